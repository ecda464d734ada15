"""Points of one structure, one after another in one memory, without a scene for each.

The numbers of their starts come as arrays (lanes/point_numbers.py). One point is run the ordinary
way, and what its metrics look at is noted: the others have no other outputs. They take the same
steps by the same loop, and their metrics come from the same functions: they are those of the
ordinary way bit for bit. Some points are `RunAlone` and run the ordinary way. They fail, carry a
warning, need more than their family has, or end for another reason than the family's joints.
"""

import copy
import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from clearance.elements.joint import Joint
from clearance.elements.regimes import (
    DEEPEST,
    FULL_FILM,
    Regime,
    layer_of,
    oedometric_modulus,
    regime,
)
from clearance.lanes.point_numbers import NotForLanes, PointNumbers, leaves_of
from clearance.machine.callback import Callback
from clearance.mechanism.build import Mechanism, acceleration_of, energy_of
from clearance.metrics.metrics import Metric
from clearance.metrics.of_points import of_point
from clearance.results.extremes import Extremes, stretch_length
from clearance.results.integrals import Integrals
from clearance.results.memory import CONTACT_KINDS, EVENT_COLUMNS, Memory, MemoryRecord
from clearance.results.samples import Samples
from clearance.run.diagnosis import Diagnosis, doubtful
from clearance.run.ideal_motion import rate_of, stretched, unit_motion
from clearance.run.options import Span, longest_step
from clearance.run.recording import attributes_of, record_run
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.simulation import prepare
from clearance.stepping import status
from clearance.stepping.state import LOG_COLUMNS

MOST = 4_000_000  # numbers of a run's output that a family keeps
#: parts of the paths of outputs that every run is judged by
JUDGED = ("energy/", "/mode", "/sliding_speed", "/friction")


class RunAlone(Exception):
    """This point must be run the ordinary way."""


class Noted(MemoryRecord):
    """The same run in memory; it notes at which channels somebody looks."""

    def __init__(self, record: MemoryRecord):
        inner = ("_samples_taken", "_facts", "_channels_by_path", "_groups")
        outer = ("events", "attributes", "solver", "warnings", "located", "integrals")
        vars(self).update({name: vars(record)[name] for name in inner + outer})
        self.looked: set[str] = set()

    def values(self, path):
        """The channel; its path is noted."""
        self.looked.add(path)
        return super().values(path)


class Part(MemoryRecord):
    """A run in memory with the channels that its metrics read."""

    def __init__(
        self,
        groups: dict,
        channels: dict,
        scene: dict,
        attributes: dict,
        times,
        rows,
        events: dict,
        located: Extremes,
        integrals: Integrals,
    ):
        vars(self).update(_groups=groups, _channels_by_path=channels, scene=scene, _times=times)
        self._samples_taken = Samples.of(times, rows)
        self.events, self.located, self.integrals = events, located, integrals
        self.attributes = attributes


class Ended:
    """A run that has ended and its record, as a diagnosis sees them."""

    outputs, last = True, None

    def __init__(self, run: Run, mechanism: Mechanism, extremes: Extremes, last: tuple):
        self.mechanism, self.solver, self.method = mechanism, run.solver, run.method
        self.loop, self.state, self.extremes, self.last = run.loop, run.state, extremes, last
        self.channels = run.mechanism.layout.channels

    def extreme(self, name: str) -> float:
        """Largest or smallest value of a watched quantity."""
        return self.extremes.of(name).value

    def residual_share(self) -> float:
        """None is missing: that has been seen to."""
        return 0.0

    def regime(self, joint, pressure: float, gap: float) -> Regime:
        """Diagnostics of a lubricated joint."""
        return regime(joint, pressure, gap)


@dataclass(frozen=True)
class PointMetrics:
    """Numbers of one point: metrics by name, their units and texts, warnings, steps, seconds in the
    compiled loop, digest of its structure.
    """

    metrics: dict[str, float]
    known: dict[str, tuple[str, str]]
    warnings: int
    steps: int
    loop: float
    text: str


