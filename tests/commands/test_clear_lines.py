"""Bad input and bad moments end in one clear line and an exit status, never in a traceback."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import clearance as cl
from clearance.cli import main
from clearance.files import texts
from clearance.motions import branch_file
from tests.seeds import few_of
from tests.wearing.test_going_on import followed, pendulum
from tests.wearing.test_life import rotor

COMMAND = str(Path(sys.executable).with_name("clearance"))


@pytest.fixture(scope="module")
def life(tmp_path_factory):
    folder = tmp_path_factory.mktemp("life") / "worn"
    cl.wear(rotor(), turns=20.0, jump_turns=10.0, settle=0, average=1, directory=folder)
    return folder


def reading(folder):
    """All numbers of a life, also those that a life goes on from."""
    one = cl.Life(folder)
    return [*one.turns, *one.error, *one.depth("B").ravel(), *one.rate("B").ravel(), one.stages]


@pytest.mark.parametrize("seed", few_of(range(30), 6))
@pytest.mark.parametrize("name", ["life.json", "journal.jsonl", "stage-0001.npz"])
def test_T1_a_damaged_life_is_named(life, name, seed, tmp_path):
    """Cut short, a stretch of zeros, or one bit anywhere: the file is named, or nothing changed."""
    rng, copy = random.Random(f"{seed} {name}"), tmp_path / "worn"
    shutil.copytree(life, copy)
    entire, content = reading(life), bytearray((copy / name).read_bytes())
    offset = rng.randrange(len(content))
    if (way := seed % 3) == 0:
        content[offset] ^= 1 << rng.randrange(8)
    elif way == 1:
        del content[offset:]
    else:
        content[offset : offset + 64] = bytes(len(content[offset : offset + 64]))
    (copy / name).write_bytes(content)
    try:
        read = reading(copy)
    except ValueError as error:
        assert name in str(error)  # noqa: PT017
    else:
        stages = read[-1]
        if name != "journal.jsonl" or len(stages) == len(entire[-1]):  # else a line was cut short
            assert read == entire
        assert stages == entire[-1][: len(stages)]


def test_T1_a_damaged_stage_is_one_line(life, tmp_path, typed):
    """Whatever reads it: pictures, and a life that goes on."""
    copy = tmp_path / "worn"
    shutil.copytree(life, copy)
    (copy / "stage-0002.npz").write_bytes(b"PK\x03\x04" + bytes(100))
    words = "stage-0002.npz cannot be read, the file is damaged"
    assert words in typed.line("plot", copy, "-o", tmp_path / "p.png")
    with pytest.raises(ValueError, match=words):
        cl.wear(rotor(), turns=40.0, jump_turns=10.0, settle=0, average=1, directory=copy)


@pytest.mark.parametrize("value", [[], 3, "a text", None, {"joint_B_force_max": []}, [[1]]])
@pytest.mark.parametrize("name", ["metrics", "scatter", "turns", "known", "stage"])
def test_T2_entries_of_another_kind_in_a_life(life, name, value, tmp_path, typed):
    """A stranger's line, with a checksum that fits."""
    copy = tmp_path / "worn"
    shutil.copytree(life, copy)
    path = copy / "journal.jsonl"
    lines = path.read_text().splitlines()
    document = texts.signed_document(lines[0], path) | {name: value}
    if (name, value) in (("turns", 3), ("known", None)):  # may be
        return
    path.write_text("\n".join([texts.signed(document), *lines[1:], ""]))
    assert "journal.jsonl:1" in typed.line("plot", copy, "-o", tmp_path / "p.png")


def test_T2b_a_branch_without_a_column(tmp_path, monkeypatch):
    """Each column that brings points back, taken away or shortened: named with its file."""
    import h5py

    monkeypatch.syspath_prepend(tmp_path / "one")
    folder, case = tmp_path / "branch", pendulum(tmp_path / "one")
    followed(case, folder, 3)
    entire = (folder / branch_file.FILE).read_bytes()
    with h5py.File(folder / branch_file.FILE) as file:
        names = [f"{g}/{c}" for g in ("branch", "places") for c in file[g]]
    for name in names:
        for rows in (0, 1, 2, None):
            (folder / branch_file.FILE).write_bytes(entire)
            with h5py.File(folder / branch_file.FILE, "a") as file:
                values, about = file[name][()], dict(file[name].attrs)
                del file[name]
                if rows is not None:
                    file.create_dataset(name, data=values[:rows]).attrs.update(about)
            try:
                assert len(followed(case, folder, 4).points) == 4
            except ValueError as error:
                assert branch_file.FILE in str(error)  # noqa: PT017
            else:
                parts = set(branch_file.PARTS) - {branch_file.TURNS}
                assert name not in {f"places/{part}" for part in parts}


