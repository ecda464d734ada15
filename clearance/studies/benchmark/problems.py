"""The benchmark set: its problems by name, and their values beside the references."""

import time
import warnings
from pathlib import Path

from clearance.scene.catalogue import beside_cases
from clearance.studies.benchmark.foreign import foreign
from clearance.studies.benchmark.problem import PROBLEMS, RTOL, Answer, Work
from clearance.studies.benchmark.rows import compared, references
from clearance.values import checks
from clearance.values.checks import RunWarning, one_of

for _part in ("mechanisms", "bearings", "motions"):  # their problems enter PROBLEMS in this order
    beside_cases(f"benchmark.{_part}")


def named(name: str | int) -> str:
    """Name of a problem by its name or number. Raises ValueError for an unknown one."""
    numbers = {str(i): key for i, key in enumerate(PROBLEMS, 1)}
    name = numbers.get(str(name), str(name))
    one_of("benchmark", name, PROBLEMS)
    return name


def benchmark(name: str | int, against: str | Path | None = None, *, rtol: float = RTOL) -> Answer:
    """A problem of the benchmark set: computed values beside the reference values.

    name: of the problem, or its number, see `clearance benchmark`; against: CSV file of another
    code, whose values are compared and nothing is run (docs/benchmark.md states its form); rtol: of
    the motions. `print` shows the table; rows have `value`, `row.value`, `row.error`, `off` and
    `inside`, the answer `inside` of all rows, and `unknown` names.
    Raises ValueError for an unknown name and for a file without values of the problem.
    """
    name = named(name)
    rows = references(name)
    if against is not None:
        values, unknown = foreign(against, rows)
        return Answer(name, compared(rows, values), unknown=tuple(unknown))
    work = Work(checks.positive("rtol", rtol))
    began = time.perf_counter()
    with warnings.catch_warnings():  # the laws are those of the statement
        warnings.simplefilter("ignore", RunWarning)
        values = PROBLEMS[name].values(work)
    work.seconds = time.perf_counter() - began
    return Answer(name, compared(rows, values, work.widths), work)
