"""Shares of film and contact in a rough joint, from full film to dry contact.

A transition law takes the nominal gap h_0 = c - e [m] and its joint. The gap is negative where the
nominal circles overlap. The law returns the parts of the joint:

    film share, film gap [m] and its slope by h_0, contact share, penetration for the contact law
    [m]. Last come the memberships in the states full film, mixed, dry (non-negative, sum 1).

    F = film share F_film(film gap, slope eps')
        - (contact share F_contact(penetration) + F_asperity(lambda)) n

lambda = h_0 / sigma with the composite roughness sigma. The film is never evaluated at or beyond
the wall. Contact begins where the penetration passes zero, at the end of a step. It is an event in
`flores_hybrid` alone. Contact laws with an impact speed get a typical one in the others. It is the
clearance times the mechanism's angular frequency, or the start's speed if that is larger. A motion
that no drive, gravity or speed of the start sets going has 1 rad/s, and its run warns.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from clearance.laws.asperity import normal_density, normal_tail
from clearance.laws.law import BoundLaw, DataLaw, FilmJoint, transition
from clearance.values.checks import finite, fraction, inner_fraction, non_negative, positive

NARROW = 6.0  # clearance over roughness below which asperities touch around a centred journal
FLOOR = 0.02  # smallest mean gap over the roughness
# numbers of a point of a table: ratio, full film, mixed, dry, and the slopes of these three
ROW = 7
WHOLE = 1e-6  # by which the memberships of a point may miss a sum of 1


def ramp(x):
    """Half a cosine wave from 0 to 1 over x in (0, 1), with zero slope at both ends (the ridge
    distribution).
    """
    return 0.5 - 0.5 * math.cos(math.pi * min(max(x, 0.0), 1.0))


def memberships(ratio, dry, mixed, full):
    """Memberships (full film, mixed, dry) of a film thickness ratio for thresholds
    dry < mixed < full; C1.

    w_H = S((lambda - l_m) / (l_f - l_m)),  w_D = 1 - S((lambda - l_d) / (l_m - l_d)),
    w_E = 1 - w_H - w_D; S: `ramp`.
    """
    w_full = ramp((ratio - mixed) / (full - mixed))
    w_dry = 1.0 - ramp((ratio - dry) / (mixed - dry))
    return w_full, 1.0 - w_full - w_dry, w_dry


def smooth_floor(value, floor, width):
    """max(value, floor) with a parabola over floor +- width: C1, exact outside."""
    if value >= floor + width:
        return value
    if value <= floor - width:
        return floor
    return floor + (value - floor + width) ** 2 / (4.0 * width)


def smooth_floor_slope(value, floor, width):
    """Derivative of `smooth_floor` by its value: from 0 below to 1 above."""
    return min(max((value - floor + width) / (2.0 * width), 0.0), 1.0)


def where(gap, roughness, dry, mixed, full):
    """Memberships as a label: of the film thickness ratio; without roughness, inside or beyond the
    wall.
    """
    if roughness > 0.0:
        return memberships(gap / roughness, dry, mixed, full)
    inside = 1.0 if gap > 0.0 else 0.0
    return inside, 0.0, 1.0 - inside


@transition(smallest_gap=inner_fraction, dry=positive, mixed=positive, full=positive)
def superposed(gap, joint, smallest_gap=1e-3, dry=0.4, mixed=1.0, full=3.0):
    """No transition: F = F_film(max(h_0, smallest_gap c)) + F_contact(e - c) [N], the sum of both
    laws.

    The film is complete down to smallest_gap (over the clearance c), contact begins at the wall.
    The thresholds dry < mixed < full only label the states in the output. Valid to compare the
    other transitions with. Source: the plain sum.
    """
    floor = smallest_gap * joint.clearance
    w_full, w_mixed, w_dry = where(gap, joint.roughness, dry, mixed, full)
    return 1.0, smooth_floor(gap, floor, 0.5 * floor), 1.0, 1.0, -gap, w_full, w_mixed, w_dry


@transition(
    tolerance=positive,
    largest_ratio=inner_fraction,
    dry=positive,
    mixed=positive,
    full=positive,
    first_touch=True,
)
def flores_hybrid(gap, joint, tolerance=0.05, largest_ratio=0.999, dry=0.4, mixed=1.0, full=3.0):
    """Flores' hybrid: film inside the clearance, a linear blend over the tolerance e_0 beyond it,
    dry contact then [-].

    F = F_film for e < c
    F = ((c + e_0 - e) F_film + (e - c) F_dry) / e_0 for c <= e <= c + e_0
    F = F_dry beyond

    tolerance e_0 over the clearance; largest_ratio: eccentricity ratio at which the film is frozen,
    for it diverges before e = c. Continuous but with kinks at c and c + e_0; e_0 has no physical
    meaning. The thresholds dry < mixed < full only label the states in the output. Valid to compare
    with the literature. Source: Flores, Ambrosio and Claro, Multibody Syst. Dyn. 12 (2004) 47;
    Flores et al. (2006, 2009).
    """
    beyond = min(max(-gap / (tolerance * joint.clearance), 0.0), 1.0)
    film_gap = max(gap, (1.0 - largest_ratio) * joint.clearance)
    w_full, w_mixed, w_dry = where(gap, joint.roughness, dry, mixed, full)
    return 1.0 - beyond, film_gap, 1.0, beyond, -gap, w_full, w_mixed, w_dry


def weighted(gap, roughness, mixed, full, datum, squeeze, w_full, w_mixed, w_dry):
    """Film share, film gap and the rest that `fuzzy` makes of memberships: see its equation."""
    floor = mixed * roughness
    width = min(0.1 * mixed, full - mixed) * roughness
    film_gap = smooth_floor(gap, floor, width)
    slope = squeeze + (1.0 - squeeze) * smooth_floor_slope(gap, floor, width)
    penetration = datum * floor - gap
    return w_full + w_mixed, film_gap, slope, 1.0 - w_full, penetration, w_full, w_mixed, w_dry


def weighted_by_film(film, joint, dry, mixed, full, datum, squeeze):
    """Film share and memberships of the film [m] on elastic surfaces."""
    w_full, w_mixed, w_dry = memberships(film / joint.roughness, dry, mixed, full)
    return w_full + w_mixed, w_full, w_mixed, w_dry


@transition(
    dry=positive,
    mixed=positive,
    full=positive,
    datum=non_negative,
    squeeze=fraction,
    carries_roughness=True,
    on_film=weighted_by_film,
)
def fuzzy(gap, joint, dry=0.4, mixed=1.0, full=3.0, datum=1.0, squeeze=1.0):
    """Fuzzy-weighted states of the film thickness ratio: full film H, mixed E, dry D, memberships
    as weights [N].

    F = w_H F_film(h_0) + w_E F_film(max(h_0, l_m sigma))
        + (1 - w_H) F_contact(max(0, datum l_m sigma - h_0))

    Thresholds dry < mixed < full of lambda (inputs: 0.4, 1, 3; after measurements of rough contacts
    0.05, 0.3, 1.2). The film is never thinner than l_m sigma. There it is blended over a tenth of
    it, so that the force is C1. Full film exactly for lambda >= full; dry contact, from its datum,
    for lambda <= dry. A soft or late contact leaves a hole between them: `clearance.hole_check`.

    Three choices are not in what we read of the source. The study `feeder_transition` compares
    each with `load_sharing`, which has no threshold.
    - datum: film thickness ratio, over l_m, from where contact begins and penetration counts
      (at most l_f / l_m). 1: where the film's weight begins to fall. 0: at the nominal wall, as in
      `flores_hybrid`; nothing carries between there and l_d. l_f / l_m: where full film ends; the
      journal then rests on bodies that do not touch, at twice the gap of `load_sharing` or more.
    - squeeze: share of its squeeze rate that the held film keeps. 1: the true rate, as in Flores'
      hybrid, so that a load which is carried by squeezing does not drop where the gap is held.
      0: the rate of a gap that stands still.
    - memberships: half-cosines, see `memberships`; `fuzzy_table` takes others.

    Valid for gaps of about the roughness. Source: reconstruction after Jin et al., Arch. Appl.
    Mech. 93 (2023) 2831 (whose membership functions are not known to us) and Luo and Yan (1989).
    Raises ValueError for thresholds that do not grow, a datum above l_f and a share outside [0, 1].
    """
    w_full, w_mixed, w_dry = memberships(gap / joint.roughness, dry, mixed, full)
    return weighted(gap, joint.roughness, mixed, full, datum, squeeze, w_full, w_mixed, w_dry)


def _ordered(joint, parameters):
    """Thresholds must grow, and a threshold needs a roughness."""
    low = parameters["dry"]
    middle = parameters["mixed"]
    high = parameters["full"]
    if not low < middle < high:
        return f"needs thresholds dry < mixed < full, got {low:g}, {middle:g}, {high:g}"
    if joint.roughness is None:
        return "needs the joint's roughness [m] for its film thickness ratio"
    if joint.clearance < NARROW * joint.roughness:
        return (
            f"needs a clearance of at least {NARROW:g} times the roughness, got "
            f"{joint.clearance!r} m and "
            f"{joint.roughness!r} m: a centred journal would touch all around"
        )
    return None


def _weights_fit(joint, parameters):
    """As `_ordered`, and contact begins where it has a weight."""
    datum = parameters["datum"]
    mixed = parameters["mixed"]
    full = parameters["full"]
    if reason := _ordered(joint, parameters):
        return reason
    if datum * mixed > full:
        return f"needs a datum of at most full / mixed = {full / mixed:g}, got {datum:g}"
    return None


def _wide(joint, parameters):
    """Roughness should be small against the clearance."""
    reach = parameters["full"] * joint.roughness
    if reach > 0.5 * joint.clearance:
        return f"full film begins at a gap of {reach:.2g} m only, more than half of the clearance"
    return None


fuzzy.demands(_weights_fit)


@fuzzy.doubts
def _wide_or_twice(joint, parameters):
    """Roughness small against the clearance; asperities once."""
    if joint.asperity is not None and joint.elastic is None:
        return "the asperity law adds its load to the weighted contact, which stands for it already"
    return _wide(joint, parameters)


# --- memberships given as a table of points
def hermite(ratio, low, high, value_low, value_high, slope_low, slope_high):
    """The cubic between two points that has their values and slopes."""
    width = high - low
    t = (ratio - low) / width
    u = 1.0 - t
    ends = u * u * (1.0 + 2.0 * t) * value_low + t * t * (1.0 + 2.0 * u) * value_high
    return ends + width * t * u * (u * slope_low - t * slope_high)


def tabled(ratio, data, start):
    """Memberships (full film, mixed, dry) of a film thickness ratio from a table; constant beyond
    its ends.
    """
    first = start + 1
    last = start + 1 + ROW * (int(data[start]) - 1)
    x = min(max(ratio, data[first]), data[last])
    a = first
    for k in range(first, last, ROW):
        if x > data[k]:
            a = k
    b = a + ROW
    w_full = hermite(x, data[a], data[b], data[a + 1], data[b + 1], data[a + 4], data[b + 4])
    w_dry = hermite(x, data[a], data[b], data[a + 3], data[b + 3], data[a + 6], data[b + 6])
    return w_full, 1.0 - w_full - w_dry, w_dry


def _weighted_by_table(gap, joint, data, start, dry, mixed, full, datum=1.0, squeeze=1.0):
    """As `fuzzy`, with memberships from a table of points [N]: see `fuzzy_table`."""
    w_full, w_mixed, w_dry = tabled(gap / joint.roughness, data, int(start))
    return weighted(gap, joint.roughness, mixed, full, datum, squeeze, w_full, w_mixed, w_dry)


def _by_table_and_film(film, joint, data, start, dry, mixed, full, datum, squeeze):
    """As `weighted_by_film`, with memberships from a table."""
    w_full, w_mixed, w_dry = tabled(film / joint.roughness, data, int(start))
    return w_full + w_mixed, w_full, w_mixed, w_dry


@dataclass(frozen=True)
class Table:
    """Points of a table as a kernel reads them: their number, then ROW numbers for each."""

    numbers: tuple[float, ...]

    @classmethod
    def of(cls, joint: FilmJoint, settings: dict) -> "Table":
        """The table is the same in every joint."""
        points = settings["points"]
        rows = zip(points, _slopes(points), strict=True)
        return cls((float(len(points)), *(v for point, slopes in rows for v in (*point, *slopes))))


def _slopes(points: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Slopes of the three memberships at each point.

    These are the slopes of the parabola through a point and its neighbours. One factor shortens all
    three until every membership is monotone between points (Fritsch and Carlson). Their sum stays 1
    and each stays in [0, 1].
    """
    widths = [b[0] - a[0] for a, b in pairwise(points)]
    rises = [
        [(b[i] - a[i]) / w for i in (1, 2, 3)]
        for (a, b), w in zip(pairwise(points), widths, strict=True)
    ]
    slopes = [(0.0, 0.0, 0.0)]
    for (before, after), (first, second) in zip(pairwise(widths), pairwise(rises), strict=True):
        sides = list(zip(first, second, strict=True))
        wanted = [(after * a + before * b) / (before + after) for a, b in sides]
        limits = [3.0 * min(abs(a), abs(b)) if a * b > 0.0 else 0.0 for a, b in sides]
        shares = [limit / abs(w) for w, limit in zip(wanted, limits, strict=True) if w != 0.0]
        slopes.append(tuple(min([1.0, *shares]) * w for w in wanted))
    return [*slopes, (0.0, 0.0, 0.0)]


