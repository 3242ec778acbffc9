"""Layers and tides of the current against each other, the site's depth and the moorings' design currents."""

from collections.abc import Iterator, Sequence

from missionplan.errors import LocalProblem, did_you_mean, shown
from missionplan.mission.checks.phases import phase_path
from missionplan.mission.schema.phases import MoorPhase, Phase
from missionplan.mission.schema.site import CurrentLayer, Site, TidalCurrent
from missionplan.physics.tides import constituent_names

_MAIN = ("M2", "S2", "N2", "K2", "K1", "O1", "P1", "Q1", "M4")
"""Constituents that an unknown name may have meant."""
_TOLERANCE = 1e-6
"""By which the layers may end above the seafloor [m]."""


def check_site(site: Site | None, phases: Sequence[Phase]) -> list[LocalProblem]:
    """List what is wrong with the layers or constituents of the current; none where it comes from a file."""
    if site is not None and isinstance(site.current, TidalCurrent):
        return list(_constituents(site.current))
    if site is None or not isinstance(site.current, tuple):
        return []
    return [*_layers(site, site.current), *_design_currents(phases, len(site.current))]


def _layers(site: Site, layers: Sequence[CurrentLayer]) -> Iterator[LocalProblem]:
    above = 0.0
    for index, layer in enumerate(layers):
        if isinstance(layer.down_to, float):
            if layer.down_to <= above:
                message = "layers go from the surface down; this one ends above the last"
                yield LocalProblem(("site", "current", index, "down_to"), message)
            above = layer.down_to
    if isinstance(site.depth, float) and 0.0 < above < site.depth - _TOLERANCE:
        message = f"the deepest layer ends at {above:.4g} m, the seafloor is at {site.depth:.6g} m"
        yield LocalProblem(("site", "current"), message)


def _constituents(current: TidalCurrent) -> Iterator[LocalProblem]:
    known = constituent_names()
    for row, depth in enumerate(current.tide.depths):
        for column, wave in enumerate(depth.constituents):
            path = ("site", "current", "tide", "depths", row, "constituents", column, "name")
            if wave.name not in known:
                hint = did_you_mean(wave.name.upper(), known) or f"such as {', '.join(_MAIN)}"
                yield LocalProblem(path, f"given {shown(wave.name)}, which is no constituent that UTide knows", hint)
            elif wave.name in (each.name for each in depth.constituents[:column]):
                yield LocalProblem(path, f"given {shown(wave.name)} a second time at this depth")


def _design_currents(phases: Sequence[Phase], layers: int) -> Iterator[LocalProblem]:
    for index, phase in enumerate(phases):
        given = phase.design_current if isinstance(phase, MoorPhase) else None
        if isinstance(given, tuple) and len(given) != layers:
            message = f"has {len(given)} speeds; site.current has {layers} layers"
            yield LocalProblem((*phase_path(index, phase), "design_current"), message)
