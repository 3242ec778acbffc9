"""Navigation logs as a kind of data: from a mission and a log to a model, and the extended mission by it.

The model is the mission's first transit at its means, bound to the legs; what of the extended mission belongs to no
effect is written here.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.datasets.legs import read_transit
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind, PutOff
from missionplan.diagnosis.extended_mission import with_noise
from missionplan.diagnosis.given import forecast_effect, has_forecast_error, with_forecast_error
from missionplan.diagnosis.given.priors import check_together, given_effects, given_priors
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.diagnosis.legs.fit_checks import (
    aliases,
    not_constant,
    one_step,
    put_off,
    wrong_fixes,
)
from missionplan.diagnosis.legs.likelihood.covariance import FIX_UNSTATED
from missionplan.diagnosis.legs.likelihood.fix_gaps import share_of_fix_errors
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.plan_gain import leg_length_choice, plan_gain
from missionplan.effects import CATALOGUE, effects_of
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.place import Geographic, to_geographic
from missionplan.mission.views import navigation_of
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.posterior import MOST_PLACES, Place
from missionplan.phases.currents import Current, Span
from missionplan.phases.hooks import TransitEffect
from missionplan.results.learned import PlanGain
from missionplan.results.learned.evidence import Alias, Causes, WrongFix
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current

LEGS_TOGETHER = 32
"""Legs over which position errors are added up for the misfit in words."""
DRAWS = 512
"""Draws of the mission from which its own uncertainty of the current is taken."""


def transit_model(data: TransitData, mission: Mission, seed: int) -> TransitModel:
    """Bind a mission's first transit to a navigation log.

    `seed` is of the draws of the mission's current.

    Raises InputError when the mission has no transit or no navigation, or its current cannot be read.
    """
    navigation = navigation_of(mission)
    recorded = recorded_current(mission, np.hstack((data.start, data.end)))
    means = Scenario.at_means(mission, recorded)
    drawn = means.sampled(seed=seed, block=0, size=DRAWS)
    if means.current is not None:
        check_cover(data, means.current, float(np.mean(means.transit().depth)), mission)
    current, base, spread = _expected_velocity(data, means, drawn)
    error = navigation.velocity_error
    base = base + np.array([[mean_of(part)] for part in error.mean])
    spread = np.hypot(spread, [np.std(side) for side in drawn.velocity_error.mean])
    fix_error = float(np.sqrt(max(mean_of(navigation.fix_error) ** 2, 0.0)))
    priors = given_priors(mission, effects_of("transit"))
    check_together(priors, mission, "transit")
    current_sd = (float(spread[0]), float(spread[1]))
    phase = means.transit()
    planned = float(np.mean(phase.speed)), float(np.mean(phase.depth))
    model = TransitModel(
        data, base, error.covariance, fix_error, current_sd, priors, site_current=current, planned=planned
    )
    effects = [effect for effect in given_effects(mission) if isinstance(effect, TransitEffect)]
    return with_fix_share(replace(model, base=model.base + model.velocity_error(effects)))


def with_fix_share(model: TransitModel) -> TransitModel:
    """Return a model with the part of the gaps between fixes that is an error of either, estimated from its log."""
    sigma = math.sqrt(max(0.5 * float(np.trace(model.covariance)), 1e-6))
    fix_sd = model.data.typical_fix_sd or model.fix_error or FIX_UNSTATED[0]
    data, error = model.data, model.data.velocity_error - model.base
    share = share_of_fix_errors(model.gaps, error, data.under_way, sigma, fix_sd)
    if not share:
        return model
    notice = (
        "The errors of fixes show in the gaps between the fix after a leg and the one before the next: "
        f"{100.0 * share:.0f} % of a gap is taken as the error of either fix."
    )
    return replace(model, data=replace(data, notices=(*data.notices, notice)), fix_share=share)


def check_cover(data: TransitData, current: Current, depth: float, mission: Mission) -> None:
    """Refuse a log that leaves the record of the current: its misfit would be that of a current made up.

    Raises InputError with the number of such legs, and the times of the log.
    """
    if not current.is_binding:
        return
    ends = data.t_start + data.under_way
    covered = np.broadcast_to(current.covers(Span(data.t_start, ends, depth, (data.start, data.end))), ends.shape)
    if covered.all():
        return
    hours = (float(data.t_start.min()) / 3600.0, float(ends.max()) / 3600.0)
    legs = f"{np.count_nonzero(~covered)} of the {data.n} legs of {data.name}"
    when = f"the log runs from {hours[0]:.1f} to {hours[1]:.1f} h after the mission's start, {depth:.0f} m down"
    hint = "is start: right? `outside: hold` in site.current keeps the record's last value"
    problem = f"{legs} lie beyond this record of the current: {when}"
    raise InputError([Problem(problem, mission.file, key="site.current", hint=hint)])


def _expected_velocity(data: TransitData, means: Scenario, drawn: Scenario) -> tuple[Array, Array, Array]:
    """The site's current on each leg, with that at the surface, each (2, n), and its standard deviation (2,) [m/s]."""
    if means.current is None or drawn.current is None:
        return np.zeros((2, data.n)), np.zeros((2, data.n)), np.zeros(2)
    depth = float(np.mean(means.transit().depth))
    through = data.dead_reckoned - data.start
    velocity = means.current.mean_velocity(data.t_start, data.under_way, depth, data.start, through)
    surfaced = data.t_start + data.under_way
    drift = means.current.velocity(surfaced, 0.0, data.end)
    expected = velocity + drift * data.surface / data.under_way
    place = np.repeat(data.start[:, :1], DRAWS, axis=1)
    draws = drawn.current.velocity(float(data.t_start[0]), depth, place)
    under_way, whole = (np.broadcast_to(current, (2, data.n)).copy() for current in (velocity, expected))
    return under_way, whole, np.broadcast_to(draws, (2, DRAWS)).std(axis=1)


