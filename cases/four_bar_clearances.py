"""Four-bar linkage with three dry clearance joints, friction and a passivity-based controller of
its crank (Akhadkar, Acary and Brogliato, Multibody Syst. Dyn. 38 (2016) 101).

Lengths, masses, inertias, radii, coefficient of friction, gains, reference motion and start are
those of the public example of the time-stepping code Siconos (siconos-tutorials,
examples/mechanics/FourBarLinkageWith3clearance). The example has the paper's mechanism. A result of
that example is stored beside it; `tests/validation/test_four_bar_clearances.py` compares.

The example has rigid bodies, impacts with restitution 0 and set-valued Coulomb friction. Here
contacts are stiff and strongly damped, and friction is smooth within `transition_speed`: that is
this case's own approximation. Peaks of force at impacts belong to it: the damper of 1e5 N s/m takes
1e5 N from each m/s of approach, for microseconds. With it they grow or fall; their impulses do not,
nor do forces between impacts. Rigid bodies have impulses and no such peaks. In the picture of a run
they lie beyond the axis of forces, with a mark for each. `--samples-per-turn 4000`, of the complete
run here, shows the paths of the journals at impacts.

The example takes the friction of an impact by the sliding at its end. Stiff contacts follow the
sliding. They differ where an impact turns it round, in this run once, at 0.0221 s in D. The
example's step of 1e-4 s is 5 % off in forces where journals swing fast. Rigid bodies with a small
step and the sliding followed agree with this case to 7e-6 rad and 0.16 % of the forces.

The controller has the linkage without clearance as its model, M theta'' + C theta' + G = torque.
With e = theta - wished it commands

    M (wished'' - bandwidth e') + C (theta' - bandwidth e) + G - gain (e' + bandwidth e).

In the second bracket textbooks have the wished rate, the example the rate theta'. Its C also has
half of the rocker's part. Both are taken over, for they are part of the result compared with.
"""

import math

import clearance as cl
from clearance.values import checks

GRAVITY = 9.81
FRAME = 3.0  # m, from A to D
CRANK, COUPLER, ROCKER = 1.0, 4.0, 2.5  # m
MASS = 1.0  # kg, of each bar
AMPLITUDE = 6.0  # rad, of the crank's wished motion, a sine
FREQUENCY = 0.75 * math.pi  # rad/s
UNTIL = 1.0  # s, of the reference run
START = 1.570823772407980  # rad, crank angle at t = 0
#: bodies of each clearance joint
PAIRS = {"B": ("crank", "coupler"), "C": ("coupler", "rocker"), "D": ("rocker", "ground")}
#: start of the second body's point against the first's [m]: the example's loops close to 1e-6 m
OFFSETS = {"B": (-9.756e-7, 6.8e-9), "C": (-6.506e-7, -7.505e-7), "D": (-2.986e-7, -9.411e-7)}


def closed(angle):
    """Directions (x, y) of coupler and rocker at a crank angle, without clearance."""
    x, y = FRAME - CRANK * math.cos(angle), -CRANK * math.sin(angle)
    square = x * x + y * y
    along = 0.5 * (square + COUPLER**2 - ROCKER**2) / square
    across = math.sqrt(COUPLER**2 / square - along * along)
    to_x, to_y = along * x - across * y, along * y + across * x
    return to_x / COUPLER, to_y / COUPLER, (to_x - x) / ROCKER, (to_y - y) / ROCKER


