"""`clearance view`: a page on which runs move, and a map whose points open their runs."""

import argparse

from clearance.commands.common import DONE, add_command, existing, json_text, listed, number

EXAMPLES = """\
  clearance view run.h5                              mechanism, clearances, curves, pressure fields
  clearance view dry.h5 lubricated.h5 -o both.html   two runs over each other
  clearance view run.h5 --channels "slider.ax,B.force,B.epsilon"
  clearance view SWEEP                               a map whose points open their runs

The page is one file for any browser since 2023; it asks nothing of a network. Of runs it has all
channels, of the runs of a sweep the last two turns. In the page, ? lists the keys.
"""


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(
        commands,
        "view",
        help="a page that moves, of runs or of a sweep, in one HTML file",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument(
        "inputs",
        metavar="FILE_OR_DIR",
        nargs="+",
        help="run files, up to six, or one sweep directory",
    )
    p.add_argument(
        "-o",
        dest="output",
        metavar="PAGE.html",
        help="page (default FILE.view.html beside a run file, view.html in a sweep directory)",
    )
    p.add_argument(
        "--channels",
        metavar="NAMES",
        help="comma list of the curves that are shown first, as in plot "
        "(default: accelerations, efforts, forces, films)",
    )
    p.add_argument(
        "--settle",
        type=number,
        metavar="N",
        help="turns of the start-up, which the page opens after (default 1); "
        "seconds where nothing turns",
    )
    return p


def run(options) -> int:
    """Write the page and print its path.

    Raises FileNotFoundError or ValueError for inputs that are no run and no sweep.
    """
    from clearance.postprocess.view import view

    inputs = [existing(path) for path in options.inputs]
    page = view(inputs, options.output, channels=listed(options.channels), settle=options.settle)
    size = page.stat().st_size
    if options.json:
        print(json_text({"status": "complete", "page": str(page), "bytes": size}))
    else:
        print(f"wrote {page} ({size / 1e6:.2f} MB); open it in a browser")
    return DONE
