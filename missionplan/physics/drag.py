"""Drag of hull, sail, anchor and vehicle by the methods of Briggs et al., section III (Eqs. 2–14), or by a tank's."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from missionplan.arrays import Scalars
from missionplan.physics import drag
from missionplan.physics.tank import reynolds_drag_coefficient
from missionplan.physics.water import Water

REYNOLDS_HELD = 1e4
"""Below it C_f is held constant: the ITTC line is singular at Re = 100, which every dive passes."""
REYNOLDS_TURBULENT = 5e5
"""Above it a smooth plate's boundary layer is turbulent, as the ITTC line assumes."""
REYNOLDS_HIGHEST = 1e10
"""Largest Reynolds number of ships, and of the data behind the ITTC line."""
FORM_CONSTANTS = {"briggs": 2.643, "hoerner": 1.0}
"""First term of Eq. 5: as printed (C_d = 0.431 at 1.6 m/s; a REMUS has 0.42), and for Hoerner's streamlined body."""
ANCHOR_FINENESS = (2.0, 10.0)
"""Fineness ratios for which Hoerner gives the blunt cylinder with a round front C_d = 0.2."""


def reynolds_number(speed: Scalars, length: Scalars, viscosity: Scalars) -> Scalars:
    """Reynolds number v l/ν (Eqs. 3, 9) of a speed [m/s], a length [m] and a kinematic viscosity [m²/s]."""
    return np.abs(speed) * length / viscosity


def friction_coefficient(reynolds: Scalars) -> Scalars:
    """Skin friction by the 1957 ITTC line, 0.075/(log₁₀ Re - 2)² (Eqs. 4, 10).

    Constant below `REYNOLDS_HELD`. The line is for turbulent flow, Re above about 5e5; between the two it overestimates
    the friction of a smooth body.

    Parameters
    ----------
    reynolds : float or array
        Re ≥ 0.

    Returns
    -------
    float or array
        C_f on the wetted area; 0.004298 at 1.504e6.
    """
    return 0.075 / (np.log10(np.maximum(reynolds, REYNOLDS_HELD)) - 2.0) ** 2


def form_factor(length: Scalars, diameter: Scalars, constant: Scalars = FORM_CONSTANTS["briggs"]) -> Scalars:
    """Drag of the body over that of a flat plate of its wetted area (Eq. 5).

    Parameters
    ----------
    length, diameter : float or array
        Of the body [m].
    constant : float or array
        First term: 2.643 as printed, found in no other source, or 1 after Hoerner (`FORM_CONSTANTS`).

    Returns
    -------
    float or array
        FF; 2.705 for the prototype.
    """
    ratio = diameter / length
    return constant + 1.5 * ratio**1.5 + 7.0 * ratio**3


def body_drag_coefficient(friction: Scalars, factor: Scalars, length: Scalars, diameter: Scalars) -> Scalars:
    """C_d of the body on its frontal area, C_f · 4l/d · FF (Eqs. 6–7), for a cylinder with hemispherical ends."""
    return friction * (4.0 * length / diameter) * factor


def sail_drag_coefficient(friction: Scalars, chord: Scalars, thickness: Scalars) -> Scalars:
    """C_d of the sail on chord × span, 2[1 + 2 t/c + 60 (t/c)⁴] C_f (Eq. 11), from Hoerner's airfoil sections."""
    ratio = thickness / chord
    return 2.0 * (1.0 + 2.0 * ratio + 60.0 * ratio**4) * friction


def drag_force(speed: Scalars, coefficient: Scalars, area: Scalars, density: Scalars) -> Scalars:
    """Drag ½ ρ v|v| A C_d [N] (Eqs. 2, 8, 12), with the sign of the speed.

    Parameters
    ----------
    speed : float or array
        Through the water [m/s].
    coefficient : float or array
        C_d on `area`.
    area : float or array
        Reference area [m²].
    density : float or array
        ρ [kg/m³].
    """
    return 0.5 * density * area * coefficient * speed * np.abs(speed)


def disc_area(diameter: Scalars) -> Scalars:
    """Area π d²/4 [m²] of a disc of a diameter [m]: a body of revolution from the front, a propeller, a tunnel."""
    return np.pi * diameter**2 / 4.0


class DragLaw(Protocol):
    """Drag against speed through the water, with the speed's sign."""

    def __call__(self, speed: Scalars) -> Scalars:
        """Drag [N] at a speed [m/s]."""
        ...


