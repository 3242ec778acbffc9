"""What the catalogue refuses, and that a plug-in which fails does no harm."""

from dataclasses import dataclass, replace

import pytest

from missionplan.effects import (
    CATALOGUE,
    EffectInfo,
    Parameter,
    TankEffect,
    catalogue_problems,
    entry_problems,
    with_plugins,
)
from missionplan.effects.info import Instrument, Likeness
from missionplan.phases.hooks import TransitEffect


@dataclass(frozen=True)
class Wake(TransitEffect):
    """Another vehicle's wake."""

    strength: float = 0.0


@dataclass(frozen=True)
class Gusts(Wake):
    """An effect that draws normals for each leg."""

    is_random = True


@dataclass(frozen=True)
class Paint(TankEffect):
    """An effect in a tank that refines no hook."""

    strength: float = 0.0


WAKE = EffectInfo(
    id="wake",
    effect=Wake,
    parameters={"strength": Parameter("m/s", "push", 0.0, 1.0, scale=0.1, spike=0.001)},
    what="A ship passes.",
    sizes="Decimetres a second.",
    confused_with=(),
    distinguished_by="AIS.",
)
SHAPED = {"strength": Parameter("m/s", "push", 0.0, 1.0, median=0.1, factor=2.0)}
OWN = tuple(CATALOGUE.values())


class Plugin:
    """An entry point that loads what it is given, or raises it."""

    dist = None

    def __init__(self, name, loaded):
        self.name, self.loaded = name, loaded

    def load(self):
        if isinstance(self.loaded, Exception):
            raise self.loaded
        return self.loaded


def test_the_projects_own_entries_are_in_order():
    assert [problem for info in OWN for problem in entry_problems(info)] == []
    assert catalogue_problems(OWN) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"effect": object}, "derived from TransitEffect or DescentEffect or TankEffect"),
        ({"parameters": {"width": WAKE.parameters["strength"]}}, "has no field width"),
        ({"parameters": {"strength": Parameter("m/s", "push")}}, "declare scale and spike"),
        ({"parameters": {"strength": Parameter("m/s", "push", 1.0, 1.0, scale=1.0, spike=0.1)}}, "low must be below"),
        ({"parameters": {"strength": Parameter("m/s", "push", median=0.1)}}, "needs a factor above 1"),
        ({"polar": (("strength", "phase"),)}, "phase is no parameter"),
        ({"is_modulated": True}, "needs an effect derived from Oscillation"),
        ({"instrument": Instrument("a log", "speed", 0.1)}, "speed is no parameter"),
        ({"likeness": Likeness("speed", 0.1, "like a log")}, "likeness: speed is no parameter"),
        ({"effect": Gusts}, 'must declare part="covariance"'),
        ({"part": "covariance"}, "needs a median and a factor"),
        ({"part": "covariance", "parameters": SHAPED}, "refine fix_variance, position_variance_rate or tail_dof"),
        ({"tank": ("flume",)}, "flume is none of drag, free-oscillation, thruster, propeller-transient"),
        ({"tank": ("thruster",)}, "an effect of phase transit acts through no hook"),
        ({"effect": Paint}, "name the kinds of tank data"),
        ({"effect": Paint, "tank": ("drag",)}, "acts through drag_factor"),
        ({"vehicle_key": "drag.coefficient"}, "drag.coefficient holds one parameter that tank data show"),
    ],
)
def test_an_entry_that_declares_too_little_is_refused_with_words(change, words):
    assert any(words in problem for problem in entry_problems(replace(WAKE, **change)))


def test_two_processes_that_may_act_together_are_refused():
    walk = replace(CATALOGUE["random-walk"], id="another-walk", exclusive_group="")
    (problem,) = catalogue_problems([*OWN, walk])
    assert "another-walk (no group)" in problem
    assert "exclusive_group" in problem
    assert catalogue_problems([*OWN, replace(walk, exclusive_group=CATALOGUE["random-walk"].exclusive_group)]) == []


def test_a_name_declared_twice_is_refused():
    assert catalogue_problems([*OWN, replace(WAKE, id="mean-current")]) == ["mean-current is declared twice"]


def test_a_key_of_the_vehicle_is_filled_by_one_effect():
    rough = replace(CATALOGUE["drag-bias"], id="roughness", scatter="")
    (problem,) = catalogue_problems([*OWN, rough])
    assert problem == "vehicle_key 'drag.coefficient': declared by drag-bias, roughness, expected one effect"


def test_a_plugin_that_works_is_added_and_those_that_fail_do_no_harm():
    plugins = [
        Plugin("broken", ImportError("no module named sonar")),
        Plugin("nothing", 3),
        Plugin("thin", replace(WAKE, parameters={"strength": Parameter("m/s", "push")})),
        Plugin("again", replace(WAKE, id="mean-current")),
        Plugin("wakes", WAKE),
    ]
    found = with_plugins(OWN, plugins)
    assert list(found.entries) == [*CATALOGUE, "wake"]
    assert found.origins["wake"] == "wakes"
    assert found.origins["mean-current"] == "missionplan"
    assert set(found.failed) == {"broken", "nothing", "thin", "again"}
    assert found.failed["broken"] == "ImportError: no module named sonar"


def test_own_entries_that_cannot_stand_together_are_an_error():
    with pytest.raises(ValueError, match="declared twice"):
        with_plugins([*OWN, OWN[0]], [])
