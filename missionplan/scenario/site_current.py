"""The site's current where a mission reads it from files.

The tide of a mission's site at its date: constituents with Greenwich phases as waves from the mission's start.

The current of a block of trials: a recorded one or a member of an ensemble, with the error expected of it; and the
members one by one: what is expected stays, and all trials sail in one of them.

The wind of a mission and, trial by trial, the leeway that it gives.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.includes import REMOTE
from missionplan.mission.schema.site import CurrentFile, LeewaySection, TidalCurrent, WindFile
from missionplan.mission.views import forecast_error, required_origin
from missionplan.montecarlo.streams import CommonStreams, NormalSource, block_count, block_size
from missionplan.phases.currents import Current, Leeway, layers
from missionplan.phases.ensemble import NORMALS, WAVES, Ensemble, ErringCurrent, ErrorWaves, Statistics
from missionplan.phases.recorded_currents import EVER, RecordedCurrent, TidalStream
from missionplan.physics.water import angular_frequencies, nodal_state
from missionplan.store.folder import matching


def tidal_stream(mission: Mission, written: TidalCurrent) -> TidalStream:
    """Build the current of `site.current.tide`.

    Raises InputError when the mission lacks the start, which ties the phases to the moon, or the origin, on whose
    latitude nodal corrections depend.
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
            along, across = wave.major * np.exp(-1j * wave.phase), -1j * wave.minor * np.exp(-1j * wave.phase)
            sine, cosine = math.sin(wave.toward), math.cos(wave.toward)
            waves[:, names.index(wave.name), column] += np.array(
                [along * sine - across * cosine, along * cosine + across * sine]
            )
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


NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")
"""Endings of files that are read as NetCDF; others are read as CSV."""


def recorded_current(mission: Mission, also: Array | None = None) -> Current | None:
    """Read the files of a mission's current, or forecast its tide; None where it has neither.

    Raises InputError when they cannot be read, or the mission lacks the `start` or the `site.origin` that a NetCDF
    field needs, which is read about the places `also`, shape (2, k) [m], besides the mission's.
    """
    if mission.site and isinstance(mission.site.current, TidalCurrent):
        return tidal_stream(mission, mission.site.current)
    written = current_source(mission)
    if written is None:
        return None
    return replace(_members(mission, written, also), outside=written.outside)


def current_source(mission: Mission) -> CurrentFile | None:
    """Return what the mission says of its current's files; None where it reads none."""
    written = mission.site.current if mission.site else ()
    return written if isinstance(written, CurrentFile) else None


def is_netcdf(name: str) -> bool:
    """Whether a file, a pattern or an address is read as NetCDF."""
    return name.startswith(REMOTE) or Path(name).suffix.lower() in NETCDF


def _members(mission: Mission, written: CurrentFile, also: Array | None) -> RecordedCurrent:
    """Read the current, or all members of an ensemble: files of their own, or along a dimension of one."""
    names: list[tuple[str, int | None, str]] = [(name, None, Path(name).name) for name in written.members]
    if len(names) == 1 and is_netcdf(written.members[0]):
        from missionplan.scenario.currents.reading import member_count

        count = member_count(matching(written.members[0]), written.members[0])
        if count > 1:
            names = [(written.members[0], number, f"member {number + 1}") for number in range(count)]
    if len(names) == 1:
        return _read(mission, written, written.members[0], also)
    weights = written.weights or (1.0,) * len(names)
    if len(weights) != len(names):
        message = f"{len(weights)} weights for {len(names)} members"
        raise InputError([Problem(message, mission.file, key="site.current.weights")])
    shown = [name for *_, name in names]
    shown = shown if len(set(shown)) == len(shown) else [name for name, *_ in names]
    return Ensemble.of([_read(mission, written, name, also, number) for name, number, _ in names], shown, weights)


