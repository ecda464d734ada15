"""Rows of a benchmark problem: reference values with their errors, and the answers of any code."""

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from clearance.values.checks import meant
from clearance.values.units import UNITS

DELIMITERS = ";\t|,"  # the first one that a line has
_NUMBER = re.compile(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eEdD][-+]?\d+)?")


@dataclass(frozen=True)
class Row:
    """A reference value, its unit, and the largest error it may have."""

    quantity: str
    unit: str
    value: float
    error: float


@dataclass(frozen=True)
class Comparison:
    """A value beside its reference; value is None where a code has none.

    width: half the 95 % interval of a statistical value.
    """

    row: Row
    value: float | None
    width: float = 0.0

    @property
    def off(self) -> float | None:
        """The value's difference from the reference."""
        return None if self.value is None else self.value - self.row.value

    @property
    def inside(self) -> bool:
        """The value lies within the error of the reference and its own interval."""
        return self.off is not None and abs(self.off) <= self.row.error + self.width


def source(name: str) -> str:
    """The file of a problem's reference values."""
    return files(__package__).joinpath(f"{name}.csv").read_text(encoding="utf-8")


def references(name: str) -> list[Row]:
    """Rows of a problem."""
    lines = (line for line in source(name).splitlines() if not line.startswith("#"))
    return [
        Row(row["quantity"], row["unit"], float(row["value"]), float(row["error"]))
        for row in csv.DictReader(lines)
    ]


def compared(
    rows: Iterable[Row], values: dict[str, float], widths: dict[str, float] | None = None
) -> list[Comparison]:
    """All rows, in their order, with the values of a code and half their intervals."""
    wide = widths or {}
    return [Comparison(r, values.get(r.quantity), wide.get(r.quantity, 0.0)) for r in rows]


def foreign(path: str | Path, rows: Iterable[Row]) -> dict[str, float]:
    """Values of another code from its CSV file, in the units of the rows.

    A line has the name of a quantity, later its value, and anywhere its unit, if that is another
    one. Order, header, case, further columns and lines of remarks are free. So are the delimiter,
    one of comma, semicolon, tab and bar, and decimal commas unless commas delimit.
    Raises ValueError for a file without any quantity, for one that stands twice, has no number, or
    a unit of another kind.
    """
    by_key = {_key(row.quantity): row for row in rows}
    values: dict[str, float] = {}
    strangers: list[str] = []
    text = Path(path).read_text(encoding="utf-8-sig", errors="replace")
    for count, line in enumerate(text.splitlines(), 1):
        cells = _cells(line)
        at, row = next(
            ((i, by_key[k]) for i, k in enumerate(map(_key, cells)) if k in by_key), (0, None)
        )
        if row is None:
            strangers += [cell for cell in cells[:1] if cell and not cell.startswith("#")]
            continue
        if row.quantity in values:
            raise ValueError(f"{path}:{count}: {row.quantity} is there twice")
        try:
            values[row.quantity] = _value(cells[at + 1 :] + cells[:at][::-1], row)
        except ValueError as error:
            raise ValueError(f"{path}:{count}: {row.quantity}: {error}") from None
    if not values:
        names = [row.quantity for row in by_key.values()]
        hint = meant(strangers[-1], names) if strangers else ""
        raise ValueError(
            f"{path}: no line has a quantity of this problem{hint}: {', '.join(names)}"
        )
    return values


def _cells(line: str) -> list[str]:
    delimiter = next((d for d in DELIMITERS if d in line), None)
    if delimiter is None:
        return line.split()
    (cells,) = csv.reader([line], delimiter=delimiter, skipinitialspace=True) if line else ([],)
    return [cell.strip() for cell in cells]


def _key(name: str) -> str:
    """A name without case, brackets of units, and what stands between its words."""
    return re.sub(r"[\W_]+", "", re.sub(r"[\[(].*?[\])]", "", name).lower())


def _value(cells: list[str], row: Row) -> float:
    """The first number, by the unit that stands with it or in a cell of its own."""
    numbers = [cell for cell in cells if _NUMBER.match(cell)]
    if not numbers:
        raise ValueError("no number")
    match = _NUMBER.match(numbers[0])
    assert match
    number = float(match[0].replace(",", ".").replace("d", "e").replace("D", "e"))
    units = [numbers[0][match.end() :], *(cell for cell in cells if cell not in numbers)]
    units = [unit.strip(" []()").replace(" ", "") for unit in units]
    unit = next((unit for unit in units if unit in UNITS), None)
    if unit is None or unit == row.unit.replace(" ", ""):
        return number
    kind, factor = UNITS[unit]
    wanted, size = UNITS.get(row.unit.replace(" ", ""), (row.unit, 1.0))
    if kind != wanted:
        raise ValueError(f"{unit} is no unit of it; {row.unit} is")
    return number * factor / size


def table(comparisons: list[Comparison]) -> list[str]:
    """A line a quantity: value, reference, difference, error of the reference."""
    width = max(len(c.row.quantity) for c in comparisons)
    head = (
        f"{'quantity':{width}}  {'unit':8} {'value':>18} {'reference':>18} {'off':>10} {'error':>8}"
    )
    lines = [head]
    for c in comparisons:
        value, off = ("-", "-") if c.off is None else (f"{c.value:.10g}", f"{c.off:.2e}")
        verdict = "" if c.inside else "  missing" if c.off is None else "  outside"
        lines.append(
            f"{c.row.quantity:{width}}  {c.row.unit:8} {value:>18} {c.row.value:>18.10g} {off:>10} "
            f"{c.row.error:>8.1e}{verdict}"
        )
    inside = sum(c.inside for c in comparisons)
    worst = max(
        (abs(c.off / c.row.value) for c in comparisons if c.off and c.row.value), default=0.0
    )
    verdict = f"{inside} of {len(comparisons)} within the errors of their references"
    return [*lines, f"{verdict}; largest difference {worst:.1e} of a value"]
