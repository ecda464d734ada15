"""Film models from coarse to fine: error against run time, for single states and for a complete
run; mesh convergence.
"""

import math
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from clearance.files.texts import markdown
from clearance.film import bands, fem
from clearance.film.bearing import Bearing
from clearance.film.elastic import elastic_film
from clearance.film.moving import MovingFilm
from clearance.film.tabulated import table_film
from clearance.laws.law import BoundLaw, DataLaw, FilmJoint
from clearance.machine.store import KERNEL, address, caller, njit
from clearance.mechanism.build import build
from clearance.results.tables import columns_of, save_tables
from clearance.run.options import Solver, Span
from clearance.run.run import Run
from clearance.scene import joint_options
from clearance.scene.catalogue import find_case
from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import compiled

JOINT = FilmJoint(radius=0.01, clearance=1e-4, length=0.02, viscosity=0.05)  # of the feeder
STATES = 120
FAST = ((32, 4), (48, 6), (64, 8), (96, 12), (128, 16), (192, 24))
ELEMENTS = ((16, 2), (32, 4), (64, 8), (128, 16))
REFERENCE = (384, 48)
NODES = (9, 17, 33, 65)
SOLVERS = ("fast solver", "fast solver"), ("FEM", "finite elements")  # name and kind
RUN_RTOL, REFERENCE_RTOL = 1e-6, 1e-9
SAMPLES = 401
REPEATS = 5
#: the elastic film, here of a surface that hardly yields: what it costs, its way to the rigid one
STIFF = "elastic film, stiff", "elastic film", elastic_film(liner=1e-18, pressure_viscosity=0.0)
#: passes of a solver along all states, fewer once they took so long [s]; derivatives at every so
#: many states
PASSES, ENOUGH, EVERY = 3, 3.0, 4


@dataclass
class Rung:
    """One film model. seconds: of one force, or of one run; error_closing, error: largest relative
    force error of the states where the journal closes in, and the median of all. In a run both are
    the rms error of the journal's path over c.
    """

    name: str
    kind: str
    seconds: float
    error_closing: float
    error: float
    steps: int = 0
    slopes_seconds: float = math.nan  # of force and derivatives


@dataclass
class Ladder:
    """The rungs of single states and of a run."""

    states: list[Rung]
    runs: list[Rung]
    remarks: list[str] = field(default_factory=list)


# --- single states
def path() -> np.ndarray:
    """Neighbouring states (eps, d(eps)/dt, w), (STATES, 3): loops through eps 0.1 to 0.97, closing
    and opening.
    """
    t = np.linspace(0.0, 2.0 * math.pi, STATES, endpoint=False) + 0.013
    y = 1.8 + 1.6 * np.cos(3.0 * t)
    eps = -np.expm1(-y)
    s = np.sqrt(1.0 - eps**2)
    angle = 1.5 * (1.0 + np.sin(2.0 * t)) + 0.05
    return np.column_stack([eps, 30.0 * s * np.cos(angle), 60.0 * np.sin(angle) / eps])


def is_closing(states: np.ndarray) -> np.ndarray:
    """True where the scaled velocity points towards the wall."""
    return states[:, 1] > 0.0


def errors_of(forces: np.ndarray, wanted: np.ndarray, states: np.ndarray) -> tuple[float, float]:
    """Largest relative error of the force where the journal closes in, and the median of all."""
    errors = np.hypot(*(forces - wanted).T) / np.hypot(*wanted.T)
    return float(errors[is_closing(states)].max()), float(np.median(errors))


def compiled_law(law: BoundLaw, slopes: bool) -> tuple[Callable, np.ndarray, int]:
    """evaluate(arguments (t, n), numbers, values (t, m)) of a film law (of a formula or a table) as
    kernels have it; its numbers, and how many values it gives.
    """
    function = traced(law.law.function, law.law.kinds)
    function = function.slopes((0, 1, 2)) if slopes else function
    pointer, kernel_at = address(compiled(function), KERNEL), caller(KERNEL)

    @njit(error_model="numpy")
    def evaluate(arguments, par, values):
        for i in range(len(arguments)):
            kernel_at(pointer)(0.0, arguments[i], par, par, values[i])

    numbers = law.source(JOINT).numbers if isinstance(law.law, DataLaw) else np.zeros(1)
    return evaluate, np.asarray(numbers, float), function.count


