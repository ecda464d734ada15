"""The film of a bearing whose surface yields to the pressure, through the wall into dry contact.

Gap and pressure of an elastic column, H = 1 + eps cos(theta) + P, P = kappa p / c, follow

    div(H^3 exp(-beta P) grad P) = C_w dH/dtheta + C_s cos(theta),   beta = alpha c / kappa
    C_w = 6 mu w R^2 kappa / c^3,   C_s = 12 mu eps' R^2 kappa / c^3

and the film carries f c R L / kappa. The gap at the wall has the size h of `size`. All is relative
to two films that are known. One is the rigid film (film/tabulated.py) in the gap g, which is
1 - eps far off the wall and goes with h^2 / (eps - 1) behind it. It is taken times 1 + k, which is
what yield makes of a concentric film. The other is dry contact on the same surface,
f_dry = eps a - sin a, cos a = 1 / eps. With f_q, twice the concentric film of the motion, which is
larger than any pull,

    (f_q - f_r)^2 = f_dry^2 + exp(r_N) (f_q - f_r)^2 of the rigid film
    f_t = (1 + r_t) of the rigid film,   shear = exp(r_K) 2 pi / s,   s^2 = g (2 - g)

Therefore the force is above that of dry contact, and tends to it at rest. Without yield it is the
rigid film. The three r are small and smooth. They are C1 quadratic splines over

    x = (ln h - ln g - z) / (1.35 - 1.74 z),   h^(1/3),   alpha: angle of (eps', s eps w / 2)

z = ln h, not far below ln 0.004, where films at the wall are alike. The centre has no direction.
So r_N is its spline times eps^2 / (eps^2 + 2e-4), r_t is times eps / (eps^2 + 2e-4), and r_K is
that of a concentric film at x = 0. For the first h all are nothing there. Before the first x all
are constant. Beyond the last they go straight on, beyond the last h for a little.
"""

import math

from clearance.film.lookup import looked_up
from clearance.film.tabulated import polar
from clearance.laws.film import REST

#: numbers before the splines: factor of the force; cells over x, h^(1/3) and alpha; cells per
#: h^(1/3); where the splines of the thickness and the rigid film begin
HEAD = 7
SPLINES = HEAD + 4  # where those of the force begin, behind the numbers of `middle`
SMALLEST, LARGEST = 0.2, 1.05 ** (1.0 / 3.0)  # h^(1/3) of the table's first and last nodes
LAST = 0.05  # ln h, not below that of the last node
ROUND = 0.3  # of the corner of g at the wall
CLOSE = -5.5  # ln h below which films at the wall are alike
MIDDLE = 0.1  # eccentricity ratio below which the wedge counts less
TURNS = 0.03  # C_s over eps C_w at which an approach becomes a recession
LEAST = 5e-3  # of f_q: f_q - f_r of the rigid film is not below
CENTRE = 2e-4  # eps^2 below which r_N and r_t fade: the centre has no direction
SHARP = 0.03  # of the corner of z
CONTACT = 4.0 * math.sqrt(2.0) / 3.0
#: m / (eps - 1), f_dry = CONTACT m^1.5, by falling powers of (eps - 1) / (eps + 1): 3e-8 up to 5
DRY = (
    *(-0.7338927289, 1.8663992396, -2.0925510843, 1.1714860009, -0.2273616486, -0.3013360499),
    *(0.4163645107, -0.5443150589, 0.5097594071, -0.8666654507, 0.9999999983),
)


def central_film(u):
    """psi: the film in the middle over h, at u = (1 - eps) / h.

    Within 2 % of long bearings in rotation, C_w 1e-4 to 1e-2 (ehl.md, 6 a'). psi -> u far off the
    wall, 0.31 |u|^-1/4 behind it.
    """
    root = math.sqrt(u * u + 0.507)
    p = 0.5 * (root - u) if u < 0.0 else 0.2535 / (root + u)
    return u + p + 0.3084 * p * p / (p * p * math.sqrt(math.sqrt(p)) + 0.0526)


def yielding(apart, radial, turning, square):
    """chi: share of the journal's own rate that the film feels, at apart = 1 - eps; square: h^2.

    The surface follows the journal with the rest. Read off the film with memory through the wall:
    approaches within 0.06, above apart = 0.7 h it is the slope of `central_film`. A journal that
    recedes leaves oil trapped, so that the film feels less. It keeps it until the surfaces part.
    radial = C_s / 12, turning = eps C_w / 12.
    """
    slow = TURNS * turning
    opens = 0.5 - 0.5 * radial / math.sqrt(radial * radial + slow * slow + REST * REST)
    part = apart + math.sqrt(apart * apart + (1.195 - 1.02 * opens) * square)
    part *= part
    return part / (part + (1.407 - 0.973 * opens) * square)


