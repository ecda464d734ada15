"""Periodic motions against closed forms, an independent study and the runs that settle to them."""

import math

import numpy as np
import pytest

import clearance as cl
from clearance import cli
from clearance.commands.steady import lines, shown
from clearance.laws.law import signal
from clearance.mechanism.build import build
from clearance.metrics.metrics import metrics
from clearance.motions import maps, periodic_errors
from clearance.motions.maps import Motion, _repeats, _turns_made
from clearance.motions.shooting import multipliers
from clearance.motions.steady import steady, tolerance_of
from tests.mechanisms import body, film
from tests.random_scenes import ALIKE, draw
from tests.seeds import few_of

MASS, DAMPING, STIFFNESS, FORCE, FREQUENCY = 2.0, 3.0, 800.0, 40.0, 12.0
STALL, NO_LOAD, INERTIA, DRAG = 4.0, 50.0, 2e-3, 0.02


@signal
def harmonic(time, amplitude, frequency):
    return amplitude * math.cos(frequency * time)


@pytest.mark.parametrize("seed", few_of(range(12), 2))
def test_ranges1_wheels_that_turn_with_their_drive_have_a_periodic_motion(seed):
    """Random wheels on springs and teeth, measured against a drive that turns: three periods from
    the orbit on are alike to 1e-5 of the torque or of the inertia's, ten tolerances.
    """
    drawn = draw(ALIKE * seed, "settling")
    scene, turn = drawn.scene, drawn.turn
    period = None if scene.turn else turn
    motion = steady(scene, 1e-6, error=None, most_turns=150, period=period)
    length = {"until": 3.0 * motion.duration, "samples": 121, "rtol": 1e-10, "error": None}
    run = cl.simulate(scene, start=motion.orbit, **length)
    torque = run.drive(scene.drives[0].name).torque
    natural = sum(b.inertia for b in scene.bodies) * (2.0 * math.pi / turn) ** 2
    for later in (40, 80):
        size = 1e-5 * max(np.abs(torque).max(), natural)
        np.testing.assert_allclose(torque[later : later + 41], torque[:41], atol=size)


@pytest.mark.parametrize("seed", few_of(range(8), 2))
def test_a_loop_that_cannot_turn_has_forces_that_come_back(seed):
    """A crank longer than its rod: its loop does not close at all phases that are compared."""
    rng = np.random.default_rng(seed)
    size, share = 10.0 ** rng.uniform(-2, 0), rng.uniform(0.3, 0.9)
    angle, side = rng.uniform(-0.2, 0.2), float(rng.choice([-1.0, 1.0]))
    sway = -math.asin(math.sin(angle) / share)
    crank = body("crank", {"A": (0, 0), "B": (size, 0)}, angle=angle)
    rod = body("rod", {"B": (0, 0), "C": (share * size, 0)}, angle=sway)
    block = cl.Body("block", 1.0, size**2)
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank["A"], name="A"),
        film(crank["B"], rod["B"], "B", clearance=1e-4 * size),
        cl.Revolute(rod["C"], block.at(0, 0), name="C"),
        cl.Prismatic(cl.ground, block.at(0, 0), name="guide"),
        cl.Drive(crank, speed=side * rng.uniform(1.0, 20.0)),
    )
    mechanism = build(scene, ledger=False)
    assert _repeats(mechanism, scene.turn, _turns_made(mechanism, scene.turn))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::clearance.RunWarning")
