"""Slider-crank with clearance between rod and slider, or in its guide: the benchmark of the Flores
group.

Inputs: crank 0.05 m, rod 0.12 m, slider 0.14 kg, 5000 rpm, bearing radius 10 mm (Flores, Ambrosio,
Claro and Lankarani, 2004 to 2009). Centres of mass at mid-length, the journal belongs to the
slider; crank and slider inertia do not matter at constant speed.
"""

import clearance as cl

BEARING_RADIUS = 10e-3
BEARING_LENGTH = 40e-3
#: of the slider in a guide with clearance; the benchmark's guide is ideal
BLOCK = {"overlap": 60e-3, "height": 40e-3, "width": 40e-3}
#: twice the kinetic energy over the squared crank speed, mean of a turn: the size of finite drives
#: [kg m2]
INERTIA = 8e-4


def scene(
    *,
    speed: float = cl.rpm(5000),
    clearance: float = 0.5e-3,
    guide_clearance: float = 0.1e-3,
    joints: str = "C",
    model: str = "dry",
    viscosity: float = 0.4,
    restitution: float = 0.9,
    contact: str = "auto",
    friction: str = "none",
    friction_coefficient: float = 0.03,
    film: str = "table",
    film_torques: bool = False,
    ambient: float = 0.0,
    flow_factors: bool = False,
    mesh: str = "auto",
    roughness: float = 0.8e-6,
    transition: str = "load_sharing",
    thresholds: str = "auto",
    memberships: str = "cosine",
    asperity: str = "auto",
    wear: float = 0.0,
    wear_journal: float = 0.0,
    drive: str = "speed",
) -> cl.Scene:
    """Slider-crank, crank angle 0 (outer dead centre) at t = 0.

    speed: crank speed; of finite drives that asked for, or at which they idle [rad/s]
    clearance: radial clearance of joint C [m]
    guide_clearance: clearance of the guide on either side of the slider [m]
    joints: clearance joints, "C" (between rod and slider), "guide" or both [-]
    model: ideal, dry, lubricated or mixed (film, asperities and contact) [-]
    viscosity: dynamic viscosity of the oil [Pa s]
    restitution: coefficient of restitution of the dry contact [-]
    contact: law, as hertz or impact(damping=440); auto: lankarani_nikravesh when dry, winkler when
        mixed [-]
    friction: friction law of contact and asperities: none, coulomb, stribeck, lugre, ... [-]
    friction_coefficient: coefficient of friction of contact and asperities [-]
    film: film law: table (of the Reynolds equation), harmonic, short, long, pinkus_sternlicht,
        sommerfeld, fem, ... [-]
    film_torques: whether the film drags on both bodies; the benchmark leaves it out [-]
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
    wear: coefficient of wear of the bearings, Archard's; 0: none [m2/N]
    wear_journal: that of the journals [m2/N]
    drive: speed (prescribed), pi, motor, kloss or dc, or with parameters as motor(stall=5,
        no_load=69.1) [-]
    """
    crank = cl.Body(
        "crank", mass=0.30, inertia=6.25e-5, points={"shaft": (-0.025, 0), "pin": (0.025, 0)}
    )
    rod = cl.Body("rod", mass=0.21, inertia=2.5e-4, points={"pin": (-0.06, 0), "slider": (0.06, 0)})
    slider = cl.Body("slider", mass=0.14, inertia=1e-5, points={"pin": (0, 0)})
    factory = cl.joint_factory(
        joints,
        ("C", "guide"),
        model=model,
        clearance=clearance,
        radius=BEARING_RADIUS - clearance,
        length=BEARING_LENGTH,
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
        wear=wear,
        wear_journal=wear_journal,
    )
    return cl.Scene(
        cl.Revolute(cl.ground.at(0, 0), crank["shaft"], name="A"),
        cl.Revolute(crank["pin"], rod["pin"], name="B"),
        factory("C", rod["slider"], slider["pin"]),
        factory.slide(
            "guide", cl.ground.at(0, 0), slider["pin"], clearance=guide_clearance, **BLOCK
        ),
        cl.crank_drive(drive, crank, speed=speed, inertia=INERTIA),
        name="slider_crank",
    )
