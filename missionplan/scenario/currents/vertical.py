"""Depths of a model's layers below the surface of the moment, and how deep a column of water is good."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.recorded_currents import DEPTH_MARGIN, DEPTH_SHARE
from missionplan.scenario.currents.files import FieldFiles

SKIN = 1.0
"""Depth down to which a current that is given for the surface alone is good [m]."""


@dataclass(frozen=True)
class SLevels:
    """Levels that follow bottom and surface, stretched (ROMS).

    Shchepetkin and McWilliams 2005, Ocean Modelling 9, 347-404, Eqs. 2.1 (`transform` 1) and 2.2 (2), with the notation
    of the ROMS manual.

    Attributes
    ----------
    s, stretching : array, shape (d,)
        s-coordinate and C(s), -1 at the bottom to 0 at the surface.
    critical_depth : float
        h_c [m].
    transform : int
        ``Vtransform``, 1 or 2.
    """

    s: Array
    stretching: Array
    critical_depth: float
    transform: int

    @classmethod
    def of(cls, files: FieldFiles, along: str) -> "SLevels":
        """Read them from a file.

        Parameters
        ----------
        files : FieldFiles
        along : str
            Dimension of the layers.
        """
        s = files.fixed(files.required("the s-coordinate", along, "s_rho", "sc_r"))
        stretching = files.fixed(files.required("the stretching of the s-coordinate", "Cs_r"))
        critical = float(files.fixed(files.required("the critical depth", "hc")))
        name = files.named("Vtransform")
        transform = 1 if name is None else round(float(files.fixed(name)))
        if transform not in (1, 2):
            raise files.problem(f"Vtransform is {transform}; expected 1 or 2")
        if s.shape != stretching.shape or np.any(np.abs(s) > 1.0) or np.any(np.abs(stretching) > 1.0):
            raise files.problem("its s-coordinate and the stretching of it do not lie between -1 and 0")
        return cls(s, stretching, critical, transform)

    def depths(self, bottom: Array, surface: Array) -> Array:
        """Depths of the levels below the surface.

        Parameters
        ----------
        bottom : array, shape (c,)
            Depth of the seafloor below the datum [m].
        surface : array, shape (t, c)
            Its height above the datum [m].

        Returns
        -------
        array, shape (t, c, d)
            [m]
        """
        h, zeta = bottom[:, None], surface[:, :, None]
        if self.transform == 1:
            unmoved = self.critical_depth * (self.s - self.stretching) + h * self.stretching
            return np.asarray(zeta - (unmoved + zeta * (1.0 + unmoved / h)))
        share = (self.critical_depth * self.s + h * self.stretching) / (self.critical_depth + h)
        return np.asarray(-(zeta + h) * share)


def depth_axis(files: FieldFiles, along: str, names: Sequence[str] = ("depth", "Depth", "lev", "z")) -> Array:
    """Depths of fixed levels [m]; heights count as depths."""
    name = files.required("the depth", along, *names)
    return np.abs(files.fixed(name))


def good_down_to(depth: Array | float) -> Array:
    """Depth to which a column is good that reaches down to a depth [m]: as records are, see `DEPTH_MARGIN`."""
    return np.asarray(depth + np.maximum(DEPTH_MARGIN, DEPTH_SHARE * np.asarray(depth)))
