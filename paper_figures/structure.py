"""Structure of the code: which part imports which.

Group: evidence

Answers: how a scene becomes a kernel, a run, a result file and pictures; no source shows it.

Reproduced: all imports between modules of the package, read from their syntax trees. None leads
back.

Assumed: nothing; the grouping of modules is that of `BOXES`.

Not comparable: the sources publish no code.
"""

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from textwrap import fill

from clearance.paper_figures import workshop
from clearance.postprocess.figures import sheet
from matplotlib.patches import FancyBboxPatch, PathPatch, Polygon
from matplotlib.path import Path as Line

#: sizes in the picture [inch]
PITCH = 1.7  # from column to column
BREADTH = 1.28  # of a box
HEIGHT = 0.82  # of a box
SHARE = 0.0034  # width of an arrow an import
THIN = 0.012  # least width of an arrow
APART = 0.05  # distance of arrows
HEAD = 0.1  # length of the head of an arrow
BARB = 0.035  # how far a head stands out on each side
LEGEND = 120  # characters of a line of the legend
CLEAR = 0.13  # room between an arrow and a box that it passes
WAY = "#ffecb3"  # colour of the band
GREY = "#333333"  # of the legend


@dataclass(frozen=True)
class Box:
    """A part of the code: its title, what it is, its column and height in the picture, its colour.

    modules: folders and flat modules, apart by spaces.
    step: its place in the way of a scene through the code, 0 for parts beside that way.
    """

    title: str
    text: str
    column: int
    height: float
    colour: str
    modules: str
    step: int = 0

    @property
    def edges(self) -> tuple[float, float]:
        """Its lower and its upper edge [inch]."""
        return self.height - HEIGHT / 2, self.height + HEIGHT / 2

    @property
    def middle(self) -> float:
        """Middle of its column [inch]."""
        return PITCH * self.column

    @property
    def sides(self) -> tuple[float, float]:
        """Its left and its right side [inch]."""
        return self.middle - BREADTH / 2, self.middle + BREADTH / 2


BOXES = {
    "laws": Box("laws", "contact, friction,\nfilm, transition", 0, 0.0, "#8d6e63", "laws"),
    "film": Box("film", "Reynolds equation,\nforce tables", 1, 1.5, "#00897b", "film"),
    "scene": Box(
        "scene",
        "elements, cases,\nscene files",
        1,
        0.0,
        "#1565c0",
        "elements scene cases",
        step=1,
    ),
    "tracing": Box("tracing", "expressions to\ncompiled code", 2, 1.6, "#ad1457", "tracing"),
    "compiler": Box(
        "compiler", "mechanism/: one\nkernel a scene", 2, 0.0, "#6a1b9a", "mechanism", step=2
    ),
    "stepping": Box("stepping", "time loop,\nsteppers, events", 3, -1.25, "#8e7cc3", "stepping"),
    "run": Box(
        "run",
        "one run, and how\nsure it is",
        4,
        0.0,
        "#c62828",
        "run accuracy simulation",
        step=3,
    ),
    "files": Box(
        "results",
        "written by runs,\nread by pictures",
        4,
        1.75,
        "#ef6c00",
        "results metrics",
        step=4,
    ),
    "studies": Box("studies", "accuracy, cost,\nextremes", 5, 1.0, "#546e7a", "studies"),
    "sweeps": Box(
        "many runs",
        "sweeps, lanes,\nmotions, wear, fits",
        5,
        -1.0,
        "#9e9d24",
        "motions wearing lanes sweeping identify",
    ),
    "pictures": Box(
        "pictures",
        "postprocess/,\ncommands/",
        6,
        0.0,
        "#2e7d32",
        "postprocess commands cli paper_figures",
        step=5,
    ),
}
#: what all parts may use: it is drawn without arrows
SHARED = "version values files machine"
#: the package itself: its public names come from all parts
PUBLIC = "clearance"


