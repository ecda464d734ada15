"""Summits of rough surfaces on a layer of elastic columns, beside a film on the same layer.

    H = 1 - eps cos(phi) + P_f + P_a(H),   P = kappa p / c,   P_a = kappa / c K F_n((H c - z) / s)

The gap is flat in the middle of a film. The summits there press the layer back all over. So the
film has the eccentricity ratio eps_f = eps - P_a(h), with the gap h in its middle. Beside it the
surfaces are dry, P_f = 0. The flat gap ends where cos(phi) = (1 - h + P_a(h)) / eps, so that both
are one. With the sine s(H) of the place with the gap H,

    F_a = c R L / kappa int P_a cos(phi) dphi = 2 c R L / kappa int_h^inf s(H) (-dP_a / dH) dH

K F_n is the pressure of an asperity law, z its summit height. Moments of half orders follow from
their neighbours, F_(5/2) = k (F_2 F_3)^(1/2), k within 6e-4. Valid for summits up to ten times as
stiff as the layer, kappa K / s < 10.
Source: ours, by comparison with the film with memory on such a layer (film/summits.py).
"""

import math
from functools import cache

from clearance.laws.asperity import normal_density, normal_tail, second_moment, third_moment

NODES = 8  # parts of the sum over H: it errs by 1.5 % in nine states of ten, 2.3 % at most
REACH = 5.5  # roughnesses above the mean summit, where none touches any more
SLOWEST = 1e-14  # entrainment [rad/s] below which films count as turning so: no endless slopes
FARTHEST = 6.0  # film thickness ratio beyond which a moment is that there, 1e-12


def turned(turning):
    """Size of the entrainment [rad/s], never quite 0: gaps of films at rest have endless slopes."""
    return math.sqrt(turning * turning + SLOWEST * SLOWEST)


def half_order(below, above, x, most, middle, width):
    """F_n from F_(n - 1/2) and F_(n + 1/2) at x; most: what k loses up to x = infinity."""
    x -= middle
    return math.sqrt(below * above) * (1.0 - most * (0.5 + 0.5 * x / math.sqrt(x * x + width)))


def moment_of_two(ratio):
    """F_(5/2), of two rough surfaces."""
    x = min(ratio, FARTHEST)
    return half_order(second_moment(x), third_moment(x), x, 0.0406312, -0.5622, 12.27)


def moment_of_one(ratio):
    """F_(3/2), of a rough surface on a smooth one."""
    x = min(ratio, FARTHEST)
    first = normal_density(x) - x * normal_tail(x)
    return half_order(first, second_moment(x), x, 0.0600144, -0.6814, 8.331)


#: by the order of an asperity law's pressure
MOMENTS = {2.5: moment_of_two, 1.5: moment_of_one}


def sine_of_contact(gap, pressed, eccentricity_ratio):
    """Sine of the angle from the line of centres to where rough surfaces have a gap (over c)."""
    cosine = (1.0 - gap + pressed) / max(eccentricity_ratio, 0.1)
    square = 1.0 - cosine * cosine
    root = math.sqrt(square * square + 1e-12)
    return math.sqrt(0.5 * (square + root if square > 0.0 else 1e-12 / (root - square)))


@cache
def pressure_of(order):
    """P_a(h) of summits with the order n: pressed(film, joint, liner, factor, summit_height)."""
    moment = MOMENTS[order]

    def pressed(film, joint, liner, factor, summit_height):
        """kappa / c K F_n; film [m], liner kappa [m/Pa], factor K [Pa], summit_height [m]."""
        return liner * factor / joint.clearance * moment((film - summit_height) / joint.roughness)

    return pressed


@cache
def load_of(order):
    """F_a of summits with the order n, see `pressure_of`; film: h in the middle [m]."""
    pressed = pressure_of(order)

    def load(film, eccentricity_ratio, joint, liner, factor, summit_height):
        """The trapezium rule over NODES parts of H, which are finer at h [N]."""
        clearance, total, pressure, sine = joint.clearance, 0.0, 0.0, 0.0
        reach = REACH * joint.roughness + max(summit_height, 0.0)
        for k in range(NODES + 1):
            gap = film + reach * (k / NODES) ** 2.5
            before, beside = pressure, sine
            pressure = pressed(gap, joint, liner, factor, summit_height)
            sine = sine_of_contact(gap / clearance, pressure, eccentricity_ratio)
            if k > 0:
                total += (sine + beside) * (before - pressure)
        return clearance * joint.radius * joint.length / liner * total

    return load
