"""Sketches and animations: everything drawn is where the result has it, in every frame; errors are
clear.
"""

import itertools

import numpy as np
import pytest
from clearance.postprocess import animation, drawing, figures
from clearance.postprocess.animation import COLOURS, Lens, animate, frame_times
from clearance.postprocess.drawing import MM, Drawing, Motion, sketch
from clearance.postprocess.shapes import Shapes
from matplotlib.text import Annotation
from PIL import Image

import clearance as cl
from clearance.results.result import Result
from tests import mechanisms
from tests.seeds import few_of

from .records import Gallery

FEEDER = {"joints": "B,C,E"}
MIXED = {
    "model": "mixed",
    "transition": "fuzzy",
    "film": "pinkus_sternlicht",
    "viscosity": 0.005,
    "joints": "B,C",
}


def springs():
    """Free and guided bodies on springs: of one point and two, with the centre of mass aside; a
    slide seen from b.
    """
    free = cl.Body(
        "free",
        1.0,
        1e-2,
        points={"l": (-0.1, 0), "r": (0.1, 0)},
        position=(0, -0.3),
        com=(0.02, 0.03),
    )
    cart, mass = (
        cl.Body("cart", 1.0, 1e-2, points={"c": (0, 0)}),
        cl.Body("mass", 0.5, 1e-3, position=(0.9, -0.2)),
    )
    bob = cl.Body("bob", 0.5, 1e-3, points={"p": (0, 0)}, com=(0, -0.15), angle=0.5)
    return cl.Scene(
        cl.Prismatic(cart["c"], cl.ground.at(0.5, -0.3), axis=(1, 0.5), name="ramp"),
        cl.Revolute(cart["c"], bob["p"], name="H"),
        cl.SpringDamper(
            cl.ground.at(-0.15, 0), free["l"], stiffness=100.0, free_length=0.2, name="s1"
        ),
        cl.SpringDamper(free["r"], cart["c"], stiffness=20.0, free_length=0.3, name="s2"),
        cl.SpringDamper(cl.ground.at(0.9, 0.0), mass, stiffness=100.0, free_length=0.2, name="s3"),
        cl.SpringDamper(cl.ground.at(1.2, -0.3), mass, damping=1.0, name="damper"),
        name="springs",
    )


def wheel():
    """A single body with a single point: nothing has an extent."""
    body = cl.Body("wheel", 1.0, 1e-2, points={"w": (0, 0)})
    return cl.Scene(
        cl.Revolute(cl.ground, body["w"], name="O"), cl.Drive(body, speed=-3.0), name="wheel"
    )


def tripod():
    """An arm of three pins on a line, out of the plane, that an actuator with an outer bar
    holds.
    """
    arm = cl.Body(
        "arm",
        1.0,
        1e-2,
        com=(0.2, 0.0, 0.05),
        angle=0.3,
        points={"near": (0, 0), "mid": (0.2, 0.0, 0.1), "far": (0.4, 0)},
    )
    tube = cl.Body(
        "tube", 0.5, 1e-3, points={"pin": (0, 0), "mouth": (0.15, 0)}, com=(0.05, 0.01), angle=1.2
    )
    rod = cl.Body("rod", 0.2, 1e-3, points={"pin": (0, 0), "piston": (-0.15, 0)}, angle=1.2)
    slide = cl.Prismatic(tube["mouth"], rod["piston"], name="ram")
    return cl.Scene(
        cl.Revolute(cl.ground, arm["near"], name="O"),
        cl.Revolute(cl.ground.at(0.15, -0.25), tube["pin"], name="foot"),
        slide,
        cl.Revolute(rod["pin"], arm["mid"], name="head", self_aligning=True),
        cl.Drive(slide, speed=0.05, start=0.0, name="oil"),
        cl.Force(arm["far"], y=-10.0, name="load"),
        name="tripod",
    )


