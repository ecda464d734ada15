"""Branches of periodic motions against a pendulum with a fold in closed form, and the
slider-crank's fold.
"""

import csv
import math

import numpy as np
import pytest

import clearance as cl
from clearance.motions import branch_file

DAMPING, SPEED = 0.5, 4.0
CASE = f'''
import clearance as cl


def scene(*, torque: float = 0.5, length: int = 1) -> cl.Scene:
    """A pendulum of unit weight and inertia that a torque holds aside, beside a body that turns.

    torque: on the pendulum [N m]
    length: not used [-]
    """
    pivot = {{"pivot": (0, 0)}}
    bob = cl.Body("bob", mass=1.0, inertia=0.75, points=pivot, com=(0, -0.5), angle=0.2)
    rotor = cl.Body("rotor", mass=1.0, inertia=1.0, points=pivot)
    return cl.Scene(
        cl.Revolute(cl.ground, bob["pivot"], name="pivot"),
        cl.Revolute(cl.ground, rotor["pivot"], name="shaft"),
        cl.TorsionSpring(cl.ground, bob, damping={DAMPING}),
        cl.Torque(bob, torque),
        cl.Drive(rotor, speed={SPEED}),
        gravity=(0, -2.0),
        name="held_pendulum",
    )
'''


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    path = tmp_path_factory.mktemp("case") / "held_pendulum.py"
    path.write_text(CASE)
    return path


