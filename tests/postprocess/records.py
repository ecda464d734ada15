"""Results made of formulas instead of a run, and a look at the pictures that were saved."""

import json

import numpy as np
from clearance.postprocess import figures
from matplotlib.text import Text

from clearance.results.record import Record

UNITS = {"x": "m", "vx": "m/s", "ax": "m/s2", "theta": "rad", "omega": "rad/s"}
EVENTS = ("time", "impact_speed", "peak_force", "duration", "joint", "kind")


class Formula(Record):
    """A slider whose channels are given functions of time, driven by a crank at `speed` (None: by
    nothing).

    channels: path -> function or values; joints: descriptions of clearance joints; events: columns
        of contacts.
    """

    solver, warnings = {}, []

    def __init__(
        self,
        time,
        channels,
        *,
        speed=2.0 * np.pi,
        start=0.0,
        joints=(),
        events=None,
        status="complete",
    ):
        drive = {"type": "Drive", "target": "crank", "speed": speed, "start": start}
        scene = {
            "bodies": [{"name": "slider"}],
            "joints": list(joints),
            "loads": [drive | {"name": "crank"}] if speed else [],
        }
        self.attributes = {"case": "formula", "scene": json.dumps(scene), "status": status}
        time = np.asarray(time, float)
        self.data = {"time": time} | {
            p: v(time) if callable(v) else np.asarray(v) for p, v in channels.items()
        }
        none = dict.fromkeys(EVENTS, np.zeros(0)) | dict.fromkeys(
            ("joint", "kind"), np.zeros(0, str)
        )
        self.events = none | {n: np.asarray(v) for n, v in (events or {}).items()}

    def names(self, group):
        start = f"{group}/" if group else ""
        inside = [p.removeprefix(start) for p in self.data if p.startswith(start)]
        return tuple(dict.fromkeys(p.partition("/")[0] for p in inside))

    def values(self, path):
        return self.data[path]

    def units(self, path):
        return UNITS.get(path.rpartition("/")[2], "N")

    def facts(self, group):
        return {}


def joint(name="C", clearance=1e-3, contact="flores", transition=None, bearing="ground"):
    """A clearance joint as scenes describe it."""
    law = {"law": f"clearance.laws.contact:{contact}", "restitution": 0.9} if contact else None
    empty = dict.fromkeys(("film", "friction", "lubricant", "length", "roughness"))
    return empty | {
        "type": "ClearanceRevolute",
        "name": name,
        "clearance": clearance,
        "contact": law,
        "transition": transition,
        "a": {"body": bearing},
        "b": {"body": "slider"},
    }


class Gallery:
    """The figures saved while a test runs."""

    def __init__(self, monkeypatch):
        self.figures, save = [], figures.save

        def keep(figure, path, dpi=150):
            self.figures.append(figure)
            return save(figure, path, dpi)

        monkeypatch.setattr(figures, "save", keep)

    @property
    def last(self):
        return self.figures[-1]

    @property
    def panels(self):
        """Axes of the last figure that are no colour bars."""
        return [a for a in self.last.axes if a.get_label() != "<colorbar>"]

    @property
    def bars(self):
        """Labels of its colour bars."""
        return [a.get_ylabel() for a in self.last.axes if a.get_label() == "<colorbar>"]

    @property
    def legend(self):
        """Names in its first legend."""
        return [plain(t.get_text()) for t in self.last.legends[0].get_texts()]

    @property
    def written(self):
        """Text objects of the last figure that are not empty."""
        return [t for t in self.last.findobj(Text) if t.get_text()]

    def texts(self):
        """Everything that is written on it, blanks that do not break as others."""
        return [plain(t.get_text()) for t in self.written]

    @property
    def text(self):
        """All of that in one."""
        return " ".join(self.texts())

    def smallest_text(self):
        """Size of the smallest letters [pt]."""
        return min(t.get_fontsize() for t in self.written if t.get_visible())


def plain(text: str) -> str:
    """A text whose blanks may all break."""
    return text.replace("\u00a0", " ")
