"""A synthetic test bench of a ball joint, after the programme of Pfitzer et al., Lubricants 2025,
13(10), 436.

Nothing here was measured. The joint is richer than every model that is fitted to it. Eight
ellipsoidal LuGre elements stand side by side; their break-away angles span 0.0004 to 0.02 rad (an
Iwan-like spectrum). There is a Stribeck peak. Friction depends on direction, on the place of the
ball in its seat and on warm-up. Its level differs from run to run.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from clearance.identify.records import Measurement, Trial
from clearance.machine.store import njit
from clearance.values.checks import finite, non_negative, positive

DEGREE = math.pi / 180.0
AXIS = {"tilt": 0, "tilt_y": 1, "spin": 2}
PRELOAD = 5000.0  # N
#: of the torque over the preload: a polymer's coefficient of friction falls a little as its
#: pressure rises
LOAD_EXPONENT = 0.85
#: the bench's second-order filter, which rounds the corners of triangles
CORNER, FILTER_DAMPING = 20.0, math.sqrt(0.5)  # Hz, 1
#: longest step of the joint's integration [s]
FINE = 2.5e-4
#: rate [rad/s] within which friction goes over from one direction's to the other's
TURNING = 1e-3

MOST_SCATTER = 1.0  # of the level's logarithm
#: of the random numbers, what seed 0 begins with
FIRST = 6

#: position, kind, role, amplitude [deg], speed [deg/s] of triangles or frequency [Hz] of sines,
#: cycles; each for spin and tilt. At 1 kHz the trials for training have 57,600 samples.
PROGRAMME = (
    (1, "triangle", "other", 1.0, 0.5, 2),
    (2, "triangle", "training", 2.0, 1.0, 2),
    (3, "triangle", "other", 2.0, 2.0, 2),
    (4, "triangle", "test", 10.0, 5.0, 2),
    (5, "triangle", "training", 10.0, 10.0, 2),
    (6, "triangle", "other", 10.0, 20.0, 3),
    (7, "triangle", "training", 10.0, 50.0, 6),
    (8, "triangle", "test", 10.0, 100.0, 12),
    (9, "sine", "test", 12.0, 1.0, 5),
    (10, "sine", "test", 8.0, 2.0, 10),
    (11, "sine", "test", 3.0, 5.0, 25),
    (12, "sine", "extrapolation", 0.5, 10.0, 50),
    (13, "sine", "extrapolation", 0.2, 20.0, 100),
    (14, "triangle", "extrapolation", 20.0, 200.0, 12),
    (15, "triangle", "extrapolation", 20.0, 400.0, 25),
)
#: position, name, and kind, amplitude [deg], speed [deg/s] or frequency [Hz], cycles of the axes
#: that move together
MIXED = (
    (16, "in_step", {"spin": ("triangle", 10.0, 10.0, 2), "tilt": ("triangle", 10.0, 10.0, 2)}),
    (17, "crossing", {"spin": ("sine", 8.0, 1.5, 9), "tilt": ("sine", 8.0, 1.0, 6)}),
    (18, "dithered", {"spin": ("triangle", 10.0, 10.0, 2), "tilt": ("sine", 0.5, 10.0, 80)}),
    (
        19,
        "all",
        {
            "spin": ("sine", 8.0, 1.5, 12),
            "tilt": ("sine", 8.0, 1.0, 8),
            "tilt_y": ("sine", 5.0, 1.25, 10),
        },
    ),
)


@dataclass(frozen=True)
class Joint:
    """The friction of the bench's ball joint under its preload; the numbers are calibrated, see
    `bench`.

    torque: of steady sliding at high speed about x, y, z [N m]; break_away: angles of the elements
        [rad]; shares: what they carry of the torque (any scale); ratio: torque near rest over that;
        stribeck: speed [rad/s] at which the excess has fallen to 1/e; asymmetry: of the directions;
        seat: modulation by the angle, seat_wave: its period [rad];
    warm_up: excess of a cold joint, warm_up_time [s] in which it falls to 1/e; damping of the
        elements and viscosity [N m s/rad].
    """

    torque: tuple[float, float, float] = (2.6, 2.6, 2.0)
    break_away: tuple[float, ...] = tuple(4e-4 * 50.0 ** (j / 7.0) for j in range(8))
    shares: tuple[float, ...] = tuple(50.0 ** (-0.3 * j / 7.0) for j in range(8))
    ratio: float = 1.35
    stribeck: float = 0.06
    asymmetry: float = 0.04
    seat: float = 0.05
    seat_wave: float = 20.0 * DEGREE
    warm_up: float = 0.06
    warm_up_time: float = 20.0
    damping: float = 0.05
    viscosity: float = 0.05

    def under(self, preload: float) -> "Joint":
        """The joint under another preload [N]: elements follow (F / 5 kN)^0.85, the grease's
        viscosity does not.
        """
        level = (preload / PRELOAD) ** LOAD_EXPONENT
        torque = tuple(level * t for t in self.torque)
        return replace(self, torque=torque, damping=level * self.damping)

    def torques(
        self, rate: np.ndarray, angle: np.ndarray, step: float, every: int = 1, level: float = 1.0
    ):
        """Torque (n / every, 3) [N m] at every so many samples of rate and angle (n, 3) a step [s]
        apart, from rest.
        """
        torques = np.zeros((-(-len(rate) // every), 3))
        numbers = (
            self.ratio,
            self.stribeck,
            self.asymmetry,
            self.seat,
            2.0 * math.pi / self.seat_wave,
            self.warm_up,
            self.warm_up_time,
            self.damping,
            self.viscosity,
            level,
        )
        elements = np.array(self.break_away), np.array(self.shares) / sum(self.shares)
        _torques(rate, angle, step, every, np.array(self.torque), *elements, numbers, torques)
        return torques


def bench(
    seed: int = 0,
    scatter: float = 0.16,
    noise: float = 0.02,
    rate_of_samples: float = 1000.0,
    joint: Joint | None = None,
    preloads: Sequence[float] = (PRELOAD,),
) -> Measurement:
    """The synthetic measurement of the complete programme, the same numbers for the same arguments.

    scatter: relative standard deviation of the level from run to run; noise: standard deviation of
        the torque [N m]; rate_of_samples [1/s]; preloads [N], under each of which the entire
        programme is run.
    Raises ValueError for numbers out of range.

    Calibrated by hand: the shares of the elements (the stiff ones carry more), the scatter, and
    FIRST, so that seed 0 is a draw near the source. The amplitudes of positions 4 and 9 to 11 are
    calibrated, too. The source does not print them, and no sine there is faster than the fastest
    triangle. NRMSE (rms error over rms torque) of training and test, source in brackets. LuGre with
    constant parameters 0.083 (0.129) and 0.236 (0.260), characteristic curve 0.263 (0.271) and
    0.305 (0.302). The test
    error is mostly the scatter, of which the training has three levels an axis: without scatter
    LuGre has 0.081 and 0.079. Of 20 draws the middle 80 % have 0.080 to 0.087 and 0.14 to 0.33
    (median 0.25). The curve has 0.23 to 0.28 and 0.29 to 0.38 (median 0.31). Torques are integrated
    to 0.002 N m (rms).
    """
    scatter, noise = non_negative("scatter", scatter), non_negative("noise", noise)
    if scatter > MOST_SCATTER:
        raise ValueError(
            f"scatter must lie in [0, {MOST_SCATTER:g}], 0.16 is 16 %, got {scatter:g}"
        )
    if not 200.0 <= finite("rate_of_samples", rate_of_samples) <= 20000.0:
        raise ValueError(f"rate_of_samples must lie in [200, 20000] 1/s, got {rate_of_samples!r}")
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ValueError(f"seed must be a whole number from 0 on, got {seed!r}")
    preloads = tuple(positive("preload", p) for p in preloads)
    if not preloads or len(set(preloads)) < len(preloads):
        raise ValueError(f"preloads must be different loads in N, at least one, got {preloads}")
    joint, trials = joint or Joint(), []
    for preload in preloads:
        loaded = joint if preload == PRELOAD else joint.under(preload)
        for position, name, role, parts in _runs():
            name += f"_{preload:g}N".replace("+", "").replace(".", "p") * (preloads != (PRELOAD,))
            # whatever other trials there are
            random = np.random.default_rng((FIRST + seed, position, *map(ord, name)))
            about = loaded, preload, random, scatter, noise, rate_of_samples
            trials.append(_trial(position, name, role, parts, *about))
    facts = {
        "title": "ball joint, synthetic test bench",
        "synthetic": True,
        "seed": int(seed),
        "scatter": scatter,
        "noise": noise,
        "bench": "synthetic bench after Pfitzer et al., Lubricants 13 (2025) 436",
        "preload": preloads[0] if len(preloads) == 1 else list(preloads),
        "specimen": "ball joint, eight ellipsoidal LuGre elements",
        "recorded_by": "clearance bench-data",
        "sampling_rate": rate_of_samples,
        "sensor_torque": "torque about x, y, z (ideal, white noise)",
        "sensor_torque_range": [-20.0, 20.0],
        "sensor_rate": "angular velocity about x, y, z (ideal)",
        "sensor_rate_range": [-10.0, 10.0],
    }
    return Measurement(tuple(trials), facts)


def _runs():
    """Position, name, role, and the moving axes with their kind, amplitude, pace and cycles, of
    every trial.
    """
    for position, kind, role, *how in PROGRAMME:
        for axis in ("spin", "tilt"):
            yield position, f"p{position:02d}_{kind}_{axis}", role, {axis: (kind, *how)}
    for position, name, parts in MIXED:
        yield position, f"p{position}_mixed_{name}", "extrapolation", parts


def _trial(
    position, name, role, parts, joint, preload, random, scatter, noise, rate_of_samples
) -> Trial:
    """One trial, its level and noise drawn from `random`."""
    every = math.ceil(1.0 / (FINE * rate_of_samples))
    step = 1.0 / (every * rate_of_samples)
    samples = max(round(_duration(*how) * rate_of_samples) for how in parts.values())
    time = np.arange(samples * every) * step
    rate, angle = np.zeros((2, len(time), 3))
    for axis, (kind, amplitude, pace, cycles) in parts.items():
        i, motion = AXIS[axis], triangle if kind == "triangle" else sine
        rate[:, i] = motion(
            time, amplitude * DEGREE, pace * (DEGREE if kind == "triangle" else 1.0), cycles
        )
        angle[1:, i] = np.cumsum(0.5 * step * (rate[1:, i] + rate[:-1, i]))
        angle[:, i] -= amplitude * DEGREE if kind == "sine" else 0.0  # sines begin where they turn
    level = math.exp(scatter * random.standard_normal() - 0.5 * scatter**2)
    torque = joint.torques(rate, angle, step, every, level) + noise * random.standard_normal(
        (samples, 3)
    )
    facts = {"position": position, "preload": preload}
    if len(parts) == 1:
        _, amplitude, pace, cycles = next(iter(parts.values()))
        pace_facts = {"speed": pace * DEGREE} if kind == "triangle" else {"frequency": pace}
        facts |= {"amplitude": amplitude * DEGREE, **pace_facts, "cycles": cycles}
    return Trial(
        name,
        kind if len(parts) == 1 else "mixed",
        axis if len(parts) == 1 else "mixed",
        role,
        time[::every],
        rate[::every],
        torque,
        tuple(i in [AXIS[a] for a in parts] for i in range(3)),
        facts,
    )


# --- motions
def _duration(kind: str, amplitude: float, pace: float, cycles: int) -> float:
    """Length [s] of a motion."""
    return cycles * (4.0 * amplitude / pace if kind == "triangle" else 1.0 / pace)


def triangle(time: np.ndarray, amplitude: float, speed: float, cycles: int) -> np.ndarray:
    """Rate (n,) [rad/s] of a triangular motion [rad, rad/s] through the bench's filter, from rest
    in the middle.
    """
    quarter = amplitude / speed
    rate = speed * _after(time)
    for k in range(2 * cycles):
        rate += (2.0 if k % 2 else -2.0) * speed * _after(time - (2 * k + 1) * quarter)
    return rate


def _after(time: np.ndarray) -> np.ndarray:
    """Response of the bench's filter to a unit step at time 0."""
    w, late = 2.0 * math.pi * CORNER, np.maximum(time, 0.0)
    turn = w * math.sqrt(1.0 - FILTER_DAMPING**2)
    wave = np.cos(turn * late) + FILTER_DAMPING * w / turn * np.sin(turn * late)
    return 1.0 - np.exp(-FILTER_DAMPING * w * late) * wave


