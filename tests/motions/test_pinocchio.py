"""Inverse dynamics against Pinocchio, whose spatial recursive Newton-Euler shares nothing with ours
but the motion.

Both sides are exact, so only rounding is left between them: 1e-15 to 1e-12 of the largest value
here, more where a loop stands near a dead centre. 1e-10 is what is requested.
"""

import dataclasses
import math

import numpy as np
import pytest

import clearance as cl
from clearance.elements import Drive
from clearance.laws.joint_friction import joint_coulomb
from tests import mechanisms

try:
    import pinocchio

    from tests.oracles import pinocchio as peer
except ImportError:
    pinocchio = None

# its rows: not run
pytestmark = pytest.mark.skipif(pinocchio is None, reason="pinocchio is not installed")

CLOSE = 1e-10
SPATIAL = ("axial_force", "bending_x", "bending_y")
PINOCCHIO = {"source": "Pinocchio, recursive Newton-Euler", "kind": "independent"}


@cl.signal
def wave(time, bias, amplitude, frequency):
    return bias + amplitude * math.sin(frequency * time)


def crane():
    """A tree of all that there is: slides and hinges with either end as the child, points at
    heights, products of inertia, a drive of an absolute angle on the third body, forces, torques
    and springs out of the plane.
    """
    post = cl.Body(
        "post",
        2.0,
        0.03,
        points={"foot": (0.01, 0.0, 0.1), "rail": (0.2, 0.05, 0.3)},
        com=(0.1, 0.02, 0.2),
        products=(0.004, -0.003),
    )
    beam = cl.Body(
        "beam",
        1.5,
        0.02,
        points={"rail": (0.0, 0.02, -0.1), "end": (0.3, 0, 0.05)},
        com=(0.15, -0.01, 0.1),
        products=(-0.002, 0.001),
    )
    hook = cl.Body(
        "hook",
        0.7,
        0.004,
        points={"eye": (0.02, 0.01, -0.04), "tip": (0.1, 0.0, -0.2)},
        com=(0.04, 0.0, 0.03),
    )
    trolley = cl.Body(
        "trolley", 0.4, 0.001, points={"shoe": (0.0, -0.01, 0.02)}, com=(0.01, 0.02, -0.05)
    )
    slide = cl.Prismatic(post["rail"], beam["rail"], axis=(0.8, 0.6), angle=0.3, name="slide")
    shoe = cl.Prismatic(
        trolley["shoe"], beam.at(0.1, 0.0, 0.03), axis=(1.0, -0.2), angle=-0.4, name="shoe"
    )
    eye = cl.Revolute(hook["eye"], beam["end"], name="eye")
    foot = cl.Revolute(cl.ground.at(0.3, -0.1, 0.4), post["foot"], name="foot")
    return cl.Scene(
        eye,
        shoe,
        slide,
        foot,
        cl.Drive(foot, motion=wave(bias=0.4, amplitude=0.5, frequency=3.0), name="slew"),
        cl.Drive(slide, motion=wave(bias=0.1, amplitude=0.08, frequency=5.0), name="reach"),
        cl.Drive(shoe, motion=wave(bias=-0.05, amplitude=0.04, frequency=4.0), name="run"),
        cl.Drive(hook, motion=wave(bias=1.0, amplitude=0.6, frequency=2.0), name="swing"),
        cl.Force(
            hook["tip"], x=3.0, y=wave(bias=1.0, amplitude=4.0, frequency=6.0), z=-2.0, name="wind"
        ),
        cl.Torque(trolley, torque=wave(bias=0.3, amplitude=0.2, frequency=1.0), name="twist"),
        cl.SpringDamper(
            cl.ground.at(0.5, 0.5, 0.2), hook["tip"], stiffness=20.0, damping=1.5, free_length=0.2
        ),
        cl.TorsionSpring(post, hook, stiffness=0.8, damping=0.05, free_angle=0.2),
        gravity=(0.4, -3.0, -9.0),
        name="crane",
    )


