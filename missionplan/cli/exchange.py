"""Commands that exchange with vehicles: import their logs, export the plan."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import typer

import missionplan
from missionplan.cli import options as o
from missionplan.cli.measurements import NextTrial, diagnosed
from missionplan.cli.options import print_json, remark
from missionplan.cli.running import Progress, deliver, progress_bar, report_folder
from missionplan.errors import InputError, Problem, shown
from missionplan.store.folder import exists, is_file

if TYPE_CHECKING:
    from missionplan.results.imported import ImportedData


_Sources = Annotated[list[str], typer.Argument(metavar="SOURCE...", help="Log files, and folders of them.")]
_Out = Annotated[Path, typer.Option("--out", "-o", metavar="DATASET", help="Folder of the data set.")]
_Format = Annotated[str | None, typer.Option(help="Format of the logs; default: as recognised.")]
_Kind = Annotated[str, typer.Option(help="transit (legs between fixes) or descent (dives).")]
_Map = Annotated[
    list[str] | None,
    typer.Option("--map", metavar="QUANTITY=NAME[UNIT]", help="Columns, variables, topics; or a YAML file of them."),
]
_Cache = Annotated[Path | None, typer.Option(help="Folder of a Slocum's sensor lists; default: beside the logs.")]
_Name = Annotated[str | None, typer.Option(help="Name of the data set; default: the vehicle's.")]
_Shift = Annotated[str | None, typer.Option(metavar="LAT,LON", help="Move the first fix to a made-up place.")]
_Shortest = Annotated[
    str | None,
    typer.Option(
        metavar="TIME", help="Shortest leg that counts; default: half of a leg as planned or usual, 15 min at most."
    ),
]
_Gap = Annotated[str | None, typer.Option(metavar="TIME", help="Longest gap in a leg; default: 120 s.")]
_DiveDepth = Annotated[str | None, typer.Option(metavar="DEPTH", help="Depth that a dive reaches; default: 5 m.")]
_TakeOut = Annotated[
    bool,
    typer.Option("--take-out-current", help="Take the vehicle's own estimate of the current out of its positions."),
]
_Mark = Annotated[
    list[str] | None, typer.Option(metavar="TIME", help="When an anchor separated (dives); may be repeated.")
]
_Vehicle = Annotated[str | None, typer.Option(help="Vehicle, where the files are of several.")]
_Deployment = Annotated[str | None, typer.Option(help="Deployment, where the files are of several: its name or date.")]
_Strict = Annotated[bool, typer.Option("--strict", help="Stop at a damaged file instead of passing it over.")]
_Explain = Annotated[
    list[int] | None, typer.Option(metavar="LEG", help="Tell and draw what a leg rests on; may be repeated.")
]


@dataclass(frozen=True)
class ImportOptions:
    """How logs are read, and which legs count."""

    format: _Format = None
    kind: _Kind = "transit"
    map: _Map = None
    cache: _Cache = None
    name: _Name = None
    shift_origin: _Shift = None
    shortest: _Shortest = None
    longest_gap: _Gap = None
    dive_depth: _DiveDepth = None
    take_out_current: _TakeOut = False
    mark: _Mark = None
    vehicle: _Vehicle = None
    deployment: _Deployment = None
    strict: _Strict = False
    explain: _Explain = None

    def logs(self, sources: list[str]) -> list[Path]:
        """Return the sources that are logs: `--map lat=A lon=B` leaves the second assignment to the sources."""
        entries = self._entries(sources)
        paths = [Path(source) for source in sources if source not in entries]
        if not paths:
            raise InputError([Problem("no log files are named", key="map")])
        return paths

    def imported(self, sources: list[str], progress: Progress) -> "ImportedData":
        """Import the logs."""
        from missionplan.importers import import_logs
        from missionplan.importers.dives import LegRules

        rules = LegRules(
            _quantity(self.shortest, "shortest", "s"),
            _quantity(self.longest_gap, "longest_gap", "s"),
            _quantity(self.dive_depth, "dive_depth", "m"),
            self.take_out_current,
        )
        return import_logs(
            self.logs(sources),
            format=self.format,
            kind=self.kind,  # type: ignore[arg-type]  # it is checked there
            names=[*(self.map or ()), *self._entries(sources)],
            cache=self.cache,
            name=self.name,
            shift_origin=_place(self.shift_origin),
            rules=rules,
            marks=self.mark or (),
            vehicle=self.vehicle,
            deployment=self.deployment,
            is_strict=self.strict,
            explain=self.explain or (),
            progress=progress,
        )

    @staticmethod
    def _entries(sources: list[str]) -> list[str]:
        from missionplan.importers.mapping import ASSIGNMENT

        return [source for source in sources if ASSIGNMENT.fullmatch(source) and not exists(Path(source))]


def import_(
    sources: _Sources,
    out: _Out,
    *,
    reading: ImportOptions,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Make a data set of a vehicle's own logs, with a report of what was made of them and a starter mission."""
    output = o.OutputOptions(out, force, as_json, quiet)
    with report_folder(output, "", "import", [path for path in reading.logs(sources) if is_file(path)]) as folder:
        with progress_bar("import", shown=not quiet) as progress:
            result = reading.imported(sources, progress)
        deliver(result, folder, output)


