"""Legs as trials: stars, boxes, legs there and back, of several lengths, speeds and depths, from the first transit."""

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
from scipy.linalg import block_diag

from missionplan.arrays import Array, Scalars
from missionplan.datasets.legs import MIN_LEGS
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.given import held
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.kind import TransitKind
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.next_trial.belief import Believed, Posterior
from missionplan.diagnosis.next_trial.designs import Alternatives, TrialKind
from missionplan.diagnosis.next_trial.prediction import Prediction
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.mission.schema.phases import LegTableSection, TransitPhase
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current

SHAPES: Mapping[str, tuple[float, ...]] = {
    "two opposite legs": (0.0, 180.0),
    "a star of six legs": (0.0, 180.0, 120.0, 300.0, 240.0, 60.0),
    "a box": (0.0, 90.0, 180.0, 270.0),
    "a figure of eight": (0.0, 90.0, 180.0, 270.0, 180.0, 90.0, 0.0, 270.0),
}
"""Headings from the mission's course [deg]; each ends where it begins."""
LENGTHS = (0.5, 1.0, 2.0)
"""Lengths of the legs over the mission's d_max."""
SHORT = (300.0, 600.0)
"""Times under way of shorter legs [s]: what is random is so from leg to leg, so that many short ones tell as much."""
MIXED, CHANGED = "a figure of eight", 0.7
"""Shape whose second half, on the headings of the first, is sailed at another speed or depth: this share of it."""
LEAST_DEPTHS = 2.0
"""Difference of depths below which legs are as good as at one depth [m]."""
LONG_LEG = 4.0
"""Length of one long leg over the mission's d_max."""
LATER = 86_400.0
"""Time between the end of the record and the trial [s]."""
SHARES = np.linspace(0.1, 1.0, 10)
"""Maximum leg lengths that are tried, of the first transit's distance."""
TABLE_SHARE = 0.25
"""Length that stands for the d_max of a mission with a table, of the distance."""
GENEROUS = 0.5
"""Arrival radius of a trial's leg over its length: one leg each, whatever its error."""


