"""Laws and motions a user writes in a file of their own reach the kernel without registration."""

import math
import re

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.values.checks import positive
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
        return 0.5 * amplitude * (time - period / math.pi * math.sin(math.pi * time / period))
    return amplitude * (time - 0.5 * period)


@cl.signal
def gust(time, force):
    return force * math.sin(10.0 * time) ** 2


@cl.effort
def motor(time, position, rate, stall, no_load):
    return stall * (1.0 - rate / no_load)


def ball(law, clearance=1e-3):
    """A ball that falls in its bearing, onto a contact law."""
    body = cl.Body("ball", 0.5, 1e-4)
    return cl.Scene(
        cl.ClearanceRevolute(
            cl.ground, body, name="J", radius=0.01, clearance=clearance, contact=law
        )
    )


def test_contact_law():
    """The file has the force of the law. It is elastic: the ball comes back to its height."""
    law = stiffening(stiffness=100.0, limit=1e-4)
    result = cl.simulate(ball(law), until=0.1, rtol=1e-9)
    inside = result.joint("J").gap < 0
    assert inside.any()
    expected = law(-result.joint("J").gap[inside], 0.0, 0.0)
    np.testing.assert_allclose(result.joint("J").contact_force[inside], expected, rtol=1e-9)
    assert result.solver["energy_residual_share"] < 1e-8


def test_prescribed_motion_has_exact_rates():
    """Angle, speed and acceleration of a driven crank are the signal and its derivatives; torque
    from Newton-Euler.
    """
    crank = m.body("crank", {"A": (0, 0)}, com=(0.1, 0.0), mass=2.0)
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank["A"], name="A"),
        cl.Drive(crank, motion=ramp(amplitude=3.0, period=0.5)),
        gravity=(0.0, 0.0),
    )
    result = cl.simulate(scene, until=1.0, samples=101)
    t, w = result.time, math.pi / 0.5
    early = t < 0.5
    np.testing.assert_allclose(
        result["crank"].omega[early], 1.5 * (1 - np.cos(w * t[early])), atol=1e-12
    )
    np.testing.assert_allclose(
        result["crank"].alpha[early], 1.5 * w * np.sin(w * t[early]), atol=1e-11
    )
    inertia = crank.inertia + 2.0 * 0.1**2
    np.testing.assert_allclose(
        result.drive("crank").torque, inertia * result["crank"].alpha, atol=1e-11
    )


def bend(x, y):
    return x * y, x - y


@cl.signal
def stepped(time, v):
    """Everything at once: a ternary, max, a helper, names that generated code might use."""
    d0_time, w0_0 = bend(time, v)
    late = v * (time - 0.5) ** 2 if time > 0.5 else 0.0
    return (
        late
        + max(0.1 * d0_time, w0_0 * time - 3.0)
        + (time > 0.25) * (time - 0.25) ** 3
        + time % 2.0
    )


@pytest.mark.parametrize("at", [0.2, 0.4, 0.8])
def test_motions_are_differentiated_twice(at):
    """First and second derivative of an awkward motion against central differences (1e-4:
    h = 1e-4).
    """
    rotor = cl.Body("rotor", 1.0, 0.02)
    motion = stepped(v=0.7)
    scene = cl.Scene(cl.Revolute(cl.ground, rotor, name="A"), cl.Drive(rotor, motion=motion))
    result = cl.simulate(scene, until=at, samples=2)
    h = 1e-4
    low, here, high = motion(at - h), motion(at), motion(at + h)
    assert result["rotor"].theta[-1] == pytest.approx(here, abs=1e-12)
    assert result["rotor"].omega[-1] == pytest.approx((high - low) / (2 * h), abs=1e-5)
    assert result["rotor"].alpha[-1] == pytest.approx((high - 2 * here + low) / h**2, abs=1e-4)


