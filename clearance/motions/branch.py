"""A periodic motion followed through a parameter: folds, period doublings, grazing, stability.

Pseudo-arclength continuation: the unknowns are the coordinates Y of the section, in natural sizes,
and the parameter p over its range. F(Y, p) = P(Y; p) - Y = 0 is a curve. From a point on it the way
goes along its tangent by ds, and back to the curve at right angles to that. So it passes folds,
where the parameter turns back and the tangent has no share of it. In a period doubling a curve of
motions of twice the period begins, along the eigenvector of the multiplier -1.
Source: Seydel, Practical Bifurcation and Stability Analysis, 3rd ed., Springer 2010, ch. 4 and 7.
"""

import math
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np

from clearance.accuracy.horizon import NotSolved
from clearance.motions.maps import Motion, NotPeriodic, Place, Section
from clearance.motions.shooting import multipliers
from clearance.motions.steady import Family, Search, calmest
from clearance.scene.scene import Scene
from clearance.values.units import written

FIRST, SMALLEST, LARGEST = 0.01, 1e-6, 0.03  # steps along the curve: the first, the least, the most
QUIET = 0.2  # the longest step where the branch is quiet
QUICK, CALM = 2, 0.5  # rounds of the corrector, and multipliers, of a quiet branch at most
GROW, SHRINK = 1.4, 0.5  # of the step after a point that was easy, and after none
EASY = 4  # rounds of the corrector that an easy point takes at most
ROUNDS = 9  # of the corrector, at most
LIMIT = 0.3  # natural sizes: its longest step
BENT = 0.97  # least cosine between two tangents of one step
LOCATED = 1e-6  # of the range: how nearly a bifurcation's parameter is located
TURNED = 1e-3  # share of the parameter in the tangent below which it stands in a fold
SEARCHES = 14  # points made to locate one bifurcation, at most
EVERY = 8  # points after which the section is chosen again
STEEP = 0.02  # share of the parameter in the tangent that gives the way through another section
AWAY = (0.003, 0.01, 0.03)  # natural sizes: from a doubling to the first motion of twice the period
REAL = 1e-6  # imaginary over real part of a multiplier that counts as real

POINTS = " points"  # after which a curve ends
FOLD, DOUBLING, TORUS, GRAZING = "fold", "period doubling", "torus", "grazing"


@dataclass(frozen=True)
class Point:
    """A periodic motion on a branch. value: of the parameter; multipliers: Floquet, the largest
    first; errors: of each; slope: share of the parameter in the tangent, which changes its sign in
    a fold; contacts: that end in a period; outputs: values of the channels at the start of each
    turn, (turns, channels); kind: of bifurcation, empty for a point on the way; branch: 0, or the
    number of the doubling that its curve begins in.
    """

    value: float
    period: int
    duration: float
    multipliers: np.ndarray
    errors: np.ndarray
    slope: float
    contacts: int
    outputs: np.ndarray
    phase: float
    passage: Place = field(repr=False)
    tangent: np.ndarray = field(repr=False)
    matrix: np.ndarray = field(repr=False)
    kind: str = ""
    branch: int = 0

    @property
    def largest(self) -> float:
        """Size of the largest multiplier."""
        return float(np.abs(self.multipliers).max(initial=0.0))

    @property
    def stable(self) -> bool:
        """True where neighbouring motions come back to it."""
        return self.largest < 1.0

    @property
    def decided(self) -> bool:
        """True where the errors of the multipliers are too small to change the stability."""
        sizes = np.abs(self.multipliers)
        return bool(np.all(sizes + self.errors < 1.0) or np.any(sizes - self.errors >= 1.0))


