"""Trials of a random scene: numbers of its run, and a second run or a command that must agree with
it.

Each trial is a function of a scene, its run and a random generator. It raises `Wrong` where a
relation does not hold, and returns False where it is not defined for the scene.
"""

import contextlib
import io
import random
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance import cli
from clearance.lanes.code import natural_width
from clearance.lanes.group import impossible
from clearance.run.options import Output
from clearance.simulation import prepare, write
from tests.random_scenes import OF_USERS, Drawn, timed
from tests.relations import RELATIONS, Channels, Spread, balance, closure, spread

ROOT = Path(__file__).parents[1]
RTOL, MOVE = 1e-8, 1e-6  # tolerance of the runs; by which starts are moved, over natural sizes
#: errors of a run: local ones of RTOL, summed over its steps
SUM = 1000.0
LATER = 10.0  # growth of errors that are made on the way, over that of errors at the start
FURTHEST = 1e-3  # grown error over the size of a channel, beyond which trajectories have parted
STEPS, SAMPLES = 20_000, 201
BALANCE = 1e-7  # rounding of forces, over the largest of a body
LEDGER = 1e-4  # share of the energy turned over
ROUNDING = 1e-13  # of turns and shares
PLACES = ("m", "rad", "m/s", "rad/s")  # units of what impacts do not make jump
JUMPING = ("/efficiency", "/mode")  # outputs that jump


class Wrong(AssertionError):
    """A relation or a number does not hold."""


# --- runs
def run(scene: cl.Scene, span: dict, samples: int = SAMPLES, **more) -> Channels:
    """Channels of a run."""
    options = {"rtol": RTOL, "max_steps": STEPS, "error": None} | span | more
    return Channels(cl.simulate(scene, samples=samples, **options))


def moved(scene: cl.Scene, span: dict, signs: int, samples: int) -> Channels:
    """Channels of a run whose start is moved; signs: seed of the directions."""
    trial = prepare(scene, **span, rtol=RTOL, samples=samples, max_steps=STEPS)
    size = trial.mechanism.size
    ways = np.random.default_rng(signs).choice([-1.0, 1.0], size)
    trial.state.y[:size] += MOVE * ways * trial.mechanism.scale[:size]
    return Channels(write(trial, Output()))


@dataclass(frozen=True)
class Base:
    """The run of a scene; its spread, from two starts beside its own, where it is needed."""

    scene: cl.Scene
    span: dict
    run: Channels

    @cached_property
    def none(self) -> Spread:
        return spread(self.run, [self.run], MOVE)

    @cached_property
    def near(self) -> Spread:
        samples = self.run["time"].size
        return spread(
            self.run, [moved(self.scene, self.span, signs, samples) for signs in (1, 2)], MOVE
        )

    def agree(self, other: Channels, change, rule: str, share: float = SUM * RTOL) -> None:
        """Raise Wrong where a run is further from what it must be than errors may grow to.

        They are looked at as if they did not grow first, which costs no run.
        """
        share = max(share, RTOL * self.run.result.solver["steps"])  # of local errors
        if _furthest(self.none, other, change, share)[1]:
            ratio, text = _furthest(self.near, other, change, LATER * share)
            if text:
                raise Wrong(f"{rule}: {text} ({ratio:.2g} times)")


def _furthest(near: Spread, other: Channels, change, share: float) -> tuple[float, str]:
    """The worst of the distances that are not allowed, over what is, in words; else no words."""
    worst, together = (1.0, ""), _together(near, share)
    for path in near.run.paths:
        expected = change.expected(path, near.run)
        if expected is None or path.endswith(JUMPING):
            continue
        values = other[change.counterpart(path)]
        size = near.sizes[unit := near.run.units(path)]
        factor = getattr(change, "factor", lambda unit: 1.0)(unit)
        allowed = near.allowed(path, share)
        apart = np.abs(values - expected) / factor
        if path.endswith("/theta"):
            apart = np.abs(np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi)
        apart = np.where(apart < ROUNDING, 0.0, apart) if unit == "1" else apart
        near_enough = (allowed < FURTHEST * size) & ((unit in PLACES) | together)
        ratio = np.where(near_enough, apart / (allowed + 1e-300), 0.0)
        k = int(np.argmax(ratio))
        if not ratio[k] <= worst[0]:
            text = f"{apart[k]:.3g} at sample {k}, {allowed[k]:.2g} allowed, size {size:.3g}"
            worst = ratio[k], f"{path} is off by {text}"
    return worst