@pytest.mark.parametrize("seed", few_of(range(5), 1))
def test_the_rounding_of_a_turn_winds_up_no_thin_film(seed):
    """Clearances of 50 nm to 0.1 mm: the motion and its errors. The accelerations of a thin film
    are small differences of large ones, and rounding of a turn changes them by more than 1e-10.
    """
    rng = np.random.default_rng(seed)
    values = {"clearance": 10.0 ** rng.uniform(-7.3, -4.0), "speed": rng.uniform(20.0, 150.0)}
    scene = cl.load_case("slider_crank", model="lubricated", **values)
    settled = steady(scene, tolerance=1e-6)
    assert settled.orbit.errors
    assert np.abs(settled.multipliers).max() < 1.0


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::clearance.RunWarning")
@pytest.mark.parametrize("seed", few_of(range(4), 1))
def test_a_trial_that_cannot_go_on_does_not_end_the_search(seed):
    """Clearances of 10 to 30 nm: at the tolerances of a solver a motion beside may stick. Then
    plain turns go on; a motion is met, or the reason is in words.
    """
    rng = np.random.default_rng(seed)
    values = {"clearance": 10.0 ** rng.uniform(-8.0, -7.5), "speed": rng.uniform(15.0, 30.0)}
    scene = cl.load_case("slider_crank", model="lubricated", **values)
    try:
        met = steady(scene, most_turns=60, error=None)
    except cl.NotPeriodic as reason:
        message = str(reason)
    else:
        message = ""
        assert met.change < 1e-6
    assert not message or "no periodic motion within 60 turns" in message


def test_a_trial_that_needs_too_many_steps_is_given_up(monkeypatch):
    """Its end is no end of the search; a step limit of the user ends a plain turn."""
    scene = cl.load_case("slider_crank", model="lubricated")
    motion = Motion(scene, 1e-9)
    motion.go(motion.start(), 0.0, motion.turn)
    monkeypatch.setattr(maps, "MANY", 0)
    monkeypatch.setattr(maps, "FEW", 20)
    sentence = "cannot be continued: at t.*step limit"
    with pytest.raises(cl.NotPeriodic, match=sentence), motion.trials():
        motion.go(motion.start(), 0.0, motion.turn)
    motion.go(motion.start(), 0.0, motion.turn)
    with pytest.raises(RuntimeError, match="the step limit is reached"):
        steady(scene, max_steps=20)


def test_a_spring_that_is_wound_up_has_no_periodic_motion():
    """A geared wheel turns against a spring on the ground; the reason is in words."""
    one, two = (cl.Body(n, 1.0, 0.01) for n in ("one", "two"))
    hinges = cl.Revolute(cl.ground, one, name="A"), cl.Revolute(cl.ground.at(0.1, 0), two, name="B")
    teeth = cl.Gear(*hinges, ratio=-1.0, stiffness=1e4, damping=10.0)
    hold = cl.TorsionSpring(cl.ground, two, stiffness=0.01)
    scene = cl.Scene(*hinges, teeth, hold, cl.Drive(one, speed=10.0, start=0.0))
    with pytest.raises(cl.NotPeriodic, match="wind up springs"):
        steady(scene, most_turns=25)


def test_a_motion_that_runs_away_has_no_periodic_motion():
    """A block on a turning rod flies off, faster with each turn; 10 random rods."""
    rng = np.random.default_rng(7)
    for _ in range(10):
        rod, block = (cl.Body(n, rng.uniform(0.1, 5.0), 0.01) for n in ("rod", "block"))
        hinge = cl.Revolute(cl.ground, rod, name="A")
        guide = cl.Prismatic(rod, block, name="guide", angle=rng.uniform(-3.0, 3.0))
        drive = cl.Drive(rod, speed=rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 300.0))
        scene = cl.Scene(hinge, guide, drive, gravity=(0.0, -9.81))
        with pytest.raises(cl.NotPeriodic, match="runs away"):
            steady(scene)


def oscillator():
    """m x'' + c x' + k x = F cos(w t)."""
    body = cl.Body("mass", mass=MASS, inertia=1.0, points={"p": (0, 0)}, position=(0.1, 0))
    anchor = cl.ground.at(-1, 0)
    spring = {"stiffness": STIFFNESS, "damping": DAMPING, "free_length": 1.0}
    force = harmonic(amplitude=FORCE, frequency=FREQUENCY)
    return cl.Scene(
        cl.Prismatic(cl.ground, body["p"], name="guide"),
        cl.SpringDamper(anchor, body["p"], **spring),
        cl.Force(body["p"], x=force),
        gravity=(0, 0),
        name="oscillator",
    )


