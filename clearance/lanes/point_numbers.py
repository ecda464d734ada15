"""The numbers of many points of one structure as arrays, without a scene for each.

Runs are prepared at some points all over the sweep: its corners, and points between. Each number of
their starts belongs to one of three kinds. It is the same everywhere, or the scene of columns
(values/columns.py) gives it, or it follows from one parameter and is prepared at each value. A
typical speed comes from the rates at the start where it has to. All else is put together from these
by the formulas of the ordinary way. The numbers must be those prepared: bit for bit, or within a
share of them. Where they are not, each start is prepared by itself, or the points are run one by
one (`NotForLanes`).
"""

import itertools
import math
from collections.abc import Callable, Iterator
from functools import reduce

import numpy as np

from clearance.lanes.lane_outputs import LaneOutputs
from clearance.mechanism.assembly import size_of
from clearance.mechanism.numbers import numbers_of
from clearance.run.ideal_motion import moves
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.values.algebra import Arrays
from clearance.values.columns import Column, values_of
from clearance.values.spots import BLENDED

MOST_CORNERS = 16
BETWEEN = 12  # points between the corners that are prepared too, at most
OF_ALL = 8  # of so many points one, at most
SCANNED = 0.5  # share of the points that may be prepared to scan a parameter


class NotForLanes(Exception):
    """The reason for which points of a sweep cannot share a memory or run in lanes."""


#: parts of a start. Numbers are those of the parameter vector, without derived ones and tables.
#: Sizes are natural ones of the coordinates, then of states of first order. Reach is the free way
#: of each spot, scalars are SCALARS. Leaves are numbers of the scene's description.
PARTS = ("numbers", "state", "work", "sizes", "reach", "scalars", "leaves")
#: turn of the drive [s] (0: none turns), frequency [rad/s], size [m], mass [kg]
SCALARS = ("turn", "frequency", "size", "mass")


def leaves_of(description: object) -> Iterator[tuple[tuple, object]]:
    """Path and value of each text and number of a scene's description."""
    stack = [((), description)]
    while stack:
        path, value = stack.pop()
        if isinstance(value, dict):
            stack += [((*path, key), entry) for key, entry in value.items()]
        elif isinstance(value, list | tuple):
            stack += [((*path, i), entry) for i, entry in enumerate(value)]
        else:
            yield path, value


def start_of(run: Run) -> Arrays:
    """Parts of all numbers with which a run that has not begun begins, before films change natural
    sizes.
    """
    mechanism = run.mechanism
    turn, work = mechanism.scene.turn, mechanism.work0.copy()
    blended = [i for i, (_, spot) in enumerate(mechanism.spots) if spot.kind == BLENDED]
    work[blended] = 0.0  # a typical speed, see `Mechanism`
    described = (v for _, v in leaves_of(mechanism.scene.description()))
    mass = sum(b.mass for b in mechanism.scene.bodies)
    scalars = turn or 0.0, mechanism.frequency, mechanism.start.size, mass
    parts = (
        mechanism.par[: len(mechanism.layout.parameters)].copy(),
        mechanism.y0,
        work,
        np.delete(mechanism.scale, mechanism.layout.rates),
        mechanism.reach,
        np.array(scalars, dtype=float),
        np.array([v for v in described if type(v) is float]),
    )
    return dict(zip(PARTS, parts, strict=True))


