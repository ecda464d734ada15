"""A run: its state and the calls that advance it."""

import json
import logging
import math
import time as clock
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np

from clearance.machine import store
from clearance.machine.callback import Callback
from clearance.mechanism.build import Mechanism, changed
from clearance.mechanism.dead_centre import DeadCentre
from clearance.results.memory import Memory, MemoryRecord
from clearance.results.record import Record
from clearance.results.recorder import Recorder
from clearance.results.stream import Unwritable
from clearance.run import observers
from clearance.run.interrupts import DeferredSignals, ended
from clearance.run.options import (
    FINEST,
    STAGED,
    Solver,
    Span,
    choose_method,
    implicit,
    kernel_roles,
    longest_step,
)
from clearance.run.outputs import Watched
from clearance.run.start import end_state, state_from
from clearance.stepping import status
from clearance.stepping.announce import announced
from clearance.stepping.state import (
    CLEARANCE,
    CONTACTS,
    COORDINATE,
    FUNCTIONS,
    IMPACT_SPEED,
    KERNELS,
    KIND,
    PEAKS,
    PULL,
    RATE_X,
    RATE_Y,
    SINCE,
    STEPPER,
    TOUCHING,
    VALUE,
    State,
)
from clearance.stepping.types import MOMENTS
from clearance.values.spots import FILM

LOG = logging.getLogger("clearance")
NEWTON_TOLERANCE = 0.05  # error left by Newton's method, of the error tolerance
ROWS = 2048  # samples held in memory between two pieces of output
LOG_ROWS = 4096
IMPACT_ROWS = 512
# steps between two looks at the progress, of usual films and of those solved online
BUDGET, SLOW_BUDGET = 2000, 20
STEP_LIMIT = 2**62
# tolerances, and share, of the energy that count as turned over in a motion that turns over less:
# then a residual of one tolerance is below diagnosis.doubtful
COASTING, LEAST = 1e3, 1e-3
# trial steps between two looks at the pace, and those of a run at which it ends
PACE, ENDLESS = 200_000, 1e9
CHANGES = 8  # of the method where films stop it, at most


