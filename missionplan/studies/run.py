"""A run of a study of a mission: its arguments, its repetitions under doubts, and where its result comes from."""

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import TypedDict, Unpack

from missionplan.errors import InputError, Problem, shown
from missionplan.identity import Identity, digest_of_files, running_program
from missionplan.mission import Mission, as_mission
from missionplan.montecarlo.blocks import IN_THIS_PROCESS, Backend, Progress, Workers
from missionplan.montecarlo.streams import BLOCK
from missionplan.phases.currents import Current
from missionplan.phases.ensemble import Ensemble
from missionplan.results import Provenance
from missionplan.scenario.site_current import members_of
from missionplan.store.checkpoints import Checkpoints
from missionplan.store.folder import as_path
from missionplan.studies.coverage import checked_ranges, probability_holds

MAX_JOBS = 10_000


class RunArguments(TypedDict, total=False):
    """How a study that runs trials is run; its result does not depend on where, to the last bit."""

    trials: int | None
    seed: int | None
    """Default: the mission's."""
    jobs: int
    backend: Backend
    scheduler: str | None
    """Where blocks of trials run: see `montecarlo.blocks.Workers`."""
    progress: Progress | None
    """Called with the trials done and their total."""


class ResumableArguments(RunArguments, total=False):
    """The same, of a study that can go on where it was cut short."""

    checkpoint: str | Path | None
    """Folder in which finished blocks are kept."""
    resume: bool
    """Whether to go on with the blocks in that folder."""


def check_arguments(
    mission: object,
    *,
    trials: object = None,
    seed: object = None,
    jobs: object = 1,
    one_of: Mapping[str, tuple[object, Sequence[object]]] | None = None,
    text: Mapping[str, object] | None = None,
) -> Mission:
    """Check the arguments that studies share, and return the mission, loaded where its path is given.

    `mission`: expected to be a `Mission` or the path of its file. `trials`, `seed`, `jobs`: expected to be whole
    numbers; None, for the first two, is the mission's. `one_of`: by argument: what is given, and what may be. `text`:
    arguments that are text or None. Raises InputError with every argument that is wrong, else every problem of the
    mission's file.
    """
    count, listed = "a whole number", [(name, value, choices) for name, (value, choices) in (one_of or {}).items()]
    kinds = (
        ("mission", mission, isinstance(mission, Mission | str | PurePath), "a Mission, or the path of a mission file"),
        ("trials", trials, trials is None or _is_whole(trials, 1), f"{count}, at least 1"),
        ("seed", seed, seed is None or _is_whole(seed, 0), f"{count}, at least 0"),
        (
            "jobs",
            jobs,
            jobs == -1 or _is_whole(jobs, 1, MAX_JOBS),
            f"{count} from 1 to {MAX_JOBS}, or -1 for every core",
        ),
        *((name, value, value is None or isinstance(value, str), "text") for name, value in (text or {}).items()),
        *((name, value, value in choices, f"one of {', '.join(map(str, choices))}") for name, value, choices in listed),
    )
    problems = [
        Problem(f"given {shown(value)}, expected {expected}", key=name)
        for name, value, is_right, expected in kinds
        if not is_right
    ]
    if problems:
        raise InputError(problems)
    running_program()  # as it is before anything is computed
    return as_mission(mission)


def identified(mission: Mission) -> dict[str, object]:
    """Return a mission as an input of an identity: trials and seed stand in it by themselves, as they were chosen."""
    return {"mission": {key: value for key, value in mission.identified().items() if key != "monte_carlo"}}


def identified_datasets(folders: Iterable[Path]) -> dict[str, object]:
    """Return data sets as an input of an identity: the SHA-256 of each of their files."""
    from missionplan.datasets import dataset_files  # pandas: half a second

    datasets = []
    for folder in folders:
        files = {str(path.relative_to(folder)): digest_of_files([path]) for path in dataset_files(folder)}
        datasets.append({"name": folder.resolve().name, "files": files})
    return {"datasets": datasets}


