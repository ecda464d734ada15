"""Pictures of a life: worn outlines by stage, depth over turns, the journal's path in its bearing,
films and motion, and wear over the drive's angle. Also an animation.
"""

from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import angle_at
from clearance.postprocess.drawing import period
from clearance.postprocess.labels import shown_in

from clearance.results.result import open_result
from clearance.wearing.life_record import Life

ANGLE = np.deg2rad(np.arange(361))
#: units of the wear of a turn, by its size [m]
WEAR = {"m": ((1e-6, "µm", 1e6), (1e-9, "nm", 1e9), (0.0, "pm", 1e12))}
#: metrics that are drawn over the turns, where runs have them: end of the name, words, unit
OVER_LIFE = (
    ("position_deviation_max", "distance from the ideal motion", "m"),
    ("force_max", "largest joint force", "N"),
    ("gap_min", "smallest gap", "m"),
)


def life(
    source: Life | str | Path,
    path: str | Path,
    joint: str | None = None,
    surface: str | None = None,
) -> Path:
    """A life in six panels, of one joint (default the first) and surface (default the first that
    wears).

    Raises ValueError for a joint that does not wear, and for a life without a stage.
    """
    one, joint, surface = _shown(source, joint, surface)
    wears = one.asked["joints"][joint]["wears"]
    figure = figures.sheet(13.0, 8.6)
    grid = figure.add_gridspec(2, 3)
    round_one = figure.add_subplot(grid[0, 0], projection="polar")
    panels = [round_one, *(figure.add_subplot(grid[k // 3, k % 3]) for k in range(1, 6))]
    below = {"location": "bottom", "shrink": 0.5, "aspect": 50}
    colours = figures.bar_of_values(figure, panels, one.turns, False, "turns done", **below)
    _outlines(panels[0], one, joint, surface, colours)
    _depth(panels[1], one, joint, wears)
    _path(panels[2], one, joint, colours)
    _rates(panels[3], one, joint, surface, colours)
    _over_life(panels[4], one, joint)
    _around_the_drive(panels[5], one, joint, surface, colours)
    name = one.asked["scene"]["name"]
    figure.suptitle(f"{name}, joint {joint}: {one.turns[-1]:g} turns in {len(one.stages)} stages")
    return figures.save(figure, path)


def _shown(
    source: Life | str | Path, joint: str | None, surface: str | None
) -> tuple[Life, str, str]:
    """The life, joint and surface that are drawn; ValueError for what is not there."""
    one = source if isinstance(source, Life) else Life(source)
    if not one.stages:
        raise ValueError(f"{one.path} has no stage yet: there is nothing to draw")
    joint = joint or one.joints[0]
    if joint not in one.joints:
        raise ValueError(f"joint {joint} does not wear; {', '.join(one.joints)} do")
    wears = one.asked["joints"][joint]["wears"]
    if surface is not None and surface not in wears:
        raise ValueError(f"the {surface} of joint {joint} does not wear; {', '.join(wears)} does")
    return one, joint, surface or wears[0]


def _some(one: Life, most: int = 12) -> list[int]:
    """Stages that are drawn, evenly over the life."""
    count = len(one.stages)
    return sorted({round(i) for i in np.linspace(0, count - 1, min(count, most))})


def _closed(values: np.ndarray) -> np.ndarray:
    return np.append(values, values[0])


def _outlines(axes, one: Life, joint: str, surface: str, colours: list) -> None:
    """The outline over its angle, magnified: the clearance circle, depth outwards."""
    depth = one.depth(joint, surface)
    clearance = one.asked["joints"][joint]["clearance"]
    largest = max(float(depth.max()), 1e-3 * clearance)
    for i in _some(one):
        axes.plot(ANGLE, _closed(1.0 + 0.5 * depth[i] / largest), color=colours[i], lw=1.0)
    axes.set_ylim(0.0, 1.55)
    axes.set_yticks([1.0, 1.5], ["", ""])
    title = (
        f"worn depth of the {surface}, over its angle\ngrey circles: 0 and {1e6 * largest:.3g} µm"
    )
    axes.set_title(title, fontsize="medium")


def _depth(axes, one: Life, joint: str, wears: list[str]) -> None:
    """Largest depth over turns, what the jumps may have missed, and under a load that stands still
    the closed form.
    """
    scale = 1e6
    for k, surface in enumerate(wears):
        deep = scale * one.depth(joint, surface).max(axis=1)
        axes.plot(
            one.turns, deep, "o-", ms=3, color=f"C{k}", label=f"{surface}: dynamics and jumps"
        )
        error = scale * one.error
        axes.fill_between(one.turns, deep - error, deep + error, color=f"C{k}", alpha=0.3, lw=0.0)
    if one.stands_still(joint):
        form = scale * one.closed_form(joint)
        axes.plot(one.turns, form, "k--", lw=1.0, label="bearing: rigid, first load path alone")
    figures.finish(axes, "largest depth [µm]", "turns")


def _path(axes, one: Life, joint: str, colours: list) -> None:
    """Path of the journal's centre in the bearing's frame, first and last stage, inside what the
    outline leaves.
    """
    for i in dict.fromkeys((0, len(one.stages) - 1)):
        colour = colours[i]
        with open_result(one.file(i)) as record:
            x, y = _in_bearing(record, joint)
        late = len(x) // 2
        axes.plot(1e6 * x[late:], 1e6 * y[late:], lw=0.9, color=colour)
        room = _room(one, joint, i)
        axes.plot(*(1e6 * room), color=colour, lw=0.9, ls=":")
    axes.set_aspect("equal", adjustable="datalim")
    figures.finish(axes, "y in the bearing [µm]", "x in the bearing [µm]")
    axes.set_title("path (line) and room (dots) of the journal", fontsize="medium")


def _in_bearing(record, joint: str) -> tuple[np.ndarray, np.ndarray]:
    described = record.described(joint)
    x, y = record.joint(joint).eccentricity.T
    body = described["a"]["body"]
    angle = record[body].theta if body != "ground" else np.zeros_like(x)
    return np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x


def _room(one: Life, joint: str, stage: int) -> np.ndarray:
    """Places where a round journal's centre would touch the worn bearing, direction by
    direction.
    """
    free = one.asked["joints"][joint]["clearance"] + one.depth(joint, "bearing")[stage]
    angle = ANGLE[:-1]
    with np.errstate(divide="ignore"):
        facing = np.cos(angle[:, None] - angle)
        reach = np.where(facing > 1e-6, free[:, None] / np.maximum(facing, 1e-6), np.inf).min(
            axis=0
        )
    return np.array([_closed(reach * np.cos(angle)), _closed(reach * np.sin(angle))])


def _rates(axes, one: Life, joint: str, surface: str, colours: list) -> None:
    """Wear of a turn over the angle, by stage."""
    rate = one.rate(joint, surface)
    middle = int(rate[-1].argmax())
    half = min(180, int(np.abs(_beside(rate.max(axis=0), middle)).max()) + 15)
    shown = np.arange(-half, half) + middle
    unit, factor = shown_in("m", [float(rate.max())], WEAR)
    for i in _some(one):
        axes.plot(shown, factor * rate[i][shown % 360], color=colours[i], lw=1.0)
    figures.finish(axes, f"wear of a turn [{unit}]", f"angle of the {surface} [deg]")


def _beside(values: np.ndarray, middle: int) -> np.ndarray:
    """Angles [deg] from the middle at which values are more than a thousandth of their largest."""
    places = np.flatnonzero(values > 1e-3 * max(float(values.max()), 1e-300))
    return (places - middle + 180) % 360 - 180 if len(places) else np.array([90])


def _over_life(axes, one: Life, joint: str) -> None:
    """Metrics over turns, each over its value at the start."""
    drawn = False
    for end, words, unit in OVER_LIFE:
        names = [n for n in one.stages[0]["metrics"] if n.endswith(end) and _of(n, joint)]
        for name in names[:1]:
            values = one.metric(name)
            if not np.isfinite(values).all() or not values.any():
                continue
            label, size = _sized(values, words, unit)
            axes.plot(one.turns, values / size, "o-", ms=3, label=label)
            drawn = True
    if not drawn:
        axes.set_visible(False)
        return
    figures.finish(axes, "over the value in the legend [-]", "turns")


def _sized(values: np.ndarray, words: str, unit: str) -> tuple[str, float]:
    """Words of a curve and what it is drawn over: its first value; where its sign changes, the
    largest magnitude.
    """
    size, which = float(values[0]), "first"
    if (values < 0.0).any() and (values > 0.0).any():
        size, which = float(np.abs(values).max()), "largest"
        words = f"{words} (below 0: solids)" if words == OVER_LIFE[-1][1] else words
    elif size < 0.0 and words == OVER_LIFE[-1][1]:
        words = "deepest penetration"
    shown = f"{1e6 * abs(size):.3g} µm" if unit == "m" else f"{size:.3g} {unit}"
    return f"{words}, {which} {shown}", size


def _of(name: str, joint: str) -> bool:
    """A metric of this joint, or of no joint."""
    return not name.startswith("joint_") or name.startswith(f"joint_{joint}_")


def _around_the_drive(axes, one: Life, joint: str, surface: str, colours: list) -> None:
    """Volume worn off over the angle of the drive, in the last turn of each stage."""
    drawn = False
    for i in _some(one):
        with open_result(one.file(i)) as record:
            volumes = _over_angle(record, joint, surface)
        if volumes is not None:
            axes.plot(*volumes, color=colours[i], lw=1.0)
            drawn = True
    if not drawn:
        axes.set_visible(False)
        return
    axes.set_xticks(np.arange(0, 361, 90))
    figures.finish(axes, "wear [µm³/deg]", "angle of the drive [deg]")


def _over_angle(record, joint: str, surface: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Angle of the drive [deg] and volume worn off [um3 a degree] of the last turn; None where the
    volume was not integrated.
    """
    path = f"joints/{joint}/wear_volume_{surface}"
    if path not in record:
        return None
    time, volume = record.time, record.values(path)
    last = time > time[-1] - period(record) * (1.0 + 1e-9)
    angle = np.degrees(angle_at(record, time[last]))
    middle, steps = 0.5 * (angle[1:] + angle[:-1]), np.abs(np.diff(angle))
    order = np.argsort(middle % 360.0)
    return (middle % 360.0)[order], (1e18 * np.diff(volume[last]) / steps)[order]


FRAMES = 60


def animation(
    source: Life | str | Path,
    path: str | Path,
    joint: str | None = None,
    surface: str | None = None,
    frames: int = FRAMES,
    fps: float = 15.0,
) -> Path:
    """A life as a .gif or .mp4: the outline as it wears, magnified, and the depth over the turns.

    Frames stand at equal numbers of turns; between stages depths are straight lines. Raises
    ValueError for what is not there, and for fewer than two frames or stages.
    """
    one, joint, surface = _shown(source, joint, surface)
    if not isinstance(frames, int) or frames < 2 or len(one.stages) < 2:
        raise ValueError(
            f"an animation needs two frames and two stages at least, got {frames!r} and "
            f"{len(one.stages)}"
        )
    figures.check_film(path, fps)
    depth, at = one.depth(joint, surface), np.linspace(0.0, one.turns[-1], frames)
    between = np.array([np.interp(at, one.turns, column) for column in depth.T]).T
    figure = figures.sheet(9.0, 4.6)
    grid = figure.add_gridspec(1, 2)
    ring, curve = figure.add_subplot(grid[0], projection="polar"), figure.add_subplot(grid[1])
    largest = float(depth.max())
    (outline,) = ring.plot(ANGLE, np.ones(ANGLE.size), color="C3", lw=1.6)
    ring.plot(ANGLE, np.ones(ANGLE.size), color="k", lw=0.6)
    ring.set_ylim(0.0, 1.55)
    ring.set_yticks([1.0, 1.5], ["", ""])
    title = ring.set_title("")
    _depth(curve, one, joint, one.asked["joints"][joint]["wears"])
    (dot,) = curve.plot([], [], "o", color="C3", ms=8)

    def show(k: int) -> None:
        outline.set_ydata(_closed(1.0 + 0.5 * between[k] / largest))
        dot.set_data([at[k]], [1e6 * between[k].max()])
        title.set_text(
            f"joint {joint}, {surface}: {at[k]:.0f} turns, outer circle {1e6 * largest:.3g} µm"
        )

    show(frames - 1)
    return figures.save_film(figure, path, fps, frames, show, (outline, dot, title))
