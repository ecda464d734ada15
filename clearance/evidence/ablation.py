"""What each part of a scene costs: states, operations, time a step, of the scene and of what is left without a part."""

import statistics
from collections.abc import Callable
from dataclasses import asdict, dataclass

from clearance.evidence.explain import operations
from clearance.evidence.variants import reduced
from clearance.mechanism.build import build
from clearance.scene import Scene
from clearance.simulation import Run, Span, choose_method
from clearance.stepping import status

RTOL = 1e-6
REPEATS = 5
SAMPLES_PER_TURN = 400


@dataclass(frozen=True)
class Part:
    """One row of the table; times are of one accepted step [s], None where not measured."""

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


def ablation(scene: Scene, measured: bool = True, progress: Callable[[str], None] = lambda name: None) -> list[Part]:
    """The rows of a scene: itself, then without one part after the other."""
    rows = []
    for name, less in reduced(scene).items():
        progress(name)
        rows.append(cost(name, less, measured))
    return rows


def cost(name: str, scene: Scene, measured: bool = True) -> Part:
    """One row. Measured over one turn (or second) at rtol 1e-6 with 400 samples, warm, median of five."""
    mechanism = build(scene)
    states = build(scene, ledger=False).y0.size
    facts = (name, len(scene.clearance_joints), states, len(mechanism.structure.channels))
    method, _ = choose_method(mechanism, rtol=RTOL)
    count = operations("rhs", mechanism.structure.texts["rhs"])
    if not measured:
        return Part(*facts, count, method)
    steps, bare = _per_step(scene, ledger=False, outputs=False)
    return Part(*facts, count, method, steps, bare, _per_step(scene, True, False)[1], _per_step(scene, True, True)[1])


def _per_step(scene: Scene, ledger: bool, outputs: bool) -> tuple[int, float]:
    mechanism = build(scene, ledger=ledger)
    span = Span(scene.turn or 1.0, SAMPLES_PER_TURN + 1 if outputs else 2)
    seconds = []
    for _ in range(REPEATS + 1):
        run = Run(mechanism, span, RTOL, choose_method(mechanism, rtol=RTOL), outputs=outputs)
        code = run.trajectory()[2]
        if code != status.DONE:
            raise ValueError(f"cannot measure the cost: {run._failure(code, None)}")
        seconds.append(run.wall)
    steps = int(run.counts[run.types.STEPS])
    return steps, statistics.median(seconds[1:]) / steps


def table(rows: list[Part], title: str = "cost of the parts") -> list[str]:
    """The rows as Markdown."""
    measured = rows[0].step is not None
    head = [title, "clearance joints", "states", "operations a right-hand side", "output channels"]
    if measured:
        head += ["method", "steps", "a step", "and ledger", "and outputs"]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for r in rows:
        cells = [r.name, r.joints, r.states, r.operations, r.channels]
        if measured:
            times = (f"{1e6 * t:.2f} us" for t in (r.step, r.ledger_step, r.output_step))
            cells += [r.method, r.steps, *times]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return lines


def plain(rows: list[Part]) -> list[dict]:
    """The rows as JSON types; times in seconds."""
    return [asdict(r) for r in rows]
