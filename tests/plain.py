"""Kernels run as plain Python, straight from their text: no compilation, the same numbers."""

from functools import cache, lru_cache, partial

import numpy as np

from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated, plain_kernel

#: a text is compiled once for all states that it is called at
written = lru_cache(maxsize=50)(plain_kernel)


def kernel(mechanism, role):
    """The kernel of a role as an ordinary function."""
    return written(mechanism.structure.programs[role])


def observed(mechanism, t=0.0, y=None, work=None):
    """One row of output channels as a dict."""
    channels = mechanism.layout.channels
    out = np.zeros(len(channels))
    y = mechanism.y0 if y is None else y
    work = mechanism.work0 if work is None else work
    kernel(mechanism, "observe")(t, y, mechanism.par, np.append(work, 0.0), out)
    return {c.path: float(v) for c, v in zip(channels, out, strict=True)}


def jacobian_error(mechanism, y, t=0.0, work=None, compiled=False):
    """Largest difference of the Jacobian from central differences of the right-hand side, in each
    column as a share of its largest entry: good to 1e-6.
    """
    of = mechanism.kernel if compiled else partial(kernel, mechanism)
    work = np.append(mechanism.work0 if work is None else work, 0.0)
    n, rates = mechanism.size, np.zeros((2, y.size))
    matrix, shares = np.zeros(n * n), []
    of("jacobian")(t, y, mechanism.par, work.copy(), matrix)
    for column, size in zip(matrix.reshape(n, n).T, mechanism.scale, strict=True):
        step = 1e-6 * size * (np.arange(y.size) == len(shares))
        for rate, moved in zip(rates, (y + step, y - step), strict=True):
            of("rhs")(t, moved, mechanism.par, work.copy(), rate)
        slope = (rates[0] - rates[1])[:n] / (2e-6 * size)
        shares.append(np.abs(column - slope).max() / np.abs(slope).max())
    return max(shares)


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
