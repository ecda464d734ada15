"""Mobile manipulator: boom, stick and bucket on three actuators, friction in all joints (Chacko and
Khan, Tribology in Industry 39 (2017)).

The source prints masses, centres of mass, the sinusoids and time constants of its simulations and
the friction levels. It prints no length, no inertia, no anchor and no curve of its dig pattern. The
geometry here is an assumed one that closes over all strokes. Links are twice as long as their
centres of mass are far, anchors and actuator lengths are chosen, inertias are m |c|^2 / 3. The load
is (-150, 150) N on the tooth tip. The match of sinusoids and actuators is assumed as well. Forces
cannot be compared with the source's. The dig pattern (reach, penetrate, curl, lift, dump, return)
is ours.

The printed friction law (Eqs. 14 to 17) is corrected in two signs and a bracket. (14) lacks "- F_C"
and the brackets about breakaway less Coulomb friction, (15) and (17) have a wrong sign. (16) is as
printed, with its value 24.995.

Pins J1, J2, J3 join base, boom, stick and bucket. An actuator's barrel is pinned to the body before
(boom_base, ...), its rod to the body it moves (boom_end, ...). The slide between them bears its
name (boom_slide, ...).
"""

import math
from typing import NamedTuple

import clearance as cl
from clearance.values import checks

GRAVITY = 9.81
#: of boom, stick and bucket: mass [kg], end in the body's own frame [m] (the next hinge, or the
#: tooth tip), rough start angle [deg]
LINKS = {
    "boom": (3.92, (0.1690, 0.4318), 5.0),
    "stick": (0.94, (0.2034, 0.0088), 25.0),
    "bucket": (1.19, (0.0910, 0.0764), -45.0),
}
PISTON = 0.110  # middle of the overlap of rod and barrel, back from the rod's pin [m]


class Actuator(NamedTuple):
    """Cylinder of boom, stick or bucket: lengths and places in m, along and across in the frame of
    barrel or rod.
    """

    base: tuple[float, float]  # anchor on the body before
    end: tuple[float, float]  # anchor on the body it moves
    length: float  # from pin to pin at extension zero
    barrel_mass: float
    barrel_com: tuple[float, float]  # from the barrel's pin
    rod_mass: float
    rod_com: tuple[float, float]  # from the rod's pin
    angle: float  # rough start angle [deg]


ACTUATORS = {
    "boom": Actuator(
        (0.110, -0.040), (0.080, 0.135), 0.180, 0.60, (0.0634, 0.0166), 0.10, (-0.0873, 0.0), 103.0
    ),
    "stick": Actuator(
        (0.140, 0.250), (-0.050, 0.030), 0.190, 0.64, (0.0722, 0.0148), 0.10, (-0.0973, 0.0), 103.0
    ),
    "bucket": Actuator(
        (0.050, 0.045), (-0.025, 0.035), 0.170, 0.60, (0.0634, 0.0166), 0.03, (-0.0873, 0.0), 25.0
    ),
}
#: simulation 1: bias and amplitude of the extensions [m], angular frequency [rad/s]
SWINGS = {"boom": (0.020, 0.025, 0.4), "stick": (0.020, 0.015, 0.5), "bucket": (0.010, 0.0015, 0.3)}
#: simulations 2 and 3: ends of the phases reach, penetrate, curl, lift, dump, home [s], and
#: extensions there [m]
PHASES = (6.0, 12.0, 20.0, 28.0, 34.0, 40.0)
DIGS = {
    "boom": (0.005, -0.005, 0.0, 0.040, 0.040, 0.0),
    "stick": (-0.010, 0.010, 0.025, 0.030, 0.0, 0.0),
    "bucket": (-0.005, 0.0, 0.012, 0.012, -0.005, 0.0),
}
TIME_CONSTANTS = {1: 0.1, 2: 0.1, 3: 0.01}
#: friction levels of the source, alike for pins [N m] and slides [N]; viscous of pins [N m s/rad]
#: and slides [N s/m]
LEVELS = {"breakaway": 25.0, "coulomb": 20.0}
VISCOUS = (1e-3, 100.0)


def swung(time, bias, amplitude, frequency, time_constant):
    """Extension and its rate for the input bias + amplitude sin(frequency t) behind
    1 / (time_constant s + 1)^2.

    The filter is at rest at zero at t = 0, as that of the source, so a bias makes a start-up
    transient.
    """
    sine, cosine = math.sin(frequency * time), math.cos(frequency * time)
    if time_constant <= 0.0:
        return bias + amplitude * sine, amplitude * frequency * cosine
    elapsed, turn = time / time_constant, frequency * time_constant
    fading = math.exp(-elapsed)
    share = 1.0 / (1.0 + turn * turn)
    transient = turn * (2.0 * share + elapsed) * fading
    swing = share * ((1.0 - turn * turn) * sine - 2.0 * turn * cosine) + transient
    swing_rate = share * frequency * ((1.0 - turn * turn) * cosine + 2.0 * turn * sine)
    swing_rate = swing_rate + (turn * fading - transient) / time_constant
    position = bias * (1.0 - (1.0 + elapsed) * fading) + amplitude * share * swing
    return position, bias * elapsed * fading / time_constant + amplitude * share * swing_rate


