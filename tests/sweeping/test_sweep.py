"""Sweeps: every point once, restartable, the same numbers as runs one by one."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.files.texts import signed_document
from clearance.metrics.of_points import of_point
from clearance.sweeping import index as indices
from clearance.sweeping import sweep
from tests.run.test_checkpoint import same

CASE, OPTIONS = "slider_crank", {"turns": 2.0, "samples_per_turn": 50, "rtol": 1e-5}
FIXED = {"model": "lubricated", "film": "pinkus_sternlicht"}
POINTS = cl.grid(speed=[20.0, 30.0], clearance=[1e-4, 2e-4, 3e-4])


def sweeping(points, folder, **more):
    """A sweep of the lubricated slider-crank by this process."""
    return cl.sweep(CASE, points, folder, **{"fixed": FIXED, "workers": 1, **OPTIONS} | more)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Six points by two workers."""
    return sweeping(POINTS, tmp_path_factory.mktemp("sweep") / "map", workers=2)


@pytest.fixture
def copy(swept, tmp_path):
    """A folder that a test may change."""
    shutil.copytree(swept.folder, tmp_path / "map")
    return tmp_path / "map"


def again(folder, **more):
    """The same sweep into its folder."""
    return sweeping(POINTS, folder, workers=None, **more)


def test_a_sweep_ends_long_after_its_index_was_written(tmp_path, monkeypatch):
    """The index is due again at each report, also at the last one, when the journal is closed."""
    monkeypatch.setattr(sweep, "SAVE", -1.0)
    monkeypatch.setattr(sweep, "SHARE", 0.0)
    assert sweeping(POINTS, tmp_path / "map", channels=[]).done.all()


def ended_whole(folder) -> list[bytes]:
    """Lines of the journal, without one that was cut short."""
    lines = (folder / "journal.jsonl").read_bytes().splitlines(keepends=True)
    return [line for line in lines if line.endswith(b"\n")]


def ended(folder) -> list[dict]:
    """The contents of these lines."""
    return [json.loads(line) for line in ended_whole(folder)]


def test_all_points_are_done_once(swept):
    """A line and a file each, named by the point's key."""
    assert swept.done.all()
    assert sorted(o["index"] for o in ended(swept.folder)) == list(range(6))
    assert sorted(p.stem for p in (swept.folder / "runs").iterdir()) == sorted(
        swept.definition.keys
    )


def test_a_run_is_that_of_simulate(swept, tmp_path):
    """Its file is the same but for what a sweep adds, its metrics to the last bit."""
    scene = cl.load_case(CASE, speed=30.0, clearance=2e-4, **FIXED)
    alone = cl.simulate(scene, path=tmp_path / "run.h5", error=None, **OPTIONS)
    for source, name in ((swept.path(4), "plain"), (alone.path, "alone")):
        shutil.copy(source, tmp_path / f"{name}.h5")
        with h5py.File(tmp_path / f"{name}.h5", "a") as file:
            if name == "plain":
                del file["metrics"], file["sweep"]  # what a sweep adds
            for end in ("", "_crc32"):
                del file.attrs[f"options{end}"]
                if name == "alone":  # of `simulate` alone
                    del file.attrs[f"errors_left_out{end}"]
    same(tmp_path / "alone.h5", tmp_path / "plain.h5")
    for name, metric in of_point(alone).items():
        assert swept.metrics[name][swept.select(speed=30.0, clearance=2e-4)[0]] == metric.value


def test_dataset_and_table(swept):
    """Dimensions are the parameters; values have units and are those of the index."""
    data = swept.dataset
    assert data.sizes == {"speed": 2, "clearance": 3}
    assert data.clearance.attrs["units"] == "m"
    assert data.joint_C_force_max.attrs["units"] == "N"
    value = float(data.joint_C_force_max.sel(speed=30.0, clearance=2e-4))
    assert value == swept.metrics["joint_C_force_max"][4]
    frame = swept.table
    assert len(frame) == 6
    assert frame.query("speed == 30.0 and clearance == 0.0002").joint_C_force_max.item() == value


