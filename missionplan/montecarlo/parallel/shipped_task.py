"""A task as it is sent to the processes of the pool, each of which keeps it: what it has computed serves its items."""

import pickle
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar, cast

from loky.backend.reduction import dumps

Item = TypeVar("Item")
Result = TypeVar("Result")

_kept: dict[str, object] = {}  # one at most: the last task that this process was sent


@dataclass(frozen=True)
class ShippedTask(Generic[Item, Result]):
    """A task, pickled once; use `of`.

    It is pickled before this process runs items too, and changes what the task keeps.
    """

    content: bytes
    name: str

    @classmethod
    def of(cls, task: Callable[[Item], Result]) -> "ShippedTask[Item, Result]":
        """Pickle a task."""
        return cls(bytes(dumps(task)), uuid.uuid4().hex)

    def __call__(self, item: Item) -> Result:
        """Run the task on an item."""
        return self.unpacked()(item)

    def unpacked(self) -> Callable[[Item], Result]:
        """Return the task, as this process has kept it."""
        if self.name not in _kept:
            _kept.clear()
            _kept[self.name] = pickle.loads(self.content)
        return cast(Callable[[Item], Result], _kept[self.name])

    def prepare(self) -> None:
        """Import what the task needs, and keep it."""
        self.unpacked()
