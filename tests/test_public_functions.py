"""Every public function can be called again in one process: none is replaced by a module of its name once imported."""

import pkgutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

import missionplan

MISSIONS = Path(__file__).parents[1] / "missions"


def mission(name: str) -> missionplan.Mission:
    return missionplan.load(MISSIONS / f"{name}.yaml")


CALLS: dict[str, Callable[[], object]] = {
    "load": lambda: missionplan.load(MISSIONS / "fig8.yaml"),
    "simulate": lambda: missionplan.simulate(mission("fig8"), trials=20, seed=1),
    "sweep_dmax": lambda: missionplan.sweep_dmax(mission("fig8"), trials=20, seed=1, method="analytic"),
    "size_anchor": lambda: missionplan.size_anchor(mission("anchor-design"), trials=20, seed=1),
    "export": lambda: missionplan.export(mission("fig8"), "csv", out=tempfile.mkdtemp()),
    "import_logs": lambda: missionplan.import_logs([Path(__file__).parent / "importers" / "made.gli"]),
    "identify": lambda: missionplan.identify(MISSIONS / "measured" / "avila-drag"),
    "diagnose": lambda: missionplan.diagnose(mission("chesapeake"), MISSIONS / "measured" / "avila-drag", plan=False),
}
SLOW = {"plan_legs", "sweep_transition"}


@pytest.mark.parametrize("name", CALLS)
def test_a_public_function_is_called_twice(name: str) -> None:
    first, second = CALLS[name](), CALLS[name]()
    assert type(first) is type(second)
    assert callable(getattr(missionplan, name))


def test_every_public_function_is_called_here() -> None:
    assert set(missionplan.__all__) - {"Mission", "__version__"} == {*CALLS, *SLOW}


def test_no_public_name_is_that_of_a_module() -> None:
    """Importing a submodule binds it in its package: it would take the function's place."""
    modules = {module.name for module in pkgutil.iter_modules(missionplan.__path__)}
    assert not modules & set(missionplan.__all__)
    assert "score" not in modules  # a command to come
