"""``python -m tests.hidden_effects.further``: the study in a form that can be continued, with further kinds of cases.

Besides the scenarios of `cases`: effects of 3 to 10 times their usual size (``strong``), missions that already carry
the effect, unchanged (``given``) or changed since (``changed``), headings within ±10° (``narrow``), inertial currents
that wander beside persistent errors (``wandering``, and ``calm`` without the current), and position errors that gather
within a leg (``gathering``). ``transit-control`` and ``descent-control`` are data sets without an effect alone. Each case
is a line of a file; those that are in it are not run again.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from . import dives, legs
from .case import Case
from .cases import SCENARIO_CYCLE, draw_case
from .legs import random_records
from .score import covered, in_credible_set, page
from .tool import Outcome, diagnose

FURTHER = ("strong", "given", "wandering", "narrow", "calm", "strong", "changed", "gathering")
"""Further scenarios of navigation logs, in turn."""
FURTHER_DIVES = ("strong", "given", "strong", "changed")
"""Further scenarios of dives, in turn."""
GIVEN = {
    "transit": {"compass-bias": ("angle",), "speed-scale": ("fraction",), "mean-current": ("east", "north")},
    "descent": {"clock-offset": ("time",), "depth-scale": ("fraction",), "vertical-current": ("speed",)},
}
"""Effects that a mission carries, with their parameters."""
UNITS = {"angle": "rad", "fraction": "", "east": "m/s", "north": "m/s", "time": "s", "speed": "m/s"}
PRIOR_SD = 0.08
"""Standard deviation of what the mission knows, over the effect's size."""
CLEAR = {"wandering": 6.0, "gathering": 8.0}
"""Log Bayes factor of the generating law from which an effect has to be named."""
Argument = tuple[int, str, str]
"""Seed, kind and scenario of a case."""


def draw(seed: int, kind: str, scenario: str) -> Case:
    """Draw a case of any scenario."""
    if kind == "descent" and scenario == "strong":
        return dives.draw(seed, scenario)
    if scenario in ("strong", "narrow"):
        case = legs.draw(seed, scenario)
        return replace(case, ties=(("mean-current",), ("persistent-error",))) if scenario == "narrow" else case
    if scenario in ("given", "changed"):
        return _known(seed, kind, scenario)
    if scenario in ("wandering", "calm"):
        return replace(random_records.wandering(seed, inertial=scenario == "wandering"), scenario=scenario)
    if scenario == "gathering":
        return random_records.gathering(seed)
    return draw_case(seed, kind, scenario)


def _known(seed: int, kind: str, scenario: str) -> Case:
    """A case whose mission carries the effect: as it is to within its prior, or with the other sign."""
    rng = np.random.default_rng([seed, 43])
    given = GIVEN[kind]
    name = str(rng.choice(list(given)))
    case = (dives if kind == "descent" else legs).draw(seed, "single", name)
    size = float(np.linalg.norm([case.parameters[f"{name}.{key}"] for key in given[name]]))
    entry = {}
    for key in given[name]:
        truth, unit = float(case.parameters[f"{name}.{key}"]), UNITS[key]
        mean = (truth if scenario == "given" else -truth) + float(PRIOR_SD * size * rng.standard_normal())
        sd = PRIOR_SD * size
        entry[key] = {"mean": f"{mean:.6g} {unit}", "sd": f"{sd:.6g} {unit}"} if unit else {"mean": mean, "sd": sd}
    mission = {**case.mission, "effects": [{name: entry}]}
    truth = () if scenario == "given" else case.truth
    return replace(case, scenario=scenario, mission=mission, truth=truth)


STUDIES = ("further", "further-descent", "transit", "descent", "transit-control", "descent-control")
"""Names of the studies."""


def plan(cases: int, seed: int, which: str) -> Iterator[Argument]:
    """Seed, kind and scenario of each case: further ones of legs or dives, or those of the study of a kind."""
    kind = which.removesuffix("-control")
    for index in range(cases):
        if which == "further":
            yield seed + index, "transit", FURTHER[index % len(FURTHER)]
        elif which == "further-descent":
            yield seed + index, "descent", FURTHER_DIVES[index % len(FURTHER_DIVES)]
        else:
            yield seed + index, kind, SCENARIO_CYCLE[index % len(SCENARIO_CYCLE)] if kind == which else "control"


KEPT = ("kind", "scenario", "truth", "ties", "outside", "parameters", "strength")
"""What a line keeps of a case."""


