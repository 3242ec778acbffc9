"""Rows of tank data as they are fitted, and their forward model: the base model of a measurement and its catalogue."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.tank import TankData
from missionplan.effects import CATALOGUE, Effect, EffectInfo, TankEffect
from missionplan.effects.info import TankKind, TankRecord
from missionplan.phases.hooks import DescentEffect
from missionplan.results.learned.evidence import Causes

Predict = Callable[[Array, Sequence[Effect]], Array]
"""From nuisance parameters, shape (q, m), and effects with parameters of shape (m,) to the data, shape (N, m)."""

UNSTATED_NOISE = 0.03
"""Initial noise of a sensor that states none, of the root mean square of the data."""

ROUNDING = 1e-8
"""Least noise of a sensor, of the root mean square of the data."""


@dataclass(frozen=True)
class Nuisance:
    """A constant of the base model that is fitted under any set of causes, with its normal prior."""

    name: str
    centre: float
    sd: float


@dataclass(frozen=True)
class TankForward:
    """A kind of tank data with its base model."""

    kind: TankKind
    """Kind of the data."""
    record: TankRecord
    """What they hold, as far as it decides which effects they could show."""
    quantity: str
    """Column that is explained."""
    y: Array
    sd: Array
    """Data and the sensor's standard deviation [SI], shape (N,)."""
    stated: bool
    """Whether that deviation was stated; else its size is fitted, from a rough guess."""
    nuisances: tuple[Nuisance, ...]
    """Fitted under any set of causes."""
    predict: Predict
    """The model of the data."""
    axes: Mapping[str, Array]
    """Axis → where each datum lies."""
    groups: NDArray[np.str_]
    """Runs, or blocks in the order of the record, for predictions of what was held out, shape (N,)."""
    starts: Mapping[tuple[str, str], tuple[float, ...]] = field(default_factory=dict)
    """Effect and parameter → coordinates from which its fit starts, where the data tell of some."""
    designs: tuple[tuple[str, "TankForward"], ...] = ()
    """Further measurements in words, and the model of each."""

    @property
    def candidates(self) -> Causes:
        """Effects that the data could show."""
        return tuple(info.id for info in effects_seen_in(self.kind) if not info.lacking_in_tank(self.record))

    @property
    def untestable(self) -> dict[str, str]:
        """Effects that data of this kind could show but these could not, and why."""
        reasons = {info.id: info.lacking_in_tank(self.record) for info in effects_seen_in(self.kind)}
        return {name: reason for name, reason in reasons.items() if reason}


def effects_seen_in(kind: TankKind) -> tuple[EffectInfo, ...]:
    """Effects of the catalogue that a kind of tank data could show."""
    return tuple(info for info in CATALOGUE.values() if kind in info.tank)


def tank_effects(effects: Sequence[Effect]) -> list[TankEffect]:
    """Those that act in a tank only."""
    return [effect for effect in effects if isinstance(effect, TankEffect)]


def descent_effects(effects: Sequence[Effect]) -> list[DescentEffect]:
    """Those that act on a descent too."""
    return [effect for effect in effects if isinstance(effect, DescentEffect)]


def product(factors: Sequence[Array | float]) -> Array | float:
    """Product of the factors; 1 of none."""
    return math.prod(factors) if factors else 1.0


def noise_sd(y: Array, stated: float | None) -> tuple[Array, bool]:
    """Standard deviation of each datum, and whether it was stated: else a guess from the size of the data.

    A stated one is at least `ROUNDING`: no model is computed better.
    """
    size = max(float(np.sqrt(np.mean(y**2))), 1e-12)
    if stated is not None:
        return np.full_like(y, max(stated, ROUNDING * size)), True
    return np.full_like(y, UNSTATED_NOISE * size), False


MAX_ROWS = 600
"""Rows that are kept of a longer record, evenly."""
BLOCKS = 8
"""Blocks into which a record is divided."""
MAX_SINGLE_ROWS = 12
"""Up to so many rows each is a block by itself."""


def decimated(data: TankData) -> TankData:
    """Return every nth row of a long record, with a note of it."""
    count = len(next(iter(data.columns.values())))
    step = -(-count // MAX_ROWS)
    if step == 1:
        return data
    note = f"{count} rows: every {step}th is used"
    return replace(
        data,
        columns={name: column[::step] for name, column in data.columns.items()},
        labels={name: column[::step] for name, column in data.labels.items()},
        notices=(*data.notices, note),
    )


def row_blocks(count: int) -> NDArray[np.str_]:
    """Name of each row's block: rows one by one where they are few, else even blocks in their order."""
    if count <= MAX_SINGLE_ROWS:
        return np.array([f"row {k + 1}" for k in range(count)])
    ends = np.linspace(0, count, BLOCKS + 1).astype(int)
    names = [f"rows {a + 1} to {b}" for a, b in itertools.pairwise(ends.tolist())]
    return np.repeat(names, np.diff(ends))
