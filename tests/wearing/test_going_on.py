"""Lives and branches that go on after something has changed: never two physics in one folder."""

import itertools
import json
import logging
import os
import random
import signal
import subprocess
import sys
import time

import pytest

import clearance as cl
from clearance.motions import branch_file
from clearance.run import inputs
from tests.seeds import few_of

LAW = """
import clearance as cl
{helper}

@cl.surface_wear
def mine(pressure, sliding_speed, coefficient):
    return {factor} * coefficient * pressure * sliding_speed
"""
ROTOR = """
import math

import clearance as cl
{law}

def scene(*, wear: float = 1e-13, load: float = 1000.0) -> cl.Scene:
    \"\"\"A journal at rest under a load that turns once a second.

    wear: coefficient [m2/N]
    load: on the journal [N]
    \"\"\"
    body = cl.Body("rotor", {mass}, 1e-4)
    joint = cl.ClearanceRevolute(
        cl.ground, body, name="B", radius=0.01, clearance=1e-4, length=0.02,
        eccentricity=(1.09e-4, 0.0), contact=cl.winkler(layer_modulus=1e12, restitution=0.5),
        wear=mine(coefficient=wear),
    )
    drive = cl.Drive(body, speed=2.0 * math.pi, name="d")
    return cl.Scene(joint, cl.Force(body.at(0, 0), x=load), drive, gravity=(0, 0), name="rotor")
"""
TOML = """
name = "rotor"
gravity = [0, 0]
parameters.load = "1000 N"
body.rotor = {{ mass = {mass}, inertia = 1e-4, points = {{ O = [0, 0] }} }}
force.load = {{ kind = "Force", point = "rotor.O", x = "$load" }}
drive.d = {{ target = "rotor", speed = "6.283185307179586 rad/s" }}
[joint.B]
kind = "ClearanceRevolute"
a = "ground"
b = "rotor.O"
radius = 0.01
clearance = 1e-4
length = 0.02
eccentricity = [1.09e-4, 0.0]
contact = {{ law = "winkler", layer_modulus = 1e12, restitution = 0.5 }}
wear = {{ law = "rotor_laws.py:mine", coefficient = 1e-13 }}
"""
PLAN = {"jump_turns": 10.0, "settle": 0, "average": 1}


class Files:
    """A rotor whose law of wear stands in a file of the user, and its parts as texts."""

    def __init__(self, folder, kind):
        self.folder, self.kind = folder, kind
        self.parts = {"factor": 1.0, "mass": 0.5, "comment": "", "bound": 3}
        self.write()

    @property
    def path(self):
        return self.folder / f"rotor.{self.kind}"

    def write(self, **parts):
        """Write the files with some parts changed."""
        self.parts |= parts
        factor, mass, comment = (self.parts[n] for n in ("factor", "mass", "comment"))
        # a law that the user imports, or one that stands beside a scene file
        law = LAW.format(factor=f"(1.0 if pressure < 0.0 else {factor})", helper="")
        (self.folder / "rotor_laws.py").write_text(law)
        text = ROTOR.format(mass=mass, law="from rotor_laws import mine")
        if self.kind == "toml":
            text = TOML.format(mass=mass)
        self.path.write_text(f"{text}\n# {comment}\n")


@pytest.fixture(params=few_of(["py", "toml"], 1))
def files(request, tmp_path, monkeypatch):
    (tmp_path / "one").mkdir()
    monkeypatch.syspath_prepend(tmp_path / "one")
    return Files(tmp_path / "one", request.param)


def afresh():
    """Forget the modules that a new process has not loaded."""
    for name in [n for n in sys.modules if n.startswith(("clearance_case", "rotor_laws"))]:
        del sys.modules[name]


def worn(path, folder, turns, **more):
    afresh()
    return cl.wear(path, turns=turns, directory=folder, **PLAN, **more)


def lines(folder):
    return [json.loads(line) for line in (folder / "journal.jsonl").read_text().splitlines()]


