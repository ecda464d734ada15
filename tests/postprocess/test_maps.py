"""Maps, curves and samples of sweeps that are made of formulas, and bifurcation diagrams of one
that was run.
"""

import numpy as np
import pytest
from clearance.postprocess import figures
from clearance.postprocess.labels import shown_in
from clearance.postprocess.maps import (
    Choice,
    bifurcation_of,
    by_ratio,
    chosen_metrics,
    curves,
    edges,
    maps,
)
from clearance.postprocess.sections import section
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, LogNorm
from matplotlib.contour import QuadContourSet
from matplotlib.patches import PathPatch
from numpy.testing import assert_allclose

import clearance as cl
from clearance.sweeping import definition as definitions
from clearance.sweeping.index import Sweep
from clearance.sweeping.points import grid, sampled, zipped
from tests.postprocess.records import plain

RPM = np.pi / 30.0
UNITS = {
    "speed": "rad/s",
    "clearance": "m",
    "viscosity": "Pa s",
    "model": "-",
    "joints": "-",
    "restitution": "-",
}
SPEEDS, CLEARANCES = RPM * np.array([100.0, 200.0, 300.0, 400.0]), np.geomspace(5e-5, 1e-3, 5)


def force(speed, clearance, **_):
    """A metric that is linear in both [N]."""
    return speed * 1e3 + clearance * 1e6


def steep(speed, clearance, **_):
    """A metric over decades [N]."""
    return speed**2 / clearance


BOTH = grid(speed=SPEEDS, clearance=CLEARANCES)


@pytest.fixture
def sweep_of(tmp_path):
    """A sweep over points, its metrics given as functions of a point, in SI."""

    def make(points=BOTH, metrics={"force": force}, reference=None, fixed=None):  # noqa: B006
        definitions.write(
            definitions.Definition(
                case="formula",
                path="formula",
                source="",
                points=points,
                fixed=fixed or {},
                options={"turns": 4.0},
                keep=(),
                compression=0,
                settle=None,
                own=(),
                units={n: UNITS[n] for n in points.columns},
            ),
            tmp_path,
        )
        sweep = Sweep(tmp_path)
        sweep.status = np.full(len(points), "done", dtype="<U8")
        sweep.metrics = {
            n: np.array([float(f(**points[i])) for i in range(len(points))])
            for n, f in metrics.items()
        }
        sweep.known = reference or {n: ("N", f"force {n}") for n in metrics}
        return sweep

    return make


def cells(axes) -> dict[tuple[float, float], float]:
    """Value of each coloured cell by the middle of its edges along x and the geometric middle along
    y.
    """
    corners, values = mesh(axes).get_coordinates(), mesh(axes).get_array()
    x, y = corners[0, :, 0], corners[:, 0, 1]
    middle_x, middle_y = 0.5 * (x[1:] + x[:-1]), np.sqrt(y[1:] * y[:-1])
    return {
        (float(round(u, 6)), float(round(v, 9))): values[j, i]
        for j, v in enumerate(middle_y)
        for i, u in enumerate(middle_x)
    }


def hatched(axes) -> int:
    """Cells in the one outline of each kind of hatch."""
    outlines = [p.get_path() for p in axes.patches if isinstance(p, PathPatch)]
    return sum(np.count_nonzero(outline.codes == outline.MOVETO) for outline in outlines)


def mesh(axes):
    """Its coloured cells."""
    return next(c for c in axes.collections if isinstance(c, QuadMesh))


def norm(axes):
    """The scale of their colours."""
    return mesh(axes).norm


@pytest.fixture
def draw(tmp_path, gallery):
    """A function that draws a picture of a sweep and gives its panels."""

    def drawn(kind, sweep, **options):
        assert kind(sweep, tmp_path / "m.png", **options).read_bytes().startswith(b"\x89PNG")
        return gallery.panels

    return drawn


# --- scales
def test_edges():
    """Half-way between the points, by ratio on a logarithmic axis, and never below zero for
    positive values.
    """
    assert_allclose(edges(np.array([1.0, 2.0, 4.0]), log=False), [0.5, 1.5, 3.0, 5.0])
    assert_allclose(edges(np.array([1.0, 10.0, 1000.0]), log=True), [10**-0.5, 10**0.5, 100.0, 1e4])
    # half-way below lies -150, which is no speed
    assert edges(np.array([100.0, 600.0, 700.0]), log=False)[0] == 0.0
    assert edges(np.array([-1.0, 1.0]), log=False)[0] == -2.0


