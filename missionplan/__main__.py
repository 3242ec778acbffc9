"""``python -m missionplan``."""

from missionplan.cli import main

main()
