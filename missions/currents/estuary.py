"""Compute the current of the made-up estuary of ``missions/estuary.yaml``: ``python missions/currents/estuary.py``.

The estuary runs east from its mouth for 60 km to a closed head, is 12 m deep, narrows towards the head and has a
further narrowing 6 km in. The tide at the mouth (M2, S2 and the overtide M4) drives the linear equations of long waves
along it, with friction linearised by Lorentz's rule (Dronkers 1964, Tidal Computations in Rivers and Coastal Waters,
ch. 4; Friedrichs 2010, in Contemporary Issues in Estuarine Physics, ch. 3):

    ∂(b h u)/∂x = −b ∂ζ/∂t,    ∂u/∂t = −g ∂ζ/∂x − r u/h,    r = 8 C_d U/(3π),

solved for each constituent on a staggered grid, so that water is conserved through the narrowing and the phase lags up
the estuary. A river's flow is added. Across the channel the current is stronger in the middle; the velocity across
follows from the conservation of water at each point, and is parallel to the banks there. It falls off towards the
seafloor as the seventh root of the height.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH, DEPTH, GRAVITY = 60_000.0, 12.0, 9.81
DRAG, TYPICAL_SPEED = 2.5e-3, 0.7
"""Of the seafloor [1], and the speed about which its friction is linear [m/s]."""
RIVER = 120.0
"""Flow from the head [m³/s]."""
PEAKED = 0.35
"""How much stronger than the mean the current is in the middle of the channel."""
CONSTITUENTS = {"M2": (12.4206012, 1.30, 0.0), "S2": (12.0, 0.42, 0.6), "M4": (6.2103006, 0.06, 1.1)}
"""Period [h], amplitude of the tide at the mouth [m] and its phase lag at the first time [rad]."""
LATITUDE, LONGITUDE = 51.0, -4.0
"""Of the mouth, in the middle [deg]; no estuary lies there."""
START = "2026-06-01T00:00"
METRES_PER_DEGREE = 6_371_008.8 * np.pi / 180.0


def width(x: Array) -> Array:
    """Width against the distance from the mouth [m]."""
    return 2400.0 * np.exp(-x / 30_000.0) * (1.0 - 0.35 * np.exp(-(((x - 6000.0) / 900.0) ** 2)))


@dataclass(frozen=True)
class Wave:
    """A constituent along the estuary: flow through sections [m³/s] and level between them [m], complex."""

    omega: float
    x: Array
    flow: NDArray[np.complex128]
    level: NDArray[np.complex128]


def wave(period: float, amplitude: float, lag: float, cells: int = 600) -> Wave:
    """Solve the equations of long waves for one constituent, whose period is in hours."""
    omega, dx = 2.0 * np.pi / (3600.0 * period), LENGTH / cells
    faces = dx * np.arange(cells + 1)  # the last is the closed head
    wide, area = width(faces[:-1] + 0.5 * dx), width(faces[:-1]) * DEPTH
    friction = 8.0 * DRAG * TYPICAL_SPEED / (3.0 * np.pi) / DEPTH
    matrix = np.zeros((2 * cells, 2 * cells), dtype=complex)
    known = np.zeros(2 * cells, dtype=complex)
    for i in range(cells):
        # conservation of water in cell i: i ω b ζ dx + Q[i + 1] − Q[i] = 0
        matrix[i, cells + i] = 1j * omega * wide[i] * dx
        matrix[i, i] = -1.0
        if i + 1 < cells:
            matrix[i, i + 1] = 1.0
        # momentum at face i: (i ω + r/h) Q/(b h) + g (ζ[i] − ζ[i − 1])/dx = 0; half a cell from the mouth
        step = dx if i else 0.5 * dx
        matrix[cells + i, i] = (1j * omega + friction) / area[i]
        matrix[cells + i, cells + i] = GRAVITY / step
        if i:
            matrix[cells + i, cells + i - 1] = -GRAVITY / step
        else:
            known[cells] = GRAVITY / step * amplitude * np.exp(-1j * lag)
    solution = np.linalg.solve(matrix, known)
    return Wave(omega, faces, np.append(solution[:cells], 0.0), solution[cells:])


def velocity(t: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Velocity of the water's column, east and north, shape (time, y, x) [m/s]; nan on land.

    Parameters
    ----------
    t : array
        Since `START` [s].
    x, y : array
        East of the mouth and north of the middle of the channel [m].
    """
    flow, storing = np.full((t.size, x.size), -RIVER), np.zeros((t.size, x.size))
    for each in (wave(*numbers) for numbers in CONSTITUENTS.values()):
        turning = np.exp(1j * each.omega * t)[:, None]
        flow += (turning * _between(x, each.x, each.flow)).real
        slope = np.gradient(each.flow, each.x)
        storing += (turning * _between(x, each.x, slope)).real
    wide = width(x)
    narrowing = np.gradient(width(np.stack((x - 1.0, x, x + 1.0))), 1.0, axis=0)[1]
    across = y[:, None] / wide
    peak = 1.0 + PEAKED * (1.0 - 12.0 * across**2)
    share = across + PEAKED * (across - 4.0 * across**3)  # of the flow, south of here, less a half
    east = flow[:, None, :] * peak / (wide * DEPTH)
    north = storing[:, None, :] * (across - share) / DEPTH + east * (across * narrowing)
    land = np.abs(across) > 0.5
    return np.where(land, np.nan, east), np.where(land, np.nan, north)


