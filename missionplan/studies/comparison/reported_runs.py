"""A report of `simulate` as an alternative among others."""

import math
from collections.abc import Mapping
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.montecarlo.statistics import Probability
from missionplan.results.choosing.alternatives import Alternative, Estimate
from missionplan.results.plain_data import mapping, mappings, real, whole
from missionplan.results.simulation import RequirementOutcome


def reported(name: str, folder: Path, summary: Mapping[str, object]) -> Alternative:
    """Read what a report's `summary.json` says of success, duration, energy and requirements.

    Raises
    ------
    InputError
        When it is not a report of `simulate`.
    """
    total, trials = mapping(summary.get("total")), whole(summary.get("trials"))
    events = total.get("events")
    if summary.get("command") != "simulate" or not isinstance(events, Mapping):
        message = (
            f"was made by {summary.get('command')}; of more than two, missions and reports of simulate are compared, "
            "or reports of explore, or of optimise"
        )
        raise InputError([Problem(message, str(folder))])
    return Alternative(
        name=name,
        source=str(folder),
        success=probability_of(events.get("success")),
        quantities=estimates_of(total.get("quantities")),
        requirements=requirements_of(summary.get("requirements"), trials),
        trials=trials,
        seed=whole(summary.get("seed")),
        contrasts={},
    )


def requirements_of(entries: object, trials: int) -> tuple[RequirementOutcome, ...]:
    """Read the requirements of a summary."""
    return tuple(_requirement(item, trials) for item in mappings(entries))


def probability_of(entry: object) -> Probability:
    """Read a probability of a summary; nan where it has none."""
    return Probability(*(real(mapping(entry).get(key)) for key in ("value", "low", "high")))


def estimates_of(entries: object) -> dict[str, Estimate]:
    """Read energy and duration of a summary, where it has them."""
    found = {}
    for name, entry in mapping(entries).items():
        mean, error = (real(mapping(entry).get(key)) for key in ("mean", "standard_error"))
        if name in ("duration_s", "energy_wh") and math.isfinite(mean):
            found[name] = (mean, error)
    return found


def _requirement(item: Mapping[str, object], trials: int) -> RequirementOutcome:
    bound: tuple[str, ...] = tuple(side for side in ("at_most", "at_least") if side in item)
    return RequirementOutcome(
        quantity=str(item.get("quantity")),
        bound=None if not bound else "at_most" if bound[0] == "at_most" else "at_least",
        limit=real(item[bound[0]]) if bound else None,
        unit="",
        required=real(item.get("required")),
        probability=probability_of(item.get("probability")),
        met=bool(item.get("met")),
        undecided=bool(item.get("undecided")),
        trials=trials,
    )
