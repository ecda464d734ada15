"""Empty figures of matplotlib that take no settings from the working folder, which may be a
stranger's. Such settings name programs, and have LaTeX read the names that a file holds.
"""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
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


#: methods of an axis that its `_Ticks` takes over, where matplotlib has them
OF_TICKS = ("_update_ticks", "_get_ticklabel_bboxes")


class _Ticks:
    """Ticks of one axis, and the boxes of their labels, which matplotlib lays out nine times a
    picture. Here it does so where the ends of the axis or its place have changed.
    """

    def __init__(self, axis):
        self.lay, self.measure = axis._update_ticks, axis._get_ticklabel_bboxes
        self.axis, self.where, self.laid, self.boxes = axis, None, [], None

    def ticks(self) -> list:
        """Those that are drawn."""
        axis = self.axis
        where = *axis.get_view_interval(), *axis.axes.bbox.extents
        if where != self.where:
            self.where, self.laid, self.boxes = where, self.lay(), None
        return self.laid

    def around(self, ticks: list, renderer=None) -> tuple[list, list]:
        """Boxes of the labels of ticks."""
        if ticks is not self.laid:
            return self.measure(ticks, renderer)
        if self.boxes is None:
            self.boxes = self.measure(ticks, renderer)
        return self.boxes


@contextmanager
def _ticks_laid_once(figure: Figure) -> Iterator[None]:
    """Lay out ticks of linear and logarithmic axes once for each place of their axes."""
    sides = [side for axes in figure.axes for side in (axes.xaxis, axes.yaxis)]
    sides = [
        s for s in sides if hasattr(s, "_update_ticks") and hasattr(s, "_get_ticklabel_bboxes")
    ]
    try:
        for side in sides:
            laid = _Ticks(side)
            side._update_ticks, side._get_ticklabel_bboxes = laid.ticks, laid.around
        yield
    finally:
        for side in sides:
            for name in OF_TICKS:
                vars(side).pop(name, None)


class Sheet(Figure):
    """A figure whose texts are drawn by matplotlib itself, never by LaTeX.

    latex: texts may have been made for it.
    """

    latex = False

    def draw(self, renderer):
        for text in self.findobj(Text) if self.latex or _latex() else ():  # takes a while
            text.set_usetex(False)
        with matplotlib.rc_context({"text.usetex": False}), _ticks_laid_once(self):
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
