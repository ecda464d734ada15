"""Looks films up in tables of numbers: cubic B-splines over a grid, as plain functions.

film/table.py makes the numbers of bearings, film/tabulated.py has the laws that read them.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

#: numbers before the coefficients: A; nodes over y and alpha', cells per y, per alpha', nodes over
#: tau. Then values of A; where the side flow begins; the same four of the side flow, over y and
#: alpha
HEAD = 11
TOP = 6.2  # largest y of the nodes
ALONE = (1.0,)  # weights over tau of a table without it


@dataclass(frozen=True)
class Tabulated:
    """Numbers that a film law reads from a table, and how far they are from the film they stand
    for.

    Each kind has the fields of its errors and its `error`, the largest of the force where the film
    carries. `stronger(factor)` are its numbers with all forces and the friction of the film times a
    factor.
    """

    numbers: "np.ndarray"

    @property
    def errors(self) -> tuple[float, ...]:
        return tuple(value for name, value in vars(self).items() if name != "numbers")

    def facts(self) -> dict:
        """Facts of it in the report of a run."""
        return {
            f"film_table_{name}": value for name, value in vars(self).items() if name != "numbers"
        }


def bump_0(t):
    """First of the four cubic B-splines over a cell, t in [0, 1]."""
    u = 1.0 - t
    return u * u * u / 6.0


def bump_1(t):
    return (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0


def splines(t):
    """The four cubic B-splines over a cell."""
    return bump_0(t), bump_1(t), bump_1(1.0 - t), bump_0(1.0 - t)


def cell(position, last):
    """Number of a cell, at most the last, for a place in units of cells; the place inside it."""
    x = min(position, last + 1.0)
    i = min(int(x), last)
    return i, x - i


def row(data, at, step, w):
    """Sum of four coefficients."""
    return (
        data[at] * w[0]
        + data[at + step] * w[1]
        + data[at + 2 * step] * w[2]
        + data[at + 3 * step] * w[3]
    )


def patch(data, at, line, step, p, w):
    """Sum of four rows of coefficients."""
    return (
        p[0] * row(data, at, step, w)
        + p[1] * row(data, at + line, step, w)
        + p[2] * row(data, at + 2 * line, step, w)
        + p[3] * row(data, at + 3 * line, step, w)
    )


def block(data, at, plane, line, step, p, w, q):
    """Sum of patches of coefficients, one a layer."""
    total = 0.0
    for weight in q:
        total += weight * patch(data, at, plane, line, p, w)
        at += step
    return total


def continued(p, y, per_y, last):
    """Splines over y of a force, which goes on beyond the last node."""
    p1, p3, top = p[1], p[3], last + 1.0
    if y * per_y > top:
        further = (1.0 - math.exp(0.5 * (top / per_y - y))) * per_y
        p1, p3 = p1 - further, p3 + further
    return p[0], p1, p[2], p3


def looked_up(data, start, y, angle, taus=()):
    """A and the three splines (w_r + A cos, w_t - A sin, K) at y = -ln(1 - eps), alpha' in [0, pi]
    and tau in [0, 1].

    taus: of a table with layers over tau, one tau; else none.
    """
    last = int(data[start + 1]) - 2
    per_y = data[start + 2]
    layers = 1
    k = 0
    q = ALONE
    i, t = cell(y * per_y, last)
    j, u = cell(angle * data[start + 3], last)
    size = data[start]
    for tau in taus:
        layers = int(data[start + 4]) + 2
        k, v = cell(tau * (layers - 3.0), layers - 4)
        q = splines(v)
        size = row(data, start + HEAD + k, 1, q)
    p, w = splines(t), splines(u)
    f = continued(p, y, per_y, last)
    line = 3 * layers
    plane = line * (last + 4)
    at = start + HEAD + layers + i * plane + j * line + 3 * k
    return (
        size,
        block(data, at, plane, line, 3, f, w, q),
        block(data, at + 1, plane, line, 3, f, w, q),
        block(data, at + 2, plane, line, 3, p, w, q),
    )


def looked_up_flow(data, start, y, angle, taus=()):
    """The spline of the side flow, q, at y, alpha in [0, pi] and tau, as in `looked_up`."""
    last = int(data[start + 7]) - 2
    layers = 1
    k = 0
    q = ALONE
    i, t = cell(y * data[start + 8], last)
    j, u = cell(angle * data[start + 9], last)
    for tau in taus:
        layers = int(data[start + 10]) + 2
        k, v = cell(tau * (layers - 3.0), layers - 4)
        q = splines(v)
    plane = layers * (last + 4)
    at = start + int(data[start + 6]) + i * plane + j * layers + k
    return block(data, at, plane, layers, 1, splines(t), splines(u), q)
