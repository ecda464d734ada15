"""Parameters of a scene that are free between bounds: coordinates, scenes, starts, their journal.

Positive parameters have their logarithm as coordinate, others the value over the width of the
bounds.
"""

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from clearance.accuracy.by_differences import WIDTH, Impossible
from clearance.files.locks import replace_file
from clearance.files.texts import document_of
from clearance.results.recorder import MemoryRecord
from clearance.run.run import Run
from clearance.scene.parameter import check_effect, varied
from clearance.scene.scene import Scene
from clearance.simulation import prepare
from clearance.values import checks
from clearance.values.even_points import sobol
from clearance.values.units import quantity
from clearance.version import VERSION

#: two bounds in SI or with units, or "LOW:HIGH"
Bounds = Mapping[str, tuple[float | str, float | str] | str]


NEAR = 0.25  # of the width of the bounds, between starts
RUN = "run.h5"  # of the result of a search
NO_RUN = Impossible, ValueError, ArithmeticError  # of a scene that cannot be run


@dataclass(frozen=True)
class Free:
    """A free parameter, in SI: of the case ("clearance") or a number of the scene."""

    name: str
    low: float
    high: float
    units: str = "?"

    @property
    def positive(self) -> bool:
        """True where it is searched for in its logarithm."""
        return self.low > 0.0

    @property
    def size(self) -> float:
        """Of a step of 1 in its coordinate where that is no logarithm."""
        return self.high - self.low

    def value(self, x: float) -> float:
        """The parameter at its coordinate."""
        return math.exp(x) if self.positive else x * self.size

    def coordinate(self, value: float) -> float:
        """Its logarithm, or the parameter over the width of its bounds."""
        return math.log(value) if self.positive else value / self.size

    def slope(self, x: float) -> float:
        """Of the parameter by its coordinate."""
        return self.value(x) if self.positive else self.size


def all_bounded(scene: Scene, parameters: Bounds) -> list[Free]:
    """Free parameters. Raises TypeError for what has no bounds by name, ValueError as `bounded`."""
    if not isinstance(parameters, Mapping):
        raise TypeError(
            f"parameters have bounds by name, as {{'clearance': '0.1mm:1mm'}}; got {parameters!r}"
        )
    return [bounded(scene, name, bounds) for name, bounds in parameters.items()]


def bounded(scene: Scene, name: str, bounds) -> Free:
    """A free parameter. Raises ValueError for bounds that do not rise, and for one that does
    nothing.
    """
    about = varied(scene, name, 1.0)
    check_effect(scene, name)
    ends = bounds.split(":") if isinstance(bounds, str) else bounds
    if not hasattr(ends, "__len__") or len(ends) != 2:
        raise ValueError(f"{name} needs two bounds, such as 0.1mm:1mm, got {bounds!r}")
    try:
        ends = [quantity(e, about.units) if isinstance(e, str) else e for e in ends]
    except ValueError as error:
        raise ValueError(f"bounds of {name}: {error}") from None
    return Free(name, *checks.rising(f"bounds of {name}", ends), about.units)


class Progress:
    """The share of a search that is done, also before each of its runs.

    report: called with it, unless it is None.
    """

    share = 0.0

    def __init__(self, report: Callable[[float], None] | None = None):
        self.report = report

    def __call__(self, share: float | None = None) -> None:
        """share: another one."""
        self.share = self.share if share is None else share
        if self.report is not None:
            self.report(self.share)


