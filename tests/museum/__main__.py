"""``python -m tests.museum``: what is said of faults before and after their mends, and of effects that have no name.

Prints the table of pairs, then the figures of logs with an effect outside the catalogue (half at 20 to 60 nats beyond
what named effects can be, half at 6 to 20), of logs without any, of logs with a named one, and of sets of dives with
an effect outside (half as drawn for hidden effects, half at 6 to 20 nats). ``--outside 200 --free 400 --named 100
--dives 100 --lines FILE`` for figures to publish.
"""

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import missionplan
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.results.learned import Diagnosis
from tests.hidden_effects.cases import draw_case
from tests.hidden_effects.dives import draw_worth
from tests.hidden_effects.dives.outside import OUTSIDE

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
SMALL = (6.0, 20.0)
"""Nats of what is hardly seen."""
Line = dict[str, Any]
"""What is in a case, and what is said of it."""


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


def outside_line(k: int, seed: int) -> Line:
    """Diagnose a log with an effect that has no name."""
    kinds = [*((name, build, "seen") for name, build in SEEN.items())]
    kinds += [(name, build, "unseen") for name, build in UNSEEN.items()]
    name, build, looked_at = kinds[k % len(kinds)]
    rng = np.random.default_rng([seed, k])
    is_strong = (k + k // len(kinds)) % 2 == 0
    errors = None
    while errors is None:
        log = drawn(rng, int(rng.integers(30, 90)))
        nats = rng.uniform(20.0, 60.0) if is_strong else rng.uniform(*SMALL)
        errors = sized(build, log, nats, seed + k)
    return {"name": name, "looked_at": looked_at, "nats": nats} | _said(diagnosed(log, errors, seed + k))


def free_line(k: int, seed: int) -> Line:
    """Diagnose a log without any effect."""
    rng = np.random.default_rng([seed, 1, k])
    log = drawn(rng, int(rng.integers(20, 90)))
    return _said(diagnosed(log, np.zeros((len(log.headings), 2)), seed + k))


def named_line(k: int, seed: int) -> Line:
    """Diagnose a log with an effect that has a name."""
    name = list(NAMED)[k % len(NAMED)]
    rng = np.random.default_rng([seed, 2, k])
    log = drawn(rng, int(rng.integers(30, 90)))
    return {"name": name} | _said(diagnosed(log, velocity_errors(log, NAMED[name](rng)), seed + k))


def dives_line(k: int, seed: int) -> Line:
    """Diagnose a set of dives with an effect that has no name: every other one worth 6 to 20 nats, kind by kind."""
    kinds = [name for name in OUTSIDE if name != "obstacle"]  # which stops the vehicle, however short it is
    kind = kinds[(seed + k // 2) % len(kinds)]
    case = draw_worth(seed + k, kind, SMALL) if k % 2 else draw_case(seed + k, "descent", "outside")
    with tempfile.TemporaryDirectory() as name:
        found = missionplan.diagnose(*case.write(Path(name) / "case", Path(name) / "truth"), plan=False)
    return {"name": case.outside, "nats": case.notes["nats_beyond_the_named"]} | _said(found)


def _said(found: Diagnosis) -> Line:
    return {
        "verdict": found.verdict,
        "causes": found.causes,
        "none_of_these": found.none_of_these,
        "flagged": is_flagged(found),
        "sets": [[each.causes, each.posterior] for each in found.ranking[:4]],
        "parameters": [[each.effect, each.name, each.value, each.sd] for each in found.best.parameters]
        if found.best is not None
        else [],
        "remainder": found.discrepancy.summary(),
    }


LINES = {"outside": outside_line, "free": free_line, "named": named_line, "dives": dives_line}


def figures(lines: Sequence[Line]) -> list[str]:
    """Count what is said of the cases of each kind; then those that were missed or named wrongly."""
    groups: dict[str, list[Line]] = {}
    for line in lines:
        groups.setdefault(_group(line), []).append(line)
    found = [f"{group}: {_counts(own)}" for group, own in groups.items()]
    return found + [_row(line) for line in lines if _is_missed(line)]


def _group(line: Line) -> str:
    if line["kind"] in ("free", "named"):
        return {"free": "without an effect", "named": "with a named effect"}[line["kind"]]
    held = "20 nats and more" if line["nats"] >= 20.0 else "6 to 20 nats" if line["nats"] >= 6.0 else "less"
    return f"dives, outside, {held}" if line["kind"] == "dives" else f"outside, {line['looked_at']}, {held}"


def _counts(own: Sequence[Line]) -> str:
    if own[0]["kind"] == "free":
        return f"terms {sum(map(_has_term, own))} of {len(own)}, any claim {sum(map(_is_missed, own))}"
    if own[0]["kind"] == "named":
        return f"named {len(own) - sum(map(_is_missed, own))} of {len(own)}"
    beside = sum(one["flagged"] and bool(_physical(one)) for one in own)
    wrong = sum(one["verdict"] == "explained" and not one["flagged"] for one in own)
    return f"flagged {sum(one['flagged'] for one in own)} of {len(own)}, wrong name {wrong}, a name beside {beside}"


def _has_term(line: Line) -> bool:
    return "response" in line["causes"] or line["none_of_these"] >= 0.5


def _physical(line: Line) -> list[str]:
    """Claimed causes with a name that are no statistical law."""
    return [name for name in line["causes"] if CATALOGUE[name].tier == "physical"]


def _is_missed(line: Line) -> bool:
    if line["kind"] == "free":
        return line["verdict"] != "adequate"
    return line["causes"] != [line["name"]] if line["kind"] == "named" else not line["flagged"]


def _row(line: Line) -> str:
    held = f" ({line['nats']:.0f} nats)" if "nats" in line else ""
    said = f"{line['verdict']} {'+'.join(line['causes'])} {line['none_of_these']:.2f}"
    return f"  {line['kind']} {line['k']} {line.get('name', '')}{held}: {said}"


def cases(counts: Mapping[str, int]) -> list[tuple[str, int]]:
    """Kinds and numbers of the cases, each kind's spread over the whole run."""
    drawn = [(kind, k) for kind, count in counts.items() for k in range(count)]
    return sorted(drawn, key=lambda case: (case[1] + 0.5) / counts[case[0]])


def lines_of(wanted: Sequence[tuple[str, int]], seed: int, file: Path | None) -> list[Line]:
    """Diagnose the cases that a file lacks, a line each, and return those of all."""
    text = file.read_text(encoding="utf-8") if file is not None and file.exists() else ""
    kept = {(line["kind"], line["k"]): line for line in map(json.loads, text.splitlines())}
    for kind, k in wanted:
        if (kind, k) not in kept:
            one = json.dumps({"kind": kind, "k": k, **LINES[kind](k, seed)}, default=float)
            kept[kind, k] = json.loads(one)
            if file is not None:
                with file.open("a", encoding="utf-8") as end:
                    end.write(one + "\n")
    return [kept[case] for case in wanted]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    for kind, count in {"outside": 20, "free": 10, "named": 8, "dives": 4}.items():
        parser.add_argument(f"--{kind}", type=int, default=count)
    parser.add_argument("--seed", type=int, default=42_000)
    parser.add_argument("--lines", type=Path, help="file of a line a case, continued with those that it lacks")
    parser.add_argument("--no-pairs", action="store_true", help="leave the table of pairs out")
    options = parser.parse_args(arguments)
    if not options.no_pairs:
        for row in pair_rows(options.seed):
            print(row, flush=True)
    wanted = cases({kind: getattr(options, kind) for kind in LINES})
    print(*figures(lines_of(wanted, options.seed, options.lines)), sep="\n")


if __name__ == "__main__":
    main()
