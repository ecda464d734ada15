"""Measured records: a column of a CSV file over time or over the angle of a drive."""

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from clearance.files.texts import unpacked_text
from clearance.values.checks import meant
from clearance.values.units import UNITS

HEADING = re.compile(r"^\s*(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?\s*$")
#: units of data beside those of the command line -> (SI unit, factor)
MORE_UNITS = {
    "gn": ("m/s2", 9.80665),
    "mm/s2": ("m/s2", 1e-3),
    "turns": ("rad", 2.0 * math.pi),
    "°": ("rad", math.pi / 180.0),
    **{unit: (unit, 1.0) for unit in ("rad/s2", "m3/s", "m3", "A", "V")},
}
ALL_UNITS = UNITS | MORE_UNITS
#: names of the column that a record runs along, and its SI unit
ALONG = {"time": "s", "t": "s", "angle": "rad", "turns": "rad", "crank angle": "rad"}
FEWEST = 4  # rows of a record


@dataclass(frozen=True)
class Measured:
    """A measured record. along: "time" [s] or "angle" [turns]; values in SI, over `x`.

    path: its file; column: name of the values; units: their SI unit.
    """

    path: Path
    column: str
    units: str
    along: str
    x: np.ndarray
    values: np.ndarray


def read(path: str | Path, column: str | None = None) -> Measured:
    """A record from a CSV file.

    The first row has names with units, as "time [ms], a [m/s2]" or "time_ms, a_m_s2"; commas,
    semicolons or tabs stand between cells; lines that begin with # are passed over. One column is
    time, or the angle of the drive; column: name of the values, where there are several. Units
    become SI ones. The file may be compressed by gzip.
    Raises ValueError, with file and line, for what is no such record.
    """
    path = Path(path)
    lines = unpacked_text(path).splitlines()
    rows = [(i, line) for i, line in enumerate(lines, 1) if line.strip() and line.strip()[0] != "#"]
    if len(rows) <= FEWEST:
        raise ValueError(
            f"{path}: a header and at least {FEWEST} rows are needed, got {len(rows)} lines"
        )
    split = next((s for s in "\t;," if s in rows[0][1]), ",")
    cells = [(i, _cells(path, i, line, split)) for i, line in rows]
    headings = [_heading(path, cells[0][0], cell) for cell in cells[0][1]]
    names = [name for name, _, _ in headings]
    x_at = next((i for i, (n, kind, _) in enumerate(headings) if _along(n, kind)), None)
    if x_at is None:
        raise ValueError(f"{path}: no column is time or angle; columns: {', '.join(names)}")
    y_at = _column(path, names, x_at, column)
    columns = _numbers(path, cells[1:], len(names))
    along = "time" if _along(*headings[x_at][:2]) == "s" else "angle"
    x = columns[:, x_at] * headings[x_at][2] / (1.0 if along == "time" else 2.0 * math.pi)
    if not (np.diff(x) > 0.0).all():
        row = int(np.argmax(np.diff(x) <= 0.0)) + 2
        raise ValueError(f"{path}:{cells[row][0]}: {names[x_at]} must grow from row to row")
    name, units, factor = headings[y_at]
    return Measured(path, name, units, along, x, columns[:, y_at] * factor)


def _cells(path: Path, i: int, line: str, split: str) -> list[str]:
    """Cells of a line. Raises ValueError with its number, such as for an endless cell."""
    try:
        return next(csv.reader([line], delimiter=split))
    except csv.Error as error:
        raise ValueError(f"{path}:{i}: {error}") from None


def _heading(path: Path, line: int, cell: str) -> tuple[str, str, float]:
    """Name, SI unit and factor of a column; the unit is "?" where there is none."""
    match = HEADING.match(cell)
    unit = next((u for u in match.groups()[1:] if u is not None), "").replace(" ", "")
    unit = unit or _ending(match[1])[1]
    if unit in ("", "-", "1"):
        return match[1], "?" if unit == "" else "1", 1.0
    if unit not in ALL_UNITS:
        answer = f"{meant(unit, ALL_UNITS)}; known: {', '.join(ALL_UNITS)}"
        raise ValueError(f"{path}:{line}: column {match[1]!r}: unknown unit {unit!r}{answer}")
    return match[1], *ALL_UNITS[unit]


def _ending(name: str) -> tuple[str, str]:
    """A name without the unit at its end, and that: "crank_angle_deg", "a_m_s2"."""
    parts = name.split("_")
    for first in range(max(len(parts) - 3, 1), len(parts)):
        for mark in ("/", ""):
            if (unit := mark.join(parts[first:])) in ALL_UNITS:
                return "_".join(parts[:first]), unit
    return name, ""


def _along(name: str, units: str) -> str | None:
    """SI unit of the column that a record runs along; None for other columns."""
    expected = ALONG.get(_ending(name)[0].lower().replace("_", " "))
    return expected if expected is not None and units in (expected, "?") else None


def _column(path: Path, names: list[str], x_at: int, column: str | None) -> int:
    """Place of the values. Raises ValueError where that is not clear."""
    others = [i for i in range(len(names)) if i != x_at]
    listed = ", ".join(names[i] for i in others)
    if column is not None:
        if column not in [names[i] for i in others]:
            raise ValueError(f"{path}: no column {column!r}{meant(column, names)}; it has {listed}")
        return names.index(column)
    if len(others) != 1:
        raise ValueError(f"{path}: name one of its columns: {listed or 'none'}")
    return others[0]


def _numbers(path: Path, rows: list[tuple[int, list[str]]], count: int) -> np.ndarray:
    """Rows of a record as numbers; decimal commas are read where they do not part cells."""
    values = np.empty((len(rows), count))
    for row, (line, cells) in zip(values, rows, strict=True):
        try:
            row[:] = [float(cell.strip().replace(",", ".")) for cell in cells]
        except ValueError:
            raise ValueError(f"{path}:{line}: expected {count} numbers, got {cells}") from None
        if not np.isfinite(row).all():
            raise ValueError(f"{path}:{line}: expected finite numbers, got {cells}")
    return values
