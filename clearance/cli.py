"""The command line: one thin layer over the Python interface.

Exit status: 0 done, 1 the run failed part-way (what it had is kept), 2 the input was wrong.
"""

import argparse
import json
import logging
import os
import re
import sys
import time
from pathlib import Path

from clearance.commands import bench_data, figures, identify, inverse, lyapunov, plot, report, sweep
from clearance.commands.common import (
    DONE,
    FAILED,
    WRONG,
    Line,
    add_case,
    add_length,
    channel_patterns,
    complain,
    length_of,
    make_folder,
    number,
    peak,
    publish,
    quantity_of,
    scene_of,
)  # fmt: skip


class Parser(argparse.ArgumentParser):
    """Wrong arguments are one clear line (and a JSON document where one is asked for) and exit status 2."""

    def error(self, message: str):
        if "--json" in sys.argv:
            print(json.dumps({"status": "wrong input", "message": message}))
        self.exit(WRONG, f"clearance: {message}\n")


def parser() -> Parser:
    top = Parser(
        prog="clearance", description="Tribodynamics of planar mechanisms with clearance, lubricant, friction."
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    cases = commands.add_parser("cases", help="list cases with their parameters, units and defaults")
    run = commands.add_parser("run", help="run a case and write an HDF5 result file")
    explain = commands.add_parser("explain", help="what the compiled scene contains and what was left out")
    study = commands.add_parser("work-precision", help="error against run time: all methods, with --peers others' too")
    stress = commands.add_parser("stress", help="the stiff and extreme matrix: each cell done or a named reason")
    for command in (run, explain, study):
        add_case(command)
    for command in (run, study):
        add_length(command)
    study.add_argument("--peers", action="store_true", help="also numbalsoda, SUNDIALS, Exudyn where installed")
    study.add_argument("--physics", action="store_true", help="compare choices of physics instead of solvers")
    stress.add_argument("case", metavar="CASE", nargs="?", help="only this case (or: random)")
    stress.add_argument("--quick", action="store_true", help="a seventh of the matrix, short runs")
    stress.add_argument("--workers", type=int, metavar="N", help="processes (default: one a core)")
    for command in (study, stress):
        command.add_argument("-o", dest="output", metavar="DIR", help="folder for table, picture and HDF5")
    run.add_argument("--rtol", type=number, default=1e-6, metavar="R", help="local error tolerance (default 1e-6)")
    run.add_argument("--method", default="auto", help="auto, dop853, rodas5p, radau5, radau9 or radau (default auto)")
    run.add_argument("--max-step", type=quantity_of("s"), metavar="S", help="longest step, where loads act briefly")
    run.add_argument(
        "--samples-per-turn", type=number, default=400, metavar="N", help="output rows a turn (default 400)"
    )
    run.add_argument(
        "--channels", metavar="PATHS", help='kept in the file: comma list such as "bodies/slider,joints/B/gap" (all)'
    )
    run.add_argument("--compression", type=int, default=0, metavar="0..9", help="gzip level of the file (default 0)")
    run.add_argument(
        "--checkpoint", type=quantity_of("s"), metavar="S",
        help="keep a checkpoint every so many seconds of wall time: the same command goes on from it after a crash",
    )  # fmt: skip
    run.add_argument("-o", dest="output", metavar="FILE.h5", help="result file (default CASE.h5)")
    run.add_argument("--plot", action="store_true", help="draw a picture beside the result file")
    explain.add_argument("--cost", action="store_true", help="also measure what each part of such a scene costs")
    own = (module.add(commands) for module in (inverse, sweep, plot, report, lyapunov, bench_data, identify, figures))
    for command in (cases, run, explain, study, stress, *own, *_film_commands(commands)):
        command.add_argument("--json", action="store_true", help="one JSON document on stdout, nothing else")
    return top


def _film_commands(commands) -> list:
    """`clearance film WHAT`: the Reynolds equation on its own."""
    film = commands.add_parser("film", help="oil films: pressure fields, force maps, snapshots, mesh and error studies")
    whats = film.add_subparsers(dest="what", required=True, metavar="WHAT")
    pressure = whats.add_parser("pressure", help="pressure, load, friction and flow of a bearing in one state")
    map_ = whats.add_parser("map", help="what the force table of a bearing holds, and its error")
    shots = whats.add_parser("snapshots", help="pressure fields along a run, from its result file")
    meshes = whats.add_parser("convergence", help="error of both solvers as their meshes are refined")
    ladder = whats.add_parser("ladder", help="error against run time of all films, single states and a feeder run")
    for command in (pressure, map_, meshes):
        for name, default, text in _BEARING:
            command.add_argument(f"--{name}", type=quantity_of(text[1]), default=default, help=f"{text[0]} ({default})")
        command.add_argument("--cavitation", default="reynolds", help="reynolds, gumbel, none or mass_conserving")
    for name, default, text in _STATE:
        pressure.add_argument(f"--{name}", type=quantity_of(text[1]), default=default, help=f"{text[0]} ({default})")
    pressure.add_argument(
        "--groove", action="append", default=[], metavar="ANGLE[,WIDTH[,LENGTH[,PRESSURE]]]",
        help="oil supply: angle from the widest gap, width, axial share, pressure above ambient; may be repeated",
    )  # fmt: skip
    pressure.add_argument("--solver", default="auto", help="auto, fast or fem")
    for command in (pressure, shots):
        command.add_argument("--mesh", type=_mesh, metavar="NxM", help="cells around x over half the length")
    map_.add_argument("--roughness", type=quantity_of("m"), default="0", help="of the flow factors, 0: smooth (0)")
    map_.add_argument("--nodes", type=int, default=33, help="nodes over eccentricity and direction (33)")
    shots.add_argument("file", metavar="RUN.h5", help="a result file")
    shots.add_argument("--joint", help="joint (default the first with a film)")
    shots.add_argument("--count", type=int, default=6, metavar="N", help="moments over the last turn (6)")
    ladder.add_argument("--turns", type=number, default=1.0, help="length of the feeder run in turns (1)")
    ladder.add_argument("--quick", action="store_true", help="coarse meshes only")
    every = [pressure, map_, shots, meshes, ladder]
    for command in every:
        command.add_argument("-o", dest="output", metavar="DIR", help="folder for table, picture and data")
    return every


#: options of `clearance film`: name, default, (meaning, unit)
_BEARING = (
    ("radius", "10mm", ("journal radius", "m")), ("clearance", "0.1mm", ("radial clearance", "m")),
    ("length", "20mm", ("length of the bearing", "m")), ("viscosity", "50cP", ("dynamic viscosity", "Pa s")),
)  # fmt: skip
_STATE = (
    ("eccentricity", "0.8", ("eccentricity ratio", "1")), ("rate", "0", ("rate of the eccentricity ratio", "1/s")),
    ("entrainment", "300rpm", ("omega_J + omega_B - 2 gamma'", "rad/s")),
    ("ambient", "0", ("ambient above cavitation pressure, 0: the same", "Pa")),
    ("roughness", "0", ("composite roughness of the flow factors, 0: smooth", "m")),
)  # fmt: skip


def _mesh(text: str) -> tuple[int, int]:
    if not (found := re.fullmatch(r"(\d+)x(\d+)", text)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a mesh such as 64x8")
    return int(found[1]), int(found[2])


def main(arguments: list[str] | None = None) -> int:
    """Entry point: returns the exit status."""
    options = parser().parse_args(_joined(sys.argv[1:] if arguments is None else arguments))
    action = {
        "cases": list_cases, "run": run_case, "explain": explain_case, "work-precision": measure_case,
        "stress": stress_cases, "film": study_film, "sweep": sweep.run, "plot": plot.run,
        "lyapunov": lyapunov.run, "report": report.run, "inverse": inverse.run,
        "bench-data": bench_data.run, "identify": identify.run, "figures": figures.run,
    }[options.command]  # fmt: skip
    try:
        return action(options)
    except BrokenPipeError:  # the reader of our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except (ValueError, TypeError, OSError, ImportError) as error:
        return complain(options, str(error), WRONG)
    except KeyboardInterrupt:
        return complain(options, "interrupted; the result file holds what was computed", FAILED)


def _joined(arguments: list[str]) -> list[str]:
    """`--rtol -1e-6` as `--rtol=-1e-6`: argparse takes only plain negative numbers for values."""
    found: list[str] = []
    for argument in arguments:
        if re.match(r"-\.?\d", argument) and found and re.fullmatch(r"--[a-z-]+", found[-1]):
            found[-1] += f"={argument}"
        else:
            found.append(argument)
    return found


def list_cases(options) -> int:
    from clearance.catalogue import case_names, find_case

    cases = [find_case(name) for name in case_names()]
    if options.json:
        rows = {
            c.name: {
                "summary": c.summary,
                "parameters": {
                    p.name: {"default": p.default, "units": p.units, "text": p.text} for p in c.parameters.values()
                },
            }
            for c in cases
        }
        print(json.dumps(rows, indent=1))
        return DONE
    for case in cases:
        print(f"{case.name}: {case.summary}")
        for p in case.parameters.values():
            default = f"{p.default:g}" if isinstance(p.default, float) else str(p.default)
            print(f"    {p.name:<20} {default:>18} {p.units:<9} {p.text}")
        print()
    return DONE


def run_case(options) -> int:
    from clearance.evidence.statistics import over_turns
    from clearance.simulation import SimulationError, simulate

    case, values, scene = scene_of(options)
    output = Path(options.output or f"{case.name}.h5")
    if options.plot and output.suffix == ".png":
        raise ValueError(f"-o {output}: the result would be overwritten by the picture; name the result file .h5")
    watched = not options.json and sys.stderr.isatty()
    bar = ProgressBar() if watched else None
    if watched:
        logging.basicConfig(level=logging.INFO, format="%(message)s")
    began = time.perf_counter(), time.process_time()
    failure = None
    try:
        result = simulate(
            scene, **length_of(options, scene), rtol=options.rtol, method=options.method,
            max_step=options.max_step, samples_per_turn=options.samples_per_turn, path=output, progress=bar,
            channels=channel_patterns(options.channels), compression=options.compression,
            checkpoint=options.checkpoint,
        )  # fmt: skip
    except SimulationError as error:
        failure, result = str(error), error.result
    finally:
        if bar is not None:
            bar.close()
    summary = _summary(case, values, result, began)
    horizon = _horizon(scene, result, options.rtol) if failure is None else None
    if horizon is not None:
        summary["horizon"], chaotic = horizon
        if chaotic and (means := over_turns(result, scene.turn)):
            summary["statistics"] = {n: {"mean": m.value, "standard_error": m.error} for n, m in means.items()}
            summary["statistics_turns"] = next(iter(means.values())).turns
    if options.plot:
        summary["plot"] = str(_plot(result, output))
    if failure is not None:
        summary.pop("status")
        return complain(options, failure, FAILED, **summary)
    print(json.dumps(summary) if options.json else _readable(summary))
    return DONE


def _horizon(scene, result, rtol: float) -> tuple[str, bool] | None:
    """How far a run with impacts can be compared with another, and whether it ends there; None without impacts."""
    from clearance.evidence.problem import NotSolved, horizon

    if not any(j.impacts for j in scene.clearance_joints) or not result.file["time"].size:
        return None
    until = float(result.file["time"][-1])
    try:
        found = horizon(scene, until, rtol, str(result.solver["method"]).rpartition(", ")[2])
    except NotSolved as reason:
        return f"not found: {reason}", True
    return found.sentence(scene.turn), found.time is not None


class ProgressBar:
    """A progress bar on stderr."""

    def __init__(self):
        from tqdm import tqdm

        self.bar = tqdm(total=100, unit="%", bar_format="{l_bar}{bar}| {elapsed} passed, {remaining} left")

    def __call__(self, share: float) -> None:
        self.bar.update(100.0 * share - self.bar.n)

    def close(self) -> None:
        self.bar.close()


def _plot(result, output: Path) -> Path:
    from clearance.postprocess.plots import overview

    return overview(result, output.with_suffix(".png"))


def _summary(case, values: dict, result, began: tuple[float, float]) -> dict:
    """What a run cost and gave, as plain data."""
    solver, events = result.solver, result.events
    contacts: dict[str, int] = {}
    for joint in events["joint"]:
        contacts[str(joint)] = contacts.get(str(joint), 0) + 1
    return {
        "status": result.status,
        "case": case.name,
        "parameters": values,
        "file": str(result.path),
        "simulated_s": float(result.file["time"][-1]) if result.file["time"].size else 0.0,
        "samples": int(result.file["time"].size),
        "method": solver["method"],
        "method_reason": solver["method_reason"],
        "rtol": float(solver["rtol"]),
        "steps": int(solver["steps"]),
        "rejected": int(solver["rejected"]),
        "evaluations": int(solver["evaluations"]),
        "jacobians": int(solver["jacobians"]),
        "integration_s": float(solver["wall_s"]),
        "wall_s": time.perf_counter() - began[0],
        "cpu_s": time.process_time() - began[1],
        "energy_residual": float(result.facts("energy").get("largest_residual", 0.0)),
        "energy_turned_over": float(result.facts("energy").get("turned_over", 0.0)),
        "contacts": contacts,
        "open_contacts": sum(str(k) == "open_contact" for k in events["kind"]),
        "joints": _joint_extremes(result),
        "drives": _drive_extremes(result),
        "warnings": result.warnings,
    }


SHARES = {"share_full_film": "full film", "share_mixed": "mixed", "share_dry": "dry"}
JOINT_FACTS = (
    "peak_force", "smallest_gap", "film_pressure", "piezoviscous_number", "flattening_ratio", "mean_asperity_share",
    "film_table_error_closing", *SHARES,
)  # fmt: skip


def _joint_extremes(result) -> dict:
    """Peak forces and smallest gaps, of samples and contacts; nothing for a run that ended before its first sample."""
    found = {}
    for name in result.names("joints"):
        joint, facts = result.joint(name), result.facts(f"joints/{name}")
        found[name] = {n: float(facts[n]) for n in JOINT_FACTS if n in facts}
        if result.time.size and "film_thickness_ratio" in joint and "film_radial" in joint:
            found[name]["smallest_film_thickness_ratio"] = result.range(f"joints/{name}/film_thickness_ratio")[0]
        if result.time.size and f"joints/{name}/friction" in result and "gap" not in joint:
            found[name]["peak_friction"] = peak(result, f"joints/{name}/friction")
            found[name]["friction_units"] = result.units(f"joints/{name}/friction")
    return found


def _drive_extremes(result) -> dict:
    """Largest efforts of the drives, and of what they were without joint friction."""
    found = {}
    for name in result.names("drives") if result.time.size else ():
        kinds = [k for k in ("torque", "force") if f"drives/{name}/{k}" in result]
        for kind in kinds:
            path = f"drives/{name}/{kind}"
            found[name] = {"units": result.units(path), "peak": peak(result, path)}
            if f"{path}_ideal" in result:
                found[name]["peak_ideal"] = peak(result, f"{path}_ideal")
    return found


def _readable(summary: dict) -> str:
    s = summary
    lines = [
        f"{s['case']}: {s['simulated_s']:.6g} s simulated in {s['integration_s']:.3g} s "
        f"({s['wall_s']:.3g} s in all), {s['status']}",
        f"  method       {s['method']} ({s['method_reason']}), rtol {s['rtol']:g}",
        f"  steps        {s['steps']} ({s['rejected']} rejected), {s['evaluations']} evaluations, "
        f"{s['jacobians']} jacobians",
        f"  energy       residual {s['energy_residual']:.3g} J of {s['energy_turned_over']:.3g} J turned over",
    ]
    for name, joint in s["joints"].items():
        line = f"  joint {name:<6} peak force {joint.get('peak_force', 0.0):.6g} N"
        if "smallest_gap" in joint:
            line += f", smallest gap {joint['smallest_gap'] * 1e6:.4g} um"
        if "smallest_film_thickness_ratio" in joint:
            line += f", film thickness ratio down to {joint['smallest_film_thickness_ratio']:.3g}"
        if "share_full_film" in joint:
            shares = (f"{text} {joint[n]:.0%}" for n, text in SHARES.items() if joint[n] >= 0.005)
            line += f", {', '.join(shares)}, {joint['mean_asperity_share']:.0%} of the load on the solids"
        if "film_table_error_closing" in joint:
            line += f", film table within {joint['film_table_error_closing']:.1e}"
        if "peak_friction" in joint:
            line += f", friction up to {joint['peak_friction']:.4g} {joint['friction_units']}"
        if name in s["contacts"]:
            line += f", {s['contacts'][name]} contacts"
        lines.append(line)
    for name, drive in s["drives"].items():
        ideal = f", {drive['peak_ideal']:.6g} without joint friction" if "peak_ideal" in drive else ""
        lines.append(f"  drive {name:<6} peak effort {drive['peak']:.6g} {drive['units']}{ideal}")
    if s["contacts"]:
        still = f" ({s['open_contacts']} not over at the end)" if s["open_contacts"] else ""
        lines.append(f"  events       {sum(s['contacts'].values())} contacts{still}")
    if "horizon" in s:
        lines.append(f"  horizon      {s['horizon']}")
    if "statistics" in s:
        lines.append(f"  statistics   mean and standard error over {s['statistics_turns']} turns, the first left out")
        lines += [f"    {n:<32} {m['mean']:.5g} +- {m['standard_error']:.2g}" for n, m in s["statistics"].items()]
    lines += [f"  warning      {w}" for w in s["warnings"]]
    lines += [f"  file         {s['file']}"] + ([f"  picture      {s['plot']}"] if "plot" in s else [])
    return "\n".join(lines)


def explain_case(options) -> int:
    from clearance.evidence import ablation
    from clearance.evidence.explain import explain

    case, values, scene = scene_of(options)
    parts = ablation.ablation(scene, options.cost, Line(options))
    found = {"parameters_given": values, **explain(scene), "cost": ablation.plain(parts)}
    if options.json:
        print(json.dumps(found))
        return DONE
    print(f"{case.name}: {len(found['bodies'])} bodies, {len(found['states'])} states")
    for name in found["states"]:
        print(f"  state      {name}")
    for name, joint in found["joints"].items():
        laws = ", ".join(f"{k} {v}" for k, v in joint.items() if k not in ("kind", "reality"))
        print(f"  joint {name:<4} {joint['reality']} {joint['kind']}{': ' + laws if laws else ''}")
    for group in found["plan"]:
        print(f"  position   {group['bodies']} {group['solved']}")
    for role, k in found["kernels"].items():
        calls = f", calls {', '.join(k['calls'])}" if k["calls"] else ""
        print(
            f"  kernel     {role}: {k['operations']} operations{calls}{'' if k['in_store'] else ' (not compiled yet)'}"
        )
    print(f"  numbers    {found['parameters']} parameters, {found['derived_parameters']} derived from them")
    print(f"  outputs    {len(found['channels'])} channels")
    print(f"  modules    {', '.join(found['modules'])}")
    print(f"  left out   {', '.join(found['left_out'])}")
    print(f"  store      {found['store']}")
    for warning in found["warnings"]:
        print(f"  warning    {warning}")
    print("\n" + "\n".join(ablation.table(parts)))
    return DONE


def measure_case(options) -> int:
    """Error against run time of solvers, or with --physics the price of choices of physics."""
    from clearance.evidence import physics, pictures, work_precision

    if options.physics and options.peers:
        raise ValueError("--physics compares choices of physics, not solvers: leave out --peers")
    case, values, scene = scene_of(options)
    make_folder(options)
    title = " ".join([case.name, *(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in values.items())])
    module = physics if options.physics else work_precision
    if options.physics:
        study = physics.compare(case, values, options.turns, options.until, progress=Line(options))
        draw, stem = pictures.physics, "physics"
    else:
        study = work_precision.work_precision(
            title, scene, turns=options.turns, until=options.until, peers=options.peers, progress=Line(options)
        )
        draw, stem = pictures.work_precision, "work_precision"
    lines = [*module.table(study), "", *module.describe(study)]
    return publish(options, lines, module.plain(study), lambda folder: module.save(study, folder), draw, study, stem)


def stress_cases(options) -> int:
    """The stress matrix; exit status 1 if a cell crashed, hung or gave a number that is not finite."""
    import dataclasses

    from clearance.evidence import pictures, stress

    if options.workers is not None and options.workers < 1:
        raise ValueError(f"--workers must be at least 1, got {options.workers}")
    make_folder(options)
    line = Line(options)
    verdicts = stress.stress(
        options.case, quick=options.quick, workers=options.workers,
        progress=lambda done, total, name: line(f"{done}/{total} {name}"),
    )  # fmt: skip
    document = {"cells": [dataclasses.asdict(v) for v in verdicts]}
    lines = stress.table(verdicts)
    publish(options, lines, document, lambda folder: stress.save(verdicts, folder), pictures.stress, verdicts, "stress")
    return FAILED if any(v.kind == "fault" for v in verdicts) else DONE


def study_film(options) -> int:
    """The Reynolds equation on its own: see `clearance film --help`."""
    make_folder(options)
    return {
        "pressure": _film_pressure, "map": _film_map, "snapshots": _film_snapshots, "convergence": _film_convergence,
        "ladder": _film_ladder,
    }[options.what](options)  # fmt: skip


def _bearing(options, **more):
    from clearance.film.bearing import Bearing

    return Bearing(
        options.radius, options.clearance, options.length, options.viscosity, options.cavitation, **more
    )  # fmt: skip


def _groove(text: str):
    from clearance.film.bearing import Groove
    from clearance.units import quantity

    parts, units = text.split(","), ("rad", "rad", "1", "Pa")
    if len(parts) > len(units):
        raise ValueError(f"--groove {text}: expected ANGLE[,WIDTH[,LENGTH[,PRESSURE]]]")
    try:
        return Groove(*(quantity(t, u) for t, u in zip(parts, units, strict=False)))
    except ValueError as error:
        raise ValueError(f"--groove {text}: {error}") from None


def _film_pressure(options) -> int:
    from clearance.evidence import film_pictures, films
    from clearance.film.solvers import solve_film

    bearing = _bearing(
        options, ambient=options.ambient or None, grooves=tuple(map(_groove, options.groove)),
        roughness=options.roughness,
    )  # fmt: skip
    state = options.eccentricity, options.rate, options.entrainment
    found = solve_film(bearing, *state, solver=options.solver, mesh=options.mesh)
    title = f"L/D {bearing.slenderness:.3g}, eps {state[0]:g}, d(eps)/dt {state[1]:g} 1/s, w {state[2]:.4g} rad/s"
    title += f", {options.cavitation}" + (f", ambient {options.ambient / 1e3:g} kPa" if options.ambient else "")
    title += f", {len(options.groove)} groove(s)" if options.groove else ""
    return publish(
        options, films.report(found), films.plain(found), lambda folder: films.save(found, folder),
        lambda solution, path: film_pictures.pressure(solution, title, path), found, "film_pressure",
    )  # fmt: skip


def _film_map(options) -> int:
    from clearance.evidence import film_pictures, films

    bearing = _bearing(options, roughness=options.roughness)
    found, table = films.force_map(bearing, options.nodes)
    title = f"film table of L/D {bearing.slenderness:.3g}, {options.cavitation}, {options.nodes} nodes each way"
    return publish(
        options, films.map_report(table, title), table.facts(), lambda folder: films.save_map(found, table, folder),
        lambda shown, path: film_pictures.force_map(shown, title, path), found, "film_map",
    )  # fmt: skip


def _film_snapshots(options) -> int:
    from clearance.evidence import film_pictures, films
    from clearance.results import open_result

    result = open_result(options.file)
    shots = films.snapshots(result, options.joint, options.count, options.mesh)
    case, joint = result.attributes["case"], films.joint_with_film(result, options.joint)
    return publish(
        options, films.shots_report(shots), {"snapshots": [films.shot_plain(s) for s in shots]},
        lambda folder: films.save_shots(shots, folder),
        lambda shown, path: film_pictures.snapshots(shown, joint, case, path), shots, "film_snapshots",
    )  # fmt: skip


def _film_convergence(options) -> int:
    import dataclasses

    from clearance.evidence import film_ladder, film_pictures

    meshes = film_ladder.convergence(_bearing(options), progress=Line(options))
    return publish(
        options, film_ladder.convergence_table(meshes), {"meshes": [dataclasses.asdict(m) for m in meshes]},
        lambda folder: film_ladder.save_convergence(meshes, folder), film_pictures.convergence, meshes,
        "film_convergence",
    )  # fmt: skip


def _film_ladder(options) -> int:
    from clearance.evidence import film_ladder, film_pictures

    study = film_ladder.ladder(options.turns, options.quick, Line(options))
    return publish(
        options, [*film_ladder.table(study), "", *film_ladder.describe(study)], film_ladder.plain(study),
        lambda folder: film_ladder.save(study, folder), film_pictures.ladder, study, "film_ladder",
    )  # fmt: skip


def entry() -> None:
    """The console script."""
    sys.exit(main())


if __name__ == "__main__":
    entry()
