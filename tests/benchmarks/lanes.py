"""Sweeps in lanes against the ordinary way: `python tests/benchmarks/lanes.py [--update]`.

CPU seconds of a point, both ways measured in turn in one process, medians over rounds; then the
largest and the median error of the metrics at random points, against runs at rtol 1e-11. Set-up
(machine code, numbers of all points) is stated apart. One thread; the first metric table of a
structure is made before anything is measured.
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
from clearance.catalogue import find_case  # noqa: E402
from clearance.lanes.code import natural_width  # noqa: E402
from clearance.recording import MemorySink  # noqa: E402
from clearance.simulation import prepare  # noqa: E402
from clearance.sweeping import definition as definitions  # noqa: E402
from clearance.sweeping.driver import define  # noqa: E402
from clearance.sweeping.ideal import ideal_motion  # noqa: E402
from clearance.sweeping.peaks import of_point  # noqa: E402
from clearance.sweeping.together import Together  # noqa: E402
from clearance.sweeping.worker import run_point  # noqa: E402

MARK = "<!-- lanes table -->"
SCENES = {
    "B, 2 turns": ("B", 2.0, 400),
    "B, 20 turns": ("B", 20.0, 100),
    "B, C and E, 2 turns": ("B,C,E", 2.0, 100),
}
ORDINARY = 12  # points that are run the ordinary way
ROUNDS = 3
SPEEDS = (cl.rpm(60), cl.rpm(600))
CLEARANCES = (2e-5, 5e-4)
COMPARED = 16  # random points whose metrics are compared


class Sweep:
    """Points of the feeder, both ways."""

    def __init__(self, joints: str, turns: float, count: int):
        rng = np.random.default_rng(1)
        self.fixed, self.turns = {"model": "lubricated", "joints": joints}, turns
        self.speed = rng.uniform(*SPEEDS, count)
        self.clearance = np.exp(rng.uniform(*np.log(CLEARANCES), count))
        self.case = find_case("six_bar_feeder")
        began = time.process_time()
        columns = {"speed": self.speed, "clearance": self.clearance}
        options = {"turns": turns}
        self.together = Together(
            lambda values: self.case.scene(**self.fixed, **values), columns, options, None
        )
        self.set_up = time.process_time() - began

    def scene(self, i: int):
        """The scene of a point."""
        numbers = {"speed": float(self.speed[i]), "clearance": float(self.clearance[i])}
        return self.case.scene(**self.fixed, **numbers)

    def lanes(self) -> tuple[float, dict]:
        """CPU seconds of a point in lanes, and the metrics of all."""
        began, parts = time.process_time(), []
        for first in range(0, len(self.speed), self.together.block):
            places = slice(first, first + self.together.block)
            points = self.together.points({n: v[places] for n, v in self.together.columns.items()})
            answers = self.together.answers(points, 1)
            if not self.together.summing.sound(answers, points).all():
                raise RuntimeError("a point is not sound")
            parts.append(self.together.summing.metrics(answers, points))
        spent = time.process_time() - began
        return spent / len(self.speed), {n: np.concatenate([p[n] for p in parts]) for n in parts[0]}

    def ordinary(self, folder: str) -> float:
        """CPU seconds of a point as workers run it, without a file."""
        points = cl.zipped(speed=self.speed[:ORDINARY], clearance=self.clearance[:ORDINARY])
        defined = define(
            "six_bar_feeder", points, self.fixed, [], 0, None, (), {"turns": self.turns}
        )
        definitions.write(defined, Path(folder))
        stamp = definitions.digest(Path(folder) / "sweep.json")
        run_point(folder, stamp, 0)
        began = time.process_time()
        for i in range(ORDINARY):
            run_point(folder, stamp, i)
        return (time.process_time() - began) / ORDINARY

    def alone(self, i: int, rtol: float) -> dict[str, float]:
        """Metrics of a point run alone."""
        run = prepare(self.scene(i), turns=self.turns, rtol=rtol)
        sink = MemorySink(run.mechanism.layout.channels, run.attributes())
        run.record(sink)
        ideal = ideal_motion(run.mechanism.scene, run.span, sink.record.scene)
        return {n: m.value for n, m in of_point(sink.record, None, ideal).items()}


def errors(sweep: Sweep, result: dict) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors of all metrics at random points, in lanes and the ordinary way."""
    lanes, ordinary = [], []
    for i in np.random.default_rng(2).permutation(len(sweep.speed))[:COMPARED]:
        exact, usual = sweep.alone(i, 1e-11), sweep.alone(i, 1e-6)
        names = [n for n, v in exact.items() if np.isfinite(v) and v != 0.0]
        lanes += [abs(result[n][i] / exact[n] - 1.0) for n in names]
        ordinary += [abs(usual[n] / exact[n] - 1.0) for n in names]
    return np.array(lanes), np.array(ordinary)


def table() -> list[str]:
    """Costs and errors of all scenes."""
    logging.getLogger("clearance").setLevel(logging.ERROR)
    lines = [
        "| lubricated feeder | ordinary | in lanes | ratio | set-up | median error | ordinary | 99 "
        "% | ordinary |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, scene in SCENES.items():
        sweep, costs, result = Sweep(*scene), [], {}
        for _ in range(ROUNDS):
            with tempfile.TemporaryDirectory() as folder:
                usual = sweep.ordinary(folder)
            cost, result = sweep.lanes()
            costs.append((usual, cost))
        usual, cost = (statistics.median(c) for c in zip(*costs, strict=True))
        numbers = [
            f"{usual * 1e3:.1f} ms",
            f"{cost * 1e3:.2f} ms",
            f"{usual / cost:.1f}",
            f"{sweep.set_up:.1f} s",
        ]
        short = scene[1] <= 2.0  # the others would take the references minutes
        both = errors(sweep, result) if short else ()
        numbers += [f"{np.quantile(e, share):.1e}" for share in (0.5, 0.99) for e in both] or [
            "-"
        ] * 4
        lines.append(f"| {name} | {' | '.join(numbers)} |")
    return [*lines, "", f"Width of a register: {natural_width()} numbers."]


if __name__ == "__main__":
    publish(__doc__, table, MARK)
