"""`cl.follow`: a periodic motion of a case over a parameter, with its bifurcations; in CSV, HDF5
and a picture.
"""

import csv
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import groupby, islice, pairwise
from pathlib import Path

import numpy as np

from clearance.files.locks import replacing
from clearance.mechanism.build import Mechanism, build
from clearance.motions import branch_file
from clearance.motions.branch import DOUBLING, FOLD, LARGEST, LOCATED, POINTS, Follower, Point
from clearance.motions.maps import NotPeriodic
from clearance.motions.steady import tolerance_of
from clearance.results.extremes import along, guides
from clearance.results.stream import matching
from clearance.results.tables import columns_of, save_tables
from clearance.run.inputs import accept, differences, of_case
from clearance.run.progress_bar import watched
from clearance.scene.catalogue import AnyCase, case_with
from clearance.values import checks
from clearance.values.accessors import Celled
from clearance.values.units import UNITS, written

INTERRUPTED = "interrupted"
SAVED = 3.0  # seconds between two writings of a branch under way, at least
SHARE = 50.0  # the same, over the time that a writing takes
#: columns of a branch that are attributes of its points: units, text
COLUMNS = {
    "period": ("turns", "period"),
    "branch": ("1", "number of the doubling that the curve begins in, 0 for the first curve"),
    "duration": ("s", "duration of a period"),
    "contacts": ("1", "contacts in a period"),
    "slope": ("1", "share of the parameter in the tangent"),
}


