"""Limit states of the literature on structural reliability whose probabilities of failure are known.

They are those of OpenTURNS' benchmark (otbenchmark 0.2, whose names they keep; most from Rozsas and Slobbe 2019,
*Repository and Black-box Reliability Challenge*), written anew. Their probabilities are computed here by closed forms
and quadrature, as those published have three digits: too few to tell a bias of a hundredth.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.special import ndtr, ndtri
from scipy.stats import chi2, gamma, gumbel_r, lognorm, norm, qmc

State = Callable[[np.ndarray], np.ndarray]
"""Limit state of standard normals of shape (dimensions, n), negative or zero where they fail."""
_ROOT2 = math.sqrt(2.0)


@dataclass(frozen=True)
class Problem:
    """A limit state.

    Attributes
    ----------
    name : str
    dimensions : int
    state : callable
        Of standard normals.
    published : float
        Probability of failure that otbenchmark states.
    truth : callable
        Computes it; default: quadrature over two dimensions.
    """

    name: str
    dimensions: int
    state: State
    published: float
    truth: Callable[[], float] | None = None

    def probability(self) -> float:
        """Return the probability of failure."""
        return self.truth() if self.truth is not None else in_a_plane(self.state)


def in_a_plane(state: State, reach: float = 8.5, step: float = 0.008) -> float:
    """Probability of failure in two dimensions: along each line across, between the places where the state is zero."""
    across = np.arange(-reach, reach, step) + 0.5 * step
    nodes = np.arange(-reach, reach + 0.5 * step, step)
    total = 0.0
    for rows in np.array_split(across, 64):
        x, y = np.broadcast_arrays(rows[:, None], nodes[None, :])
        values = state(np.stack((x.ravel(), y.ravel()))).reshape(x.shape)
        low, high = values[:, :-1], values[:, 1:]
        crosses = (low <= 0.0) != (high <= 0.0)
        share = np.where(crosses, low / np.where(crosses, low - high, 1.0), 0.0)
        place = nodes[:-1] + share * step
        first = np.where(low <= 0.0, nodes[:-1], np.where(crosses, place, nodes[1:]))
        last = np.where(high <= 0.0, nodes[1:], np.where(crosses, place, nodes[:-1]))
        between = np.where(first > 0.0, ndtr(-first) - ndtr(-last), ndtr(last) - ndtr(first))
        total += float(np.sum(norm.pdf(rows) * step * np.maximum(between, 0.0).sum(axis=1)))
    return total


def _log_normal(mean: float, sd: float) -> tuple[float, float]:
    """Mean and standard deviation of the logarithm."""
    width = math.sqrt(math.log(1.0 + (sd / mean) ** 2))
    return math.log(mean) - 0.5 * width**2, width


def _log_normals(u: np.ndarray, means: tuple[float, ...], sds: tuple[float, ...]) -> np.ndarray:
    given = np.array([_log_normal(mean, sd) for mean, sd in zip(means, sds, strict=True)])
    return np.exp(given[:, :1] + given[:, 1:] * u)


# RP8: a sum of log-normals.
_MEANS_8, _SDS_8 = (120.0, 120.0, 120.0, 120.0, 50.0, 40.0), (12.0, 12.0, 12.0, 12.0, 10.0, 8.0)
_FACTORS_8 = np.array([1.0, 2.0, 2.0, 1.0, -5.0, -5.0])


def _rp8(u: np.ndarray) -> np.ndarray:
    return _FACTORS_8 @ _log_normals(u, _MEANS_8, _SDS_8)


def _truth_8(step: float = 0.1, count: int = 2**15) -> float:
    """Densities of the terms on a grid, convolved."""
    places = step * np.arange(count)

    def total(numbers: tuple[int, ...]) -> np.ndarray:
        product: np.ndarray | float = 1.0
        for number in numbers:
            mean, width = _log_normal(_MEANS_8[number], _SDS_8[number])
            scale = abs(float(_FACTORS_8[number])) * math.exp(mean)
            shares = np.diff(lognorm.cdf(np.append(places, places[-1] + step) - 0.5 * step, width, scale=scale))
            product = product * np.fft.rfft(shares)
        return np.fft.irfft(product, count)

    strength, load = total((0, 1, 2, 3)), total((4, 5))
    below = np.cumsum(strength) - 0.5 * strength
    return float(np.sum(load * below))


# RP14: a shaft; the strength x1 is uniform.
def _stress(x2, x3, x4, x5):
    return 32.0 / (np.pi * x2**3) * np.sqrt(x3**2 * x4**2 / 16.0 + x5**2)


_GUMBEL_SCALE = 350.0 * math.sqrt(6.0) / math.pi
_GUMBEL_MODE = 1500.0 - np.euler_gamma * _GUMBEL_SCALE


def _rp14(u: np.ndarray) -> np.ndarray:
    x3 = _GUMBEL_MODE - _GUMBEL_SCALE * np.log(-np.log(np.clip(ndtr(u[2]), 1e-300, 1.0 - 1e-16)))
    return 70.0 + 10.0 * ndtr(u[0]) - _stress(39.0 + 0.1 * u[1], x3, 400.0 + 0.1 * u[3], 250_000.0 + 35_000.0 * u[4])


def _truth_14() -> float:
    nodes, weights = np.polynomial.hermite_e.hermegauss(9)
    weights = weights / weights.sum()
    x3 = np.linspace(-500.0, 9000.0, 3001)[:, None]
    z5 = np.linspace(-9.0, 9.0, 1801)[None, :]
    density = gumbel_r.pdf(x3, _GUMBEL_MODE, _GUMBEL_SCALE) * norm.pdf(z5)
    cell = (x3[1, 0] - x3[0, 0]) * (z5[0, 1] - z5[0, 0])
    total = 0.0
    for node, weight in zip(nodes, weights, strict=True):  # x4 is known to 0.03 %, its variance makes no difference
        stress = _stress(39.0 + 0.1 * node, x3, 400.0, 250_000.0 + 35_000.0 * z5)
        total += weight * cell * float(np.sum(density * np.clip((stress - 70.0) / 10.0, 0.0, 1.0)))
    return total


# RP38: seven normals, the state linear in the first.
_MEANS_38 = np.array([350.0, 50.8, 3.81, 173.0, 9.38, 33.1, 0.036])


def _factor_38(x2, x3, x4, x5, x6, x7):
    top = x4**2 - 4.0 * x5 * x6 * x7**2 + x4 * (x6 + 4.0 * x5 + 2.0 * x6 * x7)
    return x2**3 / (2.0 * x3**3) * top / (x4 * x5 * (x4 + x6 + 2.0 * x6 * x7))


def _rp38(u: np.ndarray) -> np.ndarray:
    x = _MEANS_38[:, None] * (1.0 + 0.1 * u)
    return 155_900.0 - x[0] * _factor_38(*x[1:])


def _truth_38() -> float:
    """Exact in the first variable, low-discrepancy points in the others."""
    u = ndtri(qmc.Sobol(6, seed=1).random_base2(20)).T
    x = _MEANS_38[1:, None] * (1.0 + 0.1 * u)
    return float(np.mean(ndtr(-(155_900.0 / _factor_38(*x) - 350.0) / 35.0)))


# RP60: seven limits on five log-normals.
_MEANS_60, _SDS_60 = (2200.0, 2100.0, 2300.0, 2000.0, 1200.0), (220.0, 210.0, 230.0, 200.0, 480.0)


def _rp60(u: np.ndarray) -> np.ndarray:
    x1, x2, x3, x4, x5 = _log_normals(u, _MEANS_60, _SDS_60)
    all_half = np.minimum(np.minimum(x2, x3), x4) - 0.5 * x5
    whole = np.maximum(x4 - x5, np.minimum(x2, x3) - x5)
    return np.minimum(x1 - x5, np.maximum(all_half, whole))


def _truth_60() -> float:
    given = [_log_normal(mean, sd) for mean, sd in zip(_MEANS_60, _SDS_60, strict=True)]

    def stands(z: float) -> float:
        load = math.exp(given[4][0] + given[4][1] * z)
        below = [[ndtr((math.log(part * load) - m) / s) for part in (0.5, 1.0)] for m, s in given[:4]]
        kinds = [(half, whole - half, 1.0 - whole) for half, whole in below]
        total = 0.0
        for two, three, four in itertools.product(range(3), repeat=3):
            if min(two, three, four) >= 1 or four == 2 or min(two, three) == 2:
                total += kinds[1][two] * kinds[2][three] * kinds[3][four]
        return (1.0 - below[0][1]) * total

    return quad(lambda z: norm.pdf(z) * (1.0 - stands(z)), -9.0, 9.0, limit=400, epsabs=1e-12)[0]


# RP91: the first of its three limits lies beyond 70 standard deviations.
def _limits_91(x3, x4, x5):
    mises = np.sqrt(x3**2 + x4**2 - x3 * x4 + 3.0 * x5**2)
    return np.maximum(mises, np.abs(x4)) / 84_000.0


def _rp91(u: np.ndarray) -> np.ndarray:
    x1, x2 = 0.07433 + 0.005 * u[0], 0.1 + 0.01 * u[1]
    x3, x4, x5 = 13.0 + 60.0 * u[2], 4751.0 + 48.0 * u[3], -684.0 + 11.0 * u[4]
    first = 0.847 + 0.96 * x2 + 0.986 * x3 - 0.216 * x4 + 0.077 * x2**2 + 0.11 * x3**2 + 7.0 / 378.0 * x4**2
    first = first - x3 * x2 - 0.106 * x2 * x4 - 0.11 * x3 * x4
    return np.minimum(first, x1 / _limits_91(x3, x4, x5) - 1.0)


def _truth_91() -> float:
    nodes, weights = np.polynomial.hermite_e.hermegauss(40)
    weights = weights / weights.sum()
    a, b, c = np.meshgrid(nodes, nodes, nodes, indexing="ij")
    share = ndtr((_limits_91(13.0 + 60.0 * a, 4751.0 + 48.0 * b, -684.0 + 11.0 * c) - 0.07433) / 0.005)
    return float(np.einsum("ijk,i,j,k", share, weights, weights, weights))


# Two dimensions and closed forms.
def _rp22(u):
    return 2.5 - (u[0] + u[1]) / _ROOT2 + 0.1 * (u[0] - u[1]) ** 2


def _rp24(u):
    return 2.5 - 0.2357 * 3.0 * (u[0] - u[1]) + 0.00463 * (3.0 * (u[0] + u[1])) ** 4


def _rp25(u):
    return np.maximum(u[0] ** 2 - 8.0 * u[1] + 16.0, -16.0 * u[0] + u[1] + 32.0)


def _rp28(u):
    return (78_064.0 + 11_710.0 * u[0]) * (0.0104 + 0.00156 * u[1]) - 146.14


def _rp31(u):
    return 2.0 - u[1] + 256.0 * u[0] ** 4


def _rp33(u):
    return np.minimum(3.0 * math.sqrt(3.0) - u[0] - u[1] - u[2], 3.0 - u[2])


def _truth_33() -> float:
    beyond = quad(lambda z: norm.pdf(z) * norm.sf((3.0 * math.sqrt(3.0) - z) / _ROOT2), -9.0, 3.0, epsabs=1e-14)[0]
    return float(beyond + norm.sf(3.0))


def _rp35(u):
    return np.minimum(2.0 - u[1] + np.exp(-0.1 * u[0] ** 2) + (0.2 * u[0]) ** 4, 4.5 - u[0] * u[1])


def _rp53(u):
    x1, x2 = 1.5 + u[0], 2.5 + u[1]
    return np.sin(2.5 * x1) + 2.0 - (x1 * x1 + 4.0) * (x2 - 1.0) / 20.0


def _rp54(u):
    return -np.log(ndtr(-u)).sum(axis=0) - 8.951


def _rp55(u):
    apart = 2.0 * (ndtr(u[0]) - ndtr(u[1]))
    bent = 0.2 + 0.6 * apart**4
    edge = 5.0 / _ROOT2 - 2.2
    return np.minimum(np.minimum(bent - apart / _ROOT2, bent + apart / _ROOT2), edge - np.abs(apart))


def _rp57(u):
    lens = np.maximum(-(u[0] ** 2) + u[1] ** 3 + 3.0, 2.0 - u[0] - 8.0 * u[1])
    return np.minimum(lens, (u[0] + 3.0) ** 2 + (u[1] + 3.0) ** 2 - 4.0)


def _rp63(u):
    return 0.1 * (u[1:] ** 2).sum(axis=0) - 4.5 - u[0]


def _truth_63() -> float:
    return quad(lambda s: chi2.pdf(s, 99) * norm.sf(0.1 * s - 4.5), 20.0, 200.0, epsabs=1e-14, limit=400)[0]


def _rp75(u):
    return 3.0 - u[0] * u[1]


def _rp77(u):
    x1, x3 = 10.0 + 0.5 * u[0], 4.0 + u[2]
    return np.where(x3 <= 5.0, x1 - u[1] - x3, x3 - u[1])


def _truth_77() -> float:
    near = quad(lambda x: norm.pdf(x - 4.0) * norm.sf((10.0 - x) / math.hypot(0.5, 1.0)), -5.0, 5.0, epsabs=1e-16)[0]
    return near + quad(lambda x: norm.pdf(x - 4.0) * norm.sf(x), 5.0, 14.0, epsabs=1e-16)[0]


def _rp89(u):
    return np.minimum(8.0 - u[0] ** 2 - u[1], 6.0 - 0.2 * u[0] - u[1])


def _rp107(u):
    return 5.0 * math.sqrt(10.0) - u.sum(axis=0)


def _rp110(u):
    one = np.where(u[0] <= 3.5, 0.85 - 0.1 * u[0], 4.0 - u[0])
    return np.minimum(one, np.where(u[1] <= 2.0, 2.3 - u[1], 0.5 - 0.1 * u[1]))


def _truth_110() -> float:
    return float(1.0 - norm.cdf(4.0) * norm.cdf(5.0))


def _rp111(u):
    return 12.5 - np.abs(u[0] * u[1])


def _four_branches(u):
    bent, along = 3.0 + 0.1 * (u[0] - u[1]) ** 2, np.abs(u[0] + u[1]) / _ROOT2
    return np.minimum(bent - along, 7.0 / _ROOT2 - np.abs(u[0] - u[1]))


def _beam(u):
    mean, width = _log_normal(300.0, 30.0)
    return np.exp(mean + width * u[0]) - (75_000.0 + 5_000.0 * u[1]) / (100.0 * np.pi)


PROBLEMS = (
    Problem("RP8", 6, _rp8, 0.000784, _truth_8),
    Problem("RP14", 5, _rp14, 0.00077285, _truth_14),
    Problem("RP22", 2, _rp22, 0.004207305511),
    Problem("RP24", 2, _rp24, 0.00286),
    Problem("RP25", 2, _rp25, 4.148566e-5),
    Problem("RP28", 2, _rp28, 1.46e-7),
    Problem("RP31", 2, _rp31, 0.00322668121),
    Problem("RP33", 3, _rp33, 0.00257, _truth_33),
    Problem("RP35", 2, _rp35, 0.00347894632),
    Problem("RP38", 7, _rp38, 0.0081, _truth_38),
    Problem("RP53", 2, _rp53, 0.0313),
    Problem("RP54", 20, _rp54, 0.000998, lambda: float(gamma.cdf(8.951, 20.0))),
    Problem("RP55", 2, _rp55, 0.560014428),
    Problem("RP57", 2, _rp57, 0.0284),
    Problem("RP60", 5, _rp60, 0.0456, _truth_60),
    Problem("RP63", 100, _rp63, 0.000379, _truth_63),
    Problem("RP75", 2, _rp75, 0.00981929872),
    Problem("RP77", 3, _rp77, 2.87e-7, _truth_77),
    Problem("RP89", 2, _rp89, 0.00543),
    Problem("RP91", 5, _rp91, 0.000697, _truth_91),
    Problem("RP107", 10, _rp107, 2.92e-7, lambda: float(norm.sf(5.0))),
    Problem("RP110", 2, _rp110, 3.19e-5, _truth_110),
    Problem("RP111", 2, _rp111, 7.65e-7),
    Problem("four branches", 2, _four_branches, 0.00222279507),
    Problem("R-S", 2, lambda u: 2.0 + u[0] - u[1], 0.0786, lambda: float(norm.sf(_ROOT2))),
    Problem("axial stressed beam", 2, _beam, 0.02920),
)
