"""Requested errors of points in lanes: each has its tolerance, and its numbers are as near to the
truth as requested.
"""

import numpy as np
import pytest

import clearance as cl
from clearance.accuracy.request import PRINTED
from clearance.lanes.point_numbers import NotForLanes
from clearance.sweeping.in_lanes import Together
from clearance.sweeping.requested import Ladder
from tests.seeds import few_of
from tests.sweeping.test_dry_together import ordinary
from tests.sweeping.test_together import scenes

#: case, fixed parameters, speeds [rad/s] and turns
SCENES = {
    "film": ("six_bar_feeder", {"joints": "B"}, (10.0, 50.0), 2.0),
    "mixed": ("six_bar_feeder", {"joints": "B", "model": "mixed"}, (10.0, 50.0), 2.0),
    "dry": ("slider_crank", {"model": "dry"}, (20.0, 60.0), 1.0),
}
POINTS = 24


def swept(name, seed):
    """Speeds and clearances at random."""
    rng = np.random.default_rng(seed)
    clearance = np.exp(rng.uniform(*np.log([5e-5, 4e-4]), POINTS))
    return {"speed": rng.uniform(*SCENES[name][2], POINTS), "clearance": clearance}


def together(name, seed, error):
    """The points, none of which has run but one."""
    case, fixed, _, turns = SCENES[name]
    columns = swept(name, seed)
    return Together(scenes(case, **fixed), columns, {"turns": turns}, None, error), columns


def printed(name):
    """A number that a request of all is about."""
    ends = [pattern.rpartition("*")[2] for pattern in PRINTED]
    return name.endswith((*ends, "_torque_max")) and name.startswith(("joint_", "drive_"))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("seed", few_of(range(8), 1))
@pytest.mark.parametrize("error", [1e-2, 1e-3])
def test_errors(name, seed, error):
    """Of requested numbers 90 % lie within their errors of a run at rtol 1e-10.

    98 % lie within five times, as two runs may err alike by chance: one dry peak was seven off. Dry
    points that part by then are left out: the run at 1e-9 is not within a tenth of the error.
    """
    group, columns = together(name, seed, error)
    scene, options = group.scene_of, {"turns": SCENES[name][3]}
    within = []
    for part in Ladder(group, columns).climb():
        for row, point in list(enumerate(part.places.tolist()))[:4]:
            values = {n: v[point].item() for n, v in columns.items()}
            truth, looser = (
                ordinary(scene, values, options | {"rtol": r})[0] for r in (1e-10, 1e-9)
            )
            for metric in filter(printed, part.values):
                size = error * abs(truth[metric])
                if abs(looser[metric] - truth[metric]) < 0.1 * size:
                    apart = abs(part.values[metric][row] - truth[metric])
                    within.append(apart / size)
    assert len(within) > 10
    assert np.mean(np.array(within) <= 1.0) >= 0.9
    assert np.mean(np.array(within) <= 5.0) >= 0.98


@pytest.mark.parametrize("name", SCENES)
def test_company(name):
    """A point has the same tolerance, numbers and errors, bit for bit, whatever runs beside."""
    group, columns = together(name, 3, 1e-3)
    mixed = np.random.default_rng(4).permutation(POINTS)[:9]
    rows = []
    for chosen in (np.arange(POINTS), mixed):
        some = {n: v[chosen] for n, v in columns.items()}
        parts = list(Ladder(group, some).climb())
        rows.append(
            {
                chosen[point]: [v[row] for v in (part.values | part.stated).values()]
                + [part.points.rtol[row], part.answers.steps[row]]
                for part in parts
                for row, point in enumerate(part.places)
            }
        )
    every, some = rows
    assert set(some) == set(every) & set(mixed)
    assert len({row[-2] for row in every.values()}) > 1
    for point, row in some.items():
        np.testing.assert_array_equal(row, every[point])


def test_a_trajectory(tmp_path):
    """Requested of the trajectory: points are done with their errors, which are small."""
    points = cl.grid(speed=np.linspace(20.0, 50.0, 6), clearance=[1e-4, 2e-4, 3e-4, 4e-4])
    options = {"fixed": {"joints": "B"}, "turns": 2, "channels": [], "workers": 1}
    swept = cl.sweep("six_bar_feeder", points, tmp_path, error={"trajectory": 1e-3}, **options)
    assert swept.ways.in_lanes == 24
    assert swept.done.all()
    share = swept.metrics["joint_B_force_max_error"] / swept.metrics["joint_B_force_max"]
    assert (share < 1e-2).all()


@pytest.mark.parametrize("name", ["four_bar", "double_pendulum"])
def test_mechanisms_without_a_guide(name, tmp_path):
    """Nothing slides on the ground, so that there is no ideal motion: points reach their errors."""
    length = {"until": 0.1} if name == "double_pendulum" else {"turns": 0.1}
    fixed = {"model": "lubricated"} if name == "four_bar" else {}
    points = cl.grid(speed=[8.0, 9.0]) if name == "four_bar" else cl.grid(length=[0.4])
    options = {"fixed": fixed, "channels": [], "workers": 1, "progress": False}
    swept = cl.sweep(name, points, tmp_path / "s", error=1e-3, **length, **options)
    assert swept.done.all()


def test_errors_that_are_not_reached(tmp_path):
    """Errors that a film table alone exceeds: the ordinary way gives the reason."""
    points = cl.grid(speed=np.linspace(20.0, 50.0, 6), clearance=[1e-4, 2e-4, 3e-4, 4e-4])
    options = {"fixed": {"joints": "B"}, "turns": 2, "channels": [], "workers": 1}
    swept = cl.sweep("six_bar_feeder", points, tmp_path, error=1e-5, **options)
    assert not swept.done.any()
    assert all("the film table alone makes" in reason for reason in swept.reason)
    assert any("do not reach the requested errors" in reason for reason in swept.ways.reasons)


def test_requests_that_do_not_suit():
    """Extremes along time are compared the ordinary way."""
    with pytest.raises(NotForLanes, match="the error of bodies/slider/ax_max is requested"):
        together("film", 0, {"bodies/slider/ax_max": 1e-3})
