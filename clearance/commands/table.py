"""`clearance table`: a run for other programs."""

from pathlib import Path

from clearance.commands.common import existing, show
from clearance.files.texts import listed

SUFFIXES = (".csv", ".mat", ".tex", ".bib")


OPTIONS = {
    "file RUN.h5": "a result file",
    "-o FILE": ".csv or .mat: channels along time; .tex: metrics with errors; .bib: sources of "
    "the laws (default RUN.csv)",
    "--channels LIST": 'of .csv and .mat: "bodies/slider/*" (all)',
    "--metrics LIST": 'of .tex: "joint_B_*" (all)',
}


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
    return show(options, {"file": str(path)}, [f"wrote {path}"])
