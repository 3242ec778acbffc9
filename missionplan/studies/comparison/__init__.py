"""`compare`: missions on common random numbers, or reports; which is better, by how much, or what changed.

Read then `two_reports` with `summary_numbers` (what is compared between reports, and the tests).
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.identity import digest_of
from missionplan.mission import Mission, MissionOrPath, load
from missionplan.mission.documents import load_document
from missionplan.montecarlo.alternatives import LEVEL, paired_difference
from missionplan.montecarlo.blocks import Progress, Workers
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
from missionplan.studies.run import check_arguments, identified

_COLUMNS = {"success": "total.success", "energy_wh": ENERGY, "duration_s": DURATION}


def compare_missions(
    *alternatives: MissionOrPath,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Alternatives:
    """Compare missions, which are run on common random numbers, and reports of `simulate`; or reports of choices.

    `alternatives`: two or more missions, mission files or report folders; or report folders of `explore` alone, all of
    the same keys, or of `optimise` alone. The rest, and what is raised, is as of `compare`.
    """
    began = time.perf_counter()
    sources = _sources(alternatives, allow_outside=allow_outside)
    compared = check_kinds([(each.path, each.summary) for each in sources])
    entries, found = _entries(sources, trials, seed, jobs, progress)
    aim = aim_of([each.summary for each in sources])
    best = min(range(len(entries)), key=lambda index: _rank(entries[index], aim))
    columns = [run.columns if run is not None else {} for run in found]
    own = sources[best].mission
    return Alternatives(
        provenance=Provenance(
            command="compare",
            mission=" and ".join(each.name for each in sources),
            file=" ".join(str(each.path) for each in sources),
            seed=entries[best].seed,
            trials=entries[best].trials,
            options={"jobs": jobs},
            elapsed_s=time.perf_counter() - began,
            data={each.name: each.data for each in sources},
            inputs={each.name: each.identified for each in sources},
            holds=coverage_of({each.name: each.mission or each.summary for each in sources}),
        ),
        alternatives=tuple(
            entry if index == best else replace(entry, contrasts=_contrasts(entries, columns, index, best))
            for index, entry in enumerate(entries)
        ),
        best=best,
        compared=compared,
        aim=aim,
        differing=differing_values([each.data for each in sources]),
        assumptions=() if own is None else judgement.ledger(own, entries[best].seed),
    )


def _entries(
    sources: Sequence["_Source"], trials: int | None, seed: int | None, jobs: int, progress: Progress | None
) -> tuple[list[Alternative], list[CellTrials | None]]:
    """Run the missions and read the reports; returns the trials of the missions besides."""
    missions = [each.mission for each in sources if each.mission is not None]
    ran: list[CellTrials] = []
    if missions:
        check_arguments(missions[0], trials=trials, seed=seed, jobs=jobs)
        trials = missions[0].monte_carlo.trials if trials is None else trials
        seed = missions[0].monte_carlo.seed if seed is None else seed
        ran = _run(missions, trials, seed, Workers(jobs, progress=progress))
    runs = iter(ran)
    found = [next(runs) if each.mission is not None else None for each in sources]
    entries = [
        _of_mission(each.name, each.path, each.mission, run, seed or 0)
        if each.mission is not None and run is not None
        else reported_alternative(each.name, each.path, each.summary)
        for each, run in zip(sources, found, strict=True)
    ]
    return entries, found


def _run(missions: Sequence[Mission], trials: int, seed: int, workers: Workers) -> list[CellTrials]:
    """Run missions on common random numbers; raises InputError where one cannot be run."""
    task = MissionTask(missions, [SharedCurrent.of(mission) for mission in missions], seed, (DURATION, ENERGY))
    items = [(number, *block) for number in range(len(missions)) for block in sized_blocks(trials)]
    ran = cell_trials(task, items, range(len(missions)), workers)
    if problems := [Problem(each.reason, own.file) for own, each in zip(missions, ran, strict=True) if each.reason]:
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
    for number, each in enumerate(alternatives, start=1):  # a mission that is given as such has its name for a path
        name = as_path((each.name or f"mission {number}") if isinstance(each, Mission) else each, "alternatives")
        paths.append(Path(f"{name} {number}") if isinstance(each, Mission) and name in paths else name)
    if len(paths) < 2:
        raise InputError([Problem(f"given {len(paths)}, expected two or more missions or reports", key="alternatives")])
    found = []
    for named, path, each in zip(_names(paths), paths, alternatives, strict=True):
        if not isinstance(each, Mission) and is_folder(path):
            found.append(_Source(named, path, None, read_summary(path)))
        else:
            mission = each if isinstance(each, Mission) else load(path, allow_outside=allow_outside)
            found.append(_Source(named, path, mission, {}))
    return found


def _names(paths: Sequence[Path]) -> list[str]:
    """Return the last part of each path, or the whole where parts are alike."""
    short = [path.resolve().stem if path.suffix in (".yaml", ".yml") else path.resolve().name for path in paths]
    if len(set(short)) == len(short):
        return short
    whole = [str(path) for path in paths]
    return whole if len(set(whole)) == len(whole) else [f"{name} ({i + 1})" for i, name in enumerate(whole)]


def _of_mission(name: str, path: Path, mission: Mission, found: CellTrials, seed: int) -> Alternative:
    cell = cell_of((), mission, found.columns, "")
    if cell.reason:
        raise InputError([Problem(cell.reason, str(path))])
    quantities: dict[str, Estimate] = {
        key.partition(".")[2]: (statistic.mean, statistic.standard_error)
        for key, statistic in cell.quantities.items()
        if statistic.count
    }
    return Alternative(name, str(path), cell.success, quantities, cell.requirements, cell.trials, seed, {})


def _rank(each: Alternative, aim: Aim) -> tuple[bool, int, float, float]:
    """Order alternatives, the best first; last those of which nothing is known."""
    energy, first = (each.quantities.get(key, (np.inf, 0.0))[0] for key in ("energy_wh", DECIDES[aim]))
    known = np.isfinite(each.success.value)
    first = -each.success.value if aim == "success" and known else first
    return not known, len(each.missed), first, energy if np.isfinite(energy) else np.inf


def _contrasts(
    entries: Sequence[Alternative], columns: Sequence[Mapping[str, np.ndarray]], index: int, best: int
) -> dict[str, Contrast]:
    """Compare an alternative with the best: in pairs where both were run here, else as independent runs."""
    level = LEVEL / (len(entries) - 1)
    found = {}
    for key, column in _COLUMNS.items():
        one, two = _number(entries[best], key), _number(entries[index], key)
        if one is None or two is None:
            continue
        if column in columns[best] and column in columns[index]:
            own, other = columns[index][column], columns[best][column]
            mean, error, up = paired_difference(own, other, most=True)
            down = paired_difference(own, other, most=False)[2]
            found[key] = Contrast(mean, error, 2.0 * min(up, down) < level, paired=True)
        else:
            spread, p_value = standard_error_and_p_value(one, two, (entries[best].trials, entries[index].trials))
            differs = p_value is not None and p_value < level
            found[key] = Contrast(two.value - one.value, spread or 0.0, differs, paired=False)
    return found


def _number(each: Alternative, key: str) -> SummaryNumber | None:
    if key == "success":
        known = np.isfinite(each.success.value)
        return SummaryNumber("probability", each.success.value, float("nan")) if known else None
    return SummaryNumber("mean", *each.quantities[key]) if key in each.quantities else None


def compare(
    *compared: MissionOrPath,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Comparison | Alternatives:
    """Compare two reports of one command, or two and more missions or reports.

    Parameters
    ----------
    *compared : Mission, str or Path
        Two report folders: what changed, and is it more than noise? Missions, their files, more than two, or reports of
        what was chosen (`explore`, `optimise`): which is better? Missions are run on the same random numbers.
    trials, seed : int, optional
        Of the missions; default: the first mission's.
    jobs : int
        Processes.
    allow_outside : bool
        Whether missions may name files outside their folders.
    progress : callable, optional
        Called with the trials done and their total.

    Raises
    ------
    InputError
        When something is neither a mission nor a report, a mission cannot be run, or the reports cannot be compared.
    """
    if len(compared) == 2 and not any(_is_mission(each) for each in compared):
        first, second = (as_path(each, "compared") for each in compared if not isinstance(each, Mission))
        if {read_summary(folder)["command"] for folder in (first, second)}.isdisjoint(CHOOSING):
            return compare_reports(first, second)
    return compare_missions(
        *compared, trials=trials, seed=seed, jobs=jobs, allow_outside=allow_outside, progress=progress
    )


def _is_mission(given: MissionOrPath) -> bool:
    if isinstance(given, Mission):
        return True
    path = Path(given)
    return path.suffix in (".yaml", ".yml") or (path.exists() and not is_folder(path))
