"""Contacts of a trial step on traced numbers: whether one starts or ends inside it.

Places inside the step are looked at, with its dense output. The search itself is that of
touches.py.
"""

from operator import add

from clearance.stepping import control
from clearance.values.spots import CONTACT

PROBES = 8  # parts of a step that is searched for contacts


def add_probes(rows, shape) -> None:
    """Rows that the search for contacts needs."""
    spots = len(shape.contacts)
    rows.add("begins ends", count=2 * spots)  # penetration and its rate of each spot
    rows.add("probes", count=2 * spots * (PROBES - 1))
    rows.add("aimed event")


def met_inside(piece, shape, entries, polynomial: list):
    """True where a contact starts or ends inside the trial step, unless it is to end on one.

    polynomial: dense output of the step.
    """
    t, h, y, n = piece["t"], piece["h"], piece.all("y"), shape.states
    places = [p / PROBES for p in range(1, PROBES)]
    moved = (piece.along(polynomial, share, n) for share in places)
    inner = [
        piece.call(entries.spots, t + h * p, [*map(add, y, way), *y[n:]])
        for p, way in zip(places, moved, strict=True)
    ]
    probes = [piece.all("begins"), *inner, piece.all("ends")]
    piece.set(probes=[v for row in inner for v in row])
    aimed = piece["aimed"] > 0.5
    return piece.none(aimed) & _meets(piece, shape, probes)


def touching(piece, spot: int):
    """True where a spot is in contact: its impact speed stands in the work vector."""
    return piece.at("work", spot) > -0.5


def falling(piece, shape, finite, ends: list, factor):
    """The next step over one that is refused, inside which contacts end."""
    begins = piece.all("begins")
    for k, (kind, i, _) in enumerate(shape.contacts):
        before, after = begins[2 * k], ends[2 * k]
        if kind == CONTACT:
            inside = (after < 0.0) & (before > 0.0)
            (near,) = piece.formula(control.leaving, factor, before, after)
            factor = piece.choose(touching(piece, i) & inside & finite, near, factor)
    return factor


def _meets(piece, shape, probes: list[list]):
    """True where a contact starts or ends inside the step; see `near_contact` and `event_of` of
    stepping/contacts.py.

    probes: penetrations and their rates at the step's ends and PROBES - 1 places between.
    """
    h = piece["h"]
    part, met = h * (1.0 / PROBES), [h < 0.0]
    for k, (kind, i, band) in enumerate(shape.contacts):
        begins, rate = probes[0][2 * k], probes[0][2 * k + 1]
        state = touching(piece, i), kind != CONTACT, begins, rate, band
        (sign,) = piece.formula(control.beyond, *state)
        ways = [(row[2 * k] * sign, row[2 * k + 1] * sign) for row in probes]
        for low, high in zip(ways, ways[1:], strict=False):
            turns = (low[1] > 0.0) & (high[1] < 0.0)
            curve = piece.formula(control.cubic, *low, *high, part)
            _, value = piece.formula(control.summit, low[0], *curve)
            top = piece.choose(turns, value, high[0])
            met.append(piece.largest(top, high[0]) > band)
    return piece.either(*met)
