"""How missions fail: the ways, and what is not as usual in each."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.results.rare_failure import Cause, FailureMode

LEAST_SHARE = 0.02
"""Of the failures, of a way to fail that is described."""
LEAST_SHIFT = 0.5
"""Standard deviations from usual from which an input counts as unusual."""
MOST_CAUSES = 4


def failure_modes(
    weights: Array, steps: NDArray[np.str_], inputs: Mapping[str, Array], usual: Mapping[str, Array]
) -> tuple[FailureMode, ...]:
    """Group failing trials by where they fail, and find what was drawn unlike usual.

    Parameters
    ----------
    weights : array, shape (n,)
    steps : array of str, shape (n,)
    inputs : mapping of str to array, shape (n,)
        What was drawn in them; nan where it was never needed.
    usual : mapping of str to array, shape (m,)
        The same of plain trials.
    """
    shares = {str(step): float(weights[steps == step].sum() / weights.sum()) for step in np.unique(steps)}
    modes = [
        FailureMode(step, share, _causes(steps == step, weights, inputs, usual))
        for step, share in shares.items()
        if share >= LEAST_SHARE
    ]
    return tuple(sorted(modes, key=lambda mode: -mode.share))


def _causes(
    chosen: NDArray[np.bool_], weights: Array, inputs: Mapping[str, Array], usual: Mapping[str, Array]
) -> tuple[Cause, ...]:
    found = []
    for source, values in inputs.items():
        drawn = chosen & np.isfinite(values)
        before = usual[source][np.isfinite(usual[source])]
        if before.size < 2 or weights[drawn].sum() < 0.5 * weights[chosen].sum() or not np.std(before) > 0.0:
            continue
        mean = float(np.average(values[drawn], weights=weights[drawn]))
        found.append(Cause(source, mean, float(np.mean(before)), float(np.std(before))))
    unusual = [cause for cause in found if abs(cause.shift) >= LEAST_SHIFT]
    return tuple(sorted(unusual, key=lambda cause: -abs(cause.shift))[:MOST_CAUSES])
