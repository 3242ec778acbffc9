"""Whether a claimed cause is the same in all dives: its strength against one that differs from dive to dive."""

import numpy as np

from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.inference.adequacy.axes import differing
from missionplan.diagnosis.inference.adequacy.discrepancy import THRESHOLD, along_each_axis
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.results.learned.evidence import Causes


def not_constant(model: DescentModel, fit: CauseFit) -> Causes:
    """Return the causes whose strengths differ from dive to dive.

    A strength of each dive beside the common one, independent normals of unknown size, against none: the Bayes factor
    is averaged over the sizes and over the grid of noises, so that it says more than the scatter from dive to dive that
    every model allows. A line that jams on its spool in some dives looks like a late clock, but not like the same one
    in all.

    Parameters
    ----------
    model : DescentModel
        Of the dives.
    fit : CauseFit
        The claimed set.
    """
    counts = [len(rows) for rows in model.parts]
    own = np.repeat(np.eye(len(counts)), counts, axis=0)
    strengths = [
        differing(coordinate.effect, own * fit.state.linear.columns[:, [index]])
        for index, coordinate in enumerate(model.coordinates)
        if coordinate.effect in fit.causes and coordinate.kind != "shape"
    ]
    found = {
        axis.description for axis, value in along_each_axis(model.residuals_along(fit, strengths)) if value > THRESHOLD
    }
    return tuple(name for name in fit.causes if name in found)