@dataclass(frozen=True)
class QuadraticDrag:
    """Drag with a constant coefficient, k v|v|: the anchor's, and that of descents in closed form."""

    factor: Scalars
    """k = ½ ρ A C_d, float or shape (n,) [N s²/m²]."""

    def __call__(self, speed: Scalars) -> Scalars:
        """Drag [N] at a speed [m/s]."""
        return self.factor * speed * np.abs(speed)


@dataclass(frozen=True)
class Hull:
    """A cylinder with hemispherical ends."""

    length: Scalars
    diameter: Scalars
    """Shape (n,). [m]."""
    form_constant: Scalars = drag.FORM_CONSTANTS["briggs"]
    """First term of Eq. 5; float or shape (n,)."""


@dataclass(frozen=True)
class Sail:
    """An airfoil across the flow: chord, span and thickness, each a float or an array of shape (n,) [m]."""

    chord: Scalars
    span: Scalars
    thickness: Scalars


@dataclass(frozen=True)
class DragBuildUp:
    """Contributions to the drag at one speed [N]."""

    body: Scalars
    sail: Scalars
    """Eqs. 8 and 12, before the appendage factor."""
    vehicle: Scalars
    """Eq. 13: the sum of both times the appendage factor."""
    anchor: Scalars
    total: Scalars
    """Eqs. 2 and 14."""


@dataclass(frozen=True)
class VehicleDrag:
    """Drag of the egress vehicle along its axis (Eqs. 3–13).

    A call evaluates the sum with one logarithm; `body` and `sail_drag` are the equations as printed and agree with it
    to rounding.
    """

    hull: Hull
    sail: Sail | None
    appendage_factor: Scalars
    """Eq. 13: 1.25 for fins and transducer; float or shape (n,)."""
    water: Water

    def body(self, speed: Scalars) -> Scalars:
        """Body's drag, Eq. 8 [N]."""
        hull, water = self.hull, self.water
        friction = drag.friction_coefficient(drag.reynolds_number(speed, hull.length, water.viscosity))
        factor = drag.form_factor(hull.length, hull.diameter, hull.form_constant)
        coefficient = drag.body_drag_coefficient(friction, factor, hull.length, hull.diameter)
        return drag.drag_force(speed, coefficient, drag.disc_area(hull.diameter), water.density)

    def sail_drag(self, speed: Scalars) -> Scalars:
        """Sail's drag, Eq. 12 [N]; 0 without a sail."""
        sail, water = self.sail, self.water
        if sail is None:
            return 0.0 * speed
        friction = drag.friction_coefficient(drag.reynolds_number(speed, sail.chord, water.viscosity))
        coefficient = drag.sail_drag_coefficient(friction, sail.chord, sail.thickness)
        return drag.drag_force(speed, coefficient, sail.chord * sail.span, water.density)

    def build_up(self, speed: Scalars, anchor: DragLaw) -> DragBuildUp:
        """Contributions to the drag at a speed [m/s], the anchor's included."""
        body, sail, lone = self.body(speed), self.sail_drag(speed), anchor(speed)
        vehicle = (body + sail) * self.appendage_factor
        return DragBuildUp(body, sail, vehicle, lone, vehicle + lone)

    def __call__(self, speed: Scalars) -> Scalars:
        """Drag of the vehicle, Eq. 13 [N], at a speed [m/s]."""
        magnitude = np.abs(speed)
        log_speed = np.log(np.maximum(magnitude, _SLOWEST))
        parts = [scale / np.square(np.maximum(log_speed + shift, _LOG_HELD)) for scale, shift in self._terms]
        return sum(parts[1:], start=parts[0]) * speed * magnitude

    @cached_property
    def _terms(self) -> tuple[tuple[Scalars, Scalars], ...]:
        """For body and sail, k and b of the drag k v|v| / max(ln v + b, ln 100)², where ln v + b = ln(Re/100)."""
        hull, sail, water = self.hull, self.sail, self.water
        scale = 0.5 * water.density * self.appendage_factor * 0.075 * math.log(10.0) ** 2
        factor = drag.form_factor(hull.length, hull.diameter, hull.form_constant)
        area = drag.disc_area(hull.diameter) * drag.body_drag_coefficient(1.0, factor, hull.length, hull.diameter)
        terms = [(scale * area, np.log(hull.length / (100.0 * water.viscosity)))]
        if sail is not None:
            area = sail.chord * sail.span * drag.sail_drag_coefficient(1.0, sail.chord, sail.thickness)
            terms.append((scale * area, np.log(sail.chord / (100.0 * water.viscosity))))
        return tuple(terms)


_LOG_HELD = math.log(drag.REYNOLDS_HELD / 100.0)
_SLOWEST = 1e-12
"""Speed that keeps the logarithm finite at rest, where C_f is constant anyway [m/s]."""


