"""Results made again from their own files: bit for bit, or refused with the reason."""

import shutil

import h5py
import pytest

import clearance as cl
from clearance import cli
from clearance.run.again import again, differences
from clearance.scene.catalogue import case_names
from clearance.simulation import prepare
from clearance.stepping import status

#: a twentieth of a turn, or 10 ms
SHORT = 0.05
COSTLY = ("five_axis_chain", "mobile_manipulator")  # to compile
CHEAP = [name for name in case_names() if name not in COSTLY]
RUNS = [
    *((name, {}, {}) for name in CHEAP[::3]),
    *(
        pytest.param(name, {}, {}, marks=pytest.mark.slow)
        for name in case_names()
        if name not in CHEAP[::3]
    ),
    (
        "four_bar",
        {"model": "dry"},
        {"method": "dop853", "channels": ["joints/*"], "compression": 1},
    ),
    ("six_bar_feeder", {"clearance": 2e-4}, {"start": "quasi-static"}),
]


@pytest.mark.parametrize(("name", "values", "options"), RUNS)
def test_a_result_again_bit_for_bit(name, values, options, tmp_path):
    """A file has all that makes it again, bit for bit."""
    scene = cl.load_case(name, **values)
    until = SHORT * (scene.turn or 0.2)
    one = cl.simulate(
        scene, until=until, samples=5, error=None, path=tmp_path / "one.h5", **options
    )
    again_scene, again_options = cl.again(tmp_path / "one.h5")
    two = cl.simulate(again_scene, path=tmp_path / "two.h5", **again_options)
    assert differences(one, two) == {}
    same = [n for n in one.file.attrs if n != "created" and not n.endswith("_crc32")]
    assert [n for n in same if str(one.file.attrs[n]) != str(two.file.attrs[n])] == []


def test_differences_are_seen():
    """Another tolerance: some columns differ, by no more than their size."""
    scene = cl.load_case("four_bar", model="dry")
    runs = [
        cl.simulate(scene, until=0.01, samples=5, rtol=rtol, error=None) for rtol in (1e-6, 1e-5)
    ]
    apart = differences(*runs)
    assert "bodies/coupler/ax" in apart
    assert 0.0 < apart["bodies/coupler/ax"] < 1.0
    assert "time" not in apart


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """A run of the command line."""
    path = tmp_path_factory.mktemp("again") / "run.h5"
    words = ["run", "four_bar", "-p", "model=dry", "--turns", "0.05", "--no-error", "-o", str(path)]
    assert cli.main(words) == 0
    return path


def test_the_command_line(result, tmp_path, monkeypatch, typed):
    """The same numbers, and a file beside; options of the file are refused."""
    monkeypatch.chdir(tmp_path)
    printed = typed("run", result, "--again").out
    assert "given        model = dry" in printed
    assert "every number is that of run.h5, to the last bit" in printed
    with cl.open_result("run_again.h5") as second, cl.open_result(result) as first:
        assert second.file.attrs["case_file"] == first.file.attrs["case_file"] == "four_bar"
        assert differences(first, second) == {}
    for words, reason in (
        (["--rtol", "1e-4"], "--rtol beside --again"),
        (["-p", "model=dry"], "-p beside --again"),
        (["-o", str(result)], "is the file that is run again"),
    ):
        assert reason in typed.line("run", result, "--again", *words)


def test_what_cannot_be_made_again_is_refused(result, tmp_path):
    """Without options, of a periodic motion, and with numbers that were changed on the way."""
    for name, change, reason in (
        (
            "older",
            lambda file: file.attrs.__delitem__("options"),
            "does not hold the options of its run",
        ),
        ("steady", lambda file: file.create_group("steady"), "is a periodic motion"),
        ("changed", lambda file: file.create_group("changes"), "were changed on the way"),
    ):
        path = tmp_path / f"{name}.h5"
        shutil.copy(result, path)
        with h5py.File(path, "r+") as file:
            change(file)
        with pytest.raises(ValueError, match=reason):
            again(path)


def test_a_run_that_began_at_the_end_of_another(result, tmp_path):
    """The state it began in is in its file: the other file is not needed."""
    scene, _ = cl.again(result)
    short = {"until": 0.002, "samples": 3, "error": None}
    first = shutil.copy(result, tmp_path / "first.h5")
    with pytest.raises(ValueError, match="from where this scene starts"):
        cl.simulate(scene, start=first, **short)
    still = cl.load_case("double_pendulum")
    cl.simulate(still, path=tmp_path / "one.h5", **short)
    two = cl.simulate(still, start=tmp_path / "one.h5", path=tmp_path / "two.h5", **short)
    (tmp_path / "one.h5").unlink()
    scene, options = cl.again(tmp_path / "two.h5")
    assert differences(two, cl.simulate(scene, **options)) == {}


def test_options_of_a_run_without_a_file():
    """A prepared run has them too; the span is exact."""
    scene = cl.load_case("four_bar", model="dry")
    run = prepare(scene, turns=0.3, rtol=1e-5)
    assert run.code == status.RUNNING
    assert run.options["until"] == 0.3 * scene.turn
    assert run.options["rtol"] == 1e-5


def test_a_scene_without_a_case_again(tmp_path, monkeypatch, typed):
    """The file of a scene that Python made runs again by the command, to the last bit."""
    monkeypatch.chdir(tmp_path)
    arm = cl.Body("arm", 1.0, 0.1, com=(0.3, 0.0))
    scene = cl.Scene(cl.Revolute(cl.ground, arm, name="pin"))
    cl.simulate(scene, until=0.1, path="swing.h5").close()
    assert "every number is that of swing.h5, to the last bit" in typed("run swing.h5 --again").out
