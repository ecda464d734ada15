"""The interface for users: public names, laws that take what their joint has, messages that name
what there is.
"""

import inspect
import json
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import clearance as cl
from clearance import cli, laws
from clearance.commands import common
from clearance.laws.law import Family, FilmJoint, Law
from clearance.run import progress_bar
from clearance.run.options import span_of
from clearance.scene.catalogue import find_case
from clearance.scene.joint_options import CONTACTS
from clearance.sweeping.points import from_words
from tests.pages import block
from tests.typed import python

SCENE = """
from clearance.values.units import mm


def journal(name, **slots):
    rotor = cl.Body(name, 20.0, 1e-2)
    return cl.ClearanceRevolute(
        cl.ground, rotor, name=name, radius=mm(10), clearance=mm(0.1), length=mm(20),
        contact=cl.hertz(),
        lubricant=cl.Lubricant(0.001), roughness=1e-6, eccentricity=(0.0, -mm(0.05)), **slots
    ), cl.Drive(rotor, speed=100.0, name=name)


def scene(*, share: float = 0.5) -> cl.Scene:
    \"\"\"Two journals of their own, each in its bearing.

    share: share of the film [-]
    \"\"\"
    own = journal("P", **laws | {"film": full_short(share=share)})
    tabled = journal("Q", film=full_short(share=share), transition=transition)
    return cl.Scene(*own, *tabled, name="journals")
"""


# --- public names
@pytest.mark.parametrize("package", [cl, laws], ids=["clearance", "laws"])
def test_U2_every_public_name_is_what_it_stands_for(package):
    """No decorator, law or function is hidden by the module of its name; `cl.film` is both, on
    purpose.
    """
    for name in package.__all__:
        value = getattr(package, name)
        assert inspect.getdoc(value), name
        if inspect.ismodule(value):
            assert package is cl
            assert name in ("elements", "film", "films", "laws")
    assert {f.name for f in laws.FAMILIES} == {
        n for n in laws.__all__ if isinstance(getattr(laws, n), Family)
    }
    assert all(isinstance(f, Family) for f in laws.FAMILIES)


@pytest.mark.parametrize("family", laws.FAMILIES, ids=lambda f: f.name)
def test_U2_every_family_decorates(family):
    """As `cl.<family>` and as `clearance.laws.<family>`, plainly and with checks."""
    scope: dict = {}
    arguments = ", ".join([*family.state, "strength"])
    value = "strength * max(penetration, 0.0)" if family.name == "contact" else "strength"
    exec(f"def mine({arguments}):\n    return {', '.join([value] * family.outputs)}", scope)
    for decorator in (getattr(cl, family.name), getattr(laws, family.name)):
        for law in (
            decorator(scope["mine"]),
            decorator(strength=lambda field, value: float(value))(scope["mine"]),
        ):
            assert isinstance(law, Law)
            assert law.family is family
            assert law(strength=2).values == {"strength": 2.0}


def test_A2_the_subpackage_film_is_imported_by_its_name():
    """In a fresh process, in each of the usual ways."""
    code = "import clearance.film.table as t, clearance; assert clearance.film.table is t; t.Key"
    python("-c", code)


# --- laws that take what their joint has
def pin(contact, **more):
    return cl.ClearanceRevolute(
        cl.ground,
        cl.Body("pin", 1.0, 1e-3),
        name="J",
        radius=0.01,
        clearance=1e-4,
        contact=contact,
        **more,
    )


@pytest.mark.parametrize("name", CONTACTS)
def test_contacts_take_what_the_joint_determines(name):
    """Stiffness, moduli and lengths left out are those of the joint: the force is that of the law
    with all given.
    """
    law = getattr(laws, name)
    free = {"restitution": 0.9, "dissipation": 0.1, "damping": 5.0}
    values = {n: free[n] for n in free if n in law.inputs}
    if name == "kelvin_voigt":  # its stiffness [N/m] follows from no joint
        with pytest.raises(TypeError, match="missing stiffness"):
            law(**values)
        return
    actual = pin(law(**values), length=0.02).contact
    assert None not in actual.numbers
    reference = {
        "stiffness": cl.hertz_stiffness(0.01, 1e-4),
        "modulus": cl.contact_modulus(cl.steel, cl.steel),
        "layer_modulus": cl.layer_modulus(cl.steel, 0.005),
        "length": 0.02,
        "radius": 0.01,
        "radius_difference": 1e-4,
    }
    entire = law(**values, **{n: v for n, v in reference.items() if n in law.inputs})
    assert actual == entire
    assert actual(1e-6, 0.01, 0.1) == entire(1e-6, 0.01, 0.1) > 0.0


