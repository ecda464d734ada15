"""The stress matrix: extremes over the cases.

Each cell is done, with residuals, or stops for a named reason.

A row is an extreme, a column a case with one model of its joints. Cells run in worker processes,
with a budget of steps and of time. If one brings its process down, the others are run again without
it.
"""

import dataclasses
import math
import multiprocessing
import os
import re
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from clearance.elements import Drive, Prismatic, Revolute
from clearance.elements.body import Body, ground
from clearance.elements.joint import Joint
from clearance.files.texts import markdown
from clearance.results.result import Result
from clearance.results.tables import columns_of, save_tables
from clearance.run.interrupts import end_groups, follow_parent
from clearance.scene.catalogue import find_case
from clearance.scene.scene import Scene
from clearance.simulation import SimulationError, simulate
from clearance.values.units import rpm

STEP_BUDGET = 10_000_000
TIME_BUDGET = 60.0  # CPU seconds a cell
TURNS = 2.0
RANDOM_SCENES = 12

MODELS = ("lubricated", "dry", "mixed")
CASES = ("six_bar_feeder", "slider_crank", "four_bar")
ALL_JOINTS = {"six_bar_feeder": "A,B,C,D,E,F", "four_bar": "A,B,C,D"}
WHEN = re.compile(r"at t = |from t = ")


@dataclass(frozen=True)
class Cell:
    """One run of the matrix: what is extreme about it, and how."""

    row: str
    case: str
    model: str
    parameters: dict = field(default_factory=dict)
    # fields of every clearance joint; eccentricity as a ratio
    joint: dict = field(default_factory=dict)
    laws: dict = field(default_factory=dict)  # parameters of every contact law
    masses: float = 1.0  # mass ratio of the lightest to the heaviest body
    gravity: tuple[float, float] | None = None
    rtol: float = 1e-6
    turns: float = TURNS
    seed: int | None = None

    @property
    def column(self) -> str:
        return f"{self.case} {self.model}"

    def scene(self) -> Scene:
        if self.case == "random":
            return random_scene(self.seed, self.model)
        scene = find_case(self.case).scene(model=self.model, **self.parameters)
        return altered(scene, self.joint, self.laws, self.masses, self.gravity)


@dataclass(frozen=True)
class Verdict:
    """Outcome of a cell. kind: done, named (a stated reason), or fault (a crash, a NaN, a hang:
    never allowed).
    """

    row: str
    column: str
    kind: str
    reason: str = ""
    energy: float = math.nan  # largest residual over the energy turned over in a stretch
    closure: float = math.nan  # largest gap of a joint's points over the mechanism's size
    seconds: float = 0.0
    steps: int = 0
    contacts: int = 0
    warnings: tuple[str, ...] = ()


# --- the matrix
def matrix(case: str | None = None, quick: bool = False) -> list[Cell]:
    """All cells, or those of one case; `quick` takes a seventh of them and shorter runs."""
    cells = [c for c in [*_cells(), *_random_cells()] if case is None or c.case == case]
    if not cells:
        names = ", ".join([*CASES, "random"])
        raise ValueError(f"the stress matrix has {names}; got {case!r}")
    if quick:
        cells = [dataclasses.replace(c, turns=min(c.turns, 0.5)) for c in cells[::7]]
    return cells


def _cells() -> Iterator[Cell]:
    both = {
        "c 1 um": {"clearance": 1e-6},
        "c 1 mm": {"clearance": 1e-3},
        "30 rpm": {"speed": rpm(30)},
        "12000 rpm": {"speed": rpm(12000)},
        "12000 rpm, c 1 um": {"speed": rpm(12000), "clearance": 1e-6},
    }
    for case in CASES:
        for model in MODELS:
            yield Cell("as it comes", case, model)
            for row, parameters in both.items():
                yield Cell(row, case, model, smoothed(model, parameters))
            if case in ALL_JOINTS:
                yield Cell("all joints", case, model, {"joints": ALL_JOINTS[case]})
                yield Cell(
                    "all joints, 12000 rpm",
                    case,
                    model,
                    {"joints": ALL_JOINTS[case], "speed": rpm(12000)},
                )
            yield Cell("no gravity", case, model, gravity=(0.0, 0.0))
            yield Cell("mass ratio 1e4", case, model, masses=1e-4)
            yield Cell("rtol 1e-1", case, model, rtol=1e-1)
            yield Cell("rtol 1e-3", case, model, rtol=1e-3)
            yield Cell("rtol 1e-12", case, model, rtol=1e-12, turns=1.0)
            yield Cell("1000 turns", case, model, rtol=1e-4, turns=1000.0)
            yield Cell("start at 0.9999 c", case, model, joint={"eccentricity": 0.9999})
            yield Cell("start at 1.01 c", case, model, joint={"eccentricity": 1.01})
            yield from _dry(case) if model == "dry" else _oiled(case, model)


