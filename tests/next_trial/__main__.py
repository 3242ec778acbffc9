"""Predicted beside realised worth of trials: ``python -m tests.next_trial --cases 100``; resumed where it ended."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from . import campaign, dive_campaign
from .campaign import Campaign, recorded

KINDS = {"transit": campaign.made, "descent": dive_campaign.made}
UNITS = {"transit": "min", "descent": "%"}
"""Of the savings; those of dives over the loss expected before."""


def slope(predicted: Sequence[float], realised: Sequence[float], groups: Sequence[int]) -> tuple[float, float]:
    """Slope through the origin of realised on predicted, and its standard error.

    Trials of one campaign share the truth: the error is that of independent groups of unequal variances (Liang & Zeger
    1986, *Biometrika* 73).
    """
    x, y = np.asarray(predicted), np.asarray(realised)
    if not np.any(x):
        return float("nan"), float("nan")
    value = float(x @ y / (x @ x))
    _, group = np.unique(groups, return_inverse=True)
    return value, float(np.sqrt(np.sum(np.bincount(group, x * (y - value * x)) ** 2)) / (x @ x))


def told(found: Sequence[Campaign]) -> str:
    """Write the figures."""
    among = [each for each in found if each.among]
    seeds = [each.seed for each in among]
    information = slope([each.expected for each in among], [each.gained for each in among], seeds)
    lines = [
        f"{len({each.seed for each in found})} campaigns; the truth among the sets considered in {len(set(seeds))}, "
        f"with {len(among)} trials",
        f"information: expected {np.mean([e.expected for e in among]):.2f}, gained "
        f"{np.mean([e.gained for e in among]):.2f} nats; slope {information[0]:.2f} ± {information[1]:.2f}",
    ]
    predicted, saved = (np.array([getattr(each, name) for each in among]) for name in ("saving", "saved"))
    if np.any(predicted > 0.0):
        value, error = slope(predicted.tolist(), saved.tolist(), seeds)
        lines.append(
            f"saving: predicted {predicted.mean():.2f}, realised {saved.mean():.2f}; slope {value:.2f} ± {error:.2f}"
        )
    return "\n".join(lines)


def main() -> None:
    """Make campaigns one after the other and tell what they showed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--kind", choices=list(KINDS), default="transit")
    parser.add_argument("--folder", type=Path, default=Path("next-trial-cases"))
    options = parser.parse_args()
    found: list[Campaign] = []
    for seed in range(options.seed, options.seed + options.cases):
        for each in recorded(options.folder / options.kind, seed, KINDS[options.kind]):
            found.append(each)
            print(
                f"{each.seed} {each.causes}, {each.design}: {each.expected:.2f} → {each.gained:.2f} nats, "
                f"{each.saving:.2f} → {each.saved:.2f} {UNITS[options.kind]}",
                flush=True,
            )
    print(told(found))


if __name__ == "__main__":
    main()
