"""What every study's command does around the study: load, progress, save, tell."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from missionplan.cli.options import Output

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result

Study = Callable[["Mission", Any], "Result"]
"""A study of a loaded mission, and the progress that it reports to."""


def run_study(path: Path, command: str, study: Study, output: Output, *, allow_outside: bool) -> "Result":
    """Load a mission, run a study of it, save the report and say what came out."""
    from missionplan.mission import load
    from missionplan.store.folder import check_new_folder

    folder = output.out or report_folder(path.stem, command)
    check_new_folder(folder, force=output.force)
    mission = load(path, allow_outside=allow_outside)
    with progress_bar(command, shown=not output.quiet) as progress:
        result = study(mission, progress)
    return deliver(result, folder, output)


def report_folder(stem: str, command: str) -> Path:
    """Name the report folder of a command that starts now."""
    return Path("reports") / stem / f"{command}-{datetime.now(UTC):%Y%m%dT%H%M%SZ}"


def deliver(result: "Result", folder: Path, output: Output, *, force: bool | None = None) -> "Result":
    """Save a result, then say it: as JSON for scripts, else as a sentence and a compact table."""
    result.save(folder, force=output.force if force is None else force)
    if output.as_json:
        from missionplan.results.base import to_json

        sys.stdout.write(to_json(result.summary()))
    elif not output.quiet:
        _tell(result, folder)
    return result


def _tell(result: "Result", folder: Path) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from missionplan.report.render import terminal_view

    shown = terminal_view(result)
    console = Console(highlight=False)
    console.print(f"[bold]{escape(shown.sentence)}[/bold]")
    table = Table(box=None, pad_edge=False, header_style="dim")
    for index, column in enumerate(shown.columns):
        table.add_column(escape(column), justify="left" if index == 0 else "right", no_wrap=index > 0)
    for row in shown.rows:
        table.add_row(*(escape(cell) for cell in row))
    console.print(table)
    sys.stdout.flush()
    for notice in result.provenance.notices:
        typer.echo(f"Note: {notice}", err=True)
    typer.echo(f"Report: {folder / 'report.html'}", err=True)


@contextmanager
def progress_bar(label: str, *, shown: bool) -> Iterator[Callable[[int, int], None] | None]:
    """Show a bar with rate and time left on standard error; yields what a study calls with (done, total)."""
    if not shown or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    class Rate(TextColumn):
        def render(self, task: Any) -> Any:
            from rich.text import Text

            return Text(f"{task.speed:,.0f}/s".replace(",", " ") if task.speed else "")

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Rate(""), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(label, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
