"""Three-loop closed chain with load-dependent joint friction (Guo, Ju and Wang, Aerospace 11 (2024)
368).

Seven links in a vertical plane, ten hinges, one crank. The source prints vectors, rounded to 0.1
mm, masses, inertias and friction coefficients. Decoded from the vectors: links of 100, 55 and 45
mm, the long ones with a pin in the middle. The ground pivots are 50 mm apart on a horizontal line.
They meet all printed digits for a crank that starts at -98.797 degrees. Centres of mass stand in
the middle of the links. Assumed by us: the crank's sense of turning, the exponent of Stribeck's
term, what the viscous coefficient multiplies (the rate alone), the pin radius.

Links a to g; a hinge is named after the two bodies it joins. The source cuts the loops at g-f, f-d
and c-d. It numbers the joints of the remaining tree 1 (ground-a), 2 (a-b), 3 (b-c), 4 (a-d), 1'
(ground-e), 2' (e-f), 1'' (ground-g, driven). P is the common pin of c, d and f.
"""

import clearance as cl

GRAVITY = 9.8
START = cl.degree(-98.797)
#: where the chain stands on the ground [m]
PIVOTS = {"a": (0.0, 0.0), "e": (-0.050, 0.0), "g": (-0.100, 0.0)}
#: link -> (mass [kg], moment of inertia about its centre of mass [kg m2], its pins along it [m],
#: start angle [deg])
LINKS = {
    "a": (2.0, 0.04, {"ground": -0.050, "d": 0.0, "b": 0.050}, -42.557),
    "b": (2.0, 0.04, {"a": -0.050, "c": 0.0, "free": 0.050}, -154.3275),
    "c": (1.0, 0.01, {"b": -0.0225, "P": 0.0225}, 146.4035),
    "d": (1.2, 0.02, {"a": -0.0275, "P": 0.0275}, -146.224),
    "e": (1.2, 0.02, {"ground": -0.0275, "f": 0.0275}, -98.2419),
    "f": (2.0, 0.04, {"e": 0.0, "P": 0.050, "g": -0.050}, -11.4917),
    "g": (1.0, 0.01, {"ground": -0.0225, "f": 0.0225}, -98.797),
}
HINGES = ("ground-a", "a-b", "b-c", "a-d", "ground-e", "e-f", "ground-g", "g-f", "f-d", "c-d")
CRANK = "ground-g"


@cl.signal
def turning(time, start, speed):
    """Angle [rad] of the crank; a Drive's own constant speed would promise full turns, which this
    crank cannot do.
    """
    return start + speed * time


@cl.effort
def servo(time, position, rate, start, speed, stiffness, damping):
    """Torque [N m] of a position controller that follows turning."""
    return stiffness * (turning(time, start, speed) - position) + damping * (speed - rate)


def scene(
    *,
    speed: float = 0.1,
    friction: str = "coulomb",
    where: str = "driven",
    pin_radius: float = 0.010,
    coefficient: float = 0.05,
    viscous: float = 0.01,
    static: float = 0.2,
    stribeck_rate: float = 0.1,
    exponent: float = 2.0,
    drive: str = "motion",
    stiffness: float = 2e3,
    damping: float = 1e2,
    transition_rate: float = 1e-3,
) -> cl.Scene:
    """Three-loop chain from crank angle -98.797 deg; 10 s, no further than +90.5 deg (15.8 s) or
    -145.5 deg.

    speed: crank speed, positive sense assumed [rad/s]
    friction: friction law of the pins: none, coulomb or stribeck [-]
    where: which pins rub: driven (the crank's on the ground, as in the source) or all ten [-]
    pin_radius: radius of the pins, assumed [m]
    coefficient: kinetic coefficient of friction [-]
    viscous: viscous friction of a pin [N m s/rad]
    static: static coefficient of friction of stribeck [-]
    stribeck_rate: rate of stribeck's fall from static to kinetic [rad/s]
    exponent: of stribeck's fall: 2 (Gauss) or 1 (Tustin), assumed [-]
    drive: motion (prescribed; the torque follows) or torque (of a position controller; the motion
        follows) [-]
    stiffness: of the position controller [N m/rad]
    damping: of the position controller [N m s/rad]
    transition_rate: rate over which friction turns round, for drive=torque [rad/s]
    """
    cl.one_of("where", where, ("driven", "all"))
    cl.one_of("drive", drive, ("motion", "torque"))
    law = cl.joint_friction_law(
        friction,
        coefficient=coefficient,
        viscous=viscous,
        static=static,
        stribeck_rate=stribeck_rate,
        exponent=exponent,
        transition_rate=transition_rate if drive == "torque" else 0.0,
    )
    rubbing = {"friction": law, "pin_radius": pin_radius}
    hinges = _hinges({name: rubbing for name in HINGES if where == "all" or name == CRANK})
    if drive == "motion":
        motor = cl.Drive(hinges[CRANK], motion=turning(start=START, speed=speed), name="crank")
    else:
        effort = servo(start=START, speed=speed, stiffness=stiffness, damping=damping)
        motor = cl.Drive(hinges[CRANK], torque=effort, start=START, speed_start=speed, name="crank")
    return cl.Scene(*hinges.values(), motor, gravity=(0.0, -GRAVITY), name="three_loop_chain")


def _hinges(friction: dict[str, dict]) -> dict[str, cl.Revolute]:
    """The hinges by name, with what those named in `friction` rub with."""
    bodies = {name: _link(name) for name in LINKS}

    def pin(name: str, other: str) -> cl.Point:
        if name == "ground":
            return cl.ground.at(*PIVOTS[other])
        return bodies[name][other if other in LINKS[name][2] else "P"]

    pairs = {name: name.split("-") for name in HINGES}
    return {
        n: cl.Revolute(pin(a, b), pin(b, a), name=n, **friction.get(n, {}))
        for n, (a, b) in pairs.items()
    }


def _link(name: str) -> cl.Body:
    mass, inertia, pins, angle = LINKS[name]
    points = {pin: (along, 0.0) for pin, along in pins.items()}
    return cl.Body(f"link_{name}", mass, inertia, points=points, angle=cl.degree(angle))
