"""Named random streams: a draw depends on the seed, the quantity's name and the block of trials, on nothing else.

Streams that several missions run on in turn, one after the other: common random numbers, drawn once for all.
"""

import hashlib
import threading
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

BLOCK = 4096
"""Trials in a block. Whole blocks are drawn even when fewer trials are used: draws do not depend on their number."""


def stream(seed: int, quantity: str, block: int) -> np.random.Generator:
    """Open the random stream of one quantity in one block of trials.

    The name (as its SHA-256) and the block are the spawn key of the seed sequence, so that streams are independent of
    each other and of the order in which they are opened. `SeedSequence(seed, spawn_key=…)` would convert each word of
    the key to an array, slowly: it is given the array of all words at once, with the same result.

    Parameters
    ----------
    seed : int
        The run's seed, not negative.
    quantity : str
        The quantity's key path in the mission, phases by name, such as ``ingress.velocity_error``.
    block : int
        Number of the block, from 0.

    Raises
    ------
    ValueError
        When the seed or the block is negative.
    """
    if seed < 0 or block < 0:
        raise ValueError(f"seed {seed}, block {block}: neither may be negative")
    entropy = np.concatenate((_words(seed, _POOL), _name_words(quantity), _words(block)), dtype=np.uint32)
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(entropy)))


_POOL = 4  # words to which a seed sequence pads its entropy before the spawn key


@lru_cache(maxsize=4096)
def _name_words(quantity: str) -> NDArray[np.uint32]:
    """SHA-256 of a name, as 32-bit words."""
    return np.frombuffer(hashlib.sha256(quantity.encode()).digest(), dtype="<u4")


@lru_cache(maxsize=256)
def _words(number: int, least: int = 1) -> NDArray[np.uint32]:
    """32-bit words of a number, the lowest first, padded with zeros to at least `least`."""
    count = max(least, -(-number.bit_length() // 32))
    return np.frombuffer(number.to_bytes(4 * count, "little"), dtype="<u4")


def block_count(trials: int) -> int:
    """Number of blocks for `trials` trials, of which the last may be in use in part."""
    return -(-trials // BLOCK)


def block_size(trials: int, block: int) -> int:
    """Trials in use in a block when the run has `trials` in all."""
    return max(0, min(BLOCK, trials - block * BLOCK))


def sized_blocks(trials: int) -> list[tuple[int, int]]:
    """Blocks of a run of `trials` trials, each with the trials in use."""
    return [(block, block_size(trials, block)) for block in range(block_count(trials))]


class LegNormals:
    """Standard normals of a quantity that is drawn anew for each leg: drawn on first use, then kept.

    One block of draws thus serves every maximum leg length and every sigma of a sweep.
    """

    def __init__(self, seed: int, quantity: str, block: int) -> None:
        self._open = partial(stream, seed, quantity, block)
        self._stream: np.random.Generator | None = None  # opened on first use: many never are
        self._legs: list[Array] = []

    @property
    def drawn(self) -> int:
        """Legs drawn so far."""
        return len(self._legs)

    def leg(self, number: int) -> Array:
        """Normals of a leg, from 0: read-only, shape (2, BLOCK)."""
        if self._stream is None:
            self._stream = self._open()
        while len(self._legs) <= number:
            drawn = self._stream.standard_normal((2, BLOCK))
            drawn.flags.writeable = False
            self._legs.append(drawn)
        return self._legs[number]


class LegSource(Protocol):
    """Standard normals of a quantity that is drawn anew for each leg."""

    def leg(self, number: int) -> Array:
        """Normals of a leg, from 0, shape (2, at least n)."""
        ...


class NormalSource(Protocol):
    """Where a block of trials has its standard normals from, by the name of the quantity."""

    def once(self, quantity: str) -> Array:
        """Normals of a quantity that is drawn once a trial, shape (at least n,)."""
        ...

    def legs(self, quantity: str) -> LegSource:
        """Normals of a quantity that is drawn anew for each leg."""
        ...


@dataclass(frozen=True)
class BlockStreams:
    """The streams of one block of a run: what every plain Monte Carlo draws from."""

    seed: int
    block: int

    def once(self, quantity: str) -> Array:
        """Normals of a quantity that is drawn once a trial, shape (BLOCK,)."""
        return stream(self.seed, quantity, self.block).standard_normal(BLOCK)

    def legs(self, quantity: str) -> LegNormals:
        """Normals of a quantity that is drawn anew for each leg."""
        return LegNormals(self.seed, quantity, self.block)


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
