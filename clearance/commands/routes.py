"""Routes of inverse dynamics side by side: run time, operations, agreement.

All routes are exact, so there is no error to trade time for. They get the same times and, where
they need it, the motion of the same record. What each computes differs and stands beside its time.
"""

import importlib.util
import math
import statistics
import time as clock
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from clearance.mechanism.assembly import assemble
from clearance.mechanism.structure import Structure
from clearance.motions.inverse import inverse_dynamics
from clearance.motions.prescribed import STRETCH, Explicit
from clearance.results.result import Record, save_tables
from clearance.scene.scene import Scene
from clearance.studies import multipliers, pinocchio
from clearance.studies.pairs import Geometry, Pairs
from clearance.tracing.emission import kernel_text

REPEATS = 7
ENOUGH = 3.0  # seconds after which a route is not repeated any more
IN_PYTHON = 1000  # samples at most of a loop in Python
COUNTED = 25  # samples over which operations are counted
KINDS = ("additions", "multiplications", "divisions", "functions")


@dataclass(frozen=True)
class Operations:
    """Arithmetic of one sample; subtractions are additions, functions are roots, sines and the
    like.
    """

    additions: float
    multiplications: float
    divisions: float
    functions: float

    @property
    def total(self) -> float:
        return self.additions + self.multiplications + self.divisions + self.functions

    def __str__(self) -> str:
        return " + ".join(f"{getattr(self, k):.0f}" for k in KINDS) + f" = {self.total:.0f}"


@dataclass
class Route:
    """One way to the same forces.

    Differences are from the explicit route, over its largest value of the same unit.
    """

    name: str
    computes: str
    samples: int  # that a timing is made over
    operations: Operations | None = None  # for efforts of drives and reactions of joints
    output_operations: Operations | None = None  # for the complete output
    efforts: float = math.nan  # largest difference
    reactions: float = math.nan
    seconds: list[float] = field(default_factory=list)  # a sample, of each repeat

    @property
    def per_sample(self) -> float:
        """Median [s]."""
        return statistics.median(self.seconds)


@dataclass
class RouteStudy:
    """The routes of a scene; equations: of the multipliers, all solved at once."""

    title: str
    samples: int
    equations: int
    routes: list[Route]
    remarks: list[str]

    def route(self, start: str) -> Route:
        """The first route whose name starts so."""
        return next(r for r in self.routes if r.name.startswith(start))


