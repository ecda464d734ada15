"""Periodic motion of a scene, by waiting where that is quick, else by a solver."""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from clearance.mechanism.build import build
from clearance.motions.maps import AtDeadCentre, Motion, NotPeriodic, Place, Section
from clearance.motions.orbit_sensitivities import FINEST, orbit_sensitivities
from clearance.motions.periodic_errors import paired
from clearance.motions.shooting import Fixed, newton, settled, slow_states
from clearance.results.errors import AUTO
from clearance.results.record import Record, warn
from clearance.results.result import Result
from clearance.run.options import Output
from clearance.run.progress_bar import watched
from clearance.run.run import Run
from clearance.run.start import opened_by
from clearance.scene.catalogue import AnyCase, load_case
from clearance.scene.parameter import Wanted
from clearance.scene.scene import Scene
from clearance.simulation import prepare, write
from clearance.values import checks
from clearance.values.accessors import Celled

FINE, COARSE = 1e-13, 1e-9  # local tolerances, at least and at most
FINER = 1e-6  # local tolerance over the requested one
NEAR = 1e-2  # natural sizes: a motion that comes back so nearly is worth Newton's method
CLOSE = 3.0  # least change over some turns: a shorter period may have so much more
LEAVING = 1e-3  # natural sizes: beside an unstable motion, where a motion that leaves it begins
SIDEWAYS = 200  # periods of it, at most
RUNAWAY = 1e9  # natural sizes: a motion that changes by so much in a turn does not come back
AGAIN = 20  # periods more where that failed
SAME = 10.0  # tolerances within which two passages are one
PHASES = 48  # of a turn, among which the section is chosen
LONG = 0.1  # of a turn: a free flight that is worth a section
MOST_PERIOD = 16  # turns
FEWEST = 3  # turns before slow states are solved for
FAST = 0.5  # change over a turn, over that of the turn before: below it waiting is quicker


@dataclass(frozen=True)
class Steady(Celled):
    """A periodic motion. orbit: one period of it, a result whose file has the rest in the
    attributes of /steady.

    multipliers: Floquet multipliers of the period, the largest first; those of an autonomous motion
    without the 1 along it; errors: of each. period: turns of the drive; duration [s]. change: of
    the states over a period; distance: from the periodic motion (both in natural sizes). waited:
    plain turns; turns_spent: all turns that were integrated. slow: states that were solved for
    alone; plain_turns: an estimate of those that waiting for them would have taken. phase: of the
    turn at which states are compared; states: their values there.
    """

    orbit: Result
    multipliers: np.ndarray
    errors: np.ndarray
    period: int
    duration: float
    change: float
    distance: float
    waited: int
    turns_spent: float
    slow: tuple[str, ...]
    plain_turns: float | None
    phase: float
    states: dict[str, float]
    autonomous: bool