@pytest.mark.parametrize(
    ("values", "ratio"),
    [
        (np.linspace(1.0, 100.0, 20), False),
        (np.geomspace(1.0, 100.0, 20), True),
        (np.geomspace(1.0, 4.0, 20), False),
        ([1.0, 3.0, 10.0], True),
        ([0.0, 1.0, 10.0, 100.0], False),
        ([-10.0, 1.0, 10.0], False),
        ([1.0, 100.0], False),
    ],
)
def test_by_ratio(values, ratio):
    """Values that grow by a ratio over more than a decade have a logarithmic axis."""
    assert by_ratio(np.array(values)) is ratio


@pytest.mark.parametrize(
    ("units", "values", "unit", "factor"),
    [
        ("rad/s", [0.0, 30.0], "rpm", 30.0 / np.pi),
        ("m", [5e-5, 5e-4], "mm", 1e3),
        ("m", [-1e-3, 1e-6], "mm", 1e3),
        ("m", [5e-5], "mm", 1e3),
        ("m", [2e-6, 1.6e-5], "µm", 1e6),
        ("m", [np.nan, np.inf, 2.0], "m", 1.0),
        ("m", [np.nan], "µm", 1e6),
        ("Pa s", [0.04], "mPa s", 1e3),
        ("N", [2e4], "kN", 1e-3),
        ("J", [], "µJ", 1e6),
        ("N m", [2e4], "N m", 1.0),
        ("1", [0.1], "1", 1.0),
    ],
)
def test_display_units(units, values, unit, factor):
    """The prefix is that of the largest finite value."""
    assert shown_in(units, values) == (unit, factor)


def test_titles_of_lives(sweep_of):
    """They name the turns of the lives, not those of the runs in them."""
    sweep = sweep_of(grid(speed=SPEEDS), {"depth": lambda speed: speed})
    sweep.definition.options["life"] = {"turns": 3000.0}
    title = Choice.of(sweep, None).title(width=7.0)
    assert plain(title) == "formula: lives of 3000 turns"


# --- maps
def test_cells_stand_where_the_points_are(sweep_of, draw, gallery):
    """Values swept in any order; a logarithmic axis has its points in the geometric middle of their
    cells.
    """
    sweep = sweep_of(
        grid(clearance=CLEARANCES[::-1], speed=SPEEDS[[2, 0, 3, 1]]),
        {"force": force, "steep": steep},
    )
    first, second = draw(maps, sweep, x="speed", y="clearance")
    assert (first.get_xlabel(), first.get_ylabel()) == ("speed [rpm]", "clearance [mm]")
    assert (first.get_xscale(), first.get_yscale()) == ("linear", "log")
    # both are shown in kN
    for axes, function, factor in ((first, force, 1e-3), (second, steep, 1e-3)):
        actual = cells(axes)
        assert len(actual) == 20
        for speed in SPEEDS:
            for clearance in CLEARANCES:
                value = actual[round(speed / RPM, 6), round(1e3 * clearance, 9)]
                assert value == pytest.approx(factor * function(speed, clearance), rel=1e-12)
    assert not isinstance(norm(first), LogNorm)
    assert isinstance(norm(second), LogNorm)
    titles = [axes.get_title("left") for axes in (first, second)]
    assert titles == ["force force [kN]", "force steep [kN]"]
    assert gallery.bars == ["", ""]
    assert gallery.smallest_text() >= 8.0


def test_logarithmic_colours_on_demand(sweep_of, draw):
    """The option decides about colours; values that are not positive are refused."""
    sweep = sweep_of(metrics={"force": force, "steep": steep})
    assert isinstance(norm(draw(maps, sweep, metrics="force", log=True)[0]), LogNorm)
    assert not isinstance(norm(draw(maps, sweep, metrics="steep", log=False)[0]), LogNorm)
    sweep.metrics["force"] -= sweep.metrics["force"].min()
    with pytest.raises(
        ValueError, match="log: force is not positive everywhere, its smallest value is 0 "
    ):
        draw(maps, sweep, metrics="force", log=True)
    with pytest.raises(ValueError, match="log must be"):
        draw(maps, sweep, log="never")


