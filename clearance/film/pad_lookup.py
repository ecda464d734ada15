"""Looks the film of a pad up in its table: see film/pad_table.py."""

import math

from clearance.film.lookup import cell, patch, splines

HEAD = 4  # numbers before the coefficients: nodes over y, cells per y, cells over theta, per theta
TOP = 3.2  # largest |y| of the nodes, tau = 0.9967
PARTS = 3  # load, moment, wetted area
NODES = 65  # over y, an odd number
MESH = (128, 12)  # of the solver


def looked_up(data, start, y, angle):
    """The three splines w, k, A of `pad_table` at y and theta; linear in y beyond the nodes."""
    last = int(data[start]) - 2
    around = int(data[start + 2])
    position = (y + TOP) * data[start + 1]
    i, t = cell(max(position, 0.0), last)
    z = (angle + math.pi) * data[start + 3]
    j = min(max(int(z), 0), around - 1)
    p, w = splines(t), splines(z - j)
    below = min(0.5 * position, 0.0)
    above = max(0.5 * (position - (last + 1.0)), 0.0)
    p = p[0] - below, p[1] - above, p[2] + below, p[3] + above
    line = PARTS * (around + 3)
    at = start + HEAD + i * line + PARTS * j
    return (
        patch(data, at, line, PARTS, p, w),
        patch(data, at + 1, line, PARTS, p, w),
        patch(data, at + 2, line, PARTS, p, w),
    )
