"""Numbers of a scene that write down how all others follow from them.

A `Symbol` is a float that carries its expression on a trace through arithmetic, as a `Column`
carries its values. Conditions go the way of its value. Conversions to plain floats lose the
expression: what is made this way has to be compared with scenes made one by one.
"""

import operator
from collections.abc import Callable
from numbers import Real

from clearance.tracing.trace import Scalar, Trace, Value
from clearance.values.columns import Column


def expression(number: float) -> Value:
    """The expression of a number; a plain one is itself."""
    return number.node if isinstance(number, Symbol) else float(number)


def _arithmetic(function: Callable, name: str, turned: bool = False) -> Callable:
    def method(self, other):
        if not isinstance(other, Real):
            return NotImplemented
        a, b = (other, self) if turned else (self, other)
        return self.followed(function(float(a), float(b)), name, a, b)

    return method


class Symbol(Column):
    """A number and its expression; see above. Equal numbers have hashes of their own: no memory
    that goes by values gives one for the other.
    """

    __slots__ = ("node",)

    def __new__(cls, value: float, node: Scalar) -> "Symbol":
        symbol = float.__new__(cls, value)
        symbol.node = symbol.values = node
        return symbol

    def followed(self, value: float, name: str, *numbers: float) -> "Symbol":
        """The result of an operation."""
        trace: Trace = self.node.trace
        operation = trace.binary if name == "pow" else trace.operation
        arguments = map(expression, numbers)
        node = operation(name, *arguments)
        return Symbol(value, node) if isinstance(node, Scalar) else value

    def each(self, function: Callable, numbers: tuple) -> float:
        """A function of `math` of numbers."""
        value = function(*map(float, numbers))
        return self.followed(value, function.__name__, *numbers)

    __add__, __radd__ = (_arithmetic(operator.add, "add", turned) for turned in (False, True))
    __sub__, __rsub__ = (_arithmetic(operator.sub, "sub", turned) for turned in (False, True))
    __mul__, __rmul__ = (_arithmetic(operator.mul, "mul", turned) for turned in (False, True))
    __truediv__, __rtruediv__ = (
        _arithmetic(operator.truediv, "div", turned) for turned in (False, True)
    )
    __pow__, __rpow__ = (_arithmetic(operator.pow, "pow", turned) for turned in (False, True))
    __lt__, __le__, __gt__, __ge__ = float.__lt__, float.__le__, float.__gt__, float.__ge__
    __eq__, __ne__, __bool__ = float.__eq__, float.__ne__, float.__bool__
    __hash__ = object.__hash__
    __int__, __trunc__, __round__ = float.__int__, float.__trunc__, float.__round__
    __floor__, __ceil__, __format__ = float.__floor__, float.__ceil__, float.__format__
    __mod__, __floordiv__ = float.__mod__, float.__floordiv__

    def __neg__(self) -> "Symbol":
        return self.followed(-float(self), "neg", self)

    def __abs__(self) -> "Symbol":
        return self.followed(abs(float(self)), "fabs", self)
