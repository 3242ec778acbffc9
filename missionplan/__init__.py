"""Monte-Carlo mission planning for a self-mooring AUV, and a diagnosis of what the plan's model gets wrong.

Every command of the command line is one public function here, which takes a mission or the path of its file. Names are
imported when first used, so that ``import missionplan`` stays quick.
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

from missionplan.errors import InputError as InputError
from missionplan.errors import MissionplanError as MissionplanError
from missionplan.errors import RunError as RunError

if TYPE_CHECKING:
    from missionplan.diagnosis.campaign import diagnose_campaign as diagnose_campaign
    from missionplan.diagnosis.campaign import why as why
    from missionplan.diagnosis.diagnose import diagnose as diagnose
    from missionplan.diagnosis.scoring import score as score
    from missionplan.importers import import_logs as import_logs
    from missionplan.mission import Mission as Mission
    from missionplan.mission import load as load
    from missionplan.store import reports as reports
    from missionplan.studies.anchor import size_anchor as size_anchor
    from missionplan.studies.comparison import compare as compare
    from missionplan.studies.comparison import compare_missions as compare_missions
    from missionplan.studies.exploration.explore import explore as explore
    from missionplan.studies.export import export as export
    from missionplan.studies.history import history as history
    from missionplan.studies.identification import identify as identify
    from missionplan.studies.init import init as init
    from missionplan.studies.leg_length.plan_legs import plan_legs as plan_legs
    from missionplan.studies.leg_length.sweep_dmax import sweep_dmax as sweep_dmax
    from missionplan.studies.optimisation.optimise import optimise as optimise
    from missionplan.studies.rare_failure import find_rare_failure as find_rare_failure
    from missionplan.studies.schema import schema as schema
    from missionplan.studies.simulation.simulate import simulate as simulate
    from missionplan.studies.sweep_transition import sweep_transition as sweep_transition
    from missionplan.studies.tide import tide as tide
    from missionplan.studies.validate import validate as validate
    from missionplan.verification import verify as verify

    import_log = import_logs

__version__ = version("missionplan")

_MODULES = {
    "Mission": "missionplan.mission",
    "compare": "missionplan.studies.comparison",
    "compare_missions": "missionplan.studies.comparison",
    "diagnose": "missionplan.diagnosis.diagnose",
    "diagnose_campaign": "missionplan.diagnosis.campaign",
    "explore": "missionplan.studies.exploration.explore",
    "export": "missionplan.studies.export",
    "find_rare_failure": "missionplan.studies.rare_failure",
    "history": "missionplan.studies.history",
    "identify": "missionplan.studies.identification",
    "import_logs": "missionplan.importers",
    "init": "missionplan.studies.init",
    "load": "missionplan.mission",
    "reports": "missionplan.store",
    "optimise": "missionplan.studies.optimisation.optimise",
    "plan_legs": "missionplan.studies.leg_length.plan_legs",
    "schema": "missionplan.studies.schema",
    "score": "missionplan.diagnosis.scoring",
    "simulate": "missionplan.studies.simulation.simulate",
    "size_anchor": "missionplan.studies.anchor",
    "sweep_dmax": "missionplan.studies.leg_length.sweep_dmax",
    "sweep_transition": "missionplan.studies.sweep_transition",
    "tide": "missionplan.studies.tide",
    "validate": "missionplan.studies.validate",
    "verify": "missionplan.verification",
    "why": "missionplan.diagnosis.campaign",
}
"""Module of each public name, imported when the name is first used."""
_ALIASES = {"import_log": "import_logs"}
"""Second names: of one log or several."""

__all__ = ["InputError", "MissionplanError", "RunError", "__version__", *_MODULES, *_ALIASES]


def __getattr__(name: str) -> object:
    name = _ALIASES.get(name, name)
    if name in _MODULES:
        return getattr(import_module(_MODULES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