_fuzzy_table = DataLaw(
    transition,
    _weighted_by_table,
    {
        "dry": finite,
        "mixed": positive,
        "full": positive,
        "datum": non_negative,
        "squeeze": fraction,
        "carries_roughness": True,
        "on_film": _by_table_and_film,
    },
    Table.of,
    name="fuzzy_table",
)
_fuzzy_table.demands(_weights_fit)
_fuzzy_table.doubts(_wide_or_twice)


def fuzzy_table(
    points: Iterable[Sequence[float]], *, datum: float = 1.0, squeeze: float = 1.0
) -> BoundLaw:
    """The transition `fuzzy` with memberships given as points; datum, squeeze: see there.

    A point is (film thickness ratio, full film, mixed, dry). Ratios grow. The memberships of a
    point are at least 0 and have the sum 1; the last point is all full film. Between points each
    membership is a monotone cubic (C1), beyond them it is constant. The film is never thinner than
    at the ratio where `mixed` is largest, and contact starts there.
    Raises ValueError for points that are no such table.
    """
    rows = [_point(i, row) for i, row in enumerate(points)]
    if len(rows) < 2:
        raise ValueError(f"fuzzy_table: give at least two points, got {len(rows)}")
    for before, after in pairwise(rows):
        if after[0] <= before[0]:
            raise ValueError(
                f"fuzzy_table: film thickness ratios must grow, got "
                f"{after[0]:g} after {before[0]:g}"
            )
    if rows[-1][1] != 1.0:
        last = rows[-1][1:]
        raise ValueError(f"fuzzy_table: the last point must be all full film (1, 0, 0), got {last}")
    dry = max((r[0] for r in rows if r[3] == 1.0), default=rows[0][0])
    mixed = max(rows, key=lambda r: r[2])[0]
    full = min(r[0] for r in rows if r[1] == 1.0)
    thresholds = {"dry": dry, "mixed": mixed, "full": full}
    return _fuzzy_table.bind({"points": tuple(rows)}, **thresholds, datum=datum, squeeze=squeeze)


