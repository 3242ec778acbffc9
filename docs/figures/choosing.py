"""Draw the pictures of ``docs/explore.md`` and ``docs/optimise.md``: ``python docs/figures/choosing.py [NAME...]``."""

import re
import sys
import time
from pathlib import Path

import missionplan
from missionplan.report.optimisation import answer, front_figure
from missionplan.report.page import Figure, style
from missionplan.studies.exploration import page as exploration
from missionplan.studies.exploration.figures import curves_figure

ROOT = Path(__file__).parents[2]


def estuary() -> missionplan.Mission:
    """Load the mission through the narrows."""
    return missionplan.load(ROOT / "missions" / "estuary.yaml")


def start() -> Figure | None:
    """Draw what starts give."""
    found = missionplan.explore(estuary(), "start=04:00:14:00:20 min", quantities=["moor.offset"], trials=500)
    print(exploration.answer(found))
    with style():
        return curves_figure(found)


def best() -> Figure | None:
    """Draw what an optimisation tried."""
    choose = ["ingress.speed+egress.speed=0.6:2:0.1 m/s", "ingress.d_max+egress.d_max=200:1600:100 m"]
    mission = missionplan.load(ROOT / "missions" / "chesapeake.yaml")
    found = missionplan.optimise(mission, choose=choose, trials=1000)
    print(answer(found), found.combinations, found.search_trials, found.check_trials, found.relaxation_trials)
    with style():
        return front_figure(found)


PICTURES = {"explore-start": start, "optimise": best}


def main() -> None:
    """Write the pictures, on white so that they are legible on any page."""
    white = '<rect width="100%" height="100%" fill="#ffffff"/>'
    for name in sys.argv[1:] or PICTURES:
        began = time.process_time()
        picture = PICTURES[name]()
        print(f"{name}: {time.process_time() - began:.0f} s of processor time")
        if picture is not None:
            text = re.sub(r"(<svg[^>]*>)", rf"\1{white}", picture.svg, count=1)
            (Path(__file__).parent / f"{name}.svg").write_text(text)


if __name__ == "__main__":
    main()
