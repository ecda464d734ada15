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
    clearance: float = 1e-4,
    joints: str = "C",
    model: str = "ideal",
    viscosity: float = 0.05,
    restitution: float = 0.9,
    contact: str = "auto",
    friction: str = "none",
    friction_coefficient: float = 0.1,
    film: str = "table",
    film_torques: bool = True,
    ambient: float = 0.0,
    flow_factors: bool = False,
    mesh: str = "auto",
    roughness: float = 0.8e-6,
    transition: str = "load_sharing",
    thresholds: str = "auto",
    memberships: str = "cosine",
    asperity: str = "auto",
    drive: str = "speed",
) -> cl.Scene:
    """Crank-rocker: crank 50 mm, coupler 150 mm, rocker 120 mm, frame 160 mm.

    speed: crank speed; of finite drives that asked for, or at which they idle [rad/s]
    clearance: radial clearance of the clearance joints [m]
    joints: clearance joints, a comma list of A B C D [-]
    model: ideal, dry, lubricated or mixed (film, asperities and contact) [-]
    viscosity: dynamic viscosity of the oil [Pa s]
    restitution: coefficient of restitution of the dry contact [-]
    contact: law, as hertz or impact(damping=440); auto: lankarani_nikravesh when dry, winkler when
        mixed [-]
    friction: friction law of contact and asperities: none, coulomb, stribeck, lugre, ... [-]
    friction_coefficient: coefficient of friction of contact and asperities [-]
    film: film law: table (of the Reynolds equation), harmonic, short, long, pinkus_sternlicht,
        sommerfeld, fem, ... [-]
    film_torques: whether the film drags on both bodies [-]
    ambient: pressure at the bearing's ends above cavitation (films table, fem, conserving); 0:
        cavitates there [Pa]
    flow_factors: whether the film of table and fem is that of rough surfaces (Patir and Cheng) [-]
    mesh: cells around and over half the length (films fast, fem, conserving), as 16x2; or auto [-]
    roughness: composite rms roughness; 0 leaves out the film thickness ratio, and mixed joints need
        it [m]
    transition: how film and contact share a mixed joint: none, flores, fuzzy, load_sharing, or as
        fuzzy(squeeze=0) [-]
    thresholds: film thickness ratios dry,mixed,full of the fuzzy states; auto: 0.4,1,3 or those of
        the file [-]
    memberships: of fuzzy: cosine, or a CSV file of film thickness ratio, full film, mixed, dry [-]
    asperity: of load_sharing: greenwood_tripp, greenwood_williamson, none; auto: the first, none
        elsewhere [-]
    drive: speed (prescribed), pi, motor, kloss or dc, or with parameters as motor(stall=5,
        no_load=69.1) [-]
    """
    crank, coupler, rocker = (
        _bar("crank", 0.050, 0.0),
        _bar("coupler", 0.150, 0.8),
        _bar("rocker", 0.120, 1.6),
    )
    joint = cl.joint_factory(
        joints,
        "ABCD",
        model=model,
        clearance=clearance,
        radius=10e-3,
        length=20e-3,
        viscosity=viscosity,
        restitution=restitution,
        contact=contact,
        friction=friction,
        friction_coefficient=friction_coefficient,
        film=film,
        roughness=roughness,
        film_torques=film_torques,
        ambient=ambient,
        flow_factors=flow_factors,
        mesh=mesh,
        transition=transition,
        thresholds=thresholds,
        memberships=memberships,
        asperity=asperity,
    )
    return cl.Scene(
        joint("A", cl.ground.at(0, 0), crank["near"]),
        joint("B", crank["far"], coupler["near"]),
        joint("C", coupler["far"], rocker["far"]),
        joint("D", cl.ground.at(0.160, 0), rocker["near"]),
        cl.crank_drive(drive, crank, speed=speed, inertia=INERTIA),
        name="four_bar",
    )
