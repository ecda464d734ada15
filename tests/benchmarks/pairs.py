"""This code beside an earlier commit: `python tests/benchmarks/pairs.py COMMIT [--update]`.

The table of a commit stands at a mark of its own, `<!-- costs beside COMMIT -->`.

COMMIT: a commit of this repository, which is checked out beside it, or the folder of a checkout.
Some fifty workloads: bare loops, calls, points of every model and way, commands, memory, imports,
sizes of files; ratios within this code. CPU seconds of fresh processes, their children counted,
each checkout with a store and a numba cache of its own. The two take turns, and the one that begins
alternates. A ratio is the median of before over now of the pairs, which other work on the machine
hardly changes. Pieces of a process, such as a loop, are the least of several in it, with all
kernels that many steps pay for. Where the store must be empty there are fewer pairs. What the
earlier commit does not have is left out. It ends with status 1 where a ratio is below --least.
`--only WORDS` takes the rows that have one of the words, between commas. Without COMMIT: seconds
alone.
"""

import ctypes
import math
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from publishing import publish, require

#: of the table beside a commit
MARK = f"<!-- {' '.join(['costs beside', *sys.argv[1:2]])} -->"
HERE = Path(__file__).resolve().parent.parent.parent
#: what a copy of a checkout does without: an installation would leave its parts there
BESIDE = (".git", ".venv", "build", "*.egg-info", "__pycache__", ".*_cache")
README = ["six_bar_feeder", "-p", "model=mixed", "--turns", "6", "--plot"]
MIXED, LUBRICATED = {"model": "mixed"}, {"model": "lubricated"}
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
#: PR_SET_CHILD_SUBREAPER of Linux: processes whose parent has ended become children of this one
ADOPT = 36
#: a piece of the work on a case, with values and a span: the least CPU of several, once warm
PIECE = f"""
import sys, time
import inspect
from contextlib import suppress
import clearance as cl
from clearance.simulation import prepare
piece, case, values, span = eval(sys.argv[1])
count = 0
#: no errors are stated, in versions that state some
quick = {{"error": None}} if "error" in inspect.signature(cl.simulate).parameters else {{}}

def scene():
    return cl.load_case(case, **values)

same = scene()
with suppress(AttributeError):  # as after many steps: kernels of several moments are compiled
    hot = prepare(same, **span).mechanism.structure.compiled
    hot.steps += 10**9

def another():  # of a structure that the process knows, at another position
    return cl.load_case(case, clearance=(1.0 + 0.01 * count) * 1e-4, **values)

def loop():  # by CPU: a run to its end, without its record
    return timed(prepare(scene(), **span).go)

def loops():  # of chaotic motions: several, for two codes have other impacts in each
    global count
    total = 0.0
    for count in range(20, 28):
        total += timed(prepare(another(), **span).go)
    return total / 8

def whole():  # a call without samples, of a scene that the process knows
    return timed(lambda: cl.simulate(same, **quick, **span, rtol=1e-3, samples=2))

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
    "loops": loops,
    "scene": lambda: timed(scene),
    "prepare": lambda: timed(lambda: prepare(another(), **span)),
    "simulate": lambda: timed(lambda: cl.simulate(another(), **quick, **span)),
    "whole": whole,
    "read": lambda: timed(read, "read.h5"),
}}
times = []
for count in range({REPEATS} if piece.startswith("loop") else {5 * REPEATS}):
    times.append(pieces[piece]())
print(min(times[1:]))
"""
TURN = {"turns": 1.0}
#: rows: piece, case, values, span
PIECES = {
    "loop: slider-crank, dry": ("loops", "slider_crank", {"model": "dry"}, {"turns": 20}),
    "loop: slider-crank, lubricated": (
        "loop",
        "slider_crank",
        {"model": "lubricated"},
        {"turns": 20},
    ),
    "loop: feeder, dry B": ("loops", "six_bar_feeder", {"model": "dry"}, {"turns": 10}),
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
    "later `prepare`: slider-crank, dry": ("prepare", "slider_crank", {"model": "dry"}, TURN),
    "later `prepare`: feeder, lubricated B": ("prepare", "six_bar_feeder", {}, TURN),
    "later `prepare`: feeder, lubricated B,C,E": (
        "prepare",
        "six_bar_feeder",
        {"joints": "B,C,E"},
        TURN,
    ),
    "`simulate`, a turn: slider-crank, dry": ("simulate", "slider_crank", {"model": "dry"}, TURN),
    "`simulate`, a turn: feeder, lubricated B": ("simulate", "six_bar_feeder", {}, TURN),
    "`simulate`, a turn: feeder, mixed B": ("simulate", "six_bar_feeder", MIXED, TURN),
    "`simulate` without samples, a turn at 1e-3: slider-crank, lubricated": (
        "whole",
        "slider_crank",
        LUBRICATED,
        TURN,
    ),
    "`simulate` without samples, a turn at 1e-3: feeder, lubricated B": (
        "whole",
        "six_bar_feeder",
        {},
        TURN,
    ),
    "file opened, two channels and the scene read": ("read", "six_bar_feeder", MIXED, TURN),
}
#: it prints wall seconds and the mean steps of a point
SWEEP = """
import sys, time
import numpy as np
import clearance as cl
values, side, turns, workers, folder = eval(sys.argv[1])
case = values.pop("case", "six_bar_feeder")
points = cl.grid(speed=np.linspace(20.0, 60.0, side), clearance=np.geomspace(5e-5, 5e-4, side))
options = {"workers": workers, "turns": turns}
began = time.perf_counter()
done = cl.sweep(case, points, folder, fixed=values, channels=[], **options)
print(time.perf_counter() - began, np.mean(getattr(done, "costs", {}).get("steps", 0.0)))
"""
#: points that fill a rectangle, by chance or as a grid
FILLED = """
import sys
import numpy as np
import clearance as cl
way, values, turns, folder = eval(sys.argv[1])
options = {"fixed": values, "workers": 1, "turns": turns}
if way == "grid":
    points = cl.grid(speed=np.linspace(20.0, 60.0, 16), clearance=np.linspace(5e-5, 5e-4, 16))
    cl.sweep("six_bar_feeder", points, folder, channels=[], **options)
else:
    spread = {"speed": "uniform(20, 60)", "clearance": "uniform(50um, 500um)"}
    cl.scatter("six_bar_feeder", spread, folder, points=256, **options)
"""
THIN, BCE = MIXED | {"viscosity": 0.005}, {"joints": "B,C,E"}
FEW, MANY = 10, 20  # points of a side of two sweeps, whose difference is that of their points
#: rows: values, points of a side of the grid, turns
SWEEPS = {
    "sweep: lubricated B, 400 points": (LUBRICATED, 20, 2.0),
    "sweep: lubricated B, 100 points, 20 turns": (LUBRICATED, 10, 20.0),
    "sweep: lubricated B,C,E, 100 points": (LUBRICATED | BCE, 10, 2.0),
    "sweep: mixed B, 400 points": (THIN, 20, 2.0),
    "sweep: mixed B, 100 points, 20 turns": (THIN, 10, 20.0),
    "sweep: mixed B,C,E, 100 points": (THIN | BCE, 10, 2.0),
    "sweep: dry B, 100 points": ({"model": "dry"}, 10, 2.0),
}
#: values, turns
POINTS = {
    "lubricated B": (LUBRICATED, 2.0),
    "lubricated B, 20 turns": (LUBRICATED, 20.0),
    "lubricated B,C,E": (LUBRICATED | BCE, 2.0),
    "mixed B": (THIN, 2.0),
    "mixed B, 20 turns": (THIN, 20.0),
    "mixed B,C,E": (THIN | BCE, 2.0),
    "dry B": ({"model": "dry"}, 2.0),
    "dry slider-crank": ({"case": "slider_crank", "model": "dry"}, 2.0),
}
#: those whose wall times with one worker and with two are compared: seconds of the loop each
WORKERS = {
    "film": (LUBRICATED, 100, 2.0),
    "mixed": (THIN, 40, 2.0),
    "dry": ({"model": "dry"}, 26, 2.0),
}

