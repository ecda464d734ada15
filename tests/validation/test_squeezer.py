"""Andrews' squeezing mechanism against the published solution of its differential equations."""

import pytest

import clearance as cl
from tests.benchmarks.squeezer import scene

#: angles after 0.03 s [rad]: Test Set for Initial Value Problem Solvers, components 1, 3, 5, 7
PUBLISHED = {
    "K1": 15.81077119629904,
    "K3": 0.04082224013073101,
    "K5": 0.5244099658805304,
    "K7": 1.048080741042263,
}


@pytest.mark.parametrize("method", ["dop853", "radau9"])
def test_angles_after_sixteen_radians(method):
    """Two methods at rtol 1e-12: 3e-9 rad, of which the published crank angle errs by 1.1e-9."""
    run = cl.simulate(scene(), until=0.03, rtol=1e-12, method=method, samples=2, error=None)
    for name, angle in PUBLISHED.items():
        assert run[name].theta[-1] == pytest.approx(angle, abs=3e-9)