def crowded():
    """Two driven arms on hinges 50 mm apart, with long names, in a mechanism of 2 m."""
    one, other = (
        cl.Body(f"long_named_arm_{i}", 1.0, 0.1, points={"o": (0, 0), "e": (1.0, 0)})
        for i in (1, 2)
    )
    first = cl.Revolute(cl.ground, one["o"], name="long_named_hinge_1")
    right = cl.Revolute(cl.ground.at(0.05, 0.0), other["o"], name="long_named_hinge_2")
    return cl.Scene(
        first, right, cl.Drive(first, speed=1.0), cl.Drive(right, speed=1.0), name="crowded"
    )


def gears():
    """A planet on a driven carrier, between a sun and a ring that stands still, and a rack."""
    carrier = cl.Body("carrier", 1.0, 1e-3, points={"O": (0, 0), "P": (0.05, 0)})
    planet, sun, rack = (cl.Body(n, 0.5, 1e-4) for n in ("planet", "sun", "rack"))
    ring, axle, shaft = (
        cl.Revolute(carrier[p], b, name=n)
        for p, b, n in (("O", cl.ground, "R"), ("P", planet, "P"), ("O", sun, "S"))
    )
    slide = cl.Prismatic(carrier.at(0.0, 0.03), rack, name="slide")
    teeth = {"stiffness": 1e7, "damping": 1e3}
    return cl.Scene(
        ring,
        axle,
        shaft,
        slide,
        cl.Gear(axle, ring, ratio=2 / 7, **teeth, name="outer"),
        cl.Gear(axle, shaft, ratio=-2 / 3, **teeth, name="inner"),
        cl.Gear(shaft, slide, ratio=-0.03, **teeth, name="pinion"),
        cl.Drive(carrier, speed=1.0),
        name="gears",
    )


def blown():
    """An arm with a torque, a force along the ground, one that turns with it, and none at all."""
    arm = cl.Body("arm", 1.0, 1e-2, points={"o": (0, 0), "e": (0.3, 0)}, com=(0.1, 0), angle=0.4)
    return cl.Scene(
        cl.Revolute(cl.ground, arm["o"], name="O"),
        cl.Force(arm["e"], x=-3.0, name="wind"),
        cl.FollowerForce(arm["e"], y=1.0, name="jet"),
        cl.Force(arm["e"], name="none"),
        cl.Torque(arm, torque=-0.5, name="twist"),
        name="blown",
    )


