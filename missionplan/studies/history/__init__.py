"""`history`: read reports of `diagnose` and counts of failures below a folder, and follow what was learned."""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np
from scipy.special import chdtrc

from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, Problem, attempted
from missionplan.identity import differences, digest_of, program_part
from missionplan.mission import MissionOrPath, as_mission
from missionplan.mission.documents import load_document, read_json
from missionplan.mission.includes import hash_of, read_draws
from missionplan.mission.learned import Series, series_of
from missionplan.moments import moment_or_none
from missionplan.montecarlo.levels import Seen
from missionplan.montecarlo.posterior import FILE, DamagedPosteriorError
from missionplan.results import Provenance
from missionplan.results.entries import mapping, mappings, real
from missionplan.results.learned.levels import Level, ParameterLevels
from missionplan.store.folder import as_path
from missionplan.studies.history.result import History, Learned, State, rates_file, read_counts, updated_rates


def parameter_levels(seen: Sequence[Seen], reports: Mapping[str, str] | None = None) -> tuple[ParameterLevels, ...]:
    """Return how each parameter that has a level went from mission to mission.

    `seen`: what records have told. `reports`: names of the records by their hashes.
    """
    by_key = series_of(seen)
    return tuple(_told(series, reports or {}) for key, series in by_key.items() if key[2] == "strength")


def _told(series: Series, reports: Mapping[str, str]) -> ParameterLevels:
    levels, then = series.levels()
    measured, (effect, name, _) = levels.measured, series.of
    mean, sd = levels.at(np.append(measured.times, then))
    numbers = zip(mean[:-1].tolist(), sd[:-1].tolist(), levels.jumps.tolist(), strict=True)
    missions = tuple(
        Level(reports.get(seen.record, seen.record), seen.date if math.isfinite(seen.date) else None, *level)
        for seen, level in zip(series.records[-len(measured.times) :], numbers, strict=True)
    )
    # measurements of one mission differ by chance as they do: χ² about their weighted means
    _, mission = np.unique(measured.times, return_inverse=True)
    weight = np.asarray(measured.sds) ** -2.0
    middle = np.bincount(mission, weight * measured.values) / np.bincount(mission, weight)
    free = len(mission) - len(middle)
    chance = float(chdtrc(free, np.sum(weight * (measured.values - middle[mission]) ** 2))) if free else 1.0
    unit = CATALOGUE[effect].parameters[name].unit
    now = float(mean[-1]), float(sd[-1])
    return ParameterLevels(effect, name, unit, missions, *levels.trend, *now, agreement=chance)


MAX_BYTES = 20_000_000
"""Of a summary."""
NUMBERS = ("value", "sd", "low", "high")


@dataclass(frozen=True)
class _Report:
    """A report of `diagnose`: its place, its summary, and the start and the units of its mission."""

    place: str
    summary: Mapping[str, object]
    start: str
    units: object
    seen: tuple[Seen, ...] = ()
    """What its mission has seen of levels."""

    @property
    def learned_from(self) -> frozenset[str] | None:
        """Hashes of the legs, dives and runs that were new to its mission; None where the report does not say."""
        hashes = self.summary.get("learned_from")
        return frozenset(map(str, hashes)) if isinstance(hashes, list) else None

    @property
    def data(self) -> str:
        """Date of what it learned from, where that told of a level; else empty."""
        identity = hash_of(self.summary.get("learned_from"))
        dates = [dataset.date for dataset in self.seen if dataset.record == identity and math.isfinite(dataset.date)]
        return datetime.fromtimestamp(dates[0], UTC).isoformat(timespec="seconds") if dates else ""

    @property
    def created(self) -> str:
        return str(self.summary.get("created_utc", ""))


