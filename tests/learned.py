"""What the draws of an extended mission hold, for tests of many rooms."""

from collections.abc import Mapping

import numpy as np

from missionplan.montecarlo.posterior import WeightedDraws


def likeliest(extended: Mapping[str, object]) -> WeightedDraws:
    """Draws of the likeliest set of effects."""
    draws = extended["posterior"].draws
    return draws.of_set(int(np.argmax(draws.probabilities)))


def held(extended: Mapping[str, object]) -> tuple[str, ...]:
    """Effects of the likeliest set."""
    return likeliest(extended).sets[0] if "posterior" in extended else ()


def moments(extended: Mapping[str, object], effect: str, name: str) -> tuple[float, float]:
    """Mean and standard deviation of a parameter in the likeliest set."""
    values, _ = likeliest(extended).column((effect, name))
    return float(values.mean()), float(values.std())
