"""A full disk ends a run in order: what fitted can be read, nothing else is harmed.

A limit on the size of files stands for the full disk: the system refuses to write beyond it.
"""

import subprocess
import sys

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance import simulation
from clearance.results.stream import Stream, Unwritable
from clearance.run import checkpoint
from clearance.run import run as running
from tests.run.test_checkpoint import same
from tests.seeds import few_of

#: limit of the size of files in bytes (0: none), whether the system can promise room, then the
#: command
LIMITED = """
import os, resource, sys
from clearance.cli import entry
limit = int(sys.argv[1])
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
if sys.argv[2] == "no promise":
    del os.posix_fallocate
sys.argv[1:] = ["run", "slider_crank", "-p", "model=dry", "--no-error", *sys.argv[3:]]
entry()
"""
TURNS = 100
REASON = "cannot be written: File too large"


def limited(limit, path, *more, promise="promise", turns=TURNS):
    """`clearance run` in a process of its own, whose exit is what is looked at too.

    -B: Python would leave cut byte code of modules that it imports first here.
    """
    call = [
        sys.executable,
        "-B",
        "-c",
        LIMITED,
        str(limit),
        promise,
        "--turns",
        str(turns),
        "-o",
        str(path),
        *more,
    ]
    ended = subprocess.run(call, capture_output=True, text=True, timeout=900)
    lines = ended.stderr.splitlines(keepends=True)
    # where the store is new, and where its files are larger than the limit
    ended.stderr = "".join(line for line in lines if "compil" not in line)
    return ended


@pytest.fixture(scope="module")
def entire(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    scene = cl.load_case("slider_crank", model="dry")
    return cl.simulate(scene, turns=TURNS, path=path, error=None)


@pytest.mark.parametrize("compression", few_of(["4", "0"], 1))
@pytest.mark.parametrize("limit", [1_000_000, 5_000_000])
def test_what_fitted_is_kept(tmp_path, entire, limit, compression):
    """The same rows as without a limit, as many as there was room for, and a summary of these
    alone.
    """
    path = tmp_path / "run.h5"
    ended = limited(limit, path, "--compression", compression)
    assert ended.returncode == 1
    assert ended.stderr.startswith("clearance: at t = ")
    assert ended.stderr.endswith(f" s: {path} {REASON}; what fitted is stored in {path}\n")
    assert ended.stderr.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]
    with cl.open_result(path) as stored:
        assert stored.status.startswith("partial: at t = ")
        assert stored.status.endswith(REASON)
        rows = stored.time.size
        assert (limit > 2_000_000) <= rows < entire.time.size
        for name in ("time", "joints/C/gap", "energy/residual", "bodies/rod/theta") if rows else ():
            np.testing.assert_array_equal(
                stored.values(name), entire.values(name)[:rows], err_msg=name
            )
        if rows:
            gap = stored.values("joints/C/gap")
            assert stored.range("joints/C/gap") == (gap.min(), gap.max())
            assert path.stat().st_size > (0.5 * limit if compression == "0" else 0)


def test_without_a_promise_the_file_is_lost_in_order(tmp_path):
    """No file that nobody can read is left; one that was there before stays as it was."""
    path = tmp_path / "run.h5"
    h5py.File(path, "w").close()
    earlier = path.read_bytes()
    ended = limited(3_000_000, path, promise="no promise")
    assert ended.returncode == 1
    assert ended.stderr.endswith(f" s: {path} {REASON}; {path} was not written\n")
    assert ended.stderr.count("\n") == 1
    assert path.read_bytes() == earlier
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.parametrize("promise", few_of(["promise", "no promise"], 1))
def test_no_room_to_begin(tmp_path, promise):
    """A disk full from the start: one line and no file."""
    path = tmp_path / "run.h5"
    ended = limited(20_000, path, promise=promise)
    assert ended.returncode == 1
    assert ended.stderr.endswith(f" s: {path} {REASON}; {path} was not written\n")
    assert ended.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_checkpoints_are_kept_and_the_run_goes_on(tmp_path, entire):
    """The stretches fit and the file that joins them does not."""
    path = tmp_path / "run.h5"
    ended = limited(8_000_000, path, "--checkpoint", "0.05")
    assert ended.returncode == 1
    assert (
        f"{path} {REASON}; its checkpoints are stored in {path}.parts, and the same call goes on"
        in ended.stderr
    )
    assert ended.stderr.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5.parts"]
    after = limited(0, path, "--checkpoint", "0.05")
    assert after.returncode == 0, after.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]
    same(entire.path, path)


