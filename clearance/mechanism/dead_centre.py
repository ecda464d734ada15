"""Dead centres: where the equations of a loop are singular, along a motion that has gone wrong."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from clearance.body import ground
from clearance.elements.joint import RELATIVE, TURN
from clearance.mechanism.build import Mechanism, place_named
from clearance.mechanism.kinematics import Kinematics, Pose, Propagation
from clearance.mechanism.loops import wrong_turn
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.rates import ZERO, Rates
from clearance.mechanism.topology import Group
from clearance.tracing.trace import Trace

DEAD = 1e-2  # closing determinant at a dead centre, over the largest of the motion
STEEP = 4.0  # a determinant may reach zero within this many of its changes between two outputs
FAR = 1.0  # way of a coordinate between two outputs, of its natural size, that is too long
POINTS = 33  # places between two outputs that are looked at together
ZOOMS = 6
RATES = {"x": "vx", "y": "vy", "angle": "omega"}


@dataclass(frozen=True)
class SampledMotion:
    """Outputs of a mechanism at a few times, (times, channels), with its states between them.

    work: what an accepted step left for the next.
    """

    mechanism: Mechanism
    work: np.ndarray
    times: np.ndarray
    rows: np.ndarray

    def column(self, path: str) -> np.ndarray:
        return self.rows[:, self.mechanism.layout.output[path]]

    @cached_property
    def kinematics(self) -> Kinematics:
        """Poses of all bodies, each number an array over the times."""
        numbers = Numbers(self.mechanism.scene).constants
        index = self.mechanism.layout.parameters
        numbers |= {name: self.mechanism.par[i] for name, i in index.items()}
        k = Kinematics(Trace(), numbers.__getitem__, {}, {})
        for body in self.mechanism.scene.bodies:
            x, y, angle = (self.column(f"bodies/{body.name}/{n}") for n in ("x", "y", "theta"))
            k.poses[body] = Pose(x, y, np.cos(angle), np.sin(angle), angle)
        return k

    @cached_property
    def velocities(self) -> dict:
        """Planar twists of all bodies."""
        twists = {
            body: tuple(self.column(f"bodies/{body.name}/{n}") for n in RATES.values())
            for body in self.mechanism.scene.bodies
        }
        return twists | {ground: ZERO}

    def determinants(self, group: Group) -> np.ndarray:
        """Closing determinant of a group over its scale, the product of the lengths of its columns.

        Of a dyad it is the sine of the angle between its links.
        """
        number = self.mechanism.plan.groups.index(group)
        matrix = Propagation(self.kinematics, self.mechanism.plan).matrix(number, group)
        size = self.mechanism.start.size  # makes an equation of angles one of lengths
        closed = [what for joint in group.closures for what in RELATIVE if what not in joint.free]
        lengths = [size if what == TURN else 1.0 for what in closed]
        cells = np.zeros((len(self.times), len(matrix), len(matrix)))
        for i, row in enumerate(matrix):
            for j, value in enumerate(row):
                cells[:, i, j] = lengths[i] * value
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.linalg.det(cells) / np.linalg.norm(cells, axis=1).prod(axis=1)

    # --- between the times
    def coordinate(self, place: tuple) -> tuple[np.ndarray, np.ndarray]:
        """A coordinate and its rate: of a body, or a relative one of a joint."""
        part, what = place
        if what in RATES:
            name = "theta" if what == "angle" else what
            return self.column(f"{part.key}/{name}"), self.column(f"{part.key}/{RATES[what]}")
        jet = Rates(self.kinematics, real=self.velocities).measured(part, {})[what]
        return (self.kinematics.turn(part) if what == TURN else jet.v), jet.d

    def offset(self, place: tuple) -> tuple[np.ndarray, np.ndarray]:
        """A relative coordinate that is a state of its joint, less the joint's number, and its
        rate.
        """
        joint, what = place
        value, rate = self.coordinate(place)
        if what == TURN:
            return np.arctan2(*wrong_turn(self.kinematics, joint)), rate
        return value - self.kinematics.given(joint, what)[0], rate

    @cached_property
    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """Independent coordinates and their rates, (times, coordinates)."""
        joints = self.mechanism.eccentric
        columns = [self.coordinate(c.place) for c in self.mechanism.plan.free]
        columns += [self.offset((j, what)) for j in joints for what, _ in j.soft_coordinates]
        shape = (len(self.times), len(columns))
        values, rates = zip(*columns, strict=True) if columns else ((), ())
        return tuple(np.array(column).T.reshape(shape) for column in (values, rates))

    @cached_property
    def carried(self) -> np.ndarray:
        """Coordinates that steps carry on, (times, carried)."""
        carried = self.mechanism.layout.carried
        values = [self.coordinate(place_named(self.mechanism.scene, *one))[0] for one in carried]
        return np.array(values).T.reshape(len(self.times), len(carried))

    def between(self, times: np.ndarray) -> "SampledMotion":
        """Outputs at other times, from cubic interpolation of the states."""
        rows = np.empty((len(times), self.rows.shape[1]))
        y, work = self.mechanism.y0.copy(), self.work.copy()
        values, rates = self.states
        size = values.shape[1]
        for time, row in zip(times, rows, strict=True):
            i = int(np.clip(np.searchsorted(self.times, time) - 1, 0, len(self.times) - 2))
            h = self.times[i + 1] - self.times[i]
            s = (time - self.times[i]) / h
            y[:size] = (1.0 - s) ** 2 * ((1.0 + 2.0 * s) * values[i] + s * h * rates[i])
            y[:size] += s**2 * ((3.0 - 2.0 * s) * values[i + 1] + (s - 1.0) * h * rates[i + 1])
            carried = (1.0 - s) * self.carried[i] + s * self.carried[i + 1]
            work[self.mechanism.layout.carried_places] = carried
            row[:] = self.mechanism.outputs(time, y, work)
        return SampledMotion(self.mechanism, self.work, times, rows)

    @cached_property
    def dense(self) -> np.ndarray:
        """True for each piece between two times in which no coordinate moves far.

        The states are right there.
        """
        count = len(self.mechanism.plan.free)
        rates = np.abs(self.states[1][:, :count]) / self.mechanism.scale[:count]
        moved = np.maximum(rates[1:], rates[:-1]) * np.diff(self.times)[:, None]
        return (moved < FAR).all(axis=1)

    def lowest(self, group: Group, first: float, last: float) -> float:
        """Size of a group's smallest determinant from the first to the last time."""
        size = np.inf
        for _ in range(ZOOMS):
            times = np.linspace(first, last, POINTS)
            sizes = _sizes(self.between(times), group)
            best = int(sizes.argmin())
            size = min(size, float(sizes[best]))
            first, last = times[max(best - 1, 0)], times[min(best + 1, POINTS - 1)]
        return size


