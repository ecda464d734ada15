"""`clearance sweep`: a case at many points."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path

from clearance.commands.accuracy import tolerance
from clearance.commands.common import (
    ACCEPT,
    DONE,
    FAILED,
    FORCE,
    GOES_ON,
    case_of,
    case_options,
    channel_patterns,
    complain,
    log_to_terminal,
    noted,
    number,
    progress_of,
    quiet,
    show,
    taken,
    texts_of,
)
from clearance.run.interrupts import terminable
from clearance.run.progress_bar import ProgressBar
from clearance.values.units import behind, unit_in

SHOWN = 12  # metrics in the summary
#: options of a sweep, and of `RUNS`
OF_SWEEP = "force compression error sensitivity method max_step max_steps samples_per_turn"
OF_MANY = "turns until rtol settle workers scheduler retry_failed accept_changes"
EXAMPLES = """\
-p NAME=VALUES takes LO:HI:N (N values), LO:HI:N:log, or a comma list; several of them make a
grid. Parameters whose values have commas themselves (joints, thresholds) take lists with
semicolons: joints="B;B,C;B,C,E". A fit, clearance=H7/f7, has its limits and its mean. With
--sample N ranges are LO:HI or LO:HI:log.

  clearance sweep six_bar_feeder -p speed=100rpm:600rpm:20 -p clearance=0.05mm:0.5mm:20 \\
    --turns 4 -o map
  clearance sweep slider_crank -p model=dry -p speed=50rpm,100rpm --turns 50 \\
    --channels "joints/C/ecc*,bodies/slider"
  clearance sweep six_bar_feeder --sample 200 -p speed=100rpm:600rpm \\
    -p clearance=10um:500um:log --channels none

