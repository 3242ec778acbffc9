"""Diagnoses with a small catalogue of causes, for tests that do not look at what the others compete for."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from missionplan.diagnosis.dives import linearised
from missionplan.diagnosis.legs import terms
from missionplan.diagnosis.legs.likelihood import mean

COMMON = (
    *("mean-current", "speed-scale", "compass-bias", "persistent-error"),
    *("drag-bias", "line-payout", "added-mass", "clock-offset"),
)


@contextmanager
def few(names: tuple[str, ...] = COMMON) -> Iterator[None]:
    """Let legs be explained by these causes or by a smooth error without a name, and dives by these alone."""
    with pytest.MonkeyPatch.context() as patch:
        for module, function, kept in (
            (mean, "named_effects", names),
            (terms, "effects_of", names),
            (linearised, "named_effects", names),
            (linearised, "effects_of", names),
        ):
            patch.setattr(module, function, _only(getattr(module, function), kept))
        yield


def _only(listed: Callable, kept: tuple[str, ...]) -> Callable:
    return lambda phase: tuple(info for info in listed(phase) if info.id in kept)
