"""A slender body that hangs by its nose on a line."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.physics.vehicle_drag import DragLaw

CROSSFLOW_COEFFICIENT = 1.1
"""C_d of a long round body across the flow, on length × diameter, below the drag crisis (Hoerner 1965, ch. III)."""
_SECTIONS = 10
"""Of the body, each with the current at its middle."""


@dataclass(frozen=True)
class HeldBody:
    """A slender body held by its nose; each number is a float or an array over trials, shape (n,).

    Attributes
    ----------
    length, diameter : float or array
        [m].
    net_buoyancy : float or array
        Buoyancy minus weight [N].
    raising_moment : float or array
        About the nose with the body level, buoyancy's minus weight's; positive raises the tail [N m].
    righting_moment : float or array
        About the nose with the body upright, of centres off the axis; its size counts, as the body rolls freely [N m].
    crossflow_coefficient : float or array
        C_d on length × diameter.
    axial_drag : DragLaw
        Drag along the axis.
    density : float or array
        Of the water [kg/m³].
    """

    length: Scalars
    diameter: Scalars
    net_buoyancy: Scalars
    raising_moment: Scalars
    righting_moment: Scalars
    crossflow_coefficient: Scalars
    axial_drag: DragLaw
    density: Scalars

    @property
    def section_drag(self) -> Scalars:
        """Drag of a section of the body across the flow over the speed squared [kg/m]."""
        return 0.5 * self.density * self.crossflow_coefficient * self.diameter * self.length / _SECTIONS

    @property
    def sections(self) -> Array:
        """Middles of the body's sections from its nose, shape (m, 1) or (m, n) [m]."""
        middles = (np.arange(_SECTIONS) + 0.5) / _SECTIONS
        return np.asarray(middles[:, None] * self.length)
