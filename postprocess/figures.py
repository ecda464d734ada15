"""Shared parts of pictures: a sheet, lines whose peaks survive, labels with units, saving."""

import io
import shutil
import subprocess
from collections.abc import Collection
from functools import partial
from pathlib import Path

# isort: off
# before matplotlib is imported
from clearance.postprocess.sheets import Sheet as Plain, sheet as sheet_of

# isort: on
import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator, ScalarFormatter

from clearance.files.locks import replacing

#: most points drawn per line; of longer records each bin's smallest and largest value is drawn, so
#: no peak is lost
POINTS = 20000
#: of pixels, 0 to 9; 6 is usual, takes half as long again and leaves 6 % less
COMPRESSION = 3
SCREEN = 90  # dots per inch of a figure that a notebook shows
#: kinds of file a picture can be saved as
KINDS = (".png", ".pdf", ".svg")
#: breadth of an entry of a small legend: its stroke and each of its characters [inch]
ENTRY = (0.55, 0.07)
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: powers of ten from which on, down and up, numbers of an axis are multiples of them
POWERS = (-3, 5)
#: units that take a prefix in place of a power, and the prefixes
PREFIXED = ("m", "s", "N", "N m", "Pa", "J", "W")
PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 3: "k", 6: "M", 9: "G"}
#: units as they are printed
PRINTED = {"m/s2": "m/s²", "rad/s2": "rad/s²", "m3/s": "m³/s", "N m": "N m", "1": "-"}


class Sheet(Plain):
    """A figure that notebooks show."""

    def _repr_png_(self) -> bytes:
        image = io.BytesIO()
        self.savefig(image, dpi=SCREEN, format="png")
        return image.getvalue()


def sheet(width: float, height: float) -> Sheet:
    """An empty figure [inch], drawn without a screen."""
    return sheet_of(width, height, Sheet)


def save(figure: Figure, path: str | Path | None, dpi: float = 150) -> Path | Figure:
    """Write a picture, completely or not at all; its folder is made.

    Without a path the figure itself is returned.

    Raises ValueError for a kind of file that a picture cannot be.
    """
    if path is None:
        powers_into_labels(figure)
        return figure
    path = Path(path)
    if path.suffix.lower() not in KINDS:
        raise ValueError(f"picture {path}: its name must end in {', '.join(KINDS)}")
    powers_into_labels(figure)
    with replacing(path) as temporary:
        drawn_once(figure, temporary, dpi, path.suffix[1:].lower())
    return path


def drawn_once(figure: Figure, path: Path, dpi: float, kind: str) -> None:
    """Write a picture. `savefig` would draw twice, the first time for the layout only."""
    figure.set_dpi(dpi)
    if kind == "png":
        figure.canvas.print_png(path, pil_kwargs={"compress_level": COMPRESSION})
        return
    before = figure.canvas
    try:
        getattr(get_registered_canvas_class(kind)(figure), f"print_{kind}")(path)
    finally:
        figure.set_canvas(before)


def powers_into_labels(figure: Figure) -> None:
    """Put the power of ten of each linear axis into its label, "energy [µJ]", "share [10⁻⁶]".

    Beside the axis it would lie over legends and titles. Axes that share their scale have one
    power.
    Numbers are never printed as a difference from another one.
    """
    sides = [side for axes in figure.axes for side in (axes.xaxis, axes.yaxis)]
    shared: dict[int, list] = {}
    for side in sides:
        formatter = side.get_major_formatter()
        if type(formatter) is ScalarFormatter:  # none that is scaled already
            shared.setdefault(id(formatter), []).append(side)
    for group in shared.values():
        group[0].get_major_formatter().set_useOffset(False)
        largest = np.abs(group[0].get_view_interval()).max()
        power = int(np.floor(np.log10(largest))) if np.isfinite(largest) and largest > 0.0 else 0
        named = [side for side in group if side.get_label_text()]
        if POWERS[0] < power < POWERS[1] or not named:
            continue
        if all(_parts(side.get_label_text())[1] in PREFIXED for side in named):
            power -= power % 3
        for side in named:
            side.set_label_text(_with_power(side.get_label_text(), power))
        group[0].set_major_formatter(Scaled(power))


