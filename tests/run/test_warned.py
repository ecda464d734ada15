"""Warnings of runs reach Python, once a run, and the repr of a result counts them."""

import random
import subprocess
import sys
import warnings

import pytest

import clearance as cl
from clearance.values.checks import RunWarning

CONTACTS = ["hertz", "kelvin_voigt", "winkler", "lankarani_nikravesh", "hunt_crossley"]


def dry(draw: random.Random) -> cl.Scene:
    """A dry slider-crank; some of these contacts warn by themselves."""
    return cl.load_case(
        "slider_crank",
        model="dry",
        contact=draw.choice(CONTACTS),
        speed=cl.rpm(draw.uniform(30, 600)),
        clearance=10 ** draw.uniform(-4, -3),
    )


def test_users3_warnings_reach_python_once_a_run():
    """20 runs: one RunWarning with all texts where there are any, at the line of the call."""
    draw, seen = random.Random(3), set()
    for _ in range(20):
        options = draw.choice([{}, {"error": None}, {"samples": 50}])
        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("always")
            run = cl.simulate(dry(draw), turns=draw.uniform(0.05, 0.3), **options)
        seen.add(len(run.warnings))
        assert len(issued) == bool(run.warnings)
        for one in issued:
            assert one.category is cl.RunWarning
            assert one.filename == __file__
            assert str(one.message).splitlines()[1:] == run.warnings
        some = f", {len(run.warnings)} warning" if run.warnings else ", no warnings"
        assert f"{some}{'s' if len(run.warnings) > 1 else ''}, errors not stated>" in repr(run)
    assert 0 in seen
    assert len(seen) > 1


@pytest.mark.parametrize("options", [{"error": {"drive_crank_torque_max": 0.3}}, {}])
def test_requested_errors_warn_once_too(options):
    """However many runs the answer takes."""
    scene = cl.load_case("slider_crank", model="dry", contact="kelvin_voigt")
    with pytest.warns(RunWarning, match="elastic") as issued:
        cl.simulate(scene, turns=0.1, **options)
    assert len(issued) == 1


def test_a_periodic_motion_warns():
    """Warnings of an orbit are issued once."""
    scene = cl.load_case(
        "slider_crank", model="dry", clearance=1e-3, speed=cl.rpm(3000), friction="coulomb"
    )
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        orbit = cl.steady(scene, 1e-4).orbit
    assert [str(w.message).splitlines()[1:] for w in issued] == [orbit.warnings] * bool(
        orbit.warnings
    )


def test_users3_the_repr_says_what_a_result_is(tmp_path):
    """In memory, in a file, closed, with stated errors; no file that nobody has written."""
    run = cl.simulate(cl.load_case("slider_crank", model="ideal"), turns=1)
    text = f"401 samples, complete, no warnings, errors of {len(run.errors)} numbers stated>"
    assert len(run.errors) > 10
    assert repr(run) == f"<Result of slider_crank: {text}"
    run.save(tmp_path / "größe 1.h5")
    with cl.open_result(tmp_path / "größe 1.h5") as stored:
        assert repr(stored) == f"<Result größe 1.h5: {text}"
    assert repr(stored) == "<Result, closed>"
    with pytest.raises(
        KeyError, match=r"no channel 'bodies/slide/ax' \(did you mean bodies/slider/ax"
    ):
        run.values("bodies/slide/ax")
    assert "bodies/slider/ax" in run.channels
    record = cl.inverse_dynamics(cl.load_case("three_loop_chain"), until=0.1)
    assert repr(record).startswith("<Result of three_loop_chain: ")


def test_a_script_prints_warnings_and_the_command_line_prints_them_once(typed, tmp_path):
    """The command has lines of its own for them."""
    scene = 'cl.load_case("slider_crank", model="dry", contact="kelvin_voigt")'
    script = tmp_path / "script.py"
    script.write_text(f"import clearance as cl\ncl.simulate({scene}, turns=0.1)\n")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True)
    assert done.stderr.count("impacts are elastic") == 1
    assert "script.py:2: RunWarning: 1 warning of this run" in done.stderr
    command = "run slider_crank -p model=dry -p contact=kelvin_voigt --turns 0.1 -o"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _, out, err = typed(command, tmp_path / "run.h5")
    assert (out + err).count("impacts are elastic") == 1
    assert "RunWarning" not in out + err


@pytest.mark.parametrize(
    ("contact", "gravity", "warned"),
    [
        (cl.lankarani_nikravesh(restitution=0.9), (0.0, 0.0), True),
        (cl.lankarani_nikravesh(restitution=0.9), (0.0, -9.81), False),
        (cl.hunt_crossley_memoryless(dissipation=0.1), (0.0, 0.0), False),
    ],
)
def test_a_typical_impact_speed_that_nothing_sets_is_named(contact, gravity, warned):
    """A rough pin at rest that a force pushes: a law with an impact speed has no frequency."""
    rod = cl.Body("rod", mass=1.0, inertia=1e-3, points={"a": (0.0, 0.0)})
    pin = cl.ClearanceRevolute(
        cl.ground,
        rod["a"],
        name="A",
        clearance=1e-5,
        radius=0.01,
        length=0.02,
        roughness=4e-7,
        contact=contact,
        film=cl.pinkus_sternlicht(),
        transition=cl.superposed(),
        lubricant=cl.Lubricant(viscosity=0.05),
    )
    push = cl.Force(rod["a"], x=1.0, y=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = cl.simulate(cl.Scene(pin, push, gravity=gravity), until=1e-3, error=None)
    assert any("impacts of 1e-05 m/s" in text for text in run.warnings) == warned
