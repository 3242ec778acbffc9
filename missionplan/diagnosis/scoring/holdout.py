"""The last share of a record kept away from its diagnosis, and the extended mission's score on it."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from missionplan.datasets.legs import MIN_LEGS
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.dives.kind import DescentKind
from missionplan.diagnosis.dives.model import descent_model
from missionplan.diagnosis.dives.preparation import MIN_DIVES, PreparedDives
from missionplan.diagnosis.learned_data import unlearned
from missionplan.diagnosis.legs.kind import TransitKind, transit_model
from missionplan.diagnosis.scoring import read_record, scored_record
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.montecarlo.posterior import NOWHERE
from missionplan.results.score import DatasetScore


def first_part(bound: DataKind, share: float, seed: int) -> DataKind:
    """Return a record without its last share, bound to the same mission.

    Raises InputError when it is not a share, a part is too short, or the data are neither legs nor dives.

    `bound`: of legs or dives. `share`: of the legs or dives, from the end. `seed`: of draws from the mission's own
    uncertainty.
    """
    if bound.is_known:
        raise InputError("holdout: the mission has learned from all of these data (learned_from): none is held out")
    if isinstance(bound, TransitKind):
        legs = bound.data.subset(np.arange(_kept(bound.data, share)))
        return TransitKind(bound.kind, bound.mission, legs, transit_model(legs, bound.mission, seed))
    if isinstance(bound, DescentKind):
        dives = replace(bound.data, dives=bound.data.dives[: _kept(bound.data, share)])
        return DescentKind(bound.kind, bound.mission, dives, descent_model(dives, bound.mission))
    raise InputError(f"holdout: given data of kind {bound.kind}, expected legs (transit) or dives (descent)")


def score_last_part(
    folder: Path, share: float, base: Mission, extended: Mapping[str, object], seed: int
) -> DatasetScore:
    """Score a mission that was extended on the first part of a record on the rest, whose past that part is.

    Parameters
    ----------
    folder : Path
        Of the data set.
    share : float
        Of the legs or dives, from the end.
    base : Mission
        For the origin and start to which the record refers.
    extended : mapping
        The extended mission's data.
    seed : int
        Of the draws.
    """
    record = replace(unlearned(read_record(folder, base), base), notices=())
    same = Mission.from_data(extended, file=base.file).at_place(NOWHERE, None)  # the vehicle of the same record
    return scored_record(record, same, seed, past=_kept(record, share))


def _kept(data: TransitData | PreparedDives, share: float) -> int:
    """Number of legs or dives that a diagnosis sees."""
    if isinstance(data, TransitData):
        count, least_kept, least_held_out, what = data.n, MIN_LEGS, MIN_LEGS, "legs"
    else:
        count, least_kept, least_held_out, what = len(data.dives), MIN_DIVES, 1, "dives"
    if not 0.0 < share < 1.0:
        raise InputError(f"holdout: given {share:g}, expected a share of the record between 0 and 1")
    kept = round(count * (1.0 - share))
    if kept < least_kept or count - kept < least_held_out:
        raise InputError(
            f"holdout: leaves {kept} {what} for the diagnosis and {count - kept} for the score; "
            f"expected at least {least_kept} and {least_held_out}"
        )
    return kept
