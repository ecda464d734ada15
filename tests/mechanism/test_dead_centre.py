"""A run that ends at a dead centre names the loop and its closing determinant."""

import logging
import math
import random
import re

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.mechanism.dead_centre import Motion, dead_centre
from clearance.motions.maps import NotPeriodic
from clearance.results.recorder import Memory
from clearance.run.recording import record_run, remember_run
from clearance.simulation import prepare, reopened
from clearance.stepping import status
from tests import mechanisms as m
from tests.seeds import few_of


def bar(name, length, angle=0.0):
    """A slender bar with its centre in its middle."""
    return m.bar(name, length, angle, 0.1, 1e-4, com=(length / 2, 0))


def parallelogram(**drive):
    """Flat after half a turn less the start angle of 1 rad."""
    one, two, beam = bar("one", 0.05, 1.0), bar("two", 0.05, 1.0), bar("beam", 0.2)
    return cl.Scene(*m.loop(one, beam, two, 0.2), cl.Drive(one, start=1.0, **drive))


def slider_crank(rod, **drive):
    crank, slider = bar("crank", 0.06, 0.3), cl.Body("slider", 0.1, 1e-4)
    joints = m.crank_and_slider(crank, bar("rod", rod, -0.2), slider)
    return cl.Scene(*joints, cl.Drive(crank, start=0.3, **drive))


FREE = {"torque": 0.5, "speed_start": 5.0}
ENDS = {
    "parallelogram driven": lambda: parallelogram(speed=5.0),
    "equal rod free": lambda: slider_crank(0.06, **FREE),
    "parallelogram free": lambda: parallelogram(**FREE),
    "parallelogram coasting": lambda: parallelogram(torque=0.0, speed_start=30.0),
    "short rod free": lambda: slider_crank(0.05, **FREE),
    "equal rod driven": lambda: slider_crank(0.06, speed=5.0),
}


@pytest.mark.parametrize("name", few_of([*ENDS], 2))
def test_M5_a_run_that_ends_at_a_dead_centre_names_the_loop(name):
    """The loop and its determinant are the reason, alone: no tighter rtol is suggested."""
    with pytest.raises(cl.SimulationError) as caught:
        cl.simulate(ENDS[name](), until=2.0, samples=200)
    loop = "(beam.two|two.beam)" if name.startswith("parallelogram") else "(rod.slider|slider.rod)"
    message = (
        rf"loop {loop} came to its dead centre, .* "
        r"fell to (\S+) of its scale \((\S+) at the start\)"
    )
    for text in (str(caught.value), *caught.value.result.warnings):
        _, fell, begun = re.search(message, text).groups()
        assert float(fell) < 0.01 < 0.5 < float(begun)
        assert "rtol" not in text


def test_M5_a_short_rod_that_is_driven_cannot_go_on():
    """The position where a prescribed loop ends is named as before."""
    with pytest.raises(cl.SimulationError, match="closed by joint B, is in a singular position"):
        cl.simulate(slider_crank(0.05, speed=5.0), until=2.0, samples=200)


@pytest.mark.parametrize("drive", [{"speed": 5.0}, FREE], ids=["driven", "free"])
def test_M5_a_crank_that_turns_all_the_way_has_no_dead_centre(drive):
    """A rod of 1.2 cranks: the determinant stays above sin(acos(1 / 1.2)) = 0.55."""
    run = prepare(slider_crank(0.072, **drive), until=2.0, samples=200)
    sink = Memory(run.mechanism.layout.channels, {})
    assert record_run(run, sink) is None
    assert not run.observers[0].diagnosis.look_for_dead_centre()


def standing(mechanism):
    """Its start, as a motion."""
    work = np.append(mechanism.work0, 0.0)
    numbers = mechanism.y0, work[mechanism.layout.carried_places]
    return Motion(mechanism, work, np.zeros(1), np.concatenate(numbers)[None])


