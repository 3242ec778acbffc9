"""What an answer takes for granted, and how far it moves where that is off."""

from dataclasses import dataclass
from typing import Annotated

from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class Assumption(Record):
    """Something that a mission leaves out or states as exact, with the answer when it is off by its usual size."""

    what: Annotated[str, Entry("what is taken for granted")]
    otherwise: Annotated[str, Entry("what was put in its place")]
    worth: Annotated[float, Entry("by how much P(success) then changes")]
    success: Annotated[float, Entry("P(success) then")]
    missed: Annotated[tuple[str, ...], Entry("requirements that are met as it stands, and then no longer")] = ()

    @property
    def turns(self) -> Annotated[bool, Entry()]:
        """Whether it could turn the answer: a requirement, or a mission that works more often than not."""
        return bool(self.missed) or self.success < 0.5 <= self.success - self.worth
