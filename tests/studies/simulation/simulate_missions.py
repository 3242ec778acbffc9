"""Missions for the tests of `simulate`: the Chesapeake test with some of its values replaced."""

import copy
from pathlib import Path

import yaml

from missionplan.mission import load

MISSIONS = Path(__file__).parents[3] / "missions"
GONE = object()
EXACT = {  # nothing errs, nothing is uncertain, the water is still
    "site.current": GONE,
    "navigation.velocity_error": {"sigma": "0 m/s"},
    "navigation.fix_error": "0 m",
    "navigation.drift_compensation": "none",
    "phases.1.moor.release_time": "10 s",
    "phases.1.moor.galvanic_release": "10 min",
}


def chesapeake_data():
    data = yaml.safe_load((MISSIONS / "chesapeake.yaml").read_text())
    data["vehicle"] = yaml.safe_load((MISSIONS / "vehicles" / "vt475-self-mooring.yaml").read_text())
    return data


def chesapeake(folder, changes=None, name="mission.yaml"):
    """Write the mission with the values at some paths replaced (or removed: GONE), and load it."""
    data = copy.deepcopy(chesapeake_data())
    for path, value in (changes or {}).items():
        *parents, last = path.split(".")
        section = data
        for part in parents:
            section = section[int(part)] if isinstance(section, list) else section.setdefault(part, {})
        if value is GONE:
            section.pop(last)
        else:
            section[int(last) if isinstance(section, list) else last] = value
    (folder / name).write_text(yaml.safe_dump(data))
    return load(folder / name)
