"""Pictures and pages of results: names of the code that draws them.

That code stands above. It enters itself here, and is imported when it is called.
"""

from importlib import import_module
from pathlib import Path

#: "module:name" of what draws, by the attribute of a result
ACCESSORS: dict[str, str] = {}


def accessor(name: str):
    """Code that an attribute of a result calls."""
    module, _, drawing = ACCESSORS[name].partition(":")
    return getattr(import_module(module), drawing)


class Celled:
    """A thing with a cell of its own in notebooks."""

    def _repr_html_(self) -> str:
        return accessor("cell")(self)


class Drawn(Celled):
    """Pictures and pages of a run or a sweep."""

    @property
    def plot(self):
        """Pictures, as `clearance plot` has them: `run.plot.orbit("B")`,
        `sweep.plot.map("period")`.
        """
        return accessor("plot")(self)

    def view(self, output: str | Path | None = None, **options) -> Path:
        """Write a page that moves, as `cl.view` does; options and errors are its."""
        return accessor("view")(self, output, **options)

    def report(self, output: str | Path, **options) -> Path:
        """Write a page that needs nothing else, as `cl.report` does; options and errors are its."""
        return accessor("report")(self, output, **options)
