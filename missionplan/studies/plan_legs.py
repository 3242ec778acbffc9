"""How long should each leg be? The best legs by dynamic programming, tried in the mission's own Monte Carlo."""

import time
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.fanout import Backend, Progress, run_blocks
from missionplan.montecarlo.statistics import Moments, wilson
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.phases.expectation import TransitExpectation, expected_transit
from missionplan.phases.leg_policy import LegPolicy, best_d_max, best_legs
from missionplan.phases.legs import LegTable
from missionplan.phases.transit import transit
from missionplan.phases.transit_plan import VelocityError
from missionplan.results.base import Provenance
from missionplan.results.legs import LegCase, LegPlan, SampledCost
from missionplan.studies.setting import Setting
from missionplan.studies.sweep_setting import SweepSetting

Array = NDArray[np.float64]
Aim = Literal["mean"]

TRACKS = 6
"""Trials whose tracks are kept."""


@dataclass(frozen=True)
class Misjudged:
    """A navigation error that is not as planned.

    Attributes
    ----------
    name : str
    sigma_factor : float
        On Σ_v's root.
    mean : tuple of float
        Beyond the mission's v̄, east and north [m/s].
    """

    name: str
    sigma_factor: float = 1.0
    mean: tuple[float, float] = (0.0, 0.0)


