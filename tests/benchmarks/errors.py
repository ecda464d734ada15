"""Stated against true errors, and errors that are requested: `python tests/benchmarks/errors.py
[--update]`.

Scenes of varied parameters, three turns each, settled numbers of the last two. True errors are
against rtol 1e-12. Statements: runs at 1e-4 ... 1e-8, each with its companion at ten times the
tolerance. Requests: the integration of all printed numbers, 1e-2 ... 1e-6; their time is that of
all compiled loops of the ladder over that of the cheapest run of complete decades whose true errors
are small enough, known only afterwards. With --update also draws the picture
paper_figures/stated_errors.png. Some minutes.
"""

import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from clearance.postprocess.study_pictures import stated_against_true
from publishing import publish, require

import clearance as cl
from clearance.accuracy.companion import (
    THROUGHOUT,
    CompanionFailed,
    Pair,
    Start,
    companion,
    size_of,
    stated,
)
from clearance.accuracy.request import Request, ToleranceSearch, printed
from clearance.metrics.metrics import metrics
from clearance.results.recorder import MemoryRecord
from clearance.run.run import Run
from clearance.simulation import prepare
from clearance.stepping import loop

BEGIN = "<!-- stated errors -->"
PICTURE = "paper_figures/stated_errors.png"
TURNS, SETTLE, SAMPLES = 3, 1.0, 200
EXACT, DECADES, STATED = 12, range(2, 10), range(4, 9)  # tolerances 10^-k
ASKED = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
FLOOR = 1e-11  # relative errors below it are those of the reference
#: what is requested: shares covered, median factor too large, median time of a request over the
#: cheapest run
METRICS_COVERED, TOO_LARGE, SLOWER = 0.97, 40.0, 5.0
MISSED = 0.02  # share of the requests that are stated as reached and are not: one of 65
rpm = cl.rpm
#: for each group: case, its parameters
SCENES = {
    "lubricated": [
        *(
            ("six_bar_feeder", {"speed": rpm(s), "clearance": c})
            for s in (100, 300, 600)
            for c in (5e-5, 1e-4, 3e-4)
        ),
        *(("six_bar_feeder", {"speed": rpm(s), "film": "pinkus_sternlicht"}) for s in (150, 450)),
        *(("six_bar_feeder", {"speed": rpm(s), "joints": "B,C,E"}) for s in (200, 400)),
        *(
            ("slider_crank", {"model": "lubricated", "speed": rpm(s), "viscosity": v})
            for s in (1500, 3000, 5000)
            for v in (0.4, 0.04)
        ),
        *(
            ("slider_crank", {"model": "lubricated", "film": f, "speed": rpm(2500)})
            for f in ("short", "harmonic")
        ),
        *(
            ("four_bar", {"model": "lubricated", "speed": rpm(s), "joints": j})
            for s in (200, 500)
            for j in ("C", "B,C")
        ),
        *(
            (
                "slider_crank",
                {"model": "lubricated", "speed": rpm(s), "clearance": 2e-4, "viscosity": 0.1},
            )
            for s in (1000, 4000)
        ),
        ("four_bar", {"model": "lubricated", "speed": rpm(1000), "joints": "C", "viscosity": 0.02}),
        ("six_bar_feeder", {"film": "short"}),
    ],
    "mixed": [
        *(
            ("six_bar_feeder", {"model": "mixed", "speed": rpm(s), "transition": t})
            for s in (100, 300, 600)
            for t in ("fuzzy", "load_sharing", "flores")
        ),
        *(
            (
                "slider_crank",
                {
                    "model": "mixed",
                    "viscosity": 0.02,
                    "clearance": 1e-4,
                    "speed": rpm(s),
                    "transition": t,
                },
            )
            for s in (1500, 3000)
            for t in ("fuzzy", "load_sharing", "flores")
        ),
        *(
            ("four_bar", {"model": "mixed", "speed": rpm(s), "viscosity": 0.005})
            for s in (100, 300)
        ),
        *(
            ("six_bar_feeder", {"model": "mixed", "speed": rpm(200), "clearance": c})
            for c in (5e-5, 2e-4)
        ),
        (
            "slider_crank",
            {"model": "mixed", "viscosity": 0.05, "clearance": 1e-4, "speed": rpm(4500)},
        ),
    ],
    "thin": [
        *(
            ("six_bar_feeder", {"model": "mixed", "speed": rpm(s), "viscosity": v, "transition": t})
            for s, v in ((60, 0.002), (300, 0.001))
            for t in ("fuzzy", "load_sharing", "flores")
        ),
        *(
            ("slider_crank", {"model": "lubricated", "viscosity": 0.004, "speed": rpm(s)})
            for s in (2000, 4000)
        ),
    ],
    "friction": [
        *(
            ("three_loop_chain", {"drive": "torque", "friction": f, "speed": s})
            for f, s in (("coulomb", 0.5), ("stribeck", 0.5), ("coulomb", 0.3))
        ),
        (
            "four_bar",
            {"model": "mixed", "speed": rpm(200), "viscosity": 0.005, "friction": "stribeck"},
        ),
        *(
            (
                "slider_crank",
                {"model": "mixed", "viscosity": 0.02, "clearance": 1e-4, "friction": f},
            )
            for f in ("coulomb", "stribeck")
        ),
        *(("double_pendulum", {"damping": d}) for d in (0.0, 0.02)),
    ],
}


