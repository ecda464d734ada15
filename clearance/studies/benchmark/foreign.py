"""Values of another code from its CSV file, in the units of the rows of a problem."""

import csv
import re
from collections.abc import Container, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from clearance.studies.benchmark.rows import Row
from clearance.values.checks import meant
from clearance.values.units import UNITS

DELIMITERS = ";\t|,"  # the first one that a line has
EMPTY = {"", "-", "nan", "na", "n/a", "none", "null", "missing", "=", ":"}
REFERENCES = {"reference", "error", "off"}  # columns of numbers that are no values
REMARKS = {"remark", "remarks", "comment", "comments", "note", "notes"}
_NUMBER = re.compile(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eEdD][-+]?\d+)?")
_POWER = re.compile(r"10\s*(\^|\*\*)")
_BRACKETS = re.compile(r"[\[(](.*?)[\])]")
_SIGNS = str.maketrans({"µ": "u", "μ": "u"} | dict.fromkeys(" []()*·.^"))
#: decimals that a comma parted from their number
_DECIMALS = re.compile(r"(0\d|\d{6})\d*([eEdD][-+]?\d+)?")


@dataclass
class Columns:
    """Header of a file: the column of values with its unit, and columns that have none."""

    value: int | None = None
    unit: str = ""
    skipped: set[int] = field(default_factory=set)

    def read(self, cells: list[str]) -> bool:
        """True for a header, whose columns count for the lines below."""
        keys = [_key(cell) for cell in cells]
        if len(keys) < 2 or not {"value", *REFERENCES} & {*keys}:
            return False
        self.value = keys.index("value") if "value" in keys else None
        self.unit = "" if self.value is None else _unit_in(cells[self.value])
        self.skipped = {i for i, key in enumerate(keys) if key in REFERENCES | REMARKS}
        return True


def foreign(path: str | Path, rows: Iterable[Row]) -> tuple[dict[str, float], list[str]]:
    """Values of another code from its CSV file, and the names that the problem does not have.

    A line has the name of a quantity, its value, and its unit, if that is another one. A header
    may name the column `value`; else the first number behind the name counts. Order, case and lines
    of remarks are free. So are the delimiter, one of comma, semicolon, tab, bar and space, and
    decimal commas unless commas delimit. A name without a value is missing.
    Raises ValueError for a file without any quantity, for one that stands twice, and for a value
    that is no number. A unit that is unknown or of another kind raises it, too.
    """
    by_key = {_key(row.quantity): row for row in rows}
    names = [row.quantity for row in by_key.values()]
    values: dict[str, float | None] = {}
    unknown: list[str] = []
    columns = Columns()
    for count, line in enumerate(_text(path).splitlines(), 1):
        cells = _cells(line.lstrip("# ").partition(" # ")[0], by_key)
        if line.lstrip().startswith("#"):
            columns.read(cells)
            continue
        at = next((i for i, cell in enumerate(cells) if _key(cell) in by_key), None)
        if at is None:
            if not columns.read(cells) and (name := _stranger(cells)):
                unknown.append(name + meant(name, names))
            continue
        row = by_key[_key(cells[at])]
        if row.quantity in values:
            raise ValueError(f"{path}:{count}: {row.quantity} is there twice")
        try:
            values[row.quantity] = _value(cells, at, row, columns)
        except ValueError as error:
            raise ValueError(f"{path}:{count}: {row.quantity}: {error}") from None
    if not values:
        hint = f"; a line has {unknown[-1]}" if unknown else ""
        reason = f"no line has a quantity of this problem{hint}; the problem has {', '.join(names)}"
        raise ValueError(f"{path}: {reason}")
    return {name: value for name, value in values.items() if value is not None}, unknown


def _text(path: str | Path) -> str:
    """A text in UTF-8, UTF-16 or the code page 1252, as spreadsheets write them."""
    data = Path(path).read_bytes()
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    return text.replace("\N{MINUS SIGN}", "-")


def _cells(line: str, keys: Container[str]) -> list[str]:
    """Cells of a line; commas are decimal behind a name and a space."""
    delimiter = next((d for d in DELIMITERS if d in line), None)
    words = line.replace("N m", "Nm").split()
    spaced = len(words) > 1 and _key(words[0]) in keys and _NUMBER.fullmatch(words[1])
    if delimiter is None or delimiter == "," and spaced:
        return words
    (cells,) = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
    return [cell.strip() for cell in cells]