def law_rung(name: str, kind: str, law: BoundLaw, states: np.ndarray, wanted: np.ndarray) -> Rung:
    """A law that kernels call, timed inside compiled code."""
    seconds, others = [], np.array([*JOINT, *law.numbers])
    many = np.tile(np.column_stack([states, np.tile(others, (len(states), 1))]), (50, 1))
    for slopes in (False, True):
        evaluate, numbers, count = compiled_law(law, slopes)
        values = np.zeros((len(many), count))
        evaluate(many, numbers, values)
        best = math.inf
        for _ in range(REPEATS):
            began = time.thread_time()
            evaluate(many, numbers, values)
            best = min(best, (time.thread_time() - began) / len(many))
        seconds.append(best)
    errors = errors_of(values[: len(states), :2], wanted, states)
    return Rung(name, kind, seconds[0], *errors, slopes_seconds=seconds[1])


def solver_rung(name: str, kind: str, film, states: np.ndarray, wanted: np.ndarray) -> Rung:
    """A solver called from Python along the path, so that it starts from the state before (the fast
    one does not).
    """
    passes: list[float] = []
    while len(passes) < PASSES and sum(passes) < ENOUGH:
        began = time.thread_time()
        forces = np.array([film.outputs(*state)[:2] for state in states])
        passes.append(time.thread_time() - began)
    began = time.thread_time()
    for state in states[::EVERY]:
        film.linearised(*state)
    slopes = (time.thread_time() - began) / len(states[::EVERY])
    return Rung(
        name,
        kind,
        min(passes) / len(states),
        *errors_of(forces, wanted, states),
        slopes_seconds=slopes,
    )


def single_states(progress: Callable[[str], None], quick: bool = False) -> list[Rung]:
    """All rungs at the states of `path`, in the feeder's bearing (L/D = 1)."""
    bearing, states = Bearing.of(JOINT), path()
    progress("reference")
    finest = bands.FastFilm(bearing, FAST[-1] if quick else REFERENCE)
    wanted = np.array([finest.outputs(*state)[:2] for state in states])
    rungs = []
    for name, kind, law in laws_by_cost(quick):
        progress(name)
        rungs.append(law_rung(name, kind, law, states, wanted))
    meshes = (FAST[:2], ELEMENTS[:2]) if quick else (FAST, ELEMENTS)
    for (solver, kind), make, of in zip(SOLVERS, (bands.FastFilm, MovingFilm), meshes, strict=True):
        for mesh in of:
            name = f"{solver} {mesh[0]}x{mesh[1]}"
            progress(name)
            rungs.append(solver_rung(name, kind, make(bearing, mesh), states, wanted))
    return rungs


def laws_by_cost(quick: bool) -> Iterator[tuple[str, str, BoundLaw]]:
    """Films that kernels call, coarse to fine: name, kind, law."""
    for name in ("pinkus_sternlicht", "long", "short", "harmonic"):
        yield name, "closed form", joint_options.FILMS[name]()
    for nodes in NODES[:3] if quick else NODES:
        yield f"table {nodes}x{nodes}", "table", table_film(nodes=nodes)
    if not quick:
        yield STIFF


