"""Drag of a vehicle as the tank measured it, where Briggs's build-up would stand."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.physics.drag import REYNOLDS_HELD, drag_force, reynolds_number
from missionplan.physics.tank import reynolds_drag_coefficient
from missionplan.physics.vehicle_drag import VehicleDrag


@dataclass(frozen=True)
class MeasuredVehicleDrag(VehicleDrag):
    """The whole vehicle's drag from one coefficient; its sail and appendages are in it.

    Attributes
    ----------
    coefficient : float or array, shape (n,)
        C_D on `area`, at `at_reynolds` where it varies.
    area : float
        Reference area [m²].
    exponent : float or array, shape (n,)
        p of C_D ∝ Re^p; 0 for a constant coefficient.
    at_reynolds, reference_length : float
        Where the coefficient holds, and the length of the Reynolds number [m].
    """

    coefficient: Scalars = 0.0
    area: float = 0.0
    exponent: Scalars = 0.0
    at_reynolds: float = 1e5
    reference_length: float = 1.0

    def body(self, speed: Scalars) -> Scalars:
        """Drag of the whole vehicle [N]; below `REYNOLDS_HELD` the coefficient keeps its value there."""
        reynolds = reynolds_number(speed, self.reference_length, self.water.viscosity)
        held = np.maximum(reynolds, REYNOLDS_HELD)
        coefficient = reynolds_drag_coefficient(held, self.coefficient, self.exponent, self.at_reynolds)
        return drag_force(speed, coefficient, self.area, self.water.density)

    def sail_drag(self, speed: Scalars) -> Scalars:
        """None of its own."""
        return 0.0 * speed

    def __call__(self, speed: Scalars) -> Scalars:
        """Drag [N] at a speed [m/s]."""
        return self.body(speed)
