"""Traced scalars: folding, sharing, derivatives, text, derived parameters."""

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from clearance.tracing.emission import Program, Writer, called, derive_text, kernel_text, scheduled
from clearance.tracing.function import Function
from clearance.tracing.kernels import plain, plain_kernel
from clearance.tracing.trace import DerivedParameters, Trace


def run(trace, outputs, **names):
    """Execute the statements of some outputs."""
    scope = {"math": math, **names}
    exec("\n".join(Writer([]).lines(scheduled(outputs), "")), scope)
    return [scope[f"v{o.index}"] if hasattr(o, "index") else o for o in outputs]


def test_structural_zeros_and_ones_leave_no_code():
    """Zeros and ones fold."""
    trace = Trace()
    x = trace.load("x")
    assert x * 0.0 == 0.0
    assert x + 0.0 is x
    assert x * 1.0 is x
    assert x - x == 0.0
    assert 0.0 / x == 0.0
    assert trace.neg(-x) is x


def test_common_terms_are_shared():
    """Equal terms are one object, in any order."""
    trace = Trace()
    x, y = trace.load("x"), trace.load("y")
    assert x * y is y * x
    assert x + y is y + x
    assert trace.sin(x * y) is trace.sin(y * x)


def formula(trace, x, y):
    s = trace.sqrt(x * x + 2.0) / (y + 3.0)
    return trace.sin(s * y) - trace.cos(x) * s + trace.atan2(y, x + 5.0), trace.select(
        x - y, s * x, y * y
    ) - 3.0


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_derivatives(x, y):
    """Central differences, h = 1e-6: 1e-7."""
    if abs(x - y) < 1e-3:
        return
    trace = Trace()
    tx, ty = trace.load("x"), trace.load("y")
    outputs = formula(trace, tx, ty)
    slopes = trace.tangent(outputs, {tx: {0: 1.0}, ty: {1: 1.0}})
    h = 1e-6
    for column, (dx, dy) in enumerate(((h, 0.0), (0.0, h))):
        high, low = run(trace, outputs, x=x + dx, y=y + dy), run(trace, outputs, x=x - dx, y=y - dy)
        for k in range(2):
            (exact,) = run(trace, [slopes[k][column]], x=x, y=y)
            assert exact == pytest.approx((high[k] - low[k]) / (2 * h), abs=1e-7)


def test_what_depends_on_parameters_only_is_computed_once():
    """Terms of parameters leave the kernel."""
    trace = Trace()
    p, q, y = trace.load("par[0]"), trace.load("par[1]"), trace.load("y[0]")
    output = trace.sqrt(p * q + 1.0) * y + p * p
    slots = DerivedParameters(2)
    slots.claim([output])
    program = Program("rhs", {0: output}, slots.index)
    assert "sqrt" not in kernel_text(program, {})
    par, out = np.array([2.0, 4.0, 0.0, 0.0]), np.zeros(1)
    plain(derive_text(slots.index))["derive"](par)
    plain_kernel(program)(0.0, np.array([5.0]), par, out, out)
    assert out[0] == pytest.approx(3.0 * 5.0 + 4.0)


def test_a_traced_scalar_has_no_truth_value():
    """A condition on a traced scalar is refused."""
    trace = Trace()
    with pytest.raises(TypeError, match="select"):
        bool(trace.load("x"))


@pytest.mark.parametrize("seed", range(3))
def test_functions_that_call_each_other_are_collected_once(seed):
    """Forty, each of which calls up to five before it: each behind those that it calls. Paths
    between them are more than can be walked.
    """
    rng, inner = random.Random(seed), {}

    def build(names):
        return lambda trace, x: [sum((trace.call(f, x)[0] for f in names), x[0])]

    for i in range(40):
        names = rng.sample([*inner], min(i, 5))
        inner[Function.of(f"f{i}", 1, build(names))] = names
    trace = Trace()
    collected = called(trace.call([*inner][-1], [trace.load("y[0]")]))
    for i, function in enumerate(collected):
        assert {*inner[function]} <= {*collected[:i]}
    assert len({*collected}) == len(collected) > 20
