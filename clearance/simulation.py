"""The one simulate call: scene in, result file out.

Not called simulate.py: a module of that name would hide the function cl.simulate.
"""

import logging
import shutil
import warnings
import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from clearance.accuracy.companion import Pair, Statement, add_errors, reason_without
from clearance.files.locks import temporary_file
from clearance.machine.callback import Callback
from clearance.mechanism.build import Mechanism, build
from clearance.metrics.metrics import metrics
from clearance.results.errors import AUTO, asks
from clearance.results.record import Record, warn
from clearance.results.result import MemoryResult, Result
from clearance.results.short_file import ShortFile
from clearance.results.stream import Content, Stream, Unwritable, matching
from clearance.run.interrupts import DeferredSignals
from clearance.run.options import (
    SAMPLES_PER_TURN,
    Demand,
    Output,
    Solver,
    Span,
    affordable,
    check_settle,
    longest_step,
    span_of,
)
from clearance.run.progress_bar import watched
from clearance.run.recording import attributes_of, record_run
from clearance.run.run import Run
from clearance.run.start import opened_by
from clearance.scene.scene import Scene, idealised

if TYPE_CHECKING:  # what few runs need
    from clearance.accuracy.request import Outcome, Request
    from clearance.run.checkpoint import PartsSink

    Sink = Stream | PartsSink | ShortFile

LOG = logging.getLogger("clearance")
BRIEF = 0.01  # seconds of a motion where nothing turns
SHORT = 1_000_000  # largest count of numbers of a run that is held in memory until its end


class SimulationError(RuntimeError):
    """A run failed part-way. `result` holds what had been computed; None where no file of it could
    be stored. Its warnings are notes of the error.
    """

    def __init__(self, message: str, result: Result | None):
        super().__init__(message)
        self.result = result
        for warning in getattr(result, "warnings", ()):
            self.add_note(f"warning: {warning}")


class NotReached(SimulationError):
    """An error that was requested cannot be reached. `result` is the best run, with what it has
    reached.
    """


