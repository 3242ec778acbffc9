"""Report of a rare failure: how probable it is, and how it comes about."""

import math
from collections.abc import Iterator

from matplotlib.axes import Axes

from missionplan.errors import counted
from missionplan.report.page import Block, Cells, Page, PageSection, Table, typed
from missionplan.report.quantities import Unit, reader_unit
from missionplan.report.simulation.quantities import failure_in_words
from missionplan.report.wording import capitalised, in_words, number, portion_in_words, raised
from missionplan.studies.rare_failure import Cause, FailureMode, RareFailure, WayDriven

_FAILS = "not total.success"
_DEGREES = Unit("°", math.radians(1.0))


def page(risk: RareFailure) -> Page:
    """Build the page of a rare failure."""
    made = risk.provenance
    asked = {name: made.options.get(name) for name in ("trials", "precision")}
    return Page(
        title=f"Rare failure: {risk.provenance.mission or risk.provenance.file}",
        answer=answer(risk),
        numbers=_numbers(risk),
        write=lambda: [*_how(risk), *_driven(risk), *_precision(risk)],
        rerun=typed("simulate", made.file, rare=risk.event, seed=made.seed, **asked),
        table=lambda: _cells(risk),
        plots={"failures": failures},
    )


def _cells(risk: RareFailure) -> Cells:
    rows = [(_way(mode), portion_in_words(mode.share)) for mode in risk.modes]
    is_failure = any(mode.step for mode in risk.modes)
    return ("way to fail" if is_failure else "in", "of all of these"), rows


def answer(risk: RareFailure) -> str:
    """Write how probable the failure is, and how it comes about."""
    if not risk.reached:
        return (
            f"No {event_in_words(risk.event)} was found, in {counted(risk.provenance.trials, 'trial')} led towards "
            f"each way to fail by its own margin. By plain trials alone it is at most {_power(risk.probability.high)}."
        )
    value = risk.probability.value
    chance = f"{_power(value)} ({_power(risk.probability.low)} to {_power(risk.probability.high)})"
    event = f"{capitalised(event_in_words(risk.event))} comes about"
    often = f"about one mission in {number(float(f'{1.0 / value:.1e}'))}" if value < 0.5 else "more often than not"
    often = f"with probability {chance}: {often}"
    if value == 1.0:
        often = f"in each of {counted(risk.provenance.trials, 'trial')}"
    words = f"{'This mission fails' if risk.event == _FAILS else event} {often}."
    if not risk.modes:
        return words
    commonest = risk.modes[0]
    causes = _causes_in_words(commonest)
    if not commonest.step:
        return f"{words} It comes with {causes}." if causes else words
    how = f" with {causes}" if causes else ""
    return f"{words} {portion_in_words(commonest.share)} of these are {failure_in_words(commonest.step)}{how}."


def event_in_words(event: str) -> str:
    """Write an event in words: ``offset of the anchor (moor) above 30 m``, ``failure``."""
    if event == _FAILS:
        return "failure"
    for sign, word in ((" > ", "above"), (" < ", "below")):
        quantity, separator, limit = event.partition(sign)
        if separator:
            return f"{in_words(quantity.strip())} {word} {limit.strip()}"
    denied = event.removeprefix("not ")
    return f"failure of “{in_words(denied)}”" if denied != event else in_words(event)


def _way(mode: FailureMode) -> str:
    return failure_in_words(mode.step) if mode.step else "missions that otherwise succeed"


def _causes_in_words(mode: FailureMode) -> str:
    return ", ".join(
        f"{'high' if cause.shift > 0.0 else 'low'} {in_words(cause.source)} ({_value(cause, cause.mean)} where "
        f"{_value(cause, cause.usual)} is usual)"
        for cause in mode.causes[:3]
    )


def _value(cause: Cause, value: float) -> str:
    """Write a value in the reader's unit; an angle in degrees."""
    unit = _DEGREES if cause.unit == "rad" else reader_unit(cause.unit, max(abs(cause.mean), abs(cause.usual)))
    return f"{number(unit(value), 0.05 * unit(cause.usual_sd))}{unit.suffix}"


