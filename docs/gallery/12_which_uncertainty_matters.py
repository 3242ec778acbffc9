"""Which uncertainty matters.

The uncertain quantities of the mission, by their share of the variance of its duration: what is worth measuring
better before you go.
"""

import matplotlib.pyplot as plt

import missionplan

plan = missionplan.simulate("missions/chesapeake.yaml", trials=4000, seed=1)
shares = {each.source: each.first_order for each in plan.sensitivities if each.output == "ingress.duration_s"}
largest = sorted(shares, key=shares.get)[-6:]
figure, axes = plt.subplots(layout="constrained")
axes.barh(largest, [100 * shares[name] for name in largest])
axes.set(xlabel="share of the variance of the ingress' duration (%)")
