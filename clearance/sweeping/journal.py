"""Finished points of a sweep, a line of JSON each or a block of them, only ever appended to.

Points that ran together share a line: {"block": columns by name, metrics among them, "made": ...,
...}. Its numbers are bytes of floats in base 64, so that no digit is lost and a million points are
read in seconds. Only the driver writes it. A line that a kill or a full disk cut short is taken
off before the next is appended. `Ways` counts how the points of one call ran.
"""

import base64
import logging
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from clearance.files.locks import opener
from clearance.files.texts import signed, signed_document

LOG = logging.getLogger("clearance.files")

DONE, FAILED, LOST = "done", "failed", "lost"
#: numbers of each point of a block
COLUMNS = ("index", "warnings", "wall", "loop", "steps")
COUNTS = ("index", "warnings", "steps")
TAIL = 2**20  # bytes that are read at a time to find the last line's end
WAITING = "waiting"  # given back by a dead worker that had not begun it; never in a journal
ALONE = "alone"  # the reason of one that must not share a block again: its block lost its worker


@dataclass(frozen=True)
class Outcome:
    """Outcome of one point.

    key: the point's name, "" where the outcome comes from a team and not from a worker. status:
        done; failed (the run itself, which will fail again); lost (a worker died, a disk was full:
        try again). reason: why, or which own metrics of a run are missing.
    metrics: values by name; known: units and text of metrics
    that this journal has not named before. wall: seconds in all, loop: of these in the compiled
    loop; size and check: bytes and CRC-32 of the run's file; made: what it was run with, see
    run/inputs.py;
    recovered: from the run's file or the index, the journal does not list it; together: run in
    lanes.
    """

    index: int
    key: str
    status: str
    reason: str = ""
    metrics: dict[str, float] = field(default_factory=dict)
    known: dict[str, tuple[str, str]] = field(default_factory=dict)
    warnings: int = 0
    wall: float = 0.0
    loop: float = 0.0
    steps: int = 0
    size: int = 0
    check: int = 0
    made: dict = field(default_factory=dict)
    recovered: bool = False
    together: bool = False

    @property
    def died(self) -> bool:
        """True where its worker died with it."""
        return self.status == LOST and not self.key


@dataclass
class Block:
    """Outcomes of points that ran together and are done.

    columns, metrics: numbers of all of them by name; known, made: see Outcome.
    """

    keys: list[str]
    columns: dict[str, np.ndarray]
    metrics: dict[str, np.ndarray]
    known: dict[str, tuple[str, str]]
    made: dict

    @classmethod
    def of(cls, outcomes: list[Outcome]) -> "Block":
        """Outcomes that differ in numbers only."""
        first = outcomes[0]
        return cls(
            [o.key for o in outcomes],
            {n: np.array([getattr(o, n) for o in outcomes]) for n in COLUMNS},
            {n: np.array([o.metrics[n] for o in outcomes]) for n in first.metrics},
            {name: about for o in outcomes for name, about in o.known.items()},
            first.made,
        )

    def outcomes(self, summed: bool = True) -> list[Outcome]:
        """One for each point; summed: with its metrics."""
        shared: dict[str, Any] = {
            "status": DONE,
            "known": self.known,
            "made": self.made,
            "together": True,
        }
        columns = {n: v.astype(int) if n in COUNTS else v for n, v in self.columns.items()}
        rows = zip(*(v.tolist() for v in columns.values()), strict=True)
        entries = [dict(zip(columns, row, strict=True)) for row in rows]
        names = self.metrics if summed else {}
        values = np.array([self.metrics[n] for n in names]).T.reshape(len(entries), len(names))
        return [
            Outcome(key=key, **entry, metrics=dict(zip(names, row, strict=True)), **shared)
            for key, entry, row in zip(self.keys, entries, values.tolist(), strict=True)
        ]


class Journal:
    """The journal of a sweep directory, open for appending."""

    def __init__(self, folder: Path):
        self.path = folder / "journal.jsonl"
        good = whole(self.path)
        self.file = open(self.path, "ab", opener=opener)  # noqa: SIM115 - closed by close()
        if self.file.tell() > good:
            self.file.truncate(good)
        self.named: set[str] = set()
        for entry in entries(self.path):
            self.named.update(entry.known)

    def add(self, *entries: Outcome | Block) -> None:
        """Append outcomes; they are out of this process's hands when this returns, a block of them
        on the disk.
        """
        blocks = [e for e in entries if isinstance(e, Block)]
        outcomes = [e for e in entries if isinstance(e, Outcome)]
        plain = groupby(filter(_plain, outcomes), _shared)
        blocks += [Block.of(list(alike)) for _, alike in plain]
        lines = [self._line(o) for o in outcomes if not _plain(o)]
        lines += map(self._block, blocks)
        begin = self.file.tell()
        try:
            self.file.write(b"".join(f"{signed(line)}\n".encode() for line in lines))
            self.file.flush()
            if blocks:
                os.fsync(self.file.fileno())
        except OSError:
            self._take_back(begin)
            raise

    def _line(self, outcome: Outcome) -> dict:
        document = asdict(outcome) | {"known": self._new(outcome.known)}
        del document["recovered"]
        return {n: v for n, v in document.items() if v or n in ("index", "status")}

    def _block(self, block: Block) -> dict:
        columns: dict[str, Any] = {n: packed(block.columns[n]) for n in COLUMNS}
        columns["key"] = block.keys
        columns["metrics"] = {n: packed(values) for n, values in block.metrics.items()}
        return {"block": columns, "known": self._new(block.known), "made": block.made}

    def _new(self, described: dict) -> dict:
        """Units and texts of metrics that this journal has not named before."""
        fresh = {n: k for n, k in described.items() if n not in self.named}
        self.named.update(fresh)
        return fresh

    def _take_back(self, length: int) -> None:
        """Nothing of an incomplete line stays, neither in the file nor waiting to be written."""
        raw = self.file.detach()
        raw.truncate(length)
        raw.close()
        self.file = open(self.path, "ab", opener=opener)  # noqa: SIM115 - closed by close()

    def close(self) -> None:
        """Put it on the disk."""
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()


