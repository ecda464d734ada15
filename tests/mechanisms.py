"""Mechanisms for tests: every kind of group, none of them in the case library."""

import math

import clearance as cl


def body(name, points, angle=0.0, mass=None, com=(0.0, 0.0), position=None):
    """A body with plausible mass and inertia for its points."""
    size = max(math.hypot(*p) for p in points.values()) or 0.05
    mass = mass or 2.0 * size + 0.1
    return cl.Body(
        name,
        mass,
        0.3 * mass * size**2 + 1e-5,
        points=points,
        angle=angle,
        com=com,
        position=position,
    )


def bar(name, length, angle=0.0, mass=1.0, inertia=0.01, **more):
    """A bar from its point a to its point b."""
    ends = {"a": (0, 0), "b": (length, 0)}
    return cl.Body(name, mass, inertia, points=ends, angle=angle, **more)


def loop(first, coupler, last, base, names="ABCD", b=cl.Revolute, c=cl.Revolute, **more):
    """Hinges of a four-bar: two bars on pivots `base` apart, and their coupler; b, c: kinds of the
    coupler's, which take what else is given.
    """
    options = {kind: more if kind is not cl.Revolute else {} for kind in (b, c)}
    return (
        cl.Revolute(cl.ground, first["a"], name=names[0]),
        b(first["b"], coupler["a"], name=names[1], **options[b]),
        c(coupler["b"], last["b"], name=names[2], **options[c]),
        cl.Revolute(cl.ground.at(base, 0), last["a"], name=names[3]),
    )


def crank_and_slider(crank, rod, block, names="OABG", at=(0.0, 0.0), **guide):
    """Joints of a slider-crank on its pivot, with the block's centre on a guide through it."""
    return (
        cl.Revolute(cl.ground.at(*at), crank["a"], name=names[0]),
        cl.Revolute(crank["b"], rod["a"], name=names[1]),
        cl.Revolute(rod["b"], block.at(0, 0), name=names[2]),
        cl.Prismatic(cl.ground.at(*at), block.at(0, 0), name=names[3], **guide),
    )


def film(a, b, name, clearance=1e-4, viscosity=0.05, **more):
    """A lubricated hinge of 20 mm by 20 mm, unless other numbers are stated."""
    options = {"radius": 0.01, "length": 0.02, "film": cl.pinkus_sternlicht()} | more
    oil = cl.Lubricant(viscosity)
    return cl.ClearanceRevolute(a, b, name=name, clearance=clearance, lubricant=oil, **options)


def journal(*loads, mass=3.0, speed=None, spin=0.0, gravity=(0.0, -9.81), **more):
    """A journal in a lubricated bearing J of the ground, at eccentricity (0.2, -0.3) c.

    speed: of its drive [rad/s], none without; spin: at which it starts [rad/s]. The film of 20 mm
    holds 3 kg at 100 rad/s with an eccentricity ratio of about 0.6. loads: more elements.
    """
    body = cl.Body("journal", mass, 1e-3, angular_velocity=spin)
    drive = [] if speed is None else [cl.Drive(body, speed=speed)]
    options = {"eccentricity": (2e-5, -3e-5)} | more
    joint = film(cl.ground.at(0, 0), body.at(0, 0), "J", **options)
    return cl.Scene(joint, *loads, *drive, gravity=gravity)


def dry(a, b, name, clearance=1e-4, stiffness=1e9, restitution=0.9, **more):
    law = cl.lankarani_nikravesh(stiffness=stiffness, restitution=restitution)
    return cl.ClearanceRevolute(
        a, b, name=name, radius=0.01, clearance=clearance, contact=law, **more
    )


def chooser(joint=cl.Revolute, chosen=(), **more):
    """A hinge function that makes the chosen joints with `joint` and all others ideal."""

    def hinge(name, a, b):
        return joint(a, b, name=name, **more) if name in chosen else cl.Revolute(a, b, name=name)

    return hinge