def heavy_four_bar():
    """A closed loop with loads out of its plane, which its self-aligning hinge leaves to the
    others.
    """
    crank = cl.Body(
        "crank",
        1.0,
        0.002,
        points={"A": (0, 0, 0.05), "B": (0.05, 0, 0.02)},
        com=(0.02, 0.01, 0.03),
    )
    coupler = cl.Body(
        "coupler",
        2.0,
        0.01,
        points={"B": (0, 0, -0.01), "C": (0.15, 0, 0.04)},
        com=(0.07, 0.01, 0.02),
        angle=0.6,
        products=(0.001, 0.002),
    )
    rocker = cl.Body(
        "rocker",
        1.5,
        0.006,
        points={"D": (0, 0), "C": (0.12, 0, 0.06)},
        com=(0.06, 0, -0.02),
        angle=1.5,
    )
    return cl.Scene(
        cl.Revolute(cl.ground.at(0, 0, 0.1), crank["A"], name="A"),
        cl.Revolute(crank["B"], coupler["B"], name="B"),
        cl.Revolute(rocker["C"], coupler["C"], name="C", self_aligning=True),
        cl.Revolute(rocker["D"], cl.ground.at(0.16, 0), name="D"),
        cl.Drive(crank, speed=12.0, start=0.4, name="motor"),
        gravity=(0.0, 0.0, -9.8),
        name="heavy_four_bar",
    )


def slider_crank(driven: str):
    """A slider-crank on a slanted guide, driven at the crank or at the slider."""
    crank = mechanisms.body("crank", {"A": (0, 0), "B": (0.05, 0)}, com=(0.02, 0.004), angle=0.7)
    rod = mechanisms.body("rod", {"B": (0, 0), "C": (0.18, 0)}, com=(0.08, -0.006), angle=-0.2)
    slider = mechanisms.body("slider", {"C": (0.004, 0.002)}, mass=0.5, position=(0.2, 0.0))
    guide = cl.Prismatic(
        slider.at(0.01, 0.0), cl.ground.at(0.3, 0.0), axis=(1.0, 0.1), angle=0.0, name="guide"
    )
    turning, pushing = (
        cl.Drive(crank, speed=15.0, start=0.7, name="motor"),
        wave(bias=0.11, amplitude=0.02, frequency=9.0),
    )
    return cl.Scene(
        cl.Revolute(cl.ground, crank["A"], name="A"),
        cl.Revolute(crank["B"], rod["B"], name="B"),
        cl.Revolute(rod["C"], slider["C"], name="C"),
        guide,
        turning if driven == "crank" else cl.Drive(guide, motion=pushing, name="motor"),
        name="slider_crank",
    )


def agree(scene, times, validated) -> dict:
    """Every effort and every reaction of the record against Pinocchio's; returns the record's and
    Pinocchio's.
    """
    record = cl.inverse_dynamics(scene, time=times)
    actual = peer.inverse(scene, record)
    efforts = [f"drives/{d}/{n}" for d in record.names("drives") for n in ("torque", "force")]
    reactions = [
        f"joints/{j}/{n}"
        for j in record.names("joints")
        for n in ("force_x", "force_y", "moment", *SPATIAL)
    ]
    compared = {"N": [], "N m": []}
    for path in (p for p in (*efforts, *reactions) if p in record):
        ours = record.values(f"{path}_ideal" if f"{path}_ideal" in record else path)
        compared[record.units(path)].append((path, ours, actual[path]))
    for unit, rows in compared.items():
        size = max((np.abs(ours).max() for _, ours, _ in rows), default=0.0)
        for _, ours, theirs in rows:
            label, options = f"efforts and reactions [{unit}]", PINOCCHIO | {"relative": size}
            validated(f"{label}, {scene.name}", ours, theirs, CLOSE, **options)
    for path in set(actual) - set(efforts) - {p for rows in compared.values() for p, *_ in rows}:
        assert not np.abs(actual[path]).max() > CLOSE, f"{path}: the record has no such channel"
    return record, actual


class TestTrees:
    def test_all_parts_in_space(self, validated):
        """Efforts and reactions agree, and no spatial reaction is zero throughout."""
        record, actual = agree(crane(), np.linspace(0.0, 2.0, 60), validated)
        for joint in ("eye", "shoe", "slide", "foot"):  # nothing of it is trivial
            assert all(np.abs(actual[f"joints/{joint}/{n}"]).max() > 1e-3 for n in SPATIAL)
        assert np.abs(record.values("drives/swing/torque")).max() > 0.1

    @pytest.mark.parametrize("reading", ["P", "Q"])
    def test_five_axis_chain(self, reading, validated):
        """The source's vertical axes: gravity along -z makes axial forces and bending moments
        only.
        """
        record, actual = agree(
            cl.load_case("five_axis_chain", reading=reading), np.linspace(0.0, 5.0, 80), validated
        )
        weight = sum(9.8 * b["mass"] for b in record.scene["bodies"])
        np.testing.assert_allclose(actual["joints/1/axial_force"], weight, rtol=1e-13)

    @pytest.mark.parametrize(
        "scene", [mechanisms.arm, mechanisms.reversed_arm], ids=lambda f: f.__name__
    )
    def test_arms(self, scene, validated):
        """Arms agree, whichever end of a hinge is the child."""
        agree(scene(), np.linspace(0.0, 1.0, 40), validated)


