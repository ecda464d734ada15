"""Laws and motions a user writes in a file of their own reach the kernel without registration."""

import math

import numpy as np
import pytest

import clearance as cl
from tests import mechanisms as m

STIFFENING = 2.0


def saturation(x, limit):
    if x > limit:
        return limit
    return x


@cl.contact
def stiffening(penetration, penetration_rate, impact_speed, stiffness, limit):
    """A law with a helper, a number, a loop and branches."""
    if penetration <= 0.0:
        return 0.0
    total = 0.0
    for power in range(1, 4):
        total += stiffness * (penetration / limit) ** power / STIFFENING
    return total + stiffness * saturation(penetration, limit) / limit


@cl.signal
def ramp(time, amplitude, period):
    """Smooth start, then constant speed."""
    if time < period:
        return amplitude * (time - period / math.pi * math.sin(math.pi * time / period))
    return amplitude * time


@cl.signal
def gust(time, force):
    return force * math.sin(10.0 * time) ** 2


@cl.effort
def motor(time, position, rate, stall, no_load):
    return stall * (1.0 - rate / no_load)


def test_contact_law():
    body = cl.Body("ball", 0.5, 1e-4)
    law = stiffening(stiffness=100.0, limit=1e-4)
    joint = cl.ClearanceRevolute(cl.ground, body, name="J", radius=0.01, clearance=1e-3, contact=law)
    result = cl.simulate(cl.Scene(joint), until=0.1, rtol=1e-9)
    inside = result.joint("J").gap < 0
    assert inside.any()
    expected = law(-result.joint("J").gap[inside], 0.0, 0.0)
    np.testing.assert_allclose(result.joint("J").contact_force[inside], expected, rtol=1e-9)
    # memoryless and elastic: the ball comes back to its height
    assert np.abs(result.energy.residual).max() < 1e-8 * result.file["energy"].attrs["turned_over"]


def test_prescribed_motion_has_exact_rates():
    """Angle, speed and acceleration of a driven crank are the signal and its derivatives; torque from Newton-Euler."""
    crank = m.body("crank", {"A": (0, 0)}, com=(0.1, 0.0), mass=2.0)
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank["A"], name="A"),
        cl.Drive(crank, motion=ramp(amplitude=3.0, period=0.5)),
        gravity=(0.0, 0.0),
    )
    result = cl.simulate(scene, until=1.0, samples=101)
    t, w = result.time, math.pi / 0.5
    early = t < 0.5
    np.testing.assert_allclose(result["crank"].omega[early], 3.0 * (1 - np.cos(w * t[early])), atol=1e-12)
    np.testing.assert_allclose(result["crank"].alpha[early], 3.0 * w * np.sin(w * t[early]), atol=1e-11)
    inertia = crank.inertia + 2.0 * 0.1**2
    np.testing.assert_allclose(result.drive("crank").torque, inertia * result["crank"].alpha, atol=1e-11)


def test_motor_curve_and_gust():
    """A rotor on a motor curve: omega = no_load (1 - exp(-t / tau)), tau = J no_load / stall."""
    rotor = cl.Body("rotor", 1.0, 0.02)
    scene = cl.Scene(
        cl.Revolute(cl.ground, rotor, name="A"),
        cl.Drive(rotor, torque=motor(stall=3.0, no_load=50.0)),
        cl.Force(rotor.at(0, 0), x=gust(force=2.0)),
    )
    result = cl.simulate(scene, until=0.5, rtol=1e-10)
    tau = 0.02 * 50.0 / 3.0
    np.testing.assert_allclose(result["rotor"].omega, 50.0 * (1 - np.exp(-result.time / tau)), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(result.joint("A").force_x, -2.0 * np.sin(10.0 * result.time) ** 2, atol=1e-12)


def test_driven_slide_and_closed_loop():
    """The actuator lifts its boom: cylinder length is the drive's, power balance closes."""
    result = cl.simulate(m.actuator(), until=2.0, rtol=1e-9)
    length = np.hypot(*(point(result, "piston", (0.0, 0.0), (0.1, 0.0)) - point(result, "tube", (0, 0), (0.1, 0.0))))
    np.testing.assert_allclose(length, 0.35 + 0.05 * result.time, atol=1e-11)
    assert np.abs(result.energy.residual).max() < 1e-8 * result.file["energy"].attrs["turned_over"]


def point(result, body, local, com):
    c, s = np.cos(result[body].theta), np.sin(result[body].theta)
    x, y = local[0] - com[0], local[1] - com[1]
    return np.array([result[body].x + c * x - s * y, result[body].y + s * x + c * y])


def test_spring_pendulum_period():
    """A free mass on a spring without joints: sqrt(k/m) oscillation about its rest length."""
    mass = cl.Body("mass", 2.0, 1e-3, position=(0.0, -0.6))
    spring = cl.SpringDamper(cl.ground, mass, stiffness=300.0, free_length=0.5)
    result = cl.simulate(cl.Scene(spring), until=3.0, rtol=1e-10)
    rest = -0.5 - 2.0 * 9.81 / 300.0
    expected = rest + (-0.6 - rest) * np.cos(math.sqrt(300.0 / 2.0) * result.time)
    np.testing.assert_allclose(result["mass"].y, expected, atol=1e-8)


def test_a_law_the_kernel_cannot_read():
    @cl.contact
    def unreadable(penetration, penetration_rate, impact_speed):
        return np.exp(penetration)

    body = cl.Body("ball", 0.5, 1e-4)
    joint = cl.ClearanceRevolute(cl.ground, body, name="J", radius=0.01, clearance=1e-3, contact=unreadable)
    with pytest.raises(ValueError, match="law unreadable uses 'np'"):
        cl.simulate(cl.Scene(joint), until=0.1)
