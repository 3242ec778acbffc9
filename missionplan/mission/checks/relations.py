"""Keys against each other, every distribution at its mean: what cannot be together, and what is unusual together."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from missionplan.errors import LocalProblem
from missionplan.mission.checks import Findings, four_digits
from missionplan.mission.checks.sections import phase_path
from missionplan.mission.schema.phases import LegTableSection, MoorPhase, Navigation, Phase, TransitPhase
from missionplan.mission.schema.place import Geographic, Position, to_plane
from missionplan.mission.schema.site import Site
from missionplan.mission.schema.vehicle import EnergyBudget, Vehicle
from missionplan.montecarlo.distributions import mean_of
from missionplan.physics.held_line import LINE_MATERIALS
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.physics.water import LEAD_DENSITY, STANDARD_GRAVITY, wet_weight

FARTHEST = 500_000.0
"""Farthest from the origin [m]: there the plane stretches distances across by (D/R)²/6 = 0.1 %."""
_SEA_WATER = 1025.0
"""Density to compare a hull's volume with its mass [kg/m³]."""
_FRESH_WATER = 1000.0
"""Density in which an anchor weighs most [kg/m³]."""
_BUOYANT = (0.5, 0.1)
"""Net buoyancy over weight that is impossible, and that is unusual: AUVs are trimmed to 0.1 to 2 %."""
_FILLED = ((0.1, 3.0), (0.4, 1.3))
"""Displaced mass over the hull's volume of water that is possible, and that is usual: free flooding, appendages."""
_DENSEST = 250.0
"""Energy over mass of lithium-ion cells [W h/kg] (Linden & Reddy, *Handbook of Batteries*): a fifth of it is much for a
whole vehicle, and primary lithium cells hold two to three times as much."""
_SHALLOWEST = 1.0
"""Water above a moored vehicle that is unusual: tide and waves are seldom less [m]."""

_Place = tuple[float, float]


def check_relations(
    phases: Sequence[Phase],
    site: Site | None,
    vehicle: Vehicle | None,
    navigation: Navigation | None,
    energy: EnergyBudget | None = None,
) -> Findings:
    """List what is impossible or unusual between keys, by key path from the top of the mission."""
    depth = mean_of(site.depth) if site is not None and site.depth is not None else math.inf
    problems: list[LocalProblem] = []
    notices: list[LocalProblem] = []
    for index, phase in enumerate(phases):
        faults: list[LocalProblem] = []
        if isinstance(phase, TransitPhase):
            faults += _transit(phase, depth, navigation)
        elif isinstance(phase, MoorPhase):
            faults += _mooring(phase, depth, vehicle)
            asked = (*_cover(phase, depth, vehicle), *_weightless(phase))
            notices += [notice.within(phase_path(index, phase)) for notice in asked]
        problems += [problem.within(phase_path(index, phase)) for problem in faults]
    problems += _anchors(phases, vehicle)
    problems += _way(phases, site, navigation)
    problems += _layers(site, depth)
    if vehicle is not None:
        wrong, odd = _vehicle(vehicle)
        problems += [problem.within(("vehicle",)) for problem in wrong]
        notices += [notice.within(("vehicle",)) for notice in odd]
        notices += _battery(vehicle, energy)
    if navigation is not None:
        notices += _fixes(phases, navigation)
    return Findings(tuple(problems), tuple(notices))


def _transit(phase: TransitPhase, depth: float, navigation: Navigation | None) -> Iterator[LocalProblem]:
    run_depth, radius = mean_of(phase.depth), mean_of(phase.arrival_radius)
    if run_depth >= depth:
        yield LocalProblem(("depth",), f"{run_depth:.4g} m runs aground: the site is {depth:.4g} m deep")
    if isinstance(phase.d_max, LegTableSection):
        return
    leg = mean_of(phase.d_max)
    if leg < radius:
        message = f"{leg:.4g} m is less than the arrival radius, {radius:.4g} m: no leg needs to be so short"
        yield LocalProblem(("d_max",), message, "is the unit right?")


