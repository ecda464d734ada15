"""`clearance follow`: a periodic motion of a case over a parameter."""

from pathlib import Path

from clearance.commands.common import (
    ACCEPT,
    case_of,
    case_options,
    listed,
    make_folder,
    number,
    progress_of,
    quiet,
    share,
    show,
    taken,
    texts_of,
)
from clearance.run.interrupts import terminable
from clearance.values.units import unit_in, written

EXAMPLES = """\
One -p has a range LO:HI: the periodic motion that the case settles to at LO is followed towards
HI, round folds, also where it is unstable. Its bifurcations are located, its Floquet multipliers
state where it is stable.

  clearance follow slider_crank -p model=dry -p clearance=1mm -p speed=3000rpm:4100rpm -o branch
The same command goes on where it was interrupted.

  clearance follow my.py -p clearance=0.1mm:0.3mm -p speed=600rpm --over map_dry -o branch
"""


OPTIONS = (
    case_options(text="see below")
    | ACCEPT
    | {
        "--tolerance TOL": (share, 1e-6, "distance from the motion, as --steady"),
        "--points N": (500, "points of a curve"),
        "--step S": (
            number,
            None,
            "longest step, as share of the range (default 0.03, or 0.2 where the branch is quiet)",
        ),
        "--doublings N": (
            0,
            "follow motions of twice the period too, from period doublings on, N times",
        ),
        "--most-turns N": (400, "to the first motion"),
        "--channels PATHS": "comma list of outputs stored where turns begin",
        "--over SWEEP": "a sweep over the parameter, drawn behind the branch as dots",
        "-o DIR": "folder for CSV, HDF5 and picture",
    }
)


def run(options) -> int:
    """Follow the motion and show what was met; exit status 1 where none was, or the user ended
    it.
    """
    from clearance.motions.follow import follow

    case = case_of(options)
    texts = texts_of(options, case.parameters)
    name, ends, fixed = _range(case, texts)
    unit = unit_in(texts[name])
    _check(options)
    with progress_of(options) as shown, terminable(), quiet(options):
        branch = follow(
            options.case,
            name,
            *ends,
            fixed=fixed,
            channels=listed(options.channels),
            path=options.output,
            unit=unit,
            progress=shown,
            **taken(options, "tolerance points step doublings most_turns accept_changes"),
        )
    document = _document(branch)
    if options.output:
        document["files"] = [
            *(str(Path(options.output) / f"follow.{kind}") for kind in ("csv", "h5")),
            _drawn(options, branch),
        ]
    return show(options, document, _lines(branch, document, unit))


def _check(options) -> None:
    """Raises ValueError for an output or a sweep that cannot be."""
    if options.over and not options.output:
        raise ValueError("--over belongs to a picture: give its folder, -o DIR")
    if options.over and not Path(options.over).is_dir():
        raise ValueError(f"--over {options.over}: there is no such sweep")
    make_folder(options)


def _range(case, texts: dict[str, str]) -> tuple[str, tuple[float, float], dict]:
    """The parameter with a range, its ends, and the values of the others."""
    parameters = case.parameters
    ranged = [
        n for n, text in texts.items() if parameters[n].kind is float and text.count(":") == 1
    ]
    if len(ranged) != 1:
        count = f"{len(ranged)} have: {', '.join(ranged)}" if ranged else "none has"
        raise ValueError(f"one parameter needs a range, as -p speed=3000rpm:4100rpm; {count}")
    (name,) = ranged
    ends = tuple(parameters[name].value(text) for text in texts[name].split(":"))
    return name, ends, case.read({n: text for n, text in texts.items() if n != name})


def _document(branch) -> dict:
    """The branch as plain data."""
    return {
        "status": "complete",
        "case": branch.case,
        "parameter": branch.parameter,
        "units": branch.units,
        "points": len(branch.points),
        "ended": branch.reason,
        "bifurcations": [
            {
                "kind": p.kind,
                "value": p.value,
                "multipliers": [[m.real, m.imag] for m in p.multipliers],
                "multiplier_errors": p.errors.tolist(),
            }
            for p in branch.bifurcations
        ],
        "coexisting": [
            dict(zip(("begin", "end", "motions", "stable"), stretch, strict=True))
            for stretch in branch.coexisting
        ],
        "branch": {name: values.tolist() for name, (_, _, values) in branch.columns().items()},
    }


def _lines(branch, document: dict, unit: str) -> list[str]:
    """The branch in print; unit: of the parameter, as the user wrote it."""
    from clearance.commands.steady import shown

    def text(value: float) -> str:
        return written(float(value), unit, 7) if unit else _readable(value, branch.units)

    values, stable = branch.values, sum(p.stable for p in branch.points)
    lines = [
        f"{branch.case}: {len(branch.points)} periodic motions over {branch.parameter}, "
        f"{text(values.min())} to {text(values.max())}, {stable} of them stable",
        f"  ended        {branch.reason}",
    ]
    if undecided := sum(not p.decided for p in branch.points if not p.kind):
        lines.append(f"  doubt        {undecided} motions have a multiplier of size 1 in its error")
    for p in branch.bifurcations:
        values = ", ".join(shown(p.multipliers[:3], p.errors[:3]))
        lines.append(f"  {p.kind:<16} at {text(p.value)}, multipliers {values}")
    for begin, end, motions, quiet_ones in branch.coexisting:
        lines.append(
            f"  coexisting   {text(begin)} to {text(end)}: {motions} motions, {quiet_ones} stable"
        )
    return [*lines, *(f"  wrote        {file}" for file in document.get("files", ()))]


def _readable(value: float, units: str) -> str:
    """A value in the unit in which it reads well, with enough digits to distinguish
    bifurcations.
    """
    from clearance.postprocess.labels import shown_in

    unit, factor = shown_in(units, [value])
    return f"{value * factor:.7g} {unit}"


def _drawn(options, branch) -> str:
    """The picture of the branch."""
    from clearance.postprocess.branches import branches
    from clearance.sweeping.index import open_sweep

    over = open_sweep(options.over) if options.over else None
    title = f"{branch.case}: a periodic motion over {branch.parameter.replace('_', ' ')}"
    return str(
        branches(branch.columns(), Path(options.output) / "follow.png", title=title, over=over)
    )
