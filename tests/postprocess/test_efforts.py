"""Efforts and joint friction: what is drawn is what the run has, many joints stay readable, what is
missing is stated.
"""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from clearance.postprocess import figures, plots
from clearance.postprocess.channels import channel, expand
from clearance.postprocess.efforts import (
    MOST,
    efforts,
    friction,
    groups,
    joint_friction,
    largest,
    rate,
)
from clearance.postprocess.labels import about, labels_of, title

import clearance as cl
from clearance.laws.joint_friction import breakaway_smooth, joint_coulomb, joint_stribeck

from .records import Formula

BENT = {"pin_radius": 0.01, "friction_arm": 0.02, "bending_arm": 0.05}


@cl.signal
def swing(time, amplitude, frequency):
    return amplitude * math.sin(frequency * time)


def cart(drives=True):
    """A driven cart on a rail with a driven arm out of its plane; both joints rub."""
    body = cl.Body("cart", 2.0, 0.02, points={"c": (0.0, 0.0)})
    arm = cl.Body(
        "arm", 1.0, 0.01, com=(0.3, 0.0, 0.05), points={"pin": (0.0, 0.0), "tip": (0.6, 0.0)}
    )
    sliding = joint_stribeck(static=0.3, kinetic=0.1, stribeck_rate=0.2, viscous=1.0)
    rail = cl.Prismatic(
        cl.ground, body["c"], name="rail", friction=sliding, overlap=0.1, friction_arm=0.05
    )
    hinge = cl.Revolute(
        body["c"], arm["pin"], name="hinge", friction=joint_coulomb(coefficient=0.1), **BENT
    )
    moved = (
        cl.Drive(hinge, speed=4.0, name="motor"),
        cl.Drive(rail, motion=swing(amplitude=0.2, frequency=3.0), name="ram"),
    )
    return cl.Scene(rail, hinge, *(moved if drives else ()), name="cart")


def fan(count, rubbing=True):
    """Many driven arms on ground, each heavier than the one before; every hinge rubs."""
    law = joint_coulomb(coefficient=0.1) if rubbing else None
    parts = []
    for i in range(count):
        arm = cl.Body(f"arm{i}", 1.0 + i, 0.01, com=(0.1, 0.0), points={"o": (0.0, 0.0)})
        hinge = cl.Revolute(
            cl.ground.at(0.3 * i, 0.0), arm["o"], name=f"hinge_{i}", friction=law, pin_radius=0.01
        )
        parts += [hinge, cl.Drive(hinge, speed=2.0, name=f"motor_{i}")]
    return cl.Scene(*parts, name="fan")


@pytest.fixture(scope="module")
def run():
    return cl.inverse_dynamics(cart(), until=3.0, samples=301)


@pytest.fixture(scope="module")
def crowd():
    return cl.inverse_dynamics(fan(12), until=1.0, samples=21)


@pytest.fixture
def page(monkeypatch):
    """The figure of an overview."""
    stored = []
    monkeypatch.setattr(plots, "save", lambda figure, path, dpi: stored.append(figure))
    return stored


def labels(figure):
    return [axes.get_ylabel() for axes in figure.axes]


def drawn(axes):
    """Curves by name; those without one by their number."""
    return {line.get_label(): line.get_ydata() for line in axes.lines if len(line.get_xdata())}


def test_efforts_are_those_of_the_run(run, gallery, tmp_path):
    """Entire effort solid, ideal one dashed, their difference beneath."""
    efforts(run, tmp_path / "e.png")
    torque, torque_added, force, force_added = gallery.last.axes
    assert labels(gallery.last) == [
        "driving torque [N m]",
        "torque for friction [N m]",
        "driving force [N]",
        "force for friction [N]",
    ]
    for axes, added, drive, kind in (
        (torque, torque_added, "motor", "torque"),
        (force, force_added, "ram", "force"),
    ):
        channels = run.drive(drive)
        entire, ideal = getattr(channels, kind), getattr(channels, f"{kind}_ideal")
        solid, dashed = (line for line in axes.lines if len(line.get_xdata()))
        assert (solid.get_ydata() == entire).all()
        assert (dashed.get_ydata() == ideal).all()
        assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
        assert solid.get_color() == dashed.get_color() == added.lines[0].get_color()
        assert (added.lines[0].get_ydata() == entire - ideal).all()
    (legend,) = gallery.last.legends
    assert [t.get_text() for t in legend.get_texts()] == ["motor", "ram", "without friction"]


def test_without_friction_there_are_only_efforts(gallery, tmp_path):
    """No panel for friction where nothing rubs."""
    efforts(cl.inverse_dynamics(fan(3, rubbing=False), until=1.0, samples=11), tmp_path / "e.png")
    assert labels(gallery.last) == ["driving torque [N m]"]
    assert "without friction" not in gallery.texts()


