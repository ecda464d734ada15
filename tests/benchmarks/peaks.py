"""Located extremes, right and dear, and a long dry run: `python tests/benchmarks/peaks.py
[--update]`.

Errors: extremes of the turns after the first at each rtol, against 1e-11. Costs: time of the
compiled loop with located extremes over the same loop that looks at step ends only, for the energy
ledger, and over one without any look. They are medians of ratios of runs made in turn; in dry
joints the peaks of each contact are part of it.
Long run: 20,000 turns of the feeder with a dry joint (some four minutes).
"""

import statistics

import numpy as np
from publishing import publish, require

import clearance as cl
from clearance.results.recorder import Memory
from clearance.run.recording import record_run
from clearance.run.run import Run
from clearance.simulation import prepare
from clearance.stepping import status
from clearance.stepping.state import PEAKS

BEGIN = "<!-- peaks -->"
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8)
EXACT = 1e-11
#: at rtol 1e-6: largest error and median that are requested
WORST, MEDIAN = 1e-5, 1e-6
# ratio of the loop with located extremes to the one that looks at step ends, of films
DEAREST = 1.10
REPEATS = 15
LONG, LOST = 20_000, 1e-6  # turns; share of the energy of a stretch that it may lose
CASES = {
    "six_bar_feeder": {},
    "slider_crank -p model=lubricated -p viscosity=0.04": {
        "model": "lubricated",
        "viscosity": 0.04,
    },
    "six_bar_feeder -p model=mixed -p transition=load_sharing": {
        "model": "mixed",
        "transition": "load_sharing",
    },
    "six_bar_feeder -p model=dry": {"model": "dry"},
    "slider_crank -p model=dry": {"model": "dry"},
}


def scene_of(name: str) -> cl.Scene:
    return cl.load_case(name.partition(" ")[0], **CASES[name])


def errors(scene: cl.Scene, rtol: float, exact) -> np.ndarray:
    """Relative errors of all extremes that are not zero."""
    located = cl.simulate(scene, turns=3, rtol=rtol).located
    pairs = [(located.of(n, scene.turn).value, exact.of(n, scene.turn).value) for n in exact.names]
    return np.array([abs(a / b - 1.0) for a, b in pairs if abs(b) > 1e-9])


def convergence(name: str) -> str:
    scene = scene_of(name)
    exact = cl.simulate(scene, turns=3, rtol=EXACT).located
    cells = []
    for rtol in TOLERANCES:
        e = errors(scene, rtol, exact)
        cells.append(f"{np.median(e):.1e} / {e.max():.1e}")
        if rtol == 1e-6:
            require(e.max() < WORST, f"{name}: an extreme is off by {e.max():.1e}")
            require(np.median(e) < MEDIAN, f"{name}: the median of errors is {np.median(e):.1e}")
    return f"| `{name}` | {len(exact.names)} | {' | '.join(cells)} |"


def loop_time(scene: cl.Scene, turns: int, looks: str) -> tuple[float, int]:
    """Seconds in the compiled loop and steps; looks: "located", "step ends" or "none"."""
    run = prepare(scene, turns=turns)
    if looks != "located":
        run.state.contacts[:, PEAKS] = -1
        run.resize(peaks=0, ledger=run.state.sizes["ledger"] if looks == "step ends" else 0)
        run.state.watched = looks == "step ends"
    advance(run)
    return run.wall, int(run.state.steps)


def advance(run: Run) -> None:
    while run.advance() == status.RUNNING:
        pass


def cost(name: str) -> str:
    scene, turns = scene_of(name), 40 if "dry" not in name else 10
    ratios: dict[str, list] = {"step ends": [], "none": []}
    for _ in range(REPEATS):
        located, steps = loop_time(scene, turns, "located")
        for looks, stored in ratios.items():
            stored.append(located / loop_time(scene, turns, looks)[0])
    ends, none = (statistics.median(ratios[looks]) for looks in ("step ends", "none"))
    require(
        ends < DEAREST or "dry" in name,
        f"{name}: locating extremes costs {ends - 1.0:.0%} of the loop",
    )
    return f"| `{name}` | {1e6 * located / steps:.2f} us | {ends:.3f} | {none:.3f} |"


def long_run() -> list[str]:
    """20,000 dry turns: the worst stretch of the ledger."""
    scene = cl.load_case("six_bar_feeder", model="dry")
    run = prepare(scene, turns=LONG, samples_per_turn=4)
    sink = Memory(run.mechanism.layout.channels, {})
    failure = record_run(run, sink)
    record, steps = sink.record, int(run.state.steps)
    share, energy = record.solver["energy_residual_share"], record.facts("energy")
    require(failure is None and share < LOST, f"{LONG} dry turns lose {share:.1e} of a stretch")
    return [
        f"{LONG} turns of the dry feeder at rtol 1e-6: {steps / 1e6:.1f} million steps in "
        f"{run.wall:.0f} s of the "
        f"compiled loop; the worst stretch loses {share:.1e} of its energy, "
        f"the whole run {energy['largest_residual']:.1e} J of "
        f"{energy['turned_over']:.0f} J.",
    ]


def tables() -> list[str]:
    heads = " | ".join(f"rtol {rtol:.0e}" for rtol in TOLERANCES)
    films = [name for name in CASES if "dry" not in name]
    return [
        f"| median / worst error | extremes | {heads} |",
        f"|---|---|{'---|' * len(TOLERANCES)}",
        *map(convergence, films),
        "",
        "| cost of the loop | a step | over looks at step ends only | over no look |",
        "|---|---|---|---|",
        *map(cost, CASES),
        "",
        *long_run(),
    ]


if __name__ == "__main__":
    publish(__doc__, tables, BEGIN)
