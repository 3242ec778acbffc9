"""Systems with two to five known ways to fail, drawn at random, whose probabilities follow from closed forms.

Each way has a probability between 10⁻⁸ and 10⁻³ and is met by an input, or two, of its own: normal, log-normal, uniform
(near its bound), of a heavy tail, a distance of two normals, correlated with the way before, or a discrete cause under
which some trials fail. Beside them stand inputs that come near to a limit and never reach it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import quad
from scipy.special import ndtr, ndtri
from scipy.stats import norm

from missionplan.montecarlo.rare_events import Key
from missionplan.montecarlo.rare_events.strata import DiscreteValue, StrataView, TrialMargins

Margin = Callable[[StrataView], np.ndarray]
KINDS = ("normal", "log-normal", "uniform", "heavy tail", "distance", "correlated", "discrete")


@dataclass
class System:
    """Independent ways to fail.

    Attributes
    ----------
    margins : list of callable
        Of each way, then of what never fails.
    probabilities : list of float
        Of each way.
    survival : float
        Probability that none happens.
    values : mapping
        Of its discrete quantities.
    """

    margins: list[Margin] = field(default_factory=list)
    probabilities: list[float] = field(default_factory=list)
    survival: float = 1.0
    values: dict[Key, list[DiscreteValue]] = field(default_factory=dict)

    def __call__(self, view: StrataView) -> TrialMargins:
        """Run trials."""
        margins = np.array([margin(view) for margin in self.margins])
        return TrialMargins(margins, (margins <= 0.0).any(axis=0))

    @property
    def truth(self) -> float:
        """Probability that any happens."""
        return 1.0 - self.survival


def _monotone(name: str, probability: float, transform: Callable[[np.ndarray], np.ndarray]) -> Margin:
    """Fails where an input, a transform of one normal, lies above its quantile."""
    limit = float(transform(np.array(norm.isf(probability))))
    return lambda view: limit - transform(view.cell(name)[0])


def _distance(name: str, probability: float) -> Margin:
    """Fails where a place with normal errors lies beyond a radius (Rayleigh)."""
    radius = math.sqrt(-2.0 * math.log(probability))
    return lambda view: radius - np.hypot(*view.cell(name, 0, 2))


def _transform(kind: str, rng: np.random.Generator) -> Callable[[np.ndarray], np.ndarray]:
    if kind == "log-normal":
        factor = math.exp(rng.uniform(0.2, 1.5))
        return lambda z: factor**z
    if kind == "uniform":
        return ndtr
    if kind == "heavy tail":
        power = rng.uniform(1.5, 4.0)
        return lambda z: ndtr(-z) ** (-1.0 / power)  # Pareto
    return lambda z: z


def drawn(seed: int) -> System:
    """Draw a system."""
    rng = np.random.default_rng([44, seed])
    system = System()
    for number in range(int(rng.integers(2, 6))):
        kind, probability = str(rng.choice(KINDS)), 10.0 ** rng.uniform(-8.0, -3.0)
        name = f"way {number}"
        if kind == "correlated":
            _correlated(system, name, probability, rng)
        elif kind == "discrete":
            _discrete(system, name, probability, rng)
        elif kind == "distance":
            _independent(system, probability, _distance(name, probability))
        else:
            _independent(system, probability, _monotone(name, probability, _transform(kind, rng)))
    for number in range(int(rng.integers(0, 3))):
        near = 1.0 + 10.0 ** rng.uniform(-4.0, -1.0)
        system.margins.append(lambda view, near=near, number=number: near - ndtr(view.cell(f"near {number}")[0]))
    return system


def _independent(system: System, probability: float, margin: Margin) -> None:
    system.margins.append(margin)
    system.probabilities.append(probability)
    system.survival *= 1.0 - probability


def _correlated(system: System, name: str, probability: float, rng: np.random.Generator) -> None:
    """Two ways whose normals are correlated, the second seen through a skewed transform."""
    other, rho = probability * 10.0 ** rng.uniform(-1.0, 1.0), rng.uniform(-0.9, 0.95)
    factor, across = math.exp(rng.uniform(0.2, 1.0)), math.sqrt(1.0 - rho * rho)
    one, two = norm.isf(probability), norm.isf(other)
    system.margins.append(lambda view: one - view.cell(name)[0])
    system.margins.append(
        lambda view: factor**two - factor ** (rho * view.cell(name)[0] + across * view.cell(f"{name}, across")[0])
    )
    both = quad(lambda z: norm.pdf(z) * norm.sf((two - rho * z) / across), one, one + 8.0, epsabs=0.0, limit=200)[0]
    system.probabilities += [probability, other]
    system.survival *= 1.0 - (probability + other - both)


def _discrete(system: System, name: str, probability: float, rng: np.random.Generator) -> None:
    """A cause of known probability, under which a share of the trials fail."""
    share = min(10.0 ** rng.uniform(math.log10(probability), -0.5), 0.3)
    limit = float(ndtri(probability / share))

    def margin(view: StrataView) -> np.ndarray:
        holds = ndtr(view.cell(f"{name}, cause")[0]) < share
        return np.where(holds, view.cell(name)[0] - limit, 10.0)

    key = (f"{name}, cause", 0)
    system.values[key] = [
        DiscreteValue(key[0], "yes", (0.0, share)),
        DiscreteValue(key[0], "no", (share, 1.0)),
    ]
    _independent(system, probability, margin)