def _point(index: int, row: Sequence[float]) -> tuple[float, ...]:
    """A checked point of a table of memberships."""
    label = f"fuzzy_table: point {index}"
    if isinstance(row, str) or not hasattr(row, "__len__") or len(row) != 4:
        raise ValueError(
            f"{label} must be (film thickness ratio, full film, mixed, dry), got {row!r}"
        )
    states = zip(("full film", "mixed", "dry"), row[1:], strict=True)
    shares = [fraction(f"{label}: {state}", share) for state, share in states]
    if abs(sum(shares) - 1.0) > WHOLE:
        raise ValueError(f"{label}: the memberships must have the sum 1, got {sum(shares):g}")
    return (finite(f"{label}: film thickness ratio", row[0]), *shares)


def shared_by_film(film, joint, dry, mixed, full):
    """Film share erf(lambda / 2^(1/2)) and memberships of the film [m] on elastic surfaces."""
    ratio = film / joint.roughness
    w_full, w_mixed, w_dry = memberships(ratio, dry, mixed, full)
    return 1.0 - 2.0 * normal_tail(max(ratio, 0.0)), w_full, w_mixed, w_dry


@transition(
    dry=positive,
    mixed=positive,
    full=positive,
    carries_roughness=True,
    needs_asperity=True,
    on_film=shared_by_film,
)
def load_sharing(gap, joint, dry=0.4, mixed=1.0, full=3.0):
    """Film, asperities and bulk carry together [N], each at the mean gap [m]: no threshold, smooth
    everywhere.

    h_T = sigma (lambda Phi(lambda) + phi(lambda)),  dh_T / dh_0 = Phi(lambda)
    F = F_film(h_T, h_T') - (F_asperity(lambda) + F_contact(e - c)) n

    The film gap is floored: sqrt(h_T^2 + (0.02 sigma)^2).
    Full film for lambda -> infinity (h_T = h_0 to 0.02 % at 3), dry contact for mu -> 0 and sigma
    -> 0. The thresholds dry < mixed < full only label the states in the output. Valid for
    Gaussian heights. Source: their mean gap, Patir and Cheng (1978).
    """
    sigma = joint.roughness
    ratio = gap / sigma
    below = 1.0 - normal_tail(ratio)
    mean = sigma * max(ratio * below + normal_density(ratio), 0.0)
    film_gap = math.sqrt(mean * mean + FLOOR * FLOOR * sigma * sigma)
    w_full, w_mixed, w_dry = memberships(ratio, dry, mixed, full)
    return 1.0, film_gap, below * mean / film_gap, 1.0, -gap, w_full, w_mixed, w_dry


load_sharing.demands(_ordered)
load_sharing.doubts(_wide)
