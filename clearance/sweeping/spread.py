"""The numbers of many points of one structure as arrays, without a scene for each.

Runs are prepared at some points all over the sweep: its corners, and points between. Each number of
their starts turns out to be the same everywhere, to be a swept parameter (or its size, or the time
of a turn at this speed), or to follow from one of them, which is then prepared at each of its
values. All else is put together from these by the formulas of the ordinary way; the numbers must be
equal to those prepared, bit for bit. Where they are not, the points of a sweep are run one by one
(`Irregular`).
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from clearance.elements.element import BLENDED
from clearance.run import Run

MOST_CORNERS = 16
BETWEEN = 12  # points between the corners that are prepared too
SCANNED = 0.5  # share of the points that may be prepared to scan a parameter


class Irregular(Exception):
    """The numbers of this sweep do not follow from its parameters one by one."""


@dataclass(frozen=True)
class Start:
    """All numbers with which a run begins, before films have a say in natural sizes."""

    numbers: np.ndarray  # of the parameter vector, without the derived ones and tables
    state: np.ndarray
    work: np.ndarray
    sizes: np.ndarray  # natural sizes of the coordinates, then of states of first order
    reach: np.ndarray  # free ways of spots
    scalars: np.ndarray  # see SCALARS
    leaves: np.ndarray  # numbers of the scene's description

    @property
    def vector(self) -> np.ndarray:
        """All in one row."""
        return np.concatenate([getattr(self, name) for name in PARTS])


PARTS = ("numbers", "state", "work", "sizes", "reach", "scalars", "leaves")
#: turn of the drive [s] (0: none turns), length of runs without turns [s], frequency [rad/s], size
#: [m], mass [kg]
SCALARS = ("turn", "until", "frequency", "size", "mass")
#: forms in which a parameter may be a number: itself, its size, the time of a turn at this speed
FORMS = (lambda v: v, np.abs, lambda v: 2.0 * np.pi / np.abs(v))


def leaves_of(description: object) -> Iterator[tuple[tuple, object]]:
    """Place and value of each text and number of a scene's description."""
    stack = [((), description)]
    while stack:
        place, value = stack.pop()
        if isinstance(value, dict):
            stack += [((*place, key), entry) for key, entry in value.items()]
        elif isinstance(value, list | tuple):
            stack += [((*place, i), entry) for i, entry in enumerate(value)]
        else:
            yield place, value


def start_of(run: Run) -> Start:
    """The start of a run that has not begun."""
    mechanism, count = run.mechanism, run.mechanism.coordinates
    turn, work = mechanism.scene.turn, mechanism.work0.copy()
    blended = [i for i, (_, spot) in enumerate(mechanism.spots) if spot.kind == BLENDED]
    work[blended] = 0.0  # a typical speed, see `Mechanism`
    described = (v for _, v in leaves_of(mechanism.scene.description()))
    until = 0.0 if turn else run.span.until
    mass = sum(b.mass for b in mechanism.scene.bodies)
    scalars = turn or 0.0, until, mechanism.frequency, mechanism.start.size, mass
    return Start(
        mechanism.par[: len(mechanism.layout.parameters)].copy(),
        mechanism.y0,
        work,
        np.delete(mechanism.scale, range(count, 2 * count)),
        mechanism.reach,
        np.array(scalars, dtype=float),
        np.array([v for v in described if type(v) is float]),
    )


