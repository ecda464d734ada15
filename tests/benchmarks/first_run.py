"""CPU seconds of starting: `python tests/benchmarks/first_run.py [--before CHECKOUT] [--update]`.

Fresh processes, their children counted, with a store and a numba cache of their own. --before:
another checkout, such as an older commit, which is measured first; without it the numbers that
stand in the table stay. --repeats: of all but the first run and the new structures, which are
measured once.
"""

import argparse
import compileall
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from publishing import RESULTS, put

MARK = "<!-- first run table -->"
END = "<!-- end -->"
HERE = Path(__file__).resolve().parent.parent.parent
README = ["six_bar_feeder", "-p", "model=mixed", "--turns", "6", "--plot"]
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
SECOND = """
import sys, time, statistics
import clearance as cl
from clearance.mechanism.build import build
case, more = sys.argv[1], eval(sys.argv[2])
times = []
for k in range(12):
    began = time.process_time()
    build(cl.load_case(case, clearance=(1.0 + 0.01 * k) * 1e-4, **more))
    times.append(time.process_time() - began)
print(statistics.median(times[2:]))
"""
CALLED = {
    "slider-crank, dry": ("slider_crank", {"model": "dry"}),
    "feeder, lubricated B": ("six_bar_feeder", {}),
    "feeder, lubricated B,C,E": ("six_bar_feeder", {"joints": "B,C,E"}),
}


class Checkout:
    """One checkout with an empty store."""

    def __init__(self, root: Path, folder: str, repeats: int):
        self.root, self.folder, self.repeats = root, Path(folder), repeats
        paths = {
            "PYTHONPATH": str(root),
            "CLEARANCE_STORE": f"{folder}/store",
            "NUMBA_CACHE_DIR": f"{folder}/numba",
        }
        self.environment = os.environ | paths
        compileall.compile_dir(root / "clearance", quiet=2)  # as pip does where it installs

    def cpu(self, *command: str) -> float:
        """User and system CPU seconds of a fresh process and its children."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, *command],
            check=True,
            capture_output=True,
            env=self.environment,
            cwd=self.folder,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def run(self, words: list[str]) -> float:
        """`clearance run` of a tenth of a turn, if not as given."""
        span = [] if "--turns" in words else SPAN.get(words[0], ["--turns", "0.1"])
        return self.cpu(
            "-m", "clearance.cli", "run", *words, *span, "-o", str(self.folder / "run.h5")
        )

    def median(self, measure) -> float:
        return statistics.median(measure() for _ in range(self.repeats))

    def second(self, case: str, more: dict) -> float:
        """Of a structure met before in the process, with other numbers [s]."""
        command = [sys.executable, "-c", SECOND, case, repr(more)]
        done = subprocess.run(
            command,
            check=True,
            capture_output=True,
            text=True,
            env=self.environment,
            cwd=self.folder,
        )
        return float(done.stdout)

    def numbers(self) -> dict[str, str]:
        """All rows."""
        result = {
            "`import clearance`": f"{self.median(lambda: self.cpu('-c', 'import clearance')):.2f} s"
        }
        result["first run of the README, empty store"] = f"{self.run(README):.1f} s"
        result["the same again"] = f"{self.median(lambda: self.run(README)):.2f} s"
        result["the same without `--plot`"] = f"{self.median(lambda: self.run(README[:-1])):.2f} s"
        for words in BEFORE_NEW:
            self.run(words)
        for name, words in NEW.items():
            result[f"new structure: {name}"] = f"{self.run(words):.2f} s"
        for name, (case, more) in CALLED.items():
            result[f"later `build` in one process: {name}"] = (
                f"{1e3 * self.second(case, more):.2f} ms"
            )
        return result


def measured(root: Path, repeats: int) -> dict[str, str]:
    with tempfile.TemporaryDirectory() as folder:
        return Checkout(root, folder, repeats).numbers()


def standing() -> dict[str, str]:
    """The numbers before, as the table has them."""
    lines = RESULTS.read_text().partition(MARK)[2].partition(END)[0].splitlines()
    cells = [[cell.strip() for cell in line.split("|")] for line in lines if line.startswith("|")]
    return {row[1]: row[2] for row in cells[2:]}


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--before", type=Path, help="a checkout to measure beside this one")
    options.add_argument("--repeats", type=int, default=3)
    options.add_argument(
        "--update", action="store_true", help=f"put the table into {RESULTS}, at the mark {MARK}"
    )
    chosen = options.parse_args()
    before = measured(chosen.before.resolve(), chosen.repeats) if chosen.before else standing()
    lines = ["| CPU of fresh processes | before (0c252a5) | now |", "|---|---|---|"]
    lines += [
        f"| {name} | {before.get(name, '-')} | {now} |"
        for name, now in measured(HERE, chosen.repeats).items()
    ]
    print("\n".join(lines))
    if chosen.update:
        put(RESULTS, lines, MARK, END)


if __name__ == "__main__":
    main()