@watched
def simulate(
    scene: Scene,
    *,
    turns: float | None = None,
    until: float | None = None,
    rtol: float = 1e-6,
    method: str = "auto",
    samples_per_turn: int = SAMPLES_PER_TURN,
    samples: int | None = None,
    path: str | Path | None = None,
    energy: bool = True,
    max_step: float | None = None,
    max_steps: int | None = None,
    channels: Sequence[str] | None = None,
    compression: int = 0,
    checkpoint: float | None = None,
    force: bool = False,
    progress: Callable[[float], None] | bool | None = None,
    start: Record | str | Path | None = None,
    pressure_fields: int | None = None,
    error: str | float | Mapping[str, float] | None = AUTO,
    settle: float | None = None,
    sensitivity: str | Iterable[str] | Mapping[str, float | None] | None = None,
) -> Result:
    """Integrate a scene and return its result.

    turns: length in turns of the constant-speed drive, or until: seconds. rtol: local error
        tolerance, relative to the natural size of each state (clearance for eccentricities) plus
        its value. method: "auto" takes dop853 where no film makes the scene stiff, else the
        implicit method that is fastest at this rtol. Others are "dop853" (explicit, order 8),
        "rodas5p" (linearly implicit, order 5), "radau5", "radau9" (implicit, order 5 and 9) and
        "radau" (one of these two, by rtol). samples_per_turn (in all, where nothing turns evenly)
        or samples (in all): output rows.
    path: write the HDF5 file there. That of a short run is written at its end. Without a path a
        short result stays in memory, a large one in a temporary file, see Result.save.
        energy: integrate the energy ledger. max_step: longest step [s] (default a 24th of a turn,
        or of the span); give one where loads act more briefly than that. max_steps: give up after
        so many. progress: called with the done share of the span; by default
        a bar stands in terminals and notebooks after a second, False: none.
    channels: paths or patterns of the stored output, such as "bodies/slider/ax", "joints/B/*" or
        "solver", the log of steps (default all; the events are always stored);
    compression: gzip level of the file's columns (0: none). checkpoint: seconds of wall time
        between checkpoints beside the file: the same call goes on from the last one after a crash,
        and gives the same file. force: begin although the run needs more than 2^31 rows, a day or
        the free disk (see run/options.py).
    start: the result of another run (or the path of its file), at whose end this one begins; its
        scene must have the same states. Or "quasi-static": journals at rest where their films carry
        the joint forces. Default: the start of the scene.
    pressure_fields: number of pressure fields of its films in the file, for each turn (of the run,
        where nothing turns). They are solved after the run from its motion, see
        run/pressure_fields.py. The default is none.
    error: "auto" states the distance of the numbers from those of an exact integration, from a
        second run at ten times the tolerance (`Result.errors`). It does not where trajectories may
        part at impacts. "state" also states it where the second run costs as much again: films that
        are solved during the run, runs with checkpoints. None: not.
    1e-3, "5%" or {"joint_B_force_max": 1e-4, "trajectory": 1e-5} makes the cheapest run whose
    stated errors are that small, whatever rtol is. They are of all that `clearance run` prints, or
    of metrics, extremes or the trajectory (over the clearance) by name. "integration" is that of
    all, the errors of film tables left aside.
    settle: turns (seconds, where nothing turns) left out of the metrics whose errors are stated
        (default one of two).
    sensitivity: parameters by which the metrics are differentiated, such as "clearance,viscosity"
        of a case, "joints/B/clearance" of any scene (`Result.sensitivities`, see
        accuracy/by_differences.py). One that is 0 needs a size: {"load": 1.0}.
    Raises ValueError for bad arguments and impossible scenes before anything runs.
    Raises SimulationError for a run that fails part-way, also where the disk is full: the message
    has time, joint and state, and the partial result is attached.
    Raises NotReached, with the best run, for a requested error that cannot be reached.
    Raises KeyboardInterrupt once the results so far are stored, with a note of the place.
    Warns once, by `RunWarning`, where the result has warnings.

    Example:

        >>> run = cl.simulate(cl.load_case("slider_crank", model="ideal"), turns=1)
        >>> run.complete, run["slider"].ax.shape
        (True, (401,))
    """
    request = _request(error, checkpoint)
    output = Output(path, channels, compression, checkpoint, pressure_fields)
    if pressure_fields is not None:
        from clearance.run.pressure_fields import check

        check(scene.description(), pressure_fields, channels)
    prepared = partial(
        prepare,
        scene,
        None if force else partial(_affordable, output),
        turns=turns,
        until=until,
        rtol=rtol,
        method=method,
        samples_per_turn=samples_per_turn,
        samples=samples,
        energy=energy,
        max_step=max_step,
        max_steps=max_steps,
        start=start,
    )
    sensing = None if sensitivity is None else _sensing(scene, sensitivity, prepared, settle)
    run = prepared(opened=_opened(path, checkpoint))
    check_settle(scene, settle, run.span.until)
    if sensing:
        sensing.check(run)
    matching(run.mechanism.layout.channels, channels)
    for warning in hole_warnings(run.mechanism) + cost_warnings(run.mechanism):
        LOG.warning(warning)
    while True:
        run.options |= _options(output, error, settle)
        extra = partial(sensing.add, run) if sensing else None
        try:
            if request is not None:
                result = answer(run, output, request, settle, progress, extra)
            else:
                result = write(run, output, progress, error, settle, extra=extra)
            warn(result.warnings if request else run.warnings)
            return result
        except SimulationError as failed:  # not `error`: it is needed again
            again, reason = reopened(run, prepared, str(failed))
            if failed.result is None or again is None:
                failed.args = (reason,)
                raise
            failed.result.close()
            run = again


