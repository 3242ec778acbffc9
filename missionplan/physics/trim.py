"""Trim of a submerged vehicle: the pitch at which its weights balance about its centre of buoyancy.

The net buoyancy, a hundredth of the weight, is left out of the balance: it moves the vehicle up or down, and its lever
about the centre of buoyancy is nil.
"""

import math
from dataclasses import dataclass

_LEVEL = math.radians(2.0)
"""Pitch below which a vehicle counts as level."""


@dataclass(frozen=True)
class Weight:
    """A weight [N], its distance aft of the nose's tip [m], and below the axis [m]; negative ahead of it, above it."""

    size: float
    from_nose: float
    below_axis: float


@dataclass(frozen=True)
class TrimState:
    """Trim in one configuration."""

    configuration: str
    """Such as ``with the flooded anchor``."""
    net_force: float
    """Upward [N]."""
    moment: float
    """Of the weights about the centre of buoyancy with the vehicle level; positive puts the nose down [N m]."""
    pitch: float | None
    """Nose down; None where nothing rights the vehicle, or its centres are not known [rad]."""
    centres_known: bool
    """Whether the vehicle file gives them."""

    @property
    def verdict(self) -> str:
        """How the vehicle lies."""
        if self.pitch is None:
            if not self.centres_known:
                return "nose-heavy" if self.moment > 0.0 else "not known"
            return "turns over: its centre of gravity is not below that of buoyancy"
        if abs(self.pitch) <= _LEVEL:
            return "level"
        return "nose-heavy" if self.pitch > 0.0 else "tail-heavy"

    def summary(self) -> dict[str, object]:
        """Return an entry of ``summary.json``."""
        return {
            "configuration": self.configuration,
            "net_force_n": self.net_force,
            "moment_n_m": self.moment,
            "pitch_rad": self.pitch,
            "verdict": self.verdict,
        }


def trim(
    configuration: str,
    weights: tuple[Weight, ...],
    buoyancy: Weight,
    *,
    centres_known: bool = True,
) -> TrimState:
    """Find the trim of a vehicle.

    Parameters
    ----------
    buoyancy : Weight
        Size and centre of the buoyancy.
    centres_known : bool
        Whether they are known; assumed ones give no pitch.

    Returns
    -------
    TrimState
        tan θ = Σ W (x_B - x) / Σ W (z - z_B), nose down.
    """
    total = sum(weight.size for weight in weights)
    moment = sum(weight.size * (buoyancy.from_nose - weight.from_nose) for weight in weights)
    righting = sum(weight.size * (weight.below_axis - buoyancy.below_axis) for weight in weights)
    pitch = math.atan2(moment, righting) if centres_known and righting > 0.0 else None
    return TrimState(configuration, buoyancy.size - total, moment, pitch, centres_known)
