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
from typing import TYPE_CHECKING

from clearance.values.accessors import ACCESSORS
from clearance.version import VERSION

if TYPE_CHECKING:  # for editors: names of laws and elements, modules, and what _LAZY has
    # isort: off
    from clearance.laws import *  # noqa: F403
    from clearance.elements import *  # noqa: F403
    from clearance import elements as elements, film as film, laws as laws
    from clearance.film import names as films  # noqa: F401

    from clearance.elements.body import Body as Body, Point as Point, ground as ground
    from clearance.film.bearing import (
        Bearing as Bearing,
        FilmSolution as FilmSolution,
        Groove as Groove,
    )
    from clearance.film.coefficients import film_coefficients as film_coefficients
    from clearance.film.elastic import elastic_film as elastic_film
    from clearance.film.online import (
        conserving_film as conserving_film,
        fast_film as fast_film,
        fem_film as fem_film,
    )
    from clearance.film.pad_law import pad_film as pad_table  # noqa: F401
    from clearance.film.tabulated import table_film as table_film
    from clearance.laws.materials import (
        HeatBalance as HeatBalance,
        Lubricant as Lubricant,
        Material as Material,
        steel as steel,
    )
    from clearance.laws.oils import oil as oil, oil_heat as oil_heat
    from clearance.results.run_warning import RunWarning as RunWarning
    from clearance.scene.joint_options import JointOptions as JointOptions
    from clearance.scene.law_names import (
        crank_drive as crank_drive,
        joint_friction_law as joint_friction_law,
        one_of as one_of,
    )
    from clearance.scene.scene import Scene as Scene
    from clearance.values.fit_class import fit_class as fit_class
    from clearance.values.units import (
        cP as cP,
        degree as degree,
        mm as mm,
        rpm as rpm,
        um as um,
    )

    from clearance.scene.catalogue import load_case as load_case

    from clearance.motions.chaos import statistics as statistics
    from clearance.postprocess.pictures import plot as plot
    from clearance.metrics.assumptions import assumptions as assumptions
    from clearance.film.solvers import solve_film as solve_film
    from clearance.motions.inverse import inverse_dynamics as inverse_dynamics
    from clearance.laws.outline import worn as worn
    from clearance.motions.follow import follow as follow

    from clearance.motions.maps import NotPeriodic as NotPeriodic

    from clearance.motions.steady import steady as steady
    from clearance.postprocess.measured import compare as compare
    from clearance.exporting.export import export as export
    from clearance.identify.designs import optimize as optimize
    from clearance.identify.scene_parameters import fit as fit
    from clearance.postprocess.report import report as report
    from clearance.postprocess.view import view as view
    from clearance.run.force_hole import hole_check as hole_check
    from clearance.studies.benchmark.problems import benchmark as benchmark

    from clearance.run.again import again as again

    from clearance.results.result import Result as Result, open_result as open_result
    from clearance.simulation import (
        NotReached as NotReached,
        SimulationError as SimulationError,
        simulate as simulate,
    )
    from clearance.sweeping.chance import scatter as scatter
    from clearance.sweeping.dataset import dataset as dataset
    from clearance.sweeping.sweep import SweepError as SweepError, sweep as sweep
    from clearance.sweeping.index import Sweep as Sweep, open_sweep as open_sweep
    from clearance.sweeping.points import grid as grid, sampled as sampled, zipped as zipped
    from clearance.sweeping.scatter import open_scatter as open_scatter
    from clearance.wearing.life import wear as wear
    from clearance.wearing.life_record import Life as Life
    # isort: on

__version__ = VERSION

