"""Influence of the radial clearance on the six-bar feeder with joint B dry, lubricated and mixed.

Group: feeder

Answers: Jin et al. (2023), slider acceleration and joint force at several clearances, dry and with lubricated
clearance.

Reproduced: curves over a turn with radial clearances of 0.05, 0.1 and 0.2 mm, and over 0.02 to 0.5 mm the largest
force in joint B, the largest acceleration of the slider, what it accelerates beyond the ideal slider, the smallest
film thickness ratio, contacts and energy lost; speed 300 rpm. The mixed joint has an oil of 5 mPa s and shares its
load between film and asperities. With oil, deviations grow with the clearance; dry peaks do not, contacts only get
fewer.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 50 mPa s (lubricated). Contact
stiffness follows the radii, so that it grows as the clearance shrinks. Dry motion was irregular at all clearances that
were looked at in longer runs (0.02 to 0.5 mm), so that neighbouring points of its sweep scatter: extremes are those of
six turns.

Not comparable: the source's clearances and peaks, which were not in the part we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_speed import curves, influence, rows, swept, values

CLEARANCES = (0.05, 0.1, 0.2)


def draw(work: workshop.Workshop) -> None:
    sizes = np.geomspace(0.02, 0.5, work.less(29, 4))
    runs = {f"c = {c:g} mm": values(work, clearance=1e-3 * c) for c in work.less(CLEARANCES, CLEARANCES[1:])}
    work.keep(curves(runs))
    found = swept(work, clearance=[1e-3 * c for c in sizes])
    work.keep(influence(found, sizes, "radial clearance of joint B [mm]", log=True), "sweep")
    work.table(*rows(found, sizes, "mm", CLEARANCES), "sweep", "Nearest points of the sweep.")


if __name__ == "__main__":
    workshop.main(__file__)
