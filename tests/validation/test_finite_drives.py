"""Finite drives against one-coordinate equations of motion, closed forms and limits.

`finite_drives.csv`: crank angle [rad] and speed [rad/s] of the slider-crank with ideal joints and a
crank of 1e-3 kg m2 that starts at 600 rpm, driven by the PI of 0.5 N m s/rad and 5 N m/rad, and by
the motor line of 5 N m and 660 rpm. They come from an independent Lagrange equation of the crank
angle.
"""

import csv
import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from clearance.postprocess.channels import abscissa
from clearance.postprocess.sections import section_times
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import clearance as cl
from clearance import laws
from clearance.mechanism.build import build
from clearance.metrics.metrics import metrics
from clearance.values import checks
from tests.pages import block
from tests.seeds import few_of

TABLE = (Path(__file__).parent / "finite_drives.csv").read_text()
ROWS = list(csv.DictReader(TABLE.splitlines()))
SPEED = cl.rpm(600)
LAWS = {
    "pi": cl.pi_speed(proportional=0.5, integral=5.0, speed=SPEED),
    "motor": cl.motor_line(stall=5.0, no_load=cl.rpm(660)),
}
LAGRANGE = {"source": "Lagrange equation of the crank angle", "kind": "independent"}
INERTIA = 2e-3


def slider_crank(law=None, **more):
    """The case with ideal joints, a crank of 1e-3 kg m2 and another drive."""
    scene = cl.load_case("slider_crank", model="ideal", speed=SPEED)
    heavy = dataclasses.replace(scene.bodies[0], inertia=1e-3)
    at = {"A": (cl.ground.at(0, 0), heavy["shaft"]), "B": (heavy["pin"], scene.joints[1].b)}
    hinges = [cl.Revolute(*ends, name=name) for name, ends in at.items()]
    finite = {} if law is None else {"torque": law, "speed_start": SPEED, "nominal": SPEED}
    return cl.Scene(*hinges, *scene.joints[2:], cl.Drive(heavy, start=0.0, **finite, **more))


def rotor(law, inertia=INERTIA, **more):
    """A disc on its axle, from rest."""
    disc = cl.Body("disc", 1.0, inertia)
    return cl.Scene(cl.Revolute(cl.ground, disc, name="axle"), cl.Drive(disc, torque=law, **more))


def lagrange(
    torque, times, mass=0.14, rod=0.21, spin=2.5e-4, crank=0.3, inertia=1e-3, r=0.05, length=0.12
):
    """Crank angle and speed of the slider-crank: M(q) q'' + M'(q) q'^2 / 2 = T - V'(q)."""

    def parts(q):
        s, c = math.sin(q), math.cos(q)
        sine = -r * s / length
        cosine = math.sqrt(1.0 - sine * sine)
        turn = -r * c / (length * cosine)
        bend = (r * s / length + sine * turn * turn) / cosine
        slide, slides = (
            -r * s - length * sine * turn,
            -r * c - length * (cosine * turn**2 + sine * bend),
        )
        x, xx = (
            -r * s - 0.5 * length * sine * turn,
            -r * c - 0.5 * length * (cosine * turn**2 + sine * bend),
        )
        y, yy = (
            r * c + 0.5 * length * cosine * turn,
            -r * s + 0.5 * length * (cosine * bend - sine * turn**2),
        )
        matrix = (
            inertia
            + crank * (0.5 * r) ** 2
            + rod * (x * x + y * y)
            + spin * turn**2
            + mass * slide**2
        )
        slope = rod * (x * xx + y * yy) + spin * turn * bend + mass * slide * slides
        return matrix, slope, -9.81 * (0.5 * crank * r * c + rod * y)

    def rates(t, state):
        matrix, slope, weight = parts(state[0])
        return state[1], (torque(t, *state) + weight - slope * state[1] ** 2) / matrix

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12, "t_eval": times}
    return solve_ivp(rates, (0.0, times[-1]), (0.0, SPEED), **options).y


