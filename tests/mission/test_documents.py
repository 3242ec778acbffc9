"""Bounded, marked loading of YAML."""

from pathlib import Path

import pytest
import yaml

from missionplan.errors import InputError, key_path
from missionplan.mission import documents, load
from missionplan.mission.documents import MAX_DEPTH, load_document


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


@pytest.mark.parametrize("loader", [documents._LOADER, yaml.SafeLoader])
@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_deep_nesting_is_refused_before_recursion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, opening: str, loader: object
) -> None:
    """In words of this package, whichever parser PyYAML has and whatever depth that refuses by itself."""
    monkeypatch.setattr(documents, "_LOADER", loader)
    assert f"deeper than {MAX_DEPTH}" in problems_of(tmp_path, opening * 50_000)[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("a: [1, 2\n", "not valid YAML"),
        ("a: !!python/object/apply:os.system [echo]\n", "is not supported"),
        ("a: !!python/name:os.system x\n", "is not supported"),
        ("? [1, 2]\n: 3\n", "plain word"),
        ("a: 2026-13-45\n", "cannot be read"),
        ('a: "\\ud800"\n', "code"),
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


def test_a_file_that_a_mission_names_in_a_folder_that_is_not_there_points_to_the_nearest(tmp_path: Path) -> None:
    write(tmp_path, "name: m\nvehicle: vehicels/fish.yaml\n")
    (tmp_path / "vehicles").mkdir()
    with pytest.raises(InputError, match=r"there is no folder vehicels; did you mean vehicles\?"):
        load(tmp_path / "mission.yaml")


def test_key_paths_read_as_users_write_them() -> None:
    assert key_path(("phases", 0, "transit", "speed")) == "phases[0].transit.speed"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("phases: [{moor: }]\n", "phases[0].moor: given nothing, expected the keys of this phase"),
        ("phases: [{transit: }]\n", "phases[0].transit: given nothing"),
        ("<a: 1\n", "<a: unknown key"),
        ("site: {current: [{down_to: 5 m, <file>: 1}]}\n", "site.current[0].<file>: unknown key"),
        ("site: {depth: {median: 10 m, factor: 1e300}}\n", "site.depth.factor: given '1e300'"),
        ("site: {depth: {median: 10 m, factor: 1.0e+300}}\n", "site.depth.factor: given 1e+300"),
        (
            "site: {depth: {median: 10 m, factor: 1.0e+9}}\n",
            "site.depth.factor: given 1e+09, expected a factor above 1",
        ),
        ("site: {depth: 1e300 m}\n", "given 1e+300 m, expected 0, or from 1e-30 to 1e+31 in size m"),
        ('name: "a\\eb"\n', "name: given 'a\\x1bb', expected text without control characters"),
        ('"a\\eb": 1\n', "holds a control character"),
        ('name: "a\\u202eb"\n', "expected text without control characters"),
        (f"name: {'1:' * 50_000}1\n", "a number of 100001 characters"),
        (f"name: 0x{'f' * 5000}\n", "a number of 5002 characters"),
        ("name: !!bool maybe\n", "'maybe' is no bool"),
        ("name: !!timestamp x\n", "'x' is no timestamp"),
    ],
)
def test_what_once_was_a_traceback_is_said_in_words(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        load(write(tmp_path, text))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "name: [" + "1," * 490_000 + "1]\n",
        "".join(f"key{number}: 1\n" for number in range(80_000)),
        "[" * 500_000,
        "- " * 400_000,
        "a: &x 1\n" + "b: *x\n" * 150_000,
    ],
)
def test_nonsense_is_refused_while_it_is_parsed(tmp_path: Path, text: str) -> None:
    (problem,) = problems_of(tmp_path, text)
    assert "has more than 10000 values" in problem or "is nested deeper" in problem