_Mission = Annotated[
    Path | None,
    typer.Option(
        "--mission", metavar="MISSION", help="Mission that the vehicle sailed; default: one that is made of its logs."
    ),
]


def why(
    sources: _Sources,
    mission: _Mission = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    *,
    reading: ImportOptions,
    next_trial: NextTrial = False,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Say why the vehicle was not where it reckoned, from its logs: how sure that is, what to do, the next mission.

    It is `import` and `diagnose` in one. The folder holds the report, mission.yaml extended by what was found, the data
    set in `dataset`, and what was made of the logs in dataset/report.html. Example: missionplan why logs/
    """
    from missionplan.diagnosis.campaign import DATASET, MISSION
    from missionplan.report.imported import answer
    from missionplan.report.wording import typeset

    paths = reading.logs(sources)
    with report_folder(output, paths[0].resolve().stem, "why", [path for path in paths if is_file(path)]) as folder:
        dataset = folder / DATASET
        with progress_bar("import", shown=not output.quiet) as progress:
            logs = reading.imported(sources, progress)
        quiet = output.quiet or output.as_json
        if not quiet:
            remark(typeset(answer(logs)))
        deliver(logs, dataset, replace(output, as_json=False, quiet=quiet or not logs.pictures, force=True))
        diagnosis = diagnosed(
            mission or dataset / MISSION,
            [dataset],
            folder,
            seed=seed,
            jobs=jobs,
            next_trial=next_trial,
            holdout=None,
            allow_outside=allow_outside,
            quiet=output.quiet,
        )
        deliver(diagnosis, folder, replace(output, force=True))


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
    match = re.fullmatch(r"\s*([-+]?[\d.]+)\s*,\s*([-+]?[\d.]+)\s*", text)
    try:
        if match:
            return float(match[1]), float(match[2])
    except ValueError:
        pass
    raise InputError(
        [Problem(f"given {shown(text)}, expected a latitude and a longitude such as 10,20", key="shift_origin")]
    )


PlanFormat = Literal[
    "csv", "json", "svg", "gpx", "geojson", "kml", "gpkg", "slocum", "moos", "neptus", "iver", "qgc"
]  # fmt: skip
"""Formats that a plan is written in; the names are those of `missionplan.exporters`."""
_To = Annotated[
    PlanFormat, o.choice(PlanFormat, "--to", metavar="FORMAT", help=f"One of {', '.join(get_args(PlanFormat))}.")
]
_PlanFile = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="File or folder to write; default: MISSION.FORMAT or MISSION-FORMAT here."),
]
_WriteOver = Annotated[bool, typer.Option("--force", help="Write over files that are there.")]


def export(
    mission: o.MissionFile,
    to: _To,
    out: _PlanFile = None,
    seed: o.Seed = None,
    force: _WriteOver = False,
    allow_outside: o.AllowOutside = False,
    as_json: o.JsonAnswer = False,
    quiet: o.Quiet = False,
) -> None:
    """Write the plan as a vehicle takes it: waypoints, depth, speed, time-outs, surfacings, release of the anchor."""
    from missionplan.report.quantities import in_reader_units, reading_in, units_of
    from missionplan.report.wording import typeset

    loaded = missionplan.load(mission, allow_outside=allow_outside)
    written = missionplan.export(loaded, to, out=out, seed=seed, force=force)
    if as_json:
        print_json(files=written.files, notes=written.notes, lost=written.lost)
    if as_json or quiet:
        return
    for path in written.files:
        typer.echo(str(path))
    with reading_in(units_of(loaded.raw)):
        for words in written.notes:
            remark(f"Note: {typeset(in_reader_units(words))}")
        for words in written.lost:
            remark(f"Not in this format: {typeset(in_reader_units(words))}")
