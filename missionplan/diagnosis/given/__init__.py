"""What a mission knows of its effects, and of all of them together: before a record, in it, and after it.

What a mission knows of an effect (its long-run value) and what the effect is in one record differ by the effect's
spike, its uncertainty from record to record. Effects that the mission's `correlations` tie to each other have one
joint prior, and all of them one posterior: the prior of the next record. The error of the current's forecast is an
effect that persists. `priors` reads them from a mission.
"""

import copy
import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import block_diag

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, JointPosterior, estimates
from missionplan.diagnosis.inference.prior import Prior
from missionplan.effects import CATALOGUE, EffectInfo
from missionplan.mission import Mission
from missionplan.mission.schema.site import CurrentFile, TidalCurrent
from missionplan.mission.views import forecast_error
from missionplan.montecarlo.distributions import Quantity, mean_of
from missionplan.results.learned.evidence import Causes, ParameterEstimate

CoordinateKey = tuple[str, str, str]
"""Effect, name and kind."""


@dataclass(frozen=True)
class GivenEffect:
    """An effect of the mission as the diagnosis holds it, k coordinates."""

    effect: str
    """Its name."""
    coordinates: tuple[Coordinate, ...]
    """Of the parameters that the mission gives, and of all its shapes."""
    mean: Array
    """Of their long-run values, shape (k,)."""
    covariance: Array
    """Of their long-run values: what the mission knows, shape (k, k)."""
    scatter: Array
    """Variance about them from record to record, shape (k,)."""
    shared: Mapping[tuple[CoordinateKey, CoordinateKey], float] = field(default_factory=dict)
    """Covariances of long-run values of one effect with those of another, by the pairs of their coordinates' keys."""

    def only(self, names: Collection[str]) -> "GivenEffect":
        """Return the effect with some of its parameters; an amplitude goes with its phase."""
        kept = [index for index, coordinate in enumerate(self.coordinates) if coordinate.name in names]
        return GivenEffect(
            self.effect,
            tuple(self.coordinates[index] for index in kept),
            self.mean[kept],
            self.covariance[np.ix_(kept, kept)],
            self.scatter[kept],
            self.shared,
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

        `mean`, shape (k,): posterior mean of the coordinates in the record. `covariance`, shape (k, k): posterior
        covariance of them.
        """
        after, spread = self.long_run(mean), self.left_over + self.gain @ covariance @ self.gain.T
        return estimates(self.coordinates, after, spread)

    @property
    def gain(self) -> Array:
        """Change of the long-run values a unit change of those in a record, shape (k, k)."""
        return np.asarray(self.covariance @ np.linalg.pinv(self.here))

    @property
    def left_over(self) -> Array:
        """Covariance of the long-run values if those in a record were known, shape (k, k)."""
        return np.asarray((np.eye(len(self.mean)) - self.gain) @ self.covariance)

    def long_run(self, mean: Array) -> Array:
        """Mean of the long-run values, from that of the values in a record."""
        return np.asarray(self.mean + self.gain @ (mean - self.mean))


def held(priors: Iterable[GivenEffect], causes: Causes) -> tuple[GivenEffect, ...]:
    """Return the given effects that hold beside a set of causes.

    A given effect that is itself a cause has changed; one of the same exclusive group is replaced.
    """
    groups = {CATALOGUE[name].exclusive_group for name in causes} - {""}
    return tuple(
        prior
        for prior in priors
        if prior.effect not in causes and CATALOGUE[prior.effect].exclusive_group not in groups
    )


def tied(priors: Iterable[GivenEffect]) -> tuple[GivenEffect, ...]:
    """Return given effects with those that are correlated with each other joined into one."""
    groups: list[list[GivenEffect]] = []
    for prior in priors:
        near = [group for group in groups if any(_are_tied(prior, other) for other in group)]
        groups = [group for group in groups if group not in near] + [[e for group in near for e in group] + [prior]]
    return tuple(group[0] if len(group) == 1 else _joined(group) for group in groups)


def _are_tied(first: GivenEffect, second: GivenEffect) -> bool:
    return any((a.key, b.key) in first.shared for a in first.coordinates for b in second.coordinates)


def _joined(group: Sequence[GivenEffect]) -> GivenEffect:
    """One of several effects, with all their covariances."""
    coordinates = tuple(c for prior in group for c in prior.coordinates)
    covariance = block_diag(*(prior.covariance for prior in group))
    for i, a in enumerate(coordinates):
        for j, b in enumerate(coordinates):
            covariance[i, j] += group[0].shared.get((a.key, b.key), 0.0)
    return GivenEffect(
        "+".join(prior.effect for prior in group),
        coordinates,
        np.concatenate([prior.mean for prior in group]),
        covariance,
        np.concatenate([prior.scatter for prior in group]),
    )


def places_in(coordinates: Iterable[Coordinate], prior: GivenEffect) -> list[int]:
    """Return the indices of a given effect's coordinates among others."""
    index = {coordinate.key: i for i, coordinate in enumerate(coordinates)}
    return [index[coordinate.key] for coordinate in prior.coordinates]


def coordinate_prior(coordinates: Sequence[Coordinate], causes: Causes, priors: Iterable[GivenEffect]) -> Prior:
    """Return the prior of coordinates: of causes, of what the mission knows of its own effects, and of all else.

    A slab with heavy tails inside its physical range for a cause, what the mission knows of effects that have not
    changed, else a spike (0 for a shape parameter).
    """
    centre = np.array([coordinate.centre for coordinate in coordinates])
    is_cause = np.array([coordinate.effect in causes for coordinate in coordinates], dtype=bool)
    sd = np.array([c.slab if c.effect in causes else c.spike for c in coordinates])
    joint = []
    for prior in tied(held(priors, causes)):
        indices = places_in(coordinates, prior)
        centre[indices], sd[indices] = prior.mean, np.sqrt(np.diag(prior.here))
        if np.any(prior.here != np.diag(np.diag(prior.here))):
            joint.append((np.array(indices), prior.here))
    ranges = np.array([coordinate.range for coordinate in coordinates]).reshape(-1, 2).T
    low, high = (np.where(is_cause, end, beyond) for end, beyond in zip(ranges, (-np.inf, np.inf), strict=True))
    return Prior(centre, sd, is_cause, tuple(joint), low, high)


@dataclass(frozen=True)
class RecordPosterior:
    """Posterior of k coordinates in one record."""

    coordinates: Sequence[Coordinate]
    mean: Array
    """Shape (k,)."""
    covariance: Array
    """Shape (k, k)."""

    def known(self, priors: Iterable[GivenEffect]) -> tuple[ParameterEstimate, ...]:
        """Return what is known after the record of the mission's own effects, in the long run."""
        parameters: list[ParameterEstimate] = []
        for prior in priors:
            indices = places_in(self.coordinates, prior)
            parameters += prior.posterior(self.mean[indices], self.covariance[np.ix_(indices, indices)])
        return tuple(parameters)

    def afterwards(self, priors: Sequence[GivenEffect], causes: Sequence[int]) -> JointPosterior:
        """Return what is known after the record: of the mission's own effects in the long run, and of the causes.

        `priors` has those that are tied as one; `causes` are coordinates, known after the record as they are in it.
        """
        places = [places_in(self.coordinates, prior) for prior in priors]
        chosen = [*itertools.chain(*places), *causes]
        long_run = (prior.long_run(self.mean[indices]) for prior, indices in zip(priors, places, strict=True))
        mean = np.concatenate([*long_run, self.mean[list(causes)]])
        gain = block_diag(*(prior.gain for prior in priors), np.eye(len(causes)))
        left_over = block_diag(*(prior.left_over for prior in priors), np.zeros((len(causes), len(causes))))
        covariance = gain @ self.covariance[np.ix_(chosen, chosen)] @ gain.T + left_over
        return JointPosterior(tuple(self.coordinates[index] for index in chosen), mean, covariance)


_PARAMETERS = {"sigma", "time"}
ERROR_PLACE = "site.current.error"
"""Beginning of the key paths of the error's parameters."""


def along_a_track(mission: Mission) -> tuple[EffectInfo, dict[str, Quantity]] | None:
    """Return the effect that the error of the forecast is on legs, with its parameters; None where there is none.

    With a length L the error is forgotten along the track too, at the speed U of the first transit: 1/time + U/L.
    """
    error = forecast_error(mission)
    if error is None:
        return None
    time = error.time
    if error.length is not None and mission.transits and mission.transits[0].speed is not None:
        time = 1.0 / (1.0 / mean_of(error.time) + mean_of(mission.transits[0].speed) / mean_of(error.length))
    return forecast_effect(), {"sigma": error.sigma, "time": time}


def has_forecast_error(mission: Mission) -> bool:
    """Whether a mission states the error of its forecast: what legs tell of it is then written there, as no effect."""
    return forecast_error(mission) is not None


def with_forecast_error(
    data: Mapping[str, object], mission: Mission, estimates: Sequence[ParameterEstimate]
) -> dict[str, object]:
    """Write what was found of the error where the mission has it, in `site.current.error`.

    Legs tell how long the error lasts along the track alone, so that it has no length any more.
    """
    changed = copy.deepcopy(dict(data))
    site, sizes = changed.get("site"), [estimate for estimate in estimates if estimate.effect == forecast_effect().id]
    current = site.get("current") if isinstance(site, dict) else None
    if sizes and isinstance(current, dict) and has_forecast_error(mission):
        current["error"] = {size.name: _written(size) for size in sizes}
    return changed


def _written(size: ParameterEstimate) -> dict[str, object]:
    factor = math.exp(min(size.sd / size.value, 3.0))
    return {"median": f"{size.value:.5g} {size.unit}", "factor": float(f"{max(factor, 1.0001):.5g}")}


def forecast_notice(mission: Mission, causes: tuple[str, ...]) -> tuple[str, ...]:
    """Say that an error which persists beside a forecast of the current is the forecast's, where that was found."""
    current = mission.site.current if mission.site else None
    name = forecast_effect().id
    if name not in causes or not isinstance(current, CurrentFile | TidalCurrent) or current.error is not None:
        return ()
    return (
        f"The mission's current is a forecast, so that the {name} found is the error of this forecast: written as "
        "site.current.error, with its sigma and time, it also moves the vehicle at the surface and at its mooring.",
    )


def forecast_effect() -> EffectInfo:
    """Return the effect that has the parameters of a forecast's error."""
    return next(info for info in CATALOGUE.values() if info.phase == "transit" and set(info.parameters) == _PARAMETERS)
