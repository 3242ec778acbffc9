"""The anchor that a mission asks for: its worst-case wet weight, and its mass once it is built and flooded."""

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.views import MooringMission
from missionplan.montecarlo.distributions import mean_of, sd_of
from missionplan.phases.mooring.forces import DescentHooks, SteadyDescent
from missionplan.physics.anchor import AnchorProblem, Construction, Part, dry_mass
from missionplan.physics.buoyancy import flooded_mass
from missionplan.physics.mooring import layer_thicknesses, required_terminal_velocity
from missionplan.physics.vehicle_drag import anchor_drag
from missionplan.scenario.scenario import Scenario


def design_current(means: Scenario, phase: MoorPhase) -> tuple[Array, Array]:
    """Worst current of each layer, and the layers' thicknesses.

    Returns
    -------
    speeds, thicknesses : array, shape (k,)
        The phase's `design_current`; by default each layer's mean + 2 sd [m/s, m].

    Raises
    ------
    InputError
        When there is neither, as with a current from a file.
    """
    site, given = MooringMission.of(means.mission).site, phase.design_current
    depth = float(means["site.depth"])
    written = site.current if isinstance(site.current, tuple) else ()
    if not written:
        if given is None or isinstance(given, tuple):
            raise InputError(
                [Problem("sizing the anchor needs one `design_current` where the site has no layers", key=phase.name)]
            )
        return np.array([given]), np.array([depth])
    thicknesses = layer_thicknesses(np.array([mean_of(layer.down_to) for layer in written]), depth)
    if given is None:
        speeds = [abs(mean_of(layer.speed)) + 2.0 * sd_of(layer.speed) for layer in written]
    else:
        speeds = list(given) if isinstance(given, tuple) else [given] * len(written)
    return np.array(speeds, dtype=float), thicknesses


def worst_case_weight(means: Scenario, phase: MoorPhase) -> float:
    """Wet weight that takes the vehicle down within the radius in the worst current, all layers aligned (Eqs. 1, 15).

    Parameters
    ----------
    means : Scenario
        At the means.
    phase : MoorPhase

    Returns
    -------
    float
        Drag at the required terminal velocity with the mission's effects, and the vehicle's net buoyancy where the
        phase says so [N].
    """
    speeds, thicknesses = design_current(means, phase)
    over_ground = float(required_terminal_velocity(speeds, thicknesses, means[f"{phase.name}.radius"]))
    sink = SteadyDescent.at(over_ground, DescentHooks(means.descent_effects), float(means["site.depth"]))
    law = anchor_drag(means["vehicle.anchor.diameter"], means["vehicle.anchor.drag_coefficient"], means.water.density)
    weight = float(sink.wet_weight(means.vehicle_drag(sink.through_water) + law(sink.through_water)))
    weight += float(means["vehicle.net_buoyancy"]) if phase.carry_net_buoyancy else 0.0
    if weight <= 0.0:
        raise InputError([Problem("no current to size the anchor for", key=f"{phase.name}.anchor_wet_weight")])
    return weight


def anchor_problem(means: Scenario) -> AnchorProblem:
    """Geometry and materials of the mission's anchor, at their means.

    Raises
    ------
    KeyError
        Where the mission gives the anchor no construction.
    """
    path = "vehicle.anchor.construction"

    def mean(key: str) -> float:
        return float(means[key])

    return AnchorProblem(
        radius=mean("vehicle.anchor.diameter") / 2.0,
        overlap_volume=mean("vehicle.anchor.overlap_volume"),
        nose_radius=mean("vehicle.hull.diameter") / 2.0,
        water_density=float(means.water.density),
        construction=Construction(
            front=Part(*(mean(f"{path}.front.{key}") for key in ("mass", "density", "centre"))),
            back=Part(*(mean(f"{path}.back.{key}") for key in ("mass", "density", "centre_from_back"))),
            tube_mass_per_length=mean(f"{path}.tube.mass_per_length"),
            tube_density=mean(f"{path}.tube.density"),
            trim_density=mean(f"{path}.trim.density"),
        ),
    )


def anchor_flooded_mass(means: Scenario, weight: Scalars) -> Scalars:
    """Mass with the water inside of the anchor built for a wet weight [N], without added mass [kg]."""
    return flooded_mass(dry_mass(anchor_problem(means), weight), weight)
