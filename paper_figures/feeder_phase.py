"""Phase portraits and Poincare sections of slider and journal B of the six-bar feeder, four models
of the joint.

Group: feeder

Answers: Jin et al. (2023), phase diagrams and Poincare maps of the mechanism with dry, lubricated
and transitional clearance.

Reproduced: velocity over position and acceleration over velocity of the slider, and the journal's
radial rate over its eccentricity, over the last turns. Also the sections once a turn at crank angle
0, where a motion with the period of the drive is one point. At 150 and 600 rpm, clearance 0.2 mm.
With
oil: one point. Dry: clouds.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 5 mPa s, fuzzy
transition. Dry sections fill clouds: the motion does not repeat in the turns run. Chaos is a matter
of its Lyapunov exponent.

Not comparable: the source's speeds and clearances of its maps, which were not in the part we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import (
    CLEARANCE,
    DRY,
    FILM,
    IDEAL,
    MODELS,
    OIL,
    STYLES,
    TRANSITIONAL,
    feeder,
    say,
)
from clearance.postprocess.channels import kept
from clearance.postprocess.figures import finish, legend_below, sheet, trajectory
from clearance.postprocess.sections import section

import clearance as cl

SPEEDS = (150, 600)
#: turns of a run for its sections
TURNS = {DRY: 220, FILM: 30, TRANSITIONAL: 30}
#: marks of a section
MARKS = {
    DRY: {"marker": "o", "ms": 3, "mew": 0},
    FILM: {"marker": "s", "ms": 9, "mfc": "none", "mew": 1.3},
    TRANSITIONAL: {"marker": "D", "ms": 6, "mfc": "none", "mew": 1.3},
}
#: turns left out of sections, turns of a portrait
SETTLE, PORTRAIT = 20, 1.0
#: spread of the journal over the clearance below which a motion repeats
REPEATS = 1e-3
PER_TURN = 400
KEPT = ("bodies/slider/*x", "joints/B/eccentricity_*")


def draw(work: workshop.Workshop) -> None:
    runs = {(n, m): run(work, n, m) for n in SPEEDS for m in TURNS}
    fine = {
        (n, m): feeder(work, **MODELS[m], speed=cl.rpm(n), turns=4) for n in SPEEDS for m in MODELS
    }
    work.keep(portraits(fine), "portraits")
    work.keep(sections(runs), "sections")
    heads = ["rpm", "joint B", "passages", "spread of x [um]", "of v [mm/s]", "of journal B / c"]
    rows = [[n, m, *spread(result)] for (n, m), result in runs.items()]
    work.table(
        heads, rows, remarks="Spread: standard deviation over the passages of crank angle 0."
    )


def run(work: workshop.Workshop, speed: float, model: str):
    turns = work.less(TURNS[model], SETTLE + 15)
    options = {"turns": turns, "samples_per_turn": PER_TURN, "channels": list(KEPT)}
    parameters = {"clearance": CLEARANCE, "viscosity": OIL, "speed": cl.rpm(speed)}
    return work.run("six_bar_feeder", MODELS[model] | parameters, **options)


def repeating(runs: dict) -> str:
    """The models whose motion repeats every turn, and the source's statement."""
    once = [m for m in TURNS if all(spread(runs[n, m])[-1] < REPEATS for n in SPEEDS)]
    clouds = [m for m in TURNS if m not in once]
    met = "met" if DRY in clouds and len(once) == 2 else "not met"
    text = f"One point a turn: {', '.join(once) or 'none'}; clouds: {', '.join(clouds) or 'none'}"
    return (
        f"{text}. Source: dry clearance makes the motion irregular, oil keeps it periodic; {met}."
    )


