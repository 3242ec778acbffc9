"""Times as data write them: ISO 8601, or seconds since 1970."""

import math
from typing import TYPE_CHECKING

from missionplan.moments import moment_of

if TYPE_CHECKING:
    import pandas as pd

EPOCH_SCALE = 1e8
"""Times above this are seconds since 1970, not since some start [s]."""


def epoch_of(text: str) -> float:
    """Read a time as seconds since 1970; without a zone it is UTC.

    Raises
    ------
    ValueError
        When it is neither ISO 8601 nor a number.
    """
    words = text.strip()
    try:
        return float(words)
    except ValueError:
        return moment_of(words).timestamp()


def epoch_seconds(words: "pd.Series[str]") -> "pd.Series[float]":
    """Read times by ISO 8601 as seconds since 1970, nan where a cell holds none; without a zone they are UTC."""
    return words.map(_epoch_or_nan).astype(float)


def _epoch_or_nan(text: object) -> float:
    try:
        return epoch_of(text) if isinstance(text, str) else math.nan
    except (ValueError, OverflowError):
        return math.nan
