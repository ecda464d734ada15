"""`clearance lyapunov`: the largest Lyapunov exponent of a case."""

import argparse
import textwrap

from clearance.commands.common import (
    FAILED,
    Line,
    add_case,
    add_command,
    complain,
    make_folder,
    publish,
    quantity_of,
    scene_of,
)


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "lyapunov")
    add_case(p)
    p.add_argument(
        "--turns",
        type=int,
        default=200,
        metavar="N",
        help="turns of the drive that it is averaged over (200)",
    )
    p.add_argument(
        "--settle", type=int, default=20, metavar="N", help="turns before them, left out (20)"
    )
    p.add_argument(
        "--interval",
        type=quantity_of("s"),
        metavar="S",
        help="takes the place of a turn where nothing turns steadily",
    )
    p.add_argument("-o", dest="output", metavar="DIR", help="folder for table, picture and HDF5")
    return p


def run(options) -> int:
    """Find the exponent and show it; exit status 1 where the motion cannot be continued."""
    from clearance.accuracy.horizon import NotSolved
    from clearance.motions import lyapunov
    from clearance.postprocess import study_pictures

    case, _, scene = scene_of(options)
    make_folder(options)
    line = Line(options)
    try:
        exponent = lyapunov.lyapunov(
            scene,
            options.turns,
            options.settle,
            interval=options.interval,
            progress=lambda share: line(f"{share:.0%} of the turns"),
        )
    except NotSolved as error:
        return complain(options, str(error), FAILED)
    name = " ".join([case.name, *options.parameters])
    exponents, wrapped = (
        {name: exponent},
        {textwrap.fill(name, 80): exponent},
    )  # the picture has no room for longer lines
    return publish(
        options,
        lyapunov.table(exponents),
        lyapunov.plain(exponents),
        lambda folder: lyapunov.save(exponents, folder),
        study_pictures.lyapunov,
        wrapped,
        "lyapunov",
    )
