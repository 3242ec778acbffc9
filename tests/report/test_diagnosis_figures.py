"""What a diagnosis's figures draw and its tables tell: captions, bars beside their names, bands, numbers in their columns."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from missionplan.report.diagnosis import campaign, evidence, kinds, scoring
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.report.page import BLUE, GREY
from missionplan.results.learned.evidence import DiscrepancyShape, GroupScore, ParameterEstimate, RankedSet
from missionplan.results.score import DatasetScore, Prediction, Yardstick

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
    assert [bars[name].get_facecolor() for name in ("speed scale", "compass bias")] == [to_rgba(BLUE), to_rgba(GREY)]
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
    assert plain(table[3].rows) == [["fraction of speed scale", "0.20", "0.12 to 0.29", ""]]
    (section,) = evidence.held_out_section(diagnosed(best=None))
    assert section.heading.startswith("Predicted better when held out: 2 of 3 parts")
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


def lines(axes: Any) -> dict[str, np.ndarray]:
    return {str(line.get_label()): np.array(line.get_data(), dtype=float) for line in axes.get_lines()}


def test_each_kind_of_data_is_drawn_with_the_model_that_its_label_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """Legs at the middle of their times, the extended model where measured and left say; dives and tests as tabled."""
    seen: list[Figure] = []
    monkeypatch.setattr(kinds, "to_figure", lambda figure, *words, **more: seen.append(figure))
    legs = {"t_start_s": [0.0, 900.0], "duration_s": [840.0, 420.0]}
    for k, side in enumerate(("east", "north")):
        for what, value in (("error", 0.05), ("expected", 0.02), ("residual_extended", 0.01)):
            legs[f"{what}_{side}_m_s"] = [value + 0.001 * k, value + 0.002]
    dive = {**DIVE, "base_m": [0.0, 1.1], "extended_m": [0.0, 0.9]}
    for kind, table in (("transit", legs), ("descent", dive), ("summary", {**SUMMARY, "base": [0.9, 0.8]})):
        REPORTS[kind].data_figure(SimpleNamespace(kind=kind, causes=("a",), residuals=pd.DataFrame(table)))  # type: ignore[arg-type]
    for k, axes in enumerate(seen[0].axes):
        drawn = lines(axes)
        for label, value in (("measured", 5.0), ("mission", 2.0), ("extended, a leg ahead", 4.0)):
            own = 0.0 if label.startswith("extended") else 0.1 * k
            assert drawn[label] == pytest.approx(
                np.array([[420.0 / 3600.0, 1110.0 / 3600.0], [value + own, value + 0.2 * (label[0] == "m")]])
            )
    drawn = lines(seen[1].axes[0])
    assert [drawn[label][1, 1] for label in ("measured", "mission", "extended")] == [1.0, 1.1, 0.9]
    (axes,) = seen[2].axes
    drawn = {str(line.get_label()): list(line.get_xdata()) for line in axes.get_lines()}
    assert [drawn[label] for label in ("mission", "extended")] == [[0.9, 0.8], [1.05, 1.05]]
    assert [np.ptp(part[:, 0]) for part in axes.collections[0].get_segments()] == pytest.approx([0.1, 0.1])


def test_how_far_a_leg_ends_is_both_axes_of_its_error_by_its_time() -> None:
    """0.1 m/s on each axis over 1000 s are 141 m, to two digits; before is as the mission stands, which learns nothing."""
    sides = {f"residual_base_{side}_m_s": [0.1] * 3 for side in ("east", "north")}
    found: Any = SimpleNamespace(residuals=pd.DataFrame({"duration_s": [1000.0] * 3, **sides}))
    for learning in (0.1, 0.06, 0.04):
        words = REPORTS["transit"].gained(found, learning, 0.05).replace("\u00a0", " ")
        assert words == "; a leg of 16.7 min then ends 71 m from where it is expected, not 140 m"
    found.residuals.loc[3] = [1.0, 9.0, 9.0]  # whose fixes alone make such velocities
    assert REPORTS["transit"].gained(found, 0.1, 0.05).replace("\u00a0", " ") == words


def test_a_score_draws_and_tells_the_numbers_of_its_own_axis_and_prediction() -> None:
    other = Yardstick(30.0, -5.0, 17.0)
    ahead, whole = (
        Prediction(rmse, -4.0, 9.0, 2, 3, (0.8, 1.0), 0.5, 0.05, np.arange(4.0) + add, np.full(4, 2.0), np.ones(4), np.full(4, 0.5),
                   {"no_effects": other, "last_leg": other})
        for rmse, add in ((12.0, 0.0), (18.0, 100.0))
    )  # fmt: skip
    each = DatasetScore(
        "log", "transit", 2, np.arange(4), np.arange(4), np.array([10.0, 20.0, 11.0, 21.0]), ahead, whole, 1.0
    )
    for axis, name in enumerate(("East", "North")):
        axes = Figure().add_subplot()
        scoring._leg_panel(axes, each, axis)
        assert lines(axes)["measured"].tolist() == [[1.0, 2.0], [10.0 + 10.0 * axis, 11.0 + 10.0 * axis]]
        assert axes.get_ylabel().startswith(f"{name} error")
        bands = [band.get_paths()[0].vertices[:, 1] for band in axes.collections]
        for band, add in zip(bands, (100.0, 0.0), strict=True):
            assert (band.min(), band.max()) == pytest.approx((axis + add - 3.29, axis + 2.0 + add + 3.29))
    axes = Figure().add_subplot()
    scoring._dive_panel(axes, each, ahead, "")
    assert lines(axes)["measured"][1].tolist() == [10.0, 19.0, 9.0, 18.0]
    own, bare, *_, last = plain(scoring._table(each).rows)
    assert last[:4] == ["the last leg", "30 m", "60 %", "-5.00"]  # one step ahead
    assert (own[1], own[3], own[4]) == ("12 m", "-4.00", "9 m")
    assert [words.partition(" % ")[0] for words in own[5:]] == ["50", "75"]
    assert bare[:5] == ["the mission without its effects, one step ahead", "30 m", "60 %", "-5.00", "17 m"]
    assert scoring._against(-2.0, "leg") == "3.0 times the error that the last leg would give"
    assert (scoring._against(0.51, "leg"), scoring._against(-0.4, "leg")) == (
        "half better than the last leg would",
        "40 % worse than the last leg would",
    )


def test_what_an_extended_mission_leaves_open_is_told() -> None:
    learned = {
        "compass-bias": {"probability": 0.7},
        "fix-error": {"probability": 0.04},
        "speed-scale": {"probability": 0.96},
    }
    assert campaign._doubts(learned) == ["Still in doubt: compass bias 70.0 %."]
    assert campaign._doubts({}) == []
