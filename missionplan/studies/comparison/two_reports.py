"""What changed between two reports of one command, and the chance that Monte-Carlo noise alone makes numbers differ."""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, NamedTuple, TypeGuard, get_args

import numpy as np
from scipy.special import ndtr

from missionplan.errors import InputError, Problem
from missionplan.identity import differences, digest_of, program_part
from missionplan.mission.documents import load_document, read_json
from missionplan.results import Provenance, without_run
from missionplan.results.entries import mapping, mappings, real, whole
from missionplan.store.folder import as_path
from missionplan.studies.comparison.differing_values import differing_values
from missionplan.studies.comparison.reported_choices import CHOOSING
from missionplan.studies.comparison.result import (
    Bound,
    ChangedValue,
    ComparedNumber,
    ComparedRun,
    Comparison,
    KeyPath,
    ListItem,
)
from missionplan.studies.coverage import coverage_of


def changed_values(first: object, second: object) -> tuple[ChangedValue, ...]:
    """List the values that differ, by key path with phases by name; ``75 ft`` and ``22.86 m`` are the same."""
    keys = differing_values((first, second))
    return tuple(ChangedValue(key.path, key.values[0], key.values[1], key.mission_key) for key in keys)


SECTIONS = {
    "simulate": ("phases", "total", "requirements"),
    "sweep-dmax": ("sweep",),
    "size-anchor": ("anchor", "descent", "odds", "probable"),
}
"""Sections that are compared, by the command that made the reports."""
_NAMES, _NUMBERS, _BOUNDS = ("name", "quantity"), ("sigma_m_s", "d_max_m"), get_args(Bound)
"""Keys that identify the items of a list."""
_NOT_RESULTS = ("required", *_BOUNDS, "met", "undecided", "trials_to_decide")
_NOISY = {"simulate": ("requirements",), "sweep-dmax": ("sweep",), "size-anchor": ("probable",)}
"""Sections whose plain numbers are quantiles, or result from a search over noisy values."""
_KINDS = ("quantities", "events")
"""Keys of a phase's numbers, whatever a phase is called."""
_MAX_DEPTH = 20


class SummaryNumber(NamedTuple):
    """A number of a summary."""

    kind: Literal["mean", "probability", "number"]
    value: float
    error: float
    """Standard error; nan where it is not known, or follows from the number of trials (a probability's)."""


def summary_numbers(summary: Mapping[str, object], command: str) -> dict[KeyPath, SummaryNumber]:
    """Numbers of a summary by their places in it, such as ``("phases", "moor", "quantities", "offset_m")``."""
    numbers = {}
    for section in SECTIONS[command]:
        error = math.nan if section in _NOISY.get(command, ()) else 0.0
        value = summary.get(section)
        for path, number in _walk(value, (section,), error) if isinstance(value, Mapping | list) else ():
            numbers[path] = number
    return numbers


def _walk(value: object, path: KeyPath, error: float) -> Iterator[tuple[KeyPath, SummaryNumber]]:
    """Read a number, a list of named items, or a mapping."""
    if len(path) > _MAX_DEPTH:
        return
    if isinstance(value, list):
        for item in value:
            if isinstance(item, Mapping):
                inside = {key: inner for key, inner in item.items() if key not in (*_NAMES, *_NUMBERS)}
                name = next((str(item[key]) for key in _NAMES if key in item), "")
                number = next((item[key] for key in (*_NUMBERS, *_BOUNDS) if _is_number(item.get(key))), None)
                bound = next((key for key in _BOUNDS if key in item), None)
                yield from _walk(
                    inside, (*path, ListItem(name, None if number is None else float(f"{number:.6g}"), bound)), error
                )
    elif isinstance(value, Mapping):
        yield from _walk_mapping(value, path, error)
    elif _is_number(value):
        yield path, SummaryNumber("number", float(value), error)


def _walk_mapping(value: Mapping[str, object], path: KeyPath, error: float) -> Iterator[tuple[KeyPath, SummaryNumber]]:
    """Read a statistic, a point of a sweep, a probability, or what is under the keys of any other mapping."""
    is_cost = "mean" not in value
    estimate = value.get("cost" if is_cost else "mean")
    if _is_number(estimate) and "standard_error" in value:  # null of a single trial
        yield (
            (*path, "cost") if is_cost else path,
            SummaryNumber("mean", float(estimate), real(value["standard_error"])),
        )
        if is_cost and _is_number(d_max := value.get("d_max_m")):
            yield (*path, "d_max_m"), SummaryNumber("number", float(d_max), error)
    elif set(value) == {"value", "low", "high"}:
        if _is_number(probability := value["value"]):
            yield path, SummaryNumber("probability", float(probability), math.nan)
    else:
        for key, inner in value.items():
            if key not in _NOT_RESULTS:
                yield from _walk(inner, (*path, str(key)), error)


