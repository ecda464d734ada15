"""Dry friction: tangential force as a function of sliding speed and normal force."""

import math

from clearance.checks import non_negative, positive
from clearance.laws.law import friction


@friction(coefficient=non_negative, transition_speed=positive)
def coulomb(sliding_speed, normal_force, coefficient, transition_speed=1e-3):
    """Smooth Coulomb friction force [N], opposed to the sliding speed.

    F = -mu F_n v / sqrt(v^2 + v_t^2)

    sliding_speed v [m/s], normal_force F_n >= 0 [N]; coefficient mu, transition_speed v_t [m/s]. Infinitely smooth;
    reaches 99 % of mu F_n at v = 7 v_t. A regularised law: it creeps instead of sticking.
    Source: the usual algebraic regularisation of Coulomb's law; see Marques et al., Nonlinear Dyn. 86 (2016) 1407.
    """
    return -coefficient * normal_force * sliding_speed / math.sqrt(sliding_speed**2 + transition_speed**2)
