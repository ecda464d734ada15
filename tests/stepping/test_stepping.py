"""Steppers and the loop: order, events against closed-form motions, failures that keep what they
had.
"""

import math
import random

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import clearance as cl
from clearance.run.options import METHODS
from clearance.simulation import SimulationError, prepare
from clearance.stepping import status
from tests import mechanisms as m
from tests.seeds import few_of


def pendulum():
    """A smooth scene with two free degrees of freedom."""
    return cl.load_case("double_pendulum", angle1=0.3, angle2=-0.2, damping=0.02)


def state(result, k=-1):
    return np.array(
        [result[b].__getattr__(c)[k] for b in ("upper", "lower") for c in ("theta", "omega")]
    )


def fixed_step_error(method, steps, reference):
    """Error at the end with (nearly) equal steps: no tolerance on the error, a tight one in Newton,
    a largest step.
    """
    from clearance.mechanism.build import build
    from clearance.run.options import Output, Solver, Span
    from clearance.run.run import Run
    from clearance.simulation import write

    run = Run(build(pendulum()), Span(1.0, 2), Solver(0.05, method))
    run.state.longest_step = run.state.step_size = 1.0 / steps
    run.state.rtol, run.state.newton_tolerance = 1e3, 1e-18
    result = write(run, Output())
    run_steps = result.solver["steps"]
    return np.abs(state(result) - reference).max(), run_steps


ORDERS = {  # as published
    "dop853": "Dormand and Prince, by Hairer 1993",
    "rodas5p": "Steinebach 2023",
    "radau5": "Hairer and Wanner 1996",
    "radau9": "Hairer and Wanner 1999",
}


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [
        ("dop853", 8, (48, 96)),
        ("rodas5p", 5, (80, 160)),
        ("radau5", 5, (40, 80)),
        ("radau9", 9, (48, 96)),
    ],
)
def test_order(method, order, steps, validated):
    """Observed order, from halved steps, at least the declared one less 0.5 (more is luck of this
    problem).
    """
    reference = state(cl.simulate(pendulum(), until=1.0, rtol=1e-13, samples=2))
    (e1, n1), (e2, n2) = (fixed_step_error(method, n, reference) for n in steps)
    actual = math.log(e1 / e2) / math.log(n2 / n1)
    assert actual < order + 1.5
    label = f"order of {method}, or more"
    validated(label, min(actual, order), order, 0.5, source=ORDERS[method], relative=False)


@pytest.mark.parametrize("method", METHODS)
def test_error_follows_the_tolerance(method):
    """Ten times the tolerance per digit, within a factor of 300 (global against local error)."""
    reference = state(cl.simulate(pendulum(), until=1.0, rtol=1e-13, samples=2))
    for rtol in (1e-5, 1e-8):
        actual = state(cl.simulate(pendulum(), until=1.0, rtol=rtol, samples=2, method=method))
        assert np.abs(actual - reference).max() < 300 * rtol


@pytest.mark.parametrize("method", METHODS)
def test_dense_output_agrees_with_steps(method):
    """Samples between steps lie on the solution: 1e-6 at rtol 1e-8."""
    coarse = cl.simulate(pendulum(), until=1.0, rtol=1e-8, samples=401, method=method)
    fine = cl.simulate(pendulum(), until=1.0, rtol=1e-12, samples=401)
    assert np.abs(coarse["lower"].theta - fine["lower"].theta).max() < 1e-6


def ball(restitution=1.0, clearance=1e-3, stiffness=1e8, mass=0.5, gravity=(0.0, -9.81), **more):
    """A journal falling freely inside a fixed bearing."""
    body = cl.Body("ball", mass, 1e-4)
    joint = m.dry(
        cl.ground.at(0.2, 0.3), body.at(0, 0), "J", clearance, stiffness, restitution, **more
    )
    return cl.Scene(joint, gravity=gravity)


