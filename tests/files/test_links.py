"""Fixed names: none of them leads elsewhere, and two runs onto one are safe."""

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from clearance.files.locks import Foreign, Lock
from clearance.machine import store
from clearance.results import short_file
from clearance.run.checkpoint import parts_folder

TEXTS = ["", "x", "thesis\n" * 99, "process", "#!/bin/sh\n", "process 12 on host\n" * 40]


@pytest.fixture
def outside(tmp_path):
    """Something of the user's outside of the folder, and all that must stay of it."""
    target = tmp_path / "mine"
    target.mkdir()
    for name in ("a.h5.1.0.partial", "thesis.tex", "0000.h5"):
        (target / name).write_text("mine")

    before = dict.fromkeys((p.name for p in target.iterdir()), "mine")

    def unchanged():
        return {p.name: p.read_text() for p in target.iterdir()} == before

    return target, unchanged


def test_S1_a_lock_neither_follows_links_nor_empties_files(tmp_path):
    """200 names with random contents, as files, links, links to nothing, folders and pipes."""
    rng = random.Random(1)
    for i in range(200):
        path, target = tmp_path / f"{i}.lock", tmp_path / f"{i}.txt"
        text, kind = rng.choice(TEXTS), rng.choice(["file", "link", "nowhere", "pipe"])
        if kind in ("file", "link"):
            target.write_text(text)
        if kind == "file":
            os.link(target, path)
        elif kind == "pipe":
            os.mkfifo(path)
        else:
            path.symlink_to(target)
        ours = kind == "file" and (not text or (text.startswith("process ") and len(text) < 301))
        if ours:
            Lock(path).release()
        else:
            with pytest.raises(Foreign, match=path.name):
                Lock(path)
            assert (target.read_text() if target.exists() else text) == text


def test_S1_commands_refuse_a_link_in_place_of_a_lock(tmp_path, monkeypatch, typed, outside):
    """Runs, sweeps and lives, in one line; the target stays."""
    target, unchanged = outside
    monkeypatch.chdir(tmp_path)
    wear = ["wear", "slider_crank", "-p", "model=dry", "-p", "wear=1e-4mm3/Nm", "--turns", "2"]
    sweep = ["sweep", "slider_crank", "-p", "speed=10,20", "--workers", "1"]
    for i, (lock, command) in enumerate(
        [("r.h5.lock", ["run", "slider_crank", "--turns", "1"]), ("s/lock", sweep)]
        + [("l/life.lock", wear)]
    ):
        path = tmp_path / lock
        path.parent.mkdir(exist_ok=True)
        path.symlink_to(target / "thesis.tex")
        assert f"{path} is a link" in typed.line(
            *command, "-o", path.parent if i else tmp_path / "r.h5"
        )
    assert unchanged()


@pytest.mark.parametrize("name", ["sweep.log", "journal.jsonl", "runs"])
def test_S2_a_sweep_follows_no_link(tmp_path, typed, outside, name):
    """A link in the folder of a sweep is refused; its target is unharmed."""
    target, unchanged = outside
    folder = tmp_path / "sweep"
    sweep = "sweep slider_crank -p speed=10,20 --turns 1 --workers 1"
    typed(sweep, "-o", folder)
    if (folder / name).is_dir():
        os.rename(folder / name, tmp_path / "aside")
    else:
        (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(target if name == "runs" else target / "thesis.tex")
    assert f"{folder / name} is a link" in typed.line(sweep, "-o", folder)
    assert unchanged()


@pytest.mark.parametrize("patience", [0.0, 1e3])
def test_S2_a_run_replaces_links(tmp_path, monkeypatch, outside, patience):
    """A short one and one that goes on in a file."""
    target, unchanged = outside
    monkeypatch.setattr(short_file, "PATIENCE", patience)
    for name in ("r.h5", "r.h5.partial"):
        (tmp_path / name).symlink_to(target / "none.h5" if name == "r.h5" else target / "0000.h5")
    cl.simulate(cl.load_case("slider_crank"), turns=1, path=tmp_path / "r.h5").close()
    assert not (tmp_path / "r.h5").is_symlink()
    assert cl.open_result(tmp_path / "r.h5").complete
    assert unchanged()


def test_S2_checkpoints_are_in_no_linked_folder(tmp_path, outside):
    """A linked folder of checkpoints is refused."""
    target, unchanged = outside
    parts_folder(tmp_path / "r.h5").symlink_to(target)
    with pytest.raises(ValueError, match=r"r\.h5\.parts is a link"):
        cl.simulate(cl.load_case("slider_crank"), turns=1, path=tmp_path / "r.h5", checkpoint=0.1)
    assert unchanged()


WITHOUT_LOCKS = """
import errno, fcntl
def flock(*_):
    raise OSError(errno.ENOLCK, "No locks available")
fcntl.flock = flock
"""


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("checkpoint", [False, True])
def test_L5_two_runs_without_locks_are_safe_or_refused(tmp_path, checkpoint, times):
    """Of a second or two each, started together."""
    (tmp_path / "sitecustomize.py").write_text(WITHOUT_LOCKS)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tmp_path), str(Path(cl.__file__).parent.parent)]),
        "HDF5_USE_FILE_LOCKING": "FALSE",
    }
    code = (
        "import sys; from clearance import cli; from clearance.results import short_file; "
        "short_file.PATIENCE = 0.0; cli.entry()"
    )
    call = [sys.executable, "-c", code, "run", "slider_crank", "-p", "model=dry", "--turns", "12"]
    call += ["--checkpoint", "0.1"] if checkpoint else []
    for i in range(times):
        path = tmp_path / f"{i}.h5"
        runs = [
            subprocess.Popen(
                [*call, "-o", path], env=environment, stderr=subprocess.PIPE, text=True
            )
            for _ in range(2)
        ]
        errors = [run.communicate()[1] for run in runs]
        if checkpoint:
            assert [run.returncode for run in runs] == [2, 2], errors
            assert all("this file system has no locks" in error for error in errors)
        else:
            assert [run.returncode for run in runs] == [0, 0], errors
            with cl.open_result(path) as run:
                assert run.complete
                for column in run.reader.columns():
                    if not column.endswith(("/event", "/step_number")):
                        run.reader.column(column)
        assert {p.suffix for p in tmp_path.glob("*.*.*")} <= {".h5"}


def test_T3_a_user_without_a_folder(monkeypatch):
    """Then the store takes no files, as a read-only folder; nothing stops."""
    for name in ("HOME", "XDG_CACHE_HOME", "CLEARANCE_STORE"):
        monkeypatch.delenv(name, raising=False)

    def without(*_):
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", without)
    assert not store.file_of("kernel").exists()
    with store.alone(store.file_of("kernel")):
        pass
