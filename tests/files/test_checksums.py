"""Checksums of files: what is damaged is refused, at any bit of any kind of file."""

import io
import random
import re
import shutil
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.files.texts import signed
from clearance.results import short_file
from clearance.results.reading import Damaged, open_checked
from clearance.results.tables import in_memory
from clearance.sweeping import definition
from tests.benchmarks import damage
from tests.seeds import few_of
from tests.typed import python


def test_L1_a_file_made_in_memory_opens():
    """Of 20 files of random names and numbers, with all that was written."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        values = {f"c{j}": rng.normal(size=rng.integers(1, 99)) for j in range(rng.integers(1, 9))}
        content = io.BytesIO()
        with in_memory(content) as file:
            for name, column in values.items():
                file[name] = column
        with h5py.File(io.BytesIO(content.getvalue())) as file:
            for name, column in values.items():
                np.testing.assert_array_equal(file[name], column)


@pytest.fixture(scope="module")
def long_run(tmp_path_factory):
    """A file of 4801 rows, three pieces a column, written as the run goes."""
    path = tmp_path_factory.mktemp("long") / "run.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(short_file, "PATIENCE", 0.0)
        scene = cl.load_case("slider_crank", friction="coulomb")
        channels = ["bodies/*", "joints/C/gap", "energy/*"]
        cl.simulate(scene, path=path, turns=4, samples_per_turn=1200, channels=channels).close()
    return path


def nodes(content, entries=3):
    """Used parts of the indexes of columns: first and last byte of each."""
    begin = -1
    while (begin := content.find(b"TREE\x01", begin + 1)) >= 0:
        yield begin, begin + 24 + 32 * entries + 24


def without_checks(path):
    """A file as version 0.2 wrote it: columns have no checksum."""
    with h5py.File(path, "a") as file:
        for item in columns_of(file):
            item.attrs.pop("crc32")


def columns_of(file):
    """Columns that have a checksum."""
    items = []
    file.visititems(lambda _, item: items.append(item))
    return [item for item in items if isinstance(item, h5py.Dataset) and "crc32" in item.attrs]


def wrong_numbers(path, entire):
    """Columns that are read and are not what was written; a line names file and column."""
    wrong = []
    with cl.open_result(path) as run:
        for name, values in entire.items():
            try:
                there = run.reader.column(name)
            except Damaged as error:
                there = values if str(error).startswith(f"{path}: /{name} ") else str(error)
            if not np.array_equal(there, values):
                wrong.append(name)
    return wrong


def readings(content, bits, path):
    """Place and bit of those whose flip shows numbers that were not written."""
    path.write_bytes(content)
    with cl.open_result(path) as run:
        entire = {c: run.reader.column(c) for c in damage._channels(run)}
    for offset, bit in bits:
        changed = bytearray(content)
        changed[offset] ^= 1 << bit
        path.write_bytes(changed)
        if wrong := wrong_numbers(path, entire):
            yield offset, bit, wrong


@pytest.mark.parametrize("seed", few_of(range(5), 1))
def test_L0_no_bit_of_an_index_turns_into_numbers(long_run, tmp_path, seed):
    """40 random bits of the indexes of columns, and a fifth of the numbers of their entries."""
    content, rng = long_run.read_bytes(), random.Random(seed)
    parts = list(nodes(content))
    bits = [(begin + 6, bit) for begin, _ in parts[seed::5] for bit in (0, 1)]
    bits += [(rng.randrange(*rng.choice(parts)), rng.randrange(8)) for _ in range(40)]
    assert list(readings(content, bits, tmp_path / "run.h5")) == []


@pytest.mark.slow
def test_L0_an_older_file_lacks_no_pieces(long_run, tmp_path):
    """All numbers of entries and all first places of pieces; a column has no checksum here."""
    path = Path(shutil.copy(long_run, tmp_path / "run.h5"))
    without_checks(path)
    content, rng = path.read_bytes(), random.Random(4)
    begins = [begin for begin, _ in nodes(content)]
    bits = [(begin + 6, bit) for begin in begins for bit in (0, 1)]
    # keys of a node: size, filters left out, then the place of the piece
    bits += [(rng.choice(begins) + 24 + 32 * rng.randrange(3) + 8, b) for b in range(8)]
    assert list(readings(content, bits, path)) == []


READING = """
import sys
import clearance as cl

