"""The generators themselves: physics, determinism, columns, and that what they hide can be seen."""

import ast
import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from . import dives, transits
from .cases import CYCLE, KINDS, SCENARIOS, cases, draw_case, plan
from .dive import Dive, Twist, sink
from .dive_effects import CATALOGUE as DIVE_CATALOGUE
from .dive_outside import OUTSIDE as DIVE_OUTSIDE
from .dive_outside import STUDIED as STUDIED_DIVES
from .drag import Craft, friction, spheroid_share
from .leg_effects import CATALOGUE as LEG_CATALOGUE
from .leg_effects import HOUR, PERIODS
from .leg_outside import OUTSIDE as LEG_OUTSIDE
from .leg_outside import STUDIED

HERE = Path(__file__).parent
ALLOWED = {"numpy", "scipy", "yaml", "pytest"}
PAPER = Craft(
    length=1.1176,
    diameter=0.12065,
    form_factor="briggs",
    sail=(0.1016, 0.1016, 0.01524),
    appendage_factor=1.25,
    mass=10.2,
    net_buoyancy=0.0,
    anchor_diameter=0.12065,
    anchor_drag_coefficient=0.2,
    anchor_flooded_mass=2.79,
    density=1026.02,
    viscosity=1.1892e-6,
)


def test_imports_nothing_from_the_package_under_test():
    import sys

    for path in HERE.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module or ""]
            roots = {name.split(".")[0] for name in names}
            assert roots <= ALLOWED | set(sys.stdlib_module_names), f"{path.name} imports {roots}"


class Coefficient(Craft):
    """A craft with constant drag coefficients and no net buoyancy."""

    def vehicle_drag(self, speed):
        return 3.0 * speed * abs(speed)


def test_drag_of_the_paper():
    # issue's check values at 1.62 m/s; Lamb's shares from the notes
    assert PAPER.vehicle_drag(1.62) == pytest.approx(8.619, abs=2e-3)
    assert PAPER.anchor_drag(1.62) == pytest.approx(3.078, abs=2e-3)
    assert PAPER.terminal_speed(11.697) == pytest.approx(1.62, abs=2e-4)
    assert [spheroid_share(x) for x in (2.0, 3.0, 9.26)] == pytest.approx([0.210, 0.122, 0.0233], abs=6e-4)
    assert friction(10.0) == friction(1e4)


def test_dive_reaches_the_speed_of_force_balance():
    track = sink(PAPER, Dive(11.7, 5.0, 60.0), (), 45.0)
    inside = (track.t > track.t_touchdown - 4.0) & (track.t < track.t_touchdown)
    speed = np.gradient(track.depth[inside], track.t[inside])
    assert speed == pytest.approx(PAPER.terminal_speed(11.7), rel=1e-3)


def test_constant_drag_falls_like_tanh():
    """From the speed v₁ after the snatch: z = v_t τ ln(cosh(s + a)/cosh a), tanh a = v₁/v_t."""
    craft = Coefficient(**vars(PAPER))
    weight, line = 12.0, 5.0
    k_anchor = craft.anchor_drag(1.0)
    v_alone = math.sqrt(weight / k_anchor)
    tau_alone = craft.anchor_mass / math.sqrt(weight * k_anchor)
    t_taut = tau_alone * math.acosh(math.exp(line / (v_alone * tau_alone)))
    joint = craft.anchor_mass + craft.vehicle_mass
    start = craft.anchor_mass * v_alone * math.tanh(t_taut / tau_alone) / joint
    k = k_anchor + 3.0
    v_t, tau = math.sqrt(weight / k), joint / math.sqrt(weight * k)
    track = sink(craft, Dive(weight, line, 40.0), (), 60.0)
    assert track.t_taut == pytest.approx(t_taut, abs=1e-6)
    falling = (track.t >= t_taut) & (track.t < track.t_touchdown)
    a = math.atanh(start / v_t)
    expected = v_t * tau * np.log(np.cosh((track.t[falling] - t_taut) / tau + a) / math.cosh(a))
    np.testing.assert_allclose(track.depth[falling], expected, atol=1e-5)