def test_what_is_given_stays():
    """Only what was left out comes from the joint; another material gives another stiffness."""
    assert pin(cl.hertz(stiffness=7.0)).contact.values["stiffness"] == 7.0
    bronze = cl.Material("bronze", young=110e9, poisson=0.34, density=8800.0)
    actual = pin(cl.hertz(), material=bronze).contact.values["stiffness"]
    assert (
        actual
        == cl.hertz_stiffness(0.01, 1e-4, bronze)
        < cl.hertz_stiffness(0.01, 1e-4, bronze, cl.steel)
    )


def test_asperities_take_their_modulus_from_the_joint():
    """The contact modulus of two steels is filled in."""
    joint = pin(
        cl.hertz,
        length=0.02,
        roughness=1e-6,
        film=cl.pinkus_sternlicht,
        lubricant=cl.Lubricant(0.01),
        transition=cl.load_sharing,
        asperity=cl.greenwood_tripp,
    )
    assert joint.asperity.values["modulus"] == cl.contact_modulus(cl.steel, cl.steel)


def test_what_no_joint_can_determine_is_named():
    """A number that a law still lacks is named with the joint."""
    with pytest.raises(ValueError, match="joint J: contact johnson: length is missing"):
        pin(cl.johnson(restitution=0.9))
    with pytest.raises(ValueError, match="joint J: contact hertz: .* exponent 1.5, not 2"):
        pin(cl.hertz(exponent=2.0))
    with pytest.raises(ValueError, match="hertz: give stiffness; without a joint"):
        cl.hertz()(1e-6, 0.0, 0.1)


# --- arguments, cases, units that do not exist
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda b: cl.TorsionSpring(cl.ground, b, angle=1.0),
            "'angle' .did you mean free_angle.*stiffness, damping",
        ),
        (
            lambda b: cl.Body("b", mass=1.0, inertia=1.0, centre=(0, 0)),
            "Body has no argument 'centre'.*com, products",
        ),
        (lambda b: cl.Revolute(cl.ground, b, frictoin=None), "Revolute .*did you mean friction"),
        (lambda b: cl.ClearanceRevolute(cl.ground, b, clearence=1.0), "did you mean clearance"),
        (lambda b: cl.Drive(b, sped=1.0), "did you mean speed"),
        (lambda b: cl.Drive(b, start_speed=1.0), "did you mean speed_start"),
        (lambda b: cl.Scene(gravty=(0, 0)), "did you mean gravity"),
        (lambda b: cl.Lubricant(viscosty=1.0), "did you mean viscosity"),
        (lambda b: cl.Bearing(radios=1.0), "did you mean radius"),
        (lambda b: cl.lankarani_nikravesh(restitutoin=0.9), "did you mean restitution"),
    ],
)
def test_unknown_arguments_are_answered_with_the_known_ones(make, message):
    """A wrong argument is answered with the right ones."""
    with pytest.raises(TypeError, match=message):
        make(cl.Body("body", 1.0, 1e-3))


def test_signatures_stay():
    """`help` shows the arguments of scene parts as before."""
    assert list(inspect.signature(cl.TorsionSpring).parameters)[:3] == ["a", "b", "stiffness"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("run six_bar_feedr", "did you mean six_bar_feeder"),
        ("run slider_crank -p clearence=1mm", "did you mean clearance"),
        ("run slider_crank -p speed=300RPM", "did you mean rpm"),
        ("run six_bar_feeder -p film=tabel", "did you mean table"),
        ("figures feeder_spede", "did you mean feeder_speed"),
    ],
)
def test_misspelt_names_are_answered_with_the_closest(
    arguments, message, typed, tmp_path, monkeypatch
):
    """A misspelt name is answered with the closest one."""
    monkeypatch.chdir(tmp_path)
    assert message in typed.line(arguments)


