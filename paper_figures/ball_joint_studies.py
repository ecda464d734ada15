"""Studies of ball-joint friction models on the synthetic bench, after Pfitzer et al., Lubricants 13
(2025) 436.

Fit and prediction of the four models. Their predictions beyond their data, against the bench's
joint itself. The effect of a fixed step in a simulation. The course of the estimation, the recovery
of known parameters, and the cost of a step.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from clearance.paper_figures import ball_joint_variants as variants
from clearance.paper_figures.ball_joint_bench import Joint, bench, sine

from clearance.identify import learn, models
from clearance.identify.estimation import STARTS
from clearance.identify.fit import Fit, fit, nrmse
from clearance.identify.records import Measurement, Trial
from clearance.machine.store import njit

#: what the source prints: NRMSE of training and test
SOURCE = {
    "lugre3d": (0.1288, 0.2596),
    "lugre1d": (0.1281, 0.2595),
    "curve": (0.2711, 0.3021),
    "lstm": (0.0482, 0.1887),
}
STEP = 1e-3  # s, of the source's simulator
INERTIA = 0.01  # kg m2, of a link about its ball joint: 2 kg at 7 cm
LOAD = (1.0, 0.0, 1.0)  # N m about the axes, less than breaks the joint away: it has to stick
STEPS = tuple(1e-3 * 2.0 ** (k / 2.0) for k in range(-14, 7))  # s
# disturbance [rad/s], where it counts as grown, and as gone
SMALL, LARGE, GONE = 1e-9, 1e-5, 1e-100
FOLLOWED = 0.4  # s, how long it is followed at most
# scatter of runs and seeds of the bench, on which fast spin is looked at
DRAWS = (0.16, range(10)), (0.0, range(3))
TIMED, REPEATS = 200_000, 5  # steps of a timing, of which the fastest repeat counts

Fits = Mapping[str, Fit]


# --- fits and their errors
def fitted(
    measurement: Measurement,
    names: Sequence[str] = tuple(SOURCE),
    *,
    seed: int = 0,
    starts: int = STARTS,
    progress: Callable[[str], None] = lambda text: None,
) -> dict[str, Fit]:
    """Fits of models by name, from the trials for training; the lstm is left out where the extra
    `learn` is missing.

    progress: called with a sentence on each. Raises ValueError as `fit` does.
    """
    fits = {}
    for name in names:
        if name == "lstm" and (reason := learn.missing()):
            progress(f"lstm left out: {reason}")
            continue
        fits[name] = fit(measurement, name, seed=seed, starts=starts)
        progress(f"{name} fitted in {fits[name].facts['seconds']:.1f} s")
    return fits


@dataclass(frozen=True)
class Error:
    """NRMSE of a model: rms error over rms torque, all trials of a role and measured axes together.
    Also that of the source, and the same over the standard deviation and the range of the torque.
    """

    model: str
    training: float
    test: float
    source_training: float
    source_test: float
    training_over_std: float
    test_over_std: float
    training_over_range: float
    test_over_range: float


def errors(fits: Fits, measurement: Measurement) -> list[Error]:
    """Errors of each fit in training and test.

    Raises ValueError where trials of one of these roles are missing.
    """
    roles = [measurement.of(role).trials for role in ("training", "test")]
    scores = {
        n: [f.score(t, over) for over in ("rms", "std", "range") for t in roles]
        for n, f in fits.items()
    }
    return [
        Error(n, *s[:2], *SOURCE.get(n, (math.nan, math.nan)), *s[2:]) for n, s in scores.items()
    ]


# --- beyond the data
@dataclass(frozen=True, eq=False)
class Extrapolation:
    """Predictions of models for a motion that they were not fitted to.

    trial: motion and torque of the bench's joint, without noise or scatter; group: "fast", "small"
        or "mixed"; torque: of the models (n, 3) [N m]; nrmse against the truth; peak: largest
        torque over the true one; energy: dissipated, over the true one; asymmetry: rms of
        torque(w) + torque(-w) over that of torque(w), also of "truth".
    """

    trial: Trial
    group: str
    torque: dict[str, np.ndarray]
    nrmse: dict[str, float]
    peak: dict[str, float]
    energy: dict[str, float]
    asymmetry: dict[str, float]


GROUPS = {"triangle": "fast", "sine": "small", "mixed": "mixed"}
#: further small motions: amplitude [deg] and frequency [Hz] of sines, s
TINY, TINY_LONG = ((0.05, 20.0), (0.02, 40.0)), 0.5


def extrapolations(fits: Fits, joint: Joint | None = None) -> list[Extrapolation]:
    """The models in the bench's motions for extrapolation, and smaller ones, against the joint that
    the bench holds.
    """
    joint = joint or Joint()
    trials = [*bench(scatter=0.0, noise=0.0, joint=joint).of("extrapolation").trials]
    trials += [_tiny(joint, *motion) for motion in TINY]
    return [_extrapolation(fits, joint, trial) for trial in trials]


def _tiny(joint: Joint, amplitude: float, frequency: float) -> Trial:
    """A sine of spin at 10 kHz, without noise."""
    step = 0.1 * STEP
    time = step * np.arange(round(TINY_LONG / step))
    rate, amplitude = np.zeros((len(time), 3)), math.radians(amplitude)
    rate[:, 2] = sine(time, amplitude, frequency, 1)
    facts = {"amplitude": amplitude, "frequency": frequency}
    trial = Trial(
        f"sine_{frequency:g}",
        "sine",
        "spin",
        "extrapolation",
        time,
        rate,
        rate,
        (False, False, True),
        facts,
    )
    return replace(trial, torque=joint.torques(trial.rate, trial.angle, step))


def _extrapolation(fits: Fits, joint: Joint, trial: Trial) -> Extrapolation:
    axes = np.flatnonzero(trial.measured)
    true, torque = trial.torque[:, axes], {n: f.torque(trial) for n, f in fits.items()}
    modelled = {n: t[:, axes] for n, t in torque.items()}
    work = float(np.sum(trial.torque * trial.rate))
    asymmetry = {n: asymmetry_of(f.torque, trial) for n, f in fits.items()}
    asymmetry["truth"] = asymmetry_of(lambda t: joint.torques(t.rate, t.angle, t.step), trial)
    return Extrapolation(
        trial=trial,
        group=GROUPS.get(trial.kind, "mixed"),
        torque=torque,
        nrmse={n: nrmse(true, m) for n, m in modelled.items()},
        peak={n: float(abs(m).max() / abs(true).max()) for n, m in modelled.items()},
        energy={n: float(np.sum(m * trial.rate[:, axes])) / work for n, m in modelled.items()},
        asymmetry=asymmetry,
    )


def asymmetry_of(torque: Callable[[Trial], np.ndarray], trial: Trial) -> float:
    """Difference between the torque of the mirrored motion and the mirrored torque: 0 for an odd
    model.
    """
    mirrored = replace(trial, rate=-trial.rate)
    axes = np.flatnonzero(trial.measured)
    one, other = torque(trial)[:, axes], torque(mirrored)[:, axes]
    size = float(np.sqrt(np.mean(one**2)))
    return float(np.sqrt(np.mean((one + other) ** 2))) / size if size else 0.0


# --- in a simulation of fixed step
@dataclass(frozen=True, eq=False)
class FixedStep:
    """A body on a ball joint, moved by explicit steps: the torque at the rate before a step changes
    the rate.

    Under a preload below break-away the joint has to come to rest. steps (k,) [s]; chatter (k,):
    rms rate over the last half [rad/s]. growth (k,): factor a step by which a small disturbance of
    the unloaded joint grows; stable: largest step up to which it does not grow [s] (0 where it
    always does); bound: what linear analysis gives for it [s], nan where there is none; time (n,),
    rate (n, 3): under the preload, at 1 ms.
    """

    model: str
    steps: np.ndarray
    chatter: np.ndarray
    growth: np.ndarray
    stable: float
    bound: float
    time: np.ndarray
    rate: np.ndarray


@njit(error_model="numpy")
def free(function, layout, values, state, load, inertia, dt, rate):
    """Rates (n, 3) after each step, from the one in rate[0]."""
    torque = np.empty(3)
    for n in range(rate.shape[0] - 1):
        function(layout, values, state, rate[n], dt, torque)
        for i in range(3):
            rate[n + 1, i] = rate[n, i] + dt / inertia * (load[i] - torque[i])


def _free(
    model: models.Model, values, load, start, dt: float, count: int, inertia: float
) -> np.ndarray:
    rate = np.zeros((count, 3))
    rate[0] = start
    free(model.compiled, model.layout, model.packed(values), model.start(), load, inertia, dt, rate)
    return rate


def fixed_steps(
    fits: Fits,
    steps: Sequence[float] = STEPS,
    *,
    inertia: float = INERTIA,
    load: Sequence[float] = LOAD,
    until: float = 1.0,
) -> list[FixedStep]:
    """Every fit in simulations of fixed steps [s] until a time [s]; inertia [kg m2] about an axis,
    load (3,) [N m].
    """
    return [
        _fixed_step(f.model, f.values, np.array(steps), inertia, np.array(load), until)
        for f in fits.values()
    ]


def _fixed_step(
    model: models.Model, values, steps: np.ndarray, inertia: float, load, until: float
) -> FixedStep:
    none, nudge = np.zeros(3), np.array([0.0, 0.0, SMALL])
    loaded = [_free(model, values, load, none, dt, int(until / dt), inertia) for dt in steps]
    nudged, still = (
        [_free(model, values, none, w, dt, int(FOLLOWED / dt), inertia)[:, 2] for dt in steps]
        for w in (nudge, none)
    )
    growth = np.array([_growth(a - b) for a, b in zip(nudged, still, strict=True)])
    grown = np.flatnonzero(growth > 1.0)
    stable = steps[: grown[0]] if grown.size else steps
    shown = _free(model, values, load, none, STEP, int(until / STEP), inertia)
    return FixedStep(
        model=model.name,
        steps=steps,
        chatter=np.array([np.sqrt(np.mean(r[len(r) // 2 :] ** 2)) for r in loaded]),
        growth=growth,
        stable=float(stable[-1]) if stable.size else 0.0,
        bound=stability_bound(model, values, inertia),
        time=STEP * np.arange(len(shown)),
        rate=shown,
    )


def _growth(disturbance: np.ndarray) -> float:
    """Factor a step of a disturbance that starts at `SMALL`, until it is large or gone or was
    followed long enough.
    """
    size = abs(disturbance)
    n = int(np.argmax((size > LARGE) | (size < GONE))) or len(size) - 1
    return float(size[max(n - 10, 1) : n + 1].max() / SMALL) ** (1.0 / n)


def stability_bound(model: models.Model, values, inertia: float) -> float:
    """Largest stable step [s] about the spin axis at rest. For a curve it is 2 J over the slope.
    For bristles it is the positive root of dt^2 sigma0 + 2 dt (sigma1 + sigma2) = 4 J, where the
    step's matrix has the eigenvalue -1; else nan.
    """
    if isinstance(model, models.Curve):
        first = model.knots[0]
        torque = model.step(values, model.start(), np.array([0.0, 0.0, first]), 0.0)[2]
        return 2.0 * inertia * first / float(torque) if torque > 0.0 else 0.0
    if not isinstance(model, models.LuGre) or model.static:
        return math.nan
    _, stiffness, damping, viscous = model.functions(values, np.zeros(1))[2, :, 0]
    drag = damping + viscous
    return (math.sqrt(drag * drag + 4.0 * inertia * stiffness) - drag) / stiffness


# --- how the estimation goes
@dataclass(frozen=True, eq=False)
class Progress:
    """rms error over rms torque of the training after each iteration (epoch) of the fit. The end of
    each start, with its passes over the samples. The same error of held-out windows, where there
    are some.
    """

    model: str
    error: np.ndarray
    ends: np.ndarray
    passes: np.ndarray
    held_out: np.ndarray


def progress(fits: Fits, measurement: Measurement) -> list[Progress]:
    """Costs of each fit over its iterations; the samples are those of the trials for training."""
    trials = measurement.of("training").trials
    squares = sum(float(np.sum(t.torque[:, np.array(t.measured)] ** 2)) for t in trials)
    return [_progress(f, squares) for f in fits.values()]


def _progress(result: Fit, squares: float) -> Progress:
    squares = result.facts.get("squares", squares)  # a network is not trained on all windows
    error, ends = (
        np.sqrt(2.0 * np.asarray(c, float) / squares)
        for c in (result.history, result.starts["cost"])
    )
    held_out = np.array(result.facts.get("held_out_nrmse", ()))
    return Progress(
        result.model.name, error, ends, np.asarray(result.starts["evaluations"]), held_out
    )


# --- known parameters
@dataclass(frozen=True, eq=False)
class Recovery:
    """Parameters that made the data (p,), and the fitted ones for several draws of the noise
    (draws, p).

    roles: of the bench's trials that the fits saw.
    """

    model: str
    roles: tuple[str, ...]
    names: tuple[str, ...]
    true: np.ndarray
    fits: np.ndarray

    @property
    def errors(self) -> np.ndarray:
        """Relative errors (draws, p)."""
        return self.fits / self.true - 1.0


#: trials that parameters are recovered from: those that the fits of the studies see, and all of one
#: axis
SEEN = ("training",), ("training", "test", "other")
#: a joint in the class of the LuGre models, by parts of the parameters' names
KNOWN = {
    "kinetic": 2.0,
    "static": 2.7,
    "stribeck_speed": 0.06,
    "stiffness": 1200.0,
    "damping": 1.5,
    "viscous": 0.2,
}


def recovery(
    model: str = "lugre3d",
    *,
    roles: Sequence[str] = ("training",),
    noise: float = 0.02,
    seeds: Sequence[int] = range(5),
    starts: int = 3,
) -> Recovery:
    """Fit a model to torques of its own with noise [N m], in the motions of the bench's trials of
    these roles.

    The true values are those of `KNOWN`, about the spin axis 0.8 times as large.
    """
    built = models.model(model)
    parts = [p.name.split("_", 1) for p in built.parameters]
    true = np.array([(0.8 if group == "spin" else 1.0) * KNOWN[part] for group, part in parts])
    motions = bench(scatter=0.0, noise=0.0).of(*roles).trials
    rows = []
    for seed in seeds:
        random = np.random.default_rng(seed)
        trials = [_imitated(built, true, trial, noise, random) for trial in motions]
        values = fit(Measurement(tuple(trials)), built, starts=starts, seed=seed).values
        rows.append([values[p.name] for p in built.parameters])
    return Recovery(
        built.name, tuple(roles), tuple(p.name for p in built.parameters), true, np.array(rows)
    )


def _imitated(model: models.Model, values, trial: Trial, noise: float, random) -> Trial:
    """A trial for training with the model's torque."""
    torque = model.torque(values, trial) + noise * random.standard_normal((trial.samples, 3))
    return Trial(
        trial.name,
        trial.kind,
        trial.axis,
        "training",
        trial.time,
        trial.rate,
        torque,
        trial.measured,
    )


