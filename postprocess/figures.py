"""What all pictures share: a sheet, lines whose peaks survive, labels with units, saving."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

#: most points drawn per line; of longer records each bin's smallest and largest value is drawn, so no peak is lost
POINTS = 20000
#: kinds of file a picture can be saved as
KINDS = (".png", ".pdf", ".svg")
#: units as they are printed
PRINTED = {"m/s2": "m/s²", "rad/s2": "rad/s²", "m3/s": "m³/s", "N m": "N m", "1": "-"}


def sheet(width: float, height: float) -> Figure:
    """An empty figure [inch], drawn without a screen."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: str | Path, dpi: float = 150) -> Path:
    """Write a picture; its folder is made. Raises ValueError for a kind of file it cannot be."""
    path = Path(path)
    if path.suffix.lower() not in KINDS:
        raise ValueError(f"picture {path}: its name must end in {', '.join(KINDS)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=dpi)
    return path


def with_units(text: str, units: str) -> str:
    """An axis label: "gap [m]"."""
    return f"{text} [{PRINTED.get(units, units)}]"


def line(axes, x: np.ndarray, values: np.ndarray, **style) -> None:
    """A curve whose peaks survive thinning."""
    width = 2 * len(values) // POINTS
    if width > 1:
        bins = values[: len(values) // width * width].reshape(-1, width)
        start = np.arange(len(bins)) * width
        kept = np.sort(np.concatenate([start + bins.argmin(axis=1), start + bins.argmax(axis=1)]))
        x, values = x[kept], values[kept]
    axes.plot(x, values, **{"lw": 0.8, **style})


def finish(axes, ylabel: str, xlabel: str = "time [s]") -> None:
    """Labels, grid, and a legend above the axes where curves have names."""
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.grid(alpha=0.3)
    names = axes.get_legend_handles_labels()[1]
    if names:
        axes.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(names), frameon=False)
