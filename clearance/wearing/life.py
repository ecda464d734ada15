"""A life: stages of settled turns on outlines that stay as they are, and jumps over many turns
between them.

A stage runs the scene on its outlines and measures wear and load path of a turn. A jump replays
that path (wearing/replay.py) until a depth has grown by a share of the clearance. The stage at its
end measures anew, and its load path is replayed in place of the first. The depths of both may
differ by more than the tolerance. The loads have changed then, and half the jump is made instead.
Where that does not make the difference smaller, no shorter jump would. The half jump stands, and
longer ones with such a difference follow.

A life may be off by the errors of the replays and by half of each difference. Where loads change
evenly, the jump before foretells most of a difference. The life then goes on from the mean of both
replays, which is the trapezium rule. It may be off by half of what was not foretold, which is six
times the error of that rule. Wear of a turn is no measure of the error: on hard surfaces each ridge
of an outline takes all of it.
"""

import json
import logging
import math
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from clearance.elements.body import ground
from clearance.files.locks import Lock, opener, replace_file, replacing
from clearance.files.texts import signed
from clearance.laws.contact import layer_of
from clearance.laws.outline import Outline, worn
from clearance.mechanism.build import build
from clearance.metrics.metrics import SURFACES, described, metrics
from clearance.results.result import Result, open_result
from clearance.run.ideal_motion import ideal_motion
from clearance.run.inputs import accept, differences, of_case
from clearance.run.options import Output
from clearance.run.progress_bar import watched
from clearance.run.wear_sum import Turn, Wearing, solids_of, thinned
from clearance.scene.catalogue import AnyCase, load_case
from clearance.scene.scene import Scene
from clearance.simulation import SimulationError, prepare, reopened, write
from clearance.values import checks
from clearance.values.algebra import Arrays
from clearance.wearing import life_record
from clearance.wearing.life_record import Life
from clearance.wearing.load_path import LoadPath, Worn, middle, moved, smoothed, untold

LOG = logging.getLogger("clearance")
JUMPS = ("replay", "linear")
MOST_AVERAGED = 50  # turns of a stage, where its wear scatters
LEAST = 1.0  # turns of a jump
FINE = 90  # samples of a turn from which on they give a speed
EVENLY = 20.0  # of a place's shift, by which it changes in a turn at most; else it is on a ridge
GROW, SHRINK, EASY = 1.5, 0.5, 1.0 / 3.0  # of jumps; share of the tolerance below which they grow
FORETOLD = 0.5  # of a change: the rest where loads change evenly
BETTER = 0.7  # of the difference behind a jump: that behind its half; else no shorter one helps
LIKELY = 0.6  # of the largest difference by chance: one that is there half the time
REPLAYED = 0.006  # error of the replay, of the depth that it adds, over the tolerance
SCATTERED = 0.1  # the same, over the spread of the depth of a turn, where that is more
CHANCE = 4.0  # standard errors that the largest of some twenty places is off by, of few turns
THINNEST = 6  # rows of a load path of which one is replayed, where twice as many turns are averaged
FIRST = 0.4  # of the share: depth of the first jump, whose change nothing foretells


@dataclass(frozen=True)
class Plan:
    """Request for a life, all but the scene: see `wear`."""

    turns: float
    share: float
    tolerance: float
    settle: int
    average: int
    jump: str
    jump_turns: float | None
    rtol: float
    method: str
    samples_per_turn: int

    def __post_init__(self):
        checks.positive("turns", self.turns)
        checks.positive("tolerance", self.tolerance)
        if not 0.0 < checks.finite("share", self.share) <= 1.0:
            reason = "a jump that deepens a scar by more than the clearance swallows it"
            raise ValueError(
                f"share must lie in (0, 1] of the clearance, got {self.share!r}: {reason}"
            )
        checks.one_of("jump", self.jump, JUMPS)
        if self.jump_turns is not None:
            checks.positive("jump_turns", self.jump_turns)
        checks.whole("settle", self.settle)
        checks.whole("average", self.average, 1)


