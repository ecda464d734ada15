"""First pictures of a run."""

import textwrap
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from clearance.postprocess import efforts
from clearance.postprocess.figures import (
    FAR_APART,
    finish,
    legend_above,
    line,
    plain_decades,
    save,
    sheet,
    trajectory,
)
from clearance.postprocess.guides import of_slides, portrait
from clearance.postprocess.labels import title

from clearance.metrics.metrics import Window
from clearance.results.extremes import SLIDES, guides
from clearance.results.record import Record
from clearance.results.result import Result
from clearance.values.spots import THRESHOLDS

TIME = "time [s]"
LEDGER = "kinetic energy [J]", "energy residual [J]"
#: share of the samples, at either end of their range, that may be lone peaks
LONE = 0.01
#: turns that curves are drawn over, of a run that has more than twice as many
LAST = 2
#: states of a mixed joint and their colours
STATES = {"full film": "tab:blue", "mixed": "tab:orange", "dry": "tab:red"}
ARC = np.radians(3.0)  # largest step of a drawn path along the wall [rad]
#: states of a dry joint and their colours
FLIGHT = {"free flight": "0.55", "contact": STATES["dry"]}
MEMBERSHIPS = [f"membership_{state.replace(' ', '_')}" for state in STATES]
#: channels of a mixed joint that its states are drawn from
OF_STATES = {"film_thickness_ratio", "asperity_share", *MEMBERSHIPS}


def overview(result: Record, path: str | Path, *, settle: float | None = None) -> Path:
    """One page: motion, drive, joint forces, journal orbits and the energy balance.

    Saved under `path`.

    Of a mechanism whose joints rub and have no clearance: efforts, joint friction, reactions and
    losses instead.
    settle: turns of the start-up (seconds, where nothing turns; default one of two or more). It is
        shaded, and axes are those of the motion after it; peaks that lie far beyond all other
        samples are marked at the edge. Dots: located extremes. Of more than four turns the curves
        of motion, drive and forces have the last two.
    Raises ValueError for a settle that is negative or not finite.
    """
    clearance_joints = _with_paths(result)
    rubbing = efforts.joint_friction(result)
    figure = (
        _friction_page(result)
        if rubbing and not clearance_joints
        else _page(result, clearance_joints[:3])
    )
    _settled_axes(figure, Window.of(result, settle))
    _last_turns(figure, result)
    figure.suptitle(
        textwrap.fill(": ".join(filter(None, (result.attributes["case"], title(result)))), 110)
    )
    return save(figure, path, dpi=130)


def _settled_axes(figure, window: Window | None) -> None:
    """Axes along time have the range of their curves after the start-up, which is shaded, without
    lone peaks.
    """
    begin = window.begin if window else 0.0
    for axes in figure.axes:
        if axes.get_xlabel() != TIME or axes.get_yscale() != "linear" or not axes.lines:
            continue
        late = [
            np.asarray(y)[np.asarray(x) >= begin]
            for x, y in (curve.get_data() for curve in axes.lines)
        ]
        late = np.concatenate([v[np.isfinite(v)] for v in late])
        low, high = _without_peaks(late) if late.size else (0.0, 0.0)
        peaks = late.size and (late.min() < low or late.max() > high)
        if high > low and (begin or peaks):
            axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
        if peaks:
            _mark_peaks(axes, begin)
        if begin:
            axes.axvspan(0.0, begin, color="0.9", lw=0, zorder=0)


def _last_turns(figure, result: Record) -> None:
    """Curves of many turns in their last ones; the energy ledger has all."""
    end, turn = float(result.time[-1]), result.turn
    turns = (end - float(result.time[0])) / turn if turn else 0.0
    if turns <= 2 * LAST + 1e-9:
        return
    for axes in figure.axes:
        if axes.get_xlabel() == TIME and axes.get_ylabel() not in LEDGER:
            axes.set_xlim(end - LAST * turn, end)
            axes.set_xlabel(f"{TIME}, the last {LAST} of {turns:.4g} turns")


