"""Neutral responses beside a fit: smooth random functions along axes, and what they add to its log evidence.

A response is a smooth random function along an axis (`axes`) by its principal components, in the metric of the noise
and less what causes with a name do to the data there (Kennedy & O'Hagan 2001, *J. R. Stat. Soc. B* 63; Brynjarsdóttir &
O'Hagan 2014, *Inverse Problems* 30); or one number for each run. Its evidence is a mean over its lengths and sizes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis, principal_components
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, InnerProducts
from missionplan.diagnosis.inference.set_evidence import log_slab_factor

LENGTHS = (0.3, 0.1)
"""Correlation lengths, of the axis' extent: slow changes, and what happens within a second or in a layer."""
MOST_COLUMNS, MOST_OF_RUNS, LEAST_SHARE = 8, 32, 1e-4
"""Principal components kept at most, of what all runs share and of what each has of its own, and least share of the
first one's variance that one has."""
MOST_TOGETHER = 8
"""Runs that differ from the others, of which it is not known which they are, at most."""
SAME = 1e-6
"""Size of a combination of named causes, over the greatest, below which it is none."""


@dataclass(frozen=True)
class Responses:
    """Responses along some axes."""

    axes: Sequence[Axis]
    columns: Sequence[Sequence[Array]]
    """For standard normal coefficients, shape (N, q): of each axis its alternatives, the lengths over which it is
    smooth or the runs in which it acts."""

    @cached_property
    def joined(self) -> Array:
        """All columns, shape (N, m)."""
        return np.concatenate([own for alternatives in self.columns for own in alternatives], axis=1)

    @cached_property
    def _parts(self) -> list[list[NDArray[np.intp]]]:
        """Places of each alternative's columns among all."""
        ends = np.cumsum([own.shape[1] for alternatives in self.columns for own in alternatives])
        places = iter(np.split(np.arange(ends[-1]), ends[:-1]))
        return [[next(places) for _ in alternatives] for alternatives in self.columns]

    @classmethod
    def of(cls, axes: Sequence[Axis], covariance: BlockCovariance, named: Array) -> "Responses":
        """Take responses less what named causes do to the data.

        Parameters
        ----------
        axes : sequence of Axis
        covariance : BlockCovariance
            In whose blocks' metric principal components are taken.
        named : array, shape (N, k)
            Columns of the causes.
        """
        left, sizes, _ = np.linalg.svd(covariance.in_blocks(named), full_matrices=False)
        span = left[:, sizes > SAME * sizes.max(initial=0.0)]
        found = []
        for axis in axes:
            if len(axis.places) == 1:
                found.append(np.split(axis.response, axis.functions if axis.in_some_runs else 1, axis=1))
                continue
            most = MOST_COLUMNS if axis.functions == 1 else max(MOST_OF_RUNS, axis.functions)
            smooth = []
            for length in LENGTHS:
                white = covariance.in_blocks(axis.smooth_columns(length))
                white -= span @ (span.T @ white)
                smooth.append(covariance.coloured(principal_components(white, most, LEAST_SHARE)))
            found.append(smooth)
        return cls(axes, [[axis.size * own for own in each] for axis, each in zip(axes, found, strict=True)])

    def in_size(self, size: float) -> "Responses":
        """Return them so large that each alternative has this root mean square in the data, where these respond."""
        sizes = [[float(np.sqrt(np.sum(own**2) / len(own))) for own in alternatives] for alternatives in self.columns]
        scaled = [
            [size / max(usual, 1e-300) * own for own, usual in zip(alternatives, alike, strict=True)]
            for alternatives, alike in zip(self.columns, sizes, strict=True)
        ]
        return Responses(self.axes, scaled)

    def log_gains(self, products: Sequence[InnerProducts]) -> Array:
        """Return what each response adds to the log evidence, shape (r,), a mean over noises, sizes and alternatives.

        Parameters
        ----------
        products : sequence of InnerProducts
            Of the columns and the data, at each noise.
        """
        grams = np.stack([each.gram for each in products])
        plain = np.array([each.log_density for each in products])
        plain -= logsumexp(plain)

        def gain(part: NDArray[np.intp]) -> float:
            inner, right = grams[:, part[:, None], part], grams[:, part, -1]
            return float(logsumexp(plain + log_slab_factor(inner, right)))

        return np.array(
            [
                _in_some_runs(gain, alternatives) if axis.in_some_runs else _mean([gain(part) for part in alternatives])
                for alternatives, axis in zip(self._parts, self.axes, strict=True)
            ]
        )


def _mean(logs: Sequence[float]) -> float:
    return float(logsumexp(logs)) - math.log(len(logs))


def _in_some_runs(gain: Callable[[NDArray[np.intp]], float], runs: Sequence[NDArray[np.intp]]) -> float:
    """Gain of a response in one run or several: in each alone, and in the likeliest together.

    All numbers of runs are as likely, and all choices of so many.
    """
    alone = [gain(part) for part in runs]
    order, total = np.argsort(alone)[::-1], len(runs)
    sizes = range(2, min(total, MOST_TOGETHER) + 1)
    together = [
        gain(np.concatenate([runs[i] for i in order[:size]])) - math.log(math.comb(total, size)) for size in sizes
    ]
    return float(logsumexp([_mean(alone), *together])) - math.log(total)
