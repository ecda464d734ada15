"""Pressure in the lubricated joint B of the feeder at six moments of a turn.

Group: feeder

Answers: no figure of Jin et al. (2023), whose film model is a closed-form force without a pressure
field. It shows the pressure behind the tabulated film of the front picture.

Reproduced: the state of joint B along the sixth turn at 300 rpm. At six moments of it the Reynolds
equation is solved again with the run's bearing, oil and cavitation. The table sets its load beside
the force of the run.

Assumed: the feeder's parameter set feeder-A, and a bearing of length over diameter 1 without
grooves that cavitates at ambient pressure. Also constant viscosity, rigid smooth surfaces at the
nominal gap.

Not comparable: pressures and film extents; the source prints none.
"""

from clearance.paper_figures import workshop
from clearance.paper_figures.films import snapshots
from clearance.paper_figures.six_bar_feeder import PARAMETERS, TURNS
from clearance.postprocess import film_pictures

JOINT = "B"


def draw(work: workshop.Workshop) -> None:
    with work.run("six_bar_feeder", PARAMETERS, turns=TURNS) as run:
        shots = snapshots(run, JOINT)
    work.drawing(film_pictures.snapshots, shots, JOINT, "six_bar_feeder, lubricated, 300 rpm")
    heads = (
        "time [ms]",
        "eccentricity ratio [-]",
        "its rate [1/s]",
        "entrainment speed [rad/s]",
        "load [N]",
        "film force in the run [N]",
        "difference [%]",
        "peak pressure [MPa]",
    )
    remarks = "Load and pressure: finite volumes of that state; the run: its table."
    work.table(heads, [_row(s) for s in shots], remarks=remarks)


def _row(shot) -> list[float]:
    load = shot.solution.load
    return [
        1e3 * shot.time,
        shot.eccentricity_ratio,
        shot.radial_rate,
        shot.entrainment,
        load,
        shot.recorded,
        100.0 * (shot.recorded / load - 1.0),
        shot.solution.peak_pressure / 1e6,
    ]
