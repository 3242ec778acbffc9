"""Report of `size-anchor`: what to build, where to put the trim ring, and what dive the anchor gives."""

import math

from missionplan.report.anchor import sections
from missionplan.report.anchor.drawing import drawing
from missionplan.report.anchor.figures import descent_profile
from missionplan.report.anchor.numbers_table import numbers_table
from missionplan.report.numbers import percent
from missionplan.report.page import Figure, Page, Terminal
from missionplan.results.anchor import AnchorSizing
from missionplan.results.sized_anchor import SizedAnchor


def page(sizing: AnchorSizing) -> Page:
    """Build the page of a sizing."""
    anchor = sizing.anchor
    succeeds = not anchor.problems and anchor.touched_down and anchor.lowest_altitude > 0.0
    return Page(
        title=f"Anchor for {sizing.phase}: {sizing.provenance.mission}",
        answer=answer(sizing),
        figure=_main_figure(anchor),
        numbers=[
            ("Wet weight", f"{anchor.wet_weight:.2f} N"),
            ("Terminal velocity it is sized for", f"{anchor.terminal_velocity:.2f} m/s"),
            (f"Dives within {sizing.radius:.1f} m and clear of the bottom", percent(anchor.probabilities.good)),
        ],
        sections=[
            *sections.problems(anchor),
            *sections.probable(sizing),
            sections.probabilities(sizing),
            *sections.dive(sizing),
            sections.drag(sizing),
            sections.all_numbers(sizing),
        ],
        verdict="good" if succeeds else "bad",
    )


def terminal(sizing: AnchorSizing) -> Terminal:
    """Build the terminal's view of a sizing."""
    return Terminal(answer(sizing), *numbers_table(sizing))


def answer(sizing: AnchorSizing) -> str:
    """Write what a field engineer wants to know, in a sentence or two."""
    anchor = sizing.anchor
    design = anchor.design
    weight = f"{anchor.wet_weight:.{1 if anchor.wet_weight >= 1.0 else 2}f}\u00a0N"
    if design is None:
        return f"An anchor of {weight} wet: {sections.dive_in_words(anchor)}."
    if not design.feasible:
        failures = "; ".join(failure.words for failure in design.failures)
        return f"An anchor of {weight} wet cannot be built from these parts: {failures}."
    built = f"{design.dry_mass:.2f}\u00a0kg dry, {design.length * 1e3:.0f}\u00a0mm long"
    if math.isfinite(design.trim_position):
        built += f", ring of {design.trim_mass:.2f}\u00a0kg at {design.trim_position * 1e3:.0f}\u00a0mm"
    return f"An anchor of {weight} wet, {built}: {sections.dive_in_words(anchor)}."


def _main_figure(anchor: SizedAnchor) -> Figure | None:
    """The anchor where it can be built, else its dive where there is one."""
    if anchor.design is not None and anchor.design.feasible:
        return drawing(anchor.design)
    return descent_profile(anchor) if anchor.touched_down else None