class PointNumbers:
    """Starts of points as arrays.

    scene: gives the scene of swept values; prepared: gives the run of them, not begun; columns:
        values of the swept numbers by name, (points,); share: of a number that it may be off; base:
        a point to begin with, default in the middle; alone: numbers of none of the three kinds
        are prepared at each point, such as a start that lengths decide; even: runs have as many
        turns and samples.
    run: of the base. Raises NotForLanes.
    """

    def __init__(
        self,
        scene: Callable[[dict], Scene],
        prepared: Callable[[dict], Run],
        columns: Arrays,
        share: float = 0.0,
        base: dict[str, float] | None = None,
        alone: bool = False,
        even: bool = True,
    ):
        self.scene_of, self.prepared, self.columns, self.share = scene, prepared, columns, share
        self.alone, self.even, self.latest = alone, even, ({}, np.zeros((0, 0)))
        self.rates: LaneOutputs | None = None  # of the bodies at the start, see `_frequency`
        self.values = {name: np.unique(column) for name, column in columns.items()}
        middle = {name: values[len(values) // 2].item() for name, values in self.values.items()}
        self.base = base or middle
        self.run = self._tried(self.base)
        self.kind = self._kind(self.run)
        parts = list(start_of(self.run).values())
        self.fixed, self.sizes = np.concatenate(parts), [part.size for part in parts]
        self.rounded = self._rounded()
        trials = [*self._corners(), *self._between()]
        rows = np.array([self._row(trial) for trial in trials])
        swept = {n: np.array([trial[n] for trial in trials], dtype=float) for n in columns}
        self.latest = swept, rows
        self._classify(swept, rows)
        if not self._same(self.vectors(swept), rows).all():
            raise NotForLanes("its numbers depend on several parameters at once")

    def _tried(self, values: dict) -> Run:
        try:
            return self.prepared(values)
        except (ValueError, TypeError, OSError) as error:
            raise NotForLanes(str(error)) from error

    def _corners(self) -> list[dict]:
        """Outermost values of all parameters together."""
        ends = [(values[0].item(), values[-1].item()) for values in self.values.values()]
        corners = list(itertools.islice(itertools.product(*ends), MOST_CORNERS))
        corners.append(tuple(end[1] for end in ends))
        return [dict(zip(self.values, corner, strict=True)) for corner in dict.fromkeys(corners)]

    def _between(self) -> list[dict]:
        """Some of the points."""
        count = len(next(iter(self.columns.values())))
        tried = min(BETWEEN, count // OF_ALL)
        places = np.random.default_rng(0).choice(count, tried, replace=False)
        return [{n: column[i].item() for n, column in self.columns.items()} for i in places]

    def _kind(self, run: Run) -> tuple:
        """Parts that all runs must share: structure, tables, samples, texts, a pace or none."""
        mechanism, layout = run.mechanism, run.mechanism.layout
        described = leaves_of(mechanism.scene.description())
        texts = [(path, type(v) if type(v) is float else v) for path, v in described]
        texts = [(path, v) for path, v in texts if not _is_place(path, v)]
        starts = mechanism.par[len(layout.parameters) + layout.derived :]
        length = (run.span.samples, run.watched.sizes) if self.even else ()
        return (
            mechanism.structure,
            texts,
            len(starts),
            length,
            run.method.text,
            bool(mechanism.pace),
        )

    def _row(self, trial: dict) -> np.ndarray:
        run = self._tried(trial)
        if (kind := self._kind(run)) != self.kind:
            many = "film tables" if kind[:2] == self.kind[:2] else "structures"
            raise NotForLanes(f"its points have several {many}")
        return np.concatenate(list(start_of(run).values()))

    def _same(self, values: np.ndarray, base: np.ndarray) -> np.ndarray:
        """True for numbers that are equal within the share."""
        sizes = np.maximum(np.abs(base), self.rounded)
        return (values == base) | (np.abs(values - base) <= self.share * sizes)

    def _rounded(self) -> np.ndarray:
        """Sizes of what starts are solved for, which may be rounding beside 0: states, and
        coordinates of drives.
        """
        mechanism, sizes = self.run.mechanism, np.zeros(sum(self.sizes))
        for drive in mechanism.scene.drives:
            if (index := mechanism.layout.parameters.get(f"{drive.key}/start")) is not None:
                sizes[index] = mechanism.start.size if drive.slides else 1.0
        first = self.sizes[0]
        sizes[first : first + mechanism.size] = mechanism.scale
        return sizes

    def _classify(self, swept: Arrays, rows: np.ndarray) -> None:
        """Separate the numbers that are the same everywhere, those that the scene of columns gives,
        and those that follow from one parameter.
        """
        varying = ~self._same(self.fixed, rows).all(axis=0)
        formed = varying & self._as_formed(swept, rows)
        frequency = sum(self.sizes[: PARTS.index("scalars")]) + SCALARS.index("frequency")
        if self.share and varying[frequency] and not formed[frequency]:
            bodies = [b.key for b in self.run.mechanism.scene.bodies]
            paths = [f"{body}/{name}" for name in ("omega", "vx") for body in bodies]
            self.rates = LaneOutputs(self.run.mechanism, paths)
            formed = varying & self._as_formed(swept, rows)
        self.formed = np.flatnonzero(formed)
        following: dict[str, list[int]] = {n: [] for n in self.columns}
        self.solved = np.flatnonzero(varying & ~formed) if self.alone else np.zeros(0, int)
        for j in np.flatnonzero(varying & ~formed) if not self.alone else ():
            name = next((n for n, v in swept.items() if _follows(v, rows[:, j])), None)
            if name is None:
                raise NotForLanes(self._not_from_parameters())
            following[name].append(j)
        needed = sum(len(self.values[n]) for n, places in following.items() if places)
        if needed > max(SCANNED * len(next(iter(self.columns.values()))), 1.0):
            raise NotForLanes("a number that follows from a parameter has too many values")
        self.following = {
            n: (places, self._scan(n)[:, places]) for n, places in following.items() if places
        }

    def _as_formed(self, swept: Arrays, rows: np.ndarray) -> np.ndarray:
        """True for numbers that the scene of columns gives."""
        try:
            return self._same(self._formed(swept), rows).all(axis=0)
        except (ValueError, TypeError):  # a scene that takes no columns
            return np.zeros(rows.shape[1], bool)

    def _not_from_parameters(self) -> str:
        """The reason where a number neither is formed nor follows from one parameter."""
        if len(self.columns) > 1:
            return "its numbers depend on several parameters at once"
        return f"a number of its starts does not come from {next(iter(self.columns))} by arithmetic"

    def _formed(self, columns: Arrays) -> np.ndarray:
        """Starts of points as the scene of columns gives them, a row each; all that it does not
        give is that of the base.
        """
        scene = self.scene_of({name: Column(values) for name, values in columns.items()})
        layout, start = self.run.mechanism.layout, start_of(self.run)
        numbers = list(start["numbers"])
        for name, number in numbers_of(scene):
            if name in layout.parameters and isinstance(number, Column):
                numbers[layout.parameters[name]] = number
        states = {f"{e.key}/{s.name}": s.size for e in scene.elements for s in e.states()}
        names = [*layout.coordinates, *layout.first_order]
        sizes = [states.get(n, size) for n, size in zip(names, start["sizes"], strict=True)]
        reach = [spot.reach for _, spot in scene.spots]
        size = size_of(scene)
        mass = sum(b.mass for b in scene.bodies)
        scalars = [scene.turn or 0.0, self._frequency(scene, size, numbers), size, mass]
        leaves = [v for _, v in leaves_of(scene.description()) if isinstance(v, float)]
        row = [*numbers, *start["state"], *start["work"], *sizes, *reach, *scalars, *leaves]
        count = len(next(iter(columns.values())))
        return np.column_stack([np.broadcast_to(values_of(number), count) for number in row])

    def _frequency(self, scene: Scene, size: float, numbers: list) -> np.ndarray:
        """Typical angular frequencies, see Mechanism.frequency: motions of the start are those of
        the drive's speed, or as outputs give them.
        """
        mechanism, size = self.run.mechanism, values_of(size)
        start, drives = mechanism.start, mechanism.scene.drives
        if self.rates is not None:
            outputs = self.rates.at_start(np.array(np.broadcast_arrays(*map(values_of, numbers))))
            spins, speeds = np.split(np.abs(outputs), 2)
            rates = [*spins, *(speeds / size)]
        else:
            rates = [abs(v[2]) for v in start.velocity.values()]
            rates += [abs(v[0]) / size for v in start.velocity.values()]
        rates += [abs(d.nominal) for d in drives if d.nominal]
        fastest = reduce(np.maximum, rates, 0.0)
        if len(drives) == 1 and drives[0].speed and self.rates is None:
            before, speed = abs(drives[0].speed), np.abs(values_of(scene.drives[0].speed))
            # bit for bit where nothing is faster than the driven body
            fastest = np.where(fastest == before, speed, fastest * (speed / before))
        gravity = np.sqrt(math.hypot(*mechanism.scene.gravity) / size)
        return np.maximum(fastest, gravity)

    def _scan(self, name: str) -> np.ndarray:
        """Starts at all values of one parameter."""
        return np.array([self._row(self.base | {name: v.item()}) for v in self.values[name]])

    def varying(self, part: str) -> list[int]:
        """Places of the numbers of a part that are not the same everywhere."""
        k = PARTS.index(part)
        begin, end = sum(self.sizes[:k]), sum(self.sizes[: k + 1])
        places = [*self.formed.tolist(), *(j for p, _ in self.following.values() for j in p)]
        places += self.solved.tolist()
        return sorted(j - begin for j in places if begin <= j < end)

    @property
    def paths(self) -> list[tuple]:
        """Those numbers of the scene's description that are not the same everywhere."""
        described = leaves_of(self.run.mechanism.scene.description())
        leaves = [path for path, v in described if type(v) is float]
        return [leaves[i] for i in self.varying("leaves")]

    @property
    def moves(self) -> bool:
        """True where ideal motions differ in more than the speed of one drive."""
        scene, places = self.run.mechanism.scene, self.paths
        speeds = [p for p in places if p[0] == "loads" and p[-1] == "speed"]
        return any(map(moves, places)) or bool(speeds) and len(scene.drives) > 1

    def has(self, columns: Arrays) -> np.ndarray:
        """True for points whose values this was made of."""
        return np.logical_and.reduce([np.isin(columns[n], v) for n, v in self.values.items()])

    def vectors(self, columns: Arrays) -> np.ndarray:
        """Starts of points, a row each."""
        rows = np.tile(self.fixed, (len(next(iter(columns.values()))), 1))
        if self.formed.size:
            rows[:, self.formed] = self._formed(columns)[:, self.formed]
        for name, (places, table) in self.following.items():
            rows[:, places] = table[np.searchsorted(self.values[name], columns[name])]
        if self.solved.size:
            rows[:, self.solved] = self._prepared(columns)[:, self.solved]
        return rows

    def _prepared(self, columns: Arrays) -> np.ndarray:
        """Starts of points as they are prepared one by one, those of the last points once; where
        none can be, not numbers.
        """
        before, rows = self.latest
        same = before.keys() == columns.keys()
        if not same or any(not np.array_equal(before[n], v) for n, v in columns.items()):
            points = zip(*(column.tolist() for column in columns.values()), strict=True)
            rows = np.array([self._start(dict(zip(columns, p, strict=True))) for p in points])
            self.latest = columns, rows
        return rows

    def _start(self, values: dict) -> np.ndarray:
        try:
            return self._row(values)
        except NotForLanes:  # the ordinary way gives the reason
            return np.full_like(self.fixed, np.nan)

    def starts(self, columns: Arrays) -> Arrays:
        """Parts of the starts of points, (points, numbers) each."""
        return self.parts(self.vectors(columns))

    def parts(self, vectors: np.ndarray) -> Arrays:
        """Parts of starts by name, their numbers along the last axis."""
        ends = np.cumsum(self.sizes)[:-1]
        return dict(zip(PARTS, np.split(vectors, ends, axis=-1), strict=True))


def _is_place(path: tuple, value: object) -> bool:
    """True for the name of a point that has its coordinates for one."""
    return path[-1] == "point" and str(value).startswith("(")


def _follows(parameter: np.ndarray, values: np.ndarray) -> bool:
    """The values are the same wherever a parameter is."""
    _, groups = np.unique(parameter, return_inverse=True)
    first = np.zeros(groups.max() + 1)
    first[groups] = values
    return bool(np.array_equal(first[groups], values)) and len(np.unique(groups)) < len(parameter)
