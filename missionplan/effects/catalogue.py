"""The catalogue: every effect by its stable name."""

from collections.abc import Mapping
from types import MappingProxyType

from missionplan.effects import (
    added_mass,
    axial_flow,
    broadside_start,
    clock_offset,
    compass_bias,
    compass_deviation,
    current_shear,
    depth_scale,
    drag_bias,
    drag_crisis,
    fix_error,
    heavy_tails,
    inertial_current,
    jet_suction,
    line_payout,
    mean_current,
    persistent_error,
    quadratic_damping,
    random_walk,
    reynolds_drag,
    sensor_lag,
    slow_flooding,
    speed_scale,
    stratification,
    surface_drift,
    thrust_asymmetry,
    tidal_current,
    trapped_gas,
    vertical_current,
)
from missionplan.effects.info import EffectInfo, Phase

_FILES = (
    drag_bias,
    line_payout,
    slow_flooding,
    trapped_gas,
    stratification,
    broadside_start,
    added_mass,
    sensor_lag,
    clock_offset,
    depth_scale,
    vertical_current,
    drag_crisis,
    mean_current,
    tidal_current,
    inertial_current,
    compass_bias,
    compass_deviation,
    speed_scale,
    surface_drift,
    persistent_error,
    random_walk,
    fix_error,
    heavy_tails,
    current_shear,
    reynolds_drag,
    quadratic_damping,
    jet_suction,
    thrust_asymmetry,
    axial_flow,
)

CATALOGUE: Mapping[str, EffectInfo] = MappingProxyType({file.INFO.id: file.INFO for file in _FILES})
"""Effects of the descent, then of the transit, then of the tank alone, by name."""


def effects_of(phase: Phase) -> tuple[EffectInfo, ...]:
    """Return the catalogue's effects on one phase, in its order."""
    return tuple(info for info in CATALOGUE.values() if info.phase == phase)