def test_rates_are_those_of_the_bodies(run):
    """The rail lies on x, so its rate is the cart's velocity; power over friction rounds to 1e-15
    of it.
    """
    assert (rate(run, "hinge") == run["arm"].omega - run["cart"].omega).all()
    assert np.abs(rate(run, "rail") - run["cart"].vx).max() < 1e-14
    dead = {"joints/rail/friction": [0.0, -2.0], "joints/rail/power_loss": [0.0, 1.0]}
    slide = {"name": "rail", "type": "Prismatic", "a": {"body": "ground"}, "b": {"body": "slider"}}
    actual = rate(Formula([0.0, 1.0], dead, joints=[slide]), "rail")
    assert np.isnan(actual[0])
    assert actual[1] == 0.5


def test_friction_is_that_of_the_run(run, gallery, tmp_path):
    """Each joint's friction and loss, over the run."""
    friction(run, tmp_path / "f.png")
    torque, load, curve, force, _, slide_curve = gallery.last.axes
    assert (drawn(torque)["hinge"] == run.joint("hinge").friction).all()
    assert (drawn(load)["hinge"] == run.joint("hinge").friction_load).all()
    assert (drawn(force)["rail"] == run.joint("rail").friction).all()
    assert curve.get_xlabel() == "rate of b against a [rad/s]"
    assert slide_curve.get_xlabel() == "rate of b against a [m/s]"
    (line,) = slide_curve.lines
    points = {tuple(p) for p in np.stack([rate(run, "rail"), run.joint("rail").friction], axis=-1)}
    assert {tuple(p) for p in line.get_xydata()} <= points
    # neighbours closer than a printed dot are one
    assert len(line.get_xydata()) > 0.9 * len(points)
    # friction jumps where the rate changes sign: samples are not joined
    assert line.get_linestyle() == "None"


def test_joints_can_be_chosen(run, gallery, tmp_path):
    """Only the chosen ones are drawn."""
    friction(run, tmp_path / "f.png", joints="rail")
    assert labels(gallery.last) == ["friction force [N]", "friction load [N]", "friction force [N]"]


def test_laws_without_a_load_have_no_panel_for_it(gallery, tmp_path):
    """Friction that does not depend on a load shows none."""
    arm = cl.Body("arm", 1.0, 0.01, com=(0.1, 0.0))
    hinge = cl.Revolute(
        cl.ground, arm, name="pin", friction=breakaway_smooth(breakaway=1.0, coulomb=0.5)
    )
    moved = cl.Drive(hinge, motion=swing(amplitude=0.5, frequency=3.0), name="motor")
    friction(
        cl.inverse_dynamics(cl.Scene(hinge, moved, name="arm"), until=2.0, samples=51),
        tmp_path / "f.png",
    )
    assert labels(gallery.last) == ["friction torque [N m]"] * 2


def test_coupled_friction_says_how_it_was_found(gallery, tmp_path):
    """The title has the iterations."""
    scene = cl.load_case("four_bar", model="ideal")
    reference = {j.name: j for j in scene.joints}
    rubbing = [
        cl.Revolute(
            j.a, j.b, name=j.name, friction=joint_coulomb(coefficient=0.1), pin_radius=0.005
        )
        for j in reference.values()
    ]
    result = cl.inverse_dynamics(
        cl.Scene(*rubbing, *scene.loads, name="rubbing"), turns=1.0, samples=41
    )
    friction(result, tmp_path / "f.png")
    most = result.values("friction/iterations").max()
    message = gallery.text
    assert f"coupled friction: at most {most:.0f} iterations" in message


def test_of_many_the_largest_are_drawn(crowd, gallery, tmp_path):
    """Arms grow heavier, so the last eight load their motors and hinges most; their order stays."""
    efforts(crowd, tmp_path / "e.png")
    wanted = [f"motor_{i}" for i in range(4, 12)]
    assert gallery.legend == [
        *wanted,
        "without friction",
    ]
    assert gallery.last.axes[0].get_title(loc="right") == "the 8 largest of 12"
    (group,) = groups(crowd, joint_friction(crowd))
    assert list(group.paths) == [f"hinge_{i}" for i in range(4, 12)]
    strokes = [(group.styles[n]["color"], group.styles[n]["ls"]) for n in group.paths]
    assert len(set(strokes)) == MOST


def test_few_are_all_drawn():
    """Up to the limit no curve is left out."""
    values = {str(i): np.full(3, float(i)) for i in range(MOST)}
    assert largest(values) == (values, "")


