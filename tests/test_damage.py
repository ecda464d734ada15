"""Damaged and foreign files: stated in one line, by file and place, and no wrong number is read.

The long form of the first tests is `python -m tests.benchmarks.damage`.
"""

import gzip
import json
import resource
import shutil
import sys
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

import clearance as cl
from clearance.cli import main
from clearance.identify.records import read
from clearance.reading import Damaged
from clearance.results import save_tables
from clearance.sweeping import definition, journal
from tests.benchmarks import damage

OLD = Path(__file__).parent / "files" / "version_1.h5.gz"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return damage.sources(tmp_path_factory.mktemp("whole"))


@pytest.fixture
def dry(files, tmp_path):
    return Path(shutil.copy(files["dry run"][0], tmp_path / "dry.h5"))


def text_one(capsys, *arguments, status=2):
    """The line that a command ends with."""
    assert main([str(a) for a in arguments]) == status
    (line,) = capsys.readouterr().err.splitlines()
    return line


@pytest.mark.usefixtures("undrawn")
def test_R5_no_damaged_file_raises(files, tmp_path):
    """Bits, lengths, attributes, datasets, lines: each command does its work or ends with status 1
    or 2 and a line.
    """
    failed = [
        f"{label}\n{wrong}" for label, wrong in damage.attempts(7, 54, files, tmp_path) if wrong
    ]
    assert not failed, "\n".join(failed)


def test_R7_no_flipped_bit_changes_a_number(files, tmp_path):
    """60 single bits anywhere in a result file: noticed, or all numbers are exactly those that were
    written.
    """
    failed = [
        f"{label}: {wrong}"
        for label, wrong in damage.flips(7, 60, files["dry run"][0], tmp_path)
        if wrong
    ]
    assert not failed, "\n".join(failed)


def flip_in(path, name, place=5):
    """A bit among the values of a column."""
    with h5py.File(path) as file:
        begin = file[name].id.get_chunk_info(0).byte_offset
    content = bytearray(path.read_bytes())
    content[begin + place] ^= 1
    path.write_bytes(content)


def test_R7_a_flipped_bit_is_reported_with_its_dataset(files, dry, tmp_path, capsys):
    flip_in(dry, "joints/C/force_x")
    with (
        cl.open_result(dry) as run,
        pytest.raises(Damaged, match=r"dry\.h5: /joints/C/force_x cannot be read"),
    ):
        run.joint("C").force_x  # noqa: B018
    for arguments in (["plot", dry, "history", "--channels", "C.force,slider.ax"], ["report", dry]):
        assert f"{dry}: /joints/C/force_x cannot be read" in text_one(capsys, *arguments)
    folder = shutil.copytree(files["run of a sweep"][0], tmp_path / "sweep")
    sweep = cl.open_sweep(folder)
    flip_in(sweep.path(2), "joints/C/gap")
    with sweep.run(2) as run, pytest.raises(Damaged, match="/joints/C/gap cannot be read"):
        run.values("joints/C/gap")


def test_R7_every_column_has_a_checksum(files, tmp_path):
    """In result files, indices of sweeps, measurements and tables of studies; of texts too."""

    def check(name, item):
        if isinstance(item, h5py.Dataset) and item.size:
            assert item.fletcher32, name

    paths = [
        files["dry run"][0],
        files["lubricated run"][0],
        files["measurement"][0],
        files["sweep.h5"][0] / "sweep.h5",
    ]
    columns = {"a": ("m", "a", np.arange(3.0)), "b": ("1", "b", np.array(["x", "", "µ"]))}
    paths.append(save_tables(tmp_path / "t.h5", "clearance-test", {}, {"t": ({}, columns)}))
    for path in paths:
        with h5py.File(path) as file:
            file.visititems(check)
    with h5py.File(paths[-1]) as file:
        assert file["t/b"].asstr()[()].tolist() == ["x", "", "µ"]


def test_R7_long_texts_have_checksums(dry, capsys):
    """The scene holds the numbers of the mechanism; HDF5 keeps no checksum of a text of any
    length.
    """
    with h5py.File(dry, "a") as file:
        file.attrs["scene"] = file.attrs["scene"].replace('"clearance": ', '"clearance": 1')
    assert "attribute scene is not what was written: its checksum differs" in text_one(
        capsys, "plot", dry
    )