def plan_legs(
    mission: Mission,
    *,
    aim: Aim = "mean",
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> LegPlan:
    """Find the legs that make a transit's expected time least, and try them beside the best fixed d_max.

    The legs are best for isotropic errors about zero, drawn anew each leg, and exact fixes; whatever else the mission
    has acts on the trials of both plans.

    Parameters
    ----------
    mission : Mission
        Its transit is the one that `sweep` names, else the first.
    aim : {'mean'}
    trials, seed : int, optional
        Default: the mission's.
    jobs, backend, scheduler, progress
        See `run_blocks`.

    Raises
    ------
    InputError
        When the mission has no transit, or no legs can be planned for it.
    """
    started = time.perf_counter()
    setting = replace(SweepSetting.of(mission), sigmas=(None,))
    policy, d_max, fixed, one_leg = _optimise(setting)
    trials = trials or mission.monte_carlo.trials
    seed = mission.monte_carlo.seed if seed is None else seed
    cases = _cases(setting)
    task = LegTask(setting, cases, d_max, _as_written(policy.legs), trials, seed)
    items = [(number, block) for block in range(block_count(trials)) for number in range(len(cases))]
    totals: dict[int, Moments] = {}
    results = run_blocks(task, items, jobs=jobs, backend=backend, scheduler=scheduler, progress=progress)
    for (number, _), moments in zip(items, results, strict=True):
        totals[number] = totals[number].merge(moments) if number in totals else moments
    tracks = task.tracks()
    provenance = Provenance(
        command="plan-legs",
        mission=mission.name,
        file=mission.file,
        seed=seed,
        trials=trials,
        options={"aim": aim, "jobs": jobs, "backend": backend, "scheduler": scheduler},
        elapsed_s=time.perf_counter() - started,
        data=mission.raw,
        notices=(*mission.notices(), *_notices(setting)),
    )
    return LegPlan(
        provenance=provenance,
        phase=setting.phase.name,
        phase_index=mission.phases.index(setting.phase),
        aim=aim,
        distance=setting.distance,
        speed=setting.speed,
        arrival_radius=setting.arrival_radius,
        surfacing_time=setting.surfacing_time,
        sigma=setting.sigma(0),
        left=task.legs.left,
        leg=task.legs.leg,
        expected_cost=policy.transit.cost,
        least_cost=policy.bound,
        expected_surfacings=policy.transit.surfacings,
        fixed_d_max=d_max,
        fixed_cost=fixed.cost,
        one_leg_cost=one_leg.cost,
        cases=tuple(_case(setting, case, totals[number]) for number, case in enumerate(cases)),
        fixed_tracks=tracks[0],
        adaptive_tracks=tracks[1],
    )


@dataclass(frozen=True)
class LegTask:
    """Both plans on one block of trials of one case: a function of the case's number and the block alone."""

    setting: SweepSetting
    cases: tuple[Misjudged, ...]
    d_max: float
    legs: LegTable
    trials: int
    seed: int

    def __call__(self, item: tuple[int, int]) -> Moments:
        """Moments of cost fixed, cost adaptive, saving, surfacings fixed, surfacings adaptive, arrivals of each.

        Costs, saving and surfacings are of the trials that arrive by both plans.
        """
        number, block = item
        size = block_size(self.trials, block)
        (fixed, adaptive), nominal = self._run(self.cases[number], block, size, tracked=0)
        values = np.stack(
            [fixed.cost, adaptive.cost, (fixed.cost - adaptive.cost) * nominal, fixed.surfacings, adaptive.surfacings]
        )
        values[:, ~(fixed.arrived & adaptive.arrived)] = np.nan
        return Moments.of(np.concatenate([values, np.stack([fixed.arrived, adaptive.arrived]).astype(float)]))

    def tracks(self) -> tuple[Array, Array]:
        """Tracks of the first few trials of the mission itself, by each plan."""
        size = min(block_size(self.trials, 0), TRACKS)
        (fixed, adaptive), _ = self._run(self.cases[0], 0, size, tracked=size)
        assert fixed.track is not None
        assert adaptive.track is not None
        return fixed.track, adaptive.track

    def _run(self, case: Misjudged, block: int, size: int, tracked: int) -> tuple[tuple["_Run", "_Run"], Array]:
        setting = self.setting
        drawn = Setting.drawn(setting.mission, setting.means.recorded, seed=self.seed, block=block, size=size)
        state = setting.state(drawn, self.seed, block, size)
        normals, surroundings = setting.normals(self.seed, block), setting.surroundings(drawn)
        plan = setting.plan(0, drawn)
        error = plan.velocity_error
        shifted = VelocityError(error.mean + np.array(case.mean)[:, None], error.root * case.sigma_factor)
        plan = replace(plan, velocity_error=shifted)
        nominal = np.hypot(*(np.asarray(plan.goal).reshape(2, -1) - state.position)) / plan.speed
        runs = []
        for d_max in (self.d_max, self.legs):
            _, record = transit(replace(plan, d_max=d_max), state, normals, surroundings, tracked=tracked)
            charged = np.maximum(record.surfacings - 1.0, 0.0) * plan.surfacing_time
            cost = (record.distance / plan.speed + charged) / nominal - 1.0  # Eq. 25
            track = record.track.position if record.track is not None else None
            runs.append(_Run(cost, record.surfacings, record.arrived, track))
        return (runs[0], runs[1]), nominal


@dataclass(frozen=True)
class _Run:
    """What one plan came to, an array over trials each."""

    cost: Array
    surfacings: Array
    arrived: NDArray[np.bool_]
    track: Array | None


def _optimise(setting: SweepSetting) -> tuple[LegPolicy, float, TransitExpectation, TransitExpectation]:
    """Best legs, best fixed d_max, what it is expected to do, and what a single leg is."""
    arguments = (
        setting.distance,
        setting.speed,
        setting.arrival_radius,
        setting.sigma(0),
        setting.surfacing_time,
    )
    try:
        return (
            best_legs(*arguments),
            *best_d_max(*arguments),
            expected_transit(setting.distance, setting.distance, *arguments[1:]),
        )
    except ValueError as error:
        raise InputError([Problem(str(error), setting.mission.file, key=setting.phase.name)]) from error


def _as_written(legs: LegTable) -> LegTable:
    """Round a table as mission files write it, to 0.1 m; knots that fall together are left out."""
    left, leg = np.round(legs.left, 1), np.maximum(np.round(legs.leg, 1), 0.1)
    kept = np.append(True, np.diff(left) > 0.0)
    return LegTable(left[kept], leg[kept])


def _cases(setting: SweepSetting) -> tuple[Misjudged, ...]:
    """The mission itself; σ_v half and double; the mean error half and double, or one that was not expected."""
    mean = setting.plan(0, setting.means).velocity_error.mean[:, 0]
    sigma = setting.sigma(0)
    if np.any(mean):
        means = [("mean error half as large", -0.5 * mean), ("mean error twice as large", mean)]
    else:
        course = setting.means.position(setting.phase.to, f"{setting.phase.name}.to")
        course = course - setting.means.position(*setting.start)
        across = np.array([-course[1], course[0]]) / np.hypot(*course)
        means = [
            ("unexpected mean error of σ_v/2 across the course", 0.5 * sigma * across),
            ("unexpected mean error of σ_v across the course", sigma * across),
        ]
    return (
        Misjudged(""),
        Misjudged("σ_v half as large", 0.5),
        Misjudged("σ_v twice as large", 2.0),
        *(Misjudged(name, mean=(float(shift[0]), float(shift[1]))) for name, shift in means),
    )


def _case(setting: SweepSetting, case: Misjudged, totals: Moments) -> LegCase:
    mean, error = totals.mean, totals.standard_error
    reached = bool(totals.count[0])

    def sampled(plan: int) -> SampledCost:
        trials = int(totals.count[5 + plan])
        arrived = wilson(round(float(mean[5 + plan]) * trials), trials)
        cost, spread, surfacings = (mean[plan], error[plan], mean[3 + plan]) if reached else (np.nan,) * 3
        return SampledCost(float(cost), float(spread), float(surfacings), arrived)

    saving, saving_error = (mean[2], error[2]) if reached else (np.nan, np.nan)
    return LegCase(
        name=case.name,
        sigma=setting.sigma(0) * case.sigma_factor,
        mean_error=case.mean,
        fixed=sampled(0),
        adaptive=sampled(1),
        saving=float(saving),
        saving_error=float(saving_error),
    )


def _notices(setting: SweepSetting) -> tuple[str, ...]:
    obstacle = setting.analytic_obstacle()
    return (f"the legs are best without {obstacle}, which only the trials have",) if obstacle else ()
