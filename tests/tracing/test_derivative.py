"""Derivatives written from law sources, against central differences."""

import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import compiled, evaluated
from tests.differences import slopes
from tests.plain import differentiated

SLOPE = 3.0


def helper(a, b):
    if a > b:
        return a * b, a - b
    return a / (1.0 + b * b), b


def plain(x, y, gain):
    return gain * x**3 - math.sin(x * y) / (2.0 + math.cos(y)) + SLOPE * abs(x)


def branching(x, y, gain):
    total = 0.0
    if x > y:
        total = x * x
    elif x > -1.0:
        total = -y * x
    else:
        total += gain * math.exp(-x * x)
    return max(total, 0.1 * x, -5.0) + min(x, y)


def looping(x, y, gain):
    total, term = 0.0, 1.0
    for k in range(1, 8):
        term *= x / k
        if k > 5:
            continue
        total += term * math.atan2(y, 2.0 + x * x)
    while total > 3.0:
        total = 0.5 * total + 0.1 * y
    return total


def powers(x, y, gain):
    base = 1.0 + x * x
    return base**gain + base ** (0.5 * y) - math.log(base) ** 2


def check(function, state, rest, active, tolerance=1e-7):
    """Central differences with h = 1e-6: 1e-7 of the value's size."""
    actual = differentiated(function, active)(*state, *rest)
    value = function(*state, *rest)
    values = value if isinstance(value, tuple) else (value,)
    assert actual[: len(values)] == pytest.approx(values, rel=1e-14)
    numbers = [float(state[i]) for i in active]

    def moved(*at):
        arguments = dict(enumerate(state)) | dict(zip(active, at, strict=True))
        return np.atleast_1d(function(*arguments.values(), *rest))

    wanted = slopes(moved, numbers, 1e-6 * np.maximum(np.abs(numbers), 1.0))
    size = np.maximum(1.0, np.abs(np.array(values, dtype=float)))[:, None]
    off = np.abs(np.reshape(actual[len(values) :], wanted.shape) - wanted)
    assert (off <= tolerance * np.maximum(size, np.abs(wanted))).all()


@pytest.mark.parametrize("function", [plain, looping, powers])
@given(st.floats(-2, 2), st.floats(-2, 2))
def test_smooth_functions(function, x, y):
    """Functions of the library, away from their corners: 1e-6."""
    if abs(x) < 1e-4 or abs(y) < 1e-4:
        return
    check(function, (x, y), (1.7,), (0, 1), 1e-6)


@pytest.mark.parametrize("state", [(1.3, 0.4), (0.2, 0.9), (-1.6, 0.3), (-0.4, 1.7), (1.9, -1.2)])
@pytest.mark.parametrize("function", [branching])
def test_branches(function, state):
    """On each side of a branch."""
    check(function, state, (1.7,), (0, 1))


@pytest.mark.parametrize("active", [(0,), (1,), (0, 1)])
def test_only_the_wanted_arguments(active):
    """Slopes of a choice of arguments."""
    check(plain, (0.7, -0.3), (1.1,), active)


def test_helpers_are_differentiated_too():
    """Helpers and reassigned names."""

    def law(x, y, gain):
        p, q = helper(x, y)
        p, q = q, p
        return p * math.hypot(p, 1.0 + q * q), math.sqrt(1.0 + x * x) * gain

    check(law, (0.7, 0.2), (1.1,), (0, 1))
    check(law, (0.1, 0.8), (1.1,), (0, 1))


def indexing(x, y, gain):
    return helper(x, y)[0] * helper(y, x)[1] + float(x) * y


def masking(x, y, gain):
    return (
        (x > 0.3) * x + y * (x < y) + math.copysign(gain * x, y) + (1.0 if x > y and y > 0.0 else x)
    )


def delegating(x, y, gain):
    if x > 0.0:
        return helper(x * gain, y)
    return x, y


def choosing(x, y, gain):
    return x > 0.5 and x * y or y


def scaled(x, factor=2.0, /, shift=0.5, *, power=2):
    return factor * x**power + shift


def helped_by_name(x, y, gain=1.0):
    [a, b] = [scaled(x), scaled(y, 3.0, power=3)]
    return a + scaled(y, shift=x) * b


def of_tuples(x, y, gain):
    total = max((x, y, 0.5)) * math.hypot(x, y, gain)
    for a, b in ((x, 1.0), (y, 2.0)):
        total += a * b * bool(x)
    return total


def other_units(x, y, gain):
    return math.log10(1.0 + x * x) + math.log2(2.0 + y * y), math.degrees(x) * math.radians(y)


def reusing(x, y, gain):
    a = b = x * y
    total = a + gain * b
    for x in range(1, 3):
        total += x * y
    return total + x if not y > 5.0 else total


@pytest.mark.parametrize("state", [(0.7, 0.2), (0.1, 0.8), (1.4, -0.6)])
@pytest.mark.parametrize(
    "function",
    [indexing, masking, delegating, reusing, choosing, helped_by_name, of_tuples, other_units],
)
def test_less_usual_constructs(function, state):
    """Loops, ternaries and other constructs."""
    check(function, state, (1.3,), (0, 1))