def _together(near: Spread, share: float) -> np.ndarray:
    """Samples up to which no channel has parted: then forces within impacts compare."""
    units = {path: near.run.units(path) for path in near.run.paths}
    parted = [near.allowed(p, share) >= FURTHEST * near.sizes[u] for p, u in units.items()]
    return ~np.any(parted, axis=0)


# --- numbers of one run
def independent(scene: cl.Scene, base: Channels) -> None:
    """Raise Wrong where forces do not balance, hinges come apart, or energy is lost unseen."""
    for name, rest in balance(scene, base).items():
        if not rest < BALANCE:
            raise Wrong(f"balance: {name} leave {rest:.2g} of the largest")
    for name, gap in closure(scene, base).items():
        if not gap < 1e-10:
            raise Wrong(f"closure: joint {name} is {gap:.2g} of the mechanism apart")
    share = base.result.solver.get("energy_residual_share", 0.0)
    if not share < LEDGER and not any("ledger" in w for w in base.result.warnings):
        raise Wrong(f"ledger: {share:.2g} of the energy turned over is missing, without a warning")
    for path in base.paths:
        if not np.isfinite(base[path]).all():
            raise Wrong(f"finite: {path} is not")


# --- relations and commands: each returns False where it is not defined for a scene
class Same:
    """Every channel as it was."""

    skipped: tuple[str, ...] = ()

    def expected(self, path: str, base: Channels):
        return None if path.endswith(self.skipped) else base[path]

    def counterpart(self, path: str) -> str:
        return path


