"""A life read from its directory: no solver is needed for that.

worn/life.json          what was asked for
worn/journal.jsonl      one line for each stage, appended once its files are whole
worn/stage-0007.h5      the run of a stage, on outlines that stay as they are
worn/stage-0007.npz     its outlines, wear of a turn and load paths; what those have changed
"""

import math
from functools import cached_property
from pathlib import Path

import numpy as np

from clearance.files.texts import check_kinds, signed_document, text_of
from clearance.metrics.metrics import SURFACES
from clearance.results.reading import arrays_of
from clearance.values.accessors import Celled

STEADY = 0.99  # of a load's size: its mean, where it stands still
NUMBER = (int, float)
#: entries of life.json, of a joint in it, of a line of the journal
ASKED = {"turns": NUMBER, "joints": dict, "scene": dict}
SIZES = {"radius": NUMBER, "length": NUMBER, "clearance": NUMBER, "wears": list}
STAGE = {"stage": int, "average": int, "scatter": dict, "metrics": dict}
STAGE |= dict.fromkeys(("turns", "error", "jump"), NUMBER)


def asked(folder: Path) -> dict:
    """The request for a life. Raises ValueError for a folder that holds none, or a damaged one."""
    path = folder / "life.json"
    if not path.is_file():
        raise ValueError(f"{folder} holds no life: it has no life.json")
    document = signed_document(text_of(path), path)
    try:
        check_kinds(document, ASKED)
        check_kinds(document["scene"], {"name": str, "joints": list})
        for size in document["joints"].values():
            check_kinds(size, SIZES)
            if not size["wears"] or not all(s in SURFACES for s in size["wears"]):
                raise ValueError(f"wears must be some of {', '.join(SURFACES)}")
    except ValueError as error:
        raise ValueError(f"{path} is no request for a life: {error}") from None
    return document


def stages(folder: Path, joints: list[str]) -> list[dict]:
    """Lines of a life's journal; a line that a kill has cut short does not count.

    Raises ValueError with the number of a line that cannot be read.
    """
    path = folder / "journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
    read = [_stage(line, f"{path}:{i + 1}") for i, line in enumerate(lines) if line[-1:] == b"\n"]
    for i, entry in enumerate(read):
        shares = [entry["scatter"], entry.get("spread", entry["scatter"])]
        if entry["stage"] != i or not all(_numbers(s, joints) for s in shares):
            raise ValueError(f"{path}:{i + 1} is not stage {i} of this life")
    return read


def _stage(line: bytes, where: str) -> dict:
    entry = signed_document(line, where)
    try:
        check_kinds(entry, STAGE)
        if not _numbers(entry["metrics"]) or not _described(entry.get("known", {})):
            raise ValueError("its metrics must be numbers, with units and texts")
    except ValueError as error:
        raise ValueError(f"{where} is no stage of a life: {error}") from None
    return entry


def _numbers(table: object, names: list[str] | tuple = ()) -> bool:
    """A table of numbers that has these names."""
    if not isinstance(table, dict) or not all(n in table for n in names):
        return False
    return all(v is None or isinstance(v, NUMBER) for v in table.values())


def _described(table: object) -> bool:
    """A table of units and texts."""
    if not isinstance(table, dict):
        return False
    rows = table.values()
    return all(isinstance(r, list) and [type(t) for t in r] == [str, str] for r in rows)


def arrays(folder: Path, stage: int, joints: dict[str, list[str]]) -> dict[str, np.ndarray]:
    """Outlines, wear of a turn and load paths of a stage. joints: surfaces that wear, by joint.

    Raises ValueError where they are not there.
    """
    path = folder / f"stage-{stage:04d}.npz"
    columns = arrays_of(path)
    shapes = {f"{n}/{s}": (1, 360) for n in joints for s in SURFACES}  # dimensions, length of last
    shapes |= {f"{n}/{s}/turn": (1, 360) for n, wears in joints.items() for s in wears}
    shapes |= {f"{n}/path": (2, 6) for n in joints}
    shapes |= {f"{n}/change": (2, 360) for n in joints if f"{n}/change" in columns}
    for name, shape in shapes.items():
        column = columns.get(name, np.zeros(0))
        if column.dtype != float or (len(column.shape), *column.shape[-1:]) != shape:
            raise ValueError(f"{path} has no {name} of a life")
    return columns