def _oiled(case: str, model: str) -> Iterator[Cell]:
    yield Cell("viscosity 1e-4", case, model, {"viscosity": 1e-4})
    yield Cell("viscosity 10", case, model, {"viscosity": 10.0})
    yield Cell(
        "viscosity 1e-4, 12000 rpm, c 1 mm",
        case,
        model,
        {"viscosity": 1e-4, "speed": rpm(12000), "clearance": 1e-3},
    )
    narrow = {"viscosity": 10.0, "speed": rpm(30), "clearance": 1e-6}
    yield Cell("viscosity 10, 30 rpm, c 1 um", case, model, smoothed(model, narrow))


def smoothed(model: str, parameters: dict) -> dict:
    """Surfaces of a mixed joint with a clearance of 1 um must be smoother than usual."""
    if model == "mixed" and parameters.get("clearance") == 1e-6:
        return parameters | {"roughness": 5e-8}
    return parameters


def _dry(case: str) -> Iterator[Cell]:
    yield Cell("stiffness 1e13", case, "dry", laws={"stiffness": 1e13})
    yield Cell("restitution 0", case, "dry", {"restitution": 0.0})
    yield Cell("restitution 1", case, "dry", {"restitution": 1.0})


def _random_cells() -> Iterator[Cell]:
    for seed in range(RANDOM_SCENES):
        yield Cell(f"random scene {seed}", "random", MODELS[seed % len(MODELS)], seed=seed)


# --- scenes
def altered(scene: Scene, changes: dict, laws: dict, masses: float, gravity) -> Scene:
    """A scene with other numbers: bodies get masses from 1 down to `masses` of theirs.

    `changes` are fields of clearance joints (eccentricity as a ratio), `laws` parameters of their
    contact laws.
    """
    count = max(len(scene.bodies) - 1, 1)
    share = {b.name: masses ** (i / count) for i, b in enumerate(scene.bodies)}
    loose = {j.key for j in scene.clearance_joints}

    def body(b: Body) -> Body:
        return dataclasses.replace(
            b, mass=b.mass * share[b.name], inertia=b.inertia * share[b.name]
        )

    def joint(j: Joint) -> Joint:
        if j.key not in loose:
            return j
        values = dict(changes)
        if "eccentricity" in values:
            values["eccentricity"] = tuple(
                k * values["eccentricity"] * j.clearance for k in (0.6, -0.8)
            )
        if laws and j.contact is not None:
            values["contact"] = j.contact.law(**(j.contact.parameters | laws))
        return dataclasses.replace(j, **values)

    return scene.rebuilt(body=body, element=joint, gravity=gravity)