def test_a_brief_load_needs_and_gets_a_short_step():
    """A blow of 1 ms is met with steps of 0.2 ms: its impulse, 1e-5."""

    @cl.signal
    def blow(time, force):
        return force if 0.5037 < time < 0.5047 else 0.0

    slider = cl.Body("slider", 2.0, 1e-3)
    scene = cl.Scene(
        cl.Prismatic(cl.ground, slider, name="g"), cl.Force(slider, x=blow(force=400.0))
    )
    result = cl.simulate(scene, until=1.0, max_step=2e-4, rtol=1e-8)
    assert result["slider"].vx[-1] == pytest.approx(0.2, rel=1e-5)


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
    np.testing.assert_allclose(
        result["rotor"].omega, 50.0 * (1 - np.exp(-result.time / tau)), rtol=1e-8, atol=1e-8
    )
    np.testing.assert_allclose(
        result.joint("A").force_x, -2.0 * np.sin(10.0 * result.time) ** 2, atol=1e-12
    )


def test_driven_slide_and_closed_loop():
    """The actuator lifts its boom: cylinder length is the drive's, power balance closes."""
    result = cl.simulate(m.actuator(), until=2.0, rtol=1e-9)
    length = np.hypot(
        *(
            point(result, "piston", (0.0, 0.0), (0.1, 0.0))
            - point(result, "tube", (0, 0), (0.1, 0.0))
        )
    )
    np.testing.assert_allclose(length, 0.35 + 0.05 * result.time, atol=1e-11)
    assert result.solver["energy_residual_share"] < 1e-8


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
    """A law with functions of numpy is refused with its name."""

    @cl.contact
    def unreadable(penetration, penetration_rate, impact_speed):
        return np.expm1(max(penetration, 0.0))

    with pytest.raises(ValueError, match="law unreadable cannot be differentiated: it uses np"):
        cl.simulate(ball(unreadable), until=0.1)


def engine(order, force=None):
    """A free slider-crank with a heavy crank, its joints listed in some order."""
    crank = m.body("crank", {"A": (0, 0), "B": (0.05, 0)}, angle=0.7, com=(0.0, 0.0), mass=2.0)
    rod = m.body("rod", {"B": (0, 0), "C": (0.15, 0)}, angle=-0.2, com=(0.07, 0))
    piston = m.body("piston", {"C": (0, 0)}, mass=0.3)
    joints = {
        "A": cl.Revolute(cl.ground, crank["A"], name="A"),
        "B": cl.Revolute(crank["B"], rod["B"], name="B"),
        "C": cl.Revolute(rod["C"], piston["C"], name="C"),
        "g": cl.Prismatic(cl.ground, piston["C"], name="g"),
    }
    drive = [cl.Drive(joints["g"], force=force, name="gas")] if force else []
    turning = cl.Body(**{**vars(crank), "angular_velocity": 40.0})
    object.__setattr__(joints["A"], "b", turning["A"])
    object.__setattr__(joints["B"], "a", turning["B"])
    return cl.Scene(*(joints[n] for n in order), *drive)


@pytest.mark.parametrize("order", ["ABCg", "gCBA", "BgAC"])
@pytest.mark.parametrize("force", [None, 3.0])
def test_the_coordinate_passes_dead_centres_whatever_the_order(order, force):
    """Free or pushed by its piston: the crank is the coordinate, so dead centres are nothing
    special.
    """
    result = cl.simulate(engine(order, force), until=1.0, rtol=1e-9)
    assert result["crank"].theta[-1] > 20.0
    assert result.solver["energy_residual_share"] < 3e-7


def test_a_torsion_spring_counts_whole_turns():
    """Between a crank and a coupler known by cosine and sine only: no jump of energy when an angle
    passes pi.
    """
    scene = m.pushed_four_bar()
    crank = scene.joints[0].b.body
    coupler = scene.joints[1].b.body
    spring = cl.TorsionSpring(crank, coupler, stiffness=0.3)
    twisted = cl.Scene(*scene.joints, *scene.loads, spring)
    result = cl.simulate(twisted, until=2.0, rtol=1e-9)
    twist = result["coupler"].theta - result["crank"].theta
    assert np.ptp(twist) > np.pi
    assert result.solver["energy_residual_share"] < 1e-7


