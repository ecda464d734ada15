"""Oil film forces of a journal bearing, in the frame of the line of centres.

Conventions: the journal's centre is displaced from the bearing's by e = eps c along n, towards the
thinnest film. t is n turned by +90 degrees. A film law returns the force *on the journal* along n
(radial) and t (tangential). radial_rate = d(eps)/dt [1/s]; entrainment w = omega_J + omega_B - 2
gamma' [rad/s]. The entrainment has the **sum** of the absolute angular speeds and the absolute rate
gamma' of the line of centres.
"""

import math

from clearance.laws.law import film

# eccentricity ratio below which the journal counts as this far off centre
ECCENTRICITY_FLOOR = 1e-9
# smallest 1 - eps^2 the film is evaluated at: trial states at and beyond the wall stay finite
WALL = 1e-9
NEAREST = math.sqrt(1.0 - WALL)  # eccentricity ratio where 1 - eps^2 is WALL
# rate [1/s] below which all is an approach: forces of degree 1 in the rates have no slope at rest
REST = 1e-100
#: unit and description of an output of films with data
SIDE_FLOW = "m3/s", "oil that leaves the film at both ends"


@film
def pinkus_sternlicht(eccentricity_ratio, radial_rate, entrainment, joint):
    """Pinkus-Sternlicht force of a long bearing, half-Sommerfeld film, both branches in one form
    [N, N].

    S = sqrt(1 - eps^2) sqrt((w/2)^2 + (eps'/eps)^2)
    g = 1 + 1.5 eps' / (S + 1.5 |eps'|),   P0 = mu L R^3 / c^2
    F_r = -6 P0 / ((2 + eps^2)(1 - eps^2)^1.5) (4 S eps^2 + (2 + eps^2) pi eps' g)
    F_t = 6 pi eps w P0 / ((2 + eps^2) sqrt(1 - eps^2)) g

    Continuously differentiable in eps' for w != 0; tends to -6 pi eps' P0 for eps -> 0. Finite for
    every state: eps counts as at most 1, and 1 - eps^2 as at least 1e-9. Rigid, aligned,
    isoviscous. Valid for L/D > 2, far too large below.
    Source: Pinkus and Sternlicht, Theory of Hydrodynamic Lubrication (1961), in the form used by
    Flores et al. (2006). Here k^2 = (1 - eps^2)((w / 2 eps')^2 + 1/eps^2) is multiplied out, and
    the receding branch carries the plus sign.
    """
    eps = min(max(eccentricity_ratio, ECCENTRICITY_FLOOR), 1.0)
    scale = joint.viscosity * joint.length * joint.radius**3 / joint.clearance**2
    gap = max(1.0 - eps * eps, WALL)
    root = math.sqrt(gap)
    thick = 2.0 + eps * eps
    turning = root * math.sqrt(
        0.25 * entrainment * entrainment + (radial_rate / eps) ** 2 + REST * REST
    )
    share = 1.0 + 1.5 * radial_rate / (turning + 1.5 * abs(radial_rate))
    strength = 6.0 * scale / (thick * gap * root)
    radial = -strength * (4.0 * turning * eps * eps + thick * math.pi * radial_rate * share)
    tangential = strength * gap * math.pi * eps * entrainment * share
    return radial, tangential


# nodes in (0, 1) and weights of the Gauss-Legendre rule of 24 points on (-1, 1), symmetric about 0
_HALF, _WEIGHTS = (
    tuple(map(float, text.split()))
    for text in (
        """
    0.06405689286260563 0.1911188674736163 0.3150426796961634 0.4337935076260451
    0.5454214713888396 0.6480936519369755 0.7401241915785544 0.820001985973903
    0.8864155270044011 0.9382745520027328 0.9747285559713095 0.9951872199970213
""",
        """
    0.12793819534675202 0.12583745634682825 0.1216704729278033 0.11550566805372552
    0.10744427011596556 0.09761865210411393 0.0861901615319532 0.07334648141108016
    0.05929858491543636 0.04427743881741941 0.02853138862893356 0.01234122979998869
""",
    )
)
NODES, WEIGHTS = (*_HALF, *(-node for node in _HALF)), 2 * _WEIGHTS
POINTS = len(NODES)


