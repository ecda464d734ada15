"""Models of one's own: a function of a record and of numbers, which a fit compares with what was
measured.

    from clearance.identify.own import between, model

    law = model(my_law, torque=between(0.1, 10.0, "N m"), stiffness=between(100.0, 1e4, "N m/rad"))

    @model(predicts={"x": "m", "y": "m"}, dry=between(0.1, 0.8), full=between(2.0, 6.0))
    def journal(record, dry, full):
        ...
        return np.stack([x, y], axis=1)

A friction law of a joint (`cl.joint_friction`, `cl.joint_bristle`) is driven by the rate of each
axis. Any other function gets the record and its parameters by name. It returns its prediction at
`record.time`: the torque (n, 3) [N m], or the columns of `predicts` (n, k).
"""

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import ClassVar

import numpy as np

from clearance.identify.axis_kernel import Layout, Leaves
from clearance.identify.models import (
    FINER,
    LAG,
    Bounds,
    Driven,
    Model,
    Parameter,
    Values,
    delayed,
    preload_of,
)
from clearance.identify.records import Trial
from clearance.laws.law import Law, joint_bristle, joint_friction
from clearance.scene.user_module import located, module_of
from clearance.tracing.function import Opaque
from clearance.tracing.interpreter import traced
from clearance.tracing.trace import live
from clearance.values.checks import finite, identifier, known, meant, positive, rising

# of a parameter (of its range where it may be negative), by which it is moved for slopes
DIFFERENCE = 1e-4
GROUPS = "tilt", "tilt", "spin"  # whose parameters a law has about x, y, z


def between(low: float, high: float, units: str = "1", start: float | None = None) -> Parameter:
    """A parameter to be fitted: its bounds, its SI unit, and where the search starts.

    start: the geometric mean of the bounds by default, their mean where one is not
        positive. Positive parameters are searched for in their logarithms.
    Raises ValueError for bounds that do not rise and a start outside.
    """
    low, high = rising("between: bounds", (low, high))
    parameter = Parameter("", units, low, high, math.nan).within((low, high), -math.inf)
    start = finite("between: start", parameter.typical if start is None else start)
    if not low <= start <= high:
        raise ValueError(f"between: start must lie in [{low:g}, {high:g}], got {start:g}")
    return replace(parameter, typical=start)


@dataclass(frozen=True, eq=False)
class Own(Model):
    """A model of one's own; made by `model`.

    function(record, **numbers) -> (n, 3) [N m], or (n, k) where `predicts` names columns with their
    units; free: parameters without the lag; difference: relative step of the slopes; lag: whether
    a lag of the torque is fitted.
    """

    function: Callable
    free: tuple[Parameter, ...]
    predicts: Mapping[str, str] = field(default_factory=dict)
    difference: float = DIFFERENCE
    name: str = "own"
    law: Law | None = None
    lag: bool = False

    symmetric: ClassVar[bool] = True
    groups: ClassVar[tuple[str, ...]] = ()  # functions have no axes

    @property
    def options(self) -> dict:
        """None: its file is what it is made from."""
        return {}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Fitted parameters, in the order of their vector."""
        return (*self.free, *([LAG] * self.lag))

    def with_bounds(self, bounds: Bounds) -> "Own":
        """The same with other bounds of some parameters."""
        return replace(self, free=self.bounded(self.free, bounds, -math.inf))

    def with_lag(self) -> "Own":
        """The same with a lag [s] of the torque.

        Raises ValueError for a model that predicts other columns.
        """
        if self.predicts:
            raise ValueError(f"--lag: {self.name} predicts {', '.join(self.predicts)}, no torque")
        return replace(self, lag=True)

    def _called(self, values: Values, record) -> np.ndarray:
        """Result of the function, (n, 3) or (n, k). Raises ValueError for another shape."""
        numbers = dict(
            zip((p.name for p in self.parameters), self.array(values).tolist(), strict=True)
        )
        if self.lag:
            return self.function(_finer(record, numbers.pop(LAG.name)), **numbers)[::FINER]
        prediction = np.asarray(self.function(record, **numbers), float)
        if self.predicts and len(self.predicts) == 1 and prediction.shape == (record.samples,):
            prediction = prediction[:, None]
        wanted = record.samples, len(self.predicts) or 3
        if prediction.shape != wanted:
            raise ValueError(
                f"{self.name} must return an array of shape {wanted}, got {prediction.shape}"
            )
        return prediction

    def torque(self, values: Values, trial) -> np.ndarray:
        """Torque (n, 3) [N m] of a trial."""
        return self._called(values, trial)

    def observed(self, trial) -> np.ndarray:
        """Columns that were measured (n, k). Raises ValueError for trials of the other kind."""
        if not self.predicts:
            return super().observed(trial)
        if isinstance(trial, Trial):
            reason = f"read(path, predicts={dict(self.predicts)}) has them"
            raise ValueError(
                f"{self.name} predicts {', '.join(self.predicts)}, not torques: {reason}"
            )
        return np.stack([trial[c] for c in self.predicts], axis=1)

    def predicted(self, values: Values, trial) -> np.ndarray:
        """The same as the model predicts."""
        return self._called(values, trial) if self.predicts else super().predicted(values, trial)

    def modelled(self, values: Values, trial):
        """The trial with the model's columns."""
        if not self.predicts:
            return super().modelled(values, trial)
        columns = dict(zip(self.predicts, self._called(values, trial).T, strict=True))
        return replace(trial, columns=trial.columns | columns)

    def senses(self, trial) -> float | np.ndarray:
        """Signs of errors: of columns as they are."""
        return 1.0 if self.predicts else super().senses(trial)

    def sizes(self, trials) -> float | np.ndarray:
        """Rms of all columns of a unit together, (k,): so columns of different units are put
        together.
        """
        if not self.predicts:
            return 1.0
        units = list(self.predicts.values())
        measured = np.concatenate([self.observed(t) for t in trials])
        squares = {u: np.mean(measured[:, [v == u for v in units]] ** 2) for u in units}
        return np.array([math.sqrt(squares[u]) or 1.0 for u in units])

    def doubts(self, values: Values, fastest: float) -> list[str]:
        """None: a function has no requirements."""
        return []