def _without_peaks(values: np.ndarray) -> tuple[float, float]:
    """Range of values (n,); where lone ones lie far out, that of the others with as much room again
    on both sides.
    """
    low, high = float(values.min()), float(values.max())
    first, last = np.quantile(values, (LONE, 1.0 - LONE))
    room = float(last - first)
    if not 0.0 < FAR_APART * room < high - low:
        return low, high
    return max(low, first - room), min(high, last + room)


def _mark_peaks(axes, begin: float) -> None:
    """Triangles at the edge where curves go beyond their axis, and how far."""
    (low, high), largest = axes.get_ylim(), 0.0
    for curve in list(axes.lines):
        x, y = (np.asarray(v) for v in curve.get_data())
        late = x >= begin
        for beyond, height, mark in ((y > high, 0.985, "^"), (y < low, 0.015, "v")):
            here = x[beyond & late]
            style = {"ms": 3, "color": curve.get_color(), "transform": axes.get_xaxis_transform()}
            axes.plot(here, np.full(len(here), height), mark, **style)
            largest = max(largest, float(np.abs(y[beyond & late]).max(initial=0.0)))
    text = f"triangles: beyond the axis, up to {largest:.2g}"
    box = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.0}
    axes.text(
        0.99, 0.93, text, transform=axes.transAxes, ha="right", va="top", fontsize="small", bbox=box
    )


def _page(result: Record, shown: list[str]):
    """Motion, drive, forces and energy, then `shown` joints with clearance, and the friction of
    those without.
    """
    mixed = [n for n in shown if set(result.names(f"joints/{n}")) >= OF_STATES]
    rubbing = efforts.friction_panels(result, reactions=False)
    rows = 2 + (len(mixed) if mixed else bool(shown))
    figure = sheet(11.0, 3.4 * (rows + bool(rubbing)))
    grid = figure.add_gridspec(rows + bool(rubbing), 6)
    panels = [
        (grid[0, :3], motion),
        (grid[0, 3:], drive),
        (grid[1, :3], joint_forces),
        (grid[1, 3:], energy),
    ]
    for cell, draw in panels:
        draw(result, figure.add_subplot(cell))
    width = 6 // max(len(shown), 1)
    for i, name in enumerate(mixed):
        orbit(result, name, figure.add_subplot(grid[2 + i, :2]))
        regimes(result, name, figure.add_subplot(grid[2 + i, 2:]))
    for i, name in enumerate(shown if not mixed else ()):
        orbit(result, name, figure.add_subplot(grid[2, i * width : (i + 1) * width]))
    width = 6 // max(len(rubbing), 1)
    for i, draw in enumerate(rubbing):
        axes = figure.add_subplot(grid[rows, i * width : (i + 1) * width])
        draw(result, axes)
        legend_above(axes)
    return figure


def _friction_page(result: Record):
    """Efforts, motion and energy on the left; friction, reactions and losses on the right."""
    columns = [
        [*(efforts.driving_panels(result) or [drive]), motion, energy],
        efforts.friction_panels(result),
    ]
    figure = sheet(13.0, 2.3 * max(map(len, columns)) + 0.8)
    parts = figure.add_gridspec(1, 2)
    for part, panels in zip(parts, columns, strict=True):
        grid = part.subgridspec(len(panels), 1)
        axes = grid.subplots(sharex=True)
        for panel, draw in zip(axes, panels, strict=True):
            draw(result, panel)
        for panel in axes[:-1]:
            panel.set_xlabel("")
        axes[-1].margins(x=0.01)
        legend_above(
            *[
                panel
                for panel, draw in zip(axes, panels, strict=True)
                if draw not in (motion, energy)
            ]
        )
    return figure


