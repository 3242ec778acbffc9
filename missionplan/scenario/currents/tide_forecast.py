"""The tide of a mission's site at its date: constituents with Greenwich phases as waves from the mission's start."""

import math

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.site import TidalConstituent, TidalCurrent
from missionplan.mission.views import required_origin
from missionplan.phases.tidal_stream import EVER, TidalStream
from missionplan.physics.tides import angular_frequencies, nodal_state


def tidal_stream(mission: Mission, written: TidalCurrent) -> TidalStream:
    """Build the current of `site.current.tide`.

    Parameters
    ----------
    mission : Mission
        With a start, which ties the phases to the moon, and an origin, on whose latitude nodal corrections depend.
    written : TidalCurrent

    Raises
    ------
    InputError
        When one of them is missing.
    """
    if mission.start is None:
        message = "a tide with phases at Greenwich needs the mission's `start` (UTC)"
        raise InputError([Problem(message, mission.file, key="start")])
    origin = required_origin(mission, "the tide's nodal corrections depend on its latitude")
    depths = written.tide.depths
    names = sorted({wave.name for depth in depths for wave in depth.constituents})
    state = nodal_state(names, mission.start.timestamp(), origin.latitude) if names else None
    waves = np.zeros((2, len(names), len(depths)), dtype=complex)
    for column, depth in enumerate(depths):
        for wave in depth.constituents:
            waves[:, names.index(wave.name), column] += _coefficients(wave)
    if state is not None:  # f·A·cos(V + u + ωt − g): turned to the mission's start
        waves *= (state.factor * np.exp(1j * (state.argument + state.angle)))[:, None]
    return TidalStream(
        time=EVER,
        depth=np.array([depth.depth for depth in depths]),
        mean=np.array([[depth.east for depth in depths], [depth.north for depth in depths]]),
        frequency=angular_frequencies(names) if names else np.zeros(0),
        cosine=waves.real,
        sine=-waves.imag,
        outside=written.outside,
    )


def _coefficients(wave: TidalConstituent) -> "np.ndarray[tuple[int], np.dtype[np.complex128]]":
    """East and north of an ellipse, of which the velocity is the real part times exp(i·argument) [m/s]."""
    along, across = wave.major * np.exp(-1j * wave.phase), -1j * wave.minor * np.exp(-1j * wave.phase)
    sine, cosine = math.sin(wave.toward), math.cos(wave.toward)
    return np.array([along * sine - across * cosine, along * cosine + across * sine])
