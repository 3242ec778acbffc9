"""Effects that a mission carries already: part of the base model, their distributions the priors of their parameters.

What a mission knows of an effect (its long-run value) and what the effect is in one record differ by the effect's
spike, its uncertainty from record to record. A number without a distribution is known to within the spike alone.
Whatever a mission states or has learned is drawn, and the prior has the moments of the draws.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, permutations
from typing import Literal

import numpy as np

from missionplan.arrays import Array, Normals
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of, even_normals
from missionplan.diagnosis.given import ERROR_PLACE, GivenEffect, along_a_track
from missionplan.effects import CATALOGUE, Effect, EffectInfo, exclusive_groups
from missionplan.effects.oscillation import MODULATION, MODULATION_PARAMETERS
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.effect_list import POSTERIOR, EffectEntry
from missionplan.montecarlo.distributions import Distribution, Quantity, mean_of
from missionplan.montecarlo.streams import JointDistribution, stream

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
    posterior = mission.effect_list.learned.held
    draws = [
        {name: posterior.values[:, posterior.columns.index((entry.effect, name))] for name in entry.parameters}
        for entry in entries
    ]
    return draws, posterior.weights


def stated_draws(mission: Mission, stated: Mapping[str, Mapping[str, Quantity]]) -> Drawn:
    """Draw effects that a mission states, with its correlations.

    `stated` has the parameters of each effect, by the beginning of their key paths.
    """
    by_key = {f"{place}.{name}": value for place, parameters in stated.items() for name, value in parameters.items()}
    joint = JointDistribution.of({**mission.quantities(), **by_key}, mission.correlated)
    marginals = {name: value for name, value in by_key.items() if isinstance(value, Distribution)}
    names = sorted({*marginals, *joint.correlated})
    normals = even_normals(DRAWS, len(names), stream(0, "prior", 0))
    drawn = replace(joint, marginals=marginals).draw_from(_Normals(dict(zip(names, normals.T, strict=True))), DRAWS)
    draws = [
        {
            name: drawn.get(f"{place}.{name}", np.full(DRAWS, float(mean_of(value))))
            for name, value in parameters.items()
        }
        for place, parameters in stated.items()
    ]
    return draws, np.full(DRAWS, 1.0 / DRAWS)


@dataclass(frozen=True)
class _Normals:
    """Normals by name, as a source of draws."""

    by_name: Mapping[str, Array]

    def once(self, quantity: str) -> Array:
        """Normals of a quantity."""
        return self.by_name[quantity]

    def legs(self, quantity: str) -> Normals:
        """Nothing here is drawn anew for each leg."""
        raise NotImplementedError


BARE_SHAPE_LOG_SD = 0.05
"""Standard deviation of the logarithm of a shape parameter that is given as a number: it has no spike."""
ONE = np.ones(1)
LEAST_SHAPE = 1e-3
"""Of a shape, over its mean: draws below count as this."""
CONSTANT = 1e-6
"""Standard deviation over its value below which a parameter is a number."""
LEAST_CORRELATION = 0.01
"""Weaker ones between effects are left out."""


def given_effects(mission: Mission) -> list[Effect]:
    """Return a mission's effects at their means, those on readings included."""
    return [
        CATALOGUE[entry.effect].make({name: mean_of(value) for name, value in entry.parameters.items()})
        for entry in mission.effect_list.known
    ]


def given_priors(mission: Mission, wanted: Iterable[EffectInfo]) -> tuple[GivenEffect, ...]:
    """Return the effects of a mission among those wanted, with the priors of their parameters.

    An effect whose shape is at its neutral value (infinite degrees of freedom) or whose size is nil is left out.
    """
    infos = {info.id: info for info in wanted}
    learned = [entry for entry in mission.effect_list.known if entry.effect in infos and is_learned(entry)]
    stated = [(e.place, e) for e in mission.effect_list.known if e.effect in infos and not is_learned(e)]
    error = along_a_track(mission)
    if error is not None and error[0].id in infos:
        stated.append((ERROR_PLACE, EffectEntry(error[0].id, error[1])))
    places = {place: entry.parameters for place, entry in stated}
    drawn, weights = stated_draws(mission, places) if places else ([], ONE)
    by_place = dict(zip(places, drawn, strict=True))
    return (
        *_of_draws(learned, infos, *learned_draws(mission, learned)),
        *_of_draws([entry for _, entry in stated], infos, [by_place[place] for place, _ in stated], weights),
    )


def _of_draws(
    entries: Sequence[EffectEntry],
    infos: Mapping[str, EffectInfo],
    draws: Sequence[Mapping[str, Array]],
    weights: Array,
) -> tuple[GivenEffect, ...]:
    """Effects by draws of their parameters, those of all entries together, with their covariances."""
    listed: list[tuple[EffectInfo, tuple[Coordinate, ...]]] = []
    values: list[Array | None] = []
    for entry, parameters in zip(entries, draws, strict=True):
        info = infos[entry.effect]
        stated = _stated(info, entry.parameters)
        if stated is not None:
            coordinates, quantities = stated
            samples = {name: parameters.get(name, np.full(1, mean_of(value))) for name, value in quantities.items()}
            listed.append((info, coordinates))
            values += [_values(c, samples, dict(info.polar)) for c in coordinates]
    if not listed:
        return ()
    all_coordinates = [c for _, coordinates in listed for c in coordinates]
    mean, together = _moments(all_coordinates, values, weights)
    ends = np.cumsum([0, *(len(coordinates) for _, coordinates in listed)]).tolist()
    sd = np.sqrt(np.maximum(np.diag(together), 1e-300))
    rho = together / np.outer(sd, sd)
    shared = {
        (all_coordinates[i].key, all_coordinates[j].key): float(together[i, j])
        for block, other in permutations([range(a, b) for a, b in pairwise(ends)], 2)
        if np.abs(rho[np.ix_(block, other)]).max(initial=0.0) > LEAST_CORRELATION
        for i in block
        for j in other
    }
    return tuple(
        replace(_made(*pair, mean[a:b], together[a:b, a:b].copy()), shared=shared)
        for pair, (a, b) in zip(listed, pairwise(ends), strict=True)
    )