def test_vehicle_coasts_by_the_closed_form_and_rises_to_the_line():
    craft = Coefficient(**{**vars(PAPER), "net_buoyancy": 0.9})
    dive = Dive(12.0, 6.0, 40.0)
    track = sink(craft, dive, (), 90.0)
    near = (track.t > track.t_touchdown - 0.5) & (track.t < track.t_touchdown)
    speed = np.polyfit(track.t[near], track.depth[near], 1)[0]
    coast = craft.vehicle_mass / 6.0 * math.log(1.0 + 3.0 * speed**2 / 0.9)
    assert track.depth.max() == pytest.approx(34.0 + coast, abs=1e-3)
    assert track.depth[-1] == pytest.approx(34.0)


@pytest.mark.parametrize(
    ("twist", "sign"),
    [
        (Twist(lone_drag=1.5, drag=lambda t, u, z, n: 1.5), -1),
        (Twist(weight=lambda t, z: 0.8), -1),
        (Twist(lift=lambda z: 2.0), -1),
        (Twist(water=lambda t, z: 0.1), 1),
        (Twist(mass=1.5), -1),
        (Twist(hold=(0.5, 2.0)), -1),
        (Twist(line=lambda n: 0.5), 1),
        (Twist(stretch=lambda line: 0.05), -1),
    ],
)
def test_twists_act_in_the_direction_they_should(twist, sign):
    plain = sink(PAPER, Dive(11.7, 5.0, 40.0), (), 60.0)
    other = sink(PAPER, Dive(11.7, 5.0, 40.0), (twist,), 60.0)
    late = int(0.95 * min(plain.t_touchdown, other.t_touchdown) / 0.02)
    assert sign * (other.depth[late] - plain.depth[late]) > 0.1


def test_legs_close():
    """Steering + errors + drift are the displacement, and a leg starts where the last one ended."""
    survey = transits.draw_survey(np.random.default_rng(3), "single", ("mean-current",))
    bend, _ = LEG_CATALOGUE["mean-current"].build(0.1, np.random.default_rng(1), survey.field)
    log = transits.sail(survey, (bend,), np.random.default_rng(2))
    np.testing.assert_allclose(log.fix_end, log.reckoned + log.signal + log.noise, atol=1e-6)
    np.testing.assert_allclose(log.true_end[:-1], log.true_start[1:], atol=1e-9)
    assert np.all(log.t_end > log.t_start)
    assert np.all(log.t_start[1:] > log.t_end[:-1])
    np.testing.assert_allclose(transits.displacement(survey, log, (bend,)), log.signal, atol=1e-6)


def test_errors_without_effect_have_the_covariance_assumed():
    chi_square, count = 0.0, 0
    for seed in range(12):
        survey = transits.draw_survey(np.random.default_rng(seed), "single", ())
        log = transits.sail(survey, (), np.random.default_rng(seed))
        z = transits.whiten(survey, log, log.noise)
        chi_square += float(z @ z)
        count += z.size
    assert chi_square / count == pytest.approx(1.0, abs=0.05)


def test_inertial_current_turns_clockwise_north_of_the_equator():
    for latitude, sign in ((45.0, -1.0), (-45.0, 1.0)):
        survey = transits.draw_survey(np.random.default_rng(5), "single", ("inertial-current",))
        field = transits.replace(survey, latitude=latitude).field
        bend, _ = LEG_CATALOGUE["inertial-current"].build(0.1, np.random.default_rng(8), field)
        t = 0.8 * field.span
        (e0, n0), (e1, n1) = bend.current(t, np.zeros(2)), bend.current(t + 600.0, np.zeros(2))
        turn = np.angle(complex(e1, n1) / complex(e0, n0))
        inertial = sign * 4.0 * np.pi / 86164.0905 * np.sin(np.radians(45.0)) * 600.0
        assert turn == pytest.approx(inertial, rel=0.025)


def _outside_leg(name: str, size: float, seed: int = 4):
    field = transits.draw_survey(np.random.default_rng(5), "outside", (name,)).field
    return LEG_OUTSIDE[name].build(size, np.random.default_rng(seed), field)[0], field


