"""The numbers of the lanes: rows by name, each of W numbers side by side."""

from collections.abc import Callable

from clearance.tracing.interpreter import Execution
from clearance.tracing.trace import Trace, is_value, live

LARGEST = 1.7e308


class Rows:
    """Places of rows by name: one, or several in turn."""

    def __init__(self):
        self.first: dict[str, int] = {}
        self.counts: dict[str, int] = {}
        self.total = 0

    def add(self, names: str, count: int = 1) -> None:
        """One row, or so many, for each name; names: with blanks between."""
        for name in names.split():
            self.first[name], self.counts[name] = self.total, count
            self.total += count

    def places(self, name: str) -> range:
        """Places of the rows of a name."""
        return range(self.first[name], self.first[name] + self.counts[name])


def split(values: list, count: int) -> list[list]:
    """Values in so many rows of equal length."""
    length = len(values) // count
    return [values[i * length : (i + 1) * length] for i in range(count)]


class Entry:
    """A function of W lanes that others call: it fills a vector of `count` numbers.

    It takes t, then the numbers of y.
    """

    operations, values_of = 200, None

    def __init__(self, name: str, count: int):
        self.name, self.count = name, count


class Piece:
    """A piece of a stepper on a trace: it reads rows and sets them.

    It changes the lanes that are in its phase (None: all); all others stay as they are.
    """

    def __init__(self, rows: Rows, phase: float | None):
        self.rows, self.trace = rows, Trace()
        self.outputs: dict[int, object] = {}
        self.on = None if phase is None else self.trace.compare("eq", self["phase"], phase)

    # --- rows
    def __getitem__(self, name: str):
        """The row of a name as it was."""
        return self.at(name, 0)

    def at(self, name: str, i: int):
        """The i-th row of a name as it was."""
        return self.trace.load(f"s[{self.rows.places(name)[i]}]")

    def all(self, name: str) -> list:
        """All rows of a name as they were."""
        return [self.trace.load(f"s[{row}]") for row in self.rows.places(name)]

    def set(self, **rows) -> None:
        """Set rows by name, the first ones to the values of a list."""
        for name, values in rows.items():
            values = [values] if is_value(values) else values
            self.outputs |= zip(self.rows.places(name), values, strict=False)

    def set_at(self, i: int, **rows) -> None:
        """Set the i-th row of each name."""
        self.outputs |= {self.rows.places(name)[i]: value for name, value in rows.items()}

    def keep(self, condition, **rows) -> None:
        """Set rows, see `set`, where a condition holds."""
        for name, values in rows.items():
            values = [values] if is_value(values) else values
            pairs = zip(values, self.all(name), strict=False)
            self.set(**{name: [self.choose(condition, *pair) for pair in pairs]})

    def leave(self, condition, *names: str) -> None:
        """Leave rows that were set as they were where a condition holds."""
        for row in (row for name in names for row in self.rows.places(name)):
            before = self.trace.load(f"s[{row}]")
            self.outputs[row] = self.choose(condition, before, self.outputs[row])

    def used(self, entry: Entry) -> list[int]:
        """Places of those values of a function that the piece uses."""
        items = [n.args for n in live(self.outputs.values()) if n.op == "item"]
        return sorted({i for called, i in items if called.args[0] is entry})

    # --- arithmetic
    def formula(self, function: Callable, *arguments) -> list:
        """Values of a formula of stepping/control.py."""
        plain = getattr(function, "py_func", function)
        return list(Execution(self.trace, plain, {}).returned(list(arguments)))

    def call(self, entry: Entry, t, y: list) -> list:
        """Values of a function of time and state."""
        return self.trace.call(entry, [t, *y])

    def sqrt(self, a):
        return self.trace.sqrt(a)

    def choose(self, condition, a, b):
        """a where the condition holds, else b."""
        return self.trace.select(condition, a, b)

    def flag(self, condition):
        """1 where the condition holds, else 0."""
        return self.choose(condition, 1.0, 0.0)

    def both(self, *conditions):
        """True where all of them hold."""
        return self._joined(self.trace.both, conditions)

    def either(self, *conditions):
        """True where one of them holds."""
        return self._joined(self.trace.either, conditions)

    def _joined(self, join: Callable, conditions: tuple):
        result = conditions[0]
        for condition in conditions[1:]:
            result = join(result, condition)
        return result

    def none(self, condition):
        """True where it does not hold."""
        return self.trace.negation(condition)

    def largest(self, a, *others):
        for b in others:
            a = self.choose(a > b, a, b)
        return a

    def smallest(self, a, *others):
        for b in others:
            a = self.choose(a < b, a, b)
        return a

    def total(self, values):
        return self.trace.sum(values)

    def weighted(self, weights, values):
        """Sum of products, those with a weight of zero left out."""
        pairs = zip(weights, values, strict=True)
        return self.trace.sum(value * float(w) for w, value in pairs if w != 0.0)

    def along(self, polynomial: list, share, count: int) -> list:
        """Change of so many states up to a share of a step, on its dense output."""
        return [value for value, _ in self.moving(polynomial, share, count)]

    def moving(self, polynomial: list, share, count: int) -> list[tuple]:
        """These changes, each with its derivative to the share."""
        pairs = []
        for i in range(count):
            value = slope = 0.0
            for r in range(len(polynomial) // count - 1, -1, -1):
                value = value + polynomial[r * count + i]
                factor, turn = (share, 1.0) if r % 2 == 0 else (1.0 - share, -1.0)
                value, slope = value * factor, slope * factor + value * turn
            pairs.append((value, slope))
        return pairs

    def length(self, values, count: int):
        """Root of the mean square."""
        return self.sqrt(self.total(v * v for v in values) * (1.0 / count))

    def finite(self, values):
        """True where all values are finite."""
        return self.both(*(abs(v) < LARGEST for v in values))