def rotor():
    """A disc with viscous drag on the straight line of a motor: J w' = T_s (1 - w / w_0) - c w."""
    disc = cl.Body("disc", mass=1.0, inertia=INERTIA, points={"centre": (0, 0)})
    motor = cl.motor_line(stall=STALL, no_load=NO_LOAD)
    return cl.Scene(
        cl.Revolute(cl.ground, disc["centre"], name="bearing"),
        cl.TorsionSpring(cl.ground, disc, damping=DRAG),
        cl.Drive(disc, torque=motor, nominal=NO_LOAD),
        name="rotor",
    )


def crank(**more):
    """The dry slider-crank of the bifurcation diagram over its speed."""
    dry = {"restitution": 0.9, "friction": "coulomb", "friction_coefficient": 0.03}
    chosen = {"model": "dry", "clearance": 1e-3, "speed": cl.rpm(3000)} | dry
    return cl.load_case("slider_crank", **chosen | more)


def warm():
    """A journal whose oil warms up, slowly."""
    body = cl.Body("journal", 3.0, 1e-3)
    bearing = {"radius": 0.01, "clearance": 1e-4, "length": 0.02, "film": cl.table_film()}
    heat = cl.HeatBalance(50.0, 1.0, volumetric=0.0)
    more = {"lubricant": cl.Lubricant(0.05), "heat": heat}
    joint = cl.ClearanceRevolute(cl.ground.at(0, 0), body.at(0, 0), name="J", **bearing, **more)
    return cl.Scene(joint, cl.Drive(body, speed=100.0))


@pytest.fixture(scope="module")
def dry():
    return steady(crank())


@pytest.fixture(scope="module")
def orbit():
    return steady(oscillator(), 1e-8, period=2.0 * math.pi / FREQUENCY)


class TestClosedForms:
    def test_multipliers_of_an_oscillator(self, orbit, validated):
        """exp(-c T / 2 m) exp(+-i w_d T), to 1e-6: the map is linear, differences are right to
        the local tolerance over their step, 1e-12 / 1e-7.
        """
        decay = DAMPING / (2.0 * MASS)
        damped, period = math.sqrt(STIFFNESS / MASS - decay**2), 2.0 * math.pi / FREQUENCY
        exact = np.exp(-decay * period + 1j * damped * period)
        exact = exact if exact.imag > 0.0 else exact.conjugate()
        assert orbit.multipliers[0] == pytest.approx(exact, abs=1e-6)
        source = {"source": "closed form", "kind": "exact"}
        size = abs(orbit.multipliers[0])
        validated("size of an oscillator's multipliers", size, abs(exact), 1e-6, unit="1", **source)

    def test_amplitude_of_an_oscillator(self, orbit):
        """F / sqrt((k - m w^2)^2 + c^2 w^2), to 1e-6: samples lie a 400th of the period apart,
        where the largest is short by (pi / 400)^2 / 2 = 3e-5 at most; so the mean square over
        the period, exact for harmonics, is taken.
        """
        x = orbit.orbit["mass"].x[:-1]
        amplitude = math.sqrt(2.0 * np.mean((x - x.mean()) ** 2))
        stiff, drag = STIFFNESS - MASS * FREQUENCY**2, DAMPING * FREQUENCY
        assert amplitude == pytest.approx(FORCE / math.hypot(stiff, drag), rel=1e-6)

    def test_a_motor_finds_its_speed_and_its_period(self):
        """w = T_s / (T_s / w_0 + c); the multiplier is exp(-(T_s / w_0 + c) T / J): linear,
        right to 1e-6.
        """
        actual, slope = steady(rotor(), 1e-8), STALL / NO_LOAD + DRAG
        speed = STALL / slope
        assert actual.autonomous
        assert actual.states["rate of bodies/disc/angle"] == pytest.approx(speed, rel=1e-8)
        assert actual.duration == pytest.approx(2.0 * math.pi / speed, rel=1e-8)
        expected = math.exp(-slope * actual.duration / INERTIA)
        assert actual.multipliers == pytest.approx([expected], abs=1e-6)


