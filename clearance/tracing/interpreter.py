"""Plain functions executed on traced scalars: a law stays the function that its author wrote.

Python evaluates the expressions, with operators and calls as operations of the trace. Branches
become selects, a loop over a range is unrolled, and a loop that ends by a condition stays one.
Numbers of the function's module or closure are taken as they stand. The sign of a zero may change,
and a product with a constant zero is zero.
"""

import ast
import builtins
import copy
import inspect
import math
import operator
import textwrap
from collections import namedtuple
from collections.abc import Callable
from contextlib import suppress
from functools import partial, reduce
from types import CodeType, ModuleType
from typing import ClassVar

from clearance.files.sealed import parsed
from clearance.machine.callback import KEEP
from clearance.tracing.function import Answer, Function, Loop, Opaque, SubTrace
from clearance.tracing.trace import (
    BINARY,
    COMPARISONS,
    FLAT,
    UNARY,
    Scalar,
    Trace,
    defined,
    is_number,
)

UNSET = object()  # in place of a variable that a side has not set
UNROLLED = 64  # passes of a loop over a range that are written out
COUNTER, STOP = "<counter>", "<stop>"  # variables of a counted loop, by names that no law has
BUILTINS = (abs, max, min, float, int, bool, pow, round, range)
EXPRESSIONS = (ast.Name, ast.Load, ast.Constant, ast.Tuple, ast.Attribute, ast.Call, ast.keyword)
EXPRESSIONS += (ast.Lambda, ast.arguments)  # of conditional expressions

DATA = object()  # stands for the parameter vector, which laws with data read


def _remainder(trace: Trace, a, b):
    """a % b, which has the sign of b."""
    if is_number(a) and is_number(b):
        return defined(operator.mod, a, b)
    rest = trace.binary("fmod", a, b)
    flip = trace.both(trace.compare("ne", rest, 0.0), trace.compare("lt", trace.mul(rest, b), 0.0))
    return trace.select(flip, trace.add(rest, b), rest)


def _quotient(trace: Trace, a, b):
    """a // b, an integer as far as the remainder leaves it."""
    if is_number(a) and is_number(b):
        return defined(operator.floordiv, a, b)
    quotient = trace.div(trace.sub(a, _remainder(trace, a, b)), b)
    return trace.function("floor", trace.add(quotient, 0.5))


def _logical(*values) -> bool:
    return all(v.boolean if isinstance(v, Scalar) else isinstance(v, bool) for v in values)


def _and(trace: Trace, a, b):
    return trace.both(a, b) if _logical(a, b) else trace.select(trace.truth(a), b, a)


def _or(trace: Trace, a, b):
    return trace.either(a, b) if _logical(a, b) else trace.select(trace.truth(a), a, b)


def _extreme(name: str) -> Callable:
    def extreme(trace: Trace, value, *others):
        value, *others = (value, *others) if others else value
        for rival in others:
            value = trace.select(trace.compare(name, rival, value), rival, value)
        return value

    return extreme


def _logarithm(trace: Trace, x, *base):
    x, *base = (trace.function("log", a) for a in (x, *base))
    return trace.div(x, *base) if base else x


#: operators of the syntax and functions whose operations have another name
NAMES = {"Add": "add", "Sub": "sub", "Mult": "mul", "Div": "div", "Pow": "pow", "USub": "neg"}
NAMES |= {"abs": "fabs", "int": "trunc"}
NAMES |= dict(zip(("Lt", "LtE", "Gt", "GtE", "Eq", "NotEq"), COMPARISONS, strict=True))
#: what several operations make
FORMULAS: dict[str, Callable] = {
    "Mod": _remainder,
    "FloorDiv": _quotient,
    "UAdd": Trace.numeric,
    "Not": lambda trace, a: trace.negation(trace.truth(a)),
    "And": _and,
    "Or": _or,
    "max": _extreme("gt"),
    "min": _extreme("lt"),
    "float": Trace.numeric,
    "bool": Trace.truth,
    "hypot": lambda trace, *sides: reduce(partial(trace.binary, "hypot"), sides, 0.0),
    "log": _logarithm,
    "log10": lambda trace, x: _logarithm(trace, x, 10.0),
    "log2": lambda trace, x: _logarithm(trace, x, 2.0),
    "degrees": lambda trace, x: trace.mul(x, math.degrees(1.0)),
    "radians": lambda trace, x: trace.mul(x, math.radians(1.0)),
}
OPERATIONS = {*NAMES, *UNARY, *FLAT, *BINARY}


