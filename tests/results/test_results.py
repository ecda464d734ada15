"""The result file: layout, units, reading with h5py and xarray, streaming, honesty about partial
runs.
"""

import json

import h5py
import numpy as np
import pytest
import xarray

import clearance as cl
from clearance.results.stream import Content, Stream
from tests import mechanisms as m
from tests.seeds import few_of


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.h5"
    return cl.simulate(cl.load_case("six_bar_feeder"), turns=2.0, path=path, samples_per_turn=100)


@pytest.fixture(scope="module")
def dry(tmp_path_factory):
    path = tmp_path_factory.mktemp("dry") / "dry.h5"
    scene = cl.load_case("slider_crank", friction="coulomb")
    return cl.simulate(scene, turns=1.0, path=path, samples_per_turn=100)


def test_layout(run):
    """Groups, attributes and channels of a file, as documented."""
    with h5py.File(run.path) as file:
        assert file.attrs["format"] == "clearance-result"
        assert file.attrs["format_version"] == 2
        assert file.attrs["status"] == "complete"
        assert file.attrs["case"] == "six_bar_feeder"
        assert json.loads(file.attrs["parameters"]) == {}
        assert json.loads(file.attrs["scene"])["joints"][1]["type"] == "ClearanceRevolute"
        assert "def rhs(t, y, par, work, out)" in file.attrs["kernel"]
        assert set(file["bodies"]) == {"crank", "rod2", "rocker", "rod4", "slider"}
        assert set(file["bodies/crank"]) == {
            "time",
            "x",
            "y",
            "theta",
            "vx",
            "vy",
            "omega",
            "ax",
            "ay",
            "alpha",
        }
        assert set(file["joints/A"]) == {"time", "force_x", "force_y"}
        assert file["joints/A/time"] == file["time"]
        assert set(file["joints/B"]) == {
            "time",
            "force_x",
            "force_y",
            "eccentricity_x",
            "eccentricity_y",
            "eccentricity_ratio",
            "gap",
            "film_thickness_ratio",
            "film_radial",
            "film_tangential",
            "film_pressure",
            "side_flow",
            "power_loss",
            "dissipated",
        }
        assert set(file["drives/crank"]) == {"time", "torque", "power"}
        assert set(file["energy"]) == {
            "time",
            "kinetic",
            "potential",
            "input",
            "dissipated",
            "residual",
        }
        assert {"time", "joint", "kind", "impact_speed", "peak_force", "duration"} <= set(
            file["events"]
        )
        assert set(file["solver"]) == {"time", "step", "error_estimate", "step_number"}
        assert {
            "method",
            "rtol",
            "atol",
            "steps",
            "rejected",
            "evaluations",
            "jacobians",
            "wall_s",
        } <= set(file["solver"].attrs)
        file.visititems(check_dataset)


def check_dataset(name, item):
    if isinstance(item, h5py.Dataset):
        assert item.attrs["units"], name
        assert item.attrs["long_name"], name
        if item.dtype.kind == "f":
            assert np.isfinite(item[()]).all(), name


def test_dry_channels(dry):
    """Channels of a dry joint, and its events."""
    with h5py.File(dry.path) as file:
        assert {"contact_force", "friction", "gap", "power_loss"} <= set(file["joints/C"])
        assert "film_radial" not in file["joints/C"]
        assert (file["joints/C/contact_force"][()] >= 0.0).all()
        assert set(file["events/joint"].asstr()[()]) == {"C"}
        file.visititems(check_dataset)


@pytest.mark.parametrize(
    "group", ["/", "bodies/slider", "joints/B", "drives/crank", "energy", "events", "solver"]
)
def test_opens_in_xarray(run, group):
    """Each group opens in xarray, with units."""
    with xarray.open_dataset(run.path, group=group, engine="h5netcdf") as data:
        assert "time" in data.coords
        for variable in data.variables.values():
            assert "units" in variable.attrs or np.issubdtype(variable.dtype, np.datetime64)


def test_reading(run):
    """Parts are read by name; a wrong name is answered with the right ones."""
    result = cl.open_result(run.path)
    assert result.complete
    assert result.time.size == 201
    assert result.time[-1] == pytest.approx(0.4, rel=1e-15)
    assert result["slider"].ax.shape == (201,)
    assert result.joint("B").force.shape == (201, 2)
    assert result.joint("B").eccentricity.shape == (201, 2)
    assert result.drive("crank").torque.shape == (201,)
    assert result.range("joints/B/gap")[0] == result.joint("B").gap.min()
    with pytest.raises(KeyError, match="no 'nobody' among bodies; there are: crank"):
        result["nobody"]
    with pytest.raises(KeyError, match=r"a channel is result.values\('bodies/crank/x'\)"):
        result["bodies/crank/x"]
    with pytest.raises(AttributeError, match="no channel 'ay2'; it has"):
        result["slider"].ay2  # noqa: B018
    result.close()


