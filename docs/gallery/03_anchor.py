"""Which anchor to build.

The anchor has to pull the vehicle down within the radius against the current. The figure shows the probability of
staying within it against the anchor's wet weight.
"""

import missionplan

anchor = missionplan.size_anchor("missions/anchor-design.yaml", trials=1000, seed=1)
anchor.plot()
print(anchor)
