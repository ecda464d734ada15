"""Commands that are killed at random moments, and the same command again until it is done.

    python -m tests.benchmarks.kills [NAME ...] [--kills 40] [--seed 0] [--update]

Each command runs once in peace. Then SIGKILL ends it and its workers at a random moment of that
time, again and again in one folder; one that comes to its end begins anew in an empty folder. Some
are killed only once they have written a file anew, such as a checkpoint. After each kill every file
of a final name must be complete. At each end the results must be those of the run in peace, to the
last bit. `loads` are larger things: a race for an empty store, a Dask worker's death, 20,000 dry
turns, 2000 run files. With names, --update puts their rows only. The exit status is 1 where
something is wrong.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import clearance as cl
from clearance.results.reading import Damaged, Reader
from clearance.results.result import DIMENSIONS
from clearance.run import again
from tests.benchmarks.publishing import RESULTS, options, put_rows

CALL = [sys.executable, "-c"]
COMMAND = "from clearance.cli import entry; entry()"
LIVES = """
import sys, clearance as cl
fixed = {"model": "dry", "wear": 1e-13}
life = {"turns": 300.0, "settle": 0, "average": 1}
points = cl.grid(speed=[20.0, 30.0])
cl.sweep("slider_crank", points, sys.argv[1], fixed=fixed, life=life, workers=2)
"""
BEGIN = "<!-- kills -->"
DRY = "slider_crank -p model=dry"
SWEEP = f"sweep {DRY} -p speed=10:30:6 --turns 2"
#: name -> command; OUT is its folder
KILLED = {
    "run": f"run {DRY} --turns 60 -o OUT/r.h5",
    "run with checkpoints": f"run {DRY} --turns 60 --checkpoint 0.05 -o OUT/r.h5",
    "run from a checkpoint": f"run {DRY} --turns 200 --checkpoint 0.05 -o OUT/r.h5",
    "sweep": f"{SWEEP} --workers 2 --channels none -o OUT",
    "sweep with run files": f"{SWEEP} --workers 2 -o OUT",
    "wear": f"wear {DRY} -p wear=1e-13 --turns 2000 --settle 0 --average 1 -o OUT",
    "lives in a sweep": LIVES,
    "scatter": f"scatter {DRY} -p clearance=normal(1e-4,1e-5) --points 24 --workers 2 -o OUT",
    "figures": "figures feeder_sketch --quick --workers 1 -o OUT",
}
#: file that a command has written anew before it is killed
AFTER = {"run from a checkpoint": "r.h5.parts/state.npz"}


@dataclass
class Count:
    """Kills and ends of a command. wrong: lines about it."""

    kills: int = 0
    ends: int = 0
    seconds: float = 0.0
    wrong: list[str] = field(default_factory=list)


def started(command: str, out: Path, **options) -> subprocess.Popen:
    """A command in a group of processes of its own."""
    words = [COMMAND, *command.replace("OUT", str(out)).split()]
    words = [command, str(out)] if command is LIVES else words
    quiet = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen([*CALL, *words], start_new_session=True, **quiet | options)


def finished(process: subprocess.Popen) -> str:
    """Nothing, or the end of what a command printed that did not do its work."""
    text, _ = process.communicate()
    return "" if process.returncode == 0 else f"exit {process.returncode}: {text[-300:]!r}"


# --- files
def columns(path: Path) -> dict[str, bytes]:
    """All columns of an HDF5 file of ours. Raises ValueError for a damaged one."""
    import h5py

    aside = {f"{group}/{name}" for group, name in DIMENSIONS.items()}
    try:
        with Reader(path, h5py.File(path)) as reader:
            names = set(reader.columns()) - aside
            return {name: reader.column(name).tobytes() for name in names}
    except OSError as error:
        raise Damaged(f"{path}: {error}") from None


def damaged(folder: Path) -> list[str]:
    """Files of final names that are not complete."""
    wrong = []
    for path in (p for p in folder.rglob("*") if p.is_file() and ".partial" not in p.name):
        if path.suffix == ".png" and not path.read_bytes().endswith(b"IEND\xaeB`\x82"):
            wrong.append(f"{path} is cut short")
        if path.suffix == ".npz":
            with np.load(path) as arrays:
                dict(arrays)
        if path.suffix == ".h5" and ".parts" not in str(path.parent):
            try:
                columns(path)
            except ValueError as error:
                wrong.append(str(error))
    return wrong


def results(out: Path) -> object:
    """Numbers that a command computed, without the time it took."""
    if (out / "life.json").exists():
        life = cl.Life(out)
        return life.stages, [life.depth(j).tolist() for j in life.joints]
    if (out / "sweep.json").exists():
        sweep = cl.open_sweep(out)
        runs = {p.name: moved(p) for p in sorted((out / "runs").glob("*.h5"))}
        metrics = {n: v.tolist() for n, v in sorted(sweep.metrics.items())}
        return sweep.status.tolist(), metrics, runs
    runs = {p.name: moved(p) for p in sorted(out.glob("*.h5"))}
    return runs, sorted(p.name for p in out.glob("*.png"))


def moved(path: Path) -> dict[str, bytes]:
    """Columns of the motion of a run."""
    return {n: c for n, c in columns(path).items() if n.partition("/")[0] in again.COMPARED}


# --- kills
def killed(
    command: str, kills: int, rng: random.Random, folder: Path, after: str | None = None
) -> Count:
    """A command that is killed at so many moments; after: of those behind a file's writing."""
    count, peace, out = Count(), folder / "peace", folder / "out"
    for directory in (peace, out):
        directory.mkdir()
    begin = time.monotonic()
    if wrong := finished(started(command, peace)):
        return Count(wrong=[f"in peace: {wrong}"])
    count.seconds = time.monotonic() - begin
    entire = repr(results(peace))
    while count.kills < kills:
        before = _stamp(out, after)
        process = started(command, out)
        while after and process.poll() is None and _stamp(out, after) == before:
            time.sleep(0.005)
        try:
            process.communicate(timeout=rng.uniform(0.0, count.seconds))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            count.kills += 1
            count.wrong += damaged(out)
        else:
            _ended(process.returncode, out, entire, count)
    count.wrong += [wrong] if (wrong := finished(started(command, out))) else []
    _ended(0, out, entire, count)
    return count


