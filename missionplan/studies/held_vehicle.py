"""How a mooring's vehicle stands in the mean and in the worst current, and what would mend what is wrong there.

What a descent needs before it is asked for: a dive at the means that succeeds.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, take_trials
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.schema.sweep import Requirement
from missionplan.mission.views import missing_for_moorings
from missionplan.phases.currents import Current, LayeredCurrent
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.hold import Hold, HoldRecord, extreme_moments, layers_above, lifted, record_at_once
from missionplan.physics.drag import terminal_velocity
from missionplan.physics.held_line import LINE_MATERIALS
from missionplan.physics.line_statics import held_pose, line_shape
from missionplan.physics.seafloor import LayersAbove
from missionplan.results.whereabouts import HeldState, HeldVehicle
from missionplan.scenario.anchors import anchor_length, design_current
from missionplan.scenario.phases import dive_of, hold_of, start_of
from missionplan.scenario.scenario import STILL_WATER, Scenario

_FACTORS: Array = np.geomspace(0.05, 20.0, 401)
"""Factors on a quantity that are tried as remedies; 1 is among them."""


def held_vehicle(means: Scenario, phase: MoorPhase[Scalars], weight: float) -> HeldVehicle:
    """Find how the vehicle of a mooring stands above an anchor of a weight in water [N]."""
    hold, mooring = lifted(hold_of(means, phase, weight), means.descent_effects), means.mooring
    currents = dict(_currents(means, phase, hold))
    worst = list(currents.values())[-1]
    return HeldVehicle(
        phase=phase.name,
        length=float(hold.body.length),
        diameter=float(hold.body.diameter),
        anchor_length=float(hold.anchor.length),
        anchor_diameter=float(hold.anchor.diameter),
        anchor_weight=weight,
        line_length=float(hold.line.length),
        friction=float(hold.anchor.friction),
        friction_assumed=mooring.anchor.holding_factor is None,
        centres_assumed=mooring.vehicle.centres is None,
        if_polyester=_if_polyester(hold, phase, worst),
        states=tuple(_state(hold, name, layers) for name, layers in currents.items()),
        remedies=tuple(_remedies(hold, means, worst, _faults(means.mission.requirements, phase))),
    )


def _if_polyester(hold: Hold, phase: MoorPhase[Scalars], layers: LayersAbove) -> float | None:
    """Altitude of the nose were the line of polyester [m]; None where its weight is given, or no diameter."""
    if not phase.line_diameter or phase.line_material is not None or phase.line_wet_weight is not None:
        return None
    weight = LINE_MATERIALS["polyester"].wet_weight(phase.line_diameter, hold.body.density)
    return float(hold.altitude(held_pose(hold.body, replace(hold.line, wet_weight=weight), layers))[0])


def _currents(means: Scenario, phase: MoorPhase[Scalars], hold: Hold) -> Iterator[tuple[str, LayersAbove]]:
    """Layers above the anchor in the mean and in the worst current, by name.

    The worst is the design current in the layers' own directions, or the fastest of a record during the hold.
    """
    current = means.current or STILL_WATER
    place, start = start_of(means, phase)
    anchor, moment = place.reshape(2, 1), np.array([start])
    is_layered = isinstance(current, LayeredCurrent)
    yield "mean current" if is_layered else "current at touchdown", layers_above(hold, current, anchor, moment)
    if isinstance(current, LayeredCurrent):
        yield "worst current", layers_above(hold, _worst(means, phase, current), anchor, moment)
    else:
        lasting = np.array([float(sum(phase.times_moored))])
        fastest, _ = extreme_moments(hold, current, anchor, moment, lasting)
        yield "fastest current of the hold", layers_above(hold, current, anchor, fastest)


def _worst(means: Scenario, phase: MoorPhase[Scalars], current: LayeredCurrent) -> Current:
    """The design current in each layer's own direction; the mean one where there is no design current."""
    try:
        speeds, _ = design_current(means, phase)
    except InputError:
        return current
    east, north = (np.array([float(np.mean(value)) for value in side]) for side in (current.east, current.north))
    mean = np.hypot(east, north)
    if speeds.size != mean.size:
        return current
    layers = means.mooring.site.current
    toward = np.array([float(layer.toward) for layer in layers]) if isinstance(layers, tuple) else np.zeros(mean.size)
    sign = np.where(east * np.sin(toward) + north * np.cos(toward) < 0.0, -1.0, 1.0)
    return LayeredCurrent(current.down_to, sign * speeds * np.sin(toward), sign * speeds * np.cos(toward))


