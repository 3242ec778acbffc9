"""`score`: how well a mission as it stands predicts measured legs and dives; nothing is fitted.

`legs` and (for dives) this module make a `predictive.Ensemble` of a data set: what the mission expects of each value in
many draws of its uncertain quantities, by the phases that `simulate` runs, and the covariance of what else is random.
`predictive` turns it into distributions of each value, with the past of the record or without; `yardsticks` has what
they are held against.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from missionplan.arrays import Array
from missionplan.datasets import dataset_kind, files_outside
from missionplan.datasets.dives import read_descent
from missionplan.datasets.legs import read_transit
from missionplan.datasets.records import TransitData, is_learned
from missionplan.diagnosis.dives.forward import NO_BOTTOM, STEP, DiveHistories
from missionplan.diagnosis.dives.model import check_leaves_surface, descent_model
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.dives.preparation import DiveLog, PreparedDives, prepare_dives
from missionplan.diagnosis.learned_data import as_then
from missionplan.diagnosis.scoring.legs import leg_ensemble
from missionplan.diagnosis.scoring.predictive import (
    Ensemble,
    Mixture,
    Noise,
    Part,
    bare_mission,
    explained,
    one_step_ahead,
    without_past,
)
from missionplan.diagnosis.scoring.yardsticks import (
    Chance,
    Point,
    one_step_chance,
    whole_chance,
    with_spread,
    yardsticks,
)
from missionplan.errors import InputError
from missionplan.mission import Mission, MissionOrPath
from missionplan.mission.views import MooringMission
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.profile import sensor_history
from missionplan.phases.transit.compensation import CompletedLeg, PlannedLeg
from missionplan.phases.transit.kalman_filter import DriftFilter
from missionplan.results.score import STATED, DatasetScore, Prediction, Score, Yardstick
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.store.folder import as_path
from missionplan.studies.run import Run, check_arguments


def expected_by_vehicle(data: TransitData, mission: Mission) -> list[Array] | None:
    """Run the mission's drift compensation along a log; expected error of each leg [m], None where there is none.

    The displacement at the surface that it expects after a leg is not part of the leg's error, and is left out.
    """
    scenario = Scenario.at_means(mission, recorded_current(mission))
    compensation = scenario.compensation(scenario.transit())
    if compensation is None:
        return None
    errors, last_run, memory = [], -1, compensation.begin(1)
    for leg in range(data.n):
        if data.run[leg] != last_run:
            memory, last_run = compensation.begin(1), int(data.run[leg])
        start, reckoned, end = (points[:, leg : leg + 1] for points in (data.start, data.dead_reckoned, data.end))
        t, duration, through = data.t_start[leg : leg + 1], data.under_way[leg : leg + 1], reckoned - start
        planned = PlannedLeg(t, start, through, duration, reckoned, 0.0)
        if isinstance(compensation, DriftFilter):
            expected = compensation.expected(memory, planned)[0] * duration
        else:
            expected = compensation.offset(memory, planned) - compensation.undershoot(memory, planned)
        errors.append(np.broadcast_to(expected, (2, 1))[:, 0])
        memory = compensation.update(
            memory,
            CompletedLeg((end - reckoned) / duration, duration, np.zeros((2, 1)), end - reckoned, t, start, through),
        )
    return errors


DRAWS = 256
"""Draws of the mission's uncertain quantities."""


def dive_ensemble(data: PreparedDives, mission: Mission, seed: int) -> Ensemble:
    """Return a mission's distribution of the depths of dives [m].

    Raises InputError when the mission lacks what a descent needs.
    """
    MooringMission.of(mission, depth=False)
    parts = []
    for share, plain_mission in explained(mission):
        drawn = Scenario.at_means(plain_mission).at_depth(0.0).sampled(seed=seed, block=0, size=DRAWS)
        trials = DRAWS if drawn.draws else 1
        expected = np.concatenate([_readings(log, drawn, trials) for log in data.dives]).T
        model = descent_model(data, plain_mission)
        spread = model.nuisance_sd(())  # nil for the mission's own effects: those are drawn
        noises = []
        for noise in noise_grid():
            covariance = model.covariance(model.base, noise, spread).dense()
            noises.append(Noise(float(np.exp(noise.log_prior)), covariance, np.ones(1), np.zeros(len(covariance))))
        parts.append(Part(share, expected, tuple(noises)))
    groups = np.repeat(np.arange(len(data.dives)), [len(log.t) for log in data.dives])
    return Ensemble(np.concatenate([log.depth for log in data.dives]), groups, tuple(parts))


