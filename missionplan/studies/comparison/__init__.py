"""`compare`: missions on common random numbers, or reports; which is better, by how much, or what changed.

Read then `two_reports` with `summary_numbers` (what is compared between reports, and the tests).
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Unpack

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.identity import digest_of
from missionplan.mission import Mission, MissionOrPath, load
from missionplan.mission.documents import load_document
from missionplan.montecarlo.alternatives import LEVEL, paired_difference
from missionplan.montecarlo.streams import sized_blocks
from missionplan.results import Provenance
from missionplan.results.decision import Aim
from missionplan.store.folder import as_path, is_folder
from missionplan.studies import judgement
from missionplan.studies.comparison.differing_values import differing_values
from missionplan.studies.comparison.reported_choices import CHOOSING, aim_of, check_kinds, reported_alternative
from missionplan.studies.comparison.result import DECIDES, Alternative, Alternatives, Comparison, Contrast, Estimate
from missionplan.studies.comparison.two_reports import (
    SummaryNumber,
    compare_reports,
    read_summary,
    standard_error_and_p_value,
)
from missionplan.studies.coverage import coverage_of
from missionplan.studies.exploration.cells import CellTrials, MissionTask, SharedCurrent, cell_trials
from missionplan.studies.exploration.result import DURATION, ENERGY, cell_of
from missionplan.studies.run import Run, RunArguments, identified

_COLUMNS = {"success": "total.success", "energy_wh": ENERGY, "duration_s": DURATION}


def compare_missions(
    *alternatives: MissionOrPath, allow_outside: bool = False, **run_as: Unpack[RunArguments]
) -> Alternatives:
    """Compare missions, which are run on common random numbers, and reports of `simulate`; or reports of choices.

    `alternatives`: two or more missions, mission files or report folders; or report folders of `explore` alone, all of
    the same keys, or of `optimise` alone. The rest, and what is raised, is as of `compare`.
    """
    began = time.perf_counter()
    sources = _sources(alternatives, allow_outside=allow_outside)
    compared = check_kinds([(source.path, source.summary) for source in sources])
    entries, runs = _entries(sources, run_as)
    aim = aim_of([source.summary for source in sources])
    best = min(range(len(entries)), key=lambda index: _rank(entries[index], aim))
    columns = [run.columns if run is not None else {} for run in runs]
    mission = sources[best].mission
    return Alternatives(
        provenance=Provenance(
            command="compare",
            mission=" and ".join(source.name for source in sources),
            file=" ".join(str(source.path) for source in sources),
            seed=entries[best].seed,
            trials=entries[best].trials,
            options={"jobs": run_as.get("jobs", 1)},
            elapsed_s=time.perf_counter() - began,
            data={source.name: source.data for source in sources},
            inputs={source.name: source.identified for source in sources},
            holds=coverage_of({source.name: source.mission or source.summary for source in sources}),
        ),
        alternatives=tuple(
            entry if index == best else replace(entry, contrasts=_contrasts(entries, columns, index, best))
            for index, entry in enumerate(entries)
        ),
        best=best,
        compared=compared,
        aim=aim,
        differing=differing_values([source.data for source in sources]),
        assumed=() if mission is None else judgement.ledger(mission, entries[best].seed),
    )


def _entries(sources: Sequence["_Source"], run_as: RunArguments) -> tuple[list[Alternative], list[CellTrials | None]]:
    """Run the missions and read the reports; returns the trials of the missions besides."""
    missions = [source.mission for source in sources if source.mission is not None]
    common = Run.begun("compare", missions[0], **run_as) if missions else None
    runs = iter(_run(missions, common) if common is not None else ())
    source_runs = [next(runs) if source.mission is not None else None for source in sources]
    entries = [
        _of_mission(source.name, source.path, source.mission, run, common.seed)
        if common is not None and source.mission is not None and run is not None
        else reported_alternative(source.name, source.path, source.summary)
        for source, run in zip(sources, source_runs, strict=True)
    ]
    return entries, source_runs


def _run(missions: Sequence[Mission], run: Run) -> list[CellTrials]:
    """Run missions on common random numbers; raises InputError where one cannot be run."""
    task = MissionTask(missions, [SharedCurrent.of(mission) for mission in missions], run.seed, (DURATION, ENERGY))
    items = [(number, *block) for number in range(len(missions)) for block in sized_blocks(run.trials)]
    ran = cell_trials(task, items, range(len(missions)), run.workers)
    if problems := [Problem(run.reason, case.file) for case, run in zip(missions, ran, strict=True) if run.reason]:
        raise InputError(problems)
    return ran


@dataclass(frozen=True)
class _Source:
    """Where an alternative comes from: a mission, or the summary of a report."""

    name: str
    path: Path
    mission: Mission | None
    summary: Mapping[str, object]

    @property
    def identified(self) -> object:
        """What an identity takes it for."""
        return identified(self.mission) if self.mission is not None else digest_of(self.summary)

    @property
    def data(self) -> object:
        """The mission's document."""
        return self.mission.raw if self.mission is not None else load_document(self.path / "mission.yaml").data


