"""Drag of a vehicle by a coefficient measured in a tank, in place of the build-up of Briggs et al."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.physics.drag import REYNOLDS_HELD, drag_force, reynolds_number
from missionplan.physics.tank import reynolds_drag_coefficient
from missionplan.physics.vehicle_drag import VehicleDrag


@dataclass(frozen=True)
class MeasuredVehicleDrag(VehicleDrag):
    """Drag of the whole vehicle, sail and appendages included, from one coefficient.

    Attributes
    ----------
    coefficient : float or array, shape (n,)
        C_D on `area`, at `at_reynolds` where it varies.
    area : float
        Reference area [m²].
    exponent : float or array, shape (n,)
        p of C_D ∝ Re^p; 0 for a constant coefficient.
    at_reynolds, reference_length : float
        Reynolds number of the coefficient, and its reference length [m].
    """

    coefficient: Scalars = 0.0
    area: float = 0.0
    exponent: Scalars = 0.0
    at_reynolds: float = 1e5
    reference_length: float = 1.0

    def body(self, speed: Scalars) -> Scalars:
        """Drag of the whole vehicle [N]; the coefficient is constant below `REYNOLDS_HELD`."""
        reynolds = reynolds_number(speed, self.reference_length, self.water.viscosity)
        held = np.maximum(reynolds, REYNOLDS_HELD)
        coefficient = reynolds_drag_coefficient(held, self.coefficient, self.exponent, self.at_reynolds)
        return drag_force(speed, coefficient, self.area, self.water.density)

    def sail_drag(self, speed: Scalars) -> Scalars:
        """Zero: the body's drag includes it [N]."""
        return 0.0 * speed

    def __call__(self, speed: Scalars) -> Scalars:
        """Drag [N] at a speed [m/s]."""
        return self.body(speed)
