"""One page that moves: mechanism, magnified clearances, curves and pressure fields at one time.

The page is one HTML file with all its numbers. Its content-security policy forbids every request
and every script but its own.
"""

import html
import json
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path

from clearance.postprocess.channels import expand
from clearance.postprocess.labels import labels_of
from clearance.postprocess.measured import Comparison
from clearance.postprocess.moving import Moving, of_all
from clearance.postprocess.policy import policy
from clearance.postprocess.view_map import of_sweep

from clearance.files.locks import replacing
from clearance.results.record import Record
from clearance.results.result import open_result
from clearance.sweeping.index import Sweep, open_sweep

PAGE = Path(__file__).parent / "page"
#: in the order in which a browser reads them
SCRIPTS = ("data.js", "canvas.js", "chart.js", "field.js", "machine.js", "map.js", "main.js")
MOST = 6  # runs laid over each other
SUFFIXES = (".html", ".htm")


def view(
    source,
    output: str | Path | None = None,
    *,
    channels: str | Iterable[str] | None = None,
    settle: float | None = None,
    labels: str | Iterable[str] | None = None,
    measured: Comparison | Iterable[Comparison] = (),
) -> Path:
    """Write a page on which runs move, or the map of a sweep whose points open their runs.

    source: a run's file or Result, up to six of them, or a sweep's directory or Sweep. output:
    default RUN.view.html beside the first file, view.html in the directory of a sweep. channels:
    names or patterns of the curves that are shown first, default accelerations, efforts, forces and
    films. settle: turns of the start-up (seconds, where nothing turns), which the page opens after;
    default one of two or more. labels: names of the runs, default what differs between them.
    measured: comparisons of measured data with the first run, as `cl.compare` makes them; their
    channels are shown first. Returns the path of the page. Raises ValueError for a name that does
    not end in .html, for too many runs, for channels that no run has and for runs of fewer than two
    samples. It raises FileNotFoundError and ValueError as `open_result` and `open_sweep` do.
    """
    sources = [*source] if isinstance(source, list | tuple) else [source]
    if not sources:
        raise ValueError("view: give at least one run or sweep")
    sweeps = [
        s for s in sources if isinstance(s, Sweep) or not isinstance(s, Record) and Path(s).is_dir()
    ]
    data = [measured] if isinstance(measured, Comparison) else [*measured]
    if sweeps and (len(sources) > 1 or data or settle is not None or labels is not None):
        raise ValueError(
            "view: a sweep has a page by itself; settle, labels and measured data are for runs"
        )
    path = _checked(output or _default(sources[0], bool(sweeps)))
    if sweeps:
        sweep = sources[0] if isinstance(sources[0], Sweep) else open_sweep(sources[0])
        return _write(path, document(*of_sweep(sweep, channels)))
    if len(sources) > MOST:
        raise ValueError(f"view: {len(sources)} runs, a page lays at most {MOST} over each other")
    with ExitStack() as opened:
        records = [
            s if isinstance(s, Record) else opened.enter_context(open_result(s)) for s in sources
        ]
        return _write(path, page_text(records, channels, settle, labels, data))


def _default(source, swept: bool) -> Path:
    """Path of a page that is given no name."""
    if swept:
        return Path(getattr(source, "folder", source)) / "view.html"
    path = getattr(source, "path", source)
    if isinstance(path, Record):
        raise ValueError(
            "view: this run has no file beside which a page could stand; give `output`"
        )
    return Path(path).with_suffix(".view.html")


def _checked(path: str | Path) -> Path:
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"view {path}: its name must end in .html")
    return path


def page_text(
    records: list[Record],
    channels=None,
    settle: float | None = None,
    labels=None,
    measured: Iterable[Comparison] = (),
) -> str:
    """The page of runs, as text; arguments as of `view`."""
    names = labels_of(records, labels)
    runs = [
        Moving(record, name, settle=settle) for record, name in zip(records, names, strict=True)
    ]
    first = [runs[0].lay(comparison) for comparison in measured]
    if channels is None:
        first += [path for run in runs for path in run.telling()]
    else:
        first += _wanted(records, channels)
    cases = dict.fromkeys(record.attributes["case"] for record in records)
    facts = {
        "title": " and ".join(cases),
        "first": list(dict.fromkeys(first)),
        "open": [*range(len(runs))],
        "map": None,
    }
    return document(facts | of_all(runs), [run.pack.text() for run in runs])


def _wanted(records: list[Record], channels: str | Iterable[str]) -> list[str]:
    """Paths of channels that some run has. Raises ValueError for a name that none has."""
    names = (
        [n.strip() for n in channels.split(",")] if isinstance(channels, str) else list(channels)
    )
    paths = []
    for name in names:
        missing = []
        for record in records:
            try:
                paths += expand(record, name)
            except ValueError as error:
                missing.append(error)
        if len(missing) == len(records):
            raise missing[0]
    return paths


def _write(path: Path, text: str) -> Path:
    """Write a page, completely or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def document(facts: dict, blocks: list[str], module: str = "") -> str:
    """The page as text; module: WebAssembly in base64, of a page that computes."""
    names = (*SCRIPTS, "live.js") if module else SCRIPTS
    script = '"use strict";\n' + "\n".join(
        (PAGE / name).read_text(encoding="utf-8") for name in names
    )
    style = (PAGE / "page.css").read_text(encoding="utf-8")
    texts = (
        f'<script type="text/plain" id="block{i}">{block}</script>'
        for i, block in enumerate(blocks)
    )
    rules = policy(script, style)
    if module:
        texts = (*texts, f'<script type="text/plain" id="module">{module}</script>')
        rules = rules.replace("script-src ", "script-src 'wasm-unsafe-eval' ")
    parts = {
        "POLICY": rules,
        "TITLE": html.escape(facts["title"]),
        "STYLE": style,
        "SCRIPT": script,
        "BLOCKS": "\n".join(texts),
        # no name of a user's ends the element or begins a comment
        "FACTS": json.dumps(facts, allow_nan=False).replace("<", "\\u003c"),
    }
    pieces = (PAGE / "page.html").read_text(encoding="utf-8").split("@")
    return "".join(parts[p] if i % 2 else p for i, p in enumerate(pieces))
