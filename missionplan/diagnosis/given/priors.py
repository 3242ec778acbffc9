"""Effects that a mission carries already: part of the base model, their distributions the priors of their parameters.

What a mission knows of an effect (its long-run value) and what the effect is in one record differ by the effect's
spike, its uncertainty from record to record. A number without a distribution is known to within the spike alone.
The mission's `correlations` are those of the normals that its distributions are drawn from, and so of the coordinates.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.linalg import block_diag
from scipy.special import ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of
from missionplan.diagnosis.forecast_error import ERROR_PLACE, along_a_track
from missionplan.diagnosis.given.effects import CoordinateKey, GivenEffect
from missionplan.effects import CATALOGUE, Effect, EffectInfo, exclusive_groups
from missionplan.effects.oscillation import MODULATION, MODULATION_PARAMETERS
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.distributions import Distribution, Quantity, mean_of, sd_of

BARE_SHAPE_LOG_SD = 0.05
"""Standard deviation of the logarithm of a shape parameter that is given as a number: it has no spike."""
QUANTILES = 512
"""Equally likely values that stand for a distribution where its moments are taken of a function of it."""
SHARES = (1.0, 0.99, 0.9, 0.5)
"""Factors on correlations of amplitudes and phases, the first with which a joint distribution of the pairs exists."""


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
    known = {info.id: info for info in wanted}
    found = [
        _given(known[entry.effect], entry.parameters) for entry in mission.effect_list.known if entry.effect in known
    ]
    error = along_a_track(mission)
    if error is not None and error[0].id in known:
        found.append(_given(*error))
    return _correlated([given for given in found if given is not None], mission)


def check_together(
    given: Iterable[GivenEffect], mission: Mission, phase: Literal["transit", "descent", "tank"]
) -> None:
    """Refuse missions whose effects a diagnosis cannot hold together.

    Raises
    ------
    InputError
        With each pair.
    """
    names = [each.effect for each in given]
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    problems = [f"{name} is given {names.count(name)} times; a diagnosis holds one of each" for name in twice]
    for group in exclusive_groups(phase):
        if len(both := sorted(group & set(names))) > 1:
            problems.append(f"a diagnosis holds one of {', '.join(both)}: they describe the same errors")
    if problems:
        raise InputError([Problem(problem, mission.file, key="effects") for problem in problems])


def _given(info: EffectInfo, parameters: Mapping[str, Quantity]) -> GivenEffect | None:
    quantities = _stated(info, parameters)
    unknown = [] if info.part == "covariance" else _nil_shapes(info, quantities)
    quantities = {name: quantity for name, quantity in quantities.items() if name not in unknown}
    if any(info.parameters[name].is_shape and not 0.0 < mean_of(q) < math.inf for name, q in quantities.items()):
        return None
    phases = dict(info.polar)
    known = {*quantities, *unknown}
    names = [name for name in info.parameters if name in known or phases.get(name) in known]
    coordinates = coordinates_of(info, names)
    blocks = [_block(coordinate, quantities, phases) for coordinate in coordinates if coordinate.kind != "sine"]
    means, covariances, scatters = zip(*blocks, strict=True) if blocks else ((np.zeros(0),),) * 3
    covariance = block_diag(*covariances) if blocks else np.zeros((0, 0))
    return GivenEffect(info.id, coordinates, np.concatenate(means), covariance, np.concatenate(scatters))


def _nil_shapes(info: EffectInfo, quantities: Mapping[str, Quantity]) -> list[str]:
    """Shapes at nil of an effect on the mean, which does not vanish with them: as unknown as in the catalogue."""
    return [
        name for name, quantity in quantities.items() if info.parameters[name].is_shape and mean_of(quantity) == 0.0
    ]


def _stated(info: EffectInfo, parameters: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Parameters that the mission gives, with the defaults of shapes; without a modulation that is nil."""
    defaults = {name: parameter.default for name, parameter in info.parameters.items() if parameter.is_shape}
    quantities: dict[str, Quantity] = defaults | dict(parameters)
    if info.is_modulated and mean_of(quantities[MODULATION]) == 0.0:
        return {name: value for name, value in quantities.items() if name not in MODULATION_PARAMETERS}
    return quantities


def _block(
    coordinate: Coordinate, quantities: Mapping[str, Quantity], phases: Mapping[str, str]
) -> tuple[Array, Array, Array]:
    """Mean, covariance and scatter of a parameter's coordinate, or of the pair of an amplitude with its phase."""
    quantity, spike = quantities.get(coordinate.name, 0.0), coordinate.spike**2
    if coordinate.kind == "shape":
        if coordinate.name not in quantities:
            return np.array([coordinate.centre]), np.array([[coordinate.slab**2]]), np.zeros(1)
        centre, sd = _log_moments(quantity)
        return np.array([centre]), np.array([[(sd or BARE_SHAPE_LOG_SD) ** 2]]), np.zeros(1)
    if coordinate.kind == "strength":
        mean, covariance = np.array([mean_of(quantity)]), np.array([[sd_of(quantity) ** 2]])
    else:
        mean, covariance = _polar_moments(quantity, quantities.get(phases[coordinate.name], 0.0))
    if not np.any(covariance):  # a number, known to within the spike
        return mean, spike * np.eye(len(mean)), np.zeros(len(mean))
    return mean, covariance, np.full(len(mean), spike)


