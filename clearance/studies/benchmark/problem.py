"""A problem of the benchmark set, and the answer to it."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import clearance as cl
from clearance.results.record import Record
from clearance.scene.scene import Scene
from clearance.studies.benchmark.rows import Comparison, table

RTOL = 1e-11  # of the motions that the command integrates


@dataclass
class Work:
    """Runs of a problem and what they cost; widths: half 95 % intervals of statistical values."""

    rtol: float = RTOL
    seconds: float = 0.0
    steps: int = 0
    evaluations: int = 0
    widths: dict[str, float] = field(default_factory=dict)

    def __call__(self, scene: Scene, **options) -> Record:
        """A run without the second one that states its errors."""
        result = cl.simulate(scene, **{"rtol": self.rtol, "error": None} | options)
        self.steps += int(result.solver["steps"])
        self.evaluations += int(result.solver["evaluations"])
        return result

    def __str__(self) -> str:
        cost = f"{self.seconds:.2f} s, {self.steps} steps, {self.evaluations} evaluations"
        return f"{cost}, rtol {self.rtol:g}"


@dataclass(frozen=True)
class Problem:
    """A problem: its line in the list, and what computes its values, by quantity."""

    text: str
    values: Callable[[Work], dict[str, float]]


@dataclass(frozen=True)
class Answer:
    """Values of a problem beside their references; work: of a run, None of another code's;
    unknown: names in the file of another code that the problem does not have.
    """

    name: str
    rows: list[Comparison]
    work: Work | None = None
    unknown: tuple[str, ...] = ()

    @property
    def inside(self) -> bool:
        """All rows have a value within the error of its reference."""
        return all(row.inside for row in self.rows)

    def __str__(self) -> str:
        last = [f"work: {self.work}"] if self.work else [f"unknown: {n}" for n in self.unknown]
        return "\n".join([f"{self.name}: {PROBLEMS[self.name].text}", *table(self.rows), *last])

    @property
    def plain(self) -> dict:
        """Values, references, errors, unknown names and work as plain data."""
        rows = [asdict(c.row) | {"reference": c.row.value, "value": c.value} for c in self.rows]
        return {"rows": rows, "unknown": self.unknown, "work": self.work and asdict(self.work)}


PROBLEMS: dict[str, Problem] = {}


def problem(text: str) -> Callable:
    """Decorate what computes the values of a problem with its line in the list."""

    def add(values: Callable[[Work], dict[str, float]]) -> Callable:
        PROBLEMS[values.__name__] = Problem(text, values)
        return values

    return add
