"""Checked views: everything that is missing at once, and phases by name."""

from collections.abc import Callable
from pathlib import Path

import pytest

from missionplan import load
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.views import MooringMission, TransitionMission, navigation_of, required_origin, transit_of

MISSIONS = Path(__file__).parents[2] / "missions"


def keys_of(view: Callable[[Mission], object], mission: Mission) -> list[str]:
    with pytest.raises(InputError) as caught:
        view(mission)
    return [problem.key for problem in caught.value.problems]


def test_a_view_holds_the_sections_of_a_shipped_mission() -> None:
    mission = load(MISSIONS / "chesapeake.yaml")
    moorings = MooringMission.of(mission)
    assert navigation_of(mission) is mission.navigation
    assert moorings.anchor is mission.vehicle.anchor
    assert transit_of(mission) is mission.phases[0]
    assert transit_of(mission, "egress") is mission.phases[2]
    assert moorings.mooring("moor") is mission.phases[1]


def test_everything_missing_is_listed() -> None:
    fig8 = load(MISSIONS / "fig8.yaml")
    needed = ["phases", "site.depth", "site.water", "vehicle", "vehicle.mass", "vehicle.anchor"]
    assert keys_of(MooringMission.of, fig8) == needed
    assert keys_of(TransitionMission.of, fig8) == [
        "phases",
        "site.water",
        *needed[3:4],
        "vehicle.manoeuvring",
        needed[4],
    ]
    assert keys_of(navigation_of, Mission()) == ["phases", "navigation"]


def test_data_of_dives_bring_their_own_depth() -> None:
    mission = load(MISSIONS / "anchor-design.yaml")
    bare = mission.model_copy(update={"site": mission.site.model_copy(update={"depth": None})})
    assert keys_of(MooringMission.of, bare) == ["site.depth"]
    assert MooringMission.of(bare, depth=False).site.depth is None


def test_an_anchor_needs_a_construction_or_a_flooded_mass() -> None:
    mission = load(MISSIONS / "chesapeake.yaml")
    anchor = mission.vehicle.anchor.model_copy(update={"construction": None, "flooded_mass": None})
    bare = mission.model_copy(update={"vehicle": mission.vehicle.model_copy(update={"anchor": anchor})})
    assert keys_of(MooringMission.of, bare) == ["vehicle.anchor.flooded_mass"]


def test_a_phase_that_is_not_there() -> None:
    moorings = MooringMission.of(load(MISSIONS / "chesapeake.yaml"))
    with pytest.raises(InputError, match="phase: given 'egress', expected a mooring: moor"):
        moorings.mooring("egress")


def test_a_missing_origin_says_what_it_is_needed_for() -> None:
    with pytest.raises(InputError, match=r"site\.origin: missing; a map needs it"):
        required_origin(Mission(), "a map needs it")
