"""Runs of dives: anchor, line and site of each, from `runs:` in `dataset.yaml`, else from the mission."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated

from missionplan.datasets.reading import DatasetSettings, RawDataset
from missionplan.errors import Problem, did_you_mean
from missionplan.mission import Mission
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.moment import Moment
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy
from missionplan.montecarlo.distributions import mean_of

Weight = Annotated[float, ReadBy(QuantityParser("N", low=0.0, open_low=True, fixed=True))]


_CONDITIONS = ("anchor_wet_weight", "line_length", "depth")
DEEPEST = 11_000.0
"""Of the sea [m]."""


class RunSection(FileSection):
    """What differed from the mission in one run, and when its anchor separated, where its times are of the day."""

    anchor_wet_weight: Weight | None = None
    line_length: q.FixedLength | None = None
    depth: q.FixedLength | None = None
    separation: Moment | None = None


class DivesSettings(DatasetSettings):
    """Keys of a data set of dives."""

    runs: Mapping[str, RunSection] = {}


@dataclass(frozen=True)
class DiveConditions:
    """Anchor's wet weight [N], length of the line [m] and depth of the site [m] of one dive."""

    wet_weight: float
    line_length: float
    site_depth: float


def conditions_of_runs(
    names: Iterable[str], raw: RawDataset[DivesSettings], mission: Mission
) -> tuple[dict[str, DiveConditions], list[Problem]]:
    """Return the conditions of the runs, and what is wrong with them.

    Parameters
    ----------
    names : iterable of str
        Of the runs.
    raw : RawDataset
        What ``dataset.yaml`` says of them.
    mission : Mission
        Where the rest is taken from, at its means.
    """
    conditions: dict[str, DiveConditions] = {}
    problems: list[Problem] = []
    if raw.settings is None:
        return conditions, problems
    default, names = _of_mission(mission), tuple(names)
    for name in raw.settings.runs:
        if name not in names:
            hint = did_you_mean(name, names)
            problems.append(raw.document.problem(("runs", name), "no row of the table is of this run", hint))
    for name in names:
        run = raw.settings.runs.get(name, RunSection())
        given = default | run.model_dump(exclude_none=True)
        missing = [key for key in _CONDITIONS if key not in given]
        messages = [f"needs {key}: neither the run nor the mission has it" for key in missing]
        if not missing:
            conditions[name] = DiveConditions(given["anchor_wet_weight"], given["line_length"], given["depth"])
            if conditions[name].site_depth > DEEPEST:
                messages.append(f"depth: expected at most {DEEPEST:g} m, the deepest sea")
            if conditions[name].site_depth <= conditions[name].line_length:
                messages.append("the line is as long as the site is deep: the vehicle is never pulled down")
        problems += [raw.document.problem(("runs", name), message) for message in messages]
    return conditions, problems


def _of_mission(mission: Mission) -> dict[str, float]:
    """Conditions of the mission's first mooring, at its means, as far as it has them."""
    found: dict[str, float] = {}
    if mission.site is not None and mission.site.depth is not None:
        found["depth"] = mean_of(mission.site.depth)
    if mission.moors:
        moor = mission.moors[0]
        found["line_length"] = mean_of(moor.line_length)
        if not isinstance(moor.anchor_wet_weight, str):
            found["anchor_wet_weight"] = mean_of(moor.anchor_wet_weight)
    return found