SCENES = {
    "blown": (blown, {"until": 0.5}),
    "crowded": (crowded, {"turns": 0.5}),
    "tripod": (tripod, {"until": 0.5}),
    "actuator": (mechanisms.actuator, {"until": 0.5}),
    "feeder": (lambda: cl.load_case("six_bar_feeder", **FEEDER), {"turns": 0.5}),
    "mixed": (lambda: cl.load_case("six_bar_feeder", **MIXED), {"turns": 0.2}),
    "slider_crank": (lambda: cl.load_case("slider_crank"), {"turns": 1.0}),
    "four_bar": (lambda: cl.load_case("four_bar"), {"turns": 0.5}),
    "pendulum": (lambda: cl.load_case("double_pendulum"), {"until": 0.5}),
    "inverted_slider": (mechanisms.inverted_slider, {"turns": 0.5}),
    "scotch_yoke": (mechanisms.scotch_yoke, {"turns": 0.5}),
    "watt": (mechanisms.watt, {"turns": 0.5}),
    "reversed_arm": (mechanisms.reversed_arm, {"turns": 0.5}),
    "pushed_four_bar": (mechanisms.pushed_four_bar, {"until": 0.3}),
    "springs": (springs, {"until": 0.5}),
    "wheel": (wheel, {"turns": 0.5}),
    "gears": (gears, {"turns": 0.2}),
}
#: mechanisms that no other test looks at, and all others
ALONE = "pendulum", "reversed_arm", "pushed_four_bar", "wheel", "gears"
DRAWN = ["tripod", "feeder", "slider_crank", "springs", "blown"]
DRAWN += [n for n in SCENES if n not in {*ALONE, *DRAWN, "crowded"}] + ["crowded"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Results by name, each simulated once."""
    folder, results = tmp_path_factory.mktemp("runs"), {}

    def result(name):
        if name not in results:
            scene, span = SCENES[name]
            results[name] = cl.open_result(cl.simulate(scene(), **span).save(folder / f"{name}.h5"))
        return results[name]

    return result


class Without(Result):
    """A result some of whose channels were not stored."""

    dropped: tuple[str, ...] = ()

    def names(self, group):
        return tuple(n for n in super().names(group) if f"{group}/{n}" not in self.dropped)


def without(result, *dropped):
    actual = Without(result.path)
    actual.dropped = dropped
    return actual


@pytest.fixture
def gallery(monkeypatch):
    stored = Gallery(monkeypatch)
    monkeypatch.setattr(drawing, "save", figures.save)
    return stored


def stage(result, frames=8, turns=0.2):
    """A drawing of a result, and the times it is drawn at."""
    times = frame_times(result, turns, frames)
    axes = figures.sheet(6.0, 6.0).add_subplot()
    return Drawing(Motion(result, times), axes), times


@pytest.fixture
def film(monkeypatch):
    """Animation in place of its file: figure, frames and the function that shows one."""
    stored = {}

    def keep(figure, path, fps, frames, show, moving):
        stored.update(figure=figure, frames=frames, show=show, moving=list(moving))
        return path

    monkeypatch.setattr(animation, "save_film", keep)
    return stored


class Paths(Drawing):
    """Lines and faces of a drawing as paths, in the order in which they are drawn."""

    def __init__(self, motion):
        self.paths = []
        super().__init__(motion, None)
        self.paths = [path for _, path in sorted(self.paths, key=lambda pair: pair[0])]

    def line(self, path, **style):
        self.paths.append((style.get("zorder", 3), path))
        self._sweep(path)

    def face(self, path, **style):
        self.line(path, zorder=style["zorder"])


def posed(shape, motion):
    """A shape at the times of a motion, as a page poses it, (times, n, 2) [m]."""
    if "spring" in shape:
        a, b = (posed(shape[end], motion)[:, 0] for end in "ab")
        along, across = np.array([p or (np.nan, np.nan) for p in shape["spring"]]).T
        return drawing.coil(a, b, (along, across), 1.0)
    points = np.array([p or (np.nan, np.nan) for p in shape["points"]])
    body, *origin = shape.get("at", [shape["turn"], 0.0, 0.0])
    at = motion.turned(body, [origin])
    at = at if body == "ground" else at + motion.poses[body][:, None, :2]
    return at + motion.turned(shape["turn"], points)


@pytest.mark.parametrize("name", few_of([*DRAWN[:-1], *ALONE], len(DRAWN) - 1))
def test_shapes_of_a_page_rest_in_their_bodies(name, run):
    """Posed at other times they are where the animation draws them, to 0.2 % of the size of the
    mechanism.

    Rails reach as far as the block is seen to slide at the times of a drawing; a wrong body is off
    by far more.
    """
    result = run(name)
    shapes = Shapes(result)
    motion = Motion(result, result.time[3:-3:7])
    paths = Paths(Motion(result, np.concatenate([shapes.motion.times, motion.times]))).paths
    assert len(shapes.shapes) == len(paths) > 0
    for shape, path in zip(shapes.shapes, paths, strict=True):
        path = np.broadcast_to(path[-len(motion.times) :], (len(motion.times), *path.shape[1:]))
        np.testing.assert_allclose(posed(shape, motion), path, atol=2e-3 * shapes.size)


@pytest.mark.parametrize("name", few_of([*DRAWN, *ALONE], 4))
def test_every_mechanism_is_sketched_and_animated(name, run, tmp_path):
    """Something is drawn, frames differ, and the paper stays white."""
    picture = sketch(run(name), tmp_path / "new" / "still.png", at=0.1)
    with Image.open(picture) as still:
        pixels = np.asarray(still.convert("L"))
    assert 0.005 < (pixels < 250).mean() < 0.5  # something is drawn, and the page is not black
    gif = animate(run(name), tmp_path / "run.gif", turns=0.2, frames=6, fps=20.0)
    with Image.open(gif) as film:
        assert film.n_frames == 6
        shown = []
        for k in range(6):
            film.seek(k)
            assert film.info["duration"] == 50
            shown.append(np.asarray(film.convert("RGB")).astype(int))
    assert all(np.abs(a - b).max() > 100 for a, b in zip(shown, shown[1:], strict=False))
    assert (shown[0][0, 0] == 255).all()  # paper stays white in 256 colours
    assert [p.name for p in tmp_path.iterdir() if p.suffix == ".gif"] == ["run.gif"]


@pytest.mark.parametrize("name", few_of([*DRAWN, *ALONE], len(DRAWN)))
def test_joint_points_of_both_bodies_are_one(name, run):
    """At samples loops are closed to 1e-12 of the size and eccentricities are differences of the
    same poses.
    """
    result = run(name)
    motion = Motion(result, result.time[::7])
    for joint in result.scene["joints"]:
        apart = motion.end(joint["b"]) - motion.end(joint["a"])
        if joint["type"] == "ClearanceRevolute":
            apart = apart - result.joint(joint["name"]).eccentricity[::7]
        if joint["type"] == "Prismatic":
            axis = motion.turned(joint["a"]["body"], joint["axis"])[:, 0]
            apart = axis[:, 0] * apart[:, 1] - axis[:, 1] * apart[:, 0]
        assert np.abs(apart).max() < 1e-9, joint["name"]


@pytest.mark.parametrize("name", ["four_bar", "watt", "inverted_slider"])
def test_joints_hold_between_samples_too(name, run):
    """Cubic Hermite poses err by (w h)^4 / 384 = 2e-10 of the size, with w h = 2 pi / 400: below
    1e-9 m.
    """
    result = run(name)
    times = np.linspace(result.time[0], result.time[-1], 997)
    motion = Motion(result, times)
    for joint in result.scene["joints"]:
        if joint["type"] == "Revolute":
            assert np.abs(motion.end(joint["b"]) - motion.end(joint["a"])).max() < 1e-9, joint[
                "name"
            ]


@pytest.mark.parametrize("name", ["feeder", "slider_crank"])
def test_artists_follow_the_result(name, run):
    """The ring of a clearance joint is drawn at its bearing's centre in every frame."""
    drawn, _ = stage(run(name))
    joints = {j["name"]: j for j in run(name).scene["joints"]}
    for k in (5, 0, 7):
        drawn.show(k)
        for joint, ring in drawn.rings.items():
            at = np.ravel(ring.get_data())
            assert np.abs(at - MM * drawn.motion.end(joints[joint]["a"])[k]).max() < 1e-9


@pytest.mark.parametrize("name", ["inverted_slider", "scotch_yoke", "slider_crank", "springs"])
def test_blocks_stay_on_their_guides(name, run):
    """The middle of a block lies on its guide, between its ends."""
    drawn, _ = stage(run(name), turns=0.5)
    assert drawn.slides
    for slide in drawn.slides.values():
        start, end = np.moveaxis(slide.line(drawn.motion, 0.0), 1, 0)
        along, middle = end - start, slide.corners((0.01, 0.005)).mean(axis=1)
        share = np.sum((middle - start) * along, axis=-1) / np.sum(along**2, axis=-1)
        # poses between samples are interpolated, and a dry joint's impacts bend them: 1e-6 of the
        # guide is unseen
        assert np.abs(middle - start - share[:, None] * along).max() < 1e-6
        assert share.min() > -1e-6
        assert share.max() < 1.0 + 1e-6


@pytest.mark.parametrize("name", ["tripod", "actuator"])
def test_actuators_are_cylinders_round_their_rods(name, run):
    """The piston stays in the cylinder, the rod's pin outside of it, and neither bar is drawn as a
    block.
    """
    drawn, _ = stage(run(name), turns=1.0)
    (slide,) = drawn.slides.values()
    assert slide.cylinder
    motion, (start, end) = drawn.motion, np.moveaxis(slide.line(drawn.motion, 0.0), 1, 0)
    length = np.hypot(*(end - start).T)

    def along(points):
        return np.sum((points - start) * (end - start), axis=-1) / length**2

    pin = motion.points(slide.block, drawn.bodies[slide.block])
    outer = pin[:, int(along(pin[:, 0]).mean() < along(pin[:, 1]).mean())]
    assert along(slide.at).min() > 0.0
    assert along(slide.at).max() < 1.0
    assert along(outer).min() > 1.0
    tube = slide.tube(motion, 0.01)
    assert np.abs(np.hypot(*np.diff(tube, axis=1)[:, 0].T) - length).max() < 1e-12
    assert np.abs(np.hypot(*np.diff(tube, axis=1)[:, 1].T) - 0.02).max() < 1e-12


@pytest.mark.parametrize("name", ["inverted_slider", "scotch_yoke", "springs", "slider_crank"])
def test_blocks_on_guides_are_no_cylinders(name, run):
    """Only actuators between two bodies are."""
    assert not any(s.cylinder for s in stage(run(name))[0].slides.values())


def test_pins_on_a_line_make_a_bar(run):
    """Of three pins on a line the outer two are the ends of a stroke."""
    drawn, _ = stage(run("tripod"), turns=1.0)
    points = drawn.bodies["arm"]
    ends = points[drawing.bar(points)]
    assert sorted(map(tuple, ends)) == [(0.0, 0.0), (0.4, 0.0)]
    assert drawing.bar(np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.1)])) is None
    assert drawing.bar(np.array([(0.0, 0.0)])) is None


