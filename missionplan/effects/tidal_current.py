"""A tidal current of the constituents M2, S2, N2, K1, O1, K2, P1, Q1 and M4."""

import math
from collections.abc import Collection
from dataclasses import dataclass, make_dataclass, replace
from typing import Self

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, Parameter
from missionplan.effects.oscillation import MODULATION_PARAMETERS, USUAL_TIME, Oscillation, mean_phasor, polar, wave
from missionplan.phases.hooks import DriftParts, Leg

PERIODS = {
    "m2": 12.4206012 * 3600.0,
    "s2": 12.0 * 3600.0,
    "n2": 12.6583482 * 3600.0,
    "k1": 23.9344696 * 3600.0,
    "o1": 25.8193417 * 3600.0,
    "k2": 11.9672348 * 3600.0,
    "p1": 24.0658902 * 3600.0,
    "q1": 26.8683566 * 3600.0,
    "m4": 6.2103006 * 3600.0,
}
"""Periods of the constituents, those of UTide's table, which a test compares: reading it takes half a second [s]."""


STRONGEST = ("m2",)
"""What stands for the tide in a record that resolves no constituent: it cannot tell one from another."""


def _beat(first: str, second: str) -> float:
    """Time after which two constituents are in phase again [s]."""
    return 1.0 / abs(1.0 / PERIODS[first] - 1.0 / PERIODS[second])


STRONGER = {"s2": "m2", "n2": "m2", "k2": "s2", "o1": "k1", "p1": "k1", "q1": "o1"}
"""The nearest stronger constituent of each: a record shorter than their beat takes both for one."""
_LEAST = {"m2": 0.5 * PERIODS["m2"], "k1": PERIODS["k1"], "m4": _beat("s2", "m2")}
LEAST_RECORD = {name: _LEAST.get(name) or _beat(name, STRONGER[name]) for name in PERIODS}
"""Length of a record that resolves a constituent: its beat with the nearest stronger one (Rayleigh's criterion); of M4
with MS4, which is the beat of M2 and S2 [s]."""
_USUAL = {"m2": 0.12, "s2": 0.12, "n2": 0.03, "k1": 0.12, "o1": 0.12, "k2": 0.03, "p1": 0.04, "q1": 0.025, "m4": 0.01}
"""Usual sizes of the amplitudes; of N2, K2, P1 and Q1 from their shares of M2, S2, K1 and O1 in the equilibrium tide,
0.19, 0.27, 0.33 and 0.19 (Pugh & Woodworth 2014, *Sea-Level Science*, Table 4.1) [m/s]."""
_SPIKE = 1.0 / 60.0
"""Share of the usual size that is in the base model."""


_COMPONENTS = tuple(f"{name}_{component}" for name in PERIODS for component in ("east", "north"))


@dataclass(frozen=True)
class _Tide(Oscillation):
    """Sum over constituents of ``amplitude·cos(ωt − phase)`` in each component, t from the mission's start."""

    modulation: Scalars = 0.0
    coherence_time: Scalars = USUAL_TIME

    def later(self) -> Self:
        """Return the tide with each constituent a quarter of its period later."""
        phases = {f"{name}_phase": getattr(self, f"{name}_phase") + 0.5 * np.pi for name in _COMPONENTS}
        return replace(self, **phases)

    def velocity(self, leg: Leg) -> Array:
        """Return the mean tidal velocity over each leg, shape (2, n) [m/s]."""
        total = np.zeros((2, np.size(leg.t_start)))
        for name, period in PERIODS.items():
            if not self._has(name):
                continue
            cosine, sine = mean_phasor(leg, 2.0 * np.pi / period)
            for axis, component in enumerate((f"{name}_east", f"{name}_north")):
                amplitude, phase = getattr(self, component), getattr(self, f"{component}_phase")
                total[axis] += wave(cosine, sine, amplitude, phase)
        return total

    def drift(self) -> DriftParts:
        """Return the waves of the constituents that are not nil."""
        waves = {period: self._wave(name) for name, period in PERIODS.items() if self._has(name)}
        return DriftParts(waves=waves, modulation=(self.modulation, self.coherence_time))

    def _has(self, name: str) -> bool:
        return any(np.any(getattr(self, f"{name}_{component}")) for component in ("east", "north"))

    def _wave(self, name: str) -> Array:
        """Coefficients of cosine and sine toward east, then north, shape (4,) or (4, n) [m/s]."""
        parts = [
            part
            for component in ("east", "north")
            for part in polar(getattr(self, f"{name}_{component}"), getattr(self, f"{name}_{component}_phase"))
        ]
        return np.stack(np.broadcast_arrays(*parts))


