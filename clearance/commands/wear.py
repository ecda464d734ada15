"""`clearance wear`: the life of a mechanism whose joints wear, over many turns."""

from pathlib import Path

from clearance.commands.common import (
    ACCEPT,
    case_of,
    case_options,
    noted,
    number,
    progress_of,
    scene_of,
    show,
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


OPTIONS = (
    case_options()
    | {
        "--turns TURNS !": (number, None, "turns of the drive in the complete life"),
        "-o DIR !": "directory of the life; one that is there goes on",
    }
    | ACCEPT
    | {
        "--share X": (0.25, "growth of a depth in a jump, over the clearance"),
        "--tolerance X": (0.05, "change of the wear of a turn over a jump"),
        "--settle N": (2, "turns of a stage left out"),
        "--average N": (2, "measured turns of a stage; more, up to 50, where they scatter"),
        "--jump JUMP": ("replay", "replay (implicit) or linear (wear of a turn times turns)"),
        "--jump-turns N": (number, None, "longest jump (default by share and tolerance)"),
        "--rtol R": (1e-4, "tolerance of the runs"),
        "--method M": ("auto", "stepper of the runs"),
        "--plot": "draw DIR/life.png; of a sweep its curves",
        "--depth D": (
            "m",
            None,
            "of a sweep: a column of the turns to this depth (default one clearance)",
        ),
        "--workers N": (int, None, "of a sweep: processes (one a core)"),
        "--scheduler ADDRESS": "of a sweep: a Dask scheduler",
        "--retry-failed": "of a sweep: also what failed",
    }
)


def run(options) -> int:
    """The life, its table; exit status 1 where a stage fails or a wall is worn through."""
    from clearance.wearing.life import wear

    points, fixed = points_of(options)
    if points.columns:
        return _many(options, points, fixed)
    if misused := [n for n, v in taken(options, f"depth {OF_MANY}").items() if v]:
        name = misused[0].replace("_", "-")
        raise ValueError(f"--{name} belongs to sweeps of lives: a -p with several values")
    case, values, scene = scene_of(options)
    chosen = taken(options, f"{NAMES} accept_changes")
    note = "stages before it are stored; the same command goes on from the last one"
    try:
        with progress_of(options) as shown, terminable(), noted(note):
            life = wear(scene, **chosen, directory=options.output, progress=shown)
    except RuntimeError as error:
        raise RuntimeError(f"{error}; stages before it are stored in {options.output}") from error
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
    return show(options, document, _readable(case.name, life, table, picture))


def points_of(options):
    """Points and fixed parameters of -p NAME=VALUES, a grid."""
    from clearance.commands.sweep import grid_of

    return grid_of(options, case_of(options))


def _many(options, points, fixed) -> int:
    """The lives of several points."""
    from clearance.commands.sweep import completed
    from clearance.postprocess.maps import curves
    from clearance.sweeping.sweep import sweep

    options.quiet, options.until = False, None
    life = taken(options, f"{NAMES} depth")

    def swept(shown):
        return sweep(
            options.case,
            points,
            options.output,
            fixed=fixed,
            progress=shown,
            life={n: v for n, v in life.items() if v is not None},
            **taken(options, f"{OF_MANY} accept_changes"),
        )

    def drawn(result):
        names = [n for n in result.metrics if n.endswith(LIFE[:3])]
        return curves(result, Path(options.output) / "curves.png", metrics=names)

    return completed(options, swept, drawn, LIFE)


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
