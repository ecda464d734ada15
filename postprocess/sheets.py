"""Empty figures of matplotlib that take no settings from the working folder, which may be a
stranger's. Such settings name programs, and have LaTeX read the names that a file holds.
"""

import sys
from pathlib import Path

OF_THE_USER = "matplotlib" in sys.modules  # a program that imports it has settings of its own

import matplotlib  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.text import Text  # noqa: E402

if not OF_THE_USER and Path(matplotlib.matplotlib_fname()).absolute().parent == Path.cwd():
    matplotlib.rcdefaults()


class Sheet(Figure):
    """A figure whose texts are drawn by matplotlib itself, never by LaTeX.

    latex: texts may have been made for it.
    """

    latex = False

    def draw(self, renderer):
        for text in self.findobj(Text) if self.latex or _latex() else ():  # takes a while
            text.set_usetex(False)
        with matplotlib.rc_context({"text.usetex": False}):
            super().draw(renderer)


def _latex() -> bool:
    """True where settings have texts drawn by LaTeX."""
    return bool(matplotlib.rcParams["text.usetex"])


def sheet(width: float, height: float, kind: type[Sheet] = Sheet) -> Sheet:
    """An empty figure [inch], drawn without a screen."""
    with matplotlib.rc_context({"text.usetex": False}):
        figure = kind(figsize=(width, height), layout="constrained")
    figure.latex = _latex()
    FigureCanvasAgg(figure)
    return figure
