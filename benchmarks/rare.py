"""Rare failures: how many trials they take beside a plain Monte Carlo, and whether what is found is true.

``python -m benchmarks rare`` counts trials, which do not depend on the machine. ``python -m benchmarks.rare`` searches
problems and systems of known probability, many times each; about five minutes of one core for 200 seeds.
"""

import argparse
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from benchmarks.common import Options, Row, Section, duration
from benchmarks.rare_problems import PROBLEMS, Problem
from benchmarks.rare_ways import drawn
from missionplan.mission import Mission
from missionplan.montecarlo.rare_events import Key, NormalPopulation
from missionplan.montecarlo.rare_events.failure_search import FailureSearch, Found, find
from missionplan.montecarlo.rare_events.strata import (
    DiscreteValue,
    Model,
    ReliabilityIndices,
    StrataView,
    TrialMargins,
    strata,
)
from missionplan.studies.rare_failure import find_rare_failure

TARGET = 200_000
"""Trials by which a probability of about 10⁻⁶ has to be known to `VARIATION`."""
VARIATION = 0.10


def four_legs(sigma: float) -> Mission:
    """Return a mission that misses its goal only by the errors of its legs [m/s]."""
    transit = {
        "from": ["0 m", "0 m"],
        "to": ["800 m", "0 m"],
        "speed": "1.5 m/s",
        "d_max": "300 m",
        "arrival_radius": "15 m",
    }
    navigation = {"velocity_error": {"sigma": f"{sigma} m/s"}, "surfacing_time": "60 s", "max_legs": 4}
    return Mission.from_data({"name": "Four legs", "navigation": navigation, "phases": [{"transit": transit}]})