def ramp(time, time_constant):
    """Response of the filter 1 / (time_constant s + 1)^2 to an input that grows as time from t = 0
    on, and its rate.
    """
    if time <= 0.0:
        return 0.0, 0.0
    fading = math.exp(-time / time_constant)
    rate = 1.0 - (1.0 + time / time_constant) * fading
    return time - 2.0 * time_constant + (time + 2.0 * time_constant) * fading, rate


def dug(time, reach, penetrate, curl, lift, dump, home, time_constant):
    """Extension and its rate of the dig pattern: straight from phase to phase, behind the
    filter.
    """
    goals = (reach, penetrate, curl, lift, dump, home)
    position, rate, slope, start, level = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(6):
        next_slope = (goals[i] - level) / (PHASES[i] - start)
        further, faster = ramp(time - start, time_constant)
        position, rate = (
            position + (next_slope - slope) * further,
            rate + (next_slope - slope) * faster,
        )
        slope, start, level = next_slope, PHASES[i], goals[i]
    further, faster = ramp(time - start, time_constant)
    return position - slope * further, rate - slope * faster


@cl.signal(time_constant=checks.non_negative)
def swing(time, bias, amplitude, frequency, time_constant):
    """Extension of an actuator in simulation 1 [m]."""
    return swung(time, bias, amplitude, frequency, time_constant)[0]


@cl.signal(time_constant=checks.positive)
def dig(time, reach, penetrate, curl, lift, dump, home, time_constant):
    """Extension of an actuator in simulations 2 and 3 [m]."""
    return dug(time, reach, penetrate, curl, lift, dump, home, time_constant)[0]


@cl.effort
def swing_servo(
    time, position, rate, bias, amplitude, frequency, time_constant, stiffness, damping
):
    """Force [N] of a position controller that follows swing."""
    goal, goal_rate = swung(time, bias, amplitude, frequency, time_constant)
    return stiffness * (goal - position) + damping * (goal_rate - rate)


@cl.effort
def dig_servo(
    time,
    position,
    rate,
    reach,
    penetrate,
    curl,
    lift,
    dump,
    home,
    time_constant,
    stiffness,
    damping,
):
    """Force [N] of a position controller that follows dig."""
    goal, goal_rate = dug(time, reach, penetrate, curl, lift, dump, home, time_constant)
    return stiffness * (goal - position) + damping * (goal_rate - rate)


def scene(
    *,
    simulation: int = 1,
    time_constant: float | None = None,
    load_x: float = -150.0,
    load_y: float = 150.0,
    friction: str = "breakaway",
    coefficient: float = 0.1,
    pin_radius: float = 0.010,
    overlap: float = 0.060,
    drive: str = "motion",
    stiffness: float = 5e6,
    damping: float = 5e4,
    transition_rate: float = 1e-3,
) -> cl.Scene:
    """Boom, stick and bucket moved by three actuators; 40 s, which is the entire dig pattern.

    simulation: 1 (sinusoids), 2 (slowly filtered dig pattern) or 3 (fast filtered dig pattern) [-]
    time_constant: of the input filter (default: 0.1, 0.1, 0.01 by simulation); 0, in simulation 1:
        no filter [s]
    load_x: force on the tooth tip along x [N]
    load_y: force on the tooth tip along y [N]
    friction: none, breakaway (the source's levels), breakaway_smooth (smooth at rest) or coulomb
        (made by loads) [-]
    coefficient: coefficient of friction of coulomb, assumed [-]
    pin_radius: radius of the pins for coulomb, assumed [m]
    overlap: of rods and barrels for coulomb, assumed [m]
    drive: motion (prescribed; forces follow) or force (of position controllers; the motion follows)
        [-]
    stiffness: of the position controllers [N/m]
    damping: of the position controllers [N s/m]
    transition_rate: rate over which coulomb turns round, for drive=force [rad/s or m/s]
    """
    if simulation not in TIME_CONSTANTS:
        raise ValueError(f"simulation must be 1, 2 or 3, got {simulation!r}")
    if time_constant is None:
        time_constant = TIME_CONSTANTS[simulation]
    cl.one_of("drive", drive, ("motion", "force"))
    pins, slides = _friction(friction, coefficient, transition_rate if drive == "force" else 0.0)
    on_pins, on_slides = (
        {"friction": pins, "pin_radius": pin_radius},
        {"friction": slides, "overlap": overlap},
    )
    bodies, hinge, parts = {"base": cl.ground} | _links(), (0.0, 0.0), []
    names = [*bodies]
    for i, (before, name) in enumerate(zip(names, names[1:], strict=False), 1):
        actuator, base, moved = ACTUATORS[name], bodies[before], bodies[name]
        barrel, rod = _halves(name, actuator)
        slide = cl.Prismatic(barrel["guide"], rod["piston"], name=f"{name}_slide", **on_slides)
        parts += [
            cl.Revolute(base.at(*hinge), moved["hinge"], name=f"J{i}", **on_pins),
            cl.Revolute(base.at(*actuator.base), barrel["pin"], name=f"{name}_base", **on_pins),
            slide,
            cl.Revolute(rod["pin"], moved.at(*actuator.end), name=f"{name}_end", **on_pins),
            _drive(drive, slide, name, simulation, time_constant, stiffness, damping),
        ]
        hinge = LINKS[name][1]
    load = cl.Force(bodies["bucket"]["tip"], x=load_x, y=load_y, name="load")
    return cl.Scene(*parts, load, gravity=(0.0, -GRAVITY), name="mobile_manipulator")