def _sources(alternatives: Sequence[MissionOrPath], *, allow_outside: bool) -> list[_Source]:
    """Read missions and summaries; raises InputError when there are fewer than two, or one is neither."""
    paths: list[Path] = []
    for number, case in enumerate(alternatives, start=1):  # a mission that is given as such has its name for a path
        name = as_path((case.name or f"mission {number}") if isinstance(case, Mission) else case, "alternatives")
        paths.append(Path(f"{name} {number}") if isinstance(case, Mission) and name in paths else name)
    if len(paths) < 2:
        raise InputError([Problem(f"given {len(paths)}, expected two or more missions or reports", key="alternatives")])
    sources = []
    for named, path, case in zip(_names(paths), paths, alternatives, strict=True):
        if not isinstance(case, Mission) and is_folder(path):
            sources.append(_Source(named, path, None, read_summary(path)))
        else:
            mission = case if isinstance(case, Mission) else load(path, allow_outside=allow_outside)
            sources.append(_Source(named, path, mission, {}))
    return sources


def _names(paths: Sequence[Path]) -> list[str]:
    """Return the last part of each path, or the whole where parts are alike."""
    short = [path.resolve().stem if path.suffix in (".yaml", ".yml") else path.resolve().name for path in paths]
    if len(set(short)) == len(short):
        return short
    whole = [str(path) for path in paths]
    return whole if len(set(whole)) == len(whole) else [f"{name} ({i + 1})" for i, name in enumerate(whole)]


def _of_mission(name: str, path: Path, mission: Mission, run: CellTrials, seed: int) -> Alternative:
    cell = cell_of((), mission, run.columns, "")
    if cell.reason:
        raise InputError([Problem(cell.reason, str(path))])
    quantities: dict[str, Estimate] = {
        key.partition(".")[2]: (statistic.mean, statistic.standard_error)
        for key, statistic in cell.quantities.items()
        if statistic.count
    }
    return Alternative(name, str(path), cell.success, quantities, cell.requirements, cell.trials, seed, {})


def _rank(case: Alternative, aim: Aim) -> tuple[bool, int, float, float]:
    """Order alternatives, the best first; last those of which nothing is known."""
    energy, first = (case.quantities.get(key, (np.inf, 0.0))[0] for key in ("energy_wh", DECIDES[aim]))
    is_finite = np.isfinite(case.success.value)
    first = -case.success.value if aim == "success" and is_finite else first
    return not is_finite, len(case.missed), first, energy if np.isfinite(energy) else np.inf


def _contrasts(
    entries: Sequence[Alternative], columns: Sequence[Mapping[str, np.ndarray]], index: int, best: int
) -> dict[str, Contrast]:
    """Compare an alternative with the best: in pairs where both were run here, else as independent runs."""
    level = LEVEL / (len(entries) - 1)
    contrasts = {}
    for key, column in _COLUMNS.items():
        one, two = _number(entries[best], key), _number(entries[index], key)
        if one is None or two is None:
            continue
        if column in columns[best] and column in columns[index]:
            values, other = columns[index][column], columns[best][column]
            mean, error, up = paired_difference(values, other, most=True)
            down = paired_difference(values, other, most=False)[2]
            contrasts[key] = Contrast(mean, error, 2.0 * min(up, down) < level, paired=True)
        else:
            spread, p_value = standard_error_and_p_value(one, two, (entries[best].trials, entries[index].trials))
            differs = p_value is not None and p_value < level
            contrasts[key] = Contrast(two.value - one.value, spread or 0.0, differs, paired=False)
    return contrasts


def _number(case: Alternative, key: str) -> SummaryNumber | None:
    if key == "success":
        is_finite = np.isfinite(case.success.value)
        return SummaryNumber("probability", case.success.value, float("nan")) if is_finite else None
    return SummaryNumber("mean", *case.quantities[key]) if key in case.quantities else None


def compare(
    *compared: MissionOrPath, allow_outside: bool = False, **run_as: Unpack[RunArguments]
) -> Comparison | Alternatives:
    """Compare two reports of one command, or two and more missions or reports.

    Parameters
    ----------
    *compared : Mission, str or Path
        Two report folders: what changed, and is it more than noise? Missions, their files, more than two, or reports of
        what was chosen (`explore`, `optimise`): which is better? Missions are run on the same random numbers.
    allow_outside : bool
        Whether missions may name files outside their folders.
    **run_as
        See `studies.run.RunArguments`; trials and seed are by default the first mission's.

    Raises
    ------
    InputError
        When something is neither a mission nor a report, a mission cannot be run, or the reports cannot be compared.
    """
    if len(compared) == 2 and not any(_is_mission(case) for case in compared):
        first, second = (as_path(case, "compared") for case in compared if not isinstance(case, Mission))
        if {read_summary(folder)["command"] for folder in (first, second)}.isdisjoint(CHOOSING):
            return compare_reports(first, second)
    return compare_missions(*compared, allow_outside=allow_outside, **run_as)


def _is_mission(case: MissionOrPath) -> bool:
    if isinstance(case, Mission):
        return True
    path = Path(case)
    return path.suffix in (".yaml", ".yml") or (path.exists() and not is_folder(path))
