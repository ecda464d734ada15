"""clearance: tribodynamics of planar mechanisms whose joints have clearance, lubricant and friction."""

from clearance import laws
from clearance.joints import ClearanceRevolute, Prismatic, Revolute
from clearance.laws import (
    contact,
    coulomb,
    effort,
    film,
    friction,
    hertz_stiffness,
    hunt_crossley_memoryless,
    lankarani_nikravesh,
    pinkus_sternlicht,
    signal,
)
from clearance.loads import Drive, Force, SpringDamper, Torque, TorsionSpring
from clearance.materials import Lubricant, Material, steel
from clearance.scene import Body, Point, Scene, ground
from clearance.units import cP, degree, mm, rpm, um

__all__ = [
    "Body", "ClearanceRevolute", "Drive", "Force", "Lubricant", "Material", "Point", "Prismatic", "Revolute", "Scene",
    "SimulationError", "SpringDamper", "Torque", "TorsionSpring", "cP", "contact", "coulomb", "degree", "effort",
    "film", "friction", "ground", "hertz_stiffness", "hunt_crossley_memoryless",
    "lankarani_nikravesh", "laws", "load_case", "mm",
    "open_result", "pinkus_sternlicht", "rpm", "signal", "simulate", "steel", "um",
]  # fmt: skip

_LAZY = {
    "simulate": "clearance.simulation", "SimulationError": "clearance.simulation", "open_result": "clearance.results",
    "Result": "clearance.results", "load_case": "clearance.catalogue",
}  # fmt: skip


def __getattr__(name: str):
    """Describing a scene needs neither numba nor h5py: what does is imported on first use."""
    if name in _LAZY:
        from importlib import import_module

        value = getattr(import_module(_LAZY[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'clearance' has no attribute {name!r}")