def test_the_index_is_plain_hdf5(swept):
    """Parameters, metrics with units, and states can be read without this package."""
    with h5py.File(swept.folder / "sweep.h5") as file:
        assert file.attrs["format"] == "clearance-sweep"
        assert file["metrics/joint_C_force_max"].shape == (6,)
        assert file["metrics/joint_C_force_max"].attrs["units"] == "N"
        assert file["parameters/clearance"].attrs["units"] == "m"
        assert set(file["runs/status"].asstr()[()]) == {"done"}


@pytest.mark.parametrize("lost", [["sweep.h5"], ["sweep.h5", "journal.jsonl"], ["journal.jsonl"]])
def test_the_index_is_rebuilt_from_what_is_left(swept, copy, lost):
    """From the journal or from the run files: the same metrics."""
    for name in lost:
        (copy / name).unlink()
    actual = cl.open_sweep(copy)
    assert actual.done.all()
    for name, values in swept.metrics.items():
        np.testing.assert_array_equal(actual.metrics[name], values)
        assert actual.known[name] == swept.known[name]


def test_the_same_call_again_runs_nothing(copy):
    """The journal stays byte for byte."""
    before = (copy / "journal.jsonl").read_bytes()
    assert again(copy).done.all()
    assert (copy / "journal.jsonl").read_bytes() == before


def test_only_what_is_missing_is_run(copy):
    """Absent and damaged files and cut lines are made again; damaged ones are set aside."""
    keys = cl.open_sweep(copy).definition.keys
    lines = (copy / "journal.jsonl").read_bytes().splitlines(keepends=True)
    # and one cut short
    cut = b"".join(line for line in lines if json.loads(line)["index"] != 4) + lines[0][:30]
    (copy / "journal.jsonl").write_bytes(cut)
    (copy / "runs" / f"{keys[4]}.h5").unlink()
    (copy / "runs" / f"{keys[1]}.h5").unlink()
    (copy / "runs" / f"{keys[2]}.h5").write_bytes(b"rubbish")
    damaged = copy / "runs" / f"{keys[3]}.h5"
    content = bytearray(damaged.read_bytes())
    content[len(content) // 2] ^= 1  # a single bit
    damaged.write_bytes(content)
    count = len(ended_whole(copy))
    assert again(copy).done.all()
    assert sorted(o["index"] for o in ended(copy)[count:]) == [1, 2, 3, 4]
    assert damaged.with_suffix(".h5.broken").exists()
    for key in keys:
        cl.open_result(copy / "runs" / f"{key}.h5").close()


def test_a_run_whose_line_was_lost_is_taken_from_its_file(copy):
    """A kill between a run's file and its line: the file is complete and counts."""
    lines = (copy / "journal.jsonl").read_bytes().splitlines(keepends=True)
    (copy / "journal.jsonl").write_bytes(b"".join(lines[:2]))
    actual = again(copy)
    assert actual.done.all()
    assert len(ended(copy)) == 6


def test_another_sweep_is_refused(copy):
    """The message has what differs."""
    other = cl.grid(speed=[20.0, 40.0], clearance=[1e-4, 2e-4, 3e-4])
    for case, points, fixed, message in (
        (CASE, POINTS, FIXED | {"viscosity": 0.1}, r"fixed .* instead of .*0\.1"),
        (CASE, other, FIXED, r"speed 20\.0,30\.0 instead of 20\.0,40\.0"),
        ("six_bar_feeder", cl.grid(speed=[20.0]), {}, "case"),
    ):
        with pytest.raises(ValueError, match=f"holds another sweep: {message}"):
            cl.sweep(case, points, copy, fixed=fixed, **OPTIONS)


def test_newer_formats_are_refused(copy):
    """Both to read and to go on."""
    document = signed_document((copy / "sweep.json").read_bytes(), "")
    document["format_version"] = 99
    (copy / "sweep.json").write_text(json.dumps(document))
    for use in (cl.open_sweep, again):
        with pytest.raises(ValueError, match="newer clearance"):
            use(copy)


def test_a_newer_index_is_refused(copy):
    """The message names the newer version."""
    with h5py.File(copy / "sweep.h5", "a") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(ValueError, match="newer clearance"):
        cl.open_sweep(copy)


def test_a_directory_in_use_is_refused(copy):
    """While another process holds its lock."""
    import fcntl

    with open(copy / "lock", "a+") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(ValueError, match="is in use"):
            again(copy)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"fixed": {"speeed": 1.0}}, "no parameter 'speeed' .did you mean speed.*it has speed"),
        ({"fixed": {"speed": 1.0}}, "speed is both swept and fixed"),
        ({"workers": 0}, "workers"),
        ({"compression": 12}, "compression"),
        ({"settle": 2.0}, "leaves nothing"),
        ({"channels": ["joints/Q/*"]}, "fits none"),
        ({"metrics": ["nowhere.py:f"]}, "no file"),
        ({"rtol": -1.0}, "rtol"),
        ({"fixed": {"model": "wet"}}, "model must be one of"),
    ],
)
def test_wrong_input_comes_before_anything_is_written(change, reason, tmp_path):
    """No folder is left."""
    with pytest.raises(ValueError, match=reason):
        sweeping(POINTS, tmp_path / "never", **change)
    assert not (tmp_path / "never").exists()