def test_failed_cells_are_hatched_and_missing_ones_blank(sweep_of, draw, gallery):
    """Only failed points have a hatch, and the title counts both kinds."""
    sweep = sweep_of()
    sweep.status[[0, 3]], sweep.status[7], sweep.status[[10, 11, 12]] = "failed", "lost", "missing"
    (axes,) = draw(maps, sweep)
    assert hatched(axes) == 3
    assert np.ma.count(mesh(axes).get_array()) == 20 - 6
    assert "3 of 20 points failed, 3 of 20 points not run yet" in gallery.text
    assert gallery.legend == ["failed"]


def test_cells_with_warnings(sweep_of, draw, gallery):
    """Marked where not all have them; the title has their number."""
    sweep = sweep_of()
    sweep.costs["warnings"][[2, 5]] = 1, 3
    assert hatched(draw(maps, sweep)[0]) == 2
    assert "2 of 20 points with warnings" in gallery.text
    sweep.costs["warnings"][:] = 1
    assert hatched(draw(maps, sweep)[0]) == 0


def test_warnings_of_a_point_are_named(tmp_path, gallery, draw):
    """The title has the begin of each warning of the point with most, where its run has a file."""
    scene = {"model": "dry", "contact": "kelvin_voigt(stiffness=1e6,damping=0)"}
    points = cl.grid(speed=[20.0, 30.0], clearance=[1e-4, 2e-4])
    swept = cl.sweep("slider_crank", points, tmp_path, turns=1, fixed=scene, workers=1)
    draw(maps, swept, metrics="joint_C_force*")
    assert "4 of 4 points with warnings" in gallery.text
    assert "joint C: kelvin_voigt: without damping" in " ".join(gallery.text.split())


def ratio(speed, clearance):
    """A film thickness ratio that is linear along both axes."""
    return 5.0 - speed / RPM / 100.0 - 1e3 * clearance


REGIMES = {"B": {"roughness": 2e-6, "dry": 0.4, "mixed": 1.0, "full": 3.0}}


@pytest.mark.parametrize(("metric", "size"), [("film_thickness_ratio_min", 1.0), ("gap_min", 2e-6)])
def test_regimes_have_borders(sweep_of, draw, gallery, metric, size):
    """Lines where the ratio, or the gap over the roughness, passes a threshold: rounding, for it is
    linear. None for other joints, for numbers outside of the map, and beside names.
    """
    names = [f"joint_{joint}_{metric}" for joint in "BC"]
    sweep = sweep_of(metrics={n: lambda **at: size * ratio(**at) for n in names})
    sweep.definition.regimes.update(REGIMES | {"C": {"full": 7.0}})
    ours, other = draw(maps, sweep, metrics=names, x="speed", y="clearance")
    lines = [c for c in ours.collections if isinstance(c, QuadContourSet)]
    assert [float(line.levels[0] / size) for line in lines] == pytest.approx([3.0, 1.0, 0.4])
    for line, threshold in zip(lines, (3.0, 1.0, 0.4), strict=True):
        corners = np.concatenate([path.vertices for path in line.get_paths()])
        assert len(corners) > 1
        at = ratio(speed=corners[:, 0] * RPM, clearance=1e-3 * corners[:, 1])
        assert_allclose(at, threshold, atol=1e-12)
    assert not any(isinstance(c, QuadContourSet) for c in other.collections)
    words = ["full film above ratio 3", "mixed at ratio 1", "dry below ratio 0.4"]
    assert gallery.legend == words
    sweep.status[:] = "failed"  # no value, and no warning of numpy
    assert not any(
        isinstance(c, QuadContourSet) for c in draw(maps, sweep, metrics=names)[0].collections
    )
    sweep = sweep_of(
        grid(joints=["B", "B,C"], speed=SPEEDS),
        {names[0]: lambda joints, speed: size * ratio(speed, 1e-3)},
    )
    sweep.definition.regimes.update(REGIMES)
    (axes,) = draw(maps, sweep)
    assert not any(isinstance(c, QuadContourSet) for c in axes.collections)


