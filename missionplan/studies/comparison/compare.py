"""`compare`: two reports of one command, or missions on common random numbers."""

from pathlib import Path

from missionplan.mission import Mission, MissionOrPath
from missionplan.montecarlo.parallel.blocks import Progress
from missionplan.results.choosing.alternatives import Alternatives
from missionplan.results.comparison import Comparison
from missionplan.store.paths import is_folder
from missionplan.studies.comparison.compare_missions import compare_missions
from missionplan.studies.comparison.two_reports import compare_reports


def compare(
    *compared: MissionOrPath,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Comparison | Alternatives:
    """Compare two reports of one command, or two and more missions or reports of `simulate`.

    Parameters
    ----------
    *compared : Mission, str or Path
        Two report folders: what changed, and is it more than noise? Missions, their files, or more than two: which is
        better? Missions are run on the same random numbers.
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
        first, second = compared
        return compare_reports(first, second)  # type: ignore[arg-type]  # neither is a mission
    return compare_missions(
        *compared, trials=trials, seed=seed, jobs=jobs, allow_outside=allow_outside, progress=progress
    )


def _is_mission(given: MissionOrPath) -> bool:
    if isinstance(given, Mission):
        return True
    path = Path(given)
    return path.suffix in (".yaml", ".yml") or (path.exists() and not is_folder(path))
