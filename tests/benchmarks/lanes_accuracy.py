"""Errors of metrics in lanes and of the ordinary way: `python tests/benchmarks/lanes_accuracy.py
[--update] [--points N]`.

Random points of nine scenes run both ways, and alone at rtol 1e-11. The table has relative errors
of all metrics: the median, the quantile of 99 %, and the largest one. A number that is zero has
none. Deviations from ideal joints are small differences of large numbers; they have a row of their
own, too. Dry points count before their horizon: where rtol 1e-10 changes no metric by 1e-4.
`--points` is the number of points of each scene (default 200). Five minutes.
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
from clearance.results.recorder import Memory  # noqa: E402
from clearance.run.ideal_motion import ideal_motion  # noqa: E402
from clearance.run.recording import attributes_of, record_run  # noqa: E402
from clearance.scene.catalogue import find_case  # noqa: E402
from clearance.simulation import prepare  # noqa: E402
from clearance.sweeping.in_lanes import Together  # noqa: E402

MARK = "<!-- lanes accuracy table -->"
EXACT, CLOSE, ALIKE = 1e-11, 1e-10, 1e-4
WORSE = 1.25  # errors in lanes over those of the ordinary way, at most
FEEDER, CRANK, B = "six_bar_feeder", "slider_crank", {"joints": "B"}
FILM, MIXED, DRY = ({"model": model} for model in ("lubricated", "mixed", "dry"))
TURNS, ONE = {"turns": 2.0, "rtol": 1e-6}, {"turns": 1.0, "rtol": 1e-8}
SLOW = {"speed": (20.0, 60.0), "clearance": (1e-4, 5e-4)}
#: case, its fixed parameters, options of the runs, and ranges of two numbers, spread by their
#: logarithms
SCENES = {
    "feeder, B": (FEEDER, FILM | B, TURNS, {}),
    "feeder, B, C and E": (FEEDER, FILM | {"joints": "B,C,E"}, TURNS, {}),
    "feeder, B, film by formula": (
        FEEDER,
        FILM | B | {"film": "pinkus_sternlicht"},
        TURNS | {"turns": 3.0},
        {},
    ),
    "slider-crank, C": (CRANK, FILM, TURNS, {"clearance": (1e-4, 3e-4)}),
    "mixed feeder, B": (FEEDER, MIXED | B | {"viscosity": 0.005}, TURNS, {}),
    "dry feeder, B": (FEEDER, DRY | B, ONE, {"speed": (3.0, 10.0), "clearance": (1e-4, 5e-4)}),
    "dry slider-crank, C": (CRANK, DRY, ONE, SLOW),
    "dry slide with corners": (CRANK, DRY | {"joints": "guide"}, ONE, SLOW),
    "friction of ideal joints": (
        "three_loop_chain",
        {"drive": "torque", "where": "all"},
        {"until": 1.0, "rtol": 1e-8, "method": "dop853"},
        {"transition_rate": (1e-2, 1e-1), "coefficient": (0.02, 0.2)},
    ),
}
RANGES = {"speed": (cl.rpm(60), cl.rpm(600)), "clearance": (2e-5, 5e-4)}
#: one table a clearance: fewer clearances than points
TABLES = {"slider-crank, C": 4}


def drawn(name: str, others: dict, count: int) -> dict[str, np.ndarray]:
    """Random points of a scene."""
    rng = np.random.default_rng(7)
    ranges = others if len(others) > 1 else RANGES | others
    columns = {n: np.exp(rng.uniform(*np.log(ends), count)) for n, ends in ranges.items()}
    if name in TABLES:
        columns["clearance"] = np.resize(columns["clearance"][: TABLES[name]], count)
    return columns


def alone(scene, options: dict, rtol: float) -> dict[str, float]:
    """Metrics of a point run alone."""
    run = prepare(scene, **options | {"rtol": rtol})
    sink = Memory(run.mechanism.layout.channels, attributes_of(run))
    if failure := record_run(run, sink):
        raise RuntimeError(failure)
    ideal = ideal_motion(run.mechanism.scene, run.span, sink.record.scene)
    return {n: m.value for n, m in of_point(sink.record, None, ideal).items()}


def apart(metrics: dict[str, float], exact: dict[str, float]) -> dict[str, float]:
    """Relative errors of all metrics that are numbers and not zero."""
    there = {n: v for n, v in exact.items() if np.isfinite(v) and v != 0.0}
    return {n: abs(metrics[n] / v - 1.0) for n, v in there.items()}


def errors(
    name: str, case: str, fixed: dict, options: dict, others: dict, count: int
) -> tuple[int, list[tuple[bool, float, float]]]:
    """Number of points that count; of each metric True for a deviation, and its relative errors in
    lanes and the ordinary way.
    """
    columns, measured, counted = drawn(name, others, count), [], 0
    make, dry = find_case(case).scene, fixed.get("model") == "dry"
    together = Together(lambda v: make(**fixed, **v), columns, options, None)
    points = together.points(columns)
    answers = together.answers(points)
    sound = together.summing.sound(answers, points)
    require(bool(sound.all()) or dry, f"{name}: {(~sound).sum()} points are not sound")
    metrics = together.summing.metrics(answers, points)
    for i in np.flatnonzero(sound).tolist():
        at = make(**fixed, **{n: column[i].item() for n, column in columns.items()})
        exact = alone(at, options, EXACT)
        if dry and max(apart(alone(at, options, CLOSE), exact).values()) > ALIKE:
            continue
        ways = {n: values[i] for n, values in metrics.items()}, alone(at, options, options["rtol"])
        both = [apart(way, exact) for way in ways]
        measured += [("deviation" in n, *(way[n] for way in both)) for n in both[0]]
        counted += 1
    return counted, measured


def table(count: int) -> list[str]:
    """Errors of each scene, and of all."""
    logging.getLogger("clearance").setLevel(logging.ERROR)
    lines = [
        "| scene | numbers | median in lanes | ordinary | 99 % in lanes | ordinary | largest in "
        "lanes | ordinary |",
        "|---|---|---|---|---|---|---|---|",
    ]
    measured, points = {}, 0
    for name, scene in SCENES.items():
        counted, rows = errors(name, *scene, count)
        measured[f"{name}: {counted} points"] = np.array(rows).T
        points += counted
    every = np.concatenate(list(measured.values()), axis=1)
    measured[f"all, {points} points"] = every
    measured["their deviations from ideal joints"] = every[:, every[0] > 0.0]
    measured["their other metrics"] = every[:, every[0] == 0.0]
    for name, (_, *both) in measured.items():
        numbers = [np.quantile(both, share, axis=1) for share in (0.5, 0.99, 1.0)]
        cells = " | ".join(f"{value:.1e}" for pair in numbers for value in pair)
        lines.append(f"| {name} | {len(both[0])} | {cells} |")
        if name.startswith("their"):
            for word, (lanes, ordinary) in (("median", numbers[0]), ("largest", numbers[2])):
                text = f"{word} of {name}: {lanes:.1e}, not {ordinary:.1e}"
                require(lanes <= WORSE * ordinary, text)
    return lines


if __name__ == "__main__":
    publish(__doc__, lambda chosen: table(chosen.points), MARK, points=(200, "of each scene"))
