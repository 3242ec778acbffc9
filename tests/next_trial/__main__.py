"""Predicted beside realised worth of trials: ``python -m tests.next_trial --cases 100``; resumed where it ended."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from . import campaign, dive_campaign
from .campaign import Campaign, recorded

KINDS = {"transit": campaign.made, "descent": dive_campaign.made}


def slope(predicted: Sequence[float], realised: Sequence[float]) -> tuple[float, float]:
    """Slope through the origin of realised on predicted, and its standard error (of unequal variances)."""
    x, y = np.asarray(predicted), np.asarray(realised)
    if not np.any(x):
        return float("nan"), float("nan")
    value = float(x @ y / (x @ x))
    return value, float(np.sqrt(np.sum((x * (y - value * x)) ** 2)) / (x @ x))


def told(found: Sequence[Campaign]) -> str:
    """Write the figures."""
    among = [each for each in found if each.among]
    information = slope([each.expected for each in among], [each.gained for each in among])
    lines = [
        f"{len(found)} campaigns; the truth among the sets considered in {len(among)}",
        f"information: expected {np.mean([e.expected for e in among]):.2f}, gained "
        f"{np.mean([e.gained for e in among]):.2f} nats; slope {information[0]:.2f} ± {information[1]:.2f}",
    ]
    predicted, saved = (np.array([getattr(each, name) for each in found]) for name in ("saving", "saved"))
    if np.any(np.nan_to_num(predicted) > 0.0):
        value, error = slope(predicted.tolist(), saved.tolist())
        lines.append(
            f"saving: predicted {predicted.mean():.2f}, realised {saved.mean():.2f} ± "
            f"{saved.std() / np.sqrt(len(found)):.2f} min; slope {value:.2f} ± {error:.2f}"
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
        found.append(recorded(options.folder / options.kind, seed, KINDS[options.kind]))
        last = found[-1]
        print(
            f"{last.seed} {last.causes}, {last.design}: {last.expected:.2f} → {last.gained:.2f} nats, "
            f"{last.saving:.2f} → {last.saved:.2f} min",
            flush=True,
        )
    print(told(found))


if __name__ == "__main__":
    main()
