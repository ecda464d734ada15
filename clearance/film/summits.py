"""Rough surfaces on an elastic liner: asperities and oil press it in together.

    H = y + kappa p_a(H) / c,   y = H_rigid + kappa p / c

y is the gap over c that smooth surfaces would have under the pressure p of the oil. p_a is the
pressure of the asperities at the gap H, that of an asperity law (laws/worn_asperity.py). y grows
with H, so H is a function of y. It stands in a table of even steps: y of its begin, the step, then
H. Between them it is straight. Below the table the summits are flat and H is constant; what lacks
is carried by them. Valid for a liner that yields at each place in proportion to the pressure there.
"""

import math

import numpy as np

from clearance.laws.law import BoundLaw
from clearance.machine.store import njit

COUNT = 4096  # of the table: its straight parts err by 1e-5 of the roughness
FLAT = 1e-6  # gap over c of flat summits: a film has a conductance
NONE = np.zeros(0)
BEGIN, STEP, FIRST = range(3)


def summits_of(law: BoundLaw, roughness: float, liner: float, clearance: float) -> np.ndarray:
    """The table of an asperity law; roughness: composite rms [m]; liner [m/Pa].

    Raises ValueError for a law without a pressure at the local gap.
    """
    from clearance.laws.worn_asperity import MOST, moment_and_slope, row_of

    if law.law.pressure is None:
        raise ValueError(f"asperity {law.law.name}: it has no pressure at the local gap")
    order, factor = law.law.pressure
    row, strength = row_of(order), factor(**law.values)
    summit = law.values["summit_height"]
    top = max(MOST * roughness + summit, roughness)
    gaps = np.linspace(FLAT * clearance, top, 8 * COUNT)
    ratios = (gaps - summit) / roughness
    moments = np.array([moment_and_slope(ratio, row)[0] for ratio in ratios])
    free = (gaps - liner * strength * moments) / clearance
    even = np.linspace(max(free[0], -1.0), free[-1], COUNT)
    return np.concatenate([[even[0], even[1] - even[0]], np.interp(even, free, gaps / clearance)])


@njit(error_model="numpy", forceinline=True, _nrt=False)
def lifted(gap, summits):
    """Gap between rough surfaces by that between smooth ones, and its slope."""
    position = (gap - summits[BEGIN]) / summits[STEP]
    last = summits.size - FIRST - 1
    if position >= last:
        return gap, 1.0
    if position < 0.0:
        return summits[FIRST], 0.0
    k = FIRST + int(position)
    rise = summits[k + 1] - summits[k]
    return summits[k] + (position - math.floor(position)) * rise, rise / summits[STEP]