@dataclass(frozen=True)
class Run:
    """A run of a study: the mission, what was asked for, checked and filled in, and when it began."""

    command: str
    """Name of the study on the command line."""
    mission: Mission
    trials: int
    seed: int
    """As asked for, else the mission's."""
    workers: Workers = IN_THIS_PROCESS
    """Where blocks of trials run, and who is told of those done."""
    checkpoint: Path | None = None
    """Folder in which finished blocks are kept."""
    resume: bool = False
    """Whether to go on with those that it holds."""
    started: float = field(default_factory=time.perf_counter)
    """`time.perf_counter` at its beginning [s]."""

    @classmethod
    def begun(
        cls,
        command: str,
        mission: object,
        *,
        one_of: Mapping[str, tuple[object, Sequence[object]]] | None = None,
        text: Mapping[str, object] | None = None,
        **asked: Unpack[ResumableArguments],
    ) -> "Run":
        """Begin a run: check all arguments, and load the mission where its path is given.

        `mission`, `one_of`, `text`: as `check_arguments` takes them. Raises InputError with every argument that is
        wrong, else every problem of the mission's file, and TypeError when one is none of a run.
        """
        started = time.perf_counter()
        if unknown := sorted(asked.keys() - ResumableArguments.__annotations__.keys()):
            raise TypeError(f"{command} got an unexpected keyword argument {unknown[0]!r}")
        trials, seed, jobs = asked.get("trials"), asked.get("seed"), asked.get("jobs", 1)
        checked = check_arguments(mission, trials=trials, seed=seed, jobs=jobs, one_of=one_of, text=text)
        checkpoint = asked.get("checkpoint")
        return cls(
            command,
            checked,
            checked.monte_carlo.trials if trials is None else trials,
            checked.monte_carlo.seed if seed is None else seed,
            Workers(jobs, asked.get("backend", "loky"), asked.get("scheduler"), asked.get("progress")),
            None if checkpoint is None else as_path(checkpoint, "checkpoint"),
            asked.get("resume", False),
            started,
        )

    def store(self, identity: Identity) -> Checkpoints | None:
        """Open the folder of finished blocks, which depend on `identity`; None where none are kept."""
        return None if self.checkpoint is None else Checkpoints(self.checkpoint, identity, resume=self.resume)

    def under_explanations(self) -> Iterator[tuple[tuple[str, ...], float, "Run"]]:
        """Yield effects and probability of each explanation of each doubt, the others as they are, and the run then."""
        for doubt in self.mission.doubts:
            for number in doubt.told_apart:
                run = replace(self, mission=self.mission.knowing(doubt.place, number))
                yield doubt.causes[number], doubt.probabilities[number], run

    def in_members(self, recorded: Current | None) -> Iterator[tuple[str, float, Current, "Run"]]:
        """Yield name and probability of each member of a current's ensemble, the current then, and the run in it.

        All members together take about as many trials as the run.
        """
        if isinstance(recorded, Ensemble):
            alone = replace(self, trials=min(self.trials, max(self.trials // len(recorded.names), BLOCK)))
            for number, (name, probability) in enumerate(members_of(recorded)):
                yield name, probability, replace(recorded, given=number), alone

    def provenance(
        self,
        options: Mapping[str, object],
        notices: Iterable[str],
        *,
        trials: int | None = None,
        datasets: Sequence[Path] = (),
    ) -> Provenance:
        """Tell where the result comes from, as the run ends.

        `options`: the study's. `notices`: on the input. `trials`: that were run, where these are not those asked for.
        `datasets`: folders that it read besides.
        """
        return Provenance(
            command=self.command,
            mission=self.mission.name,
            file=self.mission.file,
            seed=self.seed,
            trials=self.trials if trials is None else trials,
            options=options,
            elapsed_s=time.perf_counter() - self.started,
            data=self.mission.raw,
            notices=tuple(notices),
            inputs={**identified(self.mission), **(identified_datasets(datasets) if datasets else {})},
            holds=probability_holds(self.mission),
            checked=checked_ranges(self.mission),
        )


def _is_whole(value: object, least: int, most: float = float("inf")) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most