def _equally_likely(quantity: Quantity) -> Array:
    """Values at the middles of equal shares of probability, shape (q,)."""
    if not isinstance(quantity, Distribution):
        return np.array([quantity])
    return quantity.from_normal(ndtri((np.arange(QUANTILES) + 0.5) / QUANTILES))


def _log_moments(quantity: Quantity) -> tuple[float, float]:
    """Mean and standard deviation of the logarithm; values at or below zero count as a thousandth of the mean."""
    logarithms = np.log(np.maximum(_equally_likely(quantity), 1e-3 * mean_of(quantity)))
    return float(logarithms.mean()), float(logarithms.std())


def _polar_moments(amplitude: Quantity, phase: Quantity) -> tuple[Array, Array]:
    """Mean and covariance of (a·cos φ, a·sin φ), amplitude and phase independent."""
    sizes, angles = _equally_likely(amplitude), _equally_likely(phase)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    mean = sizes.mean() * directions.mean(axis=1)
    second = np.mean(sizes**2) * (directions @ directions.T) / len(angles)
    return mean, second - np.outer(mean, mean)


def _correlated(given: Sequence[GivenEffect], mission: Mission) -> tuple[GivenEffect, ...]:
    """Give effects the covariances that the mission's correlations mean."""
    quantities = {entry.effect: entry.parameters for entry in mission.effect_list.known}
    steps = {
        (f"effects.{each.effect}.{name}" if each.effect in quantities else f"{ERROR_PLACE}{name}"): (each, step)
        for each in given
        for name, step in _steps(each, quantities.get(each.effect, {})).items()
    }
    keys = [c.key for each in given for c in each.coordinates]
    added = np.zeros((len(keys), len(keys)))
    for correlation in mission.correlated:
        if all(name in steps for name in correlation.between):
            first, second = (_placed(*steps[name], keys) for name in correlation.between)
            added += correlation.rho * (np.outer(first, second) + np.outer(second, first))
    if not added.any():
        return tuple(given)
    added *= _possible_share(block_diag(*(each.here for each in given)), added)
    shared = {(a, b): float(added[i, j]) for i, a in enumerate(keys) for j, b in enumerate(keys) if added[i, j] != 0.0}
    return tuple(_with_shared(each, shared) for each in given)


def _with_shared(given: GivenEffect, shared: Mapping[tuple[CoordinateKey, CoordinateKey], float]) -> GivenEffect:
    """Give an effect the covariances between its own coordinates, and those with others."""
    own = [c.key for c in given.coordinates]
    inside = np.array([[shared.get((a, b), 0.0) for b in own] for a in own]).reshape(len(own), len(own))
    between = {(a, b): value for (a, b), value in shared.items() if a[0] != b[0]}
    return replace(given, covariance=given.covariance + inside, shared=between)


def _steps(given: GivenEffect, quantities: Mapping[str, Quantity]) -> dict[str, Array]:
    """Change of an effect's coordinates with the normal of each of its distributions, to first order."""
    phases = dict(CATALOGUE[given.effect].polar)
    found = {}
    for index, coordinate in enumerate(given.coordinates):
        unit = np.eye(len(given.coordinates))
        if coordinate.kind in ("strength", "shape"):
            found[coordinate.name] = math.sqrt(given.covariance[index, index]) * unit[index]
        elif coordinate.kind == "sine":
            phase = phases[coordinate.name]
            amplitude, angle = (quantities.get(name, 0.0) for name in (coordinate.name, phase))
            c, s = math.cos(mean_of(angle)), math.sin(mean_of(angle))
            found[coordinate.name] = sd_of(amplitude) * (c * unit[index - 1] + s * unit[index])
            found[phase] = sd_of(angle) * mean_of(amplitude) * (c * unit[index] - s * unit[index - 1])
    return found


def _placed(given: GivenEffect, step: Array, keys: Sequence[CoordinateKey]) -> Array:
    """A change of one effect's coordinates among those of all."""
    found = np.zeros(len(keys))
    found[[keys.index(c.key) for c in given.coordinates]] = step
    return found


def _possible_share(covariance: Array, added: Array) -> float:
    """The largest share of covariances that a joint distribution can have; 0 where none of those tried."""
    for share in SHARES:
        try:
            np.linalg.cholesky(covariance + share * added)
        except np.linalg.LinAlgError:
            continue
        return share
    return 0.0
