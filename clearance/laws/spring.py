"""Springs and dampers: tension [N] over the elongation of a line, or moment [N m] over a twist.

elongation: length less free length [m], or twist less free angle [rad]; rate: its rate. Tension is
positive; a law of twist has N m and rad in place of N and m.
"""

import math

from clearance.laws.law import spring
from clearance.values.checks import non_negative, positive


@spring(stiffness=non_negative, damping=non_negative)
def cubic_spring(elongation, rate, stiffness, cubic, damping=0.0):
    """T = k x + k_3 x^3 + d x' [N]: a spring that hardens (k_3 > 0) or softens.

    stiffness k [N/m], cubic k_3 [N/m^3], damping d [N s/m]. With k_3 = 0 it is linear. Valid for
    k + 3 k_3 x^2 > 0, where it is stable.
    Raises ValueError for a negative stiffness or damping.
    Source: Duffing, Erzwungene Schwingungen bei veraenderlicher Eigenfrequenz (1918).
    """
    return stiffness * elongation + cubic * elongation**3 + damping * rate


def _in_stop(elongation, rate, stiffness, play, dissipation):
    return -elongation - play, -rate


def _in_flank(elongation, rate, stiffness, play, dissipation):
    return abs(elongation) - 0.5 * play, rate if elongation > 0.0 else -rate


#: contacts of `stop` and `backlash`; without play they have no way of their own
STOP = _in_stop, lambda values: values["play"] or 1.0
FLANKS = _in_flank, lambda values: 0.5 * values["play"] or 1.0


@spring(stiffness=positive, play=non_negative, dissipation=non_negative, engaged=STOP)
def stop(elongation, rate, stiffness, play=0.0, dissipation=0.0):
    """T = -k d (1 + chi d') where d = -x - play > 0, else 0; never pulling [N]: a bumper.

    stiffness k [N/m]; play [m]: way from the free length to the stop; dissipation chi [s/m]. The
    force starts at 0 at any speed. Restitution is some 1 - 2/3 chi v; valid for small chi v.
    Raises ValueError for a stiffness that is not positive and other negative numbers.
    Source: Hunt and Crossley, J. Appl. Mech. 42 (1975) 440, with the exponent 1.
    """
    depth = -elongation - play
    if depth <= 0.0:
        return 0.0
    return -max(stiffness * depth * (1.0 - dissipation * rate), 0.0)


@spring(stiffness=positive, play=non_negative, dissipation=non_negative, engaged=FLANKS)
def backlash(elongation, rate, stiffness, play, dissipation=0.0):
    """T = s k d (1 + chi s x') where d = |x| - play / 2 > 0, s = sign(x), else 0 [N]: a loose fit.

    stiffness k [N/m] of either side; play [m] in all; dissipation chi [s/m], as `stop`. It never
    pulls back. Without play it is a linear spring. Valid for small chi x'.
    Raises ValueError for a stiffness that is not positive and other negative numbers.
    Source: Hunt and Crossley, J. Appl. Mech. 42 (1975) 440; teeth: Kahraman and Singh (1990).
    """
    depth = abs(elongation) - 0.5 * play
    if depth <= 0.0:
        return 0.0
    side = 1.0 if elongation > 0.0 else -1.0
    return side * max(stiffness * depth * (1.0 + dissipation * side * rate), 0.0)


@spring(force=non_negative, transition_rate=positive, viscous=non_negative)
def friction_damper(elongation, rate, force, transition_rate, viscous=0.0):
    """T = F tanh(x' / v_t) + d x' [N]: a damper with dry friction, smooth at rest.

    force F [N]; transition_rate v_t [m/s], far below the speeds of interest; viscous d [N s/m].
    Valid for sliding far above v_t; at rest it creeps. Raises ValueError for negative numbers and a
    v_t of 0.
    Source: as `joint_coulomb`; Andersson, Soederberg and Bjoerklund, Tribol. Int. 40 (2007) 580.
    """
    return force * math.tanh(rate / transition_rate) + viscous * rate


@spring(quadratic=non_negative, viscous=non_negative)
def quadratic_damper(elongation, rate, quadratic, viscous=0.0):
    """T = c |x'| x' + d x' [N]: an orifice, whose pressure drop grows with the squared flow.

    quadratic c [N s2/m2], viscous d [N s/m]. Valid for turbulent flow. Raises ValueError for
    negative numbers.
    Source: Dixon, The Shock Absorber Handbook, 2nd ed., Wiley 2007, ch. 6.
    """
    return quadratic * abs(rate) * rate + viscous * rate
