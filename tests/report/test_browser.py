"""The page in a real browser: no errors, no requests, figures shown, readable on a telephone, light and dark."""

import json
import re
from pathlib import Path

import pytest
from browsing import needs_browser, show
from outcome_example import example

pytestmark = [needs_browser, pytest.mark.usefixtures("drawn")]


@pytest.fixture(scope="module")
def report(tmp_path_factory) -> Path:
    return example().save(tmp_path_factory.mktemp("browser") / "report") / "report.html"


def requests(browser) -> list[str]:
    messages = (json.loads(entry["message"])["message"] for entry in browser.get_log("performance"))
    return [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]


def test_the_console_is_silent_and_nothing_is_asked_for(browser, report):
    browser.get("about:blank")  # leaves the browser's own first tab, whose requests are not the page's
    requests(browser)
    show(browser, report, width=1200)
    assert browser.get_log("browser") == []
    urls = set(requests(browser))
    assert report.as_uri() in urls
    assert [url for url in urls if url != report.as_uri() and not url.startswith("data:")] == []


@pytest.mark.parametrize("width", [375, 1200])
def test_every_figure_is_shown_within_the_page(browser, report, width):
    show(browser, report, width=width)
    boxes = browser.execute_script(
        "return [...document.querySelectorAll('figure svg')].map(svg => {"
        "const box = svg.getBoundingClientRect();"
        "return [box.left, box.right, box.width, box.height]; })"
    )
    assert len(boxes) == 3
    for left, right, wide, high in boxes:
        assert wide > 250
        assert high > 80
        assert left >= 0
        assert right <= width


def test_no_label_is_cut_off_at_the_edge_of_its_figure(browser, report):
    show(browser, report, width=1200)
    cut = browser.execute_script(
        "return [...document.querySelectorAll('figure svg')].flatMap(svg => {"
        "const edge = svg.getBoundingClientRect();"
        "return [...svg.querySelectorAll('text')].filter(text => { const box = text.getBoundingClientRect();"
        "return box.left < edge.left - 1 || box.right > edge.right + 1 || box.top < edge.top - 1"
        " || box.bottom > edge.bottom + 1; }).map(text => text.textContent); })"
    )
    assert cut == []


def test_the_page_reads_at_the_width_of_a_telephone(browser, report):
    show(browser, report, width=375)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= 375
    smallest = browser.execute_script(
        "return Math.min(...[...document.querySelectorAll('figure svg text')]"
        ".map(text => { const m = text.getScreenCTM();"
        "return parseFloat(getComputedStyle(text).fontSize) * Math.hypot(m.a, m.b); }))"
    )
    assert smallest > 8.0
    assert browser.execute_script("return parseFloat(getComputedStyle(document.body).fontSize)") >= 16.0


def test_what_is_looked_up_is_folded_until_it_is_asked_for(browser, report):
    words = "return document.body.innerText.split(/\\s+/).length"
    show(browser, report, width=375, unfolded=False)
    first, height = (browser.execute_script(each) for each in (words, "return document.body.scrollHeight"))
    assert first < 800
    assert height < 8000
    show(browser, report, width=375)
    assert browser.execute_script(words) > 1.5 * first


def contrast(first: str, second: str) -> float:
    """Contrast ratio of two colours, WCAG 2.1."""

    def luminance(colour: str) -> float:
        parts = [int(part) / 255.0 for part in re.findall(r"\d+", colour)[:3]]
        red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_the_page_in_light_and_dark(browser, report, scheme):
    show(browser, report, width=1200, scheme=scheme)
    paper, *inks = browser.execute_script(
        "const colour = (query, what) => getComputedStyle(document.querySelector(query))[what];"
        "return [colour('body', 'backgroundColor'), colour('h1', 'color'), colour('figcaption', 'color'),"
        "colour('thead th', 'color'), colour('figure svg text', 'fill')]"
    )
    assert (contrast(paper, "rgb(0, 0, 0)") > 10) == (scheme == "light")
    assert all(contrast(paper, ink) > 4.5 for ink in inks)
