"""How film and contact share a rough joint, from full film to dry contact.

A transition law takes the nominal gap h_0 = c - e [m] (negative where the nominal circles overlap) and its joint, and
returns what the joint is made of:

    film share, film gap [m] and its slope by h_0, contact share, penetration the contact law sees [m],
    memberships in the states full film, mixed, dry (non-negative, sum 1).

    F = film share F_film(film gap, slope eps') - (contact share F_contact(penetration) + F_asperity(lambda)) n

lambda = h_0 / sigma with the composite roughness sigma. The film is never evaluated at or beyond the wall. Contact
begins without an event in all but `flores_hybrid`: there, contact laws that look at the impact speed get a typical one,
clearance times the mechanism's angular frequency or the start's speed if that is larger.
"""

import math

from clearance.checks import inner_fraction, positive
from clearance.laws.asperity import normal_density, normal_tail
from clearance.laws.law import transition

NARROW = 6.0  # clearance over roughness below which asperities touch around a centred journal
FLOOR = 0.02  # smallest mean gap over the roughness


def ramp(x):
    """Half a cosine wave from 0 to 1 over x in (0, 1), with zero slope at both ends (the ridge distribution)."""
    return 0.5 - 0.5 * math.cos(math.pi * min(max(x, 0.0), 1.0))


