"""`identify`: hydrodynamic and thruster parameters, with their errors, from tank data."""

import math
import time
from dataclasses import replace
from pathlib import Path

from missionplan.datasets.reading import files_outside
from missionplan.datasets.tank import (
    DragSettings,
    OscillationSettings,
    PropellerSettings,
    TankData,
    ThrusterSettings,
    read_tank_data,
)
from missionplan.results.base import Provenance
from missionplan.results.learned.identification import Identification, TankAnalysis
from missionplan.studies.identification.drag import identify_drag
from missionplan.studies.identification.oscillation import identify_oscillation
from missionplan.studies.identification.propeller import identify_propeller
from missionplan.studies.identification.thruster import identify_thruster
from missionplan.studies.run import identified_datasets


def identify(dataset: str | Path, *, allow_outside: bool = False) -> Identification:
    """Find the parameters that a data set from a tank determines.

    Parameters
    ----------
    dataset : str or Path
        Folder with `dataset.yaml`, of kind drag, free-oscillation, thruster or propeller-transient.
    allow_outside : bool
        Whether its tables may lie outside the folder.

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
    with files_outside(allowed=allow_outside):
        data = read_tank_data(dataset)
    analysis = _analysis(data)
    provenance = Provenance(
        command="identify",
        mission=data.name,
        file=str(dataset),
        seed=0,
        trials=0,
        options={},
        elapsed_s=time.perf_counter() - started,
        data=data.raw,
        notices=data.notices,
        inputs=identified_datasets([Path(dataset)]),
    )
    return Identification(provenance, data.settings.kind, data.name, data.source, _headed(analysis))


def _headed(analysis: TankAnalysis) -> TankAnalysis:
    """Lead with it where the preferred model does not fit, and say what its numbers are then."""
    best = analysis.fits[0]
    if not best.does_not_fit:
        return analysis
    larger = math.sqrt(best.chi_squared / best.degrees_of_freedom)
    headline = (
        f"The model does not fit ({best.name}): chi-squared is {best.chi_squared:.0f} on {best.degrees_of_freedom} "
        f"degrees of freedom, the residuals are {larger:.1f} times the stated errors. These are the numbers of the "
        "best fit, without an interval. "
    )
    remark = (
        "What a model leaves out can shift its parameters by more than any standard error says, so no interval is "
        "given. Look at the residuals for what is missing. If the stated errors are too small, correct them or leave "
        "them out: the interval then follows from the scatter. Errors in the vehicle's fragment take the misfit for "
        f"scatter: they are {best.widened:.1f} times those that follow from the stated errors."
    )
    return replace(analysis, answer=headline + analysis.answer, remarks=(remark, *analysis.remarks))


def _analysis(data: TankData) -> TankAnalysis:
    """Analyse data by their kind."""
    match data.settings:
        case DragSettings() as settings:
            return identify_drag(data, settings)
        case OscillationSettings() as settings:
            return identify_oscillation(data, settings)
        case ThrusterSettings() as settings:
            return identify_thruster(data, settings)
        case PropellerSettings() as settings:
            return identify_propeller(data, settings)
