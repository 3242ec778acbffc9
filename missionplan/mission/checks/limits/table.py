"""For every key of a mission with a physical size: what is impossible, what is unusual, and who says so."""

import math
from dataclasses import dataclass

HOUR, DAY = 3600.0, 86_400.0
WATT_HOUR = 3600.0


@dataclass(frozen=True)
class Limit:
    """What one quantity may be. Ends are included; the sign does not count where `signed`.

    Attributes
    ----------
    unit : str
        In which all numbers are.
    possible : (float, float)
        Beyond it is an error.
    usual : (float, float)
        Beyond it is a notice. Zero is never unusual.
    source : str
        Who says so, as messages quote it.
    signed : bool
        Whether the range is one of sizes, whatever the sign.
    """

    unit: str
    possible: tuple[float, float]
    usual: tuple[float, float]
    source: str
    signed: bool = False


_INFINITE = math.inf
_CURRENT = "tidal currents reach 10 m/s in Saltstraumen, ocean currents 2.5 m/s in the Gulf Stream"
_SPEED = "gliders make 0.25 m/s, survey AUVs 1 to 2 m/s, the fastest about 3 m/s"
_DEPTH = "the deepest sea is 10 984 m (Challenger Deep), deep AUVs are rated for 6000 m"
_DENSITY = "foams start at 30 kg/m^3, the densest metal has 22 600 kg/m^3"
_MASS = "AUVs weigh from about 1 kg to 10 t, the largest 80 t"

_depth = Limit("m", (0.0, 11_000.0), (0.0, 6000.0), _DEPTH)
_speed = Limit("m/s", (0.0, 10.0), (0.2, 3.2), _SPEED)
_current = Limit("m/s", (0.0, 12.0), (0.0, 3.0), _CURRENT, signed=True)
_sigma = Limit("m/s", (0.0, 5.0), (0.0, 0.5), "Briggs et al., Fig. 8: 0.015 to 0.055 m/s without a Doppler log")
_mass = Limit("kg", (0.01, 200_000.0), (0.5, 20_000.0), _MASS)
_part_mass = Limit("kg", (1e-6, 20_000.0), (1e-3, 500.0), "parts of an anchor that an AUV carries")
_density = Limit("kg/m^3", (10.0, 23_000.0), (100.0, 20_000.0), _DENSITY)
_length = Limit("m", (0.05, 50.0), (0.3, 26.0), "micro-AUVs are 0.5 m long, the longest 26 m")
_diameter = Limit("m", (0.01, 10.0), (0.04, 3.0), "AUVs are 0.05 m to 2.6 m across")
_centre = Limit("m", (0.0, 50.0), (0.01, 20.0), "it lies inside the vehicle")
_off_axis = Limit("m", (0.0, 5.0), (0.0, 0.5), "centimetres on a small AUV", signed=True)
_fin = Limit("m", (1e-3, 10.0), (5e-3, 3.0), "a sail is smaller than the hull that carries it")

