"""Instruments as trials: each measures one parameter of one effect, as the catalogue declares it."""

from collections.abc import Mapping, Sequence

import numpy as np

from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.inference.trials.prediction import Prediction
from missionplan.diagnosis.next_trial.belief import Believed
from missionplan.effects import CATALOGUE
from missionplan.effects.info import Instrument


def instruments_for(believed: Sequence[Believed]) -> Mapping[Coordinate, Instrument]:
    """Return the instruments that measure a strength of a possible cause, by its coordinate."""
    found = {}
    for each in believed:
        for coordinate in each.coordinates:
            instrument = CATALOGUE[coordinate.effect].instrument
            if coordinate.effect not in each.causes or coordinate.kind != "strength" or instrument is None:
                continue
            if instrument.parameter == coordinate.name:
                found[coordinate] = instrument
    return found


def measured(instrument: Instrument, coordinate: Coordinate, believed: Sequence[Believed]) -> list[Prediction]:
    """Return one reading of an instrument as each set of causes predicts it.

    Parameters
    ----------
    instrument : Instrument
    coordinate : Coordinate
        What it measures.
    believed : sequence of Believed
        Under those without the effect the parameter is nil, to within its spike.
    """
    found = []
    for each in believed:
        column = np.array([[float(_is_same(own, coordinate)) for own in each.coordinates]])
        spike = 0.0 if column.any() else coordinate.spike
        noise = np.array([[instrument.sd**2 + spike**2]])
        found.append(Prediction(column @ each.explanation.mean, column, noise))
    return found


def _is_same(own: Coordinate, other: Coordinate) -> bool:
    return (own.effect, own.name, own.kind) == (other.effect, other.name, other.kind)
