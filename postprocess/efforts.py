"""Driving efforts and friction of a mechanism: driving efforts, and friction of hinges and slides
without clearance.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import name_of
from clearance.postprocess.labels import headline, rubbing_joints

from clearance.results.record import Record

#: curves that a panel has room for; of more, those that reach furthest are drawn
MOST = 8
COLOURS = [f"C{i}" for i in range(10)]
#: what efforts of these units are called, and the units of the rate that they work on
EFFORTS = {"N m": ("torque", "rad/s"), "N": ("force", "m/s")}
IDEAL = {"ls": "--", "lw": 1.0}
UNLIKE = "-."  # slides beside hinges
BESIDE = {"fontsize": "small", "loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "frameon": False}


@dataclass(frozen=True)
class Group:
    """Drives or joints whose efforts have the same units: paths of those shown, by name, and how
    each of all is drawn.

    remark: that some are left out, where they are.
    """

    units: str
    paths: dict[str, str]
    styles: dict[str, dict]
    remark: str

    @property
    def effort(self) -> str:
        return EFFORTS[self.units][0]

    def beside(self, channel: str) -> dict[str, str]:
        """Paths of another channel of the same drives or joints."""
        return {name: f"{path.rpartition('/')[0]}/{channel}" for name, path in self.paths.items()}


def drive_efforts(record: Record) -> dict[str, str]:
    """Paths of the driving torques and forces that were stored, by drive, in the scene's order."""
    names = [d["name"] for d in record.scene["loads"] if d["type"] == "Drive"]
    return {n: p for n in names for p in (f"drives/{n}/torque", f"drives/{n}/force") if p in record}


def joint_friction(record: Record) -> dict[str, str]:
    """Paths of the friction of hinges and slides without clearance that was stored, by joint, in
    the scene's order.
    """
    names = [j["name"] for j in rubbing_joints(record.scene)]
    return {n: p for n in names if (p := f"joints/{n}/friction") in record}


def groups(
    record: Record, paths: dict[str, str], *, afresh: bool = False, dashes: str = "-"
) -> list[Group]:
    """Efforts by their units, torques first; `dashes`: of the forces, whose colours may begin
    `afresh`.
    """
    panels, first = [], 0
    for units in EFFORTS:
        alike = {n: p for n, p in paths.items() if record.units(p) == units}
        if not alike:
            continue
        curves, remark = largest({n: record.values(p) for n, p in alike.items()})
        styles = {
            n: _style(first + i, dashes if units == "N" else "-") for i, n in enumerate(alike)
        }
        panels.append(Group(units, {n: alike[n] for n in curves}, styles, remark))
        first += 0 if afresh else len(alike)
    return panels


def _style(i: int, dashes: str) -> dict:
    """Stroke of drive or joint i; after ten the colours come again, dotted."""
    again = i >= len(COLOURS) and dashes == "-"
    return {"color": COLOURS[i % len(COLOURS)], "ls": ":" if again else dashes}


def largest(values: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], str]:
    """The curves (samples,) that reach furthest from zero, at most 8, in their order, and a remark
    on the others.
    """
    if len(values) <= MOST:
        return values, ""
    reach = {n: np.abs(v).max() for n, v in values.items()}
    names = sorted(reach, key=lambda n: -reach[n])[:MOST]
    return {n: v for n, v in values.items() if n in names}, f"the {MOST} largest of {len(values)}"


def rate(record: Record, joint: str) -> np.ndarray:
    """Rate of body b of a hinge [rad/s] or slide [m/s] against body a, (samples,), from angular
    velocities or the loss.

    The power loss of a slide means nothing where there is no friction: NaN. Raises ValueError for a
    channel not stored.
    """
    entry = record.described(joint)
    if entry["type"] == "Prismatic":
        power, friction = (_kept(record, f"joints/{joint}/{c}") for c in ("power_loss", "friction"))
        return np.divide(-power, friction, out=np.full(power.shape, np.nan), where=friction != 0.0)
    bodies = (entry[end]["body"] for end in "ab")
    a, b = (0.0 if n == "ground" else _kept(record, f"bodies/{n}/omega") for n in bodies)
    return b - a


def _kept(record: Record, path: str) -> np.ndarray:
    if path not in record:
        raise ValueError(f"channel {path} of {name_of(record)} was not stored")
    return record.values(path)


