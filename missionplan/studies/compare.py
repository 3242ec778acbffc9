"""`compare`: what changed between two reports of one command, and whether it is more than Monte-Carlo noise."""

import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtr

from missionplan.errors import InputError, Problem
from missionplan.mission.reading.documents import load_document, read_text
from missionplan.results.base import Provenance
from missionplan.results.comparison import ChangedValue, ComparedNumber, ComparedRun, Comparison
from missionplan.studies.mission_changes import changes

SECTIONS = {
    "simulate": ("phases", "total", "requirements"),
    "sweep-dmax": ("sweep",),
    "size-anchor": ("anchor", "descent", "odds", "probable"),
}
"""What is compared, by the command that made the reports."""
_NAMES = ("name", "sigma_m_s", "d_max_m", "quantity")
"""Keys that tell the items of a list apart."""
_NOISY = {"sweep-dmax": ("sweep",), "size-anchor": ("probable",)}
"""Sections whose bare numbers come out of a search over noisy values."""
_LEVEL = 0.05
_MAX_BYTES = 50_000_000
_MAX_DEPTH = 20

Reading = tuple[str, float, float]
"""Kind, value and standard error of a number of a summary; the error is nan where it is not known."""


def compare(first: str | Path, second: str | Path) -> Comparison:
    """Compare two report folders.

    The runs are taken as independent: two runs of one seed share their draws, so that less than is said here may
    be noise.

    Parameters
    ----------
    first, second : str or Path
        Report folders with `summary.json` and `mission.yaml`, made by the same command.

    Raises
    ------
    InputError
        When a folder is no report, or the two were not made by one command that can be compared.
    """
    began = time.perf_counter()
    folders = (Path(first), Path(second))
    summaries = [_read_summary(folder) for folder in folders]
    missions = [load_document(folder / "mission.yaml").data for folder in folders]
    command = _one_command(folders, summaries)
    runs = _run(folders[0], summaries[0]), _run(folders[1], summaries[1])
    one, two = (dict(_readings(summary, command)) for summary in summaries)
    return Comparison(
        provenance=Provenance(
            command="compare",
            mission=" and ".join(dict.fromkeys(run.mission for run in runs)),
            file=" ".join(run.folder for run in runs),
            seed=runs[1].seed,
            trials=runs[1].trials,
            options={},
            elapsed_s=time.perf_counter() - began,
            data={"first": missions[0], "second": missions[1]},
            notices=_notices(runs),
        ),
        compared=command,
        runs=runs,
        mission_changes=changes(missions[0], missions[1]),
        option_changes=changes(_options(summaries[0]), _options(summaries[1])),
        differences=_judge(list(_differences(one, two, runs))),
        requirement_changes=_requirement_changes(*summaries),
    )


def _read_summary(folder: Path) -> dict[str, Any]:
    if not folder.is_dir():
        raise InputError([Problem("no such folder", str(folder), hint="a report folder was expected")])
    path = folder / "summary.json"
    try:
        summary = json.loads(read_text(path, str(path), max_bytes=_MAX_BYTES))
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError([Problem(f"is not valid JSON: {error}", str(path))]) from None
    if not isinstance(summary, dict) or not isinstance(summary.get("command"), str):
        raise InputError([Problem("is not a summary of missionplan", str(path))])
    return summary


def _one_command(folders: Sequence[Path], summaries: Sequence[Mapping[str, Any]]) -> str:
    commands = [summary["command"] for summary in summaries]
    if commands[0] != commands[1]:
        made = " and ".join(f"{folder} by {command}" for folder, command in zip(folders, commands, strict=True))
        raise InputError([Problem(f"two reports of one command were expected, but they were made {made}")])
    if commands[0] not in SECTIONS:
        raise InputError([Problem(f"reports of {commands[0]} cannot be compared; those of {', '.join(SECTIONS)} can")])
    return str(commands[0])


def _run(folder: Path, summary: Mapping[str, Any]) -> ComparedRun:
    text = {key: str(summary.get(key, "")) for key in ("mission", "version", "created_utc")}
    whole = {key: value if isinstance(value := summary.get(key), int) else 0 for key in ("seed", "trials")}
    return ComparedRun(
        str(folder), text["mission"], text["version"], text["created_utc"], whole["seed"], whole["trials"]
    )


def _options(summary: Mapping[str, Any]) -> dict[str, Any]:
    options = summary.get("options")
    return {key: summary.get(key) for key in ("seed", "trials", "version")} | {
        f"option {key}": value for key, value in (options.items() if isinstance(options, Mapping) else ())
    }


def _notices(runs: tuple[ComparedRun, ComparedRun]) -> tuple[str, ...]:
    if runs[0].seed != runs[1].seed:
        return ()
    return ("both runs have the same seed and so share draws: a difference that is called noise here may be real",)


def _readings(summary: Mapping[str, Any], command: str) -> Iterator[tuple[tuple[str, str], Reading]]:
    """Numbers of a summary by (group, key)."""
    for section in SECTIONS[command]:
        error = math.nan if section in _NOISY.get(command, ()) else 0.0
        for path, reading in _walk(summary.get(section), (section,), error):
            yield _place(path), reading