@dataclass(frozen=True)
class Branch(Celled):
    """Periodic motions of a case over a parameter, in the order in which they were met.

    parameter and its units; fixed: the other parameters that were given; channels: paths of the
    outputs in `points`, with their units; reason: why it ends; request: what was requested, as
    plain data; inputs: of its points, see `inputs.of_case`.
    """

    case: str
    parameter: str
    units: str
    fixed: dict
    channels: dict[str, str]
    points: list[Point] = field(repr=False)
    reason: str
    request: dict = field(repr=False, default_factory=dict)
    inputs: list[dict] = field(repr=False, default_factory=list)

    @property
    def values(self) -> np.ndarray:
        """Values of the parameter, (points,)."""
        return np.array([p.value for p in self.points])

    @property
    def bifurcations(self) -> list[Point]:
        """Folds, period doublings, tori and grazings, located."""
        return [p for p in self.points if p.kind]

    @property
    def folds(self) -> list[float]:
        """Values of the parameter where it turns."""
        return [p.value for p in self.points if p.kind == FOLD]

    @property
    def coexisting(self) -> list[tuple[float, float, int, int]]:
        """Stretches of the parameter with more than one motion of this branch: begin, end,
        motions, stable ones.
        """
        parts = list(self._parts())
        edges = sorted({edge for low, high, _ in parts for edge in (low, high)})
        stretches: list[tuple[float, float, int, int]] = []
        least = 10.0 * LOCATED * (edges[-1] - edges[0]) if edges else 0.0
        for low, high in pairwise(edges):
            if high - low <= least:
                continue
            here = [stable for a, b, stable in parts if a <= low and high <= b]
            stretch = (low, high, len(here), sum(here))
            if stretches and stretches[-1][1] == low and stretches[-1][2:] == stretch[2:]:
                stretches[-1] = (stretches[-1][0], *stretch[1:])
            elif len(here) > 1:
                stretches.append(stretch)
        return stretches

    def _parts(self) -> Iterator[tuple[float, float, bool]]:
        """Stretches of each curve between bifurcations: lower and upper value, stable."""
        for _, curve in groupby(self.points, lambda p: p.branch):
            points = list(curve)
            edges = [0, *(i for i, p in enumerate(points) if p.kind), len(points) - 1]
            for first, last in pairwise(edges):
                inner = [p.stable for p in points[first : last + 1] if not p.kind]
                ends = sorted((points[first].value, points[last].value))
                if inner and ends[0] < ends[1]:
                    yield *ends, bool(np.median(inner))

    def columns(self) -> dict[str, tuple[str, str, np.ndarray]]:
        """All of it as columns: units, text, values."""
        points, turns = self.points, max((p.period for p in self.points), default=1)
        count = max((p.multipliers.size for p in points), default=0)

        def padded(rows: list[np.ndarray]) -> np.ndarray:
            wide = [np.pad(row, (0, count - row.size)) for row in rows]
            return np.array(wide).reshape(len(points), count)

        values, errors = padded([p.multipliers for p in points]), padded([p.errors for p in points])
        stable = np.array([p.stable for p in points], int)
        largest = np.array([p.largest for p in points])
        table = {self.parameter: (self.units, "value of the parameter", self.values)}
        table |= columns_of(points, {"kind": ("1", "bifurcation, empty on the way")})
        table["stable"] = "1", "1: neighbouring motions come back", stable
        table["largest_multiplier"] = "1", "size of the largest", largest
        table |= columns_of(points, COLUMNS)
        for i in range(count):
            table[f"multiplier_{i + 1}_real"] = ("1", "Floquet multiplier", values[:, i].real)
            table[f"multiplier_{i + 1}_imaginary"] = ("1", "Floquet multiplier", values[:, i].imag)
            table[f"multiplier_{i + 1}_error"] = ("1", "its error", errors[:, i])
        for c, (path, units) in enumerate(self.channels.items()):
            for turn in range(turns):
                rows = [p.outputs[turn, c] if turn < len(p.outputs) else math.nan for p in points]
                name = path.replace("/", ".") + (f"[{turn}]" if turns > 1 else "")
                table[name] = (units, f"{path} where a turn begins", np.array(rows, float))
        return table

    def save(self, folder: str | Path) -> list[Path]:
        """Write follow.csv and follow.h5 in a folder."""
        folder, columns = Path(folder), self.columns()
        folder.mkdir(parents=True, exist_ok=True)
        about = {
            "case": self.case,
            "parameter": self.parameter,
            "units": self.units,
            "ended": self.reason,
            "format_version": branch_file.FORMAT_VERSION,
            "request": json.dumps(self.request, sort_keys=True),
            "made": json.dumps(self.inputs, sort_keys=True),
        }
        fixed = {
            name: value if isinstance(value, int | float) else str(value)
            for name, value in self.fixed.items()
        }
        tables = {"branch": (fixed, columns), "places": ({}, branch_file.places(self.points))}
        file = save_tables(folder / branch_file.FILE, branch_file.FORMAT, about, tables)
        with replacing(folder / "follow.csv") as part, part.open("w", newline="") as table:
            writer = csv.writer(table)
            writer.writerow(f"{name} [{units}]" for name, (units, _, _) in columns.items())
            writer.writerows(
                zip(*(values.tolist() for _, _, values in columns.values()), strict=True)
            )
        return [folder / "follow.csv", file]