def at_rest(eccentricity, mass, clearance, modulus, load):
    """A journal that a load presses into a bearing with a foundation."""
    body = cl.Body("journal", mass, 1e-4)
    joint = cl.ClearanceRevolute(
        cl.ground,
        body,
        name="B",
        radius=0.01,
        clearance=clearance,
        length=0.02,
        eccentricity=(eccentricity, 0.0),
        contact=cl.winkler(layer_modulus=modulus, restitution=0.5),
    )
    drive = cl.Drive(body, speed=2.0 * math.pi, name="d")
    return cl.Scene(joint, cl.Force(body.at(0, 0), x=load), drive, gravity=(0, 0))


@pytest.mark.parametrize("seed", few_of(range(4), 1))
def test_a_journal_at_rest_feels_no_peak_of_force(seed):
    """Largest contact force within 1e-4 of the load, at rtol 1e-6. Its steps end on the spot, so
    that they grow far beyond the limit of stability; within them dense output had peaks of up to
    6000 times the load, as rounding would have it. Ten random journals each.
    """
    rng = np.random.default_rng(seed)
    for _ in range(10):
        modulus, load, mass = 10.0 ** rng.uniform((10.0, 1.0, -1.5), (13.0, 4.0, 0.5))
        numbers = {"mass": mass, "modulus": modulus, "load": load}
        numbers["clearance"] = 10.0 ** rng.uniform(-4.5, -3.3)
        scene = at_rest(1.05 * numbers["clearance"], **numbers)
        settled = cl.simulate(scene, until=1.0, samples=3, error=None).joint("B").eccentricity_x[-1]
        run = cl.simulate(at_rest(float(settled), **numbers), until=1.0, samples=361, error=None)
        assert run.extreme("joints/B/force_max").value == pytest.approx(load, rel=1e-4)


def test_fall_time_and_impact_speed(validated):
    """Free fall through the clearance: t = sqrt(2 c / g), v = sqrt(2 g c); 1e-12, the located
    event's promise.
    """
    c, g = 1e-3, 9.81
    result = cl.simulate(ball(), until=0.05, rtol=1e-8)
    time, speed, options = (
        result.events["time"][0],
        result.events["impact_speed"][0],
        {"kind": "exact"},
    )
    validated(
        "time of a free fall",
        time,
        math.sqrt(2 * c / g),
        1e-12,
        unit="s",
        source="sqrt(2 c / g)",
        **options,
    )
    validated(
        "its impact speed",
        speed,
        math.sqrt(2 * g * c),
        1e-12,
        unit="m/s",
        source="sqrt(2 g c)",
        **options,
    )


def test_hertz_impact_without_gravity(validated):
    """Penetration (5 m v^2 / 4 K)^0.4, duration 2.9432 penetration / v, force K delta^1.5;
    elastic.
    """
    v, mass, stiffness = 0.3, 0.5, 1e8
    scene = ball(stiffness=stiffness, mass=mass, gravity=(0.0, 0.0), eccentricity_rate=(v, 0.0))
    events = cl.simulate(scene, until=0.01, rtol=1e-11).events
    depth = (1.25 * mass * v**2 / stiffness) ** 0.4
    for column, wanted, tolerance, unit in (
        ("impact_speed", v, 1e-12, "m/s"),
        ("peak_penetration", depth, 1e-9, "m"),
        ("peak_force", stiffness * depth**1.5, 1e-9, "N"),
        ("duration", 2.94326 * depth / v, 1e-5, "s"),
        ("separation_speed", v, 1e-9, "m/s"),
    ):
        options = {"unit": unit, "source": "Hertz' elastic impact", "kind": "exact"}
        validated(column.replace("_", " "), events[column][0], wanted, tolerance, **options)


def test_impacts_are_neither_missed_nor_counted_twice(validated):
    """Without gravity and friction an elastic ball crosses the clearance in equal flights: the
    count is known.
    """
    v, c = 0.3, 1e-3
    scene = ball(gravity=(0.0, 0.0), clearance=c, eccentricity_rate=(v, 0.0))
    events = cl.simulate(scene, until=0.5, rtol=1e-9).events
    first, duration = c / v, events["duration"][0]
    period = 2 * c / v + duration
    expected = math.floor((0.5 - first) / period) + 1
    options = {"source": "equal flights of an elastic ball", "kind": "exact"}
    validated("number of impacts", len(events["time"]), expected, 0.0, **options)
    validated("time between impacts", np.diff(events["time"]), period, 1e-6, unit="s", **options)