def _state(hold: Hold, name: str, layers: LayersAbove) -> HeldState:
    pose = held_pose(hold.body, hold.line, layers)
    pull, drag = hold.loads(pose, layers)
    distance = float(pose.excursion[0])
    downstream = pose.nose[:2, 0] / distance if distance > 1e-6 else np.array([1.0, 0.0])
    line = line_shape(hold.line, layers, pose)[..., 0]
    tail = pose.nose[:, 0] + float(hold.body.length) * pose.axis[:, 0]
    fall = hold.slope.fall(np.stack((tail[:2], downstream), axis=1).reshape(2, -1))
    into = float(hold.anchor.wet_weight - pull[2, 0])
    return HeldState(
        current=name,
        speed=float(np.hypot(*layers.velocity[0])[0]),
        nose_altitude=float(hold.altitude(pose)[0]),
        tail_altitude=float(tail[2] + fall[0]),
        clearance=float(hold.clearance(pose)[0]),
        excursion=distance,
        pitch=float(pose.pitch[0]),
        line_angle=float(pose.line_angle[0]),
        tension_at_nose=float(np.sqrt((pose.tension_at_nose**2).sum())),
        tension_at_anchor=float(np.sqrt((pull**2).sum())),
        anchor_drag=float(np.hypot(*drag)[0]),
        friction_needed=float(np.hypot(*(pull[:2] + drag))[0] / into) if into > 0.0 else float("inf"),
        holding_margin=float(hold.margin(pose, layers)[0]),
        least_weight=float(hold.least_weight(pose, layers)[0]),
        line=np.stack((downstream @ line[:, :2].T, line[:, 2]), axis=1),
        tail=(float(downstream @ tail[:2]), float(tail[2])),
        uphill=-float(fall[1]),
    )


@dataclass(frozen=True)
class _Fault:
    """Something that a hold must not do: in words, and whether each trial of a record is free of it."""

    words: str
    is_mended: Callable[[HoldRecord], NDArray[np.bool_]]


_PHRASES = {
    "nose_altitude": ("the nose's altitude", " m"),
    "excursion": ("the radius of the watch circle", " m"),
    "line_tension": ("the line's tension", " N"),
    "holding_margin": ("the holding margin", ""),
}


def _faults(requirements: Sequence[Requirement], phase: MoorPhase[Scalars]) -> Iterator[_Fault]:
    """What may go wrong: dragging, grounding, and what the mission's requirements forbid."""
    yield _Fault("the anchor drags", lambda record: record.anchor_holds)
    yield _Fault("the hull touches the seafloor", lambda record: ~record.grounded)
    for item in requirements:
        name, _, quantity = item.quantity.partition(".")
        if name == phase.name and quantity in _PHRASES:
            yield from _bound_fault(item, quantity)


def _bound_fault(item: Requirement, quantity: str) -> Iterator[_Fault]:
    words, unit = _PHRASES[quantity]
    if item.at_most is not None:
        most = float(item.at_most)
        yield _Fault(f"{words} is above {most:.3g}{unit}", lambda record: getattr(record, quantity) <= most)
    elif item.at_least is not None:
        least = float(item.at_least)
        yield _Fault(f"{words} is below {least:.3g}{unit}", lambda record: getattr(record, quantity) >= least)


@dataclass(frozen=True)
class _Knob:
    """A number that a remedy may change, in words, and the hold with other values of it, of shape (n,)."""

    article: str
    name: str
    unit: str
    value: float
    changed: Callable[[Array], Hold]