def modules() -> dict[str, Path]:
    """Files of all modules of the package, by name without `clearance.`."""
    files = {}
    for folder in ("", *workshop.BESIDE):
        package = find_spec(f"{PUBLIC}.{folder}".rstrip("."))
        root = Path(package.origin).parent
        for path in sorted(root.rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            name = ".".join(p for p in (folder, *parts) if p and p != "__init__")
            files.setdefault(name, path)
    return {name: path for name, path in files.items() if name}


def box_of(name: str) -> str:
    """The box of a module, "shared" for those of all. Raises ValueError for none or several."""
    patterns = {b: box.modules for b, box in BOXES.items()} | {"shared": SHARED}
    fits = [b for b, words in patterns.items() if name.split(".")[0] in words.split()]
    if len(fits) != 1:
        raise ValueError(
            f"module clearance.{name} falls into {fits or 'no box'}: see BOXES in {__file__}"
        )
    return fits[0]


def imported(path: Path, names: dict[str, Path]) -> Iterator[str]:
    """Modules of the package that a file imports, without `clearance.`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            wanted = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            inside = [f"{node.module}.{alias.name}" for alias in node.names]
            wanted = {n if n.removeprefix(f"{PUBLIC}.") in names else node.module for n in inside}
        else:
            continue
        yield from (n for n in (w.removeprefix(f"{PUBLIC}.") for w in wanted) if n in names)


def counted() -> Counter[tuple[str, str]]:
    """Imports between boxes: (box that is imported, box that imports) and their number."""
    names, numbers = modules(), Counter()
    for name, path in names.items():
        for wanted in imported(path, names):
            numbers[box_of(wanted), box_of(name)] += 1
    return Counter({(a, b): n for (a, b), n in numbers.items() if a != b})


def width(count: int) -> float:
    """Width of the arrow of so many imports."""
    return max(THIN, SHARE * count)


def gaps(column: int) -> list[tuple[float, float]]:
    """Free stretches of a column, from below."""
    edges = [box.edges for box in BOXES.values() if box.column == column]
    sides = [-9.0, *(v for low, high in sorted(edges) for v in (low - CLEAR, high + CLEAR)), 9.0]
    return list(zip(sides[::2], sides[1::2], strict=True))


def lanes(counts: Counter) -> dict[tuple[str, str], list[tuple[float, float]]]:
    """Places (column, height) where each arrow passes the columns between its boxes."""
    passing = defaultdict(list)
    for a, b in counts:
        start, end = BOXES[a], BOXES[b]
        for column in range(start.column + 1, end.column):
            share = (column - start.column) / (end.column - start.column)
            wanted = start.height + share * (end.height - start.height)
            gap = min(gaps(column), key=lambda g: max(g[0] - wanted, wanted - g[1], 0.0))
            passing[column, gap].append((min(max(wanted, gap[0]), gap[1]), start.height, (a, b)))
    places = defaultdict(list)
    for (column, gap), arrows in passing.items():
        arrows.sort()
        sizes = [width(counts[edge]) + APART for *_, edge in arrows]
        middle, total = sum(w for w, *_ in arrows) / len(arrows), sum(sizes)
        low = min(max(middle - total / 2, gap[0]), gap[1] - total)
        for size, (*_, edge) in zip(sizes, arrows, strict=True):
            places[edge].append((column, low + size / 2))
            low += size
    return {edge: sorted(at) for edge, at in places.items()}


def ports(counts: Counter, between: dict) -> dict[tuple[str, str], list[float]]:
    """Heights at which each arrow leaves its box and reaches the other."""
    sides = defaultdict(dict)
    for end in (0, 1):
        for name in BOXES:
            edges = [e for e in counts if e[end] == name and not is_upright(e)]
            edges.sort(key=lambda e: (between.get(e) or [(0, BOXES[e[1 - end]].height)])[-end][1])
            sizes = [width(counts[e]) + APART for e in edges]
            low = BOXES[name].height - sum(sizes) / 2
            for size, edge in zip(sizes, edges, strict=True):
                sides[edge][end] = low + size / 2
                low += size
    return {edge: [at[0], at[1]] for edge, at in sides.items()}


def is_upright(edge: tuple[str, str]) -> bool:
    """True where both boxes stand in one column."""
    return BOXES[edge[0]].column == BOXES[edge[1]].column


def curve(points: list[tuple[float, float]]) -> Line:
    """A smooth line through points, level at each of them."""
    vertices, codes = [points[0]], [Line.MOVETO]
    for (x0, y0), (x1, y1) in pairwise(points):
        reach = 0.5 * (x1 - x0)
        vertices += [(x0 + reach, y0), (x1 - reach, y1), (x1, y1)]
        codes += [Line.CURVE4] * 3
    return Line(vertices, codes)


def arrow(axes, points: list[tuple[float, float]], size: float, colour: str) -> None:
    """A band along points with a head at its end; upright where they stand above each other."""
    (x, y), half = points[-1], 0.5 * size + BARB
    if points[0][0] == x:
        foot = y - HEAD if y > points[0][1] else y + HEAD
        line, head = Line([points[0], (x, foot)]), [(x - half, foot), (x + half, foot), (x, y)]
    else:
        line = curve([*points[:-1], (x - HEAD, y)])
        head = [(x - HEAD, y - half), (x - HEAD, y + half), (x, y)]
    band = {"fc": "none", "ec": colour, "lw": 72 * size, "capstyle": "butt"}
    axes.add_patch(PathPatch(line, alpha=0.5, zorder=1, **band))
    axes.add_patch(Polygon(head, fc=colour, ec="none", alpha=0.85, zorder=2))


def paths(counts: Counter) -> dict[tuple[str, str], list[tuple[float, float]]]:
    """Points of each arrow."""
    between = lanes(counts)
    ends, points_of = ports(counts, between), {}
    for edge in counts:
        a, b = (BOXES[name] for name in edge)
        if is_upright(edge):
            up = b.height > a.height
            points_of[edge] = [(a.middle, a.edges[up]), (a.middle, b.edges[not up])]
            continue
        points = [(a.sides[1], ends[edge][0])]
        for column, height in between.get(edge, ()):
            points += [(PITCH * column + side, height) for side in (-BREADTH / 2, BREADTH / 2)]
        points_of[edge] = [*points, (b.sides[0], ends[edge][1])]
    return points_of


def draw_way(axes, ways: dict) -> None:
    """A pale band along the boxes that a scene passes, in the order of their steps."""
    steps = sorted((name for name, box in BOXES.items() if box.step), key=lambda n: BOXES[n].step)
    for edge in pairwise(steps):
        a, b = ((BOXES[name].middle, BOXES[name].height) for name in edge)
        points = ways.get(edge, [a, b]) if a[1] != b[1] else [a, b]
        line = Line([a, b]) if a[0] == b[0] else curve(points)
        axes.add_patch(PathPatch(line, fc="none", ec=WAY, lw=30, capstyle="butt", zorder=0))


def draw_box(axes, box: Box) -> None:
    """A box with its title, its text and its step."""
    x, colour, corner = box.middle, box.colour, (box.sides[0], box.edges[0])
    shape = "round,pad=0,rounding_size=0.08"
    paper, ink = (colour, "white") if box.step else ("white", "#222222")
    edge = {"fc": paper, "ec": colour, "lw": 1.4, "zorder": 3}
    axes.add_patch(FancyBboxPatch(corner, BREADTH, HEIGHT, boxstyle=shape, **edge))
    words = {"color": ink, "ha": "center", "va": "center", "zorder": 4}
    axes.text(x, box.height + 0.2, box.title, size=12, weight="bold", **words)
    axes.text(x, box.height - 0.14, box.text, size=8, linespacing=1.2, **words)
    if box.step:
        badge = {"boxstyle": "circle,pad=0.25", "fc": "white", "ec": colour, "lw": 1.4}
        words |= {"color": colour, "zorder": 5}
        axes.text(corner[0] + 0.03, box.edges[1] - 0.03, box.step, size=9, bbox=badge, **words)


def draw_legend(axes, count: int) -> None:
    """The band, the widths of arrows, and the modules that are drawn without any."""
    y, x, words = -2.4, BOXES["laws"].sides[0], {"size": 9, "va": "center", "color": GREY}
    axes.plot([x, x + 0.5], [y, y], color=WAY, lw=14, solid_capstyle="butt")
    axes.text(x + 0.6, y, "the way of a scene", **words)
    x += 2.3
    for number in (3, 10, 30):
        arrow(axes, [(x, y), (x + 0.5, y)], width(number), GREY)
        axes.text(x + 0.56, y, number, **words)
        x += 0.9
    axes.text(x, y, "imports: an arrow leads from a part to one that imports it", **words)
    names = ", ".join(SHARED.split())
    text = fill(f"Without arrows: {count} imports of what all parts share: {names}.", LEGEND)
    axes.text(BOXES["laws"].sides[0], y - 0.22, text, **words | {"va": "top"})


def picture(counts: Counter):
    """Boxes in columns, an arrow from each to those that import it."""
    common = {edge: n for edge, n in counts.items() if "shared" in edge}
    figure = sheet(11.6, 4.9)
    axes = figure.add_subplot()
    shown = Counter({edge: n for edge, n in counts.items() if edge not in common})
    ways = paths(shown)
    draw_way(axes, ways)
    for edge, count in shown.items():
        arrow(axes, ways[edge], width(count), BOXES[edge[0]].colour)
    for box in BOXES.values():
        draw_box(axes, box)
    draw_legend(axes, sum(common.values()))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_xlim(BOXES["laws"].sides[0] - 0.1, BOXES["pictures"].sides[1] + 0.1)
    axes.set_ylim(-2.85, 2.3)
    return figure


def draw(work: workshop.Workshop) -> None:
    work.keep(picture(counted()))
