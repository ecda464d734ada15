"""A function or a scene is a case wherever a case is."""

import importlib
import random
import sys
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.scene.catalogue import find_case

MACHINES = """
import functools
import clearance as cl
from dampers import drag


def machine(speed: float = 9.0, *, mass: float = 1.0, wide: bool = False,
            options: cl.JointOptions = cl.JointOptions(joints="A", model="dry")) -> cl.Scene:
    \"\"\"A pendulum that is turned.

    speed: of its drive [rad/s]
    mass: of the wheel [kg]
    \"\"\"
    wheel = cl.Body("wheel", mass, 1e-2, com=(0.02 if wide else 0.01, 0.0))
    hinge = cl.Revolute(cl.ground, wheel, name="A", friction=drag(coefficient=0.2), pin_radius=0.01)
    return cl.Scene(hinge, cl.Drive(wheel, speed=speed, start=0.0), name="machine")


def dry(*, speed: float = 314.0, clearance: float = 1e-3):
    return cl.load_case("slider_crank", model="dry", speed=speed, clearance=clearance,
                        friction="coulomb")


@functools.wraps(dry)
def wrapped(**values):
    return dry(**values)
"""
DAMPERS = """
from clearance.laws import joint_friction


@joint_friction
def drag(rate, load, coefficient):
    \"\"\"Drag [N m].\"\"\"
    return -coefficient * load * rate
"""


@pytest.fixture
def machines(tmp_path, monkeypatch):
    """A user's module that is imported as any other, from a folder with a blank."""
    folder = tmp_path / "my machines ö"
    folder.mkdir()
    (folder / "machines.py").write_text(MACHINES)
    (folder / "dampers.py").write_text(DAMPERS)
    monkeypatch.syspath_prepend(folder)
    yield importlib.import_module("machines")
    for name in ("machines", "dampers"):
        sys.modules.pop(name, None)


def test_users12_a_function_is_swept_from_any_folder_and_resumed(machines, tmp_path, monkeypatch):
    """Its numbers are those of its scenes one by one; a second call runs nothing."""
    monkeypatch.chdir(tmp_path)
    speeds = [5.0, 9.0, 11.0]
    options = {"fixed": {"mass": 2.0}, "turns": 1, "workers": 2, "error": "state"}
    swept = cl.sweep(machines.machine, cl.grid(speed=speeds), "swept", **options)
    assert swept.done.all()
    for i, speed in enumerate(speeds):
        run = cl.simulate(machines.machine(speed, mass=2.0), turns=1)
        with cl.open_result(swept.folder / "runs" / f"{swept.definition.keys[i]}.h5") as stored:
            drive = "drives/wheel/torque"
            np.testing.assert_array_equal(stored.values(drive), run.values(drive))
    times = {p: p.stat().st_mtime_ns for p in (tmp_path / "swept" / "runs").glob("*.h5")}
    again = cl.sweep(machines.machine, cl.grid(speed=speeds), "swept", **options)
    assert again.done.all()
    assert {p: p.stat().st_mtime_ns for p in times} == times
    reference = f"{machines.__file__}:machine"
    assert cl.sweep(reference, cl.grid(speed=speeds), "swept", **options).done.all()


def test_users12_a_scene_is_swept_over_its_numbers(tmp_path):
    """Of a scene that no case made: "bodies/wheel/mass"; of another: its parameters, the rest as
    it has them.
    """
    body = cl.Body("wheel", 1.0, 1e-2, com=(0.01, 0.0))
    scene = cl.Scene(
        cl.Revolute(cl.ground, body, name="A"), cl.Drive(body, speed=9.0, start=0.0), name="plain"
    )
    masses = [1.0, 2.0, 3.0]
    points = cl.grid(**{"bodies/wheel/mass": masses})
    swept = cl.sweep(scene, points, tmp_path / "plain", turns=1, workers=1)
    assert swept.done.all()
    torque = swept.metrics["drive_wheel_torque_max"]
    np.testing.assert_allclose(torque / torque[0], masses, rtol=1e-6)
    assert cl.open_sweep(tmp_path / "plain").done.all()
    base = cl.load_case("slider_crank", model="ideal", speed=20.0)
    swept = cl.sweep(base, cl.grid(speed=[10.0, 20.0]), tmp_path / "made", turns=1, workers=1)
    assert swept.definition.fixed == {"model": "ideal"}
    with pytest.raises(ValueError, match="has no parameter 'spead'"):
        cl.sweep(scene, cl.grid(spead=[1.0, 2.0]), tmp_path / "other", turns=1)