def wedge_part(eps, turning):
    """(1.1 eps C_w / (eps + 0.1))^3, turning = eps C_w / 12."""
    wedge = 12.0 * (1.0 + MIDDLE) * abs(turning) / (eps + MIDDLE)
    return wedge * wedge * wedge


def squeezed(radial, part):
    """|C_s|^2.5 + part; radial = C_s / 12."""
    squeeze = 12.0 * abs(radial)
    return squeeze * squeeze * math.sqrt(squeeze + REST) + part + REST


def size(radial, part):
    """ln h, h = (|C_s|^2.5 + part)^(2/15): C_s^(1/3) or C_w^(2/5)."""
    return math.log(squeezed(radial, part)) / 7.5


def about(both):
    """h^2 within a fifth, of what h is a power of."""
    return 0.774 * math.sqrt(math.sqrt(both))


def dry(eps):
    """f_dry^2."""
    beyond = max(eps - 1.0, 0.0)
    t = beyond / (eps + 1.0)
    total = 0.0
    for number in DRY:
        total = number + t * total
    return CONTACT * CONTACT * (beyond * total) ** 3


def gap_at(eps, third):
    """ln g, s, and twice the mean of the rigid gap and its size, 1 - eps far off."""
    h = third * third * third
    beyond, corner = 1.0 - eps, 4.0 * ROUND * h * h
    root = math.sqrt(beyond * beyond + corner)
    wide = beyond + root if beyond > 0.0 else corner / (root - beyond)
    g = wide / (1.0 + math.sqrt(1.0 + corner))
    s = math.sqrt(g * (2.0 - g))
    return math.log(g), s, wide


def across(log_h, log_g):
    """x of the table. Beyond its last h, ln h slows down, to 0.55 at most: x has a pole at 0.78."""
    beyond = max(log_h - LAST, 0.0)
    log_h += beyond / (1.0 + 2.0 * beyond) - beyond
    apart = log_h - CLOSE
    z = 0.5 * (log_h + CLOSE + math.sqrt(apart * apart + SHARP))
    return (log_h - log_g - z) / (1.35 - 1.74 * z)


def directed(eps):
    """Factors of the splines of r_N and r_t: nothing at the centre."""
    part = eps / (eps * eps + CENTRE)
    return eps * part, part


def middle(eps, motion, data, at):
    """Effect of the yield on a concentric film, less and less of it off the centre.

        1 + k,   k = ((1 + a C + b C^2) / (1 + c C + d C^2) - 1) / (1 + 25 eps^2)

    The film is weaker, with oil that thickens stronger. motion: C, the size of C_s there.
    """
    below = 1.0 + motion * (data[at + 2] + data[at + 3] * motion)
    k = (1.0 + motion * (data[at] + data[at + 1] * motion)) / below - 1.0
    return 1.0 + k / (1.0 + 25.0 * eps * eps)


def rigid(still, w_r, w_t, s, eps, radial, turning, data, at):
    """Of the rigid film: f_q, (f_q - f_r)^2, f_t, from the values of its table; times `middle`."""
    way = s * turning
    speed, _, width = polar(radial, way)
    size = math.sqrt(radial * radial + turning * turning + REST * REST)
    factor, pull = middle(eps, 12.0 * size, data, at), 2.0 * still * size
    push = pull - (speed * w_r - still * radial) / (s * s * s)
    square, across = push * push + LEAST * LEAST * pull * pull, (speed * w_t / width + still) * way
    return factor * pull, factor * factor * square, factor * across / (s * s)


def straight(at, last, less):
    """Cell, at most the last, for a place in units of cells; weights of its three quadratic
    splines, which go straight on beyond both ends. less: 1 where no more than for a cell.
    """
    i = min(max(int(at), 0), last)
    t = at - i
    u = min(max(t, 0.0), 1.0)
    v, z = 1.0 - u, (t - u) / (1.0 + less * abs(t - u))
    return i, 0.5 * v * v - z * v, 0.5 + u * v + z * (v - u), 0.5 * u * u + z * u


def three(data, at, step, p, q, r):
    """Sum of three coefficients."""
    return data[at] * p + data[at + step] * q + data[at + 2 * step] * r


def nine(data, at, line, step, w, q):
    """Sum of three rows of coefficients."""
    total = 0.0
    for weight in w:
        total += weight * three(data, at, step, q[0], q[1], q[2])
        at += line
    return total


def looked(data, start, at, parts, x, third, angle):
    """The splines of three values at a state, whose numbers begin at `at`, parts each."""
    cells_x, cells_h, cells_a = int(data[start + 1]), int(data[start + 2]), int(data[start + 3])
    i, p0, p1, p2 = straight(max(x, 0.0) * cells_x, cells_x - 1, 0.0)
    j, w0, w1, w2 = straight(angle / math.pi * cells_a, cells_a - 1, 0.0)
    k, q0, q1, q2 = straight((third - SMALLEST) * data[start + 4], cells_h - 1, 1.0)
    line = parts * (cells_h + 2)
    plane = line * (cells_a + 2)
    at += i * plane + j * line + parts * k
    a, b, c = 0.0, 0.0, 0.0
    for weight in (p0, p1, p2):
        a += weight * nine(data, at, line, parts, (w0, w1, w2), (q0, q1, q2))
        b += weight * nine(data, at + 1, line, parts, (w0, w1, w2), (q0, q1, q2))
        c += weight * nine(data, at + parts - 1, line, parts, (w0, w1, w2), (q0, q1, q2))
        at += plane
    return a, b, c


