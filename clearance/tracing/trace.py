"""Traced scalars: arithmetic on them writes down a graph of operations.

Mechanics written with `+ - * /`, `sqrt`, `sin`, `cos` runs on plain floats or on traced scalars
alike; so do laws, whose source the interpreter executes. A trace folds constants, drops structural
zeros, shares common terms and differentiates forward with sparse seeds. What depends on parameters
only becomes a derived parameter, see `DerivedParameters`. The graph is written as Python by
`emission` and as LLVM IR by `ir`.
"""

import math
import operator
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

Tangents = dict  # column -> Value

#: functions of one number: name -> derivative by the argument x, where y is the value
UNARY: dict[str, Callable] = {
    "sqrt": lambda t, x, y: t.div(0.5, y),
    "exp": lambda t, x, y: y,
    "log": lambda t, x, y: t.div(1.0, x),
    "sin": lambda t, x, y: t.function("cos", x),
    "cos": lambda t, x, y: t.neg(t.function("sin", x)),
    "tan": lambda t, x, y: 1.0 + y * y,
    "tanh": lambda t, x, y: 1.0 - y * y,
    "sinh": lambda t, x, y: t.function("cosh", x),
    "cosh": lambda t, x, y: t.function("sinh", x),
    "asin": lambda t, x, y: t.div(1.0, t.sqrt(1.0 - x * x)),
    "acos": lambda t, x, y: t.div(-1.0, t.sqrt(1.0 - x * x)),
    "atan": lambda t, x, y: t.div(1.0, 1.0 + x * x),
    "asinh": lambda t, x, y: t.div(1.0, t.sqrt(1.0 + x * x)),
    "atanh": lambda t, x, y: t.div(1.0, 1.0 - x * x),
    "log1p": lambda t, x, y: t.div(1.0, 1.0 + x),
    "expm1": lambda t, x, y: y + 1.0,
    "erf": lambda t, x, y: t.function("exp", t.neg(x * x)) * (2.0 / math.sqrt(math.pi)),
    "erfc": lambda t, x, y: t.function("exp", t.neg(x * x)) * (-2.0 / math.sqrt(math.pi)),
    "fabs": lambda t, x, y: t.binary("copysign", 1.0, x),
}
FLAT = ("floor", "ceil", "trunc")  # functions of one number without a slope
STEEP = ("sqrt", "pow", "asin", "acos", "hypot", "atan2")  # finite where a slope is not
COMPARISONS = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}
BOOLEAN = {*COMPARISONS, "and", "or", "not"}
BINARY = ("atan2", "hypot", "copysign", "fmod", "pow")
OPERATIONS = {"and": "both", "or": "either", "not": "negation", "pow": "power"}
OPERATIONS |= {n: n for n in ("add", "sub", "mul", "div", "neg", "select", "load", "lookup")}


def _operation(name: str, turned: bool = False) -> Callable:
    """Method of a traced number and another; turned: the other one stands first."""

    def method(self, other):
        operation = getattr(self.trace, name)
        return operation(other, self) if turned else operation(self, other)

    return method


def _comparison(name: str) -> Callable:
    return lambda self, other: self.trace.compare(name, self, other)


class Scalar:
    """One traced number or truth value.

    fixed: depends on parameters only, so it can be computed once per parameter set. rule: of a
    call, what differentiates it in place of its function.
    """

    __slots__ = ("trace", "index", "op", "args", "fixed", "section", "rule")

    def __init__(self, trace, index, op, args, fixed, section):
        self.trace, self.index, self.op, self.args = trace, index, op, args
        self.fixed, self.section, self.rule = fixed, section, None

    @property
    def operands(self) -> list["Scalar"]:
        """The traced values that this one is made of."""
        return [a for a in self.args if isinstance(a, Scalar)]

    @property
    def boolean(self) -> bool:
        return self.op in BOOLEAN

    __add__ = __radd__ = _operation("add")
    __sub__, __rsub__ = _operation("sub"), _operation("sub", True)
    __mul__ = __rmul__ = _operation("mul")
    __truediv__, __rtruediv__ = _operation("div"), _operation("div", True)
    __and__ = __rand__ = _operation("both")
    __or__ = __ror__ = _operation("either")
    __lt__, __le__, __gt__, __ge__ = map(_comparison, ("lt", "le", "gt", "ge"))

    def __neg__(self):
        return self.trace.neg(self)

    def __abs__(self):
        return self.trace.function("fabs", self)

    def __bool__(self):
        raise TypeError("a traced scalar has no truth value: use trace.select")

    def __repr__(self):
        return f"v{self.index}"