def test_gyro_creep_is_the_integral_of_a_turning_course():
    """Halfway off to the side at first order, ½ U ω T², and by quadrature for a large angle."""
    rate = np.radians(12.0) / HOUR
    bend, _ = _outside_leg("gyro-creep", rate)
    first = bend.push(0.0, 1.2, 600.0)
    assert abs(first[0]) == pytest.approx(0.5 * 1.2 * rate * 600.0**2, rel=1e-3)
    heading, speed, time = 2.0, 0.8, 2.5 * HOUR
    course = heading + np.sign(first[0]) * rate * (np.arange(20000) + 0.5) * time / 20000
    made_good = speed * time * np.array([np.sin(course).mean(), np.cos(course).mean()])
    reckoned = speed * time * np.array([np.sin(heading), np.cos(heading)])
    np.testing.assert_allclose(bend.push(heading, speed, time), made_good - reckoned, atol=1e-3)


def test_weed_slows_once_and_for_a_while():
    bend, field = _outside_leg("weed", 0.2)
    pace = np.array([bend.pace(t) for t in np.linspace(0.0, 1.3 * field.span, 2000)])
    assert set(pace) == {1.0, 0.8}
    assert np.count_nonzero(np.diff(pace)) == 2
    assert 0.1 / 1.3 < np.mean(pace < 1.0) < 0.6 / 1.3 + 1e-3


def test_tidal_race_is_a_tide_and_only_near_one_place():
    bend, field = _outside_leg("tidal-race", 0.4)
    grid = 3.0 * field.extent * np.stack(np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 31)]), axis=-1).reshape(-1, 2)
    speed = np.array([np.hypot(*bend.current(3.0 * HOUR, place)) for place in grid])
    assert np.median(speed) < 0.05 * speed.max()
    place = grid[np.argmax(speed)]
    series = np.array([bend.current(t, place) for t in np.arange(0.0, 60.0 * PERIODS["M2"], HOUR)])
    assert np.abs(series.mean(axis=0)).max() < 0.02 * np.abs(series).max()
    assert np.abs(series).max() < 0.4 * 1.4


def test_line_drag_follows_the_line_of_the_dive():
    scenario = dives.Scenario(10.0, 1.2, 1.8, 15.0, 30.0, lines=(4.0, 12.0))
    twist, _ = DIVE_OUTSIDE["line-drag"].build(0.02, np.random.default_rng(0), scenario)
    assert [twist.drag(3.0, 1.0, 2.0, number) for number in (0, 1)] == pytest.approx([1.08, 1.24])


def test_motor_drives_down_until_it_is_stopped():
    """Deeper than the plain dive, and at the plain dive's speed long after."""
    scenario = dives.Scenario(11.7, 1.6, 1.6, 35.0, 30.0, lines=(5.0,))
    twist, _ = DIVE_OUTSIDE["motor-runs-on"].build(0.5, np.random.default_rng(0), scenario)
    plain, other = (sink(PAPER, Dive(11.7, 5.0, 60.0), twists, 45.0) for twists in ((), (twist,)))
    stopped = int((plain.t_taut + 10.0) / 0.02)
    assert twist.resist(2.0, 0.0) == pytest.approx(-0.5 * 11.7)
    assert 0.3 < other.depth[stopped] - plain.depth[stopped] < 5.0
    ahead = other.depth - plain.depth
    late = (plain.t > other.t_touchdown - 5.0) & (plain.t < other.t_touchdown)
    assert np.ptp(ahead[late]) < 0.02


def _outside_dive(name: str, size: float, seed: int = 0):
    scenario = dives.Scenario(11.7, 1.6, 2.0, 35.0, 30.0, lines=(5.0, 5.0, 8.0))
    return DIVE_OUTSIDE[name].build(size, np.random.default_rng(seed), scenario)[0]


@pytest.mark.parametrize("seed", range(4))
def test_foam_gives_way_for_good_below_its_yield(seed):
    lift = np.array([_outside_dive("foam-compression", 0.4, seed).lift(z) for z in np.linspace(0.0, 200.0, 50)])
    assert lift[0] == 0.0
    assert np.all(np.diff(lift) <= 0.0)
    assert -0.4 * 11.7 < lift[-1] < -0.3 * 11.7


def test_vehicle_that_became_heavy_stays_on_the_seafloor():
    twist = _outside_dive("foam-compression", 0.4)
    track = sink(PAPER, Dive(11.7, 5.0, 40.0), (twist,), 90.0)
    assert track.depth[-1] == pytest.approx(40.0)