@pytest.mark.parametrize(
    ("place", "name", "message"),
    [
        ("/", "warnings", "/ has no attribute 'warnings'"),
        ("/", "scene", "/ has no attribute 'scene'"),
        ("/", "format_version", "/ has no attribute 'format_version'"),
        ("solver", "wall_s", "/solver has no 'wall_s'"),
        ("joints/C/gap", "units", "/joints/C/gap has no attribute 'units'"),
        ("joints/C/gap", "actual_range", "/joints/C/gap has no attribute 'actual_range'"),
    ],
)
def test_R5_a_missing_attribute_is_named(dry, capsys, place, name, message):
    with h5py.File(dry, "a") as file:
        del file[place].attrs[name]
    if name in ("units", "actual_range"):
        with cl.open_result(dry) as run, pytest.raises(Damaged, match=message):
            run.units("joints/C/gap") if name == "units" else run.range("joints/C/gap")
    else:
        assert message in text_one(capsys, "report", dry)


def test_R5_a_scene_without_something(dry, capsys):
    """A file of the first version has no checksum of its scene."""
    with h5py.File(dry, "a") as file:
        scene = json.loads(file.attrs["scene"])
        del scene["bodies"][1]["com"], file.attrs["scene_crc32"]
        file.attrs["scene"] = json.dumps(scene)
    assert (
        text_one(capsys, "plot", dry, "sketch") == f"clearance: {dry}: attribute scene has no 'com'"
    )


@pytest.mark.parametrize(
    "command", [["run"], ["sweep", "-p", "speed=1,2"], ["lyapunov"], ["explain"]]
)
def test_R5_a_result_file_is_no_case(dry, capsys, command):
    assert "is a result, no case; clearance run " in text_one(capsys, command[0], dry, *command[1:])


def test_R5_nothing_is_read_from_another_file(dry, tmp_path):
    """HDF5 can point to other files; a stranger's result does not show what is in them."""
    (tmp_path / "secret").write_bytes(np.arange(41.0).tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["x"] = np.arange(41.0)
    with h5py.File(dry, "a") as file:
        del file["joints/C/gap"], file["joints/C/force_x"]
        place = [(str(tmp_path / "secret"), 0, 8 * 41)]
        file.create_dataset("joints/C/gap", (41,), "f8", external=place)
        file["joints/C/force_x"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "x")
    with cl.open_result(dry) as run:
        for name in ("gap", "force_x"):
            with pytest.raises(Damaged, match=f"/joints/C/{name} points to another file"):
                run.values(f"joints/C/{name}")


@pytest.mark.usefixtures("undrawn")
def test_nothing_of_a_strangers_sweep_is_executed(files, tmp_path, capsys):
    """As the guide states: the case and the metrics that sweep.json names are not imported."""
    folder = shutil.copytree(files["sweep.json"][0], tmp_path / "sweep")
    code = tmp_path / "code.py"
    code.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    document = json.loads((folder / "sweep.json").read_text())
    document |= {"path": str(code), "own": [[f"{code}:metric", "0"]]}
    (folder / "sweep.json").write_text(json.dumps(document))
    assert cl.open_sweep(folder).done.all()
    assert main(["plot", str(folder), "curves", "--metrics", "slider_acceleration_max"]) == 0
    assert main(["report", str(folder)]) == 0
    assert not (tmp_path / "ran").exists()


# --- tables of sweeps and measurements
@pytest.mark.parametrize(
    ("line", "text"),
    [
        ({"index": 0, "key": "k", "status": "done", "wall": {}}, "wall"),
        ({"index": -1, "key": "k", "status": "done"}, "index"),
        ({"index": 0, "key": "k", "status": "done", "metrics": {"a": "b"}}, "metrics"),
        ({"index": 0, "key": 3, "status": "done"}, "key"),
        ([1, 2], "list"),
    ],
)
def test_R10_a_journal_line_that_is_none_is_passed_over(tmp_path, line, text):
    good = {"index": 1, "key": "k", "status": "done", "wall": 1, "metrics": {"a": 2}}
    path = tmp_path / "journal.jsonl"
    path.write_text(f"{json.dumps(line)}\n{json.dumps(good)}\n")
    (outcome,) = journal.read(path)
    assert (outcome.index, outcome.wall, outcome.metrics) == (1, 1.0, {"a": 2.0})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("points"), "it has no points"),
        (lambda d: d.update(fixed=3), "fixed cannot be 3"),
        (
            lambda d: d["points"].update(axes=[["speed", 2]]),
            "axes must be pairs of names and a number",
        ),
        (
            lambda d: d["points"].update(axes=[[["speed"]]]),
            "axes must be pairs of names and a number",
        ),
        (lambda d: d.update(own=[["a"]]), "own must be pairs of texts"),
        (lambda d: d.update(format="other"), "its format is 'other'"),
    ],
)
def test_R10_what_is_wrong_with_a_sweep_is_said_in_words(files, tmp_path, change, message):
    document = json.loads((files["sweep.json"][0] / "sweep.json").read_text())
    change(document)
    (tmp_path / "sweep.json").write_text(json.dumps(document))
    with pytest.raises(
        ValueError, match=r"sweep\.json is not the definition of a sweep: "
    ) as caught:
        definition.read(tmp_path)
    assert str(caught.value).endswith(message)


