"""Choice of cases: everything about case number i follows from the seed and i."""

from collections.abc import Iterator

from . import dives, legs
from .case import Case

KINDS = ("descent", "transit")
SCENARIOS = ("control", "single", "weak", "pair", "outside", "tie")
SCENARIO_CYCLE = (
    *("single", "control", "single", "pair", "single", "control", "weak", "single", "outside", "pair"),
    *("single", "control", "single", "tie", "single", "control", "weak", "pair", "outside", "single"),
)
"""Scenarios of twenty consecutive cases of one kind."""


def draw_case(seed: int, kind: str, scenario: str, effect: str | None = None) -> Case:
    """Draw one case.

    Parameters
    ----------
    seed : int
        Seed of everything: effect, sizes, geometry, nuisances, sensors.
    kind : str
        ``descent`` or ``transit``.
    scenario : str
        ``control`` (no effect), ``single`` (one, well above the nuisances), ``weak`` (a quarter of that), ``pair``,
        ``outside`` (not in the catalogue) or ``tie`` (indistinguishable from another cause in these data).
    effect : str, optional
        Effect for ``single``, ``weak`` and ``outside``, instead of a random one.
    """
    if kind not in KINDS or scenario not in SCENARIOS:
        raise ValueError(f"no cases of kind {kind!r}, scenario {scenario!r}")
    maker = dives if kind == "descent" else legs
    return maker.draw(seed, scenario, effect)


def plan(count: int, seed: int, kind: str | None = None) -> list[tuple[int, str, str]]:
    """Return arguments of ``draw_case`` for ``count`` cases, both kinds in turn unless one is given."""
    kinds = (kind,) if kind else KINDS
    cycle = SCENARIO_CYCLE
    return [(seed + i, kinds[i % len(kinds)], cycle[i // len(kinds) % len(cycle)]) for i in range(count)]


def cases(count: int, seed: int, kind: str | None = None) -> Iterator[Case]:
    """Draw ``count`` cases of consecutive seeds."""
    return (draw_case(*arguments) for arguments in plan(count, seed, kind))
