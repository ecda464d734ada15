"""A run to its end, recorded: into a sink, or in memory."""

import json
import logging
import time as clock
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from clearance.results.extremes import Extremes, Integrals
from clearance.results.recorder import Memory, MemoryRecord, Recorder
from clearance.results.stream import Unwritable
from clearance.run.diagnosis import Diagnosis
from clearance.run.interrupts import DeferredSignals, ended
from clearance.run.observers import Interrupts, Observer, Progress
from clearance.run.run import Run
from clearance.run.start import end_state
from clearance.stepping import status
from clearance.stepping.state import TOUCHING
from clearance.values.later import Later

LOG = logging.getLogger("clearance")
# tolerances, and share, of the energy that count as turned over in a motion that turns over less:
# then a residual of one tolerance is below diagnosis.doubtful
COASTING, LEAST = 1e3, 1e-3
COUNTERS = ("steps", "rejected", "evaluations", "jacobians", "factorisations")


class Recording(Observer):
    """Hands the output to a recorder as long as it is finite; the diagnosis judges it."""

    def __init__(self, run: Run, recorder: Recorder):
        self.recorder = recorder
        self.diagnosis = Diagnosis(run, recorder)
        self.contacts = recorder.impacts

    def steps(self, log):
        """Record them; the diagnosis looks at them again where something is wrong."""
        self.diagnosis.remember(log)
        self.recorder.steps(log)

    def samples(self, times, rows):
        """Record those before the first that is not finite."""
        good = len(rows)
        if not np.isfinite(rows).all():
            good = int(np.isfinite(rows).all(axis=1).argmin())
            self.diagnosis.spoil(times[: good + 1], rows[good])
        self.recorder.samples(times[:good], rows[:good])

    def piece(self, run, code):
        """Write, then judge."""
        self.recorder.flush()
        return self.diagnosis.judge(code)


def record_run(
    run: Run,
    sink,
    progress: Callable[[float], None] | None = None,
    checkpoint: float | None = None,
    check: Callable[[], None] = lambda: None,
) -> str | None:
    """Run to the end, handing the output to a sink; why it ended early, if it did.

    checkpoint: seconds of wall time between two checkpoints, for a sink that keeps them. check:
        called after each piece of output, raises KeyboardInterrupt where the run shall end.
    Raises Unwritable where a file takes no more; like an interrupt it comes when what was computed
    before is stored, if it can be.
    """
    run.method.paced = True
    _sum_wear(run)
    scale = max(COASTING * run.solver.rtol, LEAST) * run.mechanism.energy
    layout = run.mechanism.layout
    recording = Recording(run, Recorder(layout.channels, sink, True, scale, layout.output))
    watching = [recording, Interrupts(check)]
    if progress is not None:
        watching.append(Progress(progress))
    if checkpoint is not None:
        from clearance.run.checkpoint import Checkpoints, restore

        if (before := sink.begin()) is not None:
            restore(run, recording, sink, before)
            LOG.info("going on from t = %.6g s", run.state.time)
        watching.append(Checkpoints(sink, recording, checkpoint))
    run.observers[:0] = watching
    began, failure = clock.perf_counter(), None
    try:
        if (code := run.go()) != status.DONE:
            failure = recording.diagnosis.failure(code)
    except KeyboardInterrupt as request:
        failure = f"{ended(request)} at t = {run.state.time:.9g} s"
        raise
    except Unwritable as error:
        failure = f"at t = {run.state.time:.9g} s: {error}"
        raise
    finally:
        done = run.code == status.DONE
        finished = "complete" if done else f"partial: {failure or 'stopped by an error'}"
        _close(run, recording, finished, clock.perf_counter() - began)
    return failure


def remember_run(run: Run, attributes: dict | None = None) -> tuple[MemoryRecord, str | None]:
    """Run to the end in memory: the record, and why it ended early, None where it did not.

    attributes: of the record, default those of this run.
    """
    sink = Memory(
        run.mechanism.layout.channels, attributes_of(run) if attributes is None else attributes
    )
    with DeferredSignals() as held:
        failure = record_run(run, sink, check=held.check)
    return sink.record, failure


def attributes_of(run: Run, **more: str) -> Mapping:
    """Attributes of the result file: scene, kernel, start, options, and more."""
    mechanism = run.mechanism
    roles = tuple(run.method.roles)
    started = run.started
    options = dict(run.options)

    def text() -> str:
        return "\n\n".join(mechanism.structure.texts[r] for r in roles)

    def attributes() -> dict:
        kernel = mechanism.remembered(("text", *roles), text)
        about = {"kernel": kernel, "start": started, "options": json.dumps(options)}
        return mechanism.scene.provenance | about | more

    return Later(attributes)


def _sum_wear(run: Run) -> None:
    """Let the wear of joints be summed, unless it is."""
    if run.mechanism.layout.followed and run.wearing is None:
        from clearance.run.wear_sum import Wearing

        run.wearing = Wearing(run)
        run.observers.append(run.wearing)


def _close(run: Run, recording: Recording, finished: str, wall: float) -> None:
    """End the record; finished: its status. What few look at is made where somebody does."""
    recorder = recording.recorder
    diagnosis = recording.diagnosis
    end = run.at_end()
    if run.state.contacts[:, TOUCHING].any():
        recorder.impacts(run.labels(), run.open_contacts(), "open_contact")
    for joint, source in run.mechanism.sources.items():
        recorder.add_facts(f"joints/{joint.name}", **source.facts())
    if run.wearing is not None:
        run.wearing.add_facts(recorder)
    if run.changes:
        times, changes = zip(*run.changes, strict=True)
        recorder.add_facts(
            "changes",
            times=np.array(times),
            numbers=[json.dumps(c, sort_keys=True) for c in changes],
        )
    for group, facts in run.facts.items():
        recorder.add_facts(group, **facts)
    run.warnings = diagnosis.warnings() if run.warned else []
    solver = Later(partial(_summary, end, recorder, wall))
    recorder.close(finished, run.warnings, solver, partial(_located, end, diagnosis.regimes))


def _located(run: Run, regimes: list, recorder: Recorder) -> tuple[Extremes, Integrals]:
    """Facts of a run at its end, and its located extremes and integrals."""
    scene, sooner = run.mechanism.scene, recorder.facts
    here = run.mechanism, run.state.y, run.state.work, run.state.time, run.state.turned[:, 0]
    recorder.facts = {}
    for groups in (scene.facts, sooner, {"state": end_state(*here)}):
        for group, facts in groups.items():
            recorder.add_facts(group, **facts)
    for joint, regime in regimes:
        recorder.know_regime(joint, regime)
    return run.extremes, run.integrals


def _summary(run: Run, recorder: Recorder, wall: float) -> dict:
    """Numbers of the integration."""
    return {
        "method": run.method.text,
        "method_reason": run.method.reason,
        "rtol": run.solver.rtol,
        "atol": run.rtol * np.maximum(run.state.scale[: run.mechanism.size], 0.0),
        "wall_s": wall,
        "loop_s": run.wall,
        **{name: getattr(run.state, name) for name in COUNTERS},
        "energy_residual_share": recorder.residual_share(),
    }
