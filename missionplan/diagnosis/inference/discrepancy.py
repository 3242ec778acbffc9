"""What a model leaves, and what it misses along an axis: tests of residuals, smooth responses that compete with causes.

A response is a smooth random function along an axis (`axes`) by its principal components, in the metric of the noise
(Kennedy & O'Hagan 2001, *J. R. Stat. Soc. B* 63; Brynjarsdóttir & O'Hagan 2014, *Inverse Problems* 30); or one number
for each run. Its evidence is a mean over its lengths and sizes. As a test of what is left its Bayes factor is computed
and its shape shown; nothing of it enters the extended model.
"""

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import chdtrc, logsumexp, ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis, differing, principal_components
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, InnerProducts
from missionplan.diagnosis.inference.marginal_likelihood import SCALES, log_slab_factor, nested_log_factors
from missionplan.results.learned.evidence import Causes, Discrepancy, DiscrepancyShape, OutlyingGroup, ResidualTest


@dataclass(frozen=True)
class Residuals:
    """Residuals of the base model and their joint distribution under a set of causes."""

    values: Array
    """Data less the prior mean of the (linearised) model, in the order of the record, shape (N,)."""
    covariance: BlockCovariance
    """Of the values under the model, uncertain parameters included."""
    series: NDArray[np.int_]
    """Which series each value belongs to: runs and components, shape (N,)."""
    axes: Sequence[Axis]
    """Along which a discrepancy may be smooth."""
    groups: NDArray[np.str_]
    """Runs, which the search for outlying groups leaves out in turn, shape (N,)."""
    quantised: bool = False
    """Whether the residual tests ignore what alternates, as readings of a coarse sensor in quick succession do."""
    products_by_noise: Callable[[Array], Iterable[InnerProducts]] | None = None
    """From columns, shape (N, m), to their inner products at every noise over which the test for a discrepancy
    averages; default the one noise of the covariance."""

    def innovations(self) -> Array:
        """Return one-step-ahead errors over their standard deviations, shape (N,)."""
        return self.covariance.innovations(self.values)

    def inner_products(self, columns: Array) -> Iterable[InnerProducts]:
        """Return inner products of columns, shape (N, m), and the values at every noise over which to average."""
        if self.products_by_noise is not None:
            return self.products_by_noise(columns)
        return [self.covariance.products(columns, self.values)]


OUTLYING = 0.01
"""Level at which a group is outlying, for all groups together."""
TEST_LEVEL = 0.001
"""Level of the residual tests, for all of them together."""
SHORTEST = 16
"""Values that a series needs to be tested."""
UNSEEN = 0.01
"""Innovations that are all smaller are no errors: rounding follows a pattern, but far below the noise."""