@pytest.mark.parametrize("seed", few_of(range(3), 1))
def test_T2b_a_branch_with_attributes_of_another_kind(seed, tmp_path, monkeypatch):
    """Each attribute of its file as something else: named with the file, or not needed."""
    import h5py
    import numpy as np

    monkeypatch.syspath_prepend(tmp_path / "one")
    folder, rng, needed = tmp_path / "branch", random.Random(seed), set()
    followed(pendulum(tmp_path / "one"), folder, 3)
    entire = (folder / branch_file.FILE).read_bytes()
    with h5py.File(folder / branch_file.FILE) as file:
        names = [n for n in file.attrs if not n.endswith("_crc32")]
    for name in names:
        (folder / branch_file.FILE).write_bytes(entire)
        with h5py.File(folder / branch_file.FILE, "a") as file:
            del file.attrs[name]
            file.attrs[name] = rng.choice([3.5, np.arange(3.0), np.zeros((2, 2)), [], b"\xff"])
        try:
            branch_file.asked(folder)
            branch_file.points(folder)
        except ValueError as error:
            needed.add(name)
            assert branch_file.FILE in str(error)  # noqa: PT017
    assert needed >= {"format", "request", "made", "ended", "parameter"}


def test_T2c_an_endless_field(tmp_path, typed):
    """More letters than Python's reader of such files takes."""
    path = tmp_path / "m.csv"
    cl.simulate(cl.load_case("slider_crank"), until=0.01, path=tmp_path / "r.h5").close()
    path.write_text("time [s],a [m/s2]\n0,1\n1," + 200_000 * "7" + "\n2,1\n3,1\n4,1\n")
    for command in (("view", tmp_path / "r.h5"), ("plot", tmp_path / "r.h5", "measured")):
        more = ("--measured", path, "--channels", "slider.ax", "-o", tmp_path / "out.html")
        assert "m.csv: line 3: field larger than field limit" in typed.line(*command, *more)


@pytest.mark.parametrize("seed", few_of(range(12), 4))
def test_T4_scenes_without_an_end(seed, tmp_path, typed):
    """Brackets, terms, signs, of any number up to 100,000."""
    rng = random.Random(seed)
    count = int(10 ** rng.uniform(3.5, 5.0))
    text = (
        f"a = {count * '['}{count * ']'}\n",
        f"parameters.a = 1\nbody.b = {{ mass = '$a{count * '+1'}' }}\n",
        f"parameters.a = 1\nbody.b = {{ mass = '{count * '-'}$a' }}\n",
        f"parameters.a = 1\nbody.b = {{ mass = '{count * '('}$a{count * ')'}' }}\n",
    )[seed % 4]
    path = tmp_path / "deep.toml"
    path.write_text(text)
    assert "deep.toml" in typed.line("run", path)
    assert "deep.toml" in typed.line("new", path, "--python -o", tmp_path / "deep.py")


