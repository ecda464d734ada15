"""Kernels run as plain Python, straight from their text: no compilation, the same numbers."""

from functools import cache, lru_cache

from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated, plain_kernel

#: a text is compiled once for all states that it is called at
written = lru_cache(maxsize=50)(plain_kernel)


def kernel(mechanism, role):
    """The kernel of a role as an ordinary function."""
    return written(mechanism.structure.programs[role])


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