def content(path, names):
    columns = {}
    with cl.open_result(path) as run:
        for name in names:
            try:
                columns[name] = run.reader.column(name).tobytes()
            except ValueError as error:
                assert str(error).startswith(f"{path}: /{name} "), error
    return columns

with cl.open_result(sys.argv[1]) as run:
    names = run.reader.columns()
entire = content(sys.argv[1], names)
for path in sys.argv[2:]:
    assert content(path, names).items() <= entire.items(), path
"""


@pytest.mark.parametrize("older", few_of([False, True], 1))
def test_L0_no_damage_of_an_index_ends_the_process(long_run, tmp_path, older):
    """20 copies in which each index has a bit, four, eight or 64 bytes changed, at random."""
    path, rng = Path(shutil.copy(long_run, tmp_path / "run.h5")), random.Random(older)
    if older:
        without_checks(path)
    content = path.read_bytes()
    for i in range(20):
        changed = bytearray(content)
        for begin, end in nodes(content):
            offset = rng.randrange(begin, end)
            other = [bytes([content[offset] ^ 1 << rng.randrange(8)]), bytes(4), bytes(64)]
            other = rng.choice([*other, rng.randbytes(8)])
            changed[offset : offset + len(other)] = other
        (tmp_path / f"{i}.h5").write_bytes(changed)
    copies = [path, *(tmp_path / f"{i}.h5" for i in range(20))]
    python("-W", "ignore", "-c", READING, *copies)


#: for other readers only
ASIDE = {"coordinates", "_Encoding", "DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"}


def everything(path, form):
    """Names of all columns and attributes of a file, GROUP@NAME."""
    with open_checked(path, "file", form, 99) as reader:
        names: list = []
        reader.file.visit(names.append)
        columns = [c for c in reader.columns() if not c.endswith(("/event", "/step_number"))]
        groups = [n for n in names if isinstance(reader.item(n), h5py.Group)]
        about = {path: reader.attributes(path) for path in ("", *columns, *groups)}
        return [*columns, *(f"{p}@{n}" for p, some in about.items() for n in some.keys() - ASIDE)]


def read(path, form, names):
    """Columns and attributes as readers of the package have them; those refused are left out."""
    with open_checked(path, "file", form, 99) as reader:
        content = {}
        for name in names:
            group, _, attribute = name.partition("@")
            with suppress(Damaged):
                if attribute:
                    content[name] = str(reader.attribute(group, attribute))
                else:
                    content[name] = reader.column(name).tobytes()
        return content


def opens(path, form):
    """A reader takes a file."""
    try:
        open_checked(path, "file", form, 99).close()
    except (ValueError, OSError):
        return False
    return True


#: kinds of files of which there is another one
ALIKE = ("no case", "life: run of a stage", "checkpoint: a stretch")


@pytest.fixture(scope="module")
def kinds(tmp_path_factory, long_run):
    """A file of each kind."""
    files = damage.sources(tmp_path_factory.mktemp("kinds"))
    files_of = {n: k.source / k.inside if k.inside else k.source for n, k in files.items()}
    files_of = {n: p for n, p in files_of.items() if p.suffix == ".h5" and n not in ALIKE}
    return files_of | {"long run": long_run}


@pytest.fixture(scope="module")
def dry(tmp_path_factory):
    """A file of a run."""
    return damage.sources(tmp_path_factory.mktemp("dry"), rest=False)["dry run"].source


def heaps(content):
    """Texts of a file: first and last byte of each heap."""
    begin = -1
    while (begin := content.find(b"GCOL\x01", begin + 1)) >= 0:
        yield begin + 16, begin + int.from_bytes(content[begin + 8 : begin + 16], "little")


@pytest.mark.slow
@pytest.mark.parametrize("seed", few_of(range(5, 9), 1))
def test_L7_no_flipped_bit_of_any_file_is_read(kinds, tmp_path, seed):
    """Of each kind of file 8 bits anywhere, and 16 of its texts: refused, or all is as before.

    Twelve in one copy, without those that keep it closed: its parts are read one by one.
    """
    rng, path = random.Random(seed), tmp_path / "run.h5"
    for kind, source in kinds.items():
        with h5py.File(source) as file:
            form = file.attrs["format"]
        content, names = source.read_bytes(), everything(source, form)
        entire = read(source, form, names)
        assert len(entire) == len(names) > 10, kind
        texts = [range(*ends) for ends in heaps(content)]
        places = [rng.randrange(len(content)) for _ in range(8)]
        places += [rng.choice(rng.choice(texts)) for _ in range(16)]
        rng.shuffle(places)
        for i in range(0, len(places), 12):
            changed = bytearray(content)
            for offset in places[i : i + 12]:
                before, changed[offset] = changed[offset], changed[offset] ^ 1 << rng.randrange(8)
                path.write_bytes(changed)
                changed[offset] = changed[offset] if opens(path, form) else before
            path.write_bytes(changed)
            assert read(path, form, names).items() <= entire.items(), (kind, places[i : i + 12])


def test_L6_no_command_makes_a_run_from_a_damaged_scene(dry, tmp_path, typed, monkeypatch):
    """30 bits of scene and options: --again, new and cl.again refuse, and nothing is written."""
    content, rng = dry.read_bytes(), random.Random(6)
    monkeypatch.chdir(tmp_path)
    with cl.open_result(dry) as run:
        texts = [run.attributes[n].encode() for n in ("scene", "options", "parameters")]
    path = tmp_path / "run.h5"
    for text in rng.choices(texts, k=30):
        changed = bytearray(content)
        changed[content.index(text) + rng.randrange(len(text))] ^= 1 << rng.randrange(7)
        path.write_bytes(changed)
        commands = [["run", "--again", "run.h5", "-o", "other.h5"]]
        commands += [["new", "run.h5", "-o", "s.toml"]] if text == texts[0] else []
        for command in commands:
            assert "its checksum differs" in typed.line(*command)
        with pytest.raises(Damaged):
            cl.again(path)
        assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_L6_a_damaged_column_is_named_by_again(dry, tmp_path, typed):
    """Of the file that is made again; no traceback."""
    path = Path(shutil.copy(dry, tmp_path / "run.h5"))
    damage_column(path, "bodies/slider/ax", random.Random(7))
    assert f"{path}: /bodies/slider/ax cannot be read" in typed.line(
        "run --again", path, "-o", tmp_path / "other.h5"
    )


def damage_column(path, name, rng):
    """A bit of a column's values."""
    with h5py.File(path) as file:
        piece = file[name].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[piece.byte_offset + rng.randrange(piece.size)] ^= 1 << rng.randrange(8)
    path.write_bytes(content)