_MOSTLY = 0.9
"""Share of an error that is along the course, where it is one of speed."""


def widened(best: CauseFit, scale: float) -> CauseFit:
    """Return a fit with σ_v and the sizes of its random causes scaled: its intervals were too narrow, or too wide.

    A scale of 1 leaves it as it is.
    """
    calibration = {name: value * (scale if name == "sigma_v_m_s" else 1.0) for name, value in best.calibration.items()}
    return replace(best, calibration=calibration, posterior=best.posterior.scaled(scale))


def extended_transit_mission(raw: Mapping[str, object], best: CauseFit, data: TransitData) -> dict[str, object]:
    """Return a mission's data with the noise as fitted, and with the place and time to which phases refer.

    The log gives origin and start to missions that lack them: currents that may be there refer to them, likely or not.
    `raw` has includes in place.
    """
    mission = with_noise(raw, best.calibration)
    section = mission.get("site")
    site = dict(section) if isinstance(section, dict) else {}
    if data.origin is not None and "origin" not in site:
        latitude, longitude = (math.degrees(angle) for angle in data.origin)
        mission["site"] = {**site, "origin": {"latitude": f"{latitude:.7f} deg", "longitude": f"{longitude:.7f} deg"}}
    if data.epoch is not None and "start" not in mission:
        mission["start"] = datetime.fromtimestamp(data.epoch, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return mission


def place_of(data: TransitData, mission: Mission) -> Place:
    """Latitude, longitude [rad] and date [s since 1970] of the middle of a log; nan where it does not tell."""
    (place,) = _placed(data, mission, data.start.mean(axis=1, keepdims=True), np.array([data.middle.mean()]))
    return place


def _placed(data: TransitData, mission: Mission, points: Array, times: Array) -> tuple[Place, ...]:
    """Places as of `place_of` of points, shape (2, k) [m], at times of a log, shape (k,) [s]."""
    zero = data.epoch if data.epoch is not None else mission.start.timestamp() if mission.start else math.nan
    position = np.full((2, times.size), math.nan)
    if data.origin is not None:
        origin = Geographic.model_construct(latitude=data.origin[0], longitude=data.origin[1])
        position = np.array(to_geographic(points[0], points[1], origin))
    return tuple(zip(*position.tolist(), (zero + times).tolist(), strict=True))


def date_of(data: TransitData, mission: Mission) -> float:
    """Date of the middle of a log [s since 1970]; nan where neither it nor a start of its own tells."""
    date = place_of(data, mission)[2]
    return date if data.epoch is not None else mission.dated(date)


@dataclass(frozen=True)
class TransitKind(DataKind):
    """Legs between fixes."""

    kind: str
    mission: Mission
    data: TransitData
    model: TransitModel

    @classmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read the legs and bind the mission's first transit to them."""
        data = unlearned(read_transit(folder, mission), mission)
        here = as_then(data, mission.at_place(place_of(data, mission)), date_of(data, mission))
        left = [notice for notice in here.notices() if notice not in mission.notices()]
        model = transit_model(replace(data, notices=(*data.notices, *left)), here, seed)
        return cls(kind, here, model.data, model)

    @property
    def places(self) -> tuple[Place, ...]:
        """Where and when legs began, of a long log some all over it."""
        legs = np.unique(np.linspace(0, self.data.n - 1, MOST_PLACES).astype(int))
        return _placed(self.data, self.mission, self.data.start[:, legs], self.data.middle[legs])

    @property
    def date(self) -> float:
        """Of the middle of the legs."""
        return date_of(self.data, self.mission)

    @property
    def model_coordinates(self) -> Sequence[Coordinate]:
        """Parameters of all causes as the model fits them."""
        return self.model.coordinates

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a leg: velocity errors, what the mission expects, and the errors left with both models.

        `residual_base` is data less the mission's expectation, `residual_extended` the error of predicting the leg
        from those before it.
        """
        model, data = self.model, self.model.data
        plain = model.axes @ model.y
        ahead = model.axes @ (model.one_step_errors(best) if best.causes else model.y)
        velocities = {"error": data.velocity_error, "expected": model.base}
        velocities |= {"residual_base": plain, "residual_extended": ahead}
        return pd.DataFrame(
            {
                "leg": data.labels,
                "t_start_s": data.t_start,
                "duration_s": data.under_way,
                "surface_s": data.surface,
                "x_start_m": data.start[0],
                "y_start_m": data.start[1],
                "heading_deg": np.degrees(np.arctan2(*model.leg.along)) % 360.0,
                **{
                    f"{n}_{way}_m_s": velocity[k]
                    for n, velocity in velocities.items()
                    for k, way in enumerate(("east", "north"))
                },
            }
        )

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe how errors add up over many legs, beside independent errors of the mission's size."""
        model, data = self.model, self.model.data
        count = min(LEGS_TOGETHER, data.n)
        moved = (model.axes @ model.y) * data.under_way
        sums = np.stack([moved[:, k : k + count].sum(axis=1) for k in range(data.n - count + 1)])
        measured = math.sqrt(float(np.mean(np.sum(sums**2, axis=1))))
        variance = np.trace(model.covariance) * data.under_way**2 + 4.0 * max(model.fix_error, 0.0) ** 2
        expected = math.sqrt(count * float(np.mean(variance)))
        ratio = measured / expected
        words = f"{ratio:.1f} times" if not 0.95 < ratio < 1.05 else "about"
        row = " in a row" if count < data.n else ""
        rms, usual = np.sqrt(np.array([np.sum(moved**2), np.sum(variance)]) / np.sum(data.under_way**2))
        return (
            f"Over {count} legs{row} the errors add up to {words} what the mission expects ({measured / 1000.0:.2f} km "
            f"against {expected / 1000.0:.2f} km); a leg errs by {100.0 * rms:.1f} cm/s rms, "
            f"{100.0 * usual:.1f} cm/s expected."
        )

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared errors of position that each fit predicts one leg ahead."""
        weight = self.data.weight
        before = max(float(np.sum((self.model.y * weight) ** 2)), 1e-30)
        left = (np.sum((self.model.one_step_errors(fit) * weight) ** 2) for fit in fits)
        return [float(np.clip(1.0 - remainder / before, 0.0, 1.0)) for remainder in left]

    def extended_mission(self, best: CauseFit) -> dict[str, object]:
        """Return the mission's data with the noise as fitted, and the place and time to which phases refer."""
        data = extended_transit_mission(self.mission.raw, best, self.data)
        return with_forecast_error(data, self.mission, (*best.given, *best.estimates))

    def plan_gain(self, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
        """Compare the maximum leg lengths chosen."""
        return plan_gain(leg_length_choice, base, extended, seed=seed, jobs=jobs)

    def carried(self, best: CauseFit, scale: float) -> CauseFit:
        """Return a fit with the velocity error and the random causes scaled, the error of a forecast taken out."""
        stated = (forecast_effect().id,) if has_forecast_error(self.mission) else ()
        return widened(replace(best, posterior=best.posterior.without(stated)), scale)

    def not_constant(self, best: CauseFit) -> Causes:
        """Return the physical causes whose parameters differ between the halves of the log."""
        return not_constant(self.model, best)

    def wrong_fixes(self, best: CauseFit) -> tuple[WrongFix, ...]:
        """Return the GPS fixes that are wrong."""
        return wrong_fixes(self.model, best)

    def confounded_with_reckoning(self, best: CauseFit) -> Causes:
        """Return causes of the vehicle along its course, no larger than twice the doubt of a made reckoning's speed."""
        doubt = self.data.reckoned_speed_sd
        if doubt is None:
            return ()
        model = self.model.with_term(best.state.term)
        columns, causes = model.columns_at(best), []
        speed = float(np.sqrt(np.mean(np.square(model.leg.speed))))
        for cause in best.causes:
            indices = model.by_effect.get(cause)
            if indices is None or CATALOGUE[cause].belongs_to != "vehicle":
                continue
            error = model.axes @ (columns[:, :, indices] @ best.state.mean[indices])
            sizes = np.sum(error * model.leg.along, axis=0), np.hypot(*error)
            along, whole = (float(np.sqrt(np.mean(np.square(size)))) for size in sizes)
            if _MOSTLY * whole < along <= 2.0 * doubt * speed:
                causes.append(cause)
        return tuple(causes)

    def put_off(self) -> Iterator[PutOff]:
        """Yield what the log takes as exact, what is put in its place, and the model then."""
        yield from put_off(self.model)

    def aliases(self, best: CauseFit) -> tuple[Alias, ...]:
        """Return effects that do to these legs what a claimed cause does, but not on the way back."""
        return aliases(self.model, best)

    def is_better_ahead(self, base: CauseFit, best: CauseFit) -> bool:
        """Whether a fit to the first two thirds predicts the others all the way better, in density and in place."""
        without, with_causes = (self.model.last_part_ahead(fit) for fit in (base, best))
        return with_causes.log_score > without.log_score and with_causes.squared_error < without.squared_error

    def calibration(self, best: CauseFit) -> dict[str, float]:
        """Return the nuisance parameters as fitted, and how well the next leg's position error is predicted [m]."""
        return {**best.calibration, **one_step(self.model, best)}
