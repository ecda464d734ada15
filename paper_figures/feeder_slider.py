"""Slider of the six-bar feeder: displacement, velocity, acceleration with four models of joint B.

Group: feeder

Answers: Jin et al. (2023), displacement, velocity and acceleration of the slider with ideal joints,
with dry, with lubricated and with transitional clearance.

Reproduced: the four models at 300 rpm and a radial clearance of 0.2 mm. They are ideal, dry
(Lankarani-Nikravesh contact, Coulomb friction), film only (the Reynolds equation's), and
transitional. The last is the source's: film and contact weighted by fuzzy states of the film
thickness ratio. Both oils have 5 mPa s, so thin that the journal comes down to the roughness. At 50
mPa s the transitional joint never leaves full film. Deviations from the ideal slider, which the eye
does not see in the motion itself, have panels of their own.

Assumed: all lengths, masses and inertias, joint dimensions, material, oil, roughness 0.8 um,
restitution 0.9 and friction coefficient 0.1 (parameter set feeder-A). Also memberships
(half-cosines at film thickness ratios 0.4, 1, 3). The dry motion is irregular: its curves are one
sample of many, its means carry half their 95 % interval.

Not comparable: amplitudes and peaks. Of lengths, speeds and clearances the part of the source we
had gives none but the distances of the pivots A and D.
"""

from textwrap import fill

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.channels import abscissa, kept
from clearance.postprocess.figures import STROKES, degrees, finish, legend_below, line, sheet

from clearance.metrics.statistics import FEWEST, mean

#: oil of both wet models [Pa s] and radial clearance [m] of the studies, unless they vary it
OIL = 0.005
CLEARANCE = 2e-4
IDEAL = "ideal"
DRY = "dry"
FILM = "film only"
TRANSITIONAL = "transitional"
ELASTIC = "elastic transitional"
#: models of joint B: name -> parameters of the case
MODELS = {
    IDEAL: {"model": "ideal"},
    DRY: {"model": "dry"},
    FILM: {"model": "lubricated"},
    TRANSITIONAL: {"model": "mixed"},
}
#: of studies with rigid and elastic surfaces side by side
COMPARED = MODELS | {ELASTIC: {"model": "mixed", "elastic": "true"}}
#: of which model a curve is, everywhere
STYLES = {
    IDEAL: STROKES[0],
    DRY: STROKES[1] | {"lw": 0.5},
    FILM: STROKES[2],
    TRANSITIONAL: STROKES[3],
    ELASTIC: STROKES[5],
}
#: growth from which on a study calls something grown
GROWN = 1.02
#: turns; samples in a turn; turns left out at the start. Samples are 25 us apart: peaks of the dry
#: acceleration are within 1 % of those at a quarter of that.
TURNS, PER_TURN, SETTLE = 12, 8000, 2
#: spread of turns, over their mean, below which they are the same
SAME = 1e-4
KEPT = ("bodies/slider/*x", "joints/[BCE]/*", "drives/*")
#: rates of the slider: channel, factor to printed units, label, its units, those of deviations,
#: factor to them
RATES = (
    ("x", 1e3, "displacement", "mm", "µm", 1e6),
    ("vx", 1.0, "velocity", "m/s", "mm/s", 1e3),
    ("ax", 1.0, "acceleration", "m/s²", "m/s²", 1.0),
)


def draw(work: workshop.Workshop) -> None:
    runs = models(work)
    work.keep(motion(runs), "motion")
    work.keep(deviations(runs), "deviations")
    work.table(*peaks(runs), "peaks", f"Of {turns_seen(runs)} turns after {SETTLE}.")


def models(work: workshop.Workshop) -> dict:
    """A run of each model, at the same times."""
    return {name: feeder(work, **parameters) for name, parameters in MODELS.items()}


def feeder(work: workshop.Workshop, turns: float = TURNS, **parameters):
    """A finely sampled run of the feeder; fewer turns and samples in previews."""
    parameters = {"clearance": CLEARANCE, "viscosity": OIL} | parameters
    turns, samples = work.less(turns, SETTLE + 2), work.less(PER_TURN, 2000)
    return work.run(
        "six_bar_feeder", parameters, turns=turns, samples_per_turn=samples, channels=list(KEPT)
    )


