"""Navigation logs as a kind of data, and what of the mission extended by one belongs to no effect."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from missionplan.datasets.legs import read_transit
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.extended_mission import with_noise
from missionplan.diagnosis.given.effects import forecast_effect, has_forecast_error, with_forecast_error
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.diagnosis.legs.fit_checks import (
    aliases,
    not_constant,
    one_step,
    transit_misfit,
    transit_residuals,
    transit_share,
    wrong_fixes,
)
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.legs.model_factory import transit_model
from missionplan.diagnosis.plan_gain import leg_length_choice, plan_gain
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.mission.schema.place import Geographic, to_geographic
from missionplan.montecarlo.posterior import Place
from missionplan.results.learned import PlanGain
from missionplan.results.learned.evidence import Alias, Causes, WrongFix

_MOSTLY = 0.9
"""Share of an error that is along the course, where it is one of speed."""


def widened(best: CauseFit, scale: float) -> CauseFit:
    """Return a fit with σ_v and the sizes of its random causes scaled: its intervals were too narrow, or too wide.

    Parameters
    ----------
    best : CauseFit
    scale : float
        1 leaves it as it is.
    """
    calibration = {name: value * (scale if name == "sigma_v_m_s" else 1.0) for name, value in best.calibration.items()}
    return replace(best, calibration=calibration, posterior=best.posterior.scaled(scale))


def extended_transit_mission(raw: Mapping[str, object], best: CauseFit, data: TransitData) -> dict[str, object]:
    """Return a mission's data with the noise as fitted, and with the place and time to which phases refer.

    Parameters
    ----------
    raw : mapping
        The mission file's data with includes in place.
    best : CauseFit
    data : TransitData
        Gives origin and start to missions that lack them: currents that may be there refer to them, likely or not.
    """
    mission = with_noise(raw, best.calibration)
    given = mission.get("site")
    site = dict(given) if isinstance(given, dict) else {}
    if data.origin is not None and "origin" not in site:
        latitude, longitude = (math.degrees(angle) for angle in data.origin)
        mission["site"] = {**site, "origin": {"latitude": f"{latitude:.7f} deg", "longitude": f"{longitude:.7f} deg"}}
    if data.epoch is not None and "start" not in mission:
        mission["start"] = datetime.fromtimestamp(data.epoch, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return mission


def place_of(data: TransitData, mission: Mission) -> Place:
    """Latitude, longitude [rad] and date [s since 1970] of the middle of a log; nan where it does not tell."""
    zero = data.epoch if data.epoch is not None else mission.start.timestamp() if mission.start else math.nan
    date = zero + float(np.mean(data.middle))
    if data.origin is None:
        return math.nan, math.nan, date
    origin = Geographic.model_construct(latitude=data.origin[0], longitude=data.origin[1])
    latitude, longitude = to_geographic(data.start[0].mean(), data.start[1].mean(), origin)
    return float(latitude), float(longitude), date


def date_of(data: TransitData, mission: Mission) -> float:
    """Date of the middle of a log [s since 1970]; nan where neither it nor a start of its own tells."""
    date = place_of(data, mission)[2]
    return date if data.epoch is not None else mission.dated(date)


@dataclass(frozen=True)
class TransitKind(DataKind):
    """Legs between fixes."""

    ids = ("transit",)

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
    def place(self) -> Place:
        """Middle of the legs, and its date."""
        return place_of(self.data, self.mission)

    @property
    def date(self) -> float:
        """Of the middle of the legs."""
        return date_of(self.data, self.mission)

    @property
    def model_coordinates(self) -> Sequence[Coordinate]:
        """Parameters of all causes as the model fits them."""
        return self.model.coordinates

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a leg."""
        return transit_residuals(self.model, best)

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe how errors add up over many legs."""
        return transit_misfit(self.model)

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared velocity errors that each fit predicts one leg ahead."""
        return [transit_share(self.model, fit) for fit in fits]

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
        return () if doubt is None else _slower_or_faster(self.model.with_term(best.state.term), best, 2.0 * doubt)

    def aliases(self, best: CauseFit) -> tuple[Alias, ...]:
        """Return effects that do to these legs what a claimed cause does, but not on the way back."""
        return aliases(self.model, best)

    def is_better_ahead(self, base: CauseFit, best: CauseFit) -> bool:
        """Whether a fit to the first two thirds predicts the others all the way better, in density and in place."""
        without, with_causes = (self.model.last_part_ahead(fit) for fit in (base, best))
        return with_causes.log_score > without.log_score and with_causes.squared_error < without.squared_error

    def calibration(self, best: CauseFit) -> dict[str, float]:
        """Return the nuisance parameters as fitted, and how well the next leg's position error is predicted [m]."""
        ahead = one_step(self.model, best)
        if ahead is None:
            return dict(best.calibration)
        return {
            **best.calibration,
            "next_leg_mean_so_far_rms_m": ahead.mean_so_far,
            "next_leg_last_leg_rms_m": ahead.last_leg,
            "next_leg_model_rms_m": ahead.model,
        }


def _slower_or_faster(model: TransitModel, fit: CauseFit, most: float) -> Causes:
    """Causes of the vehicle that act along its course, by a share of the speed that is at most so large."""
    columns, found = model.columns_at(fit), []
    speed = float(np.sqrt(np.mean(np.square(model.leg.speed))))
    for cause in fit.causes:
        own = model.by_effect.get(cause)
        if own is None or CATALOGUE[cause].belongs_to != "vehicle":
            continue
        error = model.axes @ (columns[:, :, own] @ fit.state.mean[own])
        along, whole = (float(np.sqrt(np.mean(np.square(each)))) for each in (
            np.sum(error * model.leg.along, axis=0), np.hypot(*error)))  # fmt: skip
        if _MOSTLY * whole < along <= most * speed:
            found.append(cause)
    return tuple(found)