def anchor_drag(diameter: Scalars, coefficient: Scalars, density: Scalars) -> QuadraticDrag:
    """Drag law of the anchor (Eq. 2) from its diameter [m], C_d on the frontal area and the water's density [kg/m³]."""
    return QuadraticDrag(0.5 * density * drag.disc_area(diameter) * coefficient)


def terminal_velocity(law: DragLaw, weight: Scalars, *, start: float = 1.0) -> Scalars:
    """Speed at which a drag law balances a weight.

    Fixed-point iteration v ← v √(W/F(v)). Drag here grows as v^p with 1.56 ≤ p ≤ 2, so that each step reduces the error
    of log v to 0.22 of the last or less; 30 steps reach rounding.

    Parameters
    ----------
    law : DragLaw
        Drag [N] of a speed [m/s].
    weight : float or array, shape (n,)
        Net downward force [N].
    start : float
        First guess [m/s].

    Returns
    -------
    float or array, shape (n,)
        [m/s]; 0 where the force is not downward.
    """
    pull = np.maximum(weight, 0.0)
    v = np.full(np.shape(law(start) + pull), start)
    for _ in range(30):
        v = np.maximum(v * np.sqrt(pull / law(v)), _SLOWEST)
    result = np.where(pull > 0.0, v, 0.0)
    return result if result.ndim else float(result)


def range_notes(law: VehicleDrag, speed: float, anchor_fineness: float | None = None) -> tuple[str, ...]:
    """Describe where a drag estimate is outside the range of its formulae.

    Parameters
    ----------
    law : VehicleDrag
        With floats for parameters.
    speed : float
        Through the water [m/s].
    anchor_fineness : float, optional
        Length over diameter of the anchor, when it is known.

    Returns
    -------
    tuple of str
        One sentence each; empty when the estimate is within range.
    """
    notes = []
    parts = [("hull", law.hull.length)] + ([("sail", law.sail.chord)] if law.sail is not None else [])
    for name, length in parts:
        reynolds = float(drag.reynolds_number(speed, length, law.water.viscosity))
        if reynolds < drag.REYNOLDS_TURBULENT:
            notes.append(
                f"The {name}'s Reynolds number is {_rounded(reynolds)} at {speed:.2f} m/s: below "
                f"{_rounded(drag.REYNOLDS_TURBULENT)} the flow may be laminar and the turbulent ITTC line too high."
            )
        if reynolds > drag.REYNOLDS_HIGHEST:
            notes.append(f"The {name}'s Reynolds number {_rounded(reynolds)} is beyond the ITTC line's experience.")
    low, high = drag.ANCHOR_FINENESS
    if anchor_fineness is not None and not low <= anchor_fineness <= high:
        notes.append(
            f"The anchor's fineness ratio is {anchor_fineness:.2f}: its drag coefficient of 0.2 is given for "
            f"{low:g} to {high:g}."
        )
    return tuple(notes)


def _rounded(value: float) -> str:
    """Two significant digits, with thousands separated: 140 000."""
    digits = 1 - math.floor(math.log10(max(value, 1.0)))
    return f"{round(value, digits):,.0f}".replace(",", "\u202f")


@dataclass(frozen=True)
class MeasuredVehicleDrag(VehicleDrag):
    """Drag of the whole vehicle, sail and appendages included, from one coefficient."""

    coefficient: Scalars = 0.0
    """C_D on `area`, at `at_reynolds` where it varies, float or shape (n,)."""
    area: float = 0.0
    """Reference area [m²]."""
    exponent: Scalars = 0.0
    """p of C_D ∝ Re^p; 0 for a constant coefficient; float or shape (n,)."""
    at_reynolds: float = 1e5
    reference_length: float = 1.0
    """Reynolds number of the coefficient, and its reference length [m]."""

    def body(self, speed: Scalars) -> Scalars:
        """Drag of the whole vehicle [N]; the coefficient is constant below `REYNOLDS_HELD`."""
        reynolds = reynolds_number(speed, self.reference_length, self.water.viscosity)
        reynolds_used = np.maximum(reynolds, REYNOLDS_HELD)
        coefficient = reynolds_drag_coefficient(reynolds_used, self.coefficient, self.exponent, self.at_reynolds)
        return drag_force(speed, coefficient, self.area, self.water.density)

    def sail_drag(self, speed: Scalars) -> Scalars:
        """Zero: the body's drag includes it [N]."""
        return 0.0 * speed

    def __call__(self, speed: Scalars) -> Scalars:
        """Drag [N] at a speed [m/s]."""
        return self.body(speed)
