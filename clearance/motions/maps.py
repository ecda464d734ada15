"""The map of a section: where a motion stands one period later, and the derivative of that by
differences.

The state is complete. A contact law with an impact speed stores it while the contact lasts. A
section inside a contact therefore has that speed as a further coordinate. A section in free flight
has none.
"""

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from clearance.accuracy.horizon import NotSolved
from clearance.mechanism.build import TURN, Mechanism, build
from clearance.run.diagnosis import Diagnosis, remembers
from clearance.run.options import Solver, Span, longest_step
from clearance.run.run import Run
from clearance.run.start import prescribed, state_from
from clearance.scene.scene import Scene
from clearance.stepping import status
from clearance.stepping.state import KIND, SINCE, SPOT_VALUES, TOUCHING
from clearance.values.spots import CONTACT

FREE = -1.0  # in the place of an impact speed: no contact
PROBED = (
    0.0,
    0.13,
    0.41,
    0.77,
)  # of a period: where the forces are compared with those of later periods
LATER = (1, 7)  # periods later
EQUAL = 1e-7  # of the rates: difference that the rounding of large times may make
TURNED = 1e-10  # of the rates: difference that turns may make, beside that of their rounding
ROUNDED = 16  # last bits of angles and of the time: what rounding may change of them
LONGEST = 1e6  # turns that a trajectory may be long
LEFT = 1e-7  # rad before or behind the section's angle from which on the way to it is straight
CHUNK = 24  # parts of a nominal turn that an autonomous motion advances at once
TRIES = 400  # such advances to one passage, at most
MANY, FEW = 30, 10_000  # steps of a trial, over those of the passage before it, and in any case


class NotPeriodic(RuntimeError):
    """No periodic motion was reached; the message gives the best."""


class AtDeadCentre(NotSolved):
    """A loop came to its dead centre, which it does not have where `joint` opens it."""

    def __init__(self, message: str, joint: str):
        super().__init__(message)
        self.joint = joint


@dataclass(frozen=True)
class Place:
    """Place of a motion in its phase space. y: states; carried: what Newton's method in the kernel
    begins with;
    touching: which spots are in a contact that began with a touch; speeds: the impact speeds
    that they remember [m/s]; ages: how long their contacts have lasted [s]; turns: full ones that
    drives have made before, see `Mechanism.turn`.
    """

    y: np.ndarray
    carried: np.ndarray
    touching: np.ndarray
    speeds: np.ndarray
    ages: np.ndarray
    turns: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))  # of old files