def ideal_turn(scene: Scene) -> Result:
    """A turn of a scene with ideal joints, or its start where nothing turns.

    Raises ValueError where it has none.
    """
    span = {"turns": 1.0} if scene.turn else {"until": BRIEF}
    more = {"samples": 201, "error": None, "energy": False, "progress": False}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return simulate(idealised(scene), **span, **more)
        except SimulationError as error:
            raise ValueError(str(error)) from None


def reopened(run: Run, prepared: Callable[..., Run], failure: str) -> tuple[Run | None, str]:
    """A run that failed at a dead centre again, its loop open; None where it has no such loop, or
    where that cannot be. The failure, with the reason for that.
    """
    dead = run.dead_centre
    if dead is None or not dead.soft_joints:
        return None, failure
    try:
        again = prepared(opened=(*run.mechanism.opened, dead.soft_joints[0]))
    except ValueError as reason:
        joint = dead.soft_joints[0]
        return None, f"{failure}; the loop cannot be opened at joint {joint}: {reason}"
    LOG.info("%s: again with places of its bodies as coordinates", dead.text)
    return again, failure


def _sensing(scene: Scene, parameters, prepared: partial, settle: float | None):
    """Sensitivities of the run of a scene, from runs of the same options. Raises ValueError."""
    from clearance.accuracy.by_differences import Sensing

    options = {n: prepared.keywords[n] for n in ("energy", "max_step", "start")}
    return Sensing(scene, parameters, partial(prepare, **options), settle)


def _opened(path: str | Path | None, checkpoint: float | None) -> tuple[str, ...]:
    """Joints whose loops a run with checkpoints has opened before."""
    if checkpoint is None:
        return ()
    from clearance.run.checkpoint import opened_in

    return opened_in(path)


def _request(error: str | float | Mapping | None, checkpoint: float | None) -> "Request | None":
    """The request for an error; None where none is requested. Raises ValueError."""
    if not asks(error):
        return None
    from clearance.accuracy.request import Request

    if checkpoint is not None:
        raise ValueError(
            "checkpoint and a requested error do not go together: its runs are stored in memory"
        )
    return Request.of(error)


def _options(output: Output, error: str | float | Mapping | None, settle: float | None) -> dict:
    """Arguments of `simulate` that are no part of `prepare`, as plain data."""
    return {
        "channels": output.channels and list(output.channels),
        "compression": output.compression,
        "pressure_fields": output.pressure_fields,
        "error": dict(error) if isinstance(error, Mapping) else error,
        "settle": settle,
    }


def _affordable(output: Output, mechanism: Mechanism, demand: Demand) -> None:
    """Raise ValueError where a run and its file are too large; checkpoints are joined, which takes
    the room twice.
    """
    columns = 1 + len(matching(mechanism.layout.channels, output.channels))
    runs = 1 if output.checkpoint is None else 2
    if output.path is None and _in_memory(output, demand.rows * columns):
        columns = 0
    demand = replace(demand, columns=columns, compressed=output.compression > 0, runs=runs)
    affordable(demand, output.path)


def prepare(
    scene: Scene,
    demanded: Callable[[Mechanism, Demand], None] | None = None,
    *,
    turns: float | None = None,
    until: float | None = None,
    rtol: float = 1e-6,
    method: str = "auto",
    samples_per_turn: int = SAMPLES_PER_TURN,
    samples: int | None = None,
    energy: bool = True,
    max_step: float | None = None,
    max_steps: int | None = None,
    start: Record | str | Path | None = None,
    opened: tuple[str, ...] = (),
) -> Run:
    """The run of a scene, all checked and compiled, not begun; arguments and errors are those of
    `simulate`.

    demanded: called with what the run needs, before anything is compiled. opened: joints with
        clearance whose loops are opened, see `build`.
    """
    if not isinstance(scene, Scene):
        raise TypeError(
            f"simulate needs a Scene, got {scene!r}; cl.load_case makes one from a case name"
        )
    solver = Solver(rtol, method, max_step, max_steps)
    opened = opened if start is None else (*opened_by(start), *opened)
    mechanism = build(scene, ledger=energy, opened=opened)
    asked = {"turns": turns, "until": until, "samples": samples}
    asked["samples_per_turn"] = samples_per_turn
    span = _span(mechanism, asked)
    if demanded is not None:
        steps = span.until / (max_step or longest_step(mechanism, span))
        demanded(mechanism, Demand(span.samples, min(steps, max_steps or steps)))
    run = Run(mechanism, span, solver)
    run.options = {
        "until": span.until,
        "samples": span.samples,
        "rtol": rtol,
        "method": method,
        "energy": energy,
        "max_step": max_step,
        "max_steps": max_steps,
    }
    if start is not None:
        run.start_from(start)
    return run


