"""Effects that a mission carries already: part of the base model, their distributions the priors of their parameters.

What a mission knows of an effect (its long-run value) and what the effect is in one record differ by the effect's
spike, its uncertainty from record to record. A number without a distribution is known to within the spike alone.
"""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import block_diag
from scipy.special import ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of, estimates
from missionplan.diagnosis.forecast_error import along_a_track
from missionplan.effects import CATALOGUE, Effect, EffectInfo, exclusive_groups
from missionplan.effects.oscillation import MODULATION, MODULATION_PARAMETERS
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.distributions import Distribution, Quantity, mean_of, sd_of
from missionplan.results.learned.evidence import Causes, ParameterEstimate

BARE_SHAPE_LOG_SD = 0.05
"""Standard deviation of the logarithm of a shape parameter that is given as a number: it has no spike."""
QUANTILES = 512
"""Equally likely values that stand for a distribution where its moments are taken of a function of it."""


@dataclass(frozen=True)
class GivenEffect:
    """An effect of the mission as the diagnosis holds it, k coordinates.

    Attributes
    ----------
    effect : str
        Its name.
    coordinates : tuple of Coordinate, length k
        Of the parameters that the mission gives, and of all its shapes.
    mean : array, shape (k,)
        Of their long-run values.
    covariance : array, shape (k, k)
        Of their long-run values: what the mission knows.
    scatter : array, shape (k,)
        Variance about them from record to record.
    """

    effect: str
    coordinates: tuple[Coordinate, ...]
    mean: Array
    covariance: Array
    scatter: Array

    def only(self, names: Collection[str]) -> "GivenEffect":
        """Return the effect with some of its parameters; an amplitude goes with its phase."""
        kept = [index for index, coordinate in enumerate(self.coordinates) if coordinate.name in names]
        return GivenEffect(
            self.effect,
            tuple(self.coordinates[index] for index in kept),
            self.mean[kept],
            self.covariance[np.ix_(kept, kept)],
            self.scatter[kept],
        )

    @property
    def here(self) -> Array:
        """Prior covariance of the coordinates in one record, shape (k, k)."""
        return self.covariance + np.diag(self.scatter)

    @property
    def prior(self) -> tuple[ParameterEstimate, ...]:
        """What the mission knows."""
        return estimates(self.coordinates, self.mean, self.covariance)

    def posterior(self, mean: Array, covariance: Array) -> tuple[ParameterEstimate, ...]:
        """Return the long-run parameters after a record.

        Parameters
        ----------
        mean : array, shape (k,)
            Posterior mean of the coordinates in the record.
        covariance : array, shape (k, k)
            Posterior covariance of them.
        """
        gain = self.covariance @ np.linalg.pinv(self.here)
        after = self.mean + gain @ (mean - self.mean)
        spread = (np.eye(len(gain)) - gain) @ self.covariance + gain @ covariance @ gain.T
        return estimates(self.coordinates, after, spread)


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
    return tuple(given for given in found if given is not None)


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


def held(given: Iterable[GivenEffect], causes: Causes) -> tuple[GivenEffect, ...]:
    """Return the given effects that hold beside a set of causes.

    A given effect that is itself a cause has changed; one of the same exclusive group is replaced.
    """
    groups = {CATALOGUE[name].exclusive_group for name in causes} - {""}
    return tuple(
        each for each in given if each.effect not in causes and CATALOGUE[each.effect].exclusive_group not in groups
    )


def _given(info: EffectInfo, parameters: Mapping[str, Quantity]) -> GivenEffect | None:
    quantities = _stated(info, parameters)
    if any(info.parameters[name].is_shape and not 0.0 < mean_of(q) < math.inf for name, q in quantities.items()):
        return None
    phases = dict(info.polar)
    names = [name for name in info.parameters if name in quantities or phases.get(name) in quantities]
    coordinates = coordinates_of(info, names)
    blocks = [_block(coordinate, quantities, phases) for coordinate in coordinates if coordinate.kind != "sine"]
    means, covariances, scatters = zip(*blocks, strict=True) if blocks else ((np.zeros(0),),) * 3
    covariance = block_diag(*covariances) if blocks else np.zeros((0, 0))
    return GivenEffect(info.id, coordinates, np.concatenate(means), covariance, np.concatenate(scatters))


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