def _read(
    mission: Mission, written: CurrentFile | WindFile, name: str, also: Array | None = None, member: int | None = None
) -> RecordedCurrent:
    """Read one file of a current or of a wind."""
    key = "current" if isinstance(written, CurrentFile) else "wind"
    if not is_netcdf(name):
        from missionplan.scenario.currents.reading import CURRENT_LIMITS, WIND_LIMITS, read_series_csv  # pandas: slow

        is_current = isinstance(written, CurrentFile)
        if is_current and "*" in name:
            message = f"given {name}; a pattern is for NetCDF files, a CSV record is one file"
            raise InputError([Problem(message, mission.file, key="site.current.file")])
        limits = CURRENT_LIMITS if is_current else WIND_LIMITS
        return read_series_csv(Path(name), limits, mission.start, written.start)
    if written.start is not None:
        message = f"a NetCDF {key} has dates of its own; `start` is for a CSV record that counts seconds"
        raise InputError([Problem(message, mission.file, key=f"site.{key}.start")])
    if mission.start is None:
        raise InputError([Problem(f"a NetCDF {key} needs the mission's `start` (UTC)", name)])
    from missionplan.scenario.currents.area import Area
    from missionplan.scenario.currents.files import SEA, WIND
    from missionplan.scenario.currents.reading import read_field
    from missionplan.scenario.place import mission_places

    origin = required_origin(mission, f"a NetCDF {key} is placed by it")
    start = np.datetime64(round(mission.start.timestamp() * 1e6), "us").astype("datetime64[ns]")
    places = np.hstack((np.zeros((2, 1)), mission_places(mission), *(() if also is None else (also,))))
    projection, carries = (written.projection, SEA) if isinstance(written, CurrentFile) else (None, WIND)
    return read_field(matching(name), Area(origin, start, places, projection), name, member, carries)


STREAM = "vehicle.leeway"
"""Of the scatter of leeway and the side of its crosswind part."""


def recorded_wind(mission: Mission) -> Current | None:
    """Read the file of a mission's wind; None where it has none.

    Raises InputError when it cannot be read, or the mission lacks the `start` or the `site.origin` that it needs.
    """
    written = mission.site.wind if mission.site else None
    if not isinstance(written, WindFile):
        return None
    return _read(mission, written, written.file)


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


ERROR = "site.current.error"
"""Key path of the error, and name of its stream."""
MEMBER = "site.current.member"
"""Name of which member of an ensemble a trial sails in, and of its stream."""


def error_statistics(mission: Mission[Scalars]) -> Statistics | None:
    """Return the statistics of a forecast's error, as drawn; None where the mission expects none."""
    error = forecast_error(mission)
    return None if error is None else Statistics(error.sigma, error.time, error.length)


def with_member(recorded: Current, source: NormalSource, size: int) -> Current:
    """Return an ensemble with a member drawn for each trial; any other current as it is."""
    if not isinstance(recorded, Ensemble):
        return recorded
    return recorded.drawn(source.legs(MEMBER).leg(0)[0, :size])


def with_error(forecast: Current, statistics: Statistics | None, source: NormalSource, size: int) -> Current:
    """Return a forecast with an error drawn for each trial; itself where there is none."""
    if statistics is None:
        return forecast
    stream = source.legs(ERROR)
    pairs = NORMALS // 2
    normals = np.concatenate([stream.leg(number)[:, :size] for number in range(pairs * WAVES)])
    waves = normals.reshape(WAVES, NORMALS, size).transpose(1, 0, 2)
    return ErringCurrent(forecast, ErrorWaves.drawn(statistics, waves))


def members_of(recorded: Current | None) -> tuple[tuple[str, float], ...]:
    """Names and probabilities of the members of an ensemble; none where the current is none."""
    if not isinstance(recorded, Ensemble):
        return ()
    return tuple(zip(recorded.names, recorded.weights.tolist(), strict=True))


def members_drawn(recorded: Current | None, seed: int, trials: int) -> NDArray[np.intp] | None:
    """Return which member each trial of a run sails in, shape (n,); None where there is no ensemble."""
    if not isinstance(recorded, Ensemble):
        return None
    streams, members = CommonStreams(seed), []
    for block in range(block_count(trials)):
        drawn = with_member(recorded, streams.of_block(block), block_size(trials, block))
        if isinstance(drawn, Ensemble) and drawn.chosen is not None:
            members.append(drawn.chosen)
    return np.concatenate(members)