def watt(hinge=None, speed=20.0):
    """Watt six-bar: two RRR dyads; centres of mass off the bars."""
    hinge = hinge or chooser()
    crank = body("crank", {"A": (0, 0), "B": (0.04, 0)}, com=(0.01, 0.002))
    coupler = body("coupler", {"B": (0, 0), "C": (0.14, 0)}, angle=0.5, com=(0.06, 0.01))
    rocker = body(
        "rocker", {"D": (0, 0), "C": (0.10, 0), "E": (0.08, 0.05)}, angle=1.5, com=(0.05, 0.01)
    )
    rod = body("rod", {"E": (0, 0), "F": (0.15, 0)}, angle=0.2, com=(0.07, -0.01))
    lever = body("lever", {"G": (0, 0), "F": (0.09, 0)}, angle=1.4, com=(0.04, 0.0))
    return cl.Scene(
        hinge("A", cl.ground.at(0, 0), crank["A"]),
        hinge("B", crank["B"], coupler["B"]),
        hinge("C", coupler["C"], rocker["C"]),
        hinge("D", cl.ground.at(0.13, 0), rocker["D"]),
        hinge("E", rocker["E"], rod["E"]),
        hinge("F", rod["F"], lever["F"]),
        hinge("G", cl.ground.at(0.25, 0.02), lever["G"]),
        cl.Drive(crank, speed=speed, start=0.3),
        name="watt",
    )


def stephenson(hinge=None, speed=15.0):
    """Stephenson III driven so that its other five bodies form one group no dyads solve (crank on
    the ternary side).
    """
    hinge = hinge or chooser()
    crank = body("crank", {"A": (0, 0), "B": (0.02, 0)}, com=(0.01, 0.0))
    link = body("link", {"B": (0, 0), "C": (0.21, 0)}, angle=0.6, com=(0.08, 0.004))
    plate = body(
        "plate", {"C": (0, 0), "D": (0.09, 0), "E": (0.05, 0.06)}, angle=0.1, com=(0.045, 0.02)
    )
    lower = body("left", {"D": (0, 0), "F": (0.16, 0)}, angle=-1.2, com=(0.06, 0.0))
    right = body("right", {"E": (0, 0), "G": (0.16, 0)}, angle=-1.0, com=(0.08, 0.005))
    return cl.Scene(
        hinge("A", cl.ground.at(0, 0), crank["A"]),
        hinge("B", crank["B"], link["B"]),
        hinge("C", link["C"], plate["C"]),
        hinge("D", plate["D"], lower["D"]),
        hinge("E", plate["E"], right["E"]),
        hinge("F", cl.ground.at(0.23, -0.05), lower["F"]),
        hinge("G", cl.ground.at(0.26, 0.02), right["G"]),
        cl.Drive(crank, speed=speed, start=0.4),
        name="stephenson",
    )


def inverted_slider(hinge=None, speed=12.0):
    """Crank, swinging guide and slider: an RPR dyad whose guide carries the slide (quick-return
    mechanism).
    """
    hinge = hinge or chooser()
    crank = body("crank", {"A": (0, 0), "B": (0.05, 0)}, com=(0.02, 0.0))
    block = body("block", {"B": (0.002, 0.001)}, mass=0.2)
    guide = body("guide", {"O": (0, 0), "P": (0.02, 0.01)}, angle=1.2, com=(0.1, 0.01))
    return cl.Scene(
        hinge("A", cl.ground.at(0, 0.15), crank["A"]),
        hinge("B", crank["B"], block["B"]),
        hinge("O", cl.ground.at(0, 0), guide["O"]),
        cl.Prismatic(guide["P"], block.at(0, 0), axis=(1.0, 0.1), angle=0.3, name="slot"),
        cl.Drive(crank, speed=speed, start=0.5),
        name="inverted_slider",
    )


