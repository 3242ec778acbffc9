"""Draws of the effects that a mission states or has learned: what a diagnosis begins from, and carries on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import even_normals
from missionplan.mission import Mission
from missionplan.mission.schema.effect_list import POSTERIOR, EffectEntry
from missionplan.montecarlo.distributions import Distribution, Quantity, mean_of
from missionplan.montecarlo.draws import JointDistribution
from missionplan.montecarlo.streams import LegSource, stream

DRAWS = 4096
"""Of what a mission states: their normals have the moments of the law, so that means and spreads are exact."""
Drawn = tuple[list[dict[str, Array]], Array]
"""Draws of each effect's parameters by name, and their weights, whose sum is 1."""


def is_learned(entry: EffectEntry) -> bool:
    """Whether an effect is one of a posterior's."""
    return entry.explanation is not None and entry.explanation[0] == POSTERIOR


def learned_draws(mission: Mission, entries: Sequence[EffectEntry]) -> Drawn:
    """Return the draws of effects of a posterior of which one set is known to hold."""
    if mission.effect_list.learned is None or not entries:
        return [], np.ones(1)
    held = mission.effect_list.learned.held
    found = [
        {name: held.values[:, held.columns.index((entry.effect, name))] for name in entry.parameters}
        for entry in entries
    ]
    return found, held.weights


def stated_draws(mission: Mission, stated: Mapping[str, Mapping[str, Quantity]]) -> Drawn:
    """Draw effects that a mission states, with its correlations.

    Parameters
    ----------
    mission : Mission
    stated : mapping
        Parameters of each effect, by the beginning of their key paths.
    """
    own = {f"{place}.{name}": value for place, parameters in stated.items() for name, value in parameters.items()}
    joint = JointDistribution.of({**mission.quantities(), **own}, mission.correlated)
    marginals = {name: value for name, value in own.items() if isinstance(value, Distribution)}
    names = sorted({*marginals, *joint.correlated})
    normals = even_normals(DRAWS, len(names), stream(0, "prior", 0))
    drawn = replace(joint, marginals=marginals).draw_from(_Normals(dict(zip(names, normals.T, strict=True))), DRAWS)
    found = [
        {
            name: drawn.get(f"{place}.{name}", np.full(DRAWS, float(mean_of(value))))
            for name, value in parameters.items()
        }
        for place, parameters in stated.items()
    ]
    return found, np.full(DRAWS, 1.0 / DRAWS)


@dataclass(frozen=True)
class _Normals:
    """Normals by name, as a source of draws."""

    by_name: Mapping[str, Array]

    def once(self, quantity: str) -> Array:
        """Normals of a quantity."""
        return self.by_name[quantity]

    def legs(self, quantity: str) -> LegSource:
        """Nothing here is drawn anew for each leg."""
        raise NotImplementedError
