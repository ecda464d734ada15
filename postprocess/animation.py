"""Animations of a mechanism: the bodies to scale, and beside them every clearance joint under a
lens.
"""

from pathlib import Path

import numpy as np
from clearance.postprocess.channels import angle_at, drive_angle, name_of, series
from clearance.postprocess.drawing import EDGE, MM, Drawing, Motion, frame, name_joints, period
from clearance.postprocess.figures import check_film, save_film, sheet
from clearance.postprocess.guides import COLOURS as OF_MODES
from clearance.postprocess.guides import MAGNIFIED, block, modes_at, of_slides
from clearance.postprocess.labels import headline
from clearance.postprocess.plots import FLIGHT, STATES, touched

from clearance.metrics.metrics import CORNERS, MODES
from clearance.results.record import Record

#: types of joints that a lens shows
UNDER_A_LENS = ("ClearanceRevolute", "ClearancePrismatic")
#: colours of what a joint is doing; later states count as drier
COLOURS = STATES | FLIGHT | OF_MODES
TRAIL = 0.25  # turns of the journal's path that stay in sight
#: room of a lens: its radius over the breadth of its slot, height over breadth of the slot,
#: smallest and largest breadth over the mechanism's size
LENS, SLOT, ROOM = 0.4, 1.2, (0.3, 0.5)
ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
SLOW = 5e-3  # time between frames from which the clock counts seconds [s]
# of a lens, over its radius: where its pressure begins, the largest one's height
RIM, PRESSURE = 1.05, 0.6
FILM = "#7b2d8b"  # colour of pressures
STRONG = 3.0  # forces up to so many times the median have arrows to scale; impacts go far beyond


def animate(
    record: Record,
    path: str | Path,
    *,
    turns: float = 1.0,
    frames: int = 120,
    fps: float = 25.0,
    magnify: float | None = None,
) -> Path:
    """Animate the last turns of a run as a .gif, or an .mp4 where ffmpeg is installed; saved under
    `path` when complete.

    turns: of the drive at constant speed, without one the entire run counts as a turn; frames in
        all, at equal intervals, poses interpolated between samples; fps: frames a second (a .gif
        keeps hundredths of a second a frame).
    magnify: how many times larger than the mechanism all clearances are drawn (default: each as
        large as its lens). A lens shows the path of the journal's centre over the last quarter
        turn. It also shows the largest force on the journal since the frame before, at its place.
        Its colour is the driest state since the frame before, so that no contact is missed. Where
        the file holds pressure fields, the one last before a frame stands around the lens.
    Raises ValueError for a span longer than the run, more frames than it has samples, channels that
    were not stored, and files that cannot be written.
    """
    check_film(path, fps)
    times = frame_times(record, turns, frames)
    figure = sheet(8.0, 6.0)
    figure.set_layout_engine("none")
    drawing = Drawing(Motion(record, times), figure.add_subplot())
    joints = [j for j in record.scene["joints"] if j["type"] in UNDER_A_LENS]
    slides = of_slides(record)
    lenses = [(GuideLens if j["name"] in slides else Lens)(record, j, times) for j in joints]
    _arrange(lenses, drawing, magnify)
    strongest = _draw_lenses(lenses, drawing)
    name_joints(drawing, 0, only=[j["name"] for j in joints])
    _scale_bar(drawing)
    _page(figure, drawing, record, fps, strongest, lenses)
    drawing.show(0)
    moving = dict.fromkeys(artist for artist, *_ in drawing.moving)
    return save_film(figure, path, fps, frames, drawing.show, moving)


