"""Dry contact of journal and bearing: normal force as a function of penetration and its rate.

Most laws are an elastic force times a hysteresis factor,

    F = F_elastic(delta) max(1 + chi delta' / max(delta'_0, v_g), 0)   for delta > 0, else 0,

with penetration delta [m], its rate delta' [m/s] and impact speed delta'_0 [m/s]. The impact speed
is the rate at first touch, frozen while the contact lasts. Each author derives the damping factor
chi from the restitution e. Impact speeds below the grazing speed v_g count as v_g, so that the
damping stays finite. The factor is cut at zero, so that a rebound is never pulled back. In joints
with a transition model contact has no first touch and delta'_0 is a typical speed throughout, see
transition.py.

All of them are linear elasticity of small strains. A formula may allow greater depths, but a run
warns of penetrations beyond a twentieth of the journal radius (`regimes.depth_warning`).

Stiffness, moduli and lengths that are not given are those of the joint that the law stands in.

Which restitution a factor really delivers does not depend on the elastic force: see
`delivered_restitution`.
"""

import math
from collections.abc import Callable
from functools import lru_cache

from clearance.laws.law import Derived, Law, OfJoint, contact
from clearance.laws.materials import Material, steel
from clearance.values.checks import Check, bounded, fraction, non_negative, positive
from clearance.values.columns import each

GRAZING_SPEED = 1e-3  # m/s
# penetration at which IMPACT's damping is complete, over that of the impact it is chosen for
STEP_DEPTH = 0.1
# of a body that IMPACT's damping gives back about the restitution requested, at 1 m/s [kg]
IMPACT_MASS = 0.1


# --- stiffness from material and geometry
def contact_modulus(a: Material, b: Material) -> float:
    """E* of two solids [Pa]: 1 / E* = (1 - nu_a^2) / E_a + (1 - nu_b^2) / E_b (Johnson, Contact
    Mechanics, 1985).
    """
    return 1.0 / ((1.0 - a.poisson**2) / a.young + (1.0 - b.poisson**2) / b.young)


def oedometric_modulus(young: float, poisson: float) -> float:
    """Modulus of a solid that cannot give sideways [Pa]: E (1 - nu) / ((1 + nu) (1 - 2 nu))."""
    return young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))


def layer_modulus(material: Material, thickness: float) -> float:
    """Modulus K_w [Pa/m] of an elastic layer of that thickness [m] on a rigid base: the oedometric
    modulus over it.

    Raises ValueError for nu = 0.5, where it is infinite.
    Source: Johnson, Contact Mechanics (1985), section 4.3; Podra and Andersson, Wear 207 (1997) 79.
    """
    if material.poisson >= 0.5:
        raise ValueError(
            f"material {material.name}: an incompressible layer (poisson 0.5) has no Winkler "
            f"modulus"
        )
    return oedometric_modulus(material.young, material.poisson) / positive("thickness", thickness)


def hertz_stiffness(
    radius: float,
    clearance: float,
    material: Material = steel,
    bearing_material: Material | None = None,
) -> float:
    """Generalised Hertz stiffness K of a pin in a hole, F = K delta^1.5.

    K = 4 / (3 (s_J + s_B)) * sqrt(R_J R_B / (R_B - R_J)),   s = (1 - nu^2) / E,   R_B = R_J + c

    journal radius R_J and radial clearance c [m], material of the journal and of the bearing
    (default: the same); result in N/m^1.5. An infinite clearance makes the bore a plane.
    The **minus** sign belongs to the internal (conformal) contact; the sphere formula behind it has
    no bearing length and is soft for tight clearances.
    Source: Lankarani and Nikravesh, J. Mech. Design 112 (1990) 369; Flores et al. (2004 to 2009).
    Raises ValueError unless radius and clearance are positive.
    """
    flat = clearance == math.inf
    bore = positive("radius", radius) + (clearance if flat else positive("clearance", clearance))
    a, b = material, bearing_material or material
    compliance = (1.0 - a.poisson**2) / a.young + (1.0 - b.poisson**2) / b.young
    curvature = radius if flat else radius * bore / (bore - radius)
    return 4.0 / (3.0 * compliance) * each(math.sqrt, curvature)


