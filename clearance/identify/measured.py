"""Measured records: a column of a CSV file over time or over the angle of a drive."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from clearance.files.texts import unpacked_text
from clearance.identify.csv_rows import rows_of
from clearance.values.checks import known, meant
from clearance.values.units import UNITS, plain

HEADING = re.compile(r"^\s*(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?\s*$")
#: units of data beside those of the command line -> (SI unit, factor)
MORE_UNITS = {
    "g": ("m/s2", 9.80665),
    **dict.fromkeys(("turns", "rev"), ("rad", 2.0 * math.pi)),
    "deg/s2": ("rad/s2", math.pi / 180.0),
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

    The first row has names with units, as "time [ms], a [m/s2]" or "time_ms, a_m_s2"; units may
    stand in the second row. Commas, semicolons or tabs stand between cells; lines that begin with #
    are passed over. One column is time, or the angle of the drive: that of such a name, else the
    first one with a unit of them. Angles may begin anew after each turn. column: name of the
    values, where there are several. Units become SI ones. The file may be compressed by gzip.
    Raises ValueError, with file and line, for what is no such record.
    """
    path = Path(path)
    text = unpacked_text(path)
    try:
        _, (line, *lines), (first, *rows) = rows_of(text, FEWEST + 1)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    cells = list(zip(lines, rows, strict=True))
    second = cells[0][1]
    if len(second) == len(first) and all(_number(cell) is None for cell in second):
        pairs, cells = zip(first, second, strict=True), cells[1:]
        first = [f"{name} [{unit.strip('[] ')}]" for name, unit in pairs]
    names = [_parts(cell)[0] for cell in first]
    places = [i for i, cell in enumerate(first) if _along(cell) and names[i] != column]
    named = [i for i in places if _named(names[i])]
    if not places:
        raise ValueError(
            f"{path}: no column is time or angle, by its name or its unit; columns: "
            f"{', '.join(names)}"
        )
    x_at = (named or places)[0]
    y_at = _column(path, names, x_at, column)
    (_, kind, factor), (name, units, size) = (_heading(path, line, first[i]) for i in (x_at, y_at))
    x, values = _numbers(path, cells, (x_at, y_at)).T
    along = "angle" if "rad" in (kind, _named(names[x_at])) else "time"
    x = x * factor / (2.0 * math.pi if along == "angle" else 1.0)
    if along == "angle":
        x = x + np.append(0.0, np.cumsum(np.diff(x) < -0.5))
    if not (np.diff(x) > 0.0).all():
        row = int(np.argmax(np.diff(x) <= 0.0)) + 1
        raise ValueError(f"{path}:{cells[row][0]}: {names[x_at]} must grow from row to row")
    return Measured(path, name, units, along, x, values * size)


def parts_of(lengths: Iterable[int]) -> list[slice]:
    """Stretches of values of these lengths, one after the other."""
    return [slice(a, b) for a, b in pairwise(np.cumsum([0, *lengths]).tolist())]


def _number(cell: str) -> float | None:
    """The number of a cell, whose decimal comma is read where it does not part cells."""
    try:
        return float(cell.strip().replace(",", "."))
    except ValueError:
        return None


def _parts(cell: str) -> tuple[str, str]:
    """Name and unit of a column; "" where there is none."""
    match = HEADING.match(cell)
    unit = next((u for u in match.groups()[1:] if u is not None), "")
    return match[1], plain(unit or _ending(match[1])[1])


def _heading(path: Path, line: int, cell: str) -> tuple[str, str, float]:
    """Name, SI unit and factor of a column; the unit is "?" where there is none."""
    name, unit = _parts(cell)
    if unit in ("", "-", "1"):
        return name, "?" if unit == "" else "1", 1.0
    known(f"{path}:{line}: column {name!r}: unknown unit", unit, ALL_UNITS)
    return name, *ALL_UNITS[unit]


def _ending(name: str) -> tuple[str, str]:
    """A name without the unit at its end, and that: "crank_angle_deg", "a_m_s2"."""
    parts = name.split("_")
    for first in range(max(len(parts) - 3, 1), len(parts)):
        for mark in ("/", ""):
            if (unit := plain(mark.join(parts[first:]))) in ALL_UNITS:
                return "_".join(parts[:first]), unit
    return name, ""


def _named(name: str) -> str | None:
    """SI unit of a column that a record runs along by its name; None for others."""
    base = _ending(name)[0]
    return ALONG.get(base.lower().replace("_", " ") if len(base) > 1 else base)


def _along(cell: str) -> bool:
    """True for a column of time or angle, by its name or its unit."""
    name, unit = _parts(cell)
    named, kind = _named(name), ALL_UNITS.get(unit, (unit or "?",))[0]
    return kind in (named, "?") if named else kind in ALONG.values()


def _column(path: Path, names: list[str], x_at: int, column: str | None) -> int:
    """Place of the values. Raises ValueError where that is not clear."""
    others = [i for i in range(len(names)) if i != x_at]
    listed = ", ".join(names[i] for i in others)
    if column is not None:
        same = [i for i in others if column in (names[i], _ending(names[i])[0])]
        if not same:
            raise ValueError(f"{path}: no column {column!r}{meant(column, names)}; it has {listed}")
        return same[0]
    if len(others) != 1:
        raise ValueError(f"{path}: name one of its columns: {listed or 'none'}")
    return others[0]


def _numbers(path: Path, rows: list[tuple[int, list[str]]], places: Sequence[int]) -> np.ndarray:
    """Columns at places as numbers, (rows, columns)."""
    values = np.empty((len(rows), len(places)))
    for row, (line, cells) in zip(values, rows, strict=True):
        numbers = [_number(cells[i]) if i < len(cells) else None for i in places]
        if None in numbers:
            raise ValueError(f"{path}:{line}: expected {len(places)} numbers, got {cells}")
        row[:] = numbers
        if not np.isfinite(row).all():
            raise ValueError(f"{path}:{line}: expected finite numbers, got {cells}")
    return values