class Untraceable(ValueError):
    """A construct that cannot be traced, in words."""


class Unsupported(Exception):
    """An expression that no law may have."""


def traced(function: Callable, shape: tuple = ()) -> Function | Opaque:
    """A plain function on the trace.

    shape: of each argument "number", "data" (the parameter vector) or a named tuple type; default:
    numbers. Raises ValueError naming the function for what is not allowed in one.
    """
    result = Function(_name(function))
    execution = Execution(result.trace, function, {})
    shape = shape or ("number",) * len(execution.arguments)
    arguments = []
    for kind in shape:
        if kind == "data":
            arguments.append(DATA)
        elif kind == "number":
            arguments.append(result.argument())
        else:
            arguments.append(kind(*(result.argument() for _ in kind._fields)))
    try:
        result.outputs = list(execution.returned(arguments))
    except Untraceable as reason:
        return _opaque(function, shape, str(reason))
    except (TypeError, AttributeError, IndexError, KeyError, ArithmeticError) as reason:
        raise ValueError(f"law {function.__name__} cannot be read: {reason}") from reason
    return result


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
        raise ValueError(
            f"law {name}: a decorator wraps it, so its source is not what runs; leave it out"
        )
    try:
        node = parsed(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError):
        raise ValueError(
            f"law {name}: no source found; define it with def in a file, not at a prompt"
        ) from None
    if not isinstance(node, ast.FunctionDef) or node.args.vararg or node.args.kwarg:
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
    code = function.__code__
    read = []
    inside = function.__globals__
    if code.co_freevars:
        inside = inside | inspect.getclosurevars(function).nonlocals
    for name in (*names_in(code), *code.co_freevars):
        value = inside.get(name)
        value = getattr(value, "function", value)
        if inspect.isfunction(value):
            read.append((name, fingerprint(value) if value is not function else None))
        elif _is_array(value):
            read.append((name, value.shape, value.tobytes()))
        elif isinstance(value, int | float) or hasattr(value, "__float__"):
            read.append((name, float(value)))
        elif isinstance(value, tuple):
            read.append((name, value))
    return code, tuple(read)


def names_in(code: CodeType) -> list[str]:
    """Names of globals and attributes that code reads, with those of functions inside it."""
    inside = [c for c in code.co_consts if isinstance(c, CodeType)]
    return [*code.co_names, *(name for nested in inside for name in names_in(nested))]


def _is_array(value) -> bool:
    return isinstance(getattr(value, "ndim", None), int) and value.ndim > 0


def _name(function: Callable) -> str:
    return function.__name__.lstrip("_") or "law"


#: a range whose values are counted as the loop goes
Counted = namedtuple("Counted", "start stop step")
#: a way out of a block: "return", "break" or "continue", where the condition holds and no earlier
#: one did; payload: values returned, or the variables
Exit = namedtuple("Exit", "kind condition payload")


def _called(name: str, *arguments: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(f"<{name}>", ast.Load()), list(arguments), [])


def _operated(operator: ast.AST, *operands: ast.expr) -> ast.Call:
    return _called("operation", ast.Constant(type(operator).__name__), *operands)


def _later(value: ast.expr) -> ast.Lambda:
    return ast.Lambda(ast.arguments([], [], None, [], [], None, []), value)


def _compared(node: ast.Compare) -> ast.expr:
    parts = map(_operated, node.ops, [node.left, *node.comparators], node.comparators)
    return reduce(partial(_operated, ast.And()), parts)


def _changed(node: ast.AugAssign) -> ast.Assign:
    before = parsed(ast.unparse(node.target)).body[0].value
    return ast.Assign([node.target], _operated(node.op, before, node.value))


