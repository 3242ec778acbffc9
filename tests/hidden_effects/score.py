"""Score of the tool: the confusion matrix and the figures with their targets."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binom, t

from .dives import outside as dive_outside
from .legs import outside as leg_outside
from .tool import Outcome

STUDIED = dive_outside.STUDIED | leg_outside.STUDIED
DESCRIPTIONS = {"persistent-error", "heavy-tails", "random-walk", "fix-error"}
"""Statistical descriptions; claiming one says that no physical cause was found."""
UNITS = {
    **dict.fromkeys(("", "1", "m", "s", "N", "m/s", "s/m", "rad", "1/s", "dimensionless"), 1.0),
    **{"deg": np.pi / 180.0, "%": 0.01, "min": 60.0, "h": 3600.0, "cm/s": 0.01, "mm/s": 0.001, "km": 1000.0},
    **dict.fromkeys(("m/s/s^0.5", "m/s^1.5", "m/s**1.5", "m/s/sqrt(s)", "m/s/√s"), 1.0),
}
KIND_WEIGHTS = {"descent": 492, "transit": 300}
"""Weights of the kinds for the held-out error: their cases in the trial of the method that its target comes from."""
SIGNIFICANCE = 0.01
"""Level at which a share or a mean refutes its target (one-sided: binomial, Student's t)."""


@dataclass(frozen=True)
class Figure:
    """One figure: its value, its number of cases, and its target."""

    name: str
    value: float
    cases: int
    low: float | None = None
    high: float | None = None
    is_share: bool = True
    error: float = 0.0
    """Standard error of a mean; 0 where the value is judged as it stands."""

    @property
    def target(self) -> str:
        """Limits as text."""
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
        """Whether the target is missed by more than chance with this number of cases."""
        if self.cases == 0 or self.met:
            return False
        if not self.is_share:
            away = max(
                (-np.inf if self.low is None else self.low) - self.value,
                self.value - (np.inf if self.high is None else self.high),
            )
            return self.error == 0.0 or bool(t.sf(away / self.error, self.cases - 1) < SIGNIFICANCE)
        hits = round(self.value * self.cases)
        below = self.low is not None and binom.cdf(hits, self.cases, self.low) < SIGNIFICANCE
        above = self.high is not None and binom.sf(hits - 1, self.cases, self.high) < SIGNIFICANCE
        return bool(below or above)


def claimed(outcome: Outcome) -> list[str]:
    """Return the causes that the tool claims."""
    return [str(cause) for cause in outcome.diagnosis.get("causes", [])]


def claimed_entry(outcome: Outcome) -> dict[str, Any]:
    """Return the claimed entry of the ranking; else the first with a cause; else an empty one."""
    ranking = [entry for entry in outcome.diagnosis.get("ranking", []) if entry["causes"]]
    causes = sorted(claimed(outcome))
    match = [entry for entry in ranking if causes and sorted(entry["causes"]) == causes]
    return (match or ranking or [{}])[0]


def is_false_alarm(outcome: Outcome) -> bool:
    """Whether a control has any verdict but ``adequate``."""
    return outcome.diagnosis.get("verdict") != "adequate"


def in_credible_set(outcome: Outcome) -> bool:
    """Whether the truth, or an exact tie, is among the credible sets."""
    return any(outcome.case.accepts(causes) for causes in outcome.diagnosis.get("credible_set", []))


def is_wrong_claim(outcome: Outcome) -> bool:
    """Whether a wrong set of causes has the verdict ``explained``."""
    return outcome.diagnosis.get("verdict") == "explained" and not outcome.case.accepts(claimed(outcome))


def is_flagged(outcome: Outcome) -> bool:
    """Whether the verdict itself reports a discrepancy."""
    return outcome.diagnosis.get("verdict") in ("unexplained", "partly-explained")


def is_flagged_or_descriptive(outcome: Outcome) -> bool:
    """Whether it is flagged, or only a statistical description is claimed, which disclaims a physical cause."""
    return is_flagged(outcome) or (bool(claimed(outcome)) and set(claimed(outcome)) <= DESCRIPTIONS)


def covered(outcome: Outcome) -> list[bool]:
    """For each parameter shared with the contract, whether its 90 % interval contains the true value."""
    if not outcome.case.accepts(claimed(outcome)):
        return []
    hits = []
    for entry in claimed_entry(outcome).get("parameters", []):
        true = outcome.case.parameters.get(f"{entry['effect']}.{entry['name']}")
        factor = UNITS.get(entry.get("unit") or "")
        if true is not None and factor is not None:
            low, high = sorted((factor * entry["low"], factor * entry["high"]))
            if entry["name"] == "amplitude" and high < 0.0:  # half a turn of the phase
                low, high = -high, -low
            hits.append(low <= true <= high)
    return hits


def held_out_ratio(outcome: Outcome) -> float | None:
    """Held-out RMSE of the extended over that of the base model, for a claim."""
    held = claimed_entry(outcome).get("held_out") or {}
    if not claimed(outcome) or not held.get("rmse_base") or held.get("rmse_extended") is None:
        return None
    return float(held["rmse_extended"]) / float(held["rmse_base"])


def _share(name: str, hits: Sequence[bool], low: float | None = None, high: float | None = None) -> Figure:
    return Figure(name, float(np.mean(hits)) if hits else float("nan"), len(hits), low, high)


def figures(outcomes: Sequence[Outcome]) -> list[Figure]:
    """Compute the figures of outcomes. A failed run counts against every figure that it belongs to."""
    by: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        by.setdefault(outcome.case.scenario, []).append(outcome)
    single, pairs = by.get("single", []), by.get("pair", [])
    clocks = [o.seconds for o in outcomes]
    kinds = {o.case.kind for o in outcomes}
    ratio = None if kinds == {"transit"} else 0.6  # legs alone cannot reach it: docs/diagnosis-scope.md
    return [
        _share("runs that failed", [bool(o.error) for o in outcomes], high=0.0),
        _share("false alarms without an effect", [is_false_alarm(o) for o in by.get("control", [])], high=0.03),
        *_single_figures(single, kinds),
        *_pair_figures(pairs),
        *_other_figures(by.get("weak", []), by.get("outside", []), by.get("tie", [])),
        _share("90 % intervals cover", [hit for o in single + pairs for hit in covered(o)], low=0.85, high=0.98),
        Figure("held-out RMSE, extended / base, median", *_median_ratio(single + pairs), high=ratio, is_share=False),
        Figure("time, median [s]", _median(clocks), len(clocks), high=15.0, is_share=False),
        Figure("time, longest [s]", max(clocks, default=float("nan")), len(clocks), is_share=False),
    ]


def _single_figures(single: Sequence[Outcome], kinds: set[str]) -> list[Figure]:
    right = {("descent",): 0.93, ("transit",): 0.95}.get(tuple(kinds))
    sizes = [float(len(o.diagnosis.get("credible_set", []))) for o in single]
    first = [o.case.accepts(claimed_entry(o).get("causes", [])) for o in single]
    return [
        _share("right cause claimed, modulo exact ties", [o.case.accepts(claimed(o)) for o in single], low=right),
        _share("right cause first in the ranking", first),
        _share("true cause in the 95 % set", [in_credible_set(o) for o in single], low=0.95),
        Figure(
            "mean size of the 95 % set",
            _mean(sizes),
            len(sizes),
            high=2.0,
            is_share=False,
            error=_standard_error(sizes),
        ),
    ]


def _pair_figures(pairs: Sequence[Outcome]) -> list[Figure]:
    one = [bool(set(o.case.truth) & set(claimed(o))) for o in pairs]
    return [
        _share("two effects: both claimed", [o.case.accepts(claimed(o)) for o in pairs], low=0.75),
        _share("two effects: true pair in the 95 % set", [in_credible_set(o) for o in pairs]),
        _share("two effects: at least one claimed", one, low=0.95),
    ]


def _other_figures(weak: Sequence[Outcome], outside: Sequence[Outcome], ties: Sequence[Outcome]) -> list[Figure]:
    blind = [o for o in outside if o.case.outside not in STUDIED]
    studied = [o for o in outside if o.case.outside in STUDIED]
    wrong = [bool(o.error) or is_wrong_claim(o) for o in weak]
    return [
        _share("wrong cause claimed for a weak effect", wrong, high=0.10),
        _share("outside the catalogue, blind: flagged", [is_flagged_or_descriptive(o) for o in blind], low=0.70),
        _share("outside the catalogue, blind: flagged by the verdict", [is_flagged(o) for o in blind]),
        _share("outside the catalogue, studied: flagged", [is_flagged_or_descriptive(o) for o in studied]),
        _share("exact tie: one of the tied causes claimed", [o.case.accepts(claimed(o)) for o in ties]),
        _share("exact tie: true cause in the 95 % set", [list(o.case.truth) in _sets(o) for o in ties]),
    ]


def _median_ratio(outcomes: Sequence[Outcome]) -> tuple[float, int]:
    """Return the median of the held-out ratios and their number; the kinds have the weights of `KIND_WEIGHTS`."""
    found = sorted((ratio, o.case.kind) for o in outcomes if (ratio := held_out_ratio(o)) is not None)
    if not found:
        return float("nan"), 0
    counts = Counter(kind for _, kind in found)
    weights = np.cumsum([KIND_WEIGHTS[kind] / counts[kind] for _, kind in found])
    return found[int(np.searchsorted(weights, 0.5 * weights[-1]))][0], len(found)


def _sets(outcome: Outcome) -> list[list[str]]:
    return [sorted(causes) for causes in outcome.diagnosis.get("credible_set", [])]


def _standard_error(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1) / np.sqrt(len(values))) if len(values) > 1 else 0.0


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def confusion(outcomes: Sequence[Outcome]) -> dict[str, Counter[str]]:
    """Return counts of the claimed sets by true set; an outside effect is in brackets."""
    table: dict[str, Counter[str]] = {}
    for outcome in outcomes:
        case = outcome.case
        row = f"({case.outside})" if case.outside else " + ".join(case.truth) or "nothing"
        claim = "failed" if outcome.error else " + ".join(sorted(claimed(outcome))) or "nothing"
        if is_flagged(outcome):
            claim += " …"
        table.setdefault(f"{row} [{case.scenario}]", Counter())[claim] += 1
    return dict(sorted(table.items()))


