"""Functions written here instead of called: accuracy and edges, against longer numbers."""

import math

import llvmlite.ir as ir
import numpy as np
import pytest

from clearance.lanes.code import Code, begin, callable_at, new_module
from clearance.tracing.elementary import FUNCTIONS
from clearance.tracing.lanes import Lanes

WIDTHS = (1, 4, 8)
STRANGE = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 5e-324, 1e-310, 1e308]
PAIRS = {"pow": np.power, "atan2": np.arctan2}
# of both arguments
RANGES = {
    "sin": [(-1e6, 1e6, 0.0, 1.0), (-4.0, 4.0, 0.0, 1.0)],
    "cos": [(-1e6, 1e6, 0.0, 1.0), (-4.0, 4.0, 0.0, 1.0)],
    "log": [(0.0, 3.0, 0.0, 1.0), (0.99, 1.01, 0.0, 1.0), (0.0, 1e300, 0.0, 1.0)],
    "exp": [(-720.0, 709.0, 0.0, 1.0), (-1e-3, 1e-3, 0.0, 1.0)],
    "pow": [(1e-3, 4.0, -30.0, 30.0), (1e-12, 1e-3, 1.4, 1.6)],
    "atan2": [(-1.0, 1.0, -1.0, 1.0), (0.0, 1e-9, -1.0, 1.0)],
}


def functions(width):
    """All functions of a width, by name: f(x, y) of arrays of numbers."""
    module = new_module()
    for name in FUNCTIONS:
        function = begin(module, f"written_{name}", 3)
        builder = ir.IRBuilder(function.append_basic_block())
        arrays = dict(zip(("x", "y", "out"), function.args, strict=True))
        lowering = Lanes(builder, arrays, None, {}, width)
        arguments = [lowering.load("x", 0), lowering.load("y", 0)]
        value = lowering.function(name, arguments[: 2 if name in PAIRS else 1])
        builder.store(value, lowering.entry("out", 0), align=8)
        builder.ret_void()
    code = Code(module)

    def function(name):
        call = callable_at(code.address(f"written_{name}"), 3)

        def of(x, y):
            out = np.empty_like(x)
            for i in range(0, len(x), width):
                call(*(a[i:].ctypes.data for a in (x, y, out)))
            return out

        return of

    return {name: function(name) for name in FUNCTIONS} | {"code": code}


def reference(name, x, y):
    """The value with eleven bits more, where nothing is raised."""
    x, y = x.astype(np.longdouble), y.astype(np.longdouble)
    with np.errstate(all="ignore"):
        return PAIRS[name](x, y) if name in PAIRS else getattr(np, name)(x)


@pytest.mark.parametrize("width", WIDTHS)
def test_accuracy(width):
    """Two units in the last place over 4000 arguments of each range."""
    compiled, rng = functions(width), np.random.default_rng(3)
    for name, ranges in RANGES.items():
        for low, high, below, above in ranges:
            x, y = rng.uniform(low, high, 4000), rng.uniform(below, above, 4000)
            values, expected = compiled[name](x, y), reference(name, x, y)
            unit = np.spacing(np.abs(expected).astype(float))
            assert (np.abs(values - expected) <= 2.0 * unit).all(), (name, low, high)


@pytest.mark.parametrize("width", WIDTHS)
def test_edges(width):
    """As the C library where arguments are zero, infinite, no number, tiny or huge (1e-15)."""
    compiled = functions(width)
    x, y = (np.ravel(a) for a in np.meshgrid(np.resize(STRANGE, 16), np.resize(STRANGE, 16)))
    for name in FUNCTIONS:
        with np.errstate(all="ignore"):
            expected = PAIRS[name](x, y) if name in PAIRS else getattr(np, name)(x)
        np.testing.assert_allclose(compiled[name](x, y), expected, rtol=1e-15, err_msg=name)


def test_bits_do_not_depend_on_the_width():
    """One number alone has the bits of one among eight."""
    alone, together = functions(1), functions(8)
    x, y = np.random.default_rng(5).uniform(1e-6, 30.0, (2, 4000))
    for name in FUNCTIONS:
        np.testing.assert_array_equal(alone[name](x, y), together[name](x, y))
