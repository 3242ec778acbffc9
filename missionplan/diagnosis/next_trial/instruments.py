"""Instruments as trials: each measures one parameter of one effect, as the catalogue declares it."""

from collections.abc import Mapping, Sequence

import numpy as np

from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.inference.trials.experiment import Prediction
from missionplan.diagnosis.next_trial.belief import Believed
from missionplan.effects import CATALOGUE
from missionplan.effects.info import Instrument


def instruments_for(believed: Sequence[Believed], coordinates: Sequence[Coordinate]) -> Mapping[int, Instrument]:
    """Return the instruments that measure a strength of a possible cause, by the index of its coordinate."""
    possible = {cause for each in believed for cause in each.causes}
    found = {}
    for index, coordinate in enumerate(coordinates):
        instrument = CATALOGUE[coordinate.effect].instrument
        if instrument is None or coordinate.effect not in possible or coordinate.kind != "strength":
            continue
        if instrument.parameter == coordinate.name:
            found[index] = instrument
    return found


def measured(
    instrument: Instrument, index: int, coordinate: Coordinate, believed: Sequence[Believed]
) -> list[Prediction]:
    """Return one reading of an instrument as each set of causes predicts it.

    Parameters
    ----------
    instrument : Instrument
    index, coordinate : int, Coordinate
        What it measures.
    believed : sequence of Believed
        Under those without the effect the parameter is as the mission expects it, to within its spike.
    """
    found = []
    for each in believed:
        places = each.posterior.places
        column = (places == index).astype(float)[None, :]
        spike = 0.0 if column.any() else coordinate.spike
        noise = np.array([[instrument.sd**2 + spike**2]])
        found.append(Prediction(each.posterior.mean[[index]], column, noise))
    return found
