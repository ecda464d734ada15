"""Sensitivities against central differences of independent runs at rtol 1e-11.

`python tests/benchmarks/sensitivities.py` prints a table with a row for each scene and parameter:
the median and the 90 % quantile over its metrics of the error over the value, the share of the
metrics within their stated error, and CPU times. Differences of references at two widths show how
far these can be trusted; metrics whose references differ by a tenth are left out. `--tangent`
compares the states at the end of a run instead: tangents of the collocation of radau5, and
differences on common steps.
"""

import argparse
import time

import numpy as np

import clearance as cl
from clearance.accuracy.fixed_steps import Ends, Replay
from clearance.metrics.metrics import metrics
from clearance.run.run import Run
from clearance.simulation import prepare
from clearance.stepping.tableaus import RADAU5

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


def computed(case: str, values: dict):
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


# --- tangents
def run_of(viscosity: float, rtol: float, method: str) -> Run:
    """A run of the feeder with a film law, not begun."""
    scene = cl.load_case("six_bar_feeder", film="pinkus_sternlicht", viscosity=viscosity)
    return prepare(scene, turns=TURNS, rtol=rtol, method=method, energy=False)


def end(run: Run, ends: list[float] | None = None) -> tuple[np.ndarray, list[float]]:
    """State at the end of a run, on the steps of another if given, and the ends of its steps."""
    run, seen = run if ends is None else Replay(run, ends, run.span.until), Ends()
    run.observers.append(seen)
    run.go()
    return run.state.y.copy(), seen.times


def difference(viscosity: float, width: float, rtol: float, method: str, ends=None) -> np.ndarray:
    """Central difference of the states at the end."""
    above, below = (end(run_of(viscosity + d, rtol, method), ends)[0] for d in (width, -width))
    return (above - below) / (2.0 * width)


class Tangent:
    """States and their derivatives on the steps of radau5, each step's equations solved to
    rounding; the parameter's part of the right-hand side is a difference.
    """

    def __init__(self, viscosity: float, rtol: float):
        run, self.width = run_of(viscosity, rtol, "radau5"), 1e-6 * viscosity
        beside = [run_of(viscosity + d, rtol, "radau5") for d in (self.width, -self.width)]
        self.run, self.size, self.par = run, run.mechanism.size, run.mechanism.par
        self.above, self.below = (one.mechanism.par for one in beside)
        self.y = run.state.y[: self.size].copy()
        starts = [one.state.y[: self.size] for one in beside]
        self.slope = (starts[0] - starts[1]) / (2.0 * self.width)

    def rate(self, t: float, y: np.ndarray, par: np.ndarray) -> np.ndarray:
        """Right-hand side."""
        out = np.zeros(self.size)
        self.run.mechanism.kernel("rhs")(t, y, par, self.run.state.work, out)
        return out

    def jacobian(self, t: float, y: np.ndarray) -> np.ndarray:
        """Its derivative by the state."""
        out = np.zeros(self.size**2)
        self.run.mechanism.kernel("jacobian")(t, y, self.par, self.run.state.work, out)
        return out.reshape(self.size, self.size)

    def step(self, t: float, h: float) -> None:
        """One step of the state and of its derivative, with the same matrix."""
        times, z, eye = t + RADAU5.c * h, np.zeros((3, self.size)), np.eye(3 * self.size)
        for _ in range(12):
            rates = np.array(
                [self.rate(s, self.y + d, self.par) for s, d in zip(times, z, strict=True)]
            )
            inner = [self.jacobian(s, self.y + d) for s, d in zip(times, z, strict=True)]
            matrix = eye - h * np.block(
                [[a * j for a, j in zip(row, inner, strict=True)] for row in RADAU5.a]
            )
            z -= np.linalg.solve(matrix, (z - h * RADAU5.a @ rates).ravel()).reshape(z.shape)
        by = [
            self.rate(s, self.y + d, self.above) - self.rate(s, self.y + d, self.below)
            for s, d in zip(times, z, strict=True)
        ]
        right = np.array([j @ self.slope for j in inner]) + np.array(by) / (2.0 * self.width)
        change = np.linalg.solve(matrix, (h * RADAU5.a @ right).ravel()).reshape(z.shape)
        self.y, self.slope = self.y + z[2], self.slope + change[2]


def tangents() -> None:
    """Largest relative errors of the derivatives of the states at the end, by method."""
    viscosity, print_row = 0.05, "| {} | {:g} | {} | {:.0e} |".format
    near, far = (difference(viscosity, k * 5e-5, 1e-11, "radau9") for k in (1, 2))
    exact = (4.0 * near - far) / 3.0
    print("| derivatives of the states at the end | rtol | steps | largest error |")
    print("|---|---|---|---|")
    for rtol in (1e-6, 1e-8):
        tangent, t = Tangent(viscosity, rtol), 0.0
        ends = end(run_of(viscosity, rtol, "radau5"))[1]
        for until in ends:
            tangent.step(t, until - t)
            t = until
        off = np.abs(tangent.slope / exact - 1.0).max()
        print(print_row("tangent columns, radau5", rtol, len(ends), off))
    for rtol in (1e-6, 1e-8):
        ends = end(run_of(viscosity, rtol, "rodas5p"))[1]
        computed = difference(viscosity, 1e-5 * viscosity, rtol, "rodas5p", ends)
        off = np.abs(computed / exact - 1.0).max()
        print(print_row("differences on common steps, rodas5p", rtol, len(ends), off))
    apart = np.abs(difference(viscosity, 5e-7, 1e-6, "radau5") / exact - 1.0).max()
    print(print_row("differences of independent runs, radau5", 1e-6, "-", apart))


def main() -> None:
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    everything = []
    for title, (case, values) in SCENES.items():
        computed(case, values)  # compiled
        sensitivities, seconds = computed(case, values)
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
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--tangent", action="store_true", help="tangents at the end of a run")
    tangents() if parser.parse_args().tangent else main()
