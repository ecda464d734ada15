"""Sensitivities: against closed forms and independent runs, their stated errors, refusals,
files.
"""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray
from clearance.postprocess.tornado import tornado

import clearance as cl
from clearance.accuracy import by_differences
from clearance.accuracy.fixed_steps import Ends, Replay, halved
from clearance.metrics.metrics import Metric, metrics
from clearance.results.reading import Damaged
from clearance.results.result import open_result
from clearance.results.sensitivity import Sensitivities, Sensitivity, quotient
from clearance.results.short_file import ShortFile
from clearance.scene.parameter import varied, wanted
from clearance.simulation import prepare

CRANK = """
import clearance as cl

def scene(*, crank: float = 0.05, rod: float = 0.15, speed: float = 2.0, side: int = 1) -> cl.Scene:
    \"\"\"A slider-crank with ideal joints.

    crank: length [m]
    rod: length [m]
    speed: of the crank [rad/s]
    side: of nothing [-]
    \"\"\"
    one = cl.Body("one", 0.3, 1e-4, points={"O": (0, 0), "P": (crank, 0)})
    two = cl.Body("two", 0.2, 5e-4, points={"P": (0, 0), "Q": (rod, 0)}, angle=-0.2)
    block = cl.Body("block", 0.1, 1e-5, points={"Q": (0, 0)})
    return cl.Scene(
        cl.Revolute(cl.ground, one["O"], name="A"), cl.Revolute(one["P"], two["P"], name="B"),
        cl.Revolute(two["Q"], block["Q"], name="C"), cl.Prismatic(cl.ground, block["Q"], name="G"),
        cl.Drive(one, speed=speed, start=0.0),
    )
"""
FILM = {"model": "lubricated", "film": "pinkus_sternlicht", "speed": 50.0}


@pytest.fixture
def crank(tmp_path):
    (tmp_path / "crank.py").write_text(CRANK)
    return tmp_path / "crank.py"


def test_ideal_slider_crank(crank):
    """At the outer dead centre the block has -w^2 r (1 + r / l), its smallest acceleration: by hand
    d/dr = -w^2 (1 + 2 r / l), d/dl = w^2 (r / l)^2, d/dw = -2 w r (1 + r / l).

    To 1e-9: the motion is prescribed, and a difference of 1e-5 is off by 1e-10.
    """
    r, length, w = 0.05, 0.15, 2.0
    result = cl.simulate(cl.load_case(crank), turns=2, sensitivity="crank, rod, speed")
    exact = {
        "crank": -w * w * (1.0 + 2.0 * r / length),
        "rod": (w * r / length) ** 2,
        "speed": -2.0 * w * r * (1.0 + r / length),
    }
    for name, value in exact.items():
        actual = result.sensitivities["block_acceleration_min", name]
        assert actual.value == pytest.approx(value, rel=1e-9, abs=1e-9)
        assert actual.trusted
    assert actual.units == "(m/s2)/(rad/s)"
    assert actual.change == pytest.approx(0.02 * actual.metric, rel=1e-9)


def oscillator(stiffness=200.0, mass=0.5):
    block = cl.Body("block", mass, 1e-3, position=(0.13, 0.0))
    return cl.Scene(
        cl.Prismatic(cl.ground, block, name="G"),
        cl.SpringDamper(cl.ground, block, stiffness=stiffness, free_length=0.1, name="S"),
        gravity=(0.0, 0.0),
    )


def test_oscillator():
    """Released 0.03 m from rest: a_max = A k / m, d/dk = A / m, d/dm = -A k / m^2, of a scene that
    no case made. To 1e-6: differences of runs at 1e-8, which err alike.
    """
    names = "springs/S/stiffness", "bodies/block/mass"
    result = cl.simulate(oscillator(), until=0.4, sensitivity=names).sensitivities
    by_stiffness, by_mass = (result["block_acceleration_max", name] for name in names)
    assert by_stiffness.value == pytest.approx(0.03 / 0.5, rel=1e-6)
    assert by_mass.value == pytest.approx(-0.03 * 200.0 / 0.25, rel=1e-6)
    assert by_stiffness.units == "(m/s2)/(N/m)"