# --- panels
def draw(
    record: Record,
    axes,
    paths: dict[str, str],
    styles: dict[str, dict],
    label: str,
    remark: str = "",
) -> None:
    """Channels along time, those of them that were stored."""
    for name, path in paths.items():
        if path in record:
            figures.line(axes, record.time, record.values(path), label=name, **styles[name])
    _finish(axes, label, remark)


def _finish(axes, label: str, remark: str, xlabel: str = "time [s]", margin: float = 0.01) -> None:
    figures.finish(axes, label, xlabel, legend=False)
    axes.margins(x=margin)
    if remark:
        axes.set_title(remark, fontsize="small", loc="right", color="0.3", pad=3.0)


def draw_efforts(record: Record, axes, group: Group, key: bool) -> None:
    """Driving efforts of a group, dashed what they would be without joint friction; `key`: the
    legend states so.
    """
    draw(
        record,
        axes,
        group.paths,
        group.styles,
        f"driving {group.effort} [{group.units}]",
        group.remark,
    )
    for name, path in _without_friction(record, group).items():
        figures.line(axes, record.time, record.values(path), **(group.styles[name] | IDEAL))
    if key:
        axes.plot([], [], color="black", label="without friction", **IDEAL)


def draw_added(record: Record, axes, group: Group) -> None:
    """Addition of joint friction to the driving efforts of a group."""
    for name, path in _without_friction(record, group).items():
        added = record.values(group.paths[name]) - record.values(path)
        figures.line(axes, record.time, added, **group.styles[name])
    _finish(axes, f"{group.effort} for friction [{group.units}]", "")


def _without_friction(record: Record, group: Group) -> dict[str, str]:
    """Paths of what the drives of a group would need without joint friction, where they prescribe a
    motion.
    """
    return {n: p for n, p in group.beside(f"{group.effort}_ideal").items() if p in record}


def draw_friction(record: Record, axes, group: Group) -> None:
    """Friction torques or forces of a group."""
    draw(
        record,
        axes,
        group.paths,
        group.styles,
        f"friction {group.effort} [{group.units}]",
        group.remark,
    )


def draw_reactions(record: Record, axes, styles: dict[str, dict]) -> None:
    """Magnitudes of the reactions of joints, with their axial parts out of the plane."""
    forces, across = {}, False
    for name in styles:
        parts = [record.values(f"joints/{name}/{c}") for c in ("force_x", "force_y")]
        if f"joints/{name}/axial_force" in record:
            parts.append(record.values(f"joints/{name}/axial_force"))
            across = across or bool(parts[-1].any())
        forces[name] = np.linalg.norm(parts, axis=0)
    label = "joint force\nwith axial part" if across else "joint force"
    _draw_largest(axes, record.time, forces, styles, f"{label} [N]")


