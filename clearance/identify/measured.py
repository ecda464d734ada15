"""Measured records: a column of a CSV file over time or over the angle of a drive."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

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
    heads = [Heading.of(cell) for cell in first]
    names = [head.name for head in heads]
    places = [i for i, head in enumerate(heads) if head.runs and head.name != column]
    if not places:
        raise ValueError(
            f"{path}: no column is time or angle, by its name or its unit; columns: "
            f"{', '.join(names)}"
        )
    x_at = next((i for i in places if heads[i].along), places[0])
    y_at = _column(path, heads, x_at, column)
    (kind, factor), (units, size) = (heads[i].si(f"{path}:{line}") for i in (x_at, y_at))
    x, values = _numbers(path, cells, (x_at, y_at)).T
    along = "angle" if "rad" in (kind, heads[x_at].along) else "time"
    x = x * factor / (2.0 * math.pi if along == "angle" else 1.0)
    if along == "angle":
        x = x + np.append(0.0, np.cumsum(np.diff(x) < -0.5))
    if not (np.diff(x) > 0.0).all():
        row = int(np.argmax(np.diff(x) <= 0.0)) + 1
        raise ValueError(f"{path}:{cells[row][0]}: {names[x_at]} must grow from row to row")
    return Measured(path, names[y_at], units, along, x, values * size)


def parts_of(lengths: Iterable[int]) -> list[slice]:
    """Stretches of values of these lengths, one after the other."""
    return [slice(a, b) for a, b in pairwise(np.cumsum([0, *lengths]).tolist())]


def _number(cell: str) -> float | None:
    """The number of a cell, whose decimal comma is read where it does not part cells."""
    try:
        return float(cell.strip().replace(",", "."))
    except ValueError:
        return None


class Heading(NamedTuple):
    """A column: its name, the same without a unit at its end, and the unit, "" where there is none:
    "a [m/s2]", "crank_angle_deg", "a_m_s2".
    """

    name: str
    stem: str
    unit: str

    @classmethod
    def of(cls, cell: str) -> "Heading":
        name, *units = HEADING.match(cell).groups()
        unit = next((plain(u) for u in units if u is not None), "")
        parts = name.split("_")
        for first in range(max(len(parts) - 3, 1), len(parts)):
            for mark in ("/", ""):
                if (ending := plain(mark.join(parts[first:]))) in ALL_UNITS:
                    return cls(name, "_".join(parts[:first]), unit or ending)
        return cls(name, name, unit)

    @property
    def along(self) -> str | None:
        """SI unit of a column that a record runs along by its name; None for others."""
        stem = self.stem
        return ALONG.get(stem.lower().replace("_", " ") if len(stem) > 1 else stem)

    @property
    def runs(self) -> bool:
        """True for a column of time or angle, by its name or its unit."""
        kind = ALL_UNITS.get(self.unit, (self.unit or "?",))[0]
        return kind in (self.along, "?") if self.along else kind in ALONG.values()

    def si(self, where: str) -> tuple[str, float]:
        """SI unit and factor; the unit is "?" where there is none. Raises ValueError."""
        unit = self.unit or (self.stem.lower() if self.along == "rad" else "")
        if unit in ("", "-", "1"):
            return "1" if unit else "?", 1.0
        known(f"{where}: column {self.name!r}: unknown unit", unit, ALL_UNITS)
        return ALL_UNITS[unit]


def _column(path: Path, heads: list[Heading], x_at: int, column: str | None) -> int:
    """Place of the values. Raises ValueError where that is not clear."""
    others = [i for i in range(len(heads)) if i != x_at]
    listed = ", ".join(heads[i].name for i in others)
    if column is not None:
        same = [i for i in others if column in heads[i][:2]]
        if not same:
            names = [head.name for head in heads]
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
