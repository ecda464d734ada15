"""Arithmetic operations of inverse dynamics: counted while code runs, or by formula."""

import math
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from clearance.mechanism.structure import Structure
from clearance.motions.prescribed import STRETCH, Explicit
from clearance.tracing.emission import kernel_text

KINDS = ("additions", "multiplications", "divisions", "functions")
#: what a joint puts on its body b
REACTIONS = ("force_x", "force_y", "moment", "axial_force", "bending_x", "bending_y")


@dataclass(frozen=True)
class Operations:
    """Arithmetic of one sample; subtractions are additions, functions are roots, sines and the
    like.
    """

    additions: float
    multiplications: float
    divisions: float
    functions: float

    @property
    def total(self) -> float:
        return self.additions + self.multiplications + self.divisions + self.functions

    def __str__(self) -> str:
        return " + ".join(f"{getattr(self, k):.0f}" for k in KINDS) + f" = {self.total:.0f}"


def dense_operations(bodies: int, joints: int) -> Operations:
    """Of one solve for all multipliers of a known motion, n = 3 bodies equations, no zero of the
    matrix made use of.

    Of the assembly it counts only a sine and a cosine a body, the turning of two points a joint,
    mass times acceleration less gravity. Then come Gaussian elimination with the right side, and
    back substitution.
    """
    n = 3 * bodies
    pairs = (n - 1) * n * (2 * n - 1) // 6 + n * (n - 1)  # a multiplication and a subtraction each
    return Operations(
        pairs + 4 * joints + 2 * bodies,
        pairs + 8 * joints + 3 * bodies,
        n * (n + 1) // 2,
        2 * bodies,
    )


def needed_channels(solver: Explicit) -> list[int]:
    """Places of the efforts of drives and the reactions of joints among the channels."""
    wanted = {"drives": ("torque", "force"), "joints": REACTIONS}
    parts = [c.path.split("/") for c in solver.channels]
    return [i for i, (group, *_, name) in enumerate(parts) if name in wanted.get(group, ())]


def counted_operations(solver: Explicit, times: np.ndarray, channels: Iterable[int]) -> Operations:
    """Operations a sample of the code for some channels, counted while it runs in Python at growing
    times [s].

    Iterations count as often as they are made; changes of sign, comparisons and copies do not
    count.
    """
    structure, m, count = solver.structure, solver.mechanism, Counting()
    look = count.function("observe", observing(structure, channels))
    keep = count.function("commit", structure.texts["commit"])
    state, par, work = (
        [count.number(v) for v in x] for x in (m.y0, m.par, np.append(m.work0, 0.0))
    )
    out = [0.0] * len(solver.channels)
    for i, time in enumerate(times):
        way = time - times[i - 1] if i else 0.0
        stretches = (
            max(math.ceil(way * m.frequency / STRETCH), 1) if structure.layout.commits else 0
        )
        for k in range(1, stretches):
            keep(count.number(time - way + way * k / stretches), state, par, work, work)
        look(count.number(time), state, par, work, out)
        if structure.layout.commits:
            keep(count.number(time), state, par, work, work)
    return Operations(*(count.tally[kind] / len(times) for kind in KINDS))


def observing(structure: Structure, channels: Iterable[int]) -> str:
    """Text of the kernel that observes some channels only."""
    program = structure.programs["observe"]
    return kernel_text(replace(program, outputs={i: program.outputs[i] for i in channels}), {})


class Counting:
    """Runs the text of a kernel in plain Python on numbers that count what is done with them."""

    def __init__(self):
        self.tally: Counter = Counter()
        names = {
            "add": "additions",
            "sub": "additions",
            "mul": "multiplications",
            "truediv": "divisions",
        }
        methods = {
            f"__{side}{name}__": self._counted(kind, getattr(float, f"__{side}{name}__"))
            for name, kind in names.items()
            for side in ("", "r")
        }
        methods["__pow__"] = self._counted("functions", float.__pow__)
        methods |= {
            f"__{name}__": self._counted(None, getattr(float, f"__{name}__"))
            for name in ("neg", "abs")
        }
        self.number = type("Number", (float,), methods)
        tools = {
            n: f if isinstance(f, float) else self._counted("functions", f)
            for n, f in vars(math).items()
        }
        self.math = SimpleNamespace(**{n: f for n, f in tools.items() if not n.startswith("_")})

    def _counted(self, kind: str | None, plain: Callable) -> Callable:
        def method(*numbers):
            if kind is not None:
                self.tally[kind] += 1
            try:
                return self.number(plain(*numbers))
            except (ZeroDivisionError, ValueError):  # of a value that a condition then leaves out
                return self.number(math.nan)

        return method

    def function(self, name: str, text: str) -> Callable:
        """The function of a text."""
        scope = {"math": self.math}
        exec(text.replace("import math\n", ""), scope)  # noqa: S102
        return scope[name]