def orbits(result: Result, path: str | Path, *, joints: str | Iterable[str] | None = None) -> Path:
    """Journal paths of clearance joints, and the states of mixed ones over the last turns, saved
    under `path`.

    joints: default all whose eccentricity was stored. Raises ValueError for others, and where there
        is none.
    """
    with_paths = _with_paths(result)
    names = with_paths if joints is None else [joints] if isinstance(joints, str) else list(joints)
    if unknown := [j for j in names if j not in with_paths]:
        raise ValueError(
            f"no journal path of joint {unknown[0]!r} in {result.path.name}; of "
            f"{', '.join(with_paths) or 'none'}"
        )
    if not names:
        raise ValueError(f"{result.path.name} has the eccentricity of no clearance joint")
    mixed = [j for j in names if set(result.names(f"joints/{j}")) >= OF_STATES]
    plain = [j for j in names if j not in mixed]
    columns = 3 if mixed else min(len(plain), 3)
    rows = len(mixed) + -(-len(plain) // columns)
    figure = sheet(3.7 * columns, 3.4 * rows + 0.6)
    grid = figure.add_gridspec(rows, columns)
    for i, name in enumerate(mixed):
        orbit(result, name, figure.add_subplot(grid[i, 0]))
        regimes(result, name, figure.add_subplot(grid[i, 1:]))
    for i, name in enumerate(plain):
        orbit(result, name, figure.add_subplot(grid[len(mixed) + i // columns, i % columns]))
    figure.suptitle(
        ": ".join(filter(None, (result.attributes["case"], title(result)))),
        fontsize="medium",
        wrap=True,
    )
    return save(figure, path, dpi=130)


def _with_paths(result: Result) -> list[str]:
    """Joints with clearance whose eccentricity, or offset and tilt, were stored."""
    slides = of_slides(result)
    journals = {"eccentricity_x", "eccentricity_y"}
    return [
        j for j in result.clearances if j in slides or journals <= set(result.names(f"joints/{j}"))
    ]


def motion(result: Result, axes) -> None:
    """Acceleration of the output body along its larger component."""
    name = output_body(result.scene)
    channels = result[name]
    component = max(("ax", "ay"), key=lambda c: np.ptp(getattr(channels, c)))
    label = f"acceleration {component[1]} [m/s²]"
    if np.ptp(getattr(channels, component)) == 0.0:  # it turns about its centre of mass
        component, label = "alpha", "angular acceleration [rad/s²]"
    line(axes, result.time, getattr(channels, component), label=name)
    _mark(result, axes, {name: f"bodies/{name}/{component}"})
    finish(axes, label)


def output_body(scene: dict) -> str:
    """Name of the body whose motion a mechanism is for.

    The one that slides on the ground; else the last one hinged to the ground that no drive turns;
    else the last.
    """
    if slides := list(guides(scene)):
        return slides[-1]
    driven = {name for d in scene["loads"] if d["type"] == "Drive" for name in _turned(d["target"])}
    hinged = [
        j["b" if j["a"]["body"] == "ground" else "a"]["body"]
        for j in scene["joints"]
        if _on_ground(j)
    ]
    links = [b["name"] for b in scene["bodies"] if b["name"] in hinged and b["name"] not in driven]
    return links[-1] if links else scene["bodies"][-1]["name"]


def _turned(target: str | dict) -> list[str]:
    """Bodies that a drive acts on, by the body or the joint that is its target."""
    return [target] if isinstance(target, str) else [target[end]["body"] for end in "ab"]


def _on_ground(joint: dict) -> bool:
    return joint["type"] not in SLIDES and "ground" in (joint["a"]["body"], joint["b"]["body"])


def _mark(result: Record, axes, paths: dict[str, str]) -> None:
    """Dots at the located extremes of curves, which lead there: label of a curve -> its path."""
    for curve in list(axes.lines):
        path = paths.get(curve.get_label())
        for name in (f"{path}_min", f"{path}_max"):
            if result.located is None or name not in result.located:
                continue
            column = result.located.columns[name]
            times, values = result.located.times[:, column], result.located.values[:, column]
            curve.set_data(*_through(*curve.get_data(), times, values))
            axes.plot(times, values, "o", ms=2.5, color=curve.get_color())


def _through(x: np.ndarray, y: np.ndarray, times: np.ndarray, values: np.ndarray):
    """A curve (x, y) that also passes through points between its samples."""
    inside = np.isfinite(values) & (times >= x[0]) & (times <= x[-1])
    x, y = np.append(x, times[inside]), np.append(y, values[inside])
    order = np.argsort(x, kind="stable")
    return x[order], y[order]


def drive(result: Result, axes) -> None:
    """Driving torques and forces, or the angles where nothing drives."""
    paths = efforts.drive_efforts(result)
    if not paths:
        _largest(
            result,
            axes,
            {name: result[name].theta for name in result.names("bodies")},
            "angle [rad]",
            {},
        )
        return
    units = [f"{path.rpartition('/')[2]} [{result.units(path)}]" for path in paths.values()]
    values = {name: result.values(path) for name, path in paths.items()}
    _largest(result, axes, values, "driving " + " and ".join(dict.fromkeys(units)), paths)


def joint_forces(result: Result, axes) -> None:
    """Magnitude of the force in each joint with clearance; of all joints where none has."""
    loose = [name for name in result.clearances if name in result.names("joints")]
    forces = {
        name: np.hypot(*result.joint(name).force.T) for name in loose or result.names("joints")
    }
    label = "force in joints with clearance [N]" if loose else "joint force [N]"
    _largest(result, axes, forces, label, {name: f"joints/{name}/force" for name in forces})


def _largest(
    result: Record, axes, values: dict[str, np.ndarray], label: str, paths: dict[str, str]
) -> None:
    """Curves (samples,) by name; of many, those that reach furthest, which the label states; dots:
    their extremes.
    """
    shown, remark = efforts.largest(values)
    for name, curve in shown.items():
        line(axes, result.time, curve, label=name)
    _mark(result, axes, paths)
    finish(axes, f"{label}\n{remark}".strip())


def energy(result: Result, axes) -> None:
    """Kinetic energy and, on an axis of its own, the residual of the energy ledger where one was
    integrated.
    """
    line(axes, result.time, result.energy.kinetic, color="tab:gray", label="kinetic energy")
    finish(axes, LEDGER[0])
    if "energy/residual" not in result:
        return
    right = axes.twinx()
    line(right, result.time, result.energy.residual, color="tab:red")
    right.set_ylabel(LEDGER[1], color="tab:red")


def orbit(result: Result, joint: str, axes) -> None:
    """Path of the journal in the clearance circle, or of a block in its guide, coloured by what the
    joint does.

    Joints with a film that is never shared have their smallest gap marked instead.
    """
    if joint in of_slides(result):
        return portrait(result, joint, axes)
    law = result.described(joint)
    e = result.joint(joint).eccentricity / law["clearance"]
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color="black", lw=0.8)
    if set(MEMBERSHIPS) <= set(result.names(f"joints/{joint}")):
        _coloured(axes, *e.T, _states(result, joint), STATES, trajectory)
    elif law.get("film"):
        trajectory(axes, *e.T, color=STATES["full film"])
        far = np.hypot(*e.T)
        gap, name = 1.0 - far.max(), f"joints/{joint}/gap_min"
        if result.located and name in result.located:
            gap = result.located.of(name).value / law["clearance"]
        label = f"smallest gap {gap:.3g} c"
        axes.plot(*e[far.argmax()], "D", ms=3.5, color="tab:orange", label=label, zorder=3)
    else:
        path, contact, _ = with_contacts(result, joint)
        _coloured(axes, *path.T / law["clearance"], contact.astype(int), FLIGHT, trajectory)
    axes.plot(*e[-1], "o", ms=4, color="black")
    axes.set_aspect("equal")
    axes.set_xlabel("eccentricity x / c [-]")
    axes.set_ylabel("eccentricity y / c [-]")
    axes.set_title(f"journal path, joint {joint} (fixed axes; dot: end)", fontsize="medium", pad=20)
    handles = axes.get_legend_handles_labels()[0]
    axes.legend(
        fontsize="small",
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        borderpad=0.0,
        ncols=len(handles),
        frameon=False,
    )


def _coloured(axes, x: np.ndarray, y: np.ndarray, state: np.ndarray, colours: dict, draw) -> None:
    """A curve (n,) in the colours of states, index `state` (n,) into them; `draw` puts each on the
    axes.
    """
    for i, (name, colour) in enumerate(colours.items()):
        here = state == i
        here[:-1] |= here[1:]  # a state holds from the sample before on
        if here.any():
            draw(axes, x, np.where(here, y, np.nan), color=colour, lw=1.0, label=name)


def _states(result: Result, joint: str) -> np.ndarray:
    """Index of the state (full film, mixed, dry) with the largest membership, for every sample."""
    return np.argmax([result.values(f"joints/{joint}/{name}") for name in MEMBERSHIPS], axis=0)


def touched(record: Record, joint: str, clock: np.ndarray) -> np.ndarray:
    """True where a contact event of a joint lies between a time of the ascending clock (n,) [s] and
    the one before.
    """
    events = record.events
    here = events["joint"] == joint
    starts = np.sort(events["time"][here])
    ends = np.sort((events["time"] + events["duration"])[here])
    before = np.concatenate([clock[:1], clock[:-1]])
    # contacts begun up to here that had not ended at the time before
    return np.searchsorted(starts, clock, side="right") > np.searchsorted(ends, before)


def with_contacts(record: Record, joint: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Path (n, 2) of a dry joint's journal [m], which of its points it reaches in contact (n,), and
    when (n,) [s].

    Both ends of each contact stand between the samples, on the clearance circle. They lie where the
    free flight beside them leads, or on the chord where no flight lasts a complete sample interval.
    In contact the path follows the wall between its points.
    """
    time, e, events = record.time, record.joint(joint).eccentricity, record.events
    places = np.flatnonzero(events["joint"] == joint)
    places = places[np.argsort(events["time"][places])]
    starts = events["time"][places]
    ends = starts + events["duration"][places]
    within = np.searchsorted(starts, time, side="right") > np.searchsorted(ends, time)
    busy = np.searchsorted(starts, time[1:]) > np.searchsorted(ends, time[:-1], side="right")
    law = record.described(joint)
    before = _flown(time, e, busy, starts, np.append(-np.inf, ends[:-1]), -1)
    after = _flown(time, e, busy, ends, np.append(starts[1:], np.inf), 1)
    instants = np.concatenate([starts, ends])
    chord = np.stack([np.interp(instants, time, values) for values in e.T], axis=1)
    # contacts that begin and end between the same samples
    short = np.searchsorted(time, starts) == np.searchsorted(time, ends)
    begun = np.where(np.isnan(before) & short[:, None], after, before)
    ended = np.where(np.isnan(after) & short[:, None], before, after)
    wall = np.concatenate([begun, ended])
    wall = np.where(np.isnan(wall), chord, wall)
    wall *= law["clearance"] / np.maximum(np.hypot(*wall.T), 1e-300)[:, None]
    inside = (instants > time[0]) & (instants < time[-1])
    order = np.argsort(np.concatenate([time, instants[inside]]), kind="stable")
    reached = np.concatenate([within, np.repeat([False, True], len(starts))[inside]])
    clock = np.concatenate([time, instants[inside]])[order]
    return _along_the_wall(np.concatenate([e, wall[inside]])[order], reached[order], clock)


def _along_the_wall(path, reached, clock) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The path (n, 2) with points between samples of one contact, ARC apart or less.

    Angle and distance from the centre go evenly from sample to sample: a chord would leave the
    wall.
    """
    polar = np.stack([np.hypot(*path.T), np.unwrap(np.arctan2(*path.T[::-1]))], axis=1)
    near = np.isclose(polar[:-1, 0], polar[1:, 0], rtol=0.1)
    steps = np.abs(np.diff(polar[:, 1])) * (reached[1:] & near)
    parts = np.append(0.0, np.maximum(np.ceil(steps / ARC), 1.0))
    ends = np.cumsum(parts)
    at = np.arange(ends[-1] + 1.0)
    far, angle, when = (np.interp(at, ends, values) for values in (*polar.T, clock))
    here = reached[np.searchsorted(ends, at)]
    rounded = far[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rounded[ends.astype(int)] = path
    return rounded, here, when


def _flown(time, e, busy, instants, neighbours, side: int) -> np.ndarray:
    """Places (m, 2) at some instants (m,) on the line through the two samples beside each.

    These lie before (side -1) or after (1). busy: sample intervals (n - 1,) with a contact;
    neighbours (m,): the end of the contact before, or the start of the one after. nan where
    another contact lies between.
    """
    places = np.full((len(instants), 2), np.nan)
    near = np.searchsorted(time, instants, side="right") - (side < 0)  # the sample beside
    first = near + min(side, 0)
    free = (first >= 0) & (first < len(time) - 1)
    free[free] &= ~busy[first[free]]
    free[free] &= side * (neighbours[free] - time[near[free]]) > 0.0
    i, k = first[free], near[free]
    slope = (e[i + 1] - e[i]) / (time[i + 1] - time[i])[:, None]
    places[free] = e[k] + slope * (instants[free] - time[k])[:, None]
    return places


def regimes(result: Result, joint: str, axes, turns: float = 2.0) -> None:
    """Film thickness ratio over the last turns of a mixed joint, coloured by its state, and who
    carries the load.

    Between elastic surfaces it is that of their film; the nominal gap's is dashed. Dotted: the
    thresholds dry, mixed, full of the joint's transition law, where these are parameters of it.
    """
    time, channels = result.time, result.joint(joint)
    late = time >= time[-1] - turns * (result.turn or time[-1] / 4.0)
    ratio, state = channels.film_thickness_ratio[late], _states(result, joint)[late]
    if f"joints/{joint}/elastic_film" in result:
        axes.plot(time[late], ratio, color="0.6", lw=0.6, ls="--", label="without deflection")
        axes.legend(frameon=False, fontsize="small", loc="upper left")
        ratio = channels.elastic_film[late] / result.described(joint)["roughness"]
    _coloured(
        axes,
        time[late],
        ratio,
        state,
        STATES,
        lambda axes, *curve, **style: axes.plot(*curve, **style),
    )
    if ratio.min() > 0.0:
        axes.set_yscale("log")
        plain_decades(axes.yaxis, *axes.get_ylim())
    else:
        axes.set_yscale("symlog", linthresh=0.1)
    law = result.described(joint)["transition"]
    for name in (n for n in THRESHOLDS if n in law):
        axes.axhline(law[name], color="0.5", lw=0.6, ls=":")
        position = {
            "transform": axes.get_yaxis_transform(),
            "ha": "right",
            "va": "bottom",
            "fontsize": "small",
        }
        axes.text(0.995, law[name], f"{name} {law[name]:g}", color="0.3", **position)
    axes.set_title(f"joint {joint}", fontsize="medium", loc="right")
    finish(axes, "film thickness ratio [-]")
    right = axes.twinx()
    share = channels.asperity_share[late]
    right.fill_between(time[late], 0.0, 100.0 * share, color="0.5", alpha=0.25, lw=0)
    right.set_ylim(0.0, 100.0)
    right.set_ylabel("load on the solids [%]", color="0.4")
