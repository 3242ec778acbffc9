"""Entries of the catalogue: an effect with its parameters, their plausible sizes, and what it is confused with."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import DescentEffect, TransitEffect

Phase = Literal["transit", "descent", "tank"]
Ageing = Literal["keeps", "drifts", "jumps"]
Tier = Literal["physical", "statistical", "neutral"]
Part = Literal["mean", "covariance"]
Scatter = Literal["", "release", "drag"]
TankKind = Literal["drag", "free-oscillation", "thruster", "propeller-transient"]
VehicleKey = Literal["", "drag.coefficient", "drag.exponent", "added_mass.surge"]


@dataclass(frozen=True)
class Finding:
    """How the operator is told that an effect was found, and what to do about it."""

    parameter: str
    """Whose size is told; empty where none is."""
    positive: str
    negative: str = ""
    """Clauses for either sign, with ``{size}``, and ``{at}`` for the moment or threshold from which it acts; a
    parameter that has one sign needs the first alone."""
    remedy: str = ""
    """What to do about it."""
    in_percent: bool = False
    """Whether the size is a share, told in per cent."""
    toward: tuple[str, str] | None = None
    """Components east and north, where the size is that of a vector; the clause has ``{direction}`` too."""
    each: float = 1.0
    """Change of what it responds to for which the size is told [its unit]."""
    unit: str = ""
    """Unit of the size that is then told; empty: the parameter's."""
    beyond: float = 0.0
    """What is added to the size before it is told: 1 where nothing is meant by a share of all."""


@dataclass(frozen=True)
class LegRecord:
    """What a navigation log holds, as far as it decides which effects the log could show."""

    latitude: float
    """Of the coordinates' origin [rad]; nan where unknown."""
    has_surface_time: bool
    """Whether the time at the surface before each fix is logged."""
    duration: float
    """Between the middles of the first and the last leg [s]."""
    speeds: float = 0.0
    durations: float = 0.0
    """Range of the legs' speeds, and of their times under way, over the median."""
    depths: float = float("nan")
    """Range of the legs' mean depths [m]; nan where they are not logged."""


@dataclass(frozen=True)
class TankRecord:
    """What tank data hold, as far as it decides which effects they could show."""

    has_vehicle_drag: bool = False
    """Whether the mission's vehicle file has a drag from a tank."""
    has_both_signs: bool = False
    """Whether a thruster was commanded in both directions."""
    has_jet_speed: bool = False
    """Whether shaft rates and the tunnel's diameter are known, so that the speed of a thruster's jet follows."""
    is_under_way: bool = False
    """Whether some rows were taken under way."""


def lacks_nothing(record: LegRecord | TankRecord) -> str:
    """Return why a record cannot show an effect; empty: any record can."""
    return ""


@dataclass(frozen=True)
class Instrument:
    """An instrument that measures one effect by itself."""

    description: str
    """In words."""
    parameter: str
    """What it measures."""
    sd: float
    """Standard deviation of its error, in the parameter's unit: what such instruments state."""
    minutes: float = 60.0
    """Time that it takes a practised crew [min]."""


@dataclass(frozen=True)
class Likeness:
    """What is said of an effect that is found larger than it can be: the errors are like it, their cause is another."""

    parameter: str
    size: float
    """Beyond this [the parameter's unit]."""
    words: str
    """In the place of the effect's name."""


FIND_OUT = "find out what changes it from mission to mission"
"""What to do about a trend of which nothing is known."""


@dataclass(frozen=True)
class Term:
    """Strengths of an effect that act together and without its others."""

    strengths: tuple[str, ...]
    """One parameter, or two that are components."""
    searched: tuple[str, ...] = ()
    """The shapes that they depend on: one, or the moment from which they act and that until which they do."""
    finding: Finding | None = None
    """How it is told, where it is not as the effect is."""
    lacking: Callable[[LegRecord], str] = lacks_nothing
    """Why a navigation log cannot show it; empty where it can."""


