"""Draw a transit case: effects, survey, log and mission file."""

from collections.abc import Callable

import numpy as np

from ..case import Case
from .catalogue import CATALOGUE
from .files import columns, mission_file
from .outside import OUTSIDE
from .strength import HiddenEffects, draw_hidden
from .survey import RANDOM, Survey, draw_survey, with_scaled_nuisances

TIES = {"compass-bias": ("compass-deviation", "mean-current"), "speed-scale": ("mean-current",)}
"""Effects that on a single heading cannot be distinguished from an effect."""


STRONG = {
    "mean-current": (0.15, 0.5),
    "tidal-current": (0.36, 1.2),
    "inertial-current": (0.45, 1.0),
    "compass-bias": (0.15, 0.5),
    "compass-deviation": (0.2, 0.6),
    "speed-scale": (0.12, 0.35),
    "surface-drift": (0.6, 1.2),
    "current-shear": (0.2, 0.6),
}
"""Sizes of strong effects: 3 to 10 times the usual ones, at most half of what is possible [as in the catalogue]."""


def _strong_size(rng: np.random.Generator, name: str) -> float:
    low, high = STRONG[name]
    return float(low * (high / low) ** rng.random())


def draw(seed: int, scenario: str, effect: str | None = None) -> Case:
    """Draw a transit case; deterministic for its arguments."""
    base = [seed, 2, sum(map(ord, scenario))]
    names = _pick_effects(np.random.default_rng(base), scenario)
    if effect is not None:
        names = (effect,)
    scale = 0.25 if scenario == "weak" else 1.0
    size = _strong_size(np.random.default_rng([*base, 99]), names[0]) if scenario == "strong" else None
    for attempt in range(30):
        shape, hiding = np.random.default_rng([*base, attempt]).spawn(2)
        survey = draw_survey(shape, scenario, names)
        if scenario == "control":
            survey = with_scaled_nuisances(survey, shape)
        hidden = draw_hidden(survey, names, hiding, [*base, attempt, 7], scale, size)
        if hidden is not None:
            break
    else:
        raise RuntimeError(f"no survey shows {names} (seed {seed})")
    return _case(seed, scenario, names, survey, hidden, shape, attempt)


def draw_sized(seed: int, effect: str, size: Callable[[Survey], float]) -> Case:
    """Draw a case with one effect of a size, as its builder takes it on a survey, whether it can be seen or not.

    Its log says how long the vehicle lay at the surface: else all that acts under way would seem weaker.
    """
    for attempt in range(30):
        shape, hiding = np.random.default_rng([seed, 2, 77, attempt]).spawn(2)
        survey = draw_survey(shape, "single", (effect,))
        hidden = draw_hidden(survey, (effect,), hiding, [seed, 2, 77, attempt, 7], 1.0, size(survey))
        if hidden is not None and hidden.parameters:  # a mixture has no degrees of freedom
            return _case(seed, "single", (effect,), survey, hidden, shape, attempt, states_surface_time=True)
    raise RuntimeError(f"no survey has {effect} (seed {seed})")


def _case(
    seed: int,
    scenario: str,
    names: tuple[str, ...],
    survey: Survey,
    hidden: HiddenEffects,
    shape: np.random.Generator,
    attempt: int,
    states_surface_time: bool = False,
) -> Case:
    inside = scenario != "outside"
    header, rows, dataset = columns(survey, hidden.log, shape, states_surface_time or "surface-drift" in names)
    return Case(
        seed=seed,
        kind="transit",
        scenario=scenario,
        truth=names if inside else (),
        ties=tuple((rival,) for rival in TIES[names[0]]) if scenario == "tie" else (),
        outside="" if inside else names[0],
        parameters=hidden.parameters if inside else {},
        strength=hidden.strength,
        mission=mission_file(survey, shape),
        vehicle=None,
        dataset=dataset,
        header=header,
        rows=rows,
        notes={
            "sizes": hidden.sizes,
            "sigma": survey.sigma,
            "fix": survey.fix,
            "pattern": survey.pattern,
            "legs": int(survey.planned.size),
            "latitude": survey.latitude,
            "attempt": attempt,
        },
    )


def _pick_effects(rng: np.random.Generator, scenario: str) -> tuple[str, ...]:
    if scenario == "control":
        return ()
    if scenario == "outside":
        return (str(rng.choice(list(OUTSIDE))),)
    if scenario in ("tie", "narrow"):
        return (str(rng.choice(["compass-bias", "speed-scale"])),)
    if scenario == "strong":
        return (str(rng.choice(list(STRONG))),)
    while True:
        names = tuple(sorted(str(name) for name in rng.choice(list(CATALOGUE), 1 + (scenario == "pair"), False)))
        if len(RANDOM & set(names)) < 2:
            return names
