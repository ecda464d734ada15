"""Definition of a sweep: its case, points and options, stored as `sweep.json` in its directory.

It has the regimes of the joints too: the thresholds that all points share.
"""

import hashlib
import json
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from clearance.files.locks import replace_file
from clearance.files.texts import brief, check_kinds, signed, signed_document, text_of
from clearance.files.texts import digest as digest
from clearance.scene.catalogue import find_case
from clearance.scene.scene import Scene
from clearance.sweeping.points import Points, in_words, spread_out
from clearance.values.spots import THRESHOLDS

FEWEST = 24  # points that are worth machine code of their own
FORMAT = "clearance-sweep"
# 1: a grid's columns had a value for each point; 2: neither it nor the journal had checksums
FORMAT_VERSION = 3
#: what sweep.json holds beside its format
FIELDS = {
    "case": str,
    "path": str,
    "source": str,
    "points": dict,
    "fixed": dict,
    "options": dict,
    "keep": list | None,
    "compression": int,
    "settle": float | int | None,
    "own": list,
    "units": dict,
    "regimes": dict,
}


@dataclass(frozen=True)
class Definition:
    """All that the results of a sweep depend on.

    case: name, or path to a case file; source: digest of its text; fixed: parameters that all
        points share; options: keywords of `simulate` (turns, rtol, ...); keep: patterns of the
        channels stored in run files, () for no files, None for all; compression: gzip level;
        settle: turns left out of the metrics; own: a user's metrics, each "file.py:name" and the
        digest of the file; units: of the parameters; regimes: see regimes.py; no result depends on
        them.
    """

    case: str
    path: str
    source: str
    points: Points
    fixed: dict
    options: dict
    keep: tuple[str, ...] | None
    compression: int
    settle: float | None
    own: tuple[tuple[str, str], ...]
    units: dict[str, str]
    regimes: dict[str, dict[str, float]] = field(default_factory=dict)

    @property
    def files(self) -> bool:
        """True where each run has its own file."""
        return self.keep is None or len(self.keep) > 0

    @property
    def run_options(self) -> dict:
        """Options of a run: all but errors and sensitivities, and the life of a point."""
        return {n: v for n, v in self.options.items() if n not in ("error", "life", "sensitivity")}

    @property
    def life(self) -> dict | None:
        """Plan of the life of each point; None where points are single runs."""
        return self.options.get("life")

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """Name of each point: a digest of all its run depends on."""
        common = hashlib.sha256(json.dumps(self._common(), sort_keys=True).encode())
        keys, text = [], json.JSONEncoder(sort_keys=True).encode
        for i in range(len(self.points)):
            values = common.copy()
            values.update(text(self.points[i]).encode())
            keys.append(values.hexdigest()[:16])
        return tuple(keys)

    @cached_property
    def names(self) -> np.ndarray:
        """The keys as an array."""
        return np.array(self.keys)

    @cached_property
    def spread(self) -> tuple[str, ...]:
        """Names of the swept numbers that are not integers."""
        columns = self.points.columns.items()
        return tuple(
            n for n, v in columns if isinstance(v[0], float) and any(value != v[0] for value in v)
        )

    def idle(self) -> dict[str, str]:
        """Parameters that do nothing at any point, with the option that makes it so."""
        from clearance.scene.joint_options import DECIDING, idle

        case, columns = find_case(self.path), self.points.columns
        decisive = zip(*(columns[n] for n in DECIDING if n in columns), strict=True)
        kinds = {kind: i for i, kind in enumerate(decisive)} or {(): 0}
        everywhere: dict[str, str] = dict.fromkeys({*self.fixed, *columns}, "")
        for i in kinds.values():
            try:
                vain = idle(case.scene(**self.values(i)))
            except ValueError:  # a point that will be recorded as failed
                continue
            everywhere = {n: vain[n] for n in everywhere if n in vain}
        return {n: reason for n, reason in everywhere.items() if reason}

    def _common(self) -> dict:
        return {n: getattr(self, n) for n in ("case", "source", "fixed", "options")}

    def values(self, index: int) -> dict:
        """Case parameters of a point."""
        return self.fixed | self.points[index]

    @property
    def used(self) -> set:
        """All values of case parameters."""
        return {
            *self.fixed.values(),
            *(v for values in self.points.columns.values() for v in values),
        }

    def says(self, index: int) -> str:
        """A point in words: "speed=300 rpm, clearance=0.0001"."""
        return in_words(self.points[index], self.points.units) or "the only point"

    def to_json(self) -> str:
        """All of it; a column that an axis of a grid bears has the values along the axis only."""
        names = [f.name for f in fields(self)]
        document: dict[str, Any] = {"format": FORMAT, "format_version": FORMAT_VERSION}
        document |= {name: getattr(self, name) for name in names}
        points = self.points
        columns = points.columns if points.sampled else points.along
        document["points"] = {name: getattr(points, name) for name in ("axes", "sampled")}
        return json.dumps(
            document | {"points": document["points"] | {"columns": columns}}, indent=1
        )

    def differences(self, definition: "Definition") -> list[str]:
        """Differences of another definition, in words."""
        differences = []
        mine, theirs = json.loads(self.to_json()), json.loads(definition.to_json())
        for document in (mine, theirs):  # a directory may be moved
            document["own"] = [
                [reference.rpartition("/")[2], digest] for reference, digest in document["own"]
            ]
        for name in ("case", "fixed", "options", "keep", "compression", "settle", "own"):
            if mine[name] != theirs[name]:
                differences.append(f"{name} {brief(theirs[name])} instead of {brief(mine[name])}")
        if mine["source"] != theirs["source"] and mine["case"] == theirs["case"]:
            differences.append("the case file has been changed since")
        first, second = self.points.columns, definition.points.columns
        for name in dict.fromkeys([*first, *second]):
            if sorted(map(str, first.get(name, ()))) != sorted(map(str, second.get(name, ()))):
                differences.append(
                    f"{name} {_range(second.get(name))} instead of {_range(first.get(name))}"
                )
        if not differences and mine["points"] != theirs["points"]:
            differences.append("the order of its points")
        return differences


