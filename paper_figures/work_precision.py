"""Error against run time: all steppers of this package and, on the same compiled right-hand side,
other people's.

Timings are warm, as after many steps, and medians of repeats; what a solver compiles or sets up
before its first solution is reported apart. The reference is this package's tightest run, checked
by a second method.
"""

import importlib.util
import math
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from clearance.paper_figures.peers import PEERS, Problem

from clearance.accuracy.companion import THROUGHOUT
from clearance.accuracy.horizon import DISPLACEMENT, NotSolved, parting
from clearance.files.texts import markdown
from clearance.metrics.by_turn import means
from clearance.metrics.statistics import Mean
from clearance.results.tables import save_tables
from clearance.run.options import LARGEST_SHARE, METHODS, Demand, affordable, choose_method
from clearance.scene.scene import Scene
from clearance.simulation import SimulationError, simulate
from clearance.values import checks

RTOLS = tuple(10.0**-k for k in range(3, 13))
LEVELS = tuple(10.0**-k for k in range(2, 9))
STATISTICS_TURNS, STATISTICS_RTOLS = 40, (1e-4, 1e-6, 1e-8)
REPEATS = 7
ENOUGH = 1.5  # seconds after which a measurement is not repeated any more
PATIENCE = 20.0  # seconds: a solver that needed longer gets no request for more digits
STEP_LIMIT = 3_000_000
NONSENSE = 1.0  # error of a solution that has lost the trajectory
FLOOR = 1e-9  # errors of a chaotic reference must stay below this where they are measured


@dataclass
class Curve:
    """One solver: its points, ordered by tolerance, and what it cost before the first one.

    stated: errors that a run has by one at ten times the tolerance, as `simulate` states them; nan
        without such a run.
    """

    name: str
    own: bool
    prepared_s: float = 0.0
    rtol: list[float] = field(default_factory=list)
    error: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    calls: list[float] = field(default_factory=list)
    evaluations: list[int] = field(default_factory=list)
    stated: list[float] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(
        self,
        rtol: float,
        error: float,
        seconds: float,
        evaluations: int,
        stated: float = math.nan,
        call: float = math.nan,
    ) -> None:
        self.rtol.append(rtol)
        self.error.append(error)
        self.seconds.append(seconds)
        self.calls.append(seconds if math.isnan(call) else call)
        self.evaluations.append(evaluations)
        self.stated.append(stated)

    def cheapest(self, level: float, calls: bool = False) -> float:
        """Seconds of the cheapest run with an error of at most `level`, or of the cheapest call;
        nan if there is none.
        """
        seconds = self.calls if calls else self.seconds
        return min(
            (s for s, e in zip(seconds, self.error, strict=True) if e <= level), default=math.nan
        )


@dataclass
class Study:
    """All curves of a scene and where their reference stands."""

    title: str
    measure: str
    until: float
    turns: float | None
    reference: tuple[str, str]
    doubt: float
    curves: list[Curve]
    remarks: list[str]
    # by rtol, beyond the horizon
    statistics: dict[float, dict[str, Mean]] = field(default_factory=dict)

    def best(self, level: float, calls: bool = False) -> float:
        """Cheapest own run at an error level, or cheapest call."""
        cheapest = (c.cheapest(level, calls) for c in self.curves if c.own)
        return min((seconds for seconds in cheapest if seconds > 0.0), default=math.nan)


def work_precision(
    title: str,
    scene: Scene,
    *,
    turns: float | None = None,
    until: float | None = None,
    peers: bool = False,
    progress: Callable[[str], None] = lambda text: None,
) -> Study:
    """Measure all solvers on a scene, over `turns` of its drive or `until` seconds (default: two
    turns, or two seconds). The time is cut where neighbouring trajectories of a chaotic scene part.
    `peers` adds those that are installed.
    """
    if turns is not None and until is not None:
        raise ValueError("give either turns or until, not both")
    if until is None:
        _moving(scene)
        if turns is not None and scene.turn is None:
            raise ValueError(
                "turns needs a constant-speed rotating drive with speed != 0, or one with a "
                "nominal speed; "
                "give until=SECONDS instead"
            )
        until = (2.0 if turns is None else checks.positive("turns", turns)) * (scene.turn or 1.0)
    until, began = checks.positive("until", until), time.perf_counter()
    affordable(Demand(0, until / (scene.turn or until) / LARGEST_SHARE))
    problem, remarks = Problem(scene, until), []
    if problem.mechanism.layout.remembering:
        raise ValueError(
            "a film with a memory makes no initial value problem that solvers could share"
        )
    problem.mechanism.structure.fuse_stages()
    problem.solution(problem.reference_methods[0], 1e-3, max_steps=STEP_LIMIT)
    shared = time.perf_counter() - began
    remarks.append(f"kernels and time loop: {shared:.2g} s; all solvers share the right-hand side")
    statistics: dict[float, dict[str, Mean]] = {}
    if problem.contacts:
        progress("horizon")
        full, problem = problem, _comparable(problem, remarks)
        if problem is not full:
            statistics = _statistics(scene, progress)
    progress("reference")
    doubt = problem.doubt
    solvers = [
        (m, True, _stepper_of(m))
        for m in METHODS
        if m == "dop853" or not (problem.contacts and not problem.films)
    ]
    if len(solvers) == 1:
        remarks.append(
            "implicit methods are 5 to 100 times dearer in dry contact: only the "
            "explicit one is shown"
        )
    for name, (module, prepare) in PEERS.items():
        if module == "scipy" or peers:
            _add_peer(solvers, name, module, prepare, remarks)
    curves = [_curve(problem, *s, progress) for s in solvers]
    turn = scene.turn
    chosen = ", ".join(
        f"{choose_method(problem.mechanism, 'auto', r)[0]} at {r:.0e}" for r in (1e-3, 1e-6, 1e-9)
    )
    remarks.append(f"simulate and run would choose {chosen}")
    return Study(
        title,
        problem.measure,
        problem.until,
        problem.until / turn if turn else None,
        problem.reference_methods,
        doubt,
        curves,
        remarks,
        statistics,
    )


