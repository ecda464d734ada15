"""Time up to which trajectories of a scene can be compared: until neighbours have parted."""

import math
from dataclasses import dataclass

import numpy as np

from clearance.mechanism.build import Mechanism, build
from clearance.run.options import Solver, Span
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.stepping import status

# of the natural size of each state: how far apart neighbouring trajectories start
DISPLACEMENT = 1e-12
# of the clearance: trajectories this far apart have nothing to do with each other any more
PARTED = 1e-2


class NotSolved(RuntimeError):
    """A solver gave up or cannot do the scene; the message states why."""


class Problem:
    """A scene over a span, sampled at equal times, by default without the energy ledger.

    Compared states are the eccentricities over the clearance, else all coordinates over their
    natural size.
    """

    def __init__(self, scene: Scene, until: float, samples: int = 201, ledger: bool = False):
        self.scene, self.until = scene, until
        self.mechanism: Mechanism = build(scene, ledger=ledger)
        if self.mechanism.size == 0:
            raise ValueError(
                "this scene has no degree of freedom: there is nothing to integrate and no error "
                "to measure"
            )
        self.times = np.linspace(0.0, until, samples)
        free, moving = len(self.mechanism.plan.free), len(self.mechanism.eccentric)
        self.compared = np.arange(free, free + 2 * moving) if moving else np.arange(free)
        self.measure = "eccentricity / clearance" if moving else "coordinate / natural size"

    def solved(
        self, method: str, rtol: float, displacement: float = 0.0, max_steps: int | None = None
    ) -> tuple[Run, np.ndarray]:
        """The run by a stepper of this package, its states at the times.

        displacement: of the compared states at the start, over their sizes.
        """
        span = Span(self.until, self.times.size)
        run = Run(self.mechanism, span, Solver(rtol, method, max_steps=max_steps), outputs=False)
        y = run.state.y
        y[:] = self.mechanism.y0
        y[self.compared] += displacement * self.mechanism.scale[self.compared]
        _, rows, code = run.trajectory()
        if code != status.DONE:
            raise NotSolved(f"at t = {run.state.time:.6g} s: {status.MESSAGES[code]}")
        return run, rows

    def states(self, method: str, rtol: float, displacement: float = 0.0) -> np.ndarray:
        return self.solved(method, rtol, displacement)[1]

    def distance(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Largest deviation of the compared states at each time."""
        return np.abs((a - b)[:, self.compared] / self.mechanism.scale[self.compared]).max(axis=1)


@dataclass(frozen=True)
class Horizon:
    """Time up to which a trajectory can be compared; None where that is throughout."""

    time: float | None
    growth: float  # decades per second at which neighbours part (0 where they do not)
    checked: float  # seconds looked at

    def sentence(self, turn: float | None) -> str:
        unit, length = ("turn", turn) if turn else ("s", 1.0)
        if self.time is None:
            return (
                f"comparable throughout ({self.checked / length:.3g} "
                f"{unit}{'s' if turn else ''} checked)"
            )
        parted = (
            f"; neighbouring trajectories part by {self.growth * length:.2g} decades per {unit}"
        )
        if not math.isfinite(self.growth):
            parted = ""
        return (
            f"comparable until {unit} {self.time / length:.3g}{parted}: beyond, compare statistics"
        )


def parting(problem: Problem, a: np.ndarray, b: np.ndarray, level: float = PARTED) -> float | None:
    """First sampled time at which two trajectories are further apart than `level`, or None."""
    apart = problem.distance(a, b) > level
    return float(problem.times[int(np.argmax(apart))]) if apart.any() else None


def horizon(scene: Scene, until: float, rtol: float, method: str, longest: int = 64) -> Horizon:
    """Time up to which a run at this tolerance can be compared with another: it and one at rtol /
    10 have not parted. At the tightest tolerances the other starts displaced by 1e-12 of the
    clearance.

    Looked for over 1, 2, 4 ... turns (of the drive, else sixteenths of the span), at most
    `longest`, at most `until`. The growth comes from two runs at tight tolerance whose starts
    differ by 1e-12 of the clearance.
    """
    unit = min(scene.turn or until / 16.0, until)
    count = 1
    while True:
        end = min(count * unit, until)
        # the kernel that the run has compiled already
        problem = Problem(scene, end, 200 * count + 1, ledger=True)
        beside = (rtol / 10.0,) if rtol >= 1e-13 else (rtol, DISPLACEMENT)
        tighter = problem.states(method, *beside)
        time = parting(problem, problem.states(method, rtol), tighter)
        if time is not None:
            return Horizon(time, growth(problem, method), end)
        if end >= until or count >= longest:
            return Horizon(None, 0.0, end)
        count *= 2


def growth(problem: Problem, method: str) -> float:
    """Decades per second at which trajectories from neighbouring starts part, by least squares on
    the logarithm.
    """
    a, b = (problem.states(method, 1e-11, apart) for apart in (0.0, DISPLACEMENT))
    apart = problem.distance(a, b)
    use = (apart > 0.0) & (np.maximum.accumulate(apart) < PARTED)
    if use.sum() < 3:
        return math.inf
    return float(np.polyfit(problem.times[use], np.log10(apart[use]), 1)[0])
