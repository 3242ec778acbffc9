"""What each vehicle's format does with the guards of a plan's states: kept, weaker by so much, or refused."""

from collections.abc import Mapping
from importlib import import_module
from typing import cast

from missionplan.exporters.formats import FORMATS, VEHICLES
from missionplan.results.plan_states import GUARDS, GuardKind


def conformance(name: str) -> Mapping[GuardKind, str]:
    """Return what the format of a vehicle does with each guard, in words."""
    return cast(Mapping[GuardKind, str], import_module(FORMATS[name]).CONFORMANCE)


def conformance_table() -> str:
    """Return the table of `docs/vehicles.md`: guards by formats, in Markdown."""
    told = [conformance(name) for name in VEHICLES]
    lines = [f"| guard | {' | '.join(f'`{name}`' for name in VEHICLES)} |", "|---" * (len(VEHICLES) + 1) + "|"]
    for guard, (words, unit) in GUARDS.items():
        asked = words.format(f"so many {unit}" if unit else "")
        lines.append(f"| {asked} | {' | '.join(each[guard] for each in told)} |")
    return "\n".join(lines) + "\n"
