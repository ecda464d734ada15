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
from matplotlib.patches import PathPatch
from numpy.testing import assert_allclose

import clearance as cl
from clearance.sweeping import definition as definitions
from clearance.sweeping.index import Sweep
from clearance.sweeping.points import grid, sampled, zipped
from tests.postprocess.records import Gallery

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


@pytest.fixture
def gallery(monkeypatch):
    return Gallery(monkeypatch)


@pytest.fixture
def made(tmp_path):
    """A sweep over points, its metrics given as functions of a point, in SI."""

    def make(points, metrics, reference=None, fixed=None):
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


def force(speed, clearance, **_):
    return speed * 1e3 + clearance * 1e6


def steep(speed, clearance, **_):
    return speed**2 / clearance


def cells(axes) -> dict[tuple[float, float], float]:
    """Value of each coloured cell by the middle of its edges along x and the geometric middle along
    y.
    """
    (mesh,) = (c for c in axes.collections if isinstance(c, QuadMesh))
    corners, values = mesh.get_coordinates(), mesh.get_array()
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


def panels(figure) -> list:
    """Axes that are no colour bars."""
    return [a for a in figure.axes if a.get_label() != "<colorbar>"]


def norm(axes):
    return next(c for c in axes.collections if isinstance(c, QuadMesh)).norm


# --- scales
def test_edges():
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
    assert shown_in(units, values) == (unit, factor)


def test_titles_of_lives(made):
    """They name the turns of the lives, not those of the runs in them."""
    sweep = made(grid(speed=SPEEDS), {"depth": lambda speed: speed})
    sweep.definition.options["life"] = {"turns": 3000.0}
    title = Choice.of(sweep, None).title(width=7.0)
    assert title.replace("\u00a0", " ") == "formula: lives of 3000 turns"


# --- maps
def test_cells_stand_where_the_points_are(made, tmp_path, gallery):
    """Values swept in any order; a logarithmic axis has its points in the geometric middle of their
    cells.
    """
    sweep = made(
        grid(clearance=CLEARANCES[::-1], speed=SPEEDS[[2, 0, 3, 1]]),
        {"force": force, "steep": steep},
    )
    path = maps(sweep, tmp_path / "m.png", x="speed", y="clearance")
    assert path.read_bytes().startswith(b"\x89PNG")
    first, second = panels(gallery.last)
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
    bars = [a for a in gallery.last.axes if a.get_label() == "<colorbar>"]
    assert [b.get_ylabel() for b in bars] == ["force force [kN]", "force steep [kN]"]
    assert gallery.smallest_text() >= 8.0


def test_logarithmic_colours_on_demand(made, tmp_path, gallery):
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), {"force": force, "steep": steep})
    maps(sweep, tmp_path / "m.png", metrics="force", log=True)
    assert isinstance(norm(panels(gallery.last)[0]), LogNorm)
    maps(sweep, tmp_path / "m.png", metrics="steep", log=False)
    assert not isinstance(norm(panels(gallery.last)[0]), LogNorm)
    sweep.metrics["force"] -= sweep.metrics["force"].min()
    with pytest.raises(
        ValueError, match="log: force is not positive everywhere, its smallest value is 0 "
    ):
        maps(sweep, tmp_path / "m.png", metrics="force", log=True)
    with pytest.raises(ValueError, match="log must be"):
        maps(sweep, tmp_path / "m.png", log="never")


def test_failed_cells_are_hatched_and_missing_ones_blank(made, tmp_path, gallery):
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), {"force": force})
    sweep.status[[0, 3]], sweep.status[7], sweep.status[[10, 11, 12]] = "failed", "lost", "missing"
    maps(sweep, tmp_path / "m.png")
    (axes,) = panels(gallery.last)
    assert hatched(axes) == 3
    assert (
        np.ma.count(next(c for c in axes.collections if isinstance(c, QuadMesh)).get_array())
        == 20 - 6
    )
    assert "3 of 20 points failed, 3 of 20 points not run yet" in " ".join(gallery.texts()).replace(
        "\u00a0", " "
    )
    assert [t.get_text() for t in gallery.last.legends[0].get_texts()] == ["failed"]


def test_cells_with_warnings(made, tmp_path, gallery):
    """Marked where not all have them; the title has their number."""
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), {"force": force})
    sweep.costs["warnings"][[2, 5]] = 1, 3
    maps(sweep, tmp_path / "m.png")
    assert hatched(panels(gallery.last)[0]) == 2
    assert "2 of 20 points with warnings" in " ".join(gallery.texts()).replace("\u00a0", " ")
    sweep.costs["warnings"][:] = 1
    maps(sweep, tmp_path / "m.png")
    assert hatched(panels(gallery.last)[0]) == 0


