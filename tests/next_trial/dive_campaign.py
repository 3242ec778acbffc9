"""One campaign of dives: hidden dives, their diagnosis, trials of those it offers made, and what each brought.

A prediction is a mean over what is believed, so that what is hidden has to come as often, and as large, as the diagnosis
expects: nothing with a weight of a half, else one cause of the catalogue, its size from the same heavy-tailed
distribution. Causes whose size the hidden dives and the catalogue define alike are drawn, and the others struck from what
is believed, which leaves the odds of the rest as they are.
"""

import csv
import math
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import islice
from pathlib import Path

import numpy as np
import yaml

from missionplan.datasets.dives import read_descent
from missionplan.diagnosis.dives.preparation import DiveLog, prepare_dives
from missionplan.diagnosis.explanations import weighed
from missionplan.diagnosis.next_trial import Valuation
from missionplan.diagnosis.next_trial.belief import Believed, believe, possible_fits
from missionplan.diagnosis.next_trial.dive_trials import DiveTrials
from missionplan.diagnosis.next_trial.experiment import Experiment, drawn, value_of_information
from missionplan.diagnosis.next_trial.prediction import Explanation, Prediction
from missionplan.diagnosis.pipeline import run_pipeline
from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.trial_block import run_block
from tests.hidden_effects.dives.catalogue import CATALOGUE
from tests.hidden_effects.dives.dynamics import Dive, DiveEffect
from tests.hidden_effects.dives.files import measure, mission_files
from tests.hidden_effects.dives.trials import Nuisances, Plan, conditions_of, draw_nuisances, draw_plan

from .campaign import Campaign
from .seen import choice_after, realised_information

DIVES, DRAWS, TRIALS = 2, 2000, 1000
"""Dives of the first log; draws of which the expected information is the mean; missions of which the true losses are."""
TRIED = 4
"""Trials made after each first log, drawn from those offered."""
VALUED_EVERY = 4
"""Of so many campaigns the savings of one are found too: half of a campaign's time."""
UNTROUBLED, HIDDEN = 0.5, 0.85
"""Share of the prior in which nothing is off; share of the campaigns in which a cause is hidden, where little is at stake without one; they weigh as in the prior."""
SCENARIO, DOF = "single", 3.0
"""Nuisances; degrees of freedom of the sizes' distribution."""
USUAL = {
    "drag-bias": 0.3,
    "line-payout": 0.2,
    "trapped-gas": 1.5,
    "added-mass": 0.4,
    "sensor-lag": 0.5,
    "clock-offset": 0.5,
    "depth-scale": 0.06,
    "vertical-current": 0.12,
}
"""Usual sizes of causes [SI; the lift of gas in N], as docs/add-an-effect.md has them."""
LARGEST = {"drag-bias": 0.6, "trapped-gas": 0.5, "depth-scale": 0.4, "vertical-current": 0.4}
"""Sizes beyond which the hidden dives do not go down, or are no dives; of gas a share of the anchor's weight."""
UNITS = {"line-payout": "s/m", "trapped-gas": "N", "sensor-lag": "s", "clock-offset": "s", "vertical-current": "m/s"}


@dataclass(frozen=True)
class _Sea:
    """What is hidden, and what makes dives there."""

    plan: Plan
    noise: Nuisances
    names: tuple[str, ...]
    effects: list[DiveEffect]
    parameters: dict[str, float]
    told: dict

    @property
    def weight(self) -> float:
        """Share of such campaigns as the diagnosis expects them, over that of those made."""
        return (1.0 - UNTROUBLED) / HIDDEN if self.names else UNTROUBLED / (1.0 - HIDDEN)

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "_Sea":
        plan = draw_plan(rng, SCENARIO, ())
        plan = replace(plan, dives=plan.dives[:DIVES], vehicle_form="inline")
        noise = draw_nuisances(rng, SCENARIO)
        names, effects, parameters = _draw_cause(plan, rng)
        told, _ = mission_files(plan, rng)
        _set_decision(told, plan, rng)
        return cls(plan, noise, names, effects, parameters, told)

    def log(self, plan: Plan, rng: np.random.Generator) -> Path:
        """Make the dives of a plan; the folder of the log is the caller's to delete."""
        return _written(Path(tempfile.mkdtemp()), *measure(plan, self.noise, self.effects, rng))


