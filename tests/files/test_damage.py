"""Damaged and foreign files: stated in one line, by file and place, and no wrong number is read.

The long form of the first tests is `python -m tests.benchmarks.damage`.
"""

import gzip
import json
import math
import os
import random
import re
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
from clearance.files.texts import signed_document
from clearance.identify.records import read
from clearance.results import reading
from clearance.results.reading import Damaged, crc_of
from clearance.results.result import EVENT_TEXTS
from clearance.results.tables import save_tables
from clearance.scene import document
from clearance.scene.catalogue import case_names
from clearance.sweeping import definition, journal
from tests.benchmarks import damage
from tests.seeds import few_of

OLD = Path(__file__).with_name("version_1.h5.gz")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return damage.sources(tmp_path_factory.mktemp("whole"), rest=False)


@pytest.fixture(scope="module")
def all_files(tmp_path_factory):
    return damage.sources(tmp_path_factory.mktemp("all"))


@pytest.fixture
def dry(files, tmp_path):
    return Path(shutil.copy(files["dry run"].source, tmp_path / "dry.h5"))


def faults(looks):
    """Lines of looks that are wrong."""
    return "\n".join(f"{x.outcome}: {x.text}\n{x.fault}" for x in looks if x.fault)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_R5_no_damaged_file_raises(all_files, tmp_path):
    """Three files of each kind, damaged in any way: a reader or a command does its work or states
    the reason in one line.
    """
    assert not faults(damage.attempts(7, 3, all_files, tmp_path))


@pytest.mark.slow
def test_R7_no_flipped_bit_changes_a_number(all_files, tmp_path):
    """Of each kind that has checksums 4 single bits anywhere: noticed, or all numbers are exactly
    those that were written.
    """
    flipped = {
        n: k._replace(ways=(damage.flip,), commands=(), ongoing="") for n, k in all_files.items()
    }
    assert not faults(damage.attempts(7, 4, flipped, tmp_path))


def flip_in(path, name, offset=5):
    """A bit among the values of a column."""
    with h5py.File(path) as file:
        begin = file[name].id.get_chunk_info(0).byte_offset
    content = bytearray(path.read_bytes())
    content[begin + offset] ^= 1
    path.write_bytes(content)


def test_R7_a_flipped_bit_is_reported_with_its_dataset(files, dry, tmp_path, typed):
    """A flipped bit is reported with file and dataset, by Python and by commands."""
    flip_in(dry, "joints/C/force_x")
    with (
        cl.open_result(dry) as run,
        pytest.raises(Damaged, match=r"dry\.h5: /joints/C/force_x cannot be read"),
    ):
        run.joint("C").force_x  # noqa: B018
    for words in ("plot history --channels C.force,slider.ax", "report"):
        command, _, more = words.partition(" ")
        assert f"{dry}: /joints/C/force_x cannot be read" in typed.line(command, dry, more)
    folder = shutil.copytree(files["sweep: a run"].source, tmp_path / "sweep")
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
        files["dry run"].source,
        files["lubricated run"].source,
        files["measurement"].source,
        files["sweep: sweep.h5"].source / "sweep.h5",
    ]
    columns = {"a": ("m", "a", np.arange(3.0)), "b": ("1", "b", np.array(["x", "", "µ"]))}
    paths.append(save_tables(tmp_path / "t.h5", "clearance-test", {}, {"t": ({}, columns)}))
    for path in paths:
        with h5py.File(path) as file:
            file.visititems(check)
    with h5py.File(paths[-1]) as file:
        assert file["t/b"].asstr()[()].tolist() == ["x", "", "µ"]


def test_R7_long_texts_have_checksums(dry, typed):
    """The scene holds the numbers of the mechanism; HDF5 keeps no checksum of a text of any
    length.
    """
    with h5py.File(dry, "a") as file:
        file.attrs["scene"] = file.attrs["scene"].replace('"clearance": ', '"clearance": 1')
    assert "attribute scene is not what was written: its checksum differs" in typed.line(
        "plot", dry
    )


