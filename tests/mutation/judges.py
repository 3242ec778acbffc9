"""Which tests judge which module: its own folder's or what a table names, and those that import it."""

import ast
from functools import cache
from pathlib import Path

EDGES = (
    "exporters",
    "importers",
    "studies/export.py",
    "studies/planned_phases.py",
    "studies/optimisation",
    "studies/exploration",
    "studies/history",
    "diagnosis/next_trial",
    "phases/mooring",
    "scenario",
    "datasets",
)
"""Where faults survived: what a run without `--modules` draws from, besides all other rooms."""

TABLE = {
    "results/plan.py": ["exporters"],
    "results/whereabouts": ["studies/simulation/test_times_of_the_sheet.py", "studies/simulation/test_overdue.py"],
    "results/choosing": ["studies/optimisation", "studies/comparison"],
    "results/leg_length": ["studies/leg_length"],
    "results/mooring": ["studies/anchor", "studies/simulation"],
    "scenario": ["scenario", "montecarlo/test_streams_drawn.py", "studies/simulation", "phases/mooring"],
    "scenario/place.py": ["scenario/place", "phases/place", "studies/simulation/test_over_ground.py"],
    "scenario/transits.py": ["scenario/test_drift_model.py", "studies/simulation/test_kalman_filter_missions.py"],
    "scenario/currents": ["scenario/currents", "phases/test_field_lookups.py"],
    "importers/readers/netcdf.py": ["importers/readers/test_netcdf_variables.py", "importers"],
    "datasets/tank.py": ["datasets", "studies/identification", "diagnosis/tank"],
    "diagnosis/next_trial": ["next_trial", "diagnosis/inference/test_value_of_trials.py"],
    "studies/export.py": ["cli/test_export.py", "exporters"],
    "studies/planned_phases.py": ["exporters", "cli/test_export.py"],
    "studies/optimisation": [
        "studies/optimisation/test_against_brute_force.py",
        "studies/optimisation/test_search.py",
        "studies/optimisation/test_optimise.py",
    ],
    "studies/exploration": [
        "studies/exploration/test_shared_current.py",
        "studies/optimisation/test_against_brute_force.py",
        "studies/exploration",
    ],
    "studies/history": ["studies/test_history.py", "mission/test_levels_ahead.py", "studies/test_failure_rates.py"],
    "importers/readers": ["importers"],
    "importers/mapping.py": ["importers"],
    "importers/readers/ardupilot.py": ["importers/test_ardupilot.py", "importers"],
    "importers/readers/slocum.py": ["importers/test_structure_of_slocum.py", "importers"],
    "studies/simulation/overdue.py": [
        "studies/simulation/test_times_of_the_sheet.py",
        "studies/simulation/test_overdue.py",
    ],
    "studies/held_vehicle.py": ["scenario/test_held_vehicle.py", "studies/test_standing_vehicle.py"],
    "phases/gridded_current.py": ["phases/test_field_lookups.py", "scenario/currents"],
    "mission/schema/place.py": ["exporters", "mission"],
}
"""By the beginning of a module's path, the longest that fits; folders and files of `tests`, the quickest first."""


COMMON = 8
"""A module that more test files import than this is nobody's own: its folder judges it."""


def judges(module: str, tests: Path) -> list[str]:
    """Return the tests nearest to a module, as files below the folder of tests.

    Of its own those that import it come first, then the others, then what else imports it: a fault is noticed sooner.

    Parameters
    ----------
    module : str
        Path below the package, such as ``exporters/iver.py``.
    tests : Path
        The folder of tests.
    """
    fitting = [key for key in TABLE if module == key or module.startswith(f"{key}/")]
    near = [each for each in TABLE[max(fitting, key=len)] if (tests / each).exists()] if fitting else []
    folder = Path(module).parent
    while not fitting and folder.parts and not near:
        near = sorted(path.relative_to(tests).as_posix() for path in (tests / folder).glob("test_*.py"))
        folder = folder.parent
    users = _users(tests).get(f"missionplan.{module.removesuffix('.py').replace('/', '.')}", [])
    own = [path.relative_to(tests).as_posix() for each in near for path in _files(tests / each)]
    beside = [each for each in users if each not in own] if len(users) <= COMMON else []
    return list(dict.fromkeys([*(each for each in own if each in users), *own, *beside]))


def _files(place: Path) -> list[Path]:
    return sorted(place.rglob("test_*.py")) if place.is_dir() else [place]


@cache
def _users(tests: Path) -> dict[str, list[str]]:
    """Test files by what they import."""
    found: dict[str, list[str]] = {}
    for path in sorted(tests.rglob("test_*.py")):
        names = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                names |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
            elif isinstance(node, ast.Import):
                names |= {each.name for each in node.names}
        for name in names:
            found.setdefault(name, []).append(path.relative_to(tests).as_posix())
    return found