def _key(name: str) -> str:
    """A name without case, brackets of units, and what stands between its words."""
    return re.sub(r"[\W_]+", "", _BRACKETS.sub("", name).lower())


def _stranger(cells: list[str]) -> str:
    """The name in a line of an unknown quantity, "" of a remark: a name stands by a number,
    with a unit or a remark of a word at most.
    """
    words = [i for i, cell in enumerate(cells) if re.search(r"[^\W\d]", _key(cell))]
    words = [i for i in words if not _NUMBER.match(cells[i]) and _plain(cells[i]) not in UNITS]
    matches = [match for match in map(_NUMBER.match, cells) if match]
    numbers = [m for m in matches if _plain(m.string[m.end() :]) in {"", *UNITS}]
    return cells[words[0]] if numbers and 0 < len(words) < 3 else ""


def _value(cells: list[str], at: int, row: Row, columns: Columns) -> float | None:
    """The number of a line in the unit of its row; None where the line has none."""
    free = [i for i in range(len(cells)) if i != at and i not in columns.skipped]
    order = [i for i in free if i > at] + [i for i in reversed(free) if i < at]
    if columns.value is not None and columns.value != at:
        numbers = [columns.value] if columns.value < len(cells) else []
    else:
        numbers = [i for i in order if _NUMBER.match(cells[i])]
        if row.unit == "1" and len(numbers) > 1 and cells[numbers[0]] == "1":
            numbers = numbers[1:]  # behind its unit
    words = [i for i in order if i not in numbers[:1] and not _NUMBER.match(cells[i])]
    behind = bool(numbers) and numbers[0] > at
    texts = [cells[i] for i in words if i > at or not behind or _plain(cells[i]) in UNITS]
    texts = [text for text in texts if text.lower() not in EMPTY and not text.startswith("#")]
    if any(_POWER.search(cells[i]) for i in order):
        raise ValueError("a power of ten stands by the number: write 5.28e-6")
    if not numbers or cells[numbers[0]].lower() in EMPTY:
        if strange := [text for text in texts if _plain(text) not in {*UNITS, _plain(row.unit)}]:
            raise ValueError(f"{strange[0]!r} is no number")
        return None
    number, rest = _number(*cells[numbers[0] :][:2])
    if rest:
        return _scaled(number, rest, row)
    units = [text for text in texts if _plain(text) in {*UNITS, _plain(row.unit)}]
    near = [*(units or texts), _unit_in(cells[at]), columns.unit]
    return _scaled(number, next((text for text in near if text), row.unit), row)


def _number(cell: str, after: str = "") -> tuple[float, str]:
    """Number of a cell, and the text behind it there; after: the next cell."""
    match = _NUMBER.match(cell)
    if not match:
        raise ValueError(f"{cell!r} is no number")
    rest = cell[match.end() :].strip()
    if cell.lstrip("+-").isdigit() and _DECIMALS.fullmatch(after):
        raise ValueError("decimal commas need semicolons or tabs between cells")
    if rest.startswith((".", ",")):
        raise ValueError(f"{cell!r} has a comma and a point: leave out what parts thousands")
    return float(match[0].replace(",", ".").lower().replace("d", "e")), rest


def _unit_in(name: str) -> str:
    """The unit in brackets behind a name, or ""."""
    brackets = _BRACKETS.search(name)
    return brackets[1].strip() if brackets else ""


def _plain(unit: str) -> str:
    """A unit without the signs that change nothing."""
    return unit.translate(_SIGNS)


def _known(unit: str, row: Row) -> tuple[str, float]:
    """Kind and factor of a unit."""
    name = _plain(unit)
    if name == _plain(row.unit):
        return UNITS.get(name, (row.unit, 1.0))
    if name not in UNITS:
        raise ValueError(f"{unit!r} is no unit that is known{meant(name, UNITS)}")
    return UNITS[name]


def _scaled(number: float, unit: str, row: Row) -> float:
    """A number of this unit in that of its row."""
    kind, factor = _known(unit, row)
    wanted, size = _known(row.unit, row)
    if kind != wanted:
        raise ValueError(f"{unit} is no unit of it; {row.unit} is")
    return number if factor == size else number * factor / size
