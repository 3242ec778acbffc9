"""One campaign: a log, its diagnosis, one of the trials it offers made at the made-up sea, and what that brought.

A prediction is a mean over what is believed, so that what is hidden comes as often, and as large, as the diagnosis expects
(`tests.calibration.truths`). Causes about which something is to be done are hidden more often, and weigh less. Eight
effects on legs are never hidden: what is believed of them before is what trials then settle more than they are said to.
"""

import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.explanations import weighed
from missionplan.diagnosis.next_trial import Valuation, valuation
from missionplan.diagnosis.next_trial.belief import to_do
from missionplan.diagnosis.next_trial.experiment import Experiment
from missionplan.diagnosis.next_trial.leg_trials import LegTrials
from missionplan.diagnosis.pipeline import run_pipeline
from missionplan.mission import Mission
from missionplan.results.decision import FAILURE_LOSS
from tests.calibration import truths
from tests.calibration.voyages import Truth, sail, write
from tests.calibration.voyages import Voyage as Legs

from .sea import Vehicle, mission
from .seen import choice_after, realised_information
from .voyage import Voyage, first_log_headings, mean_loss, on_a_day

VEHICLE = Vehicle(sigma=0.02, fix=8.0)
VOYAGE = Voyage(distance=3000.0, radius=100.0, surfacing=480.0)
LATITUDE = 37.0
"""As the mission has it [deg]."""
D_MAX, FIRST_LEG = 800.0, 100.0
"""The mission's d_max, and the legs of the first log [m]: short, so that it leaves much open."""
LATER = 90_000.0
"""When the trial begins [s]."""
PATTERNS = ("one way", "there and back", "corner")
HIDDEN = {"nothing": 0.2, "vehicle": 0.5, "else": 0.3}
"""Shares of the campaigns in which nothing is off, something is to be done about the vehicle, or something else is off."""
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


def draw_causes(rng: np.random.Generator) -> tuple[tuple[str, ...], float]:
    """Draw what is off, and its weight: its share in the prior over that in the campaigns."""
    sets, prior = truths.prior()
    kinds = np.array(["nothing" if not causes else "vehicle" if to_do(causes) else "else" for causes in sets])
    kind = str(rng.choice(list(HIDDEN), p=list(HIDDEN.values())))
    share = np.where(kinds == kind, prior, 0.0)
    return sets[int(rng.choice(len(sets), p=share / share.sum()))], float(share.sum()) / HIDDEN[kind]


def parameters_of(coordinates: Sequence[Coordinate], truth: Truth) -> np.ndarray:
    """Parameters in the order of the package's coordinates."""
    ends = {"cosine": ".cosine", "sine": ".sine"}
    return np.array([truth.parameters[f"{c.effect}.{c.name}{ends.get(c.kind, '')}"] for c in coordinates])


def made(seed: int) -> list[Campaign]:
    """Make one campaign, with one trial."""
    rng = np.random.default_rng(seed)
    causes, weight = draw_causes(rng)
    truth = truths.truth(causes, rng, LATITUDE)
    count = int(rng.integers(8, 15))
    headings = first_log_headings(str(rng.choice(PATTERNS)), count)
    loaded = Mission.from_data(mission(VEHICLE, VOYAGE.distance, D_MAX, VOYAGE.surfacing, VOYAGE.radius))
    with tempfile.TemporaryDirectory() as folder:
        rows = sailed(truth, Plan(headings, np.full(count, FIRST_LEG), np.full(count, VEHICLE.speed)), 0.0, rng)
        explanations = weighed(loaded, write(Path(folder) / "first", rows, VEHICLE.fix), seed, 1)
        found = run_pipeline(explanations[0].bound.model)
        value = valuation(explanations, found, 1.0, seed)
        possible = map(value.designed, rng.permutation(len(value.kind.designs)).tolist())
        chosen = next(each for each in possible if each is not None)
        more = sailed(truth, legs_of(chosen.trial), LATER, rng)
        rows += [[count + row[0], *row[1:]] for row in more]  # one log: so few legs alone are refused
        data = read_transit(write(Path(folder) / "both", rows, VEHICLE.fix), loaded)
        data = data.subset(np.arange(data.n) >= count)
    kind = value.kind
    assert isinstance(kind, LegTrials)
    experiment = Experiment(
        tuple(each.explanation for each in value.believed), tuple(kind.predicted(data, value.believed))
    )
    y = data.velocity_error.ravel()
    sets = [each.causes for each in value.believed]
    which = next((index for index, own in enumerate(sets) if set(own) == set(causes)), None)
    gained = float("nan")
    if which is not None:
        parameters = parameters_of(value.believed[which].coordinates, truth)
        gained = realised_information(experiment, which, parameters, y)
    planned, _ = value.valued(chosen)
    one = Campaign(
        seed=seed,
        causes="+".join(causes) or "nothing",
        design=chosen.name,
        among=which is not None,
        expected=planned.information,
        gained=gained,
        saving=planned.saving,
        saving_error=planned.saving_error,
        saved=saved(value, experiment, y, truth, seed),
        weight=weight,
        said_before=value.right(),
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

    def loss(choice: int) -> float:
        failed = value.losses.failure * (1.0 + 1.0 / FAILURE_LOSS)
        d_max, rng = float(problem.alternatives[choice]), np.random.default_rng(seed + 2)
        return mean_loss(truth, VEHICLE, VOYAGE, d_max, TRIALS, failed, rng)

    return loss(problem.choice) - loss(after)


@dataclass(frozen=True)
class Plan:
    """Legs: headings [rad], lengths [m] and speeds [m/s], shape (n,) each."""

    headings: np.ndarray
    lengths: np.ndarray
    speeds: np.ndarray


def sailed(truth: Truth, plan: Plan, begins: float, rng: np.random.Generator) -> list[list[float]]:
    """Sail legs from a time on [s]: the rows of a log."""
    legs = Legs(
        plan.headings, plan.lengths / plan.speeds, 60.0, plan.speeds, VEHICLE.sigma, VEHICLE.fix, LATITUDE, begins
    )
    return sail(legs, on_a_day(truth, rng), rng)


def legs_of(trial: object) -> Plan:
    """Legs of a trial's mission file, as a crew would read them."""
    assert isinstance(trial, dict)
    transits = [entry["transit"] for entry in trial["phases"]]
    places = [transits[0]["from"], *(each["to"] for each in transits)]
    corners = np.array([[float(value.removesuffix(" m")) for value in place] for place in places]).T
    steps = np.diff(corners, axis=1)
    speeds = np.array([float(each["speed"].removesuffix(" m/s")) for each in transits])
    return Plan(np.arctan2(steps[0], steps[1]), np.hypot(*steps), speeds)


def recorded(folder: Path, seed: int, make: Callable[[int], list[Campaign]]) -> list[Campaign]:
    """Make a campaign, or read it where it was made before: one entry for each trial made."""
    file = folder / f"{seed}.json"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps([asdict(each) for each in make(seed)]), encoding="utf-8")
    return [Campaign(**each) for each in json.loads(file.read_text(encoding="utf-8"))]
