"""Draw the pictures of ``docs/mooring.md``: ``python docs/figures/mooring.py``."""

import re
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

import missionplan
from missionplan.physics.held_line import LINE_MATERIALS, HeldLine, line_drag_factor
from missionplan.physics.line_statics import held_pose
from missionplan.physics.seafloor import LayersAbove
from missionplan.report.anchor.drawing import hold_figure
from missionplan.report.page import Figure, style, to_figure
from missionplan.scenario.anchors import wet_weight_of
from missionplan.scenario.phases import held_body
from missionplan.scenario.scenario import Scenario
from missionplan.studies.held_vehicle import held_vehicle

ROOT = Path(__file__).parents[2]


def stand(name: str) -> Figure:
    """Draw the vehicle of a mission in its mean and its worst current."""
    mission = missionplan.load(ROOT / "missions" / f"{name}.yaml")
    means, (moor,) = Scenario.at_means(mission), mission.moors
    return hold_figure(held_vehicle(means, moor, float(wet_weight_of(means, moor))))


def against_current() -> Figure:
    """Draw the nose's altitude against the current, for lines and coefficients."""
    body = held_body(Scenario.at_means(missionplan.load(ROOT / "missions" / "chesapeake.yaml")))
    speed = np.linspace(0.0, 1.0, 201)
    current = LayersAbove(np.full((1, speed.size), np.inf), np.stack([np.stack((speed, 0.0 * speed))]))
    figure = MatplotlibFigure(figsize=(6.0, 3.4))
    axes = figure.subplots()
    cases = [
        ("line without weight and drag", body.net_buoyancy, 0.0, "-"),
        ("4 mm of polyester", body.net_buoyancy, 0.004, "--"),
        ("5 N of net buoyancy", 5.0, 0.0, "-."),
    ]
    for label, buoyancy, width, dashes in cases:
        weight = LINE_MATERIALS["polyester"].wet_weight(width, body.density)
        line = HeldLine(5.0, line_drag_factor(width, body.density), wet_weight=weight)
        held = type(body)(**{**vars(body), "net_buoyancy": buoyancy, "raising_moment": 0.5 * body.length * buoyancy})
        pose = held_pose(held, line, current)
        axes.plot(speed, pose.nose[2], dashes, label=label)
    axes.plot([0.2 * 0.514444, 0.4 * 0.514444, 0.9], [4.0, 2.5, 0.6], "o", label="independent estimate", zorder=5)
    axes.set(xlabel="Current (m/s)", ylabel="Nose above the seafloor (m)", xlim=(0.0, 1.0), ylim=(0.0, 5.2))
    axes.legend()
    return to_figure(figure, "mooring-altitude", "Altitude of the nose against the current")


def main() -> None:
    """Write the pictures, on white so that they are legible on any page."""
    white = '<rect width="100%" height="100%" fill="#ffffff"/>'
    with style():
        pictures = {name: stand(name) for name in ("chesapeake", "anchor-design")}
        pictures["altitude"] = against_current()
    for name, picture in pictures.items():
        text = re.sub(r"(<svg[^>]*>)", rf"\1{white}", picture.svg, count=1)
        (Path(__file__).parent / f"mooring-{name}.svg").write_text(text)


if __name__ == "__main__":
    main()
