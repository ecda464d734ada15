"""Kernels run as plain Python, straight from their text: no compilation, the same numbers."""

from functools import cache, lru_cache, partial

import numpy as np

from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated, plain_kernel
from tests.differences import answer, jacobian_and_differences

#: a text is compiled once for all states that it is called at
written = lru_cache(maxsize=50)(plain_kernel)


def kernel(mechanism, role):
    """The kernel of a role as an ordinary function."""
    return written(mechanism.structure.programs[role])


def observed(mechanism, t=0.0, y=None, work=None):
    """One row of output channels as a dict."""
    channels, y = mechanism.layout.channels, mechanism.y0 if y is None else y
    row = answer(mechanism, "observe", y, len(channels), t, work, partial(kernel, mechanism))
    return {c.path: float(v) for c, v in zip(channels, row, strict=True)}


def jacobian_error(mechanism, y, t=0.0, work=None, compiled=False):
    """Largest difference of the Jacobian from central differences of the right-hand side, in each
    column as a share of its largest entry: good to 1e-6.
    """
    of = None if compiled else partial(kernel, mechanism)
    options = {"t": t, "work": work, "kernel": of}
    actual, wanted = jacobian_and_differences(mechanism, y, 1e-6, **options)
    apart, largest = (np.abs(m).max(axis=0) for m in (actual - wanted, wanted))
    return (apart[apart > 0.0] / largest[apart > 0.0]).max(initial=0.0)


@cache
def differentiated(function, active, kinds=()):
    """Values and, output by output, exact derivatives by the active arguments: a function of the
    same arguments.
    """
    kinds = kinds or ("number",) * function.__code__.co_argcount
    slopes = evaluated(traced(function, kinds).slopes(tuple(active)))

    def values(*arguments):
        numbers, data = [], ()
        for kind, value in zip(kinds, arguments, strict=True):
            if kind == "data":
                data = value
            else:
                numbers += [value] if kind == "number" else list(value)
        return slopes(*numbers, par=data)

    return values