def line_of(outcome: Outcome) -> str:
    """Write an outcome as a line: the truth, and of the diagnosis what is scored."""
    found = outcome.diagnosis
    scored = {key: found[key] for key in ("verdict", "causes", "credible_set") if key in found}
    scored |= {"ranking": found.get("ranking", [])[:12]} if found else {}
    case = {key: getattr(outcome.case, key) for key in KEPT}
    return json.dumps(
        {"seed": outcome.case.seed, **case, "diagnosis": scored, "seconds": outcome.seconds, "error": outcome.error}
    )


def outcome_of(line: str) -> Outcome:
    """Read an outcome from its line; its case has no data."""
    read = json.loads(line)
    ties = tuple(tuple(tie) for tie in read["ties"])
    case = Case(
        seed=read["seed"],
        kind=read["kind"],
        scenario=read["scenario"],
        truth=tuple(read["truth"]),
        ties=ties,
        outside=read["outside"],
        parameters=read["parameters"],
        strength=read["strength"],
        mission={},
        vehicle=None,
        dataset={},
        header=[],
        rows=[],
    )
    return Outcome(case, read["diagnosis"], read["seconds"], read["error"])


def further_figures(outcomes: Sequence[Outcome]) -> list[str]:
    """Say how the further scenarios came out, a line each."""
    by: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        by.setdefault(outcome.case.scenario, []).append(outcome)
    lines = []
    for scenario, own in by.items():
        if scenario not in FURTHER:
            continue
        clear = [o for o in own if o.case.strength >= CLEAR.get(scenario, -np.inf)]
        named = [set(o.case.truth) <= set(o.diagnosis.get("causes", [])) for o in clear]
        physical = [set(o.diagnosis.get("causes", [])) & {"tidal-current", "inertial-current"} for o in own]
        hits = [hit for o in own for hit in covered(o)]
        words = {
            "given": f"adequate {sum(o.diagnosis.get('verdict') == 'adequate' for o in own)} of {len(own)}",
            "calm": f"a tide or an inertial current claimed in {sum(map(bool, physical))} of {len(own)}",
            "wandering": f"inertial current named in {sum('inertial-current' in p for p in _causes(clear))} of "
            f"{len(clear)} clear sets, a tide in {sum('tidal-current' in p for p in _causes(own))} of {len(own)}",
            "narrow": f"truth in the 95 % set {sum(map(in_credible_set, own))} of {len(own)}, explained "
            f"{sum(o.diagnosis.get('verdict') == 'explained' for o in own)}",
        }
        said = words.get(scenario, f"truth claimed in {sum(named)} of {len(clear)}")
        lines.append(f"{scenario}: {said}; intervals cover {sum(hits)} of {len(hits)}; failed {_failed(own)}")
    return lines


def _causes(outcomes: Sequence[Outcome]) -> list[list[str]]:
    return [o.diagnosis.get("causes", []) for o in outcomes]


def _failed(outcomes: Sequence[Outcome]) -> int:
    return sum(bool(o.error) for o in outcomes)


def main(words: Sequence[str] | None = None) -> int:
    """Run the cases that a file lacks, one after the other, and print the figures of all that it has."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_effects.further", description=__doc__)
    parser.add_argument("--lines", type=Path, required=True, help="file of outcomes, continued where it ends")
    parser.add_argument("--cases", type=int, default=400)
    parser.add_argument("--seed", type=int, default=41_000_000)
    parser.add_argument("--which", choices=STUDIES, default="further")
    options = parser.parse_args(words)
    known = [outcome_of(line) for line in options.lines.read_text().splitlines()] if options.lines.exists() else []
    done = {(o.case.seed, o.case.kind, o.case.scenario) for o in known}
    for argument in plan(options.cases, options.seed, options.which):
        if argument in done:
            continue
        with tempfile.TemporaryDirectory() as folder:
            outcome = diagnose(draw(*argument), Path(folder) / "cases", Path(folder) / "truths", in_process=True)
        with options.lines.open("a") as file:
            file.write(line_of(outcome) + "\n")
        known.append(outcome)
        print(f"{len(known)} cases, last {argument}: {outcome.diagnosis.get('causes')}", file=sys.stderr, flush=True)
    standard = [o for o in known if o.case.scenario in SCENARIO_CYCLE]
    if standard:
        print(page(standard))
    print("\n".join(further_figures(known)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