def _row(sigma: float, options: Options) -> Row:
    mission = four_legs(sigma)
    started = time.perf_counter()
    found = find_rare_failure(mission, trials=1_000_000 // options.shrink, seed=1)
    seconds = time.perf_counter() - started
    probability, ran = found.probability.value, found.provenance.trials
    plain = (1.0 - probability) / (VARIATION**2 * probability)
    asked = probability < 1e-5
    return Row(
        f"four legs, σ_v = {sigma:g} m/s, p = {probability:.2g}",
        f"{ran / 1e3:.0f} 000 trials, {100.0 * found.variation:.1f} %, {duration(seconds)}",
        f"{plain / 1e6:.3g} million",
        f"1/{plain / ran:.0f}",
        f"≤ {TARGET / 1e3:.0f} 000 trials, 10 %" if asked else "",
        (ran <= TARGET and found.variation <= VARIATION) if asked else None,
    )


def compare(options: Options) -> Section:
    """Compare the trials that both ways need."""
    return Section(tuple(_row(sigma, options) for sigma in (0.097, 0.12)), ("numpy",))


# Whether what is found is true.


def search(model: Model, seed: int, values: Mapping[Key, Sequence[DiscreteValue]] | None = None) -> Found[None]:
    """Search a model as `simulate --rare` does a mission."""
    plain = model(StrataView(NormalPopulation(2048, np.random.default_rng(1_000_000 + seed))))
    wanted = FailureSearch(model, strata(values or {}), ReliabilityIndices.of(plain), seed, lambda view, weights: None)
    return find(wanted, lambda task, items: (task(item) for item in items), variation=VARIATION, most_trials=1_000_000)


def _holds(found: Found[None], truth: float) -> tuple[bool, bool]:
    """Whether the 95 % interval holds the truth, and whether it lies below it."""
    return found.estimate.low <= truth <= found.estimate.high, found.estimate.high < truth


def _model_of(problem: Problem) -> Model:
    def model(view: StrataView) -> TrialMargins:
        margins = problem.state(view.cell("u", 0, problem.dimensions))
        return TrialMargins(margins[None], margins <= 0.0)

    return model


def searched(problem: Problem, seeds: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Search a problem so often.

    Returns
    -------
    truth, ratios, judged : float, array, array
        Its probability, that found over it, and whether intervals hold it and lie wholly below it, shape (2,).
    """
    truth = problem.probability()
    found = [search(_model_of(problem), seed) for seed in range(seeds)]
    ratios = np.array([each.estimate.value for each in found]) / truth
    return truth, ratios, np.mean([_holds(each, truth) for each in found], axis=0)


def problems(seeds: int, only: str | None = None) -> Iterator[str]:
    """Yield a line for each problem of the literature, and one for all."""
    ratios, held = [], []
    for problem in PROBLEMS:
        if only is not None and only != problem.name:
            continue
        truth, ratio, (holds, below) = searched(problem, seeds)
        ratios.append(ratio)
        held.append(holds)
        yield (
            f"{problem.name:20} p = {truth:.5g} (published {problem.published:.4g}): mean {ratio.mean():.4f} ± "
            f"{_error(ratio):.4f}, holds {holds:.3f}, wholly below {below:.3f}"
        )
    pooled = np.concatenate(ratios)
    off = [abs(ratio.mean() - 1.0) / _error(ratio) for ratio in ratios]
    yield (
        f"{len(ratios)} problems × {seeds} seeds: mean ratio {pooled.mean():.4f} ± "
        f"{math.sqrt(sum(_error(ratio) ** 2 for ratio in ratios)) / len(ratios):.4f} (asked 1 ± 0.01), "
        f"{sum(ratio.mean() < 1.0 for ratio in ratios)} below 1, furthest {max(off):.1f} standard errors; "
        f"intervals hold {np.mean(held):.3f} (least {min(held):.3f}, most {max(held):.3f})"
    )


def _error(values: np.ndarray) -> float:
    return float(np.std(values, ddof=1) / math.sqrt(values.size)) if values.size > 1 else math.inf


def searched_systems(seeds: int, systems: int = 100) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Search random systems with several known ways to fail, one after the other.

    Returns
    -------
    ratios, judged, parts : array
        Probability found over the true one, shape (seeds,); whether each interval holds it and lies wholly below it,
        shape (seeds, 2); and the same ratio of each way above a tenth of the whole.
    """
    ratios, judged, parts = [], [], []
    for seed in range(seeds):
        system = drawn(seed % systems)
        found = search(system, seed, system.values)
        ratios.append(found.estimate.value / system.truth)
        judged.append(_holds(found, system.truth))
        large = [way for way, each in enumerate(system.probabilities) if each > 0.1 * system.truth]
        parts += [found.probability(way) / system.probabilities[way] for way in large]
    return np.array(ratios), np.array(judged), np.array(parts)


MISSED = 0.1
"""Of its probability, below which a way counts as missed."""


def ways(seeds: int, systems: int = 100) -> Iterator[str]:
    """Yield what was found of random systems with several known ways to fail."""
    ratio, judged, parts = searched_systems(seeds, systems)
    holds, below = judged.mean(axis=0)
    yield (
        f"{min(systems, seeds)} systems, {seeds} searches: mean ratio {ratio.mean():.4f} ± {_error(ratio):.4f}, median "
        f"{np.median(ratio):.3f} ({ratio.min():.2f}–{ratio.max():.2f}); intervals hold {holds:.3f} (asked 0.92 to "
        f"0.98), wholly below {below:.3f}; {np.count_nonzero(parts < MISSED)} of {parts.size} ways above a tenth "
        f"missed; a way over its truth {parts.mean():.3f} ({parts.min():.2f}–{parts.max():.2f})"
    )


KINDS: Mapping[str, Callable[..., Iterator[str]]] = {"problems": problems, "ways": ways}


def main() -> None:
    """Search problems and systems of known probability, and print what was found beside the truth."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.rare", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"{', '.join(KINDS)}; default: all")
    parser.add_argument("--seeds", type=int, default=200, help="searches of each problem, and of all systems")
    parser.add_argument("--systems", type=int, default=100, help="that are drawn at random")
    parser.add_argument("--only", help="one problem, by its name")
    asked = parser.parse_args()
    if unknown := set(asked.kinds) - set(KINDS):
        parser.error(f"no {', '.join(unknown)}; there are {', '.join(KINDS)}")
    options: dict[str, dict[str, object]] = {"problems": {"only": asked.only}, "ways": {"systems": asked.systems}}
    for name in asked.kinds or KINDS:
        started = time.process_time()
        for line in KINDS[name](asked.seeds, **options[name]):
            print(line, flush=True)
        print(f"{name}: {duration(time.process_time() - started)} of one core\n", flush=True)


if __name__ == "__main__":
    main()
