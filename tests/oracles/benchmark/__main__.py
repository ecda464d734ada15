"""Makes the reference values of the benchmark set, and the tables of its pages, again:
`python -m tests.oracles.benchmark [NAME ...]`.

A value is that of the package at `TIGHT`, or of the second method where that is nearer to the
exact one (`BEST` of its module). The error is twice the largest difference from the package at its
default tolerance and from the second method; where the second method is best, from its coarser
answer. Rows that begin with `SHARED` have one error a unit. `MARGIN` of its module replaces the
factor of two for some rows. No error is below `LEAST` of the value. Statistics have half their
95 % interval.
"""

import dataclasses
import importlib
import math
import sys
from pathlib import Path

from clearance.studies.benchmark import problems
from clearance.studies.benchmark.rows import Row, references

ROOT = Path(__file__).parents[3]
FILES, PAGES = ROOT / "clearance/studies/benchmark", ROOT / "docs/benchmark"
TIGHT, LEAST = 1e-12, 1e-9
MARKS = "<!-- rows -->", "<!-- rows:end -->"
#: units by the last or the first words of a quantity
UNITS = {
    **dict.fromkeys(("time", "end", "period"), "s"),
    **dict.fromkeys(("depth", "x", "y", "offset", "film"), "m"),
    **dict.fromkeys(("angle", "tilt", "lead", "attitude"), "rad"),
    **dict.fromkeys(("torque",), "N m"),
    **dict.fromkeys(("force",), "N"),
    **dict.fromkeys(("energy",), "J"),
    "speed": "m/s",
    "crank_speed": "rad/s",
    "slider_acceleration": "m/s2",
}


def unit(quantity: str, more: dict) -> str:
    """Unit of a quantity: of its longest words that are known."""
    words = quantity.split("_")
    spans = [(i, j) for i in range(len(words)) for j in range(i + 1, len(words) + 1)]
    for i, j in sorted(spans, key=lambda span: (span[0] - span[1], -span[1])):
        if (name := "_".join(words[i:j])) in more | UNITS:
            return (UNITS | more)[name]
    return "1"


def rows(name: str) -> tuple[list[Row], str]:
    """Reference values of a problem, and the words of their methods."""
    oracle = importlib.import_module(f"tests.oracles.benchmark.{name}")
    values = problems.PROBLEMS[name].values
    work = problems.Work(TIGHT)
    tight, usual = values(work), values(problems.Work())
    second, best, items = oracle.solve(), getattr(oracle, "BEST", ()), []
    coarse = oracle.coarser() if best else {}
    margins = getattr(oracle, "MARGIN", {})
    for quantity, value in tight.items():
        off = [usual[quantity] - value, second[quantity] - value]
        if quantity.startswith(best or ("-",)):
            value, off = second[quantity], [coarse[quantity] - second[quantity]]
        factor = next((f for begin, f in margins.items() if quantity.startswith(begin)), 2.0)
        error = max(factor * max(map(abs, off)), LEAST * abs(value))
        error = work.widths.get(quantity, error)
        items.append(
            Row(quantity, unit(quantity, getattr(oracle, "UNITS", {})), value, upward(error))
        )
    shared = getattr(oracle, "SHARED", ())
    for i, row in enumerate(items):
        if row.quantity.startswith(shared):
            beside = (
                r.error for r in items if r.unit == row.unit and r.quantity.startswith(shared)
            )
            items[i] = dataclasses.replace(row, error=max(beside))
    return items, " ".join(oracle.__doc__.split())


def upward(error: float) -> float:
    """Two digits, rounded up."""
    power = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(error / power) * power:.1e}")


def written(name: str, items: list[Row], method: str) -> None:
    """The file, and the table of the page."""
    head = f"# {name}: reference values; second method: {method}\n"
    lines = [f"{r.quantity},{r.unit},{r.value:.12g},{r.error:.1e}\n" for r in items]
    (FILES / f"{name}.csv").write_text(head + "quantity,unit,value,error\n" + "".join(lines))
    page = PAGES / f"{name}.md"
    if page.exists():
        before, _, rest = page.read_text().partition(MARKS[0])
        after = rest.partition(MARKS[1])[2]
        page.write_text(before + "\n".join([MARKS[0], "", *table(items), "", MARKS[1]]) + after)


def table(items: list[Row]) -> list[str]:
    """The rows in Markdown, with the digits that are sure."""
    lines = ["| quantity | unit | value | error |", "|---|---|---|---|"]
    for r in items:
        digits = max(2, 2 + math.ceil(math.log10(abs(r.value) / r.error))) if r.value else 2
        lines.append(
            f"| `{r.quantity}` | {r.unit} | {r.value:#.{min(digits, 12)}g} | {r.error:.1e} |"
        )
    return lines


if __name__ == "__main__":
    for asked in sys.argv[1:] or problems.PROBLEMS:
        written(asked, *rows(asked))
        shares = [r.error / abs(r.value) for r in references(asked) if r.value]
        print(f"{asked}: {len(shares)} rows, errors up to {max(shares):.1e} of a value")