class Life(Celled):
    """A life: stages at growing numbers of turns, and how the outlines grew between them.

    Raises ValueError for a folder that holds none.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.asked = asked(self.path)
        self.stages = stages(self.path, self.joints)

    def __repr__(self) -> str:
        end = self.turns[-1] if self.stages else 0
        return (
            f"Life({str(self.path)!r}: {len(self.stages)} stages, {end:g} of "
            f"{self.asked['turns']:g} turns)"
        )

    @property
    def done(self) -> bool:
        """True where the last stage stands at the requested end."""
        return bool(self.stages) and self.stages[-1]["turns"] >= self.asked["turns"]

    @property
    def turns(self) -> np.ndarray:
        """Turns done at each stage."""
        return np.array([stage["turns"] for stage in self.stages])

    @property
    def error(self) -> np.ndarray:
        """Depth that the jumps up to each stage may have missed [m]."""
        return np.array([stage["error"] for stage in self.stages])

    @cached_property
    def joints(self) -> list[str]:
        """Names of the joints that wear."""
        return list(self.asked["joints"])

    def file(self, stage: int) -> Path:
        """Result file of the run of a stage."""
        return self.path / f"stage-{stage:04d}.h5"

    @cached_property
    def _arrays(self) -> list[dict]:
        wears = {name: size["wears"] for name, size in self.asked["joints"].items()}
        return [arrays(self.path, i, wears) for i in range(len(self.stages))]

    def depth(self, joint: str, surface: str = "bearing") -> np.ndarray:
        """Worn depth [m] over the angle of the surface's body, one a degree, at each stage:
        (stages, 360).
        """
        return np.array([a[f"{joint}/{surface}"] for a in self._arrays])

    def rate(self, joint: str, surface: str = "bearing") -> np.ndarray:
        """Wear of a turn [m] over the angle, as each stage's run has it."""
        return np.array([a[f"{joint}/{surface}/turn"] for a in self._arrays])

    def load_path(self, joint: str, stage: int = 0) -> np.ndarray:
        """Load path of a turn, see `wearing.summing.PATH`."""
        return self._arrays[stage][f"{joint}/path"]

    def volume(self, joint: str, surface: str = "bearing") -> np.ndarray:
        """Worn volume at each stage [m3]."""
        size = self.asked["joints"][joint]
        return (
            self.depth(joint, surface).sum(axis=1)
            * size["radius"]
            * size["length"]
            * math.radians(1.0)
        )

    def metric(self, name: str) -> np.ndarray:
        """A metric of the stages' runs, such as "joint_B_force_max"; nan where a run has it not."""
        return np.array([s["metrics"].get(name, math.nan) for s in self.stages], dtype=float)

    def stands_still(self, joint: str) -> bool:
        """True where the load of a dry joint stands still in the bearing, which alone wears: then
        `closed_form` is about it.
        """
        named = (j for j in self.asked["scene"]["joints"] if isinstance(j, dict))
        described = next((j for j in named if j.get("name") == joint), {})
        if described.get("asperity") or self.asked["joints"][joint]["wears"] != ["bearing"]:
            return False
        force_x, force_y, _, over, *_ = self.load_path(joint).T
        shared = float((np.hypot(force_x, force_y) * over).sum())
        return math.hypot((force_x * over).sum(), (force_y * over).sum()) > STEADY * shared

    def closed_form(self, joint: str) -> np.ndarray:
        """Depth [m] of a rigid journal whose load stands still in the bearing, from the first load
        path alone.

        L c (a / cos a - sin a) = sum(F w) / R n after n turns, depth c / cos a - c: Dufrane's arc
        grows with a. For a bearing that wears under loads of one direction, it is what a designer
        needs no code for.
        """
        size = self.asked["joints"][joint]
        force_x, force_y, _, over, _, _ = self.load_path(joint).T
        wear = (np.hypot(force_x, force_y) * over).sum() / size["radius"] * self.turns
        wanted = wear / (size["length"] * size["clearance"])
        return size["clearance"] * (1.0 / np.cos([_angle(w) for w in wanted]) - 1.0)

    def table(self) -> list[dict]:
        """Rows of the stages: turns, deepest place, its angle, volume and error of each surface."""
        rows = []
        for i, stage in enumerate(self.stages):
            row = {"turns": stage["turns"], "error": stage["error"]}
            for joint in self.joints:
                for surface in self.asked["joints"][joint]["wears"]:
                    depth = self._arrays[i][f"{joint}/{surface}"]
                    row[f"{joint}_{surface}_depth"] = float(depth.max())
                    row[f"{joint}_{surface}_angle_deg"] = float(depth.argmax())
                    row[f"{joint}_{surface}_volume"] = float(self.volume(joint, surface)[i])
            rows.append(row)
        return rows


def _angle(wanted: float) -> float:
    """Solution a of a / cos a - sin a = target, by bisection to rounding."""
    low, high = 0.0, 0.5 * math.pi
    for _ in range(80):
        middle = 0.5 * (low + high)
        small = middle / math.cos(middle) - math.sin(middle) < wanted
        low, high = (middle, high) if small else (low, middle)
    return 0.5 * (low + high)