# --- a complete run
def whole_runs(turns: float, progress: Callable[[str], None], quick: bool = False) -> list[Rung]:
    """The feeder with each film: time of the integration, distance of the journal's path from the
    finest table's.
    """
    case = find_case("six_bar_feeder")
    reference = journal(
        with_film(case, table_film(nodes=65, mesh=(64, 8) if quick else (128, 16))),
        turns,
        REFERENCE_RTOL,
    )[0]
    films = list(laws_by_cost(quick))
    meshes = ((), ELEMENTS[:1]) if quick else (FAST[:2], ELEMENTS[:2])
    for (solver, kind), law, of in zip(SOLVERS, ("fast", "fem"), meshes, strict=True):
        make = joint_options.ONLINE_FILMS[law]
        films += [(f"{solver} {mesh[0]}x{mesh[1]}", kind, make(mesh=mesh)) for mesh in of]
    rungs = []
    for name, kind, law in films:
        progress(f"run with {name}")
        moved, seconds, steps = journal(with_film(case, law), turns, RUN_RTOL)
        error = float(np.sqrt(((moved - reference) ** 2).sum(axis=1).mean()))
        rungs.append(Rung(name, kind, seconds, error, error, steps))
    return rungs


def with_film(case, law: BoundLaw):
    def filled(part):
        return replace(part, film=law) if getattr(part, "film", None) is not None else part

    return case.scene().rebuilt(element=filled)


def journal(scene, turns: float, rtol: float) -> tuple[np.ndarray, float, int]:
    """Path of the journal over c, CPU seconds of the compiled loop (warm), steps."""
    mechanism = build(scene, ledger=False)
    joint, offsets = next(iter(mechanism.offsets.items()))
    seconds: list[float] = []
    while len(seconds) < 2 or len(seconds) < REPEATS + 1 and sum(seconds) < 2.0:
        run = Run(mechanism, Span(turns * scene.turn, SAMPLES), Solver(rtol), outputs=False)
        _, rows, _ = run.trajectory()
        seconds.append(run.cpu)
    steps = int(run.state.steps)
    return rows[:, offsets] / joint.clearance, statistics.median(seconds[1:]), steps


def ladder(
    turns: float = 1.0, quick: bool = False, progress: Callable[[str], None] = lambda text: None
) -> Ladder:
    """The entire film ladder."""
    remarks = [
        f"single states: {STATES} on a path through eps 0.1 to 0.97 in a bearing of L/D = 1; "
        f"reference the fast solver "
        f"on {REFERENCE[0]}x{REFERENCE[1]}, extrapolated (finite elements, another method, come "
        f"within 2e-5); "
        "finite elements start from the state before",
        f"runs: the feeder, {turns:g} turn(s), rtol {RUN_RTOL:g}; reference the table of 65 x 65 "
        f"nodes at rtol "
        f"{REFERENCE_RTOL:g}; error: rms of the journal's path over the clearance",
    ]
    return Ladder(single_states(progress, quick), whole_runs(turns, progress, quick), remarks)


# --- mesh convergence
@dataclass
class Mesh:
    """One mesh of one solver: relative error of the force, its order against the mesh before, cost
    of one film.
    """

    solver: str
    mesh: str
    unknowns: int
    error: float
    order: float
    seconds: float


CONVERGENCE_STATES = ((0.5, 20.0, 40.0), (0.8, 5.0, 30.0), (0.9, 0.0, 60.0), (0.9, 10.0, 0.0))


def convergence(
    bearing: Bearing, states=CONVERGENCE_STATES, progress: Callable[[str], None] = lambda text: None
) -> list[Mesh]:
    """Error of the force (rms over states) as the meshes are halved, for the fast solver and finite
    elements.
    """
    finest = bands.FastFilm(bearing, REFERENCE)
    wanted = np.array([finest.outputs(*state)[:2] for state in states])
    points: list[Mesh] = []
    for solver, meshes, film in (
        (
            "fast solver, one grid",
            [(c, r) for c, r in zip((17, 33, 65, 129), (3, 5, 9, 17), strict=True)],
            None,
        ),
        ("fast solver, extrapolated", ((48, 6), (96, 12), (192, 24)), bands.FastFilm),
        ("finite elements", ELEMENTS, fem.FemFilm),
    ):
        last = None
        for mesh in meshes:
            progress(f"{solver} {mesh}")
            oil_film = (film or bands.FastFilm)(bearing, mesh)
            oil_film.solve(*states[0])  # warm
            began = time.thread_time()
            solutions = [oil_film.solve(*state) for state in states]
            seconds = (time.thread_time() - began) / len(states)
            forces = np.array([(s.radial, s.tangential) for s in solutions])
            each = np.hypot(*(forces - wanted).T) / np.hypot(*wanted.T)
            error = float(np.sqrt((each**2).mean()))
            order = math.log(last[0] / error) / math.log(mesh[0] / last[1]) if last else math.nan
            points.append(
                Mesh(solver, f"{mesh[0]}x{mesh[1]}", solutions[0].unknowns, error, order, seconds)
            )
            last = error, mesh[0]
    return points


