"""Measured records: a column of a CSV file over time or over the angle of a drive."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from clearance.files.texts import unpacked_text
from clearance.identify.csv_rows import ALL_UNITS, number, rows_of
from clearance.values.checks import known, meant
from clearance.values.units import ZEROS, behind, plain

#: names of the column that a record runs along, and its SI unit
ALONG = {"time": "s", "t": "s", "angle": "rad", "turns": "rad", "crank angle": "rad"}
NOT_MEASURED = "?", "N/m"  # N_m is no stiffness
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

    Its header has names with units, as "time [ms], a [m/s2]" or "time_ms, a_m_s2"; see
    identify/csv_rows.py. One column is time, or the angle of the drive: that of such a name, else
    the first one with a unit of them. Angles may begin anew after each turn. column: name of the
    values, where there are several. Units become SI ones. The file may be compressed by gzip.
    Raises ValueError, with file and line, for what is no such record.
    """
    if not isinstance(path, str | Path):
        raise TypeError(f"a record is a CSV file, got {type(path).__name__}; write it into one")
    path = Path(path)
    text = unpacked_text(path)
    try:
        _, (line, *lines), (first, *rows) = rows_of(text, FEWEST + 1)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
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
    x, values = (_numbers(path, names[i], lines, [row[i] for row in rows]) for i in (x_at, y_at))
    along = "angle" if "rad" in (kind, heads[x_at].along) else "time"
    check_varies(f"{path}: column {names[x_at]}", x, heads[x_at].unit)
    x = x * factor / (2.0 * math.pi if along == "angle" else 1.0)
    if along == "angle":
        x = x + np.append(0.0, np.cumsum(np.diff(x) < -0.5))
    if not (np.diff(x) > 0.0).all():
        row = int(np.argmax(np.diff(x) <= 0.0)) + 1
        raise ValueError(f"{path}:{lines[row]}: {names[x_at]} must grow from row to row")
    values = values * size + ZEROS.get(heads[y_at].unit, 0.0)
    return Measured(path, names[y_at], units, along, x, values)


def check_varies(label: str, values: np.ndarray, units: str) -> None:
    """Raise ValueError for values that are all the same, as those of a dead sensor."""
    if not np.ptp(values):
        raise ValueError(f"{label}: {values[0]:g}{behind(units)} in all rows; nothing measured?")


def parts_of(lengths: Iterable[int]) -> list[slice]:
    """Stretches of values of these lengths, one after the other."""
    return [slice(a, b) for a, b in pairwise(np.cumsum([0, *lengths]).tolist())]


class Heading(NamedTuple):
    """A column: its name, the same without a unit at its end, and the unit, "" where there is none:
    "a [m/s2]", "crank_angle_deg", "a_m_s2".
    """

    name: str
    stem: str
    unit: str

    @classmethod
    def of(cls, cell: str) -> "Heading":
        name, _, unit = cell[:-1].rpartition(" [") if cell.endswith("]") else (cell, "", "")
        unit = plain(unit)
        parts = name.split("_")
        for first in range(max(len(parts) - 3, 1), len(parts)):
            for mark in ("/", ""):
                ending = plain(mark.join(parts[first:]))
                if ALL_UNITS.get(ending, NOT_MEASURED)[0] not in NOT_MEASURED:
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


def _numbers(path: Path, name: str, lines: Sequence[int], cells: Sequence[str]) -> np.ndarray:
    """A column as numbers (rows,). Raises ValueError."""
    values = np.array([number(cell) for cell in cells], float)  # None is nan
    bad = ~np.isfinite(values)
    if bad.all():
        raise ValueError(f"{path}: column {name} has no number, such as {cells[0]!r}")
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(f"{path}:{lines[row]}: column {name}: {cells[row]!r} is no finite number")
    return values
