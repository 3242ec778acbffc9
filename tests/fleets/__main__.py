"""Fleets of missions, one after the other: each mission is diagnosed, its extended mission is the next one's.

``python -m tests.fleets --fleets 40`` prints the figures. Every vehicle has a compass that is off and a log that runs
slow. One of the two stays as it is, drifts, jumps once or is drawn anew each mission; the other stays. The legs are
sailed in steps of a minute with errors of their own, and each mission has nuisances of its own: a slight current, a
compass and a log that differ a little. With ``--dives`` it is a drag that stays or changes, in four dives a mission
(`dives`).
"""

import argparse
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from missionplan import diagnose
from missionplan.mission import Mission
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.levels import Level, ParameterLevels

from .dives import BEGIN, DAYS, DRAG, Diving
from .legs import COMPASS, LOG, Sailing

MISSIONS = 6
WAYS = ("constant", "drifting", "jumping", "redrawn")
CHANGES = {
    COMPASS: {"constant": 0.0, "drifting": np.radians(0.8), "jumping": np.radians(6.0), "redrawn": np.radians(2.0)},
    LOG: {"constant": 0.0, "drifting": 0.02, "jumping": 0.08, "redrawn": 0.02},
    DRAG: {"constant": 0.0, "drifting": 0.06, "jumping": 0.25, "redrawn": 0.06},
}
"""Change a mission, greatest jump, standard deviation of what is drawn anew."""


@dataclass(frozen=True)
class Fleet:
    """What one vehicle showed in its missions.

    Attributes
    ----------
    way, changing : str
        How the vehicle changes, and what of it does.
    held, beside : tuple of bool
        Whether the 90 % interval of that level, at its date, held the truth, and likewise of the level that stays.
    gains : tuple of float
        Log scores of legs unseen in the third and the last mission, over starting afresh [nats].
    trend, jump : bool or None
        Whether a trend was told at the end, and a jump at its mission; None where there was none to tell.
    false_trend : bool
        Whether a trend was told of what does not drift.
    """

    way: str
    changing: str
    held: tuple[bool, ...]
    beside: tuple[bool, ...]
    gains: tuple[float, ...]
    trend: bool | None
    jump: bool | None
    false_trend: bool


def levels_of(rng: np.random.Generator, way: str, changing: str) -> tuple[dict[str, np.ndarray], int | None]:
    """Draw the levels of a vehicle's parameters in each mission [rad, –, –], and the mission that jumps."""
    if changing == DRAG:
        found = {DRAG: np.full(MISSIONS, rng.uniform(0.1, 0.35))}
    else:
        found = {
            COMPASS: np.full(MISSIONS, np.radians(rng.uniform(2.0, 6.0)) * rng.choice([-1.0, 1.0])),
            LOG: np.full(MISSIONS, rng.uniform(-0.08, -0.03)),
        }
    at = int(rng.integers(2, 5)) if way == "jumping" else None
    change = {
        "constant": np.zeros(MISSIONS),
        "drifting": np.arange(MISSIONS) * rng.choice([-1.0, 1.0]),
        "jumping": (np.arange(MISSIONS) >= (at or 0)) * rng.choice([-1.0, 1.0]) * rng.uniform(0.7, 1.0),
        "redrawn": rng.standard_normal(MISSIONS),
    }[way]
    found[changing] = found[changing] + CHANGES[changing][way] * change
    return found, at


def extended(found: Diagnosis) -> Mission:
    return Mission.from_data(found.extended)


def kind_of(seed: int, dives: bool = False) -> tuple[str, str]:
    """Return how a vehicle of that seed changes, and what of it does."""
    return WAYS[seed % 4], DRAG if dives else (COMPASS, LOG)[seed // 4 % 2]


def number_of(level: Level, told: ParameterLevels) -> int:
    """Return the number of the mission that a level is of: by its date, else as they came."""
    if level.date is None:
        return told.missions.index(level)
    return round((level.date - BEGIN.timestamp()) / (DAYS * 86400.0))


def run(seed: int, dives: bool = False) -> Fleet:
    """Make and diagnose one vehicle's missions."""
    rng = np.random.default_rng([seed, 77])
    way, changing = kind_of(seed, dives)
    truths, at = levels_of(rng, way, changing)
    vehicle = (Diving if dives else Sailing)(rng, truths)
    fresh = mission = vehicle.mission
    held: dict[str, list[bool]] = {effect: [] for effect in truths}
    gains: list[float] = []
    trend = jump = None
    false_trend = False
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(MISSIONS):
            record = vehicle.record(number)
            if number in (2, MISSIONS - 1) and number != at:
                parts = enumerate(vehicle.halves(record))
                learned, unseen = (vehicle.data(folder / f"{number}-{i}", half) for i, half in parts)
                known, anew = (diagnose(each, learned, plan=False) for each in (mission, fresh))
                gains.append(vehicle.score(extended(known), unseen) - vehicle.score(extended(anew), unseen))
            found = diagnose(mission, vehicle.data(folder / f"{number}", record), plan=False)
            mission = extended(found)
            told = {each.effect: each for each in found.levels}
            for effect in told.keys() & truths.keys():
                last = told[effect].missions[-1]
                truth = truths[effect][number_of(last, told[effect])]
                held[effect].append(bool(abs(last.value - truth) < 1.645 * last.sd))
            one = told.get(changing)
            if at is not None and one is not None and number in (at, at + 1):
                jump = bool(jump) or at in (number_of(each, one) for each in one.jumps)
            drifts = {effect for effect, each in told.items() if each.has_trend}
            trend = changing in drifts if way == "drifting" else None
            false_trend |= bool(drifts - ({changing} if way == "drifting" else set()))
    beside = [inside for effect, own in held.items() if effect != changing for inside in own]
    jump = None if at is None else bool(jump)
    return Fleet(way, changing, tuple(held[changing]), tuple(beside), tuple(gains), trend, jump, false_trend)


def table(found: Mapping[int, Fleet]) -> str:
    """Coverage, gains, trends and jumps by the way in which the vehicles change."""
    lines = []
    for way in WAYS:
        own = [each for each in found.values() if each.way == way]
        if not own:
            continue
        held, beside, gains = (
            [value for each in own for value in getattr(each, name)] for name in ("held", "beside", "gains")
        )
        named = [bool(value) for each in own for value in (each.trend, each.jump) if value is not None]
        lines.append(
            f"{way}: {len(own)} vehicles; 90 % intervals hold {np.mean(held):.3f} of {len(held)}"
            + (f", of the level that stays {np.mean(beside):.3f} of {len(beside)}" if beside else "")
            + f"; over starting afresh {np.mean(gains):+.2f} nats; false trends {sum(each.false_trend for each in own)}"
            + (f"; named {sum(named)} of {len(named)}" if named else "")
        )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fleets", description=__doc__)
    parser.add_argument("--fleets", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--dives", action="store_true")
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.fleets)
    with ProcessPoolExecutor(chosen.jobs) as pool:
        made = pool.map(partial(run, dives=chosen.dives), seeds)
        print(table(dict(zip(seeds, made, strict=True))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
