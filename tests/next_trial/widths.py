"""Time that each shape of a trial takes to know a cause as well as a star: ``python -m tests.next_trial.widths``.

After the same short log, of each shape as many legs as it takes to reach the standard deviation that one star of six
legs at the mission's d_max reaches.
"""

import tempfile
from pathlib import Path

import numpy as np

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.explanations import weighed
from missionplan.diagnosis.next_trial.belief import Believed
from missionplan.diagnosis.next_trial.experiment import Experiment
from missionplan.diagnosis.next_trial.leg_trials import SHAPES, LegTrials
from missionplan.diagnosis.next_trial.prediction import Explanation
from missionplan.mission import Mission

from .sea import Truth, Vehicle, mission, sail, write_log

VEHICLE, D_MAX, SURFACING, DISTANCE = Vehicle(), 800.0, 60.0, 3000.0
CAUSES = ("compass-bias", "speed-scale", "mean-current")
MOST_LEGS = 120
STAR = "a star of six legs"


def legs_data(headings: np.ndarray, length: float, folder: Path, plan: Mission):
    """Legs of such headings and length as the package reads them."""
    rows = sail(Truth(), VEHICLE, headings, np.full(len(headings), length), 90_000.0, np.random.default_rng(1))
    return read_transit(write_log(folder / f"{len(headings)}-{length:.0f}", VEHICLE, rows), plan)


def width(kind: LegTrials, believed: Believed, data) -> float:
    """Standard deviation of the cause's first parameter after these legs, or of a current's worse component."""
    experiment = Experiment((believed.explanation,), tuple(kind.predicted(data, [believed])))
    return float(np.sqrt(np.diag(experiment.covariances[0]).max()))


def main() -> None:
    """Print a table: minutes to the star's width, by cause, shape and length over d_max."""
    plan = Mission.from_data(mission(VEHICLE, DISTANCE, D_MAX, SURFACING))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = sail(Truth(), VEHICLE, np.radians(90.0) * np.arange(8), np.full(8, 100.0), 0.0, np.random.default_rng(2))
        (one,) = weighed(plan, write_log(folder / "first", VEHICLE, rows), 1, 1)
        kind = LegTrials(one.bound)
        for cause in CAUSES:
            fit = one.bound.model.fit((cause,))
            posterior = kind.posterior(one.bound, fit)
            known = Explanation(1.0, posterior.mean[posterior.places], posterior.covariance)
            own = tuple(one.bound.model_coordinates[place] for place in posterior.places)
            believed = Believed((cause,), one.bound, fit, posterior, known, own, plan)
            whole = legs_data(np.radians(np.resize(SHAPES[STAR], 12)), D_MAX, folder, plan).subset(np.arange(6))
            target = width(kind, believed, whole)
            before = float(np.sqrt(np.diag(known.covariance).max()))
            print(f"{cause}: {before:.4g} before, {target:.4g} after a star at d_max ({6 * minutes(D_MAX):.0f} min)")
            for shape in (*SHAPES, "one long leg"):
                told = [f"{time_to(kind, believed, shape, factor, target, folder, plan)}" for factor in (0.5, 1.0, 2.0)]
                print(f"  {shape}: {' | '.join(told)} min with legs of 0.5 | 1 | 2 d_max", flush=True)


def minutes(length: float) -> float:
    """Time of a leg with its surfacing [min]."""
    return (length / VEHICLE.speed + SURFACING) / 60.0


def time_to(
    kind: LegTrials, believed: Believed, shape: str, factor: float, target: float, folder: Path, plan: Mission
) -> str:
    """Minutes of the fewest legs that reach a width; a dash where a great many do not."""
    length = factor * D_MAX
    headings = SHAPES.get(shape, (0.0,))
    data = legs_data(np.radians(np.resize(headings, MOST_LEGS)), length, folder, plan)
    low, high = 0, MOST_LEGS
    if width(kind, believed, data) > target * 1.001:
        return "–"
    while high - low > 1:
        middle = (low + high) // 2
        if width(kind, believed, data.subset(np.arange(middle))) <= target * 1.001:
            high = middle
        else:
            low = middle
    return f"{high * minutes(length):.0f}"


if __name__ == "__main__":
    main()
