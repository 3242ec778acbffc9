"""What the page's script adds, in a real browser: values under the pointer, series switched off, the slider."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from browsing import browsing, needs_browser, show

from missionplan.mission import load
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

MISSIONS = Path(__file__).parents[2] / "missions"
pytestmark = needs_browser


@pytest.fixture(scope="module")
def browser() -> Iterator:
    with browsing() as driver:
        yield driver


@pytest.fixture(scope="module")
def sweep():
    found = sweep_dmax(load(MISSIONS / "fig8.yaml"), trials=20)
    evil = '</script><script>document.title="stolen"</script>'
    return replace(found, provenance=replace(found.provenance, mission=evil))


@pytest.fixture(scope="module")
def report(sweep, tmp_path_factory) -> Path:
    return sweep.save(tmp_path_factory.mktemp("interaction") / "report") / "report.html"


def point_at(browser, figure: int, across: float, up: float) -> str:
    """Move the pointer over a figure's first axes, in shares of its box; returns what the page says there."""
    return browser.execute_script(
        "const figure = document.querySelectorAll('figure[data-plot]')[arguments[0]],"
        "svg = figure.querySelector('svg'), [left, top, wide, high] = JSON.parse(figure.dataset.plot).axes[0].box,"
        "{ x, y } = new DOMPoint(left + arguments[1] * wide, top + (1 - arguments[2]) * high)"
        ".matrixTransform(svg.getScreenCTM());"
        "svg.dispatchEvent(new PointerEvent('pointermove', { clientX: x, clientY: y, bubbles: true }));"
        "const tip = figure.querySelector('.tip'); return tip.hidden ? '' : tip.textContent;",
        figure, across, up,
    )  # fmt: skip


def test_the_pointer_reads_values_off_axes_and_curves(browser, report, sweep):
    show(browser, report, width=1280)
    words = point_at(browser, 0, 0.5, 0.5).splitlines()
    assert words[0] == "Maximum leg length d_max / distance 0.5"
    assert words[1].startswith("Mean cost c ")
    middle = min(sweep.middle.points, key=lambda point: abs(point.d_max_over_distance - 0.5))
    told = next(word for word in words if word.startswith(f"σ_v {sweep.middle.sigma:g}\u00a0m/s: "))
    value = float(told.split(": ")[1].split(" at ")[0].replace("\u2212", "-"))
    assert value == pytest.approx(100.0 * middle.cost, rel=0.01)
    assert point_at(browser, 0, 0.25, 0.5).startswith("Maximum leg length d_max / distance 0.25\n")
    assert point_at(browser, 0, 1.5, 0.5) == ""


def test_a_series_is_switched_off_and_on(browser, report):
    show(browser, report, width=1280)
    buttons = browser.find_elements("css selector", "header + figure .switches button")
    assert [button.text for button in buttons] == ["σ_v 0.015 m/s", "σ_v 0.035 m/s", "σ_v 0.055 m/s"]
    hidden = "return [...document.querySelectorAll('figure svg g[id]')].filter(g => g.style.display === 'none').length"
    assert browser.execute_script(hidden) == 0
    buttons[0].click()
    assert buttons[0].get_attribute("aria-pressed") == "false"
    assert browser.execute_script(hidden) >= 2
    assert "σ_v 0.015" not in point_at(browser, 0, 0.5, 0.5)
    buttons[0].click()
    assert browser.execute_script(hidden) == 0


def test_the_slider_runs_over_d_max(browser, report, sweep):
    show(browser, report, width=1280)
    set_to = (
        "const input = document.querySelector('.slider input'); input.value = arguments[0];"
        "input.dispatchEvent(new Event('input')); return document.querySelector('.slider output').textContent"
    )
    last = sweep.middle.points[-1]
    words = browser.execute_script(set_to, len(sweep.middle.points) - 1)
    assert f"{last.surfacings:.1f} surfacings" in words
    assert words.startswith("7.41\u00a0km.")
    ends = "const mark = document.querySelector('.mark').getBoundingClientRect(); return mark.left"
    far = browser.execute_script(ends)
    browser.execute_script(set_to, 0)
    assert far - browser.execute_script(ends) > 400


def test_what_a_file_says_is_no_script_and_without_script_nothing_is_missing(browser, report):
    show(browser, report, width=390)
    assert browser.title.startswith("Maximum leg length for ingress: </script>")
    assert browser.get_log("browser") == []
    html = report.read_text(encoding="utf-8")
    assert len(html.partition("<script>")[2].partition("</script>")[0]) < 8000
    static = html.partition("<script>")[0]
    assert "The numbers behind the curves" in static
    assert 'class="tip"' not in static
