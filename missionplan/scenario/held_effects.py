"""Effects of an explanation, which act in the trials in which it holds."""

from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.effects import Effect
from missionplan.phases.hooks import DescentEffect, TransitEffect
from missionplan.phases.mooring.subset_effect import SubsetEffect
from missionplan.phases.transit.held_effect import HeldEffect


def where_held(effect: Effect, held: NDArray[np.bool_]) -> Effect:
    """Return an effect that is neutral to the trials in which its explanation does not hold.

    Parameters
    ----------
    effect : Effect
        Its parameters are floats or arrays over the trials, shape (n,).
    held : array of bool, shape () or (n,)
    """
    if held.all():
        return effect
    if isinstance(effect, TransitEffect):
        return HeldEffect(effect, held)
    if not isinstance(effect, DescentEffect):
        return effect  # of the tank, which changes no plan
    if not held.any():
        return DescentEffect()
    trials = np.flatnonzero(held)
    values = {field.name: getattr(effect, field.name) for field in fields(effect)}  # type: ignore[arg-type]
    arrays = {name: value[trials] for name, value in values.items() if np.ndim(value) == 1}
    return SubsetEffect(replace(effect, **arrays), trials, held.size)  # type: ignore[type-var]
