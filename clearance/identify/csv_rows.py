"""Rows of CSV files of measurements.

The header is the first line of names with rows of numbers below, none of them longer. What an
instrument writes above is passed over. Units may stand in a row of their own below. A header behind
a # counts where there is no other. Semicolons, tabs or commas part cells: those of the longer
table. Empty cells at the end of a line are none.
"""

import csv
import math
import re
from collections.abc import Sequence
from itertools import takewhile

from clearance.values.units import UNITS, plain

#: units of data beside those of the command line -> (SI unit, factor)
MORE_UNITS = {
    "g": ("m/s2", 9.80665),
    **dict.fromkeys(("turns", "rev"), ("rad", 2.0 * math.pi)),
    "deg/s2": ("rad/s2", math.pi / 180.0),
    **{unit: (unit, 1.0) for unit in ("rad/s2", "m3/s", "m3", "A", "V")},
}
ALL_UNITS = UNITS | MORE_UNITS
UNIT = re.compile(r"\s*[\[(]([^\[\]()]*)[\])]$")  # at the end of a name
MARKS = ";\t,"  # between cells
SEEN = 20  # lines below a header that show which it is
NUMBERS = 2  # of a row there, at least
DEEPEST = 1000  # lines among which a header is looked for

Line = tuple[int, str]  # number and text


def rows_of(text: str, fewest: int) -> tuple[list[str], list[int], list[list[str]]]:
    """Comments of a text without #; numbers and cells of the lines of header and rows.

    All have as many cells, and names their units in brackets.

    Raises ValueError for fewer lines, for no header, and naming a line that has no end or too many
    cells.
    """
    if "\0" in text:
        raise ValueError("not a text file: it has a NUL character")
    notes, content = [], []
    for i, line in enumerate(text.splitlines(), 1):
        if line.strip(MARKS + " "):
            (notes if line.lstrip().startswith("#") else content).append((i, line.lstrip(" #")))
    above, first = [n for n in notes if [n] < content][-1:], "".join(t for _, t in content[:1])
    usual = content, next((m for m in MARKS if m in first), MARKS[-1])
    table, mark = _table(content) or _table(above + content) or usual
    cells = _parsed(table, mark)
    cells[:1] = [[UNIT.sub(r" [\1]", name.strip()) for name in row] for row in cells[:1]]
    if len(cells) > 1 and _units(cells[1], cells[0]):
        del table[1]
        for k, cell in enumerate(cells.pop(1)):
            if unit := cell.strip("[]() "):
                cells[0][k] += f" [{unit}]"
    if len(cells) < fewest:
        raise ValueError(
            f"no table: at least {fewest} lines are needed, a header and rows; got {len(cells)}"
        )
    if not _names(cells[0]):
        raise ValueError("no header: a line above the rows needs a name for each of their columns")
    for (i, _), row in zip(table, cells, strict=True):
        if (more := len(row) - len(cells[0])) > 0:
            hint = "; decimal commas need semicolons or tabs between cells" * (mark == ",")
            raise ValueError(f"line {i}: {len(row)} cells under a header of {len(cells[0])}{hint}")
        row += [""] * -more
    return [note for _, note in notes], [i for i, _ in table], cells


def number(cell: str) -> float | None:
    """The number of a cell, whose decimal comma is read where it does not part cells."""
    try:
        return float(cell.strip().replace(",", "."))
    except ValueError:
        return None


def _table(lines: Sequence[Line]) -> tuple[Sequence[Line], str] | None:
    """Lines from the header on, and what parts their cells; None where none is a header."""
    most, table = 0, None
    for mark in MARKS:
        top = lines[: DEEPEST + SEEN]
        rows = [_parsed([line], mark)[0] if mark in line[1] else [] for line in top]
        for i in range(len(rows)):
            if (count := _below(rows[i : i + SEEN + 1])) > most:
                most, table = count, (lines[i:], mark)
            if most == SEEN:
                return table
    return table


def _below(rows: Sequence[list[str]]) -> int:
    """Rows of numbers below the first one, if that is a header; units count as one."""
    head, *below = rows
    if not _names(head):
        return 0
    units = bool(below) and _units(below[0], head)
    filled = takewhile(_numeric, below[units:])
    count = sum(_numeric(row) >= NUMBERS and len(row) <= len(head) for row in filled)
    return count and count + units


def _names(row: Sequence[str]) -> bool:
    """True for names of several columns."""
    return len(row) >= NUMBERS and not _numeric(row)


def _units(row: Sequence[str], head: Sequence[str]) -> bool:
    """True for units of columns with names, most of which are there."""
    stated = sum(plain(cell.strip("[]() ")) in ALL_UNITS for cell in row)
    some = 0 < len(row) - row.count("-") <= 2 * stated
    return len(row) <= len(head) and not _numeric(row) and some


def _numeric(row: Sequence[str]) -> int:
    """Number of cells that are numbers."""
    return sum(number(cell) is not None for cell in row)


def _parsed(lines: Sequence[Line], mark: str) -> list[list[str]]:
    """Cells of lines. Raises ValueError naming a line that has no end."""
    texts, cells = (text for _, text in lines), []
    reader = csv.reader(texts, delimiter=mark, skipinitialspace=mark != "\t")
    try:
        for row in reader:
            if reader.line_num > len(cells) + 1:
                raise csv.Error
            while row and not row[-1].strip():
                row.pop()
            cells.append(row)
    except csv.Error as error:
        i, text = lines[len(cells)]
        reason = "a quote is not closed" if '"' in text else error
        raise ValueError(f"line {i}: {reason}") from None
    return cells
