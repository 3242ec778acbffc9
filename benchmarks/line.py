"""The nose of a moored vehicle against MoorDyn 2: ``python -m benchmarks.line``, where `moordyn` is installed.

MoorDyn holds the upper end of its line where missionplan's nose stands, in the same current, and says with which force
it must be held. The difference to the vehicle's pull, divided by how the line yields, is how far the noses are apart.
"""

import os
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

from missionplan.physics.current_above import ProfileAbove
from missionplan.physics.held_line import HeldBody, HeldLine, hang, line_drag_factor
from missionplan.physics.line_statics import held_pose
from missionplan.physics.vehicle_drag import Hull, Sail, VehicleDrag
from missionplan.physics.water import sea_water

CURRENTS = ((0.05, 0.0), (0.1, 0.03), (0.2, 0.0), (0.25, -0.02), (0.5, 0.0))
"""At the seafloor [m/s], and its growth upward [1/s]."""
LINES = (
    (0.004, 0.046, 5.0, 200.0),
    (0.002, 0.15, 5.0, 200.0),
    (0.004, 0.55, 4.0, 200.0),
    (0.0001, 0.1, 6.0, 200.0),
    (0.006, -0.03, 5.0, 200.0),
    (0.004, 0.046, 5.0, 20.0),
    (0.003, 0.2, 3.0, 8.0),
    (0.008, 0.0, 5.0, 40.0),
)
"""Diameter [m], wet weight [N/m], length [m] and EA [N]."""
WATER, GRAVITY, DEPTH = sea_water(20.0, 15.0), 9.80665, 30.0
INPUT = """MoorDyn 2
---- LINE TYPES ----
Name Diam MassDen EA BA EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s) (N-m2) (-) (-) (-) (-)
rope {diameter} {mass} {ea} -0.8 0 1.2 1.0 0.0 0.0
---- POINTS ----
ID Type X Y Z M V CdA CA
(-) (-) (m) (m) (m) (kg) (m3) (m2) (-)
1 Fixed 0 0 {bottom} 0 0 0 0
2 Coupled {east} 0 {up} 0 0 0 0
---- LINES ----
ID LineType AttachA AttachB UnstrLen NumSegs LineOutputs
(-) (-) (-) (-) (m) (-) (-)
1 rope 1 2 {length} 40 -
---- OPTIONS ----
0.0005 dtM
rk2 tScheme
{density} WtrDnsty
30.0 WtrDpth
9.80665 g
1e5 kBot
1e4 cBot
0 FrictionCoefficient
0 WaveKin
1 Currents
0.5 dtIC
20 TmaxIC
0.001 threshIC
---- END ----
"""


def body() -> HeldBody:
    """Return the vehicle of the Chesapeake mission."""
    length, diameter, buoyancy = 1.1176, 0.12065, 0.88964
    drag = VehicleDrag(Hull(length, diameter), Sail(0.1016, 0.1016, 0.01524), 1.25, WATER)
    return HeldBody(length, diameter, buoyancy, 0.5 * length * buoyancy, 0.0, 1.1, drag, WATER.density)


def apart(current: tuple[float, float], rope: tuple[float, float, float, float]) -> float:
    """Distance of the noses, in lengths of the line."""
    (low, shear), (diameter, weight, length, ea) = current, rope
    heights = np.linspace(0.0, 8.0, 17)
    velocity = np.stack((low + shear * heights, 0.0 * heights), axis=1)[..., None]
    profile = ProfileAbove(heights[:, None], velocity)
    line = HeldLine(length, line_drag_factor(diameter, WATER.density), wet_weight=weight, compliance=1.0 / ea)
    pose = held_pose(body(), line, profile)
    given = {
        "diameter": diameter,
        "mass": weight / GRAVITY + float(WATER.density) * 0.25 * np.pi * diameter**2,
        "ea": ea,
        "bottom": -DEPTH,
        "east": pose.nose[0, 0],
        "up": pose.nose[2, 0] - DEPTH,
        "length": length,
        "density": float(WATER.density),
    }
    held = _moordyn(INPUT.format(**given), low, shear, (float(given["east"]), 0.0, float(given["up"])))
    yields = np.empty((2, 2))
    for column, axis in enumerate((0, 2)):
        change = np.zeros((3, 1))
        change[axis] = 1e-4
        more, less = (hang(line, profile, pose.nose[2], pose.tension_at_nose + sign * change) for sign in (1, -1))
        moved = more.fallen[-1, 0] - less.fallen[-1, 0], more.deepest - less.deepest
        yields[:, column] = np.concatenate(moved) / 2e-4
    return float(np.hypot(*(yields @ (held - pose.tension_at_nose[[0, 2], 0]))) / length)


def _moordyn(text: str, low: float, shear: float, place: tuple[float, float, float]) -> np.ndarray:
    """Force that holds the upper end of a line at rest, east and up [N]."""
    import moordyn

    rows = [f"{z:.4f} {low + shear * (z + DEPTH):.6f} 0 0" for z in np.linspace(-DEPTH, 0.0, 61)]
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("lines.txt").write_text(text)
        Path("current_profile.txt").write_text("\n".join(["-----", "depth and velocity", "z ux uy uz", *rows]))
        system = moordyn.Create("lines.txt")
        moordyn.SetVerbosity(system, moordyn.LEVEL_ERR)
        moordyn.Init(system, list(place), [0.0, 0.0, 0.0])
        force = [0.0, 0.0, 0.0]
        for second in range(60):
            force = moordyn.Step(system, list(place), [0.0, 0.0, 0.0], float(second), 1.0)
        moordyn.Close(system)
        os.chdir(before)
    return -np.array([force[0], force[2]])


def main() -> None:
    """Print each case and the greatest distance."""
    found = []
    for current, rope in product(CURRENTS, LINES):
        found.append(apart(current, rope))
        print(f"current {current}, line {rope}: noses {100.0 * found[-1]:.3f} % of the line apart", flush=True)
    print(
        f"{len(found)} cases: at most {100.0 * max(found):.2f} %, in the median {100.0 * float(np.median(found)):.3f} %"
    )


if __name__ == "__main__":
    main()