class Family:
    """Runs of one structure in one memory. Raises NotForLanes where they cannot be had.

    scene: gives the scene of swept values; columns: all values of the swept numbers by name;
        options: of the runs, as of `prepare`; settle: as of `of_point`.
    """

    def __init__(
        self,
        scene: Callable[[dict], Scene],
        columns: dict[str, np.ndarray],
        options: dict,
        settle: float | None,
    ):
        self.scene_of, self.turns, self.settle = scene, options.get("turns"), settle
        self.judged: list[tuple] = []

        def noted(values: dict) -> Run:
            run = prepare(scene(values), **options)
            self.judged.append(_limits(run))
            return run

        self.spread = PointNumbers(scene, noted, columns)
        first = self.spread.run
        _check(first, self.turns)
        self.alike = all(shared == self.judged[0][0] for shared, _ in self.judged)
        self.deepest = {j: min(depths[j] for _, depths in self.judged) for j in self.judged[0][1]}
        self._describe(first.mechanism)
        self.motion = unit_motion(first.mechanism.scene, first.span, self.scene)
        record = _recorded(first)
        structure = first.mechanism.structure
        self.part = structure.observing(self._looked_at(record) | _watched(first))
        self.groups, self.digest = record._groups, structure.digest
        self.channels = {c.path: (i, c) for i, c in enumerate(self.part.layout.channels)}
        self._take_memory()
        self.labels = self.run.labels()
        self.joints = first.mechanism.scene.clearance_joints
        #: dry joints alone: no warnings but those of laws, of depths and of the method
        self.plain = all(
            j.film is None and j.transition is None and type(j).at_end is Joint.at_end
            for j in self.joints
        )
        self.doubts = sum(len(j.doubts()) for j in first.mechanism.scene.joints)
        self.known = {n: (m.units, m.text) for n, m in self._metrics(record).items()}

    def _take_memory(self) -> None:
        """The run that all points are, with its mechanism."""
        first = self.spread.run
        mechanism = Mechanism(
            **{n: getattr(first.mechanism, n) for n in Mechanism.__dataclass_fields__}
        )
        mechanism.structure, mechanism.par = self.part, mechanism.par.copy()
        self.mechanism, self.run = mechanism, Run(mechanism, first.span, first.solver)
        self.image = self.run.state.memory.tobytes()

    def twin(self) -> "Family":
        """The same family with a memory of its own, for another thread."""
        family = copy.copy(self)
        family._describe(self.spread.run.mechanism)
        family._take_memory()
        return family

    def _metrics(self, record: MemoryRecord) -> dict[str, Metric]:
        """Metrics of a record of the scene that is described."""
        return of_point(record, self.settle, stretched(self.motion, rate_of(self.scene)))

    def _describe(self, mechanism: Mechanism) -> None:
        """The description of a scene whose varying numbers can be set, and their places."""
        self.scene, leaves = _open(mechanism.scene.description()), []
        self.attributes = {"status": "complete", "first_touch": mechanism.scene.first_touch}
        for path, value in leaves_of(self.scene):
            if type(value) is float:
                leaves.append(path)
        varying = self.spread.varying("leaves")
        if self.spread.moves:
            raise NotForLanes("the ideal motion depends on what is swept")
        self.leaves = [(i, _container(self.scene, leaves[i]), leaves[i][-1]) for i in varying]

    def _looked_at(self, record: MemoryRecord) -> set[str]:
        """Paths of the channels that the metrics of a run look at."""
        noted = Noted(record)
        self._metrics(noted)
        return noted.looked

    # --- points
    def found(self, columns: dict[str, np.ndarray]) -> list[PointMetrics | None]:
        """Numbers of points, from their swept numbers; None for those that must be run the ordinary
        way.
        """
        has = self.spread.has(columns)
        points: list[PointMetrics | None] = [None] * has.size
        if not has.any():
            return points
        starts = self.spread.starts({n: column[has] for n, column in columns.items()})
        for k, i in enumerate(np.flatnonzero(has).tolist()):
            start = {n: v[k] for n, v in starts.items()}
            values = {n: column[i].item() for n, column in columns.items()}
            with suppress(Exception):  # the ordinary way gives the reason
                points[i] = self._point(start, values)
        return points

    def _point(self, start: dict[str, np.ndarray], values: dict[str, float]) -> PointMetrics:
        """Run a point. Raises RunAlone, and what a law raises."""
        run, state = self.run, self.run.state
        self._begin(start)
        began = time.perf_counter()
        pieces = self._pieces()
        loop = time.perf_counter() - began
        times, rows, impacts, log = (np.concatenate(p) for p in zip(*pieces, strict=True))
        self._check_ledger(pieces[0][3], log, rows)
        if not np.isfinite(rows).all():
            raise RunAlone
        extremes, events = run.watched.extremes(state), self._events(impacts)
        output = times, rows, events, extremes, run.integrals
        record = Part(self.groups, self.channels, self.scene, self.attributes, *output)
        metrics = {name: m.value for name, m in self._metrics(record).items()}
        warnings = self._warnings(extremes, (times[-1], rows[-1]), values)
        return PointMetrics(metrics, self.known, warnings, int(state.steps), loop, self.digest)

    def _begin(self, start: dict[str, np.ndarray]) -> None:
        """Put the run to the start of a point."""
        run, mechanism, state = self.run, self.mechanism, self.run.state
        state.restore(self.image)
        numbers = start["numbers"]
        mechanism.par[: numbers.size] = numbers
        with np.errstate(all="ignore"):
            mechanism.structure.derive(mechanism.par)
        turn, until, frequency, size, mass = start["scalars"].tolist()
        sizes, p = start["sizes"], mechanism.coordinates
        vars(mechanism).update(
            y0=start["state"],
            work0=start["work"],
            reach=start["reach"],
            frequency=frequency,
            energy=energy_of(mass, size, frequency),
            acceleration=acceleration_of(size, frequency, mechanism.scene.gravity),
            scale=np.concatenate([sizes[:p], sizes[:p] * frequency, sizes[p:]]),
        )
        mechanism.blend()
        run.span = Span(self.turns * turn if turn else until, run.span.samples)
        run.take_numbers()
        run.watched.measure(state, stretch_length(run.span.until, turn or None))
        state.longest_step = run.solver.max_step or longest_step(mechanism, run.span, turn)
        state.end = run.span.until
        for i, container, key in self.leaves:
            container[key] = float(start["leaves"][i])

    def _pieces(self) -> list[tuple[np.ndarray, ...]]:
        """Run to the end: times, rows, contacts and steps, piece by piece."""
        run, state, pieces, code = self.run, self.run.state, [], status.RUNNING
        while code == status.RUNNING:
            code = run.loop.run(state.address, run.budget)
            rows = state.rows_filled
            pieces.append(
                (
                    state.times[:rows].copy(),
                    state.rows[:rows].copy(),
                    state.impacts[: state.impacts_filled].copy(),
                    state.log[: state.log_filled].copy(),
                )
            )
            state.rows_filled = state.impacts_filled = state.log_filled = 0
        if code != status.DONE:
            raise RunAlone
        return pieces

    def _check_ledger(self, first: np.ndarray, log: np.ndarray, rows: np.ndarray) -> None:
        """Raise RunAlone unless the energy ledger closes for certain.

        No stretch of a run that is judged turns over less than the range of the kinetic energy in
        the first piece.
        """
        if not (energies := len(self.run.watched.ledger)):
            return
        kinetic, residual = first[:, LOG_COLUMNS], log[:, LOG_COLUMNS + energies - 1]
        moved, turned = np.ptp(residual), np.ptp(kinetic)
        start = rows[0, self.channels["energy/residual"][0]]
        moved = max(moved, np.abs(residual - start).max())
        doubt = doubtful(self.run.solver.rtol)
        if not (np.isfinite(log).all() and moved <= doubt * turned):
            raise RunAlone

    def _events(self, impacts: np.ndarray) -> dict[str, np.ndarray]:
        """Contacts as a record has them: those that are over, then those that the end cuts off."""
        table = np.concatenate([impacts, self.run.open_contacts().reshape(-1, impacts.shape[1])])
        events = {n: table[:, i] for i, n in enumerate(EVENT_COLUMNS, 1)}
        events["joint"] = np.array([self.labels[int(j)] for j in table[:, 0]], dtype=str)
        cut_off = len(table) - len(impacts)
        events["kind"] = np.repeat(CONTACT_KINDS, [len(impacts), cut_off])
        return events

    def _warnings(self, extremes: Extremes, last: tuple, values: dict[str, float]) -> int:
        """Number of warnings of the run; its scene is made only where they may depend on more than
        all share.
        """
        mechanism = self.mechanism
        if not self.alike or any(self._near_a_limit(j, extremes) for j in self.joints):
            mechanism = copy.copy(mechanism)
            mechanism.scene = self.scene_of(values)
        elif self.plain and self._moves_on():
            return self.doubts
        ended = Ended(self.run, mechanism, extremes, last)
        return len(Diagnosis(ended, ended).warnings())

    def _moves_on(self) -> bool:
        """True for a run that is not held up by stability and does not stand still."""
        state, rates = self.run.state, self.mechanism.layout.rates
        held_up = state.stiff_steps >= self.run.loop.STIFF_ENOUGH
        return not held_up and bool(state.f[: rates.stop].any())

    def _near_a_limit(self, joint: Joint, extremes: Extremes) -> bool:
        """True where surfaces come so near or so deep that numbers of the joint decide on a
        warning.
        """
        gap = extremes.of(f"{joint.key}/gap_min").value
        rough = joint.transition is not None and gap < FULL_FILM * (joint.roughness or 0.0)
        return rough or -gap > self.deepest[joint.key]


