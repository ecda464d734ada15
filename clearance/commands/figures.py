"""`clearance figures`: the figures and tables of the sources, and of the evidence."""

import argparse
import dataclasses
import json
import time
from fnmatch import fnmatch
from pathlib import Path

from clearance.commands.common import DONE, FAILED, Line, add_command

EXAMPLES = """\
  clearance figures --list                       names and titles
  clearance figures -o figures                   all of them (about half an hour on two cores; again: minutes)
  clearance figures 'feeder_*' -o figures        some
  clearance figures --quick -o preview           coarse previews of all

DIR holds each picture as PNG and PDF, each table as Markdown and CSV, the results they were drawn from (DIR/results,
used again as long as scene, options and sources are the same), manifest.json, which says what lies behind each
picture, and index.html, which shows all of them.
"""


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(
        commands, "figures", help="regenerate the figures of the source systems and of the evidence", epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    p.add_argument("names", metavar="NAME", nargs="*", help="figures or patterns such as 'feeder_*' (default all)")
    p.add_argument("-o", dest="output", metavar="DIR", default="figures", help="folder (default figures)")
    p.add_argument("--list", action="store_true", help="only say which there are")
    p.add_argument("--quick", action="store_true", help="coarse previews: fewer turns, points and tolerances")
    p.add_argument("--fresh", action="store_true", help="run again what has been run before")
    return p


def run(options) -> int:
    """Draw what is asked for; one that fails does not stop the others. Raises ValueError for unknown names."""
    from clearance.paper_figures import gallery, workshop

    names = _chosen(options.names, workshop.names())
    titles = {name: workshop.about(name)[0] for name in names}
    if options.list:
        width = max(map(len, names))
        print(json.dumps(titles) if options.json else "\n".join(f"{n:<{width}}  {t}" for n, t in titles.items()))
        return DONE
    folder, line, began = Path(options.output), Line(options), time.perf_counter()
    found = []
    for k, name in enumerate(names):
        entry = gallery.drawn(folder, name, options.quick, options.fresh, lambda text: line(f"{name}: {text}"))  # noqa: B023
        gallery.note(folder, entry)
        found.append(entry)
        if not options.json:
            line.clear()
            print(f"{k + 1:>3}/{len(names)} {entry.seconds:7.1f} s  {name:<26} {entry.status}", flush=True)
    seconds = time.perf_counter() - began
    page = gallery.page(folder)
    failed = [e.name for e in found if e.status != gallery.DONE]
    if options.json:
        document = {"status": "failed" if failed else "complete", "folder": str(folder), "seconds": seconds}
        print(json.dumps(document | {"figures": [dataclasses.asdict(e) for e in found]}))
    else:
        print(f"{len(found) - len(failed)} of {len(found)} figures in {seconds:.0f} s; see {page}")
    return FAILED if failed else DONE


def _chosen(patterns: list[str], known: list[str]) -> list[str]:
    """Names that a pattern fits, all where none is given. Raises ValueError for a pattern that fits none."""
    for pattern in patterns:
        if not any(fnmatch(n, pattern) for n in known):
            raise ValueError(f"no figure {pattern!r}; there are {', '.join(known)}")
    return [n for n in known if not patterns or any(fnmatch(n, p) for p in patterns)]