@dataclass(frozen=True)
class _Legs:
    """Legs of a trial: name, courses from north [rad] and the length of each [m]."""

    name: str
    courses: Array
    length: float
    speeds: Array | float = 1.0
    depths: Array | float = 1.0
    """Those of each leg over the mission's."""

    def halved(self, key: str, words: str) -> "_Legs":
        """Return them with the second half at another speed or depth."""
        half = np.where(np.arange(len(self.courses)) < len(self.courses) // 2, 1.0, CHANGED)
        changed = replace(self, name=f"{self.name}, half of it at {words}")
        return replace(changed, speeds=half) if key == "speed" else replace(changed, depths=half)


@dataclass(frozen=True)
class LegTrials(TrialKind):
    """Legs that the mission's vehicle could sail."""

    bound: TransitKind
    """The log so far, bound to the mission."""

    @cached_property
    def _means(self) -> Scenario:
        return Scenario.at_means(self.bound.mission, recorded_current(self.bound.mission))

    @cached_property
    def _phase(self) -> TransitPhase[Scalars]:
        return self._means.transit()

    @cached_property
    def _ends(self) -> tuple[Array, Array]:
        """Where the mission's first transit begins and ends, shape (2,) each [m]."""
        phase = self._phase
        begin = np.zeros(2) if phase.start is None else self._means.position(phase.start)
        return begin, self._means.position(phase.to)

    @cached_property
    def _distance(self) -> float:
        return float(np.hypot(*(self._ends[1] - self._ends[0])))

    @cached_property
    def _usual_length(self) -> float:
        """The mission's d_max, at most its distance [m]."""
        length = self._phase.d_max
        usual = TABLE_SHARE * self._distance if isinstance(length, LegTableSection) else float(length)
        return min(usual, self._distance)

    @cached_property
    def _legs(self) -> tuple[_Legs, ...]:
        course = math.atan2(*(self._ends[1] - self._ends[0]))
        trials = []
        for length in self._lengths:
            for shape, headings in SHAPES.items():
                trials += [
                    _Legs(
                        f"{shape} of {_metres(length)}{f', {times} times' if times > 1 else ''}",
                        course + np.radians(headings * times),
                        length,
                    )
                    for times in (1, max(2, math.ceil(MIN_LEGS / len(headings))))  # these are a data set of their own
                ]
        mixed = [legs.halved(*other) for legs in trials if legs.name.startswith(MIXED) for other in self._others]
        length = LONG_LEG * self._usual_length
        return (*trials, *mixed, _Legs(f"one long leg of {_metres(length)}", np.array([course]), length))

    @property
    def _lengths(self) -> list[float]:
        """Of the legs [m]."""
        usual = [factor * self._usual_length for factor in LENGTHS]
        short = [seconds * float(self._phase.speed) for seconds in SHORT]
        return [length for length in short if length < usual[0]] + usual

    @property
    def _others(self) -> list[tuple[str, str]]:
        """Speed and depth at which half of a trial may be sailed, each with its words."""
        phase, others = self._phase, []
        if "speed" in self._as_written:
            others.append(("speed", f"{CHANGED * float(phase.speed):.2g} m/s"))
        if self.bound.data.depth is not None and (1.0 - CHANGED) * float(phase.depth) > LEAST_DEPTHS:
            others.append(("depth", f"{CHANGED * float(phase.depth):.0f} m depth"))
        return others

    @property
    def designs(self) -> Sequence[str]:
        """Designs in words."""
        return [legs.name for legs in self._legs]

    def posterior(self, bound: DataKind, fit: CauseFit) -> Posterior:
        """Return what a fit of the legs says of its causes and of the mission's own effects."""
        model = cast("TransitKind", bound).model
        mission_effects = {prior.effect for prior in held(model.given_in_mean, fit.causes)}
        places = np.flatnonzero([c.effect in fit.causes or c.effect in mission_effects for c in model.coordinates])
        mean = model.expected.copy()
        mean[places] = fit.state.mean[places]
        return Posterior(places, mean, fit.state.covariance[np.ix_(places, places)])

    def predictions(self, design: int, believed: Sequence[Believed]) -> list[Prediction]:
        """Velocity errors of a design's legs on a later day, as each set of causes predicts them [m/s]."""
        return self.predicted(self._planned(self._legs[design]), believed)

    def predicted(self, data: TransitData, believed: Sequence[Believed]) -> list[Prediction]:
        """Return the velocity errors of legs, beyond the site's current, as each set of causes predicts them [m/s].

        They are legs of another day; where they ended is not used. What is known from record to record moves the mean;
        every effect differs from it in a new record by its spike, and so does the mission's current by its own
        uncertainty.
        """
        predictions = []
        for belief in believed:
            about, places = belief.posterior.mean, belief.posterior.places
            model, size = cast("TransitKind", belief.bound).model, 2 * data.n
            model = replace(model, data=data, base=np.zeros((2, data.n)), only=model.coordinates)
            columns = model.columns(about).reshape(size, -1)
            fresh = columns * _from_record_to_record(model)
            noise = block_diag(*model.noise(belief.fit.state.values)) + fresh @ fresh.T
            predictions.append(Prediction(model.mean_error(about).ravel(), columns[:, places], noise))
        return predictions

    def _planned(self, legs: _Legs) -> TransitData:
        """A record of these legs alone, sailed without error a day after the one so far."""
        data, count = self.bound.data, len(legs.courses)
        speed = float(self._phase.speed) * legs.speeds
        path = legs.length * np.stack([np.sin(legs.courses), np.cos(legs.courses)])
        ends = self._ends[0][:, None] + np.cumsum(path, axis=1)
        under_way = np.full(count, legs.length / speed)
        surface = np.full(count, float(np.median(data.surface)))
        first = float(data.t_start[-1] + data.under_way[-1]) + LATER
        lasting = under_way + surface + float(np.mean(self._means.surfacing_time))
        return replace(
            data,
            labels=np.array([f"leg {k + 1}" for k in range(count)]),
            run=np.zeros(count, dtype=int),
            t_start=first + np.cumsum(lasting) - lasting,
            under_way=under_way,
            surface=surface,
            start=ends - path,
            dead_reckoned=ends,
            end=ends + 1e-3,  # each leg has fixes of its own, on surfacing and on diving
            leg_fix_sd=None if data.leg_fix_sd is None else np.full(count, np.median(data.leg_fix_sd)),
            depth=None if data.depth is None else np.full(count, np.nanmedian(data.depth)) * legs.depths,
        )

    def trial(self, design: int) -> Mapping[str, object]:
        """Return the mission that sails a design's legs, one transit each."""
        legs, raw = self._legs[design], copy.deepcopy(dict(self.bound.mission.raw))
        corners = self._ends[0][:, None] + np.cumsum(
            legs.length * np.stack([np.sin(legs.courses), np.cos(legs.courses)]), axis=1
        )
        transit = self._as_written
        phases: list[object] = []
        for index, (east, north) in enumerate(corners.T.tolist()):
            begin = {} if index else {"from": [f"{place:.1f} m" for place in self._ends[0].tolist()]}
            to = {"to": [f"{east:.1f} m", f"{north:.1f} m"]}
            leg = {"d_max": f"{1.2 * legs.length:.1f} m", "arrival_radius": f"{GENEROUS * legs.length:.1f} m"}
            for key, shares, unit in (("depth", legs.depths, "m"), ("speed", legs.speeds, "m/s")):
                share = float(np.broadcast_to(shares, len(legs.courses))[index])
                if share != 1.0:
                    leg = {key: f"{share * float(getattr(self._phase, key)):.4g} {unit}"} | leg
            phases.append({"transit": {**transit, "name": f"leg-{index + 1}", **begin, **to, **leg}})
        kept = {key: value for key, value in raw.items() if key not in ("requirements", "sweep", "correlations")}
        return kept | {"name": f"Trial: {legs.name}", "phases": phases}

    @property
    def _as_written(self) -> dict[str, object]:
        """Keys of the first transit as the mission file has them, without those that a trial's leg has of its own."""
        written = self.bound.mission.raw["phases"]
        entries = written if isinstance(written, list) else []
        transit = next(entry["transit"] for entry in entries if isinstance(entry, dict) and "transit" in entry)
        return {key: value for key, value in transit.items() if key not in ("name", "from", "to", "d_max")}

    def alternatives(self) -> Alternatives:
        """Return maximum leg lengths, of all transits alike."""
        return Alternatives("d_max_m", SHARES * self._distance, _with_d_max)


def _with_d_max(mission: Mission, d_max: float) -> Mission:
    entries = tuple(
        entry.model_copy(update={"transit": entry.transit.model_copy(update={"d_max": d_max})})
        if entry.transit is not None
        else entry
        for entry in mission.entries
    )
    return mission.model_copy(update={"entries": entries})


def _from_record_to_record(model: TransitModel) -> Array:
    """Standard deviation of each coordinate from one record to another."""
    return np.array(
        [
            math.hypot(c.spike, model.current_sd[c.name == "north"])
            if CATALOGUE[c.effect].is_steady_current
            else c.spike
            for c in model.coordinates
        ]
    )


def _metres(length: float) -> str:
    return f"{length:.0f} m" if length < 1000.0 else f"{length / 1000.0:.3g} km"
