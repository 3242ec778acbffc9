"""The descent phase linearised: sensitivities to all causes, with their priors, and to what differs from dive to dive.

To first order about a point, as in an extended Kalman filter (Jazwinski 1970, *Stochastic Processes and Filtering
Theory*, section 8.3), with a second-order term where the vehicle starts with a jerk.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of, is_approximate
from missionplan.diagnosis.dives.forward import (
    DRAG_EFFECT,
    LARGEST_RELEASE_DELAY,
    RELEASE_EFFECT,
    DescentForward,
    Histories,
)
from missionplan.diagnosis.dives.noise import (
    DIVE_SD,
    NOMINAL_NOISE,
    dive_to_dive_covariance,
    sensor_and_turbulence_covariance,
)
from missionplan.diagnosis.given import GivenEffect, coordinate_prior, held, places_in
from missionplan.diagnosis.inference.gauss_newton import perturbed
from missionplan.diagnosis.inference.prior import Prior
from missionplan.effects import effects_of, named_effects
from missionplan.results.learned.evidence import Causes

DIFFERENCE = 0.01
"""Step of the forward differences along coordinates, in prior standard deviations."""
WEIGHT_STEP, DRAG_STEP, DELAY_STEP = 0.01, 0.01, 0.005
"""Steps of the differences along wet weight and drag, of themselves, and along a release delay [s]."""
CURVATURE_STEP = 0.1
"""Step of the second differences along the release delay [s]: its standard deviation from dive to dive."""
DELAY_ITERATIONS = 2
"""Gauss–Newton steps towards each dive's most likely release delay."""
FIXED_SETTINGS = 6
"""Settings of a linearisation before those of its forward differences."""


@dataclass(frozen=True)
class DiveLinearisation:
    """The model linearised about a set's best coordinates."""

    at: Array
    """Coordinates, shape (k,)."""
    centre: Array
    """Prior means of the coordinates, shape (k,)."""
    release_delays: Array
    """Most likely delay of each dive's release (the separation of vehicle and anchor) on its log's clock, about which
    the readings are linearised, shape (d,) [s]."""
    y: Array
    """Data less the model there, plus columns times the distance of `at` from the prior means, plus sensitivities times
    `release_delays`, shape (N,) [m]."""
    columns: Array
    """Shape (N, k). Sensitivities to all coordinates; zero for shape parameters of effects that are neither causes nor
    the mission's own, and for all of such effects without a name."""
    sensitivities: Array
    """To what differs from dive to dive, in the order of `DIVE_SD`, shape (N, 4)."""
    readings: Array
    """The model there, shape (N,) [m]."""
    curvature: Array
    """Second-order term of the release delay's scatter: large where the line goes taut with a jerk, shape (N,) [m]."""
    shaped: Array
    """Part of the readings that is due to the causes whose form is approximate, shape (N,) [m]."""

    def sensitivity(self, name: str) -> Array:
        """Sensitivity of the readings to one of the things that differ from dive to dive, shape (N,)."""
        return self.sensitivities[:, list(DIVE_SD).index(name)]


