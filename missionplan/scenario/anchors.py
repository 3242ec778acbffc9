"""The anchors of a mission: wet weight for the worst current, mass once built and flooded, and those still aboard.

The vehicle carries its anchors one before the other on its nose, the next to be moored foremost, sealed and neutral
(Briggs et al., Eq. 17). Each stays aboard until its own mooring.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.schema.vehicle import Centre, Vehicle
from missionplan.mission.views import MooringMission, missing_for_moorings, required
from missionplan.montecarlo.distributions import mean_of, sd_of
from missionplan.phases.mooring.forces import DescentHooks, SteadyDescent
from missionplan.physics.anchor import (
    AnchorProblem,
    Construction,
    Part,
    cap_height,
    cylinder_and_trim,
    dry_mass,
    layer_thicknesses,
    required_terminal_velocity,
)
from missionplan.physics.drag import MeasuredVehicleDrag, VehicleDrag, anchor_drag
from missionplan.physics.water import STANDARD_GRAVITY, flooded_mass, lead_mass
from missionplan.scenario.drawn_mission import DrawnMission

_Drawn = TypeVar("_Drawn", bound=DrawnMission)


@dataclass(frozen=True)
class CarriedAnchors:
    """What the anchors that are attached, sealed and neutral add to the vehicle."""

    length: Scalars
    """By which they lengthen the hull, float or shape (n,) [m]."""
    mass: Scalars
    """Dry, float or shape (n,) [kg]."""

    def lengthened(self, drag: VehicleDrag) -> VehicleDrag:
        """Drag of the vehicle with the anchors on its nose; one that was measured in a tank stays as it is."""
        if isinstance(drag, MeasuredVehicleDrag):
            return drag
        return replace(drag, hull=replace(drag.hull, length=drag.hull.length + self.length))


def carried_anchors(
    drawn: DrawnMission, phase: TransitPhase[Scalars] | MoorPhase[Scalars], spare: Scalars | None = None
) -> CarriedAnchors | None:
    """Return the anchors that stay aboard in a phase, a mooring's own not among them.

    None where there are none left, or the mission does not give its anchor. Spare ones are as the mooring's own, whose
    wet weight [N] may be given.
    """
    moors = _aboard(drawn, phase)
    if not moors or missing_for_moorings(drawn.mission):
        return None
    overlap = overlap_height(drawn.means)
    length: Scalars = 0.0
    mass: Scalars = 0.0
    try:
        for moor in moors:
            weight = wet_weight_of(drawn, moor) if spare is None or moor.name != phase.name else spare
            length = length + np.maximum(anchor_length(drawn, weight) - overlap, 0.0)
            dry = anchor_flooded_mass(drawn, weight) - weight / STANDARD_GRAVITY
            mass = mass + np.maximum(dry, 0.0)
    except (InputError, ValueError):
        return None  # said by who sizes the anchor: a study of the transits alone needs none
    return CarriedAnchors(length, mass)


def _aboard(drawn: DrawnMission, phase: TransitPhase[Scalars] | MoorPhase[Scalars]) -> Sequence[MoorPhase[Scalars]]:
    """The moorings of the anchors that are aboard in a phase; one more than the mission moors is as the last."""
    moors, vehicle = drawn.drawn.moors, drawn.drawn.vehicle
    names = [other.name for other in drawn.mission.phases]
    if not moors or vehicle is None or phase.name not in names:
        return ()
    until = names.index(phase.name) + isinstance(phase, MoorPhase)
    gone = sum(isinstance(other, MoorPhase) for other in drawn.mission.phases[:until])
    left = max(vehicle.anchors - gone, 0)
    return (*moors[gone:], *[moors[-1]] * vehicle.anchors)[:left]


def laden(drawn: _Drawn, phase: TransitPhase[Scalars] | MoorPhase[Scalars], spare: Scalars | None = None) -> _Drawn:
    """Return the mission with the vehicle of a phase: longer and heavier by the anchors that it keeps aboard."""
    carried, vehicle = carried_anchors(drawn, phase, spare), drawn.drawn.vehicle
    if carried is None or vehicle is None or vehicle.mass is None:
        return drawn
    hull = vehicle.hull.model_copy(update={"length": vehicle.hull.length + carried.length})
    changed = {"hull": hull, "mass": vehicle.mass + carried.mass, **_centres(vehicle, vehicle.mass, carried)}
    changed |= {"anchors": 0}  # they are a part of it now
    return replace(drawn, drawn=drawn.drawn.model_copy(update={"vehicle": vehicle.model_copy(update=changed)}))


def _centres(vehicle: Vehicle[Scalars], mass: Scalars, carried: CarriedAnchors) -> dict[str, Centre[Scalars]]:
    """Centres of gravity and of buoyancy from the foremost anchor's tip, where the file gives them."""
    if vehicle.centres is None:
        return {}
    centres = {}
    masses = (mass, mass + vehicle.net_buoyancy / STANDARD_GRAVITY)
    for key, centre, weight in zip(("centre_of_gravity", "centre_of_buoyancy"), vehicle.centres, masses, strict=True):
        total = weight + carried.mass
        moment = weight * (centre.from_nose + carried.length) + carried.mass * 0.5 * carried.length
        centres[key] = centre.model_copy(
            update={"from_nose": moment / total, "below_axis": centre.below_axis * weight / total}
        )
    return centres


