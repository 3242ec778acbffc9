"""Rows that ask whether what is said with a probability is right as often as it says.

Data are made by code that shares nothing with the models (`tests.calibration`, `tests.hidden_effects`, `tests.fleets`,
`tests.next_trial`, `tests.next_mission`, `tests.regret`); long rows keep each case as a line of a file in the work
folder.
"""

import json
import math
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rare import four_legs
from missionplan.mission import load
from missionplan.scenario.scenario import Scenario
from missionplan.studies.rare_failure import find_rare_failure
from missionplan.studies.simulation.simulate import simulate
from missionplan.studies.simulation.trial_block import run_block
from missionplan.studies.tide.harmonic_analysis import Samples, fit_tide, tidal_velocity
from validation.rows import Measured, Options, at_least, at_most, between, reported, row


def lines(file: Path, wanted: Iterable[Any], made: Callable[[Any], object]) -> list[Any]:
    """Make a line for every case that a file lacks, and return all of them as they stand there."""
    kept = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    for case in list(wanted)[len(kept) :]:
        kept.append(json.dumps(made(case), default=bool))
        with file.open("a", encoding="utf-8") as end:
            end.write(kept[-1] + "\n")
    return [json.loads(line) for line in kept]


LEGS, OUTSIDE, LEGS_SEED = 40, 10, 92_000_000


@row(
    "calibration.legs",
    "Probabilities of causes and intervals of a diagnosis of legs are what they say",
    case=f"{LEGS} logs of 12 to 69 legs with truths drawn from the stated prior, a quarter on half the compass; "
    f"{OUTSIDE} with something outside the catalogue",
    reference="`tests.calibration`: logs sailed in steps by code of its own",
    seed=LEGS_SEED,
    accepted=[
        at_most("expected calibration error", 0.03),
        at_least("truth in the 95 % set", 0.85),
        at_most("mean size of the set", 2.0),
        between("parameters in 90 % intervals", 0.75, 1.0),
        between("fresh legs in 90 % intervals", 0.85, 0.95),
        between("fresh legs in 50 % intervals", 0.44, 0.58),
        reported("AUC of `none_of_these`, outside against inside"),
    ],
    cost=250.0,
)
def _legs(options: Options) -> Measured:
    from tests.calibration.__main__ import figures, record

    wanted = [(LEGS_SEED + k, False) for k in range(LEGS)] + [(LEGS_SEED + k, True) for k in range(OUTSIDE)]
    found = lines(options.work / "calibration.legs.jsonl", wanted, lambda case: record(*case))
    seen = figures(found)
    names = ("ece", "in_set", "set_size", "parameters_90", "fresh_90", "fresh_50", "none_auc")
    return Measured([seen[name] for name in names], _reliability(found))


def _reliability(found: list[Any]) -> Any:
    """Draw how often a set of causes is the truth against its probability."""
    import matplotlib.pyplot as plt

    from missionplan.report.page import style

    pairs = [(p, causes == each["truth"]) for each in found if not each["outside"] for causes, p in each["sets"]]
    p, right = np.array(pairs, dtype=float).T
    edges = np.array([0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0])
    bins = np.digitize(p, edges[1:-1])
    with style():
        figure, axes = plt.subplots(figsize=(4.5, 3.8), layout="constrained")
        axes.plot([0.0, 1.0], [0.0, 1.0], color="0.6", linewidth=1.0)
        for each in np.unique(bins):
            own = bins == each
            share, count = right[own].mean(), int(own.sum())
            error = 1.96 * math.sqrt(max(share * (1.0 - share), 0.25 / count) / count)
            axes.errorbar(p[own].mean(), share, error, fmt="o", color="C0")
            axes.annotate(f"{count}", (p[own].mean(), share), textcoords="offset points", xytext=(6, -10), fontsize=8)
        axes.set(xlabel="probability of a set of causes", ylabel="share that is the truth", ylim=(-0.05, 1.05))
        plt.close(figure)
    return figure


