"""Weighted draws of what was learned from data: the effects that hold together, their parameters, and how likely.

A posterior is kept as its draws, so that nothing between a diagnosis and a plan reduces it to moments. A trial draws
the number of one of them, from one normal: all its columns are then of that draw, and joint. They are in a file beside
the extended mission, with what was seen of levels, and where and when.
"""

import hashlib
import io
import json
import math
import zipfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.levels import Seen
from missionplan.montecarlo.normal_transform import NormalTransform

Causes = tuple[str, ...]
Column = tuple[str, str]
"""Effect and parameter; of what belongs to no effect, an empty name and the quantity."""
Place = tuple[float, float, float]
"""Latitude, longitude [rad] and date [s since 1970]; nan where they are not known."""
NOWHERE: Place = (math.nan, math.nan, math.nan)


@dataclass(frozen=True, eq=False)
class DrawnColumn(NormalTransform):
    """One parameter of a posterior, as a distribution: a draw is picked by one normal, the same for all columns."""

    values: Array
    """Shape (n,)."""
    ends: Array
    """Shape (n,). Cumulative weights; the last is 1."""
    typical: float
    """What stands for it in a mission at its means: of an angle, and of a set of effects, there is no mean."""

    @property
    def mean(self) -> float:
        """What stands for it in a mission at its means."""
        return self.typical

    @property
    def weights(self) -> Array:
        """Of the draws."""
        return np.diff(self.ends, prepend=0.0)

    @property
    def sd(self) -> float:
        """Standard deviation of the draws about their mean."""
        centre = float(self.weights @ self.values)
        return math.sqrt(float(self.weights @ (self.values - centre) ** 2))

    @override
    def from_normal(self, z: Array) -> Array:
        places = np.searchsorted(self.ends, scipy.special.ndtr(z), side="right")
        return np.asarray(self.values[np.minimum(places, len(self.values) - 1)])

    @override
    def cdf(self, value: float) -> float:
        return float(self.weights[self.values <= value].sum())

    @override
    def quantile(self, probability: float) -> float:
        order = np.argsort(self.values)
        place = int(np.searchsorted(np.cumsum(self.weights[order]), probability))
        return float(self.values[order[min(place, len(order) - 1)]])


@dataclass(frozen=True, eq=False)
class Tied(NormalTransform):
    """A quantity that keeps its own distribution, and has the ranks of a posterior's column: the two are then joint."""

    own: NormalTransform
    """Its distribution."""
    scores: DrawnColumn
    """Normals by the ranks of the column."""

    @override
    def from_normal(self, z: Array) -> Array:
        return self.own.from_normal(self.scores.from_normal(z))

    @override
    def cdf(self, value: float) -> float:
        return self.own.cdf(value)


@dataclass(frozen=True, eq=False)
class WeightedDraws:
    """Draws of a posterior over sets of effects and their parameters, n of them."""

    sets: tuple[Causes, ...]
    """The effects that hold together, by the number of the set."""
    which: NDArray[np.int_]
    """Set of each draw, in ascending order, shape (n,)."""
    columns: tuple[Column, ...]
    """Length k."""
    values: Array
    """Shape (n, k). In SI; nan where the effect of the column does not hold."""
    weights: Array
    """Their sum is 1, shape (n,)."""

    @property
    def effects(self) -> Causes:
        """Every effect of a set."""
        return tuple(dict.fromkeys(effect for causes in self.sets for effect in causes))

    @cached_property
    def probabilities(self) -> tuple[float, ...]:
        """Of each set."""
        return tuple(np.bincount(self.which, self.weights, len(self.sets)).tolist())

    def probability(self, effect: str) -> float:
        """Probability that an effect holds."""
        return sum(p for causes, p in zip(self.sets, self.probabilities, strict=True) if effect in causes)

    def of_set(self, number: int) -> "WeightedDraws":
        """Return the draws of one set alone."""
        rows = self.which == number
        weights = self.weights[rows]
        which = np.zeros(len(weights), dtype=int)
        return WeightedDraws((self.sets[number],), which, self.columns, self.values[rows], weights / weights.sum())

    def without(self, effects: Collection[str]) -> "WeightedDraws":
        """Return the draws without some effects: sets that differ in nothing else are one."""
        kept = [tuple(effect for effect in causes if effect not in effects) for causes in self.sets]
        sets = tuple(dict.fromkeys(kept))
        which = np.array([sets.index(causes) for causes in kept])[self.which]
        order = np.argsort(which, kind="stable")
        columns = [index for index, (effect, _) in enumerate(self.columns) if effect not in effects]
        return WeightedDraws(
            sets,
            which[order],
            tuple(self.columns[index] for index in columns),
            self.values[order][:, columns],
            self.weights[order],
        )

    def column(self, column: Column) -> tuple[Array, Array]:
        """Values of a column where it is known, and their weights, not normalised."""
        values = self.values[:, self.columns.index(column)]
        is_known = np.isfinite(values)
        return values[is_known], self.weights[is_known]

    def distribution(self, column: Column, typical: float) -> DrawnColumn:
        """Return a column as a distribution; a draw without its effect has some value of another draw."""
        values = self.values[:, self.columns.index(column)].astype(float)
        rows = np.flatnonzero(np.isfinite(values))
        unknown = np.flatnonzero(~np.isfinite(values))
        values[unknown] = values[rows[np.arange(len(unknown)) % len(rows)]]
        ends = np.cumsum(self.weights)
        return DrawnColumn(values, ends / ends[-1], typical)

    def scores(self, column: Column) -> DrawnColumn:
        """Return a column as the normals by its ranks."""
        values = self.values[:, self.columns.index(column)]
        order = np.argsort(values)
        before = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        normals = np.empty(len(values))
        normals[order] = scipy.special.ndtri(before)
        ends = np.cumsum(self.weights)
        return DrawnColumn(normals, ends / ends[-1], 0.0)


