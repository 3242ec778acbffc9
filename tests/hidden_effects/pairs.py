"""``python -m tests.hidden_effects.pairs``: how much the data of dives can tell of two causes at once.

Each hidden pair is drawn several times: the same plan, causes and sizes, with other random errors of dives and log. The
mean, over the repeats, of the log Bayes factor of the true pair over the best other set of causes is an estimate of the expected
log Bayes factor at the truth: where it is below some 3 nats, data of this kind do not tell the pair from its rival, and a
pair that is not claimed in full is no fault of the method. A pair is not ranked where, in one of the repeats, its second
cause adds less to the first than a cause has to. Each pair is a line of a file; those in it are not run again.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import dives
from .tool import Outcome, diagnose

TOLD = 3.0
"""Nats from which a pair is called told from its rival."""


def margin(outcome: Outcome) -> tuple[float, tuple[str, ...]]:
    """Log Bayes factor of the true pair over the best other set of the ranking, and that set; -inf if not ranked."""
    ranking = outcome.diagnosis.get("ranking", [])
    scores = {tuple(sorted(each["causes"])): float(each["log_bayes_factor"]) for each in ranking}
    truth = scores.pop(outcome.case.truth, -np.inf)
    rivals = {causes: score for causes, score in scores.items() if not set(causes) > set(outcome.case.truth)}
    best = max(rivals, key=lambda causes: rivals[causes]) if rivals else ()
    return truth - max(rivals.get(best, 0.0), 0.0), best


def run(seed: int, repeats: int) -> dict[str, Any]:
    """Diagnose the repeats of one pair."""
    found = []
    for repeat in range(repeats):
        case = dives.draw(seed, "pair", repeat=repeat)
        with tempfile.TemporaryDirectory() as folder:
            outcome = diagnose(case, Path(folder) / "cases", Path(folder) / "truths", in_process=True)
        told, rival = margin(outcome)
        claimed = case.accepts(outcome.diagnosis.get("causes", []))
        found.append({"margin": told, "rival": rival, "claimed": claimed, "error": outcome.error})
    return {"seed": seed, "truth": case.truth, "repeats": found}


def table(pairs: Sequence[dict[str, Any]]) -> str:
    """Each pair with its mean margin and how often it was claimed; then the shares, told and not told."""
    lines, shares = [], {True: [0, 0], False: [0, 0]}
    for each in pairs:
        margins = np.array([one["margin"] for one in each["repeats"]])
        claims = [one["claimed"] for one in each["repeats"]]
        rivals = [" + ".join(one["rival"]) for one in each["repeats"]]
        ranked = bool(np.isfinite(margins).all())
        mean = margins.mean() if ranked else -np.inf
        error = margins.std(ddof=1) / np.sqrt(margins.size) if ranked and margins.size > 1 else np.nan
        counts = shares[bool(mean >= TOLD)]
        counts[0] += sum(claims)
        counts[1] += len(claims)
        lines.append(
            f"| {' + '.join(each['truth'])} | {max(set(rivals), key=rivals.count) or 'none'} "
            f"| {f'{mean:.1f} ± {error:.1f}' if ranked else 'not ranked'} | {sum(claims)} of {len(claims)} |"
        )
    head = ["| pair | usual rival | log Bayes factor, mean | claimed in full |", "|---|---|---|---|"]
    ends = [
        f"{'told' if told else 'not told'} (mean {'≥' if told else '<'} {TOLD:g} nats): {hits} of {count} claimed in full"
        for told, (hits, count) in shares.items()
    ]
    return "\n".join([*head, *lines, "", *ends])


def main(words: Sequence[str] | None = None) -> int:
    """Run the pairs that a file lacks, and print the table of all that it has."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_effects.pairs", description=__doc__)
    parser.add_argument("--lines", type=Path, required=True, help="file of results, continued where it ends")
    parser.add_argument("--pairs", type=int, default=24)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--seed", type=int, default=61_000_000)
    options = parser.parse_args(words)
    known = [json.loads(line) for line in options.lines.read_text().splitlines()] if options.lines.exists() else []
    done = {each["seed"] for each in known}
    for seed in range(options.seed, options.seed + options.pairs):
        if seed in done:
            continue
        known.append(run(seed, options.repeats))
        with options.lines.open("a") as file:
            file.write(json.dumps(known[-1]) + "\n")
        print(f"{len(known)} pairs, last {known[-1]['truth']}", file=sys.stderr, flush=True)
    print(table(known))
    return 0


if __name__ == "__main__":
    sys.exit(main())
