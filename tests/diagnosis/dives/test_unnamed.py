"""Dives with something that has no name: described beside the named causes, carried, and never an order."""

from dataclasses import replace

import pytest

from missionplan import diagnose
from missionplan.diagnosis.dives.discrepancy_axes import DRAG_OF_SOME
from missionplan.report.diagnosis.page import answer
from tests.hidden_effects.cases import draw_case
from tests.hidden_effects.dives import draw_worth
from tests.hidden_effects.dives.catalogue import EffectKind
from tests.hidden_effects.dives.dynamics import DiveEffect
from tests.hidden_effects.dives.outside import OUTSIDE


def diagnosed(case, folder):
    """Diagnosis of a case of the generators of dives, which share nothing with the phase."""
    return diagnose(*case.write(folder / "case", folder / "truth"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "effect", "found_as"),
    [
        (6001, "foam-compression", "lift-by-depth"),
        (6003, "spooling-line", "drag-by-depth"),
        (6006, "line-drag", "drag-by-line"),
        (6007, "shear-layer", "lift-in-layer"),
        (42_910_009, "pitch-oscillation", "drag-in-swings"),
    ],
)
def test_what_has_no_name_is_described(seed, effect, found_as, tmp_path):
    found = diagnosed(draw_case(seed, "descent", "outside", effect), tmp_path)
    assert found.verdict == "unexplained"
    assert found.causes == (found_as,)


@pytest.mark.slow
def test_a_port_that_mud_leaves_as_a_dive_begins_is_no_place_of_the_sensor(tmp_path):
    found = diagnosed(draw_worth(43_700_007, "plugged-port", (6.0, 20.0)), tmp_path)
    assert found.verdict == "unexplained"
    assert found.causes == ("reading-at-first",)


@pytest.mark.slow
def test_a_part_of_the_anchor_that_falls_off_is_told_carried_and_no_order(tmp_path):
    case = draw_case(6004, "descent", "outside", "weight-loss")
    found = diagnosed(case, tmp_path)
    assert found.verdict == "unexplained"
    assert found.causes == ("weight-from-moment",)
    estimates = {each.name: each for each in found.best.parameters}
    lost = -case.notes["sizes"]["weight-loss"]
    assert abs(estimates["fraction"].value - lost) < 5.0 * estimates["fraction"].sd
    words = answer(found)
    assert "From some moment of the dive on the anchor pulls" in words
    assert "no effect that I know does that" in words
    found.save(tmp_path / "out")
    assert "weight-from-moment:\n      probability: 1.0" in (tmp_path / "out" / "mission.yaml").read_text()


@pytest.mark.slow
def test_an_early_clock_is_in_doubt_where_a_part_of_the_only_line_may_stay_on_the_spool(tmp_path):
    """In dives on one length of line they are the same, and no other line says which it was."""
    found = diagnosed(draw_case(710_009, "descent", "outside", "jammed-spool"), tmp_path)
    assert found.causes == ("clock-offset",)
    assert found.verdict == "ambiguous"
    assert any(each.causes == ("delay-by-line",) for each in found.ranking[:2])


@pytest.mark.slow
def test_a_line_of_which_some_dives_run_out_less_is_no_clock(tmp_path):
    """They begin as early as each other, the rest on time: no scatter of releases does that."""
    found = diagnosed(draw_case(42_910_005, "descent", "outside", "jammed-spool"), tmp_path)
    assert found.verdict == "unexplained"
    assert found.causes == ()
    likeliest = max(found.readings.responses, key=lambda response: response[2])
    assert likeliest[1] == "a delay that differs from dive to dive"


@pytest.mark.slow
def test_a_line_that_stretches_is_no_hull_across_its_way(tmp_path):
    """The vehicle swings on it after the first pull, within seconds."""
    found = diagnosed(draw_case(79_100_018, "descent", "outside", "elastic-line"), tmp_path)
    assert found.verdict == "unexplained"
    assert found.causes == ()
    likeliest = max(found.readings.responses, key=lambda response: response[2])
    assert likeliest[1] == "an error of the depth read that changes with time"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [6301, 6302])
def test_an_anchor_that_weighs_otherwise_than_the_log_book_says_is_described(seed, tmp_path):
    case = draw_case(seed, "descent", "control")
    entry = case.dataset["runs"]["dive-3"]
    wrong = {**entry, "anchor_wet_weight": f"{1.2 * float(entry['anchor_wet_weight'].split()[0]):.3f} N"}
    dataset = {**case.dataset, "runs": {**case.dataset["runs"], "dive-3": wrong}}
    found = diagnosed(replace(case, dataset=dataset), tmp_path)
    assert found.verdict == "unexplained"
    likeliest = max(found.readings.responses, key=lambda response: response[2])
    assert likeliest[1].startswith("an anchor that weighs otherwise than the log book says")
    assert likeliest[2] > 0.9


def _weed_on_the_first(size, rng, conditions):
    return DiveEffect(drag=lambda t, u, z, number: 1.0 + size * (number == 0)), {}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [51_700_006, 51_700_116])
def test_weed_that_one_dive_tows_is_no_scatter_of_all(seed, tmp_path, monkeypatch):
    """Found: 2.9 s late of 27 s in one dive of eight, adequate at 76 %, as no anchor's weight does what drag does."""
    monkeypatch.setitem(OUTSIDE, "weed", EffectKind(0.1, 0.6, _weed_on_the_first))
    found = diagnosed(draw_worth(seed, "weed", (20.0, 60.0)), tmp_path)
    assert found.verdict == "unexplained"
    assert found.causes == ()
    likeliest = max(found.readings.responses, key=lambda response: response[2])
    assert likeliest[1] == DRAG_OF_SOME


def moved(case, *, rate=1.0, aft=0.0):
    """A case whose log has other times, or readings of a sensor behind the nose."""
    time, depth = case.header.index("t_s"), case.header.index("depth_m")
    rows = [list(row) for row in case.rows]
    for row in rows:
        read = float(row[depth])
        row[time], row[depth] = f"{rate * float(row[time]):.4f}", f"{max(read - aft, min(read, 0.0)):.4f}"
    return replace(case, rows=rows)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [6201, 6202])
def test_a_fast_clock_is_an_alias_and_in_doubt(seed, tmp_path):
    found = diagnosed(moved(draw_case(seed, "descent", "control"), rate=1.05), tmp_path)
    assert found.verdict == "ambiguous"
    assert ("clock-rate",) in found.credible_set


@pytest.mark.slow
def test_a_sensor_behind_the_nose_is_named(tmp_path):
    found = diagnosed(moved(draw_case(6203, "descent", "control"), aft=0.9), tmp_path)
    assert found.causes == ("sensor-position",)
    (aft,) = found.best.parameters
    assert abs(aft.value - 0.9) < 4.0 * aft.sd
