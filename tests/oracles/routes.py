"""Routes of inverse dynamics side by side: run time, operations, agreement.

All routes are exact, so there is no error to trade time for. They get the same times and, where
they need it, the motion of the same record. What each computes differs and stands beside its time.
"""

import importlib.util
import math
import statistics
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from clearance.paper_figures.operation_counts import (
    REACTIONS,
    Operations,
    counted_operations,
    dense_operations,
    needed_channels,
)

from clearance.mechanism.assembly import assemble
from clearance.motions.inverse import inverse_dynamics
from clearance.motions.prescribed import Explicit
from clearance.results.record import Record
from clearance.scene.scene import Scene
from tests.oracles import multipliers, pinocchio
from tests.oracles.pairs import Geometry, Pairs

REPEATS = 7
ENOUGH = 3.0  # seconds after which a route is not repeated any more
IN_PYTHON = 1000  # samples at most of a loop in Python
COUNTED = 25  # samples over which operations are counted


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
    """The routes of a scene, and what has to be known of them."""

    routes: list[Route] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def route(self, start: str) -> Route:
        """The first route whose name starts so."""
        return next(r for r in self.routes if r.name.startswith(start))


def compare(scene: Scene, times: np.ndarray) -> RouteStudy:
    """Measure the routes of inverse dynamics at the same times [s], Pinocchio's where it is
    installed.

    Raises ValueError for scenes that inverse dynamics does not take, SimulationError where their
    motion ends.
    """
    record, solver = inverse_dynamics(scene, time=times), Explicit(scene)
    study = RouteStudy()
    timings = [*_explicit(study, solver, record), *_multipliers(study, record, scene)]
    if importlib.util.find_spec("pinocchio") is None:
        study.remarks.append("Pinocchio: not installed (pip install -e .[oracles])")
    else:
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
    for _ in range(REPEATS):  # in turn, so that all meet the same state of the machine
        for route, once in timings:
            if sum(route.seconds) * route.samples < ENOUGH:
                route.seconds.append(once() / route.samples)
    return study


def _timed(call: Callable[[], object]) -> Callable[[], float]:
    """A call that returns its CPU time [s]."""

    def once() -> float:
        began = clock.thread_time()
        call()
        return clock.thread_time() - began

    return once


def _explicit(study: RouteStudy, solver: Explicit, record: Record) -> list[tuple]:
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


def _multipliers(study: RouteStudy, record: Record, scene: Scene) -> list[tuple]:
    """All bodies at once: numpy over all samples, and of it the linear solve alone, by LAPACK."""
    poses = pinocchio.states(scene, record)[:, :-1, :3]
    formula = dense_operations(len(scene.bodies), len(scene.joints))
    everything = Route(
        "multipliers", "motion, friction, all efforts and reactions; numpy", record.time.size
    )
    _agreement(
        everything, multipliers.inverse(scene, record.time, poses), record, scene, ideal=False
    )
    label = (
        "efforts and reactions in the plane of a given motion without friction: "
        f"{3 * len(scene.bodies)} equations, LAPACK"
    )
    solve = Route("multipliers, solve alone", label, record.time.size, formula)
    matrices, right, channels = dense_system(scene, record, poses)
    _agreement(solve, channels, record, scene)
    study.remarks.append(
        f"multipliers: operations by formula, turning points and inertia, LU factors of n = "
        f"{3 * len(scene.bodies)} and one "
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
    for drive, pair in zip(pairs.drives, pairs.driven, strict=True):
        channels[f"drives/{drive.name}/{drive.effort_kind}"] = relative[:, pair]
    return matrices, right, channels
