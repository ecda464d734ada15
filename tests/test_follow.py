"""Branches of periodic motions against a pendulum with a fold in closed form, and the
slider-crank's fold.
"""

import csv
import json
import math

import numpy as np
import pytest

import clearance as cl
from clearance import cli

DAMPING, SPEED = 0.5, 4.0
CASE = f'''
import clearance as cl


def scene(*, torque: float = 0.5, length: int = 1) -> cl.Scene:
    """A pendulum of unit weight and inertia that a torque holds aside, beside a body that turns.

    torque: on the pendulum [N m]
    length: not used [-]
    """
    pivot = {{"pivot": (0, 0)}}
    bob = cl.Body("bob", mass=1.0, inertia=0.75, points=pivot, com=(0, -0.5), angle=0.2)
    rotor = cl.Body("rotor", mass=1.0, inertia=1.0, points=pivot)
    return cl.Scene(
        cl.Revolute(cl.ground, bob["pivot"], name="pivot"),
        cl.Revolute(cl.ground, rotor["pivot"], name="shaft"),
        cl.TorsionSpring(cl.ground, bob, damping={DAMPING}),
        cl.Torque(bob, torque),
        cl.Drive(rotor, speed={SPEED}),
        gravity=(0, -2.0),
        name="held_pendulum",
    )
'''


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    path = tmp_path_factory.mktemp("case") / "held_pendulum.py"
    path.write_text(CASE)
    return path


@pytest.fixture(scope="module")
def branch(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("branch")
    return cl.follow(
        case, "torque", 0.5, 1.2, channels=["bodies/bob/theta"], path=folder, step=0.1
    ), folder


class TestPendulum:
    """theta'' + c theta' + sin theta = T rests at sin theta = T, stable and unstable, which meet
    at T = 1.
    """

    def test_the_fold(self, branch, validated):
        """T = 1. It is located where the parameter has a share of 1e-3 in the tangent: 1e-6 in
        T.
        """
        (fold,) = branch[0].folds
        validated(
            "torque at which a pendulum falls",
            fold,
            1.0,
            1e-5,
            unit="N m",
            source="closed form",
            kind="exact",
        )

    def test_both_branches_and_their_multipliers(self, branch):
        """sin theta = T to 1e-6, and exp(s t), s^2 + c s + cos theta = 0, to 1e-4 of the
        largest.
        """
        period = 2.0 * math.pi / SPEED
        for point in branch[0].points:
            angle = point.outputs[0, 0]
            assert math.sin(angle) == pytest.approx(point.value, abs=1e-6)
            exact = np.exp(period * np.roots([1.0, DAMPING, math.cos(angle)]))
            exact = exact[np.lexsort((-exact.imag, -np.abs(exact)))]
            assert np.abs(point.multipliers - exact).max() < 1e-4 * np.abs(exact).max()
            if not point.kind:
                assert point.stable == (angle < 0.5 * math.pi)

    def test_coexisting_motions(self, branch):
        ((low, high, motions, stable),) = branch[0].coexisting
        assert (low, high) == pytest.approx((0.5, 1.0), abs=1e-5)
        assert (motions, stable) == (2, 1)
        assert branch[0].reason == "the parameter left its range"

    def test_files(self, branch):
        """The table has a row for each point, and HDF5 the same columns."""
        met, folder = branch
        with (folder / "follow.csv").open() as file:
            rows = list(csv.reader(file))
        assert rows[0][0] == "torque [N m]"
        assert [float(row[0]) for row in rows[1:]] == met.values.tolist()
        assert sum(row[1] == "fold" for row in rows) == 1
        assert (folder / "follow.h5").exists()


class TestSliderCrank:
    def test_the_fold(self, validated):
        """Runs settle at 3941.750 rpm and leave at 3941.757 rpm, after thousands of turns:
        within 0.01 rpm.
        """
        dry = {
            "model": "dry",
            "restitution": 0.9,
            "friction": "coulomb",
            "friction_coefficient": 0.03,
        }
        fixed = dry | {"clearance": 1e-3}
        met = cl.follow(
            "slider_crank", "speed", cl.rpm(3925), cl.rpm(3950), fixed=fixed, points=21, step=0.1
        )
        fold, options = (
            met.folds[0] / cl.rpm(1),
            {"source": "plain runs on either side", "kind": "independent"},
        )
        validated(
            "fold of the dry slider-crank's orbit",
            fold,
            3941.7535,
            0.0035,
            unit="rpm",
            relative=False,
            **options,
        )
        assert not met.points[-1].stable


class TestCommand:
    def test_follow(self, case, tmp_path, capsys):
        command = [
            "follow",
            str(case),
            "-p",
            "torque=0.8:1.2",
            "--step",
            "0.1",
            "--channels",
            "bodies/bob/theta",
        ]
        assert cli.main([*command, "-o", str(tmp_path), "--json"]) == 0
        document = json.loads(capsys.readouterr().out)
        assert [b["kind"] for b in document["bifurcations"]] == ["fold"]
        assert document["coexisting"][0]["motions"] == 2
        assert (tmp_path / "follow.png").stat().st_size > 10000
        assert len(document["branch"]["torque"]) == document["points"]

    def test_wrong_input(self, case, tmp_path, capsys):
        for words, said in (
            ((), "one parameter needs a range"),
            (("-p", "torque=0.5:0.5"), "the range begins where it ends"),
            (("-p", "torque=0.5:1", "--over", "nowhere"), "--over belongs to a picture"),
            (("-p", "torque=0.5:1", "--points", "1"), "points must be"),
        ):
            assert cli.main(["follow", str(case), *words]) == 2
            assert said in capsys.readouterr().err

    def test_no_periodic_motion(self, capsys):
        assert (
            cli.main(
                ["follow", "slider_crank", "-p", "speed=5000rpm:6000rpm", "--most-turns", "12"]
            )
            == 1
        )
        assert "no periodic motion within 12 turns" in capsys.readouterr().err
