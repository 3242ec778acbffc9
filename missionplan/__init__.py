"""Monte-Carlo mission planning for a self-mooring AUV, and a diagnosis of what the plan's model gets wrong.

Every command of the command line is one public function here; names are imported when first used, so that
``import missionplan`` stays cheap.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

__version__ = version("missionplan")

_PUBLIC = {
    "Mission": "missionplan.mission",
    "diagnose": "missionplan.diagnose.study",
    "identify": "missionplan.studies.identify",
    "load": "missionplan.mission",
    "plan_legs": "missionplan.studies.plan_legs",
    "simulate": "missionplan.studies.simulate",
    "size_anchor": "missionplan.studies.size_anchor",
    "sweep_dmax": "missionplan.studies.sweep_dmax",
    "sweep_transition": "missionplan.studies.sweep_transition",
}

__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
