"""`missionplan effects`."""

import sys

import pytest
import yaml

from missionplan.cli import main
from missionplan.effects import CATALOGUE
from missionplan.mission.sections import read_effects
from missionplan.report.effect_catalogue import effect_text, fragment


def run(monkeypatch, capsys, *arguments):
    monkeypatch.setattr(sys, "argv", ["missionplan", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    return stop.value.code or 0, capsys.readouterr()


def test_the_list_holds_every_effect_and_fits_a_terminal(monkeypatch, capsys):
    status, said = run(monkeypatch, capsys, "effects")
    assert status == 0
    assert set(CATALOGUE) <= {line.split()[0] for line in said.out.splitlines() if line and line[0] != " "}
    assert max(map(len, said.out.splitlines())) <= 80


def test_the_list_takes_a_line_an_effect_with_its_usual_size(monkeypatch, capsys):
    _, said = run(monkeypatch, capsys, "effects")
    lines = {line.split()[0]: line for line in said.out.splitlines() if line.strip()}
    assert len(said.out.splitlines()) < len(CATALOGUE) + 15
    assert "A current that is constant" in lines["mean-current"]
    assert lines["mean-current"].endswith("m/s")


def test_one_effect_is_shown_with_a_fragment(monkeypatch, capsys):
    status, said = run(monkeypatch, capsys, "effects", "compass-bias")
    assert status == 0
    for part in ("Usual sizes:", "Confused with:", "Distinguished by:", "From: missionplan.", "- compass-bias:"):
        assert part in said.out


def test_what_acts_on_readings_alone_is_said_to():
    """A delay of a log is one; nothing that moves the vehicle is."""
    words = "Acts on readings alone"
    assert words in effect_text(CATALOGUE["clock-offset"])
    assert words not in effect_text(CATALOGUE["compass-bias"])
    assert words not in effect_text(CATALOGUE["drag-bias"])


@pytest.mark.parametrize("info", CATALOGUE.values(), ids=lambda info: info.id)
def test_every_fragment_is_valid_in_a_mission(info):
    (entry,) = read_effects(yaml.safe_load(fragment(info))["effects"]).entries
    assert entry.effect == info.id
    assert set(entry.parameters) == set(info.parameters)


def test_a_misspelt_effect_gets_the_nearest(monkeypatch, capsys):
    status, said = run(monkeypatch, capsys, "effects", "compas-bias")
    assert status == 2
    assert "did you mean compass-bias?" in said.err