def _range(values: tuple | None) -> str:
    if values is None:
        return "not swept"
    distinct = list(dict.fromkeys(values))
    if len(distinct) <= 3:
        return ",".join(map(str, distinct))
    return f"{distinct[0]}..{distinct[-1]} ({len(distinct)} values)"


def write(definition: Definition, folder: Path) -> None:
    """Store a definition completely or not at all."""
    replace_file(folder / "sweep.json", signed(json.loads(definition.to_json()), indent=1))


def read(folder: Path) -> Definition | None:
    """The definition in a sweep directory; None where there is none.

    Raises ValueError for one of a newer format, and for a file that is none.
    """
    path = Path(folder) / "sweep.json"
    if not path.exists():
        return None
    try:
        document = signed_document(text_of(path), path)
        check_kinds(document, {"format": str, "format_version": int})
        if document["format"] != FORMAT:
            raise ValueError(f"its format is {document['format']!r}")
        if document["format_version"] <= FORMAT_VERSION:
            return _definition(document)
    except ValueError as error:
        raise ValueError(f"{path} is not the definition of a sweep: {error}") from None
    raise ValueError(
        f"{path} was written by a newer clearance (format {document['format_version']}; "
        f"this one reads up to {FORMAT_VERSION})"
    )


def _definition(document: dict) -> Definition:
    """The definition that a document holds. Raises ValueError for what is none."""
    document = {"regimes": {}} | document  # earlier ones have none
    check_kinds(document, FIELDS)
    points = document["points"]
    check_kinds(points, {"axes": list, "columns": dict, "sampled": bool})
    check_kinds(points["columns"], dict.fromkeys(points["columns"], list))
    metrics, keep = document["own"], document["keep"]
    if not all(
        _is_row(axis, list, int) and _is_row(axis[0], *[str] * len(axis[0]))
        for axis in points["axes"]
    ):
        raise ValueError("axes must be pairs of names and a number")
    if not all(_is_row(metric, str, str) for metric in metrics):
        raise ValueError("own must be pairs of texts")
    for numbers in document["regimes"].values():
        check_kinds({"regimes": numbers}, {"regimes": dict})
        if not all(isinstance(n, float) and math.isfinite(n) for n in numbers.values()):
            raise ValueError("regimes must be finite numbers")
    if keep is not None and not all(isinstance(pattern, str) for pattern in keep):
        raise ValueError("keep must be texts")
    if any(
        isinstance(v, dict | list | type(None))
        for values in points["columns"].values()
        for v in values
    ):
        raise ValueError("columns must be numbers and texts")
    axes = tuple((tuple(names), count) for names, count in points["axes"])
    columns = spread_out({n: tuple(v) for n, v in points["columns"].items()}, axes)
    values = {f.name: document[f.name] for f in fields(Definition) if f.name in document} | {
        "points": Points(columns, axes, points["sampled"]),
        "keep": None if keep is None else tuple(keep),
        "own": tuple(map(tuple, metrics)),
    }
    return Definition(**values)


def _is_row(value: object, *kinds: type) -> bool:
    """The value is a list of entries of these kinds."""
    return (
        isinstance(value, list) and len(value) == len(kinds) and all(map(isinstance, value, kinds))
    )


def regimes(definition: Definition) -> dict[str, dict[str, float]]:
    """For each joint with a transition its roughness [m] and thresholds [-], by name.

    Numbers that differ between points are absent: scenes at the ends of each swept number are
    compared, and one of each text. Points that cannot be built do not count.
    """
    case, shared = find_case(definition.path), None
    for index in _ends(definition):
        with suppress(ValueError, TypeError):
            numbers = _numbers(case.scene(**definition.values(index)))
            shared = numbers if shared is None else shared & numbers
            if not shared:
                return {}
    joints: dict[str, dict[str, float]] = {}
    for joint, name, value in sorted(shared or ()):
        joints.setdefault(joint, {})[name] = value
    return joints


def _ends(definition: Definition) -> Iterator[int]:
    """Points with the first and last value of each swept number, and with each text."""
    yield 0
    for column in map(np.array, definition.points.columns.values()):
        places = np.unique(column, return_index=True)[1].tolist()
        yield from (places[0], places[-1]) if column.dtype.kind in "if" else places


def _numbers(scene: Scene) -> set[tuple[str, str, float]]:
    """Joint, name and value of the roughness and thresholds of all its transitions.

    Those of elastic surfaces go by another film than the ratio of the metrics.
    """
    return {
        (str(joint.name), name, float(value))
        for joint in scene.joints
        if (law := getattr(joint, "transition", None)) is not None
        and getattr(joint, "elastic", None) is None
        for name, value in (law.values | {"roughness": joint.roughness}).items()
        if name in (*THRESHOLDS, "roughness") and value is not None
    }
