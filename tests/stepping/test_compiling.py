"""The compiling of the time loop: announced, and each function once."""

import gc
import json
import logging
import os

import numba
import numpy as np
import pytest
from numba.core.postproc import PostProcessor
from numba.core.targetconfig import TargetConfig

from clearance.machine import store
from clearance.machine.numba_passes import Part, Whole
from clearance.stepping.types import COMPILING, IN_LANES, TESTED, Announcer
from tests.typed import python


def test_compiling_the_time_loop_is_announced_once(caplog, monkeypatch):
    """Two functions of the package `stepping` compile, and one of `lanes`: a line for each package,
    none for others.
    """
    monkeypatch.setattr(Announcer, "waiting", {"stepping": COMPILING, "lanes": IN_LANES})
    modules = "clearance.stepping.loop", "clearance.stepping.radau5", "elsewhere"
    modules = *modules, "clearance.lanes.queue"
    with caplog.at_level(logging.INFO, "clearance"):
        for module in modules:
            added = eval("lambda x: x + 1.0", {"__name__": module})
            assert numba.njit(added)(1.0) == 2.0
    assert [r.message for r in caplog.records] == [COMPILING, IN_LANES]


def _caller_and_helper():
    """A compiled function and the helper that it calls, with the environment of neither."""

    @numba.njit(pipeline_class=Part, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)
    def helper(values, i):
        return values[i] * values[i + 1]

    @numba.njit(pipeline_class=Whole, _nrt=False)
    def caller(values):
        total = 0.0
        for i in range(2):
            total += helper(values, i)
        return total

    return caller, helper


def test_helpers_become_machine_code_in_their_callers_only():
    """The helper's code is in the caller; by itself it was neither optimised nor made
    executable.
    """
    caller, helper = _caller_and_helper()
    assert caller(np.array([2.0, 3.0, 5.0])) == 21.0
    (entire,) = caller.overloads.values()
    (part,) = helper.overloads.values()
    assert entire.library.get_pointer_to_function(entire.fndesc.llvm_func_name) > 0
    assert part.library.get_pointer_to_function(part.fndesc.llvm_func_name) == 0
    steps = [timing.name for timing in part.library.recorded_timings]
    assert not [name for name in steps if "Module" in name or "Finalize" in name], steps


def test_options_of_a_function_are_never_compared_one_by_one(monkeypatch):
    """Numba looks for operations by the options of the function too, at every mention: by
    identity.
    """
    compared = []
    monkeypatch.setattr(TargetConfig, "__eq__", lambda a, b: compared.append(a) or a is b)
    caller, _ = _caller_and_helper()
    assert caller(np.array([2.0, 3.0, 5.0])) == 21.0
    assert not compared


def test_lifetimes_of_variables_are_not_looked_for(monkeypatch):
    """Nothing is freed where they end. Afterwards numba looks for them again."""
    run = PostProcessor.run
    with monkeypatch.context() as patch:
        patch.delattr("numba.core.postproc.VariableLifetime")
        caller, _ = _caller_and_helper()
        assert caller(np.array([2.0, 3.0, 5.0])) == 21.0
    assert PostProcessor.run is run
    assert numba.njit(lambda x: x + 1.0)(1.0) == 2.0


def test_the_garbage_collector_rests_while_numba_compiles(tmp_path, monkeypatch):
    """It is off inside, and as before afterwards, also where compiling fails."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    seen = []

    class Watching(Whole):
        def define_pipelines(self):
            seen.append(gc.isenabled())
            return super().define_pipelines()

    def doubled(x):
        return 2.0 * x

    def wrong(x):
        return x.nothing

    assert gc.isenabled()
    options = {"pipeline_class": Watching, "_nrt": False}
    compiled = store.cached(doubled, numba.float64(numba.float64), "test", **options)
    assert compiled(1.5) == 3.0
    with pytest.raises(numba.TypingError):
        store.cached(wrong, numba.float64(numba.float64), "test", **options)
    assert seen == [False, False]
    assert gc.isenabled()


def test_a_roomy_frame_has_room_for_thousands_of_others():
    """Its size is beyond a piece of 2048 words of Python's; result and docstring stay."""

    def sixty(depth=60):
        """The text."""
        return 1 + sixty(depth - 1) if depth else 0

    usual = sixty.__code__.co_stacksize
    roomy = store.roomy(sixty)
    assert usual < 20
    assert roomy.__code__.co_stacksize >= 16 * 2048
    assert (roomy(), roomy.__doc__) == (60, "The text.")


def test_scenes_without_a_first_touch_leave_out_the_search_for_it():
    """The module of contact events is loaded, and so compiled, by the dry scene only."""
    code = """
import sys, json
import clearance as cl
loaded = []
for model in ("ideal", "dry"):
    cl.simulate(cl.load_case("slider_crank", model=model), turns=0.1, error=None)
    loaded.append("clearance.stepping.contacts" in sys.modules)
print(json.dumps(loaded))
"""
    assert json.loads(python("-c", code).stdout) == [False, True]


HIDING = """
from numba.core import untyped_passes
del untyped_passes.FixupArgs  # numba itself needs it no more
from clearance.stepping.types import Compiler, Part, Plain, Unrolled, Whole, compiled, inline, int64
assert Part is Plain is Unrolled is Whole is Compiler

@inline
def doubled(x):
    return 2 * x

def more(x):
    return doubled(x) + 1

print(*(compiled(int64(int64), unrolled=u)(more)(20) for u in (True, False)))
"""


def test_numba_without_what_is_replaced_compiles_in_its_own_way(tmp_path):
    """One of the passes is hidden: functions and helpers compile, and one line names it."""
    done = python("-c", HIDING, env=os.environ | {"CLEARANCE_STORE": str(tmp_path)})

    assert done.stdout == "41 41\n"
    (line,) = done.stderr.splitlines()
    assert f"numba {numba.__version__} is not as the tested {' and '.join(TESTED)}" in line
    assert "'FixupArgs'" in line


def test_this_version_of_numba_is_among_those_tested():
    """A newer one that passes all tests belongs into the list."""
    assert ".".join(numba.__version__.split(".")[:2]) in TESTED
