"""The one simulate call: scene in, result file out.

Not called simulate.py: a module of that name would hide the function cl.simulate.
"""

import logging
import math
import shutil
import tempfile
import time as clock_of_the_wall
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np

from clearance import checks, fields
from clearance.checkpoint import PartsSink, restore, state_of
from clearance.compiling import announced
from clearance.demand import Demand, affordable
from clearance.elements.element import CONTACT
from clearance.extremes import Extremes, along, followed, guides, stretch_length, stretches
from clearance.interrupts import Held, ended
from clearance.mechanism import store
from clearance.mechanism.asking import Answerer
from clearance.mechanism.build import Mechanism, build
from clearance.mechanism.closing import last_position, lost_at, no_number
from clearance.mechanism.dead_centre import Motion, dead_centre
from clearance.recording import FileSink, LedgerWatch, Recorder, Unwritable, chosen, filters
from clearance.regimes import FULL_FILM, depth_warning, hole_warning
from clearance.results import Record, Result
from clearance.scene import Scene
from clearance.starting import end_state, state_from
from clearance.stepping import status as codes

LOG = logging.getLogger("clearance")
METHODS = ("dop853", "rodas5p", "radau5", "radau9")
NEWTON_TOLERANCE = 0.05  # error left by Newton's method, of the error tolerance
LOOSE, TIGHT = 1e-3, 3e-7  # tolerances between which radau5 is the fastest implicit method (clearance work-precision)
NOT_STIFF = "no film: explicit as long as the scene is not stiff between contacts"
SAMPLES_PER_TURN = 400
MOST_SAMPLES = 2**53  # beyond which their times are not told apart
ROWS = 2048  # samples and ends of steps held in memory between two writes
LOG_ROWS = 4096
IMPACT_ROWS = 512
BUDGET, SLOW_BUDGET = 2000, 20  # steps between two looks at the progress, of usual films and of those solved online
STEP_LIMIT = 2**62
WORST_LEDGER = 0.5  # share of lost energy at which a run ends itself, however loose its tolerance
THIN = 1e-6  # film left over the clearance at which a run that cannot go on has run out of film
LOST_ENERGY = 1e-3  # share of the energy turned over whose loss makes a run doubtful
LEDGER = ("energy/kinetic", "energy/input", "energy/dissipated", "energy/residual")
LARGEST_SHARE = 1.0 / 24.0  # largest step as a share of a turn
PRESCRIBED_SHARE = 1.0 / 100.0  # the same where nothing is free to move
REMEMBERED_SHARE = 1.0 / 400.0  # the same where a film has a memory


class SimulationError(RuntimeError):
    """A run failed part-way. `result` holds what had been computed; None where no file of it could be kept."""

    def __init__(self, message: str, result: Result | None):
        super().__init__(message)
        self.result = result


@dataclass(frozen=True)
class Span:
    """How long to run and how finely to sample."""

    until: float
    samples: int


def simulate(
    scene: Scene,
    *,
    turns: float | None = None,
    until: float | None = None,
    rtol: float = 1e-6,
    method: str = "auto",
    samples_per_turn: int = SAMPLES_PER_TURN,
    samples: int | None = None,
    path: str | Path | None = None,
    energy: bool = True,
    max_step: float | None = None,
    max_steps: int | None = None,
    channels: Sequence[str] | None = None,
    compression: int = 0,
    checkpoint: float | None = None,
    force: bool = False,
    progress: Callable[[float], None] | None = None,
    start: Record | str | Path | None = None,
    pressure_fields: int | None = None,
) -> Result:
    """Integrate a scene and return its result.

    turns: length in turns at the drive's constant or nominal speed, or until: seconds. rtol: local error tolerance,
    relative to the natural size of each state (clearance for eccentricities) plus its value. method: "auto" (dop853
    where no film makes the scene stiff, else the implicit method that is fastest at this rtol), "dop853" (explicit,
    order 8), "rodas5p" (linearly implicit, order 5), "radau5", "radau9" (implicit, order 5 and 9) or "radau" (one
    of these two, by rtol). samples_per_turn (in all, where nothing turns evenly) or samples (in all): output rows.
    path: write the HDF5 file there while running (default: a temporary file, see Result.save). energy: integrate the
    energy ledger. max_step: longest step [s] (default a 24th of a turn, or of the span); give one where loads act
    more briefly than that. max_steps: give up after so many. progress: called with the done share of the span.
    channels: paths or patterns of the output to keep, such as "bodies/slider/ax", "joints/B/*" or "solver", the log of
    steps (default all; the events are always kept);
    compression: gzip level of the file's columns (0: none). checkpoint: seconds of wall time between checkpoints beside
    the file: the same call goes on from the last one after a crash, and gives the same file. force: begin although the
    run needs more than 2^31 rows, a day or the free disk (see demand.py).
    start: the result (or the path of its file) of another run, at whose end this one begins, in any scene with the same
    states; or "quasi-static": journals at rest where their films carry the joint forces (default: as the scene says).
    pressure_fields: how many pressure fields of its films a turn the file shall hold (of the run, where nothing turns),
    solved after the run from its motion, see fields.py; none unless asked for.
    Raises ValueError for bad arguments and impossible scenes before anything runs, SimulationError for a run that fails
    part-way, with time, joint and state in the message and the partial result attached, also where the disk is full;
    KeyboardInterrupt once what was computed is kept, with a note that says where.
    """
    if checkpoint is not None and path is None:
        raise ValueError("checkpoint needs a path: the name of the result file that the run shall go on with")
    if checkpoint is not None:
        checkpoint = checks.positive("checkpoint", checkpoint)
    filters(compression)
    if pressure_fields is not None:
        fields.check(scene.description(), pressure_fields, channels)
    demanded = None if force else partial(_affordable, channels, compression, checkpoint, path)
    run = prepare(
        scene, demanded, turns=turns, until=until, rtol=rtol, method=method, samples_per_turn=samples_per_turn,
        samples=samples, energy=energy, max_step=max_step, max_steps=max_steps, start=start,
    )  # fmt: skip
    chosen(run.mechanism.layout.channels, channels)
    for warning in foreseen(run.mechanism) + dear(run.mechanism):
        LOG.warning(warning)
    return run.to_file(path, progress, channels, compression, checkpoint, pressure_fields)