def thrown(depth):
    """Time of rise, and contacts, of a ball thrown up to a depth in the wall [m]."""
    g, c = 9.81, 1e-3
    speed = math.sqrt(2 * g * (c + depth))
    scene = ball(clearance=c, eccentricity_rate=(0.0, speed))
    return speed / g, cl.simulate(scene, until=speed / g * 1.5, rtol=1e-6).events


@pytest.mark.parametrize("depth", [1e-6, 1e-8, 1e-10])
def test_grazing_contact_is_found(depth):
    """A ball that would pass its turning point `depth` beyond the wall touches it, however large
    the step could be.
    """
    rise, events = thrown(depth)
    assert len(events["time"]) == 1
    assert events["time"][0] < rise

    assert 0.1 * depth < events["peak_penetration"][0] < depth


def test_a_near_miss_is_no_contact():
    """A ball that turns a nanometre before the wall does not touch it."""
    assert len(thrown(-1e-9)[1]["time"]) == 0


@given(
    speed=st.floats(1e-3, 3.0),
    angle=st.floats(0.0, 2.0 * math.pi),
    tolerance=st.floats(3.0, 10.0),
    gravity=st.floats(0.01, 20.0),
)
@settings(max_examples=40, deadline=None)
def test_first_touch_is_where_it_must_be(speed, angle, tolerance, gravity):
    """A throw across the clearance meets the circle at the root of a quartic, whatever tolerance
    and direction: within 1e-12 of the time, with a penetration within the dead band (1e-13 c).
    """
    c, vx, vy = 1e-3, speed * math.cos(angle), speed * math.sin(angle)
    scene = ball(gravity=(0.0, -gravity), clearance=c, eccentricity_rate=(vx, vy))
    pull = gravity * c / speed**2
    # time over c / speed
    roots = np.roots([pull**2 / 4.0, -pull * math.sin(angle), 1.0, 0.0, -1.0])
    real = roots[np.abs(roots.imag) < 1e-6].real
    first = min(r for r in real if r > 0.0) * c / speed
    for _ in range(3):  # the quartic's roots are right to 1e-10 only
        x, y = vx * first, vy * first - 0.5 * gravity * first**2
        slope = 2.0 * (x * vx + y * (vy - gravity * first))
        first -= (x * x + y * y - c * c) / slope
    assume(slope > 1e-3 * c * speed)
    events = cl.simulate(scene, until=1.5 * first, rtol=10.0**-tolerance).events
    assert len(events["time"]) >= 1
    assert events["time"][0] == pytest.approx(first, rel=1e-12)


def advanced(scene, until, rtol, step):
    """All states in which a contact has just begun or ended, one trial step at a time."""
    from clearance.mechanism.build import build
    from clearance.run.options import Solver, Span
    from clearance.run.run import Run
    from clearance.stepping.state import TOUCHING

    run = Run(build(scene), Span(until, 2), Solver(rtol, "dop853"))
    state, actual, touching = run.state, [], np.zeros(len(run.state.contacts))
    monitor = run.mechanism.kernel("events")
    values = np.zeros(3 * len(state.contacts))
    while step(run) == 0:
        now = state.contacts[:, TOUCHING].copy()
        if (now != touching).any():
            monitor(state.time, state.y, run.mechanism.par, state.work, values)
            actual.append((state.time, np.flatnonzero(now != touching), now, values.copy()))
        touching = now
    return actual, run


def test_contacts_begin_and_end_within_the_dead_band(monkeypatch):
    """Every change of phase lies on the wall to the dead band; while a joint is free its law sees
    no penetration.
    """
    from clearance.run import run as running

    monkeypatch.setattr(running, "BUDGET", 1)
    scene = cl.load_case("six_bar_feeder", model="dry", joints="B,C,E")
    actual, run = advanced(scene, 0.25 * scene.turn, 1e-5, lambda run: run.advance())
    assert len(actual) > 50
    for _, joints, _, values in actual:
        for j in joints:
            assert abs(values[2 * j]) <= run.state.band[j]


