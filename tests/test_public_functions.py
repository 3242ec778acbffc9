"""Every public function can be called again in one process: none is replaced by a module of its name once imported."""

import cmath
import math
import pkgutil
import random
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

import missionplan
from missionplan.cli import app
from missionplan.studies.leg_length import optimise_legs
from missionplan.studies.leg_length.analytic_transit import PolicyFamily

pytestmark = pytest.mark.usefixtures("unassumed")

MISSIONS = Path(__file__).parents[1] / "missions"


def mission(name: str) -> missionplan.Mission:
    return missionplan.load(MISSIONS / f"{name}.yaml")


@cache
def a_report() -> Path:
    folder = Path(tempfile.mkdtemp()) / "report"
    missionplan.simulate(mission("fig8"), trials=20, seed=1).save(folder)
    return folder


@cache
def a_sea_trial() -> Path:
    folder = Path(tempfile.mkdtemp())
    missionplan.init(folder)
    return folder


@cache
def a_diagnosis() -> Path:
    folder = Path(tempfile.mkdtemp())
    missionplan.diagnose(mission("chesapeake"), MISSIONS / "measured" / "avila-drag", plan=False).save(folder / "first")
    return folder


@cache
def a_record() -> Path:
    path = Path(tempfile.mkdtemp()) / "record.csv"
    rows = [f"{1800 * k},5,{0.3 * math.cos(0.253 * k):.4f},0.01" for k in range(96)]
    path.write_text("\n".join(["t_s,depth_m,east_m_s,north_m_s", *rows]) + "\n")
    return path


@cache
def a_log() -> Path:
    """A table of ten legs of half an hour round the compass, in a current: fixes at the surface, else reckoned."""
    path, rows, place = Path(tempfile.mkdtemp()) / "log.csv", ["t,lat,lon,a,b,depth"], 0j
    rng = random.Random(1)

    def row(t: int, here: complex, *, is_fix: bool, depth: int) -> str:
        at = f"{48 + here.imag / 111_200:.7f},{-123 + here.real / 74_600:.7f}"
        return f"{1_750_000_000 + t},{at if is_fix else ','},{at},{depth}"

    for leg in range(10):
        begin, way = 2400 * leg, 0.5 * cmath.exp(0.7j * leg)
        rows += [row(t, place, is_fix=True, depth=0) for t in range(begin, begin + 600, 60)]
        rows += [row(begin + 540 + t, place + way * t, is_fix=False, depth=20) for t in range(60, 1800, 60)]
        place += (way + complex(0.1 + rng.gauss(0.0, 0.02), rng.gauss(0.0, 0.02))) * 1800.0
    path.write_text("\n".join([*rows, row(24_000, place, is_fix=True, depth=0)]) + "\n")
    return path


def few_points() -> missionplan.Mission:
    return mission("fig8").with_({"sweep.d_max.points": 3})


def a_required_mission() -> missionplan.Mission:
    required = {"quantity": "ingress.arrived", "probability": 0.5}
    return missionplan.Mission.from_data({**mission("fig8").raw, "requirements": [required]})


