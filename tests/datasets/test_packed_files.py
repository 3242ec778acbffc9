"""Compressed tables are read within limits; what is not compressed as its name says is refused in words."""

import bz2
import gzip
import lzma
import zipfile

import pytest

from missionplan.datasets import csv_cells
from missionplan.datasets.table import Columns, read_table
from missionplan.errors import InputError
from missionplan.scenario.currents.reading import read_series_csv

TEXT = b"t_s,depth_m,east_m_s,north_m_s\n0,0,0.1,0.2\n60,0,0.2,0.1\n"
COLUMNS = Columns((("t_s", "depth_m"),))


def packed(path, content=TEXT):
    if path.suffix == ".zip":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("table.csv", content)
        return path
    by_kind = {".gz": gzip.compress, ".bz2": bz2.compress, ".xz": lzma.compress}
    path.write_bytes(by_kind[path.suffix](content))
    return path


@pytest.mark.parametrize("kind", [".gz", ".bz2", ".xz", ".zip"])
class TestKind:
    def test_is_read_like_the_plain_file(self, tmp_path, kind):
        path = packed(tmp_path / f"x.csv{kind}")
        assert read_table(path, COLUMNS).rows["t_s"].tolist() == [0.0, 60.0]
        assert read_series_csv(path).east.tolist() == [[0.1], [0.2]]

    def test_that_is_none_is_refused(self, tmp_path, kind):
        for content in (TEXT, b"", b"\x1f\x8b\x08", packed(tmp_path / f"whole{kind}").read_bytes()[:-9]):
            path = tmp_path / f"x.csv{kind}"
            path.write_bytes(content)
            for read in (lambda path: read_table(path, COLUMNS), read_series_csv):
                with pytest.raises(InputError, match=r"cannot be unpacked|is empty|cannot be read|is missing"):
                    read(path)

    def test_that_unpacks_to_too_much_is_refused(self, tmp_path, kind, monkeypatch):
        monkeypatch.setattr(csv_cells, "MAX_UNPACKED", 1_000_000)
        path = packed(tmp_path / f"x.csv{kind}", TEXT + b"1,0,0,0\n" * 200_000)
        for read in (lambda path: read_table(path, COLUMNS), read_series_csv):
            with pytest.raises(InputError, match="unpacks to more than 1 MB"):
                read(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"t_s,depth_m,east_m_s,north_m_s\n", "has no rows"),
        (b"t_s,t_s,depth_m,east_m_s,north_m_s\n0,0,0,0,0\n", "stands twice"),
        (b"", "is empty"),
        (b"\xff\xfe", "is not UTF-8"),
    ],
)
def test_a_current_file_that_is_none(tmp_path, content, words):
    path = tmp_path / "current.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_series_csv(path)


def test_cells_beyond_the_header_shift_no_column_of_a_current(tmp_path):
    path = tmp_path / "current.csv"
    rows = ["t_s,depth_m,east_m_s,north_m_s", "0,0,0.1,0.05", "600,0,0.2,0.06"]
    path.write_text("\n".join([rows[0], *(f"{row}," for row in rows[1:])]))  # an empty cell is none
    assert read_series_csv(path).east.tolist() == [[0.1], [0.2]]
    path.write_text("\n".join([rows[0], *(row.replace("0.", "0,") for row in rows[1:])]))  # decimal commas
    with pytest.raises(InputError, match="more cells than the header has columns") as caught:
        read_series_csv(path)
    assert [problem.line for problem in caught.value.problems] == [2, 3]
