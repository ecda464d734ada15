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
    throw: float = 0.05,
    rod_length: float = 0.12,
    guide_clearance: float = 0.1e-3,
    options: cl.JointOptions = cl.JointOptions(
        clearance=0.5e-3,
        joints="C",
        model="dry",
        viscosity=0.4,
        friction_coefficient=0.03,
        film_torques=False,
    ),
    drive: str = "speed",
) -> cl.Scene:
    """Slider-crank, crank angle 0 (outer dead centre) at t = 0.

    speed: crank speed; of finite drives the set or idling speed [rad/s]
    throw: length of the crank, which keeps its mass [m]
    rod_length: length of the rod, which keeps its mass [m]
    guide_clearance: clearance of the guide on either side of the slider [m]
    clearance: radial clearance of joint C [m]
    joints: clearance joints, "C" (between rod and slider), "guide" or both [-]
    drive: speed (prescribed), pi, motor, kloss or dc, or with parameters as motor(stall=5,
        no_load=69.1) [-]
    """
    ends = {"shaft": (-0.5 * throw, 0), "pin": (0.5 * throw, 0)}
    crank = cl.Body("crank", mass=0.30, inertia=6.25e-5, points=ends)
    ends = {"pin": (-0.5 * rod_length, 0), "slider": (0.5 * rod_length, 0)}
    rod = cl.Body("rod", mass=0.21, inertia=2.5e-4, points=ends)
    slider = cl.Body("slider", mass=0.14, inertia=1e-5, points={"pin": (0, 0)})
    factory = options.factory(
        ("C", "guide"), radius=BEARING_RADIUS - options.clearance, length=BEARING_LENGTH
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
