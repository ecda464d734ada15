"""Crank-rocker four-bar linkage with an optional clearance joint between coupler and rocker.

A textbook Grashof linkage with steel bars of 20 mm x 10 mm section; all numbers are this case's
own.
"""

import clearance as cl

#: twice the kinetic energy over the squared crank speed, mean of a turn: the size of finite drives
#: [kg m2]
INERTIA = 7e-4


def _bar(name: str, length: float, angle: float) -> cl.Body:
    mass = cl.steel.density * 0.020 * 0.010 * (length + 0.020)
    inertia = mass * ((length + 0.020) ** 2 + 0.020**2) / 12.0
    ends = {"near": (-0.5 * length, 0.0), "far": (0.5 * length, 0.0)}
    return cl.Body(name, mass, inertia, points=ends, angle=angle)


def scene(
    *,
    speed: float = cl.rpm(300),
    options: cl.JointOptions = cl.JointOptions(joints="C", model="ideal"),
    drive: str = "speed",
) -> cl.Scene:
    """Crank-rocker: crank 50 mm, coupler 150 mm, rocker 120 mm, frame 160 mm.

    speed: crank speed; of finite drives the set or idling speed [rad/s]
    joints: clearance joints, a comma list of A B C D [-]
    drive: speed (prescribed), pi, motor, kloss or dc, or with parameters as motor(stall=5,
        no_load=69.1) [-]
    """
    crank, coupler, rocker = (
        _bar("crank", 0.050, 0.0),
        _bar("coupler", 0.150, 0.8),
        _bar("rocker", 0.120, 1.6),
    )
    joint = options.factory("ABCD", radius=10e-3, length=20e-3)
    return cl.Scene(
        joint("A", cl.ground.at(0, 0), crank["near"]),
        joint("B", crank["far"], coupler["near"]),
        joint("C", coupler["far"], rocker["far"]),
        joint("D", cl.ground.at(0.160, 0), rocker["near"]),
        cl.crank_drive(drive, crank, speed=speed, inertia=INERTIA),
        name="four_bar",
    )
