"""Damaged and foreign files, many of them: what commands and readers make of each.

    python -m tests.benchmarks.damage [--cases 400] [--seed 0]

damages copies of a small result file, a sweep and measurements (flipped bits, cut short, parts
missing or of another kind) and has every command that reads such files look at them. A command must
state in one line what is wrong, or do its work; nothing may raise. No number may be read that was
not written. The exit status is 1 where something failed.
"""

import argparse
import contextlib
import io
import json
import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

import clearance as cl
from clearance.cli import main
from clearance.identify.bench import bench
from clearance.identify.records import Measurement, write

#: what reads a result file
OF_RUNS = (
    ("plot", "{}", "-o", "{out}.png"),
    ("plot", "{}", "history", "--channels", "C.force,slider.ax", "-o", "{out}.png"),
    ("plot", "{}", "orbit", "-o", "{out}.png"),
    ("plot", "{}", "phase", "-o", "{out}.png"),
    ("plot", "{}", "poincare", "--settle", "0", "-o", "{out}.png"),
    ("plot", "{}", "spectrum", "-o", "{out}.png"),
    ("plot", "{}", "contacts", "-o", "{out}.png"),
    ("plot", "{}", "efforts", "-o", "{out}.png"),
    ("plot", "{}", "sketch", "-o", "{out}.png"),
    ("plot", "{}", "animation", "--frames", "2", "-o", "{out}.gif"),
    ("film", "snapshots", "{}", "--count", "1", "--mesh", "16x2"),
    ("report", "{}", "-o", "{out}.html"),
)
#: what reads the directory of a sweep
OF_SWEEPS = (
    ("plot", "{}", "map", "--metrics", "slider_acceleration_max", "-o", "{out}.png"),
    ("plot", "{}", "curves", "--metrics", "slider_acceleration_max", "-o", "{out}.png"),
    (
        "plot",
        "{}",
        "bifurcation",
        "--x",
        "speed",
        "--at",
        "clearance=1e-4",
        "--channels",
        "C.gap",
        "-o",
        "{out}.png",
    ),
    ("report", "{}", "-o", "{out}.html"),
)
OF_MEASUREMENTS = (("identify", "--data", "{}", "--model", "curve", "-o", "{out}"),)
#: what takes any file for a case
OF_CASES = (
    ("run", "{}"),
    ("sweep", "{}", "-p", "speed=1,2", "-o", "{out}"),
    ("lyapunov", "{}"),
    ("explain", "{}"),
)

Damage = Callable[[Path, random.Random], str]


# --- ways to damage a file; each returns its name
def flip(path: Path, rng: random.Random) -> str:
    """One bit of a file."""
    content = bytearray(path.read_bytes())
    place, bit = rng.randrange(len(content)), rng.randrange(8)
    content[place] ^= 1 << bit
    path.write_bytes(content)
    return f"bit {bit} of byte {place}"


def cut(path: Path, rng: random.Random) -> str:
    """A file that ends early."""
    content = path.read_bytes()
    place = rng.randrange(len(content))
    path.write_bytes(content[:place])
    return f"cut at byte {place}"


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
        made = file.create_group(name) if value is None else file.create_dataset(name, data=value)
        made.attrs.update(attributes)
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
    place = rng.randrange(len(text))
    path.write_text(text[:place] + put + text[place:])
    return f"{put!r} at {place}"


OF_BYTES = (flip, cut)
OF_HDF5 = (*OF_BYTES, less_attributes, other_attribute, less_items, other_item, endless_item)


# --- what is damaged
def sources(folder: Path) -> dict[str, tuple[Path, str, tuple[Damage, ...], tuple]]:
    """Name -> file or folder to copy, file in it to damage, ways to damage it, commands that read
    it.
    """
    dry, wet = folder / "dry.h5", folder / "wet.h5"
    few = {"turns": 1.0, "samples_per_turn": 40}
    cl.simulate(cl.load_case("slider_crank", friction="coulomb"), path=dry, **few).close()
    cl.simulate(
        cl.load_case("slider_crank", model="lubricated", film="harmonic"), path=wet, **few
    ).close()
    points = cl.grid(speed=[20.0, 30.0], clearance=[1e-4, 2e-4])
    fixed = {"model": "lubricated", "film": "harmonic"}
    cl.sweep(
        "slider_crank",
        points,
        folder / "sweep",
        fixed=fixed,
        workers=1,
        turns=2.0,
        samples_per_turn=40,
    )
    trials = bench(seed=0).of("training").trials[:2]
    short = (
        replace(t, time=t.time[:300], rate=t.rate[:300], torque=t.torque[:300]) for t in trials
    )
    measurement = Measurement(tuple(short), {"bench": "none"})
    write(folder / "bench.h5", measurement)
    write(folder / "bench.csv", measurement)
    key = sorted(p.name for p in (folder / "sweep" / "runs").iterdir())[0]
    return {
        "dry run": (dry, "", (*OF_HDF5, other_scene), OF_RUNS),
        "lubricated run": (wet, "", (*OF_HDF5, other_scene), OF_RUNS),
        "sweep.h5": (folder / "sweep", "sweep.h5", OF_HDF5, OF_SWEEPS),
        "sweep.json": (folder / "sweep", "sweep.json", (*OF_BYTES, other_json), OF_SWEEPS),
        "journal.jsonl": (folder / "sweep", "journal.jsonl", (*OF_BYTES, other_json), OF_SWEEPS),
        "run of a sweep": (folder / "sweep", f"runs/{key}", OF_HDF5, OF_SWEEPS),
        "measurement": (folder / "bench.h5", "", OF_HDF5, OF_MEASUREMENTS),
        "CSV": (folder / "bench.csv", "", (*OF_BYTES, other_text), OF_MEASUREMENTS),
        "no case": (dry, "", OF_BYTES, OF_CASES),
    }


