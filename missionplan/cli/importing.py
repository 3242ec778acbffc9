"""The command `import`: a vehicle's own logs to a data set."""

import re
from pathlib import Path
from typing import Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, progress_bar, report_folder
from missionplan.errors import InputError, Problem, shown
from missionplan.store.paths import exists, is_file


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("import")(import_)


_Sources = Annotated[
    list[str], typer.Argument(metavar="SOURCE...", help="Log files, and folders of them.", show_default=False)
]
_Out = Annotated[Path, typer.Option("--out", "-o", metavar="DATASET", help="Folder of the data set.")]
_Format = Annotated[str | None, typer.Option(help="Format of the logs; default: as recognised.", show_default=False)]
_Kind = Annotated[str, typer.Option(help="transit (legs between fixes) or descent (dives).")]
_Map = Annotated[
    list[str] | None,
    typer.Option("--map", metavar="QUANTITY=NAME[UNIT]", help="Columns, variables, topics; or a YAML file of them."),
]
_Cache = Annotated[
    Path | None, typer.Option(help="Folder of a Slocum's sensor lists; default: beside the logs.", show_default=False)
]
_Name = Annotated[str | None, typer.Option(help="Name of the data set; default: the vehicle's.", show_default=False)]
_Shift = Annotated[
    str | None, typer.Option(metavar="LAT,LON", help="Move the first fix to a made-up place.", show_default=False)
]
_Shortest = Annotated[
    str | None,
    typer.Option(
        metavar="TIME",
        help="Shortest leg that counts; default: half of a leg as planned or usual, 15 min at most.",
        show_default=False,
    ),
]
_Gap = Annotated[
    str | None, typer.Option(metavar="TIME", help="Longest gap in a leg; default: 120 s.", show_default=False)
]
_DiveDepth = Annotated[
    str | None, typer.Option(metavar="DEPTH", help="Depth that a dive reaches; default: 5 m.", show_default=False)
]
_TakeOut = Annotated[
    bool,
    typer.Option("--take-out-current", help="Take the vehicle's own estimate of the current out of its positions."),
]
_Mark = Annotated[
    list[str] | None, typer.Option(metavar="TIME", help="When an anchor separated (dives); may be repeated.")
]
_Vehicle = Annotated[str | None, typer.Option(help="Vehicle, where the files are of several.", show_default=False)]
_Deployment = Annotated[
    str | None, typer.Option(help="Deployment, where the files are of several: its name or date.", show_default=False)
]
_Strict = Annotated[bool, typer.Option("--strict", help="Stop at a damaged file instead of passing it over.")]
_Explain = Annotated[
    list[int] | None, typer.Option(metavar="LEG", help="Tell and draw what a leg rests on; may be repeated.")
]
_Force = Annotated[bool, typer.Option("--force", help="Overwrite files in a folder that is not empty.")]
_Json = Annotated[
    bool, typer.Option("--json", help="Print the summary as JSON on standard output, and nothing else there.")
]


def import_(
    sources: _Sources,
    out: _Out,
    format: _Format = None,
    kind: _Kind = "transit",
    map: _Map = None,
    cache: _Cache = None,
    name: _Name = None,
    shift_origin: _Shift = None,
    shortest: _Shortest = None,
    longest_gap: _Gap = None,
    dive_depth: _DiveDepth = None,
    take_out_current: _TakeOut = False,
    mark: _Mark = None,
    vehicle: _Vehicle = None,
    deployment: _Deployment = None,
    strict: _Strict = False,
    explain: _Explain = None,
    force: _Force = False,
    as_json: _Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Make a data set of a vehicle's own logs, with a report of what was made of them and a starter mission."""
    from missionplan.importers.dives import LegRules
    from missionplan.importers.importing import import_logs
    from missionplan.importers.mapping import ASSIGNMENT

    # `--map lat=A lon=B` leaves the second to the sources
    entries = [each for each in sources if ASSIGNMENT.fullmatch(each) and not exists(Path(each))]
    paths = [Path(each) for each in sources if each not in entries]
    if not paths:
        raise InputError([Problem("no log files are named", key="map")])
    output = o.OutputOptions(out, force, as_json, quiet)
    rules = LegRules(
        _quantity(shortest, "shortest", "s"),
        _quantity(longest_gap, "longest_gap", "s"),
        _quantity(dive_depth, "dive_depth", "m"),
        take_out_current,
    )
    with report_folder(output, "", "import", [path for path in paths if is_file(path)]) as folder:
        with progress_bar("import", shown=not quiet) as progress:
            result = import_logs(
                paths,
                format=format,
                kind=kind,  # type: ignore[arg-type]  # it is checked there
                names=[*(map or ()), *entries],
                cache=cache,
                name=name,
                shift_origin=_place(shift_origin),
                rules=rules,
                marks=mark or (),
                vehicle=vehicle,
                deployment=deployment,
                is_strict=strict,
                explain=explain or (),
                progress=progress,
            )
        deliver(result, folder, output)


def _quantity(text: str | None, key: str, unit: str) -> float | None:
    """Read an option with a unit, such as ``20 min``."""
    if text is None:
        return None
    from missionplan.mission.units import QuantityError, parse_number_with_unit

    try:
        value = parse_number_with_unit(text, unit)
    except QuantityError as error:
        raise InputError([Problem(problem.message, key=key) for problem in error.problems]) from None
    if value <= 0.0:
        raise InputError([Problem(f"given {shown(text)}, expected more than 0", key=key)])
    return value


def _place(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    found = re.fullmatch(r"\s*([-+]?[\d.]+)\s*,\s*([-+]?[\d.]+)\s*", text)
    try:
        if found:
            return float(found[1]), float(found[2])
    except ValueError:
        pass
    raise InputError(
        [Problem(f"given {shown(text)}, expected a latitude and a longitude such as 10,20", key="shift_origin")]
    )
