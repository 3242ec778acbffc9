"""Parameters of effects as the diagnosis fits them: unbounded coordinates with normal priors.

A strength is its own coordinate, a shape enters by its logarithm, an amplitude and its phase as a·cos φ and a·sin φ.
Every prior is then normal: narrow about zero while the effect is no cause (a *spike*: its uncertainty before any
misfit is seen), wide when it is (a *slab*: the sizes at which the effect occurs); George & McCulloch (1993).
"""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.linalg import block_diag, solve_triangular
from scipy.special import ndtri

from missionplan.arrays import Array, Scalars
from missionplan.effects import CATALOGUE, EffectInfo
from missionplan.effects.oscillation import MODULATION_PARAMETERS
from missionplan.results.learned.evidence import ParameterEstimate

LOWER, UPPER = 0.05, 0.95
"""Probabilities at the ends of the reported intervals."""


@dataclass(frozen=True)
class Coordinate:
    """One fitted coordinate."""

    effect: str
    name: str
    """Effect and parameter (of a polar pair: the amplitude)."""
    kind: Literal["strength", "shape", "cosine", "sine"]
    """Its relation to the parameter: the parameter itself, its logarithm, or one of a·cos φ and a·sin φ."""
    centre: float
    slab: float
    spike: float
    """Prior mean, and prior standard deviation as a cause and otherwise; a shape has no spike."""

    @property
    def key(self) -> tuple[str, str, str]:
        """What distinguishes it from all others."""
        return self.effect, self.name, self.kind

    @property
    def range(self) -> tuple[float, float]:
        """Ends of its physical range; an amplitude and its phase have none together."""
        parameter = CATALOGUE[self.effect].parameters[self.name]
        if self.kind in ("cosine", "sine"):
            return -math.inf, math.inf
        if self.kind == "shape":
            return (math.log(parameter.low) if parameter.low > 0.0 else -math.inf), math.log(parameter.high)
        return parameter.low, parameter.high


def coordinates_of(info: EffectInfo, names: Iterable[str] | None = None) -> tuple[Coordinate, ...]:
    """Return the coordinates of an effect.

    `info`: the effect. `names`: parameters to fit; default all of them but those of a modulation, which is random.
    """
    wanted = [name for name in info.parameters if not (info.is_modulated and name in MODULATION_PARAMETERS)]
    if names is not None:
        wanted = list(names)
    phases = {phase for _, phase in info.polar}
    amplitudes = {amplitude for amplitude, _ in info.polar}
    coordinates: list[Coordinate] = []
    for name in wanted:
        parameter = info.parameters[name]
        if name in phases:
            continue
        if name in amplitudes:
            coordinates.append(Coordinate(info.id, name, "cosine", 0.0, parameter.scale, parameter.spike))
            coordinates.append(Coordinate(info.id, name, "sine", 0.0, parameter.scale, parameter.spike))
        elif parameter.is_shape:
            centre, slab = math.log(parameter.median), math.log(parameter.factor)
            coordinates.append(Coordinate(info.id, name, "shape", centre, slab, 0.0))
        else:
            coordinates.append(Coordinate(info.id, name, "strength", 0.0, parameter.scale, parameter.spike))
    return tuple(coordinates)


def parameters_from(
    coordinates: Sequence[Coordinate], values: Sequence[Scalars] | Array
) -> dict[str, dict[str, Scalars]]:
    """Convert coordinates to parameters: effect → name → value, of the shapes of `values`."""
    result: dict[str, dict[str, Scalars]] = {}
    cosines: dict[tuple[str, str], Scalars] = {}
    for coordinate, value in zip(coordinates, values, strict=True):
        parameters = result.setdefault(coordinate.effect, {})
        if coordinate.kind == "strength":
            parameters[coordinate.name] = value
        elif coordinate.kind == "shape":
            parameters[coordinate.name] = np.exp(value)
        elif coordinate.kind == "cosine":
            cosines[coordinate.effect, coordinate.name] = value
        else:
            cosine = cosines[coordinate.effect, coordinate.name]
            parameters[coordinate.name] = np.hypot(cosine, value)
            parameters[_phase_of(coordinate)] = np.arctan2(value, cosine)
    return result


def _phase_of(coordinate: Coordinate) -> str:
    return dict(CATALOGUE[coordinate.effect].polar)[coordinate.name]


LARGEST = 700.0
"""Logarithm of the largest number that is written."""


def estimates(coordinates: Sequence[Coordinate], mean: Array, covariance: Array) -> tuple[ParameterEstimate, ...]:
    """Return parameters with standard deviations and 90 % intervals, from a normal posterior of the coordinates.

    An amplitude and its phase by linear propagation of errors (the delta method); intervals are clipped to the
    parameter's range.

    `coordinates`: the fitted ones. `mean`, shape (k,): posterior mean. `covariance`, shape (k, k): posterior
    covariance.
    """
    parameters: list[ParameterEstimate] = []
    for index, coordinate in enumerate(coordinates):
        value, variance = float(mean[index]), float(covariance[index, index])
        sd = math.sqrt(max(variance, 0.0))
        if coordinate.kind == "strength":
            parameters.append(_estimate(coordinate, coordinate.name, value, sd))
        elif coordinate.kind == "shape":
            low, size, high = np.exp(np.minimum(value + ndtri([LOWER, 0.5, UPPER]) * sd, LARGEST)).tolist()
            unit = CATALOGUE[coordinate.effect].parameters[coordinate.name].unit
            parameters.append(ParameterEstimate(coordinate.effect, coordinate.name, size, size * sd, low, high, unit))
        elif coordinate.kind == "sine":
            both = slice(index - 1, index + 1)
            pair, block = mean[both], covariance[both, both]
            size, phase = float(np.hypot(*pair)), float(np.arctan2(pair[1], pair[0]))
            along = pair / max(size, 1e-12)
            radial, across = (
                math.sqrt(max(float(way @ block @ way), 0.0)) for way in (along, np.array([-along[1], along[0]]))
            )
            parameters.append(_estimate(coordinate, coordinate.name, size, radial))
            sd_phase = min(across / max(size, 1e-12), math.pi / math.sqrt(3))
            parameters.append(_estimate(coordinate, _phase_of(coordinate), phase, sd_phase))
    return tuple(parameters)