def test_coarse_samples_keep_whole_angles():
    """A double pendulum sampled once a second: the stored angle is the state's, not a guess from
    its speed.
    """
    scene = cl.load_case("double_pendulum")
    fine = cl.simulate(scene, until=20.0, rtol=1e-9, samples=20001)
    coarse = cl.simulate(scene, until=20.0, rtol=1e-9, samples=21)
    np.testing.assert_allclose(coarse["lower"].theta, fine["lower"].theta[::1000], atol=1e-3)


def same_name(factor):
    @cl.contact
    def linear(penetration, penetration_rate, impact_speed, stiffness):
        return factor * stiffness * max(penetration, 0.0)

    return linear(stiffness=1e6)


def _half(x):
    return 0.5 * x


@cl.contact
def solve_gap(penetration, penetration_rate, impact_speed, stiffness):
    """Half a spring [N], by a helper."""
    return _half(stiffness * max(penetration, 0.0))


@cl.contact
def _spring(penetration, penetration_rate, impact_speed, stiffness):
    """A spring [N]."""
    return stiffness * max(penetration, 0.0)


def test_names_that_kernels_use_themselves():
    """A law may be called as the kernel's own functions and variables are, or begin with an
    underscore.
    """
    half, entire = (
        cl.simulate(ball(law), until=0.05)
        for law in (solve_gap(stiffness=2e6), _spring(stiffness=1e6))
    )
    np.testing.assert_array_equal(half.joint("J").contact_force, entire.joint("J").contact_force)
    assert half.joint("J").contact_force.max() > 0.0


def test_two_laws_of_one_name():
    """Two laws of one name keep their numbers apart."""
    bodies = [cl.Body(n, 1.0, 1e-3) for n in ("one", "two")]
    joints = [
        cl.ClearanceRevolute(
            cl.ground,
            b,
            name=b.name,
            radius=0.01,
            clearance=1e-4,
            contact=same_name(f),
            eccentricity=(1.1e-4, 0.0),
        )
        for b, f in zip(bodies, (1.0, 3.0), strict=True)
    ]
    result = cl.simulate(cl.Scene(*joints), until=1e-6)
    assert result.joint("one").contact_force[0] == pytest.approx(10.0, rel=1e-9)
    assert result.joint("two").contact_force[0] == pytest.approx(30.0, rel=1e-9)


def test_parts_of_one_name_keep_their_numbers():
    """A joint, a spring, a force and a body may share a name."""
    body = cl.Body("P", 1.0, 1e-3, points={"x": (0.1, 0.0)})
    scene = cl.Scene(
        cl.Revolute(cl.ground, body, name="P"),
        cl.SpringDamper(
            cl.ground.at(0.0, 0.3), body["x"], stiffness=100.0, free_length=0.2, name="P"
        ),
        cl.Force(body["x"], x=1.0, name="gravity"),
    )
    result = cl.simulate(scene, until=1e-3)
    length = math.hypot(0.1, 0.3)
    assert result.file["springs/P/tension"][0] == pytest.approx(100.0 * (length - 0.2), rel=1e-12)


def test_impossible_parts_are_named():
    """Pins in one point, and a drive of a joint outside the scene."""
    one = cl.Body("one", 1.0, 1e-3, points={"p": (0.1, 0.0), "q": (0.1, 0.0)})
    two = cl.Body("two", 1.0, 1e-3, points={"a": (0, 0), "b": (0.2, 0)}, angle=1.0)
    hinges = [
        cl.Revolute(cl.ground.at(0.1, 0.0), one["p"], name="A"),
        cl.Revolute(one["q"], two["a"], name="B"),
        cl.Revolute(two["b"], cl.ground.at(0.3, 0.0), name="C"),
    ]
    with pytest.raises(
        ValueError, match="its pins of joint .* lie in one point|repeat each other's constraints"
    ):
        cl.simulate(cl.Scene(*hinges), until=0.1)
    loose = cl.Revolute(one["p"], two["a"], name="elsewhere")
    with pytest.raises(ValueError, match="its target, joint elsewhere, is not in the scene"):
        cl.Scene(*hinges, cl.Drive(loose, speed=1.0))


