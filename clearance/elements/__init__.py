"""Elements: what a mechanism is made of, one kind a file."""

from clearance.elements.clearance_prismatic import ClearancePrismatic
from clearance.elements.clearance_revolute import ClearanceRevolute
from clearance.elements.drive import Drive
from clearance.elements.forces import FollowerForce, Force, Torque
from clearance.elements.gear import Gear
from clearance.elements.pin_slot import ClearancePinSlot, PinSlot
from clearance.elements.prismatic import Prismatic
from clearance.elements.revolute import Revolute
from clearance.elements.springs import SpringDamper, TorsionSpring
from clearance.elements.thermal_node import ThermalNode
from clearance.elements.weld import Weld
from clearance.values.checks import absent

__all__ = [
    "ClearancePinSlot",
    "ClearancePrismatic",
    "ClearanceRevolute",
    "Drive",
    "FollowerForce",
    "Force",
    "Gear",
    "PinSlot",
    "Prismatic",
    "Revolute",
    "SpringDamper",
    "ThermalNode",
    "Torque",
    "TorsionSpring",
    "Weld",
]

__getattr__ = absent(__name__, __all__)
