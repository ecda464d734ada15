"""The start of a run: bodies put together from a rough position, every loop closed, velocities from
the drives.

Coordinates that the plan of the mechanism leaves free start at the values of the scene. Examples
are the angle of an undriven crank or of a pendulum. The other bodies move to close the loops. Only
if the loops cannot be closed so do the free coordinates give way as well.

Works on absolute coordinates of all bodies (numpy, once per run).
"""

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from clearance.elements.body import ABSOLUTE, Body, Point, ground
from clearance.elements.element import Element
from clearance.elements.joint import FREE, RELATIVE, TURN, Joint
from clearance.mechanism.kinematics import Geometry
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.topology import closed_plan
from clearance.scene.scene import Scene
from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated
from clearance.values.algebra import least_squares, product, solutions
from clearance.values.columns import chosen, each

CLOSURE = 1e-12  # largest closing error accepted, relative to the mechanism's size
RANK = 1e-9  # singular values below this share of the largest count as zero
GUILTY = 1e-6  # share of an equation in a combination that is zero, from which it takes part
#: share of the least singular value of a position beside it, at which rounding leaves an error of
#: some 1e-16 / share^2 = 1e-5 of the rates
SINGULAR = 5e-6
AROUND = 8  # positions beside it
SMALLEST = 1e-12  # as RANK, of equations that start rates follow from
ITERATIONS = 200
LARGEST_TURN = 0.5  # rad a single correction may turn a body
MOST_POSITIONS = 100  # that a process keeps


@dataclass(frozen=True)
class _Position:
    """A closed position q, and values of all coordinates there.

    measured: places of the measured joints in the scene. rates: of all coordinates for each of the
        requested rates alone, see `_System.rates`.
    """

    q: np.ndarray
    measured: list[int]
    values: list[float]
    rates: np.ndarray


#: by all that they depend on: points of a sweep mostly share them
_positions: dict[tuple, _Position] = {}


@dataclass(frozen=True)
class Start:
    """Assembled poses and velocities: body -> (x, y, angle) of the centre of mass; size of the
    mechanism and farthest place from the origin [m].

    measured: joints that only forces hold and that would over-constrain the mechanism, such as a
        third bearing of a bar or a second rubber mount. Their states follow from the other
        coordinates; a turn is in (-pi, pi]. relative: value and rate of each relative coordinate,
        by (joint, name).
    """

    pose: dict[Body, tuple[float, float, float]]
    velocity: dict[Body, tuple[float, float, float]]
    size: float
    farthest: float
    measured: tuple[Joint, ...]
    relative: dict[tuple, tuple[float, float]]

    def value(self, coordinate: tuple) -> tuple[float, float]:
        """Value and rate of a coordinate: of a body ("x", "y", "angle"), or a relative one of a
        joint.
        """
        part, axis = coordinate
        if axis not in ABSOLUTE:
            return self.relative[coordinate]
        i = ABSOLUTE.index(axis)
        return self.pose[part][i], self.velocity[part][i]

    def coordinate(self, target: Body | Joint) -> float:
        """Start value of the coordinate of a drive's target."""
        return self.value(place_of(target))[0]


def place_of(target: Body | Joint) -> tuple:
    """The coordinate that a drive of this target drives."""
    return (target, "angle") if isinstance(target, Body) else (target, target.free[0])


def assemble(scene: Scene, numbers: Numbers | None = None) -> Start:
    """Close all loops and find the start velocities.

    Raises ValueError naming the joint for a loop that cannot close (and by how much), a locked
    mechanism or a redundant loop. The same holds for a drive that contradicts another.
    """
    numbers = numbers or Numbers(scene)
    system = _System(scene, numbers)
    key = numbers.signature, system.inputs()
    if key not in _positions:
        if len(_positions) >= MOST_POSITIONS:
            del _positions[next(iter(_positions))]  # the oldest
        _positions[key] = system.position()
    position = _positions[key]
    system.measure(position.measured)
    system.check_measured(position.q)
    values = position.values
    rates = (position.rates * system.requested()).sum(axis=1).tolist()
    relative = dict(zip(system.geometry.places, zip(values, rates, strict=True), strict=True))
    poses, velocities = (
        {b: tuple(q[span]) for b, span in system.pose.items()} | {ground: (0.0, 0.0, 0.0)}
        for q in (values[-position.q.size :], rates[-position.q.size :])
    )
    lengths = system.size, system.farthest
    return Start(poses, velocities, *lengths, tuple(system.measured), relative)