# --- reports
def table(study: Ladder) -> list[str]:
    """Both halves as Markdown."""
    of_states = "film, single states", "a force", "with derivatives"
    states = (
        (
            r.name,
            *map(_time, (r.seconds, r.slopes_seconds)),
            f"{r.error_closing:.1e}",
            f"{r.error:.1e}",
        )
        for r in study.states
    )
    of_runs = "film, feeder run", "CPU time", "steps", "a step", "error of the journal's path"
    runs = (
        (r.name, _time(r.seconds), r.steps, _time(r.seconds / max(r.steps, 1)), f"{r.error:.1e}")
        for r in study.runs
    )
    heads = *of_states, "error, closing in", "median error"
    return [*markdown(heads, states), "", *markdown(of_runs, runs)]


def _time(seconds: float) -> str:
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")):
        if seconds * factor >= 1.0 or unit == "ns":
            return f"{seconds * factor:.3g} {unit}"
    raise AssertionError


def describe(study: Ladder) -> list[str]:
    return [
        *study.remarks,
        "times: one core, smallest of repeats (runs: median), warm; solvers that take 3 s for all "
        "states pass once",
    ]


def plain(study: Ladder) -> dict:
    """The ladder as one JSON document."""
    return {"states": [asdict(r) for r in study.states], "runs": [asdict(r) for r in study.runs]}


def save(study: Ladder, folder: str | Path) -> Path:
    """The ladder as HDF5."""
    about = {
        "name": ("1", "film"),
        "kind": ("1", "kind of film"),
        "seconds": ("s", "of one force, or one run"),
        "error_closing": ("1", "largest relative force error, closing in"),
        "error": ("1", "median force error, or rms of the path over c"),
        "steps": ("1", "steps of the run"),
    }
    rungs = {"states": study.states, "runs": study.runs}
    tables = {group: ({}, columns_of(rows, about)) for group, rows in rungs.items()}
    return save_tables(
        Path(folder) / "film_ladder.h5",
        "clearance-film-ladder",
        {"remarks": "; ".join(study.remarks)},
        tables,
    )


def convergence_table(meshes: list[Mesh]) -> list[str]:
    """The mesh study as Markdown."""
    heads = "solver", "mesh", "unknowns", "error of the force", "order", "a film"
    orders = ["-" if math.isnan(m.order) else f"{m.order:.1f}" for m in meshes]
    rows = (
        (m.solver, m.mesh, m.unknowns, f"{m.error:.1e}", order, _time(m.seconds))
        for m, order in zip(meshes, orders, strict=True)
    )
    return markdown(heads, rows)


def save_convergence(meshes: list[Mesh], folder: str | Path) -> Path:
    """The mesh study as HDF5."""
    about = {
        "solver": ("1", "solver"),
        "mesh": ("1", "cells around x over half the length"),
        "unknowns": ("1", "unknowns"),
        "error": ("1", "relative error of the force"),
        "seconds": ("s", "of one film"),
    }
    path, kind = Path(folder) / "film_convergence.h5", "clearance-film-convergence"
    return save_tables(path, kind, {}, {"meshes": ({}, columns_of(meshes, about))})
