"""Failure rates from a fleet's counts, against closed forms, quadrature and scipy's distributions."""

from pathlib import Path

import numpy as np
import pytest
import scipy
import yaml

import missionplan
from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.montecarlo.reliability import chance_of_counts, counts_of_rate, rate_quantile

HEAD = "per,failures,exposure,vehicle\n"


def fleet(root: Path, *rows: str, name: str = "reliability.csv") -> Path:
    path = root / "fleet" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(HEAD + "\n".join(rows) + "\n")
    return root / "fleet"


def mission(root: Path, reliability: object) -> Path:
    vehicle = {"hull": {"length": "1 m", "diameter": "0.1 m"}, "reliability": reliability}
    navigation = {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s", "fix_error": "3 m"}
    transit = {"name": "out", "from": ["0 m", "0 m"], "to": ["1 km", "0 m"], "speed": "1 m/s", "d_max": "1 km"}
    (root / "vehicle.yaml").write_text(yaml.safe_dump(vehicle))
    written = {
        "vehicle": "vehicle.yaml",
        "navigation": navigation,
        "phases": [{"transit": {**transit, "arrival_radius": "20 m"}}],
    }
    (root / "mission.yaml").write_text(yaml.safe_dump(written))
    return root / "mission.yaml"


@pytest.mark.parametrize(("seen", "exposure"), [(0, 50.0), (2, 300.0), (9, 40.0)])
def test_the_posterior_is_prior_times_poisson_by_quadrature(seen: int, exposure: float) -> None:
    before = (3.0, 1200.0)
    rates = np.linspace(1e-9, 0.3, 400_001)
    prior = scipy.stats.gamma(before[0] + 0.5, scale=1.0 / before[1])
    weight = prior.pdf(rates) * scipy.stats.poisson.pmf(seen, rates * exposure)
    cumulative = scipy.integrate.cumulative_trapezoid(weight, rates, initial=0.0)
    for share in (0.05, 0.5, 0.95):
        exact = np.interp(share, cumulative / cumulative[-1], rates)
        assert rate_quantile(before[0] + seen, before[1] + exposure, share) == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("seen", [0, 1, 4, 30])
def test_counts_as_far_out_are_negative_binomial(seen: int) -> None:
    law = scipy.stats.nbinom(3.5, 1200.0 / (1200.0 + 400.0))
    exact = min(law.cdf(seen), law.sf(seen - 1))
    assert chance_of_counts(seen, 400.0, 3.0, 1200.0) == pytest.approx(exact)


def test_a_distribution_of_a_rate_is_worth_the_gamma_of_its_mean_and_variance() -> None:
    failures, exposure = counts_of_rate(2e-3, 5e-4)
    law = scipy.stats.gamma(failures + 0.5, scale=1.0 / exposure)
    assert (law.mean(), law.std()) == pytest.approx((2e-3, 5e-4))
    assert counts_of_rate(2e-3, 1.0) == pytest.approx((0.0, 250.0))


def test_counts_update_the_mission_s_and_the_file_is_planned_with(tmp_path: Path) -> None:
    given = [
        {"per": "hour", "failures": 3, "exposure": 1200, "source": "log book"},
        {"per": "hour", "rate": "1e-5 1/h", "leaves": "lost"},
    ]
    plan = mission(tmp_path, given)
    root = fleet(tmp_path, "hour,1,400,A", "hour,0,100,B", "surfacing,2,90,A", "dive,0,0,A")
    fleet(tmp_path, "hour,1,400,A", "hour,0,100,B", "surfacing,2,90,A", "dive,0,0,A", name="copy/reliability.csv")
    found = missionplan.history(root, mission=plan)
    assert [(rate.per, rate.failures, rate.exposure) for rate in found.rates] == [
        ("hour", 1.0, 500.0),
        ("surfacing", 2.0, 90.0),
    ]
    assert found.rates[0].rate == pytest.approx(4.5 / 1700.0)
    assert any("copy" in notice for notice in found.provenance.notices)
    (tmp_path / "reliability.yaml").write_text(str(found.files()["reliability.yaml"]))
    again = mission(tmp_path, "reliability.yaml")
    vehicle = load(again).vehicle
    assert vehicle is not None
    told = {(each.per, each.leaves): (each.failures, each.exposure) for each in vehicle.reliability}
    assert told == {("hour", None): (4.0, 1700.0), ("hour", "lost"): (None, None), ("surfacing", None): (2.0, 90.0)}
    assert missionplan.history(root, mission=again).rates == ()
    grown = fleet(tmp_path, "hour,1,400,A", "hour,0,100,B", "surfacing,2,90,A", "dive,0,0,A", "hour,2,50,C")
    (root / "copy" / "reliability.csv").unlink()
    (fresh,) = missionplan.history(grown, mission=again).rates
    assert (fresh.failures, fresh.exposure, fresh.prior_failures, fresh.prior_exposure) == (2.0, 50.0, 4.0, 1700.0)


def test_a_rate_with_its_error_is_updated_in_hours_and_kilometres_and_a_fixed_one_replaced(tmp_path: Path) -> None:
    """A gamma law of mean m and standard deviation s is worth (m/s)² - 1/2 failures in m/s² of exposure."""
    given = [
        {"per": "hour", "rate": {"mean": "2e-3 1/h", "sd": "5e-4 1/h"}, "source": "Büro"},
        {"per": "km", "rate": "0.01 1/km", "leaves": "lost"},
    ]
    found = missionplan.history(fleet(tmp_path, "hour,3,400,A", "km,1,50,B"), mission=mission(tmp_path, given))
    hour, km = found.rates
    assert (hour.per, hour.leaves, hour.prior, km.per, km.leaves, km.prior) == (
        "hour",
        "",
        "distribution",
        "km",
        "",
        "none",
    )
    assert (hour.prior_failures, hour.prior_exposure) == pytest.approx((15.5, 8000.0), rel=1e-3)
    law = scipy.stats.gamma(19.0, scale=1.0 / 8400.0)
    assert (hour.rate, hour.low, hour.high) == pytest.approx((law.mean(), *law.ppf([0.05, 0.95])), rel=1e-3)
    assert hour.surprise == pytest.approx(chance_of_counts(3, 400.0, 15.5, 8000.0), rel=1e-2)
    law = scipy.stats.gamma(1.5, scale=1.0 / 50.0)
    assert (km.rate, km.low, km.high, km.surprise) == pytest.approx((law.mean(), *law.ppf([0.05, 0.95]), 1.0))
    assert "Büro" in found.rates_file
    written = yaml.safe_load(found.rates_file)
    assert [each["source"] for each in written if "learned_from" in each] == [
        "Büro; 3 failures in 400 h of the fleet",
        "1 failure in 50 km of the fleet",
    ]
    assert [(each["per"], each.get("leaves")) for each in written] == [("km", "lost"), ("hour", None), ("km", None)]
    assert (len(hour.learned_from), len(km.learned_from)) == (1, 1)


def test_every_wrong_cell_is_named_with_its_line(tmp_path: Path) -> None:
    root = fleet(tmp_path, "hours,1,400,A", "hour,-1,400,A", "hour,x,1,A", "hour,1,0,B")
    with pytest.raises(InputError) as caught:
        missionplan.history(root)
    assert [problem.line for problem in caught.value.problems] == [2, 3, 4, 5]
    assert "did you mean hour" in str(caught.value)


def test_a_folder_without_anything_to_learn_from_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no reliability\.csv"):
        missionplan.history(tmp_path)


# medians of the published survivals: Brito, Smeed & Griffiths 2014; Rudnick, Davis & Sherman 2016
@pytest.mark.parametrize(
    ("kind", "survival", "days"), [("deep-glider", 0.50, 90.0), ("shallow-glider", 0.59, 30.0), ("spray", 0.83, 100.0)]
)
def test_starter_values_of_a_class_hold_its_published_survival(
    tmp_path: Path, kind: str, survival: float, days: float
) -> None:
    vehicle = load(mission(tmp_path, kind)).vehicle
    assert vehicle is not None
    hazards = vehicle.reliability
    total = sum(float(hazard.rate.median) for hazard in hazards)  # type: ignore[union-attr]
    assert np.exp(-total * days * 86400.0) == pytest.approx(survival, abs=0.005)
    assert all(hazard.source for hazard in hazards)


def test_a_class_that_is_not_known_is_named_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="did you mean deep-glider"):
        load(mission(tmp_path, "deepglider"))
