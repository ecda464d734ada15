"""clearance: tribodynamics of planar mechanisms whose joints have clearance, lubricant and
friction.
"""

import sys
from os.path import basename, dirname

if [*map(basename, sys.orig_argv[1:2])] == ["clearance"]:  # the command, which imports for a while
    from clearance.run import interrupts

    interrupts.beginning()

from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder

from clearance.values.accessors import ACCESSORS, stated
from clearance.version import VERSION

__version__ = VERSION

_MODULES = {
    "elements": "clearance.elements",
    "film": "clearance.film",
    "films": "clearance.film.names",
    "laws": "clearance.laws",
}
#: public name -> its module, and its name there
_LAZY = {name: path for name, path in stated(__file__).items() if name not in _MODULES}

#: names that only authors of cases need: not among those to choose from
_ASIDE = ("crank_drive", "joint_friction_law", "one_of", "pad_table")

ACCESSORS |= {
    "plot": "clearance.postprocess.pictures:Pictures",
    "report": "clearance.postprocess.report:report",
    "cell": "clearance.postprocess.cells:cell",
    "live": "clearance.postprocess.live:live",
    "ideal_turn": "clearance.simulation:ideal_turn",
    "to_csv": "clearance.postprocess.tables:to_csv",
    "to_mat": "clearance.postprocess.tables:to_mat",
    "to_latex": "clearance.postprocess.tables:to_latex",
    "metrics": "clearance.metrics.metrics:metrics",
    "citations": "clearance.postprocess.citations:citations",
    "view": "clearance.postprocess.view:view",
    "plot_fit": "clearance.postprocess.scene_fits:picture",
    "plot_optimum": "clearance.postprocess.optima:picture",
    "report_optimum": "clearance.postprocess.optima:report",
    "report_fit": "clearance.postprocess.scene_fits:report",
}


def __getattr__(name: str):
    """A public name, whose module is imported on first use: a command needs few of them."""
    if name in _LAZY:
        module, there = _LAZY[name]
        value = getattr(import_module(module), there)
    elif name in _MODULES:
        value = import_module(_MODULES[name])
    elif f"{__name__}.{name}" in _MOVED:
        return import_module(f"{__name__}.{name}")
    elif name == "__all__":
        groups = import_module("clearance.laws"), import_module("clearance.elements")
        value = [*(n for g in groups for n in g.__all__), *_LAZY, *_MODULES.keys() - {"film"}]
    elif name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    else:
        value = _of_groups(name)
    globals()[name] = value
    return value


def _of_groups(name: str):
    """A law or an element."""
    for group in map(import_module, ("clearance.laws", "clearance.elements")):
        if name in group.__all__:
            return getattr(group, name)
    from clearance.values.checks import absent

    return absent(__name__, __getattr__("__all__"))(name)


def __dir__() -> list[str]:
    """Names to choose from, those that are imported on first use too; laws are listed in
    `clearance.laws` and `clearance.films`.
    """
    laws, films = import_module("clearance.laws"), import_module("clearance.film.names")
    aside = {*laws.__all__, *(f"{n}_film" for n in films.__all__), *_ASIDE}
    return [*(n for n in __getattr__("__all__") if n not in aside), "__version__"]


#: paths of before, and where these modules are now
_MOVED = {
    "clearance.body": "clearance.elements.body",
    "clearance.checks": "clearance.values.checks",
    "clearance.choices": "clearance.scene.joint_options",
    "clearance.films": "clearance.film.names",
    "clearance.observers": "clearance.run.observers",
    "clearance.options": "clearance.run.options",
    "clearance.quantities": "clearance.elements.quantities",
    "clearance.units": "clearance.values.units",
    "clearance.identify.bench": "clearance.paper_figures.ball_joint_bench",
    "clearance.identify.response": "clearance.paper_figures.ball_joint_response",
    "clearance.identify.studies": "clearance.paper_figures.ball_joint_studies",
    "clearance.identify.variants": "clearance.paper_figures.ball_joint_variants",
}


#: packages that lie beside this one in a checkout
_FOLDERS = tuple(f"clearance.{n}" for n in ("cases", "postprocess", "paper_figures"))


class _Moved:
    """Loads a module by its path of before."""

    @staticmethod
    def create_module(spec):
        return None

    @staticmethod
    def exec_module(module):
        sys.modules[module.__name__] = import_module(_MOVED[module.__name__])


class _Beside:
    """Finds the packages that lie beside this one in a checkout, and inside it once installed;
    modules by their paths of before.
    """

    @staticmethod
    def find_spec(name: str, path=None, target=None):
        if name in _FOLDERS:
            return PathFinder.find_spec(name, [dirname(__file__), dirname(dirname(__file__))])
        return ModuleSpec(name, _Moved) if name in _MOVED else None


# before the finder of another checkout that is installed editable
sys.meta_path.insert(0, _Beside)
