"""Missions run on common random numbers, and reports, in one table: which is better, by how much."""

from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.mission.mission import with_values
from missionplan.results import to_yaml
from missionplan.studies.comparison.alternatives_page import answer

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture
def files(tmp_path):
    base = missionplan.load(MISSIONS / "chesapeake.yaml")

    def write(name, **values):
        path = tmp_path / f"{name}.yaml"
        path.write_text(
            to_yaml(with_values(base.raw, {key.replace("__", "."): value for key, value in values.items()}))
        )
        return path

    return write


def test_the_better_mission_is_named_with_the_difference_and_its_error(files):
    usual, worse = files("usual"), files("far", moor__radius="3 m")
    found = missionplan.compare_missions(worse, usual, trials=300)
    assert found.best_one.name == "usual"
    contrast = found.others[0].contrasts["success"]
    alone = [missionplan.simulate(missionplan.load(path), trials=300, sheet=False) for path in (worse, usual)]
    shares = [each.total.events["success"].value for each in alone]
    assert contrast.difference == pytest.approx(shares[0] - shares[1])
    assert contrast.differs
    assert contrast.paired
    assert answer(found).startswith("usual is better than far: it succeeds with")


def test_missions_that_are_alike_cannot_be_told_apart(files):
    first, second = files("first"), files("second", moor__hold="20.001 min")
    found = missionplan.compare_missions(first, second, trials=100)
    assert "first and second cannot be told apart by P(success)" in answer(found)
    assert found.others[0].contrasts["energy_wh"].differs  # by a tenth of a second in each trial: exactly
    assert "first takes less energy" in answer(found)


def test_a_report_and_a_mission_are_compared_as_independent_runs(files, tmp_path):
    usual = files("usual")
    missionplan.simulate(missionplan.load(usual), trials=100, seed=5, sheet=False).save(tmp_path / "report")
    found = missionplan.compare_missions(tmp_path / "report", usual, files("other", ingress__speed="1 m/s"), trials=100)
    assert len(found.alternatives) == 3
    kinds = {each.name: each.contrasts.get("success") for each in found.alternatives}
    best = found.best_one.name
    assert all(
        contrast is None or contrast.paired == ("report" not in (name, best)) for name, contrast in kinds.items()
    )
    assert np.isfinite(found.to_frame()["energy_wh"]).all()
    found.save(tmp_path / "page")
    assert "Side by side" in (tmp_path / "page" / "report.html").read_text()


def test_what_is_neither_mission_nor_report_is_refused(files, tmp_path):
    with pytest.raises(InputError, match="two or more"):
        missionplan.compare_missions(files("usual"))
    with pytest.raises(InputError, match="no such file"):
        missionplan.compare_missions(files("usual"), tmp_path / "none.yaml")
    with pytest.raises(InputError, match="moor"):
        missionplan.compare_missions(files("usual"), files("long", moor__line_length="30 m"), trials=10)
