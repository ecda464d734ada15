"""CPU seconds beside an older commit: `python tests/benchmarks/costs.py --before CHECKOUT
[--update]`.

Fresh processes, their children counted, each checkout with a store and a numba cache of its own.
The two take turns, and the one that begins alternates: a ratio is the median of those of the pairs,
which other work on the machine hardly changes. Pieces of a process, such as a loop, are the least
of several in it. Where the store must be empty there are fewer pairs. Without --before: seconds
alone. `--only WORD` takes the rows that have the word.
"""

import compileall
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from publishing import publish

MARK = "<!-- cost table -->"
HERE = Path(__file__).resolve().parent.parent.parent
README = ["six_bar_feeder", "-p", "model=mixed", "--turns", "6", "--plot"]
MIXED = {"model": "mixed"}
#: structures that compile the steppers, so that the new ones below do not
BEFORE_NEW = (["six_bar_feeder", "-p", "model=dry"], ["six_bar_feeder", "-p", "model=lubricated"])
NEW = {
    "slider-crank, dry": ["slider_crank", "-p", "model=dry"],
    "slider-crank, lubricated": ["slider_crank", "-p", "model=lubricated"],
    "feeder, mixed B,C,E": ["six_bar_feeder", "-p", "model=mixed", "-p", "joints=B,C,E"],
    "four-bar, friction": ["four_bar", "-p", "model=dry", "-p", "friction=stribeck"],
    "double pendulum": ["double_pendulum"],
}
SPAN = {"double_pendulum": ["--until", "0.1"]}
REPEATS = 8
#: a piece of the work on a case, with values and a span: the least CPU of several, once warm
PIECE = f"""
import sys, time
import clearance as cl
from clearance.mechanism.build import build
from clearance.simulation import prepare
piece, case, values, span = eval(sys.argv[1])
count = 0

def scene():
    return cl.load_case(case, **values)

def another():  # of a structure that the process knows, at another position
    return cl.load_case(case, clearance=(1.0 + 0.01 * count) * 1e-4, **values)

def loop():
    run = prepare(scene(), **span)
    run.trajectory()
    return run.cpu

def timed(work, *arguments):
    began = time.process_time()
    work(*arguments)
    return time.process_time() - began

def read(path):
    with cl.open_result(path) as result:
        result.time, result["crank"].omega, result.scene, result.warnings

if piece == "read":
    cl.simulate(scene(), path="read.h5", **span).close()
pieces = {{
    "loop": loop,
    "scene": lambda: timed(scene),
    "build": lambda: timed(build, another()),
    "simulate": lambda: timed(lambda: cl.simulate(another(), error=None, **span)),
    "read": lambda: timed(read, "read.h5"),
}}
times = []
for count in range({REPEATS} if piece == "loop" else {5 * REPEATS}):
    times.append(pieces[piece]())
print(min(times[1:]))
"""
TURN = {"turns": 1.0}
#: rows: piece, case, values, span
PIECES = {
    "loop: slider-crank, dry": ("loop", "slider_crank", {"model": "dry"}, {"turns": 20}),
    "loop: slider-crank, lubricated": (
        "loop",
        "slider_crank",
        {"model": "lubricated"},
        {"turns": 20},
    ),
    "loop: feeder, dry B": ("loop", "six_bar_feeder", {"model": "dry"}, {"turns": 10}),
    "loop: feeder, lubricated B": ("loop", "six_bar_feeder", {}, {"turns": 10}),
    "loop: feeder, mixed B": ("loop", "six_bar_feeder", MIXED, {"turns": 10}),
    "loop: feeder, mixed B,C,E": (
        "loop",
        "six_bar_feeder",
        MIXED | {"joints": "B,C,E"},
        {"turns": 5},
    ),
    "loop: feeder, mixed B, load sharing": (
        "loop",
        "six_bar_feeder",
        MIXED | {"transition": "load_sharing"},
        {"turns": 10},
    ),
    "loop: guide, dry": ("loop", "guide_slider", {}, {"until": 0.5}),
    "loop: chain, coulomb": ("loop", "five_axis_chain", {}, {"until": 5.0}),
    "loop: chain, stribeck": ("loop", "five_axis_chain", {"friction": "stribeck"}, {"until": 5.0}),
    "loop: four-bar, stribeck": (
        "loop",
        "four_bar",
        {"model": "dry", "friction": "stribeck"},
        {"turns": 10},
    ),
    "scene of a case: slider-crank": ("scene", "slider_crank", {}, TURN),
    "later `build`: slider-crank, dry": ("build", "slider_crank", {"model": "dry"}, TURN),
    "later `build`: feeder, lubricated B": ("build", "six_bar_feeder", {}, TURN),
    "later `build`: feeder, lubricated B,C,E": (
        "build",
        "six_bar_feeder",
        {"joints": "B,C,E"},
        TURN,
    ),
    "`simulate`, a turn: slider-crank, dry": ("simulate", "slider_crank", {"model": "dry"}, TURN),
    "`simulate`, a turn: feeder, lubricated B": ("simulate", "six_bar_feeder", {}, TURN),
    "`simulate`, a turn: feeder, mixed B": ("simulate", "six_bar_feeder", MIXED, TURN),
    "file opened, two channels and the scene read": ("read", "six_bar_feeder", MIXED, TURN),
}
SWEEP = """
import sys
import numpy as np
import clearance as cl
values, side, folder = eval(sys.argv[1])
points = cl.grid(speed=np.linspace(20.0, 60.0, side), clearance=np.geomspace(5e-5, 5e-4, side))
cl.sweep("six_bar_feeder", points, folder, fixed=values, channels=[], workers=1, turns=2.0)
"""
SWEEPS = {
    "sweep: lubricated B, 400 points": ({"model": "lubricated"}, 20),
    "sweep: mixed B, 100 points": (MIXED, 10),
    "sweep: dry B, 100 points": ({"model": "dry"}, 10),
}