def _mooring(phase: MoorPhase, depth: float, vehicle: Vehicle | None) -> Iterator[LocalProblem]:
    line, length = mean_of(phase.line_length), mean_of(vehicle.hull.length) if vehicle else 0.0
    if line + length >= depth:
        words = f"{line:.4g} m of line" + (f" and {length:.4g} m of vehicle" if length else "")
        message = f"{words} are longer than the water is deep, {depth:.4g} m: the anchor cannot draw the vehicle under"
        yield LocalProblem(("line_length",), message)
    yield from _line(phase, line)
    if vehicle is None or isinstance(phase.anchor_wet_weight, str):
        return
    weight, buoyancy = mean_of(phase.anchor_wet_weight), mean_of(vehicle.net_buoyancy)
    if weight <= buoyancy:
        message = f"{weight:.4g} N cannot sink a vehicle of {buoyancy:.4g} N net buoyancy"
        yield LocalProblem(("anchor_wet_weight",), message)
    flooded = vehicle.anchor.flooded_mass if vehicle.anchor is not None else None
    if flooded is not None and weight > (most := float(wet_weight(mean_of(flooded), LEAD_DENSITY, _FRESH_WATER))):
        message = f"{weight:.4g} N is more than vehicle.anchor.flooded_mass, {mean_of(flooded):.4g} kg, weighs in water"
        yield LocalProblem(("anchor_wet_weight",), message, f"of lead it would weigh {most:.3g} N")


def _anchors(phases: Sequence[Phase], vehicle: Vehicle | None) -> Iterator[LocalProblem]:
    """Refuse moorings for which no anchor is left."""
    moors = [(index, phase) for index, phase in enumerate(phases) if isinstance(phase, MoorPhase)]
    if vehicle is not None and len(moors) > vehicle.anchors:
        index, phase = moors[vehicle.anchors]
        message = (
            f"no anchor is left for {phase.name}: {len(moors)} moorings take as many anchors, and vehicle.anchors is "
            f"{vehicle.anchors}"
        )
        yield LocalProblem(phase_path(index, phase), message, f"anchors: {len(moors)} in the vehicle file")


def _line(phase: MoorPhase, length: float) -> Iterator[LocalProblem]:
    if phase.line_strength is not None and phase.line_stiffness is None and phase.line_material is None:
        message = "says nothing without line_stiffness, from which the load of the snatch follows, or line_material"
        yield LocalProblem(("line_strength",), message)
    if phase.line_material is not None and mean_of(phase.line_diameter) == 0.0:
        yield LocalProblem(("line_diameter",), "missing; what a line of this material weighs and bears follows from it")
    before = 0.0
    for index, item in enumerate(phase.line_floats):
        distance = mean_of(item.distance)
        if not before <= distance <= length:
            message = f"{distance:.4g} m; expected {before:.4g} m to the line's length, {length:.4g} m: floats in order"
            yield LocalProblem(("line_floats", index, "distance"), message)
        before = distance


def _cover(phase: MoorPhase, depth: float, vehicle: Vehicle | None) -> Iterator[LocalProblem]:
    """Ask about a vehicle that is moored close to the surface."""
    cover = depth - mean_of(phase.line_length) - (mean_of(vehicle.hull.length) if vehicle else 0.0)
    if 0.0 < cover < _SHALLOWEST:
        message = f"leaves {cover:.2g} m of water above the moored vehicle: are tide and waves allowed for?"
        yield LocalProblem(("line_length",), message)


def _weightless(phase: MoorPhase) -> Iterator[LocalProblem]:
    """Say what is assumed of a line that has a diameter and neither material nor weight."""
    diameter = mean_of(phase.line_diameter)
    if diameter == 0.0 or phase.line_material is not None or phase.line_wet_weight is not None:
        return
    weight = float(LINE_MATERIALS["polyester"].wet_weight(diameter, _SEA_WATER)) * mean_of(phase.line_length)
    message = (
        "the line is taken as weightless: neither line_material nor line_wet_weight is given. "
        f"Of polyester it would pull the vehicle down with {weight:.2g} N"
    )
    yield LocalProblem(("line_diameter",), message)


