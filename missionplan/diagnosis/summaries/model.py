"""Model of summaries of dives: the descent phase again, asked for terminal speeds and times instead of depths."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.datasets.summaries import TestSummary
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.dives import designs as dive_designs
from missionplan.diagnosis.dives.forward import DescentForward, Histories
from missionplan.diagnosis.dives.linearised import DiveLinearisation
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.phases.currents import LayeredCurrent
from missionplan.phases.mooring.descent import descend

STILL_WATER = LayeredCurrent(np.ones(1), np.zeros(1), np.zeros(1))
LOGGED_SD = 0.05
"""Noise of the depth sensor that a proposed log is reckoned with [m]."""


def as_log(test: TestSummary) -> DiveLog:
    """A test in the shape of a dive log: all of its numbers at time zero, where no turbulence has gathered."""
    zeros = np.zeros(len(test.values))
    places = np.arange(len(zeros))
    return DiveLog(
        test.name,
        zeros,
        test.values,
        test.sd,
        zeros,
        places,
        np.ones(len(zeros)),
        test.wet_weight,
        test.line_length,
        test.site_depth,
    )


@dataclass(frozen=True)
class SummaryForward(DescentForward):
    """Quantities of all tests under many settings at once, as `DescentForward` gives readings."""

    tests: tuple[TestSummary, ...] = ()

    def histories(
        self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars = 1.0
    ) -> "SummaryQuantities":
        """Quantities of all tests, less the base model's where the table prints measured less simulated."""
        relative = np.concatenate([test.relative for test in self.tests])
        found = self._quantities(coordinates, values, weight_factor)
        return SummaryQuantities(found - np.where(relative[:, None], self._plain, 0.0))

    @cached_property
    def _plain(self) -> Array:
        """Quantities of the base model, shape (N, 1)."""
        return self._quantities((), np.zeros((0, 1)), 1.0)

    def _quantities(self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars) -> Array:
        count, settings = len(self.tests), values.shape[1]
        effects = (*self.given, *self._effects(coordinates, np.repeat(values, count, axis=1)))
        factor = np.repeat(np.broadcast_to(np.asarray(weight_factor, dtype=float), settings), count)
        trials = count * settings
        depths = np.tile([test.site_depth for test in self.tests], settings)
        record = descend(
            replace(self._tiled(settings, factor), site_depth=depths),
            effects=effects,
            release_time=np.zeros(trials),
            current=STILL_WATER,
            position=np.zeros((2, trials)),
            t_start=np.zeros(trials),
            step=self.step,
        )
        by_name = {"terminal_velocity_m_s": record.terminal_velocity, "descent_time_s": record.descent_time}
        rows = [
            by_name[quantity].reshape(settings, count)[:, index]
            for index, test in enumerate(self.tests)
            for quantity in test.quantities
        ]
        return np.stack(rows)


@dataclass(frozen=True)
class SummaryQuantities:
    """Quantities of all tests under b settings, shape (N, b), where logs have the histories of their sensor."""

    values: Array

    @property
    def settings(self) -> int:
        """Number of settings, b."""
        return int(self.values.shape[1])

    def readings(self, delays: Scalars = 0.0) -> Array:
        """Return the quantities, shape (N, b); `delays` is zero, see `SummaryModel.most_likely_release_delays`."""
        return self.values

    def subset(self, settings: NDArray[np.intp]) -> "SummaryQuantities":
        """Those under some of the settings."""
        return SummaryQuantities(self.values[:, settings])


@dataclass(frozen=True)
class SummaryModel(DescentModel):
    """Base model and catalogue bound to summaries."""

    forward: SummaryForward

    def most_likely_release_delays(self, histories: Histories) -> Array:
        """Zero: the numbers of a table are linear in the lateness of a separation."""
        return np.zeros((histories.settings, len(self.parts)))

    def axes(self, linear: DiveLinearisation) -> Sequence[Axis]:
        """None: a handful of numbers has no structure to be tested."""
        return ()

    @property
    def units(self) -> Array:
        """Standard deviations of the numbers, which are speeds and times."""
        return np.concatenate([log.sd for log in self.forward.logs])

    @property
    def designs(self) -> Sequence[str]:
        """Logs of dives, in words."""
        same = "depth logged five times a second on two such dives"
        return [same, *(f"{what}, depth logged" for what, *_ in dive_designs.DESIGNS)]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Fit both sets to noise-free readings of the first on the dives of a menu entry, or to the numbers in hand."""
        if entry is None:
            return super().discrimination(first, second, None)
        plain = DescentForward(self.forward.build, self.forward.logs, self.forward.given)
        logs = dive_designs.design_dives(plain, None if entry == 0 else entry - 1)
        logs = tuple(replace(log, sd=np.full(len(log.t), LOGGED_SD)) for log in logs)
        forward = replace(plain, logs=logs)
        readings = forward.readings(self.coordinates, first.state.linear.at[:, None])[:, 0]
        return DescentModel(replace(forward, logs=dive_designs.with_depths(logs, readings))).expected_log_bayes_factor(
            first, second
        )