def test_the_point_that_a_force_acts_on_is_followed(run, gallery, tmp_path):
    """Its path is bold and where the run has it."""
    sketch(run("tripod"), tmp_path / "s.png")
    (bold,) = (line for line in gallery.last.axes[0].lines if line.get_label() == "path of arm far")
    far = 0.4 * np.stack(
        [np.cos(run("tripod")["arm"].theta), np.sin(run("tripod")["arm"].theta)], axis=-1
    )
    assert np.abs(bold.get_xydata() - MM * far).max() < 1e-9


@pytest.mark.parametrize("name", ["tripod", "crowded", "feeder", "watt"])
def test_names_do_not_hide_each_other(name, run, gallery, tmp_path):
    """No two texts overlap."""
    sketch(run(name), tmp_path / "s.png")
    figure = gallery.last
    figure.canvas.draw()
    names = {t.get_text(): t.get_window_extent() for t in figure.axes[0].texts}
    scene = run(name).scene
    pushed = sum(load["type"] == "Force" for load in scene["loads"])
    assert len(names) == len(scene["joints"]) + len(scene["bodies"]) + pushed
    for a, b in itertools.combinations(names, 2):
        assert not names[a].overlaps(names[b]), (a, b)


def test_round_arrows_turn_as_the_joints_do(run):
    """The wheel turns clockwise; its arrow's arc begins at the right and ends on the other side,
    over the top.
    """
    for name, sense in (("wheel", -1.0), ("four_bar", 1.0)):
        drawn, _ = stage(run(name))
        (arrow,) = (line for line in drawn.axes.lines if line.get_zorder() == 7)
        x, y = (v[:30] for v in arrow.get_data())
        turned = np.unwrap(np.arctan2(y - y.mean(), x - x.mean()))
        assert np.sign(turned[-1] - turned[0]) == sense


