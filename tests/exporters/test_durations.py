"""Every duration that a mission file gives a mooring is in trials, plan, and what each format tells the vehicle."""

from dataclasses import replace

import pytest
from planned_missions import chesapeake

from missionplan.exporters.formats import FORMATS, format_named
from missionplan.mission.reading.validation_errors import keys_of, parsers_of
from missionplan.mission.schema.phases import MoorPhase
from missionplan.montecarlo.distributions import mean_of
from missionplan.results.plan import PlannedMooring
from missionplan.studies.coverage import probability_holds
from missionplan.studies.export import mission_plan
from missionplan.studies.simulation.simulate import simulate_block

DURATIONS = tuple(
    key for key, field in keys_of(MoorPhase).items() if any(parser.unit == "s" for parser in parsers_of(field))
)
LONGER = 7200.0


@pytest.fixture(scope="module")
def plan():
    return mission_plan(chesapeake(), seed=1)


@pytest.mark.parametrize("key", DURATIONS)
def test_what_follows_a_mooring_is_as_much_later_as_it_lasts_longer(plan, key):
    mission = chesapeake()
    lasts = mean_of(getattr(mission.moors[0], key)) + LONGER
    later = mission_plan(mission.with_({f"moor.{key}": lasts}), seed=1)
    ends = [each.phases[-1].waypoints[-1].elapsed for each in (plan, later)]
    assert ends[1] - ends[0] == pytest.approx(LONGER)


@pytest.mark.parametrize("key", DURATIONS)
def test_a_trial_lasts_as_much_longer(key):
    still = chesapeake().with_({"site.current": []})  # in a current a vehicle adrift for longer comes down elsewhere
    longer = still.with_({f"moor.{key}": mean_of(getattr(still.moors[0], key)) + LONGER})
    plain = still.with_({f"moor.{key}": mean_of(getattr(still.moors[0], key))})
    blocks = (simulate_block(each, seed=1, block=0, trials=20) for each in (plain, longer))
    before, after = (block.phases[1].quantities["duration_s"] for block in blocks)
    assert after - before == pytest.approx(LONGER)


@pytest.mark.parametrize("key", DURATIONS)
def test_equipment_is_said_to_fail_in_all_that_time(key):
    mission = chesapeake()
    longer = mission.with_({f"moor.{key}": mean_of(getattr(mission.moors[0], key)) + 20.0 * 3600.0})
    said = [next(row.why for row in probability_holds(each) if row.what == "equipment") for each in (mission, longer)]
    assert said[0] != said[1]


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("key", DURATIONS)
def test_every_format_tells_each_duration_or_says_that_it_cannot(plan, key, to):
    form = format_named(to)
    if to == "slocum":  # at the speed and depth of a glider
        gliding = (replace(phase, speed=0.3, depth=6.0) if phase in plan.transits else phase for phase in plan.phases)
        plan = replace(plan, phases=tuple(gliding))
    longer = replace(
        plan,
        phases=tuple(
            replace(phase, **{key: getattr(phase, key) + LONGER}) if isinstance(phase, PlannedMooring) else phase
            for phase in plan.phases
        ),
    )
    written, changed = (form.files(each, "plan") for each in (plan, longer))
    assert written != changed or any("mooring" in words for words in form.lost(plan)), f"{to} leaves out {key}"