class Calls(ast.NodeTransformer):
    """Makes calls of `Execution` of all that Python would compute itself."""

    MADE: ClassVar = {
        ast.BinOp: lambda n: _operated(n.op, n.left, n.right),
        ast.UnaryOp: lambda n: _operated(n.op, n.operand),
        ast.BoolOp: lambda n: reduce(partial(_operated, n.op), n.values),
        ast.Compare: _compared,
        ast.IfExp: lambda n: _called("choice", n.test, _later(n.body), _later(n.orelse)),
        ast.Call: lambda n: ast.Call(_called("call").func, [n.func, *n.args], n.keywords),
        ast.Subscript: lambda n: _called("item", n.value, n.slice) if _read(n) else n,
        ast.List: lambda n: ast.Tuple(n.elts, n.ctx),
        ast.AugAssign: _changed,
        ast.AnnAssign: lambda n: ast.Assign([n.target], n.value),
    }

    def generic_visit(self, node):
        """Parts first."""
        make = self.MADE.get(type(node), lambda n: n)
        return ast.copy_location(make(super().generic_visit(node)), node)


def _read(node: ast.expr) -> bool:
    return isinstance(node.ctx, ast.Load)


_trees: dict[CodeType, ast.FunctionDef] = {}


def calls_of(function: Callable) -> ast.FunctionDef:
    """The syntax tree of a function as `Calls` makes it, once for all functions of one text."""
    code = function.__code__
    if code not in _trees:
        _trees[code] = Calls().visit(definition(function))
    return _trees[code]