def history(folder: str | Path, *, mission: MissionOrPath | None = None) -> History:
    """Follow learned parameters from mission to mission, and update failure rates by a fleet's counts.

    Reports are in the order of their data where all tell their date, else of their missions' `start` where all have
    one, else of the time at which they were made.

    Parameters
    ----------
    folder : str or Path
        Holds report folders of `diagnose`, and `reliability.csv` (`per`, `failures`, `exposure`), at any depth.
    mission : Mission, str or Path, optional
        Whose `vehicle.reliability` is the prior of the failure rates.

    Raises
    ------
    InputError
        When there is no such folder, or neither report nor counts in it, or one cannot be read.
    """
    began, root = time.perf_counter(), as_path(folder, "folder")
    if not root.is_dir():
        raise InputError([Problem("no such folder", str(root))])
    rows, copies = read_counts(root)
    planned = None if mission is None else as_mission(mission)
    rates = updated_rates(rows, planned)
    if rows and not rates:
        copies = (*copies, "the mission's failure rates have all counts in them already")
    reports, foreign = _reports(root, needed=not rows)
    reports, notices = _counted_once(reports)
    ordered_by = next((by for by in ("data", "start") if all(getattr(report, by) for report in reports)), "created")
    reports.sort(key=lambda report: (*(_moment(getattr(report, by)) for by in (ordered_by, "created")), report.place))
    entries, levels = _followed(reports, ordered_by)
    places = tuple(report.place for report in reports)
    provenance = Provenance(
        command="history",
        mission=", ".join(dict.fromkeys(str(report.summary.get("mission", "")) for report in reports)),
        file="",
        options={"folder": str(root), **({} if planned is None else {"mission": planned.file})},
        elapsed_s=time.perf_counter() - began,
        data={"folder": str(root), "reports": list(places), **_units(reports)},
        notices=(*foreign, *copies, *notices, *_other_programs(reports)),
        inputs={
            "reports": {report.place: digest_of(report.summary) for report in reports},
            **({"counts": digest_of([row.digest for row in rows])} if rows else {}),
        },
    )
    written = rates_file(rates, planned) if rates else ""
    return History(provenance, places, entries, ordered_by, levels, rates, written)


def _units(reports: Sequence[_Report]) -> dict[str, object]:
    """Return the units in which all missions are written; nothing where they differ."""
    units = {report.units for report in reports if isinstance(report.units, str)}
    return {"units": units.pop()} if len(units) == 1 and all(report.units for report in reports) else {}


def _followed(reports: Sequence[_Report], ordered_by: str) -> tuple[tuple[Learned, ...], tuple[ParameterLevels, ...]]:
    """Return what ordered reports say of each parameter, and how each that has a level went over all of them."""
    entries = [entry for report in reports for entry in _learned(report, getattr(report, ordered_by))]
    # levels by all that the draws of reports have seen, each record once
    names = {hash_of(report.summary.get("learned_from")): report.place for report in reports}
    levels = parameter_levels([measurement for report in reports for measurement in report.seen], names)
    # what is told by a record before which its level jumped is changed
    jumped = {(parameter.effect, parameter.name, level.record) for parameter in levels for level in parameter.jumps}
    learned = (replace(entry, state="changed") if (*entry.key, entry.report) in jumped else entry for entry in entries)
    return tuple(learned), levels


def _other_programs(reports: Sequence[_Report]) -> Iterator[str]:
    """Name the reports that other code has made than the last, of which a jump may come."""
    stated = [(report, mapping(report.summary.get("identity_parts"))) for report in reports]
    programs = [(report, program_part(parts)) for report, parts in stated if parts]
    for report, program in programs[:-1]:
        if unlike := differences(program, programs[-1][1]):
            yield f"the report {report.place} was made by other code than {programs[-1][0].place}: {'; '.join(unlike)}"


def _reports(root: Path, *, needed: bool) -> tuple[list[_Report], tuple[str, ...]]:
    """Read every report of `diagnose` below a folder; notices name what is none.

    Raises InputError when there is none that can be read.
    """
    places = sorted(path.parent for path in root.rglob("diagnosis.json") if (path.parent / "summary.json").is_file())
    if not places and needed:
        words = "holds no report of diagnose (summary.json beside diagnosis.json) and no reliability.csv"
        raise InputError([Problem(words, str(root))])
    problems: list[Problem] = []
    attempts = [attempted(partial(_read, place, root), problems) for place in places]
    reports = [report for report in attempts if report is not None]
    if problems and not reports:
        raise InputError(problems)
    return reports, tuple(f"left out: {problem}" for problem in problems)


