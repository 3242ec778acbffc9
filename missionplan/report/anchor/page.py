"""Report of `size-anchor`: what to build, where to put the ring, and what dive it gives."""

import math
from collections.abc import Sequence

from missionplan.report.anchor.figures import descent_profile, drag_bars, drawing, drift
from missionplan.report.numbers import number, percent
from missionplan.report.page import Block, Figure, Page, PageSection, Table, Terminal
from missionplan.results.anchor import AnchorSizing, ProbableAnchor, SizedAnchor


def page(sizing: AnchorSizing) -> Page:
    """Build the page of a sizing."""
    anchor = sizing.anchor
    return Page(
        title=f"Anchor for {sizing.phase}: {sizing.provenance.mission}",
        answer=answer(sizing),
        figure=_main_figure(anchor),
        numbers=[
            ("Wet weight", f"{anchor.wet_weight:.2f} N"),
            ("Terminal velocity it is sized for", f"{anchor.terminal_velocity:.2f} m/s"),
            (f"Dives within {sizing.radius:.1f} m and clear of the bottom", percent(anchor.probabilities.good)),
        ],
        sections=list(_sections(sizing)),
        verdict="bad" if anchor.problems or not _is_down(anchor) or anchor.lowest_altitude <= 0.0 else "good",
    )


def terminal(sizing: AnchorSizing) -> Terminal:
    """Build the terminal's view of a sizing."""
    columns, rows = _columns(sizing), _rows(sizing)
    return Terminal(answer(sizing), columns, rows)


def answer(sizing: AnchorSizing) -> str:
    """Say what a field engineer wants to know, in a sentence or two."""
    anchor = sizing.anchor
    design = anchor.design
    if design is not None and not design.feasible:
        return (
            f"An anchor of {_newtons(anchor)} wet cannot be built from these parts: "
            f"{'; '.join(failure.words for failure in design.failures)}."
        )
    built = f"An anchor of {_newtons(anchor)} wet"
    if design is not None:
        built += f", {design.dry_mass:.2f}\u00a0kg dry, {design.length * 1e3:.0f}\u00a0mm long"
        if math.isfinite(design.trim_position):
            built += f", ring of {design.trim_mass:.2f}\u00a0kg at {design.trim_position * 1e3:.0f}\u00a0mm"
    return f"{built}: {_dive_words(anchor)}."


def _newtons(anchor: SizedAnchor) -> str:
    return f"{anchor.wet_weight:.{1 if anchor.wet_weight >= 1.0 else 2}f}\u00a0N"


def _main_figure(anchor: SizedAnchor) -> Figure | None:
    """The anchor where it can be built, else its dive where there is one."""
    if anchor.design is not None and anchor.design.feasible:
        return drawing(anchor.design)
    return descent_profile(anchor) if _is_down(anchor) else None


def _is_down(anchor: SizedAnchor) -> bool:
    return bool(anchor.profile.record.touched_down[0])


def _dive_words(anchor: SizedAnchor) -> str:
    if not _is_down(anchor):
        return "it does not take the vehicle to the seafloor"
    down = (
        f"at the seafloor {anchor.descent_time:.0f}\u00a0s after separation, "
        f"{anchor.offset:.0f}\u00a0m from the last fix"
    )
    if anchor.lowest_altitude > 0.0:
        return f"{down}; the vehicle stops {anchor.lowest_altitude:.1f}\u00a0m above the bottom"
    return f"{down}; the vehicle strikes the bottom, for want of {-anchor.lowest_altitude:.1f}\u00a0m of line"


def _sections(sizing: AnchorSizing) -> Sequence[PageSection]:
    anchor = sizing.anchor
    sections = []
    if anchor.problems:
        blocks: list[Block] = [f"{problem[0].upper()}{problem[1:]}." for problem in anchor.problems]
        if anchor.design is not None and anchor.design.cylinder_length > 0.0:
            blocks.append(drawing(anchor.design))
        sections.append(PageSection("Why it cannot be built, and what would mend it", blocks))
    if sizing.probable is not None:
        sections.append(_probable_section(sizing, sizing.probable))
    sections.append(PageSection(_probability_heading(sizing), [_probability_words(sizing)]))
    if _is_down(anchor):
        if anchor.design is not None and anchor.design.feasible:
            sections.append(PageSection(_stop_heading(anchor), [descent_profile(anchor)]))
        sections.append(PageSection(_drift_heading(sizing), [drift(sizing), _layers_words(sizing)]))
    else:
        sections.append(PageSection("The anchor does not come down", [_layers_words(sizing)]))
    sections.append(PageSection(_drag_heading(anchor), [drag_bars(anchor), *sizing.notes]))
    sections.append(PageSection("All numbers", [Table(_columns(sizing), _rows(sizing))]))
    return sections


def _probable_section(sizing: AnchorSizing, probable: ProbableAnchor) -> PageSection:
    wanted = f"{100 * probable.required:g}\u00a0%"
    found, worst = probable.anchor, sizing.anchor
    if found is None:
        words = [f"{probable.reason[0].upper()}{probable.reason[1:]}."]
        if probable.line_length is not None:
            words.append(
                f"A line of {probable.line_length:.1f}\u00a0m, instead of {sizing.line_length:.1f}\u00a0m, "
                f"with an anchor of {probable.line_anchor_weight:.1f}\u00a0N would do."
            )
        return PageSection(f"No anchor reaches {wanted}", words)
    difference = found.wet_weight - worst.wet_weight
    compared = f"{abs(difference):.1f}\u00a0N {'lighter' if difference < 0.0 else 'heavier'}"
    words = [
        f"The lightest anchor that stays within {sizing.radius:.1f}\u00a0m without the vehicle striking in {wanted} of "
        f"dives weighs {found.wet_weight:.1f}\u00a0N wet, {compared} "
        f"than the worst-case anchor, which reaches {percent(worst.probabilities.good)}. It is {_dive_words(found)}.",
        "The worst case takes every layer at its design speed and all as aligned, but leaves out the release, the "
        "pay-out of the line and the time to gather speed; so it may be on either side.",
    ]
    words += [f"{problem[0].upper()}{problem[1:]}." for problem in found.problems]
    heading = f"For {wanted} the anchor weighs {found.wet_weight:.1f}\u00a0N"
    return PageSection(heading, words)