class Execution:
    """One function's statements, executed on a trace. helpers: functions that have been traced for
    their calls; callers: those that it is executed for.
    """

    def __init__(self, trace: Trace, function: Callable, helpers: dict, callers: tuple = ()):
        self.trace, self.function, self.helpers, self.callers = trace, function, helpers, callers
        self.tree = calls_of(function)
        closure = inspect.getclosurevars(function).nonlocals
        self.outer = {**vars(builtins), **function.__globals__, **closure}
        self.arguments = list(inspect.signature(function).parameters)
        self.local = {*self.arguments, *_set(self.tree)}
        self.codes: dict[ast.expr, tuple] = {}  # of expressions, with the names from outside

    @property
    def name(self) -> str:
        return self.function.__name__

    def returned(self, arguments: list) -> tuple:
        """The values that the function returns."""
        exits: list[Exit] = []
        variables = dict(zip(self.arguments, arguments, strict=True))
        end = self.block(self.tree.body, variables, exits)
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
        for way in reversed(before):
            values = self.select(way.condition, way.payload, values)
        return values

    def select(self, condition, a, b):
        """a where the condition holds, else b, for tuples value by value."""
        if is_number(condition):
            return a if condition else b
        if isinstance(a, tuple):
            return _like(a, [self.select(condition, x, y) for x, y in zip(a, b, strict=True)])
        return self.trace.select(condition, a, b)

    def unreadable(self, node) -> ValueError:
        return ValueError(f"law {self.name}: cannot read {_source(node, self.function)!r}")

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
        raise Untraceable(f"it has {_source(node, self.function)} for what that does")

    def _assign(self, node, variables, exits):
        value = self.value(node.value, variables)
        for target in node.targets:
            self._bind(target, value, variables)
        return variables

    def _bind(self, target, value, variables) -> None:
        if isinstance(target, ast.Subscript):
            raise Untraceable(f"it writes to {_source(target, self.function)}")
        if isinstance(target, ast.Name):
            variables[target.id] = value
        elif _fits(target, value):
            for part, element in zip(target.elts, value, strict=True):
                self._bind(part, element, variables)
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
        return self._merged(condition, *ends)

    def _merged(self, condition, first: dict | None, second: dict | None) -> dict | None:
        """Variables of the first where the condition holds; not a number where a side has not set
        one. None of a side that nothing comes behind.
        """
        if first is None or second is None:
            return second if first is None else first
        merged = {}
        for name in first | second:
            a, b = (side.get(name, UNSET) for side in (first, second))
            a, b = _unset(b) if a is UNSET else a, _unset(a) if b is UNSET else b
            merged[name] = a if a is b else self.select(condition, a, b)
        return merged

    def _for(self, node, variables, exits):
        self._plain(node)
        passes = self.value(node.iter, variables)
        if isinstance(passes, Counted):
            return self._counted(node, passes, variables)
        if not isinstance(passes, tuple | range):
            raise self.unreadable(node)
        ways: list[Exit] = []  # ways out of the loop
        for value in passes:
            inside: list[Exit] = []
            variables = dict(variables)
            self._bind(node.target, value, variables)
            end = self.block(node.body, variables, inside)
            variables, inside = self._gathered("continue", end, inside)
            ways += inside
            if variables is None:
                break
        variables, ways = self._gathered("break", variables, ways)
        exits += ways
        return variables

    def _counted(self, node, counted: Counted, variables: dict) -> dict:
        """A loop over a range as one that ends by a condition."""
        variables = {node.target.id: counted.start} | variables
        variables |= {COUNTER: counted.start, STOP: counted.stop}
        counter, stop = (ast.Name(name, ast.Load()) for name in (COUNTER, STOP))
        test = _operated(ast.Lt() if counted.step > 0 else ast.Gt(), counter, stop)
        onward = _operated(ast.Add(), counter, ast.Constant(counted.step))
        counting = [
            ast.Assign([node.target], counter),
            ast.Assign([ast.Name(COUNTER, ast.Store())], onward),
        ]
        return self._while(ast.While(test, [*counting, *node.body], []), variables, [])

    def _plain(self, node) -> None:
        if node.orelse:
            raise self.unreadable(node)

    def _gathered(self, kind: str, end: dict | None, exits: list[Exit]) -> tuple:
        """The variables where exits of a kind have joined, and the other exits."""
        joined, others, gone = [], [], False
        for way in exits:
            if way.kind == kind:
                joined.append(way)
                gone = self.trace.either(gone, way.condition)
            else:
                alone = self.trace.both(way.condition, self.trace.negation(gone))
                others.append(Exit(way.kind, alone, way.payload))
        for way in reversed(joined):
            end = self._merged(way.condition, way.payload, end)
        return end, others

    def _while(self, node, variables, exits):
        """A loop on the trace: the variables that its body sets are its state."""
        self._plain(node)
        enter = self.condition(node.test, variables)
        if is_number(enter) and not enter:
            return variables
        names = sorted(_set(node))
        step = SubTrace(f"{_name(self.function)}_step")
        state = {n: step.argument() for n in names}
        inner = copy.copy(self)
        inner.trace = step.trace
        inside: list[Exit] = []
        begun = {n: _mapped(v, step.value) for n, v in variables.items() if n not in state} | state
        end = inner.block(node.body, begun, inside)
        end, ways = inner._gathered("continue", end, inside)
        if any(e.kind == "return" for e in ways):
            raise Untraceable("it returns from inside a loop that ends by a condition")
        again = False if end is None else inner.condition(node.test, end)
        for way in ways:
            again = inner.trace.both(again, inner.trace.negation(way.condition))
        end, _ = inner._gathered("break", end, ways)
        step.outputs = [again, *(inner.trace.number(_number(end, n)) for n in names)]
        start = [_number(variables, n) for n in names]
        loop = Loop(f"{_name(self.function)}_loop", step)
        values = self.trace.call(loop, [enter, *start, *step.outer])
        return variables | dict(zip(names, values, strict=True))

    # --- expressions
    def condition(self, node, variables):
        """A test: a truth value, where numbers are true unless they are zero."""
        return self.trace.truth(self.value(node, variables))

    def value(self, node, variables):
        """Number, traced value, tuple, or a function to be called."""
        if node not in self.codes:
            if not all(isinstance(n, EXPRESSIONS) for n in ast.walk(node)):
                raise self.unreadable(node)
            code = compile(ast.fix_missing_locations(ast.Expression(node)), self.name, "eval")
            names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} - self.local
            self.codes[node] = code, {n: self.outside(n) for n in sorted(names) if n[0] != "<"}
        code, names = self.codes[node]
        calls = {f"<{f.__name__}>": f for f in (self.operation, self.call, self.choice, self.item)}
        try:
            return eval(code, {**calls, **names, **variables})  # noqa: S307
        except NameError as missing:
            raise ValueError(f"law {self.name} reads {missing.name!r} before it is set") from None
        except Unsupported:
            raise self.unreadable(node) from None

    def outside(self, name: str):
        """A number, tuple or function that stands outside."""
        value = self.outer.get(name)
        value = getattr(value, "function", value)
        if isinstance(value, ModuleType) and value is not math or _is_array(value):
            raise Untraceable(f"it uses {name}")
        if isinstance(value, int | float | tuple) or value is math or _callable(value):
            return value
        if hasattr(value, "__float__") and not isinstance(value, type):
            return float(value)
        raise ValueError(
            f"law {self.name} uses {name!r}: only arguments, numbers, tuples of numbers, math and "
            "plain functions are allowed"
        )

    def operation(self, name: str, *values):
        """An operator, or a function by its name."""
        if name in FORMULAS:
            return FORMULAS[name](self.trace, *values)
        if name in OPERATIONS:
            return self.trace.operation(NAMES.get(name, name), *values)
        raise Unsupported

    def choice(self, condition, first: Callable, second: Callable):
        """A conditional expression."""
        condition = self.trace.truth(condition)
        if is_number(condition):
            return first() if condition else second()
        return self.select(condition, first(), second())

    def item(self, values, index):
        """A value of a tuple, or of the parameter vector."""
        if values is DATA:
            return self.trace.lookup(index)
        if isinstance(values, tuple) and is_number(index):
            return values[index]
        raise Untraceable("it picks a value by a number that is not fixed")

    def call(self, function, *arguments, **named):
        """A call of a function of Python, of `math` or of the law's module."""
        if not _callable(function):
            raise Unsupported
        if hasattr(function, "py_func"):
            raise Untraceable(f"it calls compiled code, {function.__name__}")
        if getattr(function, "answers", False):
            return self._answered(*arguments)
        if inspect.isfunction(function):
            bound = inspect.signature(function).bind(*arguments, **named)
            bound.apply_defaults()
            return self._helped(function, list(bound.arguments.values()))
        if named:
            raise Unsupported
        if function is range:
            return _passes(*arguments)
        if all(_fixed(a) for a in arguments):
            return defined(function, *arguments)
        try:
            return self.operation(function.__name__, *arguments)
        except (Unsupported, TypeError):
            raise Untraceable(f"it calls {function.__name__}") from None

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
        body = Function(_name(function))
        inner = Execution(body.trace, function, self.helpers, (*self.callers, self.function))
        body.outputs = list(
            inner.returned([_mapped(a, lambda v: body.argument()) for a in arguments])
        )
        returned = [n.value for n in ast.walk(inner.tree) if isinstance(n, ast.Return)]
        return body, len(body.outputs) == 1 and not any(isinstance(v, ast.Tuple) for v in returned)