def test_arrows_of_forces_point_where_they_push(run):
    """One keeps the direction of the ground, one turns with its body; a force of zero has none. The
    arrow of a negative torque turns clockwise.
    """
    result = run("blown")
    drawn, times = stage(result)
    assert set(drawn.arrows) == {"wind", "jet"}
    for name in drawn.arrows:
        begin, head = drawn.arrows[name]
        np.testing.assert_allclose(begin, drawn.motion.end(result.scene["loads"][0]["point"]))
        angle = np.arctan2(*(head - begin).T[::-1])
        turned = np.interp(times, result.time, result["arm"].theta) + 0.5 * np.pi
        wanted = np.full(len(times), np.pi) if name == "wind" else turned
        np.testing.assert_allclose(np.exp(1j * angle), np.exp(1j * wanted), atol=1e-3)
    (twist,) = (line for line in drawn.axes.lines if len(line.get_xydata()) == len(drawing.ROUND))
    x, y = twist.get_xydata()[:30].T
    sense = np.unwrap(np.arctan2(y - y.mean(), x - x.mean()))
    assert sense[-1] < sense[0]


def test_arrows_of_neighbouring_drives_stay_apart(run):
    """Their circles are smaller than the distance of the hinges."""
    drawn, _ = stage(run("crowded"))
    arrows = [line.get_xydata()[:30] for line in drawn.axes.lines if line.get_zorder() == 7]
    assert len(arrows) == 2
    radii = [0.5 * np.ptp(a[:, 0]) for a in arrows]
    assert sum(radii) < 50.0  # the hinges are 50 mm apart


