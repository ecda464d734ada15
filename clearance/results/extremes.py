"""Extremes and integrals of a run: which quantities have theirs, and what came of it.

The time loop locates them on the dense output of its steps (stepping/locating.py), with their
times. A stretch is a turn, or several in runs of more than 100,000, or a hundredth of a run without
turns. Start-ups can thus be left out.

Integrals over time are those of squares of forces and efforts, and times in contact. The loop sums
them over its steps (stepping/quadrature.py), so that they do not depend on the samples. A part is a
twentieth of a stretch, or all of it in runs of many turns.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from clearance.values.units import behind

#: types of joints along which a body slides
SLIDES = ("Prismatic", "ClearancePrismatic")
STRETCHES = 100  # of a run without turns that have extremes of their own
TURNS = 100_000  # that have extremes of their own, at most
ROUNDING = 1e-9  # share of a stretch, or of a part, that rounding may move its ends by
LOW, HIGH = ("min",), ("max",)
BOTH = ("min", "max")
#: extremes of joints that have names of their own, as attributes of a file's joints and in
#: summaries
JOINT_EXTREMES = {"force_max": "peak_force", "gap_min": "smallest_gap"}
#: channels of joints and drives with located extremes; of joints also the size of the force
FOLLOWED = {
    "gap": LOW,
    "elastic_film": LOW,
    "film_least": LOW,
    "film_wedge": HIGH,
    "film_squeeze": HIGH,
    "film_pressure": HIGH,
    "friction": BOTH,
    "torque": BOTH,
    "torque_ideal": BOTH,
    "force": BOTH,
    "force_ideal": BOTH,
}


@dataclass(frozen=True)
class Extreme:
    """Largest or smallest value of a quantity, its time [s] and its units."""

    value: float
    time: float
    units: str = field(default="", compare=False)

    def __repr__(self) -> str:
        return f"<extreme {self.value:.6g}{behind(self.units)} at {self.time:.6g} s>"


def sign_of(name: str) -> float:
    """-1 for an extreme that is a smallest value, 1 for a largest one."""
    return -1.0 if name.endswith("_min") else 1.0


@dataclass(frozen=True)
class Quantity:
    """A quantity whose extreme is located.

    name: "joints/B/force_max", the path of a channel, or of a vector's size, and its end; channel:
        its place among the outputs; paired: it is the size of the vector of this channel and the
        next.
    """

    name: str
    units: str
    channel: int
    paired: bool = False

    @property
    def sign(self) -> float:
        return sign_of(self.name)


@lru_cache(maxsize=16)
def followed(channels: tuple, accelerations: tuple[str, ...] = ()) -> tuple[Quantity, ...]:
    """The quantities of a run whose extremes are located.

    channels: its outputs, with path and units; accelerations: paths of those along guides.
    """
    guided, quantities, paths = set(accelerations), [], {c.path for c in channels}
    for i, c in enumerate(channels):
        kind, _, name = c.path.partition("/")[0], *c.path.rpartition("/")[1:]
        if kind == "joints" and name == "force_x" and f"{c.path[:-1]}y" in paths:
            quantities.append(Quantity(f"{c.path[:-2]}_max", c.units, i, paired=True))
        ends = FOLLOWED.get(name, ()) if kind in ("joints", "drives") else ()
        if name == "friction" and c.path.replace("friction", "gap") in paths:
            ends = ()  # of clearance joints: part of their force
        for end in BOTH if c.path in guided else ends:
            quantities.append(Quantity(f"{c.path}_{end}", c.units, i))
    return tuple(quantities)


def guides(scene: dict) -> dict[str, tuple[float, float]]:
    """Direction, along the fixed axes, of the guide of each body that slides on the ground.

    scene: its description, as plain data.
    """
    directions = {}
    for joint in scene["joints"]:
        if joint["type"] not in SLIDES:
            continue
        a, b = joint["a"]["body"], joint["b"]["body"]
        x, y = joint["axis"]
        if a == "ground":
            directions[b] = (x, y)
        # the axis is fixed in the body, which stands at minus the joint's angle
        elif b == "ground":
            c, s = math.cos(joint["angle"]), math.sin(joint["angle"])
            directions[a] = (c * x + s * y, c * y - s * x)
    return directions


def along(direction: tuple[float, float]) -> tuple[str, float]:
    """The fixed axis that is nearest to a guide, and the guide's share of it: a body has no
    acceleration across.
    """
    x, y = direction
    return ("x", x) if abs(x) >= abs(y) else ("y", y)


def stretch_length(until: float, turn: float | None) -> float:
    """Length of the stretches of a run [s]; turn: of a turn, None where nothing turns."""
    if turn is None:
        return until / STRETCHES
    return min(turn * math.ceil(until / turn / TURNS), until)


def stretches(until: float, length: float) -> int:
    """Number of stretches of a run; its last may be shorter."""
    return max(math.ceil(until / length * (1.0 - ROUNDING)), 1)


@dataclass(frozen=True)
class Extremes:
    """Located extremes of a run.

    length: of a stretch [s]; names, units: of the quantities; values, times: (stretches,
        quantities), infinite values where a stretch was not reached.
    """

    length: float
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    times: np.ndarray

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    @cached_property
    def columns(self) -> dict[str, int]:
        """Column of each quantity."""
        return {name: i for i, name in enumerate(self.names)}

    def inside(self, begin: float, end: float) -> np.ndarray:
        """True for extremes that lie between two times [s], (stretches, quantities); where no times
        are stored, for stretches that lie completely there.
        """
        slack = ROUNDING * self.length
        inside = (self.times >= begin - slack) & (self.times <= end + slack)
        inside[self.whole(begin, end)] |= np.isnan(self.times).any(axis=0)
        return inside

    def whole(self, begin: float, end: float) -> slice:
        """Stretches that lie completely between two times [s]."""
        first = math.ceil(max(begin, 0.0) / self.length * (1.0 - ROUNDING))
        count = len(self.values)
        last = count if math.isinf(end) else math.floor(end / self.length * (1.0 + ROUNDING))
        return slice(first, max(first, min(last, count)))

    def cut(self, begin: float, end: float) -> list[tuple[float, float]]:
        """Parts between two times [s] that belong to stretches which the times cut.

        Samples count in them, beside located extremes.
        """
        part = self.whole(begin, end)
        if part.start >= part.stop or not np.isfinite(self.values[part]).all():
            return [(begin, end)]
        low = part.start * self.length
        high = math.inf if math.isinf(end) else part.stop * self.length
        slack = ROUNDING * self.length
        return [(a, b) for a, b in ((begin, low), (high, end)) if a < b and b - a > slack]

    def outermost(self, begin: float, end: float) -> tuple[np.ndarray, np.ndarray]:
        """Values of all quantities as `of` gives them, infinite where there is none, and their
        times.
        """
        inside, signs = self.inside(begin, end), np.array([*map(sign_of, self.names)])
        best = np.where(inside, signs * self.values, -np.inf).argmax(axis=0)
        columns = np.arange(len(self.names))
        values = np.where(inside[best, columns], self.values[best, columns], np.inf)
        return values, self.times[best, columns]

    @cached_property
    def _outermost(self) -> dict[tuple, list[list[float]]]:
        """Outermost values and their times, by begin and end."""
        return {}

    def of(self, name: str, begin: float = 0.0, end: float = math.inf) -> Extreme | None:
        """Outermost of the extremes that lie between two times [s]; None where there is none.

        In a stretch that the times cut, an extreme beside them hides those between them.
        """
        if (begin, end) not in self._outermost:
            self._outermost[begin, end] = [v.tolist() for v in self.outermost(begin, end)]
        value, time = (row[self.columns[name]] for row in self._outermost[begin, end])
        return Extreme(value, time) if math.isfinite(value) else None


def better(name: str, extremes: Iterable[Extreme | None]) -> Extreme | None:
    """The outermost of several extremes of a quantity; None among them do not count."""
    there = (e for e in extremes if e is not None)
    return max(there, key=lambda e: sign_of(name) * e.value, default=None)


PARTS = 20  # of a stretch
MOST = 20_000  # parts of a run, where a stretch has several
EFFORTS = ("torque", "force")
FORMS = {"positive": 1, "growth": 2}  # of integrands that are no squares, behind these


@dataclass(frozen=True)
class Integrand:
    """A quantity with an integral over time.

    name: "drives/crank/torque_square", the path of a channel, or of a vector, and _square, or
        _positive for the time in which it is above zero; channel: its place among the outputs;
        form: "square", "pair" for the square of the vector of this channel and the next,
        "positive", or "growth" for that of the channel itself.
    """

    name: str
    units: str
    channel: int
    form: str


@lru_cache(maxsize=16)
def summed(
    channels: tuple, blended: tuple[str, ...] = (), uneven: bool = False
) -> tuple[Integrand, ...]:
    """The quantities of a run that are summed over time, in the order of FORMS.

    channels: its outputs, with path and units; blended: joints whose contact sets in gradually;
    uneven: turns end between samples, where growths of energies are needed.
    """
    integrands, paths = [], {c.path for c in channels}
    for i, c in enumerate(channels):
        kind, part, name = (*c.path.split("/"), "", "")[:3]
        if kind == "drives" and name in EFFORTS:
            integrands.append(Integrand(f"{c.path}_square", f"({c.units})^2 s", i, "square"))
        if kind == "joints" and name == "force_x" and f"{c.path[:-1]}y" in paths:
            integrands.append(Integrand(f"{c.path[:-2]}_square", f"({c.units})^2 s", i, "pair"))
        if kind == "joints" and name == "contact_force" and part in blended:
            integrands.append(Integrand(f"{c.path}_positive", "s", i, "positive"))
        if uneven and c.path.endswith("/dissipated"):
            integrands.append(Integrand(f"{c.path}_growth", c.units, i, "growth"))
    return tuple(sorted(integrands, key=lambda i: FORMS.get(i.form, 0)))


def parts(stretches: int) -> int:
    """Number of parts of a stretch, from the number of stretches."""
    return PARTS if PARTS * stretches <= MOST else 1


@dataclass(frozen=True)
class Integrals:
    """Integrals over time of a run.

    names, units: of the integrands; ends: of the parts [s], (parts,), the first begins with the
        run; values: (parts, integrands).
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    ends: np.ndarray
    values: np.ndarray

    @cached_property
    def edges(self) -> np.ndarray:
        """Ends of the parts, with the start of the run [s]."""
        return np.concatenate([[0.0], self.ends])

    @cached_property
    def cumulated(self) -> dict[str, np.ndarray]:
        """Integrals from the start of the run to each of the edges, by name."""
        start = np.zeros((1, len(self.names)))
        sums = np.cumsum(np.concatenate([start, self.values]), axis=0)
        return dict(zip(self.names, sums.T, strict=True))

    def inside(self, begin: float, end: float) -> tuple[int, int]:
        """First and last edge between two times [s]; the same where no part lies between."""
        slack = ROUNDING * self.edges[1]
        first = int(np.searchsorted(self.edges, begin - slack))
        last = int(np.searchsorted(self.edges, end + slack, side="right")) - 1
        return first, max(first, last)

    def nearest(self, times: np.ndarray) -> np.ndarray:
        """Places of the edges nearest to times [s]."""
        places = np.clip(np.searchsorted(self.edges, times), 1, len(self.ends))
        return places - (times - self.edges[places - 1] < self.edges[places] - times)

    def between(self, name: str, times: np.ndarray) -> np.ndarray | None:
        """Integrals between ascending times [s] that are edges; None where one is not, or the run
        has no such integral.
        """
        places = self.nearest(times)
        if (
            name not in self.names
            or np.abs(self.edges[places] - times).max() > ROUNDING * self.edges[1]
        ):
            return None
        return np.diff(self.cumulated[name][places])
