"""Sweeps in lanes against the ordinary way: `python tests/benchmarks/lanes.py [--update]`.

CPU seconds of a point, both ways measured in turn in one process, medians over rounds. Set-up
(machine code, numbers of all points) is stated apart. One thread; the first metric table of a
structure is made before anything is measured. lanes_accuracy.py has the errors of the metrics.
"""

import logging
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from publishing import publish

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))

import clearance as cl  # noqa: E402
from clearance.lanes.code import natural_width  # noqa: E402
from clearance.scene.catalogue import find_case  # noqa: E402
from clearance.sweeping import definition as definitions  # noqa: E402
from clearance.sweeping.in_lanes import Together  # noqa: E402
from clearance.sweeping.sweep import define  # noqa: E402
from clearance.sweeping.worker import run_point  # noqa: E402

MARK = "<!-- lanes table -->"
FEEDER = {"case": "six_bar_feeder"}
FILM, MIXED = FEEDER | {"model": "lubricated"}, FEEDER | {"model": "mixed", "viscosity": 0.005}
DRY, CRANK = FEEDER | {"model": "dry"}, {"case": "slider_crank", "model": "dry"}
OILED = CRANK | {"model": "lubricated", "film": "pinkus_sternlicht", "speed": 40.0}
#: least and largest values of what is swept, of the clearance their logarithms
NUMBERS = {"speed": (cl.rpm(60), cl.rpm(600)), "clearance": np.log([2e-5, 5e-4])}
LENGTHS = {"throw": (0.0495, 0.0505), "rod_length": (0.119, 0.121)}
SCENES = {
    "B, 2 turns": (FILM, "B", 2.0, 400),
    "B, 20 turns": (FILM, "B", 20.0, 100),
    "B, C and E, 2 turns": (FILM, "B,C,E", 2.0, 100),
    "B, 2 turns, stated errors": (FILM, "B", 2.0, 400, "state"),
    "B, 20 turns, stated errors": (FILM, "B", 20.0, 60, "state"),
    "mixed B, 2 turns": (MIXED, "B", 2.0, 400),
    "mixed B, 20 turns": (MIXED, "B", 20.0, 100),
    "mixed B, C and E, 2 turns": (MIXED, "B,C,E", 2.0, 100),
    "dry B, 2 turns": (DRY, "B", 2.0, 400),
    "dry slider-crank, C, 2 turns": (CRANK, "C", 2.0, 400),
    "its lengths, dry": (CRANK | {"speed": 40.0}, "C", 2.0, 400, None, LENGTHS),
    "its lengths, lubricated": (OILED, "C", 2.0, 400, None, LENGTHS),
}
ORDINARY = 36  # points that are run the ordinary way: dry ones differ in their contacts
ROUNDS = 3


class Sweep:
    """Points of a case, both ways."""

    def __init__(
        self,
        model: dict,
        joints: str,
        turns: float,
        count: int,
        error: str | None = None,
        numbers: dict = NUMBERS,
    ):
        rng, self.count = np.random.default_rng(1), count
        self.fixed, self.turns, self.error = model | {"joints": joints}, turns, error
        self.case = find_case(self.fixed.pop("case"))
        self.columns = {n: rng.uniform(*ends, count) for n, ends in numbers.items()}
        if "clearance" in numbers:
            self.columns["clearance"] = np.exp(self.columns["clearance"])
        began = time.process_time()
        self.together = Together(
            lambda values: self.case.scene(**self.fixed, **values),
            self.columns,
            {"turns": turns},
            None,
            error,
        )
        self.set_up = time.process_time() - began

    def lanes(self) -> float:
        """CPU seconds of a point in lanes."""
        began, together = time.process_time(), self.together
        for first in range(0, self.count, together.block):
            places = slice(first, first + together.block)
            columns = {n: v[places] for n, v in together.columns.items()}
            points = together.points(columns)
            answers = together.answers(points)
            if not together.summing.sound(answers, points).all():
                raise RuntimeError("a point is not sound")
            together.summing.metrics(answers, points)
            together.warnings(columns, answers, points)
            if self.error is not None:
                together.errors(columns, answers)
        return (time.process_time() - began) / self.count

    def ordinary(self, folder: str) -> float:
        """CPU seconds of a point as workers run it, without a file."""
        points = cl.zipped(**{n: v[:ORDINARY] for n, v in self.columns.items()})
        options = {"turns": self.turns, "error": self.error}
        defined = define(self.case.name, points, self.fixed, [], 0, None, (), options)
        definitions.write(defined, Path(folder))
        stamp = definitions.digest(Path(folder) / "sweep.json")
        run_point(folder, stamp, 0)
        began = time.process_time()
        for i in range(ORDINARY):
            run_point(folder, stamp, i)
        return (time.process_time() - began) / ORDINARY


def table() -> list[str]:
    """Costs and errors of all scenes."""
    logging.getLogger("clearance").setLevel(logging.ERROR)
    lines = [
        "| feeder | ordinary | in lanes | ratio | set-up |",
        "|---|---|---|---|---|",
    ]
    for name, scene in SCENES.items():
        sweep, costs = Sweep(*scene), []
        for _ in range(ROUNDS):
            with tempfile.TemporaryDirectory() as folder:
                costs.append((sweep.ordinary(folder), sweep.lanes()))
        usual, cost = (statistics.median(c) for c in zip(*costs, strict=True))
        numbers = f"{usual * 1e3:.1f} ms | {cost * 1e3:.2f} ms | {usual / cost:.1f}"
        lines.append(f"| {name} | {numbers} | {sweep.set_up:.1f} s |")
    return [*lines, "", f"Width of a register: {natural_width()} numbers."]


if __name__ == "__main__":
    publish(__doc__, table, MARK)
