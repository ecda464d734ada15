"""Requests that cannot end are refused with their numbers before anything runs; usual ones never
are.
"""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

import clearance as cl
from clearance.run import options as limits
from clearance.run.options import Demand, affordable

IDEAL = ["slider_crank", "-p", "model=ideal"]


def ideal(**more):
    return cl.load_case("slider_crank", model="ideal", **more)


@pytest.mark.parametrize(
    ("request_", "why"),
    [
        ("--samples-per-turn 1e12", r"2e\+12 rows of output \(2\^31 are allowed\)"),
        ("--samples-per-turn 1e20", "samples must be at most 2\\^53"),
        ("--samples-per-turn 1e300 --turns 1e10", "samples must be finite"),
        ("--turns 2147483648", r"8\.59e\+11 rows"),
        ("--turns 1e300", "samples must be at most"),
        (
            "--until 1e9",
            r"at least 8\.33e\+12 steps of a microsecond or more, 96\.5 days \(one is allowed\)",
        ),
        ("--max-step 1e-14", r"at least 2\.4e\+12 steps"),
    ],
)
def test_R9_run_refuses_what_cannot_end(request_, why, tmp_path, monkeypatch, typed):
    """The command refuses it in one line, without a file."""
    monkeypatch.chdir(tmp_path)
    printed = typed.line("run", *IDEAL, request_)
    assert re.search(why, printed), printed
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("more", [{"samples": 10**20}, {"samples": 3 * 10**9}, {"until": 1e12}])
def test_R9_simulate_and_sweep_refuse_it_too(more, tmp_path):
    """So do the calls of Python."""
    length = {} if "until" in more else {"turns": 2.0}
    with pytest.raises(
        ValueError, match="samples must be at most|rows of output|steps of a microsecond"
    ):
        cl.simulate(ideal(), **length, **more)
    with pytest.raises(
        ValueError, match="samples must be at most|rows of output|steps of a microsecond"
    ):
        cl.sweep(
            "slider_crank",
            cl.grid(speed=[1.0, 2.0]),
            tmp_path / "out",
            fixed={"model": "ideal"},
            **length,
            **more,
        )
    assert not (tmp_path / "out").exists()


def free(monkeypatch, size):
    """Room on the disk [bytes]."""
    monkeypatch.setattr(
        limits.shutil, "disk_usage", lambda path: SimpleNamespace(free=size, total=1e12)
    )


def test_R9_what_the_disk_cannot_hold_is_refused(tmp_path, monkeypatch, typed):
    """By all the channels that are stored, at eight bytes a number; --force and force=True begin
    all the same.
    """
    free(monkeypatch, 100_000)

    with pytest.raises(
        ValueError, match=r"files of .* GB \(0.0001 GB are free in .*--force \(force=True\)"
    ):
        cl.simulate(ideal(), turns=2, path=tmp_path / "run.h5")
    assert not list(tmp_path.iterdir())
    cl.simulate(ideal(), turns=2, path=tmp_path / "run.h5", channels=["bodies/slider/x"]).close()
    cl.simulate(ideal(), turns=2, path=tmp_path / "run.h5", force=True).close()
    typed("run", *IDEAL, "--force --json -o", tmp_path / "run.h5")

    call = {"fixed": {"model": "ideal"}, "turns": 2.0, "workers": 1}
    points = cl.grid(speed=[10.0, 20.0])
    with pytest.raises(ValueError, match="files of"):
        cl.sweep("slider_crank", points, tmp_path / "never", **call)
    assert cl.sweep(
        "slider_crank", points, tmp_path / "out", **call, channels=["bodies/slider/x"]
    ).done.all()


def test_R9_usual_requests_are_never_refused():
    """The bounds are lower ones: a run of 20,000 turns with all channels takes a second of steps at
    least.
    """
    affordable(Demand(rows=8_000_001, steps=480_000.0, columns=80))
    assert Demand(rows=8_000_001, steps=480_000.0).seconds < 1.0
    with pytest.raises(ValueError, match="3e\\+09 rows"):
        affordable(Demand(rows=3_000_000_000, steps=1.0))


def test_R9_a_compressed_file_is_given_the_benefit_of_the_doubt(monkeypatch):
    """A compressed file may fit; a plain one is refused by its size."""
    free(monkeypatch, 8_000_000)

    affordable(Demand(rows=1_000_000, steps=1.0, columns=9, compressed=True))
    with pytest.raises(ValueError, match="files of 0.072 GB"):
        affordable(Demand(rows=1_000_000, steps=1.0, columns=9))


@pytest.mark.parametrize(("total", "writable"), [(0, True), (1e9, False)])
def test_a_folder_that_takes_no_files_is_not_called_full(total, writable, monkeypatch, tmp_path):
    """The file system of the kernel has no size, a read-only medium no room: the system's own
    reason comes where the file is written.
    """
    room = SimpleNamespace(free=0, total=total)
    monkeypatch.setattr(limits.shutil, "disk_usage", lambda path: room)
    monkeypatch.setattr(limits.os, "access", lambda path, mode: writable)
    affordable(Demand(rows=1000, steps=1.0, columns=9), tmp_path)
    monkeypatch.setattr(limits.os, "access", lambda path, mode: True)
    room.total = 1e9
    with pytest.raises(ValueError, match="0 GB are free"):
        affordable(Demand(rows=1000, steps=1.0, columns=9), tmp_path)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="this system has no such folder")
@pytest.mark.parametrize("more", ["", "--checkpoint 60"])
def test_a_folder_that_takes_no_files_is_named_with_the_reason(more, typed):
    """One line with the path, and no number of the system's error."""
    line = typed.line("run", *IDEAL, "--turns 0.1 -o /proc/run.h5", more)
    assert line.startswith("clearance: /proc/run.h5: it cannot be written: ")


def test_R9_lyapunov_and_inverse_refuse_it(typed):
    """So do other kinds of runs."""
    assert "this needs 1e+20 rows of output" in typed.line(
        "lyapunov slider_crank --turns 100000000000000000000"
    )
    with pytest.raises(ValueError, match="rows of output"):
        cl.inverse_dynamics(ideal(), turns=1, samples=10**10)


def test_R9_work_precision_of_a_scene_that_does_not_move(typed):
    """Nothing but gravity on a slider at rest: it bounces on its bearing without end."""
    printed = typed("work-precision slider_crank -p speed=0 --json", status=2).document
    assert printed["message"].startswith("this scene does not move: the speed of drive ")