def test_against_independent_runs(tmp_path):
    """A lubricated slider-crank: within 1e-3 of central differences of runs at 1e-11 in the median,
    and each within its stated error and what two references differ by.
    """

    def numbers(viscosity):
        scene = cl.load_case("slider_crank", viscosity=viscosity, **FILM)
        run = cl.simulate(scene, turns=1, rtol=1e-11, error=None)
        return {name: m.value for name, m in metrics(run).items()}

    scene = cl.load_case("slider_crank", **FILM)
    path = tmp_path / "run.h5"
    result = cl.simulate(scene, turns=1, sensitivity=["viscosity"], path=path).sensitivities
    d = 4e-4
    near, far = (
        {n: (above - low[n]) / (2.0 * k * d) for n, above in numbers(0.4 + k * d).items()}
        for k, low in ((1, numbers(0.4 - d)), (2, numbers(0.4 - 2.0 * d)))
    )
    shares = []
    for (metric, _), one in result.items():
        exact, apart = near[metric], abs(near[metric] - far[metric])
        assert abs(one.value - exact) <= one.error + apart
        shares.append(abs(one.value - exact) / max(abs(exact), 1e-300))
    assert len(shares) > 10
    assert np.median(shares) < 1e-3
    with open_result(path) as again:
        assert dict(again.sensitivities) == dict(result)
        tree = again.to_xarray()
    with xarray.open_dataset(path, group="sensitivities", engine="h5netcdf") as data:
        xarray.testing.assert_equal(data, tree["/sensitivities"].to_dataset())
        cell = data["value"].sel(metric="joint_C_gap_min", parameter="viscosity")
        assert float(cell) == result["joint_C_gap_min", "viscosity"].value


def test_same_steps_same_run():
    """A run on its own steps is itself (1e-9: a step after a refused one keeps its Jacobian); half
    steps are closer to the truth than the tolerance.
    """
    scene, ends = cl.load_case("slider_crank", **FILM), Ends()
    first, second, third = (prepare(scene, turns=0.5, method="rodas5p") for _ in range(3))
    first.observers.append(ends)
    one = by_differences.recorded(first)
    two = by_differences.recorded(Replay(second, ends.times, second.span.until))
    half = halved(ends.times)
    three = by_differences.recorded(Replay(third, half, third.span.until))
    assert len(half) == 2 * len(ends.times)
    path = "joints/C/eccentricity_x"
    size = np.abs(one.values(path)).max()
    np.testing.assert_allclose(two.values(path), one.values(path), atol=1e-9 * size)
    apart = np.abs(three.values(path) - one.values(path)).max()
    assert 1e-12 * size < apart < 1e-4 * size


def test_a_corner_is_not_trusted():
    """M = |p| has a jump of its slope at 0, of 2: the error says a quarter of it. A parabola is
    trusted: its difference is exact to rounding over the width.
    """
    one = varied(oscillator(), "bodies/block/mass")
    d = by_differences.WIDTH * one.size

    def of(function):
        values = {k: {"m": Metric(function(k * d), "N", "")} for k in by_differences.PLACES}
        return dict(by_differences.differences(one, values, values))["m"]

    assert of(lambda x: 7.0 + abs(x)).error == pytest.approx(0.5, rel=1e-6)
    assert not of(lambda x: 7.0 + abs(x)).trusted
    smooth = of(lambda x: 7.0 + 3.0 * x + 0.2 * x * x)
    assert smooth.value == pytest.approx(3.0, rel=1e-9)
    assert smooth.trusted
    assert smooth.error < 1e-9


