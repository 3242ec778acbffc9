"""Prior of the coordinates of a model: independent normal distributions."""

from dataclasses import dataclass

from missionplan.arrays import Array


@dataclass(frozen=True)
class NormalPrior:
    """Independent normal distributions of k coordinates.

    Attributes
    ----------
    centre, sd : array, shape (k,)
        Means and standard deviations.
    """

    centre: Array
    sd: Array
