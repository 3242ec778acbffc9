"""How reports and terminals are set: every text of every shipped example is scanned."""

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from missionplan.mission import load
from missionplan.report.render import render_report, terminal_view
from missionplan.report.wording import in_words, keys_in_words, typeset, wrapped
from missionplan.studies.anchor import size_anchor
from missionplan.studies.comparison import compare
from missionplan.studies.identification import identify
from missionplan.studies.leg_length import optimise_legs
from missionplan.studies.leg_length.analytic_transit import PolicyFamily
from missionplan.studies.leg_length.plan_legs import plan_legs
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation.simulate import simulate
from missionplan.studies.sweep_transition import sweep_transition

pytestmark = pytest.mark.usefixtures("drawn")

MISSIONS = Path(__file__).parents[2] / "missions"
UNITS = (
    r"(?:%|m|km|mm|cm|ft|nmi|s|min|h|day|days|N|kg|W|J|m/s|cm/s|kn|m²|m³|rev/s|°C|rad|deg|nats|kJ|rpm|Hz)(?![\w²³/-])"
)
FORBIDDEN = {
    "floating-point residue": r"\d\.\d{8,}|\d\.\d*(?:0{6}|9{6})\d",
    "a minus before zero": r"[−-]0(?:\.0+)?(?![\d.])",
    "a hyphen for a minus sign": r"(?<![\w.)\]\u2013\u202f/-])-\.?\d",
    "another spelling of a unit": r"\bk?Wh\b|W[·* ]h\b|\[(?:m|s|N|kg|m/s|W|rad|deg|°)\]|\^\d|\bdegC\b|\*\*",
    "a unit that may be torn from its number": rf"\d[ \n]{UNITS}",
    "a long number without thin spaces": r"(?<![\w.,:/=\u202f#-])\d{5,}(?![\w:/.-])|\d[,\u00a0]\d{3}(?!\d)",
    "a number in a computer's notation": r"\d[eE][+−-]?\d",
}
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
WITH_ERROR = re.compile(r"[\d\u202f]+(?:\.(\d+))?\s*±\s*([\d\u202f]+(?:\.(\d+))?)")


class Text(HTMLParser):
    """What a page says, in paragraphs, cells, figures and alternative texts; no listings."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.hidden, self.parts = 0, []
        self.feed(html)

    def handle_starttag(self, tag, attributes):
        self.hidden += tag in ("script", "style", "pre", "code")
        self.parts += [value for key, value in attributes if key in ("aria-label", "alt") and value]
        self.parts.append("\x00")

    def handle_endtag(self, tag):
        self.hidden -= tag in ("script", "style", "pre", "code")
        self.parts.append("\x00")

    def handle_data(self, data):
        if not self.hidden:
            self.parts.append(data)

    def blocks(self) -> list[str]:
        return [block.strip() for block in "".join(self.parts).split("\x00") if block.strip()]


def faults(text: str) -> Iterator[tuple[str, str]]:
    for name, pattern in FORBIDDEN.items():
        for found in re.finditer(pattern, text):
            yield name, text[max(found.start() - 30, 0) : found.end() + 20]
    for found in WITH_ERROR.finditer(text):
        decimals, error, error_decimals = found.groups()
        digits = error.replace("\u202f", "").replace(".", "").lstrip("0")
        if len(decimals or "") != len(error_decimals or "") or ("." in error and len(digits) > 2):
            yield "more digits than the error bears", found[0]


def said(result, page: str) -> Iterator[str]:
    """Every text of the page and of the terminal's view, each sentence as it is wrapped."""
    made = re.compile(r"\d{4}-\d\d-\d\dT|numpy")  # provenance: when, with which libraries
    yield from (block for block in Text(page).blocks() if not made.search(block))
    shown = terminal_view(result)
    yield wrapped(shown.sentence, 80)
    yield from shown.columns
    for row in shown.rows:
        yield from row
    yield from map(typeset, result.provenance.notices)


def check(result, page: str | None = None) -> None:
    page = page or render_report(result).html
    assert [fault for text in said(result, page) for fault in faults(text)] == []


def mission(name):
    return load(MISSIONS / f"{name}.yaml")


EXAMPLES = {
    "identify avila-drag": lambda: identify(MISSIONS / "measured" / "avila-drag"),
}
SLOW = {
    "plan-legs fig8": lambda: plan_legs(mission("fig8"), trials=300),
    "simulate chesapeake": lambda: simulate(mission("chesapeake"), trials=300),
    "sweep-dmax fig8": lambda: sweep_dmax(mission("fig8"), trials=300, method="monte-carlo"),
    "size-anchor anchor-design, worst case": lambda: size_anchor(mission("anchor-design"), trials=100),
    "simulate anchor-design": lambda: simulate(mission("anchor-design"), trials=300),
    "simulate fig8": lambda: simulate(mission("fig8"), trials=300),
    "simulate autosub-transition": lambda: simulate(mission("autosub-transition"), trials=40),
    "sweep-dmax chesapeake": lambda: sweep_dmax(mission("chesapeake"), trials=300),
    "identify avila-added-mass": lambda: identify(MISSIONS / "measured" / "avila-added-mass"),
    "size-anchor anchor-design": lambda: size_anchor(mission("anchor-design"), trials=300, probability=0.9),
    "size-anchor chesapeake": lambda: size_anchor(mission("chesapeake"), trials=300),
    "sweep-transition": lambda: sweep_transition(mission("autosub-transition"), time_step=0.5),
    "plan-legs chesapeake, for a deadline": lambda: plan_legs(mission("chesapeake"), aim="p95", trials=300),
}


