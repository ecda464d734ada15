"""Control volumes of the film with memory: its mesh, and what the gap makes of faces and cells.

A face has a conductance and a gap, a cell an axial conductance, a volume and a shear integral, all
with their derivatives. Equation and frame: `clearance.film.conserving`.
"""

import math
from collections import namedtuple

from clearance.film.piezo import reduced
from clearance.film.summits import NONE, lifted
from clearance.machine.store import njit

FULL, CAVITATED, FIXED = 0, 1, 2  # kinds of cell; pressure and content of a fixed one are given
# in `face`: conductance and gap, each followed by d/d(ex, ey, this cell's P, the next cell's P);
# at last the gap by the drag
COND, GAP, DRAG = 0, 5, 10
# in `cell`: each followed by d/d(ex, ey, this cell's P); at last, with a liner, the root of AXIAL
AXIAL, VOLUME, SHEAR, ROOT = 0, 4, 8, 12
# in `oil`, of a cell or an end: P, its reduced pressure, mu0 / mu, slope of ln(mu / mu0) by P. At
# last d P / d(-rigid gap) where the solids touch, else 0
PRESS, REDUCED, THIN, RATE, TOUCH = range(5)
LOWEST_GAP = 1e-6  # H is not taken below this: roughness is larger

#: of a bearing. ring: cos, sin of each cell's middle, cos, sin midway to the next (n, 4). order:
#: position of each column in the band (n,). worn: depths over c in the middle, at the face behind,
#: their mean over the cell, and the journal's growth over the cell (n, 4). width of each column
#: (n,); step: from its middle to the next one's (n,); depth of each layer (nz,); apart: from its
#: middle to the next one's, or to the end, as far as the flow counts it (nz,); weight: (R / L)^2;
#: mean: of cos over a column's width relative to its middle (n,). soft: deflection per P [s]; oil:
#: how P thickens it; lowest: P in a cavity. carried: 1 where the flow carries the content, 0 where
#: it carries full gaps (the memoryless film); filled: whether cavities drag as if full. summits:
#: see `clearance.film.summits`, empty for smooth surfaces
Mesh = namedtuple(
    "Mesh",
    "ring order worn width step depth apart weight mean soft oil lowest carried filled summits",
    defaults=(NONE,),
)
#: of a film: kind of its cells, p = P - lowest, content f, each (n, nz)
State = namedtuple("State", "kind p content")
#: of one Newton step: face (n, layers, 11), that between column i and the next. cell (n, layers,
#: 13), with a liner one layer more, of the ends. oil (n, nz + 1, 5), of cells and ends. least (n,
#: nz + 1): P - lowest where oil does not decide on it: of grooves, of ends, else 0. matrix (n nz, 2
#: w + 1): row i holds a_ij at w + j - i. rest (n nz, 1): right-hand side
System = namedtuple("System", "face cell oil least matrix rest")

#: nothing in these allocates: arrays need no counting
inlined = njit(error_model="numpy", forceinline=True, _nrt=False)
uncounted = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, _nrt=False)


@inlined
def floored(gap, summits):
    """A gap not below LOWEST_GAP, and its slope by the gap that smooth surfaces would have."""
    if summits.size > 0:
        return lifted(gap, summits)
    if gap > LOWEST_GAP:
        return gap, 1.0
    return LOWEST_GAP, 0.0


@inlined
def join(gaps, slopes, width, summits, face):
    """Conductance and gap of one face: exact for a one-dimensional film between the middles of its
    two cells.

    With the flow q = 6 spin H - H^3 P' constant between them, q = 6 spin gap - conductance (P_next
    - P_this). Here conductance = 1 / I3, gap = I2 / I3 and I_k is the integral of H^-k (Simpson).
    P is the reduced pressure of film/piezo.py. Both are per axial length. gaps,
    and their slopes: in the middle of this cell, at the face, in the middle of the next cell.
    """
    here, own_on = floored(gaps[0], summits)
    mid, mid_on = floored(gaps[1], summits)
    far, far_on = floored(gaps[2], summits)
    own_slope, mid_slope, far_slope = slopes
    a, b, d = 1.0 / here, 1.0 / mid, 1.0 / far
    third = width / 6.0 * (a * a * a + 4.0 * b * b * b + d * d * d)
    second = width / 6.0 * (a * a + 4.0 * b * b + d * d)
    face[COND] = 1.0 / third
    face[DRAG] = 0.0
    face[GAP] = second / third
    for m in range(4):
        da = -own_on * own_slope[m] * a * a
        db = -mid_on * mid_slope[m] * b * b
        dd = -far_on * far_slope[m] * d * d
        d_third = width / 2.0 * (a * a * da + 4.0 * b * b * db + d * d * dd)
        d_second = width / 3.0 * (a * da + 4.0 * b * db + d * dd)
        face[COND + 1 + m] = -d_third / (third * third)
        face[GAP + 1 + m] = (d_second - second / third * d_third) / third


