"""What dives to come show under a set of causes: linear and Gaussian, with the errors that they have in common."""

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.dives.designs import with_depths
from missionplan.diagnosis.dives.fitting import DescentState, log_joint_with_noise
from missionplan.diagnosis.dives.kind import DescentKind
from missionplan.diagnosis.dives.linearised import DiveLinearisation
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.noise import SCATTER_FACTORS, Noise, noise_grid, shape_error_covariance
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.diagnosis.inference.trials.prediction import Prediction
from missionplan.diagnosis.next_trial.belief import Believed

NEGLIGIBLE = 0.02
"""Probability below which a noise is not considered."""


def planned(logs: tuple[DiveLog, ...], each: Believed) -> Prediction:
    """Return what dives to come show under a set of causes: as `made`, of the depths that the set expects."""
    model = cast("DescentKind", each.bound).model
    readings = replace(model.forward, logs=logs).readings(model.coordinates, each.posterior.mean[:, None])
    (found,) = made(with_depths(logs, readings[:, 0]), [each])
    return found


def made(logs: tuple[DiveLog, ...], believed: Sequence[Believed]) -> list[Prediction]:
    """Mean, sensitivities and everything else of dives under sets of causes of one mission.

    The phase is linearised at the parameters' mean and about each log's most likely release delay, as where a log is
    fitted. What the causes add is uncertain by a smooth factor, as in a fit, but one that all these dives share, for
    their law has the same error in each; and by how much dives scatter is known only so far as the dives so far tell.

    Parameters
    ----------
    logs : tuple of DiveLog
    believed : sequence of Believed
        The sets, all with data bound to the mission under the same explanation.
    """
    model = cast("DescentKind", believed[0].bound).model
    model = replace(model, forward=replace(model.forward, logs=logs))
    linears = model.linearise([(each.fit.causes, each.posterior.mean) for each in believed])
    bare = model.forward.readings(
        model.coordinates,
        np.stack([_without_causes(model, each) for each in believed], axis=1),
        np.stack([linear.release_delays for linear in linears]),
    )
    return [
        _prediction(model, each, linear, linear.readings - own)
        for each, linear, own in zip(believed, linears, bare.T, strict=True)
    ]


def _without_causes(model: DescentModel, each: Believed) -> Array:
    """Coordinates without the set's causes and the mission's own effects, shape (K,)."""
    found = each.posterior.mean.copy()
    found[[place for place in each.posterior.places if model.coordinates[place].kind != "shape"]] = 0.0
    return found


def _prediction(model: DescentModel, each: Believed, linear: DiveLinearisation, added: Array) -> Prediction:
    """The dives under one set, of which its causes add a part, shape (N,) [m]."""
    shared = shape_error_covariance(np.concatenate([log.t for log in model.forward.logs]), added)
    own = replace(linear, shaped=np.zeros_like(added))
    spikes = np.array([coordinate.spike for coordinate in model.coordinates])
    noises, shares = _noises(each.fit.state)
    covariances = [model.total_covariance(own, noise, spikes) + shared for noise in noises]
    centre = linear.readings - model.release_delay_shift(linear)
    return Prediction(centre, linear.columns[:, each.posterior.places], np.stack(covariances), shares)


def _noises(state: DescentState) -> tuple[list[Noise], Array]:
    """The likeliest noise at each scatter from dive to dive, and their probabilities by the dives so far."""
    grid, logs = noise_grid(), log_joint_with_noise(state.likelihood.marginals(state.prior_sd))
    shares = np.exp(logs - np.logaddexp.reduce(logs))
    found = []
    for scatter in SCATTER_FACTORS:
        own = [index for index, noise in enumerate(grid) if noise.scatter == scatter]
        found.append((grid[max(own, key=lambda index: shares[index])], float(shares[own].sum())))
    kept = [(noise, share) for noise, share in found if share > NEGLIGIBLE]
    total = sum(share for _, share in kept)
    return [noise for noise, _ in kept], np.array([share / total for _, share in kept])
