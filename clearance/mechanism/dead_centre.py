"""Dead centres: where the equations of a loop are singular, along a motion that has gone wrong;
other coordinates for it.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from clearance.elements.body import ground
from clearance.elements.joint import RELATIVE, TURN
from clearance.mechanism.build import Mechanism, place_named
from clearance.mechanism.kinematics import ZERO, Kinematics, Pose, Propagation, Rates
from clearance.mechanism.loops import wrong_turn
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.topology import Group, soft_joints
from clearance.tracing.trace import Trace
from clearance.values.algebra import each

DEAD = 1e-2  # closing determinant at a dead centre, over the largest of the motion
STEEP = 4.0  # a determinant may reach zero within this many of its changes between two steps
POINTS = 33  # places between two steps that are looked at together
ZOOMS = 6
RATES = {"x": "vx", "y": "vy", "angle": "omega"}


@dataclass(frozen=True)
class Outputs:
    """Rows of outputs of a mechanism, (rows, channels), and what they show of its coordinates."""

    mechanism: Mechanism
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
        closed = [axis for joint in group.closures for axis in RELATIVE if axis not in joint.free]
        lengths = [size if axis == TURN else 1.0 for axis in closed]
        cells = np.zeros((len(self.rows), len(matrix), len(matrix)))
        for i, row in enumerate(matrix):
            for j, value in enumerate(row):
                cells[:, i, j] = lengths[i] * value
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.linalg.det(cells) / np.linalg.norm(cells, axis=1).prod(axis=1)

    def sizes(self, group: Group) -> np.ndarray:
        """Sizes of a group's determinant, endless where there is no position."""
        sizes = np.abs(self.determinants(group))
        return np.where(np.isfinite(sizes), sizes, np.inf)

    # --- coordinates
    def coordinate(self, key: tuple) -> tuple[np.ndarray, np.ndarray]:
        """A coordinate and its rate: of a body, or a relative one of a joint."""
        part, axis = key
        if axis in RATES:
            name = "theta" if axis == "angle" else axis
            return self.column(f"{part.key}/{name}"), self.column(f"{part.key}/{RATES[axis]}")
        jet = Rates(self.kinematics, real=self.velocities).measured(part, {})[axis]
        return (self.kinematics.turn(part) if axis == TURN else jet.v), jet.d

    def offset(self, key: tuple) -> tuple[np.ndarray, np.ndarray]:
        """A relative coordinate that is a state of its joint, less the joint's number, and its
        rate.
        """
        joint, axis = key
        value, rate = self.coordinate(key)
        if axis == TURN:
            return each(math.atan2, *wrong_turn(self.kinematics, joint)), rate
        return value - self.kinematics.held(joint, axis)[0], rate

    @cached_property
    def states(self) -> np.ndarray:
        """Independent coordinates, then their rates, (rows, states)."""
        columns = [self.coordinate(c.address) for c in self.mechanism.plan.free]
        soft = [(j, axis) for j in self.mechanism.eccentric for axis, _ in j.soft_coordinates]
        columns += map(self.offset, soft)
        values = [value for value, _ in columns] + [rate for _, rate in columns]
        return np.array(values).T.reshape(len(self.rows), len(values))

    @cached_property
    def carried(self) -> np.ndarray:
        """Coordinates that steps carry on, (rows, carried)."""
        carried = self.mechanism.layout.carried
        values = [self.coordinate(place_named(self.mechanism.scene, *pair))[0] for pair in carried]
        return np.array(values).T.reshape(len(self.rows), len(carried))


