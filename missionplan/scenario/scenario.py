"""A mission at its means or with the draws of a block of trials: what its phases share, and its transits."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.includes import SIGMA
from missionplan.mission.schema.effect_list import POSTERIOR
from missionplan.mission.schema.phases import LegTableSection, MoorPhase, TransitPhase
from missionplan.montecarlo.posterior import Tied
from missionplan.montecarlo.streams import BLOCK, BlockStreams, JointDistribution, NormalSource
from missionplan.phases.currents import Current, LayeredCurrent, Leeway, layers
from missionplan.phases.ensemble import Ensemble, ErringCurrent
from missionplan.phases.hooks import TransitEffect
from missionplan.phases.place import Place
from missionplan.phases.transit.compensation import Compensation, Forecast, LastVelocity, compensation_named
from missionplan.phases.transit.kalman_filter import DriftFilter
from missionplan.phases.transit.plan import Environment, Execution, LegTable, TransitPlan
from missionplan.physics.propulsion import propulsive_power
from missionplan.scenario.anchors import carried_anchors
from missionplan.scenario.drawn_mission import DrawnMission
from missionplan.scenario.place import drawn_place, read_place
from missionplan.scenario.site_current import MEMBER, error_statistics, leeway, recorded_wind, with_error, with_member
from missionplan.scenario.transits import DriftSample, PropelledVehicle, drift_model

STILL_WATER = LayeredCurrent(np.ones(1), np.zeros(1), np.zeros(1))
"""For phases that need a current where the mission has none."""

SIGMA_KEY = "navigation.velocity_error.sigma"
PRIOR = 1 << 41
"""Block of draws from which a filter's prior is taken: never one that a trial is run with."""


