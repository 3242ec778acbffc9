"""Weights and displaced masses of submerged bodies."""

from missionplan.arrays import Scalars

STANDARD_GRAVITY = 9.80665
"""g [m/s²], the conventional value."""
LEAD_DENSITY = 11_340.0
"""Of lead, the densest that anchors are made of [kg/m³]."""


def wet_weight(mass: Scalars, material_density: Scalars, water_density: Scalars) -> Scalars:
    """Weight of a solid in water, m (1 - ρ/ρ_i) g [N], from its mass [kg] and the two densities [kg/m³]."""
    return mass * (1.0 - water_density / material_density) * STANDARD_GRAVITY


def lead_mass(weight: Scalars, water_density: Scalars) -> Scalars:
    """Mass of lead of a wet weight W [N] in water of a density ρ [kg/m³], W/g(1 - ρ/ρ_lead) [kg]."""
    return weight / wet_weight(1.0, LEAD_DENSITY, water_density)


def displaced_mass(mass: Scalars, net_buoyancy: Scalars) -> Scalars:
    """Mass of the water that a body displaces, m + B_net/g [kg], from its mass [kg] and net buoyancy [N]."""
    return mass + net_buoyancy / STANDARD_GRAVITY


def flooded_mass(dry_mass: Scalars, weight_in_water: Scalars) -> Scalars:
    """Mass of a neutrally trimmed anchor once it is flooded.

    Attached, the sealed anchor displaces its own mass of water (Eqs. 16–17): ρ∇ = m_dry. Flooded, the water inside has
    mass ρ(∇ - Σ m_i/ρ_i), and with the wet weight W = (m_dry - ρ Σ m_i/ρ_i) g the sum is m_dry + W/g.

    Parameters
    ----------
    dry_mass : float or array
        Of the unflooded anchor [kg].
    weight_in_water : float or array
        Wet weight of the flooded anchor [N].

    Returns
    -------
    float or array
        Mass with the water inside, without added mass [kg].
    """
    return dry_mass + weight_in_water / STANDARD_GRAVITY