def _affordable(channels, compression: int, checkpoint: float | None, path, mechanism: Mechanism, demand: Demand):
    """Raise ValueError where a run and its file are too large; checkpoints are joined, which takes the room twice."""
    columns = 1 + len(chosen(mechanism.layout.channels, channels))
    runs = 1 if checkpoint is None else 2
    affordable(replace(demand, columns=columns, compressed=compression > 0, runs=runs), path)


def prepare(
    scene: Scene,
    demanded: Callable[[Mechanism, Demand], None] | None = None,
    *,
    turns: float | None = None,
    until: float | None = None,
    rtol: float = 1e-6,
    method: str = "auto",
    samples_per_turn: int = SAMPLES_PER_TURN,
    samples: int | None = None,
    energy: bool = True,
    max_step: float | None = None,
    max_steps: int | None = None,
    start: Record | str | Path | None = None,
) -> "Run":
    """The run of a scene, all checked and compiled, not begun; arguments and errors are those of `simulate`.

    demanded: called with what the run needs, before anything is compiled.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"simulate needs a Scene, got {scene!r}; cl.load_case makes one from a case name")
    rtol = checks.positive("rtol", rtol)
    if max_steps is not None and (not isinstance(max_steps, int) or max_steps < 1):
        raise ValueError(f"max_steps must be a positive whole number, got {max_steps!r}")
    if max_step is not None:
        max_step = checks.positive("max_step", max_step)
    if not 1e-14 <= rtol <= 0.1:
        raise ValueError(f"rtol must lie in [1e-14, 0.1], got {rtol!r}")
    if method not in ("auto", "radau", *METHODS):
        raise ValueError(f"method must be one of auto, radau, {', '.join(METHODS)}; got {method!r}")
    mechanism = build(scene, ledger=energy)
    span = span_of(scene, turns=turns, until=until, samples=samples, samples_per_turn=samples_per_turn)
    if demanded is not None:
        steps = span.until / (max_step or longest_step(mechanism, span))
        demanded(mechanism, Demand(span.samples, min(steps, max_steps or steps)))
    stepper = choose_method(mechanism, method, rtol)
    with announced():
        run = Run(mechanism, span, rtol, stepper, max_step, max_steps)
    if start is not None:
        run.start_from(start)
    return run


def foreseen(mechanism: Mechanism) -> list[str]:
    """Force holes that the mechanism's own inertia may find, before anything runs."""
    inertia = sum(b.mass for b in mechanism.scene.bodies) * mechanism.acceleration
    found = (hole_warning(j, mechanism.frequency, inertia) for j in mechanism.scene.clearance_joints)
    return [f for f in found if f]


def dear(mechanism: Mechanism) -> list[str]:
    """The cost of films that are solved as the run goes, from the time of one solution."""
    found, turn = [], mechanism.scene.turn
    for joint in (j for j, s in mechanism.sources.items() if isinstance(s, Answerer)):
        try:
            film = joint.film.source(joint.film_joint)  # another film: the run's stays as it is
            each = film.seconds()
        except Exception:  # noqa: BLE001 - the run itself ends with the reason
            continue
        cost = f"{joint.label()}: its film is solved as the run goes, {each:.2g} s of CPU each time"
        found.append(f"{cost}, about {each * film.usual:.2g} s a turn" if turn else cost)
    return found


def span_of(scene: Scene, *, turns, until, samples, samples_per_turn=SAMPLES_PER_TURN) -> Span:
    """The length of a run from what was asked for. Raises ValueError naming the argument."""
    if (turns is None) == (until is None):
        raise ValueError("give the length of the run: either turns=N or until=SECONDS")
    turn = scene.turn
    if until is None:
        turns = checks.positive("turns", turns)
        if turn is None:
            raise ValueError(
                "turns needs a constant-speed rotating drive with speed != 0, or one with a nominal speed; "
                "give until=SECONDS instead"
            )
        until = turns * turn
    until = checks.positive("until", until)
    if samples is None:
        every = checks.positive("samples_per_turn", samples_per_turn)
        wanted = checks.finite("samples", every * until / turn) if turn else every
        samples = max(round(wanted), 1) + 1
    if checks.finite("samples", samples) < 2:
        raise ValueError(f"samples must be at least 2, got {samples!r}")
    if samples > MOST_SAMPLES:
        raise ValueError(f"samples must be at most 2^53, got {samples:.6g}")
    return Span(until, int(samples))