def compare(
    scene: Scene,
    times: np.ndarray,
    peers: bool = False,
    title: str | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> RouteStudy:
    """Measure the routes of inverse dynamics at the same times [s]; `peers` adds Pinocchio where it
    is installed.

    Raises ValueError for scenes that inverse dynamics does not take, SimulationError where their
    motion ends.
    """
    progress("explicit route")
    record, solver = inverse_dynamics(scene, time=times), Explicit(scene)
    study = RouteStudy(title or scene.name, record.time.size, 3 * len(scene.bodies), [], [])
    timings = [*_own(study, solver, record), *_multipliers(study, record, scene, progress)]
    if peers and importlib.util.find_spec("pinocchio") is None:
        study.remarks.append("Pinocchio: not installed (pip install clearance[peers])")
    elif peers:
        progress("Pinocchio")
        timings += _pinocchio(study, record, scene)
    if rubbing := [j.name for j in scene.rubbing_joints]:
        study.remarks.append(
            f"friction in {', '.join(rubbing)}: the routes without friction are compared with the "
            f"ideal efforts"
            + (
                ""
                if _reactions_are_ideal(scene)
                else "; reactions, which friction changes here, are not compared"
            )
        )
    study.routes = [route for route, _ in timings]
    for repeat in range(REPEATS):  # in turn, so that all meet the same state of the machine
        for route, once in timings:
            if sum(route.seconds) * route.samples < ENOUGH:
                progress(f"{route.name}, repeat {repeat + 1}")
                route.seconds.append(once() / route.samples)
    return study


def _timed(call: Callable[[], object]) -> Callable[[], float]:
    """A call that returns its CPU time [s]."""

    def once() -> float:
        began = clock.thread_time()
        call()
        return clock.thread_time() - began

    return once


def _own(study: RouteStudy, solver: Explicit, record: Record) -> list[tuple]:
    """The explicit route: its compiled loop, and the call around it."""
    everything = "motion, friction, all efforts and reactions, all channels"
    count, first = record.time.size, record.time[:COUNTED]
    needed, complete = (
        counted_operations(solver, first, c)
        for c in (needed_channels(solver), range(len(solver.channels)))
    )
    study.remarks.append(
        f"explicit: operations are counted while its code runs the first {first.size} samples"
    )

    def loop() -> float:
        solver.rows(record.time)
        return solver.loop_s

    call = _timed(lambda: inverse_dynamics(solver.scene, time=record.time))
    return [
        (
            Route("explicit", f"{everything}; compiled loop", count, needed, complete, 0.0, 0.0),
            loop,
        ),
        (
            Route(
                "explicit, whole call", f"{everything}; inverse_dynamics, record in memory", count
            ),
            call,
        ),
    ]


def _multipliers(study: RouteStudy, record: Record, scene: Scene, progress) -> list[tuple]:
    """All bodies at once: numpy over all samples, and of it the linear solve alone, by LAPACK."""
    progress("multipliers")
    poses = pinocchio.states(scene, record)[:, :-1, :3]
    formula = dense_operations(len(scene.bodies), len(scene.joints))
    everything = Route(
        "multipliers", "motion, friction, all efforts and reactions; numpy", record.time.size
    )
    _agreement(
        everything, multipliers.inverse(scene, record.time, poses), record, scene, ideal=False
    )
    what = (
        "efforts and reactions in the plane of a given motion without friction: "
        f"{study.equations} equations, LAPACK"
    )
    solve = Route("multipliers, solve alone", what, record.time.size, formula)
    matrices, right, channels = dense_system(scene, record, poses)
    _agreement(solve, channels, record, scene)
    study.remarks.append(
        f"multipliers: operations by formula, turning points and inertia, LU factors of n = "
        f"{study.equations} and one "
        "solution; the time of the solve is that of numpy.linalg.solve on matrices that are there "
        "already"
    )
    return [
        (everything, _timed(lambda: multipliers.inverse(scene, record.time, poses))),
        (solve, _timed(lambda: np.linalg.solve(matrices, right))),
    ]


def _pinocchio(study: RouteStudy, record: Record, scene: Scene) -> list[tuple]:
    """Pinocchio, called from Python sample by sample."""
    try:
        model = pinocchio.Model(scene)
    except ValueError as reason:
        study.remarks.append(f"Pinocchio: {reason}")
        return []
    part = slice(None, None, math.ceil(record.time.size / IN_PYTHON))
    state = pinocchio.states(scene, record)
    outer = model.outer(state, pinocchio.applied(scene, record))[part]
    q, v, a = (x[part] for x in model.coordinates(state))
    solved = " frame Jacobians and a dense solve," if model.cuts else ""
    forces = " and cut forces" if model.cuts else ""
    short = Route(
        "Pinocchio",
        f"efforts{forces} of a given motion without friction: rnea,{solved} a loop in Python",
        len(q),
    )
    full = Route(
        "Pinocchio, reactions", "the same, and with a second rnea a sample all reactions", len(q)
    )
    channels = pinocchio.inverse(scene, record, model)
    for route in (short, full):
        _agreement(route, channels, record, scene)
    short.reactions = math.nan
    cut = outer + pinocchio.of_cuts(
        model, state[part], pinocchio.inverse_in_loop(model, q, v, a, outer)[1]
    )

    def both() -> None:
        pinocchio.inverse_in_loop(model, q, v, a, outer)
        pinocchio.reactions_in_loop(model, q, v, a, cut)

    study.remarks.append(
        f"Pinocchio {model.pin.__version__}: timed over {len(q)} samples; making its coordinates "
        f"and outer forces is "
        "left out of its time; much of that goes into the calls from Python, not into Pinocchio "
        "itself"
    )
    return [
        (short, _timed(lambda: pinocchio.inverse_in_loop(model, q, v, a, outer))),
        (full, _timed(both)),
    ]


# --- agreement
def _reactions_are_ideal(scene: Scene) -> bool:
    """True where friction leaves all reactions alone: it sits on driven joints only."""
    driven = [d.target for d in scene.drives]
    return all(j in driven for j in scene.rubbing_joints)


def _agreement(
    route: Route, channels: dict, record: Record, scene: Scene, ideal: bool = True
) -> None:
    """Note the largest differences of efforts and reactions; ideal: the joints have no friction."""
    efforts = {
        p: v
        for p, v in channels.items()
        if p.startswith("drives/") and p.endswith(("/torque", "/force"))
    }
    reactions = {
        p: v
        for p, v in channels.items()
        if p.startswith("joints/") and p.rpartition("/")[2] in REACTIONS
    }
    if ideal:
        efforts = {f"{p}_ideal" if f"{p}_ideal" in record else p: v for p, v in efforts.items()}
    route.efforts = largest_difference(efforts, record)
    if not ideal or _reactions_are_ideal(scene):
        route.reactions = largest_difference(reactions, record)


#: what a joint puts on its body b
REACTIONS = ("force_x", "force_y", "moment", "axial_force", "bending_x", "bending_y")


def largest_difference(channels: dict[str, np.ndarray], record: Record) -> float:
    """From the record's channels, over the largest value of all that have the same unit."""
    worst, shared = 0.0, [p for p in channels if p in record]
    for units in {record.units(p) for p in shared}:
        paths = [p for p in shared if record.units(p) == units]
        size = max(np.abs(record.values(p)).max() for p in paths)
        apart = max(np.abs(channels[p] - record.values(p)).max() for p in paths)
        share = float(apart / size) if size > 0.0 else math.inf if apart > 0.0 else 0.0
        worst = max(worst, math.inf if math.isnan(share) else share)
    return worst


def power_residual(scene: Scene, record: Record) -> np.ndarray:
    """Power of drives, gravity and all other loads that is neither inertia's nor lost in joints
    (samples,) [W].

    Everything stands in the record's channels; no difference quotient is taken.
    """
    state = pinocchio.states(scene, record)[:, :-1]
    power = (_unbalanced(scene, record, state) * state[..., 3:6]).sum(axis=(1, 2))
    power += sum(record.values(f"drives/{name}/power") for name in record.names("drives"))
    losses = [f"joints/{name}/power_loss" for name in record.names("joints")]
    return power - sum(record.values(p) for p in losses if p in record)


def _unbalanced(scene: Scene, record: Record, state: np.ndarray) -> np.ndarray:
    """Gravity and loads but drives, less inertia (samples, bodies, 3), in the plane."""
    resisting = np.array([(b.mass, b.mass, b.inertia) for b in scene.bodies])
    gravity = np.array([*scene.gravity[:2], 0.0])
    return pinocchio.applied(scene, record)[..., [0, 1, 5]] - resisting * (
        state[..., 6:9] - gravity
    )


# --- multipliers
def dense_system(
    scene: Scene, record: Record, poses: np.ndarray
) -> tuple[np.ndarray, np.ndarray, dict]:
    """Matrices J^T (samples, n, n) and right sides (samples, n, 1) of the multipliers, and the
    forces they give.

    The motion is the record's, friction is left out. The forces by the paths of its channels, those
    in the plane only.
    """
    pairs, state = Pairs(scene, assemble(scene)), pinocchio.states(scene, record)[:, :-1]
    geometry = Geometry(pairs, poses)
    right = -_unbalanced(scene, record, state).reshape(len(state), -1, 1)
    matrices = np.ascontiguousarray(geometry.rows[:, pairs.held].swapaxes(1, 2))
    relative = np.zeros((len(state), 3 * pairs.a.size))
    relative[:, pairs.held] = np.linalg.solve(matrices, right)[..., 0]
    force = (relative[:, 0::3] + 1j * relative[:, 1::3]) * geometry.axis
    channels = {}
    for i, joint in enumerate(scene.joints):
        here = f"joints/{joint.name}"
        channels |= {f"{here}/force_x": force[:, i].real, f"{here}/force_y": force[:, i].imag}
        if joint.slides:
            channels[f"{here}/moment"] = relative[:, 3 * i + 2]
    for drive, place in zip(pairs.drives, pairs.driven, strict=True):
        channels[f"drives/{drive.name}/{drive.effort_kind}"] = relative[:, place]
    return matrices, right, channels


def dense_operations(bodies: int, joints: int) -> Operations:
    """Of one solve for all multipliers of a known motion, n = 3 bodies equations, no zero of the
    matrix made use of.

    Of the assembly it counts only a sine and a cosine a body, the turning of two points a joint,
    mass times acceleration less gravity. Then come Gaussian elimination with the right side, and
    back substitution.
    """
    n = 3 * bodies
    pairs = (n - 1) * n * (2 * n - 1) // 6 + n * (n - 1)  # a multiplication and a subtraction each
    return Operations(
        pairs + 4 * joints + 2 * bodies,
        pairs + 8 * joints + 3 * bodies,
        n * (n + 1) // 2,
        2 * bodies,
    )


# --- operations of the explicit route
def needed_channels(solver: Explicit) -> list[int]:
    """Places of the efforts of drives and the reactions of joints among the channels."""
    wanted = {"drives": ("torque", "force"), "joints": REACTIONS}
    parts = [c.path.split("/") for c in solver.channels]
    return [i for i, (group, *_, name) in enumerate(parts) if name in wanted.get(group, ())]


def counted_operations(solver: Explicit, times: np.ndarray, channels: Iterable[int]) -> Operations:
    """Operations a sample of the code for some channels, counted while it runs in Python at growing
    times [s].

    Iterations count as often as they are made; changes of sign, comparisons and copies do not
    count.
    """
    structure, m, count = solver.structure, solver.mechanism, Counting()
    look = count.function("observe", observing(structure, channels))
    keep = count.function("commit", structure.texts["commit"])
    state, par, work = (
        [count.number(v) for v in x] for x in (m.y0, m.par, np.append(m.work0, 0.0))
    )
    out = [0.0] * len(solver.channels)
    for i, time in enumerate(times):
        way = time - times[i - 1] if i else 0.0
        stretches = (
            max(math.ceil(way * m.frequency / STRETCH), 1) if structure.layout.commits else 0
        )
        for k in range(1, stretches):
            keep(count.number(time - way + way * k / stretches), state, par, work, work)
        look(count.number(time), state, par, work, out)
        if structure.layout.commits:
            keep(count.number(time), state, par, work, work)
    return Operations(*(count.tally[kind] / len(times) for kind in KINDS))


def observing(structure: Structure, channels: Iterable[int]) -> str:
    """Text of the kernel that observes some channels only."""
    program = structure.programs["observe"]
    return kernel_text(replace(program, outputs={i: program.outputs[i] for i in channels}), {})


class Counting:
    """Runs the text of a kernel in plain Python on numbers that count what is done with them."""

    def __init__(self):
        self.tally: Counter = Counter()
        names = {
            "add": "additions",
            "sub": "additions",
            "mul": "multiplications",
            "truediv": "divisions",
        }
        methods = {
            f"__{side}{name}__": self._counted(kind, getattr(float, f"__{side}{name}__"))
            for name, kind in names.items()
            for side in ("", "r")
        }
        methods["__pow__"] = self._counted("functions", float.__pow__)
        methods |= {
            f"__{name}__": self._counted(None, getattr(float, f"__{name}__"))
            for name in ("neg", "abs")
        }
        self.number = type("Number", (float,), methods)
        tools = {
            n: f if isinstance(f, float) else self._counted("functions", f)
            for n, f in vars(math).items()
        }
        self.math = SimpleNamespace(**{n: f for n, f in tools.items() if not n.startswith("_")})

    def _counted(self, kind: str | None, plain: Callable) -> Callable:
        def method(*numbers):
            if kind is not None:
                self.tally[kind] += 1
            try:
                return self.number(plain(*numbers))
            except (ZeroDivisionError, ValueError):  # of a value that a condition then leaves out
                return self.number(math.nan)

        return method

    def function(self, name: str, text: str) -> Callable:
        """The function of a text."""
        scope = {"math": self.math}
        exec(text.replace("import math\n", ""), scope)  # noqa: S102
        return scope[name]


# --- showing
def table(study: RouteStudy) -> list[str]:
    """Time, operations and agreement of each route, as Markdown."""
    base = study.route("explicit")
    lines = [
        f"| {study.title}, {study.samples} samples | us a sample | x explicit | operations a "
        f"sample "
        "| efforts | reactions |",
        "|---|---|---|---|---|---|",
    ]
    for r in study.routes:
        ratio = "" if r is base else f"{r.per_sample / base.per_sample:.3g}"
        apart = " | ".join(
            "-" if math.isnan(d) or r is base else f"{d:.0e}" for d in (r.efforts, r.reactions)
        )
        lines.append(
            f"| {r.name} | {1e6 * r.per_sample:.3g} | {ratio} | {r.operations or '-'} | {apart} |"
        )
    return lines


def describe(study: RouteStudy) -> list[str]:
    """Notes to the table."""
    base, dense = study.route("explicit"), study.route("multipliers, solve")
    return [
        "Operations: additions + multiplications + divisions + functions (roots, sines) for "
        "efforts and reactions.",
        "Efforts, reactions: largest difference from the explicit route, over its largest value.",
        f"The explicit route needs {base.operations.total:.0f} operations from the time to efforts "
        f"and reactions "
        f"({base.output_operations.total:.0f} for all channels), one dense solve of a given motion "
        f"{dense.operations.total:.0f}: {dense.operations.total / base.operations.total:.2g} times "
        f"as many.",
        *(f"{r.name}: {r.computes}" for r in study.routes),
        *study.remarks,
    ]


def plain(study: RouteStudy) -> dict:
    """The study as one JSON document."""
    return {
        "title": study.title,
        "samples": study.samples,
        "equations": study.equations,
        "remarks": study.remarks,
        "routes": [
            {
                "name": r.name,
                "computes": r.computes,
                "samples": r.samples,
                "seconds_a_sample": r.per_sample,
                "repeats": r.seconds,
                "operations": _listed(r.operations),
                "output_operations": _listed(r.output_operations),
                "efforts_difference": None if math.isnan(r.efforts) else r.efforts,
                "reactions_difference": None if math.isnan(r.reactions) else r.reactions,
            }
            for r in study.routes
        ],
    }


def _listed(operations: Operations | None) -> dict | None:
    return operations and {
        **{kind: getattr(operations, kind) for kind in KINDS},
        "total": operations.total,
    }


def save(study: RouteStudy, folder: str | Path) -> Path:
    """Times of all repeats, operations and differences as HDF5, a group a route."""
    tables = {}
    for r in study.routes:
        facts = {
            "computes": r.computes,
            "samples": r.samples,
            "efforts": r.efforts,
            "reactions": r.reactions,
        }
        for name, counts in (
            ("operations", r.operations),
            ("output_operations", r.output_operations),
        ):
            facts |= {f"{name}_{kind}": number for kind, number in (_listed(counts) or {}).items()}
        tables[r.name] = (
            facts,
            {"seconds": ("s", "run time a sample, of each repeat", np.array(r.seconds))},
        )
    attributes = {
        "title": study.title,
        "samples": study.samples,
        "equations": study.equations,
        "remarks": "; ".join(study.remarks),
    }
    return save_tables(Path(folder) / "routes.h5", "clearance-inverse-routes", attributes, tables)


def picture(study: RouteStudy, path: str | Path) -> Path:
    """Time a sample of each route, logarithmic."""
    from clearance.postprocess.sheets import sheet
    from clearance.postprocess.study_pictures import COLOURS, GREYS, saved

    figure = sheet(8.0, 1.2 + 0.45 * len(study.routes))
    axes = figure.add_subplot()
    names, times = [r.name for r in study.routes], [1e6 * r.per_sample for r in study.routes]
    axes.barh(
        names, times, color=[COLOURS[0] if n.startswith("explicit") else GREYS[0] for n in names]
    )
    for i, r in enumerate(study.routes):
        label = f" {times[i]:.3g} us" + (
            f", {r.operations.total:.0f} operations" if r.operations else ""
        )
        axes.annotate(label, (times[i], i), va="center", fontsize=8)
    axes.set_xscale("log")
    axes.set_xlim(0.3 * min(times), 30.0 * max(times))
    axes.invert_yaxis()
    axes.set_xlabel("time a sample / us")
    axes.set_title(f"{study.title}, {study.samples} samples", fontsize=10)
    return saved(figure, path)
