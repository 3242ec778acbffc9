"""Every result on one screen, in a notebook and as plots."""

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import missionplan
from missionplan.errors import InputError
from missionplan.results import Result
from tests.few_causes import few
from tests.fixtures import drawing_nothing

pytestmark = pytest.mark.usefixtures("drawn")

ROOT = Path(__file__).parents[2]
MISSIONS = ROOT / "missions"
LOOP = Path(missionplan.__file__).parent / "starter" / "loop"


@cache
def result(name: str, folder: Path) -> Result:
    made = {
        "simulation": lambda: missionplan.simulate(MISSIONS / "chesapeake.yaml", trials=60, keep_trials=True),
        "sweep": lambda: missionplan.sweep_dmax(MISSIONS / "fig8.yaml", trials=20),
        "anchor": lambda: missionplan.size_anchor(MISSIONS / "anchor-design.yaml", trials=20),
        "identification": lambda: missionplan.identify(MISSIONS / "measured" / "avila-drag"),
        "import": lambda: missionplan.import_log(ROOT / "tests" / "importers" / "made.gli"),
        "diagnosis": lambda: _diagnosis(folder),
        "comparison": lambda: _comparison(folder),
        "exploration": lambda: _exploration(),
        "score": lambda: missionplan.score(LOOP / "mission.yaml", LOOP / "third-log"),
        "history": lambda: _history(folder),
        "optimisation": lambda: _optimisation(),
        "campaign": lambda: _campaign(folder),
    }
    return made[name]()


NAMES = (
    "simulation",
    "sweep",
    "anchor",
    "identification",
    "import",
    "diagnosis",
    "comparison",
    "exploration",
    "score",
    "history",
    "optimisation",
    "campaign",
)


def _diagnosis(folder: Path) -> Result:
    missionplan.init(folder)
    with few(("compass-bias", "mean-current")):
        return missionplan.diagnose(folder / "mission.yaml", folder / "sea-trial", plan=False)


def _exploration() -> Result:
    varied = ["moor.line_length=4:6:1 m", "ingress.speed=1.0:1.5:0.5 m/s"]
    return missionplan.explore(MISSIONS / "chesapeake.yaml", vary=varied, trials=20)


def _optimisation() -> Result:
    return missionplan.optimise(MISSIONS / "chesapeake.yaml", choose=["ingress.speed=1.0:1.6:0.3 m/s"], trials=60)


def _campaign(folder: Path) -> Result:
    return missionplan.diagnose_campaign(
        MISSIONS / "chesapeake.yaml", [MISSIONS / "measured" / "avila-drag"], plan=False
    )


def _history(folder: Path) -> Result:
    with drawing_nothing():
        result("diagnosis", folder).save(folder / "log-book" / "first", force=True)
    return missionplan.history(folder / "log-book")


def test_an_exploration_is_a_grid(folder):
    pytest.importorskip("xarray")
    grid = result("exploration", folder).to_xarray()
    assert dict(grid.sizes) == {"moor.line_length": 3, "ingress.speed": 2}
    assert grid["moor.line_length"].values.tolist() == [4.0, 5.0, 6.0]
    assert grid["moor.line_length"].attrs["units"] == "m"
    assert float(grid["success"].sel({"moor.line_length": 5.0, "ingress.speed": 1.5})) >= 0.0


def _comparison(folder: Path) -> Result:
    for name, seed in (("one", 1), ("two", 2)):
        with drawing_nothing():
            missionplan.simulate(MISSIONS / "fig8.yaml", trials=50, seed=seed, sheet=False).save(folder / name)
    return missionplan.compare(folder / "one", folder / "two")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("results")


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    plt.close("all")


@pytest.mark.parametrize("name", NAMES)
def test_a_result_is_shown_on_one_screen(name: str, folder: Path) -> None:
    found = result(name, folder)
    text = repr(found)
    lines = text.splitlines()
    assert lines[0].startswith(f"<{type(found).__name__}: {found.provenance.command}")
    assert lines[0].endswith(">")
    assert len(text) < 3000
    assert 2 < len(lines) <= 30
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_shows_the_answer_a_table_and_a_figure(name: str, folder: Path) -> None:
    html = result(name, folder)._repr_html_()
    assert html.count("<table>") == html.count("</table>") == 1
    assert len(re.findall('src="data:image/svg', html)) == 1
    assert "<script" not in html


@pytest.mark.parametrize("name", NAMES)
def test_plots_draw_on_given_axes_and_return_them(name: str, folder: Path) -> None:
    found = result(name, folder)
    assert dir(found.plot)
    for plot in dir(found.plot):
        axes = Figure().add_subplot()
        assert getattr(found.plot, plot)(ax=axes) is axes
        assert axes.has_data() or axes.texts, plot
    assert isinstance(found.plot(), Axes)


def test_a_histogram_is_of_the_quantity_named(folder: Path) -> None:
    found = result("simulation", folder)
    assert "offset" in found.plot.histogram(quantity="moor.offset_m").get_xlabel()
    with pytest.raises(InputError, match=re.escape("did you mean moor.offset_m?")):
        found.plot("histogram", quantity="moor.ofset_m")


def test_a_plot_that_there_is_not_is_refused_in_words(folder: Path) -> None:
    found = result("sweep", folder)
    with pytest.raises(InputError, match="expected one of cost, surfacings"):
        found.plot("costs")
    with pytest.raises(AttributeError, match=re.escape("did you mean cost?")):
        found.plot.costs  # noqa: B018
    assert repr(found.plot) == "<plots of Sweep: cost, surfacings>"


def test_a_sweep_is_a_grid(folder: Path) -> None:
    found = result("sweep", folder)
    grid = found.to_xarray()
    frame = found.to_frame()
    assert grid.sizes == {"sigma_m_s": frame["sigma_m_s"].nunique(), "d_max_m": frame["d_max_m"].nunique()}
    row = frame.iloc[37]
    assert grid["cost"].sel(sigma_m_s=row["sigma_m_s"], d_max_m=row["d_max_m"]) == row["cost"]
    assert grid["d_max_m"].attrs["units"] == "m"


def test_trials_are_a_table_when_kept(folder: Path) -> None:
    found = result("simulation", folder)
    assert len(found.trials) == 60
    durations = found.trials["total.duration_s"]
    assert np.isclose(durations.mean(), found.total.quantities["duration_s"].mean)
    with pytest.raises(InputError, match=re.escape("simulate(..., keep_trials=True) keeps them")):
        _ = missionplan.simulate(MISSIONS / "fig8.yaml", trials=10).trials
