"""First pictures of a run."""

import json
import textwrap
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from clearance.postprocess.figures import POINTS, finish, line, save, sheet

from clearance.results import Result

#: states of a mixed joint and their colours
STATES = {"full film": "tab:blue", "mixed": "tab:orange", "dry": "tab:red"}
#: channels of a mixed joint that its states are drawn from
OF_STATES = {"film_thickness_ratio", "asperity_share", *(f"membership_{s.replace(' ', '_')}" for s in STATES)}


def overview(result: Result, path: str | Path) -> Path:
    """One page: motion, drive, joint forces, journal orbits and the energy balance. Saved under `path`."""
    clearance_joints = [n for n in result.file["joints"] if "eccentricity_x" in result.file["joints"][n]]
    shown = clearance_joints[:3]
    mixed = [n for n in shown if "membership_dry" in result.file["joints"][n]]
    rows = 2 + (len(mixed) if mixed else bool(shown))
    figure = sheet(11.0, 3.4 * rows)
    grid = figure.add_gridspec(rows, 6)
    panels = [(grid[0, :3], motion), (grid[0, 3:], drive), (grid[1, :3], joint_forces), (grid[1, 3:], energy)]
    for place, draw in panels:
        draw(result, figure.add_subplot(place))
    width = 6 // max(len(shown), 1)
    for i, name in enumerate(mixed):
        orbit(result, name, figure.add_subplot(grid[2 + i, :2]))
        regimes(result, name, figure.add_subplot(grid[2 + i, 2:]))
    for i, name in enumerate(shown if not mixed else ()):
        orbit(result, name, figure.add_subplot(grid[2, i * width : (i + 1) * width]))
    figure.suptitle(textwrap.fill(": ".join(filter(None, (result.attributes["case"], title(result)))), 110))
    return save(figure, path, dpi=130)


def orbits(result: Result, path: str | Path, *, joints: str | Iterable[str] | None = None) -> Path:
    """Journal paths of clearance joints, and the states of mixed ones over the last turns, saved under `path`.

    joints: default all whose eccentricity was kept. Raises ValueError for others, and where there is none.
    """
    known = [j for j in result.clearances if {"eccentricity_x", "eccentricity_y"} <= set(result.names(f"joints/{j}"))]
    names = known if joints is None else [joints] if isinstance(joints, str) else list(joints)
    if unknown := [j for j in names if j not in known]:
        raise ValueError(
            f"no journal path of joint {unknown[0]!r} in {result.path.name}; of {', '.join(known) or 'none'}"
        )
    if not names:
        raise ValueError(f"{result.path.name} has kept the eccentricity of no clearance joint")
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
    figure.suptitle(": ".join(filter(None, (result.attributes["case"], title(result)))), fontsize="medium", wrap=True)
    return save(figure, path, dpi=130)


def title(result: Result) -> str:
    """Drive speed, clearance joints and status in a line."""
    scene = json.loads(result.attributes["scene"])
    parts = [] if result.turn is None else [f"{60.0 / result.turn:.4g} rpm"]
    for joint in scene["joints"]:
        if joint["type"] == "ClearanceRevolute":
            kind = "mixed" if joint.get("transition") else "lubricated" if joint["film"] else "dry"
            parts.append(f"{joint['name']} {kind} c = {joint['clearance'] * 1e3:.3g} mm")
    return ", ".join([*parts, *([] if result.complete else [result.status])])


def motion(result: Result, axes) -> None:
    """Acceleration of the last body (the slider of most mechanisms) along its larger component."""
    name = list(json.loads(result.attributes["scene"])["bodies"])[-1]["name"]
    channels = result[name]
    component = max(("ax", "ay"), key=lambda c: np.ptp(getattr(channels, c)))
    line(axes, result.time, getattr(channels, component), label=name)
    finish(axes, f"acceleration {component[1]} [m/s²]")