class Motion:
    """Trajectories of a scene from any place at any time. spent: time integrated so far [s];
    max_steps: of a trajectory.
    """

    def __init__(
        self,
        scene: Scene,
        rtol: float,
        method: str = "auto",
        turn: float | None = None,
        mechanism: Mechanism | None = None,
        max_steps: int | None = None,
    ):
        self.mechanism = mechanism or build(scene, ledger=False)
        self.scene, self.rtol, self.spent, self.max_steps = scene, rtol, 0.0, max_steps
        still = "it repeats itself with its drives, and nothing is solved for"
        check_state(self.mechanism, still, "no periodic motion can be solved for")
        self.turn = turn or scene.turn
        if self.turn is None:
            raise ValueError(
                f"{scene.name} has no drive of constant or nominal speed, which would give its "
                "period: give it, period=SECONDS or --period S"
            )
        #: full turns that drives make in the time of one
        self.rounds = _turns_made(self.mechanism, self.turn)
        timeless = not _repeats(self.mechanism, self.turn, self.rounds)
        self.autonomous = timeless and turn is None and any(d.nominal for d in scene.drives)
        self._use(method)
        self.limit = int(self.run.state.step_limit)  # steps of a trajectory
        self.remembers = np.array(
            [_remembers(element, spot) for element, spot in self.mechanism.spots], dtype=bool
        )

    def _use(self, method: str) -> None:
        """A run of a method, and its memory before it begins."""
        span = Span(self.turn, 401)
        solver = Solver(self.rtol, method, longest_step(self.mechanism, span), self.max_steps)
        self.run = Run(self.mechanism, Span(LONGEST * self.turn, 2), solver, outputs=False)
        self.fresh = self.run.state.memory.copy()
        self.same: dict[tuple, bool] = {}  # forces after full turns, see `alike`

    # --- places
    def start(self, start=None) -> Place:
        """Start of the scene, or end of another run; see `simulate`."""
        mechanism, spots = self.mechanism, len(self.mechanism.spots)
        y, carried = mechanism.y0.copy(), mechanism.work0[mechanism.layout.carried_places].copy()
        turns = np.zeros(len(self.rounds), dtype=int)
        if start is not None:
            begin = state_from(mechanism, start)
            y[: mechanism.size], carried = begin.values, np.array(begin.carried)
            turns[: len(begin.turns)] = begin.turns
        still = np.zeros(spots, dtype=bool), np.full(spots, FREE), np.zeros(spots)
        return Place(y, carried, *still, turns)

    def moved(self, state: Place, y: np.ndarray, speeds: np.ndarray | None = None) -> Place:
        """A place with other states and remembered speeds."""
        return replace(state, y=y, speeds=state.speeds if speeds is None else speeds)

    # --- advancing
    def go(self, start: Place, begin: float, end: float) -> Place:
        """The place at the time `end` of the motion that is in another one at `begin` [s].

        Raises NotSolved where the motion cannot be continued.
        """
        self._begin(start, begin)
        self._advance(end)
        return self.here()

    def stops(self, start: Place, begin: float, ends) -> list[Place]:
        """The places at several times, one after another."""
        self._begin(start, begin)
        places = []
        for end in ends:
            self._advance(float(end))
            places.append(self.here())
        return places

    @property
    def enough(self) -> int:
        """Steps of a trajectory that stays near the last one."""
        state = self.run.state
        return min(self.limit, max(MANY * int(state.steps + state.rejected), FEW))

    @contextlib.contextmanager
    def trials(self) -> Iterator[None]:
        """Trajectories of places that a solver tries. Raises NotPeriodic where one needs more than
        enough steps, such as at a wall, or cannot be continued.
        """
        limit, self.limit = self.limit, self.enough
        try:
            yield
        except AtDeadCentre:
            raise
        except NotSolved as reason:
            raise NotPeriodic(f"a motion beside it cannot be continued: {reason}") from reason
        finally:
            self.limit = limit

    def _begin(self, start: Place, time: float) -> None:
        state = self.run.state
        np.copyto(state.memory, self.fresh)
        state.time, state.begin, state.step_limit = time, time, self.limit
        self.run.begin_at(start)
        self.begun, self.turns = time, start.turns

    def _advance(self, end: float) -> None:
        state, before, method = self.run.state, self.run.state.time, self.run.method.current
        code = self.run.advance_to(end)
        self.spent += state.time - before
        if code != status.DONE:
            failure = self._failure(code)
            if self.run.method.current != method:
                self._use(self.run.solver.method)
            raise failure
        if self.run.method.current != method:
            # stiff: go on with the implicit one from the next place on
            here, time = self.here(), float(state.time)
            self._use(self.run.method.current)
            self._begin(here, time)

    def _failure(self, code: int) -> NotSolved:
        """The reason of the end of a trajectory."""
        diagnosis = Diagnosis(self.run)
        dead = diagnosis.look_for_dead_centre()
        if dead and (joints := self.run.dead_centre.soft_joints):
            way = "simulate, sweep, statistics, wear and steady go on with another"
            text = f"{dead}: no state for a branch of motions, {way}"
            return AtDeadCentre(f"at t = {self.run.state.time:.6g} s: {text}", joints[0])
        return NotSolved(diagnosis.failure(status.DEAD_CENTRE if dead else code))

    def here(self) -> Place:
        """The place reached."""
        state, spots = self.run.state, len(self.mechanism.spots)
        mine = state.contacts[:, KIND] == CONTACT
        touching = mine & (state.contacts[:, TOUCHING] > 0.0)
        speeds = np.where(touching, state.work[:spots], FREE)
        carried = state.work[self.mechanism.layout.carried_places].copy()
        ages = np.where(touching, state.time - state.contacts[:, SINCE], 0.0)
        return Place(state.y.copy(), carried, touching, speeds, ages, self.turns)

    def later(self, state: Place, turns: int) -> Place:
        """A place as seen from so many turns later: its drives have made them before."""
        return replace(state, turns=state.turns + turns * self.rounds)

    @property
    def held(self) -> np.ndarray:
        """Spots whose contact has lasted since before the last trajectory began."""
        contacts = self.run.state.contacts
        return (contacts[:, TOUCHING] > 0.0) & (contacts[:, SINCE] < self.begun)

    def rates(self, time: float, state: Place) -> np.ndarray:
        """Rates of the states."""
        mechanism, rates = self.mechanism, np.zeros(state.y.size)
        mechanism.kernel("rhs")(time, state.y, mechanism.par, self.work(state), rates)
        return rates

    def alike(
        self, state: Place, winding: np.ndarray, angles: np.ndarray, turns: np.ndarray
    ) -> bool:
        """True where so many full turns of the angles at `winding` in the state and of the drives,
        in either sense, leave the forces as they are: they turn together, or no spring, tooth or
        law counts their turns.

        Rounding of a turn is no difference: in thin films small rates are sums of large ones.
        """
        key = (*angles.tolist(), *turns.tolist())
        if any(key) and key not in self.same:

            def rates(share: float, moved: np.ndarray | float = 0.0, times: int = 0) -> np.ndarray:
                y = state.y.copy()
                y[winding] += moved
                there = replace(state, y=y, turns=state.turns + times * turns)
                return self.rates(share * self.turn, there)

            def same(share: float) -> bool:
                base = rates(share)
                if not np.isfinite(base).all():
                    return True  # its loops do not close there
                rounded = np.abs(rates(share + ROUNDED * np.spacing(1.0), little) - base).max()
                allowed = TURNED * np.abs(base).max() + rounded
                moved = (rates(share, n * TURN * angles, n) for n in (-1, 1))
                return all(np.abs(there - base).max() <= allowed for there in moved)

            little = ROUNDED * np.spacing(TURN + np.abs(state.y[winding]))
            self.same[key] = all(map(same, PROBED))
        return self.same.get(key, True)

    def work(self, state: Place) -> np.ndarray:
        """Work vector of the kernels there, whose drives stand as they do there."""
        mechanism, work = self.mechanism, np.append(self.mechanism.work0, 0.0)
        mechanism.turn(state.turns)
        mine = np.flatnonzero(self.run.state.contacts[:, KIND] == CONTACT)
        work[mine] = state.speeds[mine]
        work[mechanism.layout.carried_places] = state.carried
        return work

    def gap(self, time: float, state: Place) -> float:
        """Smallest gap over its size [-] of the spots that may touch; infinite where there is
        none.
        """
        mechanism = self.mechanism
        mine = np.flatnonzero(self.run.state.contacts[:, KIND] == CONTACT)
        if not mine.size:
            return math.inf
        inside = np.zeros(SPOT_VALUES * len(mechanism.spots))
        mechanism.kernel("events")(time, state.y, mechanism.par, self.work(state), inside)
        reach = np.array([spot.reach for _, spot in mechanism.spots])
        return float((-inside[::SPOT_VALUES] / reach)[mine].min())


