"""Cells of an exploration are simulations on common random numbers; the best start in a tide is known in closed form."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import xarray

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.results.decision import Assumption
from missionplan.studies import judgement

MISSIONS = Path(__file__).parents[3] / "missions"
CALM = Assumption("it is calm", "a swell", 0.03, 0.93, is_required=True)
VARY = "moor.line_length=4:12:4 m"


@pytest.fixture(scope="module")
def whole():
    return missionplan.load(MISSIONS / "chesapeake.yaml")


@pytest.fixture(scope="module")
def chesapeake(whole):
    """The mission until the vehicle is back at the surface."""
    return Mission.from_data({**whole.raw, "phases": whole.raw["phases"][:2]}, file=whole.file)


@pytest.mark.parametrize(("limit", "meets"), [("1 s", False), ("1 d", True)])
def test_assumptions_of_the_best_are_asked_for_where_it_meets_what_is_required(limit, meets, monkeypatch):
    monkeypatch.setattr(judgement, "ledger", lambda *_: (CALM,))
    way = {"from": ["0 m", "0 m"], "to": ["500 m", "0 m"], "speed": "1 m/s", "d_max": "300 m", "arrival_radius": "99 m"}
    data = {
        "navigation": {"velocity_error": {"sigma": "0.001 m/s"}, "surfacing_time": "60 s"},
        "phases": [{"transit": way}],
        "requirements": [{"quantity": "transit.duration", "at_most": limit, "probability": 0.9}],
    }
    found = missionplan.explore(Mission.from_data(data), "d_max=200:300:100 m", trials=20, jobs=1)
    assert (found.constrained, found.assumed) == (meets, (CALM,) if meets else ())


def tidal_mission(folder, *, peak, period=12.42 * 3600.0, distance=6000.0):
    """Along a tide that runs to and fro everywhere alike, fastest towards the goal six hours into 1 June."""
    time = np.arange(0.0, 30.0 * 3600.0, 300.0)
    tide = peak * np.cos(2.0 * np.pi * (time - 6.0 * 3600.0) / period)
    shape = (time.size, 1, 2, 2)
    field = {
        "u": (("time", "depth", "lat", "lon"), np.broadcast_to(tide[:, None, None, None], shape), {"units": "m s-1"}),
        "v": (("time", "depth", "lat", "lon"), np.zeros(shape), {"units": "m s-1"}),
    }
    start = np.datetime64("2026-06-01", "ns")
    axes = {
        "time": start + (time * 1e9).astype("timedelta64[ns]"),
        "depth": ("depth", [0.0], {"units": "m", "positive": "down"}),
        "lat": [49.8, 50.2],
        "lon": [-5.2, -4.8],
    }
    xarray.Dataset(field, axes).to_netcdf(folder / "tide.nc")
    return Mission.from_data(
        {
            "start": "2026-06-01",
            "site": {
                "origin": {"latitude": "50 deg", "longitude": "-5 deg"},
                "current": {"file": str(folder / "tide.nc"), "outside": "hold"},
            },
            "navigation": {"velocity_error": {"sigma": "0.0001 m/s"}, "surfacing_time": "0 s"},
            "phases": [
                {
                    "transit": {
                        "from": ["0 m", "0 m"],
                        "to": [f"{distance} m", "0 m"],
                        "speed": "1 m/s",
                        "d_max": "100 km",
                        "arrival_radius": "3 km",
                    }
                }
            ],
        }
    )


def test_the_best_start_in_a_tide_puts_the_middle_of_the_trip_at_its_peak(tmp_path):
    # one leg of the time L/V through the water, without compensation: the tide carries it past the goal by the integral
    # of its speed, which is the most, 2 U/ω sin(ω L/2V), for a trip whose middle is at the peak
    peak, omega, distance = 0.4, 2.0 * np.pi / (12.42 * 3600.0), 6000.0
    mission = tidal_mission(tmp_path, peak=peak, distance=distance)
    found = missionplan.explore(
        mission, "start=03:00:07:00:10 min", quantities=["transit.arrival_error"], trials=20, jobs=1
    )
    carried = [cell.quantities["transit.arrival_error_m"].mean for cell in found.cells]
    starts = found.axes[0].numbers
    expected = datetime(2026, 6, 1, 6, tzinfo=UTC) - timedelta(seconds=0.5 * distance)
    assert abs(starts[int(np.argmax(carried))] - expected.timestamp()) <= 300.0
    assert max(carried) == pytest.approx(2.0 * peak / omega * np.sin(0.5 * omega * distance), rel=2e-3)


def test_a_cell_is_the_simulation_of_its_mission(chesapeake):
    found = missionplan.explore(chesapeake, VARY, quantities=["moor.offset", "moor.within_radius"], trials=150)
    longer = Mission.from_data(
        {**chesapeake.raw, "phases": _with_line(chesapeake.raw["phases"], "8 m")}, file=chesapeake.file
    )
    alone = missionplan.simulate(longer, trials=150, sheet=False)
    cell = found.cells[1]
    assert cell.success == alone.total.events["success"]
    assert cell.quantities["moor.offset_m"].mean == pytest.approx(
        alone.phases[1].quantities["offset_m"].mean, rel=1e-12
    )
    assert cell.events["moor.within_radius"] == alone.phases[1].events["within_radius"]
    assert [item.probability for item in cell.requirements] == [item.probability for item in alone.requirements]


def _with_line(phases, length):
    return [
        {kind: {**section, "line_length": length} if kind == "moor" else section}
        for each in phases
        for kind, section in each.items()
    ]


def test_a_cell_that_cannot_be_run_has_its_reason_and_the_others_go_on(chesapeake):
    found = missionplan.explore(chesapeake, VARY, trials=60)
    assert [bool(cell.reason) for cell in found.cells] == [False, False, True]
    assert "line" in found.cells[2].reason
    assert found.cells[2].status == "invalid"
    assert "reason" in found.summary()["cells"][2]
    assert found.to_frame().status.tolist()[2] == "invalid"


def test_bits_depend_neither_on_processes_nor_on_the_order_of_cells(chesapeake):
    one = missionplan.explore(chesapeake, VARY, trials=60)
    two = missionplan.explore(chesapeake, VARY, trials=60, jobs=2)
    back = missionplan.explore(chesapeake, "moor.line_length=12:4:-4 m", trials=60)
    assert repr(one.cells) == repr(two.cells)  # nan is there too
    columns = ["moor.line_length", "success", "total.energy_wh", "total.duration_s"]
    rows = back.to_frame().iloc[::-1].reset_index(drop=True)
    assert one.to_frame()[columns].equals(rows[columns])


def test_a_run_cut_short_goes_on_with_the_same_numbers(chesapeake, tmp_path):
    whole = missionplan.explore(chesapeake, VARY, trials=60)
    first = missionplan.explore(chesapeake, VARY, trials=60, checkpoint=tmp_path / "blocks")
    kept = sorted((tmp_path / "blocks").glob("block-*.npz"))
    assert len(kept) == 3
    kept[0].unlink()
    kept[1].write_bytes(kept[1].read_bytes()[:-50])
    again = missionplan.explore(chesapeake, VARY, trials=60, checkpoint=tmp_path / "blocks", resume=True)
    assert repr(whole.cells) == repr(first.cells) == repr(again.cells)  # nan is there too
    with pytest.raises(InputError, match="another run"):
        missionplan.explore(chesapeake, VARY, trials=60, seed=2, checkpoint=tmp_path / "blocks", resume=True)


def test_vehicles_words_and_tied_keys_can_be_varied(whole, chesapeake, tmp_path):
    chesapeake = chesapeake.with_({"navigation.max_legs": 20})  # where the drift is not met none would do
    heavier = (MISSIONS / "vehicles" / "vt475-self-mooring.yaml").read_text().replace("mass: 10.2 kg", "mass: 12 kg")
    (tmp_path / "heavier.yaml").write_text(heavier)
    here = MISSIONS / "vehicles" / "vt475-self-mooring.yaml"
    found = missionplan.explore(
        chesapeake,
        [f"vehicle={here},{tmp_path / 'heavier.yaml'}", "navigation.drift_compensation=none,mean"],
        trials=40,
    )
    assert [axis.labels for axis in found.axes] == [("vt475-self-mooring", "heavier"), ("none", "mean")]
    assert len(found.valid) == 4
    times = ["ingress.duration", "egress.duration"]
    tied = missionplan.explore(whole, "ingress.speed+egress.speed=1:2:1 m/s", quantities=times, trials=40)
    slow, fast = tied.cells
    for phase in times:
        assert slow.quantities[f"{phase}_s"].mean - fast.quantities[f"{phase}_s"].mean > 0.7 * 1600.0 * 0.5


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("ingress.sped=1:2:0.5 m/s", "did you mean ingress.speed"),
        ("moor.hold=1:2 min", "expected FROM:TO:STEP"),
        ("moor.hold=1 min:2 min:-10 s", "never lead"),
        ("moor.hold=1 min:2 m:1 min", "expected a quantity in min"),
        ("moor.hold", "expected KEY=FROM:TO:STEP"),
        ("moor.hold=1:1000000:1 s", "at most 5000"),
        ("ingress.speed=1:2:1", "expected a unit too"),
        ("start=04:00:05:00:10 min", "the mission has none"),
        (["moor.hold=1:2:1 min", "moor.hold=1:2:1 min"], "twice"),
        ([], "expected once or twice"),
    ],
)
def test_a_wrong_option_gets_one_clear_message(chesapeake, vary, words):
    with pytest.raises(InputError, match=words):
        missionplan.explore(chesapeake, vary, trials=10)


def test_a_quantity_that_no_phase_has_is_refused_with_the_nearest(chesapeake):
    with pytest.raises(InputError, match="did you mean offset"):
        missionplan.explore(chesapeake, VARY, quantities=["moor.ofset"], trials=10)


def test_a_report_says_the_best_the_windows_and_what_cannot_be_run(chesapeake, tmp_path):
    found = missionplan.explore(chesapeake, VARY, trials=200)
    found.save(tmp_path / "report")
    page = (tmp_path / "report" / "report.html").read_text()
    assert "The best line length (moor) is" in page
    assert "1 of the 3 choices cannot be run" in page
    assert (tmp_path / "report" / "explore.csv").read_text().count("\n") == 4
