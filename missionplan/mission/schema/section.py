"""Base of every section of a mission file."""

from pydantic import BaseModel, ConfigDict
from pydantic_core import PydanticCustomError


class FileSection(BaseModel):
    """A mapping of a mission file: frozen, and unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, arbitrary_types_allowed=True)


def complain(message: str, below: tuple[str | int, ...] = ()) -> PydanticCustomError:
    """Error of a section, or of a key below it, in words."""
    return PydanticCustomError("section", "{words}", {"words": message, "problems": [(below, message)]})