def packed(values: np.ndarray) -> str:
    """Numbers as text, every bit of them."""
    return base64.b64encode(np.asarray(values, "<f8").tobytes()).decode()


def unpacked(text: str | list) -> np.ndarray:
    """Numbers from their text; version 0.1 wrote lists.

    Raises ValueError or TypeError for what is none.
    """
    if isinstance(text, list):
        return np.array(text, float)
    return np.frombuffer(base64.b64decode(text, validate=True), "<f8")


def whole(path: Path) -> int:
    """Bytes of a journal up to the end of its last complete line."""
    if not path.exists():
        return 0
    with open(path, "rb") as file:
        end = file.seek(0, os.SEEK_END)
        while end > 0:
            begin = max(end - TAIL, 0)
            file.seek(begin)
            if (last := file.read(end - begin).rfind(b"\n")) >= 0:
                return begin + last + 1
            end = begin
    return 0


def entries(path: Path) -> Iterator[Outcome | Block]:
    """Outcomes and blocks in a journal, oldest first.

    Lines that cannot be read are passed over, and the log names them; the last line may be cut.
    """
    if not path.exists():
        return
    with open(path, "rb") as file:
        for number, line in enumerate(file, 1):
            try:
                document = signed_document(line, path)
                if "block" in document:
                    yield _block(document)
                else:
                    yield _outcome({"key": "", "status": LOST} | document)
            except (ValueError, TypeError, AttributeError, OverflowError):
                if line.endswith(b"\n"):
                    LOG.warning("%s: line %d is damaged; its points are missing", path, number)


def read(path: Path, summed: bool = True) -> Iterator[Outcome]:
    """Outcomes in a journal, point by point; summed: those of blocks with their metrics."""
    for entry in entries(path):
        if isinstance(entry, Block):
            yield from entry.outcomes(summed)
        else:
            yield entry


def _plain(outcome: Outcome) -> bool:
    """True for an outcome that can stand in a block."""
    return outcome.together and outcome.status == DONE and not outcome.reason


def _shared(outcome: Outcome) -> tuple:
    """Equal for outcomes that can stand in one block."""
    return tuple(outcome.metrics), outcome.made


def _block(document: dict) -> Block:
    """The block that a line holds. Raises ValueError or TypeError for what is none."""
    block = document["block"]
    columns = {name: unpacked(block[name]) for name in COLUMNS}
    metrics = {str(name): unpacked(text) for name, text in block["metrics"].items()}
    keys, inputs = [str(key) for key in block["key"]], document.get("made", {})
    described = {name: (str(u), str(t)) for name, (u, t) in document.get("known", {}).items()}
    if any(v.shape != (len(keys),) for v in (*columns.values(), *metrics.values())):
        raise ValueError
    counts = np.array([columns[name] for name in COUNTS])
    if not isinstance(inputs, dict) or not (counts == np.floor(counts)).all() or (counts < 0).any():
        raise ValueError
    return Block(keys, columns, metrics, described, inputs)


def _outcome(document: dict) -> Outcome:
    """The outcome that a line holds. Raises ValueError or TypeError for what is none."""
    outcome = Outcome(**document)
    if not all(isinstance(text, str) for text in (outcome.key, outcome.status, outcome.reason)):
        raise TypeError
    if outcome.status not in (DONE, FAILED, LOST):
        raise ValueError
    described = {name: (str(units), str(text)) for name, (units, text) in outcome.known.items()}
    metrics = {name: float(value) for name, value in outcome.metrics.items()}
    plain = ("index", "warnings", "steps", "size", "check")
    counts: dict[str, Any] = {name: _count(getattr(outcome, name)) for name in plain}
    return replace(
        outcome,
        known=described,
        metrics=metrics,
        wall=float(outcome.wall),
        loop=float(outcome.loop),
        **counts,
    )


def _count(value) -> int:
    """An integer from 0 on, also one that was stored as 3.0.

    Raises ValueError or TypeError for what is none.
    """
    if isinstance(value, str | bool) or value != int(value) or value < 0:
        raise ValueError
    return int(value)


@dataclass
class Ways:
    """Points that one call ran side by side in lanes, and each by itself.

    lanes: points at a time; reasons: why points are left to the ordinary way, and their numbers.
    """

    in_lanes: int = 0
    by_themselves: int = 0
    lanes: int = 0
    reasons: dict[str, int] = field(default_factory=dict)

    def alone(self, reason: str, count: int) -> None:
        """So many points take the ordinary way."""
        self.reasons[reason] = self.reasons.get(reason, 0) + count

    def __str__(self) -> str:
        lanes = "no points in lanes"
        if self.in_lanes:
            lanes = f"{self.in_lanes} points in lanes, {self.lanes} at a time"
        others = "; ".join(f"{count}: {reason}" for reason, count in self.reasons.items())
        return f"{lanes}; the ordinary way for {others}" if others else lanes
