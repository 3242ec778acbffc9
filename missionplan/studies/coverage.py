"""What the probability of a mission's success holds of the world, and where its models were checked."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from missionplan.mission import Mission
from missionplan.mission.schema.site import Site
from missionplan.montecarlo.distributions import mean_of
from missionplan.results.decision import RANGES, CheckedRange, Coverage
from missionplan.results.entries import mappings
from missionplan.scenario.place import mission_places

_GLIDERS = 0.5, 90.0
"""Share of deep gliders that end a mission of so many days as planned (Brito, Smeed & Griffiths 2014, 205 deployments):
the yardstick for equipment whose hazards a mission does not give."""
_DAY, _HOUR = 86400.0, 3600.0
_BRIEF = 60.0
"""Nominal time below which a mission gives none of what takes its time: a dive without a hold [s]."""
_GROWS = 7.0 * _DAY
"""Time after which growth on a hull is worth a thought [s]."""


def probability_holds(mission: Mission) -> tuple[Coverage, ...]:
    """Return the box: ground, coast, wind, waves, traffic, equipment, biofouling, operators; none without a phase."""
    if not mission.phases:
        return ()
    return tuple(Coverage(what, is_held, why) for what, is_held, why in _rows(mission))


def coverage_of(alternatives: Mapping[str, Mission | Mapping[str, object]]) -> tuple[Coverage, ...]:
    """Return the boxes of missions and of reports' summaries as one, what they do not share under their names."""
    boxes = {
        name: probability_holds(case)
        if isinstance(case, Mission)
        else tuple(
            Coverage(str(row.get("what")), row.get("held") is True, str(row.get("why")))
            for row in mappings(case.get("probability_holds"))
        )
        for name, case in alternatives.items()
    }
    coverages: list[Coverage] = []
    for what in dict.fromkeys(row.what for box in boxes.values() for row in box):
        rows = {name: row for name, box in boxes.items() for row in box if row.what == what}
        if len(rows) == len(boxes) and len(set(rows.values())) == 1:
            coverages.append(next(iter(rows.values())))
        else:
            coverages += [replace(row, what=f"{what} ({name})") for name, row in rows.items()]
    return tuple(coverages)


def checked_ranges(mission: Mission) -> tuple[CheckedRange, ...]:
    """Return the quantities of a mission, at the means, beside the ranges in which the models were checked."""
    finite = {key: [*filter(math.isfinite, values)] for key, values in _quantities(mission).items()}
    return tuple(
        CheckedRange(**vars(RANGES[key]), least=min(numbers), greatest=max(numbers))
        for key, numbers in finite.items()
        if numbers
    )


def _quantities(mission: Mission) -> dict[str, list[float]]:
    """Values by the keys of `RANGES` [SI]; a field of an ocean model has no layers to be told of here."""
    values: dict[str, list[float]] = {}
    if mission.transits and mission.navigation is not None:
        error = math.sqrt(0.5 * float(np.trace(mission.navigation.velocity_error.covariance)))
        places = mission_places(mission)
        values["speed_error"] = [error / mean_of(phase.speed) for phase in mission.transits]
        values["leg"] = [
            mean_of(phase.d_max) / mean_of(phase.arrival_radius)
            for phase in mission.transits
            if not hasattr(phase.d_max, "table")
        ]
        values["transit"] = [float(length) for length in np.hypot(*np.diff(places, axis=1)) if length > 0.0]
    if mission.moors:
        site = mission.site or Site()
        layers = site.current if isinstance(site.current, tuple) else ()
        speeds = [abs(mean_of(layer.speed)) for layer in layers]
        values["depth"] = [mean_of(site.depth)] if site.depth is not None else []
        values["line"] = [mean_of(phase.line_length) for phase in mission.moors]
        values["line_diameter"] = [mean_of(phase.line_diameter) for phase in mission.moors]
        values["dive_current"], values["hold_current"] = speeds, speeds[-1:]
    return values


def _rows(mission: Mission) -> Iterator[tuple[str, bool, str]]:
    site = mission.site or Site()
    afloat = 0.0 if mission.navigation is None else mean_of(mission.navigation.surfacing_time)
    length, time = _way(mission)
    legs = [mean_of(phase.d_max) for phase in mission.transits if not hasattr(phase.d_max, "table")]
    surfacings = math.ceil(length / max(legs)) if legs else 0
    time += surfacings * afloat
    yield ("ground", *_ground(mission, site))
    yield ("coast", *_coast(site, length))
    yield ("wind", *_wind(site, afloat))
    yield "waves", False, _waves(mission, afloat)
    yield ("traffic", *_traffic(site, length, surfacings, afloat))
    yield ("equipment", *_equipment(mission, time))
    yield "biofouling", False, f"drag and weight stay those of a clean hull; {_growth(time)}"
    yield "operators", False, "ballast, settings and launch are as in the file: a check-list holds slips, this does not"


