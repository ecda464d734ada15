"""`cl.fit`: parameters of a scene from records, with a verdict, in a folder."""

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from clearance.files.locks import locked
from clearance.files.texts import listed
from clearance.identify.free import Bounds, Journal, Progress, all_bounded, saved
from clearance.identify.measured import Measured, check_varies, read
from clearance.identify.run_errors import refined, weighted
from clearance.identify.scene_fit import (
    MOUNTING,
    NUISANCES,
    OFFSET,
    REFUSED,
    SHIFT,
    STARTING,
    Curve,
    NotFollowed,
    Problem,
    Solved,
)
from clearance.identify.turn_statistics import by_statistics, reason_without
from clearance.identify.verdict import Interval, Verdict, verdict
from clearance.metrics.sensor import crossed, deviation
from clearance.results.result import Result
from clearance.run.progress_bar import watched
from clearance.scene.catalogue import AnyCase, load_case
from clearance.scene.scene import Scene
from clearance.simulation import simulate
from clearance.values import checks
from clearance.values.accessors import Celled, accessor
from clearance.values.units import behind
from clearance.version import VERSION

STARTS = 5
DOCUMENT, JOURNAL = "fit.json", "starts.json"
AUTO = "auto"
# probability of chi-square below which a fit with many minima has not followed its record
# without a stated noise: residuals over the record's deviation, above which it has not
LOST, FOLLOWED = 1e-6, 0.3

Data = str | Path | Measured | tuple[str | Path | Measured, Mapping[str, object]]


@dataclass(frozen=True, eq=False)
class SceneFit(Celled):
    """Parameters of a scene that were fitted to records.

    problem: scene and records; best: the least cost; ends: of all starts; verdict: intervals,
    correlations, checks.
    """

    problem: Problem
    best: Solved
    ends: tuple[Solved, ...]
    verdict: Verdict

    @property
    def values(self) -> dict[str, float]:
        """Parameters by name, in SI."""
        return self.problem.values(self.best.x)

    @property
    def intervals(self) -> dict[str, Interval]:
        """Parameters with their 95 % intervals, by name."""
        return {i.name: i for i in self.verdict.intervals}

    @property
    def nuisances(self) -> dict[str, tuple[float, float, str]]:
        """Fitted numbers of the sensors: value, standard deviation and units, by name."""
        problem, rows = self.problem, {}
        deviations = np.sqrt(np.diag(self.verdict.covariance))  # those of statistics have none
        for k in range(len(problem.free), len(deviations)):
            i, kind = problem.nuisances[k - len(problem.free)]
            units = {SHIFT: "s", MOUNTING: "rad", OFFSET: problem.curves[i].measured.units}
            size = problem.scales[i] if kind == OFFSET else 1.0
            numbers = (float(size * x) for x in (self.best.x[k], deviations[k]))
            rows[problem.names[k]] = *numbers, units.get(kind, "1")
        return rows

    @cached_property
    def scene(self) -> Scene:
        """The scene with the fitted parameters."""
        return self.problem.scene_of(self.best.x)

    @cached_property
    def curves(self) -> list[tuple[Curve, np.ndarray]]:
        """Records, each with the values that the fitted scene gives in their place."""
        problem = self.problem
        errors = problem.residuals(self.best.x)
        return [
            (c, c.measured.values + errors[rows] * sigma)
            for c, rows, sigma in zip(problem.curves, problem.rows, problem.sigma, strict=True)
        ]

    def document(self) -> dict:
        """All of it as plain data."""
        judged, problem = self.verdict, self.problem
        return {
            "parameters": {i.name: i._asdict() for i in judged.intervals},
            "nuisances": {name: value for name, (value, _, _) in self.nuisances.items()},
            "correlation": judged.correlation.tolist(),
            "names": judged.names,
            "inseparable": judged.products,
            "noise": judged.noise,
            "sigma": problem.sigma,
            "values": judged.samples,
            "independent_values": judged.facts,
            "tests": judged.tests,
            "minima": [
                {"parameters": v, "growth": g, "probability": p}
                for (v, g), p in zip(judged.minima, judged.chances[1:], strict=True)
            ],
            "doubts": judged.doubts,
            "records": [
                {"file": str(c.measured.path), "column": c.measured.column, "channel": c.channel}
                for c in problem.curves
            ],
            "starts": [{"cost": e.cost, "parameters": problem.values(e.x)} for e in self.ends],
            "version": VERSION,
        }

    def save(self, folder: str | Path) -> Path:
        """Write `fit.json` and the run of the fitted scene, `run.h5`, into a folder."""
        return saved(self, folder, DOCUMENT)

    def simulated(self, path: str | Path | None = None) -> Result:
        """The run of the fitted scene, as long as the longest record and what settles before."""
        run = self.problem.run_of(self.best.x, self.problem.groups[0])
        until = run.span.until
        return simulate(self.scene, until=until, samples=run.span.samples, path=path)

    def plot(self, output: str | Path | None = None):
        """Picture: records over what was fitted, residuals, regions of pairs of parameters."""
        return accessor("plot_fit")(self, output)

    def report(self, output: str | Path) -> Path:
        """Write a page that needs nothing else."""
        return accessor("report_fit")(self, output)

    def __repr__(self) -> str:
        text = ", ".join(shown(i) for i in self.verdict.intervals)
        return f"<fit of {self.problem.scene.name}: {text}>"


