"""Around every study: load the mission, show progress, save the report, print the answer.

Runs that were cut short: their finished blocks of trials are kept in the report folder and used again.
"""

import os
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, TypeVar

from missionplan.cli.options import OutputOptions, answering, note, remark
from missionplan.errors import InputError, MissionplanError, Problem, RunError, attempted
from missionplan.identity import blamed_plugin, running_program

if TYPE_CHECKING:
    from rich.progress import Task
    from rich.text import Text

    from missionplan.mission import Mission
    from missionplan.results import Result


_Result = TypeVar("_Result", bound="Result")
Progress = Callable[[int, int], None] | None
"""Called by a study with (done, total); None where no progress is shown."""
Study = Callable[..., _Result]
"""A study of a loaded mission, to which `progress` is given besides, and where it is kept its blocks."""
_COLOURS = {"good": "green", "bad": "red", "undecided": "yellow"}
"""Colour of the answer on a terminal, by verdict."""


def run_study(
    path: Path,
    command: str,
    study: Study[_Result],
    output: OutputOptions,
    *,
    allow_outside: bool,
    datasets: Sequence[Path] = (),
) -> _Result:
    """Load a mission, run a study of it, save the report, print and return the result; data sets are read besides."""
    with report_folder(output, path.stem, command) as folder:
        mission = loaded(path, datasets, folder, allow_outside=allow_outside)
        result = _with_bar(command, partial(study, mission), shown=not output.quiet)
        deliver(result, folder, output)
    return result


def loaded(path: Path, datasets: Sequence[Path], folder: Path, *, allow_outside: bool) -> "Mission":
    """Load a mission, and read data sets for what is wrong with them; the report's folder may hold none of their files.

    Raises InputError: all that is wrong with any of them.
    """
    from missionplan.mission import load
    from missionplan.store.folder import check_holds_no_input

    problems: list[Problem] = []
    mission = attempted(partial(load, path, allow_outside=allow_outside), problems)
    files = [] if mission is None else [*mission.sources]
    for dataset in datasets:
        from missionplan.datasets import dataset_files
        from missionplan.studies.data_sets import check_dataset

        paths = attempted(partial(dataset_files, dataset), problems)
        if paths is not None:
            files += paths
            attempted(partial(check_dataset, dataset, mission, allow_outside=allow_outside), problems)
    attempted(partial(check_holds_no_input, folder, files), problems)
    if mission is None or problems:
        raise InputError(problems)
    return mission


@contextmanager
def report_folder(output: OutputOptions, stem: str, command: str, inputs: Sequence[Path] = ()) -> Iterator[Path]:
    """Hold the report folder of a command that starts now; refuse one in use, not empty or holding its input."""
    from missionplan.store.folder import check_holds_no_input, claimed, new_folder_name

    folder = output.out or new_folder_name(Path("reports") / stem, command)
    with claimed(folder, force=output.force):
        check_holds_no_input(folder, inputs)
        yield folder


def deliver(result: "Result", folder: Path, output: OutputOptions) -> None:
    """Save a result, then print it: as JSON for scripts, else as a sentence and a compact table."""
    if pool := sys.modules.get("missionplan.montecarlo.pool"):
        pool.shut_down_pool()  # copies of this process draw once those that took part in the study have ended
    _import_page("missionplan.report.page")
    from missionplan.report.page import drawing_in_parallel
    from missionplan.report.quantities import using_units

    jobs = result.provenance.options.get("jobs")
    with using_units(output.units):
        with drawing_in_parallel(jobs if isinstance(jobs, int) else None):
            result.save(folder, force=output.force)
        with answering(f"; the report is saved in {folder}"):
            if output.as_json:
                from missionplan.results import to_json

                text = to_json(result.summary())
                try:
                    text.encode(sys.stdout.encoding or "utf-8")
                except UnicodeEncodeError:
                    text = to_json(result.summary(), ascii_only=True)
                sys.stdout.write(text)
            elif not output.quiet:
                _print_result(result)
    if output.as_json:
        return
    if not output.quiet:
        from missionplan.report.render import notices_of

        for notice in notices_of(result):
            remark(f"Note: {notice}")
    note(f"Report: {folder / 'report.html'}")


def _import_page(module: str) -> None:
    """Import what presents results."""
    from matplotlib import artist

    artist.kwdoc = lambda artist: (
        ""
    )  # lists of properties for docstrings, a fifth of its import, which no command shows
    import_module(module)


def _print_result(result: "Result") -> None:
    from rich.console import Console
    from rich.text import Text

    from missionplan.report.render import laid_out, terminal_view
    from missionplan.report.wording import wrapped

    class Output(Console):
        def on_broken_pipe(self) -> NoReturn:
            raise BrokenPipeError  # the base class would end the process

    shown = terminal_view(result)
    console = Output(highlight=False, emoji=False)
    style = f"bold {_COLOURS.get(shown.verdict, '')}".strip()
    console.print(Text(wrapped(shown.sentence, console.width), style), soft_wrap=True)
    for line in laid_out(shown.columns, shown.rows, console.width) if shown.rows else ():
        console.print(line, markup=False, soft_wrap=True)


