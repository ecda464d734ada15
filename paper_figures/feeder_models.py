"""Models of joint B compared: Flores' hybrid, fuzzy transition, load sharing; Lankarani-Nikravesh, IMPACT.

Group: feeder

Answers: Jin et al. (2023), their lubrication model against that of Flores, and their dry contact against ADAMS.

Reproduced: slider acceleration and force in joint B at 300 rpm and 0.1 mm. Lubrication: the film fades by memberships
(fuzzy), over a tolerance of 0.05 c beyond the wall (Flores), or never (load sharing); all three are one model as long
as the film is thick, so that curves are drawn for an oil thin enough for them to part. Contact: Lankarani-Nikravesh
with restitutions 0.9 and 0.5, IMPACT with Hertz's stiffness and exponent 1.5. IMPACT knows no restitution; its damping
is what gives a free body of 0.1 kg at 1 m/s about 0.9 and 0.5. The median speed after over before contact is 0.93 and
0.78: it is grown only beyond a depth that slow contacts hardly reach, and heavy bodies lose less to it. With 0.91,
nearly the same, Lankarani-Nikravesh has a third of the forces. At 0.5 it delivers 0.73, as its formula does for any
impact. Single contacts rebound much faster or slower than the median, for the mechanism goes on driving them.

Assumed: parameter set feeder-A; memberships (half-cosines at film thickness ratios 0.4, 1, 3), Flores' tolerance, and
IMPACT's damping with its depth of 1.5 um, none of which we have from the source; the solid contact of all mixed joints
is Winkler's. Dry motions are irregular: compared are their statistics over ten turns, not their curves.

Not comparable: the source's curves and peaks of either comparison; its settings of ADAMS are not known to us.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import SETTLE, feeder, finished, rms, settled, turns_seen
from clearance.postprocess.channels import abscissa
from clearance.postprocess.contacts import contacts_of
from clearance.postprocess.figures import finish, legend_below, line, sheet, stroke

#: oils of the table, and the one of the curves [Pa s]
OILS, THIN = (0.005, 0.001, 0.0005), 0.0005
TRANSITIONS = {"Flores hybrid": "flores", "fuzzy": "fuzzy", "load sharing": "load_sharing"}
CONTACTS = {
    "Lankarani-Nikravesh, e = 0.9": {},
    "IMPACT, 440 N s/m": {"contact": "impact"},
    "Lankarani-Nikravesh, e = 0.5": {"restitution": 0.5},
    "IMPACT, 2900 N s/m": {"contact": "impact", "restitution": 0.5},
}
#: crank angles about the peak that is enlarged [deg]
PEAK = (310.0, 318.0)


def draw(work: workshop.Workshop) -> None:
    oils = work.less(OILS, (THIN,))
    mixed = {
        (oil, name): feeder(work, model="mixed", transition=law, viscosity=oil, turns=SETTLE + 3)
        for oil in oils
        for name, law in TRANSITIONS.items()
    }
    work.keep(transitions({name: mixed[THIN, name] for name in TRANSITIONS}), "transitions")
    dry = {name: feeder(work, model="dry", **parameters) for name, parameters in CONTACTS.items()}
    work.keep(contacts(dry), "contacts")
    rows = [[f"{name}, {1e3 * oil:g} mPa s", *numbers(run)] for (oil, name), run in mixed.items()]
    rows += [[name, *numbers(run)] for name, run in dry.items()]
    heads = [
        "joint B", "largest abs. acceleration [m/s2]", "its rms [m/s2]", "largest force B [N]", "its rms [N]",
        "its mean [N]", "contacts a turn", "time in contact [%]", "time solids carry over 1 % [%]",
        "median speed after / before contact",
    ]  # fmt: skip
    remark = (
        f"Mixed: of 3 turns after {SETTLE}. Dry: of {turns_seen(dry)} turns after {SETTLE}. "
        "Contact of load sharing is that of the bulk; its asperities carry from afar."
    )
    work.table(heads, rows, remarks=remark)


def transitions(runs: dict):
    """Acceleration, force and film thickness ratio of three transitions over the last turn, and about its peak."""
    figure = sheet(9.5, 7.4)
    panels = figure.subplots(3, 2, sharex="col", width_ratios=(1.7, 1.0))
    for i, (name, run) in enumerate(runs.items()):
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        curves = (run["slider"].ax, np.hypot(*run.joint("B").force.T), run.joint("B").film_thickness_ratio)
        near = (angle >= PEAK[0]) & (angle <= PEAK[1])
        for row, values in zip(panels, curves, strict=True):
            shown = {"lw": 1.2, "label": name} | stroke(i, len(runs))
            line(row[0], angle, values[last], **shown)
            line(row[1], angle[near], values[last][near], **shown)
    labels = ("slider acceleration [m/s²]", "force in joint B [N]", "film thickness ratio [-]")
    for row, label in zip(panels, labels, strict=True):
        finish(row[0], label, "", legend=False)
        finish(row[1], "", "", legend=False)
    panels[2, 0].set_yscale("symlog", linthresh=1.0)
    panels[2, 0].set_yticks([0, 1, 10], ["0", "1", "10"])
    panels[2, 1].set_yscale("symlog", linthresh=1.0)
    panels[2, 1].set_yticks([0, 1, 10], ["0", "1", "10"])
    panels[2, 1].set_xlabel(xlabel)
    return finished(figure, panels[:, 0], xlabel)


def contacts(runs: dict):
    """Dry: acceleration over the last turn, how contacts rebound, and how many of them exceed a force."""
    figure = sheet(9.5, 8.6)
    grid = figure.add_gridspec(len(runs), 2, width_ratios=(1.35, 1.0))
    curves = [figure.add_subplot(grid[i, 0]) for i in range(len(runs))]
    below, above = figure.add_subplot(grid[:2, 1]), figure.add_subplot(grid[2:, 1])
    for i, (axes, (name, run)) in enumerate(zip(curves, runs.items(), strict=True)):
        shown = stroke(i, len(runs)) | {"label": name}
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        line(axes, angle, 1e-3 * run["slider"].ax[last], **shown | {"lw": 0.5, "ls": "-"})
        finish(axes, "slider acc.\n[km/s²]", xlabel if axes is curves[-1] else "", legend=False)
        axes.set_xlim(0.0, 360.0)
        axes.set_xticks(range(0, 361, 45))
        ratio, bins = rebounds(run), np.linspace(0.0, 2.0, 41)
        share = 100.0 * np.histogram(ratio, bins)[0] / len(ratio)
        below.stairs(share, bins, color=shown["color"], ls=shown["ls"], lw=1.2)
        force = np.sort(whole(run)["peak_force"])[::-1]
        above.plot(1e-3 * force, np.arange(1, len(force) + 1) / turns_seen(runs), **shown)
    extreme = max(max(map(abs, axes.get_ylim())) for axes in curves)
    for axes in curves:
        axes.set_ylim(-extreme, extreme)
    finish(below, "share of contacts [%]", "normal speed after / before contact [-]", legend=False)
    below.set(xlim=(0.0, 2.0), ylim=(0.0, None))
    finish(above, "contacts a turn with a larger peak", "peak force of a contact [kN]", legend=False)
    above.set_yscale("log")
    legend_below(figure, above)
    return figure


def whole(run) -> dict[str, np.ndarray]:
    """Contacts of the settled turns that ended."""
    events = run.events
    late = (events["time"] >= SETTLE * run.turn) & (events["kind"] == "contact")
    return {name: values[late] for name, values in events.items()}


def rebounds(run) -> np.ndarray:
    """Normal speed after over before each contact."""
    events = whole(run)
    return np.abs(events["separation_speed"]) / events["impact_speed"]


def numbers(run) -> list:
    """Extremes and means of slider acceleration and force in joint B, contacts."""
    found, joint = contacts_of(run, "B", settle=SETTLE), run.joint("B")
    now = settled(run)
    acceleration, force = run["slider"].ax[now], np.hypot(*joint.force.T)[now]
    peak = max(float(force.max()), float(found.peak_force.max(initial=0.0)))
    shared = float(100.0 * (joint.asperity_share[now] > 0.01).mean()) if "asperity_share" in joint else "-"
    rebound = "-" if "film_radial" in joint else float(np.median(rebounds(run)))
    count = len(found.time) / ((found.end - found.start) / run.turn)
    return [
        float(np.abs(acceleration).max()), rms(acceleration), peak, rms(force), float(force.mean()), float(count),
        100.0 * found.share, shared, rebound,
    ]  # fmt: skip


if __name__ == "__main__":
    workshop.main(__file__)
