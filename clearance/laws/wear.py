"""Sliding wear of one surface: how fast its worn depth grows where it is pressed and rubbed.

    h' = w(p, v) [m/s],   volume V' = R L int w(p, |v|) dtheta [m3/s]

pressure p >= 0 of the solids [Pa] (the film's pressure wears nothing), sliding_speed v >= 0 [m/s].
Coefficients k [m2/N] are volumes over load and sliding distance: 1 mm3/(N m) = 1e-9 m2/N. k = K / H
with a dimensionless coefficient K and a hardness H [Pa]. Steel on steel, oiled: 1e-18 to 1e-16
m2/N; dry metals 1e-15 to 1e-13; PTFE on steel 1e-13 to 1e-12. For a law that is linear in the
pressure the worn volume follows from the normal load alone, V' = w(N, |v|), and is integrated with
the motion. For another law it is summed over the arc at each step.
"""

import math

from clearance.laws.law import surface_wear
from clearance.values.checks import non_negative

LARGEST = 1e-9  # m2/N; softer than any bearing: a number in other units
LEAST = 1e-22
HARDNESS = 1e-2  # of Young's modulus, about
SEVERE = 1e-2  # coefficient times hardness of the severest dry wear of metals, about
MILD = 1e-11  # the same of the mildest wear in oil, about


def coefficient_of_wear(field: str, value: object) -> float:
    """A wear coefficient [m2/N], 0 or from 1e-22 to 1e-9.

    Raises ValueError for another, which has another unit.
    """
    number = non_negative(field, value)
    if number > LARGEST or 0.0 < number < LEAST:
        raise ValueError(
            f"{field} must be 0 or lie in [{LEAST:g}, {LARGEST:g}] m2/N, got {number:g} m2/N = "
            f"{number * 1e9:g} mm3/(N m); with a unit: 5.05e-4mm3/Nm"
        )
    return number


@surface_wear(coefficient=coefficient_of_wear)
def archard(pressure, sliding_speed, coefficient):
    """h' = k p v [m/s]: worn volume in proportion to load and way.

    coefficient k [m2/N]. Valid as long as neither heat nor pressure changes the mechanism of wear.
    Raises ValueError for k outside [1e-22, 1e-9] m2/N.
    Source: Archard, J. Applied Physics 24 (1953) 981; local form: Podra and Andersson, Wear 207
    (1997) 79.
    """
    return coefficient * pressure * sliding_speed


@surface_wear(energy_coefficient=coefficient_of_wear, friction=non_negative)
def archard_reye(pressure, sliding_speed, energy_coefficient, friction):
    """h' = k_e mu p v [m/s]: worn volume in proportion to the work of friction.

    energy_coefficient k_e [m3/J]; friction mu, the coefficient that the surfaces rub with [-].
    `archard` with k = k_e mu, and valid as that. Raises ValueError for k_e outside [1e-22, 1e-9]
    m3/J and mu < 0.
    Source: Reye, Der Civilingenieur 4 (1860) 235; Fouvry, Kapsa and Vincent, Wear 200 (1996) 186.
    """
    return energy_coefficient * friction * pressure * sliding_speed


@surface_wear(coefficient=coefficient_of_wear, friction=non_negative)
def sarkar(pressure, sliding_speed, coefficient, friction):
    """h' = k p v sqrt(1 + 3 mu^2) [m/s]: the shear of friction makes the real contact yield
    earlier.

    coefficient k [m2/N] without friction; friction mu [-]. `archard` for mu = 0, and valid as that.
    Raises ValueError for k outside [1e-22, 1e-9] m2/N and mu < 0.
    Source: Sarkar (1980), Friction and Wear, Academic Press.
    """
    return coefficient * math.sqrt(1.0 + 3.0 * friction * friction) * pressure * sliding_speed


def _unusual(coefficient: float, joint) -> str | None:
    """Objection to a coefficient whose product with the material's hardness no pair has."""
    product = coefficient * HARDNESS * joint.material.young
    if product == 0.0 or MILD <= product <= SEVERE:
        return None
    material = f"the hardness of {joint.material.name} (Young's modulus / {1.0 / HARDNESS:g})"
    severe = f"the severest dry wear has {SEVERE:g}"
    limit = severe if product > SEVERE else f"the mildest wear in oil has {MILD:g}"
    return (
        f"coefficient {coefficient:g} m2/N = {coefficient * 1e9:g} mm3/(N m) times {material} is "
        f"{product:.2g}; {limit}: look at its unit, or give the joint its material"
    )


@archard.doubts
@sarkar.doubts
def _severe(joint, parameters):
    """The coefficient against the material."""
    return _unusual(parameters["coefficient"], joint)


@archard_reye.doubts
def _reye_severe(joint, parameters):
    """Reye's coefficient times friction against the material."""
    return _unusual(parameters["energy_coefficient"] * parameters["friction"], joint)


def is_linear(law) -> bool:
    """True where a bound law of wear is linear in the pressure."""
    pairs = ((1e3, 1e-3), (1e6, 0.1), (1e9, 10.0))
    return all(abs(law(2.0 * p, v) - 2.0 * law(p, v)) <= 1e-12 * abs(law(p, v)) for p, v in pairs)
