"""Dry friction: tangential force as a function of sliding speed and normal force.

A friction law returns the force on the body whose sliding speed v [m/s] it gets, opposed to v [N];
normal force F_n >= 0 [N]. Laws written with mu_eff(v) return -mu_eff F_n sgn v. Regularised laws
creep instead of sticking; `lugre` sticks, and has the deflection of its bristles as a state of the
joint.
"""

import math

from clearance.laws.law import bristle, friction
from clearance.values.checks import at_least_one, non_negative, positive

ADHERES = 1.25  # coefficient at rest over that of sliding, where only this is known
SMALL_FORCE = 1e-3  # N: normal force over which bristles come into touch


@friction(coefficient=non_negative, transition_speed=positive)
def coulomb(sliding_speed, normal_force, coefficient, transition_speed=1e-3):
    """Smooth Coulomb friction [N], algebraic: F = -mu F_n v / sqrt(v^2 + v_t^2).

    coefficient mu [-], transition_speed v_t [m/s]. Valid for sliding far above v_t; at rest it
    creeps. Infinitely smooth; reaches 99 % of mu F_n at v = 7
    v_t.
    Source: the usual algebraic regularisation of Coulomb's law; see Marques et al., Nonlinear Dyn.
    86 (2016) 1407.
    """
    return (
        -coefficient
        * normal_force
        * sliding_speed
        / math.sqrt(sliding_speed**2 + transition_speed**2)
    )


@friction(coefficient=non_negative, transition_speed=positive)
def coulomb_tanh(sliding_speed, normal_force, coefficient, transition_speed=1e-3):
    """Smooth Coulomb friction [N]: F = -mu F_n tanh(v / v_t); 99 % of mu F_n at v = 2.65 v_t.

    coefficient mu [-], transition_speed v_t [m/s]. Valid for sliding far above v_t; at rest it
    creeps.
    Source: see Marques et al., Nonlinear Dyn. 86 (2016) 1407.
    """
    return -coefficient * normal_force * math.tanh(sliding_speed / transition_speed)


@friction(coefficient=non_negative, transition_speed=positive)
def threlfall(sliding_speed, normal_force, coefficient, transition_speed=1e-3):
    """Threlfall's friction [N]: mu_eff = mu (1 - exp(-3 |v| / v_0)) up to v_0, 0.95 mu beyond.

    coefficient mu [-], transition_speed v_0 [m/s]. Valid for sliding; at rest it creeps.
    Continuous to 2e-4 at v_0 only. Source: Threlfall, Mech. Mach.
    Theory 13 (1978) 475.
    """
    speed = abs(sliding_speed)
    if speed <= transition_speed:
        effective = coefficient * (1.0 - math.exp(-3.0 * speed / transition_speed))
    else:
        effective = 0.95 * coefficient
    return -effective * normal_force * math.copysign(1.0, sliding_speed)


@friction(coefficient=non_negative, dead_speed=non_negative, full_speed=positive)
def ambrosio(sliding_speed, normal_force, coefficient, dead_speed=1e-4, full_speed=1e-3):
    """Ambrosio's friction [N], with a ramp: -mu N sgn(v) r,  r = (|v| - v_0) / (v_1 - v_0) within
    [0, 1].

    coefficient mu [-]; dead_speed v_0, full_speed v_1 > v_0 [m/s]. Continuous, no stiction; keeps
    the sign of v from chattering. Validity: its kinks limit the accuracy at tight tolerances;
    `coulomb` has none.
    Source: Ambrosio, in Virtual Nonlinear Multibody Systems (2003), 57.
    """
    ramp = (abs(sliding_speed) - dead_speed) / (full_speed - dead_speed)
    return (
        -coefficient * min(max(ramp, 0.0), 1.0) * normal_force * math.copysign(1.0, sliding_speed)
    )


@ambrosio.demands
def _ramp_exists(joint, parameters):
    """The ramp ends above where it begins."""
    if parameters["full_speed"] <= parameters["dead_speed"]:
        return (
            f"needs dead_speed < full_speed, got {parameters['dead_speed']:g} and "
            f"{parameters['full_speed']:g} m/s"
        )
    return None


@friction(
    static=non_negative,
    kinetic=non_negative,
    transition_speed=positive,
    decay=non_negative,
    from_coefficient=lambda mu: bengisu_akay(static=ADHERES * mu, kinetic=mu),
)
def bengisu_akay(sliding_speed, normal_force, static, kinetic, transition_speed=1e-3, decay=100.0):
    """Bengisu and Akay's friction [N]: a parabola up to mu_s at v_0, then an exponential fall to
    mu_k.

    mu_eff = mu_s (1 - (|v| / v_0 - 1)^2) for |v| < v_0, mu_k + (mu_s - mu_k) exp(-xi (|v| - v_0))
    beyond. static mu_s, kinetic mu_k [-]; transition_speed v_0 [m/s], decay xi [s/m]. Valid for
    sliding; at rest it creeps.
    Source: Bengisu and Akay, J. Vibration and Acoustics 116 (1994) 166.
    """
    speed = abs(sliding_speed)
    if speed < transition_speed:
        effective = static * (1.0 - (speed / transition_speed - 1.0) ** 2)
    else:
        effective = kinetic + (static - kinetic) * math.exp(-decay * (speed - transition_speed))
    return -effective * normal_force * math.copysign(1.0, sliding_speed)


