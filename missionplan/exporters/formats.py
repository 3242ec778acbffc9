"""The formats that a plan can be written in, by name."""

from importlib import import_module
from typing import Protocol, cast

from missionplan.results.plan import Plan

FORMATS = {
    "csv": "missionplan.exporters.table",
    "json": "missionplan.exporters.plan_json",
    "gpx": "missionplan.exporters.maps.gpx",
    "geojson": "missionplan.exporters.maps.geojson",
    "kml": "missionplan.exporters.maps.kml",
    "gpkg": "missionplan.exporters.maps.geopackage",
    "slocum": "missionplan.exporters.vehicles.slocum",
    "moos": "missionplan.exporters.vehicles.moos",
    "neptus": "missionplan.exporters.vehicles.neptus",
    "iver": "missionplan.exporters.vehicles.iver",
}
"""Module of each format, by the name that the command line takes."""


class Format(Protocol):
    """What the module of a format has."""

    TITLE: str
    NEEDS_ORIGIN: bool

    def lost(self, plan: Plan, /) -> tuple[str, ...]:
        """Say what the format cannot hold of a plan."""

    def files(self, plan: Plan, stem: str, /) -> dict[str, str | bytes]:
        """Write the files, by name; `stem` begins the names."""


def format_named(name: str) -> Format:
    """Return the module of a format."""
    return cast(Format, import_module(FORMATS[name]))
