"""Mechanisms as drawings: bodies, slides, springs and ground of a result, posed at any of its times."""

from pathlib import Path

import numpy as np
from clearance.postprocess import channels
from clearance.postprocess.figures import save, sheet
from clearance.postprocess.labels import headline

from clearance.results import Record

#: fills of the bodies, one after the other
FILLS = ("#a6cee3", "#fdbf6f", "#b2df8a", "#cab2d6", "#fb9a99", "#e5c494", "#9ad6c8", "#d9d9d9")
EDGE, GROUND, CLEARANCE = "0.25", "0.45", "tab:blue"
#: sizes over that of the mechanism: half a block, ground symbols, breadth of springs
BLOCK, PIVOT, COIL = (0.045, 0.028), 0.022, 0.018
#: springs and dampers as places along their line and offsets across it
ZIGZAG = ((0.0, 0.15, *np.linspace(0.2, 0.8, 9), 0.85, 1.0), (0.0, 0.0, *[1.0, -1.0] * 4, 1.0, 0.0, 0.0))
DASHPOT = (
    (0.0, 0.4, 0.4, 0.6, 0.6, 0.4, 0.4, np.nan, 0.6, 1.0),
    (0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.0, np.nan, 0.0, 0.0),
)
MM = 1e3


def period(record: Record) -> float:
    """Time of one turn of the drive [s]; of the whole run where nothing turns at constant speed.

    Raises ValueError for a result of fewer than two samples.
    """
    if record.time.size < 2:
        raise ValueError(f"{channels.name_of(record)} has {record.time.size} sample(s): nothing moves")
    return record.turn or float(record.time[-1] - record.time[0])


class Motion:
    """Poses of all bodies at some times [s]: those of the samples, or interpolated between them.

    Raises ValueError naming a pose channel that the result has not got, and for times outside the run.
    """

    def __init__(self, record: Record, times: np.ndarray):
        self.scene, self.times = record.scene, np.asarray(times, float)
        self.coms = {b["name"]: np.array(b["com"]) for b in self.scene["bodies"]}
        self.poses = {
            name: np.stack(
                [channels.at(record, f"bodies/{name}/{c}", self.times) for c in ("x", "y", "theta")], axis=-1
            )
            for name in self.coms
        }

    def turned(self, body: str, vectors) -> np.ndarray:
        """Vectors (n, 2) of a body's frame along the fixed axes, (times, n, 2)."""
        vectors = np.atleast_2d(np.asarray(vectors, float))
        angle = np.zeros((len(self.times), 1)) if body == "ground" else self.poses[body][:, 2:]
        cos, sin, (x, y) = np.cos(angle), np.sin(angle), vectors.T
        return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)

    def points(self, body: str, points) -> np.ndarray:
        """Where points (n, 2) of a body's frame [m] are, (times, n, 2) [m]."""
        if body == "ground":
            return self.turned(body, points)
        return self.poses[body][:, None, :2] + self.turned(body, np.asarray(points, float) - self.coms[body])

    def end(self, end: dict) -> np.ndarray:
        """Where an end of a joint or spring is, (times, 2) [m]."""
        return self.points(end["body"], (end["x"], end["y"]))[:, 0]


def ends(part: dict) -> list[dict]:
    """The points of bodies that a joint or load is attached to."""
    return [part[e] for e in ("a", "b", "point") if isinstance(part.get(e), dict)]


def outline(scene: dict, body: dict) -> np.ndarray:
    """Points (n, 2) of a body's frame [m] that its drawing joins, in order round their middle.

    They are its named points and those where joints and loads are attached; a body of one point reaches from there
    to its centre of mass.
    """
    attached = [e for part in (*scene["joints"], *scene["loads"]) for e in ends(part) if e["body"] == body["name"]]
    points = [*body["points"].values(), *((e["x"], e["y"]) for e in attached)]
    if len(set(map(tuple, points))) < 2:
        points.append(body["com"])
    points = np.unique(np.asarray(points, float), axis=0)
    x, y = (points - points.mean(axis=0)).T
    return points[np.argsort(np.arctan2(y, x), kind="stable")]


