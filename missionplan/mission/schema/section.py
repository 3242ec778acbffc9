"""Base of every section of a mission file, and the errors that its validators raise."""

from collections.abc import Sequence

from pydantic import BaseModel, ConfigDict
from pydantic_core import PydanticCustomError

from missionplan.errors import KeyPath, LocalProblem


class FileSection(BaseModel):
    """A mapping of a mission file: frozen, and unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, arbitrary_types_allowed=True)


def invalid(message: str, below: KeyPath = ()) -> PydanticCustomError:
    """Return the error of a section, or of a key below it."""
    return all_invalid([LocalProblem(below, message)])


def all_invalid(problems: Sequence[LocalProblem]) -> PydanticCustomError:
    """Return the error of a section with several problems; `validation_errors` takes them from its context."""
    return PydanticCustomError("section", "{words}", {"words": problems[0].message, "problems": list(problems)})
