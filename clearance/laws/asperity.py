"""Rough surfaces: the load their asperities carry, and what roughness does to a film's flow.

Heights are Gaussian; film_thickness_ratio lambda = h_0 / sigma with the nominal minimum film
thickness h_0 and the composite rms roughness sigma = sqrt(R_q1^2 + R_q2^2) (`composite_roughness`).
Pressures over the parabolic gap of a conformal joint are integrated in closed form with

    integral of F_n(lambda + u^2) du = B(1/2, n + 1) F_(n + 1/2)(lambda),
    F_n(x) = integral_x^inf (s - x)^n phi(s) ds.

Valid for roughness much smaller than the clearance.
"""

import math

from clearance.laws.contact import MODULUS
from clearance.laws.law import OfJoint, asperity
from clearance.values.checks import finite, positive
from clearance.values.units import amount

FAR = 12.0  # film thickness ratio at which asperities have long lost touch
SQRT2 = math.sqrt(2.0)
SQRT2PI = math.sqrt(2.0 * math.pi)


def composite_roughness(first: float | str, second: float | str) -> float:
    """rms roughness of two surfaces together: sigma = sqrt(R_q1^2 + R_q2^2) [m].

    Texts may be R_a, as "Ra 0.4 um", which counts sqrt(pi / 2) times (Gaussian heights).
    """
    return math.hypot(amount(first, ("m",)), amount(second, ("m",)))


def normal_density(x):
    """phi(x), the standard normal density."""
    return math.exp(-0.5 * x * x) / SQRT2PI


def normal_tail(x):
    """1 - Phi(x), the chance that a standard normal height exceeds x."""
    return 0.5 * math.erfc(x / SQRT2)


def second_moment(x):
    """F_2(x) = (x^2 + 1) (1 - Phi(x)) - x phi(x); 0 beyond x = 12, where it is below 1e-33."""
    if x > FAR:
        return 0.0
    return max((x * x + 1.0) * normal_tail(x) - x * normal_density(x), 0.0)


def third_moment(x):
    """F_3(x) = (x^2 + 2) phi(x) - (x^3 + 3 x) (1 - Phi(x)); 0 beyond x = 12, where it is below
    1e-34.
    """
    if x > FAR:
        return 0.0
    return max((x * x + 2.0) * normal_density(x) - (x * x * x + 3.0 * x) * normal_tail(x), 0.0)


def rough_on_rough(modulus, roughness_group, slope_ratio, summit_height=0.0):
    """K' E* of `greenwood_tripp` [Pa]: p = K' E* F_5/2(H / sigma) at a gap H."""
    group = 16.0 * SQRT2 * math.pi / 15.0 * roughness_group * roughness_group
    return group * math.sqrt(slope_ratio) * modulus


def rough_on_smooth(modulus, roughness_group, slope_ratio, summit_height=0.0):
    """Factor of `greenwood_williamson` [Pa]: p = 4/3 E* eta beta sigma sqrt(sigma / beta) F_3/2."""
    return 4.0 / 3.0 * roughness_group * math.sqrt(slope_ratio) * modulus


def of_summits(factor):
    """The modulus of summits: `contact_modulus` of the joint's material. On a film's liner, a bare
    compliance kappa [m/Pa], summits are at most as stiff as what they press, kappa K <= sigma.

    factor: K of a law [Pa], from its parameters.
    """

    def modulus(joint, parameters):
        solid = MODULUS.function(joint, parameters)
        film = getattr(joint, "film", None)
        if film is None or not (liner := film.values.get("liner")) or not joint.roughness:
            return solid
        return min(solid, joint.roughness / (liner * factor(**parameters | {"modulus": 1.0})))

    return OfJoint(positive, modulus)


def touching_arc(film_thickness_ratio, joint):
    """Length scale of the arc on which summits touch [m]: R sqrt(2 sigma / e)."""
    eccentricity = max(
        joint.clearance - film_thickness_ratio * joint.roughness, 0.1 * joint.clearance
    )
    return joint.radius * math.sqrt(2.0 * joint.roughness / eccentricity)


@asperity(
    modulus=of_summits(rough_on_rough),
    roughness_group=positive,
    slope_ratio=positive,
    summit_height=finite,
    pressure=(2.5, rough_on_rough),
)
def greenwood_tripp(
    film_thickness_ratio,
    joint,
    modulus,
    roughness_group=0.04,
    slope_ratio=1e-3,
    summit_height=0.0,
):
    """Load of the asperities of two rough surfaces in a conformal joint [N].

    F = 5 pi / 16 K' E* R L sqrt(2 sigma / e) F_3(lambda)
    K' = 16 sqrt(2) pi / 15 (eta beta sigma)^2 sqrt(sigma / beta)

    modulus E* [Pa] (`of_summits`, not 2 E*), roughness_group eta beta sigma (0.03 to 0.05),
    slope_ratio sigma / beta (1e-4 to 1e-2). e = c - lambda sigma is the eccentricity.
    summit_height: sum of both heights of the mean summit above the mean surface [m], taken off the
    film. From the pressure K' E* F_5/2. Valid for elastic summits. Source: Greenwood and Tripp,
    Proc. IMechE 185 (1970) 625; integrated over the arc.
    """
    strength = rough_on_rough(modulus, roughness_group, slope_ratio)
    area = joint.length * touching_arc(film_thickness_ratio, joint)
    ratio = film_thickness_ratio - summit_height / joint.roughness
    return 0.3125 * math.pi * strength * area * third_moment(ratio)


