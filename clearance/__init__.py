"""clearance: tribodynamics of planar mechanisms whose joints have clearance, lubricant and
friction.
"""

# isort: off
from clearance.laws import *  # noqa: F403
from clearance.elements import *  # noqa: F403

# isort: on
from clearance import elements, films, laws
from clearance import film as film
from clearance.body import Body, Point, ground
from clearance.choices import crank_drive, joint_friction_law, one_of
from clearance.film.bearing import Bearing, FilmSolution, Groove
from clearance.film.online import conserving_film, fast_film, fem_film
from clearance.film.pad_law import pad_film as pad_table
from clearance.film.tabulated import table_film
from clearance.joint_options import JointOptions
from clearance.materials import HeatBalance, Lubricant, Material, steel
from clearance.scene import Scene
from clearance.units import cP, degree, mm, rpm, um
from clearance.version import VERSION

__version__ = VERSION

_LAZY = {
    "simulate": "clearance.simulation",
    "SimulationError": "clearance.simulation",
    "open_result": "clearance.results",
    "NotReached": "clearance.simulation",
    "Result": "clearance.results",
    "load_case": "clearance.catalogue",
    "hole_check": "clearance.regimes",
    "inverse_dynamics": "clearance.inverse.dynamics",
    "statistics": "clearance.chaos",
    "steady": "clearance.periodic.steady",
    "NotPeriodic": "clearance.periodic.maps",
    "worn": "clearance.laws.outline",
    "wear": "clearance.wearing.life",
    "Life": "clearance.wearing.records",
    "solve_film": "clearance.film.solvers",
    "sweep": "clearance.sweeping.driver",
    "SweepError": "clearance.sweeping.driver",
    "open_sweep": "clearance.sweeping.index",
    "follow": "clearance.periodic.follow",
    "assumptions": "clearance.evidence.assumptions",
    "Sweep": "clearance.sweeping.index",
    "grid": "clearance.sweeping.points",
    "zipped": "clearance.sweeping.points",
    "sampled": "clearance.sweeping.points",
    "scatter": "clearance.sweeping.chance",
    "open_scatter": "clearance.sweeping.scatter",
    "plot": "clearance.commands.plot",
    "report": "clearance.postprocess.report",
    "view": "clearance.postprocess.view",
    "again": "clearance.rerun",
    "compare": "clearance.postprocess.measured",
}

__all__ = [
    *laws.__all__,
    *elements.__all__,
    "Bearing",
    "Body",
    "FilmSolution",
    "Groove",
    "HeatBalance",
    "JointOptions",
    "Lubricant",
    "Material",
    "Point",
    "Scene",
    "cP",
    "conserving_film",
    "crank_drive",
    "degree",
    "elements",
    "fast_film",
    "fem_film",
    "films",
    "ground",
    "joint_friction_law",
    "laws",
    "mm",
    "one_of",
    "pad_table",
    "rpm",
    "steel",
    "table_film",
    "um",
    *_LAZY,
]


def __getattr__(name: str):
    """Describing a scene needs neither numba nor h5py: what does is imported on first use."""
    if name in _LAZY:
        from importlib import import_module

        value = getattr(import_module(_LAZY[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'clearance' has no attribute {name!r}")
