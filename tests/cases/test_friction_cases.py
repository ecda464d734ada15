"""The three friction cases against the numbers of independent implementations, to all digits that
were noted.

Of prescribed motions the kernels are run as plain Python, at any time and in any order. The numbers
come from recursive Newton-Euler, virtual power and multiplier solutions outside this package that
agree to 1e-11 and better.
"""

import math
from functools import cache

import numpy as np
import pytest
from clearance.paper_figures import mobile_manipulator as figures
from scipy.integrate import solve_ivp

import clearance as cl
from clearance.mechanism.build import build
from clearance.scene.catalogue import find_case, load_case
from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated
from tests.plain import kernel, observed
from tests.seeds import few_of

FIVE = "12345"
GUO = {
    "source": "chains of Guo, Ju and Wang 2024, solved elsewhere",
    "kind": "independent",
    "relative": False,
}
CHACKO = {
    "source": "manipulator of Chacko and Khan 2017, solved elsewhere",
    "kind": "independent",
    "relative": False,
}
ACTUATORS = ("boom", "stick", "bucket")


@cache
def mechanism(case, **parameters):
    return build(load_case(case, **parameters))


def outputs(case, t, *paths, **parameters):
    """Output channels of a prescribed motion at one time, as an array."""
    row = observed(mechanism(case, **parameters), t)
    return np.array([row[p] for p in paths])


def last(digits, units=0.5):
    """Half a unit (`units`) of the last noted digit, 1e-9 units for the rounding of decimals."""
    return (units + 1e-9) * 10.0**-digits


