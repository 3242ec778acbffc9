"""The command line: load → one study → render → exit status. Heavy imports wait until a command needs them."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from missionplan.errors import InputError, MissionplanError, Problem

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result

app = typer.Typer(
    name="missionplan",
    help="Plan missions of a self-mooring AUV by Monte Carlo, and diagnose what the plan's model gets wrong.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

INTERRUPTED = 130
REQUIREMENT_NOT_MET = 3


class Backend(StrEnum):
    """How blocks of trials are spread."""

    LOKY = "loky"
    THREADING = "threading"
    DASK = "dask"


class Method(StrEnum):
    """How the cost of a d_max is found."""

    BOTH = "both"
    ANALYTIC = "analytic"
    MONTE_CARLO = "monte-carlo"


MissionFile = Annotated[Path, typer.Argument(metavar="MISSION", help="Mission file (YAML).", show_default=False)]
Trials = Annotated[
    int | None, typer.Option(min=1, help="Number of trials; default: the mission's.", show_default=False)
]
Seed = Annotated[int | None, typer.Option(min=0, help="Seed; default: the mission's.", show_default=False)]
Jobs = Annotated[int, typer.Option("--jobs", "-j", help="Processes; 0 = one for each core.", min=0)]
BackendOption = Annotated[Backend, typer.Option(help="How blocks of trials are spread.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler, tcp://host:port.", show_default=False)
]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="Report folder; default: reports/MISSION/COMMAND-TIME.", show_default=False),
]
Force = Annotated[bool, typer.Option("--force", help="Write over files in a folder that is not empty.")]
Json = Annotated[bool, typer.Option("--json", help="Print the summary as JSON, and nothing else, on standard output.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside", help="Permit included files outside the mission's folder.")
]


@dataclass(frozen=True)
class Output:
    """Where a command's answer goes."""

    out: Path | None
    force: bool
    as_json: bool
    quiet: bool


@app.callback(invoke_without_command=True)
def _root(show_version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False) -> None:
    if show_version:
        typer.echo(f"missionplan {version('missionplan')}")
        raise typer.Exit


@app.command("sweep-dmax")
def sweep_dmax_command(
    mission: MissionFile,
    method: Annotated[
        Method | None, typer.Option(help="Default: both where the analytic form applies.", show_default=False)
    ] = None,
    trials: Trials = None,
    seed: Seed = None,
    jobs: Jobs = 0,
    backend: BackendOption = Backend.LOKY,
    scheduler: Scheduler = None,
    out: Out = None,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
    allow_outside: AllowOutside = False,
) -> None:
    """Cost of each maximum leg length d_max, for each velocity error; the best d_max with its uncertainty."""

    def study(loaded: "Mission", progress: Any) -> "Result":
        from missionplan.studies.sweep_dmax import sweep_dmax

        return sweep_dmax(
            loaded,
            method=method.value if method else None,
            trials=trials,
            seed=seed,
            jobs=_jobs(jobs),
            backend=backend.value,
            scheduler=scheduler,
            progress=progress,
        )

    run_study(mission, "sweep-dmax", study, Output(out, force, as_json, quiet), allow_outside=allow_outside)


@app.command()
def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION...", help="Mission files.", show_default=False)],
    allow_outside: AllowOutside = False,
    quiet: Quiet = False,
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


def run_study(
    path: Path, command: str, study: Callable[["Mission", Any], "Result"], output: Output, *, allow_outside: bool
) -> "Result":
    """Load a mission, run a study of it, save the report and say what came out."""
    from missionplan.mission import load
    from missionplan.store.folder import check_new_folder

    folder = output.out or report_folder(path, command)
    check_new_folder(folder, force=output.force)
    loaded = load(path, allow_outside=allow_outside)
    with progress_bar(command, shown=not output.quiet) as progress:
        result = study(loaded, progress)
    result.save(folder, force=output.force)
    tell(result, folder, output)
    return result


def report_folder(path: Path, command: str) -> Path:
    """Name the report folder of a command that starts now."""
    return Path("reports") / path.stem / f"{command}-{datetime.now(UTC):%Y%m%dT%H%M%SZ}"


def tell(result: "Result", folder: Path, output: Output) -> None:
    """Print the summary: JSON for scripts, else a sentence and a compact table."""
    if output.as_json:
        from missionplan.results.base import to_json

        sys.stdout.write(to_json(result.summary()))
        return
    if output.quiet:
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from missionplan.report.render import terminal

    shown = terminal(result)
    console = Console(highlight=False)
    console.print(f"[bold]{escape(shown.sentence)}[/bold]")
    table = Table(box=None, pad_edge=False, header_style="dim")
    for index, column in enumerate(shown.columns):
        table.add_column(escape(column), justify="left" if index == 0 else "right", no_wrap=True)
    for row in shown.rows:
        table.add_row(*(escape(cell) for cell in row))
    console.print(table)
    for notice in result.provenance.notices:
        typer.echo(f"Note: {notice}", err=True)
    typer.echo(f"Report: {folder / 'report.html'}", err=True)


@contextmanager
def progress_bar(label: str, *, shown: bool) -> Iterator[Callable[[int, int], None] | None]:
    """Show a bar with the time left on standard error; yields what a study calls with (done, total)."""
    if not shown or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(label, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def _jobs(jobs: int) -> int:
    return jobs or os.cpu_count() or 1


def main() -> None:
    """Run the command line; every expected error becomes words and an exit status."""
    try:
        status = app(standalone_mode=False)
    except MissionplanError as error:
        typer.echo(f"{'Error' if error.exit_status == 1 else 'Cannot start'}:\n{error}", err=True)
        sys.exit(error.exit_status)
    except KeyboardInterrupt:
        typer.echo("Interrupted.", err=True)
        _leave_at_once(INTERRUPTED)
    except Exception as error:
        sys.exit(_usage_error(error))
    sys.exit(status if isinstance(status, int) else 0)


def _usage_error(error: Exception) -> int:
    """Show a usage error as typer words it; anything else is a fault of the program and keeps its traceback.

    Told by what it offers: typer brings click's errors with it, or takes them from click, by its version.
    """
    if type(error).__name__ == "Abort":
        typer.echo("Interrupted.", err=True)
        _leave_at_once(INTERRUPTED)
    if hasattr(error, "show") and hasattr(error, "exit_code"):
        error.show()
        return int(error.exit_code)
    raise error


def _leave_at_once(status: int) -> None:
    """End without waiting for worker pools to wind down."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