@pytest.mark.parametrize("name", LAWS)
def test_slider_crank(name, validated):
    """Angle and speed at three times within 1e-9 of each (2e-11; tolerance 1e-10 a step); the
    ledger closes to 1e-9.
    """
    rows = [r for r in ROWS if r["drive"] == name]
    wanted = np.array([[float(r[n]) for r in rows] for n in ("angle", "speed")])
    result = cl.simulate(slider_crank(LAWS[name]), until=0.6, samples=61, rtol=1e-10)
    crank = result["crank"]
    at = [round(float(r["time"]) / 0.01) for r in rows]
    actual = np.array([crank.theta[at], crank.omega[at]])
    validated(f"crank angle and speed, {name}", actual, wanted, 1e-9, unit="rad, rad/s", **LAGRANGE)
    assert result.solver["energy_residual_share"] < 1e-9


def test_lagrange_equation_gives_the_rows():
    """The equation of this file, solved here, gives the rows: 1e-9 (3e-12)."""
    torques = {
        "pi": lambda t, q, w: 0.5 * (SPEED - w) + 5.0 * (SPEED * t - q),
        "motor": lambda t, q, w: 5.0 * (1.0 - w / cl.rpm(660)),
    }
    for name, torque in torques.items():
        rows = [r for r in ROWS if r["drive"] == name]
        wanted = np.array([[float(r[n]) for r in rows] for n in ("angle", "speed")])
        actual = lagrange(torque, [float(r["time"]) for r in rows])
        np.testing.assert_allclose(actual, wanted, rtol=1e-9)


def test_a_stiff_motor_line_prescribes_the_speed(validated):
    """Ten times the stall torque is a tenth of the slip, to 5 %; the torque is that of the
    prescribed speed, to 1 % (0.7 %: the angle lags by the slip).
    """
    slips, torques = [], []
    for stall in (300.0, 3000.0):
        law = cl.motor_line(stall=stall, no_load=SPEED)
        result = cl.simulate(slider_crank(law), turns=1, rtol=1e-9)
        slips.append(np.abs(result["crank"].omega / SPEED - 1.0).max())
        torques.append(result.drive("crank").torque)
    assert slips[1] == pytest.approx(0.1 * slips[0], rel=0.05)
    assert slips[1] < 2e-3
    prescribed = slider_crank(speed=SPEED)
    torque, late = cl.simulate(prescribed, turns=1).drive("crank").torque, slice(40, None)
    more = {"source": "prescribed speed", "kind": "exact", "relative": np.abs(torque).max()}
    validated(
        "torque of a stiff motor line", torques[1][late], torque[late], 1e-2, unit="N m", **more
    )


def test_kloss(validated):
    """At the breakdown slip the breakdown torque, nowhere more, beyond synchronous speed with the
    other sign.
    """
    law = cl.kloss(breakdown=12.0, slip=0.2, synchronous=SPEED)
    rates = SPEED * (1.0 - np.array([0.2, -0.2]))
    actual, source = law(0.0, 0.0, rates), "T_b at s_b"
    validated(
        "breakdown torque", actual, [12.0, -12.0], 1e-14, source=source, kind="exact", unit="N m"
    )
    assert np.abs(law(0.0, 0.0, np.linspace(-SPEED, 3.0 * SPEED, 4001))).max() <= 12.0 * (
        1.0 + 1e-15
    )
    near = SPEED * (1.0 - 1e-6)
    assert law(0.0, 0.0, near) == pytest.approx(2.0 * 12.0 / 0.2 * 1e-6, rel=1e-9)
    back = cl.kloss(breakdown=12.0, slip=0.2, synchronous=-SPEED)
    assert back(0.0, 0.0, -near) == pytest.approx(-law(0.0, 0.0, near), rel=1e-12)


def test_pi_without_integral_is_a_motor_line():
    """Stall K_p w_0, no load w_0; the same torque to rounding, whatever the state."""
    control = cl.pi_speed(proportional=0.3, integral=0.0, speed=SPEED)
    line = cl.motor_line(stall=0.3 * SPEED, no_load=SPEED)
    for rate in (-10.0, 0.0, 40.0, SPEED, 90.0):
        assert control(7.0, 0.1, 3.0, rate)[1] == pytest.approx(
            line(0.1, 3.0, rate), rel=1e-14, abs=1e-14
        )


