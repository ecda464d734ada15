"""Other people's integrators on the same compiled right-hand side.

All optional but scipy; imported when requested.

A peer is prepared once (whatever it compiles then is reported apart) and then solves a problem at a
tolerance. Peers get the same natural scales as absolute tolerances. A dry law that remembers the
impact speed is given to them as the phases between its contact events, located by their own root
finding.
"""

import contextlib
import dis
import math
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np

from clearance.accuracy import horizon
from clearance.accuracy.horizon import NotSolved
from clearance.machine import store
from clearance.stepping.locating import FREE
from clearance.stepping.state import SPOT_VALUES

BIGGEST_STEP = 1.0 / 96.0  # of a turn, where contacts must not be jumped over
# of a turn, after a contact event: a longer one could jump over the entire contact
FIRST_STEP = 1e-7
BUDGET = 20.0  # seconds a peer may spend on one solution
PHASES = 100_000


REFERENCE_RTOL = 1e-13
CHECK_RTOL = 1e-12


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


class Problem(horizon.Problem):
    """A scene as an initial value problem that any solver can be given: one compiled right-hand
    side, one error measure.

    The error of a solution is the largest deviation of the compared states from the reference.
    """

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

    def start(self) -> np.ndarray:
        return self.mechanism.y0.copy()

    def work(self) -> np.ndarray:
        return np.append(self.mechanism.work0, 0.0)

    def solution(
        self, method: str, rtol: float, displacement: float = 0.0, max_steps: int | None = None
    ) -> Solution:
        """Solved by a stepper of this package, warm; seconds are CPU time of the compiled loop."""
        began = time.thread_time()
        run, rows = self.solved(method, rtol, displacement, max_steps)
        counts = int(run.state.steps), int(run.state.evaluations), run.contact_count
        return Solution(rows, run.cpu, *counts, call=time.thread_time() - began)

    def error(self, states: np.ndarray) -> float:
        return float(self.distance(states, self.reference).max())

    @cached_property
    def reference_methods(self) -> tuple[str, str]:
        """The method of the reference, and the second one that checks it."""
        return ("radau9", "radau5") if self.films else ("dop853", "radau9")

    @cached_property
    def reference(self) -> np.ndarray:
        return self.solution(self.reference_methods[0], REFERENCE_RTOL).states

    @cached_property
    def doubt(self) -> float:
        """Deviation of a second method at its tightest from the reference: no error below this
        means anything.
        """
        return self.error(self.solution(self.reference_methods[1], CHECK_RTOL).states)


class OverBudget(Exception):
    """A peer's right-hand side was called after its time was up."""


@cache
def dispatched(kernel: Callable) -> Callable:
    """A kernel behind numba's own call from Python, the quickest there is; compiled before any
    peer is timed.
    """
    if not store.COMPILED:
        return kernel
    import numba

    pointer, kernel_at = store.address(kernel, store.KERNEL), store.caller(store.KERNEL)

    @numba.njit(store.KERNEL_SIGNATURE)
    def call(t, y, par, work, out):
        kernel_at(pointer)(t, y, par, work, out)

    return call


class Phase:
    """The right-hand side and the contact events as plain Python callables, with the impact speeds
    frozen.
    """

    def __init__(self, problem: Problem):
        m = problem.mechanism
        self.problem, self.par, self.work = problem, m.par, problem.work()
        self.rhs, self.f = dispatched(m.kernel("rhs")), np.zeros(m.y0.size)
        self.y = np.zeros(m.y0.size)
        self.joints = [
            i for i, j in enumerate(problem.scene.clearance_joints) if j.contact is not None
        ]
        self.count = len(problem.scene.clearance_joints)
        self.touching = [False] * self.count
        self.events = dispatched(m.kernel("events")) if self.joints else None
        self.spots = np.zeros((max(self.count, 1), SPOT_VALUES))  # penetration, its rate
        self.evaluations, self.deadline = 0, time.perf_counter() + BUDGET

    def __call__(self, t, y):
        self.evaluations += 1
        if self.evaluations % 256 == 0 and time.perf_counter() > self.deadline:
            raise OverBudget
        self.y[:] = y  # solvers hand out read-only and strided arrays
        self.rhs(t, self.y, self.par, self.work, self.f)
        return self.f.copy()

    def penetration(self, joint: int, t, y) -> float:
        self.y[:] = y
        self.events(t, self.y, self.par, self.work, self.spots.ravel())
        return self.spots[joint, 0]

    def begin(self, t, y) -> None:
        for j in self.joints:
            self.work[j] = FREE
            if self.penetration(j, t, y) > 0.0:
                self.switch(j, t, y)

    def switch(self, joint: int, t, y) -> None:
        self.penetration(joint, t, y)
        self.work[joint] = FREE if self.touching[joint] else max(self.spots[joint, 1], 0.0)
        self.touching[joint] = not self.touching[joint]


