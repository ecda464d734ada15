"""Models of joint B compared: Flores' hybrid, fuzzy transition, load sharing; Lankarani-Nikravesh,
IMPACT.

Group: feeder

Answers: Jin et al. (2023), their lubrication model against that of Flores, and their dry contact
against ADAMS.

Reproduced: slider acceleration and force in joint B. Lubrication, at 300 rpm and 0.1 mm: the film
fades by memberships (fuzzy), over a tolerance of 0.05 c beyond the wall (Flores), or never (load
sharing). All three are one model as long as the film is thick. The curves therefore have an oil
thin enough for them to part. Contact, at 0.2 mm: Lankarani-Nikravesh with a restitution of 0.9
beside ADAMS' IMPACT, which has no restitution. IMPACT is matched twice on one reference impact, a
free body with the median speed and mass of the contacts. Once its damping gives the restitution
that Lankarani-Nikravesh delivers, with Hertz's stiffness. Once its stiffness gives the same peak
force as well. Over 150 to 600 rpm the picture has forces and accelerations of each and by what
factor they differ. A match of one impact is none of the mechanism: IMPACT's damping has a depth
from where it acts, so that slow contacts lose less.

Assumed: parameter set feeder-A; memberships (half-cosines at film thickness ratios 0.4, 1, 3),
Flores' tolerance. IMPACT's damping is full from a tenth of the reference impact's depth. The source
gives none of these. The solid contact of all mixed joints is Winkler's. Dry
motions are irregular: compared are their statistics over ten turns, not their curves.

Not comparable: the source's curves and peaks of either comparison; its settings of ADAMS are not
known to us.
"""

import math
from dataclasses import dataclass

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import (
    CLEARANCE,
    SETTLE,
    feeder,
    finished,
    rms,
    say,
    settled,
    turns_seen,
)
from clearance.postprocess.channels import abscissa
from clearance.postprocess.contacts import contacts_of
from clearance.postprocess.figures import finish, legend_below, line, marker, sheet, stroke
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import clearance as cl

#: oils of the table, and the one of the curves [Pa s]
OILS, THIN = (0.005, 0.001, 0.0005), 0.0005
TRANSITIONS = {"Flores hybrid": "flores", "fuzzy": "fuzzy", "load sharing": "load_sharing"}
LN = "Lankarani-Nikravesh"
SAME_RESTITUTION = "IMPACT, same restitution"
SAME_PEAK = "IMPACT, same restitution and peak"
CONTACTS = (LN, SAME_RESTITUTION, SAME_PEAK)
SPEEDS = (150, 300, 600)
#: speed of the curves and of the reference impact [rpm]
CURVES = 300
RESTITUTION = 0.9
#: depth from which IMPACT's damping is full, over the reference impact's
DEPTH = 0.1
#: crank angles about the peak that is enlarged [deg]
PEAK = (310.0, 318.0)


def draw(work: workshop.Workshop) -> None:
    oils = work.less(OILS, (THIN,))
    mixed = {
        (oil, name): feeder(
            work, model="mixed", transition=law, clearance=1e-4, viscosity=oil, turns=SETTLE + 3
        )
        for oil in oils
        for name, law in TRANSITIONS.items()
    }
    work.keep(transitions({name: mixed[THIN, name] for name in TRANSITIONS}), "transitions")
    dry = contact_runs(work)
    at_rest = {name: runs[CURVES] for name, runs in dry.items()}
    work.keep(contacts(at_rest), "contacts")
    work.keep(trends(dry), "impact")
    rows = [
        [f"{name}, {1e3 * oil:g} mPa s", CURVES, *numbers(run)]
        for (oil, name), run in mixed.items()
    ]
    rows += [[name, n, *numbers(run)] for name, runs in dry.items() for n, run in runs.items()]
    heads = [
        "joint B",
        "rpm",
        "largest abs. acceleration [m/s2]",
        "its rms [m/s2]",
        "largest force B [N]",
        "its rms [N]",
        "its mean [N]",
        "contacts a turn",
        "time in contact [%]",
        "time solids carry over 1 % [%]",
        "median speed after / before contact",
    ]
    remark = (
        f"Mixed: of 3 turns after {SETTLE}. Dry: of {turns_seen(at_rest)} turns after {SETTLE}. "
        "Contact of load sharing is that of the bulk; its asperities carry from afar."
    )
    work.table(heads, rows, remarks=remark)


