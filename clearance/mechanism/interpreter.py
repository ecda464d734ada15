"""Plain functions executed on traced scalars: a law stays the function that its author wrote.

The source is read, not the name: arithmetic, `math`, abs, max, min, if, for, while and helper
functions. Branches become selects, a loop over a range is unrolled, and a loop that ends by a
condition stays one. Numbers of the function's module or closure are taken as they stand. The sign
of a zero is not kept, and a product with a constant zero is zero.
"""

import ast
import builtins
import inspect
import math
import textwrap
from collections import namedtuple
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from types import ModuleType

from clearance.mechanism.asking import KEEP
from clearance.mechanism.function import Answer, Function, Inside, Loop, Opaque
from clearance.mechanism.trace import COMPARISONS, FLAT, UNARY, Scalar, Trace, defined, is_number

UNSET = object()  # in place of a variable that a side has not set
BINARY = ("atan2", "hypot", "copysign", "pow", "fmod")
UNROLLED = 64  # passes of a loop over a range that are written out
COUNTER, STOP = (
    "<counter>",
    "<stop>",
)  # variables of a counted loop, under names that no function has
OPERATORS = {"Lt": "lt", "LtE": "le", "Gt": "gt", "GtE": "ge", "Eq": "eq", "NotEq": "ne"}
assert set(OPERATORS.values()) == set(COMPARISONS)

Data = namedtuple("Data", "")  # stands for the parameter vector, which laws with data read
DATA = Data()


class Untraceable(ValueError):
    """A construct that cannot be traced, in words."""


def traced(function: Callable, shape: tuple = ()) -> Function | Opaque:
    """A plain function on the trace.

    shape: of each argument "number", "data" (the parameter vector) or a named tuple type; default:
    numbers. Raises ValueError naming the function for what is not allowed in one.
    """
    tree = definition(function)
    shape = shape or ("number",) * len(tree.args.args)
    made = Function(_name(function))
    arguments = []
    for kind in shape:
        if kind == "data":
            arguments.append(DATA)
        elif kind == "number":
            arguments.append(made.argument())
        else:
            arguments.append(kind(*(made.argument() for _ in kind._fields)))
    try:
        made.outputs = list(Execution(made.trace, function).call(arguments))
    except Untraceable as reason:
        return _opaque(function, shape, str(reason))
    except (TypeError, AttributeError, IndexError, KeyError, ArithmeticError) as reason:
        raise ValueError(f"law {function.__name__} cannot be read: {reason}") from reason
    return made


def _opaque(function: Callable, shape: tuple, reason: str) -> Opaque:
    """A function that numba compiles, with the derivative that it brings."""
    slopes = getattr(function, "slopes", None)
    return Opaque(
        function, shape, outputs_of(function), reason, slopes and _opaque(slopes, shape, reason)
    )


def definition(function: Callable) -> ast.FunctionDef:
    """The syntax tree of a function."""
    name = getattr(function, "__name__", repr(function))
    if hasattr(function, "__wrapped__"):
        raise ValueError(f"law {name}: a decorator wraps it, so its source is not what runs; leave it out")
    try:
        node = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError):
        raise ValueError(
            f"law {name}: no source found; define it with def in a file, not at a prompt"
        ) from None
    if (
        not isinstance(node, ast.FunctionDef)
        or node.args.vararg
        or node.args.kwarg
        or node.args.kwonlyargs
    ):
        raise ValueError(f"law {name} must be a function defined with def and plain arguments")
    return node


def outputs_of(function: Callable) -> int:
    """Number of values that a function returns, by its source."""
    returned = [n.value for n in ast.walk(definition(function)) if isinstance(n, ast.Return)]
    return max((_count(function, value) for value in returned), default=0)


def _count(function: Callable, value: ast.expr | None) -> int:
    if isinstance(value, ast.Tuple):
        return len(value.elts)
    called = function.__globals__.get(value.func.id) if _is_call(value) else None
    return outputs_of(called) if inspect.isfunction(called) and called is not function else 1


