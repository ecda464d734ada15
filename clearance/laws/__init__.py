"""The physics of one joint, as plain functions: one file a family."""

from clearance.laws.asperity import (
    composite_roughness,
    contact_flow_factor,
    greenwood_tripp,
    greenwood_williamson,
    pressure_flow_factor,
    shear_flow_factor,
)
from clearance.laws.contact import (
    contact_modulus,
    delivered_restitution,
    exact_damping,
    exact_restitution,
    flores,
    gonthier,
    herbert_mcwhannell,
    hertz,
    hertz_stiffness,
    hu_guo,
    hunt_crossley,
    hunt_crossley_memoryless,
    impact,
    johnson,
    kelvin_voigt,
    lankarani_nikravesh,
    layer_modulus,
    lee_wang,
    liu,
    winkler,
    zhiying_qishao,
)
from clearance.laws.drive import dc_motor, kloss, motor_line, pi_speed, ramp
from clearance.laws.film import (
    film_torques,
    full_sommerfeld,
    harmonic,
    long_film,
    pinkus_sternlicht,
    short_film,
)
from clearance.laws.friction import (
    ambrosio,
    bengisu_akay,
    coulomb,
    coulomb_tanh,
    coulomb_viscous,
    lugre,
    stribeck,
    threlfall,
)
from clearance.laws.joint_friction import (
    breakaway_linear,
    breakaway_smooth,
    joint_coulomb,
    joint_lugre,
    joint_lugre_loaded,
    joint_stribeck,
)
from clearance.laws.pad import full_pad
from clearance.laws.spring import (
    backlash,
    cubic_spring,
    friction_damper,
    quadratic_damper,
    stop,
)
from clearance.laws.transition import flores_hybrid, fuzzy, fuzzy_table, load_sharing, memberships, superposed
from clearance.laws.wear import archard, archard_reye, sarkar

# isort: split
# the families last: they have the names of the modules of their laws, and are what is public
from clearance.laws.law import (
    BoundLaw,
    Derived,
    FilmJoint,
    Law,
    asperity,
    bristle,
    contact,
    drive_state,
    effort,
    film,
    friction,
    joint_bristle,
    joint_friction,
    pad,
    signal,
    spring,
    surface_wear,
    transition,
)

#: the families, to decorate laws of one's own with, and the laws by family
FAMILIES = (
    contact,
    friction,
    bristle,
    joint_friction,
    joint_bristle,
    film,
    pad,
    asperity,
    transition,
    spring,
    signal,
    effort,
    drive_state,
    surface_wear,
)  # fmt: skip

__all__ = [
    "backlash", "cubic_spring", "friction_damper", "quadratic_damper", "spring", "stop",
    "BoundLaw", "Derived", "FAMILIES", "FilmJoint", "Law", "ambrosio", "archard", "archard_reye", "asperity",
    "bengisu_akay", "breakaway_linear",
    "breakaway_smooth", "bristle", "composite_roughness", "contact", "contact_flow_factor", "contact_modulus",
    "coulomb", "coulomb_tanh", "coulomb_viscous", "dc_motor", "delivered_restitution", "drive_state", "effort",
    "exact_damping", "exact_restitution", "film", "film_torques", "flores", "flores_hybrid", "friction",
    "full_pad", "full_sommerfeld", "fuzzy", "fuzzy_table", "gonthier", "greenwood_tripp", "greenwood_williamson",
    "harmonic",
    "herbert_mcwhannell", "hertz", "hertz_stiffness", "hu_guo", "hunt_crossley", "hunt_crossley_memoryless", "impact",
    "johnson", "joint_bristle", "joint_coulomb", "joint_friction", "joint_lugre", "joint_lugre_loaded",
    "joint_stribeck", "kelvin_voigt", "kloss", "lankarani_nikravesh", "layer_modulus", "lee_wang", "liu",
    "load_sharing", "long_film", "lugre", "memberships", "motor_line", "pad", "pi_speed", "pinkus_sternlicht",
    "pressure_flow_factor", "ramp", "shear_flow_factor", "sarkar", "short_film", "signal", "stribeck",
    "superposed", "surface_wear",
    "threlfall", "transition", "winkler", "zhiying_qishao",
]  # fmt: skip
