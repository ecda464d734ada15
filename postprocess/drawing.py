"""Mechanisms as drawings: bodies, slides, springs and ground of a result, posed at any of its
times.
"""

from pathlib import Path

import numpy as np
from clearance.postprocess import channels
from clearance.postprocess.figures import save, sheet
from clearance.postprocess.labels import headline, shown_in

from clearance.results.extremes import SLIDES
from clearance.results.record import Record

#: fills of the bodies, one after the other
FILLS = ("#a6cee3", "#fdbf6f", "#b2df8a", "#cab2d6", "#fb9a99", "#e5c494", "#9ad6c8", "#d9d9d9")
EDGE, GROUND, CLEARANCE = "0.25", "0.45", "tab:blue"
#: sizes over that of the mechanism: half a block, ground symbols, breadth of springs
BLOCK, PIVOT, COIL = (0.045, 0.028), 0.022, 0.018
#: springs and dampers as places along their line and offsets across it
ZIGZAG = (
    (0.0, 0.15, *np.linspace(0.2, 0.8, 9), 0.85, 1.0),
    (0.0, 0.0, *[1.0, -1.0] * 4, 1.0, 0.0, 0.0),
)
DASHPOT = (
    (0.0, 0.4, 0.4, 0.6, 0.6, 0.4, 0.4, np.nan, 0.6, 1.0),
    (0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.0, np.nan, 0.0, 0.0),
)
MM = 1e3
#: most way of a point that does not move, over the mechanism's size
STILL = 1e-6
#: share of the mechanism's size that is half the breadth of a cylinder
CYLINDER = 0.018
#: directions about the one given in which names are tried [rad], nearest first, and how much
#: further away
TRIED = tuple(np.radians([0, 30, -30, 60, -60, 90, -90, 135, -135, 180]))
FURTHER = (1.0, 1.8)
#: height and breadth of a letter over its size, spacing of the points that drawn lines count by
#: [pt]
LETTER, SPACING = (1.35, 0.62), 4.0
BOLD = {"color": "tab:red", "lw": 1.4}
#: colour of forces, and the length of their arrows over the mechanism's size
FORCE, ARROW = "tab:purple", 0.11
FORCES = ("Force", "FollowerForce")
#: pitch of drawn teeth over the mechanism's size, their height over the pitch, and the places of a
#: tooth along it and across it
PITCH, TEETH = 0.045, 0.35
TOOTH = np.array([(-0.25, -0.5), (-0.12, 0.5), (0.12, 0.5), (0.25, -0.5)])
#: breadth and height of a picture's axes [inch], at most
PAPER = (7.0, 7.8)


def period(record: Record) -> float:
    """Time of one turn of the drive [s]; of the entire run where nothing turns at constant speed.

    Raises ValueError for a result of fewer than two samples.
    """
    if record.time.size < 2:
        raise ValueError(
            f"{channels.name_of(record)} has {record.time.size} sample(s): nothing moves"
        )
    return record.turn or float(record.time[-1] - record.time[0])