def test_M5_the_determinant_of_a_dyad_is_the_sine_between_its_links():
    """Of the parallelogram at 1 rad: sin(1), to rounding of the assembled position."""
    mechanism = build(parallelogram(speed=5.0))
    motion = standing(mechanism)
    (loop,) = (g for g in mechanism.plan.groups if g.closures)
    assert abs(motion.outputs.determinants(loop)[0]) == pytest.approx(math.sin(1.0), rel=1e-9)
    assert dead_centre(motion) is None


def test_states_of_a_tilted_guide():
    """Of a joint with an angle of its own: those of the start, to rounding of the assembly."""
    law = cl.hunt_crossley(stiffness=1e9, restitution=0.9)
    body = cl.Body("block", 1.0, 1e-3, angle=3.0)
    sizes = {"overlap": 0.1, "height": 0.02, "clearance": 1e-3, "contact": law}
    guide = cl.ClearancePrismatic(
        cl.ground, body, name="G", angle=3.0, offset=2e-4, tilt=1e-3, **sizes
    )
    mechanism = build(cl.Scene(guide))
    states = standing(mechanism).outputs.states[0]
    np.testing.assert_allclose(states, mechanism.y0[: states.size], atol=1e-14)


def falling_parallelogram(clearance):
    """Three equal rods on gravity, with a clearance between coupler and rocker; it falls through
    flat positions.
    """
    ends = {"a": (-0.5, 0.0), "b": (0.5, 0.0)}
    rods = [("left", np.pi / 2), ("top", 0.0), ("right", np.pi / 2)]
    first, top, right = (
        cl.Body(n, 1.0, 1.0 / 12.0, points=ends, angle=angle, angular_velocity=-1.0 * (n == "left"))
        for n, angle in rods
    )
    law = cl.hunt_crossley(stiffness=1e9, restitution=0.9)
    loose = {"radius": 0.02, "clearance": clearance, "contact": law}
    hinges = m.loop(first, top, right, 1.0, "ABDC", c=cl.ClearanceRevolute, **loose)
    return cl.Scene(*hinges, name="parallelogram")


def test_a_mechanism_that_stands_still_at_its_dead_centre_is_named():
    """A force along a stretched slider-crank without weight: no part moves, and a warning states
    so. With its weight it moves, without a warning.
    """
    slider = cl.Body("slider", 0.1, 1e-4)
    joints = m.crank_and_slider(bar("crank", 0.06), bar("rod", 0.1), slider)
    parts = *joints, cl.Force(slider.at(0, 0), x=-5.0)

    stands = cl.simulate(cl.Scene(*parts, gravity=(0.0, 0.0)), until=0.1, samples=11)
    assert np.ptp(stands["slider"].x) == 0.0
    assert any("nothing has moved" in text for text in stands.warnings)
    moves = cl.simulate(cl.Scene(*parts), until=0.1, samples=11)
    assert np.ptp(moves["slider"].x) > 1e-4
    assert not any("nothing has moved" in text for text in moves.warnings)


def test_ranges2_points_of_a_sweep_pass_a_flat_position(tmp_path):
    """As single runs do: with places of bodies as coordinates; metrics equal those of
    `simulate`.
    """
    case = tmp_path / "falling.py"
    case.write_text(
        "from tests.mechanism.test_dead_centre import falling_parallelogram\n"
        "def scene(*, clearance: float = 1e-3):\n"
        "    return falling_parallelogram(clearance)\n"
    )
    options = {"until": 1.2, "samples": 61}
    sweep = cl.sweep(case, cl.grid(clearance=[1e-3]), tmp_path / "map", error=None, **options)
    assert sweep.done.all()
    run = cl.simulate(falling_parallelogram(1e-3), error=None, **options)
    assert (np.abs(np.diff(np.sign(np.sin(run["left"].theta)))) > 1.0).sum() >= 1
    assert sweep.metrics["joint_D_force_max"][0] == run.extreme("joints/D/force_max").value