def random_scene(seed: int, model: str) -> Scene:
    """A crank-rocker or slider-crank of random proportions, masses, clearances, speed and laws;
    always assemblable.
    """
    from clearance.scene.joint_options import JointOptions

    rng = np.random.default_rng(seed)

    def spread(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    size, slides = spread(0.02, 0.5), bool(rng.integers(2))
    crank_length = size * rng.uniform(0.1, 0.45)
    mass = [spread(1e-2, 10.0) for _ in range(3)]
    crank, rod, last = (
        Body(
            name,
            m,
            m * (size / 3.0) ** 2,
            points={"a": (0, 0), "b": (length, 0)},
            com=(0.5 * length, 0.0),
            angle=angle,
        )
        for name, m, length, angle in zip(
            ("crank", "rod", "last"),
            mass,
            (crank_length, size, 0.9 * size),
            (0.7, 0.1, 1.2),
            strict=True,
        )
    )
    names = [n for n in "BC" if rng.integers(2)] or ["C"]
    clearance = spread(2e-6, 5e-4)
    radius = max(0.05 * size, 3.0 * clearance)
    contact, friction = (
        str(rng.choice(c))
        for c in (("lankarani_nikravesh", "hunt_crossley_memoryless"), ("none", "coulomb"))
    )
    options = JointOptions(
        joints=names,
        model=model,
        clearance=clearance,
        viscosity=spread(1e-3, 1.0),
        restitution=float(rng.uniform(0.0, 1.0)),
        contact=contact,
        friction=friction,
        friction_coefficient=float(rng.uniform(0.0, 0.3)),
        film="pinkus_sternlicht",
        roughness=0.01 * clearance,
    )
    factory = options.factory(("B", "C"), radius=radius, length=0.05 * size)
    joints = [
        Revolute(ground, crank["a"], name="A"),
        factory("B", crank["b"], rod["a"]),
        factory("C", rod["b"], last["b"]),
    ]
    if slides:
        joints.append(Prismatic(ground, last["b"], name="guide", angle=0.0))
    else:
        joints.append(Revolute(ground.at(size, 0.0), last["a"], name="D"))
    return Scene(*joints, Drive(crank, speed=rpm(spread(30.0, 6000.0))), name=f"random_{seed}")


# --- running
class OutOfTime(Exception):
    """A cell used up its time."""


def judge(cell: Cell) -> Verdict:
    """Run one cell; whatever happens becomes a verdict."""
    began = time.thread_time()

    def watch(share: float) -> None:
        if time.thread_time() - began > TIME_BUDGET:
            raise OutOfTime(
                f"{share:.1%} of {cell.turns:g} turns done after {TIME_BUDGET:g} s of CPU"
            )

    def verdict(kind: str, reason: str = "", **more) -> Verdict:
        return Verdict(
            cell.row, cell.column, kind, reason, seconds=time.thread_time() - began, **more
        )

    try:
        result = simulate(
            cell.scene(),
            turns=cell.turns,
            rtol=cell.rtol,
            max_steps=STEP_BUDGET,
            samples_per_turn=100,
            progress=watch,
            error=None,
        )
    except SimulationError as error:
        named = bool(WHEN.search(str(error)))
        return verdict("named" if named else "fault", str(error), **_numbers(error.result))
    except OutOfTime as error:
        return verdict("named", f"out of time: {error}")
    except (ValueError, TypeError) as error:
        return verdict("named", f"wrong input: {error}")
    except Exception as error:
        return verdict("fault", f"{type(error).__name__}: {error}")
    numbers = _numbers(result)
    if not numbers["finite"]:
        return verdict("fault", "a number in the result is not finite", **numbers)
    numbers.pop("finite")
    return verdict("done", **numbers)


def _numbers(result: Result | None) -> dict:
    if result is None:
        return {}
    finite = True

    def look(name, data):
        nonlocal finite
        if hasattr(data, "shape") and data.dtype.kind == "f":
            finite = finite and bool(np.isfinite(data[()]).all())

    result.file.visititems(look)
    solver = result.solver
    numbers = {
        "energy": float(solver["energy_residual_share"]),
        "closure": closure(result),
        "steps": int(solver["steps"]),
        "contacts": len(result.file["events/time"]),
        "warnings": tuple(result.warnings),
        "finite": finite,
    }
    if not result.complete:
        numbers.pop("finite")
    result.close()
    return numbers


def closure(result: Result) -> float:
    """Largest distance of two points that a joint holds together (less its eccentricity), over the
    largest position.
    """
    scene = result.scene
    centres = {b["name"]: b["com"] for b in scene["bodies"]} | {"ground": (0.0, 0.0)}
    worst, size = 0.0, 1e-300

    def position(point):
        if point["body"] == "ground":
            return point["x"], point["y"]
        body = result[point["body"]]
        x, y = point["x"] - centres[point["body"]][0], point["y"] - centres[point["body"]][1]
        c, s = np.cos(body.theta), np.sin(body.theta)
        return body.x + c * x - s * y, body.y + s * x + c * y

    for joint in scene["joints"]:
        (ax, ay), (bx, by) = position(joint["a"]), position(joint["b"])
        size = max(size, float(np.max(np.abs([ax, ay]))))
        if joint["type"] == "Prismatic":
            continue
        ex = ey = 0.0
        if joint["type"] == "ClearanceRevolute":
            channels = result.joint(joint["name"])
            ex, ey = channels.eccentricity_x, channels.eccentricity_y
        if np.size(bx - ax):
            worst = max(worst, float(np.max(np.hypot(bx - ax - ex, by - ay - ey))))
    return worst / size


def stress(
    case: str | None = None,
    *,
    quick: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int, str], None] = lambda done, total, name: None,
) -> list[Verdict]:
    """Run the matrix, each cell in one of `workers` processes; verdicts in the order of the
    cells.
    """
    cells = matrix(case, quick)
    verdicts: dict[int, Verdict] = {}

    def run(todo: list[int], processes: int) -> None:
        """Judge cells in a pool of their own; those whose pool broke are left out."""
        context = multiprocessing.get_context("spawn")
        before, count = set(multiprocessing.active_children()), min(processes, len(todo))
        with ProcessPoolExecutor(count, context, follow_parent) as pool:
            futures = {pool.submit(judge, cells[i]): i for i in todo}
            try:
                for future in as_completed(futures):
                    i = futures[future]
                    try:
                        verdicts[i] = future.result()
                    except BrokenProcessPool:
                        continue
                    progress(len(verdicts), len(cells), f"{cells[i].column}, {cells[i].row}")
            except BaseException:
                end_groups(set(multiprocessing.active_children()) - before)
                raise

    run(list(range(len(cells))), workers or os.cpu_count() or 1)
    for i in [i for i in range(len(cells)) if i not in verdicts]:  # a process died: who was it?
        run([i], 1)
        if i not in verdicts:
            verdicts[i] = Verdict(cells[i].row, cells[i].column, "fault", "its process died")
    return [verdicts[i] for i in range(len(cells))]


