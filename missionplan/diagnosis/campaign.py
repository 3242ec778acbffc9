"""Diagnoses of several steps: of logs, imported first; of data sets, the posterior of one the prior of the next."""

import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from missionplan.datasets import dataset_kind, files_outside, load_dataset_document
from missionplan.datasets.dives import read_descent
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.data_kind import KINDS
from missionplan.diagnosis.diagnose import diagnose
from missionplan.errors import InputError
from missionplan.mission import Mission, MissionOrPath
from missionplan.results.learned import Campaign, Diagnosis
from missionplan.store.folder import as_path
from missionplan.studies.run import Run, check_arguments

ORDER = ("drag", "free-oscillation", "thruster", "propeller-transient", "summary", "descent", "transit")
"""Kinds of data in the order in which they are diagnosed: the tank, which measures a thing by itself, first."""
PARTED = ("descent", "transit")
"""Kinds of data whose last share can be kept away."""
Progress = Callable[[int, int], None]
"""Called with data sets done, of how many."""


def diagnose_campaign(
    mission: MissionOrPath,
    datasets: Sequence[str | Path],
    *,
    seed: int | None = None,
    jobs: int = 1,
    plan: bool = True,
    holdout: float | None = None,
    next_trial: bool = False,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Campaign:
    """Diagnose several data sets of one campaign, of any kinds, one after the other.

    They are taken in the order of `ORDER`, then of the dates of legs and dives, then of their names, however they are
    given. Each is laid against the mission that the one before has extended, so that an effect which several of them
    can show has the posterior of one as its prior for the next.

    Parameters
    ----------
    mission : Mission, str or Path
        The base model.
    datasets : sequence of str or Path
        Folders of data sets.
    seed, jobs, plan, allow_outside
        As of `diagnose`.
    holdout : float, optional
        Last share of each record of legs or dives that is kept away; the mission extended so far is scored on it.
    next_trial : bool
        Whether to value the trials that could be made after the last of the data sets.
    progress : callable, optional
        Called with data sets done, of how many.

    Raises
    ------
    InputError
        When a data set or the mission lack what a diagnosis needs, or one is given twice.
    RunError
        When not even the base model can be fitted to one of them.
    """
    started = time.perf_counter()
    base = check_arguments(mission, seed=seed, jobs=jobs)
    folders = list({as_path(dataset, "dataset").resolve() for dataset in datasets})
    if len(folders) != len(datasets) or not folders:
        raise InputError(f"datasets: given {len(datasets)}, {len(folders)} of them different; expected each one once")
    with files_outside(allowed=allow_outside):
        folders.sort(key=partial(_place, mission=base))
    parted = [folder for folder in folders if dataset_kind(folder, KINDS) in PARTED]
    if holdout is not None and not parted:
        raise InputError("holdout: none of the data sets is of legs (transit) or dives (descent)")
    extended, diagnoses = base, []
    for folder in folders:
        one = diagnose(
            extended,
            folder,
            seed=seed,
            jobs=jobs,
            plan=plan,
            holdout=holdout if folder in parted else None,
            next_trial=next_trial and folder == folders[-1],
            allow_outside=allow_outside,
        )
        diagnoses.append(one)
        extended = Mission.from_data(one.extended, file=base.file)
        if progress is not None:
            progress(len(diagnoses), len(folders))
    provenance = Run("diagnose", base, 0, diagnoses[0].provenance.seed, started=started).provenance(
        {
            "datasets": [str(folder) for folder in folders],
            "jobs": jobs,
            "plan": plan,
            "holdout": holdout,
            "next_trial": next_trial,
        },
        datasets=folders,
        notices=tuple(dict.fromkeys(notice for diagnosis in diagnoses for notice in diagnosis.provenance.notices)),
    )
    return Campaign(provenance, tuple(diagnoses))


def _place(folder: Path, mission: Mission) -> tuple[int, float, str, str]:
    """Place of a data set in the order: by its kind, its date (without one last), its name, its folder."""
    kind, date = dataset_kind(folder, KINDS), math.nan
    if kind in PARTED:
        date = read_transit(folder, mission).date if kind == "transit" else read_descent(folder, mission).date
    name = str(load_dataset_document(folder).data.get("name") or "")
    return ORDER.index(kind), date if math.isfinite(date) else math.inf, name, str(folder)


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
    progress: Progress | None = None,
    **reading: Any,
) -> Diagnosis:
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
    from missionplan.importers import import_logs

    dataset = as_path(folder, "folder") / DATASET
    import_logs(sources, progress=progress, **reading).save(dataset, force=True)
    sailed = dataset / MISSION if mission is None else mission
    return diagnose(sailed, dataset, seed=seed, jobs=jobs, next_trial=next_trial, progress=progress)
