"""Slider-crank whose bushing wears through its wall, after the test of Mukras, Kim, Mauntler,
Schmitz and Sawyer.

A steel pin on the crank turns in a PTFE bushing in the rod, joint B; a spring loads the slider. The
set *wear-A* is assumed. SAE 2009-01-0403 and J. Tribology 132 (2010) 031604 have the same kind of
test (some 0.5 mm after 21,400 turns at 30 rpm). Masses, lengths and clearance here are ours, so no
number can be compared with theirs.
"""

import clearance as cl

CRANK, ROD = 76.2e-3, 203.2e-3
SPRING = 525.0  # N/m
STRETCH = 0.15  # m, at the inner dead centre
ANCHOR = -1.0  # m, of the spring, on the slider's line behind the crank


def scene(
    *,
    speed: float = cl.rpm(30),
    clearance: float = 0.1e-3,
    radius: float = 9.5e-3,
    length: float = 13.1e-3,
    wear: float = 5.05e-13,
    wear_journal: float = 0.0,
    layer_modulus: float = 2e11,
    restitution: float = 0.5,
    friction_coefficient: float = 0.0,
    model: str = "dry",
) -> cl.Scene:
    """Slider-crank with a worn bushing, crank angle 0 (outer dead centre) at t = 0.

    speed: crank speed [rad/s]
    clearance: radial clearance of the new bushing [m]
    radius: of the pin [m]
    length: of the bushing [m]
    wear: coefficient of wear of the bushing, Archard's [m2/N]
    wear_journal: that of the pin [m2/N]
    layer_modulus: of the elastic foundation, pressure over depth [Pa/m]
    restitution: coefficient of restitution of the contact [-]
    friction_coefficient: of the contact, Coulomb's, smooth at rest; PTFE: 0.13 [-]
    model: ideal or dry [-]
    """
    crank = cl.Body("crank", 0.5, 5e-4, points={"A": (0, 0), "B": (CRANK, 0)})
    rod = cl.Body("rod", 0.2, 7e-4, points={"B": (-0.5 * ROD, 0), "C": (0.5 * ROD, 0)})
    slider = cl.Body("slider", 2.0, 1e-3, points={"C": (0, 0)})
    cl.one_of("model", model, ("ideal", "dry"))
    pin = cl.Revolute(rod["B"], crank["B"], name="B")
    if model == "dry":
        pin = cl.ClearanceRevolute(
            rod["B"],
            crank["B"],
            name="B",
            radius=radius,
            clearance=clearance,
            length=length,
            contact=cl.winkler(layer_modulus=layer_modulus, restitution=restitution),
            friction=cl.coulomb_tanh(coefficient=friction_coefficient)
            if friction_coefficient
            else None,
            wear=cl.archard(coefficient=wear) if wear else None,
            wear_journal=cl.archard(coefficient=wear_journal) if wear_journal else None,
        )
    return cl.Scene(
        cl.Revolute(cl.ground.at(0, 0), crank["A"], name="A"),
        pin,
        cl.Revolute(rod["C"], slider["C"], name="C"),
        cl.Prismatic(cl.ground.at(0, 0), slider["C"], name="guide"),
        cl.SpringDamper(
            cl.ground.at(ANCHOR, 0),
            slider["C"],
            stiffness=SPRING,
            free_length=ROD - CRANK - ANCHOR - STRETCH,
            name="S",
        ),
        cl.Drive(crank, speed=speed, start=0.0),
        name="wear_a",
    )
