"""The kinds of data that can be diagnosed: a new kind has a folder of its own and a line here."""

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import cast

from missionplan.datasets import dataset_kind
from missionplan.diagnosis.data_kind import DataKind
from missionplan.mission import Mission

KINDS: Mapping[str, tuple[str, str]] = {
    "transit": ("missionplan.diagnosis.legs.kind", "TransitKind"),
    "descent": ("missionplan.diagnosis.dives.kind", "DescentKind"),
    "drag": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "free-oscillation": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "thruster": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "propeller-transient": ("missionplan.diagnosis.tank.kind", "TankKind"),
    "summary": ("missionplan.diagnosis.summaries", "SummaryKind"),
}
"""By ``kind`` in ``dataset.yaml``, the module and the class: one of them is imported, when it is needed."""


def kind_named(name: str) -> type[DataKind]:
    """Import a kind of data by its name in ``dataset.yaml``."""
    module, of = KINDS[name]
    return cast("type[DataKind]", getattr(import_module(module), of))


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
    given = dataset_kind(folder, KINDS)
    return kind_named(given).bind(given, folder, mission, seed)