MEMORY = """
import resource, sys
import clearance as cl
turns, options = eval(sys.argv[1])
cl.simulate(cl.load_case("six_bar_feeder"), turns=turns, path="long.h5", **options)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)
"""


class Checkout:
    """One checkout, installed beside the packages of this Python, with an empty store."""

    def __init__(self, root: Path, folder: str):
        self.root, self.folder, self.count = root, Path(folder), 0
        site, source = str(self.folder / "site"), self.folder / "source"
        shutil.copytree(root, source, ignore=shutil.ignore_patterns(*BESIDE))
        pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation"]
        subprocess.run([*pip, "--target", site, str(source)], check=True, capture_output=True)
        paths = {
            "PYTHONPATH": site,
            "CLEARANCE_STORE": f"{folder}/store",
            "NUMBA_CACHE_DIR": f"{folder}/numba",
        }
        self.environment = os.environ | paths
        # modules are read compiled, as users read them
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)

    def done(self, *command: str) -> str:
        """Output of a fresh process.

        Workers of a server of processes outlive their parent; this process adopts and awaits them.
        """
        try:
            return subprocess.run(
                [sys.executable, *command],
                check=True,
                capture_output=True,
                text=True,
                env=self.environment,
                cwd=self.folder,
            ).stdout
        finally:
            with suppress(ChildProcessError):
                while True:
                    os.wait()

    def cpu(self, *command: str) -> float:
        """User and system CPU seconds of a fresh process and of all that it began."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.done(*command)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def run(self, words: list[str]) -> float:
        """`clearance run` of a tenth of a turn, if not as given."""
        span = [] if "--turns" in words else SPAN.get(words[0], ["--turns", "0.1"])
        result = str(self.folder / "run.h5")
        return self.cpu("-m", "clearance.cli", "run", *words, *span, "-o", result)

    def report(self) -> float:
        """A page of a result."""
        words = ["run", "six_bar_feeder", "--turns", "6", "-o", "six.h5"]
        if not (self.folder / "six.h5").exists():
            self.done("-m", "clearance.cli", *words)
        return self.cpu("-m", "clearance.cli", "report", "six.h5", "-o", "six.html")

    def piece(self, *piece) -> float:
        """Least CPU seconds of a piece in one process."""
        return float(self.done("-c", PIECE, repr(piece)))

    def sweep(self, values: dict, side: int, turns: float) -> float:
        """A sweep into a new folder."""
        self.count += 1
        return self.cpu("-c", SWEEP, repr((values, side, turns, 1, f"sweep{self.count}")))

    def point(self, values: dict, turns: float) -> float:
        """CPU of one point more, from sweeps of two sizes: without what all of a size share."""
        fewer, more = (self.sweep(values, n, turns) for n in (FEW, MANY))
        return (more - fewer) / (MANY**2 - FEW**2)

    def swept(self, values: dict, side: int, turns: float, workers: int = 1) -> list[float]:
        """Wall seconds of a sweep into a new folder, and mean steps of its points."""
        self.count += 1
        about = values, side, turns, workers, f"sweep{self.count}"
        return [float(word) for word in self.done("-c", SWEEP, repr(about)).split()]

    def workers(self, *sweep) -> float:
        """Wall time with one worker over that with two: the machine must have nothing beside."""
        return self.swept(*sweep, 1)[0] / self.swept(*sweep, 2)[0]

    def step(self, values: dict, turns: float) -> float:
        """CPU seconds of a step of a point, without what all points of a sweep share."""
        return self.point(values, turns) / self.swept(values, MANY, turns)[1]

    def scatter(self, values: dict, turns: float) -> float:
        """256 random points over a grid of as many, by CPU."""
        self.count += 1
        random, grid = (
            self.cpu("-c", FILLED, repr((way, values, turns, f"{way}{self.count}")))
            for way in ("random", "grid")
        )
        return random / grid

    def life(self, case: str, turns: int) -> float:
        """A life in a new folder."""
        self.count += 1
        words = ["wear", case, "--turns", str(turns), "-o", f"life{self.count}"]
        return self.cpu("-m", "clearance.cli", *words)

    def memory(self, turns: int, **options) -> float:
        """Largest memory of a lubricated run [MB]."""
        return float(self.done("-c", MEMORY, repr((turns, options))))

    def size(self, values: dict) -> float:
        """Size of the file of a run of two turns [MB]."""
        words = [w for n, v in values.items() for w in ("-p", f"{n}={v}")]
        self.run(["six_bar_feeder", *words, "--turns", "2"])
        return (self.folder / "run.h5").stat().st_size / 1e6


Row = Callable[[Checkout], float]
#: ratios within this code
WITHIN: dict[str, Row] = {
    **{
        f"one worker over two, wall: {n}": (lambda one, s=s: one.workers(*s))
        for n, s in WORKERS.items()
    },
    "a step of a mixed point over a film-only one": lambda one: (
        one.step(THIN, 20.0) / one.step(LUBRICATED, 20.0)
    ),
    "scatter over a grid, 256 mixed points": lambda one: one.scatter(THIN, 2.0),
}


def _ours(checkout: Checkout, measure: Row) -> float:
    return measure(checkout) if checkout.root == HERE else math.nan


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
    "report of six feeder turns": lambda one: one.report(),
    **{n: (lambda one, p=p: one.piece(*p)) for n, p in PIECES.items()},
    **{n: (lambda one, s=s: one.sweep(*s)) for n, s in SWEEPS.items()},
    **{f"a point: {n}": (lambda one, p=p: one.point(*p)) for n, p in POINTS.items()},
    **{f"{n} [times]": (lambda one, r=r: _ours(one, r)) for n, r in WITHIN.items()},
    "life: 4000 turns of `wear_a`": lambda one: one.life("wear_a", 4000),
    "memory of 200 lubricated turns [MB]": lambda one: one.memory(200),
    "memory of 1000 lubricated turns [MB]": lambda one: one.memory(1000),
    "memory of 4000 lubricated turns, 50 samples each [MB]": partial(
        Checkout.memory, turns=4000, samples_per_turn=50
    ),
    "file of two mixed turns [MB]": lambda one: one.size(MIXED),
}


def attempted(measure: Row, checkout: Checkout) -> float:
    """The number of a row; not a number where an earlier commit cannot do it."""
    try:
        return measure(checkout)
    except subprocess.CalledProcessError as error:
        if checkout.root == HERE:
            print(error.stderr, file=sys.stderr)
            raise
        return math.nan


def paired(rows: dict[str, Row], checkouts: list[Checkout], turn: int) -> dict[str, list[float]]:
    """Seconds of each row of each checkout; the first one begins in even turns."""
    order = checkouts[:: -1 if turn % 2 else 1]
    seconds = {}
    for name, measure in rows.items():
        each = {one.root: attempted(measure, one) for one in order}
        seconds[name] = [each[one.root] for one in checkouts]
        print(name, *(f"{s:.4g}" for s in seconds[name]), file=sys.stderr, flush=True)
    return seconds


def measured(
    roots: list[Path], pairs: int, cold: int, words: list[str]
) -> dict[str, list[list[float]]]:
    """All pairs of seconds of each row; the first pair with a warm store is not counted."""
    warm, chilly = (
        {n: r for n, r in rows.items() if any(word in n for word in words)} for rows in (WARM, COLD)
    )
    result: dict[str, list[list[float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(cold):
            every = [Checkout(r, tempfile.mkdtemp(dir=folder)) for r in roots]
            for name, seconds in paired(COLD if chilly else {}, every, turn).items():
                if name.startswith(("first", "new")) and name in chilly:
                    result.setdefault(name, []).append(seconds)
        every = [Checkout(r, tempfile.mkdtemp(dir=folder)) for r in roots]
        for turn in range(pairs + 1):
            for name, seconds in paired(warm, every, turn).items():
                if turn:
                    result.setdefault(name, []).append(seconds)
    return result


def shown(name: str, number: float) -> str:
    """A number with its unit, that of the row or a time."""
    if math.isnan(number):
        return "-"
    if name.endswith("]"):
        return f"{number:.3g}"
    return f"{number:.3g} s" if number >= 0.1 else f"{1e3 * number:.3g} ms"


def ratios(result: dict[str, list[list[float]]]) -> dict[str, list[float]]:
    """Before over now of each pair, from the least on, of rows that both have."""
    pairs = {n: sorted(a / b for a, b in p if a == a) for n, p in result.items() if len(p[0]) > 1}
    return {name: each for name, each in pairs.items() if each}


def lines(roots: list[Path], result: dict[str, list[list[float]]]) -> list[str]:
    """The table."""
    heads = [*(f"before ({_commit(r)})" for r in roots[:-1]), "now"]
    heads += ["before / now", "from, to"] if len(roots) > 1 else []
    text, of_pairs = ["| work, CPU | " + " | ".join(heads) + " |"], ratios(result)
    text.append("|---" * (1 + len(heads)) + "|")
    for name, pairs in result.items():
        cells = [shown(name, statistics.median(n)) for n in zip(*pairs, strict=True)]
        if len(roots) > 1:
            each = of_pairs.get(name)
            middle = f"{statistics.median(each):.2f}" if each else "-"
            cells += [middle, f"{each[0]:.2f}, {each[-1]:.2f}" if each else ""]
        text.append(f"| {name} | " + " | ".join(cells) + " |")
    return text


@contextmanager
def checked_out(commit: str, folder: str) -> Iterator[Path]:
    """A checkout of a commit, or the folder itself."""
    if Path(commit).is_dir():
        yield Path(commit).resolve()
        return
    root = Path(folder) / commit
    git = ["git", "-C", str(HERE), "worktree"]
    subprocess.run([*git, "add", "--detach", str(root), commit], check=True, capture_output=True)
    try:
        yield root
    finally:
        subprocess.run([*git, "remove", "--force", str(root)], check=True)


def _commit(root: Path) -> str:
    command = ["git", "-C", str(root), "rev-parse", "--short=7", "HEAD"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def table(chosen) -> list[str]:
    """Work of this code, and of an earlier one beside it; ratios below the least are missed."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(ADOPT, 1)
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        roots = [stack.enter_context(checked_out(n, folder)) for n in chosen.names[:1]] + [HERE]
        result = measured(roots, chosen.pairs, chosen.cold, chosen.only.split(","))
        text = lines(roots, result)
    for name, each in ratios(result).items():
        middle = statistics.median(each)
        require(middle >= chosen.least, f"{name}: {middle:.2f}")
    return text


if __name__ == "__main__":
    publish(
        __doc__,
        table,
        MARK,
        names=([], "commit, or folder of a checkout, to measure beside this code"),
        pairs=(7, "with a warm store"),
        cold=(3, "pairs with an empty store"),
        only=("", "words, between commas: rows with one of them"),
        least=(0.95, "ratio that is no failure"),
    )
