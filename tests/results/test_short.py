"""Files of short runs, made from images: the same as those that HDF5 writes, complete or honest."""

import errno
import random
from pathlib import Path

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.results import hdf5_image, short_file
from clearance.results.hdf5_image import Image, Unknown, header

#: attributes that are places in a file
PLACES = ("REFERENCE_LIST", "DIMENSION_LIST")
#: attributes that time, not the run, decides
TIMED = ("created", "created_crc32", "wall_s", "loop_s")


def content(path):
    """All of a file: attributes and values by place."""
    out = {}

    def add(name, item):
        about = {n: v for n, v in item.attrs.items() if n not in (*PLACES, *TIMED)}
        out[name] = [about]
        if isinstance(item, h5py.Dataset):
            kind = item.shape, item.maxshape, item.chunks, item.fletcher32, item.dtype
            scales = [[s.name for s in axis.values()] for axis in item.dims]
            out[name] += [kind, scales, item[()]]

    with h5py.File(path) as file:
        add("/", file)
        file.visititems(add)
    return out


def run(path, model, turns=1.0, **options):
    """A run of the slider-crank and its file."""
    return cl.simulate(cl.load_case("slider_crank", model=model), turns=turns, path=path, **options)


@pytest.mark.parametrize(
    ("model", "turns", "options"),
    [("dry", 1.0, {}), ("lubricated", 6.0, {}), ("ideal", 1.0, {}), ("ideal", 1.0, {"samples": 2})],
)
def test_an_image_gives_the_same_file(tmp_path, monkeypatch, model, turns, options):
    """Other numbers in the image of a run: every place of the file that HDF5 writes of them; also
    contacts, two chunks and stated errors, and steps in many chunks of two rows.
    """
    monkeypatch.setattr(short_file, "_images", {})
    for name in ("first", "second"):  # it is made of the second
        run(tmp_path / f"{name}.h5", model, turns, **options)
    assert [type(image) for image in short_file._images.values()] == [Image]
    run(tmp_path / "filled.h5", model, turns, rtol=3e-6, **options)
    count = len(short_file._images)
    monkeypatch.setattr(hdf5_image, "available", lambda: False)
    run(tmp_path / "written.h5", model, turns, rtol=3e-6, **options)
    filled, written = (content(tmp_path / f"{n}.h5") for n in ("filled", "written"))
    assert filled.keys() == written.keys()
    for item, parts in written.items():
        np.testing.assert_equal(filled[item], parts, err_msg=item)
    assert count == 1 or model == "dry"  # contacts may need another number of chunks


def test_frames_that_a_profiler_keeps_are_in_nobodys_way(tmp_path, monkeypatch):
    """A sampler of stacks, as in Dask's workers, keeps what a frame has: here views of the file."""
    views, fill = [], Image._fill

    def filling(self, out, column, values):
        fill(self, out, column, values)
        views.append(np.frombuffer(out, np.uint8))

    monkeypatch.setattr(Image, "_fill", filling)
    monkeypatch.setattr(short_file, "_images", {})
    for rtol in (1e-6, 1e-6, 3e-6):
        run(tmp_path / f"{rtol}.h5", "lubricated", rtol=rtol)
    assert views


def test_lengths_of_columns_do_not_mix(monkeypatch, tmp_path):
    """Each file holds all samples of its run, whatever numbers of samples came before it."""
    monkeypatch.setattr(short_file, "_images", {})
    for samples in (51, 201, 101, 601, 2001, 51, 201, 101, 51, 201):
        run(tmp_path / "run.h5", "ideal", samples=samples, error=None).close()
        with cl.open_result(tmp_path / "run.h5") as result:
            assert result.time.size == samples
            np.testing.assert_allclose(np.diff(result.time), result.time[-1] / (samples - 1))


def content_read(path):
    """Range and samples of a channel."""
    with cl.open_result(path) as result:
        return result.range("bodies/slider/x"), result["slider"].x


