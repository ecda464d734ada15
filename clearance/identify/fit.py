"""Parameters of a friction model from measured torques: one call, with errors, warnings and
provenance.

identify/estimation.py has the method. Other models bring `estimate(trials, starts, seed, progress)`
themselves.
"""

import json
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from clearance.identify import doubts, estimation, models
from clearance.identify.estimation import MOST_STARTS, STARTS, in_group
from clearance.identify.models import LuGre, Model
from clearance.identify.own import Own
from clearance.identify.records import Series
from clearance.results.reading import Entries, open_checked
from clearance.results.tables import save_tables
from clearance.values import checks

FORMAT = "clearance-friction-fit"
FORMAT_VERSION = 1
STILL = 1e-7  # rad: a trial that turns less has no motion


def nrmse(measured: np.ndarray, modelled: np.ndarray, over: str = "rms") -> float:
    """Root mean square of the error over that of the measured values, all trials and measured axes
    together.

    over: "rms", or "std" and "range" for the standard deviation and the range (largest less
        smallest) of the measured values in its place.
    Raises ValueError for another one, for shapes that differ, and where that size is zero.
    """
    measured, modelled = np.asarray(measured, float), np.asarray(modelled, float)
    if measured.shape != modelled.shape or not measured.size:
        raise ValueError(
            f"nrmse: shapes {measured.shape} and {modelled.shape} must be equal and not empty"
        )
    sizes = {"rms": lambda x: np.sqrt(np.mean(x**2)), "std": np.std, "range": np.ptp}
    size = float(sizes[checks.one_of("nrmse: over", over, sizes)](measured))
    if not size:
        raise ValueError(f"nrmse: the {over} of the measured values is zero")
    return float(np.sqrt(np.mean((modelled - measured) ** 2))) / size


