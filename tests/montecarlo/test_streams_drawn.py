"""Who draws from which stream: every random quantity from its own, once, and no two quantities from one."""

import copy
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.mission.mission import with_values
from missionplan.mission.schema.site import LeewaySection
from missionplan.montecarlo.streams import BLOCK, BlockStreams
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import STREAM, recorded_current
from missionplan.studies.simulation.trial_block import run_trials

MISSIONS = Path(__file__).parents[2] / "missions"
TRIALS = 256
UNCERTAIN = {
    "vehicle.mass": {"mean": "10.2 kg", "sd": "0.1 kg"},
    "vehicle.net_buoyancy": {"mean": "0.9 N", "sd": "0.05 N"},
    "vehicle.anchor.drag_coefficient": {"mean": 0.2, "sd": 0.02},
    "site.depth": {"mean": "12.2 m", "sd": "0.2 m"},
    "navigation.velocity_error.sigma": {"mean": "0.035 m/s", "sd": "0.004 m/s"},
    "navigation.surfacing_time": {"mean": "90 s", "sd": "9 s"},
    "navigation.fix_error": {"mean": "3 m", "sd": "0.3 m"},
    "ingress.speed": {"mean": "1.5 m/s", "sd": "0.03 m/s"},
    "egress.depth": {"mean": "2 m", "sd": "0.1 m"},
    "moor.anchor_wet_weight": {"mean": "11.8 N", "sd": "0.2 N"},
    "moor.line_length": {"mean": "5 m", "sd": "0.1 m"},
    "moor.hold": {"mean": "20 min", "sd": "1 min"},
}
"""Besides those of the mission itself."""
OF_LEGS = ("velocity_error", "fix_on_surfacing", "fix_on_diving")


@pytest.fixture(scope="module")
def means():
    data = missionplan.load(MISSIONS / "chesapeake.yaml").raw
    data = with_values(data, UNCERTAIN)
    data["vehicle"]["anchor"]["premature_flooding"] = 0.1
    data["effects"] = [{"persistent-error": {"sigma": "0.02 m/s", "time": "600 s"}}]
    return Scenario.at_means(Mission.from_data(data))


class Recorded:
    """Streams that keep count of who draws; those of some names are silent, or of another seed."""

    def __init__(self, seed=1, heard=None, other=()):
        self.seed, self.heard, self.other, self.names = seed, heard, other, []

    def _source(self, name):
        return BlockStreams(self.seed + (name in self.other), 0)

    def once(self, name):
        self.names.append(name)
        return self._source(name).once(name) * (self.heard is None or name in self.heard)

    def legs(self, name):
        self.names.append(name)
        return Legs(self._source(name).legs(name), self.heard is None or name in self.heard)


class Legs:
    def __init__(self, normals, heard):
        self.normals, self.heard = normals, heard

    def leg(self, number):
        return self.normals.leg(number) * self.heard


def uncertain(means):
    return tuple(means.sampled(seed=1, block=0, size=1).draws)


def ran(means, trials=TRIALS, **how):
    source = Recorded(**how)
    return run_trials(means.sampled_from(source, trials), source, trials, inputs=False), source.names


def test_every_quantity_has_a_stream_of_its_own_and_is_drawn_once(means):
    trials, names = ran(means)
    own = ["moor.fix", "moor.premature_flooding", "ingress.fix_at_start"]
    legs = [f"{phase}.{each}" for phase in ("ingress", "egress") for each in (*OF_LEGS, "effects.persistent-error")]
    assert sorted(names) == sorted([*trials.draws, *own, *legs])
    assert set(trials.draws) > set(UNCERTAIN)


@pytest.fixture(scope="module")
def silent(means):
    return everything(ran(means, heard=())[0])


def everything(trials):
    failures = {
        f"{phase.name} failed: {why}": flags for phase in trials.phases for why, flags in phase.failures.items()
    }
    return {**trials.columns(), **failures}


def changed(one, other):
    return {name for name in one if not np.array_equal(one[name], other[name], equal_nan=one[name].dtype != bool)}


ALONE = [
    *[f"{phase}.{each}" for phase in ("ingress", "egress") for each in (*OF_LEGS, "effects.persistent-error")],
    *["moor.fix", "moor.premature_flooding", "ingress.fix_at_start", "moor.release_time", "moor.hold", "site.depth"],
    *["ingress.speed", "navigation.fix_error", "site.current[1].speed"],
]


@pytest.mark.parametrize("name", ALONE)
def test_a_stream_moves_what_is_its_own_and_what_comes_after(means, silent, name):
    """All others being silent: its own quantity and no other, nothing before its phase, and no anchor but by its own."""
    moved = changed(everything(ran(means, heard=(name,))[0]), silent)
    assert moved & set(uncertain(means)) == {name} & set(uncertain(means))
    phases = {"ingress": ("egress.", "moor.", "ingress."), "moor": ("egress.", "moor."), "egress": ("egress.",)}
    after = phases.get(name.split(".")[0], phases["ingress"])
    assert all(each.startswith((*after, "total.", name)) or each.split()[0] + "." in after for each in moved)
    assert (moved - {name} == set()) is (name == "navigation.fix_error")
    flooded = {each for each in moved if "flooded" in each}
    assert bool(flooded) is (name == "moor.premature_flooding")
    assert ("moor.release_time_s" in moved) is (name in ("moor.release_time", "moor.premature_flooding"))
    assert not (name == "moor.fix" and any(each.startswith("moor") for each in moved)), "the anchor is down by then"


