"""Types the steppers share: one signature a role, so every stepper takes every kernel and the loop
every stepper.
"""

import logging
from pathlib import Path
from typing import ClassVar

import numba
from numba.core import event as events
from numba.core.compiler import Compiler

from clearance.files.sealed import digest_of_code
from clearance.machine.store import (
    COMPILED,
    KERNEL,
    OPTIONS,
    Entry,
    cached,
    caller,
    njit,
    types,
)
from clearance.values import spots

LOG = logging.getLogger("clearance")
COMPILING = "compiling: the time loop, once for each installation and method (some ten seconds)"
IN_LANES = "compiling: the time loop in lanes, once for each installation (some ten seconds)"
#: versions of numba that the tests ran with; others are tried all the same
TESTED = ("0.62", "0.68")
try:
    from clearance.machine.numba_passes import Part, Plain, Unrolled, Whole
except (ImportError, AttributeError) as lacking:
    Part = Plain = Unrolled = Whole = Compiler
    LOG.warning(
        f"numba {numba.__version__} is not as the tested {' and '.join(TESTED)} ({lacking}): "
        f"it compiles the time loop in its own way, some ten seconds longer, once"
    )

float64, int64, complex128 = types.float64, types.int64, types.complex128
VECTOR = float64[::1]
MATRIX = float64[:, ::1]
INTEGERS = int64[::1]

#: (address of the run's state, t, h)
STEP_SIGNATURE = int64(int64, float64, float64)
STEP = types.FunctionType(STEP_SIGNATURE)
kernel_at = caller(KERNEL)

#: rows of the dense output: y(theta) = d0 + theta (d1 + (1 - theta) (d2 + theta (d3 + ...)))
DENSE_ROWS = 8

MACHINE = Path(__file__).parents[1] / "machine"
#: of all sources that steppers are compiled from
SOURCES = [
    Path(spots.__file__),
    MACHINE / "numba_passes.py",
    MACHINE / "numba_record.py",
    *sorted(Path(__file__).parent.glob("*.py")),
]
DIGEST = digest_of_code(*SOURCES)


def compiled(signature, arrays: bool = False, unrolled: bool = True):
    """Compile for the entire package, once (plain Python when numba is switched off).

    Without numba's runtime: nothing in here may allocate, and no array is counted; counting took
    half of the time.

    arrays: it is called from Python with arrays. Numba's cache has it.
    unrolled: its loops take most of the time of a run, and are worth more code.
    """
    pipeline = Unrolled if unrolled else Plain

    def decorate(function):
        if not COMPILED:
            return function
        if not arrays:
            return Entry(function, signature, DIGEST, pipeline_class=pipeline, **OPTIONS)
        return cached(function, signature, DIGEST, pipeline_class=pipeline, **OPTIONS)

    return decorate


#: of helpers, which only compiled functions call
HELPER = OPTIONS | {"pipeline_class": Part, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def shared(function):
    """A helper that its callers call, those too that become part of theirs."""
    return njit(forceinline=False, **HELPER)(function)


def inline(function):
    """A helper that becomes part of its callers, with their constants.

    It is put in by LLVM: numba takes far longer.
    """
    return njit(forceinline=True, **HELPER)(function)


def pasted(function):
    """A helper that numba puts into its callers before anything is compiled: slow, for loops whose
    ends are constants there.
    """
    return njit(inline="always", **OPTIONS)(function)


class Announcer(events.Listener):
    """Numba calls it before it compiles a function, not where it loads a cached one."""

    waiting: ClassVar = {"stepping": COMPILING, "lanes": IN_LANES}

    def on_start(self, event) -> None:
        """Log a line, the first time in a process that a function of a folder is compiled."""
        package, folder, *_ = (event.data["dispatcher"].py_func.__module__ + "..").split(".")
        if package == "clearance" and (text := self.waiting.pop(folder, "")):
            LOG.info(text)

    def on_end(self, event) -> None:
        """Required by numba."""


events.register("numba:compile", Announcer())
__all__ = ["KERNEL", "compiled", "inline", "pasted", "shared"]
