"""Coverage of the intervals of `cl.fit`: `python tests/benchmarks/intervals.py [NAMES] [--update]`.

200 draws of the noise, each fitted; the shares of 95 % intervals that hold the truth scatter by
1.5 %. The masses of an ideal slider-crank are those of linear least squares on the closed form of
its torque. Three minutes on one core.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from publishing import publish, require

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent))

import clearance as cl  # noqa: E402
from clearance.identify.free import Free  # noqa: E402
from clearance.identify.measured import Measured, read  # noqa: E402
from clearance.identify.run_errors import weighted  # noqa: E402
from clearance.identify.scene_fit import LAST, Curve, Problem  # noqa: E402
from clearance.identify.verdict import verdict  # noqa: E402
from tests.identify import test_scene_fit as fits  # noqa: E402

BEGIN = "<!-- intervals -->"
DRAWS, LOWEST, HIGHEST = 200, 0.92, 0.98
EQUAL = 1e-9  # largest difference to linear least squares, over the value
SAMPLES = 360  # of the turn of the ideal slider-crank
SPEED = cl.rpm(5000)


@dataclass(frozen=True)
class Trial:
    """Records with noise, and what is fitted to them.

    clean: the record without noise; sigma: of its values; truth: by parameter, with bounds; stated:
    whether sigma is stated; columns: slopes of a linear record by the parameters.
    """

    scene: cl.Scene
    clean: Measured
    channel: str
    sigma: float
    truth: dict[str, tuple[float, float, float]]
    settle: float | None = None
    stated: bool = True
    columns: np.ndarray | None = None

    def drawn(self, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Intervals of a draw, (parameters, 4): value, low, high, deviation; its errors."""
        errors = np.random.default_rng(seed).normal(0.0, self.sigma, self.clean.values.size)
        clean = self.clean
        values = clean.values + errors
        data = Measured(clean.path, clean.column, clean.units, clean.along, clean.x, values)
        free = [Free(name, low, high) for name, (_, low, high) in self.truth.items()]
        curve = Curve(data, self.channel, self.sigma if self.stated else None)
        problem = Problem(self.scene, free, [curve], self.settle)
        best = weighted(problem, problem.solved(problem.middle, finish=LAST))
        rows = [i[1:5] for i in verdict(problem, best, [best]).intervals]
        return np.array(rows), errors


def oscillator(stated: bool = True) -> Trial:
    """The oscillator's closed form, noise of 2 % of its first amplitude."""
    clean = fits.record(fits.TIMES, fits.exact(fits.TIMES))
    values = zip(fits.FREE.items(), (fits.STIFFNESS, fits.DAMPING), strict=True)
    truth = {name: (value, *bounds) for (name, bounds), value in values}
    return Trial(fits.oscillator(1.1, 0.25), clean, "bodies/block/x", 0.02, truth, stated=stated)


def record_a() -> Trial:
    """The third turn of a lubricated slider-crank, by another code; noise of 1 % of its range."""
    path = Path(fits.__file__).parent / "data" / "fit_record_a.csv"
    clean = read(path, "slider_acceleration_exact_m_s2")
    truth = {
        "clearance": (5e-4, 1e-4, 1e-3),
        "viscosity": (0.4, 0.05, 1.0),
        "bodies/slider/mass": (0.14, 0.05, 0.5),
    }
    scene = cl.load_case("slider_crank", **fits.CASE)
    return Trial(scene, clean, "bodies/slider/ax", fits.RECORDS["a"][0], truth)


def ideal() -> Trial:
    """The torque of an ideal slider-crank, linear in both masses; noise of 2 % of its range."""
    still, *columns = torques()
    truth = {"bodies/slider/mass": (0.14, 0.05, 0.5), "bodies/rod/mass": (0.21, 0.05, 0.6)}
    values = still + 0.14 * columns[0] + 0.21 * columns[1]
    clean = fits.record(np.arange(SAMPLES) / SAMPLES, values, "angle", "N m")
    scene, sigma = cl.load_case("slider_crank", model="ideal"), 0.02 * float(np.ptp(values))
    slopes = np.stack(columns, axis=1)
    return Trial(scene, clean, "drives/crank/torque", sigma, truth, 0.0, columns=slopes)


def torques(crank: float = 0.05, rod: float = 0.12) -> Iterator[np.ndarray]:
    """Drive torque of the rod's inertia and the crank's weight [N m], and that over the mass of
    slider and rod [m2/s2]: the slope of kinetic and potential energy by the crank angle.

    Slopes are those of Fourier series, whose harmonics fall by a factor of five each.
    """
    theta = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    waves = 1j * np.fft.fftfreq(SAMPLES, 1.0 / SAMPLES)
    height, along = crank * np.sin(theta), crank * np.cos(theta)
    reach = np.sqrt(rod**2 - height**2)

    def slope(values):
        return np.fft.ifft(waves * np.fft.fft(values)).real

    def torque(*squares, y=0.0 * theta):
        moving = sum(slope(s) ** 2 for s in squares)
        return slope(0.5 * SPEED**2 * moving + 9.81 * y)

    inertia = torque(np.arcsin(height / rod))
    yield 2.5e-4 * inertia + 0.3 * torque(y=0.5 * height)
    yield torque(along + reach)
    yield torque(along + 0.5 * reach, 0.5 * height, y=0.5 * height)


TRIALS = {
    "oscillator, noise stated": oscillator,
    "oscillator, noise unknown": lambda: oscillator(stated=False),
    "ideal slider-crank": ideal,
    "record a, lubricated slider-crank": record_a,
}


def rows(name: str, trial: Trial) -> Iterator[str]:
    """Coverage of each parameter, and the distance to linear least squares."""
    truth = np.array([v[0] for v in trial.truth.values()])
    ends, apart = [], 0.0
    for seed in range(DRAWS):
        intervals, errors = trial.drawn(1000 + seed)
        ends.append(intervals)
        if trial.columns is not None:
            linear = truth + np.linalg.lstsq(trial.columns, errors, rcond=None)[0]
            apart = max(apart, float(np.abs(intervals[:, 0] / linear - 1.0).max()))
        print(f"\r{name}: {seed + 1} of {DRAWS}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    value, low, high, deviation = np.moveaxis(np.array(ends), 2, 0)
    shares = ((low <= truth) & (truth <= high)).mean(axis=0)
    scores = (value - truth) / deviation
    require(apart < EQUAL, f"{name}: linear least squares is {apart:.1e} away")
    for k, parameter in enumerate(trial.truth):
        within = LOWEST <= shares[k] <= HIGHEST
        require(within, f"{name}: {shares[k]:.1%} of the intervals of {parameter} hold the truth")
        equal = f"{apart:.0e}" if trial.columns is not None else "-"
        spread = f"{scores[:, k].mean():+.2f}, {scores[:, k].std():.2f}"
        yield f"| {name} | {parameter} | {shares[k]:.1%} | {spread} | {equal} |"


def table(chosen) -> list[str]:
    lines = [
        f"| {DRAWS} draws of | parameter | intervals with the truth | (estimate - truth) / "
        "deviation: mean, deviation | linear least squares |",
        "|---|---|---|---|---|",
    ]
    for name in chosen.names or TRIALS:
        lines += rows(name, TRIALS[name]())
    return lines


if __name__ == "__main__":
    publish(__doc__, table, BEGIN, names=([], f"of {', '.join(TRIALS)}"))
