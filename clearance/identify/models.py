"""Models of ball-joint friction behind one interface: a rate goes in, the torque that keeps it up
comes out.

Frame of the housing, x and y tilt, z spins the stud; rates (n, 3) [rad/s], torques (n, 3) [N m]. A
model has `name`, `parameters`, `options` (what made it), `linear`, and

    torque(values, trial)            from undeflected bristles, (n, 3)
    sensitivity(values, trial)       the torque and its slopes by the parameters, (n, 3, p)
    start(), step(values, state, rate, dt)      one step of a simulation; `state` moves
    compiled(layout, packed(values), state, rate, dt, torque)      the same for compiled callers
    passive_rate(values)             up to which rate it can only take up energy
    observed(trial), predicted(values, trial)      compared torques of the measured axes (n, k)

with values as an array in the order of the parameters or as a dictionary of all of them.
"""

import importlib
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from clearance.identify import axis_kernel, lugre_kernel
from clearance.identify.axis_kernel import Layout
from clearance.identify.lugre_kernel import DAMPING, TORQUE, VISCOUS, Form
from clearance.values.checks import finite, known, non_negative, one_of, positive, whole

Values = np.ndarray | Sequence[float] | Mapping[str, float]
Bounds = Mapping[str, tuple[float, float]]
AXES = "x", "y", "z"
#: rates at which passivity is looked at [rad/s], 0.6 % apart
SPEEDS = np.geomspace(1e-6, 1e4, 4001)
#: [rad/s], of the characteristic curve: below the slowest steady motion it is seen only while the
#: motion turns, and comes out wild
KNOTS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)


@dataclass(frozen=True)
class Parameter:
    """A number that a fit finds between low and high; typical: where it starts from."""

    name: str
    units: str
    low: float
    high: float
    typical: float

    def within(self, bounds: tuple[float, float], least: float) -> "Parameter":
        """The same with other bounds. Raises ValueError where these are none."""
        low, high = (finite(f"bounds of {self.name}", b) for b in bounds)
        if not least <= low < high:
            raise ValueError(
                f"bounds of {self.name} must rise from above {least:g}, got {low:g} and {high:g}"
            )
        middle = math.sqrt(low * high) if low > 0.0 else 0.5 * (low + high)
        return replace(
            self, low=low, high=high, typical=self.typical if low < self.typical < high else middle
        )


#: bounds of stiffness and damping and the upper one of the torque as in the source
KINETIC = Parameter("kinetic", "N m", 0.02, 10.0, 2.0)
STATIC = Parameter("static", "N m", 0.02, 10.0, 2.5)
SPEED = Parameter("stribeck_speed", "rad/s", 1e-3, 2.0, 0.05)
BRISTLES = (
    Parameter("stiffness", "N m/rad", 100.0, 1e4, 1000.0),
    Parameter("damping", "N m s/rad", 1e-3, 20.0, 1.0),
)
WEIGHT = Parameter("weight", "1", -2.0, 2.0, 0.1)
# how firmly neighbouring knots are held equal, which gives those without samples their torque
LEVEL = 1e-6
LOOSE = 0.1  # how firmly a network's units are held, beside its weights
THICK = Parameter("viscous", "N m s/rad", 1e-3, 10.0, 0.05)
LAG = Parameter("lag", "s", -0.02, 0.02, 0.0)
OFFSET = Parameter("offset", "N m", -100.0, 100.0, 0.0)
FOLLOWS = Parameter("load_exponent", "1", 0.05, 3.0, 1.0)
#: how the torque follows the preload: not at all, as preload^1, as preload^n
LOADS = ("fixed", "proportional", "power")
PRELOAD = 5000.0  # N, of the source
SHIFT = 0.05  # of a step, by which a lag is moved for its slope
FINER = 4  # steps of a sample where a lag is fitted: corners of the rate then lie within steps


def preload_of(trial) -> float:
    """Preload [N] of a trial. Raises ValueError where no fact gives it."""
    facts = getattr(trial, "facts", {})
    if "preload" not in facts:
        name = getattr(trial, "name", "?")
        raise ValueError(
            f"trial {name!r} has no fact preload [N]: in CSV '# preload = 5000' or '# "
            f"{name}.preload = 5000'"
        )
    return positive(f"trial {trial.name!r}: preload", facts["preload"])


