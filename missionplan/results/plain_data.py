"""Parts of plain data, as a mission's file or a report's `summary.json` holds them: of the kind expected, or empty.

What these data hold is not checked when they are read back: a report may be of another version, a mission half written.
"""

import math
from collections.abc import Mapping


def mapping(value: object) -> Mapping[str, object]:
    """Return a mapping as it is; an empty one for anything else."""
    return value if isinstance(value, Mapping) else {}


def mappings(value: object) -> list[Mapping[str, object]]:
    """Return the entries of a list that are mappings; none of anything else."""
    return [each for each in value if isinstance(each, Mapping)] if isinstance(value, list | tuple) else []


def whole(value: object) -> int:
    """Return a whole number as it is; 0 for anything else."""
    return value if isinstance(value, int) else 0


def real(value: object) -> float:
    """Return a number; nan for anything else, and for one that no float holds."""
    try:
        return float(value) if isinstance(value, int | float) else math.nan
    except OverflowError:
        return math.nan
