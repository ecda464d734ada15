"""Rows of a benchmark problem: reference values with their errors, and values beside them."""

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files


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
    missing = sum(c.off is None for c in comparisons)
    verdict = f"{inside} of {len(comparisons)} within the errors of their references"
    verdict += f", {missing} missing" * bool(missing)
    return [*lines, f"{verdict}; largest difference {worst:.1e} of a value"]
