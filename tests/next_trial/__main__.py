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


def slope(
    predicted: Sequence[float], realised: Sequence[float], groups: Sequence[int], weights: Sequence[float] | None = None
) -> tuple[float, float]:
    """Slope through the origin of realised on predicted, and its standard error.

    Trials of one campaign share the truth: the error is that of independent groups of unequal variances (Liang & Zeger
    1986, *Biometrika* 73).
    """
    x, y = np.asarray(predicted), np.asarray(realised)
    wx = x * (1.0 if weights is None else np.asarray(weights))
    if not np.any(wx):
        return float("nan"), float("nan")
    value = float(wx @ y / (wx @ x))
    _, group = np.unique(groups, return_inverse=True)
    return value, float(np.sqrt(np.sum(np.bincount(group, wx * (y - value * x)) ** 2)) / (wx @ x))


def compared(found: Sequence[Campaign], predicted: str, realised: str, unit: str) -> str:
    """Write the weighted means of what was predicted and realised, and the slope."""
    x, y, weights = ([float(getattr(each, name)) for each in found] for name in (predicted, realised, "weight"))
    value, error = slope(x, y, [each.seed for each in found], weights)
    means = f"predicted {np.average(x, weights=weights):.2f}, realised {np.average(y, weights=weights):.2f}{unit}"
    return f"{means}; slope {value:.2f} ± {error:.2f}"


SAID = (0.0, 0.7, 0.9, 0.97, 1.0)
"""Edges of the table of what trials were said to settle."""


def settled(found: Sequence[Campaign]) -> list[tuple[int, float, float]]:
    """How many trials were said to settle what to do about the vehicle with how much probability, and how many did.

    Parameters
    ----------
    found : sequence of Campaign

    Returns
    -------
    list of tuple
        Between the edges of `SAID`: number, weighted mean probability, weighted share in which the right thing is done.
    """
    known = np.array([(each.said, each.right, each.weight) for each in found if np.isfinite(each.said)]).reshape(-1, 3)
    place = np.searchsorted(SAID[1:-1], known[:, 0], side="right")
    parts = [known[place == k] for k in range(len(SAID) - 1)]
    return [(len(own), *np.average(own[:, :2], axis=0, weights=own[:, 2]).tolist()) for own in parts if len(own)]


def told(found: Sequence[Campaign]) -> str:
    """Write the figures."""
    among = [each for each in found if each.among]
    valued = [each for each in among if np.isfinite(each.saving)]
    campaigns, kept = (len({each.seed for each in part}) for part in (found, among))
    lines = [f"{campaigns} campaigns; the truth among the sets considered in {kept}, with {len(among)} trials"]
    lines.append(f"information: {compared(among, 'expected', 'gained', ' nats')}")
    if any(each.saving > 0.0 for each in valued):
        lines.append(f"saving, of {len(valued)} trials: {compared(valued, 'saving', 'saved', '')}")
    lines += [f"said to settle with {said:.2f}: {share:.2f} of {count} did" for count, said, share in settled(found)]
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
