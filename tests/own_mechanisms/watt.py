"""A user's own case file: the Watt six-bar of the tests with a lubricated joint C."""

import clearance as cl
from tests import mechanisms as m


def scene(*, speed: float = 15.0, clearance: float = 1e-4) -> cl.Scene:
    """Watt six-bar.

    speed: crank speed [rad/s]
    clearance: radial clearance of joint C [m]
    """
    return m.watt(m.chooser(m.film, "C", clearance=clearance), speed=speed)