def test_no_period_and_no_value(made, tmp_path, gallery):
    metrics = {
        "period": lambda speed, clearance: np.inf if clearance > 5e-4 else round(speed / SPEEDS[0])
    }
    metrics["impacts"] = lambda speed, clearance: np.nan if speed < 12.0 else speed
    reference = {"period": ("turns", "period"), "impacts": ("1", "impacts")}
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), metrics, reference)
    maps(sweep, tmp_path / "m.png", metrics=["period", "impacts"])
    period, impacts = panels(gallery.last)
    assert isinstance(norm(period), BoundaryNorm)
    assert_allclose(norm(period).boundaries, [0.5, 1.5, 2.5, 3.5, 4.5])
    assert hatched(period) == 4  # the largest clearance
    assert hatched(impacts) == 5  # the slowest speed
    assert [t.get_text() for t in gallery.last.legends[0].get_texts()] == [
        "not periodic within the run",
        "no value",
    ]
    sweep.metrics["period"][:] = np.inf
    maps(sweep, tmp_path / "m.png", metrics="period")
    assert hatched(panels(gallery.last)[0]) == 20


def test_settling_is_told_from_no_period(made, tmp_path, gallery):
    metrics = {"period": lambda speed, clearance: np.inf if clearance > 5e-4 else 1.0}
    metrics["settling_ratio"] = lambda speed, clearance: 0.1 if speed < 12.0 else 0.9
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), metrics, {"period": ("turns", "period")})
    maps(sweep, tmp_path / "m.png", metrics="period")
    assert hatched(panels(gallery.last)[0]) == 4
    legend = [t.get_text() for t in gallery.last.legends[0].get_texts()]
    assert legend == ["not periodic within the run", "not settled within the run"]
    curves(sweep, tmp_path / "c.png", metrics="period", x="speed")
    assert "1 of 20 not settled within the run" in " ".join(gallery.texts()).replace("\u00a0", " ")


def test_names_and_a_third_parameter(made, tmp_path, gallery):
    """Names have equal cells, and the panels of a metric one scale."""
    points = grid(joints=["B", "B,C", "B,C,E"], model=["dry", "lubricated"], speed=SPEEDS)
    sweep = made(
        points,
        {"force": lambda joints, model, speed: speed * len(joints) * (1.0 + (model == "dry"))},
    )
    maps(sweep, tmp_path / "m.png", x="speed", y="joints")
    dry, lubricated = panels(gallery.last)
    assert [a.get_title() for a in (dry, lubricated)] == ["model dry", "model lubricated"]
    assert [t.get_text() for t in dry.get_yticklabels()] == ["B", "B,C", "B,C,E"]
    assert norm(dry) is norm(lubricated)
    ours, other = (
        next(c for c in a.collections if isinstance(c, QuadMesh)).get_array()
        for a in (dry, lubricated)
    )
    assert_allclose(ours, 2.0 * other)
    assert_allclose(other, np.outer([1, 3, 5], SPEEDS))
    maps(sweep, tmp_path / "m.png")  # numbers along x, names beside
    assert panels(gallery.last)[0].get_xlabel() == "speed [rpm]"


def test_a_parameter_is_held(made, tmp_path, gallery):
    points = grid(model=["dry", "lubricated"], speed=SPEEDS, clearance=CLEARANCES)
    sweep = made(points, {"force": force}, fixed={"restitution": 0.9, "friction": "coulomb"})
    maps(sweep, tmp_path / "m.png", at={"model": "dry"})
    assert len(panels(gallery.last)) == 1
    title = " ".join(gallery.texts()).replace("\u00a0", " ")
    assert "formula: restitution 0.9, friction coulomb, model dry, runs of 4 turns" in title
    curves(sweep, tmp_path / "m.png", at={"model": "dry", "clearance": 1.1e-3}, x="speed")
    (line,) = panels(gallery.last)[0].lines
    assert_allclose(line.get_ydata(), 1e-3 * force(SPEEDS, 1e-3))
    assert "clearance 1 mm" in " ".join(gallery.texts()).replace("\u00a0", " ")


