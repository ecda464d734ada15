"""Largest Lyapunov exponents against motions whose exponent is known, and against the variational
equations.
"""

import json
import math

import h5py
import numpy as np
import pytest
from clearance.postprocess import study_pictures
from scipy.integrate import solve_ivp

import clearance as cl
from clearance.laws.law import signal
from clearance.mechanism.build import build
from clearance.motions import lyapunov as module
from clearance.motions.lyapunov import Exponent, lyapunov

pytestmark = pytest.mark.slow


@signal
def cosine(time, amplitude, frequency):
    return amplitude * math.cos(frequency * time)


DRIVE = 2.0 / 3.0  # rad/s


def pendulum(amplitude, quality=2.0):
    """theta'' + theta' / q + sin theta = g cos(2 t / 3) (Baker and Gollub, Chaotic Dynamics, 1990):
    unit inertia about the pivot and unit m g l.
    """
    bob = cl.Body("bob", mass=1.0, inertia=0.75, points={"pivot": (0, 0)}, com=(0, -0.5), angle=0.2)
    return cl.Scene(
        cl.Revolute(cl.ground, bob["pivot"], name="pivot"),
        cl.TorsionSpring(cl.ground, bob, damping=1.0 / quality),
        cl.Torque(bob, cosine(amplitude=amplitude, frequency=DRIVE)),
        gravity=(0, -2.0),
        name="pendulum",
    )


def oscillator(mass=2.0, damping=3.0, stiffness=800.0):
    body = cl.Body("mass", mass=mass, inertia=1.0, points={"p": (0, 0)}, position=(0.1, 0))
    return cl.Scene(
        cl.Prismatic(cl.ground, body["p"], name="guide"),
        cl.SpringDamper(
            cl.ground.at(-1, 0), body["p"], stiffness=stiffness, damping=damping, free_length=1.0
        ),
        gravity=(0, 0),
        name="oscillator",
    )


def double_pendulum(angle):
    upper = cl.Body(
        "upper",
        mass=1,
        inertia=0.01,
        points={"o": (0, 0), "e": (0, -1)},
        com=(0, -0.5),
        angle=angle,
    )
    lower = cl.Body(
        "lower", mass=1, inertia=0.01, points={"e": (0, 0)}, com=(0, -0.5), angle=-angle
    )
    return cl.Scene(
        cl.Revolute(cl.ground, upper["o"], name="o"),
        cl.Revolute(upper["e"], lower["e"], name="e"),
        name="double",
    )


def crank(rpm=2000, clearance=0.5e-3, restitution=0.5, **more):
    return cl.load_case(
        "slider_crank",
        model="dry",
        speed=cl.rpm(rpm),
        clearance=clearance,
        restitution=restitution,
        **more,
    )


class TestKnownExponents:
    def test_damped_oscillator(self, validated):
        """-c / (2 m) exactly.

        The growth over a damped period is the same from every phase, so what is left are the
        local errors over the distance, 1e-10 / 1e-6, averaged over 1200 stops: below 1e-5.
        """
        exponent = lyapunov(
            oscillator(), turns=50, settle=2, interval=2.0 * math.pi / math.sqrt(400.0 - 0.75**2)
        )
        options = {"unit": "1/s", "source": "-c / (2 m)", "kind": "exact"}
        validated("exponent of a damped oscillator", exponent.per_second, -0.75, 1e-5, **options)
        assert exponent.error_per_second < 1e-5
        assert exponent.verdict == "regular"

    def test_damped_oscillator_over_another_interval(self):
        """Out of step with the oscillation the growth scatters, and the stated error covers it:
        within 3 errors.
        """
        exponent = lyapunov(oscillator(), turns=50, settle=2, interval=0.2)
        assert abs(exponent.per_second + 0.75) < 3.0 * exponent.error_per_second < 1.0

    def test_periodic_pendulum(self, validated):
        """The two exponents add up to -1 / q; where neighbours spiral in, each is half of it:
        -0.25. Within 3 errors, and these below 2 %.
        """
        exponent = lyapunov(pendulum(0.9), turns=150, interval=2.0 * math.pi / DRIVE)
        assert exponent.error_per_second < 0.005
        options = {
            "unit": "1/s",
            "source": "half the divergence, Baker and Gollub's pendulum",
            "kind": "exact",
        }
        allowed = 3.0 * exponent.error_per_second
        validated(
            "exponent of a periodic pendulum",
            exponent.per_second,
            -0.25,
            allowed,
            relative=False,
            **options,
        )
        assert exponent.verdict == "regular"

    def test_chaotic_pendulum(self, validated):
        """Against the variational equations on a hundred motions of their own, whose mean is known
        to 0.006.

        Another processor runs another motion of the same mean. So within 6 stated errors: batches
        of 20 make that a chance of 1e-5.
        """
        exponent = lyapunov(pendulum(1.5), turns=600, interval=2.0 * math.pi / DRIVE)
        growth = variational_pendulums(1.5, turns=200, count=100)
        allowed = 6.0 * math.hypot(exponent.error, growth.std() / math.sqrt(growth.size))
        options = {
            "source": "variational equations by Runge and Kutta",
            "kind": "independent",
            "relative": False,
        }
        validated(
            "exponent of a chaotic pendulum, a turn",
            exponent.per_turn,
            growth.mean(),
            allowed,
            **options,
        )
        assert exponent.error < 0.15 * exponent.per_turn
        assert exponent.verdict == "chaotic"

    def test_double_pendulum(self):
        """Undamped and low, it is nearly two linear oscillators: neighbours part in proportion to
        time at most, below what the run resolves; thrown high, it is chaotic.
        """
        low = lyapunov(double_pendulum(0.1), turns=100, interval=2.0)
        assert abs(low.per_turn) < low.resolution + 2.0 * low.error < 0.05
        assert low.verdict == "undecided"
        assert lyapunov(double_pendulum(2.0), turns=100, interval=2.0).verdict == "chaotic"


