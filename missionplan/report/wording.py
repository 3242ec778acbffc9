"""Names of keys and phases as people read them."""

import re

from missionplan.report.display_units import split_key

_POINT_OR_UNDERSCORE = re.compile(r"\.(?!\d)|_")


def in_words(name: str) -> str:
    """Write a dotted name in words: ``moor release time``, ``current speed in layer 2``."""
    quantity = split_key(name)[0].removeprefix("effects.")
    if quantity.startswith("site.current["):
        layer, _, rest = quantity.removeprefix("site.current[").partition("].")
        return f"current {rest} in layer {int(layer) + 1}"
    return _POINT_OR_UNDERSCORE.sub(" ", quantity)


def capitalised(words: str) -> str:
    """Write the first letter as a capital and leave the rest."""
    return words[:1].upper() + words[1:]