def _is_number(value: object) -> TypeGuard[float]:
    return not isinstance(value, bool) and math.isfinite(real(value))


def _group_and_key(path: KeyPath) -> tuple[str, str]:
    """The parts of the path that a reader needs."""
    section, *inside, key = map(str, path)
    if section == "requirements":
        return "requirement", str(path[1])
    name, rest = (inside[:1], inside[1:]) if section == "phases" else ([section], inside)
    return ", ".join((*name, *(part for part in rest if part not in _KINDS))) or key, key


def standard_error_and_p_value(
    first: SummaryNumber, second: SummaryNumber, trials: tuple[int, int]
) -> tuple[float | None, float | None]:
    """Standard error of the difference of two independent estimates, and its two-sided p-value from a z test.

    None where the standard errors are not known. Without noise, the p-value is 1 where the numbers are equal, else 0.
    """
    error = pooled = math.hypot(first.error, second.error)
    if first.kind == "probability":
        # of two proportions, and pooled under the test that they are equal (Fleiss, Levin & Paik 2003, Statistical
        # Methods for Rates and Proportions, ch. 3)
        (n, m), (one, two) = trials, (first.value, second.value)
        if n < 1 or m < 1:
            return None, None
        share = (n * one + m * two) / (n + m)
        error = math.sqrt(one * (1.0 - one) / n + two * (1.0 - two) / m)
        pooled = math.sqrt(max(share * (1.0 - share), 0.0) * (1.0 / n + 1.0 / m))
    if not math.isfinite(error):
        return None, None
    if pooled == 0.0:
        return 0.0, 1.0 if math.isclose(first.value, second.value, rel_tol=1e-9, abs_tol=1e-12) else 0.0
    return error, float(2.0 * ndtr(-abs(second.value - first.value) / pooled))


def holm(p_values: Sequence[float]) -> list[float]:
    """Adjust p-values so that the chance of any false finding stays at the level.

    Step-down procedure of Holm 1979, A simple sequentially rejective multiple test procedure, Scand. J. Statist. 6,
    65–70.
    """
    order = np.argsort(p_values)
    factors = np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[order] = np.minimum(np.maximum.accumulate(factors * np.asarray(p_values, dtype=float)[order]), 1.0)
    return [float(value) for value in adjusted]


LEVEL = 0.05
"""Probability of finding any difference where there is none."""
_MAX_BYTES = 50_000_000
_SHARED = "Both runs have the same seed and so share draws: a difference that is called noise here may be real"


def compare_reports(first: str | Path, second: str | Path) -> Comparison:
    """Compare two report folders, whose runs are taken as independent.

    `first`, `second`: report folders with `summary.json` and `mission.yaml`, made by the same command. Raises
    InputError when a folder is no report, or the two were not made by one command that can be compared.
    """
    began = time.perf_counter()
    folders = (as_path(first, "first"), as_path(second, "second"))
    summaries = [read_summary(folder) for folder in folders]
    missions = [load_document(folder / "mission.yaml").data for folder in folders]
    command = _one_command(folders, summaries)
    runs = _run(folders[0], summaries[0]), _run(folders[1], summaries[1])
    one, two = (summary_numbers(summary, command) for summary in summaries)
    options = [
        {key: summary.get(key) for key in ("seed", "trials", "version")}
        | {f"option {key}": value for key, value in mapping(summary.get("options")).items()}
        for summary in summaries
    ]
    return Comparison(
        provenance=Provenance(
            command="compare",
            mission=" and ".join(dict.fromkeys(run.mission for run in runs)),
            file=" ".join(run.folder for run in runs),
            seed=runs[1].seed,
            trials=runs[1].trials,
            elapsed_s=time.perf_counter() - began,
            data={"first": missions[0], "second": missions[1]},
            notices=(*([_SHARED] if runs[0].seed == runs[1].seed else []), *_other_program(*summaries)),
            inputs={"reports": [digest_of(summary) for summary in summaries]},
            holds=coverage_of({run.folder: summary for run, summary in zip(runs, summaries, strict=True)}),
        ),
        compared=command,
        runs=runs,
        mission_changes=changed_values(*missions),
        option_changes=changed_values(*options),
        differences=_with_verdicts(list(_differences(one, two, (runs[0].trials, runs[1].trials)))),
        requirement_changes=changed_values(*map(_requirements_met, summaries)),
    )


