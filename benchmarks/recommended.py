"""Recommendations against brute force: ``python -m benchmarks.recommended``.

`size-anchor`: the lightest of up to 350 wet weights, a fiftieth apart, that meets everything asked of the dive, on 40
random missions. `optimise`: the least energy of every choice of a fine lattice, each with 4096 trials of another seed,
on 12 missions and 5 seeds. About ten minutes of one core.
"""

import argparse
import copy
import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

import missionplan
from benchmarks.common import MISSIONS, duration
from missionplan.mission import Mission
from missionplan.montecarlo.alternatives import paired_difference
from missionplan.montecarlo.blocks import IN_THIS_PROCESS
from missionplan.montecarlo.streams import BlockStreams, stream
from missionplan.phases.hooks import TrialState
from missionplan.results.anchor_sizing import ProbableAnchor
from missionplan.results.failures import Counted
from missionplan.scenario.anchors import laden, worst_case_weight
from missionplan.scenario.phases import start_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor.sizing import AnchorSizer, AnchorTrials
from missionplan.studies.exploration import read_axes
from missionplan.studies.exploration.cells import CellTask, CellTrials, cell_trials
from missionplan.studies.exploration.result import cell_of
from missionplan.studies.optimisation.evaluations import columns_needed
from missionplan.studies.simulation.block_statistics import requirement_flags
from missionplan.studies.simulation.mooring_trials import mooring_trials
from missionplan.studies.simulation.phase_trials import TrialBlock

DIVES = 40
"""Of each anchor."""
APART = 1.02
"""Ratio of neighbouring wet weights of the brute force."""


# The lightest anchor.


@dataclass(frozen=True)
class _Tiled:
    """The first normals of a block, over and over: each anchor has the same draws."""

    source: BlockStreams
    times: int

    def once(self, quantity: str) -> np.ndarray:
        return np.tile(self.source.once(quantity)[:DIVES], self.times)

    def legs(self, quantity: str) -> "_TiledLegs":
        return _TiledLegs(self, quantity)


@dataclass(frozen=True)
class _TiledLegs:
    tiled: _Tiled
    quantity: str

    def leg(self, number: int) -> np.ndarray:
        return np.tile(self.tiled.source.legs(self.quantity).leg(number)[:, :DIVES], self.tiled.times)


def anchor_mission(number: int) -> Mission:
    """Return a mission whose currents, depth, line, seafloor and requirements are drawn at random."""
    rng = np.random.default_rng([45, number])
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "anchor-design.yaml").raw))
    depth, speed = rng.uniform(15.0, 60.0), rng.uniform(0.1, 0.9)
    layers = [
        {
            "down_to": f"{share * depth:.3f} m",
            "speed": {"mean": f"{speed * factor:.3f} m/s", "sd": f"{rng.uniform(0.05, 0.25) * speed:.3f} m/s"},
            "toward": f"{rng.uniform(0.0, 360.0):.0f} deg",
        }
        for share, factor in ((0.5, 1.0), (1.0, rng.uniform(0.5, 1.0)))
    ]
    data["site"] |= {"depth": f"{depth:.3f} m", "current": layers}
    low = rng.uniform(0.1, 1.2)
    data["vehicle"]["anchor"] |= {"holding_factor": {"low": low, "high": 1.6 * low}}
    moor = data["phases"][0]["moor"]
    moor["line_length"] = f"{rng.uniform(3.0, 9.0):.2f} m"
    moor["radius"] = f"{rng.uniform(0.25, 1.0) * speed * depth / 1.4:.2f} m"
    moor.pop("design_current")
    possible = [
        {"quantity": "moor.within_radius", "probability": rng.uniform(0.7, 0.97)},
        {"quantity": "moor.anchor_holds", "probability": rng.uniform(0.7, 0.97)},
        {
            "quantity": "moor.lowest_altitude",
            "at_least": f"{rng.uniform(0.1, 2.0):.2f} m",
            "probability": rng.uniform(0.7, 0.95),
        },
        {
            "quantity": "moor.touchdown_speed",
            "at_most": f"{rng.uniform(1.4, 2.4):.2f} m/s",
            "probability": rng.uniform(0.7, 0.95),
        },
        {
            "quantity": "moor.nose_altitude",
            "at_least": f"{rng.uniform(0.2, 1.0):.2f} m",
            "probability": rng.uniform(0.6, 0.9),
        },
        {"quantity": "total.success", "probability": rng.uniform(0.6, 0.95)},
    ]
    chosen = rng.choice(len(possible), size=int(rng.integers(1, 4)), replace=False)
    return Mission.from_data({**data, "requirements": [possible[item] for item in sorted(chosen)]})