def _hidden(options: Options, which: str, cases: int, seed: int) -> dict[str, float]:
    """Diagnose sets with hidden effects; the figures by name."""
    from tests.hidden_effects import further, score
    from tests.hidden_effects.tool import diagnose

    def made(argument: further.Argument) -> object:
        with tempfile.TemporaryDirectory() as folder:
            case = further.draw(*argument)
            outcome = diagnose(case, Path(folder) / "cases", Path(folder) / "truths", in_process=True)
        return json.loads(further.line_of(outcome))

    file = options.work / f"calibration.hidden-{which}.jsonl"
    outcomes = [further.outcome_of(json.dumps(each)) for each in lines(file, further.plan(cases, seed, which), made)]
    return {each.name: each.value for each in score.figures(outcomes)}


_HIDDEN = (
    "runs that failed",
    "false alarms without an effect",
    "right cause claimed, modulo exact ties",
    "true cause in the 95 % set",
    "mean size of the 95 % set",
    "two effects: both claimed",
    "two effects: true pair in the 95 % set",
    "wrong cause claimed for a weak effect",
    "90 % intervals cover",
)
_HIDDEN_ACCEPTED = [
    at_most("runs that failed", 0.0),
    at_most("false alarms without an effect", 0.1),
    at_least("right cause claimed", 0.85),
    at_least("true cause in the 95 % set", 0.9),
    at_most("its mean size", 2.0),
    at_least("both of two effects claimed", 0.4),
    at_least("true pair in the 95 % set", 0.6),
    at_most("wrong cause claimed for a weak effect", 0.2),
    between("90 % intervals cover", 0.8, 1.0),
]


@row(
    "calibration.hidden-legs",
    "A hidden effect in navigation logs is found, and none where there is none",
    case="32 logs with one, two, weak or no effects, or one outside the catalogue",
    reference="`tests.hidden_effects`: files by code that shares nothing with the model",
    seed=79_000_000,
    accepted=_HIDDEN_ACCEPTED,
    cost=200.0,
)
def _hidden_legs(options: Options) -> list[float]:
    found = _hidden(options, "transit", 32, 79_000_000)
    return [found[name] for name in _HIDDEN]


@row(
    "calibration.hidden-dives",
    "A hidden effect in dives is found, and none where there is none",
    case="24 sets with one, two, weak or no effects, or one outside the catalogue",
    reference="`tests.hidden_effects`: files by code that shares nothing with the model",
    seed=79_100_000,
    accepted=_HIDDEN_ACCEPTED,
    cost=250.0,
)
def _hidden_dives(options: Options) -> list[float]:
    found = _hidden(options, "descent", 24, 79_100_000)
    return [found[name] for name in _HIDDEN]


@row(
    "calibration.tank",
    "A hidden effect in tank data is found, and none where there is none",
    case="40 sets: towing, oscillation, thrusters, propeller; half of them without an effect",
    reference="`tests.hidden_effects.tank`",
    seed=9_700_000,
    accepted=[at_most("false alarms", 0.1), at_least("right cause at five standard errors or more", 0.95)],
    cost=100.0,
)
def _tank(_: Options) -> list[float]:
    from tests.hidden_effects import tank
    from tests.hidden_effects.tool import diagnose

    with tempfile.TemporaryDirectory() as folder:
        seen, truths = Path(folder) / "seen", Path(folder) / "truths"
        outcomes = [diagnose(case, seen, truths, in_process=True) for case in tank.cases(40, 9_700_000)]
    _text, alarms, right = tank.summary(outcomes)
    return [alarms, right]


def _sizes(options: Options, kind: str, sets: int, seed: int) -> list[float]:
    """Fit effects of known sizes; mean error of the usual size and more, its greatest, and coverage."""
    from tests import effect_sizes
    from tests.effect_sizes import __main__ as sizes

    assert effect_sizes.__doc__
    plan = list(sizes.plan(kind, sets, seed, ""))

    def made(case: tuple[str, float, int]) -> object:
        name, size, own = case
        return {"effect": name, "size": size, "seed": own, "estimates": sizes.fitted(sizes.draw(own, kind, name, size))}

    found = lines(options.work / f"calibration.sizes-{kind}.jsonl", plan, made)
    usual = {name: sizes.SIZES[kind][name][1:3] for name in sizes.SIZES[kind]}
    groups: dict[str, list[dict[str, Any]]] = {}
    for line in found:
        if line["size"] in usual[line["effect"]]:
            for each in line["estimates"]:
                if "refused" not in each:
                    groups.setdefault(f"{line['effect']} {each['name']}", []).append(each)
    errors = []
    for own in groups.values():
        true, value = (np.array([each[key] for each in own]) for key in ("true", "value"))
        sign = np.where(true < 0.0, -1.0, 1.0)
        errors.append(float(np.mean(sign * (value - true)) / np.sqrt(np.mean(true**2))))
    every = [each for own in groups.values() for each in own]
    held = np.mean([each["low"] <= each["true"] <= each["high"] for each in every])
    return [float(np.median(np.abs(errors))), float(np.max(np.abs(errors))), float(held), float(len(every))]


