"""Structure of the code: the way of a scene through its folders, and what they import.

Group: evidence

Answers: how a scene becomes a kernel, a run, a result file and pictures; no source shows it.

Reproduced: all imports between folders, read from the syntax trees of their modules, and the
sentence at the head of each folder. None leads back.

Assumed: nothing; the order of the folders is that of `STREET`.

Not comparable: the sources publish no code.
"""

import ast
from collections import Counter
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from textwrap import wrap

from clearance.paper_figures import workshop
from clearance.postprocess.figures import sheet

#: folders and modules of the package in the order of a scene's way, stretch by stretch; a module
#: imports its own folder and those before it. Those of the last stretch import each other.
STREET = {
    "tools": ("version", "values", "files", "machine"),
    "scene": ("laws", "film", "elements", "scene"),
    "kernel": ("tracing", "mechanism", "stepping"),
    "run": ("results", "metrics", "run", "accuracy", "simulation"),
    "many runs": ("lanes", "motions", "wearing", "sweeping", "identify", "exporting", "studies"),
    "people": ("cases", "postprocess", "paper_figures", "commands", "cli"),
}
COLOURS = ("#546e7a", "#1565c0", "#6a1b9a", "#c62828", "#9e9d24", "#2e7d32")
PITCH, BREADTH, LINE = 1.95, 1.72, 0.125  # from box to box, of a box, of a line of text [inch]
LETTERS = 32  # of a line
FOOT, BEND = 0.3, 0.15  # of arrows: height above the boxes [inch], and above their feet over length
LEGEND = "An arrow leads from a stretch to one that imports it; the number counts the imports."
WIDTH = 0.07  # of an arrow an import [points]


def files(name: str) -> list[Path]:
    """Files of a folder or module of the package, that with its docstring first."""
    first = Path(find_spec(f"clearance.{name}").origin)
    others = first.parent.rglob("*.py") if first.name == "__init__.py" else ()
    return list(dict.fromkeys((first, *sorted(others))))


def sentence(path: Path) -> str:
    """First sentence of a module's docstring."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return " ".join(text.split()).partition(". ")[0].rstrip(".")


def counted() -> Counter[tuple[str, str]]:
    """Imports between folders: (folder that is imported, folder that imports) and their number."""
    counts, street = Counter(), set(chain(*STREET.values()))
    for name in street:
        for node in (n for path in files(name) for n in ast.walk(ast.parse(path.read_bytes()))):
            if isinstance(node, ast.ImportFrom):
                wanted = {f"{node.module}.{alias.name}".split(".")[1] for alias in node.names}
                ours = wanted & street if node.module.split(".")[0] == "clearance" else ()
                counts.update((w, name) for w in ours if w != name)
    return counts


def picture(counts: Counter):
    """A box for each stretch with its folders, an arrow for all imports from one to another."""
    figure = sheet(11.8, 5.2)
    axes = figure.add_subplot()
    stretch = {name: i for i, names in enumerate(STREET.values()) for name in names}
    between = Counter()
    for (wanted, name), count in counts.items():
        between[stretch[wanted], stretch[name]] += count
    for i, (title, names) in enumerate(STREET.items()):
        draw_stretch(axes, i, title, names)
    for (a, b), count in between.items():
        if a != b:
            draw_arrow(axes, a, b, count)
    axes.text(0.0, -3.25, LEGEND, size=9, color="#333333")
    axes.set_xlim(-0.1, PITCH * len(STREET))
    axes.set_ylim(-3.4, 1.95)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def draw_stretch(axes, i: int, title: str, names: tuple[str, ...]) -> None:
    """The folders of a stretch with their sentences, from the top down."""
    x, y = PITCH * i, -0.12
    heading = {"size": 12, "weight": "bold", "color": COLOURS[i]}
    axes.text(x, 0.05, f"{i + 1}  {title}", **heading)
    axes.plot([x, x + BREADTH], [0, 0], lw=3, color=COLOURS[i])
    for name in names:
        y -= LINE
        axes.text(x, y, name, size=8, weight="bold", color=COLOURS[i])
        for line in wrap(sentence(files(name)[0]).replace("`", ""), LETTERS):
            y -= LINE
            axes.text(x, y, line, size=7, color="#333333")
        y -= 0.4 * LINE


def draw_arrow(axes, a: int, b: int, count: int) -> None:
    """An arc over the stretches from an imported one to one that imports it, with the number."""
    width, inset = WIDTH * count, 0.16 * (b - a)  # near neighbours inside, at the gap
    start, end = PITCH * a + BREADTH - inset, PITCH * b + inset
    head = f"simple,tail_width={width},head_width={width + 5},head_length=7"
    style = {"arrowstyle": head, "connectionstyle": f"arc3,rad={-2 * BEND}", "mutation_scale": 1}
    style |= {"color": COLOURS[a], "lw": 0, "alpha": 0.7, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (end, FOOT), (start, FOOT), arrowprops=style)
    top = FOOT + BEND * (end - start) + width / 144 + 0.02
    axes.text((start + end) / 2, top, count, size=7, ha="center", zorder=4)


def draw(work: workshop.Workshop) -> None:
    work.keep(picture(counted()))