def test_T4_formulas_of_every_depth_have_a_number_or_a_reason():
    """Up to the longest: nothing else is raised."""
    from clearance.scene.toml_scene import LONGEST, formula

    rng = random.Random(0)
    for _ in range(60):
        count = rng.randrange(1, LONGEST // 2 + 20)
        text = rng.choice(
            [count * "-" + "$a", count * "(" + "$a" + count * ")", "$a" + count * "+1"]
        )
        try:
            assert isinstance(formula(text, {"a": 2.0}), float)
        except ValueError as error:
            assert "formula" in str(error)  # noqa: PT017


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep") / "s"
    points = cl.grid(speed=[20.0, 30.0])
    cl.sweep("slider_crank", points, folder, workers=1, turns=0.1, channels=())
    return folder


@pytest.mark.parametrize("depth", [900, 3000, 100_000])
def test_T5_lines_without_an_end(sweep, depth, tmp_path, typed):
    """A line of a journal is passed over; a definition is named."""
    copy = tmp_path / "s"
    shutil.copytree(sweep, copy)
    (copy / "sweep.h5").unlink()
    with (copy / "journal.jsonl").open("a") as file:
        file.write(depth * "[" + depth * "]" + "\n")
    assert main(["report", str(copy), "-o", str(tmp_path / "r.html")]) == 0
    assert cl.open_sweep(copy).done.all()
    (copy / "sweep.json").write_text(depth * "[" + depth * "]")
    message = typed("report", copy, "-o", tmp_path / "r.html", status=2).err
    assert "sweep.json" in message
    assert message.count("clearance: ") == 1


@pytest.mark.parametrize("length", [1e150, 1e200, 1e308])
def test_T8_films_beyond_numbers(length, capsys):
    """A solver without an answer gives its reason. The input may be right: exit status 1 or 2."""
    try:
        status = main(["film", "convergence", f"--length={length}", "--json"])
    except SystemExit as request:
        status = request.code
    assert status in (1, 2)
    assert json.loads(capsys.readouterr().out)["message"]


RAISING = """
import clearance as cl
class Mine({base}):
    def __str__(self):
        {text}
def scene(*, a: float = 1.0) -> cl.Scene:
    raise {what}
{top}
"""


@pytest.mark.parametrize("base", ["Exception", "ValueError", "BaseException", "OSError"])
@pytest.mark.parametrize("text", ["raise RuntimeError", "return 3", "return 'a reason'"])
@pytest.mark.parametrize("top", ["", "raise Mine"])
def test_T9_exceptions_without_a_text(base, text, top, tmp_path, typed):
    """An exception whose text is empty or fails still gives a line."""
    path = tmp_path / "mine.py"
    path.write_text(RAISING.format(base=base, text=text, what="Mine", top=top))
    words = typed.line("run", path)
    assert "a reason" in words or "its text cannot be read" in words


@pytest.mark.parametrize(
    "error", ["GeneratorExit", "BaseException('x')", "SystemExit(3)", "StopIteration"]
)
@pytest.mark.parametrize("top", [True, False])
def test_T10_what_is_no_error_ends_in_a_line(error, top, tmp_path, typed):
    """Whatever a user's file raises ends in a line with its name."""
    path = tmp_path / "mine.py"
    raised = f"raise {error}" if top else ""
    path.write_text(RAISING.format(base="Exception", text="return ''", what=error, top=raised))
    assert "mine" in typed.line("run", path)


@pytest.mark.parametrize("error", [MemoryError(), MemoryError("Unable to allocate 3 GiB")])
def test_T11_no_memory_is_one_line(error, monkeypatch, typed):
    """A run that gets no memory ends in a line, with status 1."""
    from clearance import simulation

    def simulate(*_, **__):
        raise error

    monkeypatch.setattr(simulation, "write", simulate)
    assert "not enough memory" in typed.line("run slider_crank --turns 0.1", status=1)


#: leaves a mark once the package begins to import its modules
BEGUN = """
import sys

def seen(event, arguments):
    if event == "import" and arguments[0] == "clearance.values.accessors":
        open({mark!r}, "w").close()

sys.addaudithook(seen)
"""


@pytest.mark.parametrize("seed", few_of(range(10), 1))
def test_T12_two_interrupts_while_modules_are_imported(seed, tmp_path):
    """At moments drawn from the first second: one line, exit status 1, no traceback. Python's own
    start, before the first line of the package, is left out.
    """
    rng = random.Random(seed)
    mark = tmp_path / "begun"
    (tmp_path / "sitecustomize.py").write_text(BEGUN.format(mark=str(mark)))
    command = [COMMAND, "run", "six_bar_feeder", "--turns", "1000", "-o", str(tmp_path / "r.h5")]
    process = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )
    while not mark.exists():
        assert process.poll() is None
        time.sleep(0.002)
    time.sleep(rng.uniform(0.0, 1.0))
    for _ in range(2):
        process.send_signal(signal.SIGINT)
        time.sleep(rng.uniform(0.0, 0.05))
    error = process.communicate()[1]
    assert "Traceback" not in error
    assert process.returncode == 1
    lines = [x for x in error.splitlines() if x.startswith("clearance:")]
    assert sum("compiling" not in x for x in lines) == 1


@pytest.mark.parametrize("seed", range(3))
def test_a_vanished_working_directory_is_named(seed, tmp_path, monkeypatch, typed):
    """By a run as by a sweep."""
    rng, folder = random.Random(seed), tmp_path / f"{seed}"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PWD", str(folder))
    folder.rmdir()
    command = rng.choice(["run slider_crank --turns 0.1", "sweep slider_crank -p speed=1,2 -o s"])
    assert f"{folder} does not exist any more" in typed.line(command)