def test_no_period_and_no_value(sweep_of, draw, gallery):
    """Each has a hatch of its own, and each period one colour."""
    metrics = {
        "period": lambda speed, clearance: np.inf if clearance > 5e-4 else round(speed / SPEEDS[0])
    }
    metrics["impacts"] = lambda speed, clearance: np.nan if speed < 12.0 else speed
    reference = {"period": ("turns", "period"), "impacts": ("1", "impacts")}
    sweep = sweep_of(metrics=metrics, reference=reference)
    period, impacts = draw(maps, sweep, metrics=["period", "impacts"])
    assert isinstance(norm(period), BoundaryNorm)
    assert_allclose(norm(period).boundaries, [0.5, 1.5, 2.5, 3.5, 4.5])
    assert hatched(period) == 4  # the largest clearance
    assert hatched(impacts) == 5  # the slowest speed
    assert gallery.legend == [
        "not periodic within the run",
        "no value",
    ]
    sweep.metrics["period"][:] = np.inf
    assert hatched(draw(maps, sweep, metrics="period")[0]) == 20


def test_settling_is_told_from_no_period(sweep_of, draw, gallery):
    """Runs that have not settled have a hatch and a word of their own."""
    metrics = {"period": lambda speed, clearance: np.inf if clearance > 5e-4 else 1.0}
    metrics["settling_ratio"] = lambda speed, clearance: 0.1 if speed < 12.0 else 0.9
    sweep = sweep_of(metrics=metrics, reference={"period": ("turns", "period")})
    assert hatched(draw(maps, sweep, metrics="period")[0]) == 4
    legend = gallery.legend
    assert legend == ["not periodic within the run", "not settled within the run"]
    draw(curves, sweep, metrics="period", x="speed")
    assert "1 of 20 not settled within the run" in gallery.text


def test_names_and_a_third_parameter(sweep_of, draw, gallery):
    """Names have equal cells, and the panels of a metric one scale."""
    points = grid(joints=["B", "B,C", "B,C,E"], model=["dry", "lubricated"], speed=SPEEDS)
    sweep = sweep_of(
        points,
        {"force": lambda joints, model, speed: speed * len(joints) * (1.0 + (model == "dry"))},
    )
    dry, lubricated = draw(maps, sweep, x="speed", y="joints")
    assert [a.get_title() for a in (dry, lubricated)] == ["model dry", "model lubricated"]
    assert [t.get_text() for t in dry.get_yticklabels()] == ["B", "B,C", "B,C,E"]
    assert norm(dry) is norm(lubricated)
    ours, other = (mesh(a).get_array() for a in (dry, lubricated))
    assert_allclose(ours, 2.0 * other)
    assert_allclose(other, np.outer([1, 3, 5], SPEEDS))
    draw(maps, sweep)  # numbers along x, names beside
    assert gallery.panels[0].get_xlabel() == "speed [rpm]"


def test_a_parameter_is_held(sweep_of, draw, gallery):
    """A held parameter leaves one panel, and the title states it."""
    points = grid(model=["dry", "lubricated"], speed=SPEEDS, clearance=CLEARANCES)
    sweep = sweep_of(points, {"force": force}, fixed={"restitution": 0.9, "friction": "coulomb"})
    assert len(draw(maps, sweep, at={"model": "dry"})) == 1
    title = gallery.text
    assert "formula: restitution 0.9, friction coulomb, model dry, runs of 4 turns" in title
    draw(curves, sweep, at={"model": "dry", "clearance": 1.1e-3}, x="speed")
    (line,) = gallery.panels[0].lines
    assert_allclose(line.get_ydata(), 1e-3 * force(SPEEDS, 1e-3))
    assert "clearance 1 mm" in gallery.text


