"""Tables as plain text that fit a width: words are wrapped, never cut, and columns too many go below the others."""

import re
from collections.abc import Iterator, Sequence

GAP = 2
"""Spaces between columns."""
_LEAST_FIRST = 32
"""Characters that the first column keeps beside several others, where it has them."""
_LONGEST_CELL = 24
"""Characters of a cell that is not broken."""
_SPACES = re.compile(r"(?<= )(?=\S)")
_BREAKS = re.compile(r"(?<=[ _./-])(?=\S)")
"""Where a word may be broken: after a space, an underscore, a full stop, a slash, a hyphen."""


def laid_out(columns: Sequence[str], rows: Sequence[Sequence[str]], width: int = 80) -> list[str]:
    """Lay out a table: its first column to the left, the others to the right.

    Parameters
    ----------
    columns : sequence of str
        Headings.
    rows : sequence of sequence of str
    width : int
        Characters of a line.

    Returns
    -------
    list of str
        Lines. Where the columns do not fit side by side they follow in parts, the first column in each.
    """
    cells = [list(columns), *(list(row) for row in rows)]
    lines: list[str] = []
    for part in _parts(cells, width):
        lines += ["", *part] if lines else part
    return lines


def _parts(cells: list[list[str]], width: int) -> Iterator[list[str]]:
    """Lines of each group of columns that fits."""
    first = [row[0] for row in cells]
    others = [[row[index] for row in cells] for index in range(1, len(cells[0]))]
    while True:
        count = len(others)
        while count > 1 and _comfortable(first) + sum(GAP + _narrow(column) for column in others[:count]) > width:
            count -= 1
        yield _lines(first, others[:count], width)
        others = others[count:]
        if not others:
            return


def _lines(first: list[str], others: list[list[str]], width: int) -> list[str]:
    """Lines of columns that fit side by side; headings are wrapped before the first column is."""
    wide = [max(map(len, column)) for column in others]
    if max(map(len, first)) + sum(wide) + GAP * len(wide) > width:
        wide = [_narrow(column) for column in others]
    room = max(width - sum(wide) - GAP * len(wide), _least(first))
    own = min(max(map(len, first)), room)
    lines: list[str] = []
    for number, head in enumerate(first):
        broken = [wrapped(head, own), *_cells(others, number, wide)]
        height = max(map(len, broken))
        if number == 0:  # headings stand on the line above the rows
            broken = [[""] * (height - len(cell)) + cell for cell in broken]
        for at in range(height):
            texts = [cell[at] if at < len(cell) else "" for cell in broken]
            numbers = (f"{text:>{size + GAP}}" for text, size in zip(texts[1:], wide, strict=True))
            lines.append(f"{texts[0]:<{own}}{''.join(numbers)}".rstrip())
    return lines


def _cells(others: list[list[str]], number: int, sizes: list[int]) -> Iterator[list[str]]:
    """Lines of each cell of a row but the first."""
    for column, size in zip(others, sizes, strict=True):
        yield wrapped(column[number], size, _SPACES)


def _narrow(column: list[str]) -> int:
    """Least width of a column: that of its heading's longest word, and of its cells, long ones broken at spaces."""
    cells = (piece for cell in column[1:] for piece in ([cell] if len(cell) <= _LONGEST_CELL else cell.split(" ")))
    narrow = max((len(piece) for piece in cells), default=0)
    is_long = any(len(cell) > _LONGEST_CELL for cell in column[1:])
    return max(narrow, *map(len, column[0].split(" ")), _LONGEST_CELL if is_long else 1)


def _least(first: list[str]) -> int:
    """Least width of the first column: of its longest piece."""
    return max((len(piece.rstrip()) for cell in first for piece in _BREAKS.split(cell)), default=0)


def _comfortable(first: list[str]) -> int:
    return max(_least(first), min(_LEAST_FIRST, max(map(len, first))))


def wrapped(text: str, width: int, breaks: re.Pattern[str] = _BREAKS) -> list[str]:
    """Break a text into lines, by default at its spaces, underscores, full stops and slashes; pieces stay whole."""
    lines = [""]
    for piece in breaks.split(text):
        if lines[-1] and len((lines[-1] + piece).rstrip()) > width:
            lines[-1] = lines[-1].rstrip()
            lines.append(piece)
        else:
            lines[-1] += piece
    return lines
