"""Navigation logs end to end: what is hidden is found, what is not there is not."""

import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
import yaml
from scipy.stats import multivariate_normal

import missionplan
from missionplan import diagnose
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.legs.designs import with_further_legs
from missionplan.diagnosis.legs.kind import transit_model
from missionplan.diagnosis.pipeline import run_pipeline, verdict_of
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.phases.hooks import velocity_error
from missionplan.report.diagnosis.page import answer
from missionplan.report.render import render_report
from missionplan.results import to_json
from missionplan.results.learned.evidence import Readings
from tests.fixtures import TRANSIT, make_legs
from tests.learned import held, moments

KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def model(folder, mission, table):
    return transit_model(read_transit(folder(KIND, table), mission), mission, seed=1)


def test_columns_are_the_effects_own_hooks(folder, transit_mission, legs):
    bound = model(folder, transit_mission, legs())
    columns = bound.columns(np.zeros(len(bound.coordinates)))
    at = [coordinate.effect for coordinate in bound.coordinates].index("speed-scale")
    expected = velocity_error((CATALOGUE["speed-scale"].make({"fraction": 1.0}),), bound.leg)
    np.testing.assert_allclose(columns[:, :, at], expected, rtol=1e-9)


def test_a_scale_of_the_speed_acts_on_the_course_that_is_made(folder, transit_mission, legs):
    bound = model(folder, transit_mission, legs())
    names, about = [coordinate.effect for coordinate in bound.coordinates], np.zeros(len(bound.coordinates))
    about[names.index("compass-bias")] = 0.3
    east, north = bound.leg.speed * bound.leg.along
    made = [np.cos(0.3) * east + np.sin(0.3) * north, np.cos(0.3) * north - np.sin(0.3) * east]
    np.testing.assert_allclose(bound.columns(about)[:, :, names.index("speed-scale")], made, rtol=1e-9)


def test_noise_of_independent_legs_is_the_contracts(folder, transit_mission, legs):
    bound = model(folder, transit_mission, legs())
    noise = bound.noise({("", "sigma_v"): 0.03, ("", "fix_sd"): 5.0})
    np.testing.assert_allclose(noise[0], np.diag(0.03**2 + 2.0 * 25.0 / bound.data.under_way**2))


def test_legs_that_share_a_fix_share_its_error(folder, transit_mission, legs):
    table = legs()
    table.loc[1:, ["x_start_m", "y_start_m"]] = table[["x_end_m", "y_end_m"]].to_numpy()[:-1]
    bound = model(folder, transit_mission, table)
    noise = bound.noise({("", "sigma_v"): 0.03, ("", "fix_sd"): 5.0})
    duration = bound.data.under_way
    assert noise.shape == (2, 48, 48)
    np.testing.assert_allclose(noise[0, 0, 1], -25.0 / (duration[0] * duration[1]))


def test_a_poor_fix_counts_less_and_so_does_the_leg_that_it_begins(folder, transit_mission, legs):
    table = legs().assign(fix_sd_m=5.0)
    table.loc[1:, ["x_start_m", "y_start_m"]] = table[["x_end_m", "y_end_m"]].to_numpy()[:-1]
    table.loc[3, "fix_sd_m"] = 50.0
    bound = model(folder, transit_mission, table)
    noise = bound.noise({("", "sigma_v"): 0.03, ("", "fix_sd"): 5.0})[0]
    duration = bound.data.under_way
    expected = np.array([50.0, 5.0**2 + 50.0**2, 50.0**2 + 5.0**2, 50.0])
    np.testing.assert_allclose(np.diag(noise)[2:6] - 0.03**2, expected / duration[2:6] ** 2)
    np.testing.assert_allclose(noise[3, 4], -(50.0**2) / (duration[3] * duration[4]))
    further = with_further_legs(bound.data, 0)
    assert len(further.leg_fix_sd) == further.n > bound.data.n


def test_persistence_is_the_effects_own_covariance(folder, transit_mission, legs):
    bound = model(folder, transit_mission, legs())
    values = {("", "sigma_v"): 0.03, ("", "fix_sd"): 5.0}
    with_it = bound.noise({**values, ("persistent-error", "sigma"): 0.1, ("persistent-error", "time"): 3000.0})
    begin, under_way = bound.data.t_start, bound.data.under_way
    apart = begin[5] - (begin + under_way)[2]
    first, second = -np.expm1(-under_way[[2, 5]] / 3000.0) / (under_way[[2, 5]] / 3000.0)  # means of e^(-t/3000 s)
    assert with_it[0, 2, 5] == pytest.approx(0.01 * first * second * np.exp(-apart / 3000.0), rel=1e-6)