def test_a_damaged_file_from_an_image_is_seen(tmp_path, monkeypatch):
    """Columns and headers of a filled image have checksums of their own: a flipped bit raises."""
    monkeypatch.setattr(short_file, "_images", {})
    for name in ("first", "second", "filled"):
        run(tmp_path / f"{name}.h5", "ideal", error=None)
    path = tmp_path / "filled.h5"
    with h5py.File(path) as file:
        offset = file["bodies/slider/x"].id.get_chunk_info(0).byte_offset
        head = h5py.h5o.get_info(file["bodies/slider/x"].id).addr
    data = path.read_bytes()
    for at in (offset + 17, header(data, head).attributes["actual_range"][0]):
        path.write_bytes(data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
        with pytest.raises(ValueError, match="filled.h5"):
            content_read(path)


def test_no_file_has_a_text_of_another_run(tmp_path, monkeypatch):
    """Six runs of random speeds from one image: each file has its own numbers only."""
    monkeypatch.setattr(short_file, "_images", {})
    rng, path = random.Random(12), tmp_path / "run.h5"
    numbers = [repr(rng.uniform(20.0, 30.0)).encode() for _ in range(6)]
    for number in numbers:
        scene = cl.load_case("slider_crank", model="ideal", speed=float(number))
        cl.simulate(scene, turns=1.0, path=path, error=None).close()
        assert [n for n in numbers if n in path.read_bytes()] == [number]
    assert len(short_file._images) == 1


def test_a_run_without_a_path_makes_no_file(tmp_path, monkeypatch):
    """It is in memory, reads and is saved like one in a file; its path is written when needed."""
    monkeypatch.setattr(short_file, "temporary_file", None)
    with run(None, "lubricated") as result:
        again = cl.open_result(result.save(tmp_path / "run.h5"))
        np.testing.assert_array_equal(result["slider"].x, again["slider"].x)
        assert result.errors["joints/C/gap_min"] == again.errors["joints/C/gap_min"]
        assert Path(result.path).read_bytes() == (tmp_path / "run.h5").read_bytes()


def test_a_run_that_lasts_goes_on_in_a_file(tmp_path, monkeypatch):
    """The file holds what was computed before: a process that is killed loses none of it."""
    monkeypatch.setattr(short_file, "PATIENCE", 0.0)
    seen = []

    def look(share):
        seen.append((tmp_path / "run.h5.partial").exists())

    result = run(tmp_path / "run.h5", "dry", progress=look)
    assert any(seen)
    assert result.complete
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_a_full_disk_keeps_what_fits(tmp_path, monkeypatch):
    """The file does not fit in one piece: the run is there as of one that ended early."""

    def full(*_):
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr(short_file, "replace_file", full)
    with pytest.raises(cl.SimulationError, match="what fitted is stored in") as caught:
        run(tmp_path / "run.h5", "dry")
    assert caught.value.result.status.startswith("partial: ")
    assert caught.value.result.time.size > 0
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_other_headers_are_refused():
    """A header of another version is refused by its place."""
    with pytest.raises(Unknown, match="no object header of version 2 at 3"):
        header(b"abcOHDR\x01", 3)


@pytest.mark.parametrize("error", ["state", None])
def test_a_log_of_steps_that_is_in_a_file_stays_in_no_memory(tmp_path, monkeypatch, error):
    """Of a run that lasts, also where its samples are remembered for stated errors."""
    monkeypatch.setattr(short_file, "PATIENCE", 0.0)
    pieces, store = [], short_file.ShortFile.store

    def stored(sink):
        kinds = {kind for kind, *_ in sink.pieces} | ({"rows"} if sink.samples.count else set())
        pieces.append(kinds)
        store(sink)

    monkeypatch.setattr(short_file.ShortFile, "store", stored)
    scene = cl.load_case("slider_crank", model="lubricated", film="pinkus_sternlicht")
    with cl.simulate(scene, turns=2, path=tmp_path / "run.h5", error=error) as run:
        assert run.values("solver/step").size == run.solver["steps"]
    assert pieces == [{"rows"} if error else set()]
