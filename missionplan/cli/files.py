"""Commands about files: validate, init, effects, compare, reports, schema, verify."""

import json
import sys
import textwrap
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import missionplan
from missionplan.cli import options as o
from missionplan.cli.options import note, print_json
from missionplan.cli.running import deliver, progress_bar, report_folder
from missionplan.errors import InputError, Problem, did_you_mean, shown

if TYPE_CHECKING:
    from missionplan.studies.validate import Validated


def init(
    folder: Annotated[Path, typer.Argument(metavar="[DIR]", help="Folder to write to.")] = Path(),
    data: Annotated[str | None, typer.Option(metavar="KIND", help="Write a data set of this kind instead.")] = None,
    loop: Annotated[
        bool, typer.Option("--loop", help="Write the files of the second round of docs/loop.md instead.")
    ] = False,
    as_json: o.JsonAnswer = False,
    quiet: o.Quiet = False,
) -> None:
    """Write a commented starter mission, vehicle and data set; no file is overwritten."""
    from missionplan.studies.init import init, init_data

    if data is not None and loop:
        raise InputError([Problem("given with --data, expected one of them", key="--loop")])
    written = init(folder, loop=loop) if data is None else init_data(data, folder)
    if as_json:
        print_json(files=written)
    elif not quiet:
        for path in written:
            typer.echo(str(path))


_EffectId = Annotated[str, typer.Argument(metavar="[ID]", help="Effect to show; default all.")]


def effects(effect: _EffectId = "", as_json: o.JsonAnswer = False) -> None:
    """List the effects that missions and diagnoses know, a line each; with an ID, all about one of them."""
    from missionplan.effects import CATALOGUE
    from missionplan.report.effect_catalogue import catalogue_text, effect_text

    if effect and effect not in CATALOGUE:
        raise InputError([Problem(f"no effect of the name {shown(effect)}", hint=did_you_mean(effect, CATALOGUE))])
    if as_json:
        print_json(effects=[CATALOGUE[effect]] if effect else list(CATALOGUE.values()))
    else:
        typer.echo(effect_text(CATALOGUE[effect]) if effect else catalogue_text())


_Compared = Annotated[
    list[Path], typer.Argument(metavar="A B...", help="Report folders or mission files, two or more.")
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
    read = [path / "summary.json" if path.is_dir() else path for path in compared]

    with report_folder(output, compared[-1].resolve().stem, "compare", read) as folder:
        with progress_bar("compare", shown=not output.quiet) as progress:
            comparison = missionplan.compare(
                *compared,
                trials=trials,
                seed=seed,
                jobs=o.worker_count(jobs),
                allow_outside=allow_outside,
                progress=progress,
            )
        deliver(comparison, folder, output)


_Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Mission files, data sets, and folders of them.")]


def validate(
    files: _Files, allow_outside: o.AllowOutside = False, as_json: o.JsonAnswer = False, quiet: o.Quiet = False
) -> None:
    """Check missions and data sets without running anything, and list which commands each is ready for."""
    checks = missionplan.validate(files, allow_outside=allow_outside)
    if as_json and not any(check.problems for check in checks):
        print_json(files=[_valid(check) for check in checks])
    elif not quiet and not as_json:
        for check in (check for check in checks if not check.problems):
            typer.echo(f"{check.path}: {check.summary}")
            for line in (*check.values, *check.table):
                typer.echo(f"  {line}")
            for notice in check.notices:
                note(f"{check.path}: {notice}")
    problems: list[Problem] = [problem for check in checks for problem in check.problems]
    if problems:
        raise InputError(problems)


def _valid(check: "Validated") -> dict[str, object]:
    return {
        "file": str(check.path),
        "summary": check.summary,
        "values": [str(value) for value in check.values],
        "commands": [
            {"command": row.command, "ready": not row.needs, "needs": list(row.needs), "without": row.without}
            for row in check.table
        ],
        "notices": list(check.notices),
    }


OTHER_BITS = 3
"""Exit status of `verify` where other bits come out."""
_WIDTH = 80
_LINES = 3
"""Of an answer."""

_Number = Annotated[int | None, typer.Argument(metavar="[NUMBER]", help="Report to open, as listed.")]
_Root = Annotated[Path, typer.Option(metavar="DIR", help="Folder of the reports.")]


def reports(number: _Number = None, root: _Root = Path("reports"), as_json: o.JsonAnswer = False) -> None:
    """List the reports made so far, the newest first; with a NUMBER, open that one in the browser.

    missionplan reports 1 opens the newest.
    """
    entries = missionplan.reports(root)
    if number is not None and not 1 <= number <= len(entries):
        raise InputError([Problem(f"given {number}, expected 1 to {len(entries)}", key="NUMBER", file=str(root))])
    if as_json:
        print_json(reports=entries if number is None else [entries[number - 1]])
    elif number is None:
        for place, entry in enumerate(entries, start=1):
            when = f"{entry.created:%Y-%m-%d %H:%M}" if entry.created else "(no date)"
            head = f"{place:>3}  {when}  {entry.command}"
            mission = textwrap.shorten(entry.mission, max(_WIDTH - len(head) - 3, 20), placeholder=" ...")
            typer.echo(f"{head}: {mission}" if mission else head)
            answer = textwrap.wrap(
                entry.answer, _WIDTH - 5, max_lines=_LINES, placeholder=" ...", break_on_hyphens=False
            )
            for line in (*answer, entry.folder):
                typer.echo(f"     {line}")
        if not entries:
            note(f"There are no reports in {root} yet.")
    else:
        page = entries[number - 1].page
        typer.echo(str(page))
        if not webbrowser.open(page.resolve().as_uri()):
            note("No browser could be started: open that file in one.")


_Report = Annotated[Path, typer.Argument(metavar="REPORT", help="Report folder.")]
_All = Annotated[bool, typer.Option("--all", help="All blocks of simulate, and every number that follows from them.")]


def verify(
    report: _Report,
    all_blocks: _All = False,
    jobs: o.Jobs = 0,
    allow_outside: o.AllowOutside = False,
    as_json: o.JsonAnswer = False,
    quiet: o.Quiet = False,
) -> None:
    """Compute some blocks of a report again, and say whether the same bits come out here, and if not, what differs.

    Reports of studies that keep no blocks are computed again as a whole. Exit status 3: other bits come out.
    """
    with progress_bar("verify", shown=not quiet) as progress:
        processes = o.worker_count(jobs)
        verification = missionplan.verify(
            report, all_blocks=all_blocks, jobs=processes, allow_outside=allow_outside, progress=progress
        )
    if as_json:
        from missionplan.results import to_json

        sys.stdout.write(to_json(verification.summary()))
    elif not quiet:
        typer.echo(str(verification))
    if not verification.same:
        raise typer.Exit(OTHER_BITS)


_Kind = Annotated[str, typer.Argument(metavar="KIND", help="mission, vehicle, dataset, summary or plan.")]


def schema(kind: _Kind, as_json: o.JsonAnswer = False) -> None:
    """Print the JSON schema of mission, vehicle or data set files, summary.json or plan.json, for editors and checks.

    missionplan schema mission > mission.json; then begin a mission with: # yaml-language-server: $schema=mission.json
    """
    from missionplan.studies.schema import KINDS, schema

    if kind not in KINDS:
        hint = did_you_mean(kind, KINDS)
        raise InputError([Problem(f"given {shown(kind)}, expected {', '.join(KINDS)}", file="KIND", hint=hint)])
    typer.echo(json.dumps(schema(kind), indent=None if as_json else 2, ensure_ascii=False))