def _span(mechanism: Mechanism, asked: dict) -> Span:
    """The length of a run; the scene remembers it for the same arguments."""
    make = partial(span_of, mechanism.scene, **asked)
    try:
        return mechanism.remembered(("span", *asked.values(), *map(type, asked.values())), make)
    except TypeError:  # an argument without a hash
        return make()


def write(
    run: Run,
    output: Output,
    progress: Callable[[float], None] | None = None,
    error: str | None = None,
    settle: float | None = None,
    pair: Callable[[Record], Pair] | None = None,
    extra: "Callable[[Sink], None] | None" = None,
) -> Result:
    """Run to the end, streaming into the file; a signal and a full disk end it early, the file
    stored.

    error: "auto" and "state" state the errors of its numbers, as `simulate` does; settle: turns
        left out of those. What an observer changes is changed in the second run too. pair: puts
        companions beside the record, where the run from the same start is none. extra: adds to the
        finished file.
    Raises SimulationError, and KeyboardInterrupt with a note that states what is stored.
    """
    reason = "" if error and pair else reason_without(run, error, output)
    statement = None if reason else Statement(run, settle, output.checkpoint is not None, pair)

    def record(sink, check: Callable[[], None]) -> str | None:
        return record_run(run, sink, progress, output.checkpoint, check)

    adds = statement and statement.add, extra
    return _placed(run, output, record, adds, reason, remembering=statement is not None)


def answer(
    run: Run,
    output: Output,
    request: "Request",
    settle: float | None,
    progress: Callable[[float], None] | None,
    extra: "Callable[[Sink], None] | None" = None,
) -> Result:
    """The run that a request leads to, in its file; extra: adds to the finished file.

    Raises ValueError for names that the run does not have, before anything runs. Raises NotReached,
    SimulationError, and KeyboardInterrupt, with the best run so far stored in the file.
    """
    from clearance.accuracy.request import ToleranceSearch, names

    request.check(names(run, partial(metrics, settle=settle)))
    ladder = ToleranceSearch(run, request, settle, progress=progress)
    try:
        best = ladder.climb()
    except KeyboardInterrupt as stopped:
        if ladder.best is not None:
            _handed_on(ladder.best, output).close()
            stopped.add_note(f"the best run so far is stored in {output.path}")
        raise
    run.dead_centre = best.attempt.run.dead_centre
    result = _handed_on(best, output, extra)
    if best.attempt.failure is not None:
        raise SimulationError(f"an error of {request} cannot be reached: {best.cannot}", result)
    if best.cannot:
        reached = f"; stated: {ladder.reached}"
        raise NotReached(f"an error of {request} cannot be reached: {best.cannot}{reached}", result)
    return result


def _handed_on(
    reached: "Outcome", output: Output, extra: "Callable[[Sink], None] | None" = None
) -> Result:
    """The file of an answer."""

    def record(sink, check: Callable[[], None]) -> None:
        reached.attempt.memory.replay(sink)

    adds = partial(add_errors, reached.errors), extra
    return _placed(reached.attempt.run, output, record, adds, "")


