"""The anchor that a vehicle carries as its false nose, until its first mooring."""

import itertools
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Scalars
from missionplan.errors import InputError
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.views import missing_for_moorings
from missionplan.physics.anchor import cap_height
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.measured_drag import MeasuredVehicleDrag
from missionplan.physics.vehicle_drag import VehicleDrag
from missionplan.scenario.anchor_weight import anchor_flooded_mass, anchor_length, wet_weight_of
from missionplan.scenario.drawn_mission import DrawnMission


@dataclass(frozen=True)
class CarriedAnchor:
    """What the anchor adds to the vehicle while it is attached, sealed and neutral (Briggs et al., Eq. 17).

    Attributes
    ----------
    length : float or array, shape (n,)
        By which it lengthens the hull [m].
    mass : float or array, shape (n,)
        Dry [kg].
    """

    length: Scalars
    mass: Scalars

    def lengthened(self, drag: VehicleDrag) -> VehicleDrag:
        """Drag of the vehicle with the anchor on its nose; one that was measured in a tank stays as it is."""
        if isinstance(drag, MeasuredVehicleDrag):
            return drag
        return replace(drag, hull=replace(drag.hull, length=drag.hull.length + self.length))


def carried_anchor(drawn: DrawnMission, phase: TransitPhase[Scalars]) -> CarriedAnchor | None:
    """Return the anchor that a transit carries; None after the first mooring, and where the mission gives no anchor."""
    moors = drawn.drawn.moors
    before = itertools.takewhile(lambda other: not isinstance(other, MoorPhase), drawn.mission.phases)
    if not moors or phase.name not in [other.name for other in before] or missing_for_moorings(drawn.mission):
        return None
    try:
        weight = wet_weight_of(drawn, moors[0])
        length = anchor_length(drawn, weight)
        mass = anchor_flooded_mass(drawn, weight) - weight / STANDARD_GRAVITY
    except (InputError, ValueError):
        return None  # said by who sizes the anchor: a study of the transits alone needs none
    return CarriedAnchor(np.maximum(length - overlap_height(drawn.means), 0.0), np.maximum(mass, 0.0))


def overlap_height(means: DrawnMission) -> float:
    """How far the vehicle's nose reaches into the anchor [m]."""
    needed = means.mooring
    return cap_height(float(needed.anchor.overlap_volume), float(needed.vehicle.hull.diameter) / 2.0)