@asperity(
    modulus=of_summits(rough_on_smooth),
    roughness_group=positive,
    slope_ratio=positive,
    summit_height=finite,
    pressure=(1.5, rough_on_smooth),
)
def greenwood_williamson(
    film_thickness_ratio,
    joint,
    modulus,
    roughness_group=0.04,
    slope_ratio=1e-3,
    summit_height=0.0,
):
    """Load of the asperities of a rough surface on a smooth one in a conformal joint [N].

    F = pi / 2 E* (eta beta sigma) sqrt(sigma / beta) R L sqrt(2 sigma / e) F_2(lambda)

    modulus E*, roughness_group, slope_ratio and summit_height as in `greenwood_tripp`, and valid as
    that. From the pressure 4/3 eta E* sqrt(beta) sigma^1.5 F_3/2 over
    the arc. Source: Greenwood and Williamson, Proc. R. Soc. A 295 (1966) 300; integrated over the
    arc.
    """
    strength = 0.375 * math.pi * rough_on_smooth(modulus, roughness_group, slope_ratio)
    ratio = film_thickness_ratio - summit_height / joint.roughness
    return (
        strength * joint.length * touching_arc(film_thickness_ratio, joint) * second_moment(ratio)
    )


# --- flow factors, for film models that solve a Reynolds equation
PATTERNS = (1 / 9, 1 / 6, 1 / 3, 1.0, 3.0, 6.0, 9.0)  # of surfaces, gamma


def _by_pattern(text: str) -> dict[float, tuple[float, ...]]:
    """A table, one row a pattern."""
    rows = (tuple(map(float, row.split())) for row in text.strip().splitlines())
    return dict(zip(PATTERNS, rows, strict=True))


#: C, r, smallest valid ratio
PRESSURE_FACTORS = _by_pattern("""
1.48 0.42 1
1.38 0.42 1
1.18 0.42 0.75
0.90 0.56 0.5
0.225 1.5 0.5
0.520 1.5 0.5
0.870 1.5 0.5
""")
#: A1, alpha1, alpha2, alpha3, A2
SHEAR_FACTORS = _by_pattern("""
2.046 1.12 0.78 0.03 1.856
1.962 1.08 0.77 0.03 1.754
1.858 1.01 0.76 0.03 1.561
1.899 0.98 0.92 0.05 1.126
1.560 0.85 1.13 0.08 0.556
1.290 0.62 1.09 0.08 0.388
1.011 0.54 1.07 0.08 0.295
""")


def _pattern(table: dict, pattern: float) -> tuple:
    for tabled, row in table.items():
        if math.isclose(tabled, pattern, rel_tol=1e-6):
            return row
    names = "1/9, 1/6, 1/3, 1, 3, 6, 9"
    raise ValueError(f"surface pattern must be one of {names} (1: isotropic), got {pattern!r}")


def pressure_flow_factor(ratio: float, pattern: float = 1.0) -> float:
    """Patir and Cheng's phi_p at film thickness ratio H = h / sigma: 1 - C exp(-r H), for patterns
    above 1: 1 + C H^-r.

    Valid for H above 0.5 to 1; below, its value there. Raises ValueError for patterns without
    coefficients. Source: Patir and Cheng, J. Lubrication Technology 100 (1978) 12.
    """
    strength, rate, lowest = _pattern(PRESSURE_FACTORS, pattern)
    ratio = max(ratio, lowest)
    return (
        1.0 - strength * math.exp(-rate * ratio)
        if pattern <= 1.0
        else 1.0 + strength * ratio**-rate
    )


def shear_flow_factor(ratio: float, pattern: float = 1.0) -> float:
    """Patir and Cheng's phi_s of one surface: A1 H^a1 exp(-a2 H + a3 H^2) up to H = 5, A2
    exp(-H / 4) beyond.

    Two surfaces: Phi_s = (sigma_1 / sigma)^2 phi_s1 - (sigma_2 / sigma)^2 phi_s2; equal surfaces
    give 0. Source: Patir and Cheng, J. Lubrication Technology 101 (1979) 220.
    """
    a1, power, first, second, a2 = _pattern(SHEAR_FACTORS, pattern)
    if ratio > 5.0:
        return a2 * math.exp(-0.25 * ratio)
    ratio = max(ratio, 0.0)
    return a1 * ratio**power * math.exp(-first * ratio + second * ratio * ratio)


def contact_flow_factor(ratio: float) -> float:
    """Wu and Zheng's phi_c = dh_T / dh = Phi(H): the share of the surface that is not in contact.

    Source: Wu and Zheng, J. Tribology 111 (1989) 188; their polynomial is a fit of Phi.
    """
    return 1.0 - normal_tail(ratio)
