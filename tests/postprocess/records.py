"""Results made of formulas instead of a run, and a look at the pictures that were saved."""

import json

import numpy as np
from clearance.postprocess import figures

from clearance.results.record import Record

UNITS = {"x": "m", "vx": "m/s", "ax": "m/s2", "theta": "rad", "omega": "rad/s"}
EVENTS = ("time", "impact_speed", "peak_force", "duration")


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
        drive = {
            "type": "Drive",
            "target": "crank",
            "speed": speed,
            "start": start,
            "name": "crank",
        }
        scene = {
            "bodies": [{"name": "slider"}],
            "joints": list(joints),
            "loads": [drive] if speed else [],
        }
        self.attributes = {"case": "formula", "scene": json.dumps(scene), "status": status}
        time = np.asarray(time, float)
        self.data = {"time": time} | {
            p: v(time) if callable(v) else np.asarray(v) for p, v in channels.items()
        }
        self.events = {n: np.zeros(0) for n in EVENTS} | {
            "joint": np.zeros(0, str),
            "kind": np.zeros(0, str),
        }
        self.events |= {n: np.asarray(v) for n, v in (events or {}).items()}

    def names(self, group):
        inside = (
            [p.removeprefix(f"{group}/") for p in self.data if p.startswith(f"{group}/")]
            if group
            else self.data
        )
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
    return {
        "type": "ClearanceRevolute",
        "name": name,
        "clearance": clearance,
        "contact": law,
        "transition": transition,
        "film": None,
        "friction": None,
        "lubricant": None,
        "length": None,
        "roughness": None,
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

    def texts(self):
        """Everything that is written on the last figure."""
        from matplotlib.text import Text

        return [t.get_text() for t in self.last.findobj(Text) if t.get_text()]

    def smallest_text(self):
        """Size of the smallest letters [pt]."""
        from matplotlib.text import Text

        return min(
            t.get_fontsize() for t in self.last.findobj(Text) if t.get_text() and t.get_visible()
        )
