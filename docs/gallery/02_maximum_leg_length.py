"""How long may a leg be.

A short leg costs surfacings, a long one misses the goal. The cost has teeth: it falls wherever one leg less will do.
The curve of this mission is Fig. 8 of Briggs et al.
"""

import missionplan

sweep = missionplan.sweep_dmax("missions/fig8.yaml", trials=2000, seed=1)
sweep.plot()
for curve in sweep.summary()["sweep"]:
    print(f"σ = {curve['sigma_m_s']} m/s: d_max {curve['recommended']['d_max_m']:.0f} m")
