"""The command `tide`: constituents of a record of a current."""

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import checked_folder, deliver, progress_bar
from missionplan.errors import InputError, Problem, shown


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

    north, since = _angle(latitude), _moment(start)
    folder = checked_folder(output, record.stem, "tide", [record])
    with progress_bar("tide", shown=not output.quiet) as progress:
        result = find_tide(record, latitude=north, start=since, progress=progress)
    deliver(result, folder, output)


def _angle(text: str | None) -> float | None:
    if text is None:
        return None
    from missionplan.mission.units import QuantityError, parse_number_with_unit

    try:
        return parse_number_with_unit(text, "rad")
    except QuantityError as error:
        hint = "a latitude such as '37.2 deg'; south is negative"
        raise InputError([Problem(each.message, key="latitude", hint=hint) for each in error.problems]) from None


def _moment(text: str | None) -> datetime | None:
    if text is None:
        return None
    try:
        return datetime.fromisoformat(text)
    except ValueError:
        message = f"given {shown(text)}, expected a time such as 2026-05-01T06:00:00Z"
        raise InputError([Problem(message, key="start")]) from None
