"""Reports on paper, printed by a real browser: pages, what stands alone on them, what is cut off."""

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
from browsing import needs_browser, printed, show

from missionplan.mission import load
from missionplan.report.page import Drawn, drawing_by
from missionplan.studies.comparison import compare
from missionplan.studies.simulation.simulate import simulate

MISSIONS = Path(__file__).parents[2] / "missions"
PDFTOTEXT = shutil.which("pdftotext")
pytestmark = [
    needs_browser,
    pytest.mark.skipif(not PDFTOTEXT, reason="needs pdftotext (poppler-utils)"),
]
WORD = re.compile(r'<word xMin="([\d.-]+)" yMin="([\d.-]+)" xMax="([\d.-]+)" yMax="([\d.-]+)">(.*?)</word>')


@dataclass(frozen=True)
class Paper:
    """A printed page: its size, and its words with their boxes (left, top, right, bottom) [pt]."""

    width: float
    height: float
    words: list[tuple[float, float, float, float, str]]

    @property
    def filled(self) -> float:
        return max((bottom for _, _, _, bottom, _ in self.words), default=0.0) / self.height


@pytest.fixture(scope="module")
def compared(simulated, saved, tmp_path_factory):
    with drawing_by(lambda figure, shown: Drawn("<svg/>")):
        other = simulate(load(MISSIONS / "chesapeake.yaml"), trials=200, seed=2)
        again = other.save(tmp_path_factory.mktemp("paper") / "again")
    return saved(compare(simulated.page.parent, again))


@pytest.fixture
def report(request) -> Path:
    return request.getfixturevalue(request.param).page


def paper(browser, tmp_path) -> list[Paper]:
    """Print the page that is open, and read its pages."""
    (tmp_path / "page.pdf").write_bytes(printed(browser))
    subprocess.run([PDFTOTEXT, "-bbox", "page.pdf", "page.html"], cwd=tmp_path, check=True)
    pages = []
    for page in (tmp_path / "page.html").read_text().split("<page ")[1:]:
        width, height = (float(size) for size in re.findall(r'(?:width|height)="([\d.]+)"', page)[:2])
        words = [(*map(float, found[:4]), found[4]) for found in WORD.findall(page)]
        pages.append(Paper(width, height, words))
    return pages


@pytest.mark.parametrize("report", ["simulated", "swept", "sized", "compared"], indirect=True)
def test_a_report_prints_well(browser, report, tmp_path):
    show(browser, report, width=1280, unfolded=False)
    has_sheet = browser.execute_script("return document.querySelectorAll('.sheet').length") == 1
    headings = browser.execute_script("return [...document.querySelectorAll('h2')].map(each => each.textContent)")
    pages = paper(browser, tmp_path)
    assert len(pages) <= (8 if has_sheet else 6)
    for page in pages:
        assert all(left > 20.0 and right < page.width - 20.0 for left, _, right, _, _ in page.words)
        assert len(page.words) > 40
    # the sheet is a page of its own: the one before it may end early, as the last may
    assert all(page.filled > 0.5 for page in pages[: len(pages) - 1 - has_sheet])
    for page in pages:
        lowest = max(word[1] for word in page.words)
        last = " ".join(word[4] for word in page.words if word[1] > lowest - 2.0)
        assert [heading for heading in headings if heading.endswith(last)] == [], last


@pytest.mark.parametrize("report", ["simulated", "swept", "sized"], indirect=True)
def test_the_summary_is_two_pages(browser, report, tmp_path):
    show(browser, report, width=1280, unfolded=False)
    browser.execute_script("document.querySelector('.details').remove()")
    pages = paper(browser, tmp_path)
    assert len(pages) <= 2
    words = " ".join(word[4] for page in pages for word in page.words)
    assert "identity" in words
    assert "Made 20" in words


def test_the_sheet_for_the_boat_is_one_page(browser, simulated, tmp_path):
    show(browser, simulated.page, width=1280, unfolded=False)
    browser.execute_script(
        "const sheet = document.querySelector('.sheet');document.querySelector('main').replaceChildren(sheet);"
    )
    assert browser.execute_script("return document.querySelectorAll('.sheet table').length") == 2
    assert len(paper(browser, tmp_path)) == 1


def test_a_figure_is_as_wide_as_the_page_or_as_high_as_fits_and_its_text_has_8_pt(browser, simulated):
    show(browser, simulated.page, width=1280, unfolded=False)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        found = browser.execute_script(
            "return [...document.querySelectorAll('figure svg')].map(svg => {"
            " const box = svg.getBoundingClientRect(), scale = box.width / svg.viewBox.baseVal.width;"
            " const text = svg.querySelector('text');"
            " return [box.width, box.height, scale * parseFloat(getComputedStyle(text).fontSize)]; })"
        )
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    millimetre, point = 96.0 / 25.4, 96.0 / 72.0
    assert found
    for width, height, text in found:
        assert text == pytest.approx(8.0 * point, rel=0.01)
        assert width == pytest.approx(180.0 * millimetre, rel=0.01) or height > 74.0 * millimetre