def test_R5_comments_without_a_name_and_facts_that_no_file_keeps(files, tmp_path, capsys):
    text = files["CSV"][0].read_text()
    odd = (
        "#=\n# = x\n# .a = 1\n# a. = 1\n# many = [1,a]\n# large = 99999999999999999999\n# format "
        "= x\n# a.order = x\n"
    )
    (tmp_path / "a.csv").write_text(odd + text)
    facts = read(tmp_path / "a.csv").facts
    assert facts["many"] == "[1,a]"
    assert facts["large"] == 1e20
    assert "" not in facts
    assert (
        main(
            [
                "identify",
                "--data",
                str(tmp_path / "a.csv"),
                "--model",
                "curve",
                "-o",
                str(tmp_path / "out"),
            ]
        )
        == 0
    )
    assert len(read(tmp_path / "out" / "modelled.h5").trials) == 2


@pytest.mark.parametrize("lines", [1, 400_000])
def test_R5_an_open_quote_is_named_by_its_line(files, tmp_path, lines):
    """Of few lines, and of more than the csv module takes for one cell."""
    head, *rows = [t for t in files["CSV"][0].read_text().splitlines() if t[0] != "#"]
    rows = [rows[0], '"' + rows[1], *([rows[2]] * lines)]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows]))
    with pytest.raises(ValueError, match=r"a\.csv: line 3: a quote is not closed"):
        read(tmp_path / "a.csv")


def test_R10_folders_and_seeds(files, tmp_path, capsys):
    (tmp_path / "file").touch()
    bench = files["measurement"][0]
    for arguments in (
        ["film", "pressure"],
        ["lyapunov", "slider_crank"],
        ["identify", "--data", bench],
    ):
        assert text_one(capsys, *arguments, "-o", tmp_path / "file").endswith(
            "file is a file; give the name of a folder"
        )
    huge = "100000000000000000000"
    assert (
        text_one(capsys, "bench-data", "ball_joint", "--seed", huge)
        == f"clearance: --seed must be less than 2^63, got {huge}"
    )