# --- overview
def test_overview_of_joints_that_rub(run, page, tmp_path):
    """Panels for friction, bending moments and losses, with their total."""
    plots.overview(run, tmp_path / "o.png")
    assert labels(page[0]) == [
        "driving torque [N m]",
        "driving force [N]",
        "acceleration x [m/s²]",
        "kinetic energy [J]",
        "friction torque [N m]",
        "friction force [N]",
        "joint force [N]",
        "bending moment [N m]",
        "power lost [W]",
    ]
    reactions, moments, losses = page[0].axes[-3:]
    assert np.allclose(
        drawn(reactions)["hinge"], np.hypot(*run.joint("hinge").force.T), rtol=1e-15, atol=0.0
    )
    assert (drawn(moments)["hinge"] == np.hypot(*run.joint("hinge").bending.T)).all()
    lost = [run.joint(j).power_loss for j in ("hinge", "rail")]
    assert (drawn(losses)["all joints"] == lost[0] + lost[1]).all()
    legend = page[0].axes[4].get_legend()
    assert [t.get_text() for t in legend.get_texts()] == ["hinge", "rail", "all joints"]


def test_overview_of_axial_forces(page, tmp_path):
    """Gravity along the axis: the reaction is in space."""
    hinges = [
        cl.Revolute(j.a, j.b, name=j.name, friction=j.friction, **BENT) for j in fan(2).joints
    ]
    moved = [cl.Drive(j, speed=2.0, name=f"motor_{j.name}") for j in hinges]
    scene = cl.Scene(*hinges, *moved, gravity=(0.0, 0.0, -9.81), name="fan")
    result = cl.inverse_dynamics(scene, until=1.0, samples=11)
    plots.overview(result, tmp_path / "o.png")
    axes = next(a for a in page[0].axes if a.get_ylabel() == "joint force\nwith axial part [N]")
    channels = result.joint("hinge_1")
    force = np.sqrt(channels.force_x**2 + channels.force_y**2 + channels.axial_force**2)
    assert np.abs(drawn(axes)["hinge_1"] - force).max() < 1e-12 * force.max()


def test_overview_of_a_file_with_its_energies(tmp_path):
    """A file is drawn as a run in memory is."""
    result = cl.simulate(cart(), until=1.0, samples=101, path=tmp_path / "cart.h5")
    picture = plots.overview(result, tmp_path / "o.png")
    assert picture.stat().st_size > 60000


def test_overview_of_friction_beside_a_clearance(page, tmp_path):
    """Both kinds of joint have their panels."""
    upper = cl.Body("upper", 1.0, 0.02, points={"o": (0.0, 0.0), "p": (0.5, 0.0)}, com=(0.25, 0.0))
    lower = cl.Body("lower", 1.0, 0.02, points={"p": (0.0, 0.0)}, com=(0.25, 0.0))
    law = joint_coulomb(coefficient=0.1, transition_rate=1e-2)
    scene = cl.Scene(
        cl.Revolute(cl.ground, upper["o"], name="A", friction=law, pin_radius=0.02),
        cl.ClearanceRevolute(
            upper["p"],
            lower["p"],
            name="B",
            radius=0.01,
            clearance=1e-4,
            contact=cl.kelvin_voigt(stiffness=1e7, damping=1e3),
        ),
        name="pendulum",
    )
    plots.overview(cl.simulate(scene, until=0.05, samples=51), tmp_path / "o.png")
    assert labels(page[0])[-2:] == ["friction torque [N m]", "power lost [W]"]
    assert "eccentricity y / c [-]" in labels(page[0])


@pytest.mark.parametrize("rubbing", [True, False])
def test_many_joints_stay_readable(rubbing, crowd, page, tmp_path):
    """At most 8 curves and their total in a panel, and legends no broader than half the page."""
    result = (
        crowd if rubbing else cl.inverse_dynamics(fan(12, rubbing=False), until=1.0, samples=21)
    )
    plots.overview(result, tmp_path / "o.png")
    (figure,) = page
    figure.canvas.draw()
    message = " ".join(t.get_text() for a in figure.axes for t in (a.yaxis.label, a._right_title))
    assert "the 8 largest of 12" in message
    for axes in figure.axes:
        assert (
            len([n for n in axes.get_legend_handles_labels()[1] if n != "all joints"]) <= MOST + 1
        )
        assert axes.get_window_extent().width > 0.3 * figure.bbox.width
        if axes.get_legend():
            assert axes.get_legend().get_window_extent().width < 0.5 * figure.bbox.width


