"""How well the tool did: the confusion matrix and the figures asked for."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binom

from .dives import outside as dive_outside
from .legs import outside as leg_outside
from .tool import Outcome

STUDIED = dive_outside.STUDIED | leg_outside.STUDIED
DESCRIPTIONS = {"persistent-error", "heavy-tails", "random-walk", "fix-error"}
"""Causes that only describe; naming one says that no physical cause was found."""
UNITS = {
    **dict.fromkeys(("", "1", "m", "s", "N", "m/s", "s/m", "rad", "1/s", "dimensionless"), 1.0),
    **{"deg": np.pi / 180.0, "%": 0.01, "min": 60.0, "h": 3600.0, "cm/s": 0.01, "mm/s": 0.001, "km": 1000.0},
    **dict.fromkeys(("m/s/s^0.5", "m/s^1.5", "m/s**1.5", "m/s/sqrt(s)", "m/s/√s"), 1.0),
}
MIX = {"descent": 492, "transit": 300}
"""Cases of each kind in the trial of the method that the held-out error asked of all together comes from."""
DOUBT = 0.01
"""A share is called worse than asked when chance alone gives it less often than this."""


@dataclass(frozen=True)
class Figure:
    """One figure: its value, from how many cases, and what is asked of it."""

    name: str
    value: float
    cases: int
    low: float | None = None
    high: float | None = None
    is_share: bool = True

    @property
    def asked(self) -> str:
        """The limits in words."""
        parts = [f"≥ {self.low:g}" if self.low is not None else "", f"≤ {self.high:g}" if self.high is not None else ""]
        return " and ".join(part for part in parts if part) or "–"

    @property
    def met(self) -> bool:
        """Whether the value itself is within the limits."""
        if self.cases == 0:
            return True
        return (self.low is None or self.value >= self.low) and (self.high is None or self.value <= self.high)

    @property
    def refuted(self) -> bool:
        """Whether so few cases are enough to say that the figure is not reached."""
        if self.cases == 0 or self.met:
            return False
        if not self.is_share:
            return True
        hits = round(self.value * self.cases)
        below = self.low is not None and binom.cdf(hits, self.cases, self.low) < DOUBT
        above = self.high is not None and binom.sf(hits - 1, self.cases, self.high) < DOUBT
        return bool(below or above)


def named(outcome: Outcome) -> list[str]:
    """Causes that the tool claims."""
    return [str(cause) for cause in outcome.diagnosis.get("causes", [])]


def best(outcome: Outcome) -> dict[str, Any]:
    """Entry of the ranking that belongs to the causes claimed; else the first that has a cause; else empty."""
    ranking = [entry for entry in outcome.diagnosis.get("ranking", []) if entry["causes"]]
    claimed = sorted(named(outcome))
    match = [entry for entry in ranking if claimed and sorted(entry["causes"]) == claimed]
    return (match or ranking or [{}])[0]


def is_false_alarm(outcome: Outcome) -> bool:
    """Anything but ``adequate`` where there is nothing."""
    return outcome.diagnosis.get("verdict") != "adequate"


def in_credible_set(outcome: Outcome) -> bool:
    """Whether the truth, or what is exactly tied with it, is among the credible sets."""
    return any(outcome.case.accepts(causes) for causes in outcome.diagnosis.get("credible_set", []))


def asserts_wrongly(outcome: Outcome) -> bool:
    """A single wrong explanation given as the explanation."""
    return outcome.diagnosis.get("verdict") == "explained" and not outcome.case.accepts(named(outcome))


def is_flagged(outcome: Outcome) -> bool:
    """The verdict itself says that something is left, or that nothing fits."""
    return outcome.diagnosis.get("verdict") in ("unexplained", "partly-explained")


def is_not_misnamed(outcome: Outcome) -> bool:
    """Flagged, or named only by a statistical description, which disclaims a physical cause."""
    return is_flagged(outcome) or (bool(named(outcome)) and set(named(outcome)) <= DESCRIPTIONS)


def covered(outcome: Outcome) -> list[bool]:
    """For each parameter known in the contract's form, whether its 90 % interval holds the true value."""
    if not outcome.case.accepts(named(outcome)):
        return []
    hits = []
    for entry in best(outcome).get("parameters", []):
        true = outcome.case.parameters.get(f"{entry['effect']}.{entry['name']}")
        factor = UNITS.get(entry.get("unit") or "")
        if true is not None and factor is not None:
            low, high = sorted((factor * entry["low"], factor * entry["high"]))
            if entry["name"] == "amplitude" and high < 0.0:  # half a turn of the phase
                low, high = -high, -low
            hits.append(low <= true <= high)
    return hits


def gain(outcome: Outcome) -> float | None:
    """Held-out RMSE of the extended over that of the base model, for a right claim."""
    held = best(outcome).get("held_out") or {}
    if not named(outcome) or not held.get("rmse_base") or held.get("rmse_extended") is None:
        return None
    return float(held["rmse_extended"]) / float(held["rmse_base"])


def _share(name: str, hits: Sequence[bool], low: float | None = None, high: float | None = None) -> Figure:
    return Figure(name, float(np.mean(hits)) if hits else float("nan"), len(hits), low, high)


