"""Signals: none is lost, computed results are stored, and handlers are put back."""

import signal
import subprocess
import sys
import threading
import time
import weakref

import pytest

import clearance as cl
from clearance import simulation
from clearance.run.interrupts import DeferredSignals, Terminated, begun, terminable


@pytest.fixture(autouse=True)
def handlers():
    """Those of a plain process, whatever runs the tests; the same again after each test."""
    before = [(n, signal.getsignal(n)) for n in (signal.SIGINT, signal.SIGTERM)]
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    yield
    actual = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    for number, handler in before:
        signal.signal(number, handler)
    assert actual == (signal.default_int_handler, signal.SIG_DFL)


class Thing:
    """Something to refer to."""


def signal_in_a_callback(number):
    """A signal that Python handles in a weak reference's callback, where it drops what the handler
    raises.
    """
    thing = Thing()
    stored = weakref.ref(thing, lambda _: signal.raise_signal(number))
    del thing
    assert stored() is None


def once(number, share=0.2):
    """A progress that gets the signal once, so far into the run."""
    sent = []

    def progress(done):
        if done > share and not sent:
            sent.append(done)
            signal_in_a_callback(number)

    return progress


def test_an_interrupt_in_a_callback_ends_the_run(tmp_path):
    """The file is partial, and the exception names it."""
    scene, path = cl.load_case("slider_crank", model="dry"), tmp_path / "run.h5"
    with pytest.raises(KeyboardInterrupt) as caught:
        cl.simulate(scene, turns=60, path=path, progress=once(signal.SIGINT))
    assert caught.value.__notes__ == [f"what was computed is stored in {path}"]
    with cl.open_result(path) as result:
        assert result.status.startswith("partial: interrupted at t = ")
        assert 0.2 * 60 * scene.turn < result.time[-1] < 0.5 * 60 * scene.turn
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.parametrize(("sink", "writes"), [("Stream", "_rename"), ("ShortFile", "_write")])
def test_an_interrupt_while_the_file_is_closed_keeps_it_whole(tmp_path, monkeypatch, sink, writes):
    """It comes too late to end the run, and is raised once the file has its name."""
    write = getattr(getattr(simulation, sink), writes)

    def written(sink):
        signal.raise_signal(signal.SIGINT)
        write(sink)

    monkeypatch.setattr(getattr(simulation, sink), writes, written)
    monkeypatch.setattr(simulation, "SHORT", 0 if sink == "Stream" else simulation.SHORT)
    with pytest.raises(KeyboardInterrupt):
        cl.simulate(cl.load_case("slider_crank"), turns=1, path=tmp_path / "run.h5")
    assert cl.open_result(tmp_path / "run.h5").complete


