"""Forms of the plan: one module a format, each with a title, what it cannot hold, and the files that it writes.

All take `missionplan.results.plan.Plan` and know neither missions nor phases. Here is what every file says of itself:
which mission it is the plan of, what it cannot hold; and text as XML. Read `table` first, then `slocum` and `moos`.
"""

import math
import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Protocol, cast
from xml.etree import ElementTree

from missionplan.errors import Problem
from missionplan.phases.transit.plan import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_places import Fence
from missionplan.results.plan_states import GUARDS, GuardKind

FIXED_POINTS = (
    "legs that begin where the vehicle surfaces: it goes through the ends of the planned legs, and a leg may be longer "
    "than d_max by the drift"
)

_LONGEST = 40
"""Characters of a name that a token keeps."""
_NAMES = 6
"""Names of zones that are listed."""


def header(plan: Plan, title: str, lost: Sequence[str]) -> tuple[str, ...]:
    """Return the lines of a file's header.

    `title`: of the format. `lost`: what the format cannot hold, in words.
    """
    return tuple(
        one_line(line)
        for line in (
            f"Plan of the mission {plan.mission or 'without a name'} as {title}",
            f"Written by missionplan {plan.version}; SHA-256 of the mission: {plan.digest}",
            *(f"Note: {note}" for note in plan.notes),
            *(f"Not in this file: {words}" for words in lost),
        )
    )


def one_interval(plan: Plan) -> tuple[str, ...]:
    """Say what a format loses that holds one interval between surfacings for each transit."""
    return tuple(_lost_table(transit) for transit in plan.transits if transit.surfacing.table)


def _lost_table(transit: PlannedTransit) -> str:
    rule = transit.surfacing
    words = f"the table of legs of {transit.name}; in its place the interval that costs least, {rule.interval:.0f} m"
    if rule.extra_time != rule.extra_time:  # not compared
        return f"{words.replace('that costs least', 'of its longest leg')}, whose cost is not known"
    size, error = abs(rule.extra_time) / 60.0, rule.extra_time_error / 60.0
    return f"{words}, at {size:.2f} ± {error:.2f} minutes {'less' if rule.extra_time < 0.0 else 'more'} on average"


def no_correction(plan: Plan) -> tuple[str, ...]:
    """Say that a format has no correction of the course, where the mission makes one."""
    return ("the correction of the course for drift from fix to fix",) if plan.corrects else ()


def no_decision(plan: Plan) -> tuple[str, ...]:
    """Say what a format loses that goes through a fixed number of points: whether a fix lies within the radius."""
    made = ", ".join(f"{transit.name} {transit.extra_legs}" for transit in plan.transits)
    return (
        "arrival by the fix: the vehicle does not compare it with the goal, makes a fixed number of further legs "
        f"({made}) and ends there",
    )


def no_battery(plan: Plan, instead: str) -> tuple[str, ...]:
    """Say what becomes of the plan's guard on the battery, where it has one."""
    return (f"the guard for the battery of {plan.capacity:g} W h: {instead}",) if math.isfinite(plan.capacity) else ()


def zones_lost(plan: Plan, what: str = "nothing in it keeps the vehicle out") -> tuple[str, ...]:
    """Say what a format without polygons loses: land and zones kept out of, by their names, a few of many."""
    return (f"land and zones kept out of ({_names(plan.fences)}): {what}",) if plan.fences else ()


def limits_lost(plan: Plan) -> tuple[str, ...]:
    """Say what a format loses whose polygons hold at all times and depths, and have no holes."""
    limited = [fence for fence in plan.fences if fence.limits]
    holed = [fence for fence in plan.fences if fence.holes]
    times = (f"times and depths of zones kept out of: fenced at all of them ({_names(limited)})",) if limited else ()
    return times + ((f"water inside land and zones: fenced with them ({_names(holed)})",) if holed else ())


def _names(fences: Sequence[Fence]) -> str:
    named = list(dict.fromkeys(fence.name for fence in fences))
    more = f" and {len(named) - _NAMES} more" if len(named) > _NAMES else ""
    return ", ".join(named[:_NAMES]) + more


def unheld_moorings(plan: Plan) -> tuple[str, ...]:
    """Say of each mooring that a format cannot hold it, with the numbers that the crew needs."""
    return tuple(
        f"the mooring {mooring.name} (release {mooring.release_time:.1f} s after the fix on arrival, by "
        f"{mooring.release_time_p99:.1f} s in 99 % of cases; hold {mooring.hold:.0f} s; galvanic release "
        f"{mooring.galvanic_release:.0f} s; line {mooring.line_length:.2f} m)"
        for mooring in plan.moorings
    )


def one_line(text: str) -> str:
    """Return a text without line breaks."""
    return " ".join(text.split())


