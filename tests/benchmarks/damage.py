"""Damaged and foreign files, many of them: what commands and readers make of each.

    python -m tests.benchmarks.damage [NAME ...] [--tries 300] [--seed 0] [--update]

damages copies of files of each kind (flipped bits, cut short, zeros, parts missing or of another
kind), and a reader or a command looks at each. It must state in one line what is wrong, or do its
work; nothing may raise. Of damaged bytes no number may be read that was not written. Work that goes
on must end as it does from undamaged files. A worker process looks, and a new one takes its place
where a look takes longer than LIMIT. The exit status is 1 where something failed.
"""

import contextlib
import io
import json
import multiprocessing
import random
import re
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from clearance.paper_figures.ball_joint_bench import bench

import clearance as cl
from clearance.cli import main
from clearance.identify.records import Measurement, read, write
from clearance.motions import branch_file
from clearance.run.checkpoint import load, parts_folder
from tests.benchmarks import kills
from tests.benchmarks.publishing import RESULTS, options, put
from tests.motions.test_follow import CASE

LIMIT = 60.0  # seconds of a look
COMMANDS = 0.25  # share of commands among the looks; readers have the others
BEGIN = "<!-- damage -->"
#: what reads a result file
OF_RUNS = (
    "plot {} -o {out}.png",
    "plot {} history --channels C.force,slider.ax -o {out}.png",
    "plot {} orbit -o {out}.png",
    "plot {} phase -o {out}.png",
    "plot {} poincare --settle 0 -o {out}.png",
    "plot {} spectrum -o {out}.png",
    "plot {} contacts -o {out}.png",
    "plot {} efforts -o {out}.png",
    "plot {} sketch -o {out}.png",
    "plot {} animation --frames 2 -o {out}.gif",
    "film snapshots {} --count 1 --mesh 16x2",
    "report {} -o {out}.html",
    "view {} -o {out}.html",
    "new {} -o {out}.toml",
    "run {} --again -o {out}.h5",
)
#: what reads the directory of a sweep
_BIFURCATION = "plot {} bifurcation --x speed --at clearance=1e-4 --channels C.gap"
OF_SWEEPS = (
    "plot {} map --metrics slider_acceleration_max -o {out}.png",
    "plot {} curves --metrics slider_acceleration_max -o {out}.png",
    f"{_BIFURCATION} -o {{out}}.png",
)
OF_RUNS_OF_SWEEPS = (*OF_SWEEPS, "report {} -o {out}.html")
OF_MEASUREMENTS = ("identify --data {} --model curve -o {out}",)
#: what takes any file for a case
OF_CASES = ("run {}", "sweep {} -p speed=1,2 -o {out}", "lyapunov {}", "explain {}")
OF_LIVES = ("plot {} -o {out}.png",)
OF_STAGES = ("view {}/stage-0001.h5 -o {out}.html",)
_SHORT = "--until 0.01 -o {out}.h5"
OF_SCENES = ("explain {}", f"run {{}} {_SHORT}", f"inverse {{}} {_SHORT}")
OF_TEXTS = ("explain {text}", f"run {{text}} {_SHORT}")
#: work that goes on in a folder
LIFE = "wear slider_crank -p model=dry -p wear=1e-13 --settle 0 --average 1 --turns 300 -o {}"
BRANCH = "follow {whole}/held_pendulum.py -p torque=0.5:0.7 -o {} --points"
RUN = (
    "run slider_crank -p friction=coulomb --turns 20 --samples-per-turn 40 --checkpoint 60 "
    "-o {}/r.h5"
)
SWEEP = (
    "sweep slider_crank -p speed=20,30 -p clearance=1e-4,2e-4 -p model=lubricated -p film=harmonic "
    "--turns 2 --samples-per-turn 40 --workers 1 -o {}"
)

Damage = Callable[[Path, random.Random], str]


# --- ways to damage a file; each returns its name
def flip(path: Path, rng: random.Random) -> str:
    """One bit of a file."""
    content = bytearray(path.read_bytes())
    offset, bit = rng.randrange(len(content)), rng.randrange(8)
    content[offset] ^= 1 << bit
    path.write_bytes(content)
    return f"bit {bit} of byte {offset}"


def cut(path: Path, rng: random.Random) -> str:
    """A file that ends early."""
    content = path.read_bytes()
    offset = rng.randrange(len(content))
    path.write_bytes(content[:offset])
    return f"cut at byte {offset}"


