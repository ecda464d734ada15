"""Elements: what a mechanism is made of, one kind a file."""

from clearance.elements.clearance_revolute import ClearanceRevolute
from clearance.elements.drive import Drive
from clearance.elements.forces import Force, Torque
from clearance.elements.prismatic import Prismatic
from clearance.elements.revolute import Revolute
from clearance.elements.springs import SpringDamper, TorsionSpring
from clearance.elements.thermal_node import ThermalNode

__all__ = [
    "ClearanceRevolute",
    "Drive",
    "Force",
    "Prismatic",
    "Revolute",
    "SpringDamper",
    "ThermalNode",
    "Torque",
    "TorsionSpring",
]