def model(
    function: Callable | Law | None = None,
    /,
    *,
    predicts: Mapping[str, str] | None = None,
    arm: float = 1.0,
    difference: float = DIFFERENCE,
    **parameters: Parameter | float,
):
    """A model from a friction law of a joint, or (as a decorator) from a function of a record.

    parameters: `between(low, high, units)` is fitted, a plain number is held. predicts: columns
        that the function returns, with their SI units (else the torque). arm: of laws, what a
        preload [N] times is their load [m].
    difference: relative step of central differences; a simulation needs more than its error.

    A law's parameters are fitted about each axis by itself: tilt_stiffness, spin_stiffness. A
    bristle's deflection is carried by the exponential step, which is exact where z' is linear in z,
    from rest.
    Raises ValueError and TypeError for parameters that the function has not or that are missing.
    """
    if function is None:
        options = {"predicts": predicts, "arm": arm, "difference": difference}
        return lambda wrapped: model(wrapped, **options, **parameters)
    name, predicts = function.__name__, dict(predicts or {})
    fitted = {n: p for n, p in parameters.items() if isinstance(p, Parameter)}
    held = {n: finite(f"{name}: {n}", p) for n, p in parameters.items() if n not in fitted}
    if not fitted:
        raise ValueError(
            f"model {name}: no parameter to fit; give one as between(low, high, units)"
        )
    for column in predicts:
        identifier(f"model {name}: predicts", column.replace("/", "_"))
    difference = positive(f"model {name}: difference", difference)
    if isinstance(function, Law):
        _check_parameters(name, function.inputs, function.needed, parameters)
        if function.family not in (joint_friction, joint_bristle):
            families = "joint_friction or joint_bristle"
            raise ValueError(
                f"{name} is a {function.family.name} law; models are made of {families} laws and "
                f"functions"
            )
        renamed = [
            replace(p, name=f"{g}_{n}") for g in dict.fromkeys(GROUPS) for n, p in fitted.items()
        ]
        of_law = {"law": function, "held": held, "arm": positive(f"model {name}: arm", arm)}
        return OwnLaw(function, tuple(renamed), {}, difference, name, **of_law)
    arguments = list(inspect.signature(function).parameters.values())[1:]
    needed = [a.name for a in arguments if a.default is a.empty]
    _check_parameters(name, [a.name for a in arguments], needed, parameters)
    renamed = tuple(replace(p, name=n) for n, p in fitted.items())
    return Own(_with(function, held), renamed, predicts, difference, name)


def _finer(trial: Trial, lag: float) -> Trial:
    """The trial with its rate a time [s] earlier, at finer steps; without a torque."""
    rate = delayed(trial, lag)
    time = trial.time[0] + trial.step / FINER * np.arange(len(rate))
    return replace(trial, time=time, rate=rate, torque=np.zeros((len(rate), 3)))


class FunctionError(ValueError):
    """An error that a user's function raised, with its file, line and function; the cause is that
    error.
    """


def _with(function: Callable, held: dict) -> Callable:
    """The function with the parameters that are held.

    It raises FunctionError for whatever the function raises.
    """

    def called(record, **numbers):
        try:
            return function(record, **held, **numbers)
        except Exception as error:
            raise FunctionError(f"model {function.__name__}: {located(error)}") from error

    return called


def _check_parameters(name: str, names: list[str], needed: list[str], parameters: Mapping) -> None:
    for parameter in parameters:
        known(f"model {name} has no parameter", parameter, names)
    if missing := [n for n in needed if n not in parameters]:
        raise ValueError(
            f"model {name}: give {missing[0]} as between(low, high, units), or as a number"
        )


