"""Sections of a mission file, in SI once validated: here their base, the errors of validators, the type of moments.

Read next `quantity_parser`, then `phases`, `site` and `vehicle`.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, PrivateAttr
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import no_info_plain_validator_function
from typing_extensions import Doc, TypeVar

from missionplan.errors import KeyPath, LocalProblem, shown
from missionplan.moments import EXAMPLE, moment_of
from missionplan.montecarlo.distributions import Quantity

V = TypeVar("V", covariant=True, default=Quantity)
"""What the quantities of a section are: as the file has them numbers or distributions; drawn, numbers or arrays."""


class FileSection(BaseModel):
    """A mapping of a mission file: frozen, and unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, arbitrary_types_allowed=True)

    def __class_getitem__(cls, _: object) -> type[Self]:
        """Return the class itself: what its quantities are is told to the type checker alone."""
        return cls


class PhaseSection(FileSection):
    """A phase. Its `name` stands for it in key paths: as the file has it, or counted (`quantity_paths.phase_keys`)."""

    name: str

    _label: str | None = PrivateAttr(default=None)

    @property
    def label(self) -> str:
        """Its name as the file has it, for people to read."""
        return self.name if self._label is None else self._label

    def keyed(self, key: str) -> Self:
        """Return the phase with another name in key paths."""
        if key == self.name:
            return self
        keyed = self.model_copy(update={"name": key})
        keyed._label = self.label
        return keyed


@dataclass(frozen=True)
class ReadBy:
    """Annotation of a field whose value a function makes of what the file says.

    Like pydantic's `PlainValidator`, which also builds a schema of the result that nothing here needs: of every
    distribution, for every quantity, a quarter of the time in which the mission's schema is imported.
    """

    read: Callable[[object], object]
    """From the file's value to the field's; raises `PydanticCustomError`."""

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        """Return pydantic's schema of the field."""
        return no_info_plain_validator_function(self.read)


def _read_identity(value: object) -> str:
    if isinstance(value, str) and IDENTITY.fullmatch(value):
        return value
    raise invalid(f"given {shown(value)}, expected a hash written by diagnose: 16 or 32 hexadecimal digits, in quotes")


def _read_schema(kind: str, value: object) -> str:
    latest = SCHEMAS[kind]
    match = re.fullmatch(rf"missionplan/{kind}/([1-9][0-9]*)", value) if isinstance(value, str) else None
    if match is None:
        raise invalid(f"given {shown(value)}, expected missionplan/{kind}/{latest}")
    if int(match[1]) > latest:
        raise invalid(f"given {shown(value)}, of a newer missionplan; this one reads up to missionplan/{kind}/{latest}")
    return match[0]


SCHEMAS = {"mission": 1, "vehicle": 1, "dataset": 1}
"""Newest form of each kind of file that is read; a file that does not say is of the first."""
_SCHEMA = Doc("form of the file; without it the first")
MissionSchema = Annotated[str, ReadBy(partial(_read_schema, "mission")), _SCHEMA]
VehicleSchema = Annotated[str, ReadBy(partial(_read_schema, "vehicle")), _SCHEMA]
DatasetSchema = Annotated[str, ReadBy(partial(_read_schema, "dataset")), _SCHEMA]
IDENTITY = re.compile(r"(?:[0-9a-f]{16}){1,2}")
Identity = Annotated[str, ReadBy(_read_identity)]
"""Hash of a leg, dive or run; see `datasets.records`."""


def invalid(message: str, below: KeyPath = ()) -> PydanticCustomError:
    """Return the error of a section, or of a key below it."""
    return all_invalid([LocalProblem(below, message)])


def all_invalid(problems: Sequence[LocalProblem]) -> PydanticCustomError:
    """Return the error of a section with several problems; `validation_errors` takes them from its context."""
    return PydanticCustomError("section", "{words}", {"words": problems[0].message, "problems": list(problems)})


def read_moment(value: object) -> datetime:
    """Read a moment as a pydantic validator does."""
    try:
        return moment_of(value)
    except (ValueError, OverflowError) as error:
        words = str(error) if "expected" in str(error) else f"{error}; expected a date and time such as {EXAMPLE}"
        raise invalid(f"given {shown(value)}: {words}") from None


Moment = Annotated[datetime, ReadBy(read_moment)]
"""Read by `missionplan.moments.moment_of`."""
