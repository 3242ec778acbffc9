"""Bounded, marked loading of YAML."""

from pathlib import Path

import pytest

from missionplan.errors import InputError, key_path
from missionplan.mission.reading.documents import MAX_DEPTH, load_document


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mission.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def problems_of(tmp_path: Path, text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        load_document(write(tmp_path, text), "mission.yaml")
    return [str(problem) for problem in caught.value.problems]


def test_marks_carry_the_line_of_each_key(tmp_path: Path) -> None:
    document = load_document(write(tmp_path, "a: 1\nb:\n  - c: 2\n    d: 3\n"))
    assert document.data == {"a": 1, "b": [{"c": 2, "d": 3}]}
    assert document.mark(("b", 0, "d"))[1] == 4
    assert document.mark(("b", 0, "missing"))[1] == 3


def test_duplicate_keys_are_all_reported(tmp_path: Path) -> None:
    found = problems_of(tmp_path, "a: 1\na: 2\nb: {c: 1, c: 2}\n")
    assert found == [
        "mission.yaml:2: a: duplicate key; first on line 1",
        "mission.yaml:3: b.c: duplicate key; first on line 3",
    ]


def test_aliases_that_explode_are_refused_quickly(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 10)]
    assert "aliases" in problems_of(tmp_path, "\n".join(lines))[0]


def test_an_alias_of_itself_is_refused(tmp_path: Path) -> None:
    assert "expands" in problems_of(tmp_path, "a: &a [*a]\n")[0]


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_deep_nesting_is_refused_before_recursion(tmp_path: Path, opening: str) -> None:
    assert f"deeper than {MAX_DEPTH}" in problems_of(tmp_path, opening * 50_000)[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("a: [1, 2\n", "not valid YAML"),
        ("a: !!python/object/apply:os.system [echo]\n", "is not supported"),
        ("a: !!python/name:os.system x\n", "could not determine a constructor"),
        ("? [1, 2]\n: 3\n", "plain word"),
        ("a: 2026-13-45\n", "cannot be read"),
        ('a: "\\ud800"\n', "cannot be read"),
        ("a: 1\n---\nb: 2\n", "not valid YAML"),
    ],
)
def test_bad_syntax_is_said_in_words(tmp_path: Path, text: str, words: str) -> None:
    assert words in problems_of(tmp_path, text)[0]


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "mission.yaml").write_bytes(b"a: \xff\xfe\n")
    (tmp_path / "sea-trial").mkdir()
    for name, words in [
        ("mission.yaml", "not UTF-8"),
        ("mision.yaml", "did you mean mission.yaml?"),
        ("sea-trail/dataset.yaml", "there is no folder .*sea-trail; did you mean sea-trial?"),
        ("elsewhere/below/dataset.yaml", r"there is no folder .*elsewhere\)"),
        (".", "is a folder"),
    ]:
        with pytest.raises(InputError, match=words.replace("?", r"\?")):
            load_document(tmp_path / name)
    write(tmp_path, "# " + "x" * 1_100_000)
    with pytest.raises(InputError, match="larger than 1 MB"):
        load_document(tmp_path / "mission.yaml")


def test_key_paths_read_as_users_write_them() -> None:
    assert key_path(("phases", 0, "transit", "speed")) == "phases[0].transit.speed"