def free_four_bar(lengths):
    """Undriven four-bar released from rest; which link is the shortest decides the coordinate."""
    names = ("crank", "coupler", "rocker")
    angles = (1.0, 0.4, 1.7)
    a, b, c = (
        m.body(n, {"a": (0, 0), "b": (x, 0)}, angle=q, com=(0.5 * x, 0.0))
        for n, x, q in zip(names, lengths, angles, strict=True)
    )
    return cl.Scene(*m.loop(a, b, c, 0.16))


def test_other_lengths_may_need_another_plan():
    """The coordinate depends on lengths: scenes of one connectivity but different plans must not
    share kernels.
    """
    results = [
        cl.simulate(free_four_bar(x), until=0.2, rtol=1e-9)
        for x in ((0.05, 0.15, 0.12), (0.12, 0.15, 0.05))
    ]
    assert [r.attributes["kernel"] for r in results][0] != results[1].attributes["kernel"]
    for result in results:
        assert result.solver["energy_residual_share"] < 1e-7


@pytest.mark.parametrize("point", [0.0, 0.02, 0.2])
def test_a_quick_return_driven_by_torque(point):
    """The crank turns all the way whatever point of the guide the slot is described from."""
    crank = m.body("crank", {"A": (0, 0), "B": (0.05, 0)}, angle=0.5)
    block = m.body("block", {"B": (0, 0)}, mass=0.2)
    guide = m.body("guide", {"O": (0, 0), "P": (point, 0)}, angle=1.3, com=(0.1, 0.0))
    scene = cl.Scene(
        cl.Revolute(cl.ground, guide["O"], name="O"),
        cl.Prismatic(guide["P"], block["B"], name="slot"),
        cl.Revolute(crank["B"], block["B"], name="B"),
        cl.Revolute(cl.ground.at(0, 0.15), crank["A"], name="A"),
        cl.Drive(crank, torque=0.2, start=0.5, speed_start=10.0),
    )
    result = cl.simulate(scene, until=0.5, rtol=1e-9)
    assert result["crank"].theta[-1] > 6.0
    assert result.solver["energy_residual_share"] < 1e-6


@cl.contact
def rooted(penetration, penetration_rate, impact_speed, stiffness, low, high):
    """Without a value below one depth and beyond another."""
    if penetration <= 0.0:
        return 0.0
    return stiffness * penetration * math.sqrt((penetration - low) * (high - penetration)) / high


@pytest.mark.parametrize(("low", "high", "gap"), [(1e-6, 1e-2, -1e-6), (0.0, 2e-5, -2e-5)])
def test_a_law_without_a_value_is_named(low, high, gap):
    """On the way out or on the way in: the joint, what is no number, and where (1e-9 m)."""
    scene = ball(rooted(stiffness=1e6, low=low, high=high), clearance=1e-4)

    message = (
        r"joint J: contact_force is not a number at a gap of (\S+) m: "
        r"the law rooted has no value there \(J: ecc"
    )
    with pytest.raises(cl.SimulationError, match=message) as caught:
        cl.simulate(scene, until=0.1)
    assert float(re.search(message, str(caught.value))[1]) == pytest.approx(gap, abs=1e-9)


def test_what_the_force_of_a_slide_is():
    """Of a driven slide the drive's force is in it, and the file states so; of others it is the
    reaction.
    """
    message = {c.path: c.long_name for c in build(m.actuator()).layout.channels}
    assert (
        message["joints/cylinder/force_x"]
        == "force x on piston, with that of drive oil along the slide"
    )
    assert message["joints/O/force_x"] == "force x on boom"
    plain = {c.path: c.long_name for c in build(engine("ABCg")).layout.channels}
    assert plain["joints/g/force_y"] == "force y on piston"


