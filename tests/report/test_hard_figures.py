"""Figures of results that have next to nothing to draw: the fewest legs or dives, no cause claimed, all missing."""

import re
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from outcome_example import MISSIONS

import missionplan
from missionplan.montecarlo.statistics import wilson
from missionplan.rendering import render
from missionplan.studies.rare_failure.page import event_in_words

pytestmark = pytest.mark.usefixtures("drawn")

EIGHT_LEGS = "t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m\n" + "".join(
    f"{400 * leg},{400 * leg + 300},0,0,300,0,{300 + (-9) ** (leg % 2)},{5 - leg}\n" for leg in range(8)
)
"""Fewer are refused, as is a single dive."""
TWO_DIVES = "run,t_s,depth_m\n" + "".join(
    f"{run},{3 + step / 2:g},{0.3 * weight / 11.8 * step * 1.4:.2f}\n"
    for run, weight in (("first", 11.8), ("second", 9.5))
    for step in range(20)
)
RUNS = """runs:
  first: {anchor_wet_weight: 11.8 N, line_length: 5 m}
  second: {anchor_wet_weight: 9.5 N, line_length: 5 m}
"""
DATA = {
    "transit": ("legs.csv", EIGHT_LEGS, ""),
    "descent": ("dives.csv", TWO_DIVES, RUNS),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", DATA)
def test_the_fewest_legs_or_dives_are_drawn(tmp_path, kind):
    file, rows, more = DATA[kind]
    (tmp_path / file).write_text(rows)
    (tmp_path / "dataset.yaml").write_text(f"kind: {kind}\nname: One\nfile: {file}\n{more}")
    mission = missionplan.load(MISSIONS / "chesapeake.yaml")
    for found in (
        missionplan.diagnose(mission, tmp_path, plan=False, jobs=1),
        missionplan.score(mission, tmp_path),
    ):
        rendered = render(found)
        assert rendered.figures
        assert not re.search(r"\bnan\b", rendered.html)


def test_an_exploration_that_never_succeeds_is_drawn():
    found = missionplan.explore(MISSIONS / "chesapeake.yaml", vary=["moor.line_length=4:6:1 m"], trials=8)
    cells = tuple(
        replace(
            cell,
            success=wilson(0, 8),
            quantities={
                name: replace(each, count=0, mean=np.nan, sd=np.nan, p05=np.nan, p50=np.nan, p95=np.nan)
                for name, each in cell.quantities.items()
            },
        )
        for cell in found.cells
    )
    assert render(replace(found, cells=cells)).figures


@pytest.mark.parametrize(
    ("event", "words"),
    [
        ("not total.success", "failure"),
        ("moor.offset > 30 m", "offset of the anchor (moor) above 30 m"),
        ("moor.lowest_altitude < 0.2 m", "lowest altitude of the nose (moor) below 0.2 m"),
        ("moor.struck_seafloor", "strike on the seafloor (moor)"),
        ("not ingress.arrived", "failure of “arrival (ingress)”"),
    ],
)
def test_a_rare_event_is_written_in_words(event, words):
    assert event_in_words(event) == words


def test_a_record_without_a_tide_is_drawn(tmp_path):
    left = np.random.default_rng(1).normal(0.0, 0.05, (2, 180))
    rows = "".join(f"{600 * k},4,{0.2 + left[0, k]:.4f},{left[1, k]:.4f}\n" for k in range(180))
    (tmp_path / "record.csv").write_text(f"t_s,depth_m,east_m_s,north_m_s\n{rows}")
    found = missionplan.tide(tmp_path / "record.csv", latitude=0.65, start=datetime(2026, 4, 1, tzinfo=UTC))
    rendered = render(found)
    assert rendered.figures
    assert not re.search(r"\bnan\b", rendered.html)


def test_a_report_compared_with_itself_is_drawn(simulated):
    report = simulated.page.parent
    rendered = render(missionplan.compare(report, report))
    assert "The results are the same." in rendered.html
    assert not re.search(r"\bnan\b", rendered.html)


def test_a_transition_that_holds_its_depth_at_every_speed_is_drawn():
    few = {"deceleration": ["0.01 m/s^2"], "steepness": ["0.1 m/s"], "mid_speed": ["0.5 m/s", "0.75 m/s"]}
    planned = missionplan.load(MISSIONS / "autosub-transition.yaml").with_({"slow-down.sweep": few})
    found = missionplan.sweep_transition(planned, time_step=1.0)
    rendered = render(replace(found, saturation_speed=np.nan))
    assert rendered.figures
    assert not re.search(r"\bnan\b", rendered.html)