@pytest.mark.parametrize(
    ("units", "parameter", "quotient_of"),
    [
        ("N", "m", "N/m"),
        ("N m", "Pa s", "N m/(Pa s)"),
        ("m/s2", "rad/s", "(m/s2)/(rad/s)"),
        ("m", "m", "1"),
        ("N", "-", "N"),
    ],
)
def test_units(units, parameter, quotient_of):
    """Units of a number over a parameter are simplified."""
    assert quotient(units, parameter) == quotient_of


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ("crnk", r"no parameter 'crnk' \(did you mean crank\?\)"),
        ("side", "sensitivity to side: 1 is no number that can vary"),
        ("bodies/one/mas", r"no number of this scene \(did you mean bodies/one/mass\?\)"),
        ("bodies/one/points", "is no number"),
        ("bodies/one/angle", "its value is 0.*give the size that counts"),
        ("crank,crank", "crank is requested twice"),
        ("crank,", "a name is missing"),
        ("", "sensitivity '': give at least one parameter"),
        ((), r"sensitivity \(\): give at least one parameter"),
        ({"crank": -1.0}, "size of crank must be positive, got -1"),
        ("crank=x", "size of crank: 'x' is not a number"),
        ("crank=1N", "size of crank: '1N' is in N, expected m"),
    ],
)
def test_wrong_parameters(parameters, message, crank):
    """A parameter that the scene does not have is refused."""
    with pytest.raises(ValueError, match=message):
        cl.simulate(cl.load_case(crank), turns=1, sensitivity=parameters)


MOTOR = """
import clearance as cl

def scene(*, crank: float = 0.03, friction: float = 0.15, spring: float = 2e3) -> cl.Scene:
    \"\"\"A slider-crank that a motor drives: its turns are uneven.

    crank: length [m]
    friction: coefficient of the guide [-]
    spring: stiffness [N/m]
    \"\"\"
    one = cl.Body("one", 0.8, 4e-4, points={"O": (0, 0), "P": (crank, 0)})
    two = cl.Body("two", 0.5, 8e-4, points={"P": (-0.07, 0), "Q": (0.07, 0)})
    block = cl.Body("block", 1.2, 1e-4, points={"Q": (0, 0)})
    law = cl.joint_coulomb(coefficient=friction, transition_rate=2e-3)
    motor = cl.dc_motor(voltage=24.0, resistance=0.5, inductance=1e-3, constant=0.35)
    return cl.Scene(
        cl.Revolute(cl.ground, one["O"], name="A"), cl.Revolute(one["P"], two["P"], name="B"),
        cl.Revolute(two["Q"], block["Q"], name="C"),
        cl.Prismatic(cl.ground, block["Q"], name="G", axis=(1, 0), overlap=0.05, friction=law),
        cl.SpringDamper(cl.ground.at(0.3, 0), block["Q"], stiffness=spring, free_length=0.12),
        cl.Drive(one, torque=motor, nominal=60.0, name="M"),
    )
"""


@pytest.fixture
def motor(tmp_path):
    path = tmp_path / "motor.py"
    path.write_text(MOTOR)
    return path


@pytest.mark.parametrize(("friction", "median", "worst"), [(0.0, 1e-6, 1e-3), (0.15, 1e-3, 2e-2)])
def test_turns_of_a_motor(friction, median, worst, motor):
    """Against differences of independent runs at 1e-11 and four times the samples, extrapolated:
    without friction half of all within 1e-6, what those are good for; with it within 1e-3, and the
    worst within 2e-2, for samples see a jump of the forces somewhere between two of them.
    """

    def values(crank):
        scene = cl.load_case(motor, crank=crank, friction=friction)
        return metrics(cl.simulate(scene, until=0.4, rtol=1e-11, error=None, samples=6401))

    scene = cl.load_case(motor, friction=friction)
    table = cl.simulate(scene, until=0.4, sensitivity="crank").sensitivities
    slopes = []
    for width in (6e-5, 3e-5):
        up, down = values(0.03 + width), values(0.03 - width)
        slopes.append({n: (up[n].value - down[n].value) / (2.0 * width) for n in up})
    true = {n: (4.0 * slopes[1][n] - slopes[0][n]) / 3.0 for n in table.metrics}
    off = {n: abs(table[n, "crank"].value / t - 1.0) for n, t in true.items() if t}
    assert {"joint_A_force_rms", "drive_M_torque_rms", "block_acceleration_max"} <= off.keys()
    assert np.median(list(off.values())) < median
    assert max(off.values()) < worst