def test_lists_that_go_together(sweep_of, draw, gallery):
    """Parameters swept together are one axis, named after the first."""
    points = zipped(speed=SPEEDS, clearance=CLEARANCES[:4], viscosity=[0.01, 0.01, 0.02, 0.02])
    sweep = sweep_of(points * grid(restitution=[0.3, 0.6, 0.9]), {"force": force})
    assert draw(maps, sweep)[0].get_xlabel() == "speed [rpm]"
    assert draw(maps, sweep, x="restitution", y="clearance")[0].get_ylabel() == "clearance [mm]"
    draw(curves, sweep, x="restitution")
    names = gallery.legend
    assert names[0] == "speed 100 rpm, clearance 0.05 mm, viscosity 10 mPa s"
    with pytest.raises(
        ValueError, match="x and y must vary apart from each other, got speed and clearance"
    ):
        draw(maps, sweep, x="speed", y="clearance")
    with pytest.raises(ValueError, match="'viscosity' has the same value at several places"):
        draw(maps, sweep, x="viscosity")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"metrics": "force_max"}, "no metric 'force_max' in .*; it has force"),
        ({"metrics": []}, r"metrics:  are 0, a page has room for 1 to 12"),
        (
            {"x": "colour"},
            "'colour' is no parameter that varies in .*; what varies: speed, clearance",
        ),
        ({"x": "speed", "y": "speed"}, "x and y must vary apart"),
        ({"at": {"colour": 1}}, "colour is not swept here; swept are speed, clearance"),
        (
            {"at": {"speed": 10.0}},
            "a map needs two parameters that vary, here varies clearance: ask for curves",
        ),
    ],
)
def test_bad_maps(sweep_of, draw, options, message):
    """A map that cannot be is refused with the names that are there."""
    sweep = sweep_of()
    with pytest.raises(ValueError, match=message):
        draw(maps, sweep, **options)


MANY = np.linspace(0.1, 0.9, 8)


@pytest.mark.parametrize(
    ("more", "kind", "options", "message"),
    [
        (
            {"restitution": MANY},
            maps,
            {"metrics": "m0"},
            "restitution: 8 different points, a page has room for 6 panels: hold some",
        ),
        (
            {"restitution": MANY},
            maps,
            {"metrics": "m*"},
            r"metrics: m\* are 13, a page has room for 1 to 12",
        ),
        (
            {"restitution": MANY, "viscosity": [0.1, 0.2]},
            maps,
            {},
            "left are restitution, viscosity: hold some of them",
        ),
        (
            {"restitution": MANY, "viscosity": [0.1, 0.2]},
            curves,
            {},
            "clearance, restitution, viscosity: 80 different points, a page has room for 50 curves",
        ),
        (
            {"model": ["dry"]},
            curves,
            {"at": {"model": "wet"}},
            "model='wet' was not swept; there are dry",
        ),
    ],
)
def test_more_than_a_page_holds(sweep_of, draw, more, kind, options, message):
    """Too many panels, metrics or curves are refused, and a value that is not there."""
    points = grid(speed=SPEEDS, clearance=CLEARANCES, **more)
    with pytest.raises(ValueError, match=message):
        draw(kind, sweep_of(points, {f"m{i}": force for i in range(13)}), **options)


def test_telling_metrics(sweep_of):
    """Forces of joints with clearance come first; names and patterns choose others."""
    names = [
        "slider_acceleration_min",
        "slider_acceleration_max",
        "drive_crank_torque_rms",
        "joint_A_force_max",
        "joint_B_force_max",
        "joint_B_gap_min",
        "joint_B_film_thickness_ratio_min",
        "joint_B_contact_fraction",
        "joint_B_impacts_per_turn",
        "dissipated_per_turn",
        "period",
    ]
    sweep = sweep_of(grid(speed=SPEEDS), {n: lambda speed: speed for n in names})
    assert chosen_metrics(sweep, None) == [
        "slider_acceleration_max",
        "drive_crank_torque_rms",
        "joint_B_force_max",
        "joint_B_film_thickness_ratio_min",
        "joint_B_contact_fraction",
        "joint_B_impacts_per_turn",
    ]
    sweep.metrics["joint_B_contact_fraction"][:] = np.nan
    assert "dissipated_per_turn" in chosen_metrics(sweep, None)
    assert chosen_metrics(sweep, ["joint_*_force_max", "joint_B_*_max"]) == [
        "joint_A_force_max",
        "joint_B_force_max",
    ]
    sweep.status[:] = "failed"
    with pytest.raises(ValueError, match="no metric to draw: 0 points are done"):
        chosen_metrics(sweep, None)