class Spread:
    """Starts of points as arrays.

    prepared: gives the run of swept values, not begun; columns: values of the swept numbers by
        name, (points,).
    at: of each number, how it follows from them. Raises Irregular.
    """

    def __init__(self, prepared: Callable[[dict], Run], columns: dict[str, np.ndarray]):
        self.prepared, self.columns = prepared, columns
        self.values = {name: np.unique(column) for name, column in columns.items()}
        self.base = {name: values[len(values) // 2].item() for name, values in self.values.items()}
        self.run = self._tried(self.base)
        self.kind = self._kind(self.run)
        self.sizes = [getattr(start_of(self.run), name).size for name in PARTS]
        trials = [*self._corners(), *self._between()]
        rows = np.array([self._row(trial) for trial in trials])
        self._classify(trials, rows)
        for trial, row in zip(trials, rows, strict=True):
            if not np.array_equal(
                self.vectors({n: np.array([v]) for n, v in trial.items()})[0], row
            ):
                raise Irregular("its numbers depend on several parameters at once")

    def _tried(self, values: dict) -> Run:
        try:
            return self.prepared(values)
        except (ValueError, TypeError, OSError) as error:
            raise Irregular(str(error)) from error

    def _corners(self) -> list[dict]:
        """Outermost values of all parameters together."""
        ends = [(values[0].item(), values[-1].item()) for values in self.values.values()]
        corners = list(itertools.islice(itertools.product(*ends), MOST_CORNERS))
        corners.append(tuple(end[1] for end in ends))
        return [dict(zip(self.values, corner, strict=True)) for corner in dict.fromkeys(corners)]

    def _between(self) -> list[dict]:
        """Some of the points."""
        count = len(next(iter(self.columns.values())))
        places = np.random.default_rng(0).choice(count, min(BETWEEN, count), replace=False)
        return [{n: column[i].item() for n, column in self.columns.items()} for i in places]

    def _kind(self, run: Run) -> tuple:
        """Parts that all runs must share: structure, tables, samples, texts of the scene."""
        mechanism, layout = run.mechanism, run.mechanism.layout
        described = leaves_of(mechanism.scene.description())
        texts = [(place, type(v) if type(v) is float else v) for place, v in described]
        tables = [id(source) for source in mechanism.sources.values()]
        starts = mechanism.par[len(layout.parameters) + layout.derived :]
        return (
            mechanism.structure,
            texts,
            tables,
            len(starts),
            run.span.samples,
            run.watched.sizes,
            run.method,
        )

    def _row(self, trial: dict) -> np.ndarray:
        run = self._tried(trial)
        if self._kind(run) != self.kind:
            raise Irregular("its points have several structures")
        return start_of(run).vector

    def _classify(self, trials: list[dict], rows: np.ndarray) -> None:
        """Tell numbers that are the same everywhere, those that are a parameter, and those that
        follow from one.
        """
        self.fixed = start_of(self.run).vector
        varying = np.flatnonzero(~((rows == rows[0]).all(axis=0) & (rows[0] == self.fixed)))
        given = {n: np.array([trial[n] for trial in trials], dtype=float) for n in self.columns}
        self.same: dict[tuple, list[int]] = {}
        for (n, v), form in itertools.product(given.items(), range(len(FORMS))):
            taken = {j for places in self.same.values() for j in places}
            with np.errstate(divide="ignore"):
                same = [
                    j
                    for j in varying
                    if j not in taken and np.array_equal(rows[:, j], FORMS[form](v))
                ]
            self.same[n, form] = same
        equal = {j for places in self.same.values() for j in places}
        following: dict[str, list[int]] = {n: [] for n in self.columns}
        for j in (j for j in varying if j not in equal):
            name = next((n for n, v in given.items() if _follows(v, rows[:, j])), None)
            if name is None:
                raise Irregular("its numbers depend on several parameters at once")
            following[name].append(j)
        needed = sum(len(self.values[n]) for n, places in following.items() if places)
        if needed > max(SCANNED * len(next(iter(self.columns.values()))), 1.0):
            raise Irregular("a number that follows from a parameter has too many values")
        self.following = {
            n: (places, self._scan(n)[:, places]) for n, places in following.items() if places
        }

    def _scan(self, name: str) -> np.ndarray:
        """Starts at all values of one parameter."""
        return np.array([self._row(self.base | {name: v.item()}) for v in self.values[name]])

    def varying(self, part: str) -> list[int]:
        """Places of the numbers of a part that are not the same everywhere."""
        k = PARTS.index(part)
        begin, end = sum(self.sizes[:k]), sum(self.sizes[: k + 1])
        places = [
            *(j for p in self.same.values() for j in p),
            *(j for p, _ in self.following.values() for j in p),
        ]
        return sorted(j - begin for j in places if begin <= j < end)

    def vectors(self, columns: dict[str, np.ndarray]) -> np.ndarray:
        """Starts of points, a row each."""
        rows = np.tile(self.fixed, (len(next(iter(columns.values()))), 1))
        for (name, form), places in self.same.items():
            if places:
                rows[:, places] = FORMS[form](columns[name])[:, None]
        for name, (places, table) in self.following.items():
            rows[:, places] = table[np.searchsorted(self.values[name], columns[name])]
        return rows

    def starts(self, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Parts of the starts of points, (points, numbers) each."""
        return dict(
            zip(
                PARTS,
                np.split(self.vectors(columns), np.cumsum(self.sizes)[:-1], axis=1),
                strict=True,
            )
        )


def _follows(given: np.ndarray, values: np.ndarray) -> bool:
    """The values are the same wherever a parameter is."""
    _, groups = np.unique(given, return_inverse=True)
    first = np.zeros(groups.max() + 1)
    first[groups] = values
    return bool(np.array_equal(first[groups], values)) and len(np.unique(groups)) < len(given)
