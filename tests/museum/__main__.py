"""``python -m tests.museum``: what is said of faults before and after their mends, and of effects that have no name.

Prints the table of pairs, then the figures of logs with an effect outside the catalogue (half at 20 to 60 nats beyond
what named effects can be, half at 6 to 20), of logs without any, and of logs with a named one. ``--outside 200 --free
400 --named 100`` for figures to publish.
"""

import argparse
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

import missionplan
from missionplan.mission import Mission
from missionplan.results.learned.diagnosis import Diagnosis

from .faults import PAIRS, Pair, log_of_pair, still_speed
from .outside import SEEN, UNSEEN, sized
from .sailing import Array, Log, Moment, Recipe, drawn, mission, velocity_errors, write

NAMED: dict[str, Callable[[np.random.Generator], Recipe]] = {
    "compass-bias": lambda rng: _turned(rng, lambda m: 1.0),
    "compass-deviation": lambda rng: _turned(rng, lambda m: np.cos(m.heading - 1.0)),
    "speed-scale": lambda rng: _paced(rng),
    "mean-current": lambda rng: _carried(rng),
}
STATISTICAL = {"persistent-error", "heavy-tails", "random-walk", "fix-error", "position-random-walk"}


def _turned(rng: np.random.Generator, shape: Callable[[Moment], float]) -> Recipe:
    angle = float(np.radians(rng.uniform(3.0, 9.0)))
    return Recipe(turn=lambda m: angle * shape(m))


def _paced(rng: np.random.Generator) -> Recipe:
    factor = 1.0 + float(rng.uniform(0.04, 0.12))
    return Recipe(pace=lambda m: factor)


def _carried(rng: np.random.Generator) -> Recipe:
    angle, size = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.05, 0.2)
    return Recipe(water=lambda m: size * np.array([np.sin(angle), np.cos(angle)]))


def diagnosed(log: Log, errors: Array, seed: int) -> Diagnosis:
    """Diagnose a log with these errors and noise."""
    with tempfile.TemporaryDirectory() as name:
        data = write(Path(name) / "legs", log, errors, np.random.default_rng(seed))
        return missionplan.diagnose(Mission.from_data(mission(log)), data, plan=False)


def is_flagged(found: Diagnosis) -> bool:
    """Whether it is said that something without a name is there, or no physical cause is."""
    only_described = bool(found.causes) and set(found.causes) <= STATISTICAL | {"response"}
    return found.verdict in ("unexplained", "partly-explained") or "response" in found.causes or only_described


def pair_rows(seed: int) -> Iterator[str]:
    """Diagnose all pairs; a row each."""
    for number, (name, pair) in enumerate(PAIRS.items()):
        rng = np.random.default_rng([seed, number])
        log = log_of_pair(rng, pair.speeds)
        if "advance" in name:
            log = Log(log.headings, log.under_way, np.full_like(log.speeds, still_speed()), log.depths, 0.015, 2.0)
        before, after = (diagnosed(log, velocity_errors(log, r), seed + number) for r in (pair.before, pair.after))
        yield f"{name:42s} before: {_told(before, pair)}; after: {_after(after, pair)}"


def is_described(found: Diagnosis, pair: Pair) -> bool:
    """Whether the changed term is named rightly or described."""
    named = any(names <= set(found.causes) for names in pair.names)
    sizes = found.best.parameters if found.best is not None and found.causes else ()
    return named or (bool(pair.response) and any(pair.response in each.name for each in sizes))


def _told(found: Diagnosis, pair: Pair) -> str:
    causes = "+".join(found.causes) or "nothing"
    is_wrong = found.verdict == "explained" and not is_described(found, pair)
    return f"{found.verdict} {causes} ({'described' if is_described(found, pair) else 'WRONG' if is_wrong else 'flagged' if is_flagged(found) else 'not seen'})"


def _after(found: Diagnosis, pair: Pair) -> str:
    right = set(found.causes) == pair.mended or (found.verdict == "adequate" and not pair.mended)
    return f"{found.verdict} {'+'.join(found.causes) or 'nothing'} ({'right' if right else 'NOT right'})"


def outside_figures(count: int, seed: int) -> list[str]:
    """Diagnose logs with effects that have no name."""
    kinds = [*((name, build, "seen") for name, build in SEEN.items())]
    kinds += [(name, build, "unseen") for name, build in UNSEEN.items()]
    found: dict[tuple[str, bool], list[tuple[bool, bool, float]]] = {}
    missed = []
    for k in range(count):
        name, build, looked_at = kinds[k % len(kinds)]
        rng = np.random.default_rng([seed, k])
        is_strong = (k // len(kinds)) % 2 == 0
        errors = None
        while errors is None:
            log = drawn(rng, int(rng.integers(30, 90)))
            nats = rng.uniform(20.0, 60.0) if is_strong else rng.uniform(6.0, 20.0)
            errors = sized(build, log, nats, seed + k)
        said = diagnosed(log, errors, seed + k)
        flagged, wrong = is_flagged(said), said.verdict == "explained" and not is_flagged(said)
        found.setdefault((looked_at, is_strong), []).append((flagged, wrong, said.none_of_these))
        if not flagged:
            missed.append(
                f"  {name} ({nats:.0f} nats): {said.verdict} {'+'.join(said.causes)} {said.none_of_these:.2f}"
            )
    lines = []
    for (looked_at, is_strong), each in found.items():
        flagged, wrong = sum(one[0] for one in each), sum(one[1] for one in each)
        strength = "20 nats and more" if is_strong else "6 to 20 nats"
        lines.append(f"outside, {looked_at}, {strength}: flagged {flagged} of {len(each)}, wrong name {wrong}")
    return lines + missed


def free_figures(count: int, seed: int) -> list[str]:
    """Diagnose logs without any effect."""
    said = []
    for k in range(count):
        rng = np.random.default_rng([seed, 1, k])
        log = drawn(rng, int(rng.integers(20, 90)))
        said.append(diagnosed(log, np.zeros((len(log.headings), 2)), seed + k))
    terms = sum("response" in one.causes or one.none_of_these >= 0.5 for one in said)
    return [f"without an effect: terms {terms} of {count}, any claim {sum(one.verdict != 'adequate' for one in said)}"]


def named_figures(count: int, seed: int) -> list[str]:
    """Diagnose logs with an effect that has a name."""
    right, missed = 0, []
    for k in range(count):
        name = list(NAMED)[k % len(NAMED)]
        rng = np.random.default_rng([seed, 2, k])
        log = drawn(rng, int(rng.integers(30, 90)))
        said = diagnosed(log, velocity_errors(log, NAMED[name](rng)), seed + k)
        right += said.causes == (name,)
        if said.causes != (name,):
            missed.append(f"  {name}: {said.verdict} {'+'.join(said.causes)}")
    return [f"with a named effect: named {right} of {count}", *missed]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--outside", type=int, default=20)
    parser.add_argument("--free", type=int, default=10)
    parser.add_argument("--named", type=int, default=8)
    parser.add_argument("--seed", type=int, default=42_000)
    options = parser.parse_args(arguments)
    for row in pair_rows(options.seed):
        print(row, flush=True)
    counts = ((outside_figures, options.outside), (free_figures, options.free), (named_figures, options.named))
    for figures, count in counts:
        print(*figures(count, options.seed), sep="\n", flush=True)


if __name__ == "__main__":
    main()
