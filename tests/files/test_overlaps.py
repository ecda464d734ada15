"""Two runs onto one name: the second is refused, the first is unharmed; what a killed run left is
in nobody's way.
"""

import signal
import subprocess
import sys
import threading

import pytest

import clearance as cl
from clearance.files import locks
from clearance.files.locks import InUse, Lock
from clearance.results.short_file import ShortFile
from clearance.results.stream import Content
from tests.run.test_checkpoint import same

TURNS = 40
KILLED = """
import os, signal, sys
import clearance as cl
checkpoint = float(sys.argv[2]) or None
scene = cl.load_case("slider_crank", model="ideal")
killed = lambda share: os.kill(os.getpid(), signal.SIGKILL)
cl.simulate(scene, turns=40, path=sys.argv[1], checkpoint=checkpoint, progress=killed)
"""


def ideal():
    return cl.load_case("slider_crank", model="ideal")


def names(folder):
    return sorted(p.name for p in folder.iterdir())


class Paused:
    """A run in a thread that waits in its first report of progress until it is let go."""

    def __init__(self, path, **more):
        self.begun, self.go, self.path, self.more = threading.Event(), threading.Event(), path, more
        self.error = None
        self.thread = threading.Thread(target=self._run)

    def _run(self):
        try:
            cl.simulate(
                ideal(), turns=TURNS, path=self.path, progress=self._wait, error=None, **self.more
            ).close()
        except BaseException as error:  # noqa: BLE001 - looked at by the test
            self.error = error

    def _wait(self, share):
        self.begun.set()
        self.go.wait(600.0)

    def __enter__(self):
        self.thread.start()
        assert self.begun.wait(600.0)
        return self

    def __exit__(self, *_):
        self.go.set()
        self.thread.join()


@pytest.fixture(scope="module")
def entire(tmp_path_factory):
    return cl.simulate(
        ideal(), turns=TURNS, path=tmp_path_factory.mktemp("whole") / "run.h5", error=None
    ).path


@pytest.mark.parametrize("second", [{}, {"checkpoint": 1e-9}])
@pytest.mark.parametrize("first", [{}, {"checkpoint": 1e-9}])
def test_R1_a_second_run_onto_the_name_is_refused(tmp_path, entire, first, second):
    """The first is bit for bit what it would have been alone, and nothing but its file is left."""
    path = tmp_path / "run.h5"
    with Paused(path, **first) as run:
        before = names(tmp_path)
        for _ in range(3):
            with pytest.raises(ValueError, match=r"another run writes .*run\.h5 \(process \d+ on "):
                cl.simulate(ideal(), turns=1, path=path, **second)
        assert names(tmp_path) == before
    assert run.error is None
    assert names(tmp_path) == ["run.h5"]
    same(entire, path)


def test_R1_the_command_line_refuses_it_too(tmp_path, entire):
    """A second run onto one name ends in one line."""
    path = tmp_path / "run.h5"
    with Paused(path) as run:
        call = [
            sys.executable,
            "-c",
            "from clearance.cli import entry; entry()",
            "run",
            "slider_crank",
        ]
        done = subprocess.run(
            [*call, "-p", "model=ideal", "--turns", "1", "-o", str(path)],
            capture_output=True,
            text=True,
        )
    assert run.error is None
    assert (done.returncode, done.stdout) == (2, "")
    assert f"clearance: another run writes {path} (process " in done.stderr
    same(entire, path)


@pytest.mark.parametrize("checkpoint", ["0", "1e-9"])
def test_R1_what_a_killed_run_left_is_in_nobodys_way(tmp_path, entire, checkpoint):
    """A lock ends with its process; the unfinished file is written anew, or the run goes on from
    its checkpoint.
    """
    path, wanted = tmp_path / "run.h5", tmp_path / "run.h5.lock"
    done = subprocess.run([sys.executable, "-c", KILLED, str(path), checkpoint], check=False)
    assert done.returncode == -signal.SIGKILL
    assert wanted.exists()
    assert not path.exists()
    again = {"checkpoint": float(checkpoint) or None, "error": None}
    cl.simulate(ideal(), turns=TURNS, path=path, **again).close()
    assert names(tmp_path) == ["run.h5"]
    same(entire, path)


def test_R1_without_locks_both_files_are_whole(tmp_path, entire, monkeypatch):
    """Without locks of the file system each run writes a file of its own and the last one takes the
    name.
    """

    def none(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(locks.fcntl, "flock", none)
    monkeypatch.setenv("HDF5_USE_FILE_LOCKING", "FALSE")
    path = tmp_path / "run.h5"
    with Paused(path) as run:
        cl.simulate(ideal(), turns=1, path=path).close()
        assert cl.open_result(path).complete
    assert run.error is None
    assert names(tmp_path) == ["run.h5"]
    same(entire, path)


def test_R1_a_sweeps_image_needs_no_lock(tmp_path, monkeypatch):
    """Two of one name are each written in one piece: whichever comes last is complete."""
    monkeypatch.setattr(ShortFile, "locked", False)
    path = tmp_path / "run.h5"
    one, two = (ShortFile(path, Content([], {"case": name})) for name in "ab")
    for sink in (one, two):
        sink.close("complete", {}, [], {}, None)
        sink.store()
        with cl.open_result(path) as result:
            assert result.complete
    assert names(tmp_path) == ["run.h5"]


def test_R1_a_lock_is_taken_over_and_removed(tmp_path):
    """The file of a killed holder is locked by nobody; one that its holder removes is not mistaken
    for a lock.
    """
    path = tmp_path / "lock"
    path.write_text("process 1 on nowhere")
    with Lock(path, "in use") as lock:
        assert lock.held
        with pytest.raises(InUse, match=r"in use \(process \d+"):
            Lock(path, "in use")
    assert not path.exists()


def test_R1_of_many_that_wait_one_at_a_time_gets_the_lock(tmp_path):
    """Each removes the file as it lets go, which the others that wait on it notice."""
    path, inside, most = tmp_path / "lock", [], []

    def enter():
        for _ in range(50):
            with Lock(path, wait=True):
                inside.append(1)
                most.append(len(inside))
                inside.pop()

    threads = [threading.Thread(target=enter) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == 1
    assert len(most) == 200