def overlap_height(means: DrawnMission) -> float:
    """How far the vehicle's nose reaches into the anchor [m]."""
    needed = means.mooring
    return cap_height(float(needed.anchor.overlap_volume), float(needed.vehicle.hull.diameter) / 2.0)


def design_current(means: DrawnMission, phase: MoorPhase[Scalars]) -> tuple[Array, Array]:
    """Return the worst current of each layer and the layers' thicknesses.

    Raises InputError when the mission lacks what a mooring needs, or has no layers and not one `design_current`, as
    with a current from a file.

    `means`: at the means.

    Returns
    -------
    speeds, thicknesses : array, shape (k,)
        The phase's `design_current`; by default each layer's mean + 2 sd [m/s, m].
    """
    site, design_speed = MooringMission.of(means.mission).site, phase.design_current
    depth = float(means.mooring.depth)
    if not isinstance(site.current, tuple) or not site.current:
        if design_speed is None or isinstance(design_speed, tuple):
            message = "missing; sizing the anchor needs one speed here where the site's current is not given in layers"
            raise InputError([Problem(message, means.mission.file, key=f"{phase.name}.design_current")])
        return np.array([design_speed]), np.array([depth])
    thicknesses = layer_thicknesses(np.array([mean_of(layer.down_to) for layer in site.current]), depth)
    if design_speed is None:
        speeds = [abs(mean_of(layer.speed)) + 2.0 * sd_of(layer.speed) for layer in site.current]
    else:
        speeds = list(design_speed) if isinstance(design_speed, tuple) else [design_speed] * len(site.current)
    return np.array(speeds, dtype=float), thicknesses


def worst_case_weight(means: DrawnMission, phase: MoorPhase[Scalars]) -> float:
    """Return the wet weight that takes the vehicle down within the radius in the worst current (Eqs. 1, 15).

    The layers' currents all flow the same way. Of a mission's explanations the one that needs the heaviest anchor is
    taken to hold, those of less than 5 % left out. Raises InputError when there is no current to size the anchor for;
    see also `design_current`.

    Parameters
    ----------
    means : DrawnMission
        At the means.

    Returns
    -------
    float
        Drag at the required terminal velocity with the mission's effects, and the vehicle's net buoyancy where the
        phase has `carry_net_buoyancy` [N].
    """
    return max(_weight_at(explained, phase) for explained in means.under_explanations())