@dataclass(frozen=True)
class JointPosterior:
    """What is known of k coordinates together, as a normal distribution: for a record to come."""

    coordinates: tuple[Coordinate, ...]
    mean: Array
    """Shape (k,)."""
    covariance: Array
    """Shape (k, k)."""

    def joined(self, other: "JointPosterior") -> "JointPosterior":
        """Join with another one that is independent of it."""
        mean, covariance = np.concatenate([self.mean, other.mean]), block_diag(self.covariance, other.covariance)
        return JointPosterior((*self.coordinates, *other.coordinates), mean, covariance)

    def without(self, effects: Collection[str]) -> "JointPosterior":
        """Return it without the coordinates of some effects."""
        kept = [index for index, coordinate in enumerate(self.coordinates) if coordinate.effect not in effects]
        coordinates = tuple(self.coordinates[index] for index in kept)
        return JointPosterior(coordinates, self.mean[kept], self.covariance[np.ix_(kept, kept)])

    def scaled(self, scale: float) -> "JointPosterior":
        """Return it with the sizes of random errors scaled."""
        sizes = [not c.effect or CATALOGUE[c.effect].parameters[c.name].is_random_size for c in self.coordinates]
        return replace(self, mean=self.mean + math.log(scale) * np.array(sizes))

    def drawn(self, count: int, generator: np.random.Generator) -> dict[tuple[str, str], Array]:
        """Draw parameters by effect and name, shape (count,) each, with just this mean and covariance.

        A draw with a strength out of its physical range is replaced by another one; sizes and times are cut.
        """
        normals = even_normals(count, len(self.mean), generator)
        values, vectors = np.linalg.eigh(self.covariance)
        at = self.mean + (normals * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
        draws = {
            (effect, name): np.asarray(drawn)
            for effect, named in parameters_from(self.coordinates, at.T).items()
            for name, drawn in named.items()
        }
        kept = np.ones(count, dtype=bool)
        for column in draws:
            (effect, name), (low, high) = column, _range(column)
            if effect and not CATALOGUE[effect].parameters[name].is_shape:
                kept &= (draws[column] >= low) & (draws[column] <= high)
        places = np.arange(count)
        if kept.any():
            places[~kept] = np.resize(np.flatnonzero(kept), np.count_nonzero(~kept))
        return {column: np.clip(values[places], *_range(column)) for column, values in draws.items()}


def even_normals(count: int, size: int, generator: np.random.Generator) -> Array:
    """Draw standard normals, shape (count, size), with just the mean and the covariance of the law where they can."""
    normals = generator.standard_normal((count, size))
    if count > EXACT * size > 0:
        normals -= normals.mean(axis=0)
        factor = np.linalg.cholesky(normals.T @ normals / count)
        normals = solve_triangular(factor, normals.T, lower=True).T
    return normals


EXACT = 4
"""Draws a coordinate from which their moments are made exact."""
SIGMA_V = Coordinate("", "sigma_v", "shape", 0.0, 0.0, 0.0)
"""The standard deviation of the velocity error, which belongs to no effect."""


def _range(column: tuple[str, str]) -> tuple[float, float]:
    effect, name = column
    if not effect:
        return 1e-9, math.inf
    parameter = CATALOGUE[effect].parameters[name]
    return parameter.low, parameter.high


def _estimate(coordinate: Coordinate, name: str, value: float, sd: float) -> ParameterEstimate:
    parameter = CATALOGUE[coordinate.effect].parameters[name]
    low, high = (min(max(value + float(ndtri(p)) * sd, parameter.low), parameter.high) for p in (LOWER, UPPER))
    return ParameterEstimate(coordinate.effect, name, value, sd, low, high, parameter.unit)


def is_approximate(cause: str) -> bool:
    """Whether an effect has shape parameters and no physical law gives its form but for them."""
    info = CATALOGUE[cause]
    return any(parameter.is_shape for parameter in info.parameters.values()) and not info.follows_law


def is_possible(estimates: Iterable[ParameterEstimate]) -> bool:
    """Whether every strength lies in its physical range, and every shape's 90 % interval overlaps it.

    A strength of the wrong sign is not the effect.
    """
    for estimate in estimates:
        parameter = CATALOGUE[estimate.effect].parameters[estimate.name]
        if parameter.is_shape:
            if estimate.high < parameter.low or estimate.low > parameter.high:
                return False
        elif not parameter.low <= estimate.value <= parameter.high:
            return False
    return True