def residual_tests(residuals: Residuals, innovations: Array) -> tuple[ResidualTest, ...]:
    """Test each series for autocorrelation (`ljung_box_p_value`) and for changing spread (`arch_p_value`).

    Innovations enter by their normal scores (van der Waerden 1952, *Indag. Math.* 14), so that a heavy tail alone
    rejects nothing.

    `residuals`: which say what makes a series. The quantisation steps of a coarse sensor beat with the sampling: of
    quantised residuals, neighbours are added together, and only a positive sum of autocorrelations counts.
    `innovations`, shape (N,): theirs.
    """
    tests = []
    for number in np.unique(residuals.series):
        z = innovations[residuals.series == number]
        if residuals.quantised:
            z = z[: len(z) // 2 * 2].reshape(-1, 2).sum(axis=1)
        if len(z) < SHORTEST or float(np.max(np.abs(z))) < UNSEEN:
            continue
        ranks = np.argsort(np.argsort(z))
        scores = ndtri((ranks + 0.5) / len(z))
        lags = min(8, len(z) // 4)
        portmanteau = ljung_box_p_value(scores, lags)
        if residuals.quantised and sum(float(scores[k:] @ scores[:-k]) for k in range(1, lags + 1)) <= 0.0:
            portmanteau = 1.0
        tests.append(ResidualTest(f"autocorrelation {number + 1}", portmanteau))
        tests.append(ResidualTest(f"changing spread {number + 1}", arch_p_value(scores, min(4, lags))))
    return tuple(tests)


def ljung_box_p_value(series: Array, lags: int) -> float:
    """P-value of the portmanteau test that the first autocorrelations of a series are zero.

    Q = n(n + 2) Σ_k r_k²/(n - k) is χ² with as many degrees of freedom as lags (Ljung & Box 1978, Eq. 1.3).

    `series`, shape (n,). `lags`: fewer than n.
    """
    n, centred = len(series), series - series.mean()
    lag = np.arange(1, lags + 1)
    correlation = np.array([centred[k:] @ centred[:-k] for k in lag]) / (centred @ centred)
    return float(chdtrc(lags, n * (n + 2.0) * np.sum(correlation**2 / (n - lag))))


def arch_p_value(series: Array, lags: int) -> float:
    """P-value of the test that the spread of a series does not depend on its past.

    Regress the squares on the squares before them: n·R² is χ² with as many degrees of freedom as lags, n the number
    of squares regressed (Engle 1982, section 8).

    `series`, shape (n,). `lags`: fewer than (n - 1)/2.
    """
    squares = series**2
    past = np.stack([squares[lags - k - 1 : -k - 1] for k in range(lags)], axis=1)
    design = np.column_stack([np.ones(len(past)), past])
    present = squares[lags:]
    left = present - design @ np.linalg.lstsq(design, present, rcond=None)[0]
    determination = 1.0 - float(left @ left) / float(np.sum((present - present.mean()) ** 2))
    return float(chdtrc(lags, len(past) * determination))


def rejects(tests: tuple[ResidualTest, ...]) -> bool:
    """Whether any of the tests rejects, at a level for all of them together (Bonferroni)."""
    return any(test.p_value < TEST_LEVEL / len(tests) for test in tests)


def outlying_groups(residuals: Residuals) -> tuple[OutlyingGroup, ...]:
    """Return groups that the others do not predict, with their p-values (Bonferroni over groups).

    The squared Mahalanobis length of a group's error is χ² with as many degrees of freedom as the group has values.
    """
    names = list(dict.fromkeys(residuals.groups.tolist()))
    groups = [np.flatnonzero(residuals.groups == name) for name in names]
    outliers = []
    for name, (error, covariance) in zip(names, residuals.covariance.left_out(residuals.values, groups), strict=True):
        squared = float(error @ np.linalg.solve(covariance, error))
        p_value = min(1.0, float(chdtrc(len(error), squared)) * len(names))
        if p_value < OUTLYING and len(names) > 1:
            outliers.append(OutlyingGroup(name, p_value))
    return tuple(outliers)


LENGTHS = (0.3, 0.1)
"""Correlation lengths, of the axis' extent: slow changes, and what happens within a second or in a layer."""
MOST_COLUMNS, MOST_OF_RUNS, LEAST_SHARE = 8, 32, 1e-4
"""Principal components kept at most, of what all runs share and of what each has of its own, and least share of the
first one's variance that one has."""
MOST_TOGETHER = 8
"""Runs that differ from the others, of which it is not known which they are, at most."""


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
        return np.concatenate([part for alternatives in self.columns for part in alternatives], axis=1)

    @cached_property
    def _parts(self) -> list[list[NDArray[np.intp]]]:
        """Places of each alternative's columns among all."""
        ends = np.cumsum([part.shape[1] for alternatives in self.columns for part in alternatives])
        places = iter(np.split(np.arange(ends[-1]), ends[:-1]))
        return [[next(places) for _ in alternatives] for alternatives in self.columns]

    @classmethod
    def of(cls, axes: Sequence[Axis], covariance: BlockCovariance) -> "Responses":
        """Take responses by their principal components in the metric of the blocks of a covariance.

        They may do what a named cause does: else whatever is like one were its, before they compete with it.
        """
        by_axis = []
        for axis in axes:
            if len(axis.places) == 1:
                by_axis.append(np.split(axis.response, axis.functions if axis.in_some_runs else 1, axis=1))
                continue
            most = MOST_COLUMNS if axis.functions == 1 else max(MOST_OF_RUNS, axis.functions)
            smooth = []
            for length in LENGTHS:
                columns = axis.smooth_columns(length)
                smooth.append(principal_components(columns, most, LEAST_SHARE, covariance.in_blocks(columns)))
            by_axis.append(smooth)
        return cls(axes, [[axis.size * part for part in parts] for axis, parts in zip(axes, by_axis, strict=True)])

    def in_size(self, size: float) -> "Responses":
        """Return them so large that each alternative has this root mean square in the data, where these respond."""
        sizes = [
            [float(np.sqrt(np.sum(part**2) / len(part))) for part in alternatives] for alternatives in self.columns
        ]
        scaled = [
            [size / max(usual, 1e-300) * part for part, usual in zip(alternatives, alike, strict=True)]
            for alternatives, alike in zip(self.columns, sizes, strict=True)
        ]
        return Responses(self.axes, scaled)

    def log_gains(self, products: Sequence[InnerProducts]) -> Array:
        """What each response adds to the log evidence, shape (r,), a mean over noises, sizes and alternatives."""
        grams = np.stack([product.gram for product in products])
        plain = np.array([product.log_density for product in products])
        plain -= np.logaddexp.reduce(plain)

        def over_noises(logs: Array) -> Array:
            return np.asarray(np.logaddexp.reduce(plain.reshape(-1, *(1,) * (logs.ndim - 1)) + logs, axis=0))

        parts = [part for alternatives in self._parts for part in alternatives]
        sizes, gains = np.array([len(part) for part in parts]), np.empty(len(parts))
        for size in np.unique(sizes).tolist():
            alike = np.flatnonzero(sizes == size)
            at = np.stack([parts[index] for index in alike])
            inner, right = grams[:, at[:, :, None], at[:, None, :]], grams[:, at, -1]
            gains[alike] = over_noises(log_slab_factor(inner, right))
        by_axis = np.split(gains, np.cumsum([len(alternatives) for alternatives in self.columns])[:-1])
        return np.array(
            [
                _in_some_runs(alone, np.concatenate(alternatives), grams, over_noises)
                if axis.in_some_runs
                else _mean(alone)
                for alone, alternatives, axis in zip(by_axis, self._parts, self.axes, strict=True)
            ]
        )


def _mean(logs: Array, axis: int = 0) -> Array:
    return np.asarray(np.logaddexp.reduce(logs, axis=axis) - math.log(logs.shape[axis]))


def _in_some_runs(alone: Array, runs: NDArray[np.intp], grams: Array, over_noises: Callable[[Array], Array]) -> Array:
    """Gain of a response in one run or several: in each alone, and in the likeliest together, in each its own or one.

    All numbers of runs are as likely, and all choices of so many.

    `alone`, shape (r,): gains of each run's column, `runs` its place in the inner products.
    """
    total, chosen = len(runs), runs[np.argsort(alone)[::-1][:MOST_TOGETHER]]
    inner, right = grams[:, chosen[:, None], chosen], grams[:, chosen, -1]
    apart = over_noises(log_slab_factor(inner, right, nested_log_factors))
    sums = np.diagonal(np.cumsum(np.cumsum(inner, axis=1), axis=2), axis1=1, axis2=2)  # of the columns added up
    one = over_noises(log_slab_factor(sums[..., None, None], np.cumsum(right, axis=1)[..., None]))
    choices = np.log([math.comb(total, size) for size in range(1, len(chosen) + 1)])
    together = _mean(np.stack([apart, one])) - choices
    return np.asarray(np.logaddexp.reduce([_mean(alone), *together[1:]]) - math.log(total))


THRESHOLD = 3.0
"""ln Bayes factor above which there is a discrepancy."""
USUAL = 1.0 / 3.0
"""Usual size of the smooth part, of the residuals' typical standard deviation."""


def discrepancy(residuals: Residuals) -> Discrepancy:
    """Test what a model leaves, along every axis and by residual tests."""
    gains = along_each_axis(residuals)
    together = float(logsumexp([value for _, value in gains]) - np.log(len(gains))) if gains else 0.0
    tests = residual_tests(residuals, residuals.innovations())
    likeliest = gains[0][0] if together > THRESHOLD else None
    by_axis = tuple((axis.description, value) for axis, value in gains)
    if likeliest is not None:
        shape = _shape(likeliest, residuals)
        return Discrepancy(together, likeliest.name, by_axis, tests, likeliest.description, shape)
    return Discrepancy(together, "time" if rejects(tests) else None, by_axis, tests)


def along_each_axis(residuals: Residuals) -> list[tuple[Axis, float]]:
    """Return the ln Bayes factor of a smooth function along each axis over none, greatest first."""
    axes, covariance = residuals.axes, residuals.covariance
    if not axes:
        return []
    typical = float(np.sqrt(np.median(covariance.variances)))
    responses = Responses.of(axes, covariance).in_size(USUAL * typical)
    gains = responses.log_gains(list(residuals.inner_products(responses.joined)))
    return [(axes[index], float(gains[index])) for index in np.argsort(-gains, kind="stable")]


def differing_causes(
    residuals_along: Callable[[Sequence[Axis]], Residuals], columns: Mapping[str, Array], parts: Sequence[Array]
) -> Causes:
    """Return the causes whose strengths differ between parts of the data.

    A strength of each part beside the common one, independent normals of unknown size, against none: the Bayes factor
    is averaged over the sizes and over the noises, so that it says more than the scatter that every model allows.

    `residuals_along`: of axes to look along: what the claimed set leaves. `columns`: response of the data to the
    strengths of each cause, shape (N, c). `parts`, shape (N, p): divisions of the data: 1 where a datum is of a part.
    """
    axes = [
        differing(name, (part[:, :, None] * response[:, None]).reshape(len(response), -1))
        for name, response in columns.items()
        for part in parts
    ]
    descriptions = {axis.description for axis, value in along_each_axis(residuals_along(axes)) if value > THRESHOLD}
    return tuple(name for name in columns if name in descriptions)


def _shape(axis: Axis, residuals: Residuals) -> DiscrepancyShape | None:
    """Posterior of the function at the likeliest noise, length and size (Rasmussen & Williams 2006, Eq. 2.8)."""
    scale = axis.scale
    if scale is None:
        return None
    typical = float(np.sqrt(np.median(residuals.covariance.variances)))
    bases = [axis.smooth(length) for length in LENGTHS]
    squares = [np.sum(axis.smooth_columns(length) ** 2, axis=1) for length in LENGTHS]
    usual = [USUAL * typical / float(np.sqrt(np.mean(square))) for square in squares]
    posteriors = (
        _function_posterior(products, basis, size * unit)
        for products in residuals.inner_products(axis.response)
        for (basis, unit), size in itertools.product(zip(bases, usual, strict=True), SCALES)
    )
    _, mean, sd = max(posteriors, key=lambda posterior: posterior[0])
    at = scale.at(axis.places[:, 0])
    return DiscrepancyShape(scale.place, scale.value, at, scale.factor * mean, scale.factor * sd)


def _function_posterior(products: InnerProducts, basis: Array, size: float) -> tuple[float, Array, Array]:
    """Log evidence of a function size·basis·z with z ~ N(0, I), and its posterior mean and sd at the places, (m,)."""
    scaled_basis = size * basis
    gram, right = scaled_basis.T @ products.gram[:-1, :-1] @ scaled_basis, scaled_basis.T @ products.gram[:-1, -1]
    factor = np.linalg.cholesky(gram + np.eye(len(gram)))
    half = solve_triangular(factor, np.column_stack([right, scaled_basis.T]), lower=True)
    evidence = products.log_density + 0.5 * float(half[:, 0] @ half[:, 0]) - float(np.log(np.diag(factor)).sum())
    return evidence, half[:, 1:].T @ half[:, 0], np.sqrt(np.sum(half[:, 1:] ** 2, axis=0))