# --- what a joint determines where it is not given
def layer_of(joint) -> float:
    """Thickness of the elastic layer of a joint [m], half the journal radius by default."""
    return joint.layer or 0.5 * joint.radius


def _stiffness(joint, parameters: dict) -> float | None:
    """Hertz's, of the joint's radius, clearance and material."""
    if parameters["exponent"] != 1.5:
        exponent = parameters["exponent"]
        raise ValueError(
            f"the joint determines a stiffness for exponent 1.5, not {exponent:g}: give it"
        )
    if joint.radius is None:
        return None
    return hertz_stiffness(joint.radius, joint.clearance, joint.material)


def _layer_modulus(joint) -> float | None:
    """Of the joint's layer and material."""
    return (
        None
        if joint.layer is joint.radius is None
        else layer_modulus(joint.material, layer_of(joint))
    )


STIFFNESS = OfJoint(positive, _stiffness)
MODULUS = OfJoint(
    positive, lambda joint, parameters: contact_modulus(joint.material, joint.material)
)
LAYER = OfJoint(positive, lambda joint, parameters: _layer_modulus(joint))
LENGTH = OfJoint(positive, lambda joint, parameters: joint.length)
RADIUS = OfJoint(positive, lambda joint, parameters: joint.radius)
CLEARANCE = OfJoint(
    positive, lambda joint, parameters: None if joint.clearance == math.inf else joint.clearance
)


# --- damping and restitution
def delivered_restitution(damping: float) -> float:
    """Restitution e that a damping factor chi really gives a free impact, for any elastic force and
    mass.

    Solves chi (1 + e) = ln((1 + chi) / (1 - chi e)) for e by bisection (1e-12): dividing m v
    dv = -F ddelta by the hysteresis factor makes both sides integrable.
    """
    if damping < 1e-9:
        return 1.0
    low, high = 0.0, min(1.0, (1.0 - 1e-15) / damping)
    while low < (middle := 0.5 * (low + high)) < high:
        excess = damping * (1.0 + middle) - math.log((1.0 + damping) / (1.0 - damping * middle))
        low, high = (middle, high) if excess > 0.0 else (low, middle)
    return middle


@lru_cache
def exact_damping(restitution: float) -> float:
    """Damping factor chi in (0, 1 / e) whose delivered restitution is e: `delivered_restitution`
    solved for chi.
    """
    if restitution >= 1.0:
        return 0.0
    low, high = 0.0, 1.0 / restitution
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if delivered_restitution(middle) > restitution else (low, middle)
    return middle


#: below 0.01 the damping factor of the laws that divide by the restitution grows beyond all bounds
restitution_above_zero = bounded(
    lambda number: not 0.01 <= number <= 1.0, "lie in [0.01, 1] for this law"
)


def elastic_force(penetration, stiffness, exponent):
    """K delta^n; the square root of the usual n = 1.5 costs a third of a general power."""
    if exponent == 1.5:
        return stiffness * penetration * math.sqrt(penetration)
    return stiffness * penetration**exponent


def hysteresis(penetration_rate, impact_speed, damping, grazing_speed):
    """max(1 + chi delta' / max(delta'_0, v_g), 0)."""
    return max(1.0 + damping * penetration_rate / max(impact_speed, grazing_speed), 0.0)


def damped_force(
    penetration, penetration_rate, impact_speed, stiffness, exponent, damping, grazing_speed
):
    """K delta^n times the hysteresis factor in contact, else 0."""
    if penetration <= 0.0:
        return 0.0
    return elastic_force(penetration, stiffness, exponent) * hysteresis(
        penetration_rate, impact_speed, damping, grazing_speed
    )


#: equation and parameters of all laws with a hysteresis factor, in their docstrings
DAMPED = """
    F = K delta^n max(1 + chi delta' / max(delta'_0, v_g), 0) for delta > 0, else 0 [N]

    stiffness K [N/m^n], of the joint where it is not given (`hertz_stiffness`); restitution e [-];
    exponent n [-]; grazing_speed v_g [m/s]: slower impacts are damped as at this speed.
    Raises ValueError for an e that the formula does not allow.
"""


