"""The load path of a turn, replayed with the wear of many turns: outlines, steps and their errors.

The equations are those of replay.py.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from clearance.laws.law import FilmJoint
from clearance.laws.outline import LINE, NODES, STEP
from clearance.laws.worn_asperity import Rough
from clearance.machine.store import compiled
from clearance.wearing.replay import forces, pressure_at, replay

LIGHT = 1e-6  # of the strength of asperities: pressures whose journal swims in its film
MANY = 100  # steps of a jump
SMOOTH = 9  # nodes that depths are averaged over before they are compared
FEW = 1e-3  # of the depth of a jump: a step that adds less may miss as if it added this


def moved(
    x: float,
    y: float,
    angle: float,
    clearance: float,
    old: np.ndarray,
    new: np.ndarray,
    solids: Rough | None = None,
) -> tuple[float, float]:
    """Place in a new outline with the force that the old one has at (x, y); the same place in free
    flight. It is that of a replay without wear.

    solids: where asperities carry too.
    """
    rough = solids is not None
    joint = FilmJoint(0.0, clearance, 0.0, 0.0, solids.roughness if rough else 0.0)
    force_x, force_y, load, *_ = forces((x, y, angle), joint, old, solids, 0.0)
    if load <= (LIGHT * solids.strength if rough else 0.0):
        return x, y
    path, journal = np.array([[force_x, force_y, angle, 0.0, 0.0, clearance]]), np.array([[x, y]])
    surface, room = 1.0 / STEP if rough else 1.0, np.zeros(2 * NODES)
    done = _replay()(path, 0.0, (new, journal, np.zeros(2)), 1.0, solids, surface, room)
    return (float(journal[0, 0]), float(journal[0, 1])) if done else (x, y)


def surfaces(data: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depths of bearing and journal in the numbers of outlines [m]."""
    return data[2 : 2 + NODES], data[2 + LINE : 2 + LINE + NODES]


def smoothed(depths: np.ndarray) -> np.ndarray:
    """Mean over SMOOTH neighbouring nodes."""
    return sum(np.roll(depths, k) for k in range(-(SMOOTH // 2), SMOOTH // 2 + 1)) / SMOOTH


def untold(change: np.ndarray, turns: float, before: tuple[np.ndarray, float] | None) -> float:
    """The largest of what many turns have changed [m] that the change before has not foretold.

    change: such as a first-order error, which grows with the square of the turns: (..., NODES).
    before: the one before, and its turns. It does not count where it foretells nothing.
    """
    largest = float(np.abs(change).max())
    if before is None:
        return largest
    return min(largest, float(np.abs(change - (turns / before[1]) ** 2 * before[0]).max()))


def middle(first: "Worn", second: "Worn") -> "Worn":
    """Mean of two outlines."""
    mean = first.copy()
    mean.data[1:] = 0.5 * (first.data[1:] + second.data[1:])
    return mean


@cache
def _replay():
    """`replay`, compiled."""
    return compiled(replay)


@dataclass
class Worn:
    """Outlines as the replay wears them: their numbers (see `laws.outline.Outline`), places of
    rest, volumes [m3].
    """

    data: np.ndarray
    position: np.ndarray
    volumes: np.ndarray

    @classmethod
    def of(cls, numbers: np.ndarray, path: np.ndarray, wears_journal: bool) -> "Worn":
        """Outlines as they are; the journal rests against its force."""
        data = numbers.copy()
        data[0] = max(data[0], float(wears_journal))
        away = path[:, :2] / np.hypot(path[:, 0], path[:, 1])[:, None]
        return cls(data, -path[:, 5, None] * away, np.zeros(2))

    def copy(self) -> "Worn":
        """Another of the same."""
        return Worn(self.data.copy(), self.position.copy(), self.volumes.copy())

    @property
    def bearing(self) -> np.ndarray:
        """Depths of the bearing [m]."""
        return surfaces(self.data)[0]

    @property
    def journal(self) -> np.ndarray:
        """Depths of the journal [m]."""
        return surfaces(self.data)[1]


class LoadPath:
    """The load path of a turn in one joint, to be replayed.

    path: rows of `wear_sum.PATH` of one turn; stiffness: K_w [Pa/m]; surface: R L [m2]; solids:
        where asperities carry too.
    """

    def __init__(
        self, path: np.ndarray, stiffness: float, surface: float, solids: Rough | None = None
    ):
        self.path, self.stiffness, self.surface = np.ascontiguousarray(path), stiffness, surface
        self.pressure, self.solids = np.zeros(2 * NODES), solids

    @property
    def stiff(self) -> float:
        """Wear of a turn over what the solids yield, K sum(w): explicit jumps end at 2 over it.

        K is that of the foundation, and of the asperities at the gap 0.
        """
        stiffness = self.stiffness
        if self.solids is not None:
            stiffness = pressure_at(1e-30, 0.0, self.solids)[1]
        return stiffness * float(self.path[:, 3:5].sum())

    def step(self, worn: Worn, turns: float) -> Worn:
        """Outlines after so many turns at once.

        Raises RuntimeError where no place of rest exists.
        """
        new = worn.copy()
        arrays = new.data, new.position, new.volumes
        solids = self.stiffness, self.solids, self.surface
        if not _replay()(self.path, float(turns), arrays, *solids, self.pressure):
            raise RuntimeError(f"no place of rest was found when {turns:g} turns were replayed")
        return new

    def both(self, worn: Worn, turns: float) -> tuple[Worn, float]:
        """Outlines after so many turns, first-order error taken off, and that error [m].

        The error is that of a mean over neighbouring nodes: a hard layer touches at one of them,
        and parts of a path leave ridges in between.
        """
        full, half = self.step(worn, turns), self.step(self.step(worn, 0.5 * turns), 0.5 * turns)
        change = half.data - full.data
        error = max(float(np.abs(smoothed(c)).max()) for c in surfaces(change))
        half.data[1:] = np.maximum(half.data[1:] + change[1:], worn.data[1:])
        half.volumes += half.volumes - full.volumes
        return half, error

    def over(
        self, worn: Worn, turns: float, tolerance: float, most: float = math.inf, aim: float = 0.0
    ) -> tuple[Worn, float, float]:
        """Outlines after `turns` turns, or where a depth has grown by `most` [m]: outlines, turns,
        error [m].

        A step's error is at most `tolerance` of the largest depth that it adds. A FEW of the depth
        so far, or of `aim`, the depth of a complete jump [m], stands for a smaller one. Where a
        journal leaves one place of rest for another, a step of any length is uncertain by that.
        MANY steps, taken or not, therefore double the tolerance of those to come.
        """
        done, error, grown, begin = 0.0, 0.0, 0.0, worn.data.copy()
        steps = 0
        size = min(turns, max(1.0, 0.2 / max(self.stiff, 1e-300)))
        while done < turns:
            size = min(size, turns - done)
            new, off = self.both(worn, size)
            added = max(float(smoothed(d).max()) for d in surfaces(new.data - worn.data))
            allowed = 2.0 ** (steps // MANY) * tolerance * max(added, FEW * max(grown, aim))
            steps += 1
            if off > allowed and size > 1e-3:
                size *= max(0.2, 0.8 * allowed / off)
                continue
            worn, done, error = new, done + size, error + off
            grown = max(float(d.max()) for d in surfaces(worn.data - begin))
            if grown >= most:
                break
            rest = max(1.0, size * (most - grown) / max(added, 1e-300))
            size = min(size * min(2.0, 0.8 * allowed / max(off, 1e-300)), rest)
        return worn, done, error