def zeros(path: Path, rng: random.Random) -> str:
    """A file of which a block was never written."""
    content = bytearray(path.read_bytes())
    offset = rng.randrange(len(content))
    content[offset : offset + 64] = bytes(len(content[offset : offset + 64]))
    path.write_bytes(content)
    return f"zeros from byte {offset}"


def index(path: Path, rng: random.Random) -> str:
    """A file in which the index of some column has eight bytes or a block of others."""
    content = bytearray(path.read_bytes())
    begin = rng.choice([match.start() for match in re.finditer(b"TREE\x01", content)] or [0])
    offset = begin + rng.randrange(80)
    other = rng.choice([rng.randbytes(8), bytes(64)])
    content[offset : offset + len(other)] = other
    path.write_bytes(content)
    return f"{len(other)} bytes from byte {offset}"


def _items(file: h5py.File) -> list[str]:
    numbers_found = ["/"]
    file.visit(numbers_found.append)
    return sorted(numbers_found)


def _one_of(file: h5py.File, rng: random.Random, kind=object) -> str:
    return rng.choice([name for name in _items(file)[1:] if isinstance(file[name], kind)])


def _attribute(file: h5py.File, rng: random.Random) -> tuple[h5py.AttributeManager, str, str]:
    names = [(item, name) for item in _items(file) for name in sorted(file[item].attrs)]
    item, name = rng.choice(
        [n for n in names if n[1] not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")]
    )
    return file[item].attrs, name, f"{item}@{name}"


def less_attributes(path: Path, rng: random.Random) -> str:
    """A file without some attribute."""
    with h5py.File(path, "a") as file:
        attributes, name, where = _attribute(file, rng)
        del attributes[name]
    return f"without {where}"


def other_attribute(path: Path, rng: random.Random) -> str:
    """An attribute of another kind."""
    with h5py.File(path, "a") as file:
        attributes, name, where = _attribute(file, rng)
        value = rng.choice(
            [3.5, -1, "a text", np.arange(3.0), np.zeros((2, 2)), [], h5py.Empty("f8")]
        )
        del attributes[name]
        attributes[name] = value
    return f"{where} = {value!r}"


def less_items(path: Path, rng: random.Random) -> str:
    """A file without some dataset or group."""
    with h5py.File(path, "a") as file:
        name = _one_of(file, rng)
        del file[name]
    return f"without {name}"


def other_item(path: Path, rng: random.Random) -> str:
    """A dataset of another kind or shape."""
    others = [
        3.5,
        "a text",
        np.zeros(1),
        np.zeros((3, 2)),
        np.array([b"a", b"b"]),
        np.zeros(3, complex),
        None,
    ]
    with h5py.File(path, "a") as file:
        name = _one_of(file, rng, h5py.Dataset)
        attributes = {
            n: v for n, v in file[name].attrs.items() if n in ("units", "long_name", "actual_range")
        }
        value = rng.choice(others)
        del file[name]
        item = file.create_group(name) if value is None else file.create_dataset(name, data=value)
        item.attrs.update(attributes)
    return f"{name} = {value!r}"


def endless_item(path: Path, rng: random.Random) -> str:
    """A dataset that claims more values than any machine has room for."""
    with h5py.File(path, "a") as file:
        name = _one_of(file, rng, h5py.Dataset)
        attributes = {
            n: v for n, v in file[name].attrs.items() if n in ("units", "long_name", "actual_range")
        }
        del file[name]
        file.create_dataset(name, (10**12,), "f8", chunks=(1024,)).attrs.update(attributes)
    return f"{name} of 10^12 values"


def other_scene(path: Path, rng: random.Random) -> str:
    """A scene that lacks something, of a file that has no checksum for it."""
    with h5py.File(path, "a") as file:
        scene = json.loads(file.attrs["scene"])
        owner = rng.choice([scene, *scene["bodies"], *scene["joints"], *scene["loads"]])
        name = rng.choice(sorted(owner))
        del owner[name]
        file.attrs["scene"] = json.dumps(scene)
        file.attrs.pop("scene_crc32", None)
    return f"scene without {name}"


def other_json(path: Path, rng: random.Random) -> str:
    """Lines of JSON in which some value is of another kind, or gone."""
    lines = path.read_text().splitlines() if path.suffix == ".jsonl" else [path.read_text()]
    i = rng.randrange(len(lines))
    document = json.loads(lines[i])
    document.pop("crc32", None)  # else all are refused for their checksum
    owner, name = document, rng.choice(sorted(document))
    while isinstance(owner[name], dict) and owner[name] and rng.random() < 0.6:
        owner = owner[name]
        name = rng.choice(sorted(owner))
    value = rng.choice(["gone", {}, [], None, "a text", -1, 1e300, True, [[1]]])
    if value == "gone":
        del owner[name]
    else:
        owner[name] = value
    lines[i] = json.dumps(document)
    path.write_text("\n".join(lines) + "\n")
    return f"{name}: {value}"


def other_text(path: Path, rng: random.Random) -> str:
    """A text into which something is put that does not belong there."""
    text = path.read_text()
    put = rng.choice(
        [
            '"',
            "\n#=\n",
            "\n# = x\n",
            ",,,",
            "\0",
            "\n\n",
            "1e400",
            "# x = [1,a]\n",
            "\ud7ff",
            ";",
            "nan",
        ]
    )
    offset = rng.randrange(len(text))
    path.write_text(text[:offset] + put + text[offset:])
    return f"{put!r} at {offset}"


def other_arrays(path: Path, rng: random.Random) -> str:
    """Arrays of which one is gone, or of another kind or shape."""
    with np.load(path) as file:
        arrays = dict(file)
    name = rng.choice(sorted(arrays))
    del arrays[name]
    others = [3.5, "a text", np.zeros(1), np.zeros((3, 2)), np.nan, [b"a"], None]
    if (value := rng.choice(others)) is not None:
        arrays[name] = value
    np.savez(path, **arrays)
    return f"{name}: {value!r}"


OF_BYTES = (flip, cut, zeros)
OF_FILES = (*OF_BYTES, index)  # what a checksum reveals
OF_HDF5 = (*OF_FILES, less_attributes, other_attribute, less_items, other_item, endless_item)
OF_JSON = (*OF_BYTES, other_json)
OF_TEXT = (*OF_BYTES, other_text)
OF_ARRAYS = (*OF_BYTES, other_arrays)


# --- readers
def of_run(path: Path) -> dict:
    """All numbers of a result file, by place."""
    with cl.open_result(path) as run:
        places = {p: run.values(p) for p in _channels(run)} | {
            f"events/{n}": v for n, v in run.events.items()
        }
        for group in (
            "",
            "solver",
            "energy",
            *(f"joints/{j}" for j in run.names("joints")),
            *_channels(run),
        ):
            places |= {
                f"{group}@{n}": v
                for n, v in run.facts(group).items()
                if not isinstance(v, str | np.ndarray)
            }
        return places | {"scene": json.dumps(run.scene)}


def _channels(run) -> Iterator[str]:
    yield "time"
    for kind in ("bodies", "joints", "drives"):
        for name in run.names(kind):
            yield from (f"{kind}/{name}/{channel}" for channel in run.names(f"{kind}/{name}"))


def of_sweep(folder: Path) -> dict:
    """Numbers of the points of a sweep that are done."""
    sweep = cl.open_sweep(folder)
    columns, done = sweep.columns | sweep.metrics, np.flatnonzero(sweep.done)
    return {f"{i} {n}": v[i] for i in done for n, v in columns.items()}


def of_sweep_with_run(folder: Path) -> dict:
    """The same, and numbers of the run with the first name."""
    run = min((folder / "runs").glob("*.h5"))
    return of_sweep(folder) | of_run(run)


def of_life(folder: Path) -> dict:
    """Numbers of the stages of a life."""
    life = cl.Life(folder)
    there = {f"asked {n}": v for n, v in life.asked.items()}
    for i, stage in enumerate(life.stages):
        there |= {f"{i} {n}": v for n, v in (stage | life._arrays[i]).items()}
    return there


def of_stage(folder: Path) -> dict:
    """Numbers of the run of a stage."""
    return of_run(cl.Life(folder).file(1))


def of_branch(folder: Path) -> dict:
    """Points of a branch, and the request."""
    there = {"asked": branch_file.asked(folder)}
    for i, point in enumerate(branch_file.points(folder)):
        there |= {f"{i} {n}": v for part in (point, point.passage) for n, v in vars(part).items()}
        del there[f"{i} passage"]
    return there


def of_checkpoints(folder: Path) -> dict:
    """State and first stretch of a run that was killed."""
    parts = parts_folder(folder / "r.h5")
    return load(parts / "state.npz") | of_run(parts / "0000.h5")


def of_measurement(path: Path) -> dict:
    """Columns of the trials of a measurement."""
    trials = enumerate(read(path).trials)
    return {f"{i} {n}": v for i, trial in trials for n, v in vars(trial).items()}


def of_table(path: Path) -> None:
    """A measurement without checksums."""
    read(path)


def of_scene(path: Path) -> None:
    """A scene without checksums."""
    cl.load_case(path)


def of_text(path: Path) -> None:
    """A scene of a text without checksums."""
    cl.Scene.from_json(path.read_text(errors="replace"))


# --- files
class Kind(NamedTuple):
    """A kind of files.

    source: file or folder to copy; inside: file in it to damage. reader: gives numbers by place,
    None where files have no checksums. ongoing: a command whose results are compared. parts: lines
    of a journal, some may be missing.
    """

    source: Path
    inside: str
    ways: tuple[Damage, ...]
    reader: Callable[[Path], dict | None]
    commands: tuple[str, ...] = ()
    ongoing: str = ""
    parts: bool = False

    @property
    def damaged(self) -> str:
        """Name of the damaged file in a copy."""
        return str(Path(self.source.name, self.inside))


def kinds(folder: Path) -> dict[str, Kind]:
    """Kinds of the files that `sources` writes."""
    dry, sweep, life, run = (folder / n for n in ("dry.h5", "sweep", "life", "run"))
    key, stage = min((p.name for p in sweep.glob("runs/*.h5")), default=""), "stage-0001"
    points, swept = (of_sweep, OF_SWEEPS, SWEEP), (of_sweep_with_run, OF_RUNS_OF_SWEEPS, SWEEP)
    stages, worn = (of_life, OF_LIVES, LIFE), (of_stage, OF_STAGES, LIFE)
    rest = of_checkpoints, (), RUN
    return {
        "dry run": Kind(dry, "", (*OF_HDF5, other_scene), of_run, OF_RUNS),
        "lubricated run": Kind(folder / "wet.h5", "", (*OF_HDF5, other_scene), of_run, OF_RUNS),
        "sweep: sweep.h5": Kind(sweep, "sweep.h5", OF_HDF5, *points),
        "sweep: sweep.json": Kind(sweep, "sweep.json", OF_JSON, *points),
        "sweep: journal": Kind(sweep, "journal.jsonl", OF_JSON, *points, True),
        "sweep: a run": Kind(sweep, f"runs/{key}", OF_HDF5, *swept),
        "life: life.json": Kind(life, "life.json", OF_JSON, *stages),
        "life: journal": Kind(life, "journal.jsonl", OF_JSON, *stages, True),
        "life: outlines of a stage": Kind(life, f"{stage}.npz", OF_ARRAYS, *stages),
        "life: run of a stage": Kind(life, f"{stage}.h5", OF_HDF5, *worn),
        "branch": Kind(folder / "branch", branch_file.FILE, OF_HDF5, of_branch, (), f"{BRANCH} 6"),
        "checkpoint: a stretch": Kind(run, "r.h5.parts/0000.h5", OF_HDF5, *rest),
        "checkpoint: state": Kind(run, "r.h5.parts/state.npz", OF_ARRAYS, *rest),
        "measurement": Kind(folder / "bench.h5", "", OF_HDF5, of_measurement, OF_MEASUREMENTS),
        "measurement: CSV": Kind(folder / "bench.csv", "", OF_TEXT, of_table, OF_MEASUREMENTS),
        "scene: TOML": Kind(folder / "scene.toml", "", OF_TEXT, of_scene, OF_SCENES),
        "scene: JSON": Kind(folder / "scene.json", "", (*OF_TEXT, other_json), of_text, OF_TEXTS),
        "no case": Kind(dry, "", OF_BYTES, of_scene, OF_CASES),
    }


def sources(folder: Path, rest: bool = True) -> dict[str, Kind]:
    """Write a file of each kind. rest: also lives, branches, written scenes and checkpoints."""
    few = {"turns": 1.0, "samples_per_turn": 40}
    scene = cl.load_case("slider_crank", friction="coulomb")
    wet = cl.load_case("slider_crank", model="lubricated", film="harmonic")
    cl.simulate(scene, path=folder / "dry.h5", **few).close()
    cl.simulate(wet, path=folder / "wet.h5", **few).close()
    trials = bench(seed=0).of("training").trials[:2]
    short = (
        replace(t, time=t.time[:300], rate=t.rate[:300], torque=t.torque[:300]) for t in trials
    )
    measurement = Measurement(tuple(short), {"bench": "none"})
    write(folder / "bench.h5", measurement)
    write(folder / "bench.csv", measurement)
    (folder / "held_pendulum.py").write_text(CASE)
    (folder / "scene.json").write_text(scene.to_json())
    right(SWEEP, folder / "sweep")
    if not rest:
        return kinds(folder)
    right(LIFE, folder / "life")
    right(f"{BRANCH} 4", folder / "branch")
    right("new slider_crank -o {}", folder / "scene.toml")
    interrupted(scene, folder / "run" / "r.h5")
    lines = (folder / "life" / "journal.jsonl").read_text().splitlines(keepends=True)
    (folder / "life" / "journal.jsonl").write_text("".join(lines[:-1]))  # as a kill leaves it
    return kinds(folder)


def right(command: str, path: Path) -> None:
    """A command writes path."""
    look = commanded(command, path, path.parent, path.parent)
    assert look.outcome == RIGHT, look.fault


def interrupted(scene: cl.Scene, path: Path) -> None:
    """Leave checkpoints of a run that did not come to its end."""

    def interrupt(share):
        if share > 0.4:
            raise KeyboardInterrupt

    options = {"turns": 20, "samples_per_turn": 40, "checkpoint": 1e-9}
    with contextlib.suppress(KeyboardInterrupt):
        cl.simulate(scene, path=path, progress=interrupt, **options)
    path.unlink(missing_ok=True)  # as a kill leaves it


def copied(kind: Kind, folder: Path) -> Path:
    """A copy of the files of a kind."""
    copy = folder / kind.source.name
    shutil.rmtree(copy) if copy.is_dir() else copy.unlink(missing_ok=True)
    shutil.copytree(kind.source, copy) if kind.source.is_dir() else shutil.copy(kind.source, copy)
    if kind.inside == "journal.jsonl" or kind.inside.startswith("runs/"):
        (copy / "sweep.h5").unlink(missing_ok=True)  # else the index has it
    return copy


# --- looks
RIGHT, REFUSED = "read right", "refused in one line"
WRONG, RAISED, LATE = "silent wrong", "traceback", "timed out"
FAULTS = (WRONG, RAISED, LATE)


class Look(NamedTuple):
    """Outcome of a look, and its fault; text: of the damage and of the look."""

    outcome: str
    fault: str = ""
    text: str = ""


def commanded(command: str, copy: Path, root: Path, folder: Path) -> Look:
    """A command looks at a copy. root: folder of the sources."""
    text = copy.read_text(errors="replace") if "{text}" in command else ""
    places = {"whole": root, "out": folder / "out", "text": text}
    return judged([word.format(copy, **places) for word in command.split()])


def judged(arguments: list[str]) -> Look:
    """The end of a command: it does its work, or gives one line with the reason."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(arguments)
    except SystemExit as request:
        status = request.code
    except Exception:
        return Look(RAISED, traceback.format_exc(limit=-3))
    if not status:
        return Look(RIGHT)
    message = [line for line in err.getvalue().splitlines() if line.startswith("clearance:")]
    if status in (1, 2) and len(message) == 1 and len(message[0]) <= 2000:
        return Look(REFUSED)
    return Look(RAISED, f"exit status {status}: {err.getvalue()[:500]!r}")


def printed(arguments: list[str]) -> str | None:
    """Fault in the end of a command; None where there is none."""
    look = judged(arguments)
    return look.fault if look.outcome in FAULTS else None


def went_on(kind: Kind, copy: Path, compared: bool) -> Look:
    """Work goes on in a copy, and ends as it does from undamaged files."""
    look = commanded(kind.ongoing, copy, kind.source.parent, copy.parent)
    if look.outcome != RIGHT or not compared or results(copy) == peace(kind):
        return look
    return Look(WRONG, "it ends with other results")


@cache
def peace(kind: Kind) -> str:
    """Results of work that goes on from undamaged files."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        look = commanded(kind.ongoing, copied(kind, folder), kind.source.parent, folder)
        assert look.outcome == RIGHT, look.fault
        return results(folder / kind.source.name)


def results(folder: Path) -> str:
    """Numbers that work in a folder has computed."""
    branch = folder / branch_file.FILE
    return repr(kills.columns(branch) if branch.exists() else kills.results(folder))


def readings(kind: Kind, copy: Path, compared: bool) -> Look:
    """The reader looks at a copy."""
    try:
        there = kind.reader(copy)
    except (ValueError, OSError):
        return Look(REFUSED)
    except Exception:
        return Look(RAISED, traceback.format_exc(limit=-3))
    if there is None or not compared:
        return Look(RIGHT)
    written = entire(kind)
    faults = [f"{n} is another" for n, v in there.items() if not same(v, written.get(n))]
    faults += [] if kind.parts else [f"there is no {n}" for n in written.keys() - there.keys()]
    return Look(WRONG, faults[0]) if faults else Look(RIGHT)


@cache
def entire(kind: Kind) -> dict:
    """All that was written."""
    return kind.reader(kind.source)


def same(one: object, other: object) -> bool:
    """Equal to the last bit."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and one.tobytes() == other.tobytes()
    return repr(one) == repr(other)


def attempt(kind: Kind, rng: random.Random, folder: Path) -> Look:
    """A look at a copy that is damaged."""
    way, copy = rng.choice(kind.ways), copied(kind, folder)
    text, compared = f"{way.__name__}, {way(folder / kind.damaged, rng)}", way in OF_FILES
    commands = (*kind.commands, *filter(None, [kind.ongoing]))
    if not commands or rng.random() > COMMANDS:
        return readings(kind, copy, compared)._replace(text=f"{text}: {kind.reader.__name__}")
    command = rng.choice(commands)
    if command == kind.ongoing:
        look = went_on(kind, copy, compared)
    else:
        look = commanded(command, copy, kind.source.parent, folder)
    return look._replace(text=f"{text}: {command}")


def attempts(seed: int, tries: int, files: dict[str, Kind], folder: Path) -> Iterator[Look]:
    """Looks at each kind in turn."""
    for i in range(tries):
        for name, kind in files.items():
            look = attempt(kind, random.Random(f"{seed} {name} {i}"), folder)
            yield look._replace(text=f"{name}, {look.text}")


# --- a worker that may hang
class Worker:
    """A process that looks; another one takes its place where it does not answer."""

    def __init__(self, root: Path):
        self.root, self.process = root, None

    def look(self, name: str, seed: str) -> Look:
        """A look at a kind of files."""
        if self.process is None:
            self._start()
        self.pipe.send((name, seed))
        try:
            if self.pipe.poll(LIMIT):
                return self.pipe.recv()
            look = Look(LATE, f"no answer in {LIMIT:g} s", seed)
        except EOFError:
            look = Look(RAISED, "the process has ended", seed)
        self.end()
        return look

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=answer, args=(other, self.root))
        self.process.start()
        other.close()
        self.pipe.recv()  # it is ready

    def end(self) -> None:
        """Kill the process."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.process = None


def answer(pipe, root: Path) -> None:
    """The life of a worker."""
    files = kinds(root)
    pipe.send("ready")
    with tempfile.TemporaryDirectory() as folder:
        while True:
            name, seed = pipe.recv()
            pipe.send(attempt(files[name], random.Random(seed), Path(folder)))


def table(counts: dict[str, Counter]) -> list[str]:
    """Rows of the table of counts."""
    outcomes = (RIGHT, REFUSED, *FAULTS)
    head = [f"| kind of file | tries | {' | '.join(outcomes)} |", "|---" * 7 + "|"]
    counts = counts | {"all": sum(counts.values(), Counter())}
    return head + [
        f"| {name} | {count.total()} | {' | '.join(str(count[o]) for o in outcomes)} |"
        for name, count in counts.items()
    ]


def parsed(arguments: list[str] | None = None) -> int:
    """Try damaged files; the exit status."""
    chosen = options(
        "damaged files, and what is made of them",
        arguments,
        names=([], "kinds of files (all)"),
        tries=(300, "of each kind (300)"),
        seed=(0, "of the damage"),
    )
    counts: dict[str, Counter] = {}
    with tempfile.TemporaryDirectory() as folder:
        files, worker = sources(Path(folder)), Worker(Path(folder))
        for name in chosen.names or files:
            counts[name] = Counter()
            for i in range(chosen.tries):
                look = worker.look(name, f"{chosen.seed} {name} {i}")
                counts[name][look.outcome] += 1
                if look.outcome in FAULTS:
                    print(f"{look.outcome}: {name}, {look.text}\n{look.fault}", flush=True)
            print(table(counts)[-2], flush=True)
        worker.end()
    if chosen.update:
        put(RESULTS, table(counts), BEGIN)
    return int(any(count[fault] for count in counts.values() for fault in FAULTS))


if __name__ == "__main__":
    sys.exit(parsed())
