"""What lines are made of: density, filling of the circle, stiffness and strength, each of the diameter squared.

Densities: *Synthetic fibre yarn properties*, Tension Technology International; of steel 7850 kg/m³. Quasi-static
stiffness and strength of ropes: the default coefficients of MoorPy (Hall et al., NREL, doi:10.11578/dc.20210726.1),
fitted to makers' catalogues of thicker ropes; aramid's from its yarn (49 and 2.0 N/tex), of which a rope has half the
stiffness and a third of the strength.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.physics.buoyancy import STANDARD_GRAVITY


@dataclass(frozen=True)
class LineMaterial:
    """A material of lines.

    Attributes
    ----------
    density : float
        Of the material [kg/m³].
    filling : float
        Share of the line's circle that it fills. Of a fibre line all of it, the most that a tight cord of this
        diameter weighs; laid and plaited ropes fill 0.63 to 0.75, and `line_wet_weight` states what was weighed.
    stiffness : float
        EA over the diameter squared [Pa].
    strength : float
        Breaking load over the diameter squared [Pa].
    """

    density: float
    filling: float
    stiffness: float
    strength: float

    def wet_weight(self, diameter: Scalars, water_density: Scalars) -> Scalars:
        """Weight in water of a metre, negative where it floats [N/m]."""
        area = 0.25 * math.pi * self.filling * diameter * diameter
        return (self.density - water_density) * area * STANDARD_GRAVITY


LINE_MATERIALS: Mapping[str, LineMaterial] = {
    "polyester": LineMaterial(1380.0, 1.0, 4.31e9, 3.08e8),
    "nylon": LineMaterial(1140.0, 1.0, 1.04e9, 2.07e8),
    "aramid": LineMaterial(1440.0, 1.0, 2.0e10, 5.5e8),
    "polyethylene": LineMaterial(970.0, 1.0, 3.25e10, 5.8e8),
    "steel-wire": LineMaterial(7850.0, 0.65, 9.71e10, 1.02e9),
}
"""By the word of `line_material`. Polyethylene is that of high modulus (Dyneema, Spectra); a wire rope with a wire core
fills 0.65 of its circle."""