def test_angles_are_continuous(run):
    """Two turns of the crank, and no jump of any body by more than its speed allows."""
    assert run["crank"].theta[-1] - run["crank"].theta[0] == pytest.approx(4 * np.pi, abs=1e-12)
    for body in ("crank", "rod2", "rocker", "rod4"):
        steps = np.abs(np.diff(run[body].theta))
        assert steps.max() <= 1.05 * np.abs(run[body].omega).max() * np.diff(run.time).max()


def test_force_balance_of_a_body(run):
    """Newton-Euler on rod 4 from the stored channels alone: m a = sum of joint forces + weight;
    1e-12 of the forces.
    """
    mass, g = 0.2669, 9.81
    force = -run.joint("F").force + run.joint("E").force
    np.testing.assert_allclose(mass * run["rod4"].ax, force[:, 0], atol=1e-11)
    np.testing.assert_allclose(mass * (run["rod4"].ay + g), force[:, 1], atol=1e-11)


def test_velocities_are_derivatives(run):
    """Central differences of the stored positions: second order in the sampling."""
    t = run.time
    for body in ("rocker", "slider"):
        slope = (run[body].x[2:] - run[body].x[:-2]) / (t[2] - t[0])
        np.testing.assert_allclose(
            slope, run[body].vx[1:-1], atol=3e-3 * np.abs(run[body].vx).max()
        )


def test_warnings_are_kept_with_the_run(run):
    """The feeder's L/D = 1 is no long bearing; a soft restitution is not what the law gives; both
    are stated.
    """
    assert run.warnings == []
    long = cl.simulate(cl.load_case("six_bar_feeder", film="pinkus_sternlicht"), until=1e-4)
    assert long.warnings == [
        "joint B: pinkus_sternlicht: a long bearing's film; L/D = 1 makes it too stiff"
    ]
    soft = cl.simulate(cl.load_case("slider_crank", restitution=0.5, roughness=1e-6), until=1e-4)
    assert soft.warnings == [
        "joint C: lankarani_nikravesh delivers a restitution of 0.73 where 0.50 is set"
    ]
    thin = cl.simulate(
        cl.load_case("slider_crank", model="lubricated", viscosity=0.04, roughness=1e-6), turns=1
    )
    assert ["film thickness ratio falls to" in w for w in thin.warnings] == [True, False, False]
    assert ["piezoviscous number" in w for w in thin.warnings] == [False, True, False]
    explicit = cl.simulate(
        cl.load_case("slider_crank", model="lubricated"), until=1e-4, method="dop853"
    )
    assert ["method dop853 is explicit" in w for w in explicit.warnings] == [True]


def test_save_and_open(run, tmp_path):
    """A saved copy is complete and alone in its folder."""
    copy = run.save(tmp_path / "deep" / "copy.h5")
    assert cl.open_result(copy).time.size == 201
    assert [p.name for p in copy.parent.iterdir()] == ["copy.h5"]


def test_what_is_not_a_result(tmp_path):
    """Missing and foreign files are refused."""
    with pytest.raises(FileNotFoundError, match="no result file"):
        cl.open_result(tmp_path / "nothing.h5")
    text = tmp_path / "text.h5"
    text.write_text("hello")
    with pytest.raises(ValueError, match="not a readable HDF5 file"):
        cl.open_result(text)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file.attrs["format"] = "other"
    with pytest.raises(ValueError, match="not a clearance result"):
        cl.open_result(tmp_path / "other.h5")


def test_a_result_replaces_results_alone(run, tmp_path):
    """A scene file is not lost to a slip of `-o`."""
    scene = tmp_path / "machine.toml"
    scene.write_text("text = 'of hours'\n")
    with pytest.raises(ValueError, match="machine.toml is there already and is no result file"):
        cl.simulate(cl.load_case("double_pendulum"), until=0.01, path=scene)
    with pytest.raises(ValueError, match="no result file"):
        run.save(scene)
    assert scene.read_text() == "text = 'of hours'\n"


def test_streaming_gives_the_same_as_one_buffer(monkeypatch):
    """Buffers of a few rows, steps and contacts: the file does not depend on them."""
    from clearance.run import run as running

    scene = cl.load_case("slider_crank")
    entire = cl.simulate(scene, until=2e-3, samples=301)
    monkeypatch.setattr(running, "ROWS", 7)
    monkeypatch.setattr(running, "LOG_ROWS", 5)
    monkeypatch.setattr(running, "IMPACT_ROWS", 2)
    monkeypatch.setattr(running, "BUDGET", 11)
    pieces = cl.simulate(scene, until=2e-3, samples=301)
    assert len(entire.events["time"]) > 3
    for path in (
        "time",
        "bodies/rod/theta",
        "joints/C/force_x",
        "events/time",
        "events/peak_force",
        "solver/time",
    ):
        np.testing.assert_array_equal(entire.file[path][()], pieces.file[path][()], err_msg=path)