def test_draws_are_uncorrelated(means):
    """All pairs of drawn quantities; and which anchors flood, with every normal that is drawn besides."""
    values = np.stack(list(means.sampled_from(Recorded(), BLOCK).draws.values()))
    apart = np.corrcoef(values)[~np.eye(len(values), dtype=bool)]
    assert np.abs(apart).max() < 5.0 / np.sqrt(BLOCK)
    trials, names = ran(means)
    flooded = trials.phases[1].failures["anchor flooded before its release"]
    assert 0.04 < flooded.mean() < 0.18
    source = BlockStreams(1, 0)
    for name in set(names) - {"moor.premature_flooding"}:
        normals = source.once(name)[:TRIALS] if name in uncertain(means) else source.legs(name).leg(0)[0, :TRIALS]
        assert abs(np.corrcoef(flooded, normals)[0, 1]) < 5.0 / np.sqrt(TRIALS), name


FORECAST = {
    "site.current": {
        "file": "current.csv",
        "outside": "hold",
        "error": {
            "sigma": {"median": "0.05 m/s", "factor": 1.5},
            "time": {"median": "2 h", "factor": 1.3},
            "length": {"median": "2 km", "factor": 1.3},
        },
    }
}
EQUIPMENT = {
    "vehicle.reliability": [{"per": "hour", "rate": {"mean": "0.2 1/h", "sd": "0.02 1/h"}}],
    "site.wind": {"speed": {"mean": "8 m/s", "sd": "1 m/s"}, "from": {"low": "150 deg", "high": "210 deg"}},
    "effects": [{"compass-bias": {"angle": {"mean": "0 deg", "sd": "1 deg"}}}],
}


@pytest.mark.parametrize("changes", [EQUIPMENT, FORECAST], ids=["layers", "forecast"])
def test_a_trial_is_the_mission_with_its_draws_written_in(changes, tmp_path):
    """Whatever is uncertain acts in a trial by its value there; without what the vehicle's plan knows of the means."""
    (tmp_path / "current.csv").write_text("t_s,depth_m,east_m_s,north_m_s\n0,0,0.1,0.1\n20000,0,-0.1,0.2\n")
    data = with_values(missionplan.load(MISSIONS / "chesapeake.yaml").raw, copy.deepcopy(UNCERTAIN | changes))
    if "file" in data["site"]["current"]:
        data["site"]["current"]["file"] = str(tmp_path / "current.csv")
    else:
        data["site"]["current"][1]["down_to"] = "20 m"  # below the seafloor of any trial
    data["navigation"]["drift_compensation"] = "last-leg"
    mission, trial = Mission.from_data(data), 5
    means = Scenario.at_means(mission, recorded_current(mission))
    drawn, _ = ran(means, trial + 1)
    assert set(drawn.draws) == set(mission.uncertain())
    written = mission.with_({key: float(values[trial]) for key, values in drawn.draws.items()})
    alone, _ = ran(Scenario.at_means(written, recorded_current(written)), trial + 1)
    for name, values in everything(alone).items():
        assert values[trial] == pytest.approx(everything(drawn)[name][trial], rel=3e-3, nan_ok=True), name


def straight(d_max):
    """2 km to the north in still water, with the mission's own errors."""
    way = {"name": "way", "from": ["0 m", "0 m"], "to": ["0 m", "2 km"], "speed": "2 m/s", "arrival_radius": "500 m"}
    return Scenario.at_means(
        Mission.from_data(
            {
                "navigation": {
                    "velocity_error": {"sigma": "0.05 m/s"},
                    "surfacing_time": "60 s",
                    "fix_error": "4 m",
                    "drift_compensation": "none",
                },
                "phases": [{"transit": {**way, "d_max": d_max}}],
            }
        )
    )


@pytest.mark.parametrize(
    ("d_max", "name", "size", "leg"),
    [
        ("3 km", "velocity_error", 0.05 * 1000.0, 0),
        ("3 km", "fix_at_start", -4.0, 0),
        ("3 km", "fix_on_surfacing", 0.0, 0),
        ("3 km", "fix_on_diving", 0.0, 0),
        ("1.2 km", "velocity_error", 0.05 * 400.0, 1),
        ("1.2 km", "fix_at_start", 0.0, 0),
        ("1.2 km", "fix_on_diving", -4.0, 0),
    ],
)
def test_the_last_leg_misses_by_its_own_error_and_that_of_the_fix_before_it(d_max, name, size, leg):
    trials, _ = ran(straight(d_max), heard=(f"way.{name}",))
    expected = size * BlockStreams(1, 0).legs(f"way.{name}").leg(leg)[:, :TRIALS]
    assert trials.phases[0].miss == pytest.approx(expected, rel=0.2, abs=0.5)  # the second leg is as long as is left


def test_the_scatter_and_the_side_of_leeway_are_each_trial_s_own_normals():
    """Along and across the wind the first leg's two normals of its stream, and the side by the sign of the second's."""
    data = missionplan.load(MISSIONS / "chesapeake.yaml").raw
    wind = {"speed": "8 m/s", "from": "180 deg"}  # blows toward north
    scenario = Scenario.at_means(Mission.from_data(with_values(data, {"site.wind": wind})))
    blown = scenario.sampled(seed=1, block=0, size=TRIALS).leeway
    east, north = blown.surface_velocity(np.zeros(TRIALS), np.zeros(TRIALS), np.zeros((2, TRIALS)))
    stream = BlockStreams(1, 0).legs(STREAM)
    along, across = stream.leg(0)[:, :TRIALS]
    section = LeewaySection()
    assert north == pytest.approx(section.downwind * 8.0 + section.downwind_offset + section.scatter * along)
    side = np.sign(stream.leg(1)[0, :TRIALS])
    assert east == pytest.approx(side * section.crosswind * 8.0 + section.scatter * across)
    assert abs(np.corrcoef(side, across)[0, 1]) < 5.0 / np.sqrt(TRIALS)
