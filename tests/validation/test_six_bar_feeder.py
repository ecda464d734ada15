"""The six-bar feeder (assumed set feeder-A): ideal extremes from an independent Newton-Euler,
spectral derivatives.
"""

import numpy as np
import pytest

import clearance as cl

ROWS = {  # rpm: slider acceleration min, max; crank moment min, max; peak force B, C, E; as printed
    150: (-19.951, 11.321, -0.6310, 0.5615, 32.92, 30.34, 15.43),
    300: (-79.806, 45.286, -2.6399, 2.0055, 128.09, 116.21, 61.30),
}


PLAIN = {"source": "plain Newton-Euler, spectral derivatives", "kind": "independent"}


@pytest.fixture(scope="module", params=ROWS)
def ideal(request):
    scene = cl.load_case("six_bar_feeder", speed=cl.rpm(request.param), model="ideal")
    return request.param, cl.simulate(scene, turns=1, samples_per_turn=4096)


def test_ideal_extremes(ideal, validated):
    """Four digits: 2e-4, the printed rows' own rounding and their 4096 positions."""
    rpm, result = ideal
    ax, moment = result["slider"].ax, result.drive("crank").torque
    force = [np.hypot(*result.joint(j).force.T).max() for j in "BCE"]
    validated(
        "slider acceleration, ideal feeder",
        [ax.min(), ax.max()],
        ROWS[rpm][:2],
        2e-4,
        unit="m/s2",
        **PLAIN,
    )
    validated(
        "crank moment, ideal feeder",
        [moment.min(), moment.max()],
        ROWS[rpm][2:4],
        2e-4,
        unit="N m",
        **PLAIN,
    )
    validated("peak forces of B, C, E, ideal feeder", force, ROWS[rpm][4:], 2e-4, unit="N", **PLAIN)


def test_kinematics(ideal, validated):
    """Stroke 119.561 mm, slider 242.685 to 362.246 mm, rocker 76.40 to 115.37 deg, rod 4 within
    -3.82 to 2.81 deg.
    """
    _, result = ideal
    x, rocker, rod4 = (
        result["slider"].x,
        np.degrees(result["rocker"].theta),
        np.degrees(result["rod4"].theta),
    )
    places, printed = [0.242685, 0.362246, 0.119561], PLAIN | {"relative": False}
    validated(
        "slider's ends and stroke",
        [x.min(), x.max(), np.ptp(x)],
        places,
        1.2e-6,
        unit="m",
        **printed,
    )
    validated(
        "rocker angles", [rocker.min(), rocker.max()], [76.40, 115.37], 6e-3, unit="deg", **printed
    )
    validated("rod angles", [rod4.min(), rod4.max()], [-3.82, 2.81], 6e-3, unit="deg", **printed)


def test_small_clearance_tends_to_the_ideal_mechanism():
    """Lubricated B without drag (which grows as 1/c), second turn: the deviation shrinks with the
    clearance.
    """

    def extremes(clearance):
        scene = cl.load_case("six_bar_feeder", clearance=clearance, film_torques=False)
        result = cl.simulate(scene, turns=2, samples_per_turn=1000)
        keep = result.time > 0.2
        return np.array([result["slider"].ax[keep].min(), result.drive("crank").torque[keep].min()])

    ideal = np.array([ROWS[300][0], ROWS[300][2]])
    errors = [np.abs(extremes(c) / ideal - 1.0).max() for c in (1e-4, 1e-5)]
    assert errors[0] < 0.02
    assert errors[1] < 0.1 * errors[0] + 2e-4


@pytest.mark.slow
def test_independent_integration(validated):
    """scipy's Radau drives the plain multiplier formulation of the same lubricated scene: 1e-6 of
    the clearance.
    """
    from scipy.integrate import solve_ivp

    from clearance.mechanism.build import build
    from tests.augmented import Augmented

    scene = cl.load_case("six_bar_feeder", film="pinkus_sternlicht")
    start, reference = build(scene).start, Augmented(scene)
    q0 = np.array([v for b in scene.bodies for v in start.pose[b]])
    v0 = np.array([v for b in scene.bodies for v in start.velocity[b]])
    # the textbook film has no value at the very centre: start 1e-6 c beside it on both sides
    offset = 1e-10

    def rate(t, z):
        q, v = z[: q0.size], z[q0.size :]
        return np.concatenate([v, reference.accelerations(q, v)[: q0.size]])

    shifted = cl.load_case("six_bar_feeder", film="pinkus_sternlicht")
    joint = next(j for j in shifted.joints if j.name == "B")
    object.__setattr__(joint, "eccentricity", (offset, 0.0))
    mechanism_start = build(shifted).start
    q0 = np.array([v for b in shifted.bodies for v in mechanism_start.pose[b]])
    until = 0.01
    actual = solve_ivp(
        rate, (0.0, until), np.concatenate([q0, v0]), method="Radau", rtol=1e-10, atol=1e-14
    )
    ours = cl.simulate(shifted, until=until, rtol=1e-10, samples=2)
    q = actual.y[: q0.size, -1].reshape(-1, 3)
    for body, (x, y, theta) in zip(shifted.bodies, q, strict=True):
        options = {
            "source": "scipy Radau on plain multipliers",
            "kind": "independent",
            "relative": False,
        }
        centre, b = (ours[body.name].x[-1], ours[body.name].y[-1]), ours[body.name]
        validated("positions in the lubricated feeder", centre, (x, y), 1e-10, unit="m", **options)
        validated(
            "angles in the lubricated feeder", b.theta[-1], theta, 1e-9, unit="rad", **options
        )