def page(outcomes: Sequence[Outcome]) -> str:
    """Return the page that ``python -m tests.hidden_effects`` prints."""
    lines: list[str] = []
    for kind in ("descent", "transit"):
        chosen = [outcome for outcome in outcomes if outcome.case.kind == kind]
        if not chosen:
            continue
        lines += [f"{kind}: {len(chosen)} cases", "", "true → claimed (… = with a discrepancy)"]
        for row, counts in confusion(chosen).items():
            total = sum(counts.values())
            claims = ", ".join(f"{claim} {count}" for claim, count in counts.most_common())
            lines.append(f"  {row:<52} {total:>3} → {claims}")
        lines += _table(figures(chosen))
        lines += ["", *(f"  failed: {o.case.name}: {o.error}" for o in chosen if o.error), ""]
    lines += ["all kinds together", *_table(figures(outcomes)), ""]
    return "\n".join(lines)


def _table(found: Sequence[Figure]) -> list[str]:
    lines = ["", f"  {'figure':<52} {'value':>8} {'cases':>6}  target"]
    for figure in found:
        mark = "" if figure.met else "  not met" + ("" if figure.refuted else " (within chance)")
        lines.append(f"  {figure.name:<52} {figure.value:>8.3f} {figure.cases:>6}  {figure.target}{mark}")
    return lines
