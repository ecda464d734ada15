"""Programs and functions as C99: readable, and without anything but libm."""

from collections.abc import Callable, Iterable
from typing import ClassVar

from clearance.tracing.emission import INFIX, Branch, Program, Writer, scheduled
from clearance.tracing.function import Loop
from clearance.tracing.trace import Scalar, text

#: names that C or its library has
RESERVED = {"double", "int", "long", "out", "par", "work", "y", "t", "exp", "log", "tables"}
KERNEL = "double t, const double *y, const double *par, const double *work, double *out"


def value(number) -> str:
    """A value as it stands in an expression."""
    special = {"math.nan": "NAN", "math.inf": "INFINITY", "(-math.inf)": "(-INFINITY)"}
    return special.get(text(number), text(number))


class CWriter(Writer):
    """C statements of schedules. Values that leave a branch are declared before it."""

    reserved, comment, library = RESERVED, "/* {} */", ""
    infix: ClassVar = INFIX | {"and": "&&", "or": "||"}
    forms: ClassVar = {
        "neg": "-{}",
        "not": "!{}",
        "lookup": "tables[(long)({})]",
        "select": "{} ? {} : {}",
    }
    begin, unless, otherwise, end = "if ({}) {{", "if (!{}) {{", "} else {", "}"
    value = staticmethod(value)

    def body(self, steps: list, ends: Iterable, indent: str = "    ") -> list[str]:
        """Statements of a schedule; ends: values that are read behind it."""
        self.hoisted = _leaving(steps, ends, self.operands)
        declared = (indent + self._declared(n, " = {0.0}", " = 0") for n in self.hoisted)
        return [*declared, *self.lines(steps, indent)]

    def operands(self, node: Scalar) -> list[Scalar]:
        """Values that a statement reads."""
        return [] if node in self.slots else node.operands

    @staticmethod
    def _declared(node: Scalar, array: str = "", number: str = "") -> str:
        if node.op == "call":
            return f"double v{node.index}[{node.args[0].count}]{array};"
        kind = "int" if node.boolean else "double"
        return f"{kind} v{node.index}{number};"

    def _assigned(self, node: Scalar, source: str) -> list[str]:
        hoisted = node in self.hoisted
        if node.op == "call" and node not in self.slots:
            return [*([] if hoisted else [self._declared(node)]), f"{source};"]
        kind = "" if hoisted else "const int " if node.boolean else "const double "
        return [f"{kind}v{node.index} = {source};"]

    def _call(self, node: Scalar, args: list[str]) -> str:
        return f"{self.called[node.args[0]]}({', '.join([*args, f'v{node.index}'])})"

    def function(self, function) -> list[str]:
        """Definition of a function, which fills the values in."""
        name = self.called[function]
        if isinstance(function, Loop):
            step = function.step
            arguments = [a.args[0] for a in step.arguments]
            head = f"static void {name}({_doubles(['again', *arguments])}, double *out)"
            state = arguments[: function.count]
            passed = [f"{a} = v[{i}];" for i, a in enumerate(["again", *state])]
            ends = [f"out[{i}] = {a};" for i, a in enumerate(state)]
            call = f"{self.called[step]}({', '.join([*arguments, 'v'])});"
            lines = [f"double v[{step.count}];", "while (again != 0.0) {", f"    {call}"]
            return _defined(head, [*lines, *("    " + p for p in passed), "}", *ends])
        names = [a.args[0] for a in function.arguments]
        inner = CWriter([])
        inner.called = self.called
        lines = inner.body(scheduled(function.outputs), function.outputs, "")
        read = {n.args[0] for n in _nodes(scheduled(function.outputs)) if n.op == "load"}
        lines = [f"(void){n};" for n in names if n not in read] + lines
        ends = [f"out[{i}] = {value(o)};" for i, o in enumerate(function.outputs)]
        head = f"static void {name}({_doubles(names)}, double *out)"
        return _defined(head, [*lines, *ends])

    def kernel(
        self, name: str, outputs: dict, cut: Callable, size: int, arguments: str = KERNEL
    ) -> list[str]:
        """A kernel that fills so many places, those without an output with 0."""
        ends = list(outputs.values())
        steps = scheduled(ends, cut)
        filled = [f"for (int i = 0; i < {size}; i++) out[i] = 0.0;"] if size > len(outputs) else []
        filled += [f"out[{i}] = {value(v)};" for i, v in sorted(outputs.items())]
        return self._whole(name, [*self.body(steps, ends, ""), *filled], arguments)

    def matrix(self, program: Program) -> list[str]:
        """A matrix, column by column."""
        n = program.columns
        ends = list(program.outputs.values())
        lines = self.body(program.steps, _read_by(program.column, ends, self.operands), "")
        column = self.body(program.column, ends, "    ")
        rows = [f"    out[{i * n} + column] = {value(v)};" for i, v in program.outputs.items()]
        first = [f"double dy[{n}] = {{0.0}};", f"for (int column = 0; column < {n}; column++) {{"]
        moved = ["    dy[column] = 1.0;", *column, *rows, "    dy[column] = 0.0;", "}"]
        zeros = f"for (int i = 0; i < {n * n}; i++) out[i] = 0.0;"
        return self._whole(program.role, [*lines, zeros, *first, *moved])

    def _whole(self, name: str, lines: list[str], arguments: str = KERNEL) -> list[str]:
        names = (a.split()[-1].lstrip("*") for a in arguments.split(","))
        unused = " ".join(f"(void){n};" for n in names)
        return _defined(f"void {name}({arguments})", [unused, *lines])


def _doubles(names: Iterable[str]) -> str:
    return ", ".join(f"double {n}" for n in names)


def _defined(head: str, lines: list[str]) -> list[str]:
    return [head, "{", *("    " + line for line in lines), "}", ""]


def _nodes(steps: list) -> list[Scalar]:
    """All nodes of a schedule, those of its branches too."""
    nodes = []
    for step in steps:
        inner = [*step.then, *step.otherwise] if isinstance(step, Branch) else []
        nodes += _nodes(inner) if isinstance(step, Branch) else [step]
    return nodes


def _read_by(steps: list, ends: Iterable, operands: Callable) -> list:
    return [*(a for n in _nodes(steps) for a in operands(n)), *ends]


def _leaving(steps: list, ends: Iterable, operands: Callable) -> list[Scalar]:
    """Values that are computed inside a branch and read outside of it, in order."""
    path_of: dict[Scalar, tuple] = {}
    reads = [(n, ()) for n in ends]

    def placed(inner: list, path: tuple) -> None:
        for k, step in enumerate(inner):
            if isinstance(step, Branch):
                reads.append((step.condition, path))
                placed(step.then, (*path, (k, True)))
                placed(step.otherwise, (*path, (k, False)))
            else:
                path_of[step] = path
                reads.extend((n, path) for n in operands(step))

    placed(steps, ())
    leaving = {n for n, p in reads if n in path_of and p[: len(path_of[n])] != path_of[n]}
    return sorted(leaving, key=lambda n: n.index)