@pytest.mark.parametrize(
    ("item", "name", "message"),
    [
        ("/", "warnings", "/ has no attribute 'warnings'"),
        ("/", "scene", "/ has no attribute 'scene'"),
        ("/", "format_version", "/ has no attribute 'format_version'"),
        ("solver", "wall_s", "/solver has no 'wall_s'"),
        ("joints/C/gap", "units", "/joints/C/gap has no attribute 'units'"),
        ("joints/C/gap", "actual_range", "/joints/C/gap has no attribute 'actual_range'"),
    ],
)
def test_R5_a_missing_attribute_is_named(dry, typed, item, name, message):
    """A missing attribute is named where it is read."""
    with h5py.File(dry, "a") as file:
        del file[item].attrs[name]
    if name in ("units", "actual_range"):
        with cl.open_result(dry) as run, pytest.raises(Damaged, match=message):
            run.units("joints/C/gap") if name == "units" else run.range("joints/C/gap")
    else:
        assert message in typed.line("report", dry)


def test_R5_a_scene_without_something(dry, typed):
    """A file of the first version has no checksum of its scene."""
    with h5py.File(dry, "a") as file:
        scene = json.loads(file.attrs["scene"])
        del scene["bodies"][1]["com"], file.attrs["scene_crc32"]
        file.attrs["scene"] = json.dumps(scene)
    assert typed.line("plot", dry, "sketch") == f"clearance: {dry}: attribute scene has no 'com'"


@pytest.mark.parametrize("command", ["run", "sweep -p speed=1,2", "lyapunov", "explain"])
def test_R5_a_result_file_is_no_case(dry, typed, command):
    """A result in place of a case is answered with the command for it."""
    assert "is a result, no case; clearance run " in typed.line(command, dry)


