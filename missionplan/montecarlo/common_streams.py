"""Streams that several missions run on in turn, one after the other: common random numbers, drawn once for all."""

import threading

from missionplan.arrays import Array
from missionplan.montecarlo.streams import BlockStreams, LegNormals, NormalSource

MOST_KEPT = 1000
"""Legs whose normals are kept, all streams together; those of a leg take 64 KiB."""


class KeptStreams:
    """The streams of one block, whose normals are kept for the next mission; see `BlockStreams`."""

    def __init__(self, streams: BlockStreams) -> None:
        self._streams = streams
        self._once: dict[str, Array] = {}
        self._legs: dict[str, LegNormals] = {}

    @property
    def kept(self) -> int:
        """Legs whose normals have been drawn."""
        return sum(each.drawn for each in self._legs.values())

    def once(self, quantity: str) -> Array:
        """Normals of a quantity that is drawn once a trial: read-only, shape (BLOCK,)."""
        if quantity not in self._once:
            self._once[quantity] = self._streams.once(quantity)
            self._once[quantity].flags.writeable = False
        return self._once[quantity]

    def legs(self, quantity: str) -> LegNormals:
        """Normals of a quantity that is drawn anew for each leg."""
        if quantity not in self._legs:
            self._legs[quantity] = self._streams.legs(quantity)
        return self._legs[quantity]


class _Kept(threading.local):
    """Streams by block, of each thread its own."""

    def __init__(self) -> None:
        self.blocks: dict[int, KeptStreams] = {}


class CommonStreams:
    """The streams of a run's blocks, kept in this process and thread up to `MOST_KEPT` legs; pickled without them."""

    def __init__(self, seed: int) -> None:
        self._seed, self._kept = seed, _Kept()

    def __reduce__(self) -> tuple[type["CommonStreams"], tuple[int]]:
        return CommonStreams, (self._seed,)

    def of_block(self, block: int) -> NormalSource:
        """Return the streams of a block."""
        kept = self._kept.blocks
        if sum(streams.kept for streams in kept.values()) > MOST_KEPT:
            kept.clear()
        if block not in kept:
            kept[block] = KeptStreams(BlockStreams(self._seed, block))
        return kept[block]