class Run:
    """One integration.

    state: its numbers and arrays, see stepping/state.py. observers: see `observers.Observer`.
        wall, cpu: time in the compiled loop, and CPU time there of a `trajectory` [s]. outputs:
        rows hold the outputs of the mechanism, else its state. code: last status.
    """

    def __init__(
        self, mechanism: Mechanism, span: Span, solver: Solver | None = None, outputs: bool = True
    ):
        self.mechanism, self.span, self.solver, self.outputs = (
            mechanism,
            span,
            solver or Solver(),
            outputs,
        )
        # smaller where offsets are differences of places of bodies, which errors are relative to
        self.rtol = max(self.solver.rtol * mechanism.share, FINEST)
        self.method, self.reason = choose_method(mechanism, self.solver.method, self.rtol)
        online = [s for s in mechanism.sources.values() if isinstance(s, Callback)]
        for source in online:
            source.reset()
        self.budget = SLOW_BUDGET if online else BUDGET
        self.loop = import_module("clearance.stepping.loop")
        self.watched = Watched(mechanism, span.until, outputs)
        self.state = self._new_state()
        self.watched.install(self.state, self.solver.rtol)
        self.take(self.method)
        self.take_numbers()
        self.observers: list[observers.Observer] = [observers.Kinks(self)]
        self.changes: list[tuple[float, dict[str, float]]] = []  # times and changes so far
        self.paced = False  # it goes to its end, and ends where it crawls
        self.pace = 0, 0.0  # trial steps and time since the last look
        self.wall, self.cpu, self.contact_count, self.code = 0.0, 0.0, 0, status.RUNNING
        self.timed = False  # CPU time is measured
        self.started = "as the scene says"
        self.options: dict = {}  # arguments of `simulate`, which make this run again
        self.facts: dict[str, dict] = {}  # of the result, group by group
        self.wearing = None  # the observer that sums wear, where some joint wears
        self.dead_centre: DeadCentre | None = None  # of a loop, once the run has failed there
        self.warned = True  # its record has warnings

    def _new_state(self) -> State:
        """The state at the start, without numbers, with room for its stepper."""
        mechanism, size, solver = self.mechanism, self.mechanism.y0.size, self.solver
        states, layout = mechanism.size or size, mechanism.layout
        state = State(
            size=size,
            states=states,
            work=mechanism.work0.size + 1,
            spots=len(mechanism.spots),
            outputs=len(layout.channels) if self.outputs else size,
            scratch=import_module(f"clearance.stepping.{self.method}").ROWS,
            rows=min(ROWS, self.span.samples),
            log=LOG_ROWS,
            impacts=IMPACT_ROWS,
            followed=len(layout.followed),
            **self.watched.sizes,
        )
        state.states, state.coordinates = states, mechanism.coordinates
        state.rtol, state.newton_tolerance = self.rtol, NEWTON_TOLERANCE
        state.convergence, state.effort = 1.0, 0.9
        state.evaluate_ledger = size > mechanism.size
        state.step_limit = solver.max_steps or STEP_LIMIT
        state.commits, state.remembering = layout.commits, len(layout.remembering)
        state.may_switch = (
            solver.method == "auto" and self.method == "dop853" and mechanism.size > 0
        )
        state.contacts[:, KIND] = [spot.kind for _, spot in mechanism.spots]
        state.touchable = self._touchable
        state.contacts[:, COORDINATE] = [mechanism.places.get(e, -1) for e, _ in mechanism.spots]
        return state

    @property
    def _touchable(self) -> int:
        """Number of spots where contacts start and end."""
        return sum(spot.kind != FILM for _, spot in self.mechanism.spots)

    def start_from(self, start: Record | str | Path) -> None:
        """Begin in another state than the scene's. Raises ValueError as `state_from` does."""
        begin, mechanism, state = state_from(self.mechanism, start), self.mechanism, self.state
        self.started, self.options["start"] = begin.text, vars(begin)
        state.y[: mechanism.size] = begin.values
        state.work[mechanism.layout.carried_places] = begin.carried
        state.turned[: len(begin.angles), 0] = begin.angles
        mechanism.turn(begin.turns)
        mechanism.count_from(state.y, state.work)

    def place(self, start) -> None:
        """Begin in a state amidst a motion, see `periodic.maps.Place`."""
        state = self.state
        self.mechanism.turn(start.turns)
        state.y[: start.y.size] = start.y
        state.work[self.mechanism.layout.carried_places] = start.carried
        for i in np.flatnonzero(start.touching):
            state.contacts[i, TOUCHING], state.contacts[i, SINCE] = 1.0, state.time - start.ages[i]
            state.contacts[i, IMPACT_SPEED] = state.work[i] = start.speeds[i]

    def take(self, method: str) -> None:
        """Use a stepper: its functions, the kernels it needs, its scratch."""
        mechanism = self.mechanism
        stepper = import_module(f"clearance.stepping.{method}")
        self.roles = kernel_roles(mechanism, method)
        if not self.outputs:
            self.roles.remove("observe")
        together = method in STAGED and mechanism.structure.together
        called = [*self.roles, "moments"] if together else self.roles
        # the loop takes a function for every role; one that is not needed is never called, so any
        # will do
        functions = {role: mechanism.kernel(role if role in called else "rhs") for role in KERNELS}
        functions |= {name: getattr(stepper, name) for name in STEPPER}
        touching = import_module("clearance.stepping.contacts") if self._touchable else None
        functions |= {name: getattr(touching, name, stepper.step) for name in CONTACTS}
        if not self.outputs:
            functions["observe"] = self.loop.copy_state
        self.links = {name: store.address(f, FUNCTIONS[name]) for name, f in functions.items()}
        self.links["together"] = self._room(stepper.STAGES if together else 0)
        self.resize(scratch=stepper.ROWS)
        self.state.order, self.state.degree = stepper.ORDER, stepper.DEGREE

    def _room(self, stages: int) -> np.ndarray:
        """Room for times and states of so many stages, and for their rates."""
        blocks = 2 * math.ceil(stages / MOMENTS)
        return np.zeros((blocks, MOMENTS * (self.mechanism.y0.size + 1)))

    def resize(self, **sizes: int) -> None:
        """Give arrays other lengths, see `stepping.state.layout`."""
        if not sizes.items() <= self.state.sizes.items():
            self.state = self.state.resized(**sizes)
        self.state.connect(self.mechanism.par, **self.links)

    def _become_implicit(self) -> None:
        """The explicit method of an automatic choice is held up by stability: go on with an
        implicit one.
        """
        method, state = implicit(self.rtol, stages_only=True), self.state
        LOG.info("stiff: going on with %s", method)
        self.reason = f"explicit at first; stiff, so implicit from t = {state.time:.6g} s on"
        self.method = f"{self.method}, {method}"
        state.may_switch = state.stiff_steps = 0
        state.stiffness = 0.0
        with announced():
            self.take(method)

    def _crawls(self, tried: int, passed: float) -> bool:
        """True where the run would need too many steps at its pace, unless it has a step limit.

        tried, passed: trial steps and time [s] of a call of the loop.
        """
        self.pace = self.pace[0] + tried, self.pace[1] + passed
        if self.pace[0] < PACE or self.solver.max_steps or not self.paced:
            return False
        (tried, passed), self.pace = self.pace, (0, 0.0)
        return passed * ENDLESS < tried * self.span.until

    def _resolves_films(self) -> bool:
        """True where rates in mixed joints are judged by what their films resolve from here on.

        That takes two to seven times the steps, so it is for runs that are stuck.
        """
        contacts = self.state.contacts
        loose = (contacts[:, RATE_X] > 0.0) & (contacts[:, PULL] == 0.0)
        if not loose.any():
            return False
        contacts[loose, PULL] = self.mechanism.acceleration
        self._begin_anew()
        return True

    def _begin_anew(self) -> None:
        """A phase begins, with a first step of its own."""
        self.interrupt_steps()
        self.state.started, self.state.free_step, self.state.contact_step = 2, 0.0, 0.0

    def _can_change(self) -> bool:
        """True where a film stops the method of an automatic choice; another one goes on from here.

        Radau's iterations may fail where a film's force turns round, which a step of Rodas5P
        survives, and the other way round.
        """
        films = any(j.film is not None for j in self.mechanism.scene.clearance_joints)
        if self.solver.method != "auto" or not films or self.method.count(", ") == CHANGES:
            return False
        method = "radau5" if self.method.endswith("rodas5p") else "rodas5p"
        LOG.info("stuck: going on with %s", method)
        self.reason += f"; stuck at t = {self.state.time:.6g} s, so {method} from there on"
        self.method = f"{self.method}, {method}"
        with announced():
            self.take(method)
        self._begin_anew()
        return True

    def _use_fused_stages(self) -> None:
        """Take the kernel that only a structure of many steps pays for; no bit changes."""
        method, alone = self.method.rpartition(", ")[2], not self.links["together"].size
        if alone and method in STAGED and self.mechanism.structure.together:
            self.take(method)

    # --- numbers
    def take_numbers(self) -> None:
        """Stand at the start, with the numbers that the mechanism has now."""
        self._take_start()
        self._take_numbers()

    def _take_start(self) -> None:
        """Start, length and longest step of the run."""
        state, mechanism, span = self.state, self.mechanism, self.span
        state.y[...], state.work[:-1] = mechanism.y0, mechanism.work0
        state.finish, state.samples = span.until, span.samples
        state.sample_every = span.until / (span.samples - 1)
        state.longest_step = self.solver.max_step or longest_step(mechanism, span)

    def _take_numbers(self) -> None:
        """Natural sizes of states and free ways of spots, from the numbers of the mechanism."""
        state, mechanism = self.state, self.mechanism
        state.scale[: mechanism.size], state.scale[mechanism.size :] = (
            mechanism.scale,
            mechanism.energy,
        )
        state.contacts[:, CLEARANCE] = mechanism.reach
        state.band[:] = self.loop.BAND * mechanism.measures
        self.watched.take_layers(state, mechanism)
        self._scale_film_rates()
        finer = self.rtol / self.solver.rtol
        state.scale[: mechanism.size] /= finer
        state.contacts[:, [CLEARANCE, RATE_X, RATE_Y]] /= finer

    def _scale_film_rates(self) -> None:
        """A thick film gives way slowly: its natural rate is acceleration over damping, not
        clearance times speed.

        Otherwise a rate that is right to rtol of its natural size would leave the film's force,
        damping times rate, wrong by much more.
        """
        mechanism, state = self.mechanism, self.state
        films = {j: offsets for j, offsets in mechanism.offsets.items() if j.film is not None}
        if not films:
            return
        pull = mechanism.acceleration
        state.contacts[:, PULL] = np.where(state.contacts[:, KIND] == FILM, pull, 0.0)
        rhs, rates, scale = mechanism.kernel("rhs"), mechanism.layout.rates, state.scale
        rest = self._rest()
        before, after = np.zeros_like(rest), np.zeros_like(rest)
        rhs(0.0, rest, mechanism.par, state.work, before)
        for joint, offsets in films.items():
            own_rates = range(rates.start, rates.stop)[offsets]
            for k in own_rates:
                # tilts have other units
                moved, share = rest.copy(), mechanism.scale[k] / mechanism.scale[own_rates[0]]
                moved[k] = scale[k]
                rhs(0.0, moved, mechanism.par, state.work, after)
                damping = abs(after[k] - before[k]) / scale[k]
                if damping * scale[k] > pull * share:
                    scale[k] = pull * share / damping
            row = state.contacts[[e for e, _ in mechanism.spots].index(joint)]
            row[RATE_X], row[RATE_Y] = scale[rates][offsets]

    def _rest(self) -> np.ndarray:
        """The start without rates in clearances, and centred there, unless that takes a journal
        whose offset is measured through its wall.
        """
        mechanism, rates = self.mechanism, self.mechanism.layout.rates
        rest = mechanism.y0.copy()
        for offsets in mechanism.offsets.values():
            rest[rates][offsets] = 0.0
        centred = rest.copy()
        for offsets in mechanism.offsets.values():
            centred[offsets] = 0.0
        if films := [j for j in mechanism.start.measured if j.film is not None]:
            row = mechanism.outputs(0.0, centred, self.state.work)
            gaps = [row[mechanism.layout.output[f"{j.key}/gap"]] for j in films]
            return centred if min(gaps) > 0.0 else rest
        return centred

    # --- where the run stands
    @property
    def extremes(self):
        """Located extremes so far."""
        return self.watched.extremes(self.state)

    @property
    def integrals(self):
        """Integrals over time so far."""
        return self.watched.integrals(self.state)

    def extreme(self, name: str) -> float:
        """Largest or smallest value of a watched quantity so far."""
        return self.extremes.of(name).value

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
        self._take_numbers()
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
        self.state.connect(mechanism.par, **self.links)

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
        began, worked, state = clock.perf_counter(), self._worked(), self.state
        until = min(until, self.span.until)
        state.end = min(until, self._next_stop())
        before, tried, since = state.steps, int(state.steps + state.rejected), state.time
        code = self.loop.run(state.address, self.budget)
        self.mechanism.structure.compiled.steps += int(state.steps - before)
        self.cpu += self._worked() - worked
        self.wall += clock.perf_counter() - began
        self._hand_over()
        if code == status.STIFF:
            self._become_implicit()
            return status.RUNNING
        self._use_fused_stages()
        tried = int(state.steps + state.rejected) - tried
        if code == status.RUNNING and self._crawls(tried, state.time - since):
            code = status.CRAWLING
        stuck = code in (status.STEP_TOO_SMALL, status.CRAWLING)
        if stuck and (self._resolves_films() or self._can_change()):
            return status.RUNNING
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
        contacts, log = state.impacts[: state.impacts_filled], state.log[: state.log_filled]
        trail = state.trail[: state.log_filled]
        self.contact_count += len(contacts)
        state.rows_filled = state.impacts_filled = state.log_filled = 0
        for observer in self.observers:
            observer.samples(*samples)
            observer.contacts(self.labels(), contacts)
            observer.steps(log)
            if self.mechanism.layout.followed:
                observer.follow(log, trail)

    def labels(self) -> list[str]:
        """Names of the spots where elements may touch."""
        return [spot.label(element) for element, spot in self.mechanism.spots]

    def _next_stop(self) -> float:
        """The first time from here on at which an observer lets a step end."""
        return min((o.after(self.state.time) for o in self.observers), default=math.inf)

    def _reach(self) -> None:
        """Call the observers that are due at the present time."""
        for observer in self.observers:
            if observer.due(self.state.time):
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

    # --- recording
    def record(
        self,
        sink,
        progress: Callable[[float], None] | None = None,
        checkpoint: float | None = None,
        check: Callable[[], None] = lambda: None,
    ) -> str | None:
        """Run to the end, handing the output to a sink; why it ended early, if it did.

        checkpoint: seconds of wall time between two checkpoints, for a sink that keeps them. check:
            called after each piece of output, raises KeyboardInterrupt where the run shall end.
        Raises Unwritable where a file takes no more; like an interrupt it comes when what was
        computed before is stored, if it can be.
        """
        self.paced = True
        self._sum_wear()
        scale = max(COASTING * self.solver.rtol, LEAST) * self.mechanism.energy
        recording = observers.Recording(
            self, Recorder(self.mechanism.layout.channels, sink, True, scale)
        )
        watching = [recording, observers.Interrupts(check)]
        for joint in self.mechanism.scene.joints:
            recording.recorder.add_facts(f"joints/{joint.name}", **joint.facts)
        if progress is not None:
            watching.append(observers.Progress(progress))
        if checkpoint is not None:
            from clearance.run.checkpoint import Checkpoints, restore

            if (before := sink.begin()) is not None:
                restore(self, recording, sink, before)
                LOG.info("going on from t = %.6g s", self.state.time)
            watching.append(Checkpoints(sink, recording, checkpoint))
        self.observers[:0] = watching
        began, failure = clock.perf_counter(), None
        try:
            if (code := self.go()) != status.DONE:
                failure = recording.diagnosis.failure(code)
        except KeyboardInterrupt as request:
            failure = f"{ended(request)} at t = {self.state.time:.9g} s"
            raise
        except Unwritable as error:
            failure = f"at t = {self.state.time:.9g} s: {error}"
            raise
        finally:
            done = self.code == status.DONE
            finished = "complete" if done else f"partial: {failure or 'stopped by an error'}"
            self._close(recording, finished, clock.perf_counter() - began)
        return failure

    def remembered(self, attributes: dict | None = None) -> tuple[MemoryRecord, str | None]:
        """Run to the end in memory: the record, and why it ended early, None where it did not.

        attributes: of the record, default those of this run.
        """
        sink = Memory(
            self.mechanism.layout.channels, self.attributes() if attributes is None else attributes
        )
        with DeferredSignals() as held:
            failure = self.record(sink, check=held.check)
        return sink.record, failure

    def _sum_wear(self) -> None:
        """Let the wear of joints be summed, unless it is."""
        if self.mechanism.layout.followed and self.wearing is None:
            from clearance.run.wear_sum import Wearing

            self.wearing = Wearing(self)
            self.observers.append(self.wearing)

    def _close(self, recording, finished: str, wall: float) -> None:
        """End the record; finished: its status."""
        recorder, state = recording.recorder, self.state
        recorder.impacts(self.labels(), self.open_contacts(), "open_contact")
        summary = self._summary(wall) | {"energy_residual_share": recorder.residual_share()}
        for joint, source in self.mechanism.sources.items():
            recorder.add_facts(f"joints/{joint.name}", **source.facts())
        if self.wearing is not None:
            self.wearing.add_facts(recorder)
        if self.changes:
            times, changes = zip(*self.changes, strict=True)
            recorder.add_facts(
                "changes",
                times=np.array(times),
                numbers=[json.dumps(c, sort_keys=True) for c in changes],
            )
        for group, facts in self.facts.items():
            recorder.add_facts(group, **facts)
        here = self.mechanism, state.y, state.work, state.time, state.turned[:, 0]
        recorder.add_facts("state", **end_state(*here))
        warnings = recording.diagnosis.warnings() if self.warned else []
        recorder.close(finished, summary, warnings, self.extremes, self.integrals)

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

    def attributes(self) -> dict:
        """Attributes of the result file: scene, kernel, start, options."""
        texts = self.mechanism.structure.texts
        about = {"kernel": "\n\n".join(texts[r] for r in self.roles), "start": self.started}
        about["options"] = json.dumps(self.options)
        return self.mechanism.scene.provenance | about

    def identity(self) -> dict:
        """Facts that two runs must share for one to continue the other."""
        for key in self.mechanism.layout.remembering:
            raise ValueError(
                f"{key}: its film has a memory that no checkpoint keeps; leave out checkpoint"
            )
        for joint in (j for j in self.mechanism.scene.joints if j.wear or j.wear_journal):
            raise ValueError(f"{joint.label()}: its wear is in no checkpoint; leave out checkpoint")
        facts = vars(self.span) | {"rtol": self.solver.rtol, "method": self.method}
        facts["start"] = self.state.y[: self.mechanism.size].tolist()
        facts["opened"] = list(self.mechanism.opened)
        return facts | {
            "max_step": self.state.longest_step,
            "max_steps": int(self.state.step_limit),
        }

    def _summary(self, wall: float) -> dict:
        counters = ("steps", "rejected", "evaluations", "jacobians", "factorisations")
        return {
            "method": self.method,
            "method_reason": self.reason,
            "rtol": self.solver.rtol,
            "atol": self.rtol * np.maximum(self.state.scale[: self.mechanism.size], 0.0),
            "wall_s": wall,
            "loop_s": self.wall,
            **{name: getattr(self.state, name) for name in counters},
        }
