"""The command that writes plans for vehicles: export."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.streams import remark


class PlanFormat(StrEnum):
    """Formats that a plan is written in; the names are those of `missionplan.exporters.formats`."""

    CSV = "csv"
    JSON = "json"
    GPX = "gpx"
    GEOJSON = "geojson"
    KML = "kml"
    GPKG = "gpkg"
    SLOCUM = "slocum"
    MOOS = "moos"
    NEPTUS = "neptus"
    IVER = "iver"
    QGC = "qgc"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(export)


_To = Annotated[PlanFormat, typer.Option(metavar="FORMAT", help=f"One of {', '.join(PlanFormat)}.", show_default=False)]
_Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        help="File or folder to write; default: MISSION.FORMAT or MISSION-FORMAT here.",
        show_default=False,
    ),
]
_Force = Annotated[bool, typer.Option("--force", help="Write over files that are there.")]


def export(
    mission: o.MissionFile,
    to: _To,
    out: _Out = None,
    seed: o.Seed = None,
    force: _Force = False,
    allow_outside: o.AllowOutside = False,
    quiet: o.Quiet = False,
) -> None:
    """Write the plan as a vehicle takes it: waypoints, depth, speed, time-outs, surfacings, release of the anchor."""
    from missionplan.mission import load
    from missionplan.report.wording import typeset
    from missionplan.studies.mission_plan.export import export

    written = export(load(mission, allow_outside=allow_outside), to.value, out=out, seed=seed, force=force)
    if quiet:
        return
    for path in written.files:
        typer.echo(str(path))
    for words in written.notes:
        remark(f"Note: {typeset(words)}")
    for words in written.lost:
        remark(f"Not in this format: {typeset(words)}")
