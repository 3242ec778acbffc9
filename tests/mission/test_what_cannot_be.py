"""The tables of `what_cannot_be.md`: every row says what the tool says."""

import importlib.util
import re
import shutil
from pathlib import Path

import pytest
import yaml
from test_limits import altered

from missionplan import validate
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.studies.data_sets import validated_dataset

ROOT = Path(__file__).parents[2]
_SPEC = importlib.util.spec_from_file_location("silly_datasets", ROOT / "tests" / "datasets" / "silly_datasets.py")
silly_datasets = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(silly_datasets)


def rows(heading):
    """Cells of the rows of the table under a heading."""
    part = re.split(
        r"^## ", Path(__file__).with_name("what_cannot_be.md").read_text(encoding="utf-8"), flags=re.MULTILINE
    )
    text = next(section for section in part if section.startswith(heading))
    found = [re.split(r"(?<!\\) ?\| ?", line)[1:-1] for line in text.splitlines() if line.startswith("| ")]
    return [[cell.replace("\\|", "|") for cell in row] for row in found[1:]]


MISSIONS_OF_THE_PAGE, DATA_SETS = rows("Missions"), rows("Data sets")
FIELDS = rows("Fields of the current")


def test_the_page_has_fifty_rows_and_all_data_sets():
    assert len(MISSIONS_OF_THE_PAGE) >= 50
    assert [row[0] for row in DATA_SETS] == list(silly_datasets.SILLY)


@pytest.mark.parametrize("row", MISSIONS_OF_THE_PAGE, ids=[row[0] for row in MISSIONS_OF_THE_PAGE])
def test_a_mission_of_the_page_is_said_what_stands_there(row):
    changes = {}
    for change in row[0].split("<br>"):
        path, _, value = change.strip("`").partition(": ")
        changes[path] = yaml.safe_load(value)
    now = row[1].removeprefix("notice: ")
    if row[1] == now:
        with pytest.raises(InputError) as refused:
            Mission.from_data(altered(changes))
        assert str(refused.value).splitlines()[0] == now
    else:
        assert now in Mission.from_data(altered(changes)).notices()


@pytest.mark.parametrize("row", FIELDS, ids=[row[0] for row in FIELDS])
def test_a_field_of_the_page_is_said_what_stands_there(row, tmp_path):
    for folder in ("vehicles", "currents"):
        shutil.copytree(ROOT / "missions" / folder, tmp_path / folder)
    path, _, value = row[0].strip("`").partition(": ")
    data = yaml.safe_load((ROOT / "missions" / "estuary.yaml").read_text(encoding="utf-8"))
    place, keys = data, [int(key) if key.isdigit() else key for key in path.split(".")]
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = yaml.safe_load(value)
    (tmp_path / "mission.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    (found,) = validate(tmp_path / "mission.yaml")
    assert [problem.message.replace("\u202f", " ") for problem in found.problems] == [row[1]]


@pytest.mark.parametrize("row", DATA_SETS, ids=[row[0] for row in DATA_SETS])
def test_a_data_set_of_the_page_is_said_what_stands_there(row, tmp_path):
    folder = silly_datasets.write(tmp_path / "data", row[0])
    problems = validated_dataset(folder, ()).problems
    assert "; ".join(str(problem).replace(f"{folder}/", "") for problem in problems) == row[1]
    assert problems