def test_cases_lists_those_that_are_named(tmp_path, typed):
    """By name and by path to a file of one's own."""
    mine = tmp_path / "liner.py"
    mine.write_text(block("def scene("))
    printed = typed("cases", mine, "four_bar --json").document
    assert list(printed) == ["liner", "four_bar"]
    assert printed["liner"]["parameters"]["clearance"]["units"] == "m"
    typed("cases four_barr", status=2)


def test_figures_are_drawn_in_the_order_asked_for():
    """Patterns choose figures in their order, each once."""
    from clearance.paper_figures.workshop import chosen

    reference = ["a_map", "a_run", "b"]
    assert chosen(["b", "a_*"], reference) == ["b", "a_map", "a_run"]
    assert chosen(["a_run", "a_*"], reference) == ["a_run", "a_map"]
    assert chosen([], reference) == reference


def test_S18_run_says_its_parameters_with_units(typed, tmp_path):
    """Those given first, in SI and in units people think in."""
    arguments = "run slider_crank -p model=dry -p speed=300 --turns 0.1 --no-error"
    printed = " ".join(typed(arguments, "-o", tmp_path / "run.h5").out.split())
    assert "given speed = 300 rad/s (2865 rpm), model = dry" in printed
    assert "clearance 0.0005 m (0.5 mm)" in printed
    assert "roughness 8e-07 m (0.8 um)" in printed


def test_S15_a_log_gets_a_line_now_and_then(capsys, monkeypatch):
    """stderr is no terminal here: nothing at once, a line when the interval has passed, nothing
    under --json.
    """
    line = common.progress_of(SimpleNamespace(command="wear", json=False))
    line("one")
    assert capsys.readouterr().err == ""
    line("two", always=True)
    monkeypatch.setattr(progress_bar, "INTERVAL", 0.0)
    line(0.25, "three")
    for silent in ({"json": True}, {"json": False, "quiet": True}):
        common.progress_of(SimpleNamespace(command="wear", **silent))("four")
    lines = r"clearance: wear: \d+ s, two\nclearance: wear: \d+ s, 25% done three\n"
    assert re.fullmatch(lines, capsys.readouterr().err)


@pytest.mark.usefixtures("undrawn")
def test_S11_pictures_and_reports_from_python(tmp_path, monkeypatch):
    """The guide's lines, of a run still open; a path and names as a list do as well."""
    monkeypatch.chdir(tmp_path)
    scope: dict = {}
    exec(block("run.plot."), scope)
    assert {"history.png", "moving.html", "run.html"} <= {p.name for p in tmp_path.iterdir()}
    path = scope["run"].save("run.h5")
    assert cl.plot(path, "phase", "phase.png", channels=["slider.x", "slider.vx"]).exists()
    with pytest.raises(ValueError, match="no kind 'orbits' .did you mean orbit"):
        cl.plot(path, "orbits", "x.png")
    with pytest.raises(TypeError, match="no option 'chanels' .did you mean channels"):
        cl.plot(path, "phase", "x.png", chanels="slider.x")
    with pytest.raises(ValueError, match="--joint does not belong to phase"):
        cl.plot(path, "phase", "x.png", joint="C")


@pytest.fixture(scope="module")
def periodic(tmp_path_factory):
    """Six turns of a mechanism without clearance, by the command."""
    path = tmp_path_factory.mktemp("periodic") / "run.h5"
    assert (
        cli.main(["run", "slider_crank", "-p", "model=ideal", "--turns", "6", "-o", str(path)]) == 0
    )
    return path


@pytest.mark.usefixtures("undrawn")
def test_a_report_says_case_command_and_defaults(periodic):
    """The source of a run is in its file and in its report; no column of a table is empty."""
    with cl.open_result(periodic) as run:
        assert run.attributes["case_file"] == "slider_crank"
        assert run.attributes["command"].startswith(
            "clearance run slider_crank -p model=ideal --turns 6"
        )
        assert json.loads(run.attributes["defaults"])["restitution"] == 0.9
        text = cl.report(run, periodic.with_suffix(".html")).read_text()
    assert "clearance run slider_crank -p model=ideal" in text
    assert "restitution = 0.9" in text
    assert not re.search(r"<th[^>]*></th></tr></thead>", text)


