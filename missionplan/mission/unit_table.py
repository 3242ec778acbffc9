"""The units that mission files promise, with their factors to SI: what most files use, without a unit library.

Any other unit that pint knows is accepted too (`missionplan.mission.units`); the factors here are those of the
international definitions: foot, inch, nautical mile and pound (1959 agreement), knot 1852 m/h.
"""

import math
from collections.abc import Mapping

_LENGTH = {
    "m": 1.0,
    "meter": 1.0,
    "metre": 1.0,
    "km": 1000.0,
    "cm": 0.01,
    "mm": 0.001,
    "ft": 0.3048,
    "foot": 0.3048,
    "feet": 0.3048,
    "in": 0.0254,
    "inch": 0.0254,
    "yd": 0.9144,
    "nmi": 1852.0,
    "mi": 1609.344,
}
_TIME = {
    "s": 1.0,
    "second": 1.0,
    "seconds": 1.0,
    "min": 60.0,
    "minute": 60.0,
    "minutes": 60.0,
    "h": 3600.0,
    "hr": 3600.0,
    "hour": 3600.0,
    "hours": 3600.0,
    "d": 86400.0,
    "day": 86400.0,
    "days": 86400.0,
}
_KNOT = 1852.0 / 3600.0

FACTORS: Mapping[str, Mapping[str, float]] = {
    "m": _LENGTH,
    "s": _TIME,
    "m/s": {
        "m/s": 1.0,
        "km/h": 1000.0 / 3600.0,
        "cm/s": 0.01,
        "mm/s": 0.001,
        "ft/s": 0.3048,
        "kn": _KNOT,
        "kt": _KNOT,
        "knot": _KNOT,
        "knots": _KNOT,
    },
    "N": {"N": 1.0, "kN": 1000.0, "mN": 0.001, "lbf": 4.4482216152605},
    "kg": {"kg": 1.0, "g": 0.001, "lb": 0.45359237, "t": 1000.0},
    "kg/m^3": {"kg/m^3": 1.0, "kg/m**3": 1.0, "g/cm^3": 1000.0},
    "kg/m": {"kg/m": 1.0, "g/m": 0.001},
    "m^2": {"m^2": 1.0, "m**2": 1.0, "cm^2": 1e-4},
    "m^3": {"m^3": 1.0, "m**3": 1.0, "L": 0.001, "l": 0.001, "cm^3": 1e-6},
    "m^2/s": {"m^2/s": 1.0},
    "m^2/s^2": {"m^2/s^2": 1.0, "cm^2/s^2": 1e-4},
    "rad": {"rad": 1.0, "deg": math.pi / 180.0, "degree": math.pi / 180.0, "degrees": math.pi / 180.0},
    "W": {"W": 1.0, "kW": 1000.0, "mW": 0.001},
    "J": {"J": 1.0, "kJ": 1000.0, "MJ": 1e6, "W*h": 3600.0, "Wh": 3600.0, "kW*h": 3.6e6, "kWh": 3.6e6},
    "1/s": {"1/s": 1.0, "1/h": 1.0 / 3600.0, "1/hour": 1.0 / 3600.0, "1/d": 1.0 / 86400.0, "1/day": 1.0 / 86400.0},
    "1/m": {"1/m": 1.0, "1/km": 1e-3, "1/nmi": 1.0 / 1852.0},
    "V": {"V": 1.0, "mV": 0.001},
    "degC": {"degC": 1.0},
}
"""SI unit of a quantity → unit of the file → factor."""


def factor(name: str, unit: str) -> float | None:
    """Factor from a unit of the file to the SI unit of a quantity; None where the table does not have the pair.

    Parameters
    ----------
    name : str
        As the file writes it.
    unit : str
        SI unit of the quantity (temperatures in degC).
    """
    return 1.0 if name == unit else FACTORS.get(unit, {}).get(name)


def dimension_of(name: str) -> str | None:
    """SI unit of the quantities that a unit measures; None where the table does not have it."""
    return next((unit for unit, names in FACTORS.items() if name in names), None)
