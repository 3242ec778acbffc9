"""`reports`: what was computed so far, and one of the reports opened; `schema`: what files may hold, for editors."""

import textwrap
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from missionplan.cli.streams import note
from missionplan.errors import InputError, Problem, did_you_mean, shown

if TYPE_CHECKING:
    from missionplan.store.reports import ReportEntry

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


_Kind = Annotated[str, typer.Argument(metavar="KIND", help="mission, vehicle or dataset.", show_default=False)]


def schema(kind: _Kind) -> None:
    """Print the JSON schema of mission, vehicle or data set files, for completion and checks in editors.

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
