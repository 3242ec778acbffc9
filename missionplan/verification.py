"""`verify`: compute a report again, in part or whole, and say whether the same bits come out here."""

import json
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import missionplan
from missionplan.errors import InputError, Problem, counted
from missionplan.identity import differences, digest_of, leaves, program_part, running_program
from missionplan.mission import Mission, load
from missionplan.montecarlo.blocks import Progress, Workers
from missionplan.montecarlo.streams import sized_blocks
from missionplan.results import OF_THE_RUN, to_json
from missionplan.results.entries import mapping, whole
from missionplan.store.checkpoints import read_block
from missionplan.store.folder import as_path
from missionplan.studies.comparison.two_reports import read_summary
from missionplan.studies.run import MAX_JOBS, identified

if TYPE_CHECKING:
    from missionplan.results import Result

_SHOWN = 8
Arrays = Mapping[str, NDArray[np.generic]]
Leaves = dict[tuple[str, ...], object]


@dataclass(frozen=True)
class Verification:
    """What came out when a report was computed again."""

    report: str
    command: str
    """The folder, and what had made it."""
    computed: str
    """What was computed again, in words."""
    values: int
    """Values that were held against the report's."""
    different: tuple[str, ...]
    """Each value that is not the same to the bit, as it was and as it is here."""
    unlike: tuple[str, ...]
    """In what code, plug-ins, libraries and inputs differ from those of the report."""

    @property
    def same(self) -> bool:
        """Whether all that was computed again is the same to the bit."""
        return not self.different

    def summary(self) -> dict[str, object]:
        """Return it as plain data."""
        return {"command": "verify", "same": self.same, **{name: _listed(value) for name, value in vars(self).items()}}

    def __str__(self) -> str:
        if self.same:
            lines = [f"The same bits come out here: {self.computed}, {counted(self.values, 'value')}."]
        else:
            count = f"{len(self.different)} of {counted(self.values, 'value')} differ"
            lines = [f"Other bits come out here: {self.computed}; {count}.", *self.different[:_SHOWN]]
        if self.unlike:
            lines += ["It was made with other code or inputs:", *self.unlike]
        elif not self.same:
            lines.append("Code, libraries, inputs, options and seed are the same: the machines compute differently.")
        return "\n".join(lines)


