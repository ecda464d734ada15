"""Frequency response of bristle friction: linearised, and of the full law at several amplitudes.

The angle is x = w_0 t + A sin(omega t), so the rate w_0 + A omega cos(omega t). G = G' + i G'' [N
m/rad] is the torque's first harmonic over the angle's. The storage moment G' is a stiffness, the
loss moment G'' is what is
dissipated: pi A^2 G'' a cycle. At rest (w_0 = 0) the bristles' rate is w - k z with k of first
order, so

    G(i omega) = sigma0 + i omega (sigma1 + sigma2),

a spring and a damper: no sliding, whatever the frequency. Sliding steadily at w_0 with T(w) the
steady torque,

    G(i omega) = i omega [ (w_0 T' / T) (sigma0 + i omega sigma1) / (i omega + k) + sigma2 ],
    k = w_0 sigma0 / T,

which for slow oscillations is the damping T' + sigma2 of the steady curve, negative where it falls.
The term with T' takes sigma0, sigma1 and sigma2 as constant.

Bristles break away where A comes to T / sigma0: the linear model holds for A much smaller. Sources:
Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419
(linearisation at rest); Pfitzer et al., Lubricants 13 (2025) 436, appendix A (its numbers were not
at hand).
"""

import math
from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np

from clearance.identify.lugre_kernel import DAMPING, STIFFNESS, TORQUE, VISCOUS
from clearance.identify.models import LuGre, Values

CYCLE = 2000  # steps of a cycle: the first harmonic of the law to some 1e-6
CYCLES = 4  # of which the last one counts
# angles of break-away that a sliding joint turns before the oscillation is looked at
SETTLED = 30.0
NUDGE = 1e-6  # relative step of the slope of the steady torque


def linear(
    model: LuGre, values: Values, frequencies: Sequence[float], *, axis: int = 2, rate: float = 0.0
) -> np.ndarray:
    """G (n,) [N m/rad] of the linearised law about an axis at frequencies [Hz]; rate: of steady
    sliding [rad/s].

    Raises ValueError for a model without bristles.
    """
    if model.static:
        raise ValueError(f"linear: this {model.name} is static, it has no bristles")
    at = np.array([abs(rate) * (1.0 - NUDGE), abs(rate), abs(rate) * (1.0 + NUDGE)])
    functions = model.functions(values, at)[axis]
    torque, stiffness, damping, viscous = functions[[TORQUE, STIFFNESS, DAMPING, VISCOUS], 1]
    s = 2j * math.pi * np.asarray(frequencies, float)
    if rate == 0.0:
        return stiffness + s * (damping + viscous)
    slope = (functions[TORQUE, 2] - functions[TORQUE, 0]) / (at[2] - at[0])
    k = abs(rate) * stiffness / torque
    bristles = abs(rate) * slope / torque * (stiffness + s * damping) / (s + k)
    return s * (bristles + viscous)


def whole(
    model: LuGre,
    values: Values,
    amplitude: float,
    frequencies: Sequence[float],
    *,
    axis: int = 2,
    rate: float = 0.0,
) -> np.ndarray:
    """G (n,) [N m/rad] of the full law: first harmonic of its torque at an amplitude [rad] of the
    angle.
    """
    return np.array([_harmonic(model, values, amplitude, f, axis, rate) for f in frequencies])


def _harmonic(
    model: LuGre, values: Values, amplitude: float, frequency: float, axis: int, rate: float
) -> complex:
    """First harmonic of the last cycle, once the bristles have forgotten how they started."""
    functions = model.functions(values, np.array([abs(rate)]))[axis, :, 0]
    reach = functions[TORQUE] / functions[STIFFNESS]
    turned = SETTLED * reach / (abs(rate) + 4.0 * amplitude * frequency)
    cycles = min(max(CYCLES, math.ceil(turned * frequency)), 100 * CYCLES)
    if not rate and amplitude < reach:
        cycles = CYCLES
    step = 1.0 / (frequency * CYCLE)
    phase = 2.0 * math.pi * np.arange(cycles * CYCLE + 1) / CYCLE
    rates = np.zeros((phase.size, 3))
    rates[:, axis] = rate + 2.0 * math.pi * frequency * amplitude * np.cos(phase)
    trial = SimpleNamespace(
        name="sine", samples=len(rates), rate=rates, step=step, facts={"preload": model.preload}
    )
    torque = model.torque(values, trial)[-CYCLE - 1 : -1, axis]
    last = phase[-CYCLE - 1 : -1]
    return complex(np.mean(torque * np.sin(last)), np.mean(torque * np.cos(last))) * 2.0 / amplitude
