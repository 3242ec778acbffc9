"""The result of an import, from a track cut into legs."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import yaml

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.importers.legs.cutting import LEG_COLUMNS, CutTrack, cut
from missionplan.importers.legs.rules import LegRules
from missionplan.importers.prospects import prospects
from missionplan.importers.starter import LegNumbers, mission_text, numbers_of
from missionplan.importers.track import Fixes, Positions, Track
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.site import Geographic
from missionplan.results.base import Provenance
from missionplan.results.imported import ImportedData, SourceEntry, TrackLines

_DRAWN = 4000
"""Readings of depth that the report draws."""
_UTC = "times without a zone are taken as UTC"


@dataclass(frozen=True)
class Reading:
    """A track as read, and where it comes from.

    Attributes
    ----------
    track : Track
    name : str
        Of the data set.
    sources : tuple of SourceEntry
    passed_over : tuple of str
        Files that were not read, with the reason.
    options : Mapping
        As the report tells them.
    began : float
        When the import began, by the performance counter [s].
    """

    track: Track
    name: str
    sources: tuple[SourceEntry, ...]
    passed_over: tuple[str, ...]
    options: Mapping[str, object]
    began: float

    def provenance(self, mission: str, notices: tuple[str, ...]) -> Provenance:
        """Return the provenance of the result, with the starter mission's data."""
        elapsed = time.perf_counter() - self.began
        counted = len(self.passed_over)
        left = (f"{counted} file{'s were' if counted > 1 else ' was'} passed over",) if counted else ()
        told = (*self.track.notices, *notices, *left, _UTC)
        data = yaml.safe_load(mission) if mission else {}
        inputs = {"logs": {each.name: each.sha256 for each in self.sources}}
        return Provenance("import", self.name, "", 0, 0, self.options, elapsed, data, told, inputs)

    @property
    def source(self) -> str:
        """Where the data come from, for ``dataset.yaml``."""
        files = len(self.sources)
        return f"Imported from {files} {self.track.format} log{'s' if files > 1 else ''} by missionplan import."


def transit_data(reading: Reading, rules: LegRules) -> ImportedData:
    """Make a data set of legs.

    Raises
    ------
    InputError
        When the track has no dive between fixes, or none with a dead-reckoned end.
    """
    parts = cut(reading.track, rules)
    _check_found(reading.track, parts)
    found = numbers_of(parts.legs)
    text = mission_text(reading.name, found)
    mission_file = "mission.yaml"
    return ImportedData(
        provenance=reading.provenance(text, (*_of_current(parts, rules), *parts.notices)),
        kind="transit",
        name=reading.name,
        format=reading.track.format,
        dataset={
            "kind": "transit",
            "name": reading.name,
            "file": "legs.csv",
            "noise": {"fix": f"{found.fix_sd:.3g} m"},
            "source": reading.source,
        },
        table=_rounded(parts.legs[list(LEG_COLUMNS)]),
        dives=_rounded(parts.dives),
        sources=reading.sources,
        passed_over=reading.passed_over,
        reckoning=parts.reckoning,
        rejected_fixes=_rejected(parts),
        mission_text=text,
        can_show=prospects(parts.legs, found),
        next_commands=(f"missionplan diagnose {mission_file} .", f"missionplan simulate {mission_file}"),
        figures=_figures(parts, found),
        lines=_lines(parts, found),
    )


def _check_found(track: Track, parts: CutTrack) -> None:
    good, rejected = len(parts.fixes.good), len(parts.fixes.rejected)
    if good < 2:
        message = f"{good} fixes that count ({rejected} do not): a leg needs one before and one after a dive"
        hint = parts.fixes.reasons[0] if parts.fixes.reasons else "are there fixes in these files?"
        raise InputError([Problem(message, hint=hint)])
    if not len(parts.dives):
        deepest = float(track.depth.values.max()) if len(track.depth) else float("nan")
        message = f"no dive between {good} fixes; the greatest depth is {deepest:.1f} m"
        raise InputError([Problem(message, hint="--dive-depth says how deep a dive goes")])
    if not len(parts.legs):
        reason = str(parts.dives["reason"].iloc[0])
        message = f"{len(parts.dives)} dives, but none has a dead-reckoned end: {track.reckoning} ({reason})"
        hint = "dead reckoning can be made from heading with speed, or with pitch and depth"
        raise InputError([Problem(message, hint=hint)])


