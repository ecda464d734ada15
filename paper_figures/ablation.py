"""Cost of each part of a scene: states, operations, time a step, of the scene and of what is left
without a part.
"""

import statistics
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace

from clearance.files.texts import markdown
from clearance.mechanism.build import build
from clearance.run.diagnosis import Diagnosis
from clearance.run.options import Solver, Span, choose_method
from clearance.run.run import Run
from clearance.scene.scene import Scene, reduced
from clearance.stepping import status

RTOL = 1e-6
REPEATS = 9
SAMPLES_PER_TURN = 400
#: times of a step: name -> whether with the energy ledger, and with all outputs
TIMES = {"step": (False, False), "ledger_step": (True, False), "output_step": (True, True)}
DOUBT = 0.2  # spread of repeats over their median from which on they are warned of


@dataclass(frozen=True)
class Part:
    """One row of the table; times are CPU times of one accepted step [s], medians; None where not
    measured.

    ranges: smallest and largest repeat of each time.
    """

    name: str
    joints: int
    states: int
    channels: int
    operations: int  # of one right-hand side, laws not counted
    method: str = ""
    steps: int | None = None
    step: float | None = None  # without outputs and energy ledger
    ledger_step: float | None = None  # with the energy ledger
    output_step: float | None = None  # with the ledger and all outputs
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def spread(self) -> float:
        """Largest difference of repeats over their median."""
        spreads = [(high - low) / getattr(self, n) for n, (low, high) in self.ranges.items()]
        return max(spreads, default=0.0)


def ablation(
    scene: Scene, measured: bool = True, progress: Callable[[str], None] = lambda name: None
) -> list[Part]:
    """The rows of a scene: itself, then without one part after the other."""
    return costs(reduced(scene), measured, progress)


def costs(
    scenes: dict[str, Scene],
    measured: bool = True,
    progress: Callable[[str], None] = lambda name: None,
) -> list[Part]:
    """A row for each scene. Measured over one turn (or second) at rtol 1e-6 with 400 samples, warm.

    In each of nine repeats all rows take their turn, so that a slow minute of the machine meets
    all of them.
    """
    rows, loops = [], {}
    for name, scene in scenes.items():
        progress(name)
        mechanism = build(scene)
        states = build(scene, ledger=False).y0.size
        count = mechanism.structure.programs["rhs"].operations
        method, _ = choose_method(mechanism, rtol=RTOL)
        rows.append(
            Part(
                name,
                len(scene.clearance_joints),
                states,
                len(mechanism.layout.channels),
                count,
                method,
            )
        )
        if measured:
            loops |= {(name, time): _loop(scene, *parts) for time, parts in TIMES.items()}
            steps = {time: loops[name, time]()[1] for time in TIMES}  # compiles
            rows[-1] = replace(rows[-1], steps=steps["step"])
    if not measured:
        return rows
    repeats = []
    for i in range(REPEATS):
        progress(f"repeat {i + 1} of {REPEATS}")
        times = {key: run() for key, run in loops.items()}
        repeats.append({key: seconds / steps for key, (seconds, steps) in times.items()})
    return [_timed(r, {time: [m[r.name, time] for m in repeats] for time in TIMES}) for r in rows]


def cost(name: str, scene: Scene, measured: bool = True) -> Part:
    """The row of one scene, as `costs`."""
    return costs({name: scene}, measured)[0]


def _timed(row: Part, times: dict[str, list[float]]) -> Part:
    medians = {name: statistics.median(values) for name, values in times.items()}
    ranges = {name: (min(values), max(values)) for name, values in times.items()}
    return replace(row, **medians, ranges=ranges)


def _loop(scene: Scene, ledger: bool, outputs: bool) -> Callable[[], tuple[float, int]]:
    """A call that runs a scene and gives CPU seconds in the compiled loop and accepted steps."""
    mechanism = build(scene, ledger=ledger)
    span = Span(scene.turn or 1.0, SAMPLES_PER_TURN + 1 if outputs else 2)

    def measured() -> tuple[float, int]:
        run = Run(mechanism, span, Solver(RTOL), outputs)
        code = run.trajectory()[2]
        if code != status.DONE:
            raise ValueError(f"cannot measure the cost: {Diagnosis(run).failure(code)}")
        return run.cpu, int(run.state.steps)

    return measured


def doubt(rows: list[Part]) -> str:
    """A sentence where repeats differ so much that small differences between rows mean nothing."""
    worst = max(rows, key=lambda r: r.spread)
    if worst.spread < DOUBT:
        return ""
    return (
        f"Repeats of '{worst.name}' differ by {100.0 * worst.spread:.0f} % of their median: the "
        "machine was busy. Differences within the ranges mean nothing."
    )


def table(rows: list[Part], title: str = "cost of the parts") -> list[str]:
    """The rows as Markdown: medians, ranges of the repeats in brackets, and then `doubt`."""
    measured = rows[0].step is not None
    head = [title, "clearance joints", "states", "operations a right-hand side", "output channels"]
    if measured:
        head += ["method", "steps", "a step [us]", "and ledger", "and outputs"]
    cells = [[r.name, r.joints, r.states, r.operations, r.channels] for r in rows]
    for r, row in zip(rows, cells, strict=True):
        if measured:
            row += [r.method, r.steps, *(_microseconds(r, name) for name in TIMES)]
    lines, doubts = markdown(head, cells), doubt(rows)
    return [*lines, "", doubts] if doubts else lines


def _microseconds(row: Part, name: str) -> str:
    low, high = (1e6 * t for t in row.ranges[name])
    return f"{1e6 * getattr(row, name):.2f} ({low:.2f} to {high:.2f})"


def plain(rows: list[Part]) -> list[dict]:
    """The rows as JSON types; times in seconds."""
    return [asdict(r) for r in rows]