def test_a_fixed_point_is_drawn_as_one(periodic, monkeypatch):
    """The axes of a section are wider than rounding: 10 % of what the channel does in the run
    (exact: as drawn).
    """
    from clearance.postprocess import figures

    stored = []
    monkeypatch.setattr(figures, "save", lambda figure, path: stored.append(figure))
    cl.plot(periodic, "poincare", "section.png")
    (axes,) = stored[0].axes
    with cl.open_result(periodic) as run:
        for limits, channel in (
            (axes.get_xlim(), run["slider"].vx),
            (axes.get_ylim(), run["slider"].ax),
        ):
            assert np.ptp(limits) == pytest.approx(0.1 * np.abs(channel).max(), rel=1e-9)


# --- laws of one's own, through everything that reads a run
@pytest.fixture(scope="module")
def journals(tmp_path_factory):
    """The guide's laws in a case file, run with its picture: the folder."""
    folder = tmp_path_factory.mktemp("journals")
    blocks = [block(mark) for mark in ("@cl.transition", "cl.fuzzy_table(")]
    (folder / "journals.py").write_text("\n".join([*blocks, SCENE]))
    command = [
        "run",
        str(folder / "journals.py"),
        "--turns",
        "3",
        "-o",
        str(folder / "run.h5"),
        "--plot",
    ]
    assert cli.main(command) == 0
    return folder


@pytest.mark.parametrize("joint", ["P", "Q"])
def test_U3_own_laws_run(journals, joint):
    """Films, frictions, asperities and transitions of one's own, and memberships from points, are
    in the file.
    """
    with cl.open_result(journals / "run.h5") as run:
        actual = run.joint(joint)
        shares = np.array(
            [getattr(actual, f"membership_{s}") for s in ("full_film", "mixed", "dry")]
        )
        np.testing.assert_allclose(shares.sum(axis=0), 1.0, atol=1e-12)
        assert shares[0].min() < 0.9
        assert run.solver["energy_residual_share"] < 1e-5
    assert (journals / "run.png").stat().st_size > 0


def test_U3_own_friction_and_asperity_act(journals):
    """Element by element as the laws state (1e-9: rounding)."""
    with cl.open_result(journals / "run.h5") as run:
        actual, ratio = run.joint("P"), run.joint("P").film_thickness_ratio
        np.testing.assert_allclose(
            actual.asperity_force, 1e6 * 0.01 * 0.02 * np.exp(-ratio), rtol=1e-9
        )
        assert np.abs(actual.friction).max() > 0.0


def test_U3_points_act_as_their_law(journals):
    """The memberships in the file are those of the points at the film thickness ratio there (1e-9:
    rounding).
    """
    scope: dict = {}
    exec(block("cl.fuzzy_table("), scope)
    with cl.open_result(journals / "run.h5") as run:
        actual = run.joint("Q")
        joint = JOINT._replace(viscosity=0.001)
        expected = scope["transition"](actual.film_thickness_ratio * joint.roughness, joint)
        np.testing.assert_allclose(actual.membership_full_film, expected[5], atol=1e-9)
        np.testing.assert_allclose(actual.membership_dry, expected[7], atol=1e-9)


@pytest.mark.parametrize("picture", ["orbit", "history", "phase", "overview", "contacts"])
def test_U3_own_laws_are_drawn(journals, picture):
    """Pictures of joints with laws of one's own."""
    more = {"history": ["--channels", "P.force"], "phase": ["--channels", "P.gap,Q.gap"]}.get(
        picture, []
    )
    path = journals / f"{picture}.png"
    assert cli.main(["plot", str(journals / "run.h5"), picture, *more, "-o", str(path)]) == 0
    assert path.exists()


@pytest.mark.usefixtures("undrawn")
def test_U3_own_laws_are_reported(journals):
    """The report names a law of one's own."""
    path = journals / "run.html"
    assert cli.main(["report", str(journals / "run.h5"), "-o", str(path)]) == 0
    assert "two_states" in path.read_text()