class TestLimit:
    """A PI whose torque is limited runs a disc up from rest: K_p 0.05, K_i 1, limit 0.2 N m, to 100
    rad/s.
    """

    NUMBERS = {"proportional": 0.05, "integral": 1.0, "speed": 100.0, "limit": 0.2}

    def test_state(self, validated):
        """While T = limit: w = T t / J, z = T / K_i (1 - exp(-K_i t / K_p)); 1e-8 of the largest
        (2e-10).
        """
        result = cl.simulate(rotor(cl.pi_speed(**self.NUMBERS)), until=0.8, samples=81, rtol=1e-10)
        time, drive = result.time, result.drive("disc")
        assert drive.torque == pytest.approx(0.2, abs=1e-15)
        wanted = 0.2 * (1.0 - np.exp(-time / 0.05))
        more = {"source": "closed form", "kind": "exact", "relative": 0.2}
        validated("integral of a limited PI", drive.integral, wanted, 1e-8, unit="rad", **more)
        assert result["disc"].omega == pytest.approx(0.2 * time / INERTIA, abs=1e-7)

    def test_overshoot(self):
        """Back-calculation holds the overshoot below 5 % (3.8 %); an integral that goes on, above
        40 %.
        """

        @laws.effort
        def wound(time, position, rate, proportional, integral, speed, limit):
            wanted = proportional * (speed - rate) + integral * (speed * time - position)
            return min(max(wanted, -limit), limit)

        peaks = []
        for law in (cl.pi_speed(**self.NUMBERS), wound(**self.NUMBERS)):
            result = cl.simulate(rotor(law), until=3.0, samples=601)
            peaks.append(result["disc"].omega.max() / 100.0 - 1.0)
        assert 0.0 <= peaks[0] < 0.05
        assert peaks[1] > 0.4


class TestMotor:
    """A direct-current motor of 24 V, 1 Ohm, 20 mH, 0.1 N m/A runs a disc up from rest."""

    NUMBERS = {"voltage": 24.0, "resistance": 1.0, "inductance": 0.02, "constant": 0.1}

    def exact(self, time):
        """Current and speed: a linear system, by its matrix exponential."""
        v, r, x, k = self.NUMBERS.values()
        matrix = np.array([[-r / x, -k / x, v / x], [k / INERTIA, 0.0, 0.0], [0.0, 0.0, 0.0]])
        return np.array([expm(t * matrix)[:2, 2] for t in time]).T

    @pytest.mark.parametrize("method", few_of(["dop853", "radau5"], 1))
    def test_run_up(self, method, validated):
        """Current and speed within 1e-7 of their largest (1e-9): explicit, and implicit by the
        Jacobian.
        """
        law = cl.dc_motor(**self.NUMBERS)
        result = cl.simulate(rotor(law), until=0.5, samples=51, rtol=1e-9, method=method)
        actual = np.array([result.drive("disc").current, result["disc"].omega])
        wanted = self.exact(result.time)
        sizes = np.abs(wanted).max(axis=1)[:, None]
        more = {"source": "matrix exponential", "kind": "exact"}
        validated(
            f"current and speed of a motor, {method}",
            actual / sizes,
            wanted / sizes,
            1e-7,
            relative=1.0,
            **more,
        )
        assert result.solver["energy_residual_share"] < 1e-8

    def test_outputs(self):
        """V i = T w + R i^2 + (L i^2 / 2)' integrated to 1e-5 (trapezoids); efficiency and
        units.
        """
        law = cl.dc_motor(**self.NUMBERS)
        result = cl.simulate(rotor(law), until=0.5, samples=2001, rtol=1e-9)
        drive, omega, (_, r, x, k) = (
            result.drive("disc"),
            result["disc"].omega,
            self.NUMBERS.values(),
        )
        i = drive.current
        lost = np.trapezoid(r * i * i, result.time)
        taken = np.trapezoid(drive.electric_power, result.time)
        work = result.energy.input[-1]
        assert taken == pytest.approx(work + lost + 0.5 * x * i[-1] ** 2, rel=1e-5)
        assert drive.voltage == pytest.approx(24.0)
        assert drive.torque == pytest.approx(k * i, rel=1e-14)
        late = slice(1, None)
        share = drive.power[late] / (drive.power[late] + r * i[late] ** 2)
        assert drive.efficiency[late] == pytest.approx(share, rel=1e-12)
        assert 0.0 <= drive.efficiency.min() <= drive.efficiency.max() < 1.0
        assert omega[-1] == pytest.approx(self.exact([0.5])[1, 0], rel=1e-6)
        units = {
            "current": "A",
            "voltage": "V",
            "electric_power": "W",
            "efficiency": "1",
            "power": "W",
        }
        assert {n: result.units(f"drives/disc/{n}") for n in units} == units

    def test_without_inductance(self):
        """L -> 0 is the motor line of k V / R and V / k: off by the electric time constant over the
        mechanical.
        """
        line = cl.motor_line(stall=0.1 * 24.0 / 1.0, no_load=24.0 / 0.1)
        wanted = cl.simulate(rotor(line), until=0.3, samples=31).drive("disc").torque
        off = []
        for inductance in (2e-3, 2e-4):
            law = cl.dc_motor(**self.NUMBERS | {"inductance": inductance})
            torque = cl.simulate(rotor(law), until=0.3, samples=31, rtol=1e-8).drive("disc").torque
            off.append(np.abs(torque - wanted)[5:].max())
        assert off[1] == pytest.approx(0.1 * off[0], rel=0.15)