def by_restitution(check: Check) -> Callable[[Callable[[float], float]], Law]:
    """Decorate the damping factor chi(e) of a law: its force is `damped_force`.

    check: of the restitution e. A joint warns where the law delivers another restitution.
    """

    def law(damping: Callable[[float], float]) -> Law:
        def force(
            penetration,
            penetration_rate,
            impact_speed,
            stiffness,
            restitution,
            exponent=1.5,
            grazing_speed=GRAZING_SPEED,
        ):
            factor = damping(restitution)
            return damped_force(
                penetration,
                penetration_rate,
                impact_speed,
                stiffness,
                exponent,
                factor,
                grazing_speed,
            )

        def doubt(joint, parameters):
            wanted = parameters["restitution"]
            actual = delivered_restitution(damping(wanted))
            text = f"{result.name} delivers a restitution of {actual:.2f} where {wanted:.2f} is set"
            return text if abs(actual - wanted) > 0.05 else None

        force.__name__ = damping.__name__
        force.__doc__ = (damping.__doc__ or "").replace("\n\n", f"\n{DAMPED}", 1)
        result = contact(
            stiffness=STIFFNESS, restitution=check, exponent=positive, grazing_speed=positive
        )(force)
        result.doubts(doubt)
        return result

    return law


# --- laws
@contact(stiffness=STIFFNESS, exponent=positive, from_restitution=lambda pair, e: hertz().of(pair))
def hertz(penetration, penetration_rate, impact_speed, stiffness, exponent=1.5):
    """Elastic contact, F = K delta^n [N].

    stiffness K [N/m^n], of the joint where it is not given; exponent n [-]. Valid for point
    contact of small strains, without loss. Source: Hertz (1881); for a pin in a hole with
    `hertz_stiffness`.
    """
    if penetration <= 0.0:
        return 0.0
    return elastic_force(penetration, stiffness, exponent)


@hertz.doubts
def _point_contact(joint, parameters):
    """A sphere's formula in a conformal joint of some length."""
    conformal = joint.radius is not None and joint.clearance < 0.1 * joint.radius
    if joint.length is not None and conformal:
        return (
            "a point contact's law without dissipation; for a conformal joint with a length, liu "
            "or winkler are meant"
        )
    return None


def _chord(pair, e: float):
    """The chord of Hertz's law at a hundredth of the clearance; no damping belongs to a restitution
    without a mass.
    """
    depth = 0.01 * (pair.reach or pair.clearance)
    return kelvin_voigt(stiffness=pair.stiffness * depth**0.5, damping=0.0)


@contact(stiffness=positive, damping=non_negative, from_restitution=_chord)
def kelvin_voigt(penetration, penetration_rate, impact_speed, stiffness, damping):
    """Linear spring and damper, F = max(K delta + D delta', 0) [N]; stiffness K [N/m], damping D
    [N s/m].

    Valid as a penalty: the force jumps at first touch. Source: Kelvin and Voigt; Goldsmith, Impact
    (1960).
    """
    if penetration <= 0.0:
        return 0.0
    return max(stiffness * penetration + damping * penetration_rate, 0.0)


@kelvin_voigt.doubts
def _undamped(joint, parameters):
    """A linear spring alone."""
    return (
        "without damping it is a linear spring: impacts are elastic"
        if parameters["damping"] == 0.0
        else None
    )


@contact(
    stiffness=STIFFNESS,
    dissipation=non_negative,
    exponent=positive,
    # that of an impact at 1 m/s
    from_restitution=lambda pair, e: hunt_crossley_memoryless(dissipation=1.0 - e).of(pair),
)
def hunt_crossley_memoryless(
    penetration, penetration_rate, impact_speed, stiffness, dissipation, exponent=1.5
):
    """F = K delta^n max(1 + 1.5 alpha delta', 0) [N]; it does not look at the impact speed.

    stiffness K [N/m^n], dissipation alpha [s/m], exponent n [-]. For slow impacts the restitution
    is 1 - alpha v: it falls with the impact speed v. Valid for alpha v well below 1.
    Source: Hunt and Crossley, J. Applied Mechanics 42 (1975) 440, eqs. 10 to 14; Marhefka and Orin
    (1999).
    """
    if penetration <= 0.0:
        return 0.0
    return elastic_force(penetration, stiffness, exponent) * max(
        1.0 + 1.5 * dissipation * penetration_rate, 0.0
    )


