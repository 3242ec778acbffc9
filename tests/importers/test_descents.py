"""Dives of a depth record: where each begins and ends, what counts, and what the folder says of it."""

import numpy as np
import pandas as pd
import pytest
import yaml

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.descents import read_marks

BEGAN = 1_700_000_000.0
MARKS = [BEGAN + each for each in (100.0, 400.0, 700.0, 1000.0)]


def imported(folder, *, marks=True, **changes):
    """Four dives at 0.5 m/s to 20, 30, 20 and 0.6 m from the marks; the third has a gap of 15 s in its readings.

    The pitch is read at every other of them.
    """
    t = np.arange(0.0, 1300.0, 0.5)
    depth = np.zeros_like(t)
    for start, bottom in zip((100.0, 400.0, 700.0, 1000.0), (20.0, 30.0, 20.0, 0.6), strict=True):
        since = t - start
        depth = np.where((since >= 0.0) & (since < 200.0), np.clip(0.5 * since, 0.0, bottom), depth)
    rows = pd.DataFrame({"t": BEGAN + t, "depth": depth, "pitch": np.where(t % 1.0 == 0.0, -0.1 * t, np.nan)})
    rows = rows[~((t > 710.0) & (t < 725.0))]
    rows.to_csv(folder / "dives.csv", index=False)
    given = [f"{each:.0f}" for each in MARKS] if marks else []
    return import_logs(
        [folder / "dives.csv"], kind="descent", names=["time=t[epoch] depth=depth pitch=pitch"], marks=given, **changes
    )


def test_each_dive_is_judged_and_its_rows_count_from_the_mark(tmp_path):
    found = imported(tmp_path)
    assert found.counted == 2
    assert found.dives["run"].tolist() == ["dive-1", "dive-2", "dive-3", "dive-4"]
    assert found.dives["ok"].tolist() == [1, 1, 0, 0]
    assert found.dives["reason"].tolist() == ["", "", "a gap in the log (15 s)", "not as deep as 1 m (0.6 m)"]
    assert found.dives["max_depth_m"].to_numpy() == pytest.approx([20.0, 30.0, 20.0, 0.6])
    assert found.dives["t_start_s"].tolist() == MARKS
    assert found.dives["t_start"].tolist()[0] == "2023-11-14T22:15:00.000+00:00"
    first = found.table[found.table["run"] == "dive-1"]
    assert first["depth_m"].to_numpy() == pytest.approx(np.clip(0.5 * first["t_s"], 0.0, 20.0))
    assert first["pitch_deg"].to_numpy() == pytest.approx(-0.1 * (first["t_s"] + 100.0), abs=1e-3)
    assert (first["t_s"].min(), first["t_s"].max()) == (0.0, 44.5)  # five seconds beyond 98 % of the way down
    assert found.dives["t_end_s"].tolist()[:2] == [MARKS[0] + 44.5, MARKS[1] + 64.0]
    assert (found.table.groupby("run")["ok"].nunique() == 1).all()


def test_too_few_readings_are_no_dive(tmp_path):
    t = np.concatenate([np.arange(0.0, 100.0, 0.5), 100.0 + 5.0 * np.arange(5), np.arange(300.0, 500.0, 0.5)])
    depth = np.where(t < 300.0, np.clip(0.5 * (t - 100.0), 0.0, None), np.clip(0.5 * (t - 300.0), 0.0, 20.0))
    pd.DataFrame({"t": BEGAN + t, "depth": depth}).to_csv(tmp_path / "a.csv", index=False)
    found = import_logs(
        [tmp_path / "a.csv"],
        kind="descent",
        names=["time=t[epoch] depth=depth"],
        marks=[f"{BEGAN + each:.0f}" for each in (100, 300)],
    )
    assert found.dives["reason"].tolist() == ["fewer than 8 readings (5)", ""]


def test_the_folder_says_what_is_known_and_what_is_not(tmp_path):
    found = imported(tmp_path)
    told = dict(found.can_show)
    assert told["drag, mass and flooding of the descent"] == "yes: 2 dives"
    assert told["late payout of the line, a clock's offset"] == "yes"
    assert told["interval of the readings"] == "0.5 s"
    assert list(found.dataset["runs"]) == ["dive-1", "dive-2"]
    assert yaml.safe_load(found.mission_text)["site"]["depth"] == "35.0 m"  # the deepest and the line
    assert found.figures.max_depth == 30.0
    by_sinking = imported(tmp_path, marks=False)
    assert by_sinking.dives["t_start_s"].to_numpy() == pytest.approx(MARKS[:3], abs=0.6)
    assert dict(by_sinking.can_show)["late payout of the line, a clock's offset"].startswith("no: ")


def test_a_mark_long_before_the_log_is_of_no_dive(tmp_path):
    imported(tmp_path)
    found = import_logs([tmp_path / "dives.csv"], kind="descent", names=["time=t[epoch] depth=depth"],
                        marks=["2023-11-14T15:15:00Z"])  # fmt: skip
    assert found.dives["ok"].tolist() == [0]
    assert found.dives["reason"][0].startswith("a gap in the log (2")


def test_marks_are_read_in_any_order():
    assert read_marks(["2023-11-14T22:15:00Z", "1700000000"]) == [BEGAN, BEGAN + 100.0]
    with pytest.raises(InputError, match="given 'noon', expected a time") as refused:
        read_marks(["noon", "1700000000", "night"])
    assert len(refused.value.problems) == 2


@pytest.mark.parametrize(("sign", "reads"), [(1.0, 0.9), (1.0, 1.6), (-1.0, 0.0)])
def test_a_gauge_that_is_off_or_counts_upwards_hides_no_dive(tmp_path, sign, reads):
    plain = imported(tmp_path, marks=False)
    rows = pd.read_csv(tmp_path / "dives.csv")
    rows.assign(depth=sign * rows["depth"] + reads).to_csv(tmp_path / "other.csv", index=False)
    found = import_logs([tmp_path / "other.csv"], kind="descent", names=["time=t[epoch] depth=depth pitch=pitch"])
    assert found.dives["t_start_s"].tolist() == plain.dives["t_start_s"].tolist()
    assert len(found.dives) == 3  # the fourth is not as deep as a metre
    left = reads if reads <= 1.0 else 0.0
    assert found.table["depth_m"].to_numpy() == pytest.approx(plain.table["depth_m"].to_numpy() + left, abs=2e-3)
    assert any("gauge reads 1.6 m" in each for each in found.provenance.notices) == (reads > 1.0)
