"""The feeder with the table of the Reynolds equation against finite elements that are solved as the run goes."""

import numpy as np

import clearance as cl

ELEMENTS = {"source": "finite elements, solved in the run", "kind": "independent"}


def test_table_beside_elements_over_a_turn(validated):
    """Largest differences over a turn from rest in the middle of the clearance.

    The table's error of force is 3e-4 where the film closes, and elements have 5e-4 of their own at
    an automatic mesh: 1e-3 of the largest force. Gap and path follow the force: 2e-3 of the clearance.
    """
    table, elements = (
        cl.simulate(cl.load_case("six_bar_feeder", film=film), turns=1)
        for film in ("table", "fem")
    )
    first, second = table.joint("B"), elements.joint("B")
    c = elements.clearances["B"]
    largest = np.hypot(*second.force.T).max()
    apart = {
        "force": (np.hypot(*(first.force - second.force).T).max() / largest, 1e-3),
        "gap over c": (np.abs(first.gap - second.gap).max() / c, 2e-3),
        "path over c": (
            np.hypot(*(first.eccentricity - second.eccentricity).T).max() / c,
            2e-3,
        ),
    }
    for name, (found, tolerance) in apart.items():
        what = f"{name} of joint B over a turn, table beside elements"
        validated(what, found, 0.0, tolerance, relative=False, **ELEMENTS)
    ends = ("force_max", "gap_min")
    first_ends, second_ends = (
        [run.extreme(f"joints/B/{end}").value for end in ends] for run in (table, elements)
    )
    what = "peak force and smallest gap of joint B, table beside elements"
    validated(what, first_ends, second_ends, 1e-3, **ELEMENTS)