def test_restarts_keep_the_order():
    """A falling ball, after several impacts: errors stay below four times the tolerance, from 1e-5
    to 1e-9 (a restart of low order would leave 1e-6 or so at any). Some are three times as large.
    """
    scene, until, errors = ball(restitution=0.9, eccentricity_rate=(0.02, 0.0)), 0.12, []
    exact = cl.simulate(scene, until=until, rtol=1e-13, samples=2)
    for rtol in (1e-5, 1e-7, 1e-9):
        result = cl.simulate(scene, until=until, rtol=rtol, samples=2)
        assert len(exact.events["time"]) == len(result.events["time"]) > 5
        e = [getattr(result.joint("J"), n)[-1] - getattr(exact.joint("J"), n)[-1] for n in EXY]
        errors.append(math.hypot(*e) / 1e-3)
        assert errors[-1] < 4 * rtol
    assert errors[2] < errors[0] / 20


def replayed(run, before, time, memory):
    """Error over tolerance of the last step, against scipy's DOP853 at 1e-13 from the state
    before.
    """
    rhs = run.mechanism.kernel("rhs")

    def slopes(t, y):
        out = np.zeros_like(y)
        rhs(t, np.ascontiguousarray(y), run.mechanism.par, memory, out)
        return out

    now, size = run.state.time, run.mechanism.size
    fine = solve_ivp(
        slopes,
        (time, now),
        before,
        method="DOP853",
        rtol=1e-13,
        atol=1e-22,
        max_step=(now - time) / 4,
    )
    tolerance = run.solver.rtol * (run.state.scale + np.abs(run.state.y))
    return (np.abs(fine.y[:, -1] - run.state.y) / tolerance)[:size].max()


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_R4_clock_and_state_stay_together_where_contacts_graze(rtol, monkeypatch):
    """A ball that rests on its bearing comes back to a penetration of 1e-16 to 1e-9 m: its contact
    ends, or just not.

    Every step that begins or ends a contact agrees with an independent integration to the
    tolerance; a clock that parts from its state is off by 1e4 of it.
    """
    from clearance.mechanism.build import build
    from clearance.run import run as running
    from clearance.run.options import Solver, Span
    from clearance.stepping.state import TOUCHING

    monkeypatch.setattr(running, "BUDGET", 1)
    changes = 0
    for depth in np.logspace(-16, -9, 29):
        scene = ball(eccentricity=(0.0, -(1e-3 + depth)))
        run = running.Run(build(scene), Span(0.02, 2), Solver(rtol, "dop853"))
        state, code = run.state, 0
        while code == 0:
            before, time, memory = state.y.copy(), state.time, state.work.copy()
            touching = state.contacts[0, TOUCHING]
            code = run.advance()
            if state.contacts[0, TOUCHING] != touching and state.time > time:
                assert replayed(run, before, time, memory) < 1.0, (depth, time)
                changes += 1
    assert changes > 20


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_M1_contacts_that_change_at_nearly_the_same_instant(every):
    """Two equal journals whose clearances differ by 1e-16 to 1e-14 of themselves: all runs finish.

    They touch 1e-19 to 1e-17 s apart. A phase that began with such a step would end the run at its
    next contact.
    """

    def hung(i, clearance):
        bob = cl.Body(f"b{i}", 1.0, 1e-3, points={"p": (0, 0)})
        law = cl.lankarani_nikravesh(stiffness=1e9, restitution=0.9, exponent=1.5)
        hook = cl.ground.at(i, 0)
        joint = cl.ClearanceRevolute(
            hook, bob["p"], name=f"J{i}", radius=0.01, clearance=clearance, contact=law
        )
        return joint, cl.TorsionSpring(cl.ground, bob, stiffness=1.0, name=f"s{i}")

    for apart in 10.0 ** (-16.0 + np.arange(0, 60, every) / 30.0):
        for rtol in (1e-4, 1e-6, 1e-8):
            scene = cl.Scene(*hung(0, 1e-4), *hung(1, 1e-4 * (1.0 + apart)), name="twins")
            assert cl.simulate(scene, until=0.05, samples=11, rtol=rtol).complete


