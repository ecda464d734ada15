"""The ladder of oil films: error against run time, and mesh convergence of both Reynolds solvers.

Group: measured

Answers: the choice of the Pinkus-Sternlicht film in Jin et al. (2023): what it costs and how far
off it is.

Reproduced: time and error of one film force for formulas, tables, the fast solver and finite
elements, and of a feeder run with each. Also the order of both solvers as their meshes are refined.

Assumed: a bearing of L/D = 1. The fast solver on its finest mesh, extrapolated, is the reference of
single states. The table of 65 x 65 nodes is that of runs.

Not comparable: the source's optional Reynolds solution, whose mesh and results are not given.
"""

from clearance.paper_figures import film_ladder, workshop
from clearance.postprocess import film_pictures

from clearance.film.bearing import Bearing


def draw(work: workshop.Workshop) -> None:
    study = film_ladder.ladder(work.less(1.0, 0.05), work.quick, work.say)
    work.drawing(film_pictures.ladder, study)
    work.text([*film_ladder.table(study), "", *film_ladder.describe(study)])
    work.study(
        lambda folder: film_ladder.save(study, folder),
        case="six_bar_feeder",
        turns=work.less(1.0, 0.05),
    )
    if not work.quick:
        meshes = film_ladder.convergence(Bearing(10e-3, 1e-4, 20e-3, 0.05), progress=work.say)
        work.drawing(film_pictures.convergence, meshes, suffix="convergence")
        work.text(film_ladder.convergence_table(meshes), suffix="convergence")
        work.study(lambda folder: film_ladder.save_convergence(meshes, folder), slenderness=1.0)
