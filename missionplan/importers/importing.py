"""`import`: a vehicle's own logs to a data set, with a report of what was made of them and a starter mission."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path, PurePath
from typing import Literal

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.importers.building import Reading, transit_data
from missionplan.importers.declination import with_declination
from missionplan.importers.descents import descent_data, read_marks
from missionplan.importers.formats import known_importers
from missionplan.importers.importer import Identity, ReadOptions, SourceLog
from missionplan.importers.legs.rules import LegRules
from missionplan.importers.mapping import read_mapping
from missionplan.importers.shifting import shifted
from missionplan.importers.sources import find_sources, of_one
from missionplan.importers.track import Track
from missionplan.results.imported import ImportedData, SourceEntry
from missionplan.store.paths import as_path

KINDS = ("transit", "descent")


def import_logs(
    sources: str | Path | Sequence[str | Path],
    *,
    format: str | None = None,
    kind: Literal["transit", "descent"] = "transit",
    names: Sequence[str] = (),
    cache: str | Path | None = None,
    name: str | None = None,
    shift_origin: tuple[float, float] | None = None,
    rules: LegRules | None = None,
    marks: Sequence[str] = (),
    vehicle: str | None = None,
    deployment: str | None = None,
    is_strict: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> ImportedData:
    """Make a data set of a vehicle's logs.

    Parameters
    ----------
    sources : str, Path or sequence of them
        Files and folders.
    format : str, optional
        Of the logs; default: as recognised.
    kind : str
        ``transit`` (legs between fixes) or ``descent`` (dives).
    names : sequence of str
        What the source calls things, `lat=Latitude[deg]`, or YAML files of it.
    cache : str or Path, optional
        Folder of the sensor lists of Slocum gliders; default: beside the files.
    name : str, optional
        Of the data set; default: the vehicle's.
    shift_origin : tuple of float, optional
        Latitude and longitude [deg] of a made-up place that the first fix is moved to, and all else with it.
    rules : LegRules, optional
        For legs.
    marks : sequence of str
        Times at which an anchor separated, ISO 8601 or seconds since 1970, for dives.
    vehicle, deployment : str, optional
        Which to read, where the files are of several; a deployment may be the date it began, 2026-05-01.
    is_strict : bool
        Whether a damaged file ends the import; else it is named and passed over.
    progress : callable, optional
        Called with the number of files done and of all.

    Raises
    ------
    InputError
        When a source is missing, of no known format or of several vehicles, or holds no dives between fixes.
    """
    began, rules = time.perf_counter(), rules or LegRules()
    if kind not in KINDS:
        message = f"given {shown(kind)}, expected {' or '.join(KINDS)}"
        raise InputError([Problem(message, key="kind", hint=did_you_mean(str(kind), KINDS))])
    mapping = read_mapping(names)
    several = [sources] if isinstance(sources, str | PurePath) else sources
    paths = [as_path(each, "sources") for each in several]
    importers, left_out = known_importers()
    if left_out and format not in (None, *importers):
        raise InputError([Problem(f"no format of the name {shown(format)}", key="format"), *left_out])
    found = find_sources(paths, importers, format, otherwise="track" if mapping else None)
    found, identity = of_one(found, vehicle, deployment)
    log = SourceLog(progress=progress, is_strict=is_strict)
    options = ReadOptions(mapping, None if cache is None else as_path(cache, "cache"), vehicle)
    track = found.importer.read([each.path for each in found.files], options, log)
    if not log.read:
        raise InputError([*log.passed_over, *found.passed_over])
    track = with_declination(_of_one_deployment(track, None if identity.deployment else deployment))
    track = replace(track, notices=(*track.notices, *map(str, left_out)))
    if shift_origin is not None:
        track = shifted(track, *shift_origin)
    read = set(log.read)
    reading = Reading(
        track=track,
        name=name or _name(track, identity),
        sources=tuple(SourceEntry(each.path.name, each.checksum) for each in found.files if each.path in read),
        passed_over=tuple(str(each) for each in (*log.passed_over, *found.passed_over)),
        options=_options(track, kind, rules, names, shift_origin),
        began=began,
    )
    return transit_data(reading, rules) if kind == "transit" else descent_data(reading, read_marks(marks))


def _of_one_deployment(track: Track, begun: str | None) -> Track:
    """Keep one deployment of a track: they are told apart by a long silence.

    Raises
    ------
    InputError
        With the list, when there are several and none, or none of them, is chosen.
    """
    spans = track.deployments()
    if len(spans) < 2 and begun is None:
        return track
    parts = {f"{datetime.fromtimestamp(part.fixes.t[0], UTC):%Y-%m-%d}": part for part in
             (track.within(*span) for span in spans)}  # fmt: skip
    if begun is not None and begun in parts:
        return parts[begun]
    listed = ", ".join(f"{date} ({len(part.fixes)} fixes)" for date, part in parts.items()) or "none"
    message = f"deployments, by the date of their first fix: {listed}"
    if begun is not None:
        message = f"no deployment {shown(begun)}; {message}"
    hint = f"choose one with --deployment {next(iter(parts), 'DATE')}"
    raise InputError([Problem(message, key="deployment", hint=hint)])


def _name(track: Track, identity: Identity) -> str:
    """Name of a data set: the vehicle's make and its own, and the deployment's."""
    return ", ".join(filter(None, (" ".join(filter(None, (track.name, identity.vehicle))), identity.deployment)))


def _options(
    track: Track, kind: str, rules: LegRules, names: Sequence[str], shift_origin: tuple[float, float] | None
) -> dict[str, object]:
    """Options as the report tells them; the made-up origin is no secret, the true one is not told."""
    return {"format": track.format, "kind": kind, "map": list(names), "shift_origin": shift_origin, **asdict(rules)}