def scales(problem: Problem, rtol: float) -> np.ndarray:
    return rtol * problem.mechanism.scale


def biggest_step(problem: Problem) -> float:
    return (problem.scene.turn or problem.until) * BIGGEST_STEP if problem.contacts else np.inf


def timed(solve: Callable) -> Callable:
    """Turn `solve(problem, phase, rtol) -> (states, steps)` into a peer's solver."""

    def measured(problem: Problem, rtol: float) -> Solution:
        phase = Phase(problem)
        began = time.thread_time()
        try:
            states, steps = solve(problem, phase, rtol)
        except OverBudget:
            raise NotSolved(f"not done after {BUDGET:g} s") from None
        seconds = time.thread_time() - began
        if (
            states.shape != (problem.times.size, problem.mechanism.y0.size)
            or not np.isfinite(states).all()
        ):
            raise NotSolved("stopped before the end")
        return Solution(states, seconds, steps, phase.evaluations)

    return measured


# --- scipy
def _scipy(method: str, problem: Problem, phase: Phase, rtol: float):
    from scipy.integrate import solve_ivp

    options = {
        "method": method,
        "rtol": max(rtol, 3e-14),
        "atol": scales(problem, rtol),
        "max_step": biggest_step(problem),
    }
    if not problem.remembers:
        solution = solve_ivp(
            phase, (0.0, problem.until), problem.start(), t_eval=problem.times, **options
        )
        if not solution.success:
            raise NotSolved(solution.message)
        return solution.y.T, len(solution.t)

    def event(joint, direction):
        function = partial(phase.penetration, joint)
        # solve_ivp reads attributes of a plain function
        wrapped = lambda t, y: function(t, y)  # noqa: E731
        wrapped.terminal, wrapped.direction = True, direction
        return wrapped

    def leg(t, y, times):
        events = [event(j, -1.0 if phase.touching[j] else 1.0) for j in phase.joints]
        first = min(FIRST_STEP * (problem.scene.turn or problem.until), problem.until - t)
        solution = solve_ivp(
            phase, (t, problem.until), y, t_eval=times, events=events, first_step=first, **options
        )
        if not solution.success:
            raise NotSolved(solution.message)
        # an empty list where no output time was passed
        states = np.reshape(solution.y, (y.size, -1)).T
        hit = next(
            (j for j, e in zip(phase.joints, solution.t_events, strict=True) if e.size), None
        )
        if hit is None:
            return problem.until, None, None, states
        index = phase.joints.index(hit)
        return float(solution.t_events[index][0]), solution.y_events[index][0], hit, states

    return _legs(problem, phase, leg), 0


def _legs(problem: Problem, phase: Phase, leg: Callable):
    """Put phases between contact events together: leg(t, y, times) -> (t, y, joint or None, states
    at times).
    """
    t, y, rows = 0.0, problem.start(), []
    phase.begin(t, y)
    for _ in range(PHASES):
        rest = problem.times[sum(map(len, rows)) :]
        t, y, joint, states = leg(t, y, rest)
        rows.append(states)
        if joint is None:
            return np.concatenate(rows)
        phase.switch(joint, t, y)
    raise NotSolved(f"more than {PHASES} contacts")


# --- SUNDIALS through scikit-sundae
def _cvode(method: str, problem: Problem, phase: Phase, rtol: float):
    from sksundae.cvode import CVODE

    def right(t, y, yp):
        yp[:] = phase(t, y)

    options = {
        "method": method,
        "rtol": rtol,
        "atol": scales(problem, rtol),
        "max_num_steps": 10_000_000,
    }
    if problem.contacts:
        options["max_step"] = biggest_step(problem)
    if not problem.remembers:
        solution = CVODE(right, **options).solve(problem.times, problem.start())
        if not solution.success:
            raise NotSolved(str(solution.message))
        return solution.y, int(solution.nfev)

    def roots(t, y, values):
        for i, j in enumerate(phase.joints):
            values[i] = phase.penetration(j, t, y)

    def leg(t, y, times):
        roots.terminal = [True] * len(phase.joints)
        roots.direction = [-1 if phase.touching[j] else 1 for j in phase.joints]
        first = min(FIRST_STEP * (problem.scene.turn or problem.until), problem.until - t)
        solver = CVODE(
            right, eventsfn=roots, num_events=len(phase.joints), first_step=first, **options
        )
        grid = np.union1d([t], times)
        padded = grid if len(grid) > 2 else np.linspace(t, problem.until, 3)
        solution = solver.solve(padded, y)
        if not solution.success:
            raise NotSolved(str(solution.message))
        wanted = np.isin(solution.t, times)
        if solution.t_events is None or not len(solution.t_events):
            return problem.until, None, None, solution.y[wanted]
        hit = phase.joints[int(np.argmax(np.abs(solution.i_events[0])))]
        return (
            float(solution.t_events[0]),
            solution.y_events[0],
            hit,
            solution.y[wanted & (solution.t < solution.t_events[0])],
        )

    return _legs(problem, phase, leg), 0