def test_R5_nothing_is_read_from_another_file(dry, tmp_path):
    """HDF5 can point to other files; a stranger's result does not show what is in them."""
    (tmp_path / "secret").write_bytes(np.arange(41.0).tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["x"] = np.arange(41.0)
    with h5py.File(dry, "a") as file:
        del file["joints/C/gap"], file["joints/C/force_x"]
        outside = [(str(tmp_path / "secret"), 0, 8 * 41)]
        file.create_dataset("joints/C/gap", (41,), "f8", external=outside)
        file["joints/C/force_x"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "x")
    with cl.open_result(dry) as run:
        for name in ("gap", "force_x"):
            with pytest.raises(Damaged, match=f"/joints/C/{name} points to another file"):
                run.values(f"joints/C/{name}")


def test_R5_no_link_is_followed(files, tmp_path):
    """Random columns and groups as links to a pipe without an end, a file, or within the file."""
    rng, pipe = random.Random(9), tmp_path / "pipe"
    os.mkfifo(pipe)
    for _ in range(30):
        path = Path(shutil.copy(files["dry run"].source, tmp_path / "dry.h5"))
        with h5py.File(path, "a") as file:
            name = rng.choice([n for n in damage._items(file)[1:] if "extremes" not in n])
            aims = [h5py.ExternalLink(str(aim), "/time") for aim in (pipe, files["dry run"].source)]
            del file[name]
            file[name] = rng.choice([*aims, h5py.SoftLink("/solver"), h5py.SoftLink("/nothing")])
        with cl.open_result(path) as run:
            for look in (run.reader.has, run.reader.item, run.reader.names, run.reader.column):
                with pytest.raises(Damaged, match=f"/{name} points to another file"):
                    look(name)


def test_R5_texts_without_an_end(files, tmp_path):
    """30 blocks of zeros and 30 bits among texts: HDF5 would read some of them for ever."""
    rng, path, content = (
        random.Random(10),
        tmp_path / "dry.h5",
        files["dry run"].source.read_bytes(),
    )
    heads, wrong = [m.start() for m in re.finditer(b"GCOL", content)], 0
    for i in range(60):
        changed = bytearray(content)
        offset = rng.choice(heads) + rng.randrange(16, 3000)
        if i % 2:
            changed[offset : offset + 64] = bytes(64)
        changed[offset] ^= 1 << rng.randrange(8)
        path.write_bytes(changed)
        try:
            with cl.open_result(path) as run:
                assert all(run.units(c) for c in damage._channels(run))
                assert run.attributes["case"] == "slider_crank"
        except ValueError as error:
            assert str(path) in str(error)  # noqa: PT017
            wrong += "have no end" in str(error)
    assert wrong > 5


def test_R5_a_closed_file_is_free(files, tmp_path):
    """Of 40 damaged files, whose errors are still there: none is open."""
    rng, path, errors = random.Random(11), tmp_path / "dry.h5", []

    def look(seen, *arguments):
        try:
            return seen(*arguments)
        except ValueError as error:
            errors.append(error)

    for _ in range(40):
        shutil.copy(files["dry run"].source, path)
        rng.choice(damage.OF_HDF5)(path, rng)
        if (run := look(cl.open_result, path)) is not None:
            channels = look(lambda run=run: list(damage._channels(run))) or []
            for channel in rng.sample(channels, min(len(channels), 12)):
                look(run.values, channel)
            run.close()
        assert str(path) not in [os.path.realpath(link) for link in Path("/proc/self/fd").iterdir()]
        assert str(path) not in Path("/proc/self/maps").read_text()
    assert len(errors) > 5


@pytest.mark.parametrize("value", ["a text", 3.5, np.zeros((3, 2)), np.zeros(1), b"abc"])
def test_R5_columns_of_contacts_of_another_kind(dry, value):
    """Each column of the contacts in turn: numbers in place of texts, and the other way round."""
    with cl.open_result(dry) as run:
        names = list(run.events)
    content = dry.read_bytes()
    for name in names:
        dry.write_bytes(content)
        with h5py.File(dry, "a") as file:
            rows = len(file[f"events/{name}"])
            del file[f"events/{name}"]
            file[f"events/{name}"] = [value] * rows if isinstance(value, bytes) else value
        with cl.open_result(dry) as run:
            if isinstance(value, bytes) and name in EVENT_TEXTS:
                assert run.events[name].tolist() == ["abc"] * rows
            else:
                with pytest.raises(Damaged, match=r"dry\.h5.*/events"):
                    run.events  # noqa: B018


@pytest.mark.usefixtures("undrawn")
def test_nothing_of_a_strangers_sweep_is_executed(files, tmp_path, typed):
    """As the guide states: the case and the metrics that sweep.json names are not imported."""
    folder = shutil.copytree(files["sweep: sweep.json"].source, tmp_path / "sweep")
    code = tmp_path / "code.py"
    code.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    document = signed_document((folder / "sweep.json").read_bytes(), "")
    document |= {"path": str(code), "own": [[f"{code}:metric", "0"]]}
    (folder / "sweep.json").write_text(json.dumps(document))
    assert cl.open_sweep(folder).done.all()
    typed("plot", folder, "curves --metrics slider_acceleration_max")
    typed("report", folder)
    assert not (tmp_path / "ran").exists()


# --- tables of sweeps and measurements
@pytest.mark.parametrize(
    "line",
    [
        {"index": 0, "key": "k", "status": "done", "wall": {}},
        {"index": -1, "key": "k", "status": "done"},
        {"index": 0, "key": "k", "status": "done", "metrics": {"a": "b"}},
        {"index": 0, "key": 3, "status": "done"},
        [1, 2],
    ],
)
def test_R10_a_journal_line_that_is_none_is_passed_over(tmp_path, line):
    """Broken lines of a journal do not hide good ones."""
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
    """A changed definition is refused with its fault."""
    document = signed_document((files["sweep: sweep.json"].source / "sweep.json").read_bytes(), "")
    change(document)
    (tmp_path / "sweep.json").write_text(json.dumps(document))
    with pytest.raises(
        ValueError, match=r"sweep\.json is not the definition of a sweep: "
    ) as caught:
        definition.read(tmp_path)
    assert str(caught.value).endswith(message)


def test_R5_comments_without_a_name_and_facts_that_no_file_keeps(files, tmp_path, typed):
    """Odd comments of a measurement are read or passed over."""
    text = files["measurement: CSV"].source.read_text()
    odd = (
        "#=\n# = x\n# .a = 1\n# a. = 1\n# many = [1,a]\n# large = 99999999999999999999\n# format "
        "= x\n# a.order = x\n"
    )
    (tmp_path / "a.csv").write_text(odd + text)
    facts = read(tmp_path / "a.csv").facts
    assert facts["many"] == "[1,a]"
    assert facts["large"] == 1e20
    assert "" not in facts
    typed("identify --data", tmp_path / "a.csv", "--model curve -o", tmp_path / "out")
    assert len(read(tmp_path / "out" / "modelled.h5").trials) == 2


@pytest.mark.parametrize("lines", [1, 400_000])
def test_R5_an_open_quote_is_named_by_its_line(files, tmp_path, lines):
    """Of few lines, and of more than the csv module takes for one cell."""
    head, *rows = [
        t for t in files["measurement: CSV"].source.read_text().splitlines() if t[0] != "#"
    ]
    rows = [rows[0], '"' + rows[1], *([rows[2]] * lines)]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows]))
    with pytest.raises(ValueError, match=r"a\.csv: line 3: a quote is not closed"):
        read(tmp_path / "a.csv")


