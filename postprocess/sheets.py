"""Empty figures of matplotlib that take no settings from the working folder, which may be a
stranger's. Such settings name programs, and have LaTeX read the names that a file holds.
"""

import sys
import warnings
from pathlib import Path

OF_THE_USER = "matplotlib" in sys.modules  # a program that imports it has settings of its own
IN_SPACE = "mpl_toolkits.mplot3d"  # axes that no picture has

import matplotlib  # noqa: E402
import matplotlib._docstring as help_texts  # noqa: E402
from matplotlib.artist import Artist  # noqa: E402

if "clearance.commands" in sys.modules and not OF_THE_USER:
    # A process of ours reads no help of matplotlib, whose texts take a third of its import.
    for kind in (type(help_texts.interpd), help_texts.Substitution):
        kind.__call__ = lambda self, described: described
    Artist._update_set_signature_and_docstring = classmethod(lambda kind: None)
    sys.modules[IN_SPACE] = None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that there are no axes in space
        import matplotlib.figure
    del sys.modules[IN_SPACE]

from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.layout_engine import ConstrainedLayoutEngine  # noqa: E402
from matplotlib.text import Text  # noqa: E402
from matplotlib.transforms import Bbox  # noqa: E402

if not OF_THE_USER and Path(matplotlib.matplotlib_fname()).absolute().parent == Path.cwd():
    matplotlib.rcdefaults()


class Layout(ConstrainedLayoutEngine):
    """Matplotlib's layout, which measures texts around axes twice; here the second look takes the
    margins of the first. Axes of a fixed aspect are measured twice.
    """

    def execute(self, figure):
        free = [a for a in figure.axes if a.get_aspect() == "auto" and a.get_box_aspect() is None]
        try:
            for axes in free:
                axes.get_tightbbox = _measured_once(axes)
            super().execute(figure)
        finally:
            for axes in free:
                del axes.get_tightbbox


def _measured_once(axes):
    """The box around axes and their texts, whose margins are measured at the first call."""
    measure, margins = axes.get_tightbbox, []

    def box(*arguments, **options):
        if not margins:
            around = measure(*arguments, **options)
            if around is None:
                return None
            margins.append(around.extents - axes.bbox.extents)
        return Bbox.from_extents(*(axes.bbox.extents + margins[0]))

    return box


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
        figure = kind(figsize=(width, height), layout=Layout())
    figure.latex = _latex()
    FigureCanvasAgg(figure)
    return figure