def test_ramp():
    """A prescribed run-up: the speed in the ramp and after it, and the angle at its end, to
    rounding.
    """
    disc = cl.Body("disc", 1.0, INERTIA)
    motion = cl.ramp(speed=50.0, duration=0.2, start=0.3)
    drive = cl.Drive(disc, motion=motion, nominal=50.0)
    result = cl.simulate(cl.Scene(cl.Revolute(cl.ground, disc, name="axle"), drive), turns=4)
    time, omega = result.time, result["disc"].omega
    assert omega == pytest.approx(50.0 * np.minimum(time / 0.2, 1.0), abs=1e-12)
    angle = 0.3 + 50.0 * np.where(time < 0.2, time**2 / 0.4, time - 0.1)
    assert result.turns_at(time) == pytest.approx((angle - 0.3) / (2.0 * math.pi), abs=1e-12)
    assert result.turn == pytest.approx(2.0 * math.pi / 50.0)


@cl.signal(rise=checks.positive)
def corner(time, rise):
    """An angle that stands still and then moves at once [rad]: its rate jumps."""
    return max(0.0, time - rise)


def test_steps_end_where_a_law_of_time_has_a_kink():
    """The ledger closes to 1e-12 at rtol 1e-6: no step crosses the end of the run-up, which lies
    between samples; stepped over it was off by 2e-5. No step is refused.

    A kink at the end of the run leaves the right torque there, that of the ramp's end.
    """
    scene = cl.load_case("slider_crank", model="ideal")
    motion = cl.ramp(speed=SPEED, duration=0.1234)
    driven = cl.Scene(*scene.joints, cl.Drive(scene.drives[0].target, motion=motion))
    assert driven.kinks == [0.1234]
    run = cl.simulate(driven, until=0.3, samples=301, error=None)
    assert run.solver["energy_residual_share"] < 1e-12
    assert run.solver["rejected"] == 0
    ends = cl.simulate(driven, until=0.1234, samples=101, error=None)
    assert ends.complete
    assert ends.time[-1] == 0.1234
    assert ends.solver["energy_residual_share"] < 1e-12


def test_extremes_see_both_sides_of_a_kink():
    """The torque of a disc falls from I w / t_r to 0 at the end of its run-up: largest before it,
    smallest from there on, to rounding."""
    disc = cl.Body("disc", 1.0, INERTIA)
    axle = cl.Revolute(cl.ground, disc, name="axle")
    drive = cl.Drive(disc, motion=cl.ramp(speed=50.0, duration=0.21), name="D")
    run = cl.simulate(cl.Scene(axle, drive), until=0.4, samples=5, error=None)
    assert run.drive("D").torque[2] == pytest.approx(INERTIA * 50.0 / 0.21, rel=1e-12)
    assert run.drive("D").torque[3] == pytest.approx(0.0, abs=1e-12)