@dataclass(frozen=True)
class Scenario(DrawnMission):
    """A mission at its means, or with one draw per trial of every uncertain quantity.

    Attributes
    ----------
    mission, drawn : Mission
        See `DrawnMission`.
    """

    recorded: Current | None = None
    """The site's current where the mission reads it from a file (`site_current.recorded_current`)."""
    expected: "Scenario | None" = None
    """The mission at its means, if already made; see `means`."""
    sailed: Current | None = None
    """The recorded current with what was drawn of it, one a trial; None at the means."""
    member: Array | None = None
    """Number of the member of the current's ensemble that each trial sails in; None where it is none; shape (n,)."""
    wind: Current | None = None
    """Where the mission reads it from a file."""
    leeway: Leeway | None = None
    """Of the vehicle afloat; None in a mission without wind."""
    place: Place | None = None
    """Ground, coast and sea level; None where the mission names no file of them."""
    executions: Mapping[str, Execution] = field(default_factory=dict)
    """By transit, how a vehicle carries it out by other rules than the plan's."""

    @classmethod
    def at_means(cls, mission: Mission, recorded: Current | None = None) -> "Scenario":
        """Return the mission with every distribution at its mean; files of wind and place are read.

        On a grid of depths `site.depth` is the depth at the first mooring, else at the last goal.
        """
        means, wind = mission.at_means(), recorded_wind(mission)
        afloat = leeway(means, wind, None, 1)
        made = cls(mission, means, recorded, wind=wind, leeway=afloat, place=read_place(mission))
        return made._with_depth()._with_shaft_speeds()

    def sampled(self, *, seed: int, block: int, size: int = BLOCK) -> "Scenario":
        """Draw a block of trials, `self` being at the means; what blocks share is computed once and kept in `self`."""
        return self.sampled_from(BlockStreams(seed, block), size)

    def sampled_from(self, source: NormalSource, size: int) -> "Scenario":
        """Draw trials from a source of normals; as `sampled`."""
        values = self.drawn.at(self._joint.draw_from(source, size))
        blown, place = leeway(values, self.wind, source, size), self.place and drawn_place(self.place, values)
        drawn = replace(self, drawn=values, expected=self, leeway=blown, place=place)._with_shaft_speeds()
        if self.recorded is None:
            return drawn
        member = with_member(self.recorded, source, size)
        if isinstance(member, Ensemble) and member.chosen is not None:
            drawn = replace(drawn, member=member.chosen.astype(float))
        sailed = with_error(member, error_statistics(values), source, size)
        return replace(drawn, sailed=sailed)

    @cached_property
    def _joint(self) -> JointDistribution:
        mission, listed = self.mission, self.mission.effect_list
        streams = {f"{e.place}.{key}": listed.stream_of(e, key) for e in listed.entries for key in e.parameters}
        joint = JointDistribution.of(mission.quantities(), mission.correlated, streams)
        if listed.learned is None or SIGMA not in listed.learned.draws.columns or SIGMA_KEY in joint.correlated:
            return joint
        sigma = joint.marginals.get(SIGMA_KEY)  # stays as the mission has it, and gets the ranks of the draws
        tied = {} if sigma is None else {SIGMA_KEY: Tied(sigma, listed.learned.held.scores(SIGMA))}
        return replace(joint, marginals={**joint.marginals, **tied}, streams={**streams, SIGMA_KEY: POSTERIOR})

    def _with_depth(self) -> "Scenario":
        """Say how deep it is where the mission moors first, else at its last goal, where a grid of depths tells it."""
        if self.place is None or self.place.ground is None:
            return self
        here = np.zeros(2)
        for phase in self.drawn.phases:
            if isinstance(phase, MoorPhase):
                break
            if isinstance(phase, TransitPhase):
                here = self.position(phase.to)
        depth = float(self.place.water_at(here.reshape(2, 1), np.zeros(1))[0])
        return self.at_depth(depth) if np.isfinite(depth) else self

    def _with_shaft_speeds(self) -> "Scenario":
        """Add the speeds of the transits that give a shaft rate."""
        if self.propelled is None or all(phase.shaft_rate is None for phase in self.drawn.transits):
            return self
        bare = replace(self, expected=self.expected or self)  # what an anchor weighs depends on no speed of a transit
        speeds = {
            f"{phase.name}.speed": propelled.speed(phase.shaft_rate)
            for phase in self.drawn.transits
            if phase.shaft_rate is not None and (propelled := bare._propelled(phase)) is not None
        }
        return replace(self, drawn=self.drawn.at(speeds))

    @cached_property
    def means(self) -> "Scenario":
        """The same mission at its means: what is known before the mission starts."""
        return self.expected or Scenario.at_means(self.mission, self.recorded)

    @property
    def draws(self) -> Mapping[str, Array]:
        """What was drawn, by the names of the quantities that are distributions, shape (n,) each."""
        values = self.drawn.quantities()
        draws = {name: np.asarray(values[name], dtype=float) for name in self.means._joint.marginals}
        return draws if self.member is None else {**draws, MEMBER: self.member}

    def stream_of(self, name: str) -> str:
        """Return the name of the stream that an uncertain quantity is drawn from."""
        return self.means._joint.streams.get(name, name)

    @cached_property
    def current(self) -> Current | None:
        """The site's current; None in still water."""
        if self.recorded is not None:
            return self.sailed or self.recorded
        site_current = self.drawn.site.current if self.drawn.site else ()
        if not isinstance(site_current, tuple) or not site_current:
            return None
        return layers(*zip(*((layer.down_to, layer.speed, layer.toward) for layer in site_current), strict=True))

    def transit_plan(self, phase: TransitPhase[Scalars]) -> TransitPlan:
        """Return the parameters of one transit.

        Until the first mooring the vehicle carries the anchor on its nose, which lengthens the hull.
        """
        table, propelled, hotel = phase.d_max, self._propelled(phase), self.budget.hotel
        return TransitPlan(
            goal=self.position(phase.to),
            via=self.ways(phase),
            speed=phase.speed,
            arrival_radius=phase.arrival_radius,
            d_max=leg_table(table) if isinstance(table, LegTableSection) else table,
            surfacing_time=self.surfacing_time,
            velocity_error=self.velocity_error,
            fix_error=self.fix_error,
            depth=phase.depth,
            max_legs=self.navigation.max_legs,
            power_under_way=hotel + self.propulsion_power(phase),
            power_at_surface=hotel,
            surfacing_energy=self.budget.surfacing,
            latitude=self.latitude,
            length_lost=None if propelled is None else propelled.length_lost(phase.speed),
        )

    def ways(self, phase: TransitPhase[Scalars]) -> tuple[Array, ...]:
        """Points on the way of a transit: the mission's, or the shortest way clear of ground and coast."""
        if isinstance(phase.via, str):
            return self.means._ways_round[phase.name]
        return tuple(self.position(point) for point in phase.via)

    @cached_property
    def _ways_round(self) -> Mapping[str, tuple[Array, ...]]:
        """Ways of the transits that leave theirs to the program; `self` being at the means."""
        ways, here = {}, np.zeros(2)
        for phase in self.drawn.transits:
            start = here if phase.start is None else self.position(phase.start)
            here = self.position(phase.to)
            if phase.via != "auto":
                continue
            if self.place is None:
                message = "given auto, which needs site.land, site.keep_out or site.bathymetry to go round"
                raise InputError([Problem(message, self.mission.file, key=f"{phase.name}.via")])
            from missionplan.scenario.ways import way_round  # shapely: of few missions

            margin = leg_spread(self, phase)
            way = way_round(self.place, start.reshape(2), here.reshape(2), float(phase.depth), margin)
            if way is None:
                message = f"no way from start to goal keeps {margin:.3g} m, the drift of a leg, from what blocks it"
                hint = "a shorter d_max drifts less far; points given as via may pass nearer"
                raise InputError([Problem(message, self.mission.file, key=f"{phase.name}.via", hint=hint)])
            ways[phase.name] = way
        return ways

    def environment(self, phase: TransitPhase[Scalars]) -> Environment:
        """Return the current, the drift compensation and the effects of one transit."""
        return Environment(self.current, self.compensation(phase), self.effects_under_way(phase), self.place)

    def effects_under_way(self, phase: TransitPhase[Scalars]) -> tuple[TransitEffect, ...]:
        """Return the effects on one transit: the mission's, and the error of a speed inferred from the shaft rate."""
        propelled = self._propelled(phase)
        return (*self.effects_afloat, *(propelled.inferred_speed(phase.speed) if propelled else ()))

    @property
    def effects_afloat(self) -> tuple[TransitEffect, ...]:
        """The mission's effects on transits, and the leeway."""
        return (*self.transit_effects, *((self.leeway,) if self.leeway else ()))

    def propulsion_power(self, phase: TransitPhase[Scalars]) -> Scalars:
        """Power of propulsion on a transit [W]; nan without the vehicle or the water that its drag depends on."""
        speed, propelled = phase.speed, self._propelled(phase)
        if propelled is not None:
            return propelled.power(speed)
        if self.mission.vehicle is None or self.mission.site is None or self.mission.site.water is None:
            return float("nan")
        anchor = carried_anchors(self, phase)
        drag = self.vehicle_drag if anchor is None else anchor.lengthened(self.vehicle_drag)
        return propulsive_power(drag(speed), speed, self.budget.propulsive_efficiency)

    def _propelled(self, phase: TransitPhase[Scalars]) -> PropelledVehicle | None:
        """The vehicle with its propeller, as it is on a transit."""
        anchor = carried_anchors(self, phase) if self.propelled is not None else None
        if self.propelled is None or anchor is None:
            return self.propelled
        return replace(self.propelled, drag=anchor.lengthened(self.vehicle_drag), carried_mass=anchor.mass)

    def compensation(self, phase: TransitPhase[Scalars]) -> Compensation | None:
        """Return how the vehicle compensates for drift on one transit, which only the means determine."""
        execution = self.executions.get(phase.name)
        if execution is not None:
            return LastVelocity() if execution.corrects else None
        return self.means._compensations[phase.name]

    @cached_property
    def _compensations(self) -> Mapping[str, Compensation | None]:
        """By transit; `self` being at the means."""
        return {phase.name: self._compensation(phase) for phase in self.drawn.transits}

    def _compensation(self, phase: TransitPhase[Scalars]) -> Compensation | None:
        navigation = self.navigation
        forecast = Forecast(
            current=self.current,
            mean_error=np.array([float(value) for value in self.velocity_error.mean[:, 0]]),
            depth=float(phase.depth),
            surfacing_time=float(self.surfacing_time),
        )
        way, covariance = navigation.drift_compensation, navigation.velocity_error.covariance
        if way == "filter":
            drawn = self.sampled(seed=0, block=PRIOR)
            in_doubt = any(len(doubt.probabilities) > 1 for doubt in self.mission.doubts)  # at the means one holds
            fix_error = float(np.sqrt(np.mean(np.square(drawn.fix_sd))) if in_doubt else np.mean(self.fix_sd))
            model = drift_model(
                drawn._drift_sample(drawn.transit(phase.name)),
                forecast,
                covariance=covariance,
                latitude=self.latitude,
                fix_error=fix_error,
            )
            return DriftFilter(forecast, model)
        return compensation_named(way, forecast, covariance, self.fix_error)

    def _drift_sample(self, phase: TransitPhase[Scalars]) -> DriftSample:
        current = self.current
        return DriftSample(
            trials=self.trials,
            velocity_error=self.velocity_error.mean,
            current=current.forecast if isinstance(current, ErringCurrent) else current,
            is_recorded=self.recorded is not None and not isinstance(self.recorded, Ensemble),
            depth=phase.depth,
            surfacing_time=self.surfacing_time,
            effects=self.transit_effects,
            forecast_error=self._error_along(phase),
        )

    def _error_along(self, phase: TransitPhase[Scalars]) -> tuple[Scalars, Scalars] | None:
        """Standard deviation and correlation time, along a track, of the forecast's error [m/s, s]."""
        error = error_statistics(self.drawn) if self.recorded is not None else None
        if error is None:
            return None
        lost = 1.0 / np.asarray(error.time)
        if error.length is not None:
            lost = lost + phase.speed / np.asarray(error.length)
        return error.sigma, 1.0 / lost


