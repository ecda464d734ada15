"""Functions on the trace: arguments, outputs, and the exact derivative, which is a function again.

A function has a trace of its own. Short ones become part of what calls them, long ones are compiled
as functions.
"""

from collections.abc import Callable, Iterable
from functools import cached_property

from clearance.machine.callback import KEEP, SLOPES, VALUE
from clearance.tracing.trace import Scalar, Trace, is_number, live

#: operations up to which a function becomes part of its callers
SHORT = 150


def counted(nodes: Iterable[Scalar]) -> int:
    """Operations of nodes, those of called functions with them."""
    return sum(
        n.args[0].operations if n.op == "call" else n.op not in ("load", "item") for n in nodes
    )


class Differentiable:
    """A function whose derivatives are made once."""

    def __init__(self, name: str):
        self.name = name
        self.values_of = None  # of a derivative: the function whose values it returns too
        self._slopes: dict[tuple[int, ...], Function] = {}

    def slopes(self, active: tuple[int, ...]) -> "Function":
        """The function that returns the values and, output by output, their derivatives by the
        active arguments.
        """
        if active not in self._slopes:
            self._slopes[active] = self._differentiated(active)
        return self._slopes[active]


class Function(Differentiable):
    """A traced function: `arguments` are the leaves of its trace, `outputs` values on it.

    name: as it stands in texts; two functions may share one. The leaves are x0, x1, ...
    """

    def __init__(
        self, name: str, trace: Trace | None = None, arguments: list[Scalar] | None = None
    ):
        super().__init__(name)
        self.trace = trace or Trace(exact=True)
        self.arguments = arguments or []
        self.outputs: list = []

    @classmethod
    def of(cls, name: str, count: int, build: Callable) -> "Function":
        """From build(trace, arguments) -> outputs."""
        function = cls(name)
        arguments = [function.argument() for _ in range(count)]
        function.outputs = list(build(function.trace, arguments))
        return function

    def argument(self) -> Scalar:
        """One more argument."""
        self.arguments.append(self.trace.load(f"x{len(self.arguments)}"))
        return self.arguments[-1]

    @property
    def count(self) -> int:
        """Number of outputs."""
        return len(self.outputs)

    def _differentiated(self, active: tuple[int, ...]) -> "Function":
        result = Function(f"{self.name}_d", self.trace, self.arguments)
        result.values_of = self
        rows = self.trace.tangent(
            self.outputs, {self.arguments[a]: {i: 1.0} for i, a in enumerate(active)}
        )
        result.outputs = [
            *self.outputs,
            *(row.get(i, 0.0) for row in rows for i in range(len(active))),
        ]
        return result

    @property
    def operations(self) -> int:
        """Operations of the values, those of called functions with them."""
        return counted(live(self.outputs))

    @cached_property
    def short(self) -> bool:
        """True where it becomes part of what calls it."""
        return self.operations <= SHORT


class SubTrace(Function):
    """A function whose arguments stand for values of the trace around it, in the order in which
    they are met.
    """

    def __init__(self, name: str):
        super().__init__(name)
        self._inner: dict[Scalar, Scalar] = {}

    def value(self, outer):
        """The argument that stands for an outer value."""
        if is_number(outer):
            return outer
        if outer not in self._inner:
            self._inner[outer] = self.argument()
        return self._inner[outer]

    @property
    def outer(self) -> list[Scalar]:
        """The outer values of the arguments that were met, behind those that were made first."""
        return list(self._inner)


class Loop(Differentiable):
    """A function that repeats a step while it is to go on: (again, state...) = step(state...,
    given...).

    It takes whether to begin, a state and what the step is given, and returns the state of the end.
    """

    def __init__(self, name: str, step: Function):
        super().__init__(name)
        self.step = step

    @property
    def count(self) -> int:
        """Number of values in the state."""
        return self.step.count - 1

    @property
    def operations(self) -> int:
        """Those of one step, which stands for more."""
        return SHORT + self.step.operations

    def _differentiated(self, active: tuple[int, ...]) -> Function:
        """A loop that carries state and derivatives."""
        step = self.step
        count = self.count
        width = len(active)
        size = len(step.arguments)
        carried = [
            [step.trace.load(f"x{size + i * width + a}") for a in range(width)]
            for i in range(count)
        ]
        seeds = {x: dict(enumerate(row)) for x, row in zip(step.arguments, carried, strict=False)}
        seeds |= {step.arguments[i - 1]: {a: 1.0} for a, i in enumerate(active) if i > count}
        rows = step.trace.tangent(step.outputs[1:], seeds)
        both = [*step.arguments[:count], *(x for row in carried for x in row)]
        wide = Function(f"{step.name}_d", step.trace, [*both, *step.arguments[count:]])
        slopes = (row.get(a, 0.0) for row in rows for a in range(width))
        wide.outputs = [*step.outputs, *slopes]

        def build(trace, arguments):
            start = [float(i + 1 == a) for i in range(count) for a in active]
            begun = arguments[: 1 + count]
            constants = arguments[1 + count :]
            return trace.call(Loop(f"{self.name}_d", wide), [*begun, *start, *constants])

        return Function.of(f"{self.name}_d", 1 + size, build)