@dataclass(frozen=True)
class Measured:
    """Measurement of one joint in a stage: wear of a turn [m] by surface, and the load path of one.

    scatter: standard error of the volume's mean over the turns, as a share of it. spread: that of
    the depth of a turn, the largest over the angle, as a share of the largest depth.
    """

    rate: Arrays
    scatter: float
    path: np.ndarray
    spread: float

    @property
    def fastest(self) -> float:
        """Largest depth of a turn, over neighbouring bins [m]."""
        return max(float(smoothed(rate).max()) for rate in self.rate.values())

    @classmethod
    def of(cls, turns: list[Turn]) -> "Measured":
        """Mean of turns."""
        count = len(turns)
        rate = {b: sum(t.depths[b] for t in turns) / count for b in turns[0].depths}
        totals = np.array([sum(t.volumes.values()) for t in turns])
        scatter = spread = 0.0
        if count > 1 and totals.mean() > 0.0:
            scatter = float(totals.std(ddof=1) / math.sqrt(count) / totals.mean())
            spread = max(_spread([t.depths[b] for t in turns]) for b in rate)
        path = np.concatenate([thinned(t.path, min(max(count // 2, 1), THINNEST)) for t in turns])
        path[:, 3:5] /= count
        return cls(rate, scatter, path, spread)


class Reached(NamedTuple):
    """State of a life after a stage: turns, their error, and the next jump in turns. Also by how
    much the loads have changed the wear, and the part of it that a shorter jump leaves.
    """

    turns: float
    error: float
    jump: float
    changed: float = 0.0
    floor: float = 0.0


@watched
def wear(
    case: AnyCase,
    *,
    turns: float,
    directory: str | Path,
    share: float = 0.25,
    tolerance: float = 0.05,
    settle: int = 2,
    average: int = 2,
    jump: str = "replay",
    jump_turns: float | None = None,
    rtol: float = 1e-4,
    method: str = "auto",
    samples_per_turn: int = 360,
    accept_changes: bool = False,
    progress: Callable[[float, str], None] | bool | None = None,
    **parameters,
) -> Life:
    """The life of a mechanism whose joints wear, in a directory that can be killed and gone on
    with.

    case: a name, a file, a function or a scene, with its parameters; turns: how many it shall do.
        share: of the clearance, by which a depth grows in a jump at most; tolerance: of wear of a
        turn, by which it may differ from that predicted.
    settle, average: turns of a stage before the measurement, and turns of the measurement. There
    are more, up to 50, where wear scatters from turn to turn (dry clearance is chaotic). jump:
    "replay" (implicit, of the load path), or "linear" (wear of a turn times turns, as in the
    literature), which is refused beyond its stability. jump_turns: longest jump.
    rtol, method, samples_per_turn: of the runs, see `simulate`. accept_changes: go on although the
        package, a law, the case file or the scene's numbers have changed since. progress: called
        with the share of the turns that is done, and with the state of the stage: "stage 3: 40 % of
        6 turns".
    Raises ValueError for bad input, for a directory of another life, and where a joint is worn
    through.

    Example:

        >>> life = cl.wear("wear_a", turns=2, directory="worn")
        >>> life.done
        True
    """
    of_stages = settle, average, jump, jump_turns, rtol, method, samples_per_turn
    plan = Plan(float(turns), share, tolerance, *of_stages)
    scene = load_case(case, **parameters)
    folder = Path(directory)
    with in_hand(folder):
        return Driver(scene, plan, folder, progress, accept_changes).go()


def in_hand(folder: Path, wait: bool = False) -> Lock:
    """The directory of a life, for one process. wait: until another one that has it in hand has
    ended; else that is an error.
    """
    folder.mkdir(parents=True, exist_ok=True)
    return Lock(folder / "life.lock", f"{folder} is in use", wait)


class Driver:
    """One life as it goes on. outlines: Worn by joint; turns: done; size: of the next jump.

    accept_changes: see `wear`; None: stages of what has changed since are run anew.
    """

    def __init__(
        self,
        scene: Scene,
        plan: Plan,
        folder: Path,
        progress: Callable | None = None,
        accept_changes: bool | None = False,
    ):
        self.plan, self.folder, self.done = plan, folder, 0.0
        self.progress = progress or (lambda done, words: None)
        self.joints = {j.name: j for j in scene.clearance_joints if j.wear or j.wear_journal}
        for joint in self.joints.values():
            _check_law(joint)
        if not self.joints:
            names = ", ".join(j.name for j in scene.clearance_joints) or "none with clearance"
            raise ValueError(
                f"no joint of {scene.name} wears (joints: {names}); give wear, such as "
                f"{_law_for(scene)}"
            )
        if scene.turn is None:
            raise ValueError(f"{scene.name}: a life counts turns, and nothing turns evenly in it")
        self.scene, self.turn = scene, scene.turn
        self.settle, self.average = plan.settle, plan.average
        self.most = plan.share * min(j.clearance for j in self.joints.values())  # of a jump [m]
        self._begin(accept_changes)

    # --- the directory
    def _begin(self, accept_changes: bool | None) -> None:
        """Take up the life of the directory, or begin one."""
        sizes = {
            n: {
                "radius": j.radius,
                "length": j.contact_length,
                "clearance": j.clearance,
                "wears": _wears(j),
            }
            for n, j in self.joints.items()
        }
        scene, case = self.scene.description(), vars(self.scene).get("case")
        asked = {**asdict(self.plan), "scene": scene, "joints": sizes}
        asked = json.loads(json.dumps(asked))
        path = self.folder / "life.json"
        self.journal = life_record.stages(self.folder, list(self.joints)) if path.exists() else []
        mechanism = build(self._scene(self._unworn()))  # the structure that all stages have
        self.inputs = of_case(mechanism, case, self.scene.parameters.values())
        if path.exists():
            before = {"method": "auto"} | life_record.asked(self.folder)
            fixed = {*asked} - {"turns", "scene"}
            settings = [n for n in asked if n in fixed and before.get(n) != asked[n]]
            if settings:
                raise ValueError(
                    f"{self.folder} holds another life (other {', '.join(settings)}); take another "
                    f"directory"
                )
            self._compare(before["scene"], asked["scene"], accept_changes)
        replace_file(path, signed(asked))
        replace_file(self.folder / "journal.jsonl", "".join(f"{signed(e)}\n" for e in self.journal))

    def _compare(self, before: dict, scene: dict, accept_changes: bool | None) -> None:
        """Stages of the journal and those to come must be of one physics; see `Driver`."""
        texts = json.dumps(before), json.dumps(scene)
        inputs = (entry.get("made", {}) for entry in self.journal)
        changed = dict.fromkeys(c for old in inputs for c in differences(old, self.inputs, *texts))
        if changed and accept_changes is None:
            LOG.info("%s begins anew: %s", self.folder, "; ".join(changed))
            self.journal = []
        elif changed:
            accept(f"{self.folder} has {len(self.journal)} stages", changed, accept_changes)

    def _scene(self, outlines: dict[str, Worn]) -> Scene:
        """The scene on outlines."""

        def element(part):
            if (
                getattr(part, "name", None) not in self.joints
                or part.key != self.joints[part.name].key
            ):
                return part
            depths = outlines[part.name]
            return replace(part, outline=worn(bearing=depths.bearing, journal=depths.journal))

        return self.scene.rebuilt(element=element)

    # --- a stage
    def run(
        self, stage: int, outlines: dict[str, Worn], average: int
    ) -> tuple[dict[str, Measured], dict]:
        """The run of a stage: what it has measured, and its metrics."""
        start = self.folder / f"stage-{stage - 1:04d}.h5" if stage else None
        path = self.folder / f"stage-{stage:04d}.h5"
        plan, turns = self.plan, self.settle + average
        options = {"turns": turns, "rtol": plan.rtol, "method": plan.method}
        options["samples_per_turn"] = plan.samples_per_turn
        prepared = partial(prepare, self._scene(outlines), start=start, **options)
        words = f"of {turns} turns"

        def report(share: float) -> None:
            self.progress(self.done, f"stage {stage}: {100.0 * share:.0f} % {words}")

        run, result = self._written(prepared, path, stage, report)
        ideal = ideal_motion(run.mechanism.scene, run.span, result.scene)
        values = metrics(result, float(self.settle), ideal)
        result.close()
        late = {name: t[self.settle :] for name, t in run.wearing.turns.items()}
        return {n: Measured.of(t) for n, t in late.items()}, values

    def _written(self, prepared: partial, path: Path, stage: int, report: Callable) -> tuple:
        """The run of a stage and its result, with open loops where it comes to dead centres."""
        run = prepared()
        while True:
            if stage:
                self._settle(run, stage - 1)
            run.wearing = Wearing(run, self.turn)
            run.observers.append(run.wearing)
            try:
                return run, write(run, Output(path, None, 0, None, None), report)
            except SimulationError as failed:
                run, reason = reopened(run, prepared, str(failed))
                if run is None:
                    failed.args = (reason,)
                    raise
                failed.result.close()

    def _settle(self, run, before: int) -> None:
        """Put journals that touched at the end of the stage before where the new outline carries
        the same force, and give them the speed at which that place moves.

        Without that speed they oscillate on their walls, and an implicit method resolves it.
        """
        state, mechanism = run.state, run.mechanism
        with open_result(self.folder / f"stage-{before:04d}.h5") as result:
            step = float(result.time[-1] - result.time[-2])
            for joint in (j for j in mechanism.places if j.name in self.joints):
                shifts = _shifts(joint, result)
                first = mechanism.places[joint]
                state.y[first : first + 2] += shifts[0]
                if FINE * step > self.turn or not shifts.any(axis=1).all():
                    continue
                rate = (1.5 * shifts[0] - 2.0 * shifts[1] + 0.5 * shifts[2]) / step
                if np.hypot(*rate) * self.turn < EVENLY * np.hypot(*shifts[0]):
                    first += mechanism.coordinates
                    state.y[first : first + 2] += rate

    def _arrays(self, stage: int) -> Arrays:
        wears = {name: _wears(joint) for name, joint in self.joints.items()}
        return life_record.arrays(self.folder, stage, wears)

    def stage(self, stage: int, outlines: dict[str, Worn]) -> tuple[dict[str, Measured], dict]:
        """A run of as many turns as its scatter needs."""
        average = self.average
        while True:
            measured, values = self.run(stage, outlines, average)
            worst = max(m.scatter for m in measured.values())
            enough = EASY * self.plan.tolerance
            if worst <= enough or average >= MOST_AVERAGED:
                self.average = average
                return measured, values
            needed = math.ceil(average * (worst / enough) ** 2)
            average = min(MOST_AVERAGED, max(needed, average + 2))
            LOG.info("wear of a turn scatters by %.2g: averaged over %d turns", worst, average)

    # --- a jump
    def jump(
        self,
        outlines: dict[str, Worn],
        measured: dict[str, Measured],
        turns: float,
        most: float,
    ) -> tuple[dict[str, Worn], float, float]:
        """Outlines after a jump of a depth [m], its turns (of the joint whose depth grows fastest),
        and the error of the replay.
        """
        jumps = {}
        for name in sorted(self.joints, key=lambda n: -measured[n].fastest):
            jumps[name] = self._over(name, outlines[name], measured[name], turns, most)
            turns = jumps[name][1]
        for name in (n for n, (_, done, _) in jumps.items() if done > turns):
            jumps[name] = self._over(name, outlines[name], measured[name], turns, math.inf)
        return {n: jumps[n][0] for n in self.joints}, turns, max(m[2] for m in jumps.values())

    def _over(
        self, name: str, outline: Worn, measured: Measured, turns: float, most: float
    ) -> tuple[Worn, float, float]:
        """Outline of one joint after `turns` turns or `most` [m] of depth."""
        if self.plan.jump == "linear":
            return self._straight(name, outline, measured, turns, most)
        if not len(measured.path):
            return outline, turns, 0.0
        outline = Worn.of(outline.data, measured.path, self.joints[name].wear_journal is not None)
        tolerance = max(REPLAYED * self.plan.tolerance, SCATTERED * measured.spread)
        try:
            return self._load_path(name, measured).over(outline, turns, tolerance, most, self.most)
        except RuntimeError as error:
            raise RuntimeError(f"joint {name}: {error}; jump=linear is a way out") from error

    def _load_path(self, name: str, measured: Measured) -> LoadPath:
        joint = self.joints[name]
        stiffness = joint.contact.values["layer_modulus"]
        surface = joint.radius * joint.contact_length
        return LoadPath(measured.path, stiffness, surface, solids_of(joint))

    def _straight(self, name: str, outline: Worn, measured: Measured, turns: float, most: float):
        """Wear of a turn times turns.

        Raises ValueError for a requested jump that is unstable.
        """
        stable = 2.0 / max(self._load_path(name, measured).stiff, 1e-300)
        if self.plan.jump_turns is not None and self.plan.jump_turns > stable:
            asked = f"jump_turns={self.plan.jump_turns:g} of linear jumps"
            raise ValueError(
                f"joint {name}: {asked}: beyond {stable:.3g} turns they are unstable; take "
                f"jump=replay"
            )
        fastest = max(float(rate.max()) for rate in measured.rate.values())
        turns = min(turns, stable, most / fastest if fastest > 0.0 else math.inf)
        new = outline.copy()
        depths = {s: d + turns * measured.rate.get(s, 0.0) for s, d in _depths(outline).items()}
        new.data = Outline(None, depths).numbers
        return new, turns, 0.0

    def instead(
        self, outlines: dict[str, Worn], measured: dict[str, Measured], turns: float
    ) -> dict[str, Worn]:
        """Outlines after as many turns of what another stage has measured."""
        return {n: self._over(n, outlines[n], measured[n], turns, math.inf)[0] for n in self.joints}

    # --- the life
    def go(self) -> Life:
        """Stages and jumps to the end."""
        outlines, turns, error, size, stage, before = self._resumed()
        measured = self._measured(stage) if stage >= 0 else None
        longer = math.inf  # difference at the end of the jump of which this one is the half
        floor = self.journal[-1].get("floor", 0.0) if self.journal else 0.0  # of the difference
        if measured is None:
            stage, measured = 0, self._first(outlines)
        while turns < self.plan.turns:
            self.done = turns / self.plan.turns
            self.progress(self.done, f"stage {stage} is done")
            rest = self.plan.turns - turns
            longest = max(LEAST, min(size, rest, self.plan.jump_turns or rest))
            most = self.most if stage else FIRST * self.most
            new, done, off = self.jump(outlines, measured, longest, most)
            self._check_walls(new, turns + done)
            after, values = self.stage(stage + 1, new)
            instead = self.instead(outlines, after, done)
            miss, changes = _missed(outlines, new, instead)
            chance = _chance(measured, after)
            allowed = max(self.plan.tolerance, chance)
            if done > LEAST and max(allowed, floor) < miss < BETTER * longer:
                size, longer = max(LEAST, SHRINK * done), miss
                LOG.info(
                    "the loads behind a jump wear by %.2g otherwise in %.4g turns: %.4g instead",
                    miss,
                    done,
                    size,
                )
                continue
            evenly = {n for n in changes if self._evenly(changes[n], done, before[n])}
            error += off + 0.5 * max(
                untold(c, done, before[n] if n in evenly else None) for n, c in changes.items()
            )
            outlines = {n: middle(w, instead[n]) if n in evenly else w for n, w in new.items()}
            since, turns = turns, turns + done
            measured, stage = after, stage + 1
            before = {n: (c, turns - since) for n, c in changes.items()}  # as the journal has it
            size = done / (SHRINK if miss >= BETTER * longer else 1.0)
            if miss < max(EASY * self.plan.tolerance, LIKELY * chance):
                size *= GROW
            floor = 0.0 if miss <= allowed else min(miss / BETTER, floor or math.inf)
            longer = math.inf
            reached = Reached(turns, error, size, miss, floor)
            self._keep(stage, outlines, measured, values, reached, changes)
        self.progress(1.0, f"stage {stage} is done")
        return Life(self.folder)

    def _evenly(self, change: np.ndarray, turns: float, before: tuple | None) -> bool:
        """True where a change goes on as the one before. Linear jumps stand as they are."""
        foretold = untold(change, turns, before) <= FORETOLD * np.abs(change).max()
        return foretold and self.plan.jump == "replay"

    def _first(self, outlines: dict[str, Worn]) -> dict[str, Measured]:
        for text in (text for joint in self.joints.values() for text in joint.doubts()):
            LOG.warning("%s", text)
        measured, values = self.stage(0, outlines)
        for name, of_joint in measured.items():
            if (
                self.plan.jump == "replay"
                and not len(of_joint.path)
                and any(r.any() for r in of_joint.rate.values())
            ):
                raise ValueError(
                    f"joint {name}: its law of wear is not linear in the pressure; take jump=linear"
                )
            self._check_turn(name, of_joint)
            if not any(rate.any() for rate in of_joint.rate.values()):
                LOG.warning("joint %s: nothing wears; its solids do not touch in a turn", name)
        first = Reached(turns=0.0, error=0.0, jump=self.plan.turns)
        self._keep(0, outlines, measured, values, first)
        return measured

    def _check_turn(self, name: str, measured: Measured) -> None:
        """Raise ValueError where one turn deepens a scar by more than a jump may."""
        most = self.plan.share * self.joints[name].clearance
        for surface, rate in measured.rate.items():
            if rate.max() > most:
                turn = f"the first turn wears its {surface} {rate.max():.3g} m deep"
                share = f"share = {self.plan.share:g} of the clearance is {most:.3g} m"
                raise ValueError(
                    f"joint {name}: {turn}, and {share}: no jump is that short; look at the unit "
                    f"of its coefficient, or allow a larger share"
                )

    def _resumed(self) -> tuple:
        """Outlines, turns, error and next jump of the last stage in the journal, its number, and
        what the jump to it has changed.
        """
        changes: dict[str, tuple | None] = dict.fromkeys(self.joints)
        if not self.journal:
            return self._unworn(), 0.0, 0.0, self.plan.turns, -1, changes
        last = self.journal[-1]
        arrays = self._arrays(last["stage"])
        outlines = {}
        for name, joint in self.joints.items():
            depths = {s: arrays[f"{name}/{s}"] for s in SURFACES}
            numbers = Outline(None, depths).numbers
            outlines[name] = Worn.of(numbers, np.zeros((0, 6)), joint.wear_journal is not None)
            if f"{name}/change" in arrays:
                done = last["turns"] - self.journal[-2]["turns"]
                changes[name] = arrays[f"{name}/change"], done
        self.average = last["average"]
        LOG.info("going on from %.6g turns", last["turns"])
        return outlines, last["turns"], last["error"], last["jump"], last["stage"], changes

    def _unworn(self) -> dict[str, Worn]:
        """Outlines to begin with."""
        empty = np.zeros((0, 6))
        numbers = {n: Outline(None, j.outline.parameters).numbers for n, j in self.joints.items()}
        return {
            n: Worn.of(outline, empty, self.joints[n].wear_journal is not None)
            for n, outline in numbers.items()
        }

    def _measured(self, stage: int) -> dict[str, Measured]:
        arrays = self._arrays(stage)
        scatter = self.journal[-1]["scatter"]
        spread = self.journal[-1].get("spread", scatter)
        joints = {}
        for name, joint in self.joints.items():
            rate = {s: arrays[f"{name}/{s}/turn"] for s in _wears(joint)}
            joints[name] = Measured(rate, scatter[name], arrays[f"{name}/path"], spread[name])
        return joints

    def _keep(self, stage: int, outlines, measured, values, reached: Reached, changes=None) -> None:
        """A stage is over: its arrays, then its line in the journal."""
        arrays = {f"{name}/change": change for name, change in (changes or {}).items()}
        for name, of_joint in measured.items():
            arrays |= {f"{name}/{s}": d for s, d in _depths(outlines[name]).items()}
            arrays |= {f"{name}/{s}/turn": rate for s, rate in of_joint.rate.items()}
            arrays[f"{name}/path"] = of_joint.path
        path = self.folder / f"stage-{stage:04d}.npz"
        with replacing(path) as temporary, open(temporary, "xb") as file:
            np.savez_compressed(file, **arrays)
        entry = {
            "stage": stage,
            **reached._asdict(),
            "average": self.average,
            "scatter": {n: m.scatter for n, m in measured.items()},
            "spread": {n: m.spread for n, m in measured.items()},
            "metrics": {n: m.value for n, m in values.items()},
            "made": self.inputs,
        }
        if stage == 0:
            entry["known"] = described(values)
        with open(self.folder / "journal.jsonl", "ab", opener=opener) as file:
            file.write(f"{signed(entry)}\n".encode())
            file.flush()
            os.fsync(file.fileno())

    def _check_walls(self, outlines: dict[str, Worn], turns: float) -> None:
        """Raise ValueError where a surface is worn through."""
        for name, outline in outlines.items():
            wall = layer_of(self.joints[name])
            for surface, depth in _depths(outline).items():
                if depth.max() > wall:
                    deep = f"its {surface} is worn {depth.max():.4g} m deep after {turns:.6g} turns"
                    through = (
                        f"through its wall of {wall:.4g} m (layer, default half the journal radius)"
                    )
                    raise ValueError(f"joint {name}: {deep}, {through}")


def _wears(joint) -> list[str]:
    """Surfaces of a joint that wear."""
    return [
        s
        for s, law in zip(SURFACES, (joint.wear, joint.wear_journal), strict=True)
        if law is not None
    ]


def _law_for(scene: Scene) -> str:
    """A law of wear as the author of a scene writes it: parameter, scene file or Python."""
    case = vars(scene).get("case")
    if case is not None and "wear" in case.parameters:
        return "wear=1e-4mm3/Nm"
    if case is not None and case.path is not None and case.path.suffix == ".toml":
        return 'wear = { law = "archard", coefficient = "1e-4 mm3/Nm" } in its table'
    return "wear=cl.archard(coefficient=1e-13)"


def _check_law(joint) -> None:
    """Raise ValueError for a law that wears nothing: its life would be a row of zeros."""
    for slot, law in (("wear", joint.wear), ("wear_journal", joint.wear_journal)):
        if law is not None and not law(1e6, 1.0) > 0.0:
            numbers = ", ".join(f"{n}={v:g}" for n, v in law.values.items())
            raise ValueError(
                f"{joint.label()}: {slot} {law.law.name}({numbers}) wears nothing: a pressure of "
                f"1 MPa at 1 m/s gives {law(1e6, 1.0):g} m/s; leave it out or give it a coefficient"
            )


def _shifts(joint, result: Result) -> np.ndarray:
    """Way of the journal from its place in a stage to where it has the same force on the present
    outline of the joint [m]. Of the last three samples, the latest first, (3, 2).
    """
    channels, facts = result.joint(joint.name), result.facts(f"joints/{joint.name}/wear")
    ran_on = {surface: facts[f"depth_{surface}"] for surface in SURFACES}
    outlines = [Outline(None, depths).numbers for depths in (ran_on, joint.outline.parameters)]
    angles = [
        np.zeros(3) if body == ground else result[body.name].theta[-3:] for body in joint.bodies()
    ]
    columns = channels.eccentricity_x[-3:], channels.eccentricity_y[-3:], *angles
    shifts = []
    for x, y, turn, journal in np.transpose(columns)[::-1].tolist():
        cos, sin = math.cos(turn), math.sin(turn)
        here = cos * x + sin * y, cos * y - sin * x
        new = moved(*here, journal - turn, joint.clearance, *outlines, solids_of(joint))
        dx, dy = new[0] - here[0], new[1] - here[1]
        shifts.append((cos * dx - sin * dy, cos * dy + sin * dx))
    return np.array(shifts)


def _depths(outline: Worn) -> Arrays:
    return {"bearing": outline.bearing, "journal": outline.journal}


def _spread(depths: list[np.ndarray]) -> float:
    """Standard error of the mean of depths, largest over the angle, over the largest mean."""
    smooth = np.array([smoothed(depth) for depth in depths])
    largest = float(smooth.mean(axis=0).max())
    error = float(smooth.std(axis=0, ddof=1).max()) / math.sqrt(len(depths))
    return error / largest if largest > 0.0 else 0.0


def _chance(before: dict[str, Measured], after: dict[str, Measured]) -> float:
    """Largest difference of two stages' wear of a turn by chance."""
    return CHANCE * max(math.hypot(before[n].spread, later.spread) for n, later in after.items())


def _missed(
    before: dict[str, Worn], jumped: dict[str, Worn], instead: dict[str, Worn]
) -> tuple[float, Arrays]:
    """Largest difference of two jumps from the same outlines, over the largest depth; and by joint
    that of each surface [m] over the angle, (surfaces, NODES).
    """
    share, changes = 0.0, {}
    for name, begin in before.items():
        first, second = (_grown(begin, w[name]) for w in (jumped, instead))
        changes[name] = second - first
        apart, deepest = np.abs(changes[name]).max(axis=1), np.maximum(first, second).max(axis=1)
        share = max([share, *(a / d for a, d in zip(apart, deepest, strict=True) if a > 0.0)])
    return share, changes


def _grown(begin: Worn, worn: Worn) -> np.ndarray:
    """Depths worn off since, over neighbouring nodes [m], (surfaces, NODES)."""
    pairs = zip(_depths(begin).values(), _depths(worn).values(), strict=True)
    return np.array([smoothed(new - old) for old, new in pairs])