CONTACTS = (cl.hunt_crossley, cl.lankarani_nikravesh, cl.flores, cl.gonthier, cl.hu_guo)


def folding(rng, share=None):
    """A loop of two pairs of equal bars that falls, somehow turned and mirrored, with one joint in
    clearance: a parallelogram, or crank and rod of one length with a block on a rail.

    Bars of 1 cm to 10 m, masses of 1 to 100, clearances of 1e-6 to 5e-3 of the size, five laws of
    contact, with friction or without. share: of the size, the clearance in place of a random one.
    """
    size, tilt, hand = 10.0 ** rng.uniform(-2, 1), rng.uniform(0, 2 * np.pi), rng.choice([-1, 1])
    share = share or 10.0 ** rng.uniform(-6, np.log10(5e-3))
    law = rng.choice(CONTACTS)(
        stiffness=10.0 ** rng.uniform(8, 10) * size**0.5, restitution=rng.uniform(0.3, 0.9)
    )
    rub = cl.coulomb(coefficient=0.1, transition_speed=1e-2) if rng.random() < 0.3 else None
    loose, turned = rng.choice(["B", "D"]), np.exp(1j * tilt)

    def at(x, y=0.0):
        point = turned * (x + 1j * hand * y)
        return float(point.real), float(point.imag)

    def bar(name, angle, speed=0.0):
        ends, mass = {"a": (-size / 2, 0), "b": (size / 2, 0)}, 10.0 ** rng.uniform(-1, 1)
        angle, speed = float(tilt + hand * angle), float(hand * speed)
        more = {"points": ends, "angle": angle, "angular_velocity": speed}
        return cl.Body(name, mass * size**2, mass * size**4 / 12, **more)

    def hinge(name, a, b):
        sizes = {"radius": 0.05 * size, "clearance": share * size, "contact": law, "friction": rub}
        return (
            cl.ClearanceRevolute(a, b, name=name, **sizes)
            if name == loose
            else cl.Revolute(a, b, name=name)
        )

    up = rng.uniform(0.5, 2.6)
    crank = bar("crank", up, rng.uniform(1.0, 4.0) * rng.choice([-1, 1]) * np.sqrt(9.81 / size))
    parts = [cl.Revolute(cl.ground, crank["a"], name="A")]
    if rng.random() < 0.5:
        rod, rocker = bar("rod", 0.0), bar("rocker", up)
        parts += [hinge("B", crank["b"], rod["a"]), hinge("D", rod["b"], rocker["b"])]
        parts += [cl.Revolute(cl.ground.at(*at(size)), rocker["a"], name="C")]
    else:
        rod = bar("rod", -up)
        block = cl.Body("block", size**2, 1e-3 * size**4, points={"p": (0, 0)})
        parts += [hinge("B", crank["b"], rod["a"]), hinge("D", rod["b"], block["p"])]
        parts += [cl.Prismatic(cl.ground, block["p"], axis=at(1.0), name="C")]
    gravity = tuple(9.81 * x for x in at(0.0, -1.0))
    return cl.Scene(*parts, gravity=gravity, name="folding"), 3.0 * np.sqrt(size)


def passed(caplog) -> bool:
    """True where the latest run was made again with an open loop."""
    again = "again with places of its bodies as coordinates" in caplog.text
    caplog.clear()
    return again


