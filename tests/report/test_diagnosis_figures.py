"""What a diagnosis's figures draw and its tables tell: captions, bars beside their names, bands, numbers in their columns."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from missionplan.report.diagnosis import evidence
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.results.learned.evidence import DiscrepancyShape, GroupScore, ParameterEstimate, RankedSet

pytestmark = pytest.mark.usefixtures("drawn")

LEGS = {
    **{"t_start_s": [0.0, 900.0], "duration_s": [840.0, 840.0]},
    **{
        f"{what}_{side}_m_s": [0.01, 0.02]
        for what in ("error", "expected", "residual_extended")
        for side in ("east", "north")
    },
}
DIVE = {"run": ["a", "a"], "t_s": [0.0, 1.0], "depth_m": [0.0, 1.0], "base_m": [0.0, 1.1], "extended_m": [0.0, 1.0]}
TANK = {"at_speed": [0.5, 1.0], "force_n": [2.0, 8.0], "base": [2.1, 8.2], "extended": [2.0, 8.0]}
SUMMARY = {
    **{"run": ["a", "b"], "quantity": "terminal_velocity_m_s", "less_simulated": False},
    **{"measured": [1.0, 1.1], "sd": 0.05, "base": [1.0, 1.0], "extended": [1.05, 1.05]},
}


@pytest.mark.parametrize("causes", [(), ("drag-bias",)])
@pytest.mark.parametrize(
    ("kind", "table"), [("transit", LEGS), ("descent", DIVE), ("drag", TANK), ("summary", SUMMARY)]
)
def test_the_main_figure_tells_of_an_extended_model_only_where_it_draws_one(
    kind: str, table: dict[str, Any], causes: tuple[str, ...]
) -> None:
    found: Any = SimpleNamespace(kind=kind, causes=causes, residuals=pd.DataFrame(table))
    figure = REPORTS[kind].data_figure(found)
    assert ("extended" in figure.alt) == bool(causes)
    assert ("extended" in figure.caption or "with the causes" in figure.caption) == bool(causes)


def estimate(effect: str, value: float, sd: float) -> ParameterEstimate:
    return ParameterEstimate(effect, "fraction", value, sd, value - 1.6 * sd, value + 1.7 * sd, "")


def ranked(cause: str, posterior: float, value: float) -> RankedSet:
    return RankedSet((cause,), 4.0 + value, 3.0 + value, posterior, (estimate(cause, value, 0.05),), None, 0.25 + value)


def diagnosed(**given: Any) -> Any:
    """Speed scale before a bias of the compass; of three parts the second is predicted worse."""
    ranking = (ranked("speed-scale", 0.75, 0.2), ranked("compass-bias", 0.2, 0.5))
    scores = tuple(
        GroupScore(f"part {k}", -50.0, -50.0 + gain, 0.04 + k, 0.02 + k) for k, gain in enumerate((3.0, -1.5, 2.0))
    )
    known, now = estimate("fix-error", 0.3, 0.1), estimate("fix-error", 0.4, 0.02)
    usual = {"kind": "transit", "causes": ("speed-scale",), "ranking": ranking, "best": ranking[0], "scores": scores, "none_of_these": 0.1,
             "known": (known,), "confirmed": (now,), "probability_of": lambda effect: 0.8}  # fmt: skip
    return SimpleNamespace(**{**usual, **given})


def plain(rows: Any) -> list[list[str]]:
    return [[cell.replace("\u00a0", " ") for cell in row] for row in rows]


def test_bars_stand_beside_the_name_they_belong_to() -> None:
    axes = Figure().add_subplot()
    evidence.draw_ranking(axes, diagnosed())
    names = [label.get_text() for label in axes.get_yticklabels()]
    bars = {names[round(bar.get_y() + 0.5 * bar.get_height())]: bar for bar in axes.patches}
    assert {name: bar.get_width() for name, bar in bars.items()} == pytest.approx(
        {"speed scale": 75.0, "compass bias": 20.0}
    )
    assert bars["speed scale"].get_y() > bars["compass bias"].get_y()  # the best above
    assert bars["speed scale"].get_facecolor() != bars["compass bias"].get_facecolor()
    axes = Figure().add_subplot()
    evidence.draw_held_out(axes, diagnosed())
    assert [bar.get_width() for bar in axes.patches] == [3.0, -1.5, 2.0]
    assert axes.patches[0].get_facecolor() == axes.patches[2].get_facecolor() != axes.patches[1].get_facecolor()


def test_tables_of_the_evidence_have_each_number_in_its_column() -> None:
    table = evidence.ranking_section(diagnosed()).blocks
    assert [row[:4] for row in plain(table[1].rows)] == [
        ["speed scale", "4.2", "3.2", "75.0 %"],
        ["compass bias", "4.5", "3.5", "20.0 %"],
    ]
    assert plain(table[3].rows) == [["fraction of speed scale", "0.2", "0.12 to 0.285", ""]]
    (section,) = evidence.held_out_section(diagnosed(best=None))
    assert section.heading.startswith("2 of 3 parts are predicted better")
    assert plain(section.blocks[1].rows)[:2] == [["part 0", "+3.0", "0.04", "0.02"], ["part 1", "-1.5", "1.04", "1.02"]]
    (section,) = evidence.known_section(diagnosed())
    assert plain(section.blocks[0].rows) == [
        ["fraction of fix error", "0.30 ± 0.10", "0.40 ± 0.02, if it holds (80.0 %)", ""]
    ]


def test_what_is_left_is_drawn_with_a_band_of_90_percent(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Figure] = {}
    monkeypatch.setattr(evidence, "to_figure", lambda figure, *words, **more: seen.update(figure=figure))
    shape = DiscrepancyShape(
        "Time (h)", "Error (m/s)", np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 0.2]), np.full(3, 0.1)
    )
    evidence.discrepancy_figure(SimpleNamespace(resembles="a drift"), shape)  # type: ignore[arg-type]
    (axes,) = seen["figure"].axes
    band = axes.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == pytest.approx((-0.1645, 0.6645))
    assert np.array(axes.get_lines()[1].get_data()) == pytest.approx(np.array([shape.at, shape.mean]))
