"""Operations of inverse dynamics: chains of Guo et al., counted, beside published counts.

Group: chains

Answers: Guo, Ju and Wang, Aerospace 11 (2024) 368. They state that their explicit equations need
fewer operations than the methods of Lagrange, of Newton and Euler, and of Zhao.

Reproduced: operations a sample of the kernel for both chains, counted while its code runs; the
dense solve for multipliers by formula. A planar recursion of Newton and Euler in link frames is
written here as in textbooks, and counted in the same way. Also the growth with the number of
joints.

Assumed: published counts of serial chains of n revolute joints in space stand for two of the
methods: recursive Newton-Euler 150 n - 48 multiplications and 131 n - 48 additions (Luh, Walker and
Paul, J. Dyn. Syst. Meas. Control 102 (1980) 69), recursive Lagrange 412 n - 277 and 320 n - 201
(Hollerbach, IEEE Trans. Syst. Man Cybern. 10 (1980) 730).

Not comparable: the source's own count, for its equations are spatial and the part we had gives no
number. Of Zhao's method we have no published count. The kernel moves in the plane, published
counts hold in space: the planar recursion shows how much that is worth. It needs less than the
kernel if only torques are requested. The claim of the source is neither confirmed nor refuted here.
"""

import math

import numpy as np
from clearance.cases.five_axis_chain import INERTIA, LINKS, READINGS, speeding_up
from clearance.paper_figures import workshop
from clearance.paper_figures.operation_counts import (
    KINDS,
    Counting,
    Operations,
    counted_operations,
    dense_operations,
    needed_channels,
)
from clearance.postprocess.figures import finish, line, sheet, stroke

import clearance as cl
from clearance.motions.prescribed import Explicit

TIMES = np.linspace(0.2, 5.0, 25)  # s
ACCELERATION = 0.2  # rad/s2, of each joint
#: multiplications a joint, constant; additions a joint, constant
PUBLISHED = {
    "recursive Newton-Euler, in space": (150, -48, 131, -48),
    "recursive Lagrange, in space": (412, -277, 320, -201),
}
KERNEL, PLANAR = "kernel, torques", "recursive Newton-Euler, in the plane"


def published(name: str, joints: int) -> Operations:
    """Operations of a published method for a serial chain of revolute joints."""
    each, constant, added, added_constant = PUBLISHED[name]
    return Operations(added * joints + added_constant, each * joints + constant, 0, 0)


def torques(links, angles, rates, accelerations, tools=math) -> list:
    """Driving torques [N m] of a planar tree by the recursion of Newton and Euler in link frames.

    links: of each the number of its carrier or None, its joint's place there [m], centre of mass
    [m], mass [kg], moment of inertia [kg m2]. angles [rad], rates and accelerations: of the joints,
    link against link. There is no gravity in the plane.
    """
    motions = []
    moving = zip(links, angles, rates, accelerations, strict=True)
    for (carrier, (px, py), (cx, cy), mass, inertia), angle, rate, more in moving:
        cosine, sine, ax, ay = tools.cos(angle), tools.sin(angle), 0.0, 0.0
        if carrier is not None:
            _, spin, turn, (bx, by), _, _ = motions[carrier]
            square = spin * spin
            bx, by = bx - turn * py - square * px, by + turn * px - square * py
            ax, ay = cosine * bx + sine * by, cosine * by - sine * bx
            rate, more = spin + rate, turn + more
        square = rate * rate
        force = mass * (ax - more * cy - square * cx), mass * (ay + more * cx - square * cy)
        moment = inertia * more + cx * force[1] - cy * force[0]
        motions.append(((cosine, sine), rate, more, (ax, ay), force, moment))
    forces, moments = [m[4] for m in motions], [m[5] for m in motions]
    for i in reversed(range(len(links))):
        carrier, (px, py), *_ = links[i]
        if carrier is not None:
            (cosine, sine), (fx, fy) = motions[i][0], forces[i]
            gx, gy = cosine * fx - sine * fy, sine * fx + cosine * fy
            forces[carrier] = forces[carrier][0] + gx, forces[carrier][1] + gy
            moments[carrier] = moments[carrier] + moments[i] + px * gy - py * gx
    return moments


def recursion(links) -> Operations:
    """Operations of `torques`, counted while it runs."""
    count = Counting()
    angles, rates, more = ([count.number(v)] * len(links) for v in (0.3, 0.2, 0.1))
    torques(links, angles, rates, more, count.math)
    return Operations(*(count.tally[kind] for kind in KINDS))


