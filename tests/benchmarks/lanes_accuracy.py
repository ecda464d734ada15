"""Errors of metrics in lanes and of the ordinary way: `python tests/benchmarks/lanes_accuracy.py
[--update] [--points N]`.

Random points of five scenes run both ways at rtol 1e-6, and alone at rtol 1e-11. The table has
relative errors of all metrics: the median, the quantile of 99 %, and the largest one. A number that
is zero has none. Deviations from ideal joints are small differences of large numbers; they have a
row of their own, too. `--points` is the number of points of each scene (default 40). A minute.
"""

import logging
import sys
from pathlib import Path

import numpy as np
from publishing import publish, require

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))

import clearance as cl  # noqa: E402
from clearance.metrics.of_points import of_point  # noqa: E402
from clearance.results.memory import Memory  # noqa: E402
from clearance.run.ideal_motion import ideal_motion  # noqa: E402
from clearance.run.recording import attributes_of, record_run  # noqa: E402
from clearance.scene.catalogue import find_case  # noqa: E402
from clearance.simulation import prepare  # noqa: E402
from clearance.sweeping.in_lanes import Together  # noqa: E402

MARK = "<!-- lanes accuracy table -->"
USUAL, EXACT = 1e-6, 1e-11
#: case, its fixed parameters, turns, and ranges of two numbers, spread by their logarithms
SCENES = {
    "feeder, B": ("six_bar_feeder", {"joints": "B"}, 2.0, {}),
    "feeder, B, C and E": ("six_bar_feeder", {"joints": "B,C,E"}, 2.0, {}),
    "feeder, B, film by formula": (
        "six_bar_feeder",
        {"joints": "B", "film": "pinkus_sternlicht"},
        3.0,
        {},
    ),
    "four-bar, C": ("four_bar", {}, 2.0, {"viscosity": (0.01, 0.2)}),
    "slider-crank, C": ("slider_crank", {}, 2.0, {"clearance": (1e-4, 3e-4)}),
}
RANGES = {"speed": (cl.rpm(60), cl.rpm(600)), "clearance": (2e-5, 5e-4)}
#: one table a clearance: fewer clearances than points
TABLES = {"slider_crank": 4}


def drawn(case: str, others: dict, count: int) -> dict[str, np.ndarray]:
    """Random points of a scene."""
    rng = np.random.default_rng(7)
    ranges = {"speed": RANGES["speed"], **(others or {"clearance": RANGES["clearance"]})}
    columns = {n: np.exp(rng.uniform(*np.log(ends), count)) for n, ends in ranges.items()}
    if case in TABLES:
        columns["clearance"] = np.resize(columns["clearance"][: TABLES[case]], count)
    return columns


def alone(scene, turns: float, rtol: float) -> dict[str, float]:
    """Metrics of a point run alone."""
    run = prepare(scene, turns=turns, rtol=rtol)
    sink = Memory(run.mechanism.layout.channels, attributes_of(run))
    if failure := record_run(run, sink):
        raise RuntimeError(failure)
    ideal = ideal_motion(run.mechanism.scene, run.span, sink.record.scene)
    return {n: m.value for n, m in of_point(sink.record, None, ideal).items()}


def errors(
    name: str, fixed: dict, turns: float, others: dict, count: int
) -> list[tuple[bool, float, float]]:
    """Of each metric: True for a deviation, its relative errors in lanes and the ordinary way."""
    case, columns, measured = find_case(name), drawn(name, others, count), []

    def scene(values: dict):
        return case.scene(model="lubricated", **fixed, **values)

    together = Together(scene, columns, {"turns": turns, "rtol": USUAL}, None)
    points = together.points(columns)
    answers = together.answers(points, 1)
    if not together.summing.sound(answers, points).all():
        raise RuntimeError("a point is not sound")
    metrics = together.summing.metrics(answers, points)
    made = [{name: values[i] for name, values in metrics.items()} for i in range(count)]
    for i in range(count):
        at = scene({n: column[i].item() for n, column in columns.items()})
        exact, usual = alone(at, turns, EXACT), alone(at, turns, USUAL)
        for metric, value in exact.items():
            if np.isfinite(value) and value != 0.0:
                both = (abs(way[metric] / value - 1.0) for way in (made[i], usual))
                measured.append(("deviation" in metric, *both))
    return measured


def table(count: int) -> list[str]:
    """Errors of each scene, and of all."""
    logging.getLogger("clearance").setLevel(logging.ERROR)
    lines = [
        "| scene | numbers | median in lanes | ordinary | 99 % in lanes | ordinary | largest in "
        "lanes | ordinary |",
        "|---|---|---|---|---|---|---|---|",
    ]
    measured = {name: np.array(errors(*scene, count)).T for name, scene in SCENES.items()}
    every = np.concatenate(list(measured.values()), axis=1)
    measured[f"all, {count * len(SCENES)} points"] = every
    measured["their deviations from ideal joints"] = every[:, every[0] > 0.0]
    measured["their other metrics"] = every[:, every[0] == 0.0]
    for name, (_, *both) in measured.items():
        numbers = [np.quantile(both, share, axis=1) for share in (0.5, 0.99, 1.0)]
        cells = " | ".join(f"{value:.1e}" for pair in numbers for value in pair)
        lines.append(f"| {name} | {len(both[0])} | {cells} |")
        if name.startswith("all"):
            for word, (lanes, ordinary) in (("median", numbers[0]), ("largest", numbers[2])):
                require(lanes <= ordinary, f"{word} of {name}: {lanes:.1e}, not {ordinary:.1e}")
    return lines


if __name__ == "__main__":
    publish(__doc__, lambda chosen: table(chosen.points), MARK, points=(40, "of each scene"))
