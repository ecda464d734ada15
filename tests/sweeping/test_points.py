"""The points of a sweep: what the user means is what is run."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import clearance as cl
from clearance.scene.catalogue import find_case
from clearance.sweeping.points import from_words, range_from_words, spread_out

CASE = find_case("six_bar_feeder").parameters


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4))
def test_a_grid_has_every_combination_once_last_fastest(sizes):
    """The order is that of nested loops."""
    values = {f"p{i}": [10.0 * i + k for k in range(n)] for i, n in enumerate(sizes)}
    points = cl.grid(**values)
    assert [tuple(points[i].values()) for i in range(len(points))] == list(
        itertools.product(*values.values())
    )
    assert points.axes == tuple(((n,), len(v)) for n, v in values.items())


def test_lists_that_go_together_and_products():
    """Lists run in parallel; a product combines them with others."""
    points = cl.zipped(speed=[1.0, 2.0, 3.0], viscosity=[0.1, 0.2, 0.3]) * cl.grid(
        model=["dry", "lubricated"]
    )
    assert len(points) == 6
    assert points[3] == {"speed": 2.0, "viscosity": 0.2, "model": "lubricated"}
    with pytest.raises(ValueError, match="different lengths: speed 2, viscosity 1"):
        cl.zipped(speed=[1.0, 2.0], viscosity=[0.1])
    with pytest.raises(ValueError, match="speed is swept twice"):
        cl.grid(speed=[1.0]) * cl.grid(speed=[2.0])


@settings(max_examples=25)
@given(st.integers(2, 200), st.integers(0, 2**32 - 1))
def test_a_latin_hypercube_has_one_point_in_every_slice(count, seed):
    """Of even and of logarithmic ranges; a seed decides the points."""
    points = cl.sampled(count, seed=seed, speed=(10.0, 20.0), clearance=(1e-5, 1e-3, "log"))
    slices = np.floor((np.array(points.columns["speed"]) - 10.0) / 10.0 * count)
    assert sorted(slices) == list(range(count))
    decades = np.log(np.array(points.columns["clearance"]) / 1e-5) / math.log(100.0)
    # a point may sit on a boundary to rounding of the logarithm
    assert sorted(np.floor(decades * count + 1e-9)) == list(range(count))
    assert points == cl.sampled(count, seed=seed, speed=(10.0, 20.0), clearance=(1e-5, 1e-3, "log"))


def test_random_points_and_choices():
    """Within the range; choices are fair; seeds differ."""
    points = cl.sampled(400, kind="random", seed=3, speed=(10.0, 20.0), model=["dry", "lubricated"])
    assert min(points.columns["speed"]) >= 10.0
    assert max(points.columns["speed"]) <= 20.0
    # 400 fair draws: 5 standard deviations are 50
    assert abs(points.columns["model"].count("dry") - 200) < 50
    assert points != cl.sampled(
        400, kind="random", seed=4, speed=(10.0, 20.0), model=["dry", "lubricated"]
    )


def test_words_of_the_command_line():
    """Ranges, lists, names and switches, with units."""
    np.testing.assert_allclose(
        from_words(CASE["speed"], "100rpm:300rpm:3"), [cl.rpm(n) for n in (100, 200, 300)]
    )
    np.testing.assert_allclose(
        from_words(CASE["clearance"], "10um:1mm:3:log"), [1e-5, 1e-4, 1e-3], rtol=1e-12
    )
    assert from_words(CASE["clearance"], "0.1mm,0.2mm") == [1e-4, 2e-4]
    assert from_words(CASE["joints"], "B;B,C") == ["B", "B,C"]
    assert from_words(CASE["model"], "dry,lubricated") == ["dry", "lubricated"]
    assert from_words(CASE["film_torques"], "on,off") == [True, False]
    assert range_from_words(CASE["speed"], "60rpm:120rpm") == (2.0 * math.pi, 4.0 * math.pi)
    assert range_from_words(CASE["clearance"], "10um:1mm:log") == (pytest.approx(1e-5), 1e-3, "log")


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("speed", "100rpm:300rpm", "a range is LO:HI:N"),
        ("speed", "100rpm:300rpm:0", "is empty"),
        ("speed", "100rpm:300rpm:1", "must begin where it ends"),
        ("speed", "0:300rpm:4:log", "must be positive"),
        ("speed", "1:2:3:lin", "LO:HI:N:log"),
        ("speed", "20,,30", "empty value"),
        ("speed", "quick", "speed: "),
        ("clearance", "1kg", "clearance: "),
    ],
)
def test_bad_words(name, text, reason):
    """The message has the parameter and the reason."""
    with pytest.raises(ValueError, match=reason) as error:
        from_words(CASE[name], text)
    assert name in str(error.value)


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda: cl.grid(speed=[]), "speed: the range is empty"),
        (lambda: cl.grid(speed=[1.0, 1.0]), "stands twice"),
        (lambda: cl.grid(speed=[1.0, math.nan]), "speed"),
        (lambda: cl.sampled(0, speed=(1.0, 2.0)), "count"),
        (lambda: cl.sampled(3), "at least one range"),
        (lambda: cl.sampled(3, kind="sobol", speed=(1.0, 2.0)), "latin, random"),
        (lambda: cl.sampled(3, speed=(2.0, 1.0)), "range from 2 to 1 is empty"),
        (lambda: cl.sampled(3, speed=(0.0, 1.0, "log")), "must be positive"),
        (lambda: cl.sampled(3, speed=1.0), "expected"),
    ],
)
def test_bad_points(call, reason):
    """Calls that make no points are refused with the reason."""
    with pytest.raises(ValueError, match=reason):
        call()


def test_columns_along_their_axes():
    """A grid is stored as its axes; what is read is what was written."""
    points = (
        cl.grid(speed=[1.0, 2.0, 3.0])
        * cl.zipped(clearance=[1e-4, 2e-4], joints=["B", "C"])
        * cl.grid(model=["dry"])
    )
    along = points.along
    assert {name: len(values) for name, values in along.items()} == {
        "speed": 3,
        "clearance": 2,
        "joints": 2,
        "model": 1,
    }
    assert spread_out(along, points.axes) == points.columns
    assert spread_out(points.columns, points.axes) == points.columns
