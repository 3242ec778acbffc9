"""Draw the pictures of ``docs/tide.md``: ``python docs/figures/tide.py``. The record is made up."""

import math
import re
import tempfile
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd

import missionplan
from missionplan.report.page import style
from missionplan.studies.tide.page import ellipses_figure, record_figure

HERE = Path(__file__).parent
HOURS = {"M2": 12.4206012, "S2": 12.0, "N2": 12.6583482, "K1": 23.9344696, "O1": 25.8193417, "M4": 6.2103006}
AMPLITUDES = {"M2": 0.42, "S2": 0.13, "N2": 0.08, "K1": 0.07, "O1": 0.05, "M4": 0.04}


def made_record() -> pd.DataFrame:
    """A month of a current meter at 4 m: waves, a mean, and an Ornstein–Uhlenbeck process of 5 cm/s and 5 h."""
    rng, step = np.random.default_rng(3), 1200.0
    seconds = np.arange(0.0, 31.0 * 86400.0, step)
    phase = {name: 2.0 * np.pi * seconds / 3600.0 / period + rng.uniform(0.0, 6.3) for name, period in HOURS.items()}
    along = sum(AMPLITUDES[name] * np.cos(phase[name]) for name in HOURS)
    across = sum(0.25 * AMPLITUDES[name] * np.sin(phase[name]) for name in HOURS)
    left, share = np.zeros((2, len(seconds))), math.exp(-step / 18000.0)
    for k in range(1, len(seconds)):
        left[:, k] = share * left[:, k - 1] + 0.05 * math.sqrt(1.0 - share**2) * rng.normal(size=2)
    begins = datetime(2026, 4, 1, tzinfo=UTC).timestamp()
    return pd.DataFrame(
        {
            "t_s": [datetime.fromtimestamp(begins + each, UTC).isoformat() for each in seconds],
            "depth_m": 4.0,
            "east_m_s": 0.03 + 0.8 * along - 0.6 * across + left[0],
            "north_m_s": 0.6 * along + 0.8 * across + left[1],
        }
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        made_record().to_csv(Path(folder) / "mooring.csv", index=False)
        result = missionplan.tide(Path(folder) / "mooring.csv", latitude=math.radians(37.2))
    with style():
        pictures = {"ellipses": ellipses_figure(result), "record": record_figure(result)}
    white = '<rect width="100%" height="100%" fill="#ffffff"/>'  # legible on any page
    for name, picture in pictures.items():
        text = re.sub(r"(<svg[^>]*>)", rf"\1{white}", picture.svg, count=1)
        (HERE / f"tide-{name}.svg").write_text(text, encoding="utf-8")
