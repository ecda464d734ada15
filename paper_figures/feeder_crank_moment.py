"""Crank moment of the six-bar feeder with four models of joint B.

Group: feeder

Answers: Jin et al. (2023), driving moment of the crank at constant speed, ideal against dry,
lubricated and transitional clearance.

Reproduced: the moment over a turn at 300 rpm and a radial clearance of 0.2 mm, its smallest and
largest value of a turn, root mean square and mean. The mean times a turn is the work of a turn,
which goes into friction and oil. The oil of 5 mPa s is thin enough for the journal to cross the
clearance fast and for surfaces to touch.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1; all joints but B are
ideal and free of friction. The dry moment is irregular; smallest and largest values are means over
turns, which do not grow with their number.

Not comparable: the source's moments belong to its own lengths and masses, which were not in the
part we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import (
    DRY,
    IDEAL,
    SETTLE,
    by_turns,
    ends,
    finished,
    models,
    over_ideal,
    rms,
    say,
    settled,
    style,
    turns_seen,
)
from clearance.postprocess.channels import abscissa
from clearance.postprocess.figures import finish, line, sheet


def draw(work: workshop.Workshop) -> None:
    runs = models(work)
    work.keep(moments(runs))
    remark = (
        f"Of {turns_seen(runs)} turns after {SETTLE}; +-: half the 95 % interval of means "
        "over turns."
    )
    work.table(*numbers(runs), remarks=remark)


def moments(runs: dict):
    """The moment over the last turn, with oil above and dry below, and how it differs from the
    ideal one.
    """
    figure = sheet(7.0, 6.8)
    panels = figure.subplots(3, 1, sharex=True)
    ideal = runs[IDEAL].drive("crank").torque
    for name, run in runs.items():
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        torque = run.drive("crank").torque
        line(panels[2 if name == DRY else 0], angle, torque[last], **style(name))
        if name not in (DRY, IDEAL):
            line(panels[1], angle, torque[last] - ideal[last], **style(name))
    for axes, label in zip(
        panels,
        ("crank moment", "what it has beyond\nthe ideal one", "dry: crank moment"),
        strict=True,
    ):
        finish(axes, f"{label} [N m]", "", legend=False)
    moments = {n: r.drive("crank").torque[settled(r)] for n, r in runs.items()}
    ratios, factors = over_ideal(moments, turns_seen(runs))
    met = "met" if min(ratios.values()) > 1.0 and max(ratios, key=ratios.get) == DRY else "not met"
    claim = "clearance makes the moment peak, oil less than dry contact"
    say(figure, f"Largest crank moment over the ideal one: {factors}. Source: {claim}; {met}.")
    return finished(figure, panels, xlabel, (panels[0], panels[2]))


def numbers(runs: dict) -> tuple[list[str], list[list]]:
    """Heads and rows: ends of a turn, root mean squares and work."""
    heads = [
        "joint B",
        "min of a turn [N m]",
        "max of a turn [N m]",
        "largest abs. of a turn [N m]",
        "rms [N m]",
        "mean [N m]",
        "work of a turn [J]",
        "rms beyond ideal [N m]",
    ]
    rows, turns = [], turns_seen(runs)
    ideal = runs[IDEAL].drive("crank").torque[settled(runs[IDEAL])]
    for name, run in runs.items():
        torque = run.drive("crank").torque[settled(run)]
        largest = by_turns(np.abs(torque), turns)
        middle = round(float(torque[:-1].mean()), 9) + 0.0  # of the ideal one rounding is left
        rows.append(
            [
                name,
                *ends(torque, turns),
                largest,
                rms(torque),
                middle,
                2.0 * np.pi * middle,
                rms(torque - ideal),
            ]
        )
    return heads, rows
