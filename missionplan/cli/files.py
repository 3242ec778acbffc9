"""Commands about files: validate."""

from pathlib import Path
from typing import Annotated

import typer

from missionplan.cli import options as o
from missionplan.errors import InputError, Problem


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(validate)


def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION...", help="Mission files.", show_default=False)],
    allow_outside: o.AllowOutside = False,
    quiet: o.Quiet = False,
) -> None:
    """Check mission files and run nothing."""
    from missionplan.mission import load

    problems: list[Problem] = []
    for path in missions:
        try:
            mission = load(path, allow_outside=allow_outside)
        except InputError as error:
            problems += error.problems
            continue
        if not quiet:
            uncertain = len(mission.uncertain())
            kinds = ", ".join(phase.kind for phase in mission.phases) or "none"
            typer.echo(f"{path}: valid. Phases: {kinds}; {uncertain} quantities are distributions.")
            for notice in mission.notices():
                typer.echo(f"{path}: {notice}", err=True)
    if problems:
        raise InputError(problems)
