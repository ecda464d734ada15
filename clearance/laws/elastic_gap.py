"""Gap of a film between elastic surfaces: the deflection at which contact and film carry the same.

    delta + h_0 = h,   h = h_c(F_c(delta), u_eff)

with the nominal gap h_0 = c - e, the dry contact F_c and the central film h_c of a line contact.
The left side grows with delta, the right falls: one root, which works through h_0 = 0. Of an
approach V the surfaces recede with a part, the film closes with the rest, chi V:

    chi = h / (h + delta / q),   q = 0.54

It is 1 for rigid surfaces and 0 in contact, and within 0.02 of the slope dh/dh_0 of solved elastic
films. A film that squeezes carries what an entrainment carries:

    2.448 mu L R' u / h,   3 pi 2^(1/2) mu L (R' / h)^1.5 V = 2.448 mu L R' s / h
    s = 3 pi 2^(1/2) / 2.448 (R' / h)^(1/2) chi V,   u_eff = (u^2 + max(s, 0)^2)^(1/2)

So the film lasts where the entrainment turns round while the journal approaches. Speeds in m/s,
lengths in m, loads in N.
Source: the parabola of a line contact, both as in Martin (1916); the combination is ours.
"""

import math

from clearance.laws.line_contact import (
    CENTRAL,
    MARTIN,
    effective_radius,
    four_regimes,
    joined,
    moes_numbers,
    resolved_speed,
    scales,
)

YIELD = 1.0 / 0.54  # 1 / q
SQUEEZE = 3.0 * math.pi * math.sqrt(2.0) / MARTIN
#: at M around 1: H and its power of M
MIDDLE, FALL = 3.47, 0.6
#: of the guess: H of thick oil at M = 1, and how sharply its sides meet in h_0 < 0, h_0 > 0
THICK, BELOW, ABOVE, MET = 1.3, 1.2, 3.0, 2.5
POWER = 0.8  # of u_eff in the product of film and deflection


def gap_scales(joint, modulus, pressure_viscosity, depth, force):
    """The scales of a line contact, ln of M U^(-1/4) = k (delta / (R' U^(1/2)))^1.5 for the dry
    contact, and the squeeze speed s of unit film and approach.

    force: of the dry contact at a depth.
    """
    of_radius, of_speed, of_load, of_material = scales(joint, modulus, pressure_viscosity)
    stiff = math.log(force) - 1.5 * math.log(depth) + 1.5 * of_radius - of_load
    squeeze = SQUEEZE * math.sqrt(effective_radius(joint.radius, joint.clearance))
    return of_radius, of_speed, of_load, of_material, stiff, squeeze


def unfolded(z, gap):
    """(film, deflection) from ln of their product."""
    product, half = math.exp(z), 0.5 * gap
    part = math.sqrt(product + half * half) + abs(half)
    rest = product / part
    return (part, rest) if gap > 0.0 else (rest, part)


def share_of_film(film, deflection):
    """chi."""
    return film / (film + YIELD * deflection)


def entrained(speed, squeeze, rest):
    """ln of u_eff."""
    closing = max(squeeze, 0.0)
    return math.log(resolved_speed(speed * speed + closing * closing, rest))


def guessed(gap, speed, approach, width, rest, sizes, stiff, squeeze):
    """z near the root: of the sides far below and above h_0 = 0, and of the middle.

    width: of the gap at which the film is of its size [m].
    """
    film = 0.5 * (gap + math.sqrt(gap * gap + width * width))
    fast = entrained(speed, squeeze * approach / math.sqrt(film), rest)
    of_radius, of_speed, _, of_material = sizes
    half = 0.5 * (of_speed + fast)
    stiff = stiff + 0.5 * half
    material = of_material + 0.5 * half
    unit = of_radius + half
    thin = (math.log(MIDDLE) - FALL * stiff) * (1.0 / (1.0 + 1.5 * FALL))
    thick = (math.log(THICK) + 0.75 * material - 0.125 * stiff) * (1.0 / 1.1875)
    middle = joined(thin, thick, MET)
    far = 0.5 * math.log(gap * gap + 1e-4 * film * film) - unit
    boost = middle - thin
    if gap > 0.0:  # what thickens the oil fades
        middle = thin + boost / (1.0 + math.exp(2.0 * (far - middle)))
        side = (2.0 * (math.log(MARTIN) - stiff) + far) * (1.0 / 3.0)
        sharpness = ABOVE
    else:
        side = 0.7 * far + math.log(CENTRAL[0]) - 0.2 * stiff + boost
        sharpness = BELOW
    z = 2.0 * unit + joined(2.0 * middle, side, sharpness)
    film, deflection = unfolded(z, gap)
    closing = approach * math.sqrt(film) / (film + YIELD * deflection)
    return z + POWER * (entrained(speed, squeeze * closing, rest) - fast)


def mismatch(film, deflection, load, speed, approach, squeeze, rest, sizes):
    """ln of the film over that of the load, and of the rigid film over that of the load."""
    closing = approach * math.sqrt(film) / (film + YIELD * deflection)
    fast = entrained(speed, squeeze * closing, rest)
    m, l_, unit = moes_numbers(math.log(load), fast, sizes)
    of_load = four_regimes(m, l_, CENTRAL)
    return math.log(film) - unit - of_load, math.log(MARTIN) - m - of_load


def parted(film, deflection, ratio):
    """Film of rigid surfaces that carries the load, approach with which it squeezes as the elastic
    one does, and rate of the deflection, both over that of the journal.

    ratio: ln of the rigid film over the film.
    """
    chi = share_of_film(film, deflection)
    root = math.exp(0.5 * ratio)
    return film * root * root, chi * root, 1.0 - chi


def centred(gap, clearance):
    """(1 - eps^2)^2: share of rigid surfaces, for a journal in the middle has no line contact."""
    open_share = max(gap, 0.0) / clearance
    weight = open_share * (2.0 - open_share)
    return weight * weight


def blended(weight, rigid, elastic):
    """Of a value for rigid surfaces and that for elastic ones."""
    return elastic + weight * (rigid - elastic)


def beyond(contact, summits):
    """Load of the contact beyond that of its summits [N]: these are how the surfaces touch."""
    more = contact - summits
    return 0.5 * (more + math.sqrt(more * more + 0.01 * summits * summits + 1e-30))