def _stamp(out: Path, name: str | None) -> int:
    """Time of the last change of a file; 0 where there is none."""
    path = out / (name or "")
    return path.stat().st_mtime_ns if path.is_file() else 0


def _ended(status: int, out: Path, entire: str, count: Count) -> None:
    """A command came to its end: its results, and an empty folder for the next."""
    count.ends += 1
    if status or repr(results(out)) != entire:
        count.wrong.append(f"end {count.ends} (exit {status}) has other results than in peace")
    shutil.rmtree(out)
    out.mkdir()


# --- larger things
def race(folder: Path) -> Count:
    """Ten processes on an empty store: equal files."""
    environment = {**os.environ, "CLEARANCE_STORE": str(folder / "store")}
    outs = [folder / str(i) for i in range(10)]
    command = f"run {DRY} --turns 2 -o OUT/r.h5"
    runs = [started(command, out, env=environment) for out in outs]
    wrong = [text for run in runs if (text := finished(run))]
    if not wrong and len({repr(results(out)) for out in outs}) > 1:
        wrong.append("their files differ")
    return Count(ends=len(outs), wrong=wrong)


def cluster(folder: Path) -> Count:
    """A Dask worker dies at a random moment, five times: no point is lost."""
    from distributed import LocalCluster

    count, command = Count(), f"{SWEEP} -o OUT"
    begin = time.monotonic()
    count.wrong += [w for w in [finished(started(command, folder / "peace"))] if w]
    entire, rng = repr(results(folder / "peace")), random.Random(0)
    count.seconds = time.monotonic() - begin
    for i in range(5):
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as dask:
            out = folder / str(i)
            process = started(f"{command} --scheduler {dask.scheduler_address}", out)
            time.sleep(rng.uniform(1.0, 1.0 + count.seconds))
            os.kill(next(iter(dask.workers.values())).pid, signal.SIGKILL)
            count.kills, count.ends = count.kills + 1, count.ends + 1
            count.wrong += [w for w in [finished(process)] if w]
        if repr(results(out)) != entire:
            count.wrong.append(f"sweep {i} has other results")
    return count


def many_turns(folder: Path) -> Count:
    """20,000 dry turns in one file."""
    command = f"run {DRY} --turns 20000 --samples-per-turn 20 --method dop853 -o OUT/r.h5"
    begin = time.monotonic()
    wrong = finished(started(command, folder))
    count = Count(ends=1, seconds=time.monotonic() - begin, wrong=[wrong] if wrong else [])
    with cl.open_result(folder / "r.h5") as run:
        if not run.complete or len(run.time) != 20 * 20000 + 1 or damaged(folder):
            count.wrong.append(f"{run!r}")
        if not run.solver["energy_residual_share"] < 1e-3:
            count.wrong.append(f"energy {run.solver['energy_residual_share']:g}")
    return count


def many_files(folder: Path) -> Count:
    """2000 run files in one sweep."""
    command = "sweep slider_crank -p model=ideal -p speed=10:30:2000 --turns 1"
    command += " --channels bodies/slider/* --workers 2 -o OUT"
    begin = time.monotonic()
    wrong = [w for w in [finished(started(command, folder))] if w]
    count = Count(ends=1, seconds=time.monotonic() - begin, wrong=wrong + damaged(folder))
    sweep = cl.open_sweep(folder)
    if not sweep.done.all() or len(list((folder / "runs").iterdir())) != 2000:
        count.wrong.append(f"{sweep!r}")
    return count


LOADS: dict[str, Callable[[Path], Count]] = {
    "ten processes, empty store": race,
    "a Dask worker dies": cluster,
    "20,000 dry turns": many_turns,
    "2000 run files": many_files,
}


def table(counts: dict[str, Count]) -> list[str]:
    """Rows of the table of counts."""
    head = ["| command | kills | ends with equal results | wrong |", "|---|---|---|---|"]
    rows = [f"| {n} | {c.kills} | {c.ends} | {len(c.wrong)} |" for n, c in counts.items()]
    return head + rows


def parsed(arguments: list[str] | None = None) -> int:
    """Try the commands; the exit status."""
    chosen = options(
        "commands that are killed at random moments",
        arguments,
        names=([], f"of {', '.join([*KILLED, *LOADS])}"),
        kills=(40, "of each command (40)"),
        seed=(0, "of the moments"),
    )
    counts = {}
    for name in chosen.names or [*KILLED, *LOADS]:
        with tempfile.TemporaryDirectory() as directory:
            rng = random.Random(f"{chosen.seed} {name}")
            if name in KILLED:
                after = AFTER.get(name)
                counts[name] = killed(KILLED[name], chosen.kills, rng, Path(directory), after)
            else:
                counts[name] = LOADS[name](Path(directory))
        print(table(counts)[-1], *counts[name].wrong, sep="\n", flush=True)
    if chosen.update:
        put_rows(RESULTS, table(counts), BEGIN)
    return int(any(count.wrong for count in counts.values()))


if __name__ == "__main__":
    sys.exit(parsed())