FILE, FORMAT, _ONE_PLACE = "posterior.npz", 3, 2
"""Name of the file beside the mission that names it, its form, and the one before, with the middle of the data."""
MOST_BYTES, MOST_UNPACKED = 8_000_000, 64_000_000
"""Of the file, and of each of its members unpacked."""
MOST_DRAWS, MOST_COLUMNS, MOST_SETS, MOST_SEEN, MOST_PLACES = 50_000, 200, 500, 20_000, 64
_MEMBERS: Mapping[str, tuple[str, int]] = {
    "format": ("i", 0),
    "effects": ("U", 1),
    "sets": ("b", 2),
    "which": ("i", 1),
    "columns": ("U", 2),
    "values": ("f", 2),
    "weights": ("f", 1),
    "learned_from": ("U", 0),
    "epoch": ("f", 0),
    "place": ("f", 2),
    "seen_of": ("U", 2),
    "seen": ("f", 2),
    "summary": ("U", 0),
}
"""Kind and number of dimensions of each array of the file."""


class DamagedPosteriorError(ValueError):
    """A file that holds no posterior: says what is wrong."""


class PosteriorFile(Mapping[str, object]):
    """A posterior as a mission's data hold it: what the mission file says of it, with the draws themselves.

    Made of a file's content; raises DamagedPosteriorError when it is none.
    """

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.draws, self.learned_from, self.epoch, self.places, self.seen, summary = _read(content)
        self.section: Mapping[str, object] = {"file": FILE, "sha256": sha256(content), "summary": summary}

    @classmethod
    def of(
        cls,
        draws: WeightedDraws,
        learned_from: str,
        summary: Mapping[str, object],
        epoch: float = math.nan,
        places: Sequence[Place] = (NOWHERE,),
        seen: Sequence[Seen] = (),
    ) -> "PosteriorFile":
        """Write draws, with the hash of what they were learned from and a summary for the reader.

        `epoch`: date from which phases count [s since 1970]. `places`: all over the data. `seen`: what each record has
        told of the levels of the vehicle's parameters.
        """
        effects = draws.effects
        membership = np.array([[effect in causes for effect in effects] for causes in draws.sets], dtype=bool)
        written = io.BytesIO()
        np.savez_compressed(
            written,
            format=np.array(FORMAT),
            effects=np.array(effects, dtype=str),
            sets=membership.reshape(len(draws.sets), len(effects)),
            which=draws.which.astype(np.int32),
            columns=np.array(draws.columns, dtype=str).reshape(-1, 2),
            values=draws.values.astype(np.float32),
            weights=draws.weights.astype(np.float64),
            learned_from=np.array(learned_from),
            epoch=np.array(epoch),
            place=np.array(places, dtype=float),
            seen_of=np.array([(*level.of, level.record) for level in seen], dtype=str).reshape(-1, 4),
            seen=np.array([(level.date, level.value, level.sd) for level in seen], dtype=float).reshape(-1, 3),
            summary=np.array(json.dumps(summary, ensure_ascii=False)),
        )
        return cls(written.getvalue())

    def __getitem__(self, key: str) -> object:
        return self.section[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.section)

    def __len__(self) -> int:
        return len(self.section)

    def __deepcopy__(self, memo: object) -> "PosteriorFile":
        return self  # nothing in it changes

    def __reduce__(self) -> tuple[type["PosteriorFile"], tuple[bytes]]:
        return type(self), (self.content,)


def sha256(content: bytes) -> str:
    """Hash of a file's content."""
    return hashlib.sha256(content).hexdigest()