def closing_over(factor):
    def law(x, y, gain):
        return factor * x * x + SLOPE * y

    return law


def test_closures_and_globals_are_read_where_the_law_stands():
    """Each closure has its own numbers."""
    assert differentiated(closing_over(5.0), (0,))(2.0, 1.0, 0.0) == (23.0, 20.0)
    laws_apart = [evaluated(traced(closing_over(f))) for f in (2.0, 7.0)]
    assert [law(1.0, 0.0, 0.0) for law in laws_apart] == [(2.0,), (7.0,)]


def summing(x, y, gain):
    return sum([x, y])


def slicing(x, y, gain):
    return (x, y, gain)[1:][0]


def forgetting(x, y, gain):
    if x > 0.0:
        return x  # noqa: RET503


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (summing, "law summing uses 'sum'"),
        (slicing, "law slicing: cannot read"),
        (forgetting, "law forgetting can end without returning a value"),
        (lambda x: x, "must be a function defined with def|no source found"),
    ],
)
def test_unreadable_laws_are_refused_by_name(function, message):
    """A law that cannot be read is named."""
    with pytest.raises(ValueError, match=message):
        differentiated(function, (0,))


def clipped(x, y, gain):
    depth = max(min(x, 1.0), 0.0)
    return gain * depth**1.5 + math.sqrt(2.0 * depth), math.acos(min(y, 1.0)) + depth**0.3


@pytest.mark.parametrize("state", [(-0.5, 1.5), (1.5, 0.3), (0.4, 1.5)])
def test_a_flat_side_has_no_slope_where_the_other_is_steep(state):
    """Clipped functions have no slope beyond the clip."""
    check(clipped, state, (1.3,), (0, 1))


# --- what Python does, construct by construct
k = 5.0


def logarithm(x, y, gain):
    return math.log(abs(x) + 1.0, 2.0) + math.fmod(x, 0.3) + x // 0.1 + int(y / 49.0)


def set_on_one_side(x, y, gain):
    if x > 0.0:
        k = 2.0 * x
    if x > 0.0:
        return k
    return gain


def leaving_loops(x, y, gain):
    total = 0.0
    for i in range(6):
        if i * x > 1.5:
            break
        if i == 2:
            continue
        for j in (x, y):
            if j > 1.0:
                return total, j
            total += j * i
    return total, y


def counted(x, y, gain):
    total = 0.0
    for i in range(int(abs(10.0 * x)), 0, -2):
        if total > 3.0:
            break
        total += math.sin(i * y)
    return total


def only_where_needed(x, y, gain):
    if x == 0.0:
        return 1.0
    step, size = 0.0, x
    while size != 0.0:
        step, size = size, 0.5 * size if abs(size) > 1e-3 else 0.0
    if y > 0.0:
        return step
    return step + size


def flagged(x, y, gain):
    fast = False
    if x > 0.5:
        fast = y > 0.0
    count = 0.0
    while not (fast or count > 3.0):
        count, fast = count + 1.0, count * x > 1.0
    return max(x, 1.0, y) if fast and x > y else min(0.25, x, y, -0.5) + count + helper(x > y, y)[0]


def scattered(x, y, gain):
    a = helper(x, 2.0)[0]
    b = math.sin(a) - max(y, 1.0, x)
    return (
        max(4.5, a * b, int(x), min(0.25, b, y, -0.5))
        if x < 1.0 or a > b
        else math.sqrt(x - 1.0) * b
    )


@pytest.mark.parametrize("x", [-3.0, -0.4, 0.0, 0.3, 1.0, 49.0])
@pytest.mark.parametrize("y", [-2.0, 0.0, 0.7, 49.0, 98.0])
@pytest.mark.parametrize(
    "law",
    [logarithm, set_on_one_side, leaving_loops, counted, only_where_needed, flagged, scattered],
)
def test_a_traced_law_is_its_function(law, x, y):
    """To 1e-14: as plain Python from its text, and compiled."""
    wanted = law(x, y, 1.3)
    wanted = wanted if isinstance(wanted, tuple) else (wanted,)
    function = traced(law)
    assert evaluated(function)(x, y, 1.3) == pytest.approx(wanted, rel=1e-14, abs=1e-14)
    if law not in COMPILED:
        COMPILED[law] = compiled(function)
    actual, par = np.empty(function.count), np.zeros(1)
    COMPILED[law](0.0, np.array([x, y, 1.3]), par, par, actual)
    assert tuple(actual) == pytest.approx(wanted, rel=1e-14, abs=1e-14)


COMPILED: dict = {}


def doubled(function):
    @functools.wraps(function)
    def twice(*arguments):
        return 2.0 * function(*arguments)

    return twice


def otherwise(x, y, gain):
    while x > 0.0:
        x -= 1.0
    else:
        x = y
    return x


def too_early(x, y, gain):
    total = total + x  # noqa: F821
    return total


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (doubled(plain), "law plain: a decorator wraps it"),
        (otherwise, "law otherwise: cannot read 'while"),
        (too_early, "law too_early reads 'total' before it is set"),
    ],
)
def test_what_would_be_another_function_is_refused(law, message):
    """Constructs that a trace would change are refused."""
    with pytest.raises(ValueError, match=message):
        traced(law)