@dataclass(frozen=True)
class DeadCentre:
    """A loop that came to its dead centre, and that in words."""

    group: Group
    text: str

    @property
    def soft_joints(self) -> tuple[str, ...]:
        """Names of its joints with clearance: one of them measured, the loop is open and has no
        dead centre.
        """
        joints = (*self.group.closures, *(a.joint for a in self.group.attachments))
        return tuple(j.name for j in joints if j is not None and j.soft)


def dead_centre(motion: SampledMotion) -> DeadCentre | None:
    """The first loop that comes to a dead centre along a motion; None where none does."""
    mechanism = motion.mechanism
    row = mechanism.outputs(0.0, mechanism.y0, np.append(mechanism.work0, 0.0))
    start = SampledMotion(mechanism, motion.work, np.zeros(1), row[None])
    for group in (g for g in mechanism.plan.groups if g.closures):
        begun, sizes = float(_sizes(start, group)[0]), _sizes(motion, group)
        enough = DEAD * max([begun, *sizes[np.isfinite(sizes)]])
        size = next((s for s in _lows(motion, group, sizes) if s < enough), None)
        if size is not None:
            text = (
                f"loop {group.label()} came to its dead centre, where two branches meet: "
                f"its closing determinant fell to {size:.1g} of its scale ({begun:.2g} at the "
                f"start)"
            )
            return DeadCentre(group, text)
    return None


def _lows(motion: SampledMotion, group: Group, sizes: np.ndarray) -> Iterator[float]:
    """Small sizes of a group's determinant: where it may go to zero, then at the times."""
    for i, size in enumerate(sizes):
        before = i - 1 if i > 0 and motion.dense[i - 1] else i
        after = i + 1 if i + 1 < len(sizes) and motion.dense[i] else i
        change = max(abs(sizes[before] - size), abs(sizes[after] - size))
        if size <= min(sizes[before], sizes[after]) and size < STEEP * change < np.inf:
            yield motion.lowest(group, motion.times[before], motion.times[after])
    yield float(sizes.min())


def _sizes(motion: SampledMotion, group: Group) -> np.ndarray:
    """Sizes of a group's determinant along a motion, endless where there is no position."""
    sizes = np.abs(motion.determinants(group))
    return np.where(np.isfinite(sizes), sizes, np.inf)