def test_a_killed_run_leaves_no_file_under_the_final_name(tmp_path):
    """Until its end a run has a temporary name."""
    writer = Stream(tmp_path / "run.h5", Content([], {}))
    writer.flush()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.h5.lock", "run.h5.partial"]
    writer.abandon()


def test_interrupt_keeps_what_was_computed(tmp_path):
    """An interrupted run is partial, and states it."""

    def interrupt(share):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cl.simulate(
            cl.load_case("six_bar_feeder"),
            turns=500.0,
            path=tmp_path / "run.h5",
            progress=interrupt,
        )
    result = cl.open_result(tmp_path / "run.h5")
    assert result.status.startswith("partial: interrupted at t = ")
    assert 0.0 < result.time[-1] < 100.0


@pytest.mark.parametrize("rtol", [1e-10])
@pytest.mark.parametrize(
    ("case", "options", "span"),
    [
        ("double_pendulum", {}, {"until": 3.0}),
        ("four_bar", {"model": "ideal"}, {"turns": 2}),
        ("slider_crank", {"model": "dry"}, {"turns": 1}),
        ("six_bar_feeder", {"model": "dry", "friction": "none", "joints": "B"}, {"turns": 1}),
        ("six_bar_feeder", {"model": "lubricated", "joints": "B,C,E"}, {"turns": 1}),
        ("six_bar_feeder", {"model": "dry", "friction": "coulomb", "joints": "C"}, {"turns": 1}),
    ],
)
def test_energy_closes(case, options, span, rtol):
    """Below 1e-8 of the energy turned over at rtol 1e-10."""
    result = cl.simulate(cl.load_case(case, **options), rtol=rtol, **span)
    assert np.abs(result.energy.residual).max() < 1e-8 * result.file["energy"].attrs["turned_over"]


def test_springs_loads_and_motor_close_the_ledger():
    """Spring, damper, force, torque, torsion spring and a torque drive in one scene: every term of
    the ledger.
    """
    arm = m.body("arm", {"S": (0, 0), "E": (0.3, 0)}, angle=0.4, com=(0.15, 0))
    fore = m.body("fore", {"E": (0, 0), "H": (0.25, 0)}, angle=-0.3, com=(0.1, 0.01))
    scene = cl.Scene(
        cl.Revolute(cl.ground, arm["S"], name="S"),
        cl.Revolute(arm["E"], fore["E"], name="E"),
        cl.SpringDamper(
            cl.ground.at(0.4, 0.3), fore["H"], stiffness=200.0, damping=1.5, free_length=0.1
        ),
        cl.TorsionSpring(arm, fore, stiffness=3.0, damping=0.05, free_angle=-0.5),
        cl.Force(fore["H"], x=2.0, y=-1.0),
        cl.Torque(arm, 0.5),
        cl.Drive(arm, torque=1.5, speed_start=2.0),
    )
    result = cl.simulate(scene, until=2.0, rtol=1e-10)
    assert result["arm"].omega[0] == pytest.approx(2.0, rel=1e-12)
    assert np.abs(result.energy.residual).max() < 1e-8 * result.file["energy"].attrs["turned_over"]
    assert result.energy.dissipated[-1] > 0.0


@pytest.mark.parametrize(
    "name", ["scotch_yoke", "pushed_four_bar", "parallelogram", "inverted_slider"]
)
def test_energy_closes_in_other_mechanisms(name):
    """Two slides, a torque-driven loop, an over-constrained loop with a dry joint, a slide on a
    moving body: 1e-6 at rtol 1e-9 (samples of a stiff run lie between steps).
    """
    scene = {
        "scotch_yoke": lambda: m.scotch_yoke(m.chooser(m.film, "B")),
        "pushed_four_bar": lambda: m.pushed_four_bar(m.chooser(m.film, "C")),
        "parallelogram": lambda: m.parallelogram(
            lambda a, b, name: m.dry(a, b, name, stiffness=1e9)
        ),
        "inverted_slider": lambda: m.inverted_slider(m.chooser(m.dry, "O")),
    }[name]()
    result = cl.simulate(scene, until=0.15, rtol=1e-9)
    assert np.abs(result.energy.residual).max() < 1e-6 * result.file["energy"].attrs["turned_over"]
    result.file.visititems(check_dataset)