def test_U3_own_laws_are_swept(journals):
    """A case with laws of one's own is swept."""
    arguments = [
        "--turns",
        "2",
        "--settle",
        "1",
        "--workers",
        "1",
        "--quiet",
        "-o",
        str(journals / "sweep"),
    ]
    case = str(journals / "journals.py")
    assert cli.main(["sweep", case, "-p", "share=0.4,0.5", *arguments]) == 0
    assert cl.open_sweep(journals / "sweep").done.all()


def test_U3_an_own_transition_without_roughness_is_drawn(tmp_path):
    """The states have no film thickness ratio to be drawn over: the orbit is drawn alone."""
    joint = pin(
        cl.hertz,
        length=0.02,
        film=cl.pinkus_sternlicht,
        lubricant=cl.Lubricant(0.01),
        transition=cl.superposed,
    )
    result = cl.simulate(cl.Scene(joint, name="smooth"), until=0.01)
    from clearance.postprocess.plots import overview

    assert overview(result, tmp_path / "run.png").exists()


# --- memberships from points
RATIOS = np.linspace(-1.0, 5.0, 1201)
JOINT = FilmJoint(0.01, 1e-4, 0.02, 0.01, 1e-6)


def memberships_of(law):
    return np.array(law(RATIOS * JOINT.roughness, JOINT)[5:])


def test_points_of_the_default_are_the_default():
    """Three points make cubics where `fuzzy` has half cosines: within 0.011 everywhere."""
    points = [(0.4, 0.0, 0.0, 1.0), (1.0, 0.0, 1.0, 0.0), (3.0, 1.0, 0.0, 0.0)]
    assert np.abs(memberships_of(cl.fuzzy_table(points)) - memberships_of(cl.fuzzy())).max() < 0.011


def test_memberships_from_points_are_memberships():
    """Through the points; in [0, 1], sum 1 (rounding); continuous slopes (steps of 0.005: jumps
    below 5 %).
    """
    random = np.random.default_rng(1)
    for _ in range(50):
        count = random.integers(2, 9)
        ratios = np.sort(random.uniform(0.0, 4.0, count) + 0.3 * np.arange(count))
        shares = random.dirichlet((0.5, 0.5, 0.5), count)
        shares[-1] = 1.0, 0.0, 0.0
        law = cl.fuzzy_table(np.column_stack([ratios, shares]))
        actual = memberships_of(law)
        assert actual.min() > -1e-12
        np.testing.assert_allclose(actual.sum(axis=0), 1.0, atol=1e-12)
        at_points = np.array(law(ratios * JOINT.roughness, JOINT)[5:])
        np.testing.assert_allclose(at_points.T, shares, atol=1e-9)
        slope = np.diff(actual, axis=1) / np.diff(RATIOS)
        assert (
            np.abs(np.diff(slope, axis=1)).max()
            < 0.05 * (1.0 + np.abs(slope).max()) * 3.0 / np.diff(ratios).min()
        )


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([(1.0, 1.0, 0.0, 0.0)], "at least two points"),
        ([(1.0, 0.0, 1.0), (2.0, 1.0, 0.0, 0.0)], "point 0 must be .film thickness ratio"),
        (
            [(1.0, 0.0, 0.5, 0.4), (2.0, 1.0, 0.0, 0.0)],
            "point 0: the memberships must have the sum 1",
        ),
        ([(2.0, 0.0, 0.0, 1.0), (1.0, 1.0, 0.0, 0.0)], "must grow, got 1 after 2"),
        ([(1.0, 0.0, 0.0, 1.0), (2.0, 0.0, 1.0, 0.0)], "last point must be all full film"),
        ([(1.0, 0.0, -0.5, 1.5), (2.0, 1.0, 0.0, 0.0)], "point 0: mixed must lie in"),
    ],
)
def test_points_that_are_no_table_are_refused(points, message):
    """Points that make no memberships are refused."""
    with pytest.raises(ValueError, match=message):
        cl.fuzzy_table(points)


# --- memberships from a file
POINTS = [(0.4, 0.0, 0.0, 1.0), (0.8, 0.0, 0.7, 0.3), (1.2, 0.1, 0.9, 0.0), (3.0, 1.0, 0.0, 0.0)]
ROWS = "\n".join(",".join(map(str, row)) for row in POINTS)