def _how(risk: RareFailure) -> Iterator[PageSection]:
    """Say of each way to fail how often it is, and what is not as usual in it."""
    if not risk.modes:
        return
    is_failure = any(mode.step for mode in risk.modes)
    of_these = "the failures" if is_failure else "these missions"
    blocks: list[Block] = [
        f"{portion_in_words(mode.share)} of {of_these} are {_way(mode)}"
        + (f", with {causes}." if (causes := _causes_in_words(mode)) else "; no input is far from usual in them.")
        for mode in risk.modes
    ]
    rows = [
        (
            _way(mode),
            in_words(cause.source),
            _value(cause, cause.mean),
            _value(cause, cause.usual),
            f"{cause.shift:+.1f}",
        )
        for mode in risk.modes
        for cause in mode.causes
    ]
    if rows:
        columns = ("way to fail" if is_failure else "in", "input", "mean then", "usual mean", "shift (sd)")
        caption = (
            "SI units; shift in standard deviations of all trials. Velocity errors are means over a transit's legs."
        )
        blocks.append(Table(columns, rows, caption, text_columns=2))
    blocks.append(
        "failures.csv has trials in which it comes about, each as likely as any other, with all that was drawn in them."
    )
    heading = "How it fails" if is_failure else "How it comes about"
    yield PageSection(f"{heading}: {_way(risk.modes[0])}", blocks)


def _driven(risk: RareFailure) -> Iterator[PageSection]:
    """Say of each way to fail what was found of it, and of those without a failure what bounds them."""
    met = sorted((way for way in risk.ways if way.probability > 0.0), key=lambda way: -way.probability)
    unmet = [way for way in risk.ways if way.probability == 0.0 and way.way]
    rows = [(_driven_way(risk, way), _power(way.probability), "", "") for way in met]
    rows += [
        (_driven_way(risk, way), "none found", _power(way.nearest) if way.nearest < 1.0 else "—", _power(way.bound))
        for way in unmet
    ]
    if not rows:
        return
    caption = (
        "A trial that fails in several ways counts for each of them here, and once in the whole. Where none was found: "
        "the probability of coming as near as the nearest trials, beyond which the margin did not lead (— where it "
        "varies with nothing that is drawn), and what plain trials alone allow at most."
    )
    heading = "Each way to fail, driven by its own margin"
    if unmet and risk.reached:
        heading = f"Not met: {len(unmet)} of {len(met) + len(unmet)} ways to fail"
    columns = ("way to fail", "probability", "nearest without failing", "at most, by plain trials")
    yield PageSection(heading, [Table(columns, rows, caption)])


def _driven_way(risk: RareFailure, way: WayDriven) -> str:
    if not way.way:
        return "none of the known margins"
    return capitalised(event_in_words(way.way)) if way.way == risk.event else failure_in_words(way.way)


def _precision(risk: RareFailure) -> Iterator[PageSection]:
    if not risk.reached:
        return
    yield PageSection(
        f"Known to {100.0 * risk.variation:.0f} % from {counted(risk.provenance.trials, 'trial')}",
        [
            f"{risk.repetitions} independent runs of subset simulation of at most {risk.levels} levels, each with a "
            "pilot of its own; the interval follows from their scatter (Student's t on the logarithm). A plain Monte "
            f"Carlo would know the probability as well after {_power(risk.plain_trials)} trials.",
            "The probability is that of the model: what the mission file leaves out is not in it, and one in a million "
            "is to be believed only as far as the tails of the distributions given.",
        ],
    )


def _numbers(risk: RareFailure) -> list[tuple[str, str]]:
    if not risk.reached:
        return []
    low, high = _power(risk.probability.low), _power(risk.probability.high)
    return [
        ("Probability", _power(risk.probability.value)),
        ("95 % interval", f"{low} to {high}"),
        ("Coefficient of variation", f"{100.0 * risk.variation:.1f} %"),
    ]


def _power(value: float) -> str:
    """Write a probability or a number of trials in two digits: ``0.046``, ``1.2·10⁻⁶``, ``3.4·10⁸``."""
    if value <= 0.0 or not math.isfinite(value):
        return "0" if value <= 0.0 else "∞"
    if 1e-3 <= value < 1e4:
        return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"
    digits, exponent = f"{value:.1e}".split("e")
    return f"{digits}·10{raised(str(int(exponent)))}"


def failures(axes: Axes, risk: RareFailure) -> None:
    """Draw the share of each way to fail."""
    modes = risk.modes[::-1]
    axes.barh(range(len(modes)), [100.0 * mode.share for mode in modes])
    axes.set_yticks(range(len(modes)), [failure_in_words(mode.step) if mode.step else "any" for mode in modes])
    axes.set(xlabel="of the failures (%)", xlim=(0.0, 100.0))