@watched
def follow(
    case: AnyCase,
    parameter: str,
    low: float,
    high: float,
    *,
    fixed: Mapping[str, object] | None = None,
    tolerance: float | str = 1e-6,
    rtol: float | None = None,
    points: int = 500,
    step: float | None = None,
    doublings: int = 0,
    most_turns: int = 400,
    max_steps: int | None = None,
    channels: list[str] | None = None,
    path: str | Path | None = None,
    unit: str = "",
    accept_changes: bool = False,
    progress: Callable[[str], None] | bool | None = None,
) -> Branch:
    """Follow the periodic motion that a case settles to at `low`, towards `high`, round folds.

    parameter: name of one with numbers; fixed: values of others. tolerance, rtol, most_turns and
    max_steps: as in `steady`. points: of a curve, at most; step: the longest along the curve, in
    natural sizes of the states and shares of the range (default 0.03, up to 0.2 where it is quiet).
    doublings: how often the period may double: from each period doubling a curve of motions of
    twice the period is followed too. channels: paths or patterns of outputs to keep where turns
    begin (default: what bifurcation diagrams show). path: folder for follow.csv and follow.h5,
    written every few seconds. The same call continues from there, and with more points from the end
    of a curve. accept_changes: also where the package, a law, the case file or the scene's numbers
    have changed since. unit: in which sentences show values of the parameter, such as rpm; SI
    without. progress: called with a sentence.
    Folds, period doublings, changes of the number of contacts (grazing) and of stability by complex
    multipliers are located. Motions behind a fold are unstable as a rule; where the branch turns
    again several motions coexist. Raises ValueError for bad arguments, NotPeriodic where no
    periodic motion is met at `low`.

    Example:

        >>> lubricated = {"model": "lubricated"}
        >>> branch = cl.follow("slider_crank", "speed", 30.0, 40.0, fixed=lubricated, points=3)
        >>> len(branch.folds)
        0
    """
    the_case, fixed = case_with(case, fixed, [parameter])
    _check(the_case, parameter, fixed, low, high, unit)
    _check_numbers(step, points, doublings)
    tolerance, rtol = tolerance_of(tolerance, rtol)

    def scene(value: float):
        return the_case.scene(**fixed, **{parameter: value})

    mechanism, report = build(scene(low), ledger=False), progress or (lambda text: None)
    shown = _channels(mechanism, channels)
    request = {"case": the_case.name, "parameter": parameter, "low": low, "high": high}
    request |= {"fixed": dict(sorted(fixed.items())), "channels": list(shown), "rtol": rtol}
    request |= {"tolerance": tolerance, "step": step or LARGEST, "doublings": doublings}
    now = of_case(mechanism, the_case, fixed.values())
    met, before = _met(Path(path), request, points, now, accept_changes) if path else ([], [])
    inputs = before if now in before else [*before, now]
    units = the_case.parameters[parameter].units
    branch = Branch(the_case.name, parameter, units, fixed, shown, met, "", request, inputs)
    follower = Follower(scene, low, high, tolerance, rtol, list(shown), step, unit, max_steps)
    follower, first = _begun(follower, met, most_turns, report)
    return _followed(branch, follower, first, points, doublings, path, report)


def _begun(
    follower: Follower, met: list[Point], most_turns: int, report: Callable[[str], None]
) -> tuple[Follower, Point]:
    """A follower and the point that it stands on: the last that was met, or the first of all."""
    if met:
        report(f"going on from point {len(met)}")
        return follower.again(met[-1])
    met.append(follower.start(follower.low, follower.high, most_turns, report))
    return follower, met[0]


def _followed(
    branch: Branch,
    follower: Follower,
    first: Point,
    points: int,
    doublings: int,
    path: str | Path | None,
    report: Callable[[str], None],
) -> Branch:
    """A branch with all that its follower meets from a point on, stored in a folder."""
    met, reasons = branch.points, list[str]()
    with _kept(branch, path) as keep:
        for point in _walk(follower, first, met, points, doublings, reasons):
            met.append(point)
            keep()
            value = written(point.value, follower.unit, 6)
            report(f"point {len(met)} at {value}, multiplier {point.largest:.4g}")
    complete = replace(branch, reason="; ".join(reasons))
    if path is not None:
        complete.save(path)
    return complete


def _met(
    folder: Path, request: dict, most: int, now: dict, accept_changes: bool
) -> tuple[list[Point], list[dict]]:
    """Points of an earlier call to go on from, and inputs of these; none where there was none, or
    it came to its end.

    Raises ValueError where the folder holds what was met before an interrupt of another call, and
    where its inputs were others.
    """
    before = branch_file.asked(folder)
    if before is None or not before[1].endswith((INTERRUPTED, POINTS)):
        return [], []
    asked, reason, inputs = before
    if not inputs:  # version 0.2 wrote the path of the case
        asked["case"] = Path(str(asked.get("case"))).stem
    different = [n for n in request if json.dumps(asked.get(n)) != json.dumps(request[n])]
    if different and reason == INTERRUPTED:
        raise ValueError(
            f"{folder} holds an interrupted branch with other {', '.join(different)}; "
            "give another folder"
        )
    met = [] if different else branch_file.points(folder)
    while met and met[-1].kind:  # located on the way to a point that is not there
        met.pop()
    if not met or reason != INTERRUPTED and sum(p.branch == met[-1].branch for p in met) >= most:
        return [], []
    changed = dict.fromkeys(c for entry in inputs or [{}] for c in differences(entry, now))
    if changed:
        accept(f"{folder} has {len(met)} points", changed, accept_changes)
    return met, inputs