@pytest.mark.parametrize(
    "text",
    [
        ROWS,
        f"# of a paper\nratio,full,mixed,dry\n{ROWS}\n",
        ROWS.replace(",", "; "),
        ROWS.replace(",", "\t"),
    ],
)
def test_memberships_of_a_file(text, tmp_path):
    """The case takes the file's points: the same law as `fuzzy_table` makes of them."""
    path = tmp_path / "memberships.csv"
    path.write_text(text)
    options = {"transition": "fuzzy(squeeze=0.5)", "memberships": str(path)}
    joint = journal_B(model="mixed", **options)
    assert joint.transition == cl.fuzzy_table(POINTS, squeeze=0.5)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (None, "memberships must be cosine or a CSV file: .*No such file"),
        ("1,0,1\n", "line 1 needs four numbers: .*got '1,0,1'"),
        ("O.2,0,0,1\n" + ROWS, "line 1 needs four numbers: .*got 'O.2,0,0,1'"),
        (ROWS + "\n4,1,0,zero", "line 5 needs four numbers: .*got '4,1,0,zero'"),
        ("ratio,full,mixed,dry\n", "give at least two points, got 0"),
        ("", "memberships: .*memberships.csv: give at least two points, got 0"),
        ("0.4,0,0,1\n1,0,0.9,0\n", "point 1: the memberships must have the sum 1"),
    ],
)
def test_files_that_hold_no_memberships_are_refused(text, line, tmp_path):
    """A file without memberships is refused with its line."""
    path = tmp_path / "memberships.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ValueError, match=line):
        cl.load_case("six_bar_feeder", model="mixed", memberships=str(path))


def test_only_the_fuzzy_transition_takes_memberships():
    """Other transitions refuse a table."""
    with pytest.raises(ValueError, match="load_sharing has no memberships; fuzzy has"):
        cl.load_case(
            "six_bar_feeder", model="mixed", transition="load_sharing", memberships="a.csv"
        )


# --- laws with their parameters, as words
def journal_B(**parameters):
    scene = cl.load_case("six_bar_feeder", **parameters)
    return next(j for j in scene.joints if j.name == "B")


def test_laws_with_parameters_as_words():
    """Parameters in a word are those of the law; all others are those of the plain name."""
    plain = journal_B(model="dry", contact="impact").contact.parameters
    actual = journal_B(model="dry", contact="impact(damping=440, depth=1.5e-6)").contact.parameters
    assert actual == plain | {"damping": 440.0, "depth": 1.5e-6}
    joint = journal_B(
        model="mixed",
        transition="fuzzy(squeeze=0,datum=3)",
        friction="coulomb(transition_speed=0.01)",
    )
    assert joint.transition == cl.fuzzy(squeeze=0.0, datum=3.0)
    assert joint.friction == cl.coulomb(coefficient=0.1, transition_speed=0.01)
    points = journal_B(model="mixed", film="harmonic", transition="load_sharing(full=4)").transition
    assert points == cl.load_sharing(full=4.0)


@pytest.mark.parametrize(
    ("option", "line"),
    [
        ({"contact": "impact(damping)"}, r"contact must be a name or impact\(parameter=number"),
        ({"contact": "impact(dampin=1)"}, r"joint B: impact\(stiffness, .*unknown .*damping"),
        ({"contact": "impact(depth=-1)"}, "joint B: impact: depth must be positive"),
        ({"contact": "hertzz(stiffness=1)"}, "contact must be one of .*got 'hertzz'"),
        (
            {"contact": "impact(damping=1"},
            r"contact: a closing bracket is missing in .*; write impact\(damping=1\)",
        ),
        (
            {"contact": "impact(depth=1,depth=2)"},
            r"contact: depth is given twice in 'impact\(depth=1,depth=2\)'",
        ),
        ({"contact": "auto(x=1)"}, r"contact auto takes no parameters, got 'auto\(x=1\)'"),
        ({"friction": "none(x=1)"}, r"friction none takes no parameters, got 'none\(x=1\)'"),
        ({"asperity": "none(x=3)"}, r"asperity none takes no parameters, got 'none\(x=3\)'"),
    ],
)
def test_words_that_are_no_law_are_refused(option, line):
    """A word that names no law is refused."""
    with pytest.raises(ValueError, match=line):
        cl.load_case("six_bar_feeder", model="dry", **option)


