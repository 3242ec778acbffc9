"""What if the compass is off.

Keys of a mission can be changed in Python, with units as text. Here the compass of the starter mission is turned by
one to eight degrees: how often does the vehicle arrive, and how long does it take?
"""

import matplotlib.pyplot as plt

import missionplan

missionplan.init("trial")
mission = missionplan.load("trial/mission.yaml")
angles = [0, 2, 4, 6, 8]
minutes = []
for angle in angles:
    turned = mission.with_(effects=[{"compass-bias": {"angle": f"{angle} deg"}}])
    minutes.append(missionplan.simulate(turned, trials=1000, seed=1).total.quantities["duration_s"].mean / 60)
figure, axes = plt.subplots(layout="constrained")
axes.plot(angles, minutes, "o-")
axes.set(xlabel="compass bias (°)", ylabel="mission, mean (min)")