def moving_guide(hinge=None, speed=10.0):
    """A slide on a driven turning plate, pinned to a rod hinged to ground (RRP on a moving guide),
    slider as body a.
    """
    hinge = hinge or chooser()
    plate = body("plate", {"A": (0, 0), "S": (0.01, 0.03)}, com=(0.01, 0.01))
    slider = body("slider", {"S": (0, 0), "T": (0.01, 0.004)}, mass=0.15)
    rod = body("rod", {"T": (0, 0), "G": (0.12, 0)}, angle=-0.4, com=(0.05, 0.003))
    return cl.Scene(
        hinge("A", cl.ground.at(0, 0), plate["A"]),
        cl.Prismatic(slider["S"], plate["S"], axis=(1.0, 0.2), angle=-0.2, name="slot"),
        hinge("T", slider["T"], rod["T"]),
        hinge("G", cl.ground.at(0.15, 0.0), rod["G"]),
        cl.Drive(plate, speed=speed, start=0.1),
        name="moving_guide",
    )


def actuator(speed=0.05):
    """A boom lifted by a prismatic actuator of constant speed (driven slide inside a loop)."""
    boom = body("boom", {"O": (0, 0), "P": (0.5, 0.05)}, angle=0.4, com=(0.3, 0.02))
    tube = body("tube", {"Q": (0, 0)}, angle=0.8, com=(0.1, 0.0))
    piston = body("piston", {"P": (0.2, 0), "tail": (0, 0)}, angle=0.8, com=(0.1, 0.0))
    slide = cl.Prismatic(tube["Q"], piston["tail"], axis=(1, 0), name="cylinder")
    return cl.Scene(
        cl.Revolute(cl.ground.at(0, 0), boom["O"], name="O"),
        cl.Revolute(cl.ground.at(0.3, -0.3), tube["Q"], name="Q"),
        slide,
        cl.Revolute(piston["P"], boom["P"], name="P"),
        cl.Drive(slide, speed=speed, start=0.35, name="oil"),
        name="actuator",
    )


def arm(speed1=2.0, speed2=-3.0):
    """Two-link arm: first joint driven against ground, second by the relative angle."""
    upper = body("upper", {"S": (0, 0), "E": (0.3, 0)}, angle=0.5, com=(0.14, 0.01))
    lower = body("lower", {"E": (0, 0)}, angle=1.1, com=(0.12, -0.01))
    elbow = cl.Revolute(upper["E"], lower["E"], name="elbow")
    return cl.Scene(
        cl.Revolute(cl.ground, upper["S"], name="shoulder"),
        elbow,
        cl.Drive(upper, speed=speed1, name="motor1"),
        cl.Drive(elbow, speed=speed2, name="motor2"),
        name="arm",
    )


def reversed_arm():
    """The arm with ground and upper arm as the b sides."""
    upper = body("upper", {"S": (0, 0), "E": (0.3, 0)}, angle=0.5, com=(0.14, 0.01))
    lower = body("lower", {"E": (0, 0)}, angle=1.1, com=(0.12, -0.01))
    elbow = cl.Revolute(lower["E"], upper["E"], name="elbow")
    return cl.Scene(
        cl.Revolute(upper["S"], cl.ground.at(0.1, 0.2), name="shoulder"),
        elbow,
        cl.Drive(upper, speed=2.0, name="motor1"),
        cl.Drive(elbow, speed=-3.0, name="motor2"),
        name="reversed_arm",
    )


