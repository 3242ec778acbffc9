"""Monte-Carlo mission planning for a self-mooring AUV, and a diagnosis of what the plan's model gets wrong.

Every command of the command line is one public function here; names are imported when first used, so that
``import missionplan`` stays cheap.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

__version__ = version("missionplan")

_PUBLIC = {
    "load": "missionplan.mission",
    "Mission": "missionplan.mission",
    "sweep_dmax": "missionplan.studies.sweep_dmax",
}

__all__ = ["Mission", "__version__", "load", "sweep_dmax"]


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
