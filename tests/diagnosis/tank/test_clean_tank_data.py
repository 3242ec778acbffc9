"""Tank data without noise, made by the model itself: what is in them is named, and nothing is made of rounding."""

import numpy as np
import pytest
import yaml

from missionplan.datasets.tank import PropellerGeometry
from missionplan.diagnosis.diagnose import diagnose
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.physics.drag import disc_area
from missionplan.studies.identification import TURN, TransientRun

GEOMETRY = {"diameter": "0.3 m", "wake_fraction": 0.15, "axial_flow_factor": 0.2}
MISSION = Mission.from_data({"phases": []})


class Run:
    """Columns of a transient as `TransientRun` takes them."""

    density = 1000.0

    def __init__(self, columns):
        self.columns = columns


def transient(folder, rate, speed, mass_factor=0.0, stated=None):
    """Write a run at a shaft rate [1/min] and a speed [m/s], against time, with flow dynamics where the flow has mass."""
    time = 0.06 * np.arange(60)
    columns = {"t_s": time, "rpm": rate(time) + 0.0 * time, "speed_m_s": speed(time) + 0.0 * time}
    run = TransientRun(Run(columns), PropellerGeometry.model_validate(GEOMETRY))
    unit = 1000.0 * 0.3**4 / TURN**2
    constants = [0.4 * unit, -0.8 * unit * TURN / 0.3 / 1.2]
    mass = mass_factor * 1000.0 * float(disc_area(0.3)) * 0.3
    columns["thrust_n"] = (
        run.axial_flow(np.array([*constants, mass])) if mass else run.quasi_steady(np.array(constants))
    )
    rows = [",".join(map(repr, row)) for row in np.stack(list(columns.values()), axis=1).tolist()]
    (folder / "run.csv").write_text("\n".join([",".join(columns), *rows]) + "\n")
    settings = {"kind": "propeller-transient", "file": "run.csv", "geometry": GEOMETRY}
    settings |= {"noise": {"thrust": f"{stated} N"}} if stated else {}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(settings))
    return folder


def swing(t):
    return 420.0 + 180.0 * np.sin(2.0 * t)


def gather_way(t):
    return 0.9 - 0.7 * np.exp(-t / 4.0)


STATED = (None, 0.5, 1e-4, 1e-10)
QUICK = ((0.0, 1e-10), (1.0, None))


@pytest.mark.parametrize(
    ("mass_factor", "causes", "stated"),
    [
        pytest.param(mass, causes, stated, marks=() if (mass, stated) in QUICK else pytest.mark.slow)
        for mass, causes in ((0.0, ()), (1.0, ("axial-flow",)))
        for stated in STATED
    ],
)
def test_a_clean_transient_is_explained(tmp_path, mass_factor, causes, stated):
    found = diagnose(MISSION, transient(tmp_path, swing, gather_way, mass_factor, stated), plan=False)
    assert found.causes == causes
    assert found.verdict == ("explained" if causes else "adequate")
    assert not found.failures


@pytest.mark.parametrize(
    "stated", [None, pytest.param(1e-4, marks=pytest.mark.slow), 1e-7, pytest.param(1e-10, marks=pytest.mark.slow)]
)
def test_constants_that_one_rate_at_one_speed_cannot_separate(tmp_path, stated):
    """Both constants act alike in every row: their sum is known to the noise, each of them as before."""
    found = diagnose(MISSION, transient(tmp_path, lambda t: 420.0, lambda t: 0.5, stated=stated), plan=False)
    assert found.verdict == "adequate"


def test_a_propeller_that_stands_still_explains_nothing(tmp_path):
    with pytest.raises(InputError, match="thrust_n is 0 in every row"):
        diagnose(MISSION, transient(tmp_path, lambda t: 0.0, lambda t: 0.0), plan=False)