def _knobs(hold: Hold, means: Scenario) -> tuple[_Knob, ...]:
    body, anchor, line = hold.body, hold.anchor, hold.line
    is_built = means.mooring.anchor.construction is not None

    def heavier(weight: Array) -> Hold:
        length = np.maximum(anchor_length(means, weight), 0.5 * anchor.diameter) if is_built else anchor.length
        return replace(hold, anchor=replace(anchor, wet_weight=weight, length=length))

    def lighter(buoyancy: Array) -> Hold:
        raised = body.raising_moment + 0.5 * body.length * (buoyancy - body.net_buoyancy)
        return replace(hold, body=replace(body, net_buoyancy=buoyancy, raising_moment=raised))

    return (
        _Knob("an", "anchor", "N wet", float(anchor.wet_weight), heavier),
        _Knob("a", "net buoyancy", "N", float(body.net_buoyancy), lighter),
        _Knob("a", "line", "m", float(line.length), lambda length: replace(hold, line=replace(line, length=length))),
    )


def _remedies(hold: Hold, means: Scenario, layers: LayersAbove, faults: Iterator[_Fault]) -> Iterator[str]:
    """Write what is wrong in a current, and the least change of each number that mends it."""
    now = record_at_once(hold, held_pose(hold.body, hold.line, layers), layers)
    wrong = [fault for fault in faults if not fault.is_mended(now)[0]]
    knobs = _knobs(hold, means) if wrong else ()
    records = {knob: _record(knob.changed(knob.value * _FACTORS), layers) for knob in knobs}
    for fault in wrong:
        remedies, useless = [], []
        for knob, record in records.items():
            factors = _FACTORS[fault.is_mended(record)]
            factor = float(factors[np.argmin(np.abs(np.log(factors)))]) if factors.size else None
            if factor is None:
                useless.append(knob.name)
            else:
                needed = f"{knob.article} {knob.name} of {factor * knob.value:.3g} {knob.unit}"
                remedies.append(f"{needed} instead of {knob.value:.3g} {knob.unit}")
        words = f"In the worst current {fault.words}."
        if remedies:
            words += f" It would be mended by {'; or by '.join(remedies)}."
        if useless:
            words += f" No {' and no '.join(useless)} from a twentieth to twenty times the present one would."
        yield words


def _record(hold: Hold, layers: LayersAbove) -> HoldRecord:
    many = take_trials(layers, np.zeros(_FACTORS.size, dtype=np.intp))
    return record_at_once(hold, held_pose(hold.body, hold.line, many), many)


FASTEST = 10.0
"""Terminal velocity [m/s] that no streamlined body on a line reaches: torpedo anchors, of tonnes, fall at 15 to 25."""


def check_dives(means: Scenario) -> None:
    """Refuse a mission whose nominal dives are faster than any; one that lacks what a mooring needs is left alone.

    So is an anchor that is `sized`: its weight follows from the radius and the current, and is no slip of a unit.

    Raises InputError with each mooring and its terminal velocity.
    """
    mission = means.mission
    if not mission.moors or missing_for_moorings(mission):
        return
    problems = []
    for phase in means.drawn.moors:
        if isinstance(phase.anchor_wet_weight, str):
            continue
        fastest = sinking_speed(dive_of(means, phase))
        if fastest > FASTEST:
            message = f"{phase.name} goes down at {fastest:.3g} m/s; expected at most {FASTEST:g} m/s"
            key = f"{phase.name}.anchor_wet_weight"
            problems.append(Problem(message, mission.file, key=key, hint="are the units of weight and hull right?"))
    if problems:
        raise InputError(problems)


def sinking_speed(dive: Dive) -> float:
    """Speed at which anchor and vehicle sink together [m/s]; 0 where they do not."""

    def drag(speed: Scalars) -> Scalars:
        return dive.vehicle_drag(speed) + dive.anchor_drag(speed)

    return float(np.max(terminal_velocity(drag, dive.wet_weight - dive.net_buoyancy)))