def _readings(log: DiveLog, scenario: Scenario, trials: int) -> Array:
    """Run one dive in each draw; its readings, shape (m, trials) [m]."""
    weight, line = np.full(trials, log.wet_weight), np.full(trials, log.line_length)
    phase = scenario.moor().model_copy(update={"line_length": line, "lateral": "uncoupled"})
    dive = replace(dive_of(scenario, phase, weight), site_depth=NO_BOTTOM)
    effects = [effect for effect in scenario.effects_on_readings_too if isinstance(effect, DescentEffect)]
    history = sensor_history(dive, trials, float(log.fine[-1]), effects=effects, step=STEP)
    return DiveHistories((log,), history).readings(0.0)


FALSE_ALARM = 0.05
"""Probability, at most, with which a mission that is true is said to be outside chance, all data sets together."""
KINDS = ("transit", "descent")
Progress = Callable[[int, int], None]
"""Called with data sets done, of how many."""


def score(
    mission: MissionOrPath,
    *datasets: str | Path,
    seed: int | None = None,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Score:
    """Score how well a mission as it stands predicts data sets of legs or dives; nothing is fitted.

    Parameters
    ----------
    mission : Mission, str or Path
        With or without effects.
    *datasets : str or Path
        Folders of data sets of kind ``transit`` or ``descent``.
    seed : int, optional
        Of the draws; default the mission's.
    allow_outside : bool
        Whether a data set's table may lie outside its folder.
    progress : callable, optional
        Called with data sets done, of how many.

    Raises
    ------
    InputError
        When data set or mission lack what a prediction needs.
    """
    started = time.perf_counter()
    mission = check_arguments(mission, seed=seed)
    if not datasets:
        raise InputError("expected at least one data set to score the mission on")
    seed = mission.monte_carlo.seed if seed is None else seed
    folders = [as_path(dataset, "dataset") for dataset in datasets]
    level = FALSE_ALARM / (2 * len(folders))
    scores = []
    with threadpool_limits(limits=1), files_outside(allowed=allow_outside):
        for done, folder in enumerate(folders):
            record = read_record(folder, mission)
            then = as_then(record, mission, record.date)
            learned_count = int(is_learned(record, mission.learned_from).sum())
            scores.append(replace(scored_record(record, then, seed, level), learned=learned_count))
            if progress is not None:
                progress(done + 1, len(folders))
    provenance = Run("score", mission, 0, seed, started=started).provenance(
        {"datasets": [str(folder) for folder in folders]},
        datasets=folders,
        notices=(*mission.notices(), *dict.fromkeys(notice for score in scores for notice in score.notices)),
    )
    return Score(provenance, tuple(scores))


def read_record(folder: Path, mission: Mission) -> TransitData | PreparedDives:
    """Read the legs or dives of a data set.

    Raises InputError: all problems of the folder; when it holds neither.
    """
    if dataset_kind(folder, KINDS) == "transit":
        return read_transit(folder, mission)
    measured = read_descent(folder, mission)
    check_leaves_surface(measured, mission)
    return prepare_dives(measured)


def scored_record(
    record: TransitData | PreparedDives, mission: Mission, seed: int, level: float = 0.5 * FALSE_ALARM, past: int = 0
) -> DatasetScore:
    """Score a mission on a record.

    `level` is the probability with which each of the two predictions of a true mission is outside chance. The mission
    has learned from the first `past` legs or dives: the past of the others, which are scored.
    """
    if isinstance(record, TransitData):
        ensemble, bare = leg_ensemble(record, mission, seed), leg_ensemble(record, bare_mission(mission), seed)
        error = (record.end - record.dead_reckoned).T
        scales = [np.full(2, seconds) for seconds in record.under_way]
        first = float(np.sqrt(np.mean((without_past(ensemble).sd / np.repeat(record.under_way, 2)) ** 2)))
        others = yardsticks(
            list(error), lambda later, earlier: error[earlier] / scales[earlier] * scales[later], scales, first
        )
        expected = expected_by_vehicle(record, mission)
        if expected is not None:
            others["vehicle"] = with_spread(list(error), expected, scales, first)
        places = np.tile(["east", "north"], record.n - past)
        count, values = record.n - past, ensemble.later(past).values
        scores = _scored(ensemble, bare, others, 2, seed, level, past)
        return DatasetScore(
            record.name, "transit", count, np.repeat(record.labels[past:], 2), places, values, *scores, record.notices
        )
    return _score_dives(record, mission, seed, level, past)


def _score_dives(data: PreparedDives, mission: Mission, seed: int, level: float, past: int) -> DatasetScore:
    ensemble, bare = dive_ensemble(data, mission, seed), dive_ensemble(data, bare_mission(mission), seed)
    expected = without_past(bare)
    apart = [(ensemble.values - expected.mean)[rows] for rows in ensemble.slices()]
    times = [log.t for log in data.dives]

    def carried(later: int, earlier: int) -> Array:
        return np.asarray(np.interp(times[later], times[earlier], apart[earlier]))

    first = float(np.sqrt(np.mean(without_past(ensemble).sd ** 2)))
    others = {
        name: replace(point, mean=point.mean + expected.mean)
        for name, point in yardsticks(apart, carried, [np.ones_like(curve) for curve in apart], first).items()
    }
    dives, values = data.dives[past:], ensemble.later(past).values
    places = np.concatenate([np.char.mod("%.2f", log.t) for log in dives])
    labels = np.concatenate([np.full(len(log.t), log.name) for log in dives])
    scores = _scored(ensemble, bare, others, 1, seed, level, past)
    return DatasetScore(data.name, "descent", len(dives), labels, places, values, *scores, data.notices)


def _scored(
    ensemble: Ensemble, bare: Ensemble, others: dict[str, Point], axes: int, seed: int, level: float, past: int
) -> tuple[Prediction, Prediction, float]:
    """Score both predictions beside the yardsticks; `axes` values are the components of one error."""
    conditional, unknown = ensemble.after(past), ensemble.later(past)
    y, rows = conditional.values, slice(len(ensemble.values) - len(conditional.values), None)
    ahead, whole = one_step_ahead(conditional), without_past(unknown)
    plain_ahead = one_step_ahead(bare).mixture.of(rows)
    chance = one_step_chance(conditional, ahead, seed, level)
    common = {}
    for name, point in others.items():
        mixture = Mixture(np.ones((1, len(point.mean))), point.mean[None], np.maximum(point.sd, 1e-9)[None])
        common[name] = _yardstick(mixture.of(rows), y, axes)
    plain = {"no_effects": _yardstick(plain_ahead, y, axes)}
    one_step = _prediction(ahead.mixture, y, axes, chance, level, {**plain, **common})
    chance = whole_chance(unknown, whole, seed, level)
    plain = {"no_effects": _yardstick(without_past(bare).of(rows), y, axes)}
    return one_step, _prediction(whole, y, axes, chance, level, {**plain, **common}), ahead.effective


def _yardstick(mixture: Mixture, y: Array, axes: int) -> Yardstick:
    rmse = float(np.sqrt(axes * np.mean((y - mixture.mean) ** 2)))
    return Yardstick(rmse, float(np.mean(mixture.log_density(y))), float(np.mean(mixture.crps(y))))


def _prediction(
    mixture: Mixture, y: Array, axes: int, chance: Chance, level: float, others: dict[str, Yardstick]
) -> Prediction:
    scores, pit = _yardstick(mixture, y, axes), mixture.cdf(y)
    inside_50, inside_90 = (int(np.count_nonzero(np.abs(pit - 0.5) <= 0.5 * share)) for share in (0.5, STATED))
    z = (y - mixture.mean) / mixture.sd
    return Prediction(
        scores.rmse,
        scores.log_score,
        scores.crps,
        inside_50,
        inside_90,
        chance.coverage_90,
        chance.p_value,
        level,
        mixture.mean,
        mixture.sd,
        z,
        pit,
        others,
    )
