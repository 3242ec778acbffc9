"""A wrong GPS fix makes one leg err as much one way as the next the other: it is found, and placed."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from missionplan.diagnosis.legs.kind import TransitKind
from missionplan.mission import Mission
from missionplan.report.diagnosis.findings import wrong_fixes_in_words
from missionplan.report.quantities import reading_in
from missionplan.results.learned.evidence import WrongFix
from tests.museum.sailing import drawn, mission, write


def found(tmp_path: Path, shown, causes=(), left_out=()):
    """Fixes that look wrong in 30 legs whose errors beyond noise are displacements [m] of some legs, by their places."""
    log = drawn(np.random.default_rng(11), 30)
    errors = np.zeros((30, 2))
    for leg, moved in shown:
        errors[leg] += np.asarray(moved) / log.under_way[leg]
    data = write(tmp_path / "legs", log, errors, np.random.default_rng(12))
    rows = (data / "legs.csv").read_text().splitlines(keepends=True)
    (data / "legs.csv").write_text("".join(row for k, row in enumerate(rows) if k - 1 not in left_out))
    kind = TransitKind.bind("transit", data, Mission.from_data(mission(log)), 0)
    return kind.wrong_fixes(kind.model.fit(causes)), kind.data.labels


def test_wrong_fixes_are_placed(tmp_path):
    moved = {5: (150.0, -60.0), 16: (-40.0, 190.0)}
    shown = [(leg + k, np.multiply((1.0, -1.0)[k], by)) for leg, by in moved.items() for k in (0, 1)]
    fixes, labels = found(tmp_path, shown, ("heavy-tails",))
    placed = {fix.leg: (fix.east_m, fix.north_m) for fix in fixes}
    assert set(placed) == {labels[leg] for leg in moved}
    for leg, by in moved.items():
        assert placed[labels[leg]] == pytest.approx(by, abs=40.0)


@pytest.mark.parametrize("shown", [[], [(9, (160.0, 90.0))], [(9, (160.0, 90.0)), (10, (150.0, 80.0))]])
def test_noise_and_legs_that_err_otherwise_are_no_wrong_fix(tmp_path, shown):
    assert not found(tmp_path, shown)[0]


def test_legs_with_others_left_out_between_them_share_no_fix(tmp_path):
    moved = np.array((150.0, -60.0))
    fixes, _ = found(tmp_path, [(5, moved), (9, -moved)], ("heavy-tails",), left_out=(6, 7, 8))
    assert not fixes


def test_they_are_told_in_the_readers_units():
    one = WrongFix("7", 300.0, 400.0, 0.99)
    assert wrong_fixes_in_words(()) == ""
    assert wrong_fixes_in_words([one]).startswith("A GPS fix looks wrong, by 500\u00a0m toward 37° after leg 7: ")
    with reading_in("imperial"):
        several = wrong_fixes_in_words([one, *[replace(one, leg=str(k)) for k in range(8, 14)]])
    assert several.startswith("7 GPS fixes look wrong, by 1640\u00a0ft toward 37° after leg 7, ")
    assert "3 more" in several
    surest = [replace(one, leg=str(k), probability=0.9 + 0.01 * k) for k in range(6)]
    assert re.findall(r"after leg (\d)", wrong_fixes_in_words(surest)) == ["5", "4", "3", "2"]
