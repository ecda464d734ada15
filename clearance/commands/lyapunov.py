"""`clearance lyapunov`: the largest Lyapunov exponent of a case."""

import textwrap

from clearance.commands.common import (
    case_options,
    make_folder,
    progress_of,
    publish,
    scene_of,
)

OPTIONS = case_options() | {
    "--turns N": (200, "turns of the drive that it is averaged over"),
    "--settle N": (20, "turns before them, left out"),
    "--interval S": ("s", None, "takes the place of a turn where nothing turns steadily"),
    "-o DIR": "folder for table, picture and HDF5",
}


def run(options) -> int:
    """Find the exponent and show it; exit status 1 where the motion cannot be continued."""
    from clearance.motions import lyapunov
    from clearance.postprocess import study_pictures

    case, _, scene = scene_of(options)
    make_folder(options)
    with progress_of(options) as shown:
        exponent = lyapunov.lyapunov(
            scene, options.turns, options.settle, interval=options.interval, progress=shown
        )
    name = " ".join([case.name, *options.parameters])
    exponents = {name: exponent}
    wrapped = {textwrap.fill(name, 80): exponent}  # the picture has no room for longer lines
    return publish(
        options,
        lyapunov.table(exponents),
        lyapunov.plain(exponents),
        lyapunov.save,
        lambda _, path: study_pictures.lyapunov(wrapped, path),
        exponents,
        "lyapunov",
    )