@dataclass(frozen=True)
class Impact:
    """A free body against the joint's wall: mass [kg] and speed [m/s]."""

    mass: float
    speed: float

    @classmethod
    def of(cls, run) -> "Impact":
        """The median speed of a run's contacts, and the mass whose elastic impact has their peak
        forces.
        """
        events, stiffness = whole(run), hertz_stiffness()
        speed, force = events["impact_speed"], events["peak_force"]
        # energy of an elastic impact: m v^2 / 2 = (2 / 5) F^(5/3) / K^(2/3)
        mass = 0.8 * force ** (5.0 / 3.0) / (stiffness ** (2.0 / 3.0) * speed**2)
        return cls(float(np.median(mass)), float(np.median(speed)))

    def outcome(self, law) -> tuple[float, float]:
        """Restitution that a contact law delivers, and its peak force [N]."""

        def rates(time, state):
            return state[1], -law(max(state[0], 0.0), state[1], self.speed) / self.mass

        def leaves(time, state):
            return state[0] if time > 0.0 else 1.0

        leaves.terminal, leaves.direction = True, -1.0
        longest = 20.0 * self.depth() / self.speed
        options = {"rtol": 1e-9, "atol": 1e-15, "events": leaves, "max_step": 1e-3 * longest}
        solution = solve_ivp(rates, (0.0, longest), (0.0, self.speed), **options)
        forces = [law(max(d, 0.0), v, self.speed) for d, v in solution.y.T]
        return float(-solution.y[1, -1] / self.speed), float(max(forces))

    def depth(self) -> float:
        """Penetration of an elastic impact with Hertz's stiffness [m]."""
        return (1.25 * self.mass * self.speed**2 / hertz_stiffness()) ** 0.4


def hertz_stiffness() -> float:
    """Stiffness of joint B's contact [N/m^1.5]."""
    return joint_law().parameters["stiffness"]


def joint_law():
    """Lankarani and Nikravesh's law in joint B."""
    scene = cl.load_case(
        "six_bar_feeder", model="dry", clearance=CLEARANCE, restitution=RESTITUTION
    )
    return next(j for j in scene.joints if j.name == "B").contact


def matched(impact: Impact) -> dict[str, str]:
    """IMPACT with the restitution, and with restitution and peak, that the reference law delivers:
    as words.
    """
    restitution, peak = impact.outcome(joint_law())
    depth = DEPTH * impact.depth()

    def law(stiffness: float):
        def lacks(exponent: float) -> float:
            law = cl.impact(stiffness=stiffness, damping=math.exp(exponent), depth=depth)
            return impact.outcome(law)[0] - restitution

        damping = math.exp(brentq(lacks, math.log(1e-3), math.log(1e5), xtol=1e-6))
        return cl.impact(stiffness=stiffness, damping=damping, depth=depth)

    def excess(factor: float) -> float:
        return impact.outcome(law(factor * hertz_stiffness()))[1] / peak - 1.0

    factor = brentq(excess, 0.3, 3.0, xtol=1e-6)
    laws = {SAME_RESTITUTION: law(hertz_stiffness()), SAME_PEAK: law(factor * hertz_stiffness())}
    return {
        name: f"impact({','.join(f'{k}={v:.9g}' for k, v in fitted.parameters.items())})"
        for name, fitted in laws.items()
    }


def contact_runs(work: workshop.Workshop) -> dict[str, dict]:
    """Runs of each contact by speed; IMPACT as matched on the contacts of the reference law."""
    first = feeder(work, model="dry", restitution=RESTITUTION, speed=cl.rpm(CURVES))
    words = {LN: "lankarani_nikravesh"} | matched(Impact.of(first))
    options = {"model": "dry", "restitution": RESTITUTION}
    speeds = work.less(SPEEDS, (CURVES,))
    return {
        name: {n: feeder(work, **options, contact=word, speed=cl.rpm(n)) for n in speeds}
        for name, word in words.items()
    }