def _between(x: Array, nodes: Array, values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.asarray(np.interp(x, nodes, values.real) + 1j * np.interp(x, nodes, values.imag))


def profile(depth: Array) -> Array:
    """Velocity at a depth over the column's mean: the seventh root of the height, 0.25 m at least."""
    height = np.maximum(DEPTH - depth, 0.25) / DEPTH
    return np.asarray(8.0 / 7.0 * height ** (1.0 / 7.0))


def field() -> xarray.Dataset:
    """Return the current against time, depth and place, as forecasts are published."""
    t = np.arange(0.0, 50.0 * 3600.0 + 1.0, 1200.0)
    depth = np.array([0.0, 3.0, 6.0, 9.0, 11.0, 12.0])
    x, y = np.arange(3000.0, 9001.0, 400.0), np.linspace(-600.0, 600.0, 7)
    east, north = (column[:, None] * profile(depth)[:, None, None] for column in velocity(t, x, y))
    axes = ("time", "depth", "latitude", "longitude")
    described = {"units": "m s-1"}
    return xarray.Dataset(
        {
            "u": (axes, east, described | {"standard_name": "eastward_sea_water_velocity"}),
            "v": (axes, north, described | {"standard_name": "northward_sea_water_velocity"}),
        },
        coords={
            "time": np.datetime64(START, "ns") + (t * 1e9).astype("timedelta64[ns]"),
            "depth": ("depth", depth, {"units": "m", "positive": "down", "standard_name": "depth"}),
            "latitude": ("latitude", LATITUDE + y / METRES_PER_DEGREE, {"units": "degrees_north"}),
            "longitude": (
                "longitude",
                LONGITUDE + x / (METRES_PER_DEGREE * np.cos(np.radians(LATITUDE))),
                {"units": "degrees_east"},
            ),
        },
        attrs={"Conventions": "CF-1.8", "title": "Current of a made-up estuary", "source": Path(__file__).name},
    )


def main() -> None:
    """Write the field beside this script, to a tenth of a millimetre a second."""
    packed = {"dtype": "int16", "scale_factor": 1e-4, "_FillValue": -32768, "zlib": True, "shuffle": True}
    field().to_netcdf(Path(__file__).with_suffix(".nc"), encoding={"u": packed, "v": packed})


if __name__ == "__main__":
    main()
