"""Friction of a joint's axes along a trial: kernels from the trace of a law, with exact slopes.

A law has for each axis that moves the rate of its bristles and a torque, or the torque alone:

    z_i' = f_i(z_i, w, p),   M_i = g_i(z_i, w, p)

with deflections z, rates w and numbers p, parameters of the model and facts of the trial. Over a
step dt of constant w the bristles take the exponential step

    z_i <- z_i + f_i (exp(a_i dt) - 1) / a_i,   a_i = df_i / dz_i,

which is exact where f is linear in z. The torque of a sample belongs to its rate, the step to the
mean rate since the sample before. Slopes by p follow from those of step and torque by z and p.
"""

import math
from collections.abc import Callable, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from clearance.machine.store import KERNEL, address, caller, njit
from clearance.tracing.emission import Program, kernel_text
from clearance.tracing.function import Expansion
from clearance.tracing.interpreter import Execution, traced
from clearance.tracing.kernels import kernel
from clearance.tracing.trace import Trace

SMALL = 1e-2  # a dt below which the step is written as a series
ALL = 0, 1, 2
kernel_at = caller(KERNEL)


class Layout(NamedTuple):
    """Kernels of a law, without and with slopes.

    They read deflections, step, rates, numbers, one after another. bristles: whether there is a
    state; static: bristles always come to rest.
    """

    step: int
    torque: int
    step_slopes: int
    torque_slopes: int
    bristles: bool
    static: bool


class Leaves:
    """Numbers that a law reads, on a trace of its own, in the order of the vector of the kernels.

    widths: of the tuples of numbers.
    """

    def __init__(self, axes: tuple[int, ...], widths: Sequence[int]):
        self.trace, self.axes, size = Trace(exact=True), axes, len(axes)
        leaves = [self.trace.load(f"y[{i}]") for i in range(2 * size + 1 + sum(widths))]
        self.z, self.dt, self.w = leaves[:size], leaves[size], leaves[size + 1 : 2 * size + 1]
        rest = iter(leaves[2 * size + 1 :])
        self.numbers = tuple(tuple(islice(rest, n)) for n in widths)

    def call(self, function: Callable, *arguments) -> list:
        """Values of a plain function of numbers and tuples of numbers."""
        return list(Execution(self.trace, function, {}).returned(list(arguments)))

    def layout(self, values: list, *, static: bool = False, exact: bool = True) -> Layout:
        """Kernels of a law with these values: rates of deflections where it has such, torques.

        exact: False for a law without slopes by its numbers.
        """
        size, numbers = len(self.axes), [n for row in self.numbers for n in row]
        laws = [self._step(values, static) if len(values) > size else [], values[-size:]]
        columns = [*self.z, *numbers]
        seeds = {leaf: {j: 1.0} for j, leaf in enumerate(columns)}
        wide = [
            [*law, *(row.get(j, 0.0) for row in rows for j in range(len(columns)))]
            for law in laws
            for rows in [self.trace.tangent(law, seeds) if exact else []]
        ]
        return Layout(*map(kernel_of, [*laws, *wide]), len(values) > size, static)

    def _step(self, values: list, static: bool) -> list:
        """Deflections after a step."""
        seeds = {z: {i: 1.0} for i, z in enumerate(self.z)}
        rows = self.trace.tangent(values[: len(self.z)], seeds)
        longer, ends = traced(rest if static else reach), []
        for i, (z, rate) in enumerate(zip(self.z, values, strict=False)):
            (length,) = self.trace.call(longer, [rows[i].get(i, 0.0), self.dt])
            ends.append(z + rate * length)
        return ends


def reach(slope, dt):
    """(exp(a dt) - 1) / a [s], for an a that is not positive."""
    x = slope * dt
    if abs(x) > SMALL:
        return math.expm1(x) / slope
    series = 1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0 + x / 720.0))
    return dt * (1.0 + x * (0.5 + x * series))


def rest(slope, dt):
    """-1 / a [s]: the same of an endless step; bristles that nothing moves stay."""
    return -1.0 / slope if slope != 0.0 else 0.0


def kernel_of(outputs: list):
    """Address of the compiled function of a vector y with these values."""
    program = Program("rhs", dict(enumerate(Expansion().of(outputs))), {})
    return address(kernel(lambda: program, kernel_text(program, {})), KERNEL)


# --- along a trial
@njit(cache=True, error_model="numpy")
def step(layout, values, state, rate, dt, torque):
    """One step dt [s] of constant rate (3,): moves the deflections `state` (3,) [rad], and writes
    the `torque` (3,) [N m] at its end.
    """
    y = np.concatenate((torque, np.array([dt]), rate, values))
    if layout.bristles:
        y[:3] = state
        kernel_at(layout.step)(0.0, y, y, y, state)
        y[:3] = state
    kernel_at(layout.torque)(0.0, y, y, y, torque)


def drive(
    layout: Layout,
    values: np.ndarray,
    rate: np.ndarray,
    dt: float | np.ndarray,
    torque,
    slopes,
    middle: np.ndarray | None = None,
) -> None:
    """Torque (n, axes) [N m] at samples of the rates (n, axes), from rest.

    dt: step [s] between samples, or the times since the samples before (n,). slopes (n, axes,
        values): its slopes by the values, none where there is no room for them. middle: mean
        rates since the samples before, where they are not those of neighbouring samples.
    """
    between = rate
    if middle is not None and not layout.static:
        between = middle
    elif not layout.static:
        between = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1])])
    steps = np.broadcast_to(np.asarray(dt, float), len(rate)).copy()
    _drive(layout, values, rate, between, steps, torque, slopes)


@njit(cache=True, error_model="numpy")
def _drive(layout, values, rate, between, steps, torque, slopes):
    size, count = rate.shape[1], slopes.shape[2]
    wide = size + count
    y = np.concatenate((np.zeros(2 * size + 1), values))
    out, moved = np.empty(size * (1 + wide)), np.zeros((size, count))
    moves, pulls = layout.step, layout.torque
    if count:
        moves, pulls = layout.step_slopes, layout.torque_slopes
    for n in range(rate.shape[0]):
        if layout.bristles:
            y[size + 1 : 2 * size + 1] = between[n]
            y[size] = steps[n] if n else 0.0
            kernel_at(moves)(0.0, y, y, y, out)
            y[:size] = out[:size]
            for c in range(size):
                first = size + c * wide
                for p in range(count):
                    moved[c, p] = moved[c, p] * out[first + c] + out[first + size + p]
        y[size + 1 : 2 * size + 1] = rate[n]
        kernel_at(pulls)(0.0, y, y, y, out)
        for c in range(size):
            first = size + c * wide
            torque[n, c] = out[c]
            for p in range(count):
                slopes[n, c, p] = out[first + c] * moved[c, p] + out[first + size + p]
