"""Whether a physical cause holds still: its parameters fitted to either half of the legs."""

import numpy as np
from scipy.special import chdtrc

from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import Causes

LEGS = 10
"""Legs that either half needs."""
LEVEL = 0.0027
"""P-value below which the halves differ: three standard deviations of a single parameter."""


def not_constant(model: TransitModel, fit: CauseFit) -> Causes:
    """Return the physical causes whose parameters differ between the halves of a log.

    The halves are the first and the second, and even and odd blocks of five legs. With independent data and a wide
    prior the squared Mahalanobis distance of the two estimates is χ²; a modulated oscillation is compared with its
    modulation in the model. Two comparisons share the level (Bonferroni).

    Parameters
    ----------
    model : TransitModel
    fit : CauseFit
        The claimed set, fitted to the whole log.
    """
    count, model = model.data.n, model.with_term(fit.state.term)
    physical = [name for name in fit.causes if CATALOGUE[name].tier == "physical" and name in model.by_effect]
    if not physical or count < 2 * LEGS:
        return ()
    legs = np.arange(count)
    found: set[str] = set()
    for second in (legs >= count // 2, legs // 5 % 2 == 1):
        states = [model.refitted(fit, legs[half]).state for half in (~second, second)]
        for name in physical:
            own = model.by_effect[name]
            between = states[1].mean[own] - states[0].mean[own]
            spread = sum(state.covariance[np.ix_(own, own)] for state in states)
            squared = float(between @ np.linalg.solve(spread, between))
            if chdtrc(len(own), squared) < 0.5 * LEVEL:
                found.add(name)
    return tuple(name for name in fit.causes if name in found)
