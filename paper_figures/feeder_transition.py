"""The fuzzy transition of joint B: what its choices, thresholds and shapes decide, beside load
sharing.

Group: feeder

Answers: Jin et al. (2023), the transitional model itself, whose thresholds and membership functions
were not in the part we had. Three choices are open: the start of contact, the datum of its
penetration, and the closing rate of the film where its gap is held.

Between elastic surfaces two of them need no choice: film and contact meet at one gap.

Reproduced: largest force in joint B at 300 rpm, by thin oils and two clearances, for every choice.
Load sharing, which has no threshold, is the reference. Choices: squeeze rate of the held film
(full, or that of a gap that stands still). Datum of contact (the threshold mixed, the wall as in
Flores' hybrid, or the threshold full). Flores' hybrid and no transition. Thresholds: 0.4, 1, 3
halved and doubled, each with memberships that are half-cosines, straight lines and polynomials of
fifth degree. They come from files, as a reader of the paper would give them. A cross marks a force
hole: the film has faded before the contact carries.

Assumed: parameter set feeder-A, roughness 0.8 um, Winkler's contact, Greenwood and Tripp's
asperities in load sharing.

Not comparable: the source's memberships and forces; load sharing is a model too, not a measurement.
"""

import csv
import itertools
from pathlib import Path

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import SETTLE, feeder, rms, say, settled
from clearance.postprocess.figures import finish, legend_below, line, marker, sheet, stroke

OILS = (0.005, 0.002, 0.001)
CLEARANCES = (1e-4, 2e-4)
REFERENCE = "load sharing"
#: choices of the transition: name -> parameters of the case
CHOICES = {
    REFERENCE: {"transition": "load_sharing"},
    "load sharing, elastic": {"transition": "load_sharing", "elastic": "true"},
    "fuzzy, elastic": {"elastic": "true"},
    "fuzzy, rigid": {},
    "held film does not squeeze": {"transition": "fuzzy(squeeze=0)"},
    "contact from the threshold full": {"transition": "fuzzy(datum=3)"},
    "contact from the wall": {"transition": "fuzzy(datum=0)"},
    "Flores' hybrid": {"transition": "flores"},
    "no transition": {"transition": "none"},
}
THRESHOLDS = (0.4, 1.0, 3.0)
SCALES = (0.5, 1.0, 2.0)
#: rises of a membership over (0, 1)
SHAPES = {
    "half-cosine": lambda x: 0.5 - 0.5 * np.cos(np.pi * x),
    "straight": lambda x: x,
    "fifth degree": lambda x: x**3 * (10.0 - 15.0 * x + 6.0 * x**2),
}
#: points of a file on each rise
POINTS = 13
HOLE = "force hole"
#: ticks of the film thickness ratio
RATIOS = (-3, -2, -1, 0, 1, 2, 3)


def draw(work: workshop.Workshop) -> None:
    places = list(
        itertools.product(work.less(CLEARANCES, CLEARANCES[:1]), work.less(OILS, OILS[:2]))
    )
    chosen = {
        (name, point): mixed(work, point, **CHOICES[name]) for point in places for name in CHOICES
    }
    heads = [
        "transition",
        "clearance [mm]",
        "oil [mPa s]",
        "largest force B [N]",
        "over load sharing",
        "rms difference of force [N]",
        "largest abs. acceleration [m/s2]",
        "smallest film thickness ratio",
        HOLE,
    ]
    rows = [
        row(name, point, run, chosen[REFERENCE, point]) for (name, point), run in chosen.items()
    ]
    work.table(heads, rows, "choices", f"Of 2 turns after {SETTLE}.")
    work.keep(choices(chosen, places), "choices")
    shaped = {
        (shape, scale, point): mixed(work, point, memberships=table(work, shape, scale))
        for point in places
        for shape in SHAPES
        for scale in SCALES
    }
    heads[:1] = ["memberships", "thresholds times"]
    rows = [
        [shape, scale, *row("", point, run, chosen[REFERENCE, point])[1:]]
        for (shape, scale, point), run in shaped.items()
    ]
    work.table(heads, rows, "thresholds", f"Of 2 turns after {SETTLE}.")
    work.keep(thresholds(shaped, chosen, places), "thresholds")