@pytest.mark.parametrize(
    ("names", "columns"), [(["a", "b"], 2), (["long name " * 6] * 3, 1), (["a" * 10] * 8, 5)]
)
def test_legends_above_take_the_rows_they_need(names, columns):
    """Axes of about 7 inch: no legend is broader, by its drawn letters."""
    axes = figures.sheet(8.0, 3.0).add_subplot()
    for i, name in enumerate(names):
        axes.plot([0.0], [0.0], label=f"{name}{i}")
    figures.legend_above(axes)
    axes.figure.canvas.draw()
    boxes = [t.get_window_extent() for t in axes.get_legend().get_texts()]
    assert len({round(b.x0) for b in boxes}) == columns
    assert axes.get_legend().get_window_extent().width < axes.get_window_extent().width


# --- names
def test_runs_are_told_apart_by_their_friction():
    """Labels are the numbers or laws that differ."""

    def label(law, radius=0.01):
        arm = cl.Body("arm", 1.0, 0.01, com=(0.1, 0.0))
        pin = cl.Revolute(cl.ground, arm, name="pin", friction=law, pin_radius=radius)
        return cl.inverse_dynamics(
            cl.Scene(pin, cl.Drive(pin, speed=3.0), name="arm"), turns=1.0, samples=5
        )

    smooth, rough, free = (
        label(joint_coulomb(coefficient=0.1)),
        label(joint_coulomb(coefficient=0.3)),
        label(None),
    )
    printed = [f"coefficient of joint friction {value}" for value in ("0.1", "0.3")]
    assert labels_of([smooth, rough]) == printed
    laws = [n.split(",")[0] for n in labels_of([smooth, free])]
    assert laws == ["joint friction joint_coulomb", "joint friction none"]
    wide = label(joint_coulomb(coefficient=0.1), radius=0.02)
    assert labels_of([smooth, wide]) == ["pin radius 10 mm", "pin radius 20 mm"]
    assert title(smooth) == "28.65 rpm, joint_coulomb in joint pin"


@pytest.mark.parametrize("beside", [{}, {"asperity": {"law": "greenwood_tripp"}}])
def test_a_film_with_summits_is_mixed(beside):
    """A film that is contact too has no transition."""
    joint = {"name": "B", "clearance": 1e-4, "film": {"law": "elastic"}} | beside
    record = SimpleNamespace(turn=None, scene={"joints": [joint]})
    assert about(record) == [f"B {'mixed' if beside else 'lubricated'} c = 0.1 mm"]


def test_titles_count_many_joints(crowd, run):
    """Few are named with their law, many counted."""
    assert about(crowd)[1] == "joint_coulomb in 12 joints"
    assert about(run)[1:] == ["joint_stribeck in joint rail", "joint_coulomb in joint hinge"]


def test_channels_of_friction_have_names(run):
    """Labels for ideal efforts; patterns for counts of iterations."""
    assert channel(run, "motor.torque_ideal").label == "motor torque without friction"
    record = Formula(
        [0.0, 1.0],
        {"friction/iterations": [3.0, 4.0], "friction/contraction": [0.1, 0.2]},
        speed=None,
    )
    assert channel(record, "friction.iterations").label == "friction iterations"
    assert expand(record, "friction.*") == ["friction/iterations", "friction/contraction"]


# --- what is not there
def test_what_a_run_has_not_got_is_said(tmp_path):
    """Missing drives, friction and channels are named, and nothing is written."""
    idle = cl.simulate(cl.load_case("double_pendulum"), until=0.1, samples=5)
    with pytest.raises(ValueError, match=r"run\.h5: this run has no drive"):
        efforts(idle, tmp_path / "e.png")
    with pytest.raises(ValueError, match=r"run\.h5: this run has no joint friction"):
        friction(idle, tmp_path / "f.png")
    little = cl.simulate(cart(), until=0.1, samples=5, channels=["bodies/cart"])
    with pytest.raises(ValueError, match="this run has stored no driving effort"):
        efforts(little, tmp_path / "e.png")
    with pytest.raises(ValueError, match="this run has stored no joint friction"):
        friction(little, tmp_path / "f.png")
    lossless = cl.simulate(
        cart(), until=0.1, samples=5, channels=["joints/*/friction", "bodies/*/omega"]
    )
    with pytest.raises(ValueError, match="channel joints/rail/power_loss of .* was not stored"):
        friction(lossless, tmp_path / "f.png")
    assert not list(tmp_path.iterdir())


def test_other_joints_are_refused(run, tmp_path):
    """The message names the joints that rub."""
    with pytest.raises(
        ValueError, match=re.escape("no friction of joint 'door' in run.h5; of rail, hinge")
    ):
        friction(run, tmp_path / "f.png", joints=["hinge", "door"])