def check_state(mechanism: Mechanism, still: str, reason: str) -> None:
    """Raises ValueError for scenes whose state has nothing in it, `still`, or is not complete."""
    if mechanism.size == 0:
        raise ValueError(f"this scene has no degree of freedom: {still}")
    if films := ", ".join(mechanism.layout.remembering):
        raise ValueError(f"{films}: a film with a memory has more than its state: {reason}")


def _turns_made(mechanism: Mechanism, period: float) -> np.ndarray:
    """Full turns that each drive of `Mechanism.turning` makes in a period."""
    before, after = (prescribed(mechanism, time) for time in (0.0, period))
    names = [d.target.name for d in mechanism.turning]
    return np.array([round((after[n] - before[n]) / TURN) for n in names], dtype=int)


def _repeats(mechanism: Mechanism, period: float, turns: np.ndarray) -> bool:
    """True where the forces come back after the period, but for full turns of drives; False where
    time is not in them at all.

    Raises ValueError where they do neither.
    """
    rhs, work = mechanism.kernel("rhs"), np.append(mechanism.work0, 0.0)
    y, out = mechanism.y0 + 0.01 * mechanism.scale, np.zeros(mechanism.size)

    def rates(share: float, periods: int) -> np.ndarray:
        mechanism.turn(-periods * turns)
        rhs((share + periods) * period, y.copy(), mechanism.par, work.copy(), out)
        return out.copy()

    every = {share: rates(share, 0) for share in PROBED}
    # loops that do not close with the drive there have no rates
    base = {share: there for share, there in every.items() if np.isfinite(there).all()}
    if not base:
        return True
    values = np.array([*base.values()])
    size = np.abs(values).max() or 1.0
    if len(base) == len(PROBED) and np.ptp(values, axis=0).max() == 0.0:
        return False
    later = [np.abs(rates(s, n) - there).max() for n in LATER for s, there in base.items()]
    mechanism.turn(0 * turns)
    if not max(later) <= EQUAL * size:
        raise ValueError(
            f"the forces do not come back after {period:.6g} s: they differ by "
            f"{max(later) / size:.2g} of their size; give period=SECONDS (--period S), "
            "and leave out run-ups"
        )
    return True