FAILS = """
import clearance as cl
import math

@cl.signal
def ends(time, strength):
    return math.sqrt(0.05 - time) if strength > 0.0 else 0.0

def scene(*, strength: float = 0.0, length: float = 0.1) -> cl.Scene:
    \"\"\"A pendulum that a torque without a value may stop.

    strength: of the torque [N m]
    length: of the pendulum [m]
    \"\"\"
    if length > 0.5:
        raise ValueError(f"length {length} m is too long")
    body = cl.Body("arm", mass=1.0, inertia=1e-3, points={"pin": (-length, 0.0)})
    torque = cl.Torque(body, torque=ends(strength=strength))
    return cl.Scene(cl.Revolute(cl.ground, body["pin"], name="P"), torque)
"""


@pytest.fixture
def torn(tmp_path):
    """A function that sweeps the pendulum, whose file it writes with other words."""

    def sweep(points, *words, until=0.1, **more):
        path = tmp_path / "torn.py"
        path.write_text(FAILS.replace(*words) if words else FAILS)
        return cl.sweep(path, points, tmp_path / "out", until=until, **{"workers": 1} | more)

    return sweep


def test_a_failed_point_keeps_its_reason_and_the_sweep_goes_on(torn, tmp_path):
    """Its partial run is there; it is tried again on demand only."""
    points = cl.grid(strength=[0.0, 1.0], length=[0.1, 0.9])
    actual = torn(points, until=0.2)
    assert actual.status.tolist() == ["done", "failed", "failed", "failed"]
    assert "at t =" in actual.reason[2]
    assert "length 0.9 m is too long" in actual.reason[1]
    with actual.run(2) as partial:
        assert partial.status.startswith("partial: ")
        assert partial.time.size > 1
    with pytest.raises(ValueError, match="has no file: .*too long"):
        actual.run(3)
    count = len(ended(tmp_path / "out"))
    torn(points, until=0.2)
    assert len(ended(tmp_path / "out")) == count
    torn(points, until=0.2, retry_failed=True)
    assert sorted(o["index"] for o in ended(tmp_path / "out")[count:]) == [1, 2, 3]


def test_a_changed_case_file_is_another_sweep(torn):
    """The text of the file decides, not its name."""
    points = cl.grid(length=[0.1, 0.2])
    torn(points)
    with pytest.raises(ValueError, match="the case file has been changed since"):
        torn(points, "mass=1.0", "mass=2.0")


def test_summaries_only_and_samples(tmp_path):
    """No run files; the dataset has one dimension for drawn points."""
    points = cl.sampled(6, seed=5, speed=(10.0, 20.0), clearance=(5e-5, 2e-4, "log"))
    actual = sweeping(points, tmp_path / "out", channels=[], workers=2)
    assert actual.done.all()
    assert not list((tmp_path / "out" / "runs").iterdir())
    assert actual.dataset.sizes == {"run": 6}
    np.testing.assert_array_equal(actual.dataset.speed.values, points.columns["speed"])
    with pytest.raises(ValueError, match="summaries only"):
        actual.run(0)


