"""A sensor: its filter, and the noise of its values."""

from collections.abc import Callable

import numpy as np
from scipy.signal import butter, sosfilt

from clearance.values import checks
from clearance.values.units import quantity


def filtered(time: np.ndarray, values: np.ndarray, lowpass: tuple[int, float] | None) -> np.ndarray:
    """Values at even times [s] through a Butterworth filter; lowpass: order and corner [Hz]."""
    if lowpass is None:
        return values
    order, corner = lowpass
    rate = (len(time) - 1) / float(time[-1] - time[0])
    return sosfilt(butter(order, corner, fs=rate, output="sos"), values)


def deviation(
    noise: float | str, span: float, check: Callable[[float], float], units: str | None = None
) -> float:
    """Standard deviation of the error of a value: in SI, or a share of a span ("1%").

    check: of a number in SI; units: that a text must be in. Raises ValueError for a text that is
    neither.
    """
    if isinstance(noise, str) and noise.strip().endswith("%"):
        return checks.share("noise", noise) * span
    return check(quantity(noise, units) if isinstance(noise, str) else noise)