EXY = ("eccentricity_x", "eccentricity_y")


def braced(damping):
    """An arm held by one spring and damper."""
    arm = cl.Body("arm", 1.0, 0.01, points={"o": (0, 0), "p": (0.2, 0)}, com=(0.1, 0), angle=-0.3)
    strut = cl.SpringDamper(
        cl.ground.at(0.2, 0.3), arm["p"], stiffness=1e3, damping=damping, free_length=0.3
    )
    return cl.Scene(cl.Revolute(cl.ground, arm["o"], name="o"), strut)


@pytest.mark.parametrize("damping", [1e6, 1e9])
def test_a_stiff_scene_without_film_goes_on_implicitly(damping):
    """The explicit choice notices that stability holds it up; both parts together are one run."""
    result = cl.simulate(braced(damping), until=2.0)
    assert result.solver["method"] == "dop853, radau5"
    assert "stiff, so implicit from t = " in result.solver["method_reason"]
    assert result.solver["steps"] < 1000
    exact = cl.simulate(braced(damping), until=2.0, method="radau9", rtol=1e-11)
    assert np.abs(result["arm"].theta - exact["arm"].theta).max() < 1e-6


def test_a_forced_explicit_method_is_kept_and_warned_about():
    """A stiff run with dop853 keeps it, with a warning."""
    result = cl.simulate(braced(1e5), until=0.02, method="dop853")
    assert result.solver["method"] == "dop853"
    assert any("held up by stability" in w for w in result.warnings)


def test_impacts_do_not_count_as_stiff():
    """A dry run stays with the explicit method."""
    result = cl.simulate(
        cl.load_case("six_bar_feeder", model="dry", joints="B,C"), turns=1, rtol=1e-6
    )
    assert result.solver["method"] == "dop853"


def test_a_micrometre_with_long_levers_keeps_its_digits():
    """Eccentricities are coordinates: with c = 1 um between 0.3 m levers two tight methods agree to
    1e-9 of c, although positions are rounded to 5e-17 m = 5e-11 c each.
    """
    scene = cl.load_case("six_bar_feeder", joints="B,C,E", clearance=1e-6)
    a, b = (
        cl.simulate(scene, turns=0.5, rtol=r, method=m)
        for r, m in ((1e-12, "radau9"), (1e-11, "radau5"))
    )
    for joint in "BCE":
        assert (
            np.abs(a.joint(joint).eccentricity_x - b.joint(joint).eccentricity_x).max()
            < 1e-9 * 1e-6
        )


def test_forces_of_very_thick_films_are_right():
    """With a film thousands of times stiffer than the motion needs, joint forces still converge:
    1e-3 at 1e-6.

    (Their natural rate is acceleration over damping; clearance times speed would leave the force
    wrong by 10 %.)
    """
    scene = cl.load_case(
        "four_bar", model="lubricated", viscosity=10.0, speed=cl.rpm(30), clearance=1e-6
    )
    exact, actual = (cl.simulate(scene, turns=1, rtol=r).joint("C") for r in (1e-11, 1e-6))
    size = np.abs(exact.force_x[20:]).max()
    assert np.abs(exact.force_x - actual.force_x)[20:].max() < 1e-3 * size


def test_stiff_and_explicit_methods_agree_in_a_film():
    """Forced methods solve the same equations: 1e-6 of the clearance at rtol 1e-9; the explicit one
    is warned about.
    """
    scene = cl.load_case("slider_crank", model="lubricated")
    actual = {m: cl.simulate(scene, turns=0.2, rtol=1e-9, method=m) for m in METHODS}
    for result in actual.values():
        apart = np.abs(
            result.joint("C").eccentricity_x - actual["radau9"].joint("C").eccentricity_x
        ).max()
        assert apart < 1e-6 * 0.5e-3
    assert any("explicit" in w for w in actual["dop853"].warnings)
    assert "asked for" in actual["dop853"].solver["method_reason"]