def delayed(trial, lag: float) -> np.ndarray:
    """Rate [rad/s] of a trial a time [s] earlier, at `FINER` steps a sample, piecewise linear.

    Before the record it is that of the first sample: records should begin at rest. Raises
    ValueError for an uneven clock.
    """
    if not getattr(trial, "even", True):
        raise ValueError(f"trial {trial.name!r}: a lag needs even steps of the time")
    position = np.arange(FINER * (trial.samples - 1) + 1) / FINER - lag / trial.step
    columns = (np.interp(position, np.arange(trial.samples), column) for column in trial.rate.T)
    return np.ascontiguousarray(np.stack(list(columns), axis=1))


def _checked_knots(knots: Sequence[float], fewest: int) -> tuple[float, ...]:
    knots = tuple(non_negative("knots", k) for k in knots)
    if len(knots) < fewest or any(b <= a for a, b in itertools.pairwise(knots)):
        raise ValueError(f"knots must be at least {fewest} growing rates in rad/s, got {knots}")
    return knots


class Model:
    """Base of all models; see the module."""

    linear: ClassVar[bool] = False
    exact: bool = False  # whether `sensitivities` has slopes of the torque
    smoothing: float = 0.0
    compiled: Callable
    parameters: tuple[Parameter, ...]
    layout: Layout
    symmetric: bool
    bounds: Bounds

    @property
    def options(self) -> dict:
        """Arguments from which the function of its name makes this model."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def roughness(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows (k, p) and numbers (k,) whose difference, over the rms torque, a fit holds small.

        Prior of the logarithms of parameters, and of weights. Neighbouring knots are to be alike.
        """
        stems = [p.name.rpartition("_at_")[0] for p in self.parameters]
        eye = np.eye(len(stems))
        pairs = enumerate(itertools.pairwise(stems))
        rows = [eye[i + 1] - eye[i] for i, (a, b) in pairs if a and a == b]
        return self.smoothing * np.array(rows).reshape(-1, len(eye)), np.zeros(len(rows))

    @property
    def centred(self) -> list[int]:
        """Places of parameters that every start of a fit has at their typical values."""
        return [len(self.parameters) - 1] if getattr(self, "lag", False) else []

    @property
    def groups(self) -> tuple[str, str, str]:
        """Whose parameters the axes x, y, z have."""
        return ("tilt", "tilt", "spin") if self.symmetric else ("tilt_x", "tilt_y", "spin")

    def bounded(
        self, parameters: Sequence[Parameter], bounds: Bounds, least: float
    ) -> tuple[Parameter, ...]:
        """Parameters with the bounds requested, above the least one or their own."""
        self._check_names(bounds, [p.name for p in parameters], "bounds")
        return tuple(
            p.within(bounds[p.name], min(least, p.low)) if p.name in bounds else p
            for p in parameters
        )

    def _check_names(self, parameters, names: Sequence[str], subject: str) -> None:
        for name in parameters:
            known(f"{subject}: {self.name} has no parameter", name, names)

    def array(self, values: Values) -> np.ndarray:
        """Values in the order of the parameters (p,).

        Raises ValueError for wrong names, numbers and values.
        """
        names = [p.name for p in self.parameters]
        if isinstance(values, Mapping):
            self._check_names(values, names, "values")
            if missing := [n for n in names if n not in values]:
                raise ValueError(f"values: {missing[0]!r} of {self.name} is missing")
            values = [values[n] for n in names]
        values = np.asarray(values, float)
        if values.shape != (len(names),):
            raise ValueError(
                f"values: {self.name} has {len(names)} parameters, got an array of shape "
                f"{values.shape}"
            )
        for p, value in zip(self.parameters, values.tolist(), strict=True):
            (positive if p.low > 0.0 else finite)(p.name, value)
        return values

    def packed(self, values: Values, trial=None) -> np.ndarray:
        """Values and facts of a trial in the layout of the compiled functions."""
        return np.append(self.array(values), self.facts(trial))

    def facts(self, trial) -> Sequence[float]:
        """Numbers of a trial that the compiled functions read; None: those of reference."""
        return ()

    def observed(self, trial) -> np.ndarray:
        """Measured columns (n, k): the torques [N m] of the measured axes."""
        return trial.torque[:, np.flatnonzero(trial.measured)]

    def predicted(self, values: Values, trial) -> np.ndarray:
        """Prediction of the measured columns (n, k)."""
        return self.torque(values, trial)[:, np.flatnonzero(trial.measured)]

    def modelled(self, values: Values, trial):
        """The trial with what the model predicts in place of what was measured."""
        return trial.with_torque(self.torque(values, trial))

    def senses(self, trial) -> np.ndarray:
        """Signs (n, k) of errors: along the motion, where a level that is too high is one error
        both ways.
        """
        return np.where(trial.rate[:, np.flatnonzero(trial.measured)] < 0.0, -1.0, 1.0)

    def sizes(self, trials) -> float | np.ndarray:
        """Scales that divide the errors (n, k) of trials before their sum."""
        return 1.0

    def start(self) -> np.ndarray:
        """State of a joint at rest."""
        return np.zeros(0 if self.linear else 3)

    def step(self, values: Values, state: np.ndarray, rate: np.ndarray, dt: float) -> np.ndarray:
        """Torque (3,) [N m] at the end of a step [s] of constant rate (3,) [rad/s]; moves the
        state.

        Raises ValueError for rates that are not three numbers, and for a step that is negative;
        `compiled` looks at neither.
        """
        torque, rate = np.empty(3), np.asarray(rate, float)
        if rate.shape != (3,) or not all(map(math.isfinite, rate.tolist())):
            raise ValueError(f"rate must be three finite numbers [rad/s], got {rate.tolist()}")
        self.compiled(self.layout, self.packed(values), state, rate, non_negative("dt", dt), torque)
        return torque


