"""A life read from its directory: no solver is needed for that.

worn/life.json          what was asked for
worn/journal.jsonl      one line for each stage, appended once its files are whole
worn/stage-0007.h5      the run of a stage, on outlines that stay as they are
worn/stage-0007.npz     its outlines, wear of a turn and load paths
"""

import json
import math
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import numpy as np

STEADY = 0.99  # of a load's size: its mean, where it stands still


def lines(path: Path) -> Iterator[dict]:
    """Complete lines of a journal; a line that a kill has cut short does not count."""
    if not path.exists():
        return
    for line in path.read_bytes().splitlines(keepends=True):
        if line.endswith(b"\n"):
            yield json.loads(line)


class Life:
    """A life: stages at growing numbers of turns, and how the outlines grew between them.

    Raises ValueError for a folder that holds none.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        if not (self.path / "life.json").is_file():
            raise ValueError(f"{self.path} holds no life: it has no life.json")
        self.asked = json.loads((self.path / "life.json").read_text())
        self.stages = list(lines(self.path / "journal.jsonl"))

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
        columns = []
        for i in range(len(self.stages)):
            with np.load(self.path / f"stage-{i:04d}.npz") as arrays:
                columns.append(dict(arrays))
        return columns

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
        described = next(j for j in self.asked["scene"]["joints"] if j["name"] == joint)
        if described["asperity"] or self.asked["joints"][joint]["wears"] != ["bearing"]:
            return False
        force_x, force_y, _, over, *_ = self.load_path(joint).T
        shared = float(np.hypot(force_x, force_y) @ over)
        return math.hypot(force_x @ over, force_y @ over) > STEADY * shared

    def closed_form(self, joint: str) -> np.ndarray:
        """Depth [m] of a rigid journal whose load stands still in the bearing, from the first load
        path alone.

        L c (a / cos a - sin a) = sum(F w) / R n after n turns, depth c / cos a - c: Dufrane's arc
        grows with a. For a bearing that wears under loads of one direction, it is what a designer
        needs no code for.
        """
        size = self.asked["joints"][joint]
        force_x, force_y, _, over, _, _ = self.load_path(joint).T
        given = np.hypot(force_x, force_y) @ over / size["radius"] * self.turns
        wanted = given / (size["length"] * size["clearance"])
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
