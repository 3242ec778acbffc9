"""`compare`: two reports of one command, or missions on common random numbers."""

from pathlib import Path

from missionplan.mission import Mission, MissionOrPath
from missionplan.montecarlo.parallel.blocks import Progress
from missionplan.results.choosing.alternatives import Alternatives
from missionplan.results.comparison import Comparison
from missionplan.store.paths import as_path, is_folder
from missionplan.studies.comparison.compare_missions import compare_missions
from missionplan.studies.comparison.reported_choices import CHOOSING
from missionplan.studies.comparison.two_reports import compare_reports, read_summary


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
        When something is neither a mission nor a report, or the reports cannot be compared.
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