@pytest.mark.slow
@pytest.mark.parametrize("seed", few_of(range(3), 1))
def test_L2_a_life_notices_changes(files, seed, tmp_path, caplog):
    """Of a law, a number, the text of the case, whichever and however much: it is refused with the
    reason; accepted changes stand in the lines of the journal.
    """
    rng, folder = random.Random(seed), tmp_path / "worn"
    change, reason = rng.choice(
        [
            ({"factor": rng.uniform(1.001, 5.0)}, "the law or kernel text has been changed"),
            ({"mass": rng.uniform(0.6, 5.0)}, "bodies rotor mass was 0.5, is now"),
            ({"comment": str(rng.random())}, "the case file has been changed"),
        ]
    )
    first = worn(files.path, folder, rng.uniform(2.0, 15.0)).depth("B")
    files.write(**change)
    with pytest.raises(ValueError, match=rf"{reason}.*accept-changes"):
        worn(files.path, folder, 20.0)
    assert len(lines(folder)) == len(first)
    with caplog.at_level(logging.WARNING):
        life = worn(files.path, folder, 20.0, accept_changes=True)
    assert reason in caplog.text
    assert (life.depth("B")[: len(first)] == first).all()
    assert len({json.dumps(line["made"]) for line in lines(folder)}) == 2
    with pytest.raises(ValueError, match="accept-changes"):  # the first stages are still others
        worn(files.path, folder, 30.0)


def test_L2_a_life_whose_case_is_moved_goes_on(files, tmp_path, monkeypatch):
    """Unchanged files in another folder, and the life in another: the same numbers as a life that
    nobody moved.
    """
    entire = worn(files.path, tmp_path / "entire", 20.0)
    worn(files.path, tmp_path / "worn", 9.0)
    (tmp_path / "one").rename(tmp_path / "two")
    (tmp_path / "worn").rename(tmp_path / "two" / "worn")
    monkeypatch.syspath_prepend(tmp_path / "two")
    moved = tmp_path / "two" / files.path.name
    life = worn(moved, tmp_path / "two" / "worn", 20.0)
    assert life.turns[-1] == entire.turns[-1]
    assert life.done


@pytest.mark.slow
def test_L2_stages_of_another_law_in_a_sweep_of_lives_are_made_anew(tmp_path, monkeypatch):
    """A life that a sweep has not finished begins again, in its driver and its workers alike."""
    monkeypatch.syspath_prepend(tmp_path)
    files = Files(tmp_path, "py")
    points, life = cl.grid(wear=[1e-13, 2e-13]), {"turns": 15.0, **PLAN}
    options = {"life": life, "workers": 1}
    afresh()
    sweep = cl.sweep(files.path, points, tmp_path / "map", **options)
    begun = sweep.life(0).path
    for name in ("sweep.h5", "journal.jsonl"):
        (tmp_path / "map" / name).unlink()
    stages = (begun / "journal.jsonl").read_text().splitlines(keepends=True)
    (begun / "journal.jsonl").write_text(stages[0])
    files.write(factor=3.0)
    afresh()
    again = cl.sweep(files.path, points, tmp_path / "map", **options)
    assert again.done.all()
    assert len({line["made"]["text"] for line in lines(begun)}) == 1
    fresh = worn(files.path, tmp_path / "alone", 15.0)
    assert (cl.Life(begun).depth("B") == fresh.depth("B")).all()