def conclude(figure, quantity: str, values: dict[str, tuple[float, float]], claim: str) -> None:
    """Above the panels: by how much a quantity grows in each model, and where the source's claim is
    met.
    """
    grown = {name: last / first for name, (first, last) in values.items()}
    factors = ", ".join(f"{name} ×\u00a0{g:.3g}" for name, g in grown.items())
    others = [name for name in grown if name != IDEAL]
    met = [name for name in others if grown[name] > GROWN]
    answers = {"met with": met, "not met with": [name for name in others if name not in met]}
    answer = "; ".join(f"{text} {', '.join(names)}" for text, names in answers.items() if names)
    say(figure, f"{quantity}: {factors}. Source: {claim}; {answer}.")


def say(figure, text: str) -> None:
    """Sentences above the panels, each line of them broken to the page."""
    width = round(13.5 * figure.get_size_inches()[0])
    figure.suptitle("\n".join(fill(line, width) for line in text.splitlines()), fontsize="medium")


def settled(run) -> slice:
    """Samples of the turns that count."""
    return kept(run, settle=SETTLE)


def turns_seen(runs: dict) -> int:
    run = next(iter(runs.values()))
    return round(run.time[-1] / run.turn) - SETTLE


def motion(runs: dict):
    """Displacement, velocity and acceleration over the last turn; the dry acceleration on a scale
    of its own.
    """
    figure = sheet(7.0, 8.6)
    panels = figure.subplots(4, 1, sharex=True)
    shown = (
        *((rate, runs) for rate in RATES[:2]),
        (RATES[2], [n for n in runs if n != DRY]),
        (RATES[2], [DRY]),
    )
    for axes, ((channel, factor, label, units, *_), names) in zip(panels, shown, strict=True):
        for name in names:
            angle, last, xlabel = abscissa(runs[name], "angle", 1.0)
            line(axes, angle, factor * getattr(runs[name]["slider"], channel)[last], **style(name))
        finish(axes, f"{label} [{units}]", "", legend=False)
    for axes, caption in zip(panels[2:], (f"{IDEAL}, {FILM}, {TRANSITIONAL}", DRY), strict=True):
        axes.set_title(caption, fontsize="small", loc="right", pad=2)
    say(figure, disturbed(runs, "ax", "acceleration"))
    return finished(figure, panels, xlabel)


def disturbed(runs: dict, channel: str, label: str) -> str:
    """Ratio of a rate of the slider to that with ideal joints, and the source's statement."""
    values = {n: getattr(r["slider"], channel)[settled(r)] for n, r in runs.items()}
    ratios, words = over_ideal(values, turns_seen(runs))
    met = "met" if ratios[DRY] > max(r for n, r in ratios.items() if n != DRY) else "not met"
    return (
        f"Largest {label} of a turn over the ideal one: {words}. Source: oil softens what dry "
        f"clearance does; {met}."
    )


def over_ideal(values: dict[str, np.ndarray], turns: int) -> tuple[dict[str, float], str]:
    """Largest size of each model's values in a turn over the ideal one's, as numbers and in
    print.
    """
    largest = {name: of_turn(v, turns) for name, v in values.items()}
    ratios = {name: v / largest[IDEAL] for name, v in largest.items() if name != IDEAL}
    return ratios, ", ".join(f"{name} ×\u00a0{ratio:.3g}" for name, ratio in ratios.items())


def deviations(runs: dict):
    """Motion of the slider beyond the ideal one: with oil on the left, dry on the right."""
    figure = sheet(9.0, 6.6)
    panels = figure.subplots(3, 2, sharex=True)
    for row, (channel, _, label, _, units, factor) in zip(panels, RATES, strict=True):
        for name in list(runs)[1:]:
            angle, last, xlabel = abscissa(runs[name], "angle", 1.0)
            beyond = getattr(runs[name]["slider"], channel) - getattr(
                runs[IDEAL]["slider"], channel
            )
            line(row[int(name == DRY)], angle, factor * beyond[last], **style(name))
        finish(row[0], f"deviation of\n{label} [{units}]", "", legend=False)
        finish(row[1], "", "", legend=False)
    for axes in panels[-1]:
        axes.set_xlabel(xlabel)
    say(figure, departures(runs))
    return finished(figure, panels.ravel(), xlabel, panels[0])


