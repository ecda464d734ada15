"""`clearance film WHAT`: the Reynolds equation on its own."""

import argparse
import math
import re
from pathlib import Path

from clearance.commands.common import (
    DONE,
    Line,
    add_command,
    json_text,
    make_folder,
    number,
    publish,
    quantity_of,
)


def add(commands) -> list[argparse.ArgumentParser]:
    """The commands and their options."""
    film = add_command(commands, "film")
    whats = film.add_subparsers(dest="what", required=True, metavar="WHAT")
    pressure = add_command(
        whats, "pressure", help="pressure, load, friction and flow of a bearing in one state"
    )
    linear = add_command(
        whats, "coefficients", help="stiffness and damping of a bearing's film about a load"
    )
    map_ = add_command(whats, "map", help="what the force table of a bearing holds, and its error")
    shots = add_command(
        whats, "snapshots", help="pressure fields along a run, from its result file"
    )
    meshes = add_command(
        whats, "convergence", help="error of both solvers as their meshes are refined"
    )
    ladder = add_command(
        whats, "ladder", help="error against run time of all films, single states and a feeder run"
    )
    for command in (pressure, linear, map_, meshes):
        for name, default, text in _BEARING:
            command.add_argument(
                f"--{name}",
                type=quantity_of(text[1]),
                default=default,
                help=f"{text[0]} ({default})",
            )
        command.add_argument(
            "--cavitation", default="reynolds", help="reynolds, gumbel, none or mass_conserving"
        )
    for name, default, text in _REST:
        linear.add_argument(
            f"--{name}", type=quantity_of(text[1]), default=default, help=f"{text[0]} ({default})"
        )
    for name, default, text in _STATE:
        pressure.add_argument(
            f"--{name}", type=quantity_of(text[1]), default=default, help=f"{text[0]} ({default})"
        )
    pressure.add_argument(
        "--groove",
        action="append",
        default=[],
        metavar="ANGLE[,WIDTH[,LENGTH[,PRESSURE]]]",
        help="oil supply: angle from the widest gap, width, axial share, pressure above ambient; "
        "may be repeated",
    )
    pressure.add_argument("--solver", default="auto", help="auto, fast or fem")
    for command in (pressure, shots):
        command.add_argument(
            "--mesh", type=_mesh, metavar="NxM", help="cells around x over half the length"
        )
    map_.add_argument(
        "--roughness", type=quantity_of("m"), default="0", help="of the flow factors, 0: smooth (0)"
    )
    map_.add_argument(
        "--nodes", type=int, default=33, help="nodes over eccentricity and direction (33)"
    )
    shots.add_argument("file", metavar="RUN.h5", help="a result file")
    shots.add_argument("--joint", help="joint (default the first with a film)")
    shots.add_argument(
        "--count", type=int, default=6, metavar="N", help="moments over the last turn (6)"
    )
    ladder.add_argument(
        "--turns", type=number, default=1.0, help="length of the feeder run in turns (1)"
    )
    ladder.add_argument("--quick", action="store_true", help="coarse meshes only")
    every = {
        pressure: _pressure,
        linear: _coefficients,
        map_: _map,
        shots: _snapshots,
        meshes: _convergence,
        ladder: _ladder,
    }
    for command, action in every.items():
        command.add_argument(
            "-o", dest="output", metavar="DIR", help="folder for table, picture and data"
        )
        command.set_defaults(study=action)
    return list(every)


#: options of `clearance film`: name, default, (meaning, unit)
_BEARING = (
    ("radius", "10mm", ("journal radius", "m")),
    ("clearance", "0.1mm", ("radial clearance", "m")),
    ("length", "20mm", ("length of the bearing", "m")),
    ("viscosity", "50cP", ("dynamic viscosity", "Pa s")),
)
_REST = (
    ("load", "20N", ("steady load", "N")),
    ("speed", "3000rpm", ("speed of the journal", "rad/s")),
)
_STATE = (
    ("eccentricity", "0.8", ("eccentricity ratio", "1")),
    ("rate", "0", ("rate of the eccentricity ratio", "1/s")),
    ("entrainment", "300rpm", ("omega_J + omega_B - 2 gamma'", "rad/s")),
    ("ambient", "0", ("ambient above cavitation pressure, 0: the same", "Pa")),
    ("roughness", "0", ("composite roughness of the flow factors, 0: smooth", "m")),
)