def _counted_once(reports: Sequence[_Report]) -> tuple[list[_Report], tuple[str, ...]]:
    """Leave out reports that learned nothing new, or the same as one made later; name them and those that overlap."""
    kept: list[_Report] = []
    notices = []
    for report in sorted(reports, key=lambda report: (_moment(report.created), report.place), reverse=True):
        hashes = report.learned_from
        same = next((other for other in kept if hashes is not None and other.learned_from == hashes), None)
        if hashes == frozenset() or same is not None:
            why = "nothing new" if same is None else f"the same data as {same.place}, which was made later"
            notices.append(f"{report.place} learned from {why}, and is left out")
            continue
        shared = [(other, len(hashes & (other.learned_from or set()))) for other in kept] if hashes else []
        notices += [
            f"{report.place} and {other.place} learned from {count} legs, dives or runs in common, which count twice"
            for other, count in shared
            if count
        ]
        kept.append(report)
    return kept, tuple(notices)


def _read(place: Path, root: Path) -> _Report | None:
    """Read a report; None for one of several data sets, whose diagnoses lie in folders of their own.

    Raises InputError when its summary is no JSON of a diagnosis, its mission cannot be read, or its draws are damaged.
    """
    file = place / "summary.json"
    summary = read_json(file, max_bytes=MAX_BYTES)
    if isinstance(summary, dict) and "datasets" in summary:
        return None
    if not isinstance(summary, dict) or not isinstance(summary.get("ranking"), list) or not _can_be_told(summary):
        raise InputError([Problem("is not the summary of a diagnosis", str(file))])
    mission = load_document(place / "mission.yaml").data if (place / "mission.yaml").is_file() else {}
    start, units = str(mapping(mission).get("start") or ""), mapping(mission).get("units")
    try:
        seen = read_draws(place / FILE).seen if (place / FILE).is_file() else ()
    except DamagedPosteriorError as error:
        raise InputError([Problem(str(error), str(place / FILE))]) from error
    return _Report(place.relative_to(root).as_posix(), summary, start, units, seen)


def _can_be_told(summary: Mapping[str, object]) -> bool:
    """Whether every parameter of a summary has names and finite numbers."""
    listed = [
        parameter for entry in mappings(summary["ranking"])[:1] for parameter in mappings(entry.get("parameters"))
    ]
    pairs = [(parameter, parameter) for parameter in listed]
    pairs += [(parameter, mapping(parameter.get("posterior"))) for parameter in mappings(summary.get("confirmed"))]
    return all(
        all(isinstance(named.get(key), str) for key in ("effect", "name"))
        and all(math.isfinite(real(value.get(key))) for key in NUMBERS)
        for named, value in pairs
    )


def _moment(text: str) -> datetime:
    """Time of a report; without a zone it is UTC."""
    return moment_or_none(text) or datetime.min.replace(tzinfo=UTC)


def _learned(report: _Report, moment: str) -> Iterator[Learned]:
    """Yield what a diagnosis says of each parameter: of its causes, and of what the mission knew."""
    summary = report.summary
    best = mappings(summary.get("ranking"))[:1] if summary.get("causes") else []
    # less than 1 where the diagnosis left a doubt
    doubt = [odds for odds in mappings(summary.get("explanations")) if odds.get("causes") == summary.get("causes")]
    likely = real(doubt[0].get("probability")) if doubt else 1.0
    for parameter in [parameter for entry in best for parameter in mappings(entry.get("parameters"))]:
        effects = summary.get("changed_effects")  # older reports do not name them
        changed = bool(summary.get("changed")) and (not isinstance(effects, list) or parameter["effect"] in effects)
        yield _entry(report, moment, parameter, parameter, "changed" if changed else "found", likely)
    for confirmed in mappings(summary.get("confirmed")):
        for value in mappings([confirmed.get("posterior")]):
            yield _entry(report, moment, confirmed, value, "confirmed", real(confirmed.get("probability", 1.0)))


def _entry(
    report: _Report,
    moment: str,
    named: Mapping[str, object],
    value: Mapping[str, object],
    state: State,
    probability: float,
) -> Learned:
    numbers = {key: real(value.get(key)) for key in NUMBERS}
    return Learned(
        report=report.place,
        mission=str(report.summary.get("mission", "")),
        dataset=str(report.summary.get("dataset", "")),
        time=moment,
        effect=str(named["effect"]),
        name=str(named["name"]),
        unit=str(value.get("unit", "")),
        state=state,
        probability=probability,
        **numbers,
    )