_SIZES = [
    at_most("mean error of an effect, median", 0.05, "of the size"),
    reported("greatest", "of the size"),
    between("90 % intervals hold", 0.82, 0.98),
    reported("estimates"),
]


@row(
    "calibration.sizes-legs",
    "The size of an effect on legs comes out, cause given",
    case="twelve effects of their usual size and three times it, two logs each",
    reference="`tests.effect_sizes`: the size put into the file",
    seed=77_500_000,
    accepted=_SIZES,
    cost=200.0,
)
def _sizes_legs(options: Options) -> list[float]:
    return _sizes(options, "transit", 2, 77_500_000)


@row(
    "calibration.sizes-dives",
    "The size of an effect on dives comes out, cause given",
    case="seven effects of their usual size and three times it, two sets each",
    reference="`tests.effect_sizes`: the size put into the file",
    seed=77_600_000,
    accepted=_SIZES,
    cost=200.0,
)
def _sizes_dives(options: Options) -> list[float]:
    return _sizes(options, "descent", 2, 77_600_000)


@row(
    "calibration.sizes-tank",
    "The size of an effect in a tank comes out, cause given",
    case="seven effects of their usual size and three times it, four sets each",
    reference="`tests.effect_sizes`: the size put into the file",
    seed=77_700_000,
    accepted=_SIZES,
    cost=60.0,
)
def _sizes_tank(options: Options) -> list[float]:
    return _sizes(options, "tank", 4, 77_700_000)


_QUADRATURE = {0.097: 5.18e-7, 0.12: 1.088e-4}
"""Of the miss of the four legs of `benchmarks.rare` over Rice's distributions, by velocity error [m/s]."""


@row(
    "calibration.rare-mission",
    "The probability of a rare failure of a mission, and its interval",
    case="four legs to 800 m, σ_v = 0.12 and 0.097 m/s; 16 searches each",
    reference="quadrature over Rice's distributions: 1.088·10⁻⁴ and 5.18·10⁻⁷; a loop in numpy: (5.9 ± 0.4)·10⁻⁷",
    seed=101,
    accepted=[
        between("mean over quadrature at 10⁻⁴", 0.92, 1.08),
        between("mean over quadrature at 5·10⁻⁷", 0.85, 1.15),
        at_least("95 % intervals hold", 0.75),
    ],
    cost=25.0,
)
def _rare_mission(_: Options) -> list[float]:
    means, held = {}, []
    for sigma in (0.12, 0.097):
        truth, mission = _QUADRATURE[sigma], four_legs(sigma)
        found = [find_rare_failure(mission, trials=1_000_000, seed=seed).probability for seed in range(101, 117)]
        means[sigma] = float(np.mean([each.value for each in found])) / truth
        held += [each.low <= truth <= each.high for each in found]
    return [means[0.12], means[0.097], float(np.mean(held))]


