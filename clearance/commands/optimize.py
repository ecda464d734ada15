"""`clearance optimize`: parameters of a mechanism that give the least metric under limits."""

import argparse
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    add_case,
    add_command,
    add_length,
    complain,
    json_text,
    log_to_terminal,
    number,
    quiet,
    seed_of,
    taken,
)
from clearance.commands.free import bounded_scene, check_bounds

EXAMPLES = """\
-p NAME=LOW:HIGH is searched for between these bounds, -p NAME=VALUE holds. A name is that of a
parameter of the case, or of a number of the scene, such as joints/B/length.

  clearance optimize six_bar_feeder -p clearance=20um:100um -p viscosity=2cP:50cP \\
    --minimize drives/crank/loss_mean --limit "joints/B/film_thickness_ratio_min > 3" -o best
  clearance run best --again                                         # the run of the best design

Metrics are those of `clearance run --json`, and mean losses: loss_mean, joints/B/loss_mean,
drives/crank/loss_mean [W]. Two goals give a front. --tolerance clearance=5um is a standard
deviation: limits are kept for a --share of machines. An interrupted search goes on with -o.
"""


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "optimize", epilog=EXAMPLES)
    add_case(p, "NAME=LOW:HIGH", "a parameter that is searched for, or NAME=VALUE, one that holds")
    for name in ("minimize", "maximize"):
        p.add_argument(
            f"--{name}",
            action="append",
            default=[],
            metavar="METRIC",
            help="the goal; two goals in all give a front",
        )
    p.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="LIMIT",
        help='"METRIC > VALUE" or "METRIC < VALUE", such as "joints/B/gap_min > 2um"; may be '
        "repeated",
    )
    add_length(p)
    p.add_argument(
        "--settle",
        type=number,
        metavar="N",
        help="turns (seconds, where nothing turns) left out of the metrics (default the first)",
    )
    p.add_argument(
        "--from", dest="start", metavar="FILE.h5", help="start of the runs, as of `clearance run`"
    )
    p.add_argument(
        "--tolerance",
        action="append",
        default=[],
        metavar="NAME=SIZE",
        help="standard deviation of a parameter among machines; may be repeated",
    )
    p.add_argument(
        "--share", default="99%", metavar="X", help="of machines that keep each limit (99%%)"
    )
    p.add_argument("--starts", type=int, default=4, metavar="N", help="of the search (default 4)")
    p.add_argument("--seed", type=int, default=0, metavar="N", help="of the starts (0)")
    p.add_argument(
        "--designs", type=int, default=20, metavar="N", help="of a front, at most (default 20)"
    )
    p.add_argument(
        "-o", dest="output", metavar="DIR", help="folder for optimum.json, run.h5, map, pages"
    )
    return p


def run(options) -> int:
    """Search, print the best design, and keep it in the folder."""
    from clearance.identify.designs import optimize

    with quiet(options):
        scene, bounds = bounded_scene(options)
    check_bounds(bounds)
    if not options.minimize and not options.maximize:
        raise ValueError("optimize: --minimize METRIC or --maximize METRIC names the goal")
    if not options.json:
        log_to_terminal()
    try:
        result = optimize(
            scene,
            bounds,
            limits=options.limit,
            tolerance=dict(map(_tolerance, options.tolerance)),
            seed=seed_of(options),
            **taken(options, "minimize maximize turns until settle start share starts designs"),
            folder=options.output,
            progress=not options.json,
        )
        document = result.document()
        if options.output:
            document["files"] = _files(result, Path(options.output))
    except KeyboardInterrupt:
        text = "interrupted; with -o the same command goes on where this stopped"
        return complain(options, text, FAILED)
    print(json_text(document) if options.json else "\n".join(lines(result, document)))
    return DONE


def _tolerance(text: str) -> tuple[str, str]:
    """Name and size of a --tolerance."""
    name, equals, size = text.partition("=")
    if not equals:
        raise ValueError(f"--tolerance {text}: expected NAME=SIZE, such as clearance=5um")
    return name.strip(), size


def _files(result, folder: Path) -> list[str]:
    """Files of the result; its map is swept and drawn."""
    try:
        swept = result.mapped(folder / "map")
    except ValueError:  # parameters of two kinds have no sweep
        swept = None
    pages = [
        result.plot(folder / "optimum.png", swept),
        result.report(folder / "report.html", swept),
    ]
    return [*(str(folder / n) for n in ("optimum.json", "run.h5")), *map(str, pages)]


def lines(result, document: dict) -> list[str]:
    """The result in lines."""
    from clearance.values.units import shown

    d, units = document, {p.name: p.units for p in result.design.free}
    text = [f"{result.design.scene.name}: {', then '.join(d['goals'])}"]
    text += [f"  {n} = {shown(p['value'], p['units'])}" for n, p in d["parameters"].items()]
    text += [f"  {n} = {shown(m['value'], m['units'])}" for n, m in d["metrics"].items()]
    for row in d["limits"]:
        error = "" if row["error"] is None else f" +- {row['error']:.1e}"
        share, of = row.get("kept"), d["share"]
        share = f"; {share['value']:.1%} of machines keep it, {of:.1%} by slopes" if share else ""
        text.append(f"  {row['limit']}: {row['value']:.6g}{error}{share}")
    text += [f"  {line}" for line in d["words"]]
    for row in d["optima"][1:]:
        text.append(f"  another optimum: {_design(row, units)}")
    if d["front"]:
        text += ["  front:", *(f"    {_design(row, units)}" for row in d["front"])]
    text += [f"  look: {doubt}" for doubt in d["doubts"]]
    return text + [f"  {path}" for path in d.get("files", ())]


def _design(row: dict, units: dict[str, str]) -> str:
    """A design and its metrics in one line."""
    from clearance.values.units import shown

    values = [f"{n} = {shown(v, units[n])}" for n, v in row["parameters"].items()]
    return ", ".join([*values, *(f"{n} {v:.5g}" for n, v in row["metrics"].items())])
