"""Compiled LuGre friction of a ball joint, and its sensitivities carried along in the same loop.

The frame is the housing's (x and y tilt, z spins the stud), with the relative angular velocity w
[rad/s] and the bristles' deflection z [rad]. With M = diag(T_x, T_y, T_z)(|w|) [N m]:

    z' = w - |M w| M^-2 S0 z,   torque = S0 z + S1 z' + S2 w.

Bristle torques fill the ellipsoid y' M^-2 y <= 1. The one that dissipates most, y = M^2 w / |M w|,
is where z comes to rest. Uncoupled, each axis has the law of its own rate, |M
w| = T_i(|w_i|) |w_i|. Given w, the axes do not see each other's z, and over a step of constant w
each is solved exactly with k = |M w| sigma0 / T^2:

    z <- z exp(-k dt) + w (1 - exp(-k dt)) / k,

which no step makes unstable and which, with w taken as the mean over the step, is of second order
in dt.

All functions take `values` as `LuGre.packed` gives them. Sources: Velenis, Tsiotras and
Canudas-de-Wit, 2002 (two axes); Pfitzer et al., Lubricants 13 (2025) 436 (the ball joint); with a
velocity-dependent ellipsoid of our own.
"""

import math
from typing import NamedTuple

import numpy as np

from clearance.machine.store import njit

TORQUE, STIFFNESS, DAMPING, VISCOUS = range(4)  # functions of the speed that an axis has
# numbers behind the parameters: stiffness and damping of a static law; two that empty slopes fall
# on
PADDING = 4
ENDLESS = 1e150  # s, step after which bristles are at rest: what a static law takes
FASTEST = 1e100  # rad/s, beyond which squares of rates are taken of smaller numbers
# rad/s, around which a network's input log(1 + |w| / UNIT) goes over from linear to logarithmic
UNIT = 0.01
TINY, SMALL = 1e-8, 1e-2  # k dt below which the step, and its slope, are written as series


class Layout(NamedTuple):
    """Places of a model's parameters in `values`.

    places: of the first one of each axis and function, (3, 4). knots [rad/s] of the tables over the
        speed, none for a Stribeck law; exponent d of that law; coupled: by the ellipsoid; static:
        no bristles, the torque of steady sliding;
    hidden: units of a network over the speed, 0 for none; their rates and steepnesses stand before
        an axis' torque.
    """

    places: np.ndarray
    knots: np.ndarray
    exponent: float
    coupled: bool
    static: bool
    hidden: int = 0


def compiled(function):
    """Nothing in here allocates: arrays need no counting."""
    return njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)(function)


# --- functions of the speed
@compiled
def cell(knots, speed):
    """The cell of the table that a speed lies in and its share of it; beyond the ends the table
    goes on level.
    """
    m = 0
    while m < knots.size - 2 and speed > knots[m + 1]:
        m += 1
    share = (speed - knots[m]) / (knots[m + 1] - knots[m])
    return m, min(max(share, 0.0), 1.0)


@compiled
def network(layout, values, axis, function, speed):
    """A function of an axis as a network: level exp(sum_k weight_k tanh(steepness_k (s - s_k))),
    s = log(1 + |w| / u).

    s_k is that of the rate of unit k; the units are shared by the functions of an axis. Positive
    and bounded.
    """
    n, first, s, total = layout.hidden, layout.places[axis, function], math.log1p(speed / UNIT), 0.0
    inner = layout.places[axis, TORQUE] - 2 * n
    for k in range(n):
        away = s - math.log1p(values[inner + k] / UNIT)
        total += values[first + k] * math.tanh(values[inner + n + k] * away)
    return values[first + n] * math.exp(total)


@compiled
def envelope(layout, values, axis, speed):
    """T [N m] of an axis at a speed [rad/s]; where its three parameters stand and its slopes by
    them; the speed.
    """
    first = layout.places[axis, TORQUE]
    if layout.hidden > 0:
        return network(layout, values, axis, TORQUE, speed), first, 0.0, 0.0, 0.0, speed
    if layout.knots.size > 0:
        m, share = cell(layout.knots, speed)
        first += m
        return (
            (1.0 - share) * values[first] + share * values[first + 1],
            first,
            1.0 - share,
            share,
            0.0,
            speed,
        )
    kinetic, static, scale = values[first], values[first + 1], values[first + 2]
    ratio = speed / scale
    power = ratio * ratio if layout.exponent == 2.0 else ratio**layout.exponent
    power = min(power, 1e3)
    fall = math.exp(-power)
    drop = (static - kinetic) * fall
    return kinetic + drop, first, 1.0 - fall, fall, drop * layout.exponent * power / scale, speed


@compiled
def tabulated(layout, values, axis, function, speed):
    """Stiffness, damping or viscosity of an axis at a speed; where its two parameters stand and its
    slopes by them.
    """
    first = layout.places[axis, function]
    if layout.hidden > 0 and function != VISCOUS and not layout.static:
        return network(layout, values, axis, function, speed), first, 0.0, 0.0
    if layout.knots.size > 0 and function != VISCOUS and not layout.static:
        m, share = cell(layout.knots, speed)
        first += m
        return (1.0 - share) * values[first] + share * values[first + 1], first, 1.0 - share, share
    return values[first], first, 1.0, 0.0


