"""`clearance wear`: the life of a mechanism whose joints wear, over many turns."""

import argparse
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    Line,
    add_case,
    add_command,
    complain,
    json_text,
    number,
    scene_of,
)
from clearance.interrupts import terminable

EXAMPLES = """\
  clearance wear wear_a --turns 21400 -o worn --plot
  clearance wear slider_crank -p model=dry -p wear=1e-6mm3/Nm -p speed=1000rpm --turns 1e6 --average 20 -o worn
  clearance wear mine.py -p wear=5e-4mm3/Nm --turns 20000 -o worn      # a case file of your own

Stop it when you like: the same command goes on from the last stage; with more --turns a life goes on beyond its end.
"""


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(
        commands,
        "wear",
        help="life of a mechanism whose joints wear: stages of turns, and jumps between them",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_case(p)
    p.add_argument(
        "--turns", type=number, required=True, help="turns of the drive in the whole life"
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
        default=0.1,
        help="growth of a depth in a jump, over the clearance (default 0.1)",
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
        default=1e-6,
        metavar="R",
        help="tolerance of the runs (default 1e-6)",
    )
    p.add_argument("--plot", action="store_true", help="draw DIR/life.png")
    return p


def run(options) -> int:
    """The life, its table; exit status 1 where a stage fails or a wall is worn through."""
    from clearance.simulation import SimulationError
    from clearance.wearing.life import wear

    case, values, scene = scene_of(options)
    line = Line(options)

    def progress(done: float) -> None:
        line(f"{100.0 * done:.1f} % of the turns")

    names = ("turns", "share", "tolerance", "settle", "average", "jump", "jump_turns", "rtol")
    chosen = {name: getattr(options, name) for name in names}
    try:
        with terminable():
            life = wear(scene, **chosen, directory=options.output, progress=progress)
    except (SimulationError, RuntimeError) as error:
        return complain(options, f"{error}; stages before it are kept in {options.output}", FAILED)
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
        if "bearing" in life.asked["joints"][joint]["wears"] and len(life.load_path(joint)):
            form = 1e6 * life.closed_form(joint)[-1]
            lines.append(
                f"  {joint} bearing  {form:.6g} um for rigid bodies under the first load path alone"
            )
    return lines + ([f"  picture      {picture}"] if picture else [])
