"""`clearance optimize`: parameters of a mechanism that give the least metric under limits."""

from pathlib import Path

from clearance.commands.common import (
    GOES_ON,
    LENGTH,
    case_options,
    log_to_terminal,
    noted,
    number,
    pair,
    quiet,
    seed_of,
    show,
    taken,
)
from clearance.commands.free import bounded_scene, check_bounds
from clearance.values.units import behind, shown

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


OPTIONS = (
    case_options("NAME=LOW:HIGH", "a parameter that is searched for, or NAME=VALUE, one that holds")
    | LENGTH
    | {
        "--minimize METRIC ...": "the goal; two goals in all give a front",
        "--maximize METRIC ...": "the goal; two goals in all give a front",
        "--limit LIMIT ...": '"METRIC > VALUE" or "METRIC < VALUE", such as "joints/B/gap_min > '
        '2um"',
        "--settle N": (
            number,
            None,
            "turns (seconds, where nothing turns) left out of the metrics (default the first)",
        ),
        "--from FILE.h5": "start of the runs, as of `clearance run`",
        "--tolerance NAME=SIZE ...": "standard deviation of a parameter among machines",
        "--share X": ("99%", "of machines that keep each limit"),
        "--starts N": (4, "of the search"),
        "--seed N": (0, "of the starts"),
        "--designs N": (20, "of a front, at most"),
        "-o DIR": "folder for optimum.json, run.h5, map, pages",
    }
)


def run(options) -> int:
    """Search, print the best design, and keep it in the folder."""
    from clearance.identify.designs import optimize

    with quiet(options):
        scene, bounds = bounded_scene(options)
    check_bounds(bounds)
    if not options.minimize and not options.maximize:
        raise ValueError("optimize: --minimize METRIC or --maximize METRIC names the goal")
    log_to_terminal(options)
    with noted(f"with -o {GOES_ON}"):
        result = optimize(
            scene,
            bounds,
            limits=options.limit,
            tolerance=dict(pair("--tolerance", t, SIZE) for t in options.tolerance),
            seed=seed_of(options),
            **taken(options, "minimize maximize turns until settle start share starts designs"),
            folder=options.output,
            progress=not options.json,
        )
        document = result.document()
        if options.output:
            document["files"] = _files(result, Path(options.output))
    return show(options, document, lines(result, document))


SIZE = "NAME=SIZE, such as clearance=5um"


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
    d, units = document, {p.name: p.units for p in result.design.free}
    text = [f"{result.design.scene.name}: {', then '.join(d['goals'])}"]
    text += [f"  {n} = {shown(p['value'], p['units'])}" for n, p in d["parameters"].items()]
    text += [f"  {n} = {shown(m['value'], m['units'])}" for n, m in d["metrics"].items()]
    for row in d["limits"]:
        error = "" if row["error"] is None else f" +- {row['error']:.1e}"
        share, of = row.get("kept"), d["share"]
        share = f"; {share['value']:.1%} of machines keep it, margin for {of:.1%}" if share else ""
        unit = behind(d["metrics"][row["limit"].split()[0]]["units"])
        text.append(f"  {row['limit']}{unit}: {row['value']:.6g}{error}{unit}{share}")
    text += [f"  {line}" for line in d["words"]]
    for row in d["optima"][1:]:
        text.append(f"  another optimum: {_design(row, units)}")
    if d["front"]:
        text += ["  front:", *(f"    {_design(row, units)}" for row in d["front"])]
    text += [f"  look: {doubt}" for doubt in d["doubts"]]
    return text + [f"  {path}" for path in d.get("files", ())]


def _design(row: dict, units: dict[str, str]) -> str:
    """A design and its metrics in one line."""
    values = [f"{n} = {shown(v, units[n])}" for n, v in row["parameters"].items()]
    return ", ".join([*values, *(f"{n} {v:.5g}" for n, v in row["metrics"].items())])