def _placed(
    run: Run,
    output: Output,
    record: Callable[..., str | None],
    adds: "Sequence[Callable[[Sink], None] | None]",
    reason: str,
    remembering: bool = False,
) -> Result:
    """The result of a run that `record` puts into a sink; adds: add the errors of its numbers and
    more to the finished file.

    record: given the sink and what raises interrupts; why the run ended early, None where it did
        not.
    """
    sink = None
    try:
        try:
            with DeferredSignals() as held:
                sink = _sink(run, output, reason, remembering)
                failure = record(sink, held.check)
            for add in filter(None, adds if failure is None else ()):
                add(sink)
        finally:
            with DeferredSignals():
                if sink is not None:
                    sink.store()
    except Unwritable as error:
        failure = f"at t = {run.state.time:.9g} s: {error}; {_remains(sink, output.path)}"
        if sink is None or not sink.placed:
            raise SimulationError(failure, None) from None
    except KeyboardInterrupt as error:
        if not getattr(error, "__notes__", ()):
            error.add_note(_remains(sink, output.path))
        raise
    if output.pressure_fields is not None and failure is None:
        from clearance.run.pressure_fields import keep

        keep(sink.path, output.pressure_fields)
        result = Result(sink.path)
    else:
        result = sink.result()
    if output.path is None and not isinstance(result, MemoryResult):
        weakref.finalize(result, shutil.rmtree, result.path.parent, ignore_errors=True)
    if failure is not None:
        if output.path is not None and str(output.path) not in failure:
            failure = f"{failure}; results so far: {output.path}"
        raise SimulationError(failure, result)
    return result


def _sink(run: Run, output: Output, reason: str, remembering: bool) -> "Sink":
    """Sink of a run's output: in memory where it is short, with checkpoints on request.

    reason: why no errors are stated; remembering: the sink has the run as a record in the end.
    """
    channels, compression = output.channels, output.compression
    outputs = run.mechanism.layout.channels
    attributes = attributes_of(run, **({"errors_left_out": reason} if reason else {}))
    path, numbers = output.path, run.span.samples * len(outputs)
    if path is None and not _in_memory(output, numbers):
        path = temporary_file()
    if output.checkpoint is not None:
        chosen_output = {"channels": channels and list(channels), "compression": compression}
        from clearance.run.checkpoint import PartsSink, identity_of

        content = Content(outputs, attributes, channels, compression)
        return PartsSink(path, content, identity_of(run) | chosen_output)
    content = Content(outputs, attributes, channels, compression, run.span.samples)
    if remembering or numbers <= SHORT:
        return ShortFile(path, content, remembering)
    return Stream(path, content)


def _in_memory(output: Output, numbers: int) -> bool:
    """True where so many numbers of output need no file, unless a path is given."""
    return numbers <= SHORT and output.pressure_fields is None


def _remains(sink, path) -> str:
    """Description of the files of a run that ended early, also before it had a sink."""
    return f"{path or 'a file'} was not written" if sink is None else sink.remains


def hole_warnings(mechanism: Mechanism) -> list[str]:
    """Force holes that the mechanism's inertia may meet, before anything runs."""
    joints = [j for j in mechanism.scene.clearance_joints if j.transition is not None]
    if not joints:
        return []
    from clearance.run.force_hole import hole_warning

    def warnings() -> list[str]:
        inertia = sum(b.mass for b in mechanism.scene.bodies) * mechanism.acceleration
        return [*filter(None, (hole_warning(j, mechanism.frequency, inertia) for j in joints))]

    return mechanism.remembered(("holes",), warnings)


def cost_warnings(mechanism: Mechanism) -> list[str]:
    """The cost of films that are solved as the run goes, from the time of one solution."""
    costs, turn = [], mechanism.scene.turn
    for joint in (j for j, s in mechanism.sources.items() if isinstance(s, Callback)):
        try:
            film = joint.film.source(joint.film_joint)  # another film: the run's stays as it is
            each = film.seconds()
        except Exception:  # noqa: BLE001 - the run itself ends with the reason
            continue
        cost = f"{joint.label()}: its film is solved as the run goes, {each:.2g} s of CPU each time"
        costs.append(f"{cost}, about {each * film.usual:.2g} s a turn" if turn else cost)
    return costs
