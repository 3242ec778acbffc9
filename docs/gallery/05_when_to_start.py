"""When to start.

The same mission through the narrows of an estuary at every hour of a day, on common random numbers: only the tide
differs.
"""

import missionplan

found = missionplan.explore("missions/estuary.yaml", ["start=04:00:16:00:1 h"], trials=200, seed=1)
found.plot()
print(found)