def _moving(scene: Scene) -> None:
    """Raise ValueError for a scene whose drives all stand still: it has no error to measure over a
    default length.
    """
    if scene.drives and all(d.speed == 0.0 for d in scene.drives):
        names = ", ".join(d.name for d in scene.drives)
        raise ValueError(
            f"this scene does not move: the speed of drive {names} is 0; give it a speed, or give "
            f"until=SECONDS where "
            "something else moves"
        )


def _statistics(scene: Scene, progress: Callable[[str], None]) -> dict[float, dict[str, Mean]]:
    """Comparable numbers beyond the horizon: means over turns at several tolerances."""
    rows = {}
    for rtol in STATISTICS_RTOLS if scene.turn else ():
        progress(f"statistics over {STATISTICS_TURNS} turns at {rtol:.0e}")
        try:
            result = simulate(scene, turns=STATISTICS_TURNS, rtol=rtol, error=None)
        except SimulationError as reason:
            if reason.result is None:
                raise
            result = reason.result
        rows[rtol] = means(result)
        result.close()
    return rows


def _comparable(problem: Problem, remarks: list[str]) -> Problem:
    """The problem, shortened to where a neighbour of the reference has not grown above the
    floor.
    """
    method = problem.reference_methods[0]
    neighbour = problem.solution(method, 1e-13, DISPLACEMENT).states
    time_of_parting = parting(problem, problem.reference, neighbour, FLOOR)
    if time_of_parting is None:
        return problem
    remarks.append(
        f"chaotic: starts {DISPLACEMENT:g} of the clearance apart are {FLOOR:g} apart after "
        f"{time_of_parting:.4g} s"
        + (f" (turn {time_of_parting / problem.scene.turn:.3g})" if problem.scene.turn else "")
        + "; errors are measured up to there"
    )
    return Problem(problem.scene, time_of_parting)


def _stepper_of(method: str):
    return lambda problem: lambda p, rtol: p.solution(method, rtol, max_steps=STEP_LIMIT)


def _add_peer(solvers: list, name: str, module: str, prepare: Callable, remarks: list[str]) -> None:
    if importlib.util.find_spec(module) is None:
        remarks.append(f"{name}: not installed (pip install clearance[peers])")
    else:
        solvers.append((name, False, prepare))


def _curve(
    problem: Problem, name: str, ours: bool, prepare: Callable, progress: Callable[[str], None]
) -> Curve:
    curve = Curve(name, ours)
    began = time.perf_counter()
    try:
        solve = prepare(problem)
    except NotSolved as reason:
        curve.notes.append(str(reason))
        return curve
    try:
        solve(problem, 1e-3)  # warm
    except (NotSolved, ValueError, RuntimeError) as reason:
        curve.notes.append(f"rtol 1e-03: {reason}")
    curve.prepared_s = time.perf_counter() - began
    failures, looser = len(curve.notes), None
    for rtol in getattr(solve, "rtols", RTOLS):
        if failures > 1 or curve.seconds and curve.seconds[-1] > PATIENCE:
            curve.notes.append(f"not asked for rtol {rtol:.0e} and tighter")
            break
        progress(f"{name} at {rtol:.0e}")
        try:
            looser = _point(problem, curve, solve, rtol, looser)
            failures = 0
        except (NotSolved, ValueError, RuntimeError) as reason:
            curve.notes.append(f"rtol {rtol:.0e}: {reason}")
            failures, looser = failures + 1, None
    return curve


def _point(
    problem: Problem, curve: Curve, solve: Callable, rtol: float, looser: np.ndarray | None
) -> np.ndarray:
    """Add the point of a tolerance, and return its states; looser: those at ten times the
    tolerance, where known.
    """
    points, began = [], time.perf_counter()
    while len(points) < REPEATS and (not points or time.perf_counter() - began < ENOUGH):
        points.append(solve(problem, rtol))
    seconds = statistics.median(s.seconds for s in points)
    error = problem.error(points[0].states)
    if not error < NONSENSE:
        raise NotSolved(f"its answer is {error:.2g} away, which is no answer")
    states = points[0].states
    stated = (
        math.nan if looser is None else THROUGHOUT * float(problem.distance(states, looser).max())
    )
    call = statistics.median(s.call for s in points)
    curve.add(rtol, error, seconds, points[0].evaluations, stated, call)
    return states


