"""Slider-crank with clearance in its guide: the benchmark of Flores, Leine and Glocker (2010).

Nothing drives it: crank and rod start stretched along the guide with 150 and -75 rad/s, the slider
in the middle. The source has rigid impacts with a restitution of 0.4; here the corners are
compliant.
"""

import clearance as cl

#: length of a run that none is given for [s]
UNTIL = 0.1
CRANK, ROD = 0.153, 0.306
HINGE_RADIUS, HINGE_LENGTH = 10e-3, 20e-3


def scene(
    *,
    speed: float = 150.0,
    clearance: float = 1e-3,
    overlap: float = 0.1,
    height: float = 0.05,
    tilt_rate: float = 0.0,
    joints: str = "guide",
    hinge_clearance: float = 0.1e-3,
    model: str = "dry",
    contact: str = "exact_restitution(stiffness=1e8)",
    restitution: float = 0.4,
    friction: str = "coulomb",
    friction_coefficient: float = 0.01,
) -> cl.Scene:
    """Slider-crank: crank 153 mm, rod 306 mm, slider 100 mm x 50 mm, 1 mm of clearance on either
    side.

    speed: crank speed at the start [rad/s]
    clearance: of the guide, on either side of the slider [m]
    overlap: length of the slider in its guide [m]
    height: height of the slider [m]
    tilt_rate: turning speed of the slider at the start [rad/s]
    joints: joints with clearance, a comma list of A B C guide [-]
    hinge_clearance: radial clearance of the hinges among them [m]
    model: ideal or dry [-]
    contact: law of corners (and hinges), as hertz(stiffness=1e8), or auto: lankarani_nikravesh by
        the radii [-]
    restitution: coefficient of restitution of the contact [-]
    friction: friction law: none, coulomb, stribeck, lugre, ... [-]
    friction_coefficient: coefficient of friction [-]
    """
    crank = cl.Body(
        "crank",
        0.038,
        7.4e-5,
        points={"A": (-0.5 * CRANK, 0), "B": (0.5 * CRANK, 0)},
        angular_velocity=speed,
    )
    rod = cl.Body(
        "rod",
        0.038,
        5.9e-4,
        points={"B": (-0.5 * ROD, 0), "C": (0.5 * ROD, 0)},
        angular_velocity=-speed * CRANK / ROD,
    )
    slider = cl.Body("slider", 0.076, 2.7e-6, points={"C": (0, 0)})
    cl.one_of("model", model, ("ideal", "dry"))
    options = cl.JointOptions(
        joints=joints,
        model=model,
        clearance=hinge_clearance,
        contact=contact,
        restitution=restitution,
        friction=friction,
        friction_coefficient=friction_coefficient,
        roughness=0.0,
    )
    factory = options.factory(("A", "B", "C", "guide"), radius=HINGE_RADIUS, length=HINGE_LENGTH)
    guide = factory.slide(
        "guide",
        cl.ground.at(0, 0),
        slider["C"],
        clearance=clearance,
        overlap=overlap,
        height=height,
        tilt_rate=tilt_rate,
    )
    return cl.Scene(
        factory("A", cl.ground.at(0, 0), crank["A"]),
        factory("B", crank["B"], rod["B"]),
        factory("C", rod["C"], slider["C"]),
        guide,
        name="guide_slider",
    )
