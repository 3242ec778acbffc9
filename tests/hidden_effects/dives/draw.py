"""Draw a descent case: effects, plan, log and mission files."""

import numpy as np

from ..case import Case
from .catalogue import CATALOGUE
from .files import measure, mission_files
from .outside import OUTSIDE, STUDIED
from .strength import LARGEST, HiddenEffects, draw_as_worth, draw_hidden, draw_strong, nats_beyond_the_named
from .trials import Nuisances, Plan, conditions_of, draw_nuisances, draw_plan

BLIND_SHARE = 0.75
"""Share of the cases outside the catalogue whose effects were not used in development."""
NEAR_TIES = ({"line-payout", "clock-offset"}, {"drag-bias", "depth-scale"}, {"drag-bias", "vertical-current"})
"""Never drawn as a pair: one can cancel or mimic the other."""


def draw(seed: int, scenario: str, effect: str | None = None, repeat: int = 0) -> Case:
    """Draw a descent case; deterministic for its arguments. Repeats differ in random errors alone."""
    base = [seed, 1, sum(map(ord, scenario))]
    names = _pick_effects(np.random.default_rng(base), scenario)
    if effect is not None:
        names = (effect,)
    scale = 0.25 if scenario == "weak" else 1.0
    for attempt in range(20):
        shape, hiding, noise_rng = np.random.default_rng([*base, attempt]).spawn(3)
        plan = draw_plan(shape, scenario, names)
        noise = draw_nuisances(shape, scenario)
        if scenario == "strong":
            hidden = draw_strong(plan, noise, names[0], hiding)
        else:
            hidden = draw_hidden(plan, noise, names, hiding, scale, scenario == "tie")
        if hidden is not None:
            break
    else:
        raise RuntimeError(f"no plan shows {names} (seed {seed})")
    if repeat:
        noise_rng = np.random.default_rng(
            [*base, attempt, repeat, 71]
        )  # a last word of 0 to 2 is a stream spawned above
    return _case(seed, scenario, names, plan, noise, hidden, (shape, noise_rng), attempt)


def draw_sized(seed: int, effect: str, size: float) -> Case:
    """Draw a case with one effect of a size, whether it can be seen or not."""
    shape, hiding, noise_rng = np.random.default_rng([seed, 1, 77]).spawn(3)
    plan = draw_plan(shape, "single", (effect,))
    noise = draw_nuisances(shape, "single")
    built, found = CATALOGUE[effect].build(size, hiding, conditions_of(plan))
    parameters = {f"{effect}.{key}": float(value) for key, value in found.items()}
    hidden = HiddenEffects((built,), parameters, {effect: size}, np.nan)
    return _case(seed, "single", (effect,), plan, noise, hidden, (shape, noise_rng), 0)


def draw_worth(seed: int, effect: str, nats: tuple[float, float]) -> Case:
    """Draw a case with an effect outside the catalogue that is worth nats in a range beyond what named effects can be."""
    base = [seed, 1, 79]
    for attempt in range(20):
        shape, hiding, noise_rng = np.random.default_rng([*base, attempt]).spawn(3)
        plan = draw_plan(shape, "outside", (effect,))
        noise = draw_nuisances(shape, "outside")
        hidden = draw_as_worth(plan, noise, effect, hiding, nats)
        if hidden is not None:
            return _case(seed, "outside", (effect,), plan, noise, hidden, (shape, noise_rng), attempt)
    raise RuntimeError(f"no plan shows {effect} (seed {seed})")


def _case(
    seed: int,
    scenario: str,
    names: tuple[str, ...],
    plan: Plan,
    noise: Nuisances,
    hidden: HiddenEffects,
    streams: tuple[np.random.Generator, np.random.Generator],
    attempt: int,
) -> Case:
    shape, noise_rng = streams
    header, rows, stated = measure(plan, noise, hidden.effects, noise_rng)
    inside = scenario != "outside"
    mission, vehicle = mission_files(plan, shape)
    notes = {} if inside else {"nats_beyond_the_named": nats_beyond_the_named(plan, noise, hidden.effects)}
    return Case(
        seed=seed,
        kind="descent",
        scenario=scenario,
        truth=names if inside else (),
        ties=_ties(plan, names),
        outside="" if inside else names[0],
        parameters=hidden.parameters if inside else {},
        strength=hidden.strength,
        mission=mission,
        vehicle=vehicle,
        dataset=stated,
        header=header,
        rows=rows,
        notes={"sizes": hidden.sizes, "nuisances": vars(noise), "attempt": attempt, **notes},
    )


def _pick_effects(rng: np.random.Generator, scenario: str) -> tuple[str, ...]:
    if scenario == "control":
        return ()
    if scenario == "outside":
        blind = rng.random() < BLIND_SHARE
        return (str(rng.choice([name for name in OUTSIDE if (name in STUDIED) != blind])),)
    if scenario == "tie":
        return (str(rng.choice(["line-payout", "clock-offset"])),)
    if scenario == "strong":
        return (str(rng.choice(list(LARGEST))),)
    while True:
        names = tuple(sorted(str(name) for name in rng.choice(list(CATALOGUE), 1 + (scenario == "pair"), False)))
        if not any(tie <= set(names) for tie in NEAR_TIES):
            return names


def _ties(plan: Plan, names: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """With one line length a pay-out delay and a clock offset are the same."""
    same_line = len({dive.line for dive in plan.dives}) == 1
    if not (same_line and {"line-payout", "clock-offset"} & set(names)):
        return ()
    swap = {"line-payout": "clock-offset", "clock-offset": "line-payout"}
    return (tuple(sorted(swap.get(name, name) for name in names)),)