def test_lists_that_go_together(made, tmp_path, gallery):
    points = zipped(speed=SPEEDS, clearance=CLEARANCES[:4], viscosity=[0.01, 0.01, 0.02, 0.02])
    sweep = made(points * grid(restitution=[0.3, 0.6, 0.9]), {"force": force})
    maps(sweep, tmp_path / "m.png")
    assert panels(gallery.last)[0].get_xlabel() == "speed [rpm]"
    maps(sweep, tmp_path / "m.png", x="restitution", y="clearance")
    assert panels(gallery.last)[0].get_ylabel() == "clearance [mm]"
    curves(sweep, tmp_path / "m.png", x="restitution")
    names = [t.get_text() for t in gallery.last.legends[0].get_texts()]
    assert names[0] == "speed 100 rpm, clearance 0.05 mm, viscosity 10 mPa s"
    with pytest.raises(
        ValueError, match="x and y must vary apart from each other, got speed and clearance"
    ):
        maps(sweep, tmp_path / "m.png", x="speed", y="clearance")
    with pytest.raises(ValueError, match="'viscosity' has the same value at several places"):
        maps(sweep, tmp_path / "m.png", x="viscosity")


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
def test_bad_maps(made, tmp_path, options, message):
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), {"force": force})
    with pytest.raises(ValueError, match=message):
        maps(sweep, tmp_path / "m.png", **options)


def test_more_than_a_page_holds(made, tmp_path):
    many = np.linspace(0.1, 0.9, 8)
    sweep = made(
        grid(speed=SPEEDS, clearance=CLEARANCES, restitution=many),
        {f"m{i}": force for i in range(13)},
    )
    with pytest.raises(
        ValueError, match="restitution: 8 different points, a page has room for 6 panels: hold some"
    ):
        maps(sweep, tmp_path / "m.png", metrics="m0")
    with pytest.raises(ValueError, match=r"metrics: m\* are 13, a page has room for 1 to 12"):
        maps(sweep, tmp_path / "m.png", metrics="m*")
    sweep = made(
        grid(speed=SPEEDS, clearance=CLEARANCES, restitution=many, viscosity=[0.1, 0.2]),
        {"m": force},
    )
    with pytest.raises(ValueError, match="left are restitution, viscosity: hold some of them"):
        maps(sweep, tmp_path / "m.png")
    with pytest.raises(
        ValueError,
        match="clearance, restitution, viscosity: 80 different points, a page has room "
        "for 50 curves",
    ):
        curves(sweep, tmp_path / "m.png")
    with pytest.raises(ValueError, match="model='wet' was not swept; there are dry"):
        curves(
            made(grid(model=["dry"], speed=SPEEDS), {"m": lambda **_: 1.0}),
            tmp_path / "m.png",
            at={"model": "wet"},
        )


def test_telling_metrics(made):
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
    sweep = made(grid(speed=SPEEDS), {n: lambda speed: speed for n in names})
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
def test_a_curve(made, tmp_path, gallery):
    sweep = made(grid(clearance=CLEARANCES), {"force": lambda clearance: 2e6 * clearance})
    sweep.status[2] = "failed"
    curves(sweep, tmp_path / "c.png")
    (axes,) = panels(gallery.last)
    line, crosses = axes.lines
    assert_allclose(line.get_xdata(), 1e3 * CLEARANCES)
    expected = 2e6 * CLEARANCES
    expected[2] = np.nan
    assert_allclose(line.get_ydata(), expected)
    assert_allclose(crosses.get_xdata(), 1e3 * CLEARANCES[2])
    assert axes.get_xscale() == "log"
    assert "crosses: 1 of 5 points failed" in " ".join(gallery.texts()).replace("\u00a0", " ")
    assert gallery.smallest_text() >= 8.0


def test_curves_of_a_second_parameter(made, tmp_path, gallery):
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), {"force": force, "steep": steep})
    curves(sweep, tmp_path / "c.png", x="clearance")
    first, second = panels(gallery.last)
    for speed, line in zip(SPEEDS, second.lines, strict=True):
        assert_allclose(line.get_ydata(), 1e-3 * steep(speed, CLEARANCES))
    assert (first.get_yscale(), second.get_yscale()) == ("linear", "log")
    names = [t.get_text() for t in gallery.last.legends[0].get_texts()]
    assert names == [f"speed {n} rpm" for n in (100, 200, 300, 400)]
    many = made(grid(speed=np.linspace(10.0, 60.0, 12), clearance=CLEARANCES), {"force": force})
    curves(many, tmp_path / "c.png", x="clearance")  # a bar distinguishes so many
    assert [a.get_ylabel() for a in gallery.last.axes if a.get_label() == "<colorbar>"] == [
        "speed [rpm]"
    ]
    assert not gallery.last.legends
    assert len({line.get_color() for line in map(_hashable, panels(gallery.last)[0].lines)}) == 12