def _sizer(mission: Mission) -> AnchorSizer:
    means = Scenario.at_means(mission)
    means = laden(means, means.moor())
    return AnchorSizer(means.moor(), means, AnchorTrials(mission, "moor", None, DIVES, mission.monte_carlo.seed))


def good_weights(sizer: AnchorSizer, weights: np.ndarray) -> np.ndarray:
    """Whether each weight meets all that is asked, all of them in one block of trials."""
    mission, trials = sizer.trials.mission, weights.size * DIVES
    source = _Tiled(BlockStreams(sizer.trials.seed, 0), weights.size)
    scenario = Scenario.at_means(mission).sampled_from(source, trials)
    phase = scenario.moor("moor").model_copy(update={"anchor_wet_weight": np.repeat(weights, DIVES)})
    place, start = start_of(scenario, phase)
    position = np.broadcast_to(place.reshape(2, -1), (2, trials))
    fix = scenario.fix_sd * np.tile(stream(sizer.trials.seed, "moor.fix", 0).standard_normal((2, DIVES)), weights.size)
    state = TrialState(position, position + fix, np.full(trials, start), np.zeros(trials), np.ones(trials, dtype=bool))
    _, done = mooring_trials(TrialBlock(scenario, source, 0, inputs=False), phase, state, place.reshape(2, -1))
    columns = {f"moor.{name}": values for name, values in {**done.quantities, **done.events}.items()}
    asked = [item for item in mission.requirements if item.quantity.startswith("moor.")]
    flags = requirement_flags(mission.model_copy(update={"requirements": tuple(asked)}), columns)
    shares = {name: values.reshape(-1, DIVES).mean(axis=1) for name, values in flags.items()}
    succeeds = ~np.logical_or.reduce(list(done.failures.values())).reshape(-1, DIVES)
    good = np.ones(weights.size, dtype=bool)
    for index, item in enumerate(asked):
        good &= shares[Counted.requirement(index)] >= item.probability
    for item in mission.requirements:
        if item.quantity == "total.success":
            good &= succeeds.mean(axis=1) >= item.probability
    inside = [item.probability for item in asked if item.quantity == "moor.within_radius"]
    if inside:  # a dive that strikes is not taken as within the radius
        struck = done.events["struck_seafloor"].reshape(-1, DIVES).mean(axis=1)
        good &= 1.0 - struck >= max(inside)
    return good


def lightest_anchors(number: int) -> tuple[float | None, float | None, Mission]:
    """Lightest weight that the search finds, and by brute force, of a mission [N]; None where there is none."""
    mission = anchor_mission(number)
    sizer = _sizer(mission)
    worst = worst_case_weight(sizer.means, sizer.moor)
    found = sizer.probable(None, worst)
    assert isinstance(found, ProbableAnchor)
    start = worst + float(sizer.means.mooring.vehicle.net_buoyancy)
    lightest = None if found.anchor is None else found.lighter or found.anchor.wet_weight
    low, high = (0.01 * start, 10.0 * start) if lightest is None else (min(0.01 * start, 0.5 * lightest), lightest)
    weights = low * APART ** np.arange(math.log(high / low) / math.log(APART) + 3.0)
    good = good_weights(sizer, weights)
    return lightest, float(weights[int(np.argmax(good))]) if good.any() else None, mission


def agree(found: float | None, first: float | None) -> bool:
    """Whether the search and the grid of the brute force, up to a step of it, say the same."""
    if found is None or first is None:
        return found is first
    return first / APART / 1.002 <= found <= first * 1.002


def anchors(count: int = 40, first: int = 0) -> Iterator[str]:
    """Yield what was found for each mission, and how many agree."""
    same = none = 0
    for number in range(first, first + count):
        lightest, best, mission = lightest_anchors(number)
        none += best is None
        same += agree(lightest, best)
        words = ", ".join(f"{item.quantity} {item.probability:.2f}" for item in mission.requirements)
        shown = [f"{weight:.3f} N" if weight is not None else "none" for weight in (lightest, best)]
        mark = "" if agree(lightest, best) else "OTHERWISE "
        yield f"{number:2}: {mark}{shown[0]}, brute force {shown[1]} ({words})"
    yield f"{same} of {count} missions agree; in {none} no anchor does"


# The choice of least energy.


SPEEDS, LENGTHS = "0.7:1.8:0.05 m/s", "200:1700:100 m"