@by_restitution(fraction)
def hunt_crossley(restitution):
    """chi = 3 (1 - e) / 2 [-]. Valid for e close to 1: delivers .909 for .9, .663 for .5.

    Source: Hunt and Crossley, J. Applied Mechanics 42 (1975) 440, with alpha = (1 - e) / delta'_0.
    """
    return 1.5 * (1.0 - restitution)


@by_restitution(fraction)
def herbert_mcwhannell(restitution):
    """chi = 6 (1 - e) / ((2 e - 1)^2 + 3) [-].

    Valid for e close to 1: delivers .901 for .9, .594 for .5.
    Source: Herbert and McWhannell, J. Eng. for Industry 99 (1977) 688.
    """
    return 6.0 * (1.0 - restitution) / ((2.0 * restitution - 1.0) ** 2 + 3.0)


@by_restitution(fraction)
def lee_wang(restitution):
    """chi = 3 (1 - e) / 4 [-]. Valid for e close to 1; loses too little: .952 for .9, .799 for .5.

    Source: Lee and Wang, J. Mech., Transmissions and Automation in Design 105 (1983) 534.
    """
    return 0.75 * (1.0 - restitution)


@by_restitution(fraction)
def lankarani_nikravesh(restitution):
    """chi = 3 (1 - e^2) / 4 [-]. Valid for e close to 1: delivers .913 for .9, but .725 for .5.

    Source: Lankarani and Nikravesh, J. Mech. Design 112 (1990) 369.
    """
    return 0.75 * (1.0 - restitution * restitution)


@by_restitution(restitution_above_zero)
def gonthier(restitution):
    """chi = (1 - e^2) / e [-]. Valid for all e: delivers .876 for .9, .488 for .5.

    Source: Gonthier, McPhee, Lange and Piedboeuf, Multibody Syst. Dyn. 11 (2004) 209.
    """
    return (1.0 - restitution * restitution) / restitution


@by_restitution(fraction)
def zhiying_qishao(restitution):
    """chi = 3 (1 - e^2) exp(2 (1 - e)) / 4 [-].

    Valid for all e: delivers .896 for .9, .483 for .5.
    Source: Qin and Lu, Chinese J. Theor. Appl. Mech. (2006), as listed by Alves et al., Mech. Mach.
    Theory 85 (2015).
    """
    return 0.75 * (1.0 - restitution * restitution) * math.exp(2.0 * (1.0 - restitution))


@by_restitution(restitution_above_zero)
def flores(restitution):
    """chi = 8 (1 - e) / (5 e) [-].

    Valid for all e: delivers .894 for .9, .470 for .5.
    Source: Flores, Machado, Silva and Martins, Multibody Syst. Dyn. 25 (2011) 357.
    """
    return 1.6 * (1.0 - restitution) / restitution


@by_restitution(restitution_above_zero)
def hu_guo(restitution):
    """chi = 3 (1 - e) / (2 e) [-].

    Valid for all e: delivers .900 for .9, .488 for .5.
    Source: Hu and Guo, Nonlinear Dyn. 81 (2015) 1415.
    """
    return 1.5 * (1.0 - restitution) / restitution


EXACT = Derived(lambda parameters: exact_damping(parameters["restitution"]))


@contact(
    stiffness=STIFFNESS,
    restitution=restitution_above_zero,
    exponent=positive,
    grazing_speed=positive,
    damping=EXACT,
)
def exact_restitution(
    penetration,
    penetration_rate,
    impact_speed,
    stiffness,
    restitution,
    exponent=1.5,
    grazing_speed=GRAZING_SPEED,
    damping=None,
):
    """The hysteresis factor that delivers exactly the given restitution [N]; chi is solved for
    once, when bound.

    chi (1 + e) = ln((1 + chi) / (1 - chi e))

    Force and parameters are those of `hunt_crossley`: stiffness K [N/m^n], restitution e, exponent
    n [-], grazing_speed v_g [m/s]. Valid for every stiffness, exponent and mass. Raises ValueError
    for e outside [0.01, 1].
    Source: our solution of the impact with the damping of Hunt and Crossley (1975), integrated in
    closed form.
    """
    return damped_force(
        penetration, penetration_rate, impact_speed, stiffness, exponent, damping, grazing_speed
    )


