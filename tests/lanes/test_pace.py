"""Points in lanes count the warning of a typical impact speed that nothing sets."""

import numpy as np
import pytest

import clearance as cl


def rough_pin(*, push: float = 1.0, memory: bool = True) -> cl.Scene:
    """A rough pin at rest in its oil; push: a force on it [N], memory: a law with an impact
    speed.
    """
    rod = cl.Body("rod", mass=1.0, inertia=1e-3, points={"a": (0.0, 0.0)})
    remembering = cl.lankarani_nikravesh(restitution=0.9)
    pin = cl.ClearanceRevolute(
        cl.ground,
        rod["a"],
        name="A",
        clearance=1e-5,
        radius=0.01,
        length=0.02,
        roughness=4e-7,
        contact=remembering if memory else cl.hunt_crossley_memoryless(dissipation=0.1),
        film=cl.pinkus_sternlicht(),
        transition=cl.superposed(),
        lubricant=cl.Lubricant(viscosity=5e-4),
    )
    return cl.Scene(pin, cl.Force(rod["a"], x=push, y=0.0), gravity=(0.0, 0.0))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("memory", [True, False])
def test_lanes_count_what_runs_warn_of(tmp_path, memory):
    """Forty pushes: as many warnings as the runs have, of laws with an impact speed one more."""
    pushes = np.linspace(0.5, 3.0, 40)
    sweep = cl.sweep(
        rough_pin,
        cl.grid(push=pushes),
        tmp_path / "s",
        fixed={"memory": memory},
        until=2e-3,
        channels=[],
    )
    scenes = [rough_pin(push=push, memory=memory) for push in pushes]
    alone = [cl.simulate(scene, until=2e-3, error=None).warnings for scene in scenes]
    assert sweep.ways.in_lanes == len(pushes)
    assert sweep.costs["warnings"].tolist() == [len(texts) for texts in alone]
    assert all(any("1 rad/s" in t for t in texts) == memory for texts in alone)
