"""An error that the data hide.

The starter sea trial was made with a compass three degrees off, of which the mission knows nothing. The diagnosis
names it.
"""

import missionplan

missionplan.init("trial")
found = missionplan.diagnose("trial/mission.yaml", "trial/sea-trial", plan=False)
found.plot()
print(found.verdict, found.causes)