@compiled
def norm(x, y, z):
    """Length of a vector, also where its square is beyond all numbers."""
    most = max(abs(x), abs(y), abs(z))
    if most < FASTEST:
        return math.sqrt(x * x + y * y + z * z)
    x, y, z = x / most, y / most, z / most
    return most * math.sqrt(x * x + y * y + z * z)


@compiled
def envelopes(layout, values, w):
    """The envelopes of the three axes at a rate."""
    x, y, z = abs(w[0]), abs(w[1]), abs(w[2])
    if layout.coupled:
        x = y = z = norm(x, y, z)
    first = envelope(layout, values, 0, x)
    alike = x == y and layout.places[0, 0] == layout.places[1, 0]
    return first, first if alike else envelope(layout, values, 1, y), envelope(layout, values, 2, z)


@compiled
def strength(layout, axis, w, e):
    """|M w| [W], of one axis where the axes are not coupled."""
    if not layout.coupled:
        return e[axis][0] * abs(w[axis])
    return norm(e[0][0] * w[0], e[1][0] * w[1], e[2][0] * w[2])


@compiled
def coefficients(layout, values, axis, w, e):
    """k [1/s], sigma0 [N m/rad], sigma1, sigma2 [N m s/rad] of an axis."""
    torque, speed = e[axis][0], e[axis][5]
    stiffness = tabulated(layout, values, axis, STIFFNESS, speed)[0]
    damping = tabulated(layout, values, axis, DAMPING, speed)[0]
    viscous = tabulated(layout, values, axis, VISCOUS, speed)[0]
    return strength(layout, axis, w, e) * stiffness / (torque * torque), stiffness, damping, viscous


@compiled
def functions(layout, values, speeds, out):
    """T, sigma0, sigma1, sigma2 of each axis at each speed, into `found` (3, 4, speeds)."""
    for axis in range(3):
        for n in range(speeds.size):
            out[axis, TORQUE, n] = envelope(layout, values, axis, speeds[n])[0]
            for function in range(STIFFNESS, VISCOUS + 1):
                out[axis, function, n] = tabulated(layout, values, axis, function, speeds[n])[0]


# --- bristles
@compiled
def relaxed(z, w, k, dt):
    """Deflection [rad] after a step of constant rate."""
    x = k * dt
    gone = -math.expm1(-x)
    return z * (1.0 - gone) + w * (gone / k if x > TINY else dt * (1.0 - 0.5 * x))


@compiled
def relaxed_slopes(z, w, k, dt):
    """Deflection after a step of constant rate, and its slopes by k and by the deflection
    before.
    """
    x = k * dt
    gone = -math.expm1(-x)
    remaining = 1.0 - gone
    if x < SMALL:
        by_k = -dt * dt * (0.5 - x * (1.0 / 3.0 - x * (0.125 - x * (1.0 / 30.0 - x / 144.0))))
    else:
        by_k = (dt * remaining - gone / k) / k
    reach = gone / k if x > TINY else dt * (1.0 - 0.5 * x)
    return z * remaining + w * reach, w * by_k - dt * remaining * z, remaining


@compiled
def step(layout, values, state, rate, dt, torque):
    """One step dt [s] of constant rate (3,) [rad/s]: moves `state` (3,) [rad] and writes its end's
    `torque` (3,) [N m].

    state: deflections of the bristles. torque: what keeps the rate up. Exact for any dt; compiled
        code may call it.
    """
    w = (rate[0], rate[1], rate[2])
    e = envelopes(layout, values, w)
    for i in range(3):
        k, stiffness, damping, viscous = coefficients(layout, values, i, w, e)
        z = relaxed(state[i], w[i], k, ENDLESS if layout.static else dt)
        state[i] = z
        torque[i] = stiffness * z + damping * (w[i] - k * z) + viscous * w[i]


@compiled
def curve_step(layout, values, state, rate, dt, torque):
    """Torque (3,) [N m] of a characteristic curve at a rate (3,); called as `step` is, `state` is
    empty.
    """
    for i in range(3):
        m, share = cell(layout.knots, abs(rate[i]))
        first = layout.places[i, TORQUE] + m
        before = values[first - 1] if m > 0 else 0.0
        torque[i] = math.copysign(1.0, rate[i]) * ((1.0 - share) * before + share * values[first])


@compiled
def between(layout, rate, n):
    """The rate that bristles see from sample n - 1 to n: the mean, and the last one where they have
    no memory.
    """
    if layout.static:
        return rate[n, 0], rate[n, 1], rate[n, 2]
    return (
        0.5 * (rate[n - 1, 0] + rate[n, 0]),
        0.5 * (rate[n - 1, 1] + rate[n, 1]),
        0.5 * (rate[n - 1, 2] + rate[n, 2]),
    )