_LAZY = {
    "Body": "clearance.elements.body",
    "Point": "clearance.elements.body",
    "ground": "clearance.elements.body",
    "Bearing": "clearance.film.bearing",
    "FilmSolution": "clearance.film.bearing",
    "Groove": "clearance.film.bearing",
    "film_coefficients": "clearance.film.coefficients",
    "conserving_film": "clearance.film.online",
    "elastic_film": "clearance.film.elastic",
    "fast_film": "clearance.film.online",
    "fem_film": "clearance.film.online",
    "pad_table": "clearance.film.pad_law",
    "table_film": "clearance.film.tabulated",
    "HeatBalance": "clearance.laws.materials",
    "Lubricant": "clearance.laws.materials",
    "Material": "clearance.laws.materials",
    "steel": "clearance.laws.materials",
    "oil": "clearance.laws.oils",
    "oil_heat": "clearance.laws.oils",
    "RunWarning": "clearance.results.run_warning",
    "JointOptions": "clearance.scene.joint_options",
    "crank_drive": "clearance.scene.law_names",
    "joint_friction_law": "clearance.scene.law_names",
    "one_of": "clearance.scene.law_names",
    "Scene": "clearance.scene.scene",
    "fit_class": "clearance.values.fit_class",
    "cP": "clearance.values.units",
    "degree": "clearance.values.units",
    "mm": "clearance.values.units",
    "rpm": "clearance.values.units",
    "um": "clearance.values.units",
    "simulate": "clearance.simulation",
    "SimulationError": "clearance.simulation",
    "open_result": "clearance.results.result",
    "NotReached": "clearance.simulation",
    "Result": "clearance.results.result",
    "load_case": "clearance.scene.catalogue",
    "benchmark": "clearance.studies.benchmark.problems",
    "hole_check": "clearance.run.force_hole",
    "inverse_dynamics": "clearance.motions.inverse",
    "statistics": "clearance.motions.chaos",
    "steady": "clearance.motions.steady",
    "NotPeriodic": "clearance.motions.maps",
    "worn": "clearance.laws.outline",
    "wear": "clearance.wearing.life",
    "Life": "clearance.wearing.life_record",
    "solve_film": "clearance.film.solvers",
    "sweep": "clearance.sweeping.sweep",
    "SweepError": "clearance.sweeping.sweep",
    "open_sweep": "clearance.sweeping.index",
    "follow": "clearance.motions.follow",
    "assumptions": "clearance.metrics.assumptions",
    "Sweep": "clearance.sweeping.index",
    "grid": "clearance.sweeping.points",
    "zipped": "clearance.sweeping.points",
    "sampled": "clearance.sweeping.points",
    "scatter": "clearance.sweeping.chance",
    "dataset": "clearance.sweeping.dataset",
    "open_scatter": "clearance.sweeping.scatter",
    "plot": "clearance.postprocess.pictures",
    "report": "clearance.postprocess.report",
    "view": "clearance.postprocess.view",
    "again": "clearance.run.again",
    "compare": "clearance.postprocess.measured",
    "fit": "clearance.identify.scene_parameters",
    "optimize": "clearance.identify.designs",
    "export": "clearance.exporting.export",
}

#: names that only authors of cases need: not among those to choose from
_ASIDE = ("crank_drive", "joint_friction_law", "one_of", "pad_table")
#: names that have another one in their module
_RENAMED = {"pad_table": "pad_film"}
_MODULES = {
    "elements": "clearance.elements",
    "film": "clearance.film",
    "films": "clearance.film.names",
    "laws": "clearance.laws",
}

ACCESSORS |= {
    "plot": "clearance.postprocess.pictures:Pictures",
    "report": "clearance.postprocess.report:report",
    "cell": "clearance.postprocess.cells:cell",
    "ideal_turn": "clearance.simulation:ideal_turn",
    "to_csv": "clearance.metrics.tables:to_csv",
    "to_mat": "clearance.metrics.tables:to_mat",
    "to_latex": "clearance.metrics.tables:to_latex",
    "metrics": "clearance.metrics.metrics:metrics",
    "citations": "clearance.metrics.citations:citations",
    "view": "clearance.postprocess.view:view",
    "plot_fit": "clearance.postprocess.scene_fits:picture",
    "plot_optimum": "clearance.postprocess.optima:picture",
    "report_optimum": "clearance.postprocess.optima:report",
    "report_fit": "clearance.postprocess.scene_fits:report",
}


def __getattr__(name: str):
    """A public name, whose module is imported on first use: a command needs few of them."""
    if name in _LAZY:
        value = getattr(import_module(_LAZY[name]), _RENAMED.get(name, name))
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
    "clearance.choices": "clearance.scene.law_names",
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
        if name in ("clearance.cases", "clearance.postprocess", "clearance.paper_figures"):
            return PathFinder.find_spec(name, [dirname(__file__), dirname(dirname(__file__))])
        return ModuleSpec(name, _Moved) if name in _MOVED else None


# before the finder of another checkout that is installed editable
sys.meta_path.insert(0, _Beside)