@pytest.mark.parametrize("count", [4, pytest.param(20, marks=pytest.mark.slow)])
def test_ranges2_a_parallelogram_passes_its_flat_position_at_every_clearance(count, caplog):
    """Clearances of 5e-5 to 2e-3, and eight random ones of 1e-7 to 5e-3 of the bars, for
    two seconds; the ledger closes to 1e-7 of the energy. Cranks part by what a clearance lets
    them near a flat position, whose sine is the root of the clearance.

    Contacts of a measured offset began again and again: their dead band was below the rounding of
    places.
    """
    caplog.set_level(logging.INFO, "clearance")
    few = np.random.default_rng(2).uniform(-7, np.log10(5e-3), 8)
    for clearance in (*np.geomspace(5e-5, 2e-3, count), *10.0**few):
        run = cl.simulate(falling_parallelogram(clearance), until=2.0, samples=301, error=None)
        assert run.complete
        assert passed(caplog)
        assert np.sin(run["left"].theta).min() < -0.5
        assert run.solver["energy_residual_share"] < 1e-7
        assert run.joint("D").gap.min() > -0.05 * 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "count"), [(0, 1), *(pytest.param(s, 6, marks=pytest.mark.slow) for s in range(4))]
)
def test_ranges10_random_folding_loops_pass_their_flat_positions(seed, count, caplog):
    """Two or six scenes, at tolerances of 1e-8 to 1e-5; ledgers close to a thousand tolerances."""
    caplog.set_level(logging.INFO, "clearance")
    rng, opened = np.random.default_rng(seed), 0
    for _ in range(count):
        (scene, until), rtol = folding(rng), 10.0 ** rng.uniform(-8, -5)
        samples = int(rng.integers(2, 400))
        run = cl.simulate(scene, until=until, samples=samples, rtol=rtol, error=None)
        opened += passed(caplog)
        assert run.complete
        assert run.solver["energy_residual_share"] < 1e3 * rtol
    assert opened >= count // 2


@pytest.mark.parametrize("seed", few_of(range(4, 7), 1))
def test_ranges2_whether_a_loop_is_opened_does_not_depend_on_samples(seed, caplog):
    """Steps and largest force of 2 and 3001 samples are the same to the last bit."""
    caplog.set_level(logging.INFO, "clearance")
    clearance, runs = 10.0 ** np.random.default_rng(seed).uniform(-5, -3), []
    for samples in (2, 3001):
        scene = falling_parallelogram(clearance)
        run = cl.simulate(scene, until=1.0, samples=samples, error=None)
        runs.append((run.solver["steps"], run.extreme("joints/D/force_max").value))
        assert passed(caplog)
    assert runs[0] == runs[1]


@pytest.mark.parametrize("seed", few_of(range(3), 1))
def test_ranges2_runs_go_on_from_ends_before_and_behind_a_flat_position(seed):
    """Two parts are as one run: a state of closed loops becomes one of open loops, whose states the
    next run takes over. Random clearances and times; angles to 1e-4 rad at rtol 1e-8, before
    impacts part them.
    """
    rng = np.random.default_rng(seed)
    scene, first = falling_parallelogram(10.0 ** rng.uniform(-5, -3)), rng.uniform(0.1, 0.6)
    options = {"rtol": 1e-8, "error": None, "samples": 11}
    single = cl.simulate(scene, until=first + 0.1, **options)
    before = cl.simulate(scene, until=first, **options)
    behind = cl.simulate(scene, until=0.1, start=before, **options)
    for name in ("left", "top", "right"):
        apart = behind[name].theta[-1] - single[name].theta[-1]
        assert abs(np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi) < 1e-4
    later = cl.simulate(scene, until=1.0, start=before, **options)
    assert list(later.facts("state")["opened"]) == ["D"]
    last = cl.simulate(scene, until=0.05, start=later, **options)
    assert list(last.facts("state")["opened"]) == ["D"]
    assert last["top"].x[0] == pytest.approx(later["top"].x[-1], abs=1e-14)


def test_an_opened_run_is_made_again(tmp_path):
    """From its file, also where it began elsewhere: the same bits."""
    scene = falling_parallelogram(1e-4)
    before = cl.simulate(scene, until=0.2, samples=3, error=None)
    for start in (None, before):
        run = cl.simulate(scene, until=0.8, samples=9, start=start, path=tmp_path / "run.h5")
        again, options = cl.again(tmp_path / "run.h5")
        np.testing.assert_array_equal(cl.simulate(again, **options)["top"].theta, run["top"].theta)


