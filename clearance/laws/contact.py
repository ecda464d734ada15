"""Dry contact of journal and bearing: normal force as a function of penetration and its rate."""

import math

from clearance.checks import fraction, non_negative, positive
from clearance.laws.law import contact


def hertz_stiffness(
    journal_radius: float,
    bearing_radius: float,
    young_journal: float,
    poisson_journal: float,
    young_bearing: float,
    poisson_bearing: float,
) -> float:
    """Generalised Hertz stiffness K of a pin in a hole, F = K delta^1.5.

    K = 4 / (3 (s_J + s_B)) * sqrt(R_J R_B / (R_B - R_J)),   s = (1 - nu^2) / E

    Radii in m, moduli in Pa, result in N/m^1.5. The **minus** sign belongs to the internal (conformal) contact; the
    sphere formula behind it knows no bearing length and is soft for tight clearances.
    Source: Lankarani and Nikravesh, J. Mech. Design 112 (1990) 369, as used by Flores et al. (2004 to 2009).
    Raises ValueError unless 0 < journal_radius < bearing_radius and both moduli are positive.
    """
    positive("journal_radius", journal_radius)
    positive("bearing radius minus journal radius", bearing_radius - journal_radius)
    compliance = (1.0 - poisson_journal**2) / positive("young_journal", young_journal) + (
        1.0 - poisson_bearing**2
    ) / positive("young_bearing", young_bearing)
    return 4.0 / (3.0 * compliance) * math.sqrt(journal_radius * bearing_radius / (bearing_radius - journal_radius))


def delivered_restitution(damping: float) -> float:
    """Restitution e that F = K delta^n (1 + chi delta' / delta'_0) really gives a free impact, for any n and K.

    Solves chi (1 + e) = ln((1 + chi) / (1 - chi e)) for the damping factor chi >= 0 by bisection (1e-12).
    """
    low, high = 0.0, min(1.0, 1.0 / damping) if damping > 0.0 else 1.0
    if damping < 1e-9:
        return 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        excess = damping * (1.0 + middle) - math.log((1.0 + damping) / (1.0 - damping * middle))
        low, high = (middle, high) if excess > 0.0 else (low, middle)
    return 0.5 * (low + high)


def elastic_force(penetration, stiffness, exponent):
    """K delta^n; the square root of the usual n = 1.5 costs a third of a general power."""
    if exponent == 1.5:
        return stiffness * penetration * math.sqrt(penetration)
    return stiffness * penetration**exponent


@contact(stiffness=positive, restitution=fraction, exponent=positive, grazing_speed=positive)
def lankarani_nikravesh(
    penetration, penetration_rate, impact_speed, stiffness, restitution, exponent=1.5, grazing_speed=1e-3
):
    """Normal contact force of Lankarani and Nikravesh [N], never pulling.

    F = K delta^n (1 + 3 (1 - e^2) / 4 * delta' / delta'_0),  F = 0 for delta <= 0 and where the bracket is negative

    penetration delta [m], penetration_rate delta' [m/s], impact_speed delta'_0 [m/s] (the rate at first touch, frozen
    while the contact lasts); stiffness K [N/m^n], restitution e (0 to 1), exponent n. Impact speeds below
    grazing_speed [m/s] count as grazing_speed, so that the damping stays finite.
    Valid for e close to 1: the delivered restitution is .913 for .9, but .725 for .5.
    Source: Lankarani and Nikravesh, J. Mech. Design 112 (1990) 369.
    """
    if penetration <= 0.0:
        return 0.0
    damping = 0.75 * (1.0 - restitution * restitution) / max(impact_speed, grazing_speed)
    return elastic_force(penetration, stiffness, exponent) * max(1.0 + damping * penetration_rate, 0.0)


@lankarani_nikravesh.doubts
def _restitution_is_not_delivered(joint, parameters):
    """The damping factor was derived for nearly elastic impacts."""
    wanted = parameters["restitution"]
    given = delivered_restitution(0.75 * (1.0 - wanted * wanted))
    if given - wanted > 0.05:
        return f"lankarani_nikravesh delivers a restitution of {given:.2f} where {wanted:.2f} is asked for"
    return None


@contact(stiffness=positive, dissipation=non_negative, exponent=positive)
def hunt_crossley_memoryless(penetration, penetration_rate, impact_speed, stiffness, dissipation, exponent=1.5):
    """Normal contact force of Hunt and Crossley [N], never pulling; it does not look at the impact speed.

    F = K delta^n (1 + 1.5 alpha delta'),  F = 0 for delta <= 0 and where the bracket is negative

    penetration delta [m], penetration_rate delta' [m/s]; stiffness K [N/m^n], dissipation alpha [s/m], exponent n.
    For slow impacts the restitution is 1 - alpha v: it falls with the impact speed v. Valid for alpha v well below 1.
    Source: Hunt and Crossley, J. Applied Mechanics 42 (1975) 440, eqs. 10 to 14.
    """
    if penetration <= 0.0:
        return 0.0
    return elastic_force(penetration, stiffness, exponent) * max(1.0 + 1.5 * dissipation * penetration_rate, 0.0)
