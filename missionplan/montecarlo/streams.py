"""Named random streams: a draw depends on the seed, the quantity's name and the block of trials, on nothing else."""

import hashlib
from functools import partial

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLOCK = 4096
"""Trials in a block. Whole blocks are drawn even when fewer trials are used, so that raising the number keeps bits."""


def stream(seed: int, quantity: str, block: int) -> np.random.Generator:
    """Open the random stream of one quantity in one block of trials.

    The name and the block enter the spawn key of the seed sequence (the name as its SHA-256), so that streams are
    independent of each other and of the order in which they are opened.

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
    name = np.frombuffer(hashlib.sha256(quantity.encode()).digest(), dtype="<u4")
    key = (*(int(word) for word in name), block)
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=key)))


def block_count(trials: int) -> int:
    """Blocks that hold `trials` trials, the last one perhaps in part."""
    return -(-trials // BLOCK)


def block_size(trials: int, block: int) -> int:
    """Trials in use in a block when the run has `trials` in all."""
    return max(0, min(BLOCK, trials - block * BLOCK))


class LegNormals:
    """Standard normals of a quantity that is drawn anew each leg, drawn when first asked for, then kept.

    Keeping them lets one block of draws serve every maximum leg length and every sigma of a sweep.
    """

    def __init__(self, seed: int, quantity: str, block: int) -> None:
        self._open = partial(stream, seed, quantity, block)
        self._stream: np.random.Generator | None = None  # opened when first asked for: many are not
        self._legs: list[Array] = []

    def leg(self, number: int) -> Array:
        """Give the normals of a leg, from 0: read-only, shape (2, BLOCK)."""
        if self._stream is None:
            self._stream = self._open()
        while len(self._legs) <= number:
            drawn = self._stream.standard_normal((2, BLOCK))
            drawn.flags.writeable = False
            self._legs.append(drawn)
        return self._legs[number]
