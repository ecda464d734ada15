"""Asperities between worn outlines: their pressure at each place of the arc, by the gap there.

    H = c - e_x cos theta - e_y sin theta + h_B(theta) + h_J(theta - a)        in the bearing's
    frame
    p = s F_n(H / sigma),   F_n(x) = integral_x^inf (t - x)^n phi(t) dt
    force F = -R L int p n dtheta,   normal load N = R L int p dtheta >= |F|
    moment M = -R L int p h_J' dtheta on the journal, its opposite on the bearing

Strength s and order n are those of the asperity law (laws/asperity.py): 5/2 of two rough surfaces,
3/2 of one. F_n comes from a table with exact slopes (1e-7 of its size near 0). The integral is the
trapezium rule over the nodes of the outline: within 1e-3 for clearances up to FINEST roughnesses.
Force and moment derive from one energy, and their derivatives are exact.

Source: pressure after Greenwood and Tripp, Proc. IMechE 185 (1970) 625, at the local gap.
"""

import math
from collections import namedtuple

import numpy as np

from clearance.laws.asperity import SQRT2PI
from clearance.laws.law import FilmJoint
from clearance.laws.outline import (
    COS,
    SIN,
    arc,
    cubic,
    cubic_bend,
    cubic_slope,
    four,
    overlap,
    places,
    turned,
    with_slopes,
)
from clearance.values.algebra import each

ORDERS = (2.5, 1.5)  # of the two tables
LEAST, MOST = -12.0, 6.0  # film thickness ratios; asperities of larger ones do not touch
POINTS = 200  # of an integral
PARTS = 16  # of a table, for a ratio of 1


#: solids of a place: stiffness K_w [Pa/m], roughness sigma [m], strength s [Pa], table of F_n
Rough = namedtuple("Rough", "stiffness roughness strength row")


def moments(order: float, ratios: np.ndarray) -> np.ndarray:
    """F_n at film thickness ratios, 2 n odd, by the trapezium rule in u = sqrt(t - x) (1e-12).

    The integrand is even in u and dies out: the rule has no error but of its end.
    """
    step = np.sqrt(np.maximum(-ratios, 0.0) + 9.0) / POINTS
    square = (step[:, None] * np.arange(1, POINTS + 1)) ** 2
    density = each(math.exp, -0.5 * (ratios[:, None] + square) ** 2) / SQRT2PI
    for _ in range(round(order + 0.5)):
        density *= square
    return 2.0 * density.sum(axis=1) * step


RATIOS = LEAST + np.arange(int((MOST - LEAST) * PARTS) + 1) / PARTS
VALUES = np.array([moments(n, RATIOS) for n in ORDERS])
SLOPES = np.array([-ORDERS[0] * VALUES[1], -ORDERS[1] * moments(0.5, RATIOS)])


def moment_and_slope(ratio, row):
    """F_n and its slope at a film thickness ratio; straight below LEAST."""
    if ratio >= MOST:
        return 0.0, 0.0
    if ratio <= LEAST:
        return VALUES[row, 0] + (ratio - LEAST) * SLOPES[row, 0], SLOPES[row, 0]
    position = (ratio - LEAST) * PARTS
    k = min(int(position), VALUES.shape[1] - 2)
    t = position - k
    a, b = VALUES[row, k], VALUES[row, k + 1]
    rise = SLOPES[row, k] / PARTS
    fall = SLOPES[row, k + 1] / PARTS
    bend = 3.0 * (b - a) - 2.0 * rise - fall
    twist = rise + fall - 2.0 * (b - a)
    return (
        a + t * (rise + t * (bend + t * twist)),
        PARTS * (rise + t * (2.0 * bend + 3.0 * t * twist)),
    )


def row_of(order: float) -> int:
    """The table of an order n."""
    return ORDERS.index(order)


def summed(eccentricity_x, eccentricity_y, angle, row, joint: FilmJoint, data, start, steep):
    """`pressed`, then its derivatives as `with_slopes` has them; zeros without
    `steep`.
    """
    x, y, sigma = eccentricity_x, eccentricity_y, joint.roughness
    first, cells = arc(x, y, joint.clearance - MOST * sigma)
    before, t = turned(angle)
    bearing, journal = places(int(start), first, before)
    weights = cubic(t)
    slopes = cubic_slope(t)
    bends = cubic_bend(t)
    journal_worn = data[int(start)] != 0.0
    fx = fy = load = moment = 0.0
    xx = xy = yy = nx = ny = 0.0
    xa = ya = na = aa = 0.0
    for node in range(first, first + 2 * cells):
        g = overlap(x, y, joint.clearance, data, bearing, journal, node, weights)
        p, slope = moment_and_slope(-g / sigma, int(row))
        c = COS[node + 1]
        d = SIN[node + 1]
        k = -slope / sigma
        fx -= p * c
        fy -= p * d
        load += p
        if steep:
            xx += k * c * c
            xy += k * c * d
            yy += k * d * d
            nx += k * c
            ny += k * d
        if journal_worn:
            j = four(data, journal + node, slopes)
            moment -= p * j
            if steep:
                xa += k * c * j
                ya += k * d * j
                na += k * j
                aa += k * j * j - p * four(data, journal + node, bends)
    return with_slopes((fx, fy, load, moment), (xx, xy, yy), (xa, ya, aa), (nx, ny, na))


def pressed(eccentricity_x, eccentricity_y, angle, row, joint: FilmJoint, data, start):
    """Force x, y, normal load N and moment M on the journal over s R L [1, 1, 1, m]."""
    values = summed(eccentricity_x, eccentricity_y, angle, row, joint, data, start, False)
    return values[0], values[1], values[2], values[3]


def pressed_slopes(eccentricity_x, eccentricity_y, angle, row, joint: FilmJoint, data, start):
    """`pressed`, then its derivatives by eccentricity_x, eccentricity_y and angle."""
    return summed(eccentricity_x, eccentricity_y, angle, row, joint, data, start, True)


pressed.slopes = pressed_slopes
