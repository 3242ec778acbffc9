"""Dives of one weight and one line, with a cause that such dives cannot tell from others.

The dives are those of the study of hidden effects, which shares nothing with the package.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tests.hidden_effects.dives.drag import Craft
from tests.hidden_effects.dives.dynamics import DiveEffect
from tests.hidden_effects.dives.files import measure, mission_files
from tests.hidden_effects.dives.trials import draw_nuisances, draw_plan

ATMOSPHERE = 10.13
"""Head of water that weighs as much as the atmosphere [m]."""
CAUSES = ("drag-bias", "vertical-current", "trapped-gas", "depth-scale", "line-payout", "clock-offset")


@dataclass(frozen=True)
class Hidden:
    """Data with a cause, the mission that does not know of it, and the effects that tell the truth.

    Attributes
    ----------
    kind : str
        ``dives`` or ``legs``.
    mission : mapping
        The base mission's data.
    dataset : mapping
        Contents of ``dataset.yaml``.
    header, rows
        Contents of the CSV file.
    truth : mapping
        An entry of ``effects`` with the true parameters.
    """

    kind: str
    mission: Mapping[str, Any]
    dataset: Mapping[str, Any]
    header: list[str]
    rows: list[list[str]]
    truth: Mapping[str, Any]


def draw_dives(seed: int) -> Hidden:
    """Draw a mooring to plan, and two or three dives of one weight that were made before it."""
    rng = np.random.default_rng([seed, 71])
    shape, noise_rng = rng.spawn(2)
    plan = draw_plan(shape, "tie", ())
    weight, line, site = plan.dives[0].wet_weight, plan.dives[0].line, plan.site_depth
    count = int(rng.integers(2, 4))
    dives = tuple(replace(plan.dives[0], wet_weight=weight, line=line, site_depth=site, number=k) for k in range(count))
    plan = replace(plan, dives=dives, vehicle_form="inline")
    effect, truth = _cause(str(rng.choice(CAUSES)), rng, plan.craft, weight)
    header, rows, dataset = measure(plan, draw_nuisances(shape, "single"), [effect], noise_rng)
    mission, _ = mission_files(plan, shape)
    (layer,) = mission["site"]["current"]
    current = rng.uniform(0.15, 0.45)
    layer["speed"] = {"mean": f"{current:.3f} m/s", "sd": f"{0.15 * current:.4f} m/s"}
    moor = mission["phases"][0]["moor"]
    moor["radius"] = f"{current * site / rng.uniform(0.7, 1.2) + 3.0:.1f} m"
    moor["carry_net_buoyancy"] = True
    moor["line_length"] = "8 m"  # so that an anchor heavy enough does not take the vehicle to the seafloor
    return Hidden("dives", mission, dataset, header, rows, truth)


def _cause(name: str, rng: np.random.Generator, craft: Craft, weight: float) -> tuple[DiveEffect, dict[str, Any]]:
    """One cause of a size that a dive shows, either sign where it has two."""
    sign = 1.0 if rng.random() < 0.5 else -1.0
    if name == "drag-bias":
        size = rng.uniform(0.2, 0.6) if sign > 0.0 else -rng.uniform(0.15, 0.3)
        effect = DiveEffect(lone_drag=1.0 + size, drag=lambda t, u, z, number: 1.0 + size)
        return effect, {name: {"fraction": size}}
    if name == "vertical-current":
        size = sign * rng.uniform(0.06, 0.2)
        return DiveEffect(water=lambda t, z: size), {name: {"speed": f"{size} m/s"}}
    if name == "trapped-gas":
        size = rng.uniform(0.1, 0.35) * weight
        return DiveEffect(lift=lambda z: size * ATMOSPHERE / (ATMOSPHERE + z)), {name: {"lift": f"{size} N"}}
    if name == "depth-scale":
        size = sign * rng.uniform(0.04, 0.1)
        return DiveEffect(reading=lambda t, depth, number: depth * (1.0 + size)), {name: {"fraction": size}}
    if name == "line-payout":
        size = rng.uniform(0.15, 0.5)
        return DiveEffect(delay=lambda line, number: size * line), {name: {"delay_per_length": f"{size} s/m"}}
    size = sign * rng.uniform(0.4, 1.5)
    return DiveEffect(delay=lambda line, number: size), {name: {"time": f"{size} s"}}