@friction(
    static=non_negative,
    kinetic=non_negative,
    stribeck_speed=positive,
    exponent=at_least_one,
    viscous=non_negative,
    transition_speed=positive,
    from_coefficient=lambda mu: stribeck(static=ADHERES * mu, kinetic=mu),
)
def stribeck(
    sliding_speed,
    normal_force,
    static,
    kinetic,
    stribeck_speed=1e-2,
    exponent=2.0,
    viscous=0.0,
    transition_speed=1e-4,
):
    """Stribeck friction [N], smoothed at rest: F = -F_n ((mu_k + (mu_s - mu_k)
    exp(-(|v| / v_s)^gamma)) s + sigma v).

    s = tanh(v / v_t); static mu_s, kinetic mu_k [-]; stribeck_speed v_s, transition_speed v_t <<
    v_s [m/s], exponent gamma >= 1, viscous sigma per unit of normal force [s/m]. Valid for sliding
    far above v_t; at rest it creeps. Source: Bo and Pavelescu, Wear 82 (1982) 277;
    Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994).
    """
    ratio = abs(sliding_speed) / stribeck_speed
    effective = kinetic + (static - kinetic) * math.exp(-(ratio**exponent))
    return -normal_force * (
        effective * math.tanh(sliding_speed / transition_speed) + viscous * sliding_speed
    )


@friction(
    coefficient=non_negative,
    viscous=non_negative,
    transition_speed=positive,
    from_coefficient=lambda mu: coulomb_viscous(coefficient=mu, viscous=0.1),
)
def coulomb_viscous(sliding_speed, normal_force, coefficient, viscous, transition_speed=1e-3):
    """Coulomb friction, smoothed, and a viscous part [N]: F = -F_n (mu tanh(v / v_t) + sigma v).

    coefficient mu [-], viscous sigma per unit of normal force [s/m], transition_speed v_t [m/s].
    Valid for sliding far above v_t; at rest it creeps. Source: see Marques et
    al., Nonlinear Dyn. 86 (2016) 1407.
    """
    return -normal_force * (
        coefficient * math.tanh(sliding_speed / transition_speed) + viscous * sliding_speed
    )


@bristle(
    static=positive,
    kinetic=positive,
    stribeck_speed=positive,
    stiffness=positive,
    damping=positive,
    viscous=non_negative,
    size=lambda parameters: parameters["static"] / parameters["stiffness"],
    from_coefficient=lambda mu: lugre(static=ADHERES * mu, kinetic=mu, damping=100.0 * mu),
)
def lugre(
    deflection,
    sliding_speed,
    normal_force,
    static,
    kinetic,
    stribeck_speed=1e-2,
    stiffness=1e5,
    damping=10.0,
    viscous=0.0,
):
    """LuGre friction: bristles that deflect by z [m]. Returns (z', force [N]).

    z' = v - sigma_0 |v| z / g(v),   g = mu_k + (mu_s - mu_k) exp(-(v / v_s)^2),
    F = -F_n (sigma_0 z + sigma_1 exp(-(v / v_s)^2) z' + sigma_2 v)

    static mu_s, kinetic mu_k [-]; per unit of normal force stiffness sigma_0 [1/m], damping sigma_1
    [s/m], viscous sigma_2 [s/m]; stribeck_speed v_s [m/s]. Valid at rest and in sliding. Without
    contact the bristles relax, z' = -sigma_0 z / sigma_1, blended over a normal force of 1 mN.
    Sliding steadily it is the Stribeck law; it sticks with a stiffness sigma_0 F_n. The damping
    fades with the speed: undiminished, fresh bristles of an impact would rub with sigma_1 v.
    Passive for sigma_1 v_s well below 10 mu_k. Source: Canudas de Wit, Olsson, Astrom and
    Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419, scaled by F_n; with fading damping, Olsson
    (1996).
    """
    slow = math.exp(-((sliding_speed / stribeck_speed) ** 2))
    rate = sliding_speed - stiffness * abs(sliding_speed) * deflection / (
        kinetic + (static - kinetic) * slow
    )
    free = math.exp(-max(normal_force, 0.0) / SMALL_FORCE)
    rate = (1.0 - free) * rate - free * stiffness * deflection / damping
    force = -normal_force * (
        stiffness * deflection + damping * slow * rate + viscous * sliding_speed
    )
    return rate, force


@lugre.doubts
def _damping_rubs(joint, parameters):
    """The damping's part of the force peaks at v_s / sqrt(2)."""
    most = 0.43 * parameters["damping"] * parameters["stribeck_speed"]
    if most > 4.0 * parameters["kinetic"]:
        return (
            f"the bristles' damping rubs with up to {most:.2g} F_n, far above kinetic "
            f"{parameters['kinetic']:g}"
        )
    return None