def test_L2_a_life_of_version_0_2_is_named(files, tmp_path):
    """Its lines do not state their inputs."""
    folder = tmp_path / "worn"
    worn(files.path, folder, 5.0)
    old = [{n: line[n] for n in line if n not in ("made", "crc32")} for line in lines(folder)]
    (folder / "journal.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in old))
    with pytest.raises(ValueError, match="do not state their inputs"):
        worn(files.path, folder, 15.0)
    assert worn(files.path, folder, 15.0, accept_changes=True).done


PENDULUM = """
import clearance as cl
from pendulum_parts import MASS

def scene(*, torque: float = 0.5, damping: float = 0.5) -> cl.Scene:
    \"\"\"A pendulum that a torque holds aside, beside a body that turns.

    torque: on the pendulum [N m]
    damping: of the pendulum [N m s]
    \"\"\"
    bob = cl.Body("bob", MASS, 0.75, points={{"pivot": (0, 0)}}, com=(0, -0.5), angle=0.2)
    rotor = cl.Body("rotor", mass=1.0, inertia={inertia}, points={{"pivot": (0, 0)}})
    return cl.Scene(
        cl.Revolute(cl.ground, bob["pivot"], name="pivot"),
        cl.Revolute(cl.ground, rotor["pivot"], name="shaft"),
        cl.TorsionSpring(cl.ground, bob, damping=damping),
        cl.Torque(bob, torque), cl.Drive(rotor, speed=4.0), gravity=(0, -2.0), name="held",
    )
"""


def pendulum(folder, mass=1.0, inertia=1.0):
    folder.mkdir(exist_ok=True)
    (folder / "pendulum_parts.py").write_text(f"MASS = {mass}\n")
    (folder / "held.py").write_text(PENDULUM.format(inertia=inertia))
    return folder / "held.py"


def followed(case, folder, points, **more):
    for name in [n for n in sys.modules if n.startswith(("clearance_case", "pendulum_parts"))]:
        del sys.modules[name]
    return cl.follow(
        case, "torque", 0.5, 0.95, channels=["bodies/bob/theta"], points=points, path=folder, **more
    )


def interrupting(at):
    def progress(text):
        if text.startswith(f"point {at} "):
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize("seed", few_of(range(4), 1))
def test_L3_a_branch_notices_changes(seed, tmp_path, monkeypatch):
    """After so many points as after an interrupt: of the case file, or a module that it imports."""
    monkeypatch.syspath_prepend(tmp_path / "one")
    rng, folder = random.Random(seed), tmp_path / "branch"
    change, reason = rng.choice(
        [
            ({"mass": rng.uniform(1.001, 5.0)}, "the imported module pendulum_parts"),
            ({"inertia": rng.uniform(1.001, 5.0)}, "the case file has been changed"),
        ]
    )
    case, count = pendulum(tmp_path / "one"), rng.randint(2, 6)
    if seed % 2:
        with pytest.raises(KeyboardInterrupt):
            followed(case, folder, 30, progress=interrupting(count))
    else:
        followed(case, folder, count)
    before = branch_file.points(folder)
    assert len(before) == count
    pendulum(tmp_path / "one", **change)
    with pytest.raises(ValueError, match=f"has {count} points, and since then: .*{reason}"):
        followed(case, folder, 30)
    again = followed(case, folder, 30, accept_changes=True)
    assert again.values[:count].tolist() == [p.value for p in before]
    assert len(again.inputs) == 2


def test_L3_a_branch_whose_case_is_moved_goes_on(tmp_path, monkeypatch):
    """The same files in another folder are the same case, however their path is written."""
    monkeypatch.syspath_prepend(tmp_path / "one")
    followed(pendulum(tmp_path / "one"), tmp_path / "branch", 3)
    first = branch_file.points(tmp_path / "branch")
    (tmp_path / "one").rename(tmp_path / "two")
    monkeypatch.syspath_prepend(tmp_path / "two")
    monkeypatch.chdir(tmp_path)
    branch = followed("two/held.py", "branch", 6)
    assert branch.values[:3].tolist() == [p.value for p in first]
    assert len(branch.points) == 6
    assert branch.reason == "6 points"


@pytest.mark.parametrize("seed", few_of(range(2), 1))
def test_L4_an_interrupted_branch_of_enough_points_ends(seed, tmp_path, monkeypatch):
    """Fewer points are requested than there are: all of them stay, and their number is stated."""
    monkeypatch.syspath_prepend(tmp_path / "one")
    case, folder, rng = pendulum(tmp_path / "one"), tmp_path / "branch", random.Random(seed)
    with pytest.raises(KeyboardInterrupt):
        followed(case, folder, 30, progress=interrupting(rng.randint(4, 7)))
    there = len(branch_file.points(folder))
    branch = followed(case, folder, rng.randint(2, there - 1))
    assert (len(branch.points), branch.reason) == (there, f"{there} points")


FOLLOWED = """
import sys
from pathlib import Path
from clearance.motions import follow
from clearance.cli import main
follow.SAVED = follow.SHARE = 0.0
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", few_of(range(2), 1))
def test_L4_a_killed_branch_goes_on(seed, tmp_path):
    """SIGKILL at a point drawn at random: what was stored stays, and the same command goes on."""
    case, count = pendulum(tmp_path / "one"), random.Random(seed).randint(2, 5)
    command = ["follow", str(case), "-p", "torque=0.5:0.95", "-o", str(tmp_path / "branch")]
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "one")}
    program = [sys.executable, "-c", FOLLOWED, *command]
    process = subprocess.Popen(program, env=environment, stdout=subprocess.DEVNULL)
    while process.poll() is None:
        if stored(tmp_path / "branch") >= count:
            process.send_signal(signal.SIGKILL)
            break
        time.sleep(0.01)
    process.wait()
    before = branch_file.points(tmp_path / "branch")
    assert len(before) >= count
    done = subprocess.run(program, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    after = [p.value for p in branch_file.points(tmp_path / "branch")]
    assert after[: len(before)] == [p.value for p in before]
    assert after[-1] == pytest.approx(0.95)
    assert not list((tmp_path / "branch").glob("*.partial"))


def stored(folder):
    """Points in the table of a branch under way."""
    try:
        return len((folder / "follow.csv").read_text().splitlines()) - 1
    except FileNotFoundError:
        return 0


def test_L4_a_branch_is_stored_as_it_goes(tmp_path, monkeypatch):
    """Every few seconds, not at each point: writing takes a fiftieth of the time at most."""
    from clearance.motions import follow

    monkeypatch.syspath_prepend(tmp_path / "one")
    clock = itertools.count(step=1.0)
    monkeypatch.setattr(follow.time, "monotonic", lambda: float(next(clock)))
    monkeypatch.setattr(follow, "SHARE", 0.0)
    seen = []

    def progress(text):
        if text.startswith("point "):
            seen.append(stored(tmp_path / "branch"))

    followed(pendulum(tmp_path / "one"), tmp_path / "branch", 12, progress=progress)
    assert 1 < len(set(seen)) < len(seen)


# --- modules of the user
def test_modules_are_found_without_running_them(tmp_path, monkeypatch):
    """Not even the package that a module is inside. A module beside the case counts too."""
    monkeypatch.syspath_prepend(tmp_path / "path")
    for folder in ("path/kit/deep", "case"):
        (tmp_path / folder).mkdir(parents=True)
    running = "raise SystemExit('this was run')\n"
    for name in ("path/kit/__init__.py", "path/kit/deep/__init__.py", "path/kit/deep/leaf.py"):
        (tmp_path / name).write_text(running)
    (tmp_path / "case" / "beside.py").write_text(running)
    case = tmp_path / "case" / "case.py"
    case.write_text("import kit.deep.leaf, numpy.distutils.misc_util, beside, nothing.there\n")
    assert list(inputs.modules_of([case])) == ["beside", "kit", "kit.deep", "kit.deep.leaf"]


def test_another_copy_of_the_package_is_not_the_users(tmp_path, monkeypatch):
    """Workers may import the installed package, and their driver that of a checkout."""
    (tmp_path / "clearance").mkdir()
    (tmp_path / "clearance" / "__init__.py").write_text("from clearance import values\n")
    (tmp_path / "clearance" / "values.py").write_text("x = 1\n")
    (tmp_path / "mine.py").write_text("import clearance.values\n")
    case = tmp_path / "case.py"
    case.write_text("import clearance as cl\nfrom clearance.values import x\nimport mine\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert list(inputs.modules_of([case])) == ["mine"]


def test_modules_of_installed_distributions_are_not_the_users(tmp_path, monkeypatch):
    """In a folder of PYTHONPATH that an installer has filled, and in other Pythons' folders."""
    target, other = tmp_path / "target", tmp_path / "lib" / "site-packages"
    for folder in (target, other):
        monkeypatch.syspath_prepend(folder)
        (folder / f"in_{folder.name}".replace("-", "_")).mkdir(parents=True)
    (target / "in_target" / "__init__.py").write_text("")
    (other / "in_site_packages" / "__init__.py").write_text("")
    (target / "mine.py").write_text("")
    (target / "kit-1.0.dist-info").mkdir()
    (target / "kit-1.0.dist-info" / "METADATA").write_text("Name: kit\nVersion: 1.0\n")
    (target / "kit-1.0.dist-info" / "RECORD").write_text("in_target/__init__.py,,\n")
    case = tmp_path / "case.py"
    case.write_text("import in_target, in_site_packages, mine, clearance.film, json.decoder\n")
    assert list(inputs.modules_of([case])) == ["mine"]
