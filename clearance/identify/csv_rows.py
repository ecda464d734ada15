"""Rows of CSV files of measurements."""

import csv
from typing import NamedTuple


class Rows(NamedTuple):
    """Comments of a file, lines that begin with #; numbers and cells of its other lines."""

    comments: list[str]
    numbers: list[int]
    cells: list[list[str]]


def rows_of(text: str, fewest: int) -> Rows:
    """The rows of a text. Commas, semicolons or tabs part cells: what its header has.

    Raises ValueError for fewer lines, and naming a line that has no end.
    """
    lines = text.splitlines()
    if any("\0" in line for line in lines):
        raise ValueError("not a text file: it has a NUL character")
    comments = [line for line in lines if line.lstrip().startswith("#")]
    content = [
        (i, line)
        for i, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(content) < fewest:
        raise ValueError(
            f"no table: at least {fewest} lines are needed, a header and rows; got {len(content)}"
        )
    numbers, texts = map(list, zip(*content, strict=True))
    mark = next((m for m in ";\t" if m in texts[0]), ",")
    reader, cells = csv.reader(texts, delimiter=mark), []
    try:
        for row in reader:
            if reader.line_num > len(cells) + 1:
                raise csv.Error
            cells.append(row)
    except csv.Error as error:
        reason = "a quote is not closed" if '"' in texts[len(cells)] else error
        raise ValueError(f"line {numbers[len(cells)]}: {reason}") from None
    return Rows(comments, numbers, cells)