@watched
def steady(
    scene: AnyCase,
    tolerance: float | str = 1e-6,
    *,
    period: float | None = None,
    most_turns: int = 400,
    start: Record | str | Path | None = None,
    rtol: float | None = None,
    method: str = "auto",
    max_steps: int | None = None,
    path: str | Path | None = None,
    samples_per_turn: int = 400,
    channels=None,
    compression: int = 0,
    error: str | None = AUTO,
    sensitivity: Wanted | None = None,
    progress: Callable[[str], None] | bool | None = None,
) -> Steady:
    """The periodic motion that a scene settles to.

    tolerance: distance from it, in natural sizes of the states (clearance for eccentricities, 10 K
    for warmings). Motions that forget their start in some turns are waited for. Slow states, such
    as the warming of oil, integrals of drives and the speed of a flywheel, have a solver of their
    own. It is a secant method that carries the fast states along. Then, and for dry joints,
    Newton's method closes the orbit and gives its multipliers: P(y) = y. P is the map of a section,
    in free flight if there is one. period [s]: takes the place of the turn of the drive. A drive
    without constant speed has an unknown period, and the section is an angle of it. most_turns:
    plain turns before it is given up. start: as in `simulate`. rtol: local tolerance (default 1e-6
    times the tolerance); method: as in `simulate`; max_steps: of a turn, before it is given up.
    path, samples_per_turn, channels, compression: of the file that keeps one period, as in
    `simulate`. error: "auto" states the errors of its numbers, of integration and of what is left
    over, see periodic_errors.py; None: not. sensitivity: parameters by which the metrics of the
    periodic motion are differentiated (`orbit.sensitivities`, see orbit_sensitivities.py).
    Raises ValueError for scenes without a periodic drive or a freedom, and for films with a memory.
    Raises NotPeriodic where no period is reached (a chaotic motion), or none is isolated. Raises
    NotSolved where the motion ends. Warns by `RunWarning` as `simulate`.
    Source: Seydel, Practical Bifurcation and Stability Analysis, 3rd ed., Springer 2010, ch. 7.

    Example:

        >>> orbit = cl.steady(cl.load_case("slider_crank", model="lubricated"), 1e-4)
        >>> orbit.period, bool(abs(orbit.multipliers).max() < 1.0)
        (1, True)
    """
    scene, (tolerance, rtol) = load_case(scene), tolerance_of(tolerance, rtol)
    period = period if period is None else checks.positive("period", period)
    output = Output(path, channels, compression)
    report = progress or (lambda text: None)

    extra = None
    if sensitivity is not None:
        rest = {"period": period, "most_turns": most_turns, "method": method, "error": None}
        rest |= {"rtol": rtol, "max_steps": max_steps, "samples_per_turn": samples_per_turn}
        extra, start = _sensing(scene, sensitivity, min(tolerance, FINEST), start, rest)

    def search_of(opened: tuple) -> Search:
        mechanism = build(scene, ledger=False, opened=opened)
        motion = Motion(scene, rtol, method, period, mechanism, max_steps)
        return Search(motion, tolerance, most_turns, report)

    search, section, fixed = _solved(search_of, start)
    facts = _numbers(search, section, fixed)
    orbiting = partial(_orbiting, samples_per_turn)
    run = orbiting(section, fixed)
    run.facts["steady"] = _facts(fixed, facts | {"tolerance": tolerance}, search.slow)
    pair = partial(paired, section, fixed, orbiting)
    orbit = write(run, output, None, error, 0.0, pair, extra=extra)
    warn(orbit.warnings)
    names = search.motion.mechanism.layout.names
    states = {name: float(fixed.passage.y[i]) for i, name in enumerate(names)}
    values = fixed.multipliers, fixed.errors
    return Steady(orbit, *values, slow=search.slow, states=states, **facts)


def _sensing(scene: Scene, parameters: Wanted, tolerance: float, start, options: dict):
    """A function that adds sensitivities to the file of a periodic motion, and the motion as a
    start.
    """
    options["rtol"] = min(options["rtol"], tolerance_of(tolerance, None)[1])

    def solve(varied: Scene, start) -> Result:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return steady(varied, tolerance, start=start, **options).orbit

    sensitivities, orbit = orbit_sensitivities(scene, parameters, solve, start)

    def add(sink) -> None:
        """Add them to a sink, or the reason."""
        sink.add(sensitivities.groups())

    return add, orbit


def _solved(
    search_of: Callable[[tuple], "Search"], start: Record | str | Path | None
) -> tuple["Search", Section, Fixed]:
    """The search that reaches a periodic motion, its section and its fixed point. Loops are opened
    that come to their dead centres on the way.
    """
    opened = () if start is None else opened_by(start)
    while True:
        search = search_of(opened)
        try:
            return search, *search.solved(search.motion.start(start))
        except AtDeadCentre as dead:
            search.report(f"{dead}: again with places of its bodies as coordinates")
            opened = (*opened, dead.joint)


def _numbers(search: "Search", section: Section, fixed: Fixed) -> dict:
    """Numbers that a search came to, by name."""
    return {
        "period": section.turns,
        "duration": section.duration,
        "change": fixed.change,
        "distance": fixed.distance,
        "waited": search.waited,
        "turns_spent": search.motion.spent / search.motion.turn,
        "plain_turns": search.plain_turns(fixed),
        "phase": section.phase,
        "autonomous": search.motion.autonomous,
    }


def tolerance_of(tolerance: float | str, rtol: float | None) -> tuple[float, float]:
    """The distance requested and the local tolerance that suits it.
    Raises ValueError naming them.
    """
    tolerance = checks.share("tolerance", tolerance)
    if rtol is None:
        return tolerance, min(max(FINER * tolerance, FINE), COARSE)
    return tolerance, checks.positive("rtol", rtol)