class TestFiveAxisChain:
    @pytest.mark.parametrize(
        ("reading", "t", "torques"),
        [
            ("P", 0.0, (1.853949, 1.127975, 0.120006, 1.235975, 0.144006)),
            ("P", 0.1, (1.854269, 1.131426, 0.118509, 1.232381, 0.145502)),
            ("P", 1.0, (1.969606, 1.486063, -0.039957, 0.894093, 0.282312)),
            ("P", 2.0, (3.316237, 2.647132, -0.603835, 0.143756, 0.528323)),
            ("Q", 0.0, (1.965952, 1.499971, 0.180010, 1.095981, 0.144006)),
            ("Q", 1.0, (2.284110, 2.043826, -0.059936, 0.752218, 0.282312)),
            ("Q", 2.0, (4.499021, 3.808744, -0.905752, -0.000667, 0.528323)),
        ],
    )
    def test_ideal_torques(self, reading, t, torques, validated):
        """Without friction, and with it as what friction is added to: friction of driven joints
        acts on nothing.
        """
        paths = [f"drives/{n}/torque" for n in FIVE]
        bare = outputs("five_axis_chain", t, *paths, reading=reading, friction="none")
        ideal = outputs("five_axis_chain", t, *(f"{p}_ideal" for p in paths), reading=reading)
        validated(
            "torques of the five-axis chain",
            [bare, ideal],
            [torques, torques],
            last(6),
            unit="N m",
            **GUO,
        )

    def test_axial_forces_are_the_weights(self, validated):
        """Each joint carries the weights of the links above it."""
        for t in (0.0, 2.0):
            actual = outputs("five_axis_chain", t, *(f"joints/{n}/axial_force" for n in FIVE))
            weights = (107.8, 49.0, 19.6, 49.0, 19.6)
            validated(
                "axial forces of the chain",
                actual,
                weights,
                last(9),
                unit="N",
                relative=False,
                source="weights of the links",
                kind="exact",
            )

    @pytest.mark.parametrize(
        ("friction", "t", "torques"),
        [
            ("coulomb", 0.05, (0.054176, 0.078561, 0.025651, 0.078564, 0.025658)),
            ("coulomb", 0.10, (0.054276, 0.078679, 0.025751, 0.078647, 0.025758)),
            ("coulomb", 0.20, (0.054478, 0.078948, 0.025951, 0.078778, 0.025957)),
            ("coulomb", 0.30, (0.054685, 0.079264, 0.026153, 0.078863, 0.026156)),
            ("stribeck", 0.05, (0.489680, 0.710454, 0.231424, 0.710482, 0.231493)),
            ("stribeck", 0.10, (0.366329, 0.531549, 0.173195, 0.531336, 0.173244)),
            ("stribeck", 0.20, (0.136736, 0.198429, 0.064818, 0.198000, 0.064833)),
            ("stribeck", 0.30, (0.063600, 0.092231, 0.030365, 0.091764, 0.030369)),
        ],
    )
    def test_friction(self, friction, t, torques, validated):
        """All rates are positive, so friction on body b is negative and its drive gives as much
        more.
        """
        row = observed(mechanism("five_axis_chain", friction=friction), t)
        rubbed = np.array([row[f"joints/{n}/friction"] for n in FIVE])
        validated(
            f"{friction} friction of the five-axis chain",
            -rubbed,
            torques,
            last(6),
            unit="N m",
            **GUO,
        )
        more = [row[f"drives/{n}/torque"] - row[f"drives/{n}/torque_ideal"] for n in FIVE]
        np.testing.assert_allclose(more, -rubbed, rtol=1e-12)

    def test_no_sign_at_rest(self):
        """sign(0) = 0: the very start has no friction."""
        assert not outputs("five_axis_chain", 0.0, *(f"joints/{n}/friction" for n in FIVE)).any()

    def test_loads_are_made_of_radial_axial_and_bending_parts(self):
        """Q = R_p f_r + R_n |f_m| + R_p / R_b t_r from the reaction's channels, for other arms than
        the default.
        """
        arms = {"pin_radius": 0.015, "friction_arm": 0.025, "bending_arm": 0.08}
        row = observed(mechanism("five_axis_chain", **arms), 1.3)
        for n in FIVE:
            here = {
                p: row[f"joints/{n}/{p}"]
                for p in ("force_x", "force_y", "axial_force", "bending_x", "bending_y")
            }
            radial, bending = (
                math.hypot(here["force_x"], here["force_y"]),
                math.hypot(here["bending_x"], here["bending_y"]),
            )
            load = 0.015 * radial + 0.025 * abs(here["axial_force"]) + 0.015 / 0.08 * bending
            assert row[f"joints/{n}/friction_load"] == pytest.approx(load, rel=1e-12)

    def test_bending_moments_carry_the_overhang(self, validated):
        """Joint 5 carries link 5's weight 2 kg * 9.8 m/s2 off its axis by |(0.3, 0.5196)| m, at any
        angle.
        """
        for t in (0.0, 2.0):
            actual = outputs("five_axis_chain", t, "joints/5/bending_x", "joints/5/bending_y")
            wanted = 19.6 * math.hypot(0.3, 0.5196)
            validated(
                "bending moment of joint 5",
                math.hypot(*actual),
                wanted,
                1e-12,
                unit="N m",
                source="weight times overhang",
                kind="exact",
            )

    def test_found_motion_follows_the_prescribed_one(self):
        """Position controllers over the forward dynamics, friction on: the same motion, the same
        torques.

        A controller gives its torque for an error of torque / stiffness: 1e-3 rad in all. The
        start-up fades within damping / stiffness = 0.1 s: 10 %. The error changes the torque by a
        few 1e-3. Energy closes to rtol = 1e-8 times a hundred steps.
        """
        stiffness = 5e3
        scene = load_case("five_axis_chain", drive="torque", stiffness=stiffness)
        result = cl.simulate(scene, until=1.5, samples=16, rtol=1e-8, method="dop853")
        for k in range(10, 16):
            t = result.time[k]
            row = observed(mechanism("five_axis_chain"), t)
            wanted = np.array([row[f"drives/{n}/torque"] for n in FIVE])
            actual = np.array([result.drive(n).torque[k] for n in FIVE])
            assert np.abs(actual - wanted).max() < 5e-3 * np.abs(wanted).max()
            angles = np.array([result[f"link{n}"].theta[k] for n in FIVE])
            relative = angles - np.array([0.0, angles[0], angles[1], angles[0], angles[3]])
            np.testing.assert_allclose(0.1 * t * t - relative, wanted / stiffness, atol=1e-4)
        assert result.solver["energy_residual_share"] < 1e-6
        assert all(result.joint(n).dissipated[-1] > 0.0 for n in FIVE)


