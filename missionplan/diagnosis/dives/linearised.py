"""Dive logs and the descent phase linearised: all causes' columns, the covariance of the rest, the likelihood."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of
from missionplan.diagnosis.dives.evidence import Evidence, inner_products, integrated
from missionplan.diagnosis.dives.forward import (
    LAG_ORDER,
    LAG_ORDER_SD,
    LARGEST_RELEASE_DELAY,
    DescentForward,
    Histories,
    with_pure_delay,
)
from missionplan.diagnosis.dives.gauss_newton import jacobian_settings
from missionplan.diagnosis.dives.noise import (
    DIVE_SD,
    NOMINAL_NOISE,
    Noise,
    dive_to_dive_covariance,
    noise_grid,
    sensor_and_turbulence_covariance,
    shape_error_covariance,
)
from missionplan.diagnosis.inference.model import MINIMUM_EVIDENCE_GAIN
from missionplan.diagnosis.inference.residuals import InnerProducts
from missionplan.effects import effects_of
from missionplan.results.diagnosis import Causes

WEIGHT_STEP, DRAG_STEP, DELAY_STEP = 0.01, 0.01, 0.005
"""Steps of the differences: shares of weight and drag, and of lateness [s]."""
SHIFT = 0.1
"""Shift of the separation at which the readings' bend is taken [s]: its scatter's standard deviation."""
PURE_DELAY_SHARE = 0.5
"""Share of a sensor's lag that is made a pure delay to see what the order of its filter does."""
MINIMUM_EVIDENCE_GAIN_SHAPED = 0.05
"""Share of the evidence that a cause must add beside others with shapes of their own, which it may only mend."""
DELAY_ITERATIONS = 2
"""Gauss–Newton steps towards each dive's most likely lateness."""


@dataclass(frozen=True)
class DiveLinearisation:
    """The model linearised at a set's best coordinates.

    Attributes
    ----------
    at : array, shape (k,)
        Coordinates.
    release_delays : array, shape (d,)
        Lateness of each dive's separation about which the readings are linearised: the most likely [s].
    y : array, shape (N,)
        Data less the model there, plus columns times the distance of `at` from the priors' centres, and sensitivities
        times `release_delays`.
    columns : array, shape (N, k)
        Of all coordinates; shapes of effects that are no causes have none (zero).
    sensitivities : array, shape (N, 4)
        Of the readings to what differs from dive to dive.
    readings : array, shape (N,)
        The model there [m].
    curvature : array, shape (N,)
        What the scatter of the separation does to the readings beyond the linear: large where the line goes taut
        and the vehicle starts with a jerk [m].
    shaped : array, shape (N,)
        What the causes with a shape of their own add to the readings [m].
    order : array, shape (N,)
        What a lag of the sensor would read otherwise if its filter were higher by `LAG_ORDER_SD` in its order; all
        dives have the same sensor [m].
    """

    at: Array
    release_delays: Array
    y: Array
    columns: Array
    sensitivities: Array
    readings: Array
    curvature: Array
    shaped: Array
    order: Array

    @property
    def nuisances(self) -> Array:
        """What all dives share beside the catalogue's coordinates, bend and order of the lag, shape (N, 2) [m]."""
        return np.stack([self.curvature, self.order], axis=1)

    def sensitivity(self, name: str) -> Array:
        """Sensitivity of the readings to one of the things that differ from dive to dive, shape (N,)."""
        return self.sensitivities[:, list(DIVE_SD).index(name)]


