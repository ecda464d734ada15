"""The order in which values are computed: what only one side of a condition needs waits for that
condition.

A contact in flight costs a comparison, and a formula that fails where it does not hold is not
evaluated there.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

from clearance.tracing.trace import Scalar, live

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
    given: Collection[Scalar] = (),
) -> list:
    """Steps that compute the outputs: nodes and branches, in order.

    Nodes where `cut` holds are inputs, read where they are needed; given: nodes that have been
    computed.
    """
    outputs = [o for o in outputs if o not in given]
    nodes = [n for n in live(outputs, lambda node: cut(node) or node in given) if n not in given]
    paths = _paths(nodes, outputs, cut)
    steps, remaining = _Ordered(paths, cut, given).block((), nodes)
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