def read_summary(folder: Path) -> dict[str, object]:
    """Read the summary of a report folder; raises InputError where it is none."""
    if not folder.is_dir():
        raise InputError([Problem("no such folder", str(folder), hint="a report folder was expected")])
    path = folder / "summary.json"
    summary = read_json(path, max_bytes=_MAX_BYTES)
    if not isinstance(summary, dict) or not isinstance(summary.get("command"), str):
        raise InputError([Problem("is not a summary of missionplan", str(path))])
    return summary


def _one_command(folders: Sequence[Path], summaries: Sequence[Mapping[str, object]]) -> str:
    commands = [summary["command"] for summary in summaries]
    if commands[0] != commands[1]:
        made = " and ".join(f"{folder} by {command}" for folder, command in zip(folders, commands, strict=True))
        raise InputError([Problem(f"two reports of one command were expected, but they were made {made}")])
    if commands[0] not in SECTIONS:
        names = ", ".join((*SECTIONS, *CHOOSING))
        raise InputError([Problem(f"reports of {commands[0]} cannot be compared; those of {names} can")])
    return str(commands[0])


def _run(folder: Path, summary: Mapping[str, object]) -> ComparedRun:
    text = {key: str(summary.get(key, "")) for key in ("mission", "version", "created_utc")}
    seed, trials = (whole(summary.get(key)) for key in ("seed", "trials"))
    return ComparedRun(str(folder), text["mission"], text["version"], text["created_utc"], seed, trials)


def _other_program(first: Mapping[str, object], second: Mapping[str, object]) -> Iterator[str]:
    """Say in what the programs of two reports differ, or that one program gave both numbers."""
    one, two = (mapping(summary.get("identity_parts")) for summary in (first, second))
    if not (one and two):
        return
    if unlike := differences(*(program_part(parts) for parts in (one, two))):
        yield f"The runs were made by other code, of which a difference may come: {'; '.join(unlike)}"
    before, now = (digest_of(without_run(summary)) for summary in (first, second))
    if one == two and before != now:
        yield "Both runs state one identity, yet their numbers differ: missionplan verify tells which come out here"


def _differences(
    first: Mapping[KeyPath, SummaryNumber], second: Mapping[KeyPath, SummaryNumber], trials: tuple[int, int]
) -> Iterator[ComparedNumber]:
    for place in dict.fromkeys((*first, *second)):
        one, two, named = first.get(place), second.get(place), _group_and_key(place)
        if one is not None and two is not None:
            error, p_value = standard_error_and_p_value(one, two, trials)
            yield ComparedNumber(*named, one.kind, one.value, two.value, error, p_value, "not judged", place)
        elif datum := one or two:
            values = one and one.value, two and two.value
            yield ComparedNumber(*named, datum.kind, *values, None, None, "only first" if one else "only second", place)


def _with_verdicts(differences: Sequence[ComparedNumber]) -> tuple[ComparedNumber, ...]:
    """Add the verdicts: exact where there is no noise, by Holm's correction over all numbers that have some."""
    noisy = [difference for difference in differences if difference.standard_error and difference.p_value is not None]
    adjusted = dict(zip(map(id, noisy), holm([difference.p_value or 0.0 for difference in noisy]), strict=True))
    judged = []
    for difference in differences:
        verdict = difference.verdict
        if difference.change == 0.0:
            verdict = "same"
        elif difference.p_value is not None:
            changed = adjusted.get(id(difference), difference.p_value) < LEVEL
            verdict = "changed" if changed else "within noise" if id(difference) in adjusted else "same"
        judged.append(replace(difference, verdict=verdict))
    return tuple(judged)


def _requirements_met(summary: Mapping[str, object]) -> dict[str, str]:
    """Verdict on each requirement, by its quantity; of several on one quantity, with their limits."""
    items = mappings(summary.get("requirements"))
    quantities = [str(item.get("quantity")) for item in items]
    verdicts = {}
    for quantity, item in zip(quantities, items, strict=True):
        bounds = [f" {key.replace('_', ' ')} {item[key]:g}" for key in _BOUNDS if isinstance(item.get(key), float)]
        name = quantity if quantities.count(quantity) == 1 else quantity + "".join(bounds)
        verdicts[name] = "undecided" if item.get("undecided") else "met" if item.get("met") else "not met"
    return verdicts
