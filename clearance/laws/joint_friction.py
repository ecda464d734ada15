"""Friction of hinges and slides without clearance: a torque or force against their motion, made by
their reactions.

The geometry of the joint turns a reaction into one number, the friction load Q. For a hinge Q is a
torque [N m] and the rate an angular velocity [rad/s]. For a slide Q is a force [N] and the rate a
speed [m/s]. A law returns the torque on body b (the force on b along the axis), opposed to the rate
of b against a. With transition_rate = 0 the sign function stands at rest (and 0 below 1e-14, which
is rounding): right for prescribed motion. In forward dynamics give a transition_rate, or a law that
is smooth at rest. `joint_lugre` sticks: the deflection of its bristles is a state of the joint.
"""

import math
from collections.abc import Callable

from clearance.laws.law import joint_bristle, joint_friction
from clearance.values.checks import at_least_one, non_negative, positive

REST = 1e-14  # rad/s, m/s: slower is rounding, which has no sign
ROOT_2, ROOT_2E = math.sqrt(2.0), math.sqrt(2.0 * math.e)


def pin_load(
    radial_x, radial_y, axial, bending_x, bending_y, pin_radius, friction_arm, bending_ratio
):
    """Friction load of a hinge [N m]: Q = R_p f_r + R_n |f_m| + (R_p / R_b) t_r.

    f_r = |(radial_x, radial_y)| radial force, f_m axial force [N], t_r = |(bending_x, bending_y)|
    bending moment [N m]; pin_radius R_p, friction_arm R_n of the thrust face [m]; bending_ratio
    R_p / R_b, R_b the bending reaction arm. Source: Guo, Ju and Wang, Aerospace 11 (2024) 368, Eq.
    47, in the form of the ADAMS joint friction.
    """
    radial = length(radial_x, radial_y)
    return (
        pin_radius * radial
        + friction_arm * abs(axial)
        + bending_ratio * length(bending_x, bending_y)
    )


def slide_load(normal, axial, twist, tilt, bending, friction_arm_inverse, overlap_inverse):
    """Friction load of a slide [N]: Q = f_p + t_p / (s / 2) + |t_m| / R_n.

    f_p = |(normal, axial)| force across the slide, in the plane and out of it [N]; t_p = |(tilt,
    bending)| moment about the axes across the slide, t_m = twist about the slide itself [N m].
    Parameters: overlap s of slide and guide [m] as overlap_inverse 1 / s, friction_arm R_n as
    friction_arm_inverse 1 / R_n [1/m].
    Source: Guo, Ju and Wang, Aerospace 11 (2024) 368, Eq. 47, in the form of the ADAMS joint
    friction.
    """
    return (
        length(normal, axial)
        + 2.0 * overlap_inverse * length(tilt, bending)
        + friction_arm_inverse * abs(twist)
    )


def length(x, y):
    """Length of a vector; its derivative at zero is zero."""
    square = x * x + y * y
    if square > 0.0:
        return math.sqrt(square)
    return 0.0


def direction(rate, transition_rate):
    """Sign of the rate, smoothed as tanh(rate / transition_rate) where a transition rate is
    given.
    """
    if transition_rate > 0.0:
        return math.tanh(rate / transition_rate)
    if rate > REST:
        return 1.0
    if rate < -REST:
        return -1.0
    return 0.0


def _elastic_reach(parameters: dict) -> float:
    """Deflection at which bristles break away."""
    return parameters["static"] / parameters["stiffness"]


def _has_slope(parameters: dict) -> bool:
    return parameters["transition_rate"] > 0.0


@joint_friction(
    coefficient=non_negative,
    viscous=non_negative,
    load_viscous=non_negative,
    transition_rate=non_negative,
    smooth=_has_slope,
    layer=lambda p: (p["transition_rate"], p["transition_rate"]),
)
def joint_coulomb(rate, load, coefficient, viscous=0.0, load_viscous=0.0, transition_rate=0.0):
    """Coulomb-viscous friction of a joint [N m or N]: -(mu Q sgn(w) + c w + c_Q Q w).

    coefficient mu [-]; viscous c [N m s or N s/m]; load_viscous c_Q per unit of load [s or s/m];
    transition_rate: of the smoothed sign [rad/s or m/s]. Valid for sliding above it.
    Source: Guo, Ju and Wang, Aerospace 11 (2024) 368, Eq. 42. The source leaves open if its viscous
    coefficient is c or c_Q.
    """
    return -(
        coefficient * load * direction(rate, transition_rate)
        + (viscous + load_viscous * load) * rate
    )