class Scaled(ScalarFormatter):
    """Ticks as multiples of a power of ten, with as many decimals as they need."""

    def __init__(self, power: int):
        super().__init__(useOffset=False)
        self.set_scientific(False)
        self.size = 10.0**power

    def set_locs(self, locs):
        super().set_locs(np.asarray(locs) / self.size)

    def __call__(self, x, pos=None):
        return super().__call__(x / self.size, pos)


def _with_power(label: str, power: int) -> str:
    """A label whose last units have a prefix or a power of ten before them."""
    before, units, after = _parts(label)
    text = "10" + str(power).translate(SUPERSCRIPTS)
    if units in PREFIXED and power in PREFIXES:
        text = PREFIXES[power] + units
    elif units not in ("-", "1", ""):
        text = f"{text} {units}"
    return f"{before}[{text}]{after}"


def _parts(label: str) -> tuple[str, str, str]:
    """A label before its last units, these, and what follows."""
    before, bracket, rest = label.rpartition("[")
    units, _, after = rest.partition("]")
    return (
        (before, units.replace("\N{NO-BREAK SPACE}", " "), after)
        if bracket
        else (f"{label} ", "", "")
    )


def with_units(text: str, units: str) -> str:
    """An axis label: "gap [m]"."""
    return f"{text} [{PRINTED.get(units, units)}]"