def five_axis(reading: str = "P") -> list:
    """The links of the five-axis chain as `torques` takes them."""
    names = ["ground", *(f"link{name}" for name in LINKS)]
    bodies = zip(LINKS.values(), READINGS[reading], strict=True)
    return [
        (names.index(carrier) - 1 if carrier != "ground" else None, pivot, com, mass, INERTIA[mass])
        for (carrier, pivot, com), mass in bodies
    ]


def links_of(joints: int) -> list:
    """A serial planar chain, no two links alike, as `torques` takes it."""
    numbers = range(joints)
    places = [(0.5 + 0.01 * i, 0.02) for i in numbers]
    coms = [(0.2 + 0.01 * i, 0.03) for i in numbers]
    carriers = [i - 1 if i else None for i in numbers]
    return [(carriers[i], places[i], coms[i], 1.0 + 0.1 * i, 0.02 + 0.01 * i) for i in numbers]


def serial(joints: int) -> cl.Scene:
    """The chain of `links_of` with a prescribed motion of every joint."""
    before, parts = cl.ground, []
    for i, (_, pivot, com, mass, inertia) in enumerate(links_of(joints)):
        link = cl.Body(f"link{i}", mass, inertia, com=com)
        joint = cl.Revolute(before.at(*pivot), link, name=f"joint{i}")
        motion = speeding_up(acceleration=ACCELERATION + 0.01 * i)
        parts += [joint, cl.Drive(joint, motion=motion, name=f"joint{i}")]
        before = link
    return cl.Scene(*parts, gravity=(0.0, 0.0), name=f"chain_of_{joints}")


def kernel(scene: cl.Scene, reactions: bool = False) -> Operations:
    """Operations a sample of our kernel, from the time on: for drives, or all reactions too."""
    solver = Explicit(scene)
    needed = needed_channels(solver)
    chosen = [i for i in needed if reactions or solver.channels[i].path.startswith("drives/")]
    return counted_operations(solver, TIMES, chosen)


def draw(work: workshop.Workshop) -> None:
    five = cl.load_case("five_axis_chain", friction="none")
    rubbing = cl.load_case("five_axis_chain", friction="coulomb")
    loops = cl.load_case("three_loop_chain", friction="none")
    sizes = len(loops.bodies), len(loops.joints)
    rows = {
        ("five-axis chain", KERNEL): kernel(five),
        ("five-axis chain", "kernel, torques and all reactions"): kernel(five, reactions=True),
        ("five-axis chain", "kernel, the same with Coulomb friction"): kernel(
            rubbing, reactions=True
        ),
        ("five-axis chain", PLANAR): recursion(five_axis()),
        ("five-axis chain", "multipliers, one dense solve"): dense_operations(5, 5),
        **{("any chain of 5 joints", name): published(name, 5) for name in PUBLISHED},
        ("three-loop chain", "kernel, torque"): kernel(loops),
        ("three-loop chain", "kernel, torque and all reactions"): kernel(loops, reactions=True),
        ("three-loop chain", "multipliers, one dense solve"): dense_operations(*sizes),
    }
    shown = ("multiplications", "additions", "divisions", "functions")
    heads = ("mechanism", "method", *shown[:3], "roots, sines", "all")
    cells = [
        [*names, *(f"{getattr(counted, kind):.0f}" for kind in (*shown, "total"))]
        for names, counted in rows.items()
    ]
    remarks = (
        "A sample, without friction but where it is named. Kernel and planar recursion: counted "
        "while "
        "their code runs. The kernel begins at the time, so that the motion's law is counted too. "
        "Its "
        "reactions include axial forces and bending moments. The published counts and the planar "
        "recursion begin at angles and rates; the published ones hold in space and leave sines out."
    )
    work.table(heads, cells, remarks=remarks)
    work.keep(growth(work.less((2, 3, 4, 6, 8), (2, 3))))


def growth(counts):
    """Operations over the number of joints of serial chains."""
    figure = sheet(6.5, 4.2)
    axes = figure.add_subplot()
    joints = np.array(counts)
    shown = {name: [published(name, n).total for n in counts] for name in reversed(PUBLISHED)}
    shown[KERNEL] = [kernel(serial(n)).total for n in counts]
    shown[PLANAR] = [recursion(links_of(n)).total for n in counts]
    for i, (name, values) in enumerate(shown.items()):
        style = stroke(i, len(shown)) | {"label": name, "lw": 1.6, "marker": "o", "ms": 4}
        line(axes, joints, np.array(values), **style)
        end = joints[-1], values[-1]
        axes.annotate(f"{values[-1]:.0f}", end, (6, 0), textcoords="offset points", va="center")
    axes.set_yscale("log")
    axes.set_xlim(right=joints[-1] + 0.12 * (joints[-1] - joints[0]))
    finish(axes, "operations a sample [-]", "joints of a serial chain [-]")
    return figure
