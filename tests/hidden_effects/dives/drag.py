"""Drag and masses of the vehicle and its anchor from Briggs et al., Eqs. 2-14, for one speed at a time."""

import math
from dataclasses import dataclass

GRAVITY = 9.80665
"""Standard gravity [m/s²]."""


@dataclass(frozen=True)
class Craft:
    """Vehicle, anchor and water as in the base mission (SI)."""

    length: float
    diameter: float
    form_factor: str | float
    sail: tuple[float, float, float] | None
    """Chord, span, thickness."""
    appendage_factor: float
    mass: float
    net_buoyancy: float
    anchor_diameter: float
    anchor_drag_coefficient: float
    anchor_flooded_mass: float
    density: float
    viscosity: float

    @property
    def vehicle_mass(self) -> float:
        """Mass with the spheroid's added mass, a fraction of the displaced mass [kg]."""
        displaced = self.mass + self.net_buoyancy / GRAVITY
        return self.mass + spheroid_share(self.length / self.diameter) * displaced

    @property
    def anchor_mass(self) -> float:
        """Flooded mass with the added mass of half a sphere and half a disc, 2.38 ρ r³ [kg]."""
        return self.anchor_flooded_mass + 2.38 * self.density * (self.anchor_diameter / 2.0) ** 3

    def anchor_drag(self, speed: float) -> float:
        """Drag of the anchor, Eq. 2 [N]."""
        area = math.pi * self.anchor_diameter**2 / 4.0
        return 0.5 * self.density * speed * abs(speed) * area * self.anchor_drag_coefficient

    def vehicle_drag(self, speed: float) -> float:
        """Drag of the vehicle, Eqs. 3-13 [N]."""
        pressure = 0.5 * self.density * speed * abs(speed)
        ratio = self.diameter / self.length
        first = {"briggs": 2.643, "hoerner": 1.0}
        constant = first[self.form_factor] if isinstance(self.form_factor, str) else self.form_factor
        form = constant + 1.5 * ratio**1.5 + 7.0 * ratio**3
        wetted = math.pi * self.diameter**2 / 4.0 * 4.0 / ratio
        body = pressure * wetted * form * friction(abs(speed) * self.length / self.viscosity)
        fin = 0.0
        if self.sail is not None:
            chord, span, thickness = self.sail
            slim = thickness / chord
            c_d = 2.0 * (1.0 + 2.0 * slim + 60.0 * slim**4) * friction(abs(speed) * chord / self.viscosity)
            fin = pressure * chord * span * c_d
        return self.appendage_factor * (body + fin)

    def drag(self, speed: float) -> float:
        """Drag of both bodies, Eq. 14 [N]."""
        return self.vehicle_drag(speed) + self.anchor_drag(speed)

    def terminal_speed(self, wet_weight: float) -> float:
        """Speed at which drag and the vehicle's net buoyancy balance the wet weight, by bisection [m/s]."""
        low, high = 0.0, 20.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.drag(middle) < wet_weight - self.net_buoyancy else (low, middle)
        return 0.5 * (low + high)


def friction(reynolds: float) -> float:
    """ITTC-57 line, constant below Re = 10⁴ (it is singular at Re = 100)."""
    return 0.075 / (math.log10(max(reynolds, 1e4)) - 2.0) ** 2


def spheroid_share(fineness: float) -> float:
    """Lamb's k₁: axial added mass of a prolate spheroid over its displaced mass."""
    e = math.sqrt(1.0 - 1.0 / fineness**2)
    alpha = 2.0 * (1.0 - e * e) / e**3 * (math.atanh(e) - e)
    return alpha / (2.0 - alpha)
