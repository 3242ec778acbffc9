"""`identify`: hydrodynamic and thruster parameters, with their errors, from data of the tank."""

import time
from collections.abc import Callable
from pathlib import Path

from missionplan.datasets.tank import TankData, read_tank_data
from missionplan.results.base import Provenance
from missionplan.results.identification import Identification, TankAnalysis
from missionplan.studies.identification.drag import identify_drag
from missionplan.studies.identification.oscillation import identify_oscillation
from missionplan.studies.identification.propeller import identify_propeller
from missionplan.studies.identification.thruster import identify_thruster

_KINDS: dict[str, Callable[[TankData], TankAnalysis]] = {
    "drag": identify_drag,
    "free-oscillation": identify_oscillation,
    "thruster": identify_thruster,
    "propeller-transient": identify_propeller,
}


def identify(dataset: str | Path) -> Identification:
    """Find the parameters that a data set of the tank holds.

    Parameters
    ----------
    dataset : str or Path
        Folder with `dataset.yaml`, of kind drag, free-oscillation, thruster or propeller-transient.

    Returns
    -------
    Identification
        Parameters with standard errors and 90 % intervals, fits, and a fragment for a vehicle file.

    Raises
    ------
    InputError
        With every problem of the data set.
    RunError
        When the data do not determine the parameters.
    """
    started = time.perf_counter()
    data = read_tank_data(dataset)
    analysis = _KINDS[data.settings.kind](data)
    name = data.settings.name or Path(dataset).resolve().name
    provenance = Provenance(
        command="identify",
        mission=name,
        file=str(dataset),
        seed=0,
        trials=0,
        options={},
        elapsed_s=time.perf_counter() - started,
        data=data.raw,
        notices=data.notes,
    )
    return Identification(provenance, data.settings.kind, name, data.settings.source, analysis)