class Motion:
    """Poses of all bodies at some times [s]: those of the samples, or interpolated between them.

    Raises ValueError naming a pose channel that the result does not have, and for times outside the
    run.
    """

    def __init__(self, record: Record, times: np.ndarray):
        self.scene, self.times = record.scene, np.asarray(times, float)
        self.coms = {b["name"]: np.array(b["com"][:2]) for b in self.scene["bodies"]}
        self.poses = {
            name: np.stack(
                [
                    channels.at(record, f"bodies/{name}/{c}", self.times)
                    for c in ("x", "y", "theta")
                ],
                axis=-1,
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
        """Positions (times, n, 2) [m] of points (n, 2) of a body's frame [m]."""
        if body == "ground":
            return self.turned(body, points)
        return self.poses[body][:, None, :2] + self.turned(
            body, np.asarray(points, float) - self.coms[body]
        )

    def end(self, end: dict) -> np.ndarray:
        """Positions of an end of a joint or spring, (times, 2) [m]."""
        return self.points(end["body"], (end["x"], end["y"]))[:, 0]


def ends(part: dict) -> list[dict]:
    """The points of bodies that a joint or load is attached to."""
    return [part[e] for e in ("a", "b", "point") if isinstance(part.get(e), dict)]


def outline(scene: dict, body: dict) -> np.ndarray:
    """Points (n, 2) of a body's frame [m] that its drawing joins, in order round their middle.

    They are its named points and those where joints and loads are attached; a body of one point
    reaches from there to its centre of mass.
    """
    attached = [
        e
        for part in (*scene["joints"], *scene["loads"])
        for e in ends(part)
        if e["body"] == body["name"]
    ]
    points = [*(p[:2] for p in body["points"].values()), *((e["x"], e["y"]) for e in attached)]
    if len(set(map(tuple, points))) < 2:
        points.append(body["com"][:2])
    points = np.unique(np.asarray(points, float), axis=0)
    x, y = (points - points.mean(axis=0)).T
    return points[np.argsort(np.arctan2(y, x), kind="stable")]


def bar(points: np.ndarray) -> list[int] | None:
    """Two of a body's points (n, 2) [m] that are its ends, where all lie on a line; else None."""
    arms = points - points.mean(axis=0)
    _, breadths, axes = np.linalg.svd(arms)
    if len(points) < 2 or breadths[1] > 1e-6 * breadths[0]:
        return None
    along = arms @ axes[0]
    return [int(along.argmin()), int(along.argmax())]


def wall(centre, normal, half: float, pitch: float) -> np.ndarray:
    """A hatched line (n, 2) broken by NaN, `half` to both sides of `centre`; the hatching is behind
    `normal`.
    """
    normal = np.asarray(normal, float) / np.hypot(*normal)
    along = np.array([-normal[1], normal[0]])
    feet = (
        np.asarray(centre)
        + along * np.linspace(-half, half, max(round(2.0 * half / pitch), 1) + 1)[:, None]
    )
    ticks = np.stack(
        [feet, feet - 0.7 * pitch * (normal + along), np.full_like(feet, np.nan)], axis=1
    )
    return np.concatenate([feet[[0, -1]], [[np.nan, np.nan]], ticks.reshape(-1, 2)])


def coil(a: np.ndarray, b: np.ndarray, shape: tuple, breadth: float) -> np.ndarray:
    """A spring or damper between two paths (times, 2), as lines (times, n, 2)."""
    along, across = np.array(shape[0])[:, None], np.array(shape[1])[:, None]
    line = (b - a)[:, None]
    length = np.maximum(np.hypot(line[..., 0], line[..., 1]), 1e-300)[..., None]
    normal = line[..., ::-1] * (-1.0, 1.0) / length
    return a[:, None] + along * line + breadth * across * normal


def toothed(radius: float, pitch: float) -> np.ndarray:
    """A wheel about its centre, (n, 2) [m]: teeth of about a pitch [m] on its pitch circle."""
    count = max(round(2.0 * np.pi * radius / pitch), 6)
    turns = (np.arange(count)[:, None] + TOOTH[:, 0]).ravel() / count
    radii = radius + TEETH * pitch * np.tile(TOOTH[:, 1], count)
    points = radii * np.exp(2j * np.pi * turns)
    return np.stack([points.real, points.imag], axis=-1)


class Slide:
    """A prismatic joint as a block on a guide; `guide` is the body that carries the line, `block`
    the other one.

    outlines: of the bodies. Of two bars along one line the guide is a cylinder, from `reach[0]` to
        `reach[1]` along it, and the other one a rod in it.
    """

    def __init__(self, motion: Motion, joint: dict, outlines: dict[str, np.ndarray]):
        guide, block, self.name = joint["a"], joint["b"], joint["name"]
        # a slide whose b is ground is the same slide seen from ground: neither side turns
        axis = motion.turned(guide["body"], joint["axis"])[:, 0]
        if swapped := block["body"] == "ground":
            guide, block = block, guide
        self.guide, self.block, self.at, self.axis = (
            guide["body"],
            block["body"],
            motion.end(block),
            axis,
        )
        places = np.sum((self.at - motion.end(guide)) * axis, axis=-1)
        # a rod reaches to the point that it is fixed to; a rail has none
        reach = [] if self.guide == "ground" else [0.0]
        self.reach = (min([places.min(), *reach]), max([places.max(), *reach]))
        self.origin, self.direction = (
            (guide["x"], guide["y"]),
            axis[0] if swapped else joint["axis"],
        )
        #: half length and height of the block [m], where the joint has them
        self.half = (0.5 * joint["overlap"], 0.5 * joint["height"]) if "height" in joint else None
        moving = self.half is None and "ground" not in (self.guide, self.block)
        self.cylinder = moving and self._telescopes(motion, outlines)

    def _telescopes(self, motion: Motion, outlines: dict[str, np.ndarray]) -> bool:
        """True where both bodies are bars along the axis, one out of the other; the reach is that
        of the cylinder.
        """
        origin, across = motion.points(self.guide, self.origin), self.axis[:, ::-1] * (-1.0, 1.0)
        offsets = [motion.points(b, outlines[b]) - origin for b in (self.guide, self.block)]
        block, rod = (np.einsum("tni,ti->tn", o, self.axis) for o in offsets)
        aside = max(np.abs(np.einsum("tni,ti->tn", o, across)).max() for o in offsets)
        length = min(np.ptp(block[0]), np.ptp(rod[0]))
        if aside > 1e-6 * length:
            return False
        ahead, behind = (rod.max(axis=1) > block.max()).all(), (rod.min(axis=1) < block.min()).all()
        places = np.sum((self.at - origin[:, 0]) * self.axis, axis=-1)
        low, high = places.min() - 0.1 * length, places.max() + 0.1 * length
        self.reach = (
            (block.min(), max(high, block.max())) if ahead else (min(low, block.min()), block.max())
        )
        return bool(length > 0.0 and ahead != behind)

    def tube(self, motion: Motion, half: float) -> np.ndarray:
        """Corners of the cylinder, `half` its breadth, (times, 4, 2) [m]."""
        start, end = np.moveaxis(self.line(motion, 0.0), 1, 0)
        across = half * self.axis[:, ::-1] * (-1.0, 1.0)
        return np.stack([start - across, end - across, end + across, start + across], axis=1)

    def piston(self, half: float) -> np.ndarray:
        """Line across the rod where it is held, (times, 2, 2) [m]."""
        across = half * self.axis[:, ::-1] * (-1.0, 1.0)
        return np.stack([self.at - across, self.at + across], axis=1)

    def line(self, motion: Motion, extra: float) -> np.ndarray:
        """The guide, `extra` longer than what the block covers, (times, 2, 2) [m]."""
        reach = np.array([[self.reach[0] - extra], [self.reach[1] + extra]])
        return motion.points(self.guide, self.origin + reach * self.direction)

    def below(self) -> np.ndarray:
        """Normal (2,) of a guide on ground, on the lower side of it (the right-hand one of an
        upright guide).
        """
        x, y = self.axis[0]
        normal = np.array([y, -x])
        return normal if x > 1e-3 or (abs(x) <= 1e-3 and y > 0.0) else -normal

    def label(self, motion: Motion, size: float) -> tuple[np.ndarray, np.ndarray]:
        """Place of the joint's name, (times, 2) [m], and the direction (2,) from there."""
        if self.guide == "ground":
            return self.line(motion, 0.0)[:, 1] + BLOCK[1] * size * self.below(), self.below()
        if self.cylinder:
            return self.line(motion, 0.0).mean(axis=1), self.axis[0, ::-1] * (-1.0, 1.0)
        tip = self.line(motion, 1.7 * BLOCK[0] * size)
        return tip[:, 1], tip[0, 1] - tip[0, 0]

    def corners(self, half: tuple[float, float]) -> np.ndarray:
        """Corners of the block, (times, 4, 2) [m]."""
        along, across = (
            half[0] * self.axis[:, None],
            half[1] * (self.axis[:, None, ::-1] * (-1.0, 1.0)),
        )
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
        return self.at[:, None] + signs[:, :1] * along + signs[:, 1:] * across


def _round() -> np.ndarray:
    """A round arrow of radius 1 about the origin, counterclockwise, (n, 2)."""
    angle = np.linspace(-0.5, 3.4, 30)[:, None]
    arc = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([arc, arc[-1] + [(0.24, 0.16), (0.0, 0.0), (-0.24, 0.24)]])


ROUND = _round()


def _sign(amount: float | dict) -> float:
    """Sign of a number; 1 for a law of time."""
    return float(np.sign(amount)) if np.isscalar(amount) else 1.0


class Drawing:
    """A mechanism on axes in mm, as artists that `show` moves from one time of its motion to
    another.

    low, high: corners (2,) [mm] of what it sweeps over all times; rings: the circles of the
    clearance joints; arrows: begin and head of those of forces, by name; moving: artists, what sets
    them, and what it is given at each time; drawn: paths of lines and faces [mm]; room: where names
    may go, None where they keep to their first places.
    """

    def __init__(self, motion: Motion, axes):
        self.motion, self.axes, self.moving, self.rings, self.drawn, self.room = (
            motion,
            axes,
            [],
            {},
            [],
            None,
        )
        self.low, self.high = np.full(2, np.inf), np.full(2, -np.inf)
        scene, self.arrows = motion.scene, {}
        self.bodies = {b["name"]: outline(scene, b) for b in scene["bodies"]}
        slides = (j for j in scene["joints"] if j["type"] in SLIDES)
        self.slides = {j["name"]: Slide(motion, j, self.bodies) for j in slides}
        paths = [motion.points(b, p) for b, p in self.bodies.items()]
        paths += [
            motion.end(e)[:, None]
            for part in (*scene["joints"], *scene["loads"])
            for e in ends(part)
        ]
        swept = np.concatenate([p.reshape(-1, 2) for p in paths])
        gyration = max(np.sqrt(b["inertia"] / b["mass"]) for b in scene["bodies"])
        self.size = float(np.ptp(swept, axis=0).max()) or 2.0 * gyration
        self.fills = {b: FILLS[i % len(FILLS)] for i, b in enumerate(self.bodies)}
        self._ground()
        self._springs()
        self.wheels: set[str] = set()
        for gear in (load for load in scene["loads"] if load["type"] == "Gear"):
            self._gear(gear)
        for slide in self.slides.values():
            self._guide(slide)
        for body, points in self.bodies.items():
            self._body(body, points)
        for slide in self.slides.values():
            self._block(slide)
        for joint in scene["joints"]:
            self._joint(joint)
        self._drives()
        for load in scene["loads"]:
            if load["type"] in FORCES:
                self._force(load)
            elif load["type"] == "Torque":
                self._torque(load)

    def show(self, k: int) -> None:
        """Move everything to time `k` of the motion."""
        for _, put, path in self.moving:
            put(path[k])

    def line(self, path: np.ndarray, **style):
        """A line (times, n, 2) [m] that moves; one whose first length is 1 stays."""
        (artist,) = self.axes.plot([], [], **style)
        self._follow(artist, lambda xy: artist.set_data(*xy.T), path)
        return artist

    def face(self, path: np.ndarray, **style):
        """A filled polygon (times, n, 2) [m]."""
        (artist,) = self.axes.fill([], [], **style)
        self._follow(artist, artist.set_xy, path)
        return artist

    def name(
        self, text: str, paths: list[np.ndarray], towards: np.ndarray, distance: float, **style
    ):
        """A name at a distance [point] from one of some paths (times, 2) [m], in a direction (2,)
        of any length.

        Where there is `room` to choose, the path, and a direction near the one given, are those
        where least is hidden.
        """
        towards, path = np.asarray(towards) / (np.hypot(*towards) or 1.0), paths[0]
        if self.room is not None:
            path, towards, distance = self.room.spot(
                text, paths, towards, distance, style["fontsize"]
            )
        side = {"ha": beside(towards[0]), "va": "center", "zorder": 9}
        box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
        offset = {
            "xytext": tuple(shifted(towards, distance)),
            "textcoords": "offset points",
            "bbox": box,
        }
        artist = self.axes.annotate(text, (0.0, 0.0), **offset, **side, **style)
        artist.set_in_layout(False)
        self._follow(artist, lambda xy: setattr(artist, "xy", xy), path)

    def _follow(self, artist, put, path: np.ndarray) -> None:
        path = self._sweep(path)
        put(path[0])
        if len(path) > 1:
            self.moving.append((artist, put, path))

    def _sweep(self, path: np.ndarray) -> np.ndarray:
        """Count a path [m] in what the drawing sweeps; it is returned in mm."""
        path = MM * path
        self.drawn.append(path)
        flat = path.reshape(-1, 2)
        self.low, self.high = (
            np.fmin(self.low, np.nanmin(flat, axis=0)),
            np.fmax(self.high, np.nanmax(flat, axis=0)),
        )
        return path

    def _ground(self) -> None:
        """Triangle and hatching under each pivot on ground, a wall behind each spring that hangs on
        it.
        """
        size, style = PIVOT * self.size, {"color": GROUND, "lw": 1.0, "zorder": 1}
        for joint in self.motion.scene["joints"]:
            for end in ends(joint) if joint["type"] not in SLIDES else ():
                if end["body"] == "ground":
                    at = np.array([end["x"], end["y"]])
                    base = at + size * np.array([(0.0, 0.0), (-1.0, -1.6), (1.0, -1.6)])
                    self.face(base[None], facecolor="white", edgecolor=GROUND, lw=1.0, zorder=1)
                    self.line(
                        wall(base[1:].mean(axis=0), (0.0, 1.0), 1.6 * size, 0.64 * size)[None],
                        **style,
                    )
        for spring in (
            load for load in self.motion.scene["loads"] if load["type"] == "SpringDamper"
        ):
            for end, other in ((spring["a"], spring["b"]), (spring["b"], spring["a"])):
                if end["body"] == "ground":
                    towards = self.motion.end(other).mean(axis=0) - (end["x"], end["y"])
                    normal = towards if towards.any() else (0.0, 1.0)
                    self.line(
                        wall((end["x"], end["y"]), normal, 1.6 * size, 0.64 * size)[None], **style
                    )

    def _springs(self) -> None:
        for spring in (
            load for load in self.motion.scene["loads"] if load["type"] == "SpringDamper"
        ):
            shape = ZIGZAG if spring["stiffness"] else DASHPOT
            path = coil(
                self.motion.end(spring["a"]), self.motion.end(spring["b"]), shape, COIL * self.size
            )
            self.line(path, color=EDGE, lw=1.0, zorder=5)

    def _gear(self, gear: dict) -> None:
        """Both wheels with their teeth, or the wheel of a rack; a ring is a line."""
        joints = {j["name"]: j for j in self.motion.scene["joints"]}
        first, second = joints[gear["first"]["name"]], joints[gear["second"]["name"]]
        ratio, radii = gear["ratio"], [abs(gear["ratio"])]
        if second["type"] not in SLIDES:
            apart = float(
                np.hypot(*(self.motion.end(first["b"])[0] - self.motion.end(second["b"])[0]))
            )
            radii = [abs(ratio / (1.0 - ratio)) * apart, apart / abs(1.0 - ratio)]
        for joint, radius in zip((first, second), radii, strict=False):
            body, pin = joint["b"]["body"], (joint["b"]["x"], joint["b"]["y"])
            if body in self.wheels:
                continue
            self.wheels.add(body)
            path = self.motion.points(body, pin + toothed(radius, PITCH * self.size))
            if joint is second and ratio > 0.0:
                path = np.concatenate([path, path[:, :1]], axis=1)
                self.line(path, color=EDGE, lw=1.0, zorder=1.5)
            else:
                fill = self.fills.get(body, "white")
                self.face(path, facecolor=fill, edgecolor=EDGE, lw=1.0, zorder=2.2)

    def _guide(self, slide: Slide) -> None:
        """A hatched rail on ground, a rod on a body that moves."""
        path = slide.line(self.motion, 1.7 * (slide.half or (BLOCK[0] * self.size,))[0])
        if slide.cylinder:
            return
        if slide.guide != "ground":
            self.line(path, color=EDGE, lw=4.0, solid_capstyle="round", zorder=2)
            self.line(
                path, color=self.fills[slide.guide], lw=2.5, solid_capstyle="round", zorder=2.1
            )
            return
        (start, end), below = path[0], slide.below()
        half, middle = 0.5 * np.hypot(*(end - start)), 0.5 * (start + end)
        style, pitch = {"color": GROUND, "lw": 1.0, "zorder": 1}, 0.64 * PIVOT * self.size
        height = slide.half[1] if slide.half else BLOCK[1] * self.size
        self.line(wall(middle + height * below, -below, half, pitch)[None], **style)
        if slide.half:
            self.line(wall(middle - height * below, below, half, pitch)[None], **style)

    def _body(self, body: str, points: np.ndarray) -> None:
        """A bar through two points, a plate through more; a box where a body has one point and no
        slide.
        """
        path = self.motion.points(body, points)
        if body in {s.guide for s in self.slides.values() if s.cylinder}:
            return
        if len(points) == 1:
            if body in {s.block for s in self.slides.values()} | self.wheels:
                return
            half = BLOCK[1] * self.size * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
            path = path + self.motion.turned(body, half)
        straight = bar(points)
        path = path if straight is None else path[:, straight]
        for colour, width in ((EDGE, 7.0), (self.fills[body], 5.0)):
            if straight is not None:
                self.line(path, color=colour, lw=width, solid_capstyle="round", zorder=3)
            else:
                self.face(
                    path, facecolor=colour, edgecolor=colour, lw=width, joinstyle="round", zorder=3
                )

    def _block(self, slide: Slide) -> None:
        """A box on the guide, or a cylinder round the rod with its piston."""
        half = (BLOCK[0] * self.size, BLOCK[1] * self.size)
        if slide.cylinder:
            breadth = CYLINDER * self.size
            tube = slide.tube(self.motion, breadth)
            self.face(tube, facecolor=self.fills[slide.guide], edgecolor=EDGE, lw=1.0, zorder=4)
            self.line(slide.piston(breadth), color=EDGE, lw=2.0, solid_capstyle="butt", zorder=4.1)
            return
        corners = slide.corners(slide.half or half)
        block = self.face(
            corners, facecolor=self.fills[slide.block], edgecolor=EDGE, lw=1.0, zorder=4
        )
        if slide.half:
            self.rings[slide.name] = block

    def _joint(self, joint: dict) -> None:
        """A small circle; a clearance joint has a ring (its bearing) round a dot (its journal)."""
        if joint["type"] in SLIDES:
            return
        style = {"marker": "o", "ls": "none", "zorder": 8, "markerfacecolor": "white"}
        bearing, journal = (
            self.motion.end(joint["a"])[:, None],
            self.motion.end(joint["b"])[:, None],
        )
        if joint["type"] == "ClearanceRevolute":
            self.rings[joint["name"]] = self.line(
                bearing, ms=9.0, mew=2.0, color=CLEARANCE, **style
            )
            self.line(journal, **(style | {"markerfacecolor": EDGE}), ms=2.5, color=EDGE)
        else:
            self.line(bearing, ms=5.5, mew=1.2, color=EDGE, **style)

    def _drives(self) -> None:
        """A round arrow about each hinge that is driven, a straight one beside each slide."""
        joints = {j["name"]: j for j in self.motion.scene["joints"]}
        angles = [
            self._driven(load, joints)
            for load in self.motion.scene["loads"]
            if load["type"] == "Drive"
        ]
        hinges = [j for j in angles if j is not None and j["type"] not in SLIDES]
        places = np.array([self.motion.end(j["b"])[0] for j in hinges]).reshape(-1, 2)
        apart = np.hypot(*np.moveaxis(places[:, None] - places, -1, 0))
        radius = 1.3 * BLOCK[0] * self.size
        radius = np.clip(0.4 * apart[apart > 0.0].min(initial=np.inf), 0.3 * radius, radius)
        for joint in hinges:
            self._round_arrow(joint, radius)
        for joint in angles:
            if joint is not None and joint["type"] in SLIDES:
                self._straight_arrow(self.slides[joint["name"]])

    def _driven(self, drive: dict, joints: dict[str, dict]) -> dict | None:
        """The joint that a drive moves; of a driven body its hinge on ground, where it has one."""
        target = drive["target"]
        if isinstance(target, dict):
            return joints[target["name"]]
        hinges = (j for j in joints.values() if j["type"] not in SLIDES)
        return next((j for j in hinges if {e["body"] for e in ends(j)} == {target, "ground"}), None)

    def _force(self, load: dict) -> None:
        """An arrow from the point of a force; of a law of time in its positive direction."""
        x, y = (load[axis] for axis in "xy")
        along = np.array([x, y] if all(np.isscalar(v) for v in (x, y)) else [_sign(x), _sign(y)])
        if not along.any():
            return
        along = along / np.hypot(*along)
        shape = np.array([(0.0, 0.0), (1.0, 0.0), (0.7, -0.15), (1.0, 0.0), (0.7, 0.15)])
        shape = shape @ np.array([along, (-along[1], along[0])])
        frame = "ground" if load["type"] == "Force" else load["point"]["body"]
        arrow = ARROW * self.size * self.motion.turned(frame, shape)
        path = self.motion.end(load["point"])[:, None] + arrow
        self.line(path, color=FORCE, lw=1.6, zorder=8)
        self.arrows[load.get("name")] = path[:, 0], path[:, 1]

    def _torque(self, load: dict) -> None:
        """A round arrow about the centre of mass of the body, which turns with it."""
        arc = ROUND * ((-1.0 if _sign(load["torque"]) < 0.0 else 1.0), 1.0)
        around = self.motion.coms[load["body"]] + 0.5 * ARROW * self.size * arc
        path = self.motion.points(load["body"], around)
        self.line(path, color=FORCE, lw=1.6, zorder=8)

    def _round_arrow(self, joint: dict, radius: float) -> None:
        """In the sense in which the hinge turns over all times."""
        mirror = (
            -1.0 if self._turn(joint["b"]["body"]) < self._turn(joint["a"]["body"]) else 1.0,
            1.0,
        )
        path = self.motion.end(joint["b"])[:, None] + radius * ROUND * mirror
        self.line(path, color=EDGE, lw=1.2, zorder=7)

    def _turn(self, body: str) -> float:
        return (
            0.0
            if body == "ground"
            else float(self.motion.poses[body][-1, 2] - self.motion.poses[body][0, 2])
        )

    def _straight_arrow(self, slide: Slide) -> None:
        """Along the axis, both ways."""
        along, across = (
            1.2 * BLOCK[0] * self.size,
            (1.6 if slide.cylinder else 2.4) * BLOCK[1] * self.size,
        )
        head, none = np.array([(0.7, -0.15), (1.0, 0.0), (0.7, 0.15)]), [(np.nan, np.nan)]
        shape = np.concatenate([head, none, [(1.0, 0.0), (-1.0, 0.0)], none, -head])
        axis = slide.axis[:, None]
        side = axis[..., ::-1] * (-1.0, 1.0)
        if slide.guide == "ground":
            side = -side if (slide.below() @ side[0, 0]) > 0.0 else side
        path = (
            slide.at[:, None] + along * (shape[:, :1] * axis + shape[:, 1:] * side) + across * side
        )
        self.line(path, color=EDGE, lw=1.2, zorder=7)


class Room:
    """Free places for names on a picture of time `k`, at `scale` [pt/mm]: away from each other and
    from what is drawn.

    boxes: left, bottom, right, top of the names so far [pt]; points (n, 2): of drawn lines and
        joints [pt].
    """

    def __init__(self, drawing: Drawing, k: int, scale: float):
        self.k, self.scale, self.boxes = k, scale, []
        paths = [scale * path[min(k, len(path) - 1)] for path in drawing.drawn]
        self.points = np.concatenate([_points_along(path) for path in paths])

    def spot(
        self, text: str, paths: list[np.ndarray], towards: np.ndarray, distance: float, size: float
    ) -> tuple:
        """Path, direction and distance [pt] with which a name of letters of a `size` [pt] hides
        least.
        """
        best, least = None, np.inf
        for path in paths:
            at = MM * self.scale * path[min(self.k, len(path) - 1)]
            for turn in TRIED:
                cos, sin = np.cos(turn), np.sin(turn)
                direction = np.array(
                    [cos * towards[0] - sin * towards[1], sin * towards[0] + cos * towards[1]]
                )
                for further in FURTHER:
                    box = _box(text, at, direction, further * distance, size)
                    hidden = self._hidden(box) + 0.5 * abs(turn) + 2.0 * (further - 1.0)
                    if hidden < least:
                        best, least = (path, direction, further * distance, box), hidden
        self.boxes.append(best[-1])
        return best[:-1]

    def _hidden(self, box: np.ndarray) -> float:
        inside = ((self.points > box[:2]) & (self.points < box[2:])).all(axis=1).sum()
        others = np.array(self.boxes).reshape(-1, 4)
        overlap = np.minimum(box[2:], others[:, 2:]) - np.maximum(box[:2], others[:, :2])
        return float(inside) + 20.0 * float((overlap > 0.0).all(axis=1).sum())


def _points_along(path: np.ndarray) -> np.ndarray:
    """Points (m, 2) along a path (n, 2) [pt] that may have gaps; of a single point those of the
    circle of a joint.
    """
    if len(path) == 1:
        angle = np.linspace(0.0, 2.0 * np.pi, 9)[:-1, None]
        return path + 4.0 * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    pairs = np.stack([path[:-1], path[1:]], axis=1)
    pairs = pairs[np.isfinite(pairs).all(axis=(1, 2))]
    counts = [max(int(np.hypot(*(b - a)) / SPACING), 1) + 1 for a, b in pairs]
    return np.concatenate([np.linspace(a, b, n) for (a, b), n in zip(pairs, counts, strict=True)])


def beside(x: float) -> str:
    """On which side of its place a name begins that lies in a direction of component x."""
    return "left" if x > 0.5 else "right" if x < -0.5 else "center"


def shifted(direction: np.ndarray, distance: float) -> np.ndarray:
    """Offset (2,) [pt] of a name; names beside their place begin nearer to it than those above and
    below.
    """
    return (
        distance * np.asarray(direction) * (1.0 if beside(direction[0]) == "center" else 0.7, 1.0)
    )


def _box(
    text: str, at: np.ndarray, direction: np.ndarray, distance: float, size: float
) -> np.ndarray:
    """Left, bottom, right and top of a name [pt], about."""
    x, y = at + shifted(direction, distance)
    height, breadth = LETTER[0] * size, LETTER[1] * size * len(text)
    near = x - {"left": 0.0, "center": 0.5, "right": 1.0}[beside(direction[0])] * breadth
    return np.array([near, y - 0.5 * height, near + breadth, y + 0.5 * height])


def name_joints(drawing: Drawing, k: int, only=None) -> None:
    """Names beside the joints (`only` some), on the side away from the bodies they join at time
    `k`.
    """
    motion = drawing.motion
    for joint in motion.scene["joints"]:
        name = joint["name"]
        if only is not None and name not in only:
            continue
        if name in drawing.slides:
            path, away = drawing.slides[name].label(motion, drawing.size)
            drawing.name(name, [path], away, 12.0, fontsize=9, fontweight="bold")
            continue
        path = motion.end(joint["b"])
        joined = [e["body"] for e in ends(joint) if e["body"] != "ground"]
        away = path[k] - np.mean(
            [motion.points(b, drawing.bodies[b])[k].mean(axis=0) for b in joined], axis=0
        )
        if len(joined) < 2:  # the ground symbol is below
            away = np.array([-1.0 if away[0] < 0.0 else 1.0, 0.2]) * drawing.size
        drawing.name(name, [path], away, 13.0, fontsize=9, fontweight="bold")


def name_bodies(drawing: Drawing, k: int) -> None:
    """Names beside the middles of the bodies, or of their sides, across what they are long along at
    time `k`.
    """
    for body, points in drawing.bodies.items():
        path = drawing.motion.points(body, points)
        arms = path[k] - path[k].mean(axis=0)
        along = arms[np.argmax(np.hypot(*arms.T))]
        across = np.array([-along[1], along[0]]) if along.any() else np.array([0.0, 1.0])
        across = across if across[0] > 0.0 or along[1] == 0.0 else -across
        distance = 17.0 if len(points) == 1 else 9.0
        sides = 0.5 * (path + np.roll(path, 1, axis=1)) if len(points) > 2 else path[:, :0]
        places = [path.mean(axis=1), *np.moveaxis(sides, 1, 0)]
        drawing.name(body, places, across, distance, fontsize=8, color="0.35", style="italic")


def name_forces(drawing: Drawing, k: int) -> None:
    """Names at the heads of the arrows of forces."""
    for name, (begin, head) in drawing.arrows.items():
        if name:
            style = {"fontsize": 8, "color": FORCE}
            drawing.name(name, [head], head[k] - begin[k], 9.0, **style)


def trace(drawing: Drawing) -> None:
    """Paths of the bodies' points over all times, bold that of the point that a force acts on, else
    of the last body that has one which moves.

    The halves of a telescope are left out: their ends are points of other bodies.
    """
    scene, motion = drawing.motion.scene, drawing.motion
    halves = {b for s in drawing.slides.values() if s.cylinder for b in (s.guide, s.block)}
    places = {b: motion.points(b, p) for b, p in drawing.bodies.items() if b not in halves}
    bodies = [b for b, p in places.items() if np.ptp(p, axis=0).max() > STILL * drawing.size]
    pushed = next((load["point"] for load in scene["loads"] if load["type"] == "Force"), None)
    for body in bodies:
        paths = np.moveaxis(places[body], 1, 0)
        bold = pushed is None and body == bodies[-1]
        for i, path in enumerate(paths):
            style = BOLD | {"label": None if i else f"path of {body}"} if bold else {}
            drawing.line(path[None], **({"color": "0.6", "lw": 0.7, "zorder": 2.5} | style))
    if pushed is not None:
        drawing.line(
            motion.end(pushed)[None], zorder=2.5, label=f"path of {_called(pushed)}", **BOLD
        )


def _called(end: dict) -> str:
    """A point of a body in words."""
    return end["body"] if end["point"].startswith("(") else f"{end['body']} {end['point']}"


def sketch(record: Record, path: str | Path, *, at: float = 0.0, trails: bool = True) -> Path:
    """A still picture of a mechanism with names, to scale in mm, saved under `path`.

    at: instant, in turns of the drive from the start of the run, or as a share of a run without a
        drive of constant speed. The sample next to it is drawn. trails: paths of the bodies' points
        over the turn from there on, or the last one.
    Raises ValueError for times outside the run and for pose channels that were not stored.
    """
    turn, time = period(record), record.time
    if not 0.0 <= at <= (time[-1] - time[0]) / turn + 1e-9:
        raise ValueError(
            f"at must lie in [0, {(time[-1] - time[0]) / turn:.6g}], the length of the run; got "
            f"{at!r}"
        )
    start = max(min(time[0] + at * turn, time[-1] - turn), time[0])
    times = time[(time >= start - 1e-9 * turn) & (time <= start + (1.0 + 1e-9) * turn)]
    motion, k = Motion(record, times), int(np.abs(times - time[0] - at * turn).argmin())
    figure = sheet(8.0, 6.0)
    axes = figure.add_subplot()
    drawing = Drawing(motion, axes)
    width, height = frame(drawing)
    drawing.room = Room(drawing, k, 72.0 * min(PAPER[0] / width, PAPER[1] / height))
    if trails:
        trace(drawing)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(
                loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize="small", frameon=False
            )
    name_joints(drawing, k)
    name_bodies(drawing, k)
    name_forces(drawing, k)
    drawing.show(k)
    width, height = frame(drawing)
    figure.set_size_inches(8.0, np.clip(PAPER[0] * height / width + 1.2, 3.0, PAPER[1] + 1.2))
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    figure.suptitle(
        headline([record], [""], f"t = {_clock(times[k])}", width=8.0), fontsize="medium"
    )
    figure.draw_without_rendering()  # the layout of axes with equal scales settles in a second pass
    return save(figure, path)


def _clock(time: float) -> str:
    unit, factor = shown_in("s", [time])
    return f"{factor * time:.4g} {unit}"


def frame(drawing: Drawing, share: float = 0.08) -> tuple[float, float]:
    """Set limits with a margin, a share of the mechanism's size, round all that it sweeps; width
    and height [mm].
    """
    margin = share * MM * drawing.size
    (low_x, bottom), (right, top) = drawing.low - margin, drawing.high + margin
    drawing.axes.set(xlim=(low_x, right), ylim=(bottom, top), aspect="equal")
    return right - low_x, top - bottom
