"""`clearance fit`: parameters of a mechanism from its records, or intervals of planned ones."""

from pathlib import Path

from clearance.commands.common import (
    GOES_ON,
    case_options,
    listed,
    log_to_terminal,
    noted,
    number,
    pair,
    seed_of,
    show,
    taken,
)
from clearance.commands.free import bounded_scene, check_bounds
from clearance.values.units import behind

EXAMPLES = """\
-p NAME=LOW:HIGH is fitted between these bounds, -p NAME=VALUE holds. A name is that of a parameter
of the case, or of a number of the scene, such as bodies/slider/mass.

  clearance fit slider_crank -p model=lubricated --data bench.csv -p clearance=0.1mm:1mm \\
    -p viscosity=0.05:1 --channels bodies/slider/ax=acceleration -o fit
  clearance run fit --again                                          # the run of what was fitted
  clearance fit slider_crank -p model=lubricated -p clearance -p viscosity --plan --noise 1% \\
    --channels bodies/slider/ax,joints/C/force --turns 1,5           # before anybody measures

The header of a record has names with units: "time [ms], a [m/s2]", "crank_angle_deg, a_m_s2".
Of a record that has its own conditions: --data slow.csv,speed=300rpm. An interrupted fit goes on.
"""


OPTIONS = case_options(
    "NAME=LOW:HIGH", "a parameter that is fitted, or NAME=VALUE, one that holds"
) | {
    "--data FILE.csv ...": "a record, and after commas parameters that hold for it alone",
    "--channels PATHS": "what was measured: comma list such as bodies/slider/ax, or as PATH=COLUMN",
    "--noise X": "standard deviation of an error of a value: 3mm, or 1% of the range of the "
    "record; one, or one for each channel (default: that of the residuals)",
    "--settle N": (
        number,
        None,
        "turns (seconds, where nothing turns) before the records begin (default 2; 0)",
    ),
    "--nuisances NAMES": (
        "auto",
        "of shift, offset, gain, mounting: those of each record that are fitted too, or none; "
        "auto: the shift of records over time, where something turns",
    ),
    "--lowpass ORDER:CORNER": "Butterworth filter of the sensor, such as 2:1000 for a corner "
    "of 1000 Hz, or one for each channel: 2:1000,none",
    "--starts N": (5, "of the search"),
    "--seed N": (0, "of the starts"),
    "--plan": "intervals that a record would give",
    "--turns LIST": "of --plan: lengths of the record (1)",
    "--speeds LIST": "of --plan: values of the parameter speed",
    "--samples-per-turn N": (360, "of --plan"),
    "-o DIR": "folder for fit.json, run.h5, pages",
}


def run(options) -> int:
    """Fit, print the verdict, and keep it in the folder."""
    from clearance.identify.scene_parameters import fit

    scene, bounds = bounded_scene(options)
    if not options.channels:
        raise ValueError("fit: --channels names what was measured, such as bodies/slider/ax")
    if options.plan:
        return _plan(options, scene, bounds)
    if not options.data:
        raise ValueError("fit: --data names a record; --plan needs none")
    check_bounds(bounds, "; only --plan takes the name alone")
    log_to_terminal(options)
    with noted(f"with -o {GOES_ON}"):
        result = fit(
            scene,
            [_data(text, scene) for text in options.data],
            bounds,
            options.channels,
            lowpass=[lowpass(text) for text in listed(options.lowpass) or ["none"]],
            seed=seed_of(options),
            **taken(options, "noise settle nuisances starts"),
            folder=options.output,
            progress=not options.json,
        )
    document = result.document()
    if options.output:
        folder = Path(options.output)
        files = [result.plot(folder / "fit.png"), result.report(folder / "report.html")]
        document["files"] = [str(folder / n) for n in ("fit.json", "run.h5")] + [*map(str, files)]
    return show(options, document, lines(result, document))


def lines(result, document: dict) -> list[str]:
    """The verdict in lines."""
    from clearance.identify.scene_parameters import shown

    judged = result.verdict
    records = f"{len(result.curves)} record{'s' * (len(result.curves) > 1)}"
    text = [f"{result.problem.scene.name}: {judged.samples} values of {records}"]
    text += [f"  {shown(i)}" for i in judged.intervals]
    for name, (value, deviation, units) in result.nuisances.items():
        text.append(f"  {name} = {value:.4g}{behind(units)} (deviation {deviation:.2g})")
    text += [f"  {line}" for line in judged.products]
    for i, row in enumerate(judged.correlation[: len(judged.intervals)]):
        pairs = ((judged.names[j], row[j]) for j in range(i))
        text += [f"  correlation of {judged.names[i]} and {n}: {r:.3f}" for n, r in pairs]
    text += [f"  {name}: probability {p:.3g}" for name, p in judged.tests.items()]
    text += [f"  look: {doubt}" for doubt in judged.doubts]
    return text + [f"  {path}" for path in document.get("files", ())]


FORM = "FILE,NAME=VALUE with parameters of the case"


def _data(text: str, scene) -> tuple[str, dict]:
    """A file, and the parameters that hold for it alone."""
    path, *changes = text.split(",")
    parameters = scene.case.parameters if scene.case is not None else {}
    values = {}
    for change in changes:
        name, value = pair("--data", change, FORM)
        if name not in parameters:
            raise ValueError(f"--data {text}: expected {FORM}")
        values[name] = parameters[name].value(value)
    return path, values


def lowpass(text: str | None) -> tuple[int, float] | None:
    """Order and corner of a filter; None for "none"."""
    if text in (None, "none"):
        return None
    order, colon, corner = text.partition(":")
    if not colon or not order.isdigit():
        raise ValueError(f"--lowpass {text}: expected ORDER:CORNER, such as 2:1000")
    try:
        return int(order), float(corner.removesuffix("Hz"))
    except ValueError:
        raise ValueError(f"--lowpass {text}: the corner is a number of Hz") from None


def _plan(options, scene, bounds: dict) -> int:
    """Print the intervals that planned records would give."""
    from clearance.identify.fit_plan import plan

    lengths = [float(t) for t in listed(options.turns) or ["1"]]
    rows = plan(
        scene,
        bounds,
        options.channels,
        noise=options.noise or "1%",
        turns=lengths,
        speeds=listed(options.speeds),
        samples_per_turn=options.samples_per_turn,
        settle=options.settle,
    )
    lines = [
        f"95 % intervals of a record with noise {options.noise or '1%'}, best first",
        "  " + "".join(f"{n:>26}" for n in bounds) + "  of",
        *("  " + "".join(f"{r.text(n):>26}" for n in bounds) + f"  {r.title}" for r in rows),
    ]
    return show(options, {"rows": [row.document() for row in rows]}, lines)
