"""Blocks in guides with clearance: where they are, what they touch with, how they move between."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from clearance.postprocess.figures import finish, save, sheet
from clearance.postprocess.labels import headline

from clearance.metrics.metrics import CORNERS, MODES, modes_of
from clearance.results.record import Record

#: colours of the modes
COLOURS = dict(
    zip(MODES, ("0.6", "tab:blue", "tab:green", "tab:red", "tab:purple", "black"), strict=True)
)
#: clearance over the half height in drawings of the block
MAGNIFIED = 0.45
SHOWN = 4  # moments that a page draws the block at
#: fill and edge of the block
FILL, EDGE = "#a6cee3", "0.25"


def of_slides(record: Record) -> dict[str, dict]:
    """Slides with clearance whose motion was stored: name -> description."""
    joints = {j["name"]: j for j in record.scene["joints"]}
    return {
        n: joints[n]
        for n in record.clearances
        if {"offset", "tilt"} <= set(record.names(f"joints/{n}"))
    }


def guides(record: Record, path: str | Path, *, joints: str | Iterable[str] | None = None) -> Path:
    """A page of slides with clearance, saved under `path`.

    The block in its guide at the strongest contact of each quarter of the run, clearance and tilt
    magnified alike. Below, its offset and tilt along time over a strip of modes; beside, its path
    through these two. joints: default all whose motion was stored. Raises ValueError for others,
    and where there is none.
    """
    slides = of_slides(record)
    names = (
        list(slides) if joints is None else [joints] if isinstance(joints, str) else list(joints)
    )
    if unknown := [n for n in names if n not in slides]:
        raise ValueError(
            f"no slide with clearance {unknown[0]!r}; there are {', '.join(slides) or 'none'}"
        )
    if not names:
        raise ValueError("this run has the motion of no slide with clearance")
    figure = sheet(11.0, 5.6 * len(names) + 0.6)
    parts = figure.subfigures(2 * len(names), 1, height_ratios=[1.0, 2.0] * len(names))
    for name, above, below in zip(names, parts[0::2], parts[1::2], strict=True):
        for k, axes in enumerate(above.subplots(1, SHOWN)):
            _moment(axes, record, slides[name], k)
        grid = below.add_gridspec(1, 12)
        _motion(below.add_subplot(grid[0, :8]), record, slides[name])
        portrait(record, name, below.add_subplot(grid[0, 8:]))
    figure.suptitle(headline([record], [""], width=11.0), fontsize="medium")
    return save(figure, path)


def portrait(record: Record, joint: str, axes) -> None:
    """Offset over tilt in their natural sizes, coloured by mode, in the polygon of first touches.

    Its sides are |e| + a |psi| = c.
    """
    law = of_slides(record)[joint]
    x, y = _natural(record, law)
    axes.fill([1, 0, -1, 0], [0, 1, 0, -1], fc="0.96", ec="black", lw=0.8, zorder=0)
    here = modes_at(record, joint, record.time)
    for i, (name, colour) in enumerate(COLOURS.items()):
        in_mode = here == i
        in_mode[:-1] |= in_mode[1:]  # a mode holds from the sample before on
        if (here == i).any():
            axes.plot(x, np.where(in_mode, y, np.nan), color=colour, lw=1.0, label=name)
    axes.plot(x[-1], y[-1], "o", ms=4, color="black")
    reach = 1.08 * max(1.0, np.abs(x).max(), np.abs(y).max())
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), box_aspect=1.0)
    axes.set_xlabel("tilt ψ a / c [-]")
    axes.set_ylabel("offset e / c [-]")
    handles = axes.get_legend_handles_labels()[0]
    rows = -(-len(handles) // 2)
    axes.set_title(f"joint {joint} (dot: end)", fontsize="small", pad=4.0 + 15.0 * rows)
    position = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderpad": 0.0}
    axes.legend(fontsize="small", ncols=2, frameon=False, **position)


def modes_at(record: Record, joint: str, clock: np.ndarray) -> np.ndarray:
    """The mode with most corners since the time before, for each of ascending times [s]."""
    if len(clock) < 2:
        return np.zeros(len(clock), int)
    edges, modes = modes_of(record, joint, clock[0], clock[-1])
    first = np.clip(np.searchsorted(edges, clock[:-1], side="right") - 1, 0, len(modes) - 1)
    last = np.clip(np.searchsorted(edges, clock[1:]) - 1, 0, len(modes) - 1)
    most = np.array([modes[a : b + 1].max() for a, b in zip(first, last, strict=True)])
    return np.concatenate([most[:1], most])


def _natural(record: Record, law: dict) -> tuple[np.ndarray, np.ndarray]:
    """Tilt over c / a, offset over c."""
    group, c = f"joints/{law['name']}", law["clearance"]
    return record.values(f"{group}/tilt") * 0.5 * law["overlap"] / c, record.values(
        f"{group}/offset"
    ) / c


def _motion(axes, record: Record, law: dict) -> None:
    """Offset and tilt along time, above a strip of modes."""
    x, y = _natural(record, law)
    turn = record.turn
    unit = turn or 1.0
    time = record.time / unit
    axes.axhline(1.0, color="0.7", lw=0.6)
    axes.axhline(-1.0, color="0.7", lw=0.6)
    axes.plot(time, y, color="black", lw=0.9, label="offset e / c")
    axes.plot(time, x, color="tab:orange", lw=0.9, label="tilt ψ a / c")
    reach = 1.1 * max(1.0, np.abs(x).max(), np.abs(y).max())
    edges, modes = modes_of(record, law["name"], record.time[0], record.time[-1])
    for i, colour in enumerate(COLOURS.values()):
        spans = [
            (a / unit, (b - a) / unit)
            for a, b, m in zip(edges, edges[1:], modes, strict=False)
            if m == i
        ]
        axes.broken_barh(spans, (-1.18 * reach, 0.16 * reach), facecolors=colour, lw=0)
        if spans:
            axes.plot([], [], color=colour, lw=5.0, label=MODES[i])
    axes.set_ylim(-1.18 * reach, reach)
    axes.set_xlim(time[0], time[-1])
    finish(axes, "over c and c / a [-]", "drive turns [-]" if turn else "time [s]")


def _moment(axes, record: Record, law: dict, quarter: int) -> None:
    """The block at the strongest contact of a quarter of the run."""
    events, time = record.events, record.time
    ends = time[0] + (time[-1] - time[0]) * (quarter + np.array([0.0, 1.0])) / SHOWN
    here = np.array([spot.partition("/")[0] == law["name"] for spot in events["joint"]], bool)
    here &= (events["time"] >= ends[0]) & (events["time"] < ends[1])
    at, force = ends.mean(), 0.0
    if here.any():
        i = np.flatnonzero(here)[events["peak_force"][here].argmax()]
        at, force = events["time"][i] + 0.5 * events["duration"][i], events["peak_force"][i]
    tilt, offset = (np.interp(at, time, v) for v in _natural(record, law))
    corners, walls = block(law, offset, tilt)
    half = walls[0, :, 0].max()
    for wall, side in zip(walls, (-1.0, 1.0), strict=True):
        axes.plot(*wall.T, color=EDGE, lw=1.0)
        axes.fill_between(
            wall[:, 0], wall[:, 1], wall[:, 1] + side * 0.1 * half, color="0.85", lw=0
        )
    axes.fill(*corners[[0, 1, 3, 2]].T, fc=FILL, ec=EDGE, lw=1.0)
    arrow = {"arrowstyle": "-|>", "color": "tab:red", "lw": 1.4}
    for x, y, side in _touching(law, at, corners, events):
        axes.annotate(
            "", (x, y), (x, y + side * 0.22 * half), arrowprops=arrow, annotation_clip=False
        )
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_ylim(*1.35 * walls[:, 0, 1])
    label = f"contact of {force:.3g} N" if force < 1e3 else f"contact of {1e-3 * force:.3g} kN"
    label = label if force else "no contact"
    zoom = MAGNIFIED * 0.5 * law["height"] / law["clearance"]
    axes.set_title(f"{1e3 * at:.4g} ms, {label}\nclearance × {zoom:.3g}", fontsize="small")


def _touching(law: dict, at: float, corners: np.ndarray, events: dict) -> Iterator[tuple]:
    """Place and side of corners in contact at a time."""
    for (name, _, side), (x, y) in zip(CORNERS, corners, strict=True):
        mine = events["joint"] == f"{law['name']}/{name}"
        begin = events["time"][mine]
        if ((begin <= at) & (at <= begin + events["duration"][mine])).any():
            yield x, y, side


def block(law: dict, offset, tilt) -> tuple[np.ndarray, np.ndarray]:
    """Corners (..., 4, 2) in the order of CORNERS, both walls (2, 2, 2), along and across [m].

    offset over c, tilt over c / a. Across the guide the clearance is magnified, and offset and tilt
    with it: the block is sheared, which keeps its gaps in proportion.
    """
    a, b = 0.5 * law["overlap"], 0.5 * law["height"]
    room = MAGNIFIED * b
    offset, tilt = np.asarray(offset)[..., None], np.asarray(tilt)[..., None]
    sx, sy = np.array([(x, y) for _, x, y in CORNERS]).T
    across = room * (offset + sx * tilt) + sy * b
    corners = np.stack([np.broadcast_to(sx * a, across.shape), across], axis=-1)
    reach = 1.25 * a
    walls = np.array([[(-reach, s * (b + room)), (reach, s * (b + room))] for s in (-1.0, 1.0)])
    return corners, walls
