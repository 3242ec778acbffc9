"""Page of an import: what was made of the logs, what the legs can and cannot show, and what to type next."""

import math
import shlex
from collections.abc import Mapping

import pandas as pd

from missionplan.report.imported.figures import depth_figure, draw_track, histograms, track_figure
from missionplan.report.page import Block, Drawing, Listing, Page, PageSection, Table, Terminal
from missionplan.report.quantities import quantity, reader_unit
from missionplan.results.imported import ImportedData

_LISTED = 60
"""Rows of a table on the page; the files hold all."""


def page(result: ImportedData) -> Page:
    """Build the page of an import."""
    is_transit = result.kind == "transit"
    depth = depth_figure(result)
    sections = [
        _what_they_show(result),
        PageSection("What to type next", _next_blocks(result)),
        PageSection(_dives_heading(result), [*([depth] if depth else []), _dives_table(result)]),
        _sources(result),
    ]
    if is_transit and result.counted:
        sections.insert(1, PageSection("How long the legs are, and where they go", [histograms(result)]))
    return Page(
        title=f"Import: {result.name}",
        answer=answer(result),
        figure=track_figure(result) if is_transit else None,
        numbers=_numbers(result),
        sections=sections,
        verdict="" if result.counted else "bad",
        rerun=f"missionplan import SOURCE --out DATASET --kind {result.kind} --format {shlex.quote(result.format)}",
    )


def terminal(result: ImportedData) -> Terminal:
    """Build the terminal's view of an import."""
    rows = [("dives that count", str(result.counted))]
    rows += [(reason, str(count)) for reason, count in result.reasons.items()]
    sentence = f"{answer(result)} Next, in that folder: {result.next_commands[0]}"
    return Terminal(sentence, ("", "dives"), rows, "" if result.counted else "bad")


def answer(result: ImportedData) -> str:
    """Say what the logs hold."""
    things = "dives between fixes" if result.kind == "transit" else "dives"
    counted = f"{result.counted} of {len(result.dives)} {things} count"
    if result.kind != "transit":
        return f"{counted}."
    doubt = result.figures["made_reckoning_sd_m"]
    if math.isfinite(doubt):
        return (
            f"The logs hold no dead reckoning: it was {result.reckoning}, and is in doubt by {doubt:.0f} m a leg "
            f"(median). {counted} as legs."
        )
    return f"{counted} as legs; dead reckoning: {result.reckoning}."


def _numbers(result: ImportedData) -> list[tuple[str, str]]:
    if result.kind != "transit":
        return []
    found = result.figures
    east, north = found["velocity_error_mean_east_m_s"], found["velocity_error_mean_north_m_s"]
    return [
        (
            "Velocity error, each axis",
            f"{quantity(found['velocity_error_sigma_m_s'], 'm/s', '.3f')} about {east:.3f}, "
            f"{quantity(north, 'm/s', '.3f')}",
        ),
        ("Leg, median", f"{quantity(found['leg_length_m'], 'm', '.0f')} in {found['leg_duration_s'] / 60.0:.0f} min"),
        ("Fix, each axis", quantity(found["fix_sd_m"], "m", ".1f")),
    ]


def _what_they_show(result: ImportedData) -> PageSection:
    lacking = sum(verdict.startswith("no") for _, verdict in result.can_show)
    heading = "What these data can show, and what they cannot" if lacking else "What these data can show"
    return PageSection(heading, [Table(("what", "can it be seen?"), result.can_show, text_columns=2)])


def _next_blocks(result: ImportedData) -> list[Block]:
    return [
        "In this folder; mission.yaml is a starter mission with what the log says, for you to correct:",
        Listing("\n".join(result.next_commands)),
        Listing(result.mission_text),
    ]


def _dives_heading(result: ImportedData) -> str:
    left = len(result.dives) - result.counted
    return f"Every dive: {left} of {len(result.dives)} left out" if left else f"All {len(result.dives)} dives count"


def _dives_table(result: ImportedData) -> Table:
    shown = result.dives.head(_LISTED)
    begins = shown["t_start"] if "t_start" in shown else pd.Series("", index=shown.index)
    reasons = shown["reason"].where(shown["ok"] == 0, "yes")
    unit = reader_unit("m", float(shown["max_depth_m"].max()))
    columns = (shown.iloc[:, 0], begins, result.durations[:_LISTED] / 60.0, shown["max_depth_m"], reasons)
    rows = [
        (str(name), str(begin).replace("T", "\u00a0")[:19], str(reason), f"{minutes:.1f}", unit.cell(depth, ".1f"))
        for name, begin, minutes, depth, reason in zip(*columns, strict=True)
    ]
    more = f"The first {_LISTED} of {len(result.dives)}. " if len(result.dives) > _LISTED else ""
    caption = f"{more}Times are UTC. All of it is in all-dives.csv."
    return Table(("dive", "begins", "counts?", "minutes", f"greatest depth{unit.axis}"), rows, caption, text_columns=3)


def _sources(result: ImportedData) -> PageSection:
    blocks: list[Block] = [
        f"{len(result.sources)} files of the format {result.format}; their checksums are in import.json."
    ]
    if len(result.rejected_fixes):
        counts = "; ".join(f"{count}: {reason}" for reason, count in result.rejected_reasons.items())
        blocks.append(f"{len(result.rejected_fixes)} fixes do not count. {counts}. They are in rejected-fixes.csv.")
    if result.passed_over:
        passed = len(result.passed_over)
        blocks.append("1 file was passed over:" if passed == 1 else f"{passed} files were passed over:")
        blocks.append(Listing("\n".join(result.passed_over[:_LISTED])))
    return PageSection("What was read", blocks)


PLOTS: Mapping[str, Drawing] = {"track": draw_track}
"""Plots on given axes by name, the main one first."""