@film
def full_sommerfeld(eccentricity_ratio, radial_rate, entrainment, joint):
    """Full film of a long bearing [N, N], sub-ambient pressure and all.

    F_r = -12 pi eps' P0 / (1 - eps^2)^1.5
    F_t = 12 pi eps w P0 / ((2 + eps^2) sqrt(1 - eps^2)),   P0 = mu L R^3 / c^2

    Valid for flooded, pressurised joints only: it allows tension.
    Source: Sommerfeld, Z. Math. Phys. 50 (1904) 97; squeeze part: Pinkus and Sternlicht (1961).
    """
    eps = min(eccentricity_ratio, 1.0)
    gap = max(1.0 - eps * eps, WALL)
    root = math.sqrt(gap)
    scale = 12.0 * math.pi * joint.viscosity * joint.length * joint.radius**3 / joint.clearance**2
    return -scale * radial_rate / (gap * root), scale * eps * entrainment / (
        (2.0 + eps * eps) * root
    )


def moving(radial_rate, wedge):
    """(factor, radial rate, eps |w|) that a pi-film is evaluated at: its own motion, at rest as
    slow an approach.
    """
    if abs(radial_rate) + wedge < REST:
        return radial_rate / REST, REST, 0.0
    return 1.0, radial_rate, wedge


def sommerfeld_angle(eps, theta):
    """psi with tan(psi / 2) = sqrt((1 - eps) / (1 + eps)) tan(theta / 2), on the branch of theta in
    (-pi, 2 pi].
    """
    return 2.0 * math.atan2(
        math.sqrt(max(1.0 - eps, 0.5 * WALL)) * math.sin(0.5 * theta),
        math.sqrt(1.0 + eps) * math.cos(0.5 * theta),
    )


def arc_integrals(eps, gap, start):
    """J_10, J_11, J_01, J_02, J_20 with J_ab = integral of sin^a cos^b / (1 + eps cos)^3 over
    [start, start + pi].

    gap = 1 - eps^2. In Sommerfeld's angle psi the last three are trigonometric polynomials of
    degree 2, which the Gauss points integrate to rounding; the usual closed forms cancel for small
    eps and near eps = 1.
    """
    sine, cosine = math.sin(start), math.cos(start)
    edge = gap + eps * eps * sine * sine
    first = sommerfeld_angle(eps, start)
    last = sommerfeld_angle(eps, start + math.pi)
    middle = 0.5 * (first + last)
    half = 0.5 * (last - first)
    j01 = j02 = j20 = 0.0
    for k in range(POINTS):
        psi = middle + half * NODES[k]
        c = math.cos(psi)
        s = math.sin(psi)
        weight = WEIGHTS[k]
        j01 += weight * (c - eps) * (1.0 - eps * c)
        j02 += weight * (c - eps) * (c - eps)
        j20 += weight * s * s
    thin = half / (gap * gap * math.sqrt(gap))
    return (
        2.0 * cosine / (edge * edge),
        -2.0 * eps * cosine**3 / (edge * edge),
        j01 * thin,
        j02 * thin,
        j20 * thin * gap,
    )


@film
def long_film(eccentricity_ratio, radial_rate, entrainment, joint):
    """Exact pi-film of a long bearing [N, N]: p = 0 at theta_1 and theta_1 + pi, positive between.

    tan theta_1 = (2 + eps^2) eps' / (eps w),   K = 3 w eps^2 / (2 + eps^2),   P0 = mu L R^3 / c^2
    F_r = -6 P0 (w eps J_11 + 2 eps' J_20 + K J_10),
    F_t = 6 P0 (w eps J_02 + 2 eps' J_11 + K J_01)

    with J_ab of `arc_integrals`. Rigid, aligned, isoviscous. Valid for L/D > 2. What Pinkus and
    Sternlicht's fractions stand for.
    Source: Pinkus and Sternlicht (1961), Reynolds equation of the long bearing, integrated over the
    arc of pressure.
    """
    eps = min(max(eccentricity_ratio, ECCENTRICITY_FLOOR), 1.0)
    gap = max(1.0 - eps * eps, WALL)
    scale = joint.viscosity * joint.length * joint.radius**3 / joint.clearance**2
    thick, wedge = 2.0 + eps * eps, eps * abs(entrainment)  # turned around, F_t changes its sign
    factor, rate, wedge = moving(radial_rate, wedge)
    start = math.atan2(thick * rate, wedge)
    j10, j11, j01, j02, j20 = arc_integrals(eps, gap, start)
    flow = 3.0 * wedge * eps / thick
    radial = -6.0 * scale * (wedge * j11 + 2.0 * rate * j20 + flow * j10)
    tangential = 6.0 * scale * (wedge * j02 + 2.0 * rate * j11 + flow * j01)
    return factor * radial, math.copysign(1.0, entrainment) * factor * tangential


@pinkus_sternlicht.doubts
@long_film.doubts
def _bearing_is_not_long(joint, parameters):
    """The long-bearing solution belongs to L/D > 2."""
    slenderness = joint.length / (2.0 * joint.radius)
    if slenderness < 2.0:
        return f"a long bearing's film; L/D = {slenderness:.3g} makes it too stiff"
    return None


