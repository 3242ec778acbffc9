"""`reports`: what was computed so far, and one of the reports opened; `schema`: what files may hold, for editors."""

import sys
import textwrap
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import progress_bar
from missionplan.cli.streams import note
from missionplan.errors import InputError, Problem, did_you_mean, shown

if TYPE_CHECKING:
    from missionplan.store.reports import ReportEntry

OTHER_BITS = 3
"""Exit status of `verify` where other bits come out."""
_WIDTH = 80
_LINES = 3
"""Of an answer."""

_Number = Annotated[
    int | None, typer.Argument(metavar="[NUMBER]", help="Report to open, as listed.", show_default=False)
]
_Root = Annotated[Path, typer.Option(metavar="DIR", help="Folder of the reports.")]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(reports)
    app.command()(schema)
    app.command()(verify)


def reports(number: _Number = None, root: _Root = Path("reports")) -> None:
    """List the reports made so far, the newest first; with a NUMBER, open that one in the browser.

    missionplan reports 1 opens the newest.
    """
    from missionplan.store.reports import reports

    found = reports(root)
    if number is None:
        for place, entry in enumerate(found, start=1):
            typer.echo("\n".join(_lines(place, entry)))
        if not found:
            note(f"There are no reports in {root} yet.")
        return
    if not 1 <= number <= len(found):
        raise InputError([Problem(f"given {number}, expected 1 to {len(found)}", key="NUMBER", file=str(root))])
    page = found[number - 1].page
    typer.echo(str(page))
    if not webbrowser.open(page.resolve().as_uri()):
        note("No browser could be started: open that file in one.")


_Report = Annotated[Path, typer.Argument(metavar="REPORT", help="Report folder.", show_default=False)]
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
    from missionplan.verification import verify

    with progress_bar("verify", shown=not quiet) as progress:
        found = verify(
            report,
            all_blocks=all_blocks,
            jobs=o.worker_count(jobs),
            allow_outside=allow_outside,
            progress=progress,
        )
    if as_json:
        from missionplan.results.base import to_json

        sys.stdout.write(to_json(found.summary()))
    elif not quiet:
        typer.echo(str(found))
    if not found.same:
        raise typer.Exit(OTHER_BITS)


_Kind = Annotated[
    str, typer.Argument(metavar="KIND", help="mission, vehicle, dataset, summary or plan.", show_default=False)
]


def schema(kind: _Kind) -> None:
    """Print the JSON schema of mission, vehicle or data set files, summary.json or plan.json, for editors and checks.

    missionplan schema mission > mission.json; then begin a mission with: # yaml-language-server: $schema=mission.json
    """
    import json

    from missionplan.studies.schemas.schema import KINDS, schema

    if kind not in KINDS:
        hint = did_you_mean(kind, KINDS)
        raise InputError([Problem(f"given {shown(kind)}, expected {', '.join(KINDS)}", file="KIND", hint=hint)])
    typer.echo(json.dumps(schema(kind), indent=2, ensure_ascii=False))


def _lines(place: int, entry: "ReportEntry") -> list[str]:
    when = f"{entry.created:%Y-%m-%d %H:%M}" if entry.created else "(no date)"
    head = f"{place:>3}  {when}  {entry.command}"
    mission = textwrap.shorten(entry.mission, max(_WIDTH - len(head) - 3, 20), placeholder=" ...")
    answer = textwrap.wrap(entry.answer, _WIDTH - 5, max_lines=_LINES, placeholder=" ...", break_on_hyphens=False)
    return [f"{head}: {mission}" if mission else head, *(f"     {line}" for line in answer), f"     {entry.folder}"]
