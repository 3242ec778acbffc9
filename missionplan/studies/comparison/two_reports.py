"""`compare`: what changed between two reports of one command, and whether it is more than Monte-Carlo noise."""

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.identity import differences, digest_of, program_part
from missionplan.mission.reading.documents import load_document, read_text
from missionplan.results.base import Provenance, without_run
from missionplan.results.entries import mapping, mappings, whole
from missionplan.store.folder import as_path
from missionplan.studies.comparison.reported_choices import CHOOSING
from missionplan.studies.comparison.result import ChangedValue, ComparedNumber, ComparedRun, Comparison
from missionplan.studies.comparison.summary_numbers import (
    SECTIONS,
    SummaryNumber,
    changed_values,
    holm,
    standard_error_and_p_value,
    summary_numbers,
)
from missionplan.studies.coverage import coverage_of

LEVEL = 0.05
"""Probability of finding any difference where there is none."""
_MAX_BYTES = 50_000_000


def compare_reports(first: str | Path, second: str | Path) -> Comparison:
    """Compare two report folders.

    The runs are taken as independent: two runs of one seed share their draws, so that a difference that is called noise
    here may be real.

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
    folders = (as_path(first, "first"), as_path(second, "second"))
    summaries = [read_summary(folder) for folder in folders]
    missions = [load_document(folder / "mission.yaml").data for folder in folders]
    command = _one_command(folders, summaries)
    runs = _run(folders[0], summaries[0]), _run(folders[1], summaries[1])
    one, two = (summary_numbers(summary, command) for summary in summaries)
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
            notices=(*_notices(runs), *_other_program(*summaries)),
            inputs={"reports": [digest_of(summary) for summary in summaries]},
            holds=coverage_of({run.folder: summary for run, summary in zip(runs, summaries, strict=True)}),
        ),
        compared=command,
        runs=runs,
        mission_changes=changed_values(missions[0], missions[1]),
        option_changes=changed_values(_options(summaries[0]), _options(summaries[1])),
        differences=_with_verdicts(list(_differences(one, two, (runs[0].trials, runs[1].trials)))),
        requirement_changes=_requirement_changes(*summaries),
    )


def read_summary(folder: Path) -> dict[str, object]:
    """Read the summary of a report folder; raises InputError where it is none."""
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


def _one_command(folders: Sequence[Path], summaries: Sequence[Mapping[str, object]]) -> str:
    commands = [summary["command"] for summary in summaries]
    if commands[0] != commands[1]:
        made = " and ".join(f"{folder} by {command}" for folder, command in zip(folders, commands, strict=True))
        raise InputError([Problem(f"two reports of one command were expected, but they were made {made}")])
    if commands[0] not in SECTIONS:
        known = ", ".join((*SECTIONS, *CHOOSING))
        raise InputError([Problem(f"reports of {commands[0]} cannot be compared; those of {known} can")])
    return str(commands[0])


def _run(folder: Path, summary: Mapping[str, object]) -> ComparedRun:
    text = {key: str(summary.get(key, "")) for key in ("mission", "version", "created_utc")}
    seed, trials = (whole(summary.get(key)) for key in ("seed", "trials"))
    return ComparedRun(str(folder), text["mission"], text["version"], text["created_utc"], seed, trials)


def _options(summary: Mapping[str, object]) -> dict[str, object]:
    return {key: summary.get(key) for key in ("seed", "trials", "version")} | {
        f"option {key}": value for key, value in mapping(summary.get("options")).items()
    }


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


def _notices(runs: tuple[ComparedRun, ComparedRun]) -> tuple[str, ...]:
    if runs[0].seed != runs[1].seed:
        return ()
    return ("Both runs have the same seed and so share draws: a difference that is called noise here may be real",)


def _differences(
    first: Mapping[tuple[str, str], SummaryNumber],
    second: Mapping[tuple[str, str], SummaryNumber],
    trials: tuple[int, int],
) -> Iterator[ComparedNumber]:
    for place in dict.fromkeys((*first, *second)):
        one, two = first.get(place), second.get(place)
        if one is not None and two is not None:
            error, p_value = standard_error_and_p_value(one, two, trials)
            yield ComparedNumber(*place, one.kind, one.value, two.value, error, p_value, "not judged")
        elif one is not None:
            yield ComparedNumber(*place, one.kind, one.value, None, None, None, "only first")
        elif two is not None:
            yield ComparedNumber(*place, two.kind, None, two.value, None, None, "only second")


def _with_verdicts(differences: Sequence[ComparedNumber]) -> tuple[ComparedNumber, ...]:
    """Add the verdicts: exact where there is no noise, by Holm's correction over all numbers that have some."""
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
        return replace(difference, verdict="changed" if adjusted < LEVEL else "within noise")
    return replace(difference, verdict="changed" if difference.p_value < LEVEL else "same")


def _requirement_changes(first: Mapping[str, object], second: Mapping[str, object]) -> tuple[ChangedValue, ...]:
    """Requirements that are judged otherwise in the two runs, or that one run does not have."""
    return changed_values(_requirements_met(first), _requirements_met(second))


def _requirements_met(summary: Mapping[str, object]) -> dict[str, str]:
    """Verdict on each requirement, by its quantity; of several on one quantity, with their limits."""
    items = mappings(summary.get("requirements"))
    quantities = [str(item.get("quantity")) for item in items]
    return {
        quantity if quantities.count(quantity) == 1 else f"{quantity}{_limit(item)}": _judged(item)
        for quantity, item in zip(quantities, items, strict=True)
    }


def _limit(requirement: Mapping[str, object]) -> str:
    bounds = (("at_most", "at most"), ("at_least", "at least"))
    return "".join(f" {words} {requirement[key]:g}" for key, words in bounds if isinstance(requirement.get(key), float))


def _judged(requirement: Mapping[str, object]) -> str:
    if requirement.get("undecided"):
        return "undecided"
    return "met" if requirement.get("met") else "not met"