@film(on_outlines=True)
def short_film(eccentricity_ratio, radial_rate, entrainment, joint):
    """Exact pi-film of a short bearing (Ocvirk, with squeeze) [N, N].

    theta_1 = atan2(2 eps', w eps),   P0 = mu L R^3 / c^2
    F_r = 2 P0 (L/D)^2 (w eps J_11 - 2 eps' J_02),   F_t = 2 P0 (L/D)^2 (w eps J_20 - 2 eps' J_11)

    with J_ab of `arc_integrals`. Rigid, aligned, isoviscous. Valid for L/D < 0.25, far too stiff
    above.
    Source: DuBois and Ocvirk, NACA TR 1157 (1953); with the squeeze term, Booker, J. Basic Eng. 87
    (1965) 537.
    """
    eps = min(max(eccentricity_ratio, ECCENTRICITY_FLOOR), 1.0)
    gap = max(1.0 - eps * eps, WALL)
    slender = joint.length / (2.0 * joint.radius)
    scale = (
        2.0
        * slender
        * slender
        * joint.viscosity
        * joint.length
        * joint.radius**3
        / joint.clearance**2
    )
    wedge = eps * abs(entrainment)  # turned around, F_t changes its sign
    factor, rate, wedge = moving(radial_rate, wedge)
    start = math.atan2(2.0 * rate, wedge)
    j10, j11, j01, j02, j20 = arc_integrals(eps, gap, start)
    factor *= scale
    tangential = wedge * j20 - 2.0 * rate * j11
    return factor * (wedge * j11 - 2.0 * rate * j02), math.copysign(
        1.0, entrainment
    ) * factor * tangential


@short_film.doubts
def _bearing_is_not_short(joint, parameters):
    """The short-bearing solution belongs to L/D < 0.25."""
    slenderness = joint.length / (2.0 * joint.radius)
    if slenderness > 0.5:
        return f"a short bearing's film; L/D = {slenderness:.3g} makes it too stiff"
    return None


def harmonic_share(x2):
    """Axial mean of a long and a short pressure in harmonic sum, over the long one;
    x2 = p_s / (p_s + p_l) in (0, 1).

    1 - r / sqrt(1 + r) artanh(1 / sqrt(1 + r)) with r = p_l / p_s, as a series where it would
    cancel.
    """
    if x2 < 0.1:
        total = 0.0
        for k in range(9, 0, -1):
            total = (total + 2.0 / (4.0 * k * k - 1.0)) * x2
        return total
    x = math.sqrt(min(x2, 1.0 - 1e-15))
    return 1.0 - (1.0 / x - x) * math.atanh(x)


@film
def harmonic(eccentricity_ratio, radial_rate, entrainment, joint):
    """Film of a bearing of finite length [N, N]: long and short pressure in harmonic sum at every
    angle.

    h = 1 + eps cos theta,   s = sin theta (2 + eps cos theta) / ((2 + eps^2) h^2)
    p_l = 6 [w eps (s(theta) - s(theta_l)) + eps' / eps (1 / h^2 - 1 / h_l^2)]
    p_s = 3 (L/D)^2 (w eps sin theta - 2 eps' cos theta) / h^3
    1 / p = 1 / p_l + 1 / (p_s (1 - z^2))
    F_r = P0 integral of p cos theta,   F_t = P0 integral of p sin theta

    over the intersection of the positive arcs, [max(theta_l, theta_s), min(theta_l, theta_s) + pi].
    The axial mean of p is a closed form (`harmonic_share`). The integrals take 24 Gauss points in
    the Sommerfeld angle (error below 1e-5 up to eps = 0.999). Rigid, aligned, isoviscous. Valid for
    L/D <= 1, mostly within 7 % of the Reynolds equation (22 % where the journal recedes at
    eps = 0.9), 3 to 25 % at L/D = 2.
    Source: Reason and Narang, ASLE Trans. 25 (1982) 437, extended to squeeze.
    """
    eps = min(max(eccentricity_ratio, ECCENTRICITY_FLOOR), NEAREST)
    gap = max(1.0 - eps * eps, WALL)
    root = math.sqrt(gap)
    slender = joint.length / (2.0 * joint.radius)
    scale = joint.viscosity * joint.length * joint.radius**3 / joint.clearance**2
    thick, wedge = 2.0 + eps * eps, eps * abs(entrainment)  # turned around, F_t changes its sign
    factor, rate, wedge = moving(radial_rate, wedge)
    at_long = math.atan2(thick * rate, wedge)
    at_short = math.atan2(2.0 * rate, wedge)
    start = sommerfeld_angle(eps, max(at_long, at_short))
    end = sommerfeld_angle(eps, min(at_long, at_short) + math.pi)
    h_l = 1.0 + eps * math.cos(at_long)
    s_l = math.sin(at_long) * (1.0 + h_l) / (thick * h_l * h_l)
    middle = 0.5 * (start + end)
    half = 0.5 * (end - start)
    radial = tangential = 0.0
    for k in range(POINTS):
        psi = middle + half * NODES[k]
        stretch = 1.0 - eps * math.cos(psi)
        c = (math.cos(psi) - eps) / stretch
        s = root * math.sin(psi) / stretch
        h = gap / stretch
        square = 1.0 / (h * h)
        squeeze = rate * (math.cos(at_long) - c) * (h_l + h) * square / (h_l * h_l)
        p_long = 6.0 * (wedge * (s * (1.0 + h) * square / thick - s_l) + squeeze)
        p_short = 3.0 * slender * slender * (wedge * s - 2.0 * rate * c) * square / h
        p_long = max(p_long, 1e-300)
        p_short = max(p_short, 1e-300)
        pressure = p_long * harmonic_share(p_short / (p_short + p_long))
        weight = WEIGHTS[k] * half * root / stretch * pressure
        radial += weight * c
        tangential += weight * s
    factor *= scale
    return factor * radial, math.copysign(1.0, entrainment) * factor * tangential


