"""Entries of the catalogue: an effect with its parameters, their plausible sizes, and what it is confused with."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Literal

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import DescentEffect, TransitEffect

Phase = Literal["transit", "descent", "tank"]
Tier = Literal["physical", "statistical"]


@dataclass(frozen=True)
class TankEffect:
    """Neutral base of effects seen only in a tank; a descent's `drag-bias` and `added-mass` are seen there too."""

    def drag_factor(self, reynolds_ratio: Array) -> Array | float:
        """Return the factor on the drag coefficient, from Re/Re₀."""
        return 1.0

    def thrust_factor(self, command: Array, jet_ratio: Array) -> Array | float:
        """Return the factor on static thrust, from the command and the vehicle's speed over the jet's."""
        return 1.0

    def damping(self) -> Scalars:
        """Return quadratic damping over the total mass [1/m]."""
        return 0.0

    def flow_mass_factor(self) -> Scalars:
        """Return the mass of the flow in the disc over ρ A_p D; 0 where it adjusts at once."""
        return 0.0


Effect = TransitEffect | DescentEffect | TankEffect


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect: unit, physical range and plausible sizes.

    A *strength* is zero when the effect is absent; its plausible sizes are a normal distribution about zero with
    standard deviation `scale`. A *shape* (a time constant, a depth) is positive and has no neutral value; its
    plausible sizes are log-normal about `median`, 68 % within × or ÷ `factor`. A *phase* goes with an amplitude.

    Attributes
    ----------
    unit : str
        SI unit as written in a mission file; empty for a bare number.
    doc : str
        Description with sign convention.
    low, high : float
        Physical range: a fitted value outside it is not this effect [unit].
    scale : float
        Standard deviation of the plausible sizes of a strength; 0 for a shape or a phase [unit].
    spike : float
        Standard deviation of a strength in the base model, its uncertainty before any misfit [unit].
    median, factor : float
        Plausible sizes of a shape [unit, 1].
    default : float
        Value when the mission file leaves it out [unit].
    field : str
        Field of the data class where a hook has the parameter's name; by default the same as the name.
    """

    unit: str
    doc: str
    low: float = -inf
    high: float = inf
    scale: float = 0.0
    spike: float = 0.0
    median: float = 0.0
    factor: float = 1.0
    default: float = 0.0
    field: str = ""

    @property
    def is_shape(self) -> bool:
        """Whether the parameter is positive with log-normal plausible sizes."""
        return self.median > 0.0


@dataclass(frozen=True)
class EffectInfo:
    """An entry of the catalogue.

    Attributes
    ----------
    id : str
        Stable name in mission files and results.
    phase : str
        Phase it acts on.
    tier : str
        ``physical`` names a cause; ``statistical`` describes the errors without naming one.
    effect : type
        The data class that refines the phase's hooks.
    parameters : mapping
        Name of each field of the data class → `Parameter`.
    what : str
        What happens physically.
    sizes : str
        Plausible sizes and signs, and where they come from.
    confused_with : tuple of str
        Effects that look alike.
    distinguished_by : str
        Measurement that would distinguish them.
    changes_plan : bool
        False for effects on readings only.
    polar : tuple
        Pairs (amplitude, phase) of parameters: linear together as a·cos φ and a·sin φ.
    """

    id: str
    phase: Phase
    tier: Tier
    effect: type[TransitEffect] | type[DescentEffect] | type[TankEffect]
    parameters: Mapping[str, Parameter]
    what: str
    sizes: str
    confused_with: tuple[str, ...]
    distinguished_by: str
    changes_plan: bool = True
    polar: tuple[tuple[str, str], ...] = ()

    def make(self, values: Mapping[str, Scalars]) -> Effect:
        """Build the effect from parameters by their names; those left out take their defaults.

        Raises
        ------
        KeyError
            When the effect has no such parameter.
        """
        given = {name: parameter.default for name, parameter in self.parameters.items()} | dict(values)
        return self.effect(**{self.parameters[name].field or name: value for name, value in given.items()})