def check_together(
    priors: Iterable[GivenEffect], mission: Mission, phase: Literal["transit", "descent", "tank"]
) -> None:
    """Refuse missions whose effects a diagnosis cannot hold together.

    Raises InputError with each pair.
    """
    names = [prior.effect for prior in priors]
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    problems = [f"{name} is given {names.count(name)} times; a diagnosis holds one of each" for name in twice]
    for group in exclusive_groups(phase):
        if len(both := sorted(group & set(names))) > 1:
            problems.append(f"a diagnosis holds one of {', '.join(both)}: they describe the same errors")
    if problems:
        raise InputError([Problem(problem, mission.file, key="effects") for problem in problems])


def _stated(
    info: EffectInfo, parameters: Mapping[str, Quantity]
) -> tuple[tuple[Coordinate, ...], dict[str, Quantity]] | None:
    """Coordinates of an effect and the parameters that the mission gives; None for one that does nothing.

    Shapes have their defaults; a modulation that is nil is left out. A shape at nil of an effect on the mean, which
    does not vanish with it, is as unknown as in the catalogue.
    """
    defaults = {name: parameter.default for name, parameter in info.parameters.items() if parameter.is_shape}
    quantities: dict[str, Quantity] = defaults | dict(parameters)
    if info.is_modulated and mean_of(quantities[MODULATION]) == 0.0:
        quantities = {name: value for name, value in quantities.items() if name not in MODULATION_PARAMETERS}
    shapes = {name: mean_of(value) for name, value in quantities.items() if info.parameters[name].is_shape}
    unknown = [name for name, mean in shapes.items() if mean == 0.0 and info.part != "covariance"]
    if any(not 0.0 < mean < math.inf for name, mean in shapes.items() if name not in unknown):
        return None
    phases = dict(info.polar)
    names = [name for name in info.parameters if name in quantities or phases.get(name) in quantities]
    known_quantities = {name: quantity for name, quantity in quantities.items() if name not in unknown}
    return coordinates_of(info, names), known_quantities


def _values(coordinate: Coordinate, parameters: Mapping[str, Array], phases: Mapping[str, str]) -> Array | None:
    """Draws of a coordinate; None of a shape that the mission does not give."""
    draws = parameters.get(coordinate.name)
    if coordinate.kind == "shape":
        if draws is None:
            return None
        return np.asarray(np.log(np.maximum(draws, LEAST_SHAPE * draws.mean())))
    if coordinate.kind == "strength":
        return draws if draws is not None else np.zeros(1)
    size = draws if draws is not None else np.zeros(1)
    angle = parameters.get(phases[coordinate.name], np.zeros(1))
    return np.asarray(size * (np.cos(angle) if coordinate.kind == "cosine" else np.sin(angle)))


def _moments(coordinates: Sequence[Coordinate], values: Sequence[Array | None], weights: Array) -> tuple[Array, Array]:
    """Mean (k,) and covariance (k, k) of coordinates by their draws; a shape without any keeps the catalogue's."""
    rows = [np.full(len(weights), c.centre) if v is None else v for c, v in zip(coordinates, values, strict=True)]
    drawn = np.stack([np.broadcast_to(row, len(weights)) for row in rows])
    mean = drawn @ weights
    apart = drawn - mean[:, None]
    covariance = (apart * weights) @ apart.T
    for index, (coordinate, draws) in enumerate(zip(coordinates, values, strict=True)):
        if draws is None:
            covariance[index, index] = coordinate.slab**2
        elif covariance[index, index] < (CONSTANT * max(abs(mean[index]), CONSTANT)) ** 2:
            covariance[index], covariance[:, index] = 0.0, 0.0
    return mean, covariance


def _made(info: EffectInfo, coordinates: tuple[Coordinate, ...], mean: Array, covariance: Array) -> GivenEffect:
    """An effect as the diagnosis holds it; a number is known to within its spike."""
    scatter = np.zeros(len(mean))
    for index, coordinate in enumerate(coordinates):
        first = index - (coordinate.kind == "sine")
        pair = slice(first, first + 1 + (coordinate.kind in ("cosine", "sine")))
        has_spread = np.any(np.diag(covariance)[pair] > 0.0) if coordinate.kind != "cosine" else True
        if coordinate.kind == "cosine":
            continue
        if coordinate.kind == "shape":
            covariance[index, index] = covariance[index, index] or BARE_SHAPE_LOG_SD**2
        elif has_spread:
            scatter[pair] = coordinate.spike**2
        else:
            covariance[pair, pair] = coordinate.spike**2 * np.eye(len(mean[pair]))
    return GivenEffect(info.id, coordinates, mean, covariance, scatter)