def test_clocks_of_slow_runs_count_seconds(run):
    """The unit of time suits the step between frames."""
    times = run("pendulum").time
    assert animation._clock(run("pendulum"), times[::10])[1].endswith(" s")
    assert animation._clock(run("pendulum"), times)[1].endswith(" ms")


def test_springs_end_where_they_are_attached(run):
    """Coils and dashpots reach both points, to rounding."""
    drawn, _ = stage(run("springs"))
    for spring in run("springs").scene["loads"]:
        a, b = drawn.motion.end(spring["a"]), drawn.motion.end(spring["b"])
        for shape in (drawing.ZIGZAG, drawing.DASHPOT):
            path = drawing.coil(a, b, shape, 0.01)
            assert np.abs(path[:, 0] - a).max() < 1e-12
            assert np.abs(path[:, -1] - b).max() < 1e-12
    assert np.isfinite(drawing.coil(a, a, drawing.ZIGZAG, 0.01)).all()  # a spring of no length


def test_wheels_touch_at_their_pitch_circles(run):
    """Middle radii of teeth: sun 30, planet 20 and ring 70 mm by the ratios (rounding)."""
    drawn, _ = stage(run("gears"))
    assert drawn.wheels == {"planet", "ground", "sun"}
    for radius in (0.02, 0.03, 0.07):
        radii = np.hypot(*drawing.toothed(radius, 0.002).T)
        assert 0.5 * (radii.min() + radii.max()) == pytest.approx(radius, rel=1e-12)
        spans = [np.ptp(path[0], axis=0).max() / 2.0 for path in drawn.drawn]
        assert min(abs(s - MM * radius) for s in spans) < 0.2 * drawing.PITCH * MM * drawn.size


def circles(figure):
    """Middles and radii [mm] of the walls of the lenses."""
    actual = []
    for line in figure.axes[0].lines:
        x, y = line.get_data()
        if len(x) == 181 and line.get_linewidth() == 0.8:
            actual.append((x[:-1].mean(), y[:-1].mean(), 0.5 * np.ptp(x)))
    return np.array(actual)


@pytest.mark.parametrize("magnify", [None, 120.0])
def test_lenses_show_the_journal_magnified_beside_the_mechanism(magnify, run, film, tmp_path):
    """Each lens states its scale, covers nothing, and has the journal in place."""
    result = run("feeder")
    animate(result, tmp_path / "run.gif", turns=0.3, frames=10, magnify=magnify)
    times = frame_times(result, 0.3, 10)
    message = [t.get_text() for t in film["figure"].findobj(Annotation)]
    message = {float(t.rpartition("×")[2]) for t in message if "×" in t}
    actual = circles(film["figure"])
    assert len(actual) == 3
    assert message == {round(actual[0, 2] / (MM * 1e-4), 6)}
    assert magnify is None or message == {magnify}
    swept = stage(result, 10, 0.3)[0]
    assert (
        (actual[:, 1] + actual[:, 2] < swept.low[1]) | (actual[:, 0] - actual[:, 2] > swept.high[0])
    ).all()
    dots = [
        a
        for a in film["moving"]
        if getattr(a, "get_marker", str)() == "o" and a.get_markersize() == 6.0
    ]
    (zoom,) = message
    for k in (9, 0, 4):
        film["show"](k)
        for dot, joint, (x, y, _) in zip(dots, "BCE", actual, strict=True):
            e = [np.interp(times[k], result.time, v) for v in result.joint(joint).eccentricity.T]
            assert np.ravel(dot.get_data()) == pytest.approx(
                (x + MM * zoom * e[0], y + MM * zoom * e[1]), abs=1e-9
            )