class Opaque:
    """A plain function that cannot be traced: numba compiles it, and kernels call it by its
    address.

    shape: kinds of its arguments (see `Law.kinds`); reason: why it is not traced. derivative: a
    function of the same arguments that returns values and, output by output, derivatives by the
    leading arguments, if it brings one.
    """

    values_of, operations = None, SHORT + 1

    def __init__(
        self,
        function: Callable,
        shape: tuple,
        count: int,
        reason: str,
        derivative: "Opaque | None" = None,
    ):
        self.name, self.function, self.shape = function.__name__, function, shape
        self.count, self.reason, self.derivative = count, reason, derivative

    def slopes(self, active: tuple[int, ...]) -> Function:
        """Values and derivatives by the active arguments. Raises ValueError where the function
        brings none.
        """
        if self.derivative is None:
            raise ValueError(
                f"law {self.name} cannot be differentiated: {self.reason}; give it an attribute "
                "`slopes`, a function of the same arguments that returns values and derivatives by "
                "the leading arguments"
            )
        leading = self.derivative.count // self.count - 1

        def build(trace, arguments):
            values = trace.call(self.derivative, arguments)
            picked = [
                values[self.count + k * leading + a] for k in range(self.count) for a in active
            ]
            return [*values[: self.count], *picked]

        return Function.of(f"{self.name}_d", self.size, build)

    @property
    def size(self) -> int:
        """Number of arguments, those of named tuples one by one."""
        return self.form.count("{}")

    @property
    def form(self) -> str:
        """Arguments of the plain function, {} for each of those of the call; `par` stands for the
        parameter vector.
        """
        forms = {"data": "par", "number": "{}"}
        return ", ".join(forms.get(kind) or _form(kind) for kind in self.shape)


def _form(kind: type) -> str:
    return f"{kind.__name__}({', '.join('{}' for _ in kind._fields)})"


class Answer:
    """An answer of Python to a kernel, through a block of the parameter vector
    (machine/callback.py).

    Arguments: where the block begins, then its inputs. outputs: number of the values that are
    needed;
    by: the inputs of the derivatives. With `keep` the block is to remember its inputs and gives
    zeros.
    """

    operations = SHORT + 1
    values_of = None
    name = "answered"

    def __init__(self, inputs: int, outputs: int, keep: bool = False, by: tuple[int, ...] = ()):
        self.inputs, self.outputs, self.keep, self.by = inputs, outputs, keep, by

    @property
    def count(self) -> int:
        """Number of values."""
        return self.outputs * (1 + len(self.by))

    @property
    def wanted(self) -> float:
        """Code of the request: values, derivatives too, or to remember."""
        return KEEP if self.keep else SLOPES if self.by else VALUE

    @property
    def places(self) -> list[int]:
        """Places of the values in the block."""
        begin, width = 2 + self.inputs, 1 + self.inputs
        values = [begin + k * width for k in range(self.outputs)]
        return values + [value + 1 + i for value in values for i in self.by]

    def slopes(self, active: tuple[int, ...]) -> "Answer":
        """Values and derivatives by the active arguments."""
        answer = Answer(self.inputs, self.outputs, self.keep, tuple(a - 1 for a in active))
        answer.values_of = self
        return answer


# --- one trace of everything
class Expansion:
    """Copies values to a trace of its own; functions that are short become part of it."""

    def __init__(self):
        self.trace = Trace(exact=True)
        self._functions: dict[object, object] = {}

    def of(self, outputs: list) -> list:
        """Outputs of another trace on this one."""
        return self._copied(outputs, self.trace, {})

    def _copied(self, outputs: list, trace: Trace, copies: dict) -> list:
        outer = trace.section
        nodes = live(outputs, copies.__contains__)
        calls = [n for n in nodes if n.op == "call"]
        wider = {(n.args[0].values_of, *n.args[1:]): n for n in calls}  # returns these values too
        for node in nodes:
            if node in copies:
                continue
            trace.section = node.section or outer
            args = [copies[a] if isinstance(a, Scalar) else a for a in node.args]
            if node.op == "item":
                copies[node] = args[0][args[1]]
            elif node.op == "call":
                same = [node]
                while same[-1].args in wider:
                    same.append(wider[same[-1].args])
                values = self._called(self.function(same[-1].args[0]), args[1:], trace)
                copies |= dict.fromkeys(same, values)
            else:
                copies[node] = trace.operation(node.op, *args)
        trace.section = outer
        return [copies[o] if isinstance(o, Scalar) else o for o in outputs]

    def _called(self, function, args: list, trace: Trace) -> list:
        if not (isinstance(function, Function) and function.short):
            return trace.call(function, args)
        section = trace.section
        if trace is self.trace:  # texts mark which law begins here
            trace.section = f"{section}: {function.name}"
        values = self._copied(
            function.outputs, trace, dict(zip(function.arguments, args, strict=True))
        )
        trace.section = section
        return values

    def function(self, function):
        """A function with everything short that it calls inside it."""
        if isinstance(function, Opaque | Answer):
            return function
        if function not in self._functions:
            if isinstance(function, Loop):
                result = Loop(function.name, self.function(function.step))
            else:
                result = Function(function.name)
                arguments = [result.argument() for _ in function.arguments]
                leaves = dict(zip(function.arguments, arguments, strict=True))
                result.outputs = self._copied(function.outputs, result.trace, leaves)
            result.values_of = function.values_of and self.function(function.values_of)
            self._functions[function] = result
        return self._functions[function]