class Varying:
    """A scene with free parameters; the first coordinates are theirs.

    Raises ValueError for a name that stands twice.
    """

    progress = Progress()

    @property
    def width(self) -> float:
        """Of differences of a coordinate."""
        return WIDTH

    def __init__(self, scene: Scene, free: Sequence[Free]):
        self.scene, self.free = scene, tuple(free)
        checks.distinct("parameters", [p.name for p in self.free])

    @cached_property
    def ends(self) -> np.ndarray:
        """Bounds of the coordinates of the parameters, (parameters, 2)."""
        return np.array([(p.coordinate(p.low), p.coordinate(p.high)) for p in self.free])

    @property
    def inside(self) -> np.ndarray:
        """The scene's numbers where they lie between the bounds, else the middle of these."""
        x = self.ends.mean(axis=1)
        for k, parameter in enumerate(self.free):
            value = varied(self.scene, parameter.name, 1.0).value
            if parameter.low < value < parameter.high:
                x[k] = parameter.coordinate(value)
        return x

    def spread(self, count: int, seed: int, box: np.ndarray | None = None) -> np.ndarray:
        """Sobol' points between the bounds, or those of a box, (count, parameters)."""
        n, random = 2 ** math.ceil(math.log2(count)), np.random.default_rng(seed)
        shares = sobol(n, len(self.free), random)
        low, high = self.ends.T if box is None else box
        return low + shares[:count] * (high - low)

    def distance(self, x: np.ndarray, other: np.ndarray) -> float:
        """The largest of the parameters' coordinates, over the width of the bounds."""
        change = np.abs(x - other)[: len(self.free)]
        return float(np.max(change / np.ptp(self.ends, axis=1)))

    def apart(self, points: Iterable[np.ndarray]) -> list[np.ndarray]:
        """Points in the order of their merit, but those that are near a better one last."""
        apart, near = [], []
        for x in points:
            beside = any(self.distance(x, a) <= NEAR for a in apart)
            (near if beside else apart).append(x)
        return [*apart, *near]

    def values(self, x: np.ndarray) -> dict[str, float]:
        """Parameters at coordinates, by name."""
        return {p.name: p.value(float(v)) for p, v in zip(self.free, x, strict=False)}

    def scene_of(self, x: np.ndarray, changes: Mapping[str, object] | None = None) -> Scene:
        """The scene at coordinates, with further parameters."""
        numbers = {**(changes or {}), **self.values(x)}
        scene, case = self.scene, self.scene.case
        of_case = {n: v for n, v in numbers.items() if "/" not in n}
        if of_case and case is not None:
            scene = case.scene(**self.scene.parameters | of_case)
        others = {n: v for n, v in numbers.items() if n not in of_case}
        return scene.replaced(others) if others else scene

    def prepared(self, scene: Scene, **options) -> Run:
        """A run without an energy ledger."""
        self.progress()
        return prepare(scene, energy=False, **options)


class Beside:
    """A point and those beside it, as `Steps` needs them.

    summed: what is taken of a run and its record, default the record.
    """

    def __init__(
        self,
        problem: Varying,
        x: np.ndarray,
        changes: Mapping[str, object],
        summed: Callable[[Run, MemoryRecord], Any] = lambda _, record: record,
    ):
        self.problem, self.x, self.changes, self.summed = problem, x, changes, summed
        self.prepared = problem.prepared

    def scene_at(self, number: Free, offset: int) -> Scene:
        """The scene with the coordinate of a parameter so many widths away."""
        moved = self.x.copy()
        moved[self.problem.free.index(number)] += offset * self.problem.width
        return self.problem.scene_of(moved, self.changes)


class Journal:
    """Ends of a search, which stand in a file (None: in none) and are taken from there.

    kind: a dataclass of an end, coordinates first; about: all that the ends depend on, by its
    representation; a file about anything else is written anew.
    """

    def __init__(self, path: Path | None, kind: type, about: Sequence):
        names = [f.name for f in fields(kind)]
        self.path, self.kind, self.rows, self.done = path, kind, [], 0
        self.key = hashlib.sha256(repr((VERSION, names, about)).encode()).hexdigest()
        if path is not None and path.is_file():
            before = document_of(path.read_text(encoding="utf-8"), path)
            self.rows = before["ends"] if before.get("key") == self.key else []

    def end(self, make: Callable[[], Any]) -> Any:
        """The next end: the next of the file, else it is made and written."""
        if self.done == len(self.rows):
            x, *others = vars(make()).values()
            self.rows.append([x.tolist(), *others])
            if self.path is not None:
                replace_file(self.path, json.dumps({"key": self.key, "ends": self.rows}))
        x, *others = self.rows[self.done]
        self.done += 1
        return self.kind(np.array(x), *others)


def saved(search, folder: str | Path, name: str) -> Path:
    """Write the `document()` of a result of a search and its `simulated(path)` into a folder."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    replace_file(folder / name, json.dumps(search.document(), indent=1) + "\n")
    search.simulated(folder / RUN).close()
    return folder
