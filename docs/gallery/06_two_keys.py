"""Two keys at once.

Start and speed together: how often the mission succeeds, on common random numbers.
"""

import missionplan

found = missionplan.explore(
    "missions/estuary.yaml",
    ["start=09:00:13:00:1 h", "ingress.speed+egress.speed=1.2,1.5,1.8 m/s"],
    trials=200,
    seed=1,
)
found.plot()
print(found)
