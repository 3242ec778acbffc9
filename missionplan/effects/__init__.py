"""The catalogue of effects: each by its stable name, with its data class and its entry, in modules by what they act on.

Read first `info` (what an entry holds) and any effect. Beside the catalogue stand the checks of its entries: what an
entry must declare, and which entries cannot stand together.
"""

import inspect
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import cast

from missionplan.effects import (
    course_and_speed,
    currents,
    dive_forces,
    dive_log,
    random_errors,
    response,
    tank,
    tidal_current,
)
from missionplan.effects.dive_responses import RESPONSES
from missionplan.effects.info import BASES, Phase, Scatter
from missionplan.effects.info import Effect as Effect
from missionplan.effects.info import EffectInfo as EffectInfo
from missionplan.effects.info import Parameter as Parameter
from missionplan.effects.info import TankEffect as TankEffect
from missionplan.effects.oscillation import MODULATION_PARAMETERS, Oscillation
from missionplan.errors import shown
from missionplan.identity import PluginError, load_plugin
from missionplan.phases.hooks import MarkovProcess, TransitEffect

_ID = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_PARAMETER = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_TANK_HOOKS = {
    "drag": {"descent": "lone_drag_factor", "tank": "drag_factor"},
    "free-oscillation": {"descent": "mass_factor", "tank": "damping"},
    "thruster": {"tank": "thrust_factor"},
    "propeller-transient": {"tank": "flow_mass_factor"},
}
"""By kind of tank data and phase of an effect, the hook through which it acts on them."""
_SHOWS_KEY = {"drag.coefficient": "drag", "drag.exponent": "drag", "added_mass.surge": "free-oscillation"}
"""By key of the vehicle file, the kind of tank data that shows it."""


def entry_problems(info: EffectInfo) -> list[str]:
    """Return what is wrong with one entry, in words; empty when it can be used."""
    if wrong := [*_name_problems(info)]:
        return wrong
    bases = tuple(BASES.values())
    if not (isinstance(info.effect, type) and issubclass(info.effect, bases) and is_dataclass(info.effect)):
        return [f"effect must be a data class derived from {' or '.join(base.__name__ for base in bases)}"]
    problems = [*_field_problems(info), *_size_problems(info), *_reference_problems(info), *_tank_problems(info)]
    if problems:
        return problems
    if info.part == "covariance":
        problems = []
        if info.phase != "transit":
            problems.append('part="covariance": only effects on a transit enter a covariance')
        hooks = ("fix_variance", "position_variance_rate", "tail_dof")
        refined = [hook for hook in hooks if getattr(info.effect, hook, None) is not getattr(TransitEffect, hook)]
        if not refined and not _is_process(info):
            problems.append(
                'part="covariance": refine fix_variance, position_variance_rate or tail_dof, or give transition, '
                "first_variance and mean_over of a Markov process"
            )
        problems += [
            f'parameter {name}: part="covariance" needs a median and a factor'
            for name, parameter in info.parameters.items()
            if not parameter.is_shape
        ]
        return problems
    undeclared = _is_random(info) and not info.is_modulated
    return ['an effect that is random from leg to leg must declare part="covariance"'] if undeclared else []


def _name_problems(info: EffectInfo) -> Iterator[str]:
    """Names by which mission files call the effect and its parameters: parts of key paths."""
    if not _ID.fullmatch(info.id):
        yield f"id {shown(info.id)}: expected words of small letters and digits, joined by hyphens"
    for name in info.parameters:
        if not _PARAMETER.fullmatch(name):
            yield f"parameter {shown(name)}: expected words of small letters and digits, joined by underscores"


def _field_problems(info: EffectInfo) -> Iterator[str]:
    fields = set(inspect.signature(info.effect).parameters)
    for name, parameter in info.parameters.items():
        if (parameter.field or name) not in fields:
            yield f"parameter {name}: {info.effect.__name__} has no field {parameter.field or name}"


def _size_problems(info: EffectInfo) -> Iterator[str]:
    phases = {phase for _, phase in info.polar}
    for name, parameter in info.parameters.items():
        if not parameter.low < parameter.high:
            yield f"parameter {name}: low must be below high"
        if parameter.is_shape and parameter.factor <= 1.0:
            yield f"parameter {name}: a median needs a factor above 1"
        is_strength = parameter.scale > 0.0 and parameter.spike > 0.0
        if not (name in phases or parameter.is_shape or is_strength):
            yield f"parameter {name}: declare scale and spike (a strength), or median and factor (a shape)"