def _hashable(line):
    line.set_color(tuple(line.get_color()))
    return line


def test_curves_over_names_are_not_joined(made, tmp_path, gallery):
    sweep = made(grid(joints=["B", "B,C", "B,C,E"]), {"force": lambda joints: len(joints)})
    curves(sweep, tmp_path / "c.png")
    (axes,) = panels(gallery.last)
    assert axes.lines[0].get_linestyle() == "None"
    assert [t.get_text() for t in axes.get_xticklabels()] == ["B", "B,C", "B,C,E"]


def test_curves_without_a_value_say_so(made, tmp_path, gallery):
    sweep = made(
        grid(speed=SPEEDS), {"period": lambda speed: np.inf}, {"period": ("turns", "period")}
    )
    curves(sweep, tmp_path / "c.png", metrics="period")
    assert {"4 of 4 not periodic within the run", "no value"} <= set(gallery.texts())
    assert_allclose(panels(gallery.last)[0].get_xlim(), (100.0, 400.0))


def test_samples_without_a_value_say_so(made, tmp_path, gallery):
    reference = {"period": ("turns", "period"), "force": ("N", "force")}
    metrics = {"period": lambda speed: np.inf, "force": lambda speed: speed}
    sweep = made(sampled(10, speed=(10.0, 60.0)), metrics, reference)
    sweep.status[:3] = "failed"
    curves(sweep, tmp_path / "s.png", metrics=["force", "period"])
    force_, period = panels(gallery.last)
    assert {"7 of 10 not periodic within the run", "no value"} <= set(gallery.texts())
    assert len(period.lines[1].get_xdata()) == 3
    assert np.isfinite(force_.lines[0].get_ydata()).sum() == 7


def test_telling_metrics_of_the_points_that_are_left(made, tmp_path, gallery):
    metrics = {
        "slider_acceleration_max": lambda model, speed, clearance: speed,
        "joint_C_contact_fraction": lambda model, speed, clearance: (
            clearance if model == "dry" else np.nan
        ),
    }
    sweep = made(grid(model=["dry", "lubricated"], speed=SPEEDS, clearance=CLEARANCES), metrics)
    for model, count in (("dry", 2), ("lubricated", 1)):
        maps(sweep, tmp_path / "m.png", at={"model": model})
        assert len(panels(gallery.last)) == count


def test_samples(made, tmp_path, gallery):
    points = sampled(25, speed=(10.0, 60.0), clearance=(1e-5, 5e-4, "log"), model=["dry", "mixed"])
    sweep = made(points, {"force": force, "steep": steep})
    curves(sweep, tmp_path / "s.png")
    grid_ = np.array(panels(gallery.last)).reshape(2, 3)
    x, y = grid_[1, 1].lines[0].get_data()
    assert_allclose(x, 1e3 * sweep.columns["clearance"])
    assert_allclose(y, 1e-3 * sweep.metrics["steep"])
    assert [a.get_xscale() for a in grid_[-1]] == ["linear", "log", "linear"]
    assert [a.get_xlabel() for a in grid_[-1]] == ["speed [rpm]", "clearance [mm]", "model"]
    assert grid_[1, 1].get_yscale() == "log"
    curves(sweep, tmp_path / "s.png", x="speed", at={"model": "dry"}, metrics="force")
    (axes,) = panels(gallery.last)
    assert len(axes.lines[0].get_xdata()) == (sweep.columns["model"] == "dry").sum()
    with pytest.raises(ValueError, match="were drawn, not spread on a grid: ask for curves"):
        maps(sweep, tmp_path / "s.png")
    with pytest.raises(ValueError, match="speed was drawn, no two points share a value of it"):
        curves(sweep, tmp_path / "s.png", at={"speed": 10.0})