def test_a_law_of_yours_declares_its_kinks():
    """A run-up of a motor's voltage and a law of a user; a run-up of no length has none."""
    corner.kinks = lambda values: [values["rise"]]
    disc = cl.Body("disc", 1.0, INERTIA)
    motor = cl.dc_motor(voltage=24.0, resistance=1.0, inductance=1e-3, constant=0.1, run_up=0.05)
    axle = cl.Revolute(cl.ground, disc, name="axle")
    push = cl.Torque(disc, torque=corner(rise=0.02))
    assert cl.Scene(axle, cl.Drive(disc, torque=motor), push).kinks == [0.02, 0.05]
    assert rotor(motor.replaced(run_up=0.0)).kinks == []
    run = cl.simulate(cl.Scene(axle, push), until=0.1, samples=11, rtol=1e-10)
    wanted = np.maximum(run.time - 0.02, 0.0) ** 2 / (2.0 * INERTIA)
    assert run["disc"].omega == pytest.approx(wanted, abs=1e-10)


@pytest.fixture(scope="module")
def run():
    """Six nominal turns of the slider-crank on a motor line that runs beyond them."""
    return cl.simulate(slider_crank(LAWS["motor"]), turns=6)


class TestTurns:
    """Numbers that are counted in turns follow the angle."""

    def test_length(self, run):
        """The run and its samples are those of the nominal speed."""
        assert run.time[-1] == pytest.approx(6.0 * 2.0 * math.pi / SPEED)
        assert run.time.size == 6 * 400 + 1

    def test_angle(self, run):
        """Turns are the crank's angle; their times are those of complete angles, to 1e-6 rad."""
        assert run.turns_at(run.time) == pytest.approx(
            run["crank"].theta / (2.0 * math.pi), abs=1e-13
        )
        times = run.time_at(np.arange(1.0, 7.0))
        spline = np.interp(times, run.time, run["crank"].theta)
        assert spline == pytest.approx(2.0 * math.pi * np.arange(1.0, 7.0), abs=2e-4)

    def test_sections(self, run):
        """A section at 1 rad: the cosine of the slider's position there, 1e-7 of the crank
        (1e-9).
        """
        from clearance.postprocess.sections import section

        assert len(section_times(run, 1.0, 1.0)) == 6  # from turn 1.16 to 6.16
        x = section(run, "slider.x", 1.0, 1.0)
        wanted = 0.05 * math.cos(1.0) + math.sqrt(0.12**2 - (0.05 * math.sin(1.0)) ** 2)
        assert x == pytest.approx(wanted, abs=0.05 * 1e-7)

    def test_metrics(self, run):
        """Full turns after the first; the largest torque in them is that of the samples there,
        1e-4.
        """
        actual = metrics(run)
        times = run.time_at(np.array([1.0, 6.0]))
        inside = (run.time >= times[0]) & (run.time <= times[1])
        torque = run.drive("crank").torque[inside]
        assert actual["drive_crank_torque_max"].value == pytest.approx(torque.max(), rel=1e-4)

    def test_last(self, run):
        """The last complete turn by its angle: from 5 to 6 of 6.4 turns, drawn from 0 to 360
        degrees.
        """
        angle, actual, label = abscissa(run, "angle", last=1.0)
        assert label == "crank angle [deg]"
        assert 0.0 <= angle[0] < 1.0 < 358.5 < angle[-1] <= 360.0 + 1e-6
        assert run.turns_at(run.time[actual][0]) == pytest.approx(5.0, abs=0.01)

    def test_period(self):
        """A lubricated journal behind a PI comes back every turn of the angle, though the speed
        ripples by 5 %.
        """
        scene = cl.load_case(
            "slider_crank", model="lubricated", film="pinkus_sternlicht", speed=SPEED, drive="pi"
        )
        result = cl.simulate(scene, turns=16, samples_per_turn=100)
        assert np.ptp(result["crank"].omega[800:]) > 0.05 * SPEED
        actual = metrics(result, settle=11)
        assert actual["period"].value == 1.0
        assert actual["period_error"].value < 1e-3

    def test_even_speed_is_a_constant_speed(self):
        """A free disc at its nominal speed, either way round: turns, times and sections of the
        constant speed.
        """
        for speed in (SPEED, -SPEED):
            more = {"start": 0.2, "speed_start": speed, "nominal": speed}
            free = cl.simulate(rotor(0.0, **more), turns=3)
            disc = cl.Body("disc", 1.0, INERTIA)
            drive = cl.Drive(disc, speed=speed, start=0.2)
            even = cl.simulate(cl.Scene(cl.Revolute(cl.ground, disc, name="axle"), drive), turns=3)
            turns = np.array([0.0, 0.7, 2.3])
            assert free.time_at(turns) == pytest.approx(even.time_at(turns), abs=1e-9 * even.turn)
            assert free.turn == even.turn
            sections = (section_times(r, 1.0, 0.0) for r in (free, even))
            np.testing.assert_allclose(*sections, atol=1e-9 * even.turn)

    def test_without_a_nominal_speed(self):
        """No turns, no output of them, no number of them in the kernels."""
        scene = rotor(LAWS["motor"])
        assert scene.turn is None
        mechanism = build(scene)
        assert not any(
            "turn" in name for name in (*mechanism.layout.parameters, *mechanism.layout.output)
        )


