"""Draw the pictures of README, home and tutorials: ``python docs/figures/tutorials.py [FOLDER]``.

Runs the commands that the pages print, in FOLDER or a temporary one, and copies figures of their reports, on white so
that they are legible on any page.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
MISSIONS = HERE.parent.parent / "missions"
WHITE = '<rect width="100%" height="100%" fill="#ffffff"/>'

COMMANDS = {
    "plan": "simulate trial/mission.yaml --trials 4000",
    "legs": "sweep-dmax trial/mission.yaml --trials 1000",
    "anchor": "size-anchor trial/mission.yaml --trials 1000",
    "line": "explore trial/mission.yaml --vary moor.line_length=3:7:1m --trials 400",
    "windows": f"explore {MISSIONS / 'estuary.yaml'} --vary start=08:00:14:00:20min --trials 400",
    "diagnosis": "diagnose trial/mission.yaml trial/sea-trial",
}
FIGURES = {
    "plan-track-map": "plan/mission",
    "plan-waterfall": "plan/waterfall",
    "legs-cost": "legs/cost",
    "anchor-drawing": "anchor/anchor",
    "anchor-descent": "anchor/descent",
    "line-curves": "line/explore",
    "windows-curves": "windows/explore",
    "diagnosis-data": "diagnosis/data",
    "diagnosis-ranking": "diagnosis/ranking",
}


def main(folder: Path) -> None:
    """Run the commands, and copy the figures beside this file."""
    subprocess.run(["missionplan", "init", "trial"], cwd=folder, check=True)
    for name, command in COMMANDS.items():
        done = subprocess.run(["missionplan", *command.split(), "--out", name], cwd=folder, check=False)
        if done.returncode not in (0, 3):  # 3: a requirement is not met
            sys.exit(done.returncode)
    for name, figure in FIGURES.items():
        report, _, stem = figure.partition("/")
        svg = (folder / report / "figures" / f"{stem}.svg").read_text(encoding="utf-8")
        (HERE / f"tutorial-{name}.svg").write_text(
            re.sub(r"(<svg[^>]*>)", rf"\1{WHITE}", svg, count=1), encoding="utf-8"
        )


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(Path(temporary))