# --- curves and samples
def test_a_curve(sweep_of, draw, gallery):
    """Points in order, a gap and a cross where one failed."""
    sweep = sweep_of(grid(clearance=CLEARANCES), {"force": lambda clearance: 2e6 * clearance})
    sweep.status[2] = "failed"
    (axes,) = draw(curves, sweep)
    line, crosses = axes.lines
    assert_allclose(line.get_xdata(), 1e3 * CLEARANCES)
    expected = 2e6 * CLEARANCES
    expected[2] = np.nan
    assert_allclose(line.get_ydata(), expected)
    assert_allclose(crosses.get_xdata(), 1e3 * CLEARANCES[2])
    assert axes.get_xscale() == "log"
    assert "crosses: 1 of 5 points failed" in gallery.text
    assert gallery.smallest_text() >= 8.0


def test_curves_of_a_second_parameter(sweep_of, draw, gallery):
    """A line for each value; a colour bar where there are many."""
    sweep = sweep_of(metrics={"force": force, "steep": steep})
    first, second = draw(curves, sweep, x="clearance")
    for speed, line in zip(SPEEDS, second.lines, strict=True):
        assert_allclose(line.get_ydata(), 1e-3 * steep(speed, CLEARANCES))
    assert (first.get_yscale(), second.get_yscale()) == ("linear", "log")
    names = gallery.legend
    assert names == [f"speed {n} rpm" for n in (100, 200, 300, 400)]
    many = sweep_of(grid(speed=np.linspace(10.0, 60.0, 12), clearance=CLEARANCES), {"force": force})
    draw(curves, many, x="clearance")  # a bar distinguishes so many
    assert gallery.bars == ["speed [rpm]"]
    assert not gallery.last.legends
    assert len({line.get_color() for line in map(_hashable, gallery.panels[0].lines)}) == 12


def _hashable(line):
    line.set_color(tuple(line.get_color()))
    return line


def test_curves_over_names_are_not_joined(sweep_of, draw):
    """Names stand at even places without a line between them."""
    sweep = sweep_of(grid(joints=["B", "B,C", "B,C,E"]), {"force": lambda joints: len(joints)})
    (axes,) = draw(curves, sweep)
    assert axes.lines[0].get_linestyle() == "None"
    assert [t.get_text() for t in axes.get_xticklabels()] == ["B", "B,C", "B,C,E"]


def test_curves_without_a_value_say_so(sweep_of, draw, gallery):
    """The panel states why it is empty, over the axis of the points."""
    sweep = sweep_of(
        grid(speed=SPEEDS), {"period": lambda speed: np.inf}, {"period": ("turns", "period")}
    )
    draw(curves, sweep, metrics="period")
    assert {"4 of 4 not periodic within the run", "no value"} <= set(gallery.texts())
    assert_allclose(gallery.panels[0].get_xlim(), (100.0, 400.0))


def test_samples_without_a_value_say_so(sweep_of, draw, gallery):
    """Crosses for failed samples, a sentence for values that are none."""
    reference = {"period": ("turns", "period"), "force": ("N", "force")}
    metrics = {"period": lambda speed: np.inf, "force": lambda speed: speed}
    sweep = sweep_of(sampled(10, speed=(10.0, 60.0)), metrics, reference)
    sweep.status[:3] = "failed"
    force_, period = draw(curves, sweep, metrics=["force", "period"])
    assert {"7 of 10 not periodic within the run", "no value"} <= set(gallery.texts())
    assert len(period.lines[1].get_xdata()) == 3
    assert np.isfinite(force_.lines[0].get_ydata()).sum() == 7


def test_telling_metrics_of_the_points_that_are_left(sweep_of, draw, gallery):
    """A metric without a value at the held points has no panel."""
    metrics = {
        "slider_acceleration_max": lambda model, speed, clearance: speed,
        "joint_C_contact_fraction": lambda model, speed, clearance: (
            clearance if model == "dry" else np.nan
        ),
    }
    sweep = sweep_of(grid(model=["dry", "lubricated"], speed=SPEEDS, clearance=CLEARANCES), metrics)
    for model, count in (("dry", 2), ("lubricated", 1)):
        draw(maps, sweep, at={"model": model})
        assert len(gallery.panels) == count


