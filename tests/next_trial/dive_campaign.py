"""One campaign of dives: hidden dives, their diagnosis, one of the trials it offers made, and what that told."""

import csv
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from missionplan.datasets.dives import read_descent
from missionplan.diagnosis.dives.preparation import prepare_dives
from missionplan.diagnosis.explanations import weighed
from missionplan.diagnosis.inference.trials.experiment import Experiment, drawn
from missionplan.diagnosis.judgement import judge
from missionplan.diagnosis.next_trial.belief import Believed, believe, possible_fits
from missionplan.diagnosis.next_trial.dive_trials import DiveTrials
from missionplan.diagnosis.pipeline import run_pipeline
from missionplan.mission import Mission
from tests.hidden_effects.dives.catalogue import CATALOGUE
from tests.hidden_effects.dives.dynamics import Dive
from tests.hidden_effects.dives.files import measure, mission_files
from tests.hidden_effects.dives.strength import draw_hidden
from tests.hidden_effects.dives.trials import Plan, draw_nuisances, draw_plan

from .campaign import UNTROUBLED, Campaign

DIVES, DRAWS = 2, 2000
"""Dives of the first log; draws of which the expected information is the mean."""
SCENARIO, SEVERITY = "single", 0.5


def made(seed: int) -> Campaign:
    """Make one campaign."""
    rng = np.random.default_rng([seed, 4])
    names: tuple[str, ...] = () if rng.random() < UNTROUBLED else (str(rng.choice(list(CATALOGUE))),)
    plan = draw_plan(rng, SCENARIO, names)
    plan = replace(plan, dives=plan.dives[:DIVES], vehicle_form="inline")
    noise = draw_nuisances(rng, SCENARIO)
    hidden = draw_hidden(plan, noise, names, rng, SEVERITY, False)
    if hidden is None:
        return Campaign(seed, "+".join(names), "not visible", False, *[float("nan")] * 5)
    told, _ = mission_files(plan, rng)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        first = _written(folder / "first", *measure(plan, noise, hidden.effects, rng))
        mission = Mission.from_data(told)
        explanations = weighed(mission, first, seed, 1)
        bound = explanations[0].bound
        found = run_pipeline(bound.model)
        kind = DiveTrials(bound)
        believed = believe(possible_fits(explanations, found, judge(bound, found)), kind.posterior, 1.0)
        design = int(rng.integers(len(kind.designs)))
        there = _dived(plan, kind.trial(design))
        logs = prepare_dives(
            read_descent(_written(folder / "next", *measure(there, noise, hidden.effects, rng)), mission)
        ).dives
        experiment = _experiment(believed, kind.predicted(logs, believed))
    draws = drawn([each.explanation for each in believed], [DRAWS // len(believed)] * len(believed), rng)
    planned = _experiment(believed, kind.predictions(design, believed))
    expected = planned.expected_information(draws, planned.data(draws, rng))
    truth = _index(believed, names, hidden.parameters)
    y = np.concatenate([log.depth for log in logs])
    gained = float("nan")
    if truth is not None:
        gained = experiment.realised_information(truth, _parameters(believed[truth], hidden.parameters), y)
    told_of = "+".join(names) or "nothing"
    return Campaign(seed, told_of, kind.designs[design], truth is not None, expected, gained, 0.0, 0.0, 0.0)


def _experiment(believed: tuple[Believed, ...], predictions: list) -> Experiment:
    return Experiment(tuple(each.explanation for each in believed), tuple(predictions))


def _index(believed: tuple[Believed, ...], names: tuple[str, ...], known: Mapping[str, float]) -> int | None:
    """Which of what is believed is the truth; None where none is, or its parameters are not comparable."""
    for index, each in enumerate(believed):
        if each.causes == names and all(f"{c.effect}.{c.name}" in known for c in each.coordinates):
            return index
    return None


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
