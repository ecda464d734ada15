"""A sweep that goes on after something has changed does not put two physics in one table."""

import json
import os
import sys
from dataclasses import asdict

import numpy as np
import pytest

import clearance as cl
from clearance.run import inputs
from clearance.sweeping import journal, sweep
from clearance.sweeping.order import shuffled

CASE = """
import clearance as cl
import helper

def scene(*, length: float = 0.1) -> cl.Scene:
    \"\"\"A pendulum.

    length: of the pendulum [m]
    \"\"\"
    body = cl.Body("arm", mass=helper.MASS, inertia=1e-3, points={"pin": (-length, 0.0)})
    torque = cl.Torque(body, torque=helper.push(size=1e-3))
    return cl.Scene(cl.Revolute(cl.ground, body["pin"], name="P"), torque)
"""
HELPER = """
import clearance as cl

MASS = 1.0

@cl.signal
def push(time, size):
    return size * time
"""
WEIGHED = """
from pathlib import Path
import clearance as cl

def scene(*, length: float = 0.1, mass: str = "") -> cl.Scene:
    \"\"\"A pendulum.

    length: of the pendulum [m]
    mass: a file that holds it [-]
    \"\"\"
    found = float(Path(mass).read_text())
    body = cl.Body("arm", mass=found, inertia=1e-3, points={"pin": (-length, 0.0)})
    return cl.Scene(cl.Revolute(cl.ground, body["pin"], name="P"))
"""
POINTS = cl.grid(length=[0.1, 0.2, 0.3])


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """A sweep of three points one of which is missing, and the call that goes on with it."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "helper", raising=False)
    (tmp_path / "mine.py").write_text(CASE)
    (tmp_path / "helper.py").write_text(HELPER)
    folder = tmp_path / "out"

    def go(**more):
        sys.modules.pop("helper", None)
        for name in [n for n in sys.modules if n.startswith("clearance_case_mine")]:
            del sys.modules[name]
        return cl.sweep(
            tmp_path / "mine.py", POINTS, folder, until=0.1, samples=11, workers=1, **more
        )

    go()
    lose(folder, 1)
    yield folder, go
    sys.modules.pop("helper", None)


def lines(folder):
    """Outcomes in a journal, a dictionary each."""
    return [asdict(outcome) for outcome in journal.read(folder / "journal.jsonl")]


def rewrite(folder, outcomes):
    (folder / "journal.jsonl").write_text("".join(json.dumps(o) + "\n" for o in outcomes))


def lose(folder, index):
    rewrite(folder, [o for o in lines(folder) if o["index"] != index])
    (folder / "runs" / f"{cl.open_sweep(folder).definition.keys[index]}.h5").unlink(missing_ok=True)


def edit(folder, old, new):
    helper = folder.parent / "helper.py"
    helper.write_text(helper.read_text().replace(old, new))
    # Python takes byte code of the same second and length for that of the file
    os.utime(helper, (later := helper.stat().st_mtime + 2.0, later))


def test_R2_unchanged_it_goes_on(begun):
    """Each line states version and modules that made it."""
    folder, go = begun
    assert go().done.all()
    assert {o["made"]["version"] for o in lines(folder)} == {inputs.common({})["version"]}
    assert all(list(o["made"]["modules"]) == ["helper"] for o in lines(folder))


def test_R2_a_changed_helper_is_named_and_refused(begun):
    """An imported file that changes a number: the file, the point, the number and both values are
    stated.
    """
    folder, go = begun
    edit(folder, "MASS = 1.0", "MASS = 2.5")
    before = (folder / "journal.jsonl").read_bytes()
    with pytest.raises(
        ValueError,
        match="imported module helper has been changed.*bodies arm mass was 1, is now 2.5",
    ):
        go()
    assert (folder / "journal.jsonl").read_bytes() == before
    actual = go(accept_changes=True)
    assert actual.done.all()
    assert len({json.dumps(o["made"]) for o in lines(folder)}) == 3
    with actual.run(1) as run:
        assert json.loads(run.file.attrs["scene"])["bodies"][0]["mass"] == 2.5


def test_R2_a_changed_file_of_one_point_among_many_is_refused(tmp_path):
    """More points than are built again: each states which files its parameters name."""
    case, folder = tmp_path / "weighed.py", tmp_path / "out"
    case.write_text(WEIGHED)
    for name in ("a", "b"):
        (tmp_path / f"{name}.txt").write_text("1.0")
    count, odd = 40, 7  # more than sweep.TRIED
    assert odd not in shuffled(list(range(count)))[: sweep.TRIED]
    masses = [str(tmp_path / f"{'b' if i == odd else 'a'}.txt") for i in range(count)]
    points = cl.zipped(length=[0.1 + 0.01 * i for i in range(count)], mass=masses)

    def go(**more):
        return cl.sweep(case, points, folder, until=0.01, samples=3, workers=1, channels=[], **more)

    assert go().done.all()
    rewrite(folder, [o for o in lines(folder) if o["index"] != 3])
    (tmp_path / "b.txt").write_text("2.0")
    with pytest.raises(ValueError, match=r"since then: the file .*b\.txt has been changed"):
        go()
    assert go(accept_changes=True).done.all()


def test_R2_a_law_that_no_file_tells_of_is_noticed(begun):
    """Kernel texts are compared too: the digests of the files are made equal here."""
    folder, go = begun
    edit(folder, "size * time", "size * time * time")
    digests = inputs.modules_of([folder.parent / "mine.py"])
    rewrite(folder, [o | {"made": o["made"] | {"modules": digests}} for o in lines(folder)])
    with pytest.raises(
        ValueError, match=r"at length=0\.\d: the law or kernel text has been changed"
    ):
        go()


def test_R2_another_version_is_refused(begun):
    """Unless changes are accepted."""
    folder, go = begun
    rewrite(folder, [o | {"made": o["made"] | {"version": "0.0.1"}} for o in lines(folder)])
    with pytest.raises(ValueError, match=r"clearance 0\.0\.1, here "):
        go()
    assert go(accept_changes=True).done.all()


def test_R2_a_journal_of_version_0_1_is_refused(begun):
    """Its points do not state their inputs, so they are unknown."""
    folder, go = begun
    rewrite(folder, [{n: v for n, v in o.items() if n != "made"} for o in lines(folder)])
    with pytest.raises(ValueError, match="do not state their inputs"):
        go()
    assert go(accept_changes=True).done.all()


def test_R2_a_finished_sweep_is_read_whatever_has_changed(begun):
    """Nothing is run, so nothing is mixed; the progress, which the command prints, names it."""
    folder, go = begun
    go()
    edit(folder, "MASS = 1.0", "MASS = 2.5")
    news = []
    assert go(progress=lambda p: news.extend(p.news)).done.all()
    assert "the imported module helper has been changed" in " ".join(news)


def test_R2_a_worker_that_runs_something_else_stops_the_sweep(begun, monkeypatch):
    """A cluster's worker of another version: its point is not stored."""
    folder, go = begun
    now = inputs.common({}) | {"version": "0.0.1"}
    monkeypatch.setattr(sweep, "common", lambda modules, files: now | {"modules": modules})
    with pytest.raises(
        sweep.SweepError,
        match=r"a worker runs something else than the driver: clearance .*here "
        r"0\.0\.1",
    ):
        go(accept_changes=True)
    assert sorted(o["index"] for o in lines(folder)) == [0, 2]