@joint_friction(
    static=non_negative,
    kinetic=non_negative,
    stribeck_rate=positive,
    exponent=at_least_one,
    viscous=non_negative,
    load_viscous=non_negative,
    transition_rate=non_negative,
    smooth=_has_slope,
    layer=lambda p: (p["transition_rate"], p["stribeck_rate"]),
)
def joint_stribeck(
    rate,
    load,
    static,
    kinetic,
    stribeck_rate,
    exponent=2.0,
    viscous=0.0,
    load_viscous=0.0,
    transition_rate=0.0,
):
    """Stribeck friction of a joint [N m or N]: -((mu_k + (mu_s - mu_k) exp(-|w / w_s|^d)) Q
    sgn(w) + c w + c_Q Q w).

    static mu_s, kinetic mu_k; stribeck_rate w_s [rad/s or m/s]; exponent d, 2 (Gauss) or 1
    (Tustin). viscous c [N m s or N s/m]; load_viscous c_Q per unit of load [s or s/m];
    transition_rate: of the smoothed sign. Valid for sliding above it. Source: Guo, Ju and Wang,
    Aerospace 11 (2024) 368, Eq. 52 (exponent not given there).
    """
    effective = kinetic + (static - kinetic) * math.exp(-(abs(rate / stribeck_rate) ** exponent))
    return -(
        effective * load * direction(rate, transition_rate) + (viscous + load_viscous * load) * rate
    )


@joint_friction(
    breakaway=non_negative,
    coulomb=non_negative,
    viscous=non_negative,
    decay=non_negative,
    threshold=positive,
    needs_load=False,
    layer=lambda p: (p["threshold"], p["threshold"]),
)
def breakaway_linear(rate, load, breakaway, coulomb, viscous=0.0, decay=10.0, threshold=1e-4):
    """Combined breakaway, Coulomb and viscous friction with a linear zone at rest [N m or N]; no
    load enters.

    -[F_C + (F_b - F_C) exp(-c |w|)] sgn(w) - f w from |w| = w_t on, below it the straight line
    through zero to the same
    value: continuous. breakaway F_b, coulomb F_C [N m or N]; viscous f [N m s or N s/m]. decay c [s
        or s/m]; threshold w_t [rad/s or m/s]. Valid for sliding; below w_t it creeps.
    Source: Chacko and Khan, Tribology in Industry 39 (2017), Eqs. 14-17, the legacy friction block
    of Simscape. Two signs and a bracket of the printed equations are corrected (see the case
    mobile_manipulator).
    """
    speed = max(abs(rate), threshold)
    return (
        -(coulomb + (breakaway - coulomb) * math.exp(-decay * speed)) * rate / speed
        - viscous * rate
    )


@joint_friction(
    breakaway=non_negative,
    coulomb=non_negative,
    viscous=non_negative,
    breakaway_rate=positive,
    needs_load=False,
    layer=lambda p: (0.1 * p["breakaway_rate"], p["breakaway_rate"]),
)
def breakaway_smooth(rate, load, breakaway, coulomb, viscous=0.0, breakaway_rate=0.1):
    """Combined breakaway, Coulomb and viscous friction, smooth at rest [N m or N]; no load enters.

    T = -sqrt(2 e) (F_b - F_C) exp(-(w / w_S)^2) w / w_S - F_C tanh(w / w_C) - f w
    w_S = sqrt(2) w_b,   w_C = w_b / 10

    breakaway F_b, coulomb F_C [N m or N]; viscous f [N m s or N s/m];
    breakaway_rate w_b [rad/s or m/s]. Valid for sliding; at rest it creeps. Source: the friction
    blocks of Simscape since R2017b (their documentation).
    """
    ratio = rate / (ROOT_2 * breakaway_rate)
    hump = ROOT_2E * (breakaway - coulomb) * math.exp(-ratio * ratio) * ratio
    return -hump - coulomb * math.tanh(10.0 * rate / breakaway_rate) - viscous * rate


