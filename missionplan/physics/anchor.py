"""Design of an anchor that is heavy enough flooded, neutral and in trim when attached (Briggs et al., Eqs. 15–17).

Positions are measured from the anchor's tip, aft positive: a hemisphere of radius r, then a tube of length C, in whose
end the vehicle's hemispherical nose sits.

Terminal velocity required of the descent (Briggs et al., Eq. 1).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.physics.water import STANDARD_GRAVITY


@dataclass(frozen=True)
class Part:
    """A solid part: mass [kg], density of its material [kg/m³], and its centre [m] from the tip or from the back."""

    mass: float
    density: float
    centre: float


@dataclass(frozen=True)
class Construction:
    """Parts of the anchor, before its length and trim ring are known."""

    front: Part
    """Its centre from the tip."""
    back: Part
    """Its centre forward of the tube's end."""
    tube_mass_per_length: float
    tube_density: float
    """λ [kg/m] and material [kg/m³] of the tube."""
    trim_density: float
    """Of the ring's material [kg/m³]."""


@dataclass(frozen=True)
class AnchorProblem:
    """Requirements of an anchor."""

    radius: float
    """r of hemisphere and tube [m]."""
    overlap_volume: float
    """V_lost, of the vehicle's nose inside the anchor [m³]."""
    nose_radius: float
    """Of the vehicle's hemispherical nose [m]."""
    water_density: float
    """ρ [kg/m³]."""
    construction: Construction


@dataclass(frozen=True)
class UnmetCondition:
    """A condition that the anchor does not meet: which, by how much [kg or m], and what it means."""

    condition: str
    amount: float
    words: str


@dataclass(frozen=True)
class AnchorDesign:
    """The anchor that satisfies the two mass equations and the trim, feasible or not."""

    problem: AnchorProblem
    wet_weight: float
    """W [N]."""
    cylinder_length: float
    """C [m]."""
    trim_mass: float
    trim_position: float
    """Of the ring [kg], and its centre from the tip [m] (nan when the ring's mass is 0)."""
    dry_mass: float
    displaced_mass: float
    """Both sides of Eq. 17 [kg]."""
    centre_of_gravity: float
    centre_of_buoyancy: float
    """Of the unflooded anchor and of the added displacement, from the tip [m]."""
    failures: tuple[UnmetCondition, ...] = ()
    """Conditions not met; empty when the anchor can be built."""

    @property
    def feasible(self) -> bool:
        """Whether the anchor can be built."""
        return not self.failures

    @property
    def length(self) -> float:
        """From the tip to the tube's end, r + C [m]."""
        return self.problem.radius + self.cylinder_length

    @property
    def flooded_mass(self) -> float:
        """With the water inside [kg]."""
        return self.dry_mass + self.wet_weight / STANDARD_GRAVITY


def cap_height(volume: float, radius: float) -> float:
    """Height h [m] of a spherical cap of a volume π h²(3R - h)/3 [m³], from the sphere's radius R [m].

    Raises ValueError when the volume is more than half the sphere, the volume of the nose.
    """
    half = 2.0 / 3.0 * math.pi * radius**3
    if not 0.0 <= volume <= half * (1.0 + 1e-12):
        raise ValueError(f"the nose holds at most {half:.3g} m³, the overlap is {volume:.3g} m³")
    # h³ - 3R h² + 3V/π = 0 by the trigonometric solution of the cubic; its middle root is the cap's.
    cosine = 1.0 - 1.5 * volume / (math.pi * radius**3)
    return max(0.0, radius * (1.0 - 2.0 * math.cos((math.acos(max(-1.0, min(1.0, cosine))) + math.pi) / 3.0)))


def cap_centroid(height: float, radius: float) -> float:
    """Centroid of a spherical cap, from its tip: R - 3(2R - h)²/(4(3R - h)) [m], with height h and radius R [m]."""
    return radius - 3.0 * (2.0 * radius - height) ** 2 / (4.0 * (3.0 * radius - height))


def added_displacement(problem: AnchorProblem, cylinder_length: Scalars) -> Scalars:
    """∇_anchor = ⅔πr³ + Cπr² - V_lost [m³] (Eq. 16)."""
    r = problem.radius
    return 2.0 / 3.0 * math.pi * r**3 + cylinder_length * math.pi * r**2 - problem.overlap_volume


