"""Scenes share a structure and nothing else: neither numbers nor names pass from one to another."""

import gc
from dataclasses import replace
from functools import partial
from types import CellType, FunctionType, MethodType, ModuleType

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism import build as building
from clearance.mechanism.build import build


def pendulum(stiffness, hinge="P", arm="arm"):
    body = cl.Body(arm, mass=1.0, inertia=1e-3, points={"pin": (-0.1, 0.0)})
    numbers = {"static": 0.3, "kinetic": 0.2, "stribeck_rate": 0.1, "damping": 0.01, "viscous": 0.1}
    friction = cl.joint_lugre(stiffness=stiffness, **numbers)
    return cl.Scene(cl.Revolute(cl.ground, body["pin"], name=hinge, friction=friction))


def test_A1_a_run_does_not_depend_on_what_was_built_before(monkeypatch):
    """Natural sizes come from the scene at hand: bit for bit the same alone and after a stiffer
    scene.
    """
    monkeypatch.setattr(building, "_structures", {})
    alone = cl.simulate(pendulum(50.0), until=0.05, samples=11)
    monkeypatch.setattr(building, "_structures", {})
    stiff = build(pendulum(5e6))
    after = cl.simulate(pendulum(50.0), until=0.05, samples=11)
    assert build(pendulum(50.0)).structure is stiff.structure
    assert after.solver["steps"] == alone.solver["steps"]
    np.testing.assert_array_equal(after["arm"].theta, alone["arm"].theta)
    np.testing.assert_array_equal(after.solver["atol"], alone.solver["atol"])


SCENERY = cl.Scene | cl.Body | cl.Revolute
CONTAINERS = dict | list | tuple | set | frozenset | CellType | MethodType | partial


def held(one):
    """Data that an object holds: not the globals of functions, not the registries of a compiler."""
    if isinstance(one, type | ModuleType):
        return []
    if isinstance(one, FunctionType):
        return [one.__closure__, one.__defaults__, one.__kwdefaults__]
    ours = type(one).__module__.startswith("clearance")
    return gc.get_referents(one) if ours or isinstance(one, CONTAINERS) else []


def scenery(structure):
    """Scenes, bodies and joints to which anything that a structure holds leads back."""
    reached, waiting = set(), list(vars(structure).values())
    for one in waiting:
        if id(one) not in reached:
            reached.add(id(one))
            waiting += held(one)
    return [one for one in waiting if isinstance(one, SCENERY)]


def test_A1_a_structure_holds_no_scene():
    """Nothing that it holds leads back to a scene or its joints."""
    structure = build(pendulum(50.0)).structure
    assert scenery(structure) == []
    layout = structure.layout
    names = (
        layout.coordinates,
        layout.first_order,
        layout.remembering,
        layout.dissipated,
        structure.forced,
    )
    assert all(isinstance(name, str) for group in names for name in group)


HIDING = {
    "closure": lambda scene: lambda: scene,
    "closure of a closure": lambda scene: (lambda inner: lambda: inner)(lambda: scene),
    "default": lambda scene: lambda x, one=scene: one,
    "keyword default": lambda scene: lambda *, one=scene: one,
    "partial": lambda scene: partial(print, scene),
    "bound method": lambda scene: scene.to_json,
    "list in a dict": lambda scene: {"numbers": [1.0, (2.0, scene)]},
    "object of the package": build,
}


def test_A1_a_scene_that_a_structure_holds_is_noticed():
    """The walk above is no empty one: it reaches a scene held by a kernel of the structure, in each
    of these ways.
    """
    scene = pendulum(50.0)
    structure = build(scene).structure
    for way, hide in HIDING.items():
        leaking = replace(structure, derive=hide(scene))
        assert any(one is scene for one in scenery(leaking)), way


def crank(bodies, joints):
    """A slider-crank with a mixed clearance joint, a dyad and a spring, under any names."""
    k, r, s = (cl.Body(n, 0.3, 1e-4, points={"p": (0.0, 0.0), "q": (0.1, 0.0)}) for n in bodies)
    law = cl.lankarani_nikravesh(stiffness=1e9, restitution=0.9, exponent=1.5)
    film = {
        "film": cl.pinkus_sternlicht(),
        "length": 0.01,
        "lubricant": cl.Lubricant(viscosity=0.05),
    }
    gap = {
        "radius": 0.01,
        "clearance": 1e-4,
        "contact": law,
        "friction": cl.coulomb(coefficient=0.1),
    }
    return cl.Scene(
        cl.Revolute(cl.ground, k["p"], name=joints[0]),
        cl.Revolute(k["q"], r["p"], name=joints[1]),
        cl.ClearanceRevolute(
            r["q"],
            s["p"],
            name=joints[2],
            transition=cl.load_sharing(),
            roughness=1e-6,
            **gap,
            **film,
        ),
        cl.Prismatic(cl.ground, s["p"], name=joints[3]),
        cl.SpringDamper(
            cl.ground, s["p"], stiffness=10.0, damping=1.0, free_length=0.1, name=joints[4]
        ),
        cl.Drive(k, speed=10.0, start=0.3, name=joints[5]),
        name="crank",
    )


def test_A3_renaming_traces_and_compiles_nothing():
    """Two names, one trace; the texts and the channels go by the new names."""
    one = build(
        crank(("crank", "rod", "slider"), ("A", "B", "C", "G", "spring", "drive"))
    ).structure
    two = build(crank(("one", "two", "three"), ("Z1", "Y", "X", "W", "V", "U"))).structure
    assert [c.path for c in one.layout.channels] != [c.path for c in two.layout.channels]
    assert one.texts["rhs"] != two.texts["rhs"]
    assert "# joints/X/clearance" in two.texts["rhs"]
    assert one.programs is two.programs
    assert one.digest == two.digest
    assert one.kernel("rhs") is two.kernel("rhs")
    names = {c.path: c.long_name for c in two.layout.channels}
    assert names["bodies/three/x"].startswith("three: ")
    assert names["joints/X/force_x"] == "force x on three"
    texts = "".join([*one.texts.values(), *two.texts.values(), *map(repr, (one, two))])
    assert "⟦" not in texts


def test_A3_an_error_of_the_trace_names_the_parts_of_its_scene(monkeypatch):
    """Also of a scene whose structure is traced for the first time."""
    monkeypatch.setattr(building, "_structures", {})

    class Broken(cl.Torque):
        def act(self, m, w):
            raise ValueError(f"{self.label()} on {self.bodies()[0].name}: broken")

    body = cl.Body("arm", mass=1.0, inertia=1e-3)
    scene = cl.Scene(cl.Revolute(cl.ground, body, name="P"), Broken(body, 1.0, name="wind"))
    with pytest.raises(ValueError, match="^Broken wind on arm: broken$"):
        build(scene)


def test_A3_a_renamed_run_gives_the_same_numbers():
    """Through the same compiled kernel, bit for bit; the file carries the text with its own
    names.
    """
    one = cl.simulate(pendulum(50.0), until=0.05, samples=11)
    two = cl.simulate(pendulum(50.0, "hinge", "rod"), until=0.05, samples=11)
    np.testing.assert_array_equal(one["arm"].theta, two["rod"].theta)
    assert "joints/P/" in one.file.attrs["kernel"]
    assert "joints/hinge/" in two.file.attrs["kernel"]
