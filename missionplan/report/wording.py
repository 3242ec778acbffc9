"""Names of keys and phases as people read them."""

import re

from missionplan.report.display_units import split_key

_PHRASES = {
    "velocity_error.along": "velocity error along the track",
    "velocity_error.across": "velocity error across the track",
    "fix_error.along": "error of the fix along the track",
    "fix_error.across": "error of the fix across the track",
    "arrived": "arrival",
    "within_radius": "anchor within the radius",
    "struck_seafloor": "strike on the seafloor",
}
"""Quantities and events of a phase whose names do not read as phrases."""
_POINT_OR_UNDERSCORE = re.compile(r"\.(?!\d)|_")


def in_words(name: str) -> str:
    """Write a dotted name in words: ``moor release time``, ``current speed in layer 2``, ``arrival (ingress)``."""
    quantity = split_key(name)[0].removeprefix("effects.").removeprefix("navigation.")
    phase, _, own = quantity.partition(".")
    if own in _PHRASES:
        return f"{_PHRASES[own]} ({phase})"
    if quantity.startswith("site.current["):
        layer, _, rest = quantity.removeprefix("site.current[").partition("].")
        return f"current {rest} in layer {int(layer) + 1}"
    return _POINT_OR_UNDERSCORE.sub(" ", quantity)


def capitalised(words: str) -> str:
    """Write the first letter as a capital and leave the rest."""
    return words[:1].upper() + words[1:]
