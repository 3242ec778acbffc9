"""Monte-Carlo mission planning for a self-mooring AUV, and a diagnosis of what the plan's model gets wrong.

Every command of the command line is one public function here; names are imported when first used, so that
``import missionplan`` stays cheap.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

from missionplan.rendering import Rendered, register_renderer

__version__ = version("missionplan")

_PUBLIC = {
    "Mission": "missionplan.mission",
    "diagnose": "missionplan.diagnosis.diagnose",
    "identify": "missionplan.studies.identification.identify",
    "load": "missionplan.mission",
    "plan_legs": "missionplan.studies.leg_length.plan_legs",
    "simulate": "missionplan.studies.simulation.simulate",
    "size_anchor": "missionplan.studies.anchor.size_anchor",
    "sweep_dmax": "missionplan.studies.leg_length.sweep_dmax",
    "sweep_transition": "missionplan.studies.transition.sweep_transition",
}

__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _render(result: Any) -> Rendered:
    """Render with `missionplan.report`, imported when the first result is saved."""
    rendered: Rendered = import_module("missionplan.report.render").render_report(result)
    return rendered


register_renderer(_render)