def test_R10_folders_and_seeds(files, tmp_path, typed):
    """A file for a folder, and a seed too large, are refused."""
    (tmp_path / "file").touch()
    bench = files["measurement"].source
    for arguments in (
        ["film pressure"],
        ["lyapunov slider_crank"],
        ["identify --data", bench],
    ):
        assert typed.line(*arguments, "-o", tmp_path / "file").endswith(
            "file is a file; give the name of a folder"
        )
    huge = "100000000000000000000"
    assert (
        typed.line("bench-data ball_joint --seed", huge)
        == f"clearance: --seed must be a whole number from 0 to {2**63 - 1}, got {huge}"
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
        "bench-data ball_joint -o {}/b.h5",
        "bench-data ball_joint -o {}/b.csv",
        "plot {dry} history --channels slider.ax -o {}/p.png",
        "plot {dry} animation --frames 2 -o {}/p.gif",
        pytest.param("film pressure -o {}/film", marks=pytest.mark.slow),
    ],
)
def test_R8_a_full_disk_is_said_and_nothing_half_is_left(dry, tmp_path, typed, arguments):
    """Without room a command ends in one line and leaves no file."""
    with room(2000):
        line = typed.line(arguments.format(tmp_path, dry=dry), status=1)
    assert line.endswith(": File too large")
    assert line.startswith(f"clearance: {tmp_path}/")
    remains = [p for p in tmp_path.rglob("*") if p.is_file() and p.suffix != ".md"]
    assert remains == [dry]


def test_R10_a_folder_that_cannot_be_written_is_named(typed, monkeypatch, tmp_path):
    """A folder that refuses files is named."""

    def refused(path, data):
        raise OSError(30, "Read-only file system", str(path))

    monkeypatch.setattr(Path, "write_bytes", refused)
    line = typed.line("bench-data ball_joint -o", tmp_path / "b.h5")
    assert line == f"clearance: directory {tmp_path}: Read-only file system"


# --- what else reads the files
@pytest.mark.slow
def test_U5_the_file_opens_as_a_tree(files):
    """Contacts and steps have dimensions of their own; time stays their coordinate."""
    path = files["dry run"].source
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
    """Radius, clearance and viscosity stand beside the channels, with units."""
    with h5py.File(files["lubricated run"].source) as file:
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