@dataclass(frozen=True)
class LinearisedDescent:
    """Base model of a mission's descent and every cause of the catalogue, bound to dive logs and linearised."""

    forward: DescentForward

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue on a descent."""
        return tuple(info.id for info in effects_of("descent"))

    def minimum_evidence_gain(self, causes: Causes) -> float:
        """The usual, more beside causes with shapes of their own: they are caricatures."""
        shaped = any(self.coordinates[i].kind == "shape" for i in self.free(causes))
        return MINIMUM_EVIDENCE_GAIN_SHAPED if shaped else MINIMUM_EVIDENCE_GAIN

    @property
    def untestable(self) -> Mapping[str, str]:
        """Every effect can show in a dive log."""
        return {}

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes."""
        return tuple(c for info in effects_of("descent") for c in coordinates_of(info))

    @cached_property
    def y(self) -> Array:
        """Readings of all dives, one after the other, shape (N,) [m]."""
        return np.concatenate([log.depth for log in self.forward.logs])

    @cached_property
    def parts(self) -> tuple[NDArray[np.int_], ...]:
        """Rows of each dive."""
        lengths = [len(log.t) for log in self.forward.logs]
        return tuple(np.split(np.arange(sum(lengths)), np.cumsum(lengths)[:-1]))

    @cached_property
    def centre(self) -> Array:
        """Prior means of the coordinates, shape (k,)."""
        return np.array([coordinate.centre for coordinate in self.coordinates])

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviation of each coordinate: slab for a cause, spike otherwise (0 for a shape)."""
        return np.array([c.slab if c.effect in causes else c.spike for c in self.coordinates])

    def free(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes."""
        return np.flatnonzero([coordinate.effect in causes for coordinate in self.coordinates])

    @cached_property
    def base(self) -> DiveLinearisation:
        """The base model, linearised."""
        return self.linearise([((), self.centre)])[0]

    def linearise(self, wanted: Sequence[tuple[Causes, Array]]) -> list[DiveLinearisation]:
        """Linearise the phase for several sets in one call: all strengths, the causes' shapes, the dives' scatter."""
        settings, factors, plans = [], [], []
        for causes, at in wanted:
            chosen = [i for i, c in enumerate(self.coordinates) if c.kind != "shape" or c.effect in causes]
            ahead, steps = jacobian_settings(self.coordinates, at, np.array(chosen))
            shifted = np.repeat(at[:, None], 2, axis=1)
            shifted[self._clock] += np.array([SHIFT, -SHIFT])
            others = np.stack([self._unshaped(at), with_pure_delay(at, self._names, PURE_DELAY_SHARE)], axis=1)
            settings += [at[:, None], np.repeat(at[:, None], 2, axis=1), shifted, others, ahead]
            factors += [np.ones(1), 1.0 + WEIGHT_STEP * np.array([1.0, -1.0]), np.ones(4 + ahead.shape[1])]
            plans.append((chosen, steps))
        widths = np.array([7 + len(chosen) for chosen, _ in plans])
        histories = self.forward.histories(self.coordinates, np.concatenate(settings, axis=1), np.concatenate(factors))
        starts = np.cumsum(widths) - widths
        delays = self.most_likely_release_delays(histories.subset(starts))
        readings = histories.readings(np.repeat(delays, widths, axis=0))
        blocks = np.split(readings, starts[1:], axis=1)
        return [
            self._linear(causes, at, own, block, chosen, steps)
            for (causes, at), own, (chosen, steps), block in zip(wanted, delays, plans, blocks, strict=True)
        ]

    def most_likely_release_delays(self, histories: Histories) -> Array:
        """Lateness of each dive's separation under w settings, given what else differs between dives, (w, d) [s].

        Where the vehicle starts with a jerk its readings are linear in the lateness over a few hundredths of a second
        only: less than the scatter.
        """
        delays: Array = np.zeros((histories.settings, len(self.parts)))
        for _ in range(DELAY_ITERATIONS):
            readings, later = histories.readings(delays), histories.readings(delays + DELAY_STEP)
            left, columns = self.y[:, None] - readings, (later - readings) / DELAY_STEP
            delays = np.array(
                [
                    _later(own, left[rows], columns[rows], known)
                    for own, rows, known in zip(self._others, self.parts, delays.T, strict=True)
                ]
            ).T
        return delays

    @cached_property
    def _others(self) -> list[Array]:
        """Covariance of each dive's readings at nominal noise, lateness aside; sensitivities as in the base model."""
        settings = np.repeat(self.centre[:, None], 3, axis=1)
        settings[self._names.index("drag-bias"), 1] += DRAG_STEP
        factors = np.array([1.0, 1.0, 1.0 + WEIGHT_STEP])
        readings = self.forward.histories(self.coordinates, settings, factors).readings()
        drag, weight = ((readings[:, 1:] - readings[:, :1]) / [DRAG_STEP, WEIGHT_STEP]).T
        sensitivities = np.stack([np.zeros_like(drag), np.ones_like(drag), drag, weight], axis=1)
        return [
            (still + dive_to_dive_covariance(sensitivities[rows], np.zeros(len(rows)), [NOMINAL_NOISE]))[0]
            for still, rows in zip(self._still((NOMINAL_NOISE,)), self.parts, strict=True)
        ]

    @cached_property
    def _names(self) -> list[str]:
        return [coordinate.effect for coordinate in self.coordinates]

    @cached_property
    def _clock(self) -> int:
        return self._names.index("clock-offset")

    def _unshaped(self, at: Array) -> Array:
        """Coordinates without the effects that have a shape of their own, shape (k,)."""
        effects = {c.effect for c in self.coordinates if c.kind == "shape"}
        return np.where([c.effect in effects for c in self.coordinates], self.centre, at)

    def _linear(
        self, causes: Causes, at: Array, delays: Array, readings: Array, chosen: list[int], steps: Array
    ) -> DiveLinearisation:
        """Linearise one set from its readings: here, heavier, lighter, later, earlier, unshaped, higher, ahead."""
        here, heavier, lighter, later, earlier, unshaped, higher = readings[:, :7].T
        columns = np.zeros((len(self.y), len(self.coordinates)))
        columns[:, chosen] = (readings[:, 7:] - here[:, None]) / steps
        free = self.free(causes)
        weight = (heavier - lighter) / (2.0 * WEIGHT_STEP)
        release, drag = columns[:, self._clock], columns[:, self._names.index("drag-bias")]
        linear = DiveLinearisation(
            at=at,
            release_delays=delays,
            y=self.y - here + columns[:, free] @ (at - self.centre)[free],
            columns=columns,
            sensitivities=np.stack([release, np.ones_like(here), drag, weight], axis=1),
            readings=here,
            curvature=0.5 * np.abs(later + earlier - 2.0 * here) * DIVE_SD["release"] / SHIFT,
            shaped=here - unshaped,
            order=LAG_ORDER_SD / (PURE_DELAY_SHARE * (2.0 - LAG_ORDER)) * (higher - here),
        )
        return replace(linear, y=linear.y + self.release_delay_shift(linear))

    def release_delay_shift(self, linear: DiveLinearisation) -> Array:
        """What the lateness about which the readings are linearised does to them, shape (N,) [m]."""
        counts = [len(rows) for rows in self.parts]
        return linear.sensitivity("release") * np.repeat(linear.release_delays, counts)

    def covariances(self, linear: DiveLinearisation, noises: tuple[Noise, ...]) -> list[Array]:
        """Covariance of each dive's readings beside the catalogue's coordinates, at each of g noises: (g, m, m) [m²].

        A cause with a shape of its own is a caricature of what it names: what it adds to the readings is uncertain
        by a smooth factor, `SHAPE_SD`.
        """
        return [
            still
            + dive_to_dive_covariance(linear.sensitivities[rows], linear.curvature[rows], noises)
            + shape_error_covariance(log.t, linear.shaped[rows])
            for still, log, rows in zip(self._still(noises), self.forward.logs, self.parts, strict=True)
        ]

    def _still(self, noises: tuple[Noise, ...]) -> list[Array]:
        """Covariance of each dive's readings that no fit changes, at each of g noises, shape (g, m, m) [m²]."""
        if noises not in self._known_still:
            self._known_still[noises] = [
                sensor_and_turbulence_covariance(log.t, log.sd, noises) for log in self.forward.logs
            ]
        return self._known_still[noises]

    @cached_property
    def _known_still(self) -> dict[tuple[Noise, ...], list[Array]]:
        return {}

    def total_covariance(self, linear: DiveLinearisation, noise: Noise, prior_sd: Array) -> Array:
        """Covariance of all readings with the coordinates' priors, shape (N, N) [m²]."""
        scaled = np.concatenate([linear.columns * prior_sd, linear.nuisances * [noise.scatter, 1.0]], axis=1)
        total = scaled @ scaled.T
        for rows, block in zip(self.parts, self.covariances(linear, (noise,)), strict=True):
            total[np.ix_(rows, rows)] += block[0]
        return np.asarray(total)

    def evidence(self, linear: DiveLinearisation) -> Evidence:
        """Whiten a linearisation's columns and data at every noise of the grid.

        Raises
        ------
        numpy.linalg.LinAlgError
            When a covariance is not positive definite.
        """
        both = np.concatenate([linear.columns, linear.nuisances, linear.y[:, None]], axis=1)
        grams, log_determinants = zip(*self._inner(linear, both), strict=True)
        counts = np.array([len(rows) for rows in self.parts])
        return Evidence(np.stack(grams, axis=1), np.stack(log_determinants, axis=1), counts)

    def products(self, linear: DiveLinearisation, prior_sd: Array, columns: Array) -> list[InnerProducts]:
        """Inner products of columns, shape (N, m), and the data, the coordinates integrated out, at every noise."""
        both = np.concatenate([linear.columns, linear.nuisances, columns, linear.y[:, None]], axis=1)
        inner = self._inner(linear, both)
        gram, log_determinant = next(inner)
        for more, further in inner:  # added in place: one dive's alone are some tens of megabytes
            gram += more
            log_determinant += further
        return integrated(gram, log_determinant, prior_sd)

    def _inner(self, linear: DiveLinearisation, columns: Array) -> Iterator[tuple[Array, Array]]:
        """Inner products of columns over each dive, and ln |covariance|, at every noise of the grid."""
        for rows, covariance in zip(self.parts, self.covariances(linear, noise_grid()), strict=True):
            yield inner_products(covariance, columns[rows])


def _later(covariance: Array, left: Array, columns: Array, delays: Array) -> Array:
    """One Gauss–Newton step of a dive's lateness under w settings, shape (w,) [s].

    From what is left of its readings and their sensitivity to it, both of shape (m, w).
    """
    precise = np.linalg.inv(covariance)
    found = []
    rows = (np.ascontiguousarray(values.T) for values in (columns, left))
    for one, rest, known in zip(*rows, delays, strict=True):  # one by one: bits the same whatever the others are
        weights = precise @ one
        found.append(weights @ (rest + known * one) / (weights @ one + DIVE_SD["release"] ** -2))
    return np.asarray(np.clip(found, -LARGEST_RELEASE_DELAY, LARGEST_RELEASE_DELAY))