class TestErrorsOfMultipliers:
    """Of a matrix with errors of the runs that its columns come from."""

    exact = np.array([[0.5, 1.0, 0.0], [-1.0, 0.5, 0.2], [0.0, 0.1, -0.3]])

    @pytest.mark.parametrize("column", range(3))
    def test_an_error_of_one_run(self, column):
        """It moves no eigenvalue further than stated, within 1 % for terms of second order, and
        the one that it moves most by as much.
        """
        half = np.zeros((3, 3))
        half[:, column] = 1e-4, -2e-4, 5e-5
        exact, _ = multipliers(self.exact, half)
        values, errors = multipliers(self.exact + half, half)
        moved = np.abs(values - exact)
        assert (moved <= 1.01 * errors).all()
        assert errors == pytest.approx(moved, rel=0.01)

    def test_errors_of_several_runs_add(self):
        """To rounding, 1e-12."""
        half = np.diag([1e-4, -2e-4, 5e-5])
        parts = [half * (np.arange(3) == column) for column in range(3)]
        total = sum(multipliers(self.exact, part)[1] for part in parts)
        assert multipliers(self.exact, half)[1] == pytest.approx(total, rel=1e-12)

    def test_print(self):
        """Digits end with the error; small errors are 1e-6."""
        values, errors = [-0.47764, 0.1 + 0.25j, 0.1 - 0.25j, -1e-7], [4e-4, 0.02, 0.02, 1e-12]
        expected = ["-0.4776 +- 0.0004", "(0.10 +- 0.25 i) +- 0.02", "0.000000 +- 0.000001"]
        assert shown(map(complex, values), errors) == expected
        assert shown([complex(-0.5)], [math.nan]) == ["-0.5"]

    def test_doubt(self):
        """A size of 1 within its error is named."""
        facts = {"period": 1, "duration": 0.02, "change": 1e-7, "distance": 1e-7, "slow": ""}
        facts |= {"waited": 1, "turns_spent": 9.0, "multipliers": [[-0.99, 0.0]]}
        assert "doubt" in lines(facts | {"multiplier_errors": [0.02]})[-1]
        assert "doubt" not in lines(facts | {"multiplier_errors": [0.005]})[-1]