def drive(result: Result, axes) -> None:
    """Driving torques and forces, or the angles where nothing drives."""
    found = result.file.get("drives")
    if found is None:
        for name in result.file["bodies"]:
            line(axes, result.time, result[name].theta, label=name)
        finish(axes, "angle [rad]")
        return
    units = []
    for name, group in found.items():
        channel = "torque" if "torque" in group else "force"
        units.append(f"{channel} [{group[channel].attrs['units']}]")
        line(axes, result.time, group[channel][()], label=name)
    finish(axes, "driving " + " and ".join(dict.fromkeys(units)))


def joint_forces(result: Result, axes) -> None:
    """Magnitude of every joint force."""
    for name in result.file["joints"]:
        force = np.hypot(*result.joint(name).force.T)
        line(axes, result.time, force, label=name)
    finish(axes, "joint force [N]")


def energy(result: Result, axes) -> None:
    """Kinetic energy and, on an axis of its own, the residual of the energy ledger."""
    line(axes, result.time, result.energy.kinetic, color="tab:gray", label="kinetic energy")
    finish(axes, "kinetic energy [J]")
    right = axes.twinx()
    line(right, result.time, result.energy.residual, color="tab:red")
    right.set_ylabel("energy residual [J]", color="tab:red")


def orbit(result: Result, joint: str, axes) -> None:
    """Path of the journal's centre in the clearance circle."""
    scene = json.loads(result.attributes["scene"])
    clearance = next(j["clearance"] for j in scene["joints"] if j["name"] == joint)
    e = result.joint(joint).eccentricity / clearance
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color="black", lw=0.8)
    every = max(len(e) // POINTS, 1)
    if "membership_dry" in result.file["joints"][joint]:
        state = _states(result, joint)[::every]
        for i, (name, colour) in enumerate(STATES.items()):
            path = np.where(state[:, None] == i, e[::every], np.nan)
            axes.plot(path[:, 0], path[:, 1], lw=1.0, color=colour, label=name)
    else:
        axes.plot(e[::every, 0], e[::every, 1], lw=0.6)
    axes.plot(*e[-1], "o", ms=4, color="tab:red")
    axes.set_aspect("equal")
    axes.set_xlabel("eccentricity x / c [-]")
    axes.set_ylabel("eccentricity y / c [-]")
    axes.set_title(f"journal path, joint {joint}", fontsize="medium")


def _states(result: Result, joint: str) -> np.ndarray:
    """Index of the state (full film, mixed, dry) with the largest membership, for every sample."""
    channels = result.joint(joint)
    return np.argmax([channels.membership_full_film, channels.membership_mixed, channels.membership_dry], axis=0)


def regimes(result: Result, joint: str, axes, turns: float = 2.0) -> None:
    """Film thickness ratio over the last turns of a mixed joint, coloured by its state, and who carries the load."""
    time, channels = result.time, result.joint(joint)
    speed = next((d["speed"] for d in json.loads(result.attributes["scene"])["loads"] if d.get("speed")), None)
    late = time >= time[-1] - turns * (2.0 * np.pi / abs(speed) if speed else time[-1] / 4.0)
    ratio, state = channels.film_thickness_ratio[late], _states(result, joint)[late]
    for i, (name, colour) in enumerate(STATES.items()):
        axes.plot(time[late], np.where(state == i, ratio, np.nan), color=colour, lw=1.2, label=name)
    axes.set_yscale("symlog", linthresh=1.0)
    for level in (1.0, 3.0):
        axes.axhline(level, color="0.7", lw=0.6, ls=":")
    axes.set_title(f"joint {joint}", fontsize="medium", loc="right")
    finish(axes, "film thickness ratio [-]")
    right = axes.twinx()
    share = channels.asperity_share[late]
    right.fill_between(time[late], 0.0, 100.0 * share, color="0.5", alpha=0.25, lw=0)
    right.set_ylim(0.0, 100.0)
    right.set_ylabel("load on the solids [%]", color="0.4")
