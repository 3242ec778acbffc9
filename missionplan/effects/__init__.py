"""The catalogue of effects: one small file an effect."""

from missionplan.effects.catalogue import CATALOGUE, effects_of
from missionplan.effects.info import EffectInfo, Parameter

__all__ = ["CATALOGUE", "EffectInfo", "Parameter", "effects_of"]
