"""Pressure fields in the result file: what they are, who reads them, and who is refused."""

import h5py
import numpy as np
import pytest
import xarray
from clearance.paper_figures import films
from clearance.postprocess import pressures

import clearance as cl


@pytest.fixture(scope="module")
def feeder(tmp_path_factory):
    """A fifth of a turn, 20 fields a turn."""
    path = tmp_path_factory.mktemp("fields") / "feeder.h5"
    return cl.simulate(cl.load_case("six_bar_feeder"), turns=0.2, path=path, pressure_fields=20)


def integrals(actual, joint):
    """Radial and tangential force of every field, Simpson's rule along and trapezia around (n,
    2).
    """
    rule = np.full(len(actual.axial), 2.0)
    rule[1::2], rule[[0, -1]] = 4.0, 1.0
    line = np.einsum("iza,z->ia", actual.pressure, rule) * np.diff(actual.axial)[0] / 3.0
    theta = actual.angle - actual.line_of_centres[:, None] + np.pi
    part = joint["radius"] * np.diff(actual.angle)[0]
    return np.stack([(line * f(theta)).sum(axis=1) * part for f in (np.cos, np.sin)], axis=-1)


def test_fields_carry_the_force_of_the_run(feeder, validated):
    """The table of the run and the elements of the fields: 1e-3 of each force, what both are right
    to.
    """
    actual = feeder.pressure_fields("B")
    joint, channels = next(j for j in feeder.scene["joints"] if j["name"] == "B"), feeder.joint("B")
    wanted = np.column_stack([channels.film_radial, channels.film_tangential])[actual.instant]
    both = (f[:, 0] + 1j * f[:, 1] for f in (integrals(actual, joint), wanted))
    source = "film table in the run"
    validated(
        "integral of pressure fields in a file",
        *both,
        1e-3,
        source=source,
        unit="N",
        kind="independent",
    )


def test_layout(feeder):
    """Units, names, checksums and dimensions; times are those of samples."""
    with h5py.File(feeder.path) as file:
        group = file["joints/B/film"]
        for name, data in group.items():
            assert {"units", "long_name"} <= set(data.attrs), name
            assert data.fletcher32, name
        assert [d.keys()[0] for d in group["pressure"].dims] == ["instant", "axial", "angle"]
        assert (group["time"][()] == file["time"][()][group["instant"][()]]).all()
        assert np.diff(group["time"][()]) == pytest.approx(0.01, abs=1e-3)
    actual = feeder.pressure_fields("B")
    assert actual.pressure.shape == actual.content.shape == (4, 17, 180)
    assert actual.pressure.min() == 0.0 < actual.pressure.max()
    assert 0.0 == actual.content.min() < actual.content.max() == 1.0
    assert (actual.pressure == actual.pressure[:, ::-1]).all()
    assert actual.pressure[:, [0, -1]] == pytest.approx(0.0, abs=1e-6 * actual.pressure.max())


def test_opens_as_a_tree(feeder):
    """xarray has pressure with axes, time and units."""
    with xarray.open_datatree(feeder.path, engine="h5netcdf", group="joints/B") as tree:
        pressure = tree["film"].ds["pressure"]
        assert pressure.dims == ("instant", "axial", "angle")
        assert pressure.attrs["units"] == "Pa"
        assert set(pressure.coords) >= {"instant", "axial", "angle", "time"}


def test_they_are_no_channels(feeder):
    """Channels of a joint are numbers along time only."""
    assert "film" not in feeder.names("joints/B")
    assert "/joints/B" in feeder.to_xarray().groups


def test_snapshots_show_them(feeder, tmp_path, typed):
    """Snapshots use the fields of the file, else they solve anew."""
    shots = typed("film snapshots", feeder.path, "--count 2 --json -o", tmp_path).document[
        "snapshots"
    ]
    assert [s["iterations"] for s in shots] == [0, 0]
    for shot in shots:
        assert shot["load"] == pytest.approx(shot["recorded"], rel=1e-3)
    anew = films.snapshots(feeder, "B", 2, mesh=(64, 8))
    assert all(shot.solution.iterations > 0 for shot in anew)


def test_animation_shows_them(feeder):
    """Each frame has the field nearest to its time."""
    from clearance.postprocess.animation import Lens

    joint = next(j for j in feeder.scene["joints"] if j["name"] == "B")
    lens = Lens(feeder, joint, np.array([0.012, 0.031]))
    assert list(lens.shown) == [0, 2]
    assert lens.turned == pytest.approx(
        np.interp([0.012, 0.031], feeder.time, feeder["crank"].theta)
    )


def test_not_unless_asked_for():
    """Without the option there are no fields."""
    result = cl.simulate(cl.load_case("six_bar_feeder"), turns=0.01)
    assert result.pressure_fields("B") is None


@pytest.mark.parametrize(
    ("options", "more", "line"),
    [
        ({"model": "dry"}, {}, "no joint has a film"),
        ({"film": "conserving"}, {}, "B has conserving"),
        ({"film": "short"}, {}, "B has short_film"),
        ({}, {"pressure_fields": 0}, "instants a turn, must be a whole number"),
        ({}, {"channels": ["joints/B/*"]}, "needs all channels"),
    ],
)
def test_refusals(options, more, line):
    """Before anything runs, naming the option and the film."""
    scene = cl.load_case("six_bar_feeder", **options)
    with pytest.raises(ValueError, match=line) as caught:
        cl.simulate(scene, turns=0.01, **{"pressure_fields": 4} | more)
    assert str(caught.value).startswith("pressure_fields")


def test_picture(feeder, tmp_path, monkeypatch):
    """Each instant has its pressures in MPa over degrees and mm, on one scale, with the edge of its
    film.
    """
    pages = []
    monkeypatch.setattr(pressures, "save", lambda figure, path, dpi: pages.append(figure))
    pressures.pressures(feeder, tmp_path / "p.png", joint="B")
    actual, (page,) = feeder.pressure_fields("B"), pages
    panels = [axes for axes in page.axes if axes.get_title()]
    assert len(panels) == len(actual.time) == 4
    for axes, time, pressure, line in zip(
        panels, actual.time, actual.pressure, actual.line_of_centres, strict=True
    ):
        assert axes.get_title().startswith(f"{1e3 * time:.4g} ms")
        assert axes.get_title().endswith(f"up to {1e-6 * pressure.max():.3g} MPa")
        field, _, edge = axes.collections
        assert field.get_clim()[1] == pytest.approx(1e-6 * actual.pressure.max(), rel=0.1)
        assert len(edge.get_paths()[0].vertices) > 10
        assert axes.lines[0].get_xdata()[0] == pytest.approx(np.degrees(line))
        assert axes.get_ylim() == pytest.approx((1e3 * actual.axial[0], 1e3 * actual.axial[-1]))


def test_pictures_of_joints_without_fields_are_refused(feeder, typed):
    """A joint without fields is answered with those that have some."""
    assert "no pressure fields of joint 'C'; of B" in typed.line(
        "plot", feeder.path, "pressure --joint C"
    )