def wall(centre, normal, half: float, pitch: float) -> np.ndarray:
    """A hatched line (n, 2) broken by NaN, `half` to both sides of `centre`; the hatching is behind `normal`."""
    normal = np.asarray(normal, float) / np.hypot(*normal)
    along = np.array([-normal[1], normal[0]])
    feet = np.asarray(centre) + along * np.linspace(-half, half, max(round(2.0 * half / pitch), 1) + 1)[:, None]
    ticks = np.stack([feet, feet - 0.7 * pitch * (normal + along), np.full_like(feet, np.nan)], axis=1)
    return np.concatenate([feet[[0, -1]], [[np.nan, np.nan]], ticks.reshape(-1, 2)])


def coil(a: np.ndarray, b: np.ndarray, shape: tuple, breadth: float) -> np.ndarray:
    """A spring or damper between two paths (times, 2), as lines (times, n, 2)."""
    along, across = np.array(shape[0])[:, None], np.array(shape[1])[:, None]
    line = (b - a)[:, None]
    length = np.maximum(np.hypot(line[..., 0], line[..., 1]), 1e-300)[..., None]
    normal = line[..., ::-1] * (-1.0, 1.0) / length
    return a[:, None] + along * line + breadth * across * normal


class Slide:
    """A prismatic joint as a block on a guide; `guide` is the body that carries the line, `block` the other one."""

    def __init__(self, motion: Motion, joint: dict):
        guide, block = joint["a"], joint["b"]
        # a slide whose b is ground is the same slide seen from ground: neither side turns
        axis = motion.turned(guide["body"], joint["axis"])[:, 0]
        if swapped := block["body"] == "ground":
            guide, block = block, guide
        self.guide, self.block, self.at, self.axis = guide["body"], block["body"], motion.end(block), axis
        places = np.sum((self.at - motion.end(guide)) * axis, axis=-1)
        # a rod reaches to the point that it is fixed to; a rail has none
        own = [] if self.guide == "ground" else [0.0]
        self.reach = (min([places.min(), *own]), max([places.max(), *own]))
        self.origin, self.direction = (guide["x"], guide["y"]), axis[0] if swapped else joint["axis"]

    def line(self, motion: Motion, extra: float) -> np.ndarray:
        """The guide, `extra` longer than what the block covers, (times, 2, 2) [m]."""
        reach = np.array([[self.reach[0] - extra], [self.reach[1] + extra]])
        return motion.points(self.guide, self.origin + reach * self.direction)

    def below(self) -> np.ndarray:
        """Normal (2,) of a guide on ground, on the lower side of it (the right-hand one of an upright guide)."""
        x, y = self.axis[0]
        normal = np.array([y, -x])
        return normal if x > 1e-3 or (abs(x) <= 1e-3 and y > 0.0) else -normal

    def label(self, motion: Motion, size: float) -> tuple[np.ndarray, np.ndarray]:
        """Where the joint's name goes, (times, 2) [m], and the direction (2,) from there."""
        if self.guide == "ground":
            return self.line(motion, 0.0)[:, 1] + BLOCK[1] * size * self.below(), self.below()
        tip = self.line(motion, 1.7 * BLOCK[0] * size)
        return tip[:, 1], tip[0, 1] - tip[0, 0]

    def corners(self, half: tuple[float, float]) -> np.ndarray:
        """Corners of the block, (times, 4, 2) [m]."""
        along, across = half[0] * self.axis[:, None], half[1] * (self.axis[:, None, ::-1] * (-1.0, 1.0))
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
        return self.at[:, None] + signs[:, :1] * along + signs[:, 1:] * across


