"""Layers of the current against each other, the site's depth and the moorings' design currents."""

from collections.abc import Iterator, Sequence

from missionplan.errors import LocalProblem
from missionplan.mission.checks.phases import phase_path
from missionplan.mission.schema.phases import MoorPhase, Phase
from missionplan.mission.schema.site import CurrentLayer, Site

_TOLERANCE = 1e-6
"""By which the layers may end above the seafloor [m]."""


def check_site(site: Site | None, phases: Sequence[Phase]) -> list[LocalProblem]:
    """List what is wrong with the layers of the current; none where it comes from a file."""
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


def _design_currents(phases: Sequence[Phase], layers: int) -> Iterator[LocalProblem]:
    for index, phase in enumerate(phases):
        given = phase.design_current if isinstance(phase, MoorPhase) else None
        if isinstance(given, tuple) and len(given) != layers:
            message = f"has {len(given)} speeds; site.current has {layers} layers"
            yield LocalProblem((*phase_path(index, phase), "design_current"), message)
