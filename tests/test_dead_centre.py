"""A run that ends at a dead centre names the loop and its closing determinant."""

import logging
import math
import re

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.mechanism.dead_centre import SampledMotion, dead_centre
from clearance.recording import MemorySink
from clearance.simulation import prepare


def bar(name, length, angle=0.0):
    ends = {"a": (0, 0), "b": (length, 0)}
    return cl.Body(name, 0.1, 1e-4, points=ends, com=(length / 2, 0), angle=angle)


def parallelogram(**drive):
    """Flat after half a turn less the start angle of 1 rad."""
    one, two, beam = bar("one", 0.05, 1.0), bar("two", 0.05, 1.0), bar("beam", 0.2)
    return cl.Scene(
        cl.Revolute(cl.ground, one["a"], name="O1"),
        cl.Revolute(cl.ground.at(0.2, 0), two["a"], name="O2"),
        cl.Revolute(one["b"], beam["a"], name="P1"),
        cl.Revolute(two["b"], beam["b"], name="P2"),
        cl.Drive(one, start=1.0, **drive),
    )


def slider_crank(rod, **drive):
    crank, link = bar("crank", 0.06, 0.3), bar("rod", rod, -0.2)
    slider = cl.Body("slider", 0.1, 1e-4, points={"p": (0, 0)})
    return cl.Scene(
        cl.Revolute(cl.ground, crank["a"], name="O"),
        cl.Revolute(crank["b"], link["a"], name="A"),
        cl.Revolute(link["b"], slider["p"], name="B"),
        cl.Prismatic(cl.ground, slider["p"], name="G"),
        cl.Drive(crank, start=0.3, **drive),
    )


FREE = {"torque": 0.5, "speed_start": 5.0}
ENDS = {
    "parallelogram driven": lambda: parallelogram(speed=5.0),
    "parallelogram free": lambda: parallelogram(**FREE),
    "parallelogram coasting": lambda: parallelogram(torque=0.0, speed_start=30.0),
    "short rod free": lambda: slider_crank(0.05, **FREE),
    "equal rod driven": lambda: slider_crank(0.06, speed=5.0),
    "equal rod free": lambda: slider_crank(0.06, **FREE),
}


@pytest.mark.parametrize("name", ENDS)
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
    sink = MemorySink(run.mechanism.layout.channels, {})
    assert run.record(sink) is None
    assert not run.observers[0].diagnosis.look_for_dead_centre()


def test_M5_the_determinant_of_a_dyad_is_the_sine_between_its_links():
    """Of the parallelogram at 1 rad: sin(1), to rounding of the assembled position."""
    mechanism = build(parallelogram(speed=5.0))
    row, work = np.empty((1, len(mechanism.layout.channels))), np.append(mechanism.work0, 0.0)
    mechanism.kernel("observe")(0.0, mechanism.y0, mechanism.par, work, row[0])
    motion = SampledMotion(mechanism, work, np.zeros(1), row)
    (loop,) = (g for g in mechanism.plan.groups if g.closures)
    assert abs(motion.determinants(loop)[0]) == pytest.approx(math.sin(1.0), rel=1e-9)
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
    row = mechanism.outputs(0.0, mechanism.y0, np.append(mechanism.work0, 0.0))
    values, _ = SampledMotion(mechanism, mechanism.work0, np.zeros(1), row[None]).states
    np.testing.assert_allclose(values[0], mechanism.y0[: values.shape[1]], atol=1e-14)


def falling_parallelogram(clearance):
    """Three equal rods on gravity, with a clearance between coupler and rocker; it falls through
    flat positions.
    """
    ends = {"a": (-0.5, 0.0), "b": (0.5, 0.0)}
    rods = [("left", np.pi / 2), ("top", 0.0), ("right", np.pi / 2)]
    left, top, right = (
        cl.Body(n, 1.0, 1.0 / 12.0, points=ends, angle=angle, angular_velocity=-1.0 * (n == "left"))
        for n, angle in rods
    )
    law = cl.hunt_crossley(stiffness=1e9, restitution=0.9)
    return cl.Scene(
        cl.Revolute(cl.ground, left["a"], name="A"),
        cl.Revolute(left["b"], top["a"], name="B"),
        cl.ClearanceRevolute(
            top["b"], right["b"], name="D", radius=0.02, clearance=clearance, contact=law
        ),
        cl.Revolute(cl.ground.at(1.0, 0.0), right["a"], name="C"),
        name="parallelogram",
    )


def test_a_mechanism_that_stands_still_at_its_dead_centre_is_named():
    """A force along a stretched slider-crank without weight: no part moves, and a warning states
    so. With its weight it moves, without a warning.
    """
    crank, rod = bar("crank", 0.06), bar("rod", 0.1)
    slider = cl.Body("slider", 0.1, 1e-4, points={"p": (0, 0)})
    parts = (
        cl.Revolute(cl.ground, crank["a"], name="O"),
        cl.Revolute(crank["b"], rod["a"], name="A"),
        cl.Revolute(rod["b"], slider["p"], name="B"),
        cl.Prismatic(cl.ground, slider["p"], name="G"),
        cl.Force(slider["p"], x=-5.0),
    )
    stands = cl.simulate(cl.Scene(*parts, gravity=(0.0, 0.0)), until=0.1, samples=11)
    assert np.ptp(stands["slider"].x) == 0.0
    assert any("nothing has moved" in text for text in stands.warnings)
    moves = cl.simulate(cl.Scene(*parts), until=0.1, samples=11)
    assert np.ptp(moves["slider"].x) > 1e-4
    assert not any("nothing has moved" in text for text in moves.warnings)


def test_points_of_a_sweep_pass_a_flat_position(tmp_path):
    """As single runs do: with places of bodies as coordinates; metrics equal those of
    `simulate`.
    """
    case = tmp_path / "falling.py"
    case.write_text(
        "from tests.test_dead_centre import falling_parallelogram\n"
        "def scene(*, clearance: float = 1e-3):\n"
        "    return falling_parallelogram(clearance)\n"
    )
    options = {"until": 1.2, "samples": 61}
    sweep = cl.sweep(case, cl.grid(clearance=[1e-3]), tmp_path / "map", error=None, **options)
    assert sweep.done.all()
    run = cl.simulate(falling_parallelogram(1e-3), error=None, **options)
    assert (np.abs(np.diff(np.sign(np.sin(run["left"].theta)))) > 1.0).sum() >= 1
    assert sweep.metrics["joint_D_force_max"][0] == run.extreme("joints/D/force_max").value


@pytest.mark.parametrize("clearance", [1e-3, 1e-4])
def test_a_parallelogram_with_clearance_passes_its_flat_position(clearance, caplog):
    """Places of bodies become coordinates where the loop is singular; the ledger closes to 1e-7 of
    the energy.

    Three seconds take it through the flat position several times. The cranks part by what the
    clearance lets them.
    """
    with caplog.at_level(logging.INFO, "clearance"):
        run = cl.simulate(falling_parallelogram(clearance), until=3.0, samples=301)
    assert "again with places of its bodies as coordinates" in caplog.text
    assert run.complete
    assert (np.abs(np.diff(np.sign(np.sin(run["left"].theta)))) > 1.0).sum() >= 3
    assert run.solver["energy_residual_share"] < 1e-7
    apart = np.remainder(run["left"].theta - run["right"].theta + np.pi, 2.0 * np.pi) - np.pi
    assert 0.0 < np.abs(apart).max() < 0.2
    assert run.joint("D").gap.min() > -0.05 * 0.02
