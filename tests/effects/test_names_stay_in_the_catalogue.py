"""Nothing outside the catalogue knows an effect by its name or its class: all that is asked of it, its entry declares."""

import ast
from pathlib import Path

import pytest

import missionplan
from missionplan.effects import CATALOGUE

PACKAGE = Path(missionplan.__file__).parent
MODULES = {info.effect.__module__ for info in CATALOGUE.values()}
CLASSES = {info.effect.__name__ for info in CATALOGUE.values()}
WORDS = (*CATALOGUE, "missionplan.effects")
"""Where none of them is written, nothing is named or imported: most sources need not be parsed."""


def names_known(source: str) -> list[str]:
    """Effects that a source names or imports, with the line."""
    found: list[str] = []
    if not any(word in source for word in WORDS):
        return found
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and node.value in CATALOGUE:
            found.append(f"line {node.lineno}: {node.value!r}")
        if isinstance(node, ast.Import):
            found += [f"line {node.lineno}: import {a.name}" for a in node.names if a.name in MODULES]
        if isinstance(node, ast.ImportFrom):
            imported = {f"{node.module}.{a.name}" for a in node.names} | {node.module}
            if imported & MODULES or (node.module == "missionplan.effects" and {a.name for a in node.names} & CLASSES):
                found.append(f"line {node.lineno}: from {node.module} import …")
    return found


@pytest.mark.parametrize(
    "source",
    [
        "if name == 'compass-bias':\n    pass",
        "from missionplan.effects.course_and_speed import CompassBias",
        "from missionplan.effects import course_and_speed",
        "import missionplan.effects.tidal_current as tides",
    ],
)
def test_an_effect_that_is_named_or_imported_is_seen(source):
    assert names_known(source)


def test_words_about_an_effect_and_the_catalogue_itself_are_no_names():
    assert not names_known("'a compass-bias of 3°'\nfrom missionplan.effects import CATALOGUE, EffectInfo")
    assert not names_known("from missionplan.effects.oscillation import inertial_frequency")


def test_no_module_outside_the_catalogue_knows_an_effect():
    sources = [path for path in sorted(PACKAGE.rglob("*.py")) if path.parent != PACKAGE / "effects"]
    assert len(sources) > 200
    known = {str(path.relative_to(PACKAGE)): names_known(path.read_text(encoding="utf-8")) for path in sources}
    assert {path: found for path, found in known.items() if found} == {}
