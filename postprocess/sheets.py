"""Empty figures of matplotlib that take no settings from the working folder, which may be a
stranger's. Such settings name programs, and have LaTeX read the names that a file holds.
"""

import sys
import warnings
from contextlib import contextmanager
from pathlib import Path

OF_THE_USER = "matplotlib" in sys.modules  # a program that imports it has settings of its own
PLAIN = "mpl_toolkits.mplot3d"  # what pictures in the plane need nothing of

import matplotlib  # noqa: E402
import matplotlib._docstring  # noqa: E402
import matplotlib.artist  # noqa: E402


@contextmanager
def _briefly():
    """Import matplotlib without its axes in space and the texts of its help: a third less time."""
    artist, docs = matplotlib.artist.Artist, matplotlib._docstring
    kinds = {type(docs.interpd), docs.Substitution}
    before = {kind: kind.__call__ for kind in kinds}
    explained = artist.__dict__.get("_update_set_signature_and_docstring")
    sys.modules[PLAIN] = None
    for kind in kinds:
        kind.__call__ = lambda self, described: described
    if explained:
        artist._update_set_signature_and_docstring = classmethod(lambda cls: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that there are no axes in space
            yield
    finally:
        del sys.modules[PLAIN]
        for kind, call in before.items():
            kind.__call__ = call
        if explained:
            artist._update_set_signature_and_docstring = explained


if "clearance.commands" in sys.modules and not OF_THE_USER:  # a process of ours
    with _briefly():
        import matplotlib.figure

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
