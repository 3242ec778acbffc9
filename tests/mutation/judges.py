"""Which tests judge which module: those in the folder of its name, and what a table adds."""

from pathlib import Path

EDGES = (
    "exporters",
    "importers",
    "studies/mission_plan",
    "studies/optimisation",
    "studies/exploration",
    "studies/overdue",
    "phases/mooring",
    "scenario",
    "datasets",
)
"""Where faults survived: what a run without `--modules` draws from, besides all other rooms."""

TABLE = {
    "results/plan.py": ["exporters"],
    "results/whereabouts": ["studies/overdue"],
    "results/choosing": ["studies/optimisation", "studies/comparison"],
    "results/leg_length": ["studies/leg_length"],
    "results/mooring": ["studies/anchor", "studies/simulation"],
    "scenario": ["scenario", "montecarlo/test_streams_drawn.py", "studies/simulation", "phases/mooring"],
    "scenario/currents": ["scenario/currents", "phases/test_field_lookups.py"],
    "studies/mission_plan": ["exporters", "cli/test_export.py"],
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
    "studies/overdue": ["studies/overdue/test_times_of_the_sheet.py", "studies/overdue"],
    "studies/held_vehicle.py": ["scenario/test_held_vehicle.py", "studies/test_standing_vehicle.py"],
    "phases/fields": ["phases/test_field_lookups.py", "scenario/currents"],
    "mission/schema/place.py": ["exporters", "mission"],
}
"""By the beginning of a module's path, the longest that fits; folders and files of `tests`, the quickest first."""


def judges(module: str, tests: Path) -> list[str]:
    """Return the tests nearest to a module, as paths below the folder of tests.

    Parameters
    ----------
    module : str
        Path below the package, such as ``exporters/vehicles/iver.py``.
    tests : Path
        The folder of tests.
    """
    fitting = [key for key in TABLE if module == key or module.startswith(f"{key}/")]
    if fitting:
        return [each for each in TABLE[max(fitting, key=len)] if (tests / each).exists()]
    folder = Path(module).parent
    while folder.parts and not any((tests / folder).rglob("test_*.py")):
        folder = folder.parent
    return [str(folder)] if folder.parts else []
