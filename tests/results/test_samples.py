"""Samples of long runs in a file without a name: the same numbers, and few of them in memory."""

import errno

import numpy as np
import pytest

import clearance as cl
from clearance.results import extremes as integrals
from clearance.results import recorder as samples
from clearance.results.recorder import Samples


def taken(random, width: int, pieces: int) -> tuple[Samples, np.ndarray, np.ndarray]:
    """Samples that come in pieces of random lengths, and all of their times and rows."""
    one, times, rows = Samples(width), [], []
    for _ in range(pieces):
        n = int(random.integers(1, 40))
        times.append(random.normal(size=n))
        rows.append(random.normal(size=(n, width)))
        one.append(times[-1], rows[-1])
    return one, np.concatenate(times), np.concatenate(rows)


def same(one: Samples, times: np.ndarray, rows: np.ndarray) -> None:
    """All of them, in every way to read them."""
    np.testing.assert_array_equal(one.times, times)
    for i in range(rows.shape[1]):
        np.testing.assert_array_equal(one.column(i), rows[:, i])
    blocks = list(one.blocks())
    np.testing.assert_array_equal(np.concatenate([t for t, _ in blocks]), times)
    np.testing.assert_array_equal(np.concatenate([r for _, r in blocks]), rows)
    assert one.count == len(times)


@pytest.mark.parametrize("room", [0, 50, 500, 10**9])
def test_every_sample_comes_back(monkeypatch, room):
    """Pieces, widths and rooms at random; numbers in memory never exceed the room."""
    monkeypatch.setattr(samples, "ROOM", room)
    random = np.random.default_rng(5)
    for _ in range(30):
        width = int(random.integers(1, 9))
        one, times, rows = taken(random, width, int(random.integers(1, 12)))
        assert sum(t.size for t, _ in one.held) * width <= room
        same(one, times, rows)


def test_a_full_disk_leaves_them_in_memory(monkeypatch):
    """From the piece on that the disk refuses, also in the middle of it."""
    monkeypatch.setattr(samples, "ROOM", 20)
    random = np.random.default_rng(5)

    class Full:
        """A file with room for some writes."""

        def __init__(self, file, writes):
            self.file, self.writes = file, writes

        def __getattr__(self, name):
            return getattr(self.file, name)

        def write(self, data):
            self.writes -= 1
            if self.writes < 0:
                raise OSError(errno.ENOSPC, "full")
            return self.file.write(data)

    real = samples.tempfile.TemporaryFile
    for writes in range(8):
        monkeypatch.setattr(samples.tempfile, "TemporaryFile", lambda w=writes: Full(real(), w))
        one, times, rows = taken(random, 3, 6)
        assert one.refused
        assert len(one.stored) <= writes // 2
        same(one, times, rows)


def test_errors_of_a_long_run_do_not_depend_on_the_room(monkeypatch, tmp_path):
    """The same file and the same stated errors, bit for bit, with all samples in memory and with
    none; no row stays in the memory of the run or of its companions.
    """
    in_memory, columns = [], samples.Samples.column
    monkeypatch.setattr(
        samples.Samples,
        "column",
        lambda s, i: in_memory.append(sum(t.size for t, _ in s.held)) or columns(s, i),
    )

    def numbers(room: int, name: str) -> tuple:
        in_memory.clear()
        monkeypatch.setattr(samples, "ROOM", room)
        scene = cl.load_case("slider_crank", model="lubricated")
        with cl.simulate(scene, turns=4, path=tmp_path / name) as run:
            values = {
                p: run.values(p).tobytes() for p in ("time", "joints/C/gap", "drives/crank/torque")
            }
            return values, dict(run.errors), run.errors.channels, max(in_memory)

    held, stored = numbers(10**9, "held.h5"), numbers(0, "stored.h5")
    assert held[:3] == stored[:3]
    assert (held[3], stored[3]) == (1601, 0)


def test_parts_of_long_runs_stay_few():
    """At most so many as a run has stretches, or `MOST`."""
    random = np.random.default_rng(5)
    for count in np.exp(random.uniform(0.0, 12.0, size=200)).astype(int):
        assert integrals.parts(int(count)) * count <= max(integrals.MOST, count)
