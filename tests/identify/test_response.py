"""Linearised bristles: transfer functions as limits of small amplitude, and Dahl's loop beyond
them.
"""

import math

import numpy as np
import pytest
from clearance.paper_figures import ball_joint_response as response

from clearance.identify.models import lugre1d, lugre3d

VALUES = {
    f"{g}_{n}": v
    for g in ("tilt", "spin")
    for n, v in {
        "kinetic": 2.0,
        "static": 2.6,
        "stribeck_speed": 0.06,
        "stiffness": 1000.0,
        "damping": 1.5,
        "viscous": 0.1,
    }.items()
}
REACH = 2.6e-3  # rad, static torque over stiffness
FREQUENCIES = np.array([0.5, 5.0, 50.0])


@pytest.mark.parametrize("make", [lugre1d, lugre3d])
def test_at_rest_it_is_spring_and_damper_in_the_limit_of_small_amplitude(make):
    """G - G_0 is of first order in the amplitude: a tenth of it at a tenth, within 1 %; 1e-4 of
    |G_0| at 1e-4 reach.
    """
    model = make()
    wanted = response.linear(model, VALUES, FREQUENCIES)
    np.testing.assert_allclose(wanted, 1000.0 + 2j * math.pi * FREQUENCIES * 1.6, rtol=1e-12)
    off = [
        abs(response.whole(model, VALUES, a * REACH, FREQUENCIES) - wanted) for a in (1e-3, 1e-4)
    ]
    np.testing.assert_allclose(off[0] / off[1], 10.0, rtol=0.01)
    assert (off[1] < 1e-4 * abs(wanted)).all()


@pytest.mark.parametrize("rate", [0.02, -0.06, 0.5])
def test_sliding_steadily_it_is_the_transfer_function(rate):
    """Amplitudes whose rate is 1e-3 of the sliding one: 1e-3 of |G|, and a tenth of that at a tenth
    or 1e-5.
    """
    model = lugre1d()
    wanted = response.linear(model, VALUES, FREQUENCIES, rate=rate)
    for share, close in ((1e-2, 1e-2), (1e-3, 1e-3)):
        for frequency, there in zip(FREQUENCIES, wanted, strict=True):
            amplitude = share * abs(rate) / (2.0 * math.pi * frequency)
            (actual,) = response.whole(model, VALUES, amplitude, [frequency], rate=rate)
            assert abs(actual - there) < close * abs(there)


def test_slow_oscillations_see_the_slope_of_the_steady_curve():
    """T' + sigma2 of the Stribeck curve in closed form, negative where it falls: 1e-4."""
    rate, slow = 0.06, 1e-3
    slope = -2.0 * 0.6 * rate / 0.06**2 * math.exp(-1.0) + 0.1
    (actual,) = response.linear(lugre1d(), VALUES, [slow], rate=rate)
    assert actual.imag / (2.0 * math.pi * slow) == pytest.approx(slope, rel=1e-4)
    assert slope < 0.0


def test_large_amplitudes_are_sliding():
    """Constant level, no damping: |G''| tends to 4 T / (pi A), as of Coulomb; G' falls as A^(-3/2),
    5 %.
    """
    values = VALUES | {"spin_static": 2.0, "spin_damping": 1e-3, "spin_viscous": 1e-3}
    reach = 2e-3
    actual = [response.whole(lugre1d(), values, a * reach, [0.1])[0] for a in (10.0, 100.0)]
    for amplitude, g in zip((10.0, 100.0), actual, strict=True):
        assert g.imag * amplitude * reach == pytest.approx(4.0 * 2.0 / math.pi, rel=3.0 / amplitude)
    assert actual[1].real / actual[0].real == pytest.approx(10.0**-1.5, rel=0.05)


def test_dissipation_is_that_of_the_loop():
    """pi A^2 G'' is the closed integral of the torque over the angle, Dahl's loop included:
    1e-6.
    """
    values = VALUES | {"spin_static": 2.0, "spin_damping": 1e-3, "spin_viscous": 1e-3}
    amplitude, frequency = 3e-3, 0.5
    (actual,) = response.whole(lugre1d(), values, amplitude, [frequency])
    a, sigma, level = amplitude, 1000.0, 2.0
    turn = level * math.tanh(sigma * a / level)  # torque at the turn of a settled loop
    work = (
        2.0
        * level
        * (2.0 * a - (level + turn) / sigma * (1.0 - math.exp(-2.0 * sigma * a / level)))
    )
    viscous = math.pi * a * a * 2.0 * math.pi * frequency * 1e-3
    assert math.pi * a * a * actual.imag == pytest.approx(work + viscous, rel=1e-3)


def test_static_models_have_no_bristles():
    """A transfer function of a static model is refused."""
    with pytest.raises(ValueError, match="has no bristles"):
        response.linear(lugre1d(static=True), {}, [1.0])
