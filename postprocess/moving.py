"""A run as a page that moves has it: facts as plain data, numbers in a `Pack`.

A run of many samples is thinned. Of each stretch of samples the page has the first one, and the
smallest and the largest value of every channel, so that no peak is lost.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from clearance.postprocess import labels
from clearance.postprocess.animation import COLOURS, STRONG, states_at
from clearance.postprocess.channels import KINDS, WHOLE, channel, expand, name_of, principal
from clearance.postprocess.figures import hexadecimal
from clearance.postprocess.guides import MAGNIFIED, modes_at
from clearance.postprocess.measured import Comparison
from clearance.postprocess.packing import Pack
from clearance.postprocess.pages import date, scaled
from clearance.postprocess.plots import with_contacts
from clearance.postprocess.shapes import Shapes

from clearance.metrics.metrics import CORNERS, MODES, Window
from clearance.results.reading import Damaged
from clearance.results.record import Record

#: most numbers of a channel, most contacts and most pressure fields of a joint that a page has
NUMBERS, CONTACTS, FIELDS = 24_000, 20_000, 480
#: values of a channel for each stretch of a thinned run: the first, the smallest, the largest one
THINNED = 3
LEVELS = 255  # steps of a pressure field from 0 to its largest pressure
#: what a lens needs of each kind of joint with clearance
OFFSETS = {
    "journal": ("eccentricity_x", "eccentricity_y"),
    "slide": ("offset", "tilt"),
    "slot": ("offset",),
}
OF_TYPES = {
    "ClearanceRevolute": "journal",
    "ClearancePrismatic": "slide",
    "ClearancePinSlot": "slot",
}


@dataclass(frozen=True)
class Thinning:
    """Stretches of samples: the first sample of each."""

    starts: np.ndarray
    stretches: bool

    @classmethod
    def of(cls, first: int, count: int) -> "Thinning":
        """Of `count` samples from `first` on, as fine as a page holds."""
        length = 1 if count <= NUMBERS else -(-THINNED * count // NUMBERS)
        return cls(np.arange(first, first + count, length), length > 1)

    def columns(self, pack: Pack, values: np.ndarray) -> list:
        """Places of the first values, and of the smallest and largest ones of each stretch."""
        columns = [pack.add(values[self.starts])]
        if self.stretches:
            columns += [pack.add(f.reduceat(values, self.starts)) for f in (np.fmin, np.fmax)]
        return columns


class Moving:
    """Facts and numbers of one run.

    first: first sample that the page has; only: paths of the channels beside those that the picture
    of the mechanism needs, default all; settle: turns of the start-up, which the page opens after.
    Raises ValueError for a run of fewer than two samples, and as `expand` for channels.
    """

    def __init__(
        self,
        record: Record,
        label: str,
        *,
        only: Iterable[str] | None = None,
        settle: float | None = None,
        begin: float | None = None,
    ):
        if record.time.size < 2:
            raise ValueError(f"{name_of(record)} has {record.time.size} sample(s): nothing moves")
        self.record, self.pack = record, Pack()
        first = 0 if begin is None else int(np.searchsorted(record.time, begin * (1.0 - 1e-12)))
        first = min(first, record.time.size - 2)
        self.thinning = Thinning.of(first, record.time.size - first)
        self.settled = settled_time(record, settle)
        self.labels: dict[str, str] = {}
        self.units: dict[str, str] = {}
        self.largest: dict[str, float] = {}
        self.facts = {
            "label": label,
            "about": self._about(label),
            **self._clock(),
            "machine": self._machine(),
        }
        self.facts["columns"] = self._columns(only)
        self.facts["lenses"] = self._lenses()
        self.facts["contacts"] = self._contacts()
        self.facts["measured"] = []
        shares = record.errors.channels
        self.facts["errors"] = {p: shares[p] for p in self.facts["columns"] if p in shares}

    def _about(self, label: str) -> list[str]:
        """Name, description, status and age in words; warnings."""
        record = self.record
        age = (
            f"written {date(record.attributes['created'])}"
            if "created" in record.attributes
            else ""
        )
        count = len(record.warnings)
        warned = f"{count} warning{'s' if count > 1 else ''}: see clearance report" if count else ""
        parts = [name_of(record), labels.title(record), age, warned]
        return [part for part in parts if part and part != label]

    # --- time
    def _clock(self) -> dict:
        record, starts = self.record, self.thinning.starts
        time = record.time[starts]
        end = float(record.time[-1])
        clock = {"time": self.pack.add(time, "f8"), "end": end, "turn": record.turn}
        clock |= {"settled": max(self.settled, float(time[0])), "thinned": self.thinning.stretches}
        if record.uneven:
            clock["turns"] = self.pack.add(record.turns_at(time), "f8")
        return clock

    # --- mechanism
    def _machine(self) -> dict | None:
        """Shapes and poses; None, with the reason beside it, where poses were not stored."""
        try:
            document = Shapes(self.record).document()
        except Damaged:
            raise
        except ValueError as error:
            return {"missing": str(error)}
        bodies = [b["name"] for b in self.record.scene["bodies"]]
        return document | {
            "poses": {
                b: [self._samples(f"bodies/{b}/{c}") for c in ("x", "y", "theta")] for b in bodies
            }
        }

    def _samples(self, path: str) -> list:
        """A channel at the samples of the page, without extremes between them."""
        return self.pack.add(self.record.values(path)[self.thinning.starts])

    # --- curves
    def _columns(self, only: Iterable[str] | None) -> dict:
        """Path of each channel -> places of its numbers."""
        paths = self._paths() if only is None else expand(self.record, only)
        columns = {}
        for path in paths:
            channel_values = channel(self.record, path)
            values = channel_values.of([self.record.values(p) for p in channel_values.parts])
            columns[path] = self.thinning.columns(self.pack, values)
            self.labels[path], self.units[path] = channel_values.label, channel_values.units
            late = values[self.record.time >= self.settled]
            late = np.abs(late[np.isfinite(late)])
            self.largest[path] = float(late.max()) if late.size else 0.0
        return columns

    def _paths(self) -> list[str]:
        """All channels, and sizes of forces and eccentricities."""
        record = self.record
        groups = [f"{kind}/{owner}" for kind in KINDS for owner in record.names(kind)]
        groups += [group for group in WHOLE if record.names(group)]
        paths = []
        for group in groups:
            names = record.names(group)
            sizes = [s for s in ("force", "friction") if {f"{s}_x", f"{s}_y"} <= set(names)]
            sizes += ["epsilon"] if {"eccentricity_x", "eccentricity_y"} <= set(names) else []
            paths += [f"{group}/{n}" for n in (*sizes, *names)]
        return paths

    # --- clearances under lenses
    def _lenses(self) -> list[dict]:
        """Clearance joints whose motion was stored."""
        joints = {j["name"]: j for j in self.record.scene["joints"]}
        lenses = []
        for name in self.record.clearances:
            joint = joints[name]
            kind = OF_TYPES.get(joint["type"])
            if kind and set(OFFSETS[kind]) <= set(self.record.names(f"joints/{name}")):
                lenses.append(self._lens(joint, kind))
        return lenses

    def _lens(self, joint: dict, kind: str) -> dict:
        name, group = joint["name"], f"joints/{joint['name']}"
        entry = {"joint": name, "kind": kind, "clearance": joint["clearance"]}
        end = joint["b" if kind == "slide" else "a"]
        entry["end"] = [end["body"], *self._in_body(end)]
        entry |= self._path(joint, kind)
        if kind == "journal":
            entry |= self._states(*states_at(self.record, joint, self.record.time))
            entry |= self._worn(joint)
        if kind == "slide":
            modes = modes_at(self.record, name, self.record.time)
            entry |= self._states([*MODES], modes)
            entry |= {
                "magnified": MAGNIFIED,
                "height": joint["height"],
                "overlap": joint["overlap"],
            }
            entry["corners"] = [[x, y] for _, x, y in CORNERS]
        if kind != "slide" and {"force_x", "force_y"} <= set(self.record.names(group)):
            entry["force"] = [self._samples(f"{group}/force_{axis}") for axis in "xy"]
            entry["strong"] = self._strong(group)
        if (fields := self.record.pressure_fields(name)) is not None:
            entry["fields"] = self._fields(fields)
        return entry

    def _path(self, joint: dict, kind: str) -> dict:
        """Path of a journal, block or pin; of a dry journal with its contacts between samples."""
        if kind != "journal" or joint.get("film") or self.thinning.stretches:
            return {
                "offsets": [self._samples(f"joints/{joint['name']}/{n}") for n in OFFSETS[kind]]
            }
        path, _, clock = with_contacts(self.record, joint["name"])
        late = clock >= self.record.time[self.thinning.starts[0]]
        return {
            "offsets": [self.pack.add(values) for values in path[late].T],
            "clock": self.pack.add(clock[late], "f8"),
        }

    def _worn(self, joint: dict) -> dict:
        """Worn depths of bearing and journal over the angles of their bodies; {} where none is."""
        outline = joint.get("outline") or {}
        depths = [np.array(outline.get(surface, [0.0])) for surface in ("bearing", "journal")]
        if not any(d.any() for d in depths):
            return {}
        return {"worn": [self.pack.add(d) for d in depths], "turning": joint["b"]["body"]}

    def _in_body(self, end: dict) -> list[float]:
        """A point of a body from its centre of mass [m]."""
        com = next(
            (b["com"] for b in self.record.scene["bodies"] if b["name"] == end["body"]), (0.0, 0.0)
        )
        return [end["x"] - com[0], end["y"] - com[1]]

    def _states(self, names: list[str], states: np.ndarray) -> dict:
        """Names, colours and the driest state since the sample before."""
        driest = np.maximum.reduceat(states, self.thinning.starts)
        return {
            "states": [[n, hexadecimal(COLOURS[n])] for n in names],
            "state": self.pack.add(driest, "u1"),
        }

    def _strong(self, group: str) -> float:
        """The force whose arrow is as long as a radius [N]; impacts go far beyond."""
        record = self.record
        force = np.hypot(*(record.values(f"{group}/force_{axis}") for axis in "xy"))
        force = force[(record.time >= self.settled) & (force > 0.0)]
        return float(min(force.max(), STRONG * np.median(force))) if force.size else 1.0

    def _fields(self, fields) -> dict:
        """Pressures over the angle and the axis, in steps of the largest one of each instant."""
        late = np.flatnonzero(fields.time >= self.record.time[self.thinning.starts[0]])
        tops = np.maximum(fields.pressure.max(axis=(1, 2)), 1e-300)
        strongest = _strongest(tops, late)
        steps = np.round(
            LEVELS * np.clip(fields.pressure[strongest] / tops[strongest][:, None, None], 0.0, 1.0)
        )
        return {
            "time": self.pack.add(fields.time[strongest], "f8"),
            "top": self.pack.add(tops[strongest]),
            "steps": self.pack.add(steps, "u1"),
            "shape": [int(n) for n in fields.pressure.shape[1:]],
            "axial": [float(fields.axial[0]), float(fields.axial[-1])],
            "largest": float(
                tops[strongest][fields.time[strongest] >= self.settled].max(initial=0.0)
                or tops.max()
            ),
        }

    # --- impacts
    def _contacts(self) -> dict:
        """Start, place and strength of each contact; of very many the strongest."""
        events = self.record.events
        here = np.flatnonzero(events["time"] >= self.record.time[self.thinning.starts[0]])
        peaks = events["peak_force"][here]
        largest = np.sort(here[np.argsort(-peaks, kind="stable")[:CONTACTS]])
        largest = largest[np.argsort(events["time"][largest], kind="stable")]
        names = list(dict.fromkeys(map(str, events["joint"][largest])))
        places = {n: i for i, n in enumerate(names)}
        return {
            "joints": names,
            "joint": self.pack.add(
                np.array([places[str(n)] for n in events["joint"][largest]]), "u1"
            ),
            "time": self.pack.add(events["time"][largest], "f8"),
            "force": self.pack.add(events["peak_force"][largest]),
            "left_out": int(len(here) - len(largest)),
        }

    def lay(self, comparison: Comparison) -> str:
        """Add measured data over a channel; its path, which the page shows first."""
        (path, *_) = expand(self.record, comparison.channel)
        record = comparison.measured
        self.facts["measured"].append(
            {
                "path": path,
                "label": f"{record.path.name}, {record.column}",
                "time": self.pack.add(comparison.times, "f8"),
                "values": self.pack.add(record.values),
            }
        )
        self.facts["about"].append(f"measured {comparison}")
        return path

    def telling(self) -> list[str]:
        """Curves that a page shows before its reader chooses."""
        return [path for path in telling(self.record) if path in self.facts["columns"]]


def of_all(runs: list[Moving]) -> dict:
    """Facts of several runs, and of their channels the label and the unit that suits all."""
    channels = {}
    for path in dict.fromkeys(path for run in runs for path in run.labels):
        having = [run for run in runs if path in run.labels]
        units, factor = scaled(having[0].units[path], *(run.largest[path] for run in having))
        channels[path] = {"label": having[0].labels[path], "unit": units.strip(), "factor": factor}
    return {"runs": [run.facts for run in runs], "channels": channels}


def _strongest(tops: np.ndarray, late: np.ndarray) -> np.ndarray:
    """Places of the fields that a page has: all of few, of many the strongest of each stretch."""
    length = -(-late.size // FIELDS) or 1
    stretches = np.split(late, np.arange(length, late.size, length))
    return np.array([s[np.argmax(tops[s])] for s in stretches if s.size], int)


def settled_time(record: Record, settle: float | None) -> float:
    """End of the start-up [s], as metrics leave it out; 0 for a run that ended before it."""
    window = Window.of(record, settle)
    return 0.0 if window is None else window.begin


def telling(record: Record) -> list[str]:
    """Acceleration of the last body, efforts, forces and films of the first clearance joints."""
    joints = {j["name"]: j for j in record.scene["joints"]}
    loose = list(record.clearances)
    efforts = [f"drives/{d}/{e}" for d in record.names("drives") for e in ("torque", "force")]
    films = [f"joints/{j}/film_thickness_ratio" for j in loose if joints[j].get("film")]
    paths = [*_principal(record), *efforts, *(f"joints/{j}/force" for j in loose[:3]), *films[:2]]
    return [path for path in paths if path in record or f"{path}_x" in record]


def _principal(record: Record) -> list[str]:
    """Acceleration of the last body; none where its positions were not stored."""
    try:
        return [principal(record).format("a")]
    except Damaged:
        raise
    except ValueError:
        return []