class Cpu:
    """Seconds of CPU in the compiled loops of all runs that are made while it is entered."""

    def __enter__(self):
        self.seconds, self.plain = 0.0, loop.run

        def counted(*arguments):
            began = time.process_time()
            code = self.plain(*arguments)
            self.seconds += time.process_time() - began
            return code

        loop.run = counted
        return self

    def __exit__(self, *_):
        loop.run = self.plain


@dataclass
class Scene:
    """One scene: its runs in memory and their costs, by k of the tolerance 10^-k."""

    group: str
    name: str
    run: Run
    records: dict[int, MemoryRecord] = field(default_factory=dict)
    cpu: dict[int, float] = field(default_factory=dict)

    def __post_init__(self):
        self.start = Start.of(self.run)
        self.summed = partial(metrics, settle=self.settle)

    @property
    def settle(self) -> float | None:
        return SETTLE if self.run.mechanism.scene.turn else None

    def make(self, k: int) -> None:
        """A run, where it comes to its end."""
        try:
            with Cpu() as cpu:
                self.records[k] = companion(self.run, self.start, 10.0**-k)
            self.cpu[k] = cpu.seconds
        except CompanionFailed as reason:
            print("  ", reason, file=sys.stderr)

    def errors(self, k: int, other: int):
        """Stated errors of a run with a companion."""
        pair = Pair(self.records[k], self.records[other], (10.0**-k, 10.0**-other))
        return stated(pair, self.summed, self.settle, size_of(self.run.mechanism))

    def true(self, record: MemoryRecord, name: str) -> float:
        """True error of a number of a record."""
        exact, begin = self.records[EXACT], self.begin
        if name == "trajectory":
            pair = Pair(record, exact, (1.0, 1.0))
            return (
                stated(pair, self.summed, self.settle, size_of(self.run.mechanism))[name].stated
                / THROUGHOUT
            )
        if "/" in name:
            return abs(record.located.of(name, begin).value - exact.located.of(name, begin).value)
        return abs(self.summed(record)[name].value - self.summed(exact)[name].value)

    @property
    def begin(self) -> float:
        turn = self.run.mechanism.scene.turn
        return turn * SETTLE if turn else 0.0


def scenes() -> Iterator[Scene]:
    """All scenes, with the reference and the runs of complete decades."""
    for group, entries in SCENES.items():
        for case, values in entries:
            output = (
                f"{n}={v:.4g}" if isinstance(v, float) else f"{n}={v}" for n, v in values.items()
            )
            name = " ".join([case, *output])
            scene = cl.load_case(case, **values)
            length = {"turns": TURNS} if scene.turn else {"until": 2.0}
            one = Scene(group, name, prepare(scene, samples_per_turn=SAMPLES, **length))
            print(name, file=sys.stderr, flush=True)
            for k in (EXACT, *DECADES):
                one.make(k)
            if EXACT in one.records:
                yield one


@dataclass(frozen=True)
class Row:
    """A stated and a true error, relative; kind: trajectory, extreme or mean."""

    group: str
    kind: str
    rtol: float
    stated: float
    true: float
    name: str = ""


MEANS = ("_rms", "dissipated_per_turn")


def statements(one: Scene) -> Iterator[Row]:
    """Rows of one scene."""
    for k in (k for k in STATED if {k, k - 1} <= one.records.keys()):
        errors = one.errors(k, k - 1)
        for name, error in errors.items():
            kind = "trajectory" if name == "trajectory" else "extreme" if "/" in name else "mean"
            if kind == "mean" and not name.endswith(MEANS):
                continue
            size = 1.0 if kind == "trajectory" else abs(error.value)
            true = one.true(one.records[k], name)
            if size > 0.0 and true > FLOOR * size:
                yield Row(
                    one.group,
                    kind,
                    10.0**-k,
                    error.stated / size,
                    true / size,
                    f"{one.name}: {name}",
                )


@dataclass(frozen=True)
class Asked:
    """Outcome of a request: reached, refused or wrong; time of its runs over the cheapest
    sufficient one.
    """

    eps: float
    result: str
    slower: float
    plain: bool  # a run at rtol = eps would have done


