"""The command `tide`: constituents of a record of a current."""

from pathlib import Path
from typing import Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, progress_bar, report_folder


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(o.with_option_groups(tide))


_Record = Annotated[
    Path, typer.Argument(metavar="RECORD", help="Record of a current: CSV or NetCDF.", show_default=False)
]
_Latitude = Annotated[
    str | None,
    typer.Option(metavar="ANGLE", help="Where it was measured; default: as the file says.", show_default=False),
]
_Start = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="From which seconds in a CSV file count (ISO 8601, UTC).", show_default=False),
]


def tide(record: _Record, latitude: _Latitude = None, start: _Start = None, *, output: o.OutputOptions) -> None:
    """Find the tide in a record of a current, with errors, and write it as the current of a mission.

    Example: missionplan tide mooring.csv --latitude '37.2 deg'
    """
    from missionplan.studies.tide.find_tide import tide as find_tide

    with report_folder(output, record.stem, "tide", [record]) as folder:
        with progress_bar("tide", shown=not output.quiet) as progress:
            result = find_tide(record, latitude=latitude, start=start, progress=progress)
        deliver(result, folder, output)
