"""Tables of the terminal: nothing is cut, and every line fits."""

import hypothesis.strategies as st
from hypothesis import given

from missionplan.report.render import laid_out

_CELL = st.text("abc1._- ", max_size=20)


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[str], list[list[str]]]:
    width = draw(st.integers(2, 14))
    row = st.lists(_CELL, min_size=width, max_size=width)
    return draw(row), draw(st.lists(row, min_size=1, max_size=4))


@given(tables())
def test_lines_fit_80_columns_and_no_character_is_lost(table: tuple[list[str], list[list[str]]]) -> None:
    columns, rows = table
    lines = laid_out(columns, rows, 80)
    assert all(len(line) <= 80 for line in lines)
    shown = "".join("".join(lines).split())
    for index in range(1, len(columns)):
        for cell in (columns[index], *(row[index] for row in rows)):
            assert all(piece in shown for piece in cell.split())


def test_keys_stay_whole_where_columns_are_many() -> None:
    columns = ["key", *(f"quantity_{number}" for number in range(12))]
    lines = laid_out(columns, [[f"site.current[{row}].speed", *["0.123456"] * 12] for row in range(3)], 80)
    assert all(any(column in line for line in lines) for column in columns)
    assert sum("site.current[2].speed" in line for line in lines) == 3  # in each part
    assert max(map(len, lines)) <= 80


def test_a_long_first_column_is_wrapped_where_people_would() -> None:
    lines = laid_out(["key", "value"], [["navigation.velocity_error.sigma", "1"], ["x", "2"]], 24)
    assert lines == [
        "key                value",
        "navigation.            1",
        "velocity_error.",
        "sigma",
        "x                      2",
    ]
