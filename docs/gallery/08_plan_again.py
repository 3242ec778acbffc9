"""Plan again with what was learned.

The diagnosis writes an extended mission, which carries the cause with its uncertainty. Both are simulated on the same
random numbers.
"""

import matplotlib.pyplot as plt

import missionplan

missionplan.init("trial")
mission = missionplan.load("trial/mission.yaml")
missionplan.diagnose(mission, "trial/sea-trial", plan=False).save("diagnosis")
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), sharex=True, layout="constrained")
for axes, each, name in (
    (left, mission, "before"),
    (right, missionplan.load("diagnosis/mission.yaml"), "with the compass bias"),
):
    result = missionplan.simulate(each, trials=1000, seed=1, keep_trials=True)
    result.plot(ax=axes)
    axes.set_title(name)
    print(name, result.total.events["success"].value)
