"""The compiling of the time loop is announced."""

import logging

import numba

from clearance import compiling


def test_compiling_the_time_loop_is_announced_once(caplog):
    """Two functions of the package `stepping` compile while one announcement lasts; other packages' do not count."""
    modules = "clearance.stepping.loop", "clearance.stepping.radau5", "elsewhere"
    with caplog.at_level(logging.INFO, "clearance"), compiling.announced():
        for module in modules:
            added = eval("lambda x: x + 1.0", {"__name__": module})
            assert numba.njit(added)(1.0) == 2.0
    assert [r.message for r in caplog.records] == [compiling.LINE]