def _reference_problems(info: EffectInfo) -> Iterator[str]:
    """Names of parameters that are none, and what a modulation needs."""
    yield from (f"polar: {name} is no parameter" for pair in info.polar for name in pair if name not in info.parameters)
    if info.instrument is not None and info.instrument.parameter not in info.parameters:
        yield f"instrument: {info.instrument.parameter} is no parameter"
    if info.likeness is not None and info.likeness.parameter not in info.parameters:
        yield f"likeness: {info.likeness.parameter} is no parameter"
    if info.finding is not None:
        names = {info.finding.parameter, *(info.finding.toward or ())} - {"", *info.parameters}
        yield from (f"finding: {name} is no parameter" for name in sorted(names))
    if info.is_modulated and not (
        info.polar and issubclass(info.effect, Oscillation) and {*MODULATION_PARAMETERS} <= {*info.parameters}
    ):
        yield (
            "is_modulated: needs an effect derived from Oscillation, pairs of amplitude and phase in polar, and the "
            f"parameters {' and '.join(MODULATION_PARAMETERS)}"
        )


def _tank_problems(info: EffectInfo) -> Iterator[str]:
    """Kinds of tank data that are none or on which it does not act, and a key of the vehicle that it does not fill."""
    if info.phase == "tank" and not info.tank:
        yield f"tank: name the kinds of tank data that could show it, of {', '.join(_TANK_HOOKS)}"
    for kind in info.tank:
        hook = _TANK_HOOKS.get(kind, {}).get(info.phase, "")
        if kind not in _TANK_HOOKS:
            yield f"tank: {kind} is none of {', '.join(_TANK_HOOKS)}"
        elif not hook or getattr(info.effect, hook) is getattr(BASES[info.phase], hook):
            yield f"tank: on data of kind {kind} an effect of phase {info.phase} acts through {hook or 'no hook'}"
    if info.vehicle_key and (len(info.parameters) != 1 or _SHOWS_KEY.get(info.vehicle_key) not in info.tank):
        yield f"vehicle_key: {info.vehicle_key} holds one parameter that tank data show"


def _usual(info: EffectInfo) -> Effect:
    """Make the effect at the usual sizes of its parameters."""
    return info.make({name: parameter.median or parameter.scale for name, parameter in info.parameters.items()})


def _is_random(info: EffectInfo) -> bool:
    """Whether an effect draws normals for each leg."""
    made = _usual(info)
    return isinstance(made, TransitEffect) and made.is_random


def _is_process(info: EffectInfo) -> bool:
    return isinstance(_usual(info), MarkovProcess)


def catalogue_problems(entries: Iterable[EffectInfo]) -> list[str]:
    """Return why entries cannot stand in one catalogue, in words; empty when they can."""
    entries = tuple(entries)
    return [*_repeated(entries), *_uncombinable(entries), *_role_problems(entries)]


def _repeated(entries: Sequence[EffectInfo]) -> Iterator[str]:
    names = [info.id for info in entries]
    yield from (f"{name} is declared twice" for name in dict.fromkeys(names) if names.count(name) > 1)


def _uncombinable(entries: Sequence[EffectInfo]) -> Iterator[str]:
    """Processes and heavy tails that are not alternatives of each other."""
    shaping = [info for info in entries if info.part == "covariance" and (_is_process(info) or _has_tails(info))]
    groups = {info.exclusive_group for info in shaping}
    if len(groups) > 1 or "" in groups:
        listed = ", ".join(f"{info.id} ({info.exclusive_group or 'no group'})" for info in shaping)
        yield (
            f"{listed}: a log's errors follow one process or one heavy tail at a time: give all of them one "
            "exclusive_group"
        )


def _role_problems(entries: Sequence[EffectInfo]) -> Iterator[str]:
    """Roles that one effect has, filled by none or by several."""
    for key in _SHOWS_KEY:
        owners = [info.id for info in entries if info.vehicle_key == key]
        if len(owners) > 1:
            yield f"vehicle_key {key!r}: declared by {', '.join(owners)}, expected one effect"
    for scatter in ("release", "drag"):
        owners = [info.id for info in entries if info.scatter == scatter]
        if len(owners) != 1:
            yield f"scatter {scatter!r}: declared by {', '.join(owners) or 'none'}, expected one effect"


def _has_tails(info: EffectInfo) -> bool:
    return getattr(info.effect, "tail_dof", None) is not TransitEffect.tail_dof and issubclass(
        info.effect, TransitEffect
    )


