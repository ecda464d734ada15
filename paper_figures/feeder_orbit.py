"""Path of journal B in its clearance circle: dry, film only, transitional.

Group: feeder

Answers: Jin et al. (2023), the centre orbit of the journal in the clearance joint, dry, lubricated
and transitional.

Reproduced: the path relative to the bearing's centre, along the fixed axes, over the last turns at
300 rpm and 0.2 mm. Its colour is the state of the joint: free flight and contact where it is dry,
with oil the state of the film thickness ratio. Film only, the film carries all at every ratio; its
colours mark where a rough surface would touch. Below, how much of the clearance is left between the
surfaces over the last turn. The dry journal penetrates by
micrometres: it stands beyond the circle there, and its gap is negative. The sentence tests both
halves of the
statement: contacts and flights of the dry journal, and the share of the time that each journal is
next to the wall.

Assumed: parameter set feeder-A, oil of 5 mPa s, fuzzy transition, roughness 0.8 um, restitution
0.9, friction coefficient 0.1.

Not comparable: size and place of the orbit; clearances, loads and oil of the source are not known
to us.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_film_ratio import THRESHOLDS
from clearance.paper_figures.feeder_slider import DRY, FILM, MODELS, TRANSITIONAL, feeder, say
from clearance.postprocess.channels import abscissa, kept
from clearance.postprocess.figures import degrees, finish, legend_below, sheet, trajectory
from clearance.postprocess.plots import FLIGHT, MEMBERSHIPS, STATES, touched

from clearance.laws.transition import memberships
from clearance.scene.catalogue import find_case

#: turns shown of the irregular motion and of the periodic ones
SHOWN = {DRY: 3.0, FILM: 1.0, TRANSITIONAL: 1.0}
#: gap over the clearance below which a journal is at the wall, and share of the time there from
#: which on it slides
WALL, SLIDES = 0.1, 0.9
#: share of the time in flight from which on a journal bounces
FLIES = 0.1
ROUGHNESS = find_case("six_bar_feeder").parameters["roughness"].default


def draw(work: workshop.Workshop) -> None:
    work.keep(orbits({name: feeder(work, **MODELS[name]) for name in SHOWN}))


def orbits(runs: dict):
    """Paths above, gaps over the crank's angle below."""
    figure = sheet(10.0, 6.9)
    panels = figure.subplots(2, 3, height_ratios=(1.5, 1.0))
    for (name, run), above, below in zip(runs.items(), *panels, strict=True):
        colours, state = states(run)
        path(above, run, SHOWN[name], colours, state)
        turns = f"last {SHOWN[name]:g} turns" if SHOWN[name] > 1.0 else "last turn"
        remark = " (colours: its ratio)" if name == FILM else ""
        above.set_title(f"{name}, {turns}{remark}", fontsize="medium")
        gap(below, run, colours, state)
    say(figure, crossings(runs))
    panels[0, 0].set_ylabel("eccentricity y / c [-]")
    panels[1, 0].set_ylabel("gap [µm]")
    legend_below(figure, *panels[0])
    return figure


def crossings(runs: dict) -> str:
    """Contacts and flights of the dry journal, how long each is at the wall, and the source's
    statement.
    """
    turns = {n: kept(r, last=SHOWN[n]) for n, r in runs.items()}
    state = touched(runs[DRY], "B", runs[DRY].time)[turns[DRY]]
    count = np.count_nonzero(np.diff(state.astype(int)) == 1) / SHOWN[DRY]
    flight = 1.0 - state.mean()
    near = {
        n: float(np.mean(r.joint("B").gap[turns[n]] < WALL * r.clearances["B"]))
        for n, r in runs.items()
    }
    bounces = "met" if count > 1.0 and flight > FLIES else "not met"
    shares = ", ".join(f"{n} {100.0 * near[n]:.0f} %" for n in (FILM, TRANSITIONAL, DRY))
    apart = [n for n in (FILM, TRANSITIONAL) if near[n] <= SLIDES]
    slides = f"not met with {' and '.join(apart)}" if apart else "met"
    return (
        f"Source: the dry journal bounces ({count:.0f} contacts a turn, {100.0 * flight:.0f} % of "
        f"the time in flight); "
        f"{bounces}.\nThe wet one slides along the wall (time within {WALL:g} c of it: {shares}); "
        f"{slides}."
    )


def states(run) -> tuple[dict, np.ndarray]:
    """Colours by state, and the state of every sample as an index into them."""
    joint = run.joint("B")
    if MEMBERSHIPS[0] in joint:
        return STATES, np.argmax([getattr(joint, name) for name in MEMBERSHIPS], axis=0)
    if "film_radial" in joint:
        weights = [memberships(float(r), *THRESHOLDS.values()) for r in ratio(run)]
        return STATES, np.argmax(weights, axis=1)
    return FLIGHT, touched(run, "B", run.time).astype(int)


def ratio(run) -> np.ndarray:
    """Film thickness ratio of joint B: gap over roughness."""
    return run.joint("B").gap / ROUGHNESS


def path(axes, run, turns: float, colours: dict, state: np.ndarray) -> None:
    late = kept(run, last=turns)
    x, y = run.joint("B").eccentricity[late].T / run.clearances["B"]
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color="0.3", lw=0.6)
    for name, colour, here in parts(colours, state[late]):
        trajectory(
            axes, np.where(here, x, np.nan), np.where(here, y, np.nan), color=colour, label=name
        )
    axes.set_aspect("equal")
    finish(axes, "", "eccentricity x / c [-]", legend=False)
    axes.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15))
    axes.set_xticks(np.linspace(-1.0, 1.0, 5))
    axes.set_yticks(np.linspace(-1.0, 1.0, 5))


def gap(axes, run, colours: dict, state: np.ndarray) -> None:
    angle, late, xlabel = abscissa(run, "angle", 1.0)
    gaps = 1e6 * run.joint("B").gap[late]
    for _, colour, here in parts(colours, state[late]):
        axes.plot(angle, np.where(here, gaps, np.nan), color=colour, lw=0.9)
    finish(axes, "", xlabel, legend=False)
    axes.set_xlim(0.0, 360.0)
    degrees(axes, most=5)
    words = f"smallest {gaps.min():.3g} µm"
    if colours is STATES:
        words += f"\nfilm thickness ratio {ratio(run)[late].min():.2g}"
    axes.text(0.58, 0.95, words, transform=axes.transAxes, ha="center", va="top", fontsize="small")


def parts(colours: dict, state: np.ndarray):
    """Name, colour and samples of each state that occurs; a state holds from the sample before
    on.
    """
    for i, (name, colour) in enumerate(colours.items()):
        here = state == i
        here[:-1] |= here[1:]
        if here.any():
            yield name, colour, here