def test_shear_layer_slows_within_it_and_slow_dives_more():
    twist = _outside_dive("shear-layer", 1.0)
    depth = np.linspace(0.0, 60.0, 600)
    slow, fast = (np.array([twist.drag(9.0, u, z, 0) for z in depth]) for u in (1.6, 2.0))
    assert slow.max() == pytest.approx(2.0)
    assert fast.max() == pytest.approx(1.0 + 0.8**2)
    assert slow[0] == 1.0
    assert slow[-1] == pytest.approx(1.0, abs=1e-3)


def test_plugged_port_reads_nothing_and_then_the_depth():
    twist = _outside_dive("plugged-port", 1.0)
    t = np.arange(0.0, 40.0, 0.02)
    first, second = (twist.reading(t, 1.5 * t, number) for number in (0, 1))
    assert np.count_nonzero(first == 0.0) != np.count_nonzero(second == 0.0)
    assert np.all(np.diff(first) >= 0.0)
    np.testing.assert_allclose(first[-500:], 1.5 * t[-500:], atol=1e-6)


def test_jammed_spool_moors_deeper_and_only_where_it_jams():
    twist = _outside_dive("jammed-spool", 0.3, seed=1)
    lines = np.array([5.0 * twist.line(number) for number in range(3)])
    assert 0.0 < np.count_nonzero(lines < 5.0) < 3
    for number, line in enumerate(lines):
        track = sink(PAPER, Dive(11.7, 5.0, 40.0, number=number), (twist,), 60.0)
        assert np.interp(track.t_touchdown, track.t, track.depth) == pytest.approx(40.0 - line, abs=1e-3)


def test_line_that_hardly_stretches_is_the_snatch():
    plain, other = (sink(PAPER, Dive(11.7, 5.0, 40.0), each, 40.0) for each in ((), (Twist(stretch=lambda n: 5e-4),)))
    inside = (plain.t > plain.t_taut + 1.0) & (plain.t < plain.t_touchdown - 1.0)
    np.testing.assert_allclose(other.depth[inside], plain.depth[inside], atol=0.05)


def test_elastic_line_is_stretched_by_the_drag_of_the_vehicle():
    """At touchdown the vehicle is the line and its stretch above the seafloor: Hooke's law at terminal speed."""
    track = sink(PAPER, Dive(11.7, 5.0, 60.0), (_outside_dive("elastic-line", 0.04),), 60.0)
    above = 60.0 - np.interp(track.t_touchdown, track.t, track.depth)
    give = _outside_dive("elastic-line", 0.04).stretch(5.0)
    assert above == pytest.approx(5.0 + give * PAPER.vehicle_drag(PAPER.terminal_speed(11.7)), abs=3e-3)


def test_studied_effects_are_some_of_those_outside():
    assert set(LEG_OUTSIDE) > STUDIED
    assert set(DIVE_OUTSIDE) > STUDIED_DIVES
    assert not set(LEG_OUTSIDE) & set(DIVE_OUTSIDE)  # one set of names serves both kinds
    assert not set(LEG_OUTSIDE) & set(LEG_CATALOGUE)
    assert not set(DIVE_OUTSIDE) & set(DIVE_CATALOGUE)


def test_degrees_keep_the_length_of_a_step():
    """Against the great circle of the local radius at 60° north, and across the date line."""
    latitude, longitude = transits.step_on_ellipsoid(60.0, 179.99, np.array([5000.0, 0.0]))
    parallel = math.radians((longitude - 179.99) % 360.0) * 6378137.0 * math.cos(math.radians(60.0))
    assert parallel / math.sqrt(1.0 - 6.69437999014e-3 * 0.75) == pytest.approx(5000.0, rel=1e-6)
    assert latitude == pytest.approx(60.0)
    back = transits.step_on_ellipsoid(*transits.step_on_ellipsoid(-35.0, 20.0, np.array([0.0, 4e3])), [0.0, -4e3])
    assert back == pytest.approx((-35.0, 20.0), abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "scenario"), [("descent", "control"), ("descent", "single"), ("transit", "single"), ("transit", "pair")]
)
def test_same_seed_same_case(kind, scenario):
    first, second = draw_case(11, kind, scenario), draw_case(11, kind, scenario)
    assert (first.header, first.rows, first.dataset, first.mission) == (
        second.header,
        second.rows,
        second.dataset,
        second.mission,
    )
    assert draw_case(12, kind, scenario).rows != first.rows