@inlined
def lean(gaps, slopes, thin, drag, mesh, face):
    """Let the gap of a face go over to that of the cell upstream where the drag of a soft liner is
    the stronger one (cell Peclet number above 1).

    gap = (1 - w) gap + w upstream, w = Pe^2 / (1 + Pe^2), Pe = drag soft / (conductance thin)
    Central differences oscillate there, and no Newton step settles. Here the matrix keeps its
    signs, and where the film is resolved the change is of third order. A gap that is constant, as
    in a contact, it leaves as it is. thin: mu0 / mu at the face, and its slopes.
    """
    peclet = drag * mesh.soft / (face[COND] * thin[0])
    share = peclet * peclet / (1.0 + peclet * peclet)
    side = 0 if drag >= 0.0 else 2
    up, on = floored(gaps[side], mesh.summits)
    apart = up - face[GAP]
    bend = 2.0 * share * (1.0 - share) * apart
    face[GAP] += share * apart
    face[DRAG] = bend / drag if drag != 0.0 else 0.0
    for m in range(4):
        thinner = face[COND + 1 + m] / face[COND] + (thin[m - 1] / thin[0] if m > 1 else 0.0)
        upstream = on * slopes[side][m]
        face[GAP + 1 + m] += share * (upstream - face[GAP + 1 + m]) - bend * thinner


@inlined
def axial(cell, i, k, apart):
    """Conductance from a cell to its axial neighbour or to the end, its slopes by the AXIAL of
    both, and the layer of the neighbour.

    Exact for a one-dimensional film whose gap opens in proportion to P.
    """
    if cell.shape[1] == 1:
        return cell[i, 0, AXIAL] / apart[k], 0.5 / apart[k], 0.5 / apart[k], 0
    a, b = cell[i, k, ROOT], cell[i, k + 1, ROOT]
    both = (a + b) * (a + b)
    return (
        0.25 * (a * a + b * b) * (a + b) / apart[k],
        (both + 2.0 * a * a) / (12.0 * a * a * apart[k]),
        (both + 2.0 * b * b) / (12.0 * b * b * apart[k]),
        k + 1,
    )


@inlined
def fill(gaps, slopes, width, mesh, cell):
    """Axial conductance (integral of H^3), volume and integral of 1 / H of one cell (Simpson over
    its width), per axial length.

    gaps, and their slopes: at the face before, in the middle, at the face behind, the mean.
    """
    before, before_on = floored(gaps[0], mesh.summits)
    here, own_on = floored(gaps[1], mesh.summits)
    beyond, beyond_on = floored(gaps[2], mesh.summits)
    mean, mean_on = floored(gaps[3], mesh.summits)
    before_slope, own_slope, beyond_slope, mean_slope = slopes
    third = mesh.weight * width / 6.0
    cell[AXIAL] = third * (before**3 + 4.0 * here**3 + beyond**3)
    cell[VOLUME] = width * mean
    cell[SHEAR] = width / 6.0 * (1.0 / before + 4.0 / here + 1.0 / beyond)
    for m in range(3):
        db = before_on * before_slope[m]
        do = own_on * own_slope[m]
        de = beyond_on * beyond_slope[m]
        cell[AXIAL + 1 + m] = 3.0 * third * (before**2 * db + 4.0 * here**2 * do + beyond**2 * de)
        # by the pressure always: a liner that the journal has passed must still answer its pressure
        cell[VOLUME + 1 + m] = width * (mean_on if m < 2 else 1.0) * mean_slope[m]
        cell[SHEAR + 1 + m] = -width / 6.0 * (db / before**2 + 4.0 * do / here**2 + de / beyond**2)


