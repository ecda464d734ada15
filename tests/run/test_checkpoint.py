"""A killed run goes on from its last checkpoint and gives the file it would have given."""

import random
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.run.checkpoint import load, parts_folder, save
from tests.seeds import few_of

CALL = """
import sys
import clearance as cl
scene = cl.load_case("slider_crank", model="dry")
options = {"samples_per_turn": 200, "checkpoint": 0.05, "compression": 1}
cl.simulate(scene, turns=float(sys.argv[2]), path=sys.argv[1], **options)
"""
TURNS = 120


def same(one, other) -> None:
    """Every dataset and every attribute but those of the time of day and of the time it took."""
    with h5py.File(one) as a, h5py.File(other) as b:
        names: list[str] = []
        a.visit(names.append)
        count: list[str] = []
        b.visit(count.append)
        assert names == count
        for name in ["/", *names]:
            first, second = dict(a[name].attrs), dict(b[name].attrs)
            for key in first.keys() | second.keys():
                if key.removesuffix("_crc32") not in (
                    "created",
                    "command",
                    "wall_s",
                    "loop_s",
                    "REFERENCE_LIST",
                    "DIMENSION_LIST",
                ):
                    np.testing.assert_array_equal(first[key], second[key], err_msg=f"{name} {key}")
            if isinstance(a[name], h5py.Dataset):
                np.testing.assert_array_equal(a[name][()], b[name][()], err_msg=name)


def killed_at(path, stretches: int) -> None:
    """Start a run in a process of its own and kill it once it has stored so many stretches, or a
    few more where this process is held up.
    """
    process = subprocess.Popen([sys.executable, "-c", CALL, str(path), str(TURNS)])
    parts = path.with_name(f"{path.name}.parts")

    def stored():
        return any(p.name[:4] >= f"{stretches:04d}" for p in parts.glob("*.h5*"))

    while not stored() and process.poll() is None:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert stored()
    assert not path.exists()


@pytest.mark.slow
def test_a_killed_run_goes_on_and_gives_the_same_file(tmp_path):
    """A run killed twice ends in the same file."""
    scene = cl.load_case("slider_crank", model="dry")
    entire = cl.simulate(
        scene, turns=TURNS, samples_per_turn=200, path=tmp_path / "whole.h5", compression=1
    )
    path = tmp_path / "run.h5"
    killed_at(path, 1)
    killed_at(path, 3)
    subprocess.run([sys.executable, "-c", CALL, str(path), str(TURNS)], check=True)
    assert not (tmp_path / "run.h5.parts").exists()
    same(entire.path, path)


def test_an_interrupted_run_keeps_its_file_and_goes_on(tmp_path):
    """An interrupted run has its part, and goes on from there."""
    scene, path, shares = cl.load_case("slider_crank", model="dry"), tmp_path / "run.h5", []

    def interrupt(share):
        shares.append(share)
        if share > 0.6:
            raise KeyboardInterrupt

    options = {"turns": 24, "path": path, "checkpoint": 1e-9}
    with pytest.raises(KeyboardInterrupt):
        cl.simulate(scene, **options, progress=interrupt)
    partial = cl.open_result(path)
    assert partial.status.startswith("partial: interrupted")
    assert partial.time[-1] > 0.55 * 24 * scene.turn
    partial.close()
    again = cl.simulate(scene, **options, progress=shares.append)
    assert again.complete
    assert min(shares[shares.index(max(s for s in shares if s < 0.62)) + 1 :]) > 0.55
    same(again.path, cl.simulate(scene, turns=24, path=tmp_path / "whole.h5").path)