def _of_current(parts: CutTrack, rules: LegRules) -> tuple[str, ...]:
    """Say whether the vehicle's dead reckoning is carried with a current of its own, and what was done about it."""
    current = parts.current
    if current is None:
        return ()
    if not np.isfinite(current.share):
        return ("the vehicle logs an estimate of the current; the legs do not show whether its dead reckoning has it",)
    measured = f"{current.share:.2f} ± {current.sd:.2f} of the current that the vehicle estimates"
    if not current.is_in:
        return (f"the dead reckoning holds {measured}: it is taken to hold none of it",)
    done = (
        "it was taken out"
        if rules.take_out_current
        else "it was left in: a leg's error is what that estimate did not foresee (--take-out-current removes it)"
    )
    return (f"the vehicle's dead reckoning holds {measured}: {done}",)


def _rounded(table: pd.DataFrame) -> pd.DataFrame:
    """Round to what logs hold: centimetres, milliseconds, and 1 cm of latitude."""
    digits = {name: 7 if name.startswith(("lat_", "lon_")) else 3 for name in table.columns}
    return table.round(
        {
            **digits,
            "heading_deg": 1,
            "depth_m": 2,
            "dr_sd_m": 1,
            "max_depth_m": 2,
            "surface_s": 1,
            "lag_dr_end_s": 1,
            "rpm": 1,
        }
    )


def _rejected(parts: CutTrack) -> pd.DataFrame:
    fixes = parts.fixes.rejected
    columns = {"t_s": fixes.t, "lat": fixes.latitude, "lon": fixes.longitude, "hdop": fixes.hdop}
    return pd.DataFrame({**columns, "satellites": fixes.satellites, "reason": list(parts.fixes.reasons)})


def _figures(parts: CutTrack, found: LegNumbers) -> dict[str, float]:
    return {
        "fixes": len(parts.fixes.good),
        "velocity_error_sigma_m_s": found.sigma,
        "velocity_error_mean_east_m_s": found.mean_error[0],
        "velocity_error_mean_north_m_s": found.mean_error[1],
        "leg_length_m": found.length,
        "leg_duration_s": found.duration,
        "speed_m_s": found.speed,
        "surfacing_time_s": found.surfacing,
        "fix_sd_m": found.fix_sd,
        "record_s": found.record,
        "max_depth_m": found.depth,
        "made_reckoning_sd_m": float(parts.legs["dr_sd_m"].median()) if parts.is_made else float("nan"),
        "current_in_reckoning": parts.current.share if parts.current else float("nan"),
    }


def _lines(parts: CutTrack, found: LegNumbers) -> TrackLines:
    latitude, longitude = float(np.radians(found.latitude)), float(np.radians(found.longitude))
    origin = Geographic.model_construct(latitude=latitude, longitude=longitude)

    def plane(places: Fixes | Positions) -> Array:
        if not len(places):
            return np.empty((2, 0))
        return np.stack(to_plane(np.radians(places.latitude), np.radians(places.longitude), origin))

    def of_dives(name: str) -> Array:
        latitude, longitude = (
            np.radians(parts.dives[f"{axis}_{name}"].to_numpy(dtype=float)) for axis in ("lat", "lon")
        )
        there = np.isfinite(latitude)
        places = np.full((2, len(latitude)), np.nan)
        places[:, there] = to_plane(latitude[there], longitude[there], origin)
        return places

    step = max(len(parts.depth) // _DRAWN, 1)
    return TrackLines(
        fixes=plane(parts.fixes.good),
        rejected=plane(parts.fixes.rejected),
        reckoned=tuple(plane(line) for line in parts.reckoned),
        leg_starts=of_dives("start"),
        leg_ends=np.stack([of_dives("dr_end"), of_dives("end")]),
        depth_t=parts.depth.t[::step],
        depth=parts.depth.values[::step],
    )