@inlined
def dry(motion, i, mesh):
    """P - lowest at which smooth solids touch all over a column's cells; -inf without a liner."""
    if mesh.soft == 0.0 or mesh.summits.size > 0:
        return -math.inf
    c, s = mesh.ring[i, 0], mesh.ring[i, 1]
    rigid = 1.0 - mesh.mean[i] * (motion[0] * c + motion[1] * s) + mesh.worn[i, 2]
    return (LOWEST_GAP - rigid) / mesh.soft - mesh.lowest


@uncounted
def thicken(motion, state, mesh, system):
    """State of the oil in all cells and ends by its P, into the system's `oil`.

    First the pressure of what is not full: as given, or that of the solids where they touch.
    """
    (kind, p, _), oil, least = state, system.oil, system.least
    nz = p.shape[1]
    for i in range(p.shape[0]):
        solid = dry(motion, i, mesh)
        for k in range(nz + 1):
            free = k < nz and kind[i, k] == FULL
            touches = not free and solid > least[i, k]
            pressure = p[i, k] if free else max(least[i, k], solid)
            if k < nz:
                p[i, k] = pressure
            q = pressure + mesh.lowest
            thin = 1.0
            rate = 0.0
            if mesh.oil.alpha > 0.0:
                q, thin, rate = reduced(q, mesh.oil)
            oil[i, k, PRESS] = pressure + mesh.lowest
            oil[i, k, REDUCED] = q
            oil[i, k, THIN], oil[i, k, RATE] = thin, rate
            oil[i, k, TOUCH] = 1.0 / mesh.soft if touches else 0.0


@uncounted
def measure(motion, drag, mesh, system):
    """All faces and cells of a film, into its system, whose `oil` is known.

    A rigid bearing (soft = 0) is alike over its length: one layer, else one per row, and one of the
    ends. motion: ex, ey; drag: 6 spin [1/s].
    """
    (ex, ey), ring, worn = motion, mesh.ring, mesh.worn
    face, cell, oil = system.face, system.cell, system.oil
    n, soft = ring.shape[0], mesh.soft
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        c, s, cf, sf = ring[i]
        mean = mesh.mean[i]
        cj, sj = ring[j, 0], ring[j, 1]
        cb, sb = ring[i - 1, 2], ring[i - 1, 3]
        own_slope = -c, -s, soft, 0.0
        far_slope = -cj, -sj, 0.0, soft
        mid_slope = (-cf, -sf, 0.5 * soft, 0.5 * soft)
        before_slope = -cb, -sb, soft
        beyond_slope = -cf, -sf, soft
        mean_slope = (-mean * c, -mean * s, soft)
        here = 1.0 - ex * c - ey * s + worn[i, 0]
        far = 1.0 - ex * cj - ey * sj + worn[j, 0]
        mid = 1.0 - ex * cf - ey * sf + worn[i, 1]
        before = 1.0 - ex * cb - ey * sb + worn[i - 1, 1]
        average = 1.0 - mean * (ex * c + ey * s) + worn[i, 2]
        for k in range(face.shape[1]):
            y = soft * oil[i, k, PRESS]
            z = soft * oil[j, k, PRESS]
            gaps = here + y, mid + 0.5 * (y + z), far + z
            slopes_here = own_slope, mid_slope, far_slope
            join(gaps, slopes_here, mesh.step[i], mesh.summits, face[i, k])
            if soft > 0.0:
                near = 0.5 * oil[i, k, THIN]
                beyond = 0.5 * oil[j, k, THIN]
                thin = near + beyond, -near * oil[i, k, RATE], -beyond * oil[j, k, RATE]
                lean(gaps, slopes_here, thin, drag, mesh, face[i, k])
        for k in range(cell.shape[1]):
            y = soft * oil[i, k, PRESS]
            gaps = before + y, here + y, mid + y, average + y
            slopes = before_slope, own_slope[:3], beyond_slope, mean_slope
            fill(gaps, slopes, mesh.width[i], mesh, cell[i, k])
            if soft > 0.0:
                cell[i, k, ROOT] = cell[i, k, AXIAL] ** (1.0 / 3.0)
