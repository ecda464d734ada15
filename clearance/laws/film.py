"""Oil film forces of a journal bearing, in the frame of the line of centres.

Conventions: the journal's centre is displaced from the bearing's by e = eps c along n (towards the thinnest film), t is
n turned by +90 degrees. A film law returns the force *on the journal* along n (radial) and t (tangential).
radial_rate = d(eps)/dt [1/s]; entrainment w = omega_J + omega_B - 2 gamma' [rad/s], with the **sum** of the absolute
angular speeds and the absolute rate gamma' of the line of centres.
"""

import math

from clearance.laws.law import film

ECCENTRICITY_FLOOR = 1e-9  # eccentricity ratio below which the journal counts as this far off centre
WALL = 1e-9  # smallest 1 - eps^2 the film is evaluated at: trial states at and beyond the wall stay finite
REST = 1e-9  # rate [1/s] that keeps the square root smooth at rest


@film
def pinkus_sternlicht(eccentricity_ratio, radial_rate, entrainment, joint):
    """Pinkus-Sternlicht force of a long bearing, half-Sommerfeld film, both branches in one form [N, N].

    S   = sqrt(1 - eps^2) sqrt((w/2)^2 + (eps'/eps)^2),   g = 1 + 1.5 eps' / (S + 1.5 |eps'|),   P0 = mu L R^3 / c^2
    F_r = -6 P0 / ((2 + eps^2)(1 - eps^2)^1.5) (4 S eps^2 + (2 + eps^2) pi eps' g)
    F_t =  6 pi eps w P0 / ((2 + eps^2) sqrt(1 - eps^2)) g

    Continuously differentiable in eps' for w != 0, tends to -6 pi eps' P0 for eps -> 0, finite for every state
    (eps counts as at most 1, and 1 - eps^2 is kept above 1e-9). Rigid, aligned, isoviscous;
    meant for L/D > 2, far too large below.
    Source: Pinkus and Sternlicht, Theory of Hydrodynamic Lubrication (1961), in the form used by Flores et al. (2006),
    with k^2 = (1 - eps^2)((w / 2 eps')^2 + 1/eps^2) multiplied out; the receding branch carries the plus sign.
    """
    eps = min(max(eccentricity_ratio, ECCENTRICITY_FLOOR), 1.0)
    scale = joint.viscosity * joint.length * joint.radius**3 / joint.clearance**2
    gap = max(1.0 - eps * eps, WALL)
    root = math.sqrt(gap)
    thick = 2.0 + eps * eps
    turning = root * math.sqrt(0.25 * entrainment * entrainment + (radial_rate / eps) ** 2 + REST * REST)
    share = 1.0 + 1.5 * radial_rate / (turning + 1.5 * abs(radial_rate))
    strength = 6.0 * scale / (thick * gap * root)
    radial = -strength * (4.0 * turning * eps * eps + thick * math.pi * radial_rate * share)
    tangential = strength * gap * math.pi * eps * entrainment * share
    return radial, tangential


@pinkus_sternlicht.doubts
def _bearing_is_not_long(joint, parameters):
    """The long-bearing solution belongs to L/D > 2."""
    slenderness = joint.length / (2.0 * joint.radius)
    if slenderness < 2.0:
        return f"pinkus_sternlicht is a long bearing's film; L/D = {slenderness:.3g} makes it too stiff"
    return None


def film_torques(eccentricity_ratio, tangential, journal_speed, bearing_speed, radius, clearance, length, viscosity):
    """Friction torques of the film on journal and bearing [N m, N m], about their own centres.

    T_J = -(T_c + e F_t / 2),  T_B = T_c - e F_t / 2,  T_c = 2 pi mu R^3 L (omega_J - omega_B) / (c sqrt(1 - eps^2))

    so that T_J + T_B + e F_t = 0 balances the moment of the two centre forces. Speeds absolute [rad/s]; lengths in m,
    viscosity in Pa s. T_c assumes an oil-filled cavitated arc (upper bound); Petroff's torque for eps -> 0.
    Source: Pinkus and Sternlicht (1961); the same form stands in MBDyn's hydrodynamic plain bearing module.
    """
    gap = max(1.0 - eccentricity_ratio * eccentricity_ratio, WALL)
    shear = 2.0 * math.pi * viscosity * radius**3 * length / (clearance * math.sqrt(gap))
    couette = shear * (journal_speed - bearing_speed)
    moment = 0.5 * eccentricity_ratio * clearance * tangential
    return -(couette + moment), couette - moment
