"""A run: its state and the calls that advance it."""

import math
import time as clock
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from clearance.machine.callback import Callback
from clearance.mechanism.build import Mechanism, changed
from clearance.results.record import Record
from clearance.run import observers
from clearance.run.interrupts import DeferredSignals
from clearance.run.method import Method
from clearance.run.options import (
    FINEST,
    Solver,
    Span,
    longest_step,
)
from clearance.run.outputs import take_sizes, watched_of
from clearance.run.start import QUASI_STATIC, stand_still, state_from
from clearance.stepping import status
from clearance.stepping.state import (
    COORDINATE,
    IMPACT_SPEED,
    KIND,
    PEAKS,
    SINCE,
    TOUCHING,
    VALUE,
    State,
)
from clearance.values.spots import FILM

if TYPE_CHECKING:
    from clearance.mechanism.dead_centre import DeadCentre

NEWTON_TOLERANCE = 0.05  # error left by Newton's method, of the error tolerance
ROWS = 2048  # samples held in memory between two pieces of output
LOG_ROWS = 4096
IMPACT_ROWS = 512
# steps between two looks at the progress, of usual films and of those solved online
BUDGET, SLOW_BUDGET = 2000, 20
STEP_LIMIT = 2**62


class Run:
    """One integration.

    state: its numbers and arrays, see stepping/state.py. observers: see `observers.Observer`.
        wall, cpu: time in the compiled loop, and CPU time there of a `trajectory` [s]. outputs:
        rows hold the outputs of the mechanism, else its state. code: last status.
    """

    def __init__(
        self, mechanism: Mechanism, span: Span, solver: Solver | None = None, outputs: bool = True
    ):
        self.mechanism = mechanism
        self.span = span
        self.solver = solver or Solver()
        self.outputs = outputs
        # smaller where offsets are differences of places of bodies, which errors are relative to
        self.rtol = max(self.solver.rtol * mechanism.share, FINEST)
        self.method = Method(self)
        online = [s for s in mechanism.sources.values() if isinstance(s, Callback)]
        for source in online:
            source.reset()
        self.budget = SLOW_BUDGET if online else BUDGET
        self.loop = import_module("clearance.stepping.loop")
        self.watched = watched_of(mechanism, span, outputs)
        if online:  # films with a memory begin anew
            self._begun()
        else:
            self._begin()
        self.observers: list[observers.Observer] = [observers.Kinks(self)]
        self.changes: list[tuple[float, dict[str, float]]] = []  # times and changes so far
        self.wall, self.cpu, self.contact_count, self.code = 0.0, 0.0, 0, status.RUNNING
        self.timed = False  # CPU time is measured
        self._looked: dict = {}  # extremes, and the steps after which they were looked up
        self.started = "as the scene says"
        self.options: dict = {}  # arguments of `simulate`, which make this run again
        self.facts: dict[str, dict] = {}  # of the result, group by group
        self.wearing = None  # the observer that sums wear, where some joint wears
        self.dead_centre: DeadCentre | None = None  # of a loop, once the run has failed there
        self.warned = True  # its record has warnings
        self.warnings: list[str] = []  # of its record

    def _begin(self) -> None:
        """Stand at the start, as an earlier run of the scene did that had the same numbers."""
        mechanism, method = self.mechanism, self.method
        about = mechanism.numbers, self.span, self.solver, self.outputs, method.fuses
        cast, roles, links = mechanism.remembered(("begun", *about), self._begun)
        self.state = cast(mechanism.par)
        method.roles = roles
        method.links = links | {"together": self.state.together}

    def _begun(self) -> tuple[Callable[[np.ndarray], State], list[str], dict]:
        """A maker of states at the start, roles and links of its method."""
        self.state = self._new_state()
        self.watched.install(self.state, self.solver.rtol)
        self.method.use(self.method.current)
        self.take_numbers()
        return self.state.mould(), self.method.roles, self.method.links

    def _new_state(self) -> State:
        """The state at the start, without numbers, with room for its stepper."""
        mechanism, size, solver = self.mechanism, self.mechanism.y0.size, self.solver
        states = mechanism.size or size
        layout = mechanism.layout
        state = State(
            size=size,
            states=states,
            work=mechanism.work0.size + 1,
            spots=len(mechanism.spots),
            outputs=len(layout.channels) if self.outputs else size,
            scratch=import_module(f"clearance.stepping.{self.method.current}").ROWS,
            rows=min(ROWS, self.span.samples + 1),  # full: more are to come
            log=min(LOG_ROWS, self.budget),
            impacts=IMPACT_ROWS,
            followed=len(layout.followed),
            **self.watched.sizes,
        )
        state.states, state.coordinates = states, mechanism.coordinates
        state.rtol, state.newton_tolerance = self.rtol, NEWTON_TOLERANCE
        state.convergence, state.effort = 1.0, 0.9
        state.evaluate_ledger = size > mechanism.size
        state.step_limit = solver.max_steps or STEP_LIMIT
        state.commits = layout.commits
        state.remembering = len(layout.remembering)
        state.may_switch = (
            solver.method == "auto" and self.method.current == "dop853" and mechanism.size > 0
        )
        state.contacts[:, KIND] = [spot.kind for _, spot in mechanism.spots]
        state.touchable = self.touchable
        state.contacts[:, COORDINATE] = [mechanism.places.get(e, -1) for e, _ in mechanism.spots]
        return state

    @property
    def touchable(self) -> int:
        """Number of spots where contacts start and end."""
        return sum(spot.kind != FILM for _, spot in self.mechanism.spots)

    def start_from(self, start: Record | str | Path) -> None:
        """Begin in another state than the scene's. Raises ValueError as `state_from` does."""
        begin = state_from(self.mechanism, start)
        mechanism = self.mechanism
        state = self.state
        self.started = begin.text
        self.options["start"] = vars(begin)
        state.y[: mechanism.size] = begin.values
        state.work[mechanism.layout.carried_places] = begin.carried
        state.turned[: len(begin.angles), 0] = begin.angles
        mechanism.turn(begin.turns)
        stand_still(mechanism, begin.text.startswith(QUASI_STATIC))
        mechanism.count_from(state.y, state.work)

    def begin_at(self, start) -> None:
        """Begin in a state amidst a motion, see `periodic.maps.Place`."""
        state = self.state
        self.mechanism.turn(start.turns)
        state.y[: start.y.size] = start.y
        state.work[self.mechanism.layout.carried_places] = start.carried
        for i in np.flatnonzero(start.touching):
            state.contacts[i, TOUCHING], state.contacts[i, SINCE] = 1.0, state.time - start.ages[i]
            state.contacts[i, IMPACT_SPEED] = state.work[i] = start.speeds[i]

    def at_end(self) -> "Run":
        """The run as it stands, without its output: what is read of it later."""
        end = Run.__new__(Run)
        state = self.state.without_output()
        vars(end).update(vars(self), state=state, observers=[], _looked={})
        return end

    def resize(self, **sizes: int) -> None:
        """Give arrays other lengths, see `stepping.state.layout`."""
        if not sizes.items() <= self.state.sizes.items():
            self.state = self.state.resized(**sizes)
        self.state.connect(self.mechanism.par, **self.method.links)

    # --- numbers
    def take_numbers(self) -> None:
        """Stand at the start, with the numbers that the mechanism has now."""
        self._take_start()
        take_sizes(self)

    def _take_start(self) -> None:
        """Start, length and longest step of the run."""
        state, mechanism, span = self.state, self.mechanism, self.span
        state.y[...], state.work[:-1] = mechanism.y0, mechanism.work0
        state.finish, state.samples = span.until, span.samples
        state.sample_every = span.until / (span.samples - 1)
        state.longest_step = self.solver.max_step or longest_step(mechanism, span)

    # --- where the run stands
    @property
    def extremes(self):
        """Located extremes so far."""
        return self._looked_at("extremes")

    @property
    def integrals(self):
        """Integrals over time so far."""
        return self.watched.integrals(self.state)

    @property
    def outermost(self) -> dict[str, float]:
        """Largest or smallest value of each watched quantity so far."""
        return self._looked_at("outermost")

    def _looked_at(self, name: str):
        """Something that `watched` finds in the state; at the end it is looked up once."""
        steps = int(self.state.steps)
        if self._looked.get("steps") != steps or self.state.time < self.span.until:
            self._looked = {"steps": steps}
        if name not in self._looked:
            self._looked[name] = getattr(self.watched, name)(self.state)
        return self._looked[name]

    def outputs_here(self) -> np.ndarray:
        """Outputs where the run stands."""
        return self.mechanism.outputs(self.state.time, self.state.y, self.state.work)

    def film_left(self, joint) -> float:
        """Film left over the clearance of a joint with nothing but a film."""
        return 1.0 - math.hypot(*self.offsets(joint).values()) / joint.film_reach

    def offsets(self, joint) -> dict[str, float]:
        """Coordinates in a joint's clearance, by name."""
        index = self.mechanism.layout.state
        return {
            name: self.state.y[index[f"{joint.key}/{name}"]] for _, name in joint.soft_coordinates
        }

    # --- changes on the way
    def every(self, period: float, function: Callable[["Run"], None]) -> None:
        """Call function(run) at each multiple of a period [s]; a step ends there, and it may
        `change` the run.
        """
        self.observers.append(observers.Every(period, function))

    def change(self, changes: dict[str, float]) -> None:
        """Change numbers of the scene where the run stands: {"joints/B/clearance": 1.1e-4}; see
        Scene.replaced.

        What depends on them follows: contact stiffness, film tables, natural sizes. The ledger
        counts as put in what the change does to the energy. Raises ValueError where a journal with
        nothing but a film would lie outside its clearance, and for changes that need another
        kernel.
        """
        before, state = self._energy(), self.state
        self.rebuild(state.time, changes)
        take_sizes(self)
        if outside := [
            j.label()
            for j in self.mechanism.places
            if j.film_reach is not None and self.film_left(j) <= 0.0
        ]:
            raise ValueError(f"{outside[0]}: its journal lies outside the changed clearance")
        self.mechanism.kernel("rhs")(state.time, state.y, self.mechanism.par, state.work, state.f)
        if before is not None:
            state.y[self.mechanism.size] += self._energy() - before
        self.interrupt_steps()

    def rebuild(self, time: float, changes: dict[str, float]) -> None:
        """Take the mechanism with numbers that change at a time [s]; the state stays as it is."""
        self.take_mechanism(changed(self.mechanism, changes, time))
        self.changes.append((float(time), changes))

    def take_mechanism(self, mechanism: Mechanism) -> None:
        """Take a mechanism of the same structure with other numbers."""
        self.mechanism = mechanism
        self.state.connect(mechanism.par, **self.method.links)

    def interrupt_steps(self) -> None:
        """Let the next step use nothing of those before: the state or its rates have been
        changed.
        """
        state = self.state
        state.jacobian_state = state.lu_state = state.has_predictor = 0
        state.last_h = state.last_step = 0.0
        state.interval = -1.0

    def _energy(self) -> float | None:
        """Kinetic and potential energy where the run stands; None without a ledger or outputs."""
        layout = self.mechanism.layout
        if not (self.outputs and layout.ledger):
            return None
        row = self.outputs_here()
        return float(row[layout.output["energy/kinetic"]] + row[layout.output["energy/potential"]])

    # --- advancing
    def advance(self, until: float = math.inf) -> int:
        """One call of the compiled loop, not beyond a time [s]; its output goes to the observers.

        A status code.
        """
        state = self.state
        until = min(until, self.span.until)
        state.end = min(until, self._next_stop())
        before = state.steps
        tried = int(state.steps + state.rejected)
        since = state.time
        began = clock.perf_counter()
        worked = self._worked()
        code = self.loop.run(state.address, self.budget)
        self.cpu += self._worked() - worked
        self.wall += clock.perf_counter() - began
        self.mechanism.structure.compiled.steps += int(state.steps - before)
        self._hand_over()
        tried = int(state.steps + state.rejected) - tried
        code = self.method.judge(code, tried, state.time - since)
        if code == status.DONE:
            self._reach()
        return status.RUNNING if code == status.DONE and self.state.time < until else code

    def _worked(self) -> float:
        """CPU time of this thread [s] where it is measured: on some systems it costs a step."""
        return clock.thread_time() if self.timed else 0.0

    def advance_to(self, time: float) -> int:
        """Advance to a time [s], in as many calls as it takes. The last status code."""
        code = status.RUNNING
        while code == status.RUNNING:
            code = self.advance(time)
        return code

    def _hand_over(self) -> None:
        """Give a piece of output to the observers, and its room back to the loop."""
        state = self.state
        samples = state.times[: state.rows_filled], state.rows[: state.rows_filled]
        contacts = state.impacts[: state.impacts_filled]
        log = state.log[: state.log_filled]
        trail = state.trail[: state.log_filled]
        self.contact_count += len(contacts)
        state.rows_filled = state.impacts_filled = state.log_filled = 0
        labels = self.labels() if len(contacts) else []
        for observer in self.observers:
            observer.samples(*samples)
            observer.contacts(labels, contacts)
            observer.steps(log)
            if self.mechanism.layout.followed:
                observer.follow(log, trail)

    def labels(self) -> list[str]:
        """Names of the spots where elements may touch."""
        return [spot.label(element) for element, spot in self.mechanism.spots]

    def _next_stop(self) -> float:
        """The first time from here on at which an observer lets a step end."""
        now, stop = float(self.state.time), math.inf
        for observer in self.observers:
            stop = min(stop, observer.after(now))
        return stop

    def _reach(self) -> None:
        """Call the observers that are due at the present time."""
        for observer in self.observers:
            if observer.due(float(self.state.time)):
                observer.reach(self)

    def go(self) -> int:
        """Advance until the end, an error, or an observer that ends it. The last status code."""
        self.code = status.RUNNING
        while self.code == status.RUNNING:
            self.code = self.advance()
            for observer in self.observers:
                self.code = observer.piece(self, self.code)
        return self.code

    def trajectory(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Run to the end in memory: times, rows (states, where the run has no outputs) and the last
        status code.
        """
        self.wall, self.cpu, self.timed = 0.0, 0.0, True
        trajectory = observers.Trajectory()
        with DeferredSignals() as held:
            self.observers += [trajectory, observers.Interrupts(held.check)]
            code = self.go()
        return np.concatenate(trajectory.times), np.concatenate(trajectory.rows), code

    def open_contacts(self) -> np.ndarray:
        """Contacts that the end of the run cuts off."""
        rows, state = [], self.state
        for j, c in enumerate(state.contacts):
            if c[TOUCHING] > 0.0:
                force, depth = state.peaks[int(c[PEAKS]) :][:2, VALUE]
                rows.append(
                    (j, c[SINCE], c[IMPACT_SPEED], force, depth, state.time - c[SINCE], 0.0)
                )
        return np.array(rows)
