"""Film thickness ratio of joint B over a turn, and what the fuzzy transition makes of it: full
film, mixed, dry.

Group: feeder

Answers: Jin et al. (2023). Lubrication states of the joint by fuzzy sets of the film thickness
ratio, and their change over a turn of the crank.

Reproduced: the membership functions over the ratio of gap to roughness. The ratio over a turn at
300 rpm and 0.1 mm with two oils, 5 mPa s (as in the guide) and 1 mPa s. Both are so thin that the
joint enters the dry state. The memberships along it, which weigh film and contact, and the share of
the load on the solids.

Assumed: the memberships themselves, half-cosines with thresholds 0.4, 1, 3. The source names the
fuzzy sets; their functions were not in the part we had. Also roughness 0.8 um, Winkler's contact,
parameter set feeder-A. That contact begins where the ratio is 1 keeps the journal there: the dry
state is entered, not reached.

Not comparable: course and smallest value of the source's film thickness; its oil, roughness and
loads are not known to us.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import SETTLE, feeder, settled
from clearance.postprocess.channels import abscissa
from clearance.postprocess.figures import degrees, finish, line, plain_decades, sheet
from clearance.postprocess.plots import MEMBERSHIPS, STATES

from clearance.laws.transition import memberships

OILS = (0.005, 0.001)
THRESHOLDS = {"dry": 0.4, "mixed": 1.0, "full": 3.0}
#: dashes of the states beside their colours
DASHES = dict(zip(STATES, ("-", "--", "-."), strict=True))


def draw(work: workshop.Workshop) -> None:
    runs = {
        oil: feeder(work, model="mixed", clearance=1e-4, viscosity=oil, turns=SETTLE + 2)
        for oil in OILS
    }
    work.keep(functions(), "memberships")
    work.keep(regimes(runs))
    heads = [
        "oil [mPa s]",
        "smallest ratio",
        "mean ratio",
        *(f"mean membership {s} [%]" for s in STATES),
        "largest membership dry [%]",
        "load on the solids, mean [%]",
    ]
    work.table(heads, [[f"{1e3 * oil:g}", *numbers(run)] for oil, run in runs.items()])


def functions():
    """Memberships over the film thickness ratio."""
    figure = sheet(6.0, 3.2)
    axes = figure.subplots()
    ratio = np.geomspace(0.2, 6.0, 400)
    values = np.array([memberships(r, *THRESHOLDS.values()) for r in ratio]).T
    for (name, colour), curve in zip(STATES.items(), values, strict=True):
        axes.plot(ratio, curve, color=colour, ls=DASHES[name], lw=1.6, label=name)
    for name, limit in THRESHOLDS.items():
        axes.axvline(limit, color="0.5", lw=0.7, ls=":")
        axes.text(
            limit, 1.01, f" {name} {limit:g}", color="0.3", fontsize="small", ha="left", va="bottom"
        )
    finish(axes, "membership [-]", "film thickness ratio [-]", legend=False)
    axes.set(xscale="log", xlim=(ratio[0], ratio[-1]), ylim=(0.0, 1.1))
    plain_decades(axes.xaxis, ratio[0], ratio[-1])
    axes.legend(fontsize="small", loc="center right", frameon=True)
    return figure


def regimes(runs: dict):
    """Ratio, memberships and share of the solids over the last turn, a column for each oil."""
    figure = sheet(9.5, 6.8)
    panels = figure.subplots(3, len(runs), sharex=True, sharey="row", height_ratios=(1.3, 1.0, 0.7))
    for column, (oil, run) in zip(panels.T, runs.items(), strict=True):
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        joint = run.joint("B")
        line(column[0], angle, joint.film_thickness_ratio[last], color="black", lw=1.2)
        column[0].set_title(f"oil {1e3 * oil:g} mPa s", fontsize="medium")
        for name, limit in THRESHOLDS.items():
            column[0].axhline(limit, color="0.5", lw=0.7, ls=":")
            column[0].text(
                195.0, limit, f"{name} {limit:g}", color="0.3", fontsize="small", va="bottom"
            )
        weights = [getattr(joint, name)[last] for name in MEMBERSHIPS]
        column[1].stackplot(
            angle, *weights, colors=list(STATES.values()), labels=list(STATES), alpha=0.75, lw=0
        )
        column[2].fill_between(angle, 0.0, 100.0 * joint.asperity_share[last], color="0.4", lw=0)
        column[2].set_xlabel(xlabel)
    labels = ("film thickness ratio [-]", "memberships, stacked [-]", "load on the\nsolids [%]")
    for row, label in zip(panels, labels, strict=True):
        for axes in row:
            finish(axes, label if axes is row[0] else "", axes.get_xlabel(), legend=False)
    panels[0, 0].set(yscale="log", xlim=(0.0, 360.0))
    plain_decades(panels[0, 0].yaxis, *panels[0, 0].get_ylim())
    panels[1, 0].set_ylim(0.0, 1.0)
    panels[2, 0].set_ylim(0.0, 100.0)
    degrees(panels[0, 0])
    figure.align_ylabels()
    figure.legend(
        *panels[1, 0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=3,
        frameon=False,
    )
    return figure


def numbers(run) -> list[float]:
    """Extremes and means of ratio, memberships and load on the solids."""
    joint, now = run.joint("B"), settled(run)
    ratio = joint.film_thickness_ratio[now]
    weights = [getattr(joint, name)[now] for name in MEMBERSHIPS]
    means = [100.0 * float(w.mean()) for w in weights]
    share = 100.0 * float(joint.asperity_share[now].mean())
    return [float(ratio.min()), float(ratio.mean()), *means, 100.0 * float(weights[2].max()), share]