@pytest.mark.slow
def test_ranges2_a_killed_run_with_checkpoints_goes_on_with_open_loops(tmp_path):
    """The same file as without checkpoints, also where it was interrupted behind the passage."""
    options = {"until": 2.0, "samples": 4001, "error": None}
    scene = falling_parallelogram(1e-4)
    plain = cl.simulate(scene, **options)
    stored = {"path": tmp_path / "run.h5", "checkpoint": 1e-9}

    def interrupt(share):
        if share > 0.6:  # the closed loop ends at a third
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cl.simulate(scene, progress=interrupt, **stored, **options)
    run = cl.simulate(scene, **stored, **options)
    for name in ("left", "top", "right"):
        np.testing.assert_array_equal(run[name].theta, plain[name].theta)


def driven(clearance, **more):
    """A parallelogram of 0.1 m and 0.2 m on a crank that turns evenly, flat twice a turn."""
    one, two, beam = bar("one", 0.1, 1.0), bar("two", 0.1, 1.0), bar("beam", 0.2)
    sizes = {"radius": 0.01, "length": 0.01, "clearance": clearance}
    sizes["contact"] = cl.hunt_crossley(stiffness=1e8, restitution=0.3)
    hinges = m.loop(one, beam, two, 0.2, c=cl.ClearanceRevolute, **sizes | more)
    return cl.Scene(*hinges, cl.Drive(one, start=1.0, speed=10.0))


@pytest.mark.slow
@pytest.mark.parametrize("clearance", [1e-3, pytest.param(2e-4, marks=pytest.mark.slow)])
def test_ranges2_statistics_and_steady_motions_pass_flat_positions(clearance):
    """Turns are counted behind the passages too; a motion that has not settled is named so."""
    result = cl.statistics(driven(clearance), 0.5, max_turns=160, check=False)
    assert result.values["joint_C_force_peak"].min() > 0.0
    with pytest.raises(NotPeriodic, match="within 8 turns"):
        cl.steady(driven(clearance), 1e-6, most_turns=8, error=None)


@pytest.mark.slow
def test_ranges2_lives_pass_flat_positions(tmp_path):
    """The stages of a joint that wears in a parallelogram; its scar grows."""
    rough = {
        "contact": cl.winkler(layer_modulus=1e12, restitution=0.3),
        "wear": cl.archard(coefficient=1e-13),
    }
    scene = driven(5e-4, **rough)
    quick = {"settle": 1, "average": 1, "tolerance": 5.0, "rtol": 1e-4, "samples_per_turn": 40}
    life = cl.wear(scene, turns=1.5, directory=tmp_path, **quick)
    assert life.done
    first = cl.open_result(tmp_path / "stage-0000.h5")
    assert list(first.facts("state")["opened"]) == ["C"]


def turned(rng):
    """A parallelogram that turns, with a film in one of its joints, of any size and speed."""
    length, start = 10.0 ** rng.uniform(-1.5, -0.5), rng.uniform(0.0, 2.0 * math.pi)
    base, loose = length * rng.uniform(0.6, 2.0), "ABCD"[rng.integers(4)]
    one, two, beam = bar("one", length, start), bar("two", length, start), bar("beam", base)
    places = {
        "A": (cl.ground, one["a"]),
        "B": (one["b"], beam["a"]),
        "C": (beam["b"], two["b"]),
        "D": (cl.ground.at(base, 0), two["a"]),
    }
    laws = cl.short_film, cl.long_film, cl.full_sommerfeld, cl.pinkus_sternlicht, cl.harmonic
    oily = {
        "radius": 0.08 * length,
        "clearance": min(10.0 ** rng.uniform(-5.5, -4.0), 8e-4 * length),
        "length": 0.08 * length,
        "film": laws[rng.integers(5)](),
        "lubricant": cl.Lubricant(10.0 ** rng.uniform(-2.0, -0.5)),
    }
    joints = [
        cl.ClearanceRevolute(*ends, name=name, **oily) if name == loose else cl.Revolute(*ends)
        for name, ends in places.items()
    ]
    speed = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(0.0, 2.0)
    return cl.Scene(*joints, cl.Drive(two if loose == "A" else one, speed=speed))


