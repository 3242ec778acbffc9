"""Mission files: what is read, and every problem at once."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from missionplan import load
from missionplan.errors import InputError
from missionplan.mission.checks import notices
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.montecarlo.distributions import Normal, TruncatedNormal

MISSIONS = Path(__file__).parents[2] / "missions"

TRANSIT = """
name: short
navigation: {velocity_error: {sigma: 0.035 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: ingress, from: [0 m, 0 m], to: [4 nmi, 0 m], speed: 1.25 m/s, d_max: 4 nmi, arrival_radius: 50 m}
"""


def problems_of(tmp_path: Path, text: str) -> list[str]:
    path = tmp_path / "mission.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(path)
    return [str(problem).removeprefix(f"{path}:") for problem in caught.value.problems]


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_missions_are_valid(path: Path) -> None:
    assert load(path).name


def test_chesapeake_in_si() -> None:
    mission = load(MISSIONS / "chesapeake.yaml")
    ingress, moor, egress = mission.phases
    assert isinstance(ingress, TransitPhase)
    assert isinstance(moor, MoorPhase)
    assert isinstance(egress, TransitPhase)
    assert (ingress.name, moor.name, egress.name) == ("ingress", "moor", "egress")
    assert ingress.to == (1600.0, 0.0)
    assert moor.radius == pytest.approx(22.86)
    assert moor.release_time == TruncatedNormal(10.0, 3.0, 0.0)
    assert mission.vehicle is not None
    assert mission.vehicle.hull.length == pytest.approx(1.1176)
    assert mission.budget is not None
    assert mission.budget.capacity == pytest.approx(216000.0)
    assert mission.requirements[1].at_most == pytest.approx(22.86)
    assert mission.requirements[3].at_most == pytest.approx(162000.0)
    assert set(mission.uncertain()) == {
        "site.current[0].speed",
        "site.current[1].speed",
        "moor.release_time",
        "moor.galvanic_release",
    }
    assert mission.uncertain()["site.current[0].speed"] == Normal(
        pytest.approx(0.4 * 1852 / 3600), pytest.approx(0.1 * 1852 / 3600)
    )


def test_every_problem_is_reported_with_its_place(tmp_path: Path) -> None:
    found = problems_of(
        tmp_path,
        """vehicle: vehicles/none.yaml
navigation:
  velocity_eror: {sigma: 0.035 m/s}
  surfacing_time: 90
  fix_error: {mean: 3 m, sd: 1 s}
  drift_compensation: meen
phases:
  - transit: {from: [0 m, 0], to: [1 m, 0 m], speed: 1.25 mps2, d_max: -4 nmi, arival_radius: 50 m}
  - transitt: {}
  - moor: {radius: 75 kg, line_length: {low: 5 m, high: 2 m}, anchor_wet_weight: size}
sweep: {d_max: {from: 0.02, to: 1.0 m, points: 99.5, of: distance}, sigma: [0.015 m/s, 0.035]}
monte_carlo: {trials: -5, seed: x}
""",
    )
    places = [problem.split(": ")[0] + " " + problem.split(": ")[1] for problem in found]
    assert places == [
        "1 vehicle",
        "3 navigation.velocity_eror",
        "4 navigation.surfacing_time",
        "5 navigation.fix_error.sd",
        "6 navigation.drift_compensation",
        "8 phases[0].transit.from[1]",
        "8 phases[0].transit.speed",
        "8 phases[0].transit.d_max",
        "8 phases[0].transit.arival_radius",
        "9 phases[1].transitt",
        "10 phases[2].moor.radius",
        "10 phases[2].moor.anchor_wet_weight",
        "10 phases[2].moor.line_length.low",
        "11 sweep.d_max.to",
        "11 sweep.d_max.points",
        "11 sweep.sigma[1]",
        "12 monte_carlo.trials",
        "12 monte_carlo.seed",
    ]
    assert "did you mean velocity_error?" in found[1]
    assert "did you mean arrival_radius?" in found[8]
    assert "bare number 90" in found[2]
    assert "'90 s'" in found[2]


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (("from: [0 m, 0 m], ", ""), "phases[0].transit.from", "missing"),
        (("to: [4 nmi, 0 m]", "to: {latitude: 37 deg, longitude: -76 deg}"), "phases[0].transit.to", "site.origin"),
        (("sigma: 0.035 m/s", "sigma: 0.035 m/s, covariance: [[1 m^2/s^2, 0 m^2/s^2], [0 m^2/s^2, 1 m^2/s^2]]"), "velocity_error", "either"),
        (("{sigma: 0.035 m/s}", "{covariance: [[1 m^2/s^2, 2 m^2/s^2], [2 m^2/s^2, 1 m^2/s^2]]}"), "covariance", "eigenvalues"),
        (("name: short", "sweep: {phase: egress}"), "sweep.phase", "ingress"),
        (("name: short", "requirements: [{quantity: ingres.arrived, probability: 0.9}]"), "requirements[0].quantity", "did you mean ingress?"),
        (("name: short", "requirements: [{quantity: ingress.duration, at_most: 5 m, probability: 0.9}]"), "at_most", "quantity in s"),
        (("name: short", "requirements: [{quantity: ingress.duration, probability: 0.9}]"), "quantity", "at_most or at_least"),
        (("name: short", "requirements: [{quantity: ingress.arrived, probability: 90}]"), "probability", "at most 1"),
        (("name: short", "correlations: [{between: [ingress.speed, ingress.d_max], rho: 0.5}]"), "between[0]", "distribution"),
        (("name: short", "effects: [{mean-curent: {east: 1 m/s}}]"), "mean-curent", "did you mean mean-current?"),
        (("name: short", "effects: [{mean-current: {est: 1 m/s, north: 2 s}}]"), "est", "did you mean east?"),
        (("name: short", "site: {current: [{down_to: 5 m, speed: 1 m/s, toward: 0 deg}, {down_to: 5 m, speed: 1 m/s, toward: 0 deg}]}"), "down_to", "surface down"),
        (("name: short", "site: {water: {temperature: 20 degC, density: 1000 kg/m^3}}"), "site.water", "expected {temperature, salinity}"),
        (("name: short", "site: {current: {file: ../../etc/passwd}}"), "site.current.file", "outside"),
        (("name: short", "vehicle: /etc/passwd"), "vehicle", "outside"),
        (("name: short", 'vehicle: "a\\0b"'), "vehicle", "control character"),
        (("name: short", f"vehicle: {'a' * 300}.yaml"), "vehicle", "no such file"),
    ],
)  # fmt: skip
def test_one_problem(tmp_path: Path, change: tuple[str, str], key: str, words: str) -> None:
    found = problems_of(tmp_path, TRANSIT.replace(*change))
    assert any(key in problem and words in problem for problem in found), found


def test_an_included_file_names_its_own_lines(tmp_path: Path) -> None:
    (tmp_path / "auv.yaml").write_text("name: x\nhull:\n  length: 1\n  diameter: 4 in\n")
    found = problems_of(tmp_path, TRANSIT + "vehicle: auv.yaml\n")
    assert len(found) == 1
    assert "auv.yaml:3: vehicle.hull.length: given the bare number 1" in found[0]


def test_outside_files_are_permitted_on_request(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "auv.yaml").write_text("hull: {length: 1 m, diameter: 0.1 m}\n")
    path = tmp_path / "inner" / "mission.yaml"
    path.write_text(TRANSIT + "vehicle: ../auv.yaml\n")
    with pytest.raises(InputError, match="allow_outside=True"):
        load(path)
    assert load(path, allow_outside=True).vehicle is not None


def test_draws_outside_the_physical_range_are_said(tmp_path: Path) -> None:
    path = tmp_path / "mission.yaml"
    path.write_text(TRANSIT.replace("surfacing_time: 90 s", "surfacing_time: {mean: 90 s, sd: 90 s}"))
    assert load(path).notices() == (
        "navigation.surfacing_time: 16 % of the distribution lies outside the physical range and was cut off",
    )


@pytest.mark.parametrize(
    ("share", "words"), [(0.156, "16 %"), (2e-4, "0.02 %"), (1e-5, "0.001 %"), (9e-6, "less than 0.001 %")]
)
def test_what_is_cut_off_of_a_distribution_is_told_in_two_digits(share, words):
    (told,) = notices((), {"a.b": SimpleNamespace(mass_cut=share)})
    assert told.startswith(f"a.b: {words} of the distribution")


def test_a_misspelt_quantity_is_reported_with_a_missing_d_max(tmp_path: Path) -> None:
    text = TRANSIT.replace(", d_max: 4 nmi", "") + "requirements: [{quantity: ingress.durtion, probability: 0.9}]\n"
    missing, misspelt = problems_of(tmp_path, text)
    assert missing.endswith("d_max: missing; expected a quantity in m, or a mapping with table")
    assert "did you mean duration?" in misspelt
