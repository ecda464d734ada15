"""The physics of one joint, as plain functions: one file a family."""

from clearance.laws.contact import hertz_stiffness, hunt_crossley_memoryless, lankarani_nikravesh
from clearance.laws.film import film_torques, pinkus_sternlicht
from clearance.laws.friction import coulomb
from clearance.laws.law import BoundLaw, FilmJoint, Law, contact, effort, film, friction, signal

__all__ = [
    "BoundLaw", "FilmJoint", "Law", "contact", "coulomb", "effort", "film", "film_torques", "friction",
    "hertz_stiffness", "hunt_crossley_memoryless", "lankarani_nikravesh", "pinkus_sternlicht", "signal",
]  # fmt: skip