# --- showing
def table(study: Study) -> list[str]:
    """Milliseconds to reach an error, and how many times the fastest own method is faster, by its
    loop and by its call, as Markdown.
    """
    levels = [x for x in LEVELS if study.best(x) > 0.0]
    heads = f"{study.title}: ms to an error of", *(f"{x:.0e}" for x in levels), "prepared"
    rows = []
    for c in study.curves:
        name, prepared = c.name, f"{c.prepared_s:.2g} s"
        if c.own:
            name, prepared = f"**{c.name}**", "see below"
        rows.append((name, *(_cell(study, c, x) for x in levels), prepared))
    return markdown(heads, rows)


def _cell(study: Study, curve: Curve, level: float) -> str:
    """Milliseconds to an error, and in brackets those of a complete call; of a peer how many times
    the fastest own loop that is, and the fastest own call.
    """
    cost, call = curve.cheapest(level), curve.cheapest(level, calls=True)
    if math.isnan(cost):
        return "-"
    if curve.own:
        return f"{cost * 1e3:.3g} [{call * 1e3:.3g}]"
    ratios = (cost / study.best(level), cost / study.best(level, calls=True))
    loop, complete = (f"{float(f'{r:.2g}'):g}x" for r in ratios)
    return f"{cost * 1e3:.3g} ({loop}) [{complete}]"


def describe(study: Study) -> list[str]:
    """Notes to the table."""
    span = f"{study.until:.6g} s" + (f" ({study.turns:.3g} turns)" if study.turns else "")
    lines = [
        f"{study.title}: error = largest deviation of {study.measure} over {span};",
        f"reference {study.reference[0]} at its tightest, {study.doubt:.1g} away from "
        f"{study.reference[1]}",
    ]
    lines.append(
        "own times are those of the compiled loop, in brackets of complete calls from Python, "
        "as all times of others are"
    )
    lines += study.remarks + _stated(study)
    if study.statistics:
        lines += ["", *statistics_table(study), ""]
    return lines + [f"{c.name}: {note}" for c in study.curves for note in c.notes]


def _stated(study: Study) -> list[str]:
    """A sentence on stated and true errors, above the uncertainty of the reference."""
    pairs = [p for c in study.curves if c.own for p in zip(c.stated, c.error, strict=True)]
    factors = sorted(s / e for s, e in pairs if s == s and e > study.doubt)
    if not factors:
        return []
    above, middle = sum(f >= 1.0 for f in factors), factors[len(factors) // 2]
    count = f"{above} of {len(factors)} runs"
    return [f"stated errors are above the true ones in {count}, {middle:.2g} times in the median"]


def statistics_table(study: Study) -> list[str]:
    """Means over turns at several tolerances: they should agree within their 95 % intervals."""
    tolerances = list(study.statistics)
    title = f"mean over {STATISTICS_TURNS - 1} turns +- half its 95 % interval"
    rows = (
        (name, *(study.statistics[r].get(name, "-") for r in tolerances))
        for name in next(iter(study.statistics.values()))
    )
    return markdown((title, *(f"rtol {r:.0e}" for r in tolerances)), rows)


def plain(study: Study) -> dict:
    """The study as one JSON document."""
    return {
        "title": study.title,
        "measure": study.measure,
        "until_s": study.until,
        "turns": study.turns,
        "reference": list(study.reference),
        "reference_doubt": study.doubt,
        "remarks": study.remarks,
        "statistics": [
            {"rtol": r, "means": {n: m.plain() for n, m in row.items()}}
            for r, row in study.statistics.items()
        ],
        "curves": [vars(c) for c in study.curves],
    }


def save(study: Study, folder: str | Path) -> Path:
    """The points of all curves as HDF5."""
    tables = {}
    for c in study.curves:
        tables[c.name.replace("/", " ")] = (
            {"own": c.own, "prepared_s": c.prepared_s, "notes": "; ".join(c.notes)},
            {
                "rtol": ("1", "requested tolerance or step over turn", np.array(c.rtol)),
                "error": ("1", f"largest deviation of {study.measure}", np.array(c.error)),
                "stated": (
                    "1",
                    "stated error, by the run at ten times the tolerance",
                    np.array(c.stated),
                ),
                "seconds": ("s", "median CPU time of a run, warm", np.array(c.seconds)),
                "call": ("s", "median CPU time of a complete call, warm", np.array(c.calls)),
                "evaluations": (
                    "1",
                    "right-hand sides (0: not counted)",
                    np.array(c.evaluations, np.int64),
                ),
            },
        )
    attributes = {
        "title": study.title,
        "until": study.until,
        "reference": " checked by ".join(study.reference),
        "reference_doubt": study.doubt,
        "remarks": "; ".join(study.remarks),
    }
    return save_tables(
        Path(folder) / "work_precision.h5", "clearance-work-precision", attributes, tables
    )