def _way(phases: Sequence[Phase], site: Site | None, navigation: Navigation | None) -> Iterator[LocalProblem]:
    """Follow the goals: how far they are, and whether there is a way to go between them."""
    place: _Place | None = None
    for index, phase in enumerate(phases):
        if not isinstance(phase, TransitPhase):
            continue
        path = phase_path(index, phase)
        for key, position in (("from", phase.start), ("to", phase.to)):
            point = _planar(position, site)
            if point is not None and (away := math.hypot(*point)) > FARTHEST:
                message = f"lies {away / 1e3:.4g} km from the origin; expected at most {FARTHEST / 1e3:g} km"
                hint = "the plane of the coordinates stretches distances by 0.1 % there"
                yield LocalProblem((*path, key), message, hint)
        start, goal = (place if phase.start is None else _planar(phase.start, site)), _planar(phase.to, site)
        if start is not None and goal is not None:
            yield from (problem.within(path) for problem in _leg_count(phase, math.dist(start, goal), navigation))
        place = goal


def _leg_count(phase: TransitPhase, distance: float, navigation: Navigation | None) -> Iterator[LocalProblem]:
    radius = mean_of(phase.arrival_radius)
    if distance < radius:
        message = (
            f"lies {distance:.4g} m from the start, within the arrival radius, {radius:.4g} m: there is no transit"
        )
        yield LocalProblem(("to",), message)
    if navigation is None or isinstance(phase.d_max, LegTableSection):
        return
    fewest = 0.5 * (distance - radius) / mean_of(phase.d_max)  # a current may carry it as far as it goes
    if fewest > navigation.max_legs:
        legs = f"{math.ceil(fewest)} legs, even with the current"
        message = f"{four_digits(distance)} m take at least {legs}; navigation.max_legs is {navigation.max_legs}"
        yield LocalProblem(("d_max",), message)


def _planar(position: Position | None, site: Site | None) -> _Place | None:
    """East and north of the origin [m]; None where it is not known."""
    if position is None:
        return None
    if not isinstance(position, Geographic):
        return mean_of(position[0]), mean_of(position[1])
    if site is None or site.origin is None:
        return None
    east, north = to_plane(np.array(position.latitude), np.array(position.longitude), site.origin)
    return float(east), float(north)


def _layers(site: Site | None, depth: float) -> Iterator[LocalProblem]:
    if site is None or not isinstance(site.current, tuple):
        return
    above = 0.0
    for index, layer in enumerate(site.current):
        if above >= depth:
            message = f"this layer begins at {above:.4g} m, below the seafloor at {depth:.4g} m"
            yield LocalProblem(("site", "current", index), message)
        above = mean_of(layer.down_to)


def _vehicle(vehicle: Vehicle) -> tuple[list[LocalProblem], list[LocalProblem]]:
    """What is impossible of a vehicle, and what is unusual."""
    length, diameter = mean_of(vehicle.hull.length), mean_of(vehicle.hull.diameter)
    problems = list(_shape(vehicle, length, diameter))
    notices: list[LocalProblem] = []
    if vehicle.mass is None or diameter > length:
        return problems, notices
    mass, buoyancy = mean_of(vehicle.mass), mean_of(vehicle.net_buoyancy)
    share = abs(buoyancy) / (mass * STANDARD_GRAVITY)
    message = f"{buoyancy:.4g} N is {100.0 * share:.3g} % of the vehicle's weight"
    if share > _BUOYANT[0]:
        problems.append(LocalProblem(("net_buoyancy",), f"{message}; expected at most {100.0 * _BUOYANT[0]:g} %"))
    elif share > _BUOYANT[1]:
        notices.append(
            LocalProblem(("net_buoyancy",), f"{message}; AUVs are trimmed to 0.1 to 2 %. Is the unit right?")
        )
    volume = math.pi / 4.0 * diameter**2 * (length - diameter / 3.0)  # a cylinder with hemispherical ends
    filled = (mass + buoyancy / STANDARD_GRAVITY) / (_SEA_WATER * volume)
    message = f"{mass:.4g} kg displace {filled:.3g} of the hull's volume, {1e3 * volume:.4g} L"
    if not _FILLED[0][0] <= filled <= _FILLED[0][1]:
        problems.append(LocalProblem(("mass",), f"{message}: it cannot float in this hull", "is the unit right?"))
    elif not _FILLED[1][0] <= filled <= _FILLED[1][1]:
        notices.append(LocalProblem(("mass",), f"{message}, which is unusual. Is the unit right?"))
    return problems, notices