def test_samples(sweep_of, draw, gallery):
    """A panel for each metric and parameter, points where they were drawn."""
    points = sampled(25, speed=(10.0, 60.0), clearance=(1e-5, 5e-4, "log"), model=["dry", "mixed"])
    sweep = sweep_of(points, {"force": force, "steep": steep})
    draw(curves, sweep)
    grid_ = np.array(gallery.panels).reshape(2, 3)
    x, y = grid_[1, 1].lines[0].get_data()
    assert_allclose(x, 1e3 * sweep.columns["clearance"])
    assert_allclose(y, 1e-3 * sweep.metrics["steep"])
    assert [a.get_xscale() for a in grid_[-1]] == ["linear", "log", "linear"]
    assert [a.get_xlabel() for a in grid_[-1]] == ["speed [rpm]", "clearance [mm]", "model"]
    assert grid_[1, 1].get_yscale() == "log"
    (axes,) = draw(curves, sweep, x="speed", at={"model": "dry"}, metrics="force")
    assert len(axes.lines[0].get_xdata()) == (sweep.columns["model"] == "dry").sum()
    with pytest.raises(ValueError, match="were drawn, not spread on a grid: ask for curves"):
        draw(maps, sweep)
    with pytest.raises(ValueError, match="speed was drawn, no two points share a value of it"):
        draw(curves, sweep, at={"speed": 10.0})


# --- bifurcation diagrams
@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Dry slider-cranks of five turns."""
    points = cl.grid(speed=RPM * np.array([1000.0, 1500.0, 2500.0]), clearance=[5e-4, 1e-3])
    options = {"turns": 5.0, "samples_per_turn": 40, "rtol": 1e-5, "fixed": {"model": "dry"}}
    channels, folder = ["bodies/slider", "joints/C/ecc*"], tmp_path_factory.mktemp("sweep") / "runs"
    return cl.sweep("slider_crank", points, folder, channels=channels, workers=1, **options)


def test_bifurcation_of_a_sweep(swept, tmp_path, gallery):
    """Each run's passages after half of its turns, at its speed."""
    bifurcation_of(swept, tmp_path / "b.png", at={"clearance": 1e-3})
    velocity, journal = gallery.last.axes
    x, y = velocity.lines[0].get_data()
    assert_allclose(np.unique(x), [1000.0, 1500.0, 2500.0])
    for rpm in (1000.0, 1500.0, 2500.0):
        with swept.run(speed=RPM * rpm, clearance=1e-3) as run:
            expected = section(run, ["slider.vx", "C.epsilon_x"], settle=2.0)
        assert len(expected) == 4
        assert_allclose(y[np.isclose(x, rpm)], expected[:, 0])
        assert_allclose(journal.lines[0].get_ydata()[np.isclose(x, rpm)], expected[:, 1])
    title = gallery.text
    assert "crank angle 0°, 2 turns dropped, 4 passages after, values at samples" in title
    assert "clearance 1 mm" in title
    assert journal.get_xlabel() == "speed [rpm]"


def test_runs_that_are_missing_are_crosses(swept, tmp_path, gallery):
    """A run without a file is a cross, and the title counts it."""
    gone = swept.select(speed=RPM * 1500.0, clearance=1e-3)[0]
    stored = swept.path(gone).read_bytes()
    swept.path(gone).unlink()
    try:
        options = {"at": {"clearance": 1e-3}, "channels": "slider.vx", "settle": 1.0, "angle": 1.0}
        bifurcation_of(swept, tmp_path / "b.png", **options)
    finally:
        swept.path(gone).write_bytes(stored)
    (axes,) = gallery.last.axes
    assert_allclose(axes.lines[1].get_xdata(), [1500.0])
    title = gallery.text
    assert "crosses: of 3 runs 1 without a file" in title
    assert "1 turn dropped, 4 passages" in title


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "besides speed, clearance varies: hold it"),
        ({"parameter": "colour"}, "'colour' is no parameter that varies"),
        (
            {"at": {"clearance": 1e-3}, "settle": 9.0},
            "settle: no run of .* has a passage after 9 turns",
        ),
        ({"at": {"clearance": 1e-3}, "channels": "B.force"}, "no channel 'B.force'"),
    ],
)
def test_bad_bifurcations(swept, tmp_path, options, message):
    """Parameters and channels that are not there are refused."""
    with pytest.raises(ValueError, match=message):
        bifurcation_of(swept, tmp_path / "b.png", **options)