@dataclass(frozen=True, eq=False)
class Fit:
    """A model with its fitted values.

    values: by the parameters' names; low, high: 95 % intervals, in the logarithms where a model is
        not linear, no wider than the bounds. covariance (p, p) of the values, to first order. All
        three take the errors of samples as
    independent: where the model is too simple they are not, and intervals are too narrow, see
        `widened`. nrmse: by role, see `nrmse`; history: cost [(N m)^2] (half the sum of squares, of
        a table's roughness too) over the iterations from the best start; starts: cost, evaluations
        and values of all starts; facts: samples, noise [N m], evaluations, seconds ...; `doubts`:
        warnings, as sentences.
    """

    model: Model
    values: dict[str, float]
    low: dict[str, float]
    high: dict[str, float]
    covariance: np.ndarray
    nrmse: dict[str, float]
    history: np.ndarray
    starts: dict[str, np.ndarray]
    facts: dict
    doubts: tuple[str, ...] = ()

    @property
    def fitted(self) -> dict[str, float]:
        """The values of axes that moved; those of the others are where the search began."""
        still = self.facts.get("still", [])
        return {
            n: v for n, v in self.values.items() if not any(in_group(n, group) for group in still)
        }

    def torque(self, trial) -> np.ndarray:
        """Torque (n, 3) [N m] that the model gives for a trial."""
        return self.model.torque(self.values, trial)

    def rms(self, trial) -> float:
        """Rms error of a trial, in its units: of the measured torques [N m], or of all columns."""
        errors = self.model.predicted(self.values, trial) - self.model.observed(trial)
        return float(np.sqrt(np.mean(errors**2)))

    def score(self, trials: Iterable, over: str = "rms") -> float:
        """NRMSE of these trials, see `nrmse`."""
        return _score(self.model, self.values, trials, over)

    def widened(self) -> tuple[dict[str, float], dict[str, float]]:
        """Low and high ends of the intervals as wide as the correlation of the errors makes them,
        within the bounds.

        By sqrt(tau), tau [samples] the integrated autocorrelation time of the errors along the
        motion; of all parameters alike, an estimate. What differs from specimen to specimen is not
        in it.
        """
        factor, low, high = self.facts.get("widening", 1.0), {}, {}
        for p in self.model.parameters if self.low else ():
            value, log = self.values[p.name], p.low > 0.0 and not self.model.linear
            ends = np.array([self.low[p.name], self.high[p.name]])
            wide = value * (ends / value) ** factor if log else value + factor * (ends - value)
            low[p.name], high[p.name] = (float(e) for e in np.clip(wide, p.low, p.high))
        return low, high

    @property
    def has_law(self) -> bool:
        """True for a LuGre model of constant parameters, see `law`."""
        model = self.model
        if not isinstance(model, LuGre) or model.load == "power":
            return False
        return not (model.knots or model.network or model.static)

    def law(self, axis: str = "spin", arm: float | None = None):
        """The friction of one axis (spin, tilt; of models that distinguish them tilt_x, tilt_y) as
        `cl.joint_lugre`.

        Turned about that axis alone, the model is that law. Where the torque is proportional to the
        preload it is `cl.joint_lugre_loaded`, whose load in the hinge is the preload times an arm
        [m]. Raises ValueError for an axis that the model has not, a missing arm, and for models
        that are no LuGre law of constant parameters.
        """
        from clearance.laws import joint_lugre, joint_lugre_loaded

        if not self.has_law:
            raise ValueError(f"law: this {self.model.name} is no LuGre law of constant parameters")
        checks.one_of("law: axis", axis, dict.fromkeys(self.model.groups))
        numbers = {
            n: self.values[f"{axis}_{n}"]
            for n in ("static", "kinetic", "stiffness", "damping", "viscous")
        }
        speed = self.values[f"{axis}_stribeck_speed"]
        options = {"stribeck_rate": speed, "exponent": self.model.exponent}
        if self.model.load == "fixed":
            return joint_lugre(**numbers, **options)
        if arm is None:
            raise ValueError(
                "law: the torque follows the preload: give arm [m], by which the preload makes the "
                "load"
            )
        load = self.model.preload * checks.positive("law: arm", arm)
        return joint_lugre_loaded(**{n: v / load for n, v in numbers.items()}, **options)

    def save(self, path: str | Path) -> Path:
        """All of it as HDF5 (format clearance-friction-fit), for `open_fit`."""

        def numbers(text: str, values: Iterable[float]) -> tuple:
            return "as units say", text, np.array([*values])

        of = self.model.parameters
        parameters = {
            "name": ("1", "parameter", [*self.values]),
            "units": ("1", "its units", [p.units for p in of]),
            "value": numbers("value", self.values.values()),
            "lower_bound": numbers("least value tried", (p.low for p in of)),
            "upper_bound": numbers("largest value tried", (p.high for p in of)),
        }
        if self.low:
            parameters["low"] = numbers("lower end of the 95 % interval", self.low.values())
            parameters["high"] = numbers("upper end of the 95 % interval", self.high.values())
        scores = np.array([*self.nrmse.values()])
        tables = {
            "parameters": parameters,
            "covariance": {
                "covariance": ("products of the parameters'", "of the values", self.covariance)
            },
            "history": {"cost": ("(N m)^2", "half the sum of squares, by iteration", self.history)},
            "starts": {n: ("see long_name", _STARTS.get(n, n), v) for n, v in self.starts.items()},
            "nrmse": {
                "role": ("1", "role of trials", list(self.nrmse)),
                "nrmse": ("1", "rms error over rms torque", scores),
            },
        }
        attributes = {
            "format_version": FORMAT_VERSION,
            "model": self.model.name,
            "options": json.dumps(self.model.options),
            "own_model": isinstance(self.model, Own),
            "synthetic": bool(self.facts.get("synthetic", False)),
            "facts": json.dumps(self.facts),
            "doubts": json.dumps(self.doubts),
        }
        return save_tables(path, FORMAT, attributes, {n: ({}, t) for n, t in tables.items()})


_STARTS = {
    "cost": "cost reached [(N m)^2]",
    "evaluations": "passes over the samples",
    "values": "values, by parameter",
}


def open_fit(path: str | Path, model: Model | None = None) -> Fit:
    """Read what `Fit.save` wrote.

    model: that of the fit where it is one's own (`own.open_model("file.py:name")`): no file of a
        fit names code that is run.
    Raises FileNotFoundError, or ValueError for other files.
    """
    with open_checked(Path(path), "clearance fit", FORMAT, FORMAT_VERSION) as file:
        table = Entries(
            f"{path}: /parameters",
            {n: file.column(f"parameters/{n}") for n in file.names("parameters")},
        )
        names = table["name"].tolist()
        model = _model_of(file, model, names)
        values, low, high = (
            dict(zip(names, table[c].tolist(), strict=True)) if c in table else {}
            for c in ("value", "low", "high")
        )
        scores = (file.column(f"nrmse/{c}").tolist() for c in ("role", "nrmse"))
        return Fit(
            model=model,
            values=values,
            low=low,
            high=high,
            covariance=file.column("covariance/covariance"),
            nrmse=dict(zip(*scores, strict=True)),
            history=file.column("history/cost"),
            starts={n: file.column(f"starts/{n}") for n in file.names("starts")},
            facts=file.document("", "facts"),
            doubts=tuple(file.document("", "doubts", list)),
        )