_OWN = (
    dive_forces.DRAG_BIAS,
    dive_log.LINE_PAYOUT,
    dive_forces.SLOW_FLOODING,
    dive_forces.TRAPPED_GAS,
    dive_forces.STRATIFICATION,
    dive_forces.BROADSIDE_START,
    dive_forces.ADDED_MASS,
    dive_log.SENSOR_LAG,
    dive_log.CLOCK_OFFSET,
    dive_log.CLOCK_RATE,
    dive_log.SENSOR_POSITION,
    dive_log.DEPTH_SCALE,
    dive_forces.VERTICAL_CURRENT,
    dive_forces.DRAG_CRISIS,
    currents.MEAN_CURRENT,
    tidal_current.TIDAL_CURRENT,
    currents.INERTIAL_CURRENT,
    course_and_speed.COMPASS_BIAS,
    course_and_speed.COMPASS_DEVIATION,
    course_and_speed.SPEED_SCALE,
    currents.SURFACE_DRIFT,
    random_errors.PERSISTENT_ERROR,
    random_errors.RANDOM_WALK,
    random_errors.POSITION_RANDOM_WALK,
    random_errors.FIX_ERROR,
    random_errors.HEAVY_TAILS,
    currents.CURRENT_SHEAR,
    course_and_speed.CURRENT_RESPONSE,
    course_and_speed.SIDESLIP,
    course_and_speed.HEADING_BY_DEPTH,
    course_and_speed.SPEED_LOSS,
    course_and_speed.COMPASS_JUMP,
    response.RESPONSE,
    tank.REYNOLDS_DRAG,
    tank.QUADRATIC_DAMPING,
    tank.JET_SUCTION,
    tank.THRUST_ASYMMETRY,
    tank.AXIAL_FLOW,
    *RESPONSES,
)

_GROUP = "missionplan.effects"
"""Entry points of packages that add effects: each names an `EffectInfo`, or a sequence of them."""


@dataclass(frozen=True)
class Catalogue:
    """The project's effects and those of plug-ins."""

    entries: Mapping[str, EffectInfo]
    """Effects by name."""
    origins: Mapping[str, str]
    """Package that each comes from, by name."""
    failed: Mapping[str, str]
    """Why a plug-in is left out, by the plug-in's name."""


def with_plugins(core: Sequence[EffectInfo], plugins: Iterable[EntryPoint]) -> Catalogue:
    """Make the catalogue of the project's own effects and of those that installed packages add.

    A plug-in that cannot be loaded, that declares too little or that cannot be combined with the others is left out as
    a whole, with the reason. Raises ValueError when the project's own effects cannot stand together.
    """
    problems = [f"{info.id}: {problem}" for info in core for problem in entry_problems(info)] + catalogue_problems(core)
    if problems:
        raise ValueError("; ".join(problems))
    accepted, failed = list(core), {}
    origins = dict.fromkeys((info.id for info in core), "missionplan")
    for plugin in plugins:
        try:
            loaded = load_plugin(plugin)
            added = [loaded] if isinstance(loaded, EffectInfo) else list(cast("Iterable[EffectInfo]", loaded))
            problems = _plugin_problems(accepted, added)
        except PluginError as error:
            added, problems = [], [str(error)]
        except Exception as error:  # whatever somebody else's code raises does no harm here
            added, problems = [], [f"{type(error).__name__}: {error}"]
        if problems:
            failed[plugin.name] = "; ".join(problems)
        else:
            accepted += added
            origins |= dict.fromkeys((info.id for info in added), plugin.dist.name if plugin.dist else plugin.name)
    return Catalogue({info.id: info for info in accepted}, origins, failed)


def _plugin_problems(accepted: Sequence[EffectInfo], added: Sequence[object]) -> list[str]:
    entries = [info for info in added if isinstance(info, EffectInfo)]
    if len(entries) < len(added) or not added:
        return ["expected an EffectInfo or a sequence of them"]
    problems = [f"{info.id}: {problem}" for info in entries for problem in entry_problems(info)]
    return problems or catalogue_problems([*accepted, *entries])


_ALL = with_plugins(_OWN, entry_points(group=_GROUP))

CATALOGUE: Mapping[str, EffectInfo] = MappingProxyType(dict(_ALL.entries))
"""Effects of the descent, then of the transit, then of the tank alone, then those of plug-ins, by name."""
ORIGINS: Mapping[str, str] = MappingProxyType(dict(_ALL.origins))
"""Package that each effect comes from."""
FAILED_PLUGINS: Mapping[str, str] = MappingProxyType(dict(_ALL.failed))
"""Plug-ins that are left out, and why."""


def effects_of(phase: Phase) -> tuple[EffectInfo, ...]:
    """Return the catalogue's effects on one phase, in its order."""
    return tuple(info for info in CATALOGUE.values() if info.phase == phase)


def exclusive_groups(phase: Phase) -> tuple[frozenset[str], ...]:
    """Return groups of effects on one phase of which a set of causes holds at most one."""
    groups: dict[str, set[str]] = {}
    for info in effects_of(phase):
        if info.exclusive_group:
            groups.setdefault(info.exclusive_group, set()).add(info.id)
    return tuple(frozenset(group) for group in groups.values())


def named_effects(phase: Phase) -> tuple[EffectInfo, ...]:
    """Return the catalogue's effects on one phase that have a name, in its order."""
    return tuple(info for info in effects_of(phase) if info.tier != "neutral")


def scattering_effect(scatter: Scatter) -> str:
    """Return the effect on a descent in which dives scatter from one to the next."""
    return next(info.id for info in effects_of("descent") if info.scatter == scatter)
