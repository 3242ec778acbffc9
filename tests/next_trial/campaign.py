"""One campaign: a log, its diagnosis, one of the trials it offers made at the made-up sea, and what that brought."""

import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.explanations import weighed
from missionplan.diagnosis.next_trial.belief import to_do
from missionplan.diagnosis.next_trial.experiment import Experiment
from missionplan.diagnosis.next_trial.leg_trials import LegTrials
from missionplan.diagnosis.next_trial.next_trial import Valuation, valuation
from missionplan.diagnosis.pipeline import run_pipeline
from missionplan.mission import Mission

from .sea import Truth, Vehicle, mission, sail, write_log
from .seen import choice_after, realised_information
from .voyage import Voyage, first_log_headings, mean_minutes

VEHICLE = Vehicle(sigma=0.02, fix=8.0)
VOYAGE = Voyage(distance=3000.0, radius=100.0, surfacing=480.0)
D_MAX, FIRST_LEG = 800.0, 100.0
"""The mission's d_max, and the legs of the first log [m]: short, so that it leaves much open."""
PATTERNS = ("one way", "there and back", "corner")
CAUSES = ("compass-bias", "speed-scale", "mean-current")
UNTROUBLED = 0.5
"""Share of the campaigns in which nothing is off: the prior of the diagnosis."""
TRIALS = 4000


@dataclass(frozen=True)
class Campaign:
    """What one trial of a campaign showed.

    Attributes
    ----------
    seed : int
    causes : str
        The truth.
    design : str
        The trial made.
    among : bool
        Whether the truth was among the sets considered.
    expected, gained : float
        Information about the truth [nats]; nan where it was not among the sets.
    saving, saving_error, saved : float
        Predicted saving with its error, and what the choice made saved [min; of dives % of the loss expected before];
        nan where it was not found.
    weight : float
        Of the campaign in every mean.
    said_before, said, right : float
        Probability that the crew does what is right about the vehicle, said without the trial and of it beforehand, and
        1 or 0 as it then does; nan where it was not found.
    """

    seed: int
    causes: str
    design: str
    among: bool
    expected: float
    gained: float
    saving: float
    saving_error: float
    saved: float
    weight: float = 1.0
    said_before: float = float("nan")
    said: float = float("nan")
    right: float = float("nan")


def draw_truth(rng: np.random.Generator) -> tuple[tuple[str, ...], Truth]:
    """Draw what is off: nothing in half of the campaigns, as the diagnosis expects before, else one of three causes."""
    if rng.random() < UNTROUBLED:
        return (), Truth()
    cause, size = str(rng.choice(CAUSES)), float(rng.standard_normal())
    if cause == "compass-bias":
        return (cause,), Truth(compass=np.radians(4.0) * size)
    if cause == "speed-scale":
        return (cause,), Truth(pace=0.06 * size)
    return (cause,), Truth(current=(0.08 * size, 0.08 * float(rng.standard_normal())))


def parameters_of(causes: tuple[str, ...], truth: Truth) -> np.ndarray:
    """Parameters in the order of the package's effects."""
    known = {
        "compass-bias": [truth.compass],
        "speed-scale": [truth.pace],
        "mean-current": list(truth.current),
    }
    return np.array([value for cause in causes for value in known[cause]])


def made(seed: int) -> list[Campaign]:
    """Make one campaign, with one trial."""
    rng = np.random.default_rng(seed)
    causes, truth = draw_truth(rng)
    count = int(rng.integers(8, 15))
    headings = first_log_headings(str(rng.choice(PATTERNS)), count)
    plan = mission(VEHICLE, VOYAGE.distance, D_MAX, VOYAGE.surfacing, VOYAGE.radius)
    loaded = Mission.from_data(plan)
    with tempfile.TemporaryDirectory() as folder:
        rows = sail(truth, VEHICLE, headings, np.full(count, FIRST_LEG), 0.0, rng)
        explanations = weighed(loaded, write_log(Path(folder) / "first", VEHICLE, rows), seed, 1)
        bound = explanations[0].bound
        found = run_pipeline(bound.model)
        value = valuation(explanations, found, 1.0, seed)
        result = value.result()
        offered = [each for each in value.candidates() if each.trial is not None]
        chosen = offered[int(rng.integers(len(offered)))]
        courses, lengths = legs_of(chosen.trial)
        rows += sail(truth, VEHICLE, courses, lengths, 90_000.0, rng)  # one log: so few legs alone are refused
        data = read_transit(write_log(Path(folder) / "both", VEHICLE, rows), loaded)
        data = data.subset(np.arange(data.n) >= count)
    kind = value.kind
    assert isinstance(kind, LegTrials)
    experiment = Experiment(
        tuple(each.explanation for each in value.believed), tuple(kind.predicted(data, value.believed))
    )
    y = data.velocity_error.ravel()
    sets = [each.causes for each in value.believed]
    among = causes in sets
    planned = next(each for each in result.designs if each.name == chosen.name)
    parameters = parameters_of(causes, truth)
    gained = realised_information(experiment, sets.index(causes), parameters, y) if among else float("nan")
    one = Campaign(
        seed=seed,
        causes="+".join(causes) or "nothing",
        design=chosen.name,
        among=among,
        expected=planned.information,
        gained=gained,
        saving=planned.saving,
        saving_error=planned.saving_error,
        saved=saved(value, experiment, y, truth, seed),
        said_before=result.right,
        said=planned.right,
        right=float(done_about_vehicle(sets, experiment.probabilities(y[None])[0]) == to_do(causes)),
    )
    return [one]


def done_about_vehicle(sets: Sequence[tuple[str, ...]], probabilities: np.ndarray) -> frozenset[str]:
    """What the crew does after a trial: what the sets of causes ask for that have the most probability together."""
    asked = [to_do(causes) for causes in sets]
    return max(asked, key=lambda thing: sum(p for own, p in zip(asked, probabilities, strict=True) if own == thing))


def saved(value: Valuation, experiment: Experiment, y: np.ndarray, truth: Truth, seed: int) -> float:
    """Minutes that the choice after the trial saves at sea, over the choice before."""
    problem = value.losses.problem
    simulated = experiment.data(value.draws, np.random.default_rng(seed + 1))
    after = choice_after(problem, experiment.summaries(simulated), experiment.summaries(y[None]))
    if after == problem.choice:
        return 0.0
    costs = [
        mean_minutes(
            truth, VEHICLE, VOYAGE, float(problem.alternatives[index]), TRIALS, np.random.default_rng(seed + 2)
        )
        for index in (problem.choice, after)
    ]
    return costs[0] - costs[1]


def legs_of(trial: object) -> tuple[np.ndarray, np.ndarray]:
    """Headings [rad] and lengths [m] of the legs of a trial's mission file, as a crew would read them."""
    assert isinstance(trial, dict)
    transits = [entry["transit"] for entry in trial["phases"]]
    places = [transits[0]["from"], *(each["to"] for each in transits)]
    corners = np.array([[float(value.removesuffix(" m")) for value in place] for place in places]).T
    steps = np.diff(corners, axis=1)
    return np.arctan2(steps[0], steps[1]), np.hypot(*steps)


def recorded(folder: Path, seed: int, make: Callable[[int], list[Campaign]]) -> list[Campaign]:
    """Make a campaign, or read it where it was made before: one entry for each trial made."""
    file = folder / f"{seed}.json"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps([asdict(each) for each in make(seed)]), encoding="utf-8")
    return [Campaign(**each) for each in json.loads(file.read_text(encoding="utf-8"))]
