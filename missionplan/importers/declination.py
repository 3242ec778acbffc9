"""The declination that a vehicle uses, against that of the World Magnetic Model."""

from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from missionplan.importers.track import Series, Track
from missionplan.packages import how_to_install

WRONG = 1.5
"""Difference from the model beyond which a vehicle's declination is called wrong [deg]: the model's own error is about
0.5 deg, vehicles round to whole degrees."""
_INSTALL = f"{how_to_install('magnetic')} to check it"


class _Declination(Protocol):
    d: float


class _Model(Protocol):
    def calculate(
        self, *, glat: float, glon: float, alt: float, time: float, allow_date_outside_lifespan: bool
    ) -> _Declination: ...


_MODELS = ("WMM_2010", "WMM_2015v2", "WMM_2020", "WMM_2025")


def model_declination(latitude: float, longitude: float, t: float) -> float | None:
    """Return the declination of the World Magnetic Model [deg, east positive], or None without its package.

    Before 2010 and after 2030 the nearest of its five-year models is extrapolated by at most two years; beyond, there
    is none.

    Parameters
    ----------
    latitude, longitude : float
        [deg].
    t : float
        Since 1970 [s].
    """
    if find_spec("pygeomag") is None:
        return None
    moment = datetime.fromtimestamp(t, UTC)
    begun = datetime(moment.year, 1, 1, tzinfo=UTC)
    year = moment.year + (moment - begun).total_seconds() / (365.2425 * 86400.0)
    if not 2008.0 <= year <= 2032.0:
        return None
    which = min(max(int((year - 2010.0) // 5), 0), len(_MODELS) - 1)
    found = _model(_MODELS[which]).calculate(
        glat=latitude, glon=(longitude + 180.0) % 360.0 - 180.0, alt=0.0, time=year, allow_date_outside_lifespan=True
    )
    return float(found.d)


@lru_cache(maxsize=4)
def _model(name: str) -> _Model:
    model: _Model = import_module("pygeomag").GeoMag(coefficients_file=f"wmm/{name}.COF")
    return model


def with_declination(track: Track) -> Track:
    """Check a vehicle's declination, and take the model's where headings are magnetic and none was logged."""
    if not len(track.heading) or not len(track.fixes) or track.heading_from == "true":
        return track
    middle = len(track.fixes) // 2
    place = float(track.fixes.latitude[middle]), float(track.fixes.longitude[middle])
    t = float(track.fixes.t[middle])
    model = model_declination(*place, t)
    if not len(track.declination):
        return _without_own(track, t, model)
    own = _own(track)
    if model is None:
        notice = f"the vehicle's declination, {own:.1f} deg, was not checked: {_INSTALL}"
    elif abs(own - model) > WRONG:
        notice = (
            f"the vehicle's declination is {own:.1f} deg, but the World Magnetic Model has {model:.1f} deg there and "
            f"then: its dead reckoning is turned by {own - model:+.1f} deg, which looks like an error of the compass"
        )
    else:
        notice = f"the vehicle's declination, {own:.1f} deg, is that of the World Magnetic Model, {model:.1f} deg"
    return replace(track, notices=(*track.notices, notice))


def _own(track: Track) -> float:
    """Median of the vehicle's declinations, but for the zeros before it knew one."""
    told = track.declination.values[track.declination.values != 0.0]
    return float(np.median(told)) if len(told) else 0.0


def _without_own(track: Track, t: float, model: float | None) -> Track:
    if track.heading_from != "magnetic":
        return track
    if model is None:
        notice = f"no declination is logged: headings are taken as from true north ({_INSTALL}, and to add it)"
        return replace(track, notices=(*track.notices, notice))
    notice = f"no declination is logged: that of the World Magnetic Model, {model:.1f} deg, is used"
    return replace(track, declination=Series(np.array([t]), np.array([model])), notices=(*track.notices, notice))
