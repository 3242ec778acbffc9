"""Hostile names, put wherever a mission has a name: they would do harm where they served as keys or ids, or unescaped."""

import copy
import itertools
from collections.abc import Iterator, Mapping, Sequence

MARK = "h0stile"
"""Stands in names that try to become a tag or an attribute: nothing of a page may be called so."""
NAMES = (
    # names of sections and of what counts are kept under
    "site", "vehicle", "navigation.velocity_error", "effects", "phases[1]", "monte_carlo", "limit run", "requirement 0",
    "explained:effects[0].one-of 0", "input:speed", "sample/count/names", "start",
    # HTML, SVG, XML
    f"a</script><img src=x onerror={MARK}()>", f"<{MARK}>", f'" onload="{MARK}()', f"' {MARK}='1", f"]]><{MARK}/>", f"--><{MARK}>",
    "&lt;b&gt; &amp; &#x27;", f"</text></svg><{MARK}>", f"</style></title><{MARK}>", 'id="url(#clip)', "#222222",
    # mathtext, TeX, format strings, templates, regular expressions
    "in$^$", "$\\frac{1}$", "a$b", "%s %(x)d {0} {{7*7}}", "\\1\\g<0>\\", "(?P<a>[", "50 % of \\d+",
    # YAML, JSON, CSV, terminals, files, ids
    "a: b # c", "- [x, {y: !!python/name:os.system }]", '{"a": null}', "=1+1", '"quoted", twice', "[bold red]x[/] :warning:",
    "../../etc/passwd", "a/b\\c.svg", "NUL", "Ä\u0308 \u05d0\u05d1 鯨 \U0001f40b", "x" * 300,
)  # fmt: skip
"""What people or attackers may call a mission, a phase, a vehicle, a run or a data set."""
ODD = ("'tis", " led by a space", "tail ", "", "nan", "null", "1e309", "a.b", "a", "x: not arrived", "success", "end")
"""More of them, which look like values, paths or words of the program."""


def named(data: Mapping[str, object], names: Sequence[str]) -> dict[str, object]:
    """Return a mission's data with these names, in turn, for itself, its vehicle and each of its phases."""
    turn = _turns(names)
    found = copy.deepcopy(dict(data)) | {"name": next(turn)}
    if isinstance(found.get("vehicle"), dict):
        found["vehicle"]["name"] = next(turn)
    before: dict[str, str] = {}
    for entry in found["phases"]:
        for kind, section in entry.items():
            old = section.get("name", kind)
            section["name"] = before[old] = next(name for name in turn if name not in before.values())
    for requirement in found.get("requirements", ()):
        phase, _, quantity = requirement["quantity"].rpartition(".")
        requirement["quantity"] = f"{before.get(phase, phase)}.{quantity}"
    return found


def _turns(names: Sequence[str]) -> Iterator[str]:
    """Yield the names, then others made of them: no two phases have one."""
    yield from names
    for number in itertools.count(2):
        yield from (f"{name} {number}" for name in names)