def _is_call(value: ast.expr | None) -> bool:
    return isinstance(value, ast.Call) and isinstance(value.func, ast.Name)


def fingerprint(function: Callable) -> tuple:
    """Equal for functions that do the same: their code and the numbers and functions they read from
    outside.
    """
    outer = {**function.__globals__, **inspect.getclosurevars(function).nonlocals}
    code, read = function.__code__, []
    for name in (*code.co_names, *code.co_freevars):
        value = getattr(outer.get(name), "function", outer.get(name))
        if inspect.isfunction(value):
            read.append((name, fingerprint(value) if value is not function else None))
        elif _is_array(value):
            read.append((name, value.shape, value.tobytes()))
        elif isinstance(value, int | float) or hasattr(value, "__float__"):
            read.append((name, float(value)))
        elif isinstance(value, tuple):
            read.append((name, value))
    return code, tuple(read)


def _is_array(value) -> bool:
    return isinstance(getattr(value, "ndim", None), int) and value.ndim > 0


def _name(function: Callable) -> str:
    return function.__name__.lstrip("_") or "law"


@dataclass(frozen=True)
class Counted:
    """A range whose values are counted as the loop goes."""

    start: object
    stop: object
    step: int


@dataclass
class Exit:
    """A way out of a block: "return", "break" or "continue", where the condition holds and no
    earlier one did.
    """

    kind: str
    condition: object
    payload: object  # values returned, or the variables


