"""An outcome shaped like that of `missions/chesapeake.yaml`, drawn by hand: reports need no engine to be tested."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from missionplan.mission import load
from missionplan.montecarlo.sensitivity import sensitivities
from missionplan.montecarlo.statistics import RunningStatistic, wilson
from missionplan.results import Provenance
from missionplan.results.simulation import (
    Attrition,
    Histogram,
    Outcome,
    PhaseOutcome,
    RequirementOutcome,
    Sensitivity,
    Tracks,
)
from missionplan.studies.export import mission_plan

MISSIONS = Path(__file__).parents[2] / "missions"
TRIALS = 4000
MAPPED = 60
POINTS = 8  # of each transit: the start and seven fixes


def example(*, origin: bool = True, name: str | None = None, seed: int = 1, shift: float = 0.0) -> Outcome:
    """Draw an outcome; `shift` moves the anchors east [m]."""
    draw = np.random.default_rng(seed).normal
    raw = dict(load(MISSIONS / "chesapeake.yaml").raw)
    release, current = draw(10.0, 3.0, TRIALS).clip(0.0), draw(0.2, 0.05, TRIALS)
    in_error, out_error = draw(0.0, 6.0, (2, TRIALS)), draw(0.0, 9.0, (2, TRIALS))
    arrived = np.hypot(*in_error) < 15.0
    anchor = in_error + np.array([[0.87], [0.5]]) * (current * (release + 30.0)) + draw(0.0, 1.0, (2, TRIALS))
    anchor = np.where(arrived, anchor + np.array([[shift], [0.0]]), np.nan)
    offset = np.hypot(*(anchor - in_error))
    altitude = np.where(arrived, draw(1.9, 0.25, TRIALS), np.nan)
    returned = arrived & (np.hypot(*out_error) < 25.0)
    ingress = {"duration_s": 1480.0 + np.abs(draw(0.0, 60.0, TRIALS)), "arrival_error_m": np.hypot(*in_error)}
    moor = {
        "offset_m": offset,
        "lowest_altitude_m": altitude,
        "duration_s": np.where(arrived, draw(1950.0, 60.0, TRIALS), np.nan),
    }
    egress = {
        "duration_s": np.where(arrived, 1560.0 + np.abs(draw(0.0, 110.0, TRIALS)), np.nan),
        "arrival_error_m": np.where(arrived, np.hypot(*out_error), np.nan),
    }
    duration = ingress["duration_s"] + moor["duration_s"] + egress["duration_s"]
    total = {"duration_s": duration, "energy_wh": 11.0 + duration / 200.0}
    inputs = {"moor.release_time": release, "site.current[1].speed": current, "ingress.velocity_error": in_error[0]}
    found = sensitivities(inputs, {"moor.offset_m": offset, "total.duration_s": duration})
    first_end, second_end = ingress["duration_s"], ingress["duration_s"] + moor["duration_s"]
    within = arrived & (offset < 22.86)
    return Outcome(
        provenance=Provenance(
            command="simulate",
            mission=raw["name"] if name is None else name,
            file="missions/chesapeake.yaml",
            seed=seed,
            trials=TRIALS,
            options={"precision": None},
            elapsed_s=1.25,
            data=raw if name is None else {**raw, "name": name},
            notices=("moor.release_time: 0.043 % of the distribution lies outside the physical range and was cut off",),
        ),
        phases=(
            _phase("ingress", "transit", ingress, {"arrived": arrived}, np.zeros(TRIALS), first_end),
            _phase("moor", "moor", moor, {"within_radius": within}, np.where(arrived, first_end, np.nan), second_end),
            _phase("egress", "transit", egress, {"arrived": returned}, second_end, duration),
        ),
        total=_phase("total", "total", total, {"success": returned & within}, np.zeros(TRIALS), duration),
        requirements=(
            _requirement("ingress.arrived", None, None, "", 0.95, arrived),
            _requirement("moor.offset", "at_most", 22.86, "m", 0.9, within),
            _requirement("moor.lowest_altitude", "at_least", 0.3, "m", 0.99, altitude > 0.3),
            _requirement("total.energy", "at_most", 45.0 * 3600.0, "J", 0.95, total["energy_wh"] < 45.0),
        ),
        attrition=_attrition(
            [
                ("ingress: not arrived", arrived),
                ("moor: anchor outside the radius", within),
                ("moor: struck the seafloor", within),
                ("egress: not arrived", returned & within),
            ]
        ),
        sensitivities=tuple(Sensitivity(**vars(influence)) for influence in found),
        plan=mission_plan(load(MISSIONS / "chesapeake.yaml")) if origin else None,
        tracks=_tracks(draw, in_error, anchor, arrived, (0.6501, -1.3331) if origin else None),
        arrivals={
            "ingress": in_error[:, :1000],
            "moor": anchor[:, :1000],
            "egress": np.where(arrived, out_error, np.nan)[:, :1000],
        },
    )


def _phase(name, kind, quantities, events, start, end) -> PhaseOutcome:
    return PhaseOutcome(
        name=name,
        kind=kind,
        quantities={key: RunningStatistic.of(values).statistic() for key, values in quantities.items()},
        events={key: wilson(int(happened.sum()), TRIALS) for key, happened in events.items()},
        histograms={key: _histogram(values) for key, values in quantities.items()},
        start=RunningStatistic.of(start).statistic(),
        end=RunningStatistic.of(end).statistic(),
        label=name,
    )


def _histogram(values) -> Histogram:
    counts, edges = np.histogram(values[np.isfinite(values)], 40)
    return Histogram(edges, counts.astype(float))


def _requirement(quantity, bound, limit, unit, required, happened) -> RequirementOutcome:
    reached = wilson(int(happened.sum()), TRIALS)
    undecided = reached.low < required < reached.high
    met = reached.value >= required
    return RequirementOutcome(quantity, bound, limit, unit, required, reached, met, undecided, trials=TRIALS)


def _attrition(steps) -> tuple[Attrition, ...]:
    entries, before = [], np.ones(TRIALS, dtype=bool)
    for step, good in steps:
        left = before & good
        entries.append(Attrition(step, wilson(int((before & ~left).sum()), TRIALS), wilson(int(left.sum()), TRIALS)))
        before = left
    return tuple(entries)


def _tracks(draw: Callable[..., np.ndarray], in_error, anchor, arrived, origin) -> Tracks:
    """Straight transits with noisy fixes; a trial that arrived early repeats nothing: its later points are nan."""
    share = np.linspace(0.0, 1.0, POINTS)[:, None, None]
    goal, home = np.array([[1600.0], [0.0]]), np.zeros((2, 1))
    noise = draw(0.0, 15.0, (POINTS, 2, MAPPED)) * (share * (1.0 - share) * 4.0)
    landed = goal + in_error[:, :MAPPED]
    inward = share * landed + noise
    inward[-2, :, ::3] = np.nan
    seabed = goal + anchor[:, :MAPPED]
    surfaced = seabed + draw(15.0, 5.0, (2, MAPPED))
    outward = (1.0 - share) * surfaced + share * (home + draw(0.0, 9.0, (2, MAPPED))) + noise
    outward[:, :, ~arrived[:MAPPED]] = np.nan
    position = np.concatenate((inward, seabed[None], surfaced[None], outward))
    phase = np.repeat([0, 1, 2], [POINTS, 2, POINTS])
    targets = {"ingress": ((1600.0, 0.0), 15.0), "moor": ((1600.0, 0.0), 22.86), "egress": ((0.0, 0.0), 25.0)}
    time = np.where(np.isfinite(position[:, 0]), 120.0 * np.arange(len(position))[:, None], np.nan)
    depth = np.where(np.isfinite(time), np.where(phase == 1, 10.0, 2.0)[:, None], np.nan)
    return Tracks(position, time, phase, targets, seabed, origin, np.array([time, depth]), arrived[:MAPPED])