def _ida(problem: Problem, phase: Phase, rtol: float):
    from sksundae.ida import IDA

    def residual(t, y, yp, res):
        res[:] = yp - phase(t, y)

    if problem.contacts:
        raise NotSolved("IDA is only asked for films here")
    solver = IDA(residual, rtol=rtol, atol=scales(problem, rtol), max_num_steps=10_000_000)
    start = problem.start()
    solution = solver.solve(problem.times, start, phase(0.0, start))
    if not solution.success:
        raise NotSolved(str(solution.message))
    return solution.y, int(solution.nfev)


# --- numbalsoda
class NumbaLsoda:
    """numbalsoda's LSODA or DOP853: compiled throughout, no events.

    It takes one absolute tolerance for all states, so it gets them divided by their natural sizes.
    """

    def __init__(self, solver: str, problem: Problem):
        import numba

        # else its messages come out at the end of the process
        os.environ.setdefault("GFORTRAN_UNBUFFERED_ALL", "y")
        import numbalsoda

        if problem.remembers:
            raise NotSolved("no events: it cannot do a law that remembers the impact speed")
        m = problem.mechanism
        entry, kernel_at = store.address(m.kernel("rhs"), store.KERNEL), store.caller(store.KERNEL)
        size, numbers, works = m.y0.size, m.par.size, problem.work().size
        inputs = numbers + works

        @numba.cfunc(numbalsoda.lsoda_sig)
        def right(t, z, dz, data):
            inside = numba.carray(data, (inputs + 3 * size,))
            scaled, rates = numba.carray(z, (size,)), numba.carray(dz, (size,))
            sizes, y, f = (
                inside[inputs : inputs + size],
                inside[inputs + size : inputs + 2 * size],
                inside[inputs + 2 * size :],
            )
            for i in range(size):
                y[i] = scaled[i] * sizes[i]
            kernel_at(entry)(t, y, inside[:numbers], inside[numbers:inputs], f)
            for i in range(size):
                rates[i] = f[i] / sizes[i]

        self.right, self.sizes = right, m.scale.copy()
        self.data = np.concatenate([m.par, problem.work(), self.sizes, np.zeros(2 * size)])
        self.solver = getattr(numbalsoda, solver)
        self.limit = {"mxstep": 10_000_000} if solver == "lsoda" else {}

    def __call__(self, problem: Problem, rtol: float) -> Solution:
        start = problem.start() / self.sizes
        with silent():
            began = time.thread_time()
            states, success = self.solver(
                self.right.address,
                start,
                problem.times,
                data=self.data,
                rtol=rtol,
                atol=rtol,
                **self.limit,
            )
            states = states * self.sizes
            seconds = time.thread_time() - began
        if not success or not np.isfinite(states).all():
            raise NotSolved("it stopped before the end")
        return Solution(states, seconds, 0, 0)


@contextlib.contextmanager
def silent():
    """Fortran prints straight to the standard output."""
    sys.stdout.flush()
    saved = os.dup(1)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)


def _always(solve: Callable) -> Callable:
    return lambda problem: timed(solve)


#: name -> (module that must be there, prepare(problem) -> solve(problem, rtol)); its curve has the
#: tolerances `solve.rtols`, where there are any
PEERS: dict[str, tuple[str, Callable]] = {
    "scipy Radau": ("scipy", _always(partial(_scipy, "Radau"))),
    "scipy BDF": ("scipy", _always(partial(_scipy, "BDF"))),
    "scipy LSODA": ("scipy", _always(partial(_scipy, "LSODA"))),
    "scipy DOP853": ("scipy", _always(partial(_scipy, "DOP853"))),
    "numbalsoda LSODA": ("numbalsoda", partial(NumbaLsoda, "lsoda")),
    "numbalsoda DOP853": ("numbalsoda", partial(NumbaLsoda, "dop853")),
    "CVODE BDF": ("sksundae", _always(partial(_cvode, "BDF"))),
    "CVODE Adams": ("sksundae", _always(partial(_cvode, "Adams"))),
    "IDA": ("sksundae", _always(_ida)),
}