class Checkout:
    """One checkout with an empty store."""

    def __init__(self, root: Path, folder: str):
        self.root, self.folder, self.count = root, Path(folder), 0
        paths = {
            "PYTHONPATH": str(root),
            "CLEARANCE_STORE": f"{folder}/store",
            "NUMBA_CACHE_DIR": f"{folder}/numba",
        }
        self.environment = os.environ | paths
        compileall.compile_dir(root / "clearance", quiet=2)  # as pip does where it installs

    def done(self, *command: str) -> str:
        """Output of a fresh process."""
        return subprocess.run(
            [sys.executable, *command],
            check=True,
            capture_output=True,
            text=True,
            env=self.environment,
            cwd=self.folder,
        ).stdout

    def cpu(self, *command: str) -> float:
        """User and system CPU seconds of a fresh process and its children."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.done(*command)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def run(self, words: list[str]) -> float:
        """`clearance run` of a tenth of a turn, if not as given."""
        span = [] if "--turns" in words else SPAN.get(words[0], ["--turns", "0.1"])
        result = str(self.folder / "run.h5")
        return self.cpu("-m", "clearance.cli", "run", *words, *span, "-o", result)

    def piece(self, *piece) -> float:
        """Least CPU seconds of a piece in one process."""
        return float(self.done("-c", PIECE, repr(piece)))

    def sweep(self, values: dict, side: int) -> float:
        """A sweep into a new folder."""
        self.count += 1
        return self.cpu("-c", SWEEP, repr((values, side, f"sweep{self.count}")))


Row = Callable[[Checkout], float]
#: rows of an empty store, in this order
COLD: dict[str, Row] = {
    "first run of the README, empty store": lambda one: one.run(README),
    **{" ".join(w): partial(Checkout.run, words=w) for w in BEFORE_NEW},
    **{f"new structure: {n}": partial(Checkout.run, words=w) for n, w in NEW.items()},
}
WARM: dict[str, Row] = {
    "`import clearance`": lambda one: one.cpu("-c", "import clearance"),
    "`clearance --help`": lambda one: one.cpu("-m", "clearance.cli", "--help"),
    "first run of the README again": lambda one: one.run(README),
    "the same without `--plot`": lambda one: one.run(README[:-1]),
    **{n: (lambda one, p=p: one.piece(*p)) for n, p in PIECES.items()},
    **{n: (lambda one, s=s: one.sweep(*s)) for n, s in SWEEPS.items()},
}


def paired(rows: dict[str, Row], checkouts: list[Checkout], turn: int) -> dict[str, list[float]]:
    """Seconds of each row of each checkout; the first one begins in even turns."""
    order = checkouts[:: -1 if turn % 2 else 1]
    seconds = {}
    for name, measure in rows.items():
        each = {one.root: measure(one) for one in order}
        seconds[name] = [each[one.root] for one in checkouts]
        print(name, *(f"{s:.4g}" for s in seconds[name]), file=sys.stderr, flush=True)
    return seconds


def measured(roots: list[Path], pairs: int, cold: int, word: str) -> dict[str, list[list[float]]]:
    """All pairs of seconds of each row; the first pair with a warm store is not counted."""
    chosen = {n: r for n, r in WARM.items() if word in n}
    result: dict[str, list[list[float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(cold):
            every = [Checkout(r, tempfile.mkdtemp(dir=folder)) for r in roots]
            for name, seconds in paired(COLD, every, turn).items():
                if name.startswith(("first", "new")):
                    result.setdefault(name, []).append(seconds)
        every = [Checkout(r, tempfile.mkdtemp(dir=folder)) for r in roots]
        for turn in range(pairs + 1):
            for name, seconds in paired(chosen, every, turn).items():
                if turn:
                    result.setdefault(name, []).append(seconds)
    return result


def shown(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds >= 0.1 else f"{1e3 * seconds:.3g} ms"


def lines(roots: list[Path], result: dict[str, list[list[float]]]) -> list[str]:
    """The table."""
    heads = [*(f"before ({_commit(r)})" for r in roots[:-1]), "now"]
    ratios = ["ratio", "from, to"] if len(roots) > 1 else []
    text = ["| CPU | " + " | ".join(heads + ratios) + " |"]
    text.append("|---" * (1 + len(heads + ratios)) + "|")
    for name, pairs in result.items():
        cells = [shown(statistics.median(times)) for times in zip(*pairs, strict=True)]
        if ratios:
            each = sorted(now / before for before, now in pairs)
            cells += [f"{statistics.median(each):.2f}", f"{each[0]:.2f}, {each[-1]:.2f}"]
        text.append(f"| {name} | " + " | ".join(cells) + " |")
    return text


def _commit(root: Path) -> str:
    command = ["git", "-C", str(root), "rev-parse", "--short=7", "HEAD"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def table(chosen) -> list[str]:
    """Costs of this checkout, and of another one beside it."""
    roots = [*([chosen.before.resolve()] if chosen.before else []), HERE]
    return lines(roots, measured(roots, chosen.pairs, chosen.cold, chosen.only))


if __name__ == "__main__":
    publish(
        __doc__,
        table,
        MARK,
        before=(Path, "a checkout to measure beside this one"),
        pairs=(7, "with a warm store"),
        cold=(3, "pairs with an empty store"),
        only=("", "rows with this word"),
    )