def pairs(legs):
    """Places of both components of legs where they stand leg by leg."""
    return np.stack([2 * legs, 2 * legs + 1], axis=1).ravel()


@pytest.mark.parametrize("rows", [slice(None), np.array([0, 1, 2, 9, 10, 11, 30, 47])], ids=["all legs", "some legs"])
@pytest.mark.parametrize("causes", [(), ("persistent-error",), ("inertial-current", "random-walk")])
def test_marginal_is_the_density_of_the_total_covariance(folder, transit_mission, legs, causes, rows):
    """The banded likelihood is the density under the dense covariance that predictions use."""
    table = legs()
    table.loc[1:, ["x_start_m", "y_start_m"]] = table[["x_end_m", "y_end_m"]].to_numpy()[:-1]
    bound = model(folder, transit_mission, table)
    fit = bound.fit(causes)
    linear, places = fit.state.linear, pairs(np.arange(bound.data.n)[rows])
    total = bound.error_covariance(fit, linear).dense()[np.ix_(places, places)]
    expected = multivariate_normal(np.zeros(len(places)), total).logpdf(linear.y[:, rows].T.ravel())
    found = bound.marginal(fit.state.hyperparameters, fit.state.posterior.mode, linear, rows)
    assert found.log_density == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("causes", [("mean-current",), ("persistent-error", "compass-bias"), ("random-walk",)])
def test_legs_are_predicted_by_the_conditional_normal_law(folder, transit_mission, legs, causes):
    """Rasmussen & Williams (2006), Eq. A.6, with the covariance written out; neighbours share a fix."""
    table = legs()
    table.loc[1:, ["x_start_m", "y_start_m"]] = table[["x_end_m", "y_end_m"]].to_numpy()[:-1]
    bound = model(folder, transit_mission, table)
    fit, n = bound.fit(causes), bound.data.n
    seen, wanted = np.setdiff1d(np.arange(5, n - 3), np.arange(20, 25)), np.arange(20, 25)
    total, y = bound.error_covariance(fit, fit.state.linear).dense(), fit.state.linear.y
    given, new = pairs(seen), pairs(wanted)
    weights = np.linalg.solve(total[np.ix_(given, given)], total[np.ix_(given, new)]).T
    mean, covariance = bound.predicted(fit, seen, wanted)
    expected = (weights @ y.T.ravel()[given]).reshape(-1, 2).T + (bound.y - y)[:, wanted]
    np.testing.assert_allclose(mean, expected, atol=1e-9)
    np.testing.assert_allclose(covariance, total[np.ix_(new, new)] - weights @ total[np.ix_(given, new)], atol=1e-9)


def test_a_cause_is_as_unsure_as_the_spike_says(folder, transit_mission, legs):
    """However long the record: a compass that is off by 5° today was never known better than its spike."""
    turned = 1.2 * np.radians(5.0)
    table = legs(200, error=lambda t, heading: turned * np.stack([np.cos(heading), -np.sin(heading)]))
    found = model(folder, transit_mission, table).fit(("compass-bias",)).estimates[0]
    spike = CATALOGUE["compass-bias"].parameters["angle"].spike
    assert spike < found.sd < 2.0 * spike


