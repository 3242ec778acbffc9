"""Report of `diagnose`: the verdict in a sentence, the picture, the gain, what to do next; then what supports it."""

import math
import shlex
from collections.abc import Sequence

from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.causes import causes_section, names
from missionplan.report.diagnosis.figures import (
    discrepancy_figure,
    held_out_figure,
    main_figure,
    ranking_figure,
)
from missionplan.report.diagnosis.plan import plan_section, plan_words
from missionplan.report.diagnosis.residual_figures import residual_figures
from missionplan.report.diagnosis.tank_figures import TANK_UNITS
from missionplan.report.page import Block, Page, PageSection, Table, Terminal
from missionplan.results.diagnosis import Diagnosis, DiscrepancyFound, ParameterEstimate, RankedSet

_PHRASES = {
    "adequate": "The mission's model is adequate for these data: nothing in them asks for a cause.",
    "unexplained": "Something is left that no cause of the catalogue explains: it {left}.",
}
_TESTS_SHOWN = 5
_UNITS = {"transit": "m/s", "descent": "m", "summary": "sd", **TANK_UNITS}


def page(diagnosis: Diagnosis) -> Page:
    """Build the page of a diagnosis."""
    sections = [
        PageSection("What to do next", _next_words(diagnosis)),
        _ranking_section(diagnosis),
        *causes_section(diagnosis),
        *_residual_section(diagnosis),
        *_held_out_section(diagnosis),
        PageSection(_discrepancy_heading(diagnosis), _discrepancy_words(diagnosis)),
        PageSection(_apart_heading(diagnosis), _apart_blocks(diagnosis)),
        *plan_section(diagnosis),
        PageSection("How the data were treated", _treatment(diagnosis)),
    ]
    return Page(
        title=f"Diagnosis of {diagnosis.provenance.mission} with {diagnosis.data}",
        answer=answer(diagnosis),
        figure=main_figure(diagnosis),
        numbers=_numbers(diagnosis),
        sections=sections,
        verdict={"adequate": "good", "explained": "good", "unexplained": "bad"}.get(diagnosis.verdict, ""),
        rerun=_rerun(diagnosis),
    )


def _rerun(diagnosis: Diagnosis) -> str:
    """Write the command on the files it was given: the mission in the report's folder is the extended one."""
    made = diagnosis.provenance
    files = " ".join(shlex.quote(str(path)) for path in (made.file, made.options["dataset"]))
    return f"missionplan diagnose {files} --seed {made.seed}"


def terminal(diagnosis: Diagnosis) -> Terminal:
    """Build the terminal's view of a diagnosis."""
    columns, rows = _ranking_rows(diagnosis.ranking[:6])
    return Terminal(answer(diagnosis), columns, rows)


def answer(diagnosis: Diagnosis) -> str:
    """Say the verdict in a sentence or two, with the size of the misfit."""
    return f"{_verdict_words(diagnosis)} {diagnosis.misfit}"


def _verdict_words(diagnosis: Diagnosis) -> str:
    if not diagnosis.causes:
        return _PHRASES[diagnosis.verdict].format(left=_left(diagnosis.discrepancy))
    named = names(diagnosis.causes)
    if diagnosis.verdict == "partly-explained":
        left = _left(diagnosis.discrepancy)
        words = f"The largest share of the misfit resembles {named}, but not all of it: what is left {left}."
    elif diagnosis.verdict == "ambiguous":
        others = [names(causes) for causes in diagnosis.rivals[:3]]
        rest = f"; {' or '.join(others)} would do nearly as well" if others else "; so few numbers settle nothing"
        words = f"The data fit {named}{rest}."
    else:
        words = f"The misfit is explained by {named}."
    if any(CATALOGUE[cause].tier == "statistical" for cause in diagnosis.causes):
        words += " Part of this describes the errors statistically; its physical cause is not identified."
    return words


