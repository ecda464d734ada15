"""Dry contact of journal and bearing: normal force as a function of penetration and its rate."""

import math

from clearance.checks import fraction, positive
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
    return stiffness * penetration**exponent * max(1.0 + damping * penetration_rate, 0.0)