class TestThreeLoopChain:
    CUTS = [f"joints/{j}/force_{x}" for j in ("ground-g", "g-f", "f-d") for x in "xy"]

    @pytest.mark.parametrize(
        ("t", "angle", "torque", "pin", "cuts"),
        [
            (
                0.0,
                -98.797,
                0.8800089,
                (9.786079, -59.734341),
                (9.78604, -69.53456, 32.37917, 60.96363),
            ),
            (
                4.0,
                -75.879,
                1.8073065,
                (63.871007, -84.365195),
                (63.87106, -94.16541, 28.47092, 74.39877),
            ),
            (
                8.0,
                -52.960,
                1.8089609,
                (141.338911, -115.658180),
                (141.33905, -125.45836, 19.53770, 82.68208),
            ),
        ],
    )
    def test_reference(self, t, angle, torque, pin, cuts, validated):
        """Friction of the driven pin alone changes none of these."""
        row = observed(mechanism("three_loop_chain"), t)
        turned, actual = math.degrees(row["bodies/link_g/theta"]), [row[p] for p in self.CUTS]
        validated("crank angle of the three-loop chain", turned, angle, last(3), unit="deg", **GUO)
        ideal = row["drives/crank/torque_ideal"]
        validated("crank torque of the three-loop chain", ideal, torque, last(7), unit="N m", **GUO)
        validated(
            "crank pin force of the three-loop chain", actual[:2], pin, last(6), unit="N", **GUO
        )
        validated("cut forces of the three-loop chain", actual[2:], cuts, last(5), unit="N", **GUO)

    def test_frictionless(self):
        """Without friction, torque and forces are the ideal ones of the run with it."""
        paths = ["drives/crank/torque", *self.CUTS]
        for t in (0.0, 8.0):
            bare = outputs("three_loop_chain", t, *paths, friction="none")
            rubbed = outputs("three_loop_chain", t, "drives/crank/torque_ideal", *self.CUTS)
            np.testing.assert_allclose(bare, rubbed, rtol=1e-13)

    @pytest.mark.parametrize(
        ("friction", "torques"),
        [
            ("coulomb", (0.03127, 0.04089, 0.05391, 0.07055, 0.09231, 0.12284)),
            ("stribeck", (0.06467, 0.08492, 0.11230, 0.14732, 0.19309, 0.25731)),
        ],
    )
    def test_friction_of_the_crank_pin(self, friction, torques, validated):
        """Friction of one pin at six moments, to all printed digits."""
        actual = [
            outputs("three_loop_chain", t, "joints/ground-g/friction", friction=friction)[0]
            for t in range(0, 11, 2)
        ]
        label = f"{friction} friction of the crank pin, three-loop chain"
        validated(label, [-f for f in actual], torques, last(5), unit="N m", **GUO)

    @pytest.mark.parametrize(
        ("t", "torque", "friction", "ours"),
        [(0, 0.999011, 0.119002, 0.016167), (10, 1.164278, 0.285188, 0.061713)],
    )
    def test_friction_in_all_pins(self, t, torque, friction, ours, validated):
        """Torques with friction in all pins, and how fast its iteration contracts."""
        row = observed(mechanism("three_loop_chain", where="all", pin_radius=0.005), float(t))
        entire, ideal = row["drives/crank/torque"], row["drives/crank/torque_ideal"]
        actual, label = (
            [entire, entire - ideal, -row["joints/ground-g/friction"]],
            "friction in all pins, three-loop chain",
        )
        validated(label, actual, (torque, friction, ours), last(6), unit="N m", **GUO)
        assert row["friction/iterations"] == 8
        if t == 0:
            validated(
                "contraction of the friction iteration",
                row["friction/contraction"],
                0.019,
                last(3),
                **GUO,
            )

    @pytest.mark.parametrize("where", ["driven", "all"])
    def test_power(self, where):
        """Drive power = rate of mechanical energy + what the joints take out.

        The rate is a central difference, h = 1e-3 s: its error, h^2 / 6 of the third derivative, is
        1e-8 W.
        """
        t, h = 6.0, 1e-3
        low, row, high = (
            observed(mechanism("three_loop_chain", where=where), at) for at in (t - h, t, t + h)
        )
        rate = sum(high[f"energy/{e}"] - low[f"energy/{e}"] for e in ("kinetic", "potential")) / (
            2.0 * h
        )
        lost = [v for p, v in row.items() if p.endswith("/power_loss")]
        assert len(lost) == {"driven": 1, "all": 10}[where]
        assert min(lost) > 0.0
        assert row["drives/crank/power"] == pytest.approx(rate + sum(lost), abs=1e-7)

    def test_printed_link_vectors(self, validated):
        """The source's vectors, rounded to 0.1 mm: 0.05 mm; the fit leaves 0.039 mm."""
        start = mechanism("three_loop_chain").start
        angle = {b.name: start.pose[b][2] for b in mechanism("three_loop_chain").scene.bodies}
        for name, length, x, y in (
            ("a", 0.100, 0.0737, -0.0676),
            ("b", 0.050, -0.0451, -0.0217),
            ("c", 0.045, -0.0375, 0.0249),
            ("a", 0.050, 0.0368, -0.0338),
            ("d", 0.055, -0.0457, -0.0306),
            ("e", 0.055, -0.0079, -0.0544),
            ("f", 0.050, 0.049, -0.01),
            ("g", 0.045, -0.0069, -0.0445),
        ):
            turned = angle[f"link_{name}"]
            vector, source = (
                length * np.array([math.cos(turned), math.sin(turned)]),
                "Guo, Ju and Wang 2024",
            )
            validated(
                "vectors of the links",
                vector,
                (x, y),
                5e-5,
                unit="m",
                source=source,
                relative=False,
            )

    @pytest.mark.parametrize(("speed", "limit"), [(0.1, 90.5), (-0.1, 145.5)])
    def test_limits(self, speed, limit):
        """The chain closes up to a tenth of a degree before the noted limit, and not a tenth beyond
        it.
        """
        for beyond in (-0.1, 0.1):
            t = math.radians(limit + beyond) / abs(speed)
            m = mechanism("three_loop_chain", speed=speed, friction="none")
            assert all(map(math.isfinite, observed(m, t).values())) == (beyond < 0.0)

    @pytest.mark.slow
    def test_found_motion_follows_the_prescribed_one(self):
        """Forward dynamics with friction in all pins, where friction and reactions depend on each
        other.

        An explicit integration of the plain kernel, rtol = 1e-8, no step beyond its stability.
        After the start-up the controller's error is torque / stiffness (5e-4 rad) and its torque
        that of the prescribed motion, both to 1e-2. The error still
        grows with the torque. The
        ledger's states are integrated along: 1e-9 of the energy.
        """
        pins = {"where": "all", "pin_radius": 0.005}
        m = mechanism("three_loop_chain", drive="torque", stiffness=2e3, damping=20.0, **pins)
        rhs, work = kernel(m, "rhs"), np.append(m.work0, 0.0)

        def slope(t, y):
            out = np.zeros_like(y)
            rhs(t, y, m.par, work, out)
            return out

        end = 0.15
        actual = solve_ivp(
            slope, (0.0, end), m.y0, method="DOP853", rtol=1e-8, atol=1e-10, max_step=1e-3
        )
        row, first = observed(m, end, actual.y[:, -1]), observed(m, 0.0)
        wanted = observed(mechanism("three_loop_chain", **pins), end)
        assert row["drives/crank/torque"] == pytest.approx(wanted["drives/crank/torque"], rel=1e-2)
        error = wanted["bodies/link_g/theta"] - row["bodies/link_g/theta"]
        assert error == pytest.approx(wanted["drives/crank/torque"] / 2e3, rel=1e-2)
        size = abs(row["energy/input"]) + abs(row["energy/dissipated"])
        assert abs(row["energy/residual"] - first["energy/residual"]) < 1e-9 * size
        assert row["energy/dissipated"] > 0.0