@pytest.mark.parametrize(
    ("rtol", "method"), [(1e-3, "rodas5p"), (1e-5, "radau5"), (1e-9, "radau9")]
)
def test_the_choice_says_why(rtol, method):
    """The method follows from the tolerance, with its reason."""
    result = cl.simulate(cl.load_case("slider_crank", model="lubricated"), turns=0.05, rtol=rtol)
    assert result.solver["method"] == method
    assert "film of joint C" in result.solver["method_reason"]


def test_two_joints_touch_in_one_step():
    """Two bearings of one rigid bar: falling together; the second joint's eccentricity follows from
    the first's.
    """
    bar = cl.Body("bar", 1.0, 0.01)
    joints = [
        m.dry(cl.ground.at(x, 0), bar.at(x, 0), n, 1e-3, 1e8, 1.0)
        for x, n in ((-0.1, "L"), (0.1, "R"))
    ]
    events = cl.simulate(cl.Scene(*joints), until=0.02, rtol=1e-8).events
    assert sorted(events["joint"][:2]) == ["L", "R"]
    assert events["time"][0] == pytest.approx(events["time"][1], rel=1e-9)


def test_a_contact_at_the_start_counts():
    """A start in touch is an event at zero."""
    events = cl.simulate(ball(eccentricity=(0.0, -1.01e-3)), until=0.002).events
    assert events["time"][0] == 0.0


def test_start_in_an_open_contact_is_recorded_as_open():
    """A contact at the end is open, with finite numbers."""
    events = cl.simulate(ball(eccentricity=(0.0, -1.01e-3)), until=1e-6).events
    assert list(events["kind"]) == ["open_contact"]
    assert np.isfinite(events["duration"]).all()


def test_dry_joint_beside_a_film_uses_the_implicit_method_with_events():
    """Film and impacts in one run: implicit, with events, ledger 1e-4."""
    scene = m.watt(
        lambda n, a, b: (
            m.film(a, b, n)
            if n == "C"
            else m.dry(a, b, n)
            if n == "E"
            else cl.Revolute(a, b, name=n)
        )
    )
    result = cl.simulate(scene, turns=0.5, rtol=1e-6)
    assert result.solver["method"] == "radau5"
    assert len(result.events["time"]) > 0
    assert result.solver["energy_residual_share"] < 1e-4


def overloaded():
    """A film too thin for its load: a heavy journal in a nearly inviscid bearing."""
    body = cl.Body("journal", 50.0, 1e-2)
    joint = m.film(cl.ground.at(0, 0), body.at(0, 0), "J", viscosity=1e-12)
    return cl.Scene(joint, cl.Torque(body, 0.0))


def test_failure_names_time_joint_and_state_and_keeps_the_rest():
    """A failure names its place; the result has the rows before it."""
    with pytest.raises(
        SimulationError, match=r"at t = .* s: joint J: .*eccentricity ratio"
    ) as caught:
        cl.simulate(overloaded(), until=1.0, samples=1001)
    result = caught.value.result
    assert result.status.startswith("partial: at t = ")
    assert 0 < result.time.size < 1001
    assert all(np.isfinite(result.joint("J").gap))


def test_step_limit_is_a_named_failure():
    """Too many steps end a run by name."""
    with pytest.raises(SimulationError, match="step limit"):
        cl.simulate(pendulum(), until=10.0, max_steps=5)


def test_leaving_the_reachable_positions_is_a_named_failure():
    """A prescribed drive pushes a double rocker past its limit."""
    crank, coupler = m.bar("crank", 0.2, 1.2), m.bar("coupler", 0.15, 0.1)
    hinges = m.loop(crank, coupler, m.bar("rocker", 0.2, 1.6), 0.3)
    scene = cl.Scene(*hinges, cl.Drive(crank, speed=1.0))

    with pytest.raises(SimulationError, match="at t = ") as caught:
        cl.simulate(scene, until=10.0, samples=1001)
    assert 10 < caught.value.result.time.size < 1001


