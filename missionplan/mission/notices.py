"""Notes on a mission that is read: what is unusual in it, and what was left out or cut off."""

from collections.abc import Mapping, Sequence

from missionplan.effects import FAILED_PLUGINS
from missionplan.montecarlo.distributions import Distribution

_LEAST_TOLD = 1e-12
"""Probability below which nothing is said of what was cut off."""


def notices(unusual: Sequence[str], uncertain: Mapping[str, Distribution]) -> tuple[str, ...]:
    """Return a note for each unusual value, distribution cut at its physical range, and plug-in left out."""
    cut = (
        f"{path}: {_percent(value.mass_cut)} of the distribution lies outside the physical range and was cut off"
        for path, value in uncertain.items()
        if value.mass_cut > _LEAST_TOLD
    )
    plugins = (f"the plug-in {name} of effects is left out: {reason}" for name, reason in FAILED_PLUGINS.items())
    return (*unusual, *cut, *plugins)


def _percent(share: float) -> str:
    """Write a share in two digits, as long as a trial in a hundred thousand may meet it."""
    return f"{100.0 * share:.2g} %" if share >= 1e-5 else "less than 0.001 %"