def figures(outcomes: Sequence[Outcome]) -> list[Figure]:
    """Figures of outcomes. A run that failed counts against every figure it belongs to."""
    by: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        by.setdefault(outcome.case.scenario, []).append(outcome)
    controls, single, weak = by.get("control", []), by.get("single", []), by.get("weak", [])
    pairs, outside, ties = by.get("pair", []), by.get("outside", []), by.get("tie", [])
    blind = [o for o in outside if o.case.outside not in STUDIED]
    studied = [o for o in outside if o.case.outside in STUDIED]
    kinds = {o.case.kind for o in outcomes}
    right = {("descent",): 0.93, ("transit",): 0.95}.get(tuple(kinds))
    kept = None if kinds == {"transit"} else 0.6  # of legs by themselves it cannot be asked: docs/diagnosis.md
    clocks = [o.seconds for o in outcomes]
    sizes = [float(len(o.diagnosis.get("credible_set", []))) for o in single]
    return [
        _share("runs that failed", [bool(o.error) for o in outcomes], high=0.0),
        _share("false alarms without an effect", [is_false_alarm(o) for o in controls], high=0.03),
        _share("right cause claimed, modulo exact ties", [o.case.accepts(named(o)) for o in single], low=right),
        _share("right cause first in the ranking", [o.case.accepts(best(o).get("causes", [])) for o in single]),
        _share("truth in the 95 % set", [in_credible_set(o) for o in single], low=0.95),
        Figure("mean size of the 95 % set", _mean(sizes), len(sizes), high=2.0, is_share=False),
        _share("two effects: exact", [o.case.accepts(named(o)) for o in pairs], low=0.75),
        _share("two effects: truth in the 95 % set", [in_credible_set(o) for o in pairs]),
        _share("two effects: at least one", [bool(set(o.case.truth) & set(named(o))) for o in pairs], low=0.95),
        _share("wrong name asserted on a weak effect", [bool(o.error) or asserts_wrongly(o) for o in weak], high=0.10),
        _share("outside the catalogue, blind: flagged", [is_not_misnamed(o) for o in blind], low=0.70),
        _share("outside the catalogue, blind: flagged by the verdict", [is_flagged(o) for o in blind]),
        _share("outside the catalogue, studied: flagged", [is_not_misnamed(o) for o in studied]),
        _share("exact tie: one of the tied claimed", [o.case.accepts(named(o)) for o in ties]),
        _share("exact tie: truth in the 95 % set", [list(o.case.truth) in _sets(o) for o in ties]),
        _share("90 % intervals cover", [hit for o in single + pairs for hit in covered(o)], low=0.85, high=0.98),
        Figure("held-out RMSE, extended / base, median", *_gain(single + pairs), high=kept, is_share=False),
        Figure("time, median [s]", _median(clocks), len(clocks), high=15.0, is_share=False),
        Figure("time, longest [s]", max(clocks, default=float("nan")), len(clocks), is_share=False),
    ]


def _gain(outcomes: Sequence[Outcome]) -> tuple[float, int]:
    """Median of the held-out ratios and their number; kinds weigh as in `MIX`, however many there are of each."""
    found = sorted((ratio, o.case.kind) for o in outcomes if (ratio := gain(o)) is not None)
    if not found:
        return float("nan"), 0
    counts = Counter(kind for _, kind in found)
    weights = np.cumsum([MIX[kind] / counts[kind] for _, kind in found])
    return found[int(np.searchsorted(weights, 0.5 * weights[-1]))][0], len(found)


def _sets(outcome: Outcome) -> list[list[str]]:
    return [sorted(causes) for causes in outcome.diagnosis.get("credible_set", [])]


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def confusion(outcomes: Sequence[Outcome]) -> dict[str, Counter[str]]:
    """Counts of what was claimed, by what was there; an outside effect is in brackets."""
    table: dict[str, Counter[str]] = {}
    for outcome in outcomes:
        case = outcome.case
        row = f"({case.outside})" if case.outside else " + ".join(case.truth) or "nothing"
        claim = "failed" if outcome.error else " + ".join(sorted(named(outcome))) or "nothing"
        if is_flagged(outcome):
            claim += " …"
        table.setdefault(f"{row} [{case.scenario}]", Counter())[claim] += 1
    return dict(sorted(table.items()))


def text(outcomes: Sequence[Outcome]) -> str:
    """The page that ``python -m tests.hidden_effects`` prints."""
    lines: list[str] = []
    for kind in ("descent", "transit"):
        chosen = [outcome for outcome in outcomes if outcome.case.kind == kind]
        if not chosen:
            continue
        lines += [f"{kind}: {len(chosen)} cases", "", "there → claimed (… = and something is left)"]
        for row, counts in confusion(chosen).items():
            total = sum(counts.values())
            claims = ", ".join(f"{claim} {count}" for claim, count in counts.most_common())
            lines.append(f"  {row:<52} {total:>3} → {claims}")
        lines += _table(figures(chosen))
        lines += ["", *(f"  failed: {o.case.name}: {o.error}" for o in chosen if o.error), ""]
    lines += ["all kinds together", *_table(figures(outcomes)), ""]
    return "\n".join(lines)


def _table(found: Sequence[Figure]) -> list[str]:
    lines = ["", f"  {'figure':<52} {'value':>8} {'cases':>6}  asked"]
    for figure in found:
        mark = "" if figure.met else "  not met" + ("" if figure.refuted else " (within chance)")
        lines.append(f"  {figure.name:<52} {figure.value:>8.3f} {figure.cases:>6}  {figure.asked}{mark}")
    return lines
