"""``python -m tests.calibration``: are the probabilities, intervals and predictions of `diagnose` what they say?

Draws truths from the stated prior (pairs, weak and untestable ones included) and some from outside the catalogue, makes
logs by code that shares nothing with the model, diagnoses them, and compares what is said with what is true. A few logs
by default; ``--logs 1000`` for figures to publish, ``--kind dives`` for dives.
"""

import argparse
import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

import missionplan
from missionplan.mission import Mission
from missionplan.results.learned import Diagnosis

from .dives import dives
from .truths import names, outside, truth
from .voyages import Voyage, mission, sail, write


def record(seed: int, is_outside: bool) -> dict[str, object]:
    """Diagnose one log; what is said beside what is true."""
    rng = np.random.default_rng([seed, int(is_outside)])
    count, under_way = int(rng.integers(12, 70)), float(rng.uniform(300.0, 1500.0))
    middle, half = rng.uniform(0.0, 2.0 * np.pi), float(rng.choice([np.pi, np.pi, np.pi, 0.8]))
    latitude = float(rng.uniform(35.0, 65.0))

    def legs(more: int, begins: float) -> Voyage:
        headings = middle + half * rng.uniform(-1.0, 1.0, more)
        return Voyage(headings, under_way, sigma=0.02, latitude=latitude, begins=begins)

    seen, later = legs(count, 0.0), legs(20, (count + 5) * (under_way + 60.0))
    what = outside(rng) if is_outside else truth(names(rng), rng, latitude)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        base = Mission.from_data(mission(seen, 0.02 * rng.uniform(0.8, 1.25)))
        found = missionplan.diagnose(base, write(folder / "seen", sail(seen, what, rng), seen.fix), plan=False)
        fresh = write(folder / "fresh", sail(later, what, rng), seen.fix)
        score = missionplan.score(Mission.from_data(found.extended), fresh)
        whole = score.summary()["datasets"][0]["predictions"]["whole"]
    return {"seed": seed, "outside": what.outside, **_said(found, what.names, what.parameters), **_held(whole)}


def record_of_dives(seed: int, is_outside: bool) -> dict[str, object]:
    """Diagnose one record of dives; what is said beside what is true."""
    case = dives(seed, is_outside)
    with tempfile.TemporaryDirectory() as name:
        base, data = case.write(Path(name) / "seen", Path(name) / "truth")
        found = missionplan.diagnose(base, data, plan=False)
    return {"seed": seed, "outside": case.outside, **_said(found, case.truth, case.parameters)}


def _said(found: Diagnosis, truth: Sequence[str], parameters: Mapping[str, float]) -> dict[str, object]:
    sets = {tuple(sorted(entry.causes)): entry.posterior or 0.0 for entry in found.ranking}
    inside = []
    entry = next((each for each in found.ranking if set(each.causes) == set(truth)), None)
    for each in entry.parameters if entry is not None else ():
        true = parameters.get(f"{each.effect}.{each.name}")
        if true is not None:
            inside.append((each.low <= true <= each.high, abs(true - each.value) < 0.6745 * each.sd))
    return {
        "truth": sorted(truth),
        "verdict": found.verdict,
        "causes": sorted(found.causes),
        "sets": [[list(causes), p] for causes, p in sets.items()],
        "credible": [sorted(causes) for causes in found.credible_set],
        "none_of_these": found.none_of_these,
        "inside": inside,
    }


def _held(whole: dict) -> dict[str, float]:
    return {"fresh_90": whole["coverage_90"]["value"], "fresh_50": whole["coverage_50"]["value"]}


def figures(lines: list[dict]) -> dict[str, float]:
    """Return the figures by name, and how many logs, sets and parameters they are of."""
    own = [line for line in lines if not line["outside"]]
    told = [(p, causes == line["truth"]) for line in own for causes, p in line["sets"]]
    sure = [right for p, right in told if p >= 0.99]
    p, right = np.array([each[0] for each in told]), np.array([each[1] for each in told], dtype=float)
    bins = np.digitize(p, np.linspace(0.0, 1.0, 11)[1:-1])
    held = [line["truth"] in line["credible"] for line in own]
    parameters = np.array([pair for line in own for pair in line["inside"]], dtype=float).reshape(-1, 2)
    outer = [line["none_of_these"] for line in lines if line["outside"]]
    inner = [line["none_of_these"] for line in own]
    pairs = [(a > b) + 0.5 * (a == b) for a in outer for b in inner]
    return {
        "logs": len(own),
        "outside": len(outer),
        "sets": len(p),
        "ece": sum(abs(p[bins == b].sum() - right[bins == b].sum()) for b in range(10)) / max(len(p), 1),
        "sure": len(sure),
        "sure_right": sum(sure),
        "in_set": float(np.mean(held)),
        "set_size": float(np.mean([len(line["credible"]) for line in own])),
        "parameters": len(parameters),
        "parameters_90": float(parameters[:, 0].mean()),
        "parameters_50": float(parameters[:, 1].mean()),
        **{key: float(np.mean([line[key] for line in own])) for key in ("fresh_90", "fresh_50") if key in own[0]},
        "none_auc": float(np.mean(pairs)) if pairs else float("nan"),
    }


def summary(lines: list[dict]) -> list[str]:
    """Return the figures in words."""
    found = figures(lines)
    return [
        f"{found['logs']} logs of the catalogue, {found['outside']} from outside it",
        f"expected calibration error of {found['sets']} sets: {found['ece']:.3f}",
        f"P >= 0.99 right: {found['sure_right']} of {found['sure']}",
        f"truth in the 95 % set: {found['in_set']:.3f}; its mean size {found['set_size']:.2f}",
        f"parameters in 90 and 50 % intervals: {found['parameters_90']:.3f}, {found['parameters_50']:.3f} "
        f"of {found['parameters']}",
        *(
            [f"fresh legs in 90 and 50 % intervals: {found['fresh_90']:.3f}, {found['fresh_50']:.3f}"]
            if "fresh_90" in found
            else []
        ),
        f"none_of_these, AUC between outside and inside: {found['none_auc']:.2f}",
    ]


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=("legs", "dives"), default="legs")
    parser.add_argument("--logs", type=int, default=12)
    parser.add_argument("--outside", type=int, default=4)
    parser.add_argument("--seed", type=int, default=90_000_000)
    parser.add_argument("--lines", type=Path, help="file of a line a log, continued where it ends")
    options = parser.parse_args()
    wanted = [(k, False) for k in range(options.logs)] + [(k, True) for k in range(options.outside)]
    lines = [json.loads(text) for text in options.lines.read_text().splitlines()] if _exists(options.lines) else []
    for k, is_outside in wanted[len(lines) :]:
        one = record if options.kind == "legs" else record_of_dives
        lines.append(one(options.seed + k, is_outside))
        if options.lines is not None:
            with options.lines.open("a") as file:
                file.write(json.dumps(lines[-1], default=bool) + "\n")
    print("\n".join(summary(lines)))


def _exists(path: Path | None) -> bool:
    return path is not None and path.exists()


if __name__ == "__main__":
    main()
