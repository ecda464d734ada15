"""Sensitivities against central differences of independent runs at rtol 1e-11.

`python tests/benchmarks/sensitivities.py` prints a table with a row for each scene and parameter:
the median and the 90 % quantile over its metrics of the error over the value, the share of the
metrics within their stated error, and CPU times. Differences of references at two widths show how
far these can be trusted; metrics whose references differ by a tenth are left out.
"""

import time

import numpy as np

import clearance as cl
from clearance.metrics import metrics

TURNS = 2.0
SCENES = {
    "feeder, table film": ("six_bar_feeder", {}),
    "feeder, pinkus_sternlicht": ("six_bar_feeder", {"film": "pinkus_sternlicht"}),
    "feeder, joints B, C, E": ("six_bar_feeder", {"joints": "B,C,E"}),
    "feeder, mixed": ("six_bar_feeder", {"model": "mixed"}),
    "slider-crank, table film": ("slider_crank", {"model": "lubricated", "speed": 50.0}),
    "slider-crank, mixed": ("slider_crank", {"model": "mixed", "speed": 50.0}),
}
PARAMETERS = "clearance", "viscosity", "speed"
WIDTHS = {"clearance": 1e-3, "viscosity": 1e-3, "speed": 1e-4}


def found(case: str, values: dict):
    """Sensitivities, and the CPU time of all [s]."""
    scene, began = cl.load_case(case, **values), time.process_time()
    result = cl.simulate(scene, turns=TURNS, sensitivity=PARAMETERS, error=None)
    return result.sensitivities, time.process_time() - began


def reference(case: str, values: dict, name: str, value: float) -> dict[str, tuple[float, float]]:
    """Derivatives by metric from four runs (Richardson), and what two widths differ by."""
    d = WIDTHS[name] * value
    m = {}
    for k in (-2, -1, 1, 2):
        scene = cl.load_case(case, **values | {name: value + k * d})
        run = cl.simulate(scene, turns=TURNS, rtol=1e-11, error=None)
        m[k] = {n: one.value for n, one in metrics(run).items()}
    slopes = {}
    for n in m[1]:
        one, two = (m[1][n] - m[-1][n]) / (2.0 * d), (m[2][n] - m[-2][n]) / (4.0 * d)
        slopes[n] = (4.0 * one - two) / 3.0, abs(one - two)
    return slopes


HEAD = (
    "scene",
    "parameter",
    "metrics",
    "median error",
    "90 %",
    "within the stated error",
    "references differ by",
    "CPU a parameter [s]",
    "CPU of a reference [s]",
)


def compared(sensitivities, exact: dict, name: str) -> list[tuple[float, bool, float]]:
    """Error over the value, whether it is within the stated one, and what the references differ
    by.
    """
    rows = []
    for (metric, parameter), s in sensitivities.items():
        value, apart = exact[metric]
        if parameter == name and value and apart < 0.1 * abs(value):
            off = abs(s.value - value)
            rows.append((off / abs(value), off <= s.error + apart, apart / abs(value)))
    return rows


def main() -> None:
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    everything = []
    for title, (case, values) in SCENES.items():
        found(case, values)  # compiled
        sensitivities, seconds = found(case, values)
        for name in PARAMETERS:
            size = next(s.size for (_, p), s in sensitivities.items() if p == name)
            began = time.process_time()
            exact = reference(case, values, name, size)
            took = time.process_time() - began
            off, inside, apart = map(
                np.array, zip(*compared(sensitivities, exact, name), strict=True)
            )
            everything += off.tolist()
            cells = [title, name, str(len(off)), f"{np.median(off):.0e}"]
            cells += [f"{np.quantile(off, 0.9):.0e}", f"{inside.mean():.0%}"]
            cells += [f"{np.median(apart):.0e}", f"{seconds / len(PARAMETERS):.2f}", f"{took:.2f}"]
            print("| " + " | ".join(cells) + " |", flush=True)
    ends = f"{np.median(everything):.0e}, 90 % {np.quantile(everything, 0.9):.0e}"
    print(f"\n{len(everything)} sensitivities: median {ends}")


if __name__ == "__main__":
    main()