def portraits(runs: dict):
    """A row for each speed: slider x-v, v-a, and the journal's eccentricity and its rate."""
    figure = sheet(10.0, 6.8)
    panels = figure.subplots(len(SPEEDS), 3)
    order = (DRY, FILM, TRANSITIONAL, IDEAL)
    for speed, model in sorted(runs, key=lambda key: order.index(key[1])):
        run = runs[speed, model]
        row, late = panels[SPEEDS.index(speed)], kept(run, last=PORTRAIT)
        slider = run["slider"]
        pairs = [(1e3 * slider.x[late], slider.vx[late]), (slider.vx[late], slider.ax[late])]
        if model != IDEAL:
            ratio = np.hypot(*run.joint("B").eccentricity[late].T) / CLEARANCE
            pairs.append((ratio, 1e3 * CLEARANCE * np.gradient(ratio, run.time[late])))
        for axes, (x, y) in zip(row, pairs, strict=False):
            trajectory(axes, x, y, **{"lw": 1.3, "label": model} | STYLES[model])
    labels = (
        ("slider position [mm]", "its velocity [m/s]"),
        ("slider velocity [m/s]", "its acceleration [m/s²]"),
        ("eccentricity ratio of journal B [-]", "its radial speed [mm/s]"),
    )
    for row, speed in zip(panels, SPEEDS, strict=True):
        for axes, (x, y) in zip(row, labels, strict=True):
            finish(axes, y, x, legend=False)
        row[1].set_yscale("symlog", linthresh=10.0 * round(speed / 150) ** 2)
        row[0].set_title(f"{speed} rpm", fontsize="medium", loc="left")
    claim = "dry clearance scatters acceleration by far more than velocity"
    say(
        figure,
        f"Last turn, dry in thin lines behind the others. Source: {claim}; {scattered(runs)}.",
    )
    legend_below(figure, panels[0, 0])
    return figure


def scattered(runs: dict) -> str:
    """Largest departure of the dry motion from the ideal one, over the ideal motion's largest
    value.
    """
    apart = []
    for channel in ("vx", "ax"):
        dry, ideal = (getattr(runs[SPEEDS[0], m]["slider"], channel) for m in (DRY, IDEAL))
        apart.append(np.abs(dry - ideal).max() / np.abs(ideal).max())
    answer = "met" if apart[1] > 2.0 * apart[0] else "not met"
    return (
        f"{answer} (by {apart[0]:.2g} of the ideal velocity, {apart[1]:.2g} of the ideal "
        "acceleration)"
    )


def sections(runs: dict):
    """A row for each speed: slider and journal when the crank passes 0 degrees."""
    figure = sheet(7.6, 7.6)
    panels = figure.subplots(len(SPEEDS), 2)
    circle = np.linspace(0.0, 2.0 * np.pi, 361)
    for (speed, model), run in runs.items():
        x, v, ex, ey = points(run).T
        row = panels[SPEEDS.index(speed)]
        label = f"{model}, {len(x)} passages"
        shown = {"ls": "", "color": STYLES[model]["color"], "label": label} | MARKS[model]
        row[0].plot(1e3 * x, v, **shown)
        row[1].plot(ex, ey, **shown)
    for row, speed in zip(panels, SPEEDS, strict=True):
        finish(row[0], "its velocity [m/s]", "slider position [mm]", legend=False)
        row[0].ticklabel_format(useOffset=False)
        row[0].locator_params(axis="x", nbins=5)
        row[0].set_title(f"{speed} rpm, crank angle 0°", fontsize="medium", loc="left")
        row[1].plot(np.cos(circle), np.sin(circle), color="0.5", lw=0.8)
        row[1].set_aspect("equal")
        row[1].set_xticks(np.linspace(-1.0, 1.0, 5))
        row[1].set_yticks(np.linspace(-1.0, 1.0, 5))
        finish(row[1], "eccentricity y / c [-]", "eccentricity x / c [-]", legend=False)
    say(figure, repeating(runs))
    legend_below(figure, panels[0, 0])
    return figure


def points(run) -> np.ndarray:
    """Position and velocity of the slider and the journal over its clearance, once a turn: (turns,
    4).
    """
    names = ("slider.x", "slider.vx", "B.epsilon_x", "B.epsilon_y")
    return section(run, names, settle=SETTLE)


def spread(run) -> list:
    """Passages, and standard deviations of position [um], velocity [mm/s] and journal over them."""
    values = points(run)
    x, v, *journal = values.std(axis=0)
    return [len(values), float(1e6 * x), float(1e3 * v), float(np.hypot(*journal))]
