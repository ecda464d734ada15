"""Checkpoints of a long run: a killed run goes on from its last one and gives the file it would
have given.

Beside `run.h5` stands a folder `run.h5.parts`. It holds finished stretches of the run (0000.h5,
...), each a complete result file, and `state.npz`. The latter is the state from which the
integration continues, written under a temporary name and renamed. At the end the stretches are
joined in `run.h5` and the folder is removed.
"""

import hashlib
import json
import os
import shutil
import time
from pathlib import Path

import numpy as np

from clearance.files.locks import Lock, check_replaceable, folder_at, replacing
from clearance.files.texts import document_of
from clearance.results.reading import Damaged, arrays_of
from clearance.results.result import Result
from clearance.results.stream import Content, FinishedFile, Stream, Unwritable, lock_of
from clearance.run.observers import Observer
from clearance.stepping import status

VERSION = 8
STATE = "state.npz"
# how runs end that shall be able to go on
GOES_ON = ("partial: interrupted", "partial: terminated")
RECORD = ("low", "high", "totals", "rows", "turned_over")


class PartsSink(FinishedFile):
    """A sink that can stop a stretch of the record and begin the next; in the end they become one
    file.

    placed: whether that file has its name. full: True where the disk had no room. The stretches
        then stay as they are, because joining them takes the room of the entire file once more.
    """

    placed = full = False

    def __init__(self, path: Path, content: Content, identity: dict):
        self.path = Path(path)
        self.folder = parts_folder(path)
        check_replaceable(self.path)
        self.content, about = content, content.attributes
        self.identity = identity | {"scene": about["scene"], "kernel": _digest(about["kernel"])}
        self.count = 0
        self.stretch: Stream | None = None
        self.lock: Lock | None = None

    def begin(self) -> dict | None:
        """Look for what an earlier attempt left: its state, or None.

        Raises ValueError where it was another run.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.lock = lock_of(self.path)
        try:
            if not self.lock.held:
                raise ValueError(
                    f"{self.path}: this file system has no locks, and checkpoints of two runs "
                    "would mix; leave them out"
                )
            folder_at(self.folder)
            before = self._state()
            self._next()
        except BaseException:
            self.lock.release()
            raise
        return before

    def leave(self) -> None:
        """End without a run: all stays as it was."""
        self.stretch.abandon()
        self.lock.release()

    def _state(self) -> dict | None:
        """The state to go on from, its stretches all there."""
        saved = load(self.folder / STATE)
        if saved is not None:
            self._compare(_identity(saved, self.folder))
            self.count = int(saved["stretches"])
            for i in range(self.count):
                self._stretch(i).close()
        return saved

    def _stretch(self, i: int) -> Result:
        """A finished stretch. Raises ValueError where it cannot be read."""
        try:
            return Result(self.folder / f"{i:04d}.h5")
        except (OSError, ValueError) as error:
            raise ValueError(f"{error}: remove {self.folder} to start anew") from None

    def _compare(self, stored: dict) -> None:
        different = [n for n in self.identity if stored.get(n) != self.identity[n]]
        if different:
            raise ValueError(
                f"{self.folder} holds checkpoints of another run (other {', '.join(different)}): "
                "remove that folder, or give the result another name"
            )

    def _next(self) -> None:
        self.stretch = s = Stream(self.folder / f"{self.count:04d}.h5", self.content, alone=True)
        self.rows, self.impacts, self.steps, self.flush = s.rows, s.impacts, s.steps, s.flush

    def cut(self, state: dict) -> None:
        """End the stretch and keep the state to go on from."""
        self._end_stretch()
        about = {
            "identity": json.dumps(self.identity),
            "stretches": self.count + 1,
            "version": VERSION,
        }
        try:
            save(self.folder / STATE, state | about)
            self.count += 1
            self._next()
        except OSError as error:
            self.full = True
            raise Unwritable(self.folder, error.errno) from None

    def _end_stretch(self) -> None:
        self.stretch.close("partial: a stretch of a longer run", {}, [], {}, None)

    def close(self, status: str, solver: dict, warnings: list[str], facts: dict, ranges) -> None:
        """Join the stretches; the folder stays where the run was interrupted, to go on from."""
        try:
            self._end_stretch()
            if self.full or self.stretch.full:
                return
            joined = self._joined()
            joined.close(status, solver, warnings, facts, ranges)
            self.placed = True
            if not status.startswith(GOES_ON):
                shutil.rmtree(self.folder)
        finally:
            self.lock.release()

    def _joined(self) -> Stream:
        """All stretches in one file, not closed yet.

        Raises Unwritable where there is no room for it.
        """
        joined = Stream(self.path, self.content, alone=True)
        try:
            for i in range(self.count + 1):
                with self._stretch(i) as part:
                    joined.join(part.reader)
        except (Unwritable, Damaged):
            joined.abandon()
            raise
        return joined

    @property
    def remains(self) -> str:
        """Description of the files of a run that ended early."""
        if self.placed:
            return (
                f"what was computed is stored in {self.path}, and the same call goes on from there"
            )
        if (self.folder / STATE).exists():
            return (
                f"its checkpoints are stored in {self.folder}, and the same call goes on from the "
                "last one"
            )
        return f"{self.path} was not written" if self.stretch is None else self.stretch.remains


def parts_folder(path: str | Path) -> Path:
    return Path(f"{path}.parts")


def opened_in(path: str | Path) -> tuple[str, ...]:
    """Joints whose loops are opened in the run that left checkpoints beside a file."""
    folder = parts_folder(path)
    saved = load(folder / STATE)
    return () if saved is None else tuple(_identity(saved, folder).get("opened", ()))


def _identity(saved: dict, folder: Path) -> dict:
    """The run that a checkpoint is of.

    Raises ValueError for one of another version, and where nothing goes on from it.
    """
    numbers = [saved.get(name, np.zeros(1)) for name in ("version", "stretches")]
    counts = all(n.dtype.kind == "i" and not n.shape for n in numbers)
    if not counts or numbers[0] != VERSION or numbers[1] < 0:
        raise ValueError(f"{folder} holds checkpoints of another version of clearance; remove it")
    try:
        return document_of(str(saved.get("identity", "")), folder / STATE)
    except ValueError as error:
        raise ValueError(f"{error}: remove {folder} to start anew") from None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def save(path: Path, state: dict) -> None:
    """Write arrays and numbers, completely or not at all."""
    with replacing(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, **state)
        file.flush()
        os.fsync(file.fileno())


def load(path: Path) -> dict | None:
    """State that `save` wrote, or None without one.

    Raises ValueError for a file that cannot be read.
    """
    if not path.exists():
        return None
    try:
        return arrays_of(path)
    except Damaged as error:
        raise ValueError(f"checkpoint {error}; remove {path.parent} to start anew") from None


class Checkpoints(Observer):
    """Cuts a checkpoint when so many seconds of wall time have passed since the last."""

    def __init__(self, sink: PartsSink, recording, every: float):
        self.sink, self.recording, self.every = sink, recording, every
        self.last = time.perf_counter()

    def piece(self, run, code):
        """Cut one when it is time."""
        if code == status.RUNNING and time.perf_counter() - self.last > self.every:
            self.sink.cut(state_of(run, self.recording))
            self.last = time.perf_counter()
        return code


def identity_of(run) -> dict:
    """Facts that two runs must share for one to continue the other.

    Raises ValueError for a run that no checkpoint keeps.
    """
    for key in run.mechanism.layout.remembering:
        raise ValueError(
            f"{key}: its film has a memory that no checkpoint keeps; leave out checkpoint"
        )
    for joint in (j for j in run.mechanism.scene.joints if j.wear or j.wear_journal):
        raise ValueError(f"{joint.label()}: its wear is in no checkpoint; leave out checkpoint")
    facts = vars(run.span) | {"rtol": run.solver.rtol, "method": run.method.text}
    facts["start"] = run.state.y[: run.mechanism.size].tolist()
    facts["opened"] = list(run.mechanism.opened)
    return facts | {
        "max_step": run.state.longest_step,
        "max_steps": int(run.state.step_limit),
    }


def state_of(run, recording) -> dict:
    """All that the run goes on with: its state, its stepper, its changes; the record so far."""
    recorder = recording.recorder
    state = {"memory": run.state.memory, "method": run.method.text, "reason": run.method.reason}
    state |= {"changes": json.dumps(run.changes), "dead_centre": recording.diagnosis.dead_centre}
    state |= {f"record.{n}": getattr(recorder.summary, n) for n in RECORD}
    state["begun.zero"] = recorder.zero
    if recorder.last is not None:
        state["last.time"], state["last.row"] = recorder.last
    if recorder.ledger is not None:
        state |= {
            f"ledger.{n}": value for n, value in vars(recorder.ledger).items() if value is not None
        }
    return state


#: entries of a checkpoint that a run has only once it is under way, with their dimensions
LATER = {"ledger.since": np.zeros(()), "ledger.last": np.zeros(3), "last.time": np.zeros(())}
#: entries of a checkpoint about itself
SELF = ("identity", "stretches", "version")


def _check(state: dict, fresh: dict) -> None:
    """Raise ValueError for a checkpoint that has other entries than a run, or no numbers in them.

    fresh: what this run has before its first step.
    """
    wanted = LATER | {"last.row": fresh["record.low"]} | fresh
    for name, value in state.items():
        if name in SELF:
            continue
        like = np.asarray(wanted.get(name))
        kinds = "bif" if like.dtype.kind in "bif" else like.dtype.kind
        rows = value.ndim == 2  # as many as there are
        if value.dtype.kind not in kinds or value.shape[rows:] != like.shape[rows:]:
            raise ValueError(f"its {name} is of another kind")
        if kinds == "bif" and name != "memory" and np.isnan(value).any():
            raise ValueError(f"its {name} is not a number")


def _take_up(run, recording, state: dict) -> None:
    """Give a run the method, the changed numbers and the state of a checkpoint.

    Raises ValueError, TypeError, AttributeError or LookupError for what is none.
    """
    if missing := state_of(run, recording).keys() - state.keys():
        raise ValueError(f"it has no {', '.join(sorted(missing))}")
    names = str(state["method"]).split(", ")
    if names[-1] != run.method.current:
        try:
            run.method.use(names[-1])
        except (ImportError, AttributeError):
            raise ValueError(f"its method is {names[-1]}") from None
    run.method.names = names
    run.method.reason = str(state["reason"])
    for moment, changes in document_of(str(state["changes"]), "its changes", list):
        run.rebuild(moment, changes)
    _check(state, state_of(run, recording))
    run.state.memory[...] = state["memory"]
    if np.isnan(run.state.y).any():
        raise ValueError("its state is not a number")


def restore(run, recording, sink: PartsSink, state: dict) -> None:
    """Put a run and its record where they were.

    Raises ValueError for a state of another kind, or that is not a number.
    """
    recorder = recording.recorder
    try:
        _take_up(run, recording, state)
    except (ValueError, TypeError, AttributeError, LookupError) as error:
        sink.leave()
        raise ValueError(f"{sink.folder / STATE} is no checkpoint of this run: {error}") from None
    recording.diagnosis.dead_centre = str(state["dead_centre"])
    if "last.time" in state:
        recorder.last = state["last.time"][()], state["last.row"]
    parts = {"begun": recorder, "record": recorder.summary, "ledger": recorder.ledger}
    for key, value in state.items():
        part, _, name = key.rpartition(".")
        if part in parts:
            setattr(parts[part], name, value if value.ndim else value.item())