def mixed(work: workshop.Workshop, point: tuple[float, float], **parameters):
    """A run at a clearance and an oil."""
    clearance, oil = point
    where = {"clearance": clearance, "viscosity": oil}
    return feeder(work, model="mixed", **where, **parameters, turns=SETTLE + 2)


def table(work: workshop.Workshop, shape: str, scale: float) -> str:
    """The file of memberships of a shape."""
    dry, middle, full = (scale * t for t in THRESHOLDS)
    path = Path(work.folder) / "results" / f"memberships-{shape.replace(' ', '-')}-{scale:g}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    steps = np.linspace(0.0, 1.0, POINTS)
    rise = SHAPES[shape](steps)
    rows = [(dry + (middle - dry) * x, 0.0, s, 1.0 - s) for x, s in zip(steps, rise, strict=True)]
    rows += [
        (middle + (full - middle) * x, s, 1.0 - s, 0.0)
        for x, s in zip(steps[1:], rise[1:], strict=True)
    ]
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["film thickness ratio", "full film", "mixed", "dry"])
        writer.writerows(rows)
    return str(path)


def row(name: str, point: tuple[float, float], run, reference) -> list:
    """Extremes of a run, and its force beside that of load sharing."""
    late = SETTLE * run.turn
    force, then = (np.hypot(*r.joint("B").force[settled(r)].T) for r in (run, reference))
    peak, base = peak_of(run), peak_of(reference)
    ratio = run.extreme("joints/B/film_thickness_ratio_min", begin=late).value
    acceleration = float(np.abs(run["slider"].ax[settled(run)]).max())
    apart = [peak, peak / base, rms(force - then), acceleration, ratio]
    return [
        name,
        f"{1e3 * point[0]:g}",
        f"{1e3 * point[1]:g}",
        *map(float, apart),
        HOLE if holed(run) else "-",
    ]


def peak_of(run) -> float:
    return float(run.extreme("joints/B/force_max", begin=SETTLE * run.turn).value)


def holed(run) -> bool:
    return any(HOLE in warning for warning in run.warnings)


def label(point: tuple[float, float]) -> str:
    return f"{1e3 * point[0]:g} mm\n{1e3 * point[1]:g} mPa s"


def choices(chosen: dict, places: list):
    """Largest force over that of load sharing, and smallest film thickness ratio, by clearance and
    oil.
    """
    figure = sheet(9.0, 7.6)
    above, below = figure.subplots(2, 1, sharex=True)
    at = np.arange(len(places))
    for i, name in enumerate(CHOICES):
        runs = [chosen[name, point] for point in places]
        forces = [
            peak_of(run) / peak_of(chosen[REFERENCE, p])
            for run, p in zip(runs, places, strict=True)
        ]
        ratios = [row(name, p, r, r)[-2] for r, p in zip(runs, places, strict=True)]
        shift = 0.09 * (i - 0.5 * (len(CHOICES) - 1))
        style = {"ls": "", "marker": marker(i), "ms": 7, "label": name} | {
            "color": stroke(i, len(CHOICES))["color"]
        }
        above.plot(at + shift, forces, **style)
        below.plot(at + shift, ratios, **style)
        holes = [k for k, run in enumerate(runs) if holed(run)]
        above.plot(at[holes] + shift, np.array(forces)[holes], "kx", ms=10, mew=1.2)
    above.set_yscale("log")
    finish(above, "largest force in joint B\nover that of load sharing [-]", "", legend=False)
    finish(below, "smallest film\nthickness ratio [-]", "", legend=False)
    below.set_xticks(at, [label(point) for point in places])
    below.set_yscale("symlog", linthresh=1.0)
    below.set_yticks(RATIOS, [f"{r:g}" for r in RATIOS])
    for axes in (above, below):
        axes.grid(axis="x", alpha=0.0)
        for k in at[1:]:
            axes.axvline(k - 0.5, color="0.8", lw=0.7)
    say(figure, verdict(chosen, places))
    legend_below(figure, above)
    return figure