PUSH = 5.0


@cl.signal
def constant_push(time):
    return PUSH + 0.0 * time


def test_a_changed_number_behind_a_law_takes_effect(monkeypatch):
    """A global that a signal reads is read anew for each run."""
    slider = cl.Body("slider", 2.0, 1e-3)
    scene = cl.Scene(cl.Prismatic(cl.ground, slider, name="g"), cl.Force(slider, x=constant_push))
    assert cl.simulate(scene, until=0.1, samples=3)["slider"].ax[-1] == pytest.approx(2.5)
    monkeypatch.setitem(globals(), "PUSH", 7.0)
    assert cl.simulate(scene, until=0.1, samples=3)["slider"].ax[-1] == pytest.approx(3.5)


@cl.signal
def infinite_bend(time):
    return abs(time - 0.05) ** 1.5


def test_an_output_without_a_value_ends_the_run():
    """Acceleration infinite at a sample: nothing that is not a number enters the file."""
    rotor = cl.Body("rotor", 1.0, 0.02)
    scene = cl.Scene(cl.Revolute(cl.ground, rotor, name="A"), cl.Drive(rotor, motion=infinite_bend))
    with pytest.raises(
        cl.SimulationError, match=r"at t = 0.05 s: bodies/rotor/alpha is not finite"
    ) as caught:
        cl.simulate(scene, until=0.1, samples=11)
    assert np.isfinite(caught.value.result["rotor"].alpha).all()


def lag(state, time, position, rate, gain, delay):
    """A torque that follows its gain with a delay."""
    return (gain - state) / delay, state


def half(state, time, position, rate, gain, delay):
    """Half of the torque."""
    return 0.5 * state


def lagging(shown: dict) -> cl.Scene:
    """A rotor with a law of its own, which has these outputs."""
    law = cl.drive_state(shown=shown)(lag)
    rotor = cl.Body("rotor", 1.0, 2e-3)
    drive = cl.Drive(rotor, torque=law(gain=2.0, delay=0.1), speed_start=0.0, name="motor")
    return cl.Scene(cl.Revolute(cl.ground, rotor, name="A"), drive)


def test_a_decorator_states_traits_and_checks_of_parameters():
    """A name that is a parameter's is its check; traits of one law are not those of others."""

    @cl.joint_friction(limit=positive, layer=lambda values: (1e-3, 1e-2), needs_load=False)
    def limited(rate, load, limit):
        return -limit * math.tanh(rate)

    assert limited.limit is None
    assert limited.layer({}) == (1e-3, 1e-2)
    assert not limited.needs_load
    with pytest.raises(ValueError, match="limited: limit must be positive"):
        limited(limit=-1.0)
    assert cl.joint_friction(_plain).needs_load
    with pytest.raises(TypeError, match=r"_plain has no parameter \['first_tuch'\] to check"):
        cl.joint_friction(first_tuch=True)(_plain)


def _plain(rate, load):
    return -rate


def test_outputs_of_a_drive_law():
    """The output is half of the torque: rounding, 1e-14. Unit and description are the law's."""
    scene = lagging({"half": ("N m", "half of the torque", half)})
    motor = cl.simulate(scene, until=0.3).drive("motor")
    assert motor.half[-1] > 0.9
    np.testing.assert_allclose(motor.half, 0.5 * motor.torque, rtol=1e-14)
    (channel,) = (c for c in build(scene).layout.channels if c.path == "drives/motor/half")
    assert (channel.units, channel.long_name) == ("N m", "half of the torque")


def test_output_without_a_unit_is_refused():
    """An output without unit and description is a TypeError."""
    with pytest.raises(TypeError, match="law lag: shown.'third'. must be .unit, description"):
        lagging({"third": half})
