"""Trials of a test bench: their columns and units, and what is checked of them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from clearance.identify.measured import check_varies
from clearance.values.checks import distinct, identifier, known, one_of

AXES = "xyz"
#: roles of a trial
LABELS = {
    "kind": ("triangle", "sine", "mixed", "other"),
    "axis": ("spin", "tilt", "mixed"),
    "role": ("training", "test", "extrapolation", "other"),
}
#: quantity -> its meaning, and units that it may come in -> factor to SI, the SI unit first
QUANTITIES = {
    "time": ("time", {"s": 1.0, "ms": 1e-3}),
    "rate": ("relative angular velocity", {"rad/s": 1.0, "deg/s": math.pi / 180.0}),
    "torque": ("torque that keeps the motion up", {"N m": 1.0, "N mm": 1e-3, "kN m": 1e3}),
    "angle": ("relative angle", {"rad": 1.0, "deg": math.pi / 180.0}),
}
OPTIONAL = "angle"
#: column of a trial -> the same of it
COLUMNS = {
    f"{quantity}_{axis}".rstrip("_"): (f"{meaning} {axis}".rstrip(), units)
    for quantity, (meaning, units) in QUANTITIES.items()
    for axis in (AXES if quantity != "time" else ("",))
}


#: fewest samples of a trial
FEWEST = 50
#: share of a step by which two samples may be nearer or farther than the others: rounded clocks, no
#: gaps
UNEVEN = 0.1
GAP = 50.0  # steps after which a clock that may be uneven has left the record
#: what no test of a ball joint exceeds: degrees, N mm and ms taken for SI units do
LONGEST_STEP = 0.05  # s
HIGHEST_RATE = 50.0  # rad/s, eight turns a second
WIDEST_TILT, WIDEST_SPIN = math.pi, 2.0 * math.pi  # rad from end to end
TORQUES = 1e-3, 200.0  # N m: largest torque of a measurement
#: form of a column in other units
CALL = "Then call it {} in CSV, or its units {!r} in HDF5"
TRUST = "; if these are SI, --trust-units (trusted=True) reads them as they are"

Where = Callable[[int], str]


class Sampled:
    """Something over time steps: `time` (n,) [s]; even: they are equal."""

    time: np.ndarray
    even = True

    @property
    def step(self) -> float:
        """Time step [s]."""
        return float(self.time[-1] - self.time[0]) / (self.samples - 1)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.time)

    @property
    def between(self) -> float | np.ndarray:
        """Time step [s], or the times since the samples before (n,), where a clock is uneven."""
        return self.step if self.even else np.diff(self.time, prepend=self.time[0])


@dataclass(frozen=True, eq=False)
class Trial(Sampled):
    """One run of a test bench: time (n,) [s], rate (n, 3) [rad/s], torque (n, 3) [N m] in the frame
    of the housing.

    measured: axes whose torque counts, the others are set to zero; facts: SI, such as preload,
        amplitude, speed, frequency; even: steps of the time are equal; turned (n, 3): measured
        angles [rad], nan where an axis has none.
    Raises ValueError for shapes, labels and samples that cannot be, naming row and column.
    """

    name: str
    kind: str
    axis: str
    role: str
    time: np.ndarray
    rate: np.ndarray
    torque: np.ndarray
    measured: tuple[bool, bool, bool] = (True, True, True)
    facts: dict = field(default_factory=dict)
    even: bool = True
    turned: np.ndarray | None = None

    def __post_init__(self):
        identifier("trial name", self.name)
        for label, choices in LABELS.items():
            one_of(f"trial {self.name!r}: {label}", getattr(self, label), choices)
        measured = tuple(map(bool, self.measured))
        if len(measured) != 3 or not any(measured):
            raise ValueError(
                f"trial {self.name!r}: measured must be three flags, at least one of them set"
            )
        arrays = {
            n: np.array(getattr(self, n), float, order="C") for n in ("time", "rate", "torque")
        }
        n = arrays["time"].shape[:1]
        for name, shape in {"time": n, "rate": (*n, 3), "torque": (*n, 3)}.items():
            if arrays[name].shape != shape:
                raise ValueError(
                    f"trial {self.name!r}: {name} has shape {arrays[name].shape}, expected {shape}"
                )
        arrays["torque"][:, ~np.array(measured)] = 0.0
        columns = {
            f"{q}_{a}": arrays[q][:, i] for q in ("rate", "torque") for i, a in enumerate(AXES)
        }
        check(self.name, {"time": arrays["time"], **columns}, even=self.even)
        for name, values in {**arrays, "measured": measured}.items():
            object.__setattr__(self, name, values)

    def with_torque(self, torque: np.ndarray) -> "Trial":
        """The same motion with another torque (n, 3) [N m]."""
        return replace(self, torque=torque)

    @property
    def angle(self) -> np.ndarray:
        """Angles turned about the axes since the start (n, 3) [rad], measured or by the
        trapezoidal rule.
        """
        rate = self.rate_between
        if rate is None:
            rate = self._mean_rate
        middle = np.diff(self.time)[:, None] * rate[1:]
        return np.concatenate([np.zeros((1, 3)), np.cumsum(middle, axis=0)])

    @property
    def _mean_rate(self) -> np.ndarray:
        """Means of neighbouring rates (n, 3); the first is that of its sample."""
        return np.concatenate([self.rate[:1], 0.5 * (self.rate[1:] + self.rate[:-1])])

    @property
    def rate_between(self) -> np.ndarray | None:
        """Mean rates since the samples before (n, 3) [rad/s], by measured angles; None where no
        angle was measured. The first is that of its sample.
        """
        if self.turned is None:
            return None
        mean = self._mean_rate
        mean[1:] = np.where(
            np.isfinite(self.turned[1:]),
            np.diff(self.turned, axis=0) / np.diff(self.time)[:, None],
            mean[1:],
        )
        return mean


@dataclass(frozen=True, eq=False)
class Series(Sampled):
    """Columns of any quantities over time, such as the path of a journal, for models of one's own.

    time: (n,) [s], even steps; columns: (n,) each, by name; units: of the columns, SI; facts as of
        a `Trial`. `series["x"]` is a column.
    Raises ValueError for shapes, roles and samples that cannot be, naming row and column.
    """

    name: str
    role: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    facts: dict = field(default_factory=dict)

    def __post_init__(self):
        identifier("trial name", self.name)
        one_of(f"trial {self.name!r}: role", self.role, LABELS["role"])
        time = np.array(self.time, float)
        columns = {n: np.array(v, float) for n, v in self.columns.items()}
        for name, values in columns.items():
            if values.shape != time.shape:
                reason = f"{name} has shape {values.shape}, expected {time.shape}"
                raise ValueError(f"trial {self.name!r}: {reason}")
        check(self.name, {"time": time, **columns})
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "columns", columns)

    def __getitem__(self, column: str) -> np.ndarray:
        return self.columns[column]


@dataclass(frozen=True, eq=False)
class Measurement:
    """Trials of different names, and facts of them all; a preload [N] of them all is one of each
    trial.

    Raises ValueError for none, and for a name that comes twice.
    """

    trials: tuple[Trial | Series, ...]
    facts: dict = field(default_factory=dict)

    def __post_init__(self):
        preload = self.facts.get("preload")
        missing = {} if preload is None or np.ndim(preload) else {"preload": preload}
        trials = (
            replace(t, facts=t.facts | missing) if missing.keys() - t.facts.keys() else t
            for t in self.trials
        )
        object.__setattr__(self, "trials", tuple(trials))
        if not self.trials:
            raise ValueError("the measurement has no trials")
        distinct("names of trials", [t.name for t in self.trials])

    def of(self, *roles: str) -> "Measurement":
        """The trials of these roles. Raises ValueError for one that no trial has."""
        there = dict.fromkeys(t.role for t in self.trials)
        for role in roles or ("none",):
            known("no trial has a role of", role, there)
        return Measurement(tuple(t for t in self.trials if t.role in roles), self.facts)

    def with_predicted(self, others: "Measurement") -> "Measurement":
        """This measurement and trials of another one that are extrapolated."""
        trials = (replace(t, role="extrapolation") for t in others.trials)
        return Measurement((*self.trials, *trials), self.facts)

    def named(self, name: str) -> Trial:
        """A trial by its name. Raises KeyError for an unknown one."""
        for trial in self.trials:
            if trial.name == name:
                return trial
        raise KeyError(f"no trial {name!r}; there are {', '.join(t.name for t in self.trials)}")

    @property
    def roles(self) -> tuple[str, ...]:
        """The roles that trials have, in the order of `LABELS`."""
        return tuple(r for r in LABELS["role"] if any(t.role == r for t in self.trials))

    @property
    def samples(self) -> int:
        """Number of samples of all trials."""
        return sum(t.samples for t in self.trials)


# --- checks
def check(
    trial: str, columns: dict[str, np.ndarray], row: Where = "row {}".format, even: bool = True
) -> None:
    """Raises ValueError for columns (n,) of a trial that are too short, not finite, or whose time
    is uneven; where it may be, for gaps of GAP steps.

    row: place of sample i; rows count from 0.
    """
    time = columns["time"]
    if len(time) < FEWEST:
        raise ValueError(f"trial {trial!r} has {len(time)} samples; at least {FEWEST} are needed")
    for name, values in columns.items():
        if (bad := ~np.isfinite(values)).any():
            i = int(bad.argmax())
            raise ValueError(
                f"trial {trial!r}, {row(i)}, column {name}: {values[i]} is not a finite number"
            )
    steps = np.diff(time)
    step = float(np.median(steps))
    if (bad := steps <= 0.0).any():
        i = int(bad.argmax()) + 1
        raise ValueError(
            f"trial {trial!r}, {row(i)}, column time: {time[i]:.9g} s does not come after "
            f"{time[i - 1]:.9g} s"
        )
    if (bad := abs(steps - step) > (UNEVEN if even else GAP) * step).any():
        i = int(bad.argmax()) + 1
        raise ValueError(
            f"trial {trial!r}, {row(i)}, column time: {steps[i - 1]:.6g} s after the row before, "
            f"others {step:.6g} s; "
            f"{'time must go in even steps' if even else 'cut the record there'}"
        )


def check_units(measurement: Measurement, rows: Mapping[str, Where] | None = None) -> None:
    """Raises ValueError for numbers no test of a ball joint gives, which other units than SI would
    explain.

    Suspicious are a time step over 0.05 s (ms) and rates over 50 rad/s. Further, angles of over
    half a turn of tilt or a turn of spin from end to end (degrees). Further, a largest torque over
    200 N m (N mm) or under 0.001 N m (kN m). Last, a torque that never changes about an axis that
    turns (a dead sensor). Small motions
    in degrees pass: they look like large ones in radians. rows: places of samples by trial.
    """

    def row(trial: Trial, i: int) -> str:
        return (rows or {}).get(trial.name, "row {}".format)(int(i))

    for trial in measurement.trials:
        prefix = f"trial {trial.name!r}"
        if trial.step > LONGEST_STEP:
            raise ValueError(
                f"{prefix}, column time: steps of {trial.step:g} s; is it in ms? "
                f"{CALL.format('time_ms', 'ms')}"
            )
        for i, axis in enumerate(AXES):
            rate, angle = abs(trial.rate[:, i]), trial.angle[:, i]
            hint = f"is it in degrees? {CALL.format(f'rate_{axis}_deg_s', 'deg/s')}"
            if rate.max() > HIGHEST_RATE:
                where = f"{prefix}, {row(trial, rate.argmax())}, column rate_{axis}"
                raise ValueError(
                    f"{where}: {rate.max():g} rad/s is more than {HIGHEST_RATE:g} rad/s; "
                    f"{hint}{TRUST}"
                )
            widest = WIDEST_SPIN if axis == "z" else WIDEST_TILT
            if (swept := float(np.ptp(angle))) > widest:
                where = f"{prefix}, {row(trial, angle.argmax())}, column rate_{axis}"
                raise ValueError(
                    f"{where}: it turns through {swept:.4g} rad, more than {widest:.4g} rad; "
                    f"{hint}{TRUST}"
                )
            if trial.measured[i] and rate.any():
                check_varies(f"{prefix}, column torque_{axis}", trial.torque[:, i], "N m")
    peaks = [abs(t.torque).max() for t in measurement.trials]
    trial, peak = measurement.trials[int(np.argmax(peaks))], max(peaks)
    if not TORQUES[0] <= peak <= TORQUES[1]:
        i, k = np.unravel_index(abs(trial.torque).argmax(), trial.torque.shape)
        where = f"trial {trial.name!r}, {row(trial, i)}, column torque_{AXES[k]}"
        units = "N mm" if peak > TORQUES[1] else "kN m"
        hint = f"in {units}? {CALL.format(f'torque_{AXES[k]}_{units}'.replace(' ', '_'), units)}"
        raise ValueError(
            f"{where}: no ball joint has a largest torque of {peak:g} N m; is it {hint}"
        )
