"""Andrews' squeezing mechanism as a case, for `clearance work-precision --until 0.03 --peers`.

Seven bodies in three loops, one degree of freedom, no clearance and no friction: the smooth problem
of integrators. Source: Mazzia and Magherini, Test Set for Initial Value Problem Solvers (2008).
"""

import clearance as cl

#: angles where it starts [rad]; those of the coupler rods are relative to the next body
CRANK, TRIANGLE, LEFT, UPPER, RIGHT, LOWER = (
    -0.0617138900142764496,
    0.455279819163070380,
    0.222668390165885884,
    0.487364979543842550,
    -0.222668390165885884,
    1.23054744454982119,
)
#: places of the fixed points [m]
FIXED = {"A": (-0.06934, -0.00227), "B": (-0.03635, 0.03273), "C": (0.014, 0.072)}
STIFFNESS, LENGTH = 4530.0, 0.07785  # of the spring [N/m, m]


def scene(*, torque: float = 0.033) -> cl.Scene:
    """Squeezing mechanism, at rest at t = 0.

    torque: of the motor on the crank [N m]
    """
    bodies = {
        name: cl.Body(name, mass, inertia, points=points, com=com, angle=angle)
        for name, mass, inertia, angle, com, points in (
            ("K1", 0.04325, 2.194e-6, CRANK, (92e-5, 0), {"O": (0, 0), "E": (7e-3, 0)}),
            ("K2", 0.00365, 4.410e-7, CRANK, (-0.0115, 0), {"E": (0, 0), "P": (-0.028, 0)}),
            (
                "K3",
                0.02373,
                5.255e-6,
                TRIANGLE,
                (0.01043, -0.01874),
                {"B": (0, 0), "P": (0, -0.035), "D": (0.02, -0.018)},
            ),
            ("K4", 0.00706, 5.667e-7, LEFT + UPPER, (0, -579e-5), {"Q": (0, 0), "P": (0, -0.02)}),
            ("K5", 0.07050, 1.169e-5, UPPER, (0.02308, 916e-5), {"A": (0, 0), "Q": (0.04, 0)}),
            ("K6", 0.00706, 5.667e-7, RIGHT + LOWER, (579e-5, 0), {"R": (0, 0), "P": (0.02, 0)}),
            ("K7", 0.05498, 1.912e-5, LOWER, (-449e-5, -0.01228), {"A": (0, 0), "R": (0, -0.04)}),
        )
    }
    k1, k2, k3, k4, k5, k6, k7 = bodies.values()
    fixed = {name: cl.ground.at(*position) for name, position in FIXED.items()}
    return cl.Scene(
        cl.Revolute(cl.ground, k1["O"], name="O"),
        cl.Revolute(k1["E"], k2["E"], name="E"),
        cl.Revolute(fixed["B"], k3["B"], name="B"),
        cl.Revolute(k2["P"], k3["P"], name="P3"),
        cl.Revolute(k2["P"], k4["P"], name="P4"),
        cl.Revolute(k4["Q"], k5["Q"], name="Q"),
        cl.Revolute(fixed["A"], k5["A"], name="A5"),
        cl.Revolute(k2["P"], k6["P"], name="P6"),
        cl.Revolute(k6["R"], k7["R"], name="R"),
        cl.Revolute(fixed["A"], k7["A"], name="A7"),
        cl.SpringDamper(k3["D"], fixed["C"], stiffness=STIFFNESS, free_length=LENGTH),
        cl.Torque(k1, torque),
        gravity=(0, 0),
        name="squeezer",
    )
