"""Pictures of the gallery: the figure that the last line of a block returns, and thumbnails."""

from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.image import imread, imsave
from sphinx_gallery.scrapers import figure_rst

#: of a thumbnail: breadth and height [inch], pixels an inch, how much wider its lines are
SIZE, DENSITY, WIDER = (4.0, 2.8), 100, 1.8


def pictures(block, block_vars: dict, gallery_conf: dict) -> str:
    """Save the figure of a block; text that shows it, empty where there is none."""
    names = block_vars["example_globals"]
    figure, names["___"] = names.get("___"), None
    if not isinstance(figure, Figure):
        return ""
    path = Path(next(block_vars["image_path_iterator"]))
    figure.savefig(path, dpi=100, format="png")
    if path.stem.endswith("_001"):
        small(figure, path.with_name(path.stem.replace("_001", "_small.png")))
    return figure_rst([str(path)], gallery_conf["src_dir"])


def small(figure: Figure, path: Path) -> None:
    """The first axes of a figure without texts, in wide lines."""
    figure.set_layout_engine("none")
    first, *others = figure.axes
    for axes in others:
        axes.remove()
    for artist in (*figure.texts, *first.texts, *figure.legends, first.get_legend()):
        if artist is not None:
            artist.remove()
    if figure.get_suptitle():
        figure.suptitle("")
    first.set_title("")
    first.set_axis_off()
    for line in first.lines:
        line.set_linewidth(WIDER * line.get_linewidth())
    figure.set_size_inches(*SIZE)
    first.set_position((0.02, 0.02, 0.96, 0.96))
    figure.savefig(path, dpi=DENSITY, format="png")


def put_thumbnails(app) -> None:
    """Handler of Sphinx, after the gallery is made: small pictures in the place of thumbnails."""
    for path in Path(app.srcdir, "docs", "made", "gallery").rglob("*_small.png"):
        thumbnail = path.parent / "thumb" / path.name.replace("_small", "_thumb")
        imsave(thumbnail, imread(path))