class Search:
    """The way to a periodic motion. waited: plain turns so far; slow: states that were solved
    for alone, and how far away they were where that began [natural sizes].
    """

    def __init__(self, motion: Motion, tolerance: float, most: int, report: Callable[[str], None]):
        self.motion, self.tolerance, self.most, self.report = motion, tolerance, most, report
        self.waited, self.slow, self.far, self.reason = 0, (), 0.0, ""
        self.passages: list[Place] = []

    def solved(self, start: Place) -> tuple[Section, Fixed]:
        """A section and its fixed point.
        Raises NotPeriodic where there is none within the turns allowed.
        """
        section, self.passages = Section(self.motion), [start]
        slow = slow_states(section)
        while self.waited < self.most:
            turns = self._wait(section, slow)
            if turns is None:
                break
            try:
                return self._closed(section, slow, turns)
            except NotPeriodic as reason:
                if isinstance(reason, Family) and self._change(section, turns) < self.tolerance:
                    raise
                self.reason, slow = str(reason), []
                for _ in range(min(AGAIN, self.most - self.waited)):
                    self._turn(section)
        raise NotPeriodic(self._failure(section))

    def _turn(self, section: Section) -> None:
        """One plain turn."""
        self.passages.append(section.next(self.passages[-1]))
        self.waited += 1

    def _change(self, section: Section, turns: int, before: int = 0) -> float:
        """Change of the states over the last turns that ended `before` turns ago [natural
        sizes].
        """
        last = len(self.passages) - 1 - before
        if last < turns:
            return math.inf
        apart = section.between(self.passages[last - turns], self.passages[last])
        return float(np.abs(apart).max())

    def _wait(self, section: Section, slow: list[int]) -> int | None:
        """Plain turns until the motion comes back nearly; after how many turns it does. None
        where it never does.
        """
        while self.waited < self.most:
            self._turn(section)
            changes = [self._change(section, k) for k in range(1, MOST_PERIOD + 1)]
            self.report(f"turn {self.waited}: back to {min(changes):.2g}")
            if RUNAWAY < changes[0] < math.inf:
                far = f"{changes[0]:.2g} of their natural sizes in turn {self.waited}"
                raise NotPeriodic(f"the motion runs away: states change by {far}")
            if slow and self.waited >= FEWEST:
                return 1
            enough = max(CLOSE * min(changes), self.tolerance)
            turns = 1 + next(i for i, change in enumerate(changes) if change <= enough)
            if min(changes) < NEAR and not self._quick(section, turns):
                return turns
        return None

    def _quick(self, section: Section, turns: int) -> bool:
        """True where the next turns will bring more than Newton's method does."""
        change = self._change(section, turns)
        return self.tolerance < change < FAST * self._change(section, turns, turns)

    def _closed(self, section: Section, slow: list[int], turns: int) -> tuple[Section, Fixed]:
        """Solved from where the motion stands."""
        passage, tolerance = self.passages[-1], self.tolerance
        if slow:
            before = section.vector(passage)[slow]
            passage = settled(section, passage, slow, tolerance, self.report)
            names = section.motion.mechanism.layout.names
            self.slow = tuple(names[section.states[i]] for i in slow)
            self.far = float(np.abs(section.vector(passage)[slow] - before).max())
        section, passage = self._best_section(section, passage, turns)
        self.report(f"solving for a motion of {numbered(turns)}")
        section.next(passage)
        if any(self.motion.held & self.motion.remembers):
            raise Family(self._held())
        section, fixed = self._shortest(section, newton(section, passage, tolerance))
        if (largest := abs(fixed.multipliers[0])) < 1.0:
            return section, fixed
        if (beside := self._beside(section, fixed)) is not None:
            return section, beside
        text = f"a motion of {numbered(turns)} was met that is unstable"
        raise NotPeriodic(f"{text} (multiplier of size {largest:.3g})")

    def _beside(self, section: Section, saddle: Fixed) -> Fixed | None:
        """The stable motion beside an unstable one, as both are near a fold.

        The motion leaves it to either side along the direction that grows. Where it slows down
        again, Newton's method begins.
        """
        values, vectors = np.linalg.eig(saddle.derivative)
        first = np.abs(values).argmax()
        if values[first].imag or values[first].real < 0.0:
            return None
        leaving = LEAVING * vectors[:, first].real
        for side in (leaving, -leaving):
            passage = section.passage(section.vector(saddle.passage) + side, saddle.passage)
            changes = [0.0]
            try:
                with self.motion.trials():
                    while changes[-1] < NEAR and len(changes) < SIDEWAYS:
                        before, passage = passage, section.next(passage)
                        changes.append(float(np.abs(section.between(before, passage)).max()))
                        if len(changes) > AGAIN and changes[-1] < FAST * max(changes):
                            break
                fixed = newton(section, passage, self.tolerance)
            except NotPeriodic:
                continue
            if abs(fixed.multipliers[0]) < 1.0:
                return fixed
        return None

    def _shortest(self, section: Section, fixed: Fixed) -> tuple[Section, Fixed]:
        """The same motion with its shortest period."""
        for turns in (k for k in range(1, section.turns) if section.turns % k == 0):
            shorter = Section(self.motion, turns, section.phase)
            if np.abs(shorter.apart(fixed.passage)).max() < SAME * self.tolerance:
                return shorter, newton(shorter, fixed.passage, self.tolerance)
        return section, fixed

    def plain_turns(self, fixed: Fixed) -> float | None:
        """Turns that waiting would have taken to be within the tolerance, by the largest
        multiplier; None where nothing was slow.
        """
        largest = abs(fixed.multipliers[0])
        if not self.slow or largest == 0.0 or self.far <= self.tolerance:
            return None
        return self.waited + math.log(self.tolerance / self.far) / math.log(largest)

    def _held(self) -> str:
        spots = self.motion.mechanism.spots
        names = [spot.label(e) for (e, spot), h in zip(spots, self.motion.held, strict=True) if h]
        return (
            f"joint {', '.join(names)} stays in contact for the entire period: its contact law "
            "remembers the impact speed of the last touch, and each speed has a periodic motion of "
            "its own; a law without impact speed, such as hertz, has one"
        )

    def _best_section(self, section: Section, passage: Place, turns: int) -> tuple[Section, Place]:
        """A section away from the ends of contacts, and where the motion stands there."""
        motion = self.motion
        if motion.autonomous or not np.any(motion.remembers):
            return Section(motion, turns, section.phase), passage
        phase, passage = calmest(section, passage)
        return Section(motion, turns, phase), passage

    def _failure(self, section: Section) -> str:
        """The reason why no periodic motion was reached."""
        changes = [self._change(section, k) for k in range(1, MOST_PERIOD + 1)]
        best = int(np.argmin(changes)) + 1
        if math.isinf(min(changes)):
            return (
                f"no periodic motion within {self.waited} turns: turns of bodies wind up springs, "
                "teeth or laws of an angle further and further"
            )
        text = (
            f"no periodic motion within {self.waited} turns: states {numbered(best)} apart still "
            f"differ by {min(changes):.2g} of their natural sizes; it may be chaotic "
            "(clearance lyapunov), or need more turns"
        )
        return f"{text}; {self.reason}" if self.reason else text