def test_a_checkpoint_that_finds_no_room_keeps_the_one_before(tmp_path, monkeypatch):
    """The last checkpoint that fitted stays."""
    path, saved = tmp_path / "run.h5", []

    def full(path, state):
        saved.append(path)
        if len(saved) == 2:
            raise OSError(28, "No space left on device")
        save(path, state)

    save = checkpoint.save
    monkeypatch.setattr(checkpoint, "save", full)
    options = {"turns": 20, "path": path, "checkpoint": 1e-9}
    with pytest.raises(
        cl.SimulationError, match="No space left on device; its checkpoints are stored in "
    ) as caught:
        cl.simulate(cl.load_case("slider_crank", model="dry"), **options)
    assert caught.value.result is None
    assert not path.exists()
    assert cl.simulate(cl.load_case("slider_crank", model="dry"), **options).complete
    assert not checkpoint.parts_folder(path).exists()
    same(
        cl.simulate(
            cl.load_case("slider_crank", model="dry"), turns=20, path=tmp_path / "whole.h5"
        ).path,
        path,
    )


def test_a_call_from_python_has_the_result(tmp_path, monkeypatch):
    """The exception has the rows that fitted."""
    append, calls = Stream._append, []

    def full(sink, columns, values):
        calls.append(sink)
        if len(calls) == 10:
            sink.full = True
            raise Unwritable(sink.path, 28)
        append(sink, columns, values)

    monkeypatch.setattr(Stream, "_append", full)
    with pytest.raises(
        cl.SimulationError, match="No space left on device; what fitted is stored in "
    ) as caught:
        cl.simulate(
            cl.load_case("slider_crank", model="dry"), turns=TURNS, path=tmp_path / "run.h5"
        )
    assert caught.value.result.time.size > 0


@pytest.mark.parametrize("compression", few_of([1, 0, 9], 1))
@pytest.mark.parametrize("rows", [7, 1024, 5000])
def test_no_piece_takes_more_than_was_claimed(tmp_path, monkeypatch, compression, rows):
    """Nor opening, nor closing; many small pieces, and such that fill more than a chunk."""
    flush, placing, grown = Stream.flush, Stream._rename, []

    def measured(sink):
        before, due = sink.flushed, sink.due
        flush(sink)
        grown.append((sink.flushed - before, due))

    def closed(sink):
        sink.file.flush()
        grown.append((sink.file.id.get_filesize() - sink.flushed, sink.closing))
        placing(sink)

    monkeypatch.setattr(simulation, "SHORT", 0)
    monkeypatch.setattr(Stream, "flush", measured)
    monkeypatch.setattr(Stream, "_rename", closed)
    monkeypatch.setattr(running, "ROWS", rows)
    monkeypatch.setattr(running, "BUDGET", 20 * rows)
    path, scene = tmp_path / "run.h5", cl.load_case("six_bar_feeder", model="dry")
    cl.simulate(
        scene,
        turns=10 if rows > 100 else 0.2,
        samples_per_turn=2000,
        compression=compression,
        path=path,
        error=None,
    )
    assert len(grown) > 3
    for taken, claimed in grown:
        assert taken <= claimed
    with h5py.File(path) as file:
        assert path.stat().st_size == file.id.get_filesize()
