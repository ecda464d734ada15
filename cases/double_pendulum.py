"""Double pendulum: two free degrees of freedom, no drive, chaotic; energy is its exact
invariant.
"""

import clearance as cl


def scene(
    *,
    length: float = 0.5,
    mass: float = 1.0,
    angle1: float = 0.0,
    angle2: float = 0.0,
    damping: float = 0.0,
) -> cl.Scene:
    """Two equal uniform rods hinged to ground and to each other, released from rest.

    length: length of each rod [m]
    mass: mass of each rod [kg]
    angle1: start angle of the first rod, from the horizontal [rad]
    angle2: start angle of the second rod, from the horizontal [rad]
    damping: torsional damping in both hinges [N m s/rad]
    """
    inertia = mass * length**2 / 12.0
    ends = {"top": (-0.5 * length, 0.0), "end": (0.5 * length, 0.0)}
    upper = cl.Body("upper", mass, inertia, points=ends, angle=angle1)
    lower = cl.Body("lower", mass, inertia, points=ends, angle=angle2)
    dampers = [
        cl.TorsionSpring(cl.ground, upper, damping=damping, name="damper1"),
        cl.TorsionSpring(upper, lower, damping=damping, name="damper2"),
    ]
    return cl.Scene(
        cl.Revolute(cl.ground, upper["top"], name="A"),
        cl.Revolute(upper["end"], lower["top"], name="B"),
        *(dampers if damping else ()),
        name="double_pendulum",
    )
