"""Content of a table, and pressure fields along a run: the data behind the pictures of films."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from clearance.files.texts import markdown
from clearance.film.bearing import Bearing, FilmSolution
from clearance.film.lookup import looked_up
from clearance.film.solvers import solve_film
from clearance.film.table import TOP, Key, Table
from clearance.film.table import table as film_table
from clearance.results.record import PressureFields
from clearance.results.result import Result
from clearance.results.tables import save_tables
from clearance.run.pressure_fields import bearing_of, motion, viscosities
from clearance.values import checks


@dataclass(frozen=True)
class Shot:
    """A film at one moment of a run."""

    time: float
    eccentricity_ratio: float
    radial_rate: float
    entrainment: float
    solution: FilmSolution
    recorded: float = math.nan  # film force in the file [N]


def force_map(bearing: Bearing, nodes: int = 33) -> tuple[dict, Table]:
    """Size of the force over P0 |V|, its angle against the motion, and the wet share of the shear,
    from a table.

    Arrays over y = -ln(1 - eps) and the direction of (d(eps)/dt, eps w / 2).
    """
    table = film_table(Key(bearing.slenderness, bearing.cavitation, bearing.thickness, nodes))
    y = np.linspace(0.0, min(TOP, 5.3), 107)
    angle = np.linspace(0.0, math.pi, 91)
    size, direction, shear = np.zeros((3, len(y), len(angle)))
    for i, height in enumerate(y):
        eps = -math.expm1(-height)
        s = math.sqrt(1.0 - eps * eps)
        for j, a in enumerate(angle):
            scaled = math.atan2(s * math.sin(a), math.cos(a))
            speed = math.hypot(math.cos(a), s * math.sin(a))
            still, rest_r, rest_t, wet = looked_up(table.numbers, 0, height, scaled)
            radial = speed * (rest_r - still * math.cos(scaled)) / s**3
            tangential = speed * (rest_t + still * math.sin(scaled)) / s**2
            size[i, j] = math.hypot(radial, tangential)
            against = math.atan2(tangential, -radial) - a
            direction[i, j] = (against + math.pi) % (2.0 * math.pi) - math.pi
            shear[i, j] = wet / (2.0 * math.pi)
    return {"y": y, "angle": angle, "size": size, "direction": direction, "shear": shear}, table


def snapshots(result: Result, joint: str | None = None, count: int = 6, mesh=None) -> list[Shot]:
    """Films of a lubricated joint at moments spread over the last turn (or the entire run) of a
    result file.

    The motion comes from the file alone: eccentricity from the joint, its rate from the bodies'
    velocities. Pressure fields in the file are drawn as they are, where no mesh is requested. Else
    the film is solved again, at the nominal gap and the temperature of the oil. Bearing,
    cavitation, ambient pressure, grooves and flow factors are those of the run. The force that the
    run had stands beside it. Raises ValueError for a joint that has no film or does not exist, and
    for a count below 1. A film with a memory, which no file stores, raises it, too.
    """
    scene = result.scene
    name = joint_with_film(result, joint)
    checks.whole("count", count, 1)
    entry = next(j for j in scene["joints"] if j["name"] == name)
    if entry["film"]["law"].endswith(":conserving"):
        raise ValueError(
            f"{result.path}: joint {name} has a film with a memory, which a file does not keep"
        )
    states = motion(result, entry).tolist()
    oil = viscosities(result, entry)
    forces = result.joint(name).film_radial, result.joint(name).film_tangential
    times = result.time
    begin = np.searchsorted(times, times[-1] - _turn(scene, times))
    fields = result.pressure_fields(name) if mesh is None else None
    places = (
        np.arange(begin, len(times)) if fields is None else fields.instant[fields.instant >= begin]
    )
    chosen = places[np.unique(np.linspace(-1, len(places) - 1, count + 1).astype(int)[1:])]

    def film(i: int) -> FilmSolution:
        bearing = bearing_of(entry, oil[i])
        if fields is None:
            return solve_film(bearing, *states[i], mesh=mesh)
        return _from_file(bearing, fields, int(np.searchsorted(fields.instant, i)))

    recorded = np.hypot(*forces)
    return [Shot(float(times[i]), *states[i], film(i), float(recorded[i])) for i in chosen]


def _from_file(bearing: Bearing, fields: PressureFields, i: int) -> FilmSolution:
    """A field of a file as a film in the frame of the line of centres; what no pressure determines
    is nan.
    """
    theta = (fields.angle - fields.line_of_centres[i] + math.pi) % (2.0 * math.pi)
    order = np.argsort(theta)
    half = fields.axial >= -1e-9 * bearing.length
    pressure = fields.pressure[i].T
    rule = np.full(len(fields.axial), 2.0)  # Simpson's
    rule[1::2], rule[[0, -1]] = 4.0, 1.0
    line = pressure @ rule * (fields.axial[1] - fields.axial[0]) / 3.0
    part = bearing.radius * (fields.angle[1] - fields.angle[0])
    radial, tangential = (float((line * f(theta)).sum() * part) for f in (np.cos, np.sin))
    return FilmSolution(
        bearing=bearing,
        theta=theta[order],
        axial=np.abs(fields.axial[half]),
        pressure=pressure[order][:, half],
        content=fields.content[i].T[order][:, half],
        radial=radial,
        tangential=tangential,
        shear=math.nan,
        side_flow=math.nan,
        iterations=0,
        unknowns=0,
    )


def joint_with_film(result: Result, joint: str | None) -> str:
    """The joint requested, or the first with a film. Raises ValueError naming those there are."""
    films = [j["name"] for j in result.scene["joints"] if j.get("film")]
    if not films:
        raise ValueError(f"{result.path}: this run has no joint with a film")
    if joint is not None and joint not in films:
        raise ValueError(
            f"{result.path}: joint {joint!r} has no film; joints with one: {', '.join(films)}"
        )
    return films[0] if joint is None else joint


def _turn(scene: dict, times: np.ndarray) -> float:
    speed = next(
        (d["speed"] for d in scene["loads"] if isinstance(d.get("speed"), float) and d["speed"]),
        None,
    )
    return min(2.0 * math.pi / abs(speed), times[-1]) if speed else float(times[-1])


# --- reports
FACTS = (
    ("load", "N", "size of the film force"),
    ("radial", "N", "force on the journal along the line of centres"),
    ("tangential", "N", "force on the journal across it"),
    ("attitude_angle", "rad", "of the load it carries"),
    ("centre_of_pressure", "rad", "from the widest gap"),
    ("peak_pressure", "Pa", "above ambient"),
    ("shear", "1", "integral of 1/H over the wet area"),
    ("drag", "N m s", "friction torque over the difference of speeds"),
    ("side_flow", "m3/s", "oil that leaves at both ends"),
)


def plain(solution: FilmSolution) -> dict:
    """Results of a film as plain data."""
    facts = {name: float(getattr(solution, name)) for name, _, _ in FACTS}
    return facts | {"iterations": solution.iterations, "unknowns": solution.unknowns}


def report(solution: FilmSolution) -> list[str]:
    """Results of a film as text."""
    lines = [
        f"{name:<20} {getattr(solution, name):>14.6g} {units:<5} {text}"
        for name, units, text in FACTS
    ]
    return [*lines, f"{solution.unknowns} unknowns, {solution.iterations} linear systems"]


def _fields(solution: FilmSolution) -> dict:
    return {
        "theta": ("rad", "angle from the widest gap", solution.theta),
        "axial": ("m", "from the middle", solution.axial),
        "pressure": ("Pa", "pressure above ambient (theta, axial)", solution.pressure),
        "content": ("1", "share of the gap that holds oil (theta, axial)", solution.content),
    }


def save(solution: FilmSolution, folder: str | Path) -> Path:
    """Fields and results of a film as HDF5."""
    return save_tables(
        Path(folder) / "film_pressure.h5",
        "clearance-film",
        plain(solution),
        {"film": ({}, _fields(solution))},
    )


def map_report(table: Table, title: str) -> list[str]:
    """Error of a table."""
    return [
        title,
        f"largest relative force error where the journal closes in  {table.error_closing:.1e}",
        f"largest of wet area, of side flow                         {table.error_shear:.1e}, "
        f"{table.error_flow:.1e}",
        f"median of all states                                      {table.error_median:.1e}",
        f"largest where it recedes (of a force that is small then)  {table.error_opening:.1e}",
        f"{table.numbers.size} numbers, {table.numbers.nbytes / 1024:.0f} kB",
    ]


def save_map(values: dict, table: Table, folder: str | Path) -> Path:
    """A force map as HDF5."""
    columns = {
        "y": ("1", "-ln(1 - eccentricity ratio)", values["y"]),
        "angle": ("rad", "direction of the motion (d(eps)/dt, eps w / 2)", values["angle"]),
        "size": ("1", "force over mu L R^3 / c^2 |V| (y, angle)", values["size"]),
        "direction": (
            "rad",
            "angle of the force against the motion (y, angle)",
            values["direction"],
        ),
        "shear": ("1", "wet share of the Couette drag (y, angle)", values["shear"]),
    }
    return save_tables(
        Path(folder) / "film_map.h5", "clearance-film-map", table.facts(), {"map": ({}, columns)}
    )


def shot_plain(shot: Shot) -> dict:
    """A snapshot as plain data."""
    return {n: v for n, v in vars(shot).items() if n != "solution"} | plain(shot.solution)


def shots_report(shots: list[Shot]) -> list[str]:
    """Snapshots as a table."""
    heads = "time / ms", "eps", "d(eps)/dt [1/s]", "w [rad/s]", "load [N]", "in the file [N]"
    rows = (
        (
            f"{s.time * 1e3:.5g}",
            f"{s.eccentricity_ratio:.4f}",
            f"{s.radial_rate:.4g}",
            f"{s.entrainment:.4g}",
            f"{s.solution.load:.4g}",
            f"{s.recorded:.4g}",
            f"{s.solution.peak_pressure / 1e6:.4g}",
        )
        for s in shots
    )
    return markdown((*heads, "peak pressure [MPa]"), rows)


def save_shots(shots: list[Shot], folder: str | Path) -> Path:
    """Snapshots as HDF5, one group a moment."""
    groups = {f"snapshot_{i}": (shot_plain(s), _fields(s.solution)) for i, s in enumerate(shots)}
    return save_tables(Path(folder) / "film_snapshots.h5", "clearance-film-snapshots", {}, groups)
