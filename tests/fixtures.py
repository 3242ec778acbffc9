"""Shared by all tests: hypothesis settings, missions, and data set folders."""

import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from missionplan.diagnosis.dives.model import descent_model
from missionplan.diagnosis.dives.preparation import PreparedDives, binned
from missionplan.effects import CATALOGUE
from missionplan.mission import load
from missionplan.montecarlo import streams
from missionplan.phases.transit.plan import LegTable
from missionplan.report.page import Drawn, draw, drawing_by
from missionplan.studies import anchor, judgement
from missionplan.studies.leg_length import analytic_transit, optimise_legs
from missionplan.studies.simulation import outcome_builder
from missionplan.studies.simulation import simulate as simulation
from tests.depth_readings import simulate_readings
from tests.few_causes import COMMON, few

# no time limits: a busy machine is slow; the same examples each time, so that what was green stays so: nightly runs
# look for new ones
settings.register_profile(
    "repeatable", deadline=None, max_examples=25, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", settings.get_profile("repeatable"), max_examples=100, derandomize=False)
settings.load_profile("repeatable")


def any_text(most: int) -> st.SearchStrategy[str]:
    """Text of all characters but surrogates; to find these, `st.text` encodes each, for two seconds of each process."""
    return st.text(st.characters(exclude_categories=("Cs",)), max_size=most)


TRANSIT = {
    "name": "Legs in a bay",
    "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s", "fix_error": "3 m"},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": "1.2 m/s",
                "d_max": "1 km",
                "arrival_radius": "60 m",
            }
        }
    ],
}

DESCENT = {
    "name": "Dives in a lake",
    "vehicle": {
        "hull": {"length": "1.12 m", "diameter": "0.12 m"},
        "appendage_factor": 1.25,
        "mass": "10.2 kg",
        "net_buoyancy": "0.9 N",
        "anchor": {"diameter": "0.12 m", "flooded_mass": "2.6 kg"},
    },
    "site": {"depth": "24 m", "water": {"density": "1000 kg/m^3", "viscosity": "1.1e-6 m^2/s"}},
    "phases": [{"moor": {"radius": "20 m", "anchor_wet_weight": "12 N", "line_length": "5 m"}}],
}


@pytest.fixture
def mission(tmp_path):
    def make(data):
        path = tmp_path / "base.yaml"
        path.write_text(yaml.safe_dump(data))
        return load(path)

    return make


@pytest.fixture
def transit_mission(mission):
    return mission(TRANSIT)


@pytest.fixture
def descent_mission(mission):
    return mission(DESCENT)


@pytest.fixture(scope="session", autouse=True)
def normals_kept():
    """Draw the normals of legs once for all tests: they depend on seed, name and block alone, and may not be written."""
    kept, anew = threading.local(), streams.BlockStreams.legs

    def legs(self, quantity):
        found = vars(kept).setdefault("legs", {})
        if sum(each.drawn for each in found.values()) > streams.MOST_KEPT:
            found.clear()
        key = (self.seed, quantity, self.block)
        if key not in found:
            found[key] = anew(self, quantity)
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(streams.BlockStreams, "legs", legs)
        yield


@pytest.fixture(scope="session", autouse=True)
def undrawn():
    """Write reports without their drawings, which few tests look at."""
    with drawing_nothing():
        yield


def drawing_nothing() -> AbstractContextManager[None]:
    """Write reports without their drawings."""
    return drawing_by(lambda figure, shown: Drawn("<svg/>"))


@pytest.fixture(scope="module")
def unassumed():
    """Judge without runs for each assumption of a mission: for modules that do not look at assumptions."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judgement, "ledger", lambda *_: ())
        yield


@pytest.fixture(scope="module")
def unplanned():
    """Simulate without the plan for the boat, of which each leg has its duration: for modules that do not look at it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation, "plan_if_any", lambda mission, means, seed: None)
        yield


@pytest.fixture(scope="module", params=["few-causes", pytest.param("all-causes", marks=pytest.mark.slow)])
def causes(request: pytest.FixtureRequest) -> Callable[[], AbstractContextManager[None]]:
    """Within it the catalogue is small, but in the long runs; a module may list `CAUSES` of its own."""
    names = getattr(request.module, "CAUSES", COMMON)
    return (lambda: few(names)) if request.param == "few-causes" else nullcontext


@pytest.fixture
def among_few(causes: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Diagnose with a small catalogue, but in the long runs."""
    with causes():
        yield


@pytest.fixture(scope="module")
def unranked():
    """Simulate without ranking inputs by what they explain: for modules that do not look at it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outcome_builder, "sensitivities", lambda inputs, outputs: ())
        yield