def lambert_w(x):
    """Lower branch W_-1 of w e^w = x for -1/e <= x < 0 (w <= -1), by Halley's method from a series
    at the branch point.

    Source: Corless et al., Adv. Comput. Math. 5 (1996) 329.
    """
    if x >= -0.25:
        first = math.log(-x)
        w = first - math.log(-first)
    else:
        root = math.sqrt(max(2.0 * (1.0 + math.e * x), 0.0))
        w = -1.0 - root - root * root / 3.0
    for _ in range(8):
        power = math.exp(w)
        miss = w * power - x
        slope = power * (w + 1.0)
        if abs(slope) < 1e-300:
            break
        change = miss / (slope - 0.5 * (w + 2.0) * miss / (w + 1.0))
        w -= change
        if abs(change) < 1e-15 * abs(w):
            break
    return w


def johnson_force(penetration, modulus, length, radius_difference):
    """Load of Johnson's cylinders [N], solved for the load without iteration over it; see
    `johnson`.
    """
    limit = 0.95 * 4.0 * radius_difference / math.e**2
    depth = min(penetration, limit)
    w = lambert_w(-0.25 * math.e * depth / radius_difference)
    force = -math.pi * modulus * length * depth / w
    slope = math.pi * modulus * length / (-w - 1.0)
    return force + slope * max(penetration - limit, 0.0)


@contact(
    modulus=MODULUS,
    length=LENGTH,
    radius_difference=CLEARANCE,
    restitution=restitution_above_zero,
    grazing_speed=positive,
    damping=EXACT,
    limit=lambda parameters: 0.95 * 4.0 * parameters["radius_difference"] / math.e**2,
)
def johnson(
    penetration,
    penetration_rate,
    impact_speed,
    modulus,
    length,
    radius_difference,
    restitution=1.0,
    grazing_speed=GRAZING_SPEED,
    damping=None,
):
    """Johnson's cylinder in a cylinder [N], with the exact hysteresis factor.

    delta = f / (pi E*) (ln(4 pi E* DR / f) - 1),  f = F / L
    f = -pi E* delta / W_-1(-e delta / (4 DR))    (solved for the force)

    modulus E* [Pa] (`contact_modulus`), bearing length L [m], radius_difference DR = clearance [m],
    restitution and grazing_speed v_g as in `exact_restitution`. Valid for
    delta < 4 DR / e^2 = 0.541 DR (e of logarithms), where the compliance reaches zero. From 95
    % of that on the force continues with its slope there. The joint warns if a run reaches this
    range.
    Source: Johnson, Contact Mechanics (1985), section 5.6; Pereira, Ramalho and Ambrosio (2011)
    for the form with Lambert's W.
    """
    if penetration <= 0.0:
        return 0.0
    factor = hysteresis(penetration_rate, impact_speed, damping, grazing_speed)
    return johnson_force(penetration, modulus, length, radius_difference) * factor


@contact(
    modulus=MODULUS,
    length=LENGTH,
    radius_difference=CLEARANCE,
    restitution=restitution_above_zero,
    grazing_speed=positive,
    damping=EXACT,
)
def liu(
    penetration,
    penetration_rate,
    impact_speed,
    modulus,
    length,
    radius_difference,
    restitution=1.0,
    grazing_speed=GRAZING_SPEED,
    damping=None,
):
    """Liu's conformal cylinders [N], with the exact hysteresis factor.

    F = pi / 2 E* L delta sqrt(delta / (2 (DR + delta)))

    modulus E* [Pa], bearing length L [m], radius_difference DR = clearance [m]; restitution e,
    grazing_speed v_g as in `exact_restitution`. Valid for small strains; explicit for any
    penetration. Source: Liu, Zhang and Yang, J. Mech. Design 129 (2007) 93.
    """
    if penetration <= 0.0:
        return 0.0
    share = penetration / (2.0 * (radius_difference + penetration))
    elastic = 0.5 * math.pi * modulus * length * penetration * math.sqrt(share)
    return elastic * hysteresis(penetration_rate, impact_speed, damping, grazing_speed)