Value = Scalar | float


def is_number(value) -> bool:
    return not isinstance(value, Scalar)


def is_value(value) -> bool:
    """True for a traced number, and for a number."""
    return isinstance(value, Scalar | int | float)


def is_zero(value) -> bool:
    """True for a structural zero: a number, and 0. A column of samples is none."""
    return isinstance(value, int | float) and value == 0.0


def defined(function: Callable, *numbers):
    """A function of numbers, not a number where Python raises: a condition may leave the value
    out.
    """
    try:
        value = function(*numbers)
    except (ArithmeticError, ValueError):
        return math.nan
    return math.nan if isinstance(value, complex) else value


@dataclass(frozen=True, eq=False)
class Rule:
    """Differentiates values that follow from inputs in another way than by a chain of operations.

    tangents(tangents of inputs) -> tangents of values. The inputs hold all that the values depend
    on.
    """

    inputs: list
    tangents: Callable

    def of(self, tangents: list[Tangents]) -> list[Tangents]:
        """Tangents of the values, sparse."""
        return [_without_zeros(row) for row in self.tangents(tangents)]


class Trace:
    """A growing list of operations, each written once."""

    def __init__(self, exact: bool = False):
        self.exact = exact  # divides where it could multiply by the reciprocal of a parameter
        self.nodes: list[Scalar] = []
        self.section = ""
        self._nodes: dict[tuple, Scalar] = {}
        # with the place and sign of the value
        self.rules: dict[Scalar, tuple[Rule, int, float]] = {}

    def node(self, op, *args) -> Scalar:
        """The one node of an operation on operands."""
        key = (op, *map(_key, args))
        if key in self._nodes:
            return self._nodes[key]
        operands = [a for a in args if isinstance(a, Scalar)]
        if op == "load":
            fixed = args[0].startswith("par[")
        else:
            fixed = (
                op not in ("call", "item", "lookup")
                and bool(operands)
                and all(a.fixed for a in operands)
            )
        node = Scalar(self, len(self.nodes), op, args, fixed, self.section)
        self.nodes.append(node)
        self._nodes[key] = node
        return node

    # --- sources
    def load(self, text: str) -> Scalar:
        """A named input: "t", "y[3]", "par[7]", or an argument of a function."""
        return self.node("load", text)

    def lookup(self, index) -> Scalar:
        """The number of the parameter vector at a traced index, truncated."""
        return self.node("lookup", index if isinstance(index, Scalar) else float(index))

    # --- arithmetic, with folding
    def add(self, a, b):
        if is_number(a) and is_number(b):
            return a + b
        if is_number(a):
            a, b = b, a
        a, b = self.numeric(a), self.numeric(b)
        if is_number(b):
            return a if b == 0.0 else self.node("add", a, float(b))
        if b.op == "neg":
            return self.sub(a, b.args[0])
        if a.op == "neg":
            return self.sub(b, a.args[0])
        return self.node("add", *sorted((a, b), key=lambda s: s.index))

    def sub(self, a, b):
        if is_number(a) and is_number(b):
            return a - b
        a, b = self.numeric(a), self.numeric(b)
        if is_number(b):
            return self.add(a, -b)
        if is_number(a) and a == 0.0:
            return self.neg(b)
        if a is b:
            return 0.0
        if b.op == "neg":
            return self.add(a, b.args[0])
        return self.node("sub", a if isinstance(a, Scalar) else float(a), b)

    def neg(self, a):
        if is_number(a):
            return -a
        a = self.numeric(a)
        if a.op == "neg":
            return a.args[0]
        if a.op == "sub":
            return self.sub(a.args[1], a.args[0])
        return self.node("neg", a)

    def mul(self, a, b):
        if is_number(a) and is_number(b):
            return a * b
        if is_number(a):
            a, b = b, a
        a, b = self.numeric(a), self.numeric(b)
        if is_number(b):
            if b == 0.0:
                return 0.0
            if b == 1.0:
                return a
            return self.neg(a) if b == -1.0 else self.node("mul", a, float(b))
        if a.op == "neg" and b.op == "neg":
            return self.mul(a.args[0], b.args[0])
        if a.op == "neg":
            return self.neg(self.mul(a.args[0], b))
        if b.op == "neg":
            return self.neg(self.mul(a, b.args[0]))
        return self.node("mul", *sorted((a, b), key=lambda s: s.index))

    def div(self, a, b):
        if is_number(a) and is_number(b):
            return defined(operator.truediv, a, b)
        a, b = self.numeric(a), self.numeric(b)
        if is_number(b) and (b == 1.0 or not self.exact):
            return self.mul(a, defined(operator.truediv, 1.0, b))
        if is_number(a):
            return 0.0 if a == 0.0 else self.node("div", float(a), b)
        if self.exact:
            return self.node("div", a, self.number(b))
        if a is b:
            return 1.0
        if b.fixed and not a.fixed:
            return self.mul(a, self.div(1.0, b))  # the reciprocal is a derived parameter
        return self.node("div", a, b)

    def power(self, a, b):
        """a to the power of b; small integer exponents as products, 1/2 as a root."""
        if is_number(a) and is_number(b):
            return defined(operator.pow, a, b)
        if is_number(b) and b in (0, 1, 2, 3, 4):
            return [
                lambda: 1.0,
                lambda: a,
                lambda: a * a,
                lambda: a * a * a,
                lambda: (a * a) * (a * a),
            ][int(b)]()
        return self.sqrt(a) if is_number(b) and b == 0.5 else self.binary("pow", a, b)

    def function(self, name: str, a):
        """A function of one number: one of UNARY or FLAT."""
        a = self.numeric(a)
        return float(defined(getattr(math, name), a)) if is_number(a) else self.node(name, a)

    def binary(self, name: str, a, b):
        """pow, atan2, hypot, fmod or copysign."""
        if is_number(a) and is_number(b):
            return defined(getattr(math, name), a, b)
        if name == "hypot" and is_zero(a):
            return self.function("fabs", b)
        return self.node(name, self.number(a), self.number(b))

    def sqrt(self, a):
        return self.function("sqrt", a)

    def sin(self, a):
        return self.function("sin", a)

    def cos(self, a):
        return self.function("cos", a)

    def atan2(self, a, b):
        return self.binary("atan2", a, b)

    # --- truth values
    def compare(self, op: str, a, b):
        """lt, le, gt, ge, eq or ne of two numbers."""
        if is_number(a) and is_number(b):
            return getattr(operator, op)(a, b)
        return self.node(op, self.number(a), self.number(b))

    def truth(self, a):
        """A value as a condition: a number is true unless it is zero."""
        return bool(a) if is_number(a) else a if a.boolean else self.compare("ne", a, 0.0)

    def negation(self, a):
        if is_number(a):
            return not a
        return a.args[0] if a.op == "not" else self.node("not", a)

    def both(self, a, b):
        if is_number(a) or is_number(b):
            a, b = (a, b) if is_number(a) else (b, a)
            return b if a else False
        return a if a is b else self.node("and", a, b)

    def either(self, a, b):
        if is_number(a) or is_number(b):
            a, b = (a, b) if is_number(a) else (b, a)
            return True if a else b
        return a if a is b else self.node("or", a, b)

    def numeric(self, a):
        """A truth value as 1 or 0; a number as it is."""
        return self.node("select", a, 1.0, 0.0) if isinstance(a, Scalar) and a.boolean else a

    def number(self, a):
        """An operand: traced, or a float."""
        return self.numeric(a) if isinstance(a, Scalar) else float(a)

    def select(self, condition, a, b):
        """a where the condition holds, else b; a number for a condition holds where it is
        positive.
        """
        if is_number(condition):
            return a if condition > 0.0 else b
        condition = condition if condition.boolean else self.compare("gt", condition, 0.0)
        if a is b or is_number(a) and is_number(b) and _key(float(a)) == _key(float(b)):
            return a
        if condition.op == "not":
            condition, a, b = condition.args[0], b, a
        return self.node("select", condition, self.number(a), self.number(b))

    def sum(self, values: Iterable):
        total = 0.0
        for value in values:
            total += value
        return total

    # --- functions
    def call(self, function, args: list, rule: Callable | None = None) -> list:
        """Outputs of a function (see function.py).

        rule(args, tangents of args) -> tangents of outputs differentiates it, by default its own
        derivative.
        """
        node = self.node("call", function, *map(self.number, args))
        node.rule = rule
        return [self.node("item", node, i) for i in range(function.count)]

    # --- differentiation
    def follow(self, values: list, inputs: list, tangents: Callable) -> None:
        """Differentiate values by a rule, in place of the operations that made them; see Rule."""
        rule = Rule(inputs, tangents)
        last = max((a.index for a in inputs if isinstance(a, Scalar)), default=-1)
        for i, value in enumerate(values):
            negative = isinstance(value, Scalar) and value.op == "neg"
            node = value.args[0] if negative else value
            # an older node is an expression that was there before its inputs: it keeps its chain
            if isinstance(node, Scalar) and node.op != "load" and node.index > last:
                self.rules.setdefault(node, (rule, i, -1.0 if negative else 1.0))

    def _needed(self, node: Scalar) -> list[Scalar]:
        """Values that the tangents of a node follow from."""
        inputs = self.rules[node][0].inputs if node in self.rules else node.args
        return [a for a in inputs if isinstance(a, Scalar)]

    def tangent(self, outputs: Iterable, seeds: Mapping[Scalar, Tangents]) -> list[Tangents]:
        """Derivatives of the outputs along the seeded columns, as sparse dicts {column: value}."""
        outputs = list(outputs)
        slopes: dict[Scalar, Tangents] = {}
        pulled: dict[Scalar | Rule, list[Tangents]] = {}

        def of(a):
            return slopes.get(a, {}) if isinstance(a, Scalar) else {}

        section = self.section
        for node in live(outputs, seeds.__contains__, self._needed):
            if node in seeds:
                slopes[node] = dict(seeds[node])
            elif node in self.rules:
                rule, index, sign = self.rules[node]
                if rule not in pulled:
                    pulled[rule] = rule.of([of(a) for a in rule.inputs])
                slopes[node] = {c: v if sign > 0.0 else -v for c, v in pulled[rule][index].items()}
            elif node.op == "call":
                args = node.args[1:]
                if any(of(a) for a in args):
                    self.section = node.section
                    rule = node.rule or (lambda a, t, f=node.args[0]: self._through(f, a, t))
                    pulled[node] = rule(args, [of(a) for a in args])
            elif node.op == "item":
                slopes[node] = pulled[node.args[0]][node.args[1]] if node.args[0] in pulled else {}
            elif node.op == "select":
                slopes[node] = self._selected(node.args[0], of(node.args[1]), of(node.args[2]))
            elif node.op != "load" and not node.fixed and not node.boolean:
                slopes[node] = self._chained(node, of)
        self.section = section
        return [of(o) for o in outputs]

    def spread(self, outputs: Iterable, seeds: Iterable[Scalar]) -> int:
        """Number of derivatives that `tangent` would form along as many columns as there are
        seeds.
        """
        columns = {seed: {i} for i, seed in enumerate(seeds)}
        for node in live(outputs, columns.__contains__, self._needed):
            if node not in columns:
                columns[node] = set().union(*(columns[a] for a in self._needed(node)))
        return sum(map(len, columns.values()))

    def _through(self, function, args, tangents) -> list[Tangents]:
        """Tangents of a call: the function's derivative by its active arguments, times theirs."""
        active = tuple(i for i, t in enumerate(tangents) if t)
        values = self.call(function.slopes(active), list(args))
        columns = sorted({c for t in tangents for c in t})
        results = []
        for k in range(function.count):
            by = values[function.count + k * len(active) :][: len(active)]
            pairs = list(zip(by, (tangents[i] for i in active), strict=True))
            row = {c: self.sum(s * t[c] for s, t in pairs if c in t) for c in columns}
            results.append(_without_zeros(row))
        return results

    def _selected(self, condition, first: Tangents, second: Tangents) -> Tangents:
        columns = sorted(set(first) | set(second))
        row = {c: self.select(condition, first.get(c, 0.0), second.get(c, 0.0)) for c in columns}
        return _without_zeros(row)

    def _chained(self, node: Scalar, of: Callable) -> Tangents:
        """Tangents of one operation."""
        partials = self._partials(node, [bool(of(a)) for a in node.args])
        pairs = list(zip(node.args, partials, strict=True))
        columns = sorted({c for a in node.args for c in of(a)})
        times = self._scaled if node.op in STEEP else self.mul
        row = {c: self.sum(times(p, of(a)[c]) for a, p in pairs if c in of(a)) for c in columns}
        return _without_zeros(row)

    def _scaled(self, partial, slope):
        """A partial derivative, infinite perhaps, times a slope: 0 on the sides where this is 0."""
        if is_number(slope):
            return partial * slope if slope else 0.0
        if slope.op == "select" and any(map(is_zero, slope.args[1:])):
            condition, *sides = slope.args
            return self.select(condition, *(self._scaled(partial, s) for s in sides))
        if slope.op == "mul":
            first, second = sorted(slope.args, key=lambda a: getattr(a, "op", "") != "select")
            if isinstance(first, Scalar) and first.op == "select":
                return self._scaled(partial * second, first)
        return partial * slope

    def _partials(self, node, active) -> list:
        """Partial derivatives of one operation with respect to its arguments (only the active ones
        matter).
        """
        op, args = node.op, node.args
        if not any(active) or op in FLAT or op == "lookup":
            return [0.0] * len(args)
        if op in UNARY:
            return [UNARY[op](self, args[0], node)]
        if op == "add":
            return [1.0, 1.0]
        if op == "sub":
            return [1.0, -1.0]
        if op == "neg":
            return [-1.0]
        if op == "mul":
            return [args[1], args[0]]
        a, b = args
        if op == "div":
            inverse = self.div(1.0, b)
            return [inverse, self.neg(self.mul(node, inverse)) if active[1] else 0.0]
        if op == "pow":
            return self._power_partials(node, active)
        if op == "atan2":
            inverse = self.div(1.0, a * a + b * b)
            return [b * inverse, self.neg(a * inverse)]
        if op == "hypot":
            return [self.div(a, node), self.div(b, node)]
        if op == "fmod":
            return [1.0, self.neg(self.function("trunc", self.div(a, b)))]
        if op == "copysign":
            return [self.binary("copysign", 1.0, a) * self.binary("copysign", 1.0, b), 0.0]
        raise ValueError(f"no derivative for {op}")

    def _power_partials(self, node, active) -> list:
        """b a^(b - 1), 0 for b = 0, and a^b ln a, 0 for a <= 0."""
        a, b = node.args
        first = second = 0.0
        if active[0]:
            first = self.select(self.compare("ne", b, 0.0), b * self.power(a, b - 1.0), 0.0)
        if active[1]:
            second = self.select(self.compare("gt", a, 0.0), node * self.function("log", a), 0.0)
        return [first, second]

    # --- by name
    def operation(self, op: str, *args):
        """An operation by its name, as nodes have it."""
        if op in OPERATIONS:
            return getattr(self, OPERATIONS[op])(*args)
        if op in COMPARISONS:
            return self.compare(op, *args)
        return self.binary(op, *args) if op in BINARY else self.function(op, *args)