def test_users12_studies_take_functions(machines, tmp_path):
    """The same as with the scenes that they make."""
    reference = cl.steady(machines.dry(), 1e-4)
    for case in (machines.dry, machines.wrapped, lambda *, speed=314.0: machines.dry(speed=speed)):
        assert cl.steady(case, 1e-4).states == reference.states
    branch = cl.follow(machines.dry, "speed", 314.0, 318.0, points=3, tolerance=1e-4)
    assert len(branch.points) == 3
    assert cl.load_case(machines.machine, mass=3.0).bodies[0].mass == 3.0
    scattered = cl.scatter(
        machines.machine,
        {"mass": "normal(1.0, 0.05)"},
        tmp_path / "scatter",
        points=32,
        turns=1,
        workers=1,
    )
    assert len(scattered.sweep) > 8


def test_functions_that_workers_cannot_load_are_refused(machines, tmp_path):
    """With the reason, before anything is written; studies in this process take them."""

    def inside(*, speed=9.0):
        return machines.machine(speed)

    for function in (inside, lambda speed=9.0: machines.machine(speed)):
        with pytest.raises(ValueError, match="put the function at the top level of a file"):
            cl.sweep(function, cl.grid(speed=[1.0, 2.0]), tmp_path / "out", turns=1)
        assert cl.load_case(function, speed=3.0).name == "machine"
    assert not (tmp_path / "out").exists()
    for case in (7, None, [1], object()):
        with pytest.raises(TypeError, match="a case is the name of a case, a file, a function or"):
            cl.sweep(case, cl.grid(speed=[1.0, 2.0]), tmp_path / "out", turns=1)


def test_parameters_of_any_function(machines):
    """200 signatures drawn at random: keywords with defaults are parameters, others are named."""
    draw = random.Random(8)
    for _ in range(200):
        names = draw.sample(["speed", "mass", "höhe", "n", "flag"], draw.randint(1, 4))
        kind = draw.choice(["plain", "keyword", "positional", "needed"])
        defaults = {n: draw.choice([1.5, 2, True, "dry", None]) for n in names}
        words = [f"{n}={defaults[n]!r}" for n in names]
        if kind == "needed":
            words[0] = names[0]
        before, after = ("*, " if kind == "keyword" else ""), ", /" * (kind == "positional")
        scope = {"machine": machines.machine}
        exec(f"def mine({before}{', '.join(words)}{after}): return machine()", scope)
        if kind in ("needed", "positional"):
            with pytest.raises(ValueError, match=f"case mine: parameter {names[0]!r}"):
                find_case(scope["mine"])
            continue
        case = find_case(scope["mine"])
        assert {n: p.default for n, p in case.parameters.items()} == defaults
        assert case.scene(**dict(draw.sample(list(defaults.items()), 1))).name == "machine"


def test_the_command_line_takes_a_function_of_a_file(machines, tmp_path, typed):
    """FILE.py:function is a case; a missing function is named."""
    reference = Path(f"{machines.__file__}:machine")
    out = tmp_path / "run.h5"
    typed("run", reference, "-p mass=2 --turns 1 -o", out)
    with cl.open_result(out) as run:
        assert run.complete
    assert "must define a function nothing(...)" in typed.line(
        "run", Path(f"{machines.__file__}:nothing"), "-o", out
    )