def _passes(*bounds) -> range | Counted:
    """The values of a range; one that is not fixed, or long, is counted."""
    start, stop, step = (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1)[:3]
    if not is_number(step):
        raise Untraceable("the step of a range is not fixed")
    if is_number(start) and is_number(stop) and len(range(start, stop, step)) <= UNROLLED:
        return range(start, stop, step)
    return Counted(start, stop, step)


def _callable(value) -> bool:
    """True for what a law may call."""
    name = getattr(value, "__name__", "")
    plain = inspect.isfunction(value) or hasattr(value, "py_func")
    return plain or value in BUILTINS or getattr(math, name, None) is value


def _source(node: ast.AST, function: Callable) -> str:
    source = textwrap.dedent(inspect.getsource(function))
    return ast.get_source_segment(source, node) or ast.unparse(node)


def _set(tree: ast.AST) -> set[str]:
    """Names that statements set."""
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and not _read(n)}


def _fits(target: ast.expr, value) -> bool:
    both = isinstance(target, ast.Tuple) and isinstance(value, tuple)
    return both and len(target.elts) == len(value)


def _number(variables: dict, name: str):
    value = variables.get(name, math.nan)
    if isinstance(value, Scalar | int | float):
        return value
    raise Untraceable("a loop that ends by a condition carries more than numbers")


def _unset(value):
    """In place of a variable that the other side has set."""
    if isinstance(value, tuple):
        return _mapped(value, lambda v: math.nan)
    return math.nan


def _like(value: tuple, parts: list) -> tuple:
    """A tuple of the same kind with other parts."""
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


def _mapped(value, change: Callable):
    """A value with every traced part replaced."""
    if isinstance(value, tuple):
        return _like(value, [_mapped(v, change) for v in value])
    return change(value) if isinstance(value, Scalar) else value


def _scalars(value) -> list[Scalar]:
    """The traced parts of a value."""
    if isinstance(value, tuple):
        return [s for v in value for s in _scalars(v)]
    return [value] if isinstance(value, Scalar) else []


def _fixed(value) -> bool:
    return value is not DATA and not _scalars(value) and not inspect.isfunction(value)