MIXED_FILE = "memberships=.*points.csv"


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (
            {"asperity": "greenwood_tripp(foo=1)"},
            r"asperity=greenwood_tripp\(foo=1\): transition fuzzy has no",
        ),
        ({"asperity": "greenwood_tripp"}, "transition fuzzy has no asperity law; load_sharing has"),
        (
            {"transition": "fuzzy(foo=1)"},
            r"fuzzy\(dry, mixed, full, datum, squeeze\): unknown foo$",
        ),
        (
            {"transition": "fuzzy(dry=0.2)", "thresholds": "0.3,1,3"},
            "thresholds=0.3,1,3 and dry=0.2 .*give the same",
        ),
        (
            {"thresholds": "0.4,1,3", "memberships": ""},
            f"thresholds=0.4,1,3: {MIXED_FILE} replaces them",
        ),
        (
            {"transition": "fuzzy(dry=0.2)", "memberships": ""},
            rf"fuzzy\(dry=0.2\): beside {MIXED_FILE} it takes datum",
        ),
        (
            {"transition": "fuzzy(mixed=2)", "memberships": ""},
            rf"fuzzy\(mixed=2\): beside {MIXED_FILE} it takes datum",
        ),
        (
            {"transition": "fuzzy(datum=-1)", "memberships": ""},
            "joint B: fuzzy_table: datum must not be negative",
        ),
        (
            {"transition": "fuzzy(datum=9)", "memberships": ""},
            "transition fuzzy_table needs a datum of at most",
        ),
    ],
)
def test_nothing_given_is_ignored(options, line, tmp_path):
    """An option without effect is refused."""
    if "memberships" in options:
        path = tmp_path / "points.csv"
        path.write_text(ROWS)
        options = options | {"memberships": str(path)}
    with pytest.raises(ValueError, match=line):
        cl.load_case("six_bar_feeder", model="mixed", **options)


def test_what_auto_came_to():
    """In the scene's provenance, which files keep; a joint without oil has no viscosity."""

    def resolved(**options):
        return json.loads(cl.load_case("six_bar_feeder", **options).provenance["resolved"])

    fuzzy = {"viscosity": 0.005, "contact": "winkler", "thresholds": "0.4,1,3", "asperity": "none"}
    assert resolved(model="mixed") == fuzzy
    shared = fuzzy | {"asperity": "greenwood_tripp"}
    assert resolved(model="mixed", transition="load_sharing") == shared

    assert resolved(model="dry") == {"contact": "lankarani_nikravesh"}
    assert resolved(viscosity=0.1) == resolved(model="ideal") == {}


def test_run_says_what_auto_came_to(typed, tmp_path):
    """The command prints the value of an automatic option."""
    film = "film=pinkus_sternlicht"
    arguments = ["run six_bar_feeder -p", film, "--turns 0.01 -o", tmp_path / "run.h5"]
    printed = " ".join(typed(*arguments).out.split())
    assert "viscosity auto: 0.05 Pa s (50 cP)" in printed
    assert typed(*arguments, "--json").document["resolved"] == {"viscosity": 0.05}


def test_laws_with_parameters_are_swept():
    """Commas in brackets do not part values."""
    contact = find_case("six_bar_feeder").parameters["contact"]
    text = "hertz,impact(damping=1,depth=2e-6)"
    assert from_words(contact, text) == ["hertz", "impact(damping=1,depth=2e-6)"]


def test_texts_of_parameters_need_no_unit(tmp_path, typed):
    """A parameter that is described without a unit keeps its text."""
    case = tmp_path / "own.py"
    body = "    import clearance as cl\n    return cl.load_case('double_pendulum')\n"
    case.write_text(
        f'def scene(*, length=1.0):\n    """Own.\n\n    length: how long it is\n    """\n{body}'
    )
    assert "how long it is" in typed("cases", case).out