@dataclass
class Execution:
    """One function's statements, executed on a trace. helpers: functions that have been traced for
    their calls.
    """

    trace: Trace
    function: Callable
    helpers: dict = field(default_factory=dict)
    callers: tuple = ()

    def __post_init__(self):
        closure = inspect.getclosurevars(self.function).nonlocals
        self.outer = {**self.function.__globals__, **closure}
        self.tree = definition(self.function)
        stored = (n for n in ast.walk(self.tree) if isinstance(n, ast.Name))
        self.local = {n.id for n in stored if isinstance(n.ctx, ast.Store)}

    @property
    def name(self) -> str:
        return self.function.__name__

    def call(self, arguments: list) -> tuple:
        """The values that the function returns."""
        names = [a.arg for a in self.tree.args.args]
        exits: list[Exit] = []
        end = self.block(self.tree.body, dict(zip(names, arguments, strict=True)), exits)
        if end is not None or not exits:
            raise ValueError(f"law {self.name} can end without returning a value")
        values = [e.payload for e in exits]
        if any(not isinstance(v, bool | int | float | Scalar) for row in values for v in row):
            raise ValueError(f"law {self.name} must return numbers, or one tuple of numbers")
        if len({len(v) for v in values}) != 1 or not values[0]:
            raise ValueError(f"law {self.name} must return the same number of values everywhere")
        return tuple(map(self.trace.number, self._chosen(exits)))

    def _chosen(self, exits: list[Exit]) -> tuple:
        """Values of the first exit that is taken; one of them is."""
        *before, last = exits
        values = last.payload
        for one in reversed(before):
            values = self.select(one.condition, one.payload, values)
        return values

    def select(self, condition, a, b):
        """a where the condition holds, else b, for tuples value by value."""
        if is_number(condition):
            return a if condition else b
        if isinstance(a, tuple):
            return _like(a, [self.select(condition, x, y) for x, y in zip(a, b, strict=True)])
        return self.trace.select(condition, a, b)

    def unreadable(self, node) -> ValueError:
        return ValueError(f"law {self.name}: cannot read {ast.unparse(node)!r}")

    # --- statements: each returns the variables behind it, None where nothing comes behind it
    def block(self, body: list, variables: dict, exits: list[Exit]) -> dict | None:
        """Execute statements on a copy of the variables."""
        variables = dict(variables)
        for statement in body:
            handler = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if handler is None:
                raise self.unreadable(statement)
            variables = handler(statement, variables, exits)
            if variables is None:
                return None
        return variables

    def _pass(self, node, variables, exits):
        return variables

    def _expr(self, node, variables, exits):
        if isinstance(node.value, ast.Constant):
            return variables
        if isinstance(node.value, ast.Call):
            raise Untraceable(f"it calls {ast.unparse(node.value.func)} for what that does")
        raise self.unreadable(node)

    def _assign(self, node, variables, exits):
        value = self.value(node.value, variables)
        for target in node.targets:
            self._bind(target, value, variables)
        return variables

    def _annassign(self, node, variables, exits):
        self._bind(node.target, self.value(node.value, variables), variables)
        return variables

    def _augassign(self, node, variables, exits):
        if not isinstance(node.target, ast.Name):
            raise Untraceable(f"it changes {ast.unparse(node.target)}")
        value = ast.BinOp(ast.Name(node.target.id, ast.Load()), node.op, node.value)
        self._bind(node.target, self.value(value, variables), variables)
        return variables

    def _bind(self, target, value, variables) -> None:
        if isinstance(target, ast.Subscript):
            raise Untraceable(f"it writes to {ast.unparse(target)}")
        if isinstance(target, ast.Name):
            variables[target.id] = value
        elif isinstance(target, ast.Tuple) and isinstance(value, tuple):
            for part, one in zip(target.elts, value, strict=True):
                self._bind(part, one, variables)
        else:
            raise self.unreadable(target)

    def _return(self, node, variables, exits):
        value = () if node.value is None else self.value(node.value, variables)
        exits.append(Exit("return", True, value if isinstance(value, tuple) else (value,)))

    def _break(self, node, variables, exits):
        exits.append(Exit("break", True, variables))

    def _continue(self, node, variables, exits):
        exits.append(Exit("continue", True, variables))

    def _if(self, node, variables, exits):
        condition = self.condition(node.test, variables)
        if is_number(condition):
            return self.block(node.body if condition else node.orelse, variables, exits)
        ends = []
        for body, holds in ((node.body, condition), (node.orelse, self.trace.negation(condition))):
            inside: list[Exit] = []
            end = self.block(body, variables, inside)
            ends.append(end)
            if end is None and {e.kind for e in inside} == {"return"}:
                inside = [Exit("return", True, self._chosen(inside))]
            exits += [Exit(e.kind, self.trace.both(holds, e.condition), e.payload) for e in inside]
        first, second = ends
        if first is None or second is None:
            return second if first is None else first
        return self._merged(condition, first, second)

    def _merged(self, condition, first: dict, second: dict) -> dict:
        """Variables of the first where the condition holds; not a number where a side has not set one."""
        merged = {}
        for name in first | second:
            a, b = first.get(name, UNSET), second.get(name, UNSET)
            if a is UNSET or b is UNSET:
                value = b if a is UNSET else a
                unset = _mapped(value, lambda v: math.nan) if isinstance(value, tuple) else math.nan
                a, b = (unset, value) if a is UNSET else (value, unset)
            merged[name] = a if a is b else self.select(condition, a, b)
        return merged

    def _for(self, node, variables, exits):
        if node.orelse or not isinstance(node.target, ast.Name):
            raise self.unreadable(node)
        passes = self._passes(node.iter, variables)
        if isinstance(passes, Counted):
            return self._counted(node, passes, variables)
        left: list[Exit] = []  # ways out of the loop
        for value in passes:
            variables[node.target.id] = value
            inside: list[Exit] = []
            end = self.block(node.body, variables, inside)
            variables = self._gone_on(end, inside, left)
            if variables is None:
                break
        return self._left(variables, left, exits)

    def _passes(self, node, variables):
        """The values that a loop goes through; those of a range that is not fixed, or long, are
        counted.
        """
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "range"
        ):
            bounds = [self.value(a, variables) for a in node.args]
            start, stop, step = (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1)[:3]
            if not is_number(step):
                raise Untraceable(f"the step of {ast.unparse(node)} is not fixed")
            if is_number(start) and is_number(stop) and len(range(start, stop, step)) <= UNROLLED:
                return range(start, stop, step)
            return Counted(start, stop, step)
        values = self.value(node, variables)
        if isinstance(values, tuple):
            return values
        raise self.unreadable(node)

    def _counted(self, node, counted: "Counted", variables: dict) -> dict:
        """A loop over a range as one that ends by a condition."""
        name = node.target.id
        variables = {name: counted.start} | variables | {COUNTER: counted.start, STOP: counted.stop}
        target, counter = ast.Name(name, ast.Store()), ast.Name(COUNTER, ast.Load())
        order = ast.Lt() if counted.step > 0 else ast.Gt()
        test = ast.Compare(counter, [order], [ast.Name(STOP, ast.Load())])
        onward = ast.AugAssign(
            ast.Name(COUNTER, ast.Store()), ast.Add(), ast.Constant(counted.step)
        )
        body = [ast.Assign([target], counter), onward, *node.body]
        return self._while(ast.While(test, body, []), variables, [])

    def _gone_on(self, end: dict | None, inside: list[Exit], left: list[Exit]) -> dict | None:
        """The variables that the next pass begins with; ways out of the loop are noted."""
        skipped = False
        for one in inside:
            if one.kind == "continue":
                skipped = self.trace.either(skipped, one.condition)
            else:
                alone = self.trace.both(one.condition, self.trace.negation(skipped))
                left.append(Exit(one.kind, alone, one.payload))
        for one in reversed([e for e in inside if e.kind == "continue"]):
            end = one.payload if end is None else self._merged(one.condition, one.payload, end)
        return end

    def _left(self, end: dict | None, left: list[Exit], exits: list[Exit]) -> dict | None:
        """The variables behind a loop; what returns from inside it is noted."""
        ended = False
        for one in left:
            if one.kind == "break":
                ended = self.trace.either(ended, one.condition)
            else:
                exits.append(
                    Exit(
                        "return",
                        self.trace.both(one.condition, self.trace.negation(ended)),
                        one.payload,
                    )
                )
        for one in reversed([e for e in left if e.kind == "break"]):
            end = one.payload if end is None else self._merged(one.condition, one.payload, end)
        return end

    def _while(self, node, variables, exits):
        """A loop on the trace: the variables that its body sets are its state."""
        if node.orelse:
            raise self.unreadable(node)
        enter = self.condition(node.test, variables)
        if is_number(enter) and not enter:
            return variables
        stored = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        names = sorted(stored)
        step = Inside(f"{_name(self.function)}_step")
        state = {n: step.argument() for n in names}
        inner = Execution(step.trace, self.function, self.helpers, self.callers)
        inside: list[Exit] = []
        begun = {n: _mapped(v, step.value) for n, v in variables.items() if n not in state} | state
        left: list[Exit] = []
        end = inner._gone_on(inner.block(node.body, begun, inside), inside, left)
        if any(e.kind == "return" for e in left):
            raise Untraceable("it returns from inside a loop that ends by a condition")
        again = False if end is None else inner.condition(node.test, end)
        for one in left:
            again = inner.trace.both(again, inner.trace.negation(one.condition))
        end = inner._left(end, left, [])
        step.outputs = [again, *(inner.trace.number(self._number(end.get(n, math.nan))) for n in names)]
        start = [self._number(variables.get(n, math.nan)) for n in names]
        loop = Loop(f"{_name(self.function)}_loop", step)
        values = self.trace.call(loop, [enter, *start, *step.outer])
        return variables | dict(zip(names, values, strict=True))

    def _number(self, value):
        if isinstance(value, Scalar | int | float):
            return value
        raise Untraceable("a loop that ends by a condition carries more than numbers")

    # --- expressions
    def condition(self, node, variables):
        """A test: a truth value, where numbers are true unless they are zero."""
        if isinstance(node, ast.BoolOp):
            join = self.trace.both if isinstance(node.op, ast.And) else self.trace.either
            result = isinstance(node.op, ast.And)
            for part in node.values:
                result = join(result, self.condition(part, variables))
            return result
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self.trace.negation(self.condition(node.operand, variables))
        return self.trace.truth(self.value(node, variables))

    def value(self, node, variables):
        """Number, traced value, tuple, or a function to be called."""
        handler = getattr(self, f"_of_{type(node).__name__.lower()}", None)
        if handler is None:
            raise self.unreadable(node)
        return handler(node, variables)

    def _of_constant(self, node, variables):
        if isinstance(node.value, int | float):
            return node.value
        raise self.unreadable(node)

    def _of_name(self, node, variables):
        if node.id in variables:
            return variables[node.id]
        if node.id in self.local:
            raise ValueError(f"law {self.name} reads {node.id!r} before it is set")
        value = self.outer.get(node.id, getattr(builtins, node.id, None))
        value = getattr(value, "function", value)
        if isinstance(value, ModuleType) and value is not math or _is_array(value):
            raise Untraceable(f"it uses {node.id}")
        if value is math or inspect.isfunction(value) or isinstance(value, int | float | tuple):
            return value
        if value in BUILTINS or hasattr(value, "py_func"):
            return value
        if value is not None and getattr(math, getattr(value, "__name__", ""), None) is value:
            return value
        if hasattr(value, "__float__"):
            return float(value)
        raise ValueError(
            f"law {self.name} uses {node.id!r}: only arguments, numbers, tuples of numbers, math and "
            "plain functions are allowed"
        )

    def _of_tuple(self, node, variables):
        return tuple(self.value(e, variables) for e in node.elts)

    def _of_attribute(self, node, variables):
        value = self.value(node.value, variables)
        if value is math or node.attr in getattr(value, "_fields", ()):
            return getattr(value, node.attr)
        raise self.unreadable(node)

    def _of_subscript(self, node, variables):
        values, index = self.value(node.value, variables), self.value(node.slice, variables)
        if values is DATA:
            return self.trace.lookup(index)
        if isinstance(values, tuple) and is_number(index):
            return values[index]
        raise Untraceable(f"it picks {ast.unparse(node)} by a number that is not fixed")

    def _of_unaryop(self, node, variables):
        value = self.value(node.operand, variables)
        if isinstance(node.op, ast.Not):
            return self.trace.negation(self.trace.truth(value))
        if isinstance(node.op, ast.USub):
            return self.trace.neg(value)
        if isinstance(node.op, ast.UAdd):
            return value
        raise self.unreadable(node)

    def _of_binop(self, node, variables):
        a, b = self.value(node.left, variables), self.value(node.right, variables)
        trace, op = self.trace, type(node.op).__name__
        if op in ("Add", "Sub", "Div"):
            return getattr(trace, op.lower())(a, b)
        if op == "Mult":
            return trace.mul(a, b)
        if op == "Pow":
            return trace.power(a, b)
        if op in ("Mod", "FloorDiv"):
            if is_number(a) and is_number(b):
                return a % b if op == "Mod" else a // b
            return self._remainder(a, b) if op == "Mod" else self._quotient(a, b)
        raise self.unreadable(node)

    def _remainder(self, a, b):
        """a % b, which has the sign of b."""
        trace, rest = self.trace, self.trace.binary("fmod", a, b)
        other = trace.both(trace.compare("ne", rest, 0.0), trace.compare("lt", trace.mul(rest, b), 0.0))
        return trace.select(other, trace.add(rest, b), rest)

    def _quotient(self, a, b):
        """a // b: whole, as far as the remainder leaves it."""
        trace = self.trace
        whole = trace.div(trace.sub(a, self._remainder(a, b)), b)
        return trace.function("floor", trace.add(whole, 0.5))

    def _of_compare(self, node, variables):
        values = [self.value(n, variables) for n in (node.left, *node.comparators)]
        result = True
        for op, a, b in zip(node.ops, values[:-1], values[1:], strict=True):
            if type(op).__name__ not in OPERATORS:
                raise self.unreadable(node)
            result = self.trace.both(result, self.trace.compare(OPERATORS[type(op).__name__], a, b))
        return result

    def _of_boolop(self, node, variables):
        for part in node.values:
            value = self.value(part, variables)
            if not (isinstance(value, bool) or isinstance(value, Scalar) and value.boolean):
                raise self.unreadable(node)
        return self.condition(node, variables)

    def _of_ifexp(self, node, variables):
        condition = self.condition(node.test, variables)
        if is_number(condition):
            return self.value(node.body if condition else node.orelse, variables)
        return self.select(
            condition, self.value(node.body, variables), self.value(node.orelse, variables)
        )

    def _of_call(self, node, variables):
        if node.keywords:
            raise self.unreadable(node)
        function = self.value(node.func, variables)
        arguments = [self.value(a, variables) for a in node.args]
        if isinstance(function, type) and function not in BUILTINS or not callable(function):
            raise self.unreadable(node)
        if hasattr(function, "py_func"):
            raise Untraceable(f"it calls compiled code, {function.__name__}")
        if getattr(function, "answers", False):
            return self._answered(*arguments)
        if inspect.isfunction(function):
            return self._helped(function, arguments)
        try:
            return self._built_in(function.__name__, arguments)
        except KeyError:
            raise self.unreadable(node) from None

    def _built_in(self, name: str, arguments: list):
        trace = self.trace
        if all(is_number(a) for a in arguments):
            return defined(getattr(math, name, None) or getattr(builtins, name), *arguments)
        if name in ("max", "min"):
            value = arguments[0]
            for other in arguments[1:]:
                value = trace.select(trace.compare("gt" if name == "max" else "lt", other, value), other, value)
            return value
        if name in BINARY:
            return trace.power(*arguments) if name == "pow" else trace.binary(name, *arguments)
        if name == "log" and len(arguments) == 2:
            x, base = (trace.function("log", a) for a in arguments)
            return trace.div(x, base)
        (x,) = arguments
        if name == "float":
            return trace.numeric(x)
        name = {"abs": "fabs", "int": "trunc"}.get(name, name)
        if name in UNARY or name in FLAT:
            return trace.function(name, trace.numeric(x))
        raise KeyError(name)

    def _answered(self, data, start, wanted: float, inputs: tuple, outputs: int) -> tuple:
        answer = Answer(len(inputs), outputs, wanted == KEEP)
        return tuple(self.trace.call(answer, [start, *inputs]))

    def _helped(self, function: Callable, arguments: list):
        """A helper's values: it is a function of its traced arguments, the others are what they
        are.
        """
        if function in self.callers:
            raise ValueError(
                f"law {self.name} calls itself (through {function.__name__}); write a loop"
            )
        if all(_fixed(a) for a in arguments):
            with suppress(ArithmeticError, ValueError):  # of a side that a condition may leave out
                return function(*arguments)
        key = function, repr([_mapped(a, lambda v: None) for a in arguments])
        if key not in self.helpers:
            self.helpers[key] = self._traced(function, arguments)
        helper, single = self.helpers[key]
        values = tuple(self.trace.call(helper, [v for a in arguments for v in _scalars(a)]))
        return values[0] if single else values

    def _traced(self, function: Callable, arguments: list) -> tuple[Function, bool]:
        made = Function(_name(function))
        inner = Execution(made.trace, function, self.helpers, (*self.callers, self.function))
        made.outputs = list(inner.call([_mapped(a, lambda v: made.argument()) for a in arguments]))
        returned = [n.value for n in ast.walk(inner.tree) if isinstance(n, ast.Return)]
        return made, len(made.outputs) == 1 and not any(isinstance(v, ast.Tuple) for v in returned)


BUILTINS = (abs, max, min, float, int, pow, range)


def _like(value: tuple, parts: list) -> tuple:
    """A tuple of the same kind with other parts."""
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


def _mapped(value, change: Callable):
    """A value with every traced part replaced."""
    if isinstance(value, tuple) and value is not DATA:
        return _like(value, [_mapped(v, change) for v in value])
    return change(value) if isinstance(value, Scalar) else value


def _scalars(value) -> list[Scalar]:
    """The traced parts of a value."""
    if isinstance(value, tuple):
        return [s for v in value for s in _scalars(v)]
    return [value] if isinstance(value, Scalar) else []


def _fixed(value) -> bool:
    return value is not DATA and not _scalars(value) and not inspect.isfunction(value)
