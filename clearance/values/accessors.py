"""Names of code that is imported when it is called: what draws pictures and pages of results, and
what packages have from their modules.

Code that draws stands above, and enters itself here.
"""

import re
from importlib import import_module
from pathlib import Path

#: "module:name" of what draws, by the attribute of a result
ACCESSORS: dict[str, str] = {}


def accessor(name: str):
    """Code that an attribute of a result calls."""
    module, _, drawing = ACCESSORS[name].partition(":")
    return getattr(import_module(module), drawing)


def stated(file: str) -> dict[str, tuple[str, str]]:
    """Names that the stub beside a module states, `from MODULE import NAME as NAME` one a line, for
    editors too: module, and name there.
    """
    stub = Path(file).with_suffix(".pyi").read_text(encoding="utf-8")
    lines = re.findall(r"^from (\S+) import (\w+) as (\w+)$", stub, re.MULTILINE)
    return {name: (module, there) for module, there, name in lines}


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