def _mesh(text: str) -> tuple[int, int]:
    if not (match := re.fullmatch(r"(\d+)x(\d+)", text)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a mesh such as 64x8")
    return int(match[1]), int(match[2])


def run(options) -> int:
    """Make the study requested."""
    make_folder(options)
    return options.study(options)


def _bearing(options, **more):
    from clearance.film.bearing import Bearing

    return Bearing(
        options.radius,
        options.clearance,
        options.length,
        options.viscosity,
        options.cavitation,
        **more,
    )


def _groove(text: str):
    from clearance.film.bearing import Groove
    from clearance.values.units import quantity

    parts, units = text.split(","), ("rad", "rad", "1", "Pa")
    if len(parts) > len(units):
        raise ValueError(f"--groove {text}: expected ANGLE[,WIDTH[,LENGTH[,PRESSURE]]]")
    try:
        return Groove(*(quantity(t, u) for t, u in zip(parts, units, strict=False)))
    except ValueError as error:
        raise ValueError(f"--groove {text}: {error}") from None


def _pressure(options) -> int:
    from clearance.film.solvers import solve_film
    from clearance.postprocess import film_pictures
    from clearance.studies import films

    bearing = _bearing(
        options,
        ambient=options.ambient or None,
        grooves=tuple(map(_groove, options.groove)),
        roughness=options.roughness,
    )
    state = options.eccentricity, options.rate, options.entrainment
    solved = solve_film(bearing, *state, solver=options.solver, mesh=options.mesh)
    title = (
        f"L/D {bearing.slenderness:.3g}, eps {state[0]:g}, d(eps)/dt {state[1]:g} 1/s, w "
        f"{state[2]:.4g} rad/s"
    )
    title += f", {options.cavitation}" + (
        f", ambient {options.ambient / 1e3:g} kPa" if options.ambient else ""
    )
    title += f", {len(options.groove)} groove(s)" if options.groove else ""
    return publish(
        options,
        films.report(solved),
        films.plain(solved),
        lambda folder: films.save(solved, folder),
        lambda solution, path: film_pictures.pressure(solution, title, path),
        solved,
        "film_pressure",
    )


def _coefficients(options) -> int:
    from clearance.files.texts import markdown
    from clearance.film.coefficients import film_coefficients

    film = film_coefficients(_bearing(options), options.load, options.speed)
    rows = [("stiffness", "N/m", film.stiffness), ("damping", "N s/m", film.damping)]
    lines = [
        f"eccentricity ratio {film.eccentricity_ratio:.6g}, attitude "
        f"{math.degrees(film.attitude):.4g} deg; x along the load, y on in the sense of rotation",
        "",
        *markdown(
            ("", "xx", "xy", "yx", "yy"),
            ((f"{n} [{u}]", *(f"{v:.5g}" for v in matrix.ravel())) for n, u, matrix in rows),
        ),
    ]
    document = {n: v.tolist() if hasattr(v, "tolist") else v for n, v in vars(film).items()}
    if options.output:
        document["files"] = [str(Path(options.output) / "film_coefficients.md")]
        Path(document["files"][0]).write_text("\n".join(lines) + "\n")
    print(json_text(document) if options.json else "\n".join(lines))
    return DONE


def _map(options) -> int:
    from clearance.postprocess import film_pictures
    from clearance.studies import films

    bearing = _bearing(options, roughness=options.roughness)
    result, table = films.force_map(bearing, options.nodes)
    title = (
        f"film table of L/D {bearing.slenderness:.3g}, {options.cavitation}, {options.nodes} "
        "nodes each way"
    )
    return publish(
        options,
        films.map_report(table, title),
        table.facts(),
        lambda folder: films.save_map(result, table, folder),
        lambda shown, path: film_pictures.force_map(shown, title, path),
        result,
        "film_map",
    )


def _snapshots(options) -> int:
    from clearance.postprocess import film_pictures
    from clearance.results.result import open_result
    from clearance.studies import films

    result = open_result(options.file)
    shots = films.snapshots(result, options.joint, options.count, options.mesh)
    case, joint = result.attributes["case"], films.joint_with_film(result, options.joint)
    return publish(
        options,
        films.shots_report(shots),
        {"snapshots": [films.shot_plain(s) for s in shots]},
        lambda folder: films.save_shots(shots, folder),
        lambda shown, path: film_pictures.snapshots(shown, joint, case, path),
        shots,
        "film_snapshots",
    )


def _convergence(options) -> int:
    import dataclasses

    from clearance.paper_figures import film_ladder
    from clearance.postprocess import film_pictures

    meshes = film_ladder.convergence(_bearing(options), progress=Line(options))
    return publish(
        options,
        film_ladder.convergence_table(meshes),
        {"meshes": [dataclasses.asdict(m) for m in meshes]},
        lambda folder: film_ladder.save_convergence(meshes, folder),
        film_pictures.convergence,
        meshes,
        "film_convergence",
    )


def _ladder(options) -> int:
    from clearance.paper_figures import film_ladder
    from clearance.postprocess import film_pictures

    study = film_ladder.ladder(options.turns, options.quick, Line(options))
    return publish(
        options,
        [*film_ladder.table(study), "", *film_ladder.describe(study)],
        film_ladder.plain(study),
        lambda folder: film_ladder.save(study, folder),
        film_pictures.ladder,
        study,
        "film_ladder",
    )
