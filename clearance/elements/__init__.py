"""Elements: what a mechanism is made of, one kind a file."""

from clearance.elements.clearance_prismatic import ClearancePrismatic
from clearance.elements.clearance_revolute import ClearanceRevolute
from clearance.elements.drive import Drive
from clearance.elements.forces import Force, Torque
from clearance.elements.prismatic import Prismatic
from clearance.elements.revolute import Revolute
from clearance.elements.springs import SpringDamper, TorsionSpring

__all__ = [
    "ClearancePrismatic",
    "ClearanceRevolute",
    "Drive",
    "Force",
    "Prismatic",
    "Revolute",
    "SpringDamper",
    "Torque",
    "TorsionSpring",
]
