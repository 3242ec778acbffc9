"""Currents that the mission does not have, under way and at the surface; the tide has a module of its own."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, LegRecord, Parameter
from missionplan.effects.oscillation import (
    MODULATION_PARAMETERS,
    USUAL_TIME,
    Oscillation,
    inertial_frequency,
    mean_phasor,
    polar,
    wave,
)
from missionplan.phases.hooks import DriftParts, Leg, TransitEffect


@dataclass(frozen=True)
class MeanCurrent(TransitEffect):
    """Steady velocity (`east`, `north`) [m/s] at the run depth."""

    east: Scalars = 0.0
    north: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]."""
        return np.stack([self.east + 0.0 * leg.t_start, self.north + 0.0 * leg.t_start])

    def drift(self) -> DriftParts:
        """Return the steady velocity."""
        return DriftParts(velocity=np.stack(np.broadcast_arrays(self.east, self.north)))


_COMPONENT = "component of the current, toward positive"
MEAN_CURRENT = EffectInfo(
    id="mean-current",
    effect=MeanCurrent,
    parameters={
        "east": Parameter("m/s", f"east {_COMPONENT}", -3.0, 3.0, scale=0.15, spike=0.004),
        "north": Parameter("m/s", f"north {_COMPONENT}", -3.0, 3.0, scale=0.15, spike=0.004),
    },
    belongs_to="place",
    what="A current that is constant over the whole record, in addition to the site's current.",
    finding=Finding(
        "east",
        "a current of {size} toward {direction} is not in the mission",
        remedy="enter it as the site's current, or let the vehicle correct for its drift",
        toward=("east", "north"),
    ),
    sizes="0.02 to 0.5 m/s in coastal water.",
    confused_with=("speed-scale", "compass-bias", "current-shear", "persistent-error"),
    distinguished_by=(
        "Legs on several headings: a current has the same direction on all, a sensor error turns with the vehicle."
    ),
    is_steady_current=True,
)


@dataclass(frozen=True)
class InertialCurrent(Oscillation):
    """Current of constant speed `amplitude` [m/s] that rotates clockwise in the northern hemisphere.

    At the mission's start it flows toward the angle `phase` [rad], counted counter-clockwise from east. Its angular
    frequency is f = 2Ω sin(latitude): period 12 h/sin(latitude) of a sidereal day, 25.97 h at 27.4° N.
    """

    amplitude: Scalars = 0.0
    phase: Scalars = 0.0
    modulation: Scalars = 0.0
    coherence_time: Scalars = USUAL_TIME

    def later(self) -> Self:
        """Return the current with its phase a quarter of a period later."""
        return replace(self, phase=self.phase + 0.5 * np.pi)

    def velocity(self, leg: Leg) -> Array:
        """Return the mean inertial velocity over each leg, shape (2, n) [m/s].

        Raises ValueError when the coordinates' origin has no latitude.
        """
        if not np.isfinite(leg.latitude):
            raise ValueError("inertial-current needs the latitude of site.origin")
        cosine, sine = mean_phasor(leg, inertial_frequency(leg.latitude))
        return np.stack(
            [wave(cosine, sine, self.amplitude, self.phase), wave(-sine, cosine, self.amplitude, self.phase)]
        )

    def drift(self) -> DriftParts:
        """Return the turning current."""
        turning = np.stack(np.broadcast_arrays(*polar(self.amplitude, self.phase)))
        return DriftParts(inertial=turning, modulation=(self.modulation, self.coherence_time))


def _needs_latitude(record: LegRecord) -> str:
    is_known = math.isfinite(record.latitude)
    return "" if is_known else "needs the latitude: site.origin in the mission, or positions by latitude"