@row(
    "calibration.tide-forecast",
    "A month of a record forecasts the tide of the next, and its spread is right",
    case="20 made records with weather, gaps and eight constituents",
    reference="Schureman's and Meeus's series, which share nothing with UTide's tables",
    seed=601,
    accepted=[
        at_most("variance lost, mean", 0.02),
        at_most("variance lost, greatest", 0.03),
        between("in the stated 90 %", 0.85, 0.95),
    ],
    cost=30.0,
)
def _tide(_: Options) -> list[float]:
    from tests.studies.tide import test_find_tide as made

    lost, inside, latitude = [], [], math.radians(37.2)
    for seed in range(601, 621):
        seconds, known, noise, rng = made.made_record(seed)
        first = seconds < seconds[0] + 30.0 * made.DAY
        taken = first & made.with_gaps(rng, seconds)
        fit = fit_tide(Samples(seconds[taken], (known + noise)[:, taken], latitude))
        forecast = fit.mean[:, None] + tidal_velocity(fit.constituents, seconds[~first], latitude)
        truth = known[:, ~first]
        lost.append(float(np.mean((forecast - truth) ** 2) / np.mean(truth**2)))
        inside.append(float(np.mean(np.abs(forecast - truth - noise[:, ~first]) < 1.645 * fit.spread)))
    return [float(np.mean(lost)), max(lost), float(np.mean(inside))]


@row(
    "calibration.search-areas",
    "Search areas and hours to worry hold the trials of another seed",
    case="ten legs in a current of 0.3 ± 0.1 m/s, 4096 trials each",
    reference="trials that the areas were not made from",
    seed=2,
    accepted=[
        at_most("areas: share that they hold less what they say, greatest", 0.04),
        at_most("times: share back less what they say, greatest", 0.03),
    ],
    cost=20.0,
)
def _search_areas(_: Options) -> list[float]:
    from tests.studies.simulation import test_overdue as sheet

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drifting.yaml"
        path.write_text(sheet.DRIFTING, encoding="utf-8")
        mission = load(path)
    outcome = simulate(mission)
    others = run_block(Scenario.at_means(mission).sampled(seed=2, block=0), 2, 0, 4096, tracked=4096)
    assert outcome.overdue is not None
    duration, back = others.total["duration_s"][others.success], outcome.overdue.times[-1]
    late = [
        abs(float(np.mean(duration <= time)) - share)
        for share, time in ((0.5, back.p50), (0.95, back.p95), (0.99, back.p99))
    ]
    failed = ~others.success
    track, time = others.phases[0].track[-1], others.phases[0].track_time[-1]
    east, north, away = np.sin(np.radians(60.0)), np.cos(np.radians(60.0)), []
    for area in outcome.overdue.areas:
        if area.way == "adrift at the surface":
            elapsed = outcome.overdue.worry_after + area.overdue - time[failed]
            gone = others.draws["site.current[0].speed"][failed] * np.maximum(elapsed, 0.0)
            places = track[:, failed] + np.stack((east * gone, north * gone))
            away.append(abs(float(np.mean(sheet.inside(area, places))) - area.share))
    return [max(away), max(late)]


@row(
    "calibration.time-to-find",
    "A search by the sheet finds a vehicle adrift sooner than one about the last fix",
    case="1000 losses each in three seas, wind of 5, 6 and 12 m/s; boat of 5 m/s, sweep width 200 m, a day at most",
    reference="expanding square from the last fix; losses carried by the published equations of leeway",
    seed=12,
    accepted=[at_least("sooner, least", 0.3), reported("by the sheet, longest", "h"), reported("by the square", "h")],
    cost=10.0,
)
def _time_to_find(_: Options) -> list[float]:
    from tests.studies.simulation import test_time_to_find as searched

    found = np.array([searched.times_to_find(*sea) for sea in searched.SEAS]).mean(axis=2) / 3600.0
    return [float((1.0 - found[:, 0] / found[:, 1]).min()), float(found[:, 0].max()), float(found[:, 1].min())]


@row(
    "calibration.fleets",
    "Levels of a vehicle are told at their dates, with their trends and jumps",
    case="40 vehicles, six missions of 24 legs, a compass or a log that stays, drifts, jumps or is drawn anew",
    reference="`tests.fleets`: angle and pace put in; a fresh start each time",
    seed=9_500,
    accepted=[
        between("90 % intervals hold", 0.84, 0.97),
        *(reported(f"of both levels where one is {way}") for way in ("constant", "drifting", "jumping", "redrawn")),
        at_least("least gain over a fresh start of the four", 0.0, "nats"),
        at_least("trends and jumps named", 0.8),
        at_most("vehicles with a false trend", 0.05),
    ],
    cost=700.0,
)
def _fleets(options: Options) -> list[float]:
    from dataclasses import asdict

    from tests.fleets import __main__ as fleets

    found = lines(options.work / "calibration.fleets.jsonl", range(9_500, 9_540), lambda seed: asdict(fleets.run(seed)))
    return _fleet_figures(found)


