"""The catalogue of effects: one small file an effect."""

from missionplan.effects.catalogue import CATALOGUE, effects_of
from missionplan.effects.info import Effect, EffectInfo, Parameter, TankEffect

__all__ = ["CATALOGUE", "Effect", "EffectInfo", "Parameter", "TankEffect", "effects_of"]
