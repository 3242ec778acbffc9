"""Tables of all kinds of data: blanks, marked rows, bad cells, and every problem of a file at once."""

import numpy as np
import pytest

from missionplan.datasets.table import MAX_SHOWN, Columns, read_table
from missionplan.errors import InputError

COLUMNS = Columns(
    (("t_s", "rpm"), ("t_s", "torque")), optional=("run", "speed", "sd"), complete=("speed",), text=("run",)
)


@pytest.fixture
def table(tmp_path):
    """Write a CSV, as text or bytes, and read it."""

    def read(content, columns=COLUMNS):
        path = tmp_path / "rows.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_table(path, columns)

    return read


def problems(found):
    return [str(problem).split("rows.csv")[1] for problem in found.problems]


def refused(excinfo):
    return [str(problem).split("rows.csv")[1] for problem in excinfo.value.problems]


@pytest.mark.parametrize("blank", ["", "  ", "nan", "NaN", "NA"])
def test_a_row_without_a_number_that_it_needs_is_left_out(table, blank):
    found = table(f"t_s,rpm,speed,sd\n1,{blank},1,1\n2,5,{blank},1\n3,5,1,{blank}\n")
    assert found.rows.index.tolist() == [4]
    assert np.isnan(found.rows.at[4, "sd"])
    assert found.notices == ("rows.csv: 2 rows left out without rpm or speed",)
    assert not found.problems


def test_blank_lines_are_no_rows(table):
    found = table("run,t_s,rpm\na,1,2\n\n,,\nb,3,4\n\n")
    assert found.rows.index.tolist() == [2, 5]
    assert found.notices == ()


@pytest.mark.parametrize("zero", ["0", "0.0", " 0 "])
def test_marked_rows_are_left_out_unseen(table, zero):
    found = table(f"t_s,rpm,ok\n1,2,1\n2,bad,{zero}\n3,4,\n4,inf,{zero}\n")
    assert found.rows["t_s"].tolist() == [1.0, 3.0]
    assert list(found.rows) == ["t_s", "rpm"]
    assert not found.problems
    assert found.notices == ("rows.csv: 2 rows left out as marked (ok = 0)",)


@pytest.mark.parametrize("cell", ["abc", "inf", "1e999", "1_000", "0x10", "--", "1 2"])
def test_a_cell_that_holds_no_number_is_named(table, cell):
    found = table(f"t_s,rpm\n1,2\n2,{cell}\n")
    assert problems(found) == [f":3: rpm: given {cell!r}, expected a number"]


def test_of_many_bad_cells_the_first_are_named_and_the_rest_counted(table):
    found = table("t_s,rpm\n" + "1,x\n" * 9)
    assert len(found.problems) == MAX_SHOWN
    assert problems(found)[-1] == ":6: rpm: given 'x', expected a number; 4 more like it"


def test_text_is_kept_as_it_stands(table):
    found = table("run,t_s,rpm\n NA ,1,2\n007,3,4\n,5,6\n")
    assert found.rows["run"].tolist() == ["NA", "007", ""]


def test_header_with_mark_spaces_and_quotes(table):
    found = table('\ufeff t_s , "rpm" ,run\r\n 1 ,"2", "a, b" \r\n')
    assert found.rows.loc[2].tolist() == [1.0, 2.0, "a, b"]


def test_columns_unknown_or_of_another_alternative_are_noted(table):
    found = table("t_s,rpm,torque,note,,\n1,2,3,x,,\n")
    assert found.notices == ("rows.csv: columns not used: torque, note",)


def test_the_alternative_that_is_there_is_read(table):
    assert list(table("t_s,torque,speed\n1,2,3\n").rows) == ["t_s", "torque", "speed"]


def test_a_missing_column_comes_with_its_nearest_and_all_else(table):
    with pytest.raises(InputError) as excinfo:
        table("time,rpms\n1,2\n")
    assert refused(excinfo) == [":1: t_s: the column is missing", ":1: rpm: the column is missing (is it rpms?)"]
    with pytest.raises(InputError) as excinfo:
        table("t,rpm,rpm\n1,x,2\n")
    assert refused(excinfo) == [
        ":1: t_s: the column is missing",
        ":1: rpm: the column stands twice",
        ":2: rpm: given 'x', expected a number",
    ]


def test_a_row_longer_than_the_header_is_a_problem(table):
    found = table("t_s,rpm\n1,2\n0,5,3\n3,4,\n")
    assert [line[:30] for line in problems(found)] == [":3: the row has more cells tha"]


def test_a_short_row_is_blank_at_its_end(table):
    found = table("t_s,rpm,run\n1,2\n3\n")
    assert found.rows.index.tolist() == [2]
    assert found.rows["run"].tolist() == [""]


@pytest.mark.parametrize("content", ["t_s,rpm", "t_s,rpm\n", "t_s,rpm\n\n", "t_s,rpm,ok\n1,2,0\n"])
def test_a_table_without_rows(table, content):
    assert problems(table(content)) == [": has no rows of data"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "is empty"),
        (b"t_s,rpm\n\xff\xfe1,2\n", "not UTF-8"),
        (b"\xff\xfet_s,rpm\n", "not UTF-8"),
        ('t_s,rpm\n1,"2\n', "is not a table: EOF inside string"),
        ("\n1,2\n", "t_s: the column is missing"),
    ],
)
def test_what_is_no_table(table, content, words):
    with pytest.raises(InputError, match=words):
        table(content)


def test_files_that_cannot_be_read(table, tmp_path):
    table("t_s,rpm\n1,2\n")
    with pytest.raises(InputError, match=r"no such file \(did you mean rows.csv\?\)"):
        read_table(tmp_path / "row.csv", COLUMNS)
    with pytest.raises(InputError, match="is a folder"):
        read_table(tmp_path, COLUMNS)
    with pytest.raises(InputError, match="is larger than"):
        read_table(tmp_path / "rows.csv", Columns(COLUMNS.alternatives, max_bytes=5))
