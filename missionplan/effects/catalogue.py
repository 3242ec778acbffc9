"""The catalogue: every effect by its stable name."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import cast

from missionplan.effects import (
    added_mass,
    axial_flow,
    broadside_start,
    clock_offset,
    compass_bias,
    compass_deviation,
    current_shear,
    depth_scale,
    drag_bias,
    drag_crisis,
    fix_error,
    heavy_tails,
    inertial_current,
    jet_suction,
    line_payout,
    mean_current,
    persistent_error,
    position_random_walk,
    quadratic_damping,
    random_walk,
    reynolds_drag,
    sensor_lag,
    slow_flooding,
    speed_scale,
    stratification,
    surface_drift,
    thrust_asymmetry,
    tidal_current,
    trapped_gas,
    vertical_current,
)
from missionplan.effects.entry_checks import catalogue_problems, entry_problems
from missionplan.effects.info import EffectInfo, Instrument, Phase, Scatter
from missionplan.packages import PluginError, load_plugin

_FILES = (
    drag_bias,
    line_payout,
    slow_flooding,
    trapped_gas,
    stratification,
    broadside_start,
    added_mass,
    sensor_lag,
    clock_offset,
    depth_scale,
    vertical_current,
    drag_crisis,
    mean_current,
    tidal_current,
    inertial_current,
    compass_bias,
    compass_deviation,
    speed_scale,
    surface_drift,
    persistent_error,
    random_walk,
    position_random_walk,
    fix_error,
    heavy_tails,
    current_shear,
    reynolds_drag,
    quadratic_damping,
    jet_suction,
    thrust_asymmetry,
    axial_flow,
)

_GROUP = "missionplan.effects"
"""Entry points of packages that add effects: each names an `EffectInfo`, or a sequence of them."""


@dataclass(frozen=True)
class Catalogue:
    """The project's effects and those of plug-ins.

    Attributes
    ----------
    entries : mapping
        Effects by name.
    origins : mapping
        Package that each comes from, by name.
    failed : mapping
        Why a plug-in is left out, by the plug-in's name.
    """

    entries: Mapping[str, EffectInfo]
    origins: Mapping[str, str]
    failed: Mapping[str, str]


def with_plugins(own: Sequence[EffectInfo], plugins: Iterable[EntryPoint]) -> Catalogue:
    """Make the catalogue of the project's own effects and of those that installed packages add.

    A plug-in that cannot be loaded, that declares too little or that cannot be combined with the others is left out
    as a whole, with the reason.

    Raises
    ------
    ValueError
        When the project's own effects cannot stand together.
    """
    problems = [f"{info.id}: {problem}" for info in own for problem in entry_problems(info)] + catalogue_problems(own)
    if problems:
        raise ValueError("; ".join(problems))
    accepted, failed = list(own), {}
    origins = dict.fromkeys((info.id for info in own), "missionplan")
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


_ALL = with_plugins([file.INFO for file in _FILES], entry_points(group=_GROUP))

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


def scattering_effect(scatter: Scatter) -> str:
    """Return the effect on a descent in which dives scatter from one to the next."""
    return next(info.id for info in effects_of("descent") if info.scatter == scatter)


def instruments() -> dict[str, Instrument]:
    """Return, by effect, the instruments that measure one effect by itself."""
    return {info.id: info.instrument for info in CATALOGUE.values() if info.instrument is not None}