def test_impacts_are_refused():
    """Motions with impacts have no derivative that steps could give."""
    with pytest.raises(ValueError, match="joint C starts with a touch"):
        cl.simulate(cl.load_case("slider_crank", model="dry"), turns=1, sensitivity="speed")


def test_a_bound_is_refused():
    """A number that may not be exceeded has no difference on both sides."""
    scene = cl.load_case("slider_crank", model="mixed", restitution=1.0, contact="hunt_crossley")
    with pytest.raises(ValueError, match="sensitivity to restitution, beside 1: .*restitution"):
        cl.simulate(scene, turns=1, sensitivity="restitution")


def test_sizes_of_parameters():
    """The size of a change is the one stated, else the parameter's value."""
    assert wanted("a, b=2mm") == {"a": None, "b": "2mm"}
    assert wanted({"a": 3.0}) == {"a": 3.0}
    assert wanted(["a"]) == {"a": None}
    scene = oscillator()
    assert varied(scene, "bodies/block/mass", "2g").size == 2e-3
    assert varied(scene, "bodies/block/mass").size == 0.5


def test_columns_have_gaps():
    """Columns and back: what there is not stays away."""
    one, two = Sensitivity(1.0, 0.1, 5.0, "N", 2.0, "m"), Sensitivity(3.0, 0.3, 5.0, "N", 4.0, "-")
    actual = Sensitivities({("f", "a"): one, ("f", "b"): two, ("g", "b"): two})
    assert dict(Sensitivities.of_columns(actual.columns())) == dict(actual)
    assert np.isnan(actual.columns()["value"][1, 0])


def test_a_damaged_table(tmp_path):
    """A table of another shape is refused by its place in the file."""
    path = tmp_path / "run.h5"
    cl.simulate(oscillator(), until=0.1, sensitivity="bodies/block/mass", path=path).close()
    with h5py.File(path, "r+") as file:
        del file["sensitivities/error"]
        file["sensitivities"].create_dataset("error", data=np.zeros(3))
    with open_result(path) as again, pytest.raises(Damaged, match="error does not fit its table"):
        again.sensitivities  # noqa: B018


def test_trust():
    """A twentieth of the value, or what changes the metric by 1e-4 of the parameter's change."""
    of = {"metric": 10.0, "metric_units": "N", "size": 2.0, "parameter_units": "m"}
    assert Sensitivity(1.0, 0.05, **of).trusted
    assert not Sensitivity(1.0, 0.06, **of).trusted
    assert Sensitivity(0.0, 5e-4, **of).trusted
    assert not Sensitivity(0.0, 6e-4, **of).trusted