def _ground(mission: Mission, site: Site) -> tuple[bool, str]:
    deepest = max((mean_of(phase.depth) for phase in mission.transits), default=0.0)
    if site.bathymetry is not None:
        datum = site.depth_datum or "an unstated datum"
        tide = "with the tide" if site.tide_height is not None else "without a tide"
        kept = f"{_m(mean_of(site.clearance))} kept under the hull"
        return True, f"depths below {datum}, {tide}, {kept}; rocks between cells are not in"
    if site.depth is None:
        runs = f"it runs {_m(deepest)} deep over" if mission.transits else "below is"
        return False, f"no depth is known: {runs} whatever there is (site.bathymetry)"
    depth = _m(mean_of(site.depth))
    if not mission.transits:
        return False, f"{depth} wherever the anchor comes down: steps and holes are not in (site.bathymetry)"
    return False, f"{depth} everywhere, running {_m(deepest)} deep: a shoal on the way is not in (site.bathymetry)"


def _coast(site: Site, length: float) -> tuple[bool, str]:
    if site.land is not None:
        return True, "polygons of land; what they leave out, such as piers and rocks, is not in"
    if site.bathymetry is not None:
        return True, "where the grid of depths rises above the water; what its cells smooth away is not in"
    if length == 0.0:
        return False, "no way is sailed; land where it drifts afloat is not in (site.land)"
    return False, "straight ways cross whatever lies between (site.land)"


def _wind(site: Site, afloat: float) -> tuple[bool, str]:
    if site.wind is not None:
        return True, "the vehicle's leeway while it is afloat"
    if afloat == 0.0:
        return False, "no time afloat is given (navigation.surfacing_time), in which wind would carry it (site.wind)"
    carried = f"10 m/s of wind at a leeway of 3 % carry it {_m(0.3 * afloat)}"
    return False, f"afloat {afloat:.0f} s at each fix: {carried} (site.wind)"


def _waves(mission: Mission, afloat: float) -> str:
    if not mission.transits:
        return "they lift and push a vehicle near the surface, and a line in shallow water snatches"
    depth = min(mean_of(phase.depth) for phase in mission.transits)
    return f"runs {_m(depth)} below the surface and is {afloat:.0f} s afloat at each fix, which waves push and lengthen"


def _traffic(site: Site, length: float, surfacings: int, afloat: float) -> tuple[bool, str]:
    if site.keep_out is not None:
        return True, "zones kept out of; ships, nets and lines in the water between them are not in"
    if length == 0.0 or afloat == 0.0:
        return False, "ships where it goes down and comes up, and nets and lines at depth, are not in"
    times = "again and again"
    if surfacings:
        times = "once or more" if surfacings == 1 else f"{surfacings} times or more"
    return False, f"at the surface {times} for {afloat:.0f} s; nets and lines at depth are not in either"


def _equipment(mission: Mission, time: float) -> tuple[bool, str]:
    hazards = mission.vehicle.reliability if mission.vehicle is not None else ()
    if hazards:
        named = ", ".join(dict.fromkeys(hazard.per for hazard in hazards))
        return True, f"hazards per {named}; what they leave out is not in"
    survival, days = _GLIDERS
    lost = 1.0 - survival ** (time / _DAY / days)
    if time < _BRIEF:
        failed = f"{100.0 * (1.0 - survival):.0f} % of deep gliders do in {days:.0f} days (Brito et al. 2014)"
        return False, f"nothing breaks; {failed} (vehicle.reliability)"
    share = f"{100.0 * lost:.2g} %" if lost >= 5e-4 else "less than 0.1 %"
    rate = f"at the rate of deep gliders (Brito et al. 2014) {share} fail in {_duration(time)}, in still water"
    return False, f"nothing breaks; {rate} (vehicle.reliability)"


def _growth(time: float) -> str:
    if time < _BRIEF:
        return "it grows in weeks"
    return f"in {_duration(time)} " + (
        "growth slows the vehicle and weighs on it" if time >= _GROWS else "it grows a little"
    )


def _way(mission: Mission) -> tuple[float, float]:
    """Length of the straight ways [m], and time of the mission [s], both nominal."""
    places = mission_places(mission) if mission.transits else np.zeros((2, 1))
    length = float(np.hypot(*np.diff(places, axis=1)).sum())
    speeds = [mean_of(phase.speed) for phase in mission.transits]
    speed = float(np.nanmean(speeds)) if speeds and not np.isnan(speeds).all() else np.inf
    stays = [(phase.release_time, *phase.times_moored) for phase in mission.moors]
    return length, length / speed + sum(mean_of(time) for stay in stays for time in stay)


def _m(length: float) -> str:
    return f"{length:.3g} m"


def _duration(time: float) -> str:
    if time >= 2.0 * _DAY:
        return f"{time / _DAY:.3g} days"
    return f"{time / _HOUR:.2g} h" if time >= _HOUR else f"{time / 60.0:.0f} min"
