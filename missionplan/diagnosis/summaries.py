"""Summaries of dives, a few numbers each, as a kind of data: the descent of `dives`, other quantities taken from it.

They are bound to the mission's first mooring at its means.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.datasets.summaries import SummaryData, TestSummary, read_summary
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.dives import designs as dive_designs
from missionplan.diagnosis.dives.forward import DescentForward, Histories
from missionplan.diagnosis.dives.kind import descent_shares
from missionplan.diagnosis.dives.linearised import DiveLinearisation
from missionplan.diagnosis.dives.model import DescentModel, descent_builder, given_on_descent, noise_free_discrimination
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.mission import Mission
from missionplan.phases.mooring.descent import descend
from missionplan.phases.mooring.forces import DescentHooks
from missionplan.results.learned.evidence import Verdict
from missionplan.scenario.scenario import STILL_WATER

LOGGED_SD = 0.05
"""Noise of the depth sensor that is assumed for a proposed log [m]."""
UNIFORM_BELOW = 100.0
"""Depth [m] below which a dive goes on at its terminal velocity, reached after some 10 m: no steps are needed."""
OFF = 3.0
"""Usual size of what no effect explains [standard deviations]."""
FINE_DOWN_TO = 30.0
"""Depth [m] down to which the steps are those of dive logs; beyond it they are up to twice as long."""
WORDS = {"terminal_velocity_m_s": ("terminal velocity", "m/s"), "descent_time_s": ("descent time", "s")}
"""Quantities in words, and their units."""


@dataclass(frozen=True)
class SummaryForward(DescentForward):
    """Quantities of all tests under many settings at once, in the place of readings of `DescentForward`."""

    tests: tuple[TestSummary, ...] = ()

    def histories(
        self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars = 1.0
    ) -> "SummaryQuantities":
        """Return quantities of all tests, less those without effects where data are measured less simulated values."""
        relative = np.concatenate([test.relative for test in self.tests])
        quantities = self._quantities(coordinates, values, weight_factor)
        return SummaryQuantities(quantities - np.where(relative[:, None], self._plain, 0.0))

    @cached_property
    def _plain(self) -> Array:
        """Quantities without effects, of which the mission may carry some by what such data showed; shape (N, 1)."""
        return self._quantities((), np.zeros((0, 1)), 1.0)

    def _quantities(self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars) -> Array:
        count, settings = len(self.tests), values.shape[1]
        effects = (*self.given, *self._effects(coordinates, np.repeat(values, count, axis=1)))
        factor = np.repeat(np.broadcast_to(np.asarray(weight_factor, dtype=float), settings), count)
        trials = count * settings
        depths = np.tile([test.site_depth for test in self.tests], settings)
        integrated = np.minimum(depths, UNIFORM_BELOW)
        step = self.step * float(np.clip(np.max(integrated) / FINE_DOWN_TO, 1.0, 2.0))
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # a start that diverges is abandoned
            record = descend(
                replace(self._tiled(settings, factor), site_depth=integrated),
                effects=effects,
                release_time=np.zeros(trials),
                current=STILL_WATER,
                position=np.zeros((2, trials)),
                t_start=np.zeros(trials),
                step=step,
            )
            over_ground = record.terminal_velocity + DescentHooks(effects).water_velocity
            rest = np.where(depths > integrated, (depths - integrated) / over_ground, 0.0)
            time = record.descent_time + rest
        by_name = {"terminal_velocity_m_s": record.terminal_velocity, "descent_time_s": time}
        rows = [
            by_name[quantity].reshape(settings, count)[:, index]
            for index, test in enumerate(self.tests)
            for quantity in test.quantities
        ]
        return np.stack(rows)


@dataclass(frozen=True)
class SummaryQuantities:
    """Quantities of all tests under b settings, shape (N, b); dive logs have histories of the sensor instead."""

    values: Array

    @property
    def settings(self) -> int:
        """Number of settings, b."""
        return int(self.values.shape[1])

    def readings(self, delays: Scalars = 0.0) -> Array:
        """Return the quantities, shape (N, b); `delays` is zero, see `SummaryModel.most_likely_release_delays`."""
        return self.values

    def subset(self, settings: NDArray[np.intp]) -> "SummaryQuantities":
        """Return those under some of the settings."""
        return SummaryQuantities(self.values[:, settings])


@dataclass(frozen=True)
class SummaryModel(DescentModel):
    """Base model and catalogue bound to summaries."""

    forward: SummaryForward

    @cached_property
    def unnamed(self) -> Mapping[str, tuple[str, str]]:
        """None: a handful of numbers does not say what an effect follows."""
        return {}

    def most_likely_release_delays(self, histories: Histories) -> Array:
        """Return zeros: the quantities are linear in the delay of a release."""
        return np.zeros((histories.settings, len(self.parts)))

    def axes(self, linear: DiveLinearisation) -> Sequence[Axis]:
        """Return none: a handful of numbers has no structure to be tested."""
        return ()

    def response_axes(self, linear: DiveLinearisation) -> Sequence[Axis]:
        """Return one along which nothing is smooth: numbers that are off each by itself."""
        words = "numbers that are off each by itself"
        return (Axis("number", words, np.zeros((1, 1)), np.diag(self.units), size=OFF),)

    def exchanged_labels(self, base: CauseFit) -> None:
        """Return none: a handful of numbers tells no exchange from an error of each."""

    @property
    def units(self) -> Array:
        """Standard deviations of the numbers, which are speeds and times."""
        return np.concatenate([log.sd for log in self.forward.logs])

    @property
    def designs(self) -> Sequence[str]:
        """Dives to be logged, in words."""
        same = "depth logged five times a second on two such dives"
        return [same, *(f"{what}, depth logged" for what, *_ in dive_designs.DESIGNS)]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Fit both sets to noise-free readings of the first on a design's dives, or to the numbers in hand."""
        if entry is None:
            return super().discrimination(first, second, None)
        plain = DescentForward(self.forward.build, self.forward.logs)
        logs = dive_designs.design_dives(plain, None if entry == 0 else entry - 1)
        logs = tuple(replace(log, sd=np.full(len(log.t), LOGGED_SD)) for log in logs)
        return noise_free_discrimination(DescentModel(replace(plain, logs=logs), self.given), first, second)