def _probability_heading(sizing: AnchorSizing) -> str:
    good = percent(sizing.anchor.probabilities.good)
    return f"{good} of dives stay within {sizing.radius:.1f}\u00a0m and clear of the bottom"


def _probability_words(sizing: AnchorSizing) -> str:
    dives, trials = sizing.anchor.probabilities, sizing.provenance.trials
    offset = dives.offset
    if offset.count == 0:
        return f"In none of {trials} dives drawn from the mission's distributions does the anchor come down."
    return (
        f"Over {trials} dives drawn from the mission's distributions the anchor comes down "
        f"{number(offset.p50, offset.standard_error)}\u00a0m from the last fix in the median and "
        f"{number(offset.p95, 2.0 * offset.standard_error)}\u00a0m at the 95th percentile. The vehicle "
        f"strikes the seafloor in {percent(dives.struck)}; in one dive of twenty it stops within "
        f"{dives.lowest_altitude.p05:.2f}\u00a0m of it."
    )


def _stop_heading(anchor: SizedAnchor) -> str:
    if anchor.lowest_altitude > 0.0:
        return f"The vehicle stops {anchor.lowest_altitude:.1f}\u00a0m above the bottom"
    return "The vehicle strikes the bottom"


def _drift_heading(sizing: AnchorSizing) -> str:
    inside = "inside" if sizing.anchor.offset <= sizing.radius else "outside"
    return f"The anchor comes down {sizing.anchor.offset:.1f}\u00a0m from the last fix, {inside} the radius"


def _layers_words(sizing: AnchorSizing) -> str:
    layers = "; ".join(f"{layer.thickness:.1f}\u00a0m at {layer.speed:.2f}\u00a0m/s" for layer in sizing.layers)
    words = f"Sized for {layers}, all aligned (Eq. 1): {sizing.required_velocity:.3f}\u00a0m/s down over the ground."
    if sizing.vector_velocity is not None:
        words += f" With the layers' own directions {sizing.vector_velocity:.3f}\u00a0m/s would do."
    return words


def _drag_heading(anchor: SizedAnchor) -> str:
    share = float(anchor.drag.anchor) / float(anchor.drag.total)
    return f"The vehicle makes {100 * (1 - share):.0f}\u00a0% of the drag, the anchor {100 * share:.0f}\u00a0%"


_LABELS = (
    ("wet_weight_n", "Wet weight", 1.0, 2, "N"),
    ("terminal_velocity_m_s", "Terminal velocity sized for", 1.0, 4, "m/s"),
    ("dry_mass_kg", "Dry mass = displaced mass", 1.0, 4, "kg"),
    ("flooded_mass_kg", "Flooded mass", 1.0, 3, "kg"),
    ("length_m", "Length", 1e3, 1, "mm"),
    ("cylinder_length_m", "Tube length C", 1e3, 2, "mm"),
    ("trim_mass_kg", "Trim ring's mass", 1.0, 4, "kg"),
    ("trim_position_m", "Trim ring from the tip", 1e3, 1, "mm"),
    ("centre_of_gravity_m", "Centre of gravity from the tip", 1e3, 1, "mm"),
    ("centre_of_buoyancy_m", "Centre of buoyancy from the tip", 1e3, 1, "mm"),
)
_DIVE_LABELS = (
    ("time_s", "Separation to touchdown", 2, "s"),
    ("payout_time_s", "of which until the line is taut", 2, "s"),
    ("terminal_velocity_m_s", "Terminal velocity of the dive", 3, "m/s"),
    ("offset_m", "Anchor from the last fix", 2, "m"),
    ("lowest_altitude_m", "Vehicle's lowest altitude", 2, "m"),
)


def _anchors(sizing: AnchorSizing) -> dict[str, SizedAnchor]:
    anchors = {"Worst case": sizing.anchor}
    if sizing.probable is not None and sizing.probable.anchor is not None:
        anchors[f"{100 * sizing.probable.required:g} %"] = sizing.probable.anchor
    return anchors


def _columns(sizing: AnchorSizing) -> list[str]:
    return ["", *_anchors(sizing)]


def _rows(sizing: AnchorSizing) -> list[list[str]]:
    anchors = list(_anchors(sizing).values())
    rows = []
    for key, label, scale, digits, unit in _LABELS:
        values = [anchor.summary()[key] for anchor in anchors]
        if values[0] is not None:
            rows.append([label, *(_shown(value * scale, digits, unit) for value in values)])
    for key, label, digits, unit in _DIVE_LABELS:
        rows.append([label, *(_shown(anchor.descent_summary()[key], digits, unit) for anchor in anchors)])
    rows.append(["Within the radius and not struck", *(percent(anchor.probabilities.good) for anchor in anchors)])
    return rows


def _shown(value: float, digits: int, unit: str) -> str:
    return f"{value:.{digits}f} {unit}" if math.isfinite(value) else "–"
