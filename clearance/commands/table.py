"""`clearance table`: a run for other programs."""

import argparse
from pathlib import Path

from clearance.commands.common import DONE, add_command, existing, json_text
from clearance.files.texts import listed

SUFFIXES = (".csv", ".mat", ".tex", ".bib")


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "table")
    p.add_argument("file", metavar="RUN.h5", help="a result file")
    p.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        help=".csv or .mat: channels along time; .tex: metrics with errors; .bib: sources of the "
        "laws (default RUN.csv)",
    )
    p.add_argument("--channels", metavar="LIST", help='of .csv and .mat: "bodies/slider/*" (all)')
    p.add_argument("--metrics", metavar="LIST", help='of .tex: "joint_B_*" (all)')
    return p


def run(options) -> int:
    """Write the file and print its path. Raises ValueError for another suffix."""
    from clearance.results.result import open_result

    path = Path(options.output or Path(existing(options.file)).with_suffix(".csv"))
    if path.suffix not in SUFFIXES:
        raise ValueError(f"-o {path}: its name must end in {', '.join(SUFFIXES)}")
    with open_result(existing(options.file)) as result:
        if path.suffix == ".tex":
            result.to_latex(path, options.metrics and listed(options.metrics))
        elif path.suffix == ".bib":
            path.write_text(result.citations(), encoding="utf-8")
        else:
            write = result.to_csv if path.suffix == ".csv" else result.to_mat
            write(path, options.channels and listed(options.channels))
    print(json_text({"file": str(path)}) if options.json else f"wrote {path}")
    return DONE
