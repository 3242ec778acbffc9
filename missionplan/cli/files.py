"""Commands about files: validate missions and data sets, write a starter mission, list effects, compare reports."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, progress_bar, report_folder
from missionplan.cli.streams import note
from missionplan.errors import InputError, Problem, did_you_mean, shown

if TYPE_CHECKING:
    from missionplan.studies.validation.validate import Validated


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(validate)
    app.command()(init)
    app.command()(effects)
    app.command()(o.with_option_groups(compare))


def init(
    folder: Annotated[Path, typer.Argument(metavar="[DIR]", help="Folder to write to.")] = Path(),
    data: Annotated[
        str | None, typer.Option(metavar="KIND", help="Write a data set of this kind instead.", show_default=False)
    ] = None,
    loop: Annotated[
        bool,
        typer.Option("--loop", help="Write the files of the second round of docs/loop.md instead.", show_default=False),
    ] = False,
    quiet: o.Quiet = False,
) -> None:
    """Write a commented starter mission, vehicle and data set; no file is overwritten."""
    from missionplan.studies.init import init, init_data

    if data is not None and loop:
        raise InputError([Problem("given with --data, expected one of them", key="--loop")])
    written = init(folder, loop=loop) if data is None else init_data(data, folder)
    if not quiet:
        for path in written:
            typer.echo(str(path))


_EffectId = Annotated[str, typer.Argument(metavar="[ID]", help="Effect to show; default all.", show_default=False)]


def effects(effect: _EffectId = "") -> None:
    """List the effects that missions and diagnoses know, a line each; with an ID, all about one of them."""
    from missionplan.effects import CATALOGUE
    from missionplan.report.effect_catalogue import catalogue_text, effect_text

    if effect and effect not in CATALOGUE:
        raise InputError([Problem(f"no effect of the name {shown(effect)}", hint=did_you_mean(effect, CATALOGUE))])
    typer.echo(effect_text(CATALOGUE[effect]) if effect else catalogue_text())


_Compared = Annotated[
    list[Path],
    typer.Argument(metavar="A B...", help="Report folders or mission files, two or more.", show_default=False),
]


def compare(
    compared: _Compared,
    trials: o.Trials = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    *,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Compare two reports of one command, what changed and is it more than noise; or missions: which is better.

    Missions are run on the same random numbers, so that small differences show. More than two reports must be of
    simulate, of explore, or of optimise. Example: missionplan compare slow.yaml fast.yaml faster.yaml --trials 2000
    """
    read = [each / "summary.json" if each.is_dir() else each for each in compared]
    from missionplan.studies.comparison.compare_missions import compare

    with report_folder(output, compared[-1].resolve().stem, "compare", read) as folder:
        with progress_bar("compare", shown=not output.quiet) as progress:
            found = compare(
                *compared,
                trials=trials,
                seed=seed,
                jobs=o.worker_count(jobs),
                allow_outside=allow_outside,
                progress=progress,
            )
        deliver(found, folder, output)


_Files = Annotated[
    list[Path],
    typer.Argument(metavar="FILE...", help="Mission files, data sets, and folders of them.", show_default=False),
]


def validate(
    files: _Files, allow_outside: o.AllowOutside = False, as_json: o.Json = False, quiet: o.Quiet = False
) -> None:
    """Check missions and data sets without running anything, and list which commands each is ready for."""
    from missionplan.studies.validation.validate import validate

    found = validate(files, allow_outside=allow_outside)
    if as_json and not any(each.problems for each in found):
        typer.echo(json.dumps({"errors": [], "files": [_valid(each) for each in found]}, indent=1))
    elif not quiet and not as_json:
        for each in found:
            _print_valid(each)
    problems: list[Problem] = [problem for each in found for problem in each.problems]
    if problems:
        raise InputError(problems)


def _valid(found: "Validated") -> dict[str, object]:
    return {
        "file": str(found.path),
        "summary": found.summary,
        "values": [str(value) for value in found.values],
        "commands": [
            {"command": row.command, "ready": not row.needs, "needs": list(row.needs), "without": row.without}
            for row in found.table
        ],
        "notices": list(found.notices),
    }


def _print_valid(found: "Validated") -> None:
    if found.problems:
        return
    typer.echo(f"{found.path}: {found.summary}")
    for value in found.values:
        typer.echo(f"  {value}")
    for row in found.table:
        typer.echo(f"  {row}")
    for notice in found.notices:
        note(f"{found.path}: {notice}")
