"""A sensor: the angle of its mounting, its filter, and the noise of its values."""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.signal import butter, cont2discrete, lfilter, lfilter_zi

from clearance.values import checks
from clearance.values.units import quantity

PASSES = 1e3  # corner over the rate of values, from which a filter changes nothing


def filtered(time: np.ndarray, values: np.ndarray, lowpass: tuple[int, float] | None) -> np.ndarray:
    """Values at even times [s] through an analog Butterworth filter; lowpass: order, corner [Hz].

    Each pole, or pair of them, is exact for a signal that is straight between its values: the
    corner may lie above their rate. Before, the sensor has seen the first value for long.
    Source: Franklin, Powell and Workman, Digital Control (1998), section 6.3, triangle hold.
    """
    if lowpass is None:
        return values
    step = float(time[-1] - time[0]) / (len(time) - 1)
    for b, a, still in _sections(*lowpass, float(f"{step:.12g}")):
        values = lfilter(b, a, values, zi=values[0] * still)[0]
    return values


@lru_cache(maxsize=64)
def _sections(order: int, corner: float, step: float) -> list[tuple[np.ndarray, ...]]:
    """Numerator, denominator and state at rest of each pole or pair; none of a corner that is far
    above the rate of values.
    """
    if not 2.0 * math.pi * corner * step < PASSES:
        return []
    sections = []
    for row in butter(order, 2.0 * math.pi * corner, analog=True, output="sos"):
        poles = np.trim_zeros(row[3:], "f")
        (b,), a, _ = cont2discrete((poles[-1:], poles), step, "foh")  # constants pass
        sections.append((b, a, lfilter_zi(b, a)))
    return sections


def crossed(channel: str) -> tuple[str, float]:
    """The channel across a directed one, and the sign with which a turned sensor has it.

    Raises ValueError for a channel without a direction.
    """
    axis = channel[-1:]
    if axis not in ("x", "y"):
        raise ValueError(f"{channel} has no direction: its sensor has no mounting angle")
    return channel[:-1] + ("y" if axis == "x" else "x"), 1.0 if axis == "x" else -1.0


def turned(record, channel: str, angle: float = 0.0) -> np.ndarray:
    """A channel of a record as a sensor has it that is mounted at an angle [rad] to its axis."""
    values = record.sizes(channel)
    if not angle:
        return values
    across, sign = crossed(channel)
    return math.cos(angle) * values + sign * math.sin(angle) * record.sizes(across)


def deviation(
    noise: float | str, span: float, check: Callable[[float], float], units: str | None = None
) -> float:
    """Standard deviation of the error of a value: in SI, or a share of a span ("1%").

    check: of a number in SI; units: that a text must be in. Raises ValueError for a text that is
    neither.
    """
    if isinstance(noise, str) and noise.strip().endswith("%"):
        return checks.share("noise", noise) * span
    return check(quantity(noise, units))