def line(axes, x: np.ndarray, values: np.ndarray, **style) -> None:
    """A curve whose peaks survive thinning."""
    width = 2 * len(values) // POINTS
    if width > 1:
        bins = values[: len(values) // width * width].reshape(-1, width)
        start = np.arange(len(bins)) * width
        places = np.sort(np.concatenate([start + bins.argmin(axis=1), start + bins.argmax(axis=1)]))
        x, values = x[places], values[places]
    axes.plot(x, values, **{"lw": 0.8, **style})


def finish(axes, ylabel: str, xlabel: str = "time [s]", legend: bool = True) -> None:
    """Labels, grid, and a legend above the axes where curves have names and one is required."""
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.grid(alpha=0.3)
    if legend:
        legend_above(axes)


def legend_above(axes, *others) -> None:
    """Legend of the named curves of axes, and of `others` below them, above it in as many rows as
    its breadth needs.
    """
    handles, names = _named(axes, *others)
    if names:
        page, share = axes.figure, axes.get_subplotspec().get_position(axes.figure).width
        # margins of the layout are narrower than a grid's own
        room = 1.1 * share * page.bbox.width / page.dpi
        fitting = (n for n in range(len(names), 1, -1) if _breadth(names, n) <= room)
        style = {
            "fontsize": "small",
            "loc": "lower left",
            "bbox_to_anchor": (0.0, 1.0),
            "frameon": False,
        }
        axes.legend(handles, names, ncols=next(fitting, 1), **style)


def _breadth(names: list[str], columns: int) -> float:
    """Breadth of a small legend, its names in columns one below the other [inch]."""
    return sum(
        ENTRY[0] + ENTRY[1] * max(map(len, part))
        for part in np.array_split(np.array(names), columns)
    )


def _named(axes, *others) -> tuple[list, list[str]]:
    """Handles and names of the curves of axes, and of those of others that have further names."""
    handles, names = axes.get_legend_handles_labels()
    for other in others:
        for handle, name in zip(*other.get_legend_handles_labels(), strict=True):
            if name not in names:
                handles, names = [*handles, handle], [*names, name]
    return handles, names


#: strokes that stay apart in grey: each darker or lighter than its neighbours, and dashed
#: differently
STROKES = (
    {"color": "#000000", "ls": "-"},
    {"color": "#d55e00", "ls": "-"},
    {"color": "#56b4e9", "ls": "-"},
    {"color": "#7b3294", "ls": "--"},
    {"color": "#e0a800", "ls": "--"},
    {"color": "#00724f", "ls": "-."},
)
MARKERS = "os^vDPX*"
#: cells along each axis in which a path's points are not distinguished: finer than a printed dot
CELLS = 4000


def stroke(i: int, count: int) -> dict:
    """Colour and dashes of curve i of `count`; more curves than strokes run through a colour
    map.
    """
    return (
        dict(STROKES[i])
        if count <= len(STROKES)
        else {"color": colormaps["viridis"](0.95 * i / (count - 1))}
    )


def hexadecimal(colour: str) -> str:
    """A colour of a picture as pages have it: "tab:blue" is "#1f77b4"."""
    return to_hex(colour)


def marker(i: int) -> str:
    return MARKERS[i % len(MARKERS)]


def trajectory(axes, x: np.ndarray, y: np.ndarray, **style) -> None:
    """A path in the plane, open where y is nan; of points in one cell and strokes between two cells
    one is drawn.
    """
    away = (CELLS + 1) ** 2
    cell = np.where(np.isnan(y), away, _cells(x) * (CELLS + 1) + _cells(y))
    moved = np.flatnonzero(np.diff(cell, prepend=-1))
    x, y, cell = x[moved], y[moved], cell[moved]
    if len(x) > POINTS:
        strokes = np.unique(cell[:-1] * (away + 1) + cell[1:], return_index=True)[1]
        new = np.zeros(len(x) - 1, bool)
        new[strokes] = True
        ends = np.flatnonzero(np.append(new, False) | np.append(False, new))
        breaks = np.flatnonzero(~new[ends[:-1]]) + 1
        x, y = np.insert(x[ends], breaks, np.nan), np.insert(y[ends], breaks, np.nan)
    axes.plot(x, y, **{"lw": 0.7, **style})


def _cells(values: np.ndarray) -> np.ndarray:
    """Cell along an axis in which each value lies, the first one for nan."""
    finite = ~np.isnan(values)
    if not finite.any():
        return np.zeros(len(values), np.int64)
    low, high = values[finite].min(), values[finite].max()
    return np.rint((np.where(finite, values, low) - low) / ((high - low) or 1.0) * CELLS).astype(
        np.int64
    )


def degrees(axes, most: int = 9) -> None:
    """Ticks of an axis of angles at parts or multiples of a turn."""
    low, high = axes.get_xlim()
    step = next(
        s for s in (15, 30, 45, 90, 180, *(360 * 2**k for k in range(40))) if high - low <= most * s
    )
    axes.set_xticks(np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step)


def note(axes, text: str) -> None:
    """Write the reason into an empty panel."""
    axes.text(
        0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, color="0.3", wrap=True
    )
    axes.set_xticks([])
    axes.set_yticks([])


def legend_below(figure: Figure, *axes) -> None:
    """One legend for the entire page, under its panels, in up to three columns that fit; none where
    nothing is named.
    """
    handles, names = _named(*axes)
    if names:
        columns = min(_columns(figure, names), 3)
        figure.legend(handles, names, loc="outside lower center", ncols=columns, frameon=False)


def _columns(figure: Figure, names: Collection[str]) -> int:
    """Columns of a legend that fit the page, as many as it has names at most."""
    fit = int(figure.get_size_inches()[0] / (0.7 + 0.1 * max(map(len, names))))
    return min(max(fit, 1), len(names))


#: lightness rises along it, so that it reads in grey too
COLOURS = "viridis"
#: the same without its lightest part, which lines on white paper lack contrast in
OF_LINES = ListedColormap(colormaps[COLOURS](np.linspace(0.0, 0.85, 256)))
#: largest over smallest value from which colours and axes are logarithmic
FAR_APART = 30.0
#: most integers that have a colour each
MOST_COLOURS = 16


def wide(values: np.ndarray, ratio: float = FAR_APART) -> bool:
    """True where values are positive and far enough apart for a logarithmic scale."""
    values = values[np.isfinite(values)]
    return bool(values.size and values.min() > 0.0 and values.max() >= ratio * values.min())


def scale(values: np.ndarray, log: bool, integers: bool = False) -> Normalize:
    """Norm from the finite values of a map to its colours: evenly, by their logarithm, or a colour
    an integer.
    """
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    if integers and values.size and high - low < MOST_COLOURS:
        return BoundaryNorm(np.arange(low - 0.5, high + 1.0), 256)
    return (LogNorm if log else Normalize)(low, high)


def cells(axes, edges: tuple[np.ndarray, np.ndarray], values: np.ndarray, norm: Normalize):
    """Coloured cells of values (y, x) between edges (x + 1,) and (y + 1,); what is not finite stays
    blank.
    """
    return axes.pcolormesh(
        *edges, np.ma.masked_invalid(values), norm=norm, cmap=COLOURS, rasterized=True
    )


def levels(low: float, high: float, most: int = 24) -> np.ndarray:
    """Round numbers that enclose a range, where the colours of a map change."""
    return MaxNLocator(most).tick_values(low, max(high, low + 1e-9))


def marked(axes, edges: tuple[np.ndarray, np.ndarray], where: np.ndarray, style: dict) -> None:
    """Cells (y, x) that are hatched instead of coloured."""
    x, y = edges
    j, i = np.nonzero(where)
    corners = np.array([(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])])
    boxes = np.concatenate([corners, corners[:1]]).transpose(2, 0, 1)  # (cells, corners, x and y)
    codes = [Outline.MOVETO, *[Outline.LINETO] * 3, Outline.CLOSEPOLY] * len(boxes)
    outline = Outline(boxes.reshape(-1, 2), codes)  # one of all: each hatched one takes 2 ms
    axes.add_artist(PathPatch(outline, lw=0.0, **style))