def texts_flipped(path, rng, count):
    """Copies of the content of a file with one bit changed."""
    content = path.read_bytes()
    for _ in range(count):
        changed = bytearray(content)
        changed[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        path.write_bytes(changed)
        yield
    path.write_bytes(content)


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory):
    """Sweeps without run files: points one by one, and points that ran together in a block."""
    folder = tmp_path_factory.mktemp("sweeps")
    options = {"channels": (), "turns": 1.0, "workers": 1}
    cl.sweep("slider_crank", cl.grid(speed=[20.0, 30.0]), folder / "few", **options)
    cl.sweep("slider_crank", cl.grid(speed=np.linspace(20, 30, 64)), folder / "many", **options)
    return folder


@pytest.mark.parametrize("name", ["few", "many"])
def test_L8_no_bit_of_a_journal_is_another_number(sweeps, tmp_path, name, caplog):
    """100 random bits each: points are missing, and the line is named, or all is as before."""
    folder, rng = Path(shutil.copytree(sweeps / name, tmp_path / name)), random.Random(8)
    (folder / "sweep.h5").unlink()
    entire = cl.open_sweep(folder)
    for _ in texts_flipped(folder / "journal.jsonl", rng, 100):
        caplog.clear()
        there = cl.open_sweep(folder)
        assert there.known.items() <= entire.known.items()
        for metric, values in there.metrics.items():
            assert np.array_equal(values[there.done], entire.metrics[metric][there.done])
        if not there.done.all():
            last = (folder / "journal.jsonl").read_bytes()[-1:] != b"\n"
            assert last or "journal.jsonl: line" in caplog.text