class TestDryJoint:
    def test_multipliers(self, dry, validated):
        """An independent study has -0.094 +- 0.149 i and 0.063 (three digits): within 1e-3."""
        assert dry.multipliers[:3] == pytest.approx(
            [-0.094 + 0.149j, -0.094 - 0.149j, 0.063], abs=1e-3
        )
        source = {"source": "shooting in a study of its own", "kind": "independent"}
        size = abs(dry.multipliers[0])
        validated(
            "largest multiplier of the dry slider-crank", size, 0.176, 1e-3, unit="1", **source
        )

    @pytest.mark.parametrize("speed", [2800.0, 2800.00016, 2850.0, 2950.0])
    def test_stated_errors_of_multipliers(self, tmp_path, speed):
        """Multipliers of the coarse and the finer orbit differ by less than both errors state.

        The largest errors are 0.05; differences of smaller increments have 0.5. The friction law
        has kinks, which make single runs of the map jump by up to 1e-6.
        """
        path = tmp_path / "slider_crank.toml"
        assert cli.main(["new", "slider_crank", "-o", str(path)]) == 0
        scene = cl.load_case(path, clearance=1e-3, speed=cl.rpm(speed))
        coarse, fine = (steady(scene, t, error=None) for t in (1e-6, 1e-9))
        apart = np.abs(coarse.multipliers[:3] - fine.multipliers[:3])
        assert (apart < coarse.errors[:3] + fine.errors[:3]).all()
        assert max(coarse.errors.max(), fine.errors.max()) < 0.05

    @pytest.mark.parametrize("speed", few_of([3938.0, 3940.0, 3941.0, 3941.7], 2))
    def test_a_stable_motion_beside_an_unstable_one(self, speed):
        """Below the fold at 3941.756 rpm the run passes the unstable motion of one turn and becomes
        irregular. The stable one beside it is reached. As near any fold, (1 - mu)^2 over the
        distance from it is constant: 0.0042 / rpm within 12 %, for terms of the next order.
        """
        options = {"friction": "coulomb", "friction_coefficient": 0.03, "restitution": 0.9}
        options |= {"model": "dry", "clearance": 1e-3, "speed": cl.rpm(speed)}
        scene = cl.load_case("slider_crank", **options)
        motion = steady(scene, error=None)
        assert motion.period == 1
        slowness = 1.0 - motion.multipliers[0].real
        assert slowness**2 / (3941.7535 - speed) == pytest.approx(0.0042, rel=0.12)

    def test_errors_of_multipliers_are_not_wide(self):
        """Those of a coarse orbit hold what the finer one has, and are at most 2e-4.

        8e-6 to 3e-5 are usual. The spread of differences alone is 1.4e-3: it counts their
        curvature.
        """
        scene = cl.load_case("slider_crank", model="dry", friction="coulomb", clearance=1e-3)
        scene = scene.replaced({"drives/crank/speed": cl.rpm(3000)})
        coarse, fine = (steady(scene, t, error=None) for t in (1e-5, 1e-8))
        apart = np.abs(coarse.multipliers[:3] - fine.multipliers[:3])
        assert (apart < coarse.errors[:3]).all()
        assert (coarse.errors[:3] < 2e-4).all()

    def test_the_file_holds_one_period(self, dry):
        """It ends where it began, to the tolerance of 1e-6, amidst a contact that lasts over its
        ends.
        """
        result = dry.orbit
        assert result.time[-1] == pytest.approx(0.02)
        for name in ("joints/C/eccentricity_x", "joints/C/contact_force", "bodies/slider/ax"):
            values = result.values(name)
            assert values[-1] == pytest.approx(values[0], abs=1e-6 * np.abs(values).max())
        assert result.events["time"].min() < 0.0
        facts = result.facts("steady")
        assert facts["waited"] == dry.waited < dry.turns_spent
        assert (
            complex(facts["multipliers_real"][0], facts["multipliers_imaginary"][0])
            == dry.multipliers[0]
        )

    def test_a_run_from_there_stays_there(self, dry, tmp_path):
        """Two turns of the usual tolerance stay within 1e-4 of the clearance."""
        dry.orbit.save(tmp_path / "orbit.h5")
        after = cl.simulate(crank(), turns=2, start=tmp_path / "orbit.h5", rtol=1e-8)
        x = after.joint("C").eccentricity_x
        assert x[-1] == pytest.approx(dry.orbit.joint("C").eccentricity_x[-1], abs=1e-7)


class TestSlowStates:
    def test_warming_of_oil(self):
        """The heat that the oil takes in leaves by conductance: first law, to 1e-6 of it.
        Waiting would take more than ten times as many turns.
        """
        actual = steady(warm())
        assert actual.slow == ("joints/J/warming",)
        power = actual.orbit.joint("J").power_loss.mean()
        assert actual.states["joints/J/warming"] * 1.0 == pytest.approx(power, rel=1e-5)
        assert actual.plain_turns > 10.0 * actual.turns_spent