def related(kind: type, drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Another scene whose run follows from this one's."""
    change = kind(rng, drawn.scene)
    if not change.applies(drawn.scene):
        return False
    try:
        other = run(change.of(drawn.scene), change.span(drawn.span))
    except ValueError as error:
        raise Wrong(f"{kind.__name__.lower()}: refused: {error}") from error
    base.agree(other, change, kind.__name__.lower())
    return True


def solved(drawn: Drawn) -> bool:
    """True where a film is solved during the run: each solution starts from the last one."""
    return bool({"film solved", "film conserving"} & {*drawn.tags})


def method(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Another method, at another tolerance."""
    name, rtol = rng.choice(["radau5", "radau9", "rodas5p"]), rng.choice([1e-7, 1e-8, 1e-9])
    other = run(drawn.scene, drawn.span, method=name, rtol=rtol)
    share = SUM * max(rtol, RTOL)
    base.agree(other, Same(), f"method {name}", share)
    return True


def resampled(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Twice the samples: every second one is the same. Samples bound the steps where a motion is
    prescribed over time.
    """
    other = run(drawn.scene, drawn.span, samples=2 * SAMPLES - 1)
    if solved(drawn) or any(d.motion is not None for d in drawn.scene.drives):
        base.agree(_Second(other), Same(), "samples")
    else:
        exactly(base.run, other, _second, "samples", 1e-9)
    return True


def _second(values: np.ndarray) -> np.ndarray:
    return values[::2]


class _Second:
    """Every second sample of a run."""

    def __init__(self, run: Channels):
        self.run = run

    def __getitem__(self, path: str) -> np.ndarray:
        return _second(self.run[path])


def exactly(base: Channels, other: Channels, of: Callable, rule: str, within: float = 0.0) -> None:
    """Raise Wrong where a channel has other values. within: over the size of the channel."""
    for path in base.paths:
        apart = np.abs(of(other[path]) - base[path])
        if not apart.max(initial=0.0) <= within * np.abs(base[path]).max(initial=0.0):
            k = int(np.argmax(apart))
            raise Wrong(f"{rule}: {path} is {other[path][k]:.17g} for {base[path][k]:.17g}")


def stored(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """The scene as TOML, Python and JSON: the same bits where the parts are in the same order."""
    from clearance.scene.write_python import python_of
    from clearance.scene.write_toml import toml_of

    exactly(base.run, run(cl.Scene.from_json(drawn.scene.to_json()), drawn.span), _same, "JSON")
    if any(tag.endswith(one.__name__) for tag in drawn.tags for one in OF_USERS):
        return True  # such a law is written into a TOML file by hand
    with tempfile.TemporaryDirectory() as folder:
        toml, python = Path(folder) / "scene.toml", Path(folder) / "scene.py"
        toml.write_text(toml_of(drawn.scene))
        python.write_text(python_of(toml))
        for name, path in {"TOML": toml, "Python": python}.items():
            scene = cl.load_case(path)
            other = run(scene, drawn.span)
            if scene.to_json() == drawn.scene.to_json():
                exactly(base.run, other, _same, name)
            else:  # a file lists parts by their kinds: sums have another order
                base.agree(other, Same(), name)
    return True


def _same(values: np.ndarray) -> np.ndarray:
    return values


def restarted(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Two runs, one from the end of the other, against one of twice the length."""
    if timed(drawn.scene) or "film conserving" in drawn.tags:
        return False
    name, length = next(iter(drawn.span.items()))
    if name == "turns":
        length = max(1.0, round(length))
    elif any(d.motion is not None for d in drawn.scene.drives):
        length = drawn.turn * max(1.0, round(length / drawn.turn))
    twice, once = {name: 2.0 * length}, {name: length}
    entire = run(drawn.scene, twice, samples=2 * SAMPLES - 1)
    with tempfile.TemporaryDirectory() as folder:
        first = run(drawn.scene, once).result
        if "open_contact" in map(str, first.events["kind"]):
            return False  # the impact speed of an open contact is not transferred
        start = first if rng.random() < 0.5 else first.save(Path(folder) / "first.h5")
        second = run(drawn.scene, once, start=start)
    change = Same()
    change.skipped = ("/dissipated", "/turns")
    Base(drawn.scene, twice, entire).agree(_After(first, second, entire), change, "restarted")
    return True


class _After:
    """Channels of two runs, one after the other."""

    def __init__(self, first, second: Channels, entire: Channels):
        self.first, self.second, self.paths = Channels(first), second, entire.paths

    def __getitem__(self, path: str) -> np.ndarray:
        return np.concatenate([self.first[path], self.second[path][1:]])


CASE = '''"""A random scene with heavier bodies."""
import sys
sys.path.insert(0, {root!r})
import clearance as cl
from tests.random_scenes import draw

def scene(*, factor: float = 1.0) -> cl.Scene:
    """A random scene.

    factor: of the mass of a body [-]
    """
    made = draw({seed}).scene
    body = made.bodies[0]
    return made.replaced({{f"{{body.key}}/mass": body.mass * factor}})
'''


def case_of(drawn: Drawn, folder: str) -> Path:
    """A case file of a scene."""
    case = Path(folder) / "random_case.py"
    case.write_text(CASE.format(root=str(ROOT), seed=drawn.seed))
    return case


@contextlib.contextmanager
def lanes(width: str | None) -> Iterator[None]:
    """With so many lanes, or as many as the processor has."""
    natural_width.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        if width is not None:
            patch.setenv("CLEARANCE_LANES", width)
        yield
    natural_width.cache_clear()


def swept(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """A point of a sweep, beside others: alone or in lanes of any width."""
    width = rng.choice(["1", "2", "8", None])
    with tempfile.TemporaryDirectory() as folder, lanes(width):
        case = case_of(drawn, folder)
        options = {**drawn.span, "rtol": RTOL, "samples": SAMPLES, "max_steps": STEPS}
        points = cl.grid(factor=[1.0, 1.01, 1.02])
        sweep = cl.sweep(case, points, Path(folder) / "sweep", workers=1, **options)
        if not sweep.done.all():
            raise Wrong(f"sweep: point failed: {sweep.reason[~sweep.done][0]}")
        with sweep.run(0) as result:
            other = Channels(result)
            base.agree(other, Same(), f"sweep, {width or 'natural'} lanes")
    return True


def side_by_side(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Points side by side in lanes of any width, of complete turns or with a part of one behind
    them: the metrics of the ordinary way.
    """
    options = {"rtol": RTOL, "max_steps": STEPS}
    if not drawn.scene.turn:
        return False
    turns = max(1.0, round(drawn.span["turns"])) + rng.choice([0.0, rng.random()])
    options |= rng.choice([{"turns": turns}, {"until": turns * drawn.scene.turn}])
    mechanism = prepare(drawn.scene, **options).mechanism
    if impossible(mechanism, "radau5"):
        return False
    options |= {"method": "radau5", "workers": 1, "channels": []}
    factors = [1.0 + 0.1 * MOVE * k for k in range(24)]
    with tempfile.TemporaryDirectory() as folder:
        case = case_of(drawn, folder)
        with lanes("0"):
            alone = cl.sweep(case, cl.grid(factor=factors[::8]), Path(folder) / "alone", **options)
        if not alone.done.all():
            return False  # entire turns may take more steps than the run before
        with lanes(width := rng.choice(["1", "2", "4", "8"])):
            wide = cl.sweep(case, cl.grid(factor=factors), Path(folder) / "lanes", **options)
        if not wide.done.all():
            raise Wrong("lanes: points failed")
    off = {}
    for name, values in alone.metrics.items():
        unit = alone.known[name][0]
        natural = mechanism.energy if unit == "J" else base.none.sizes.get(unit, 0.0)
        size = max(np.abs(values).max(), natural)
        grown = np.ptp(values) / (1.6 * MOVE) + size
        apart = np.abs(wide.metrics[name][::8] - values).max()
        allowed = LATER * SUM * RTOL * grown
        if allowed < FURTHEST * size and not apart <= allowed:
            off[name] = allowed
    if not off:
        return True
    with tempfile.TemporaryDirectory() as folder, lanes("0"):  # a peak of a stiff bristle is dear
        case, finer = case_of(drawn, folder), options | {"rtol": 1e-2 * RTOL, "max_steps": None}
        near = cl.sweep(case, cl.grid(factor=factors[::8]), Path(folder) / "near", **finer)
    for name, allowed in off.items():
        mine, theirs = (
            np.abs(values - near.metrics[name]).max()
            for values in (alone.metrics[name], wide.metrics[name][::8])
        )
        if not theirs <= allowed + LATER * mine:
            raise Wrong(f"{width} lanes: {name} is off by {theirs:.3g}, the ordinary {mine:.3g}")
    return True


def scattered(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Masses by chance: quantiles are those of the runs, which lie about the run at the median."""
    with tempfile.TemporaryDirectory() as folder:
        case = case_of(drawn, folder)
        options = {"rtol": RTOL, "samples": SAMPLES, "max_steps": STEPS, "workers": 1}
        wide = {"factor": "uniform(0.99, 1.01)"}
        scatter = cl.scatter(case, wide, Path(folder) / "out", points=24, **drawn.span, **options)
        if not scatter.sweep.done.all():
            raise Wrong(f"scatter: {scatter.sweep.reason[~scatter.sweep.done][0]}")
        factors = scatter.sweep.columns["factor"]
        if not ((factors >= 0.99) & (factors <= 1.01)).all():
            raise Wrong(f"scatter: factors from {factors.min()} to {factors.max()}")
        for name in scatter.metrics:
            values = scatter.values(name)
            low, middle, high = (scatter.quantile(name, q).value for q in (0.05, 0.5, 0.95))
            if not values.min() <= low <= middle <= high <= values.max():
                raise Wrong(f"scatter: quantiles of {name} are {low}, {middle}, {high}")
    return True


def commanded(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Commands that read the file of a run: each does its work, or gives one line."""
    from tests.benchmarks.damage import printed

    with tempfile.TemporaryDirectory() as folder:
        path, out = base.run.result.save(Path(folder) / "run.h5"), str(Path(folder) / "out")
        body = rng.choice(drawn.scene.bodies).name
        commands = [
            ["plot", str(path), "-o", f"{out}.png"],
            ["plot", str(path), "sketch", "-o", f"{out}.png"],
            ["plot", str(path), "contacts", "-o", f"{out}.png"],
            ["plot", str(path), "history", "--channels", f"{body}.omega", "-o", f"{out}.png"],
            ["report", str(path), "-o", f"{out}.html"],
            ["new", str(path), "-o", f"{out}.toml"],
            ["run", "--again", str(path), "-o", f"{out}.h5"],
        ]
        command = rng.choice(commands)
        if (fault := printed(command)) is not None:
            raise RuntimeError(f"{command[0]} {command[2]}: {fault}")
    return True


def checkpointed(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """A run that is interrupted and goes on from its checkpoint: the same bits, but for films that
    are solved from their last solution.
    """
    until = rng.uniform(0.1, 0.9)

    def stop(done: float) -> None:
        if done > until:
            raise KeyboardInterrupt

    with tempfile.TemporaryDirectory() as folder:
        more = {"path": Path(folder) / "run.h5", "checkpoint": 0.1}
        with contextlib.suppress(KeyboardInterrupt):
            run(drawn.scene, drawn.span, progress=stop, **more)
        other = run(drawn.scene, drawn.span, **more)
    if solved(drawn):
        base.agree(other, Same(), "checkpoint")
    else:
        exactly(base.run, other, _same, "checkpoint")
    return True


def sensitive(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Derivatives of the numbers of a run by a mass: finite, or refused in one line."""
    key = f"{drawn.scene.bodies[0].key}/mass"
    result = run(drawn.scene, drawn.span, sensitivity=key).result
    exactly(base.run, Channels(result), _same, "sensitivity")
    return True


def settled(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """A periodic motion: another period ends with the rates that it began with."""
    if timed(drawn.scene) or not drawn.scene.drives or drawn.scene.drives[0].slides:
        return False
    period = None if drawn.scene.turn else drawn.turn
    try:
        options = {"rtol": RTOL, "most_turns": 40, "max_steps": STEPS}
        steady = cl.steady(drawn.scene, error=None, period=period, **options)
    except cl.NotPeriodic:
        return True
    once = run(drawn.scene, {"until": steady.duration}, start=steady.orbit)
    for path in (p for p in once.paths if p.endswith(("/vx", "/vy", "/omega"))):
        size = max(np.abs(once[p]).max() for p in once.paths if once.units(p) == once.units(path))
        rest = 10.0 * RTOL * base.none.sizes[once.units(path)]  # of a motion that has come to rest
        if not abs(once[path][-1] - once[path][0]) <= 1e-4 * size + rest:
            raise Wrong(f"steady: {path} goes from {once[path][0]:.9g} to {once[path][-1]:.9g}")
    return True


def followed(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """A branch over a mass: its end is the motion that the scene with this mass settles to."""
    if not drawn.scene.turn or timed(drawn.scene) or drawn.scene.drives[0].slides:
        return False
    channel = f"{drawn.scene.drives[0].key}/torque"
    with tempfile.TemporaryDirectory() as folder:
        options = {"rtol": RTOL, "most_turns": 40, "max_steps": STEPS}
        case = case_of(drawn, folder)
        try:
            branch = cl.follow(case, "factor", 1.0, 1.05, points=20, channels=[channel], **options)
            if branch.bifurcations or branch.points[-1].value != 1.05:
                return True
            last = cl.load_case(case, factor=1.05)
            steady = cl.steady(last, error=None, **options)
        except cl.NotPeriodic:
            return True
    if steady.period != branch.points[-1].period or abs(steady.multipliers[0]) > 0.9:
        return True
    torque = np.asarray(steady.orbit.values(channel))
    off = np.abs(branch.points[-1].outputs[:, 0] - torque[0]).min()
    if not off <= 1e-4 * np.abs(torque).max() + 1e-9 * base.none.sizes.get("N m", 0.0):
        raise Wrong(f"follow: {channel} is off by {off:.3g} of {np.abs(torque).max():.3g}")
    return True


def averaged(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """Statistics of turns: the interval of a mean holds that of a run, which numpy averages."""
    if not drawn.scene.turn or timed(drawn.scene) or drawn.scene.drives[0].slides:
        return False
    drive = drawn.scene.drives[0]
    if base.run.result.solver["steps"] > 5000.0 * drawn.span["turns"]:
        return False  # eighty turns, twice, take minutes
    name = f"drive_{drive.name}_torque_rms"
    try:
        seen = cl.statistics(drawn.scene, {name: 0.2}, max_turns=80, starts=1, check=False)
    except ValueError as error:
        if "all turns are alike" in str(error):
            return False
        raise
    turns, rest = seen.shape[1], seen.left_out
    other = run(drawn.scene, {"turns": float(turns)}, turns * 720 + 1, rtol=1e-6, max_steps=None)
    torque = other[f"{drive.key}/torque"][:-1].reshape(turns, 720)[rest:]
    mine = float(np.sqrt((torque**2).mean(axis=1)).mean())
    interval = seen[name].mean
    natural = sum(b.inertia for b in drawn.scene.bodies) * (2.0 * np.pi / drawn.turn) ** 2
    wide = 3.0 * interval.half_width + 0.02 * abs(interval.value) + 1e-6 * natural
    if not abs(mine - interval.value) <= wide:
        raise Wrong(f"statistics: {name} is {interval.value:.6g} +- {wide:.2g}, not {mine:.6g}")
    return True


def worn_off(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """A life of some turns: volumes of such turns once they settled, within the stated error.

    Full turns of a film that is solved at each step would take hours.
    """
    joints = [j for j in drawn.scene.clearance_joints if getattr(j, "wear", None) is not None]
    if not joints or not drawn.scene.turn or timed(drawn.scene) or solved(drawn):
        return False
    turns = 6
    try:
        entire = cl.simulate(drawn.scene, turns=turns, error=None, max_steps=turns * STEPS)
    except cl.SimulationError:
        return False  # a life of it ends so too, later
    with tempfile.TemporaryDirectory() as folder:
        life = cl.wear(drawn.scene, turns=turns, directory=Path(folder) / "life", average=1)
        error = float(life.error[-1])
        grown = {j.name: float(np.ptp(life.volume(j.name)[[0, -1]])) for j in joints}
    if len(drawn.scene.clearance_joints) > 1:
        return True  # chaotic
    for joint in joints:
        worn = entire.joint(joint.name).wear_volume_bearing
        settled = float(np.interp(2.0 * drawn.turn, entire.time, worn))  # as stages do
        volume = (float(worn[-1]) - settled) * turns / (turns - 2)
        missed = error * 2.0 * np.pi * joint.radius * joint.length
        if not abs(volume - grown[joint.name]) <= missed + 0.2 * volume:
            raise Wrong(f"life: {joint.name} loses {grown[joint.name]:.4g}, not {volume:.4g} m3")
    return True


def gone_on(drawn: Drawn, base: Base, rng: random.Random) -> bool:
    """`clearance run --from`: the same bits as `start=` of Python."""
    if timed(drawn.scene) or "film conserving" in drawn.tags:
        return False
    with tempfile.TemporaryDirectory() as folder:
        case, out = case_of(drawn, folder), Path(folder) / "second.h5"
        length = float(drawn.turn if drawn.scene.drives else base.run["time"][-1])
        once = {"until": length, "rtol": RTOL, "samples_per_turn": 100, "error": None}
        once["max_steps"] = STEPS  # the command runs as long as the two before it, then
        first = cl.simulate(cl.load_case(case), **once).save(Path(folder) / "first.h5")
        second = cl.simulate(cl.load_case(case), start=first, **once)
        words = ["run", str(case), "--from", str(first), "-o", str(out), "--until", repr(length)]
        words += ["--rtol", repr(RTOL), "--samples-per-turn", "100"]
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            status = cli.main(words)
        if status:
            raise Wrong(f"--from: the command ends with status {status}")
        with cl.open_result(out) as result:
            exactly(Channels(second), Channels(result), _same, "--from")
    return True


TRIALS: dict[str, Callable] = {
    **{kind.__name__.lower(): partial(related, kind) for kind in RELATIONS},
    "method": method,
    "samples": resampled,
    "file": stored,
    "restarted": restarted,
    "sweep": swept,
    "command": commanded,
    "checkpoint": checkpointed,
    "sensitivity": sensitive,
    "steady": settled,
    "follow": followed,
    "statistics": averaged,
    "lanes": side_by_side,
    "scatter": scattered,
    "life": worn_off,
    "run --from": gone_on,
}
#: share of scenes that try them, over others: of trials that compile other code or run for long,
#: and of those that few scenes have
DEAR = {
    "reordered": 0.5, "renamed": 0.5, "split": 0.5, "method": 0.5, "sensitivity": 0.5,
    "command": 0.5, "sweep": 0.3, "scatter": 0.2, "steady": 1.0, "follow": 1.5, "statistics": 0.6,
    "lanes": 3.0, "life": 100.0,
}  # fmt: skip
