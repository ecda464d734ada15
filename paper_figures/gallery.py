"""All figures together: drawing one, the manifest that lists the data behind each, and the page
that shows them.
"""

import base64
import io
import json
import time
import traceback
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from importlib import import_module
from multiprocessing import active_children, get_context
from pathlib import Path

from clearance.paper_figures import workshop
from clearance.postprocess.pages import Markup, Page, element, join, markup

from clearance.files.locks import replacing
from clearance.results.tables import provenance
from clearance.run.interrupts import end_groups, lead_group

FORMAT, FORMAT_VERSION = "clearance-figures", 1
DONE = "done"
MANIFEST, PAGE = "manifest.json", "index.html"
SMALL = (240, 150)  # largest size of a small picture [pixel]
OTHERS = "Figures of earlier versions"  # whose scripts stated no group
STYLE = """
.small{display:flex;flex-wrap:wrap;gap:.6rem;margin:.4rem 0 1rem}
.small a{width:15rem;border:1px solid #ccc;padding:.3rem;text-align:center;
font-size:.8rem;overflow-wrap:anywhere}
.small img{display:block;margin:0 auto .3rem}article{border-top:1px solid #ddd;margin-top:1.5rem}
article img{max-height:34rem}
"""


@dataclass
class Entry:
    """A figure in the manifest: what it is, how it went, when and with what it was made, its files
    and results.
    """

    name: str
    title: str
    about: dict[str, str]
    status: str
    seconds: float
    quick: bool
    made: dict[str, str | int]
    files: list[str] = field(default_factory=list)
    results: list[dict] = field(default_factory=list)


def drawn(
    folder: Path,
    name: str,
    quick: bool,
    fresh: bool,
    say: Callable[[str], None] | None = None,
    results: Path | None = None,
) -> Entry:
    """Draw one figure. Where that fails, the status has the reason, and the log beside the figures
    the place.
    """
    work = workshop.Workshop(folder, name, quick, fresh, say or (lambda text: None), results)
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


def all_drawn(options, names: list[str], folder: Path, line: Callable) -> list[Entry]:
    """Draw the figures, note each in the manifest when it is done; those that measure run times
    alone, at the end.
    """
    entries: dict[str, Entry] = {}

    def done(entry: Entry) -> None:
        note(folder, entry)
        entries[entry.name] = entry
        if not options.json:
            line.clear()
            text = f"{entry.seconds:7.1f} s  {entry.name:<26} {entry.status}"
            print(f"{len(entries):>3}/{len(names)} {text}", flush=True)

    timed = [name for name in names if workshop.timed(name)]
    others = [name for name in names if name not in timed]
    if options.workers > 1 and len(others) > 1:
        _side_by_side(options, others, folder, line, done)
    else:
        timed = names
    for name in timed:
        line(f"{name}, {len(entries) + 1} of {len(names)}", always=True)
        say = lambda text, name=name: line(f"{name}: {text}")  # noqa: E731
        done(drawn(folder, name, options.quick, options.fresh, say, options.results))
    return [entries[name] for name in names]


def _side_by_side(options, names: list[str], folder: Path, line: Callable, done: Callable) -> None:
    """Draw figures in as many processes as there are workers, in their order; an interrupt ends all
    at once.
    """
    from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait

    waiting, drawing, more = deque(names), {}, (options.quick, options.fresh, None, options.results)
    before = set(active_children())
    with ProcessPoolExecutor(options.workers, get_context("spawn"), lead_group) as pool:
        try:
            while waiting or drawing:
                while waiting and len(drawing) < options.workers:
                    name = waiting.popleft()
                    drawing[pool.submit(drawn, folder, name, *more)] = name
                line(f"drawing {', '.join(drawing.values())}", always=True)
                for future in wait(drawing, timeout=30.0, return_when=FIRST_COMPLETED).done:
                    del drawing[future]
                    done(future.result())
        except BaseException:
            end_groups(set(active_children()) - before)
            raise