class TestStatedErrors:
    @pytest.mark.parametrize(("scene", "share"), [(crank, 1.0), (warm, 0.9)])
    def test_above_the_true_ones(self, scene, share):
        """Against the motion solved to 1e-9 in place of 1e-4; the warming's multiplier is 0.99.
        All numbers are covered, or equal to 1e-11; of few runs one in ten may not be.
        """
        actual, exact = steady(scene(), 1e-4), metrics(steady(scene(), 1e-9, error=None).orbit, 0.0)
        errors = actual.orbit.errors
        assert errors.rtol == pytest.approx((1e-10, 1e-9))
        covered = [
            abs(errors[name].value - number.value)
            <= max(errors[name].stated, 1e-11 * abs(number.value))
            for name, number in exact.items()
        ]
        assert len(covered) > 3
        assert np.mean(covered) >= share
        assert all(errors[name].relative < 1e-3 for name in exact if exact[name].value)

    def test_a_companion_that_fails(self, monkeypatch):
        """In a fold no step is defined: the orbit is returned, and its file states why nothing is
        stated.
        """

        def singular(section, fixed):
            raise np.linalg.LinAlgError("Singular matrix")

        monkeypatch.setattr(periodic_errors, "_moved", singular)
        orbit = steady(rotor(), 1e-8).orbit
        assert orbit.errors.reason == "the companion at rtol 1e-12 failed: Singular matrix"
        assert orbit.complete

    def test_the_films_part(self):
        """A table's forces larger by its error: the gap of a loaded journal changes by about as
        much. Nothing is stated where nothing is needed.
        """
        actual = steady(warm()).orbit
        gap = actual.errors["joint_J_gap_min"]
        table = actual.facts("joints/J")["film_table_error_closing"]
        assert 0.05 * table < gap.film / gap.value < 20.0 * table
        assert steady(warm(), error=None).orbit.errors.reason == "none was requested"


class TestRefusals:
    def test_chaos(self):
        """Chaotic motion ends the search with its reason."""
        with pytest.raises(
            cl.NotPeriodic, match="no periodic motion within 30 turns.*may be chaotic"
        ):
            steady(crank(speed=cl.rpm(5000)), most_turns=30)

    def test_scenes_without_a_periodic_motion(self):
        """Scenes without period or freedom, and wrong tolerances, are refused."""
        with pytest.raises(ValueError, match="no degree of freedom"):
            steady(cl.load_case("slider_crank", model="ideal"))
        with pytest.raises(
            ValueError, match="no drive of constant or nominal speed.*period=SECONDS"
        ):
            steady(oscillator())
        with pytest.raises(ValueError, match=r"the forces do not come back after 0\.3 s"):
            steady(oscillator(), period=0.3)
        with pytest.raises(ValueError, match="tolerance"):
            steady(oscillator(), -1.0)
        with pytest.raises(ValueError, match="tolerance: 'much' is no number such as 1e-3 or 5%"):
            steady(oscillator(), "much")
        assert tolerance_of("0.1%", None) == tolerance_of(1e-3, None)


class TestCommand:
    def test_run_steady(self, tmp_path, typed):
        """`run --steady` writes the orbit with its period."""
        path, values = (
            tmp_path / "orbit.h5",
            {"model": "dry", "friction": "coulomb", "restitution": 0.9},
        )
        values |= {"friction_coefficient": 0.03, "clearance": "1mm", "speed": "3000rpm"}
        command = [
            "run",
            "slider_crank",
            *(w for n, v in values.items() for w in ("-p", f"{n}={v}")),
        ]
        command += ["--steady", "1e-6", "-o", str(path)]
        document = typed(*command, "--json").document
        assert document["steady"]["period"] == 1
        assert document["steady"]["multipliers"][0] == pytest.approx([-0.094, 0.149], abs=1e-3)
        force = document["errors"]["numbers"]["joint_C_force_max"]
        assert 0.0 < force["stated"] < 1e-6 * force["value"]
        printed = typed(*command).out
        assert "steady       period one turn, 0.02 s; periodic to" in printed
        assert "multipliers  (-0.09" in printed
        printed = typed(*command, "--period 40ms").out
        assert "steady       period one turn, 0.04 s; periodic to" in printed
        assert "--period S" in typed.line(*command, "--period 13ms")

    def test_options_of_other_runs_are_refused(self, tmp_path, typed):
        """Options without meaning beside --steady are refused."""
        command = ["run slider_crank --steady 1e-6 -o", tmp_path / "a.h5"]
        assert "--turns has no meaning beside --steady" in typed.line(*command, "--turns 2")
        assert "no degree of freedom" in typed.line(*command, "-p model=ideal")