@pytest.mark.parametrize("case", few_of(["slider_crank", "four_bar", "six_bar_feeder"], 1))
@pytest.mark.parametrize("drive", ["pi", "motor", "kloss", "dc"])
def test_cases(case, drive):
    """Each word drives each case: near the speed requested (2 %), within 20 % at all times, the
    ledger closed.
    """
    scene = cl.load_case(case, model="ideal", drive=drive)
    result = cl.simulate(scene, turns=3, samples_per_turn=100)
    ratio = result["crank"].omega / scene.loads[-1].nominal
    assert ratio[100:].mean() == pytest.approx(1.0, abs=0.02)
    assert 0.8 < ratio[100:].min() < ratio[100:].max() < 1.2
    assert result.solver["energy_residual_share"] < 1e-5


class TestWords:
    def test_guide(self):
        """The guide's drive: its natural current is that at rest."""
        scope = {"cl": cl, "crank": cl.Body("crank", 1.0, INERTIA)}
        exec(block("cl.dc_motor("), scope)
        (current,) = scope["drive"].states()
        assert (current.name, current.unit, current.size) == ("current", "A", 24.0 / 0.5)
        assert scope["drive"].turn == pytest.approx(0.1)

    def test_parameters(self):
        """Numbers in the text are those of the law; a run-up starts at rest."""
        scene = cl.load_case("slider_crank", model="ideal", drive="motor(stall=5, no_load=69)")
        assert scene.loads[0].torque == cl.motor_line(stall=5.0, no_load=69.0)
        scene = cl.load_case("slider_crank", model="ideal", drive="pi(run_up=0.1)")
        assert scene.loads[0].speed_start == 0.0

    def test_speed_is_the_scene_as_before(self):
        """A case without options of a motor has its drive of constant speed."""
        scene = cl.load_case("four_bar")
        assert scene.loads[0] == cl.Drive(scene.bodies[0], speed=cl.rpm(300), start=0.0)

    @pytest.mark.parametrize(
        ("values", "line"),
        [
            ({"drive": "moter"}, "drive must be one of .* \\(did you mean motor\\?\\)"),
            ({"drive": "motor(torque=5)"}, "motor_line\\(stall, no_load\\): unknown torque"),
            ({"drive": "motor(stall=0)"}, "motor_line: stall must be positive"),
            ({"drive": "pi(limit=-1)"}, "pi_speed: limit must not be negative"),
            ({"drive": "pi", "speed": 0.0}, "drive pi: speed must not be 0"),
        ],
    )
    def test_errors(self, values, line):
        """Options that cannot be are refused by name."""
        with pytest.raises(ValueError, match=line):
            cl.load_case("slider_crank", model="ideal", **values)


class TestNominal:
    DISC = cl.Body("disc", 1.0, INERTIA)

    @pytest.mark.parametrize(
        ("values", "line"),
        [
            (
                {"speed": 5.0, "nominal": 5.0},
                "nominal=5.0: a drive with a constant speed takes no nominal speed",
            ),
            ({"torque": 1.0, "nominal": 0.0}, "nominal must not be 0"),
            ({"torque": 1.0, "nominal": math.nan}, "nominal must be finite"),
        ],
    )
    def test_errors(self, values, line):
        """Options that cannot be are refused by name."""
        with pytest.raises(ValueError, match=f"Drive disc: {line}"):
            cl.Drive(self.DISC, **values)

    def test_slides_have_none(self):
        """A drive that slides has no nominal speed."""
        slide = cl.Prismatic(cl.ground, self.DISC, name="slide")
        with pytest.raises(ValueError, match="a drive that slides takes no nominal speed"):
            cl.Drive(slide, force=1.0, nominal=3.0)