def test_a_run_that_lost_energy_says_so():
    """A parallelogram driven through its flat position changes branch there, which no position
    equation forbids.
    """
    lengths = {"crank": 0.05, "coupler": 0.15, "rocker": 0.05}
    crank, coupler, rocker = (
        m.body(n, {"a": (0, 0), "b": (x, 0)}, angle=0.8 * (x < 0.1)) for n, x in lengths.items()
    )
    scene = cl.Scene(*m.loop(crank, coupler, rocker, 0.15), cl.Drive(crank, speed=12.0))

    with pytest.raises(
        cl.SimulationError, match=r"from t = 0\.\d+ s on: .*came to its dead centre"
    ) as caught:
        cl.simulate(scene, turns=8)
    assert any("energy ledger does not close" in w for w in caught.value.result.warnings)


def test_a_late_jump_of_energy_is_seen_in_a_long_run():
    """The watch judges stretches of the run: 8 J lost after 2000 J have been turned over are not
    forgiven.
    """
    from clearance.results.recorder import LedgerWatch

    t = np.linspace(0.0, 100.0, 20001)
    kinetic = 5.0 + 5.0 * np.sin(2 * np.pi * t)
    residual = np.where(t > 90.0, 8.0, 0.0) + 1e-9 * t
    still = np.zeros((t.size, 2))
    rows = np.column_stack([kinetic, still, residual])
    watch = LedgerWatch()
    for part in np.array_split(np.arange(t.size), 13):
        watch.add(t[part], rows[part])
    assert max(watch.worst, watch.share()) > 0.5
    assert watch.since == pytest.approx(90.0, abs=0.02)
    calm = LedgerWatch()
    calm.add(t, np.column_stack([kinetic, still, 1e-9 * t]))
    assert max(calm.worst, calm.share()) < 1e-9


@pytest.mark.parametrize("seed", few_of(range(20), 4))
def test_a_watch_keeps_no_rows(seed):
    """Pieces of any length are judged as all rows at once, by sums that run on: what the watch
    keeps has one size, also in a stretch that never ends.
    """
    from clearance.results.recorder import LedgerWatch

    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.0, 1e-3, rng.integers(50, 3000)))
    rate, loss = 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(-9, -1)
    kinetic = 1.0 + np.sin(rate * t)
    residual = loss * (t > rng.uniform(0.0, t[-1])) + 1e-12 * rng.standard_normal(t.size)
    rows = np.column_stack([kinetic, rate * t, 0.0 * t, residual])
    watches = []
    for cuts in (0, rng.integers(1, 50)):
        watch, sizes = LedgerWatch(floor=10.0 ** rng.uniform(-12, 3)), set()
        watch.low[:], watch.high[:] = rows[:, :3].min(axis=0), rows[:, :3].max(axis=0)
        watch.floor = watches[0].floor if watches else watch.floor
        for part in np.array_split(np.arange(t.size), np.sort(rng.integers(0, t.size, cuts))):
            watch.add(t[part], rows[part])
            sizes.add(sum(np.size(v) for v in vars(watch).values()))
        assert len(sizes) <= 2  # before the first row and after it
        watches.append(watch)
    one, many = watches
    assert many.worst == pytest.approx(one.worst, rel=1e-9, abs=1e-18)
    assert many.share() == pytest.approx(one.share(), rel=1e-9, abs=1e-18)
    assert many.since == one.since


def test_chosen_channels():
    """A file has the channels that were chosen."""
    scene = cl.load_case("slider_crank", model="dry")
    options = {"turns": 1.0, "samples_per_turn": 50}
    entire = cl.simulate(scene, **options)
    some = cl.simulate(
        scene, **options, channels=["bodies/slider/a[xy]", "joints/C"], compression=3
    )
    assert some.names("bodies") == ("slider",)
    assert some.names("bodies/slider") == ("ax", "ay")
    assert "eccentricity_x" in some.joint("C")
    assert some.names("energy") == ()
    assert some.file["solver/step"].shape == (0,)  # the log of steps comes on request
    assert (
        cl.simulate(scene, **options, channels=["solver"]).file["solver/step"].shape
        == entire.file["solver/step"].shape
    )
    np.testing.assert_array_equal(some["slider"].ax, entire["slider"].ax)
    np.testing.assert_array_equal(some.events["peak_force"], entire.events["peak_force"])
    assert some.facts("joints/B") == entire.facts("joints/B")
    assert some.facts("energy") == entire.facts("energy")
    with pytest.raises(KeyError, match="or not stored"):
        some.values("energy/kinetic")
    with pytest.raises(
        ValueError, match=r"channels: 'joints/X' fits none; there are bodies/crank/\*"
    ):
        cl.simulate(scene, **options, channels=["joints/X"])
    with pytest.raises(TypeError, match="channels: give a list"):
        cl.simulate(scene, **options, channels="joints/B")
    with pytest.raises(ValueError, match="compression must be"):
        cl.simulate(scene, **options, compression=10)