_LUGRE = {
    "static": positive,
    "kinetic": positive,
    "stribeck_rate": positive,
    "stiffness": positive,
    "damping": non_negative,
    "viscous": non_negative,
    "exponent": at_least_one,
    "size": _elastic_reach,
}


@joint_bristle(**_LUGRE, needs_load=False)
def joint_lugre(
    deflection,
    rate,
    load,
    static,
    kinetic,
    stribeck_rate,
    stiffness,
    damping=0.0,
    viscous=0.0,
    exponent=2.0,
):
    """LuGre friction of a joint at a fixed level, such as a preloaded ball joint; no load enters.

    z' = w - s_0 |w| z / g(w),   g = T_c + (T_s - T_c) exp(-|w / w_s|^d),
    T = -(s_0 z + s_1 z' + s_2 w)

    Returns (z', T). deflection z [rad or m]; static T_s, kinetic T_c [N m or N]; stribeck_rate w_s
    [rad/s or m/s]. Valid at rest and in sliding. stiffness s_0 [N m/rad or N/m], damping s_1 and
    viscous s_2 [N m s/rad or N s/m]; exponent d. It sticks with the stiffness s_0, breaks away at
    T_s and slides steadily at g + s_2 |w|. Passive at all rates if and only if s_2 >= s_1 (T_s -
    T_c) / T_c.
    Source: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419;
    as joint friction Pfitzer et al., Lubricants 13 (2025) 436 (1-D LuGre per axis).
    """
    level = kinetic + (static - kinetic) * math.exp(-(abs(rate / stribeck_rate) ** exponent))
    bending = rate - stiffness * abs(rate) * deflection / level
    return bending, -(stiffness * deflection + damping * bending + viscous * rate)


@joint_bristle(**_LUGRE)
def joint_lugre_loaded(
    deflection,
    rate,
    load,
    static,
    kinetic,
    stribeck_rate,
    stiffness,
    damping=0.0,
    viscous=0.0,
    exponent=2.0,
):
    """LuGre friction of a joint made by its reaction: T = -Q (s_0 z + s_1 z' + s_2 w), otherwise as
    joint_lugre.

    Returns (z', T). static mu_s, kinetic mu_k [-]; stribeck_rate w_s [rad/s or m/s], exponent d
    [-]. Per unit of load: stiffness s_0 [1/rad or 1/m], damping s_1 and viscous s_2 [s/rad or s/m].
    Valid at rest and in sliding.
    Source: as joint_lugre, scaled by the load.
    """
    level = kinetic + (static - kinetic) * math.exp(-(abs(rate / stribeck_rate) ** exponent))
    bending = rate - stiffness * abs(rate) * deflection / level
    return bending, -load * (stiffness * deflection + damping * bending + viscous * rate)


def _may_push(joint, parameters):
    """Bristle damping beyond the passive limit can give energy back."""
    if parameters["viscous"] * parameters["kinetic"] < parameters["damping"] * (
        parameters["static"] - parameters["kinetic"]
    ):
        return "is passive at all rates only with viscous >= damping (static - kinetic) / kinetic"
    return None


joint_lugre.doubts(_may_push)
joint_lugre_loaded.doubts(_may_push)


def _falling(static: str, kinetic: str) -> Callable:
    """Friction falls from the level at rest to that of sliding."""

    def demand(joint, parameters):
        high = parameters[static]
        low = parameters[kinetic]
        return f"needs {static} >= {kinetic}, got {high:g} and {low:g}" if high < low else None

    return demand


for _law in (joint_stribeck, joint_lugre, joint_lugre_loaded):
    _law.demands(_falling("static", "kinetic"))
for _law in (breakaway_linear, breakaway_smooth):
    _law.demands(_falling("breakaway", "coulomb"))
