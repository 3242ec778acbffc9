"""Draw the cost of Fig. 8 of Briggs et al.: ``python docs/figures/fig8.py``."""

import re
from pathlib import Path

import missionplan
from missionplan.report.page import style
from missionplan.studies.leg_length.figures import cost_figure

ROOT = Path(__file__).parents[2]


def main() -> None:
    """Write fig8.svg, on white so that it is legible on any page."""
    sweep = missionplan.sweep_dmax(missionplan.load(ROOT / "missions" / "fig8.yaml"))
    with style():
        svg = cost_figure(sweep).svg
    white = '<rect width="100%" height="100%" fill="#ffffff"/>'
    (Path(__file__).parent / "fig8.svg").write_text(re.sub(r"(<svg[^>]*>)", rf"\1{white}", svg, count=1))


if __name__ == "__main__":
    main()
