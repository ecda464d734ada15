"""Sums the wear of a run over its accepted steps, surface by surface.

The pressure p = K_w g of the foundation over the nodes of both outlines becomes depth,
w(p, |v|) dt. It is evaluated at start, middle and end of each step (Lobatto's weights 1/6, 4/6,
1/6). Where the law is linear in the pressure, the depths are then scaled to the worn volume that
was integrated with the motion.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from clearance.elements.worn_journal import FOLLOWED
from clearance.laws.outline import NODES, STEP, Outline
from clearance.laws.solid_pressure import pressures, put_on_journal
from clearance.laws.wear import is_linear
from clearance.laws.worn_asperity import Rough, row_of
from clearance.machine.store import compiled
from clearance.run.observers import Observer

WEIGHTS = np.array([1.0, 4.0, 1.0]) / 6.0
ROWS = 512  # worked on at once
PARTS = 360  # of equal wear, which the load path of a turn consists of
UNIT = 1e6  # pressure at which the rate of a linear law is taken [Pa]
BODIES = {"wear": "bearing", "wear_journal": "journal"}


@dataclass
class Turn:
    """Wear of one turn, or of a complete run.

    depths, volumes: worn off each surface, by "bearing" and "journal" [m], [m3]; error: share by
    which the sum over the bins missed the volume. rubbing: int N |v| dt [J]. path: rows of PATH,
    equal parts of the wear.
    """

    depths: dict[str, np.ndarray]
    volumes: dict[str, float]
    error: float
    rubbing: float
    path: np.ndarray


#: columns of a load path: force on the journal in the bearing's frame [N], its angle, depth over
#: pressure of both surfaces [m/Pa], clearance of the contact [m]
PATH = ("force_x", "force_y", "angle", "bearing", "journal", "clearance")


@dataclass
class Sums:
    """Wear of one joint since the last turn."""

    joint: object
    rows: list = field(default_factory=list)

    def __post_init__(self):
        self.laws = {body: getattr(self.joint, slot) for slot, body in BODIES.items()}
        self.laws = {body: law for body, law in self.laws.items() if law is not None}
        self.linear = {body: is_linear(law) for body, law in self.laws.items()}
        parameters = self.joint.outline.parameters
        self.outline = {body: np.array(parameters[body]) for body in BODIES.values()}
        self.numbers = Outline(None, self.outline).numbers
        self.solids = solids_of(self.joint) or Rough(0.0, 0.0, 0.0, 0)
        self.room = np.zeros(2 * NODES)
        self.start()

    def start(self) -> None:
        """Begin a turn."""
        self.depths = {body: np.zeros(NODES) for body in self.laws}
        self.rubbing, self.rows = 0.0, []

    @property
    def area(self) -> float:
        """Surface of a bin [m2]."""
        return self.joint.radius * self.joint.contact_length * STEP

    def add(self, log: np.ndarray, trail: np.ndarray) -> None:
        """Steps (end, size, ...) and what was followed of them, (steps, 3, columns)."""
        weights = log[:, 1, None] * WEIGHTS
        flat = trail.reshape(-1, len(FOLLOWED))
        touching = flat[:, FOLLOWED.index("normal_load")] > 0.0
        flat = flat[touching]
        weights = weights.ravel()[touching]
        for first in range(0, len(flat), ROWS):
            self._spread(flat[first : first + ROWS], weights[first : first + ROWS])

    def _spread(self, flat: np.ndarray, weights: np.ndarray) -> None:
        x, y, angle, clearance, stiffness, speed, fx, fy, load = flat.T
        rows = np.column_stack([x, y, angle, clearance, stiffness, load])
        pressure = np.zeros((len(flat), NODES))
        _compiled(pressures)(rows, self.numbers, self.solids, self.area, self.room, pressure)
        self.rubbing += float((weights * load * speed).sum())
        over = {body: np.zeros(len(flat)) for body in BODIES.values()}
        for body, law in self.laws.items():
            if self.linear[body]:
                over[body] = weights * _over_pressure(law, speed)
                depth = over[body][:, None] * pressure
            else:
                rates = law(pressure, np.broadcast_to(speed[:, None], pressure.shape))
                depth = weights[:, None] * rates
            if body == "journal":
                _compiled(put_on_journal)(depth, flat[:, 2], self.depths[body])
            else:
                self.depths[body] += depth.sum(axis=0)
        self.rows.append(
            np.column_stack([fx, fy, angle, over["bearing"], over["journal"], clearance, load])
        )

    def finish(self, volumes: dict[str, float]) -> Turn:
        """The wear since the start; volumes: exact ones of the surfaces whose law is linear
        [m3].
        """
        summed = {body: self.area * float(depth.sum()) for body, depth in self.depths.items()}
        error = 0.0
        for body, exact in volumes.items():
            if summed[body] > 0.0:
                error = max(error, abs(summed[body] / exact - 1.0)) if exact > 0.0 else 1.0
                self.depths[body] *= exact / summed[body]
                summed[body] = exact
        path = np.concatenate(self.rows) if self.rows else np.zeros((0, len(PATH) + 1))
        turn = Turn(self.depths, summed, error, self.rubbing, sampled(path))
        self.start()
        return turn


def solids_of(joint) -> Rough | None:
    """Foundation and asperities of a joint; None without asperities."""
    if joint.asperity is None:
        return None
    order, factor = joint.asperity.law.pressure
    strength = factor(*joint.asperity.numbers)
    stiffness = joint.contact.values["layer_modulus"]
    return Rough(stiffness, joint.roughness, strength, row_of(order))


@cache
def _compiled(function: Callable) -> Callable:
    return compiled(function)


def _over_pressure(law, speed: np.ndarray) -> np.ndarray:
    """Rate over pressure [m/(s Pa)] of a law that is linear in the pressure."""
    if law(UNIT, 2.0) == 2.0 * law(UNIT, 1.0) == 4.0 * law(UNIT, 0.5):  # and in the speed
        return speed * (law(UNIT, 1.0) / UNIT)
    return law(np.full(speed.shape, UNIT), speed) / UNIT


def sampled(rows: np.ndarray) -> np.ndarray:
    """A load path of PARTS rows of PATH, each for the same wear: the row in the middle of its part.

    rows: these columns and the normal load. Means over a part would not do: the mean force of a
    journal that rattles in its scar presses at a place where it is not.
    """
    share = (rows[:, 3] + rows[:, 4]) * rows[:, 6]
    if not share.sum() > 0.0:
        return np.zeros((0, len(PATH)))
    passed = np.cumsum(share)
    part = passed[-1] / PARTS
    index = np.searchsorted(passed, part * (np.arange(PARTS) + 0.5))
    path = rows[index, : len(PATH)]
    path[:, 3:5] *= (part / share[index])[:, None]
    return path


def thinned(path: np.ndarray, count: int) -> np.ndarray:
    """Each `count`-th row of a load path, for the wear of all."""
    thin = path[count // 2 :: count].copy()
    thin[:, 3:5] *= len(path) / max(len(thin), 1)
    return thin


class Wearing(Observer):
    """Sums the wear of all joints of a run that wear; turns: by joint, one for each period.

    period: of the turns [s], None for the complete run.
    """

    def __init__(self, run, period: float | None = None):
        self.run, self.period = run, period
        joints = [j for j in run.mechanism.scene.clearance_joints if j.wear or j.wear_journal]
        self.sums = {j.name: Sums(j) for j in joints}
        self.turns: dict[str, list[Turn]] = {name: [] for name in self.sums}
        layout = run.mechanism.layout
        first = layout.length - len(layout.sums)
        self.index = (
            {path: first + i for i, path in enumerate(layout.sums)} if layout.ledger else {}
        )
        self.before = dict.fromkeys(self.index, 0.0)

    def follow(self, log, trail):
        """Add a piece of steps."""
        for i, sums in enumerate(self.sums.values()):
            columns = trail[:, :, i * len(FOLLOWED) : (i + 1) * len(FOLLOWED)]
            sums.add(log, columns)

    def reach(self, run):
        """A turn is over."""
        self.finish()

    def finish(self) -> None:
        """End a turn."""
        y = self.run.state.y
        for name, sums in self.sums.items():
            paths = {b: f"joints/{name}/wear_volume_{b}" for b in BODIES.values()}
            there = {b: p for b, p in paths.items() if p in self.index}
            exact = {b: float(y[self.index[p]] - self.before[p]) for b, p in there.items()}
            self.turns[name].append(sums.finish(exact))
        self.before = {path: float(y[i]) for path, i in self.index.items()}

    def add_facts(self, recorder) -> None:
        """Hand the wear of the run to a record, joint by joint."""
        if self.period is None:
            self.finish()
        for name, turns in self.turns.items():
            sums = self.sums[name]
            facts = {f"depth_{body}": depth for body, depth in sums.outline.items()}
            for body in sums.laws:
                facts[f"worn_{body}"] = sum((t.depths[body] for t in turns), np.zeros(NODES))
                facts[f"volumes_{body}"] = np.array([t.volumes[body] for t in turns])
            facts |= {
                "rubbing": sum(t.rubbing for t in turns),
                "bins_error": max((t.error for t in turns), default=0.0),
            }
            recorder.add_facts(f"joints/{name}/wear", **facts)