def frame_times(record: Record, turns: float, frames: int) -> np.ndarray:
    """Times [s] of the frames of the last turns, the last one at the end of the run.

    Raises ValueError as `animate`.
    """
    time, turn = record.time, period(record)
    run = (time[-1] - time[0]) / turn
    if not 0.0 < turns <= run * (1.0 + 1e-9):
        raise ValueError(f"turns must lie in (0, {run:.6g}], the length of the run; got {turns!r}")
    if not isinstance(frames, int) or frames < 2:
        raise ValueError(f"frames must be a whole number of at least 2, got {frames!r}")
    start = max(time[-1] - turns * turn, time[0])
    samples = int((time > start + 1e-9 * turn).sum())
    if frames > samples:
        raise ValueError(
            f"frames: {frames} asked, but {name_of(record)} has {samples} samples in its last "
            f"{turns:g} turn(s); "
            "ask for fewer frames or more turns, or simulate with more samples_per_turn"
        )
    return np.append(np.linspace(start, time[-1], frames + 1)[1:-1], time[-1])


class Lens:
    """Motion and state of a clearance joint at the samples and frames of an animation.

    eccentricity (n, 2) [m] and force on the journal (n, 2) [N] at `clock` (n,) [s]. state (n,):
    index into `states`; span of each frame: rows after the frame before, up to its own. Raises
    ValueError naming a channel not stored.
    """

    def __init__(self, record: Record, joint: dict, times: np.ndarray):
        self.joint, self.name, self.clearance = joint, joint["name"], joint["clearance"]
        self.reach = self.clearance
        step, trail = times[1] - times[0], TRAIL * period(record)
        since = times[0] - max(step, trail)
        self.clock = np.union1d(
            times, record.time[(record.time > since) & (record.time < times[-1])]
        )
        self.eccentricity, self.force = (self._pair(record, c) for c in ("eccentricity", "force"))
        self.states, self.state = states_at(record, joint, self.clock)
        ends = np.searchsorted(self.clock, times) + 1
        starts = np.append(np.searchsorted(self.clock, times[0] - step, side="right"), ends[:-1])
        self.spans = [slice(a, b) for a, b in zip(starts, ends, strict=True)]
        self.trails = [
            slice(a, b)
            for a, b in zip(np.searchsorted(self.clock, times - trail), ends, strict=True)
        ]
        strength = np.hypot(*self.force.T)
        self.peaks = np.array([s.start + strength[s].argmax() for s in self.spans])
        self.strength = strength[self.peaks]
        self.colours = [COLOURS[self.states[self.state[s].max()]] for s in self.spans]
        self.fields = record.pressure_fields(self.name)
        self.shown, self.turned = self._fields_of(record, times)

    def _at(self, record: Record, channel: str) -> np.ndarray:
        """A channel at the clock, straight between samples: journals fly straight, and contacts
        begin suddenly.
        """
        return np.interp(
            self.clock, record.time, series(record, f"joints/{self.name}/{channel}")[0]
        )

    def _pair(self, record: Record, channel: str) -> np.ndarray:
        return np.stack([self._at(record, f"{channel}_{axis}") for axis in "xy"], axis=-1)

    def _fields_of(self, record: Record, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Field that each frame shows, and the angle of the bearing then [rad]."""
        if self.fields is None:
            return np.zeros(0, int), np.zeros(0)
        body, shown = (
            self.joint["a"]["body"],
            np.searchsorted(self.fields.time, times, side="right") - 1,
        )
        if body not in record.names("bodies"):
            return np.maximum(shown, 0), np.zeros(times.size)
        return np.maximum(shown, 0), np.interp(
            times, record.time, series(record, f"bodies/{body}/theta")[0]
        )

    def _draw_pressure(self, drawing: Drawing) -> None:
        """The pressure in the middle of the bearing, outwards from its wall; none where the film
        cavitates.
        """
        middle = self.fields.pressure[:, self.fields.pressure.shape[1] // 2]
        height = PRESSURE * np.maximum(middle, 0.0) / max(self.fields.pressure.max(), 1e-300)
        angle = self.fields.angle + self.turned[:, None]
        out = (RIM + height[self.shown])[..., None] * np.stack(
            [np.cos(angle), np.sin(angle)], axis=-1
        )
        closed = np.concatenate([out, out[:, :1]], axis=1)
        drawing.line(
            self.centre + self.magnify * self.clearance * closed, color=FILM, lw=1.2, zorder=6
        )

    def draw(self, drawing: Drawing, strongest: float) -> None:
        """Circle, path and centre of the journal, force and captions, as artists of the drawing."""
        zoom, middle, radius = self.magnify, self.centre, self.magnify * self.clearance
        angle = np.linspace(0.0, 2.0 * np.pi, 181)
        wall = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        drawing.line((middle + wall)[None], color=EDGE, lw=0.8, zorder=4)
        rim = drawing.line((middle + 1.05 * wall)[None], lw=3.0, zorder=4)
        drawing.line(middle[None, None], marker="+", ms=7.0, color="0.7", zorder=4)
        if self.fields is not None:
            self._draw_pressure(drawing)
        x, y = MM * (middle + zoom * self.eccentricity).T
        for i, state in enumerate(self.states):
            here = self.state == i
            here[:-1] |= here[1:]  # a state holds from the row before on
            across = np.where(here, x, np.nan)
            (trail,) = drawing.axes.plot([], [], color=COLOURS[state], lw=1.2, zorder=5)
            drawing.moving.append(
                (
                    trail,
                    lambda s, line=trail, across=across: line.set_data(across[s], y[s]),
                    self.trails,
                )
            )
        journal = middle + zoom * self.eccentricity[[s.stop - 1 for s in self.spans]]
        drawing.line(self._arrow(strongest), color="black", lw=1.6, zorder=7)
        dot = drawing.line(
            journal[:, None], marker="o", ms=6.0, markeredgecolor="black", ls="none", zorder=8
        )
        ring = drawing.rings[self.name]
        for artist, put in ((rim, rim.set_color), (dot, dot.set_mfc), (ring, ring.set_mec)):
            drawing.moving.append((artist, put, self.colours))
        self._captions(drawing)

    def _arrow(self, strongest: float) -> np.ndarray:
        """The force as a line with a head, (frames, 5, 2) [m], as long as the lens's radius for
        `strongest` [N].
        """
        radius = self.magnify * self.clearance
        tail = self.centre + self.magnify * self.eccentricity[self.peaks]
        force = self.force[self.peaks]
        share = np.minimum(self.strength, strongest) / np.maximum(self.strength, 1e-300) / strongest
        arm = radius * share[:, None] * force
        length = np.maximum(np.hypot(*arm.T), 1e-300)[:, None]
        along = np.minimum(0.16 * radius / length, 0.5) * arm
        across = 0.5 * along[:, ::-1] * (-1.0, 1.0)
        tip = tail + arm
        return np.stack([tail, tip, tip - along + across, tip, tip - along - across], axis=1)

    def _captions(self, drawing: Drawing) -> None:
        (x, y), radius = MM * self.centre, MM * self.magnify * self.clearance

        def put(text: str, drop: float, **style):
            offset = {
                "xytext": (0.0, -drop),
                "textcoords": "offset points",
                "ha": "center",
                "va": "top",
            }
            return drawing.axes.annotate(text, (x, y - 1.1 * radius), **offset, **style)

        drawing.axes.text(
            x - radius, y + 0.95 * radius, self.name, fontsize=11, fontweight="bold", ha="center"
        )
        put(f"clearance {MM * self.clearance:.3g} mm shown × {self.magnify:.4g}", 3.0, fontsize=7.5)
        force = put("", 14.0, fontsize=8)
        drawing.moving.append(
            (force, force.set_text, [f"F = {_newtons(f)}" for f in self.strength])
        )


def states_at(record: Record, joint: dict, clock: np.ndarray) -> tuple[list[str], np.ndarray]:
    """State names of a journal, and which one holds from the row before to each row of a clock (n,)
    [s].
    """
    group = f"joints/{joint['name']}"

    def along(channel: str) -> np.ndarray:
        return np.interp(clock, record.time, series(record, f"{group}/{channel}")[0])

    if joint["transition"]:
        shares = [along(f"membership_{s.replace(' ', '_')}") for s in STATES]
        return list(STATES), np.argmax(shares, axis=0)
    if joint["film"]:
        return ["full film"], np.zeros(clock.size, int)
    touching = along("contact_force") > 0.0
    return list(FLIGHT), (touching | touched(record, joint["name"], clock)).astype(int)


class GuideLens:
    """Motion and state of a block in its guide at the frames of an animation, drawn as
    `guides.block` does.

    reach: half the height of the guide's drawing, magnified as the clearance is [m]; the other
        names as in Lens.
    """

    def __init__(self, record: Record, joint: dict, times: np.ndarray):
        self.joint, self.name, self.clearance = joint, joint["name"], joint["clearance"]
        self.reach = self.clearance * (1.0 + MAGNIFIED) / MAGNIFIED
        group, c = f"joints/{self.name}", self.clearance
        offset, tilt = (
            np.interp(times, record.time, record.values(f"{group}/{n}")) for n in ("offset", "tilt")
        )
        self.corners, self.walls = block(joint, offset / c, 0.5 * tilt * joint["overlap"] / c)
        peaks, self.forces = self._peaks(
            record, times, [f"{group}/contact_force_{i}" for i, _, _ in CORNERS]
        )
        offset, tilt = (record.values(f"{group}/{n}")[peaks] for n in ("offset", "tilt"))
        self.pushed, _ = block(joint, offset / c, 0.5 * tilt * joint["overlap"] / c)
        self.strength = self.forces.max(axis=0)
        self.fields, names = None, [*FLIGHT][:1] + list(MODES[1:])
        most = modes_at(record, self.name, np.concatenate([[2.0 * times[0] - times[1]], times]))[1:]
        self.colours = [OF_MODES[MODES[m]] for m in most]
        self.states = [name for i, name in enumerate(names) if (most == i).any()]

    @staticmethod
    def _peaks(
        record: Record, times: np.ndarray, paths: list[str]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sample with the largest force since the frame before, and the forces (paths, frames)
        there.
        """
        ends = np.searchsorted(record.time, times, side="right")
        starts = np.concatenate([[max(ends[0] - 1, 0)], ends[:-1]])
        values = np.stack([record.values(path) for path in paths])
        most = values.max(axis=0)
        spans = zip(starts, np.maximum(ends, starts + 1), strict=True)
        peaks = np.array([a + most[a:b].argmax() for a, b in spans])
        return peaks, values[:, peaks]

    def draw(self, drawing: Drawing, strongest: float) -> None:
        """Walls, block, forces on its corners and captions, as artists of the drawing."""
        scale = self.magnify * self.reach / np.abs(self.walls[..., 1]).max()
        faces, pushed = self.centre + scale * self.corners, self.centre + scale * self.pushed
        for wall in self.centre + scale * self.walls:
            drawing.line(wall[None], color=EDGE, lw=1.2, zorder=4)
        face = drawing.face(
            faces[:, [0, 1, 3, 2]], facecolor="white", edgecolor=EDGE, lw=1.0, zorder=5
        )
        for artist in (face, drawing.rings[self.name]):
            drawing.moving.append((artist, artist.set_edgecolor, self.colours))
        face.set_linewidth(2.0)
        for i, (_, _, side) in enumerate(CORNERS):
            length = (
                np.minimum(self.forces[i], strongest) / strongest * 0.6 * self.magnify * self.reach
            )
            tip = pushed[:, i] - side * np.array([0.0, 1.0]) * length[:, None]
            head = 0.12 * length[:, None] * np.array([1.0, 0.0])
            back = tip + side * np.array([0.0, 0.2]) * length[:, None]
            arrow = np.stack([pushed[:, i], tip, back + head, tip, back - head], axis=1)
            drawing.line(arrow, color="black", lw=1.6, zorder=7)
        x, y = MM * self.centre
        down = MM * self.magnify * self.reach
        text = (
            f"{self.name}: clearance {MM * self.clearance:.3g} mm shown × {self._zoom(scale):.4g}"
        )
        drawing.axes.text(
            x, y + 1.15 * down, self.name, fontsize=11, fontweight="bold", ha="center"
        )
        drawing.axes.text(
            x, y - 1.2 * down, text.partition(": ")[2], fontsize=7.5, ha="center", va="top"
        )
        style = {"textcoords": "offset points", "ha": "center", "va": "top", "fontsize": 8}
        force = drawing.axes.annotate("", (x, y - 1.2 * down), xytext=(0.0, -12.0), **style)
        drawing.moving.append(
            (force, force.set_text, [f"F = {_newtons(f)}" for f in self.strength])
        )

    def _zoom(self, scale: float) -> float:
        """Drawn clearance over the true one."""
        return scale * MAGNIFIED * 0.5 * self.joint["height"] / self.clearance


def _arrange(lenses: list[Lens], drawing: Drawing, magnify: float | None) -> None:
    """Give every lens its slot (breadth and centre, [m]) and magnification, beside or below all
    that moves.
    """
    if magnify is not None and not (lenses and np.isfinite(magnify) and magnify > 0.0):
        problem = (
            "this mechanism has no clearance joint" if not lenses else "must be a positive number"
        )
        raise ValueError(f"magnify {problem}, got {magnify!r}")
    if not lenses:
        return
    low, high = drawing.low / MM, drawing.high / MM
    (width, height), size = high - low, (high - low).max()
    below = width > 1.25 * height
    breadth = np.clip(
        width / len(lenses) if below else height / SLOT / len(lenses), *(size * np.array(ROOM))
    )
    if magnify is not None:
        widest = max(lens.reach for lens in lenses)
        if magnify * widest > size:
            raise ValueError(
                f"magnify must be at most {_rounded(size / widest):g}, which draws a clearance "
                f"about as large "
                f"as the mechanism; got {magnify!r}"
            )
        breadth = max(breadth, magnify * widest / LENS)
    room = width / breadth if below else height / SLOT / breadth
    line = max(int(1.2 * room), round(len(lenses) ** 0.5))  # lenses in a row or column
    for i, lens in enumerate(lenses):
        rank, column = divmod(i, line)
        middle = column - 0.5 * (min(line, len(lenses) - rank * line) - 1)
        if below:
            offset = (
                0.5 * (low[0] + high[0]) + middle * breadth,
                low[1] - (0.55 + rank) * SLOT * breadth,
            )
        else:
            offset = (
                high[0] + (0.6 + rank) * breadth,
                0.5 * (low[1] + high[1]) - middle * SLOT * breadth,
            )
        lens.centre = np.array(offset) + (0.0, 0.1 * breadth)
        lens.magnify = magnify or _rounded(LENS * breadth / lens.reach)
        corner = 0.5 * breadth * np.array([1.0, SLOT])
        drawing.low = np.minimum(drawing.low, MM * (offset - corner))
        drawing.high = np.maximum(drawing.high, MM * (offset + corner))


def _rounded(value: float) -> float:
    """The next round number downwards."""
    ten = 10.0 ** np.floor(np.log10(value))
    return float(ten * max(r for r in ROUND if r <= value / ten * (1.0 + 1e-9)))


def _draw_lenses(lenses: list[Lens], drawing: Drawing) -> float:
    """Draw all lenses with one scale of force; the force [N] whose arrow is as long as a radius."""
    shown = np.concatenate([lens.strength[lens.strength > 0.0] for lens in lenses] or [[]])
    strongest = float(min(shown.max(), STRONG * np.median(shown))) if shown.size else 1.0
    corners = drawing.low, drawing.high
    for lens in lenses:
        lens.draw(drawing, strongest)
    # a journal that has left its bearing leaves the picture too
    drawing.low, drawing.high = corners
    return strongest


def _scale_bar(drawing: Drawing) -> None:
    """A bar of a round length [mm] in the lower left corner of the picture."""
    size = MM * drawing.size
    length, tick = _rounded(0.2 * size), 0.01 * size
    x, y = drawing.low - np.array([0.0, 0.02]) * size
    drawing.axes.plot([x, x, x + length, x + length], [y + tick, y, y, y + tick], color=EDGE)
    drawing.axes.text(
        x + 0.5 * length, y + 0.5 * tick, f"{length:g} mm", fontsize=8, ha="center", va="bottom"
    )


def _page(
    figure, drawing: Drawing, record: Record, fps: float, strongest: float, lenses: list[Lens]
) -> None:
    """Fix limits and sizes, write title, clock and legend."""
    times, axes = drawing.motion.times, drawing.axes
    breadth, height = frame(drawing, 0.06)
    axes.axis("off")
    scale = min(8.5 / breadth, 7.0 / height)
    width, height = max(scale * breadth, 6.5), scale * height
    caption = headline([record], [""], width=width)
    above, below = 0.5 + 0.18 * len(caption.splitlines()), 0.55 if lenses else 0.1
    total = height + above + below
    figure.set_size_inches(width, total)
    axes.set_position((0.0, below / total, 1.0, height / total))
    figure.text(0.5, 1.0 - 0.08 / total, caption, ha="center", va="top", fontsize=10)
    style = {"ha": "center", "va": "center", "fontsize": 10, "family": "monospace"}
    clock = figure.text(0.5, 1.0 - (above - 0.15) / total, "", **style)
    slowed = 1.0 / fps / (times[1] - times[0])
    pace = f"slowed {slowed:.3g} times" if slowed >= 1.0 else f"sped up {1.0 / slowed:.3g} times"
    drawing.moving.append(
        (clock, clock.set_text, [f"{text}   {pace}" for text in _clock(record, times)])
    )
    if not lenses:
        return
    for state in dict.fromkeys(s for lens in lenses for s in lens.states):
        axes.plot([], [], color=COLOURS[state], lw=3.0, label=state)
    on = "journal or block" if any(isinstance(lens, GuideLens) for lens in lenses) else "journal"
    caption = (
        f"arrows: force on the {on}; as long as the lens's radius for {_newtons(strongest)} "
        "and more"
    )
    tops = [lens.fields.pressure.max() for lens in lenses if lens.fields is not None]
    if tops:
        high = f", {PRESSURE:g} radii high for {', '.join(f'{t / 1e6:.3g}' for t in tops)} MPa"
        axes.plot([], [], color=FILM, lw=1.2, label=f"film pressure in the middle{high}")
    figure.legend(
        loc="lower center", bbox_to_anchor=(0.5, 0.22 / total), ncols=5, frameon=False, fontsize=8
    )
    figure.text(0.5, 0.06 / total, caption, ha="center", va="bottom", fontsize=8)


def _newtons(force: float) -> str:
    return f"{force:.0f} N" if force >= 100.0 else f"{force:.3g} N"


def _clock(record: Record, times: np.ndarray) -> list[str]:
    """Time and drive angle of each frame, in print."""
    unit, factor = ("s", 1.0) if times[1] - times[0] >= SLOW else ("ms", 1e3)
    digits = int(np.clip(np.ceil(-np.log10(factor * (times[1] - times[0]))), 0, 9)) + 1
    texts = [f"t = {factor * t:.{digits}f} {unit}" for t in times]
    if record.turn is None:
        return texts
    target, angles = drive_angle(record)[2], np.degrees(angle_at(record, times)) % 360.0
    name = target if isinstance(target, str) else target["name"]
    return [f"{x}   {name} {angle:5.1f}°" for x, angle in zip(texts, angles, strict=True)]
