"""`clearance film WHAT`: the Reynolds equation on its own."""

import argparse
import math
import re
from pathlib import Path

from clearance.commands.common import (
    add_command,
    add_options,
    make_folder,
    progress_of,
    publish,
    show,
)


def added(film) -> list[argparse.ArgumentParser]:
    """The studies with their options."""
    whats, studies = film.add_subparsers(dest="what", required=True, metavar="WHAT"), []
    for name, (text, action, *options) in STUDIES.items():
        study = add_command(whats, name, text)
        for table in (*options, OUTPUT):
            add_options(study, table)
        study.set_defaults(study=action)
        studies.append(study)
    return studies


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
    from clearance.paper_figures import films
    from clearance.postprocess import film_pictures

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
        films.save,
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
    return show(options, document, lines)


def _map(options) -> int:
    from clearance.paper_figures import films
    from clearance.postprocess import film_pictures

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
        lambda _, folder: films.save_map(result, table, folder),
        lambda shown, path: film_pictures.force_map(shown, title, path),
        result,
        "film_map",
    )


def _snapshots(options) -> int:
    from clearance.paper_figures import films
    from clearance.postprocess import film_pictures
    from clearance.results.result import open_result

    result = open_result(options.file)
    shots = films.snapshots(result, options.joint, options.count, options.mesh)
    case, joint = result.attributes["case"], films.joint_with_film(result, options.joint)
    return publish(
        options,
        films.shots_report(shots),
        {"snapshots": [films.shot_plain(s) for s in shots]},
        films.save_shots,
        lambda shown, path: film_pictures.snapshots(shown, joint, case, path),
        shots,
        "film_snapshots",
    )


def _convergence(options) -> int:
    import dataclasses

    from clearance.paper_figures import film_ladder
    from clearance.postprocess import film_pictures

    with progress_of(options) as shown:
        meshes = film_ladder.convergence(_bearing(options), progress=shown)
    return publish(
        options,
        film_ladder.convergence_table(meshes),
        {"meshes": [dataclasses.asdict(m) for m in meshes]},
        film_ladder.save_convergence,
        film_pictures.convergence,
        meshes,
        "film_convergence",
    )


def _ladder(options) -> int:
    from clearance.paper_figures import film_ladder
    from clearance.postprocess import film_pictures

    with progress_of(options) as shown:
        study = film_ladder.ladder(options.turns, options.quick, shown)
    return publish(
        options,
        [*film_ladder.table(study), "", *film_ladder.describe(study)],
        film_ladder.plain(study),
        film_ladder.save,
        film_pictures.ladder,
        study,
        "film_ladder",
    )


OUTPUT = {"-o DIR": "folder for table, picture and data"}
BEARING = {
    "--radius RADIUS": ("m", "10mm", "journal radius"),
    "--clearance CLEARANCE": ("m", "0.1mm", "radial clearance"),
    "--length LENGTH": ("m", "20mm", "length of the bearing"),
    "--viscosity VISCOSITY": ("Pa s", "50cP", "dynamic viscosity"),
    "--cavitation NAME": ("reynolds", "reynolds, gumbel, none or mass_conserving"),
}
MESH = {"--mesh NxM": (_mesh, None, "cells around x over half the length")}
STATE = {
    "--eccentricity RATIO": ("1", "0.8", "eccentricity ratio"),
    "--rate RATE": ("1/s", "0", "rate of the eccentricity ratio"),
    "--entrainment W": ("rad/s", "300rpm", "omega_J + omega_B - 2 gamma'"),
    "--ambient PRESSURE": ("Pa", "0", "ambient above cavitation pressure, 0: the same"),
    "--roughness SIZE": ("m", "0", "composite roughness of the flow factors, 0: smooth"),
    "--groove ANGLE[,WIDTH[,LENGTH[,PRESSURE]]] ...": "oil supply: angle from the widest gap, "
    "width, axial share, pressure above ambient",
    "--solver SOLVER": ("auto", "auto, fast or fem"),
}
LOAD = {
    "--load LOAD": ("N", "20N", "steady load"),
    "--speed SPEED": ("rad/s", "3000rpm", "speed of the journal"),
}
MAP = {
    "--roughness SIZE": ("m", "0", "of the flow factors, 0: smooth"),
    "--nodes N": (33, "nodes over eccentricity and direction"),
}
SHOTS = {
    "file RUN.h5": "a result file",
    "--joint NAME": "joint (default the first with a film)",
    "--count N": (6, "moments over the last turn"),
}
LADDER = {
    "--turns TURNS": (1.0, "length of the feeder run in turns"),
    "--quick": "coarse meshes only",
}
#: studies by name: sentence, function, options
STUDIES = {
    "pressure": (
        "pressure, load, friction and flow of a bearing in one state",
        _pressure,
        BEARING,
        STATE,
        MESH,
    ),
    "coefficients": (
        "stiffness and damping of a bearing's film about a load",
        _coefficients,
        BEARING,
        LOAD,
    ),
    "map": ("what the force table of a bearing holds, and its error", _map, BEARING, MAP),
    "snapshots": ("pressure fields along a run, from its result file", _snapshots, SHOTS, MESH),
    "convergence": ("error of both solvers as their meshes are refined", _convergence, BEARING),
    "ladder": (
        "error against run time of all films, single states and a feeder run",
        _ladder,
        LADDER,
    ),
}