def plain(text: str) -> str:
    """Return a text in ASCII, for vehicles that read nothing else."""
    text = text.replace("±", "+-").replace("–", "-").replace("·", ".")
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()


def token(number: int | str, name: str) -> str:
    """Return a name that holds letters, digits and underscores alone, unlike that of any other number."""
    return f"{number}_{re.sub('[^A-Za-z0-9]+', '_', plain(name))[:_LONGEST].strip('_') or 'phase'}"


Element = ElementTree.Element

_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def add(parent: Element, tag: str, text: str | None = None, **attributes: str) -> Element:
    """Add an element; characters that XML cannot hold are replaced."""
    child = ElementTree.SubElement(parent, tag, {name: mended(value) for name, value in attributes.items()})
    if text is not None:
        child.text = mended(text)
    return child


Content = Mapping[str, "str | Content | Sequence[str | Content]"]
"""What is inside an element: by tag a text, what is inside, or several; an attribute by ``@`` and its name, the
element's own text beside attributes by the empty tag."""


def filled(element: Element, content: Content) -> Element:
    """Put into an element what is to be inside; characters that XML cannot hold are replaced."""
    for tag, contents_of_tag in content.items():
        for part in [contents_of_tag] if isinstance(contents_of_tag, str | Mapping) else contents_of_tag:
            if not isinstance(part, str):
                filled(ElementTree.SubElement(element, tag), part)
            elif tag.startswith("@"):
                element.set(tag[1:], mended(part))
            else:
                (ElementTree.SubElement(element, tag) if tag else element).text = mended(part)
    return element


def mended(text: str) -> str:
    """Replace what XML cannot hold."""
    return _NOT_IN_XML.sub("\ufffd", text)


def document(root: Element, *comments: str) -> str:
    """Write a document, indented, with comments before its root."""
    ElementTree.indent(root, " ")
    before = "".join(f"<!-- {mended(comment).replace('--', '- -')} -->\n" for comment in comments)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{before}{ElementTree.tostring(root, encoding="unicode")}\n'


FORMATS = {
    "csv": "missionplan.exporters.table",
    "json": "missionplan.exporters.plan_json",
    "svg": "missionplan.exporters.drawing",
    "gpx": "missionplan.exporters.gpx",
    "geojson": "missionplan.exporters.geojson",
    "kml": "missionplan.exporters.kml",
    "gpkg": "missionplan.exporters.geopackage",
    "slocum": "missionplan.exporters.slocum",
    "moos": "missionplan.exporters.moos",
    "neptus": "missionplan.exporters.neptus",
    "iver": "missionplan.exporters.iver",
    "qgc": "missionplan.exporters.qgc",
}
"""Module of each format, by the name that the command line takes."""


VEHICLES = ("slocum", "moos", "neptus", "iver", "qgc")
"""Formats that a vehicle carries out by itself: what it does is what their modules' `executes` say."""
Executes = Callable[[PlannedTransit], Execution]
"""How a vehicle carries out a transit that was written for it."""


class Format(Protocol):
    """What the module of a format has."""

    TITLE: str
    NEEDS_ORIGIN: bool

    def lost(self, plan: Plan, /) -> tuple[str, ...]:
        """Say what the format cannot hold of a plan."""

    def files(self, plan: Plan, stem: str, /) -> dict[str, str | bytes]:
        """Write the files, by name; `stem` begins the names."""


def execution_of(name: str) -> Executes | None:
    """Return how the vehicle of a format carries out a transit; None for a format of maps and tables."""
    return cast(Executes, import_module(FORMATS[name]).executes) if name in VEHICLES else None


def refusals_of(name: str, plan: Plan) -> tuple[Problem, ...]:
    """Return what of a plan the vehicle of a format cannot do, so that none is written."""
    check: Callable[[Plan], tuple[Problem, ...]] | None = getattr(import_module(FORMATS[name]), "refusals", None)
    return check(plan) if check is not None else ()


def format_named(name: str) -> Format:
    """Return the module of a format."""
    return cast(Format, import_module(FORMATS[name]))


def conformance(name: str) -> Mapping[GuardKind, str]:
    """Return what the format of a vehicle does with each guard, in words."""
    return cast(Mapping[GuardKind, str], import_module(FORMATS[name]).CONFORMANCE)


def conformance_table() -> str:
    """Return the table of the reference: guards by formats, in Markdown."""
    columns = [conformance(name) for name in VEHICLES]
    lines = [f"| guard | {' | '.join(f'`{name}`' for name in VEHICLES)} |", "|---" * (len(VEHICLES) + 1) + "|"]
    for guard, (words, unit) in GUARDS.items():
        asked = words.format(f"so many {unit}" if unit else "")
        lines.append(f"| {asked} | {' | '.join(column[guard] for column in columns)} |")
    return "\n".join(lines) + "\n"
