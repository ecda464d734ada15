"""Large kernels are compiled side by side, in processes of their own; the result is the same whoever compiled it."""

import logging
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import clearance as cl
from clearance import compiling
from clearance.mechanism import store
from clearance.mechanism.build import build


@pytest.fixture
def own_store(tmp_path, monkeypatch):
    """An empty store, and nothing loaded from another."""
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path))
    monkeypatch.setattr(store, "_loaded", {})
    return tmp_path


def small_and_large():
    """A jacobian and an events kernel of a scene: one beyond the limit, one far below."""
    texts = build(cl.load_case("slider_crank", model="lubricated")).structure.texts
    return texts["jacobian"], texts["events"]


def test_a_large_kernel_is_found_compiled_and_a_small_one_compiled_here(own_store, monkeypatch):
    large, small = small_and_large()
    monkeypatch.setattr(store, "LARGE", len(large))
    assert len(small) < len(large)
    hits = {r: sum(store.load(r, t).stats.cache_hits.values()) for r, t in (("jacobian", large), ("events", small))}
    assert hits == {"jacobian": 1, "events": 0}
    assert not list(own_store.glob("clearance_kernel_*.lock"))


def test_what_cannot_be_compiled_apart_is_compiled_here(own_store, monkeypatch):
    large, _ = small_and_large()
    monkeypatch.setattr(store, "LARGE", len(large))
    monkeypatch.setattr(store.sys, "executable", "/bin/false")
    assert sum(store.load("jacobian", large).stats.cache_misses.values()) == 1


def test_a_law_that_cannot_be_compiled_is_said_to_be_one(own_store, monkeypatch):
    _, small = small_and_large()
    monkeypatch.setattr(store, "LARGE", 0)
    with pytest.raises(ValueError, match="the events kernel cannot be compiled, most likely because of a law"):
        store.load("events", small.replace("out[0] = ", "out[0] = 'text' + "))


def test_both_ways_give_the_same_numbers(own_store, monkeypatch):
    large, _ = small_and_large()
    mechanism = build(cl.load_case("slider_crank", model="lubricated"))
    found = []
    for limit in (0, len(large) + 1):
        monkeypatch.setattr(store, "LARGE", limit)
        monkeypatch.setattr(store, "_loaded", {})
        monkeypatch.setenv("CLEARANCE_STORE", str(own_store / str(limit)))
        out = np.zeros(mechanism.y0.size**2)
        store.load("jacobian", large)(0.01, mechanism.y0, mechanism.par, np.append(mechanism.work0, 0.0), out)
        found.append(out)
    assert (found[0] == found[1]).all()


def test_a_kernel_whose_compiling_was_interrupted_is_announced(own_store, caplog):
    """Its text is in the store, its machine code is not; once that is there, nothing is logged."""
    _, small = small_and_large()
    store.load("events", small)
    for index in own_store.rglob("*.nbi"):
        index.rename(index.with_suffix(".aside"))
    with caplog.at_level(logging.INFO, "clearance"):
        with compiling.announced({"events": small}):
            assert store.is_known("events", small)
        for index in own_store.rglob("*.aside"):
            index.rename(index.with_suffix(".nbi"))
        with compiling.announced({"events": small}):
            pass
    assert [r.message for r in caplog.records] == [compiling.LINES[compiling.KERNELS]]


def test_compiling_the_time_loop_is_announced_once(caplog):
    """Two functions of the package `stepping` compile while one announcement lasts; other packages' do not count."""
    modules = "clearance.stepping.loop", "clearance.stepping.radau5", "elsewhere"
    with caplog.at_level(logging.INFO, "clearance"), compiling.announced({}):
        for module in modules:
            added = eval("lambda x: x + 1.0", {"__name__": module})
            assert compiling.numba.njit(added)(1.0) == 2.0
    assert [r.message for r in caplog.records] == [compiling.LINES[compiling.LOOP]]


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_an_interrupt_ends_compiling(tmp_path):
    """The scene takes many seconds to compile; the process is interrupted as soon as it has begun to."""
    chosen = "'six_bar_feeder', model='mixed', transition='load_sharing', film='pinkus_sternlicht', joints='B,C,E'"
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"  # also in the background
    code = f"{heard}; import clearance as cl; cl.simulate(cl.load_case({chosen}), turns=1)"
    own = {**os.environ, "CLEARANCE_STORE": str(tmp_path)}
    running = subprocess.Popen([sys.executable, "-c", code], env=own, stderr=subprocess.PIPE, text=True)
    while not list(tmp_path.glob("clearance_kernel_*.lock")):
        assert running.poll() is None
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert "KeyboardInterrupt" in said
    assert running.returncode != 0
    assert not list(tmp_path.rglob("*jacobian*.nbi"))