def damaged(
    source: Path, inside: str, damage: Damage, rng: random.Random, folder: Path
) -> tuple[Path, str]:
    """A damaged copy, and what was done to it."""
    copy = folder / source.name
    shutil.rmtree(copy) if copy.is_dir() else copy.unlink(missing_ok=True)
    shutil.copytree(source, copy) if source.is_dir() else shutil.copyfile(source, copy)
    if inside == "journal.jsonl" or inside.startswith("runs/"):
        (copy / "sweep.h5").unlink()  # else the index has it
    return copy, damage(copy / inside if inside else copy, rng)


# --- what is made of it
def printed(arguments: list[str]) -> str | None:
    """Fault in the end of a command; None where it did its work or gave one line with the
    reason.
    """
    out, err = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(arguments)
    except SystemExit as request:
        status = request.code
    except Exception:
        return traceback.format_exc(limit=-3)
    message = [line for line in err.getvalue().splitlines() if line.startswith("clearance:")]
    if status and (status not in (1, 2) or len(message) != 1 or len(message[0]) > 2000):
        return f"exit status {status}: {err.getvalue()[:500]!r}"
    return None


def numbers(path: Path) -> dict:
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


def unnoticed(path: Path, entire: dict) -> str | None:
    """A number that is read and was not written; None where there is none."""
    try:
        numbers_found = numbers(path)
    except (ValueError, OSError):
        return None
    if list(numbers_found) != list(entire):
        return f"there is {sorted(set(numbers_found) ^ set(entire))[:3]}"
    wrong = [
        name for name, value in numbers_found.items() if not np.array_equal(value, entire[name])
    ]
    return f"{wrong[0]} is another" if wrong else None


def attempts(seed: int, cases: int, files: dict, folder: Path) -> Iterator[tuple[str, str | None]]:
    """Label of each case, and what is wrong with how it ended."""
    rng, names = random.Random(seed), list(files)
    for i in range(cases):
        name = names[i % len(names)]
        source, inside, ways, commands = files[name]
        way = ways[(i // len(names)) % len(ways)]
        copy, did = damaged(source, inside, way, rng, folder)
        command = rng.choice(commands)
        arguments = [part.format(copy, out=folder / "out") for part in command]
        yield f"{name}, {way.__name__}, {did}: {' '.join(command)}", printed(arguments)


def flips(seed: int, cases: int, source: Path, folder: Path) -> Iterator[tuple[str, str | None]]:
    """Single bits of a result file: noticed, or without effect on its numbers."""
    rng, entire = random.Random(seed), numbers(source)
    for _ in range(cases):
        copy, did = damaged(source, "", flip, rng, folder)
        yield f"{did}: read", unnoticed(copy, entire)


def parsed(arguments: list[str] | None = None) -> int:
    """Try many cases and state which failed."""
    parser = argparse.ArgumentParser(description="damaged files, and what is made of them")
    parser.add_argument(
        "--cases", type=int, default=400, help="damaged files for commands, and flipped bits (400)"
    )
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    counts, failed = Counter(), 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "whole").mkdir()
        files = sources(folder / "whole")
        tried = [attempts(options.seed, options.cases, files, folder)]
        tried += [flips(options.seed, options.cases, files["dry run"][0], folder)]
        for results in tried:
            for label, wrong in results:
                counts[
                    label.partition(":")[0].partition(",")[0] if ", " in label else "flipped bits"
                ] += 1
                if wrong is not None:
                    failed += 1
                    print(f"FAILED {label}\n{wrong}", flush=True)
    print(
        f"{sum(counts.values())} cases, {failed} failed: "
        f"{', '.join(f'{n} {c}' for n, c in counts.items())}"
    )
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(parsed())