class TestLoops:
    @pytest.mark.parametrize("drive", ["crank", "slider"])
    def test_slider_crank(self, drive, validated):
        """The loop agrees, whether its crank or its slider is driven."""
        agree(
            slider_crank(drive), np.linspace(0.0, 0.4 if drive == "crank" else 0.7, 60), validated
        )

    @pytest.mark.parametrize(
        "name",
        ["watt", "stephenson", "inverted_slider", "moving_guide", "actuator", "scotch_yoke"],
    )
    def test_every_kind_of_group(self, name, validated):
        """Mechanisms of every kind of group agree, as long as they do not lock."""
        until = 0.015 if name == "moving_guide" else 0.25  # it locks soon
        agree(mechanisms.ALL[name](), np.linspace(0.0, until, 40), validated)

    def test_four_bar_with_loads_out_of_its_plane(self, validated):
        """Loads out of the plane bend hinge B; the self-aligning hinge C carries no axial force."""
        record, _ = agree(heavy_four_bar(), np.linspace(0.0, 0.6, 50), validated)
        assert np.abs(record.values("joints/B/bending_x")).max() > 1.0
        assert not record.values("joints/C/axial_force").any()

    def test_four_bar(self, validated):
        """The shipped four-bar agrees over 0.2 s."""
        agree(cl.load_case("four_bar"), np.linspace(0.0, 0.2, 50), validated)

    def test_three_loop_chain(self, validated):
        """The chain agrees over 10 s of its motion."""
        agree(cl.load_case("three_loop_chain"), np.linspace(0.0, 10.0, 60), validated)

    def test_mobile_manipulator(self, validated):
        """The manipulator agrees over its 40 s without friction."""
        agree(
            cl.load_case("mobile_manipulator", friction="none"),
            np.linspace(0.0, 40.0, 400),
            validated,
        )

    def test_efforts_without_friction_where_all_joints_rub(self, validated):
        """Reactions then differ, the ideal efforts do not."""
        scene = cl.load_case("three_loop_chain", where="all")
        record = cl.inverse_dynamics(scene, until=10.0, samples=30)
        actual, ideal = (
            peer.inverse(scene, record)["drives/crank/torque"],
            record.values("drives/crank/torque_ideal"),
        )
        validated(
            "ideal torque where all joints rub", actual, ideal, CLOSE, unit="N m", **PINOCCHIO
        )
        assert np.abs(record.values("drives/crank/torque") - ideal).max() > 0.1


