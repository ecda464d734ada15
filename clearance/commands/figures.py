"""`clearance figures`: the figures and tables of the sources, and of the evidence."""

import argparse
import dataclasses
import time
from fnmatch import fnmatch
from pathlib import Path

from clearance.checks import meant
from clearance.commands.common import DONE, FAILED, Line, add_command, json_text

EXAMPLES = """\
  clearance figures --list                       names and titles
  clearance figures -o figures                   all of them (about 20 minutes on two cores; again less)
  clearance figures 'feeder_*' sweep_map         some, in the order given
  clearance figures --quick -o preview           coarse previews of all

DIR holds each picture as PNG and PDF, tables as Markdown (own ones as CSV too), the results they were drawn from
(DIR/results), manifest.json, which says what lies behind each picture, and index.html, which shows all of them in
groups by source. Runs and sweeps are used again as long as scene, options and sources are the same, by all figures that
need them, and with --results by several folders; run times and fits are found anew.
"""


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(
        commands, "figures", help="regenerate the figures of the source systems and of the evidence", epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    p.add_argument("names", metavar="NAME", nargs="*", help="figures or patterns such as 'feeder_*' (default all)")
    p.add_argument("-o", dest="output", metavar="DIR", default="figures", help="folder (default figures)")
    p.add_argument("--results", metavar="DIR", help="folder of runs and sweeps, to share them (default -o/results)")
    p.add_argument("--list", action="store_true", help="only say which there are")
    p.add_argument("--quick", action="store_true", help="coarse previews: fewer turns, points and tolerances")
    p.add_argument("--fresh", action="store_true", help="run again what has been run before")
    return p


def run(options) -> int:
    """Draw what is asked for; one that fails does not stop the others. Raises ValueError for unknown names."""
    from clearance.paper_figures import gallery, workshop
    from clearance.results import locked

    names = _chosen(options.names, workshop.names())
    titles = {name: workshop.about(name)[0] for name in names}
    if options.list:
        print(json_text(titles) if options.json else "\n".join(_listed(names)))
        return DONE
    folder, began = Path(options.output), time.perf_counter()
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"-o {folder} is a file; give a directory")
    gallery.read(folder)  # another kind of folder is refused before anything runs
    folder.mkdir(parents=True, exist_ok=True)
    with locked(folder, "drawing figures there"):
        try:
            found = _draw(options, names, folder)
        finally:
            page = gallery.page(folder)
    seconds = time.perf_counter() - began
    failed = [e.name for e in found if e.status != gallery.DONE]
    if options.json:
        document = {"status": "failed" if failed else "complete", "folder": str(folder), "seconds": seconds}
        print(json_text(document | {"figures": [dataclasses.asdict(e) for e in found]}))
    else:
        print(f"{len(found) - len(failed)} of {len(found)} figures in {seconds:.0f} s; see {page}")
    return FAILED if failed else DONE


def _draw(options, names: list[str], folder: Path) -> list:
    """Draw one figure after the other, and note each in the manifest when it is done."""
    from clearance.paper_figures import gallery

    line, found = Line(options), []
    for k, name in enumerate(names, 1):
        line(f"{name}, {k} of {len(names)}", always=True)
        say = lambda text, name=name: line(f"{name}: {text}")  # noqa: E731
        entry = gallery.drawn(folder, name, options.quick, options.fresh, say, options.results)
        gallery.note(folder, entry)
        found.append(entry)
        if not options.json:
            line.clear()
            print(f"{k:>3}/{len(names)} {entry.seconds:7.1f} s  {name:<26} {entry.status}", flush=True)
    return found


def _listed(names: list[str]) -> list[str]:
    """Names and titles in print, under the titles of their groups; names of a group that stand apart repeat it."""
    from clearance.paper_figures import workshop

    lines, width, last = [], max(map(len, names)), None
    for name in names:
        title, about = workshop.about(name)
        if about["Group"] != last:
            last = about["Group"]
            lines += ["", workshop.GROUPS[last]]
        lines.append(f"  {name:<{width}}  {title}")
    return lines[1:]


def _chosen(patterns: list[str], known: list[str]) -> list[str]:
    """Names that a pattern fits, in the order of the patterns and then of the groups; all where none is given.

    Raises ValueError for a pattern that fits none.
    """
    for pattern in patterns:
        if not any(fnmatch(n, pattern) for n in known):
            raise ValueError(f"no figure {pattern!r}{meant(pattern, known)}; there are {', '.join(known)}")
    return list(dict.fromkeys(n for p in patterns or ["*"] for n in known if fnmatch(n, p)))
