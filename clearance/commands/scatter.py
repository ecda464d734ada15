"""`clearance scatter`: a case whose parameters vary by chance."""

import time
from functools import partial
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    case_of,
    case_options,
    pair,
    quiet,
    show,
    taken,
    texts_of,
)
from clearance.commands.sweep import OF_MANY, RUNS, counts, going_on
from clearance.values import checks
from clearance.values.units import behind

SHOWN = 6  # metrics in the summary
MORE_POINTS = "no exact index is; see the intervals, which more points narrow"
EXAMPLES = """\
-p NAME=VALUE takes a value or a distribution: normal(MEAN,DEVIATION),
truncated(MEAN,DEVIATION,LOW,HIGH), lognormal(MEDIAN,FACTOR), uniform(LOW,HIGH),
triangular(LOW,MODE,HIGH), or of a clearance a fit such as H7/f7. Parameters vary independently.

  clearance scatter six_bar_feeder -p "clearance=normal(100um,5um)" \\
    -p "viscosity=normal(50cP,4cP)" \\
    --points 4096 --limit slider_position_deviation_max=0.2mm

The runs are a sweep: `clearance plot` and `clearance report` take the directory too, and the same
command again runs only what is missing. Exit status 0: all runs done, 1: some failed, 2: wrong
input.
"""


OPTIONS = (
    case_options(text="see below")
    | RUNS
    | {
        "--points N": (1024, "runs in all, at most"),
        "--seed N": (0, "the same seed, the same points"),
        "--limit METRIC=VALUE ...": "probability that a metric exceeds this (of minima, falls "
        "below it)",
        "-o DIR": "directory (default CASE_scatter); the picture too",
    }
)


def run(options) -> int:
    """Run the points; exit status 1 where one failed or the sweep had to stop."""
    from clearance.sweeping.chance import scatter

    case = case_of(options)
    with quiet(options):
        spread, fixed = _parameters(options, case)
        limits = dict(pair("--limit", text, "METRIC=VALUE") for text in options.limit)
    began, folder = time.perf_counter(), Path(options.output or f"{case.name}_scatter")
    with going_on(options) as shown:
        result = scatter(
            options.case,
            spread,
            folder,
            limits=limits,
            fixed=fixed,
            progress=shown,
            **taken(options, f"points seed {OF_MANY}"),
        )
    document = _document(result, folder) | {"seconds": time.perf_counter() - began}
    status = DONE if result.sweep.done.all() else FAILED
    return show(options, document, readable(document), status)


def _parameters(options, case) -> tuple[dict, dict]:
    """Distributions and values of the command line. Raises ValueError naming the parameter."""
    from clearance.sweeping.scatter import from_words, of_fit

    spread, fixed, texts = {}, {}, texts_of(options, case.parameters)
    fits = {n: t for n, t in texts.items() if case.takes_fit(n, t)}
    for name, text in texts.items():
        if name in fits:
            continue
        parameter = case.parameters[name]
        try:
            law = from_words(text, partial(_number, parameter))
        except ValueError as error:
            raise ValueError(f"{name}: {str(error).removeprefix(f'{name}: ')}") from None
        if law is None:
            fixed[name] = _value(parameter, text)
        else:
            spread[name] = law
    spread |= {n: of_fit(case.fit(n, t, fixed)) for n, t in fits.items()}
    return spread, fixed


def _value(parameter, text: str) -> object:
    """The value of a fixed parameter. Raises ValueError for a distribution that there is not."""
    from clearance.sweeping.scatter import DISTRIBUTIONS

    kind, bracket, _ = text.partition("(")
    if bracket and parameter.kind is float:
        checks.known(f"{parameter.name}: no distribution", kind, DISTRIBUTIONS)
    if ":" in text and parameter.kind is float:
        meant = f"uniform({','.join(text.split(':')[:2])})"
        raise ValueError(f"{parameter.name}: {text} is no distribution; {meant} is one")
    return parameter.value(text)


def _number(parameter, text: str) -> float:
    """A number of the distribution of a parameter. Raises ValueError for one that has none."""
    if parameter.kind is not float:
        reason = "a distribution is for numbers with fractions; give one value"
        raise ValueError(f"{reason}, as {parameter.name}={parameter.default}")
    return parameter.value(text)


def _document(result, folder: Path) -> dict:
    """The scatter as plain data; its picture is drawn."""
    from clearance.postprocess.scatter import scatter as drawn

    metrics = {name: result.summary(name) for name in result.metrics}
    return counts(result.sweep) | {
        "folder": str(folder),
        "spread": {n: str(law) for n, law in result.spread.items()},
        "independent": 2 * result.n,
        "metrics": metrics,
        "picture": str(drawn(result, folder / "scatter.png")) if metrics else None,
    }


def _share(estimate: dict) -> str:
    """A Sobol' index with its interval: of few points an estimate may lie outside [0, 1]."""
    value, low, high = (round(estimate[n], 2) + 0.0 for n in ("value", "low", "high"))
    return f"{value:.2f} ({low:.2f} to {high:.2f})"


def readable(document: dict) -> list[str]:
    """The summary in lines."""
    d = document
    spread = ", ".join(f"{n}={law}" for n, law in d["spread"].items())
    lines = [
        f"{d['case']} with {spread}: {d['done']} of {d['points']} runs done, {d['failed']} failed"
    ]
    if d["done"] < d["points"]:
        lines.append(
            "  numbers are those of the runs that ended: where runs fail by their "
            "parameters they are biased"
        )
    for name, m in list(d["metrics"].items())[:SHOWN]:
        units, q = behind(m["units"]), m["quantiles"]
        ends = f"{q['0.05']['value']:.5g} to {q['0.95']['value']:.5g}"
        lines.append(f"  {name:<38} median {q['0.5']['value']:.5g}, 90 % within {ends}{units}")
        if "limit" in m:
            b = m["beyond"]
            share = f"{100 * b['value']:.3g} % ({100 * b['low']:.3g} to {100 * b['high']:.3g} %)"
            lines.append(f"    beyond {m['limit']:.5g}{units}: {share}")
        if m["indices"]:
            parts = sorted(m["indices"].items(), key=lambda item: -item[1]["total"]["value"])
            lines.append("    share of the variance, alone and with interactions:")
            lines += [f"      {n:<36} {_share(i['first'])}, {_share(i['total'])}" for n, i in parts]
            if above := [n for n, i in parts if i["doubtful"]]:
                lines.append(f"      first above total for {', '.join(above)}: {MORE_POINTS}")
    if len(d["metrics"]) > SHOWN:
        lines.append(f"  and {len(d['metrics']) - SHOWN} more metrics: --json has them all")
    picture = f"  picture      {d['picture']}" if d["metrics"] else "  no metric varies: no picture"
    return [*lines, picture, f"  directory    {d['folder']}"]