@pytest.mark.parametrize(
    ("number", "word"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")]
)
def test_a_signal_in_a_run_keeps_its_file(tmp_path, number, word):
    """A signal to the process leaves a readable file."""
    path, partial = tmp_path / "run.h5", tmp_path / "run.h5.partial"
    call = [
        sys.executable,
        "-c",
        "from clearance.cli import entry; entry()",
        "run",
        "slider_crank",
        "-p",
        "model=dry",
    ]
    process = subprocess.Popen(
        [*call, "--turns", "20000", "-o", str(path)],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 600.0
    while process.poll() is None and time.monotonic() < deadline:
        if partial.exists() and partial.stat().st_size > 4_000_000:  # under way, not only begun
            break
        time.sleep(0.005)
    process.send_signal(number)
    _, message = process.communicate(timeout=600.0)
    message = [line for line in message.splitlines() if "compiling" not in line]
    assert (process.returncode, message) == (
        1,
        [f"clearance: {word}; what was computed is stored in {path}"],
    )
    with cl.open_result(path) as result:
        assert result.status.startswith(f"partial: {word} at t = ")
        assert result.time.size > 1000
    assert not partial.exists()


@pytest.mark.parametrize(
    ("request_", "word"), [(KeyboardInterrupt, "interrupted"), (Terminated, "terminated")]
)
def test_before_the_first_step_nothing_is_said_to_be_kept(
    tmp_path, monkeypatch, typed, request_, word
):
    """Before the run there is no file, which is stated."""

    def prepare(*_, **__):
        raise request_

    monkeypatch.setattr(simulation, "prepare", prepare)
    path = tmp_path / "run.h5"
    assert (
        typed.line("run slider_crank -o", path, status=1)
        == f"clearance: {word}; {path} was not written"
    )
    assert not list(tmp_path.iterdir())


def test_after_the_run_its_file_is_said_to_be_kept(tmp_path, monkeypatch, typed):
    """After the run the file is complete, which is stated."""
    from clearance.commands import run

    def comparable(*_):
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(run, "_comparable", comparable)
    path = tmp_path / "run.h5"
    assert (
        typed.line("run slider_crank -o", path, status=1)
        == f"clearance: terminated; the run is stored in {path}"
    )
    assert cl.open_result(path).complete


def test_a_terminated_run_goes_on_from_its_checkpoints(tmp_path):
    """The same call goes on after a SIGTERM."""
    scene, path = cl.load_case("slider_crank", model="dry"), tmp_path / "run.h5"
    options = {"turns": 20, "path": path, "checkpoint": 1e-9}
    with terminable(), pytest.raises(Terminated) as caught:
        cl.simulate(scene, **options, progress=once(signal.SIGTERM, 0.5))
    assert caught.value.__notes__ == [
        f"what was computed is stored in {path}, and the same call goes on from there"
    ]
    shares = []
    assert cl.simulate(scene, **options, progress=shares.append).complete
    assert min(shares) > 0.5


def test_a_trajectory_in_memory_ends_too(monkeypatch):
    """A run without a file ends too."""
    run = simulation.prepare(cl.load_case("slider_crank", model="dry"), turns=60)
    advance = run.advance

    def interrupted():
        code = advance()
        signal_in_a_callback(signal.SIGINT)
        return code

    monkeypatch.setattr(run, "advance", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run.trajectory()


def test_a_second_signal_raises_at_once():
    """The first still comes at the end."""
    after = []

    def twice():
        with DeferredSignals():
            signal.raise_signal(signal.SIGINT)
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            after.append("second")

    with pytest.raises(KeyboardInterrupt):
        twice()
    assert after == ["second"]


@pytest.mark.parametrize("interrupt", [signal.default_int_handler, signal.SIG_IGN])
def test_a_dropped_request_comes_a_moment_later(monkeypatch, interrupt):
    """One to end in a callback, as while the loop is compiled; shells ignore SIGINT of commands in
    the background.
    """
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    signal.signal(signal.SIGINT, interrupt)
    begun()
    assert signal.getsignal(signal.SIGINT) is interrupt

    def dropped():
        with terminable():
            signal_in_a_callback(signal.SIGTERM)
            for _ in range(3000):
                time.sleep(0.01)

    with pytest.raises(Terminated):
        dropped()
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_handlers_that_raise_nothing_are_called_at_once():
    """Handlers of others are not delayed."""
    called = []
    signal.signal(signal.SIGTERM, lambda number, _: called.append(number))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with DeferredSignals() as held:
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
        assert called == [signal.SIGTERM]
        held.check()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def test_handlers_are_put_back_after_an_error():
    """The error goes on its way, whatever waits behind it; the handlers are looked at after every
    test.
    """

    def fails():
        with DeferredSignals():
            signal.raise_signal(signal.SIGINT)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fails()


def test_a_run_in_a_thread_leaves_handlers_alone():
    """Outside the main thread handlers stay as they are."""
    actual, seen = [], set()

    def run():
        scene = cl.load_case("slider_crank")
        actual.append(
            cl.simulate(
                scene, turns=1, progress=lambda _: seen.add(signal.getsignal(signal.SIGINT))
            )
        )

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert actual[0].complete
    assert seen == {signal.default_int_handler}