TidalCurrent: type[_Tide] = make_dataclass(
    "TidalCurrent",
    [(key, Scalars, 0.0) for name in _COMPONENTS for key in (name, f"{name}_phase")],
    bases=(_Tide,),
    namespace={"__module__": __name__},
    frozen=True,
)
"""``m2_east`` is an amplitude [m/s] and ``m2_east_phase`` its phase [rad]: the current is greatest toward east at ωt =
phase."""


def resolvable_constituents(duration: float) -> tuple[str, ...]:
    """Names of the constituents that a record of a duration [s] can resolve, by `LEAST_RECORD`."""
    return tuple(name for name, least in LEAST_RECORD.items() if duration >= least)


def kept_after(names: Collection[str], seconds: float) -> float:
    """Correlation of a tide with itself so much later [s], where a record resolved the parameters of these names.

    Those that it took for a stronger one, of their usual sizes, come out of step with it.
    """
    kept, total, constituents = 0.0, 0.0, {name.split("_")[0] for name in names}
    for name, size in _USUAL.items():
        stands = name
        while stands not in constituents and stands in STRONGER:
            stands = STRONGER[stands]
        if stands in constituents:
            total += size**2
            kept += size**2 * math.cos(2.0 * math.pi * seconds * (1.0 / PERIODS[name] - 1.0 / PERIODS[stands]))
    return kept / total if total else 1.0


def _parameters() -> dict[str, Parameter]:
    entries = {}
    for name in PERIODS:
        for component in ("east", "north"):
            entries[f"{name}_{component}"] = Parameter(
                "m/s",
                f"{component} amplitude of {name.upper()}",
                0.0,
                3.0,
                scale=_USUAL[name],
                spike=_SPIKE * _USUAL[name],
            )
            entries[f"{name}_{component}_phase"] = Parameter(
                "rad", f"phase of {name.upper()} toward {component}: time of the greatest current, times ω"
            )
    return entries


def _resolvable(duration: float) -> tuple[str, ...]:
    tides = resolvable_constituents(duration) or STRONGEST
    return tuple(name for name in _parameters() if name.split("_")[0] in tides)


TIDAL_CURRENT = EffectInfo(
    id="tidal-current",
    effect=TidalCurrent,
    parameters={**_parameters(), **MODULATION_PARAMETERS},
    belongs_to="place",
    what="Tidal ellipses: each component of the current oscillates with the periods of the moon and the sun.",
    finding=Finding(
        "",
        "a tide that the mission does not have sets the vehicle",
        remedy="add it to the mission, and choose the start by `missionplan tide`",
    ),
    sizes="0.02 to 0.5 m/s on shelves and in inlets; a few cm/s or less in the deep ocean.",
    confused_with=("inertial-current", "persistent-error", "current-shear"),
    distinguished_by=(
        "A record of two periods or more; two weeks to separate M2 from S2 and K1 from O1, four for N2 and Q1, half a "
        "year for K2 and P1."
    ),
    polar=tuple((name, f"{name}_phase") for name in _COMPONENTS),
    frequency_of=lambda phase, latitude: 2.0 * np.pi / PERIODS[phase.split("_")[0]],
    is_modulated=True,
    resolvable=_resolvable,
    kept_after=kept_after,
)
