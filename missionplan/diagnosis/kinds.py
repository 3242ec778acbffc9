"""The kinds of data that can be diagnosed: a new kind has a folder of its own and a line here."""

from pathlib import Path

from missionplan.datasets.reading import dataset_kind
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.dives.kind import DescentKind
from missionplan.diagnosis.legs.kind import TransitKind
from missionplan.diagnosis.summaries.kind import SummaryKind
from missionplan.diagnosis.tank.kind import TankKind
from missionplan.mission import Mission

KINDS: tuple[type[DataKind], ...] = (
    TransitKind,
    DescentKind,
    TankKind,
    SummaryKind,
)


def bind_dataset(folder: Path, mission: Mission, seed: int) -> DataKind:
    """Read a data set of any kind and bind a mission to it.

    Parameters
    ----------
    folder : Path
        With ``dataset.yaml``, whose ``kind`` says which it is.
    mission : Mission
    seed : int
        Of draws from the mission's own uncertainty.

    Raises
    ------
    InputError
        When there is no such kind; all problems of the data set, or all that the mission lacks.
    """
    known = {name: kind for kind in KINDS for name in kind.ids}
    given = dataset_kind(folder, known)
    return known[given].bind(given, folder, mission, seed)