@dataclass(frozen=True)
class _Row:
    """One constraint equation: of which part, its coordinate's place, its value, and the rate its
    start requires, None for one that is always zero.
    """

    label: str
    coordinate: tuple
    value: float
    rate: float | None = None


class _System:
    """Constraint equations of a scene: joints first, then drives, then free coordinates that keep
    their start.
    """

    def __init__(self, scene: Scene, numbers: Numbers):
        self.scene = scene
        self.joints: list[Joint] = list(scene.joints)
        self.measured: list[Joint] = []
        self.geometry = Geometry.of(scene, numbers)
        self.pose = {b: self.geometry.pose(b) for b in scene.bodies}
        self.drives = scene.drives
        self.start: dict[Element, float] = {}
        self.held: list[_Row] = []
        self.size = size_of(scene)
        self.farthest = max(self.size, _farthest(scene))

    # --- position
    def inputs(self) -> tuple:
        """All that the closed position and `rates` depend on, beside the structure of the scene."""
        bodies = [(b.com, b.angle, b.position) for b in self.scene.bodies]
        points = [(p.x, p.y) for j in self.scene.joints for p in (j.a, j.b)]
        turning = [j for j in self.scene.joints if TURN not in j.free and j.turn.number]
        turns = [getattr(j, j.turn.number) for j in turning]
        states = [(s.start, s.start_rate) for j in self.scene.joints for s in j.states()]
        drives = [d.start if d.motion is None else float(d.motion(0.0)) for d in self.drives]
        moving = (d.speed_start is None for d in self.drives if not d.prescribes)
        rated = tuple(moving), tuple(self._given_rates())
        parts = map(tuple, (bodies, points, turns, states, drives))
        return (self.size, self.farthest, self.geometry.read, rated, *parts)

    def position(self) -> _Position:
        """The closed position."""
        q = self.rough()
        self.take_start_values(q)
        guilty, freedom = self.choose_measured(self.generic_position(q))
        if freedom and not guilty:
            self.hold(q)
        q = self.closed(q)
        if names := self._dependent(q, SINGULAR)[0]:
            if not guilty:
                self.report_singular(q, names)
            self.report_dependent(*self.choose_measured(q))
        places = map(self.scene.joints.index, self.measured)
        values, slopes = self.geometry(q)
        return _Position(q, list(places), values, product(slopes, self.rates(slopes)))

    def measure(self, places: Collection[int]) -> None:
        """Have the joints at these places of the scene measured, in this order."""
        self.measured = [self.scene.joints[index] for index in places]
        self.joints = [j for j in self.scene.joints if j not in self.measured]

    # --- rough start
    def rough(self) -> np.ndarray:
        """Body angles as given; positions as given, or along the joints from the ground."""
        q = np.zeros(self.geometry.size)
        placed = {ground}
        angles = {
            d.target: d.start
            for d in self.drives
            if d.start is not None and isinstance(d.target, Body)
        }
        for body in self.scene.bodies:
            q[self.pose[body]][2] = angles.get(body, body.angle)
            if body.position is not None:
                self._set_origin(q, body, body.position)
                placed.add(body)
        pending = list(self.scene.joints)
        while pending:
            joint = next((j for j in pending if len(placed & set(j.bodies())) == 1), None)
            if joint is None:
                break
            pending.remove(joint)
            self._follow(q, joint, placed)
        return q

    def _set_origin(self, q, body: Body, origin) -> None:
        pose = q[self.pose[body]]
        x, y = _turned(pose[2], *body.com[:2])
        pose[:2] = origin[0] + x, origin[1] + y

    def _follow(self, q, joint: Joint, placed: set) -> None:
        old, new = (joint.a, joint.b) if joint.a.body in placed else (joint.b, joint.a)
        pose = q[self.pose[new.body]]
        if TURN not in joint.free:
            angle = getattr(joint, joint.turn.number) if joint.turn.number else 0.0
            pose[2] = self._pose(q, old.body)[2] + (angle if new is joint.b else -angle)
        target = self._point(q, old)
        arm = _turned(pose[2], new.x - new.body.com[0], new.y - new.body.com[1])
        pose[:2] = target[0] - arm[0], target[1] - arm[1]
        placed.add(new.body)

    def take_start_values(self, q) -> None:
        """Start value of each driven coordinate: as given, from its motion, or that of the rough
        start.
        """
        for drive in self.drives:
            if drive.motion is not None:
                self.start[drive] = float(drive.motion(0.0))
            elif drive.start is not None:
                self.start[drive] = drive.start
            elif drive.prescribes:
                self.start[drive] = self._value(q, place_of(drive.target))

    def hold(self, q) -> None:
        """Free coordinates keep the values of the rough start, first those that drives push, unless
        the start of a drive decides them.
        """
        nearby = self.generic_position(q)
        pushing = [d for d in self.drives if not d.prescribes]
        driven = [place_of(d.target) for d in pushing if d not in self.start]
        free = [c.address for c in closed_plan(self.scene, tuple(self.measured)).free]
        for key in dict.fromkeys([*driven, *free]):
            self.held.append(_Row(f"start of {key[0].name}", key, self._value(q, key)))
            if pushing and np.linalg.matrix_rank(matrix := self.equations(nearby)[2]) < len(matrix):
                self.held.pop()

    # --- geometry
    def _pose(self, q, body: Body):
        return q[self.pose[body]] if body in self.pose else (0.0, 0.0, 0.0)

    def _point(self, q, point):
        x, y, angle = self._pose(q, point.body)
        dx, dy = _turned(angle, point.x - point.body.com[0], point.y - point.body.com[1])
        return x + dx, y + dy

    def _value(self, q, coordinate: tuple) -> float:
        return self.geometry.value(q, coordinate)

    # --- equations
    def equations(self, q, starting: bool = True):
        """Labels, residuals and Jacobian of all constraints.

        `starting` includes what only the start must meet: start values of effort drives and of held
        coordinates.
        """
        drives = [d for d in self.drives if d in self.start and (starting or d.prescribes)]
        rows = self._rows(drives) + (self.held if starting else [])
        return [r.label for r in rows], *self._open(q, rows)

    def _open(self, q, rows: list[_Row]) -> tuple[np.ndarray, np.ndarray]:
        """Residuals and Jacobian of rows."""
        values, slopes = self.geometry(q)
        chosen = [self.geometry.index[row.coordinate] for row in rows]
        return np.array(values)[chosen] - [row.value for row in rows], slopes[chosen]

    def _rows(self, drives) -> list[_Row]:
        """Of all joints, then of these drives."""
        rows = [row for joint in self.joints for row in self._joint_rows(joint)]
        return rows + [
            _Row(d.label(), place_of(d.target), self.start.get(d, 0.0), rate_at(d)) for d in drives
        ]

    def _joint_rows(self, joint: Joint) -> list[_Row]:
        """Equations of a joint: its states have their start values, other coordinates that it keeps
        are zero.
        """
        starts: dict = {s.name: (s.start, s.start_rate) for s in joint.states()}
        coordinates = ((axis, getattr(joint, axis)) for axis in RELATIVE)
        return [
            _Row(joint.label(), (joint, axis), *starts.get(source.state, (0.0, None)))
            for axis, source in coordinates
            if source is not FREE
        ]

    # --- closing
    def closed(self, q: np.ndarray) -> np.ndarray:
        """The closed position nearest to the rough start; held coordinates are let go where it
        closes only so.
        """
        best, worst = self._nearest(q)
        if worst > CLOSURE * self.farthest and self.held:
            self.held.clear()
            best, worst = self._nearest(q)
        if worst > CLOSURE * self.farthest:
            # too many equations for any position? (a stretched loop is singular too, so look beside
            # it)
            self.report_dependent(*self._dependent(self.generic_position(best)))
            labels, residual, _ = self.equations(best)
            self._report_open(labels, residual)
        return best

    def _nearest(self, q: np.ndarray) -> tuple[np.ndarray, float]:
        """Damped Gauss-Newton: the best position on the way, and its largest residual.

        Where coordinates are free, steps are the shortest ones; angles count times the size.
        """
        best, worst = q, math.inf
        rows = self._rows([d for d in self.drives if d in self.start]) + self.held
        lengths = self._lengths() if len(rows) < q.size else np.ones(q.size)
        for _ in range(ITERATIONS):
            residual, matrix = self._open(q, rows)
            error = float(np.abs(residual).max(initial=0.0))
            if error < worst:
                best, worst = q, error
            if error <= 0.01 * CLOSURE * self.farthest:
                break
            step = -least_squares(matrix / lengths, residual) / lengths
            turn = np.abs(step[self.geometry.angles]).max(initial=0.0)
            q = q + step * min(1.0, LARGEST_TURN / turn if turn else 1.0)
            if worst <= CLOSURE * self.farthest and np.abs(step).max() < 1e-15 * self.farthest:
                break
        return best, worst

    def _lengths(self) -> np.ndarray:
        """Factors that make lengths of changes of q [1, m]: the size for angles."""
        lengths = np.ones(self.geometry.size)
        lengths[self.geometry.angles] = self.size
        return lengths

    def generic_position(self, q: np.ndarray) -> np.ndarray:
        """A random nearby position, so that ranks are not those of a singular one."""
        return q + 0.1 * self.size * np.random.default_rng(1).uniform(-1.0, 1.0, q.size)

    def _report_open(self, labels, residual) -> None:
        totals: dict[str, float] = {}
        for label, r in zip(labels, residual, strict=True):
            totals[label] = math.hypot(totals.get(label, 0.0), r)
        label = max(totals, key=totals.get)
        raise ValueError(
            f"loop cannot close: {label} stays {totals[label]:.6g} m open "
            f"(all together {float(np.linalg.norm(residual)):.6g}); check lengths and the rough "
            f"start angles"
        )

    def choose_measured(self, q: np.ndarray) -> tuple[list[str], int]:
        """Leave out joints that only forces hold until the others' equations are independent at q.

        The last is left out first, one that turns only after all others. Returns what is dependent
        still, as `_dependent` does.
        """
        while True:
            guilty, freedom = self._dependent(q)
            loose = [j for j in self.joints if j.soft and j.label() in guilty]
            if not loose:
                return guilty, freedom
            last = max(loose, key=lambda j: (not j.turns, loose.index(j)))
            self.joints.remove(last)
            self.measured.append(last)

    def check_measured(self, q: np.ndarray) -> None:
        """A film joint whose eccentricity follows from the others must start inside its clearance
        circle.
        """
        for joint in self.measured:
            e = math.hypot(*(self._value(q, (joint, axis)) for axis in RELATIVE[:2]))
            reach = joint.film_reach if joint.outline is None else None
            if reach is not None and e >= reach:
                raise ValueError(
                    f"loop cannot close: {joint.label()} starts {e:.6g} m off centre, outside its "
                    f"clearance circle "
                    f"({reach:.6g} m); the other joints leave it no other place"
                )

    def report_dependent(self, names: list[str], freedom: int) -> None:
        """Every equation must constrain something of its own."""
        if not names:
            return
        if freedom == 0:
            raise ValueError(
                f"locked: the joints leave no movement at all; too many equations in "
                f"{', '.join(names)}"
            )
        if any(not n.startswith("joint") for n in names):
            raise ValueError(
                f"locked: {', '.join(names)} prescribe more than the mechanism's {freedom} free "
                f"movement(s)"
            )
        raise ValueError(
            f"redundant loop: {', '.join(names)} repeat each other's constraints "
            "(or the start is a singular position; start elsewhere)"
        )

    def report_singular(self, q: np.ndarray, names: list[str]) -> None:
        """A drive must not begin where the loops give way to it in no sense or in either, as a
        slide at a stretched crank. Nearby, rounding of the position decides on the rates.

        names: of equations that nearly repeat each other at q.
        """
        if all(n.startswith("joint") for n in names):
            return
        turns = self.geometry.angles
        moved = q.copy()
        usual = 0.0
        for far in np.random.default_rng(1).uniform(-1.0, 1.0, (AROUND, len(turns))):
            moved[turns] = q[turns] + far
            values = np.linalg.svd(self._scaled(moved)[1], compute_uv=False)
            usual = max(usual, values[-1] / values[0])
        names, _ = self._dependent(q, SINGULAR * usual)
        if drives := [n for n in names if not n.startswith("joint")]:
            others = ", ".join(n for n in names if n not in drives)
            raise ValueError(
                f"singular position: {', '.join(drives)} cannot begin where {others} are "
                "stretched or folded (within rounding); start elsewhere"
            )

    def _dependent(self, q: np.ndarray, share: float = RANK) -> tuple[list[str], int]:
        """Labels of equations that repeat each other at q, and how many movements the joints alone
        leave. share: of the largest singular value, below which one counts as zero.
        """
        labels, scaled = self._scaled(q)
        if not scaled.size:
            return [], scaled.shape[1]
        values = np.linalg.svd(scaled, compute_uv=False)
        rank = int((values > share * values[0]).sum())
        if rank == len(labels):
            return [], scaled.shape[1] - rank
        vectors = np.linalg.svd(scaled)[0]
        guilty = np.abs(vectors[:, rank:]).max(axis=1) > GUILTY
        names = list(dict.fromkeys(n for n, g in zip(labels, guilty, strict=True) if g))
        joints = [n for n in labels if n.startswith("joint")]
        alone = scaled[: len(joints)]
        freedom = scaled.shape[1] - int(
            (np.linalg.svd(alone, compute_uv=False) > RANK * values[0]).sum()
        )
        return names, freedom

    def _scaled(self, q: np.ndarray) -> tuple[list[str], np.ndarray]:
        """Labels of all equations at q, and their Jacobian without units."""
        labels, _, matrix = self.equations(q, starting=False)
        scaled = matrix.copy()
        scaled[:, self.geometry.angles] /= self.size
        moves = np.delete(scaled, self.geometry.angles, axis=1).any(axis=1)
        for i, label in enumerate(labels):
            if not (label.startswith("joint") and moves[i]):
                scaled[i] *= self.size
        return labels, scaled

    # --- velocities
    def _moving(self) -> list[_Row]:
        """Equations that decide on rates before those given with bodies do."""
        return self._rows([d for d in self.drives if d.prescribes or d.speed_start is not None])

    def _given_rates(self) -> dict[int, float]:
        """Rates that bodies have of their own, by their places in q."""
        rates = {b: (*(b.velocity or (None, None)), b.angular_velocity) for b in self.pose}
        places = (
            (span.start + i, v) for b, span in self.pose.items() for i, v in enumerate(rates[b])
        )
        return {i: v for i, v in places if v is not None}

    def requested(self) -> list[float]:
        """Rates that the start requires: of states and drives, then those given with bodies."""
        rates = [row.rate for row in self._moving() if row.rate is not None]
        return rates + list(self._given_rates().values())

    def rates(self, slopes: np.ndarray) -> np.ndarray:
        """Rates of q for each of the requested ones alone: of joints and drives, then nearest to
        those given with bodies, then nearest to rest.

        Each only decides what those before it leave free. A body without a given rate rests
        relative to the one that carries it. Rates of angles count times the size, which matters
        where given ones contradict each other.
        """
        rows = self._moving()
        indices = list(self._given_rates())
        size = self._lengths()
        count = len(rows) + len(indices)
        requested = [i for i in range(count) if i >= len(rows) or rows[i].rate is not None]
        wanted = np.eye(count)[:, requested]
        closed = slopes[[self.geometry.index[row.coordinate] for row in rows]], wanted[: len(rows)]
        stages = closed, (np.diag(size)[indices], size[indices, None] * wanted[len(rows) :])
        rate = np.zeros((size.size, len(requested)))
        free = np.diag(1.0 / size)
        for matrix, right in chain(stages, self._resting(slopes)):
            if not free.shape[1]:
                break
            if len(matrix):
                least = SMALLEST * math.sqrt(np.square(matrix / size).sum())
                missing = right - product(matrix, rate)
                shortest, ways = solutions(product(matrix, free), missing, least)
                rate += product(free, shortest)
                free = product(free, ways)
        return rate

    def _resting(self, slopes: np.ndarray) -> Iterator[tuple[np.ndarray, float]]:
        """Each free coordinate is to rest, those next to the ground first: an angle relative to the
        carrying body.
        """
        groups = closed_plan(self.scene, tuple(self.measured)).groups
        for attachment in (a for group in groups for a in group.attachments):
            for c in (c for c in attachment.coordinates if c.source == "free"):
                turning = c.turns and attachment.joint is not None
                coordinate = (attachment.joint, TURN) if turning else c.address
                yield slopes[[self.geometry.index[coordinate]]], 0.0


