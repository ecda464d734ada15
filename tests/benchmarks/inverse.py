"""Cost of inverse dynamics: `python tests/benchmarks/inverse.py [--update]`.

The compiled kernel beside multipliers and Pinocchio (install the extra `oracles`) over 10,000
samples, warm, medians of repeats taken in turn in one run. Loops in Python are timed over 1000
samples and reported for 10,000. What each route computes and how it agrees goes to stderr.
"""

import math
import sys
from pathlib import Path

import numpy as np
from publishing import publish, require

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent))

import clearance as cl  # noqa: E402
from tests.oracles import routes  # noqa: E402

BEGIN, END = "<!-- inverse:begin -->", "<!-- inverse:end -->"
SAMPLES = 10_000
#: what is solved -> (case, parameters, seconds of motion)
CASES = {
    "three-loop chain, driven joint rubs": ("three_loop_chain", {}, 10.0),
    "three-loop chain, all ten joints rub": ("three_loop_chain", {"where": "all"}, 10.0),
    "five-axis chain, all five joints rub": ("five_axis_chain", {}, 5.0),
    "mobile manipulator, all twelve joints rub": ("mobile_manipulator", {}, 40.0),
    "mobile manipulator, no friction": ("mobile_manipulator", {"friction": "none"}, 40.0),
}
SHOWN = (
    "explicit, whole call",
    "multipliers",
    "multipliers, solve",
    "Pinocchio",
    "Pinocchio, reactions",
)


def milliseconds(study: routes.RouteStudy, name: str) -> float:
    return 1e3 * SAMPLES * study.route(name).per_sample


def row(name: str, study: routes.RouteStudy) -> str:
    """Times for all samples, ratios to the complete call, agreement and operations of one scene."""
    loop, (entire, *others) = (
        milliseconds(study, "explicit"),
        (milliseconds(study, n) for n in SHOWN),
    )
    times = [
        f"{loop:.1f} ms",
        f"**{entire:.1f} ms**",
        *(f"{t:.0f} ms ({t / entire:.1f}x)" for t in others),
    ]
    apart = [d for r in study.routes[2:] for d in (r.efforts, r.reactions) if not math.isnan(d)]
    ours, dense = (
        study.route("explicit").operations.total,
        study.route("multipliers, solve").operations.total,
    )
    return (
        f"| {name} | {' | '.join(times)} | {max(apart):.0e} | {ours:.0f} | {dense:.0f} "
        f"({dense / ours:.1f}x) |"
    )


def table() -> list[str]:
    lines = [
        f"| {SAMPLES} samples | explicit: compiled loop | explicit: whole call | multipliers, "
        f"numpy "
        "| their dense solve alone, LAPACK | Pinocchio from Python: efforts | and all reactions "
        "| largest difference | operations a sample: explicit | dense solve |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, (case, parameters, until) in CASES.items():
        scene = cl.load_case(case, **parameters)
        study = routes.compare(scene, np.linspace(0.0, until, SAMPLES))
        print(*details(name, study), sep="\n", file=sys.stderr)
        lines.append(row(name, study))
        check(name, study)
    return lines


def details(name: str, study: routes.RouteStudy) -> list[str]:
    """Routes of a scene with their purpose, times and operations, and remarks."""
    lines = [
        f"  {r.name}: {1e6 * r.per_sample:.3g} us a sample"
        + (f", {r.operations} operations" if r.operations else "")
        + f"; {r.computes}; efforts {r.efforts:.0e}, reactions {r.reactions:.0e} away"
        for r in study.routes
    ]
    return [name, *lines, *(f"  {remark}" for remark in study.remarks)]


def check(name: str, study: routes.RouteStudy) -> None:
    """Note what is requested and not met."""
    for r in study.routes:
        for quantity, apart in (("efforts", r.efforts), ("reactions", r.reactions)):
            require(not apart > 1e-10, f"{name}: {quantity} of {r.name} are {apart:.0e} away")
    entire = milliseconds(study, "explicit, whole call")
    if name.startswith("three-loop chain, driven"):
        require(entire < 20.0, f"{name}: a call takes {entire:.1f} ms, above 20")
        ratio = milliseconds(study, "Pinocchio") / entire
        require(
            ratio > 5.0, f"{name}: only {ratio:.1f} times faster than Pinocchio called from Python"
        )
    ours, dense = (
        study.route("explicit").operations.total,
        study.route("multipliers, solve").operations.total,
    )
    require(ours < dense, f"{name}: {ours:.0f} operations, a dense solve {dense:.0f}")


if __name__ == "__main__":
    publish(__doc__, table, BEGIN, END)
