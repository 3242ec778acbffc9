"""The record of the current that the cells of an exploration share: read once, and moved in time with their start."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta

from missionplan.mission import Mission
from missionplan.phases.currents import Current
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.scenario.site_current import current_source, is_netcdf, recorded_current
from missionplan.studies.exploration.key_paths import with_values


@dataclass(frozen=True)
class SharedCurrent:
    """A record of the current, read for one mission.

    Attributes
    ----------
    current : Current or None
        None where missions have none, or each reads its own.
    place : mapping
        What the record depends on besides the start; a mission with anything else reads its own.
    start : datetime or None
        Of the mission that it was read for.
    moves : bool
        Whether a later start meets a later part of it.
    """

    current: Current | None
    place: Mapping[str, object]
    start: datetime | None
    moves: bool

    @classmethod
    def of(cls, mission: Mission, first: datetime | None = None) -> "SharedCurrent":
        """Read a mission's record. A field has dates; others show by a second start whether they are tied to the clock.

        Parameters
        ----------
        mission : Mission
        first : datetime, optional
            Earliest start of all: what is read begins there, and may hold nothing from before.
        """
        if mission.start is None or first is None:
            return cls(recorded_current(mission), _place(mission), mission.start, moves=False)
        hour = timedelta(hours=1)
        early, later = (_with_start(mission, start) for start in (first, first + hour))
        current = recorded_current(early)
        if _is_field(mission):
            return cls(current, _place(mission), early.start, moves=True)
        shifted = recorded_current(later)
        if not isinstance(current, RecordedCurrent) or not isinstance(shifted, RecordedCurrent):
            return cls(None, {}, None, moves=False)  # each start reads its own
        by = float(current.time[-1] - shifted.time[-1])
        if not math.isclose(by, hour.total_seconds()) and by != 0.0:
            return cls(None, {}, None, moves=False)  # cut to the mission's time: each start reads its own part
        return cls(current, _place(mission), early.start, moves=by != 0.0)

    def for_mission(self, mission: Mission) -> Current | None:
        """Return the record as a mission with another start meets it; read anew for a mission at another place."""
        if _place(mission) != self.place:
            return recorded_current(mission)
        current = self.current
        if not self.moves or not isinstance(current, RecordedCurrent) or mission.start is None or self.start is None:
            return current
        later = (mission.start - self.start).total_seconds()
        return current.later(later) if later else current


def _is_field(mission: Mission) -> bool:
    written = current_source(mission)
    return written is not None and all(is_netcdf(name) for name in written.members)


def _place(mission: Mission) -> dict[str, object]:
    """What is read about: the record itself, and where the mission goes."""
    site, goes = mission.raw.get("site"), [(phase.start, phase.to) for phase in mission.transits]
    keys = ("current", "origin", "depth")
    return {"goes": goes} | ({key: site.get(key) for key in keys} if isinstance(site, Mapping) else {})


def _with_start(mission: Mission, start: datetime) -> Mission:
    return Mission.from_data(with_values(mission.raw, {"start": start.isoformat()}), file=mission.file)