@dataclass(frozen=True)
class LinearisedDescent:
    """Base model of a mission's descent, bound to d dive logs and linearised, with every cause of the catalogue.

    The k coordinates of all causes have spike-and-slab priors.
    """

    forward: DescentForward
    """The descent phase, bound to the dives."""
    given: tuple[GivenEffect, ...] = ()
    """The mission's own effects, whose parameters are fitted under what the mission knows of them."""

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue on a descent, those without a name where these dives differ in what they follow."""
        return (*(info.id for info in named_effects("descent")), *self.unnamed)

    @cached_property
    def unnamed(self) -> Mapping[str, tuple[str, str]]:
        """Effects without a name: what each follows, and in words."""
        differs = {"depth", "speed", "time"}
        if len({log.line_length for log in self.forward.logs}) > 1:
            differs.add("line")
        return {info.id: (info.follows, info.what) for info in effects_of("descent") if info.follows in differs}

    @cached_property
    def y(self) -> Array:
        """Readings of all dives, one dive after the other, shape (N,) [m]."""
        return np.concatenate([log.depth for log in self.forward.logs])

    @cached_property
    def parts(self) -> tuple[NDArray[np.int_], ...]:
        """Rows of each dive."""
        lengths = [len(log.t) for log in self.forward.logs]
        return tuple(np.split(np.arange(sum(lengths)), np.cumsum(lengths)[:-1]))

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes."""
        return tuple(c for info in effects_of("descent") for c in coordinates_of(info))

    @cached_property
    def centre(self) -> Array:
        """Prior means of the coordinates of effects that the mission does not have, shape (k,)."""
        return np.array([coordinate.centre for coordinate in self.coordinates])

    @cached_property
    def slab(self) -> Array:
        """Prior standard deviations of the coordinates as causes, shape (k,)."""
        return np.array([coordinate.slab for coordinate in self.coordinates])

    @cached_property
    def expected(self) -> Array:
        """Coordinates that the mission expects: those of its own effects, the centres of the others, shape (k,)."""
        return self.prior(()).centre

    def prior(self, causes: Causes) -> Prior:
        """Prior of the coordinates."""
        return coordinate_prior(self.coordinates, causes, self.given)

    def nuisance_sd(self, causes: Causes) -> Array:
        """Prior standard deviations of all coordinates but those that are searched, which have 0, shape (k,)."""
        sd = self.prior(causes).sd
        sd[self.searched(causes)] = 0.0
        return sd

    def free(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes."""
        return np.flatnonzero([coordinate.effect in causes for coordinate in self.coordinates])

    def searched(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes and of the mission's own effects, about whose best values a fit is linearised."""
        indices = [i for prior in held(self.given, causes) for i in places_in(self.coordinates, prior)]
        return np.union1d(self.free(causes), np.array(indices, dtype=int))

    def index(self, effect: str) -> int:
        """First coordinate of an effect."""
        return [coordinate.effect for coordinate in self.coordinates].index(effect)

    @cached_property
    def base(self) -> DiveLinearisation:
        """The base model, linearised as the mission expects it."""
        return self.linearise([((), self.expected)])[0]

    def linearise(self, wanted: Sequence[tuple[Causes, Array]]) -> list[DiveLinearisation]:
        """Linearise about several points, each a set of causes with coordinates, in one call of the phase.

        Along all strengths, the shape parameters of the causes and of the mission's own effects, and what differs from
        dive to dive.
        """
        varied = [self._varied(causes) for causes, _ in wanted]
        blocks = [self._settings(at, indices) for (_, at), indices in zip(wanted, varied, strict=True)]
        widths = np.array([block.shape[1] for block in blocks])
        starts = np.cumsum(widths) - widths
        factors = np.ones(int(widths.sum()))
        factors[starts + 1], factors[starts + 2] = 1.0 + WEIGHT_STEP, 1.0 - WEIGHT_STEP
        histories = self.forward.histories(self.coordinates, np.concatenate(blocks, axis=1), factors)
        delays = self.most_likely_release_delays(histories.subset(starts))
        readings = np.split(histories.readings(np.repeat(delays, widths, axis=0)), starts[1:], axis=1)
        return [
            self._linearisation(causes, at, indices, delay, block)
            for (causes, at), indices, delay, block in zip(wanted, varied, delays, readings, strict=True)
        ]

    def _varied(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates with a column: the strengths of effects with a name, and all of causes and the mission's own."""
        present = {*causes, *(prior.effect for prior in held(self.given, causes))}
        return np.flatnonzero(
            [c.effect in present or (c.kind != "shape" and c.effect not in self.unnamed) for c in self.coordinates]
        )

    def _settings(self, at: Array, varied: NDArray[np.int_]) -> Array:
        """Settings of one linearisation.

        Here, heavier, lighter, later, earlier, without effects of approximate form; then one a coordinate for the
        forward differences.
        """
        shifted = np.repeat(at[:, None], 2, axis=1)
        shifted[self.index(RELEASE_EFFECT)] += np.array([CURVATURE_STEP, -CURVATURE_STEP])
        here = np.repeat(at[:, None], 3, axis=1)
        ahead = perturbed(at, varied, DIFFERENCE * self.slab[varied])
        return np.concatenate([here, shifted, self._without_approximate(at)[:, None], ahead], axis=1)

    def _without_approximate(self, at: Array) -> Array:
        """Coordinates without the effects whose form is approximate, shape (k,)."""
        return np.where([is_approximate(c.effect) for c in self.coordinates], self.centre, at)

    def _linearisation(
        self, causes: Causes, at: Array, varied: NDArray[np.int_], delays: Array, readings: Array
    ) -> DiveLinearisation:
        """Linearisation from the readings under its settings, in the order of `_settings`."""
        here, heavier, lighter, later, earlier, shapeless = readings[:, :FIXED_SETTINGS].T
        columns = np.zeros((len(self.y), len(self.coordinates)))
        columns[:, varied] = (readings[:, FIXED_SETTINGS:] - here[:, None]) / (DIFFERENCE * self.slab[varied])
        centre = self.prior(causes).centre
        weight = (heavier - lighter) / (2.0 * WEIGHT_STEP)
        release = columns[:, self.index(RELEASE_EFFECT)]
        drag = columns[:, self.index(DRAG_EFFECT)] * self._drag_factor(at)
        y = self.y - here + columns @ (at - centre)
        return DiveLinearisation(
            at=at,
            centre=centre,
            release_delays=delays,
            y=y + release * np.repeat(delays, [len(rows) for rows in self.parts]),
            columns=columns,
            sensitivities=np.stack([release, np.ones_like(here), drag, weight], axis=1),
            readings=here,
            curvature=0.5 * np.abs(later + earlier - 2.0 * here) * DIVE_SD["release"] / CURVATURE_STEP,
            shaped=here - shapeless,
        )

    def _drag_factor(self, at: Array) -> float:
        """Factor on the base model's drag by the effect in which dives scatter: the scatter is relative to the drag."""
        return 1.0 + float(at[self.index(DRAG_EFFECT)])

    def release_delay_shift(self, linear: DiveLinearisation) -> Array:
        """Effect on the readings of the release delays about which they are linearised, shape (N,) [m]."""
        counts = [len(rows) for rows in self.parts]
        return linear.sensitivity("release") * np.repeat(linear.release_delays, counts)

    def most_likely_release_delays(self, histories: Histories) -> Array:
        """Most likely release delay of each dive under b settings, given what else differs between dives, (b, d) [s].

        Where the vehicle starts with a jerk its readings are linear in the delay over a few hundredths of a second
        only, less than the scatter of delays: hence a linearisation about each dive's own, by Gauss–Newton steps.
        """
        delays: Array = np.zeros((histories.settings, len(self.parts)))
        for _ in range(DELAY_ITERATIONS):
            readings, later = histories.readings(delays), histories.readings(delays + DELAY_STEP)
            residuals, columns = self.y[:, None] - readings, (later - readings) / DELAY_STEP
            steps = []
            for covariance, rows, starts in zip(self._covariances_at_known_delay, self.parts, delays.T, strict=True):
                precision, modes = np.linalg.inv(covariance), []
                pairs = (np.ascontiguousarray(values[rows].T) for values in (columns, residuals))
                for column, residual, delay in zip(*pairs, starts, strict=True):  # one by one: the same bits always
                    weights = precision @ column
                    modes.append(weights @ (residual + delay * column) / (weights @ column + DIVE_SD["release"] ** -2))
                steps.append(np.clip(modes, -LARGEST_RELEASE_DELAY, LARGEST_RELEASE_DELAY))
            delays = np.array(steps).T
        return delays

    @cached_property
    def _covariances_at_known_delay(self) -> list[Array]:
        """Covariance of each dive's readings at nominal noise, its delay known; sensitivities of the base model."""
        settings = np.repeat(self.expected[:, None], 3, axis=1)
        settings[self.index(DRAG_EFFECT), 1] += DRAG_STEP * self._drag_factor(self.expected)
        factors = np.array([1.0, 1.0, 1.0 + WEIGHT_STEP])
        readings = self.forward.histories(self.coordinates, settings, factors).readings()
        drag, weight = ((readings[:, 1:] - readings[:, :1]) / [DRAG_STEP, WEIGHT_STEP]).T
        sensitivities = np.stack([np.zeros_like(drag), np.ones_like(drag), drag, weight], axis=1)
        return [
            (
                sensor_and_turbulence_covariance(log.t, log.sd, [NOMINAL_NOISE])
                + dive_to_dive_covariance(sensitivities[rows], np.zeros(len(rows)), [NOMINAL_NOISE])
            )[0]
            for log, rows in zip(self.forward.logs, self.parts, strict=True)
        ]