def test_a_case_says_how_long_it_runs_without_a_length(tmp_path):
    """UNTIL of its file where nothing turns evenly, else 2 s; two turns where something does."""

    def length(case):
        return common.length_of(SimpleNamespace(turns=None, until=None), case, case.scene())

    assert length(find_case("four_bar_clearances")) == {"turns": None, "until": 1.0}
    assert length(find_case("double_pendulum")) == {"turns": None, "until": 2.0}
    assert length(find_case("slider_crank")) == {"turns": 2.0, "until": None}
    path = tmp_path / "mine.py"
    path.write_text("UNTIL = -1.0\n" + Path(find_case("double_pendulum").path).read_text())
    with pytest.raises(ValueError, match="case mine: UNTIL must be"):
        _ = find_case(path).until


def test_samples_are_those_of_the_whole_run_where_nothing_turns_evenly():
    """There, rows per turn count for all of the run."""
    scenes = (cl.load_case(name) for name in ("double_pendulum", "slider_crank"))
    lengths = (
        (s, {"turns": None, "until": 2.0 * (s.turn or 1.0), "samples": None}) for s in scenes
    )
    counts = [span_of(s, **length, samples_per_turn=50).samples for s, length in lengths]
    assert counts == [51, 101]


@pytest.mark.parametrize("unit", ["cm", "mm", "um", "nm", "cP", "kPa", "GPa", "g", "mm3/Nm", "ms"])
def test_quantities_are_rounded_once(unit):
    """A number in a decimal unit is the float next to it, as Python reads it in SI."""
    power = round(math.log10(cl.units.UNITS[unit][1]))
    for digits in ("-10", "0.8", "118", "5.05e-4", "53.2140089972525", "7"):
        number, _, exponent = digits.partition("e")
        assert cl.units.quantity(digits + unit) == float(f"{number}e{int(exponent or 0) + power}")
    assert cl.units.quantity("300rpm") == cl.rpm(300.0)
    assert (cl.um(0.8), cl.mm(118), cl.cP(7)) == (0.8e-6, 0.118, 7e-3)
    assert (cl.mm(np.array([118.0])) == [118.0 * 1e-3]).all()


def test_values_are_shown_in_the_unit_of_the_user():
    """Any number in any unit, alone, in a range, in a list or in a distribution."""
    random = np.random.default_rng(19)
    for unit in cl.units.UNITS:
        for space in ("", " "):
            number = f"{10.0 ** random.uniform(-6, 6):.4g}"
            text = f"{number}{' ' if unit.startswith('1/') else space}{unit}"
            words = [text, f"{text}:{text}:5:log", f"1e-3,{text}", f"normal({text}, {text})"]
            assert [cl.units.unit_in(one) for one in words] == [unit] * 4
            if unit not in cl.units.ZEROS:
                value = cl.units.quantity(text)
                assert cl.units.written(value, unit, 4) == f"{float(number):.4g} {unit}"
    assert cl.units.written(cl.units.quantity("40 degC"), "degC") == "40 degC"
    assert cl.units.unit_in("1e-3:2e5:7") == ""
    assert cl.units.written(1e-3, "") == "0.001"


@pytest.mark.parametrize(
    ("text", "units", "value"),
    [
        ("1 mPa*s", "Pa s", 1e-3),
        ("3 Pa.s", "Pa s", 3.0),
        ("2 N·m", "N m", 2.0),
        ("40 °C", "K", 313.15),
        ("5 kg mm2", "kg m2", 5e-6),
        ("2 N/um", "N/m", 2e6),
        ("3 kJ", "J", 3e3),
        ("46 cSt @ 870 kg/m3", "Pa s", 46e-6 * 870.0),
        ("46 mm2/s@870kg/m3", "Pa s", 46e-6 * 870.0),
    ],
)
def test_users10_units_that_people_write(text, units, value):
    """Signs between units do not count; a kinematic viscosity has the density of its oil."""
    assert cl.units.quantity(text, units) == pytest.approx(value, rel=1e-15)


def test_users10_a_kinematic_viscosity_needs_a_density():
    """The message has the form; a lubricant takes it."""
    with pytest.raises(ValueError, match="with a density: 46cSt@870kg/m3"):
        cl.Lubricant("46 cSt")
    assert cl.Lubricant("46 cSt@870 kg/m3").viscosity == pytest.approx(0.04002, rel=1e-12)
