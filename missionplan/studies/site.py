"""The site of a mission as the phases see it: positions on the plane, and the current."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missionplan.mission import Mission
from missionplan.mission.current_files import CurrentField, CurrentSeries, read_current_csv, read_current_netcdf
from missionplan.mission.geodesy import to_plane
from missionplan.mission.site import CurrentFile, Geographic, Site
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.currents import Current, FieldCurrent, SeriesCurrent, filled, layers

Array = NDArray[np.float64]
Drawn = Mapping[str, float | Array]
"""Every quantity of a mission by its key path, drawn for a block of trials."""


def means(mission: Mission) -> Drawn:
    """Give every quantity at its mean."""
    return {path: mean_of(quantity) for path, quantity in mission.quantities().items()}


def position(mission: Mission, given: Geographic | tuple[object, object], path: str, drawn: Drawn) -> Array:
    """Place a position of the mission on the plane, shape (2,) or, where it is uncertain, (2, n) [m]."""
    if isinstance(given, Geographic):
        assert mission.site is not None
        assert mission.site.origin is not None
        east, north = to_plane(np.array(given.latitude), np.array(given.longitude), mission.site.origin)
        return np.array([float(east), float(north)])
    return np.stack(np.broadcast_arrays(*(np.asarray(drawn[f"{path}[{axis}]"]) for axis in (0, 1))))


def site_current(mission: Mission, drawn: Drawn) -> Current | None:
    """Build the site's current from the draws of a block, or from `means`; None in still water.

    Raises
    ------
    InputError
        When its file cannot be read.
    """
    site = mission.site
    if site is None or not site.current:
        return None
    if isinstance(site.current, CurrentFile):
        return _current_of_file(mission, site, site.current)
    return layers(
        down_to=[mean_of(layer.down_to) for layer in site.current],
        speed=[drawn[f"site.current[{index}].speed"] for index in range(len(site.current))],
        toward=[drawn[f"site.current[{index}].toward"] for index in range(len(site.current))],
    )


def _current_of_file(mission: Mission, site: Site, given: CurrentFile) -> Current:
    path = Path(mission.file).parent / given.file
    if path.suffix == ".csv":
        series: CurrentSeries = read_current_csv(path)
        return SeriesCurrent(series.time, series.depth, series.east, series.north)
    field: CurrentField = read_current_netcdf(path, mission.start)
    # without an origin the plane's is the middle of the field
    origin = site.origin or Geographic.model_construct(
        latitude=float(np.mean(field.latitude)), longitude=float(np.mean(field.longitude))
    )
    _, north = to_plane(field.latitude, np.full_like(field.latitude, origin.longitude), origin)
    east, _ = to_plane(np.full_like(field.longitude, origin.latitude), field.longitude, origin)
    return FieldCurrent(field.time, field.depth, north, east, filled(field.east), filled(field.north))