LIMITS: dict[str, Limit] = {
    "site.depth": Limit("m", (0.1, 11_000.0), (1.0, 6000.0), _DEPTH),
    "site.current.down_to": _depth,
    "site.current.speed": _current,
    "site.current.error.sigma": Limit("m/s", (0.0, 3.0), (0.005, 0.5), "forecasts err by 0.02 to 0.3 m/s on each axis"),
    "site.current.error.time": Limit("s", (60.0, 1e7), (600.0, 30.0 * DAY), "eddies last hours to weeks"),
    "site.current.error.length": Limit("m", (10.0, 1e6), (200.0, 3e5), "eddies are 1 km to 200 km across"),
    "site.current.tide.depths.depth": _depth,
    "site.current.tide.depths.east": _current,
    "site.current.tide.depths.north": _current,
    "site.current.tide.depths.constituents.major": _current,
    "site.current.tide.depths.constituents.minor": _current,
    "site.slope.angle": Limit("rad", (0.0, 1.0), (0.0, 0.35), "sand lies no steeper than 0.6 rad (35 deg)"),
    "site.roughness": Limit("m", (1e-7, 1.0), (1e-5, 0.03), "Soulsby 1997: 0.05 mm silt, 6 mm rippled sand"),
    "navigation.velocity_error.mean": _current,
    "navigation.velocity_error.sigma": _sigma,
    "navigation.surfacing_time": Limit("s", (0.0, DAY), (1.0, HOUR), "a GPS fix takes 1 s warm to 15 min cold"),
    "navigation.fix_error": Limit("m", (0.0, 10_000.0), (0.0, 100.0), "GPS is good to 3 to 10 m, Argos to 1 km"),
    "sweep.sigma": _sigma,
    "sweep.d_max": Limit("m", (1.0, 1e6), (1.0, 2e5), "500 km is the greatest distance from the origin"),
    "transit.depth": _depth,
    "transit.speed": _speed,
    "transit.shaft_rate": Limit("rad/s", (0.0, 1050.0), (1.0, 320.0), "AUV propellers turn at 60 to 3000 rpm"),
    "transit.d_max": Limit("m", (1.0, 1e6), (5.0, 2e5), "a leg is longer than a vehicle, and than what it drifts"),
    "transit.arrival_radius": Limit("m", (0.01, 50_000.0), (1.0, 2000.0), "a fix is good to 3 to 10 m"),
    "moor.radius": Limit("m", (0.1, 50_000.0), (1.0, 1000.0), "Briggs et al.: 75 ft"),
    "moor.design_current": _current,
    "moor.anchor_wet_weight": Limit("N", (1e-3, 100_000.0), (0.5, 5000.0), "Briggs et al.: 11.8 N for a 10 kg vehicle"),
    "moor.line_length": Limit("m", (0.01, 11_000.0), (0.3, 1000.0), "Briggs et al.: 5 m"),
    "moor.line_diameter": Limit("m", (0.0, 0.5), (5e-4, 0.05), "fishing line has 0.5 mm, a ship's mooring 50 mm"),
    "moor.line_stiffness": Limit(
        "N/m", (0.1, 1e9), (50.0, 1e6), "5 m of 4 mm cord: 5 kN/m in nylon, 200 kN/m in Dyneema; of shock cord 50 N/m"
    ),
    "moor.line_strength": Limit(
        "N", (0.1, 1e8), (20.0, 1e6), "2 mm cord bears 0.5 to 4 kN, a galvanic link 0.1 to 3 kN"
    ),
    "moor.release_time": Limit("s", (0.0, DAY), (0.0, 1800.0), "Briggs et al.: seconds"),
    "moor.hold": Limit("s", (0.0, 730.0 * DAY), (0.0, 90.0 * DAY), "moorings are kept for days to months"),
    "moor.galvanic_release": Limit(
        "s", (0.0, 365.0 * DAY), (0.0, 45.0 * DAY), "galvanic links are made for hours to weeks"
    ),
    "transition.start_speed": _speed,
    "transition.mid_speed": Limit("m/s", (0.0, 10.0), (0.05, 3.2), _SPEED),
    "transition.deceleration": Limit("m/s^2", (0.0, 10.0), (1e-4, 0.5), "Palmer et al.: 0.005 to 0.015 m/s^2"),
    "transition.settle": Limit("s", (0.0, DAY), (1.0, 2 * HOUR), "hover is reached in minutes"),
    "vehicle.mass": _mass,
    "vehicle.hull.length": _length,
    "vehicle.hull.diameter": _diameter,
    "vehicle.hull.form_factor": Limit("", (1e-3, 100.0), (0.2, 5.0), "Hoerner 1, Briggs et al. 2.64"),
    "vehicle.hull.added_mass": Limit("", (0.0, 10.0), (0.0, 1.0), "Lamb: 0.5 for a sphere, less for what is longer"),
    "vehicle.hull.crossflow_drag": Limit(
        "", (0.05, 10.0), (0.3, 2.0), "Hoerner: 0.3 beyond the drag crisis, 1.2 below"
    ),
    "vehicle.centre_of_gravity.from_nose": _centre,
    "vehicle.centre_of_buoyancy.from_nose": _centre,
    "vehicle.centre_of_gravity.below_axis": _off_axis,
    "vehicle.centre_of_buoyancy.below_axis": _off_axis,
    "vehicle.sail.chord": _fin,
    "vehicle.sail.span": _fin,
    "vehicle.sail.thickness": Limit("m", (1e-4, 10.0), (1e-3, 1.0), "a sail is thinner than its chord"),
    "vehicle.appendage_factor": Limit("", (0.1, 20.0), (1.0, 3.0), "Briggs et al., Eq. 13: 1.25"),
    "vehicle.drag.coefficient": Limit("", (1e-6, 100.0), (1e-3, 3.0), "streamlined 0.1, bluff 1"),
    "vehicle.anchor.diameter": _diameter,
    "vehicle.anchor.drag_coefficient": Limit("", (1e-3, 20.0), (0.05, 2.0), "Hoerner: 0.2 rounded, 1.2 flat"),
    "vehicle.anchor.overlap_volume": Limit("m^3", (0.0, 10.0), (0.0, 0.5), "a part of the anchor's own volume"),
    "vehicle.anchor.flooded_mass": Limit("kg", (1e-3, 20_000.0), (0.05, 2000.0), "Briggs et al.: 2.8 kg"),
    "vehicle.anchor.added_mass": Limit("kg", (1e-6, 20_000.0), (1e-3, 2000.0), "less than the water it displaces"),
    "vehicle.anchor.holding_factor": Limit(
        "",
        (1e-3, 100.0),
        (0.1, 1.5),
        "DNV-RP-F109: 0.2 on clay, 0.6 on sand; one that digs in holds more than its weight",
    ),
    "vehicle.anchor.flooding_time": Limit("s", (0.0, HOUR), (0.0, 120.0), "1 L enters through a hole of 8 mm in 20 s"),
    "vehicle.anchor.construction.front.mass": _part_mass,
    "vehicle.anchor.construction.back.mass": _part_mass,
    "vehicle.anchor.construction.front.density": _density,
    "vehicle.anchor.construction.tube.density": _density,
    "vehicle.anchor.construction.back.density": _density,
    "vehicle.anchor.construction.trim.density": Limit(
        "kg/m^3", (1100.0, 23_000.0), (2000.0, 20_000.0), "a ring lighter than water adds no wet weight; brass 8500"
    ),
    "vehicle.propulsion.diameter": Limit("m", (5e-3, 5.0), (0.02, 1.5), "AUV propellers are 0.05 m to 1 m across"),
    "vehicle.thrusters.diameter": Limit("m", (5e-3, 5.0), (0.02, 1.5), "tunnels are 0.05 m to 0.3 m across"),
    "energy.hotel": Limit("W", (0.0, 100_000.0), (0.0, 3000.0), "AUVs draw 1 W to 1 kW besides propulsion"),
    "energy.capacity": Limit(
        "W*h", (0.0, 1e8), (1.0, 2e6), "batteries of AUVs hold 50 W h to 100 kW h, the largest 18 MW h of fuel"
    ),
    "energy.surfacing": Limit("W*h", (0.0, 1e5), (0.0, 100.0), "a fix and a message take a fraction of a W h"),
    "energy.propulsive_efficiency": Limit("", (1e-3, 1.0), (0.05, 0.9), "small propellers reach 0.3 to 0.7"),
    "site.water.salinity": Limit("", (0.0, _INFINITE), (0.0, 42.0), "the Red Sea has 41"),
    "site.water.density": Limit("kg/m^3", (0.0, _INFINITE), (990.0, 1060.0), "fresh 998, ocean 1020 to 1050 kg/m^3"),
    "site.water.viscosity": Limit("m^2/s", (0.0, _INFINITE), (5e-7, 2.2e-6), "1.8e-6 m^2/s at 0 degC, 0.6e-6 at 45"),
}
"""By key path without indices, phases by their kind."""

IN_UNIT = {"W*h": 1.0 / WATT_HOUR}
"""From SI to the unit of a limit where they differ."""

FARTHEST = 500_000.0
"""Farthest from the origin [m]: there the plane stretches distances across by (D/R)²/6 = 0.1 %."""
EFFECT_SCALES = 6.0
"""Plausible sizes of an effect's parameter, in its catalogue's standard deviations, beyond which it is unusual."""