def _battery(vehicle: Vehicle, energy: EnergyBudget | None) -> Iterator[LocalProblem]:
    """Ask about a battery that would have to be lighter than any for the vehicle that it is in."""
    mission_has_it = energy is not None and energy.capacity is not None
    budget = energy if mission_has_it else vehicle.energy
    if budget is None or budget.capacity is None or vehicle.mass is None:
        return
    capacity, mass = mean_of(budget.capacity) / JOULES_PER_WATT_HOUR, mean_of(vehicle.mass)
    if capacity > _DENSEST * mass:
        message = (
            f"{four_digits(capacity)} W h in a vehicle of {mass:.4g} kg are {four_digits(capacity / mass)} W h/kg; "
            f"lithium-ion cells by themselves hold at most {_DENSEST:g}. Is the unit right?"
        )
        yield LocalProblem(("energy", "capacity") if mission_has_it else ("vehicle", "energy", "capacity"), message)


def _shape(vehicle: Vehicle, length: float, diameter: float) -> Iterator[LocalProblem]:
    """What is larger than what it is a part of, and centres that lie outside the hull."""
    if diameter > length:
        message = f"{diameter:.4g} m is more than the hull's length, {length:.4g} m"
        yield LocalProblem(("hull", "diameter"), message)
    if vehicle.sail is not None and mean_of(vehicle.sail.thickness) > mean_of(vehicle.sail.chord):
        yield LocalProblem(("sail", "thickness"), "is more than the sail's chord")
    overlap = mean_of(vehicle.anchor.overlap_volume) if vehicle.anchor is not None else 0.0
    nose = 2.0 / 3.0 * math.pi * (diameter / 2.0) ** 3  # the hemisphere that the anchor covers
    if overlap > nose:
        message = f"{1e3 * overlap:.4g} L is more than the whole nose that it is a part of, {1e3 * nose:.4g} L"
        yield LocalProblem(("anchor", "overlap_volume"), message)
    for key in ("centre_of_gravity", "centre_of_buoyancy"):
        centre = getattr(vehicle, key)
        if centre is None:
            continue
        if mean_of(centre.from_nose) > length:
            message = f"{mean_of(centre.from_nose):.4g} m lies behind the tail: the hull is {length:.4g} m long"
            yield LocalProblem((key, "from_nose"), message)
        if abs(mean_of(centre.below_axis)) > 0.5 * diameter:
            message = f"{mean_of(centre.below_axis):.4g} m lies outside the hull, {diameter:.4g} m across"
            yield LocalProblem((key, "below_axis"), message)


def _fixes(phases: Sequence[Phase], navigation: Navigation) -> Iterator[LocalProblem]:
    error = mean_of(navigation.fix_error)
    for index, phase in enumerate(phases):
        radius = mean_of(phase.arrival_radius) if isinstance(phase, TransitPhase) else math.inf
        if error > radius:
            message = f"{radius:.4g} m is less than the error of a fix, {error:.4g} m: arriving is a matter of chance"
            yield LocalProblem((*phase_path(index, phase), "arrival_radius"), message)
