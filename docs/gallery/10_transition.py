"""From cruise to hover.

How a slightly buoyant vehicle slows from survey speed to hovering on its thrusters, and what that costs.
"""

import missionplan

found = missionplan.sweep_transition("missions/autosub-transition.yaml")
found.plot()
print(found)