@dataclass(frozen=True)
class Motion:
    """States of a mechanism at the ends of some steps. numbers: states with the ledger, then what
    steps carry on, (times, numbers); work: of the last step.
    """

    mechanism: Mechanism
    work: np.ndarray
    times: np.ndarray
    numbers: np.ndarray

    @cached_property
    def outputs(self) -> Outputs:
        """Their outputs."""
        mechanism, size = self.mechanism, self.mechanism.y0.size
        rows = np.empty((len(self.times), len(mechanism.layout.channels)))
        work = self.work.copy()
        for time, numbers, row in zip(self.times, self.numbers, rows, strict=True):
            work[mechanism.layout.carried_places] = numbers[size:]
            row[:] = mechanism.outputs(time, numbers[:size], work)
        return Outputs(mechanism, rows)

    def between(self, times: np.ndarray) -> "Motion":
        """Other times: coordinates by cubic interpolation, all else by straight lines."""
        i = np.clip(np.searchsorted(self.times, times) - 1, 0, max(len(self.times) - 2, 0))
        h = (self.times[1:] - self.times[:-1])[i]
        s = ((times - self.times[i]) / h)[:, None]
        first = self.numbers[i]
        second = self.numbers[i + 1]
        p = self.mechanism.layout.size
        numbers = (1.0 - s) * first + s * second
        rates = self.mechanism.layout.rates
        bend = s * (1.0 - s)
        slope = (second[:, :p] - first[:, :p]) / h[:, None]
        pull = (1.0 - s) * (first[:, rates] - slope) - s * (second[:, rates] - slope)
        numbers[:, :p] += bend * h[:, None] * pull
        return Motion(self.mechanism, self.work, times, numbers)

    def lowest(self, group: Group, first: float, last: float) -> float:
        """Size of a group's smallest determinant from the first to the last time."""
        size = np.inf
        for _ in range(ZOOMS):
            times = np.linspace(first, last, POINTS)
            sizes = self.between(times).outputs.sizes(group)
            best = int(sizes.argmin())
            size = min(size, float(sizes[best]))
            first = times[max(best - 1, 0)]
            last = times[min(best + 1, POINTS - 1)]
        return size


@dataclass(frozen=True)
class DeadCentre:
    """A loop that came to its dead centre, in words, and its joints that only forces hold. With one
    of them measured, the loop is open and has no dead centre.
    """

    text: str
    soft_joints: tuple[str, ...]


def dead_centre(motion: Motion) -> DeadCentre | None:
    """The first loop that comes to a dead centre along a motion; None where none does."""
    mechanism = motion.mechanism
    row = mechanism.outputs(0.0, mechanism.y0, np.append(mechanism.work0, 0.0))
    start = Outputs(mechanism, row[None])
    for group in (g for g in mechanism.plan.groups if g.closures):
        begun = float(start.sizes(group)[0])
        sizes = motion.outputs.sizes(group)
        enough = DEAD * max([begun, *sizes[np.isfinite(sizes)]])
        size = next((s for s in _lows(motion, group, sizes) if s < enough), None)
        if size is not None:
            text = (
                f"loop {group.label()} came to its dead centre, where two branches meet: "
                f"its closing determinant fell to {size:.1g} of its scale ({begun:.2g} at the "
                f"start)"
            )
            return DeadCentre(text, soft_joints(mechanism.plan, group))
    return None


def _lows(motion: Motion, group: Group, sizes: np.ndarray) -> Iterator[float]:
    """Small sizes of a group's determinant: where it may go to zero, then at the times."""
    values, last = sizes.tolist(), len(sizes) - 1
    for i, size in enumerate(values):
        before, after = max(i - 1, 0), min(i + 1, last)
        change = max(abs(values[before] - size), abs(values[after] - size))
        if size <= min(values[before], values[after]) and size < STEEP * change < np.inf:
            yield motion.lowest(group, motion.times[before], motion.times[after])
    yield min(values)


def transferred(
    before: Mechanism, y: np.ndarray, row: np.ndarray, after: Mechanism
) -> tuple[tuple[float, ...], ...]:
    """A state of one mechanism, of which `row` is the outputs, in the coordinates of another of the
    same scene. Its states without the ledger, what steps carry on, and angles of `Layout.wrapped`.
    """
    index = before.layout.output
    paths = [c.path for c in after.layout.channels]
    outputs = Outputs(after, np.array([[row[index[p]] if p in index else np.nan for p in paths]]))
    states = after.y0[: after.size].copy()
    places = before.layout.state
    states[: after.layout.rates.stop] = outputs.states[0]
    for name in after.layout.first_order:
        states[after.layout.state[name]] = y[places[name]]
    angles = (outputs.column(path)[0] for path in after.layout.wrapped)
    return tuple(states.tolist()), tuple(outputs.carried[0].tolist()), tuple(map(float, angles))
