"""`clearance figures`: the figures and tables of the sources, and of the evidence."""

import dataclasses
import os
import time
from collections import deque
from collections.abc import Callable
from fnmatch import fnmatch
from multiprocessing import active_children, get_context
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    Line,
    make_folder,
    show,
)
from clearance.run.interrupts import end_groups, lead_group, terminable
from clearance.values.checks import known, whole

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

    names = _chosen(options.names, workshop.names())
    if not (options.names or options.measure or options.list):
        names = [name for name in names if not _timed(name)]
    titles = {name: workshop.about(name)[0] for name in names}
    if options.list:
        return show(options, titles, _listed(names))
    whole("--workers", options.workers, 1)
    make_folder(options)
    folder, began = Path(options.output), time.perf_counter()
    gallery.read(folder)  # another kind of folder is refused before anything runs
    with locked(folder, "drawing figures there"), terminable():
        try:
            drawn = _draw(options, names, folder)
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


def _draw(options, names: list[str], folder: Path) -> list:
    """Draw the figures, note each in the manifest when it is done; those that measure run times
    alone, at the end.
    """
    from clearance.paper_figures import gallery

    line, entries = Line(options), {}

    def done(entry) -> None:
        gallery.note(folder, entry)
        entries[entry.name] = entry
        if not options.json:
            line.clear()
            text = f"{entry.seconds:7.1f} s  {entry.name:<26} {entry.status}"
            print(f"{len(entries):>3}/{len(names)} {text}", flush=True)

    timed = [name for name in names if _timed(name)]
    others = [name for name in names if name not in timed]
    if options.workers > 1 and len(others) > 1:
        _side_by_side(options, others, folder, line, done)
    else:
        timed = names
    for name in timed:
        line(f"{name}, {len(entries) + 1} of {len(names)}", always=True)
        say = lambda text, name=name: line(f"{name}: {text}")  # noqa: E731
        done(gallery.drawn(folder, name, options.quick, options.fresh, say, options.results))
    return [entries[name] for name in names]


def _side_by_side(options, names: list[str], folder: Path, line: Line, done: Callable) -> None:
    """Draw figures in as many processes as there are workers, in their order; an interrupt ends all
    at once.
    """
    from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait

    from clearance.paper_figures import gallery

    waiting, drawing, more = deque(names), {}, (options.quick, options.fresh, None, options.results)
    before = set(active_children())
    with ProcessPoolExecutor(options.workers, get_context("spawn"), lead_group) as pool:
        try:
            while waiting or drawing:
                while waiting and len(drawing) < options.workers:
                    name = waiting.popleft()
                    drawing[pool.submit(gallery.drawn, folder, name, *more)] = name
                line(f"drawing {', '.join(drawing.values())}", always=True)
                for future in wait(drawing, timeout=30.0, return_when=FIRST_COMPLETED).done:
                    del drawing[future]
                    done(future.result())
        except BaseException:
            end_groups(set(active_children()) - before)
            raise


def _timed(name: str) -> bool:
    """True for a figure that measures the code, most of them run times."""
    from clearance.paper_figures import workshop

    return workshop.about(name)[1]["Group"] == workshop.TIMED


def _listed(names: list[str]) -> list[str]:
    """Names and titles in print, under the titles of their groups; names of a group that stand
    apart repeat it.
    """
    from clearance.paper_figures import workshop

    lines, width, last = [], max(map(len, names)), None
    for name in names:
        title, about = workshop.about(name)
        if about["Group"] != last:
            last = about["Group"]
            lines += ["", workshop.GROUPS[last]]
        lines.append(f"  {name:<{width}}  {title}")
    return lines[1:]


def _chosen(patterns: list[str], names: list[str]) -> list[str]:
    """Names that a pattern fits, in the order of the patterns and then of the groups; all where
    none is given.

    Raises ValueError for a pattern that fits none.
    """
    for pattern in patterns:
        if not any(fnmatch(n, pattern) for n in names):
            known("no figure", pattern, names)
    return list(dict.fromkeys(n for p in patterns or ["*"] for n in names if fnmatch(n, p)))
