"""Influence of the radial clearance on the six-bar feeder with five models of joint B.

Group: feeder

Answers: Jin et al. (2023), slider acceleration and joint force at several clearances, with dry,
lubricated and transitional clearance. The source states that impacts grow with the clearance.

Reproduced: curves over a turn with radial clearances of 0.05, 0.1 and 0.2 mm, over the ideal
mechanism's largest value. Over 0.02 to 0.5 mm: the largest force of a turn in joint B, the
acceleration of the slider and its excess over the ideal slider. Also the smallest film thickness
ratio, contacts and energy lost; speed 300 rpm. Each picture has the growth of every model and a
mark where the source's statement is met. The transitional joint stands there with rigid and with
elastic surfaces. With oil it is met; dry peaks do not grow, contacts only
get fewer.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 5 mPa s,
half-cosine memberships. Contact stiffness follows the radii, so that it grows as the clearance
shrinks. Dry motion was irregular at all clearances of longer runs (0.02 to 0.5 mm), so that
neighbouring points of its sweep scatter. The picture has means over ten turns with 95 % intervals.
The growth compares medians of the first and last fifth of the points.

Not comparable: the source's clearances and peaks, which were not in the part we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_speed import curves, influence, rows, swept, values

CLEARANCES = (0.05, 0.1, 0.2)
CLAIM = "greater clearance, greater impacts"


def draw(work: workshop.Workshop) -> None:
    sizes = np.geomspace(0.02, 0.5, work.less(29, 4))
    runs = {f"c = {c:g} mm": values(work, clearance=1e-3 * c) for c in CLEARANCES}
    work.keep(curves(runs, f"{CLEARANCES[0]} to {CLEARANCES[-1]} mm", CLAIM))
    results = swept(work, {}, clearance=[1e-3 * c for c in sizes])
    work.keep(influence(results, sizes, "radial clearance [mm]", CLAIM, log=True), "sweep")
    work.table(*rows(results, sizes, "mm", CLEARANCES), "sweep", "Nearest points of the sweep.")