def requests(one: Scene) -> Iterator[Asked]:
    """Requests of one scene."""
    for eps in ASKED:
        ladder = ToleranceSearch(one.run, Request.of({"integration": eps}), one.settle)
        with Cpu() as cpu:
            answer = ladder.climb()
        sufficient = [
            one.cpu[k] for k in DECADES if k in one.records and good(one, one.records[k], eps)
        ]
        result = (
            "refused"
            if answer.cannot
            else "reached"
            if good(one, answer.attempt.record, eps)
            else "wrong"
        )
        if result != "reached":
            print(
                f"   {eps:g} {result}: {answer.cannot or ladder.reached} {ladder.runs}",
                file=sys.stderr,
            )
        plain = one.records.get(round(-math.log10(eps)))
        slower = cpu.seconds / min(sufficient, default=math.nan)
        yield Asked(eps, result, slower, plain is not None and good(one, plain, eps))


def good(one: Scene, record: MemoryRecord, eps: float) -> bool:
    """All printed numbers of a run are truly within an error."""
    exact = one.errors(EXACT, EXACT)
    return all(one.true(record, n) <= eps * abs(exact[n].value) for n in printed(exact))


def table(rows: list[Row]) -> list[str]:
    """Shares covered and factors too large, by group and kind."""
    lines = [
        "| stated errors | kind | n | covered | too large by: median | 5 % | 95 % |",
        "|---|---|" + "---|" * 5,
    ]
    for group in [*SCENES, "all"]:
        for kind in ("trajectory", "extreme", "mean"):
            mine = [r for r in rows if group in (r.group, "all") and r.kind == kind]
            if not mine:
                continue
            factor = np.array([r.stated / r.true for r in mine])
            covered, (low, median, high) = (
                np.mean(factor >= 1.0),
                np.percentile(factor, (5, 50, 95)),
            )
            lines.append(
                f"| {group} | {kind} | {len(mine)} | {covered:.1%} | {median:.2g} | "
                f"{low:.2g} | {high:.2g} |"
            )
            if group == "all":
                wanted = 1.0 if kind == "trajectory" else METRICS_COVERED
                require(
                    covered >= wanted,
                    f"{covered:.2%} of {kind} errors are covered, {wanted:.0%} asked for",
                )
                require(
                    median <= TOO_LARGE,
                    f"{kind} errors are {median:.0f} times too large in the median",
                )
    return lines


def asked_table(asked: list[Asked]) -> list[str]:
    lines = [
        "| asked | n | reached | refused | wrong | time over the cheapest: median | 95 % | worst | "
        "rtol = request suffices |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for eps in ASKED:
        mine = [a for a in asked if a.eps == eps]
        counts = [sum(a.result == r for a in mine) for r in ("reached", "refused", "wrong")]
        slower = [a.slower for a in mine if a.result == "reached" and math.isfinite(a.slower)]
        median, high, worst = np.percentile(slower, (50, 95, 100))
        plain = np.mean([a.plain for a in mine])
        cells = [
            f"{eps:g}",
            len(mine),
            *counts,
            f"{median:.2g}",
            f"{high:.2g}",
            f"{worst:.2g}",
            f"{plain:.0%}",
        ]
        lines.append(f"| {' | '.join(map(str, cells))} |")
        require(
            counts[2] <= MISSED * len(mine),
            f"{counts[2]} requests of {eps:g} are stated as reached and are not",
        )
        require(median <= SLOWER, f"requests of {eps:g} take {median:.1f} times the cheapest run")
    return lines


def tables() -> list[str]:
    rows, asked, count = [], [], 0
    for one in scenes():
        rows += statements(one)
        asked += requests(one)
        count += 1
    require(count >= 60, f"{count} scenes")
    if "--update" in sys.argv:
        stated_against_true(rows, PICTURE)
    below = sorted((r for r in rows if r.stated < r.true), key=lambda r: r.stated / r.true)[:12]
    for r in below:
        print(f"{r.stated / r.true:.2f} {r.rtol:.0e} {r.true:.1e} {r.name}", file=sys.stderr)
    factors = [r.true / r.stated for r in rows if r.kind != "trajectory" and r.stated < r.true]
    numbers = sum(r.kind != "trajectory" for r in rows)
    larger = (
        f"{len(factors)} of {numbers} numbers have a larger error than stated: "
        f"{np.median(factors):.1f} times in the median, {max(factors):.1f} at most."
    )
    head = [f"{count} scenes, {TURNS} turns each.", ""]
    return [*head, *table(rows), "", larger, "", *asked_table(asked)]


if __name__ == "__main__":
    publish(__doc__, tables, BEGIN)
