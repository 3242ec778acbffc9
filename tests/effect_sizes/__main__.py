"""``python -m tests.effect_sizes``: estimates and intervals of effects from 0.3 to 10 times their usual size.

The data are those of `tests.hidden_effects`, which share nothing with the package, with one effect of a given size, whether it
can be seen or not; that cause is fitted, claimed or not, to the files. Effects are those of which a
parameter is defined alike on both sides. Each fit is a line of a file; those that are in it are not run again.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from missionplan.diagnosis.data_kind import bind_dataset
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.model import fitted as fit_sets
from missionplan.errors import InputError
from missionplan.mission import load
from tests.hidden_effects import dives, legs, tank
from tests.hidden_effects.case import Case
from tests.hidden_effects.legs import random_records
from tests.hidden_effects.legs.survey import RANDOM, Survey

LEG_SIZES = {
    "mean-current": (0.045, 0.15, 0.45, 1.5),
    "compass-bias": (0.024, 0.08, 0.24, 0.4),
    "compass-deviation": (0.024, 0.08, 0.24, 0.4),
    "speed-scale": (0.024, 0.08, 0.24, 0.3),
    "surface-drift": (0.075, 0.25, 0.75, 1.5),
    "persistent-error": (0.018, 0.06, 0.18, 0.6),
    "random-walk": (1.5e-4, 5e-4, 1.5e-3),
    "position-random-walk": (0.3, 1.0, 3.0, 10.0),
    "fix-error": (7.5, 25.0, 75.0, 250.0),
    "heavy-tails": (40.0, 12.0, 4.0, 2.5),
}
"""0.3, 1, 3 and 10 times what the catalogue calls usual, at most half of what is possible [SI]; a random walk of ten
times carries the vehicle away."""
DIVE_SIZES = {
    "drag-bias": (0.09, 0.3, 0.9, 1.0),
    "line-payout": (0.06, 0.2, 0.6, 0.8),
    "added-mass": (0.12, 0.4, 1.2, 1.5),
    "sensor-lag": (0.15, 0.5, 1.5, 5.0),
    "clock-offset": (0.15, 0.5, 1.5, 5.0),
    "depth-scale": (0.018, 0.06, 0.18, 0.25),
    "vertical-current": (0.036, 0.12, 0.36, 0.5),
}
"""The same for dives, at most what still lets the vehicle go down."""
TANK_SIZES = {
    "drag-bias": (0.09, 0.3, 0.9, 1.0, -0.35),
    "reynolds-drag": (0.045, 0.15, 0.45, 0.5, -0.5),
    "added-mass": (0.12, 0.4, 1.2, 1.5),
    "quadratic-damping": (0.6, 2.0, 6.0, 20.0),
    "jet-suction": (1.5, 5.0, 15.0, 25.0),
    "thrust-asymmetry": (0.075, 0.25, 0.475, -1.0),
    "axial-flow": (0.3, 1.0, 3.0, 10.0),
}
"""The same for tank data; also the largest of the other sign, where there is one."""
SIZES = {"transit": LEG_SIZES, "descent": DIVE_SIZES, "tank": TANK_SIZES}


def in_builders_unit(name: str, size: float, survey: Survey) -> float:
    """Return a size as the builders of random effects on legs take it: over the independent error's."""
    of_random = {
        "persistent-error": survey.sigma,
        "random-walk": survey.sigma / np.sqrt(survey.conditions.span),
        "fix-error": survey.sigma * survey.conditions.leg_time,
    }
    return 1.6 / (size - 2.0) if name == "heavy-tails" else size / of_random.get(name, 1.0)


def draw(seed: int, kind: str, name: str, size: float) -> Case:
    """Draw a case with one effect of a given size."""
    if name == "position-random-walk":
        usual = random_records.gathering(seed).parameters["position-random-walk.rate"]
        return random_records.gathering(seed, size / usual)
    if kind == "tank":
        return tank.draw_sized(seed, name, size)
    if kind == "descent":
        return dives.draw_sized(seed, name, size)
    return legs.draw_sized(seed, name, lambda survey: in_builders_unit(name, size, survey))


FURTHER = 3.0
"""Nats that a persistent error has to add to a cause, that the mean of a log alone shows, to be fitted beside it."""