def _links() -> dict[str, cl.Body]:
    links = {}
    for name, (mass, end, angle) in LINKS.items():
        com = (0.5 * end[0], 0.5 * end[1])
        points = {"hinge": (0.0, 0.0), "tip": end} if name == "bucket" else {"hinge": (0.0, 0.0)}
        links[name] = cl.Body(
            name, mass, _inertia(mass, com), points=points, com=com, angle=cl.degree(angle)
        )
    return links


def _halves(name: str, actuator: Actuator) -> tuple[cl.Body, cl.Body]:
    """Barrel and rod of an actuator; their frames stand at their pins, x along the actuator."""
    barrel, rod, angle = actuator.barrel_com, actuator.rod_com, cl.degree(actuator.angle)
    points = {"pin": (0.0, 0.0), "guide": (actuator.length - PISTON, 0.0)}
    inertia = _inertia(actuator.barrel_mass, barrel)
    first = cl.Body(
        f"{name}_barrel", actuator.barrel_mass, inertia, points=points, com=barrel, angle=angle
    )
    points = {"pin": (0.0, 0.0), "piston": (-PISTON, 0.0)}
    return first, cl.Body(
        f"{name}_rod",
        actuator.rod_mass,
        _inertia(actuator.rod_mass, rod),
        points=points,
        com=rod,
        angle=angle,
    )


def _inertia(mass: float, com: tuple[float, float]) -> float:
    """Assumed moment of inertia about the centre of mass: that of a rod twice as long as the centre
    is far.
    """
    return mass * (com[0] ** 2 + com[1] ** 2) / 3.0


def _drive(kind, slide, name, simulation, time_constant, stiffness, damping) -> cl.Drive:
    """The actuator's extension as requested, prescribed or as the goal of a position controller."""
    inputs, motion, servo = (
        (SWINGS, swing, swing_servo) if simulation == 1 else (DIGS, dig, dig_servo)
    )
    names = [n for n in motion.inputs if n != "time_constant"]
    numbers = dict(zip(names, inputs[name], strict=True)) | {"time_constant": time_constant}
    asked = motion(**numbers)
    if kind == "motion":
        return cl.Drive(slide, motion=asked, name=name)
    goal = swung if simulation == 1 else dug
    position, rate = goal(0.0, **numbers)
    force = servo(**numbers, stiffness=stiffness, damping=damping)
    return cl.Drive(slide, force=force, start=position, speed_start=rate, name=name)


def _friction(kind: str, coefficient: float, transition_rate: float) -> tuple:
    """Laws of pins and slides; breakaway levels and viscous coefficients are the source's."""
    cl.one_of("friction", kind, ("none", "breakaway", "breakaway_smooth", "coulomb"))
    if kind == "none":
        return None, None
    if kind == "coulomb":
        laws = (
            cl.joint_coulomb(coefficient=coefficient, viscous=v, transition_rate=transition_rate)
            for v in VISCOUS
        )
    elif kind == "breakaway":
        laws = (
            cl.breakaway_linear(**LEVELS, viscous=v, decay=10.0, threshold=1e-4) for v in VISCOUS
        )
    else:
        laws = (cl.breakaway_smooth(**LEVELS, viscous=v, breakaway_rate=0.1) for v in VISCOUS)
    return tuple(laws)