class Drawing:
    """A mechanism on axes in mm, as artists that `show` moves from one time of its motion to another.

    low, high: corners (2,) [mm] of what it sweeps over all times; rings: the circles of the clearance joints; moving:
    artists, what sets them, and what it is given at each time.
    """

    def __init__(self, motion: Motion, axes):
        self.motion, self.axes, self.moving, self.rings = motion, axes, [], {}
        self.low, self.high = np.full(2, np.inf), np.full(2, -np.inf)
        scene = motion.scene
        self.slides = {j["name"]: Slide(motion, j) for j in scene["joints"] if j["type"] == "Prismatic"}
        self.bodies = {b["name"]: outline(scene, b) for b in scene["bodies"]}
        paths = [motion.points(b, p) for b, p in self.bodies.items()]
        paths += [motion.end(e)[:, None] for part in (*scene["joints"], *scene["loads"]) for e in ends(part)]
        swept = np.concatenate([p.reshape(-1, 2) for p in paths])
        gyration = max(np.sqrt(b["inertia"] / b["mass"]) for b in scene["bodies"])
        self.size = float(np.ptp(swept, axis=0).max()) or 2.0 * gyration
        self.fills = {b: FILLS[i % len(FILLS)] for i, b in enumerate(self.bodies)}
        self._ground()
        self._springs()
        for slide in self.slides.values():
            self._guide(slide)
        for body, points in self.bodies.items():
            self._body(body, points)
        for slide in self.slides.values():
            self._block(slide)
        for joint in scene["joints"]:
            self._joint(joint)
        for drive in (load for load in scene["loads"] if load["type"] == "Drive"):
            self._drive(drive)
        axes.set_aspect("equal")

    def show(self, k: int) -> None:
        """Move everything to time `k` of the motion."""
        for _, put, path in self.moving:
            put(path[k])

    def line(self, path: np.ndarray, **style):
        """A line (times, n, 2) [m] that moves; one whose first length is 1 stays."""
        (artist,) = self.axes.plot([], [], **style)
        self._place(artist, lambda xy: artist.set_data(*xy.T), path)
        return artist

    def face(self, path: np.ndarray, **style):
        """A filled polygon (times, n, 2) [m]."""
        (artist,) = self.axes.fill([], [], **style)
        self._place(artist, artist.set_xy, path)
        return artist

    def name(self, text: str, path: np.ndarray, towards: np.ndarray, distance: float, **style):
        """A name at a distance [point] from a path (times, 2) [m], in a direction (2,) of any length."""
        x, y = np.asarray(towards) / (np.hypot(*towards) or 1.0)
        side = {"ha": "left" if x > 0.5 else "right" if x < -0.5 else "center", "va": "center", "zorder": 9}
        box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
        offset = (distance * x * (0.7 if side["ha"] != "center" else 1.0), distance * y)
        artist = self.axes.annotate(text, (0.0, 0.0), offset, textcoords="offset points", bbox=box, **side, **style)
        artist.set_in_layout(False)
        self._place(artist, lambda xy: setattr(artist, "xy", xy), path)

    def _place(self, artist, put, path: np.ndarray) -> None:
        path = MM * path
        flat = path.reshape(-1, 2)
        self.low, self.high = np.fmin(self.low, np.nanmin(flat, axis=0)), np.fmax(self.high, np.nanmax(flat, axis=0))
        put(path[0])
        if len(path) > 1:
            self.moving.append((artist, put, path))

    def _ground(self) -> None:
        """Triangle and hatching under each pivot on ground, a wall behind each spring that hangs on it."""
        size, style = PIVOT * self.size, {"color": GROUND, "lw": 1.0, "zorder": 1}
        for joint in self.motion.scene["joints"]:
            for end in ends(joint) if joint["type"] != "Prismatic" else ():
                if end["body"] == "ground":
                    at = np.array([end["x"], end["y"]])
                    base = at + size * np.array([(0.0, 0.0), (-1.0, -1.6), (1.0, -1.6)])
                    self.face(base[None], facecolor="white", edgecolor=GROUND, lw=1.0, zorder=1)
                    self.line(wall(base[1:].mean(axis=0), (0.0, 1.0), 1.6 * size, 0.64 * size)[None], **style)
        for spring in (load for load in self.motion.scene["loads"] if load["type"] == "SpringDamper"):
            for end, other in ((spring["a"], spring["b"]), (spring["b"], spring["a"])):
                if end["body"] == "ground":
                    towards = self.motion.end(other).mean(axis=0) - (end["x"], end["y"])
                    normal = towards if towards.any() else (0.0, 1.0)
                    self.line(wall((end["x"], end["y"]), normal, 1.6 * size, 0.64 * size)[None], **style)

    def _springs(self) -> None:
        for spring in (load for load in self.motion.scene["loads"] if load["type"] == "SpringDamper"):
            shape = ZIGZAG if spring["stiffness"] else DASHPOT
            path = coil(self.motion.end(spring["a"]), self.motion.end(spring["b"]), shape, COIL * self.size)
            self.line(path, color=EDGE, lw=1.0, zorder=5)

    def _guide(self, slide: Slide) -> None:
        """A hatched rail on ground, a rod on a body that moves."""
        path = slide.line(self.motion, 1.7 * BLOCK[0] * self.size)
        if slide.guide != "ground":
            self.line(path, color=EDGE, lw=4.0, solid_capstyle="round", zorder=2)
            self.line(path, color=self.fills[slide.guide], lw=2.5, solid_capstyle="round", zorder=2.1)
            return
        (start, end), below = path[0], slide.below()
        half, centre = 0.5 * np.hypot(*(end - start)), 0.5 * (start + end) + BLOCK[1] * self.size * below
        self.line(wall(centre, -below, half, 0.64 * PIVOT * self.size)[None], color=GROUND, lw=1.0, zorder=1)

    def _body(self, body: str, points: np.ndarray) -> None:
        """A bar through two points, a plate through more; a box where a body has one point and no slide."""
        path = self.motion.points(body, points)
        if len(points) == 1:
            if body in {s.block for s in self.slides.values()}:
                return
            half = BLOCK[1] * self.size * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
            path = path + self.motion.turned(body, half)
        for colour, width in ((EDGE, 7.0), (self.fills[body], 5.0)):
            if len(points) == 2:
                self.line(path, color=colour, lw=width, solid_capstyle="round", zorder=3)
            else:
                self.face(path, facecolor=colour, edgecolor=colour, lw=width, joinstyle="round", zorder=3)

    def _block(self, slide: Slide) -> None:
        half = (BLOCK[0] * self.size, BLOCK[1] * self.size)
        self.face(slide.corners(half), facecolor=self.fills[slide.block], edgecolor=EDGE, lw=1.0, zorder=4)

    def _joint(self, joint: dict) -> None:
        """A small circle; a clearance joint has a ring (its bearing) round a dot (its journal)."""
        if joint["type"] == "Prismatic":
            return
        style = {"marker": "o", "ls": "none", "zorder": 8, "markerfacecolor": "white"}
        bearing, journal = self.motion.end(joint["a"])[:, None], self.motion.end(joint["b"])[:, None]
        if joint["type"] == "ClearanceRevolute":
            self.rings[joint["name"]] = self.line(bearing, ms=9.0, mew=2.0, color=CLEARANCE, **style)
            self.line(journal, **(style | {"markerfacecolor": EDGE}), ms=2.5, color=EDGE)
        else:
            self.line(bearing, ms=5.5, mew=1.2, color=EDGE, **style)

    def _drive(self, drive: dict) -> None:
        """A round arrow about the hinge that is driven; on a body, about its hinge on ground."""
        target = drive["target"]
        hinges = [j for j in self.motion.scene["joints"] if j["type"] != "Prismatic"]
        if isinstance(target, dict):
            found = [j for j in hinges if j["name"] == target["name"]]
        else:
            found = [j for j in hinges if {e["body"] for e in ends(j)} == {target, "ground"}]
        for joint in found[:1]:
            angle = np.linspace(-0.5, 3.4, 30)[:, None]
            arc = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
            arc = np.concatenate([arc, arc[-1] + [(0.24, 0.16), (0.0, 0.0), (-0.24, 0.24)]])
            mirror = (-1.0 if (drive["speed"] or 0.0) < 0.0 else 1.0, 1.0)
            path = self.motion.end(joint["b"])[:, None] + 1.3 * BLOCK[0] * self.size * arc * mirror
            self.line(path, color=EDGE, lw=1.2, zorder=7)


