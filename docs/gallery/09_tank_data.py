"""Drag from a towing tank.

Drag against speed of a small AUV, as measured in a tank, and the coefficients that follow with their errors.
"""

import missionplan

found = missionplan.identify("missions/measured/avila-drag")
found.plot()
print(found)
