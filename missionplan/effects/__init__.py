"""The catalogue of effects: each with its data class and its entry, by what they act on.

Read first `info` (what an entry holds) and any effect, then `catalogue`. `oscillation` is shared by the currents.
"""

from missionplan.effects.catalogue import (
    CATALOGUE,
    FAILED_PLUGINS,
    ORIGINS,
    effects_of,
    exclusive_groups,
    instruments,
    named_effects,
    scattering_effect,
)
from missionplan.effects.info import Effect, EffectInfo, Parameter, TankEffect

__all__ = [
    "CATALOGUE",
    "FAILED_PLUGINS",
    "ORIGINS",
    "Effect",
    "EffectInfo",
    "Parameter",
    "TankEffect",
    "effects_of",
    "exclusive_groups",
    "instruments",
    "named_effects",
    "scattering_effect",
]