def shown(interval: Interval) -> str:
    """A parameter with as many digits as its interval has."""
    name, value, low, high, deviation, units, kind = interval
    unit = behind(units)
    if not math.isfinite(deviation) or not deviation:
        return f"{name} = {value:.4g}{unit} ({kind})"
    digits = max(2 - math.floor(math.log10(deviation / abs(value))), 1) if value else 2
    spread = f"{low:.{digits}g} to {high:.{digits}g}"
    return f"{name} = {value:.{digits}g}{unit} ({spread}, {kind})"


@watched
def fit(
    scene: AnyCase,
    data: Data | Sequence[Data],
    parameters: Bounds,
    channels: str | Iterable[str],
    *,
    noise: float | str | Sequence[float | str] | None = None,
    settle: float | None = None,
    nuisances: str | Iterable[str] = AUTO,
    lowpass: tuple[int, float] | Sequence[tuple[int, float] | None] | None = None,
    starts: int = STARTS,
    seed: int = 0,
    folder: str | Path | None = None,
    progress: Callable[[float], None] | bool | None = None,
) -> SceneFit:
    """Parameters of a scene from measured records, each with a 95 % interval.

    scene: or a case, as `load_case` takes it.
    data: CSV files (see identify/measured.py), records, or pairs of one and the parameters that
        hold for it alone, such as {"speed": 31.4}. parameters: bounds by name, (low, high) in SI or
        texts with units: of the case ("clearance") or numbers of the scene ("bodies/slider/mass").
    channels: of the run, such as "bodies/slider/ax", each in the column of its name, or as
        "bodies/slider/ax=COLUMN". noise: standard deviation of a value's error, one or one for each
        channel, in SI or over the range of a record ("1%"). None takes that of the residuals.
    settle: turns of a run before its records begin (2; 0 s where nothing turns). nuisances: what is
        unknown of each sensor, of "shift", "offset", "gain" and "mounting". That is the angle of a
        sensor of x, y or both. "auto" is the shift of records over time, of scenes that turn.
        lowpass: order and corner [Hz] of the sensor's Butterworth filter, which the computed
        channel has as well; one, or a list of one for each channel.
    starts: points the search begins from; seed: of these. folder: of the fit; an interrupted
        one goes on there. progress: called before each run with the share of starts that have
        ended; what follows them counts as one.
    Raises ValueError for records and parameters that do not fit the scene, before anything runs,
    and where no start has a run.

    Example:

        >>> machine = cl.load_case("slider_crank", model="ideal")
        >>> run = cl.simulate(machine, turns=3, samples_per_turn=90, error=None)
        >>> third = enumerate(run.drive("crank").torque[180:270])
        >>> with open("bench.csv", "w") as file:
        ...     print("angle_deg,torque_Nm", file=file)
        ...     print(*(f"{4 * k},{torque}" for k, torque in third), sep=chr(10), file=file)
        >>> bounds = {"bodies/slider/mass": "50g:500g"}
        >>> fit = cl.fit(machine, "bench.csv", bounds, "drives/crank/torque", starts=1)
        >>> round(fit.values["bodies/slider/mass"], 6)
        0.14
    """
    scene = load_case(scene)
    free = all_bounded(scene, parameters)
    curves = [*_curves(scene, data, channels, noise, settle, nuisances, lowpass)]
    checks.whole("fit: starts", starts, 1)
    problem = Problem(scene, free, curves, settle)
    problem.progress = Progress(progress)
    if folder is None:
        return fitted(problem, starts, seed)
    path = Path(folder)
    with locked(path, "fit"):
        result = fitted(problem, starts, seed, path / JOURNAL)
        result.save(path)
    return result


def fitted(problem: Problem, starts: int, seed: int, journal: Path | None = None) -> SceneFit:
    """The fit: of trajectories, or of statistics of turns where none follows the records."""
    try:
        return _by_trajectories(problem, starts, seed, journal)
    except NotFollowed as lost:
        if reason := reason_without(problem):
            raise ValueError(f"{lost}; {reason}") from None
    best, judged = by_statistics(problem, seed)
    return SceneFit(problem, best, (best,), judged)