def resolved(eps, radial_rate, entrainment, joint, liner, follows):
    """C_s / 12, as far as the film feels it, and eps C_w / 12; h^(1/3), `gap_at` and its x there,
    and the angle of the motion.
    """
    unit = joint.viscosity * joint.radius * joint.radius * liner / joint.clearance**3
    radial, turning = unit * radial_rate, 0.5 * unit * eps * entrainment
    part = wedge_part(eps, turning)
    chi = yielding(1.0 - eps, radial, turning, about(squeezed(radial, part)))
    radial *= 1.0 - follows * (1.0 - chi)
    log_h = size(radial, part)
    third = math.exp(log_h / 3.0)
    log_g, s, wide = gap_at(eps, third)
    _, angle, _ = polar(radial, s * turning)
    return radial, turning, third, log_g, s, wide, across(log_h, log_g), angle


def elastic(
    eccentricity_ratio,
    radial_rate,
    entrainment,
    joint,
    data,
    start,
    liner,
    pressure_viscosity,
    follows=1.0,
):
    """Film of a finite bearing whose surface yields by kappa p, through the wall into dry contact
    [N, N, 1].

    F_r, F_t = c R L / kappa f_r, f_t(eps, C_w, chi C_s; beta, L/D),   beta = alpha c / kappa
    C_w = 6 mu w R^2 kappa / c^3,   C_s = 12 mu eps' R^2 kappa / c^3
    chi: see `yielding`

    liner kappa [m/Pa], pressure_viscosity alpha [1/Pa]: of the joint's layer, material and
    lubricant by default. follows: 1 where the surface follows the journal by 1 - chi of its rate,
    as in a run. 0: it stands still, as in a film that no longer changes.
    The film is contact too, and none stands beside it. P >= 0, smooth surfaces, without friction of
    solids. Valid for eccentricity ratios to 1.4, C_w and C_s to 1, and on to f_dry at rest. Not
    valid for a journal that leaves the wall within 0.03 of it. Thickening oil that is squeezed has
    errors of 4e-2 up to alpha p = 3, and 70 % and more beyond 5.
    Source: Conway and Lee, J. Lubr. Technol. 97 (1975) 599, the equation of long bearings.
    """
    first = int(start)
    radial, turning, third, log_g, s, _, x, angle = resolved(
        eccentricity_ratio, radial_rate, entrainment, joint, liner, follows
    )
    still, w_r, w_t, _ = looked_up(data, first + int(data[first + 6]), -log_g, angle)
    pull, square, tangential = rigid(
        still, w_r, w_t, s, eccentricity_ratio, radial, turning, data, first + HEAD
    )
    r_n, r_t, r_k = looked(data, first, first + SPLINES, 3, x, third, angle)
    share_n, share_t = directed(eccentricity_ratio)
    radial = pull - math.sqrt(dry(eccentricity_ratio) + math.exp(share_n * r_n) * square)
    tangential *= 1.0 + share_t * r_t
    shear = 2.0 * math.pi / s * math.exp(r_k)
    scale = data[first] * joint.clearance * joint.radius * joint.length / liner
    return scale * radial, scale * tangential, shear


def films(
    eccentricity_ratio,
    radial_rate,
    entrainment,
    joint,
    data,
    start,
    liner,
    pressure_viscosity,
    follows=1.0,
):
    """Gap of the elastic surfaces on the line of centres, and their least in the middle plane
    [m].
    """
    first = int(start)
    _, _, third, _, _, wide, x, angle = resolved(
        eccentricity_ratio, radial_rate, entrainment, joint, liner, follows
    )
    middle, least, _ = looked(data, first, first + int(data[first + 5]), 2, x, third, angle)
    half = 0.5 * joint.clearance * wide
    return half * math.exp(middle), half * math.exp(least)


def motion(
    eccentricity_ratio,
    radial_rate,
    entrainment,
    joint,
    data,
    start,
    liner,
    pressure_viscosity,
    follows=1.0,
):
    """C_w, and chi C_s, of which the film has its size.

    C_w is times eps / MIDDLE below MIDDLE. A journal that passes the centre swings round it so fast
    that C_w itself has no bound.
    """
    state = resolved(eccentricity_ratio, radial_rate, entrainment, joint, liner, follows)
    return 12.0 * abs(state[1]) / max(eccentricity_ratio, MIDDLE), 12.0 * state[0]