def _walk(
    follower: Follower,
    point: Point,
    met: list[Point],
    most: int,
    doublings: int,
    reasons: list[str],
) -> Iterator[Point]:
    """The next points: of the curve that a follower stands on, then of those that begin in period
    doublings, in the order in which these were met. Curves in which an earlier curve ended are left
    out. reasons: why each curve ends.
    """
    longest, number = met[0].period * 2**doublings, point.branch
    while True:
        count = sum(p.branch == number for p in met)
        for new in islice(follower.points(point, most - count + 1), 1, None):
            yield replace(new, branch=number)
        enough = follower.reason.endswith(POINTS)  # counted from where it went on
        reasons.append(f"{max(most, count)}{POINTS}" if enough else follower.reason)
        begins = [p for p in met if p.kind == DOUBLING and 2 * p.period <= longest]
        while True:
            if number >= len(begins):
                return
            number += 1
            if _reached(begins[number - 1], met, follower):
                continue
            try:
                follower, point = follower.doubled(begins[number - 1])
                break
            except NotPeriodic as reason:
                reasons.append(str(reason))
        yield replace(point, branch=number)


def _reached(doubling: Point, met: list[Point], follower: Follower) -> bool:
    """True where a curve before ended in a doubling: its last point lies within a step."""
    last = {p.branch: p for p in met if p.branch}.values()
    near = follower.largest * abs(follower.high - follower.low)
    return any(
        p.period == 2 * doubling.period and abs(p.value - doubling.value) <= near for p in last
    )


@contextmanager
def _kept(branch: Branch, path: str | Path | None) -> Iterator[Callable]:
    """Gives a function that stores the points met so far in the folder where that was long ago. An
    interrupt leaves them there, too.
    """
    due, partial = time.monotonic(), replace(branch, reason=INTERRUPTED)

    def keep() -> None:
        nonlocal due
        if path is not None and (began := time.monotonic()) >= due:
            partial.save(path)
            due = time.monotonic() + max(SAVED, SHARE * (time.monotonic() - began))

    try:
        yield keep
    except KeyboardInterrupt as request:
        if path is not None:
            request.add_note(f"the points so far are stored in {partial.save(path)[0]}")
        raise


def _check(case, parameter: str, fixed: dict, low: float, high: float, unit: str) -> None:
    parameters = case.parameters
    for name in (parameter, *fixed):
        checks.known(f"{case.name} has no parameter", name, parameters)
    if parameters[parameter].kind is not float:
        raise ValueError(f"{parameter} is no number that changes gradually")
    if parameter in fixed:
        raise ValueError(f"{parameter} is followed and cannot be fixed too")
    if checks.finite("low", low) == checks.finite("high", high):
        raise ValueError(f"{parameter}: the range begins where it ends, {low!r}")
    if unit and UNITS.get(unit, ("",))[0] != parameters[parameter].units:
        raise ValueError(f"unit must be one of {parameter}, got {unit!r}")


def _check_numbers(step: float | None, points: int, doublings: int) -> None:
    if step is not None:
        checks.positive("step", step)
    checks.whole("points", points, 2)
    checks.whole("doublings", doublings)


def _channels(mechanism: Mechanism, patterns: list[str] | None) -> dict[str, str]:
    """Paths and units of the outputs to store: those requested, else the eccentricity of the first
    joint with clearance and the velocities of bodies on guides.
    """
    scene, channels = mechanism.scene, mechanism.layout.channels
    if patterns is not None:
        return {channels[i].path: channels[i].units for i in matching(channels, patterns)}
    wanted = [f"joints/{j.name}/eccentricity_ratio" for j in scene.clearance_joints[:1]]
    wanted += [f"bodies/{b}/v{along(d)[0]}" for b, d in guides(scene.description()).items()]
    return {c.path: c.units for c in channels if c.path in wanted}