def _limits(run: Run) -> tuple[tuple, dict[str, float]]:
    """Numbers of joints that warnings depend on, and depths that no warning is about [m]."""
    mechanism, shared, depths = run.mechanism, [], {}
    for joint in mechanism.scene.joints:
        shared.append(len(joint.doubts()))
        if joint not in mechanism.scene.clearance_joints:
            continue
        if joint.film is not None and joint.film_joint is not None:
            modulus = oedometric_modulus(joint.material.young, min(joint.material.poisson, 0.49))
            shared += [
                layer_of(joint),
                modulus,
                joint.lubricant.pressure_viscosity,
                joint.roughness,
            ]
        depths[joint.key] = math.inf
        if joint.contact is not None:
            limit = joint.contact.law.limit
            most = limit(joint.contact.values) if limit is not None else math.inf
            depths[joint.key] = min(DEEPEST * joint.solid[0], most)
    return tuple(shared), depths


def _check(run: Run, turns: float | None) -> None:
    """Raise NotForLanes for runs that cannot share a memory."""
    mechanism, layout = run.mechanism, run.mechanism.layout
    if (
        any(isinstance(source, Callback) for source in mechanism.sources.values())
        or layout.remembering
    ):
        raise NotForLanes("a film is solved as the run goes or remembers")
    if (turns is None) == (mechanism.scene.turn is not None):
        raise NotForLanes("its runs are not so many turns long")
    if layout.followed:
        raise NotForLanes("its joints wear")
    if not mechanism.size:
        raise NotForLanes("nothing is free to move")
    if mechanism.structure.forced:
        raise NotForLanes("friction without clearance is judged run by run")
    if mechanism.scene.kinks:
        raise NotForLanes("a law of time has a kink")
    if run.span.samples * len(layout.channels) > MOST:
        raise NotForLanes("its runs are too long")


def _recorded(run: Run) -> MemoryRecord:
    """A run as it is recorded the ordinary way."""
    sink = Memory(run.mechanism.layout.channels, attributes_of(run))
    if (failure := record_run(run, sink)) is not None:
        raise NotForLanes(f"its middle point fails: {failure}")
    return sink.record


def _watched(run: Run) -> set[str]:
    """Paths of the channels that the loop looks at where steps end, and of those that every run is
    judged by.
    """
    channels = run.mechanism.layout.channels
    places = {index for row in run.watched.rows for index in (row[0], row[0] + row[1])}
    places |= {integrand.channel for integrand in run.watched.integrands}
    judged = {c.path for c in channels if any(part in c.path for part in JUDGED)}
    return {channels[index].path for index in places} | judged


def _open(value: object) -> object:
    """A description whose entries can be set."""
    if isinstance(value, dict):
        return {key: _open(entry) for key, entry in value.items()}
    return [_open(entry) for entry in value] if isinstance(value, list | tuple) else value


def _container(description: object, path: tuple) -> object:
    """The list or dictionary that an entry stands in."""
    for key in path[:-1]:
        description = description[key]
    return description