def test_plan_has_every_scenario_of_both_kinds():
    arguments = plan(40, 5)
    assert [seed for seed, _, _ in arguments] == list(range(5, 45))
    for kind in KINDS:
        drawn = [scenario for _, each, scenario in arguments if each == kind]
        assert sorted(drawn) == sorted(CYCLE)
        assert set(drawn) == set(SCENARIOS)
    with pytest.raises(ValueError, match="no cases"):
        draw_case(1, "descent", "calm")


@pytest.mark.parametrize("kind", KINDS)
def test_files_hold_the_case_and_not_the_truth(kind, tmp_path):
    case = next(cases(1, 3, kind))
    mission, data = case.write(tmp_path / "seen", tmp_path / "truth")
    truth = json.loads((tmp_path / "truth" / f"{case.name}.json").read_text())
    assert truth["truth"] == list(case.truth)
    dataset = yaml.safe_load((data / "dataset.yaml").read_text())
    assert dataset == case.dataset
    with (data / dataset["file"]).open(newline="") as file:
        header, *rows = csv.reader(file)
    assert (header, rows) == (case.header, case.rows)
    assert yaml.safe_load(mission.read_text()) == case.mission
    if kind == "descent":
        assert {row[0] for row in rows} == set(dataset["runs"])
        vehicle = case.mission["vehicle"]
        assert isinstance(vehicle, dict) or (mission.parent / vehicle).exists()
    seen = " ".join(path.read_text() for path in (tmp_path / "seen").rglob("*") if path.is_file())
    names = [*DIVE_CATALOGUE, *LEG_CATALOGUE, *DIVE_OUTSIDE, *LEG_OUTSIDE]
    assert not [name for name in names if "-" in name and name in seen]


@pytest.mark.parametrize("effect", sorted(DIVE_CATALOGUE))
def test_effect_moves_the_dives(effect):
    """Chi-square of with-effect against without, under the nuisances' covariance: nothing of the tool is used."""
    assert dives.draw(101, "single", effect).strength >= dives.STRONG


@pytest.mark.parametrize("effect", sorted(LEG_CATALOGUE))
def test_effect_moves_the_legs(effect):
    least = transits.STRONG_RANDOM if effect in transits.RANDOM else transits.STRONG
    assert transits.draw(101, "single", effect).strength >= least


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "effect"), [("descent", e) for e in DIVE_OUTSIDE] + [("transit", e) for e in LEG_OUTSIDE]
)
def test_outside_effects_are_outside(kind, effect):
    """The nearest single cause of the catalogue leaves clear misfit (checked where the case is drawn)."""
    assert draw_case(102, kind, "outside", effect).strength >= dives.STRONG


@pytest.mark.parametrize("form", ["x_start_m", "lat_start"])
def test_columns_give_back_the_errors_of_the_legs(form):
    """End fix minus dead-reckoned position, decoded from the text, against what the generator moved."""
    rng = np.random.default_rng(9)
    survey = transits.draw_survey(rng, "single", ("compass-bias",))
    log = transits.sail(survey, (), np.random.default_rng(4))
    header, rows = next(
        (header, rows)
        for header, rows, _ in (transits.columns(survey, log, rng, True) for _ in range(40))
        if form in header and "ok" not in header and len(rows) == log.heading.size
    )
    table = np.array(rows, dtype=float)
    error = table[:, [7, 8]] - table[:, [5, 6]]
    assert header[5:9] == (
        ["x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
        if form == "x_start_m"
        else ["lat_dr_end", "lon_dr_end", "lat_end", "lon_end"]
    )
    if form == "lat_start":
        phi = np.radians(table[:, 5])
        w = 1.0 - 6.69437999014e-3 * np.sin(phi) ** 2
        north = np.radians(error[:, 0]) * 6378137.0 * (1.0 - 6.69437999014e-3) / w**1.5
        error = np.column_stack([np.radians(error[:, 1]) * 6378137.0 / np.sqrt(w) * np.cos(phi), north])
    np.testing.assert_allclose(error, log.fix_end - log.reckoned, atol=0.3, rtol=3e-3)


def test_exact_ties_are_stated():
    case = draw_case(1, "descent", "tie")
    assert len({run["line_length"] for run in case.dataset["runs"].values()}) == 1
    assert case.accepts(["line-payout"])
    assert case.accepts(["clock-offset"])
    assert not case.accepts([])
    heading = draw_case(1, "transit", "tie")
    assert heading.accepts(["mean-current"])
