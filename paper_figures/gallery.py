"""All figures together: drawing one, the manifest that says what lies behind each, and the page that shows them."""

import json
import time
import traceback
from dataclasses import asdict, dataclass, field
from importlib import import_module
from pathlib import Path

from clearance.paper_figures import workshop
from clearance.postprocess.pages import Page, element, join, markup

from clearance.results import provenance, replacing

FORMAT, FORMAT_VERSION = "clearance-figures", 1
DONE = "done"
MANIFEST, PAGE = "manifest.json", "index.html"


@dataclass
class Entry:
    """A figure in the manifest: what it is, how it went, when and with what it was made, its files and results."""

    name: str
    title: str
    about: dict[str, str]
    status: str
    seconds: float
    quick: bool
    made: dict[str, str | int]
    files: list[str] = field(default_factory=list)
    results: list[dict] = field(default_factory=list)


def drawn(folder: Path, name: str, quick: bool, fresh: bool, say) -> Entry:
    """Draw one figure; where that fails, the status says why, and the log beside the figures where."""
    work = workshop.Workshop(folder, name, quick, fresh, say)
    title, about = workshop.about(name)
    began, status, log = time.perf_counter(), DONE, folder / f"{name}.log"
    log.unlink(missing_ok=True)
    try:
        import_module(f"clearance.paper_figures.{name}").draw(work)
    except Exception as error:  # whatever it is, the other figures are drawn
        status = f"failed: {type(error).__name__}: {' '.join(str(error).split())}"
        log.write_text(traceback.format_exc())
    seconds = time.perf_counter() - began
    return Entry(name, title, about, status, seconds, quick, provenance(), work.files, work.results)


def note(folder: Path, entry: Entry) -> Path:
    """Put a figure into the manifest of its folder, in place of an earlier one of the same name."""
    figures = read(folder) | {entry.name: asdict(entry)}
    document = {"format": FORMAT, "format_version": FORMAT_VERSION}
    with replacing(folder / MANIFEST) as temporary:
        temporary.write_text(json.dumps(document | {"figures": figures}, indent=1, default=str))
    return folder / MANIFEST


def read(folder: Path) -> dict[str, dict]:
    """The figures of a manifest by name; none where there is no manifest. Raises ValueError for what is none."""
    path = folder / MANIFEST
    if not path.exists():
        return {}
    try:
        document = json.loads(path.read_text())
        if document["format"] != FORMAT:
            raise KeyError("format")
        return document["figures"]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path} is not a manifest of figures: {error!r}; give another directory") from None


def page(folder: Path) -> Path:
    """Write the page that shows all figures of a folder, with what their scripts and the manifest say of them."""
    shown = Page("Figures of clearance")
    shown.head = element("h1", shown.title)
    for name, entry in sorted(read(folder).items()):
        paragraphs = [element("p", element("b", f"{part}: "), text) for part, text in entry["about"].items()]
        pictures = [_picture(f) for f in entry["files"] if f.endswith(".png")]
        files = join((element("a", f, href=f) for f in entry["files"] if not f.endswith(".png")), ", ")
        results = [element("li", _result(r)) for r in entry["results"]]
        said = f": {entry['status']}" + (", a coarse preview: the texts are about the whole figure" * entry["quick"])
        shown.section(
            entry["title"], element("p", element("code", name), said), *pictures, *paragraphs,
            element("p", "Files: ", files), element("details", element("summary", "results"), element("ul", *results)),
        )  # fmt: skip
    return shown.save(folder / PAGE)


def _picture(file: str):
    return element("figure", element("img", src=file, alt=Path(file).stem))


def _result(result: dict):
    told = "; ".join(f"{k} {json.dumps(v, default=str)}" for k, v in result.items() if k != "file" and v)
    return join([element("a", result["file"], href=result["file"]), markup(f": {told}")])
