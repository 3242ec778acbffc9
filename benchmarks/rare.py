"""Trials until a rare failure's probability is known to 10 %, beside a plain Monte Carlo, and the time of one run.

The counts do not depend on the machine. The mission goes 800 m to its goal in four legs of 300 m at most.
"""

import time

from benchmarks.common import Options, Row, Section, duration
from missionplan.mission import Mission
from missionplan.studies.rare_failure.find_rare_failure import find_rare_failure

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