# --- showing
def _short(v: Verdict) -> str:
    if v.kind == "done":
        return f"{v.energy:.0e}"
    return {"named": "stops", "fault": "FAULT"}[v.kind]


def table(verdicts: list[Verdict]) -> list[str]:
    """The matrix as Markdown: energy residual share of what was done, or the number of a reason
    below the table.
    """
    rows = list(dict.fromkeys(v.row for v in verdicts if "random" not in v.row))
    columns = list(dict.fromkeys(v.column for v in verdicts if "random" not in v.row))
    cells = {(v.row, v.column): v for v in verdicts}
    reasons: list[str] = []

    def shown(v: Verdict | None) -> str:
        if v is None:
            return ""
        if v.kind == "done":
            return _short(v)
        reasons.append(f"[{len(reasons) + 1}] {v.column}, {v.row}: {v.reason}")
        return f"{_short(v)} [{len(reasons)}]"

    lines = []
    if rows:
        table = ((r, *(shown(cells.get((r, c))) for c in columns)) for r in rows)
        lines = markdown(("energy residual", *columns), table)
    random = [v for v in verdicts if "random" in v.row]
    if random:
        lines += ["", "Random scenes: " + ", ".join(shown(v) for v in random)]
    closures = [v.closure for v in verdicts if v.kind == "done"]
    done = sum(v.kind == "done" for v in verdicts)
    named, faults = (sum(v.kind == kind for v in verdicts) for kind in ("named", "fault"))
    closed = f"joints closed to {max(closures, default=0):.0e} of the mechanism's size"
    lines += [
        "",
        f"{done} of {len(verdicts)} done, {named} with a named reason, {faults} faults; {closed}.",
    ]
    return lines + [""] * bool(reasons) + [f"- {r}" for r in reasons]


def save(verdicts: list[Verdict], folder: str | Path) -> Path:
    """All verdicts as one HDF5 table."""
    names = {
        "row": ("1", "what is extreme"),
        "column": ("1", "case, model"),
        "kind": ("1", "done, named or fault"),
        "reason": ("1", "why it stopped"),
        "energy": ("1", "largest residual over the energy turned over"),
        "closure": ("1", "largest gap of a joint over the mechanism's size"),
        "seconds": ("s", "CPU time"),
        "steps": ("1", "accepted steps"),
        "contacts": ("1", "contacts"),
    }
    cells = columns_of(verdicts, names)
    return save_tables(Path(folder) / "stress.h5", "clearance-stress", {}, {"cells": ({}, cells)})