def film_torques(
    eccentricity_ratio,
    tangential,
    journal_speed,
    bearing_speed,
    radius,
    clearance,
    length,
    viscosity,
):
    """Friction torques of the film on journal and bearing [N m, N m], about their own centres.

    T_J = -(T_c + e F_t / 2),  T_B = T_c - e F_t / 2,
    T_c = 2 pi mu R^3 L (omega_J - omega_B) / (c sqrt(1 - eps^2))

    so that T_J + T_B + e F_t = 0 balances the moment of the two centre forces. The law takes the
    **difference** of the absolute speeds [rad/s]; lengths in m, viscosity in Pa s. T_c assumes an
    oil-filled cavitated arc (upper bound); Petroff's torque for eps -> 0.
    Source: Pinkus and Sternlicht (1961); the same form stands in MBDyn's hydrodynamic plain bearing
    module.
    """
    gap = max(1.0 - eccentricity_ratio * eccentricity_ratio, WALL)
    shear = 2.0 * math.pi / math.sqrt(gap)
    return wet_film_torques(
        eccentricity_ratio,
        tangential,
        shear,
        journal_speed,
        bearing_speed,
        radius,
        clearance,
        length,
        viscosity,
    )


def wet_film_torques(
    eccentricity_ratio,
    tangential,
    shear,
    journal_speed,
    bearing_speed,
    radius,
    clearance,
    length,
    viscosity,
):
    """As `film_torques`, where only the wet area drags: T_c = mu R^3 L / c (omega_J - omega_B) K.

    shear K: the integral of 1/H over the wet area, at most 2 pi / sqrt(1 - eps^2).
    """
    couette = viscosity * radius**3 * length / clearance * shear * (journal_speed - bearing_speed)
    moment = 0.5 * eccentricity_ratio * clearance * tangential
    return -(couette + moment), couette - moment


def peak_film_pressure(load, thickness, radius, clearance, length):
    """Estimate of the largest pressure [Pa] of a film that carries `load` [N] at minimum thickness
    h [m].

    p = F / (L R min(pi / 2 sqrt(2 h / e), 2)): the squeeze pressure of a parabolic gap,
    p ~ (1 + u^2)^-2, at most spread over the diameter; e = c - h. Within a factor of two, for
    diagnostics.
    """
    thin = max(thickness, 1e-9 * clearance)
    eccentricity = max(clearance - thin, 1e-3 * clearance)
    width = radius * min(0.5 * math.pi * math.sqrt(2.0 * thin / eccentricity), 2.0)
    return load / (length * width)


def flattened(rigid, hertz):
    """Largest pressure [Pa] between that of a rigid film and Hertz's, of the same load: within 4 %
    of the solved line contacts.
    """
    return rigid / math.sqrt(1.0 + (rigid / hertz) ** 2)


def thinning(warming, surroundings, vogel, vogel_zero):
    """mu(T) / mu(T_0) of Vogel's law, for T = T_0 + warming [K]:
    exp(B / (T - theta) - B / (T_0 - theta)).

    Temperatures below theta + B / 500 count as that. Source: Vogel, Physikalische Zeitschrift 22
    (1921) 645.
    """
    above = max(surroundings + warming - vogel_zero, 0.002 * vogel)
    return math.exp(vogel / above - vogel / (surroundings - vogel_zero))