def _key(operand):
    """Equal for operands that are the same; zeros of either sign are two."""
    if isinstance(operand, Scalar):
        return "v", operand.index
    return (
        "-0"
        if isinstance(operand, float) and operand == 0.0 and math.copysign(1.0, operand) < 0.0
        else operand
    )


def _without_zeros(row: Tangents) -> Tangents:
    return {c: v for c, v in row.items() if not is_zero(v)}


def live(
    outputs: Iterable,
    cut: Callable[[Scalar], bool] = lambda node: False,
    operands: Callable[[Scalar], list] = Scalar.operands.fget,
) -> list[Scalar]:
    """The operations that outputs need, in order; the walk stops at nodes where `cut` holds."""
    needed = set()
    stack = [o for o in outputs if isinstance(o, Scalar)]
    while stack:
        node = stack.pop()
        if node not in needed:
            needed.add(node)
            if not cut(node):
                stack += operands(node)
    return sorted(needed, key=operator.attrgetter("index"))


class DerivedParameters:
    """Derived parameters: values of parameters only, computed once and read from `par` behind the
    numbers.
    """

    def __init__(self, offset: int):
        self.offset = offset
        self.index: dict[Scalar, int] = {}

    def claim(self, outputs: Iterable) -> None:
        """Give a place to every fixed value that the outputs read."""
        for node in live(outputs, derived):
            if derived(node):
                self.index.setdefault(node, self.offset + len(self.index))


def derived(node: Scalar) -> bool:
    """True for values that are computed once for a set of parameters."""
    return node.fixed and node.op != "load" and not node.boolean


def text(value) -> str:
    """A value as it stands in an expression."""
    if isinstance(value, Scalar):
        return f"v{value.index}"
    if not math.isfinite(value):
        return "math.nan" if value != value else "math.inf" if value > 0 else "(-math.inf)"
    return f"({float(value)!r})" if value < 0 else repr(float(value))