def _remembers(element, spot) -> bool:
    """True for a spot whose contact law looks at the impact speed."""
    law = getattr(element, "contact", None)
    return spot.kind == CONTACT and law is not None and remembers(law)


class Section:
    """Passages of a motion through a section: a phase of the period, or of an autonomous one an
    angle of its drive.

    turns: from one passage to the next; phase: of the period, in [0, 1).
    """

    def __init__(self, motion: Motion, turns: int = 1, phase: float = 0.0):
        self.motion, self.turns, self.phase = motion, turns, phase
        mechanism = motion.mechanism
        self.scale, size = mechanism.scale, mechanism.size
        free = enumerate(mechanism.plan.free)
        self.winding = np.array([i for i, c in free if c.turns], dtype=int)
        self.angle, self.way = _driven_angle(mechanism) if motion.autonomous else (None, 0.0)
        self.states = np.array([i for i in range(size) if i != self.angle])
        self.duration, self.contacts = turns * motion.turn, 0

    # --- coordinates in the section
    def spots(self, passage: Place) -> np.ndarray:
        """Spots whose remembered speed is a coordinate here."""
        return np.flatnonzero(passage.touching & self.motion.remembers)

    def vector(self, passage: Place) -> np.ndarray:
        """Coordinates of a passage in natural sizes: states, then remembered speeds."""
        spots = self.spots(passage)
        return np.concatenate(
            [
                passage.y[self.states] / self.scale[self.states],
                passage.speeds[spots] / self._speeds[spots],
            ]
        )

    def passage(self, vector: np.ndarray, like: Place) -> Place:
        """The place of these coordinates, in the same contacts as another one."""
        y, speeds, spots = like.y.copy(), like.speeds.copy(), self.spots(like)
        y[self.states] = vector[: self.states.size] * self.scale[self.states]
        speeds[spots] = np.maximum(vector[self.states.size :] * self._speeds[spots], 0.0)
        return self.motion.moved(like, y, speeds)

    @property
    def _speeds(self) -> np.ndarray:
        mechanism = self.motion.mechanism
        return mechanism.frequency * np.array([spot.reach for _, spot in mechanism.spots])

    # --- the map
    def next(self, passage: Place) -> Place:
        """The next passage. duration [s] and contacts are those of the way. Angles of bodies and
        drives go back by full turns where the forces are the same then: not those of a wheel that
        winds its spring.
        """
        before = self.motion.run.contact_count
        if self.angle is None:
            period = self.motion.turn
            end = self.motion.go(passage, self.phase * period, (self.phase + self.turns) * period)
            end = self.motion.later(end, self.turns)
        else:
            end = self._crossed(passage)
        self.contacts = self.motion.run.contact_count - before
        return self._wound(end, passage) or end

    def at_start(self, passage: Place) -> Place:
        """Place, at the beginning of a period, of the motion with this passage."""
        if self.angle is not None or self.phase == 0.0:
            return passage
        turn = self.motion.turn
        end = self.motion.later(self.motion.go(passage, self.phase * turn, turn), 1)
        return self._wound(end, passage) or end

    def _wound(self, passage: Place, like: Place) -> Place | None:
        """A place with its angles and drives as near to those of another as full turns bring them;
        None where the forces are others then.
        """
        turns = np.rint((passage.y - like.y)[self.winding] / TURN).astype(int)
        if not self.motion.alike(like, self.winding, turns, passage.turns - like.turns):
            return None
        y = passage.y.copy()
        y[self.winding] -= TURN * turns
        return replace(passage, y=y, turns=like.turns)

    def between(self, before: Place, after: Place) -> np.ndarray:
        """Difference between the states of two passages [natural sizes]; infinite where bodies or
        drives have made turns in between that change the forces.
        """
        end = self._wound(after, before)
        if end is None:
            return np.full(self.states.size, math.inf)
        return (end.y - before.y)[self.states] / self.scale[self.states]

    def _crossed(self, passage: Place) -> Place:
        """The passage of an autonomous motion through the same angle, after full turns."""
        motion, i = self.motion, self.angle
        rate = motion.mechanism.layout.rates.start + i
        motion._begin(passage, 0.0)
        way = self.turns * self.way
        state = motion.run.state
        for _ in range(TRIES):
            remaining, speed = passage.y[i] + way - state.y[i], state.y[rate]
            if abs(remaining) < LEFT:
                return self._straight(remaining / speed)
            step = motion.turn / CHUNK
            if remaining * speed > 0.0:
                step = min(step, remaining / speed)
            before = state.memory.copy()
            motion._advance(state.time + step)
            state = motion.run.state
            while (passage.y[i] + way - state.y[i]) * way < -LEFT * abs(way):
                np.copyto(state.memory, before)
                step *= 0.5
                motion._advance(state.time + step)
        raise NotPeriodic(
            f"the drive does not turn any more: {abs(state.y[rate]):.3g} rad/s after "
            f"{state.time:.3g} s"
        )

    def _straight(self, time: float) -> Place:
        """The place a very short time ahead or behind; the duration of the passage is stored."""
        here, state = self.motion.here(), self.motion.run.state
        self.duration = float(state.time) + time
        return self.motion.moved(here, here.y + time * self.motion.rates(float(state.time), here))

    def outputs(self, passage: Place, channels: list[str]) -> np.ndarray:
        """Values of channels where each turn begins, (turns, channels)."""
        motion, here, rows = self.motion, self.at_start(passage), []
        columns = [motion.mechanism.layout.output[c] for c in channels]
        for turn in range(self.turns if columns else 0):
            if turn:
                here = motion.go(here, (turn - 1) * motion.turn, turn * motion.turn)
            work = motion.work(here)
            rows.append(motion.mechanism.outputs(turn * motion.turn, here.y, work)[columns])
        return np.array(rows).reshape(len(rows), len(columns))

    def change(self, passage: Place) -> tuple[np.ndarray, Place]:
        """Difference between the next passage and this one, in natural sizes, and the next one.

        Raises NotPeriodic where other joints are in contact there.
        """
        end = self.next(passage)
        if not np.array_equal(self.spots(end), self.spots(passage)):
            raise NotPeriodic("other joints are in contact one period later")
        if not np.array_equal(end.turns, passage.turns):
            raise NotPeriodic("springs or teeth are wound up by turns in a period")
        return self.vector(end) - self.vector(passage), end

    def apart(self, passage: Place) -> np.ndarray:
        """Difference between the states of the next passage and these [natural sizes]."""
        return self.between(passage, self.next(passage))

    def central(self, passage: Place, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivative of the map by central differences, and half of what forward ones have more
        than backward ones.

        The increment is the cube root of the local tolerance, the square root where neighbours
        that far away have other contacts. At a smaller one the integration's errors count more.
        """
        return self._central(passage, image)[0]

    def refined(self, passage: Place, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivative by central differences with half the increment, and two matrices of errors.

        The first is what the spread of `central` has beyond the part that is proportional to the
        increment, which central differences do not have: noise and kinks. The second is what half
        the increment changes.
        """
        (entire, spread), (half, less) = self._central(passage, image, 1.0, 0.5)
        return half, np.hstack([2.0 * less - spread, half - entire])

    def _central(self, passage: Place, image: np.ndarray, *shares: float) -> list[tuple]:
        """Derivatives and spreads at shares of the increment."""
        for step in (self.motion.rtol ** (1.0 / 3.0), math.sqrt(self.motion.rtol)):
            try:
                sides = [
                    [self.derivative(passage, image, s * step) for s in (share, -share)]
                    for share in shares or (1.0,)
                ]
            except NotPeriodic as error:
                reason = error
            else:
                return [(0.5 * (a + b), 0.5 * (a - b)) for a, b in sides]
        raise reason

    def derivative(self, start: Place, image: np.ndarray, step: float | None = None) -> np.ndarray:
        """Derivative of the map by one-sided differences; image: coordinates of the next passage.

        step: increment, negative for backward ones (default: root of the local tolerance).
        """
        base, step = self.vector(start), step or math.sqrt(self.motion.rtol)
        columns, way = [], (self.duration, self.contacts)
        for i in range(base.size):
            moved = base.copy()
            moved[i] += step
            change, _ = self.change(self.passage(moved, start))
            columns.append((change + moved - image) / step)
        self.duration, self.contacts = way  # of the passage itself, not of its neighbours
        return np.stack(columns, axis=1)


def _driven_angle(mechanism: Mechanism) -> tuple[int, float]:
    """Place of the angle that a finite drive turns, and a turn the way of its nominal speed.

    Raises ValueError where the angle is no state.
    """
    drive = next(d for d in mechanism.scene.drives if d.nominal)
    free = [i for i, c in enumerate(mechanism.plan.free) if c.turns]
    turning = [i for i in free if mechanism.plan.free[i].address[0] is drive.target] or free
    if not turning:
        raise ValueError(f"{drive.label()}: its angle is no state of the motion")
    return turning[0], math.copysign(TURN, drive.nominal)
