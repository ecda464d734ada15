"""Five-axis chain of two mirrored arms with load-dependent joint friction (Guo, Ju and Wang,
Aerospace 11 (2024) 368).

A short bar turns on the ground. A two-bar arm hangs on its end (links 2 and 3) and another on its
middle (links 4 and 5). All axes are vertical, so gravity drives nothing, but it makes the axial
force and the bending moments of the joints, hence their friction. The source prints positions,
masses, inertias, motion and friction coefficients. Assumed by us: the start from rest, the pair of
links of 3 kg (reading), and the exponent of Stribeck's term. Further, the factor of the viscous
coefficient (the rate alone), and the three lengths of the joints, pin_radius, friction_arm,
bending_arm.

The source's equations hold for trees in space, with axes in any direction. Here all axes are
parallel: bodies move in one plane, and what is carried out of it are forces along the axes, bending
moments, and through both the friction. Left out are axes that are inclined or cross, motion out of
the plane, gyroscopic moments of bodies that tilt, and ball, universal and screw joints. In this
chain nothing is lost by that, for its axes are parallel.
"""

import clearance as cl

GRAVITY = 9.8
#: joint -> (link that carries it, where on it [m], centre of mass of its own link [m])
LINKS = {
    "1": ("ground", (0.0, 0.0), (-0.2, 0.0)),
    "2": ("link1", (-0.4, 0.0), (0.3, 0.5196)),
    "3": ("link2", (0.6, 1.0392), (0.3, -0.5196)),
    "4": ("link1", (-0.2, 0.0), (0.3, -0.5196)),
    "5": ("link4", (0.6, -1.0392), (0.3, 0.5196)),
}
#: masses of the links [kg], as the source's table can be read; moments of inertia go with the
#: masses [kg m2]
READINGS = {"P": (1.0, 3.0, 2.0, 3.0, 2.0), "Q": (1.0, 3.0, 3.0, 2.0, 2.0)}
INERTIA = {1.0: 0.01, 2.0: 0.04, 3.0: 0.06}


@cl.signal
def speeding_up(time, acceleration):
    """Angle [rad] of a joint that starts from rest at zero with a constant acceleration
    [rad/s2].
    """
    return 0.5 * acceleration * time * time


@cl.effort
def servo(time, position, rate, acceleration, stiffness, damping):
    """Torque [N m] of a position controller that follows speeding_up."""
    return stiffness * (speeding_up(time, acceleration) - position) + damping * (
        acceleration * time - rate
    )


def scene(
    *,
    reading: str = "P",
    acceleration: float = 0.2,
    friction: str = "coulomb",
    pin_radius: float = 0.02,
    friction_arm: float = 0.02,
    bending_arm: float = 0.05,
    coefficient: float = 0.005,
    viscous: float = 0.01,
    static: float = 0.05,
    stribeck_rate: float = 0.03,
    exponent: float = 2.0,
    drive: str = "motion",
    stiffness: float = 5e3,
    damping: float = 5e2,
    transition_rate: float = 1e-3,
) -> cl.Scene:
    """Five-axis chain from rest, joint angles acceleration t^2 / 2; run it for 5 s.

    reading: which links weigh 3 kg: P (2 and 4, mirrored arms) or Q (2 and 3) [-]
    acceleration: of every joint, link against link [rad/s2]
    friction: friction of the five joints: none, coulomb or stribeck [-]
    pin_radius: radius of the pins, assumed [m]
    friction_arm: of the joints' thrust faces, assumed [m]
    bending_arm: between the two places where a pin takes a bending moment, assumed [m]
    coefficient: kinetic coefficient of friction [-]
    viscous: viscous friction of a joint [N m s/rad]
    static: static coefficient of friction of stribeck [-]
    stribeck_rate: joint rate of stribeck's fall from static to kinetic [rad/s]
    exponent: of stribeck's fall: 2 (Gauss) or 1 (Tustin), assumed [-]
    drive: motion (prescribed; torques follow) or torque (of position controllers; the motion
        follows) [-]
    stiffness: of the position controllers [N m/rad]
    damping: of the position controllers [N m s/rad]
    transition_rate: joint rate over which friction turns round, for drive=torque [rad/s]
    """
    cl.one_of("reading", reading, READINGS)
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
    rubbing = {
        "friction": law,
        "pin_radius": pin_radius,
        "friction_arm": friction_arm,
        "bending_arm": bending_arm,
    }
    bodies = {"ground": cl.ground} | _links(READINGS[reading])
    joints = [
        cl.Revolute(bodies[carrier].at(*position), bodies[f"link{name}"], name=name, **rubbing)
        for name, (carrier, position, _) in LINKS.items()
    ]
    if drive == "motion":
        drives = [
            cl.Drive(j, motion=speeding_up(acceleration=acceleration), name=j.name) for j in joints
        ]
    else:
        effort = servo(acceleration=acceleration, stiffness=stiffness, damping=damping)
        drives = [
            cl.Drive(j, torque=effort, start=0.0, speed_start=0.0, name=j.name) for j in joints
        ]
    return cl.Scene(*joints, *drives, gravity=(0.0, 0.0, -GRAVITY), name="five_axis_chain")


def _links(masses: tuple[float, ...]) -> dict[str, cl.Body]:
    """The links by name; the frame of each stands at its own joint."""
    pairs = zip(LINKS.items(), masses, strict=True)
    links = (
        cl.Body(f"link{name}", mass, INERTIA[mass], com=com) for (name, (_, _, com)), mass in pairs
    )
    return {link.name: link for link in links}