def _walk(value: Any, path: tuple[str, ...], error: float) -> Iterator[tuple[tuple[str, ...], Reading]]:
    if len(path) > _MAX_DEPTH:
        return
    if isinstance(value, Mapping):
        yield from _walk_mapping(value, path, error)
    elif isinstance(value, list):
        for item in value:
            if isinstance(item, Mapping):
                name = ", ".join(_shown(item[key]) for key in (*_NAMES, "at_most", "at_least") if key in item)
                named = {key: inner for key, inner in item.items() if key not in _NAMES}
                yield from _walk(named, (*path, name), error)
    elif _is_number(value):
        yield path, ("number", float(value), error)


def _walk_mapping(
    value: Mapping[str, Any], path: tuple[str, ...], error: float
) -> Iterator[tuple[tuple[str, ...], Reading]]:
    """Read a mapping that may be a statistic, a probability or a point of a sweep."""
    estimate = "mean" if "mean" in value else "cost"
    if _is_number(value.get(estimate)) and _is_number(value.get("standard_error")):
        name = path if estimate == "mean" else (*path, "cost")
        yield name, ("mean", float(value[estimate]), float(value["standard_error"]))
        if estimate == "cost" and _is_number(value.get("d_max_m")):
            yield (*path, "d_max_m"), ("number", float(value["d_max_m"]), error)
    elif set(value) == {"value", "low", "high"}:
        if _is_number(value["value"]):
            yield path, ("probability", float(value["value"]), math.nan)
    else:
        for key, inner in value.items():
            if key not in ("required", "at_most", "at_least", "met", "undecided"):
                yield from _walk(inner, (*path, str(key)), error)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if _is_number(value) else str(value)


def _place(path: tuple[str, ...]) -> tuple[str, str]:
    """Group and key: the parts of the path that a reader needs."""
    if path[0] == "requirements":
        return "requirement", path[1]
    kept = [part for part in path if part not in ("phases", "quantities", "events")]
    return ", ".join(kept[:-1]) or kept[-1], kept[-1]


def _differences(
    first: Mapping[tuple[str, str], Reading],
    second: Mapping[tuple[str, str], Reading],
    runs: tuple[ComparedRun, ComparedRun],
) -> Iterator[ComparedNumber]:
    for place in dict.fromkeys((*first, *second)):
        one, two = first.get(place), second.get(place)
        kind: Any = (one or two or ("number",))[0]
        if one is None or two is None:
            values = (one[1] if one else None), (two[1] if two else None)
            yield ComparedNumber(*place, kind, *values, None, None, "only first" if one else "only second")
        else:
            error, p_value = _noise(one, two, runs)
            yield ComparedNumber(*place, kind, one[1], two[1], error, p_value, "not judged")


def _noise(first: Reading, second: Reading, runs: tuple[ComparedRun, ComparedRun]) -> tuple[float | None, float | None]:
    """Standard error of the difference, and its two-sided p-value."""
    change = second[1] - first[1]
    if first[0] == "probability":
        error, pooled = _two_proportions(first[1], second[1], runs[0].trials, runs[1].trials)
    else:
        error = pooled = math.hypot(first[2], second[2])
    if not math.isfinite(error):
        return None, None
    if pooled == 0.0:
        return 0.0, 1.0 if math.isclose(first[1], second[1], rel_tol=1e-9, abs_tol=1e-12) else 0.0
    return error, float(2.0 * ndtr(-abs(change) / pooled))


def _two_proportions(first: float, second: float, n: int, m: int) -> tuple[float, float]:
    """Standard error of the difference of two shares, and the same if both were one (pooled), for the test."""
    if n < 1 or m < 1:
        return math.nan, math.nan
    share = (n * first + m * second) / (n + m)
    own = math.sqrt(first * (1.0 - first) / n + second * (1.0 - second) / m)
    return own, math.sqrt(max(share * (1.0 - share), 0.0) * (1.0 / n + 1.0 / m))


def _judge(differences: Sequence[ComparedNumber]) -> tuple[ComparedNumber, ...]:
    """Give the verdicts: exact where there is no noise, by Holm's correction over all numbers that have some."""
    noisy = [difference for difference in differences if difference.standard_error and difference.p_value is not None]
    adjusted = dict(zip(map(id, noisy), holm([difference.p_value or 0.0 for difference in noisy]), strict=True))
    return tuple(_with_verdict(difference, adjusted.get(id(difference))) for difference in differences)


def _with_verdict(difference: ComparedNumber, adjusted: float | None) -> ComparedNumber:
    if difference.p_value is None:
        same = difference.verdict == "not judged" and difference.change == 0.0
        return replace(difference, verdict="same") if same else difference
    if difference.change == 0.0:
        return replace(difference, verdict="same")
    if adjusted is not None:
        return replace(difference, verdict="changed" if adjusted < _LEVEL else "within noise")
    return replace(difference, verdict="changed" if difference.p_value < _LEVEL else "same")


def holm(p_values: Sequence[float]) -> list[float]:
    """Adjust p-values so that the chance of any false finding stays at the level (Holm 1979)."""
    order = np.argsort(p_values)
    factors = np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[order] = np.minimum(np.maximum.accumulate(factors * np.asarray(p_values, dtype=float)[order]), 1.0)
    return [float(value) for value in adjusted]


def _requirement_changes(first: Mapping[str, Any], second: Mapping[str, Any]) -> tuple[ChangedValue, ...]:
    """Requirements that one run meets and the other does not."""
    judged = [
        {
            str(item.get("quantity")): "met" if item.get("met") else "not met"
            for item in (summary.get("requirements") or ())
            if isinstance(item, Mapping)
        }
        for summary in (first, second)
    ]
    return changes(judged[0], judged[1])
