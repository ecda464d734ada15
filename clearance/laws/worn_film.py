"""The film of a short bearing on worn outlines.

    (R/L)^2 d/dzeta (H^3 dP/dzeta) = 6 spin d(H_e + h_B - h_J)/dtheta + 12 d(H_e + lift)/dt = r
    H = H_e + h_B + h_J + lift,   H_e = 1 - x cos theta - y sin theta,   p = mu (R/c)^2 P, P >= 0
    axial mean  P = -(L/R)^2 r / (12 H^3)  where r < 0

in the bearing's frame, lengths over the clearance c; spin = omega_J - omega_B. The bearing's
outline counts with +6 spin, the journal's with -6 spin, for it turns. `lift` is what a transition
adds to the gap of a rough joint, the same all around: the smallest gap is the film gap that the
transition gives. Sums over the middles between nodes, where the bearing's outline is straight;
cells around an edge of the bearing's scar are summed at more places, see `laws.outline.pieces`. The
oil drags all around.

Valid for L/D < 0.25, too stiff above. Unworn and without lift it is `short_film` (1e-4).
Source: DuBois and Ocvirk, NACA TR 1157 (1953), place by place; outlines as in film/conserving.py.
"""

import math

import numpy as np

from clearance.laws.law import FilmJoint
from clearance.laws.outline import (
    EDGES,
    LINE,
    NODES,
    PIECE,
    STEP,
    cubic,
    cubic_bend,
    cubic_slope,
    four,
    places,
    turned,
)
from clearance.values.algebra import each

THINNEST = 1e-6  # H is not taken below this
# of the middles between nodes
COS, SIN = (each(f, STEP * (np.arange(NODES) + 0.5)) for f in (math.cos, math.sin))


def gap_and_source(motion, lift, h, slope, c, s):
    """H and r at an angle; motion: x, y, their rates, spin; lift: that and its rate; h: sum of both
    depths, slope: of the bearing's minus the journal's.
    """
    x, y, vx, vy, spin = motion
    wedge = 6.0 * spin * (x * s - y * c + slope)
    return 1.0 - x * c - y * s + h + lift[0], wedge - 12.0 * (vx * c + vy * s - lift[1])


def depths(data, bearing, journal, node, clearance, weights, slopes):
    """Over c behind a node: sum of depths, slope of the bearing's, slope of the journal's."""
    here = data[bearing + node] / clearance
    beyond = data[bearing + node + 1] / clearance
    h = 0.5 * (here + beyond)
    rise = (beyond - here) / STEP
    h += four(data, journal + node, weights) / clearance
    return h, rise, four(data, journal + node, slopes) / clearance


def beside(data, start, piece, angle, clearance):
    """A piece of a cell with an edge: its share, cos and sin, then as `depths`, and the journal's
    bend.
    """
    at = start + EDGES + 1 + PIECE * piece
    share = data[at]
    node = int(data[at + 1])
    u = data[at + 2]
    c = data[at + 3]
    s = data[at + 4]
    h = data[at + 5] / clearance
    rise = data[at + 6] / clearance
    fall = 0.0
    bend = 0.0
    if data[start] != 0.0:
        before, t = turned(angle - u * STEP)
        index = start + 2 + LINE + (node + before) % NODES
        h += four(data, index, cubic(t)) / clearance
        fall = four(data, index, cubic_slope(t)) / clearance
        bend = four(data, index, cubic_bend(t)) / clearance
    return share, c, s, h, rise, fall, bend


def size_of(joint):
    """mu (R/c)^2 R L (L/R)^2 / 12: force of a unit of r / H^3 [N s]."""
    thin = joint.length / joint.clearance
    return joint.viscosity * thin * thin * joint.radius * joint.length / 12.0


def summed(motion, angle, lift, joint: FilmJoint, data, start, steep):
    """`short_on_outlines`, then the derivatives of its values by the first eight arguments; zeros
    without `steep`.
    """
    x, y, _, _, spin = motion
    before, t = turned(angle - 0.5 * STEP)
    bearing, journal = places(int(start), 0, before)
    weights = cubic(t)
    slopes = cubic_slope(t)
    bends = cubic_bend(t)
    fx = fy = shear = 0.0
    xx = xy = yx = yy = xa = ya = xl = yl = 0.0
    cc = cs = ss = xs = ys = xr = yr = 0.0
    sx = 0.0
    sy = 0.0
    sa = 0.0
    sl = 0.0
    first = int(start)
    for node in range(NODES + int(data[first + EDGES])):
        if node < NODES:
            share, c, s = 1.0, COS[node], SIN[node]
            h, rise, fall = depths(data, bearing, journal, node, joint.clearance, weights, slopes)
            bend = four(data, journal + node, bends) / joint.clearance if steep else 0.0
        else:
            piece = beside(data, first, node - NODES, angle, joint.clearance)
            share, c, s, h, rise, fall, bend = piece
        gap, r = gap_and_source(motion, lift, h, rise - fall, c, s)
        inverse = 1.0 / max(gap, THINNEST)
        by_gap = -share * inverse * inverse if gap > THINNEST else 0.0
        cube = share * inverse * inverse * inverse
        shear += share * inverse
        if r < 0.0:
            fx += r * cube * c
            fy += r * cube * s
        if steep:
            sx, sy, sa, sl = sx - by_gap * c, sy - by_gap * s, sa - by_gap * fall, sl + by_gap
        if steep and r < 0.0:
            thinner = 3.0 * r * inverse * inverse * by_gap
            by_x = 6.0 * spin * s * cube - thinner * c
            by_y = -6.0 * spin * c * cube - thinner * s
            by_angle = 6.0 * spin * bend * cube - thinner * fall
            by_spin = 6.0 * (x * s - y * c + rise - fall) * cube
            xx, xy, yx, yy = xx + by_x * c, xy + by_y * c, yx + by_x * s, yy + by_y * s
            xa += by_angle * c
            ya += by_angle * s
            xl += thinner * c
            yl += thinner * s
            cc -= 12.0 * cube * c * c
            cs -= 12.0 * cube * c * s
            ss -= 12.0 * cube * s * s
            xs, ys, xr, yr = xs + by_spin * c, ys + by_spin * s, xr + cube * c, yr + cube * s
    w = STEP * size_of(joint)
    return (
        w * fx,
        w * fy,
        STEP * shear,
        w * xx,
        w * xy,
        w * cc,
        w * cs,
        w * xs,
        w * xa,
        w * xl,
        12.0 * w * xr,
        w * yx,
        w * yy,
        w * cs,
        w * ss,
        w * ys,
        w * ya,
        w * yl,
        12.0 * w * yr,
        STEP * sx,
        STEP * sy,
        0.0,
        0.0,
        0.0,
        STEP * sa,
        STEP * sl,
        0.0,
    )


def short_on_outlines(x, y, vx, vy, spin, angle, lift, lift_rate, joint: FilmJoint, data, start):
    """Force x, y on the journal [N] and the integral of 1 / H all around [1]; angle: of the
    journal.
    """
    values = summed((x, y, vx, vy, spin), angle, (lift, lift_rate), joint, data, start, False)
    return values[0], values[1], values[2]


def short_slopes(x, y, vx, vy, spin, angle, lift, lift_rate, joint: FilmJoint, data, start):
    """`short_on_outlines`, then the derivatives of its values by the first eight arguments."""
    return summed((x, y, vx, vy, spin), angle, (lift, lift_rate), joint, data, start, True)


short_on_outlines.slopes = short_slopes