def test_no_contact_is_missed(run):
    """A frame is red where the table has a contact since the frame before, grey where no sample
    near has one either.
    """
    result = run("slider_crank")
    times = frame_times(result, 0.8, 300)
    lens = Lens(result, next(j for j in result.scene["joints"] if j["name"] == "C"), times)
    starts = result.events["time"]
    ends = starts + result.events["duration"]
    before = np.append(times[0] - (times[1] - times[0]), times[:-1])
    hit = ((starts <= times[:, None]) & (ends >= before[:, None])).any(axis=1)
    red = np.array([c == COLOURS["contact"] for c in lens.colours])
    assert 10 < hit.sum() < 300
    assert red[hit].all()
    sampled = result.time[result.joint("C").contact_force > 0.0]
    near = np.abs(sampled[None] - 0.5 * (times + before)[:, None]).min(axis=1) < 2.0 * (
        times[1] - times[0]
    )
    assert not red[~hit & ~near].any()


def test_arrows_are_the_largest_forces_since_the_frame_before(run):
    """No peak between two frames is lost."""
    result = run("slider_crank")
    times = frame_times(result, 0.8, 40)
    lens = Lens(result, next(j for j in result.scene["joints"] if j["name"] == "C"), times)
    force = np.hypot(*result.joint("C").force.T)
    for k in range(1, 40):
        inside = force[(result.time > times[k - 1]) & (result.time <= times[k])]
        assert lens.strength[k] >= inside.max()
        assert lens.strength[k] <= max(inside.max(), np.interp(times[k], result.time, force)) * (
            1.0 + 1e-12
        )


def test_mixed_joints_have_the_colour_of_their_state(run):
    """It is that of the largest membership."""
    result = run("mixed")
    times = result.time[-40:]
    lens = Lens(result, next(j for j in result.scene["joints"] if j["name"] == "B"), times)
    shares = [getattr(result.joint("B"), f"membership_{s}") for s in ("full_film", "mixed", "dry")]
    state = np.argmax(shares, axis=0)[-41:]
    wanted = [COLOURS[("full film", "mixed", "dry")[s]] for s in state[1:]]
    assert lens.colours == wanted


def test_frames_end_with_the_run(run):
    """They are even, and the last is the last sample."""
    result = run("four_bar")
    times = frame_times(result, 0.25, 50)
    assert times[-1] == result.time[-1]
    assert np.allclose(np.diff(times), 0.25 * result.turn / 50, rtol=1e-9)
    assert times[0] == pytest.approx(result.time[-1] - 0.25 * result.turn * 49 / 50)


