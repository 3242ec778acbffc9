"""``python -m tests.regret --cases 200``: ambiguous dives and legs, and what is lost by each way to carry the doubt.

Every case is diagnosed; where the verdict leaves a doubt, the anchor for P ≥ 0.95 or the d_max is chosen with the
averaged mission (the extended mission as it is written), with the best cause alone, and with the base model. The regret
is the loss against the choice that knows the truth. Results are kept in a file, line by line: a run goes on where the
last one ended.
"""

import argparse
import csv
import itertools
import json
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from missionplan import diagnose
from missionplan.diagnosis.explanations import explained_missions
from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.results.learned import Diagnosis

from .ambiguous_dives import Hidden, draw_dives
from .ambiguous_legs import draw_legs
from .choices import REQUIRED, AnchorChoice, LegChoice, with_truth

WAYS = ("averaged", "best", "base")
TRIALS = {"dives": 400, "legs": 400}
LOW = 0.9
"""Share of successes below which an anchor that was chosen for REQUIRED has clearly failed to reach it."""


def main(words: Sequence[str] | None = None) -> int:
    """Run cases until there are enough that leave a doubt, and print the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.regret", description=__doc__)
    parser.add_argument("--cases", type=int, default=200, help="cases that leave a doubt")
    parser.add_argument("--seed", type=int, default=300_000, help="of the first case")
    parser.add_argument("--results", type=Path, default=Path("regret.jsonl"), help="file that is continued")
    parser.add_argument("--minutes", type=float, default=np.inf, help="start no further case after this time")
    parser.add_argument("--kind", choices=tuple(TRIALS), help="run these alone")
    options = parser.parse_args(words)
    done, until = read(options.results), time.monotonic() + 60.0 * options.minutes
    known = {each["seed"] for each in done}
    seeds = (
        seed for seed in itertools.count(options.seed) if seed not in known and options.kind in (None, _kind(seed))
    )
    while sum(_in_doubt(each) for each in done) < options.cases and time.monotonic() < until:
        done.append(run_case(next(seeds)))
        with options.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(done[-1]) + "\n")
        print(f"\r{len(done)} drawn, {sum(_in_doubt(each) for each in done)} in doubt", end="", file=sys.stderr)
    print(file=sys.stderr)
    print(table(done))
    return 0


def read(file: Path) -> list[dict[str, Any]]:
    """Results so far."""
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []


def run_case(seed: int) -> dict[str, Any]:
    """Draw, diagnose and plan one case: dives of an even seed, legs of an odd one."""
    case = draw_dives(seed) if _kind(seed) == "dives" else draw_legs(seed)
    (cause,) = case.truth
    found: dict[str, Any] = {"seed": seed, "kind": case.kind, "truth": cause}
    base = Mission.from_data(case.mission)
    try:
        diagnosis = diagnosed(case, base)
        found |= {"verdict": diagnosis.verdict, "causes": list(diagnosis.causes)}
        found["explanations"] = [each.summary() for each in diagnosis.explanations]
        if diagnosis.explanations:
            found |= regrets(case, base, diagnosis)
    except MissionplanError as error:
        found["error"] = str(error)
    return found


def diagnosed(case: Hidden, base: Mission) -> Diagnosis:
    """Write the data and diagnose them."""
    with tempfile.TemporaryDirectory(prefix="regret-") as scratch:
        folder = Path(scratch)
        (folder / "dataset.yaml").write_text(yaml.safe_dump(dict(case.dataset)), encoding="utf-8")
        with (folder / case.dataset["file"]).open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([case.header, *case.rows])
        return diagnose(base, folder, plan=False)


def regrets(case: Hidden, base: Mission, diagnosis: Diagnosis) -> dict[str, dict[str, Any]]:
    """Regret and outcome of each way to plan; none where not even the truth leaves a choice."""
    averaged = Mission.from_data(diagnosis.extended)
    best = explained_missions(averaged)[0].mission
    choose: Any = AnchorChoice.of if case.kind == "dives" else LegChoice.of
    trials = TRIALS[case.kind]
    truth = choose(with_truth(case.mission, case.truth), trials)
    if not truth.is_possible:
        return {"regret": {}}
    missions = dict(zip(WAYS, (averaged, best, base), strict=True))
    chosen = {way: choose(mission, trials) for way, mission in missions.items()}
    return {
        "regret": {way: each.regret(truth) for way, each in chosen.items()},
        "outcome": {way: each.outcome(truth) for way, each in chosen.items()},
    }


def _kind(seed: int) -> str:
    return "dives" if seed % 2 == 0 else "legs"


def _in_doubt(result: Mapping[str, Any]) -> bool:
    return bool(result.get("regret"))


def table(results: Sequence[Mapping[str, Any]]) -> str:
    """Median and 90th percentile of the regret by kind and way, and how many anchors reach the probability asked for."""
    lines = [
        "| cases | way | median | 90th percentile | mean | reach 0.95 | below 0.90 |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in ("dives", "legs", "all"):
        own = [each for each in results if _in_doubt(each) and kind in ("all", each["kind"])]
        for way in WAYS if own else ():
            values = 100.0 * np.array([each["regret"][way] for each in own])
            numbers = f"{np.median(values):.1f} % | {np.quantile(values, 0.9):.1f} % | {values.mean():.1f} %"
            success = np.array([each["outcome"][way].get("success", np.nan) for each in own])
            counts = f"{np.sum(success >= REQUIRED)} | {np.sum(success < LOW)}" if kind == "dives" else "– | –"
            lines.append(f"| {len(own)} {kind} | {way} | {numbers} | {counts} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