@dataclass(frozen=True)
class TankEffect:
    """Neutral base of effects seen only in a tank.

    An effect on a descent may be seen there too: its `lone_drag_factor` in towing, its `mass_factor` on springs.
    """

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
BASES: Mapping[Phase, type[Effect]] = {"transit": TransitEffect, "descent": DescentEffect, "tank": TankEffect}
"""Neutral base of the effects on each phase."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect: unit, physical range and plausible sizes.

    A *strength* is zero when the effect is absent; its plausible sizes are a normal distribution about zero with
    standard deviation `scale`. A *shape* (a time constant, a depth) is positive and has no neutral value; its
    plausible sizes are log-normal about `median`, 68 % within × or ÷ `factor`, unless `reciprocal_is_uniform`. A
    *phase* goes with an amplitude.
    """

    unit: str
    """SI unit as written in a mission file; empty for a bare number."""
    doc: str
    """Description with sign convention."""
    low: float = -inf
    high: float = inf
    """Physical range: a fitted value outside it is not this effect [unit]."""
    scale: float = 0.0
    """Standard deviation of the plausible sizes of a strength; 0 for a shape or a phase [unit]."""
    spike: float = 0.0
    """Standard deviation of a strength in the base model, its uncertainty before any misfit [unit]."""
    median: float = 0.0
    factor: float = 1.0
    """Plausible sizes of a shape [unit, 1]."""
    reciprocal_is_uniform: bool = False
    """Whether a shape's reciprocal is as likely anywhere from nil, where the effect vanishes, to 2/`median`; `factor`
    is then a scale of its logarithm for searches alone."""
    default: float = 0.0
    """Value when the mission file leaves it out [unit]."""
    field: str = ""
    """Field of the data class where a hook has the parameter's name; by default the same as the name."""
    is_random_size: bool = False
    """Whether it is the size of a velocity error that is random from leg to leg."""
    extent_scale: float = inf
    extent_spike: float = inf
    """For a gradient: `scale` and `spike` are at most these over the extent of the record [unit·m]."""
    tank_spike: float = 0.0
    """`spike` for tank data, where it differs; 0: the same [unit]."""
    searched: Literal["", "time", "period", "speed", "depth", "course"] = ""
    """Along what of a log the values of a shape are tried one by one: the ``time`` at which something changes, the
    ``period`` of what comes and goes, or how often it does so in a circle of the ``course``, the ``speed`` or ``depth``
    from which something does; empty: none."""

    @property
    def is_shape(self) -> bool:
        """Whether the parameter is positive with log-normal plausible sizes."""
        return self.median > 0.0