@pytest.fixture(scope="module")
def branch(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("branch")
    return cl.follow(
        case, "torque", 0.5, 1.2, channels=["bodies/bob/theta"], path=folder, step=0.1
    ), folder


class TestPendulum:
    """theta'' + c theta' + sin theta = T rests at sin theta = T, stable and unstable, which meet
    at T = 1.
    """

    def test_the_fold(self, branch, validated):
        """T = 1. It is located where the parameter has a share of 1e-3 in the tangent: 1e-6 in
        T.
        """
        (fold,) = branch[0].folds
        validated(
            "torque at which a pendulum falls",
            fold,
            1.0,
            1e-5,
            unit="N m",
            source="closed form",
            kind="exact",
        )

    def test_both_branches_and_their_multipliers(self, branch):
        """sin theta = T to 1e-6, and exp(s t), s^2 + c s + cos theta = 0, to 1e-4 of the
        largest.
        """
        period = 2.0 * math.pi / SPEED
        for point in branch[0].points:
            angle = point.outputs[0, 0]
            assert math.sin(angle) == pytest.approx(point.value, abs=1e-6)
            exact = np.exp(period * np.roots([1.0, DAMPING, math.cos(angle)]))
            exact = exact[np.lexsort((-exact.imag, -np.abs(exact)))]
            assert np.abs(point.multipliers - exact).max() < 1e-4 * np.abs(exact).max()
            assert (point.errors < 1e-3 * np.abs(exact).max()).all()
            if not point.kind:
                assert point.decided
                assert point.stable == (angle < 0.5 * math.pi)

    def test_coexisting_motions(self, branch):
        """Between the folds there are two motions, one of them stable."""
        ((low, high, motions, stable),) = branch[0].coexisting
        assert (low, high) == pytest.approx((0.5, 1.0), abs=1e-5)
        assert (motions, stable) == (2, 1)
        assert branch[0].reason == "the parameter left its range"

    def test_files(self, branch):
        """The table has a row for each point, and HDF5 the same columns."""
        met, folder = branch
        with (folder / "follow.csv").open() as file:
            rows = list(csv.reader(file))
        assert rows[0][0] == "torque [N m]"
        assert [float(row[0]) for row in rows[1:]] == met.values.tolist()
        assert sum(row[1] == "fold" for row in rows) == 1
        column = rows[0].index("multiplier_1_error [1]")
        assert [float(row[column]) for row in rows[1:]] == [p.errors[0] for p in met.points]
        assert [p.errors.tolist() for p in branch_file.points(folder)] == [
            p.errors.tolist() for p in met.points
        ]
        assert (folder / "follow.h5").exists()


SHAKEN = '''
import math

import clearance as cl


def scene(*, speed: float = 10.0, damping: float = 0.02) -> cl.Scene:
    """A pendulum on a slider that a crank moves up and down.

    speed: of the crank [rad/s]
    damping: of the pendulum [N m s]
    """
    up = math.pi / 2
    crank = cl.Body("crank", 1.0, 1e-3, points={"shaft": (0, 0), "pin": (0.05, 0)}, angle=up)
    rod = cl.Body("rod", 0.1, 1e-3, points={"pin": (0, 0), "end": (0.3, 0)}, angle=up)
    slider = cl.Body("slider", 0.1, 1e-5, points={"pin": (0, 0)})
    bob = cl.Body("bob", 1.0, 0.0025, points={"pin": (0, 0)}, com=(0, -0.25))
    return cl.Scene(
        cl.Revolute(cl.ground, crank["shaft"], name="A"),
        cl.Revolute(crank["pin"], rod["pin"], name="B"),
        cl.Revolute(rod["end"], slider["pin"], name="C"),
        cl.Prismatic(cl.ground, slider["pin"], axis=(0, 1), name="guide"),
        cl.Revolute(slider["pin"], bob["pin"], name="D"),
        cl.TorsionSpring(slider, bob, damping=damping),
        cl.Drive(crank, speed=speed, start=up),
        name="shaken_pendulum",
    )
'''


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    path = tmp_path_factory.mktemp("shaken") / "shaken.py"
    path.write_text(SHAKEN)
    return path


def shaken_branch(case, path=None, progress=None):
    return cl.follow(
        case,
        "speed",
        9.5,
        11.5,
        channels=["bodies/bob/theta"],
        step=0.1,
        points=30,
        doublings=1,
        path=path,
        progress=progress,
    )


@pytest.fixture(scope="module")
def met(shaken):
    return shaken_branch(shaken)


def hill(speed: float, damping: float = 0.02) -> np.ndarray:
    """Multipliers of the shaken pendulum at rest, whose equation is Hill's: (i + m l^2) phi'' = - c
    phi' - m l (g + y'') phi, with y of the slider.
    """
    from scipy.integrate import solve_ivp

    throw, rod, inertia, arm = 0.05, 0.3, 0.0025 + 0.25**2, 0.25

    def lift(angle):
        """y'' / speed^2 of y = r cos a + sqrt(l^2 - r^2 sin^2 a)."""
        s, c = throw * math.sin(angle), throw * math.cos(angle)
        root = math.sqrt(rod**2 - s * s)
        return -c - (c * c - s * s) / root - (s * c) ** 2 / root**3

    def rates(time, x):
        weight = arm * (9.81 + speed**2 * lift(speed * time))
        return [x[1], -(damping * x[1] + weight * x[0]) / inertia]

    turn = (0.0, 2.0 * math.pi / speed)
    return np.linalg.eigvals(
        np.array(
            [
                solve_ivp(rates, turn, start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
                for start in np.eye(2)
            ]
        ).T
    )


class TestDoubling:
    """A pendulum on a moved pivot: at rest until the shaking doubles its period."""

    def test_where_it_begins(self, met, validated):
        """Hill's equation has the multiplier -1 there, to 1e-5; 1e-6 of the speeds is located."""
        (born,) = met.bifurcations
        assert born.kind == "period doubling"
        validated(
            "multiplier of Hill's equation where a shaken pendulum doubles its period",
            float(hill(born.value).real.min()),
            -1.0,
            1e-5,
            unit="1",
            source="Hill's equation, integrated",
            kind="independent",
        )

    def test_motions_of_twice_the_period(self, met):
        """They swing to one side and to the other, by the same angle (1e-6); they are born where
        the period doubles, and grow towards lower speeds, unstable.
        """
        (born,), curve = met.bifurcations, [p for p in met.points if p.branch == 1]
        angles = np.array([p.outputs[:, 0] for p in curve])
        assert all(p.period == 2 for p in curve)
        assert angles[:, 0] == pytest.approx(-angles[:, 1], abs=1e-6)
        swing = np.abs(angles[:, 0])
        assert (np.diff(swing) > 0.0).all()
        assert swing[-1] > 1.0
        # near the doubling the speed falls with the square of the swing
        fall = (born.value - np.array([p.value for p in curve[:4]])) / swing[:4] ** 2
        assert fall == pytest.approx(fall[0], rel=0.02)
        assert not any(p.stable for p in curve)
        assert met.coexisting[0][2:] == (2, 1)

    @pytest.mark.slow
    def test_a_curve_between_two_doublings(self, shaken):
        """With more damping the curve turns in a fold, is stable from there on, and ends in the
        doubling at the upper end: it is followed once. Hill's equation has -1 at both (1e-5).
        """
        met = cl.follow(
            shaken, "speed", 8.0, 17.0, fixed={"damping": 0.1}, step=0.1, points=80, doublings=1
        )
        first, second, fold = met.bifurcations
        assert [p.kind for p in (first, second, fold)] == 2 * ["period doubling"] + ["fold"]
        for born in (first, second):
            assert hill(born.value, 0.1).real.min() == pytest.approx(-1.0, abs=1e-5)
        assert fold.value < first.value < second.value
        assert "it joins motions of half its period at 15.0" in met.reason
        curve = [p for p in met.points if p.branch]
        assert {p.branch for p in curve} == {1}
        assert abs(curve[-1].value - second.value) < 0.1 * 9.0
        after = [p.stable for p in curve[curve.index(fold) + 1 :]]
        assert all(after)
        assert [stretch[2:] for stretch in met.coexisting] == [(3, 2), (2, 1)]

    def test_it_goes_on_where_it_was_interrupted(self, met, shaken, tmp_path):
        """In the first curve and in the second: what was met stays, and the same is met in all."""

        def interrupt(at):
            def progress(text):
                if text.startswith(f"point {at} "):
                    raise KeyboardInterrupt

            return progress

        for at in (4, 25):
            with pytest.raises(KeyboardInterrupt):
                shaken_branch(shaken, tmp_path, interrupt(at))
            with (tmp_path / "follow.csv").open() as file:
                assert len(list(csv.reader(file))) == 1 + at
        stored = np.loadtxt(tmp_path / "follow.csv", delimiter=",", skiprows=1, usecols=0)
        again = shaken_branch(shaken, tmp_path)
        assert again.values[:25].tolist() == stored.tolist()
        (one,), (two,) = met.bifurcations, again.bifurcations
        assert two.value == pytest.approx(one.value, abs=1e-5)
        assert again.points[-1].value == pytest.approx(9.5, abs=1e-5)
        assert again.reason.startswith("the parameter left its range")
        assert max(p.branch for p in again.points) == 1

    def test_another_call_is_refused(self, shaken, tmp_path):
        """It would write over what was met before an interrupt."""

        def interrupt(text):
            if text.startswith("point 3 "):
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            shaken_branch(shaken, tmp_path, interrupt)
        with pytest.raises(ValueError, match="interrupted branch with other high, doublings"):
            cl.follow(
                shaken,
                "speed",
                9.5,
                11.0,
                channels=["bodies/bob/theta"],
                step=0.1,
                path=tmp_path,
            )


class TestSliderCrank:
    @pytest.mark.slow
    def test_the_fold(self, validated):
        """Runs settle at 3941.750 rpm and leave at 3941.757 rpm, after thousands of turns:
        within 0.01 rpm.
        """
        dry = {
            "model": "dry",
            "restitution": 0.9,
            "friction": "coulomb",
            "friction_coefficient": 0.03,
        }
        fixed = dry | {"clearance": 1e-3}
        met = cl.follow(
            "slider_crank", "speed", cl.rpm(3925), cl.rpm(3950), fixed=fixed, points=21, step=0.1
        )
        fold = met.folds[0] / cl.rpm(1)
        validated(
            "fold of the dry slider-crank's orbit",
            fold,
            3941.7535,
            0.0035,
            unit="rpm",
            relative=False,
            source="plain runs on either side",
            kind="independent",
        )
        assert not met.points[-1].stable


class TestCommand:
    def test_follow(self, case, tmp_path, typed):
        """The command finds the fold and both motions."""
        command = ["follow", case, "-p torque=0.8:1.2 --step 0.1 --channels bodies/bob/theta"]
        document = typed(*command, "-o", tmp_path, "--json").document
        assert [b["kind"] for b in document["bifurcations"]] == ["fold"]
        assert document["coexisting"][0]["motions"] == 2
        assert (tmp_path / "follow.png").stat().st_size > 10000
        assert len(document["branch"]["torque"]) == document["points"]

    def test_wrong_input(self, case, typed):
        """Wrong words: one line and status 2."""
        for words, message in (
            ("", "one parameter needs a range"),
            ("-p torque=0.5:0.5", "the range begins where it ends"),
            ("-p torque=0.5:1 --over nowhere", "--over belongs to a picture"),
            ("-p torque=0.5:1 --points 1", "points must be"),
        ):
            assert message in typed.line("follow", case, words)

    def test_no_periodic_motion(self, typed):
        """Chaos at the start is a failure with its reason."""
        assert "no periodic motion within 12 turns" in typed.line(
            "follow slider_crank -p speed=5000rpm:6000rpm --most-turns 12", status=1
        )


WHEEL = '''"""A wheel off its centre, on a spring beside a driven crank."""

import clearance as cl


def scene(*, speed: float = 6.0) -> cl.Scene:
    """speed: of the crank [rad/s]"""
    crank, wheel = cl.Body("crank", 1.0, 0.01), cl.Body("wheel", 1.0, 0.01, com=(0.02, 0.0))
    return cl.Scene(
        cl.Revolute(cl.ground, crank, name="A"),
        cl.Revolute(cl.ground, wheel, name="B"),
        cl.Drive(crank, speed=speed, start=0.0),
        cl.TorsionSpring(crank, wheel, stiffness=5.0, damping=0.5),
    )
'''


def test_a_wheel_that_turns_with_its_drive_is_followed(tmp_path):
    """It makes a turn in each period. The motion at the end of the range is that which the scene
    settles to, within ten tolerances of 1e-6.
    """
    (tmp_path / "wheel.py").write_text(WHEEL)
    branch = cl.follow(tmp_path / "wheel.py", "speed", 6.0, 12.0, tolerance=1e-6)
    last = branch.points[-1]
    assert branch.reason == "the parameter left its range"
    assert last.period == 1
    scene = cl.load_case(tmp_path / "wheel.py", speed=last.value)
    settled = cl.steady(scene, 1e-6, error=None)
    assert last.largest == pytest.approx(abs(settled.multipliers[0]), rel=1e-3)
    turned = last.passage.y[0] - next(iter(settled.states.values()))
    turns = last.passage.turns[0] - settled.orbit["crank"].theta[0] / (2.0 * np.pi)
    assert turned == pytest.approx(2.0 * np.pi * turns, abs=1e-5)


QUICK_RETURN = '''
import clearance as cl


def scene(*, speed: float = 6.0, model: str = "mixed") -> cl.Scene:
    """A quick-return mechanism with clearance at the crank pin.

    speed: of the crank [rad/s]
    model: of the crank pin
    """
    crank = cl.Body("crank", 0.2, 5e-5, points={"shaft": (0, 0), "pin": (0.05, 0)})
    block = cl.Body("block", 0.1, 2e-5, points={"pin": (0, 0)})
    lever = cl.Body("lever", 0.5, 2e-3, points={"pivot": (0, 0)}, com=(0.1, 0))
    joint = cl.JointOptions(joints="B", model=model).factory("B", radius=8e-3, length=16e-3)
    return cl.Scene(
        cl.Revolute(cl.ground.at(0.12, 0), crank["shaft"], name="A"),
        joint("B", crank["pin"], block["pin"]),
        cl.Revolute(cl.ground, lever["pivot"], name="O"),
        cl.Prismatic(lever["pivot"], block["pin"], name="slot"),
        cl.Drive(crank, speed=speed, start=0.0),
    )
'''


@pytest.mark.parametrize("step", np.random.default_rng(4).uniform(0.005, 0.1, 3))
def test_a_longest_step_is_a_bound_on_quiet_branches(step, tmp_path):
    """No way between two points is longer, in shares of the range; the last steps are as long."""
    file = tmp_path / "quick_return.py"
    file.write_text(QUICK_RETURN)
    low, high = cl.rpm(60.0), cl.rpm(120.0)
    ways = np.diff(cl.follow(file, "speed", low, high, points=9, step=step).values) / (high - low)
    assert ways.max() <= step * (1.0 + 1e-6)
    assert ways[-2] > 0.8 * step or step > 0.05


@pytest.mark.slow
def test_users19_steps_grow_on_a_quiet_branch_in_the_unit_of_the_user(tmp_path, typed):
    """Twelve points reach half of the range, 60 to 120 rpm; steps of 0.03 reach a quarter. Lines
    are in rpm. The last motion is that which the scene settles to, within its tolerance.
    """
    file = tmp_path / "quick_return.py"
    file.write_text(QUICK_RETURN)
    words = [file, "-p speed=60rpm:120rpm --points 12 -o", tmp_path / "out"]
    shown = typed("follow", *words)
    assert "60 rpm to" in shown.out
    assert "rad/s" not in shown.out
    points = branch_file.points(tmp_path / "out")
    last = points[-1]
    assert len(points) == 12
    assert last.value > cl.rpm(90.0)
    settled = cl.steady(cl.load_case(file, speed=last.value), 1e-6, error=None)
    assert last.largest == pytest.approx(abs(settled.multipliers[0]), abs=10.0 * last.errors[0])
