"""Options that commands share."""

import os
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class Backend(StrEnum):
    """How blocks of trials are spread."""

    LOKY = "loky"
    THREADING = "threading"
    DASK = "dask"


MissionFile = Annotated[Path, typer.Argument(metavar="MISSION", help="Mission file (YAML).", show_default=False)]
DatasetFolder = Annotated[
    Path, typer.Argument(metavar="DATASET", help="Data set: a folder with dataset.yaml.", show_default=False)
]
Trials = Annotated[
    int | None, typer.Option(min=1, help="Number of trials; default: the mission's.", show_default=False)
]
Seed = Annotated[int | None, typer.Option(min=0, help="Seed; default: the mission's.", show_default=False)]
Jobs = Annotated[int, typer.Option("--jobs", "-j", help="Processes; 0 is one for each core.", min=0)]
BackendOption = Annotated[Backend, typer.Option("--backend", help="How blocks of trials are spread.")]
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
    """Where a command's answer goes, and what is said beside it."""

    out: Path | None
    force: bool
    as_json: bool
    quiet: bool


def worker_count(jobs: int) -> int:
    """Number of workers that `--jobs` asks for."""
    return jobs or os.cpu_count() or 1
