"""One campaign of dives: hidden dives, their diagnosis, trials of those it offers made, and what each brought.

A prediction is a mean over what is believed, so that what is hidden has to come as often, and as large, as the diagnosis
expects: nothing in half of the campaigns, else one cause of the catalogue, its size from the same heavy-tailed
distribution. Causes whose size the hidden dives and the catalogue define alike are drawn, and the others struck from what
is believed, which leaves the odds of the rest as they are.
"""

import csv
import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from missionplan.datasets.dives import read_descent
from missionplan.diagnosis.dives.preparation import prepare_dives
from missionplan.diagnosis.explanations import weighed
from missionplan.diagnosis.inference.trials.decision import choice_after, value_of_information
from missionplan.diagnosis.inference.trials.experiment import Experiment, drawn
from missionplan.diagnosis.judgement import judge
from missionplan.diagnosis.next_trial.belief import Believed, believe, possible_fits
from missionplan.diagnosis.next_trial.dive_trials import DiveTrials
from missionplan.diagnosis.next_trial.valuation import Valuation
from missionplan.diagnosis.pipeline import run_pipeline
from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.trial_block import run_block
from tests.hidden_effects.dives.catalogue import CATALOGUE
from tests.hidden_effects.dives.dynamics import Dive, DiveEffect
from tests.hidden_effects.dives.files import measure, mission_files
from tests.hidden_effects.dives.trials import Plan, conditions_of, draw_nuisances, draw_plan

from .campaign import UNTROUBLED, Campaign

DIVES, DRAWS, TRIALS = 2, 2000, 1000
"""Dives of the first log; draws of which the expected information is the mean; missions of which the true losses are."""
TRIED = 4
"""Trials made after each first log, drawn from those offered."""
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


def made(seed: int) -> list[Campaign]:
    """Make one campaign."""
    rng = np.random.default_rng([seed, 5])
    plan = draw_plan(rng, SCENARIO, ())
    plan = replace(plan, dives=plan.dives[:DIVES], vehicle_form="inline")
    noise = draw_nuisances(rng, SCENARIO)
    names, effects, parameters = _draw_cause(plan, rng)
    told, _ = mission_files(plan, rng)
    _set_decision(told, plan, rng)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        first = _written(folder / "first", *measure(plan, noise, effects, rng))
        mission = Mission.from_data(told)
        explanations = weighed(mission, first, seed, 1)
        bound = explanations[0].bound
        found = run_pipeline(bound.model)
        kind = DiveTrials(bound)
        believed = _comparable(believe(possible_fits(explanations, found, judge(bound, found)), kind.posterior, 1.0))
        truth = _index(believed, names)
        if truth is None:
            return [Campaign(seed, "+".join(names), "none made", False, *[math.nan] * 5)]
        value = Valuation.of(kind, believed, seed)
        losses = _true_losses(value, told, parameters)
        campaigns = []
        for design in rng.permutation(len(kind.designs))[:TRIED].tolist():
            if kind.cost(design, seed) is None:
                continue
            there = measure(_dived(plan, kind.trial(design)), noise, effects, rng)
            try:
                logs = prepare_dives(read_descent(_written(folder / f"next-{design}", *there), mission)).dives
            except MissionplanError:  # a log that the package refuses: nothing is learned
                continue
            made_trial = _experiment(believed, kind.predicted(logs, believed))
            y = np.concatenate([log.depth for log in logs])
            gained = made_trial.realised_information(truth, _parameters(believed[truth], parameters), y)
            planned = _experiment(believed, kind.predictions(design, believed))
            draws = drawn([each.explanation for each in believed], [DRAWS // len(believed)] * len(believed), rng)
            expected = planned.expected_information(draws, planned.data(draws, rng))
            saving = value_of_information(
                value.losses.problem, planned.summaries(planned.data(value.draws, np.random.default_rng(seed + 1)))
            )
            simulated = made_trial.summaries(made_trial.data(value.draws, np.random.default_rng(seed + 1)))
            after = choice_after(value.losses.problem, simulated, made_trial.summaries(y[None]))
            saved = float(losses[value.losses.problem.choice] - losses[after])
            told_of = "+".join(names) or "nothing"
            scale = float(value.losses.problem.expected[value.losses.problem.choice])
            campaigns.append(
                Campaign(
                    seed,
                    told_of,
                    kind.designs[design],
                    True,
                    expected,
                    gained,
                    100.0 * saving.mean / scale,
                    100.0 * saving.error / scale,
                    100.0 * saved / scale,
                )
            )
    return campaigns


def _draw_cause(plan: Plan, rng: np.random.Generator) -> tuple[tuple[str, ...], list[DiveEffect], dict[str, float]]:
    """What is hidden: its name, the effect and its parameters; nothing in half of the campaigns."""
    if rng.random() < UNTROUBLED:
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


def _experiment(believed: tuple[Believed, ...], predictions: list) -> Experiment:
    return Experiment(tuple(each.explanation for each in believed), tuple(predictions))


def _index(believed: Sequence[Believed], names: tuple[str, ...]) -> int | None:
    """Which of what is believed is the truth; None where none is."""
    return next((index for index, each in enumerate(believed) if each.causes == names), None)


def _parameters(each: Believed, known: Mapping[str, float]) -> np.ndarray:
    values = [(known[f"{c.effect}.{c.name}"], c.kind) for c in each.coordinates]
    return np.array([np.log(value) if kind == "shape" else value for value, kind in values])


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
    folder.mkdir()
    (folder / "dataset.yaml").write_text(yaml.safe_dump(dict(told)), encoding="utf-8")
    with (folder / "dives.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])
    return folder
