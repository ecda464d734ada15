"""A recurrent network as a model of ball-joint friction: one LSTM layer and a linear read-out, no
physics.

It has an interval of its own, 4 ms. Its inputs are the means of the three rates over the interval,
compressed by asinh(w / softness), which resolves creeping and fast motion. Its outputs are the
three torques at the interval's end, which are held until the next one. With the inputs x, the
outputs h and the cells c of the units

    i, f, g, o = W x + U h + b,   c <- sig(f) c + sig(i) tanh(g),   h <- sig(o) tanh(c),
    torque = R h + r.

Training: Adam on windows of the trials, in single precision. A window begins in the state to which
the network of the last epoch comes along its trial. Intervals that do not count lead it in. JAX,
equinox and optax do it, which the extra `learn` installs and which are imported only here and only
to train. Trained networks run without them, in double precision.

It is trained on the rates of its data only. Beyond them its torque may be anything, also energy
that friction cannot give.
"""

import importlib.util
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from clearance.identify import models
from clearance.identify.estimation import Estimate
from clearance.identify.models import AXES, Model, Parameter, Values
from clearance.machine.store import njit
from clearance.values.checks import finite, positive, whole

GATES = 4  # input, forget, candidate, output
# state: time [s] and angles [rad] since the last interval; torque; h and c
SINCE, TURNED, HELD, UNITS = 0, 1, 4, 7
PASSES = 3  # over the windows in an epoch, which begins with a run along complete trials
CLIP = 1.0  # largest norm of a step's gradient
RATE_LEFT = 0.01  # learning rate at the last epoch, over that at the first
PACKAGES = "jax", "equinox", "optax"


def missing() -> str:
    """Packages that the training of an lstm lacks here, and their installation; empty where none is
    missing.
    """
    absent = [p for p in PACKAGES if importlib.util.find_spec(p) is None]
    return (
        f"training the lstm needs {', '.join(absent)}; install clearance[learn]" if absent else ""
    )


class Layout(NamedTuple):
    """Numbers of compiled code beside the weights: interval [s], softness [rad/s], number of
    units.
    """

    interval: float
    softness: float
    hidden: int


@njit(cache=True, error_model="numpy")
def sigmoid(x):
    return 0.5 + 0.5 * np.tanh(0.5 * x)


@njit(cache=True, error_model="numpy")
def advance(layout, weights, state, rate):
    """One interval of constant rate (3,): moves h and c in `state` and the torque that it holds."""
    n, h, c = layout.hidden, state[UNITS : UNITS + layout.hidden], state[UNITS + layout.hidden :]
    seen = np.concatenate((np.arcsinh(rate / layout.softness), h, np.ones(1)))
    count = seen.size * GATES * n
    gates = seen @ weights[:count].reshape(seen.size, GATES * n)
    c[:] = sigmoid(gates[n : 2 * n]) * c + sigmoid(gates[:n]) * np.tanh(gates[2 * n : 3 * n])
    h[:] = sigmoid(gates[3 * n :]) * np.tanh(c)
    state[HELD:UNITS] = weights[count:-3].reshape(3, n) @ h + weights[-3:]


@njit(cache=True, error_model="numpy")
def step(layout, weights, state, rate, dt, torque):
    """One step [s] of constant rate (3,): moves the state, writes the torque (3,) [N m] that the
    last interval gave.
    """
    remaining, turned = dt, state[TURNED:HELD]
    while state[SINCE] + remaining >= layout.interval * (1.0 - 1e-9):
        part = layout.interval - state[SINCE]
        advance(layout, weights, state, (turned + rate * part) / layout.interval)
        turned[:], state[SINCE] = 0.0, 0.0
        remaining = max(remaining - part, 0.0)
    state[SINCE] += remaining
    turned += rate * remaining
    torque[:] = state[HELD:UNITS]


@njit(cache=True, error_model="numpy")
def torques(layout, weights, rate, dt, state, torque):
    """Torque (n, 3) [N m] at samples of the rate (n, 3), a step apart, between which it sees their
    mean.
    """
    for n in range(1, len(rate)):
        step(layout, weights, state, 0.5 * (rate[n - 1] + rate[n]), dt, torque[n])