@contact(
    layer_modulus=LAYER,
    length=LENGTH,
    radius=RADIUS,
    radius_difference=CLEARANCE,
    restitution=restitution_above_zero,
    grazing_speed=positive,
    damping=EXACT,
)
def winkler(
    penetration,
    penetration_rate,
    impact_speed,
    layer_modulus,
    length,
    radius,
    radius_difference,
    restitution=1.0,
    grazing_speed=GRAZING_SPEED,
    damping=None,
):
    """Winkler (elastic foundation) contact of a journal in a bearing [N], with the exact hysteresis
    factor.

    F = K_w L R (e arccos(c / e) - c / e sqrt(e^2 - c^2)) = K_w L R e (2 a - sin 2 a) / 2
    e = c + delta = c / cos a
    F = 4 sqrt(2) / 3 K_w L R delta^1.5 / sqrt(c)    (for small delta)

    layer_modulus K_w [Pa/m] (`layer_modulus`), length L, radius R, radius_difference c [m].
    restitution e, grazing_speed v_g as in `exact_restitution`. Valid for small strains of a thin
    layer; computed for any penetration up to half the bore. The thickness of the
    layer is the free choice of this model.
    Source: elastic foundation after Johnson, Contact Mechanics (1985), section 4.3; integrated over
    the conformal arc.
    """
    if penetration <= 0.0:
        return 0.0
    e = radius_difference + penetration
    root = math.sqrt(penetration * (e + radius_difference))
    double = 2.0 * math.atan2(root, radius_difference)
    if double < 0.1:
        area = double**3 / 6.0 * (1.0 - double * double / 20.0 * (1.0 - double * double / 42.0))
    else:
        area = double - math.sin(double)
    elastic = 0.5 * e * area
    force = layer_modulus * length * radius * elastic
    return force * hysteresis(penetration_rate, impact_speed, damping, grazing_speed)


def adams_step(x, x0, h0, x1, h1):
    """The STEP function of ADAMS: h0 below x0, h1 above x1, between them h0 + (h1 - h0) s^2 (3 - 2
    s).
    """
    s = min(max((x - x0) / (x1 - x0), 0.0), 1.0)
    return h0 + (h1 - h0) * s * s * (3.0 - 2.0 * s)


def _damper(pair, e: float):
    """A linear damper has no restitution of its own; this one takes from 0.1 kg at 1 m/s what
    0.8 < e < 1 requires.

    Energy m ln(1/e) v^2 = C v d I. The elastic impact's depth is d = (5 m v^2 / (4 K))^(2/5), its
    path is I = 1.635 of the speed over it. Off by less than 0.02 for e >= 0.8, by 0.1 for e = 0.3;
    e counts as 0.01 at least.
    """
    reach = (1.25 * IMPACT_MASS / pair.stiffness) ** 0.4
    damping = IMPACT_MASS * -math.log(max(e, 0.01)) / (1.635 * reach)
    return impact(stiffness=pair.stiffness, exponent=1.5, damping=damping, depth=STEP_DEPTH * reach)


@contact(
    stiffness=STIFFNESS,
    exponent=positive,
    damping=non_negative,
    depth=positive,
    from_restitution=_damper,
)
def impact(
    penetration, penetration_rate, impact_speed, stiffness, exponent=1.5, damping=10.0, depth=1e-5
):
    """The IMPACT function of ADAMS [N]: F = max(K delta^n + STEP(delta, 0, 0, d, C) delta', 0).

    stiffness K [N/m^n], exponent n, damping C [N s/m] reached at the depth d [m]. Valid as a
    penalty: it does not depend on the impact speed and has no restitution.
    Source: MSC ADAMS/Solver manual, functions IMPACT and STEP.
    """
    if penetration <= 0.0:
        return 0.0
    grown = adams_step(penetration, 0.0, 0.0, depth, damping)
    return max(elastic_force(penetration, stiffness, exponent) + grown * penetration_rate, 0.0)
