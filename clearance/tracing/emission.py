"""A kernel as Python: what `explain` shows, what result files keep, and the plain reference of the
compiled one.

Its schedule is the order in which values are computed. What only one side of a condition needs
waits for that condition: a contact in flight costs a comparison, and a formula that fails where it
does not hold is not evaluated there.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from clearance.tracing.function import Answer, Function, Loop, Opaque, counted
from clearance.tracing.trace import COMPARISONS, Scalar, derived, live, text

#: cost of an operation where it is not 1, and of what a branch must save to be worth one
COSTS = {
    "load": 0,
    "item": 0,
    "call": 100,
    "div": 4,
    "sqrt": 5,
    "lookup": 2,
    "fabs": 0,
    "copysign": 1,
}
FUNCTION, WORTH = 20, 12
SIMPLE = {
    "add",
    "sub",
    "mul",
    "neg",
    "select",
    "lt",
    "le",
    "gt",
    "ge",
    "eq",
    "ne",
    "and",
    "or",
    "not",
    "floor",
}
SIMPLE |= {"trunc", "ceil"}

Path = tuple[tuple[Scalar, bool], ...]


@dataclass
class Branch:
    """Steps for where a condition holds, and for where it does not."""

    condition: Scalar
    then: list
    otherwise: list


def scheduled(
    outputs: Iterable,
    cut: Callable[[Scalar], bool] = lambda node: False,
    ready: Collection[Scalar] = (),
) -> list:
    """Steps that compute the outputs: nodes and branches, in order.

    Nodes where `cut` holds are inputs, read where they are needed; ready: nodes that have been
    computed.
    """
    outputs = [o for o in outputs if o not in ready]
    nodes = [n for n in live(outputs, lambda node: cut(node) or node in ready) if n not in ready]
    paths = _paths(nodes, outputs, cut)
    steps, remaining = _Ordered(paths, cut, ready).block((), nodes)
    assert not remaining
    return steps


def cost(node: Scalar) -> int:
    if node.op in COSTS:
        return COSTS[node.op]
    return 1 if node.op in SIMPLE else FUNCTION


def _paths(nodes: list[Scalar], outputs: list, cut: Callable) -> dict[Scalar, Path]:
    """Conditions under which each node is needed, outermost first, those that save little left
    out.
    """
    paths: dict[Scalar, Path] = {o: () for o in outputs if isinstance(o, Scalar)}
    wanted = set(nodes)

    def need(value, path: Path) -> None:
        if value in wanted:
            paths[value] = _common(paths[value], path) if value in paths else path

    for node in reversed(nodes):
        path = paths[node]
        if cut(node):
            continue
        if node.op == "select":
            condition, first, second = node.args
            need(condition, path)
            need(first, (*path, (condition, True)))
            need(second, (*path, (condition, False)))
        else:
            for value in node.operands:
                need(value, path)
    saved: dict[Path, int] = {}
    for node, path in paths.items():
        for depth in range(1, len(path) + 1):
            saved[path[:depth]] = saved.get(path[:depth], 0) + (0 if cut(node) else cost(node))
    return {
        n: tuple(p[i] for i in range(len(p)) if saved[p[: i + 1]] >= WORTH)
        for n, p in paths.items()
    }


def _common(a: Path, b: Path) -> Path:
    size = 0
    for x, y in zip(a, b, strict=False):
        if x[0] is not y[0] or x[1] != y[1]:
            break
        size += 1
    return a[:size]


class _Ordered:
    def __init__(self, paths: dict[Scalar, Path], cut: Callable, computed: Collection[Scalar]):
        self.paths, self.cut = paths, cut
        self.done: set[Scalar] = set(computed)

    def block(self, prefix: Path, members: list[Scalar]) -> tuple[list, list[Scalar]]:
        """Steps of the members, whose paths begin with the prefix, and the members that no step
        needs yet.
        """
        depth, steps = len(prefix), []
        waiting: dict[Scalar, list[Scalar]] = {}
        for node in members:
            if len(self.paths[node]) > depth:
                waiting.setdefault(self.paths[node][depth][0], []).append(node)
        for node in members:
            if len(self.paths[node]) > depth:
                continue
            if node.op == "select" and node.args[0] in waiting:
                steps += self._branch(prefix, node.args[0], waiting)
            steps.append(node)
            self.done.add(node)
        return steps, [n for nodes in waiting.values() for n in nodes]

    def _branch(self, prefix: Path, condition: Scalar, waiting: dict) -> list:
        """A branch with what can be computed by now of all that waits for a condition."""
        ready, rest, picked = [], [], set()
        for node in waiting.pop(condition):
            operands = () if self.cut(node) else node.operands
            if all(a in self.done or a in picked for a in operands):
                ready.append(node)
                picked.add(node)
            else:
                rest.append(node)
        sides = []
        for holds in (True, False):
            members = [n for n in ready if self.paths[n][len(prefix)][1] is holds]
            steps, later = self.block((*prefix, (condition, holds)), members)
            sides.append(steps)
            rest += later
        if rest:
            waiting[condition] = sorted(rest, key=lambda node: node.index)
        return [Branch(condition, *sides)] if any(sides) else []


#: operators that C and Python have alike
INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/", **COMPARISONS}
#: names that texts use otherwise
RESERVED = {"rhs", "jacobian", "events", "commit", "observe", "follow", "derive", "answered"}
RESERVED |= {"math", "par", "int", "abs"}


@dataclass(frozen=True, eq=False)
class Program:
    """One kernel: outputs by their place in the vector that it fills, derived parameters by their
    place in `par`.

    columns: of a matrix whose entries would be too many to write down, 0 elsewhere. The outputs are
    then a column of it, for a unit vector dy; the kernel goes through all of them.
    """

    role: str
    outputs: dict[int, object]
    slots: dict[Scalar, int]
    columns: int = 0

    @property
    def target(self) -> str:
        """The vector that is filled."""
        return "work" if self.role == "commit" else "out"

    @property
    def operations(self) -> int:
        """Operations, with those of the functions that are called."""
        nodes = live(self.outputs.values(), derived)
        return counted(n for n in nodes if n not in self.slots)

    @cached_property
    def steps(self) -> list:
        """Schedule of the operations; of a matrix by columns, of those that all columns share."""
        return scheduled(self._shared if self.columns else self.outputs.values(), derived)

    @cached_property
    def column(self) -> list:
        """Schedule of a column."""
        return scheduled(self.outputs.values(), derived, set(self._shared))

    @cached_property
    def _shared(self) -> list[Scalar]:
        """Values that columns are made of and that are the same for all."""
        moving: set[Scalar] = set()
        shared: dict[Scalar, None] = {}
        for node in live(self.outputs.values(), derived):
            operands = [] if derived(node) else node.operands
            if is_direction(node) or any(a in moving for a in operands):
                moving.add(node)
                shared |= dict.fromkeys(a for a in operands if a not in moving)
        return list(shared)

    @cached_property
    def functions(self) -> list:
        """The functions that are called."""
        return called(self.outputs.values(), derived)


def is_direction(node: Scalar) -> bool:
    """True for a component of the direction that a column is taken along."""
    return node.op == "load" and node.args[0].startswith("dy[")


def called(outputs: Iterable, cut: Callable = lambda node: False) -> list:
    """The functions that outputs call, those first that others call."""
    collected: dict = {}
    for node in live(outputs, cut):
        if node.op == "call":
            _collect(node.args[0], collected)
    return list(collected)


def _collect(function, collected: dict) -> None:
    if function in collected:  # with all that it calls
        return
    inner = [function.step] if isinstance(function, Loop) else []
    if isinstance(function, Function):
        inner = [node.args[0] for node in live(function.outputs) if node.op == "call"]
    for callee in inner:
        _collect(callee, collected)
    collected.setdefault(function)


class Writer:
    """Python statements of schedules; functions get names of their own."""

    reserved, comment, library = RESERVED, "# {}", "math."
    infix: ClassVar = INFIX | {"pow": "**", "and": "and", "or": "or"}
    forms: ClassVar = {
        "neg": "-{}",
        "not": "not {}",
        "fabs": "abs({})",
        "lookup": "par[int({})]",
        "select": "{1} if {0} else {2}",
    }
    #: heads of a branch and of its other side, and what ends it
    begin, unless, otherwise, end = "if {}:", "if not {}:", "else:", ""
    value = staticmethod(text)

    def __init__(
        self, functions: list, slots: dict | None = None, names: dict[str, str] | None = None
    ):
        self.slots = slots or {}
        self.names = names or {}
        self.called: dict[object, str] = {}
        for function in functions:
            name = function.name
            while name in self.called.values() or name in self.reserved:
                name += "_"
            self.called[function] = name
        self.section = ""

    def lines(self, steps: list, indent: str = "    ") -> list[str]:
        """Statements of a schedule."""
        result = []
        for step in steps:
            if isinstance(step, Branch):
                result += self._branch(step, indent)
            else:
                result += [indent + line for line in self._statement(step)]
        return result

    def _branch(self, branch: Branch, indent: str) -> list[str]:
        head = self.begin if branch.then else self.unless
        deeper = indent + "    "
        lines = [indent + head.format(text(branch.condition))]
        lines += self.lines(branch.then or branch.otherwise, deeper)
        if branch.then and branch.otherwise:
            lines += [indent + self.otherwise, *self.lines(branch.otherwise, deeper)]
        return [*lines, indent + self.end] if self.end else lines

    def _statement(self, node: Scalar) -> list[str]:
        lines = []
        if node.section and node.section != self.section:
            self.section = node.section
            lines.append(self.comment.format(node.section))
        source = self.source(node)
        lines += self._assigned(node, source)
        if source in self.names:
            lines[-1] += "  " + self.comment.format(self.names[source])
        return lines

    def _assigned(self, node: Scalar, source: str) -> list[str]:
        return [f"v{node.index} = {source}"]

    def source(self, node: Scalar) -> str:
        """The expression of one operation."""
        if node in self.slots:
            return f"par[{self.slots[node]}]"
        op, args = node.op, node.args
        if op == "load":
            return args[0]
        if op == "item":
            return f"{text(args[0])}[{args[1]}]"
        if op == "call":
            return self._call(node, [self.value(a) for a in args[1:]])
        texts = [self.value(a) for a in args]
        if op in self.infix:
            return f"{texts[0]} {self.infix[op]} {texts[1]}"
        if op in self.forms:
            return self.forms[op].format(*texts)
        return f"{self.library}{op}({', '.join(texts)})"

    def _call(self, node: Scalar, args: list[str]) -> str:
        function = node.args[0]
        name = self.called[function]
        if isinstance(function, Answer):
            inputs = f"({', '.join(args[1:])},)"
            return f"answered(par, {args[0]}, {function.wanted}, {inputs}, {function.places})"
        if not isinstance(function, Opaque):
            return f"{name}({', '.join(['par', *args])})"
        return f"{name}({function.form.format(*args)})"

    def function(self, function) -> list[str]:
        """Definition of a function."""
        if isinstance(function, Answer):
            return []
        if isinstance(function, Opaque):
            return [f"# {self.called[function]} is compiled apart: {function.reason}"]
        if isinstance(function, Loop):
            inner = [a.args[0] for a in function.step.arguments]
            step = f"{self.called[function.step]}({', '.join(['par', *inner])})"
            state = ", ".join(inner[: function.count])
            lines = [
                "    while again:",
                f"        again, {state} = {step}",
                f"    return ({state},)",
            ]
            names = ["again", *inner]
        else:
            names = [a.args[0] for a in function.arguments]
            inner = Writer([])
            inner.called = self.called
            lines = inner.lines(scheduled(function.outputs))
            lines.append(f"    return {', '.join(map(text, function.outputs))},")
        return [f"def {self.called[function]}({', '.join(['par', *names])}):", *lines]


def kernel_text(program: Program, names: dict[str, str]) -> str:
    """Source of one kernel. names: of parameters, by `par[i]`."""
    writer = Writer(program.functions, program.slots, names)
    blocks = ["import math"] + ["\n".join(t) for t in map(writer.function, program.functions) if t]
    body = writer.lines(program.steps)
    if program.columns:
        body += _columns_lines(program, writer)
    else:
        body += [
            f"    {program.target}[{i}] = {text(v)}" for i, v in sorted(program.outputs.items())
        ]
    blocks.append(
        "\n".join([f"def {program.role}(t, y, par, work, out):", *(body or ["    pass"])])
    )
    title = f'"""clearance kernel `{program.role}`: straight-line code of one structure only."""'
    return "\n\n".join([title, "\n\n\n".join(blocks)])


def _columns_lines(program: Program, writer: Writer) -> list[str]:
    """Statements that fill a matrix column by column."""
    count = program.columns
    lines = [
        f"    for column in range({count}):",
        f"        dy = [0.0] * {count}",
        "        dy[column] = 1.0",
    ]
    lines += writer.lines(program.column, "        ")
    rows = (
        f"        {program.target}[{i * count} + column] = {text(v)}"
        for i, v in sorted(program.outputs.items())
    )
    return [*lines, *rows]


def function_text(function) -> str:
    """Source of a function and all that it calls."""
    functions = called(function.outputs) if isinstance(function, Function) else []
    writer = Writer([function, *functions])
    return "import math\n\n\n" + "\n\n\n".join(
        "\n".join(writer.function(f)) for f in [*functions, function]
    )


def derive_text(slots: dict[Scalar, int]) -> str:
    """Source of the function that fills the derived parameters in."""
    writer = Writer([])
    lines = writer.lines(scheduled(slots))
    lines += [f"    par[{slot}] = {text(node)}" for node, slot in slots.items()]
    return "\n".join(["def derive(par):", *lines, "    return par\n"])