@dataclass(frozen=True)
class LSTM(Model):
    """A recurrent network; see the module. Its parameters are its weights, for torques in N m.

    hidden: units. interval [s]: between its steps. softness [rad/s]: rate around which inputs go
        over from linear to logarithmic. An axis that no trial measured gets no torque.

    Training: window, the samples of a window that count, and lead, those before them, in intervals.
    batch: windows a step; held_out: share of the windows that is not trained on. epochs: at most,
    of three passes over the others each; rate: of Adam at first; patience: epochs without a better
    score of the held-out windows before it ends.
    """

    hidden: int = 16
    interval: float = 4e-3
    softness: float = 0.05
    window: int = 250
    lead: int = 125
    batch: int = 8
    held_out: float = 0.15
    epochs: int = 200
    patience: int = 50
    rate: float = 0.01

    name: ClassVar[str] = "lstm"
    compiled = staticmethod(step)

    def __post_init__(self):
        for name in ("hidden", "window", "lead", "batch", "epochs", "patience"):
            whole(f"{name} of the lstm", getattr(self, name), 0 if name == "lead" else 1)
        for name in ("interval", "softness", "rate"):
            positive(f"{name} of the lstm", getattr(self, name))
        if not 0.0 < finite("held_out of the lstm", self.held_out) <= 0.5:
            raise ValueError(f"held_out of the lstm must lie in (0, 0.5], got {self.held_out!r}")

    @cached_property
    def layout(self) -> Layout:
        """Places of the numbers in the values of the kernels."""
        return Layout(float(self.interval), float(self.softness), self.hidden)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Fitted parameters, in the order of their vector."""
        gates = [f"{g}{n}" for g in ("in", "forget", "cell", "out") for n in range(self.hidden)]
        sources = [*(f"rate_{a}" for a in AXES), *(f"unit{n}" for n in range(self.hidden)), "one"]
        names = [f"{g}_from_{s}" for s in sources for g in gates]
        names += [f"torque_{a}_from_unit{n}" for a in AXES for n in range(self.hidden)]
        names += [f"torque_{a}_from_one" for a in AXES]
        return tuple(
            Parameter(n, "N m" if n.startswith("torque") else "1", -math.inf, math.inf, 0.0)
            for n in names
        )

    @cached_property
    def _names(self) -> list[str]:
        return [p.name for p in self.parameters]

    def array(self, values: Values) -> np.ndarray:
        """Weights in the order of the parameters (p,).

        Raises ValueError for other names, numbers of them or values.
        """
        if isinstance(values, Mapping):
            if values.keys() != set(self._names):
                raise ValueError(
                    f"values: not the {len(self._names)} weights of an lstm of {self.hidden} units"
                )
            values = [values[n] for n in self._names]
        values = np.asarray(values, float)
        if values.shape != (len(self._names),) or not np.isfinite(values).all():
            raise ValueError(
                f"values: an lstm of {self.hidden} units has {len(self._names)} finite weights"
            )
        return values

    def start(self) -> np.ndarray:
        """State at rest: time and angles since the last interval, torque, outputs and cells of the
        units.
        """
        return np.zeros(UNITS + 2 * self.hidden)

    def torque(self, values: Values, trial) -> np.ndarray:
        """Torque (n, 3) [N m] of a trial from the start state."""
        torque = np.zeros((trial.samples, 3))
        torques(self.layout, self.packed(values), trial.rate, trial.step, self.start(), torque)
        return torque

    def passive_rate(self, values: Values) -> float:
        """Zero [rad/s]: nothing keeps a network from giving energy."""
        return 0.0

    def doubts(self, values: Values, fastest: float) -> list[str]:
        """Warnings about the weights."""
        return [
            f"lstm: valid only for motions as in its training, up to {fastest:.3g} rad/s; "
            f"not passive"
        ]

    def estimate(
        self,
        trials: Sequence,
        starts: int = 1,
        seed: int = 0,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Estimate:
        """Train the weights on trials, once: starts is not used.

        The same weights for the same seed on one machine.

        Raises ValueError where the extra `learn` is missing, or trials give too few windows, no
        motion or no torque.
        """
        windows = Windows.of(self, trials)
        trained = _train(self, windows, seed, progress)
        best, squares = int(np.argmin(trained.others)), trained.counted * windows.size**2
        facts = {
            "starts": 1,
            "epochs": len(trained.losses),
            "best_epoch": best,
            "windows": len(windows.rate),
            "windows_held_out": trained.held,
            "held_out_nrmse": [float(f"{math.sqrt(e):.4g}") for e in trained.others],
            "squares": squares,
            "precision": "float32",
        }
        values, none = _exported(windows, trained.network), np.empty(0)
        history = 0.5 * squares * np.array(trained.losses)
        table = {
            "cost": history[[best]],
            "evaluations": np.array([len(history)]),
            "values": values[None],
        }
        return Estimate(values, none, none, np.empty((0, 0)), history, table, facts)


@dataclass(frozen=True, eq=False)
class Windows:
    """Pieces of trials, with their lead before them: rate and torque (w, n, 3), without dimensions.
    begun (w, n), 0 before the trial's start; counts (w, n, 3), 1 where the torque counts. Largest
    input `reach`, rms torque `size` [N m].

    `whole` (t, m, 3): rates of all trials, zeros at their ends. owner, before (w,): a window's
    trial, and the interval there that comes before it, negative where none does.
    """

    rate: np.ndarray
    torque: np.ndarray
    begun: np.ndarray
    counts: np.ndarray
    owner: np.ndarray
    before: np.ndarray
    whole: np.ndarray
    reach: float
    size: float

    @staticmethod
    def of(model: LSTM, trials: Sequence) -> "Windows":
        sampled = [_sampled(model, trial) for trial in trials]
        pieces = [
            (*p, k) for k, s in enumerate(sampled) for p in _pieces(model, *s, trials[k].measured)
        ]
        if len(pieces) < 2:
            raise ValueError(
                f"the trials give {len(pieces)} window of {model.window} intervals; the lstm needs "
                f"2 or more"
            )
        rate, torque, begun, counts, before, owner = (
            np.array(column) for column in zip(*pieces, strict=True)
        )
        size = float(np.sqrt((torque**2 * counts).sum() / counts.sum()))
        reach = float(abs(rate).max())
        if not size or not reach:
            raise ValueError(
                f"the lstm cannot learn from trials without {'motion' if size else 'torque'}"
            )
        series = np.zeros((len(trials), max(len(r) for r, _ in sampled), 3), np.float32)
        for row, (rates, _) in zip(series, sampled, strict=True):
            row[: len(rates)] = rates / reach
        scaled = (a.astype(np.float32) for a in (rate / reach, torque / size, begun, counts))
        return Windows(*scaled, owner, before, series, reach, size)


def _sampled(model: LSTM, trial) -> tuple[np.ndarray, np.ndarray]:
    """Compressed mean rates and torques at the ends (n, 3) of a trial's intervals."""
    time = trial.step * np.arange(trial.samples)
    ends = model.interval * np.arange(int(time[-1] / model.interval * (1.0 + 1e-9)) + 1)
    angle, torque = (
        np.stack([np.interp(ends, time, c) for c in v.T], axis=1)
        for v in (trial.angle, trial.torque)
    )
    return np.arcsinh(np.diff(angle, axis=0) / model.interval / model.softness), torque[1:]


