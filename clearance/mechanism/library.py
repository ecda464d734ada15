"""The plain functions that the kernels of one structure call, each under a name of its own.

A law's source is read, not its name: helper functions come along, numbers from the law's module or closure are written
in as literals, and two functions of the same name stay two functions.
"""

import ast
import builtins
import inspect
import math
import re
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from clearance.mechanism.derivative import jacobian_text

ALLOWED_BUILTINS = {"abs", "max", "min", "range", "float", "int", "pow"}
_RESERVED = re.compile(
    r"(v\d+|par|work|out|t|y|math|plain|kernel|rhs|jacobian|events|commit|observe|FilmJoint|ask|_.*|[dw]\d+_.*|"
    r"abs|max|min|range|float|int|pow|(solve|close|rub)_\w+)$"
)


@dataclass(frozen=True)
class Entry:
    """A plain function as text, with the names of the functions it calls and how many values it returns."""

    name: str
    tree: ast.FunctionDef
    callees: tuple[str, ...]
    outputs: int

    @property
    def source(self) -> str:
        return ast.unparse(self.tree)


class Library:
    """Functions by their emitted names; add them, differentiate them, print what a kernel needs."""

    def __init__(self):
        self.entries: dict[str, Entry] = {}
        self._names: dict[object, str] = {}
        self._slopes: dict[str, str] = {}
        self.derived: dict[str, str] = {}  # function of values and derivatives -> function of the values

    def add(self, function: Callable) -> str:
        """Take a plain function and everything it calls; returns the name it is emitted under.

        A function with an attribute `slopes` brings its own derivative: a function of the same arguments that returns
        values and derivatives by its leading arguments, ordered as `jacobian` has them.
        """
        if function not in self._names:
            name = function.__name__
            if _RESERVED.match(name):
                name = f"law_{name.lstrip('_')}"
            while name in self.entries or name in self._names.values():
                name += "_"
            self._names[function] = name
            tree = _Resolved(self, function).tree
            tree.name = name
            self._enter(tree, function.__name__)
            if hasattr(function, "slopes"):
                self._slopes[name] = self.add(function.slopes)
        return self._names[function]

    def add_text(self, source: str) -> str:
        """Take generated text."""
        tree = ast.parse(source).body[0]
        self._enter(tree, tree.name)
        return tree.name

    def jacobian(self, name: str, active: tuple[int, ...]) -> str:
        """Name of the function that returns values and derivatives by the arguments at the active positions."""
        if name in self._slopes:
            self.derived[self._slopes[name]] = name
            return self._slopes[name]
        written = f"{name}_d{''.join(map(str, active))}"
        if written not in self.entries:
            self.add_text(jacobian_text(self, self.entries[name], active, written))
            self.derived[written] = name
        return written

    def _enter(self, tree: ast.FunctionDef, called: str) -> None:
        used = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
        callees = tuple(sorted(used & set(self.entries)))
        self.entries[tree.name] = Entry(tree.name, tree, callees, self._outputs(tree, called))

    def _outputs(self, tree: ast.FunctionDef, called: str) -> int:
        """How many values a function returns; the same everywhere, and on every way through it."""
        counts = {self._count(n.value) for n in ast.walk(tree) if isinstance(n, ast.Return)}
        if len(counts) != 1:
            raise ValueError(f"law {called} must return the same number of values everywhere")
        if not _always_returns(tree.body):
            raise ValueError(f"law {called} can end without returning a value")
        return counts.pop()

    def _count(self, value: ast.expr | None) -> int:
        if isinstance(value, ast.Tuple):
            return len(value.elts)
        if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id in self.entries:
            return self.entries[value.func.id].outputs
        return 0 if value is None else 1

    def sources(self, names: Iterable[str]) -> list[str]:
        """Texts of the named functions and all they call, callees first, each once."""
        found: dict[str, str] = {}

        def collect(name: str) -> None:
            for callee in self.entries[name].callees:
                collect(callee)
            found.setdefault(name, self.entries[name].source)

        for name in names:
            collect(name)
        return list(found.values())

    def run(self, name: str) -> Callable:
        """The function as plain Python."""
        scope: dict = {"math": math}
        exec("\n\n".join(self.sources([name])), scope)  # noqa: S102
        return scope[name]


