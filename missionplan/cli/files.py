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
from missionplan.cli.options import note
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


_EffectId = Annotated[str, typer.Argument(metavar="[ID]", help="Effect to show; default all.")]


def effects(effect: _EffectId = "") -> None:
    """List the effects that missions and diagnoses know, a line each; with an ID, all about one of them."""
    from missionplan.effects import CATALOGUE
    from missionplan.report.effect_catalogue import catalogue_text, effect_text

    if effect and effect not in CATALOGUE:
        raise InputError([Problem(f"no effect of the name {shown(effect)}", hint=did_you_mean(effect, CATALOGUE))])
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
    read = [each / "summary.json" if each.is_dir() else each for each in compared]

    with report_folder(output, compared[-1].resolve().stem, "compare", read) as folder:
        with progress_bar("compare", shown=not output.quiet) as progress:
            found = missionplan.compare(
                *compared,
                trials=trials,
                seed=seed,
                jobs=o.worker_count(jobs),
                allow_outside=allow_outside,
                progress=progress,
            )
        deliver(found, folder, output)


_Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Mission files, data sets, and folders of them.")]


def validate(
    files: _Files, allow_outside: o.AllowOutside = False, as_json: o.Json = False, quiet: o.Quiet = False
) -> None:
    """Check missions and data sets without running anything, and list which commands each is ready for."""
    found = missionplan.validate(files, allow_outside=allow_outside)
    if as_json and not any(each.problems for each in found):
        typer.echo(json.dumps({"errors": [], "files": [_valid(each) for each in found]}, indent=1))
    elif not quiet and not as_json:
        for each in (each for each in found if not each.problems):
            typer.echo(f"{each.path}: {each.summary}")
            for line in (*each.values, *each.table):
                typer.echo(f"  {line}")
            for notice in each.notices:
                note(f"{each.path}: {notice}")
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


OTHER_BITS = 3
"""Exit status of `verify` where other bits come out."""
_WIDTH = 80
_LINES = 3
"""Of an answer."""

_Number = Annotated[int | None, typer.Argument(metavar="[NUMBER]", help="Report to open, as listed.")]
_Root = Annotated[Path, typer.Option(metavar="DIR", help="Folder of the reports.")]


def reports(number: _Number = None, root: _Root = Path("reports")) -> None:
    """List the reports made so far, the newest first; with a NUMBER, open that one in the browser.

    missionplan reports 1 opens the newest.
    """
    found = missionplan.reports(root)
    if number is None:
        for place, entry in enumerate(found, start=1):
            when = f"{entry.created:%Y-%m-%d %H:%M}" if entry.created else "(no date)"
            head = f"{place:>3}  {when}  {entry.command}"
            mission = textwrap.shorten(entry.mission, max(_WIDTH - len(head) - 3, 20), placeholder=" ...")
            typer.echo(f"{head}: {mission}" if mission else head)
            answer = textwrap.wrap(
                entry.answer, _WIDTH - 5, max_lines=_LINES, placeholder=" ...", break_on_hyphens=False
            )
            for line in (*answer, entry.folder):
                typer.echo(f"     {line}")
        if not found:
            note(f"There are no reports in {root} yet.")
        return
    if not 1 <= number <= len(found):
        raise InputError([Problem(f"given {number}, expected 1 to {len(found)}", key="NUMBER", file=str(root))])
    page = found[number - 1].page
    typer.echo(str(page))
    if not webbrowser.open(page.resolve().as_uri()):
        note("No browser could be started: open that file in one.")


_Report = Annotated[Path, typer.Argument(metavar="REPORT", help="Report folder.")]
_All = Annotated[bool, typer.Option("--all", help="All blocks of simulate, and every number that follows from them.")]
_Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON on standard output.")]


def verify(
    report: _Report,
    all_blocks: _All = False,
    jobs: o.Jobs = 0,
    allow_outside: o.AllowOutside = False,
    as_json: _Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Compute some blocks of a report again, and say whether the same bits come out here, and if not, what differs.

    Reports of studies that keep no blocks are computed again as a whole. Exit status 3: other bits come out.
    """
    with progress_bar("verify", shown=not quiet) as progress:
        processes = o.worker_count(jobs)
        found = missionplan.verify(
            report, all_blocks=all_blocks, jobs=processes, allow_outside=allow_outside, progress=progress
        )
    if as_json:
        from missionplan.results import to_json

        sys.stdout.write(to_json(found.summary()))
    elif not quiet:
        typer.echo(str(found))
    if not found.same:
        raise typer.Exit(OTHER_BITS)


_Kind = Annotated[str, typer.Argument(metavar="KIND", help="mission, vehicle, dataset, summary or plan.")]


def schema(kind: _Kind) -> None:
    """Print the JSON schema of mission, vehicle or data set files, summary.json or plan.json, for editors and checks.

    missionplan schema mission > mission.json; then begin a mission with: # yaml-language-server: $schema=mission.json
    """
    import json

    from missionplan.studies.schema import KINDS, schema

    if kind not in KINDS:
        hint = did_you_mean(kind, KINDS)
        raise InputError([Problem(f"given {shown(kind)}, expected {', '.join(KINDS)}", file="KIND", hint=hint)])
    typer.echo(json.dumps(schema(kind), indent=2, ensure_ascii=False))