# --- a full disk, and a folder nobody can write to
@contextmanager
def room(size):
    """No file can become larger; Python writes no byte code, which would be cut."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "dont_write_bytecode", True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize(
    "arguments",
    [
        ["bench-data", "ball_joint", "-o", "{}/b.h5"],
        ["bench-data", "ball_joint", "-o", "{}/b.csv"],
        ["plot", "{dry}", "history", "--channels", "slider.ax", "-o", "{}/p.png"],
        ["plot", "{dry}", "animation", "--frames", "2", "-o", "{}/p.gif"],
        ["film", "pressure", "-o", "{}/film"],
    ],
    ids=" ".join,
)
def test_R8_a_full_disk_is_said_and_nothing_half_is_left(dry, tmp_path, capsys, arguments):
    arguments = [a.format(tmp_path, dry=dry) for a in arguments]
    with room(2000):
        line = text_one(capsys, *arguments, status=1)
    assert line.endswith(": File too large")
    assert line.startswith(f"clearance: {tmp_path}/")
    left = [p for p in tmp_path.rglob("*") if p.is_file() and p.suffix != ".md"]
    assert left == [dry]


def test_R10_a_folder_that_cannot_be_written_is_named(capsys, monkeypatch, tmp_path):
    def refused(path, data):
        raise OSError(30, "Read-only file system", str(path))

    monkeypatch.setattr(Path, "write_bytes", refused)
    line = text_one(capsys, "bench-data", "ball_joint", "-o", tmp_path / "b.h5")
    assert line == f"clearance: directory {tmp_path}: Read-only file system"


# --- what else reads the files
def test_U5_the_file_opens_as_a_tree(files):
    """Contacts and steps have dimensions of their own; time stays their coordinate."""
    path = files["dry run"][0]
    with xarray.open_datatree(path, engine="h5netcdf") as tree, cl.open_result(path) as run:
        assert dict(tree["events"].ds.sizes) == {"event": len(run.events["time"])}
        assert dict(tree["solver"].ds.sizes)["step_number"] == run.solver["steps"]
        assert tree["events/time"].dims == ("event",)
        assert "time" in tree["events"].ds.coords
        assert set(tree["events/joint"].values) == {"C"}
        np.testing.assert_array_equal(tree["joints/C/gap"], run.joint("C").gap)
        assert tree["joints/C"].attrs["clearance"] == run.clearances["C"]
        assert tree["joints/C"].attrs["clearance_units"] == "m"
        ours = run.to_xarray()
        assert ours["events"].ds.equals(tree["events"].ds.drop_vars([]))
        for group in ("bodies/slider", "joints/C", "drives/crank", "energy", "solver"):
            assert ours[group].ds.equals(tree[group].ds), group


def test_A6_numbers_of_a_joint_stand_in_its_group(files):
    with h5py.File(files["lubricated run"][0]) as file:
        about = dict(file["joints/C"].attrs)
        scene = next(j for j in json.loads(file.attrs["scene"])["joints"] if j["name"] == "C")
        ratio = (
            np.hypot(file["joints/C/eccentricity_x"], file["joints/C/eccentricity_y"])
            / about["clearance"]
        )
        # both come of the same sum of squares; away from the centre, where it is given a floor,
        # they agree to rounding
        np.testing.assert_allclose(file["joints/C/eccentricity_ratio"][1:], ratio[1:], rtol=1e-13)
    for name in ("radius", "clearance", "length"):
        assert (about[name], about[f"{name}_units"]) == (scene[name], "m")
    assert (about["viscosity"], about["viscosity_units"]) == (
        scene["lubricant"]["viscosity"],
        "Pa s",
    )
    assert (about["type"], about["film"], about["peak_force_units"]) == (
        "ClearanceRevolute",
        "harmonic",
        "N",
    )


@pytest.mark.usefixtures("undrawn")
def test_a_file_of_the_first_version_still_opens(tmp_path):
    """Written by version 0.1.0 at commit ae0889d: 21 samples of the dry slider-crank, chosen
    channels.
    """
    path = tmp_path / "old.h5"
    path.write_bytes(gzip.decompress(OLD.read_bytes()))
    with cl.open_result(path) as run:
        assert run.attributes["format_version"] == 1
        assert run.time.size == 21
        assert len(run.events["time"]) == 12
        assert set(run.events["joint"]) == {"C"}
        assert run.names("joints/C")[0] == "contact_force"
        assert run.extremes("joints/C/gap")[0] <= run.joint("C").gap.min()
        assert run.to_xarray()["events"].ds.sizes["event"] == 12
    for arguments in (["history", "--channels", "C.force"], ["orbit"], ["contacts"]):
        assert main(["plot", str(path), *arguments, "-o", str(tmp_path / "p.png")]) == 0
    assert main(["report", str(path)]) == 0