def test_S6_a_column_that_unpacks_beyond_reason_is_not_read(dry, monkeypatch):
    """A column longer than /time is refused before it is read; so is what memory has no room
    for. 20 random sizes.
    """
    rng = np.random.default_rng(6)
    with h5py.File(dry, "a") as file:
        about = dict(file["joints/C/gap"].attrs)
        del file["joints/C/gap"]
        for i, size in enumerate(rng.integers(10**6, 10**9, 20)):
            data = file.create_dataset(
                f"joints/C/gap{i}", (size,), "f8", chunks=(2**17,), compression="gzip"
            )
            data.attrs.update({n: about[n] for n in ("units", "long_name")})
            data[: 10**6] = 0.0
    with cl.open_result(dry) as run:
        run._samples  # noqa: B018
        monkeypatch.setattr(
            h5py.Dataset, "__getitem__", lambda data, _: pytest.fail(f"{data.name} is read")
        )
        for i in range(20):
            with pytest.raises(Damaged, match=rf"/joints/C/gap{i} has \d+ values, /time has 41"):
                run.values(f"joints/C/gap{i}")


def test_S6_memory_that_is_not_free_is_not_taken(dry, monkeypatch):
    """A dataset larger than the free memory is refused."""
    with h5py.File(dry, "a") as file:
        file.create_dataset("extremes/odd", data=np.zeros(4 * 2**20), chunks=True, compression=9)
    monkeypatch.setattr(reading, "_free_memory", lambda: 3e7)
    with (
        cl.open_result(dry) as run,
        pytest.raises(Damaged, match="/extremes/odd has .* more than the 3e"),
    ):
        run.reader.column("extremes/odd")


@pytest.mark.parametrize("group", ["g", "C2", "é", "a b"])
def test_T6_a_group_that_no_joint_has(dry, tmp_path, group):
    """Pages show the joints of the scene."""
    with h5py.File(dry, "a") as file:
        file["joints"].create_group(group)
    with cl.open_result(dry) as run:
        assert list(run.clearances) == ["C"]
    assert main(["view", str(dry), "-o", str(tmp_path / "v.html")]) == 0


OTHERS = (math.nan, None, 3, "a", [], {}, [[1]], {"x": 1}, -1.5, True, {"type": "Weld"})


def misplaced(scene, rng):
    """Give a value of another kind to a random field, of any depth; its name."""
    owner = rng.choice([scene, *scene["bodies"], *scene["joints"], *scene["loads"]])
    name = rng.choice(sorted(owner))
    while isinstance(owner[name], dict) and owner[name] and rng.random() < 0.6:
        owner = owner[name]
        name = rng.choice(sorted(owner))
    owner[name] = rng.choice(OTHERS)
    return f"{name} = {owner[name]!r}"


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("of", ["dry run", "lubricated run"])
@pytest.mark.parametrize("seed", few_of(range(7, 12), 1))
def test_T7_a_scene_with_fields_of_another_kind(files, tmp_path, of, seed):
    """12 random fields of all parts, whose values are others: a page, or one line."""
    rng, path = random.Random(seed), Path(shutil.copy(files[of].source, tmp_path / "run.h5"))
    with cl.open_result(path) as run:
        text = run.attributes["scene"]
    for i in range(12):
        scene = json.loads(text)
        done = misplaced(scene, rng)
        with h5py.File(path, "a") as file:
            file.attrs["scene"] = json.dumps(scene)
            file.attrs["scene_crc32"] = crc_of(file.attrs["scene"])
        command = [["view", path], ["report", path], ["plot", path, "sketch"]][i % 3]
        wrong = damage.printed([*map(str, command), "-o", str(tmp_path / "out.html")])
        assert wrong is None, (done, command, wrong)


def test_T7_scenes_of_all_cases_are_checked():
    """Entire ones pass; 600 with a random field of another kind give a scene or one error."""
    rng, refused = random.Random(8), 0
    texts = [cl.load_case(name).to_json() for name in case_names()]
    for text in texts:
        document.check(json.loads(text))
    for i in range(600):
        scene = json.loads(texts[i % len(texts)])
        misplaced(scene, rng)
        try:
            cl.Scene.from_json(json.dumps(scene))
        except ValueError:
            refused += 1
    assert refused > 300