def departures(runs: dict) -> str:
    """Largest deviations in a turn over the ideal ranges, and the source's statement."""
    shares: dict[str, dict[str, float]] = {"x": {}, "ax": {}}
    for channel, share in shares.items():
        ideal = getattr(runs[IDEAL]["slider"], channel)
        for name, run in runs.items():
            if name != IDEAL:
                beyond = (getattr(run["slider"], channel) - ideal)[settled(run)]
                share[name] = of_turn(beyond, turns_seen(runs)) / float(np.ptp(ideal))
    words = ", ".join(
        f"{n} {100 * shares['x'][n]:.2g} % and {100 * shares['ax'][n]:.3g} %" for n in shares["x"]
    )
    met = "met" if all(shares["ax"][n] > 10.0 * shares["x"][n] for n in shares["x"]) else "not met"
    text = (
        "Largest deviation of displacement and of acceleration in a turn, over their ideal "
        f"ranges: {words}"
    )
    return (
        f"{text}. Source: clearance shows in the acceleration, hardly in the displacement; {met}."
    )


def style(name: str) -> dict:
    return {"lw": 1.2, "label": name} | STYLES[name]


def finished(figure, panels, xlabel: str, named=None):
    """A page of panels over the crank's angle with one legend below."""
    panels[-1].set_xlabel(xlabel)
    panels[-1].set_xlim(0.0, 360.0)
    degrees(panels[-1])
    figure.align_ylabels()
    legend_below(figure, *(panels[:1] if named is None else named))
    return figure


def peaks(runs: dict) -> tuple[list[str], list[list]]:
    """Heads and rows: ends of the motion in a turn, and of its deviation from the ideal one. They
    are means over turns, which do not grow with their number.
    """
    heads = [
        "joint B",
        "x min of a turn [mm]",
        "x max [mm]",
        "v min [m/s]",
        "v max [m/s]",
        "a min [m/s2]",
        "a max [m/s2]",
        "a rms [m/s2]",
        "largest abs. a of a turn [m/s2]",
        "deviation of x, max of a turn [um]",
        "of v, max [mm/s]",
        "of a, rms [m/s2]",
    ]
    rows, turns = [], turns_seen(runs)
    for name, run in runs.items():
        now, ideal = (
            [getattr(r["slider"], c[0])[settled(r)] for c in RATES] for r in (run, runs["ideal"])
        )
        x, v, a = now
        dx, dv, da = (p - q for p, q in zip(now, ideal, strict=True))
        rows.append(
            [
                name,
                *ends(1e3 * x, turns),
                *ends(v, turns),
                *ends(a, turns),
                rms(a),
                by_turns(np.abs(a), turns),
                1e6 * of_turn(dx, turns),
                1e3 * of_turn(dv, turns),
                rms(da),
            ]
        )
    return heads, rows


def in_turns(values: np.ndarray, turns: int) -> np.ndarray:
    """Values turn by turn, (turns, samples)."""
    return values[: len(values) // turns * turns].reshape(turns, -1)


def ends(values: np.ndarray, turns: int) -> tuple[float, float]:
    """Means over turns of the smallest and of the largest value of each."""
    rows = in_turns(values, turns)
    return float(rows.min(axis=1).mean()), float(rows.max(axis=1).mean())


def turn_peaks(values: np.ndarray, turns: int) -> np.ndarray:
    """Largest size of the values in each turn."""
    return in_turns(np.abs(values), turns).max(axis=1)


def of_turn(values: np.ndarray, turns: int) -> float:
    """Mean over turns of the largest size of each: it does not grow with their number."""
    return float(turn_peaks(values, turns).mean())


def by_turns(values: np.ndarray, turns: int) -> str:
    """Mean over turns of the largest value of each, with half its 95 % interval where turns
    differ.
    """
    largest = turn_peaks(values, turns)
    if turns < FEWEST or np.ptp(largest) <= SAME * largest.mean():
        return f"{largest.mean():.4g}"
    return str(mean(largest))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
