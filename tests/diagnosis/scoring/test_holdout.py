"""The last share of a record is kept away from the diagnosis, and scored."""

from pathlib import Path

import numpy as np
import pytest

import missionplan


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The starter's sea trial: 32 legs with a compass bias of 3 degrees that the mission does not hold."""
    folder = tmp_path_factory.mktemp("holdout") / "trial"
    missionplan.init(folder)
    return folder


def test_the_extended_mission_predicts_what_was_held_out(trial: Path, tmp_path: Path) -> None:
    found = missionplan.diagnose(trial / "mission.yaml", trial / "sea-trial", plan=False, holdout=0.4)
    assert found.causes == ("compass-bias",)
    assert len(found.residuals) == 19
    last = found.last_part
    assert last is not None
    assert last.groups == 13
    assert last.labels[0] == "20"
    assert last.whole.rmse < 0.8 * last.whole.yardsticks["no_effects"].rmse
    assert last.is_within_chance
    saved = found.save(tmp_path / "report")
    assert (saved / "score.json").is_file()
    assert "the last 13 legs" in (saved / "report.html").read_text()


def test_what_is_held_out_changes_nothing_before(trial: Path) -> None:
    """Scrambled errors in the last legs leave the diagnosis bit for bit."""
    first = missionplan.diagnose(trial / "mission.yaml", trial / "sea-trial", plan=False, holdout=0.4)
    table = trial / "sea-trial" / "legs.csv"
    lines = table.read_text().splitlines()
    x_end = lines[0].split(",").index("x_end_m")
    for row in range(len(lines) - 10, len(lines)):
        cells = lines[row].split(",")
        cells[x_end] = str(float(cells[x_end]) + 50.0)
        lines[row] = ",".join(cells)
    table.write_text("\n".join(lines) + "\n")
    again = missionplan.diagnose(trial / "mission.yaml", trial / "sea-trial", plan=False, holdout=0.4)
    assert again.extended == first.extended
    assert np.any(again.last_part.measured != first.last_part.measured)  # type: ignore[union-attr]


@pytest.mark.parametrize(("share", "said"), [(0.01, "at least 8 and 8"), (0.9, "at least 8 and 8"), (1.5, "between 0")])
def test_a_part_too_short_is_refused(trial: Path, share: float, said: str) -> None:
    with pytest.raises(missionplan.InputError, match=said):
        missionplan.diagnose(trial / "mission.yaml", trial / "sea-trial", plan=False, holdout=share)