@pytest.mark.filterwarnings("ignore::clearance.RunWarning")
@pytest.mark.parametrize("seed", few_of(range(20, 26), 1))
def test_infinite_outputs_at_a_dead_centre_are_no_extremes(seed):
    """A pressure may be infinite there: such a run ended with an error of Python."""
    scene = turned(np.random.default_rng(seed))
    try:
        located = cl.simulate(scene, turns=1, samples=101, error=None).located
    except cl.SimulationError as end:
        located = end.result.located
    assert np.isfinite(located.values[0]).all()


@pytest.mark.parametrize("loose", few_of(["K", "A", "F0", "Q2"], 1))
def test_ranges8_plates_on_three_legs_name_their_loop(loose):
    """A plate on three legs, solved by iteration, one foot on the rocker of a dyad; random feet and
    places. Wherever the clearance is, the loop is the reason where a run ends.
    """
    rng, reasons = np.random.default_rng(5), []
    for _ in range(2):
        run = prepare(three_legs(rng, loose), until=1.0, samples=11, max_steps=20_000)
        reasons.append(remember_run(run)[1] or "")
    for reason in reasons:
        assert re.search(r"^$|loop \S*plate came to its dead centre|step limit", reason)
        assert "changed its branch" not in reason


def three_legs(rng, loose):
    """A crank, a coupler and a rocker; the plate's legs stand on the ground, on the rocker and on
    the ground again. All joints are hinges but the loose one, which has clearance.
    """
    corners = np.array([-0.15 - 0.0833j, 0.15 - 0.0833j, 0.1667j])
    turn, law = rng.uniform(-0.3, 0.3), cl.hunt_crossley(stiffness=1e9, restitution=0.5)
    middle = complex(0.35, 0.58) + 0.05 * complex(*rng.uniform(-1, 1, 2))
    pins, tip = middle + corners * np.exp(1j * turn), 0.08 * np.exp(0.7j)
    rocker_tip = 0.45 + rng.uniform(0.15, 0.25) * np.exp(1j * rng.uniform(1.2, 1.9))
    feet = np.array([-0.1 + 0.1j, rocker_tip, 0.2 + 1.0j])
    feet[::2] += 0.05 * (rng.uniform(-1, 1, 2) + 1j * rng.uniform(-1, 1, 2))

    def link(name, begin, end):
        return bar(name, float(abs(end - begin)), float(np.angle(end - begin)))

    def hinge(name, a, b):
        sizes = {"radius": 0.01, "clearance": 1e-4, "contact": law}
        if name == loose:
            return cl.ClearanceRevolute(a, b, name=name, **sizes)
        return cl.Revolute(a, b, name=name)

    def ground(position):
        return cl.ground.at(float(position.real), float(position.imag))

    ends = {f"p{i}": (float(c.real), float(c.imag)) for i, c in enumerate(corners)}
    start = (float(middle.real), float(middle.imag))
    plate = cl.Body("plate", 1.0, 0.02, points=ends, angle=turn, position=start)
    crank, coupler = link("crank", 0j, tip), link("coupler", tip, rocker_tip)
    rocker = link("rocker", 0.45, rocker_tip)
    legs = [link(f"leg{i}", *pair) for i, pair in enumerate(zip(feet, pins, strict=True))]
    return cl.Scene(
        hinge("A", cl.ground, crank["a"]),
        hinge("B", crank["b"], coupler["a"]),
        hinge("K", coupler["b"], rocker["b"]),
        hinge("O", ground(0.45 + 0j), rocker["a"]),
        hinge("F0", ground(feet[0]), legs[0]["a"]),
        hinge("F1", rocker["b"], legs[1]["a"]),
        hinge("F2", ground(feet[2]), legs[2]["a"]),
        *(hinge(f"Q{i}", leg["b"], plate[f"p{i}"]) for i, leg in enumerate(legs)),
        cl.Torque(crank, float(rng.uniform(-1, 1))),
    )


