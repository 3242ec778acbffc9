"""Print the lowest versions that pyproject.toml allows, one requirement a line, extras of its own included."""

import re
import sys
import tomllib
from pathlib import Path


def lowest(requirements: list[str], extras: dict[str, list[str]]) -> list[str]:
    """Turn ``name>=version`` into ``name==version``, and ``missionplan[extra]`` into what the extra asks for."""
    pinned = []
    for requirement in requirements:
        own = re.fullmatch(r"missionplan\[([\w,-]+)\]", requirement)
        if own:
            for extra in own[1].split(","):
                pinned += lowest(extras[extra], extras)
        else:
            pinned.append(requirement.replace(">=", "=="))
    return pinned


if __name__ == "__main__":
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *(line for extra in sys.argv[1:] for line in extras[extra])]
    print("\n".join(lowest(wanted, extras)))