def memberships(ratio, dry, mixed, full):
    """Memberships (full film, mixed, dry) of a film thickness ratio for thresholds dry < mixed < full; C1.

    w_H = S((lambda - l_m) / (l_f - l_m)),  w_D = 1 - S((lambda - l_d) / (l_m - l_d)),  w_E = 1 - w_H - w_D; S: `ramp`.
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


def where(gap, roughness, dry, mixed, full):
    """Memberships as a label: of the film thickness ratio; without roughness, inside or beyond the wall."""
    if roughness > 0.0:
        return memberships(gap / roughness, dry, mixed, full)
    inside = 1.0 if gap > 0.0 else 0.0
    return inside, 0.0, 1.0 - inside


@transition(smallest_gap=inner_fraction, dry=positive, mixed=positive, full=positive)
def superposed(gap, joint, smallest_gap=1e-3, dry=0.4, mixed=1.0, full=3.0):
    """No transition: F = F_film(max(h_0, smallest_gap c)) + F_contact(e - c) [N], the sum of both laws.

    The film is whole down to smallest_gap (over the clearance c), contact begins at the wall. The thresholds only label
    the states in the output. Source: the plain sum, to compare the other transitions with.
    """
    floor = smallest_gap * joint.clearance
    w_full, w_mixed, w_dry = where(gap, joint.roughness, dry, mixed, full)
    return 1.0, smooth_floor(gap, floor, 0.5 * floor), 1.0, 1.0, -gap, w_full, w_mixed, w_dry


@transition(tolerance=positive, largest_ratio=inner_fraction, dry=positive, mixed=positive, full=positive)
def flores_hybrid(gap, joint, tolerance=0.05, largest_ratio=0.999, dry=0.4, mixed=1.0, full=3.0):
    """Flores' hybrid: film inside the clearance, a linear blend over the tolerance e_0 beyond it, dry contact then [-].

    F = F_film for e < c;  ((c + e_0 - e) F_film + (e - c) F_dry) / e_0 for c <= e <= c + e_0;  F_dry beyond

    tolerance e_0 over the clearance; largest_ratio: eccentricity ratio at which the film is frozen, for it diverges
    before e = c. Continuous but with kinks at c and c + e_0; e_0 has no physical meaning. The thresholds only label the
    states in the output.
    Source: Flores, Ambrosio and Claro, Multibody Syst. Dyn. 12 (2004) 47; Flores et al. (2006, 2009).
    """
    beyond = min(max(-gap / (tolerance * joint.clearance), 0.0), 1.0)
    film_gap = max(gap, (1.0 - largest_ratio) * joint.clearance)
    w_full, w_mixed, w_dry = where(gap, joint.roughness, dry, mixed, full)
    return 1.0 - beyond, film_gap, 1.0, beyond, -gap, w_full, w_mixed, w_dry


flores_hybrid.first_touch = True


@transition(dry=positive, mixed=positive, full=positive)
def fuzzy(gap, joint, dry=0.4, mixed=1.0, full=3.0):
    """Fuzzy-weighted states of the film thickness ratio: full film H, mixed E, dry D, memberships as weights [N].

    F = w_H F_film(h_0) + w_E F_film(max(h_0, l_m sigma)) + (1 - w_H) F_contact(max(0, l_m sigma - h_0))

    thresholds dry < mixed < full of lambda (inputs: 0.4, 1, 3; after measurements of rough contacts 0.05, 0.3, 1.2).
    The film is never thinner than l_m sigma (blended there over a tenth of it, so that the force is C1); contact starts
    where the film's weight starts to fall. Full film exactly for lambda >= full; dry contact, from the datum l_m
    sigma, for lambda <= dry. A soft contact leaves a hole between them: see `clearance.hole_check`.
    Source: reconstruction after Jin et al., Arch. Appl. Mech. 93 (2023) 2831 (whose membership functions are not
    known to us) and Luo and Yan (1989); half-cosine memberships assumed.
    """
    sigma = joint.roughness
    w_full, w_mixed, w_dry = memberships(gap / sigma, dry, mixed, full)
    floor = mixed * sigma
    film_gap = smooth_floor(gap, floor, min(0.1 * mixed, full - mixed) * sigma)
    return w_full + w_mixed, film_gap, 1.0, 1.0 - w_full, max(floor - gap, 0.0), w_full, w_mixed, w_dry


def _ordered(joint, parameters):
    """Thresholds must grow, and a threshold needs a roughness."""
    low, middle, high = parameters["dry"], parameters["mixed"], parameters["full"]
    if not low < middle < high:
        return f"needs thresholds dry < mixed < full, got {low:g}, {middle:g}, {high:g}"
    if joint.roughness is None:
        return "needs the joint's roughness [m] for its film thickness ratio"
    if joint.clearance < NARROW * joint.roughness:
        return (
            f"needs a clearance of at least {NARROW:g} times the roughness, got {joint.clearance!r} m and "
            f"{joint.roughness!r} m: a centred journal would touch all around"
        )
    return None


def _wide(joint, parameters):
    """Roughness should be small against the clearance."""
    reach = parameters["full"] * joint.roughness
    if reach > 0.5 * joint.clearance:
        return f"full film begins at a gap of {reach:.2g} m only, more than half of the clearance"
    return None


fuzzy.demands(_ordered)
fuzzy.carries_roughness = True


@fuzzy.doubts
def _wide_or_twice(joint, parameters):
    """Roughness small against the clearance; asperities once."""
    if joint.asperity is not None:
        return "the asperity law adds its load to the weighted contact, which stands for it already"
    return _wide(joint, parameters)


@transition(dry=positive, mixed=positive, full=positive)
def load_sharing(gap, joint, dry=0.4, mixed=1.0, full=3.0):
    """Film, asperities and bulk carry together [N], each at the mean gap [m]: no threshold, smooth everywhere.

    h_T = sigma (lambda Phi(lambda) + phi(lambda)),  dh_T / dh_0 = Phi(lambda),  floored: sqrt(h_T^2 + (0.02 sigma)^2)
    F = F_film(h_T, h_T') - (F_asperity(lambda) + F_contact(e - c)) n

    Full film for lambda -> infinity (h_T = h_0 to 0.02 % at 3), dry contact for mu -> 0 and sigma -> 0. The
    thresholds only label the states in the output. Source: mean gap of Gaussian surfaces, Patir and Cheng (1978).
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
load_sharing.carries_roughness = True