def derivatives(bound, order=2):
    """Function t -> (value, rate, second derivative) of a signal, as the kernels make it from the
    law's source.
    """
    both = evaluated(traced(bound.law.function).slopes((0,)).slopes((0,)))
    return lambda t: tuple(both(t, *bound.numbers)[i] for i in (0, 1, 3))


CASE = find_case("mobile_manipulator").function.__globals__


def asked(simulation, name, time_constant):
    """The required motion of an actuator."""
    scene = load_case(
        "mobile_manipulator", simulation=simulation, friction="none", time_constant=time_constant
    )
    return next(d.motion for d in scene.loads if d.name == name)


class TestMobileManipulator:
    PATHS = [f"drives/{n}/force" for n in ACTUATORS]

    def tip(self, row):
        angle, (x, y) = row["bodies/bucket/theta"], (0.5 * 0.0910, 0.5 * 0.0764)
        c, s = math.cos(angle), math.sin(angle)
        return row["bodies/bucket/x"] + c * x - s * y, row["bodies/bucket/y"] + s * x + c * y

    @pytest.mark.parametrize(
        ("t", "bare", "rubbed", "tip"),
        [
            (0.0, (-1326.976, 957.648, 325.510), (-816.457, 1866.192, 1782.354), (0.3712, 0.4912)),
            (2.0, (-1334.086, 1070.658, 260.939), (-753.240, 2216.677, 1746.867), (0.2761, 0.4679)),
        ],
    )
    def test_reference(self, t, bare, rubbed, tip, validated):
        """With friction 0.6 units of the last digit: 40-digit virtual power confirms -753.239496
        and 1746.866456.
        """
        row = observed(mechanism("mobile_manipulator", time_constant=0.0), t)
        ideal, forces = ([row[f"{p}{ideal}"] for p in self.PATHS] for ideal in ("_ideal", ""))
        validated("ideal actuator forces", ideal, bare, last(3), unit="N", **CHACKO)
        validated(
            "actuator forces with friction", forces, rubbed, last(3, units=0.6), unit="N", **CHACKO
        )
        validated("tip of the bucket", self.tip(row), tip, last(4), unit="m", **CHACKO)

    def test_friction_forces_by_virtual_power(self, validated):
        """Friction adds the sum of friction times d(joint coordinate) / d(extension), here from the
        cosine law.

        Lengths of the triangle give the angle between its anchors; 1e-9: rounding of central
        differences with
        h = 1e-4 and their error h^4.
        """
        t, h = 2.0, 1e-4
        row = observed(mechanism("mobile_manipulator", time_constant=0.0), t)
        law, slide_law = (mechanism("mobile_manipulator").scene.joints[i].friction for i in (0, 2))
        hinge = (0.0, 0.0)
        for name in ACTUATORS:
            actuator, (bias, amplitude, frequency) = CASE["ACTUATORS"][name], CASE["SWINGS"][name]
            extension = bias + amplitude * math.sin(frequency * t)
            speed = amplitude * frequency * math.cos(frequency * t)
            near = math.hypot(actuator.base[0] - hinge[0], actuator.base[1] - hinge[1])
            far = math.hypot(*actuator.end)

            def corners(s, near=near, far=far, base=actuator.length):
                """Angles of the triangle at the hinge and at both anchors, but for constants."""
                a, b, c = base + s, near, far
                at_hinge = math.acos((b * b + c * c - a * a) / (2 * b * c))
                at_base = math.acos((a * a + b * b - c * c) / (2 * a * b))
                return np.array([at_hinge, at_base, math.pi - at_hinge - at_base])

            slopes = (
                8.0 * (corners(extension + h) - corners(extension - h))
                - (corners(extension + 2 * h) - corners(extension - 2 * h))
            ) / (12.0 * h)
            added = -sum(law(w * speed, 0.0) * w for w in slopes) - slide_law(speed, 0.0)
            actual = row[f"drives/{name}/force"] - row[f"drives/{name}/force_ideal"]
            options = {"source": "virtual power, cosine law", "kind": "independent"}
            validated("friction in actuator forces", actual, added, 1e-9, unit="N", **options)
            hinge = CASE["LINKS"][name][1]

    def test_lever_arms_of_the_figures(self):
        """Lever arm times the pin's speed is the actuator's, from its power; 1e-11 m/s:
        rounding.
        """
        run = cl.inverse_dynamics(load_case("mobile_manipulator"), time=np.linspace(1.0, 40.0, 40))
        for pin, (_, name) in figures.PINS.items():
            turning = figures.lever(run, pin) * figures.turned(run, pin, "omega")
            speed = run.drive(name).power / run.drive(name).force
            np.testing.assert_allclose(turning, speed, atol=1e-11)
            np.testing.assert_allclose(figures.moved(run.time, name, 1)[1], speed, atol=1e-11)

    @pytest.mark.parametrize("simulation", [1, 3])
    def test_accelerations_of_the_figures(self, simulation):
        """Against exact derivatives; 1e-9 of the largest, for differences over tau^2."""
        time = np.array([0.5, 6.02, 20.01, 33.0])
        for name in ACTUATORS:
            motion = derivatives(asked(simulation, name, None))
            exact = np.array([motion(t) for t in time.tolist()]).T
            computed, size = figures.moved(time, name, simulation), abs(exact).max()
            np.testing.assert_allclose(computed, exact, atol=1e-9 * size)

    def test_load_dependent_friction(self):
        """Forces of pins and slides make it: it opposes all rates and adds a tenth of the breakaway
        levels at most.
        """
        row = observed(mechanism("mobile_manipulator", friction="coulomb"), 5.0)
        lost = [v for p, v in row.items() if p.endswith("/power_loss")]
        assert len(lost) == 12
        assert min(lost) > 0.0
        assert 1 < row["friction/iterations"] < 40
        added = [abs(row[p] - row[f"{p}_ideal"]) for p in self.PATHS]
        legacy = observed(mechanism("mobile_manipulator"), 5.0)
        more = [abs(legacy[p] - legacy[f"{p}_ideal"]) for p in self.PATHS]
        assert max(added) < 0.1 * max(more)

    @pytest.mark.parametrize("time_constant", [0.1, 0.01])
    def test_extremum_of_the_start_up(self, time_constant, validated):
        """Of a bias behind the filter: b / T^2 (1 - t / T) exp(-t / T) is lowest at t = 2 T.

        Vertex of a parabola through three points, h = T / 1000: 1e-6 of T.
        """
        motion = derivatives(
            CASE["swing"](bias=0.02, amplitude=0.0, frequency=0.4, time_constant=time_constant)
        )
        middle, h = 2.0 * time_constant, 1e-3 * time_constant
        low, here, high = (motion(t)[2] for t in (middle - h, middle, middle + h))
        wanted = -0.02 / time_constant**2 * math.exp(-2.0)
        validated(
            "largest acceleration of the filter's start-up",
            here,
            wanted,
            1e-12,
            unit="m/s2",
            source="closed form",
            kind="exact",
        )
        assert min(low, high) > here
        vertex = middle - 0.5 * h * (high - low) / (high - 2.0 * here + low)
        assert vertex == pytest.approx(middle, abs=1e-6 * time_constant)

    @pytest.mark.parametrize("simulation", [1, 2, 3])
    @pytest.mark.parametrize("name", ACTUATORS)
    def test_motions_are_the_filters_exact_response(self, simulation, name, validated):
        """T^2 y'' + 2 T y' + y = u with y = y' = 0 at the start, for derivatives as kernels take
        them.

        Tolerance 1e-13 m: rounding of T^2 y'', whose terms are as large as the extension, 0.02 m,
        times 1e-15.
        """
        tau = CASE["TIME_CONSTANTS"][simulation]
        bound = asked(simulation, name, None)
        motion = derivatives(bound)
        assert motion(0.0)[:2] == pytest.approx((0.0, 0.0), abs=1e-17)
        goal = CASE["swung" if simulation == 1 else "dug"]
        numbers = {n: v for n, v in bound.values.items() if n != "time_constant"}
        levels = [0.0, *CASE["DIGS"][name]]
        for t in (1e-3, 0.05, 0.2, 5.99, 6.02, 13.0, 28.1, 39.0, 41.0):
            y, rate, second = motion(t)
            if simulation == 1:
                wanted = goal(t, **numbers, time_constant=0.0)[0]
            else:
                wanted = np.interp(t, [0.0, *CASE["PHASES"]], levels)
            goes_in = tau**2 * second + 2.0 * tau * rate + y
            validated(
                "input of the actuators' filter",
                goes_in,
                wanted,
                1e-13,
                unit="m",
                relative=False,
                source="filter's equation",
                kind="exact",
            )
            assert goal(t, **bound.values)[1] == pytest.approx(rate, abs=1e-14)

    @pytest.mark.parametrize("simulation", [1, 2, 3])
    def test_strokes_stay_away_from_dead_points(self, simulation):
        """Lever arms over the complete run: an actuator's length is far from the sum and the
        difference of its anchors.

        The smallest arm is the bucket's at its largest extension; 20 mm is half of the largest
        there.
        """
        hinge = (0.0, 0.0)
        for name in ACTUATORS:
            bound, actuator = asked(simulation, name, None), CASE["ACTUATORS"][name]
            near = math.hypot(actuator.base[0] - hinge[0], actuator.base[1] - hinge[1])
            far = math.hypot(*actuator.end)
            length = actuator.length + np.array([bound(t) for t in np.linspace(0.0, 40.0, 801)])
            cosine = (near**2 + far**2 - length**2) / (2.0 * near * far)
            arm = near * far * np.sqrt(1.0 - cosine**2) / length
            assert arm.min() > 0.020, name
            hinge = CASE["LINKS"][name][1]

    @pytest.mark.parametrize("simulation", few_of([1, 2, 3], 1))
    def test_whole_run_stays_on_its_branch(self, simulation, validated):
        """Angles between the bodies from the cosine law and the assembly chosen at the start, all
        along 40 s; 1e-9 rad.

        The kernel closes its loops by Newton's method from the step before, here half a second.
        """
        m = mechanism("mobile_manipulator", simulation=simulation, friction="none")
        observe, commit = kernel(m, "observe"), kernel(m, "commit")
        work, row = np.append(m.work0, 0.0), np.zeros(len(m.layout.channels))
        at = [[c.path for c in m.layout.channels].index(f"bodies/{b}/theta") for b in ACTUATORS]
        sides, hinges = (1.0, -1.0, -1.0), [(0.0, 0.0), *(CASE["LINKS"][n][1] for n in ACTUATORS)]
        for t in np.linspace(0.0, 40.0, 81).tolist():
            observe(t, m.y0, m.par, work, row)
            commit(t, m.y0, m.par, work, work)
            relative = np.diff(row[at], prepend=0.0)
            for name, side, hinge, angle in zip(ACTUATORS, sides, hinges, relative, strict=False):
                actuator = CASE["ACTUATORS"][name]
                near, far = np.subtract(actuator.base, hinge), np.array(actuator.end)
                length = actuator.length + asked(simulation, name, None)(t)
                cosine = (near @ near + far @ far - length**2) / (
                    2.0 * math.hypot(*near) * math.hypot(*far)
                )
                wanted = (
                    math.atan2(near[1], near[0])
                    - math.atan2(far[1], far[0])
                    + side * math.acos(cosine)
                )
                off = math.remainder(angle - wanted, 2.0 * math.pi)
                validated(
                    "angles less those of triangles",
                    off,
                    0.0,
                    1e-9,
                    unit="rad",
                    relative=False,
                    source="cosine law",
                    kind="exact",
                )

    @pytest.mark.slow
    def test_found_motion_follows_the_prescribed_one(self):
        """Cylinders under position control, friction smooth at rest, from the filter's start-up on.

        A controller lags by force / stiffness (4e-5 m at most); its force is that of the prescribed
        motion to 1 %. The bucket is the slowest to settle: three pins of slope 2e3 N m s/rad on a
        lever of 34 mm and a stiffness of 5e7 N/m make 0.1 s. Energy closes to rtol times the number
        of steps.
        """
        scene = load_case(
            "mobile_manipulator", friction="breakaway_smooth", drive="force", stiffness=5e7
        )
        result = cl.simulate(scene, until=1.0, samples=5, rtol=1e-6, method="radau5")
        for k in (2, 4):
            row = observed(
                mechanism("mobile_manipulator", friction="breakaway_smooth"), float(result.time[k])
            )
            wanted = np.array([row[p] for p in self.PATHS])
            actual = np.array([result.drive(n).force[k] for n in ACTUATORS])
            assert np.abs(actual - wanted).max() < 0.01 * np.abs(wanted).max()
            lag = np.abs(wanted).max() / 5e7
            for body in ("boom", "stick", "bucket"):
                angle = row[f"bodies/{body}/theta"]
                assert result[body].theta[k] == pytest.approx(angle, abs=3.0 * lag / 0.035)
        assert result.solver["energy_residual_share"] < 1e-4

    @pytest.mark.parametrize(
        ("parameters", "message"),
        [
            ({"simulation": 4}, "simulation must be 1, 2 or 3, got 4"),
            (
                {"simulation": 2, "time_constant": 0.0},
                "dig: time_constant must be positive, got 0.0",
            ),
            ({"time_constant": -1.0}, "swing: time_constant must not be negative, got -1.0"),
            (
                {"friction": "stribeck"},
                "friction must be one of none, breakaway, breakaway_smooth, coulomb; got 'str",
            ),
            ({"drive": "torque"}, "drive must be one of motion, force; got 'torque'"),
        ],
    )
    def test_refusals(self, parameters, message):
        """Options that do not go together are refused."""
        with pytest.raises(ValueError, match=message):
            load_case("mobile_manipulator", **parameters)


@pytest.mark.parametrize(
    ("case", "parameters", "message"),
    [
        ("five_axis_chain", {"reading": "R"}, "reading must be one of P, Q; got 'R'"),
        (
            "five_axis_chain",
            {"friction": "lugre"},
            "friction must be one of none, coulomb, stribeck; got 'lugre'",
        ),
        ("five_axis_chain", {"drive": "force"}, "drive must be one of motion, torque; got 'force'"),
        (
            "five_axis_chain",
            {"friction": "stribeck", "static": 1e-3},
            "joint 1: friction joint_stribeck needs static",
        ),
        ("five_axis_chain", {"pin_radius": 0.0}, "joint 1: pin_radius must be positive, got 0.0"),
        ("three_loop_chain", {"where": "some"}, "where must be one of driven, all; got 'some'"),
        (
            "three_loop_chain",
            {"coefficient": -0.1},
            "joint_coulomb: coefficient must not be negative, got -0.1",
        ),
    ],
)
def test_refusals(case, parameters, message):
    """Wrong options of the cases are refused with their names."""
    with pytest.raises(ValueError, match=message):
        load_case(case, **parameters)