def test_R2_what_was_run_survives_the_journal(begun):
    """The run's own file states it too."""
    folder, go = begun
    (folder / "journal.jsonl").unlink()
    assert go().done.all()
    assert all(o["made"]["modules"] for o in lines(folder))


def test_R2_modules_of_modules(tmp_path, monkeypatch):
    """Packages, relative imports and imports of imports; not the standard library, packages or
    clearance itself.
    """
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "kit").mkdir()
    (tmp_path / "kit" / "__init__.py").write_text("from . import numbers_\n")
    (tmp_path / "kit" / "numbers_.py").write_text("import json\nfrom .deep import y\n")
    (tmp_path / "kit" / "deep.py").write_text("y = 1\n")
    (tmp_path / "beside_.py").write_text("import numpy\nimport clearance\n")
    (tmp_path / "mine.py").write_text(
        "def f():\n    import beside_\n    from kit.numbers_ import y\n"
    )
    assert list(inputs.modules_of([tmp_path / "mine.py"])) == [
        "beside_",
        "kit",
        "kit.deep",
        "kit.numbers_",
    ]


def test_R2_the_last_digit_of_a_number_is_no_change():
    """Nine digits: another machine's sine does not make another scene."""
    one, two = (
        json.dumps({"joints": [{"name": "C", "x": x}]}) for x in (0.1, np.nextafter(0.1, 1.0))
    )
    assert inputs.numbers(one) == inputs.numbers(two) == {"joints C name": "C", "joints C x": "0.1"}


def test_R9_what_killed_workers_left_is_cleaned_up(begun):
    """Half files and locks are gone in the end."""
    folder, go = begun
    (folder / "runs" / "0123456789abcdef.h5.77.0.partial").write_bytes(b"half a file")
    assert go().done.all()
    assert sorted(p.suffix for p in (folder / "runs").iterdir()) == [".h5"] * 3
    assert not (folder / "lock").exists()