# --- what a step costs
@dataclass(frozen=True)
class Speed:
    """Seconds that a step of 1 ms takes, in compiled code and from Python, and how much faster than
    time that is.
    """

    model: str
    compiled: float
    python: float

    @property
    def factor(self) -> float:
        """Real-time factor in compiled code."""
        return STEP / self.compiled

    @property
    def python_factor(self) -> float:
        """Real-time factor of one call of `step` from Python a step."""
        return STEP / self.python


@njit(error_model="numpy")
def driven(function, layout, values, state, rate, dt, torque):
    for n in range(rate.shape[0]):
        function(layout, values, state, rate[n], dt, torque)


def speeds(fits: Fits, *, count: int = TIMED, repeats: int = REPEATS) -> list[Speed]:
    """Cost of each fit's step of 1 ms under motion about all axes; the fastest of the repeats."""
    phase = 2.0 * math.pi * STEP * np.arange(count)[:, None] * np.array([1.0, 1.25, 1.5])
    rate = np.ascontiguousarray(np.sin(phase))
    return [_speed(f.model, f.values, rate, repeats) for f in fits.values()]


def _speed(model: models.Model, values, rate: np.ndarray, repeats: int) -> Speed:
    array, torque = model.array(values), np.empty(3)
    packed, few = model.packed(array), rate[: max(len(rate) // 100, 1)]

    def compiled():
        driven(model.compiled, model.layout, packed, model.start(), rate, STEP, torque)

    def python():
        state = model.start()
        for row in few:
            model.step(array, state, row, STEP)

    compiled()
    return Speed(
        model.name, _fastest(compiled, repeats) / len(rate), _fastest(python, repeats) / len(few)
    )


def _fastest(call: Callable[[], None], repeats: int) -> float:
    def took() -> float:
        began = time.perf_counter()
        call()
        return time.perf_counter() - began

    return min(took() for _ in range(repeats))


# --- all of it
@dataclass(frozen=True, eq=False)
class Study:
    """Everything above for one seed of the bench; left_out: sentences on what is missing."""

    fits: dict[str, Fit]
    errors: list[Error]
    extrapolations: list[Extrapolation]
    fixed_steps: list[FixedStep]
    progress: list[Progress]
    recoveries: list[Recovery]
    speeds: list[Speed]
    spins: list[variants.Spin]
    left_out: list[str]


def study(
    seed: int = 0,
    names: Sequence[str] = tuple(SOURCE),
    progress_of: Callable[[str], None] = lambda text: None,
) -> Study:
    """All studies of these models on the bench of this seed. progress_of: called with a sentence on
    each part.
    """
    measurement = bench(seed)
    fits = fitted(measurement, names, seed=seed, progress=progress_of)
    fitted_ones = [n for n in ("lugre1d", "lugre3d") if n in fits]
    return Study(
        fits=fits,
        errors=errors(fits, measurement),
        extrapolations=extrapolations(fits),
        fixed_steps=fixed_steps(fits),
        progress=progress(fits, measurement),
        recoveries=[recovery(n, roles=roles) for n in fitted_ones for roles in SEEN],
        speeds=speeds(fits),
        spins=[variants.fast_spin(*draws) for draws in DRAWS],
        left_out=[f"{n}: {learn.missing()}" for n in names if n not in fits],
    )


def tables(result: Study) -> list[str]:
    """The numbers of a study as lines of Markdown."""
    parts = (
        _error_table,
        _extrapolation_table,
        _spin_table,
        _fixed_step_table,
        _recovery_table,
        _speed_table,
    )
    lines = [line for part in parts for line in (*part(result), "")][:-1]
    return [*lines, *(f"\nLeft out: {text}." for text in result.left_out)]


def _error_table(result: Study) -> list[str]:
    lines = [
        "| NRMSE | training | source | test | source | training, test over std | over range | "
        "fitted in |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for e in result.errors:
        lines.append(
            f"| {e.model} | {e.training:.4f} | {e.source_training:.4f} | {e.test:.4f} | "
            f"{e.source_test:.4f} "
            f"| {e.training_over_std:.3f}, {e.test_over_std:.3f} "
            f"| {e.training_over_range:.3f}, {e.test_over_range:.3f} "
            f"| {result.fits[e.model].facts['seconds']:.1f} s |"
        )
    return lines


def _extrapolation_table(result: Study) -> list[str]:
    names = list(result.fits)
    heads = [
        "beyond the training data: NRMSE, largest torque / true",
        *names,
        "asymmetry: truth, lstm",
    ]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for e in result.extrapolations:
        cells = [f"{e.nrmse[n]:.2f}, {e.peak[n]:.2f}" for n in names]
        odd = f"{e.asymmetry['truth']:.2f}, " + (
            f"{e.asymmetry['lstm']:.2f}" if "lstm" in names else "-"
        )
        lines.append(f"| {described(e.trial)} | " + " | ".join(cells) + f" | {odd} |")
    return lines


def _spin_table(result: Study) -> list[str]:
    return variants.spin_table(result.spins)


def described(trial: Trial) -> str:
    """A trial of the bench in words."""
    facts, how = trial.facts, {"speed": "deg/s", "frequency": "Hz"}
    amplitude = facts.get("amplitude")
    paces = [
        f"{math.degrees(facts[n]) if n == 'speed' else facts[n]:g} {u}"
        for n, u in how.items()
        if n in facts
    ]
    if amplitude is None or not np.isscalar(amplitude) or not paces:
        return trial.name.partition("_")[2].replace("_", ", ", 1).replace("_", " ")
    return f"{trial.axis}, {trial.kind}, {math.degrees(amplitude):.2g} deg, {paces[0]}"


def _fixed_step_table(result: Study) -> list[str]:
    lines = [
        f"| explicit steps, {INERTIA:g} kg m2 | growth a step at 1 ms | rate left at 1 ms under "
        f"{LOAD[0]:g} N m "
        "| largest stable step | linear analysis |",
        "|---|---|---|---|---|",
    ]
    for f in result.fixed_steps:
        i = int(np.argmin(abs(f.steps - STEP)))
        bound = "-" if math.isnan(f.bound) else f"{1e3 * f.bound:.3g} ms"
        stable = f"{1e3 * f.stable:.3g} ms" if f.stable else "none of these"
        lines.append(
            f"| {f.model} | {f.growth[i]:.3g} | {f.chatter[i]:.1e} rad/s | {stable} | {bound} |"
        )
    return lines


def _recovery_table(result: Study) -> list[str]:
    lines = [
        "| known parameters, 0.02 N m noise | trials fitted | draws | largest error | parameter | "
        "of the others |",
        "|---|---|---|---|---|---|",
    ]
    for r in result.recoveries:
        worst = 100.0 * abs(r.errors).max(axis=0)
        name = r.names[int(worst.argmax())]
        others = max(
            w
            for n, w in zip(r.names, worst, strict=True)
            if n.split("_", 1)[1] != name.split("_", 1)[1]
        )
        lines.append(
            f"| {r.model} | {', '.join(r.roles)} | {len(r.fits)} | {worst.max():.1f} % | {name} | "
            f"{others:.1f} % |"
        )
    return lines


def _speed_table(result: Study) -> list[str]:
    lines = [
        "| a step of 1 ms | compiled | real-time factor | from Python | real-time factor |",
        "|---|---|---|---|---|",
    ]
    for s in result.speeds:
        python = f"{1e6 * s.python:.1f} us | {s.python_factor:.0f}"
        lines.append(f"| {s.model} | {1e9 * s.compiled:.0f} ns | {s.factor:.0f} | {python} |")
    return lines