def _pieces(model: LSTM, rate: np.ndarray, torque: np.ndarray, measured):
    """Rate, torque, begun, counts of each window of a trial, and the interval before it."""
    for first in range(0, len(rate), model.window):
        places = np.arange(first - model.lead, first + model.window)
        there = (places >= 0) & (places < len(rate))
        taken = np.clip(places, 0, len(rate) - 1)
        counts = (there & (places >= first))[:, None] & np.array(measured)
        yield rate[taken], torque[taken], there, counts, first - model.lead - 1


class Trained(NamedTuple):
    """Network of the best epoch. Mean squares over that of the torque by epoch, of the windows
    trained on, and before it of the `held` others. Last comes the number of torques that count in
    the former.
    """

    network: tuple
    losses: list[float]
    others: list[float]
    held: int
    counted: float


def _train(model: LSTM, windows: Windows, seed: int, progress: Callable[[float], None]) -> Trained:
    """Adam with a falling rate, until the windows held out get no better."""
    if reason := missing():
        raise ValueError(reason)
    import equinox as eqx
    import jax
    import optax

    random = np.random.default_rng(seed)
    order = random.permutation(len(windows.rate))
    held = order[: max(1, round(model.held_out * len(order)))]
    training = order[len(held) :]
    size = min(model.batch, len(training))
    used = len(training) // size * size
    rate = optax.cosine_decay_schedule(model.rate, model.epochs * PASSES * used // size, RATE_LEFT)
    adam = optax.chain(optax.clip_by_global_norm(CLIP), optax.adam(rate))
    data = tuple(
        jax.numpy.asarray(d) for d in (windows.rate, windows.begun, windows.torque, windows.counts)
    )

    def learn(carried, batch):
        network, state, begin = carried
        parts = (begin[batch], *(d[batch] for d in data))
        error, slopes = eqx.filter_value_and_grad(_mean_square)(network, *parts)
        change, state = adam.update(slopes, state)
        return (eqx.apply_updates(network, change), state, begin), error

    @eqx.filter_jit
    def epoch(network, state, batches):
        begin = _begins(network, windows)
        held_error = _mean_square(network, begin[held], *(d[held] for d in data))
        (network, state, _), errors = jax.lax.scan(learn, (network, state, begin), batches)
        return network, state, errors.mean(), held_error

    network = best = _network(model, jax.random.PRNGKey(seed))
    state, losses, others = adam.init(eqx.filter(network, eqx.is_array)), [], []
    for done in range(model.epochs):
        if done - int(np.argmin(others or [0.0])) > model.patience:
            break
        batches = [random.permutation(training)[:used] for _ in range(PASSES)]
        before = network
        network, state, *errors = epoch(network, state, np.reshape(batches, (-1, size)))
        for row, error in zip((losses, others), errors, strict=True):
            row.append(float(error))
        if others[-1] == min(others):
            best = before
        progress((done + 1) / model.epochs)
    return Trained(best, losses, others, len(held), float(windows.counts[training].sum()))


def _network(model: LSTM, key):
    """An LSTM cell that remembers at first, and its read-out."""
    import equinox as eqx
    import jax

    first, second = jax.random.split(key)
    cell = eqx.nn.LSTMCell(3, model.hidden, key=first)
    remembering = cell.bias.at[model.hidden : 2 * model.hidden].set(1.0)
    return eqx.tree_at(lambda c: c.bias, cell, remembering), eqx.nn.Linear(
        model.hidden, 3, key=second
    )


def _run(network, begin, rate, begun):
    """Outputs (n, 3) and states (n, 2, hidden) of the network along one piece; zero until the trial
    has begun.
    """
    import jax

    cell, out = network

    def one(state, seen):
        state = jax.numpy.stack(cell(seen[0], (state[0], state[1]))) * seen[1]
        return state, (out(state[0]), state)

    return jax.lax.scan(one, begin, (rate, begun))[1]


def _begins(network, windows: Windows):
    """States (w, 2, hidden) in which windows begin, of the network as it runs along complete
    trials.
    """
    import jax

    zero, begun = np.zeros((2, network[0].hidden_size)), np.ones(windows.whole.shape[1])
    states = jax.vmap(lambda rate: _run(network, zero, rate, begun)[1])(windows.whole)
    there = (windows.before >= 0)[:, None, None]
    return states[windows.owner, np.maximum(windows.before, 0)] * there


def _mean_square(network, begin, rate, begun, torque, counts):
    """Mean square of the error of windows where it counts."""
    import jax

    predicted = jax.vmap(lambda *piece: _run(network, *piece)[0])(begin, rate, begun)
    return (counts * (predicted - torque) ** 2).sum() / counts.sum()


def _exported(windows: Windows, network) -> np.ndarray:
    """Weights for inputs and torques in SI, in the order of the parameters; no torque where none
    was measured.
    """
    cell, out = network
    size = windows.size * (windows.counts.sum(axis=(0, 1)) > 0)
    parts = [np.asarray(w, float).T for w in (cell.weight_ih / windows.reach, cell.weight_hh)]
    read_out, offset = (np.asarray(w, float).T * size for w in (out.weight, out.bias))
    return np.concatenate([w.ravel() for w in (*parts, cell.bias, read_out.T, offset)])


models.MODELS["lstm"] = LSTM
