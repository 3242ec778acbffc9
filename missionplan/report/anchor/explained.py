"""The anchor to build under each explanation that the mission carries, and whether the doubt changes the choice."""

from missionplan.report.numbers import percent, share
from missionplan.report.page import PageSection, Table
from missionplan.report.quantities import quantity, reader_unit
from missionplan.results.explained import label
from missionplan.results.mooring.sizing import AnchorSizing

SAME_WEIGHT = 0.02
"""Ratio less one within which two wet weights are the same choice."""


def explanation_in_words(sizing: AnchorSizing) -> str:
    """Say in a sentence whether what is in doubt changes the choice; nothing for a mission without doubts."""
    found = sorted(sizing.explanations, key=lambda each: each.good.value)
    if not found:
        return ""
    needed = [each.needed for each in found if each.needed is not None]
    if sizing.probable is not None and len(needed) == len(found):
        if max(needed) <= (1.0 + SAME_WEIGHT) * min(needed):
            return f" Whichever explanation holds, the same anchor is best, to {100.0 * SAME_WEIGHT:.0f}\u00a0%."
        light, heavy = (pick(found, key=lambda each: each.needed or 0.0) for pick in (min, max))
        return (
            f" The doubt changes the choice: with {label(light.causes)} {quantity(light.needed, 'N', '.2f')} "
            "would do, with "
            f"{label(heavy.causes)} it takes {quantity(heavy.needed, 'N', '.2f')}."
        )
    worst, best = found[0], found[-1]
    if worst.good.high < best.good.low:
        ends = f"{share(worst.good)} with {label(worst.causes)}, {share(best.good)} with {label(best.causes)}"
        return f" It depends on which explanation holds: {ends}."
    return " Whichever explanation holds, it does as well, as far as the trials can tell."


def explanation_section(sizing: AnchorSizing) -> list[PageSection]:
    """Tabulate what the anchor to build achieves under each explanation, and which one would do."""
    asked = any(each.needed is not None for each in sizing.explanations)
    unit = reader_unit("N", 0.0)
    rows = [
        [
            label(each.causes),
            f"{100.0 * each.probability:.1f}\u00a0%",
            percent(each.good),
            "–" if each.needed is None and asked else unit.cell(each.needed, ".2f") if asked else "",
        ]
        for each in sizing.explanations
    ]
    columns = (
        "explanation",
        "probability",
        "dives that succeed with the anchor to build",
        f"lightest that would do{unit.axis}",
    )
    note = "Each explanation known to hold in turn, on the same random numbers."
    return [PageSection("Which explanation holds", [Table(columns, rows, note)])] if rows else []
