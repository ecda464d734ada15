"""clearance: tribodynamics of planar mechanisms whose joints have clearance, lubricant and friction."""

from clearance import film, laws
from clearance.body import Body, Point, ground
from clearance.choices import crank_drive, joint_factory, joint_friction_law, one_of
from clearance.elements import (
    ClearanceRevolute,
    Drive,
    Force,
    Prismatic,
    Revolute,
    SpringDamper,
    ThermalNode,
    Torque,
    TorsionSpring,
)
from clearance.film.bearing import Bearing, FilmSolution, Groove
from clearance.film.online import conserving_film, fast_film, fem_film
from clearance.film.tabulated import table_film
from clearance.laws import (
    ambrosio,
    asperity,
    bengisu_akay,
    breakaway_linear,
    breakaway_smooth,
    bristle,
    composite_roughness,
    contact,
    contact_flow_factor,
    contact_modulus,
    coulomb,
    coulomb_tanh,
    coulomb_viscous,
    dc_motor,
    delivered_restitution,
    drive_state,
    effort,
    exact_damping,
    exact_restitution,
    film_torques,
    flores,
    flores_hybrid,
    friction,
    full_sommerfeld,
    fuzzy,
    fuzzy_table,
    gonthier,
    greenwood_tripp,
    greenwood_williamson,
    harmonic,
    herbert_mcwhannell,
    hertz,
    hertz_stiffness,
    hu_guo,
    hunt_crossley,
    hunt_crossley_memoryless,
    impact,
    johnson,
    joint_bristle,
    joint_coulomb,
    joint_friction,
    joint_lugre,
    joint_lugre_loaded,
    joint_stribeck,
    kelvin_voigt,
    kloss,
    lankarani_nikravesh,
    layer_modulus,
    lee_wang,
    liu,
    load_sharing,
    long_film,
    lugre,
    memberships,
    motor_line,
    pi_speed,
    pinkus_sternlicht,
    pressure_flow_factor,
    ramp,
    shear_flow_factor,
    short_film,
    signal,
    stribeck,
    superposed,
    threlfall,
    transition,
    winkler,
    zhiying_qishao,
)
from clearance.materials import HeatBalance, Lubricant, Material, steel
from clearance.scene import Scene
from clearance.units import cP, degree, mm, rpm, um
from clearance.version import VERSION

__version__ = VERSION

__all__ = [
    "Bearing", "Body", "ClearanceRevolute", "Drive", "FilmSolution", "Force", "Groove", "HeatBalance", "Lubricant",
    "Material", "Point", "Prismatic", "Revolute", "Scene", "SimulationError", "SpringDamper", "SweepError",
    "ThermalNode", "Torque", "TorsionSpring", "ambrosio", "asperity", "bengisu_akay", "breakaway_linear",
    "breakaway_smooth", "bristle", "cP", "composite_roughness", "conserving_film", "contact", "contact_flow_factor",
    "contact_modulus", "coulomb", "coulomb_tanh", "coulomb_viscous", "crank_drive", "dc_motor", "degree",
    "delivered_restitution", "drive_state", "effort", "exact_damping", "exact_restitution", "fast_film", "fem_film",
    "film", "film_torques", "flores", "flores_hybrid", "friction", "full_sommerfeld", "fuzzy", "fuzzy_table",
    "gonthier", "greenwood_tripp", "greenwood_williamson", "grid", "ground", "harmonic", "herbert_mcwhannell",
    "hertz", "hertz_stiffness", "hole_check", "hu_guo", "hunt_crossley", "hunt_crossley_memoryless", "impact",
    "inverse_dynamics", "johnson", "joint_bristle", "joint_coulomb", "joint_factory", "joint_friction",
    "joint_friction_law", "joint_lugre", "joint_lugre_loaded", "joint_stribeck", "kelvin_voigt", "kloss",
    "lankarani_nikravesh", "laws", "layer_modulus", "lee_wang", "liu", "load_case", "load_sharing", "long_film",
    "lugre", "memberships", "mm", "motor_line", "one_of", "open_result", "open_sweep", "pi_speed",
    "pinkus_sternlicht", "plot", "pressure_flow_factor", "ramp", "report", "rpm", "sampled", "shear_flow_factor",
    "short_film", "signal", "simulate", "solve_film", "steel", "stribeck", "superposed", "sweep", "table_film",
    "threlfall", "transition", "um", "winkler", "zhiying_qishao", "zipped",
]  # fmt: skip

_LAZY = {
    "simulate": "clearance.simulation", "SimulationError": "clearance.simulation", "open_result": "clearance.results",
    "Result": "clearance.results", "load_case": "clearance.catalogue", "hole_check": "clearance.regimes",
    "inverse_dynamics": "clearance.inverse.dynamics",
    "solve_film": "clearance.film.solvers", "sweep": "clearance.sweeping.driver",
    "SweepError": "clearance.sweeping.driver", "open_sweep": "clearance.sweeping.index",
    "Sweep": "clearance.sweeping.index", "grid": "clearance.sweeping.points", "zipped": "clearance.sweeping.points",
    "sampled": "clearance.sweeping.points", "plot": "clearance.commands.plot", "report": "clearance.postprocess.report",
}  # fmt: skip


def __getattr__(name: str):
    """Describing a scene needs neither numba nor h5py: what does is imported on first use."""
    if name in _LAZY:
        from importlib import import_module

        value = getattr(import_module(_LAZY[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'clearance' has no attribute {name!r}")
