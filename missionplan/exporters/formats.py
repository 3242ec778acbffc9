"""The formats that a plan can be written in, by name."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Protocol, cast

from missionplan.errors import Problem
from missionplan.phases.transit.execution import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_states import GUARDS, GuardKind

FORMATS = {
    "csv": "missionplan.exporters.table",
    "json": "missionplan.exporters.plan_json",
    "svg": "missionplan.exporters.drawing",
    "gpx": "missionplan.exporters.maps.gpx",
    "geojson": "missionplan.exporters.maps.geojson",
    "kml": "missionplan.exporters.maps.kml",
    "gpkg": "missionplan.exporters.maps.geopackage",
    "slocum": "missionplan.exporters.vehicles.slocum",
    "moos": "missionplan.exporters.vehicles.moos",
    "neptus": "missionplan.exporters.vehicles.neptus",
    "iver": "missionplan.exporters.vehicles.iver",
    "qgc": "missionplan.exporters.vehicles.qgc",
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
    told = [conformance(name) for name in VEHICLES]
    lines = [f"| guard | {' | '.join(f'`{name}`' for name in VEHICLES)} |", "|---" * (len(VEHICLES) + 1) + "|"]
    for guard, (words, unit) in GUARDS.items():
        asked = words.format(f"so many {unit}" if unit else "")
        lines.append(f"| {asked} | {' | '.join(each[guard] for each in told)} |")
    return "\n".join(lines) + "\n"