def test_a_shear_is_no_stronger_than_currents_are(folder, transit_mission, legs):
    """Over an area a hundred times as large the same gradient would be a hundred times the current."""
    near, table = legs(), legs()
    places = ["x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
    table[places] *= 100.0
    slabs = [
        [c.slab for c in model(folder, transit_mission, each).coordinates if c.effect == "current-shear"]
        for each in (near, table)
    ]
    np.testing.assert_allclose(np.array(slabs[1]) * 100.0, slabs[0])


def test_an_inertial_current_need_not_keep_its_phase(folder, transit_mission, legs):
    """Two per cent above the inertial frequency for ten days: nothing else is needed to explain it."""
    slower = 8.0
    omega = slower * 1.02 * 2.0 * 7.2921e-5 * np.sin(np.radians(37.0))

    def swirl(t, heading):
        return 0.08 * np.stack([np.cos(omega * t), -np.sin(omega * t)])

    table = legs(120, error=swirl)
    times_and_places = ["t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
    table[times_and_places] *= slower
    bound = model(folder, transit_mission, table)
    alone = bound.fit(("inertial-current",))
    with_more = bound.fit(("inertial-current", "persistent-error"), (alone,))
    assert alone.log_evidence > bound.fit(()).log_evidence + 50.0
    assert with_more.log_evidence < alone.log_evidence


@pytest.mark.slow
def test_metres_lost_on_every_leg_are_no_speed_scale(folder, transit_mission, legs):
    """A vehicle that gathers way slowly loses most, of a leg's length, on short legs."""
    table = legs(96, sigma=0.02)
    through = table[["x_dr_m", "y_dr_m"]].to_numpy() - table[["x_start_m", "y_start_m"]].to_numpy()
    lost = np.cumsum(70.0 * through / np.linalg.norm(through, axis=1)[:, None], axis=0)
    table[["x_end_m", "y_end_m"]] -= lost
    for place in (["x_start_m", "y_start_m"], ["x_dr_m", "y_dr_m"]):  # the next leg begins where this one ended
        table[place] -= np.vstack([np.zeros(2), lost[:-1]])
    found = run_pipeline(model(folder, transit_mission, table))
    assert found.best.causes == ("response",)
    assert verdict_of(found.selection) == "unexplained"
    (lost_each,) = found.best.estimates
    assert (lost_each.name, lost_each.unit) == ("ahead_each_leg", "m")
    assert lost_each.low < -70.0 < lost_each.high


def test_what_a_record_cannot_show_is_said(folder, mission, transit_mission, legs):
    nowhere = mission({key: value for key, value in transit_mission.raw.items() if key != "site"})
    bound = model(folder, nowhere, legs(20))
    assert set(bound.untestable) == {
        "inertial-current",
        "surface-drift",
        "sideslip",
        "speed-loss",
        "heading-by-depth",
    }


@pytest.fixture
def quick(folder, transit_mission):
    return lambda table: diagnose(transit_mission, folder(KIND, table), plan=False)


def test_effect_free_legs_are_adequate(quick, legs):
    found = quick(legs())
    assert found.verdict == "adequate"
    assert found.causes == ()
    assert () in found.credible_set
    assert found.none_of_these < 0.05


@pytest.mark.usefixtures("among_few")
def test_what_is_likely_to_have_no_name_is_told_with_its_probability_and_what_it_is_like(quick, legs):
    found = quick(legs())
    like = Readings(responses=(("time", "a velocity ahead that changes with time", 0.7),))
    likely = replace(found, verdict="unexplained", none_of_these=0.73, readings=like)
    words = "Something is left (with a probability of 73.0 %) that no cause of the catalogue explains: it looks like "
    assert answer(likely).startswith(f"{words}a velocity ahead that changes with time. ")
    unlike = replace(likely, readings=Readings())
    assert answer(unlike).startswith(f"{words.partition(':')[0]}. ")


@pytest.mark.slow
def test_calibration_is_no_cause(quick, legs):
    found = quick(legs(sigma=0.045))
    assert found.verdict == "adequate"
    assert found.calibration["sigma_v_m_s"] == pytest.approx(0.045, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cause", "error"),
    [
        ("speed-scale", lambda t, heading: 0.07 * 1.2 * np.stack([np.sin(heading), np.cos(heading)])),
        ("compass-bias", lambda t, heading: 1.2 * np.radians(5.0) * np.stack([np.cos(heading), -np.sin(heading)])),
        ("tidal-current", lambda t, heading: np.stack([0.1 * np.cos(t * 1.405e-4), 0.08 * np.sin(t * 1.405e-4)])),
    ],
)
def test_a_hidden_cause_is_found(quick, legs, cause, error):
    found = quick(legs(error=error))
    assert found.causes == (cause,)
    assert found.best.held_out.log_score_gain > 0.0
    assert found.best.share_explained > 0.3


@pytest.fixture(scope="module")
def in_a_current(tmp_path_factory, causes):
    """The diagnosis of legs in a current that the mission does not have."""
    place = tmp_path_factory.mktemp("legs")
    (place / "dataset.yaml").write_text(yaml.safe_dump({"file": "rows.csv", **KIND}))
    table = make_legs(error=lambda t, heading: np.array([[0.08], [-0.05]]) + 0.0 * t)
    table.to_csv(place / "rows.csv", index=False)
    with causes():
        return diagnose(Mission.from_data(TRANSIT), place, plan=False)


def test_parameters_and_extended_mission(in_a_current):
    found = in_a_current
    assert found.causes == ("mean-current",)
    assert found.best.held_out.log_score_gain > 0.0
    assert found.best.share_explained > 0.3
    east, north = found.best.parameters
    assert (east.name, north.name, east.unit) == ("east", "north", "m/s")
    assert abs(east.value - 0.08) < 3.0 * east.sd
    assert held(found.extended) == ("mean-current",)
    mean, sd = moments(found.extended, "mean-current", "east")
    assert mean == pytest.approx(east.value, rel=1e-3)
    assert sd == pytest.approx(east.sd, rel=1e-3)


@pytest.mark.slow
def test_a_diagnosis_of_the_extended_mission_finds_nothing_more(folder, transit_mission, legs):
    place = folder(KIND, legs(error=lambda t, heading: np.array([[0.08], [-0.05]]) + 0.0 * t))
    first = diagnose(transit_mission, place, plan=False)
    second = diagnose(Mission.from_data(first.extended), place, plan=False)
    assert second.verdict == "adequate"


@pytest.mark.slow
def test_the_result_is_deterministic(quick, legs):
    table = legs(30)
    assert quick(table).diagnosis() == quick(table).diagnosis()


def test_the_summary_is_as_its_schema_says_and_nothing_in_it_is_left_open(in_a_current):
    summary, schema = json.loads(to_json(in_a_current.summary())), missionplan.schema("summary")
    assert [error.message for error in jsonschema.Draft7Validator(schema).iter_errors(summary)] == []
    for place in (summary, summary["ranking"][0], summary["ranking"][0]["parameters"][0], summary["decision"]):
        place["mistyped"] = 1
        assert list(jsonschema.Draft7Validator(schema).iter_errors(summary))
        del place["mistyped"]


def test_diagnosis_json_has_the_contracts_keys(in_a_current):
    found = in_a_current
    content = found.diagnosis()
    assert {
        "verdict",
        "causes",
        "credible_set",
        "ranking",
        "remainder",
        "outlying_groups",
        "indistinguishable",
        "next_measurements",
        "decision",
        "extended_mission",
    } <= set(content)
    first = content["ranking"][0]
    assert {"causes", "log_bayes_factor", "posterior", "parameters", "held_out", "share_explained"} <= set(first)
    assert set(first["parameters"][0]) == {"effect", "name", "value", "sd", "low", "high", "unit"}
    assert set(first["held_out"]) == {
        "log_score_gain",
        "paired_se",
        "groups_improved",
        "groups",
        "rmse_base",
        "rmse_extended",
        "coverage_90_base",
        "coverage_90_extended",
    }
    assert set(found.files()) == {"diagnosis.json", "residuals.csv", "ranking.csv", "mission.yaml", "posterior.npz"}
    assert {"data", "ranking", "residuals", "places", "autocorrelation", "held-out"} <= set(
        render_report(found).figures
    )


def record(path, hours):
    """A record of a current of 5 cm/s to the east at 1, 5 and 20 m, so many hours long."""
    rows = ["t_s,depth_m,east_m_s,north_m_s"]
    rows += [f"{3600 * hour},{depth},0.05,0.0" for hour in (0, hours) for depth in (1, 5, 20)]
    path.write_text("\n".join(rows) + "\n")
    return str(path)


def test_a_log_beyond_the_record_of_the_current_is_an_error(folder, mission, transit_mission, legs, tmp_path):
    raw = transit_mission.raw
    data, site = folder(KIND, legs(12)), raw["site"]
    for hours, outside, refused in ((1000, "error", False), (2, "error", True), (2, "hold", False)):
        current = {"file": record(tmp_path / "current.csv", hours), "outside": outside}
        made = mission({**raw, "site": {**site, "current": current}})
        if refused:
            with pytest.raises(InputError, match=r"site\.current: \d+ of the 12 legs .* from 0\.0 to .* h after"):
                diagnose(made, data, plan=False)
        else:
            expected_east = transit_model(read_transit(data, made), made, seed=1).base[0]
            assert expected_east == pytest.approx(0.05 * np.ones(12), rel=0.3)


def test_a_log_from_elsewhere_is_an_error(folder, transit_mission, legs):
    table = legs()
    names = {"start": "start", "dr": "dr_end", "end": "end"}
    for key, name in names.items():
        table[f"lat_{name}"] = 47.0 + table[f"y_{key}_m"] / 111_000.0
        table[f"lon_{name}"] = -76.0 + table[f"x_{key}_m"] / 76_000.0
    planar = [f"{axis}_{key}_m" for axis in "xy" for key in names]
    with pytest.raises(InputError, match=r"lat_start: 11\d\d km from the mission's site.origin"):
        diagnose(transit_mission, folder(KIND, table.drop(columns=planar)), plan=False)
