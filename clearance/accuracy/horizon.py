"""A scene as an initial value problem that any solver can be given: one compiled right-hand side,
one error measure.
"""

import dis
import math
import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from clearance.mechanism.build import Mechanism, build
from clearance.run.options import Solver, Span
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.stepping import status

REFERENCE_RTOL = 1e-13
CHECK_RTOL = 1e-12
# of the natural size of each state: how far apart neighbouring trajectories start
DISPLACEMENT = 1e-12
# of the clearance: trajectories this far apart have nothing to do with each other any more
PARTED = 1e-2


class NotSolved(RuntimeError):
    """A solver gave up or cannot do the scene; the message states why."""


@dataclass(frozen=True)
class Solution:
    """States at the problem's times, and what they cost: CPU seconds of one thread.

    call: of the complete call, where seconds are those of the compiled loop alone.
    """

    states: np.ndarray
    seconds: float
    steps: int
    evaluations: int
    contacts: int = 0
    call: float = math.nan


class Problem:
    """A scene over a span, sampled at equal times, by default without the energy ledger.

    The error of a solution is the largest deviation of the compared states from the reference.
    These are the eccentricities over the clearance, else all coordinates over their natural size.
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

    @property
    def films(self) -> bool:
        return any(j.film is not None for j in self.scene.clearance_joints)

    @property
    def contacts(self) -> bool:
        return any(j.impacts for j in self.scene.clearance_joints)

    @property
    def remembers(self) -> bool:
        """True where a contact law depends on the impact speed: such a law needs a solver that
        locates events.
        """
        laws = [j.contact.law.function for j in self.scene.clearance_joints if j.impacts]
        return any(
            i.argval == "impact_speed"
            for f in laws
            for i in dis.get_instructions(f)
            if "LOAD" in i.opname
        )

    def start(self, displacement: float = 0.0) -> np.ndarray:
        y = self.mechanism.y0.copy()
        y[self.compared] += displacement * self.mechanism.scale[self.compared]
        return y

    def work(self) -> np.ndarray:
        return np.append(self.mechanism.work0, 0.0)

    def own(
        self, method: str, rtol: float, displacement: float = 0.0, max_steps: int | None = None
    ) -> Solution:
        """Solved by a stepper of this package, warm; seconds are CPU time of the compiled loop."""
        began = time.thread_time()
        span = Span(self.until, self.times.size)
        run = Run(self.mechanism, span, Solver(rtol, method, max_steps=max_steps), outputs=False)
        run.state.y[:] = self.start(displacement)
        _, rows, code = run.trajectory()
        if code != status.DONE:
            raise NotSolved(f"at t = {run.state.time:.6g} s: {status.MESSAGES[code]}")
        counts = int(run.state.steps), int(run.state.evaluations), run.contact_count
        return Solution(rows, run.cpu, *counts, call=time.thread_time() - began)

    def distance(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Largest deviation of the compared states at each time."""
        return np.abs((a - b)[:, self.compared] / self.mechanism.scale[self.compared]).max(axis=1)

    def error(self, states: np.ndarray) -> float:
        return float(self.distance(states, self.reference).max())

    @cached_property
    def reference_methods(self) -> tuple[str, str]:
        """The method of the reference, and the second one that checks it."""
        return ("radau9", "radau5") if self.films else ("dop853", "radau9")

    @cached_property
    def reference(self) -> np.ndarray:
        return self.own(self.reference_methods[0], REFERENCE_RTOL).states

    @cached_property
    def doubt(self) -> float:
        """Deviation of a second method at its tightest from the reference: no error below this
        means anything.
        """
        return self.error(self.own(self.reference_methods[1], CHECK_RTOL).states)


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
        tighter = (
            problem.own(method, rtol / 10.0)
            if rtol >= 1e-13
            else problem.own(method, rtol, DISPLACEMENT)
        )
        time = parting(problem, problem.own(method, rtol).states, tighter.states)
        if time is not None:
            return Horizon(time, growth(problem, method), end)
        if end >= until or count >= longest:
            return Horizon(None, 0.0, end)
        count *= 2


def growth(problem: Problem, method: str) -> float:
    """Decades per second at which trajectories from neighbouring starts part, by least squares on
    the logarithm.
    """
    a, b = problem.own(method, 1e-11).states, problem.own(method, 1e-11, DISPLACEMENT).states
    apart = problem.distance(a, b)
    use = (apart > 0.0) & (np.maximum.accumulate(apart) < PARTED)
    if use.sum() < 3:
        return math.inf
    return float(np.polyfit(problem.times[use], np.log10(apart[use]), 1)[0])
