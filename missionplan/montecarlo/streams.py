"""Named random streams: a draw depends on the seed, the quantity's name and the block of trials, on nothing else.

Streams that several missions run on in turn, one after the other: common random numbers, drawn once for all. Draws of
a mission's named quantities, with correlations.
"""

import hashlib
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import chain
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Normals
from missionplan.errors import InputError, LocalProblem, Problem, did_you_mean, key_path
from missionplan.montecarlo.distributions import Distribution, Quantity
from missionplan.montecarlo.normal_transform import NormalTransform

BLOCK = 4096
"""Trials in a block. Whole blocks are drawn even when fewer trials are used: draws do not depend on their number."""


def stream(seed: int, quantity: str, block: int) -> np.random.Generator:
    """Open the random stream of one quantity in one block of trials.

    The name (as its SHA-256) and the block are the spawn key of the seed sequence, so that streams are independent of
    each other and of the order in which they are opened. `SeedSequence(seed, spawn_key=…)` would convert each word of
    the key to an array, slowly: it is given the array of all words at once, with the same result. Raises ValueError
    when the seed or the block is negative.

    Parameters
    ----------
    seed : int
        The run's seed, not negative.
    quantity : str
        The quantity's key path in the mission, phases by name, such as ``ingress.velocity_error``.
    block : int
        Number of the block, from 0.
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


class NormalSource(Protocol):
    """Where a block of trials has its standard normals from, by the name of the quantity."""

    def once(self, quantity: str) -> Array:
        """Normals of a quantity that is drawn once a trial, shape (at least n,)."""
        ...

    def legs(self, quantity: str) -> Normals:
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
        return sum(normals.drawn for normals in self._legs.values())

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


class CommonStreams:
    """The streams of a run's blocks, kept in this process and thread up to `MOST_KEPT` legs; pickled without them."""

    def __init__(self, seed: int) -> None:
        self._seed, self._kept = seed, threading.local()

    def __reduce__(self) -> tuple[type["CommonStreams"], tuple[int]]:
        return CommonStreams, (self._seed,)

    def of_block(self, block: int) -> NormalSource:
        """Return the streams of a block."""
        kept: dict[int, KeptStreams] = vars(self._kept).setdefault("blocks", {})  # of this thread
        if sum(streams.kept for streams in kept.values()) > MOST_KEPT:
            kept.clear()
        if block not in kept:
            kept[block] = KeptStreams(BlockStreams(self._seed, block))
        return kept[block]


LEAST_EIGENVALUE = 1e-10
"""Of a matrix of correlations that can be factored reliably."""


@dataclass(frozen=True)
class Correlation:
    """Correlation of two named quantities, between the standard normals from which both are drawn."""

    between: tuple[str, str]
    rho: float


@dataclass(frozen=True)
class JointDistribution:
    """The uncertain quantities of a mission with their correlations, to be drawn block by block."""

    marginals: Mapping[str, NormalTransform]
    """By key path."""
    correlated: Sequence[str]
    """Names of those that are correlated, in alphabetical order."""
    factor: Array
    """Cholesky factor of their correlations, shape (k, k)."""
    streams: Mapping[str, str] = field(default_factory=dict)
    """Names of the streams of those that have another one than their own."""

    @classmethod
    def of(
        cls,
        quantities: Mapping[str, Quantity],
        correlations: Sequence[Correlation],
        streams: Mapping[str, str] | None = None,
    ) -> "JointDistribution":
        """Select the distributions among the quantities; pairs without a correlation are independent.

        Raises InputError with everything that is wrong with the correlations (see `correlation_problems`).
        """
        marginals = {name: quantity for name, quantity in quantities.items() if isinstance(quantity, Distribution)}
        # names in alphabetical order, so that the order in the file does not matter
        problems = correlation_problems(quantities, correlations)
        if problems:
            raise InputError(
                [
                    Problem(problem.message, key=key_path(("correlations", *problem.path)), hint=problem.hint)
                    for problem in problems
                ]
            )
        correlated, matrix = _matrix(correlations)
        return cls(marginals, correlated, np.asarray(np.linalg.cholesky(matrix), dtype=np.float64), streams or {})

    def draw(self, seed: int, block: int, size: int = BLOCK) -> dict[str, Array]:
        """Draw each quantity once per trial.

        `seed`, `block`: see `stream`. `size`: trials in use, at most BLOCK: the first ones of a block that is always
        drawn whole.

        Returns
        -------
        dict of str to array, shape (size,)
        """
        return self.draw_from(BlockStreams(seed, block), size)

    def draw_from(self, source: NormalSource, size: int) -> dict[str, Array]:
        """Draw each quantity once per trial from a source of normals; as `draw`."""
        mixed: dict[str, Array] = {}
        if self.correlated:
            independent = np.stack([source.once(self.streams.get(name, name)) for name in self.correlated])
            # einsum, not BLAS: the bits must not depend on the number of BLAS threads
            mixed = dict(zip(self.correlated, np.einsum("ij,jt->it", self.factor, independent), strict=True))
        drawn = {}
        for name, marginal in self.marginals.items():
            normals = mixed[name] if name in mixed else source.once(self.streams.get(name, name))
            drawn[name] = marginal.from_normal(normals[:size])
        return drawn


def correlation_problems(quantities: Mapping[str, Quantity], correlations: Sequence[Correlation]) -> list[LocalProblem]:
    """List what is wrong with correlations, by key path below them.

    A quantity is unknown or not uncertain, a pair is given twice or joins a quantity to itself, a coefficient is not
    between -1 and 1, or no joint distribution has these correlations together.
    """
    uncertain = [name for name, quantity in quantities.items() if isinstance(quantity, Distribution)]
    problems = [
        problem.within((number,))
        for number, correlation in enumerate(correlations)
        for problem in _pair_problems(quantities, uncertain, correlation)
    ]
    pairs = [frozenset(correlation.between) for correlation in correlations]
    for number, pair in enumerate(pairs):
        if pair in pairs[:number]:
            problems.append(LocalProblem((number, "between"), "this pair is given twice"))
    smallest = float(np.linalg.eigvalsh(_matrix(correlations)[1])[0]) if correlations else 1.0
    if problems or smallest >= LEAST_EIGENVALUE:
        return problems
    message = f"no quantities can have these correlations together: the matrix's smallest eigenvalue is {smallest:.3g}"
    return [LocalProblem((), message, "make them smaller")]


def _matrix(correlations: Sequence[Correlation]) -> tuple[list[str], Array]:
    """Return the names in alphabetical order, and the matrix of their correlations."""
    correlated = sorted(set(chain.from_iterable(correlation.between for correlation in correlations)))
    matrix = np.eye(len(correlated))
    for correlation in correlations:
        row, column = (correlated.index(name) for name in correlation.between)
        matrix[row, column] = matrix[column, row] = correlation.rho
    return correlated, matrix


def _pair_problems(
    quantities: Mapping[str, Quantity], uncertain: Sequence[str], correlation: Correlation
) -> Iterator[LocalProblem]:
    for side, name in enumerate(correlation.between):
        hint = did_you_mean(name, uncertain)
        if name not in quantities:
            yield LocalProblem(("between", side), f"no quantity is named {name!r}", hint)
        elif name not in uncertain:
            yield LocalProblem(("between", side), f"{name} is a fixed value, expected a distribution", hint)
    if correlation.between[0] == correlation.between[1]:
        yield LocalProblem(("between",), "correlates a quantity with itself")
    if not -1.0 < correlation.rho < 1.0:
        yield LocalProblem(("rho",), f"given {correlation.rho:g}, expected between -1 and 1")