The same command again runs only what is missing; --retry-failed tries failed points again. Exit
status 0: all points done, 1: some failed or it had to stop, 2: wrong input. A cluster: see the
guide, "Sweeps".
"""


#: options of many runs: their length, tolerance and metrics, and the processes that make them
RUNS = {
    "one of": {
        "--turns TURNS": (number, None, "length of each run in turns of the drive (default 2)"),
        "--until S": ("s", None, "length of each run in seconds"),
    },
    "--rtol R": (number, None, "local error tolerance (default 1e-6)"),
    "--settle TURNS": (number, None, "turns left out of the metrics (default the first)"),
    "--workers N": (int, None, "threads, or processes (default: one a core)"),
    "--scheduler ADDRESS": "of a Dask scheduler whose workers run the points",
    "--retry-failed": "also run again what failed",
    "--quiet": "no progress, no summary",
} | ACCEPT
ERROR = {
    "nargs": "?",
    "const": "state",
    "metavar": "E",
    "help": "a column <metric>_error for each metric; with E, such as 1e-3 or "
    "joint_B_force_max=1e-4, each point at the tolerance that reaches it",
}
OPTIONS = case_options("NAME=VALUES", "see below") | {"--error": ERROR} | RUNS | FORCE
OPTIONS |= {
    "--zip A,B ...": "parameters whose lists go together",
    "--sample N": (int, None, "N points drawn from the ranges instead of a grid"),
    "--kind KIND": "how points are drawn: latin (hypercube) or random (default latin)",
    "--seed N": (int, None, "of the draw: the same seed, the same points (default 0)"),
    "--sensitivity NAMES": "columns <metric>_by_<parameter> of these parameters, and their "
    "stated errors",
    "--method METHOD": "see `clearance run` (default auto)",
    "--max-step S": ("s", None, "longest step"),
    "--max-steps N": (int, None, "a run that needs more steps fails (default no limit)"),
    "--samples-per-turn N": (number, None, "output rows a turn (default 400)"),
    "--channels PATHS": 'stored in run files: comma list of patterns, "all" (default) or "none"',
    "--compression 0..9": (0, "gzip level of run files"),
    "--metric FILE.py:NAME ...": "a metric of your own",
    "--plot": "draw the usual picture into the directory: the map of a grid, else curves",
    "-o DIR": "sweep directory (default CASE_sweep)",
}


@contextmanager
def going_on(options) -> Iterator[ProgressBar]:
    """Progress of many runs, with lines of the log beside it; two turns where no length is
    requested. The same command goes on where an interrupt stops them.
    """
    if options.turns is None and options.until is None:
        options.turns = 2.0
    shown = progress_of(options)
    if not shown.silent:
        log_to_terminal(options)
        logging.getLogger("clearance.sweep").propagate = False  # `shown` prints its news
    with shown, quiet(options), terminable(), noted(GOES_ON):
        yield shown


def completed(options, make: Callable, draw: Callable, first: tuple[str, ...] = ()) -> int:
    """Make a sweep and print it; exit status 1 where a point failed or the sweep had to stop.

    draw: the picture of --plot; first: see `readable`.
    """
    from clearance.sweeping.sweep import SweepError

    began, failure = time.perf_counter(), None
    with going_on(options) as shown:
        try:
            result = make(shown)
        except SweepError as error:
            failure, result = str(error), error.sweep
    passed = {"seconds": time.perf_counter() - began, "done_before": shown.before}
    document = summary(result) | passed
    if failure is not None:
        del document["status"]
        return complain(options, failure, FAILED, **document)
    if options.plot and result.done.any():
        with quiet(options):
            document["plot"] = str(draw(result))
    status = DONE if result.done.all() else FAILED
    return show(options, document, readable(document, first), status)


def run(options) -> int:
    """Run the sweep."""
    from clearance.postprocess.pictures import usual
    from clearance.sweeping.sweep import sweep

    case = case_of(options)
    with quiet(options):
        points, fixed = _points(options, case)
    tolerance(options)

    def swept(shown):
        return sweep(
            options.case,
            points,
            options.output or f"{case.name}_sweep",
            fixed=fixed,
            channels=channel_patterns(options.channels),
            metrics=options.metric,
            progress=shown,
            **taken(options, f"{OF_MANY} {OF_SWEEP}"),
        )

    return completed(options, swept, lambda result: usual(result.folder))


def _points(options, case):
    """Points and fixed parameters of the command line."""
    from clearance.sweeping.points import range_from_words, sampled

    texts = texts_of(options, case.parameters)
    together = [tuple(n.strip() for n in group.split(",")) for group in options.zip]
    if options.sample is None:
        for name, value in (("--kind", options.kind), ("--seed", options.seed)):
            if value is not None:
                raise ValueError(f"{name} {value} belongs to --sample N: points that are drawn")
    else:
        if together:
            raise ValueError("--zip belongs to grids, not to --sample")
        ranges = {n: range_from_words(case.parameters[n], _listed(case, texts, n)) for n in texts}
        fixed = {n: r[0] for n, r in ranges.items() if isinstance(r, list) and len(r) == 1}
        drawn = {n: r for n, r in ranges.items() if n not in fixed}
        points = sampled(
            options.sample, kind=options.kind or "latin", seed=options.seed or 0, **drawn
        )
        return replace(points, units=units_in(texts)), fixed
    return grid_of(options, case, together)


def grid_of(options, case, together=()):
    """Points of a grid and fixed parameters; together: names whose lists go together."""
    from clearance.sweeping.points import ONE, from_words, grid, zipped

    texts = texts_of(options, case.parameters)
    values = {
        n: from_words(case.parameters[n], _listed(case, texts, n))
        for n, text in texts.items()
        if not case.takes_fit(n, text)
    }
    single = {n: v[0] for n, v in values.items() if len(v) == 1}
    for name in texts.keys() - values.keys():  # limits and mean of a fit
        fit = case.fit(name, texts[name], single)
        values[name] = [fit.smallest, fit.mean, fit.largest]
    values = {n: values[n] for n in texts}
    for name in (n for group in together for n in group):
        if name not in values:
            raise ValueError(f"--zip: no -p gives values of {name!r}")
    points, seen = ONE, set()
    for name, values_of in values.items():
        group = next((g for g in together if name in g), (name,))
        if name not in seen and (len(values_of) > 1 or len(group) > 1):
            points = points * (
                zipped(**{n: values[n] for n in group})
                if len(group) > 1
                else grid(**{name: values_of})
            )
        seen.update(group)
    fixed = {n: v[0] for n, v in values.items() if n not in points.columns}
    return replace(points, units=units_in(texts)), fixed


def units_in(texts: dict[str, str]) -> dict[str, str]:
    """Units in which the command line has the numbers of parameters, by name."""
    return {name: unit for name, text in texts.items() if (unit := unit_in(text))}


def _listed(case, texts: dict[str, str], name: str) -> str:
    """The text of a parameter; where values have commas themselves, such as joints=B,C, semicolons
    make lists.
    """
    text, parameter = texts[name], case.parameters[name]
    as_text = parameter.kind is str and (
        "comma list" in parameter.text or "," in str(parameter.default)
    )
    return f"{text};" if as_text and ";" not in text else text


def counts(result) -> dict:
    """State of a sweep, and numbers of its points."""
    return {
        "status": "complete" if result.done.all() else "incomplete",
        "case": result.definition.case,
        "folder": str(result.folder),
        "points": len(result),
        "done": int(result.done.sum()),
        "failed": int(result.failed.sum()),
    }


def summary(result) -> dict:
    """A sweep as plain data: counts, extremes of each metric and where they are, what failed and
    why.
    """
    import numpy as np

    extremes = {}
    for name, values in result.metrics.items():
        if np.isfinite(values).any():
            finite = np.where(np.isfinite(values), values, np.nan)
            low, high = int(np.nanargmin(finite)), int(np.nanargmax(finite))
            extremes[name] = {
                "units": result.known.get(name, ("?",))[0],
                "min": float(values[low]),
                "max": float(values[high]),
                "min_at": result.definition.points[low],
                "max_at": result.definition.points[high],
            }
    done = result.done
    without = done & (result.reason != "")
    return counts(result) | {
        "given_in": result.definition.points.units,
        "lost": int((result.status == "lost").sum()),
        "missing": int((result.status == "missing").sum()),
        "reasons": [_reason(result, i) for i in np.flatnonzero(~done).tolist()],
        "metrics_missing": [_reason(result, i) for i in np.flatnonzero(without).tolist()],
        "warnings": _warnings(result),
        "ways": None if result.ways is None else asdict(result.ways),
        "loop_s": float(result.costs["loop"].sum()),
        "metrics": extremes,
        "index": str(Path(result.folder) / "sweep.h5"),
    }


def _warnings(result) -> dict:
    """Number of points with warnings, and the point that has most of them."""
    counts = result.costs["warnings"]
    if not counts.any():
        return {"points": 0}
    most = int(counts.argmax())
    at = result.definition.points[most]
    return {"points": int((counts > 0).sum()), "most": int(counts[most]), "most_at": at}


def _reason(result, i: int) -> dict:
    values, status = result.definition.points[i], str(result.status[i])
    return {"point": i, "values": values, "status": status, "reason": str(result.reason[i])}


def readable(document: dict, first: tuple[str, ...] = ()) -> list[str]:
    """Lines of a summary; first: ends of the names of metrics that stand before the others."""
    from clearance.sweeping.journal import Ways
    from clearance.sweeping.points import in_words

    d = document

    def at(values: dict) -> str:
        return in_words(values, d["given_in"]) or "-"

    ordered = sorted(d["metrics"].items(), key=lambda item: not item[0].endswith(first))
    fresh = d["points"] - d["missing"] - d["done_before"]
    lines = [
        f"{d['case']}: {d['done']} of {d['points']} points done, {d['failed']} failed, {d['lost']} "
        f"lost"
        + (f" ({d['done_before']} before)" if d["done_before"] else "")
        + f"; {fresh} in {d['seconds']:.3g} s"
    ]
    for name, m in ordered[:SHOWN]:
        units = behind(m["units"])
        lines.append(f"  {name:<38} {_range(name, m, units, at)}")
    lines += _more(ordered[SHOWN:], "metrics")
    lines += [f"  {r['status']} at {at(r['values'])}: {r['reason']}" for r in d["reasons"][:5]]
    lines += _more(d["reasons"][5:], "that are not done")
    lines += [f"  at {at(r['values'])}: {r['reason']}" for r in d["metrics_missing"][:5]]
    lines += _more(d["metrics_missing"][5:], "points with a metric missing")
    if d["failed"]:
        lines.append("  --retry-failed tries failed points again")
    if (w := d["warnings"])["points"]:
        most = f"most, {w['most']}, at {at(w['most_at'])}; clearance run there prints them"
        points = "1 point has" if w["points"] == 1 else f"{w['points']} points have"
        lines.append(f"  {points} warnings: {most}")
    if fresh and (ways := d["ways"]):
        lines.append(f"  ways         {Ways(**ways)}")
    picture = [f"  picture      {d['plot']}"] if "plot" in d else []
    return [*lines, f"  directory    {d['folder']}", *picture]


def _more(others: list, text: str) -> list[str]:
    """A line that counts what is not shown, where there is any."""
    return [f"  and {len(others)} more {text}"] if others else []


def _range(name: str, metric: dict, units: str, at: Callable[[dict], str]) -> str:
    """The ends of a metric and the place of one; of a metric that is the same everywhere the
    value.
    """
    if metric["min"] == metric["max"]:
        return f"{metric['min']:.5g}{units}"
    return f"{metric['min']:.5g} to {metric['max']:.5g}{units}, {_extreme(name, metric, at)}"


def _extreme(name: str, metric: dict, at: Callable[[dict], str]) -> str:
    """The end that matters more and where it is: of minima the smallest, else the largest in
    size.
    """
    if name.endswith("_min"):
        return f"smallest at {at(metric['min_at'])}"
    if abs(metric["min"]) > abs(metric["max"]):
        return f"{metric['min']:.5g} at {at(metric['min_at'])}"
    return f"largest at {at(metric['max_at'])}"