def colour_bar(figure: Figure, mesh, axes, label: str, **more) -> None:
    """The scale of a map beside its axes; integers have a tick each, more: see
    Figure.colorbar.
    """
    norm = mesh.norm
    if isinstance(norm, BoundaryNorm):
        more = {"ticks": norm.boundaries[:-1] + 0.5} | more
    bar = figure.colorbar(mesh, ax=axes, label=label, **more)
    if isinstance(norm, LogNorm):
        plain_decades(bar.ax.yaxis, norm.vmin, norm.vmax)
    bar.ax.tick_params(labelsize="small")


def bar_of_values(figure: Figure, axes, values: np.ndarray, log: bool, label: str, **more) -> list:
    """Colours (values,) of curves that belong to numbers, and the bar that distinguishes them;
    more: of the bar.
    """
    norm = (LogNorm if log else Normalize)(values.min(), values.max())
    colour_bar(figure, ScalarMappable(norm, OF_LINES), axes, label, **{"aspect": 40} | more)
    return list(OF_LINES(norm(values)))


def plain_decades(axis, low: float, high: float, most: int = 10) -> None:
    """Ticks of a logarithmic axis as plain numbers: 0.05, 0.1, 0.2; not many more than `most`."""
    steps = next(
        (s for s in ((1.0, 2.0, 5.0), (1.0, 3.0)) if np.log10(high / low) * len(s) <= most), (1.0,)
    )
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))


def border(axes, at: tuple[np.ndarray, np.ndarray], values: np.ndarray, level: float, style: dict):
    """The line on a map of values (y, x) where they pass a level, between places along x and y."""
    colour, dashes = style["color"], style["ls"]
    drawn = axes.contour(
        *at, np.ma.masked_invalid(values), [level], colors=colour, linestyles=dashes
    )
    halo = withStroke(linewidth=style["lw"] + 1.4, foreground="white")
    drawn.set(linewidths=style["lw"], path_effects=[halo])


