"""The drawing of a mechanism as shapes that rest in its bodies, for a page that poses them itself.

A shape lies about a point of one body and turns with another one, mostly the same. Its points are
in metres from the centre of mass of a body, from the origin of ground.
"""

import numpy as np
from clearance.postprocess.drawing import (
    COIL,
    DASHPOT,
    MM,
    PAPER,
    ZIGZAG,
    Drawing,
    Motion,
    Room,
    ends,
    name_joints,
)
from clearance.postprocess.figures import hexadecimal

from clearance.results.record import Record

INSTANTS = 24  # poses over the run from which the place of a shape is derived
AT_REST = 1e-6  # most motion of a shape in its body, over the size of the mechanism
DIGITS = 6


class Shapes(Drawing):
    """All that an animation draws, as plain data.

    shapes: in the order in which they are drawn; labels: names of joints and where they stand; box:
    left, bottom, right, top of what the mechanism sweeps [m].
    Raises ValueError for pose channels that were not stored.
    """

    def __init__(self, record: Record):
        self.shapes: list[dict] = []
        self.labels: list[dict] = []
        places = np.unique(np.linspace(0, record.time.size - 1, INSTANTS).astype(int))
        super().__init__(Motion(record, record.time[places]), None)
        for name, shape in self.rings.items():
            shape["ring"] = name
        self.box = [float(v) / MM for v in (*self.low, *self.high)]
        breadth, height = np.maximum(self.high - self.low, 1e-9)
        self.room = Room(self, 0, 72.0 * min(PAPER[0] / breadth, PAPER[1] / height))
        name_joints(self, 0)
        self.shapes.sort(key=lambda shape: shape["z"])

    def document(self) -> dict:
        """Shapes, labels and box, for JSON."""
        return {"shapes": self.shapes, "labels": self.labels, "box": self.box}

    def line(self, path: np.ndarray, **style) -> dict:
        """A line, or the marker of a joint."""
        shape = {
            "z": style.get("zorder", 3),
            "edge": hexadecimal(style["color"]),
            "width": style.get("lw", 1.0),
        }
        if "marker" in style:
            fill = hexadecimal(style["markerfacecolor"])
            shape |= {"dot": 0.5 * style["ms"], "width": style.get("mew", 1.0), "fill": fill}
        return self._keep(shape, path)

    def face(self, path: np.ndarray, **style) -> dict:
        """A filled polygon."""
        colours = {"fill": hexadecimal(style["facecolor"]), "edge": hexadecimal(style["edgecolor"])}
        return self._keep({"z": style["zorder"], "width": style["lw"], **colours}, path)

    def name(
        self, text: str, paths: list[np.ndarray], towards: np.ndarray, distance: float, **style
    ) -> None:
        """A name beside the place of a joint, where it hides least at the start."""
        towards = np.asarray(towards) / (np.hypot(*towards) or 1.0)
        path, towards, distance = self.room.spot(text, paths, towards, distance, style["fontsize"])
        offset = [round(float(v), 2) for v in distance * np.asarray(towards)]
        self.labels.append({"text": text, "offset": offset, **self._resting(path[:, None])})

    def _keep(self, shape: dict, path: np.ndarray) -> dict:
        self._sweep(path)
        shape |= self._resting(path)
        self.shapes.append(shape)
        return shape

    def _springs(self) -> None:
        """Springs and dampers by their ends, for no body carries them."""
        for spring in (
            load for load in self.motion.scene["loads"] if load["type"] == "SpringDamper"
        ):
            along, across = ZIGZAG if spring["stiffness"] else DASHPOT
            held = {e: self._resting(self.motion.end(spring[e])[:, None]) for e in "ab"}
            points = _rounded(np.stack([along, np.array(across) * COIL * self.size], axis=-1))
            self.shapes.append({"z": 5, "edge": "#404040", "width": 1.0, "spring": points, **held})

    # --- where a shape rests
    def _resting(self, path: np.ndarray) -> dict:
        """The bodies that a shape lies about and turns with, and its points there."""
        path = np.broadcast_to(path, (len(self.motion.times), *path.shape[1:]))
        bodies = ["ground", *self.motion.coms]
        for body in bodies:
            points = self._back(path - self._centre(body), body)
            if self._rests(points):
                return {"turn": body, "points": _rounded(points[0])}
        parts = (*self.motion.scene["joints"], *self.motion.scene["loads"])
        for end in (end for part in parts for end in ends(part)):
            arms = path - self.motion.end(end)[:, None]
            for body in bodies:
                if self._rests(points := self._back(arms, body)):
                    return {"at": self._in_body(end), "turn": body, "points": _rounded(points[0])}
        raise ValueError(f"the drawing has a shape that rests in no body, about {path[0, 0]} m")

    def _in_body(self, end: dict) -> list:
        """A point of a body from its centre of mass."""
        com = self.motion.coms.get(end["body"], (0.0, 0.0))
        return [end["body"], *_rounded(np.array([end["x"], end["y"]]) - com)[0]]

    def _rests(self, points: np.ndarray) -> bool:
        return bool(np.nanmax(np.ptp(points, axis=0)) <= AT_REST * self.size)

    def _centre(self, body: str) -> np.ndarray:
        """Centre of mass of a body, (times, 1, 2) [m]."""
        return np.zeros((1, 1, 2)) if body == "ground" else self.motion.poses[body][:, None, :2]

    def _back(self, vectors: np.ndarray, body: str) -> np.ndarray:
        """Vectors (times, n, 2) along the axes of a body."""
        if body == "ground":
            return vectors
        angle = self.motion.poses[body][:, 2:]
        cos, sin = np.cos(angle), np.sin(angle)
        x, y = np.moveaxis(vectors, -1, 0)
        return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def _rounded(points: np.ndarray) -> list:
    """Points for JSON; a gap in a line is None."""
    return [
        None if np.isnan(p).any() else [float(f"{v:.{DIGITS}g}") for v in p]
        for p in np.atleast_2d(points)
    ]
