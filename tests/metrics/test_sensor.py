"""Sensors: their filter beside the frequency response of the analog one."""

import numpy as np
import pytest
from scipy.signal import butter

from clearance.metrics.sensor import filtered
from clearance.values.units import quantity

TURN = 0.1  # s
AMPLITUDES = {1: 1.0, 7: 0.3, 20: 0.05}  # by order


@pytest.mark.parametrize("order", [1, 2, 5])
@pytest.mark.parametrize("corner", [30.0, 300.0, 3000.0, 1e5])
def test_a_filter_is_the_analog_one(order, corner):
    """Settled orders have its gain and phase: within 3e-3 of their amplitudes, for signals bend
    between samples by (2 pi 20 / 720)^2 / 12; also where the corner is near or above their rate.
    """
    time = np.linspace(0.0, 6.0 * TURN, 6 * 720 + 1)
    b, a = butter(order, 2.0 * np.pi * corner, analog=True)
    seen, expected = 5.0, 5.0
    for n, amplitude in AMPLITUDES.items():
        s = 2j * np.pi * n / TURN
        wave = amplitude * np.exp(s * time)
        seen = seen + wave.imag
        expected = expected + (np.polyval(b, s) / np.polyval(a, s) * wave).imag
    actual = filtered(time, seen, (order, corner))
    bend = sum(m * (2.0 * np.pi * n / 720) ** 2 / 12.0 for n, m in AMPLITUDES.items())
    assert np.abs(actual - expected)[-720:].max() < (1.0 + order) * bend
    assert actual[0] == pytest.approx(5.0)


def test_a_constant_passes_from_the_start():
    """The sensor has seen the first value for long: to rounding of its sections."""
    time = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(filtered(time, np.full(1001, 3.0), (4, 0.5)), 3.0, rtol=1e-8)


def test_g_of_an_acceleration():
    """Beside accelerations it is that of gravity, else a mass."""
    assert quantity("0.5 g", "m/s2") == pytest.approx(4.903325)
    assert quantity("0.5 g", "kg") == 5e-4