def summary_model(data: SummaryData, mission: Mission) -> SummaryModel:
    """Bind a mission's first mooring to summaries of dives.

    Raises InputError when the mission lacks what a descent needs.
    """
    logs = []
    for test in data.tests:  # numbers are readings at time zero, before any turbulence has added up
        zeros, conditions = np.zeros(len(test.values)), (test.wet_weight, test.line_length, test.site_depth)
        bins = zeros, np.arange(len(zeros)), np.ones(len(zeros))
        logs.append(DiveLog(test.name, zeros, test.values, test.sd, *bins, *conditions))
    forward = SummaryForward(descent_builder(mission), tuple(logs), tests=data.tests)
    return SummaryModel(forward, given_on_descent(mission))


@dataclass(frozen=True)
class SummaryKind(DataKind):
    """A few numbers of each dive, as papers print them."""

    kind: str
    mission: Mission
    data: SummaryData
    model: SummaryModel

    @classmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read the tests and bind the mission's first mooring to them."""
        data = unlearned(read_summary(folder, mission), mission)
        then = as_then(data, mission, data.date)
        return cls(kind, then, data, summary_model(data, then))

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a number: measured, both models', and residuals in standard deviations.

        Where a test has a simulated number too, ``measured`` is less that, and a model's is less the base model's.
        """
        model, tests = self.model, self.model.forward.tests
        places = np.stack([base.state.linear.at, best.state.linear.at], axis=1)
        quantities = model.forward.readings(model.coordinates, places)
        return pd.DataFrame(
            {
                "run": np.repeat([test.name for test in tests], [len(test.quantities) for test in tests]),
                "quantity": [quantity for test in tests for quantity in test.quantities],
                "less_simulated": [relative for test in tests for relative in test.relative],
                "measured": model.y,
                "sd": model.units,
                "base": quantities[:, 0],
                "extended": quantities[:, 1],
                "residual_base_sd": (model.y - quantities[:, 0]) / model.units,
                "residual_extended_sd": (model.y - quantities[:, 1]) / model.units,
            }
        )

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe the number that is farthest from the base model's, in standard deviations."""
        worst = residuals.iloc[int(np.argmax(np.abs(residuals["residual_base_sd"].to_numpy())))]
        words, unit = WORDS[worst["quantity"]]
        off = worst["measured"] - worst["base"]
        return (
            f"Of {len(residuals)} numbers of {residuals['run'].nunique()} tests the farthest from the simulation is "
            f"the {words} of {worst['run']}, {abs(off):.2f} {unit} {'above' if off > 0.0 else 'below'} it, "
            f"{abs(worst['residual_base_sd']):.1f} standard deviations."
        )

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared residuals, in standard deviations, that goes with each fit."""
        return descent_shares(self.model, base, fits)

    def limited_verdict(self, verdict: Verdict) -> Verdict:
        """Return at most ``ambiguous``: a few numbers, their times shifted by hand, prove no cause."""
        return "ambiguous" if verdict == "explained" else verdict