def test_chosen_channels_and_compression(tmp_path):
    """Files have these channels; metrics are of all."""
    options = {"channels": ["bodies/slider/x", "joints/C/ecc*"], "compression": 4}
    actual = sweeping(cl.grid(speed=[20.0]), tmp_path / "out", **options)
    with actual.run(0) as run:
        assert run.names("bodies/slider") == ("x",)
        assert run.names("joints/C") == ("eccentricity_ratio", "eccentricity_x", "eccentricity_y")
        assert run.file["bodies/slider/x"].compression == "gzip"
        with pytest.raises(KeyError, match="or not stored"):
            run.values("bodies/slider/y")
    assert "joint_C_gap_min" in actual.metrics  # of all channels, whichever are stored


def mine(folder, text) -> list[str]:
    """The name of the metric `mine` of a file."""
    (folder / "mine.py").write_text(text)
    return [f"{folder / 'mine.py'}:mine"]


def test_a_metric_of_ones_own(tmp_path):
    """Numbers with and without units; what is no number is a reason, not a failure."""
    points = cl.grid(speed=[20.0, 30.0])
    travel = mine(
        tmp_path,
        "def mine(run):\n    x = run['slider'].x\n"
        "    return {'travel': (x.max() - x.min(), 'm', 'way of the slider'), 'plain': 2}\n",
    )
    actual = sweeping(points, tmp_path / "out", metrics=travel, channels=[])
    assert actual.known["travel"] == ("m", "way of the slider")
    assert actual.metrics["travel"][0] > 0.0
    assert actual.metrics["plain"].tolist() == [2.0, 2.0]
    text = mine(tmp_path, "def mine(run):\n    return {'bad': 'text'}\n")
    bad = sweeping(points, tmp_path / "bad", metrics=text)
    assert bad.done.all()
    assert "bad" not in bad.metrics
    assert "metric mine: bad is no number: 'text'" in bad.reason[0]
    with pytest.raises(ValueError, match="top level of a file"):
        sweeping(points, tmp_path / "never", metrics=[lambda run: {}])