def _fleet_figures(found: list[Any]) -> list[float]:
    ways = [found[first::4] for first in range(4)]
    held = [float(np.mean([inside for each in own for inside in (*each["held"], *each["beside"])])) for own in ways]
    gains = [float(np.mean([gain for each in own for gain in each["gains"]])) for own in ways]
    named = [bool(value) for each in found for value in (each["trend"], each["jump"]) if value is not None]
    false = float(np.mean([each["false_trend"] for each in found]))
    return [float(np.mean(held)), *held, min(gains), float(np.mean(named)), false]


@row(
    "calibration.next-trial",
    "What a further trial is said to tell is what it tells",
    case="100 campaigns of legs, truths drawn from the stated prior",
    reference="`tests.next_trial`: the trial and the missions sailed by code of its own",
    seed=5_700,
    accepted=[
        between("realised on predicted information, slope", 0.75, 1.25),
        reported("its standard error"),
        reported("saving predicted, mean", "min"),
        reported("saving realised, mean", "min"),
        reported("error of that", "min"),
        reported("probability said to do what is right about the vehicle after the trial, mean"),
        reported("share that does"),
        at_most("said less done", 0.05),
    ],
    cost=900.0,
)
def _next_trial(options: Options) -> list[float]:
    from tests.next_trial import campaign
    from tests.next_trial.__main__ import slope

    found = [
        each for seed in range(5_700, 5_800) for each in campaign.recorded(options.work / "next", seed, campaign.made)
    ]
    kept = [each for each in found if each.among]
    information = slope(
        [each.expected for each in kept],
        [each.gained for each in kept],
        [each.seed for each in kept],
        [each.weight for each in kept],
    )
    names = ("saving", "saved", "said", "right")
    table = np.array([[float(getattr(each, name)) for name in names] for each in found])
    weight = np.array([each.weight for each in found])
    saving, saved, said, right = np.average(table, axis=0, weights=weight).tolist()
    error = float(np.sqrt(np.sum((weight * (table[:, 1] - saved)) ** 2)) / weight.sum())
    return [*information, saving, saved, error, said, right, said - right]


@row(
    "calibration.next-mission",
    "What is planned after a diagnosis comes to pass",
    case="60 seas of a compass, a log, a current and a tide that may each be off: a log of 12 to 39 legs, its "
    "diagnosis, and a transit of 6 km a week later, another way; one draw each",
    reference="`tests.next_mission`: log and transit sailed by code of its own",
    seed=7_000,
    accepted=[
        between("duration within the 90 % interval", 0.82, 0.97),
        between("within the 50 % interval", 0.37, 0.68),
        reported("within the 90 % interval of the mission without the diagnosis"),
        reported("within its 50 % interval"),
        at_most("ranked probability score over that without the diagnosis", 0.9),
    ],
    cost=400.0,
)
def _next_mission(options: Options) -> list[float]:
    from tests.next_mission import __main__ as loop

    return loop.figures(lines(options.work / "calibration.next-mission.jsonl", range(7_000, 7_060), loop.made))


@row(
    "calibration.regret",
    "A doubt carried into the plan costs little",
    case="40 ambiguous sets of dives and legs, planned with the averaged mission, the best cause and the base model",
    reference="`tests.regret`: the choice that knows the truth",
    seed=610_000,
    accepted=[
        at_most("mean loss with the averaged mission", 0.04),
        reported("best cause"),
        reported("base model"),
    ],
    cost=800.0,
)
def _regret(options: Options) -> list[float]:
    from tests.regret import __main__ as regret

    found = lines(options.work / "calibration.regret.jsonl", range(610_000, 610_060), regret.run_case)
    doubtful = [each["regret"] for each in found if each.get("regret")][:40]
    return [float(np.mean([each[way] for each in doubtful])) for way in regret.WAYS]