def verdict(chosen: dict, places: list) -> str:
    """Distances of choices from load sharing: the median over places and the largest."""

    def factors(name: str) -> str:
        ratios = [peak_of(chosen[name, p]) / peak_of(chosen[REFERENCE, p]) for p in places]
        return f"{np.median(ratios):.3g} ({max(ratios):.3g})"

    words = ", ".join(f"{name} {factors(name)}" for name in CHOICES if name != REFERENCE)
    return (
        f"Largest force over that of load sharing, median (most): {words}. Crosses: warned of a "
        "force hole."
    )


def thresholds(shaped: dict, chosen: dict, places: list):
    """Largest force over that of load sharing by the thresholds' scale, a panel for each place;
    holes are crossed.
    """
    columns = len(OILS)
    rows = -(-len(places) // columns)
    figure = sheet(9.5, 2.8 * rows + 1.6)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    forces = {shape: [] for shape in SHAPES}
    for axes, point in zip(panels.flat, places, strict=False):
        base = peak_of(chosen[REFERENCE, point])
        for i, shape in enumerate(SHAPES):
            runs = [shaped[shape, scale, point] for scale in SCALES]
            y = np.array([peak_of(r) for r in runs]) / base
            forces[shape].append(y)
            at = np.array(SCALES) * 1.06 ** (i - 1)
            line(
                axes,
                at,
                y,
                **stroke(i, len(SHAPES))
                | {"lw": 0.8, "label": shape, "marker": marker(i), "ms": 5},
            )
            holes = [k for k, run in enumerate(runs) if holed(run)]
            axes.plot(at[holes], y[holes], "kx", ms=11, mew=1.2)
        axes.axhline(1.0, color="0.5", lw=0.9, ls=":")
        finish(axes, "", "thresholds times [-]" if axes in panels[-1] else "", legend=False)
    panels[0, 0].set(xscale="log", yscale="log")
    panels[0, 0].set_xticks(SCALES, [f"{s:g}" for s in SCALES])
    panels[0, 0].minorticks_off()
    top = [
        t
        for t in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
        if t < 1.3 * max(np.max(f) for f in forces.values())
    ]
    panels[0, 0].set_yticks(top, [f"{t:g}" for t in top])
    for row in panels:
        row[0].set_ylabel("largest force in joint B\nover load sharing [-]")
    reach = np.array([forces[shape] for shape in SHAPES])
    for axes, point, factor in zip(panels.flat, places, by_thresholds(reach), strict=False):
        axes.set_title(f"{words(point)}: ×\u00a0{factor:.3g} apart", fontsize="medium")
    say(figure, spread(reach, places))
    legend_below(figure, panels[0, 0])
    return figure


def words(point: tuple[float, float]) -> str:
    return label(point).replace("\n", ", ")


def by_thresholds(forces: np.ndarray) -> np.ndarray:
    """Factor by which scales of the thresholds part the forces (shapes, places, scales) of each
    place.
    """
    return (forces.max(axis=2) / forces.min(axis=2)).max(axis=0)


def spread(forces: np.ndarray, places: list) -> str:
    """By how much shapes and thresholds part the forces (shapes, places, scales), and at which
    place the most.
    """
    shapes = 100.0 * (forces.max(axis=0) / forces.min(axis=0) - 1.0).max()
    factors = by_thresholds(forces)
    worst, others = int(factors.argmax()), np.sort(factors)[:-1]
    text = (
        f"Halved and doubled thresholds part by a factor of {factors[worst]:.3g} at "
        f"{words(places[worst])}"
    )
    if others.size:
        text += (
            f", in the other {others.size} panel{'s' * (others.size > 1)} by {others[0]:.3g} "
            f"to {others[-1]:.3g}"
        )
    text += f". Three shapes of the memberships part by {shapes:.2g} % at most."
    return f"{text} Crosses: warned of a force hole."