class TestModel:
    @pytest.mark.parametrize(
        "scene", [crane, heavy_four_bar, mechanisms.moving_guide], ids=lambda f: f.__name__
    )
    def test_motion_in_pinocchio(self, scene, validated):
        """Pinocchio's own kinematics put the centres of mass where ours are, with their speeds, and
        close the loops.
        """
        scene = scene()
        record = cl.inverse_dynamics(scene, until=0.015, samples=9)
        model, state = peer.Model(scene), peer.states(scene, record)
        m, flat = model.model, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        coms = {b: model._frame(b.at(*b.com), b.name) for b in scene.bodies}
        data = m.createData()
        for row, q, v, a in zip(state, *model.coordinates(state), strict=True):
            pinocchio.forwardKinematics(m, data, q, v, a)
            pinocchio.updateFramePlacements(m, data)
            for i, frame in enumerate(coms.values()):
                speed = pinocchio.getFrameVelocity(m, data, frame, flat)
                change = pinocchio.getFrameClassicalAcceleration(m, data, frame, flat)
                options, label = PINOCCHIO | {"relative": False}, "Pinocchio's kinematics"
                validated(
                    f"positions by {label}",
                    data.oMf[frame].translation[:2],
                    row[i, :2],
                    1e-12,
                    **options,
                )
                rates = (
                    [*speed.linear[:2], speed.angular[2]],
                    [*change.linear[:2], change.angular[2]],
                )
                validated(f"velocities by {label}", rates[0], row[i, 3:6], 1e-11, **options)
                validated(f"accelerations by {label}", rates[1], row[i, 6:9], 1e-9, **options)
            for cut, ends in zip(model.cuts, model.ends, strict=True):
                points = zip((cut.a, cut.b), ends, strict=True)
                a_at, b_at = (
                    data.oMf[end].translation[:2] if end else (p.x, p.y) for p, end in points
                )
                np.testing.assert_allclose(a_at, b_at, atol=1e-12)

    def test_tree_and_cuts(self):
        """Each joint of the tree adds a body to those before it; one joint of each loop is cut."""
        tree, cuts = peer.spanning_tree(cl.load_case("mobile_manipulator"))
        assert [j.name for j in cuts] == ["boom_end", "stick_end", "bucket_end"]
        placed = {cl.ground}
        for joint, parent, child in tree:
            assert parent in placed
            assert {parent, child} == set(joint.bodies())
            placed.add(child)

    def test_made_up_inertia_is_one_of_a_real_body(self):
        """Principal moments are positive, and the smaller two add up to at least the largest."""
        for scene in (crane(), heavy_four_bar()):
            for i in peer.Model(scene).model.inertias.tolist()[1:]:
                moments = np.linalg.eigvalsh(i.inertia)
                assert moments[0] > 0.0
                assert moments[0] + moments[1] >= moments[2]

    def test_only_efforts_are_asked_for_in_the_loop(self):
        """The timed loop gives what the full answer has."""
        scene = cl.load_case("three_loop_chain")
        record, model = cl.inverse_dynamics(scene, until=10.0, samples=20), peer.Model(scene)
        q, v, a = model.coordinates(peer.states(scene, record))
        efforts, forces = peer.inverse_in_loop(model, q, v, a)
        assert (efforts.shape, forces.shape) == ((20, 1), (20, 3, 2))
        np.testing.assert_allclose(
            efforts[:, 0], record.values("drives/crank/torque_ideal"), rtol=CLOSE
        )
        names = [j.name for j in model.cuts]
        np.testing.assert_allclose(
            forces[:, names.index("g-f")], record.joint("g-f").force, rtol=1e-9
        )


class TestRefused:
    def test_clearance(self):
        """A joint with clearance is refused."""
        with pytest.raises(
            ValueError, match="six_bar_feeder: Pinocchio gets scenes without clearance"
        ):
            peer.Model(cl.load_case("six_bar_feeder", model="dry"))

    def test_torque_drive(self):
        """A drive that gives a torque is refused."""
        with pytest.raises(ValueError, match="all of whose drives prescribe"):
            peer.Model(mechanisms.pushed_four_bar())

    def test_self_aligning_slide_in_a_loop(self):
        """A self-aligning slide is refused by name."""
        scene = slider_crank("crank")
        parts = [dataclasses.replace(j, self_aligning=j.name == "guide") for j in scene.joints]
        with pytest.raises(ValueError, match="joint guide is self-aligning"):
            peer.Model(cl.Scene(*parts, *scene.loads))

    def test_a_free_coordinate(self):
        """A scene with a motion that no drive prescribes is refused by name."""
        scene = mechanisms.arm()
        loads = [d for d in scene.loads if not (isinstance(d, Drive) and d.name == "motor2")]
        with pytest.raises(ValueError, match="arm: its drives do not prescribe all its motion"):
            peer.Model(cl.Scene(*scene.joints, *loads, name="arm"))


def test_friction_of_driven_joints_leaves_reactions_alone(validated):
    """Friction efforts that extend the comparison with a code without friction to all reactions."""
    law = joint_coulomb(coefficient=0.3, viscous=0.2)
    scene = cl.load_case("three_loop_chain")
    joints = {j.name: j for j in scene.joints}
    assert [n for n, j in joints.items() if j.friction] == ["ground-g"]
    strong = dataclasses.replace(joints["ground-g"], friction=law, pin_radius=0.02)
    drive = dataclasses.replace(scene.loads[0], target=strong)
    other = cl.Scene(
        *(strong if j is joints["ground-g"] else j for j in scene.joints),
        drive,
        gravity=scene.gravity,
    )
    record, _ = agree(other, np.linspace(0.0, 10.0, 20), validated)
    assert (
        np.abs(
            record.values("drives/crank/torque") - record.values("drives/crank/torque_ideal")
        ).min()
        > 0.01
    )