def choice_mission(number: int) -> Mission:
    """Return a mission of one transit with a drawn distance, current, error and time to be there."""
    rng = np.random.default_rng([46, number])
    whole = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
    distance, speed = rng.uniform(1000.0, 2500.0), rng.uniform(0.9, 1.4)
    way = {
        "name": "out",
        "from": ["0 m", "0 m"],
        "to": [f"{distance:.0f} m", f"{rng.uniform(-500.0, 500.0):.0f} m"],
        "depth": "2 m",
        "speed": "1 m/s",
        "d_max": "300 m",
        "arrival_radius": f"{rng.uniform(20.0, 40.0):.0f} m",
    }
    return Mission.from_data(
        {
            "vehicle": whole["vehicle"],
            "site": whole["site"],
            "navigation": {
                **whole["navigation"],
                "velocity_error": {"sigma": f"{rng.uniform(0.02, 0.06):.3f} m/s"},
                "max_legs": int(rng.integers(14, 20)),
            },
            "phases": [{"transit": way}],
            "requirements": [
                {"quantity": "out.arrived", "probability": rng.uniform(0.6, 0.95)},
                {
                    "quantity": "total.duration",
                    "at_most": f"{distance / speed / 60.0 + 8.0:.1f} min",
                    "probability": rng.uniform(0.7, 0.95),
                },
            ],
            "monte_carlo": {"trials": 4096, "seed": 1},
        }
    )


CHOOSE = (f"out.speed={SPEEDS}", f"out.d_max={LENGTHS}")
_ENERGY = "total.energy_wh"


def _brute_force(mission: Mission, seed: int) -> tuple[dict[tuple[str, ...], CellTrials], list[tuple[str, ...]]]:
    """Every choice with 4096 trials, and those that meet all requirements, the least energy first."""
    axes = read_axes(mission, CHOOSE)
    task = CellTask.of(mission, axes, seed, columns_needed(mission))
    numbers = range(len(task.cells))
    found = cell_trials(task, [(number, 0, 4096) for number in numbers], numbers, IN_THIS_PROCESS)
    names = [(speed, length) for speed in map(str, axes[0].values) for length in map(str, axes[1].values)]
    cells = dict(zip(names, found, strict=True))
    good = [name for name, cell in cells.items() if cell_of((), mission, cell.columns, cell.reason).meets_all]
    return cells, sorted(good, key=lambda name: float(np.nanmean(cells[name].columns[_ENERGY])))


def chosen(number: int, seeds: Iterable[int]) -> Iterator[tuple[bool, str]]:
    """Yield whether each seed's choice is as good as the best of a mission, and how much worse, in words."""
    mission = choice_mission(number)
    cells, good = _brute_force(mission, 1000 + number)
    if not good:
        return
    best = cells[good[0]].columns[_ENERGY]
    for seed in seeds:
        found = missionplan.optimise(mission, choose=CHOOSE, seed=seed)
        own = cells[tuple(map(str, found.chosen.values()))].columns[_ENERGY]
        worse, error, _ = paired_difference(best, own, most=False)
        share = worse / float(np.nanmean(best))
        fine = found.feasible and (share <= 0.01 or worse <= 2.0 * error)
        yield (
            fine,
            f"{number:2}, seed {seed}: {'' if fine else 'OTHERWISE '}{', '.join(map(str, found.chosen.values()))}: "
            f"{100.0 * share:+.2f} % from {', '.join(good[0])} ({len(good)} of {len(cells)} choices do)",
        )


def choices(count: int = 12, first: int = 0, seeds: int = 5) -> Iterator[str]:
    """Yield what was found for each mission and seed, and how many are as good as the best."""
    right = total = 0
    for number in range(first, first + count):
        for fine, words in chosen(number, range(1, seeds + 1)):
            right += fine
            total += 1
            yield words
    yield f"{right} of {total} within 1 % or two standard errors of brute force"


KINDS = {"anchors": anchors, "choices": choices}


def main() -> None:
    """Compare, and print each mission."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.recommended",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"{', '.join(KINDS)}; default: both")
    parser.add_argument("--missions", type=int, help="of each kind; default: 40 and 12")
    parser.add_argument("--first", type=int, default=0, help="number of the first mission")
    asked = parser.parse_args()
    if unknown := set(asked.kinds) - set(KINDS):
        parser.error(f"no {', '.join(unknown)}; there are {', '.join(KINDS)}")
    for name in asked.kinds or KINDS:
        started = time.process_time()
        count = {"count": asked.missions} if asked.missions else {}
        for line in KINDS[name](first=asked.first, **count):
            print(line, flush=True)
        print(f"{name}: {duration(time.process_time() - started)} of one core\n", flush=True)


if __name__ == "__main__":
    main()