CALLS: dict[str, Callable[[], object]] = {
    "load": lambda: missionplan.load(MISSIONS / "fig8.yaml"),
    "simulate": lambda: missionplan.simulate(mission("fig8"), trials=20, seed=1),
    "sweep_dmax": lambda: missionplan.sweep_dmax(few_points(), trials=20, seed=1, method="analytic"),
    "size_anchor": lambda: missionplan.size_anchor(mission("anchor-design"), trials=20, seed=1),
    "export": lambda: missionplan.export(mission("fig8"), "csv", out=tempfile.mkdtemp()),
    "import_logs": lambda: missionplan.import_logs([Path(__file__).parent / "importers" / "made.gli"]),
    "identify": lambda: missionplan.identify(MISSIONS / "measured" / "avila-drag"),
    "import_log": lambda: missionplan.import_log(Path(__file__).parent / "importers" / "made.gli"),
    "schema": lambda: missionplan.schema("dataset"),
    "reports": lambda: missionplan.reports(Path(__file__).parent),
    "validate": lambda: missionplan.validate([MISSIONS / "fig8.yaml", mission("chesapeake")]),
    "why": lambda: missionplan.why(
        a_log(),
        tempfile.mkdtemp(),
        names=["time=t[epoch]", "lat=lat", "lon=lon", "dr_lat=a", "dr_lon=b", "depth=depth"],
    ),
    "init": lambda: missionplan.init(tempfile.mkdtemp()),
    "diagnose": lambda: missionplan.diagnose(mission("chesapeake"), MISSIONS / "measured" / "avila-drag", plan=False),
    "plan_legs": lambda: missionplan.plan_legs(mission("fig8"), trials=20, seed=1),
    "find_rare_failure": lambda: missionplan.find_rare_failure(mission("fig8"), trials=2000, seed=1),
    "sweep_transition": lambda: missionplan.sweep_transition(mission("autosub-transition"), time_step=1.0),
    "compare": lambda: missionplan.compare(a_report(), a_report()),
    "explore": lambda: missionplan.explore(mission("fig8"), "ingress.d_max=3,4 km", trials=20, seed=1),
    "compare_missions": lambda: missionplan.compare_missions(mission("fig8"), mission("chesapeake"), trials=20, seed=1),
    "optimise": lambda: missionplan.optimise(a_required_mission(), choose=["ingress.d_max=3,4 km"], trials=100, seed=1),
    "diagnose_campaign": lambda: missionplan.diagnose_campaign(
        a_sea_trial() / "mission.yaml", [a_sea_trial() / "sea-trial"], plan=False
    ),
    "history": lambda: missionplan.history(a_diagnosis()),
    "verify": lambda: missionplan.verify(a_report()),
    "score": lambda: missionplan.score(a_sea_trial() / "mission.yaml", a_sea_trial() / "sea-trial"),
    "tide": lambda: missionplan.tide(a_record(), latitude="50 deg", start="2026-05-01T00:00:00Z"),
}
CLASSES = {"Mission", "__version__", "InputError", "MissionplanError", "RunError"}
UNDER_OTHER_NAMES = {"import": "import_log", "effects": "", "simulate --rare": "find_rare_failure"}
"""Commands whose function has another name, or that have none."""


LONG = {"why", "score", "diagnose_campaign", "sweep_transition"}


@pytest.mark.parametrize("name", sorted(CALLS.keys() - LONG))
def test_a_public_function_is_called_twice(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(optimise_legs, "MEAN_FAMILY", PolicyFamily((1.0,), ()))  # which legs does not matter here
    called_twice(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LONG))
def test_a_long_public_function_is_called_twice(name: str) -> None:
    called_twice(name)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("why", ([MISSIONS / "no.gli"], "nowhere")),
        ("sweep_transition", (MISSIONS / "fig8.yaml",)),
        ("score", (MISSIONS / "fig8.yaml", "nowhere")),
        ("diagnose_campaign", (MISSIONS / "fig8.yaml", ["nowhere"])),
    ],
)
def test_a_long_public_function_refuses_twice(name: str, arguments: tuple[object, ...]) -> None:
    """All that it needs is imported before it looks at its arguments."""
    for _ in range(2):
        with pytest.raises(missionplan.InputError):
            getattr(missionplan, name)(*arguments)


def called_twice(name: str) -> None:
    first, second = CALLS[name](), CALLS[name]()
    assert type(first) is type(second)
    assert callable(getattr(missionplan, name))


def test_every_public_function_is_called_here() -> None:
    assert set(missionplan.__all__) - CLASSES == set(CALLS)


def test_dir_lists_the_public_names_and_each_can_be_had() -> None:
    assert dir(missionplan) == sorted(missionplan.__all__)
    assert all(getattr(missionplan, name) is not None for name in dir(missionplan))


def test_every_command_is_a_public_function() -> None:
    commands = [command.name or command.callback.__name__ for command in app.registered_commands]
    functions = {UNDER_OTHER_NAMES.get(name, name.replace("-", "_")) for name in commands}
    assert functions - {""} <= set(missionplan.__all__)


@pytest.mark.parametrize("path", [str(MISSIONS / "fig8.yaml"), MISSIONS / "fig8.yaml"])
def test_a_mission_is_given_by_its_path(path: str | Path) -> None:
    given = missionplan.simulate(path, trials=20, seed=1)
    assert given.to_frame().equals(missionplan.simulate(mission("fig8"), trials=20, seed=1).to_frame())


def test_what_is_neither_a_mission_nor_a_path_is_refused_in_words() -> None:
    with pytest.raises(missionplan.InputError, match="mission: given 3, expected a Mission, or the path"):
        missionplan.simulate(3)  # type: ignore[arg-type]


def test_no_public_name_is_that_of_a_module() -> None:
    """Importing a submodule binds it in its package: it would take the function's place."""
    modules = {module.name for module in pkgutil.iter_modules(missionplan.__path__)}
    assert not modules & set(missionplan.__all__)
    assert "score" not in modules  # a command to come