# --- laws
@dataclass(frozen=True, eq=False)
class OwnLaw(Driven, Own):
    """A friction law of a joint, driven by the rates of a trial about each axis by itself.

    held: numbers of the law that are not fitted; arm: what a preload [N] times is its load [m].
    """

    held: Mapping[str, float] = field(default_factory=dict)
    arm: float = 1.0

    groups: ClassVar[tuple[str, ...]] = GROUPS

    @property
    def exact(self) -> bool:
        """False for a law that cannot be traced."""
        return not isinstance(traced(self.law.function), Opaque)

    def kernels_of(self, axes: tuple[int, ...]) -> Layout:
        """Kernels of the axes that move."""
        names = tuple(p.name for p in self.parameters)
        return kernels(self.law, names, tuple(self._others), axes)

    @property
    def _others(self) -> dict[str, float]:
        """Numbers that all groups have: those held, and defaults of those not fitted."""
        return {n: v for n, v in self.numbers("", {}).items() if v is not inspect.Parameter.empty}

    def numbers(self, group: str, values: Mapping[str, float]) -> dict[str, float]:
        """The law's parameters about an axis."""
        fitted = {
            n.removeprefix(f"{group}_"): v for n, v in values.items() if n.startswith(f"{group}_")
        }
        defaults = {n: v for n, v in self.law.parameters.items() if n in self.law.inputs}
        return defaults | dict(self.held) | fitted

    def facts(self, trial) -> Sequence[float]:
        """Numbers that are not fitted, and the load [N m] where the law reads it."""
        load = 0.0
        if trial and not self.exact:
            load = self.arm * trial.facts.get("preload", math.nan)  # it may not need one
        elif trial and reads_load(self.law):
            load = self.arm * preload_of(trial)
        return *self._others.values(), load

    def doubts(self, values: Values, fastest: float) -> list[str]:
        """Requirements and warnings of the law about its numbers, for each axis."""
        names, lines = [p.name for p in self.parameters], []
        by_name = dict(zip(names, self.array(values).tolist(), strict=True))
        for group in dict.fromkeys(GROUPS):
            bound = self.law(**self.numbers(group, by_name))
            for look in filter(None, (self.law.demand, self.law.doubt)):
                reason = look(None, bound.values)
                lines += [f"{group}: {self.name} {reason}"] if reason else []
        return lines


def reads_load(law: Law) -> bool:
    """True for a traced law whose values depend on its load."""
    function = traced(law.function)
    return function.arguments[law.family.state.index("load")] in live(function.outputs)


@lru_cache(maxsize=64)
def kernels(law: Law, names: tuple[str, ...], others: tuple[str, ...], axes: tuple[int, ...]):
    """Kernels of a law about each axis: of fitted numbers by these names, of others, of a load."""
    leaves, function = Leaves(axes, (len(names), len(others) + 1)), traced(law.function)
    fitted, (*rest, load) = leaves.numbers
    bristles = law.family is joint_bristle
    rates, torques = [], []
    for z, w, axis in zip(leaves.z, leaves.w, axes, strict=True):
        start = f"{GROUPS[axis]}_"
        of_axis = {
            n.removeprefix(start): v
            for n, v in zip(names, fitted, strict=True)
            if n.startswith(start)
        }
        by_name = dict(zip(others, rest, strict=True)) | of_axis
        numbers = [
            by_name[n] if n in by_name else law.checks[n].function(by_name) for n in law.parameters
        ]
        values = leaves.trace.call(function, [*[z] * bristles, w, load, *numbers])
        rates, torques = rates + values[:-1], [*torques, leaves.trace.neg(values[-1])]
    return leaves.layout([*rates, *torques], exact=not isinstance(function, Opaque))


# --- files
def open_model(reference: str) -> Own:
    """A model of a file, "path/to/file.py:name"; runs the file.

    The name may be left out where the file has one model.

    Raises ValueError for a file or a model that is not there, naming the models and functions of
    the file.
    """
    path, name = _path_and_name(reference)
    if not path or not Path(path).is_file():
        reason = f"expected NAME or FILE.py:NAME, and there is no file {path or reference!r}"
        raise ValueError(f"--model {reference}: {reason}")
    module = module_of(path, "model", f"--model {reference}")
    models = {n: v for n, v in vars(module).items() if isinstance(v, Own)}
    if not name and len(models) == 1:
        (name,) = models
    if name not in models:
        raise ValueError(f"--model {reference}: {_no_model(name, models, module)}")
    return replace(models[name], name=name)


def _path_and_name(reference: str) -> tuple[str, str]:
    """The two parts of FILE.py:NAME; a name that is left out is empty."""
    if reference.endswith(".py"):
        return reference, ""
    path, _, name = reference.rpartition(":")
    return path, name


def _no_model(name: str, models: Mapping, module: ModuleType) -> str:
    """The reason why a file has no model of a name, and the names that it has."""
    if models and not name:
        return (
            f"the name of a model is missing; give FILE.py:NAME, the file has {', '.join(models)}"
        )
    reason = f"the file has no model {name!r}" if name else "the file has no model"
    if models:
        return f"{reason}{meant(name, models)}; it has {', '.join(models)}"
    here = {
        n: v for n, v in vars(module).items() if getattr(v, "__module__", None) == module.__name__
    }
    functions = [n for n, v in here.items() if callable(v)]
    there = f"; its functions are {', '.join(functions)}" if functions else ""
    return f"{reason}{there}; make one by clearance.identify.own.model"