def _always_returns(body: list[ast.stmt]) -> bool:
    last = body[-1]
    if isinstance(last, ast.If):
        return bool(last.orelse) and _always_returns(last.body) and _always_returns(last.orelse)
    return isinstance(last, ast.Return | ast.Raise)


def definition(function: Callable) -> ast.FunctionDef:
    """The syntax tree of a function, without decorators, docstring and annotations."""
    name = getattr(function, "__name__", repr(function))
    try:
        source = textwrap.dedent(inspect.getsource(function))
        node = ast.parse(source).body[0]
    except (OSError, TypeError, SyntaxError):
        raise ValueError(f"law {name}: no source found; define it with def in a file, not at a prompt") from None
    if not isinstance(node, ast.FunctionDef) or node.args.vararg or node.args.kwarg or node.args.kwonlyargs:
        raise ValueError(f"law {name} must be a function defined with def and plain arguments")
    node.decorator_list, node.returns = [], None
    for argument in node.args.args:
        argument.annotation = None
    if ast.get_docstring(node) is not None:
        node.body = node.body[1:] or [ast.Pass()]
    return node


def fingerprint(function: Callable) -> tuple:
    """Equal for functions that do the same: their code and the numbers and functions they read from outside."""
    outer = {**function.__globals__, **inspect.getclosurevars(function).nonlocals}
    code, found = function.__code__, []
    for name in (*code.co_names, *code.co_freevars):
        value = getattr(outer.get(name), "function", outer.get(name))
        if inspect.isfunction(value):
            found.append((name, fingerprint(value) if value is not function else None))
        elif isinstance(value, int | float) or hasattr(value, "__float__"):
            found.append((name, float(value)))
        elif isinstance(value, tuple):
            found.append((name, value))
    return code, tuple(found)


class _Resolved(ast.NodeTransformer):
    """A function's tree with outer names resolved: numbers as literals, functions under their emitted names."""

    def __init__(self, library: Library, function: Callable):
        self.library, self.function = library, function
        tree = definition(function)
        self.local = {a.arg for a in tree.args.args}
        self.local |= {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        outer = inspect.getclosurevars(function)
        self.outer = {**function.__globals__, **outer.nonlocals}
        self.tree = ast.fix_missing_locations(self.visit(tree))

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self.local:
            return node
        value = self.outer.get(node.id, getattr(builtins, node.id, None))
        value = getattr(value, "function", value)
        if value is math:
            return ast.Name("math", node.ctx)
        if getattr(value, "ready_made", False):
            return ast.Name(value.__name__, node.ctx)
        if inspect.isfunction(value):
            name = self.library.add(value)
            if name not in self.library.entries:
                raise ValueError(f"law {self.function.__name__} calls itself (through {node.id}); write a loop")
            return ast.Name(name, node.ctx)
        if node.id in ALLOWED_BUILTINS and value is getattr(builtins, node.id):
            return node
        if callable(value) and getattr(math, getattr(value, "__name__", ""), None) is value:
            return ast.Attribute(ast.Name("math", ast.Load()), value.__name__, node.ctx)
        try:
            if isinstance(value, tuple):
                return ast.Tuple([_literal(float(v)) for v in value], node.ctx)
            return _literal(float(value) if not isinstance(value, bool | int) else value)
        except (TypeError, ValueError):
            raise ValueError(
                f"law {self.function.__name__} uses {node.id!r}: only arguments, numbers, tuples of numbers, math and "
                "plain functions are allowed"
            ) from None


def _literal(value: float) -> ast.expr:
    text = repr(value) if math.isfinite(value) else f"math.{value}" if value > 0 or value != value else "(-math.inf)"
    return ast.parse(text, mode="eval").body
