"""What a mission has learned from already is not counted again: such legs, dives and runs are left out of data."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from missionplan.datasets.legs import enough
from missionplan.datasets.records import TransitData, is_learned, listed
from missionplan.datasets.summaries import SummaryData
from missionplan.datasets.tank import TankData
from missionplan.diagnosis.dives.preparation import MIN_DIVES, PreparedDives
from missionplan.errors import InputError, counted
from missionplan.mission import Mission
from missionplan.montecarlo.posterior import NOWHERE

Data = TypeVar("Data", TransitData, PreparedDives, TransitData | PreparedDives, SummaryData, TankData)
NEW = "that the mission has not learned from"
WHOLE = "lay all of them against the mission as it was before it had learned from the others"


def unlearned(data: Data, mission: Mission) -> Data:
    """Return the part of a data set that a mission has not learned from, with a notice of what was left out.

    Where it has learned from everything, all is returned: such data can be laid against the mission, but teach nothing.
    Raises InputError when too little is new.
    """
    mask = is_learned(data, mission.learned_from)
    if not mask.any():
        return data
    noun, names = _groups(data)
    if mask.all():
        every = f"this {noun}" if len(mask) == 1 else f"all {len(mask)} {noun}s"
        words = f"the mission has learned from {every} already (learned_from): nothing is learned again"
        return replace(data, notices=(*data.notices, words))
    left_out = listed([name for name, is_known in zip(names, mask, strict=True) if is_known])
    words = (
        f"{counted(int(mask.sum()), noun)} of {len(mask)} from which the mission has learned already (learned_from) "
        f"count once, and are left out: {left_out}"
    )
    part = data.subset(~mask)
    if isinstance(part, TransitData):
        enough(part, NEW, WHOLE)
    if isinstance(part, PreparedDives) and len(part.dives) < MIN_DIVES:
        raise InputError(f"{part.name}: {counted(len(part.dives), 'dive')} {NEW}, too few: {WHOLE}")
    return replace(part, notices=(*data.notices, words))


def as_then(
    data: TransitData | PreparedDives | SummaryData | TankData, mission: Mission, date: float = math.nan
) -> Mission:
    """Return a mission with what it has learned of the vehicle as it was when data were taken.

    `date`: of the data [s since 1970]; nan where it is not known: they are those of the next mission.
    """
    return mission.at_place(NOWHERE, None if is_learned(data, mission.learned_from).all() else date)


def _groups(data: TransitData | PreparedDives | SummaryData | TankData) -> tuple[str, Sequence[str]]:
    """What the parts of a data set are, and their names."""
    if isinstance(data, TransitData):
        return "leg", data.labels.tolist()
    if isinstance(data, PreparedDives):
        return "dive", [log.name for log in data.dives]
    if isinstance(data, SummaryData):
        return "test", [test.name for test in data.tests]
    whole = len(data.identities) == 1
    return "record" if whole else "row", [str(k + 1) for k in range(len(data.identities))]
