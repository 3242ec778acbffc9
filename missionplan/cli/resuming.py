"""Runs that were cut short: their finished blocks of trials are kept in the report folder and used again."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from missionplan.cli.options import OutputOptions
from missionplan.cli.running import Progress, deliver, progress_bar, report_folder
from missionplan.cli.streams import note
from missionplan.errors import InputError, Problem, RunError

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result

_Result = TypeVar("_Result", bound="Result")
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

    Parameters
    ----------
    folder : Path
        The report's.
    resumed : bool
        Whether its blocks may be those of another run.
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
    study: Callable[["Mission", Path, Progress], _Result],
    output: OutputOptions,
    *,
    allow_outside: bool,
    resume: bool,
    keep: bool = False,
) -> _Result:
    """Load a mission, run a study that keeps its finished blocks in the report folder, and save it.

    The blocks stay there if they are to be kept, so that the run can be extended, else until it is done.
    """
    from missionplan.mission import load
    from missionplan.store.folder import check_holds_no_input

    found = last_unfinished(path.stem, command) if resume and output.out is None else output.out
    chosen = replace(output, out=found, force=output.force or resume)
    with report_folder(chosen, path.stem, command) as folder:
        mission = load(path, allow_outside=allow_outside)
        check_holds_no_input(folder, mission.sources)
        if output.force and not resume:
            discard_blocks(folder)
        with resume_hint(folder, resumed=resume), progress_bar(command, shown=not output.quiet) as progress:
            result = study(mission, folder / BLOCKS, progress)
        if not keep:
            discard_blocks(folder)  # of thousands of cells or choices
        deliver(result, folder, replace(output, force=True))
    return result