def name_joints(drawing: Drawing, k: int, only=None) -> None:
    """Names beside the joints (`only` some), on the side away from the bodies they join at time `k`."""
    motion = drawing.motion
    for joint in motion.scene["joints"]:
        name = joint["name"]
        if only is not None and name not in only:
            continue
        if name in drawing.slides:
            path, away = drawing.slides[name].label(motion, drawing.size)
            drawing.name(name, path, away, 12.0, fontsize=9, fontweight="bold")
            continue
        path = motion.end(joint["b"])
        joined = [e["body"] for e in ends(joint) if e["body"] != "ground"]
        away = path[k] - np.mean([motion.points(b, drawing.bodies[b])[k].mean(axis=0) for b in joined], axis=0)
        if len(joined) < 2:  # the ground symbol is below
            away = np.array([-1.0 if away[0] < 0.0 else 1.0, 0.2]) * drawing.size
        drawing.name(name, path, away, 13.0, fontsize=9, fontweight="bold")


def name_bodies(drawing: Drawing, k: int) -> None:
    """Names beside the middles of the bodies, across what they are long along at time `k`."""
    for body, points in drawing.bodies.items():
        path = drawing.motion.points(body, points)
        arms = path[k] - path[k].mean(axis=0)
        along = arms[np.argmax(np.hypot(*arms.T))]
        across = np.array([-along[1], along[0]]) if along.any() else np.array([0.0, 1.0])
        across = across if across[0] > 0.0 or along[1] == 0.0 else -across
        distance = 17.0 if len(points) == 1 else 9.0
        drawing.name(body, path.mean(axis=1), across, distance, fontsize=8, color="0.35", style="italic")


