"""Units (FMI 3.0) in FMPy against runs of the package."""

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import clearance as cl
from clearance.exporting import unit
from clearance.exporting.check import checked
from clearance.exporting.model import Model
from tests.exporting.compiled import SCENES, get, opened, put, random_places, rates
from tests.seeds import few_of

C = 1e-4  # clearance of the feeder [m]
#: scenes with several spots of contact, and how long they run [s]
SEVERAL = [
    ("six_bar_feeder", {"model": "mixed", "joints": "B,C,E"}, 0.05),
    ("six_bar_feeder", {"model": "dry", "joints": "B,C,E"}, 0.005),
    ("four_bar_clearances", {}, None),
    ("guide_slider", {}, 0.01),
]
OFFSETS = ["joints.B.eccentricity_x", "joints.B.eccentricity_y"]


@pytest.fixture(scope="module")
def feeder(tmp_path_factory):
    """Units of the feeder by its model, each made once."""
    folder, units = tmp_path_factory.mktemp("units"), {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(unit, "has_zig", lambda: False)

        def unit_of(model, **values):
            key = f"{model}_{len(units)}" if values else model
            if key not in units:
                scene = cl.load_case("six_bar_feeder", model=model, **values)
                path = str(cl.export(scene, fmu=folder / f"{key}.fmu").fmu)
                units[key] = scene, path
            return units[key]

        yield unit_of


@pytest.mark.parametrize("scene", few_of(SCENES, 1), ids=str)
def test_valid(scene, tmp_path, monkeypatch):
    """FMPy's validation has no message: the schema, names, units, starts, structure."""
    monkeypatch.setattr(unit, "has_zig", lambda: False)
    case, values = scene
    path = cl.export(cl.load_case(case, **values), fmu=tmp_path / "one.fmu").fmu
    assert validate_fmu(str(path)) == []


def own_offsets(scene, time, rtol=1e-10):
    """Eccentricities of joint B at sampled times of a run of the package."""
    run = cl.simulate(scene, until=time[-1], rtol=rtol, samples=len(time))
    np.testing.assert_allclose(run.time, time, atol=1e-12)
    return run.joint("B").eccentricity


@pytest.mark.parametrize(("model", "limit"), [("lubricated", 1e-6), ("mixed", 1e-5)])
def test_model_exchange(feeder, model, limit):
    """CVode at 1e-8 over two turns: that close, in clearances, to a run at 1e-10."""
    scene, path = feeder(model)
    until = 2 * scene.turn
    rows = simulate_fmu(
        path,
        fmi_type="ModelExchange",
        solver="CVode",
        relative_tolerance=1e-8,
        stop_time=until,
        output_interval=until / 200,
        record_events=False,
        output=OFFSETS,
    )
    package = own_offsets(scene, rows["time"])
    off = [np.abs(rows[name] - package[:, i]).max() for i, name in enumerate(OFFSETS)]
    assert max(off) < limit * C


def test_first_contacts(feeder):
    """Dry, half a turn: the first five touches within 1e-9 s, impact speeds within 1e-6 m/s."""
    scene, path = feeder("dry")
    until = 0.5 * scene.turn
    rows = simulate_fmu(
        path,
        fmi_type="ModelExchange",
        solver="CVode",
        relative_tolerance=1e-9,
        stop_time=until,
        output_interval=until / 4000,
        output=["joints.B.impact_speed"],
    )
    speed = rows["joints.B.impact_speed"]
    first = 1 + np.flatnonzero((speed[1:] >= 0.0) & (speed[:-1] < 0.0))[:5]
    package = cl.simulate(scene, until=until, rtol=1e-11).events
    np.testing.assert_allclose(rows["time"][first], package["time"][:5], rtol=0, atol=1e-9)
    np.testing.assert_allclose(speed[first], package["impact_speed"][:5], rtol=0, atol=1e-6)


@pytest.mark.parametrize("model", ["lubricated", "mixed"])
def test_communication_steps(feeder, model):
    """20 and 1000 steps a turn and uneven ones: within 1e-6 clearances of a run at 1e-10.

    Some steps are of 1e-12 s; the contact of the mixed joint begins and ends inside steps.
    """
    scene, path = feeder(model)
    until = 2 * scene.turn
    checks = np.linspace(0.0, until, 41)
    package, rng = own_offsets(scene, checks), np.random.default_rng(3)
    uneven = rng.uniform(0.0, until, 200)
    for times in (checks, np.linspace(0.0, until, 2001), np.append(uneven, uneven + 1e-12)):
        with opened(path, FMU3Slave) as one:
            one.exitInitializationMode()
            reached, times = 0.0, np.union1d(checks, times)
            for time in times[1:]:
                one.doStep(reached, time - reached)
                reached = time
                if time in checks:
                    at = np.searchsorted(checks, time)
                    assert np.abs(get(one, *OFFSETS) - package[at]).max() < 1e-6 * C


def test_early_return(feeder):
    """Co-simulation stops at the first touch, to 1e-9 s, where the importer takes events."""
    scene, path = feeder("dry")
    package = cl.simulate(scene, turns=0.05, rtol=1e-11).events
    with opened(path, FMU3Slave, eventModeUsed=True, earlyReturnAllowed=True) as one:
        one.exitInitializationMode()
        one.enterStepMode()
        event, _, early, time = one.doStep(0.0, scene.turn)
        assert event
        assert early
        assert time == pytest.approx(package["time"][0], abs=1e-9)
        assert get(one, "joints.B.impact_speed")[0] == pytest.approx(
            package["impact_speed"][0], abs=1e-6
        )
        one.enterEventMode()
        one.updateDiscreteStates()
        one.enterStepMode()
        event, _, early, later = one.doStep(time, 1e-3)
        assert later > time


CLEARANCE, VISCOSITY = 1.7e-4, 0.011


@pytest.mark.parametrize("model", ["mixed", "dry"])
def test_numbers(feeder, model):
    """A number set in the unit: the same bits of rates, outputs and nominals as a scene made with
    it, at random states. Indicators differ by dead bands, some 1e-17 m.
    """
    _, path = feeder(model)
    other, there = feeder(model, clearance=CLEARANCE)
    exported = Model(other)
    with opened(path) as one, opened(there) as two:
        put(one, joints__B__clearance=CLEARANCE)
        names = [n for n in one.places if n != "time" and not n.endswith(".indicator")]
        for instance in (one, two):
            instance.exitInitializationMode()
            instance.enterContinuousTimeMode()
        for time, states in random_places(exported, 100):
            np.testing.assert_array_equal(rates(one, time, states), rates(two, time, states))
            np.testing.assert_array_equal(get(one, *names), get(two, *names))


def test_viscosity(feeder):
    """The film's viscosity set in the unit: the same bits as a scene made with it."""
    _, path = feeder("lubricated")
    other, there = feeder("lubricated", viscosity=VISCOSITY)
    with opened(path) as one, opened(there) as two:
        put(one, joints__B__lubricant__viscosity=VISCOSITY)
        for instance in (one, two):
            instance.exitInitializationMode()
            instance.enterContinuousTimeMode()
        for time, states in random_places(Model(other), 100):
            np.testing.assert_array_equal(rates(one, time, states), rates(two, time, states))


@pytest.mark.parametrize("model", ["mixed", "lubricated"])
def test_directional_derivatives(feeder, model):
    """Along random directions at 100 random states: central differences, 1e-6 of the largest.

    Adjoint ones are their transpose, to rounding.
    """
    scene, path = feeder(model)
    exported, rng = Model(scene), np.random.default_rng(5)
    count = exported.layout.length + 1
    sizes = np.concatenate([exported.mechanism.scale, [1.0] * 10])[:count]
    with opened(path) as one:
        one.exitInitializationMode()
        one.enterContinuousTimeMode()
        states_at, rates_at = list(range(1, 1 + count)), list(range(1 + count, 1 + 2 * count))
        for time, states in random_places(exported, 100):
            seed, h = sizes * rng.uniform(-1.0, 1.0, count), 1e-6
            steps = [rates(one, time, states + k * h * seed) for k in (-2, -1, 1, 2)]
            wanted = (8 * (steps[2] - steps[1]) - (steps[3] - steps[0])) / (12 * h)
            rates(one, time, states)
            slopes = np.array(one.getDirectionalDerivative(rates_at, states_at, seed.tolist()))
            np.testing.assert_allclose(slopes, wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())
            back = rng.uniform(-1.0, 1.0, count)
            adjoint = np.array(one.getAdjointDerivative(rates_at, states_at, back.tolist()))
            assert adjoint @ seed == pytest.approx(back @ slopes, rel=1e-9)


@pytest.mark.parametrize("scene", few_of(SEVERAL, 1), ids=str)
def test_several_contacts(scene, tmp_path, monkeypatch):
    """A unit beside the run: within 1e-4 of the natural sizes where contacts meet at several spots,
    by what impacts and sharp friction make of a tolerance of 1e-8 (3e-5 is usual).
    """
    monkeypatch.setattr(unit, "has_zig", lambda: False)
    case, values, until = scene
    model = Model(cl.load_case(case, **values))
    assert len(model.layout.spots) > 1
    unit.write_unit(model, tmp_path / "unit.fmu")
    for difference in checked(model, tmp_path / "unit.fmu", until):
        assert difference.share < 1e-4, difference


def test_saved_state(feeder):
    """1000 steps, the state back, 1000 steps: the same bits; also from its bytes, elsewhere."""
    _, path = feeder("mixed")

    def thousand(one):
        for k in range(1000):
            one.doStep(0.01 + 1e-5 * k, 1e-5)
        return get(one, *OFFSETS, "joints.B.force_x", "energy.residual")

    with opened(path, FMU3Slave) as one, opened(path, FMU3Slave) as two:
        one.exitInitializationMode()
        two.exitInitializationMode()
        one.doStep(0.0, 0.01)
        state = one.getFMUState()
        content = one.serializeFMUState(state)
        first = thousand(one)
        one.setFMUState(state)
        np.testing.assert_array_equal(thousand(one), first)
        two.setFMUState(two.deserializeFMUState(content))
        np.testing.assert_array_equal(thousand(two), first)


def test_two_instances(feeder):
    """Instances side by side do what each does alone: nothing is shared."""
    scene, path = feeder("lubricated")

    def run(instances):
        for k, one in enumerate(instances):
            put(one, drives__crank__speed=20.0 + 5.0 * k)
            one.exitInitializationMode()
        for step in range(20):
            for one in instances:
                one.doStep(1e-3 * step, 1e-3)
        return [get(one, *OFFSETS) for one in instances]

    with opened(path, FMU3Slave) as one, opened(path, FMU3Slave) as two:
        (first, second) = run([one, two])
    with opened(path, FMU3Slave) as one:
        np.testing.assert_array_equal(run([one])[0], first)
    assert np.abs(second - first).max() > 1e-3 * C


def test_speed_as_input(feeder):
    """A crank whose speed changes at a communication point goes on from its angle."""
    scene, path = feeder("lubricated")
    with opened(path, FMU3Slave) as one:
        one.exitInitializationMode()
        one.doStep(0.0, 0.01)
        angle = get(one, "drives.crank.driven", "bodies.crank.theta")
        np.testing.assert_allclose(angle, scene.drives[0].speed * 0.01, rtol=1e-12)
        put(one, drives__crank__speed=10.0)
        one.doStep(0.01, 0.01)
        there = get(one, "drives.crank.driven", "bodies.crank.theta")
        np.testing.assert_allclose(there, angle + 0.1, rtol=1e-12)


def test_same_bytes(tmp_path, monkeypatch):
    """A scene gives the same archive each time; another clearance gives another token."""
    monkeypatch.setattr(unit, "has_zig", lambda: False)
    archives = []
    for k, clearance in enumerate((1e-4, 1e-4, 2e-4)):
        scene = cl.load_case("slider_crank", model="dry", clearance=clearance)
        archives.append(cl.export(scene, fmu=tmp_path / f"{k}.fmu").fmu.read_bytes())
    assert archives[0] == archives[1] != archives[2]


def test_without_compiler(tmp_path, monkeypatch, capsys):
    """The unit has its sources alone, and the command states that."""
    from clearance.cli import main

    monkeypatch.setattr(unit, "has_zig", lambda: False)
    monkeypatch.setattr(unit.shutil, "which", lambda name: None)
    path = tmp_path / "one.fmu"
    assert main(["export", "double_pendulum", "--fmu", str(path)]) == 0
    assert "no binaries: there is no compiler here" in capsys.readouterr().out
    assert validate_fmu(str(path)) == []


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"model": "lubricated", "film": "fem"}, "the film of joint B is solved during the run"),
        (
            {"model": "dry", "contact": "winkler", "wear": 1e-13},
            "wear changes the outlines of joint B",
        ),
    ],
)
def test_refusals(values, reason, capsys):
    """Scenes that cannot be exported are refused by name, and `explain` has the reason."""
    from clearance.cli import main

    scene = cl.load_case("six_bar_feeder", **values)
    with pytest.raises(ValueError, match=reason):
        cl.export(scene, c="nowhere")
    parameters = [word for n, v in values.items() for word in ("-p", f"{n}={v}")]
    assert main(["explain", "six_bar_feeder", *parameters]) == 0
    assert f"export     impossible: {reason}" in capsys.readouterr().out
