"""Parameters with all their values at once: one scene in place of many of the same structure.

A `Column` is a float, the first of its values, that carries the others along through arithmetic. A
comparison that does not come out alike for all of them, or a conversion that would lose them,
raises `Mixed`. Functions of `math` lose them without a word: what is made this way has to be
compared with some scenes made one by one.
"""

import operator
from collections.abc import Callable, Iterable
from numbers import Real
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # describing a scene needs no numpy
    import numpy as np


class Mixed(ValueError):
    """The values of a column do not share one way."""


def values_of(number) -> "np.ndarray | float":
    """All values of a number."""
    return number.values if isinstance(number, Column) else number


def each(function: Callable, *numbers: float) -> float:
    """A function of numbers; of columns a column, each value as Python works it out."""
    column = next((number for number in numbers if isinstance(number, Column)), None)
    return function(*numbers) if column is None else column.each(function, numbers)


def chosen(choice: Callable, numbers: Iterable[float], default: float = 0.0) -> float:
    """The largest (`max`) or least (`min`) of numbers; of columns a column, value by value."""
    numbers = list(numbers)
    return each(choice, *numbers) if len(numbers) > 1 else next(iter(numbers), default)


def _arithmetic(function: Callable, turned: bool = False) -> Callable:
    def method(self, other):
        if not isinstance(other, Real):
            return NotImplemented
        a, b = self.values, values_of(other)
        return Column(function(b, a) if turned else function(a, b))

    return method


def _comparison(function: Callable) -> Callable:
    def method(self, other):
        if not isinstance(other, Real):
            return NotImplemented
        holds = function(self.values, values_of(other))
        if holds.any() != holds.all():
            raise Mixed("a condition holds for some values and not for others")
        return bool(holds[0])

    return method


def _power(a, b) -> "np.ndarray":
    """Python's power of each pair: numpy's may differ from it in the last bit."""
    import numpy as np

    return np.frompyfunc(operator.pow, 2, 1)(a, b).astype(float)


def _refused(name: str) -> Callable:
    def method(self, *arguments):
        raise Mixed(f"{name} of many values")

    return method


class Column(float):
    """A number with many values; see above."""

    __slots__ = ("values",)

    def __new__(cls, values: "np.ndarray") -> "Column":
        column = super().__new__(cls, values[0])
        column.values = values
        return column

    __add__ = _arithmetic(operator.add)
    __radd__ = _arithmetic(operator.add, True)
    __sub__ = _arithmetic(operator.sub)
    __rsub__ = _arithmetic(operator.sub, True)
    __mul__ = _arithmetic(operator.mul)
    __rmul__ = _arithmetic(operator.mul, True)
    __truediv__ = _arithmetic(operator.truediv)
    __rtruediv__ = _arithmetic(operator.truediv, True)
    __pow__ = _arithmetic(_power)
    __rpow__ = _arithmetic(_power, True)
    __lt__ = _comparison(operator.lt)
    __le__ = _comparison(operator.le)
    __gt__ = _comparison(operator.gt)
    __ge__ = _comparison(operator.ge)
    __eq__ = _comparison(operator.eq)
    __ne__ = _comparison(operator.ne)
    __hash__ = float.__hash__
    __int__ = __trunc__ = _refused("the integer")
    __round__ = __floor__ = __ceil__ = _refused("rounding")
    __format__ = _refused("the text")
    __mod__ = __floordiv__ = _refused("the remainder")

    @staticmethod
    def each(function: Callable, numbers: tuple) -> "Column":
        """A function of numbers, value by value."""
        import numpy as np

        column = np.frompyfunc(function, len(numbers), 1)(*map(values_of, numbers))
        return Column(column.astype(float))

    def __neg__(self) -> "Column":
        return Column(-self.values)

    def __pos__(self) -> "Column":
        return self

    def __abs__(self) -> "Column":
        return Column(abs(self.values))

    def __bool__(self) -> bool:
        return self != 0.0
