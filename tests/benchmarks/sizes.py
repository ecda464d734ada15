"""Start and step of large mechanisms: `python tests/benchmarks/sizes.py [--update]`.

Chains of hinged links, ladders of four-bar windows with one degree of freedom, chains with
lubricated joints. Each runs in a process of its own. First call: CPU seconds from the scene to
compiled kernels (imports and the time loop, which are the same for all, left out). Later calls: the
same scene with other numbers. A step: CPU time of the compiled loop. Exponents are those of the
last doubling.
"""

import json
import math
import resource
import subprocess
import sys
import time

from publishing import publish

import clearance as cl
from clearance.mechanism.build import build
from clearance.run.options import choose_method, kernel_roles
from clearance.simulation import prepare

BEGIN = "<!-- sizes -->"
ROWS = {"chain": (10, 20, 40), "ladder": (10, 20, 40), "lubricated": (1, 2, 3, 5, 8, 10)}
UNITS = {"chain": "links", "ladder": "windows", "lubricated": "joints"}
STEPS = 300
REPEATS = 5


def link(name: str, length: float, angle: float = 0.0) -> cl.Body:
    return cl.Body(name, 0.3, 1e-4, points={"near": (0.0, 0.0), "far": (length, 0.0)}, angle=angle)


def chain(count: int, length: float = 0.1) -> cl.Scene:
    """Hinged links that fall from the horizontal."""
    parent, joints = cl.ground.at(0.0, 0.0), []
    for i in range(count):
        body = link(f"link{i}", length)
        joints.append(cl.Revolute(parent, body["near"], name=f"J{i}"))
        parent = body["far"]
    return cl.Scene(*joints, name="chain")


def ladder(count: int, length: float = 0.3) -> cl.Scene:
    """Four-bar windows in a row, each rocker the crank of the next, driven at the first."""
    crank = first = link("crank", 0.1, math.pi / 2)
    joints = [cl.Revolute(cl.ground.at(0.0, 0.0), crank["near"], name="A")]
    for i in range(count):
        coupler, rocker = link(f"coupler{i}", length), link(f"rocker{i}", 0.1, math.pi / 2)
        foot = cl.ground.at(length * (i + 1), 0.0)
        joints.append(cl.Revolute(crank["far"], coupler["near"], name=f"B{i}"))
        joints.append(cl.Revolute(coupler["far"], rocker["far"], name=f"C{i}"))
        joints.append(cl.Revolute(foot, rocker["near"], name=f"D{i}"))
        crank = rocker
    return cl.Scene(*joints, cl.Drive(first, torque=0.1, start=math.pi / 2), name="ladder")


def lubricated(count: int, length: float = 0.1) -> cl.Scene:
    """A chain whose first joints are lubricated; ten links."""
    parent, joints = cl.ground.at(0.0, 0.0), []
    for i in range(10):
        body = link(f"link{i}", length)
        film = {"film": cl.pinkus_sternlicht(), "lubricant": cl.Lubricant(0.05), "length": 0.02}
        if i < count:
            joints.append(
                cl.ClearanceRevolute(
                    parent, body["near"], name=f"J{i}", radius=0.01, clearance=1e-4, **film
                )
            )
        else:
            joints.append(cl.Revolute(parent, body["near"], name=f"J{i}"))
        parent = body["far"]
    return cl.Scene(*joints, name="lubricated")


SCENES = {"chain": chain, "ladder": ladder, "lubricated": lubricated}


def compiled(scene: cl.Scene):
    """A mechanism with the kernels that a run of it needs."""
    mechanism = build(scene)
    for role in kernel_roles(mechanism, choose_method(mechanism)[0]):
        mechanism.kernel(role)
    return mechanism


def measured(kind: str, count: int) -> dict:
    """Costs of one mechanism, in this process."""
    cl.simulate(cl.load_case("double_pendulum"), until=0.01).close()  # imports, time loop
    before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    mechanism = compiled(SCENES[kind](count))
    first = time.process_time() - began
    memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    later = []
    for i in range(REPEATS):
        scene = SCENES[kind](count, 0.11 + 0.01 * i)
        began = time.process_time()
        compiled(scene)
        later.append(time.process_time() - began)
    run = prepare(SCENES[kind](count), until=0.05, samples=3, max_steps=STEPS)
    began = time.thread_time()  # threads of the linear algebra may be busy still
    run.advance()
    stepping = time.thread_time() - began
    return {
        "operations": mechanism.structure.programs["rhs"].operations,
        "first": first,
        "later": min(later),
        "memory": memory,
        "step": stepping / max(int(run.state.steps), 1),
    }


def row(kind: str, count: int) -> dict:
    """The costs, from a fresh process."""
    command = [sys.executable, __file__, "--one", kind, str(count)]
    return json.loads(
        subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[-1]
    )


def tables() -> list[str]:
    lines = [
        "| mechanism | operations of the right-hand side | first call | later calls | memory | a "
        "step |",
        "|---|---|---|---|---|---|",
    ]
    for kind, counts in ROWS.items():
        rows = {count: row(kind, count) for count in counts}
        lines += [
            f"| {kind}, {count} {UNITS[kind]} | {r['operations']} | {r['first']:.2f} s | "
            f"{1e3 * r['later']:.1f} ms "
            f"| {r['memory']:.0f} MB | {1e6 * r['step']:.0f} us |"
            for count, r in rows.items()
        ]
        last, before = counts[-1], counts[-2]
        power = [
            math.log(rows[last][name] / rows[before][name]) / math.log(last / before)
            for name in ("operations", "first", "later", "memory", "step")
        ]
        lines.append(
            f"| exponent of {before} to {last} | " + " | ".join(f"{p:.2f}" for p in power) + " |"
        )
    return lines


if __name__ == "__main__":
    if "--one" in sys.argv:
        print(json.dumps(measured(sys.argv[-2], int(sys.argv[-1]))))
    else:
        publish(__doc__, tables, BEGIN)