class Driven(Model):
    """Base of models whose laws are on the trace, see identify/axis_kernel.py.

    kernels_of(axes) -> those of the axes that move.
    """

    lag: bool = False
    exact: bool = True
    compiled = staticmethod(axis_kernel.step)
    kernels_of: Callable[[tuple[int, ...]], Layout]

    @property
    def layout(self) -> Layout:
        """Kernels of all axes, for `compiled`."""
        return self.kernels_of(axis_kernel.ALL)

    def torque(self, values: Values, trial) -> np.ndarray:
        """Torque (n, 3) [N m] of a trial from undeflected bristles; see the module."""
        return self._driven(self.packed(values, trial), trial)[0]

    def _driven(
        self, packed: np.ndarray, trial, slopes: bool = False, later: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """The torque (n, 3) where it comes a time [s] later than by the model, and its slopes (n,
        3, packed).
        """
        axes = np.flatnonzero(trial.rate.any(axis=0))
        rate, dt, every = trial.rate, getattr(trial, "between", trial.step), 1
        if self.lag:
            rate = delayed(trial, float(packed[len(self.parameters) - 1]) + later)
            dt, every = trial.step / FINER, FINER
        count, moving = packed.size * slopes, np.ascontiguousarray(rate[:, axes])
        middle = getattr(trial, "rate_between", None) if every == 1 else None
        if middle is not None:
            middle = np.ascontiguousarray(middle[:, axes])
        parts = np.empty(moving.shape), np.empty((*moving.shape, count))
        if axes.size:
            kernels = self.kernels_of(tuple(axes.tolist()))
            axis_kernel.drive(kernels, packed, moving, dt, *parts, middle)
        torque, by = np.zeros((trial.samples, 3)), np.zeros((trial.samples, 3, count))
        torque[:, axes], by[:, axes] = (part[::every] for part in parts)
        self.add_position(packed, trial, axes, torque, by)
        return torque, by

    def add_position(self, packed, trial, axes, torque: np.ndarray, by: np.ndarray) -> None:
        """Add parts of the torque that do not depend on the rate, and their slopes: none."""

    def sensitivity(self, values: Values, trial) -> tuple[np.ndarray, np.ndarray]:
        """Torque (n, 3) [N m] of a trial and its slopes by the parameters (n, 3, p)."""
        packed, p = self.packed(values, trial), len(self.parameters)
        torque, slopes = self._driven(packed, trial, True)
        if self.lag:
            shift = SHIFT * trial.step
            later, earlier = (self._driven(packed, trial, later=s)[0] for s in (shift, -shift))
            slopes[:, :, p - 1] = (later - earlier) / (2.0 * shift)
        return torque, slopes[:, :, :p]


@dataclass(frozen=True)
class LuGre(Driven):
    """LuGre friction of a ball joint, its axes coupled or not; equations, units and source in
    identify/lugre_kernel.py.

    Per axis (tilt, spin): kinetic T_c, static T_s [N m] and stribeck_speed w_s [rad/s] of
    T = T_c + (T_s - T_c) exp(-(|w| / w_s)^exponent), stiffness sigma0 [N m/rad], damping sigma1,
    viscous sigma2 [N m s/rad].

    symmetric: both tilt axes have one set. knots [rad/s]: T, sigma0 and sigma1 are piecewise linear
        in |w| with values at these instead, level beyond them. network: T, sigma0 and sigma1 are
        functions of |w| from a network of so many tanh units. They share the units; they are
        positive and bounded, see `lugre_kernel.by_speed`. smoothing: what a factor of e between
        neighbouring knots, or by a unit, costs a fit, as an NRMSE. static: the torque of steady
        sliding, without bristles; at rest it stays as it was. bounds: of parameters by name. |w|
        is the rate's norm where axes are coupled, else the axis' own.

    load: dependence of the total torque on the fact `preload` F of a trial, fixed (none),
        proportional or power, (F / preload)^load_exponent. All other numbers are then those at
        `preload` [N].
    lag: a parameter lag [s], the delay of torques behind their rates, is fitted too. offset,
        position: so are M_0 [N m] and so many harmonics of the angle q turned since the start:
        M_0 + sum_k (a_k cos k q + b_k sin k q). `step` leaves them out.

    Valid for one temperature; sticks with the stiffness sigma0, creeps under a load that swings
    below T_s.
    """

    coupled: bool = True
    symmetric: bool = True
    knots: tuple[float, ...] = ()
    network: int = 0
    smoothing: float = 0.03
    exponent: float = 2.0
    static: bool = False
    load: str = "fixed"
    preload: float = PRELOAD
    lag: bool = False
    offset: bool = False
    position: int = 0
    bounds: Bounds = field(default_factory=dict)

    def __post_init__(self):
        whole("position", self.position)
        object.__setattr__(self, "knots", _checked_knots(self.knots, 2) if len(self.knots) else ())
        whole("network", self.network)
        if self.network and self.knots:
            raise ValueError(
                f"knots {self.knots} and a network of {self.network} units exclude each other"
            )
        one_of("load", self.load, LOADS)
        positive("preload", self.preload)
        positive("exponent", self.exponent)
        non_negative("smoothing", self.smoothing)
        _ = self.parameters  # bounds of unknown parameters

    @property
    def name(self) -> str:
        """ "lugre3d" or "lugre1d"."""
        return "lugre3d" if self.coupled else "lugre1d"

    @property
    def options(self) -> dict:
        """Arguments from which `lugre1d` or `lugre3d` makes this model."""
        return {k: v for k, v in super().options.items() if k != "coupled"}

    @cached_property
    def _functions(self) -> list[Parameter]:
        """Parameters of T, sigma0, sigma1, sigma2 of one axis."""
        bristles = [] if self.static else BRISTLES
        if not self.knots and not self.network:
            return [KINETIC, STATIC, SPEED, *bristles, THICK]
        functions = replace(KINETIC, name="torque"), *bristles
        return [*itertools.chain.from_iterable(map(self._table, functions)), THICK]

    def _table(self, of: Parameter) -> list[Parameter]:
        """Parameters of a function of the speed: at the knots, or a network's weights and level."""
        if self.knots:
            return [replace(of, name=f"{of.name}_at_{k:g}") for k in self.knots]
        count = range(1, self.network + 1)
        weights = (replace(WEIGHT, name=f"{of.name}_weight_{k}") for k in count)
        return [*weights, replace(of, name=f"{of.name}_level")]

    @cached_property
    def _units(self) -> list[Parameter]:
        """Rates and steepnesses of a network's units, of one axis."""
        rates = enumerate(np.geomspace(0.02, 1.0, self.network + 2)[1:-1].tolist(), 1)
        units = [Parameter(f"unit_rate_{k}", "rad/s", 1e-3, 10.0, r) for k, r in rates]
        steep = Parameter("", "1", 0.2, 5.0, 1.0)
        count = range(1, self.network + 1)
        return units + [replace(steep, name=f"unit_steepness_{k}") for k in count]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Fitted parameters, in the order of their vector."""
        groups = dict.fromkeys(self.groups)
        functions = [*self._units, *self._functions] + [FOLLOWS] * (self.load == "power")
        parameters = [replace(p, name=f"{g}_{p.name}") for g in groups for p in functions]
        parameters += [replace(OFFSET, name=f"{g}_{n}") for g in groups for n in self._terms]
        return self.bounded([*parameters, *([LAG] * self.lag)], self.bounds, 1e-12)

    @cached_property
    def _terms(self) -> list[str]:
        """Terms of an axis that do not depend on its rate."""
        harmonics = range(1, self.position + 1)
        return ["offset"] * self.offset + [f"{f}_{k}" for k in harmonics for f in ("cos", "sin")]

    @cached_property
    def _of_rate(self) -> int:
        """Number of the parameters of the law."""
        groups = len(dict.fromkeys(self.groups))
        return len(self.parameters) - self.lag - groups * len(self._terms)

    @property
    def centred(self) -> list[int]:
        """The terms and the lag."""
        return list(range(self._of_rate, len(self.parameters)))

    def add_position(self, packed, trial, axes, torque: np.ndarray, by: np.ndarray) -> None:
        """Add the terms of the axes that move."""
        count, names = len(self._terms), list(dict.fromkeys(self.groups))
        if not count:
            return
        angle = trial.angle
        for axis in axes:
            turned = [k * angle[:, axis] for k in range(1, self.position + 1)]
            rows = [np.ones(len(angle))] * self.offset
            rows += [f(x) for x in turned for f in (np.cos, np.sin)]
            first = self._of_rate + count * names.index(self.groups[axis])
            torque[:, axis] += packed[first : first + count] @ np.array(rows)
            if by.shape[2]:
                by[:, axis, first : first + count] = np.array(rows).T

    @cached_property
    def form(self) -> Form:
        """All that decides its kernels but for the numbers."""
        names, count = list(dict.fromkeys(self.groups)), self._of_rate
        others = len(self.parameters) - count + (self.load != "fixed")
        widths = *[count // len(names)] * len(names), others
        options = self.coupled, self.knots, self.network, float(self.exponent), self.static
        return Form(*options, self.load, tuple(map(names.index, self.groups)), widths)

    def kernels_of(self, axes: tuple[int, ...]) -> Layout:
        """Kernels of the axes that move."""
        return lugre_kernel.lugre(self.form, axes)

    def facts(self, trial) -> Sequence[float]:
        """The logarithm of the preload over that of reference."""
        if self.load == "fixed":
            return ()
        return (math.log(preload_of(trial) / self.preload) if trial else 0.0,)

    @cached_property
    def roughness(self) -> tuple[np.ndarray, np.ndarray]:
        """That of neighbouring knots. A network's weights are to be small, its units, less firmly,
        where they were.
        """
        rows, wanted = map(list, super().roughness)
        for p, row in zip(self.parameters, np.eye(len(self.parameters)), strict=True):
            share = 1.0 if "_weight_" in p.name else LOOSE if "_unit_" in p.name else 0.0
            if share:
                rows.append(share * self.smoothing * row)
                wanted.append(rows[-1].max() * math.log(p.typical) if p.low > 0.0 else 0.0)
        return np.array(rows).reshape(-1, len(self.parameters)), np.array(wanted)

    def functions(self, values: Values, speeds: Sequence[float]) -> np.ndarray:
        """T [N m], sigma0 [N m/rad], sigma1, sigma2 [N m s/rad] of the axes at speeds (n,) [rad/s],
        (3, 4, n).
        """
        form, count = self.form, self._of_rate
        function, speeds = lugre_kernel.by_speed(form), np.asarray(speeds, float).tolist()
        rows = self.array(values)[:count].reshape(-1, form.widths[0]).tolist()
        by_group = [[(*function(s, row), row[form.viscous]) for s in speeds] for row in rows]
        return np.array([by_group[g] for g in form.groups]).transpose(0, 2, 1)

    def passive_rate(self, values: Values) -> float:
        """Rate [rad/s] up to which no axis gives off more energy than its bristles hold, inf where
        that never happens.

        With the energy z' S0 z / 2 of the bristles this holds while |M w| / T_i^2 <= 4 (sigma1_i +
        sigma2_i) / sigma1_i^2, whatever the deflection. Uncoupled and started at rest (|sigma0 z|
        <= max T) it also holds where sigma2 >= sigma1 (max T / T - 1). A stiffness that changes
        with the speed does work that is not counted. Rounded down by 0.6 %.
        """
        values_at = self.functions(values, SPEEDS)
        torque, damping, viscous = (
            values_at[:, TORQUE],
            values_at[:, DAMPING],
            values_at[:, VISCOUS],
        )
        strongest = torque.max(axis=0) if self.coupled else torque
        fine = strongest * SPEEDS / torque**2 * damping**2 <= 4.0 * (damping + viscous)
        if not self.coupled:
            always = viscous >= damping * (torque.max(axis=1, keepdims=True) / torque - 1.0)
            fine |= always.all(axis=1, keepdims=True)
        bad = np.flatnonzero(~fine.all(axis=0))
        return math.inf if bad.size == 0 else float(SPEEDS[bad[0] - 1]) if bad[0] else 0.0

    def doubts(self, values: Values, fastest: float) -> list[str]:
        """Warnings about the values where rates reach `fastest` [rad/s]."""
        bound = self.passive_rate(values)
        if fastest <= bound:
            return []
        return [
            f"{self.name}: passive up to {bound:.3g} rad/s only, for the data reach {fastest:.3g}; "
            f"damping is high"
        ]


@dataclass(frozen=True)
class Curve(Driven):
    """Characteristic curve: each axis' torque is an odd, continuous, piecewise linear function of
    its own rate.

    Parameters: torques [N m] at the knots [rad/s]; zero at rest, level beyond the last knot.
    nonnegative: it brakes everywhere. No memory: no presliding, so it is wrong where amplitudes are
    small, and steep at rest.
    """

    knots: tuple[float, ...] = KNOTS
    symmetric: bool = True
    nonnegative: bool = False
    bounds: Bounds = field(default_factory=dict)

    name: ClassVar[str] = "curve"
    linear: ClassVar[bool] = True
    smoothing: ClassVar[float] = LEVEL

    def __post_init__(self):
        object.__setattr__(self, "knots", _checked_knots(self.knots, 1))
        if not self.knots[0]:
            raise ValueError("knots: the torque at rest is zero, the first knot must lie above")
        _ = self.parameters

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Fitted parameters, in the order of their vector."""
        names = [f"{g}_torque_at_{k:g}" for g in dict.fromkeys(self.groups) for k in self.knots]
        low = 0.0 if self.nonnegative else -100.0
        parameters = [Parameter(n, "N m", low, 100.0, 2.0) for n in names]
        return self.bounded(parameters, self.bounds, low)

    @cached_property
    def places(self) -> np.ndarray:
        """Places of the torques of each axis in the values (3, n)."""
        names, count = list(dict.fromkeys(self.groups)), len(self.knots)
        return np.array([count * names.index(g) + np.arange(count) for g in self.groups])

    def kernels_of(self, axes: tuple[int, ...]) -> Layout:
        """Kernels of the axes that move."""
        groups = self.places[:, 0] // len(self.knots)
        return lugre_kernel.curve(self.knots, tuple(groups.tolist()), axes)

    def passive_rate(self, values: Values) -> float:
        """Rate [rad/s] up to which it brakes, inf where it always does."""
        torques = self.array(values)[self.places]
        bad = np.flatnonzero((torques < 0.0).any(axis=0))
        return math.inf if bad.size == 0 else (0.0, *self.knots)[bad[0]]

    def doubts(self, values: Values, fastest: float) -> list[str]:
        """Warnings about the values where rates reach `fastest` [rad/s]."""
        before = [0.0, *self.knots[:-1]] * (len(self.parameters) // len(self.knots))
        reached = zip(self.parameters, self.array(values), before, strict=True)
        bad = [f"{p.name} {v:.3g}" for p, v, rate in reached if v < 0.0 and rate < fastest]
        if not bad:
            return []
        return [
            f"curve: drives the joint where its torque is negative: {', '.join(bad)}; nonnegative "
            f"holds it at zero"
        ]


def lugre1d(**options) -> LuGre:
    """LuGre friction of each axis by its own rate; options as of `LuGre`."""
    return LuGre(coupled=False, **options)


def lugre3d(**options) -> LuGre:
    """LuGre friction of all axes, coupled by the ellipsoid of their torques; options as of
    `LuGre`.
    """
    return LuGre(coupled=True, **options)


#: name -> function of the model's options
MODELS: dict[str, Callable[..., Model]] = {"lugre1d": lugre1d, "lugre3d": lugre3d, "curve": Curve}
#: name -> module that adds it: models that need more packages
FURTHER = {"lstm": "clearance.identify.learn"}


def model(name: str, **options) -> Model:
    """A model by its name.

    Raises ValueError for an unknown one, naming those there are, and for options it has not.
    """
    if name in FURTHER and name not in MODELS:
        importlib.import_module(FURTHER[name])
    one_of("model", name, dict.fromkeys([*MODELS, *FURTHER]))
    try:
        return MODELS[name](**options)
    except TypeError as error:
        raise ValueError(f"{name}: {error}") from None