def _by_trajectories(problem: Problem, starts: int, seed: int, journal: Path | None) -> SceneFit:
    """The fit; ends of starts stand in a journal and are taken from it.

    Raises NotFollowed, after one start at the latest where that ends at the least cost and
    trajectories part before a record begins.
    """
    past = Journal(journal, Solved, _about(problem, seed))
    problem = problem.before_horizon(problem.middle)
    loose, ends = problem.loose(), []
    for i, x in enumerate(loose.starts(starts, seed)):
        tell = partial(lambda i, share: problem.progress((i + share) / (starts + 1)), i)
        ends.append(past.end(lambda x=x, tell=tell: loose.followed(x, tell)))
        if not i and math.isfinite(ends[0].cost):
            problem.before_horizon(ends[0].x)
        problem.progress((i + 1) / (starts + 1))
    if not (problem.turn or problem.touching):  # minima that first parts do not lead to
        others = loose.lowest(starts - 1, seed)
        ends += [past.end(lambda x=x: loose.solved(x, finish=STARTING)) for x in others]
    ends = problem.finished(ends)
    best = min(ends, key=lambda e: e.cost)
    if not math.isfinite(best.cost):
        raise ValueError(f"fit: no start has a run and its neighbours: {loose.reason}")
    before, first = problem, best
    while (shorter := problem.before_horizon(best.x)) is not problem:
        problem, best = shorter, shorter.solved(best.x)
    problem, best, error = refined(problem, weighted(problem, best))
    moved = {id(first): best}
    for end in ends:
        if id(end) not in moved:
            rival = problem is not before and end.cost <= REFUSED * first.cost
            moved[id(end)] = (problem.solved if rival else problem.priced)(end.x)
    ends = [moved[id(end)] for end in ends]
    judged = verdict(problem, best, ends, error)
    if problem.touching and _lost(problem, judged):
        raise NotFollowed(
            f"fit: the best of {starts} starts does not follow the records: its residuals are no "
            f"noise; contacts start with a touch, and other minima are many; take more starts, or "
            f"a shorter record from the start of the motion (settle=0)"
        )
    return SceneFit(problem, best, tuple(ends), judged)


def _lost(problem: Problem, judged: Verdict) -> bool:
    """True where residuals are far larger than the stated noise, or no small share of a record."""
    shares = [
        sigma / float(np.std(c.measured.values))
        for c, sigma in zip(problem.curves, problem.sigma, strict=True)
        if c.sigma is None
    ]
    return judged.tests.get("chi-square", 1.0) < LOST or max(shares, default=0.0) > FOLLOWED


def _about(problem: Problem, seed: int) -> list:
    """All that the ends of starts depend on."""
    about: list[object] = [seed, problem.settle, problem.scene.to_json(), problem.free]
    for c in problem.curves:
        record = hashlib.sha256(c.measured.x.tobytes() + c.measured.values.tobytes()).hexdigest()
        about.append((c.channel, c.sigma, c.nuisances, c.lowpass, c.changes, record))
    return about


def _curves(scene: Scene, data, channels, noise, settle, nuisances, lowpass) -> list[Curve]:
    """All records beside their channels."""
    paths = listed(channels) or []
    if not paths:
        raise ValueError("fit: give at least one channel, such as bodies/slider/ax")
    noises = _each("noise", listed(noise) if isinstance(noise, str) else noise, paths)
    filters = _each("lowpass", [lowpass] if isinstance(lowpass, tuple) else lowpass, paths)
    many = isinstance(data, list) or (isinstance(data, tuple) and not _changed(data))
    curves = []
    for source in data if many else [data]:
        source, changes = source if isinstance(source, tuple) else (source, {})
        for text, error, filtering in zip(paths, noises, filters, strict=True):
            path, equals, column = text.partition("=")
            record = source
            if not isinstance(source, Measured):
                record = read(source, column if equals else None)
            path, wanted = path.strip(), _nuisances(nuisances, record, scene)
            label = f"{record.path.name}, {record.column} of {path}"
            check_varies(label, record.values, record.units)
            if SHIFT in wanted and scene.turn and settle != 0.0 and record.along == "time":
                record = replace(record, x=record.x - record.x[0])
            if not path.endswith(("x", "y")):
                wanted = tuple(n for n in wanted if n != MOUNTING)
            curves.append(
                Curve(record, path, _sigma(error, record), wanted, filtering, dict(changes))
            )
    if MOUNTING in nuisances and not any(MOUNTING in c.nuisances for c in curves):
        crossed(path)
    return curves


def _each(word: str, values, paths: Sequence[str]) -> Sequence:
    """Values of channels, one for all or one for each. Raises ValueError."""
    values = values if isinstance(values, list | tuple) else [values]
    if len(values) not in (1, len(paths)):
        raise ValueError(f"fit: {word} needs one value, or {len(paths)}, one a channel")
    return values if len(values) == len(paths) else [*values] * len(paths)


def _changed(data: tuple) -> bool:
    """True for a pair of a record and its parameters."""
    return len(data) == 2 and isinstance(data[1], Mapping)


def _sigma(noise: float | str | None, record: Measured) -> float | None:
    """Standard deviation of the error of a value, in SI."""
    if noise is None:
        return None
    units = None if record.units == "?" else record.units
    span, check = float(np.ptp(record.values)), partial(checks.positive, "fit: noise")
    return deviation(noise, span, check, units)


def _nuisances(words: str | Iterable[str], record: Measured, scene: Scene) -> tuple[str, ...]:
    """Nuisances of a record. Raises ValueError for one that there is not."""
    if words == AUTO:
        return (SHIFT,) if record.along == "time" and scene.turn else ()
    names = [n for n in listed(words) or [] if n != "none"]
    for name in names:
        checks.known("fit: no nuisance", name, NUISANCES)
    return tuple(names)