def choose_method(mechanism: Mechanism, method: str = "auto", rtol: float = 1e-6) -> tuple[str, str]:
    """Name of the stepper and why."""
    films = [j.name for j in mechanism.scene.clearance_joints if j.film is not None]
    if method not in ("auto", "dop853") and mechanism.size == 0:
        raise ValueError(f"method {method}: this scene has no degree of freedom to be stiff; use auto or dop853")
    if method == "radau":
        return _implicit(rtol, stages_only=True), "asked for radau; the number of stages suits rtol"
    if method != "auto":
        return method, "asked for"
    if mechanism.size == 0:
        return "dop853", "nothing is free to move: only the energy ledger is integrated"
    if rubbing := sorted(mechanism.structure.forced):
        said = f"the friction of joint {', '.join(rubbing)} is stiff where it comes to rest"
        return _implicit(rtol), f"{said}; the fastest for this rtol"
    if not films:
        return "dop853", NOT_STIFF
    return _implicit(rtol), f"the film of joint {', '.join(films)} makes the scene stiff; the fastest for this rtol"


def _implicit(rtol: float, stages_only: bool = False) -> str:
    if rtol >= LOOSE and not stages_only:
        return "rodas5p"
    return "radau9" if rtol < TIGHT else "radau5"


def kernel_roles(mechanism: Mechanism, method: str) -> list[str]:
    """The kernels a run needs; roles the scene has no use for are never called and not compiled."""
    needed = {
        "rhs": True,
        "jacobian": method != "dop853",
        "events": bool(mechanism.spots),
        "commit": mechanism.layout.commits > 0,
        "observe": True,
    }
    return [role for role, used in needed.items() if used]


def _beyond(joint, depth: float) -> str | None:
    """A contact taken deeper than its law is meant for."""
    if joint.contact is None or joint.contact.law.limit is None:
        return None
    law, limit = joint.contact.law, joint.contact.law.limit(joint.contact.values)
    if depth <= limit:
        return None
    return f"{joint.label()}: penetrations reach {depth:.2g} m; {law.name} is meant up to {limit:.2g} m only"


def _left(sink, path) -> str:
    """Description of the files of a run that ended early, also before it had a sink."""
    return f"{path} was not written" if sink is None else sink.left


def longest_step(mechanism: Mechanism, span: Span) -> float:
    """A share of a turn, or of the span; films with a memory are first order in it and need it short.

    Prescribed motions may have corners that a long step would not see: no longer than the way between two samples,
    and where nothing else moves, which costs next to nothing, a tenth of it.
    """
    share = REMEMBERED_SHARE if mechanism.layout.remembering else LARGEST_SHARE
    if mechanism.size == 0:  # no error bounds the step, and extremes are looked for step by step
        share = PRESCRIBED_SHARE
    longest = min(mechanism.scene.turn or span.until, span.until) * share
    if any(getattr(load, "motion", None) is not None for load in mechanism.scene.loads):
        longest = min(longest, span.until / (span.samples - 1) * (1.0 if mechanism.size else 0.1))
    return longest