@pytest.mark.parametrize("ratio", [0.0, 0.5, 0.9999])
def test_start_eccentricity(ratio):
    """The run starts at the stated eccentricity."""
    scene = m.watt(m.chooser(m.film, "C", eccentricity=(ratio * 1e-4, 0.0)))
    result = cl.simulate(scene, turns=0.25)
    assert result.joint("C").eccentricity[0] == pytest.approx([ratio * 1e-4, 0.0], abs=1e-16)
    assert np.isfinite(result.joint("C").force).all()


@pytest.mark.parametrize(
    "seeds", [range(3), pytest.param(range(3, 60), marks=pytest.mark.slow)], ids=["3", "rest"]
)
def test_ranges8_no_step_passes_over_a_reversal_of_friction(seeds):
    """Friction that turns round within a narrow range of speeds: at most 100 tolerances of energy
    are missing.

    The range is 1e-5 to 1e-3 m/s wide, in joints and guides that slide with up to 10 m/s. Newton's
    method ended there without a look at its last stages: up to 1100 tolerances were missing.
    """
    for seed in seeds:
        rng = random.Random(f"reversal {seed}")
        law = rng.choice(["coulomb", "coulomb_tanh", "coulomb_viscous"])
        width, mu = 10.0 ** rng.uniform(-5.0, -3.0), 10.0 ** rng.uniform(-1.0, -0.3)
        numbers = f"coefficient={mu}, transition_speed={width}"
        viscous = ", viscous=1e-3" if law == "coulomb_viscous" else ""
        case, joints = rng.choice([("slider_crank", "C"), ("six_bar_feeder", "B,E")])
        speed = 10.0 ** rng.uniform(2.0, 2.7) / (1.0 if joints == "C" else 10.0)
        scene = cl.load_case(
            case, model="dry", joints=joints, friction=f"{law}({numbers}{viscous})", speed=speed,
            clearance=10.0 ** rng.uniform(-4.0, -3.0), restitution=rng.uniform(0.3, 0.9),
        )  # fmt: skip
        rtol, method = 10.0 ** rng.uniform(-7.0, -5.0), rng.choice(["auto", "radau5", "radau9"])
        run = cl.simulate(scene, turns=3, rtol=rtol, method=method, error=None)
        share = run.solver["energy_residual_share"] / rtol
        assert share < 100.0, f"seed {seed}: {share:.3g} tolerances of the energy are missing"


def test_the_last_step_ends_at_the_end():
    """t + (end - t) may round to below the end. The rest was a step that the clock does not have,
    and a run that went on from there failed.
    """
    rotor = cl.Body("rotor", 1.0, 0.1)
    scene = cl.Scene(cl.Revolute(cl.ground, rotor, name="A"), cl.Torque(rotor, 0.3), name="rotor")
    rng = np.random.default_rng(7)
    pairs = (rng.uniform([0.1, 0.5], [0.4, 1.0]) for _ in range(1000))
    below = [(t, end) for t, end in pairs if t + (end - t) < end]
    assert below
    for t, end in below[:20]:
        run = prepare(scene, until=2.0, samples=2)
        run.advance_to(t)
        run.state.longest_step = run.state.step_size = math.inf
        before = run.state.steps
        assert run.advance_to(end) == status.DONE
        assert run.state.steps == before + 1
        assert run.state.time == end
        assert run.advance_to(2.0) == status.DONE


@pytest.mark.parametrize("seed", range(3))
def test_first_steps_of_a_phase_are_those_that_the_clock_resolves(seed):
    """A phase begins with the first step of the last such phase. That may be one of the start,
    where the clock is finer.
    """
    rng = np.random.default_rng(seed)
    scene = cl.load_case("slider_crank", model="dry", clearance=10.0 ** rng.uniform(-5, -3.3))
    run = prepare(scene, turns=1.0, samples=11)
    begin = float(rng.uniform(0.01, 0.05)) * scene.turn
    run.advance_to(begin)
    run.state.free_step = run.state.contact_step = 1e-20 * begin
    before = run.contact_count
    assert run.advance_to(scene.turn) == status.DONE
    assert run.contact_count > before
