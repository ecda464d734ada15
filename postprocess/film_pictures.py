"""Pictures of films: pressure over the unwrapped bearing, the force map of a table, snapshots of a
run, the ladder.
"""

import math
from pathlib import Path

# isort: off
from clearance.postprocess.sheets import sheet  # before matplotlib is imported

# isort: on
import numpy as np
from clearance.postprocess.study_pictures import saved
from matplotlib.ticker import MaxNLocator

from clearance.film.bearing import FilmSolution

KINDS = {
    "closed form": ("#7f7f7f", "s"),
    "table": ("#c8102e", "o"),
    "elastic film": ("tab:orange", "v"),
    "fast solver": ("#0b3d91", "^"),
    "finite elements": ("#00843d", "D"),
}
WET = 0.999  # content above which a place counts as full
FAINT = 1.0 / 16.0  # of the largest pressure of all snapshots: about one colour of their scale


def unwrapped(solution: FilmSolution, axes, top: float | None = None, lowest: float | None = None):
    """Pressure over angle and length, with the edge of the film as a white line."""
    theta = np.degrees(np.append(solution.theta, solution.theta[0] + 2.0 * math.pi))
    z = np.concatenate([-solution.axial[:0:-1], solution.axial]) * 1e3

    def whole(values):
        values = np.vstack([values, values[:1]])
        return np.hstack([values[:, :0:-1], values]).T

    pressure = whole(solution.pressure) / 1e6
    span = lowest if lowest is not None else pressure.min(), top or pressure.max() or 1e-9
    drawn = axes.contourf(
        theta, z, pressure, levels=MaxNLocator(24).tick_values(*span), cmap="viridis"
    )
    content = whole(solution.content)
    if content.min() < WET:
        axes.contour(
            theta,
            z,
            content,
            levels=[0.5 if content.min() == 0.0 else WET],
            colors="white",
            linewidths=1.2,
        )
    axes.set_xlabel("angle from the widest gap [deg]")
    axes.set_ylabel("z [mm]")
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 60))
    return drawn


def pressure(solution: FilmSolution, title: str, path: str | Path) -> Path:
    """The field, and along the middle the pressure beside the gap."""
    figure = sheet(9.0, 6.2)
    field, section = figure.subplots(2, 1, height_ratios=(3, 2), sharex=True)
    drawn = unwrapped(solution, field)
    figure.colorbar(drawn, ax=field, label="pressure above ambient [MPa]")
    field.set_xlabel("")
    field.set_title(title, fontsize=10)
    theta = np.degrees(np.append(solution.theta, solution.theta[0] + 2.0 * math.pi))
    content, middle = (np.append(v[:, 0], v[0, 0]) for v in (solution.content, solution.pressure))
    section.plot(theta, middle / 1e6, color="#c8102e", label="pressure in the middle")
    section.fill_between(
        theta, 0, 1, where=content < WET, color="0.9", lw=0, transform=section.get_xaxis_transform()
    )
    section.axvline(
        math.degrees(solution.centre_of_pressure),
        color="#c8102e",
        ls=":",
        lw=1,
        label="its resultant",
    )
    section.set_xlabel("angle from the widest gap [deg]")
    section.set_ylabel("pressure [MPa]")
    section.grid(alpha=0.3)
    section.legend(fontsize=8, frameon=False)
    section.set_title("white edge, grey: cavitated", fontsize=8, loc="right")
    return saved(figure, path)


def force_map(map_: dict, title: str, path: str | Path) -> Path:
    """Size and direction of the force over eccentricity and direction of the motion: what a table
    holds.
    """
    figure = sheet(11.0, 4.4)
    panels = figure.subplots(1, 3)
    y, angle = map_["y"], np.degrees(map_["angle"])
    shown = (
        (np.log10(map_["size"]), "log10 of the force over P0 |V|", "viridis"),
        (np.degrees(map_["direction"]), "force against the motion [deg]", "twilight_shifted"),
        (map_["shear"], "wet share of the Couette drag", "cividis"),
    )
    for axes, (values, name, colours) in zip(panels, shown, strict=True):
        drawn = axes.contourf(angle, y, values, levels=21, cmap=colours)
        figure.colorbar(drawn, ax=axes, location="bottom", label=name, ticks=MaxNLocator(6))
        axes.set_xlabel("direction of the motion [deg]:\n0 closing, 90 turning, 180 opening")
        ratios = (0.0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995)
        axes.set_yticks([-math.log1p(-e) for e in ratios], [f"{e:g}" for e in ratios])
    panels[0].set_ylabel("eccentricity ratio")
    figure.suptitle(title, fontsize=10)
    return saved(figure, path)