@pytest.mark.parametrize(
    ("name", "file", "options", "message"),
    [
        ("four_bar", "run.avi", {}, r"run\.avi: its name must end in \.gif or \.mp4"),
        ("four_bar", "run.gif", {"turns": 2.0}, r"turns must lie in \(0, 0\.5\], .*; got 2\.0"),
        ("four_bar", "run.gif", {"turns": float("nan")}, "turns must lie in"),
        (
            "four_bar",
            "run.gif",
            {"turns": 0.5, "frames": 201},
            "frames: 201 asked, but .* has 200 samples",
        ),
        (
            "four_bar",
            "run.gif",
            {"turns": 0.5, "frames": 1},
            "frames must be a whole number of at least 2, got 1",
        ),
        (
            "four_bar",
            "run.gif",
            {"turns": 0.5, "fps": 0.0},
            r"fps must lie in \(0, 50\] for a "
            r"\.gif, got 0\.0",
        ),
        (
            "four_bar",
            "run.gif",
            {"turns": 0.5, "fps": 60},
            r"fps must lie in \(0, 50\] for a "
            r"\.gif, got 60",
        ),
        (
            "four_bar",
            "run.gif",
            {"turns": 0.5, "magnify": 10.0},
            "magnify this mechanism has no clearance joint",
        ),
        (
            "feeder",
            "run.gif",
            {"turns": 0.5, "magnify": -1.0},
            "magnify must be a positive number, got -1.0",
        ),
        (
            "feeder",
            "run.gif",
            {"turns": 0.5, "magnify": 1e5},
            "magnify must be at most .*; got 100000.0",
        ),
    ],
)
def test_what_cannot_be_animated_is_refused(name, file, options, message, run, tmp_path):
    """The message has the option, and no file is left."""
    with pytest.raises(ValueError, match=message):
        animate(run(name), tmp_path / file, **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("at", [-0.1, 0.6, float("nan")])
def test_sketch_outside_the_run_is_refused(at, run, tmp_path):
    """The message has the times of the run."""
    with pytest.raises(ValueError, match=r"at must lie in \[0, 0\.5\], .*; got"):
        sketch(run("four_bar"), tmp_path / "still.png", at=at)


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("slider_crank", "bodies/slider/theta"),
        ("slider_crank", "joints/C/eccentricity_y"),
        ("slider_crank", "joints/C/force_x"),
        ("slider_crank", "joints/C/contact_force"),
        ("mixed", "joints/B/membership_dry"),
    ],
)
def test_a_channel_not_kept_is_named(name, channel, run, tmp_path):
    """An animation needs it; a sketch needs poses only."""
    result = without(run(name), channel)
    with pytest.raises(ValueError, match=channel):
        animate(result, tmp_path / "run.gif", turns=0.2, frames=5)
    if channel.startswith("joints"):
        assert sketch(result, tmp_path / "still.png").exists()  # a sketch needs poses only
    assert not (tmp_path / "run.gif").exists()


def test_rates_may_be_missing(run, tmp_path):
    """Poses alone are enough."""
    rates = [
        f"bodies/{b}/{c}" for b in ("crank", "coupler", "rocker") for c in ("vx", "vy", "omega")
    ]
    gif = animate(without(run("four_bar"), *rates), tmp_path / "run.gif", turns=0.5, frames=5)
    with Image.open(gif) as film:
        assert film.n_frames == 5


def test_mp4_without_ffmpeg_says_what_to_do(run, tmp_path, monkeypatch):
    """The message names the programme and the other format."""
    monkeypatch.setattr(figures.shutil, "which", lambda _: None)
    with pytest.raises(
        ValueError, match=r"ffmpeg, which is not installed; install it or use \.gif"
    ):
        animate(run("four_bar"), tmp_path / "run.mp4", turns=0.5, frames=5)


@pytest.mark.skipif(figures.shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_mp4_with_ffmpeg(run, tmp_path):
    """The file is a film, and nothing else is left."""
    film = animate(run("four_bar"), tmp_path / "run.mp4", turns=0.5, frames=5)
    assert film.read_bytes()[4:8] == b"ftyp"
    assert list(tmp_path.iterdir()) == [film]


def test_a_failure_leaves_the_old_file_and_no_half_one(run, tmp_path, monkeypatch):
    """A film that broke off changes no file."""
    path = tmp_path / "run.gif"
    path.write_bytes(b"old")
    show, shown = Drawing.show, []

    def fail(self, k):
        shown.append(k)
        if k == 3:
            raise RuntimeError("the disk is full")
        show(self, k)

    monkeypatch.setattr(Drawing, "show", fail)
    with pytest.raises(RuntimeError, match="the disk is full"):
        animate(run("four_bar"), path, turns=0.5, frames=6)
    assert shown[-1] == 3
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == b"old"