def verify(
    report: str | Path,
    *,
    all_blocks: bool = False,
    jobs: int = 1,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Verification:
    """Compute a report again and hold the result against it, bit by bit.

    A report of `simulate` with its blocks has some of them computed again, any other the whole study.

    Parameters
    ----------
    report : str or Path
        A report folder.
    all_blocks : bool
        Whether to compute all blocks of `simulate` again, and every number that follows from them.
    jobs : int
        Processes.
    allow_outside : bool
        Whether the report's mission may name files outside the folder, as one with a recorded current does.
    progress : callable, optional
        Called with the blocks done and their number, or with what the study counts.

    Raises
    ------
    InputError
        When the folder is no report, or one of a command that reads reports or logs; when an input is gone.
    RunError
        As the study does.
    """
    if isinstance(jobs, bool) or not isinstance(jobs, int) or not (1 <= jobs <= MAX_JOBS or jobs == -1):
        raise InputError([Problem(f"given {jobs!r}, expected a whole number, at least 1, or -1", key="jobs")])
    folder = as_path(report, "report")
    summary = read_summary(folder)
    made = _Made(folder, summary, allow_outside, jobs, progress)
    again = _STUDIES.get(made.command)
    if again is None:
        commands = ", ".join(_STUDIES)
        message = f"was made by {made.command}; reports of {commands} can be computed again"
        raise InputError([Problem(message, str(folder))])
    blocks = made.blocks() if made.command == "simulate" and not made.options.get("rare") else []
    unlike = made.unlike()
    if blocks and not all_blocks:
        chosen = sorted({blocks[0], blocks[len(blocks) // 2], blocks[-1]})
        values, different = made.computed_blocks(chosen)
        words = f"{len(chosen)} of {len(blocks)} blocks computed again"
    else:
        values, different = made.computed_whole(again, blocks)
        words = f"all {len(blocks)} blocks and the summary computed again" if blocks else "the study computed again"
    return Verification(str(folder), made.command, words, values, tuple(different), tuple(unlike))


@dataclass(frozen=True)
class _Made:
    """A report and what it takes to make it again."""

    folder: Path
    summary: Mapping[str, object]
    allow_outside: bool
    jobs: int
    progress: Progress | None

    @property
    def command(self) -> str:
        return str(self.summary["command"])

    @property
    def options(self) -> Mapping[str, Any]:
        return mapping(self.summary.get("options"))

    @property
    def drawn(self) -> dict[str, Any]:
        """Trials and seed, processes and progress, as studies with a Monte Carlo take them."""
        return {"trials": whole(self.summary.get("trials")), **self.seeded}

    @property
    def seeded(self) -> dict[str, Any]:
        return {"seed": whole(self.summary.get("seed")), "jobs": self.jobs, "progress": self.progress}

    def mission(self) -> Mission:
        return load(self.folder / "mission.yaml", allow_outside=self.allow_outside)

    def unlike(self) -> list[str]:
        """Name in what the report's identity differs from what this process would give it."""
        parts = mapping(self.summary.get("identity_parts"))
        if not parts:
            return ["the report does not state its identity"]
        lines = differences(program_part(parts), running_program().parts())
        stated = mapping(parts.get("inputs")).get("mission")
        if stated is not None and digest_of(identified(self.mission())["mission"]) != stated:
            lines.append("mission.yaml or a file that it names: not as it was when the report was made")
        if digest_of(parts) != self.summary.get("identity"):
            lines.append("identity: not that of its parts; summary.json has been changed")
        return lines

    def blocks(self) -> list[tuple[int, int]]:
        """Return the blocks of the report that are there and whole, by number and size."""
        trials = whole(self.summary.get("trials"))
        all_blocks = sized_blocks(trials)
        return [item for item in all_blocks if read_block(self.folder / "blocks", *item) is not None]

    def stored(self, item: tuple[int, int]) -> Arrays:
        return _without_digest(read_block(self.folder / "blocks", *item))

    def computed_blocks(self, chosen: list[tuple[int, int]]) -> tuple[int, list[str]]:
        """Compute some blocks of a simulation again; returns how many values there are and those that differ."""
        from missionplan.scenario.scenario import Scenario
        from missionplan.scenario.site_current import recorded_current
        from missionplan.studies.export import executions, mission_plan
        from missionplan.studies.simulation.block_sequence import BlockResult, BlockTask

        mission = self.mission()
        means = Scenario.at_means(mission, recorded_current(mission))
        if to := self.options.get("as_exported"):
            plan = mission_plan(mission, means=means, to=to)
            means = replace(means, executions=executions(mission, to, plan))
        task = BlockTask(means, whole(self.summary.get("seed")), bool(self.options.get("keep_trials")))
        values, different = 0, list[str]()
        results = Workers(self.jobs, progress=self.progress).run(task, chosen)
        for item, result in zip(chosen, results, strict=True):
            before = self.stored(item)
            now = result.to_arrays() if isinstance(result, BlockResult) else {}
            values += sum(array.size for array in before.values())
            different += _different_arrays(item[0], before, now)
        return values, different

    def computed_whole(self, again: Callable[..., "Result"], blocks: list[tuple[int, int]]) -> tuple[int, list[str]]:
        """Run the study again; returns how many values there are and those that differ."""
        with tempfile.TemporaryDirectory(prefix="missionplan-verify-") as kept:
            checkpoint = Path(kept) / "blocks"
            extra = {"checkpoint": checkpoint} if blocks else {}
            result = again(self, **extra)
            here = {item: _without_digest(read_block(checkpoint, *item)) for item in blocks}
        before, now = (_answer(summary) for summary in (self.summary, json.loads(to_json(result.summary()))))
        paths = dict.fromkeys((*before, *now))
        different = [
            f"{'.'.join(path)}: was {before.get(path, 'nothing')}, here {now.get(path, 'nothing')}"
            for path in paths
            if before.get(path) != now.get(path)
        ]
        values = len(before)
        for item in blocks:
            stored = self.stored(item)
            values += sum(array.size for array in stored.values())
            different += _different_arrays(item[0], stored, here[item])
        return values, different


def _simulate(made: _Made, **extra: Any) -> "Result":
    options = made.options
    if options.get("searched"):
        message = "was made with --searched, whose file a report does not keep: run simulate with it again"
        raise InputError([Problem(message, str(made.folder))])
    if options.get("rare"):
        chosen = {"event": options["rare"], "trials": options.get("trials"), "precision": options.get("precision")}
        return missionplan.find_rare_failure(made.mission(), **chosen, **made.seeded)
    chosen = {name: bool(options.get(name)) for name in ("keep_trials", "assumptions")}
    chosen |= {"sheet": bool(options.get("sheet", True)), "as_exported": options.get("as_exported")}
    return missionplan.simulate(made.mission(), **chosen, **made.drawn, **extra)


_OPTIONS: Mapping[str, Mapping[str, str]] = {
    "sweep-dmax": {"method": "method"},
    "plan-legs": {"aim": "aim"},
    "size-anchor": {"probability": "probability", "phase": "phase"},
    "optimise": {"choose": "choose", "aim": "aim"},
    "sweep-transition": {"phase": "phase", "time_step": "time_step"},
    "explore": {"vary": "vary", "aim": "aim", "only_best": "only_best", "quantity": "quantities"},
}
"""Options of their own that studies of a mission state, and the arguments that they are, by command."""


def _of_mission(made: _Made) -> "Result":
    chosen = {name: made.options[option] for option, name in _OPTIONS[made.command].items() if option in made.options}
    run = {"progress": made.progress} if made.command == "sweep-transition" else made.drawn
    result: Result = getattr(missionplan, made.command.replace("-", "_"))(made.mission(), **chosen, **run)
    return result


def _diagnose(made: _Made) -> "Result":
    options = made.options
    chosen = {"plan": bool(options.get("plan", True)), "allow_outside": made.allow_outside, **made.seeded}
    chosen |= {"holdout": options.get("holdout"), "next_trial": bool(options.get("next_trial"))}
    if "datasets" in options:
        return missionplan.diagnose_campaign(made.mission(), options["datasets"], **chosen)
    return missionplan.diagnose(made.mission(), options["dataset"], **chosen)


def _score(made: _Made) -> "Result":
    seed = whole(made.summary.get("seed"))
    return missionplan.score(made.mission(), *made.options["datasets"], seed=seed, allow_outside=made.allow_outside)


def _identify(made: _Made) -> "Result":
    return missionplan.identify(str(made.summary.get("file")), allow_outside=made.allow_outside)


def _tide(made: _Made) -> "Result":
    latitude, start = f"{made.options['latitude_deg']} deg", made.options.get("start")
    return missionplan.tide(str(made.summary.get("file")), latitude=latitude, start=start, progress=made.progress)


_STUDIES: dict[str, Callable[..., "Result"]] = {
    "simulate": _simulate,
    **dict.fromkeys(_OPTIONS, _of_mission),
    "diagnose": _diagnose,
    "score": _score,
    "identify": _identify,
    "tide": _tide,
}
"""What runs the study of a report again, by command."""


def _answer(summary: Mapping[str, object]) -> Leaves:
    return {path: value for path, value in leaves(summary) if not OF_THE_RUN.intersection(path)}


def _without_digest(arrays: Arrays | None) -> Arrays:
    return {name: values for name, values in (arrays or {}).items() if name != "digest"}


def _different_arrays(block: int, before: Arrays, now: Arrays) -> Iterator[str]:
    for name in dict.fromkeys((*before, *now)):
        was, here = before.get(name), now.get(name)
        place = f"block {block}, {name}"
        if was is None or here is None:
            yield f"{place}: {'only in the report' if here is None else 'only here'}"
        elif (was.dtype, was.shape) != (here.dtype, here.shape):
            yield f"{place}: was {was.dtype} {was.shape}, here {here.dtype} {here.shape}"
        elif was.tobytes() != here.tobytes():
            unlike = [place for place in np.ndindex(was.shape) if was[place].tobytes() != here[place].tobytes()]
            yield f"{place}: {len(unlike)} of {was.size}, the first was {was[unlike[0]]}, here {here[unlike[0]]}"


def _listed(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
