"""Goes on with the wear of a joint over many turns by replaying the load path of one.

A load path is the record of one turn of a run: force on the journal, its angle, and depth over
pressure w for each part. At each part the journal rests where the foundation carries the force, in
two unknowns, and both surfaces wear. m turns at once multiply w by m, and the step is implicit. A
foundation that wears by w m p under a pressure p acts like a softer one,

    p = K_w / (1 + K_w m (w_B + w_J)) g

so that no number of turns is unstable, where explicit jumps are beyond 2 / (K_w w) turns. A step is
made at once and in two halves; the difference is its error, and is taken off once (first order).
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from clearance.laws.law import FilmJoint
from clearance.laws.outline import (
    LINE,
    NODES,
    STEP,
    arc,
    cubic,
    deepest,
    overlap,
    places,
    touching,
    touching_slopes,
    turned,
)
from clearance.store import compiled

NEWTON = 60  # steps of the search for a place of rest, at most
AT_REST = 1e-9  # of the force: what is left of it there
STRIDE = 0.2  # of the clearance: longest step of the search
PRESSED = 1e-4  # of the clearance: how deep a journal in free flight is pressed in first
LIGHT = 1e-6  # of the strength of asperities: pressures whose journal swims in its film
FEW = 1e-3  # of the depth of a jump: a step that adds less may miss as if it added this
ENOUGH = 0.7  # of the slope at the start of a step that may stand at its end, behind the rest


def rest(force_x, force_y, angle, joint, data, scale, x, y):
    """Place where the foundation, `scale` stiff, puts a force on the journal, from (x, y): x, y and
    normal load.

    Newton's method on a convex energy, steps that overshoot are halved. A journal in free flight is
    pressed in, ever deeper: the deepest point may lie on a ridge that no cell sees. The load is nan
    where it fails.
    """
    size = math.sqrt(force_x * force_x + force_y * force_y)
    pressed = PRESSED * joint.clearance
    f = touching_slopes(x, y, angle, joint, data, 0.0)
    for _ in range(NEWTON):
        if f[2] <= 0.0:
            way = pressed - deepest(x, y, angle, joint, data, 0.0)[0]
            x, y, pressed = x - way * force_x / size, y - way * force_y / size, 2.0 * pressed
            f = touching_slopes(x, y, angle, joint, data, 0.0)
            continue
        rx, ry = f[0] - force_x / scale, f[1] - force_y / scale
        if math.sqrt(rx * rx + ry * ry) * scale <= AT_REST * size:
            return x, y, scale * f[2]
        a, b, d = -f[4], -f[5], -f[8]
        a, d = a + 1e-9 * (a + d), d + 1e-9 * (a + d)
        dx, dy = (d * rx - b * ry) / (a * d - b * b), (a * ry - b * rx) / (a * d - b * b)
        long = math.sqrt(dx * dx + dy * dy) / (STRIDE * joint.clearance)
        if long > 1.0:
            dx, dy = dx / long, dy / long
        slope = rx * dx + ry * dy
        for _ in range(30):
            f = touching_slopes(x + dx, y + dy, angle, joint, data, 0.0)
            if (force_x / scale - f[0]) * dx + (force_y / scale - f[1]) * dy <= ENOUGH * slope:
                break
            dx, dy, slope = 0.5 * dx, 0.5 * dy, 0.5 * slope
        x, y = x + dx, y + dy
    return x, y, math.nan


def put(data, line, node, depth):
    """Add to a depth in each of its places, see `laws.outline.Outline`."""
    data[line + 1 + node] += depth
    data[line + 1 + node + NODES] = data[line + 1 + node]
    if node == NODES - 1:
        data[line] = data[line + 1 + node]
    if node + 2 * NODES + 1 < LINE:
        data[line + 1 + node + 2 * NODES] = data[line + 1 + node]


def wear_off(x, y, angle, joint, data, stiffness, over, load, area, pressure):
    """Wear both surfaces at a place: depths over pressure `over` (bearing, journal), scaled to the
    normal load.
    """
    first, cells = arc(x, y, joint.clearance)
    before, behind = turned(angle)
    bearing, journal = places(data, 0, first, before)
    weights = cubic(behind)
    total = 0.0
    for k in range(2 * cells):
        g = overlap(x, y, joint.clearance, data, bearing, journal, first + k, weights)
        pressure[k] = max(stiffness * g, 0.0)
        total += pressure[k]
    share = load / (area * total) if total > 0.0 else 0.0
    for k in range(2 * cells):
        p, node = share * pressure[k], (first + k) % NODES
        if p > 0.0:
            if over[0] > 0.0:
                put(data, 1, node, over[0] * p)
            if over[1] > 0.0:
                other = (node + before) % NODES
                put(data, 1 + LINE, other, (1.0 - behind) * over[1] * p)
                put(data, 1 + LINE, (other + 1) % NODES, behind * over[1] * p)


def replay(path, turns, data, stiffness, surface, place, pressure, volumes):
    """Replay a load path with `turns` times its wear; data and places of rest go on in place.

    False where it fails.

    path: rows of `summing.PATH`; surface: R L [m2]; place: (x, y) of each row; volumes: worn off
        both, added to.
    """
    for q in range(path.shape[0]):
        over = (turns * path[q, 3], turns * path[q, 4])
        soft = stiffness / (1.0 + stiffness * (over[0] + over[1]))
        joint = FilmJoint(0.0, path[q, 5], 0.0, 0.0, 0.0)
        force_x, force_y, angle = path[q, 0], path[q, 1], path[q, 2]
        x, y, load = rest(
            force_x, force_y, angle, joint, data, soft * surface, place[q, 0], place[q, 1]
        )
        if not math.isfinite(load):
            return False
        place[q, 0], place[q, 1] = x, y
        wear_off(x, y, angle, joint, data, soft, over, load, surface * STEP, pressure)
        volumes[0] += over[0] * load
        volumes[1] += over[1] * load
    return True


def moved(
    x: float,
    y: float,
    angle: float,
    clearance: float,
    old: np.ndarray,
    new: np.ndarray,
    solids=None,
) -> tuple[float, float]:
    """Place in a new outline with the force that the old one has at (x, y); the same place in free
    flight.

    solids: a `laws.worn_asperity.Rough` where asperities carry too.
    """
    joint = FilmJoint(0.0, clearance, 0.0, 0.0, 0.0 if solids is None else solids.roughness)
    if solids is not None:
        from clearance.wearing.rough import carried, rest_rough

        force_x, force_y, load, *_ = carried(x, y, angle, joint, old, 0.0, solids)
        if load <= LIGHT * solids.strength:
            return x, y
        place = rest_rough(force_x, force_y, angle, joint, new, 1.0, 0.0, solids, x, y)
        return place[:2] if math.isfinite(place[2]) else (x, y)
    force_x, force_y, load, _ = touching(x, y, angle, joint, old, 0.0)
    if load <= 0.0:
        return x, y
    rest_x, rest_y, load = rest(force_x, force_y, angle, joint, new, 1.0, x, y)
    return (rest_x, rest_y) if math.isfinite(load) else (x, y)


@cache
def _compiled(rough: bool):
    """`replay`, or that of rough surfaces."""
    if not rough:
        return compiled(replay)
    from clearance.wearing.rough import replay_rough

    return compiled(replay_rough)


@dataclass
class Worn:
    """Outlines as the replay wears them: their numbers (see `laws.outline.Outline`), places of
    rest, volumes [m3].
    """

    data: np.ndarray
    place: np.ndarray
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
        return Worn(self.data.copy(), self.place.copy(), self.volumes.copy())

    @property
    def bearing(self) -> np.ndarray:
        """Depths of the bearing [m]."""
        return self.data[2 : 2 + NODES]

    @property
    def journal(self) -> np.ndarray:
        """Depths of the journal [m]."""
        return self.data[2 + LINE : 2 + LINE + NODES]


class Replay:
    """The load path of a turn in one joint, to be replayed.

    path: rows of `summing.PATH` of one turn; stiffness: K_w [Pa/m]; surface: R L [m2]; solids: a
        `laws.worn_asperity.Rough` where asperities carry too.
    """

    def __init__(self, path: np.ndarray, stiffness: float, surface: float, solids=None):
        self.path, self.stiffness, self.surface = np.ascontiguousarray(path), stiffness, surface
        self.pressure, self.solids = np.zeros(2 * NODES), solids
        self._replay = _compiled(solids is not None)

    @property
    def stiff(self) -> float:
        """Wear of a turn over what the solids yield, K sum(w): explicit jumps end at 2 over it.

        K is that of the foundation, and of the asperities at the gap 0.
        """
        stiffness = self.stiffness
        if self.solids is not None:
            from clearance.wearing.rough import pressure_at

            stiffness = pressure_at(1e-30, 0.0, self.solids)[1]
        return stiffness * float(self.path[:, 3:5].sum())

    def step(self, worn: Worn, turns: float) -> Worn:
        """Outlines after so many turns at once.

        Raises RuntimeError where no place of rest exists.
        """
        new = worn.copy()
        done = self._replay(
            self.path,
            float(turns),
            new.data,
            self.stiffness if self.solids is None else self.solids,
            self.surface,
            new.place,
            self.pressure,
            new.volumes,
        )
        if not done:
            raise RuntimeError(f"no place of rest was found when {turns:g} turns were replayed")
        return new

    def both(self, worn: Worn, turns: float) -> tuple[Worn, float]:
        """Outlines after so many turns, first-order error taken off, and that error [m]."""
        full, half = self.step(worn, turns), self.step(self.step(worn, 0.5 * turns), 0.5 * turns)
        change = half.data - full.data
        half.data[1:] = np.maximum(half.data[1:] + change[1:], worn.data[1:])
        half.volumes += half.volumes - full.volumes
        return half, float(np.abs(change[1:]).max())

    def over(
        self, worn: Worn, turns: float, tolerance: float, most: float = math.inf, aim: float = 0.0
    ) -> tuple[Worn, float, float]:
        """Outlines after `turns` turns, or where a depth has grown by `most` [m]: outlines, turns,
        error [m].

        A step's error is at most `tolerance` of the largest depth that it adds. A FEW of the depth
        so far, or of `aim`, the depth of a complete jump [m], stands for a smaller one. Where a
        journal leaves one place of rest for another, a step of any length is uncertain by that.
        """
        done, error, grown, begin = 0.0, 0.0, 0.0, worn.data.copy()
        size = min(turns, max(1.0, 0.2 / max(self.stiff, 1e-300)))
        while done < turns:
            size = min(size, turns - done)
            new, off = self.both(worn, size)
            added = float((new.data - worn.data)[1:].max())
            allowed = tolerance * max(added, FEW * max(grown, aim))
            if off > allowed and size > 1e-3:
                size *= max(0.2, 0.8 * allowed / off)
                continue
            worn, done, error = new, done + size, error + off
            grown = float((worn.data - begin)[1:].max())
            if grown >= most:
                break
            size *= min(2.0, 0.8 * allowed / max(off, 1e-300))
            size = min(size, max(1.0, size * (most - grown) / max(added, 1e-300)))
        return worn, done, error