@pytest.fixture(scope="module")
def unheld():
    """Leave out how the vehicle stands above its anchor, and what would mend it: for modules that do not look at it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation, "held_vehicles", lambda means: ())
        patch.setattr(anchor, "held_vehicle", lambda means, phase, weight: None)
        yield


@pytest.fixture
def unsought(monkeypatch):
    """Plan legs by one table by hand, of which the search is most of the work: for what does not look at the table."""

    def best_legs(distance, speed, arrival_radius, *others):
        lengths = np.array([arrival_radius, 0.6 * distance])
        return SimpleNamespace(legs=LegTable(np.array([arrival_radius, distance]), lengths), bound=0.0)

    monkeypatch.setattr(analytic_transit, "_best_legs", best_legs)
    monkeypatch.setattr(optimise_legs, "MEAN_FAMILY", analytic_transit.PolicyFamily((1.0,), ()))


@pytest.fixture(scope="module")
def drawn():
    """Draw all figures: for modules that look at drawings, or ask whether all can be drawn."""
    with drawing_by(draw):
        yield


@pytest.fixture
def folder(tmp_path):
    """Write a data set folder from the keys of dataset.yaml and a table (or the text of the CSV)."""

    def write(keys, table):
        place = tmp_path / "data"
        place.mkdir(exist_ok=True)
        (place / "dataset.yaml").write_text(yaml.safe_dump({"file": "rows.csv", **keys}))
        text = table if isinstance(table, str) else table.to_csv(index=False)
        (place / "rows.csv").write_text(text)
        return place

    return write


@pytest.fixture
def legs():
    """Make a table of legs."""
    return make_legs


def make_legs(n=48, seed=1, sigma=0.03, error=None, lasting=1.0, about=(np.pi, np.pi)):
    """Legs with random headings, within a spread of a middle, with independent velocity errors and an additional `error(t, heading)` [m/s]."""
    rng = np.random.default_rng(seed)
    duration = lasting * rng.uniform(500.0, 1100.0, n)
    t = np.concatenate([[0.0], np.cumsum(duration + 120.0)[:-1]])
    middle, spread = about
    heading = middle + spread * (rng.uniform(0.0, 2.0, n) - 1.0)
    through = 1.2 * duration * np.stack([np.sin(heading), np.cos(heading)])
    wrong = rng.normal(0.0, sigma, (2, n))
    if error is not None:
        wrong = wrong + error(t + 0.5 * duration, heading)
    moved = through + wrong * duration
    start = np.cumsum(np.concatenate([np.zeros((2, 1)), moved[:, :-1]], axis=1), axis=1)
    fixed = start + rng.normal(0.0, 3.0, (2, n))
    reckoned, end = fixed + through, start + moved + rng.normal(0.0, 3.0, (2, n))
    columns = {"leg": np.arange(n) + 1, "t_start_s": t, "t_end_s": t + duration}
    for name, (x, y) in {"start": fixed, "dr": reckoned, "end": end}.items():
        columns |= {f"x_{name}_m": x, f"y_{name}_m": y}
    return pd.DataFrame(columns)


def dated(table, hours=0.0):
    """Legs with times of one day, so many hours after its first: a vehicle is the same all day."""
    return table.assign(**{name: table[name] + 1.78e9 + 3600.0 * hours for name in ("t_start_s", "t_end_s")})


WEIGHTS, LINES = np.array([9.0, 12.0, 16.0, 20.0]), np.array([3.0, 5.0, 7.0, 4.0])


@pytest.fixture
def measured(descent_mission):
    """Bind the mission to simulated dives with one effect, each with its own delay or averaged by the logger."""

    def make(name=None, weights=WEIGHTS, lines=LINES, late=None, averaged=0.0, **parameters):
        rng = np.random.default_rng(8)
        times = np.tile(np.linspace(0.0, 13.0, 66)[:, None], (1, len(weights)))
        empty = tuple(
            binned(f"dive-{k}", times[:, k], times[:, k], 0.03, weights[k], lines[k], 60.0) for k in range(len(weights))
        )
        forward = descent_model(PreparedDives("", "", empty, ()), descent_mission).forward
        effects = [CATALOGUE[name].make(parameters)] if name else []
        late = rng.normal(0.0, 0.05, len(weights)) if late is None else late
        dive = replace(forward.dive, wet_weight=forward.dive.wet_weight * (1.0 + rng.normal(0.0, 0.006, len(weights))))
        past = late + np.linspace(0.0, averaged, 41 if averaged else 1)[:, None]
        depth = np.mean([simulate_readings(dive, times - ago, effects=effects) for ago in past], axis=0)
        depth += rng.normal(0.0, 0.03, times.shape)
        logs = tuple(
            binned(log.name, times[:, k], depth[:, k], 0.03, log.wet_weight, log.line_length, 60.0)
            for k, log in enumerate(empty)
        )
        return descent_model(PreparedDives("", "", logs, ()), descent_mission)

    return make