def variational_pendulums(amplitude, turns, count, settle=20, quality=2.0, steps=240):
    """Mean growth per period of the tangents of pendulums from random starts (shape count), by the
    classical method of order four; errors of its steps move the mean by far less than its scatter.
    """
    period, random = 2.0 * math.pi / DRIVE, np.random.default_rng(1990)
    z = np.array([random.uniform(-b, b, count) for b in (3.0, 1.0, 1.0, 1.0)])
    growth, h = np.zeros(count), period / steps

    def slope(t, z):
        angle, speed, apart, faster = z
        torque = amplitude * math.cos(DRIVE * t) - speed / quality - np.sin(angle)
        return np.array([speed, torque, faster, -faster / quality - np.cos(angle) * apart])

    for n in range((settle + turns) * steps):
        t = n * h
        k = slope(t, z)
        total = k.copy()
        for share, weight in ((0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
            k = slope(t + share * h, z + share * h * k)
            total += weight * k
        z = z + h / 6.0 * total
        if (n + 1) % (steps // 10) == 0:
            size = np.hypot(z[2], z[3])
            z[2:] /= size
            growth += np.log(size) if n >= settle * steps else 0.0
    return growth / turns


class TestSliderCrank:
    def test_against_the_variational_equations(self, monkeypatch, validated):
        """Turn by turn, the compiled Jacobian and the jump of the remembered impact speed at each
        touch give the same growth. Within 1e-3: both follow one motion to about 1e-10, which four
        turns magnify by exp(12) = 2e5 to 2e-5, and the distance bends the growth by about as much.
        Without the impact speed in the separation it is another.
        """
        wanted = variational_growth(crank(), turns=4)
        exponent = lyapunov(crank(), turns=4, settle=0, rtol=1e-12)
        options = {
            "source": "variational equations by scipy",
            "kind": "independent",
            "relative": False,
        }
        validated("growth with impacts, turn by turn", exponent.growth, wanted, 1e-3, **options)
        validated("the same at the wider distance", exponent.wider, wanted, 1e-3, **options)
        monkeypatch.setattr(module, "LASTING", -1.0)
        assert np.abs(lyapunov(crank(), turns=4, settle=0, rtol=1e-12).growth - wanted).max() > 0.05

    def test_neither_distance_nor_stops_matter(self, monkeypatch):
        """Nor does the tolerance, as long as the motions are the same: for about five turns.

        Within 2e-2: at 1e-4 of the clearance the separation bends, at a tolerance of 1e-3 of the
        distance it is rough.
        """
        usual = lyapunov(crank(), turns=5, settle=0, rtol=1e-12).growth
        for distance, rtol, stops in (
            (1e-5, 1e-12, 24),
            (1e-8, 1e-12, 24),
            (1e-6, 1e-10, 24),
            (1e-6, 1e-12, 6),
            (1e-6, 1e-12, 96),
        ):
            monkeypatch.setattr(module, "STOPS", stops)
            exponent = lyapunov(crank(), turns=5, settle=0, distance=distance, rtol=rtol)
            assert exponent.growth == pytest.approx(usual, abs=2e-2), (distance, rtol, stops)
            assert abs(exponent.effect) < 2e-2

    def test_period_one_and_chaos(self):
        """At a clearance of 1 mm with friction 0.03 the motion repeats itself every turn from 1500
        to 3940 rpm and is irregular beyond (stroboscopic sections show the same).
        """
        friction = {"clearance": 1e-3, "restitution": 0.9, "friction": "coulomb"}
        slow, fast = (lyapunov(crank(rpm, **friction), turns=60) for rpm in (2000, 5000))
        assert slow.verdict == "regular"
        assert fast.verdict == "chaotic"
        assert slow.per_turn < -0.3 < 0.8 < fast.per_turn  # 200 turns: -0.54 and 1.7 +- 0.2

    def test_lasting_contact(self):
        """A contact that never ends keeps its impact speed, which is no growth; the motion repeats
        itself every two turns, growing in one and shrinking in the other, and the error is not that
        of single turns.
        """
        exponent = lyapunov(crank(5000, 1e-4), turns=60)
        assert exponent.growth[0::2].mean() * exponent.growth[1::2].mean() < 0.0
        assert exponent.sampling < 0.1 * exponent.growth.std() / math.sqrt(exponent.turns)
        assert exponent.verdict == "regular"

    def test_with_a_film(self):
        """An implicit method does it as well: oil makes the motion repeat itself."""
        exponent = lyapunov(cl.load_case("slider_crank", model="lubricated"), turns=8, settle=4)
        assert exponent.verdict == "regular"


def variational_growth(scene, turns, rtol=1e-10):
    """Logarithm of the growth of a tangent turn by turn, of a scene with one dry joint.

    Tangent: of the state and of the impact speed s that the contact remembers. At a touch with rate
    v and closing acceleration a: ds = dv - a d(penetration) / v, as a neighbour that is deeper by
    d(penetration) touched earlier.
    """
    m = build(scene, ledger=False)
    n, speed = m.size, m.frequency * scene.clearance_joints[0].clearance
    work = np.append(m.work0, 0.0)
    work[0] = -1.0
    rhs, jacobian, events = (m.kernel(role) for role in ("rhs", "jacobian", "events"))

    def call(kernel, size, t, y, impact_speed=None):
        out, ours = np.zeros(size), work.copy()
        ours[0] = work[0] if impact_speed is None else impact_speed
        kernel(t, np.ascontiguousarray(y), m.par, ours, out)
        return out

    def slope(t, z):
        y, s = z[:n], work[0]
        tangent = call(jacobian, n * n, t, y).reshape(n, n) @ z[n:-1]
        if s > 0.0:
            h = 1e-6 * s
            tangent += z[-1] * (call(rhs, n, t, y, s + h) - call(rhs, n, t, y, s - h)) / (2.0 * h)
        return np.concatenate([call(rhs, n, t, y), tangent, [0.0]])

    def penetration(t, z):
        return call(events, 3, t, z[:n])[0]

    def touch(t, z):
        """The remembered speed and its tangent."""
        y, d = z[:n], z[n:-1]
        here, small, soon = (
            call(events, 3, t, y),
            1e-6 / np.linalg.norm(d / m.scale),
            1e-7 * scene.turn,
        )
        beside = (call(events, 3, t, y + small * d) - here) / small
        later = (call(events, 3, t + soon, y + soon * call(rhs, n, t, y)) - here) / soon
        return here[1], beside[1] - later[1] * beside[0] / here[1]

    penetration.terminal = True
    direction = np.random.default_rng(1980).standard_normal(n)
    z = np.concatenate([m.y0, m.scale * direction / np.linalg.norm(direction), [0.0]])
    tolerance = rtol * np.concatenate([m.scale, m.scale, [1.0]])
    t, growth = 0.0, []
    for turn in range(1, turns + 1):
        while t < turn * scene.turn:
            penetration.direction = -1 if work[0] > 0.0 else 1
            run = solve_ivp(
                slope,
                (t, turn * scene.turn),
                z,
                method="DOP853",
                rtol=rtol,
                atol=tolerance,
                events=penetration,
                # no flight shall be jumped over
                max_step=scene.turn / (500.0 if work[0] > 0.0 else 5000.0),
            )
            t, z = run.t[-1], run.y[:, -1].copy()
            if run.status == 1:
                work[0], z[-1] = (-1.0, 0.0) if work[0] > 0.0 else touch(t, z)
        size = math.hypot(np.linalg.norm(z[n:-1] / m.scale), z[-1] / speed)
        growth.append(math.log(size))
        z[n:] /= size
    return np.array(growth)


def exponent_of(growth, effect=0.0, settle=20):
    growth = np.asarray(growth, float)
    return Exponent(growth, growth + effect, 0.5, settle, 1e-6, 1e-10)


class TestError:
    def test_of_independent_turns(self):
        """s / sqrt(N); 20 stretches give it to about 1 / sqrt(40) = 16 %, and stretches that happen
        to follow each other up to half more.
        """
        growth = np.random.default_rng(5).standard_normal(400)
        assert 0.6 / 20.0 < exponent_of(growth).sampling < 1.6 / 20.0

    def test_distance_and_sampling_add_up(self):
        """Both errors add as squares."""
        exponent = exponent_of(np.random.default_rng(5).standard_normal(400), effect=-0.3)
        assert exponent.effect == pytest.approx(-0.3)
        assert exponent.error == pytest.approx(math.hypot(exponent.sampling, 0.3))
        assert exponent.error_per_second == pytest.approx(exponent.error / 0.5)
        assert exponent.band[-1] == pytest.approx(exponent.error)
        assert exponent.running[-1] == pytest.approx(exponent.per_turn)

    def test_verdicts(self):
        """Two errors decide; what neighbours that part in proportion to time would do is no
        chaos.
        """
        noise = 0.1 * np.random.default_rng(5).standard_normal(200)
        assert exponent_of(noise + 1.0).verdict == "chaotic"
        assert exponent_of(noise - 1.0).verdict == "regular"
        unclear = exponent_of(noise), exponent_of(noise + 1.0, effect=0.6)
        assert [e.verdict for e in unclear] == 2 * ["undecided"]
        after = np.arange(20, 220)
        assert exponent_of(np.log((after + 1.0) / after)).verdict == "undecided"


class TestBadInput:
    @pytest.mark.parametrize(
        ("wrong", "words"),
        [
            ({"turns": 3}, "turns must be a whole number of at least 4, got 3"),
            ({"settle": 1.5}, "settle must be a whole number of at least 0, got 1.5"),
            ({"distance": 0.1}, "distance must be below 0.001"),
            ({"rtol": 1e-7}, "rtol must lie in"),
            ({"interval": -1.0}, "interval must be positive, got -1.0"),
        ],
    )
    def test_arguments(self, wrong, words):
        """Wrong arguments are refused."""
        with pytest.raises(ValueError, match=words):
            lyapunov(crank(), **wrong)

    def test_no_turn(self):
        """A scene without turns needs an interval."""
        with pytest.raises(ValueError, match="give interval=SECONDS"):
            lyapunov(double_pendulum(0.1))

    def test_no_freedom(self):
        """A scene without freedom is refused."""
        with pytest.raises(ValueError, match="no degree of freedom"):
            lyapunov(cl.load_case("slider_crank", model="ideal"))

    def test_a_film_with_a_memory(self):
        """A film with a memory is refused."""
        with pytest.raises(ValueError, match="film with a memory"):
            lyapunov(cl.load_case("slider_crank", model="lubricated", film="conserving"))


class TestShowing:
    def test_files_and_tables(self, tmp_path):
        """Table, document and file have the same exponent."""
        done = []
        exponent = {"oil/none": lyapunov(crank(5000), turns=12, settle=2, progress=done.append)}
        assert done[-1] == 1.0
        assert len(done) == 14
        x = exponent["oil/none"]
        assert f"{x.per_turn:.4g}" in module.table(exponent)[-1]
        document = json.loads(json.dumps(module.plain(exponent)))["oil/none"]
        assert document["per_second"] == pytest.approx(x.per_turn / x.turn)
        assert document["verdict"] == x.verdict
        assert len(document["growth"]) == 12
        with h5py.File(module.save(exponent, tmp_path)) as file:
            group = file["oil none"]
            assert group["running"][-1] == pytest.approx(group.attrs["per_turn"])
            assert np.isnan(group["running_error"][:3]).all()
            assert np.isfinite(group["running_error"][3:]).all()
        path = study_pictures.lyapunov(
            exponent | {"made": exponent_of(np.ones(12))}, tmp_path / "new" / "lyapunov.png"
        )
        assert path.stat().st_size > 10_000
