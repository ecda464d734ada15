"""Pictures of the gallery: the figure that the last line of a block returns."""

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst


def pictures(block, block_vars: dict, gallery_conf: dict) -> str:
    """Save the figure of a block; text that shows it, empty where there is none."""
    names = block_vars["example_globals"]
    figure, names["___"] = names.get("___"), None
    if not isinstance(figure, Figure):
        return ""
    path = next(block_vars["image_path_iterator"])
    figure.savefig(path, dpi=100, format="png")
    return figure_rst([path], gallery_conf["src_dir"])