def trace(drawing: Drawing) -> None:
    """Paths of the bodies' points over all times, that of the last body bold."""
    *_, last = drawing.bodies
    for body, points in drawing.bodies.items():
        bold = {"color": "tab:red", "lw": 1.4, "label": f"path of {last}"} if body == last else {}
        for i, path in enumerate(np.moveaxis(drawing.motion.points(body, points), 1, 0)):
            style = {"color": "0.6", "lw": 0.7, "zorder": 2.5} | bold | ({"label": None} if i else {})
            drawing.line(path[None], **style)


def sketch(record: Record, path: str | Path, *, at: float = 0.0, trails: bool = True) -> Path:
    """A still picture of a mechanism with names, to scale in mm, saved under `path`.

    at: when, in turns of the drive from the start of the run, or as a share of a run without a drive of constant
    speed; the sample next to it is drawn. trails: paths of the bodies' points over the turn from there on, or the last
    one. Raises ValueError for times outside the run and for pose channels that were not kept.
    """
    turn, time = period(record), record.time
    if not 0.0 <= at <= (time[-1] - time[0]) / turn + 1e-9:
        raise ValueError(f"at must lie in [0, {(time[-1] - time[0]) / turn:.6g}], the length of the run; got {at!r}")
    start = max(min(time[0] + at * turn, time[-1] - turn), time[0])
    times = time[(time >= start - 1e-9 * turn) & (time <= start + (1.0 + 1e-9) * turn)]
    motion, k = Motion(record, times), int(np.abs(times - time[0] - at * turn).argmin())
    figure = sheet(8.0, 6.0)
    axes = figure.add_subplot()
    drawing = Drawing(motion, axes)
    if trails:
        trace(drawing)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize="small", frameon=False)
    name_bodies(drawing, k)
    name_joints(drawing, k)
    drawing.show(k)
    width, height = frame(drawing)
    figure.set_size_inches(8.0, np.clip(7.0 * height / width + 1.2, 3.0, 9.0))
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    figure.suptitle(headline([record], [""], f"t = {1e3 * times[k]:.4g} ms", width=8.0), fontsize="medium")
    figure.draw_without_rendering()  # the layout of axes with equal scales settles in a second pass
    return save(figure, path)


def frame(drawing: Drawing, share: float = 0.08) -> tuple[float, float]:
    """Set limits with a margin, a share of the mechanism's size, round all that it sweeps; width and height [mm]."""
    margin = share * MM * drawing.size
    (left, bottom), (right, top) = drawing.low - margin, drawing.high + margin
    drawing.axes.set(xlim=(left, right), ylim=(bottom, top))
    return right - left, top - bottom