def transitions(runs: dict):
    """Acceleration, force and film thickness ratio of three transitions over the last turn, and
    about its peak.
    """
    figure = sheet(9.5, 7.4)
    panels = figure.subplots(3, 2, sharex="col", width_ratios=(1.7, 1.0))
    for i, (name, run) in enumerate(runs.items()):
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        curves = (
            run["slider"].ax,
            np.hypot(*run.joint("B").force.T),
            run.joint("B").film_thickness_ratio,
        )
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
    """Dry: acceleration over the last turn, how contacts rebound, and how many of them exceed a
    force.
    """
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
    finish(
        above, "contacts a turn with a larger peak", "peak force of a contact [kN]", legend=False
    )
    above.set_yscale("log")
    legend_below(figure, above)
    return figure


def trends(dry: dict):
    """Mean and largest force and acceleration over the speed, and their ratios to the reference
    law.
    """
    figure = sheet(9.5, 6.8)
    panels = figure.subplots(2, 3, sharex=True, height_ratios=(1.4, 1.0))
    values = {name: {n: numbers(run) for n, run in runs.items()} for name, runs in dry.items()}
    shown = (
        ("mean force B [N]", 4),
        ("largest force B [N]", 2),
        ("largest acceleration [m/s²]", 0),
    )
    factors = []
    for (above, below), (label, column) in zip(panels.T, shown, strict=True):
        base = np.array([row[column] for row in values[LN].values()])
        others = []
        for i, (name, rows) in enumerate(values.items()):
            y = np.array([row[column] for row in rows.values()])
            style = stroke(i, len(values)) | {
                "marker": marker(i),
                "ms": 5,
                "lw": 1.2,
                "label": name,
            }
            above.plot(list(rows), y, **style)
            below.plot(list(rows), y / base, **style)
            others += [] if name == LN else (y / base).tolist()
        factors.append(f"{label.partition(' [')[0]} × {min(others):.2g} to {max(others):.2g}")
        finish(above, label, "", legend=False)
        finish(
            below,
            "over Lankarani-Nikravesh [-]" if column == 4 else "",
            "crank speed [rpm]",
            legend=False,
        )
        for axes in (above, below):
            axes.set_ylim(0.0, None)
        below.axhline(1.0, color="0.5", lw=0.8, ls=":")
    text = f"IMPACT, matched on one impact, over {LN}: {', '.join(factors)}"
    say(figure, f"{text}; {agreement(values)}.")
    legend_below(figure, panels[0, 0])
    return figure


def agreement(values: dict) -> str:
    """Agreement of the trends over the speed, law by law."""
    columns = {"mean force": 4, "largest force": 2, "largest acceleration": 0}
    signs = {
        name: [
            np.sign(np.diff([row[c] for row in rows.values()])).tolist() for c in columns.values()
        ]
        for name, rows in values.items()
    }
    same = [name for name in signs if name != LN and signs[name] == signs[LN]]
    if len(same) == len(signs) - 1:
        return "all grow with the speed alike"
    return f"trends over the speed agree with {' and '.join(same) or 'neither'}"


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
    touches, joint = contacts_of(run, "B", settle=SETTLE), run.joint("B")
    now = settled(run)
    acceleration, force = run["slider"].ax[now], np.hypot(*joint.force.T)[now]
    peak = max(float(force.max()), float(touches.peak_force.max(initial=0.0)))
    shared = (
        float(100.0 * (joint.asperity_share[now] > 0.01).mean())
        if "asperity_share" in joint
        else "-"
    )
    rebound = "-" if "film_radial" in joint else float(np.median(rebounds(run)))
    count = len(touches.time) / ((touches.end - touches.start) / run.turn)
    return [
        float(np.abs(acceleration).max()),
        rms(acceleration),
        peak,
        rms(force),
        float(force.mean()),
        float(count),
        100.0 * touches.share,
        shared,
        rebound,
    ]