def sine(time: np.ndarray, amplitude: float, frequency: float, cycles: int) -> np.ndarray:
    """Rate (n,) [rad/s] of a sinusoidal motion of an angle [rad], from rest at its end; `cycles`
    only set how long.
    """
    w = 2.0 * math.pi * frequency
    return amplitude * w * np.sin(w * time)


# --- the joint
@njit(cache=True, error_model="numpy")
def _torques(rate, angle, step, every, steady, break_away, shares, numbers, torques):
    """See `Joint.torques`; each element is a LuGre element of constant rate over a step, solved
    exactly.
    """
    ratio, stribeck, asymmetry, seat, wave, warm_up, warm_up_time, damping, viscosity, level = (
        numbers
    )
    bristles, w, torque = np.zeros((break_away.size, 3)), np.zeros(3), np.zeros(3)
    for n in range(len(rate)):
        for i in range(3):
            w[i] = 0.5 * (rate[n, i] + rate[max(n - 1, 0), i])
        speed = math.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
        warmth = 1.0 + warm_up * math.exp(-n * step / warm_up_time)
        now = level * warmth * (1.0 + (ratio - 1.0) * math.exp(-((speed / stribeck) ** 2)))
        strength = 0.0
        for i in range(3):
            direction = 1.0 + asymmetry * math.tanh(w[i] / TURNING)
            torque[i] = steady[i] * now * direction * (1.0 + seat * math.cos(wave * angle[n, i]))
            strength += (torque[i] * w[i]) ** 2
        strength = math.sqrt(strength)
        keep = n % every == 0
        for i in range(3):
            if keep:
                torques[n // every, i] = viscosity * rate[n, i]
            if w[i] == 0.0 and bristles[0, i] == 0.0:
                continue
            for j in range(break_away.size):
                k = strength * steady[i] / (break_away[j] * torque[i] ** 2)
                if n > 0:
                    gone = -math.expm1(-k * step)
                    reach = gone / k if k * step > 1e-9 else step
                    bristles[j, i] += w[i] * reach - gone * bristles[j, i]
                if keep:
                    slip = w[i] - k * bristles[j, i]
                    torques[n // every, i] += shares[j] * (
                        steady[i] / break_away[j] * bristles[j, i] + damping * slip
                    )