@pytest.mark.slow
def test_a_script_needs_no_guard(tmp_path):
    """Workers do not import the user's script, so one without `if __name__` works."""
    script = tmp_path / "script.py"
    script.write_text(
        "import clearance as cl\n"
        f"found = cl.sweep({CASE!r}, cl.grid(speed=[20.0, 25.0]), {str(tmp_path / 'out')!r}, "
        f"fixed={FIXED!r}, "
        f"channels=[], workers=2, **{OPTIONS!r})\nprint(int(found.done.sum()))\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=900)
    assert (done.stdout, done.stderr) == ("2\n", "")


# --- real processes, killed

SLOW = {"turns": 12.0, "samples_per_turn": 50, "rtol": 1e-8}
MANY = cl.grid(speed=np.linspace(20.0, 30.0, 40))
DRIVE = f"""
import sys
import clearance as cl
points = cl.grid(speed={MANY.columns["speed"]!r})
cl.sweep("slider_crank", points, sys.argv[1], fixed={{"model": "dry"}}, workers=2, **{SLOW!r})
"""


def finish(folder, **more):
    """Forty dry points by two workers."""
    return sweeping(MANY, folder, fixed={"model": "dry"}, **{"workers": 2} | SLOW | more)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    return finish(tmp_path_factory.mktemp("calm") / "out")


def test_metrics_are_those_of_the_file(tmp_path):
    """A dry run hands its contacts over piece by piece, each piece in the same memory."""
    options = {"fixed": {"model": "dry"}, **SLOW}
    swept = sweeping(cl.grid(speed=[20.0, 30.0]), tmp_path / "out", **options)
    for i in range(2):
        with swept.run(i) as run:
            assert len(run.events["time"]) > 100
            actual = of_point(run)
        for name, metric in actual.items():
            assert swept.metrics[name][i] == metric.value, name


def identical(one, other) -> None:
    for name, values in one.metrics.items():
        np.testing.assert_array_equal(values, other.metrics[name], err_msg=name)
    for i in (0, 17, 39):
        same(one.path(i), other.path(i))


def wait_for(count: int, folder: Path, seconds: float = 600.0) -> None:
    deadline = time.monotonic() + seconds
    journal = folder / "journal.jsonl"
    while time.monotonic() < deadline:
        if journal.exists() and len(ended_whole(folder)) >= count:
            return
        time.sleep(0.002)
    raise AssertionError(f"{folder} has not got {count} runs")


def stat(pid) -> list[str]:
    """Facts about a process from its state on; one that is gone is a zombie without parent."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return ["Z", "-1"]


def children(pid: int) -> list[int]:
    """Processes below a process that run points: the fork server's children."""
    every = [int(path.parent.name) for path in Path("/proc").glob("[0-9]*/stat")]
    near = [child for child in every if int(stat(child)[1]) == pid]
    return [p for child in near for p in (child, *children(child))]


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks for worker processes in /proc"
)
@pytest.mark.parametrize("after", [1, 7, 20])
def test_a_killed_driver_loses_no_finished_run(after, tmp_path, undisturbed):
    """Workers end with it; what was done is not run again, and the end is the same."""
    driver = subprocess.Popen([sys.executable, "-c", DRIVE, str(tmp_path / "out")])
    wait_for(after, tmp_path / "out")
    below = children(driver.pid)
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    assert below
    deadline = time.monotonic() + 120.0
    while (alive := [p for p in below if stat(p)[0] != "Z"]) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not alive, "workers outlive their driver"
    before = cl.open_sweep(tmp_path / "out")  # readable at once
    stored = before.done.sum()
    assert stored >= after
    times = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out" / "runs").glob("*.h5")}
    actual = finish(tmp_path / "out")
    assert actual.done.all()
    for name, time_ns in times.items():  # no finished run was done again
        assert (tmp_path / "out" / "runs" / name).stat().st_mtime_ns == time_ns
    identical(actual, undisturbed)


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks for worker processes in /proc"
)
def test_killed_workers_are_replaced(tmp_path, undisturbed):
    """The sweep ends with the same files."""
    driver = subprocess.Popen([sys.executable, "-c", DRIVE, str(tmp_path / "out")])
    killed = 0
    for count in (2, 8, 15, 25):
        wait_for(count, tmp_path / "out")
        workers = [p for p in children(driver.pid) if serves(p)]
        if workers:
            os.kill(workers[killed % len(workers)], signal.SIGKILL)
            killed += 1
    assert driver.wait(timeout=900) == 0
    assert killed >= 2
    actual = cl.open_sweep(tmp_path / "out")
    assert actual.done.all()
    identical(actual, undisturbed)


def serves(pid: int) -> bool:
    """True for a process that runs points: it computes, unlike the fork server and the resource
    tracker.
    """
    try:
        pair = [Path(f"/proc/{p}/cmdline").read_bytes() for p in (pid, int(stat(pid)[1]))]
    except OSError:
        return False
    return all(b"forkserver" in line for line in pair)


@pytest.mark.slow
def test_a_point_that_kills_its_worker_is_given_up(torn):
    """It is lost with the signal; others are done."""
    # the deadly point is not among those that the driver itself tries
    points = cl.grid(length=[0.1, 0.9, 0.2, 0.3])
    actual = torn(points, "raise ValueError", "import os; os.kill(os.getpid(), 9)  # ", workers=2)
    assert actual.status.tolist() == ["done", "lost", "done", "done"]
    assert actual.reason[1] == "its worker died: killed by SIGKILL"


