"""`clearance wear`: the life of a mechanism whose joints wear, over many turns."""

import argparse
import time
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    Line,
    add_accept,
    add_case,
    add_command,
    complain,
    json_text,
    number,
    quantity_of,
    quiet,
    scene_of,
    taken,
)
from clearance.run.interrupts import terminable

EXAMPLES = """\
  clearance wear wear_a --turns 21400 -o worn --plot
  clearance wear slider_crank -p model=dry -p wear=1e-6mm3/Nm -p speed=1000rpm --turns 1e6 \\
    --average 20 -o worn
  clearance wear mine.py -p wear=5e-4mm3/Nm --turns 20000 -o worn      # a case file of your own

  clearance wear wear_a -p clearance=0.05mm:0.2mm:4 -p wear=2e-4mm3/Nm,5e-4mm3/Nm \\
    --turns 21400 -o map  # 8 lives

Values as LO:HI:N or comma lists make a sweep of lives on all cores. Each has a directory in
DIR/lives. Stop it when you like: the same command goes on from the last stage; with more --turns
a life goes on beyond its end.
"""


NAMES = "turns share tolerance settle average jump jump_turns rtol method"
OF_MANY = "workers scheduler retry_failed"
#: columns of a sweep that its summary begins with
LIFE = ("_depth", "_volume", "_to_depth", "life_error")


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "wear", epilog=EXAMPLES)
    add_case(p)
    p.add_argument(
        "--turns", type=number, required=True, help="turns of the drive in the complete life"
    )
    p.add_argument(
        "-o",
        dest="output",
        metavar="DIR",
        required=True,
        help="directory of the life; one that is there goes on",
    )
    p.add_argument(
        "--share",
        type=number,
        default=0.25,
        help="growth of a depth in a jump, over the clearance (default 0.25)",
    )
    p.add_argument(
        "--tolerance",
        type=number,
        default=0.05,
        help="change of the wear of a turn over a jump (default 0.05)",
    )
    p.add_argument(
        "--settle", type=int, default=2, metavar="N", help="turns of a stage left out (default 2)"
    )
    p.add_argument(
        "--average",
        type=int,
        default=2,
        metavar="N",
        help="turns of a stage that are measured; more, up to 50, where they scatter (default 2)",
    )
    p.add_argument(
        "--jump",
        default="replay",
        help="replay (implicit, default) or linear (wear of a turn times turns)",
    )
    p.add_argument(
        "--jump-turns",
        type=number,
        metavar="N",
        help="longest jump (default by share and tolerance)",
    )
    p.add_argument(
        "--rtol",
        type=number,
        default=1e-4,
        metavar="R",
        help="tolerance of the runs (default 1e-4)",
    )
    p.add_argument(
        "--method", default="auto", metavar="M", help="stepper of the runs (default auto)"
    )
    p.add_argument("--plot", action="store_true", help="draw DIR/life.png; of a sweep its curves")
    p.add_argument(
        "--depth",
        type=quantity_of("m"),
        metavar="D",
        help="of a sweep: a column of the turns to this depth (default one clearance)",
    )
    p.add_argument("--workers", type=int, metavar="N", help="of a sweep: processes (one a core)")
    p.add_argument("--scheduler", metavar="ADDRESS", help="of a sweep: a Dask scheduler")
    p.add_argument("--retry-failed", action="store_true", help="of a sweep: also what failed")
    add_accept(p)
    return p


def run(options) -> int:
    """The life, its table; exit status 1 where a stage fails or a wall is worn through."""
    from clearance.simulation import SimulationError
    from clearance.wearing.life import wear

    points, fixed = points_of(options)
    if points.columns:
        return _many(options, points, fixed)
    if given := [n for n, v in taken(options, f"depth {OF_MANY}").items() if v]:
        name = given[0].replace("_", "-")
        raise ValueError(f"--{name} belongs to sweeps of lives: a -p with several values")
    case, values, scene = scene_of(options)
    line = Line(options)

    def progress(done: float, stage: str) -> None:
        line(f"{100.0 * done:.1f} % of the turns, {stage}")

    chosen = taken(options, f"{NAMES} accept_changes")
    try:
        with terminable():
            life = wear(scene, **chosen, directory=options.output, progress=progress)
    except (SimulationError, RuntimeError) as error:
        return complain(
            options, f"{error}; stages before it are stored in {options.output}", FAILED
        )
    except KeyboardInterrupt as request:
        request.add_note("stages before it are stored; the same command goes on from the last one")
        raise
    finally:
        line.clear()
    picture = None
    if options.plot:
        from clearance.postprocess.lives import life as draw

        picture = str(draw(life, Path(options.output) / "life.png"))
    table = life.table()
    document = {
        "case": case.name,
        "parameters": values,
        "status": "complete" if life.done else "partial",
        "directory": options.output,
        "picture": picture,
        "stages": table,
        "metrics": life.stages[-1]["metrics"],
    }
    print(
        json_text(document)
        if options.json
        else "\n".join(_readable(case.name, life, table, picture))
    )
    return DONE


def points_of(options):
    """Points and fixed parameters of -p NAME=VALUES, a grid."""
    from clearance.commands.sweep import grid_of
    from clearance.scene.catalogue import find_case

    with quiet(options):
        return grid_of(options, find_case(options.case))


def _many(options, points, fixed) -> int:
    """The lives of several points; exit status 1 where one fails."""
    from clearance.commands import sweep as command
    from clearance.sweeping.sweep import SweepError, sweep

    began, options.quiet = time.perf_counter(), options.json
    shown, failure = command.Progress(options), None
    life = taken(options, f"{NAMES} depth")
    try:
        with quiet(options), terminable():
            result = sweep(
                options.case,
                points,
                options.output,
                fixed=fixed,
                progress=shown,
                life={n: v for n, v in life.items() if v is not None},
                **taken(options, f"{OF_MANY} accept_changes"),
            )
    except SweepError as error:
        failure, result = str(error), error.sweep
    except KeyboardInterrupt:
        return complain(options, "interrupted; the same command goes on where this stopped", FAILED)
    finally:
        shown.close()
    if options.plot and result.done.any():
        from clearance.postprocess import maps

        names = [n for n in result.metrics if n.endswith(("_depth", "_volume", "_to_depth"))]
        maps.curves(result, Path(options.output) / "curves.png", metrics=names)
    passed = {"seconds": time.perf_counter() - began, "done_before": shown.before}
    document = command.summary(result) | passed
    if failure is not None:
        return complain(options, failure, FAILED)
    words = "\n".join(command.readable(document, first=LIFE))
    print(json_text(document) if options.json else words)
    return DONE if result.done.all() else FAILED


def _readable(name: str, life, table: list[dict], picture: str | None) -> list[str]:
    last = table[-1]
    lines = [f"{name}: {last['turns']:g} turns in {len(table)} stages, {life.path}"]
    for joint in life.joints:
        for surface in life.asked["joints"][joint]["wears"]:
            depth, angle, volume = (
                last[f"{joint}_{surface}_{n}"] for n in ("depth", "angle_deg", "volume")
            )
            lines.append(
                f"  {joint} {surface:<8} {1e6 * depth:.6g} um deep at {angle:.0f} deg "
                f"(jumps: within {1e6 * last['error']:.2g} um), {1e9 * volume:.6g} mm3"
            )
        if life.stands_still(joint):
            form = 1e6 * life.closed_form(joint)[-1]
            lines.append(
                f"  {joint} bearing  {form:.6g} um for rigid bodies under the first load path alone"
            )
    return lines + ([f"  picture      {picture}"] if picture else [])
