"""Oil film between a flat pad and a flat wall: the faces of a block in its guide.

The gap is h = h0 + m x over x in [-a, a], with x along the wall from the middle of the pad. The pad
slides with U over the wall. A pad law returns the load W [N] and the moment M [N m] of the pressure
about the pad's middle. It also returns the drag on the pad [N], opposed to U. Everything of the
motion is in u = h0' - m U / 2 and w = m': wedge and squeeze are the same thing for a flat pad.
"""

import math

from clearance.laws.law import pad

SERIES = 0.2  # m a / h0 below which the closed forms lose too many digits
TERMS = 12
STEEPEST = (
    1.0 - 1e-9
)  # m a / h0 at which an edge touches, nearly: trial states beyond it stay finite

#: coefficients of even powers of tau, see `full_pad`
_ODD = [1.0 / (2 * k + 1) for k in range(TERMS + 4)]  # of artanh(tau) / tau
_SQUARE = [sum(_ODD[i] * _ODD[n - i] for i in range(n + 1)) for n in range(TERMS + 4)]


def _of_square(n: int) -> float:
    """Coefficient of tau^(2 n) in ((1 - tau^2) artanh(tau) / tau)^2."""
    parts = ((0, 1.0), (1, -2.0), (2, 1.0))
    return sum(factor * _SQUARE[n - k] for k, factor in parts if n >= k)


LEVEL = tuple(3.0 * _ODD[k + 1] for k in range(TERMS))
MIXED = tuple(1.5 * (_ODD[k + 1] - 3.0 * _ODD[k + 2]) for k in range(TERMS))
TURNING = tuple(
    0.75 * (8.0 * _ODD[k + 2] - 4.0 * _ODD[k + 1] - _of_square(k + 2)) for k in range(TERMS)
)


def horner(square, coefficients):
    """Polynomial with TERMS coefficients of growing powers."""
    total = 0.0
    for k in range(TERMS - 1, -1, -1):
        total = total * square + coefficients[k]
    return total


@pad
def full_pad(gap, slope, gap_rate, slope_rate, speed, face):
    """Full film of a wide pad, also under suction [N, N m, N]; tau = m a / h0, T = artanh(tau).

    W = -mu B (A11 u + A12 w),   M = -mu B (A12 u + A22 w)
    drag = mu B U 2 a T / (h0 tau) + m W / 2

    A11 = (8 a^3 / h0^3) 3 (T - tau) / tau^3
    A12 = (8 a^4 / h0^3) (3 / 2) (3 - (3 - tau^2) T / tau) / tau^3
    A22 = (8 a^5 / h0^3) (3 / 4) (-7 + 4 (2 - tau^2) T / tau - ((1 - tau^2) T / tau)^2) / tau^4

    gap h0 [m], slope m, their rates [m/s, 1/s], speed U [m/s]; face: half length a, width B [m],
    viscosity mu [Pa s]. The power taken out, mu B (A11 u^2 + 2 A12 u w + A22 w^2 + U^2 2 a T / (h0
    tau)), is never negative. Valid for B >> 2 a and without cavitation. An edge that touches meets
    a force of the order of log(1 / gap) only. Source: Reynolds' equation between flat surfaces,
    integrated twice; see Pinkus and Sternlicht (1961), chapter 3.
    """
    a = face.half_length
    tau = min(max(slope * a / gap, -STEEPEST), STEEPEST)
    square = tau * tau
    if abs(tau) < SERIES:
        level = horner(square, LEVEL)
        turning = horner(square, TURNING)
        mixed = tau * horner(square, MIXED)
        ratio = 1.0 + square * horner(square, LEVEL) / 3.0
    else:
        ratio = 0.5 * math.log((1.0 + tau) / (1.0 - tau)) / tau
        level = 3.0 * (ratio - 1.0) / square
        mixed = 1.5 * (3.0 - (3.0 - square) * ratio) / (tau * square)
        turning = (
            0.75
            * (-7.0 + 4.0 * (2.0 - square) * ratio - ((1.0 - square) * ratio) ** 2)
            / (square * square)
        )
    scale = 8.0 * face.viscosity * face.width * a**3 / gap**3
    u = gap_rate - 0.5 * slope * speed
    w = slope_rate * a
    load = -scale * (level * u + mixed * w)
    moment = -scale * a * (mixed * u + turning * w)
    drag = 2.0 * face.viscosity * face.width * a * ratio / gap * speed + 0.5 * slope * load
    return load, moment, drag