def snapshots(shots: list, joint: str, title: str, path: str | Path) -> Path:
    """Pressure fields along a run, all on one scale, with time and state above each."""
    columns = min(3, len(shots))
    rows = -(-len(shots) // columns)
    figure = sheet(4.0 * columns, 2.6 * rows + 0.6)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    top = max(s.solution.peak_pressure for s in shots) / 1e6
    lowest = min(float(s.solution.pressure.min()) for s in shots) / 1e6
    for axes in panels.flat[len(shots) :]:
        axes.axis("off")
    for i, (axes, shot) in enumerate(zip(panels.flat, shots, strict=False)):
        drawn = unwrapped(shot.solution, axes, top, lowest)
        flat = shot.solution.peak_pressure / 1e6 < FAINT * top
        axes.set_title(
            f"{shot.time * 1e3:.4g} ms: eps {shot.eccentricity_ratio:.3f}, "
            f"{shot.solution.load:.3g} N, "
            f"up to {shot.solution.peak_pressure / 1e6:.3g} "
            f"MPa{', too low for the scale' if flat else ''}",
            fontsize=8,
        )
        if i + columns < len(shots):
            axes.set_xlabel("")
        if i % columns:
            axes.set_ylabel("")
    figure.colorbar(drawn, ax=panels, label="pressure above ambient [MPa]", shrink=0.8)
    figure.suptitle(f"{title}, joint {joint} (white: edge of the film)", fontsize=10)
    return saved(figure, path)


def _short(name: str) -> str:
    """The mesh or the nodes of a rung without its kind."""
    return name.removeprefix("fast solver ").removeprefix("FEM ").removeprefix("table ")


def _rung_labels(rungs: list):
    """Rungs, their labels, and where these stand [points]: left of tables and elements; of tables
    there is one.
    """
    kinds = {kind: [r for r in rungs if r.kind == kind] for kind in KINDS}
    for i, r in enumerate(sorted(kinds["closed form"], key=lambda r: -r.error)):
        yield r, _short(r.name), (6, (5, -5)[i % 2])  # neighbours lie on one another
    for r in kinds["fast solver"]:
        yield r, _short(r.name), (6, 0)
    for r in kinds["finite elements"]:
        yield r, _short(r.name), (-6, 0)
    if tables := kinds["table"]:
        names = dict.fromkeys((_short(tables[0].name), _short(tables[-1].name)))
        yield max(tables, key=lambda r: r.error), " to ".join(names), (-6, 0)


def ladder(study, path: str | Path) -> Path:
    """Error against run time, left of single states and right of a complete run."""
    figure = sheet(11.0, 5.4)
    states, right = figure.subplots(1, 2)
    for axes, rungs, unit in ((states, study.states, 1e6), (right, study.runs, 1e3)):
        for kind, (colour, marker) in KINDS.items():
            of_kind = [r for r in rungs if r.kind == kind]
            axes.loglog(
                [r.error for r in of_kind],
                [unit * r.seconds for r in of_kind],
                marker,
                color=colour,
                ms=6,
                label=kind if of_kind else None,
            )
        for r, name, shift in _rung_labels(rungs):
            side = "left" if shift[0] > 0 else "right"
            offset = {"textcoords": "offset points", "ha": side, "va": "center", "fontsize": 7}
            axes.annotate(name, (r.error, unit * r.seconds), xytext=shift, **offset)
        axes.invert_xaxis()
        axes.margins(0.15)
        axes.grid(True, which="major", color="0.9")
    states.set_xlabel("median relative error of the force")
    states.set_ylabel("CPU time of one force [us]")
    states.set_title("single states", fontsize=10)
    right.set_xlabel("rms error of the journal's path over c")
    right.set_ylabel("CPU time of a run [ms]")
    right.set_title("six-bar feeder", fontsize=10)
    states.legend(fontsize=8, frameon=False, loc="lower right")
    return saved(figure, path)


def convergence(meshes, path: str | Path) -> Path:
    """Error of the force against unknowns, and against time."""
    figure = sheet(10.0, 4.4)
    panels = figure.subplots(1, 2, sharey=True)
    for solver in dict.fromkeys(m.solver for m in meshes):
        of_solver = [m for m in meshes if m.solver == solver]
        panels[0].loglog(
            [m.unknowns for m in of_solver], [m.error for m in of_solver], "o-", label=solver
        )
        panels[1].loglog(
            [1e3 * m.seconds for m in of_solver], [m.error for m in of_solver], "o-", label=solver
        )
    for order, style in ((2, ":"), (4, "--")):
        first = meshes[0]
        x = np.array([first.unknowns, 40.0 * first.unknowns])
        panels[0].loglog(
            x, first.error * (x / x[0]) ** (-order / 2), style, color="0.6", label=f"order {order}"
        )
    panels[0].set_xlabel("unknowns")
    panels[1].set_xlabel("time of one film [ms]")
    panels[0].set_ylabel("relative error of the force")
    panels[0].legend(fontsize=8, frameon=False)
    for axes in panels:
        axes.grid(True, which="major", color="0.9")
    return saved(figure, path)
