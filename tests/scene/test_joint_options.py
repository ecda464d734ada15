"""Options of clearance joints, shared by cases as a dataclass."""

import pytest

import clearance as cl
from clearance.identify.free import bounded
from clearance.scene.catalogue import find_case
from clearance.scene.joint_options import MODELS, idle

CASE = '''
import clearance as cl

def scene(
    *, arm: float = 0.1, options: cl.JointOptions = cl.JointOptions(joints="P", model="dry"){more}
) -> cl.Scene:
    """A pendulum with clearance.

    arm: length of the pendulum [m]
    clearance: of its only hinge [m]
    """
    body = cl.Body("arm", 1.0, 1e-3, points={{"pin": (-arm, 0.0)}}, angle=-1.0)
    return cl.Scene(options.factory("P", radius=8e-3, length=16e-3)("P", cl.ground, body["pin"]))
'''


def write(folder, more=""):
    path = folder / "pendulum.py"
    path.write_text(CASE.format(more=more))
    return path


def test_options_are_parameters_of_the_case(tmp_path):
    """Each field is a parameter, with the text of the case where that has one."""
    case = find_case(write(tmp_path))
    parameters = case.parameters
    assert list(parameters)[:4] == ["arm", "joints", "model", "clearance"]
    assert (parameters["model"].default, parameters["model"].units) == ("dry", "-")
    assert parameters["clearance"].text == "of its only hinge"
    assert parameters["viscosity"].value("40 cP") == pytest.approx(0.04, rel=1e-15)
    assert all(p.units != "?" and p.text for p in parameters.values())
    (joint,) = case.scene(clearance=2e-4, friction="coulomb", restitution=0.5).joints
    assert (joint.clearance, joint.friction.law.name) == (2e-4, "coulomb")
    assert joint.contact.parameters["restitution"] == 0.5
    assert isinstance(case.scene(model="ideal").joints[0], cl.Revolute)


def test_a_parameter_stands_once(tmp_path):
    """A parameter that two sources give is refused."""
    with pytest.raises(ValueError, match="both give the parameter 'film'"):
        find_case(write(tmp_path, ', film: str = "table"'))


def test_cases_share_texts_and_units():
    """Cases with the options differ in defaults and in the texts that they give themselves."""
    one, other = (find_case(n).parameters for n in ("four_bar", "slider_crank"))
    assert (one["film"].text, one["film"].units) == (other["film"].text, other["film"].units)
    assert one["joints"].text != other["joints"].text


def test_auto_contact_of_worn_joints_is_conformal():
    """Worn joints have a layer, others the usual contact."""
    assert cl.JointOptions(joints="P", model="dry").factory("P", radius=1e-2, length=1e-2).hinge[
        "contact"
    ].law.name == ("lankarani_nikravesh")
    worn = cl.JointOptions(joints="P", model="dry", wear=1e-14)
    assert worn.factory("P", radius=1e-2, length=1e-2).hinge["contact"].law.name == "winkler"


#: of each option of joints, a value beside its default
CHANGED = {
    "joints": "A",
    "clearance": 2e-4,
    "viscosity": 0.2,
    "oil": "ISO-VG-46@60C",
    "restitution": 0.5,
    "contact": "hertz",
    "friction": "stribeck",
    "friction_coefficient": 0.3,
    "film": "short",
    "film_torques": False,
    "drag": "wet",
    "ambient": 1e5,
    "flow_factors": True,
    "mesh": "16x2",
    "roughness": 1e-6,
    "transition": "flores",
    "thresholds": "0.5,1,2",
    "memberships": "none.csv",
    "asperity": "greenwood_williamson",
    "elastic": "true",
    "wear": 1e-15,
    "wear_journal": 1e-15,
    "worn_depth": 1e-5,
    "worn_angle": 0.5,
}


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    ("name", "joints"),
    [
        ("six_bar_feeder", "B"),
        ("slider_crank", "C,guide"),
        ("slider_crank", "guide"),
        ("four_bar", "A,C"),
    ],
)
def test_idle_options_change_nothing(name, joints, model):
    """A scene with another value of an option that does nothing is the same scene."""
    case = find_case(name)
    defaults = {n: p.default for n, p in case.parameters.items()}
    for more in ({}, {"friction": "none"}, {"oil": "ISO-VG-32@50C"}):
        values = {"model": model, "joints": joints, **more}
        scene = case.scene(**values)
        without = idle(scene)
        assert ("film" in without) == (model in ("ideal", "dry"))
        assert ("restitution" in without) == (model == "ideal" or "contact" in without)
        for option, reason in without.items():
            option_of, _, value = reason.partition(" = ")
            assert (defaults | values)[option_of] == value
            changed = case.scene(**values | {option: CHANGED[option]})
            assert changed.to_json() == scene.to_json(), option


def test_run_names_options_that_do_nothing(tmp_path, typed):
    """Those that were given stand in a line; defaults that do nothing are left out."""
    words = ["-p", "model=dry", "-p", "film=short", "--turns", "0.02", "--no-error"]
    printed = typed("run", "four_bar", *words, "-o", tmp_path / "run.h5").out
    assert "given        model = dry, film = short\n  no effect    film (model = dry)\n" in printed
    assert "restitution 0.9" in printed
    assert "viscosity" not in printed


def test_sweeps_name_parameters_without_effect(tmp_path, typed):
    """Those that do nothing at any point stand in the log; one point where they do is enough."""
    length = ["--turns", "0.01", "--channels", "none", "--workers", "1"]
    for model, named in (("dry", True), ("ideal", True), ("dry,lubricated", False)):
        folder = tmp_path / model
        words = ["-p", f"model={model}", "-p", "film=short", "-p", "viscosity=0.1,0.2"]
        printed = typed("sweep", "four_bar", *words, *length, "-o", folder)
        for name in ("viscosity", "film"):
            words = f"{name} has no effect (model = {model})"
            assert (words in printed.err) == named
            assert (words in (folder / "sweep.log").read_text()) == named


def test_what_does_nothing_is_neither_fitted_nor_differentiated(typed):
    """The reason is stated before anything runs."""
    reason = "viscosity has no effect (model = dry)"
    words = ["six_bar_feeder", "-p", "model=dry"]
    bounds = ["-p", "viscosity=0.01:0.1"]
    optimum = ["--minimize", "drives/crank/torque_max"]
    assert reason in typed.line("optimize", *words, *bounds, *optimum)
    assert reason in typed.line("run", *words, "--sensitivity", "viscosity")
    machine = cl.load_case("slider_crank", model="dry", friction="none")
    with pytest.raises(ValueError, match=r"friction_coefficient has no effect \(friction = none\)"):
        bounded(machine, "friction_coefficient", (0.05, 0.2))