def scotch_yoke(hinge=None, speed=9.0):
    """Crank, block in a slanted slot of a yoke, yoke on a guide: a group with two slides and no
    closed form.
    """
    hinge = hinge or chooser()
    crank = body("crank", {"A": (0, 0), "B": (0.05, 0)}, com=(0.02, 0.003))
    block = body("block", {"B": (0, 0)}, mass=0.2)
    yoke = body("yoke", {"slot": (0.01, 0.0)}, mass=0.8, com=(0.02, 0.01))
    return cl.Scene(
        hinge("A", cl.ground.at(0, 0), crank["A"]),
        hinge("B", crank["B"], block["B"]),
        cl.Prismatic(yoke["slot"], block["B"], axis=(0.1, 1.0), name="slot"),
        cl.Prismatic(cl.ground.at(0, 0.02), yoke.at(0, 0), axis=(1.0, 0.0), name="guide"),
        cl.Drive(crank, speed=speed, start=0.7),
        name="scotch_yoke",
    )


def pushed_four_bar(hinge=None, torque=0.4):
    """A four-bar driven by a torque: one free coordinate inside a loop, started with some speed."""
    hinge = hinge or chooser()
    crank = body("crank", {"A": (0, 0), "B": (0.05, 0)}, angle=0.4, com=(0.02, 0.0))
    coupler = body("coupler", {"B": (0, 0), "C": (0.15, 0)}, angle=0.6, com=(0.07, 0.01))
    rocker = body("rocker", {"D": (0, 0), "C": (0.12, 0)}, angle=1.5, com=(0.06, 0.0))
    return cl.Scene(
        hinge("A", cl.ground.at(0, 0), crank["A"]),
        hinge("B", crank["B"], coupler["B"]),
        hinge("C", rocker["C"], coupler["C"]),
        hinge("D", rocker["D"], cl.ground.at(0.16, 0)),
        cl.Drive(crank, torque=torque, start=0.4, speed_start=6.0),
        name="pushed_four_bar",
    )


def parallelogram(joint=dry):
    """Three parallel cranks under one coupler: redundant, possible only because the third crank has
    clearance.
    """
    cranks = [
        body(n, {"O": (0, 0), "P": (0.05, 0)}, angle=1.0, com=(0.02, 0))
        for n in ("one", "two", "three")
    ]
    beam = body("beam", {"1": (0, 0), "2": (0.2, 0), "3": (0.1, 0)}, com=(0.1, 0.01))
    hinges = [
        part
        for i, c in enumerate(cranks, 1)
        for part in (
            cl.Revolute(cl.ground.at((0, 0.2, 0.1)[i - 1], 0), c["O"], name=f"O{i}"),
            (joint if i == 3 else cl.Revolute)(c["P"], beam[str(i)], name=f"P{i}"),
        )
    ]
    return cl.Scene(*hinges, cl.Drive(cranks[0], speed=10.0), name="parallelogram")


def long_branches():
    """Two long branches on the rocker of a pushed four-bar: with a slide, a driven hinge and
    swapped sides.
    """
    scene = pushed_four_bar()
    parts, loads, rocker = list(scene.joints), list(scene.loads), scene.bodies[-1]
    for name, count in (("one", 6), ("two", 5)):
        parent = rocker.at(0.02, 0.01)
        for i in range(count):
            link = body(
                f"{name}{i}",
                {"near": (0, 0), "far": (0.1, 0.01)},
                angle=0.3 * i - 0.5,
                com=(0.04, 0.01),
            )
            ends = (link["near"], parent) if i == 1 else (parent, link["near"])
            kind = {2: "slide", 3: "driven"}.get(i) if name == "one" else None
            if kind == "slide":
                joint = cl.Prismatic(*ends, axis=(0.8, 0.6), angle=0.2, name=f"{name}-{i}")
            else:
                joint = cl.Revolute(*ends, name=f"{name}-{i}")
            if kind == "driven":
                loads.append(cl.Drive(joint, speed=2.0, name="motor"))
            parts.append(joint)
            parent = link["far"]
    return cl.Scene(*parts, *loads, name="long_branches")


ALL = {
    f.__name__: f
    for f in (
        watt,
        stephenson,
        inverted_slider,
        moving_guide,
        actuator,
        arm,
        reversed_arm,
        scotch_yoke,
        pushed_four_bar,
        long_branches,
    )
}
