"""Runs that were cut short: their finished blocks of trials are kept in the report folder and used again."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from missionplan.cli.streams import note
from missionplan.errors import InputError, Problem, RunError

BLOCKS = "blocks"
"""Folder of finished blocks inside a report folder."""


def last_unfinished(stem: str, command: str = "simulate") -> Path:
    """Find the newest report folder of a mission whose run of a command was cut short."""
    parent = Path("reports") / stem
    for folder in sorted(parent.glob(f"{command}-*"), reverse=True):
        if (folder / BLOCKS).is_dir() and not (folder / "report.html").exists():
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