def reduced(angle):
    """The linkage without clearance, reduced to the crank. Its inertia [kg m2], half of the
    inertia's slope as in the example [kg m2/rad], and the moment of its weights [N m].
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    coupler_x, coupler_y, rocker_x, rocker_y = closed(angle)
    # sines and cosines of coupler less rocker, rocker less crank, coupler less crank
    apart = coupler_y * rocker_x - coupler_x * rocker_y
    apart_cosine = coupler_x * rocker_x + coupler_y * rocker_y
    rocker_sine = rocker_y * cosine - rocker_x * sine
    rocker_cosine = rocker_x * cosine + rocker_y * sine
    lead, lead_cosine = coupler_y * cosine - coupler_x * sine, coupler_x * cosine + coupler_y * sine
    # rates of coupler and rocker in those of the crank, and their slopes over its angle
    first = CRANK * rocker_sine / (COUPLER * apart)
    second = CRANK * lead / (ROCKER * apart)
    slope = (first - second) * apart_cosine / apart
    first_slope = CRANK * rocker_cosine * (second - 1.0) / (COUPLER * apart) - first * slope
    second_slope = CRANK * lead_cosine * (first - 1.0) / (ROCKER * apart) - second * slope
    inertia = 4.0 * CRANK**2 + (COUPLER * first) ** 2 + (ROCKER * second) ** 2
    inertia = inertia / 3.0 + CRANK * COUPLER * lead_cosine * first
    change = COUPLER**2 * first * first_slope / 3.0 + ROCKER**2 * second * second_slope / 6.0
    swing = lead_cosine * first_slope + first * lead * (1.0 - first)
    weight = 3.0 * CRANK * cosine + first * COUPLER * coupler_x + second * ROCKER * rocker_x
    half_slope = change + 0.5 * CRANK * COUPLER * swing
    return MASS * inertia, MASS * half_slope, 0.5 * MASS * GRAVITY * weight


@cl.effort(gain=checks.non_negative, bandwidth=checks.non_negative)
def passivity(time, position, rate, gain, bandwidth):
    """Torque of the controller [N m], see the module; gain [N m s/rad], bandwidth [1/s]."""
    sine, cosine = math.sin(FREQUENCY * time), math.cos(FREQUENCY * time)
    error = position - AMPLITUDE * sine
    error_rate = rate - AMPLITUDE * FREQUENCY * cosine
    inertia, half_slope, weight = reduced(position)
    asked = -AMPLITUDE * FREQUENCY**2 * sine - bandwidth * error_rate
    turning = half_slope * rate * (rate - bandwidth * error)
    return inertia * asked + turning + weight - gain * (error_rate + bandwidth * error)


def scene(
    *,
    clearance: float = 5e-3,
    radius: float = 0.055,
    journals: str = "crank,coupler,rocker",
    friction_coefficient: float = 0.1,
    transition_speed: float = 1e-4,
    stiffness: float = 1e8,
    damping: float = 1e5,
    gain: float = 200.0,
    bandwidth: float = 10.0,
) -> cl.Scene:
    """Crank 1 m, coupler 4 m, rocker 2.5 m, frame 3 m, 1 kg each; run 1 s, as the reference.

    clearance: radial clearance of B, C and D [m]
    radius: of the journals [m]
    journals: bodies that carry the journals of B, C, D; the other one has the bearing [-]
    friction_coefficient: of Coulomb friction in B, C and D; 0: none [-]
    transition_speed: sliding speed within which friction turns round [m/s]
    stiffness: of the contacts, high enough for rigid ones [N/m]
    damping: of the contacts, high enough for no rebound [N s/m]
    gain: of the controller, on rate and bandwidth times angle [N m s/rad]
    bandwidth: of the controller [1/s]
    """
    crank, coupler, rocker = (
        _bar("crank", CRANK, START),
        _bar("coupler", COUPLER, 0.353),
        _bar("rocker", ROCKER, 1.265),
    )
    ends = {
        "crank": {"B": crank["far"]},
        "coupler": {"B": coupler["near"], "C": coupler["far"]},
        "rocker": {"C": rocker["far"], "D": rocker["near"]},
        "ground": {"D": cl.ground.at(FRAME, 0.0)},
    }
    laws = {"contact": cl.kelvin_voigt(stiffness=stiffness, damping=damping)}
    if friction_coefficient:
        numbers = {"coefficient": friction_coefficient, "transition_speed": transition_speed}
        laws["friction"] = cl.coulomb(**numbers)
    carriers = [name.strip() for name in journals.split(",")]
    if len(carriers) != len(PAIRS):
        raise ValueError(f"journals must name one body each for B, C and D, got {journals!r}")
    joints = []
    for (name, pair), carrier in zip(PAIRS.items(), carriers, strict=True):
        cl.one_of(f"journals: the journal of {name}", carrier, pair)
        other, sign = (pair[1], -1.0) if carrier == pair[0] else (pair[0], 1.0)
        start = sign * OFFSETS[name][0], sign * OFFSETS[name][1]
        size = {"radius": radius, "clearance": clearance, "eccentricity": start}
        bearing, journal = ends[other][name], ends[carrier][name]
        joints.append(cl.ClearanceRevolute(bearing, journal, name=name, **size, **laws))
    torque = passivity(gain=gain, bandwidth=bandwidth)
    return cl.Scene(
        cl.Revolute(cl.ground.at(0.0, 0.0), crank["near"], name="A"),
        *joints,
        cl.Drive(crank, torque=torque, start=START),
        gravity=(0.0, -GRAVITY),
        name="four_bar_clearances",
    )


def _bar(name: str, length: float, angle: float) -> cl.Body:
    """A slender bar with its centre of mass in the middle."""
    points = {"near": (-0.5 * length, 0.0), "far": (0.5 * length, 0.0)}
    return cl.Body(name, mass=MASS, inertia=MASS * length**2 / 12.0, points=points, angle=angle)