def leg_spread(means: Scenario, phase: TransitPhase[Scalars]) -> float:
    """How far from its course a leg ends in all but 0.3 % of the trials [m].

    Three standard deviations of the velocity error, the current and the fix over the longest leg, what the mean
    current carries where nothing makes up for it, and the drift while it is at the surface.
    """
    drawn = means.sampled(seed=0, block=PRIOR, size=256)
    longest = phase.d_max
    length = float(leg_table(longest).leg.max()) if isinstance(longest, LegTableSection) else float(longest)
    time, speed = length / float(phase.speed), drawn.velocity_error
    place, root = np.zeros((2, 1)), float(np.sqrt(np.square(speed.root).sum(axis=1).max()))
    below, afloat = np.zeros((2, 256)) + speed.mean, np.zeros((2, 256))
    if drawn.current is not None:
        below = below + drawn.current.velocity(0.0, float(phase.depth), place)
        afloat = afloat + drawn.current.velocity(0.0, 0.0, place)
    random = np.hypot(root * time, float(np.std(below, axis=1).max()) * time)
    carried = float(np.hypot(*below.mean(axis=1))) * time if means.navigation.drift_compensation == "none" else 0.0
    drifted = float(np.quantile(np.hypot(*afloat), 0.997)) * float(means.surfacing_time)
    return float(3.0 * np.hypot(random, float(means.fix_sd)) + carried + drifted)


def leg_table(table: LegTableSection) -> LegTable:
    """Return the leg lengths against distance left of a mission file as a transit takes them."""
    left, length = np.array(table.table, dtype=float).T
    return LegTable(left, length)
