"""Elastohydrodynamic line contact of journal and bearing, two half-spaces with four regimes.

    R' = R_J (R_J + c) / c,  E' = 2 E*,  w = F / L,  U = mu u / (E' R')
    M = w / (E' R' U^(1/2)),  L_ = alpha E' U^(1/4),  film h = R' U^(1/2) H(M, L_)
    rigid isoviscous 2.448 / M         elastic isoviscous c_ei M^(-1/5)
    rigid piezoviscous c_rp L_^(2/3)   elastic piezoviscous c_ep M^(-1/8) L_^(3/4)
    H = [(ri^a + ei^a)^(s/a) + (rp^-b + ep^-b)^(-s/b)]^(1/s),   s = s_0 + s_1 exp(-s_2 ei / ri)

u is the **sum** of both surface speeds [m/s]. The form is that of Moes. The constants are a fit of
solutions with M from 0.1 to 50 and L_ from 0 to 10. The central film is within 6.4 % of these, the
least film within 7.8 %. The film grows with the speed. It falls with the load up to L_ = 4.5;
beyond it may grow with the load to the power of 0.06 at most. Valid where the half-width of the
contact is below a fifth of the radius.

Sources: Moes, Wear 159 (1992) 57; rigid limit: Martin, Engineering 102 (1916) 119.
"""

import math
from collections import namedtuple

from clearance.laws.contact import MODULUS
from clearance.laws.law import OfJoint, loaded_film
from clearance.values.checks import non_negative, positive

MARTIN = 2.448  # load times film of rigid surfaces
#: c_ei, c_rp, c_ep, a, b, s_0, s_1, s_2 of the central and of the least film
CENTRAL = (2.598, 1.130, 1.218, 2.180, 15.34, 1.410, 7.543, 1.912)
LEAST = (2.076, 0.911, 0.966, 2.212, 20.91, 1.586, 0.631, 0.985)
#: ln of R', of U per speed, of the load M U^(1/2) = 1, and of alpha E'
LineScales = namedtuple("LineScales", "radius speed load material")
NOTHING = 1e-12  # stands for a number L_ of zero
SLOWEST = 1e-12  # speed [m/s] that stands for rest; its film is below an atom


def joined(x, y, sharpness):
    """ln (e^(n x) + e^(n y))^(1 / n) with the sharpness n: at least the larger of both."""
    return x + math.log(1.0 + math.exp(sharpness * (y - x))) * (1.0 / sharpness)


def four_regimes(load, material, regimes):
    """ln H from ln M and ln L_, by the constants of the central or of the least film."""
    c_ei, c_rp, c_ep, a, b, s_0, s_1, s_2 = regimes
    rigid = math.log(MARTIN) - load
    elastic = math.log(c_ei) - 0.2 * load
    thin = joined(rigid, elastic, a)
    rigid_thick = math.log(c_rp) + (2.0 / 3.0) * material
    thick = -joined(-rigid_thick, 0.125 * load - 0.75 * material - math.log(c_ep), b)
    sharpness = s_0 + s_1 * math.exp(-s_2 * math.exp(elastic - rigid))
    return joined(thin, thick, sharpness)


def effective_radius(radius, clearance):
    """R' of journal and bearing [m]."""
    return radius * (radius + clearance) / clearance


def scales(joint, modulus, pressure_viscosity):
    """Those of a joint, see `LineScales`; modulus E* [Pa]."""
    radius = effective_radius(joint.radius, joint.clearance)
    stiff = 2.0 * modulus
    load = math.log(joint.length * stiff * radius)
    material = math.log(max(pressure_viscosity * stiff, NOTHING))
    return math.log(radius), math.log(joint.viscosity / (stiff * radius)), load, material


def moes_numbers(load, speed, sizes):
    """ln of M, of L_ and of the unit of film R' U^(1/2) [m], from ln of load and speed."""
    of_radius, of_speed, of_load, of_material = sizes
    half = 0.5 * (of_speed + speed)
    return load - of_load - half, of_material + 0.5 * half, of_radius + half


def resolved_speed(square, rest):
    """u^2 / (u^2 + u_0^2)^(1/2): the speed without its corner at rest, where it is quadratic.

    square: u^2.
    """
    return square / math.sqrt(square + rest * rest) + SLOWEST


def hertz_pressure(load, radius, clearance, length, modulus):
    """Largest pressure of a dry line contact [Pa]: (w E' / (2 pi R'))^(1/2), modulus E* [Pa]."""
    return math.sqrt(load * modulus / (math.pi * effective_radius(radius, clearance) * length))


@loaded_film(
    modulus=MODULUS,
    pressure_viscosity=OfJoint(
        non_negative, lambda joint, parameters: joint.lubricant.pressure_viscosity
    ),
    rest=positive,
)
def line_contact(load, speed, joint, modulus, pressure_viscosity, rest=1e-3):
    """Central film of half-spaces under a load, and the rigid isoviscous film of that load [m, m].

    h = R' U^(1/2) H(M, L_),  h_rigid = 2.448 R' U^(1/2) / M

    load F [N], speed u: sum of both surface speeds [m/s], modulus E* [Pa], pressure_viscosity alpha
    [1/Pa]. Below the speed `rest` [m/s] the square of the speed over `rest` stands for it, so that
    the film has a slope where the entrainment turns round. H, M, L_ and validity: see the module.
    Source: Moes, Wear 159 (1992) 57, with constants of our own solutions.
    """
    sizes = scales(joint, modulus, pressure_viscosity)
    m, l_, unit = moes_numbers(math.log(load), math.log(resolved_speed(speed * speed, rest)), sizes)
    return math.exp(unit + four_regimes(m, l_, CENTRAL)), math.exp(unit - m) * MARTIN


@line_contact.demands
def _half_spaces(joint, parameters):
    """A layer on a rigid base deflects as columns."""
    if joint.layer is None:
        return None
    return (
        "takes half-spaces, and a layer deflects as columns: take the film elastic with asperity "
        "beside it, without contact and transition, or leave the layer out"
    )
