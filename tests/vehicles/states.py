"""The plan's own states, as `plan.json` writes them: an interpreter that runs them and nothing else.

Imports nothing of the package. The vehicle goes by dead reckoning, climbs at once, and has a fix when it has one.
"""

import math
import operator

from dune import Dead, Sailed
from sea import Voyage

STEP = 1.0
HOLDS = {
    "reckoned-within": operator.le,
    "way-made": operator.ge,
    "at-surface": operator.le,
    "fix-received": operator.gt,
    "fix-within": operator.lt,
    "fix-beyond": operator.ge,
    "in-state": operator.gt,
    "in-phase": operator.gt,
    "energy-used": operator.gt,
}
"""How each guard compares what is with its value."""


def sail(plan: dict, voyage: Voyage) -> Sailed:
    """Run the states of the first transit; `ends` is where it was decided to have arrived."""
    phase = plan["phases"][0]
    goal = phase["waypoints"][-1]
    point = goal["east_m"], goal["north_m"]
    states = {state["name"]: state for state in plan["states"]}
    boat, name, begun, legs = Dead(voyage), plan["states"][0]["name"], 0.0, 0
    way, depth, error, entered, fixed = 0.0, 0.0, (0.0, 0.0), 0.0, False
    while name not in ("done", "abort") and states[name]["phase"] == phase["name"]:
        state, kind = states[name], states[name]["kind"]
        away = math.dist(point, boat.nav)
        facts = {
            "reckoned-within": max(away - STEP * phase["speed_m_s"], 0.0),
            "way-made": way + 1e-9,
            "at-surface": depth,
            "fix-received": float(fixed),
            "fix-within": away,
            "fix-beyond": away,
            "in-state": boat.time - entered,
            "in-phase": boat.time - begun,
            "energy-used": 0.0,
        }
        for transition in state["transitions"]:
            if all(HOLDS[guard["kind"]](facts[guard["kind"]], guard["value"] or 0.0) for guard in transition["guards"]):
                name, entered, fixed = transition["to"], boat.time, False
                if states[name]["kind"] == "leg":
                    way, error = 0.0, voyage.leg_error()
                break
        else:
            if kind in ("leg", "surfacing"):
                if way == 0.0 and kind == "leg":
                    legs, error = legs + 1, voyage.leg_error()
                step = min(STEP, away / phase["speed_m_s"]) or STEP
                heading = math.atan2(point[0] - boat.nav[0], point[1] - boat.nav[1])
                through = phase["speed_m_s"] * math.sin(heading), phase["speed_m_s"] * math.cos(heading)
                made = voyage.made(through, error, phase["depth_m"])
                for axis in (0, 1):
                    boat.nav[axis] += through[axis] * step
                    boat.true[axis] += made[axis] * step
                way, boat.time = way + phase["speed_m_s"] * step, boat.time + step
                depth = phase["depth_m"] if kind == "leg" else 0.0
            elif kind == "fix":
                boat.drift(voyage.fix_time)
                fixed = True
    boat.done.ends.append((tuple(boat.true), tuple(boat.nav)))
    boat.done.legs.append(legs)
    return boat.done
