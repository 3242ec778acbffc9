"""What the page's script adds, in a real browser: values under the pointer, series switched off, the slider."""

import math
from dataclasses import replace
from pathlib import Path

import pyproj
import pytest
from browsing import needs_browser, show

pytestmark = needs_browser


@pytest.fixture(scope="module")
def evil(swept, saved):
    """The name of the mission would be a script."""
    name = '</script><script>document.title="stolen"</script>'
    return saved(replace(swept.result, provenance=replace(swept.result.provenance, mission=name)))


@pytest.fixture(scope="module")
def sweep(evil):
    return evil.result


@pytest.fixture(scope="module")
def report(evil) -> Path:
    return evil.page


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


def test_the_pointer_reads_the_nearest_data_off_curves(browser, report, sweep):
    show(browser, report, width=1280)
    words = point_at(browser, 0, 0.5, 0.5).splitlines()
    near = [point for point in sweep.middle.points if abs(point.d_max_over_distance - 0.5) < 0.05]
    told = next(word for word in words if word.startswith(f"σ_v {sweep.middle.sigma:g}\u00a0m/s: Mean cost c "))
    value = float(told.split("Mean cost c ")[1].split()[0].replace("\u2212", "-"))
    at = float(words[0].removeprefix("Maximum leg length d_max / distance "))
    point = min(near, key=lambda point: abs(point.d_max_over_distance - at))
    assert at == pytest.approx(point.d_max_over_distance, rel=1e-3)
    assert value == pytest.approx(100.0 * point.cost, rel=0.002) or value == pytest.approx(point.cost, rel=0.002)
    assert point_at(browser, 0, 1.5, 0.5) == ""


@pytest.fixture(scope="module")
def mission(simulated):
    return simulated.result, simulated.page


def figure_named(browser, name: str) -> int:
    return browser.execute_script(
        "return [...document.querySelectorAll('figure[data-plot]')].findIndex(f => f.dataset.name === arguments[0])",
        name,
    )


def test_the_pointer_reads_bars_bins_and_places_on_earth(browser, mission):
    outcome, report = mission
    show(browser, report, width=1280)
    waterfall = figure_named(browser, "waterfall")
    success = 100.0 * outcome.total.events["success"].value
    steps = 1 + sum(step.lost.value > 0.0 for step in outcome.attrition)
    told = point_at(browser, waterfall, 0.005, 0.5 / steps)
    assert told == f"mission succeeds: {success:.4g}\u00a0%"
    drawn = outcome.total.histograms["duration_s"]
    shares = {f"{100.0 * count / drawn.counts.sum():.4g}\u00a0%" for count in drawn.counts}
    told = point_at(browser, figure_named(browser, "histograms"), 0.5, 0.05)
    assert told.partition(": ")[2] in shares
    words = point_at(browser, figure_named(browser, "mission"), 0.5, 0.9).splitlines()
    latitude, longitude = (float(word.rstrip("°")) for word in words[-1].split())
    wgs84 = pyproj.Geod(ellps="WGS84")
    origin = tuple(map(math.degrees, outcome.tracks.origin))
    assert wgs84.inv(origin[1], origin[0], longitude, latitude)[2] < 3000.0


def test_the_pointer_reads_the_median_trial_and_the_circles_about_a_goal(browser, mission):
    outcome, report = mission
    show(browser, report, width=1280)
    above = figure_named(browser, "mission")
    limits = browser.execute_script(
        "const figure = document.querySelector('figure[data-name=mission]'),"
        "{ x, y } = JSON.parse(figure.dataset.plot).axes[0]; return [x.lim, y.lim]"
    )
    goal, radius = outcome.tracks.targets["ingress"]
    shares = [(at - low) / (high - low) for at, (low, high) in zip(goal, limits, strict=True)]
    words = point_at(browser, above, *shares).splitlines()
    pixel = (limits[0][1] - limits[0][0]) / 400.0
    assert float(words[0].removeprefix("east ").removesuffix("\u00a0m")) == pytest.approx(goal[0], abs=pixel)
    (circle,) = [word for word in words if word.startswith("arrival circle: north ")]
    north = float(circle.split()[3].split("\u00a0")[0].replace("\u2212", "-"))
    assert abs(north - goal[1]) <= radius * 1.001
    assert any(word.startswith("median trial: north ") for word in words)


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
