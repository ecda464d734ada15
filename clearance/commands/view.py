"""`clearance view`: a page on which runs move, and a map whose points open their runs."""

from pathlib import Path

from clearance.commands.common import (
    existing,
    listed,
    number,
    show,
)

EXAMPLES = """\
  clearance view run.h5                              mechanism, clearances, curves, pressure fields
  clearance view dry.h5 lubricated.h5 -o both.html   two runs over each other
  clearance view run.h5 --channels "slider.ax,B.force,B.epsilon"
  clearance view run.h5 --measured bench.csv --channels slider.ax
                                                     measured data over the curve
  clearance view SWEEP                               a map whose points open their runs

The page is one file for any browser since 2023; it needs no network. Of runs it has all
channels, of the runs of a sweep the last two turns. In the page, ? lists the keys.
"""


OPTIONS = {
    "inputs FILE_OR_DIR +": "run files, up to six, or one sweep directory",
    "-o PAGE.html": "page (default FILE.view.html beside a run file, view.html in a sweep "
    "directory)",
    "--channels NAMES": "comma list of the curves that are shown first, as in plot (default: "
    "accelerations, efforts, forces, films)",
    "--settle N": (
        number,
        None,
        "turns of the start-up, which the page opens after (default 1); seconds where nothing "
        "turns",
    ),
    "--measured FILE.csv": "measured data over time or drive angle, with units in the header, "
    "laid over the first of --channels, or CHANNEL=COLUMN (default: the channel that its "
    "column names)",
    "--column NAME": "column of the measured data, where there are several",
    "--shift T": "where in the run the measured data begin (default: found)",
}


def _measured(options, source) -> list:
    """The measured data beside the first run; none where no file is given."""
    if options.measured is None:
        for name in ("column", "shift"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name} needs --measured FILE.csv")
        return []
    if Path(source).is_dir():
        raise ValueError("view: measured data lie over a run; a sweep has a map")
    from clearance.postprocess.measured import compare
    from clearance.results.result import open_result

    first = (listed(options.channels) or [None])[0]
    settings = {"channels": first, "column": options.column, "settle": options.settle or 0.0}
    if options.shift is not None:
        settings["shift"] = options.shift
    with open_result(source) as record:
        return [compare(record, options.measured, **settings)]


def run(options) -> int:
    """Write the page and print its path.

    Raises FileNotFoundError or ValueError for inputs that are no run and no sweep.
    """
    from clearance.postprocess.view import view

    inputs = [existing(path) for path in options.inputs]
    channels = [name.partition("=")[0] for name in listed(options.channels) or ()] or None
    shown = {"channels": channels, "settle": options.settle}
    page = view(inputs, options.output, measured=_measured(options, inputs[0]), **shown)
    size = page.stat().st_size
    document = {"status": "complete", "page": str(page), "bytes": size}
    return show(options, document, [f"wrote {page} ({size / 1e6:.2f} MB); open it in a browser"])
