"""Run the blocks of README, docs and examples as they are printed, each page in a folder of its own.

The folder holds what a reader has: the starter files, and copies of `missions` and `examples`. A comment on the line
before a block says what becomes of it, and a block without one is an error, so that none is forgotten:

``<!-- runs -->``
    Commands, one a line, or Python. Where commands follow ``$``, the other lines are what each prints: it must come in
    this order, blanks and line breaks aside; ``...`` stands for anything. Commands may begin and end with other output.
``<!-- runs: exit 0 3 -->``
    The same, with the exit statuses that may come.
``<!-- runs with --trials 100 -->``
    The same, with an option added to each command, where a reader's computer takes minutes.
``<!-- in FILE -->``, ``<!-- in FILE: site.current -->``
    YAML that a mission file may hold (there): `missionplan validate` takes that file with it, then named with-FILE.
``<!-- from FILE -->``
    The text stands in that file, which a block before has made or the project has; ``...`` stands for anything.
``<!-- file NAME -->``
    Written to that file, for the blocks that follow.
``<!-- not run: reason -->``
    Left alone.
``<!-- run command -->``, ``<!-- test command -->``
    Run by `.ci/run`.

``<!-- set up: commands -->``, on as many lines as it takes, runs commands that the page does not show; `$PROJECT` is
the project's folder for them.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
STEP = re.compile(
    r"^<!-- set up:\s*(?P<set_up>.*?)-->"
    r"|^(?:<!-- (?P<mark>[^\n]*?) -->\n)?(?P<fence>```|~~~)(?P<language>\w*)\n(?P<text>.*?)^(?P=fence)$",
    re.DOTALL | re.MULTILINE,
)
MARKS = re.compile(
    r"(?P<kind>runs|in|from|file|not run|run command|test command)"
    r"(?:(?: with (?P<option>--.+?))?(?:: exit (?P<codes>[\d ]+))?|:? (?P<rest>.+))"
)
ANYTHING = re.compile(r"\.\.\.|…")
WORKERS = 2


@dataclass(frozen=True)
class Block:
    """One block of a page: how it is marked, and what it holds."""

    kind: str  # of `MARKS`, or "set up"
    text: str
    line: int
    language: str = ""
    rest: str = ""  # file, key or reason
    codes: frozenset[int] = frozenset({0})
    option: str = ""  # added to each command

    def commands(self) -> list[tuple[str, str]]:
        """Return each command with what the page shows of its output."""
        lines = self.text.replace("\\\n", "").splitlines()
        shows = any(line.startswith("$ ") for line in lines)
        found: list[tuple[str, str]] = []
        for line in lines:
            if line.startswith("$ ") or (line.strip() and not shows):
                command = line.removeprefix("$ ").partition("  #")[0]
                found.append((f"{command.rstrip()} {self.option}".rstrip(), ""))
            elif found:
                found[-1] = (found[-1][0], f"{found[-1][1]}{line}\n")
        return found


@dataclass
class Reader:
    """Somebody who follows a page in a shell: files, folder and variables stay from one command to the next."""

    home: Path
    state: Path = field(init=False)

    def __post_init__(self) -> None:
        self.state = self.home.parent / f"{self.home.name}.state"
        self.state.write_text(f"cd {self.home}\n", encoding="utf-8")

    def run(self, command: str) -> tuple[int, str]:
        """Return the exit status of a command and all that it prints."""
        script = (
            f'. {self.state}\n{command}\ncode=$?\n{{ export -p; printf "cd %q\\n" "$PWD"; }} >{self.state}\nexit $code'
        )
        paths = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        done = subprocess.run(
            ["bash", "-c", script],
            env={"MPLBACKEND": "Agg", **os.environ, "COLUMNS": "80", "PATH": paths, "PROJECT": str(ROOT)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout

    def path(self, name: str) -> Path:
        """Return a file as the reader would name it."""
        return Path(self.run("pwd")[1].strip()) / name


def blocks(text: str) -> Iterator[Block]:
    """Yield the blocks of a page in order; the kind of one without a known mark is empty."""
    for found in STEP.finditer(text):
        line = text.count("\n", 0, found.start()) + 1
        if found["set_up"] is not None:
            yield Block("set up", found["set_up"], line)
            continue
        mark = MARKS.fullmatch(found["mark"] or "")
        known = mark is not None and (mark["kind"] not in ("in", "from", "file", "not run") or bool(mark["rest"]))
        yield Block(
            kind=mark["kind"] if mark and known else "",
            text=found["text"],
            line=line,
            language=found["language"],
            rest=(mark["rest"] or "") if mark else "",
            codes=frozenset(int(code) for code in mark["codes"].split()) if mark and mark["codes"] else frozenset({0}),
            option=(mark["option"] or "") if mark else "",
        )


def problems_of(text: str, reader: Reader) -> list[str]:
    """Follow a page; return what is not as it says, by line."""
    found = []
    for block in blocks(text):
        found += [f"{block.line}: {problem}" for problem in _problems_of_block(block, reader)]
    return found


def _problems_of_block(block: Block, reader: Reader) -> list[str]:
    match block.kind:
        case "":
            return ["a block without a mark: say that it runs, or why it does not"]
        case "not run" | "run command" | "test command":
            return []
        case "file":
            reader.path(block.rest).parent.mkdir(parents=True, exist_ok=True)
            reader.path(block.rest).write_text(block.text, encoding="utf-8")
            return []
        case "from":
            path = reader.path(block.rest)
            shown = _first_not_shown(block.text, path.read_text(encoding="utf-8") if path.is_file() else "")
            return [f"{block.rest} does not hold: {shown}"] if shown else []
        case "set up":
            return _problems_of_command(f"set -e\n{block.text}\nset +e", "", block.codes, reader)
        case "in":
            return _problems_of_fragment(block, reader)
        case _ if block.language == "python":
            script = reader.home.parent / f"{reader.home.name}.py"
            script.write_text(block.text, encoding="utf-8")
            return _problems_of_command(f"python {script}", "", block.codes, reader)
    return [
        problem
        for command, shown in block.commands()
        for problem in _problems_of_command(command, shown, block.codes, reader)
    ]


def _problems_of_command(command: str, shown: str, codes: frozenset[int], reader: Reader) -> list[str]:
    code, printed = reader.run(command)
    if code not in codes:
        return [f"exit status {code} of: {command}\n{printed[-2000:]}"]
    missing = _first_not_shown(shown, printed)
    return [f"{command}\nis said to print: {missing}\nand prints:\n{printed}"] if missing else []


def _first_not_shown(shown: str, printed: str) -> str:
    """Return the first line of what is shown that is not printed after those before it, if any."""
    lines = shown.splitlines()
    for count in range(1, len(lines) + 1):
        if not re.search(_pattern("\n".join(lines[:count])), printed, re.DOTALL):
            return lines[count - 1]
    return ""


def _pattern(shown: str) -> str:
    """Regular expression of a text whose blanks and line breaks may be others, and whose `...` stand for anything."""
    parts = [r"\s+".join(re.escape(word) for word in part.split()) for part in ANYTHING.split(shown)]
    return r"(?<!\S)" + r".*?".join(rf"\s*{part}\s*" for part in parts) + r"(?!\S)"


def _problems_of_fragment(block: Block, reader: Reader) -> list[str]:
    """Put YAML into a mission file, and ask `validate` what it thinks of the whole."""
    name, _, key = (part.strip() for part in block.rest.partition(":"))
    base = reader.path(name)
    whole, part = yaml.compose(base.read_text(encoding="utf-8")), yaml.compose(block.text)
    for each in reversed(key.split(".") if key else []):
        part = yaml.MappingNode("tag:yaml.org,2002:map", [(yaml.ScalarNode("tag:yaml.org,2002:str", each), part)])
    made = base.with_name(f"with-{base.name}")
    made.write_text(yaml.serialize(merged(whole, part, base.parent)), encoding="utf-8")
    return _problems_of_command(f"missionplan validate {made}", "", block.codes, reader)


def merged(whole: yaml.Node, part: yaml.Node, folder: Path) -> yaml.Node:
    """Return YAML with keys of another put in; phases are matched by kind, a file named in place of keys is read."""
    if isinstance(whole, yaml.ScalarNode) and isinstance(part, yaml.MappingNode) and (folder / whole.value).is_file():
        return merged(yaml.compose((folder / whole.value).read_text(encoding="utf-8")), part, folder)
    if isinstance(whole, yaml.MappingNode) and isinstance(part, yaml.MappingNode):
        pairs = {key.value: (key, value) for key, value in whole.value}
        for key, value in part.value:
            pairs[key.value] = (key, merged(pairs[key.value][1], value, folder) if key.value in pairs else value)
        return yaml.MappingNode(whole.tag, list(pairs.values()))
    if isinstance(whole, yaml.SequenceNode) and isinstance(part, yaml.SequenceNode):
        given = {_only_key(each): each for each in part.value}
        kinds = {_only_key(each) for each in whole.value}
        if None not in given and set(given) <= kinds:
            put_in = [merged(each, given.get(_only_key(each), each), folder) for each in whole.value]
            return yaml.SequenceNode(whole.tag, put_in)
    return part


def _only_key(node: yaml.Node) -> str | None:
    """Key of a mapping with one entry, as a phase is."""
    return node.value[0][0].value if isinstance(node, yaml.MappingNode) and len(node.value) == 1 else None


def _follow(page: Path, starter: Path) -> tuple[Path, list[str], float]:
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder) / "here"
        shutil.copytree(starter, home)
        return page, problems_of(page.read_text(encoding="utf-8"), Reader(home)), time.monotonic() - began


def main() -> int:
    """Run all pages, or those named."""
    everything = [
        ROOT / "README.md",
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("examples/**/*.md"),
        ROOT / "CONTRIBUTING.md",
    ]
    pages = [Path(each).resolve() for each in sys.argv[1:]] or everything
    pages = [page for page in pages if any(blocks(page.read_text(encoding="utf-8")))]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(WORKERS) as pool:
        starter = Path(folder) / "starter"
        subprocess.run(
            [str(Path(sys.executable).parent / "missionplan"), "init", str(starter)],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        for name in ("missions", "examples"):
            shutil.copytree(ROOT / name, starter / name)
        pages.sort(key=lambda page: -page.read_text(encoding="utf-8").count("<!-- runs"))
        followed = list(pool.map(lambda page: _follow(page, starter), pages))
    for page, problems, seconds in followed:
        print(f"{page.relative_to(ROOT)}: {len(problems) or 'no'} problems, {seconds:.0f} s")
        print("".join(f"{page.relative_to(ROOT)}:{problem}\n" for problem in problems), end="")
    return any(problems for _, problems, _ in followed)


if __name__ == "__main__":
    sys.exit(main())