@compiled
def torques(layout, values, rate, dt, state, torque):
    """Torque (n, 3) [N m] at samples of the rate (n, 3), a step apart; moves the deflections
    `state` (3,).
    """
    step_length = ENDLESS if layout.static else dt
    for n in range(rate.shape[0]):
        if n > 0 or layout.static:
            w = between(layout, rate, n)
            e = envelopes(layout, values, w)
            for i in range(3):
                if w[i] != 0.0 or state[i] != 0.0:
                    k = coefficients(layout, values, i, w, e)[0]
                    state[i] = relaxed(state[i], w[i], k, step_length)
        w = (rate[n, 0], rate[n, 1], rate[n, 2])
        e = envelopes(layout, values, w)
        for i in range(3):
            k, stiffness, damping, viscous = coefficients(layout, values, i, w, e)
            torque[n, i] = stiffness * state[i] + damping * (w[i] - k * state[i]) + viscous * w[i]


# --- sensitivities
@compiled
def add_network(layout, values, axis, function, speed, factor, row):
    """Adds a multiple of a network's slopes by the parameters."""
    n, first, s = layout.hidden, layout.places[axis, function], math.log1p(speed / UNIT)
    inner = layout.places[axis, TORQUE] - 2 * n
    factor *= network(layout, values, axis, function, speed)
    row[first + n] += factor / values[first + n]
    for k in range(n):
        rate, steepness = values[inner + k], values[inner + n + k]
        away = s - math.log1p(rate / UNIT)
        bent = math.tanh(steepness * away)
        row[first + k] += factor * bent
        slope = factor * values[first + k] * (1.0 - bent * bent)
        row[inner + k] -= slope * steepness / (UNIT + rate)
        row[inner + n + k] += slope * away


@compiled
def add_envelope(layout, values, axis, e, factor, row):
    """Adds a multiple of an envelope's slopes by the parameters."""
    if layout.hidden > 0:
        add_network(layout, values, axis, TORQUE, e[5], factor, row)
        return
    row[e[1]] += factor * e[2]
    row[e[1] + 1] += factor * e[3]
    row[e[1] + 2] += factor * e[4]


@compiled
def add_tabulated(layout, values, axis, function, speed, factor, row):
    """Adds a multiple of the slopes of stiffness, damping or viscosity."""
    if layout.hidden > 0 and function != VISCOUS and not layout.static:
        add_network(layout, values, axis, function, speed, factor, row)
        return
    value = tabulated(layout, values, axis, function, speed)
    row[value[1]] += factor * value[2]
    row[value[1] + 1] += factor * value[3]


@compiled
def add_relaxation(layout, values, axis, w, e, k, stiffness, factor, row):
    """Adds a multiple of the slopes of k = |M w| sigma0 / T^2."""
    if k == 0.0:
        return
    factor *= k
    add_tabulated(layout, values, axis, STIFFNESS, e[axis][5], factor / stiffness, row)
    if not layout.coupled:
        add_envelope(layout, values, axis, e[axis], -factor / e[axis][0], row)
        return
    add_envelope(layout, values, axis, e[axis], -2.0 * factor / e[axis][0], row)
    total = strength(layout, axis, w, e)
    for j in range(3):
        if w[j] != 0.0:
            share = e[j][0] * w[j] / total
            add_envelope(layout, values, j, e[j], factor * share * share / e[j][0], row)


@compiled
def sensitivities(layout, values, rate, dt, axes, state, moved, torque, slopes):
    """Torque (n, axes) [N m] of axes at samples of the rate (n, 3), and its slopes by the values,
    (n, axes, values).

    state (3,) [rad] moves, and so does moved (3, values), its slopes.
    """
    step_length = ENDLESS if layout.static else dt
    for n in range(rate.shape[0]):
        if n > 0 or layout.static:
            w = between(layout, rate, n)
            e = envelopes(layout, values, w)
            for i in axes:
                if w[i] != 0.0 or state[i] != 0.0:
                    k, stiffness, _, _ = coefficients(layout, values, i, w, e)
                    state[i], by_k, remaining = relaxed_slopes(state[i], w[i], k, step_length)
                    for p in range(moved.shape[1]):
                        moved[i, p] *= remaining
                    add_relaxation(layout, values, i, w, e, k, stiffness, by_k, moved[i])
        w = (rate[n, 0], rate[n, 1], rate[n, 2])
        e = envelopes(layout, values, w)
        for c in range(axes.size):
            i, row = axes[c], slopes[n, c]
            k, stiffness, damping, viscous = coefficients(layout, values, i, w, e)
            z, follows = state[i], stiffness - damping * k
            torque[n, c] = stiffness * z + damping * (w[i] - k * z) + viscous * w[i]
            for p in range(moved.shape[1]):
                row[p] = follows * moved[i, p]
            add_relaxation(layout, values, i, w, e, k, stiffness, -damping * z, row)
            add_tabulated(layout, values, i, STIFFNESS, e[i][5], z, row)
            add_tabulated(layout, values, i, DAMPING, e[i][5], w[i] - k * z, row)
            add_tabulated(layout, values, i, VISCOUS, e[i][5], w[i], row)
