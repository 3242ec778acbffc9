"""The tide in a record.

A month of a current meter, made here of two constituents and noise. The tide is found again, with errors, and becomes
the current of a mission.
"""

import math

import numpy as np
import pandas as pd

import missionplan

hours = np.arange(0.0, 30 * 24.0, 0.5)
rng = np.random.default_rng(4)
along = 0.40 * np.cos(2 * np.pi * hours / 12.4206 - 1.0) + 0.15 * np.cos(2 * np.pi * hours / 12.0 - 2.0)
record = pd.DataFrame(
    {
        "t_s": (pd.Timestamp("2026-05-01") + pd.to_timedelta(hours, "h")).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "depth_m": 5.0,
        "east_m_s": 0.9 * along + rng.normal(0.03, 0.03, len(hours)),
        "north_m_s": 0.4 * along + rng.normal(0.0, 0.03, len(hours)),
    }
)
record.to_csv("mooring.csv", index=False)

found = missionplan.tide("mooring.csv", latitude=math.radians(50.0))
found.plot()
print(found.to_frame()[["constituent", "major_m_s", "major_error_m_s"]].head(3).round(4).to_string(index=False))