def fitted(case: Case) -> list[dict[str, Any]]:
    """Fit the true cause; each parameter whose true value is known, with its estimate.

    Beside a cause of a navigation log that is no random error, a persistent error is fitted where the log wants one: no
    current made up there is quite steady.
    """
    with tempfile.TemporaryDirectory() as folder:
        mission, data = case.write(Path(folder) / "cases", Path(folder) / "truths")
        try:
            bound = bind_dataset(data, load(mission), 1)
        except InputError as error:  # carried away, or no descent
            return [{"refused": str(error)[-200:]}]
    sets = [case.truth]
    if case.kind == "transit" and not {*case.truth} & {*RANDOM, "position-random-walk"}:
        sets.append((*case.truth, "persistent-error"))
    fits = [fit for fit in fit_sets(bound.model, [(causes, ()) for causes in sets]) if isinstance(fit, CauseFit)]
    if not fits:
        return [{"refused": "no fit"}]
    best = max(fits, key=lambda fit: fit.log_evidence - FURTHER * len(fit.causes))
    return [
        {"name": each.name, "true": true, "value": each.value, "sd": each.sd, "low": each.low, "high": each.high}
        for each in best.estimates
        if (true := case.parameters.get(f"{each.effect}.{each.name}")) is not None
    ]


def plan(kind: str, sets: int, seed: int, only: str) -> Iterator[tuple[str, float, int]]:
    """Effect, size and seed of each case."""
    for number in range(sets):
        for name, sizes in SIZES[kind].items():
            if only in ("", name):
                yield from ((name, size, seed + number) for size in sizes)


def table(lines: Sequence[dict[str, Any]]) -> str:
    """Mean error and coverage of each effect's parameters, by size."""
    groups: dict[tuple[str, float, str], list[dict[str, Any]]] = {}
    refused = 0
    for line in lines:
        for each in line["estimates"]:
            if "refused" in each:
                refused += 1
            else:
                groups.setdefault((line["effect"], line["size"], each["name"]), []).append(each)
    rows = ["| effect, parameter | size | mean error, of the size | in posterior sd | 90 % intervals hold |"]
    rows.append("|---|---|---|---|---|")
    for (effect, size, name), own in sorted(groups.items()):
        true, value, sd = (np.array([each[key] for each in own]) for key in ("true", "value", "sd"))
        held = sum(each["low"] <= each["true"] <= each["high"] for each in own)
        scale = np.sqrt(np.mean(true**2))
        away, sign = value - true, np.where(true < 0.0, -1.0, 1.0)
        rows.append(
            f"| {effect}, {name} | {size:g} | {100.0 * np.mean(sign * away) / scale:.0f} % "
            f"| {np.mean(sign * away / sd):.1f} | {held} of {len(own)} |"
        )
    return "\n".join([*rows, "", f"{refused} refused"])


def main(words: Sequence[str] | None = None) -> int:
    """Run the fits that a file lacks, and print the table of all that it has."""
    parser = argparse.ArgumentParser(prog="python -m tests.effect_sizes", description=__doc__)
    parser.add_argument("--lines", type=Path, required=True, help="file of fits, continued where it ends")
    parser.add_argument("--kind", choices=list(SIZES), default="transit")
    parser.add_argument("--sets", type=int, default=24, help="cases of each size")
    parser.add_argument("--seed", type=int, default=72_000_000)
    parser.add_argument("--effect", default="", help="only this one")
    options = parser.parse_args(words)
    known = [json.loads(line) for line in options.lines.read_text().splitlines()] if options.lines.exists() else []
    done = {(line["effect"], line["size"], line["seed"]) for line in known}
    for name, size, seed in plan(options.kind, options.sets, options.seed, options.effect):
        if (name, size, seed) in done:
            continue
        case = draw(seed, options.kind, name, size)
        known.append({"effect": name, "size": size, "seed": seed, "estimates": fitted(case)})
        with options.lines.open("a") as file:
            file.write(json.dumps(known[-1]) + "\n")
        print(f"\r{len(known)} fits", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print(table(known))
    return 0


if __name__ == "__main__":
    sys.exit(main())