class Run:
    """The arrays of one integration and the calls that advance it."""

    def __init__(
        self, mechanism: Mechanism, span: Span, rtol: float, method: tuple[str, str], max_step=None, max_steps=None,
        outputs: bool = True,
    ):  # fmt: skip
        from clearance.stepping import loop, state
        from clearance.stepping import types as t

        self.mechanism, self.span, self.rtol = mechanism, span, rtol
        self.loop, self.state, self.types = loop, state, t
        self.method, self.reason = method
        self.outputs = outputs
        size = mechanism.y0.size
        states, spots = mechanism.size or size, mechanism.spots
        self.y, self.f = mechanism.y0.copy(), np.zeros(size)
        self.work = np.concatenate([mechanism.work0, np.zeros(1)])
        self.scale = np.concatenate([mechanism.scale, np.full(size - mechanism.size, self._energy_scale())])
        self.band = loop.BAND * np.array([spot.reach for _, spot in spots])
        self.control, self.counts = np.zeros(t.CONTROL_SIZE), np.zeros(t.COUNTS_SIZE, np.int64)
        self.control[t.RTOL] = rtol
        self.control[t.EVALUATE_LEDGER] = float(size > mechanism.size)
        self.counts[t.STATES], self.counts[t.COORDINATES] = states, mechanism.coordinates
        self.control[t.CONVERGENCE], self.control[t.EFFORT] = 1.0, 0.9
        self.control[t.NEWTON_TOLERANCE] = NEWTON_TOLERANCE
        self.clock, self.place = np.zeros(state.CLOCK_SIZE), np.zeros(state.PLACE_SIZE, np.int64)
        self.clock[state.END] = span.until
        online = [s for s in mechanism.sources.values() if isinstance(s, Answerer)]
        for source in online:
            source.reset()
        self.budget = SLOW_BUDGET if online else BUDGET
        self.clock[state.SAMPLE_EVERY] = span.until / (span.samples - 1)
        self.clock[state.LARGEST] = max_step or longest_step(mechanism, span)
        self.place[state.SAMPLES] = span.samples
        self.place[state.STEP_LIMIT] = max_steps or STEP_LIMIT
        self.place[state.COMMITS] = mechanism.layout.commits
        self.place[state.REMEMBERING] = len(mechanism.layout.remembering)
        self.contacts = np.zeros((len(spots), state.CONTACT_COLUMNS))
        self.contacts[:, state.KIND] = [spot.kind for _, spot in spots]
        self.contacts[:, state.CLEARANCE] = [spot.reach for _, spot in spots]
        self.contacts[:, state.COORDINATE] = [mechanism.places.get(e, -1) for e, _ in spots]
        self.contacts[:, state.PEAKS] = -1
        self.impacts = np.zeros((IMPACT_ROWS, state.IMPACT_COLUMNS))
        self._follow()
        self.log = np.zeros((LOG_ROWS, state.LOG_COLUMNS + self.ledger.size))
        self.times, self.rows = np.zeros(ROWS), np.zeros((ROWS, len(mechanism.layout.channels) if outputs else size))
        self.dense = np.zeros((t.DENSE_ROWS, size))
        self.vector = np.zeros(max(states * states, 1))
        self.complexes = np.zeros((2 * (states + 2), max(states, 1)), np.complex128)
        self.scratch = np.zeros((7, max(size, 3 * len(spots), 1)))
        self.looks = np.zeros((2, self.rows.shape[1]))
        self.place[state.MAY_SWITCH] = self.reason == NOT_STIFF
        self.take(self.method)
        self._scale_film_rates()
        self.wall, self.cpu, self.contact_count = 0.0, 0.0, 0
        self.started = "as the scene says"
        self.spoilt = ""  # why the outputs cannot be trusted any more
        self.dead_centre = ""  # of which loop, once the ledger has failed there
        self.latest: list[tuple[np.ndarray, np.ndarray]] = []  # times and rows put out last

    def _follow(self) -> None:
        """The outputs that are watched at every step: extremes, angles, energies; none where there are no outputs."""
        state, scene = self.state, self.mechanism.scene
        channels = self.mechanism.layout.channels if self.outputs else []
        place = {c.path: i for i, c in enumerate(channels)}
        guided = guides(scene.description()) if channels else {}
        self.followed = followed(channels, [f"bodies/{b}/a{along(d)[0]}" for b, d in guided.items()])
        touching = [(i, e, s) for i, (e, s) in enumerate(self.mechanism.spots) if s.kind == CONTACT and channels]
        count = len(self.followed)
        self.peaks = np.zeros((count + 2 * len(touching), state.PEAK_COLUMNS))
        rows = [(q.channel, q.paired, q.sign, -1) for q in self.followed]
        for i, element, spot in touching:
            self.contacts[i, state.PEAKS] = len(rows)
            rows.append((place[spot.path(element, "contact_force")], False, 1.0, i))
            rows.append((place[spot.path(element, "gap")], False, -1.0, i))
        columns = [state.CHANNEL, state.PAIRED, state.SIGN, state.JOINT]
        self.peaks[:, columns] = np.array(rows, dtype=float).reshape(-1, len(columns))
        self.peaks[:, state.VALUE] = -np.inf
        self.clock[state.STRETCH] = length = stretch_length(self.span.until, scene.turn)
        shape = stretches(self.span.until, length), len(self.peaks)
        self.best, self.when = np.full(shape, -np.inf), np.zeros(shape)
        angles = [(i, place[c.path.replace("theta", "omega")]) for i, c in enumerate(channels) if c.wrapped]
        self.angles = np.array(angles, dtype=np.int64).reshape(-1, 2)
        self.turned = np.zeros(self.angles.shape)
        self.ledger = np.array([place[p] for p in LEDGER if p in place], dtype=np.int64)
        if self.ledger.size < len(LEDGER):
            self.ledger = self.ledger[:0]
        self.place[state.WATCHED] = bool(channels)

    @property
    def extremes(self) -> Extremes:
        """Located extremes so far."""
        count, done = len(self.followed), self.place[self.state.STRETCHES]
        values, times = self.best[: done + 1, :count].copy(), self.when[: done + 1, :count].copy()
        values[done], times[done] = self.peaks[:count, self.state.VALUE], self.peaks[:count, self.state.WHEN]
        names, units = zip(*((q.name, q.units) for q in self.followed), strict=True) if count else ((), ())
        signs = np.array([q.sign for q in self.followed])
        return Extremes(float(self.clock[self.state.STRETCH]), names, units, signs * values, times)

    def _extreme(self, name: str) -> float:
        """Largest or smallest value of a followed quantity so far."""
        return self.extremes.of(name).value

    def start_from(self, start: Record | str | Path) -> None:
        """Begin in another state than the scene's. Raises ValueError as `state_from` does."""
        state, carried, self.started = state_from(self.mechanism, start)
        self.y[: state.size] = state
        self.work[self.mechanism.layout.carried_places] = carried

    def take(self, method: str) -> None:
        """Use a stepper: its functions, the kernels it needs, its scratch."""
        mechanism, t = self.mechanism, self.types
        stepper = import_module(f"clearance.stepping.{method}")
        self.roles = kernel_roles(mechanism, method)
        if not self.outputs:
            self.roles.remove("observe")
        # the loop takes a kernel for every role; one that is not needed is never called, so any will do
        order = ("rhs", "jacobian", "events", "commit", "observe")
        kernels = [mechanism.kernel(role if role in self.roles else "rhs") for role in order]
        if not self.outputs:
            kernels[-1] = self.loop.copy_state
        self.functions = {n: store.address(getattr(stepper, n), t.STEP) for n in ("step", "interpolant")}
        self.functions |= {n: store.address(k, t.KERNEL) for n, k in zip(order, kernels, strict=True)}
        self.control[t.ORDER] = stepper.ORDER
        states, size = self.counts[t.STATES], self.y.size
        self.matrix = np.zeros((stepper.ROWS + states, max(size, 1)))

    def _become_implicit(self) -> None:
        """The explicit method of an automatic choice is held up by stability: go on with an implicit one."""
        method, t = _implicit(self.rtol, stages_only=True), self.types
        LOG.info("stiff: going on with %s", method)
        self.reason = f"explicit at first; stiff, so implicit from t = {self.clock[self.state.TIME]:.6g} s on"
        self.method = f"{self.method}, {method}"
        self.place[self.state.MAY_SWITCH] = self.place[self.state.STIFF_STEPS] = 0
        self.control[t.STIFFNESS] = 0.0
        with announced():
            self.take(method)

    def _energy_scale(self) -> float:
        mass = sum(b.mass for b in self.mechanism.scene.bodies)
        return mass * (self.mechanism.start.size * self.mechanism.frequency) ** 2

    def _scale_film_rates(self) -> None:
        """A thick film gives way slowly: its natural rate is acceleration over damping, not clearance times speed.

        Otherwise a rate that is right to rtol of its natural size would leave the film's force, damping times rate,
        wrong by much more.
        """
        mechanism, state = self.mechanism, self.state
        films = {j: at for j, at in mechanism.places.items() if j.film is not None}
        if not films:
            return
        self.contacts[:, state.PULL] = pull = mechanism.acceleration
        rhs, work, p = mechanism.kernel("rhs"), self.work, mechanism.coordinates
        rest = mechanism.y0.copy()
        for at in mechanism.places.values():
            rest[at : at + 2] = rest[p + at : p + at + 2] = 0.0
        before, after = np.zeros_like(rest), np.zeros_like(rest)
        rhs(0.0, rest, mechanism.par, work, before)
        for joint, at in films.items():
            for k in (p + at, p + at + 1):
                moved = rest.copy()
                moved[k] = self.scale[k]
                rhs(0.0, moved, mechanism.par, work, after)
                damping = abs(after[k] - before[k]) / self.scale[k]
                if damping * self.scale[k] > pull:
                    self.scale[k] = pull / damping
            row = self.contacts[[e for e, _ in mechanism.spots].index(joint)]
            row[state.RATE_X], row[state.RATE_Y] = self.scale[p + at], self.scale[p + at + 1]

    def advance(self) -> int:
        """One call of the compiled loop; `wall` and `cpu` sum the time spent there [s]."""
        began, cpu = clock_of_the_wall.perf_counter(), clock_of_the_wall.thread_time()
        state = self._state()
        words = self.state.words(state)
        code = self.loop.run(words.ctypes.data if store.COMPILED else state, self.budget)
        self.cpu += clock_of_the_wall.thread_time() - cpu
        self.wall += clock_of_the_wall.perf_counter() - began
        if code == codes.STIFF:
            self._become_implicit()
            return codes.RUNNING
        return code

    def _state(self):
        """What the compiled loop works on."""
        names, events = self.state.State._fields, 3 * len(self.contacts)
        arrays = {name: getattr(self, name) for name in names if hasattr(self, name)}
        sizes = [self.y.size] * 3 + [events] * 4
        names = ["y_new", "f_new", "trial", "before", "after", "probed", "found"]
        scratch = {n: row[:size] for n, row, size in zip(names, self.scratch, sizes, strict=True)}
        row, look = self.looks
        return self.state.State(
            **self.functions, **arrays, **scratch, par=self.mechanism.par, row=row, look=look
        )

    def trajectory(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Run to the end in memory: times, rows (states, where the run has no outputs) and the last status code."""
        state, place, code = self.state, self.place, codes.RUNNING
        times, rows = [], []
        self.wall = self.cpu = 0.0
        with Held() as held:
            while code == codes.RUNNING:
                code = self.advance()
                times.append(self.times[: place[state.ROWS]].copy())
                rows.append(self.rows[: place[state.ROWS]].copy())
                self.contact_count += place[state.EVENTS]
                place[state.ROWS] = place[state.EVENTS] = place[state.LOGGED] = 0
                held.check()
        return np.concatenate(times), np.concatenate(rows), code

    def to_file(
        self, path: str | Path | None, progress: Callable[[float], None] | None = None,
        channels: Sequence[str] | None = None, compression: int = 0, checkpoint: float | None = None,
        pressure_fields: int | None = None,
    ) -> Result:  # fmt: skip
        """Run to the end, streaming into the file; a signal and a full disk end it early, the file kept.

        Raises SimulationError, and KeyboardInterrupt with a note that says what is kept.
        """
        folder = sink = None
        if path is None:
            folder = tempfile.mkdtemp(prefix="clearance-")
            path = Path(folder) / "run.h5"
        try:
            with Held() as held:
                sink = self._sink(path, channels, compression, checkpoint)
                failure = self.record(sink, progress, checkpoint, held.check)
        except Unwritable as error:
            failure = f"at t = {self.clock[self.state.TIME]:.9g} s: {error}; {_left(sink, path)}"
            if sink is None or not sink.placed:
                raise SimulationError(failure, None) from None
        except KeyboardInterrupt as error:
            error.add_note(_left(sink, path))
            raise
        if pressure_fields is not None and failure is None:
            fields.keep(path, pressure_fields)
        result = Result(path)
        if folder is not None:
            weakref.finalize(result, shutil.rmtree, folder, ignore_errors=True)
        if failure is not None:
            raise SimulationError(failure, result)
        return result

    def _sink(self, path, channels, compression: int, checkpoint: float | None) -> FileSink | PartsSink:
        """Sink of the run's output in a file, with checkpoints on request."""
        output = path, self.mechanism.layout.channels, self.attributes(), channels, compression
        if checkpoint is None:
            return FileSink(*output, self.span.samples)
        return PartsSink(*output, self._identity(channels, compression))

    def record(
        self, sink, progress: Callable[[float], None] | None = None, every: float | None = None,
        check: Callable[[], None] | None = None,
    ) -> str | None:  # fmt: skip
        """Run to the end, handing the output to a sink; why it ended early, if it did.

        every: seconds of wall time between two checkpoints, for a sink that keeps them. check: called after each piece
        of output, raises KeyboardInterrupt where the run shall end. Raises Unwritable where a file takes no more; like
        an interrupt it comes when what was computed before is kept, if it can be.
        """
        writer = Recorder(self.mechanism.layout.channels, sink, True, self.rtol * self._energy_scale())
        for joint in self.mechanism.scene.joints:
            writer.know(f"joints/{joint.name}", **joint.facts)
        if every is not None and (kept := sink.begin()) is not None:
            restore(self, writer, kept)
            LOG.info("going on from t = %.6g s", self.clock[self.state.TIME])
        began, failure = clock_of_the_wall.perf_counter(), None
        cut = began
        code, doubted = codes.RUNNING, False
        try:
            while code == codes.RUNNING:
                code = self.advance()
                self._drain(writer)
                self._notice_interrupt()
                if check is not None:
                    check()
                residual = writer.residual_share()
                if residual > self._doubtful and not doubted:
                    doubted = True
                    self._look_for_dead_centre()
                if residual > max(LedgerWatch.limit, min(1e4 * self.rtol, WORST_LEDGER)):
                    code = codes.LEDGER_BROKEN
                elif self.spoilt:
                    code = codes.NOT_FINITE
                if progress is not None:
                    progress(self.clock[self.state.TIME] / self.span.until)
                if every is not None and code == codes.RUNNING and clock_of_the_wall.perf_counter() - cut > every:
                    sink.cut(state_of(self, writer))
                    cut = clock_of_the_wall.perf_counter()
            if code != codes.DONE:
                failure = self._failure(code, writer)
        except KeyboardInterrupt as request:
            failure = f"{ended(request)} at t = {self.clock[self.state.TIME]:.9g} s"
            raise
        except Unwritable as error:
            failure = f"at t = {self.clock[self.state.TIME]:.9g} s: {error}"
            raise
        finally:
            self._open_contacts(writer)
            wall = clock_of_the_wall.perf_counter() - began
            finished = "complete" if code == codes.DONE else f"partial: {failure or 'stopped by an error'}"
            summary = self._summary(wall) | {"energy_residual_share": writer.residual_share()}
            for joint, source in self.mechanism.sources.items():
                writer.know(f"joints/{joint.name}", **source.facts())
            writer.know("state", **end_state(self.mechanism, self.y, self.work, self.clock[self.state.TIME]))
            writer.close(finished, summary, self._warnings(writer), self.extremes)
        return failure

    def _drain(self, writer: Recorder) -> None:
        state, place = self.state, self.place
        rows = self.rows[: place[state.ROWS]]
        bad = ~np.isfinite(rows).all(axis=1)
        good = int(np.argmax(bad)) if bad.any() else len(rows)
        if good < len(rows):
            channel = writer.channels[int(np.argmin(np.isfinite(rows[good])))].path
            self.spoilt = f"at t = {self.times[good]:.9g} s: {channel} is not finite; a law or motion has no value here"
            before = self.times[good - 1] if good else writer.last[0] if writer.last else self.times[good]
            self.spoilt = self._lost(before, self.times[good]) or self.spoilt
        before = writer.last
        writer.samples(self.times[:good], rows[:good])
        self.latest = [(np.atleast_1d(before[0]), before[1][None])] if before else []
        self.latest.append((self.times[:good], rows[:good]))
        writer.impacts(self._names(), self.impacts[: place[state.EVENTS]])
        writer.steps(self.log[: place[state.LOGGED]])
        place[state.ROWS] = place[state.EVENTS] = place[state.LOGGED] = 0
        writer.flush()

    def _notice_interrupt(self) -> None:
        """An interrupt that came while a film was being solved cannot pass through compiled code by itself."""
        for source in self.mechanism.sources.values():
            if isinstance(source, Answerer) and isinstance(source.failure, KeyboardInterrupt):
                raise source.failure

    def _names(self) -> list[str]:
        return [spot.label(element) for element, spot in self.mechanism.spots]

    def _open_contacts(self, writer: Recorder) -> None:
        """Contacts that the end of the run cuts off."""
        state, now = self.state, self.clock[self.state.TIME]
        rows = []
        for j, c in enumerate(self.contacts):
            if c[state.TOUCHING] > 0.0:
                force, depth = self.peaks[int(c[state.PEAKS]) :][:2, state.VALUE]
                rows.append((j, c[state.SINCE], c[state.IMPACT_SPEED], force, depth, now - c[state.SINCE], 0.0))
        writer.impacts(self._names(), np.array(rows), "open_contact")

    def _failure(self, code: int, writer: Recorder) -> str:
        """Place and reason of a run's failure: time, joint and state."""
        if code == codes.LEDGER_BROKEN:
            since = writer.ledger.since or 0.0
            return f"from t = {since:.9g} s on: {codes.MESSAGES[code]}: {self._suspects(writer)}"
        if self.spoilt:
            return self.spoilt
        for joint, source in self.mechanism.sources.items():
            if isinstance(source, Answerer) and source.failure is not None:
                return f"at t = {self.clock[self.state.TIME]:.9g} s: {joint.label()}: its film: {source.failure}"
        joints, moving = self.mechanism.scene.clearance_joints, self.mechanism.eccentric
        count = len(self.mechanism.plan.free)
        states = [
            f"{j.name}: eccentricity ratio {math.hypot(*self.y[count + 2 * i : count + 2 * i + 2]) / j.clearance:.9f}"
            for i, j in enumerate(moving)
        ]
        states += [
            f"{c.label()} = {v:.6g}"
            for c, v in zip(self.mechanism.plan.free, self.y, strict=False)
        ]
        ended = self.place[self.state.FAILED_JOINT]
        thin = [i for i, j in enumerate(joints) if j.contact is None and j in moving and self._gap(j) < THIN]
        if code == codes.STEP_TOO_SMALL and thin:
            code, ended = codes.FILM_LEFT, thin[0]
        where = f"joint {joints[ended].name}: " if code == codes.FILM_LEFT else ""
        time, what = self.clock[self.state.TIME], f"{where}{codes.MESSAGES[code]}"
        if code in (codes.STEP_TOO_SMALL, codes.NOT_FINITE):
            if lost := self._lost(time, time + self.clock[self.state.LARGEST]):
                return lost
            what = self._no_number() or self._look_for_dead_centre() or what
        return f"at t = {time:.9g} s: {what} ({'; '.join(states) or 'no free state'})"

    def _no_number(self) -> str | None:
        """Quantity without a value where the run cannot go on: at its last state, or one to a million steps further."""
        time, step = self.clock[self.state.TIME], self.clock[self.state.STEP_SIZE]
        found = no_number(self.mechanism, self.work, time, self.y)
        for further in (1.0, 1e2, 1e4, 1e6) if np.isfinite(self.f).all() else ():
            h = further * step
            found = found or no_number(self.mechanism, self.work, time + h, self.y + h * self.f)
        return found

    def _lost(self, before: float, after: float) -> str | None:
        """End of a prescribed motion between two times, if it has one."""
        if self.mechanism.size > 0 or not self.outputs:
            return None
        if (lost := lost_at(self.mechanism, self.work, before)) is not None:
            return f"at t = {before:.9g} s: {lost}"
        found = last_position(self.mechanism, self.work, before, after)
        return found and f"at t = {found[0]:.9g} s: {found[1]}"

    def _look_for_dead_centre(self) -> str:
        """The loop that stands at its dead centre now or did since the output before the last; "" where none does."""
        if not self.dead_centre and self.outputs:
            time, row = self.clock[self.state.TIME], np.empty((1, self.rows.shape[1]))
            self.mechanism.kernel("observe")(time, self.y, self.mechanism.par, self.work.copy(), row[0])
            times, rows = (np.concatenate(c) for c in zip(*self.latest, ([time], row), strict=True))
            later = np.concatenate([[True], np.diff(times) > 0.0])
            self.dead_centre = dead_centre(Motion(self.mechanism, self.work, times[later], rows[later])) or ""
        return self.dead_centre

    def _gap(self, joint) -> float:
        """Film left over the clearance."""
        at = self.mechanism.places[joint]
        return 1.0 - math.hypot(*self.y[at : at + 2]) / joint.clearance

    def _depths(self) -> dict:
        """Largest penetration [m] of each clearance joint so far; negative: never touched."""
        joints = self.mechanism.scene.clearance_joints if self.place[self.state.STARTED] else ()
        return {j: -self._extreme(f"joints/{j.name}/gap_min") for j in joints}

    def _suspects(self, writer: Recorder) -> str:
        """Why an energy ledger may not close: impossible penetrations, else what this scene can do."""
        if deep := [*filter(None, (depth_warning(j, depth) for j, depth in self._depths().items()))]:
            return "; ".join(deep)
        if at := self._look_for_dead_centre():
            return at
        found = []
        if any(g.closures for g in self.mechanism.plan.groups):
            found.append("a loop passed a dead centre and changed its branch")
        if any(getattr(load, "motion", None) is not None for load in self.mechanism.scene.loads):
            found.append("a prescribed motion jumped")
        return " or ".join([*found, "rtol is too loose for this motion"])

    def _warnings(self, writer: Recorder) -> list[str]:
        """Doubts of the laws used, a method that does not suit the scene, films thinner than the surfaces are rough."""
        joints = self.mechanism.scene.clearance_joints
        found = [doubt for j in self.mechanism.scene.joints for doubt in j.doubts()]
        if self.method == "dop853" and any(j.film is not None for j in joints):
            found.append("method dop853 is explicit: a thin film forces it to very small steps; radau suits this scene")
        elif self.method == "dop853" and self.place[self.state.STIFF_STEPS] >= self.loop.STIFF_ENOUGH:
            found.append("method dop853 is explicit and its steps are held up by stability; radau suits this scene")
        found += filter(None, map(self._too_sharp, self.mechanism.scene.joints))
        residual = writer.residual_share()
        if residual > self._doubtful:
            found.append(
                f"the energy ledger does not close: {residual:.2g} of the energy turned over is missing: "
                f"{self._suspects(writer)}"
            )
        for joint in joints if self.place[self.state.STARTED] else ():
            group = f"joints/{joint.name}"
            gap = self._extreme(f"{group}/gap_min")
            if joint.film is not None:
                found += writer.regime(joint, self._extreme(f"{group}/film_pressure_max"), gap).warnings(joint)
            source = self.mechanism.sources.get(joint)
            if isinstance(source, Answerer):
                doubt = source.doubt(1.0 - gap / joint.clearance)
                found += [f"{joint.label()}: mesh of the film: {doubt}"] if doubt else []
            if joint.transition is not None and gap < FULL_FILM * (joint.roughness or 0.0):
                force, reached = self._extreme(f"{group}/force_max"), gap / joint.roughness
                found += filter(None, [hole_warning(joint, self.mechanism.frequency, force, reached)])
        for joint, depth in self._depths().items():
            found += filter(None, [depth_warning(joint, depth) or _beyond(joint, depth)])
        return found

    @property
    def _doubtful(self) -> float:
        """Share of the energy turned over that must be missing for a warning."""
        return max(LOST_ENERGY, 100.0 * self.rtol)

    def _too_sharp(self, joint) -> str | None:
        """Friction that turns round within less than the tolerance resolves of the joint's rate."""
        mechanism = self.mechanism
        if joint.name not in mechanism.structure.forced or "transition_rate" not in joint.friction.values:
            return None
        slides = joint.slides
        seen = self.rtol * mechanism.frequency * (mechanism.start.size if slides else 1.0)
        if (rate := joint.friction.values["transition_rate"]) >= seen:
            return None
        units = "m/s" if slides else "rad/s"
        sharp = f"{joint.label()}: transition_rate {rate:g} {units} is finer than rtol {self.rtol:g} sees"
        return f"{sharp}, {seen:.2g} {units}"

    def _identity(self, channels, compression: int) -> dict:
        """Facts that two runs must share for one to continue the other."""
        for key in self.mechanism.layout.remembering:
            raise ValueError(f"{key}: its film has a memory that no checkpoint keeps; leave out checkpoint")
        found = {n: getattr(self, n) for n in ("rtol", "method")} | vars(self.span)
        found["start"] = self.y[: self.mechanism.size].tolist()
        more = {"max_step": self.clock[self.state.LARGEST], "max_steps": int(self.place[self.state.STEP_LIMIT])}
        return found | more | {"channels": channels and list(channels), "compression": compression}

    def attributes(self) -> dict:
        texts = self.mechanism.structure.texts
        about = {"kernel": "\n\n".join(texts[r] for r in self.roles), "start": self.started}
        return self.mechanism.scene.provenance | about

    def _summary(self, wall: float) -> dict:
        t = self.types
        return {
            "method": self.method, "method_reason": self.reason, "rtol": self.rtol,
            "atol": self.rtol * self.scale[: self.mechanism.size], "wall_s": wall, "loop_s": self.wall,
            "steps": self.counts[t.STEPS], "rejected": self.counts[t.REJECTED],
            "evaluations": self.counts[t.EVALUATIONS], "jacobians": self.counts[t.JACOBIANS],
            "factorisations": self.counts[t.FACTORISATIONS],
        }  # fmt: skip