def test_checkpoints_of_another_run_are_refused(tmp_path):
    """Other options are refused by name."""
    path = tmp_path / "run.h5"
    killed_at(path, 1)
    scene = cl.load_case("slider_crank", model="dry")
    with pytest.raises(
        ValueError, match=r"run\.h5\.parts holds checkpoints of another run \(other rtol\)"
    ):
        cl.simulate(
            scene,
            turns=TURNS,
            samples_per_turn=200,
            path=path,
            checkpoint=1.0,
            compression=1,
            rtol=1e-5,
        )
    other = cl.load_case("slider_crank", model="dry", clearance=2e-4)
    with pytest.raises(ValueError, match="another run"):
        cl.simulate(
            other, turns=TURNS, samples_per_turn=200, path=path, checkpoint=1.0, compression=1
        )
    state = path.with_name("run.h5.parts") / "state.npz"
    state.write_bytes(state.read_bytes()[:1000])
    with pytest.raises(ValueError, match="cannot be read"):
        cl.simulate(
            scene, turns=TURNS, samples_per_turn=200, path=path, checkpoint=1.0, compression=1
        )


def test_bad_input():
    """Checkpoints need a path, a positive time and no film with a memory."""
    scene = cl.load_case("slider_crank", model="dry")
    with pytest.raises(ValueError, match="checkpoint needs a path"):
        cl.simulate(scene, turns=1, checkpoint=1.0)
    with pytest.raises(ValueError, match="checkpoint must be"):
        cl.simulate(scene, turns=1, checkpoint=-1.0, path="never.h5")
    film = cl.load_case("slider_crank", model="lubricated", film="conserving")
    with pytest.raises(ValueError, match="memory that no checkpoint keeps"):
        cl.simulate(film, turns=1, checkpoint=1.0, path="never.h5")


def interrupted(path, scene):
    """A run with two checkpoints that was interrupted."""

    def progress(done):
        if (parts_folder(path) / "0001.h5").exists():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cl.simulate(scene, turns=200, path=path, checkpoint=0.02, progress=progress)


@pytest.mark.slow
@pytest.mark.parametrize("part", few_of(range(4), 1))
def test_a_checkpoint_of_another_kind_is_refused(part, tmp_path):
    """Each entry of the state as a NaN, a text, of another shape, or left out: by name; a quarter
    of them at a time.
    """
    path, scene = tmp_path / "run.h5", cl.load_case("slider_crank", model="dry")
    interrupted(path, scene)
    file = parts_folder(path) / "state.npz"
    state, rng = load(file), random.Random(part)
    assert {"record.low", "ledger.worst", "last.row", "method", "changes", "stretches"} <= {*state}
    for name in [*state][part::4]:
        values = [np.array("a text"), np.zeros((2, 2, 2)), None]
        if state[name].dtype.kind in "fU":
            values += [state[name] * np.nan if state[name].dtype.kind == "f" else np.array(-1)]
        value = rng.choice(values)
        changed = {n: v for n, v in state.items() if n != name or value is not None}
        save(file, changed if value is None else changed | {name: value})
        if value is None and name.startswith(("ledger.last", "ledger.since", "last.")):
            continue  # a run that has not begun has none
        if str(value) == "a text" and name in ("reason", "dead_centre"):
            continue
        reason = rf"state\.npz is no checkpoint .*{name}"
        if name in ("identity", "stretches", "version"):
            reason = r"state\.npz is no JSON|holds checkpoints of another version"
        with pytest.raises(ValueError, match=reason):
            cl.simulate(scene, turns=200, path=path, checkpoint=1.0)
    save(file, state)
    assert cl.simulate(scene, turns=200, path=path, checkpoint=1.0).complete


def test_a_damaged_stretch_is_named_by_its_file(tmp_path):
    """A damaged stretch is refused by file and place."""
    path, scene = tmp_path / "run.h5", cl.load_case("slider_crank", model="dry")
    interrupted(path, scene)
    stretch = parts_folder(path) / "0000.h5"
    with h5py.File(stretch) as file:
        begin = file["bodies/crank/vx"].id.get_chunk_info(0).byte_offset
    content = bytearray(stretch.read_bytes())
    content[begin + 64 : begin + 128] = bytes(64)
    stretch.write_bytes(content)
    with pytest.raises(ValueError, match=r"run\.h5\.parts/0000\.h5: /bodies/crank/vx"):
        cl.simulate(scene, turns=200, path=path, checkpoint=1.0)
