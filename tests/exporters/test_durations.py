"""Every duration that a mission file gives a mooring is in trials, plan, and what each format tells the vehicle."""

from dataclasses import asdict, replace

import pytest
from planned_missions import chesapeake

from missionplan.exporters import FORMATS, format_named
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.validation_errors import keys_of, parsers_of
from missionplan.montecarlo.distributions import mean_of
from missionplan.results.plan import PlannedMooring
from missionplan.studies.coverage import probability_holds
from missionplan.studies.export import mission_plan
from missionplan.studies.simulation.simulate import simulate_block

DURATIONS = tuple(
    key for key, field in keys_of(MoorPhase).items() if any(parser.unit == "s" for parser in parsers_of(field))
)
LONGER = 7200.0


OF_THE_WAY = {"elapsed", "east", "north", "latitude", "longitude"}
"""What a plan says of a mooring that depends on the transit before it."""


def lasting(mission, key, more):
    """The mission with a duration of its mooring that much longer."""
    return mission.with_({f"moor.{key}": mean_of(getattr(mission.moors[0], key)) + more})


@pytest.fixture(scope="module")
def plan():
    return mission_plan(chesapeake(), seed=1)


@pytest.fixture(scope="module", params=DURATIONS)
def later(request):
    """The plan of a mission whose mooring lasts longer by one of its durations."""
    return mission_plan(lasting(chesapeake(), request.param, LONGER), seed=1)


def test_what_follows_a_mooring_is_as_much_later_as_it_lasts_longer(plan, later):
    ends = [each.phases[-1].waypoints[-1].elapsed for each in (plan, later)]
    assert ends[1] - ends[0] == pytest.approx(LONGER)


@pytest.mark.parametrize("key", DURATIONS)
def test_a_trial_lasts_as_much_longer(key):
    still = chesapeake().with_({"site.current": []})  # in a current a vehicle adrift for longer comes down elsewhere
    blocks = (simulate_block(lasting(still, key, more), seed=1, block=0, trials=20) for more in (0.0, LONGER))
    before, after = (block.phases[1].quantities["duration_s"] for block in blocks)
    assert after - before == pytest.approx(LONGER)


@pytest.mark.parametrize("key", DURATIONS)
def test_equipment_is_said_to_fail_in_all_that_time(key):
    both = (lasting(chesapeake(), key, more) for more in (0.0, 20.0 * 3600.0))
    said = [next(row.why for row in probability_holds(each) if row.what == "equipment") for each in both]
    assert said[0] != said[1]


@pytest.mark.parametrize("to", FORMATS)
def test_every_format_tells_each_duration_or_says_that_it_cannot(plan, later, to):
    form = format_named(to)
    if to == "slocum":  # at the speed and depth of a glider
        gliding = (replace(phase, speed=0.3, depth=6.0) if phase in plan.transits else phase for phase in plan.phases)
        plan = replace(plan, phases=tuple(gliding))
    before, after = (asdict(each.moorings[0]) for each in (plan, later))
    differs = {name: value for name, value in after.items() if value != before[name] and name not in OF_THE_WAY}
    assert differs
    phases = (replace(each, **differs) if isinstance(each, PlannedMooring) else each for each in plan.phases)
    written, changed = (form.files(each, "plan") for each in (plan, replace(plan, phases=tuple(phases))))
    assert written != changed or any("mooring" in words for words in form.lost(plan)), f"{to} leaves out {differs}"
