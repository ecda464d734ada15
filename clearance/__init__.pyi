"""Public names and their modules, one a line: editors read them here, and Python imports them from
here on first use, see `clearance.values.accessors.stated`.
"""

# ruff: noqa: F401
# isort: off
from clearance.laws import *  # noqa: F403
from clearance.elements import *  # noqa: F403
from clearance import elements as elements, film as film, laws as laws  # type: ignore[assignment]
from clearance.film import names as films

from clearance.elements.body import Body as Body
from clearance.elements.body import Point as Point
from clearance.elements.body import ground as ground
from clearance.exporting.export import export as export
from clearance.film.bearing import Bearing as Bearing
from clearance.film.bearing import FilmSolution as FilmSolution
from clearance.film.bearing import Groove as Groove
from clearance.film.coefficients import film_coefficients as film_coefficients
from clearance.film.elastic import elastic_film as elastic_film
from clearance.film.online import conserving_film as conserving_film
from clearance.film.online import fast_film as fast_film
from clearance.film.online import fem_film as fem_film
from clearance.film.pad_law import pad_film as pad_table
from clearance.film.solvers import solve_film as solve_film
from clearance.film.tabulated import table_film as table_film
from clearance.identify.designs import optimize as optimize
from clearance.identify.scene_parameters import fit as fit
from clearance.laws.materials import HeatBalance as HeatBalance
from clearance.laws.materials import Lubricant as Lubricant
from clearance.laws.materials import Material as Material
from clearance.laws.materials import steel as steel
from clearance.laws.oils import oil as oil
from clearance.laws.oils import oil_heat as oil_heat
from clearance.laws.outline import worn as worn
from clearance.metrics.assumptions import assumptions as assumptions
from clearance.motions.chaos import statistics as statistics
from clearance.motions.follow import follow as follow
from clearance.motions.inverse import inverse_dynamics as inverse_dynamics
from clearance.motions.maps import NotPeriodic as NotPeriodic
from clearance.motions.steady import steady as steady
from clearance.postprocess.measured import compare as compare
from clearance.postprocess.pictures import plot as plot
from clearance.postprocess.report import report as report
from clearance.postprocess.view import view as view
from clearance.results.result import Result as Result
from clearance.results.result import open_result as open_result
from clearance.run.again import again as again
from clearance.run.force_hole import hole_check as hole_check
from clearance.scene.catalogue import load_case as load_case
from clearance.scene.joint_options import JointOptions as JointOptions
from clearance.scene.joint_options import crank_drive as crank_drive
from clearance.scene.joint_options import joint_friction_law as joint_friction_law
from clearance.scene.joint_options import one_of as one_of
from clearance.scene.scene import Scene as Scene
from clearance.simulation import NotReached as NotReached
from clearance.simulation import SimulationError as SimulationError
from clearance.simulation import simulate as simulate
from clearance.studies.benchmark.problems import benchmark as benchmark
from clearance.sweeping.chance import scatter as scatter
from clearance.sweeping.dataset import dataset as dataset
from clearance.sweeping.index import Sweep as Sweep
from clearance.sweeping.index import open_sweep as open_sweep
from clearance.sweeping.points import grid as grid
from clearance.sweeping.points import sampled as sampled
from clearance.sweeping.points import zipped as zipped
from clearance.sweeping.scatter import open_scatter as open_scatter
from clearance.sweeping.sweep import SweepError as SweepError
from clearance.sweeping.sweep import sweep as sweep
from clearance.values.checks import RunWarning as RunWarning
from clearance.values.fit_class import fit_class as fit_class
from clearance.values.units import cP as cP
from clearance.values.units import degree as degree
from clearance.values.units import mm as mm
from clearance.values.units import rpm as rpm
from clearance.values.units import um as um
from clearance.wearing.life import wear as wear
from clearance.wearing.life_record import Life as Life

__version__: str

def __dir__() -> list[str]: ...