def displacement_centroid(problem: AnchorProblem, cylinder_length: float) -> float:
    """Centroid of the added displacement, from the tip [m]; the overlap is a cap of the vehicle's nose."""
    r, c = problem.radius, cylinder_length
    height = cap_height(problem.overlap_volume, problem.nose_radius)
    overlap_at = r + c - height + cap_centroid(height, problem.nose_radius)
    moment = 2.0 / 3.0 * math.pi * r**3 * (5.0 / 8.0 * r) + math.pi * r**2 * c * (r + c / 2.0)
    moment -= problem.overlap_volume * overlap_at
    return float(moment / added_displacement(problem, c))


def cylinder_and_trim(problem: AnchorProblem, weight: Scalars) -> tuple[Scalars, Scalars]:
    """Tube length and ring mass from the two linear equations of an anchor.

    Dry (Eqs. 16–17, as masses: Eq. 17 lacks g): λC + m_t - ρπr²C = ρ(⅔πr³ - V_lost) - m_front - m_back.
    Wet (Eq. 15): Σ m_i (1 - ρ/ρ_i) g = W.

    Raises ValueError when the two equations are linearly dependent: tube and ring of these materials cannot meet both.

    Parameters
    ----------
    weight : float or array, shape (n,)
        Wet weight W [N].

    Returns
    -------
    cylinder_length, trim_mass : float or array, shape (n,)
        C [m] and m_t [kg], of either sign.
    """
    parts, rho, r = problem.construction, problem.water_density, problem.radius
    sunk_tube = parts.tube_mass_per_length * (1.0 - rho / parts.tube_density)
    sunk_trim = 1.0 - rho / parts.trim_density
    afloat = parts.tube_mass_per_length - rho * math.pi * r**2
    determinant = afloat * sunk_trim - sunk_tube
    if abs(determinant) <= 1e-12 * (abs(afloat * sunk_trim) + abs(sunk_tube)):
        raise ValueError("tube and trim ring enter the dry and the wet balance in the same ratio: no unique anchor")
    dry = rho * (2.0 / 3.0 * math.pi * r**3 - problem.overlap_volume) - parts.front.mass - parts.back.mass
    wet = weight / STANDARD_GRAVITY
    for part in (parts.front, parts.back):
        wet = wet - part.mass * (1.0 - rho / part.density)
    return (dry * sunk_trim - wet) / determinant, (afloat * wet - sunk_tube * dry) / determinant


def dry_mass(problem: AnchorProblem, weight: Scalars) -> Scalars:
    """Mass of the unflooded anchor of a wet weight [N], equal to the mass that it displaces attached [kg] (Eq. 17)."""
    length, _ = cylinder_and_trim(problem, weight)
    return problem.water_density * added_displacement(problem, length)


def solve_anchor(problem: AnchorProblem, weight: float) -> AnchorDesign:
    """Find the anchor of a wet weight: tube length, trim ring and the ring's place.

    Parameters
    ----------
    weight : float
        Wet weight W [N].

    Returns
    -------
    AnchorDesign
        With the conditions that it does not meet; `anchor_remedies.find_remedies` finds changes that would.
    """
    length, trim = (float(value) for value in cylinder_and_trim(problem, weight))
    parts, r = problem.construction, problem.radius
    masses = np.array([parts.front.mass, parts.tube_mass_per_length * length, parts.back.mass])
    centres = np.array([parts.front.centre, r + length / 2.0, r + length - parts.back.centre])
    displaced = problem.water_density * float(added_displacement(problem, length))
    centroid = displacement_centroid(problem, length) if displaced > 0.0 else math.nan
    mass = float(masses.sum()) + trim
    ring_at = (mass * centroid - float(masses @ centres)) / trim if trim != 0.0 else math.nan
    gravity = (float(masses @ centres) + (trim * ring_at if trim != 0.0 else 0.0)) / mass
    design = AnchorDesign(problem, weight, length, trim, ring_at, mass, displaced, gravity, centroid)
    return replace(design, failures=_failures(design))


def wet_centre(design: AnchorDesign) -> float:
    """Place at which the wet weight of the flooded anchor acts, from the tip [m]."""
    parts, end = design.problem.construction, design.length
    rho = design.problem.water_density
    tube = Part(
        parts.tube_mass_per_length * design.cylinder_length,
        parts.tube_density,
        design.problem.radius + design.cylinder_length / 2.0,
    )
    ring = Part(design.trim_mass, parts.trim_density, design.trim_position if design.trim_mass else 0.0)
    placed = (parts.front, tube, replace(parts.back, centre=end - parts.back.centre), ring)
    weights = [part.mass * (1.0 - rho / part.density) for part in placed]
    return sum(weight * part.centre for weight, part in zip(weights, placed, strict=True)) / sum(weights)


