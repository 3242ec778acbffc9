"""What is impossible and unusual for a key, and who says so: declared at its field, next to its meaning (`Doc`)."""

from dataclasses import dataclass

HOUR, DAY = 3600.0, 86_400.0
WATT_HOUR = 3600.0


@dataclass(frozen=True)
class Limit:
    """What one quantity may be. Ends are included; the sign does not count where `signed`."""

    possible: tuple[float, float]
    """Beyond it is an error."""
    usual: tuple[float, float]
    """Beyond it is a notice. Zero is never unusual."""
    source: str
    """Who says so, as messages quote it."""
    signed: bool = False
    """Whether the range is one of sizes, whatever the sign."""
    unit: str | None = None
    """In which the numbers are; None: the one in which the field is read."""


_CURRENT_SOURCE = "tidal currents reach 10 m/s in Saltstraumen, ocean currents 2.5 m/s in the Gulf Stream"
_SPEED_SOURCE = "gliders make 0.25 m/s, survey AUVs 1 to 2 m/s, the fastest about 3 m/s"
_DEPTH_SOURCE = "the deepest sea is 10 984 m (Challenger Deep), deep AUVs are rated for 6000 m"
_DENSITY_SOURCE = "foams start at 30 kg/m^3, the densest metal has 22 600 kg/m^3"
_MASS_SOURCE = "AUVs weigh from about 1 kg to 10 t, the largest 80 t"

DEPTH = Limit((0.0, 11_000.0), (0.0, 6000.0), _DEPTH_SOURCE)
SPEED = Limit((0.0, 10.0), (0.2, 3.2), _SPEED_SOURCE)
CURRENT = Limit((0.0, 12.0), (0.0, 3.0), _CURRENT_SOURCE, signed=True)
SIGMA = Limit((0.0, 5.0), (0.0, 0.5), "Briggs et al., Fig. 8: 0.015 to 0.055 m/s without a Doppler log")
MASS = Limit((0.01, 200_000.0), (0.5, 20_000.0), _MASS_SOURCE)
PART_MASS = Limit((1e-6, 20_000.0), (1e-3, 500.0), "parts of an anchor that an AUV carries")
DENSITY = Limit((10.0, 23_000.0), (100.0, 20_000.0), _DENSITY_SOURCE)
LENGTH = Limit((0.05, 50.0), (0.3, 26.0), "micro-AUVs are 0.5 m long, the longest 26 m")
DIAMETER = Limit((0.01, 10.0), (0.04, 3.0), "AUVs are 0.05 m to 2.6 m across")
CENTRE = Limit((0.0, 50.0), (0.01, 20.0), "it lies inside the vehicle")
OFF_AXIS = Limit((0.0, 5.0), (0.0, 0.5), "centimetres on a small AUV", signed=True)
FIN = Limit((1e-3, 10.0), (5e-3, 3.0), "a sail is smaller than the hull that carries it")

IN_UNIT = {"W*h": 1.0 / WATT_HOUR}
"""From SI to the unit of a limit where they differ."""
