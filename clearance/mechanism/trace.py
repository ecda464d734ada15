"""Traced scalars: arithmetic on them writes down straight-line code.

Mechanics written with `+ - * /`, `sqrt`, `sin`, `cos` runs on plain floats or on traced scalars alike. A trace folds
constants, drops structural zeros, shares common terms, differentiates forward with sparse seeds, and prints the code
that its outputs need, nothing else. What depends on parameters only is moved out of the code into derived parameters.
"""

import math
from collections.abc import Callable, Iterable, Mapping

Tangents = dict  # column -> Value


class Scalar:
    """One traced number. `fixed`: depends on parameters only, so it can be computed once per parameter set."""

    __slots__ = ("trace", "index", "op", "args", "fixed", "section", "rule")

    def __init__(self, trace, index, op, args, fixed, section):
        self.trace, self.index, self.op, self.args = trace, index, op, args
        self.fixed, self.section, self.rule = fixed, section, None

    def __add__(self, other):
        return self.trace.add(self, other)

    __radd__ = __add__

    def __sub__(self, other):
        return self.trace.sub(self, other)

    def __rsub__(self, other):
        return self.trace.sub(other, self)

    def __mul__(self, other):
        return self.trace.mul(self, other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self.trace.div(self, other)

    def __rtruediv__(self, other):
        return self.trace.div(other, self)

    def __neg__(self):
        return self.trace.neg(self)

    def __bool__(self):
        raise TypeError("a traced scalar has no truth value: use trace.select")

    def __repr__(self):
        return f"v{self.index}"


Value = Scalar | float


def is_number(value) -> bool:
    return not isinstance(value, Scalar)


class Trace:
    """A growing list of operations, each written once."""

    def __init__(self):
        self.nodes: list[Scalar] = []
        self.section = ""
        self._known: dict[tuple, Scalar] = {}

    def _node(self, op, *args) -> Scalar:
        key = (op, *(("v", a.index) if isinstance(a, Scalar) else a for a in args))
        if key in self._known:
            return self._known[key]
        operands = [a for a in args if isinstance(a, Scalar)]
        fixed = op != "call" and all(a.fixed for a in operands) and (bool(operands) or op == "load")
        if op == "load":
            fixed = args[0].startswith("par[")
        node = Scalar(self, len(self.nodes), op, args, fixed, self.section)
        self.nodes.append(node)
        self._known[key] = node
        return node

    # --- sources
    def load(self, text: str) -> Scalar:
        """A named input: "t", "y[3]", "par[7]", or an argument of a helper function."""
        return self._node("load", text)

    # --- arithmetic, with folding
    def add(self, a, b):
        if is_number(a) and is_number(b):
            return a + b
        if is_number(a):
            a, b = b, a
        if is_number(b):
            return a if b == 0.0 else self._node("add", a, float(b))
        if b.op == "neg":
            return self.sub(a, b.args[0])
        if a.op == "neg":
            return self.sub(b, a.args[0])
        return self._node("add", *sorted((a, b), key=lambda s: s.index))

    def sub(self, a, b):
        if is_number(a) and is_number(b):
            return a - b
        if is_number(b):
            return self.add(a, -b)
        if is_number(a) and a == 0.0:
            return self.neg(b)
        if a is b:
            return 0.0
        if b.op == "neg":
            return self.add(a, b.args[0])
        return self._node("sub", a if isinstance(a, Scalar) else float(a), b)

    def neg(self, a):
        if is_number(a):
            return -a
        if a.op == "neg":
            return a.args[0]
        if a.op == "sub":
            return self.sub(a.args[1], a.args[0])
        return self._node("neg", a)

    def mul(self, a, b):
        if is_number(a) and is_number(b):
            return a * b
        if is_number(a):
            a, b = b, a
        if is_number(b):
            if b == 0.0:
                return 0.0
            if b == 1.0:
                return a
            return self.neg(a) if b == -1.0 else self._node("mul", a, float(b))
        if a.op == "neg" and b.op == "neg":
            return self.mul(a.args[0], b.args[0])
        if a.op == "neg":
            return self.neg(self.mul(a.args[0], b))
        if b.op == "neg":
            return self.neg(self.mul(a, b.args[0]))
        return self._node("mul", *sorted((a, b), key=lambda s: s.index))

    def div(self, a, b):
        if is_number(b):
            return self.mul(a, 1.0 / b)
        if is_number(a):
            return 0.0 if a == 0.0 else self._node("div", float(a), b)
        if a is b:
            return 1.0
        if b.fixed and not a.fixed:
            return self.mul(a, self.div(1.0, b))  # the reciprocal is a derived parameter
        return self._node("div", a, b)

    def function(self, name: str, a):
        """sqrt, sin or cos."""
        return getattr(math, name)(a) if is_number(a) else self._node(name, a)

    def sqrt(self, a):
        return self.function("sqrt", a)

    def sin(self, a):
        return self.function("sin", a)

    def cos(self, a):
        return self.function("cos", a)

    def atan2(self, a, b):
        return math.atan2(a, b) if is_number(a) and is_number(b) else self._node("atan2", a, b)

    def select(self, condition, a, b):
        """a where condition > 0, else b."""
        if is_number(condition):
            return a if condition > 0.0 else b
        if a is b or is_number(a) and is_number(b) and a == b:
            return a
        return self._node("select", condition, a, b)

    def sum(self, values: Iterable):
        total = 0.0
        for value in values:
            total = total + value
        return total

    def call(self, name: str, args: list, outputs: int, rule: Callable | None = None, wrap: str = "") -> list:
        """Outputs of a named plain function. `rule(args, tangents of args) -> tangents of outputs` differentiates it.

        wrap: text of the argument list with {} for each argument (default: all in order).
        """
        node = self._node("call", name, wrap, outputs, *args)
        node.rule = rule
        return [self._node("item", node, i) for i in range(outputs)]

    # --- differentiation
    def tangent(self, outputs: Iterable, seeds: Mapping[Scalar, Tangents]) -> list[Tangents]:
        """Derivatives of the outputs along the seeded columns, as sparse dicts {column: value}."""
        outputs = list(outputs)
        d: dict[Scalar, Tangents] = {}
        pulled: dict[Scalar, list[Tangents]] = {}

        def of(a):
            return d.get(a, {}) if isinstance(a, Scalar) else {}

        for node in self.live(outputs):
            if node in seeds:
                d[node] = dict(seeds[node])
            elif node.op == "call":
                args = node.args[3:]
                if any(of(a) for a in args):
                    pulled[node] = node.rule(args, [of(a) for a in args])
            elif node.op == "item":
                d[node] = pulled[node.args[0]][node.args[1]] if node.args[0] in pulled else {}
            elif node.op != "load" and not node.fixed:
                partials = self._partials(node, [bool(of(a)) for a in node.args])
                columns = sorted({c for a in node.args for c in of(a)})
                d[node] = {
                    c: self.sum(p * of(a)[c] for a, p in zip(node.args, partials, strict=True) if c in of(a))
                    for c in columns
                }
                d[node] = {c: v for c, v in d[node].items() if not (is_number(v) and v == 0.0)}
        return [of(o) for o in outputs]

    def _partials(self, node, active) -> list:
        """Partial derivatives of one operation with respect to its arguments (only the active ones matter)."""
        op, args = node.op, node.args
        if op == "select":
            # a selected derivative: the condition itself does not contribute
            c = args[0]
            return [0.0, self.select(c, 1.0, 0.0), self.select(c, 0.0, 1.0)]
        if not any(active):
            return [0.0] * len(args)
        if op == "add":
            return [1.0, 1.0]
        if op == "sub":
            return [1.0, -1.0]
        if op == "neg":
            return [-1.0]
        if op == "mul":
            return [args[1], args[0]]
        if op == "div":
            inverse = self.div(1.0, args[1])
            return [inverse, self.neg(self.mul(node, inverse)) if active[1] else 0.0]
        if op == "sqrt":
            return [self.div(0.5, node)]
        if op == "sin":
            return [self.cos(args[0])]
        if op == "cos":
            return [self.neg(self.sin(args[0]))]
        if op == "atan2":
            inverse = self.div(1.0, args[0] * args[0] + args[1] * args[1])
            return [args[1] * inverse, self.neg(args[0] * inverse)]
        raise ValueError(f"no derivative for {op}")

    # --- text
    def live(self, outputs: Iterable) -> list[Scalar]:
        """The operations the outputs need, in order."""
        needed, stack = set(), [o for o in outputs if isinstance(o, Scalar)]
        while stack:
            node = stack.pop()
            if node not in needed:
                needed.add(node)
                stack += [a for a in node.args if isinstance(a, Scalar)]
        return sorted(needed, key=lambda s: s.index)

    def statements(self, outputs: Iterable, slots: "Slots | None" = None, merged: Mapping | None = None) -> list[str]:
        """Code lines that compute the outputs. With `slots`, fixed values are read from derived parameters.

        merged: calls that another call answers as well, with that one, which takes the place of the first.
        """
        nodes = self.live(outputs) if slots is None else slots.claim(outputs)
        merged = merged or {}
        lines, section = [], None
        for node in nodes:
            if node in merged.values():
                continue
            if node.section != section and node.section:
                lines.append(f"# {node.section}")
                section = node.section
            lines.append(self.statement(merged.get(node, node), slots, merged))
        return lines

    def statement(self, node: Scalar, slots: "Slots | None" = None, merged: Mapping | None = None) -> str:
        if slots is not None and node.fixed and node.op != "load":
            return f"v{node.index} = {slots.text(node)}"
        texts = [a if isinstance(a, str) else text(a) for a in node.args]
        op = node.op
        if op == "load":
            return f"v{node.index} = {node.args[0]}"
        if op in _INFIX:
            return f"v{node.index} = {texts[0]} {_INFIX[op]} {texts[1]}"
        if op == "neg":
            return f"v{node.index} = -{texts[0]}"
        if op == "select":
            return f"v{node.index} = {texts[1]} if {texts[0]} > 0.0 else {texts[2]}"
        if op == "call":
            name, wrap, count, *args = node.args
            listed = [text(a) for a in args]
            inside = wrap.format(*listed) if wrap else ", ".join(listed)
            return f"v{node.index} = {name}({inside})"
        if op == "item":
            call = (merged or {}).get(node.args[0], node.args[0])
            return f"v{node.index} = v{call.index}" + (f"[{node.args[1]}]" if call.args[2] > 1 else "")
        return f"v{node.index} = math.{op}({', '.join(texts)})"


class Inside:
    """A trace of its own whose leaves are values of the outer trace: the arguments x0, x1, ... of a helper function."""

    def __init__(self):
        self.trace = Trace()
        self.inner: dict[Scalar, Scalar] = {}  # outer value -> its argument

    def value(self, outer):
        """What stands for an outer value here."""
        if is_number(outer):
            return outer
        if outer not in self.inner:
            self.inner[outer] = self.trace.load(f"x{len(self.inner)}")
        return self.inner[outer]

    @property
    def outer(self) -> list[Scalar]:
        return list(self.inner)

    @property
    def names(self) -> list[str]:
        return [f"x{i}" for i in range(len(self.inner))]


_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def text(value) -> str:
    """A value as it stands in an expression."""
    if isinstance(value, Scalar):
        return f"v{value.index}"
    return f"({float(value)!r})" if value < 0 else repr(float(value))


class Slots:
    """Derived parameters: values of parameters only, computed once and read from `par` behind the numbers."""

    def __init__(self, offset: int):
        self.offset = offset
        self.order: list[Scalar] = []
        self._slot: dict[Scalar, int] = {}

    def claim(self, outputs: Iterable) -> list[Scalar]:
        """Operations the outputs need; a fixed value among them gets a slot, and what it is made of stays out."""
        nodes = self.cut(outputs)
        for node in nodes:
            if node.fixed and node.op != "load" and node not in self._slot:
                self._slot[node] = len(self.order)
                self.order.append(node)
        return nodes

    def cut(self, outputs: Iterable) -> list[Scalar]:
        """Live operations when the walk stops at fixed values."""
        needed, stack = set(), [o for o in outputs if isinstance(o, Scalar)]
        while stack:
            node = stack.pop()
            if node not in needed:
                needed.add(node)
                if not node.fixed:
                    stack += [a for a in node.args if isinstance(a, Scalar)]
        return sorted(needed, key=lambda s: s.index)

    def text(self, node: Scalar) -> str:
        return f"par[{self.offset + self._slot[node]}]"

    def source(self, trace: Trace) -> str:
        """A plain function that fills the derived parameters."""
        lines = ["def derive(par):", *("    " + s for s in trace.statements(self.order))]
        lines += [f"    {self.text(node)} = v{node.index}" for node in self.order]
        return "\n".join(lines) + "\n    return par\n"
