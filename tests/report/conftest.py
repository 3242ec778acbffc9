"""For all tests of pages of a process: one browser, and the pages of one study of each kind."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from browsing import browsing

from missionplan.mission import load
from missionplan.report.page import draw, drawing_by
from missionplan.results import Result
from missionplan.studies import judgement
from missionplan.studies.anchor import size_anchor
from missionplan.studies.leg_length import optimise_legs
from missionplan.studies.leg_length.analytic_transit import PolicyFamily
from missionplan.studies.leg_length.plan_legs import plan_legs
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation.simulate import simulate

MISSIONS = Path(__file__).parents[2] / "missions"
LEGS = """
name: Legs
navigation: {velocity_error: {sigma: 0.15 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: in, from: [0 m, 0 m], to: [3 km, 1 km], speed: 1 m/s, d_max: 1 km, arrival_radius: 20 m}
monte_carlo: {trials: 500, seed: 5}
"""


@pytest.fixture(scope="session")
def browser() -> Iterator:
    with browsing() as driver:
        yield driver


@dataclass(frozen=True)
class Saved:
    """A result, and its page with all figures drawn."""

    result: Result
    page: Path


@pytest.fixture(scope="session")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Result], Saved]:
    def save(result: Result) -> Saved:
        with drawing_by(draw):
            return Saved(result, result.save(tmp_path_factory.mktemp("saved") / "report") / "report.html")

    return save


@pytest.fixture(scope="session")
def simulated(saved: Callable[[Result], Saved]) -> Saved:
    """A mission of every kind of phase, in which dives fail too."""
    given = load(MISSIONS / "chesapeake.yaml").with_({"moor.radius": "6 m"})
    return saved(simulate(given, trials=200, seed=3))


@pytest.fixture(scope="session")
def planned(saved: Callable[[Result], Saved], tmp_path_factory: pytest.TempPathFactory) -> Saved:
    """Legs without runs for each assumption, the best of few: which they are does not matter to a page."""
    path = tmp_path_factory.mktemp("legs") / "legs.yaml"
    path.write_text(LEGS, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(optimise_legs, "MEAN_FAMILY", PolicyFamily((1.0,), ()))
        patch.setattr(judgement, "ledger", lambda *_: ())
        return saved(plan_legs(load(path)))


@pytest.fixture(scope="session")
def swept(saved: Callable[[Result], Saved]) -> Saved:
    few = load(MISSIONS / "fig8.yaml").with_({"sweep.d_max.points": 15})
    return saved(sweep_dmax(few, trials=20))


@pytest.fixture(scope="session")
def sized(saved: Callable[[Result], Saved]) -> Saved:
    """Both anchors: of the worst case, and of nine dives in ten."""
    return saved(size_anchor(load(MISSIONS / "anchor-design.yaml"), trials=100, probability=0.9))
