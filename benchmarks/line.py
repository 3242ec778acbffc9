"""The nose of a moored vehicle against MoorDyn 2: ``python -m benchmarks.line``, where `moordyn` is installed.

MoorDyn holds the upper end of its line where missionplan's nose stands, in the same current, and says with which force
it must be held. The difference to the vehicle's pull, divided by how the line yields, is how far the noses are apart.
"""

import os
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

from missionplan.physics.drag import Hull, Sail, VehicleDrag
from missionplan.physics.held_line import Float, HeldBody, HeldLine, line_drag_factor
from missionplan.physics.line_statics import held_pose, laid
from missionplan.physics.seafloor import ProfileAbove
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
FLOATED = (
    ((0.004, 0.2, 5.0, 200.0), ((2.0, 0.6),)),
    ((0.004, 0.55, 5.0, 200.0), ((1.0, 0.8),)),
    ((0.004, 0.2, 6.0, 200.0), ((1.0, 0.5), (3.0, 0.5))),
    ((0.004, 0.55, 5.0, 200.0), ((2.5, 2.0),)),
    ((0.004, 0.55, 6.0, 200.0), ((3.5, 0.8),)),
    ((0.003, 0.8, 8.0, 200.0), ((3.0, 0.9), (6.0, 1.5))),
    ((0.002, 0.9, 6.0, 200.0), ((4.0, 2.5),)),
    ((0.006, 0.4, 8.0, 30.0), ((2.5, 0.3), (4.5, 0.9), (6.5, 0.6))),
)
"""Lines with floats: distance from the vehicle [m] and buoyancy [N]. Most touch the ground between."""
FLOAT_MASS = 0.005
"""Of a float [kg]."""
WATER, GRAVITY, DEPTH = sea_water(20.0, 15.0), 9.80665, 30.0
INPUT = """MoorDyn 2
---- LINE TYPES ----
Name Diam MassDen EA BA EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s) (N-m2) (-) (-) (-) (-)
rope {diameter} {mass} {ea} -0.8 0 1.2 1.0 {along} 0.0
---- POINTS ----
ID Type X Y Z M V CdA CA
(-) (-) (m) (m) (m) (kg) (m3) (m2) (-)
{points}
---- LINES ----
ID LineType AttachA AttachB UnstrLen NumSegs LineOutputs
(-) (-) (-) (-) (m) (-) (-)
{lines}
---- OPTIONS ----
0.001 dtM
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
SEGMENTS = 20
"""Of the whole line."""


def body() -> HeldBody:
    """Return the vehicle of the Chesapeake mission."""
    length, diameter, buoyancy = 1.1176, 0.12065, 0.88964
    drag = VehicleDrag(Hull(length, diameter), Sail(0.1016, 0.1016, 0.01524), 1.25, WATER)
    return HeldBody(length, diameter, buoyancy, 0.5 * length * buoyancy, 0.0, 1.1, drag, WATER.density)


def apart(
    current: tuple[float, float],
    rope: tuple[float, float, float, float],
    floats: tuple[tuple[float, float], ...] = (),
) -> float:
    """Distance of the noses, in lengths of the line."""
    (low, shear), (diameter, weight, length, ea) = current, rope
    heights = np.linspace(0.0, 8.0, 17)
    velocity = np.stack((low + shear * heights, 0.0 * heights), axis=1)[..., None]
    profile = ProfileAbove(heights[:, None], velocity)
    line = HeldLine(
        length,
        line_drag_factor(diameter, WATER.density),
        wet_weight=weight,
        compliance=1.0 / ea,
        floats=tuple(Float(*item) for item in floats),
    )
    pose = held_pose(body(), line, profile)
    place = (float(pose.nose[0, 0]), 0.0, float(pose.nose[2, 0]) - DEPTH)
    points, lines = _parts(length, floats, place)
    given = {
        "diameter": diameter,
        "mass": weight / GRAVITY + float(WATER.density) * 0.25 * np.pi * diameter**2,
        "ea": ea,
        "along": 0.02 / np.pi,
        "points": points,
        "lines": lines,
        "density": float(WATER.density),
    }
    held = _moordyn(INPUT.format(**given), low, shear, place)
    yields = np.empty((2, 2))
    for column, axis in enumerate((0, 2)):
        change = np.zeros((3, 1))
        change[axis] = 1e-4
        more, less = (laid(line, profile, pose.nose[2], pose.tension_at_nose + sign * change) for sign in (1, -1))
        moved = more.fallen[-1, 0] - less.fallen[-1, 0], more.deepest - less.deepest
        yields[:, column] = np.concatenate(moved) / 2e-4
    return float(np.hypot(*(yields @ (held - pose.tension_at_nose[[0, 2], 0]))) / length)


def _parts(
    length: float, floats: tuple[tuple[float, float], ...], place: tuple[float, float, float]
) -> tuple[str, str]:
    """MoorDyn's points and lines, from the anchor to the vehicle's nose, with a float wherever two lines meet."""
    ends = [0.0, *(distance for distance, _ in floats), length]
    points = [f"1 Fixed 0 0 {-DEPTH} 0 0 0 0", f"2 Coupled {place[0]} {place[1]} {place[2]} 0 0 0 0"]
    for number, (distance, buoyancy) in enumerate(floats, start=3):
        share, volume = 1.0 - distance / length, (FLOAT_MASS + buoyancy / GRAVITY) / float(WATER.density)
        up = -DEPTH + share * (place[2] + DEPTH) + 0.05
        points.append(f"{number} Free {share * place[0]} 0 {up} {FLOAT_MASS} {volume} 0 0.5")
    chain = [2, *range(3, 3 + len(floats)), 1]
    lines = [
        f"{number} rope {chain[number]} {chain[number - 1]} {ends[number] - ends[number - 1]} "
        f"{max(round(SEGMENTS * (ends[number] - ends[number - 1]) / length), 5)} -"
        for number in range(1, len(ends))
    ]
    return "\n".join(points), "\n".join(lines)


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
    """Print each case and the greatest distance, without floats and with them."""
    for name, lines in (("without floats", tuple((rope, ()) for rope in LINES)), ("with floats", FLOATED)):
        found = []
        for current, (rope, floats) in product(CURRENTS, lines):
            found.append(apart(current, rope, floats))
            words = f", floats {floats}" if floats else ""
            print(f"current {current}, line {rope}{words}: {100.0 * found[-1]:.3f} % of the line apart", flush=True)
        middle = 100.0 * float(np.median(found))
        print(f"{len(found)} cases {name}: at most {100.0 * max(found):.2f} %, in the median {middle:.3f} %\n")


if __name__ == "__main__":
    main()