def _failures(design: AnchorDesign) -> tuple[UnmetCondition, ...]:
    r, end = design.problem.radius, design.length
    failures = []
    if design.cylinder_length <= 0.0:
        words = f"the tube would have a length of {design.cylinder_length * 1e3:.1f} mm"
        failures.append(UnmetCondition("cylinder_length > 0", -design.cylinder_length, words))
    if design.trim_mass < 0.0:
        words = f"the trim ring would weigh {design.trim_mass:.3f} kg: the other parts are already too heavy"
        failures.append(UnmetCondition("trim_mass >= 0", -design.trim_mass, words))
    if failures:
        return tuple(failures)
    if not math.isfinite(design.trim_position):
        offset = design.centre_of_gravity - design.centre_of_buoyancy
        words = f"without a ring, the centre of gravity lies {offset * 1e3:.1f} mm aft of the centre of buoyancy"
        return () if abs(offset) < 1e-4 else (UnmetCondition("centre_of_gravity = centre_of_buoyancy", offset, words),)
    ahead, behind = r - design.trim_position, design.trim_position - end
    if max(ahead, behind) > 0.0:
        side = (
            f"{ahead * 1e3:.1f} mm ahead of the tube" if ahead > 0.0 else f"{behind * 1e3:.1f} mm behind the tube's end"
        )
        words = f"the trim ring would have to sit {side}"
        failures.append(UnmetCondition("ring inside the tube", max(ahead, behind), words))
    return tuple(failures)


def layer_thicknesses(down_to: Array, depth: float) -> Array:
    """Thickness of each layer of the water column; the last one reaches the seafloor.

    Raises ValueError when there is no layer, or the edges do not increase.

    Parameters
    ----------
    down_to : array, shape (k,)
        Lower edge of each layer, from the surface down [m].
    depth : float
        Of the seafloor [m].

    Returns
    -------
    array, shape (k,)
        Thicknesses that add up to `depth`; 0 for a layer below the seafloor [m].
    """
    edges = np.concatenate(([0.0], np.asarray(down_to, dtype=float)))
    if edges.size < 2 or np.any(np.diff(edges) <= 0.0):
        raise ValueError("expected at least one layer, and lower edges that increase from the surface down")
    edges[-1] = max(edges[-1], depth)
    return np.diff(np.minimum(edges, depth))


def required_terminal_velocity(speeds: Array, thicknesses: Array, radius: Scalars) -> Scalars:
    """Terminal velocity that bounds the drift when the worst currents are aligned: Eq. 1 for any number of layers.

    It assumes terminal velocity from the start and neglects release and pay-out, so that the drift of a real dive may
    be larger.

    Parameters
    ----------
    speeds : array, shape (k,) or (k, n)
        Worst current of each layer [m/s].
    thicknesses : array, shape (k,)
        Of each layer, surface to seafloor [m].
    radius : float or array, shape (n,)
        Allowed drift R [m].

    Returns
    -------
    float or array, shape (n,)
        Σ |v_i| h_i / R [m/s].
    """
    return np.tensordot(thicknesses, np.abs(speeds), axes=(0, 0)) / radius


def required_terminal_velocity_vector(speeds: Array, toward: Array, thicknesses: Array, radius: Scalars) -> Scalars:
    """Terminal velocity that bounds the drift when each layer has its own direction.

    Parameters
    ----------
    speeds, toward : array, shape (k,) or (k, n)
        Current of each layer [m/s], and direction towards which it flows, clockwise from north [rad].
    thicknesses : array, shape (k,)
        [m].
    radius : float or array, shape (n,)
        Allowed drift R [m].

    Returns
    -------
    float or array, shape (n,)
        ‖Σ v_i h_i‖ / R [m/s]; never above `required_terminal_velocity`.
    """
    east = np.tensordot(thicknesses, speeds * np.sin(toward), axes=(0, 0))
    north = np.tensordot(thicknesses, speeds * np.cos(toward), axes=(0, 0))
    return np.hypot(east, north) / radius