def _weight_at(means: DrawnMission, phase: MoorPhase[Scalars]) -> float:
    needed = means.mooring
    speeds, thicknesses = design_current(means, phase)
    over_ground = float(required_terminal_velocity(speeds, thicknesses, phase.radius))
    steady = SteadyDescent.at(
        over_ground, DescentHooks(means.descent_effects), float(needed.depth), float(phase.line_length)
    )
    law = anchor_drag(needed.anchor.diameter, needed.anchor.drag_coefficient, means.water.density)
    weight = float(steady.wet_weight(means.vehicle_drag(steady.through_water) + law(steady.through_water)))
    weight += float(needed.vehicle.net_buoyancy) if phase.carry_net_buoyancy else 0.0
    if weight <= 0.0:
        raise InputError([Problem("no current to size the anchor for", key=f"{phase.name}.anchor_wet_weight")])
    return weight


def wet_weight_of(drawn: DrawnMission, phase: MoorPhase[Scalars]) -> Scalars:
    """Return the wet weight of the anchor: the mission's, or where it is `sized` the worst case's [N].

    A spare one like it, which is aboard in the dive, changes the drag and so the weight: both are found together.
    """
    wet_weight = phase.anchor_wet_weight
    if not isinstance(wet_weight, str):
        return wet_weight
    means = drawn.means
    mooring = means.moor(phase.name)
    if all(moor.name != phase.name for moor in _aboard(means, phase)):
        return worst_case_weight(laden(means, phase), mooring)
    weight, before = worst_case_weight(means, mooring), 0.0
    while not math.isclose(weight, before, rel_tol=1e-12):
        weight, before = worst_case_weight(laden(means, phase, weight), mooring), weight
    return weight


def anchor_problem(means: DrawnMission) -> AnchorProblem:
    """Return geometry and materials of the mission's anchor, at their means.

    Raises InputError where the mission gives the anchor no construction.
    """
    vehicle, anchor = means.mooring.vehicle, means.mooring.anchor
    parts = required(anchor.construction, means.mission, "vehicle.anchor.construction", "the anchor is built from it")
    return AnchorProblem(
        radius=float(anchor.diameter) / 2.0,
        overlap_volume=float(anchor.overlap_volume),
        nose_radius=float(vehicle.hull.diameter) / 2.0,
        water_density=float(means.water.density),
        construction=Construction(
            front=Part(float(parts.front.mass), float(parts.front.density), float(parts.front.centre)),
            back=Part(float(parts.back.mass), float(parts.back.density), float(parts.back.centre_from_back)),
            tube_mass_per_length=float(parts.tube.mass_per_length),
            tube_density=float(parts.tube.density),
            trim_density=float(parts.trim.density),
        ),
    )


def anchor_length(drawn: DrawnMission, weight: Scalars) -> Scalars:
    """Return the anchor's length from its tip to the tube's end [m].

    Of the anchor built for a wet weight [N] where the mission gives its construction; else of a round front and a tube
    of its diameter that displace the dry mass (Eqs. 16 and 17) which its flooded mass and wet weight leave.
    """
    anchor = drawn.mooring.anchor
    if anchor.construction is not None:
        problem = anchor_problem(drawn.means)
        return problem.radius + cylinder_and_trim(problem, weight)[0]
    radius = anchor.diameter / 2.0
    volume = (anchor_flooded_mass(drawn, weight) - weight / STANDARD_GRAVITY) / drawn.water.density
    tube = (volume + anchor.overlap_volume) / (np.pi * radius**2) - 2.0 / 3.0 * radius
    return radius + np.maximum(tube, 0.0)


def anchor_flooded_mass(drawn: DrawnMission, weight: Scalars) -> Scalars:
    """Return the mass of an anchor of a wet weight [N], with the water inside, without added mass [kg].

    The vehicle file's, else that of the anchor built for the weight. Studies try weights that the mass in the file
    could not have, whatever it is made of: then it is that of lead of this weight.
    """
    mass = drawn.mooring.anchor.flooded_mass
    if mass is None:
        return flooded_mass(dry_mass(anchor_problem(drawn.means), weight), weight)
    return np.maximum(mass, lead_mass(weight, drawn.water.density))