@dataclass(frozen=True)
class _Known:
    """What is believed after the first log, and what that makes of trials."""

    sea: _Sea
    mission: Mission
    kind: DiveTrials
    believed: tuple[Believed, ...]
    truth: int
    seed: int

    @cached_property
    def value(self) -> Valuation:
        return Valuation.of(self.kind, self.believed, self.seed)

    @cached_property
    def losses(self) -> np.ndarray:
        return _true_losses(self.value, self.sea.told, self.sea.parameters)

    def campaign(self, design: int, rng: np.random.Generator) -> Campaign | None:
        """Make a trial; None where its log is refused: nothing is learned."""
        logs = self._made(design, rng)
        if logs is None:
            return None
        planned, made_trial = self.kind.predictions(design, self.believed), self.kind.predicted(logs, self.believed)
        known, y = self._of_strengths(planned), np.concatenate([log.depth for log in logs])
        draws = drawn(known.explanations, [DRAWS // len(self.believed)] * len(self.believed), rng)
        expected = known.expected_information(draws, known.data(draws, rng))
        gained = realised_information(self._of_strengths(made_trial), self.truth, self._strengths, y)
        valued = self.seed % VALUED_EVERY == 0
        saving = self._saving(self._experiment(planned), self._experiment(made_trial), y) if valued else [math.nan] * 3
        name = self.kind.designs[design]
        return Campaign(self.seed, _words(self.sea.names), name, True, expected, gained, *saving, self.sea.weight)

    def _saving(self, planned: Experiment, made_trial: Experiment, y: np.ndarray) -> list[float]:
        """Saving predicted, its error, and what the choice made saves [% of the loss expected before]."""
        problem, generator = self.value.losses.problem, partial(np.random.default_rng, self.seed + 1)
        saving = value_of_information(problem, planned.summaries(planned.data(self.value.draws, generator())))
        simulated = made_trial.summaries(made_trial.data(self.value.draws, generator()))
        after = choice_after(problem, simulated, made_trial.summaries(y[None]))
        saved = float(self.losses[problem.choice] - self.losses[after]) if after != problem.choice else 0.0
        percent = 100.0 / float(problem.expected[problem.choice])
        return [percent * saving.mean, percent * saving.error, percent * saved]

    def _made(self, design: int, rng: np.random.Generator) -> tuple[DiveLog, ...] | None:
        folder = self.sea.log(_dived(self.sea.plan, self.kind.trial(design)), rng)
        try:
            return prepare_dives(read_descent(folder, self.mission)).dives
        except MissionplanError:
            return None
        finally:
            shutil.rmtree(folder)

    def _experiment(self, predictions: list[Prediction]) -> Experiment:
        return Experiment(tuple(each.explanation for each in self.believed), tuple(predictions))

    def _of_strengths(self, predictions: list[Prediction]) -> Experiment:
        """The experiment with the shapes integrated out: what is hidden has others than the catalogue's."""
        known = [
            of_some(each.explanation, prediction, np.array([c.kind != "shape" for c in each.coordinates], dtype=bool))
            for each, prediction in zip(self.believed, predictions, strict=True)
        ]
        return Experiment(tuple(own for own, _ in known), tuple(prediction for _, prediction in known))

    @property
    def _strengths(self) -> np.ndarray:
        own = [c for c in self.believed[self.truth].coordinates if c.kind != "shape"]
        return np.array([self.sea.parameters[f"{c.effect}.{c.name}"] for c in own])


def made(seed: int) -> list[Campaign]:
    """Make one campaign."""
    rng = np.random.default_rng([seed, 5])
    sea = _Sea.drawn(rng)
    first = sea.log(sea.plan, rng)
    mission = Mission.from_data(sea.told)
    explanations = weighed(mission, first, seed, 1)
    shutil.rmtree(first)
    bound = explanations[0].bound
    found = run_pipeline(bound.model)
    kind = DiveTrials(bound)
    believed = _comparable(believe(possible_fits(explanations, found), kind.posterior, 1.0))
    truth = next((index for index, each in enumerate(believed) if each.causes == sea.names), None)
    if truth is None:
        return [Campaign(seed, _words(sea.names), "none made", False, *[math.nan] * 5, sea.weight)]
    possible = (design for design in rng.permutation(len(kind.designs)).tolist() if kind.cost(design, seed) is not None)
    tried = list(islice(possible, TRIED))
    if len(believed) == 1 and not believed[0].coordinates:  # nothing else may be: no trial tells anything
        return [
            Campaign(seed, _words(sea.names), kind.designs[design], True, *[0.0] * 5, sea.weight) for design in tried
        ]
    known = _Known(sea, mission, kind, believed, truth, seed)
    return [campaign for design in tried if (campaign := known.campaign(design, rng)) is not None]


def of_some(explanation: Explanation, prediction: Prediction, kept: np.ndarray) -> tuple[Explanation, Prediction]:
    """What is believed of some parameters, and data with the others integrated out: conditional normals."""
    mean, covariance, left = explanation.mean, explanation.covariance, ~kept
    slopes = covariance[np.ix_(left, kept)] @ np.linalg.inv(covariance[np.ix_(kept, kept)])
    rest = covariance[np.ix_(left, left)] - slopes @ covariance[np.ix_(kept, left)]
    columns, others = prediction.columns[:, kept], prediction.columns[:, left]
    return (
        replace(explanation, mean=mean[kept], covariance=covariance[np.ix_(kept, kept)]),
        replace(prediction, columns=columns + others @ slopes, noise=prediction.noise + others @ rest @ others.T),
    )


def _words(names: tuple[str, ...]) -> str:
    return "+".join(names) or "nothing"


def _draw_cause(plan: Plan, rng: np.random.Generator) -> tuple[tuple[str, ...], list[DiveEffect], dict[str, float]]:
    """What is hidden: its name, the effect and its parameters; nothing in some of the campaigns."""
    if rng.random() > HIDDEN:
        return (), [], {}
    cause, lightest = str(rng.choice(list(USUAL))), min(dive.wet_weight for dive in plan.dives)
    unit = lightest if cause == "trapped-gas" else 1.0
    size = math.inf
    while size > LARGEST.get(cause, 3.0):
        size = abs(float(rng.standard_t(DOF))) * USUAL[cause] / unit
    effect, known = CATALOGUE[cause].build(size, np.random.default_rng(int(rng.integers(2**32))), conditions_of(plan))
    return (cause,), [effect], {f"{cause}.{name}": float(value) for name, value in known.items()}


def _set_decision(told: dict, plan: Plan, rng: np.random.Generator) -> None:
    """A current and a radius between which the anchor's weight decides."""
    (layer,) = told["site"]["current"]
    current = rng.uniform(0.15, 0.45)
    layer["speed"] = {"mean": f"{current:.3f} m/s", "sd": f"{0.15 * current:.4f} m/s"}
    moor = told["phases"][0]["moor"]
    moor["radius"] = f"{current * plan.site_depth / rng.uniform(0.7, 1.2) + 3.0:.1f} m"
    moor["carry_net_buoyancy"] = True


def _comparable(believed: Sequence[Believed]) -> tuple[Believed, ...]:
    """What may be hidden here, with probabilities that add up to 1."""
    kept = [each for each in believed if not each.causes or (len(each.causes) == 1 and each.causes[0] in USUAL)]
    total = sum(each.explanation.probability for each in kept)
    return tuple(
        replace(each, explanation=replace(each.explanation, probability=each.explanation.probability / total))
        for each in kept
    )


def _true_losses(value: Valuation, told: Mapping, parameters: Mapping[str, float]) -> np.ndarray:
    """Losses of every anchor where the truth is known, as the valuation counts them."""
    effects = []
    for key, number in parameters.items():
        cause, name = key.split(".")
        effects.append({cause: {name: f"{number} {UNITS[cause]}" if cause in UNITS else number}})
    truth = Mission.from_data({**told, **({"effects": effects} if effects else {})})
    alternatives, found = value.kind.alternatives(), []
    for anchor in alternatives.values.tolist():
        mission = alternatives.change(truth, anchor)
        scenario = Scenario.at_means(mission, recorded_current(mission)).sampled(seed=value.seed, block=0, size=TRIALS)
        trials = run_block(scenario, value.seed, 0, TRIALS, inputs=False)
        cost = trials.total["energy_wh"] if value.losses.unit == "W h" else trials.total["duration_s"] / 60.0
        usual = float(np.mean(cost[np.isfinite(cost)])) if np.isfinite(cost).any() else 0.0
        loss = np.where(np.isfinite(cost), cost, usual) + value.losses.failure * (1.0 - trials.success)
        found.append(float(loss.mean()))
    return np.array(found)


def _dived(plan: Plan, trial: Mapping[str, object]) -> Plan:
    """The dives of a trial's mission file, as a crew would read them."""

    def number(text: str) -> float:
        return float(text.split()[0])

    moors = [entry["moor"] for entry in trial["phases"]]
    depth = number(trial["site"]["depth"])
    dives = [
        Dive(number(moor["anchor_wet_weight"]), number(moor["line_length"]), depth, number=index)
        for index, moor in enumerate(moors)
    ]
    return replace(plan, site_depth=depth, dives=tuple(dives), states_depth=True)


def _written(folder: Path, header: list[str], rows: list[list[str]], told: Mapping[str, object]) -> Path:
    (folder / "dataset.yaml").write_text(yaml.safe_dump(dict(told)), encoding="utf-8")
    with (folder / "dives.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])
    return folder
