"""Report of `score`: how well a mission as it stands predicts measured data."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.ticker import MaxNLocator

from missionplan.errors import InputError, Problem, counted, shown
from missionplan.montecarlo.statistics import wilson
from missionplan.report.axes import name_axis
from missionplan.report.diagnosis.kind_report import part, percent
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, Page, PageSection, Table, to_figure, typed
from missionplan.report.quantities import quantity
from missionplan.results.score import PIT_BINS, STATED, DatasetScore, Prediction, Score, pit_counts

Q90 = 1.645
"""Normal quantile: half the width of a 90 % interval in standard deviations."""


def prediction_figure(data: DatasetScore) -> Figure:
    """Draw what was measured with both predictions and their 90 % bands."""
    legs = data.kind == "transit"
    figure = MatplotlibFigure(figsize=(6.4, 4.4))
    panels = figure.subplots(2, 1, sharex=True, sharey=not legs)
    for component, axes in enumerate(panels):
        _panel(axes, data, component)
    panels[0].set_xlabel("")
    panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=9, frameon=False, ncols=3)
    what = "Position errors of the legs" if legs else "Departures of the depths from what was expected"
    return to_figure(
        figure,
        "predictions",
        alt=f"{what} with the mission's predictions",
        caption=f"{what} (points) and the mission's 90 % bands: blue one step ahead, grey without the past.",
    )


def draw_predictions(axes: Axes, score: Score, dataset: int = 0, part: int = 0) -> None:
    """Draw a data set of the score, by its number.

    `part`: of legs, 0 for errors east and 1 for north; of dives, 0 for one step ahead and 1 for all the way.
    """
    for index, most, key in ((dataset, len(score.datasets), "dataset"), (part, 2, "part")):
        if not isinstance(index, int) or not 0 <= index < most:
            raise InputError([Problem(f"given {shown(index)}, expected 0 to {most - 1}", key=key)])
    _panel(axes, score.datasets[dataset], part)
    axes.legend()


def _panel(axes: Axes, data: DatasetScore, part: int) -> None:
    if data.kind == "transit":
        _leg_panel(axes, data, part)
        axes.set_xlabel("Leg")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    else:
        _dive_panel(axes, data, list(data.predictions.values())[part], ("one step ahead", "all the way")[part])
        axes.set_xlabel("Reading, dive after dive")


def _leg_panel(axes: Axes, data: DatasetScore, axis: int) -> None:
    rows = slice(axis, None, 2)
    at = np.arange(data.groups) + 1
    unit, word = (1000.0, "km") if np.max(np.abs(data.measured)) > 2000.0 else (1.0, "m")
    for prediction, colour, label in ((data.whole, GREY, "all the way"), (data.one_step, BLUE, "one step ahead")):
        mean, sd = prediction.mean[rows] / unit, prediction.sd[rows] / unit
        axes.fill_between(at, mean - Q90 * sd, mean + Q90 * sd, color=colour, alpha=0.25, linewidth=0.0, label=label)
    axes.plot(at, data.measured[rows] / unit, ".", color=ORANGE, markersize=4.0, label="measured")
    name_axis(axes.yaxis, f"{('East', 'North')[axis]} error", word)


def _dive_panel(axes: Axes, data: DatasetScore, prediction: Prediction, title: str) -> None:
    at, left = np.arange(len(data.measured)) + 1, data.measured - prediction.mean
    axes.fill_between(
        at, -Q90 * prediction.sd, Q90 * prediction.sd, color=BLUE, alpha=0.25, linewidth=0.0, label="90 %"
    )
    axes.plot(at, left, ".", color=ORANGE, markersize=3.0, label="measured")
    name_axis(axes.yaxis, "Error", "m")
    axes.set_title(title, fontsize=9)


def pit_figure(data: DatasetScore) -> Figure:
    """Draw histograms of the probability integral transforms, which are flat where the predictions are right."""
    figure = MatplotlibFigure(figsize=(6.4, 2.5))
    panels = figure.subplots(1, 2, sharey=True)
    expected = len(data.measured) / PIT_BINS
    spread = 1.645 * np.sqrt(expected * (1.0 - 1.0 / PIT_BINS))
    for axes, (title, prediction) in zip(
        panels, (("one step ahead", data.one_step), ("all the way", data.whole)), strict=True
    ):
        at = (np.arange(PIT_BINS) + 0.5) / PIT_BINS
        axes.bar(at, pit_counts(prediction.pit), width=0.9 / PIT_BINS, color=BLUE)
        axes.axhspan(max(expected - spread, 0.0), expected + spread, color=GREY, alpha=0.25, linewidth=0.0)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("Probability of less")
    panels[0].set_ylabel("Values")
    slug = "".join(letter if letter.isalnum() else "-" for letter in data.name.lower())[:40].strip("-")
    return to_figure(
        figure,
        f"pit-{data.kind}-{slug}",
        alt="Histograms of the probability integral transforms",
        caption=(
            "Where each value fell in its predicted distribution. Right predictions are flat; the grey band holds "
            "90 % of independent bins. Heaps at both ends: intervals too narrow; a heap in the middle: too wide."
        ),
    )


NAMES = {"one_step": "one step ahead", "whole": "all the way"}
EXPLAINED = {
    "one_step": "One step ahead: each {group} from those before it in the record, as the vehicle could.",
    "whole": "All the way: every {group} from nothing of the record, as the plan must.",
}
GROUPS = {"transit": ("leg", "legs"), "descent": ("dive", "dives")}
YARDSTICKS = {
    "no_effects": "the mission without its effects",
    "mean_of_past": "the mean of the past",
    "last_leg": "the last {group}",
    "random_walk": "a random walk seen through noise",
    "persistent": "a stationary persistent error",
    "wider_sigma": "a plain σ as wide as the errors so far",
    "vehicle": "the vehicle's own drift compensation",
}
SAME = 0.03
"""Skills that are as good as one another."""
_TWICE = 1.0
"""Loss against the last leg from which it is told as a multiple."""
_FAR = 0.15
"""From 50 %, beyond which the coverage of the 50 % intervals is told too."""
SHARES = ((0.8, "four fifths"), (2 / 3, "two thirds"), (0.5, "half"), (1 / 3, "a third"), (0.25, "a quarter"))


def page(score: Score) -> Page:
    """Build the page of a score."""
    made = score.provenance
    folders = made.options["datasets"]
    named = folders if isinstance(folders, list) else []
    table = _overview(score) if len(score.datasets) > 1 else _table(score.datasets[0])
    as_good = all(data.one_step.skill("last_leg") > -SAME for data in score.datasets)
    return Page(
        title=f"How well {made.mission} predicts what was measured",
        answer=answer(score),
        draw=lambda: prediction_figure(score.datasets[0]),
        numbers=_numbers(score.datasets[0]),
        write=lambda: [
            *([PageSection("All data sets", [_overview(score)])] if len(score.datasets) > 1 else []),
            *(section for data in score.datasets for section in dataset_sections(data)),
        ],
        verdict="bad" if not score.is_within_chance else "good" if as_good else "undecided",
        rerun=typed("score", made.file, *named, seed=made.seed),
        table=lambda: (table.columns, table.rows),
        plots={"predictions": draw_predictions},
    )


def answer(score: Score) -> str:
    """Say how well the next leg or dive is predicted, against the last one, and what the intervals hold."""
    said = []
    for data in score.datasets[:3]:
        one, many = GROUPS[data.kind]
        which = f"all {data.groups} {many}"
        which = which if data.learned == data.groups else f"{counted(data.learned, one)} of {data.groups}"
        learned = f" It has learned from {which}: that is no prediction of data held out." if data.learned else ""
        said.append(f"{told(data)}{learned}")
    if len(score.datasets) == 1:
        words = f"This mission {said[0]}"
    else:
        words = " ".join(f"{data.name}: this mission {how}" for data, how in zip(score.datasets, said, strict=False))
    if (more := len(score.datasets) - len(said)) > 0:
        words += f" {counted(more, 'more data set')} below."
    if score.is_within_chance:
        return f"{words} Nothing was fitted; chance allows where in their distributions the values fell."
    off = [NAMES[name] for data in score.datasets for name, p in data.predictions.items() if not p.is_within_chance]
    where = f"where in their distributions the values fell ({', '.join(dict.fromkeys(off))})"
    return f"{words} Chance does not allow {where}: they are wrong."


def told(data: DatasetScore) -> str:
    """Say how a data set was predicted, after the words "this mission"."""
    one, ahead = GROUPS[data.kind][0], data.one_step
    inside = f"its 90 % intervals hold {part(ahead.coverage_90)} of what was measured"
    if abs((half := ahead.inside_50 / len(ahead.z)) - 0.5) > _FAR:
        inside += f", its 50 % intervals {part(half)}"
    if not data.whole.is_within_chance:
        inside += f", its 90 % intervals without the past {part(data.whole.coverage_90)}"
    return f"predicts the next {one} to {_metres(ahead.rmse)}, {_against(ahead.skill('last_leg'), one)}; {inside}."


def _against(skill: float, one: str) -> str:
    """Put a skill against the last leg in words."""
    if abs(skill) < SAME:
        return f"as well as the last {one} would"
    if skill <= -_TWICE:
        return f"{1.0 - skill:.1f} times the error that the last {one} would give"
    near = next((word for share, word in SHARES if abs(abs(skill) - share) < SAME), part(abs(skill)))
    return f"{near} {'better' if skill > 0.0 else 'worse'} than the last {one} would"


def _metres(value: float) -> str:
    return quantity(value / 1000.0, "km", ".2f") if value >= 1000.0 else quantity(value, "m", ".3g")


def _overview(score: Score) -> Table:
    rows = [
        [
            data.name,
            NAMES[name],
            str(data.groups),
            _metres(prediction.rmse),
            f"{100.0 * prediction.skill('last_leg'):.0f} %",
            f"{prediction.log_score:.2f}",
            _held(prediction.inside_90, len(prediction.z)),
            "yes" if prediction.is_within_chance else "no",
        ]
        for data in score.datasets
        for name, prediction in data.predictions.items()
    ]
    quality = ("Error, rms", "Skill against the last", "Log score", "In 90 %", "Chance")
    return Table(("Data set", "Prediction", "Groups", *quality), rows, "Groups are legs or dives.", text_columns=2)


def _held(inside: int, count: int) -> str:
    interval = wilson(inside, count)
    return f"{100.0 * inside / count:.0f} % ({100.0 * interval.low:.0f} to {100.0 * interval.high:.0f})"


def _numbers(data: DatasetScore) -> list[tuple[str, str]]:
    one, _ = GROUPS[data.kind]
    ahead = data.one_step
    return [
        (f"Error of the next {one}, rms", _metres(ahead.rmse)),
        ("90 % intervals, one step ahead", _held(ahead.inside_90, len(ahead.z))),
        ("90 % intervals, all the way", _held(data.whole.inside_90, len(data.whole.z))),
    ]


def _table(data: DatasetScore) -> Table:
    one, many = GROUPS[data.kind]
    rows = []
    for name, prediction in data.predictions.items():
        rows.append(
            [
                f"this mission, {NAMES[name]}",
                _metres(prediction.rmse),
                "",
                f"{prediction.log_score:.2f}",
                _metres(prediction.crps),
                _held(prediction.inside_50, len(prediction.z)),
                _held(prediction.inside_90, len(prediction.z)),
            ]
        )
        bare = prediction.yardsticks["no_effects"]
        if (bare.rmse, bare.log_score) != (prediction.rmse, prediction.log_score):  # the mission has effects
            label = f"{YARDSTICKS['no_effects']}, {NAMES[name]}"
            rows.append(_row(label, bare.rmse, prediction.skill("no_effects"), bare.log_score, bare.crps))
    for name, other in data.one_step.yardsticks.items():
        if name != "no_effects":
            label = YARDSTICKS[name].format(group=one)
            rows.append(_row(label, other.rmse, data.one_step.skill(name), other.log_score, other.crps))
    caption = (
        f"Skill: the part of a yardstick's error that the mission avoids, one step ahead but for the last row without "
        f"effects. Log scores are means over {len(data.measured)} values (greater is better), CRPS likewise (less is "
        f"better). Yardsticks predict {many} from those before, with the spread of their own errors so far."
    )
    columns = ["Prediction", "Error, rms", "Skill", "Log score", "CRPS", "In 50 %", "In 90 %"]
    return Table(columns, rows, caption)


def _row(label: str, rmse: float, skill: float, log_score: float, crps: float) -> list[str]:
    return [label, _metres(rmse), f"{100.0 * skill:.0f} %", f"{log_score:.2f}", _metres(crps), "", ""]


def dataset_sections(data: DatasetScore, name: str = "") -> list[PageSection]:
    """Show the scores of a data set beside yardsticks; `name` stands for its own."""
    name = name or data.name
    one, _ = GROUPS[data.kind]
    words = []
    for which, prediction in data.predictions.items():
        low, high = prediction.chance_90
        words.append(
            f"{EXPLAINED[which].format(group=one)} Its {100.0 * STATED:.0f} % intervals hold "
            f"{100.0 * prediction.coverage_90:.0f} % of the values; were the mission true, chance would leave "
            f"{100.0 * low:.0f} to {100.0 * high:.0f} %. Of the records of a true mission "
            f"{percent(prediction.p_value)} fall as unevenly into its distributions. Errors over their standard "
            f"deviations have a mean of {prediction.z.mean():.2f} and a standard deviation of {prediction.z.std():.2f}."
        )
    return [
        PageSection(f"{name}: scores beside yardsticks", [_table(data), *words, _ASSUMED[data.kind]]),
        PageSection(f"{name}: where in their distributions the values fell", [pit_figure(data)]),
    ]


_ASSUMED = {
    "transit": (
        "Expected errors and their covariances come from the transit that simulate runs, along the legs as they "
        "were logged. The past is taken in as if the expected errors were normal about their mean."
    ),
    "descent": (
        "Expected depths come from the descent that simulate runs. Sensor, turbulence and scatter from dive to dive "
        "are those that the diagnosis assumes. The past is taken in as if the expected depths were normal about "
        "their mean."
    ),
}
