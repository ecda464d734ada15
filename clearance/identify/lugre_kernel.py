"""LuGre friction of a ball joint, as plain functions for the trace.

The frame is the housing's (x and y tilt, z spins the stud), with the relative angular velocity w
[rad/s] and the bristles' deflection z [rad]. With M = diag(T_x, T_y, T_z)(|w|) [N m]:

    z' = w - |M w| M^-2 S0 z,   torque = S0 z + S1 z' + S2 w.

Bristle torques fill the ellipsoid y' M^-2 y <= 1. The one that dissipates most, y = M^2 w / |M w|,
is where z comes to rest. Uncoupled, each axis has the law of its own rate, |M
w| = T_i(|w_i|) |w_i|. Given w, the axes do not see each other's z, and z' is linear in it: the
exponential step of identify/axis_kernel.py is exact. No step makes it unstable, and with w taken as
the mean over the step it is of second order in dt.

Numbers of a group of parameters (tilt, spin): of the network's units, of T, sigma0, sigma1 and
sigma2, and the exponent of the load. Behind all groups comes the logarithm of the load over its
reference. Sources: Velenis, Tsiotras and Canudas-de-Wit, 2002 (two axes); Pfitzer et al.,
Lubricants 13 (2025) 436 (the ball joint); with a velocity-dependent ellipsoid of our own.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from clearance.identify.axis_kernel import Layout, Leaves

TORQUE, STIFFNESS, DAMPING, VISCOUS = range(4)  # functions of the speed that an axis has
FASTEST = 1e100  # rad/s, beyond which squares of rates are taken of smaller numbers
# rad/s, around which a network's input log(1 + |w| / UNIT) goes over from linear to logarithmic
UNIT = 0.01


def norm(row):
    """Length of a vector of sizes, also where its square is beyond all numbers."""
    most, total = max(row), 0.0
    if most == 0.0:
        return 0.0
    scale = most if most >= FASTEST else 1.0
    for x in row:
        total += (x / scale) * (x / scale)
    return scale * math.sqrt(total)


def relaxation(pull, torque, stiffness):
    """k [1/s]."""
    return pull * stiffness / (torque * torque) if pull > 0.0 else 0.0


def stribeck(speed, kinetic, static, scale, exponent):
    """T = T_c + (T_s - T_c) exp(-(|w| / w_s)^exponent) [N m]."""
    ratio = speed / scale
    power = ratio * ratio if exponent == 2.0 else ratio**exponent
    return kinetic + (static - kinetic) * math.exp(-min(power, 1e3))


class Form(NamedTuple):
    """All that decides the functions of a model but for its numbers.

    groups: of the three axes; widths: of the tuples of numbers, of the groups and of what follows.
    """

    coupled: bool
    knots: tuple[float, ...]
    network: int
    exponent: float
    static: bool
    load: str
    groups: tuple[int, int, int]
    widths: tuple[int, ...]

    @property
    def viscous(self) -> int:
        """Place of sigma2 among the numbers of a group."""
        return -2 if self.load == "power" else -1


def by_speed(form: Form) -> Callable:
    """Function of a speed and of the numbers of a group: T [N m], sigma0 [N m/rad] and sigma1."""
    units, exponent, static = form.network, form.exponent, form.static
    wide = units + 1 if units else len(form.knots)
    first, second = 2 * units, 2 * units + (wide or 3)
    third = second + (wide or 1)
    cells = _cells(form.knots)
    count = len(cells)

    def varying(speed, numbers, at):
        """Piecewise linear over the knots and level beyond. Of a network level exp(sum_k weight_k
        tanh(steepness_k (s - s_k))), s = log(1 + |w| / u): positive and bounded.
        """
        total = 0.0 if units else numbers[at]
        for k in range(count):
            low, scale = cells[k]
            share = min(max((speed - low) * scale, 0.0), 1.0)
            total += (numbers[at + k + 1] - numbers[at + k]) * share
        for k in range(units):
            away = math.log1p(speed / UNIT) - math.log1p(numbers[k] / UNIT)
            total += numbers[at + k] * math.tanh(numbers[units + k] * away)
        return numbers[at + units] * math.exp(total) if units else total

    def functions(speed, numbers):
        if wide:
            torque = varying(speed, numbers, first)
        else:
            torque = stribeck(speed, numbers[0], numbers[1], numbers[2], exponent)
        if static:
            return torque, 1.0, 0.0  # it comes to rest with any
        return torque, varying(speed, numbers, second), varying(speed, numbers, third)

    return functions


def _cells(knots: tuple[float, ...]) -> tuple[tuple[float, float], ...]:
    """Begin and reciprocal of the width of each cell between knots."""
    return tuple((a, 1.0 / (b - a)) for a, b in pairwise(knots))


@lru_cache(maxsize=64)
def lugre(form: Form, axes: tuple[int, ...]) -> Layout:
    """Kernels of the axes that move."""
    leaves, functions = Leaves(axes, form.widths), by_speed(form)
    call, z, w = leaves.call, leaves.z, leaves.w
    numbers = [leaves.numbers[form.groups[i]] for i in axes]

    def coupled(row):
        return call(norm, tuple(row)) * len(row) if form.coupled and len(row) > 1 else row

    sizes = [leaves.trace.function("fabs", x) for x in w]
    f = [call(functions, *of_axis) for of_axis in zip(coupled(sizes), numbers, strict=True)]
    pulls = coupled([x * size for (x, *_), size in zip(f, sizes, strict=True)])
    k = [call(relaxation, x, *of_axis[:2])[0] for x, of_axis in zip(pulls, f, strict=True)]
    rates = [w[i] - k[i] * z[i] for i in range(len(axes))]
    viscous = [row[form.viscous] for row in numbers]
    torques = [f[i][1] * z[i] + f[i][2] * rates[i] + viscous[i] * w[i] for i in range(len(axes))]
    if form.load != "fixed":
        powers = [row[-1] if form.load == "power" else 1.0 for row in numbers]
        logarithm = leaves.numbers[-1][-1]
        torques = [
            m * leaves.trace.function("exp", p * logarithm)
            for m, p in zip(torques, powers, strict=True)
        ]
    return leaves.layout([*rates, *torques], static=form.static)


@lru_cache(maxsize=64)
def curve(knots: tuple[float, ...], groups: tuple[int, ...], axes: tuple[int, ...]) -> Layout:
    """Kernels of a characteristic curve: zero at rest, the numbers at the knots, linear between."""
    cells = _cells((0.0, *knots))
    count = len(cells)

    def pull(w, numbers):
        total, before = 0.0, 0.0
        for k in range(count):
            low, scale = cells[k]
            total += (numbers[k] - before) * min(max((abs(w) - low) * scale, 0.0), 1.0)
            before = numbers[k]
        return math.copysign(1.0, w) * total

    leaves = Leaves(axes, (count,) * (max(groups) + 1))
    rows = zip(leaves.w, (leaves.numbers[groups[i]] for i in axes), strict=True)
    return leaves.layout([leaves.call(pull, *row)[0] for row in rows])