def test_a_bifurcation_diagram_needs_run_files(sweep_of, tmp_path):
    """A sweep of summaries alone is refused."""
    sweep = sweep_of(grid(speed=SPEEDS), {"m": lambda speed: speed})
    with pytest.raises(ValueError, match="keeps no run files"):
        bifurcation_of(sweep, tmp_path / "b.png")


def test_colours_read_in_grey():
    """Lightness rises along the colour map: no two values look alike when printed without
    colour.
    """
    from matplotlib import colormaps

    red, green, blue = colormaps[figures.COLOURS](np.linspace(0.0, 1.0, 64))[:, :3].T
    assert (np.diff(0.2126 * red + 0.7152 * green + 0.0722 * blue) > 0.0).all()


def test_values_that_crowd_stand_at_equal_distances(sweep_of, draw):
    """Rows of 10 and 11 in 1000 would be a hundredth of the map; of an even grid all are alike and
    keep their scale.
    """
    crowded = [-20.0, 10.0, 11.0, 500.0, 1000.0]
    numbers = {"m": lambda speed, restitution: restitution}
    sweep = sweep_of(grid(speed=SPEEDS, restitution=crowded), numbers)
    (axes,) = draw(maps, sweep, y="restitution")
    assert_allclose(axes.get_yticks(), np.arange(5.0))
    assert [t.get_text() for t in axes.get_yticklabels()] == ["-20", "10", "11", "500", "1000"]
    even = np.linspace(-50.0, 50.0, 60)
    sweep = sweep_of(grid(speed=SPEEDS, restitution=even), numbers)
    assert draw(maps, sweep, y="restitution")[0].get_ylim()[0] < -50.0


def test_means_of_turn_peaks_come_first(sweep_of):
    """Of dry sweeps there is nothing else; forces are those of the joints with clearance."""
    names = [
        "slider_acceleration_peak_mean",
        "slider_acceleration_peak_mean_half_width",
        "drive_crank_torque_rms",
        "joint_A_force_peak_mean",
        "joint_C_force_peak_mean",
        "joint_C_penetration_peak_mean",
        "joint_C_force_max",
    ]
    sweep = sweep_of(grid(speed=SPEEDS), {n: lambda speed: speed for n in names})
    assert chosen_metrics(sweep, None)[:3] == [
        "slider_acceleration_peak_mean",
        "drive_crank_torque_rms",
        "joint_C_force_peak_mean",
    ]


def test_curves_have_bars_of_intervals(sweep_of, draw, monkeypatch):
    """In the units of the metric: 2000 +- 100 N is 2 +- 0.1 kN."""
    seen = []
    bars = "matplotlib.axes.Axes.errorbar"
    monkeypatch.setattr(bars, lambda self, x, y, half, **style: seen.append((y, half)))
    values = {"force_peak_mean": 2e4, "force_peak_mean_half_width": 1e3}
    metrics = {n: lambda speed, v=v: v for n, v in values.items()}
    sweep = sweep_of(grid(speed=SPEEDS), metrics)
    draw(curves, sweep, metrics=["force_peak_mean"])
    ((y, half),) = seen
    np.testing.assert_allclose(half / y, 0.05)


def test_errors_of_metrics(sweep_of, draw, gallery):
    """Cells whose stated error exceeds a twentieth of the colours are hatched, curves have bars."""
    errors = {
        "force": force,
        "force_error": lambda speed, clearance: 0.2 * force(speed, clearance) * (speed > 30.0),
    }
    sweep = sweep_of(metrics=errors)
    draw(maps, sweep, metrics="force*")
    axes = gallery.figures[-1].axes[0]
    assert hatched(axes) == (SPEEDS > 30.0).sum() * len(CLEARANCES)
    draw(curves, sweep, x="speed", at={"clearance": CLEARANCES[0]})
    assert len(gallery.figures[-1].axes[0].collections) == 1  # the bars
    assert chosen_metrics(sweep, None) == ["force"]
    assert chosen_metrics(sweep, "*_error") == ["force_error"]