INERTIAL_CURRENT = EffectInfo(
    id="inertial-current",
    effect=InertialCurrent,
    parameters={
        "amplitude": Parameter("m/s", "speed of the rotating current", 0.0, 3.0, scale=0.15, spike=0.002),
        "phase": Parameter("rad", "direction at the mission's start, counter-clockwise from east"),
        **MODULATION_PARAMETERS,
    },
    belongs_to="day",
    what="Water set in motion by a wind that has ceased rotates by the Coriolis force alone.",
    finding=Finding(
        "amplitude",
        "a current of {size} turns with the inertial period",
        "a current of {size} turns with the inertial period",
        remedy="plan with the extended mission, or with a forecast that has such a current",
    ),
    sizes="0.05 to 0.5 m/s for days after a storm.",
    confused_with=("tidal-current", "persistent-error", "mean-current"),
    distinguished_by="A record of two inertial periods or more; both components, which are in quadrature.",
    polar=(("amplitude", "phase"),),
    frequency_of=lambda phase, latitude: inertial_frequency(latitude),
    is_modulated=True,
    lacking=_needs_latitude,
    needs_latitude=True,
)


@dataclass(frozen=True)
class CurrentShear(TransitEffect):
    """Current linear in position, zero at the origin, at the middle of each leg as the current displaces it.

    ``east_by_north`` is the growth of the east component for each metre to the north [1/s], and so on: the rows of
    the 2 × 2 gradient are (east_by_east, east_by_north) and (north_by_east, north_by_north).
    """

    east_by_east: Scalars = 0.0
    east_by_north: Scalars = 0.0
    north_by_east: Scalars = 0.0
    north_by_north: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s].

        The mean over the leg of the solution of ẋ = w + G x, to second order in G and the leg's duration.
        """
        middle = leg.start + 0.5 * leg.duration * leg.speed * leg.along
        return self._at(middle + 0.5 * leg.duration * self._at(middle))

    def _at(self, place: Array) -> Array:
        """Return the current at places, shape (2, n) [m/s]."""
        x, y = place
        return np.stack(
            [self.east_by_east * x + self.east_by_north * y, self.north_by_east * x + self.north_by_north * y]
        )


CURRENT_SHEAR = EffectInfo(
    id="current-shear",
    effect=CurrentShear,
    parameters={
        f"{component}_by_{axis}": Parameter(
            "1/s",
            f"growth of the {component} current for each metre toward {axis}",
            -1e-2,
            1e-2,
            scale=5e-5,
            spike=2e-7,
            extent_scale=0.1,  # over an area a current changes by no more than its usual speed
            extent_spike=0.004,
        )
        for component in ("east", "north")
        for axis in ("east", "north")
    },
    belongs_to="place",
    what="The edge of a jet, a river mouth, the shelf edge: the current differs from one end of the area to the other.",
    finding=Finding(
        "",
        "the current differs from one place of the site to another",
        remedy="take the current from a model or from measurements along the way",
    ),
    sizes="0.1 m/s over 1 to 10 km: 1e-5 to 1e-4 1/s.",
    confused_with=("mean-current", "tidal-current", "persistent-error"),
    linear=False,
    distinguished_by="Legs that visit the same place at different times.",
)


@dataclass(frozen=True)
class SurfaceDrift(TransitEffect):
    """Steady drift (`east`, `north`) [m/s] while at the surface."""

    east: Scalars = 0.0
    north: Scalars = 0.0

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array:
        """Return the drift velocity, shape (2, n) [m/s]."""
        return np.stack([self.east + 0.0 * t, self.north + 0.0 * t])

    def drift(self) -> DriftParts:
        """Return the velocity at the surface."""
        return DriftParts(surface=np.stack(np.broadcast_arrays(self.east, self.north)))


SURFACE_DRIFT = EffectInfo(
    id="surface-drift",
    effect=SurfaceDrift,
    parameters={
        "east": Parameter("m/s", "east component, toward positive", -3.0, 3.0, scale=0.25, spike=0.01),
        "north": Parameter("m/s", "north component, toward positive", -3.0, 3.0, scale=0.25, spike=0.01),
    },
    belongs_to="day",
    what="Windage and Stokes drift move the vehicle between surfacing and its fix, in addition to the current.",
    finding=Finding(
        "east",
        "at the surface the vehicle drifts at {size} toward {direction}",
        remedy="take the fix at once on surfacing, and dive at once after it",
        toward=("east", "north"),
    ),
    sizes="About 3 % of the wind's speed: 0.1 to 0.5 m/s.",
    confused_with=("mean-current",),
    distinguished_by="Surfacing times that vary; two fixes a few minutes apart at one surfacing.",
    lacking=lambda record: (
        "" if record.has_surface_time else "needs the time at the surface before each fix: column surface_s"
    ),
)