def test_the_command(crank, tmp_path, typed, request):
    """The line of a metric has the closed form of its change, 1 % of r times -w^2 (1 + 2 r / l);
    plain data, the tornado and the report of the file.
    """
    path = tmp_path / "run.h5"
    line = ["run", crank, "--turns 2 --sensitivity crank,rod -o", path]
    printed = " ".join(typed(*line).out.split())
    assert "change for 1 % more of crank rod" in printed
    assert "block_acceleration_min -3.333 +- 0.001 mm/s2 +666.7 +- 0.1 um/s2" in printed
    plain = typed(*line, "--json").document["sensitivities"]["block_acceleration_min"]
    assert plain["crank"]["value"] == pytest.approx(-20.0 / 3.0, rel=1e-9)
    assert plain["crank"]["trusted"] is True
    typed("plot", path, "tornado --metrics block_*")
    assert (tmp_path / "run_tornado.png").stat().st_size > 10_000
    assert "no sensitivities of 'blok_*'" in typed.line("plot", path, "tornado --metrics blok_*")
    request.getfixturevalue("undrawn")
    typed("report", path, "-o", tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    assert ">Sensitivities<" in page
    typed(*line, "--steady 1e-6", status=2)


def test_bars_have_words_and_units_that_read_well(monkeypatch):
    """Changes of a gap by 60 nm and 2 um are drawn in um: 1e6 of them, to rounding."""
    text = "smallest gap of joint B, negative in contact"
    words = {"joint_B_gap_min": SimpleNamespace(text=text)}
    monkeypatch.setattr("clearance.postprocess.tornado.metrics_of", lambda run: words)
    of = {"error": 0.0, "metric": 1e-5, "metric_units": "m", "size": 1.0, "parameter_units": "1"}
    rows = {("joint_B_gap_min", n): Sensitivity(v, **of) for n, v in (("a", 6e-6), ("b", -2e-4))}
    run = SimpleNamespace(sensitivities=Sensitivities(rows), clearances=["B"])
    panel = tornado(run).axes[0]
    assert panel.get_xlabel() == "change of the smallest gap of joint B [µm]"
    widths = [bar.get_width() for bar in panel.patches]
    assert widths == pytest.approx([-0.06, 0.06, 2.0, -2.0], rel=1e-12)


def test_why_a_file_has_none(tmp_path, monkeypatch):
    """A varied run that fails leaves the result, and the file states why."""
    monkeypatch.setattr(by_differences.Steps, "around", _fails)
    path = tmp_path / "run.h5"
    result = cl.simulate(oscillator(), until=0.1, sensitivity="bodies/block/mass", path=path)
    assert result.complete
    with open_result(path) as again:
        assert again.sensitivities.reason == "a run failed"
        assert not again.sensitivities
    with pytest.raises(KeyError, match="a run failed"):
        result.sensitivities["block_acceleration_max", "bodies/block/mass"]


def test_a_full_disk_keeps_the_run(tmp_path, monkeypatch, caplog):
    """The run stays as it was if the disk has no room for the table."""
    monkeypatch.setattr(ShortFile, "has_room", lambda *_: False)
    path = tmp_path / "run.h5"
    result = cl.simulate(oscillator(), until=0.1, sensitivity="bodies/block/mass", path=path)
    assert result.complete
    assert not result.sensitivities
    assert "no room" in caplog.text


def _fails(*_):
    raise by_differences.Impossible("a run failed")


def test_columns_of_a_sweep(crank, tmp_path, typed):
    """d/dr of the smallest acceleration, -w^2 (1 + 2 r / l), at two lengths of the rod, to 1e-9;
    its error beside it. A parameter that is none is refused before a directory is made.
    """
    folder = tmp_path / "out"
    line = ["sweep", str(crank), "-p", "rod=0.15,0.2", "--turns", "2", "--channels", "none"]
    line += ["--workers", "1", "-o", str(folder)]
    assert "no parameter 'crnk'" in typed.line(*line, "--sensitivity crnk")
    assert not folder.exists()
    typed(*line, "--sensitivity crank")
    swept = cl.open_sweep(folder)
    actual = swept.metrics["block_acceleration_min_by_crank"]
    exact = [-4.0 * (1.0 + 0.1 / rod) for rod in (0.15, 0.2)]
    np.testing.assert_allclose(actual, exact, rtol=1e-9)
    assert (swept.metrics["block_acceleration_min_by_crank_error"] < 1e-6).all()
    assert swept.known["block_acceleration_min_by_crank"][0] == "(m/s2)/m"
    assert not any("period" in name for name in swept.metrics if "_by_" in name)


def test_dry_points_of_a_sweep(tmp_path):
    """Points that touch have no sensitivities, and state why; the others have them."""
    fixed = {"film": "pinkus_sternlicht", "speed": 50.0}
    swept = cl.sweep(
        "slider_crank",
        cl.grid(model=["lubricated", "dry"]),
        tmp_path / "out",
        fixed=fixed,
        turns=1,
        channels=[],
        workers=1,
        sensitivity="viscosity",
    )
    assert swept.done.all()
    assert np.isfinite(swept.metrics["joint_C_gap_min_by_viscosity"]).tolist() == [True, False]
    assert "no sensitivities: contact of joint C starts with a touch" in swept.reason[1]
