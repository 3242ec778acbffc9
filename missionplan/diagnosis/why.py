"""From a vehicle's logs to why it was not where it reckoned: the data set, the diagnosis and the next mission."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from missionplan.diagnosis.diagnose import diagnose
from missionplan.importers.importing import import_logs
from missionplan.mission import MissionOrPath
from missionplan.store.folder import as_path

if TYPE_CHECKING:
    from missionplan.results.learned import Diagnosis

DATASET = "dataset"
"""Folder of the data set, in the one of the report."""
MISSION = "mission.yaml"
"""Mission of the legs themselves, which an import writes beside them."""


def why(
    sources: str | Path | Sequence[str | Path],
    folder: str | Path,
    *,
    mission: MissionOrPath | None = None,
    seed: int | None = None,
    jobs: int = 1,
    next_trial: bool = False,
    progress: Callable[[int, int], None] | None = None,
    **reading: Any,
) -> "Diagnosis":
    """Import logs and diagnose what they hold.

    Parameters
    ----------
    sources : str, Path or sequence of them
        Log files, and folders of them.
    folder : str or Path
        The data set is written to ``dataset`` in it; save the result there too.
    mission : Mission, str or Path, optional
        That the vehicle sailed; default: one that is made of its logs.
    seed, jobs, next_trial
        See `diagnose`.
    progress : callable, optional
        Called with what is done and the total.
    **reading
        See `import_logs`.

    Raises
    ------
    InputError
        When the logs, the mission or an option are wrong.
    """
    dataset = as_path(folder, "folder") / DATASET
    import_logs(sources, progress=progress, **reading).save(dataset, force=True)
    sailed = dataset / MISSION if mission is None else mission
    return diagnose(sailed, dataset, seed=seed, jobs=jobs, next_trial=next_trial, progress=progress)
