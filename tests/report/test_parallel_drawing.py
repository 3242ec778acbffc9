"""Figures drawn by the processes of a pool: the same as those drawn here, whatever becomes of the pool."""

import os
import signal
from collections.abc import Iterator

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.montecarlo.parallel.pool import process_pool, result_of, running_pool, shut_down_pool
from missionplan.report.axes import name_axis
from missionplan.report.drawn import AT_ONCE, Drawn, draw, drawing_in_parallel, style
from missionplan.report.page import to_figure
from missionplan.report.quantities import reading_in


@pytest.fixture
def pool() -> Iterator[None]:
    shut_down_pool()
    process_pool(1)
    yield
    shut_down_pool()


def curve(phase: float = 0.0) -> Figure:
    """A figure whose ticks are written by a function that only this test knows."""
    figure = Figure(figsize=(5, 3), layout="constrained")
    axes = figure.subplots()
    t = np.linspace(0.0, 10.0, 50)
    axes.plot(t, np.sin(t + phase), label="depth")
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g} h")
    name_axis(axes.yaxis, "depth", "m")
    axes.legend()
    return figure


@pytest.mark.usefixtures("pool")
@pytest.mark.parametrize("units", ["", "imperial"])
def test_the_drawing_is_the_same(units: str) -> None:
    with style(), reading_in(units):
        here = draw(curve())
        with drawing_in_parallel():
            elsewhere = to_figure(curve(), "curve", "A curve")
    assert not isinstance(elsewhere.drawing, Drawn)
    assert (elsewhere.svg, elsewhere.plot) == (here.svg, here.plot)
    assert ("depth (ft)" in here.svg) == (units == "imperial")


@pytest.mark.usefixtures("pool")
def test_figures_that_the_pool_has_no_time_for_are_drawn_here() -> None:
    with style(), drawing_in_parallel():
        figures = [to_figure(curve(0.1 * n), f"curve-{n}", "A curve") for n in range(AT_ONCE + 1)]
        assert isinstance(figures[-1].drawing, Drawn)
        expected = [draw(curve(0.1 * n)).svg for n in range(AT_ONCE + 1)]
    assert [figure.svg for figure in figures] == expected


@pytest.mark.usefixtures("pool")
def test_a_figure_whose_process_dies_is_drawn_here() -> None:
    executor = running_pool()
    assert executor is not None
    worker = result_of(executor.submit(os.getpid))
    os.kill(worker, signal.SIGSTOP)  # it cannot finish before it is killed
    with style(), drawing_in_parallel():
        figure = to_figure(curve(), "curve", "A curve")
        os.kill(worker, signal.SIGKILL)
        assert figure.svg == draw(curve()).svg
        assert to_figure(curve(), "later", "A curve").svg == figure.svg


def test_without_a_pool_figures_are_drawn_here() -> None:
    shut_down_pool()
    with style(), drawing_in_parallel():
        assert isinstance(to_figure(curve(), "curve", "A curve").drawing, Drawn)
