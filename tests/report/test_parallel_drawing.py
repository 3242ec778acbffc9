"""Figures drawn by copies of the process: the same as those drawn here, whatever becomes of the copies."""

import os
import signal
import sys
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.report.axes import name_axis
from missionplan.report.page import Copies, Drawn, draw, drawing_by, drawing_in_parallel, style, to_figure
from missionplan.report.quantities import reading_in

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux alone"),
    pytest.mark.usefixtures("drawn"),
]


@pytest.fixture
def copies() -> Iterator[Copies]:
    made = Copies(most=1)
    with style(), drawing_by(made.drawing_of):
        yield made
    made.end()


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


@pytest.mark.parametrize("units", ["", "imperial"])
def test_the_drawing_is_the_same(copies: Copies, units: str) -> None:
    with reading_in(units):
        here = draw(curve())
        elsewhere = to_figure(curve(), "curve", "A curve")
    assert not isinstance(elsewhere.drawing, Drawn)
    assert (elsewhere.svg, elsewhere.plot) == (here.svg, here.plot)
    assert ("depth (ft)" in here.svg) == (units == "imperial")


def test_figures_that_no_copy_has_time_for_are_drawn_here(copies: Copies) -> None:
    first = to_figure(curve(), "curve-0", "A curve")
    os.kill(copies.made[0].process, signal.SIGSTOP)  # it is busy
    second = to_figure(curve(0.1), "curve-1", "A curve")
    assert isinstance(second.drawing, Drawn)
    os.kill(copies.made[0].process, signal.SIGCONT)
    assert [first.svg, second.svg] == [draw(curve()).svg, draw(curve(0.1)).svg]


def test_a_figure_whose_copy_dies_is_drawn_here(copies: Copies) -> None:
    figure = to_figure(curve(), "curve", "A curve")
    os.kill(copies.made[0].process, signal.SIGKILL)
    assert figure.svg == draw(curve()).svg
    assert to_figure(curve(), "later", "A curve").svg == figure.svg


def test_ctrl_c_does_not_end_a_copy_and_one_that_nobody_asks_ends(copies: Copies) -> None:
    figure = to_figure(curve(), "curve", "A curve")
    os.kill(copies.made[0].process, signal.SIGINT)
    assert figure.svg == draw(curve()).svg
    to_figure(curve(), "unasked", "A curve")
    copies.end()
    with pytest.raises(ChildProcessError):
        os.waitpid(copies.made[1].process, 0)


def test_beside_other_threads_figures_are_drawn_here() -> None:
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    try:
        with style(), drawing_in_parallel():
            assert isinstance(to_figure(curve(), "curve", "A curve").drawing, Drawn)
    finally:
        done.set()
        thread.join()
