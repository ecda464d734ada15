"""Six-bar rocking feeder with clearance joints (topology of Jin, Wang, Liang, Wei, Chang and Zhou,
Arch. Appl. Mech. 93 (2023) 2831, doi 10.1007/s00419-023-02410-7).

Of the source only the topology and the two frame distances (90 mm and 170 mm between the pivots A
and D) are known to us. Every other number is the assumed set *feeder-A*. Its link lengths assemble
and run. Its bars are of steel with a section of 20 mm x 10 mm. Its joints have a radius of 10 mm
and a length of 20 mm. Results cannot be compared with the source's figures number by number.

Crank A-B, rod 2 B-C, rocker D-C-E, rod 4 E-F, slider F along x at height 80 mm.

The source's transitional joint is `model=mixed`: film and contact weighted by fuzzy states of the
film thickness ratio. Its oil has 5 mPa s by default. At 300 rpm and 0.1 mm that is where
the journal comes down to the roughness: the ratio falls to 0.9, all three states occur, and speed,
clearance and further joints show. With the 50 mPa s of the film-only joint the ratio stays above 7
and the transition never acts.
"""

from dataclasses import replace

import clearance as cl

#: dynamic viscosity where none is given [Pa s]: of joints that never leave full film, and of mixed
#: ones
THICK_OIL = 0.05
THIN_OIL = 0.005
JOURNAL_RADIUS = 10e-3
BEARING_LENGTH = 20e-3
GUIDE_HEIGHT = 0.080
PIVOT_D = (0.170, -0.090)
#: twice the kinetic energy over the squared crank speed, mean of a turn: the size of finite drives
#: [kg m2]
INERTIA = 2e-3


def scene(
    *,
    speed: float = cl.rpm(300),
    options: cl.JointOptions = cl.JointOptions(
        joints="B", model="lubricated", viscosity="auto", friction="coulomb", transition="fuzzy"
    ),
    drive: str = "speed",
) -> cl.Scene:
    """Six-bar rocking feeder (assumed parameter set feeder-A), crank angle 0 at t = 0.

    speed: crank speed; of finite drives the set or idling speed [rad/s]
    joints: clearance joints, a comma list of A B C D E F [-]
    viscosity: dynamic viscosity of the oil; auto: 0.005 when mixed, 0.05 else [Pa s]
    drive: speed (prescribed), pi, motor, kloss or dc, or with parameters as motor(stall=5,
        no_load=69.1) [-]
    """
    crank = cl.Body(
        "crank", mass=0.0942, inertia=3.140e-5, points={"A": (-0.020, 0), "B": (0.020, 0)}
    )
    rod2 = cl.Body(
        "rod2", mass=0.2826, inertia=7.724e-4, points={"B": (-0.080, 0), "C": (0.080, 0)}, angle=0.6
    )
    rocker = cl.Body(
        "rocker",
        mass=0.3140,
        inertia=1.057e-3,
        points={"D": (-0.090, 0), "C": (0.030, 0), "E": (0.090, 0)},
        angle=1.6,
    )
    rod4 = cl.Body(
        "rod4", mass=0.2669, inertia=6.517e-4, points={"E": (-0.075, 0), "F": (0.075, 0)}
    )
    slider = cl.Body("slider", mass=0.500, inertia=1e-4, points={"F": (0, 0)})
    if options.viscosity == "auto":
        viscosity = THIN_OIL if options.model == "mixed" else THICK_OIL
        options = replace(options, viscosity=viscosity)
    joint = options.factory("ABCDEF", radius=JOURNAL_RADIUS, length=BEARING_LENGTH)
    return cl.Scene(
        joint("A", cl.ground.at(0, 0), crank["A"]),
        joint("B", crank["B"], rod2["B"]),
        joint("C", rod2["C"], rocker["C"]),
        joint("D", cl.ground.at(*PIVOT_D), rocker["D"]),
        joint("E", rocker["E"], rod4["E"]),
        joint("F", rod4["F"], slider["F"]),
        cl.Prismatic(cl.ground.at(0, GUIDE_HEIGHT), slider["F"], name="guide"),
        cl.crank_drive(drive, crank, speed=speed, inertia=INERTIA),
        name="six_bar_feeder",
    )