def _turned(angle: float, x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def rate_at(drive: Element, time: float = 0.0) -> float:
    """Rate of a driven coordinate at a time [s]: the speed given, or the motion's first
    derivative.
    """
    if drive.motion is None:
        return (drive.speed if drive.prescribes else drive.speed_start) or 0.0
    slope = evaluated(traced(drive.motion.law.function).slopes((0,)))
    return slope(time, *drive.motion.numbers)[1]


def _points(scene: Scene) -> list[Point]:
    """The points of all elements."""
    ends = (getattr(e, end, None) for e in scene.elements for end in ("a", "b"))
    return [p for p in ends if hasattr(p, "x")]


def size_of(scene: Scene) -> float:
    """A length of the mechanism, which does not depend on the world's origin; of a scene of columns
    a column.

    Of bodies it is the farthest point from the centre of mass, of the ground that from the point in
    its middle. Where these are zero, it is the largest radius of gyration.
    """
    points = _points(scene)
    reach = [
        each(math.hypot, p.x - p.body.com[0], p.y - p.body.com[1])
        for p in points
        if p.body is not ground
    ]
    fixed = [p for p in points if p.body is ground]
    apart = ([each(math.hypot, p.x - q.x, p.y - q.y) for q in fixed] for p in fixed)
    reach += [chosen(min, [chosen(max, ways) for ways in apart])]
    reach += [spot.reach for _, spot in scene.spots]
    ratios = (b.inertia / b.mass for b in scene.bodies if b.inertia and b.mass)
    return chosen(max, reach) or chosen(max, [each(math.sqrt, r) for r in ratios], 1.0)


def _farthest(scene: Scene) -> float:
    """The farthest given place from the world's origin: places are rounded by it."""
    fixed = [(p.x, p.y) for p in _points(scene) if p.body is ground]
    placed = [b.position for b in scene.bodies if b.position is not None]
    return max((math.hypot(*pair) for pair in fixed + placed), default=0.0)
