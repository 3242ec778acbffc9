"""Effects that do to a log what the claimed one does, and something else on the mission that is planned."""

import numpy as np
import pytest
import yaml

from missionplan import diagnose
from missionplan.mission import load
from missionplan.report.render import render_report
from tests.fixtures import TRANSIT

CAUSES = ("compass-bias", "mean-current")
KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def turned(t, heading):
    """Six degrees to starboard at 1.2 m/s."""
    actual = heading + np.radians(6.0)
    return 1.2 * np.stack([np.sin(actual) - np.sin(heading), np.cos(actual) - np.cos(heading)])


@pytest.fixture
def planned_at(tmp_path):
    def make(speed):
        (transit,) = (phase["transit"] for phase in TRANSIT["phases"])
        path = tmp_path / f"{speed}.yaml"
        path.write_text(yaml.safe_dump({**TRANSIT, "phases": [{"transit": {**transit, "speed": f"{speed} m/s"}}]}))
        return load(path)

    return make


@pytest.mark.usefixtures("among_few")
def test_what_legs_of_one_speed_cannot_tell_apart_matters_where_another_speed_is_planned(planned_at, folder, legs):
    """A sideslip falls as the square of the speed, a compass errs as much at any speed."""
    faster = diagnose(planned_at(2.4), folder(KIND, legs(24, sigma=0.02, error=turned)), plan=False)
    assert faster.causes == ("compass-bias",)
    (sideslip,) = (alias for alias in faster.readings.aliases if alias.other == "sideslip")
    assert sideslip.claimed == "compass-bias"
    assert "of the speed" in sideslip.trial
    assert 1 <= int(sideslip.trial.split()[0]) <= 12
    # three quarters of 6° of 2.4 m/s are far more than the errors of a leg
    assert sideslip.matters_from == pytest.approx(2.4 * np.mean(legs(24).eval("t_end_s - t_start_s")), rel=0.01)
    assert "Does the same on these legs" in render_report(faster).html


@pytest.mark.usefixtures("among_few")
def test_it_does_not_matter_where_the_speed_of_the_legs_is_planned(planned_at, folder, legs):
    as_sailed = diagnose(planned_at(1.2), folder(KIND, legs(24, sigma=0.02, error=turned)), plan=False)
    assert as_sailed.causes == ("compass-bias",)
    assert "sideslip" not in {alias.other for alias in as_sailed.readings.aliases}
