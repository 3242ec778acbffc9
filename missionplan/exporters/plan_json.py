"""The whole plan as JSON, for programs: the entries that its fields state, and its states."""

from dataclasses import dataclass
from typing import Annotated, Literal

from missionplan.results import to_json
from missionplan.results.entries import Entry, Record
from missionplan.results.plan import Plan
from missionplan.results.plan_states import State, states_of

TITLE = "JSON, all of the plan"
NEEDS_ORIGIN = False
PLAN_FORMAT: Literal[2] = 2
"""Number of the form: it goes up when a file of it would be read otherwise."""


@dataclass(frozen=True)
class PlanFile(Record):
    """What the file holds: SI units that end the keys, angles in degrees, null where a value is not known.

    Uncertain quantities of the mission are at their means; durations of 99 % are from trials.
    """

    plan: Annotated[Plan, Entry("its own entries", inline=True)]
    states: Annotated[
        tuple[State, ...],
        Entry(
            "the plan as a state machine, which `simulate` runs and every other format translates: the first state is "
            "where it begins; the vehicle steers for the point until its dead reckoning is there, and has arrived "
            "where the fix lies within the radius"
        ),
    ]
    format: Annotated[Literal["missionplan plan"], Entry("what the file is")] = "missionplan plan"
    format_version: Annotated[Literal[2], Entry("number of its form")] = PLAN_FORMAT


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold: nothing."""
    del plan
    return ()


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file."""
    return {f"{stem}.plan.json": plan_json(plan)}


def plan_json(plan: Plan) -> str:
    """Write the plan; what is not known is null."""
    return to_json(PlanFile(plan, states_of(plan)).summary())