def legend_of_marks(figure: Figure, marks: dict[str, dict]) -> None:
    """Legend of hatched cells and of lines, under the page, in as many columns as fit."""
    if marks:
        kinds = {True: partial(Line2D, (), ()), False: Patch}
        handles = [kinds["ls" in style](label=n, **style) for n, style in marks.items()]
        handles.sort(key=lambda handle: isinstance(handle, Patch))
        position, columns = "outside lower center", _columns(figure, marks)
        figure.legend(handles=handles, loc=position, ncols=columns, frameon=False)


#: kinds of file an animation can be saved as, and the largest frame rate [1/s] of each
FILMS = {".gif": 50.0, ".mp4": 240.0}


def check_film(path: str | Path, fps: float) -> None:
    """Raises ValueError for an animation of another kind, at a rate it cannot have, or an .mp4
    without ffmpeg.
    """
    kind = Path(path).suffix.lower()
    if kind not in FILMS:
        raise ValueError(f"animation {path}: its name must end in {' or '.join(FILMS)}")
    if not 0.0 < fps <= FILMS[kind]:
        raise ValueError(f"fps must lie in (0, {FILMS[kind]:g}] for a {kind}, got {fps!r}")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise ValueError(
            f"animation {path}: .mp4 is written by ffmpeg, which is not installed; install it or "
            f"use .gif"
        )


def save_film(figure: Figure, path: str | Path, fps: float, frames: int, show, moving) -> Path:
    """Write an animation whose frame k is set by `show(k)`, under a temporary name until it is
    entire.

    moving: the artists that frames differ in; in a .gif only they are drawn anew. Raises ValueError
        as `check_film`, RuntimeError where ffmpeg does not write it.
    """
    check_film(path, fps)
    path = Path(path)
    with replacing(path) as partial:
        (_save_mp4 if path.suffix.lower() == ".mp4" else _save_gif)(
            figure, partial, fps, frames, show, moving
        )
    return path


def _save_mp4(figure: Figure, path: Path, fps: float, frames: int, show, _moving) -> None:
    from matplotlib.animation import FFMpegWriter

    program = {"animation.ffmpeg_path": shutil.which("ffmpeg")}
    writer = FFMpegWriter(fps=fps, extra_args=["-f", "mp4"])
    try:
        with rc_context(program), writer.saving(figure, str(path), figure.dpi):
            for k in range(frames):
                show(k)
                writer.grab_frame()
    except subprocess.CalledProcessError as error:
        reason = f"{error.stderr or ''}".strip()[-300:]
        raise RuntimeError(f"ffmpeg ended with status {error.returncode}: {reason}") from None


def _save_gif(figure: Figure, path: Path, fps: float, frames: int, show, moving) -> None:
    """All frames have the commonest colours of the first one, so that what does not move is the
    same in all of them.
    """
    from PIL import Image

    canvas, moving = figure.canvas, sorted(moving, key=lambda a: a.get_zorder())
    for artist in moving:
        artist.set_animated(True)
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)

    def frame(k: int):
        show(k)
        canvas.restore_region(still)
        for artist in moving:
            artist.draw(canvas.get_renderer())
        return Image.frombuffer("RGBA", canvas.get_width_height(), canvas.buffer_rgba()).convert(
            "RGB"
        )

    width, height = canvas.get_width_height()
    commonest: dict[tuple, tuple] = {}
    for _, colour in sorted(frame(0).getcolors(width * height), reverse=True):
        # of shades that Pillow mixes up, one
        commonest.setdefault(tuple(part // 8 for part in colour), colour)
    palette = Image.new("P", (1, 1))
    palette.putpalette([part for colour in list(commonest.values())[:256] for part in colour])
    pictures = (frame(k).quantize(palette=palette, dither=Image.Dither.NONE) for k in range(frames))
    next(pictures).save(
        path,
        format="GIF",
        save_all=True,
        append_images=pictures,
        duration=round(1000.0 / fps),
        loop=0,
    )