def numbered(turns: int) -> str:
    """A number of turns in words."""
    return f"{turns} turn" if turns == 1 else f"{turns} turns"


def calmest(section: Section, passage: Place) -> tuple[float, Place]:
    """The phase of the next turn that lies furthest from the beginnings and ends of contacts, with
    the state there. It is the middle of a long free flight, else of the longest stretch in the same
    contacts.
    """
    motion = section.motion
    times = motion.turn * (section.phase + np.arange(1, PHASES + 1) / PHASES)
    places = motion.stops(passage, section.phase * motion.turn, times)
    stretches = [(len(same), same) for same in _stretches([section.spots(p) for p in places])]
    flights = [
        s for s in stretches if s[0] >= LONG * PHASES and not section.spots(places[s[1][0]]).size
    ]
    _, same = max(flights or stretches, key=lambda stretch: stretch[0])
    middle = same[len(same) // 2]
    phase, full = float(times[middle] / motion.turn) % 1.0, int(times[middle] / motion.turn)
    return phase, motion.later(places[middle], full)


def _stretches(spots: list[np.ndarray]) -> list[list[int]]:
    """Places in a cyclic list that follow one another with equal entries."""
    count = len(spots)
    edges = [i for i in range(count) if not np.array_equal(spots[i], spots[i - 1])] or [0]
    ends = [*edges[1:], edges[0] + count]
    return [[i % count for i in range(a, b)] for a, b in zip(edges, ends, strict=True)]


class Family(NotPeriodic):
    """Periodic motions that are not isolated."""


def _orbiting(samples: int, section: Section, fixed: Fixed) -> Run:
    """The run over one period, from the scene's time 0 on; samples: of a turn."""
    motion = section.motion
    run = prepare(
        motion.scene,
        until=section.duration,
        rtol=motion.rtol,
        method=motion.run.method.current,
        samples=samples * section.turns + 1,
        opened=motion.mechanism.opened,
    )
    run.begin_at(section.at_start(fixed.passage))
    run.mechanism.count_from(run.state.y, run.state.work)
    run.method.reason = motion.run.method.reason
    run.started = "a point of a periodic motion"
    return run


def _facts(fixed: Fixed, facts: dict, slow: tuple[str, ...]) -> dict:
    """Attributes of /steady."""
    attributes = {name: value for name, value in facts.items() if value is not None}
    parts = {
        "multipliers_real": fixed.multipliers.real,
        "multipliers_imaginary": fixed.multipliers.imag,
        "multipliers_error": fixed.errors,
    }
    return attributes | parts | {"slow": ", ".join(slow)}
