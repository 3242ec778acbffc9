"""Reports of `explore` and `optimise` as alternatives: the best of each, and what it was chosen from."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

from missionplan.errors import InputError, Problem
from missionplan.montecarlo.statistics import Probability
from missionplan.results.decision import Aim
from missionplan.results.entries import mapping, mappings, real, whole
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.comparison.result import Alternative, Chosen, Estimate, TriedCell


def _whole_mission(summary: Mapping[str, object]) -> dict[str, object]:
    """Return what a summary says of a mission that was simulated, as a cell of an exploration has it."""
    total = mapping(summary.get("total"))
    rest = {key: summary.get(key) for key in ("requirements", "trials")}
    return {"success": mapping(total.get("events")).get("success"), "quantities": total.get("quantities"), **rest}


def _alternative(
    name: str, folder: Path, summary: Mapping[str, object], cell: Mapping[str, object], chosen: Chosen | None = None
) -> Alternative:
    trials = whole(cell.get("trials"))
    return Alternative(
        name=name,
        source=str(folder),
        success=probability_of(cell.get("success")),
        quantities=estimates_of(cell.get("quantities")),
        requirements=tuple(_requirement(item, trials) for item in mappings(cell.get("requirements"))),
        trials=trials,
        seed=whole(summary.get("seed")),
        contrasts={},
        chosen=chosen,
    )


def probability_of(entry: object) -> Probability:
    """Read a probability of a summary; nan where it has none."""
    return Probability(*(real(mapping(entry).get(key)) for key in ("value", "low", "high")))


def estimates_of(entries: object) -> dict[str, Estimate]:
    """Read energy and duration of a summary, where it has them."""
    estimates = {}
    for name, entry in mapping(entries).items():
        mean, error = (real(mapping(entry).get(key)) for key in ("mean", "standard_error"))
        if name in ("duration_s", "energy_wh") and math.isfinite(mean):
            estimates[name] = (mean, error)
    return estimates


def _requirement(item: Mapping[str, object], trials: int) -> RequirementOutcome:
    sides: tuple[Literal["at_most", "at_least"], ...] = ("at_most", "at_least")
    bound = next((side for side in sides if side in item), None)
    return RequirementOutcome(
        quantity=str(item.get("quantity")),
        bound=bound,
        limit=None if bound is None else real(item[bound]),
        unit="",
        required=real(item.get("required")),
        probability=probability_of(item.get("probability")),
        met=bool(item.get("met")),
        undecided=bool(item.get("undecided")),
        trials=trials,
    )


CHOOSING = ("explore", "optimise")
Summary = Mapping[str, object]


def reported_alternative(name: str, folder: Path, summary: Summary) -> Alternative:
    """Read a report of `simulate`, or the best of one of `explore` or `optimise`."""
    command = summary.get("command")
    if command == "explore":
        entry, cells = mapping(summary.get("best")), []
        for cell in mappings(summary.get("cells")):
            required = mappings(cell.get("requirements"))
            met = bool(required) and all(item.get("met") for item in required)
            cells.append(
                TriedCell(tuple(_texts(cell.get("values")).values()), met, probability_of(cell.get("success")))
            )
        of_total = {
            str(key).removeprefix("total."): value
            for key, value in mapping(entry.get("quantities")).items()
            if str(key).startswith("total.")
        }
        windows = tuple((str(window.get("from")), str(window.get("to"))) for window in mappings(summary.get("windows")))
        chosen = Chosen(_texts(entry.get("values")), len(cells), windows, tuple(cells))
        return _alternative(name, folder, summary, {**entry, "quantities": of_total}, chosen)
    if command == "optimise":
        chosen = Chosen(_texts(summary.get("chosen")), whole(summary.get("combinations")))
        case = _alternative(name, folder, summary, _whole_mission(summary), chosen)
        # requirements that no choice meets, with the most that is reached of each
        obstacles = mappings(summary.get("obstacles"))
        unmet = [
            {**obstacle, "probability": obstacle.get("reached"), "met": False, "undecided": False}
            for obstacle in obstacles
        ]
        return replace(
            case, requirements=case.requirements or tuple(_requirement(obstacle, case.trials) for obstacle in unmet)
        )
    if command == "simulate" and isinstance(mapping(summary.get("total")).get("events"), Mapping):
        return _alternative(name, folder, summary, _whole_mission(summary))
    others = "missions and reports of simulate are compared, or reports of explore, or of optimise"
    raise InputError([Problem(f"was made by {command}; of more than two, {others}", str(folder))])


def check_kinds(sources: Sequence[tuple[Path, Summary]]) -> str:
    """Return the command compared, a mission having no summary; raises InputError where kinds are unlike."""
    made = [str(summary.get("command", "simulate")) for _, summary in sources]
    kinds = set(made)
    if not kinds & set(CHOOSING):
        return "simulate"
    if len(kinds) > 1:
        listed = [
            f"{path} {f'was made by {command}' if summary else 'is a mission'}"
            for (path, summary), command in zip(sources, made, strict=True)
        ]
        message = (
            f"unlike things cannot be compared: {', '.join(listed)}; expected reports of explore alone, reports of "
            "optimise alone, or missions and reports of simulate"
        )
        chosen = [path for (path, _), command in zip(sources, made, strict=True) if command == "optimise"]
        hint = f"what optimise chose is a mission too: {chosen[0] / 'mission-optimised.yaml'}" if chosen else ""
        raise InputError([Problem(message, hint=hint)])
    varied = []  # explorations of unlike keys have no cells in common
    for _, summary in sources if kinds == {"explore"} else ():
        keys = [axis.get("keys") for axis in mappings(summary.get("vary"))]
        varied.append("+".join("+".join(map(str, names)) if isinstance(names, list) else "" for names in keys))
    if len(set(varied)) > 1:
        variations = ", ".join(f"{path} varies {keys}" for (path, _), keys in zip(sources, varied, strict=True))
        raise InputError([Problem(f"explorations of the same keys were expected, in the same order, but {variations}")])
    return made[0]


def aim_of(summaries: Sequence[Summary]) -> Aim:
    """What all reports aim at; success where they differ, or have none."""
    aims = {summary.get("aim") for summary in summaries}
    (aim,) = aims if len(aims) == 1 else ("success",)
    return next((candidate for candidate in get_args(Aim) if candidate == aim), "success")


def _texts(value: object) -> dict[str, str]:
    return {str(key): str(inner) for key, inner in mapping(value).items()}
