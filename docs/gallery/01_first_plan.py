"""A mission, simulated.

Two thousand trials of the mission in the Chesapeake Bay: how often it succeeds, and how long the whole takes.
"""

import missionplan

plan = missionplan.simulate("missions/chesapeake.yaml", trials=2000, seed=1)
plan.plot()
print(plan)