@dataclass(frozen=True)
class EffectInfo:
    """An entry of the catalogue."""

    id: str
    """Stable name in mission files and results."""
    effect: type[Effect]
    """The data class that refines the hooks of a phase."""
    parameters: Mapping[str, Parameter]
    """Name of each field of the data class → `Parameter`."""
    what: str
    """What happens physically."""
    sizes: str
    """Plausible sizes and signs, and where they come from."""
    confused_with: tuple[str, ...]
    """Effects that look alike."""
    distinguished_by: str
    """Measurement that would distinguish them."""
    tier: Tier = "physical"
    """``physical`` names a cause; ``statistical`` describes the errors without naming one; ``neutral`` describes to
    what the vehicle responds, outside of what is named."""
    changes_plan: bool = True
    """False for effects on readings only."""
    polar: tuple[tuple[str, str], ...] = ()
    """Pairs (amplitude, phase) of parameters: linear together as a·cos φ and a·sin φ."""
    frequency_of: Callable[[str, float], float] | None = None
    """From the name of a phase in `polar` and a latitude [rad], the angular frequency at which it turns [rad/s], where
    the phases are of time."""
    belongs_to: Literal["vehicle", "place", "day"] = "vehicle"
    """What has it: the vehicle wherever it is, a place in a season, or the weather of some days."""
    ageing: Ageing = "keeps"
    """How what the vehicle has goes from mission to mission where its own missions do not tell: it keeps what it has,
    ``drifts`` as a hull fouls, or ``jumps`` as a compass does that is swung or refitted."""
    upkeep: tuple[str, str] = (FIND_OUT, FIND_OUT)
    """What to do about a trend of its first parameter, upwards and downwards."""
    part: Part = "mean"
    """Whether it is diagnosed in the mean of a log's errors or in their covariance. In the covariance it refines
    `fix_variance`, `position_variance_rate` or `tail_dof`, or is a `MarkovProcess`, and its parameters are shapes."""
    linear: bool = True
    """Whether the mean is linear in its coordinates."""
    follows: Literal["", "depth", "speed", "time", "line"] = ""
    """Of an effect on a descent without a name: what differs within dives, or between them, that it follows."""
    exclusive_group: str = ""
    """Of the effects of one group a set of causes holds at most one."""
    is_modulated: bool = False
    """Whether it is an oscillation whose amplitude and phase may change over days: an `effects.oscillation.Oscillation`
    with its two parameters, the others being pairs in `polar`."""
    lacking: Callable[[LegRecord], str] = lacks_nothing
    """Why a navigation log cannot show it; empty where it can."""
    resolvable: Callable[[float], Collection[str]] | None = None
    """From a log's duration [s], the parameters that it can resolve; default all."""
    kept_after: Callable[[Collection[str], float], float] | None = None
    """From the parameters that a record resolved, the correlation of what it showed with what is so much later [s]."""
    needs_latitude: bool = False
    """Whether the phase needs the latitude of the coordinates' origin."""
    is_steady_current: bool = False
    """Whether its parameters `east` and `north` add to the mission's own uncertainty of the current."""
    follows_law: bool = False
    """Whether a physical law or its definition gives its form but for its parameters. The diagnosis of dives allows the
    strengths of others a relative error, and what they add to the readings if they have shape parameters."""
    scatter: Scatter = ""
    """Whether dives scatter in this effect from one to the next: in the time of release, or in drag."""
    instrument: Instrument | None = None
    """What measures it directly."""
    likeness: Likeness | None = None
    """What to say of it where it is found too large to be true."""
    finding: Finding | None = None
    """How it is told to the operator, and what to do about it."""
    terms: tuple[Term, ...] = ()
    """Alternatives of which one acts on a log, each a few strengths in which the mean is linear: the diagnosis of legs
    weighs an effect that has any by its columns beside all sets of others, at most one to a set."""
    tank: tuple[TankKind, ...] = ()
    """Kinds of tank data that could show it."""
    lacking_in_tank: Callable[[TankRecord], str] = lacks_nothing
    """Why tank data of such a kind cannot show it; empty where they can."""
    vehicle_key: VehicleKey = ""
    """Key of the vehicle file that states what tank data show of it, with its one parameter: a relative change of the
    drag's coefficient, a change of its exponent, or a relative change of the oscillating mass."""

    @cached_property
    def phase(self) -> Phase:
        """Phase it acts on: the one whose hooks its data class refines."""
        return next(phase for phase, base in BASES.items() if issubclass(self.effect, base))

    def make(self, values: Mapping[str, Scalars]) -> Effect:
        """Build the effect from parameters by their names; those left out take their defaults.

        Raises KeyError when the effect has no such parameter.
        """
        arguments = {name: parameter.default for name, parameter in self.parameters.items()} | dict(values)
        return self.effect(**{self.parameters[name].field or name: value for name, value in arguments.items()})

    @property
    def neutral(self) -> dict[str, float]:
        """Parameters at which the effect does nothing, whatever the others are: its strengths, else its sizes."""
        strengths = [name for name, parameter in self.parameters.items() if parameter.scale > 0.0]
        sizes = [name for name, parameter in self.parameters.items() if parameter.default in (0.0, inf)]
        return {name: self.parameters[name].default for name in strengths or sizes}

    def make_where(self, values: Mapping[str, Scalars], mask: NDArray[np.bool_]) -> Effect:
        """Build the effect as it acts in some of the trials: in the others its parameters are neutral.

        Parameters
        ----------
        values : mapping
            Floats or arrays over the trials, shape (n,).
        mask : array of bool, shape () or (n,)
        """
        if mask.all() or self.phase == "tank":
            return self.make(values)
        if not mask.any():
            return TransitEffect() if self.phase == "transit" else DescentEffect()
        acting = {name: np.where(mask, values.get(name, nil), nil) for name, nil in self.neutral.items()}
        return self.make({**values, **acting})