def bending(record: Record, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Magnitudes (samples,) [N m] of the bending moments of joints that carry some."""
    moments = {}
    for name in names:
        paths = [f"joints/{name}/bending_{axis}" for axis in "xy"]
        if all(p in record for p in paths):
            moments[name] = np.hypot(*(record.values(p) for p in paths))
    return {n: v for n, v in moments.items() if v.any()}


def draw_bending(record: Record, axes, styles: dict[str, dict]) -> None:
    """Bending moments of joints."""
    _draw_largest(axes, record.time, bending(record, styles), styles, "bending moment [N m]")


def draw_losses(record: Record, axes, styles: dict[str, dict]) -> None:
    """Power lost in joints, and in all of them together."""
    lost = {n: record.values(f"joints/{n}/power_loss") for n in styles}
    _draw_largest(axes, record.time, lost, styles, "power lost [W]")
    if len(lost) > 1:
        style = {"color": "black", "lw": 1.2, "label": "all joints"}
        figures.line(axes, record.time, np.sum(list(lost.values()), axis=0), **style)


def _draw_largest(
    axes, time: np.ndarray, values: dict[str, np.ndarray], styles: dict, label: str
) -> None:
    curves, remark = largest(values)
    for name, curve in curves.items():
        figures.line(axes, time, curve, label=name, **styles[name])
    _finish(axes, label, remark)


def draw_curve(record: Record, axes, group: Group) -> None:
    """Friction of a group over the rates of its joints: the friction curves that were traversed."""
    for name, path in group.paths.items():
        # friction jumps from sample to sample
        style = group.styles[name] | {"ls": "none", "marker": ".", "ms": 2.5}
        figures.trajectory(axes, rate(record, name), record.values(path), **style)
    units = EFFORTS[group.units][1]
    axes.locator_params(axis="x", nbins=5)
    _finish(
        axes, f"friction {group.effort} [{group.units}]", "", f"rate of b against a [{units}]", 0.04
    )


def driving_panels(record: Record, added: bool = False) -> list[Callable]:
    """Functions that draw the driving efforts on axes: torques and forces apart, and the part that
    friction `added`.
    """
    rows, panels = groups(record, drive_efforts(record)), []
    ideal = any(_without_friction(record, g) for g in rows)
    for group in rows:
        panels.append(partial(draw_efforts, group=group, key=ideal and group is rows[-1]))
        if added and _without_friction(record, group):
            panels.append(partial(draw_added, group=group))
    return panels


def friction_panels(record: Record, reactions: bool = True) -> list[Callable]:
    """Functions that draw joint friction, reactions of the joints with friction, and losses on
    axes.
    """
    rows = groups(record, joint_friction(record), afresh=True, dashes=UNLIKE)
    styles = {n: style for g in rows for n, style in g.styles.items()}
    panels = [partial(draw_friction, group=g) for g in rows]
    if rows and reactions:
        panels += [partial(draw_reactions, styles=styles)]
        panels += [partial(draw_bending, styles=styles)] if bending(record, styles) else []
    return [*panels, partial(draw_losses, styles=styles)] if rows else []


# --- pages
def efforts(record: Record, path: str | Path) -> Path:
    """Driving torques and forces, what they would be without joint friction, and the difference,
    saved under `path`.

    Raises ValueError for a run that has no drive, or has stored no driving effort.
    """
    panels = driving_panels(record, added=True)
    if not panels:
        driven = any(load["type"] == "Drive" for load in record.scene["loads"])
        lacks = "stored no driving effort" if driven else "no drive"
        raise ValueError(f"{name_of(record)}: this run has {lacks}")
    figure = figures.sheet(7.5, 1.3 + 2.1 * len(panels))
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, draw_panel in zip(grid, panels, strict=True):
        draw_panel(record, axes)
    for axes in grid[:-1]:
        axes.set_xlabel("")
    figure.suptitle(headline([record], [""], width=7.5), fontsize="medium")
    figure.align_ylabels()
    figures.legend_below(figure, *grid)
    return figures.save(figure, path)


def friction(
    record: Record, path: str | Path, *, joints: str | Iterable[str] | None = None
) -> Path:
    """Friction of hinges and slides and its load over time, and over the rate of the joint, saved
    under `path`.

    joints: default all that rub. Raises ValueError for others, and for a run without joint
        friction.
    """
    channels = joint_friction(record)
    if not channels:
        had = "stored no" if rubbing_joints(record.scene) else "no"
        raise ValueError(f"{name_of(record)}: this run has {had} joint friction")
    names = [joints] if isinstance(joints, str) else list(joints or channels)
    if unknown := [j for j in names if j not in channels]:
        raise ValueError(
            f"no friction of joint {unknown[0]!r} in {name_of(record)}; of {', '.join(channels)}"
        )
    rows = groups(record, {n: channels[n] for n in channels if n in names}, afresh=True)
    loaded = [any(p in record for p in g.beside("friction_load").values()) for g in rows]
    heights = [1.6 if two else 2.6 for two in loaded for _ in range(1 + two)]
    figure = figures.sheet(10.5, 1.0 + 1.25 * sum(heights))
    grid = figure.add_gridspec(len(heights), 2, width_ratios=(3, 2), height_ratios=heights)
    row, above = 0, None
    for group, two in zip(rows, loaded, strict=True):
        above = figure.add_subplot(grid[row, 0], sharex=above)
        draw_friction(record, above, group)
        if two:
            above.set_xlabel("")
            below = figure.add_subplot(grid[row + 1, 0], sharex=above)
            draw(
                record,
                below,
                group.beside("friction_load"),
                group.styles,
                f"friction load [{group.units}]",
            )
        axes = figure.add_subplot(grid[row : row + 1 + two, 1])
        draw_curve(record, axes, group)
        axes.legend(*above.get_legend_handles_labels(), **BESIDE)
        row += 1 + two
    figure.suptitle(headline([record], [""], *_solved(record), width=10.5), fontsize="medium")
    return figures.save(figure, path)


def _solved(record: Record) -> list[str]:
    """Solution for friction that changes the reactions that make it, in words."""
    if not {"iterations", "contraction"} <= set(record.names("friction")):
        return []
    most, change = (record.range(f"friction/{c}")[1] for c in ("iterations", "contraction"))
    return [f"coupled friction: at most {most:.0f} iterations, contraction up to {change:.2g}"]
