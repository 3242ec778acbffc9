"""Run the command blocks of README and docs that are marked to run, in a copy of the missions, as they are printed.

A block runs whose fence follows ``<!-- runs -->``, or ``<!-- runs: exit 0 3 -->`` with the exit codes that may come.
Blocks of a page run one after the other in one shell, so that `cd` carries over. Where a block shows what is printed
(lines with ``$`` are then the commands), every line shown must be among what is printed; ``...`` stands for anything.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"<!-- runs(?:: exit ([\d ]+))? -->\n```\w*\n(.*?)```", re.DOTALL)
END = "==== end of block"


def blocks(page: Path) -> list[tuple[str, list[str], set[int]]]:
    """Commands, lines shown and exit codes of each block of a page."""
    found = []
    for codes, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        lines = text.splitlines()
        shows = any(line.startswith("$ ") for line in lines)
        commands = [line[2:] for line in lines if line.startswith("$ ")] if shows else lines
        shown = [line for line in lines if not line.startswith("$ ")] if shows else []
        found.append(("\n".join(commands), shown, {int(code) for code in codes.split()} or {0}))
    return found


def run(page: Path, missions: Path) -> list[str]:
    """Run a page's blocks; return what went wrong."""
    found = blocks(page)
    if not found:
        return []
    problems = []
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(missions, Path(folder) / "missions")
        script = "".join(f"{commands}\necho '{END}' $?\n" for commands, _, _ in found)
        done = subprocess.run(["bash"], input=script, cwd=folder, text=True, capture_output=True, check=False)
    parts = re.split(rf"{END} (\d+)\n", done.stdout)
    for (commands, shown, codes), output, code in zip(found, parts[::2], parts[1::2], strict=False):
        if int(code) not in codes:
            problems.append(f"{page.name}: exit {code} of\n{commands}\n{done.stderr[-2000:]}")
        printed = _words(output)
        missing = [line for line in shown if any(_words(part) not in printed for part in line.split("..."))]
        problems += [f"{page.name}: is not printed: {line}" for line in missing]
    return problems


def _words(text: str) -> str:
    return " ".join(text.split())


def main() -> int:
    """Run all pages, or those named."""
    pages = [Path(each) for each in sys.argv[1:]] or [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    problems = [problem for page in pages for problem in run(page, ROOT / "missions")]
    print("\n".join(problems) or f"{sum(len(blocks(page)) for page in pages)} blocks ran as printed")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())