@contextmanager
def progress_bar(label: str, *, shown: bool) -> Iterator[Progress]:
    """Show a bar with rate and time left on standard error; yields what a study calls with (done, total).

    What plug-ins print meanwhile goes to standard error too, and their errors tell of them.

    Raises RunError when the code of a plug-in fails.
    """
    try:
        with redirect_stdout(sys.stderr), _bar(label, shown=shown) as progress:
            yield progress
    except MissionplanError:
        raise
    except Exception as error:
        plugin = blamed_plugin(error)
        if plugin is None:
            raise
        raise RunError(f"the plug-in {plugin} failed: {type(error).__name__}: {error}") from error


@contextmanager
def _bar(label: str, *, shown: bool) -> Iterator[Progress]:
    if not shown or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, ProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as ProgressBar
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task: "Task") -> "Text":
            return Text(f"{task.speed:,.0f}/s".replace(",", " ") if task.speed else "")

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Rate(), TimeRemainingColumn())
    with ProgressBar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _with_bar(command: str, study: Study[_Result], *, shown: bool) -> _Result:
    with progress_bar(command, shown=shown) as progress:
        return study(progress=progress)


def beside_import(module: str, compute: Callable[[], _Result]) -> _Result:
    """Import a module while a copy of this process computes; where there can be none, this one computes.

    Raises what computing raises, and RunError when the copy dies.
    """
    from missionplan.montecarlo.pool import WORKER_DIED, Copy, copies_at_once, end_with, shut_down_pool

    if not module or not copies_at_once():
        return compute()
    running_program()  # as it is before anything is computed
    parent = os.getpid()

    def outcome() -> _Result | BaseException:
        end_with(parent)
        try:
            return compute()
        except (Exception, KeyboardInterrupt) as error:
            error.add_note(traceback.format_exc())
            return error
        finally:
            shut_down_pool()

    try:
        copy = Copy(outcome)
    except OSError:  # of processes or files there may be no more
        return compute()
    try:
        _import_page(module)
        result = copy.result
    except EOFError:
        raise RunError(WORKER_DIED) from None
    except KeyboardInterrupt:
        if sys.stderr.isatty():
            sys.stderr.write("\x1b[?25h")  # the cursor, which the copy's bar hid
        raise
    finally:
        copy.end()
    if isinstance(result, BaseException):
        raise result
    return result


BLOCKS = "blocks"
"""Folder of finished blocks inside a report folder."""


def last_unfinished(stem: str, command: str) -> Path:
    """Find the newest report folder of a mission whose run of a command was cut short; one that still runs is none."""
    from missionplan.store.folder import is_claimed

    parent = Path("reports") / stem
    for folder in sorted(parent.glob(f"{command}-*"), reverse=True):
        if (folder / BLOCKS).is_dir() and not (folder / "report.html").exists() and not is_claimed(folder):
            return folder
    raise InputError([Problem("there is no unfinished run to resume", str(parent), hint="--out names its folder")])


def discard_blocks(folder: Path) -> None:
    """Remove the finished blocks of a run from a report folder, and the folder where nothing else is in it."""
    blocks = folder / BLOCKS
    if blocks.exists() and not blocks.is_dir():
        raise InputError([Problem("is a file; a folder for finished blocks was expected", str(blocks))])
    for path in (*blocks.glob("block-*.npz"), blocks / "run.json"):
        path.unlink(missing_ok=True)
    for emptied in (blocks, folder):
        if emptied.is_dir() and not any(emptied.iterdir()):
            emptied.rmdir()


@contextmanager
def resume_hint(folder: Path, *, resumed: bool) -> Iterator[None]:
    """Print how to resume a run that is interrupted or fails, where it has finished blocks; drop those of one refused.

    `folder`: the report's. `resumed`: whether its blocks may be those of another run.
    """
    try:
        yield
    except InputError:
        if not resumed:
            discard_blocks(folder)
        raise
    except (KeyboardInterrupt, RunError):
        if any((folder / BLOCKS).glob("block-*.npz")):
            note(f"Finished blocks are kept; go on with: --resume --out {folder}")
        raise


def run_resumable(
    path: Path,
    command: str,
    study: Study[_Result],
    output: OutputOptions,
    *,
    allow_outside: bool,
    resume: bool,
    keep: bool = False,
    page: str = "",
) -> _Result:
    """Load a mission, run a study that keeps its finished blocks in the report folder, and save it.

    The blocks stay there if they are to be kept, so that the run can be extended, else until it is done. `page`: module
    that is imported while a copy of this process runs the study; none: this process runs it.
    """
    out = last_unfinished(path.stem, command) if resume and output.out is None else output.out
    chosen = replace(output, out=out, force=output.force or resume)
    with report_folder(chosen, path.stem, command) as folder:
        mission = loaded(path, (), folder, allow_outside=allow_outside)
        if output.force and not resume:
            discard_blocks(folder)
        with resume_hint(folder, resumed=resume):
            whole = partial(study, mission, checkpoint=folder / BLOCKS, resume=resume)
            result = beside_import(page, partial(_with_bar, command, whole, shown=not output.quiet))
        if not keep:
            discard_blocks(folder)  # of thousands of cells or choices
        deliver(result, folder, replace(output, force=True))
    return result
