"""Alternatives side by side.

The same mission with three lines, on common random numbers: is the difference more than chance?
"""

import missionplan

mission = missionplan.load("missions/chesapeake.yaml")
lines = [mission.with_({"name": f"line of {length}", "moor.line_length": length}) for length in ("3 m", "5 m", "7 m")]
found = missionplan.compare(*lines, trials=1000, seed=1)
found.plot()
print(found)