@pytest.mark.slow
def test_a_full_disk_stops_the_sweep_and_keeps_what_is_done(tmp_path):
    """A limit on the size of files stands for the full disk: writing a run's file fails half
    way.
    """
    code = (
        "import resource, sys, clearance as cl\n"
        "limit = int(sys.argv[2])\n"
        "if limit: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))\n"
        "try:\n"
        f"    cl.sweep({CASE!r}, cl.grid(speed=[20.0, 25.0, 30.0]), sys.argv[1], fixed={FIXED!r}, "
        f"workers=1, "
        f"**{OPTIONS!r})\n"
        "except cl.SweepError as error:\n    print(error)\n    sys.exit(1)\n"
    )
    out = tmp_path / "out"
    full = subprocess.run(
        [sys.executable, "-B", "-c", code, str(out), str(30_000)],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert full.returncode == 1, full.stderr
    assert "no space left" in full.stdout
    assert not list((out / "runs").glob("*.h5"))
    cl.open_sweep(out)
    after = subprocess.run(
        [sys.executable, "-c", code, str(out), "0"], capture_output=True, text=True, timeout=900
    )
    assert after.returncode == 0, after.stderr
    assert cl.open_sweep(out).done.all()


def test_a_full_disk_at_the_journal_takes_nothing_of_a_line(tmp_path):
    """Half a line is taken back, and the next one is complete."""
    from clearance.sweeping.journal import Journal, Outcome, read

    journal = Journal(tmp_path)
    journal.add(Outcome(0, "a", "done"))
    size = (tmp_path / "journal.jsonl").stat().st_size
    real = journal.file

    class Full:
        def __getattr__(self, name):
            return getattr(real, name)

        def flush(self):
            raise OSError(28, "No space left on device")

    journal.file = Full()
    with pytest.raises(OSError, match="No space"):
        journal.add(Outcome(1, "b", "done"))
    assert (tmp_path / "journal.jsonl").stat().st_size == size
    journal.add(Outcome(2, "c", "done"))
    journal.close()
    assert [o.index for o in read(tmp_path / "journal.jsonl")] == [0, 2]


def test_values_are_the_same_however_they_are_written(copy):
    """Integers, floats and texts with units are one point; words are refused."""
    before = (copy / "journal.jsonl").read_bytes()
    for clearance in ([1e-4, 2e-4, 3e-4], ["0.1 mm", "200um", 3e-4]):
        points = cl.grid(speed=[20, 30], clearance=clearance)
        assert sweeping(points, copy, turns=2, samples_per_turn=50.0).done.all()
        assert (copy / "journal.jsonl").read_bytes() == before
    for ends in ((1e-5, 1e-4), ("10um", "0.1 mm")):
        assert cl.sampled(4, clearance=ends)[1] == cl.sampled(4, clearance=(1e-5, 1e-4))[1]
    with pytest.raises(ValueError, match="speed: '1mm' is in m, expected rad/s"):
        cl.sweep(CASE, cl.grid(speed=["1mm"]), copy, **OPTIONS)
    with pytest.raises(ValueError, match="speed: 'fast' is not a number with an optional unit"):
        cl.sweep(CASE, cl.grid(speed=["fast"]), copy, **OPTIONS)


def test_a_moved_directory_goes_on(tmp_path):
    """With the case file it was made from; a file that was changed is another sweep."""
    one, two = tmp_path / "one", tmp_path / "two"
    one.mkdir(), two.mkdir()
    (one / "torn.py").write_text(FAILS)
    (one / "mine.py").write_text("def late(run):\n    return {'late': float(run.time[-1])}\n")
    points, options = cl.grid(length=[0.1, 0.2]), {"until": 0.1, "workers": 1}
    first = cl.sweep(
        one / "torn.py", points, one / "out", metrics=[f"{one / 'mine.py'}:late"], **options
    )
    for name in ("torn.py", "mine.py", "out"):
        shutil.move(one / name, two / name)
    (two / "out" / "runs" / f"{first.definition.keys[0]}.h5").unlink()
    mine = f"{two / 'mine.py'}:late"
    assert cl.sweep(two / "torn.py", points, two / "out", metrics=[mine], **options).done.all()
    assert len(ended(two / "out")) == 3
    (two / "mine.py").write_text("def late(run):\n    return {'late': 0.0}\n")
    with pytest.raises(ValueError, match="holds another sweep: own"):
        cl.sweep(two / "torn.py", points, two / "out", metrics=[mine], **options)


@pytest.mark.parametrize(
    "end", ["sys.exit(3)", "raise GeneratorExit", "raise KeyboardInterrupt", "raise Bad"]
)
def test_a_metric_may_fail_as_it_likes(end, tmp_path):
    """The point is done, with the line of the metric's file as its reason."""
    bad = "class Bad(Exception):\n    def __str__(self):\n        raise ZeroDivisionError\n"
    text = f"import sys\n{bad}def mine(run):\n    print('noise')\n    {end}\n"
    metric, points = mine(tmp_path, text), cl.grid(speed=[20.0])
    actual = sweeping(points, tmp_path / "out", channels=[], metrics=metric)
    assert actual.status.tolist() == ["done"]
    assert "mine.py, line" in actual.reason[0]


def test_names_of_metrics_that_are_taken(tmp_path):
    """A metric named as a parameter is left out, with the reason."""
    metric = mine(tmp_path, "def mine(run):\n    return {'speed': 1.0}\n")
    actual = sweeping(cl.grid(speed=[20.0]), tmp_path / "out", metrics=metric)
    assert "metric 'speed': the name is taken" in actual.reason[0]


def test_a_directory_of_other_things_is_refused(tmp_path):
    """Nothing in it is changed."""
    (tmp_path / "journal.jsonl").write_text("mine\n")
    with pytest.raises(ValueError, match=r"has journal\.jsonl but no sweep\.json"):
        again(tmp_path)
    assert (tmp_path / "journal.jsonl").read_text() == "mine\n"
    with pytest.raises(ValueError, match="is a file; give a directory"):
        again(tmp_path / "journal.jsonl")


def test_an_index_alone_is_read(tmp_path):
    """Without its journal and run files; the same call writes the journal again."""

    def force():
        actual = sweeping(cl.grid(speed=[20.0, 25.0]), tmp_path / "out", channels=[])
        assert actual.done.all()
        return actual.metrics["joint_C_force_max"]

    first = force()
    (tmp_path / "out" / "journal.jsonl").unlink()
    actual = cl.open_sweep(tmp_path / "out").metrics["joint_C_force_max"]
    assert (actual == first).all()
    assert (force() == first).all()
    assert len(ended(tmp_path / "out")) == 2


def test_values_that_were_not_swept(swept):
    """The message lists those that were; rounding does not matter."""
    with pytest.raises(ValueError, match=r"speed=31 was not swept; there are 20\.0, 30\.0"):
        swept.run(speed=31, clearance=1e-4)
    assert swept.select(speed=30.0 * (1 + 1e-9)).tolist() == [3, 4, 5]


def test_an_interrupt_keeps_what_is_done(tmp_path):
    """The index has all finished points, and no thread stays."""
    reports = []

    def stop(progress):
        reports.append(progress)
        if progress.done >= 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        finish(tmp_path / "out", progress=stop)
    assert reports[-1].done >= 3
    assert cl.open_sweep(tmp_path / "out").done.sum() >= 3
    assert threading.active_count() < 10


def test_opening_what_is_no_sweep(tmp_path):
    """Empty folders and other documents are refused."""
    with pytest.raises(FileNotFoundError, match="no sweep in"):
        cl.open_sweep(tmp_path)
    (tmp_path / "sweep.json").write_text("{}")
    with pytest.raises(ValueError, match="is not the definition of a sweep"):
        cl.open_sweep(tmp_path)


def test_missing_extras_are_named(swept, monkeypatch):
    """The message has the command that installs them."""
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(
        ImportError, match=r"xarray is not installed: pip install 'clearance\[xarray\]'"
    ):
        print(indices.Sweep(swept.folder).dataset)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"pip install 'clearance\[cluster\]'"):
        again(swept.folder.with_name("never"), scheduler="tcp://localhost:1")