def _numbers(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    best = diagnosis.best
    numbers: list[tuple[str, str]] = [("Verdict", diagnosis.verdict)]
    if diagnosis.causes and best is not None and best.held_out is not None:
        gain, unit = best.held_out, _UNITS[diagnosis.kind]
        numbers.append(
            ("Error on data held out, before and after", f"{gain.rmse_base:#.2g} → {gain.rmse_extended:#.2g} {unit}")
        )
        better = f"{gain.groups_improved} of {gain.groups} parts better"
        log = f"{gain.log_score_gain:.1f} ± {gain.paired_se:.1f} nats, {better}"
        numbers.append(("Gain in log score on data held out", log))
    ahead = diagnosis.calibration.get("next_leg_model_rms_m")
    if ahead is not None and diagnosis.causes:
        before = diagnosis.calibration["next_leg_mean_so_far_rms_m"]
        numbers.append(("Next leg's position error: mean so far, and model", f"{before:.0f} → {ahead:.0f} m"))
    return numbers


def _next_words(diagnosis: Diagnosis) -> list[str]:
    words = []
    if diagnosis.causes:
        words.append(
            "The extended mission, mission.yaml in this folder, carries the causes as effects with their "
            "uncertainties. simulate, size-anchor and sweep-dmax run it as it is."
        )
        words += plan_words(diagnosis)
    for entry in diagnosis.next_measurements:
        first, second = (names(causes) for causes in entry.separates)
        words.append(
            f"To tell {first} from {second}: {entry.measurement} (expected to favour the true one by a factor of "
            f"{_factor(entry.expected_log_bayes_factor)})."
        )
    if diagnosis.outlying_groups:
        listed = ", ".join(f"{group} (p = {p_value:.1g})" for group, p_value in diagnosis.outlying_groups)
        words.append(f"Check these parts of the record, which the rest does not predict: {listed}. A wrong label?")
    if diagnosis.verdict == "adequate":
        words.append("Nothing: plan on with this mission. A calibration of its spreads stands below.")
    if diagnosis.verdict == "unexplained":
        words.append("Look for what changed along that axis; no cause of the catalogue may be named on this evidence.")
    return words


_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def _factor(nats: float) -> str:
    if nats < 12.0:
        return f"{math.exp(nats):,.0f}".replace(",", "\u202f")
    return "10" + f"{nats / math.log(10.0):.0f}".translate(_RAISED)


def _ranking_section(diagnosis: Diagnosis) -> PageSection:
    if not diagnosis.ranking:
        return PageSection("No cause of the catalogue could be fitted", ["See the failures below."])
    columns, rows = _ranking_rows(diagnosis.ranking)
    best = diagnosis.ranking[0]
    heading = f"{names(best.causes).capitalize()} {'comes' if len(best.causes) == 1 else 'come'} first"
    meaning = (
        "ln BF is the evidence for a set of causes over the mission's own model: 3 means that the data are 20 times "
        "more probable with it. It is computed with the model linearised at its best, and checked for the first few "
        "by importance sampling, which does without that. The score charges 3 for each cause beyond the first. The "
        "posterior is the probability among the sets tried, when each cause was equally likely before; supersets of "
        "the best set have none."
    )
    return PageSection(
        heading,
        [ranking_figure(diagnosis), Table(columns, rows, "Sets of causes, best first."), meaning, _parameters(best)],
    )


def _ranking_rows(ranking: Sequence[RankedSet]) -> tuple[list[str], list[list[str]]]:
    columns = ["Causes", "ln BF", "Checked", "Score", "Posterior", "Held-out gain", "Share explained"]
    rows = [
        [
            names(entry.causes),
            f"{entry.log_bayes_factor:.1f}",
            "" if entry.importance is None else f"{entry.importance:.1f}",
            f"{entry.score:.1f}",
            "" if entry.posterior is None else f"{100.0 * entry.posterior:.1f} %",
            "" if entry.held_out is None else f"{entry.held_out.log_score_gain:.1f} ± {entry.held_out.paired_se:.1f}",
            f"{100.0 * entry.share_explained:.0f} %",
        ]
        for entry in ranking
    ]
    return columns, rows


def _parameters(best: RankedSet) -> Table:
    rows = [
        [f"{p.effect}: {p.name}", _shown(p, p.value), f"{_shown(p, p.low)} to {_shown(p, p.high)}", _unit(p)]
        for p in best.parameters
    ]
    caption = "Parameters of the first set, with 90 % intervals."
    return Table(["Parameter", "Value", "90 % interval", "Unit"], rows, caption)


def _shown(parameter: ParameterEstimate, value: float) -> str:
    return f"{math.degrees(value) if parameter.unit == 'rad' else value:.3g}"


def _unit(parameter: ParameterEstimate) -> str:
    return {"rad": "deg", "": "1"}.get(parameter.unit, parameter.unit)


def _residual_section(diagnosis: Diagnosis) -> list[PageSection]:
    figures = residual_figures(diagnosis)
    return [PageSection("What was left before, and what is left now", figures)] if figures else []


def _held_out_section(diagnosis: Diagnosis) -> list[PageSection]:
    if not diagnosis.scores:
        return []
    better = sum(score.log_score_extended > score.log_score_base for score in diagnosis.scores)
    heading = f"{better} of {len(diagnosis.scores)} parts are predicted better when they are held out"
    rows = [
        [
            score.group,
            f"{score.log_score_extended - score.log_score_base:+.1f}",
            f"{score.rmse_base:.3g}",
            f"{score.rmse_extended:.3g}",
        ]
        for score in diagnosis.scores
    ]
    unit = _UNITS[diagnosis.kind]
    table = Table(["Held out", "Gain (nats)", f"Error before ({unit})", f"Error after ({unit})"], rows)
    blocks: list[Block] = [held_out_figure(diagnosis), table]
    best = diagnosis.best
    if best is not None and best.held_out is not None:
        gain = best.held_out
        blocks.append(
            f"90 % prediction intervals hold {100 * gain.coverage_90_base:.0f} % of the values with the mission's "
            f"model and {100 * gain.coverage_90_extended:.0f} % with the extended one."
        )
    return [PageSection(heading, blocks)]


def _discrepancy_heading(diagnosis: Diagnosis) -> str:
    if not diagnosis.discrepancy.by_axis:
        return "Too few data to look for what is left"
    if diagnosis.discrepancy.axis is None:
        return "Nothing structured is left"
    return f"What is left {_left(diagnosis.discrepancy)}"


def _left(discrepancy: DiscrepancyFound) -> str:
    """Say what a remainder looks like, or along what it is structured."""
    if discrepancy.resembles is None:
        return f"is structured along {discrepancy.axis}"
    return f"looks like {discrepancy.resembles}"


def _discrepancy_words(diagnosis: Diagnosis) -> list[Block]:
    found = diagnosis.discrepancy
    if not found.by_axis:
        return ["A handful of numbers has no structure that could be tested."]
    blocks: list[Block] = [discrepancy_figure(found)] if found.shape is not None else []
    words = (
        f"A smooth remainder along any axis: ln BF = {found.log_bayes_factor:.1f} (above 3 it counts). It is a "
        f"test, not a repair. With the mission's model alone: {diagnosis.base_discrepancy.log_bayes_factor:.1f}."
    )
    blocks.append(words)
    rows = [[axis, f"{value:.1f}"] for axis, value in found.by_axis]
    blocks.append(Table(["What it could look like", "ln BF of a smooth remainder"], rows))
    if found.tests:
        telling = sorted(found.tests, key=lambda test: test[1])[:_TESTS_SHOWN]
        rows = [[name, f"{p_value:.2g}"] for name, p_value in telling]
        caption = (
            f"The {len(rows)} most telling of {len(found.tests)} tests; by chance alone the smallest would be about "
        )
        caption += f"{1.0 / len(found.tests):.2g}."
        blocks.append(Table(["Test of the errors left", "p-value"], rows, caption))
    return blocks


def _apart_heading(diagnosis: Diagnosis) -> str:
    if len(diagnosis.credible_set) > 1 or diagnosis.indistinguishable:
        return "What these data cannot tell apart, and what would"
    return "Nothing else comes near" if diagnosis.causes else "No cause comes near"


def _apart_blocks(diagnosis: Diagnosis) -> list[str | Table]:
    blocks: list[str | Table] = []
    held = ", ".join(names(causes) for causes in diagnosis.credible_set)
    blocks.append(f"95 % of the probability lies with: {held}.")
    for first, second in diagnosis.indistinguishable:
        blocks.append(f"{names(first).capitalize()} and {names(second)} predict the same of data like these.")
    if diagnosis.untestable:
        rows = [[name, why] for name, why in diagnosis.untestable.items()]
        blocks.append(Table(["Effect that these data cannot show", "Why"], rows))
    return blocks


_CALIBRATION = {
    "dive_scatter": "Scatter from dive to dive, of the usual",
    "depth_walk_m2_s": "Turbulence: rate at which the depth wanders (m²/s)",
    "eddy_time_s": "Turbulence: how long a velocity lasts (s)",
    "sigma_v_m_s": "Velocity error of a leg, σ_v (m/s)",
    "fix_sd_m": "Error of a fix (m)",
    "next_leg_mean_so_far_rms_m": "Next leg's position error, predicted by the mean so far (m)",
    "next_leg_last_leg_rms_m": "Next leg's position error, predicted by the last leg (m)",
    "next_leg_model_rms_m": "Next leg's position error, predicted by this model (m)",
}


def _treatment(diagnosis: Diagnosis) -> list[str | Table]:
    blocks: list[str | Table] = []
    if diagnosis.source:
        blocks.append(f"Source: {diagnosis.source}")
    rows = [[_CALIBRATION.get(name, name), f"{value:.4g}"] for name, value in diagnosis.calibration.items()]
    blocks.append(Table(["Calibration of the base model", "Value (SI)"], rows, "Fitted beside the causes; no cause."))
    if diagnosis.failures:
        blocks.append(
            Table(["Set that could not be fitted", "Why"], [list(item) for item in diagnosis.failures.items()])
        )
    return blocks
