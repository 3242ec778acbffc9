"""Simulations and reports in threads of one process do not disturb each other."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import missionplan

MISSION = Path(__file__).parents[3] / "missions" / "fig8.yaml"


def test_two_simulations_with_different_jobs():
    mission = missionplan.load(MISSION)

    def phases(jobs):
        return missionplan.simulate(mission, trials=4200, jobs=jobs, sheet=False).summary()["phases"]

    with ThreadPoolExecutor(3) as threads:
        first, *others = threads.map(phases, (1, 2, 2))
    assert others == [first, first]


def test_two_reports_of_one_result_are_the_same_bytes(tmp_path):
    result = missionplan.simulate(missionplan.load(MISSION), trials=20)
    with ThreadPoolExecutor(2) as threads:
        folders = list(threads.map(lambda number: result.save(tmp_path / str(number)), range(2)))
    contents = [{path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()} for folder in folders]
    assert contents[0] == contents[1]