def test_L8_no_bit_of_a_definition_asks_for_something_else(sweeps, tmp_path):
    """100 random bits of sweep.json: refused by name, or as before."""
    folder, rng = Path(shutil.copytree(sweeps / "few", tmp_path / "few")), random.Random(9)
    entire = definition.read(folder)
    for _ in texts_flipped(folder / "sweep.json", rng, 100):
        try:
            assert definition.read(folder) == entire
        except ValueError as error:
            assert "sweep.json is not the definition of a sweep" in str(error)  # noqa: PT017


def test_L8_no_bit_of_a_life_is_another_life(tmp_path):
    """100 random bits of life.json and of its journal: refused by name, or as before."""
    rng = random.Random(10)
    shared = {"average": 2, "error": 0.1, "jump": 3.5, "metrics": {"a": rng.random()}}
    stages = [
        {"stage": i, "turns": rng.random(), "scatter": {"C": rng.random()}} | shared
        for i in range(9)
    ]
    size = {"radius": rng.random(), "length": 0.01, "clearance": 1e-4, "wears": ["bearing"]}
    asked = {"turns": rng.random(), "joints": {"C": size}, "scene": {"name": "a", "joints": []}}
    (tmp_path / "life.json").write_text(signed(asked))
    (tmp_path / "journal.jsonl").write_text("".join(f"{signed(one)}\n" for one in stages))
    for name in ("life.json", "journal.jsonl"):
        for _ in texts_flipped(tmp_path / name, rng, 100):
            try:
                life = cl.Life(tmp_path)
            except ValueError as error:
                assert str(tmp_path / name) in str(error)  # noqa: PT017
                continue
            assert asked.items() <= life.asked.items()
            assert all(
                one.items() <= there.items()
                for one, there in zip(stages, life.stages, strict=False)
            )


def unsealed(path):
    """A text as version 0.2 wrote it: without checksums."""
    path.write_text(re.sub(r',\s*"crc32": \d+', "", path.read_text()))


def test_L8_journals_without_checksums_are_read(sweeps, tmp_path):
    """Sweeps of older versions, without checksums, are read as before."""
    for name in ("few", "many"):
        folder = Path(shutil.copytree(sweeps / name, tmp_path / name))
        entire = cl.open_sweep(folder)
        (folder / "sweep.h5").unlink()
        for text in ("sweep.json", "journal.jsonl"):
            unsealed(folder / text)
            assert "crc32" not in (folder / text).read_text()
        there = cl.open_sweep(folder)
        assert there.done.all()
        for metric, values in entire.metrics.items():
            np.testing.assert_array_equal(there.metrics[metric], values)


@pytest.mark.parametrize("name", ["few", "many"])
def test_L8_a_damaged_index_of_version_0_2_is_read_past_or_named(sweeps, tmp_path, name):
    """A directory without checksums whose index is damaged in 20 ways: its numbers, or an error
    that names the index.
    """
    folder, rng = Path(shutil.copytree(sweeps / name, tmp_path / name)), random.Random(11)
    entire = damage.of_sweep(folder)
    for text in ("sweep.json", "journal.jsonl"):
        unsealed(folder / text)
    with h5py.File(folder / "sweep.h5", "a") as file:
        items = [file]
        file.visititems(lambda _, item: items.append(item))
        for item in items:
            for check in [n for n in item.attrs if n.endswith("crc32")]:
                del item.attrs[check]
        file.attrs["definition"] = definition.digest(folder / "sweep.json")
        file.attrs["journal_bytes"] = (folder / "journal.jsonl").stat().st_size
    content = (folder / "sweep.h5").read_bytes()
    (folder / "journal.jsonl").rename(folder / "aside")
    assert damage.of_sweep(folder) == pytest.approx(entire, nan_ok=True)  # the index alone
    (folder / "aside").rename(folder / "journal.jsonl")
    for _ in range(20):
        (folder / "sweep.h5").write_bytes(content)
        rng.choice(damage.OF_HDF5)(folder / "sweep.h5", rng)
        try:
            there = damage.of_sweep(folder)
        except ValueError as error:
            assert "sweep.h5" in str(error)  # noqa: PT017
        else:
            assert there.keys() <= entire.keys()