def _read(
    content: bytes,
) -> tuple[WeightedDraws, str, float, tuple[Place, ...], tuple[Seen, ...], Mapping[str, object]]:
    """Read draws, the hash of what they were learned from, the date of phases, the places, levels, and the summary."""
    arrays = _arrays(content)
    if int(arrays["format"]) not in (_ONE_PLACE, FORMAT):
        raise DamagedPosteriorError(f"has format {int(arrays['format'])}, expected {FORMAT}")
    try:
        summary = json.loads(str(arrays["summary"]))
    except (ValueError, RecursionError):
        raise DamagedPosteriorError("holds no summary") from None
    effects, membership = arrays["effects"].tolist(), arrays["sets"]
    n, k = arrays["values"].shape
    shapes = len(arrays["which"]) == len(arrays["weights"]) == n > 0 and arrays["columns"].shape == (k, 2)
    if not shapes or membership.shape[1] != len(effects) or not isinstance(summary, dict):
        raise DamagedPosteriorError("holds arrays of unlike lengths")
    if n > MOST_DRAWS or k > MOST_COLUMNS or not 0 < len(membership) <= MOST_SETS:
        raise DamagedPosteriorError(f"holds {n} draws of {len(membership)} sets, too many to be one of diagnose")
    sets = tuple(tuple(name for name, is_member in zip(effects, row, strict=True) if is_member) for row in membership)
    draws = WeightedDraws(
        sets,
        arrays["which"].astype(int),
        tuple((str(effect), str(name)) for effect, name in arrays["columns"].tolist()),
        arrays["values"].astype(float),
        arrays["weights"].astype(float),
    )
    _check(draws)
    places, seen = _places(arrays["place"]), _seen(arrays["seen_of"], arrays["seen"])
    return draws, str(arrays["learned_from"]), float(arrays["epoch"]), places, seen, summary


def _places(rows: NDArray[np.generic]) -> tuple[Place, ...]:
    if rows.shape[1:] != (3,) or not 0 < len(rows) <= MOST_PLACES:
        raise DamagedPosteriorError("is damaged: it names no place")
    return tuple((north, east, date) for north, east, date in rows.astype(float).tolist())


def _seen(of: NDArray[np.generic], rows: NDArray[np.generic]) -> tuple[Seen, ...]:
    """Read what records have told of levels."""
    if of.shape != (len(rows), 4) or rows.shape[1] != 3 or len(rows) > MOST_SEEN:
        raise DamagedPosteriorError("is damaged: what it has seen of levels is not what diagnose writes")
    numbers = rows.astype(float)
    if not np.all(np.isfinite(numbers[:, 1:])) or np.any(numbers[:, 2] <= 0.0):
        raise DamagedPosteriorError("is damaged: it has seen levels that are no numbers")
    return tuple(
        Seen((str(effect), str(name), str(kind)), str(record), *values)
        for (effect, name, kind, record), values in zip(of.tolist(), numbers.tolist(), strict=True)
    )


def _arrays(content: bytes) -> dict[str, NDArray[np.generic]]:
    if len(content) > MOST_BYTES:
        raise DamagedPosteriorError(f"has {len(content)} bytes, expected at most {MOST_BYTES}")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            sizes = {entry.filename.removesuffix(".npy"): entry.file_size for entry in packed.infolist()}
        if set(sizes) != set(_MEMBERS) or max(sizes.values()) > MOST_UNPACKED:
            raise DamagedPosteriorError("does not hold what diagnose writes")
        with np.load(io.BytesIO(content), allow_pickle=False) as loaded:
            arrays = {name: loaded[name] for name in _MEMBERS}
        if np.array_equal(arrays["format"], _ONE_PLACE):
            arrays["place"] = arrays["place"].reshape(1, -1)
    except DamagedPosteriorError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise what they like on damaged bytes
        raise DamagedPosteriorError("is damaged: cannot be read") from error
    for name, (kind, dimensions) in _MEMBERS.items():
        if arrays[name].dtype.kind != kind or arrays[name].ndim != dimensions:
            raise DamagedPosteriorError(f"is damaged: {name} is not what diagnose writes")
    return arrays


def _check(draws: WeightedDraws) -> None:
    """Refuse draws that are no distribution."""
    if draws.which.min() < 0 or draws.which.max() >= len(draws.sets) or np.any(np.diff(draws.which) < 0):
        raise DamagedPosteriorError("is damaged: its draws are of no set")
    if len(np.unique(draws.which)) < len(draws.sets) or len(set(draws.columns)) < len(draws.columns):
        raise DamagedPosteriorError("is damaged: a set has no draws, or a column is there twice")
    if not np.all(draws.weights > 0.0) or not math.isclose(float(draws.weights.sum()), 1.0, abs_tol=1e-6):
        raise DamagedPosteriorError("is damaged: its weights are no probabilities")
    for index, (effect, name) in enumerate(draws.columns):
        holds = np.array([not effect or effect in causes for causes in draws.sets])[draws.which]
        if not np.array_equal(np.isfinite(draws.values[:, index]), holds):
            raise DamagedPosteriorError(f"is damaged: {effect}.{name} has values that are no numbers")
