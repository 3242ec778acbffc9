"""Random streams of a transit, named by its phase: every study of a mission runs the same trials."""

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import Phase, TransitPhase
from missionplan.montecarlo.streams import LegSource, NormalSource
from missionplan.phases.state import TrialState
from missionplan.phases.transit.plan import TransitNormals
from missionplan.scenario.scenario import Scenario


def transit_normals(scenario: Scenario, phase: TransitPhase[Scalars], source: NormalSource) -> TransitNormals:
    """Open the streams of a transit's legs.

    They depend on the phase alone, so that every σ_v and every d_max has the same ones (common random numbers).

    Parameters
    ----------
    scenario : Scenario
    phase : TransitPhase
    source : NormalSource
    """

    def legs(quantity: str) -> LegSource:
        return source.legs(f"{phase.name}.{quantity}")

    return TransitNormals(
        velocity=legs("velocity_error"),
        fix_on_surfacing=legs("fix_on_surfacing"),
        fix_on_diving=legs("fix_on_diving"),
        effects=[legs(name) for name in scenario.transit_effect_streams],
    )


def deployed(
    scenario: Scenario, phase: "Phase[Scalars]", position: Array, source: NormalSource, trials: int
) -> TrialState:
    """Deploy a block of trials at a position, shape (2,) or (2, n) [m], with a fix before the first dive of a phase."""
    sd = scenario.fix_sd
    noise = sd * fix_normals(f"{phase.name}.fix_at_start", source, trials) if np.any(sd) else 0.0
    return TrialState.at(position, trials, noise)


def fix_normals(quantity: str, source: NormalSource, trials: int) -> Array:
    """Standard normals of a fix that is taken once, shape (2, n)."""
    return source.legs(quantity).leg(0)[:, :trials]