def test_a_loop_that_cannot_be_opened_is_named_with_the_reason():
    """The failure of the run, and what forbids it to go on."""
    run = prepare(falling_parallelogram(1e-4), until=1.0, samples=3)
    remember_run(run)

    def refused(opened):
        assert opened == ("D",)
        raise ValueError("joint B: no")

    again, failure = reopened(run, refused, "at t = 0.7 s: its dead centre")
    assert again is None
    assert failure.endswith("its dead centre; the loop cannot be opened at joint D: joint B: no")


def falling(clearance: float = 1e-3) -> cl.Scene:
    """The parallelogram as a case."""
    return falling_parallelogram(clearance)


@pytest.mark.slow
def test_ranges2_scatter_passes_flat_positions_and_sensitivities_are_refused(tmp_path):
    """Contacts that begin part neighbouring trajectories, with an open loop too."""
    with pytest.raises(ValueError, match="contact of joint D starts with a touch"):
        cl.simulate(falling(), until=2.0, sensitivity=["joints/D/clearance"])
    law = {"clearance": "uniform(5e-4, 2e-3)"}
    scattered = cl.scatter(falling, law, tmp_path / "s", points=24, until=2.0, workers=1)
    assert np.isfinite(scattered.sweep.metrics["joint_D_force_max"]).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", few_of(range(6), 1))
def test_a_film_opened_beside_a_wider_clearance(seed):
    """A slider-crank opened at its film moves as the closed one, to 1e-3 of its clearance.

    Natural sizes of rates were those of a state with the other journal centred, where this one lay
    far outside its film. Tolerances of 1e-16 m/s followed, and runs stopped.
    """
    rng = random.Random(f"opened film {seed}")
    size, rate = 10.0 ** rng.uniform(-1.5, -0.5), 10.0 ** rng.uniform(0.5, 2.0)
    angle = rng.uniform(0.5, 2.5)
    wide = size * 10.0 ** rng.uniform(-3.3, -2.7)
    lean = -math.asin(math.sin(angle) / 3.0)
    crank = cl.Body("crank", 1.0, size**2, points={"o": (0, 0), "p": (size, 0)}, angle=angle)
    rod = cl.Body("rod", 1.0, size**2, points={"p": (0, 0), "q": (3 * size, 0)}, angle=lean)
    block = cl.Body("block", 1.0, size**2, points={"q": (0, 0)})
    narrow = wide * 10.0 ** rng.uniform(-1.5, -0.5)
    oil = {"film": cl.films.short(), "lubricant": cl.Lubricant(0.05), "length": 0.1 * size}
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank["o"], name="O"),
        cl.ClearanceRevolute(
            crank["p"], rod["p"], name="P", radius=0.1 * size, clearance=wide,
            eccentricity=(0.9 * wide, 0.0), **oil,
        ),
        cl.ClearanceRevolute(
            rod["q"], block["q"], name="Q", radius=0.1 * size, clearance=narrow, **oil
        ),
        cl.Prismatic(cl.ground, block["q"], name="G"),
        cl.Drive(crank, speed=rate),
    )  # fmt: skip
    span = {"until": 0.1 / rate, "rtol": 1e-6, "samples": 11, "max_steps": 20_000}
    closed, opened = (prepare(scene, **span, opened=joints) for joints in ((), ("Q",)))
    assert [closed.go(), opened.go()] == [status.DONE, status.DONE]
    one, other = (
        [r.outputs_here()[r.mechanism.layout.output[f"joints/P/eccentricity_{k}"]] for k in "xy"]
        for r in (closed, opened)
    )
    assert other == pytest.approx(one, abs=1e-3 * narrow)
