"""`tide`: constituents with errors, a mean and what is left of a record of a current, and a fragment of a mission.

Read then `result` (with the record that is read) and `harmonic_analysis` (the fit, by UTide).
"""

import math
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from missionplan.errors import InputError, Problem, shown
from missionplan.identity import digest_of_files
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.moments import moment_of
from missionplan.physics.water import DAY
from missionplan.results import Provenance
from missionplan.store.folder import as_path
from missionplan.studies.tide.harmonic_analysis import FORTNIGHT, HALF_A_YEAR, Samples, fit_tide, tidal_velocity
from missionplan.studies.tide.result import CurrentRecord, DepthTide, HeldOut, TideResult, read_current_record

SHORTEST = 1.05 * DAY
"""Of a record: two turns of the semidiurnal tide and one of the diurnal [s]."""
LEAST_SAMPLES = 48
HELD_OUT = 0.25
"""Share of a record, its end, that the tide of the rest forecasts."""
LEAST_FITTED = FORTNIGHT
"""Without this much left to be fitted nothing is held out [s]."""
_NINETY = 1.644854
"""Standard deviations on either side of 90 % of normal numbers."""
_SHOWN = 4000
"""Samples of the picture."""


def tide(
    record: str | Path,
    *,
    latitude: float | str | None = None,
    start: datetime | str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> TideResult:
    """Find the tide in a record of a current meter or an acoustic profiler.

    Parameters
    ----------
    record : str or Path
        CSV with the columns ``t_s, depth_m, east_m_s, north_m_s``, or NetCDF of time and depth.
    latitude : float or str, optional
        North [rad], or text with a unit such as ``37.2 deg``; by default the file's own.
    start : datetime or str, optional
        From which the seconds of a CSV file count, UTC where it has no zone; text in ISO 8601.
    progress : callable, optional
        Called with (done, total) depths.

    Raises
    ------
    InputError
        When the record cannot be read, has no latitude, or is too short, or an argument cannot be read.
    """
    began = time.perf_counter()
    path = as_path(record, "record")
    since = _moment(start)
    measured = read_current_record(path, since)
    north = _latitude(latitude, measured, path)
    series = [_samples(measured, column, north) for column in range(measured.depth.size)]
    enough = [samples.time.size >= LEAST_SAMPLES and samples.lasting >= SHORTEST for samples in series]
    if not any(enough):
        message = f"is too short for a tide: it needs {LEAST_SAMPLES} samples over {SHORTEST / 3600.0:.0f} h"
        raise InputError([Problem(message, str(path))])
    depths: list[DepthTide] = []
    for index in np.flatnonzero(enough):
        depths.append(_tide(float(measured.depth[index]), series[index]))
        if progress:
            progress(len(depths), int(np.sum(enough)))
    few = [f"{depth:g} m" for depth, good in zip(measured.depth, enough, strict=True) if not good]
    notices = [f"too few samples for a tide at {', '.join(few)}"] if few else []
    if datetime.fromtimestamp(float(measured.time[0]), UTC).year < 1980:
        notices.append("the record begins before 1980: is its start right?")
    most = int(np.argmax([depth.samples for depth in depths]))
    shown, column = depths[most], int(np.flatnonzero(enough)[most])
    lasting = float(measured.time[-1] - measured.time[0])
    return TideResult(
        provenance=Provenance(
            command="tide",
            mission=path.name,
            file=str(path),
            options={"latitude_deg": round(math.degrees(north), 6), "start": since.isoformat() if since else None},
            elapsed_s=time.perf_counter() - began,
            notices=tuple(notices),
            inputs={"record": digest_of_files([path])},
        ),
        depths=tuple(depths),
        latitude=north,
        begins=float(measured.time[0]),
        days=lasting / DAY,
        time=measured.time[:_SHOWN],
        measured=np.stack((measured.east[:_SHOWN, column], measured.north[:_SHOWN, column])),
        fitted=np.array([[shown.east], [shown.north]])
        + tidal_velocity(shown.constituents, measured.time[:_SHOWN], north),
        shown_depth=shown.depth,
        unresolved=_unresolved(lasting),
    )


def _moment(start: datetime | str | None) -> datetime | None:
    try:
        return None if start is None else moment_of(start)
    except (ValueError, OverflowError):
        message = f"given {shown(start)}, expected a time such as 2026-05-01T06:00:00Z"
        raise InputError([Problem(message, key="start")]) from None


def _latitude(option: float | str | None, record: CurrentRecord, path: Path) -> float:
    try:
        latitude = parse_number_with_unit(option, "rad") if isinstance(option, str) else option
    except QuantityError as error:
        hint = "a latitude such as '37.2 deg'; south is negative"
        raise InputError([Problem(problem.message, key="latitude", hint=hint) for problem in error.problems]) from None
    latitude = record.latitude if latitude is None else latitude
    if math.isnan(latitude):
        message = "nothing says at which latitude it was measured; nodal corrections need it"
        raise InputError([Problem(message, str(path), hint="give --latitude, such as --latitude '37.2 deg'")])
    if abs(latitude) > 0.5 * math.pi:
        message = f"given {math.degrees(latitude):g}°, expected a latitude between −90° and 90°"
        raise InputError([Problem(message, key="latitude")])
    return latitude


def _samples(record: CurrentRecord, column: int, latitude: float) -> Samples:
    velocity = np.stack((record.east[:, column], record.north[:, column]))
    there = np.isfinite(velocity).all(axis=0)
    return Samples(record.time[there], velocity[:, there], latitude)


def _tide(depth: float, samples: Samples) -> DepthTide:
    fit = fit_tide(samples)
    tide = tidal_velocity(fit.constituents, samples.time, samples.latitude)
    whole = np.sum(np.var(samples.velocity, axis=1))
    left = np.sum(np.var(samples.velocity - tide, axis=1))
    return DepthTide(
        depth=depth,
        samples=samples.time.size,
        east=float(fit.mean[0]),
        north=float(fit.mean[1]),
        mean_error=fit.mean_error,
        constituents=fit.constituents,
        residual=fit.spread,
        residual_time=fit.residual.time,
        tidal_share=float(max(1.0 - left / whole, 0.0)) if whole > 0.0 else 0.0,
        held_out=_held_out(samples),
    )


def _held_out(samples: Samples) -> HeldOut | None:
    """Forecast the end of the record from the rest of it."""
    end = samples.time[0] + (1.0 - HELD_OUT) * samples.lasting
    early = samples.time < end
    rest = Samples(samples.time[early], samples.velocity[:, early], samples.latitude)
    if rest.time.size < LEAST_SAMPLES or rest.lasting < LEAST_FITTED or np.all(early):
        return None
    fit = fit_tide(rest)
    late = samples.time[~early]
    error = samples.velocity[:, ~early] - fit.mean[:, None] - tidal_velocity(fit.constituents, late, samples.latitude)
    inside = float(np.mean(np.abs(error) <= _NINETY * fit.spread))
    return HeldOut(late.size, inside, float(np.sqrt(np.mean(error**2))))


def _unresolved(lasting: float) -> tuple[str, ...]:
    words = []
    if lasting < FORTNIGHT:
        words.append(
            "shorter than the 14.8 days that tell M2 from S2: what is called M2 holds S2 and N2 too, and a forecast "
            "beyond the record drifts from spring to neap"
        )
    if lasting < HALF_A_YEAR:
        words.append(
            "shorter than the half year that tells K2 from S2 and P1 from K1"
            + ("" if lasting < FORTNIGHT else ": these are inferred by their ratios in the equilibrium tide")
        )
    return tuple(words)