def _model_of(file, model: Model | None, names: list[str]) -> Model:
    """The model of a file: a built-in one, or the one given, where it has these parameters."""
    name = file.attribute("", "model")
    if not file.attributes("").get("own_model", False):
        return models.model(name, **file.document("", "options"))
    if model is None:
        raise ValueError(f"the fit is of a model of your own, {name}: open_fit(path, model=...)")
    if isinstance(model, Own) and names[-1:] == [models.LAG.name] and not model.lag:
        model = model.with_lag()
    if (there := [p.name for p in model.parameters]) != names:
        raise ValueError(f"model {model.name} has the parameters {there}, the fit {names}")
    return model


def fit(
    measurement,
    model: str | Model = "lugre3d",
    *,
    starts: int | None = None,
    seed: int = 0,
    roles: Sequence[str] = ("training",),
    progress: Callable[[float | str], None] | None = None,
) -> Fit:
    """Parameters of a model (or of one by its name) from the trials of these roles.

    starts: number of points that a nonlinear fit begins from (20; 1 of a model of one's own). The
        first stands at the typical values, the seed spreads the others over the bounds. progress:
        called with the done share, of a model of one's own with a text.
    Raises ValueError for roles that no trial has, a trial without motion, and an unknown model.
    """
    model = models.model(model) if isinstance(model, str) else model
    if starts is None:
        starts = 1 if isinstance(model, Own) else STARTS
    checks.whole("starts", starts, 1, MOST_STARTS)
    roles = (roles,) if isinstance(roles, str) else tuple(roles)
    trials = measurement.of(*roles).trials
    seed = checks.whole("seed", seed)
    driven = [t for t in trials if not isinstance(t, Series)]
    for t in driven:
        if (way := float(abs(t.rate).sum()) * t.step) < STILL:
            reason = f"never moves ({way:.2g} rad in all): it contains nothing about friction"
            raise ValueError(f"trial {t.name!r} {reason}")
    began = time.perf_counter()
    how = {"starts": starts, "seed": seed, "progress": progress or (lambda share: None)}
    estimate = getattr(model, "estimate", partial(estimation.estimate, model))(trials, **how)
    took = time.perf_counter() - began
    names = [p.name for p in model.parameters]
    values, low, high = (
        dict(zip(names, v.tolist(), strict=False))
        for v in (estimate.values, estimate.low, estimate.high)
    )
    scores = {r: _score(model, values, measurement.of(r).trials) for r in measurement.roles}
    fastest = max((float(np.linalg.norm(t.rate, axis=1).max()) for t in driven), default=0.0)
    facts = {
        "roles": list(roles),
        "trials": [t.name for t in trials],
        "samples": sum(t.samples for t in trials),
        "starts": starts,
        "seed": int(seed),
        "seconds": took,
        "fastest": fastest,
        "synthetic": bool(measurement.facts.get("synthetic", False)),
        **estimate.facts,
    }
    remarks = [
        *doubts.of_records(driven),
        *doubts.of_scores(scores, driven),
        *doubts.of_loads(model, driven),
        *estimate.doubts,
        *model.doubts(values, fastest),
    ]
    if low:
        errors = [row for t in trials for row in _errors_along(model, values, t, trials)]
        time_of_one, samples = doubts.correlation(errors), sum(map(len, errors))
        independent, widening = samples / time_of_one, math.sqrt(time_of_one)
        facts |= {"independent_samples": independent, "widening": widening}
        remarks += doubts.of_lag(facts, trials)
        remarks += doubts.of_short_damping(model, values, driven)
        remarks += doubts.of_intervals(widening, samples, independent)
    about = estimate.covariance, scores, estimate.history, estimate.starts
    return Fit(model, values, low, high, *about, facts, tuple(remarks))


def _errors_along(model: Model, values: dict[str, float], trial, trials) -> np.ndarray:
    """Errors of the columns of a trial (k, n), along the motion, over the sizes of all trials."""
    errors = model.predicted(values, trial) - model.observed(trial)
    return (errors / model.sizes(trials) * model.senses(trial)).T


def _score(model: Model, values: dict[str, float], trials: Iterable, over: str = "rms") -> float:
    trials = list(trials)
    sizes = model.sizes(trials)
    measured = [(model.observed(t) / sizes).ravel() for t in trials]
    modelled = [(model.predicted(values, t) / sizes).ravel() for t in trials]
    return nrmse(np.concatenate(measured), np.concatenate(modelled), over)
