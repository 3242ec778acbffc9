"""A glider's navigation log, shared beside the repository; skipped if absent. Modena is `sea.modena` in `validation`."""

from pathlib import Path

import pytest

from missionplan import diagnose
from missionplan.mission import load

DATA = Path(__file__).parents[2].parent / "shared" / "data"


@pytest.fixture(scope="module")
def diagnosed(causes):
    def run(name):
        folder = DATA / name
        if not folder.is_dir():
            pytest.skip(f"no measured data: {folder}")
        with causes():
            return diagnose(load(folder / "mission.yaml"), folder, plan=False)

    return run


def test_saanich_is_adequate(diagnosed):
    found = diagnosed("saanich")
    assert found.verdict == "adequate"
    assert () in found.credible_set