class Follower:
    """A branch of periodic motions, point by point.

    scene: of a value of the parameter; low, high: its range; channels: outputs to keep; unit: of
    the parameter in sentences.
    """

    def __init__(
        self,
        scene: Callable[[float], Scene],
        low: float,
        high: float,
        tolerance: float,
        rtol: float,
        channels: list[str],
        step: float | None = None,
        unit: str = "",
        max_steps: int | None = None,
    ):
        self.max_steps = max_steps  # of a turn at the start; of a period, then
        self.scene, self.low, self.high = scene, low, high
        self.tolerance, self.rtol, self.channels, self.unit = tolerance, rtol, channels, unit
        # the longest steps along the curve: anywhere, and where it is quiet, see `_next`
        self.largest, self.quiet = step or LARGEST, step or QUIET
        self.turns, self.phase, self.like = 1, 0.0, None
        self.sections: dict[float, Section] = {}
        # of a curve that begins in a doubling: how far two halves of the period are apart
        self.halves: np.ndarray | None = None
        self.shown: np.ndarray | None = None  # outputs of the point before
        self.reason = ""

    # --- the curve
    def start(
        self, value: float, towards: float, most: int, report: Callable[[str], None]
    ) -> Point:
        """The periodic motion that the scene settles to at a value of the parameter."""
        motion = Motion(self.scene(value), self.rtol, max_steps=self.max_steps)
        search = Search(motion, self.tolerance, most, report)
        section, fixed = search.solved(motion.start())
        self.turns, self.phase, self.like = section.turns, section.phase, fixed.passage
        self.max_steps = motion.enough
        unknowns = np.append(section.vector(fixed.passage), self._share(value))
        direction = np.zeros(unknowns.size)
        direction[-1] = math.copysign(1.0, towards - value)
        return self._point(unknowns, direction)

    def _share(self, value: float) -> float:
        return (value - self.low) / (self.high - self.low)

    def _value(self, unknowns: np.ndarray) -> float:
        return float(self.low + unknowns[-1] * (self.high - self.low))

    def _text(self, point: Point) -> str:
        """The parameter of a point, as the user writes it."""
        return written(point.value, self.unit, 9)

    def section(self, value: float) -> Section:
        """The section of the scene at a value of the parameter; the last few stay."""
        if value not in self.sections:
            if len(self.sections) > 3:
                del self.sections[next(iter(self.sections))]
            motion = Motion(self.scene(value), self.rtol, max_steps=self.max_steps)
            self.sections[value] = Section(motion, self.turns, self.phase)
        return self.sections[value]

    def change(self, unknowns: np.ndarray) -> np.ndarray:
        """F(Y, p)."""
        section = self.section(self._value(unknowns))
        return section.change(section.passage(unknowns[:-1], self.like))[0]

    def matrix(self, unknowns: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Derivative of F by Y and p, by forward differences."""
        section, base = self.section(self._value(unknowns)), unknowns[:-1]
        derivative = section.derivative(section.passage(base, self.like), base + change)
        return self._with_parameter(derivative, unknowns, change)

    def _with_parameter(
        self, derivative: np.ndarray, unknowns: np.ndarray, change: np.ndarray
    ) -> np.ndarray:
        """Derivative of F from that of P by Y; the parameter's difference goes into its range."""
        moved = unknowns.copy()
        moved[-1] += math.copysign(self.rtol ** (1.0 / 3.0), 0.5 - unknowns[-1])
        slope = (self.change(moved) - change) / (moved[-1] - unknowns[-1])
        return np.column_stack([derivative - np.eye(change.size), slope])

    def _point(self, unknowns: np.ndarray, along: np.ndarray, kind: str = "") -> Point:
        """The point of the curve at these unknowns; its tangent goes along a direction."""
        value = self._value(unknowns)
        section, change = self.section(value), self.change(unknowns)
        if np.any(section.motion.held & section.motion.remembers):
            raise Family("a contact lasts for the entire period")
        contacts, duration = section.contacts, section.duration
        passage = section.passage(unknowns[:-1], self.like)
        derivative, spread = section.central(passage, unknowns[:-1] + change)
        matrix = self._with_parameter(derivative, unknowns, change)
        tangent = null_vector(matrix, along)
        outputs = self.shown = aligned(section.outputs(passage, self.channels), self.shown)
        return Point(
            value,
            self.turns,
            duration,
            *multipliers(derivative, spread),
            float(tangent[-1]),
            contacts,
            outputs,
            self.phase,
            passage,
            tangent,
            matrix,
            kind,
        )

    def unknowns(self, point: Point) -> np.ndarray:
        """Coordinates and parameter of a point."""
        return np.append(self.section(point.value).vector(point.passage), self._share(point.value))

    def step(self, point: Point, length: float) -> tuple[Point, int]:
        """The point of the curve this far along the tangent of another, and the rounds that it
        took.

        Raises NotPeriodic where the corrector does not converge, NotSolved where a motion ends.
        """
        tangent = point.tangent
        return self._corrected(self.unknowns(point) + length * tangent, tangent, point.matrix)

    def _corrected(
        self, first: np.ndarray, tangent: np.ndarray, matrix: np.ndarray
    ) -> tuple[Point, int]:
        """The point of the curve beside a guess, at right angles to a tangent; as `step`."""
        guess, bordered = first, np.vstack([matrix, tangent])
        change, last = self.change(guess), math.inf
        for n in range(ROUNDS):
            right = np.append(-change, tangent @ (first - guess))
            move = np.linalg.solve(bordered, right)
            size = float(np.abs(move).max())
            if size > LIMIT or (n > 2 and size > last):
                break
            guess = guess + move
            change = self.change(guess)
            if size < self.tolerance:
                return self._point(guess, tangent), n + 1
            bordered[:-1] += np.outer(change, move) / (
                move @ move
            )  # Broyden: F was zero by the model
            last = size
        raise NotPeriodic(f"the corrector stays {min(size, last):.2g} away")

    # --- the section
    def resectioned(self, point: Point) -> Point:
        """The same motion at the section that suits it best; the same point near a fold."""
        section = self.section(point.value)
        if (
            section.angle is not None
            or not section.motion.remembers.any()
            or abs(point.slope) < STEEP
        ):
            return point
        phase, passage = calmest(section, point.passage)
        if phase == self.phase:
            return point
        self.sections.clear()
        self.phase, self.like = phase, passage
        section = self.section(point.value)
        unknowns = np.append(section.vector(passage), self._share(point.value))
        along = np.zeros(unknowns.size)
        along[-1] = point.slope
        point = self._point(unknowns, along)
        self.halves = None if self.halves is None else self._halves(point)
        return point

    # --- motions of twice the period
    def doubled(self, point: Point) -> tuple["Follower", Point]:
        """The curve of motions of twice the period that begins in a period doubling: its follower
        and its first point.

        Raises NotPeriodic where no such motion is met.
        """
        values, vectors = np.linalg.eig(point.matrix[:, :-1] + np.eye(len(point.matrix)))
        way = vectors[:, np.abs(values + 1.0).argmin()].real
        follower = self._standing(point, 2 * point.period)
        base, along = follower.unknowns(point), np.append(way / np.linalg.norm(way), 0.0)
        for length in AWAY:
            guess = base + length * along
            try:
                matrix = follower.matrix(guess, follower.change(guess))
                first, _ = follower._corrected(guess, along, matrix)
                follower.halves = follower._halves(first)
            except (NotPeriodic, NotSolved, np.linalg.LinAlgError):
                continue
            if np.linalg.norm(follower.halves) > length:  # about twice the way
                return follower, first
        raise NotPeriodic(f"no motion of twice the period was met at {self._text(point)}")

    def again(self, point: Point) -> tuple["Follower", Point]:
        """A follower that goes on from a point of a file, and that point with its derivative."""
        drives = self.section(point.value).motion.rounds.size  # old files have no turns of them
        passage = replace(point.passage, turns=np.resize(point.passage.turns, drives))
        point = replace(point, passage=passage)
        follower = self._standing(point, point.period)
        follower.halves = follower._halves(point) if point.branch else None
        unknowns = follower.unknowns(point)
        return follower, replace(point, matrix=follower.matrix(unknowns, follower.change(unknowns)))

    def _standing(self, point: Point, turns: int) -> "Follower":
        """Another follower at a point, with the section of that, and a number of turns."""
        follower = copy(self)
        follower.turns, follower.phase, follower.like = turns, point.phase, point.passage
        follower.sections, follower.halves, follower.reason = {}, None, ""
        follower.shown = point.outputs
        return follower

    def _halves(self, point: Point) -> np.ndarray:
        """Difference between the passage half a period later and that of a point [natural sizes];
        empty where other joints are in contact there.
        """
        section = Section(self.section(point.value).motion, self.turns // 2, self.phase)
        try:
            return section.change(point.passage)[0]
        except NotPeriodic:
            return np.zeros(0)

    def _joined(self, point: Point) -> bool:
        """True where a curve has passed through a motion of half its period since the point before.
        From there on it comes back, half a period later.
        """
        if self.halves is None:
            return False
        before, now = self.halves, self._halves(point)
        if now.size != before.size:
            return False
        self.halves = now
        return float(now @ before) < 0.0

    # --- the branch
    def points(self, first: Point, most: int) -> Iterator[Point]:
        """Points of the branch from the first on, bifurcations among them where they lie.

        It ends where the parameter leaves its range, after so many points, or where no step is
        short enough; `reason` states which.
        """
        point, length = first, min(FIRST, self.largest)
        self.reason = f"{most}{POINTS}"
        yield first
        for n in range(1, most):
            point = self.resectioned(point) if n % EVERY == 0 else point
            reached = self._stepped(point, length) or self._stepped(self.resectioned(point), length)
            if reached is None:
                return
            new, length = reached
            if self._joined(new):
                self.reason = f"it joins motions of half its period at {self._text(new)}"
                return
            yield from self.between(point, new)
            if not 0.0 <= (share := self._share(new.value)) <= 1.0:
                self.reason = "the parameter left its range"
                yield self._ending(point, new, min(max(share, 0.0), 1.0))
                return
            yield new
            point = new

    def _stepped(self, point: Point, length: float) -> tuple[Point, float] | None:
        """The next point, and the length to try after it; None where there is none."""
        while length > SMALLEST:
            try:
                new, rounds = self.step(point, length)
                if new.tangent @ point.tangent > BENT and new.contacts == point.contacts:
                    return new, self._next(length, rounds, new)
                if length <= 10.0 * SMALLEST:
                    return new, FIRST * 0.1
                reason = "contacts change" if new.contacts != point.contacts else "it bends"
            except (NotPeriodic, NotSolved, np.linalg.LinAlgError) as error:
                reason = str(error)
            length *= SHRINK
        self.reason = f"no step is short enough at {self._text(point)}: {reason}"
        return None

    def _next(self, length: float, rounds: int, new: Point) -> float:
        """The step after one that took so many rounds. Beyond the longest it grows where the
        tangent met the curve, and where few rounds did with motions that settle fast: no
        bifurcation is near. One round more, and it stays.
        """
        quiet = rounds == 1 or new.largest < CALM and rounds <= QUICK + 1
        most = self.quiet if quiet else self.largest
        easy = QUICK if length >= self.largest else EASY
        return min(length * GROW if rounds <= easy else length, most)

    def _ending(self, a: Point, b: Point, share: float) -> Point:
        """The point between two others where the parameter reaches an end of its range."""
        return self._located(a, b, "", lambda point: self._share(point.value) - share)

    def between(self, a: Point, b: Point) -> Iterator[Point]:
        """Bifurcations between two points of the curve, located."""
        points_between = []
        if a.contacts != b.contacts:
            points_between.append(replace(b, kind=GRAZING))
        for kind, test in TESTS.items():
            low, high = test(a), test(b)
            if low is not None and high is not None and low * high < 0.0:
                near = TURNED if kind == FOLD else LOCATED
                points_between.append(self._located(a, b, kind, test, near))
        yield from sorted(points_between, key=lambda p: abs(p.value - a.value))

    def _located(
        self, a: Point, b: Point, kind: str, test: Callable, near: float = LOCATED
    ) -> Point:
        """The point between two others where a test function is zero: bisection, secants inside."""
        apart = float(np.linalg.norm(self.unknowns(b) - self.unknowns(a)))
        low, high, at_low, at_high, best = 0.0, apart, test(a), test(b), b
        for _ in range(SEARCHES):
            length = low + (high - low) * min(max(at_low / (at_low - at_high), 0.1), 0.9)
            try:
                best, _ = self.step(a, length)
            except (NotPeriodic, NotSolved):
                break
            value = test(best)
            if value is None or abs(value) < near or (high - low) < LOCATED:
                break
            if value * at_low > 0.0:
                low, at_low = length, value
            else:
                high, at_high = length, value
        return replace(best, kind=kind)


def aligned(outputs: np.ndarray, before: np.ndarray | None) -> np.ndarray:
    """Outputs, (turns, channels), with the turns in the order of the point before: another section
    may begin the period with another turn.
    """
    if before is None or before.shape != outputs.shape or not outputs.size:
        return outputs
    size = np.abs(before).max(axis=0) + 1e-300
    ways = [np.roll(outputs, turn, axis=0) for turn in range(len(outputs))]
    return min(ways, key=lambda way: float((np.abs(way - before) / size).max()))


def null_vector(matrix: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Unit vector that a matrix with one row less than columns takes to zero, along a direction."""
    vector = np.linalg.svd(matrix)[2][-1]
    return vector if vector @ along >= 0.0 else -vector


def _doubling(point: Point) -> float:
    """Product of 1 + mu over all multipliers: it changes its sign where a real one passes -1."""
    return float(np.prod(1.0 + point.multipliers).real)


def _torus(point: Point) -> float | None:
    """Size of the largest complex multiplier less 1."""
    complexes = point.multipliers[np.abs(point.multipliers.imag) > REAL * np.abs(point.multipliers)]
    return float(np.abs(complexes).max() - 1.0) if complexes.size else None


#: functions that change their sign in a bifurcation
TESTS = {FOLD: lambda point: point.slope, DOUBLING: _doubling, TORUS: _torus}
