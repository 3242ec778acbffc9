"""The wind of a mission and, trial by trial, the leeway that it gives."""

from pathlib import Path

import numpy as np

from missionplan.arrays import Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.site import Geographic
from missionplan.mission.schema.wind import LeewaySection, WindFile
from missionplan.mission.views import required_origin
from missionplan.montecarlo.streams import NormalSource
from missionplan.phases.currents import Current, layers
from missionplan.phases.leeway import Leeway
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.scenario.site_current import is_netcdf, mission_places
from missionplan.store.paths import matching

STREAM = "vehicle.leeway"
"""Of the scatter of leeway and the side of its crosswind part."""


def recorded_wind(mission: Mission[object]) -> Current | None:
    """Read the file of a mission's wind; None where it has none.

    Raises
    ------
    InputError
        When it cannot be read, or the mission lacks the `start` or the `site.origin` that it needs.
    """
    written = mission.site.wind if mission.site else None
    if not isinstance(written, WindFile):
        return None
    if not is_netcdf(written.file):
        return _series(Path(written.file), mission, written)
    if written.start is not None:
        message = "a NetCDF wind has dates of its own; `start` is for a CSV record that counts seconds"
        raise InputError([Problem(message, mission.file, key="site.wind.start")])
    if mission.start is None:
        raise InputError([Problem("a NetCDF wind needs the mission's `start` (UTC)", written.file)])
    return _field(written.file, required_origin(mission, "a NetCDF wind is placed by it"), mission)


def _series(path: Path, mission: Mission[object], written: WindFile) -> SeriesCurrent:
    from missionplan.scenario.currents.csv_series import WIND_LIMITS, read_series_csv  # pandas: half a second

    series = read_series_csv(path, WIND_LIMITS, mission.start, written.start)
    return SeriesCurrent(series.time, series.depth, series.east, series.north)


def _field(name: str, origin: Geographic, mission: Mission[object]) -> Current:
    from missionplan.scenario.currents.area import Area
    from missionplan.scenario.currents.field import read_field
    from missionplan.scenario.currents.files import WIND

    assert mission.start is not None
    start = np.datetime64(round(mission.start.timestamp() * 1e6), "us").astype("datetime64[ns]")
    return read_field(matching(name), Area(origin, start, mission_places(mission, origin)), name, carries=WIND)


def leeway(drawn: Mission[Scalars], recorded: Current | None, source: NormalSource | None, size: int) -> Leeway | None:
    """Return the leeway of a block of trials; None in a mission without wind.

    Parameters
    ----------
    drawn : Mission of float or array, shape (n,)
    recorded : Current or None
        The wind, where a file has it.
    source : NormalSource or None
        Of the scatter and the side of the crosswind part; None: at their means, which are zero.
    size : int
        Trials.
    """
    written = drawn.site.wind if drawn.site else None
    if written is None:
        return None
    section = (drawn.vehicle.leeway if drawn.vehicle else None) or LeewaySection()
    wind = recorded
    if wind is None and not isinstance(written, WindFile):
        wind = layers([np.inf], [written.speed], [np.asarray(written.blows_from) + np.pi])
    if wind is None:
        raise AssertionError("a wind is steady or recorded")  # as its section is read
    if source is None:
        return Leeway(wind, section.downwind, 0.0, section.downwind_offset, 0.0)
    along, across = section.scatter * source.legs(STREAM).leg(0)[:, :size]
    side = np.sign(source.legs(STREAM).leg(1)[0, :size])
    return Leeway(wind, section.downwind, side * section.crosswind, section.downwind_offset + along, across)
