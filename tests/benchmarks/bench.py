"""Costs of the parts: `python tests/benchmarks/bench.py [--update]`.

Prints a table of the page beside this file. Times are medians of repeats on whatever machine runs
this; ratios compare two things measured in turn in one run. CPU seconds are of complete fresh
processes.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
from publishing import publish, require

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))

from clearance.paper_figures import ablation, film_ladder  # noqa: E402
from clearance.paper_figures.peers import dispatched  # noqa: E402

import clearance as cl  # noqa: E402
from clearance.film import bands  # noqa: E402
from clearance.film.bearing import Bearing  # noqa: E402
from clearance.film.moving import MovingFilm  # noqa: E402
from clearance.film.table import Key  # noqa: E402
from clearance.machine.store import KERNEL, address, caller, njit  # noqa: E402
from clearance.mechanism.build import build  # noqa: E402
from clearance.run.options import Solver, Span  # noqa: E402
from clearance.run.run import Run  # noqa: E402
from clearance.scene import joint_options  # noqa: E402
from clearance.scene.catalogue import find_case  # noqa: E402
from clearance.stepping import status  # noqa: E402
from clearance.tracing.interpreter import traced  # noqa: E402
from clearance.tracing.kernels import compiled  # noqa: E402
from tests.augmented import Augmented, augmented  # noqa: E402

MARK = "<!-- benchmark table -->"
JOINTS = ("B", "B,C", "B,C,E", "A,B,C,D,E,F")
REPEATS = 7


@njit
def own_calls(rhs, y, par, work, out, count):
    for _ in range(count):
        rhs(0.0, y, par, work, out)


@njit
def reference_calls(q, v, mass, gravity, rows, numbers, size, count):
    total = 0.0
    for _ in range(count):
        total += augmented(q, v, mass, gravity, rows, numbers, size)[0]
    return total


def per_call(function, count):
    began = time.perf_counter()
    function(count)
    return (time.perf_counter() - began) / count * 1e9


def state_of(scene):
    """Some state off the start: eccentric journals that move."""
    mechanism = build(scene, ledger=False)
    rng = np.random.default_rng(1)
    y = mechanism.y0 + 0.4 * mechanism.scale * rng.uniform(-1.0, 1.0, mechanism.y0.size)
    out = np.zeros(len(mechanism.layout.channels))
    mechanism.kernel("observe")(0.0, y, mechanism.par, np.append(mechanism.work0, 0.0), out)
    row = {c.path: v for c, v in zip(mechanism.layout.channels, out, strict=True)}
    q = np.array([row[f"bodies/{b.name}/{n}"] for b in scene.bodies for n in ("x", "y", "theta")])
    v = np.array([row[f"bodies/{b.name}/{n}"] for b in scene.bodies for n in ("vx", "vy", "omega")])
    a = np.array([row[f"bodies/{b.name}/{n}"] for b in scene.bodies for n in ("ax", "ay", "alpha")])
    return mechanism, y, q, v, a


def right_hand_sides():
    """One evaluation against a dense augmented (multiplier) evaluation of the same scene, LAPACK in
    numba.
    """
    yield (
        "| six-bar feeder, lubricated joints | one right-hand side | dense multipliers | ratio | "
        "largest difference |"
    )
    yield "|---|---|---|---|---|"
    for joints in JOINTS:
        scene = cl.load_case("six_bar_feeder", joints=joints, film="pinkus_sternlicht")
        mechanism, y, q, v, a = state_of(scene)
        ref = Augmented(scene)
        difference = np.abs(ref.accelerations(q, v)[: q.size] - a).max() / np.abs(a).max()
        out, work = np.zeros(y.size), np.append(mechanism.work0, 0.0)
        rhs = dispatched(mechanism.kernel("rhs"))

        def ours(count, rhs=rhs, y=y, par=mechanism.par, work=work, out=out):
            own_calls(rhs, y, par, work, out, count)

        def dense(count, ref=ref, q=q, v=v):
            reference_calls(q, v, ref.mass, ref.gravity, ref.rows, ref.numbers, ref.count, count)

        ours(10), dense(10)
        pairs = [(per_call(ours, 100_000), per_call(dense, 5_000)) for _ in range(REPEATS)]
        mine, theirs = (statistics.median(p[i] for p in pairs) for i in range(2))
        ratio = statistics.median(b / m for m, b in pairs)
        yield f"| {joints} | {mine:.0f} ns | {theirs:.0f} ns | {ratio:.0f} | {difference:.0e} |"
        require(
            ratio >= 20.0 or "," in joints,
            f"{joints}: only {ratio:.0f} times cheaper than dense multipliers",
        )
        require(difference <= 1e-12, f"{joints}: {difference:.0e} away from dense multipliers")


def eccentricities(result):
    """Eccentricity ratios of all clearance joints along a run."""
    scene = json.loads(result.attributes["scene"])
    joints = {
        j["name"]: j["clearance"] for j in scene["joints"] if j["type"] == "ClearanceRevolute"
    }
    return np.stack([result.joint(n).eccentricity / c for n, c in joints.items()])


def runs():
    """Integration time, accuracy and energy residual of complete runs."""
    yield (
        "| two turns, warm | rtol | integration | steps | error / clearance | energy residual / "
        "turned over |"
    )
    yield "|---|---|---|---|---|---|"
    cases = {
        "feeder, lubricated B": ("six_bar_feeder", {"joints": "B"}),
        "feeder, lubricated B, C, E": ("six_bar_feeder", {"joints": "B,C,E"}),
        "feeder, dry B, frictionless": (
            "six_bar_feeder",
            {"joints": "B", "model": "dry", "friction": "none"},
        ),
        "slider-crank, lubricated, 0.04 Pa s": (
            "slider_crank",
            {"model": "lubricated", "viscosity": 0.04},
        ),
    }
    for name, (case, options) in cases.items():
        film = options.get("model") != "dry"
        truth = eccentricities(
            cl.simulate(cl.load_case(case, **options), turns=2, rtol=1e-12, samples_per_turn=100)
        )
        for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
            computed = []
            for _ in range(REPEATS):
                result = cl.simulate(
                    cl.load_case(case, **options), turns=2, rtol=rtol, samples_per_turn=100
                )
                computed.append(result.solver["wall_s"] * 1e3)
                residual = (
                    np.abs(result.energy.residual).max()
                    / result.file["energy"].attrs["turned_over"]
                )
                steps = result.solver["steps"]
                error = np.abs(eccentricities(result) - truth).max()
                result.close()
            require(
                rtol > 1e-9 or residual < 1e-8,
                f"{name}: energy residual {residual:.0e} at rtol {rtol:.0e}",
            )
            shown = f"{error:.0e}" if film else "-"
            cost = f"{statistics.median(computed):.1f} ms"
            yield f"| {name} | {rtol:.0e} | {cost} | {steps} | {shown} | {residual:.0e} |"


def compiled_law(law, active, state):
    """(value, value and Jacobian) of a bound law as compiled functions of the index of a call."""
    result, function, kernel_at = [], traced(law.law.function, law.law.kinds), caller(KERNEL)
    numbers = [x for v in state[1:] for x in (v if isinstance(v, tuple) else (v,))]
    for one in (function, function.slopes(tuple(range(active)))):
        pointer, size = address(compiled(one), KERNEL), one.count

        @njit(error_model="numpy")
        def calls(count, first, others, pointer=pointer, size=size):
            total, out, inputs = 0.0, np.empty(size), np.append(first, others)
            for i in range(count):
                inputs[0] = first * (1.0 + 1e-9 * i)
                kernel_at(pointer)(0.0, inputs, others, others, out)
                total += out.sum()  # all are used: none is left out
            return total

        result.append((calls, state[0], np.array([*numbers, *law.numbers])))
    return result


def law_costs():
    """Time of one evaluation of each law, and of its values with the exact Jacobian, at a state of
    the feeder.
    """
    facts = cl.laws.FilmJoint(0.01, 1e-4, 0.02, 0.05, 0.8e-6)
    pair = joint_options.Pair(0.01, 1e-4, 0.02, cl.steel)
    cases = {
        f"film {n}": (law(), (0.7, 20.0, 40.0, facts), 3)
        for n, law in joint_options.FILMS.items()
        if n != "table"
    }
    cases |= {
        f"contact {n}": (make(pair, 0.9), (2e-6, 0.01, 0.1), 2)
        for n, make in joint_options.CONTACTS.items()
    }
    cases |= {
        f"friction {n}": (make(0.1), (0.02, 50.0), 2)
        for n, make in joint_options.FRICTIONS.items()
        if n != "lugre"
    }
    cases["friction lugre"] = (joint_options.FRICTIONS["lugre"](0.1), (1e-7, 0.02, 50.0), 3)
    cases |= {
        f"asperity {n}": (law(modulus=1e11), (1.2, facts), 1)
        for n, law in joint_options.ASPERITIES.items()
    }
    thresholds = {"dry": 0.4, "mixed": 1.0, "full": 3.0}
    for name, law in joint_options.TRANSITIONS.items():
        cases[f"transition {name}"] = (law(**thresholds), (1e-6, facts), 1)
    yield "| law | value | value and Jacobian |"
    yield "|---|---|---|"
    cost = {}
    for name, (law, state, active) in cases.items():
        times = []
        for calls, first, others in compiled_law(law, active, state):
            calls(10, first, others)
            once = partial(calls, first=first, others=others)
            times.append(
                statistics.median(per_call(lambda n, once=once: once(n), 20_000) for _ in range(5))
            )
        cost[name] = times
        yield f"| {name} | {times[0]:.1f} ns | {times[1]:.1f} ns |"
    names = (
        "transition load_sharing",
        "film pinkus_sternlicht",
        "asperity greenwood_tripp",
        "contact winkler",
    )
    shared = [sum(cost[n][k] for n in names) for k in range(2)]
    together = ", ".join(n.partition(" ")[2] for n in names)
    yield f"| load sharing in all: {together} | {shared[0]:.1f} ns | {shared[1]:.1f} ns |"
    require(cost["film pinkus_sternlicht"][1] < 100.0, "Pinkus-Sternlicht above 100 ns")
    require(shared[1] < 250.0, f"load sharing at {shared[1]:.0f} ns, above 250")
    require(cost["film harmonic"][1] < 5000.0, "the harmonic film above 5 us")


def film_costs():
    """The film table: a force, its build, finite elements no more accurate, a step of the feeder
    beside a formula's.
    """
    states = film_ladder.path()
    bearing = Bearing.of(film_ladder.JOINT)
    finest = bands.FastFilm(bearing, film_ladder.REFERENCE)
    wanted = np.array([finest.outputs(*s)[:2] for s in states])
    table = film_ladder.law_rung("table 33x33", "table", cl.table_film(), states, wanted)
    elements = film_ladder.solver_rung("FEM 36x3", "fem", MovingFilm(bearing), states, wanted)
    began = time.process_time()
    Key(1.0).build()
    built = time.process_time() - began
    case, steps = find_case("six_bar_feeder"), {}
    for name, law in (("pinkus_sternlicht", cl.pinkus_sternlicht()), ("table", cl.table_film())):
        _, seconds, count = film_ladder.journal(film_ladder.with_film(case, law), 2.0, 1e-6)
        steps[name] = seconds / count
    ratio = elements.seconds / table.seconds
    yield (
        "| film table, L/D = 1 | value | with Jacobian | build | FEM 36x3, warm, less accurate | "
        "a feeder's step |"
    )
    yield "|---|---|---|---|---|---|"
    yield (
        f"| error {table.error_closing:.1e} closing in | {table.seconds * 1e9:.0f} ns "
        f"| {table.slopes_seconds * 1e9:.0f} ns | {built:.2g} s "
        f"| {ratio:.2g} times the table's time at error {elements.error_closing:.1e} "
        f"| {steps['table'] / steps['pinkus_sternlicht']:.2f} times Pinkus-Sternlicht's |"
    )
    require(table.seconds < 100e-9, "a table's force above 100 ns")
    require(table.slopes_seconds < 200e-9, "a table's force with Jacobian above 200 ns")
    require(built < 5.0, "a table's build above 5 s")
    require(
        ratio > 1000.0 and table.error_closing < elements.error_closing,
        "FEM within 1000 times of the table",
    )
    require(
        steps["table"] < 2.0 * steps["pinkus_sternlicht"],
        "a step with the table above twice a formula's",
    )


def parts():
    """Cost a step of what a scene has: clearance joints, friction, energy ledger, outputs."""
    cases = {
        "ideal": {"model": "ideal"},
        "dry B": {"model": "dry", "joints": "B", "friction": "none"},
        "dry B, friction": {"model": "dry", "joints": "B", "friction": "coulomb"},
        "lubricated B": {"joints": "B"},
        "lubricated B, no film torques": {"joints": "B", "film_torques": False},
        "lubricated B, C, E": {"joints": "B,C,E"},
        "lubricated A to F": {"joints": "A,B,C,D,E,F"},
    }
    rows = ablation.costs(
        {name: cl.load_case("six_bar_feeder", **options) for name, options in cases.items()}
    )
    yield from ablation.table(rows, "six-bar feeder, one turn")
    one, six = (next(r for r in rows if r.name == n) for n in ("lubricated B", "lubricated A to F"))
    ratio = six.step * six.steps / (one.step * one.steps)
    yield ""
    yield (
        f"Six lubricated joints cost {ratio:.1f} times one over a turn "
        f"({six.step / one.step:.1f} times a step)."
    )
    require(ratio <= 8.0, f"six joints cost {ratio:.1f} times one")


def long_runs():
    """Run time a turn over 1000 turns: of the first and the last hundred."""
    yield (
        "| 1000 turns, no outputs | steps | a turn of the first 100 | a turn of the last 100 | "
        "ratio |"
    )
    yield "|---|---|---|---|---|"
    cases = {
        "feeder, lubricated B, C, E": ("six_bar_feeder", {"joints": "B,C,E"}),
        "slider-crank, lubricated": ("slider_crank", {"model": "lubricated"}),
        "slider-crank, dry": ("slider_crank", {"model": "dry"}),
    }
    for name, (case, options) in cases.items():
        scene = cl.load_case(case, **options)
        mechanism = build(scene, ledger=False)
        run = Run(mechanism, Span(1000 * scene.turn, 1001), Solver(1e-5), outputs=False)
        marks, clock = [(0.0, 0.0)], 0.0
        code = status.RUNNING
        while code == status.RUNNING:
            began = time.perf_counter()
            code = run.advance()
            clock += time.perf_counter() - began
            marks.append((run.state.time / scene.turn, clock))
        at = np.interp([0.0, 100.0, 900.0, 1000.0], *np.array(marks).T)
        first, last = at[1] / 100, (at[3] - at[2]) / 100
        steps = int(run.state.steps)
        yield (
            f"| {name} | {steps} | {first * 1e3:.3f} ms | {last * 1e3:.3f} ms | "
            f"{last / first:.2f} |"
        )
        require(code == status.DONE, f"{name}: 1000 turns ended with {code}")
        require(
            last < 1.2 * first, f"{name}: a turn costs {last / first:.2f} times more at the end"
        )


def memory():
    """Peak memory of a long run, all of the process."""
    yield "| 10,000 turns, feeder, lubricated B, 40 samples a turn | wall | peak memory | file |"
    yield "|---|---|---|---|"
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "clearance.cli",
            "run",
            "six_bar_feeder",
            "--turns",
            "10000",
        ]
        command += ["--samples-per-turn", "40", "--json", "-o", f"{folder}/long.h5"]
        code = (
            f"import subprocess, resource; subprocess.run({command!r}, check=True, "
            "capture_output=True)"
        )
        code += "; print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
        began = time.perf_counter()
        peak = (
            int(
                subprocess.run(
                    [sys.executable, "-c", code], check=True, capture_output=True, text=True
                ).stdout
            )
            / 1024
        )
        wall, size = time.perf_counter() - began, Path(folder, "long.h5").stat().st_size / 2**20
        yield f"| | {wall:.0f} s | {peak:.0f} MB | {size:.0f} MB |"
        require(peak < 300.0, f"a long run takes {peak:.0f} MB")


def table():
    sections = (right_hand_sides, law_costs, film_costs, parts, runs, long_runs, memory)
    return [line for section in sections for line in [*section(), ""]][:-1]


if __name__ == "__main__":
    publish(__doc__, table, MARK)