# --- bifurcation diagrams
@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Dry slider-cranks of five turns."""
    points = cl.grid(speed=RPM * np.array([1000.0, 1500.0, 2500.0]), clearance=[5e-4, 1e-3])
    options = {"turns": 5.0, "samples_per_turn": 40, "rtol": 1e-5}
    channels = ["bodies/slider", "joints/C/ecc*"]
    folder = tmp_path_factory.mktemp("sweep") / "runs"
    return cl.sweep(
        "slider_crank",
        points,
        folder,
        fixed={"model": "dry"},
        channels=channels,
        workers=1,
        **options,
    )


def test_bifurcation_of_a_sweep(swept, tmp_path, gallery):
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
    title = " ".join(gallery.texts()).replace("\u00a0", " ")
    assert "crank angle 0°, 2 turns dropped, 4 passages after, values at samples" in title
    assert "clearance 1 mm" in title
    assert journal.get_xlabel() == "speed [rpm]"


def test_runs_that_are_missing_are_crosses(swept, tmp_path, gallery):
    gone = swept.select(speed=RPM * 1500.0, clearance=1e-3)[0]
    stored = swept.path(gone).read_bytes()
    swept.path(gone).unlink()
    try:
        bifurcation_of(
            swept,
            tmp_path / "b.png",
            at={"clearance": 1e-3},
            channels="slider.vx",
            settle=1.0,
            angle=1.0,
        )
    finally:
        swept.path(gone).write_bytes(stored)
    (axes,) = gallery.last.axes
    assert_allclose(axes.lines[1].get_xdata(), [1500.0])
    title = " ".join(gallery.texts()).replace("\u00a0", " ")
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
    with pytest.raises(ValueError, match=message):
        bifurcation_of(swept, tmp_path / "b.png", **options)


def test_a_bifurcation_diagram_needs_run_files(made, tmp_path):
    sweep = made(grid(speed=SPEEDS), {"m": lambda speed: speed})
    with pytest.raises(ValueError, match="keeps no run files"):
        bifurcation_of(sweep, tmp_path / "b.png")


def test_colours_read_in_grey():
    """Lightness rises along the colour map: no two values look alike when printed without
    colour.
    """
    from matplotlib import colormaps

    red, green, blue = colormaps[figures.COLOURS](np.linspace(0.0, 1.0, 64))[:, :3].T
    assert (np.diff(0.2126 * red + 0.7152 * green + 0.0722 * blue) > 0.0).all()


def test_values_that_crowd_stand_at_equal_distances(made, tmp_path, gallery):
    """Rows of 10 and 11 in 1000 would be a hundredth of the map; of an even grid all are alike and
    keep their scale.
    """
    crowded = [-20.0, 10.0, 11.0, 500.0, 1000.0]
    numbers = {"m": lambda speed, restitution: restitution}
    maps(
        made(grid(speed=SPEEDS, restitution=crowded), numbers), tmp_path / "m.png", y="restitution"
    )
    (axes,) = panels(gallery.last)
    assert_allclose(axes.get_yticks(), np.arange(5.0))
    assert [t.get_text() for t in axes.get_yticklabels()] == ["-20", "10", "11", "500", "1000"]
    even = np.linspace(-50.0, 50.0, 60)
    maps(made(grid(speed=SPEEDS, restitution=even), numbers), tmp_path / "m.png", y="restitution")
    assert panels(gallery.last)[0].get_ylim()[0] < -50.0


def test_means_of_turn_peaks_come_first(made):
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
    sweep = made(grid(speed=SPEEDS), {n: lambda speed: speed for n in names})
    assert chosen_metrics(sweep, None)[:3] == [
        "slider_acceleration_peak_mean",
        "drive_crank_torque_rms",
        "joint_C_force_peak_mean",
    ]


def test_curves_have_bars_of_intervals(made, tmp_path, monkeypatch):
    """In the units of the metric: 2000 +- 100 N is 2 +- 0.1 kN."""
    seen = []
    monkeypatch.setattr(
        "matplotlib.axes.Axes.errorbar", lambda self, x, y, half, **style: seen.append((y, half))
    )
    metrics = {
        "force_peak_mean": lambda speed: 2e4,
        "force_peak_mean_half_width": lambda speed: 1e3,
    }
    sweep = made(grid(speed=SPEEDS), metrics)
    curves(sweep, tmp_path / "c.png", metrics=["force_peak_mean"])
    ((y, half),) = seen
    np.testing.assert_allclose(half / y, 0.05)


def test_errors_of_metrics(made, gallery, tmp_path):
    """Cells whose stated error exceeds a twentieth of the colours are hatched, curves have bars."""
    errors = {
        "force": force,
        "force_error": lambda speed, clearance: 0.2 * force(speed, clearance) * (speed > 30.0),
    }
    sweep = made(grid(speed=SPEEDS, clearance=CLEARANCES), errors)
    maps(sweep, tmp_path / "m.png", metrics="force*")
    axes = gallery.figures[-1].axes[0]
    assert hatched(axes) == (SPEEDS > 30.0).sum() * len(CLEARANCES)
    curves(sweep, tmp_path / "c.png", x="speed", at={"clearance": CLEARANCES[0]})
    assert len(gallery.figures[-1].axes[0].collections) == 1  # the bars
    assert chosen_metrics(sweep, None) == ["force"]
    assert chosen_metrics(sweep, "*_error") == ["force_error"]
