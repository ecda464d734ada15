"""Cost and error of each choice of physics: ideal, dry, lubricated, mixed feeder.

Group: measured

Answers: no single figure of a source; Jin et al. (2023) compare lubrication models by their curves
alone.

Reproduced: run time of each choice of contact, friction, film and transition against the distance
of its drive torque from that of the finest choice. Of the dry contact laws one of each kind;
`clearance work-precision six_bar_feeder --physics` has all of them, whose distances are samples of
one chaotic motion.

Assumed: set feeder-A with oil of 5 mPa s, so that joint B runs through all regimes. The mixed joint
with load sharing and tabulated film counts as the finest.

Not comparable: the distance of dry runs, which are chaotic: one sample of a statistical quantity.
"""

from clearance.paper_figures import physics, workshop
from clearance.postprocess import study_pictures

from clearance.scene.catalogue import find_case

#: elastic, spring and damper, hysteretic, with restitution, of cylinders, layered, of ADAMS
CONTACTS = (
    "hertz",
    "kelvin_voigt",
    "hunt_crossley",
    "lankarani_nikravesh",
    "johnson",
    "winkler",
    "impact",
)


def draw(work: workshop.Workshop) -> None:
    case, parameters = find_case("six_bar_feeder"), {"viscosity": 0.005}
    turns = work.less(None, 0.2)
    study = physics.compare(case, parameters, turns, None, progress=work.say, contacts=CONTACTS)
    work.drawing(study_pictures.physics, study)
    work.text([*physics.table(study), "", *physics.describe(study)])
    work.study(
        lambda folder: physics.save(study, folder), case="six_bar_feeder", parameters=parameters
    )