@pytest.mark.parametrize(
    "run", [*EXAMPLES.values(), *(pytest.param(run, marks=pytest.mark.slow) for run in SLOW.values())],
    ids=[*EXAMPLES, *SLOW],
)  # fmt: skip
def test_every_text_of_the_example_is_set_alike(run, monkeypatch):
    monkeypatch.setattr(optimise_legs, "MEAN_FAMILY", PolicyFamily((1.0,), ()))  # which legs does not matter here
    check(run())


@pytest.mark.parametrize("name", ["simulated", "planned", "swept", "sized"])
def test_every_text_of_a_saved_page_is_set_alike(name, request):
    saved = request.getfixturevalue(name)
    check(saved.result, saved.page.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_a_comparison_is_set_alike(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the page names the reports as they were given: a path is not set
    for name, trials in (("chesapeake", 300), ("fig8", 200)):
        simulate(mission(name), trials=trials).save(Path(name))
    check(compare(Path("chesapeake"), Path("fig8")))


@pytest.mark.slow
def test_a_diagnosis_is_set_alike(tmp_path, monkeypatch):
    from missionplan.diagnosis.diagnose import diagnose
    from missionplan.studies.init import init

    monkeypatch.chdir(tmp_path)
    init(tmp_path)
    check(diagnose(load(Path("mission.yaml")), Path("sea-trial")))


@pytest.mark.parametrize(
    ("given_text", "expected"),
    [
        ("ln BF -2.4", "ln BF −2.4"),
        ("13.4 Wh of 45 W*h", "13.4\u00a0W\u202fh of 45\u00a0W\u202fh"),
        ("angle [deg], depth [m]", "angle (°), depth (m)"),
        ("drag of −0.00 N", "drag of 0.00\u00a0N"),
        ("−0.005 and -0.05", "−0.005 and −0.05"),
        ("of 10000 trials", "of 10\u202f000 trials"),
        ("3 ± 0.4 s", "3\u00a0±\u00a00.4\u00a0s"),
        ("2 m/s^2 and 3 kg/m^3", "2\u00a0m/s² and 3\u00a0kg/m³"),
        ("mission-2, 2026-11-22, layer 2 is", "mission-2, 2026-11-22, layer 2 is"),
        ("1-2 km", "1-2\u00a0km"),
        ("1.35e-6 m^2/s, 2e+06 s", "1.35·10⁻⁶\u00a0m²/s, 2·10⁶\u00a0s"),
        ("15 deg at 11:30 UTC", "15° at 11:30\u00a0UTC"),
        ("2.9 ° ± 0.3 °, 4 °C", "2.9°\u00a0±\u00a00.3°, 4\u00a0°C"),
        ("reports/a/simulate-20261122T190000Z", "reports/a/simulate-20261122T190000Z"),
    ],
)
def test_text_is_set(given_text, expected):
    assert typeset(given_text) == expected


@example("--0")
@given(st.text(alphabet="0123456789 .-−±mskWhNe[]()^23,\u00a0", max_size=40))
def test_setting_text_twice_changes_nothing_and_no_digit_is_lost(text):
    once = typeset(text)
    assert typeset(once) == once
    powers = re.sub(r"(?<=\d)e[-+−]0*(\d+)(?![\w.])", r"·10\1", text)
    assert re.sub(r"\D", "", once.translate(RAISED)) == re.sub(r"\D", "", powers.translate(RAISED))


def test_lines_break_at_ordinary_spaces_alone():
    lines = wrapped(typeset("The anchor of 11.7 N wet lies 20 m from the last fix in 97.9 ± 0.3 % of the dives"), 24)
    for line in lines.splitlines()[1:]:
        assert not re.match(r"[N m%±]\b|±|%", line)
    assert all(len(line) <= 24 for line in lines.splitlines())


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("ingress.fix_error.along", "error of the fix along the track (ingress)"),
        ("egress.velocity_error.across", "velocity error across the track (egress)"),
        ("ingress.arrived", "arrival (ingress)"),
        ("site.current[1].speed", "current speed in layer 2"),
        ("navigation.surfacing_time", "surfacing time"),
        ("within_radius", "anchor within the radius"),
        ("moor.within_radius", "anchor within the radius (moor)"),
        ("total.success", "success of the mission"),
        ("moor.release_time", "release time (moor)"),
    ],
)
def test_names_of_quantities_read_as_phrases(name, words):
    assert in_words(name) == words


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        (["start"], "start"),
        (["ingress.speed"], "speed (ingress)"),
        (["ingress.speed", "egress.speed"], "speed (ingress, egress)"),
        (["ingress.speed", "egress.d_max"], "speed (ingress) and maximum leg length (egress)"),
        (["start", "ingress.speed"], "start and speed (ingress)"),
    ],
)
def test_keys_that_take_the_same_value_are_named_once(keys, words):
    assert keys_in_words(keys) == words
