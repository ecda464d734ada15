"""`clearance figures`: the figures and tables of the sources, and of the evidence."""

import dataclasses
import os
import time
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    make_folder,
    progress_of,
    show,
)
from clearance.run.interrupts import terminable
from clearance.values.checks import whole

EXAMPLES = """\
  clearance figures --list                       names and titles
  clearance figures -o figures                   all but those that measure the code
  clearance figures --measure -o figures         these too, one at a time
  clearance figures 'feeder_*' sweep_map         some, in the order given
  clearance figures --quick -o preview           coarse previews of all

DIR holds each picture as PNG and PDF, tables as Markdown (own ones as CSV too), the results they
were drawn from (DIR/results), manifest.json, which lists what lies behind each picture, and
index.html, which shows all of them in groups by source. Runs and sweeps are used again as long as
scene, options and sources are the same, by all figures that need them, and with --results by
several folders; run times and fits are found anew.
"""


OPTIONS = {
    "names NAME *": "figures or patterns such as 'feeder_*' (default: all but those of --measure)",
    "-o DIR": ("figures", "folder"),
    "--results DIR": "folder of runs and sweeps, to share them (default -o/results)",
    "--workers N": (
        os.cpu_count() or 1,
        "figures drawn at a time, but for those that measure run times: one a core",
    ),
    "--measure": "also the figures that measure the code: run times, scaling, extremes",
    "--list": "only list them",
    "--quick": "coarse previews: fewer turns, points and tolerances",
    "--fresh": "run again what has been run before",
}


def run(options) -> int:
    """Draw what is requested; one that fails does not stop the others.

    Raises ValueError for unknown names.
    """
    from clearance.files.locks import locked
    from clearance.paper_figures import gallery, workshop

    names = workshop.chosen(options.names, workshop.names())
    if not (options.names or options.measure or options.list):
        names = [name for name in names if not workshop.timed(name)]
    titles = {name: workshop.about(name)[0] for name in names}
    if options.list:
        return show(options, titles, workshop.listing(names))
    whole("--workers", options.workers, 1)
    make_folder(options)
    folder, began = Path(options.output), time.perf_counter()
    gallery.read(folder)  # another kind of folder is refused before anything runs
    with locked(folder, "drawing figures there"), terminable():
        try:
            with progress_of(options) as shown:
                drawn = gallery.all_drawn(options, names, folder, shown)
        finally:
            page = gallery.page(folder)
    seconds = time.perf_counter() - began
    failed = [e.name for e in drawn if e.status != gallery.DONE]
    document = {
        "status": "failed" if failed else "complete",
        "folder": str(folder),
        "seconds": seconds,
        "figures": [dataclasses.asdict(e) for e in drawn],
    }
    done = f"{len(drawn) - len(failed)} of {len(drawn)} figures in {seconds:.0f} s; see {page}"
    return show(options, document, [done], FAILED if failed else DONE)
