"""Heavy-tailed velocity errors: occasionally far larger than usual."""

from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import TransitEffect


@dataclass(frozen=True)
class HeavyTails(TransitEffect):
    """Student-t velocity error with `dof` degrees of freedom (above 2), of the same covariance as before.

    A leg's error is a normal one times √((ν − 2)/χ²_ν), one χ² for both components.
    """

    dof: Scalars = np.inf

    @property
    def is_random(self) -> bool:
        """It needs normals of its own for each leg."""
        return bool(np.any(np.isfinite(self.dof)))

    def tail_dof(self) -> Scalars:
        """Return the degrees of freedom."""
        return self.dof

    def error_scale(self, normals: Array) -> Array:
        """Return the factor on each leg's random velocity error, shape (n,), from the first of its normals."""
        finite = np.isfinite(self.dof)
        dof = np.where(finite, self.dof, 4.0)
        chi_squared = 2.0 * scipy.special.gammaincinv(0.5 * dof, scipy.special.ndtr(normals[0]))
        return np.where(finite, np.sqrt((dof - 2.0) / chi_squared), 1.0)


INFO = EffectInfo(
    id="heavy-tails",
    phase="transit",
    tier="statistical",
    effect=HeavyTails,
    parameters={
        "dof": Parameter(
            "",
            "degrees of freedom; normal errors at infinity",
            2.05,
            1e6,
            median=4.0,
            factor=1.6,
            reciprocal_is_uniform=True,
            default=np.inf,
        )
    },
    what="Most legs are as accurate as expected and a few are bad: fronts, a bad fix, a propeller fouled for one leg.",
    finding=Finding(
        "",
        "some legs err far more than the others",
        remedy="look at the worst legs one by one: a current, a wrong fix or a bad record",
    ),
    sizes="3 to 6 degrees of freedom in navigation logs with occasional bad legs.",
    confused_with=("fix-error", "persistent-error"),
    distinguished_by="The log of the bad legs: number of satellites, currents, revolutions.",
    part="covariance",
    exclusive_group="velocity error from leg to leg",
)