def note(folder: Path, entry: Entry) -> Path:
    """Put a figure into the manifest of its folder, in place of an earlier one of the same name."""
    figures = read(folder) | {entry.name: asdict(entry)}
    document = {"format": FORMAT, "format_version": FORMAT_VERSION}
    with replacing(folder / MANIFEST) as temporary:
        temporary.write_text(json.dumps(document | {"figures": figures}, indent=1, default=str))
    return folder / MANIFEST


def read(folder: Path) -> dict[str, dict]:
    """The figures of a manifest by name; none where there is no manifest.

    Raises ValueError for what is none.
    """
    path = folder / MANIFEST
    if not path.exists():
        return {}
    try:
        document = json.loads(path.read_text())
        if document["format"] != FORMAT:
            raise KeyError("format")
        return document["figures"]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(
            f"{path} is not a manifest of figures: {error!r}; give another directory"
        ) from None


def page(folder: Path) -> Path:
    """Write the page that shows all figures of a folder by groups.

    On top stand small pictures that link to the figures. Below stands each figure with the text of
    its script and of the manifest.
    """
    groups, shown = _by_group(read(folder)), Page("Figures of clearance")
    small = [
        join([element("h3", title), _small(folder, entries)]) for title, entries in groups.items()
    ]
    shown.head = join([element("style", Markup(STYLE)), element("h1", shown.title), *small])
    for title, entries in groups.items():
        shown.section(title, *map(_figure, entries.values()))
    return shown.save(folder / PAGE)


def _by_group(figures: dict[str, dict]) -> dict[str, dict[str, dict]]:
    """Figures of a manifest under the titles of their groups, both in order; groups without a
    figure are left out.
    """
    groups = {title: {} for title in (*workshop.GROUPS.values(), OTHERS)}
    for name, entry in sorted(figures.items()):
        groups[workshop.GROUPS.get(entry["about"].get("Group"), OTHERS)][name] = entry
    return {title: entries for title, entries in groups.items() if entries}


def _small(folder: Path, entries: dict[str, dict]):
    """A small picture of each figure, which links to it; the name alone where it has no picture."""
    links = []
    for name, entry in entries.items():
        picture = next(
            (folder / f for f in entry["files"] if f.endswith(".png") and (folder / f).exists()),
            None,
        )
        image = _thumbnail(picture) if picture else ""
        links.append(element("a", image, name, href=f"#{name}", title=entry["title"]))
    return element("div", *links, class_="small")


def _thumbnail(picture: Path):
    """A picture at SMALL size, its bytes in the page."""
    from PIL import Image

    image, data = Image.open(picture).convert("RGB"), io.BytesIO()
    image.thumbnail(SMALL, Image.Resampling.LANCZOS)
    image.save(data, "PNG", optimize=True)
    source = f"data:image/png;base64,{base64.b64encode(data.getvalue()).decode()}"
    return element("img", src=source, alt="", width=image.width, height=image.height)


def _figure(entry: dict):
    """All of one figure: pictures, paragraphs of its script, files and results."""
    parts = [(part, text) for part, text in entry["about"].items() if part != "Group"]
    paragraphs = [element("p", element("b", f"{part}: "), text) for part, text in parts]
    pictures = [_picture(f) for f in entry["files"] if f.endswith(".png")]
    files = join((element("a", f, href=f) for f in entry["files"] if not f.endswith(".png")), ", ")
    results = element("ul", *(element("li", _result(r)) for r in entry["results"]))
    preview = ", a coarse preview: the texts are about the whole figure" * entry["quick"]
    return element(
        "article",
        element("h3", entry["title"]),
        element("p", element("code", entry["name"]), f": {entry['status']}{preview}"),
        *pictures,
        *paragraphs,
        element("p", "Files: ", files),
        element("details", element("summary", "results"), results),
        id=entry["name"],
    )


def _picture(file: str):
    return element("figure", element("a", element("img", src=file, alt=Path(file).stem), href=file))


def _result(result: dict):
    words = "; ".join(
        f"{k} {json.dumps(v, default=str)}" for k, v in result.items() if k != "file" and v
    )
    return join([element("a", result["file"], href=result["file"]), markup(f": {words}")])
